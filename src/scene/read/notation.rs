//! The notations of light and color that are tables: their keys, and for what each is.

use std::ops::Bound;

use super::super::value::Unit;
use super::key::{AMOUNT, BRIGHTEST, Form, Key, Kind, Purpose, Range, key};
use crate::color::ColorSpace;
use crate::spectrum::Illuminant;

pub(super) const RGB: Key = key!("rgb", "three linear numbers", "[0.7, 0.3, 0.2]")
    .of(Kind::Channels)
    .about("Red, green and blue, linear, of the primaries of `space`.");
pub(super) const SPACE: Key = key!("space", "the name of a color space", "\"rec709\"")
    .of(Kind::Name(space_names))
    .or("\"rec709\"")
    .about("Whose primaries these are.")
    .also(&["color_space", "colorspace"]);
pub(super) const ILLUMINANT: Key = key!("illuminant", "the name of an illuminant", "\"D65\"")
    .of(Kind::Name(illuminant_names))
    .about("An illuminant of the CIE.");
pub(super) const DAYLIGHT: Key = key!("daylight", "a color temperature in K", "5600")
    .of(Kind::Number(DAYLIGHTS))
    .about("Daylight by its correlated color temperature in K: 4000 to 25000.");
pub(super) const BLACKBODY: Key = key!("blackbody", "a temperature in K", "3200")
    .of(Kind::Number(BLACKBODIES))
    .about("A glowing body by its temperature in K: 500 to 1000000.")
    .also(&["black_body", "temperature", "kelvin", "cct"]);
pub(super) const WAVELENGTHS: Key = key!(
    "wavelengths",
    "wavelengths in nm, ascending",
    "[400, 550, 700]"
)
.of(Kind::Wavelengths)
.about("Two or more wavelengths in nm, ascending.")
.also(&["nm", "lambda", "wavelength"]);
pub(super) const VALUES: Key = key!("values", "a number for each wavelength", "[0.1, 0.5, 0.4]")
    .of(Kind::Amounts)
    .about("A number from 0 for each wavelength; the curve is linear between them.");
pub(super) const FILE: Key = key!("file", "a CSV file beside the scene", "\"curve.csv\"")
    .of(Kind::Text)
    .about("A curve from a file of two columns, nm and value, relative to the scene's folder.")
    .also(&["filename", "path", "csv", "spd"]);
pub(super) const LINES: Key = key!(
    "lines",
    "wavelengths in nm, each with its W/sr",
    "[[589.0, 0.5], [589.6, 0.5]]"
)
.of(Kind::Lines)
.about("Light of single wavelengths: pairs of nm, 360 to 830, and W/sr.");
pub(super) const CANDELA: Key = key!("candela", "a luminous intensity in cd", "120")
    .of(Kind::Number(AMOUNT))
    .about("Luminous intensity in cd.")
    .also(&["cd", "candelas"]);
pub(super) const LUMENS: Key = key!("lumens", "a luminous flux in lm", "800")
    .of(Kind::Number(AMOUNT))
    .about("Luminous flux in lm: 4π times the intensity in cd.")
    .also(&["lm", "lumen"]);
pub(super) const WATTS_PER_STERADIAN: Key =
    key!("watts_per_steradian", "a radiant intensity in W/sr", "0.5")
        .of(Kind::Number(AMOUNT))
        .about("Radiant intensity in W/sr, summed over 360 to 830 nm.");
pub(super) const WATTS: Key = key!("watts", "a radiant flux in W", "6")
    .of(Kind::Number(AMOUNT))
    .about("Radiant flux in W: the light that leaves the lamp, not the electricity that enters.")
    .also(&["w", "watt"]);
pub(super) const DENSITY: Key = key!(
    "watts_per_steradian_nm",
    "a spectral intensity in W/(sr nm), a number or a curve",
    "0.002"
)
.of(Kind::Density)
.about("Spectral intensity in W/(sr nm): a number for every wavelength, or a curve.");
pub(super) const COLOR: Key = key!(
    "color",
    "the light's color (`[r, g, b]`, `\"#rrggbb\"`, `{ illuminant = \"A\" }`, …)",
    "{ blackbody = 3200 }"
)
.of(Kind::Value(Purpose::Color, BRIGHTEST))
.or("1")
.about("The light's color, of any size: it is scaled to the size that is said beside it.")
.also(&["colour", "tint", "rgb"]);
pub(super) const LUX: Key = key!("lux", "an illuminance in lx", "100000")
    .of(Kind::Number(AMOUNT))
    .about("Illuminance in lx on a surface that faces a sun.")
    .also(&["lx", "illuminance"]);
