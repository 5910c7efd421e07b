//! Illuminance of planes that are none of the scene's, beside what the oracle says of surfaces that are there.

use candela::oracle::Oracle;
use candela::scene::Scene;
use candela::{World, illuminance};

use crate::generate;
use crate::images::parse;

/// Luminance of linear Rec.709 (IEC 61966-2-1).
const WEIGHTS: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// The weights have four digits, those of the color space sixteen.
const DIGITS: f64 = 1e-4;

/// A floor with something on it, under a light of each kind.
fn scene(folder: &std::path::Path) -> Scene {
    std::fs::copy("tests/bad_scenes/lamp.ies", folder.join("lamp.ies")).unwrap();
    let text = "
        [image]
        resolution = [40, 30]
        [camera.perspective]
        eye = [0.3, 2.5, 4.0]
        look_at = [0.0, 0.2, 0.0]
        vertical_fov = 50
        [materials.m.phong]
        diffuse = 0.5
        [lights.point.point]
        position = [0.5, 2.0, 0.3]
        intensity = [90, 100, 80]
        [lights.spot.spot]
        position = [-1.0, 3.0, 1.0]
        look_at = [0.0, 0.0, 0.0]
        intensity = { lumens = 300 }
        inner = 10
        outer = 30
        falloff = \"linear_angle\"
        [lights.lamp.ies]
        position = [1.5, 1.5, -0.5]
        look_at = [0.2, 0.0, 0.2]
        file = \"lamp.ies\"
        [lights.noon.sun]
        direction = [-1, -3, -1]
        illuminance = [50, 60, 70]
        [objects.floor.plane]
        material = \"m\"
        point = [0, 0, 0]
        normal = [0, 1, 0]
        [objects.ball.sphere]
        material = \"m\"
        center = [0.2, 0.4, 0.0]
        radius = 0.4
        [objects.sail.triangle]
        material = \"m\"
        vertices = [[-1.0, 0.5, 0.5], [-0.5, 0.5, -0.5], [-0.8, 1.5, 0.0]]
        ";
    Scene::parse(text, folder.join("scene.toml")).unwrap()
}

#[test]
fn a_floor_is_lit_as_the_oracle_says() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path());
    let oracle = Oracle::new(&scene);
    let (mut points, mut expected) = (Vec::new(), Vec::new());
    for (x, y) in (0..40).flat_map(|x| (0..30).map(move |y| (x, y))) {
        let explanation = oracle.explain(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let Some(hit) = explanation.hit.filter(|hit| hit.object == "floor") else {
            continue;
        };
        let lux = explanation.lights.iter().map(|light| {
            let arrives: f64 = light.incident.iter().zip(WEIGHTS).map(|(e, w)| e * w).sum();
            let visible = f64::from(u8::from(light.visible));
            arrives * light.cos_incident * visible
        });
        points.push(hit.position);
        expected.push(lux.sum::<f64>());
    }
    assert!(points.len() > 400);
    let (world, _) = World::new(&scene).unwrap();
    let found = illuminance(&world, &points, [0.0, 2.0, 0.0]).unwrap();
    let (mut lit, mut dark) = (0, 0);
    for ((found, expected), point) in found.iter().zip(&expected).zip(&points) {
        let error = (found - expected).abs();
        assert!(
            error <= DIGITS * expected.max(1e-9),
            "{point:?}: {found}, expected {expected}"
        );
        lit += usize::from(*expected > 100.0);
        dark += usize::from(*expected < 60.0);
    }
    assert!(lit > 50 && dark > 50, "{lit} {dark}");
    // From below the floor is in the way of nothing: it is lit from there by none of them.
    let below = illuminance(&world, &points, [0.0, -1.0, 0.0]).unwrap();
    assert!(below.iter().all(|&lux| lux == 0.0));
}

/// E = I / h² below a lamp, I cos³θ / h² beside it; of a sun E cos θ.
#[test]
fn a_plane_in_the_air() {
    let scene = parse(
        "[image]\nresolution = [8, 8]\n[camera.perspective]\neye = [0, 1, 4]\nlook_at = [0, 0, 0]\nvertical_fov = 40\n\
         [materials.m.phong]\ndiffuse = 0.5\n\
         [objects.far.sphere]\nmaterial = \"m\"\ncenter = [50, 0, 0]\nradius = 1\n\
         [lights.lamp.point]\nposition = [1, 3, 2]\nintensity = 80\n\
         [lights.sun.sun]\ndirection = [0, -4, 3]\nilluminance = 10\n",
    );
    let (world, _) = World::new(&scene).unwrap();
    let points = [[1.0, 1.0, 2.0], [2.0, 1.0, 4.0]];
    let found = illuminance(&world, &points, [0.0, 1.0, 0.0]).unwrap();
    let expected = [80.0 / 4.0 + 8.0, 80.0 * 2.0 / 27.0 + 8.0];
    for (found, expected) in found.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 1e-14, "{found} {expected}");
    }
}

/// On any plane of generated scenes it is a number from 0.
#[test]
fn it_is_a_number_everywhere() {
    let folder = tempfile::tempdir().unwrap();
    for (name, scene) in generate::suns(20, folder.path()) {
        let (world, _) = World::new(&scene).unwrap();
        let anchor = scene.camera.value.view().look_at.value;
        let points: Vec<[f64; 3]> = (0..300)
            .map(|i| {
                [
                    anchor[0] + f64::from(i % 20),
                    anchor[1],
                    anchor[2] + f64::from(i / 20),
                ]
            })
            .collect();
        let lux = illuminance(&world, &points, [0.3, 1.0, 0.1]).unwrap();
        assert!(
            lux.iter().all(|lux| lux.is_finite() && *lux >= 0.0),
            "{name}"
        );
    }
}
