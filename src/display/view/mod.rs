//! Views: how radiance from 0 to ∞ becomes what a screen shows.
//!
//! A view is a file with its transform, an entry in [`View`], and an arm of [`Rendering`].

mod absolute;
mod aces1;
mod aces2;
mod aces_fit;
mod aces_fit_hill;
mod agx;
mod cube;
mod false_color;
mod hable;
mod pbr_neutral;
mod raw;
mod reinhard;
mod reinhard_extended;
mod srgb;
mod viridis;

use std::fmt;
use std::str::FromStr;

pub use cube::{Cube, CubeError, CubeFault, CubeProblem};
pub use false_color::{BadRange, FalseColor, Measure};

use super::Settings;
use super::lanes::{Planes, transform};
use super::screen::Screen;
use super::tags::Mastering;
use crate::color::Primaries;
use crate::simd::SimdLevel;

/// The views by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum View {
    /// As it is; what exceeds the screen's range clips.
    #[default]
    Srgb,
    /// x / (1 + x) per channel; nothing clips.
    Reinhard,
    /// x (1 + x/16) / (1 + x) per channel; 4 becomes white.
    ReinhardExtended,
    /// Hable's filmic curve of Uncharted 2, per channel; 5.6 becomes white.
    Hable,
    /// Narkowicz's fit of ACES's curve, per channel; 7.2 becomes white.
    AcesFit,
    /// Hill's fit of ACES with its matrices; a gray of 26 becomes white.
    AcesFitHill,
    /// Khronos PBR Neutral: base colors as they are, highlights compressed; nothing clips.
    PbrNeutral,
    /// Sobotka's AgX; a gray of 16 becomes white.
    Agx,
    /// ACES 1.0 SDR Video, as OpenColorIO has it; a gray of 16 becomes white.
    Aces1,
    /// The output transform of ACES 2.0 (Academy, 2025), as OpenColorIO has it, to 5e-5 of the range of codes: for a peak
    /// of 100 cd/m² and the primaries of Rec.709 or P3 and, on HDR screens, of 1000 cd/m² and P3. Hues stay; bright
    /// colors fade to white, and saturated ones come inside of the screen's range.
    Aces2,
    /// The numbers are code values: no curve, on any screen.
    Raw,
    /// cd/m² in the file are cd/m² on a screen of which the white is known.
    Absolute,
    /// Luminance as colors: [`Settings::false_color`].
    FalseColor,
    /// A look-up table of the user's: [`Settings::cube`].
    Cube,
}

impl View {
    /// Every view that needs no file, in the order of the documentation.
    pub const ALL: [Self; 13] = [
        Self::Srgb,
        Self::Reinhard,
        Self::ReinhardExtended,
        Self::Hable,
        Self::AcesFit,
        Self::AcesFitHill,
        Self::PbrNeutral,
        Self::Agx,
        Self::Aces1,
        Self::Aces2,
        Self::Raw,
        Self::Absolute,
        Self::FalseColor,
    ];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Srgb => "srgb",
            Self::Reinhard => "reinhard",
            Self::ReinhardExtended => "reinhard-extended",
            Self::Hable => "hable",
            Self::AcesFit => "aces-fit",
            Self::AcesFitHill => "aces-fit-hill",
            Self::PbrNeutral => "pbr-neutral",
            Self::Agx => "agx",
            Self::Aces1 => "aces1",
            Self::Aces2 => "aces2",
            Self::Raw => "raw",
            Self::Absolute => "absolute",
            Self::FalseColor => "false-color",
            Self::Cube => "lut",
        }
    }

    /// Whether it works on each channel by itself, of the screen's own primaries; the others on those of Rec.709.
    pub(super) const fn is_per_channel(self) -> bool {
        match self {
            Self::Srgb
            | Self::Reinhard
            | Self::ReinhardExtended
            | Self::Hable
            | Self::AcesFit
            | Self::Raw
            | Self::Absolute => true,
            Self::AcesFitHill
            | Self::PbrNeutral
            | Self::Agx
            | Self::Aces1
            | Self::Aces2
            | Self::FalseColor
            | Self::Cube => false,
        }
    }

    /// Whether what it yields is code values, whatever the screen.
    pub(super) const fn is_coded(self) -> bool {
        matches!(self, Self::Raw)
    }

    /// The luminance of a light of 1 on HDR screens in cd/m², where the view says one: that of a diffuse white otherwise.
    pub(super) const fn luminance(self) -> Option<f64> {
        match self {
            Self::Aces2 => Some(SDR_PEAK),
            Self::Srgb
            | Self::Reinhard
            | Self::ReinhardExtended
            | Self::Hable
            | Self::AcesFit
            | Self::AcesFitHill
            | Self::PbrNeutral
            | Self::Agx
            | Self::Aces1
            | Self::Raw
            | Self::Absolute
            | Self::FalseColor
            | Self::Cube => None,
        }
    }

    /// The display that the view is made for, where it is made for one of high dynamic range.
    pub(super) const fn mastering(self, screen: Screen) -> Option<Mastering> {
        match (self, screen) {
            (Self::Aces2, Screen::Rec2020Pq) => Some(Mastering {
                primaries: Primaries::P3_D65,
                luminance: [0.0, HDR_PEAK],
            }),
            (_, _) => None,
        }
    }

    /// Whether there is light so bright that it is cut off: all above is the screen's white.
    pub const fn clips(self) -> bool {
        match self {
            Self::Reinhard | Self::PbrNeutral | Self::FalseColor | Self::Cube => false,
            Self::Srgb
            | Self::ReinhardExtended
            | Self::Hable
            | Self::AcesFit
            | Self::AcesFitHill
            | Self::Agx
            | Self::Aces1
            | Self::Aces2
            | Self::Raw
            | Self::Absolute => true,
        }
    }
}

