//! All shapes of one kind: a list to go through, or a tree over it.

use super::Hit;
use super::bundle::Bundle;
use super::bvh::{Bounds, Bvh, Node, Pending, Viewpoint};
use crate::math::{Point, Ray};
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
        roots: Vec<Node>,
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

    /// Shows `found` every shape that a ray of the batch may hit before `nearest`, roughly near
    /// to far.
    pub(super) fn visit(
        &self,
        ray: &Ray,
        nearest: &mut Option<Hit>,
        stack: &mut Vec<Pending>,
        mut found: impl FnMut(&S, &mut Option<Hit>),
    ) {
        match self {
            Self::List(shapes) => shapes.iter().for_each(|shape| found(shape, nearest)),
            Self::Tree {
                shapes,
                tree,
                roots,
            } => {
                let limit = nearest.map_or(f64::INFINITY, |hit| hit.t);
                tree.visit(roots, ray, limit, stack, |leaf| {
                    for shape in &shapes[leaf] {
                        found(shape, nearest);
                    }
                    nearest.map_or(f64::INFINITY, |hit| hit.t)
                });
            }
        }
    }

    /// Rays that start at `origin`, prepared for [`Candidates::any`].
    pub(super) fn viewpoint(&self, origin: Point) -> Viewpoint {
        match self {
            Self::List(_) => Viewpoint::default(),
            Self::Tree { tree, .. } => tree.viewpoint(origin),
        }
    }

    /// Whether `occludes` holds for any shape that the ray of the batch may hit at t from 0 to 1.
    pub(super) fn any(
        &self,
        viewpoint: &Viewpoint,
        ray: &Ray,
        stack: &mut Vec<Pending>,
        occludes: impl Fn(&S) -> bool,
    ) -> bool {
        match self {
            Self::List(shapes) => shapes.iter().any(occludes),
            Self::Tree {
                shapes,
                tree,
                roots,
            } => tree.any(roots, viewpoint, ray.direction, stack, |leaf| {
                shapes[leaf].iter().any(&occludes)
            }),
        }
    }
}
