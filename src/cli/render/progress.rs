//! How far a render is: a bar on a terminal, lines for another program.

use std::io::{self, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::cli::is_steerable;

/// A run that takes longer than this shows a progress bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// There is at most one line in this time, before the last one.
const PAUSE: Duration = Duration::from_secs(1);

/// Whom lines are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Lines {
    /// Open Job Description: `openjd_progress: 42.0`
    Openjd,
    /// Tractor, Deadline 10 and others: `ALF_PROGRESS 42%`
    Alfred,
    /// `{"progress": 0.42, "frame": 12, "done": 11, "frames": 100}`
    Json,
}

impl Lines {
    /// What is said of a part of all work, from 0 to 1.
    fn line(self, part: f64, frame: Option<&str>, done: u64, frames: u64) -> String {
        match self {
            Self::Openjd => format!("openjd_progress: {:.1}", 100.0 * part),
            Self::Alfred => format!("ALF_PROGRESS {:.0}%", (100.0 * part).floor()),
            Self::Json => {
                let frame = frame.unwrap_or("null");
                format!(
                    "{{\"progress\": {part:.4}, \"frame\": {frame}, \"done\": {done}, \"frames\": {frames}}}"
                )
            }
        }
    }
}

/// How far all frames are.
pub(super) struct Progress {
    bar: ProgressBar,
    start: Instant,
    /// Of each frame.
    pixels: u64,
    frames: u64,
    wanted: bool,
    lines: Option<Lines>,
    /// Whether standard output is taken.
    to_stderr: bool,
    told: Mutex<Told>,
}

/// What was said last.
#[derive(Default)]
struct Told {
    last: Option<Instant>,
    frame: Option<String>,
    has_ended: bool,
}

/// How far one frame is.
pub(super) struct FrameProgress<'p> {
    progress: &'p Progress,
    start: Instant,
    rendered: AtomicU64,
    /// When the last pixel was rendered, while the last blocks of the file are still to be written.
    end: OnceLock<Duration>,
}

impl Progress {
    /// For so many frames of so many pixels. The bar shows itself only where it is `wanted` and stderr is a terminal
    /// that can remove it. Lines go to standard output, or to stderr where that is taken.
    pub(super) fn new(
        frames: usize,
        pixels: u64,
        wanted: bool,
        lines: Option<Lines>,
        to_stderr: bool,
    ) -> Self {
        let frames = frames as u64;
        // As wide as the terminal, be it narrow: a line that is broken cannot be removed.
        let style = "{wide_bar} {percent:>3} %, {eta} left";
        let style = ProgressStyle::with_template(style).expect("the template is well-formed");
        let all = pixels.saturating_mul(frames);
        let bar = ProgressBar::with_draw_target(Some(all), ProgressDrawTarget::hidden());
        Self {
            bar: bar.with_style(style),
            start: Instant::now(),
            pixels,
            frames,
            wanted: wanted && is_steerable(&io::stderr()),
            lines,
            to_stderr,
            told: Mutex::default(),
        }
    }

    /// A frame begins.
    pub(super) fn begin(&self, frame: Option<String>) -> FrameProgress<'_> {
        self.told().frame = frame;
        FrameProgress {
            progress: self,
            start: Instant::now(),
            rendered: AtomicU64::new(0),
            end: OnceLock::new(),
        }
    }

    /// A frame is there already.
    pub(super) fn skip(&self) {
        self.advance(self.pixels);
    }

    /// Writes a text past the bar.
    pub(super) fn print(&self, text: impl FnOnce(&mut dyn Write) -> io::Result<()>) {
        self.bar.suspend(|| {
            // Nowhere is left to report that the messages themselves cannot be written.
            let _ = text(&mut io::stderr().lock());
        });
    }

    /// Removes the bar, and says that all is done.
    pub(super) fn finish(&self) {
        self.bar.finish_and_clear();
        let mut told = self.told();
        if !told.has_ended {
            self.tell(&mut told, 1.0);
        }
    }

    fn advance(&self, pixels: u64) {
        self.bar.inc(pixels);
        if self.wanted && self.bar.is_hidden() && self.start.elapsed() > PATIENCE {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        if self.lines.is_none() {
            return;
        }
        let mut told = self.told();
        let is_due = told.last.unwrap_or(self.start).elapsed() >= PAUSE;
        if is_due {
            let all = self.pixels.saturating_mul(self.frames).max(1);
            let part = self.bar.position() as f64 / all as f64;
            // The end is said when all files have their names.
            self.tell(&mut told, part.min(0.9999));
        }
    }

    /// Writes a line. Whoever does not read it any more misses nothing but that.
    fn tell(&self, told: &mut Told, part: f64) {
        let Some(lines) = self.lines else {
            return;
        };
        told.last = Some(Instant::now());
        told.has_ended = part >= 1.0;
        let done = if told.has_ended {
            self.frames
        } else {
            self.bar.position() / self.pixels.max(1)
        };
        let line = lines.line(part, told.frame.as_deref(), done, self.frames);
        if self.to_stderr {
            let mut stream = io::stderr().lock();
            let _ = writeln!(stream, "{line}").and_then(|()| stream.flush());
        } else {
            let mut stream = io::stdout().lock();
            let _ = writeln!(stream, "{line}").and_then(|()| stream.flush());
        }
    }

    /// What was told stays so, even if another thread panicked meanwhile.
    fn told(&self) -> std::sync::MutexGuard<'_, Told> {
        self.told.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl FrameProgress<'_> {
    /// So many pixels more are rendered.
    pub(super) fn advance(&self, pixels: u64) {
        self.progress.advance(pixels);
        let rendered = self.rendered.fetch_add(pixels, Ordering::Relaxed) + pixels;
        if rendered >= self.progress.pixels {
            self.end.get_or_init(|| self.start.elapsed());
        }
    }

    /// The seconds from the start to the last pixel.
    pub(super) fn seconds(&self) -> f64 {
        let end = self.end.get_or_init(|| self.start.elapsed());
        end.as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_those_of_their_readers() {
        let line = |lines: Lines, part| lines.line(part, Some("12.5"), 11, 100);
        assert_eq!(line(Lines::Openjd, 0.4251), "openjd_progress: 42.5");
        assert_eq!(line(Lines::Openjd, 1.0), "openjd_progress: 100.0");
        assert_eq!(line(Lines::Alfred, 0.4299), "ALF_PROGRESS 42%");
        assert_eq!(line(Lines::Alfred, 1.0), "ALF_PROGRESS 100%");
        let json: serde_json::Value = serde_json::from_str(&line(Lines::Json, 0.42)).unwrap();
        assert_eq!(
            json,
            serde_json::json!({"progress": 0.42, "frame": 12.5, "done": 11, "frames": 100})
        );
        let still = Lines::Json.line(1.0, None, 1, 1);
        let json: serde_json::Value = serde_json::from_str(&still).unwrap();
        assert_eq!(json["frame"], serde_json::Value::Null);
    }
}
