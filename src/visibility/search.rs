//! All shapes of one kind: a list to go through, or a tree over it.

use rayon::prelude::*;

use super::bundle::Bundle;
use super::bvh::{Bounds, Bvh, Member};
use super::descent::LARGEST_BATCH;
use crate::math::Ray;
use crate::world::plan::{Acceleration, LONGEST_LIST};

/// How much the box of a shape gives way to a bundle, per unit of distance: the rounding in f64 of
/// a few operations, with room.
const GIVES_WAY: f64 = 64.0 * f64::EPSILON;

/// A shape that fits in a box.
pub(super) trait Bounded: Send + Sync {
    /// The smallest box around it.
    fn bounds(&self) -> Bounds;
}

/// A shape that is this many times larger than the middle one is kept out of the tree: its boxes
/// give way in proportion to the whole, and a planet would blur the pebbles on it.
const OUTSIZED: f64 = 1000.0;

/// All shapes of one kind.
#[derive(Debug)]
pub(super) struct Search<S> {
    /// Those that are gone through one by one.
    listed: Vec<S>,
    tree: Option<Tree<S>>,
}

/// Shapes, in the order in which the tree's leaves have them.
#[derive(Debug)]
struct Tree<S> {
    shapes: Vec<S>,
    tree: Bvh,
}

/// The shapes of one kind that a batch of rays could meet.
#[derive(Debug)]
pub(super) struct Candidates<'s, S> {
    listed: Vec<S>,
    /// Those below the roots, which are parts of the tree.
    tree: Option<(&'s Tree<S>, Vec<Member>)>,
}

impl<S: Bounded + Copy> Search<S> {
    pub(super) fn new(shapes: Vec<S>, acceleration: Acceleration) -> Self {
        match acceleration {
            Acceleration::None | Acceleration::List => Self {
                listed: shapes,
                tree: None,
            },
            Acceleration::Tree => {
                let (listed, shapes) = without_outsized(shapes);
                let (tree, order) = Bvh::new(&shapes);
                let shapes = order
                    .par_iter()
                    .map(|&index| shapes[index as usize])
                    .collect();
                Self {
                    listed,
                    tree: Some(Tree { shapes, tree }),
                }
            }
        }
    }

    /// The shapes that a ray of the bundle could meet.
    pub(super) fn within(&self, bundle: &Bundle) -> Candidates<'_, S> {
        let may_meet = |shape: &S| {
            let bounds = shape.bounds();
            bundle.may_meet(&bounds.grown((bundle.reach() + bounds.reach()) * GIVES_WAY))
        };
        Candidates {
            listed: self.listed.iter().copied().filter(may_meet).collect(),
            tree: self.tree.as_ref().map(|tree| (tree, tree.tree.cut(bundle))),
        }
    }

    /// Bytes of the shapes and their tree.
    pub(super) fn memory(&self) -> usize {
        let tree = |tree: &Tree<S>| size_of_val(tree.shapes.as_slice()) + tree.tree.memory();
        size_of_val(self.listed.as_slice()) + self.tree.as_ref().map_or(0, tree)
    }
}

/// The few shapes that are far larger than the others, and the others.
fn without_outsized<S: Bounded + Copy>(shapes: Vec<S>) -> (Vec<S>, Vec<S>) {
    let extent = |shape: &S| {
        let Bounds { min, max } = shape.bounds();
        (max - min).max_element()
    };
    let mut extents: Vec<f64> = shapes.par_iter().map(extent).collect();
    let middle = extents.len() / 2;
    let (_, &mut median, _) = extents.select_nth_unstable_by(middle, f64::total_cmp);
    let is_outsized = |shape: &S| extent(shape) > median * OUTSIZED;
    match shapes.par_iter().filter(|shape| is_outsized(shape)).count() {
        1..=LONGEST_LIST => shapes.into_iter().partition(is_outsized),
        _ => (Vec::new(), shapes),
    }
}

impl<S> Candidates<'_, S> {
    /// Whether no ray of the batch can meet anything.
    pub(super) fn is_empty(&self) -> bool {
        let tree_is_empty = |(_, roots): &(_, Vec<Member>)| roots.is_empty();
        self.listed.is_empty() && self.tree.as_ref().is_none_or(tree_is_empty)
    }

    /// Shows `found` the shapes that each ray may meet at t from 0 to its limit, with the ray's
    /// index. `found` gives back the ray's new limit, below 0 if the ray is done; `limits` keeps it.
    pub(super) fn visit(
        &self,
        rays: &[Ray],
        limits: &mut [f64],
        mut found: impl FnMut(&S, usize) -> f64,
    ) {
        for (index, limit) in limits.iter_mut().enumerate() {
            for shape in &self.listed {
                if *limit >= 0.0 {
                    *limit = found(shape, index);
                }
            }
        }
        let Some((Tree { shapes, tree }, roots)) = &self.tree else {
            return;
        };
        let batches = rays
            .chunks(LARGEST_BATCH)
            .zip(limits.chunks_mut(LARGEST_BATCH));
        for (number, (rays, limits)) in batches.enumerate() {
            let mut batch = tree.batch(rays, limits);
            tree.descend(roots, &mut batch, |leaf, index| {
                for shape in &shapes[leaf] {
                    if limits[index] >= 0.0 {
                        limits[index] = found(shape, number * LARGEST_BATCH + index);
                    }
                }
                limits[index]
            });
        }
    }
}
