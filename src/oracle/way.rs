//! L4 from a point that is seen to a light: where the way starts, and what stands in it.

use super::Oracle;
use super::camera::Ray;
use super::hit::{Hit, starts_inwards};
use super::lamp::{BEYOND_ALL, Lamp, Place};
use super::occlusion::{
    OwnSphere, Segment, Side, disk_between, plane_between, rectangle_between, sphere_between,
    triangle_between,
};
use super::panes::Crossing;
use super::smooth::Smooth;
use super::surface::Shape;
use super::vector::{WideVector, add, dot, length, scale, widened};
use super::wide::{Real, Wide};

/// What stands between a point and a light.
pub(super) enum Between {
    /// A surface through which nothing comes, the nearest to the point.
    Surface(usize),
    /// Panes alone, or nothing.
    Panes(Vec<Crossing>),
}

impl Oracle {
    /// Whether n·ω_i > 0 for the geometric normal; for the interpolated one, where shadow rays are lifted. For
    /// what is flat, the light itself tells, without the rounding of p: one in the plane of a floor is not
    /// above it.
    pub(super) fn light_is_above(
        &self,
        hit: &Hit,
        segment: &Segment,
        to_light: WideVector,
    ) -> bool {
        if hit.lift.is_some() {
            let (_, light) = segment.sides_of_plane(hit.position, hit.normal, 0.0);
            return light == Side::Above;
        }
        match &self.surfaces[hit.surface].shape {
            Shape::Sphere { .. } => dot(hit.geometric_normal, to_light) > Wide::from(0.0),
            Shape::Plane { point, .. }
            | Shape::Rectangle { center: point, .. }
            | Shape::Disk { center: point, .. }
            | Shape::Triangle {
                vertices: [point, ..],
                ..
            } => {
                let (_, light) = segment.sides_of_plane(*point, hit.geometric_normal, 0.0);
                light == Side::Above
            }
        }
    }

    /// L4: V = 0 where there is one; the surface that stands strictly between p, or p′ where shadow rays are
    /// lifted, and p_L, of several the nearest to p.
    pub(super) fn occluder(&self, hit: &Hit, light: &Lamp) -> Option<usize> {
        match self.between(hit, light, 0..self.surfaces.len()) {
            Between::Surface(surface) => Some(surface),
            Between::Panes(_) => None,
        }
    }

    /// L4 among some surfaces.
    pub(super) fn between(
        &self,
        hit: &Hit,
        light: &Lamp,
        among: impl Iterator<Item = usize>,
    ) -> Between {
        let segment = &self.shadow_segment(hit, light);
        let line = segment.line();
        let mut nearest: Option<(usize, f64)> = None;
        let mut panes = Vec::new();
        for index in among {
            let is_beside = |line: &Ray| !self.surfaces[index].may_meet(line);
            if line.as_ref().is_some_and(is_beside) {
                continue;
            }
            let Some(part) = self.part_between(hit, segment, index) else {
                continue;
            };
            if let Some(Smooth::Pane { n }) = self.object(index).smooth.as_deref() {
                panes.push(Crossing::of(
                    index,
                    &self.surfaces[index],
                    segment,
                    part,
                    *n,
                ));
            } else if nearest.is_none_or(|(_, smallest)| part < smallest) {
                nearest = Some((index, part));
            }
        }
        match nearest {
            Some((index, _)) => Between::Surface(index),
            None => Between::Panes(Crossing::once_each(panes)),
        }
    }

    /// At which part of the way from p to p_L a surface stands between, if it does.
    fn part_between(&self, hit: &Hit, segment: &Segment, index: usize) -> Option<f64> {
        let surface = &self.surfaces[index];
        let own = index == hit.surface;
        let magnitude = surface.shape.magnitude();
        match &surface.shape {
            // A flat surface never stands before its own points.
            Shape::Plane { .. }
            | Shape::Triangle { .. }
            | Shape::Rectangle { .. }
            | Shape::Disk { .. }
                if own =>
            {
                None
            }
            Shape::Rectangle {
                center,
                normal,
                halves,
            } => rectangle_between(segment, *center, *normal, halves, magnitude),
            Shape::Disk {
                center,
                normal,
                radius,
            } => disk_between(segment, *center, *normal, *radius, magnitude),
            Shape::Plane { point, normal } => plane_between(segment, *point, *normal, magnitude),
            Shape::Triangle {
                vertices, normal, ..
            } => triangle_between(segment, vertices, *normal, magnitude),
            Shape::Sphere { center, radius } => {
                let own = own.then(|| OwnSphere {
                    starts_inwards: starts_inwards(hit, *center, segment.vector()),
                });
                sphere_between(segment, *center, *radius, magnitude, own)
            }
        }
    }

    pub(super) fn segment(&self, hit: &Hit, light: &Lamp) -> Segment {
        Segment {
            from: hit.position,
            to: match light.place {
                Place::At(position) => position,
                Place::Toward(way) => add(hit.position, scale(way, Wide::from(BEYOND_ALL))),
            },
            magnitude: length(hit.position).narrow() + self.surfaces[hit.surface].shape.magnitude(),
            reference: widened(self.reference),
        }
    }

    /// The segment on which something may stand: from p, or from p′.
    pub(super) fn shadow_segment(&self, hit: &Hit, light: &Lamp) -> Segment {
        let segment = self.segment(hit, light);
        match hit.lift {
            None => segment,
            Some(lift) => Segment {
                from: add(hit.position, lift.way),
                magnitude: segment.magnitude + lift.magnitude,
                ..segment
            },
        }
    }
}
