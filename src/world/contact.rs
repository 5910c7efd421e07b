//! Faces of glass that lie on faces of other objects: a ray that leaves one of two surfaces in the same place meets
//! neither, so that what is behind both is seen.

use super::geometry::area_vector;
use super::{Shape, World};
use crate::math::DVec3;

/// How far corners may be off a plane to be on it, over the largest coordinates: a few roundings of f64.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// More triangles, and pairs of them, are not looked at.
const MOST_LOOKED_AT: usize = 10_000_000;

/// Pairs of objects of which the first is of glass and has a face that lies on one of the second, each once; what
/// would take too long is left out.
pub(super) fn touching_glass(world: &World) -> Vec<[usize; 2]> {
    let mut pairs = Vec::new();
    let mut looked_at = 0;
    for body in world.bodies() {
        let glass = body.object as usize;
        let faces = faces(world, glass, body.bounds);
        for other in (0..world.objects().len()).filter(|&other| other != glass) {
            let touches = match world.objects()[other].shape {
                Shape::Plane(index) => {
                    let plane = &world.planes()[index];
                    let (point, normal) = (plane.point.0, plane.normal.get());
                    faces.iter().any(|face| is_on(face, point, normal))
                }
                Shape::Mesh(index) => {
                    looked_at += world.triangles().meshes()[index].triangles.len();
                    if looked_at > MOST_LOOKED_AT {
                        return pairs;
                    }
                    let others = self::faces(world, other, body.bounds);
                    looked_at += faces.len() * others.len();
                    looked_at <= MOST_LOOKED_AT
                        && faces
                            .iter()
                            .any(|face| others.iter().any(|other| lie_on_each_other(face, other)))
                }
                Shape::Sphere(_) | Shape::Disk(_) => false,
            };
            // Two bodies of glass are told once.
            if touches && !pairs.contains(&[other, glass]) {
                pairs.push([glass, other]);
            }
        }
    }
    pairs
}

/// The triangles of a mesh that reach into a box, its border included.
fn faces(world: &World, object: usize, [least, most]: [DVec3; 2]) -> Vec<[DVec3; 3]> {
    let Shape::Mesh(index) = world.objects()[object].shape else {
        return Vec::new();
    };
    let triangles = world.triangles();
    let own = triangles.meshes()[index].triangles.clone();
    own.map(|triangle| triangles.vertices(triangle))
        .filter(|face| {
            let [lower, upper] = bounds(face);
            lower.cmple(most).all() && upper.cmpge(least).all()
        })
        .collect()
}

fn bounds([a, b, c]: &[DVec3; 3]) -> [DVec3; 2] {
    [a.min(*b).min(*c), a.max(*b).max(*c)]
}

/// Whether all corners are in a plane.
fn is_on(face: &[DVec3; 3], point: DVec3, normal: DVec3) -> bool {
    face.iter().all(|corner| {
        let size = corner.abs().max_element() + point.abs().max_element();
        normal.dot(*corner - point).abs() <= ROUNDING * size * normal.length()
    })
}

/// Whether two triangles are in one plane, and so are parts of both as far as boxes tell.
fn lie_on_each_other(one: &[DVec3; 3], other: &[DVec3; 3]) -> bool {
    let ([a, b], [c, d]) = (bounds(one), bounds(other));
    let overlap = b.min(d) - a.max(c);
    let wide = [overlap.x, overlap.y, overlap.z];
    let wide = wide.iter().filter(|&&width| width > 0.0).count();
    wide >= 2 && is_on(one, other[0], area_vector(*other))
}

#[cfg(test)]
mod tests {
    use crate::scene::Scene;
    use crate::world::World;
    use crate::world::physics::{Warning, warnings};

    /// A box as triangles in an OBJ file.
    fn cube([x, y, z]: [f64; 3]) -> String {
        let mut text = String::new();
        for corner in 0..8_u8 {
            let at = |bit: u8, from: f64| from + f64::from(corner >> bit & 1);
            text += &format!("v {} {} {}\n", at(0, x), at(1, y), at(2, z));
        }
        for [a, b, c, d] in [
            [1, 3, 4, 2],
            [5, 6, 8, 7],
            [1, 2, 6, 5],
            [3, 7, 8, 4],
            [1, 5, 7, 3],
            [2, 4, 8, 6],
        ] {
            text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
        }
        text
    }

    #[test]
    fn glass_that_stands_exactly_on_something_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let floor =
            "[objects.floor.plane]\nmaterial = 'm'\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n";
        let mesh = |name: &str, material: &str| {
            format!("[objects.{name}.mesh]\nmaterial = '{material}'\nfile = '{name}.obj'\n")
        };
        let table = mesh("table", "m");
        let second = mesh("table", "g");
        for (at, others, expected) in [
            ([0.0, 0.0, 0.0], floor, Some("floor")),
            ([0.0, -1.0, 0.0], floor, Some("floor")),
            ([0.0, -0.001, 0.0], floor, None),
            ([0.0, 1e-6, 0.0], floor, None),
            // The table is from 0 to 1 along each axis, too.
            ([0.5, 1.0, 0.5], &table, Some("table")),
            ([0.5, 1.0, 0.5], &second, Some("table")),
            ([1.0, 0.2, 0.1], &table, Some("table")),
            // Beside it, or sunk into it.
            ([1.0, 1.0, 0.0], &table, None),
            ([0.5, 0.9, 0.5], &table, None),
            ([3.0, 1.0, 0.0], &table, None),
        ] {
            std::fs::write(folder.path().join("glass.obj"), cube(at)).unwrap();
            std::fs::write(folder.path().join("table.obj"), cube([0.0; 3])).unwrap();
            let glass = mesh("glass", "g");
            let text = format!(
                "[image]\nresolution = [1, 1]\n[camera.orthographic]\neye = [0, 9, 9]\nlook_at = [0, 0, 0]\nheight = 1\n\
                 [materials.m.phong]\n[materials.g.glass]\nn = 1.5\n\
                 [lights.l.point]\nposition = [9, 9, 9]\nintensity = 1\n{glass}{others}"
            );
            let scene = Scene::parse(&text, folder.path().join("scene.toml")).unwrap();
            let world = World::new(&scene).unwrap().0;
            let expected = expected.map(|object| Warning::GlassTouches {
                glass: "glass".to_owned(),
                object: object.to_owned(),
            });
            assert_eq!(
                warnings(&world),
                Vec::from_iter(expected),
                "{at:?} {others}"
            );
        }
    }
}
