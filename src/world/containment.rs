//! Which lights are inside of closed objects, without asking every object about every light.

use std::f64::consts::TAU;
use std::ops::Range;

use super::{Light, Mesh, Shape, Sphere, World};
use crate::math::{DVec3, Point};

/// Lights in a leaf of the tree.
const LEAF: usize = 8;

/// How many steps are taken at most: a node looked at, or a light's view of a triangle. About a
/// second.
const MOST_STEPS: u64 = 30_000_000;

/// What was found out about lights in objects.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Contained {
    /// Objects with lights inside of them, in the order of the objects.
    pub(super) objects: Vec<Holder>,
    /// Of how many objects it was not looked at, because there are too many of both.
    pub(super) unknown: usize,
}

/// An object with lights inside of it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Holder {
    /// An index into [`World::objects`].
    pub(super) object: usize,
    /// The first of the lights, an index into [`World::lights`].
    pub(super) light: usize,
    /// How many there are.
    pub(super) count: usize,
}

/// Looks at all objects of a world.
pub(super) fn contained(world: &World) -> Contained {
    let mut contained = Contained::default();
    if world.lights().is_empty() {
        return contained;
    }
    let lights = Lights::new(world);
    let mut steps = 0;
    // A light that is seen is an object around itself.
    let objects = world.objects().iter().enumerate();
    for (object, entry) in objects.filter(|(_, entry)| entry.emits.is_none()) {
        let mut within = Within {
            light: usize::MAX,
            count: 0,
        };
        let looked_at = match entry.shape {
            Shape::Sphere(index) => {
                let sphere = world.spheres()[index];
                lights.in_sphere(&sphere, &mut steps, &mut within)
            }
            Shape::Plane(_) | Shape::Disk(_) => Some(()),
            Shape::Mesh(index) => {
                let mesh = &world.triangles().meshes()[index];
                lights.in_mesh(world, mesh, &mut steps, &mut within)
            }
        };
        match looked_at {
            Some(()) if within.count > 0 => contained.objects.push(Holder {
                object,
                light: within.light,
                count: within.count,
            }),
            Some(()) => {}
            None => contained.unknown += 1,
        }
    }
    contained
}

/// The lights that were found in an object.
struct Within {
    light: usize,
    count: usize,
}

impl Within {
    fn add(&mut self, light: usize, count: usize) {
        self.light = self.light.min(light);
        self.count += count;
    }
}

/// Lights in a tree over their positions: each node parts its lights in two halves.
struct Lights {
    /// Position and index of each.
    places: Vec<(DVec3, usize)>,
    root: Node,
}

struct Node {
    lights: Range<usize>,
    /// The least index of its lights.
    first: usize,
    min: DVec3,
    max: DVec3,
    halves: Option<Box<[Self; 2]>>,
}

impl Lights {
    fn new(world: &World) -> Self {
        let lights = world.lights().iter().enumerate();
        let lights = lights.filter(|(_, light)| !matches!(light.value, Light::Sun(_)));
        let mut places: Vec<(DVec3, usize)> = lights
            .map(|(index, light)| (light.value.position().0, index))
            .collect();
        let root = Node::new(&mut places, 0);
        Self { places, root }
    }

    /// `None` where it would take too long.
    fn in_sphere(&self, sphere: &Sphere, steps: &mut u64, within: &mut Within) -> Option<()> {
        let mut open = vec![&self.root];
        while let Some(node) = open.pop() {
            take(steps, 1)?;
            let center = sphere.center.0;
            let nearest = (center.clamp(node.min, node.max) - center).length();
            let farthest = (node.max - center)
                .abs()
                .max((node.min - center).abs())
                .length();
            // Where rounding decides, the lights are looked at one by one.
            if nearest > sphere.radius * (1.0 + ROUNDING) {
                continue;
            }
            if farthest < sphere.radius * (1.0 - ROUNDING) {
                within.add(node.first, node.lights.len());
                continue;
            }
            if let Some(halves) = &node.halves {
                open.extend(halves.iter());
                continue;
            }
            for &(position, light) in &self.places[node.lights.clone()] {
                if Point(position).from(sphere.center).length() < sphere.radius {
                    within.add(light, 1);
                }
            }
        }
        Some(())
    }

