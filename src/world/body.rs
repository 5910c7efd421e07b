//! Bodies of glass: which is inside of which, and where light enters them.

use super::containment::winding_number;
use super::{Shape, World};
use crate::math::{DVec3, Point};

/// A body of glass.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// An index into [`World::objects`].
    pub object: u32,
    /// Whether the normals of its triangles, by the order of their corners, point inwards.
    pub is_inside_out: bool,
    /// The box around it. Where bodies overlap, the one with the smallest box fills the place.
    pub bounds: [DVec3; 2],
}

impl Body {
    /// Of the box around it.
    pub fn volume(&self) -> f64 {
        let [least, most] = self.bounds;
        let size = most - least;
        size.x * size.y * size.z
    }
}

/// How many bodies may be around one point.
pub(super) const MOST: usize = 8;

/// No body.
const NONE: u32 = u32::MAX;

/// The bodies of glass that a point is inside of, by their ranks: those of [`World::bodies`], smallest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Media([u32; MOST]);

impl Media {
    /// Air.
    pub(crate) const NONE: Self = Self([NONE; MOST]);

    /// The body that fills the place.
    #[inline]
    pub(crate) fn top(self) -> Option<u32> {
        (self.0[0] != NONE).then_some(self.0[0])
    }

    /// Inside of one more. Of more than there is room for the largest is forgotten.
    pub(crate) fn with(mut self, rank: u32) -> Self {
        let mut next = rank;
        for place in &mut self.0 {
            if *place == next {
                break;
            }
            if *place > next {
                std::mem::swap(place, &mut next);
            }
        }
        self
    }

    /// Outside of one.
    pub(crate) fn without(mut self, rank: u32) -> Self {
        if let Some(place) = self.0.iter().position(|&body| body == rank) {
            self.0[place..].rotate_left(1);
            self.0[MOST - 1] = NONE;
        }
        self
    }
}

impl World {
    /// The bodies of glass that a point is inside of.
    pub(crate) fn media_around(&self, point: Point) -> Media {
        let mut media = Media::NONE;
        for (body, rank) in self.bodies.iter().zip(0..) {
            let is_inside = match self.objects[body.object as usize].shape {
                Shape::Sphere(index) => {
                    let sphere = &self.spheres[index];
                    point.from(sphere.center).length() < sphere.radius
                }
                Shape::Mesh(index) => {
                    let mesh = &self.triangles.meshes()[index];
                    let [least, most] = body.bounds;
                    point.0.cmpgt(least).all()
                        && point.0.cmplt(most).all()
                        && winding_number(self, mesh, point).abs() > 0.5
                }
                Shape::Plane(_) | Shape::Disk(_) => false,
            };
            if is_inside {
                media = media.with(rank);
            }
        }
        media
    }

    /// The bodies of glass, from the smallest to the largest; of one size in the order of the file.
    #[doc(hidden)]
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// The rank of a body of glass in [`World::bodies`].
    pub(crate) fn body_rank(&self, object: u32) -> Option<u32> {
        let rank = self.body_ranks.get(object as usize).copied()?;
        (rank != NONE).then_some(rank)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The smallest of the bodies around a point is what fills the place, in whatever order they were entered.
    #[test]
    fn the_smallest_body_fills_the_place() {
        let media = Media::NONE.with(5).with(2).with(9);
        assert_eq!(media.top(), Some(2));
        assert_eq!(media, Media::NONE.with(9).with(5).with(2));
        assert_eq!(media.with(5), media, "inside of it twice is inside of it");
        assert_eq!(media.without(2).top(), Some(5));
        assert_eq!(media.without(7), media);
        assert_eq!(media.without(2).without(9).without(5), Media::NONE);
        assert_eq!(Media::NONE.top(), None);
        let many = (0..MOST as u32 + 3).fold(Media::NONE, Media::with);
        assert_eq!(many.top(), Some(0));
    }
}
