//! Colors side by side: what happens to sixteen of them at once.

use fearless_simd::Simd;
use glam::DMat3;

use crate::color::Primaries;
use crate::color::adaptation::conversion;
use crate::simd::{self, F64x16, Kernel, LANES, SimdLevel};

/// Red, green and blue of sixteen colors.
pub(super) type Rgb<S> = [F64x16<S>; 3];

/// Colors that are worked on together: few enough to stay in the nearest cache, and a multiple of [`LANES`].
pub(super) const PIECE: usize = 256;

/// Red, green and blue of the colors of a piece, apart.
pub(super) type Planes = [[f64; PIECE]; 3];

/// What becomes of a color, each by itself. Colors are finite, and so are the results.
pub(super) trait Transform {
    /// Of sixteen at once; marked `#[inline(always)]`, as is all that it calls.
    fn apply<S: Simd>(&self, simd: S, rgb: Rgb<S>) -> Rgb<S>;
}

/// Transforms the first `count` colors, and some after them.
#[inline(never)]
pub(super) fn transform(
    level: SimdLevel,
    transform: &impl Transform,
    planes: &mut Planes,
    count: usize,
) {
    level.run(Piece {
        transform,
        planes,
        count,
    });
}

struct Piece<'p, T> {
    transform: &'p T,
    planes: &'p mut Planes,
    count: usize,
}

impl<T: Transform> Kernel for Piece<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let [red, green, blue] = self.planes;
        let mut start = 0;
        while start < self.count {
            let lanes = start..start + LANES;
            let rgb = [
                F64x16::load(simd, &red[lanes.clone()]),
                F64x16::load(simd, &green[lanes.clone()]),
                F64x16::load(simd, &blue[lanes.clone()]),
            ];
            let [r, g, b] = self.transform.apply(simd, rgb);
            r.store(&mut red[lanes.clone()]);
            g.store(&mut green[lanes.clone()]);
            b.store(&mut blue[lanes]);
            start += LANES;
        }
    }
}

/// One function for each channel.
#[inline(always)]
pub(super) fn each<S: Simd>(mut rgb: Rgb<S>, channel: impl Fn(F64x16<S>) -> F64x16<S>) -> Rgb<S> {
    // A loop, which is compiled once, in place of three copies.
    for value in &mut rgb {
        *value = channel(*value);
    }
    rgb
}

/// [`simd::log2`], as a function of its own: inlined into every view, it would take minutes to compile.
#[inline(never)]
pub(super) fn log2<S: Simd>(simd: S, x: F64x16<S>) -> F64x16<S> {
    simd.vectorize(
        #[inline(always)]
        || simd::log2(simd, x),
    )
}

/// [`simd::exp2`], likewise.
#[inline(never)]
pub(super) fn exp2<S: Simd>(simd: S, x: F64x16<S>) -> F64x16<S> {
    simd.vectorize(
        #[inline(always)]
        || simd::exp2(simd, x),
    )
}

/// A matrix by rows, times each color.
#[inline(always)]
pub(super) fn product<S: Simd>(rows: &[[f64; 3]; 3], [r, g, b]: Rgb<S>) -> Rgb<S> {
    let [red, green, blue] = rows;
    [
        r * red[0] + g * red[1] + b * red[2],
        r * green[0] + g * green[1] + b * green[2],
        r * blue[0] + g * blue[1] + b * blue[2],
    ]
}

/// The rows of a matrix.
pub(super) fn rows(matrix: DMat3) -> [[f64; 3]; 3] {
    matrix.transpose().to_cols_array_2d()
}

/// A matrix, by its rows.
#[derive(Debug)]
pub(super) struct Matrix([[f64; 3]; 3]);

impl Matrix {
    pub(super) fn new(matrix: DMat3) -> Self {
        Self(rows(matrix))
    }

    /// From linear RGB of one space to that of another; `None` where they are the same.
    pub(super) fn between(from: &Primaries, to: &Primaries) -> Option<Self> {
        (from != to).then(|| Self::new(conversion(from, to)))
    }
}

impl Transform for Matrix {
    #[inline(always)]
    fn apply<S: Simd>(&self, _: S, rgb: Rgb<S>) -> Rgb<S> {
        product(&self.0, rgb)
    }
}

/// A transform of one color.
#[cfg(test)]
pub(super) fn of_one(by: &impl Transform, rgb: [f64; 3]) -> [f64; 3] {
    let mut planes = rgb.map(|channel| [channel; PIECE]);
    transform(SimdLevel::default(), by, &mut planes, 1);
    planes.map(|plane| plane[0])
}
