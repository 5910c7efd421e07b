//! All shapes of one kind: a list to go through, or a tree over it.

use fearless_simd::Simd;

use super::bundle::Bundle;
use super::bvh::Bounds;
use super::nodes::{Node, Tree};
use super::packet::{Nearest, Question, Rays, Shadow, Stack, descend};
use crate::world::plan::{Acceleration, LONGEST_LIST};

/// How much the box of a shape gives way to a bundle, per unit of distance: the rounding in f64 of
/// a few operations, with room.
const GIVES_WAY: f64 = 64.0 * f64::EPSILON;

/// A shape that fits in a box.
pub(super) trait Shape: Copy + Send + Sync {
    /// The smallest box around it.
    fn bounds(&self) -> Bounds;

    /// L2: offers where the rays hit it at t above 0.
    fn intersect<S: Simd>(&self, simd: S, rays: &Rays<S>, nearest: &mut Nearest<S>);

    /// L4: hides the points that it stands strictly before.
    fn occlude<S: Simd>(&self, simd: S, rays: &Rays<S>, shadow: &mut Shadow<'_, S>);
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

/// The shapes of one kind that a batch of rays could meet.
#[derive(Debug)]
pub(super) struct Candidates<'s, T> {
    listed: Vec<T>,
    /// The tree, and the nodes that the batch enters it by.
    tree: Option<(&'s Tree<T>, Vec<Node>)>,
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

    /// The shapes that a ray of the bundle could meet.
    pub(super) fn within(&self, bundle: &Bundle) -> Candidates<'_, T> {
        let may_meet = |shape: &T| {
            let bounds = shape.bounds();
            bundle.may_meet(&bounds.grown((bundle.reach() + bounds.reach()) * GIVES_WAY))
        };
        let entered = self.tree.as_ref().map(|tree| (tree, tree.entries(bundle)));
        Candidates {
            listed: self.listed.iter().copied().filter(may_meet).collect(),
            tree: entered.filter(|(_, entries)| !entries.is_empty()),
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

impl<T: Shape> Candidates<'_, T> {
    /// Whether no ray of the batch can meet anything.
    pub(super) fn is_empty(&self) -> bool {
        self.listed.is_empty() && self.tree.is_none()
    }

    /// Puts a packet's question to every shape that its rays may meet.
    #[inline(never)]
    pub(super) fn ask<S: Simd>(
        &self,
        simd: S,
        rays: &Rays<S>,
        question: &mut impl Question<S>,
        stack: &mut Stack,
    ) {
        if self.is_empty() {
            return;
        }
        simd.vectorize(
            #[inline(always)]
            || self.ask_all(simd, rays, question, stack),
        );
    }

    #[inline(always)]
    fn ask_all<S: Simd>(
        &self,
        simd: S,
        rays: &Rays<S>,
        question: &mut impl Question<S>,
        stack: &mut Stack,
    ) {
        for shape in &self.listed {
            if question.asked() == 0 {
                return;
            }
            question.ask(simd, rays, shape);
        }
        if let Some((tree, entries)) = &self.tree {
            descend(simd, tree, entries, rays, question, stack);
        }
    }
}
