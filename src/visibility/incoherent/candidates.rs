//! Triangles that rays may meet, as far as f32 can tell.

use fearless_simd::Simd;

use crate::math::all_three;
use crate::simd::{DVec3x16, LANES, U64x16};
use crate::visibility::batch::{BATCH, Column, first_lanes};
use crate::visibility::ray_batch::IncoherentRays;
use crate::visibility::rays::Rays;
use crate::visibility::search::Way;
use crate::visibility::shape::{SingleRay, TrianglePerRay, side_by_side};
use crate::visibility::shapes::Shapes;
use crate::visibility::tree::Descents;

/// What a thread needs for batches, to be used again and again.
#[derive(Debug)]
pub(crate) struct Candidates {
    pub(super) descents: Descents,
    pub(super) pairs: Vec<Pair>,
}

/// A ray of a batch, and the number of a triangle that it may meet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    pub(super) ray: u32,
    pub(super) triangle: u32,
}

/// The candidates of one ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shortlist {
    /// The least t at which each is met, if it is.
    pub(super) least: [f64; LANES],
    pub(super) triangles: [u32; LANES],
    pub(super) len: usize,
}

impl Default for Candidates {
    fn default() -> Self {
        Self {
            descents: Default::default(),
            pairs: Vec::with_capacity(2 * BATCH),
        }
    }
}

/// The vectors of some rays in three columns.
#[inline(always)]
pub(super) fn gathered<S: Simd>(simd: S, columns: &[Column; 3], pairs: &[Pair]) -> DVec3x16<S> {
    let gathered = all_three(
        [0, 1, 2],
        #[inline(always)]
        |axis: usize| {
            let mut numbers = [0.0; LANES];
            for (number, pair) in numbers.iter_mut().zip(pairs) {
                *number = columns[axis][pair.ray as usize];
            }
            numbers
        },
    );
    let [x, y, z] = &gathered;
    DVec3x16::load(simd, [x, y, z])
}

impl Shortlist {
    /// Puts one more on it; there is room.
    #[inline(always)]
    pub(super) fn push(&mut self, least: f64, triangle: u32) {
        self.least[self.len] = least;
        self.triangles[self.len] = triangle;
        self.len += 1;
    }

    /// Drops those that are certainly met after t of `limit`.
    #[inline]
    pub(super) fn keep_up_to(&mut self, limit: f64) {
        let mut kept = 0;
        for place in 0..self.len {
            if self.least[place] <= limit {
                self.least[kept] = self.least[place];
                self.triangles[kept] = self.triangles[place];
                kept += 1;
            }
        }
        self.len = kept;
    }

    /// As pairs with a ray.
    pub(super) fn pairs(&self, ray: usize) -> impl Iterator<Item = Pair> {
        let triangles = self.triangles.iter().take(self.len);
        triangles.map(move |&triangle| Pair {
            ray: ray as u32,
            triangle,
        })
    }

    /// The same, for all at once.
    pub(super) fn all_pairs(&self, ray: usize) -> [Pair; LANES] {
        let mut pairs = [Pair {
            ray: ray as u32,
            triangle: 0,
        }; LANES];
        for (pair, listed) in pairs.iter_mut().zip(self.pairs(ray)) {
            *pair = listed;
        }
        pairs
    }
}

/// A ray on its way along triangles, and its candidates.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurrentRay {
    pub(super) ray: usize,
    pub(super) single: SingleRay,
    pub(super) limit: f64,
    pub(super) list: Shortlist,
}

impl CurrentRay {
    pub(super) const NONE: Self = Self {
        ray: 0,
        single: SingleRay::NONE,
        limit: 0.0,
        list: Shortlist {
            least: [0.0; LANES],
            triangles: [0; LANES],
            len: 0,
        },
    };

    #[inline(always)]
    pub(super) fn set(&mut self, ray: usize, way: &Way) {
        self.ray = ray;
        self.single = SingleRay::new(way.origin, way.direction);
        self.limit = way.limit;
        self.list.len = 0;
    }
}

impl IncoherentRays {
    /// The rays of at most sixteen pairs.
    #[inline(always)]
    pub(super) fn gathered<S: Simd>(&self, simd: S, pairs: &[Pair]) -> Rays<S> {
        let [origin, direction] = self.vectors();
        Rays::new(
            gathered(simd, origin, pairs),
            gathered(simd, direction, pairs),
            None,
        )
    }
}

impl Shapes<'_> {
    /// The triangles of at most sixteen pairs.
    #[inline(always)]
    pub(super) fn triangles_of<S: Simd>(
        &self,
        simd: S,
        pairs: &[Pair],
    ) -> (TrianglePerRay<S>, [u64; LANES]) {
        let asked = first_lanes(pairs.len(), 0);
        let mut primitives = [u64::MAX; LANES];
        for (primitive, pair) in primitives.iter_mut().zip(pairs) {
            *primitive = self.triangles.primitive(pair.triangle).0;
        }
        let corners = side_by_side(
            simd,
            asked,
            #[inline(always)]
            |lane| self.triangles.get(pairs[lane].triangle).vertices(),
        );
        let triangles = TrianglePerRay {
            corners,
            primitive: U64x16::load(simd, &primitives),
            asked,
        };
        (triangles, primitives)
    }
}
