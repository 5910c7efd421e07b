//! L2 and L4 for spheres: ‖r(t) − c‖² = R².

mod conic;
mod leaving;
mod single;

use fearless_simd::Simd;

use super::{Block, Shape};
use crate::math::{DVec3, Point, all_three};
use crate::simd::{DVec3x16, F64x16, LANES, Mask64x16, ones};
use crate::visibility::primitive::{Primitive, SPHERES, ShapeId};
use crate::visibility::projection::{BatchProjection, DepthTest};
use crate::visibility::question::{NearestHit, Occlusion};
use crate::visibility::rays::{ROUNDING, Rays, ShearedRays};
use crate::visibility::tree::{Beam, Bounds};
use crate::world;
use conic::{ProjectedConics, SphereLanes};

/// A sphere with its index in the world.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct Sphere {
    center: Point,
    radius: f64,
    object: u32,
}

/// Both parameters at which a line meets a sphere, the nearer first.
struct Crossings<S: Simd> {
    exist: Mask64x16<S>,
    first: F64x16<S>,
    second: F64x16<S>,
}

/// L2 with the whole lines, each before its sphere: `oc` from the starts to the centers, and `distance` how
/// long that is; `None` if none of those in `asked` meets it. The discriminant R² − |oc − (oc·ω)ω|² and the
/// root c/q keep their precision for a sphere that is small and far away, where b² − 4ac cancels.
#[inline(always)]
fn crossings<S: Simd>(
    simd: S,
    oc: DVec3x16<S>,
    radius: F64x16<S>,
    rays: &Rays<S>,
    asked: Mask64x16<S>,
    distance: impl FnOnce() -> F64x16<S>,
) -> Option<Crossings<S>> {
    let zero = F64x16::splat(simd, 0.0);
    let along = oc.dot(rays.direction);
    let inverse_square = F64x16::splat(simd, 1.0) / rays.square;
    let across = oc - rays.direction.times(along * inverse_square);
    let discriminant = -across.dot(across) + radius * radius;
    let exist = discriminant.ge(zero) & asked;
    if !exist.any() {
        return None;
    }
    // A ray that misses has no root; what is made of it there is not looked at.
    let root = (rays.square * discriminant.max(zero)).sqrt();
    let q = along.lt(zero).select(along - root, along + root);
    let distance = distance();
    let c = (distance - radius) * (distance + radius);
    // q is 0 only for a ray that starts on the sphere and touches it there.
    let touches = q.eq(zero);
    let a = touches.select(zero, q * inverse_square);
    let b = touches.select(zero, c / q);
    Some(Crossings {
        exist,
        first: a.min(b),
        second: b.max(a),
    })
}

impl Sphere {
    pub(in crate::visibility) fn new(sphere: &world::Sphere) -> Self {
        Self {
            center: sphere.center,
            radius: sphere.radius,
            object: sphere.object,
        }
    }

    pub(in crate::visibility) fn primitive(&self) -> Primitive {
        Primitive::whole(self.object)
    }

    pub(in crate::visibility) fn center_and_radius(&self) -> (DVec3, f64) {
        (self.center.0, self.radius)
    }

    /// L2 with the whole lines; `None` if none of the rays in `asked` meets the sphere.
    #[inline(always)]
    fn crossings<S: Simd>(
        &self,
        simd: S,
        rays: &Rays<S>,
        asked: Mask64x16<S>,
    ) -> Option<Crossings<S>> {
        let oc = -rays.origin.minus(self.center.0);
        let radius = F64x16::splat(simd, self.radius);
        crossings(
            simd,
            oc,
            radius,
            rays,
            asked,
            #[inline(always)]
            || match rays.shared_origin {
                Some(origin) => F64x16::splat(simd, self.center.from(Point(origin)).length()),
                None => oc.dot(oc).sqrt(),
            },
        )
    }

    /// L2: where the rays in `asked` first meet the sphere at t above 0, from outside or inside, and
    /// which of them do.
    #[inline(always)]
    pub(in crate::visibility) fn first_met<S: Simd>(
        &self,
        simd: S,
        rays: &Rays<S>,
        asked: Mask64x16<S>,
    ) -> Option<(Mask64x16<S>, F64x16<S>)> {
        let Crossings {
            exist,
            first,
            second,
        } = self.crossings(simd, rays, asked)?;
        let t = first.is_positive().select(first, second);
        Some((exist & t.is_positive(), t))
    }
}

/// Sixteen spheres or fewer, side by side.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(in crate::visibility) struct SphereBlock {
    center: [[f64; LANES]; 3],
    radius: [f64; LANES],
    object: [u32; LANES],
}

impl SphereBlock {
    #[inline(always)]
    fn spheres<S: Simd>(&self, simd: S) -> SphereLanes<S> {
        let [x, y, z] = &self.center;
        SphereLanes {
            center: DVec3x16::load(simd, [x, y, z]),
            radius: F64x16::load(simd, &self.radius),
        }
    }
}

impl Block<Sphere> for SphereBlock {
    type Setup = ProjectedConics;

