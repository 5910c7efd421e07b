//! Photometric quantities as types.
//!
//! The unit system is photometric with the metre as the scene unit. Each quantity is a linear
//! RGB triple in the working color space, one value per primary; quantities of different
//! dimension cannot be added, and one becomes another only through the physics named here.
//! They are f64; only the film narrows them.
//!
//! | type | quantity | unit |
//! | --- | --- | --- |
//! | [`Intensity`] | luminous intensity I of a point light | cd |
//! | [`Reflectance`] | a reflectance k_d or k_s of L5 and L7 | 1/sr |
//! | [`ReflectedIntensity`] | I · k: a light's intensity as one lobe reflects it | cd/sr |
//! | [`Radiance`] | luminance towards the viewer (L9) | cd/m² |

/// A linear RGB triple of no particular dimension: what the quantities below are made of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rgb(pub [f64; 3]);

impl Rgb {
    /// No light.
    pub const BLACK: Self = Self([0.0; 3]);

    #[inline]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let ([r, g, b], [other_r, other_g, other_b]) = (self.0, other.0);
        Self([f(r, other_r), f(g, other_g), f(b, other_b)])
    }
}

/// Luminous intensity I of a point light, in candela, per primary.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Intensity(pub Rgb);

/// A reflectance k_d or k_s (L5, L7), per primary. Range: not negative, but for a spectrum whose color
/// is outside of the working space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reflectance(pub Rgb);

/// I · k: a light's intensity after one lobe of one material, per primary.
///
/// A pixel is linear in these products. Where light is carried as RGB they are made when they are asked for,
/// and where it is spectral, each is an integral that is made when it is first asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReflectedIntensity(pub Rgb);

/// Luminance towards the viewer (L9), in cd/m², per primary.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Radiance(pub Rgb);

impl Intensity {
    /// The part of L3 and L8 that does not depend on the place: I · k.
    #[inline]
    pub fn reflected(self, reflectance: Reflectance) -> ReflectedIntensity {
        ReflectedIntensity(self.0.zip(reflectance.0, |i, k| i * k))
    }
}

impl Reflectance {
    /// Whether nothing is reflected.
    #[inline]
    pub fn is_black(self) -> bool {
        let [r, g, b] = self.0.0;
        r == 0.0 && g == 0.0 && b == 0.0
    }
}
