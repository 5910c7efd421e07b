//! Bodies of glass: a sphere, or a mesh that is closed.

use std::collections::HashMap;

use super::Builder;
use crate::math::DVec3;
use crate::scene::{Problem, Span};
use crate::world::body::Body;
use crate::world::{Delta, Shape, World};

impl Builder<'_> {
    /// Finds the bodies of glass among the objects of a world.
    pub(super) fn bodies(&mut self, world: &mut World) {
        let mut bodies = Vec::new();
        for (index, object) in world.objects.iter().enumerate() {
            if !matches!(world.deltas[object.material], Some(Delta::Glass(_))) {
                continue;
            }
            let span = self
                .scene
                .objects
                .get(index)
                .map_or(Span::default(), |entry| entry.value.material().span);
            let body = match object.shape {
                Shape::Sphere(sphere) => {
                    let sphere = &world.spheres[sphere];
                    let bounds = [-sphere.radius, sphere.radius];
                    Ok((false, bounds.map(|radius| sphere.center.0 + radius)))
                }
                Shape::Plane(_) | Shape::Disk(_) => Err("a plane has no inside".to_owned()),
                Shape::Mesh(mesh) => closed(world, mesh),
            };
            match body {
                Ok((is_inside_out, bounds)) => bodies.push(Body {
                    object: index as u32,
                    is_inside_out,
                    bounds,
                }),
                Err(why) => {
                    let conflict = format!(
                        "`{}` is of glass, but {why}; expected a sphere or a closed mesh, or a thin sheet, \
                         `[materials.NAME.pane]`",
                        object.name
                    );
                    self.report(span, Problem::Conflict(conflict));
                }
            }
        }
        bodies.sort_by(|a, b| {
            a.volume()
                .total_cmp(&b.volume())
                .then(a.object.cmp(&b.object))
        });
        if !bodies.is_empty() {
            world.body_ranks = vec![u32::MAX; world.objects.len()];
        }
        for (body, rank) in bodies.iter().zip(0..) {
            world.body_ranks[body.object as usize] = rank;
        }
        world.bodies = bodies;
    }
}

/// Whether the triangles of a mesh, which is closed, are turned inwards, and the box around it; else what
/// is wrong with it.
///
/// Corners at one place are one, as files repeat those with several normals.
fn closed(world: &World, mesh: usize) -> Result<(bool, [DVec3; 2]), String> {
    let triangles = &world.triangles;
    let range = triangles.meshes()[mesh].triangles.clone();
    let mut places: HashMap<[u64; 3], u32> = HashMap::new();
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    let count = range.len();
    let room = places.try_reserve(count);
    if room.and_then(|()| edges.try_reserve(2 * count)).is_err() {
        return Err("there is not enough memory to see whether it is closed".to_owned());
    }
    let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut volume = 0.0;
    let first = triangles.vertices(range.start)[0];
    for triangle in range {
        let vertices = triangles.vertices(triangle);
        let mut corners = [0; 3];
        for (corner, vertex) in corners.iter_mut().zip(vertices) {
            least = least.min(vertex);
            most = most.max(vertex);
            // −0 is 0.
            let key = (vertex + DVec3::ZERO).to_array().map(f64::to_bits);
            let next = places.len() as u32;
            *corner = *places.entry(key).or_insert(next);
        }
        let [a, b, c] = vertices.map(|vertex| vertex - first);
        volume += a.dot(b.cross(c));
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let (from, to) = (corners[from], corners[to]);
            let (edge, way) = if from < to {
                ((from, to), 1)
            } else {
                ((to, from), -1)
            };
            *edges.entry(edge).or_default() += way;
        }
    }
    // Each edge is passed as often in one way as in the other.
    let open = edges.values().filter(|&&ways| ways != 0).count();
    if open > 0 {
        let edges = if open == 1 { "edge" } else { "edges" };
        return Err(format!(
            "its mesh is open, or its triangles are not all turned outwards: {open} {edges} without a neighbor"
        ));
    }
    Ok((volume < 0.0, [least, most]))
}
