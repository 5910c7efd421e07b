//! Luminaires with an area: the light that a point receives of them, past what stands between.
//!
//! An emitter sends the same radiance L_e in all directions from all of its surface. A point p sees it as a set Ω
//! of directions u, its [`Outline`]. With V = 1, L9 is an integral over Ω, of which L_e and the reflectances are
//! factors. What is left are three scalars in sr:
//!
//! | factor | integral | range |
//! | --- | --- | --- |
//! | irradiance Φ(n) | ∫ max(0, n·u) dω | 0 to π |
//! | lobe τⁿ(w) | ∫ max(0, w·u)ⁿ dω | 0 to 2π/(n+1) |
//! | lobe with cosine | ∫ max(0, w·u)ⁿ (v·u) dω | 0 to 2π/(n+2) |
//!
//! By L6, ω_o·ω_r = w·u where w = 2 (n·ω_o) n − ω_o, so that, N the shininess and Ω cut by the horizon of the
//! geometric normal:
//!
//! - `phong`: L_o = L_e [k_d Φ(n) + k_s τᴺ(w)], as L7 has no cosine;
//! - `normalized_phong`: L_o = L_e [ρ_d/π Φ(n) + ρ_s (N+2)/(2π) ∫ max(0, w·u)ᴺ (n·u) dω], Ω cut by the horizon of
//!   n too.
//!
//! All are integrals along the boundary of Ω: great circles where it is straight, arcs of ellipses where it is a
//! disk or a sphere. Planes through p leave outlines of the same kinds, the horizon as well as those through an
//! occluder's edges. So what is received past triangles, planes, disks and balls is a sum of the same integrals over
//! pieces, up to rounding; only where more than two cones cross in one place it has a bound of its error instead
//! ([`Emitter::received_past`]).
//!
//! Lambert 1760, "Photometria". Baum, Rushmeier & Winget 1989, "Improving radiosity solutions through the use of
//! analytically determined form-factors". Arvo 1995, "Applications of irradiance tensors to the simulation of
//! non-Lambertian phenomena".

mod average;
mod beside;
mod clip;
mod conic;
mod crossing;
mod fit;
mod gauss;
mod lambert;
mod lobe;
mod occluder;
mod outline;
mod pieces;
mod places;
pub(crate) mod polygon;
mod power;
mod received;
mod seen;
mod shadow;
#[cfg(test)]
mod tests;
mod through;

use std::f64::consts::PI;

use crate::math::{DVec3, Normal, Point};
use clip::Polygon;
pub(crate) use conic::Conic;
pub(crate) use occluder::Occluder;
use outline::Outline;
pub(crate) use places::{Surface, SurfacePoint};
pub(crate) use received::{Gloss, Received, Receiver};
pub(crate) use shadow::{Accuracy, ShadowSpace};
pub(crate) use through::{Panes, Untold};

/// A luminaire with an area, of the same luminance everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Emitter {
    center: Point,
    shape: Shape,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    /// It shines to the side of `normal`.
    Rectangle {
        /// From the center to the middles of two sides, across each other.
        halves: [DVec3; 2],
        normal: Normal,
        is_two_sided: bool,
    },
    Disk {
        radius: f64,
        normal: Normal,
        is_two_sided: bool,
    },
    Sphere {
        radius: f64,
    },
}

impl Emitter {
    /// A rectangle with these vectors from its center to the middles of two of its sides, which are across each
    /// other; it shines to the side of their cross product. `None` where it has no area or is not finite.
    pub(crate) fn rectangle(center: Point, halves: [DVec3; 2], is_two_sided: bool) -> Option<Self> {
        let [a, b] = halves;
        let normal = Normal::new(a.cross(b))?;
        let shape = Shape::Rectangle {
            halves,
            normal,
            is_two_sided,
        };
        center.0.is_finite().then_some(Self { center, shape })
    }

    /// A disk that shines to the side of its normal. `None` where it has no area or is not finite.
    pub(crate) fn disk(
        center: Point,
        normal: Normal,
        radius: f64,
        is_two_sided: bool,
    ) -> Option<Self> {
        let shape = Shape::Disk {
            radius,
            normal,
            is_two_sided,
        };
        is_solid(center, radius).then_some(Self { center, shape })
    }

    /// A sphere that shines outwards. `None` where it has no area or is not finite.
    pub(crate) fn sphere(center: Point, radius: f64) -> Option<Self> {
        let shape = Shape::Sphere { radius };
        is_solid(center, radius).then_some(Self { center, shape })
    }

    /// The corners of a rectangle that shines to a point, as it sees them.
    fn corners_from(&self, point: Point) -> Option<[DVec3; 4]> {
        let Shape::Rectangle {
            halves: [a, b],
            normal,
            is_two_sided,
        } = self.shape
        else {
            return None;
        };
        let to_center = self.center.from(point);
        let is_lit = shines_to(to_center, normal, is_two_sided);
        let corners = [
            to_center + (-a - b),
            to_center + (a - b),
            to_center + (a + b),
            to_center + (b - a),
        ];
        let is_finite = corners.iter().all(|corner| corner.is_finite());
        (is_lit && is_finite).then_some(corners)
    }

    /// What a point sees of it. `None` from behind, from a point in its plane, and from within a sphere.
    pub(crate) fn seen_from(&self, point: Point) -> Option<Outline> {
        let to_center = self.center.from(point);
        match self.shape {
            Shape::Rectangle { .. } => {
                let corners = self.corners_from(point)?;
                Polygon::new(&corners).map(Outline::Polygon)
            }
            Shape::Disk {
                radius,
                normal,
                is_two_sided,
            } => {
                let conic = shines_to(to_center, normal, is_two_sided)
                    .then(|| Conic::of_disk(to_center, normal.get(), radius));
                conic.flatten().map(Outline::Conic)
            }
            Shape::Sphere { radius } => Conic::of_sphere(to_center, radius).map(Outline::Conic),
        }
    }

    /// In m², of one side.
    pub(crate) fn area(&self) -> f64 {
        match self.shape {
            Shape::Rectangle { halves: [a, b], .. } => 4.0 * a.cross(b).length(),
            Shape::Disk { radius, .. } => PI * radius * radius,
            Shape::Sphere { radius } => 4.0 * PI * radius * radius,
        }
    }

    /// Flux per luminance, in lm per cd/m²: π A for each side that shines, 4π² r² of a sphere.
    pub(crate) fn flux(&self) -> f64 {
        let sides = match self.shape {
            Shape::Rectangle { is_two_sided, .. } | Shape::Disk { is_two_sided, .. } => {
                if is_two_sided {
                    2.0
                } else {
                    1.0
                }
            }
            Shape::Sphere { .. } => 1.0,
        };
        PI * self.area() * sides
    }

    /// Intensity per luminance along the normal, in cd per cd/m²: A, or π r² of a sphere in all directions.
    pub(crate) fn intensity(&self) -> f64 {
        match self.shape {
            Shape::Rectangle { .. } | Shape::Disk { .. } => self.area(),
            Shape::Sphere { radius } => PI * radius * radius,
        }
    }
}

/// Whether a flat emitter shines to where the way to its center is this.
fn shines_to(to_center: DVec3, normal: Normal, is_two_sided: bool) -> bool {
    let height = -normal.get().dot(to_center);
    height > 0.0 || (is_two_sided && height < 0.0)
}

fn is_solid(center: Point, radius: f64) -> bool {
    center.0.is_finite() && radius > 0.0 && radius.is_finite()
}
