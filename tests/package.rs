//! What `cargo package` puts into the tarball: all that the build reads, and not the repository's tests.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

/// More files than this are more than the sources and what their user reads.
const MOST: usize = 700;

fn packaged() -> BTreeSet<PathBuf> {
    let output = Command::new(env!("CARGO"))
        .args(["package", "--list", "--allow-dirty", "--offline", "--quiet"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let list = String::from_utf8(output.stdout).unwrap();
    list.lines().map(PathBuf::from).collect()
}

/// Rust files below a folder.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// The file that a path with `..` in it names.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        if part.as_os_str() == ".." {
            plain.pop();
        } else {
            plain.push(part);
        }
    }
    plain
}

#[test]
fn the_package_holds_what_the_build_reads() {
    let packaged = packaged();
    assert!(packaged.len() < MOST, "{} files", packaged.len());
    let mut files = Vec::new();
    sources(Path::new("src"), &mut files);
    let mut included = 0;
    for file in &files {
        assert!(packaged.contains(file), "{}", file.display());
        let text = std::fs::read_to_string(file).unwrap();
        for (start, word) in text.match_indices("include_str!(\"") {
            let path = text[start + word.len()..].split('"').next().unwrap();
            let path = plain(&file.parent().unwrap().join(path));
            assert!(packaged.contains(&path), "{}", path.display());
            included += 1;
        }
    }
    assert!(included >= 2, "{included}");
    // Tables whose names a macro puts together.
    for entry in std::fs::read_dir("src/spectrum/data").unwrap() {
        let path = entry.unwrap().path();
        assert!(packaged.contains(&path), "{}", path.display());
    }
    for file in [
        "Cargo.lock",
        "README.md",
        "LICENSE-MIT",
        "LICENSE-APACHE",
        "CHANGELOG.md",
        "docs/scene-format.md",
        "schema/candela.schema.json",
        "examples/scene_in_code.rs",
    ] {
        assert!(packaged.contains(Path::new(file)), "{file}");
    }
    let is_left_out = |path: &&PathBuf| {
        let in_docs = path.starts_with("docs") && path.extension().is_none_or(|end| end != "md");
        let of_tests = path.starts_with("tests") && path.extension().is_some_and(|end| end == "rs");
        in_docs || of_tests || path.starts_with("benches")
    };
    assert_eq!(packaged.iter().find(is_left_out), None);
}
