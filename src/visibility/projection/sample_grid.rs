//! Which rays of a batch a box on their projection holds.
//!
//! The projection is parted into columns and into rows, and for each of these there is one bit for each ray
//! in it or before it. The rays of some columns and some rows are then four such sets, whatever their
//! number: of a thousand triangles smaller than a pixel, those without any ray are soon told.

use fearless_simd::Simd;

use crate::simd::{F32x16, LANES, U32x16, ones};
use crate::visibility::batch::{BATCH, PACKETS};

/// Columns, and rows: one less than a power of two.
const CELLS: usize = 127;

/// Widths below this are none.
const NARROWEST: f32 = 1e-30;

/// One bit for each ray of a batch.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct RaySet([u64; BATCH / 64]);

/// The columns and the rows of the rays on a projection.
#[derive(Debug)]
pub(in crate::visibility) struct SampleGrid {
    axes: [Axis; 2],
}

/// Cells along x or y.
#[derive(Debug)]
struct Axis {
    least: f32,
    most: f32,
    /// Cells per length.
    density: f32,
    /// The rays in the cells before each, and all.
    before: [RaySet; CELLS + 1],
}

/// For each of sixteen boxes the first cells along x and y that it has to do with, and the first it has not.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct Places([[[u32; LANES]; 2]; 2]);

impl RaySet {
    const NONE: Self = Self([0; BATCH / 64]);

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        Self([a & e, b & f, c & g, d & h])
    }

    #[inline(always)]
    fn but(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        Self([a & !e, b & !f, c & !g, d & !h])
    }

    #[inline(always)]
    fn or(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        Self([a | e, b | f, c | g, d | h])
    }

    #[inline(always)]
    fn any(self) -> bool {
        let [a, b, c, d] = self.0;
        a | b | c | d != 0
    }

    /// One bit for each packet that has a ray in it.
    #[inline(always)]
    fn packets(self) -> u32 {
        /// All bits of each packet but the highest.
        const LOW: u64 = 0x7fff_7fff_7fff_7fff;
        /// Moves the lowest bit of four packets side by side, at the top.
        const GATHERS: u64 = 1 << 48 | 1 << 33 | 1 << 18 | 1 << 3;
        let mut packets = 0;
        for (four, word) in self.0.into_iter().enumerate() {
            let highest = (((word & LOW) + LOW) | word) & !LOW;
            let bits = ((highest >> 15).wrapping_mul(GATHERS) >> 48) & 0xf;
            packets |= (bits as u32) << (4 * four);
        }
        packets
    }
}

impl Default for SampleGrid {
    fn default() -> Self {
        let axis = || Axis {
            least: 0.0,
            most: 0.0,
            density: 0.0,
            before: [RaySet::NONE; CELLS + 1],
        };
        Self {
            axes: [axis(), axis()],
        }
    }
}

impl Axis {
    /// Takes the rays with a bit in `asked`, which are between two numbers along this axis.
    #[inline(always)]
    fn fill<S: Simd>(
        &mut self,
        simd: S,
        [least, most]: [f32; 2],
        places: &[f32; BATCH],
        asked: &[u32; PACKETS],
    ) {
        let width = most - least;
        (self.least, self.most) = (least, most);
        self.density = if width > NARROWEST {
            CELLS as f32 / width
        } else {
            0.0
        };
        self.before.fill(RaySet::NONE);
        for (packet, &bits) in asked.iter().enumerate() {
            if bits == 0 {
                continue;
            }
            let mut cells = [0; LANES];
            let places = F32x16::load(simd, &places[packet * LANES..]);
            self.cells(simd, places).store(&mut cells);
            let (word, shift) = (packet / 4, packet % 4 * LANES);
            for lane in ones(bits) {
                let set = &mut self.before[(cells[lane] as usize + 1) & CELLS];
                set.0[word] |= 1 << (shift + lane);
            }
        }
        let mut all = RaySet::NONE;
        for set in &mut self.before {
            all = all.or(*set);
            *set = all;
        }
    }

    /// In which cells numbers are; what is outside counts as at the border. A larger number is never in an
    /// earlier cell.
    #[inline(always)]
    fn cells<S: Simd>(&self, simd: S, places: F32x16<S>) -> U32x16<S> {
        let least = F32x16::splat(simd, self.least);
        let places = places.max(least).min(F32x16::splat(simd, self.most));
        let cells = (places - least) * F32x16::splat(simd, self.density);
        cells
            .min(F32x16::splat(simd, (CELLS - 1) as f32))
            .truncated(simd)
    }

    #[inline(always)]
    fn within(&self, first: u32, last: u32) -> RaySet {
        let end = (last as usize + 1) & CELLS;
        self.before[end].but(self.before[first as usize & CELLS])
    }
}

