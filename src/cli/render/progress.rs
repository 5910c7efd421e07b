//! The progress bar.

use std::io;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use candela::image::Window;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::cli::is_steerable;

/// A run that takes longer than this shows a progress bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// How far rendering is: a bar that shows itself only when it is worth it.
pub(super) struct Progress {
    bar: ProgressBar,
    start: Instant,
    pixels: u64,
    /// When the last pixel was rendered, while the last blocks of the file are still to be written.
    end: OnceLock<Duration>,
    wanted: bool,
}

impl Progress {
    /// For a window's pixels; the bar shows itself only where it is `wanted` and stderr is a terminal
    /// that can remove it.
    pub(super) fn new(window: Window, wanted: bool) -> Self {
        let pixels = window.count();
        // As wide as the terminal, be it narrow: a line that is broken cannot be removed.
        let style = "{wide_bar} {percent:>3} %, {eta} left";
        let style = ProgressStyle::with_template(style).expect("the template is well-formed");
        let bar = ProgressBar::with_draw_target(Some(pixels), ProgressDrawTarget::hidden());
        Self {
            bar: bar.with_style(style),
            start: Instant::now(),
            pixels,
            end: OnceLock::new(),
            wanted: wanted && is_steerable(&io::stderr()),
        }
    }

    /// So many pixels more are rendered.
    pub(super) fn advance(&self, pixels: u64) {
        self.bar.inc(pixels);
        if self.wanted && self.bar.is_hidden() && self.start.elapsed() > PATIENCE {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        if self.bar.position() >= self.pixels {
            self.end.get_or_init(|| self.start.elapsed());
        }
    }

    /// Removes the bar; the seconds from the start to the last pixel.
    pub(super) fn finish(&self) -> f64 {
        self.bar.finish_and_clear();
        let end = self.end.get_or_init(|| self.start.elapsed());
        end.as_secs_f64()
    }
}
