//! All shapes of one kind: a list to go through, or a tree over it.

mod packets;

use fearless_simd::Simd;
use rayon::prelude::*;

pub(super) use packets::{AlongInPackets, AskedPacket};

use super::packet::{Question, descend};
use super::primitive::Primitive;
use super::projection::{BatchProjection, DepthTest};
use super::rays::ShearedRays;
use super::shape::{Block, Shape};
use super::tree::{
    Approach, BlockRange, Bounds, Descent, HalfSpace, PlacedPart, Stack, Step, Tree, TreeFrame,
    TreeRay, TreeVolume, blocks_of,
};
use crate::math::DVec3;
use crate::simd::{LANES, ones};
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
    /// Where the shapes are as they are, if the blocks are quantized.
    exact: T::Exact,
    /// All shapes as projections take them: first the listed ones, then those of the tree, leaf by leaf.
    blocks: Vec<T::Block>,
    /// How many are gone through one by one.
    listed: usize,
    tree: Option<Tree>,
    /// The tree's, or one around the listed shapes.
    frame: TreeFrame,
}

/// The shapes of one kind, by their numbers.
pub(super) trait NumberedShapes<T: Shape>: Sync {
    fn count(&self) -> u32;

    fn shape(&self, number: u32) -> T;

    /// The smallest box around a shape, which takes less than the shape.
    fn bounds(&self, number: u32) -> Bounds;

    /// What there is besides blocks.
    fn exact(&self) -> T::Exact;
}

/// A ray as it sets out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
    /// What is this far beside it counts as met.
    pub(super) error: f64,
    /// How far it goes, in t.
    pub(super) limit: f64,
}

/// What rays ask on their way along blocks, some at once.
pub(super) trait Along<S: Simd, B> {
    /// A ray of the batch takes a place below [`LANES`], if it asks for anything.
    fn begin(&mut self, place: usize, ray: usize) -> Option<Way>;

    /// Asks the shapes of a block with a bit for the ray at a place; how far to go from then on, if at all.
    fn show(&mut self, simd: S, place: usize, block: &B, bits: u32) -> Option<f64>;

    /// The ray at a place has asked them all.
    fn end(&mut self, place: usize);
}

impl<T: Shape> Search<T> {
    /// All of these shapes.
    pub(super) fn new(shapes: &impl NumberedShapes<T>, acceleration: Acceleration) -> Self {
        let listed = match acceleration {
            Acceleration::None | Acceleration::List => (0..shapes.count()).collect(),
            Acceleration::Tree => outsized(shapes),
        };
        Self::in_one_tree(shapes, listed)
    }

    /// In one tree, but the `listed` ones.
    pub(super) fn in_one_tree(shapes: &impl NumberedShapes<T>, listed: Vec<u32>) -> Self {
        let mut members = Vec::new();
        members.extend(blocks_of(0, listed.len() as u32, T::WIDTH));
        let mut order = listed;
        let listed = order.len();
        let tree = (listed < shapes.count() as usize).then(|| {
            let bounds = |number| shapes.bounds(number);
            let (tree, mut treed) =
                Tree::new(shapes.count(), T::WIDTH, &bounds, &order, &mut members);
            treed.splice(..0, order.drain(..));
            order = treed;
            tree
        });
        Self::of(shapes, &order, listed, tree, &members)
    }

