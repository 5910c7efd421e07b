use super::*;

fn put(path: &Path, text: &str) -> Result<(), OutputError> {
    write(path, &Unfinished::new(), |sink| {
        sink.write_all(text.as_bytes())
    })
}

/// The names in a folder.
fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn a_file_appears_and_is_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    put(&path, "one").unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "one");
    put(&path, "two").unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "two");
    assert_eq!(names(folder.path()), ["a.txt"]);
}

#[test]
fn an_error_leaves_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    put(&path, "old").unwrap();
    let error = write(&path, &Unfinished::new(), |sink| -> io::Result<()> {
        sink.write_all(&[0; 100_000])?;
        assert_eq!(names(folder.path()).len(), 2);
        Err(io::ErrorKind::StorageFull.into())
    })
    .unwrap_err();
    assert!(matches!(error.problem, OutputProblem::Full(_)), "{error}");
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(names(folder.path()), ["a.txt"]);
}

#[test]
fn an_interruption_leaves_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    put(&path, "old").unwrap();
    let unfinished = Unfinished::new();
    let handler = unfinished.clone();
    let error = write(&path, &unfinished, |sink| {
        sink.write_all(b"new")?;
        sink.flush()?;
        handler.cancel();
        assert_eq!(names(folder.path()), ["a.txt"]);
        Ok(())
    })
    .unwrap_err();
    assert!(matches!(error.problem, OutputProblem::Canceled), "{error}");
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(names(folder.path()), ["a.txt"]);

    let error = write(&path, &unfinished, |_| Ok(())).unwrap_err();
    assert!(matches!(error.problem, OutputProblem::Canceled), "{error}");
}