pub(super) const NITS: Key = key!("nits", "a luminance in cd/m²", "3000")
    .of(Kind::Number(AMOUNT))
    .about("Luminance in cd/m² of a surface that shines.")
    .also(&["nit", "luminance", "cd_per_m2", "candela_per_square_meter"]);
/// The size that a light with an area of a color alone lacks.
pub(super) const SIZE_OF_AREA: Key = Key {
    line: "the light's size in a unit, such as `{ nits = 3000, color = … }` (or `lumens`, `candela`, \
           `watts_per_steradian`, `watts`)",
    ..NITS
};
/// The size that a sun of a color alone lacks.
pub(super) const SIZE_OF_SUN: Key = Key {
    line: "the sun's size in lux: `{ lux = 100000, color = … }`",
    ..LUX
};
/// The size that a light of a color alone lacks.
pub(super) const SIZE: Key = Key {
    line: "the light's size in a unit, such as `{ candela = 120, color = … }` \
           (or `lumens`, `watts_per_steradian`, `watts`)",
    ..CANDELA
};

/// The temperatures in K for which daylight is defined (CIE 15:2018).
const DAYLIGHTS: Range = (Bound::Included(4000.0), Bound::Included(25_000.0));

/// The temperatures in K of black bodies.
const BLACKBODIES: Range = (Bound::Included(500.0), Bound::Included(1e6));

/// The names of the color spaces.
pub(super) fn space_names() -> Vec<&'static str> {
    ColorSpace::ALL.map(ColorSpace::name).to_vec()
}

fn illuminant_names() -> Vec<&'static str> {
    Illuminant::ALL.map(Illuminant::name).to_vec()
}

/// The notations that are tables, each known by the first of its keys that is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum Notation {
    Rgb,
    Illuminant,
    Daylight,
    Blackbody,
    Curve,
    File,
    Lines,
    Sized(Unit),
    Density,
}

impl Notation {
    pub(in crate::scene) const ALL: [Self; 14] = [
        Self::Rgb,
        Self::Illuminant,
        Self::Daylight,
        Self::Blackbody,
        Self::Curve,
        Self::File,
        Self::Lines,
        Self::Sized(Unit::Candela),
        Self::Sized(Unit::Lumens),
        Self::Sized(Unit::WattsPerSteradian),
        Self::Sized(Unit::Watts),
        Self::Sized(Unit::Lux),
        Self::Sized(Unit::Nits),
        Self::Density,
    ];

