//! Which surfaces face a light.

use fearless_simd::Simd;

use super::Points;
use crate::math::{DVec3, Point};
use crate::simd::{DVec3x16, F64x16, LANES, Mask64x16, ones};
use crate::visibility::batch::{PACKETS, columns};
use crate::visibility::primitive::Primitive;
use crate::visibility::rays::ROUNDING;
use crate::world::geometry::from_shorter_edges;
use crate::world::{Shape, World};

/// Where a light is as seen from the points of a batch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facing {
    /// One bit for each point whose surface it is above of.
    pub(crate) above: [u32; PACKETS],
    /// At how many points it is.
    pub(crate) at: u32,
}

impl Points {
    /// A box around all that are hit, from its least to its largest coordinates.
    #[inline]
    pub(crate) fn bounds(&self) -> [DVec3; 2] {
        self.bounds
    }

    /// The normals of the surfaces, to be made by hand.
    #[cfg(test)]
    pub(crate) fn geometric_normals_mut(&mut self) -> &mut [crate::visibility::Column; 3] {
        &mut self.geometric_normal
    }

    /// For all points, whether a light is above the surface: on the viewer's side of the tangent plane (of
    /// lifted points the one across the interpolated normal), further from it than rounding errors. A light in
    /// the very plane of a floor is not above it. And whether it is at the point itself (d = 0), as far as can
    /// be told.
    #[inline(always)]
    pub(crate) fn facing<S: Simd>(&self, simd: S, world: &World, light: Point) -> Facing {
        // What holds for all points of the batch will often do: a bound on the rounding of each, and a
        // light that is outside of the box around them.
        let room = F64x16::splat(simd, batch_height_error(self.largest_error, light));
        let [least, most] = self.bounds;
        let outside = (least - light.0).max(light.0 - most).max_element();
        let is_apart = outside > 2.0 * self.largest_error;
        let mut facing = Facing {
            above: [0; PACKETS],
            at: 0,
        };
        for (packet, &hit) in self.hit.iter().enumerate() {
            if hit == 0 {
                continue;
            }
            let normal = self.facing_normals(simd, packet);
            let plane = F64x16::load(simd, &self.plane[packet * LANES..]);
            let height = normal.dot_with(light.0) - plane;
            let above = height.gt(room).to_bits();
            if is_apart && (above | height.lt(-room).to_bits()) & hit == hit {
                facing.above[packet] = above & hit;
            } else {
                let (above, at) = self.facing_in(simd, world, packet, light);
                facing.above[packet] = above;
                facing.at += at.count_ones();
            }
        }
        facing
    }

    /// The points of a packet that a light is above of, and those that it is at, one bit for each.
    #[inline(never)]
    fn facing_in<S: Simd>(
        &self,
        simd: S,
        world: &World,
        packet: usize,
        light: Point,
    ) -> (u32, u32) {
        simd.vectorize(
            #[inline(always)]
            || {
                let hit = self.hit[packet];
                let lanes = packet * LANES;
                let position = DVec3x16::load(simd, columns(&self.position, packet));
                let error = F64x16::load(simd, &self.error[lanes..]);
                // Of flat shapes a point is known exactly.
                let mut flat = 0;
                let mut points = [[0.0; LANES]; 3];
                for lane in ones(hit & !self.lifts.points[packet]) {
                    if let Some(point) = flat_point(world, Primitive(self.primitive[lanes + lane]))
                    {
                        flat |= 1 << lane;
                        for axis in 0..3 {
                            points[axis][lane] = point[axis];
                        }
                    }
                }
                let is_flat = Mask64x16::from_bits(simd, flat);
                let [x, y, z] = &points;
                let tangent = is_flat.select_vectors(DVec3x16::load(simd, [x, y, z]), position);
                let known_to = is_flat.select(F64x16::splat(simd, 0.0), error);
                let to_light = -tangent.minus(light.0);
                let normal = self.facing_normals(simd, packet);
                let rounding = height_error(to_light, light);
                let is_above = normal.dot(to_light).gt(rounding + known_to);
                let offset = position.minus(light.0);
                let is_at = offset.dot(offset).le(error * error).to_bits() & hit;
                (is_above.to_bits() & hit & !is_at, is_at)
            },
        )
    }
}

/// At least √3: a vector is so many times longer than its largest component, at most.
const LENGTH_OVER_LARGEST: f64 = 2.0;

/// A bound on the rounding of n·(l − p₀), the height of a light l above a tangent plane through p₀, beside the
/// error of p₀ itself: that of the difference and of the product are below [`ROUNDING`] times |l| + |l − p₀|, n
/// being of unit length.
#[inline(always)]
fn height_error<S: Simd>(to_light: DVec3x16<S>, light: Point) -> F64x16<S> {
    let light_length = light.0.abs().max_element();
    (to_light.largest() + light_length) * (LENGTH_OVER_LARGEST * ROUNDING)
}

/// The same for all points of a batch, of which the largest error is known, and for n·l − n·p₀ in place of
/// n·(l − p₀).
///
/// Both are off by 2 [`ROUNDING`] (|l| + |l − p₀|) and the error of p₀, with |l − p₀| ≤ |l| + |p₀| and
/// |p₀| [`ROUNDING`] below the error of p: 4 [`ROUNDING`] |l| and three errors, and that twice.
#[inline(always)]
fn batch_height_error(largest_error: f64, light: Point) -> f64 {
    let light_length = light.0.abs().max_element();
    6.0 * largest_error + 8.0 * ROUNDING * light_length
}

/// A point of a flat primitive that is known exactly; `None` for a curved one.
fn flat_point(world: &World, primitive: Primitive) -> Option<DVec3> {
    let (object, triangle) = primitive.parts();
    match world.objects()[object as usize].shape {
        Shape::Sphere(_) => None,
        Shape::Plane(index) => Some(world.planes()[index].point.0),
        Shape::Disk(index) => Some(world.disks()[index].center.0),
        Shape::Mesh(_) => Some(from_shorter_edges(world.triangles().vertices(triangle))[0]),
    }
}
