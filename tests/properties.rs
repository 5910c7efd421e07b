//! Properties of random scenes and random files, by `proptest`: a case that fails is made as small as it goes and printed.
//!
//! `CANDELA_PROPERTIES` says how many cases each property has instead of the default. Cases are the same in every run.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use candela::exr::{ExrOptions, ExrReader};
use candela::image::{Film, Window};
use candela::mesh::MeshError;
use candela::oracle::Oracle;
use candela::output::Unfinished;
use candela::scene::{Diagnostics, MeshFile, Reading};
use candela::world::World;
use candela::{Options, Scene, render};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

use crate::fuzz_scene;
use crate::fuzzing;
use crate::images::{bits, film_of, parse};
use crate::oracle::is_edge;

type Vector = [f64; 3];

/// Cases of a property of pictures, and of files.
const PICTURES: u32 = 32;
const FILES: u32 = 400;

/// Relative error of a pixel that no rounding explains: the promise beside the oracle.
const TOLERANCE: f64 = 1e-5;

/// Below this part of the picture's peak, errors are relative to that.
const FLOOR: f64 = 1e-6;

const RESOLUTION: [u32; 2] = [16, 12];

fn runner(default_cases: u32) -> TestRunner {
    let cases = match std::env::var("CANDELA_PROPERTIES") {
        Ok(cases) => cases
            .parse()
            .expect("CANDELA_PROPERTIES is a number of cases"),
        Err(_) => default_cases,
    };
    let config = Config {
        cases,
        failure_persistence: None,
        ..Config::default()
    };
    TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha))
}

#[track_caller]
fn holds<S: Strategy>(cases: u32, strategy: &S, property: impl Fn(S::Value) -> Verdict) {
    if let Err(failure) = runner(cases).run(strategy, property) {
        panic!("{failure}");
    }
}

type Verdict = Result<(), TestCaseError>;

/// A scene in numbers, so that it can be changed and made smaller.
#[derive(Clone, Debug)]
struct Draft {
    eye: Vector,
    is_perspective: bool,
    /// Height of an orthographic view, and about that of a perspective one.
    height: f64,
    up: Vector,
    look_at: Vector,
    materials: Vec<Surface>,
    lights: Vec<(Vector, Vector)>,
    spheres: Vec<(Vector, f64)>,
    planes: Vec<(Vector, Vector)>,
    triangles: Vec<[Vector; 3]>,
    /// Objects from the last to the first.
    is_reversed: bool,
}

#[derive(Clone, Debug)]
struct Surface {
    diffuse: Vector,
    specular: f64,
    shininess: f64,
}

fn point(half: f64) -> impl Strategy<Value = Vector> + Clone {
    let axis = -half..half;
    (axis.clone(), axis.clone(), axis).prop_map(|(x, y, z)| [x, y, z])
}

fn surface() -> impl Strategy<Value = Surface> {
    let color = (0.05..1.0, 0.05..1.0, 0.05..1.0);
    (color, 0.0..1.0, 0.5..200.0).prop_map(|((r, g, b), specular, shininess)| Surface {
        diffuse: [r, g, b],
        specular,
        shininess,
    })
}

