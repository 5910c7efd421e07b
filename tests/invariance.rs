//! What must not change an image, or must change it in a known way: where a scene is, how large,
//! in which order it is written, how much light it gets, and how it is searched.
//!
//! Where a change leaves every number of the computation as it was, or multiplies it by a power
//! of two, images are compared bit by bit; elsewhere within twice what was measured.

use std::sync::Arc;

use candela::image::Film;
use candela::oracle::Oracle;
use candela::scene::{Material, Object, Scene, Transport, Value};
use candela::world::plan::Acceleration;
use candela::world::{Plan, World};

use crate::generate;
use crate::images::{at_width, bits, film_of, scene_files};
use crate::measured::Measured;
use crate::moved::{moved, times};
use crate::oracle::is_edge;

/// Relative error of a pixel that no rounding explains: then it is on the other side of an edge.
const TOLERANCE: f64 = 1e-5;

/// How far from the origin a scene may be, in multiples of its size, for its coordinates to be
/// rounded to 1e-12 of that.
const FURTHEST: f64 = 1e4;

/// Relative error of a pixel, measured, where lengths times powers of ten round every number anew; the lights just
/// above a surface show it.
const SIZE: f64 = 1.49e-7;

/// The same at 1e6 times the size of the scene, where positions are rounded to 1e-10 of it: a sharp lobe
/// multiplies that.
const PLACE: f64 = 1.30e-6;

/// Three times the light, and the sum of images: each image is rounded to f32.
const TRIPLED: f64 = 8.94e-8;
const SUM: f64 = 1.12e-7;

/// How many times as large a scene is made, and how many units it is moved by.
pub(crate) const SCALES: [f64; 4] = [1e-6, 1e-3, 1e3, 1e6];
pub(crate) const FAR: f64 = 1e6;

/// Pixel centers, and a pattern with the box filter.
const SAMPLES: [u32; 2] = [1, 4];

type Vector = [f64; 3];

/// Generated scenes, some of each kind, and the lecture's; in no more than 64 columns. None is
/// further from the origin than [`FURTHEST`]: coordinates that are computed anew are rounded there.
fn scenes(folder: &tempfile::TempDir) -> Vec<(String, Scene)> {
    let mut scenes = generate::scenes(folder.path());
    scenes.truncate(50);
    scenes.extend(generate::terminators(8, folder.path()));
    scenes.extend(generate::spots(10, folder.path()));
    scenes.extend(generate::suns(10, folder.path()));
    scenes.retain(|(_, scene)| {
        let eye = scene.camera.value.view().eye.value;
        let distance = eye.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        distance <= FURTHEST * size_of(scene)
    });
    assert!(scenes.len() >= 25, "{}", scenes.len());
    scenes.push(("lecture".to_owned(), at_width(Scene::builtin(), 64)));
    scenes
}

/// Without the kinds whose name has one of these words.
fn without(mut scenes: Vec<(String, Scene)>, words: &[&str]) -> Vec<(String, Scene)> {
    scenes.retain(|(name, _)| !words.iter().any(|word| name.contains(word)));
    assert!(scenes.len() >= 10);
    scenes
}

/// Images that must be the same but for rounding.
struct Same {
    worst: Measured,
    flips: usize,
}

impl Same {
    fn of(worst: Measured) -> Self {
        Self { worst, flips: 0 }
    }