/// A view with what it computes once: from exposed linear Rec.709, R, G, B without a coverage multiplied, to
/// linear Rec.709 light, of which 1 is the screen's white. What is outside of the screen's range clips later.
pub(super) enum Rendering<'a> {
    Srgb(srgb::Clip),
    Reinhard(reinhard::Reinhard),
    ReinhardExtended(reinhard_extended::ReinhardExtended),
    Hable(hable::Hable),
    AcesFit(aces_fit::AcesFit),
    AcesFitHill(aces_fit_hill::AcesFitHill),
    PbrNeutral(pbr_neutral::PbrNeutral),
    Agx(agx::Agx),
    Aces1(Box<aces1::Aces1>),
    /// For a peak and primaries.
    Aces2(Box<aces2::Aces2>),
    Raw(raw::Raw),
    Absolute(absolute::Absolute),
    /// A look-up table of the user's.
    Cube(&'a Cube),
    /// Luminance as colors.
    FalseColor(false_color::Map),
}

/// The peaks of screens of standard and of high dynamic range in cd/m², of the transforms of ACES 2.0 that OpenColorIO names
/// first for them: "SDR 100 nits", and "HDR 1000 nits (P3 D65)".
const SDR_PEAK: f64 = 100.0;
const HDR_PEAK: f64 = 1000.0;

impl<'a> Rendering<'a> {
    /// For a screen on which a light of 1 has the luminance `white` in cd/m², and a picture that is exposed by 2^`ev`.
    pub(super) fn new(settings: &Settings<'a>, white: f64, ev: f64) -> Self {
        let screen = settings.screen;
        match settings.view {
            View::Srgb => Self::Srgb(srgb::Clip),
            View::Reinhard => Self::Reinhard(reinhard::Reinhard),
            View::ReinhardExtended => Self::ReinhardExtended(Default::default()),
            View::Hable => Self::Hable(hable::Hable),
            View::AcesFit => Self::AcesFit(aces_fit::AcesFit),
            View::AcesFitHill => Self::AcesFitHill(aces_fit_hill::AcesFitHill),
            View::PbrNeutral => Self::PbrNeutral(pbr_neutral::PbrNeutral),
            View::Agx => Self::Agx(agx::Agx::new()),
            View::Aces1 => Self::Aces1(Box::new(aces1::Aces1::new())),
            View::Aces2 => {
                let (peak, limiting) = if screen.is_hdr() {
                    (HDR_PEAK, Primaries::P3_D65)
                } else {
                    (SDR_PEAK, screen.primaries())
                };
                Self::Aces2(Box::new(aces2::Aces2::new(peak, &limiting)))
            }
            View::Raw => Self::Raw(raw::Raw),
            View::Absolute => Self::Absolute(absolute::Absolute { white }),
            View::FalseColor => Self::FalseColor(settings.false_color.map(ev)),
            View::Cube => match settings.cube {
                Some(cube) => Self::Cube(cube),
                None => Self::Srgb(srgb::Clip),
            },
        }
    }

    /// Whether light becomes brighter as radiance does, for as long as the screen can.
    pub(super) const fn is_linear(&self) -> bool {
        matches!(self, Self::Srgb(_) | Self::Absolute(_))
    }

    /// The exposed radiance that becomes the screen's white, where all above is cut off: of each channel, or of
    /// grays under views that mix the channels. Infinite where nothing is.
    pub(super) const fn white(&self) -> f64 {
        match self {
            Self::Srgb(_) | Self::Raw(_) => 1.0,
            Self::Reinhard(_) | Self::PbrNeutral(_) | Self::FalseColor(_) | Self::Cube(_) => {
                f64::INFINITY
            }
            Self::ReinhardExtended(view) => view.white,
            Self::Hable(_) => hable::Hable::WHITE,
            Self::AcesFit(_) => aces_fit::AcesFit::WHITE,
            Self::AcesFitHill(_) => aces_fit_hill::AcesFitHill::WHITE,
            Self::Agx(_) => agx::Agx::WHITE,
            Self::Aces1(_) => aces1::Aces1::WHITE,
            Self::Aces2(view) => view.white(),
            Self::Absolute(view) => view.white,
        }
    }

