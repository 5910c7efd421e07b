//! L4: what stands strictly between, and what only touches.

use super::*;
use crate::oracle::Outcome;
use crate::oracle::vector::{add, cross, dot, scale, subtract, unit};

const FLOOR: ([f64; 3], [f64; 3]) = ([0.0; 3], [0.0, 1.0, 0.0]);

/// The point (0, 0, 0) of a floor, seen from the side.
fn floor() -> Builder {
    Builder::looking([3.0, 2.0, 1.0], [0.0; 3]).plane(FLOOR.0, FLOOR.1)
}

fn outcome(scene: &Builder) -> Outcome {
    scene.first_light().outcome
}

/// The outcome of the first light in every pixel that shows the object `shown`.
fn outcomes(scene: &Builder, shown: usize) -> Vec<Outcome> {
    let oracle = scene.oracle();
    let [width, height] = oracle.resolution();
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    pixels
        .map(|(x, y)| oracle.decisions(f64::from(x) + 0.5, f64::from(y) + 0.5))
        .filter(|decisions| decisions.hit.is_some_and(|hit| hit.object == shown))
        .map(|decisions| decisions.lights[0])
        .collect()
}

fn count(outcomes: &[Outcome], outcome: Outcome) -> usize {
    outcomes.iter().filter(|&&other| other == outcome).count()
}

#[test]
fn only_what_stands_between_occludes() {
    let wall = |height: f64| {
        [
            [-1.0, height, -1.0],
            [1.0, height, -1.0],
            [0.0, height, 2.0],
        ]
    };
    let light = [0.0, 2.0, 0.0];
    let lit = [
        floor(),
        floor().triangle(wall(-1.0)),
        floor().triangle(wall(3.0)),
        floor().sphere([0.0, -2.0, 0.0], 1.0),
        floor().sphere([0.0, 4.0, 0.0], 1.0),
        floor().sphere([-1.5, 1.0, 0.0], 1.0),
        floor().sphere([0.0, 0.0, 0.0], 100.0),
    ];
    for scene in lit {
        assert_eq!(outcome(&scene.light(light, 1.0)), Outcome::Lit);
    }
    let occluded = [
        floor().triangle(wall(1.0)),
        floor().sphere([0.0, 1.0, 0.0], 0.1),
        floor().sphere([0.05, 1.0, 0.0], 0.1),
        floor().sphere([0.0, 2.0, 0.0], 0.5),
        floor().sphere([2.0, 0.0, 0.5], 2.5),
        floor().plane([0.0, 1.0, 0.0], [-0.8, 0.6, 0.0]),
    ];
    for scene in occluded {
        let terms = scene.light(light, 1.0).first_light();
        assert_eq!(terms.outcome, Outcome::Occluded);
        assert_eq!(terms.occluder.as_deref(), Some("object1"));
        assert!(!terms.visible);
        assert_eq!(terms.radiance, [0.0; 3]);
        assert!(terms.incident[0] > 0.0 && terms.diffuse[0] > 0.0);
    }
}

#[test]
fn the_nearest_occluder_is_named() {
    let scene = floor()
        .sphere([0.0, 3.0, 0.0], 0.5)
        .sphere([0.0, 1.0, 0.0], 0.5)
        .plane([0.0, 4.0, 0.0], [0.0, 1.0, 0.0])
        .light([0.0, 5.0, 0.0], 1.0);
    let occluder = scene.first_light().occluder;
    assert_eq!(occluder.as_deref(), Some("object2"));
}

#[test]
fn surfaces_have_two_sides() {
    let seen = |eye: f64, light: f64, normal: f64| {
        Builder::looking([0.0, eye, 1.0], [0.0; 3])
            .plane([0.0; 3], [0.0, normal, 0.0])
            .light([0.0, light, 0.0], 4.0)
            .first_light()
    };
    for normal in [1.0, -1.0, 3.0] {
        for side in [1.0, -1.0] {
            assert_near(seen(side, 2.0 * side, normal).radiance[0], 1.0, ROUNDING);
            let behind = seen(side, -2.0 * side, normal);
            assert_eq!(behind.outcome, Outcome::Below);
            assert_eq!(behind.radiance, [0.0; 3]);
        }
    }
}

