//! L1 and L2: cameras, hits, normals and transformed meshes.

use super::*;
use crate::mesh::{MeshGroup, MeshRemarks};
use crate::oracle::vector::{add, dot, length, narrowed, subtract, unit};

fn normal_and_geometric(scene: &Builder) -> ([f64; 3], [f64; 3]) {
    let hit = scene.oracle().explain(0.5, 0.5).hit.unwrap();
    (hit.normal, hit.geometric_normal)
}

#[track_caller]
fn assert_same(actual: [f64; 3], expected: [f64; 3]) {
    let distance = length(subtract(actual, expected));
    assert!(
        distance <= ROUNDING * length(expected).max(1.0),
        "{actual:?}, expected {expected:?}"
    );
}

fn one_triangle(vertices: [[f64; 3]; 3], normals: Option<[[f64; 3]; 3]>) -> Arc<MeshFile> {
    Arc::new(MeshFile {
        positions: vertices.to_vec(),
        triangles: vec![[0, 1, 2]],
        normals: normals.map(|vectors| MeshNormals {
            vectors: vectors.to_vec(),
            triangles: None,
        }),
        groups: Vec::new(),
        remarks: MeshRemarks::default(),
    })
}

#[test]
fn the_image_has_its_top_left_first() {
    // Right, up and towards the viewer are +x, +y and +z; the image is 4 wide and 2 high.
    let place = |camera: Camera, [px, py]: [f64; 2]| {
        let scene = Builder::new([40, 20], camera).plane([0.0; 3], [0.0, 0.0, 1.0]);
        scene.oracle().explain(px, py).hit.unwrap().position
    };
    let fov = 2.0 * 0.5_f64.atan().to_degrees();
    for camera in [
        perspective([0.0, 0.0, 2.0], [0.0; 3], fov),
        orthographic([0.0, 0.0, 2.0], [0.0; 3], 2.0),
    ] {
        assert_same(place(camera.clone(), [0.0, 0.0]), [-2.0, 1.0, 0.0]);
        assert_same(place(camera.clone(), [40.0, 20.0]), [2.0, -1.0, 0.0]);
        assert_same(place(camera.clone(), [20.0, 10.0]), [0.0, 0.0, 0.0]);
        assert_same(place(camera, [25.0, 2.5]), [0.5, 0.75, 0.0]);
    }
}

/// Of a plane across the view it is the same everywhere, and the distance along the ray is not.
#[test]
fn depth_is_along_the_view_axis() {
    let eye = [1.0, 2.0, 8.0];
    let hit = |camera: Camera, [px, py]: [f64; 2]| {
        let scene = Builder::new([40, 20], camera).plane([0.0; 3], [0.0, 0.0, 1.0]);
        scene.oracle().explain(px, py).hit.unwrap()
    };
    let ahead = [1.0, 2.0, 0.0];
    for pixel in [[20.0, 10.0], [0.0, 0.0], [33.0, 7.0]] {
        let seen = hit(perspective(eye, ahead, 50.0), pixel);
        assert!((seen.depth - 8.0).abs() <= 8.0 * ROUNDING);
        assert_eq!(seen.distance > 8.1, pixel != [20.0, 10.0]);
        let parallel = hit(orthographic(eye, ahead, 3.0), pixel);
        assert!((parallel.depth - 8.0).abs() <= 8.0 * ROUNDING);
        assert!((parallel.distance - 8.0).abs() <= 8.0 * ROUNDING);
    }
}

#[test]
fn perspective_from_far_away_is_orthographic() {
    let ball = |camera| {
        Builder::new([16, 12], camera)
            .sphere([0.1, 0.2, 0.0], 0.9)
            .light([2.0, 3.0, 4.0], 20.0)
            .oracle()
    };
    let near = ball(orthographic([0.0, 0.0, 5.0], [0.0; 3], 2.0));
    let distance = 1e6_f64;
    let fov = 2.0 * (1.0 / distance).atan().to_degrees();
    let far = ball(perspective([0.0, 0.0, distance], [0.0; 3], fov));
    // The rays diverge by up to 1e-6, and so does what they hit, a little more near the rim;
    // radiance is around 1.
    const PARALLAX: f64 = 1e-5;
    for (x, y) in (0..16).flat_map(|x| (0..12).map(move |y| (x, y))) {
        let (px, py) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
        assert_eq!(near.decisions(px, py), far.decisions(px, py), "{x} {y}");
        let (near, far) = (near.radiance(px, py), far.radiance(px, py));
        assert!((far.radiance[0] - near.radiance[0]).abs() < PARALLAX);
    }
}

