//! How many frames make a task, and their numbers as text.

use candela::internal::counted;

use crate::cli::frames::{Frame, Frames};

/// Seconds that a task should take at most: some minutes, in which starting it, reading the scene and building its tree
/// – seconds, in a cloud – do not count, and after which a task that was lost is soon done again.
const TASK_SECONDS: f64 = 300.0;

/// Frames that a task may have. Rounded so that a measurement that is a little off gives the same job. AWS Deadline
/// Cloud takes at most 150.
const SIZES: [usize; 7] = [1, 2, 5, 10, 25, 50, 100];

/// Frames of a task where nothing is known of them.
const UNKNOWN: usize = 25;

/// What a frame takes, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Cost {
    /// It does not matter here.
    Unknown,
    /// By --seconds-per-frame.
    Stated(f64),
    /// Of parts of the first frame.
    Measured(f64),
}

impl Cost {
    /// A sentence about a task of so many of all frames.
    pub(super) fn remark(self, frames: usize, chunk: usize) -> String {
        let tasks = frames.div_ceil(chunk);
        let parted = format!(
            "{} in {} of at most {chunk}",
            counted(frames, "frame", "frames"),
            counted(tasks, "task", "tasks"),
        );
        match self {
            Self::Unknown => format!("{parted}."),
            Self::Stated(seconds) => format!("{parted}: --seconds-per-frame {seconds}."),
            Self::Measured(seconds) => {
                format!(
                    "{parted}: the first frame takes about {} s here.",
                    rounded(seconds)
                )
            }
        }
    }
}

/// How many frames make a task: the most of [`SIZES`] that take [`TASK_SECONDS`], and at least one.
pub(super) fn chunk_size(cost: Cost) -> usize {
    let seconds = match cost {
        Cost::Unknown => return UNKNOWN,
        Cost::Stated(seconds) | Cost::Measured(seconds) => seconds,
    };
    let fit = SIZES
        .iter()
        .rev()
        .find(|&&size| size as f64 * seconds <= TASK_SECONDS);
    fit.copied().unwrap_or(1)
}

/// To the nearest of 1, 2, 5, 10, … by ratio.
fn rounded(seconds: f64) -> String {
    // A frame of less is one of none.
    let seconds = seconds.max(1e-3);
    let power = 10_f64.powf(seconds.log10().floor());
    let first = seconds / power;
    // The geometric means of 1, 2, 5 and 10.
    let digit = if first < 2_f64.sqrt() {
        1.0
    } else if first < 10_f64.sqrt() {
        2.0
    } else if first < 50_f64.sqrt() {
        5.0
    } else {
        10.0
    };
    let rounded = digit * power;
    if rounded < 1.0 {
        let text = format!("{rounded:.4}");
        text.trim_end_matches('0').to_owned()
    } else {
        format!("{rounded:.0}")
    }
}

/// Frames as `--frames` takes them.
pub(super) fn text(frames: &Frames) -> String {
    text_of(frames.list())
}

/// Frames as `--frames` and Open Job Description take them: runs of equal steps, `1-9:2,20`.
pub(super) fn text_of(frames: &[Frame]) -> String {
    let mut parts = Vec::new();
    let mut rest = frames;
    while let [first, after @ ..] = rest {
        let step = after.first().map(|second| second.after(*first));
        let mut count = 1;
        while count < rest.len() && Some(rest[count].after(rest[count - 1])) == step {
            count += 1;
        }
        let last = rest[count - 1];
        match step {
            Some(step) if count > 2 || step == Frame::ONE && count > 1 => {
                let by = if step == Frame::ONE {
                    String::new()
                } else {
                    format!(":{step}")
                };
                parts.push(format!("{first}-{last}{by}"));
            }
            Some(_) | None => {
                parts.push(first.to_string());
                count = 1;
            }
        }
        rest = &rest[count..];
    }
    parts.join(",")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::frames::frames;

    #[test]
    fn frames_are_read_as_they_are_written() {
        for (list, expected) in [
            ("1-100", "1-100"),
            ("1-100x2", "1-99:2"),
            ("1,5,9-12", "1-9:4,10-12"),
            ("7", "7"),
            ("1,2", "1-2"),
            ("1,4", "1,4"),
            ("3-1:-1", "3-1:-1"),
            ("-3-2", "-3-2"),
            ("0-1:0.25,7.5", "0-1:0.25,7.5"),
        ] {
            let read = frames(list).unwrap();
            assert_eq!(text(&read), expected);
            assert_eq!(frames(expected).unwrap(), read);
        }
    }

    #[test]
    fn tasks_take_some_minutes() {
        for (seconds, size) in [
            (0.001, 100),
            (3.0, 100),
            (3.1, 50),
            (12.0, 25),
            (13.0, 10),
            (300.0, 1),
            (1e6, 1),
        ] {
            assert_eq!(chunk_size(Cost::Stated(seconds)), size, "{seconds}");
        }
        assert_eq!(chunk_size(Cost::Unknown), 25);
    }

    #[test]
    fn measured_seconds_are_1_2_5() {
        for (seconds, text) in [
            (0.0, "0.001"),
            (0.0123, "0.01"),
            (0.31, "0.2"),
            (0.33, "0.5"),
            (0.99, "1"),
            (1.4, "1"),
            (7.2, "10"),
            (640.0, "500"),
        ] {
            assert_eq!(rounded(seconds), text, "{seconds}");
        }
    }
}
