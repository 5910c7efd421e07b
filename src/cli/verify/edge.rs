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
    /// Any of these as seen in a mirror, or through glass; or where glass begins to reflect all.
    BeyondSmooth {
        /// The smooth object.
        object: String,
    },
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
            Edge::BeyondSmooth { .. } => 5,
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
            let name = |hit: Option<HitId>| hit.map(|hit| self.oracle.name_of(hit).to_owned());
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
        let object = self.oracle.name_of(here.hit?).to_owned();
        if let Some(index) = first_difference(&here.panes, &there.panes) {
            let light = self.scene.lights[index].name.clone();
            let pane = |[x, y]: [f64; 2]| -> Option<String> {
                let Explanation { lights, .. } = self.oracle.explain(x, y);
                lights.into_iter().nth(index)?.panes?.names.pop()
            };
            let occluder = points.into_iter().find_map(pane);
            return Some(Edge::Shadow { light, occluder });
        }
        if here.hit != there.hit {
            return Some(Edge::Triangles { object });
        }
        (here.beyond != there.beyond).then_some(Edge::BeyondSmooth { object })
    }
}

/// Where two lists of as many numbers first differ.
fn first_difference(a: &[usize], b: &[usize]) -> Option<usize> {
    a.iter().zip(b).position(|(a, b)| a != b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pixels of 1 m. A screen ends at x = −0.5, the middle of column 1. `key` throws its edge onto the wall at
    /// x = 0.5, the middle of column 2. `side` grazes the ball in the middle of pixel 3, 1. The cone of `spot` ends
    /// on the wall in the middle of pixel 3, 3.
    const SCENE: &str = r#"
        [image]
        resolution = [4, 4]

        [camera.orthographic]
        eye = [0, 0, 5]
        look_at = [0, 0, 0]
        height = 4

        [materials.chalk.phong]
        diffuse = 0.3

        [lights.key.point]
        position = [-1.5, 0, 2]
        intensity = 10

        [lights.side.point]
        position = [5, 0.5, 1]
        intensity = 10

        [lights.spot.spot]
        position = [1.5, -2.5, -1]
        direction = [0, 0, -1]
        intensity = 10
        inner = 45
        outer = 45

        [objects.screen.triangle]
        material = "chalk"
        vertices = [[-0.5, -10, 0], [-0.5, 10, 0], [-10, 0, 0]]

        [objects.ball.sphere]
        material = "chalk"
        center = [1.5, 0.5, 0]
        radius = 1

        [objects.wall.plane]
        material = "chalk"
        point = [0, 0, -2]
        normal = [0, 0, 1]
    "#;

    #[test]
    fn edges_have_names() {
        let scene = Scene::parse(SCENE, "edges.toml").unwrap_or_else(|error| panic!("{error}"));
        let oracle = Oracle::new(&scene);
        let edges = Edges::new(&scene, &oracle, 1e-9);
        let text = |name: &str| name.to_owned();
        let of = |pixel: [u32; 2], [dx, dy]: [f64; 2]| {
            let [x, y] = pixel.map(|coordinate| f64::from(coordinate) + 0.5);
            let sides = [-1e-6, 1e-6].map(|side| [x + side * dx, y + side * dy]);
            let is_other = |[a, b]: &[f64; 2]| oracle.decisions(*a, *b) != oracle.decisions(x, y);
            let [x, y] = sides.into_iter().find(is_other)?;
            // As if the renderer had that side.
            let there = oracle.radiance(x, y);
            let [r, g, b] = there.radiance.map(|channel| channel as f32);
            edges.of(pixel, [r, g, b, there.coverage as f32])
        };
        let silhouette = of([1, 3], [1.0, 0.0]);
        let Some(Edge::Silhouette { between }) = silhouette else {
            panic!("{silhouette:?}");
        };
        let mut between = between.map(Option::unwrap_or_default);
        between.sort();
        assert_eq!(between, ["screen", "wall"]);
        let light = text("key");
        let occluder = Some(text("screen"));
        let shadow = Edge::Shadow { light, occluder };
        assert_eq!(of([2, 3], [1.0, 0.0]), Some(shadow));
        let light = text("side");
        assert_eq!(of([3, 1], [1.0, 0.0]), Some(Edge::Terminator { light }));
        let light = text("spot");
        assert_eq!(of([3, 3], [0.0, 1.0]), Some(Edge::Cone { light }));
        // Neither side shows that, and elsewhere there is no edge.
        assert_eq!(edges.of([2, 3], [7.0, 7.0, 7.0, 1.0]), None);
        assert_eq!(of([0, 0], [1.0, 1.0]), None);
    }
}
