//! All shapes of one kind: a list to go through, or a tree over it.

use super::bundle::Bundle;
use super::bvh::{Bounds, Bvh, Member};
use crate::math::Ray;
use crate::world::plan::Acceleration;

/// How much the box of a shape gives way to a bundle, per unit of distance: the rounding in f64 of
/// a few operations, with room.
const GIVES_WAY: f64 = 64.0 * f64::EPSILON;

/// A shape that fits in a box.
pub(super) trait Bounded {
    /// The smallest box around it.
    fn bounds(&self) -> Bounds;
}

/// The shapes of one kind, in the order in which the tree's leaves have them.
#[derive(Debug)]
pub(super) struct Search<S> {
    shapes: Vec<S>,
    tree: Option<Bvh>,
}

/// The shapes of one kind that a batch of rays could meet.
#[derive(Debug)]
pub(super) enum Candidates<'s, S> {
    /// These.
    List(Vec<S>),
    /// Those below the roots, which are parts of the tree.
    Tree {
        shapes: &'s [S],
        tree: &'s Bvh,
        roots: Vec<Member>,
    },
}

impl<S: Bounded + Copy> Search<S> {
    pub(super) fn new(shapes: Vec<S>, acceleration: Acceleration) -> Self {
        match acceleration {
            Acceleration::None | Acceleration::List => Self { shapes, tree: None },
            Acceleration::Tree => {
                let (tree, order) = Bvh::new(&shapes);
                Self {
                    shapes: order.iter().map(|&index| shapes[index as usize]).collect(),
                    tree: Some(tree),
                }
            }
        }
    }

    /// The shapes that a ray of the bundle could meet.
    pub(super) fn within(&self, bundle: &Bundle) -> Candidates<'_, S> {
        match &self.tree {
            Some(tree) => Candidates::Tree {
                shapes: &self.shapes,
                tree,
                roots: tree.cut(bundle),
            },
            None => {
                let may_meet = |shape: &S| {
                    let bounds = shape.bounds();
                    bundle.may_meet(&bounds.grown((bundle.reach() + bounds.reach()) * GIVES_WAY))
                };
                Candidates::List(self.shapes.iter().copied().filter(may_meet).collect())
            }
        }
    }

    /// Bytes of the shapes and their tree.
    pub(super) fn memory(&self) -> usize {
        size_of_val(self.shapes.as_slice()) + self.tree.as_ref().map_or(0, Bvh::memory)
    }
}

impl<S> Candidates<'_, S> {
    /// Whether no ray of the batch can meet anything.
    pub(super) fn is_empty(&self) -> bool {
        match self {
            Self::List(shapes) => shapes.is_empty(),
            Self::Tree { roots, .. } => roots.is_empty(),
        }
    }

    /// Shows `found` the shapes that each ray may meet at t from 0 to its limit, with the ray's
    /// index. `found` gives back the ray's new limit, below 0 if the ray is done.
    pub(super) fn visit(
        &self,
        rays: &[Ray],
        limits: &[f64],
        mut found: impl FnMut(&S, usize) -> f64,
    ) {
        match self {
            Self::List(shapes) => {
                for (index, &limit) in limits.iter().enumerate() {
                    let mut limit = limit;
                    for shape in shapes {
                        if limit >= 0.0 {
                            limit = found(shape, index);
                        }
                    }
                }
            }
            Self::Tree {
                shapes,
                tree,
                roots,
            } => {
                let mut batch = tree.batch(rays, limits);
                tree.descend(roots, &mut batch, |leaf, index| {
                    let mut limit = 0.0;
                    for shape in &shapes[leaf] {
                        limit = found(shape, index);
                        if limit < 0.0 {
                            break;
                        }
                    }
                    limit
                });
            }
        }
    }
}
