//! The shells of a closed mesh: parts that no edge connects. Glass is where the mesh surrounds a point once; so shells
//! are apart from each other, or one is a hollow in another and turned inwards.

use crate::math::{DVec3, Point};
use crate::world::World;
use crate::world::containment::winding_number_of;

/// So many solid angles of triangles are asked at most. About a second.
const MOST_STEPS: usize = 20_000_000;

/// A point on a surface is surrounded by a part of it; so much of one is more than rounding.
const ON_IT: f64 = 0.1;

/// Triangles that are connected.
struct Shell {
    triangles: Vec<u32>,
    bounds: [DVec3; 2],
    /// Whether its normals, by the order of the corners, point outwards.
    is_outwards: bool,
}

impl Shell {
    fn new(world: &World, triangles: Vec<u32>) -> Self {
        let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut volume = 0.0;
        let vertices = |triangle: u32| world.triangles().vertices(triangle);
        let first = triangles
            .first()
            .map_or(DVec3::ZERO, |&first| vertices(first)[0]);
        for &triangle in &triangles {
            let corners = vertices(triangle);
            for corner in corners {
                least = least.min(corner);
                most = most.max(corner);
            }
            let [a, b, c] = corners.map(|corner| corner - first);
            volume += a.dot(b.cross(c));
        }
        Self {
            triangles,
            bounds: [least, most],
            is_outwards: volume > 0.0,
        }
    }

    fn may_surround(&self, point: DVec3) -> bool {
        let [least, most] = self.bounds;
        point.cmpgt(least).all() && point.cmplt(most).all()
    }

    /// How often it surrounds a point, with the sign of its orientation.
    fn winding_number(&self, world: &World, point: DVec3) -> f64 {
        winding_number_of(world, self.triangles.iter().copied(), Point(point))
    }
}

/// A place where the shells of a closed mesh overlap, or are in each other and turned alike. The corners of triangles
/// have numbers, one for each place. Very large meshes are not looked at everywhere.
pub(super) fn fault(
    world: &World,
    triangles: std::ops::Range<u32>,
    corners: &[[u32; 3]],
    is_inside_out: bool,
) -> Option<DVec3> {
    let shells = shells(world, triangles, corners);
    if shells.len() < 2 {
        return None;
    }
    let mut steps = 0;
    // Of each shell one triangle is asked, then one more, as long as there is time.
    let longest = shells.iter().map(|shell| shell.triangles.len()).max()?;
    for place in 0..longest {
        for (index, shell) in shells.iter().enumerate() {
            let Some(&triangle) = shell.triangles.get(place) else {
                continue;
            };
            let [a, b, c] = world.triangles().vertices(triangle);
            let middle = (a + b + c) / 3.0;
            let others = shells.iter().enumerate();
            let others =
                others.filter(|&(other, shell)| other != index && shell.may_surround(middle));
            let mut around = 0.0;
            for (_, other) in others {
                steps += other.triangles.len();
                around += other.winding_number(world, middle);
            }
            steps += shells.len();
            if steps > MOST_STEPS {
                return None;
            }
            if (around - around.round()).abs() > ON_IT {
                continue;
            }
            let around = around.round() as i64 * if is_inside_out { -1 } else { 1 };
            let expected = i64::from(shell.is_outwards == is_inside_out);
            if around != expected {
                return Some(middle);
            }
        }
    }
    None
}

/// Triangles that have corners in common are of one shell.
fn shells(world: &World, triangles: std::ops::Range<u32>, corners: &[[u32; 3]]) -> Vec<Shell> {
    let count = corners.iter().flatten().max().map_or(0, |&most| most + 1);
    let mut parents: Vec<u32> = (0..count).collect();
    for &[a, b, c] in corners {
        for other in [b, c] {
            let (a, b) = (root(&mut parents, a), root(&mut parents, other));
            let (low, high) = (a.min(b), a.max(b));
            parents[high as usize] = low;
        }
    }
    let mut numbers = vec![u32::MAX; count as usize];
    let mut lists: Vec<Vec<u32>> = Vec::new();
    for (triangle, corners) in triangles.zip(corners) {
        let root = root(&mut parents, corners[0]) as usize;
        if numbers[root] == u32::MAX {
            numbers[root] = lists.len() as u32;
            lists.push(Vec::new());
        }
        lists[numbers[root] as usize].push(triangle);
    }
    let shell = |triangles| Shell::new(world, triangles);
    lists.into_iter().map(shell).collect()
}

/// The smallest number of a set, so far as it is known.
fn root(parents: &mut [u32], mut number: u32) -> u32 {
    while parents[number as usize] != number {
        let parent = parents[number as usize];
        parents[number as usize] = parents[parent as usize];
        number = parent;
    }
    number
}