    /// Of parts, each with a tree of its own under a common one, and a few `listed` shapes beside them.
    pub(super) fn of_parts(
        shapes: &impl NumberedShapes<T>,
        parts: &[PlacedPart<'_>],
        listed: Vec<u32>,
    ) -> Self {
        let mut members = Vec::new();
        members.extend(blocks_of(0, listed.len() as u32, T::WIDTH));
        let bounds = |number| shapes.bounds(number);
        let count = listed.len();
        let (tree, mut order) =
            Tree::of_parts(parts, T::WIDTH, &bounds, count as u32, &mut members);
        order.splice(..0, listed);
        Self::of(shapes, &order, count, Some(tree), &members)
    }

    /// Of shapes in the order of their blocks.
    fn of(
        shapes: &impl NumberedShapes<T>,
        order: &[u32],
        listed: usize,
        tree: Option<Tree>,
        members: &[BlockRange],
    ) -> Self {
        let places = members.len() * T::WIDTH;
        assert!(places <= MOST_PLACES, "memory ends before slots do");
        let blocks = members.par_iter().enumerate();
        let blocks = blocks.map(|(index, &BlockRange { first, count })| {
            let numbers = &order[first as usize..(first + count) as usize];
            let mut some = [shapes.shape(numbers[0]); LANES];
            for (place, &number) in some.iter_mut().zip(numbers).skip(1) {
                *place = shapes.shape(number);
            }
            T::Block::of(&some[..numbers.len()], (index * T::WIDTH) as u32)
        });
        let frame = tree.as_ref().map(|tree| TreeFrame {
            center: tree.center,
            scale: tree.scale,
        });
        let frame = frame.unwrap_or_else(|| {
            let bounds = order.iter().map(|&number| shapes.bounds(number));
            TreeFrame::around(bounds.fold(Bounds::NOWHERE, Bounds::union))
        });
        Self {
            blocks: blocks.collect(),
            exact: shapes.exact(),
            listed,
            tree,
            frame,
        }
    }

    /// The shape with a number: of its slot, without what the kind has in common.
    #[inline(always)]
    pub(super) fn get(&self, number: u32) -> T {
        let number = number as usize;
        self.blocks[number / T::WIDTH].get(&self.exact, number % T::WIDTH)
    }

    /// Which shape has a number.
    #[inline(always)]
    pub(super) fn primitive(&self, number: u32) -> Primitive {
        let number = number as usize;
        self.blocks[number / T::WIDTH].primitive(number % T::WIDTH)
    }

    /// How many blocks there are.
    pub(super) fn blocks_count(&self) -> usize {
        self.blocks.len()
    }

    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// A point amid the shapes, if there are any.
    pub(super) fn somewhere(&self) -> Option<DVec3> {
        let first = self.blocks.first().map(|block| {
            let Bounds { min, max } = block.get(&self.exact, 0).bounds();
            min * 0.5 + max * 0.5
        });
        self.tree.as_ref().map(|tree| tree.center).or(first)
    }

    /// At least the largest coordinate of any shape.
    pub(super) fn reach(&self) -> f64 {
        let listed = self.blocks(0, self.listed).flat_map(|(block, _, shapes)| {
            ones(shapes).map(|place| {
                let Bounds { min, max } = block.get(&self.exact, place).bounds();
                min.abs().max(max.abs()).max_element()
            })
        });
        let of_tree = self.tree.as_ref().map_or(0.0, |tree| {
            tree.center.abs().max_element() + tree.reach / tree.scale
        });
        listed.fold(of_tree, f64::max)
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
                bits &= !(u32::from(block.get(&self.exact, place).is_beside(projection)) << place);
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
                question.ask(simd, packet, &block.get(&self.exact, place));
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
                            question.ask(simd, packet, &block.get(&self.exact, place));
                        }
                    }
                },
            );
        }
    }

    /// Takes rays along all blocks that they may meet, near ones first if it is `SORTED`. A few are on their
    /// way at once and take turns: each step of one reads from memory what another step will wait for.
    #[inline(always)]
    pub(super) fn along<S: Simd, A: Along<S, T::Block>, const SORTED: bool>(
        &self,
        simd: S,
        mut rays: impl Iterator<Item = usize>,
        asker: &mut A,
        descents: &mut [Descent],
    ) {
        let mut waiting = 0_u32;
        for (place, descent) in descents.iter_mut().enumerate() {
            let is_on_its_way = self.set_out(simd, place, &mut rays, asker, descent);
            waiting |= u32::from(is_on_its_way) << place;
        }
        let Some(tree) = &self.tree else {
            return;
        };
        while waiting != 0 {
            for place in ones(waiting) {
                let descent = &mut descents[place];
                let is_done = match descent.step::<S, SORTED>(simd, tree) {
                    Step::Opened => false,
                    Step::Leaf { block, count } => {
                        let mut limit = Some(f64::INFINITY);
                        for (block, _, bits) in self.blocks(block as usize, count as usize) {
                            limit = asker.show(simd, place, block, bits);
                            if limit.is_none() {
                                break;
                            }
                        }
                        if let Some(limit) = limit {
                            descent.go_up_to(limit);
                        }
                        limit.is_none()
                    }
                    Step::Done => true,
                };
                if is_done {
                    asker.end(place);
                    let is_on_its_way = self.set_out(simd, place, &mut rays, asker, descent);
                    waiting &= !(u32::from(!is_on_its_way) << place);
                }
                if let Some(block) = descent.look_ahead(tree) {
                    self.blocks[block as usize].touch();
                }
            }
        }
    }

    /// Sets the next ray out that has more to ask than the listed shapes; whether there is one.
    #[inline(always)]
    fn set_out<S: Simd, A: Along<S, T::Block>>(
        &self,
        simd: S,
        place: usize,
        rays: &mut impl Iterator<Item = usize>,
        asker: &mut A,
        descent: &mut Descent,
    ) -> bool {
        for ray in rays {
            let Some(way) = asker.begin(place, ray) else {
                continue;
            };
            let mut limit = Some(way.limit);
            for (block, _, bits) in self.blocks(0, self.listed) {
                if limit.is_some() {
                    limit = asker.show(simd, place, block, bits);
                }
            }
            if let (Some(limit), Some(tree)) = (limit, &self.tree) {
                match TreeRay::approach(tree, way.origin, way.direction, way.error) {
                    Approach::Beside => {}
                    Approach::Towards(ray) => {
                        descent.begin(ray, limit);
                        return true;
                    }
                    Approach::Untold => self.show_all(simd, place, tree, asker),
                }
            }
            asker.end(place);
        }
        false
    }

    /// Shows all blocks of the tree.
    #[cold]
    #[inline(never)]
    fn show_all<S: Simd, A: Along<S, T::Block>>(
        &self,
        simd: S,
        place: usize,
        tree: &Tree,
        asker: &mut A,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                for node in &tree.nodes {
                    for (&block, &count) in node.children.iter().zip(&node.counts) {
                        if count == 0 {
                            continue;
                        }
                        for (block, _, bits) in self.blocks(block as usize, count as usize) {
                            if asker.show(simd, place, block, bits).is_none() {
                                return;
                            }
                        }
                    }
                }
            },
        );
    }

    /// Shows the shapes that may reach into half-spaces and begin no deeper than `depth` along a direction, near
    /// leaves first. `show` says how deep to go from then on, if at all. What is within `error` of a half-space
    /// counts as in it.
    #[inline(always)]
    #[expect(
        clippy::too_many_arguments,
        reason = "a volume, and how to go through it"
    )]
    pub(super) fn within<S: Simd>(
        &self,
        simd: S,
        half_spaces: &[HalfSpace],
        along: DVec3,
        error: f64,
        mut depth: f64,
        stack: &mut Stack,
        mut show: impl FnMut(&T) -> Option<f64>,
    ) {
        for (block, _, bits) in self.blocks(0, self.listed) {
            for place in ones(bits) {
                let Some(next) = show(&block.get(&self.exact, place)) else {
                    return;
                };
                depth = next;
            }
        }
        let Some(tree) = &self.tree else {
            return;
        };
        let volume = TreeVolume::new(tree, half_spaces, along, error);
        volume.descend(
            simd,
            tree,
            depth,
            stack,
            #[inline(always)]
            |block, count| {
                for (block, _, bits) in self.blocks(block as usize, count as usize) {
                    for place in ones(bits) {
                        depth = show(&block.get(&self.exact, place))?;
                    }
                }
                Some(depth)
            },
        );
    }

    /// The numbers of all shapes.
    #[cfg(test)]
    pub(super) fn numbers(&self) -> Vec<u32> {
        let nodes = self.tree.iter().flat_map(|tree| &tree.nodes);
        let leaves = nodes.flat_map(|node| node.children.iter().zip(&node.counts));
        let leaves = leaves.filter(|&(_, &count)| count > 0);
        let leaves = leaves.map(|(&block, &count)| (block as usize, count as usize));
        let blocks = [(0, self.listed)].into_iter().chain(leaves);
        let blocks = blocks.flat_map(|(block, count)| self.blocks(block, count));
        let numbers = blocks.flat_map(|(_, first, bits)| ones(bits).map(move |at| first + at));
        numbers.map(|number| number as u32).collect()
    }

    /// Bytes of the blocks and their tree.
    pub(super) fn memory(&self) -> usize {
        let tree = self.tree.as_ref().map_or(0, Tree::memory);
        size_of_val(self.blocks.as_slice()) + tree
    }
}

/// The few shapes that are far larger than the others, in order.
pub(super) fn outsized<T: Shape>(shapes: &impl NumberedShapes<T>) -> Vec<u32> {
    let extent = |number: u32| {
        let Bounds { min, max } = shapes.bounds(number);
        (max - min).max_element()
    };
    let count = shapes.count();
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
