//! Values for light and color, as written.

use std::sync::Arc;

use crate::color::{ColorSpace, transfer};
use crate::spectrum::{Curve, Illuminant, Lines};

/// A value for light or color.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `0.5`: the same in every channel, and of a reflectance at every wavelength.
    Uniform(f64),
    /// `[r, g, b]` or `{ rgb = [r, g, b], space = "acescg" }`: linear, one number per primary of
    /// `space`; a bare `[r, g, b]` is Rec.709.
    Rgb {
        /// Red, green, blue.
        rgb: [f64; 3],
        /// Whose primaries these are.
        space: ColorSpace,
    },
    /// `"#rrggbb"`: sRGB-coded, 8 bits a channel.
    Srgb([u8; 3]),
    /// `{ illuminant = "D65" }`: the color of a light.
    Illuminant(Illuminant),
    /// `{ daylight = 5600 }`: the color of a light, as a correlated color temperature in K.
    Daylight(f64),
    /// `{ blackbody = 3200 }`: the color of a light, as a temperature in K.
    Blackbody(f64),
    /// `{ wavelengths = […], values = […] }` or `{ file = "curve.csv" }`: of a light in
    /// W·sr⁻¹·nm⁻¹, of a background in W·m⁻²·sr⁻¹·nm⁻¹, of a surface a reflectance.
    Curve(Arc<Curve>),
    /// `{ lines = [[589.0, 0.5], …] }`: of a light, in W·sr⁻¹ each.
    Lines(Arc<Lines>),
    /// `{ candela = 120, color = … }`: a light whose size is said in a unit.
    Sized {
        /// What is measured.
        unit: Unit,
        /// How much of it. Range: 0 or more.
        amount: f64,
        /// The light's color, of any size. Default: 1, which is white.
        color: Box<Value>,
    },
    /// Light or a reflectance between keys: the sum of others, each so many times.
    Mixed(Arc<Mixture>),
}

/// Values and how much there is of each; together 1. Those between two keys of `smooth` may have less than nothing of
/// a third.
#[derive(Clone, Debug, PartialEq)]
pub struct Mixture(pub Vec<(f64, Value)>);

/// The units in which the size of a light can be said. The light is the same in all directions, so
/// that a flux is 4π times an intensity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Unit {
    /// Luminous intensity I in cd.
    Candela,
    /// Luminous flux Φ = 4π I in lm.
    Lumens,
    /// Illuminance E in lx on a surface that faces the light, which has no place.
    Lux,
    /// Luminance L in cd/m² of a surface that shines.
    Nits,
    /// Radiant intensity in W/sr: ∫ I(λ) dλ from 360 to 830 nm.
    WattsPerSteradian,
    /// Radiant flux in W, 4π times the radiant intensity: the light that leaves the lamp, not the
    /// electricity that enters.
    Watts,
}

/// What a scene asks for about the way of light, `transport`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Transport {
    /// Spectral if anything in the scene is a spectrum, else RGB.
    #[default]
    Auto,
    /// One value per primary, whatever the scene holds.
    Rgb,
    /// Wavelength by wavelength, whatever the scene holds.
    Spectral,
}

impl Transport {
    /// Every choice, in the order of the documentation.
    pub const ALL: [Self; 3] = [Self::Auto, Self::Rgb, Self::Spectral];

    /// The name in a scene file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Rgb => "rgb",
            Self::Spectral => "spectral",
        }
    }
}

/// Where the light of a smooth mesh ends, `shadow_terminator`: what its triangles hide of themselves
/// although the normals between their vertices still face the light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ShadowTerminator {
    /// At the triangles: a shadow ray starts at the hit point p, and a light counts where it is above the
    /// triangle.
    #[default]
    Geometric,
    /// At the surface that the vertex normals describe (Hanika, "Hacking the Shadow Terminator", Ray
    /// Tracing Gems II, 2021): a shadow ray starts at p′ = p + Σ bᵢ max(0, (vᵢ − p)·nᵢ) nᵢ, and a light
    /// counts where it is above the plane through p across the interpolated normal.
    Hanika,
}

impl ShadowTerminator {
    /// Every choice, in the order of the documentation.
    pub const ALL: [Self; 2] = [Self::Geometric, Self::Hanika];