    /// `None` where it would take too long.
    fn in_mesh(
        &self,
        world: &World,
        mesh: &Mesh,
        steps: &mut u64,
        within: &mut Within,
    ) -> Option<()> {
        let triangles = mesh.triangles.len() as u64;
        take(steps, triangles.div_ceil(8))?;
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for index in mesh.triangles.clone() {
            for vertex in world.triangles().vertices(index) {
                (min, max) = (min.min(vertex), max.max(vertex));
            }
        }
        let mut open = vec![&self.root];
        while let Some(node) = open.pop() {
            take(steps, 1)?;
            if node.max.cmple(min).any() || node.min.cmpge(max).any() {
                continue;
            }
            if let Some(halves) = &node.halves {
                open.extend(halves.iter());
                continue;
            }
            for &(position, light) in &self.places[node.lights.clone()] {
                if !(position.cmpgt(min).all() && position.cmplt(max).all()) {
                    continue;
                }
                take(steps, triangles)?;
                if winding_number(world, mesh, Point(position)).abs() > 0.5 {
                    within.add(light, 1);
                }
            }
        }
        Some(())
    }
}

/// Relative to a distance, more than its rounding.
const ROUNDING: f64 = 1e-12;

/// Counts steps; `None` where these are too many.
fn take(steps: &mut u64, count: u64) -> Option<()> {
    let sum = steps.saturating_add(count);
    if sum > MOST_STEPS {
        return None;
    }
    *steps = sum;
    Some(())
}

impl Node {
    fn new(places: &mut [(DVec3, usize)], start: usize) -> Self {
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &(position, _) in &*places {
            (min, max) = (min.min(position), max.max(position));
        }
        let size = max - min;
        let halves = (places.len() > LEAF && size.max_element() > 0.0).then(|| {
            let axis = size.max_position();
            let middle = places.len() / 2;
            places.select_nth_unstable_by(middle, |(a, _), (b, _)| a[axis].total_cmp(&b[axis]));
            let (below, above) = places.split_at_mut(middle);
            Box::new([Self::new(below, start), Self::new(above, start + middle)])
        });
        let indices = places.iter().map(|&(_, index)| index);
        Self {
            lights: start..start + places.len(),
            first: indices.min().unwrap_or(usize::MAX),
            min,
            max,
            halves,
        }
    }
}

/// How often a mesh surrounds a point: its solid angle as seen from there over 4π. 0 outside of a
/// closed mesh and ±1 inside; in between for a mesh with holes.
///
/// The solid angle of a triangle with corners a, b, c around the point is
/// 2 atan2(a · (b × c), |a||b||c| + (a·b)|c| + (a·c)|b| + (b·c)|a|)
/// (Van Oosterom & Strackee 1983).
pub(super) fn winding_number(world: &World, mesh: &Mesh, point: Point) -> f64 {
    winding_number_of(world, mesh.triangles.clone(), point)
}

/// The same of some triangles.
pub(super) fn winding_number_of(
    world: &World,
    triangles: impl Iterator<Item = u32>,
    point: Point,
) -> f64 {
    let solid_angle = |index: u32| {
        let [a, b, c] = world
            .triangles()
            .vertices(index)
            .map(|vertex| vertex - point.0);
        let [la, lb, lc] = [a, b, c].map(DVec3::length);
        let volume = a.dot(b.cross(c));
        let around = la * lb * lc + a.dot(b) * lc + a.dot(c) * lb + b.dot(c) * la;
        2.0 * libm::atan2(volume, around)
    };
    triangles.map(solid_angle).sum::<f64>() / (2.0 * TAU)
}
