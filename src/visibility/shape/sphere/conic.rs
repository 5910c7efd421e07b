//! The projected conics of spheres: their discriminants as functions of a sample.

mod parallel;

use std::ops::Range;

use fearless_simd::Simd;

use crate::math::{all_three, both};
use crate::simd::{DVec3x16, F32x16, F64x16, LANES, Mask32x16, ones};
use crate::visibility::batch::Row;
use crate::visibility::primitive::ShapeId;
use crate::visibility::projection::{
    BatchProjection, DepthTest, Extents, Fragments, NEGLIGIBLE, NOISE, POLYNOMIAL_ERROR,
    RECIPROCAL_DEPTH_LIMIT, Shared, State,
};

/// Where R²|d|² − |oc × d|², over the sum of the magnitudes of its terms, is above this, a ray surely
/// meets a sphere, and the root of it is off by [`POLYNOMIAL_ERROR`] over twice the root of this at most.
const SURELY: f32 = 1.0 / (1 << 13) as f32;

/// By how much that root is off at most, √ of [`SURELY`] being 2⁻⁶·⁵: 2⁻²⁰ · 2⁶·⁵ / 2, and room.
const ROOT_ERROR: f64 = 1.0 / (1 << 14) as f64;

/// A sphere smaller than this many times the error of the points may be on the way to points that are on it as
/// far as rounding tells, though none of their rays meets it: the room of its box is less than the error.
const SMALLEST_RADIUS: f64 = 1.0 / NEGLIGIBLE;

/// The squares of lengths in this range are far from the ends of f32.
const SQUARES_FIT: Range<f64> = 1e-14..1e14;

/// By how much |oc|² − R² has to be clear of 0, over |oc|²: rounding it to f64 is then [`NEGLIGIBLE`].
const CLEAR: f64 = 2.0 * NEGLIGIBLE;

/// The projected conics of sixteen spheres.
#[derive(Clone, Debug)]
pub(in crate::visibility) struct ProjectedConics {
    /// The coefficients of 1, x, y, x², x y and y² of R²|d|² − |oc × d|², over the sum of the magnitudes of
    /// the terms.
    discriminant: [Row; 6],
    /// Those of 1, x and y of oc · d, and the factor of the root of the discriminant, so that the sum is
    /// the reciprocal depth.
    along: [Row; 3],
    root_scale: Row,
    /// How far the reciprocal depth may be off.
    error: Row,
    pub(in crate::visibility) extents: Extents,
    /// One bit for each sphere that may be of interest to any ray.
    pub(in crate::visibility) of_interest: u32,
    /// One bit for each that cannot be told from f32.
    untold: u32,
    /// One bit for each whose own points may be in its shadow, as far as can be told.
    hides_own: u32,
    /// One bit for each that may reach behind where parallel rays start.
    cut: u32,
}

impl Default for ProjectedConics {
    fn default() -> Self {
        let row = Row([0.0; LANES]);
        Self {
            discriminant: [row; 6],
            along: [row; 3],
            root_scale: row,
            error: row,
            extents: Extents::default(),
            of_interest: 0,
            untold: 0,
            hides_own: 0,
            cut: 0,
        }
    }
}

/// Spheres side by side.
#[derive(Clone, Copy)]
pub(in crate::visibility) struct SphereLanes<S: Simd> {
    pub(in crate::visibility) center: DVec3x16<S>,
    pub(in crate::visibility) radius: F64x16<S>,
}

impl<S: Simd> SphereLanes<S> {
    /// Centers in the axes of a projection, and radii, both in its unit.
    #[inline(always)]
    fn before(&self, projection: &BatchProjection) -> (DVec3x16<S>, F64x16<S>) {
        let over_unit = 1.0 / projection.unit;
        let from_origin = self.center.minus(projection.origin);
        let [u, v, w] = all_three(projection.axes, |axis| axis * over_unit);
        let center = DVec3x16 {
            x: from_origin.dot_with(u),
            y: from_origin.dot_with(v),
            z: from_origin.dot_with(w),
        };
        (center, self.radius * over_unit)
    }
}

/// The discriminants of sixteen spheres, over the sum of the magnitudes of their terms.
#[derive(Clone, Copy)]
struct Discriminants<S: Simd> {
    /// Of 1, x, y, x², x y and y².
    coefficients: [F32x16<S>; 6],
    magnitude: F32x16<S>,
}

/// The reciprocal depths of sixteen spheres.
#[derive(Clone, Copy)]
struct Roots<S: Simd> {
    /// The coefficients of 1, x and y of oc · d.
    along: [F32x16<S>; 3],
    /// The factor of the root of the discriminant.
    root_scale: F32x16<S>,
    /// How far the reciprocal depth may be off.
    error: F32x16<S>,
    /// One bit for each that the point is in.
    is_inside: u32,
}

