//! Where the shadow rays of smooth meshes start that say `shadow_terminator = "hanika"`.
//!
//! Between its vertices a smooth mesh stands for a surface that its triangles are below of, or above. Where
//! they are below, a shadow ray from p on the triangle is hidden by the neighbors although n·ω_i is
//! above 0: in steps, triangle by triangle. So it starts from p projected onto the tangent planes of
//! the vertices, by barycentric coordinates,
//!
//! p′ = p + Σ bᵢ max(0, (vᵢ − p)·nᵢ) nᵢ
//!
//! (Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II, 2021, chapter 4). Only V is that of p′: d, ω_i
//! and all cosines stay those of p, and what is lit has the radiance that it had. The tangent plane that
//! a light has to be above of is the one across the interpolated normal. As anywhere, a triangle does
//! not hide its own points, and others do where p′ and the light are clearly on different sides.

use fearless_simd::Simd;

use super::Points;
use crate::math::DVec3;
use crate::simd::{DVec3x16, F64x16, LANES, Mask64x16};
use crate::visibility::batch::{Column, PACKETS, columns, columns_mut, ranges};
use crate::visibility::rays::ROUNDING;

/// How far a lift is off, over its reach, which bounds every term of it: twice what a few operations are, for the
/// scalar products and their sum over the vertices.
const LIFT_ROUNDING: f64 = 2.0 * ROUNDING;

/// Where the shadow rays of a batch start.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct Starts<'p> {
    pub(in crate::visibility) position: &'p [Column; 3],
    /// A bound on the rounding error of each.
    pub(in crate::visibility) error: &'p Column,
    /// The largest of them, and the box around the positions.
    pub(in crate::visibility) largest_error: f64,
    pub(in crate::visibility) bounds: [DVec3; 2],
}

/// The points of a batch whose shadow rays do not start at p.
#[derive(Clone, Debug)]
pub(in crate::visibility) struct Lifts {
    /// For each packet one bit for each.
    pub(in crate::visibility) points: [u32; PACKETS],
    /// Whether there are any; the rest means something only then.
    pub(in crate::visibility) are_any: bool,
    /// Where the shadow rays of all points of the batch start.
    start: [Column; 3],
    error: Column,
    largest_error: f64,
    bounds: [DVec3; 2],
}

impl Default for Lifts {
    fn default() -> Self {
        Self {
            points: [0; PACKETS],
            are_any: false,
            start: [Column::ZERO; 3],
            error: Column::ZERO,
            largest_error: 0.0,
            bounds: [DVec3::ZERO; 2],
        }
    }
}

impl Lifts {
    /// Forgets all points.
    pub(in crate::visibility) fn begin(&mut self) {
        (self.points, self.are_any) = ([0; PACKETS], false);
    }
}

