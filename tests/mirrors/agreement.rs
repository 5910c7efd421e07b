//! What is seen in mirrors and glass, path by path, beside the oracle.

use candela::render::{Layers, Options};
use candela::scene::{Material, Metal, Mirror, Object, Scene, Value};
use candela::world::World;

use crate::generate;
use crate::images::film_of_text;
use crate::oracle::disagreement;

/// Scenes of all kinds, of which most things are smooth.
fn smooth_scenes(folder: &std::path::Path) -> Vec<(String, Scene)> {
    let are_few = |(_, scene): &(String, Scene)| scene.objects.len() < 30;
    let scenes = generate::scenes(folder)
        .into_iter()
        .filter(are_few)
        .take(30);
    let mut number = 0;
    let scenes = scenes.map(|(name, mut scene)| {
        scene.image.max_depth = 4.0.into();
        for material in &mut scene.materials {
            let name = &material.name;
            let mut objects = scene.objects.iter();
            let is_round = objects.all(|object| {
                object.value.material().value != *name
                    || matches!(object.value, Object::Sphere { .. })
            });
            number += 1;
            match number % 7 {
                0 => material.value = Material::mirror(0.9),
                1 => material.value = Material::mirror([0.9, 0.6, 0.5]),
                2 | 3 if is_round => material.value = Material::glass(1.5),
                3 => material.value = Material::pane(1.4),
                4 => {
                    material.value = Material::Metal(Metal::Preset("copper".to_owned().into()));
                }
                5 => {
                    if let Material::Phong(lobes) | Material::NormalizedPhong(lobes) =
                        &mut material.value
                    {
                        lobes.coat = Some(Mirror {
                            reflectance: Value::Uniform(0.05).into(),
                            schlick: true,
                        });
                    }
                }
                _ => {}
            }
        }
        (name, scene)
    });
    scenes.collect()
}

/// Every ray of generated scenes, path by path, with the oracle.
#[test]
fn generated_scenes_agree_with_the_oracle() {
    let folder = tempfile::tempdir().unwrap();
    let mut scenes = smooth_scenes(folder.path());
    // A metal makes light spectral, and some of the colors too bright.
    scenes.retain(|(_, scene)| World::new(scene).is_ok());
    assert!(scenes.len() >= 20);
    let (mut pixels, mut differ) = (0, 0);
    for (name, scene) in &scenes {
        let [count, wrong] = disagreement(name, scene);
        pixels += count;
        differ += wrong;
    }
    // What is seen by way of balls that touch each other is decided by the last digit, as edges are.
    println!("{differ} of {pixels} pixels differ");
    assert!(differ * 2000 <= pixels, "{differ} of {pixels}");
}

/// Through glass that disperses it each wavelength is the oracle's, where they part and where they come together again.
#[test]
fn dispersed_light_agrees_with_the_oracle() {
    let rest = "[materials.flint.glass]\nsellmeier = \"N-SF11\"\ndispersion = true\n\
        [materials.floor.phong]\ndiffuse = 0.2\n[materials.red.phong]\ndiffuse = [0.28, 0.02, 0.02]\n\
        [materials.bright.phong]\ndiffuse = 0.3\nspecular = 0.5\nshininess = 40\n\
        [lights.key.point]\nposition = [3, 6, 4]\nintensity = { candela = 90, color = { illuminant = \"D65\" } }\n\
        [objects.floor.plane]\nmaterial = \"floor\"\npoint = [0, -1.01, 0]\nnormal = [0, 1, 0]\n\
        [objects.stripe.triangle]\nmaterial = \"red\"\nvertices = [[-3, -1, -4], [3, -1, -4.3], [0, -1, -4.6]]\n\
        [objects.behind.sphere]\nmaterial = \"bright\"\ncenter = [0.4, 0.2, -3]\nradius = 0.5\n";
    for (name, body) in [
        (
            "ball",
            "[objects.body.sphere]\nmaterial = \"flint\"\ncenter = [0, 0, 0]\nradius = 1\n",
        ),
        (
            "two balls",
            "[objects.body.sphere]\nmaterial = \"flint\"\ncenter = [-0.6, 0, 0]\nradius = 0.6\n\
             [objects.other.sphere]\nmaterial = \"flint\"\ncenter = [0.5, 0.1, -0.9]\nradius = 0.7\n",
        ),
    ] {
        let text = format!(
            "[image]\nresolution = [24, 16]\nbackground = [0.1, 0.2, 0.4]\nmax_depth = 4\n\
             [camera.perspective]\neye = [0, 0.6, 5]\nlook_at = [0, 0, 0]\nvertical_fov = 30\n{rest}{body}"
        );
        let scene = Scene::parse(&text, "test.toml").unwrap_or_else(|error| panic!("{error}"));
        let [pixels, differ] = disagreement(name, &scene);
        assert!(differ * 100 <= pixels, "{name}: {differ} of {pixels}");
    }
}