#[test]
fn equally_near_surfaces_in_the_order_of_the_file() {
    let square = [[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    let mesh = Arc::new(MeshFile {
        positions: square.to_vec(),
        triangles: vec![[0, 1, 2], [0, 1, 2]],
        ..MeshFile::default()
    });
    let looking = || Builder::looking([0.1, 2.0, 0.3], [0.0; 3]);
    let hit = |scene: Builder| scene.oracle().trace(0.5, 0.5).unwrap();
    let plane_first = looking().plane([0.0; 3], [0.0, 1.0, 0.0]).triangle(square);
    assert_eq!((hit(plane_first).object, 0), (0, 0));
    let triangle_first = looking().triangle(square).plane([0.0; 3], [0.0, 1.0, 0.0]);
    assert_eq!(hit(triangle_first).object, 0);
    let twice = hit(looking().mesh(&mesh, AS_IS));
    assert_eq!((twice.object, twice.triangle), (0, Some(0)));
}

#[test]
fn hits_count_from_the_camera_on() {
    // Inside the sphere, before the plane, and with a triangle behind the viewer.
    let scene = Builder::looking([0.0, 0.0, 0.5], [0.0, 0.0, -1.0])
        .triangle([[-9.0, -9.0, 1.0], [9.0, -9.0, 1.0], [0.0, 9.0, 1.0]])
        .plane([0.0, 0.0, -3.0], [0.0, 0.0, 1.0])
        .sphere([0.0; 3], 1.0);
    let hit = scene.oracle().explain(0.5, 0.5).hit.unwrap();
    assert_eq!(hit.object, "object2");
    assert_near(hit.distance, 1.5, ROUNDING);
    assert_same(hit.normal, [0.0, 0.0, 1.0]);
    // A viewer on a surface does not see it where the ray leaves it.
    let on_the_sphere = Builder::looking([0.0, 0.0, 1.0], [0.0; 3]).sphere([0.0; 3], 1.0);
    let hit = on_the_sphere.oracle().explain(0.5, 0.5).hit.unwrap();
    assert_near(hit.distance, 2.0, ROUNDING);
}

#[test]
fn a_small_sphere_far_away_keeps_its_shape() {
    let (radius, distance) = (1e-3_f64, 1e4);
    let fov = 2.0 * (radius / distance).atan().to_degrees();
    let oracle = Builder::new([9, 9], perspective([0.0, 0.0, distance], [0.0; 3], fov))
        .sphere([0.0; 3], radius)
        .oracle();
    // The rays are parallel to radius / distance.
    const SHAPE: f64 = 1e-7;
    for (x, y) in [(4.5, 4.5), (6.5, 4.5), (4.5, 1.5), (2.5, 3.5)] {
        let normal = oracle.explain(x, y).hit.unwrap().normal;
        let across = [x / 4.5 - 1.0, 1.0 - y / 4.5];
        assert!((normal[0] - across[0]).abs() < SHAPE, "{normal:?}");
        assert!((normal[1] - across[1]).abs() < SHAPE, "{normal:?}");
    }
    assert!(oracle.trace(0.5, 0.5).is_none());
}

#[test]
fn no_ray_slips_through_the_edges_of_a_mesh() {
    let globe = globe(12);
    let corner = |i: u32| globe.positions[i as usize];
    for triangle in &globe.triangles {
        let [a, b, c] = triangle.map(corner);
        for part in [0.0, 0.5, 0.3] {
            let at = [0, 1, 2].map(|i| a[i] + part * (b[i] - a[i]));
            // Beside the normal, so that nothing is symmetric.
            let beside = [0, 1, 2].map(|i| 2.0 * a[i] + b[i] + c[i]);
            for eye in [
                at.map(|x| 5.0 * x),
                [0, 1, 2].map(|i| at[i] + beside[i]),
                [0.1, 0.05, -0.02],
            ] {
                let scene = Builder::looking(eye, at).mesh(&globe, AS_IS);
                let hit = scene.oracle().explain(0.5, 0.5).hit;
                let distance = hit.map_or(f64::INFINITY, |hit| hit.distance);
                assert_near(distance, length(subtract(at, eye)), ROUNDING);
            }
        }
    }
}

#[test]
fn triangles_without_an_area_are_not_there() {
    let through = [0.0, 0.0, 0.0];
    let scene = Builder::looking([0.0, 0.0, 2.0], through)
        .triangle([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.0, 0.0]])
        .triangle([through; 3])
        .triangle([[f64::NAN; 3]; 3])
        .triangle([[f64::INFINITY, 0.0, 0.0], [0.0; 3], [0.0, 1.0, 0.0]]);
    assert_eq!(scene.oracle().trace(0.5, 0.5), None);
}

#[test]
fn meshes_are_scaled_then_rotated_about_x_y_z_then_moved() {
    let position = |placed: Placed, v: [f64; 3]| {
        let mesh = one_triangle([v, [7.0, 0.0, 0.0], [0.0, 7.0, 0.0]], None);
        let scene = Builder::looking([0.0, 0.0, 100.0], [0.0; 3]).mesh(&mesh, placed);
        match scene.oracle().surfaces[0].shape {
            crate::oracle::surface::Shape::Triangle { vertices, .. } => {
                add(narrowed(vertices[0]), [0.0, 0.0, 100.0])
            }
            _ => unreachable!("a mesh has only triangles"),
        }
    };
    let all = Placed {
        scale: [2.0, 3.0, 4.0],
        rotate: [90.0, 0.0, 90.0],
        translate: [10.0, 20.0, 30.0],
        ..AS_IS
    };
    // (1, 1, 1) → scaled (2, 3, 4) → about x: (2, −4, 3) → about z: (4, 2, 3) → moved.
    assert_same(position(all, [1.0; 3]), [14.0, 22.0, 33.0]);
    let about_y = Placed {
        rotate: [0.0, 90.0, 0.0],
        ..AS_IS
    };
    assert_same(position(about_y, [1.0, 2.0, 3.0]), [3.0, 2.0, -1.0]);
    let y_then_z = Placed {
        rotate: [0.0, 90.0, 90.0],
        ..AS_IS
    };
    assert_same(position(y_then_z, [1.0, 2.0, 3.0]), [-2.0, 3.0, -1.0]);
}

#[test]
fn vertex_normals_are_interpolated_on_the_side_of_the_surface() {
    let vertices = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 2.0, 0.0]];
    let normals = [[1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [-0.5, 0.0, 3.0]].map(|n| unit(n).unwrap());
    let center = unit([0, 1, 2].map(|i| normals.iter().map(|n| n[i]).sum())).unwrap();
    let seen = |from: f64, normals, smooth| {
        let mesh = one_triangle(vertices, normals);
        let placed = Placed { smooth, ..AS_IS };
        normal_and_geometric(&Builder::looking([0.0, 0.0, from], [0.0; 3]).mesh(&mesh, placed))
    };
    let front = [0.0, 0.0, 1.0];
    let back = [0.0, 0.0, -1.0];
    let away = Some(normals.map(|n| n.map(|x| -x)));
    assert_same(seen(3.0, Some(normals), true).0, center);
    assert_same(seen(3.0, away, true).0, center);
    assert_same(seen(-3.0, Some(normals), true).0, center.map(|x| -x));
    assert_eq!(seen(3.0, Some(normals), true).1, front);
    assert_eq!(seen(-3.0, Some(normals), true).1, back);
    assert_eq!(seen(3.0, Some(normals), false).0, front);
    assert_eq!(seen(3.0, None, true).0, front);
    // Normals that cancel have no direction: the surface's own counts.
    let cancel = [[1.0, 0.0, 0.0], [-0.5, 0.75, 0.0], [-0.5, -0.75, 0.0]];
    let at_middle = seen(3.0, Some(cancel), true).0;
    assert!(length(at_middle) > 0.999_999, "{at_middle:?}");
}

