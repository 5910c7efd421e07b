//! A legal world, built from a scene as written.

mod area;
mod body;
mod camera;
mod color;
mod delta;
mod light;
mod material;
mod mesh;
mod mixture;
mod range;
mod shapes;
mod shells;

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::DVec3;

pub(super) use camera::place;

use super::chains::Chains;
use super::colorimetry::Colorimetry;
use super::geometry::Triangles;
use super::spectra::{Products, Spectra};
use super::{Delta, Loaded, Named, Object, World};
use crate::camera::Camera;
use crate::math::{Normal, Point};
use crate::memory::{self, OutOfMemory};
use crate::printable::{counted, printable};
use crate::scene::diagnostic::MOST_COLLECTED;
use crate::scene::{
    self, Broken, Diagnostic, Diagnostics, Problem, Reading, Scene, Span, Spanned, Transport, Value,
};
use crate::units::{Radiance, Rgb};

/// The largest coordinate, length and factor. Products of four of them, as the edge functions of
/// triangles have, still fit an f64 with room to spare.
const LARGEST: f64 = 1e30;

/// Builds the world of a whole scene, or says all that is wrong with it.
pub(super) fn world(scene: &Scene) -> Result<(World, Camera), Diagnostics> {
    finished(scene, Builder::run(scene, &Broken::default(), None))
}

/// The same for another frame than a world was made for.
pub(super) fn world_again(
    scene: &Scene,
    change: scene::Change,
    world: &World,
) -> Result<(World, Camera), Diagnostics> {
    let kept = (!change.triangles).then_some(world);
    finished(scene, Builder::run(scene, &Broken::default(), kept))
}

fn finished(
    scene: &Scene,
    (made, diagnostics): (Option<(World, Camera)>, Vec<Diagnostic>),
) -> Result<(World, Camera), Diagnostics> {
    match Diagnostics::new(Arc::clone(&scene.source), diagnostics) {
        Some(diagnostics) => Err(diagnostics),
        None => Ok(made.expect(CAMERA_IS_MADE)),
    }
}

const CAMERA_IS_MADE: &str = "what no diagnostic is about is made";

/// Validates what could be read of a scene; what is wrong with its form is reported as well.
pub(super) fn world_of_reading(reading: Reading) -> Result<Loaded, Diagnostics> {
    let Reading {
        source,
        scene,
        mut diagnostics,
        broken,
        motion,
        frame,
    } = reading;
    let validated = scene.map(|scene| {
        let (made, found) = Builder::run(&scene, &broken, None);
        let moves = motion.as_ref().is_some_and(|it| it.frames().is_some());
        diagnostics.extend(
            found
                .into_iter()
                .map(|found| if moves { found.at_frame(frame) } else { found }),
        );
        (scene, made)
    });
    if let Some(diagnostics) = Diagnostics::new(source, diagnostics) {
        return Err(diagnostics);
    }
    let motion = motion.expect("there is a scene");
    let (scene, made) = validated.expect("a scene that cannot be read has a diagnostic");
    let (world, camera) = made.expect(CAMERA_IS_MADE);
    Ok(Loaded {
        scene,
        world,
        camera,
        motion,
    })
}

/// Values in f64, checked as far as they go; what is wrong with them is in `diagnostics`, and then
/// the result is not used.
struct Builder<'a> {
    scene: &'a Scene,
    /// What stands in the file, but was left out of the scene because of other errors.
    broken: &'a Broken,
    anchor: DVec3,
    diagnostics: Vec<Diagnostic>,
    /// A world whose triangles are all that there are.
    kept: Option<&'a World>,
    /// How many of its meshes are in this world so far.
    kept_meshes: usize,
    /// What errors are about that are found now.
    entry: Option<Entry<'a>>,
    is_out_of_memory: bool,
    /// The materials' places by their names.
    materials: HashMap<&'a str, usize>,
    /// The names of the lights, where any light is in a group.
    light_names: HashSet<&'a str>,
    meshes: mesh::Checked,
    curves: color::Curves,
    colorimetry: Arc<Colorimetry>,
    /// Whether light is carried wavelength by wavelength.
    is_spectral: bool,
    reflectances: color::KnownReflectances,
    spectral_values: Vec<String>,
    gaps: Vec<Named<[f64; 2]>>,
}

