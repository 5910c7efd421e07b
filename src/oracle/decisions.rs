//! What decides a radiance at a point of the image, and so where it jumps.

use super::hit::Hit;
use super::lamp::Lamp;
use super::outcome::{Event, Outcome};
use super::{HitId, Oracle};

/// The decisions behind a radiance. Between two points of the image that agree in them, radiance
/// changes smoothly; where two computations differ in them, rounding decided at an edge.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[doc(hidden)]
pub struct Decisions {
    /// What the primary ray hits.
    pub hit: Option<HitId>,
    /// What becomes of each light, in the order of the file; empty where nothing is hit, or a light. What is seen of a
    /// light with an area changes without a jump: it is [`Outcome::Partial`] wherever it shines to.
    pub lights: Vec<Outcome>,
    /// Through how many panes each light is seen.
    pub panes: Vec<usize>,
    /// The same of what is seen over smooth surfaces, way by way.
    pub beyond: Vec<Beyond>,
}

/// The decisions about a ray that a smooth surface sends on.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[doc(hidden)]
pub struct Beyond {
    /// What sends it on.
    pub event: Event,
    /// What it hits.
    pub hit: Option<HitId>,
    /// As in [`Decisions`].
    pub lights: Vec<Outcome>,
    /// As in [`Decisions`].
    pub panes: Vec<usize>,
}

/// What becomes of each light where a ray has hit, and through how many panes it is seen.
type OfLights = (Vec<Outcome>, Vec<usize>);

impl Oracle {
    /// What is decided on the way to the radiance; coordinates as in [`Oracle::radiance`].
    pub fn decisions(&self, px: f64, py: f64) -> Decisions {
        let mut decisions = Decisions {
            hit: None,
            lights: Vec::new(),
            panes: Vec::new(),
            beyond: Vec::new(),
        };
        self.walk(&self.camera.primary_ray(px, py), |vertex| {
            let hit = vertex.hit.map(|hit| self.id(hit));
            let of_lights = |hit| self.decided_about_lights(hit);
            let (lights, panes) = vertex.hit.map_or_else(Default::default, of_lights);
            match vertex.came {
                None => (decisions.hit, decisions.lights, decisions.panes) = (hit, lights, panes),
                Some(came) => decisions.beyond.push(Beyond {
                    event: came.event,
                    hit,
                    lights,
                    panes,
                }),
            }
        });
        decisions
    }

    fn decided_about_lights(&self, hit: &Hit) -> OfLights {
        let of_light = |light: &Lamp| {
            let term = self.term(hit, light);
            // What is before an area changes without a jump.
            let panes = if light.area.is_some() {
                0
            } else {
                term.panes.len()
            };
            (term.decided(light), panes)
        };
        self.lights_of(hit).map(of_light).unzip()
    }
}