#[test]
fn a_sphere_from_inside() {
    let inside = |light| {
        Builder::looking([0.2, 0.1, 0.0], [1.0, 0.3, 0.2])
            .sphere([0.0; 3], 1.0)
            .light(light, 1.0)
            .first_light()
    };
    assert_eq!(inside([-0.5, 0.3, 0.2]).outcome, Outcome::Lit);
    // On the sphere nothing stands between any more.
    assert_eq!(inside([-0.6, 0.0, 0.8]).outcome, Outcome::Lit);
    let outside = inside([-2.0, 0.3, 0.2]);
    assert_eq!(outside.outcome, Outcome::Occluded);
    assert_eq!(outside.occluder.as_deref(), Some("object0"));
    // Outside, behind the seen point.
    assert_eq!(inside([3.0, 1.0, 0.5]).outcome, Outcome::Below);
}

#[test]
fn coincident_surfaces_do_not_shade_each_other() {
    let tilted = unit([0.3, 1.0, -0.2]).unwrap();
    let side = unit(cross(tilted, [1.0, 0.0, 0.0])).unwrap();
    let other = cross(side, tilted);
    let corner = |a: f64, b: f64| add(scale(side, a), scale(other, b));
    let triangle = [corner(-9.0, -7.0), corner(9.0, -8.0), corner(1.0, 9.0)];
    let turned = [triangle[1], triangle[2], triangle[0]];
    let flipped = [triangle[0], triangle[2], triangle[1]];
    for distance in [1.0, 1e3, 1e6] {
        let camera = perspective([0.5 * distance, 1.1 * distance, 0.3], [0.0; 3], 1.0);
        let scene = Builder::new([16, 16], camera)
            .triangle(triangle)
            .triangle(turned)
            .triangle(flipped)
            .plane(triangle[1], tilted)
            .plane(scale(corner(1e3, -1e3), -1.0), scale(tilted, -3.0))
            .light([3.0, 4.0, 5.0], 1.0);
        let oracle = scene.oracle();
        for (x, y) in (0..16).flat_map(|x| (0..16).map(move |y| (x, y))) {
            let decisions = oracle.decisions(f64::from(x) + 0.5, f64::from(y) + 0.5);
            assert!(decisions.hit.is_some());
            assert_eq!(decisions.lights, [Outcome::Lit], "{distance} {x} {y}");
        }
    }
    // A huge triangle, seen close to the middle, on a plane and on a small triangle.
    let huge = triangle.map(|vertex| scale(vertex, 1e6));
    for eye in [[0.5, 0.9, -0.4], [3.0, 0.1, 0.2], [0.2, 2.5, 7.0]] {
        let scene = Builder::new([16, 16], perspective(eye, [0.0; 3], 5.0))
            .triangle(huge)
            .triangle(triangle)
            .plane([0.0; 3], tilted)
            .light([0.3, 0.4, 0.5], 1.0);
        for object in 0..3 {
            let seen = outcomes(&scene, object);
            assert_eq!(count(&seen, Outcome::Lit), seen.len(), "{eye:?}");
        }
    }
    let camera = perspective([4.0, 5.0, 6.0], [0.1, 0.2, 0.3], 20.0);
    let spheres = Builder::new([40, 40], camera)
        .sphere([0.1, 0.2, 0.3], 0.7)
        .sphere([0.1, 0.2, 0.3], 0.7)
        .light([3.0, 4.0, -5.0], 1.0);
    let seen = outcomes(&spheres, 0);
    assert!(count(&seen, Outcome::Lit) > 50 && count(&seen, Outcome::Below) > 50);
    assert_eq!(count(&seen, Outcome::Occluded), 0);
}

#[test]
fn touching_surfaces() {
    // A ball on the floor and one on top of it, the light aside: the lower ball shades the floor,
    // never itself; the upper one shades the lower one.
    let camera = || perspective([0.0, 1.5, 6.0], [0.0, 0.7, 0.0], 25.0);
    let scene = Builder::new([60, 60], camera())
        .plane(FLOOR.0, FLOOR.1)
        .sphere([0.0, 0.5, 0.0], 0.5)
        .sphere([0.0, 1.25, 0.0], 0.25)
        .light([4.0, 1.25, 0.0], 1.0);
    let upper = outcomes(&scene, 2);
    assert!(count(&upper, Outcome::Lit) > 20);
    assert_eq!(count(&upper, Outcome::Occluded), 0);
    let lower = outcomes(&scene, 1);
    assert_eq!(count(&lower, Outcome::Occluded), 0);
    let above = Builder::new([60, 60], camera())
        .plane(FLOOR.0, FLOOR.1)
        .sphere([0.0, 0.5, 0.0], 0.5)
        .sphere([0.0, 1.25, 0.0], 0.25)
        .light([0.0, 4.0, 0.0], 1.0);
    assert!(count(&outcomes(&above, 1), Outcome::Occluded) > 20);
    // The very point where two touch, seen from inside the other one.
    let at = |point: [f64; 3], light: [f64; 3]| {
        let eye = add(point, [0.3, 0.0, 0.0]);
        outcome(
            &Builder::looking(eye, point)
                .sphere([0.0, 0.5, 0.0], 0.5)
                .sphere([1.0, 0.5, 0.0], 0.5)
                .light(light, 1.0),
        )
    };
    assert_eq!(at([0.5, 0.5, 0.0], [1.2, 0.5, 0.0]), Outcome::Lit);
    assert_eq!(at([0.5, 0.5, 0.0], [2.0, 0.5, 0.0]), Outcome::Occluded);
}

