//! Look-up tables in files: `.cube`, by Adobe's Cube LUT Specification 1.0 and as DaVinci Resolve writes it.
//!
//! A table takes exposed linear Rec.709 light as it is, clamped to the table's domain, and yields code values of an
//! sRGB screen. These are decoded by the sRGB curve into the light that a view hands on.
//!
//! One dimension: each channel by itself, linear between entries. Three dimensions: a color lies in one of six
//! tetrahedra of its cell, and the four corners of that are weighted, as Sakamoto & Itooka have it (US patent
//! 4 275 413, 1981): what is affine comes out as it is, and grays stay gray where the table's are. With both, the first
//! is the *shaper*, whose result is looked up in the second.

mod keywords;
mod problem;
mod read;

use fearless_simd::Simd;

pub use problem::{CubeError, CubeFault, CubeProblem};

use super::coded;
use crate::display::lanes::{Rgb, Transform};
use crate::simd::{F64x16, LANES};

/// A look-up table from exposed linear Rec.709 light to code values of an sRGB screen.
#[derive(Clone, Debug, PartialEq)]
pub struct Cube {
    title: Option<String>,
    tables: Tables,
}

/// What a file has.
#[derive(Clone, Debug, PartialEq)]
enum Tables {
    Curves(Table),
    Grid(Table),
    /// The shaper, and the table that takes what it yields.
    Both(Table, Table),
}

/// Entries over a range of each channel.
#[derive(Clone, Debug, PartialEq)]
struct Table {
    domain: Domain,
    /// Entries along an axis. Range: at least 2.
    size: usize,
    /// R, G, B; of three dimensions red changes fastest, blue slowest.
    entries: Vec<[f32; 3]>,
}

/// What the first and the last entry of each axis are for. Range: finite as f32, `least` below `most`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Domain {
    least: [f64; 3],
    most: [f64; 3],
}

impl Default for Domain {
    fn default() -> Self {
        Self {
            least: [0.0; 3],
            most: [1.0; 3],
        }
    }
}

impl Cube {
    /// The title that the file gives itself.
    pub fn title(&self) -> Option<&str> {
        self.title.as_deref()
    }

    /// The code values of each color, not clipped.
    #[inline(always)]
    fn codes<S: Simd>(&self, simd: S, rgb: Rgb<S>) -> Rgb<S> {
        match &self.tables {
            Tables::Curves(curves) => curves.linear(simd, rgb),
            Tables::Grid(grid) => grid.tetrahedral(simd, rgb),
            Tables::Both(shaper, grid) => {
                let shaped = shaper.linear(simd, rgb);
                grid.tetrahedral(simd, shaped)
            }
        }
    }
}

impl Transform for Cube {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, rgb: Rgb<S>) -> Rgb<S> {
        coded::light(simd, self.codes(simd, rgb))
    }
}

/// Where colors are along an axis.
#[derive(Clone, Copy)]
struct Places<S: Simd> {
    /// The entry before, but for the last one.
    cell: F64x16<S>,
    /// How far on to the next, 0 to 1.
    part: F64x16<S>,
}

impl Table {
    #[inline(always)]
    fn places<S: Simd>(&self, simd: S, x: F64x16<S>, axis: usize) -> Places<S> {
        let (least, most) = (self.domain.least[axis], self.domain.most[axis]);
        let x = x
            .max(F64x16::splat(simd, least))
            .min(F64x16::splat(simd, most));
        let place = (x - least) / (most - least) * (self.size - 1) as f64;
        let cell = place
            .floor()
            .min(F64x16::splat(simd, (self.size - 2) as f64));
        Places {
            cell,
            part: place - cell,
        }
    }

    /// Each channel on its own curve.
    #[inline(always)]
    fn linear<S: Simd>(&self, simd: S, [r, g, b]: Rgb<S>) -> Rgb<S> {
        [
            self.curve(simd, r, 0),
            self.curve(simd, g, 1),
            self.curve(simd, b, 2),
        ]
    }