/// An entry of a scene as errors name it.
#[derive(Clone, Copy)]
enum Entry<'a> {
    /// `[image]`
    Image,
    /// `[camera.VARIANT]`
    Camera,
    /// "object" and its name.
    Named(&'static str, &'a str),
}

impl Entry<'_> {
    fn described(self) -> String {
        match self {
            Self::Image => "the image".to_owned(),
            Self::Camera => "the camera".to_owned(),
            Self::Named(what, name) => format!("{what} `{}`", printable(name)),
        }
    }
}

/// An empty result of a part that has errors; they are in the diagnostics already.
#[derive(Clone, Copy)]
struct Reported;

impl<'a> Builder<'a> {
    /// Of a whole scene; no camera where it is in error.
    fn run(
        scene: &'a Scene,
        broken: &'a Broken,
        kept: Option<&'a World>,
    ) -> (Option<(World, Camera)>, Vec<Diagnostic>) {
        let look_at = scene.camera.value.view().look_at.value;
        let look_at = DVec3::from_array(scene.anchor.map_or(look_at, |anchor| anchor.look_at));
        let anchor = if look_at.is_finite() {
            look_at
        } else {
            DVec3::ZERO
        };
        let mut builder = Self {
            kept,
            ..Self::new(scene, broken, anchor)
        };
        let camera = builder.camera();
        let world = builder.world();
        let made = camera.ok().map(|camera| (world, camera));
        (made, builder.diagnostics)
    }

    fn new(scene: &'a Scene, broken: &'a Broken, anchor: DVec3) -> Self {
        Self {
            scene,
            broken,
            anchor,
            diagnostics: Vec::new(),
            kept: None,
            kept_meshes: 0,
            entry: None,
            is_out_of_memory: false,
            materials: HashMap::new(),
            light_names: HashSet::new(),
            meshes: mesh::Checked::default(),
            curves: color::Curves::default(),
            colorimetry: Arc::new(Colorimetry::new(
                scene.image.observer.value,
                scene.image.color_space.value,
            )),
            is_spectral: is_spectral(scene),
            reflectances: color::KnownReflectances::default(),
            spectral_values: Vec::new(),
            gaps: Vec::new(),
        }
    }

