//! What a point receives of a part of an emitter: all integrals that shading asks for.

use std::f64::consts::TAU;
use std::ops::{Add, AddAssign, Mul, Sub, SubAssign};

use super::clip::Polygon;
use super::conic::Conic;
use super::outline::Outline;
use super::{Emitter, polygon};
use crate::math::{DVec3, Direction, Normal, Point};

/// What receives light at a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Receiver {
    /// The geometric normal towards the viewer: light from below is not received.
    pub(crate) horizon: Normal,
    /// The shading normal n, of the cosine.
    pub(crate) normal: Normal,
    /// The specular lobe, if the material has one.
    pub(crate) gloss: Option<Gloss>,
}

/// A specular lobe (w·u)ᴺ.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gloss {
    /// w: where a mirror would show the viewer.
    pub(crate) axis: Direction,
    /// N
    pub(crate) shininess: f64,
    /// Whether n·u is a factor of it, as in `normalized_phong`.
    pub(crate) has_cosine: bool,
}

/// The integrals over what is above the horizon, in sr.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Received {
    /// Φ(n) = ∫ max(0, n·u) dω
    pub(crate) irradiance: f64,
    /// ∫ max(0, w·u)ᴺ dω, or ∫ max(0, w·u)ᴺ max(0, n·u) dω; 0 without a lobe.
    pub(crate) lobe: f64,
    /// ∫ dω
    pub(crate) solid_angle: f64,
}

impl Emitter {
    /// What a point receives where nothing is in the way. `None` where it sees nothing of the emitter: from
    /// behind, from its plane, from within a sphere, and where all of it is below the horizon.
    pub(crate) fn received(&self, point: Point, receiver: &Receiver) -> Option<Received> {
        let received = match self.seen_from(point)?.clipped(receiver.horizon)? {
            Outline::Polygon(polygon) => receiver.of_polygon(polygon.corners()),
            Outline::Conic(conic) => receiver.of_conic(&conic),
        };
        (received.solid_angle > 0.0).then_some(received)
    }

    /// The same, with a solid angle of 0 wherever there is an irradiance: that of all points that are shaded.
    pub(crate) fn received_by_lobes(&self, point: Point, receiver: &Receiver) -> Option<Received> {
        let horizon = receiver.horizon.get();
        let is_above = |corner: &DVec3| horizon.dot(*corner) >= 0.0;
        let whole = self.corners_from(point);
        let received = match whole.filter(|corners| corners.iter().all(is_above)) {
            // Of what is not cut, nothing is copied.
            Some(corners) => receiver.lobes_of_polygon(&corners),
            None => match self.seen_from(point)?.clipped(receiver.horizon)? {
                Outline::Polygon(polygon) => receiver.lobes_of_polygon(polygon.corners()),
                Outline::Conic(conic) => receiver.lobes_of_conic(&conic),
            },
        };
        if received.irradiance > 0.0 {
            Some(received)
        } else {
            self.received(point, receiver)
        }
    }
}

impl Receiver {
    /// What is received of a polygon that the horizon has cut already.
    pub(super) fn of_polygon(&self, corners: &[DVec3]) -> Received {
        Received {
            solid_angle: polygon::solid_angle(corners),
            ..self.lobes_of_polygon(corners)
        }
    }

    /// What is received of a part of a disk or a sphere that the horizon has cut already.
    pub(super) fn of_conic(&self, conic: &Conic) -> Received {
        Received {
            solid_angle: conic.solid_angle(),
            ..self.lobes_of_conic(conic)
        }
    }

    /// The same without the solid angle.
    fn lobes_of_polygon(&self, corners: &[DVec3]) -> Received {
        let normal = self.normal.get();
        let lobe = |gloss: Gloss| {
            let w = gloss.axis.get();
            if !gloss.has_cosine {
                return polygon::lobe(corners, w, gloss.shininess);
            }
            let cosine_lobe =
                |corners: &[DVec3]| polygon::cosine_lobe(corners, w, normal, gloss.shininess);
            if corners.iter().all(|&corner| normal.dot(corner) >= 0.0) {
                return cosine_lobe(corners);
            }
            // Those of more corners than there is room for are cut into triangles.
            let part = |corners: &[DVec3]| {
                let polygon = Polygon::new(corners)?.clipped(normal)?;
                Some(cosine_lobe(polygon.corners()))
            };
            part(corners).unwrap_or_else(|| {
                let first = corners.first().copied().unwrap_or_default();
                let pairs = corners.windows(2).skip(1);
                pairs
                    .filter_map(|pair| part(&[first, pair[0], pair[1]]))
                    .sum()
            })
        };
        Received {
            irradiance: polygon::irradiance(corners, normal),
            lobe: self.gloss.map_or(0.0, lobe),
            solid_angle: 0.0,
        }
    }

