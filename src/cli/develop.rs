//! The options that say how radiance becomes a picture: of `tonemap`, and of `render` for its preview.

mod quantities;

use std::path::PathBuf;

use candela::display::{
    Cube, Dither, Drawn, Exposure, FalseColor, Gamut, Overlay, Screen, Settings, View,
};
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::Failure;
use super::legend::legend;

/// From radiance to the screen's range.
#[derive(Debug, clap::Args)]
pub(super) struct DevelopArguments {
    #[command(flatten)]
    exposure: ExposureArguments,

    /// What is to look white: a light such as D65 or A, a temperature in K, or a chromaticity x,y
    ///
    /// Colors are adapted from it to the screen's white by CAT16. Without, they stay as they are.
    #[arg(long, value_name = "LIGHT", value_parser = quantities::white)]
    white_balance: Option<quantities::White>,

    /// How radiance beyond the screen's range is shown
    ///
    /// srgb: it clips, all below is as it is; reinhard: x / (1 + x) in each channel, nothing clips;
    /// reinhard-extended: the same, but 4 becomes white; hable: the filmic curve of Uncharted 2;
    /// aces-fit: Narkowicz's fit of ACES, in each channel; aces-fit-hill: Hill's fit of ACES, whose
    /// strong colors bleach; pbr-neutral: Khronos's, base colors as they are, highlights compressed;
    /// agx: Sobotka's AgX; aces1, aces2: ACES 1.0 and 2.0, as in OpenColorIO; raw: the numbers are code
    /// values, for data; absolute: 1 in the file is 1 cd/m² on the screen;
    /// false-color: luminance as colors with their legend, in stops from middle gray, or in cd/m² by
    /// false-color=0.1:1000; lut=FILE.cube: a look-up table from linear Rec.709 to sRGB codes.
    #[arg(
        long,
        value_name = "NAME",
        default_value = View::default().name(),
        value_parser = choice
    )]
    view: Choice,

    /// The screen that the picture is made for
    ///
    /// srgb; p3: Display P3; rec2020-pq and rec2020-hlg: HDR (BT.2100), where 1 after exposure and view is 203
    /// cd/m²; rec1886: a television with the primaries of Rec.709; linear: code values are light. The PNG says which.
    #[arg(
        long,
        value_name = "NAME",
        default_value = Screen::default().name(),
        value_parser = PossibleValuesParser::new(Screen::ALL.map(Screen::name))
            .map(|name| Screen::ALL.into_iter().find(|screen| screen.name() == name).unwrap_or_default())
    )]
    pub(super) display: Screen,

    /// The luminance of 1 on the screen, in cd/m² [default: 203 on HDR, else 80; 100 on rec1886]
    #[arg(long, value_name = "CD/M2", value_parser = quantities::luminance)]
    white_nits: Option<f64>,

    /// What becomes of colors that the screen's primaries cannot mix
    ///
    /// clip: their negative channels become 0; compress: saturated colors move towards gray, so far that those of
    /// Rec.2020 fit, and keep their order.
    #[arg(
        long,
        value_name = "RULE",
        default_value = Gamut::default().name(),
        value_parser = PossibleValuesParser::new(Gamut::ALL.map(Gamut::name))
            .map(|name| Gamut::ALL.into_iter().find(|gamut| gamut.name() == name).unwrap_or_default())
    )]
    gamut: Gamut,

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
    dither: Dither,
}

/// What radiance is multiplied by.
#[derive(Debug, clap::Args)]
pub(super) struct ExposureArguments {
    /// Multiply the radiance by 2^EV; may be negative or a fraction
    #[arg(
        long,
        value_name = "EV",
        default_value_t = 0.0,
        value_parser = quantities::ev,
        allow_negative_numbers = true
    )]
    exposure: f64,

    /// Choose the EV from the picture
    ///
    /// log-average, or no value: the log-average luminance of what is lit becomes 18 % gray;
    /// percentile:99: the luminance that 99 % of what is lit does not exceed becomes the screen's white. Of many
    /// pictures each is exposed by itself; a contact sheet has one exposure, for all.
    #[arg(
        long,
        value_name = "RULE",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "log-average",
        value_parser = quantities::rule,
        conflicts_with = "exposure"
    )]
    auto_exposure: Option<Exposure>,

    /// Expose as a camera does whose sensor has this speed; with --shutter and --aperture
    ///
    /// Pixels are luminances in cd/m², as candela writes them. What saturates the sensor becomes the screen's white:
    /// L = 1.2 · 2^EV100, EV100 = log2(N²/t · 100/S). --exposure adds to it.
    #[arg(
        long,
        value_name = "S",
        value_parser = quantities::speed,
        requires_all = ["shutter", "aperture"],
        conflicts_with = "auto_exposure"
    )]
    iso: Option<f64>,

    /// How long the camera's shutter is open, in seconds, such as 1/60 or 0.5
    #[arg(long, value_name = "T", value_parser = quantities::shutter, requires = "iso")]
    shutter: Option<f64>,

    /// The f-number of the camera's lens, such as 8 or f/8
    #[arg(long, value_name = "N", value_parser = quantities::aperture, requires = "iso")]
    aperture: Option<f64>,
}