    fn world(&mut self) -> World {
        self.entry = Some(Entry::Image);
        let max_depth = self.max_depth();
        let background = &self.scene.image.background;
        self.note_spectra([&background.value], || "the background".to_owned());
        let background = self.emission("background", background, color::Spread::EVERYWHERE);
        let mut reflectances = Vec::new();
        let mut materials = Vec::new();
        let mut deltas = Vec::new();
        self.each(
            "material",
            "a material",
            &self.scene.materials,
            |builder, entry| {
                let (material, lobes) = builder.material(entry);
                builder.reserve(&mut deltas, 1)?;
                deltas.push(builder.delta(entry));
                builder.reserve(&mut materials, 1)?;
                materials.push(named(entry, material));
                builder.reserve(&mut reflectances, 1)?;
                reflectances.extend(lobes);
                Ok(())
            },
        );
        let mut spectra = Vec::new();
        let mut lights = Vec::new();
        let mut light_groups = Vec::new();
        let entries = &self.scene.lights;
        if entries.iter().any(|entry| entry.value.group().is_some()) {
            self.light_names
                .extend(entries.iter().map(|entry| entry.name.as_str()));
        }
        self.each("light", "a light", &self.scene.lights, |builder, entry| {
            let (light, spectrum) = builder.light(entry);
            builder.reserve(&mut lights, 1)?;
            lights.push(named(entry, light));
            builder.reserve(&mut light_groups, 1)?;
            light_groups.push(builder.light_group(&entry.value));
            builder.reserve(&mut spectra, 1)?;
            spectra.extend(spectrum);
            Ok(())
        });
        let names = self.scene.materials.iter().map(|entry| entry.name.as_str());
        match memory::reserve_names(&mut self.materials, names.len()) {
            Ok(()) => self.materials.extend(names.zip(0..materials.len())),
            Err(error) => self.out_of_memory(error, ""),
        }
        let mut world = World {
            scene_hash: self.scene.hash().to_string(),
            inputs_hash: self.scene.inputs_hash().to_string(),
            set: self.scene.source.set().map(str::to_owned).collect(),
            color_space: self.scene.image.color_space.value,
            background: Radiance(Rgb(background.rgb)),
            anchor: self.anchor,
            materials,
            has_coats: deltas.iter().flatten().any(Delta::has_lobes),
            deltas,
            has_deltas: false,
            has_panes: false,
            has_dispersion: false,
            bodies: Vec::new(),
            body_ranks: Vec::new(),
            max_depth,
            lights,
            light_groups,
            objects: Vec::new(),
            first_light_object: 0,
            spheres: Vec::new(),
            planes: Vec::new(),
            disks: Vec::new(),
            triangles: self.kept.map_or_else(Arc::<Triangles>::default, |world| {
                Arc::clone(&world.triangles)
            }),
            products: None,
            asked: self.scene.image.transport.value,
            observer: self.scene.image.observer.value,
            spectral_values: std::mem::take(&mut self.spectral_values),
            spectra: None,
            chains: None,
            colorimetry: Arc::clone(&self.colorimetry),
            gaps: std::mem::take(&mut self.gaps),
        };
        self.each(
            "object",
            "an object",
            &self.scene.objects,
            |builder, entry| {
                builder.reserve(&mut world.objects, 1)?;
                let (material, shape) = builder.object(entry, &mut world)?;
                world.objects.push(Object {
                    name: entry.name.clone(),
                    material,
                    shape,
                    emits: None,
                });
                Ok(())
            },
        );
        self.light_objects(&mut world, |builder, world, entry| {
            let (material, lobes) = builder.material(entry);
            builder.reserve(&mut world.materials, 1)?;
            world.materials.push(named(entry, material));
            builder.reserve(&mut world.deltas, 1)?;
            world.deltas.push(None);
            builder.reserve(&mut reflectances, 1)?;
            reflectances.extend(lobes);
            Ok(())
        });
        // Of materials that no object has nothing is needed.
        let objects = world.objects.iter();
        let used = objects.filter_map(|object| world.deltas[object.material].as_ref());
        let (mut has_deltas, mut has_panes, mut disperses) = (false, false, false);
        for delta in used {
            has_deltas = true;
            has_panes |= matches!(delta, Delta::Pane { .. });
            disperses |= matches!(delta, Delta::Glass(glass) if glass.dispersion.is_some());
        }
        (world.has_deltas, world.has_panes) = (has_deltas, has_panes);
        world.has_dispersion = self.is_spectral && disperses;
        // After an error an object may be missing; then the world is dropped.
        if world.has_deltas && self.diagnostics.is_empty() {
            self.bodies(&mut world);
        }
        self.look_for_objects();
        self.check_heights();
        // After an error a spectrum may be missing; then the world is dropped.
        if self.is_spectral && self.diagnostics.is_empty() {
            let materials = world.used_materials();
            let mut used = vec![false; world.materials.len()];
            for &material in &materials {
                used[material] = true;
            }
            let spectra = Spectra {
                colorimetry: Colorimetry::clone(&self.colorimetry),
                lights: spectra,
                materials: reflectances,
                used,
                background: background.spectrum.expect("spectral light has a spectrum"),
            };
            self.products(&spectra, &mut world, materials.len());
            world.spectra = Some(spectra);
        }
        world
    }

    fn max_depth(&mut self) -> u32 {
        let legal = |depth: f64| {
            (0.0..=f64::from(scene::LARGEST_DEPTH)).contains(&depth) && depth.fract() == 0.0
        };
        let written = self.scene.image.max_depth;
        let expected = "a whole number from 0 to 1000";
        let depth = self.number("max_depth", written, legal, expected);
        depth.map_or(scene::DEFAULT_DEPTH, |depth| depth as u32)
    }