    /// The same without the solid angle.
    fn lobes_of_conic(&self, conic: &Conic) -> Received {
        let normal = self.normal.get();
        let lobe = |gloss: Gloss| {
            let w = gloss.axis.get();
            if !gloss.has_cosine {
                return conic.lobe(w, gloss.shininess);
            }
            // There is room for one plane more than a cell has edges.
            let above = conic.clipped(normal).unwrap_or(*conic);
            above.cosine_lobe(w, normal, gloss.shininess)
        };
        Received {
            irradiance: conic.irradiance(normal),
            lobe: self.gloss.map_or(0.0, lobe),
            solid_angle: 0.0,
        }
    }

    /// What each integral is over, along a direction of any length.
    pub(super) fn weights(&self, way: DVec3) -> Received {
        let way = way / way.length();
        let irradiance = self.normal.get().dot(way).max(0.0);
        let lobe = |gloss: Gloss| {
            let lobe = libm::pow(gloss.axis.get().dot(way).max(0.0), gloss.shininess);
            lobe * if gloss.has_cosine { irradiance } else { 1.0 }
        };
        Received {
            irradiance,
            lobe: self.gloss.map_or(0.0, lobe),
            solid_angle: 1.0,
        }
    }

    /// How far each integral over one piece may be off as numbers are rounded, and as what is narrower than they
    /// tell is left out.
    pub(super) fn rounding(&self) -> Received {
        Received {
            irradiance: 1e-14,
            lobe: 3e-12 * self.full_lobe(),
            solid_angle: 1e-13,
        }
    }

    /// The lobe over all directions, at most.
    pub(super) fn full_lobe(&self) -> f64 {
        self.gloss.map_or(0.0, |gloss| {
            TAU / (gloss.shininess + if gloss.has_cosine { 2.0 } else { 1.0 })
        })
    }
}

impl Received {
    pub(super) const NOTHING: Self = Self {
        irradiance: 0.0,
        lobe: 0.0,
        solid_angle: 0.0,
    };

    /// The largest of the parts that each integral is of that of another, of which 0 is no part.
    pub(super) fn part_of(self, whole: Self) -> f64 {
        let part = |mine: f64, all: f64| if all > 0.0 { mine / all } else { 0.0 };
        part(self.irradiance, whole.irradiance)
            .max(part(self.lobe, whole.lobe))
            .max(part(self.solid_angle, whole.solid_angle))
    }

    /// Whether each is at most another.
    pub(super) fn is_below(self, most: Self) -> bool {
        self.irradiance <= most.irradiance
            && self.lobe <= most.lobe
            && self.solid_angle <= most.solid_angle
    }

    /// Each with that of another.
    fn with(self, other: Self, join: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            irradiance: join(self.irradiance, other.irradiance),
            lobe: join(self.lobe, other.lobe),
            solid_angle: join(self.solid_angle, other.solid_angle),
        }
    }

    /// Each times that of another.
    pub(super) fn times(self, other: Self) -> Self {
        self.with(other, |one, other| one * other)
    }

    /// The smaller one of each.
    pub(super) fn least(self, other: Self) -> Self {
        self.with(other, f64::min)
    }

    /// The larger one of each.
    pub(super) fn most(self, other: Self) -> Self {
        self.with(other, f64::max)
    }

    /// Each without its sign.
    pub(super) fn magnitude(self) -> Self {
        Self {
            irradiance: self.irradiance.abs(),
            lobe: self.lobe.abs(),
            solid_angle: self.solid_angle.abs(),
        }
    }

    /// Each at least 0, which rounding may have changed.
    pub(super) fn at_least_nothing(self) -> Self {
        Self {
            irradiance: self.irradiance.max(0.0),
            lobe: self.lobe.max(0.0),
            solid_angle: self.solid_angle.max(0.0),
        }
    }
}

impl Add for Received {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            irradiance: self.irradiance + other.irradiance,
            lobe: self.lobe + other.lobe,
            solid_angle: self.solid_angle + other.solid_angle,
        }
    }
}

impl Mul<f64> for Received {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self {
            irradiance: self.irradiance * factor,
            lobe: self.lobe * factor,
            solid_angle: self.solid_angle * factor,
        }
    }
}

impl Sub for Received {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + other * -1.0
    }
}

impl AddAssign for Received {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Received {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}
