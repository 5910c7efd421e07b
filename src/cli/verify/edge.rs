//! Which edge a pixel lies on: there rounding may decide its side, and both sides are right.

use candela::oracle::{Decisions, Explanation, HitId, Oracle, Outcome};
use candela::scene::Scene;
use serde::Serialize;

/// Pixels away at which the oracle is asked again. And so many roundings of the eye's coordinates, where these are
/// far from the origin.
const NEARBY: f64 = 1e-6;
const ROUNDINGS: f64 = 512.0;

/// Relative change of radiance so far away, where there is no edge.
const NEARBY_CHANGE: f64 = 1e-3;

/// The edge that a pixel lies on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub(super) enum Edge {
    /// Where an object ends, before another or before the background.
    Silhouette {
        /// What is seen on both sides; `None` is the background.
        between: [Option<String>; 2],
    },
    /// The edge of a shadow.
    Shadow {
        light: String,
        /// What throws the shadow.
        occluder: Option<String>,
    },
    /// Where a surface turns away from a light.
    Terminator { light: String },
    /// The edge of a spot's cone.
    Cone { light: String },
    /// An edge between triangles of a mesh.
    Triangles { object: String },
}

/// Finds edges.
pub(super) struct Edges<'s> {
    scene: &'s Scene,
    oracle: &'s Oracle,
    nearby: f64,
    floor: f64,
}

impl<'s> Edges<'s> {
    /// Radiance below `floor` counts as that much.
    pub(super) fn new(scene: &'s Scene, oracle: &'s Oracle, floor: f64) -> Self {
        let view = scene.camera.value.view();
        let [eye, look_at] = [view.eye.value, view.look_at.value];
        let furthest = eye.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let distance = (0..3).map(|i| (eye[i] - look_at[i]).powi(2)).sum::<f64>();
        let rows = f64::from(scene.image.resolution.value[1]);
        Self {
            scene,
            oracle,
            nearby: NEARBY + ROUNDINGS * f64::EPSILON * furthest / distance.sqrt() * rows,
            floor,
        }
    }

    /// The edge at the center of a pixel, if the oracle's value jumps there and the rendered one is that of either side.
    pub(super) fn of(&self, [x, y]: [u32; 2], rendered: [f32; 4]) -> Option<Edge> {
        let center = [f64::from(x) + 0.5, f64::from(y) + 0.5];
        let here = self.oracle.decisions(center[0], center[1]);
        let steps = [0.0, -self.nearby, self.nearby];
        let around = steps
            .into_iter()
            .flat_map(|dy| steps.map(|dx| [center[0] + dx, center[1] + dy]));
        let others = around.skip(1).filter_map(|point| {
            let there = self.oracle.decisions(point[0], point[1]);
            let edge = self.between(&here, &there, [center, point])?;
            self.shows(point, rendered).then_some(edge)
        });
        // What hides everything else goes first.
        others.min_by_key(|edge| match edge {
            Edge::Silhouette { .. } => 0,
            Edge::Shadow { .. } => 1,
            Edge::Cone { .. } => 2,
            Edge::Terminator { .. } => 3,
            Edge::Triangles { .. } => 4,
        })
    }

    /// Whether the rendered pixel is what is seen at a point.
    fn shows(&self, [x, y]: [f64; 2], rendered: [f32; 4]) -> bool {
        let there = self.oracle.radiance(x, y);
        let scale = there
            .radiance
            .iter()
            .fold(self.floor, |most: f64, c| most.max(c.abs()));
        let mut channels = rendered.iter().zip(there.radiance);
        f64::from(rendered[3]) == there.coverage
            && channels.all(|(&r, o)| (f64::from(r) - o).abs() <= NEARBY_CHANGE * scale)
    }

    /// What lies between two points that differ in a decision.
    fn between(&self, here: &Decisions, there: &Decisions, points: [[f64; 2]; 2]) -> Option<Edge> {
        let object = |hit: Option<HitId>| hit.map(|hit| hit.object);
        if object(here.hit) != object(there.hit) {
            let name = |hit| object(hit).map(|object| self.scene.objects[object].name.clone());
            return Some(Edge::Silhouette {
                between: [name(here.hit), name(there.hit)],
            });
        }
        let mut lights = here.lights.iter().zip(&there.lights).enumerate();
        if let Some((index, (&a, &b))) = lights.find(|(_, (a, b))| a != b) {
            let light = self.scene.lights[index].name.clone();
            let is_either = |outcome| a == outcome || b == outcome;
            return Some(
                if is_either(Outcome::Below) || is_either(Outcome::AtPoint) {
                    Edge::Terminator { light }
                } else if is_either(Outcome::Outside) {
                    Edge::Cone { light }
                } else {
                    let occluder = |[x, y]: [f64; 2]| -> Option<String> {
                        let Explanation { lights, .. } = self.oracle.explain(x, y);
                        lights.into_iter().nth(index)?.occluder
                    };
                    let occluder = points.into_iter().find_map(occluder);
                    Edge::Shadow { light, occluder }
                },
            );
        }
        let object = here.hit.filter(|_| here.hit != there.hit)?.object;
        Some(Edge::Triangles {
            object: self.scene.objects[object].name.clone(),
        })
    }
}
