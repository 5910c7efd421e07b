//! What the program says of itself: help, and completions for shells.

use std::fs;
use std::process::Command;

use super::{COMMANDS, folder, succeeds};

#[test]
fn help_has_examples() {
    let folder = folder();
    for command in COMMANDS.into_iter().chain([""]) {
        let help = succeeds(folder.path(), &format!("{command} --help"));
        assert!(help.contains("Example"), "{help}");
        assert!(help.contains(&format!("  candela {command}")), "{help}");
        assert!(help.contains("Usage: candela"), "{help}");
    }
    let version = succeeds(folder.path(), "--version");
    assert_eq!(version, format!("candela {}\n", env!("CARGO_PKG_VERSION")));
}

/// Of examples in the help, at least those of the commands themselves name options that are there.
#[test]
fn options_of_examples_exist() {
    let folder = folder();
    for command in COMMANDS {
        let help = succeeds(folder.path(), &format!("{command} --help"));
        let (options, examples) = help.split_once("Example").unwrap();
        for word in examples
            .split_whitespace()
            .filter(|word| word.starts_with("--"))
        {
            let (option, _) = word.split_once('=').unwrap_or((word, ""));
            assert!(options.contains(option), "candela {command} has no {word}");
        }
    }
}

#[test]
fn completions_for_every_shell() {
    let folder = folder();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = succeeds(folder.path(), &format!("completions {shell}"));
        for command in COMMANDS {
            assert!(script.contains(command), "{shell}: {command}");
        }
        assert!(
            script.contains("samples") && script.contains("compression"),
            "{shell}"
        );
    }
    // A script that bash takes.
    fs::write(
        folder.path().join("script"),
        succeeds(folder.path(), "completions bash"),
    )
    .unwrap();
    let mut bash = Command::new("bash");
    match bash.arg("-n").arg(folder.path().join("script")).status() {
        Ok(status) => assert!(status.success()),
        Err(error) => println!("bash is not here ({error}): its script is not tried"),
    }
}
