//! What a point of the sweep is rendered with.

use candela::render::{ErrorTarget, Layers, MAX_SAMPLES, Options};

use super::table::digits;
use crate::cli::render::max_error;

/// What a point of the sweep is rendered with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Setting {
    /// So many samples in each pixel.
    Samples(u32),
    /// As exact as this, relative to each pixel.
    Target(f64),
}

impl Setting {
    /// The options that render it.
    pub(super) fn options(self) -> Options {
        match self {
            Self::Samples(samples) => Options {
                samples,
                ..Options::default()
            },
            Self::Target(relative) => Options {
                target: Some(ErrorTarget::new(relative)),
                ..Options::default()
            },
        }
    }

    /// The options that also say how many samples each pixel took.
    pub(super) fn with_samples(self) -> Options {
        Options {
            layers: Layers {
                samples: true,
                ..Layers::default()
            },
            ..self.options()
        }
    }

    /// What the errors of its pixels are to be at most.
    pub(super) fn target(self) -> Option<f64> {
        match self {
            Self::Samples(_) => None,
            Self::Target(relative) => Some(relative),
        }
    }

    /// The name of the curve that it is a point of.
    pub(super) fn series(self) -> String {
        match self {
            Self::Samples(_) => "candela, N samples".to_owned(),
            Self::Target(_) => "candela, to an error".to_owned(),
        }
    }

    /// As tables have it.
    pub(super) fn name(self) -> String {
        match self {
            Self::Samples(1) => "1 sample".to_owned(),
            Self::Samples(samples) => format!("{samples} samples"),
            Self::Target(relative) => format!("to {} %", digits(100.0 * relative)),
        }
    }

    /// As short as the plot needs it.
    pub(super) fn label(self) -> String {
        match self {
            Self::Samples(samples) => samples.to_string(),
            Self::Target(relative) => format!("{} %", digits(100.0 * relative)),
        }
    }
}

/// An error, or `none`.
pub(super) fn error(text: &str) -> Result<Option<f64>, String> {
    match text.trim() {
        "none" => Ok(None),
        error => max_error(error).map(Some),
    }
}

/// A number of samples.
pub(super) fn samples(text: &str) -> Result<u32, String> {
    let number = text.trim().parse().ok();
    let number = number.filter(|number| (1..=MAX_SAMPLES).contains(number));
    number.ok_or_else(|| format!("expected whole numbers from 1 to {MAX_SAMPLES}"))
}