impl DevelopArguments {
    pub(super) fn exposure(&self) -> Exposure {
        self.exposure.exposure()
    }

    /// What is to be known before frames of a sequence become pictures.
    pub(super) fn of_frames(&self) -> Option<&'static str> {
        let warning = "--auto-exposure exposes each frame by itself, so that a movie of them may flicker; give all of \
                       them one --exposure, such as the one that is told for a frame in the middle";
        self.exposure().is_auto().then_some(warning)
    }

    /// What is read from files for a picture of this resolution.
    pub(super) fn look(&self, resolution: [u32; 2]) -> Result<Look, Failure> {
        Ok(match &self.view {
            Choice::Named(_) => Look::default(),
            Choice::FalseColor(colors) => Look {
                overlays: legend(resolution, colors, &[]).into_iter().collect(),
                ..Look::default()
            },
            Choice::Cube(path) => Look {
                cube: Some(Cube::read(path)?),
                ..Look::default()
            },
        })
    }

    /// The false colors of the view, if it has them.
    pub(super) const fn false_color(&self) -> Option<&FalseColor> {
        match &self.view {
            Choice::FalseColor(colors) => Some(colors),
            Choice::Named(_) | Choice::Cube(_) => None,
        }
    }

    /// Whether another color than the screen's white is made white.
    pub(super) fn is_balanced(&self) -> bool {
        self.white_balance
            .is_some_and(|white| white.chromaticity.is_some())
    }

    /// What is said here; the rest as it is by default.
    pub(super) fn settings<'l>(&self, look: &'l Look) -> Settings<'l> {
        let default = Settings::default();
        Settings {
            exposure: self.exposure(),
            view: self.view.view(),
            dither: self.dither,
            screen: self.display,
            white_luminance: self.white_nits,
            white: self.white_balance.and_then(|white| white.chromaticity),
            gamut: self.gamut,
            false_color: match &self.view {
                Choice::FalseColor(colors) => *colors,
                Choice::Named(_) | Choice::Cube(_) => default.false_color,
            },
            cube: look.cube.as_ref(),
            drawn: Drawn {
                overlays: &look.overlays,
                ..Drawn::NOTHING
            },
            ..default
        }
    }
}

/// What a view needs beside its name.
#[derive(Debug, Default)]
pub(super) struct Look {
    cube: Option<Cube>,
    overlays: Vec<Overlay>,
}

/// A view as it is chosen.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Choice {
    Named(View),
    FalseColor(FalseColor),
    /// The file of a look-up table.
    Cube(PathBuf),
}

impl Choice {
    const fn view(&self) -> View {
        match self {
            Self::Named(view) => *view,
            Self::FalseColor(_) => View::FalseColor,
            Self::Cube(_) => View::Cube,
        }
    }
}

/// A view's name, `false-color=0.1:1000` or `lut=FILE.cube`.
fn choice(text: &str) -> Result<Choice, String> {
    let expected = || {
        let names = View::ALL.map(View::name).join(", ");
        format!("expected {names}, false-color=LEAST:MOST in cd/m², or lut=FILE.cube")
    };
    match text.split_once('=') {
        Some(("lut", "")) | None if text.starts_with("lut") => {
            Err("a look-up table is a file: lut=FILE.cube".to_owned())
        }
        Some(("lut", path)) => Ok(Choice::Cube(PathBuf::from(path))),
        Some(("false-color", "stops")) => Ok(Choice::FalseColor(FalseColor::STOPS)),
        Some(("false-color", range)) => {
            let ends = range
                .split_once(':')
                .and_then(|(least, most)| least.parse::<f64>().ok().zip(most.parse::<f64>().ok()));
            let (least, most) = ends.ok_or_else(|| {
                "expected the range of false colors in cd/m², such as false-color=0.1:1000"
                    .to_owned()
            })?;
            let colors = FalseColor::luminance(least, most).map_err(|error| error.to_string())?;
            Ok(Choice::FalseColor(colors))
        }
        Some(_) => Err(expected()),
        None => match text.parse() {
            Ok(View::FalseColor) => Ok(Choice::FalseColor(FalseColor::STOPS)),
            Ok(view) => Ok(Choice::Named(view)),
            Err(_) => Err(expected()),
        },
    }
}

impl ExposureArguments {
    pub(super) fn exposure(&self) -> Exposure {
        if let Some(chosen) = self.auto_exposure {
            return chosen;
        }
        match (self.iso, self.shutter, self.aperture) {
            (Some(iso), Some(shutter), Some(aperture)) => {
                match Exposure::of_camera(iso, shutter, aperture) {
                    Exposure::Ev(ev) => Exposure::Ev(ev + self.exposure),
                    chosen @ (Exposure::Auto | Exposure::Percentile(_)) => chosen,
                }
            }
            _ => Exposure::Ev(self.exposure),
        }
    }
}
