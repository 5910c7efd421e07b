//! What a point sees of an emitter, and what planes through the point leave of it.

use super::clip::Polygon;
use super::conic::Conic;
use super::polygon;
#[cfg(test)]
use crate::math::Direction;
use crate::math::Normal;

/// A part of an emitter, seen from a point.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Outline {
    Polygon(Polygon),
    Conic(Conic),
}

impl Outline {
    /// What of it is above a plane through the point, which is where `inward · x ≥ 0`. `None` where too many planes
    /// have cut it, more than twenty.
    pub(crate) fn clipped(&self, inward: Normal) -> Option<Self> {
        match self {
            Self::Polygon(polygon) => polygon.clipped(inward.get()).map(Self::Polygon),
            Self::Conic(conic) => conic.clipped(inward.get()).map(Self::Conic),
        }
    }

    /// Φ(n) = ∫ max(0, n·u) dω in sr, from 0 to π: the irradiance per unit of radiance.
    pub(crate) fn irradiance(&self, n: Normal) -> f64 {
        match self {
            Self::Polygon(polygon) => polygon::irradiance(polygon.corners(), n.get()),
            Self::Conic(conic) => conic.irradiance(n.get()),
        }
    }

    /// τⁿ(w) = ∫ max(0, w·u)ⁿ dω in sr, from 0 to 2π/(n+1), n from 0 to 1e9, w the mirrored direction to the
    /// viewer. The horizon has to have cut it.
    #[cfg(test)]
    pub(crate) fn lobe(&self, w: Direction, shininess: f64) -> f64 {
        match self {
            Self::Polygon(polygon) => polygon::lobe(polygon.corners(), w.get(), shininess),
            Self::Conic(conic) => conic.lobe(w.get(), shininess),
        }
    }

    /// ∫ max(0, w·u)ⁿ v·u dω in sr, from 0 to 2π/(n+2), as [`lobe`](Self::lobe). The horizon of v has to have cut
    /// it.
    #[cfg(test)]
    pub(crate) fn cosine_lobe(&self, w: Direction, v: Normal, shininess: f64) -> f64 {
        let [w, v] = [w.get(), v.get()];
        match self {
            Self::Polygon(polygon) => polygon::cosine_lobe(polygon.corners(), w, v, shininess),
            Self::Conic(conic) => conic.cosine_lobe(w, v, shininess),
        }
    }

    /// In sr, from 0 to 2π.
    #[cfg(test)]
    pub(crate) fn solid_angle(&self) -> f64 {
        match self {
            Self::Polygon(polygon) => polygon::solid_angle(polygon.corners()),
            Self::Conic(conic) => conic.solid_angle(),
        }
    }
}