/// The largest |x| and the largest |y| of any sample.
#[inline(always)]
fn extents<S: Simd>(simd: S, projection: &BatchProjection) -> [F32x16<S>; 2] {
    both(
        projection.extent,
        #[inline(always)]
        |extent| F32x16::splat(simd, extent as f32),
    )
}

impl ProjectedConics {
    /// Sets up the conics of the spheres with a bit. All is in units of the projection's unit.
    #[inline(always)]
    pub(in crate::visibility) fn set_up<S: Simd>(
        &mut self,
        simd: S,
        projection: &BatchProjection,
        spheres: &SphereLanes<S>,
        bits: u32,
    ) {
        if let Shared::Direction(start) = projection.shared {
            self.set_up_parallel(simd, projection, start, spheres, bits);
            return;
        }
        self.cut = 0;
        let (center, radius) = spheres.before(projection);
        let error = projection.error / projection.unit;
        let is_tiny = radius
            .le(F64x16::splat(simd, error * SMALLEST_RADIUS))
            .to_bits();
        self.of_interest = bits & (is_tiny | near(projection, center, radius));
        if self.of_interest == 0 {
            return;
        }
        let reach = center.taxicab() + radius;
        let fits = reach.is_within(simd, SQUARES_FIT).to_bits() & !is_tiny;
        self.set_up_boxes(simd, projection, center, radius, fits);
        let conics = self.set_up_discriminants(simd, projection, center, radius);
        let roots = self.set_up_roots(simd, projection, center, radius, fits, conics.magnitude);
        // Points that are seen from outside and face the light are not hidden by the sphere that they are
        // on. Those seen from within are, unless the light is inside as well.
        self.hides_own = self.untold;
        if projection.has_points_within {
            self.hides_own |= !roots.is_inside;
        }
        self.extents.covers = 0;
        if projection.state == State::Bounded {
            self.cover(simd, projection, conics, roots);
        }
    }

    /// R²|d|² − |oc × d|² of spheres seen from a point, as a quadratic function of a sample, over the sum of the
    /// magnitudes of its terms.
    ///
    /// oc × d = g₀ + g₁ x + g₂ y in the axes of the projection, g₀ = (y, −x, 0), g₁ = (0, z, −y),
    /// g₂ = (−z, 0, x).
    #[inline(always)]
    fn set_up_discriminants<S: Simd>(
        &mut self,
        simd: S,
        projection: &BatchProjection,
        center: DVec3x16<S>,
        radius: F64x16<S>,
    ) -> Discriminants<S> {
        let DVec3x16 { x, y, z } = center;
        let [xx, yy, zz] = [x * x, y * y, z * z];
        let square = radius * radius;
        let c = square - (xx + yy);
        let (cx, cy) = (x * z * 2.0, y * z * 2.0);
        let cxx = square - (yy + zz);
        let cxy = x * y * 2.0;
        let cyy = square - (xx + zz);
        let [ex, ey] = projection.extent;
        let magnitude = (square + xx + yy)
            + (cx.abs() * ex + cy.abs() * ey)
            + (cxx.abs() * (ex * ex) + cyy.abs() * (ey * ey) + cxy.abs() * (ex * ey));
        // One factor for all coefficients, whatever it is exactly.
        let one = F32x16::splat(simd, 1.0);
        let magnitude = magnitude.narrowed(simd);
        let over_magnitude = (one / magnitude).widened(simd);
        let coefficients = [
            (c * over_magnitude).narrowed(simd),
            (cx * over_magnitude).narrowed(simd),
            (cy * over_magnitude).narrowed(simd),
            (cxx * over_magnitude).narrowed(simd),
            (cxy * over_magnitude).narrowed(simd),
            (cyy * over_magnitude).narrowed(simd),
        ];
        for (row, coefficient) in self.discriminant.iter_mut().zip(coefficients) {
            coefficient.store(&mut row.0);
        }
        Discriminants {
            coefficients,
            magnitude,
        }
    }