    /// Compares what a change has made of an image, after `expected`, the scene's own, is multiplied.
    fn see(
        &mut self,
        name: &str,
        (scene, samples): (&Scene, u32),
        actual: &Film,
        expected: &Film,
        times: f64,
    ) {
        assert_eq!(actual.pixels().len(), expected.pixels().len());
        let mut off = Vec::new();
        for (index, (a, b)) in actual.pixels().iter().zip(expected.pixels()).enumerate() {
            let expected = [0, 1, 2].map(|i| f64::from(b[i]) * times);
            let channels = expected.iter().map(|channel| channel.abs());
            let scale = channels.fold(f64::MIN_POSITIVE, f64::max);
            let channels = expected.iter().zip(a);
            let errors = channels.map(|(b, &a)| (f64::from(a) - b).abs() / scale);
            let error = errors.fold(0.0, f64::max);
            if a[3] != b[3] || error > TOLERANCE {
                off.push(index);
            } else {
                self.worst.see(error, || format!("{name}, pixel {index}"));
            }
        }
        // One may be at an edge; none is, of those that were compared.
        assert!(off.len() <= 1, "{name}: pixels {off:?} differ");
        self.flips += off.len();
        if samples == 1 && !off.is_empty() {
            let oracle = Oracle::new(scene);
            let width = oracle.resolution()[0] as usize;
            off.retain(|index| !is_edge(&oracle, scene, [index % width, index / width]));
            assert!(off.is_empty(), "{name}: {off:?} are off any edge");
        }
    }

    fn judge(&self) {
        println!("{} flips", self.flips);
        self.worst.judge();
    }
}

fn with_light(scene: &Scene, factor: f64) -> Scene {
    let mut scene = scene.clone();
    scene.image.background.value = times(&scene.image.background.value, factor);
    for light in &mut scene.lights {
        let intensity = light.value.size_mut();
        intensity.value = times(&intensity.value, factor);
    }
    scene
}

fn has_mesh(scene: &Scene) -> bool {
    let mut objects = scene.objects.iter();
    objects.any(|object| matches!(object.value, Object::Mesh { .. }))
}

/// No distance is compared with a fixed one. Powers of ten round every number anew, so the images
/// are not the same to the bit.
#[test]
fn size() {
    let folder = tempfile::tempdir().unwrap();
    let mut same = Same::of(Measured::new("size", SIZE));
    for (name, scene) in scenes(&folder) {
        for samples in SAMPLES {
            let expected = film_of(&scene, samples);
            for scale in SCALES {
                let scaled = moved(&scene, scale, |p| p.map(|x| x * scale), |n| n);
                let actual = film_of(&scaled, samples);
                same.see(
                    &format!("{name} × {scale}"),
                    (&scene, samples),
                    &actual,
                    &expected,
                    1.0,
                );
            }
        }
    }
    same.judge();
}

/// Of scenes whose size is about 1, so that 1e6 units are 1e6 times that. Lights just above a
/// surface are left out: 1e-10 is a part of their height.
#[test]
fn place() {
    let folder = tempfile::tempdir().unwrap();
    let mut same = Same::of(Measured::new("place", PLACE));
    let scenes = without(scenes(&folder), &["near lights", "far and tiny", "grazing"]);
    let of_size_1 = scenes.into_iter().filter(|(_, scene)| {
        let view = scene.camera.value.view();
        let way = [0, 1, 2].map(|i| view.eye.value[i] - view.look_at.value[i]);
        let distance = way.iter().map(|x| x * x).sum::<f64>().sqrt();
        (0.1..10.0).contains(&distance)
    });
    let mut compared = 0;
    for (name, scene) in of_size_1 {
        compared += 1;
        for samples in SAMPLES {
            let expected = film_of(&scene, samples);
            for way in [
                [FAR, 0.0, 0.0],
                [0.0, FAR, 0.0],
                [0.0, 0.0, FAR],
                [FAR, -FAR, FAR],
            ] {
                let to = |p: Vector| [0, 1, 2].map(|i| p[i] + way[i]);
                let actual = film_of(&moved(&scene, 1.0, to, |n| n), samples);
                same.see(
                    &format!("{name} at {way:?}"),
                    (&scene, samples),
                    &actual,
                    &expected,
                    1.0,
                );
            }
        }
    }
    assert!(compared >= 5, "{compared}");
    same.judge();
}