    /// A scene has an object.
    fn look_for_objects(&mut self) {
        let hidden = self.broken.lost_entries || !self.broken.objects.is_empty();
        if self.scene.objects.is_empty() && !hidden {
            self.report(
                Span::default(),
                Problem::Missing {
                    what: "section",
                    name: "objects.NAME.VARIANT".to_owned(),
                    expected: "at least one object, such as `[objects.ball.sphere]`",
                },
            );
        }
    }

    /// A place for the products of lights with so many materials.
    fn products(&mut self, spectra: &Spectra, world: &mut World, materials: usize) {
        let products = Products::new(spectra);
        let chains = Chains::new(spectra, &world.deltas, world.max_depth);
        match (products, chains) {
            (Ok(products), Ok(chains)) => {
                world.products = Some(products);
                world.chains = chains;
            }
            (Err(error), _) | (_, Err(error)) => {
                let what = format!(
                    "the products of the spectra of {} and {}",
                    counted(world.lights.len(), "light", "lights"),
                    counted(materials, "material", "materials"),
                );
                let way_out = "; use fewer of them, or `transport = \"rgb\"` in `[image]`, \
                               which takes none";
                self.out_of_memory(error.for_what(what), way_out);
            }
        }
    }

    /// Makes something of each entry of a section, until memory ends. An entry that cannot be made is
    /// an error, after which the world is dropped.
    fn each<T>(
        &mut self,
        what: &'static str,
        an_entry: &'static str,
        entries: &'a [scene::Entry<T>],
        mut make: impl FnMut(&mut Self, &'a scene::Entry<T>) -> Result<(), Reported>,
    ) {
        self.check_names(what, an_entry, entries);
        for entry in entries {
            self.entry = Some(Entry::Named(what, &entry.name));
            if make(self, entry).is_err() && self.is_out_of_memory {
                break;
            }
        }
        self.entry = None;
    }

    /// Makes room for `additional` items.
    fn reserve<T>(&mut self, items: &mut Vec<T>, additional: usize) -> Result<(), Reported> {
        memory::reserve(items, additional).map_err(|error| {
            let Scene {
                materials,
                lights,
                objects,
                ..
            } = self.scene;
            let what = format!(
                "a part of the scene's {}, {} and {}",
                counted(materials.len(), "material", "materials"),
                counted(lights.len(), "light", "lights"),
                counted(objects.len(), "object", "objects"),
            );
            self.out_of_memory(error.for_what(what), "");
            Reported
        })
    }

    /// A scene made in code may have any names; those in a file are good, and there once.
    fn check_names<T>(
        &mut self,
        what: &'static str,
        an_entry: &'static str,
        entries: &'a [scene::Entry<T>],
    ) {
        let mut known: HashMap<&str, Span> = HashMap::new();
        if let Err(error) = memory::reserve_names(&mut known, entries.len()) {
            return self.out_of_memory(error, "");
        }
        for entry in entries {
            if let Some(first) = known.insert(&entry.name, entry.span) {
                self.entry = None;
                let problem = Problem::Duplicate {
                    what,
                    name: entry.name.clone(),
                    first: (first != Span::default()).then_some(first),
                };
                self.report(entry.span, problem);
            } else if let Some(why) = scene::name_objection(&entry.name, what == "light") {
                self.entry = None;
                let problem = Problem::BadName {
                    what: an_entry,
                    name: entry.name.clone(),
                    why,
                };
                self.report(entry.span, problem);
            }
        }
    }

    fn out_of_memory(&mut self, error: OutOfMemory, way_out: &'static str) {
        self.is_out_of_memory = true;
        self.entry = None;
        let problem = Problem::OutOfMemory { error, way_out };
        self.report(Span::default(), problem);
    }

    /// Whether enough errors were found to leave out what only makes more.
    fn has_enough(&self) -> bool {
        self.diagnostics.len() >= MOST_COLLECTED
    }

    fn report(&mut self, span: Span, problem: Problem) {
        // Of more errors than are collected no place is kept, but that the scene is in error is.
        if !self.has_enough() {
            let entry = self.entry.map(Entry::described);
            let diagnostic = Diagnostic::new(span, problem).about(entry);
            self.diagnostics.push(diagnostic);
        }
    }

    fn out_of_range(&mut self, key: &'static str, span: Span, value: String, expected: &str) {
        let expected = expected.to_owned();
        self.report(
            span,
            Problem::OutOfRange {
                key,
                value,
                expected,
            },
        );
    }

    /// A number that fulfills `legal`, or an error that says what is `expected`.
    fn number(
        &mut self,
        key: &'static str,
        written: Spanned<f64>,
        legal: impl Fn(f64) -> bool,
        expected: &str,
    ) -> Result<f64, Reported> {
        let Spanned { value, span } = written;
        if value.is_finite() && legal(value) {
            return Ok(value);
        }
        self.out_of_range(key, span, as_written(value), expected);
        Err(Reported)
    }

    /// Three finite numbers that are not too large to compute with.
    fn vector(&mut self, key: &'static str, written: Spanned<[f64; 3]>) -> Result<DVec3, Reported> {
        let Spanned { value, span } = written;
        if value.iter().all(|coordinate| coordinate.abs() <= LARGEST) {
            return Ok(DVec3::from_array(value));
        }
        self.out_of_range(
            key,
            span,
            listed(&value),
            "three numbers from -1e30 to 1e30",
        );
        Err(Reported)
    }

    /// A position relative to the anchor.
    fn position(
        &mut self,
        key: &'static str,
        written: Spanned<[f64; 3]>,
    ) -> Result<Point, Reported> {
        Ok(Point(self.vector(key, written)? - self.anchor))
    }

    /// A vector with a direction.
    fn direction(
        &mut self,
        key: &'static str,
        written: Spanned<[f64; 3]>,
    ) -> Result<Normal, Reported> {
        let vector = self.vector(key, written)?;
        Normal::new(vector).ok_or_else(|| {
            let value = listed(&written.value);
            self.out_of_range(key, written.span, value, "a direction, so not all zero");
            Reported
        })
    }

    fn length(&mut self, key: &'static str, written: Spanned<f64>) -> Result<f64, Reported> {
        let legal = |length| length > 0.0 && length <= LARGEST;
        self.number(key, written, legal, "a length above 0, in scene units")
    }

    /// Remembers what is spectral of an entry, and which of its curves leave out light.
    fn note_spectra<const N: usize>(&mut self, values: [&Value; N], name: impl Fn() -> String) {
        if values.iter().any(|value| value.is_spectral()) {
            self.spectral_values.push(name());
        }
        for value in values.into_iter().flat_map(Value::parts) {
            let curve = match value {
                Value::Sized { color, .. } => color,
                value => value,
            };
            if let Value::Curve(curve) = curve
                && let Some(range) = curve.gap()
            {
                self.gaps.push(Named {
                    name: name(),
                    value: range,
                });
            }
        }
    }

    /// The colorimetry, if light is carried spectrally.
    fn colorimetry_of_spectra(&self) -> Option<Arc<Colorimetry>> {
        self.is_spectral.then(|| Arc::clone(&self.colorimetry))
    }
}

/// Whether light is carried wavelength by wavelength.
fn is_spectral(scene: &Scene) -> bool {
    match scene.image.transport.value {
        Transport::Rgb => false,
        Transport::Spectral => true,
        Transport::Auto => {
            let mut materials = scene.materials.iter();
            let materials = materials.any(|entry| delta::is_spectral(&entry.value));
            let lights = scene.lights.iter();
            let mut lights = lights.map(|entry| &entry.value.size().value);
            let lights = lights.any(Value::is_spectral);
            materials || lights || scene.image.background.value.is_spectral()
        }
    }
}

fn named<T, U>(entry: &scene::Entry<T>, value: U) -> Named<U> {
    Named {
        name: entry.name.clone(),
        value,
    }
}

/// A number as one would write it, without rows of zeros.
fn as_written(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 || !value.is_finite() || (1e-5..1e15).contains(&magnitude) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

/// Numbers as one would write them in a scene.
fn listed(values: &[f64]) -> String {
    let values: Vec<String> = values.iter().copied().map(as_written).collect();
    format!("[{}]", values.join(", "))
}