    pub(super) const fn key(self) -> &'static Key {
        match self {
            Self::Rgb => &RGB,
            Self::Illuminant => &ILLUMINANT,
            Self::Daylight => &DAYLIGHT,
            Self::Blackbody => &BLACKBODY,
            Self::Curve => &WAVELENGTHS,
            Self::File => &FILE,
            Self::Lines => &LINES,
            Self::Sized(Unit::Candela) => &CANDELA,
            Self::Sized(Unit::Lumens) => &LUMENS,
            Self::Sized(Unit::WattsPerSteradian) => &WATTS_PER_STERADIAN,
            Self::Sized(Unit::Watts) => &WATTS,
            Self::Sized(Unit::Lux) => &LUX,
            Self::Sized(Unit::Nits) => &NITS,
            Self::Density => &DENSITY,
        }
    }

    /// The keys of its table.
    pub(in crate::scene) const fn form(self) -> Form<'static> {
        Form::new(match self {
            Self::Rgb => &[&RGB, &SPACE],
            Self::Illuminant => &[&ILLUMINANT],
            Self::Daylight => &[&DAYLIGHT],
            Self::Blackbody => &[&BLACKBODY],
            Self::Curve => &[&WAVELENGTHS, &VALUES],
            Self::File => &[&FILE],
            Self::Lines => &[&LINES],
            Self::Sized(Unit::Candela) => &[&CANDELA, &COLOR],
            Self::Sized(Unit::Lumens) => &[&LUMENS, &COLOR],
            Self::Sized(Unit::WattsPerSteradian) => &[&WATTS_PER_STERADIAN, &COLOR],
            Self::Sized(Unit::Watts) => &[&WATTS, &COLOR],
            Self::Sized(Unit::Lux) => &[&LUX, &COLOR],
            Self::Sized(Unit::Nits) => &[&NITS, &COLOR],
            Self::Density => &[&DENSITY],
        })
    }

    /// Whether it is light rather than a share of it, and whether its size is said.
    pub(in crate::scene) const fn is_for(self, purpose: Purpose) -> Result<(), &'static str> {
        match (self, purpose) {
            (Self::Sized(Unit::Lux), Purpose::Light) => Err(
                "is what arrives from a sun, `[lights.NAME.sun]`; a lamp has a size of its own: \
                     `{ candela = 120, color = … }` (or `lumens`, `watts_per_steradian`, `watts`)",
            ),
            (Self::Sized(Unit::Nits), Purpose::Light) => Err(
                "is what a surface sends, `[lights.NAME.rectangle]`, `disk` or `sphere`; a lamp without an area has \
                     an intensity: `{ candela = 120, color = … }` (or `lumens`, `watts_per_steradian`, `watts`)",
            ),
            (Self::Sized(Unit::Lux), Purpose::Luminance) => Err(
                "is what arrives from a sun, `[lights.NAME.sun]`; a surface that shines has a size of its own: \
                     `{ nits = 3000, color = … }` (or `lumens`, `candela`, `watts_per_steradian`, `watts`)",
            ),
            (Self::Density, Purpose::Luminance) => Err(
                "is what a lamp without an area sends; a surface has a luminance: a number or `[r, g, b]` in cd/m², \
                     `{ nits = 3000, color = … }`, or a curve in W/(m² sr nm)",
            ),
            (Self::Illuminant | Self::Daylight | Self::Blackbody, Purpose::Luminance) => Err(
                "is a color without a size; write `{ nits = 3000, color = … }` (or `lumens`, `candela`, \
                     `watts_per_steradian`, `watts`)",
            ),
            (Self::Curve | Self::File, _)
            | (
                Self::Rgb,
                Purpose::Light
                | Purpose::Illuminance
                | Purpose::Luminance
                | Purpose::Color
                | Purpose::Background
                | Purpose::Surface,
            )
            | (
                Self::Lines,
                Purpose::Light
                | Purpose::Illuminance
                | Purpose::Luminance
                | Purpose::Color
                | Purpose::Background,
            )
            | (Self::Illuminant | Self::Daylight | Self::Blackbody, Purpose::Color)
            | (Self::Sized(_) | Self::Density, Purpose::Light)
            | (Self::Sized(_), Purpose::Luminance)
            | (Self::Sized(Unit::Lux), Purpose::Illuminance) => Ok(()),
            (Self::Illuminant | Self::Daylight | Self::Blackbody, Purpose::Illuminance) => {
                Err("is a color without a size; write `{ lux = 100000, color = … }`")
            }
            (Self::Sized(_) | Self::Density, Purpose::Illuminance) => Err(
                "is what a lamp sends; a sun has an illuminance: a number or `[r, g, b]` in lux, \
                     `{ lux = 100000, color = … }`, or a curve in W/(m² nm)",
            ),
            (Self::Illuminant | Self::Daylight | Self::Blackbody, Purpose::Light) => Err(
                "is a color without a size; write `{ candela = 120, color = … }` \
                     (or `lumens`, `watts_per_steradian`, `watts`)",
            ),
            (
                Self::Illuminant
                | Self::Daylight
                | Self::Blackbody
                | Self::Sized(_)
                | Self::Density,
                Purpose::Background,
            ) => Err(
                "is for lights; a background is a radiance: a number or `[r, g, b]` in cd/m², \
                     or a curve in W/(m² sr nm)",
            ),
            (Self::Sized(_) | Self::Density, Purpose::Color) => {
                Err("is a size, which is said once, beside `color`")
            }
            (
                Self::Illuminant
                | Self::Daylight
                | Self::Blackbody
                | Self::Lines
                | Self::Sized(_)
                | Self::Density,
                Purpose::Surface,
            ) => Err(
                "is for lights; a surface has a reflectance: a number, `[r, g, b]`, \
                     `\"#rrggbb\"` or a curve from 0 to 1",
            ),
            (
                Self::Rgb
                | Self::Illuminant
                | Self::Daylight
                | Self::Blackbody
                | Self::Lines
                | Self::Sized(_)
                | Self::Density,
                Purpose::Index | Purpose::GlassIndex,
            ) => Err("is a color; a refractive index is a number, or a curve over the wavelength"),
        }
    }
}