impl SampleGrid {
    /// Takes the rays with a bit in `asked`, which are all within a rectangle: left, right, bottom, top.
    #[inline(always)]
    pub(in crate::visibility) fn fill<S: Simd>(
        &mut self,
        simd: S,
        [left, right, bottom, top]: [f32; 4],
        [x, y]: [&[f32; BATCH]; 2],
        asked: &[u32; PACKETS],
    ) {
        let [columns, rows] = &mut self.axes;
        columns.fill(simd, [left, right], x, asked);
        rows.fill(simd, [bottom, top], y, asked);
    }

    /// Which cells sixteen boxes have to do with: left, right, bottom, top.
    #[inline(always)]
    pub(in crate::visibility) fn places<S: Simd>(&self, simd: S, boxes: [F32x16<S>; 4]) -> Places {
        let [left, right, bottom, top] = boxes;
        let [columns, rows] = &self.axes;
        let mut places = Places([[[0; LANES]; 2]; 2]);
        let Places([[first_x, last_x], [first_y, last_y]]) = &mut places;
        columns.cells(simd, left).store(first_x);
        columns.cells(simd, right).store(last_x);
        rows.cells(simd, bottom).store(first_y);
        rows.cells(simd, top).store(last_y);
        places
    }

    /// One bit for each packet that may have rays in one of the boxes.
    #[inline(always)]
    pub(in crate::visibility) fn packets(&self, places: &Places, index: usize) -> u32 {
        let Places([[first_x, last_x], [first_y, last_y]]) = places;
        let [columns, rows] = &self.axes;
        let rays = columns
            .within(first_x[index], last_x[index])
            .and(rows.within(first_y[index], last_y[index]));
        if rays.any() { rays.packets() } else { 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Kernel, SimdLevel};

    /// Rays without order in a rectangle, and boxes of all sizes, some beyond it.
    struct Boxes;

    const RECTANGLE: [f32; 4] = [-0.25, 0.75, 1.0, 3.0];

    fn scattered(index: usize, step: f64) -> f32 {
        (index as f64 * step).fract() as f32
    }

    impl Kernel for Boxes {
        type Output = ();

        fn run<S: Simd>(self, simd: S) {
            let [left, right, bottom, top] = RECTANGLE;
            let (width, height) = (right - left, top - bottom);
            let x: [f32; BATCH] =
                std::array::from_fn(|i| left + width * scattered(i, 0.819_172_513));
            let y: [f32; BATCH] =
                std::array::from_fn(|i| bottom + height * scattered(i, 0.671_043_606));
            let asked: [u32; PACKETS] =
                std::array::from_fn(|packet| if packet == 3 { 0 } else { 0x7ffe });
            let mut grid = SampleGrid::default();
            grid.fill(simd, RECTANGLE, [&x, &y], &asked);
            for round in 0..64 {
                let size = 0.5_f32.powi(round / 8);
                let boxes: [[f32; LANES]; 4] = std::array::from_fn(|side| {
                    std::array::from_fn(|lane| {
                        let index = round as usize * LANES + lane;
                        let (x, y) = (scattered(index, 0.549_700), scattered(index, 0.324_717));
                        match side {
                            0 => left + width * (x * 1.2 - 0.1) - size * 0.5,
                            1 => left + width * (x * 1.2 - 0.1) + size * 0.5,
                            2 => bottom + height * (y * 1.2 - 0.1) - size,
                            _ if lane == 0 => f32::INFINITY,
                            _ => bottom + height * (y * 1.2 - 0.1) + size,
                        }
                    })
                });
                let sides = boxes.each_ref().map(|side| F32x16::load(simd, side));
                let places = grid.places(simd, sides);
                for lane in 0..LANES {
                    let [l, r, b, t] = boxes.each_ref().map(|side| side[lane]);
                    // Packets with rays in a box that is larger by some part of a cell.
                    let packets = |give: f32| {
                        let (over_x, over_y) = (give * width, give * height);
                        let holds = |&ray: &usize| {
                            asked[ray / LANES] >> (ray % LANES) & 1 == 1
                                && (l - over_x..=r + over_x).contains(&x[ray])
                                && (b - over_y..=t + over_y).contains(&y[ray])
                        };
                        let rays = (0..BATCH).filter(holds);
                        rays.fold(0, |packets, ray| packets | 1 << (ray / LANES))
                    };
                    let found = grid.packets(&places, lane);
                    assert_eq!(packets(0.0) & !found, 0, "none is missed");
                    // A box beyond the rectangle counts as at its border.
                    let is_inside = l <= right && r >= left && b <= top && t >= bottom;
                    let most = packets(1.01 / CELLS as f32);
                    assert!(!is_inside || found & !most == 0, "nothing far from the box");
                }
            }
        }
    }

    #[test]
    fn boxes_find_their_rays() {
        for (_, level) in SimdLevel::available() {
            level.run(Boxes);
        }
    }

    #[test]
    fn packets_of_rays() {
        assert_eq!(RaySet([0; 4]).packets(), 0);
        assert_eq!(RaySet([u64::MAX; 4]).packets(), 0xffff);
        for ray in 0..BATCH {
            let mut set = RaySet::NONE;
            set.0[ray / 64] = 1 << (ray % 64);
            assert_eq!(set.packets(), 1 << (ray / LANES));
        }
    }
}
