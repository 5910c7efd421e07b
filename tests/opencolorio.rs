//! OpenColorIO as the judge of views.

use std::path::Path;
use std::process::Command;

use crate::conformance::printed;

/// The script compares more than 100 000 colors in code value, and has a limit for each view.
#[test]
fn views_are_those_of_opencolorio() {
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/opencolorio/bin/python");
    if !python.exists() {
        println!(
            "skipped: {} is missing; ./check installs it",
            python.display()
        );
        return;
    }
    let output = Command::new(python)
        .args(["reference/display/ocio.py", env!("CARGO_BIN_EXE_candela")])
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .unwrap();
    println!("{}", printed(&output));
    assert!(output.status.success(), "{}", printed(&output));
}
