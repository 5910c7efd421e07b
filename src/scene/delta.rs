//! Perfectly smooth surfaces, which reflect like a mirror or let light through, as written.

use super::{Spanned, Value};

/// A perfect mirror, or of a Phong material the coat over its lobes: R of what is seen in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Mirror {
    /// R across the surface. Range: 0 to 1.
    pub reflectance: Spanned<Value>,
    /// Whether R rises to 1 at grazing angles, R + (1 − R)(1 − cos θ)⁵ (Schlick 1994). Default false.
    pub schlick: bool,
}

/// `[materials.NAME.metal]`: a mirror with the reflectance that Fresnel's equations give to n + ik.
#[derive(Clone, Debug, PartialEq)]
pub enum Metal {
    /// `preset`: one whose n and k are known.
    Preset(Spanned<String>),
    /// `n` and `k`
    Indices {
        /// n, a number or a curve. Range: 0 or more.
        n: Spanned<Value>,
        /// k, a number or a curve. Range: 0 or more.
        k: Spanned<Value>,
    },
}

/// `[materials.NAME.glass]`: a smooth body that bends light, all of whose boundary is an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Glass {
    /// How much it bends light.
    pub index: GlassIndex,
    /// σ in m⁻¹: over a way of x metres e^(−σx) is left. Range: 0 or more. Default 0.
    pub absorption: Spanned<Value>,
    /// Whether each wavelength goes a way of its own. Default false: all go that of 587.6 nm.
    pub dispersion: bool,
}

/// The refractive index of a glass.
#[derive(Clone, Debug, PartialEq)]
pub enum GlassIndex {
    /// `n`: a number, or a curve over the wavelength. Range: 1 to 4.
    Value(Spanned<Value>),
    /// `sellmeier`: that of a known glass.
    Sellmeier(Spanned<String>),
}

/// `[materials.NAME.pane]`: a thin sheet of glass, both of whose faces reflect, and which bends nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Pane {
    /// n. Range: 1 to 4.
    pub n: Spanned<f64>,
}

/// How often light may be reflected or refracted on its way to the viewer, if the scene does not say.
pub const DEFAULT_DEPTH: u32 = 8;

/// The largest depth that may be asked for.
pub const LARGEST_DEPTH: u32 = 1000;
