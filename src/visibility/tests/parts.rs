//! Triangles in many trees under one.

use super::incoherent::{agree_with_brute_force, world_of};
use super::*;
use crate::visibility::primitive::Primitive;
use crate::visibility::shapes::Parts;
use crate::world::geometry::from_shorter_edges;

/// However many trees the triangles are parted among, rays meet what they meet: each triangle in a tree of its own.
#[test]
fn rays_meet_the_same_in_many_trees() {
    for (size, place) in [(1.0, [0.0; 3]), (1e-9, [0.0; 3]), (1.0, [1e6, -1e6, 0.0])] {
        let mut scene = Writer::new(size, place, 40.0, EYE);
        scene.clutter(300, 80, 0.3);
        let world = world_of(&scene);
        let plan = Plan::new(&world);
        let parts = Parts::with_parts_of(1, &world, &plan, None);
        // Each triangle that is not outsized, and the spheres.
        assert!(parts.built() > 250, "{}", parts.built());
        let hit = agree_with_brute_force(&Visibility::of(&world, parts), size, 5_000);
        assert!(hit > 0.3, "{hit}");
    }
}

/// Blocks have triangles in f32; in f64 each is the world's, from the corner between its shorter edges on.
#[test]
fn triangles_are_those_of_the_world() {
    let mut scene = Writer::new(1.0, [3.0, -2.0, 1.0], 40.0, EYE);
    scene.clutter(300, 0, 0.3);
    let world = world_of(&scene);
    let plan = Plan::new(&world);
    for least in [1, usize::MAX] {
        let visibility = Visibility::of(&world, Parts::with_parts_of(least, &world, &plan, None));
        let search = &visibility.shapes.triangles;
        let mut known = vec![0; world.triangles().len()];
        for number in search.numbers() {
            let triangle = search.get(number);
            assert_eq!(triangle.primitive(), search.primitive(number));
            let (object, of_world) = triangle.primitive().parts();
            assert_eq!(object, world.triangles().mesh(of_world).object);
            assert_eq!(triangle.primitive(), Primitive::triangle(object, of_world));
            let corners = from_shorter_edges(world.triangles().vertices(of_world));
            assert_eq!(triangle.vertices(), corners);
            known[of_world as usize] += 1;
        }
        assert!(known.iter().all(|&times| times == 1));
    }
}