    /// The name in a scene file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Geometric => "geometric",
            Self::Hanika => "hanika",
        }
    }
}

/// How a spot's intensity falls off between its inner and its outer angle, `falloff`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Falloff {
    /// x²(3 − 2x), with x linear in the cosine of the angle: pbrt and Cycles.
    #[default]
    Smooth,
    /// x²: glTF, KHR_lights_punctual.
    Gltf,
    /// Linear in the angle: Mitsuba.
    LinearAngle,
}

impl Falloff {
    /// Every choice, in the order of the documentation.
    pub const ALL: [Self; 3] = [Self::Smooth, Self::Gltf, Self::LinearAngle];

    /// The name in a scene file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Smooth => "smooth",
            Self::Gltf => "gltf",
            Self::LinearAngle => "linear_angle",
        }
    }
}

impl Unit {
    /// Every unit, in the order of the documentation.
    pub const ALL: [Self; 6] = [
        Self::Candela,
        Self::Lumens,
        Self::WattsPerSteradian,
        Self::Watts,
        Self::Lux,
        Self::Nits,
    ];

    /// The key in a scene file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Candela => "candela",
            Self::Lumens => "lumens",
            Self::WattsPerSteradian => "watts_per_steradian",
            Self::Watts => "watts",
            Self::Lux => "lux",
            Self::Nits => "nits",
        }
    }
}

impl Value {
    /// Zero in every channel.
    pub const ZERO: Self = Self::Uniform(0.0);

    /// Whether it says more than RGB can: a spectrum, or a size in watts.
    pub fn is_spectral(&self) -> bool {
        match self {
            Self::Uniform(_) | Self::Rgb { .. } | Self::Srgb(_) => false,
            Self::Illuminant(_)
            | Self::Daylight(_)
            | Self::Blackbody(_)
            | Self::Curve(_)
            | Self::Lines(_) => true,
            Self::Sized { unit, color, .. } => match unit {
                Unit::Candela | Unit::Lumens | Unit::Lux | Unit::Nits => color.is_spectral(),
                Unit::WattsPerSteradian | Unit::Watts => true,
            },
            Self::Mixed(mixture) => mixture.0.iter().any(|(_, part)| part.is_spectral()),
        }
    }

    /// A sum of others.
    pub fn mixed(mixture: Mixture) -> Self {
        Self::Mixed(Arc::new(mixture))
    }

    /// The values that a sum is made of; else the value itself.
    pub(crate) fn parts(&self) -> Vec<&Self> {
        match self {
            Self::Mixed(mixture) => mixture
                .0
                .iter()
                .flat_map(|(_, part)| part.parts())
                .collect(),
            Self::Uniform(_)
            | Self::Rgb { .. }
            | Self::Srgb(_)
            | Self::Illuminant(_)
            | Self::Daylight(_)
            | Self::Blackbody(_)
            | Self::Curve(_)
            | Self::Lines(_)
            | Self::Sized { .. } => vec![self],
        }
    }

    /// The number that is the same in every channel.
    pub(super) const fn uniform(&self) -> Option<f64> {
        if let Self::Uniform(number) = self {
            Some(*number)
        } else {
            None
        }
    }

    /// What is written as numbers of primaries, linear, and whose these are; a gray is Rec.709.
    pub(crate) fn linear(&self) -> Option<([f64; 3], ColorSpace)> {
        match self {
            Self::Uniform(number) => Some(([*number; 3], ColorSpace::Rec709)),
            Self::Rgb { rgb, space } => Some((*rgb, *space)),
            Self::Srgb(codes) => {
                let rgb = codes.map(|code| transfer::srgb_decode(f64::from(code) / 255.0));
                Some((rgb, ColorSpace::Rec709))
            }
            Self::Illuminant(_)
            | Self::Daylight(_)
            | Self::Blackbody(_)
            | Self::Curve(_)
            | Self::Lines(_)
            | Self::Sized { .. }
            | Self::Mixed(_) => None,
        }
    }

    /// The unit, the amount and the color of a light whose size is said so.
    pub(super) fn sized_parts(&self) -> Option<(Unit, f64, &Self)> {
        if let Self::Sized {
            unit,
            amount,
            color,
        } = self
        {
            Some((*unit, *amount, color))
        } else {
            None
        }
    }
}
