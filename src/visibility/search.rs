//! All shapes of one kind: a list to go through, or a tree over it.

use fearless_simd::Simd;

use super::bvh::Bounds;
use super::canvas::{Canvas, Verdict};
use super::nodes::Tree;
use super::outline::Outlines;
use super::packet::{Nearest, Packet, Question, Shadow, Stack, descend, sweep};
use crate::lanes::LANES;
use crate::math::DVec3;
use crate::world::plan::{Acceleration, LONGEST_LIST};

/// A shape that fits in a box.
pub(super) trait Shape: Copy + Send + Sync {
    /// The smallest box around it.
    fn bounds(&self) -> Bounds;

    /// L2: offers where the rays hit it at t above 0.
    fn intersect<S: Simd>(&self, simd: S, packet: &Packet<S>, nearest: &mut Nearest<S>);

    /// L4: hides the points that it stands strictly before.
    fn occlude<S: Simd>(&self, simd: S, packet: &Packet<S>, shadow: &mut Shadow<'_, S>);

    /// What the slots of this kind of shape have in common.
    const SLOTS: u32;

    /// Whether it is certain, and soon told, that no ray on a canvas meets it.
    fn is_beside(&self, canvas: &Canvas) -> bool;

    /// Puts shapes on a canvas, sixteen at most, by their places.
    fn cast<'s, S: Simd>(
        simd: S,
        places: &[u32],
        shape: impl Fn(u32) -> &'s Self,
        outlines: &mut Outlines,
        canvas: &mut Canvas,
        verdict: impl Verdict,
    ) where
        Self: 's;
}

/// A shape that is this many times larger than the middle one is kept out of the tree: its boxes
/// give way in proportion to the whole, and a planet would blur the pebbles on it.
const OUTSIZED: f64 = 1000.0;

/// All shapes of one kind.
#[derive(Debug)]
pub(super) struct Search<T> {
    /// Those that are gone through one by one.
    listed: Vec<T>,
    tree: Option<Tree<T>>,
}

impl<T: Shape> Search<T> {
    pub(super) fn new(shapes: Vec<T>, acceleration: Acceleration) -> Self {
        match acceleration {
            Acceleration::None | Acceleration::List => Self {
                listed: shapes,
                tree: None,
            },
            Acceleration::Tree => {
                let (listed, shapes) = without_outsized(shapes);
                Self {
                    listed,
                    tree: Some(Tree::new(&shapes)),
                }
            }
        }
    }

    /// The shape in a place: first the listed ones, then those of the tree.
    #[inline(always)]
    pub(super) fn get(&self, place: u32) -> &T {
        let place = place as usize;
        match &self.tree {
            Some(tree) if place >= self.listed.len() => &tree.shapes[place - self.listed.len()],
            _ => &self.listed[place],
        }
    }

    /// A point amid the shapes, if there are any.
    pub(super) fn somewhere(&self) -> Option<DVec3> {
        let listed = self.listed.first().map(|shape| {
            let Bounds { min, max } = shape.bounds();
            min * 0.5 + max * 0.5
        });
        self.tree.as_ref().map(|tree| tree.center).or(listed)
    }

    /// Puts every shape that the rays on a canvas may meet on it.
    #[inline(never)]
    pub(super) fn cast<S: Simd>(
        &self,
        simd: S,
        canvas: &mut Canvas,
        outlines: &mut Outlines,
        stack: &mut Stack,
        verdict: impl Verdict,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.cast_all(simd, canvas, outlines, stack, verdict),
        );
    }

    #[inline(always)]
    fn cast_all<S: Simd>(
        &self,
        simd: S,
        canvas: &mut Canvas,
        outlines: &mut Outlines,
        stack: &mut Stack,
        verdict: impl Verdict,
    ) {
        let listed = self.listed.len() as u32;
        let mut places = [0; LANES];
        let mut count = 0;
        for (place, shape) in (0..listed).zip(&self.listed) {
            if !shape.is_beside(canvas) {
                places[count] = place;
                count += 1;
            }
            if count == LANES || count > 0 && place + 1 == listed {
                T::cast(
                    simd,
                    &places[..count],
                    #[inline(always)]
                    |place| self.get(place),
                    outlines,
                    canvas,
                    verdict,
                );
                count = 0;
            }
        }
        if let Some(tree) = &self.tree {
            sweep(
                simd,
                tree,
                listed,
                canvas,
                stack,
                #[inline(always)]
                |places, canvas| {
                    T::cast(
                        simd,
                        places,
                        #[inline(always)]
                        |place| self.get(place),
                        outlines,
                        canvas,
                        verdict,
                    );
                },
            );
        }
    }

    /// Puts a packet's question to every shape that its rays may meet.
    #[inline(never)]
    pub(super) fn ask<S: Simd>(
        &self,
        simd: S,
        packet: &Packet<S>,
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
        packet: &Packet<S>,
        question: &mut impl Question<S>,
        stack: &mut Stack,
    ) {
        for shape in &self.listed {
            if question.asked() == 0 {
                return;
            }
            question.ask(simd, packet, shape);
        }
        if let Some(tree) = &self.tree {
            descend(simd, tree, packet, question, stack);
        }
    }

    /// Bytes of the shapes and their tree.
    pub(super) fn memory(&self) -> usize {
        let tree = self.tree.as_ref().map_or(0, Tree::memory);
        size_of_val(self.listed.as_slice()) + tree
    }
}

/// The few shapes that are far larger than the others, and the others.
fn without_outsized<T: Shape>(shapes: Vec<T>) -> (Vec<T>, Vec<T>) {
    let extent = |shape: &T| {
        let Bounds { min, max } = shape.bounds();
        (max - min).max_element()
    };
    let mut extents: Vec<f64> = shapes.iter().map(extent).collect();
    let middle = extents.len() / 2;
    let (_, &mut median, _) = extents.select_nth_unstable_by(middle, f64::total_cmp);
    let is_outsized = |shape: &T| extent(shape) > median * OUTSIZED;
    if shapes.iter().filter(|shape| is_outsized(shape)).count() > LONGEST_LIST {
        return (Vec::new(), shapes);
    }
    shapes.into_iter().partition(is_outsized)
}
