//! L2 and L4 for disks: n · (r(t) − c) = 0 and ‖r(t) − c‖ ≤ R. They are planes with an end, by the rules of planes.

mod setup;

use fearless_simd::Simd;

use super::plane;
use crate::math::DVec3;
use crate::simd::{DVec3x16, F64x16, Mask64x16};
use crate::visibility::primitive::Primitive;
use crate::visibility::question::{NearestHit, Occlusion, SegmentEnds};
use crate::visibility::rays::{ROUNDING, Rays};
use crate::world::Disk;
pub(in crate::visibility) use setup::rasterize_disks;

/// Which points, given as offsets from the center, are no further from it than the rim.
#[inline(always)]
fn is_within<S: Simd>(simd: S, disk: &Disk, offset: DVec3x16<S>) -> Mask64x16<S> {
    let square = F64x16::splat(simd, disk.radius * disk.radius);
    offset.dot(offset).le(square)
}

/// L2: where the rays meet the disk, if they do so at t above 0.
#[inline(always)]
pub(in crate::visibility) fn intersect<S: Simd>(
    simd: S,
    disk: &Disk,
    rays: &Rays<S>,
    nearest: &mut NearestHit<S>,
) {
    let t = plane::met(&disk.plane(), rays);
    let may_be_nearer = t.is_positive() & t.le(nearest.t) & nearest.asked;
    if !may_be_nearer.any() {
        return;
    }
    // A ray along the disk gives an infinite or NaN t, with which nothing is within.
    let offset = rays.origin.minus(disk.center.0) + rays.direction.times(t);
    let found = may_be_nearer & is_within(simd, disk, offset);
    nearest.offer(simd, found, t, Primitive::whole(disk.object));
}

/// L4: whether the disk stands strictly between a light and points.
#[inline(always)]
pub(in crate::visibility) fn occlude<S: Simd>(
    simd: S,
    disk: &Disk,
    occlusion: &mut Occlusion<'_, S>,
) {
    let light = SegmentEnds {
        position: DVec3x16::splat(simd, occlusion.light.0),
        error: F64x16::splat(simd, 0.0),
        primitive: Primitive(u64::MAX).lanes(simd),
    };
    let hidden = is_between(simd, disk, &light, occlusion.points);
    occlusion.hide(hidden);
}

/// L4: which segments the disk stands in the way of: their ends are on different sides of its plane, each further
/// from it than its rounding error, and they come through it within the rim.
#[inline(always)]
pub(in crate::visibility) fn is_between<S: Simd>(
    simd: S,
    disk: &Disk,
    start: &SegmentEnds<S>,
    end: &SegmentEnds<S>,
) -> Mask64x16<S> {
    let is_between = plane::is_between(simd, &disk.plane(), start, end);
    if !is_between.any() {
        return is_between;
    }
    let normal = disk.normal.get();
    let to_start = start.position.minus(disk.center.0);
    let to_end = end.position.minus(disk.center.0);
    let start_height = to_start.dot_with(normal).abs();
    let end_height = to_end.dot_with(normal).abs();
    // The mean of both ends, which is on the segment however much rounding takes from the heights, and the same to
    // and fro.
    let sum = to_start.times(end_height) + to_end.times(start_height);
    let one = F64x16::splat(simd, 1.0);
    let offset = sum.times(one / (start_height + end_height));
    is_between & is_within(simd, disk, offset)
}

/// Whether it is certain that the disk is beside a box around segments, to the last digit of what f64 makes of them.
#[inline(always)]
pub(in crate::visibility) fn is_beside(disk: &Disk, [least, most]: [DVec3; 2]) -> bool {
    let center = disk.center.0;
    let size = (least - center).abs().max((most - center).abs());
    let reach = disk.radius * (1.0 + ROUNDING) + size.max_element() * ROUNDING;
    let beside = (least - center).max(center - most);
    beside.max_element() > reach
}
