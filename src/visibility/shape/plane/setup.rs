//! Planes on a [`BatchProjection`]: their reciprocal depth is one affine function of x and y.

use fearless_simd::Simd;

use crate::math::DVec3;
use crate::simd::{F32x16, Mask32x16, ones};
use crate::visibility::primitive::ShapeId;
use crate::visibility::projection::{
    Affine, BatchProjection, DepthTest, Extent, Fragments, NEGLIGIBLE, NOISE, POLYNOMIAL_ERROR,
    RECIPROCAL_DEPTH_LIMIT, Shared, Start, State,
};

/// Rasterizes an endless plane through `point`.
#[inline(always)]
pub(in crate::visibility) fn rasterize_plane<S: Simd>(
    simd: S,
    point: DVec3,
    normal: DVec3,
    id: ShapeId,
    projection: &mut BatchProjection,
    depth_test: impl DepthTest,
) {
    if projection.is_beside(point, normal) || depth_test.are_all_on(id) {
        return;
    }
    if let Shared::Direction(start) = projection.shared {
        rasterize_parallel(simd, point, normal, start, id, projection, depth_test);
        return;
    }
    let to_point = point - projection.origin;
    let height = normal.dot(to_point);
    let [u, v, w] = projection.axes;
    let scale = projection.unit / height;
    let (x, y, z) = (
        u.dot(normal) * scale,
        v.dot(normal) * scale,
        w.dot(normal) * scale,
    );
    let [extent_x, extent_y] = projection.extent;
    let magnitude = x.abs() * extent_x + y.abs() * extent_y + z.abs();
    let is_told = height.abs() > to_point.length() * NEGLIGIBLE + projection.error / NEGLIGIBLE
        && (1.0 / RECIPROCAL_DEPTH_LIMIT..RECIPROCAL_DEPTH_LIMIT).contains(&magnitude);
    let sides =
        x.abs() * extent_x + y.abs() * extent_y + magnitude * (2.0 * f64::from(POLYNOMIAL_ERROR));
    let range = [(z - sides) as f32, (z + sides) as f32];
    let cover = (is_told && range[0] > 0.0).then_some(range);
    let most = if is_told { range[1] } else { f32::INFINITY };
    let is_behind = projection.state == State::Bounded && most < 0.0;
    let is_resolved = is_behind || depth_test.resolves_whole(projection, id, cover, most);
    if is_resolved || !depth_test.ensure_projected(simd, projection) {
        return;
    }
    let reciprocal_depth = Affine([z as f32, x as f32, y as f32]);
    let error = F32x16::splat(simd, magnitude as f32 * POLYNOMIAL_ERROR);
    let plane = is_told.then_some((reciprocal_depth, error));
    cover_everywhere(simd, plane, id, projection, depth_test);
}

/// [`rasterize_plane`] before parallel rays.
#[inline(always)]
fn rasterize_parallel<S: Simd>(
    simd: S,
    point: DVec3,
    normal: DVec3,
    start: Start,
    id: ShapeId,
    projection: &mut BatchProjection,
    depth_test: impl DepthTest,
) {
    let [u, v, w] = projection.axes;
    // Exactly along the plane, f64 finds no way to it either.
    if w * normal == DVec3::ZERO {
        return;
    }
    let over_unit = 1.0 / projection.unit;
    let to_point = (point - projection.origin) * over_unit;
    let over_slope = 1.0 / w.dot(normal);
    let (x, y, z) = (
        u.dot(normal) * over_slope,
        v.dot(normal) * over_slope,
        -normal.dot(to_point) * over_slope,
    );
    let [extent_x, extent_y] = projection.extent;
    let magnitude = x.abs() * extent_x + y.abs() * extent_y + z.abs();
    // What f64 may be off on the way from the start to the plane. What hides an end is further from it than that is
    // off, which is more than its rounding.
    let distance = to_point.length() + start.distance * over_unit + 2.0;
    let of_ends = 2.0 * projection.error * over_unit;
    let noise = (distance * f64::from(NOISE) + of_ends) * over_slope.abs();
    let error = magnitude * f64::from(POLYNOMIAL_ERROR) + noise;
    let is_told = over_slope.abs() * NEGLIGIBLE < 1.0 && magnitude + error < RECIPROCAL_DEPTH_LIMIT;
    let reciprocal_depth = Affine([z as f32, x as f32, y as f32]);
    let error = F32x16::splat(simd, error as f32);
    let plane = is_told.then_some((reciprocal_depth, error));
    cover_everywhere(simd, plane, id, projection, depth_test);
}

/// Rasterizes a plane: its reciprocal depth and how far that may be off, `None` if it cannot be told.
#[inline(always)]
fn cover_everywhere<S: Simd>(
    simd: S,
    plane: Option<(Affine, F32x16<S>)>,
    id: ShapeId,
    projection: &mut BatchProjection,
    depth_test: impl DepthTest,
) {
    let all = Mask32x16::from_bits(simd, u32::from(u16::MAX));
    let packets = projection.meets(simd, &Extent::EVERYTHING);
    for packet in ones(packets) {
        let Some((reciprocal_depth, error)) = plane else {
            depth_test.leave_unresolved(simd, projection, packet, id);
            continue;
        };
        let reciprocal_depth = reciprocal_depth.at(simd, projection.samples(simd, packet));
        let may_cover = match projection.shared {
            // Behind the point a plane is of negative reciprocal depth.
            Shared::Point => reciprocal_depth.ge(F32x16::splat(simd, 0.0) - error),
            Shared::Direction(_) => all,
        };
        let fragments = Fragments {
            may_cover,
            covered: all,
            least: reciprocal_depth - error,
            most: reciprocal_depth + error,
        };
        let fragments = projection.ahead(simd, fragments);
        depth_test.resolve(simd, projection, packet, id, fragments);
    }
}