#[test]
fn rotation() {
    let folder = tempfile::tempdir().unwrap();
    let mut same = Same::of(Measured::rounding("rotation"));
    // Rz(0.7) Ry(-1.1) Rx(2.3), or any other.
    let [(sx, cx), (sy, cy), (sz, cz)] = [2.3_f64, -1.1, 0.7].map(f64::sin_cos);
    let turn = |[x, y, z]: Vector| {
        let (y, z) = (cx * y - sx * z, sx * y + cx * z);
        let (z, x) = (cy * z - sy * x, sy * z + cy * x);
        let (x, y) = (cz * x - sz * y, sz * x + cz * y);
        [x, y, z]
    };
    let mut compared = 0;
    for (name, scene) in without(scenes(&folder), &["near lights"]) {
        // Angles of a mesh do not simply add.
        if has_mesh(&scene) {
            continue;
        }
        compared += 1;
        for samples in SAMPLES {
            let expected = film_of(&scene, samples);
            let actual = film_of(&moved(&scene, 1.0, turn, turn), samples);
            same.see(&name, (&scene, samples), &actual, &expected, 1.0);
        }
    }
    assert!(compared >= 10, "{compared}");
    same.judge();
}

#[test]
fn order_of_lights() {
    let folder = tempfile::tempdir().unwrap();
    let mut same = Same::of(Measured::rounding("order_of_lights"));
    for (name, scene) in scenes(&folder) {
        let mut reversed = scene.clone();
        reversed.lights.reverse();
        for samples in SAMPLES {
            let (actual, expected) = (film_of(&reversed, samples), film_of(&scene, samples));
            same.see(&name, (&scene, samples), &actual, &expected, 1.0);
        }
    }
    same.judge();
}

/// To the bit: every ray meets the same shapes. Where two are at one place the first counts, so
/// scenes with such are left out.
#[test]
fn order_of_objects() {
    let folder = tempfile::tempdir().unwrap();
    for (name, scene) in without(scenes(&folder), &["contacts"]) {
        let mut reversed = scene.clone();
        reversed.objects.reverse();
        reversed.materials.rotate_left(1);
        for samples in SAMPLES {
            let (actual, expected) = (film_of(&reversed, samples), film_of(&scene, samples));
            assert_eq!(bits(&actual), bits(&expected), "{name}");
        }
    }
}

/// Twice the light is twice the image, to the bit; three times within rounding.
#[test]
fn linear_in_the_light() {
    let folder = tempfile::tempdir().unwrap();
    let mut same = Same::of(Measured::new("linear_in_the_light", TRIPLED));
    for (name, scene) in scenes(&folder) {
        let scene = with_light(&scene, 1.0);
        for samples in SAMPLES {
            let expected = film_of(&scene, samples);
            let doubled: Vec<[u32; 4]> = expected
                .pixels()
                .iter()
                .map(|&[r, g, b, a]| [2.0 * r, 2.0 * g, 2.0 * b, a].map(f32::to_bits))
                .collect();
            assert_eq!(
                bits(&film_of(&with_light(&scene, 2.0), samples)),
                doubled,
                "{name}"
            );
            let tripled = film_of(&with_light(&scene, 3.0), samples);
            same.see(&name, (&scene, samples), &tripled, &expected, 3.0);
        }
    }
    same.judge();
}

/// Whether a reflectance is the smooth one of a color: that of half the color is not its half.
fn has_upsampled_reflectances(scene: &Scene) -> bool {
    let is_spectral = World::new(scene).unwrap().0.spectra().is_some();
    let mut materials = scene.materials.iter();
    is_spectral
        && materials.any(|material| {
            let (Material::Phong(lobes) | Material::NormalizedPhong(lobes)) = &material.value
            else {
                return false;
            };
            [&lobes.diffuse.value, &lobes.specular.value]
                .iter()
                .any(|value| matches!(value, Value::Rgb { .. } | Value::Srgb(_)))
        })
}

