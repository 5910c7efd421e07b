//! `--samples`, or `--max-error` and what belongs to it: how exact the pixels are to be.

use candela::render::{ErrorCounts, ErrorTarget, MAX_SAMPLES, MIN_RELATIVE_ERROR};

use super::values::count;

/// Samples a pixel where none are asked for: nobody's first picture has steps at its edges.
const DEFAULT_SAMPLES: u32 = 16;

/// The options about accuracy.
#[derive(Debug, clap::Args)]
pub(super) struct AccuracyArguments {
    /// Samples a pixel, 1 to 65536: 1 is its center and nothing else, more are spread over it
    #[arg(
        long,
        value_name = "N",
        default_value_t = DEFAULT_SAMPLES,
        allow_negative_numbers = true
    )]
    #[arg(value_parser = |text: &str| count(text, MAX_SAMPLES))]
    pub(super) samples: u32,

    /// Render each pixel as exactly as this and no more, instead of with so many --samples: 0.5%, or
    /// 0.005; 1e-6 to 1
    ///
    /// In each of R, G and B a pixel is then off by no more than E times its radiance, or E times the
    /// floor where it is darker than that; its alpha by no more than E. For most pixels, those
    /// without an edge and those with few, that is proven; for others it is estimated from 16, 64,
    /// 256, … samples. The summary, the header and --stats count both, and those that --max-samples
    /// have not brought to it.
    #[arg(
        long,
        value_name = "E",
        conflicts_with = "samples",
        allow_negative_numbers = true
    )]
    #[arg(value_parser = max_error)]
    max_error: Option<f64>,

    /// With --max-error: what is darker than this, in cd/m², may be off by as much as this may
    /// [default: 1 % of the mean luminance of 64 × 64 points over the whole image]
    #[arg(
        long,
        value_name = "CD/M2",
        requires = "max_error",
        allow_negative_numbers = true
    )]
    #[arg(value_parser = floor)]
    error_floor: Option<f64>,

    /// With --max-error: the most samples of a pixel, 1 to 65536 [default: 4096]
    #[arg(
        long,
        value_name = "N",
        requires = "max_error",
        allow_negative_numbers = true
    )]
    #[arg(value_parser = |text: &str| count(text, MAX_SAMPLES))]
    max_samples: Option<u32>,
}

impl AccuracyArguments {
    pub(super) fn target(&self) -> Option<ErrorTarget> {
        self.max_error.map(|relative| {
            let target = ErrorTarget::new(relative);
            ErrorTarget {
                floor: self.error_floor,
                max_samples: self.max_samples.unwrap_or(target.max_samples),
                ..target
            }
        })
    }

    /// What a summary says of it.
    pub(super) fn summary(&self) -> String {
        match (self.max_error, self.samples) {
            (Some(relative), _) => format!("to an error of {}", percent(relative)),
            (None, 1) => "1 sample a pixel".to_owned(),
            (None, samples) => format!("{samples} samples a pixel"),
        }
    }

    /// How exact the pixels are.
    pub(super) fn outcome(&self, errors: &ErrorCounts) -> Option<String> {
        self.max_error?;
        let all = (errors.bound() + errors.estimated).max(1) as f64;
        let share = |count: u64| percent(count as f64 / all);
        let mut parts: Vec<String> = Vec::new();
        for (count, how, worst) in [
            (errors.bound(), "proven", errors.worst_bound),
            (errors.estimated, "estimated", errors.worst_estimate),
        ] {
            if count > 0 {
                let of = if parts.is_empty() {
                    " of the pixels"
                } else {
                    ""
                };
                parts.push(format!("{}{of} {how} to {}", share(count), percent(worst)));
            }
        }
        Some(format!("errors: {}", parts.join(", ")))
    }

    /// What is to be warned of.
    pub(super) fn warning(&self, errors: &ErrorCounts) -> Option<String> {
        let target = self.target()?;
        (errors.unmet > 0).then(|| {
            format!(
                "pixels that {} samples have not brought to an error of {}: {}; the worst is estimated at {}; \
                 allow more with --max-samples, or a larger --max-error",
                target.max_samples,
                percent(target.relative),
                errors.unmet,
                percent(errors.worst_estimate),
            )
        })
    }
}

/// With three digits: `0.5 %`.
fn percent(part: f64) -> String {
    let text = format!("{:.2e}", part * 100.0);
    let number: f64 = text.parse().unwrap_or(f64::NAN);
    format!("{} %", crate::cli::numbers::number(number))
}

/// 0.5% or 0.005
pub(crate) fn max_error(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let (number, scale) = match text.strip_suffix('%') {
        Some(percent) => (percent.trim_end(), 0.01),
        None => (text, 1.0),
    };
    let error = number.parse().ok().map(|number: f64| number * scale);
    error
        .filter(|error| (MIN_RELATIVE_ERROR..=1.0).contains(error))
        .ok_or_else(|| {
            format!(
                "expected an error such as 0.5% or 0.005, from {MIN_RELATIVE_ERROR:e}, below which a 32-bit float \
                 says no more, to 1, which is 100%"
            )
        })
}

fn floor(text: &str) -> Result<f64, String> {
    let floor = text.trim().parse().ok();
    floor
        .filter(|&floor: &f64| floor > 0.0 && floor.is_finite())
        .ok_or_else(|| "expected a radiance above 0 in cd/m², such as 0.001".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_parts_or_percent() {
        for (text, expected) in [
            ("0.5%", 0.005),
            ("0.5 %", 0.005),
            ("0.01", 0.01),
            ("1", 1.0),
            ("100%", 1.0),
            ("1e-6", 1e-6),
        ] {
            assert!(
                (max_error(text).unwrap() / expected - 1.0).abs() < 1e-15,
                "{text}"
            );
        }
        for text in [
            "0", "-1", "nan", "1.1", "101%", "1e-7", "half", "", "%", "inf",
        ] {
            let message = max_error(text).unwrap_err();
            assert!(message.contains("such as 0.5% or 0.005"), "{text}");
        }
    }

    #[test]
    fn a_floor_is_above_nothing() {
        assert_eq!(floor("0.001"), Ok(0.001));
        for text in ["0", "-1", "nan", "inf", "dark"] {
            assert!(floor(text).unwrap_err().contains("above 0 in cd/m²"));
        }
    }

    #[test]
    fn percentages_have_three_digits() {
        assert_eq!(percent(0.005), "0.5 %");
        assert_eq!(percent(0.987_654), "98.8 %");
        assert_eq!(percent(1.0), "100 %");
        assert_eq!(percent(0.000_012_34), "0.00123 %");
    }
}