impl Points {
    /// Where shadow rays start: at p, or off it.
    #[inline(always)]
    pub(in crate::visibility) fn starts(&self) -> Starts<'_> {
        let lifts = &self.lifts;
        if lifts.are_any {
            Starts {
                position: &lifts.start,
                error: &lifts.error,
                largest_error: lifts.largest_error,
                bounds: lifts.bounds,
            }
        } else {
            Starts {
                position: &self.position,
                error: &self.error,
                largest_error: self.largest_error,
                bounds: self.bounds,
            }
        }
    }

    /// n of the tangent plane that a light has to be above of.
    #[inline(always)]
    pub(in crate::visibility) fn facing_normals<S: Simd>(
        &self,
        simd: S,
        packet: usize,
    ) -> DVec3x16<S> {
        let geometric = DVec3x16::load(simd, columns(&self.geometric_normal, packet));
        match self.lifts.points[packet] {
            0 => geometric,
            bits => {
                let shading = DVec3x16::load(simd, columns(&self.shading_normal, packet));
                Mask64x16::from_bits(simd, bits).select_vectors(shading, geometric)
            }
        }
    }

    /// Lifts the points of a packet with a bit: by the corners of their triangles, the normals there and the
    /// barycentric coordinates.
    ///
    /// p is off by its error, and so is each (vᵢ − p)·nᵢ, which the bᵢ only average: twice the error, and
    /// what rounding makes of the offsets to the corners. (Coordinates bᵢ that are off belong to a point
    /// nearby on the triangle.)
    #[inline(never)]
    pub(in crate::visibility) fn lift<S: Simd>(
        &mut self,
        simd: S,
        packet: usize,
        bits: u32,
        corners: &[DVec3x16<S>; 3],
        normals: &[DVec3x16<S>; 3],
        weights: &[F64x16<S>; 3],
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.lift_all(simd, packet, bits, corners, normals, weights),
        );
    }

    #[inline(always)]
    fn lift_all<S: Simd>(
        &mut self,
        simd: S,
        packet: usize,
        bits: u32,
        corners: &[DVec3x16<S>; 3],
        normals: &[DVec3x16<S>; 3],
        weights: &[F64x16<S>; 3],
    ) {
        if bits == 0 {
            return;
        }
        let first = packet * LANES;
        let is_lifted = Mask64x16::from_bits(simd, bits);
        let position = DVec3x16::load(simd, columns(&self.position, packet));
        let error = F64x16::load(simd, &self.error[first..]);
        let Lifted { start, reach } = lifted(simd, position, corners, normals, weights);
        let start_error = error * 2.0 + reach * LIFT_ROUNDING;
        let start = is_lifted.select_vectors(start, position);
        start.store(columns_mut(&mut self.lifts.start, packet));
        let start_error = is_lifted.select(start_error, error);
        start_error.store(&mut self.lifts.error[first..]);
        let shading = DVec3x16::load(simd, columns(&self.shading_normal, packet));
        let plane = F64x16::load(simd, &self.plane[first..]);
        let plane = is_lifted.select(shading.dot(position), plane);
        plane.store(&mut self.plane[first..]);
        self.lifts.points[packet] = bits;
        self.lifts.are_any = true;
    }

    /// Has the points of packets without any that is lifted start where they are.
    fn stay(&mut self) {
        let lifts = &mut self.lifts;
        for (packet, &hit) in self.hit.iter().enumerate() {
            if hit == 0 || lifts.points[packet] != 0 {
                continue;
            }
            let lanes = packet * LANES..(packet + 1) * LANES;
            for (start, position) in lifts.start.iter_mut().zip(&self.position) {
                start[lanes.clone()].copy_from_slice(&position[lanes.clone()]);
            }
            lifts.error[lanes.clone()].copy_from_slice(&self.error[lanes]);
        }
    }

    /// Knows where all shadow rays start, of which some are lifted.
    #[inline(never)]
    pub(in crate::visibility) fn end_lifted<S: Simd>(&mut self, simd: S) {
        self.stay();
        (self.lifts.largest_error, self.lifts.bounds) = simd.vectorize(
            #[inline(always)]
            || self.around(simd, &self.lifts.start, &self.lifts.error),
        );
    }

    /// The largest of the errors where a ray hits something, and the box around the positions.
    #[inline(always)]
    pub(in crate::visibility) fn around<S: Simd>(
        &self,
        simd: S,
        position: &[Column; 3],
        error: &Column,
    ) -> (f64, [DVec3; 2]) {
        let zero = F64x16::splat(simd, 0.0);
        let mut largest = zero;
        for (packet, &hit) in self.hit.iter().enumerate() {
            if hit == 0 {
                continue;
            }
            let is_hit = Mask64x16::from_bits(simd, hit);
            let errors = F64x16::load(simd, &error[packet * LANES..]);
            largest = is_hit.select(errors, zero).max(largest);
        }
        let ranges = ranges(
            simd,
            #[inline(always)]
            |packet| self.hit[packet],
            #[inline(always)]
            |packet| DVec3x16::load(simd, columns(position, packet)),
        );
        (largest.largest(), ranges.unwrap_or([DVec3::ZERO; 2]))
    }
}

/// p′, and how far the corners are from p.
struct Lifted<S: Simd> {
    start: DVec3x16<S>,
    reach: F64x16<S>,
}

