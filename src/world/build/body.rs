//! Bodies of glass: a sphere, or a mesh that is closed.

use std::collections::HashMap;

use super::{Builder, shells};
use crate::math::DVec3;
use crate::scene::{Problem, Span};
use crate::world::body::{Body, MOST};
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
        if let Some(rank) = crowded(&world.bodies) {
            let object = world.bodies[rank].object as usize;
            let entry = self.scene.objects.get(object);
            let span = entry.map_or(Span::default(), |entry| entry.value.material().span);
            let conflict = format!(
                "`{}` is of glass and overlaps so many others that are as large that more than {MOST} may be around one \
                 place, which is not followed; expected bodies of glass that are apart, or fewer of them in each other",
                world.objects[object].name
            );
            self.report(span, Problem::Conflict(conflict));
        }
    }
}

/// A body around parts of whose box there are the boxes of more than [`MOST`] with it, all as large.
fn crowded(bodies: &[Body]) -> Option<usize> {
    if bodies.len() <= MOST {
        return None;
    }
    // By where they begin along x: what begins beyond the end of another overlaps nothing of it.
    let mut order: Vec<usize> = (0..bodies.len()).collect();
    let least = |rank: usize| bodies[rank].bounds[0].x;
    order.sort_by(|&a, &b| least(a).total_cmp(&least(b)));
    let mut larger: Vec<Vec<usize>> = vec![Vec::new(); bodies.len()];
    let mut open: Vec<usize> = Vec::new();
    for &rank in &order {
        let bounds = &bodies[rank].bounds;
        open.retain(|&other| bodies[other].bounds[1].x > bounds[0].x);
        for &other in &open {
            if overlap(bounds, &bodies[other].bounds) {
                larger[rank.min(other)].push(rank.max(other));
            }
        }
        open.push(rank);
    }
    (0..bodies.len()).find(|&rank| {
        let boxes = larger[rank].iter().map(|&rank| bodies[rank].bounds);
        let boxes: Vec<_> = boxes.collect();
        boxes.len() >= MOST && deepest(&boxes, bodies[rank].bounds, 0) >= MOST
    })
}

fn overlap([a, b]: &[DVec3; 2], [c, d]: &[DVec3; 2]) -> bool {
    a.cmplt(*d).all() && c.cmplt(*b).all()
}

/// The largest number of boxes around one place of a box, from one axis on; counted as far as [`MOST`].
fn deepest(boxes: &[[DVec3; 2]], within: [DVec3; 2], axis: usize) -> usize {
    if axis == 3 || boxes.len() < MOST {
        return boxes.len();
    }
    // As many as anywhere are around a place where one of them begins.
    let mut begins: Vec<f64> = boxes.iter().map(|bounds| bounds[0][axis]).collect();
    begins.push(within[0][axis]);
    let mut most = 0;
    for begin in begins {
        let begin = begin.max(within[0][axis]);
        let is_around = |bounds: &&[DVec3; 2]| {
            let [least, most] = [bounds[0][axis], bounds[1][axis]];
            (least..most).contains(&begin)
        };
        let around: Vec<_> = boxes.iter().filter(is_around).copied().collect();
        most = most.max(deepest(&around, within, axis + 1));
        if most >= MOST {
            break;
        }
    }
    most
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
    let mut numbers = Vec::new();
    if numbers.try_reserve_exact(count).is_err() {
        return Err("there is not enough memory to see whether it is closed".to_owned());
    }
    let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut volume = 0.0;
    let first = triangles.vertices(range.start)[0];
    for triangle in range.clone() {
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
        numbers.push(corners);
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
    let is_inside_out = volume < 0.0;
    if let Some(place) = shells::fault(world, range, &numbers, is_inside_out) {
        let [x, y, z] = (place + world.anchor()).to_array();
        return Err(format!(
            "parts of its mesh overlap, or one is within another and turned the same way, near ({x:.4}, {y:.4}, \
             {z:.4}): they have to be apart, or objects of their own, and hollows turned inwards"
        ));
    }
    Ok((is_inside_out, [least, most]))
}