/// The glass around the eye absorbs light as well: of what is in it, and of what is seen through its surface.
#[test]
fn the_glass_around_the_eye_absorbs() {
    for transport in ["rgb", "spectral"] {
        let text = format!(
            "[image]\nresolution = [24, 16]\nmax_depth = 3\ntransport = \"{transport}\"\n\
             [camera.perspective]\neye = [0.1, 0.2, 1.5]\nlook_at = [0.2, 0, -1]\nvertical_fov = 70\n\
             [materials.g.glass]\nn = 1.5\nabsorption = [0.4, 0.2, 0.1]\n[materials.m.phong]\ndiffuse = 0.2\nspecular = 0.3\nshininess = 20\n\
             [lights.l.point]\nposition = [0.5, 1.2, 0.6]\nintensity = 5\n\
             [objects.around.sphere]\nmaterial = \"g\"\ncenter = [0, 0, 0]\nradius = 2\n\
             [objects.within.sphere]\nmaterial = \"m\"\ncenter = [0.2, 0, -0.7]\nradius = 0.6\n\
             [objects.beyond.plane]\nmaterial = \"m\"\npoint = [0, -3, 0]\nnormal = [0, 1, 0]\n"
        );
        let scene = Scene::parse(&text, "test.toml").unwrap_or_else(|error| panic!("{error}"));
        let [_, differ] = disagreement(transport, &scene);
        assert_eq!(differ, 0, "{transport}");
        let layers = Layers {
            lights: true,
            ..Layers::default()
        };
        let options = Options {
            layers,
            ..Options::default()
        };
        let film = film_of_text(&text, &options);
        // The one light sends all there is.
        for (place, pixel) in film.pixels().iter().enumerate() {
            for (channel, share) in pixel.iter().zip(film.values(place)).take(3) {
                assert!((channel - share).abs() <= 1e-6 * channel.abs(), "{place}");
            }
        }
    }
}

/// Smooth meshes, whose interpolated normals may face away from the viewer at their outlines.
#[test]
fn smooth_meshes_agree_with_the_oracle() {
    let folder = tempfile::tempdir().unwrap();
    let mut ball = String::new();
    let (columns, rows) = (7, 5);
    for row in 0..=rows {
        let (across, up) = (std::f64::consts::PI * f64::from(row) / f64::from(rows)).sin_cos();
        for column in 0..columns {
            let turn = std::f64::consts::TAU * f64::from(column) / f64::from(columns);
            let (x, z) = (across * turn.sin(), across * turn.cos());
            ball += &format!("v {x:?} {up:?} {z:?}\nvn {x:?} {up:?} {z:?}\n");
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let at = |row: i32, column: i32| row * columns + column % columns + 1;
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column + 1), at(row + 1, column)];
            for [a, b, c] in [[a, d, c], [a, c, b]] {
                ball += &format!("f {a}//{a} {b}//{b} {c}//{c}\n");
            }
        }
    }
    std::fs::write(folder.path().join("ball.obj"), ball).unwrap();
    for material in [
        "mirror]\nreflectance = 0.9\nschlick = true",
        "metal]\nn = 0.2\nk = 3",
        "phong]\ndiffuse = 0.2\nreflectance = 0.05\nschlick = true",
    ] {
        let text = format!(
            "[image]\nresolution = [80, 80]\nbackground = [0.2, 0.3, 0.5]\ntransport = \"rgb\"\n\
             [camera.perspective]\neye = [0, 1, 4]\nlook_at = [0, 0, 0]\nvertical_fov = 40\n\
             [materials.m.{material}\n[materials.floor.phong]\ndiffuse = 0.2\n\
             [lights.l.point]\nposition = [3, 4, 3]\nintensity = 60\n\
             [objects.ball.mesh]\nmaterial = \"m\"\nfile = \"ball.obj\"\n\
             [objects.floor.plane]\nmaterial = \"floor\"\npoint = [0, -1.2, 0]\nnormal = [0, 1, 0]\n"
        );
        let path = folder.path().join("ball.toml");
        let scene = Scene::parse(&text, &path).unwrap_or_else(|error| panic!("{error}"));
        let [pixels, differ] = disagreement(material, &scene);
        assert!(differ * 2000 <= pixels, "{material}: {differ} of {pixels}");
    }
}
