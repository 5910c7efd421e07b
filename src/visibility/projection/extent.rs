//! How far shapes reach on a [`BatchProjection`](super::BatchProjection).

use fearless_simd::Simd;

use crate::simd::{F32x16, LANES};
use crate::visibility::batch::Row;

/// The box of a shape on the projection, and the largest reciprocal depth of any of its points.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct Extent {
    pub(in crate::visibility) x: [f32; 2],
    pub(in crate::visibility) y: [f32; 2],
    pub(in crate::visibility) most: f32,
}

impl Extent {
    /// Anywhere.
    pub(in crate::visibility) const EVERYTHING: Self = Self {
        x: [f32::NEG_INFINITY, f32::INFINITY],
        y: [f32::NEG_INFINITY, f32::INFINITY],
        most: f32::INFINITY,
    };
}

/// The extents of sixteen shapes, and what all rays of a bounded projection meet of them.
#[derive(Clone, Debug)]
pub(in crate::visibility) struct Extents {
    /// The least and the largest x and y.
    pub(in crate::visibility) boxes: [Row; 4],
    /// The largest reciprocal depth.
    pub(in crate::visibility) most: Row,
    /// One bit for each shape that all rays of a projection that is only bounded surely meet, and the range of its
    /// reciprocal depth.
    pub(in crate::visibility) covers: u32,
    pub(in crate::visibility) ranges: [Row; 2],
}

impl Default for Extents {
    fn default() -> Self {
        let row = Row([0.0; LANES]);
        Self {
            boxes: [row; 4],
            most: row,
            covers: 0,
            ranges: [row; 2],
        }
    }
}

impl Extents {
    /// Takes the least and the largest x and y, and the largest reciprocal depths.
    #[inline(always)]
    pub(in crate::visibility) fn store<S: Simd>(&mut self, boxes: [F32x16<S>; 4], most: F32x16<S>) {
        let [left, right, bottom, top] = boxes;
        left.store(&mut self.boxes[0].0);
        right.store(&mut self.boxes[1].0);
        bottom.store(&mut self.boxes[2].0);
        top.store(&mut self.boxes[3].0);
        most.store(&mut self.most.0);
    }

    /// Takes what covers a bounded projection, and the ranges of reciprocal depths within it.
    #[inline(always)]
    pub(in crate::visibility) fn cover_with<S: Simd>(
        &mut self,
        covers: u32,
        [least, most]: [F32x16<S>; 2],
    ) {
        self.covers = covers;
        least.store(&mut self.ranges[0].0);
        most.store(&mut self.ranges[1].0);
    }

    #[inline(always)]
    pub(in crate::visibility) fn get(&self, index: usize) -> Extent {
        let [left, right, bottom, top] = &self.boxes;
        Extent {
            x: [left.0[index], right.0[index]],
            y: [bottom.0[index], top.0[index]],
            most: self.most.0[index],
        }
    }

    /// The range of the reciprocal depth of a shape that all rays of a bounded projection surely meet.
    #[inline]
    pub(in crate::visibility) fn cover(&self, index: usize) -> Option<[f32; 2]> {
        let covers = self.covers >> index & 1 == 1;
        covers.then(|| [self.ranges[0].0[index], self.ranges[1].0[index]])
    }

    /// The largest reciprocal depth of a shape within a bounded projection.
    #[inline]
    pub(in crate::visibility) fn most_within(&self, index: usize) -> f32 {
        self.ranges[1].0[index]
    }
}
