//! All shapes of one kind: a list to go through, or a tree over it.

use super::Hit;
use super::bvh::{Bounds, Bvh, Pending, Viewpoint};
use crate::math::{Point, Ray};
use crate::world::plan::Acceleration;

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

    /// Shows `found` every shape that the ray may hit before `nearest`, roughly near to far.
    pub(super) fn visit(
        &self,
        ray: &Ray,
        nearest: &mut Option<Hit>,
        stack: &mut Vec<Pending>,
        mut found: impl FnMut(&S, &mut Option<Hit>),
    ) {
        let Some(tree) = &self.tree else {
            self.shapes.iter().for_each(|shape| found(shape, nearest));
            return;
        };
        let limit = nearest.map_or(f64::INFINITY, |hit| hit.t);
        tree.visit(ray, limit, stack, |leaf| {
            for shape in &self.shapes[leaf] {
                found(shape, nearest);
            }
            nearest.map_or(f64::INFINITY, |hit| hit.t)
        });
    }

    /// A place from which many rays start, prepared for [`Search::any`].
    pub(super) fn viewpoint(&self, origin: Point) -> Option<Viewpoint> {
        self.tree.as_ref().map(|tree| tree.viewpoint(origin))
    }

    /// Whether `occludes` holds for any shape that the ray may hit at t from 0 to 1.
    pub(super) fn any(
        &self,
        viewpoint: &Option<Viewpoint>,
        ray: &Ray,
        stack: &mut Vec<Pending>,
        occludes: impl Fn(&S) -> bool,
    ) -> bool {
        match (&self.tree, viewpoint) {
            (Some(tree), Some(viewpoint)) => tree.any(viewpoint, ray.direction, stack, |leaf| {
                self.shapes[leaf].iter().any(&occludes)
            }),
            (Some(_), None) | (None, _) => self.shapes.iter().any(occludes),
        }
    }

    /// Bytes of the shapes and their tree.
    pub(super) fn memory(&self) -> usize {
        size_of_val(self.shapes.as_slice()) + self.tree.as_ref().map_or(0, Bvh::memory)
    }
}
