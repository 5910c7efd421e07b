//! What is being measured, on a terminal: a sweep takes a minute or more.

use std::io;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::cli::is_steerable;

/// A bar of the pictures that are rendered; nothing where stderr is no terminal that can remove it.
pub(super) struct Progress(ProgressBar);

impl Progress {
    /// Of so many pictures.
    pub(super) fn new(pictures: usize) -> Self {
        let target = if is_steerable(&io::stderr()) {
            ProgressDrawTarget::stderr()
        } else {
            ProgressDrawTarget::hidden()
        };
        let style = ProgressStyle::with_template("{wide_bar} {pos} of {len}, {msg}");
        let style = style.expect("the template is well-formed");
        let bar = ProgressBar::with_draw_target(Some(pictures as u64), target);
        Self(bar.with_style(style))
    }

    /// What comes now.
    pub(super) fn begin(&self, picture: String) {
        self.0.set_message(picture);
    }

    /// It is done.
    pub(super) fn end(&self) {
        self.0.inc(1);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
