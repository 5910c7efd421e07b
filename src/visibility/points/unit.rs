//! Vectors at unit length.

use fearless_simd::Simd;

use crate::math::{DVec3, Direction, SAFE_SQUARES};
use crate::simd::{DVec3x16, F64x16, ones};

/// Vectors at unit length, from their squares and the reciprocal roots of these; 0 for those of `asked` that
/// have no direction.
#[inline(always)]
pub(in crate::visibility) fn unit<S: Simd>(
    simd: S,
    vectors: DVec3x16<S>,
    square: F64x16<S>,
    inverse_root: F64x16<S>,
    asked: u32,
) -> DVec3x16<S> {
    let is_safe = square.is_within(simd, SAFE_SQUARES).to_bits();
    let units = vectors.times(inverse_root);
    let unsafe_lanes = asked & !is_safe;
    if unsafe_lanes == 0 {
        return units;
    }
    // Tiny and huge vectors are scaled before they are squared.
    let mut columns = [units.x.to_array(), units.y.to_array(), units.z.to_array()];
    let exact = [
        vectors.x.to_array(),
        vectors.y.to_array(),
        vectors.z.to_array(),
    ];
    for lane in ones(unsafe_lanes) {
        let vector = DVec3::from_array(exact.map(|column| column[lane]));
        let unit = Direction::new(vector).map_or(DVec3::ZERO, Direction::get);
        for axis in 0..3 {
            columns[axis][lane] = unit[axis];
        }
    }
    let [x, y, z] = &columns;
    DVec3x16::load(simd, [x, y, z])
}