/// Spheres and triangles within 1 or 2 of the origin, lights within 4, a floor or none.
fn draft() -> impl Strategy<Value = Draft> {
    let camera = (point(1.0), any::<bool>(), 2.0..5.0);
    let floor = (point(0.3), -2.0..-0.5).prop_map(|([x, _, z], height)| {
        // Nearly level, below.
        ([0.0, height, 0.0], [x, 1.0, z])
    });
    let bulb = (point(4.0), point(15.0)).prop_map(|(at, color)| (at, color.map(|c| 16.0 + c)));
    let shapes = (
        vec((point(1.2), 0.1..0.8), 0..4),
        vec(floor, 0..2),
        vec([point(1.5), point(1.5), point(1.5)], 0..4),
    );
    (camera, vec(surface(), 3), vec(bulb, 1..5), shapes).prop_filter_map(
        "something to see, triangles with an area",
        |((eye, is_perspective, height), materials, lights, (spheres, planes, triangles))| {
            let is_seen = spheres.len() + planes.len() + triangles.len() > 0;
            let has_area = triangles.iter().all(|&[a, b, c]| {
                let normal = cross(minus(b, a), minus(c, a));
                dot(normal, normal) > 1e-2
            });
            (is_seen && has_area).then(|| Draft {
                eye: [eye[0], 1.5 + eye[1], 6.0],
                is_perspective,
                height,
                up: [0.1 * eye[2], 1.0, 0.0],
                look_at: [0.0; 3],
                materials,
                lights,
                spheres,
                planes,
                triangles,
                is_reversed: false,
            })
        },
    )
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

impl Draft {
    fn scene(&self) -> Scene {
        let [width, height] = RESOLUTION;
        let mut text = format!("[image]\nresolution = [{width}, {height}]\n");
        let (kind, size) = if self.is_perspective {
            let angle = 2.0 * (self.height / 12.0).atan().to_degrees();
            ("perspective", format!("vertical_fov = {angle:?}"))
        } else {
            ("orthographic", format!("height = {:?}", self.height))
        };
        let Self {
            eye, look_at, up, ..
        } = self;
        let _ = writeln!(
            text,
            "[camera.{kind}]\neye = {eye:?}\nlook_at = {look_at:?}\nup = {up:?}\n{size}"
        );
        for (number, surface) in self.materials.iter().enumerate() {
            let Surface {
                diffuse,
                specular,
                shininess,
            } = surface;
            let _ = writeln!(
                text,
                "[materials.m{number}.phong]\ndiffuse = {diffuse:?}\nspecular = {specular:?}\n\
                 shininess = {shininess:?}"
            );
        }
        for (number, (at, color)) in self.lights.iter().enumerate() {
            let _ = writeln!(
                text,
                "[lights.l{number}.point]\nposition = {at:?}\nintensity = {color:?}"
            );
        }
        let spheres = self.spheres.iter().map(|(center, radius)| {
            let keys = format!("center = {center:?}\nradius = {radius:?}");
            ("sphere", 0, keys)
        });
        let planes = self.planes.iter().map(|(at, normal)| {
            let keys = format!("point = {at:?}\nnormal = {normal:?}");
            ("plane", 1, keys)
        });
        let triangles = self
            .triangles
            .iter()
            .map(|vertices| ("triangle", 2, format!("vertices = {vertices:?}")));
        let mut objects: Vec<_> = spheres.chain(planes).chain(triangles).collect();
        if self.is_reversed {
            objects.reverse();
        }
        for (number, (kind, material, keys)) in objects.iter().enumerate() {
            let _ = writeln!(
                text,
                "[objects.o{number}.{kind}]\nmaterial = \"m{material}\"\n{keys}"
            );
        }
        parse(&text)
    }

    /// All lengths times `scale`; positions by `place`, directions by `turn`.
    fn moved(
        &self,
        scale: f64,
        place: impl Fn(Vector) -> Vector,
        turn: impl Fn(Vector) -> Vector,
    ) -> Self {
        let mut moved = self.clone();
        moved.eye = place(self.eye);
        moved.look_at = place(self.look_at);
        moved.up = turn(self.up);
        // An angle stays as it is.
        if !self.is_perspective {
            moved.height *= scale;
        }
        for (at, _) in &mut moved.lights {
            *at = place(*at);
        }
        for (center, radius) in &mut moved.spheres {
            *center = place(*center);
            *radius *= scale;
        }
        for (at, normal) in &mut moved.planes {
            *at = place(*at);
            *normal = turn(*normal);
        }
        for vertices in &mut moved.triangles {
            *vertices = vertices.map(&place);
        }
        moved
    }

    fn film(&self) -> Film {
        film_of(&self.scene(), 1)
    }

    /// What a change has made of the picture: this one times a factor, but for rounding; off an edge at every pixel.
    fn assert_becomes(&self, changed: &Self, times: f64) -> Verdict {
        let scene = self.scene();
        let (before, after) = (self.film(), changed.film());
        let brightest = |pixel: &[f32; 4]| {
            pixel[..3]
                .iter()
                .fold(0.0, |most, &c| f64::max(most, c.into()))
        };
        let peak = before.pixels().iter().map(brightest).fold(0.0, f64::max);
        for (index, (a, b)) in after.pixels().iter().zip(before.pixels()).enumerate() {
            let scale = times * brightest(b).max(FLOOR * peak);
            let is_same = a[3] == b[3]
                && (0..3).all(|i| {
                    let difference = f64::from(a[i]) - times * f64::from(b[i]);
                    difference.abs() <= TOLERANCE * scale
                });
            if !is_same {
                let width = RESOLUTION[0] as usize;
                let pixel = [index % width, index / width];
                prop_assert!(
                    is_edge(&Oracle::new(&scene), &scene, pixel),
                    "pixel {pixel:?}: {a:?}, before {b:?}, times {times}"
                );
            }
        }
        Ok(())
    }
}

/// The comparison can fail: of a picture that is a thousandth brighter, and of one that is not that scene's.
#[test]
fn a_wrong_picture_is_found() {
    let mut runner = runner(1);
    let mut found = 0;
    for _ in 0..20 {
        let draft = draft().new_tree(&mut runner).unwrap().current();
        let is_lit = draft.film().pixels().iter().any(|pixel| pixel[1] > 0.0);
        let mut darker = draft.clone();
        darker.lights.pop();
        if is_lit {
            assert!(draft.assert_becomes(&draft, 1.001).is_err());
            found += usize::from(draft.assert_becomes(&darker, 1.0).is_err());
        }
    }
    assert!(found > 5, "{found}");
}

/// All lengths times s: every light is 1/s² as strong.
#[test]
fn size_is_the_inverse_square() {
    holds(
        PICTURES,
        &(draft(), -4.0..4.0),
        |(draft, decades): (Draft, f64)| {
            let s = 10_f64.powf(decades);
            let scaled = draft.moved(s, |p| p.map(|x| x * s), |n| n);
            draft.assert_becomes(&scaled, 1.0 / (s * s))
        },
    );
}

#[test]
fn place_and_direction_do_not_count() {
    let strategy = (draft(), point(100.0), [-3.0..3.0, -3.0..3.0, -3.0..3.0]);
    holds(
        PICTURES,
        &strategy,
        |(draft, way, angles): (_, _, [f64; 3])| {
            let [(sx, cx), (sy, cy), (sz, cz)] = angles.map(f64::sin_cos);
            let turn = |[x, y, z]: Vector| {
                let (y, z) = (cx * y - sx * z, sx * y + cx * z);
                let (z, x) = (cy * z - sy * x, sy * z + cy * x);
                let (x, y) = (cz * x - sz * y, sz * x + cz * y);
                [x, y, z]
            };
            let place = |p: Vector| {
                let p = turn(p);
                [0, 1, 2].map(|i| p[i] + way[i])
            };
            let moved = draft.moved(1.0, place, turn);
            draft.assert_becomes(&moved, 1.0)
        },
    );
}

/// Two lights at one place are one of their sum.
#[test]
fn lights_can_be_split() {
    holds(
        PICTURES,
        &(draft(), 0.01..0.99),
        |(draft, share): (Draft, f64)| {
            let mut split = draft.clone();
            split.lights = (draft.lights.iter())
                .flat_map(|&(at, color)| {
                    [share, 1.0 - share].map(|part| (at, color.map(|c| c * part)))
                })
                .collect();
            draft.assert_becomes(&split, 1.0)
        },
    );
}

#[test]
fn order_does_not_count() {
    holds(PICTURES, &draft(), |draft| {
        let mut reversed = draft.clone();
        reversed.is_reversed = true;
        prop_assert_eq!(bits(&reversed.film()), bits(&draft.film()));
        reversed.lights.reverse();
        draft.assert_becomes(&reversed, 1.0)
    });
}

/// L9 is linear in every intensity and in every reflectance.
#[test]
fn linear_in_light_and_reflectance() {
    let strategy = (draft(), -6.0..6.0, 0.01..1.0);
    holds(
        PICTURES,
        &strategy,
        |(draft, decades, k): (Draft, f64, f64)| {
            let i = 10_f64.powf(decades);
            let mut changed = draft.clone();
            for (_, color) in &mut changed.lights {
                *color = color.map(|c| c * i);
            }
            for surface in &mut changed.materials {
                surface.diffuse = surface.diffuse.map(|c| c * k);
                surface.specular *= k;
            }
            draft.assert_becomes(&changed, i * k)
        },
    );
}

/// A part of the picture is that of the whole to the bit, on any number of threads.
#[test]
fn windows_and_threads_do_not_count() {
    let [width, height] = RESOLUTION;
    let corner = (0..width, 0..height);
    let strategy = (draft(), corner.clone(), corner, 1_usize..9, 1_u32..9);
    holds(PICTURES, &strategy, |(draft, a, b, threads, samples)| {
        let scene = draft.scene();
        let whole = film_of(&scene, samples);
        let (x, y) = (a.0.min(b.0), a.1.min(b.1));
        let window = Window {
            x,
            y,
            width: a.0.max(b.0) - x + 1,
            height: a.1.max(b.1) - y + 1,
        };
        let options = Options {
            samples,
            window: Some(window),
            ..Options::default()
        };
        let (world, camera) = World::new(&scene).unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        let part = pool.install(|| render(&world, &camera, &options).unwrap());
        let whole = bits(&whole);
        let rows = (y..y + window.height).map(|row| (row * width + x) as usize);
        let cut: Vec<_> = rows
            .flat_map(|start| &whole[start..start + window.width as usize])
            .copied()
            .collect();
        prop_assert_eq!(bits(&part), cut);
        Ok(())
    });
}

/// One change of a file.
#[derive(Clone, Debug)]
enum Change {
    Flip(Index, u8),
    Put(Index, u8),
    Insert(Index, Vec<u8>),
    Remove(Index, Index),
    Repeat(Index, Index, usize),
    Cut(Index),
}

fn change() -> impl Strategy<Value = Change> {
    let place = any::<Index>;
    let special = proptest::sample::select(&b"\0\n\r\t -+.eE/\\#\"'=,;[]{}09\x7f\x80\xff"[..]);
    prop_oneof![
        4 => (place(), 0_u8..8).prop_map(|(at, bit)| Change::Flip(at, bit)),
        4 => (place(), special).prop_map(|(at, byte)| Change::Put(at, byte)),
        2 => (place(), vec(any::<u8>(), 1..12)).prop_map(|(at, new)| Change::Insert(at, new)),
        2 => (place(), place()).prop_map(|(a, b)| Change::Remove(a, b)),
        2 => (place(), place(), 1_usize..40).prop_map(|(a, b, n)| Change::Repeat(a, b, n)),
        1 => place().prop_map(Change::Cut),
    ]
}

impl Change {
    fn apply(&self, bytes: &mut Vec<u8>) {
        if bytes.is_empty() {
            return;
        }
        let length = bytes.len();
        let range = |a: &Index, b: &Index| {
            let (a, b) = (a.index(length), b.index(length));
            a.min(b)..a.max(b) + 1
        };
        match self {
            Self::Flip(at, bit) => bytes[at.index(length)] ^= 1 << bit,
            Self::Put(at, byte) => bytes[at.index(length)] = *byte,
            Self::Insert(at, new) => {
                let at = at.index(length);
                bytes.splice(at..at, new.iter().copied());
            }
            Self::Remove(a, b) => {
                bytes.drain(range(a, b));
            }
            Self::Repeat(a, b, times) => {
                let range = range(a, b);
                let again = bytes[range.clone()].repeat(*times);
                bytes.splice(range.end..range.end, again);
                bytes.truncate(100_000);
            }
            Self::Cut(at) => bytes.truncate(at.index(length)),
        }
    }
}

/// Damaged files of a corpus are read, or refused with a message; nothing panics, hangs, or takes memory on the file's
/// word.
fn survives<T, E: std::fmt::Debug + ToString>(
    corpus: &[Vec<u8>],
    read: impl Fn(&[u8]) -> Result<T, E>,
) {
    let strategy = (any::<Index>(), vec(change(), 1..6));
    holds(FILES, &strategy, |(file, changes): (Index, Vec<Change>)| {
        let mut bytes = file.get(corpus).clone();
        for change in &changes {
            change.apply(&mut bytes);
        }
        let checked = fuzzing::check(&bytes, &read);
        prop_assert!(checked.is_ok(), "{checked:?}:\n{}", bytes.escape_ascii());
        Ok(())
    });
}

#[test]
fn damaged_scenes() {
    let read = |bytes: &[u8]| -> Result<World, Diagnostics> {
        let text = String::from_utf8_lossy(bytes).into_owned();
        let path = Path::new("tests/bad_scenes/damaged.toml");
        let scene = Reading::of_text(text, path).complete()?;
        World::new(&scene).map(|(world, _)| world)
    };
    survives(&fuzz_scene::legal(), read);
}

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\nproperty float nx\nproperty float ny\nproperty float nz\nelement face 2\n\
    property list uchar int vertex_indices\nend_header\n0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n\
    0 1 0 0.1 0 1\n3 0 1 2\n4 0 1 2 3\n";

/// [`PLY`] with vertices without normals, in binary.
fn binary_ply() -> Vec<u8> {
    let mut bytes = b"ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\n\
        property double y\nproperty float z\nelement face 2\n\
        property list uchar int vertex_indices\nend_header\n"
        .to_vec();
    for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
        bytes.extend(f32::to_le_bytes(x));
        bytes.extend(f64::from(y).to_le_bytes());
        bytes.extend(0_f32.to_le_bytes());
    }
    for face in [&[0, 1, 2][..], &[0, 1, 2, 3]] {
        bytes.push(face.len() as u8);
        bytes.extend(face.iter().flat_map(|index: &i32| index.to_le_bytes()));
    }
    bytes
}