#[test]
fn no_acne_at_the_edges_of_a_convex_mesh() {
    let globe = globe(10);
    let light = [3.0, 4.0, 5.0];
    for moved in [0.0, 1e3] {
        let placed = Placed {
            translate: [moved, 0.0, -moved],
            ..AS_IS
        };
        let light = add(light, placed.translate);
        for triangle in &globe.triangles {
            let [a, b, c] = triangle.map(|i| globe.positions[i as usize]);
            if unit(cross(subtract(b, a), subtract(c, a))).is_none() {
                continue;
            }
            let middle = [0, 1, 2].map(|i| (a[i] + b[i] + c[i]) / 3.0);
            for at in [
                a,
                scale(add(a, b), 0.5),
                add(scale(a, 0.9), scale(c, 0.1)),
                middle,
            ] {
                let at = add(at, placed.translate);
                let eye = add(at, scale(middle, 3.0));
                let scene = Builder::looking(eye, at)
                    .mesh(&globe, placed)
                    .light(light, 1.0);
                assert_ne!(outcome(&scene), Outcome::Occluded, "{at:?}");
            }
        }
    }
}

#[test]
fn no_acne_at_the_edge_of_a_huge_triangle() {
    // A ridge: what rounding makes of the huge side's points must not hide them below the other.
    let (start, end) = ([-1.1, 0.3, 0.2], [1.3, 0.2, -0.1]);
    let ridge = MeshFile {
        positions: vec![[2e6, -3e6, 7e6], start, end, [0.3, -0.7, -1.0]],
        triangles: vec![[0, 1, 2], [3, 2, 1]],
        ..MeshFile::default()
    };
    let ridge = Arc::new(ridge);
    let mut seen = 0;
    for i in 0..200 {
        let along = f64::from(i) / 200.0;
        let at = add(start, scale(subtract(end, start), along));
        let scene = Builder::looking([0.3, 4.0, 0.5], at)
            .mesh(&ridge, AS_IS)
            .light([0.2, 3.0, 0.3], 1.0);
        // Rounding may put the point beside the edge, where nothing is.
        if let Some(light) = scene.oracle().explain(0.5, 0.5).lights.first() {
            assert_eq!(light.outcome, Outcome::Lit, "{at:?}");
            seen += 1;
        }
    }
    assert!(seen > 20, "{seen}");
}

#[test]
fn a_light_on_a_surface() {
    // On the floor: no light for the floor, but for the ball that stands on it.
    let camera = perspective([0.0, 2.0, 6.0], [0.0, 0.5, 0.0], 25.0);
    let glossy = Material::Phong(lobes(0.5, 0.5, Some(2.0)));
    for (point, normal) in [FLOOR, ([0.1, 0.02, 0.3], [0.2, -1.0, 0.0])] {
        let scene = Builder::new([40, 40], camera.clone())
            .material(MATTE, glossy.clone())
            .plane(point, normal)
            .sphere([0.0, 0.8, 0.0], 0.5)
            .light(
                add(point, [1.0, 0.2 * -normal[0] / normal[1] * 5.0, 0.7]),
                1.0,
            );
        let floor = outcomes(&scene, 0);
        assert_eq!(count(&floor, Outcome::Below), floor.len());
        let ball = outcomes(&scene, 1);
        assert!(count(&ball, Outcome::Lit) > 20);
        assert_eq!(count(&ball, Outcome::Occluded), 0);
    }
    // At the very point that is seen: d = 0.
    for (x, z) in [(0.0, 0.0), (0.1, 0.7), (-3.3, 0.123)] {
        let at = [x, 0.0, z];
        let scene = Builder::looking([1.0, 2.0, 3.0], at)
            .plane(FLOOR.0, FLOOR.1)
            .light(at, 1.0);
        let terms = scene.first_light();
        assert_eq!(terms.outcome, Outcome::AtPoint);
        assert_eq!(terms.radiance, [0.0; 3]);
    }
    // On a sphere, seen from the floor under it.
    let on_a_sphere = floor().sphere([0.0, 1.0, 0.0], 0.5);
    let below = on_a_sphere.clone().light([0.3, 0.6, 0.0], 1.0);
    assert_eq!(outcome(&below), Outcome::Lit);
    let on_top = on_a_sphere.light([0.3, 1.4, 0.0], 1.0);
    assert_eq!(outcome(&on_top), Outcome::Occluded);
}

