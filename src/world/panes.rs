//! Thin panes before lights with an area.

use super::geometry::area_vector;
use super::{Delta, Shape, World};
use crate::emitter::{Accuracy, Emitter, Occluder, Panes, Received, Receiver, ShadowSpace, Untold};
use crate::math::{DVec3, Point};
use crate::optics;

/// The panes through which a light with an area is seen from a point.
#[derive(Debug, Default)]
pub(crate) struct PanesBefore {
    flat: Vec<Occluder>,
    /// A vector across each of the flat ones, and its index of refraction.
    across: Vec<(DVec3, f64)>,
    has_round: bool,
}

/// What is received past all that stands before a light.
pub(crate) struct Past {
    /// `None` where it is nothing.
    pub(crate) received: Option<Received>,
    /// Whether there are panes of which nothing has been taken away.
    pub(crate) is_undimmed: bool,
}

impl PanesBefore {
    pub(crate) fn clear(&mut self) {
        self.flat.clear();
        self.across.clear();
        self.has_round = false;
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.flat.is_empty() && !self.has_round
    }

    /// A pane that is this object, or a triangle of it.
    pub(crate) fn add(&mut self, world: &World, [object, triangle]: [u32; 2], occluder: Occluder) {
        let object = &world.objects()[object as usize];
        let across = match object.shape {
            Shape::Sphere(_) => {
                self.has_round = true;
                return;
            }
            Shape::Plane(index) => world.planes()[index].normal.get(),
            Shape::Disk(index) => world.disks()[index].normal.get(),
            Shape::Mesh(_) => area_vector(world.triangles().vertices(triangle)),
        };
        if let Some(Delta::Pane { n }) = world.delta(object.material) {
            self.flat.push(occluder);
            self.across.push((across.normalize_or_zero(), *n));
        }
    }

    /// What is received past opaque shapes and through these. Where not all of them are flat, or there are very many,
    /// they are left to rays.
    pub(crate) fn received(
        &self,
        emitter: &Emitter,
        (point, error): (Point, f64),
        receiver: &Receiver,
        occluders: &[Occluder],
        accuracy: &Accuracy,
        space: &mut ShadowSpace,
    ) -> Past {
        let panes = Panes {
            shapes: &self.flat,
            normal: &|pane| self.across[pane].0,
            transmittance: &|pane, way| self.transmittance(pane, way),
        };
        let through = if self.is_empty() || self.has_round {
            Err(Untold)
        } else {
            emitter.received_through(point, receiver, occluders, &panes, error, accuracy, space)
        };
        let is_undimmed = through.is_err() && !self.is_empty();
        let seen = through.unwrap_or_else(|Untold| {
            emitter.received_past(point, receiver, occluders, error, accuracy, space)
        });
        Past {
            received: seen.map(|seen| seen.value),
            is_undimmed,
        }
    }

    /// T along a direction of any length.
    fn transmittance(&self, pane: usize, way: DVec3) -> f64 {
        let (across, n) = self.across[pane];
        let cosine = (across.dot(way) / way.length()).abs().min(1.0);
        let [_, transmittance] = optics::pane(cosine, n);
        transmittance
    }
}
