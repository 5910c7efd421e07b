//! Planes on a [`Canvas`]: their closeness is one affine function of x and y.

use fearless_simd::Simd;

use crate::math::DVec3;
use crate::simd::{F32x16, Mask32x16, ones};
use crate::visibility::primitive::Who;
use crate::visibility::projection::{
    Affine, CLOSENESS, Canvas, Claim, Extent, GIVES_WAY, NEGLIGIBLE, NOISE, Shared, Start, State,
    Verdict,
};

/// Puts an endless plane through `point` on the canvas.
#[inline(always)]
pub(in crate::visibility) fn cast_plane<S: Simd>(
    simd: S,
    point: DVec3,
    normal: DVec3,
    who: Who,
    canvas: &mut Canvas,
    verdict: impl Verdict,
) {
    if canvas.is_beside(point, normal) || verdict.are_all_on(who) {
        return;
    }
    if let Shared::Direction(start) = canvas.shared {
        cast_parallel(simd, point, normal, start, who, canvas, verdict);
        return;
    }
    let to_point = point - canvas.origin;
    let height = normal.dot(to_point);
    let [u, v, w] = canvas.axes;
    let scale = canvas.unit / height;
    let (x, y, z) = (
        u.dot(normal) * scale,
        v.dot(normal) * scale,
        w.dot(normal) * scale,
    );
    let [extent_x, extent_y] = canvas.extent;
    let magnitude = x.abs() * extent_x + y.abs() * extent_y + z.abs();
    let is_told = height.abs() > to_point.length() * NEGLIGIBLE + canvas.error / NEGLIGIBLE
        && (1.0 / CLOSENESS..CLOSENESS).contains(&magnitude);
    let sides = x.abs() * extent_x + y.abs() * extent_y + magnitude * (2.0 * f64::from(GIVES_WAY));
    let range = [(z - sides) as f32, (z + sides) as f32];
    let cover = (is_told && range[0] > 0.0).then_some(range);
    let most = if is_told { range[1] } else { f32::INFINITY };
    let is_behind = canvas.state == State::Aimed && most < 0.0;
    let is_settled = is_behind || verdict.settles(canvas, who, cover, most);
    if is_settled || !verdict.is_ready(simd, canvas) {
        return;
    }
    let closeness = Affine([z as f32, x as f32, y as f32]);
    let error = F32x16::splat(simd, magnitude as f32 * GIVES_WAY);
    let plane = is_told.then_some((closeness, error));
    claim_everywhere(simd, plane, who, canvas, verdict);
}

/// [`cast_plane`] before parallel rays.
#[inline(always)]
fn cast_parallel<S: Simd>(
    simd: S,
    point: DVec3,
    normal: DVec3,
    start: Start,
    who: Who,
    canvas: &mut Canvas,
    verdict: impl Verdict,
) {
    let [u, v, w] = canvas.axes;
    // Exactly along the plane, f64 finds no way to it either.
    if w * normal == DVec3::ZERO {
        return;
    }
    let over_unit = 1.0 / canvas.unit;
    let to_point = (point - canvas.origin) * over_unit;
    let over_slope = 1.0 / w.dot(normal);
    let (x, y, z) = (
        u.dot(normal) * over_slope,
        v.dot(normal) * over_slope,
        -normal.dot(to_point) * over_slope,
    );
    let [extent_x, extent_y] = canvas.extent;
    let magnitude = x.abs() * extent_x + y.abs() * extent_y + z.abs();
    // What f64 may be off on the way from the start to the plane.
    let distance = to_point.length() + start.depth.abs() * over_unit + 2.0;
    let noise = distance * over_slope.abs() * f64::from(NOISE);
    let error = magnitude * f64::from(GIVES_WAY) + noise;
    let is_told = over_slope.abs() * NEGLIGIBLE < 1.0 && magnitude + error < CLOSENESS;
    let closeness = Affine([z as f32, x as f32, y as f32]);
    let error = F32x16::splat(simd, error as f32);
    let plane = is_told.then_some((closeness, error));
    claim_everywhere(simd, plane, who, canvas, verdict);
}

/// Puts a plane on the canvas: its closeness and how far that may be off, `None` if it cannot be told.
#[inline(always)]
fn claim_everywhere<S: Simd>(
    simd: S,
    plane: Option<(Affine, F32x16<S>)>,
    who: Who,
    canvas: &mut Canvas,
    verdict: impl Verdict,
) {
    let all = Mask32x16::from_bits(simd, u32::from(u16::MAX));
    let packets = canvas.meets(simd, &Extent::EVERYTHING);
    for packet in ones(packets) {
        let Some((closeness, error)) = plane else {
            verdict.abstain(simd, canvas, packet, who);
            continue;
        };
        let closeness = closeness.at(simd, canvas.dots(simd, packet));
        let maybe = match canvas.shared {
            // Behind the point a plane is of negative closeness.
            Shared::Point => closeness.ge(F32x16::splat(simd, 0.0) - error),
            Shared::Direction(_) => all,
        };
        let claim = Claim {
            maybe,
            surely: all,
            least: closeness - error,
            most: closeness + error,
        };
        let claim = canvas.ahead(simd, claim);
        verdict.hear(simd, canvas, packet, who, claim);
    }
}