/// p′ = p + Σ bᵢ max(0, (vᵢ − p)·nᵢ) nᵢ
#[inline(always)]
fn lifted<S: Simd>(
    simd: S,
    position: DVec3x16<S>,
    corners: &[DVec3x16<S>; 3],
    normals: &[DVec3x16<S>; 3],
    weights: &[F64x16<S>; 3],
) -> Lifted<S> {
    let zero = F64x16::splat(simd, 0.0);
    let mut lift = DVec3x16::splat(simd, DVec3::ZERO);
    let mut reach = zero;
    for corner in 0..3 {
        let offset = corners[corner] - position;
        let height = offset.dot(normals[corner]).max(zero);
        lift = lift + normals[corner].times(weights[corner] * height);
        // The sum of the components' magnitudes is at least the length.
        reach = reach + weights[corner] * offset.taxicab();
    }
    Lifted {
        start: position + lift,
        reach,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Kernel, SimdLevel};

    /// A point of a triangle with vertex normals.
    #[derive(Clone, Copy, Debug)]
    struct Hit {
        corners: [DVec3; 3],
        normals: [DVec3; 3],
        weights: [f64; 3],
    }

    impl Hit {
        fn position(&self) -> DVec3 {
            let [a, b, c] = self.corners;
            let [u, v, w] = self.weights;
            a * u + b * v + c * w
        }

        /// p projected onto the tangent planes that are above it, one ray at a time.
        fn start(&self) -> DVec3 {
            let p = self.position();
            let mut lift = DVec3::ZERO;
            for (i, normal) in self.normals.into_iter().enumerate() {
                let height = (self.corners[i] - p).dot(normal);
                lift += normal * (self.weights[i] * if height > 0.0 { height } else { 0.0 });
            }
            p + lift
        }
    }

    struct Lift<'h>(&'h [Hit; LANES]);

    impl Kernel for Lift<'_> {
        type Output = [DVec3; LANES];

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Self::Output {
            let Self(hits) = self;
            let load = |vector: &dyn Fn(&Hit) -> DVec3| {
                let axes = [0, 1, 2].map(|axis| hits.each_ref().map(|hit| vector(hit)[axis]));
                let [x, y, z] = &axes;
                DVec3x16::load(simd, [x, y, z])
            };
            let corners = [0, 1, 2].map(|corner: usize| load(&|hit| hit.corners[corner]));
            let normals = [0, 1, 2].map(|corner: usize| load(&|hit| hit.normals[corner]));
            let weights = [0, 1, 2].map(|corner: usize| {
                F64x16::load(simd, &hits.each_ref().map(|hit| hit.weights[corner]))
            });
            let position = load(&Hit::position);
            let Lifted { start, .. } = lifted(simd, position, &corners, &normals, &weights);
            let [x, y, z] = [start.x.to_array(), start.y.to_array(), start.z.to_array()];
            std::array::from_fn(|lane| DVec3::new(x[lane], y[lane], z[lane]))
        }
    }

    /// Vertices and normals of the unit circle's arc from −θ to θ, drawn out along z; the point halfway.
    fn arc(angle: f64, sign: f64) -> Hit {
        let (sin, cos) = angle.sin_cos();
        let [left, right] = [-sin, sin].map(|x| DVec3::new(x, cos, 0.0));
        Hit {
            corners: [left - DVec3::Z, right - DVec3::Z, right + DVec3::Z],
            normals: [left * sign, right * sign, right * sign],
            weights: [0.5, 0.25, 0.25],
        }
    }

    /// The middle of a chord is sin²θ below both tangent planes: it goes cos θ sin²θ up. From within
    /// the circle the planes are below it, and it stays.
    #[test]
    fn the_middle_of_a_chord_rises_above_the_circle() {
        for angle in [0.5_f64, 0.1, 1e-3, 1e-6] {
            let (sin, cos) = angle.sin_cos();
            let outside = arc(angle, 1.0);
            let rise = outside.start() - outside.position();
            let expected = DVec3::Y * (cos * sin * sin);
            assert!((rise - expected).length() < 1e-15, "{angle} {rise}");
            let inside = arc(angle, -1.0);
            assert_eq!(inside.start(), inside.position());
        }
    }

    /// At a corner, and where the normals are those of the triangle, nothing is lifted.
    #[test]
    fn corners_and_flat_triangles_stay() {
        for index in 0..3 {
            let mut weights = [0.0; 3];
            weights[index] = 1.0;
            let hit = Hit {
                weights,
                ..arc(0.3, 1.0)
            };
            assert_eq!(hit.start(), hit.corners[index]);
        }
        let flat = Hit {
            corners: [DVec3::ZERO, DVec3::X, DVec3::Y],
            normals: [DVec3::Z; 3],
            weights: [0.25, 0.25, 0.5],
        };
        assert_eq!(flat.start(), flat.position());
    }

    #[test]
    fn every_instruction_set_gives_the_bits_of_one_ray_at_a_time() {
        let scattered = |index: usize| ((index as f64 + 1.0) * 0.618_033_988_749_894_9).fract();
        let vector = |index: usize| {
            DVec3::from_array([0, 1, 2].map(|axis| scattered(3 * index + axis) * 2.0 - 1.0))
        };
        for size in [1.0, 1e-9, 1e-30, 1e30] {
            for round in 0..50 {
                let hits = std::array::from_fn(|lane| {
                    let first = (round * LANES + lane) * 7;
                    let [u, v] = [6, 20].map(|next| scattered(first + next) * 0.5);
                    Hit {
                        corners: [0, 1, 2].map(|next| vector(first + next) * size),
                        normals: [3, 4, 5].map(|next| vector(first + next).normalize()),
                        weights: [1.0 - u - v, u, v],
                    }
                });
                for (name, level) in SimdLevel::available() {
                    for (hit, found) in hits.iter().zip(level.run(Lift(&hits))) {
                        let bits = |vector: DVec3| vector.to_array().map(f64::to_bits);
                        assert_eq!(bits(found), bits(hit.start()), "{name} {hit:?}");
                    }
                }
            }
        }
    }
}