#[test]
fn normals_stay_square_to_a_surface_that_is_stretched() {
    let vertices = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mesh = one_triangle(vertices, Some([[2.0, 2.0, 2.0]; 3]));
    for scale in [
        [2.0, 1.0, 1.0],
        [0.3, 5.0, 1.0],
        [-1.0, 2.0, 3.0],
        [-1.0, -2.0, -4.0],
    ] {
        for rotate in [[0.0; 3], [30.0, 0.0, 0.0], [25.0, -130.0, 70.0]] {
            let placed = Placed {
                scale,
                rotate,
                ..AS_IS
            };
            let origin = Builder::looking([0.0; 3], [0.0, 0.0, 1.0]).mesh(&mesh, placed);
            let crate::oracle::surface::Shape::Triangle { vertices, .. } =
                origin.oracle().surfaces[0].shape
            else {
                unreachable!("a mesh has only triangles");
            };
            let vertices = vertices.map(narrowed);
            let center = [0, 1, 2].map(|i| vertices.iter().map(|v| v[i] / 3.0).sum());
            let scene = Builder::looking([0.0; 3], center).mesh(&mesh, placed);
            let (normal, geometric) = normal_and_geometric(&scene);
            assert_same(normal, geometric);
            assert!(dot(normal, center) < 0.0, "towards the viewer");
        }
    }
}

