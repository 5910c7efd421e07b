//! What ends a run early: signals, and readers that have seen enough.

use std::fs;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use super::{SCENE, candela, files, folder, text};

/// Waits for a child; kills it, and fails, if it takes longer than `patience`.
fn wait(child: &mut Child, patience: Duration) -> ExitStatus {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return status;
        }
        if start.elapsed() > patience {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("still runs after {patience:?}");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Makes children heed the signals that end a run, also where this process was started to ignore some, as
/// `nohup` and a shell's `&` do: what is caught here is at its default in a program that is started.
#[cfg(unix)]
fn heed_signals_in_children() {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGUSR1, SIGXCPU};
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| {
        let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
        let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
        for signal in [SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGUSR1, SIGXCPU] {
            // This process does what it did before.
            let is_ignored = mask.unwrap_or(0) & (1 << (signal - 1)) != 0;
            let is_heeded = Arc::new(AtomicBool::new(!is_ignored));
            signal_hook::flag::register_conditional_default(signal, is_heeded).unwrap();
        }
    });
}

/// Until the program has its signal handler, a thread, and the two that render beside it.
fn wait_for_threads(child: &Child) {
    let tasks = format!("/proc/{}/task", child.id());
    for _ in 0..500 {
        std::thread::sleep(Duration::from_millis(10));
        let Ok(entries) = fs::read_dir(&tasks) else {
            // Not Linux: a second is enough.
            return std::thread::sleep(Duration::from_secs(1));
        };
        if entries.count() >= 4 {
            return;
        }
    }
    panic!("the threads do not start");
}

#[test]
fn an_interruption_leaves_nothing() {
    heed_signals_in_children();
    let outputs = tempfile::tempdir().unwrap();
    let scenes = folder();
    let scene = scenes.path().join("ball.toml");
    let large = SCENE.replace("[60, 40]", "[4000, 4000]");
    fs::write(&scene, large).unwrap();
    for (signal, code) in [
        ("-INT", 130),
        ("-TERM", 143),
        ("-HUP", 129),
        ("-QUIT", 131),
        ("-USR1", 138),
        ("-XCPU", 152),
    ] {
        // Their numbers are other ones elsewhere.
        if ["-USR1", "-XCPU"].contains(&signal) && !cfg!(target_os = "linux") {
            continue;
        }
        let mut child = candela(
            outputs.path(),
            "render --samples 4096 --threads 2 -o long.exr",
        )
        .arg(&scene)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
        wait_for_threads(&child);
        let kill = Command::new("kill")
            .arg(signal)
            .arg(child.id().to_string())
            .status();
        assert!(kill.unwrap().success());
        let status = wait(&mut child, Duration::from_secs(20));
        assert_eq!(status.code(), Some(code), "{signal}");
        assert_eq!(files(outputs.path()), [""; 0]);
    }
}

/// These tests hold as well where they are run with signals ignored.
#[cfg(unix)]
#[test]
fn tests_of_signals_do_not_inherit_ignored_ones() {
    let test = "cli::interruption::an_ignored_signal_stays_ignored";
    let output = Command::new("sh")
        .args(["-c", "trap '' INT QUIT HUP TERM; exec \"$@\"", "sh"])
        .arg(std::env::current_exe().unwrap())
        .args(["--exact", test])
        .output()
        .unwrap();
    let report = text(&output.stdout);
    assert!(
        output.status.success() && report.contains("1 passed"),
        "{report}"
    );
}

/// `nohup` starts a program with SIGHUP ignored, so that a closed terminal does not end it.
#[test]
fn an_ignored_signal_stays_ignored() {
    heed_signals_in_children();
    let outputs = tempfile::tempdir().unwrap();
    let scenes = folder();
    let scene = scenes.path().join("ball.toml");
    fs::write(&scene, SCENE.replace("[60, 40]", "[4000, 4000]")).unwrap();
    let mut child = Command::new("sh")
        .current_dir(outputs.path())
        .args([
            "-c",
            "trap '' HUP; exec \"$@\"",
            "sh",
            env!("CARGO_BIN_EXE_candela"),
        ])
        .args([
            "render",
            "--samples",
            "4096",
            "--threads",
            "2",
            "-o",
            "long.exr",
        ])
        .arg(&scene)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    wait_for_threads(&child);
    let kill = |signal: &str| {
        let id = child.id().to_string();
        assert!(
            Command::new("kill")
                .arg(signal)
                .arg(id)
                .status()
                .unwrap()
                .success()
        );
    };
    kill("-HUP");
    std::thread::sleep(Duration::from_millis(300));
    kill("-INT");
    // Had SIGHUP been heeded, the code would be 129.
    let status = wait(&mut child, Duration::from_secs(20));
    assert_eq!(status.code(), Some(130));
}

/// A file that may not grow, as on a full disk, in the middle of rendering: an error, and the old file
/// stays.
#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_is_full_in_the_middle_leaves_the_old_file() {
    let folder = folder();
    let scene = folder.path().join("ball.toml");
    fs::write(&scene, SCENE.replace("[60, 40]", "[600, 400]")).unwrap();
    fs::write(folder.path().join("out.exr"), "old").unwrap();
    // At most 512 kB.
    let limited = "ulimit -f 1000; exec \"$0\" render ball.toml -o out.exr \
                   --compression none --quiet";
    let output = Command::new("sh")
        .current_dir(folder.path())
        .args(["-c", limited, env!("CARGO_BIN_EXE_candela")])
        .output()
        .unwrap();
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(75), "{message}");
    assert!(
        message.starts_with("error: cannot write out.exr: "),
        "{message}"
    );
    assert_eq!(message.lines().count(), 1, "{message}");
    assert_eq!(files(folder.path()), ["ball.toml", "out.exr"]);
    let old = fs::read_to_string(folder.path().join("out.exr")).unwrap();
    assert_eq!(old, "old");
    // A device that is full, which gets the whole file at once.
    let output = candela(folder.path(), "render ball.toml -o /dev/full --quiet").output();
    let output = output.unwrap();
    assert_eq!(output.status.code(), Some(75));
    let message = text(&output.stderr);
    assert!(message.contains("the disk is full"), "{message}");
}

/// As in `candela check scene.toml | head -1`: a reader that has seen enough is no error.
#[test]
fn a_closed_pipe_is_no_error() {
    let folder = folder();
    for arguments in [
        "check ball.toml",
        "probe ball.toml --pixel 30,20",
        "probe ball.toml --pixel 30,20 --json",
        "completions bash",
    ] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = candela(folder.path(), arguments)
            .stdout(writer)
            .output()
            .unwrap();
        assert_eq!(text(&output.stderr), "", "{arguments}");
        assert!(output.status.success(), "{arguments}");
    }
}
