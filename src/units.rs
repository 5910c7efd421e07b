//! Photometric quantities as types.
//!
//! The unit system is photometric with the metre as the scene unit. Each quantity is a linear
//! RGB triple in the working color space, one value per primary; quantities of different
//! dimension cannot be added, and one becomes another only through the physics named here.
//!
//! | type | quantity | unit |
//! | --- | --- | --- |
//! | [`Intensity`] | luminous intensity I of a point light | cd |
//! | [`Illuminance`] | light arriving, on a surface that faces the light (L3) | lx |
//! | [`Reflectance`] | a reflectance k_d or k_s of L5 and L7 | 1 |
//! | [`ReflectedIntensity`] | I · k: a light's intensity as one lobe reflects it | cd |
//! | [`Radiance`] | luminance towards the viewer (L9) | cd/m² |

use std::ops::{Add, AddAssign};

/// A linear RGB triple of no particular dimension: what the quantities below are made of.
///
/// Range: finite. Stored as `f32`, the precision of the film.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rgb(pub [f32; 3]);

impl Rgb {
    /// No light.
    pub const BLACK: Self = Self([0.0; 3]);

    /// The same value in every channel.
    pub const fn gray(value: f32) -> Self {
        Self([value; 3])
    }

    /// Narrows a triple from the f64 of the scene to the f32 of the film.
    pub fn narrowed(rgb: [f64; 3]) -> Self {
        Self(rgb.map(|value| value as f32))
    }

    /// Whether every channel is exactly zero.
    pub fn is_black(self) -> bool {
        self.0.iter().all(|&channel| channel == 0.0)
    }

    /// Whether every channel is a finite number.
    pub fn is_finite(self) -> bool {
        self.0.iter().all(|channel| channel.is_finite())
    }

    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

/// Luminous intensity I of a point light, in candela, per primary.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Intensity(pub Rgb);

/// Light arriving at a surface that faces the light (L3), in lux, per primary.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Illuminance(pub Rgb);

/// A reflectance k_d or k_s (L5, L7), per primary. Range: not negative.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reflectance(pub Rgb);

/// I · k: a light's intensity after one lobe of one material, in candela, per primary.
///
/// A pixel is linear in these products, so they are made once per pair of light and material.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReflectedIntensity(pub Rgb);

/// Luminance towards the viewer (L9), in cd/m², per primary.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Radiance(pub Rgb);

impl Intensity {
    /// L3: the light that arrives at `distance_squared` (m²), I / d².
    pub fn illuminance(self, distance_squared: f64) -> Illuminance {
        let per_area = 1.0 / distance_squared;
        Illuminance(Rgb(self
            .0
            .0
            .map(|intensity| (f64::from(intensity) * per_area) as f32)))
    }
}

impl ReflectedIntensity {
    /// One term of L9: the radiance that this lobe sends to the viewer, where `geometry` (m⁻²)
    /// is the lobe's cosine term over the distance squared.
    pub fn radiance(self, geometry: f32) -> Radiance {
        Radiance(Rgb(self.0.0.map(|intensity| intensity * geometry)))
    }
}

impl Radiance {
    /// No light.
    pub const BLACK: Self = Self(Rgb::BLACK);
}

impl Add for Radiance {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(self.0.zip(other.0, |a, b| a + b))
    }
}

impl AddAssign for Radiance {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