#[test]
fn grazing_light() {
    // cos(n, ω_i) down to 1e-12, on a floor that is not along an axis.
    let normal = unit([0.3, 1.0, -0.2]).unwrap();
    let along = unit(cross(normal, [1.0, 0.0, 0.0])).unwrap();
    for height in [1e-3, 1e-6, 1e-9, 1e-12] {
        let light = add(along, scale(normal, height));
        let scene = |light| {
            Builder::looking(normal, [0.0; 3])
                .plane([0.0; 3], normal)
                .light(light, 1.0)
                .first_light()
        };
        let above = scene(light);
        assert_eq!(above.outcome, Outcome::Lit);
        // The light's own coordinates are rounded to 1e-16.
        let expected = height / (1.0 + height * height).powf(1.5);
        assert_near(above.radiance[0], expected, 1e-15 / height + ROUNDING);
        let below = scene(subtract(light, scale(normal, 2.0 * height)));
        assert_eq!(below.outcome, Outcome::Below);
    }
}

#[test]
fn a_light_as_far_as_the_sun() {
    let to_sun = unit([0.3, 0.9, 0.2]).unwrap();
    let sun = scale(to_sun, 1.5e11);
    let center = scale(to_sun, 2.0);
    let aside = unit(cross(to_sun, [0.0, 0.0, 1.0])).unwrap();
    // The shadow of a ball of radius 1e-3 ends within 1e-9 of its rim.
    for (offset, expected) in [
        (1e-3 - 1e-9, Outcome::Occluded),
        (1e-3 + 1e-9, Outcome::Lit),
    ] {
        let scene = floor()
            .sphere(add(center, scale(aside, offset)), 1e-3)
            .light(sun, 1e22);
        assert_eq!(outcome(&scene), expected, "{offset}");
        let edge = subtract(add(center, scale(aside, offset)), scale(aside, 1e-3));
        let triangle = [
            add(edge, [0.0, 0.0, -1.0]),
            add(edge, [0.0, 0.0, 1.0]),
            add(edge, aside),
        ];
        let scene = floor().triangle(triangle).light(sun, 1e22);
        assert_eq!(outcome(&scene), expected, "{offset}");
    }
}

#[test]
fn a_floor_to_the_horizon() {
    // Rays that are ever closer to the horizon; the ball's shadow falls on one of the points.
    for distance in [1e3, 1e6, 1e9, 1e12] {
        let eye = [0.0, 1.0, 0.0];
        let point = [0.0, 0.0, -distance];
        let scene = Builder::looking(eye, point).plane(FLOOR.0, FLOOR.1);
        let light = [0.0, 2.0, 1.0];
        let lit = scene.clone().light(light, 1.0).first_light();
        assert_eq!(lit.outcome, Outcome::Lit);
        let expected = 2.0 / (distance + 1.0).hypot(2.0).powi(3);
        // t is 1 / cos of an angle that is known to ε.
        assert_near(lit.radiance[0], expected, 1e-15 * distance + 1e-11);
        let way = unit(subtract(point, light)).unwrap();
        let before = add(light, scale(way, 0.5));
        let ball = scene.sphere(before, 0.01).light(light, 1.0);
        assert_eq!(outcome(&ball), Outcome::Occluded);
    }
}

