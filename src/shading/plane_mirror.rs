//! Plane mirrors: what is the same for all rays of an eye that one of them reflects.
//!
//! What leaves a plane mirror comes from the image of the eye in it, and its direction is mirrored in the one normal: this
//! is done for sixteen rays at a time, to the bits of [`leave`](super::leave).

use fearless_simd::Simd;

use super::delta::{Factor, Filter, Leaving, Surface, t_of};
use crate::math::DVec3;
use crate::optics;
use crate::simd::{DVec3x16, F64x16, LANES, ones};
use crate::visibility::{IncoherentRays, Points, RayStart, columns, vector};
use crate::world::{ChainColor, Delta, Media, World};

/// A flat surface that reflects the same share of all rays, and an eye before it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlaneMirror {
    primitive: u64,
    eye: DVec3,
    /// Its image; `None` where the surface is not as simple as that.
    image: Option<EyeImage>,
}

/// The image of an eye in a plane mirror.
#[derive(Clone, Copy, Debug)]
struct EyeImage {
    position: DVec3,
    normal: DVec3,
    weight: [f64; 3],
    color: Option<ChainColor>,
}

impl PlaneMirror {
    /// The surface that is seen at a point.
    pub(crate) fn of(world: &World, points: &Points, slot: usize, eye: DVec3) -> Self {
        let material = points.material[slot] as usize;
        let factor = world.delta(material).and_then(|delta| {
            let factor = match delta {
                Delta::Mirror(tint) if !tint.schlick => {
                    Factor::of_mirror(world, material, tint, 1.0)
                }
                Delta::Coat {
                    reflectance,
                    schlick: false,
                } => Factor::Gray(*reflectance),
                _ => return None,
            };
            match factor.apart(world)? {
                (weight, None) => Some((weight, None)),
                (weight, Some(Filter::Color(color))) => Some((weight, Some(color))),
                (_, Some(Filter::Spectrum(_))) => None,
            }
        });
        let image = factor.and_then(|(weight, color)| {
            let surface = Surface::new(world, points, slot);
            surface.is_flat.then(|| EyeImage {
                position: surface.image_of(eye),
                normal: surface.normal,
                weight,
                color,
            })
        });
        Self {
            primitive: points.primitive[slot],
            eye,
            image,
        }
    }

    /// Whether it is that of another point and eye.
    #[inline]
    pub(crate) fn is_of(&self, points: &Points, slot: usize, eye: DVec3) -> bool {
        self.primitive == points.primitive[slot] && self.eye == eye
    }

    /// What [`leave`](super::leave) says of a ray that it reflects, if it is as simple as that; `Some(None)` where none is.
    #[inline]
    pub(crate) fn reflected(
        &self,
        points: &Points,
        slot: usize,
        direction: DVec3,
        (media, nm): (Media, u16),
    ) -> Option<Option<Leaving>> {
        let EyeImage {
            position,
            normal,
            weight,
            color,
        } = self.image?;
        // An interpolated normal makes another mirror of each point.
        if vector(points.shading_normals(), slot) != vector(points.geometric_normals(), slot) {
            return None;
        }
        let to_viewer = vector(&points.to_viewer, slot);
        if optics::reflected(-to_viewer, normal).dot(normal) <= 0.0 {
            return Some(None);
        }
        let start = vector(&points.position, slot);
        Some(Some(Leaving {
            origin: position,
            direction: optics::reflected(direction, normal),
            start: RayStart {
                t: t_of(start, self.eye, direction),
                position: start,
                error: points.error[slot],
                primitive: self.primitive,
            },
            weight,
            filter: color.map(Filter::Color),
            media,
            nm,
        }))
    }

    /// What [`PlaneMirror::reflected`] says of the rays of a packet that hit something; `None` where they are not all from
    /// the eye and reflected by this mirror.
    #[inline(always)]
    pub(crate) fn reflected_packet<S: Simd>(
        &self,
        simd: S,
        points: &Points,
        rays: &IncoherentRays,
        packet: usize,
    ) -> Option<ReflectedPacket<S>> {
        let EyeImage {
            position,
            normal,
            weight,
            color,
        } = self.image?;
        // With interpolated normals they are looked at one by one.
        if !std::ptr::eq(points.shading_normals(), points.geometric_normals()) {
            return None;
        }
        let bits = points.hit[packet];
        let first = packet * LANES;
        let primitives = &points.primitive[first..first + LANES];
        if ones(bits).any(|lane| primitives[lane] != self.primitive) {
            return None;
        }
        let [origin, direction] = rays.vectors_of_packet(simd, packet);
        let [x, y, z] = [self.eye.x, self.eye.y, self.eye.z];
        let is_of_eye = origin.x.eq(F64x16::splat(simd, x))
            & origin.y.eq(F64x16::splat(simd, y))
            & origin.z.eq(F64x16::splat(simd, z));
        let normal = DVec3x16::splat(simd, normal);
        let to_viewer = DVec3x16::load(simd, columns(&points.to_viewer, packet));
        let zero = F64x16::splat(simd, 0.0);
        let is_above = reflected(-to_viewer, normal).dot(normal).gt(zero);
        let start = DVec3x16::load(simd, columns(&points.position, packet));
        let t = (start - origin).dot(direction) / direction.dot(direction);
        let is_simple = (is_of_eye & is_above & t.gt(zero)).to_bits();
        (is_simple & bits == bits).then(|| ReflectedPacket {
            origin: position,
            direction: reflected(direction, normal),
            t,
            weight,
            color,
        })
    }
}

/// [`optics::reflected`] of the rays of a packet.
#[inline(always)]
fn reflected<S: Simd>(direction: DVec3x16<S>, normal: DVec3x16<S>) -> DVec3x16<S> {
    let twice = normal.dot(direction) * 2.0;
    DVec3x16 {
        x: direction.x - normal.x * twice,
        y: direction.y - normal.y * twice,
        z: direction.z - normal.z * twice,
    }
}

/// What a plane mirror makes of the rays of a packet that hit something.
pub(crate) struct ReflectedPacket<S: Simd> {
    /// The image of their eye, from which they come.
    pub(crate) origin: DVec3,
    pub(crate) direction: DVec3x16<S>,
    /// t of the points that they leave.
    pub(crate) t: F64x16<S>,
    /// As of [`Leaving`], the same of all.
    pub(crate) weight: [f64; 3],
    pub(crate) color: Option<ChainColor>,
}
