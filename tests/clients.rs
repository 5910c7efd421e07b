//! OpenImageIO, the OpenEXR project's Python package and a reader of Cryptomattes as judges of layers.

use std::path::Path;
use std::process::Command;

use crate::conformance::printed;

/// The script prints a line for each fact, and fails where one does not hold.
#[test]
fn layers_are_read_by_other_programs() {
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/clients/bin/python");
    if !python.exists() {
        println!(
            "skipped: {} is missing; ./check installs it",
            python.display()
        );
        return;
    }
    let output = Command::new(python)
        .args([
            "reference/clients/readable.py",
            env!("CARGO_BIN_EXE_candela"),
        ])
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .unwrap();
    println!("{}", printed(&output));
    assert!(output.status.success(), "{}", printed(&output));
}
