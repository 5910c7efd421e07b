//! L2 and L4 for spheres: ‖r(t) − c‖² = R².

use fearless_simd::Simd;

use super::beam::Beam;
use super::bvh::Bounds;
use super::canvas::Canvas;
use super::disc::{Discs, Spheres};
use super::packet::{Nearest, Packet, Rays, Shadow};
use super::search::{Block, Shape};
use super::verdict::{Verdict, Who};
use super::{Primitive, ROUNDING};
use crate::math::{DVec3, Point, all_three};
use crate::simd::{DVec3x16, F64x16, LANES, Mask64x16, ones};
use crate::world::Sphere;

/// A sphere with its index in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
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

impl Ball {
    pub(super) fn new(sphere: &Sphere) -> Self {
        Self {
            center: sphere.center,
            radius: sphere.radius,
            object: sphere.object,
        }
    }

    pub(super) fn primitive(&self) -> Primitive {
        Primitive::whole(self.object)
    }

    /// L2 with the whole lines; `None` if none of the rays in `asked` meets the sphere. The
    /// discriminant R² − |oc − (oc·ω)ω|² and the root c/q keep their precision for a sphere that is
    /// small and far away, where b² − 4ac cancels.
    #[inline(always)]
    fn crossings<S: Simd>(
        &self,
        simd: S,
        rays: &Rays<S>,
        asked: Mask64x16<S>,
    ) -> Option<Crossings<S>> {
        let zero = F64x16::splat(simd, 0.0);
        let oc = -rays.origin.minus(self.center.0);
        let along = oc.dot(rays.direction);
        let inverse_square = F64x16::splat(simd, 1.0) / rays.square;
        let across = oc - rays.direction.times(along * inverse_square);
        let discriminant = -across.dot(across) + self.radius * self.radius;
        let exist = discriminant.ge(zero) & asked;
        if !exist.any() {
            return None;
        }
        // A ray that misses has no root; what is made of it there is not looked at.
        let root = (rays.square * discriminant.max(zero)).sqrt();
        let q = along.lt(zero).select(along - root, along + root);
        let c = match rays.shared_origin {
            Some(origin) => {
                let distance = self.center.from(Point(origin)).length();
                F64x16::splat(simd, (distance - self.radius) * (distance + self.radius))
            }
            None => {
                let distance = oc.dot(oc).sqrt();
                (distance - self.radius) * (distance + self.radius)
            }
        };
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

    /// L2: where the rays in `asked` first meet the sphere at t above 0, from outside or inside, and
    /// which of them do.
    #[inline(always)]
    pub(super) fn first_met<S: Simd>(
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
pub(super) struct Balls {
    center: [[f64; LANES]; 3],
    radius: [f64; LANES],
    object: [u32; LANES],
}

impl Balls {
    #[inline(always)]
    fn spheres<S: Simd>(&self, simd: S) -> Spheres<S> {
        let [x, y, z] = &self.center;
        Spheres {
            center: DVec3x16::load(simd, [x, y, z]),
            radius: F64x16::load(simd, &self.radius),
        }
    }
}

impl Block<Ball> for Balls {
    type Drawing = Discs;

    fn of(shapes: &[Ball], _: u32) -> Self {
        let mut balls = Self {
            center: [[0.0; LANES]; 3],
            radius: [1.0; LANES],
            object: [0; LANES],
        };
        for (place, ball) in shapes.iter().enumerate() {
            for axis in 0..3 {
                balls.center[axis][place] = ball.center.0[axis];
            }
            balls.radius[place] = ball.radius;
            balls.object[place] = ball.object;
        }
        balls
    }

    #[inline(always)]
    fn get(&self, _: &[Ball], place: usize) -> Ball {
        Ball {
            center: all_three(self.center, |column| column[place]).into(),
            radius: self.radius[place],
            object: self.object[place],
        }
    }

    fn touch(&self) {}

    #[inline(always)]
    fn near<S: Simd>(&self, simd: S, beam: &Beam) -> u32 {
        let Spheres { center, radius } = self.spheres(simd);
        beam.may_meet_spheres(simd, center, radius)
    }

    #[inline(always)]
    fn cast<S: Simd>(
        &self,
        simd: S,
        bits: u32,
        slot: u32,
        discs: &mut Discs,
        canvas: &mut Canvas,
        verdict: impl Verdict,
    ) {
        discs.draw(simd, canvas, &self.spheres(simd), bits);
        for place in ones(discs.of_interest) {
            let who = Who {
                slot: slot + place as u32,
                primitive: Primitive::whole(self.object[place]),
            };
            let is_harmless = verdict.are_all_on(who) && !discs.hides_own(place);
            let (cover, most) = (discs.extents.cover(place), discs.extents.most_within(place));
            if !is_harmless
                && !verdict.settles(canvas, who, cover, most)
                && verdict.is_ready(simd, canvas)
            {
                discs.cast(simd, place, who, canvas, verdict);
            }
        }
    }
}

impl Shape for Ball {
    type Block = Balls;

    const WIDTH: usize = LANES;

    const SLOTS: u32 = super::SPHERES;

    const IS_SKETCHED: bool = false;

    fn bounds(&self) -> Bounds {
        Bounds {
            min: self.center.0 - DVec3::splat(self.radius),
            max: self.center.0 + DVec3::splat(self.radius),
        }
    }

    #[inline(always)]
    fn intersect<S: Simd>(&self, simd: S, packet: &Packet<S>, nearest: &mut Nearest<S>) {
        if let Some((found, t)) = self.first_met(simd, &packet.rays, nearest.asked) {
            nearest.offer(simd, found, t, self.primitive());
        }
    }

    #[inline]
    fn is_beside(&self, _: &Canvas) -> bool {
        false
    }

    /// L4: whether the sphere stands strictly between the start of the ray, a light, and the
    /// point at its end.
    #[inline(always)]
    fn occlude<S: Simd>(&self, simd: S, packet: &Packet<S>, shadow: &mut Shadow<'_, S>) {
        let rays = &packet.rays;
        let light = shadow.light;
        let points = shadow.points;
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
        if (is_on & shadow.asked).any() {
            // The point is on this sphere, so no root of L2 at the point can be trusted. Where the
            // way to the light leads inwards, it leaves the sphere again unless the light is
            // inside; where it leads outwards, it never comes back.
            if light_distance - self.radius > at_light {
                let inwards = outwards.dot(rays.direction).is_positive();
                shadow.hide(is_on & inwards);
            }
        }
        if let Some(Crossings {
            exist,
            first,
            second,
        }) = self.crossings(simd, rays, shadow.asked & !is_on)
        {
            let hidden =
                is_between(simd, first, rays, at_light) | is_between(simd, second, rays, at_light);
            shadow.hide(exist & hidden);
        }
    }
}

/// Where t is before the point at 1, and after the light: t > at_light / |ω|.
#[inline(always)]
fn is_between<S: Simd>(simd: S, t: F64x16<S>, rays: &Rays<S>, at_light: f64) -> Mask64x16<S> {
    let after = (t * t * rays.square).gt(F64x16::splat(simd, at_light * at_light));
    t.is_positive() & after & t.lt(F64x16::splat(simd, 1.0))
}