    /// The reciprocal depth as an affine function of a sample and the root of the discriminant, whose scale is
    /// `magnitude`; which spheres can be told.
    ///
    /// With b = oc · d and c = |oc|² − R², t = c / (b ± √…), the nearer root of which is before a point outside
    /// and behind one inside.
    #[inline(always)]
    fn set_up_roots<S: Simd>(
        &mut self,
        simd: S,
        projection: &BatchProjection,
        center: DVec3x16<S>,
        radius: F64x16<S>,
        fits: u32,
        magnitude: F32x16<S>,
    ) -> Roots<S> {
        let DVec3x16 { x, y, z } = center;
        let distance_square = x * x + y * y + z * z;
        let power = distance_square - radius * radius;
        let scale = F32x16::splat(simd, 1.0) / power.narrowed(simd);
        let along = [
            z.narrowed(simd) * scale,
            x.narrowed(simd) * scale,
            y.narrowed(simd) * scale,
        ];
        for (row, coefficient) in self.along.iter_mut().zip(along) {
            coefficient.store(&mut row.0);
        }
        let [ex, ey] = extents(simd, projection);
        let along_size = along[0].abs() + along[1].abs() * ex + along[2].abs() * ey;
        let root_scale = magnitude.sqrt() * scale.abs();
        root_scale.store(&mut self.root_scale.0);
        let root_error = F32x16::splat(simd, ROOT_ERROR as f32);
        let give = F32x16::splat(simd, POLYNOMIAL_ERROR);
        let error = along_size * give + root_scale * root_error;
        error.store(&mut self.error.0);
        let size = (along_size + root_scale).widened(simd);
        let distance = distance_square.narrowed(simd).sqrt().widened(simd);
        // Where points or the origin may be off by this much, c and the radius have to be clear of it.
        let room = projection.error / projection.unit / NEGLIGIBLE;
        let is_told = power
            .abs()
            .gt(distance_square * CLEAR + (distance + radius) * room)
            & radius.gt(distance * NEGLIGIBLE + room)
            & size.is_within(simd, 1.0 / RECIPROCAL_DEPTH_LIMIT..RECIPROCAL_DEPTH_LIMIT);
        self.untold = !(is_told.to_bits() & fits);
        Roots {
            along,
            root_scale,
            error,
            is_inside: power.lt(F64x16::splat(simd, 0.0)).to_bits(),
        }
    }

    /// Which spheres all rays of a bounded projection meet, and the ranges of their reciprocal depths.
    #[inline(always)]
    fn cover<S: Simd>(
        &mut self,
        simd: S,
        projection: &BatchProjection,
        conics: Discriminants<S>,
        roots: Roots<S>,
    ) {
        let [c, cx, cy, cxx, cxy, cyy] = conics.coefficients;
        let Roots {
            along,
            root_scale,
            error,
            ..
        } = roots;
        let [ex, ey] = extents(simd, projection);
        let zero = F32x16::splat(simd, 0.0);
        let threshold = F32x16::splat(simd, 2.0 * SURELY);
        let sides = cx.abs() * ex + cy.abs() * ey + cxy.abs() * (ex * ey);
        let least = c - sides + cxx.min(zero) * (ex * ex) + cyy.min(zero) * (ey * ey);
        let most = c + sides + cxx.max(zero) * (ex * ex) + cyy.max(zero) * (ey * ey);
        let is_met = least.gt(threshold);
        // Twice the error: for the sums of this.
        let error = error + error;
        let sides = along[1].abs() * ex + along[2].abs() * ey + error;
        // Where it is not sure that the sphere is met, the root is below that of 2 · SURELY.
        let roots = [least.max(zero).sqrt(), most.max(threshold).sqrt()];
        let least = along[0] - sides + roots[0] * root_scale;
        let most = along[0] + sides + roots[1] * root_scale;
        let covers = (is_met & least.gt(zero)).to_bits() & !self.untold;
        let largest = F32x16::load(simd, &self.extents.most.0);
        let told = Mask32x16::from_bits(simd, !self.untold & u32::from(u16::MAX));
        let most = told.select(most.min(largest), largest);
        self.extents.cover_with(covers, [least, most]);
    }

    /// The boxes of spheres on the projection: the planes through the origin and an axis that touch them (Mara &
    /// McGuire 2013, "2D Polyhedral Bounds of a Clipped, Perspective-Projected 3D Sphere"). Anywhere, for
    /// spheres that reach behind it, and without a bit.
    #[inline(always)]
    fn set_up_boxes<S: Simd>(
        &mut self,
        simd: S,
        projection: &BatchProjection,
        center: DVec3x16<S>,
        radius: F64x16<S>,
        fits: u32,
    ) {
        let one = F32x16::splat(simd, 1.0);
        let give = F32x16::splat(simd, POLYNOMIAL_ERROR);
        let infinite = F32x16::splat(simd, f32::INFINITY);
        let nowhere = F32x16::splat(simd, f32::NEG_INFINITY);
        let nearest = (center.z - radius).narrowed(simd);
        let [x, y, z] = [
            center.x.narrowed(simd),
            center.y.narrowed(simd),
            center.z.narrowed(simd),
        ];
        let radius = radius.narrowed(simd);
        let size = z.abs() + radius;
        let is_before = nearest.gt(size * give) & Mask32x16::from_bits(simd, fits);
        let in_nearest = one / nearest;
        let width = nearest * size;
        let over_width = in_nearest / size;
        let noise = (x.abs() + y.abs() + size) * in_nearest * F32x16::splat(simd, NOISE);
        let mut sides = [[infinite; 2]; 2];
        for (axis, across) in [x, y].into_iter().enumerate() {
            let root = radius * (across * across + width).sqrt();
            let middle = across * z;
            let least = (middle - root) * over_width;
            let most = (middle + root) * over_width;
            let extent = F32x16::splat(simd, projection.extent[axis] as f32);
            let room = (least.abs().max(most.abs()) + extent) * give + noise;
            sides[axis] = [
                is_before.select(least - room, nowhere),
                is_before.select(most + room, infinite),
            ];
        }
        let most = is_before.select(in_nearest * (one + give), infinite);
        let [[left, right], [bottom, top]] = sides;
        self.extents.store([left, right, bottom, top], most);
    }