    fn of(shapes: &[Sphere], _: u32) -> Self {
        let mut block = Self {
            center: [[0.0; LANES]; 3],
            radius: [1.0; LANES],
            object: [0; LANES],
        };
        for (place, sphere) in shapes.iter().enumerate() {
            for axis in 0..3 {
                block.center[axis][place] = sphere.center.0[axis];
            }
            block.radius[place] = sphere.radius;
            block.object[place] = sphere.object;
        }
        block
    }

    #[inline(always)]
    fn get(&self, (): &(), place: usize) -> Sphere {
        Sphere {
            center: all_three(self.center, |column| column[place]).into(),
            radius: self.radius[place],
            object: self.object[place],
        }
    }

    #[inline(always)]
    fn primitive(&self, place: usize) -> Primitive {
        Primitive::whole(self.object[place])
    }

    fn touch(&self) {}

    #[inline(always)]
    fn near<S: Simd>(&self, simd: S, beam: &Beam) -> u32 {
        let SphereLanes { center, radius } = self.spheres(simd);
        let center = center.minus(beam.center());
        let mut bits = u32::MAX;
        for plane in &beam.planes() {
            let reach = center.dot_with(plane.normal) + radius * plane.size();
            bits &= reach.ge(F64x16::splat(simd, plane.offset)).to_bits();
        }
        bits
    }

    #[inline(always)]
    fn rasterize<S: Simd>(
        &self,
        simd: S,
        bits: u32,
        slot: u32,
        conics: &mut ProjectedConics,
        projection: &mut BatchProjection,
        depth_test: impl DepthTest,
    ) {
        conics.set_up(simd, projection, &self.spheres(simd), bits);
        for place in ones(conics.of_interest) {
            let id = ShapeId {
                slot: slot + place as u32,
                primitive: self.primitive(place),
            };
            let is_harmless = depth_test.are_all_on(id) && !conics.hides_own(place);
            let (cover, most) = (
                conics.extents.cover(place),
                conics.extents.most_within(place),
            );
            if !is_harmless
                && !depth_test.resolves_whole(projection, id, cover, most)
                && depth_test.ensure_projected(simd, projection)
            {
                conics.rasterize(simd, place, id, projection, depth_test);
            }
        }
    }
}

impl Shape for Sphere {
    type Block = SphereBlock;

    /// In the blocks.
    type Exact = ();

    const WIDTH: usize = LANES;

    const SLOTS: u32 = SPHERES;

    fn bounds(&self) -> Bounds {
        Bounds {
            min: self.center.0 - DVec3::splat(self.radius),
            max: self.center.0 + DVec3::splat(self.radius),
        }
    }

    #[inline(always)]
    fn intersect<S: Simd>(&self, simd: S, packet: &ShearedRays<S>, nearest: &mut NearestHit<S>) {
        if let Some((found, t)) = self.first_met(simd, &packet.rays, nearest.asked) {
            nearest.offer(simd, found, t, self.primitive());
        }
    }

    #[inline]
    fn is_beside(&self, _: &BatchProjection) -> bool {
        false
    }

    /// L4: whether the sphere stands strictly between the start of the ray, a light, and the
    /// point at its end.
    #[inline(always)]
    fn occlude<S: Simd>(&self, simd: S, packet: &ShearedRays<S>, occlusion: &mut Occlusion<'_, S>) {
        let rays = &packet.rays;
        let light = occlusion.light;
        let points = occlusion.points;
        let outwards = points.position.minus(self.center.0);
        let distance_square = outwards.dot(outwards);
        let light_distance = light.from(self.center).length();
        // A light on the sphere itself is not occluded by the surface that it is on.
        let at_light = ROUNDING * (light_distance + self.radius + light.0.length());
        let is_own = points
            .primitive
            .eq(Primitive::whole(self.object).lanes(simd));
        // | |p − c| − R | within the rounding error, without the root: |p − c|² − R² is that times
        // |p − c| + R, and the sum of the components' magnitudes is at least the length.
        let reach = outwards.taxicab() + self.radius;
        let at_point = points.error + reach * ROUNDING;
        let off = (distance_square - self.radius * self.radius).abs();
        let is_on = is_own | off.le(at_point * reach);
        if (is_on & occlusion.asked).any() {
            // The point is on this sphere, so no root of L2 at the point can be trusted. Where the
            // way to the light leads inwards, it leaves the sphere again unless the light is
            // inside; where it leads outwards, it never comes back.
            if light_distance - self.radius > at_light {
                let inwards = outwards.dot(rays.direction).is_positive();
                occlusion.hide(is_on & inwards);
            }
        }
        if let Some(Crossings {
            exist,
            first,
            second,
        }) = self.crossings(simd, rays, occlusion.asked & !is_on)
        {
            let at_light = F64x16::splat(simd, at_light);
            let hidden =
                is_between(simd, first, rays, at_light) | is_between(simd, second, rays, at_light);
            occlusion.hide(exist & hidden);
        }
    }
}

/// Where t is before the point at 1, and after the light: t > at_light / |ω|.
#[inline(always)]
fn is_between<S: Simd>(simd: S, t: F64x16<S>, rays: &Rays<S>, at_light: F64x16<S>) -> Mask64x16<S> {
    let after = (t * t * rays.square).gt(at_light * at_light);
    t.is_positive() & after & t.lt(F64x16::splat(simd, 1.0))
}
