//! All shapes of one kind: a list to go through, or a tree over it.

use fearless_simd::Simd;
use rayon::prelude::*;

use super::packet::{Question, descend};
use super::projection::{BatchProjection, DepthTest};
use super::rays::ShearedRays;
use super::shape::{Block, Shape};
use super::tree::{Approach, BlockRange, Bounds, Stack, Tree, TreeRay, blocks_of};
use crate::math::DVec3;
use crate::simd::ones;
use crate::world::plan::{Acceleration, LONGEST_LIST};

/// A shape that is this many times larger than the middle one is kept out of the tree: its boxes
/// give way in proportion to the whole, and a planet would blur the pebbles on it.
const OUTSIZED: f64 = 1000.0;

/// Slots of one kind: of triangles 1e9 in 130 GB.
const MOST_PLACES: usize = 1 << 30;

/// The median size is that of so many shapes.
const SAMPLE: u32 = 4096;

/// All shapes of one kind.
#[derive(Debug)]
pub(super) struct Search<T: Shape> {
    /// All shapes as they are and in the order of the blocks, if the blocks are quantized.
    shapes: Vec<T>,
    /// All shapes as projections take them: first the listed ones, then those of the tree, leaf by leaf.
    blocks: Vec<T::Block>,
    /// How many are gone through one by one.
    listed: usize,
    tree: Option<Tree>,
}

impl<T: Shape> Search<T> {
    /// `count` shapes, which `shape` gives by their numbers.
    pub(super) fn new(
        count: u32,
        shape: impl Fn(u32) -> T + Sync,
        acceleration: Acceleration,
    ) -> Self {
        let listed: Vec<u32> = match acceleration {
            Acceleration::None | Acceleration::List => (0..count).collect(),
            Acceleration::Tree => outsized(count, &shape),
        };
        let mut members = Vec::new();
        members.extend(blocks_of(0, listed.len() as u32, T::WIDTH));
        let mut order = listed;
        let listed = order.len();
        let tree = (listed < count as usize).then(|| {
            let bounds = |index| shape(index).bounds();
            let (tree, treed) = Tree::new(count, T::WIDTH, &bounds, &order, &mut members);
            order.extend(treed);
            tree
        });
        let shapes = order.par_iter().map(|&index| shape(index));
        let mut shapes: Vec<T> = shapes.collect();
        let blocks: Vec<T::Block> = members
            .par_iter()
            .map(|&BlockRange { first, count }| {
                let shapes = &shapes[first as usize..(first + count) as usize];
                T::Block::of(shapes, first)
            })
            .collect();
        let places = blocks.len() * T::WIDTH;
        assert!(places <= MOST_PLACES, "memory ends before slots do");
        if !T::IS_QUANTIZED {
            shapes = Vec::new();
        }
        Self {
            shapes,
            blocks,
            listed,
            tree,
        }
    }

    /// The shape with a number: of its slot, without what the kind has in common.
    #[inline(always)]
    pub(super) fn get(&self, number: u32) -> T {
        let number = number as usize;
        if T::IS_QUANTIZED {
            return self.shapes[number];
        }
        self.blocks[number / T::WIDTH].get(&self.shapes, number % T::WIDTH)
    }

    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// A point amid the shapes, if there are any.
    pub(super) fn somewhere(&self) -> Option<DVec3> {
        let first = self.blocks.first().map(|block| {
            let Bounds { min, max } = block.get(&self.shapes, 0).bounds();
            min * 0.5 + max * 0.5
        });
        self.tree.as_ref().map(|tree| tree.center).or(first)
    }

    /// The blocks that so many shapes take from a block on, each with the number of its first shape and one
    /// bit for each shape that it has.
    #[inline(always)]
    fn blocks(&self, first: usize, count: usize) -> impl Iterator<Item = (&T::Block, usize, u32)> {
        let starts = (0..count).step_by(T::WIDTH);
        let blocks = self.blocks[first..].iter().zip(starts);
        blocks.map(move |(block, start)| {
            let shapes = T::WIDTH.min(count - start);
            (block, first * T::WIDTH + start, (1 << shapes) - 1)
        })
    }

