//! Triangles in many trees under one.

use super::incoherent::{agree_with_brute_force, world_of};
use super::*;
use crate::visibility::shapes::Parts;

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