#[test]
fn groups_and_separate_normal_indices() {
    let vertices = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 2.0, 0.0]];
    let mesh = MeshFile {
        positions: vertices.iter().copied().chain([[0.0, -9.0, 0.0]]).collect(),
        triangles: vec![[0, 1, 3], [0, 1, 2]],
        normals: Some(MeshNormals {
            vectors: vec![[0.0, 0.0, 2.0], [0.0, 3.0, 4.0]],
            triangles: Some(vec![[0, 0, 0], [1, 1, 1]]),
        }),
        groups: vec![MeshGroup {
            name: "sail".to_owned(),
            triangles: 1..2,
        }],
        remarks: MeshRemarks::default(),
    };
    let scene = Builder::looking([0.0, 0.0, 3.0], [0.0; 3]).mesh(&Arc::new(mesh), AS_IS);
    let hit = scene.oracle().explain(0.5, 0.5).hit.unwrap();
    assert_eq!(hit.group.as_deref(), Some("sail"));
    assert_eq!(hit.triangle, Some(1));
    assert_same(hit.normal, [0.0, 0.6, 0.8]);
}

#[test]
fn a_scene_that_is_not_legal_does_not_panic() {
    let mut scene = Builder::looking([0.0; 3], [0.0; 3])
        .sphere([0.0, 0.0, -3.0], f64::NAN)
        .plane([0.0; 3], [0.0; 3])
        .sphere([0.0, 0.0, -3.0], 1.0)
        .light([f64::INFINITY; 3], 1.0);
    scene.0.materials.clear();
    scene.oracle().explain(0.5, 0.5);
    scene.0.camera = perspective([0.0; 3], [0.0, 0.0, -1.0], 30.0).into();
    scene.0.lights.push(entry(
        "key",
        Light::Point {
            position: [0.0; 3].into(),
            intensity: Value::Uniform(1.0).into(),
            group: None,
        },
    ));
    // A material that is not there is black.
    assert_eq!(
        scene.oracle().explain(0.5, 0.5).lights[1].radiance,
        [0.0; 3]
    );
    let mesh = MeshFile {
        positions: vec![[0.0; 3]],
        triangles: vec![[0, 1, 2]],
        ..MeshFile::default()
    };
    scene = scene.mesh(&Arc::new(mesh), AS_IS);
    scene.oracle().explain(0.5, 0.5);
}