/// Half the reflectance is half the light from every surface, to the bit.
#[test]
fn linear_in_the_reflectance() {
    let folder = tempfile::tempdir().unwrap();
    let mut scenes = scenes(&folder);
    scenes.retain(|(_, scene)| !has_upsampled_reflectances(scene));
    assert!(scenes.len() >= 15, "{}", scenes.len());
    for (name, mut scene) in scenes {
        scene.image.background.value = Value::ZERO;
        let with_reflectance = |factor: f64| {
            let mut scene = scene.clone();
            for material in &mut scene.materials {
                let (Material::Phong(lobes) | Material::NormalizedPhong(lobes)) =
                    &mut material.value
                else {
                    continue;
                };
                lobes.diffuse.value = times(&lobes.diffuse.value, factor);
                lobes.specular.value = times(&lobes.specular.value, factor);
            }
            scene
        };
        let (scene, darker) = (with_reflectance(1.0), with_reflectance(0.5));
        for samples in SAMPLES {
            let halved: Vec<[u32; 4]> = film_of(&scene, samples)
                .pixels()
                .iter()
                .map(|&[r, g, b, a]| [0.5 * r, 0.5 * g, 0.5 * b, a].map(f32::to_bits))
                .collect();
            assert_eq!(bits(&film_of(&darker, samples)), halved, "{name}");
        }
    }
}

/// The image under all lights is the sum of the images under each.
#[test]
fn lights_add_up() {
    let folder = tempfile::tempdir().unwrap();
    let mut worst = Measured::new("lights add up", SUM);
    for (name, mut scene) in scenes(&folder) {
        scene.image.background.value = Value::ZERO;
        // Also where the only spectrum is that of a light which is not there.
        scene.image.transport.value = match World::new(&scene).unwrap().0.spectra() {
            Some(_) => Transport::Spectral,
            None => Transport::Rgb,
        };
        for samples in SAMPLES {
            let all = film_of(&scene, samples);
            // Of each channel, and of its magnitude: a light may be negative in one.
            let mut sum = vec![[[0.0_f64; 2]; 3]; all.pixels().len()];
            for light in &scene.lights {
                let mut alone = scene.clone();
                alone.lights = vec![light.clone()];
                for (sum, pixel) in sum.iter_mut().zip(film_of(&alone, samples).pixels()) {
                    for ([sum, magnitude], &channel) in sum.iter_mut().zip(pixel) {
                        *sum += f64::from(channel);
                        *magnitude += f64::from(channel.abs());
                    }
                }
            }
            for (sum, pixel) in sum.iter().zip(all.pixels()) {
                for ([sum, magnitude], &channel) in sum.iter().zip(pixel) {
                    let error = (f64::from(channel) - sum).abs();
                    worst.see(error / magnitude.max(f64::MIN_POSITIVE), || name.clone());
                }
            }
        }
    }
    worst.judge();
}

/// Surfaces have two sides. Turning a plane's normal over turns every sign of its intersection
/// over: the same bits.
#[test]
fn normals_of_planes_turned_over() {
    let folder = tempfile::tempdir().unwrap();
    for (name, scene) in scenes(&folder) {
        let mut turned = scene.clone();
        for object in &mut turned.objects {
            if let Object::Plane { normal, .. } = &mut object.value {
                normal.value = normal.value.map(|component| -component);
            }
        }
        for samples in SAMPLES {
            let (actual, expected) = (film_of(&turned, samples), film_of(&scene, samples));
            assert_eq!(bits(&actual), bits(&expected), "{name}");
        }
    }
}

