//! The projected conics of spheres before parallel rays: circles.

use fearless_simd::Simd;

use super::{ProjectedConics, ROOT_ERROR, SMALLEST_RADIUS, SQUARES_FIT, SphereLanes};
use crate::simd::{DVec3x16, F32x16, F64x16, Mask32x16};
use crate::visibility::projection::{BatchProjection, NEGLIGIBLE, NOISE, POLYNOMIAL_ERROR, Start};

impl ProjectedConics {
    #[inline(never)]
    pub(in crate::visibility) fn set_up_parallel<S: Simd>(
        &mut self,
        simd: S,
        projection: &BatchProjection,
        start: Start,
        spheres: &SphereLanes<S>,
        bits: u32,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.set_up_flattened(simd, projection, start, spheres, bits),
        );
    }

    /// [`ProjectedConics::set_up`] for parallel rays: circles, in units of the projection's unit. With c the
    /// center and d a sample the discriminant is R² − |c − d|² across, and the reciprocal depth −c_z plus its
    /// root.
    #[inline(always)]
    fn set_up_flattened<S: Simd>(
        &mut self,
        simd: S,
        projection: &BatchProjection,
        start: Start,
        spheres: &SphereLanes<S>,
        bits: u32,
    ) {
        let (center, radius) = spheres.before(projection);
        let over_unit = 1.0 / projection.unit;
        let error = projection.error * over_unit;
        let is_tiny = radius
            .le(F64x16::splat(simd, error * SMALLEST_RADIUS))
            .to_bits();
        let from_start = start.nearest() * over_unit;
        // At least how far away from the starts the center is, and how far all of it is off in f32.
        let distance = center.taxicab() + (start.distance * over_unit + 2.0);
        let room = (distance + radius) * f64::from(POLYNOMIAL_ERROR);
        let [left, right, bottom, top] = projection.rectangle();
        let farthest = -f64::from(projection.farthest);
        let DVec3x16 { x, y, z } = center;
        let beyond = radius + room;
        let beside = (-x + left).gt(beyond)
            | (x - right).gt(beyond)
            | (-y + bottom).gt(beyond)
            | (y - top).gt(beyond)
            | (z - farthest).gt(beyond)
            | (-z + from_start).gt(beyond);
        self.of_interest = bits & (is_tiny | !beside.to_bits());
        if self.of_interest == 0 {
            return;
        }
        let fits = (distance + radius).is_within(simd, SQUARES_FIT).to_bits() & !is_tiny;
        self.set_up_flattened_boxes(simd, projection, start, center, radius, distance, fits);
        let square = radius * radius;
        let [xx, yy] = [x * x, y * y];
        let [ex, ey] = projection.extent;
        let magnitude = (square + xx + yy)
            + (x.abs() * (2.0 * ex) + y.abs() * (2.0 * ey))
            + (ex * ex + ey * ey);
        // One factor for all coefficients, whatever it is exactly.
        let (zero, one) = (F32x16::splat(simd, 0.0), F32x16::splat(simd, 1.0));
        let magnitude = magnitude.narrowed(simd);
        let over_magnitude = one / magnitude;
        let wide = over_magnitude.widened(simd);
        let coefficients = [
            ((square - (xx + yy)) * wide).narrowed(simd),
            (x * 2.0 * wide).narrowed(simd),
            (y * 2.0 * wide).narrowed(simd),
            zero - over_magnitude,
            zero,
            zero - over_magnitude,
        ];
        for (row, coefficient) in self.discriminant.iter_mut().zip(coefficients) {
            coefficient.store(&mut row.0);
        }
        let along = zero - z.narrowed(simd);
        along.store(&mut self.along[0].0);
        zero.store(&mut self.along[1].0);
        zero.store(&mut self.along[2].0);
        let root_scale = magnitude.sqrt();
        root_scale.store(&mut self.root_scale.0);
        // What f64 is off is less than the room in this: √SURELY of the radius is the least root, from no
        // further away than 2²⁵ radii.
        let error = along.abs() * F32x16::splat(simd, POLYNOMIAL_ERROR)
            + root_scale * F32x16::splat(simd, ROOT_ERROR as f32);
        error.store(&mut self.error.0);
        let is_told = radius.gt(distance * NEGLIGIBLE);
        self.untold = !(is_told.to_bits() & fits);
        // The light of a sun comes from outside: it never reaches points that are seen from within.
        self.hides_own = if projection.has_points_within {
            u32::MAX
        } else {
            self.untold
        };
    }

    /// The squares around circles, and how close spheres reach; anywhere without a bit.
    #[inline(always)]
    #[expect(
        clippy::too_many_arguments,
        reason = "what is known of spheres by then"
    )]
    fn set_up_flattened_boxes<S: Simd>(
        &mut self,
        simd: S,
        projection: &BatchProjection,
        start: Start,
        center: DVec3x16<S>,
        radius: F64x16<S>,
        distance: F64x16<S>,
        fits: u32,
    ) {
        let give = F32x16::splat(simd, POLYNOMIAL_ERROR);
        let infinite = F32x16::splat(simd, f32::INFINITY);
        let nowhere = F32x16::splat(simd, f32::NEG_INFINITY);
        let fits = Mask32x16::from_bits(simd, fits);
        let radius = radius.narrowed(simd);
        let noise = distance.narrowed(simd) * F32x16::splat(simd, NOISE);
        let across = [center.x.narrowed(simd), center.y.narrowed(simd)];
        let mut sides = [[infinite; 2]; 2];
        for (axis, across) in across.into_iter().enumerate() {
            let extent = F32x16::splat(simd, projection.extent[axis] as f32);
            let room = (across.abs() + radius + extent) * give + noise;
            sides[axis] = [
                fits.select(across - radius - room, nowhere),
                fits.select(across + radius + room, infinite),
            ];
        }
        let depth = center.z.narrowed(simd);
        let room = (depth.abs() + radius) * give + noise;
        let most = fits.select(radius - depth + room, infinite);
        let [[left, right], [bottom, top]] = sides;
        self.extents.store([left, right, bottom, top], most);
        let [ahead, _] = start.reciprocal_depth;
        self.cut = !F32x16::splat(simd, ahead).gt(most).to_bits();
    }
}