#[test]
fn places_that_cannot_be_written_to() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    put(&file, "").unwrap();
    let problem = |path: &Path| put(path, "x").unwrap_err().problem;

    assert!(matches!(
        problem(&folder.path().join("none").join("a.txt")),
        OutputProblem::MissingFolder(missing) if missing.ends_with("none")
    ));
    assert!(matches!(
        problem(&file.join("a.txt")),
        OutputProblem::NotAFolder(not) if not.ends_with("file")
    ));
    assert!(matches!(problem(folder.path()), OutputProblem::IsFolder));
    assert!(matches!(
        problem(&folder.path().join("new/")),
        OutputProblem::IsFolder
    ));
    for name in ["..", ".", "new/.", "new/./", "new/.."] {
        assert!(matches!(problem(Path::new(name)), OutputProblem::IsFolder));
    }
    assert!(matches!(problem(Path::new("")), OutputProblem::NoName));
    assert_eq!(
        put(Path::new(""), "x").unwrap_err().to_string(),
        "cannot write an output: the file name is empty; give one"
    );
    assert_eq!(names(folder.path()), ["file"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_nobody_can_write_to() {
    // /proc refuses new files to the superuser as well.
    let error = put(Path::new("/proc/a.txt"), "x").unwrap_err();
    // The name of the unfinished file is of no use to anybody.
    assert!(!error.to_string().contains(".candela-"), "{error}");
    assert!(
        matches!(&error.problem, OutputProblem::ClosedFolder { folder, .. } if folder == Path::new("/proc")),
        "{error}"
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_write_protected_file_stays() {
    // Kernel parameters such as this one are protected from the superuser as well.
    let error = put(Path::new("/proc/version"), "x").unwrap_err();
    assert!(
        matches!(
            error.problem,
            OutputProblem::Protected(_) | OutputProblem::ClosedFolder { .. }
        ),
        "{error}"
    );
}

#[cfg(target_os = "linux")]
#[test]
fn devices_are_written_to_and_stay_devices() {
    use std::os::unix::fs::FileTypeExt;
    put(Path::new("/dev/null"), "x").unwrap();
    let metadata = fs::symlink_metadata("/dev/null").unwrap();
    assert!(metadata.file_type().is_char_device());

    let error = put(Path::new("/dev/full"), "x").unwrap_err();
    assert!(matches!(error.problem, OutputProblem::Full(_)), "{error}");
}

#[cfg(unix)]
#[test]
fn links_are_followed() {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("sub")).unwrap();
    symlink("sub/real.txt", at("second")).unwrap();
    symlink("second", at("first")).unwrap();
    // First where the last link dangles, then where its file is there.
    for text in ["one", "two"] {
        put(&at("first"), text).unwrap();
        assert_eq!(fs::read_to_string(at("sub/real.txt")).unwrap(), text);
        assert!(fs::symlink_metadata(at("first")).unwrap().is_symlink());
        assert!(fs::symlink_metadata(at("second")).unwrap().is_symlink());
    }

    symlink("circle", at("circle")).unwrap();
    let error = put(&at("circle"), "x").unwrap_err();
    assert!(matches!(error.problem, OutputProblem::LinkLoop), "{error}");
}

#[cfg(unix)]
#[test]
fn permissions_are_those_of_any_file() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o7777;
    let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
    put(&ours, "x").unwrap();
    fs::write(&plain, "x").unwrap();
    assert_eq!(mode(&ours), mode(&plain));

    fs::set_permissions(&ours, Permissions::from_mode(0o640)).unwrap();
    put(&ours, "y").unwrap();
    assert_eq!(mode(&ours), 0o640);
}

#[test]
fn what_is_no_file_is_not_replaced() {
    #[cfg(unix)]
    {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("socket");
        let _socket = std::os::unix::net::UnixListener::bind(&path).unwrap();
        for problem in [
            put(&path, "x").unwrap_err().problem,
            check(&path).unwrap_err().problem,
        ] {
            assert!(
                matches!(problem, OutputProblem::NotAFile("a socket")),
                "{problem}"
            );
        }
        assert_eq!(names(folder.path()), ["socket"]);
    }
}

#[test]
fn a_name_that_is_too_long_is_known_before() {
    let folder = tempfile::tempdir().unwrap();
    let long = "a".repeat(300);
    let error = check(&folder.path().join(long)).unwrap_err();
    assert!(
        matches!(error.problem, OutputProblem::NameTooLong(_)),
        "{error}"
    );
    // The longest that there can be, whose unfinished file needs a name as well.
    let longest = folder.path().join("ü".repeat(127));
    put(&longest, "x").unwrap();
    assert_eq!(fs::read_to_string(&longest).unwrap(), "x");
}

#[test]
fn each_problem_has_its_own_way_out() {
    use io::ErrorKind;
    for (kind, part, is_transient) in [
        (ErrorKind::StorageFull, "free some space", true),
        (ErrorKind::QuotaExceeded, "quota", true),
        (ErrorKind::FileTooLarge, "file size limit", true),
        (ErrorKind::TimedOut, "try again", true),
        (ErrorKind::StaleNetworkFileHandle, "try again", true),
        (ErrorKind::ReadOnlyFilesystem, "on another one", false),
        (ErrorKind::InvalidFilename, "choose a shorter one", false),
        (ErrorKind::IsADirectory, "add a file name", false),
        (ErrorKind::PermissionDenied, "permission denied", false),
    ] {
        let error = OutputError::new(Path::new("a.exr"), kind.into());
        assert!(error.to_string().contains(part), "{error}");
        assert_eq!(error.is_transient(), is_transient, "{error}");
    }
    // EIO and EMFILE have no kinds.
    #[cfg(unix)]
    for code in [5, 24] {
        let error = OutputError::new(Path::new("a.exr"), io::Error::from_raw_os_error(code));
        assert!(error.is_transient(), "{error}");
    }
}

#[cfg(unix)]
#[test]
fn what_a_killed_run_has_left_is_removed_by_the_next() {
    let folder = tempfile::tempdir().unwrap();
    let (ours, other) = (folder.path().join("a.txt"), folder.path().join("b.txt"));
    let mut seen = Vec::new();
    // While a run lives, it keeps its file from another run to the same target.
    write(&ours, &Unfinished::new(), |_| {
        seen = names(folder.path());
        put(&ours, "another run").unwrap();
        assert!(folder.path().join(&seen[0]).exists(), "{seen:?}");
        Ok(())
    })
    .unwrap();
    // A file of that name that nobody has locked is what a killed run leaves.
    let left = folder.path().join(&seen[0]);
    assert!(seen[0].starts_with(".candela-a.txt-") && seen[0].ends_with(".tmp"));
    fs::write(&left, "half").unwrap();
    // Of another host, of a file that nobody could lock, and what only looks alike: they stay.
    let host = seen[0].strip_prefix(".candela-a.txt-").unwrap();
    let kept = [
        format!(".candela-a.txt-elsewhere-{host}"),
        seen[0].replace(".tmp", ".unlocked.tmp"),
        seen[0].replace(".candela-a.txt-", ".candela-a.txt-b-"),
        ".candela-mine.tmp".to_owned(),
    ];
    for name in &kept {
        fs::write(folder.path().join(name), "").unwrap();
    }
    put(&other, "x").unwrap();
    assert!(left.exists());
    put(&ours, "x").unwrap();
    assert!(!left.exists());
    for name in &kept {
        assert!(folder.path().join(name).exists(), "{name}");
    }
}

#[cfg(unix)]
#[test]
fn an_unfinished_file_that_is_removed_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    let error = write(&path, &Unfinished::new(), |_| {
        let unfinished = folder.path().join(&names(folder.path())[0]);
        fs::remove_file(unfinished)
    })
    .unwrap_err();
    assert!(
        matches!(error.problem, OutputProblem::Removed(_)) && error.is_transient(),
        "{error}"
    );
    assert_eq!(names(folder.path()), [""; 0]);

    let inner = folder.path().join("sub");
    fs::create_dir(&inner).unwrap();
    let error = write(&inner.join("a.txt"), &Unfinished::new(), |_| {
        fs::remove_dir_all(&inner)
    })
    .unwrap_err();
    assert!(
        matches!(error.problem, OutputProblem::MissingFolder(_)),
        "{error}"
    );
}

#[cfg(unix)]
#[test]
fn a_target_that_goes_while_it_is_written_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    put(&path, "old").unwrap();
    write(&path, &Unfinished::new(), |sink| {
        fs::remove_file(&path)?;
        sink.write_all(b"new")
    })
    .unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "new");
    // And one that has become a folder stays it.
    let error = write(&path, &Unfinished::new(), |_| {
        fs::remove_file(&path)?;
        fs::create_dir(&path)
    })
    .unwrap_err();
    assert!(matches!(error.problem, OutputProblem::IsFolder), "{error}");
    assert_eq!(names(folder.path()), ["a.txt"]);
}

