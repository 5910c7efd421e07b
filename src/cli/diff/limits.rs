//! Limits, by which the exit code says whether two images agree.

use std::fmt;

use candela::internal::printable;
use serde::Serialize;

use super::figures::LayerReport;
use crate::cli::Failure;
use crate::cli::numbers::number;

/// What a layer may be off by.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Limits, for every layer")]
pub(super) struct Limits {
    /// The largest |B − A| of a value
    #[arg(long, value_name = "X", value_parser = limit)]
    max_error: Option<f64>,

    /// The mean of |B − A|
    #[arg(long, value_name = "X", value_parser = limit)]
    max_mean: Option<f64>,

    /// The root of the mean of (B − A)²
    #[arg(long, value_name = "X", value_parser = limit)]
    max_rmse: Option<f64>,

    /// The least ratio of the peak to the root mean square error, in dB
    #[arg(long, value_name = "DB", value_parser = limit)]
    min_psnr: Option<f64>,

    /// The largest relative error of a pixel
    #[arg(long, value_name = "X", value_parser = limit)]
    max_relative: Option<f64>,

    /// relMSE, the mean of (B − A)² / (A² + ε)
    #[arg(long, value_name = "X", value_parser = limit)]
    max_relmse: Option<f64>,

    /// How many pixels have a relative error above --tolerance
    #[arg(long, value_name = "N")]
    max_flips: Option<u64>,

    /// The mean of ꟻLIP, of layers with R, G, B
    #[arg(long, value_name = "X", value_parser = limit)]
    max_flip: Option<f64>,

    /// The mean of HDR-ꟻLIP, of layers with R, G, B
    #[arg(long, value_name = "X", value_parser = limit)]
    max_hdr_flip: Option<f64>,
}

/// A layer that is beyond a limit.
#[derive(Clone, Debug, Serialize)]
pub(super) struct BeyondLimit {
    pub(super) layer: String,
    /// The option that sets the limit.
    option: &'static str,
    found: f64,
    limit: f64,
}

impl fmt::Display for BeyondLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (layer, found, limit) = (
            printable(&self.layer),
            number(self.found),
            number(self.limit),
        );
        if self.option == NOT_FINITE {
            return write!(f, "differs in layer {layer} in what is NaN or infinite");
        }
        let side = if self.option.starts_with("--min") {
            "below"
        } else {
            "above"
        };
        write!(
            f,
            "is {side} the limit in layer {layer}: {found}, {} {limit}",
            self.option
        )
    }
}

/// What any limit forbids.
const NOT_FINITE: &str = "not finite";

impl Limits {
    /// What is beyond its limit.
    ///
    /// # Errors
    /// If a limit is of what no layer has.
    pub(super) fn beyond(&self, layers: &[LayerReport]) -> Result<Vec<BeyondLimit>, Failure> {
        let mut beyond = Vec::new();
        for layer in layers {
            self.judge(layer, &mut beyond)?;
        }
        let has_colors = layers.iter().any(|layer| layer.flip.is_some());
        for (limit, option) in [
            (self.max_flip, "--max-flip"),
            (self.max_hdr_flip, "--max-hdr-flip"),
        ] {
            if limit.is_some() && !has_colors {
                return Err(format!("{option} is for colors, and no layer has R, G, B").into());
            }
        }
        Ok(beyond)
    }

    fn judge(&self, layer: &LayerReport, beyond: &mut Vec<BeyondLimit>) -> Result<(), Failure> {
        let mut see = |option: &'static str, limit: Option<f64>, found: f64| {
            let Some(limit) = limit else {
                return;
            };
            let is_beyond = if option.starts_with("--min") {
                found < limit
            } else {
                found > limit
            };
            // What is not a number is within no limit.
            if is_beyond || found.is_nan() {
                beyond.push(BeyondLimit {
                    layer: layer.name.clone(),
                    option,
                    found,
                    limit,
                });
            }
        };
        let metrics = &layer.metrics;
        see("--max-error", self.max_error, metrics.max_error);
        see("--max-mean", self.max_mean, metrics.mean_error);
        see("--max-rmse", self.max_rmse, metrics.rmse);
        see("--min-psnr", self.min_psnr, metrics.psnr);
        see("--max-relative", self.max_relative, metrics.relative_max);
        see("--max-relmse", self.max_relmse, metrics.relmse);
        see(
            "--max-flips",
            self.max_flips.map(|flips| flips as f64),
            metrics.flips as f64,
        );
        if let Some(flip) = layer.flip {
            see("--max-flip", self.max_flip, flip);
            match (self.max_hdr_flip, layer.hdr_flip) {
                (limit, Some(found)) => see("--max-hdr-flip", limit, found),
                (None, None) => {}
                (Some(_), None) => {
                    return Err(format!(
                        "layer {} has no HDR-FLIP: the median luminance of the reference is not above 0, \
                         so that there is no range of exposures; leave --max-hdr-flip out",
                        printable(&layer.name)
                    )
                    .into());
                }
            }
        }
        // Means leave out what is not finite; no limit lets it pass.
        if metrics.max_error.is_infinite()
            && self.is_any()
            && beyond.last().is_none_or(|last| last.layer != layer.name)
        {
            beyond.push(BeyondLimit {
                layer: layer.name.clone(),
                option: NOT_FINITE,
                found: metrics.max_error,
                limit: 0.0,
            });
        }
        Ok(())
    }

    fn is_any(&self) -> bool {
        let Self {
            max_error,
            max_mean,
            max_rmse,
            min_psnr,
            max_relative,
            max_relmse,
            max_flips,
            max_flip,
            max_hdr_flip,
        } = self;
        let numbers = [
            max_error,
            max_mean,
            max_rmse,
            min_psnr,
            max_relative,
            max_relmse,
            max_flip,
            max_hdr_flip,
        ];
        max_flips.is_some() || numbers.iter().any(|limit| limit.is_some())
    }
}

/// A number from 0 on.
pub(crate) fn limit(text: &str) -> Result<f64, String> {
    let number = text
        .parse()
        .ok()
        .filter(|number: &f64| number.is_finite() && *number >= 0.0);
    number.ok_or_else(|| "expected a number from 0 on, such as 0.01 or 1e-5".to_owned())
}