#[test]
fn the_side_of_a_smooth_surface_is_that_of_its_triangles() {
    // The interpolated normal leans towards the light, which is below the triangle.
    let mesh = |lean: f64| {
        Arc::new(MeshFile {
            positions: vec![[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 0.0, -2.0]],
            triangles: vec![[0, 1, 2]],
            normals: Some(MeshNormals {
                vectors: vec![unit([lean, 1.0, 0.0]).unwrap(); 3],
                triangles: None,
            }),
            groups: Vec::new(),
            remarks: MeshRemarks::default(),
        })
    };
    let seen = |lean, light| {
        Builder::looking([0.0, 2.0, 0.1], [0.0; 3])
            .mesh(&mesh(lean), AS_IS)
            .light(light, 1.0)
            .first_light()
    };
    let below = seen(1.0, [2.0, -0.1, 0.0]);
    assert!(below.cos_incident > 0.6);
    assert_eq!(below.outcome, Outcome::Below);
    // And the other way round: above the triangle, but behind the interpolated normal.
    let above = seen(-1.0, [2.0, 0.1, 0.0]);
    assert_eq!(above.outcome, Outcome::Lit);
    assert_eq!((above.cos_incident, above.radiance[0]), (0.0, 0.0));
    let between = seen(1.0, [1.0, 1.0, 0.0]);
    assert_near(between.cos_incident, 1.0, ROUNDING);
    assert!(dot(between.to_light, between.reflected) > 1.0 - ROUNDING);
}

/// The middle of an arc's chord from −θ to θ: sin²θ below both tangent planes, lifted by cos θ sin²θ.
#[test]
fn shadow_rays_start_off_a_chord() {
    let (sin, cos) = 0.5_f64.sin_cos();
    let [left, right] = [-sin, sin].map(|x| [x, cos]);
    let corner = |[x, y]: [f64; 2], z: f64| [x, y, z];
    let mesh = Arc::new(MeshFile {
        positions: vec![
            corner(left, -1.0),
            corner(right, -1.0),
            corner(right, 1.0),
            corner(left, 1.0),
        ],
        triangles: vec![[0, 2, 1], [0, 3, 2]],
        normals: Some(MeshNormals {
            vectors: [left, right, right, left]
                .map(|at| corner(at, 0.0))
                .to_vec(),
            triangles: None,
        }),
        ..MeshFile::default()
    });
    let hanika = Placed {
        shadow_terminator: ShadowTerminator::Hanika,
        ..AS_IS
    };
    let seen = |height: f64, placed| {
        Builder::looking([0.0, height, 1.0], [0.0, cos, 0.25]).mesh(&mesh, placed)
    };
    let lift = |scene: &Builder| {
        let explanation = scene.oracle().explain(0.5, 0.5);
        explanation.hit.expect("the chord is seen").lift
    };
    let outside = seen(3.0, hanika);
    let [x, y, z] = lift(&outside).expect("it is lifted");
    assert_near(y, cos * sin * sin, ROUNDING);
    assert!(x.hypot(z) < 1e-15, "{x} {z}");
    // From within, the arc is hollow, and with the flat normal nothing is asked for.
    assert_eq!(lift(&seen(-3.0, hanika)), Some([0.0; 3]));
    assert_eq!(lift(&seen(3.0, AS_IS)), None);
    let flat = Placed {
        smooth: false,
        ..hanika
    };
    assert_eq!(lift(&seen(3.0, flat)), None);
}

/// A light beside the end of a triangle but before the tangent plane of p: below for the one rule, above for
/// the other; and something that is in the way of p alone, or of p′ alone.
#[test]
fn the_interpolated_normal_tells_the_side() {
    let leaning = Arc::new(MeshFile {
        positions: vec![[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 0.0, 1.0]],
        triangles: vec![[0, 2, 1]],
        normals: Some(MeshNormals {
            vectors: vec![[-0.6, 0.8, 0.0], [0.6, 0.8, 0.0], [0.6, 0.8, 0.0]],
            triangles: None,
        }),
        ..MeshFile::default()
    });
    let seen = |shadow_terminator| {
        let placed = Placed {
            shadow_terminator,
            ..AS_IS
        };
        Builder::looking([0.0, 3.0, 1.0], [0.0; 3]).mesh(&leaning, placed)
    };
    // n is (0.3, 0.8, 0) at unit length.
    let light = [4.0, -0.5, 0.0];
    let [below, above] = [ShadowTerminator::Geometric, ShadowTerminator::Hanika].map(seen);
    assert_eq!(outcome(&below.light(light, 1.0)), Outcome::Below);
    assert_eq!(outcome(&above.light(light, 1.0)), Outcome::Lit);
    // p is lifted by 0.24: over a sliver on the way from p to a light.
    let sliver = [[0.5, 0.1, -1.0], [0.5, 0.1, 1.0], [0.5, -0.1, 0.0]];
    for (terminator, expected) in [
        (ShadowTerminator::Geometric, Outcome::Occluded),
        (ShadowTerminator::Hanika, Outcome::Lit),
    ] {
        let scene = seen(terminator)
            .triangle(sliver)
            .light([4.0, 0.1, 0.0], 1.0);
        assert_eq!(outcome(&scene), expected);
    }
}