    /// Whether points of a sphere may be in its own shadow, as far as can be told.
    pub(in crate::visibility) fn hides_own(&self, index: usize) -> bool {
        self.hides_own >> index & 1 == 1
    }

    /// Rasterizes one sphere.
    #[inline(always)]
    pub(in crate::visibility) fn rasterize<S: Simd>(
        &self,
        simd: S,
        index: usize,
        id: ShapeId,
        projection: &mut BatchProjection,
        depth_test: impl DepthTest,
    ) {
        let packets = projection.meets(simd, &self.extents.get(index));
        let is_untold = self.untold >> index & 1 == 1;
        let hides_own = self.hides_own(index);
        let is_cut = self.cut >> index & 1 == 1;
        let zero = F32x16::splat(simd, 0.0);
        let splat = |row: &Row| F32x16::splat(simd, row.0[index]);
        let [c, cx, cy, cxx, cxy, cyy] = [
            splat(&self.discriminant[0]),
            splat(&self.discriminant[1]),
            splat(&self.discriminant[2]),
            splat(&self.discriminant[3]),
            splat(&self.discriminant[4]),
            splat(&self.discriminant[5]),
        ];
        let [along, along_x, along_y] = [
            splat(&self.along[0]),
            splat(&self.along[1]),
            splat(&self.along[2]),
        ];
        let root_scale = splat(&self.root_scale);
        let error = splat(&self.error);
        // Where it is not sure that the sphere is met, the root is below that of 2 · SURELY.
        let edge_error = root_scale * F32x16::splat(simd, (2.0 * SURELY).sqrt());
        for packet in ones(packets) {
            if hides_own {
                depth_test.leave_own_unresolved(simd, projection, packet, id, is_untold);
            }
            if is_untold {
                depth_test.leave_unresolved(simd, projection, packet, id);
                continue;
            }
            let [x, y] = projection.samples(simd, packet);
            let discriminant = x.times_plus(
                x.times_plus(cxx, y.times_plus(cxy, cx)),
                y.times_plus(y.times_plus(cyy, cy), c),
            );
            let may_cover = discriminant.ge(F32x16::splat(simd, -POLYNOMIAL_ERROR));
            if may_cover.to_bits() == 0 {
                continue;
            }
            let covered = discriminant.gt(F32x16::splat(simd, SURELY));
            let root = discriminant.max(zero).sqrt();
            let along = y.times_plus(along_y, x.times_plus(along_x, along));
            let reciprocal_depth = root.times_plus(root_scale, along);
            let most = reciprocal_depth + error;
            let fragments = Fragments {
                may_cover,
                covered,
                least: reciprocal_depth - error,
                most: covered.select(most, most + edge_error),
            };
            let fragments = if is_cut {
                let second = along - root * root_scale;
                projection.first_ahead(simd, fragments, second, [error, edge_error])
            } else {
                fragments
            };
            depth_test.resolve(simd, projection, packet, id, fragments);
        }
    }
}

/// One bit for each sphere that the beam of a projection's rays may meet as deep as is of interest.
#[inline(always)]
fn near<S: Simd>(projection: &BatchProjection, center: DVec3x16<S>, radius: F64x16<S>) -> u32 {
    let DVec3x16 { x, y, z } = center;
    let [left, right, bottom, top] = projection.rectangle();
    let depth = 1.0 / f64::from(projection.farthest);
    // By how much each sphere is beyond a plane, over its normal's length.
    let give = f64::from(POLYNOMIAL_ERROR);
    let room = (center.taxicab() + radius) * give + radius;
    let side = |slope: f64| 1.0 / (1.0 + slope * slope).sqrt();
    let beside = ((z * left - x) * side(left)).gt(room)
        | ((x - z * right) * side(right)).gt(room)
        | ((z * bottom - y) * side(bottom)).gt(room)
        | ((y - z * top) * side(top)).gt(room)
        | (z - depth * (1.0 + give)).gt(room)
        | (-z).gt(room);
    !beside.to_bits()
}
