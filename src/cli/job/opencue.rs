//! A list of commands for OpenCue's `cuecmd`: each line is a frame of its layer.

use candela::internal::shell_word;

use super::{Failure, Job};

/// One command a line. The frames of a chunk stand in its command: cuecmd's own tokens for them are wrong in the last
/// chunk (OpenCue issue 1129).
pub(super) fn list(job: &Job) -> Result<String, Failure> {
    let command = |frames: Option<&str>| {
        let mut words = vec!["candela".to_owned(), "render".to_owned(), job.scene_word()];
        words.extend(frames.map(|frames| format!("--frames={frames}")));
        words.extend(["-o".to_owned(), job.path(&job.name)]);
        words.extend(["--skip-done", "--quiet"].map(str::to_owned));
        words.extend(job.options.iter().cloned());
        let words: Vec<String> = words.iter().map(|word| shell_word(word)).collect();
        words.join(" ")
    };
    let lines = if job.frames.is_some() {
        job.chunks()
            .iter()
            .map(|chunk| command(Some(chunk)))
            .collect()
    } else {
        vec![command(None)]
    };
    if lines.iter().any(|line| line.contains(['\n', '\r'])) {
        return Err("a name or an option has a line end, which a list of commands cannot have; rename the file".into());
    }
    Ok(lines.iter().map(|line| format!("{line}\n")).collect())
}