    /// Of the first `count` colors.
    pub(super) fn apply(&self, level: SimdLevel, planes: &mut Planes, count: usize) {
        match self {
            Self::Srgb(view) => transform(level, view, planes, count),
            Self::Reinhard(view) => transform(level, view, planes, count),
            Self::ReinhardExtended(view) => transform(level, view, planes, count),
            Self::Hable(view) => transform(level, view, planes, count),
            Self::AcesFit(view) => transform(level, view, planes, count),
            Self::AcesFitHill(view) => transform(level, view, planes, count),
            Self::PbrNeutral(view) => transform(level, view, planes, count),
            Self::Agx(view) => transform(level, view, planes, count),
            Self::Aces1(view) => transform(level, &**view, planes, count),
            Self::Aces2(view) => transform(level, &**view, planes, count),
            Self::Raw(view) => transform(level, view, planes, count),
            Self::Absolute(view) => transform(level, view, planes, count),
            Self::Cube(view) => transform(level, *view, planes, count),
            Self::FalseColor(view) => transform(level, view, planes, count),
        }
    }
}

impl fmt::Display for View {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is not that of a [`View`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown view `{0}`, expected {expected}", expected = View::ALL.map(View::name).join(", "))]
pub struct UnknownView(pub String);

impl FromStr for View {
    type Err = UnknownView;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|view| view.name() == name)
            .ok_or_else(|| UnknownView(name.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::lanes::PIECE;

    fn shown(view: View) -> Rendering<'static> {
        let settings = Settings {
            view,
            ..Settings::new()
        };
        Rendering::new(&settings, Screen::Srgb.white(), 0.0)
    }

    #[test]
    fn views_have_names() {
        for view in View::ALL {
            assert_eq!(view.name().parse(), Ok(view));
        }
        assert_eq!(
            "film".parse::<View>().unwrap_err().to_string(),
            "unknown view `film`, expected srgb, reinhard, reinhard-extended, hable, aces-fit, \
             aces-fit-hill, pbr-neutral, agx, aces1, aces2, raw, absolute, false-color"
        );
    }

    #[test]
    fn grays_never_fall() {
        // False colors are no grays.
        for view in View::ALL
            .into_iter()
            .filter(|view| *view != View::FalseColor)
        {
            let grays = std::array::from_fn(|i| (i as f64 / 4.0 - 32.0).exp2());
            let mut planes: Planes = [grays; 3];
            shown(view).apply(SimdLevel::default(), &mut planes, PIECE);
            assert!(planes.iter().all(|plane| plane.is_sorted()), "{view}");
            assert!(planes[0][0] >= 0.0, "{view}");
        }
    }

    #[test]
    fn all_above_the_white_is_cut_off() {
        for view in View::ALL
            .into_iter()
            .filter(|view| *view != View::FalseColor)
        {
            let rendering = shown(view);
            let white = rendering.white();
            assert_eq!(view.clips(), white.is_finite(), "{view}");
            let mut planes = [[0.0; PIECE]; 3];
            for plane in &mut planes {
                plane[0] = white.min(1e3) * 0.99;
                plane[1] = white.min(1e3) * 1.01;
            }
            rendering.apply(SimdLevel::default(), &mut planes, 2);
            for [below, above, ..] in planes {
                assert!(below < 1.0, "{view}: {below}");
                // A matrix of five decimals, and decoded code values.
                assert_eq!(above > 1.0 - 2e-5, view.clips(), "{view}: {above}");
            }
        }
    }

    /// Colors of all kinds: dark, bright, saturated, negative, as large as there are.
    fn colors() -> Planes {
        std::array::from_fn(|channel| {
            std::array::from_fn(|i| match i {
                0 => 0.0,
                1 => 1e30,
                2 => -1e30,
                3 => [1e30, -1e30, 0.0][channel],
                4 => [-1e30, 0.0, 1e-30][channel],
                _ => {
                    let place = [0.37, 0.71, 0.53][channel] * i as f64;
                    (place * 17.0).sin() * (place.cos() * 12.0).exp2()
                }
            })
        })
    }

    #[test]
    fn every_instruction_set_shows_the_same() {
        for view in View::ALL {
            let bits = |level| {
                let mut planes = colors();
                shown(view).apply(level, &mut planes, PIECE);
                assert!(
                    planes.iter().flatten().all(|light| light.is_finite()),
                    "{view}"
                );
                planes.map(|plane| plane.map(f64::to_bits))
            };
            let expected = bits(SimdLevel::default());
            for (name, level) in SimdLevel::available() {
                assert_eq!(bits(level), expected, "{view} by {name}");
            }
        }
    }
}