    #[inline(always)]
    fn curve<S: Simd>(&self, simd: S, x: F64x16<S>, channel: usize) -> F64x16<S> {
        let Places { cell, part } = self.places(simd, x, channel);
        let cells = cell.to_array();
        let (mut before, mut after) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let cell = cells[lane] as usize;
            before[lane] = f64::from(self.entries[cell][channel]);
            after[lane] = f64::from(self.entries[cell + 1][channel]);
        }
        let (before, after) = (F64x16::load(simd, &before), F64x16::load(simd, &after));
        before * (-part + 1.0) + after * part
    }

    /// The corners of a cell from its first to its last, by way of the axis on which a color is farthest on, then the
    /// next: these four, each weighted by what it adds.
    #[inline(always)]
    fn tetrahedral<S: Simd>(&self, simd: S, [r, g, b]: Rgb<S>) -> Rgb<S> {
        let size = self.size as f64;
        let [of_red, of_green, of_blue] = [
            F64x16::splat(simd, 1.0),
            F64x16::splat(simd, size),
            F64x16::splat(simd, size * size),
        ];
        let red = self.places(simd, r, 0);
        let green = self.places(simd, g, 1);
        let blue = self.places(simd, b, 2);
        let (r, g, b) = (red.part, green.part, blue.part);
        let least = r.min(g).min(b);
        let most = r.max(g).max(b);
        let middle = r.min(g).max(r.max(g).min(b));

        // Of equal parts either is right: the corner between has no weight.
        let first = (r.ge(g) & r.ge(b)).select(of_red, g.ge(b).select(of_green, of_blue));
        let last = (b.le(r) & b.le(g)).select(of_blue, g.le(r).select(of_green, of_red));
        let corner = red.cell + green.cell * of_green + blue.cell * of_blue;
        let opposite = corner + of_red + of_green + of_blue;
        let corners = [
            (corner, -most + 1.0),
            (corner + first, most - middle),
            (opposite - last, middle - least),
            (opposite, least),
        ];
        let zero = F64x16::splat(simd, 0.0);
        let mut sum = [zero, zero, zero];
        for (places, weight) in corners {
            let places = places.to_array();
            let mut rows = [[0.0; LANES]; 3];
            for lane in 0..LANES {
                let [red, green, blue] = self.entries[places[lane] as usize];
                rows[0][lane] = f64::from(red);
                rows[1][lane] = f64::from(green);
                rows[2][lane] = f64::from(blue);
            }
            sum[0] = sum[0] + F64x16::load(simd, &rows[0]) * weight;
            sum[1] = sum[1] + F64x16::load(simd, &rows[1]) * weight;
            sum[2] = sum[2] + F64x16::load(simd, &rows[2]) * weight;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;
    use crate::color::transfer::srgb_decode;
    use crate::display::lanes::of_one;

    /// The codes themselves, before they are decoded.
    struct Codes(Cube);

    impl Transform for Codes {
        #[inline(always)]
        fn apply<S: Simd>(&self, simd: S, rgb: Rgb<S>) -> Rgb<S> {
            self.0.codes(simd, rgb)
        }
    }

    fn table(domain: Domain, size: usize, entries: Vec<[f32; 3]>) -> Table {
        Table {
            domain,
            size,
            entries,
        }
    }

    /// A table of three dimensions, whose entries are a function of the place in its domain.
    fn grid(domain: Domain, size: usize, of: impl Fn([f64; 3]) -> [f64; 3]) -> Table {
        let count = size.pow(3);
        let entry = |index: usize| {
            let places = [index % size, index / size % size, index / (size * size)];
            let rgb = std::array::from_fn(|axis| {
                let part = places[axis] as f64 / (size - 1) as f64;
                domain.least[axis] + part * (domain.most[axis] - domain.least[axis])
            });
            of(rgb).map(|value| value as f32)
        };
        table(domain, size, (0..count).map(entry).collect())
    }

    fn codes(tables: Tables) -> Codes {
        Codes(Cube {
            title: None,
            tables,
        })
    }

    const WIDE: Domain = Domain {
        least: [-0.5, 0.0, 0.25],
        most: [1.5, 4.0, 16.25],
    };

    /// Colors inside of `WIDE`, in all orders of their parts, on the borders of cells and between them.
    fn colors() -> impl Iterator<Item = [f64; 3]> {
        let parts = [0.0, 0.125, 0.3, 0.5, 0.77, 1.0];
        let all = move || parts.into_iter();
        let parts = all().flat_map(move |r| all().flat_map(move |g| all().map(move |b| [r, g, b])));
        parts.map(|parts| {
            std::array::from_fn(|axis| {
                WIDE.least[axis] + parts[axis] * (WIDE.most[axis] - WIDE.least[axis])
            })
        })
    }

    /// Entries are f32, the largest 16.25.
    const ROUNDING: f64 = 1e-6;

    #[track_caller]
    fn assert_near(actual: [f64; 3], expected: [f64; 3], tolerance: f64) {
        let is_near = actual
            .iter()
            .zip(expected)
            .all(|(actual, expected)| (actual - expected).abs() <= tolerance);
        assert!(is_near, "{actual:?}, not {expected:?}");
    }

    #[test]
    fn what_is_affine_comes_out_as_it_is() {
        let affine = |[r, g, b]: [f64; 3]| {
            [
                0.5 * r - 0.25 * g + 0.125 * b + 0.1,
                0.75 * g - r,
                0.3 * r + 0.2 * b - 0.4,
            ]
        };
        for size in [2, 3, 5, 8] {
            let identity = codes(Tables::Grid(grid(WIDE, size, |rgb| rgb)));
            let map = codes(Tables::Grid(grid(WIDE, size, affine)));
            for rgb in colors() {
                assert_near(of_one(&identity, rgb), rgb, ROUNDING);
                assert_near(of_one(&map, rgb), affine(rgb), ROUNDING);
            }
        }
    }

    /// Of a color whose parts are r > g > b the corners are 000, 100, 110, 111, with the weights 1 − r, r − g, g − b, b; and so
    /// in the other five orders. A table that is 1 in one corner alone shows the weight of that.
    #[test]
    fn six_tetrahedra() {
        let unit = Domain::default();
        let parts = [0.7, 0.4, 0.1];
        for order in [
            [0, 1, 2],
            [0, 2, 1],
            [1, 0, 2],
            [1, 2, 0],
            [2, 0, 1],
            [2, 1, 0],
        ] {
            let mut rgb = [0.0; 3];
            for (axis, part) in order.into_iter().zip(parts) {
                rgb[axis] = part;
            }
            for (corners, expected) in [(1, 0.3), (2, 0.3), (3, 0.1)] {
                // The corner that is reached along the first axes of the order.
                let on = |axis: usize| order[..corners].contains(&axis);
                let is_corner =
                    |place: [f64; 3]| (0..3).all(|axis| (place[axis] == 1.0) == on(axis));
                let cube = grid(unit, 2, |place| [f64::from(is_corner(place)), 0.0, 1.0]);
                let [weight, nothing, sum] = of_one(&codes(Tables::Grid(cube)), rgb);
                assert!((weight - expected).abs() < 1e-15, "{order:?} {corners}");
                assert_eq!(nothing, 0.0);
                assert!((sum - 1.0).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn what_is_outside_is_at_the_border() {
        let cube = codes(Tables::Grid(grid(WIDE, 4, |rgb| rgb)));
        assert_near(of_one(&cube, [-1e30, 1e30, 1e30]), [-0.5, 4.0, 16.25], 0.0);
        assert_near(of_one(&cube, [7.0, -7.0, 0.0]), [1.5, 0.0, 0.25], 0.0);
    }

    #[test]
    fn curves_are_linear_between_entries() {
        let entries = vec![[0.0, 1.0, 0.5], [0.25, 0.5, 0.0], [1.0, 0.0, 0.75]];
        let domain = Domain {
            least: [0.0, -1.0, 0.0],
            most: [2.0, 1.0, 4.0],
        };
        let curves = codes(Tables::Curves(table(domain, 3, entries)));
        for (rgb, expected) in [
            ([0.0, -1.0, 0.0], [0.0, 1.0, 0.5]),
            ([0.5, -0.5, 1.0], [0.125, 0.75, 0.25]),
            ([1.0, 0.0, 2.0], [0.25, 0.5, 0.0]),
            ([1.5, 0.5, 3.0], [0.625, 0.25, 0.375]),
            ([9.0, 9.0, 9.0], [1.0, 0.0, 0.75]),
        ] {
            assert_near(of_one(&curves, rgb), expected, 0.0);
        }
    }

    #[test]
    fn a_shaper_comes_first() {
        let shaper = table(
            Domain {
                least: [0.0; 3],
                most: [16.0; 3],
            },
            2,
            vec![[0.0; 3], [1.0; 3]],
        );
        let swapped = grid(Domain::default(), 2, |[r, g, b]| [g, b, r]);
        let both = codes(Tables::Both(shaper, swapped));
        assert_near(of_one(&both, [4.0, 8.0, 16.0]), [0.5, 1.0, 0.25], 0.0);
    }

    #[test]
    fn codes_become_light() {
        let cube = Cube {
            title: None,
            tables: Tables::Grid(grid(Domain::default(), 2, |rgb| rgb)),
        };
        let light = of_one(&cube, [0.5, 0.25, 1.0]);
        assert_near(light, [0.5, 0.25, 1.0].map(srgb_decode), 1e-11);
    }

    /// What OpenColorIO 2.6 makes of the files by `FileTransform` with `INTERP_TETRAHEDRAL`, in f32:
    /// reference/display/cube.py.
    #[test]
    fn opencolorio_agrees() {
        /// Of codes; twice the largest difference that was measured.
        const TOLERANCE: f64 = 5e-7;
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("reference/display");
        for name in ["cube-3d", "cube-1d", "cube-both"] {
            let cube = codes(
                Cube::read(&folder.join(name).with_extension("cube"))
                    .unwrap()
                    .tables,
            );
            let list = fs::read_to_string(folder.join(name).with_extension("csv")).unwrap();
            let mut count = 0;
            for line in list.lines().filter(|line| !line.starts_with(['#', 'r'])) {
                let numbers: Vec<f64> = line.split(',').map(|text| text.parse().unwrap()).collect();
                let (rgb, expected) = numbers.split_at(3);
                let [rgb, expected] = [rgb, expected].map(|rgb| rgb.try_into().unwrap());
                assert_near(of_one(&cube, rgb), expected, TOLERANCE);
                count += 1;
            }
            assert_eq!(count, 200, "{name}");
        }
    }
}