/// So have triangles, whose corners are then used in another order.
#[test]
fn windings_turned_over() {
    let folder = tempfile::tempdir().unwrap();
    let mut same = Same::of(Measured::rounding("windings_turned_over"));
    let swapped = |triangles: &[[u32; 3]]| -> Vec<[u32; 3]> {
        triangles.iter().map(|&[a, b, c]| [a, c, b]).collect()
    };
    let mut meshes = 0;
    for (name, scene) in scenes(&folder) {
        let mut turned = scene.clone();
        for object in &mut turned.objects {
            match &mut object.value {
                Object::Triangle { vertices, .. } => vertices.value.swap(1, 2),
                Object::Mesh { geometry, .. } => {
                    meshes += 1;
                    let mesh = Arc::make_mut(geometry);
                    if let Some(normals) = &mut mesh.normals {
                        let corners = normals.triangles.as_ref().unwrap_or(&mesh.triangles);
                        normals.triangles = Some(swapped(corners));
                    }
                    mesh.triangles = swapped(&mesh.triangles);
                }
                Object::Sphere { .. } | Object::Plane { .. } => {}
            }
        }
        for samples in SAMPLES {
            let (actual, expected) = (film_of(&turned, samples), film_of(&scene, samples));
            same.see(&name, (&scene, samples), &actual, &expected, 1.0);
        }
    }
    assert!(meshes >= 5, "{meshes}");
    same.judge();
}

/// A tree only leaves out what is not hit: with shapes added where no ray comes, below a floor
/// that is below everything, so that lists become trees, the image stays to the bit.
#[test]
fn trees_and_lists() {
    const HIDDEN: usize = 70;
    let folder = tempfile::tempdir().unwrap();
    let mut compared = 0;
    let lecture = ("lecture".to_owned(), at_width(Scene::builtin(), 64));
    let mut scenes = generate::scenes(folder.path());
    scenes.truncate(100);
    scenes.retain(|(name, _)| name.contains("still life"));
    for (name, scene) in scenes.into_iter().chain([lecture]) {
        let mut with_hidden = scene.clone();
        for object in &scene.objects {
            let copies = (1..=HIDDEN).filter_map(|number| {
                let mut copy = object.clone();
                copy.name = format!("hidden {number} of {}", object.name);
                let down = |p: &mut Vector| {
                    for (axis, component) in p.iter_mut().enumerate() {
                        let size = size_of(&scene);
                        let far = if axis == 1 {
                            100.0
                        } else {
                            3.0 * number as f64
                        };
                        *component -= far * size;
                    }
                };
                match &mut copy.value {
                    Object::Sphere { center, .. } => down(&mut center.value),
                    Object::Triangle { vertices, .. } => vertices.value.iter_mut().for_each(down),
                    Object::Plane { .. } | Object::Mesh { .. } => return None,
                }
                Some(copy)
            });
            with_hidden.objects.extend(copies);
        }
        let plan = |scene: &Scene| {
            let plan = Plan::new(&World::new(scene).unwrap().0);
            [plan.spheres(), plan.triangles()]
        };
        for (before, with_hidden) in plan(&scene).into_iter().zip(plan(&with_hidden)) {
            if before == Acceleration::List {
                assert_eq!(with_hidden, Acceleration::Tree);
                compared += 1;
            }
        }
        for samples in SAMPLES {
            let (actual, expected) = (film_of(&with_hidden, samples), film_of(&scene, samples));
            assert_eq!(bits(&actual), bits(&expected), "{name}");
        }
    }
    // Spheres in all of them, triangles in some.
    assert!(compared >= 15, "{compared}");
}

/// About how far things of a scene are from each other.
fn size_of(scene: &Scene) -> f64 {
    let view = scene.camera.value.view();
    let way = [0, 1, 2].map(|i| view.eye.value[i] - view.look_at.value[i]);
    way.iter().map(|x| x.abs()).fold(0.0, f64::max)
}

/// The same image twice: nothing depends on time, addresses or what ran before.
#[test]
fn twice_is_the_same() {
    for path in scene_files() {
        let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
        let scene = at_width(scene, 64);
        assert_eq!(bits(&film_of(&scene, 4)), bits(&film_of(&scene, 4)));
    }
}
