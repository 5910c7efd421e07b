//! What visibility takes, counted: a regression is seen without a clock.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use serde::Serialize;

/// What it took to see points and to find out which lights reach them, where rays share a point or a direction.
///
/// It is the same for any number of threads. It depends on the instructions: f32 decides with fused multiply-adds where
/// there are any, so that more or fewer rays fall back, and tells the image nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Work {
    /// For primary rays.
    pub primary: RayWork,
    /// For shadow rays.
    pub shadow: RayWork,
}

/// What it took to answer rays of a kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct RayWork {
    /// How often rays were asked together, at most 256 of them: camera rays, or points and a light. Points too far
    /// apart for one projection count once for each group of them.
    pub batches: u64,
    /// Of these, those that were answered as a whole, without any of their rays: all see one shape or nothing, all are
    /// lit, or one shape hides all.
    pub resolved_whole: u64,
    /// Rays that were asked in f64, because f32 could not decide what they meet, or because they were too few or too
    /// far apart for a projection. All other rays are resolved in f32.
    pub fallbacks: u64,
    /// How often the triangles of a leaf, at most sixteen of them, were set up before a batch.
    pub leaves: u64,
    /// How many different leaves these are, for each light by itself; `None` if telling them apart would take more than
    /// 64 MB.
    pub distinct_leaves: Option<u64>,
    /// How many bytes of leaf blocks were read for it: all that a projection knows of a leaf, each time.
    pub leaf_bytes: u64,
    /// How often a triangle was tested against a packet, the samples of sixteen rays, in f32.
    pub pairs: u64,
}

impl Work {
    /// That of both.
    #[inline]
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            primary: self.primary.and(other.primary),
            shadow: self.shadow.and(other.shadow),
        }
    }
}

impl RayWork {
    #[inline]
    fn and(self, other: Self) -> Self {
        Self {
            batches: self.batches + other.batches,
            resolved_whole: self.resolved_whole + other.resolved_whole,
            fallbacks: self.fallbacks + other.fallbacks,
            leaves: self.leaves + other.leaves,
            // Only a whole render knows it.
            distinct_leaves: self.distinct_leaves.or(other.distinct_leaves),
            leaf_bytes: self.leaf_bytes + other.leaf_bytes,
            pairs: self.pairs + other.pairs,
        }
    }
}

/// More than this many bytes are not spent on telling leaves apart.
const MOST_BYTES: usize = 1 << 26;

/// Which leaves were set up, seen from the eye and from each light: a bit for each leaf block, for all threads.
#[derive(Debug)]
pub(crate) struct MetLeaves {
    /// Those of the eye first, then those of light after light.
    words: Vec<AtomicU64>,
    /// For each of them.
    words_of_origin: usize,
}

impl MetLeaves {
    /// None yet of so many leaf blocks, as seen from so many origins; `None` if that is too much to be counted.
    pub(super) fn none(blocks: usize, origins: usize) -> Option<Arc<Self>> {
        let words_of_origin = blocks.div_ceil(u64::BITS as usize);
        let count = words_of_origin.checked_mul(origins)?;
        (count <= MOST_BYTES / size_of::<AtomicU64>()).then(|| {
            let words = (0..count).map(|_| AtomicU64::new(0)).collect();
            Arc::new(Self {
                words,
                words_of_origin,
            })
        })
    }

    /// Takes note of a leaf block.
    #[inline]
    pub(super) fn meet(&self, origin: usize, block: usize) {
        let word = &self.words[origin * self.words_of_origin + block / u64::BITS as usize];
        let bit = 1 << (block % u64::BITS as usize);
        // Most leaves have been met before, and reading is cheaper.
        if word.load(Ordering::Relaxed) & bit == 0 {
            word.fetch_or(bit, Ordering::Relaxed);
        }
    }

    /// How many there are, once all threads are done.
    pub(crate) fn count_into(&self, work: &mut Work) {
        let (of_eye, of_lights) = self.words.split_at(self.words_of_origin);
        let count = |words: &[AtomicU64]| {
            let ones = |word: &AtomicU64| u64::from(word.load(Ordering::Relaxed).count_ones());
            words.iter().map(ones).sum()
        };
        work.primary.distinct_leaves = Some(count(of_eye));
        work.shadow.distinct_leaves = Some(count(of_lights));
    }
}