#[test]
fn damaged_meshes() {
    let folder = Path::new("reference/conformance");
    let obj = |name| fs::read(folder.join(name)).unwrap();
    let corpus = [
        PLY.as_bytes().to_vec(),
        binary_ply(),
        obj("pillow.obj"),
        obj("pyramid.obj"),
    ];
    survives(&corpus, |bytes| -> Result<MeshFile, MeshError> {
        MeshFile::parse(bytes, Path::new("damaged.obj"))
    });
}

/// EXRs of several compressions, of a scene with silhouettes.
#[test]
fn damaged_exrs() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("whole.exr");
    let scene = Scene::load("reference/conformance/background.toml").unwrap();
    let film = film_of(&scene, 4);
    let mut corpus = vec![fs::read("reference/conformance/background.exr").unwrap()];
    film.write_exr(&path, &ExrOptions::default(), &Unfinished::new())
        .unwrap();
    corpus.push(fs::read(&path).unwrap());
    survives(&corpus, |mut bytes| {
        let reader = ExrReader::from_stream(Path::new("damaged.exr"), &mut bytes, None)?;
        reader.check_resolution()?;
        let bands: Vec<_> = reader.bands().collect();
        for band in bands {
            reader.new_rows(band)?;
        }
        Ok::<_, candela::exr::ExrError>(())
    });
}

/// A curve file, read by way of a scene that names it.
#[test]
fn damaged_curves() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("curve.csv");
    let text = "[image]\nresolution = [1, 1]\n[camera.orthographic]\neye = [0, 0, 1]\nlook_at = [0, 0, 0]\n\
        height = 1\n[materials.m.phong]\ndiffuse = { file = \"curve.csv\" }\n\
        [objects.o.sphere]\nmaterial = \"m\"\ncenter = [0, 0, 0]\nradius = 1\n";
    let corpus = [
        b"# paint\nnm,value\n400,0.1\n450.5,0.25\n550,0.9\n700,1e-1\n".to_vec(),
        b"wavelength value // a lamp\r\n380\t0.5\r\n500\t1\r\n780\t0.25\r\n".to_vec(),
        b"300;0\n830;1\n".to_vec(),
    ];
    survives(&corpus, |bytes| {
        fs::write(&path, bytes).unwrap();
        let scene = Scene::parse(text, folder.path().join("scene.toml"))?;
        World::new(&scene).map(|(world, _)| world)
    });
}