#[test]
fn names_of_one_place_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let is = |a: &str, b: &str| Place::of_output(&at(a)).is(&Place::of_output(&at(b)));
    fs::create_dir(at("sub")).unwrap();
    for (a, b) in [("new", "new"), ("new", "./new"), ("new", "sub/../new")] {
        assert!(is(a, b), "{a} {b}");
    }
    for (a, b) in [
        ("new", "other"),
        ("new", "sub/new"),
        ("none/new", "none/new2"),
    ] {
        assert!(!is(a, b), "{a} {b}");
    }
    fs::write(at("there"), "").unwrap();
    assert!(is("there", "sub/../there"));
    assert!(!is("there", "new"));
    assert!(Place::of_input(&at("there")).is(&Place::of_output(&at("there"))));
    // An input that is not there cannot be lost.
    assert!(!Place::of_input(&at("new")).is(&Place::of_output(&at("new"))));
}

#[cfg(unix)]
#[test]
fn links_to_one_place_are_told() {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let is = |a: &str, b: &str| Place::of_output(&at(a)).is(&Place::of_output(&at(b)));
    fs::create_dir(at("sub")).unwrap();
    symlink("sub", at("way")).unwrap();
    symlink("sub/new", at("dangling")).unwrap();
    symlink("dangling", at("chain")).unwrap();
    symlink(at("way/new"), at("absolute")).unwrap();
    for (a, b) in [
        ("sub/new", "way/new"),
        ("sub/new", "dangling"),
        ("way/new", "chain"),
        ("absolute", "chain"),
    ] {
        assert!(is(a, b) && is(b, a), "{a} {b}");
    }
    assert!(!is("new", "dangling"));
    fs::write(at("there"), "").unwrap();
    fs::hard_link(at("there"), at("hard")).unwrap();
    assert!(is("there", "hard"));
    // A pipe cannot take two files one after the other, a device that throws away can.
    assert!(
        !Place::of_output(Path::new("/dev/null")).is(&Place::of_output(Path::new("/dev/null")))
    );
    assert!(Place::of_output(Path::new("-")).is(&Place::of_output(Path::new("/dev/stdout"))));
}

/// A file system is asked whether it tells names apart, and nothing of that stays.
#[test]
fn names_that_differ_by_case_are_one_where_the_file_system_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("probe"), "").unwrap();
    let folds = at("PROBE").exists();
    let (lower, upper) = (Place::of_output(&at("new")), Place::of_output(&at("NEW")));
    assert_eq!(lower.is(&upper), folds);
    assert_eq!(names(folder.path()), ["probe"]);
}
