//! The options that say how radiance becomes a picture: of `tonemap`, and of `render` for its preview.

use candela::display::{Dither, Exposure, View};
use clap::builder::{PossibleValuesParser, TypedValueParser};

/// From radiance to the screen's range.
#[derive(Debug, clap::Args)]
pub(super) struct DevelopArguments {
    #[command(flatten)]
    exposure: ExposureArguments,

    /// How radiance beyond the screen's range is shown
    ///
    /// srgb: it clips, all below is as it is; reinhard: x / (1 + x) in each channel, nothing clips.
    #[arg(
        long,
        value_name = "NAME",
        default_value = View::default().name(),
        value_parser = PossibleValuesParser::new(View::ALL.map(View::name))
            .try_map(|name| name.parse::<View>())
    )]
    pub(super) view: View,

    /// How light between two codes of 8 bits is shown
    ///
    /// blue: by a fine pattern of both codes whose mean is right, without which slow gradients show
    /// rings; what is a code exactly, black and white among them, stays that; none: by the nearest
    /// code. 16 bits need none. The pattern depends on the place in the whole picture alone.
    #[arg(
        long,
        value_name = "NAME",
        default_value = Dither::default().name(),
        value_parser = PossibleValuesParser::new(Dither::ALL.map(Dither::name))
            .map(|name| Dither::ALL.into_iter().find(|dither| dither.name() == name).unwrap_or_default())
    )]
    pub(super) dither: Dither,
}

/// What radiance is multiplied by.
#[derive(Debug, clap::Args)]
pub(super) struct ExposureArguments {
    /// Multiply the radiance by 2^EV; may be negative or a fraction
    #[arg(
        long,
        value_name = "EV",
        default_value_t = 0.0,
        value_parser = finite,
        allow_negative_numbers = true
    )]
    exposure: f64,

    /// Choose the EV that brings the log-average luminance of what is lit to 18 % gray
    #[arg(long, conflicts_with = "exposure")]
    auto_exposure: bool,
}

impl DevelopArguments {
    pub(super) const fn exposure(&self) -> Exposure {
        self.exposure.exposure()
    }
}

impl ExposureArguments {
    pub(super) const fn exposure(&self) -> Exposure {
        if self.auto_exposure {
            Exposure::Auto
        } else {
            Exposure::Ev(self.exposure)
        }
    }
}

fn finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("expected a finite number of EV, such as 1.5 or -2".to_string()),
    }
}