    /// Rasterizes every shape that the rays of a projection may meet.
    #[inline(never)]
    pub(super) fn rasterize<S: Simd>(
        &self,
        simd: S,
        projection: &mut BatchProjection,
        setup: &mut <T::Block as Block<T>>::Setup,
        stack: &mut Stack,
        depth_test: impl DepthTest,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.rasterize_all(simd, projection, setup, stack, depth_test),
        );
    }

    #[inline(always)]
    fn rasterize_all<S: Simd>(
        &self,
        simd: S,
        projection: &mut BatchProjection,
        setup: &mut <T::Block as Block<T>>::Setup,
        stack: &mut Stack,
        depth_test: impl DepthTest,
    ) {
        for (block, number, shapes) in self.blocks(0, self.listed) {
            let mut bits = shapes;
            for place in ones(shapes) {
                bits &= !(u32::from(block.get(&self.shapes, place).is_beside(projection)) << place);
            }
            if bits != 0 {
                let slot = T::SLOTS | number as u32;
                block.rasterize(simd, bits, slot, setup, projection, depth_test);
            }
        }
        if let Some(tree) = &self.tree {
            let beam = projection.beam(tree);
            beam.descend(
                simd,
                tree,
                projection.look(simd),
                stack,
                #[inline(always)]
                |block, count, next| {
                    if let Some(next) = next {
                        self.blocks[next as usize].touch();
                    }
                    for (block, number, bits) in self.blocks(block as usize, count as usize) {
                        let slot = T::SLOTS | number as u32;
                        block.rasterize(simd, bits, slot, setup, projection, depth_test);
                    }
                    (!projection.gives_up(simd)).then(
                        #[inline(always)]
                        || projection.look(simd),
                    )
                },
            );
        }
    }

    /// Puts a packet's question to every shape that its rays may meet.
    #[inline(never)]
    pub(super) fn ask<S: Simd>(
        &self,
        simd: S,
        packet: &ShearedRays<S>,
        question: &mut impl Question<S>,
        stack: &mut Stack,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.ask_all(simd, packet, question, stack),
        );
    }

    #[inline(always)]
    fn ask_all<S: Simd>(
        &self,
        simd: S,
        packet: &ShearedRays<S>,
        question: &mut impl Question<S>,
        stack: &mut Stack,
    ) {
        for (block, _, shapes) in self.blocks(0, self.listed) {
            for place in ones(shapes) {
                if question.asked() == 0 {
                    return;
                }
                question.ask(simd, packet, &block.get(&self.shapes, place));
            }
        }
        if let Some(tree) = &self.tree {
            descend(
                simd,
                tree,
                packet,
                question,
                stack,
                #[inline(always)]
                |block, count, beam, question| {
                    for (block, _, shapes) in self.blocks(block as usize, count as usize) {
                        for place in ones(shapes & block.near(simd, beam)) {
                            question.ask(simd, packet, &block.get(&self.shapes, place));
                        }
                    }
                },
            );
        }
    }

    /// Shows the blocks that a ray may meet up to t of `limit`, near ones first if it is `SORTED`, each with one
    /// bit for each shape that it has. `show` says how far to go from then on, if at all. What is `error`
    /// beside the ray counts as met.
    #[inline(always)]
    pub(super) fn along<S: Simd, const SORTED: bool>(
        &self,
        simd: S,
        [origin, direction]: [DVec3; 2],
        error: f64,
        mut limit: f64,
        stack: &mut Stack,
        mut show: impl FnMut(&T::Block, u32) -> Option<f64>,
    ) {
        for (block, _, bits) in self.blocks(0, self.listed) {
            let Some(next) = show(block, bits) else {
                return;
            };
            limit = next;
        }
        let Some(tree) = &self.tree else {
            return;
        };
        let ray = match TreeRay::new(tree, origin, direction, error) {
            Approach::Beside => return,
            Approach::Towards(ray) => ray,
            Approach::Untold => {
                for node in &tree.nodes {
                    for (&block, &count) in node.children.iter().zip(&node.counts) {
                        for (block, _, bits) in self.blocks(block as usize, count as usize) {
                            if show(block, bits).is_none() {
                                return;
                            }
                        }
                    }
                }
                return;
            }
        };
        ray.descend::<S, SORTED>(
            simd,
            tree,
            ray.limit(limit),
            stack,
            #[inline(always)]
            |block, count| {
                for (block, _, bits) in self.blocks(block as usize, count as usize) {
                    limit = show(block, bits)?;
                }
                Some(ray.limit(limit))
            },
        );
    }

    /// Bytes of the shapes and their tree.
    pub(super) fn memory(&self) -> usize {
        let tree = self.tree.as_ref().map_or(0, Tree::memory);
        size_of_val(self.shapes.as_slice()) + size_of_val(self.blocks.as_slice()) + tree
    }
}

/// The few shapes that are far larger than the others, in order.
fn outsized<T: Shape>(count: u32, shape: &(impl Fn(u32) -> T + Sync)) -> Vec<u32> {
    let extent = |index: u32| {
        let Bounds { min, max } = shape(index).bounds();
        (max - min).max_element()
    };
    let step = count.div_ceil(SAMPLE) as usize;
    let mut extents: Vec<f64> = (0..count).step_by(step).map(extent).collect();
    let middle = extents.len() / 2;
    let (_, &mut median, _) = extents.select_nth_unstable_by(middle, f64::total_cmp);
    let all = (0..count).into_par_iter();
    let outsized: Vec<u32> = all
        .filter(|&index| extent(index) > median * OUTSIZED)
        .collect();
    if outsized.len() > LONGEST_LIST {
        return Vec::new();
    }
    outsized
}
