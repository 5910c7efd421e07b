//! Random legal scenes, the same in every run: all shapes, both cameras, both materials, light and
//! color in every notation, carried as RGB and spectrally, from tiny to huge, with what is hard for a ray tracer put in on purpose.

mod colors;
mod compositions;
mod luminaires;
mod mesh;

use std::f64::consts::TAU;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use candela::scene::Scene;

use colors::Palette;
use mesh::{MeshFormat, Patch};

/// How many kinds of scenes there are.
pub(crate) const KINDS: usize = 10;

/// How many scenes there are, unless `CANDELA_SCENES` says otherwise.
const COUNT: u64 = 200;

/// Width and height of their images.
const RESOLUTION: [u32; 2] = [64, 48];

type Vector = [f64; 3];

/// SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014).
pub(crate) struct Random {
    state: u64,
}

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.state ^ (self.state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From 0 to below 1.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Equally likely in every decade.
    fn log_between(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// From `low` to `high`, both included.
    fn count(&mut self, low: u64, high: u64) -> u64 {
        low + self.next() % (high - low + 1)
    }

    fn choice<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[(self.next() % choices.len() as u64) as usize]
    }

    fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// A point in the cube from −`half` to `half`.
    pub(crate) fn point(&mut self, half: f64) -> Vector {
        [(); 3].map(|()| self.between(-half, half))
    }

    /// A unit vector, uniform over the sphere.
    fn direction(&mut self) -> Vector {
        let z = self.between(-1.0, 1.0);
        let angle = self.between(0.0, TAU);
        let radius = (1.0 - z * z).sqrt();
        [radius * angle.cos(), radius * angle.sin(), z]
    }
}

fn along(from: Vector, direction: Vector, distance: f64) -> Vector {
    std::array::from_fn(|i| from[i] + direction[i] * distance)
}

/// How many scenes there are.
pub(crate) fn count() -> u64 {
    match std::env::var("CANDELA_SCENES") {
        Ok(count) => count.parse().expect("CANDELA_SCENES is a number of scenes"),
        Err(_) => COUNT,
    }
}

/// All scenes with their names; mesh files go to `folder`.
pub(crate) fn scenes(folder: &Path) -> Vec<(String, Scene)> {
    (0..count()).map(|seed| scene(seed, folder)).collect()
}

/// So many scenes of smooth meshes whose shadow rays start off their triangles, beside those of [`scenes`].
pub(crate) fn terminators(count: u64, folder: &Path) -> Vec<(String, Scene)> {
    // Seeds that no other scene has.
    let seeds = (0..count).map(|seed| seed + (1 << 40));
    seeds
        .map(|seed| {
            compose(
                seed,
                "terminators",
                Draft::terminators,
                Bulbs::Points,
                folder,
            )
        })
        .collect()
}

/// So many scenes of all kinds whose lights are mostly spots, beside those of [`scenes`].
pub(crate) fn spots(count: u64, folder: &Path) -> Vec<(String, Scene)> {
    // Seeds that no other scene has.
    let seeds = (0..count).map(|seed| seed + (1 << 41));
    let scenes = seeds.map(|seed| {
        let (kind, composition) = kind(seed);
        compose(
            seed,
            &format!("{kind} under spots"),
            composition,
            Bulbs::Spots,
            folder,
        )
    });
    scenes.collect()
}

/// So many scenes of all kinds under suns and luminaires, beside those of [`scenes`].
pub(crate) fn suns(count: u64, folder: &Path) -> Vec<(String, Scene)> {
    // Seeds that no other scene has.
    let seeds = (0..count).map(|seed| seed + (1 << 42));
    let scenes = seeds.map(|seed| {
        let (kind, composition) = kind(seed);
        compose(
            seed,
            &format!("{kind} under suns and luminaires"),
            composition,
            Bulbs::SunsAndLuminaires,
            folder,
        )
    });
    scenes.collect()
}

/// What the lights of a scene are.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Bulbs {
    Points,
    /// Most of them.
    Spots,
    /// Most of them, with some points.
    SunsAndLuminaires,
}

/// Writes a kind of scene.
type Compose<'f> = fn(&mut Draft<'f>);

/// The scene of a number.
pub(crate) fn scene(seed: u64, folder: &Path) -> (String, Scene) {
    let (kind, composition) = kind(seed);
    compose(seed, kind, composition, Bulbs::Points, folder)
}

fn kind<'f>(seed: u64) -> (&'static str, Compose<'f>) {
    let kinds: [(&str, Compose<'f>); KINDS] = [
        ("still life", Draft::still_life),
        ("crowd", Draft::crowd),
        ("shards", Draft::shards),
        ("torus", Draft::torus),
        ("terrain", Draft::terrain),
        ("contacts", Draft::contacts),
        ("far and tiny", Draft::far_and_tiny),
        ("near lights", Draft::near_lights),
        ("grazing", Draft::grazing),
        ("room", Draft::room),
    ];
    kinds[(seed % KINDS as u64) as usize]
}

fn compose<'f>(
    seed: u64,
    kind: &str,
    composition: Compose<'f>,
    bulbs: Bulbs,
    folder: &'f Path,
) -> (String, Scene) {
    let mut draft = Draft::new(seed, bulbs, folder);
    composition(&mut draft);
    let name = format!("{seed} {kind}");
    let scene = Scene::parse(&draft.text, folder.join("generated.toml"))
        .unwrap_or_else(|error| panic!("{name}:\n{error}\n{}", draft.text));
    (name, scene)
}

/// A scene file as it is written.
struct Draft<'f> {
    seed: u64,
    random: Random,
    bulbs: Bulbs,
    folder: &'f Path,
    palette: Palette,
    /// Scene units for one unit of the compositions below.
    scale: f64,
    /// Where their origin is, at most this many units from that of the scene.
    origin: Vector,
    far: f64,
    text: String,
    materials: u64,
    lights: u64,
    objects: u64,
    curve_files: u64,
}

impl<'f> Draft<'f> {
    fn new(seed: u64, bulbs: Bulbs, folder: &'f Path) -> Self {
        let mut random = Random::new(seed);
        let scale = random.choice(&[1.0, 1.0, 1.0, 1e-6, 1e-3, 1e3, 1e6]);
        let far = random.choice(&[0.0, 0.0, 0.0, 10.0, 1e3, 1e6, 1e9]);
        let origin = random.point(far * scale);
        let palette = random.choice(&Palette::ALL);
        let [width, height] = RESOLUTION;
        let mut draft = Self {
            seed,
            random,
            bulbs,
            folder,
            palette,
            scale,
            origin,
            far,
            text: format!("[image]\nresolution = [{width}, {height}]\n"),
            materials: 0,
            lights: 0,
            objects: 0,
            curve_files: 0,
        };
        draft.image_colors();
        draft
    }

    fn place(&self, position: Vector) -> Vector {
        along(self.origin, position, self.scale)
    }

    fn camera(&mut self, eye: Vector, look_at: Vector) {
        let distance = along(eye, look_at, -1.0).iter().map(|x| x * x).sum::<f64>();
        let up = loop {
            // Anything that is clearly across the view.
            let up = self.random.direction();
            let view = along(look_at, eye, -1.0);
            let cosine: f64 = up.iter().zip(view).map(|(a, b)| a * b).sum();
            if cosine.abs() < 0.9 * distance.sqrt() {
                break up;
            }
        };
        let up = if self.random.chance(0.5) && (eye[0] - look_at[0]).abs() > 1e-3 {
            [0.0, 1.0, 0.0]
        } else {
            up
        };
        let (eye_text, look_at_text) = (self.place(eye), self.place(look_at));
        let view = format!("eye = {eye_text:?}\nlook_at = {look_at_text:?}\nup = {up:?}\n");
        if self.random.chance(0.7) {
            let fov = self.random.between(20.0, 90.0);
            self.perspective(&view, fov);
        } else {
            let height = distance.sqrt() * self.random.between(0.3, 1.2);
            self.orthographic(&view, height);
        }
    }

    fn perspective(&mut self, view: &str, fov: f64) {
        let _ = write!(
            self.text,
            "[camera.perspective]\n{view}vertical_fov = {fov:?}\n\n"
        );
    }

    fn orthographic(&mut self, view: &str, height: f64) {
        let height = height * self.scale;
        let _ = write!(
            self.text,
            "[camera.orthographic]\n{view}height = {height:?}\n\n"
        );
    }

    /// A new material of either model, with or without a specular lobe.
    fn material(&mut self) -> String {
        let name = format!("m{}", self.materials);
        self.materials += 1;
        let model = self.random.choice(&["phong", "normalized_phong"]);
        let specular = self.random.chance(0.7);
        // Together at most 1, where the model has them be.
        let is_phong = model == "phong";
        let diffuse = self.reflectance(if specular && !is_phong { 0.5 } else { 1.0 });
        let _ = write!(
            self.text,
            "[materials.{name}.{model}]\ndiffuse = {diffuse}\n"
        );
        if specular {
            let specular = if is_phong {
                self.highlight()
            } else {
                self.reflectance(0.5)
            };
            let shininess = self.random.log_between(0.5, 5000.0);
            let _ = write!(
                self.text,
                "specular = {specular}\nshininess = {shininess:?}\n"
            );
        }
        self.text.push('\n');
        name
    }

    fn light(&mut self, position: Vector) {
        let position = self.place(position);
        // Bright enough for the distances of the compositions, at any scale.
        let strength = self.random.log_between(1.0, 100.0) * self.scale * self.scale;
        if self.bulbs == Bulbs::SunsAndLuminaires {
            match self.random.count(0, 4) {
                0 => {}
                1 => {
                    self.sun(position);
                    return;
                }
                _ => {
                    self.luminaire(position, strength);
                    return;
                }
            }
        }
        let intensity = self.intensity(strength);
        let (kind, cone) = if self.bulbs == Bulbs::Spots && self.random.chance(0.8) {
            ("spot", self.cone(position))
        } else {
            ("point", String::new())
        };
        let _ = write!(
            self.text,
            "[lights.l{}.{kind}]\nposition = {position:?}\nintensity = {intensity}\n{cone}\n",
            self.lights
        );
        self.lights += 1;
    }

    /// Where a spot points, mostly to about the middle, and its angles.
    fn cone(&mut self, position: Vector) -> String {
        let target = self.random.point(1.5);
        let target = self.place(target);
        let aim = match self.random.count(0, 4) {
            0 => format!("direction = {:?}", self.random.direction()),
            1 => format!("direction = {:?}", along(target, position, -1.0)),
            _ => format!("look_at = {target:?}"),
        };
        let outer = match self.random.count(0, 4) {
            0 => 90.0,
            1 => self.random.log_between(0.5, 5.0),
            _ => self.random.between(5.0, 75.0),
        };
        let inner = match self.random.count(0, 4) {
            0 => String::new(),
            1 => format!("inner = {outer:?}\n"),
            _ => format!("inner = {:?}\n", outer * self.random.unit()),
        };
        let falloff = match self.random.count(0, 3) {
            0 => "",
            1 => "falloff = \"smooth\"\n",
            2 => "falloff = \"gltf\"\n",
            _ => "falloff = \"linear_angle\"\n",
        };
        format!("{aim}\nouter = {outer:?}\n{inner}{falloff}")
    }

    /// Lights around the origin, at a distance of a few units.
    fn lights(&mut self, low: u64, high: u64) {
        for _ in 0..self.random.count(low, high) {
            let direction = self.random.direction();
            let distance = self.random.between(2.0, 8.0);
            self.light(along([0.0; 3], direction, distance));
        }
    }

    /// Lights on the side of +y.
    fn lights_above(&mut self, low: u64, high: u64) {
        for _ in 0..self.random.count(low, high) {
            let [x, y, z] = self.random.direction();
            let distance = self.random.between(2.0, 8.0);
            self.light(along([0.0; 3], [x, y.abs() + 0.1, z], distance));
        }
    }

    /// A unit vector less than 60 degrees from another, for walls that face the viewer.
    fn towards(&mut self, direction: Vector) -> Vector {
        loop {
            let found = self.random.direction();
            let cosine: f64 = found.iter().zip(direction).map(|(a, b)| a * b).sum();
            if cosine > 0.5 {
                return found;
            }
        }
    }

    fn object(&mut self, shape: &str, material: &str, keys: &str) {
        let _ = write!(
            self.text,
            "[objects.o{}.{shape}]\nmaterial = \"{material}\"\n{keys}\n",
            self.objects
        );
        self.objects += 1;
    }

    fn sphere(&mut self, material: &str, center: Vector, radius: f64) {
        let (center, radius) = (self.place(center), radius * self.scale);
        let keys = format!("center = {center:?}\nradius = {radius:?}\n");
        self.object("sphere", material, &keys);
    }

    fn plane(&mut self, material: &str, point: Vector, normal: Vector) {
        let point = self.place(point);
        let keys = format!("point = {point:?}\nnormal = {normal:?}\n");
        self.object("plane", material, &keys);
    }

    fn triangle(&mut self, material: &str, vertices: [Vector; 3]) {
        let vertices = vertices.map(|vertex| self.place(vertex));
        self.object("triangle", material, &format!("vertices = {vertices:?}\n"));
    }

    /// A mesh file and an object of it, moved to `center`.
    fn mesh(&mut self, material: &str, center: Vector, patch: &Patch<'_>) {
        let smooth = self.random.chance(0.6);
        let format = self
            .random
            .choice(&[MeshFormat::Ply, MeshFormat::BinaryPly, MeshFormat::Obj]);
        let file = format!("mesh-{}-{}.{}", self.seed, self.objects, format.extension());
        fs::write(self.folder.join(&file), format.write(patch, smooth)).unwrap();
        let stretch = self.random.between(0.5, 1.5);
        let scale = match self.random.count(0, 2) {
            0 => format!("{:?}", self.scale * stretch),
            1 => format!(
                "{:?}",
                [stretch, 1.0, 0.7].map(|factor| factor * self.scale)
            ),
            // Mirrored: the winding turns over.
            _ => format!(
                "{:?}",
                [-stretch, 1.2, 0.9].map(|factor| factor * self.scale)
            ),
        };
        let rotate = self.random.point(180.0);
        let center = self.place(center);
        // Of numbers apart, so that the scenes are the same but for this.
        let terminator = match Random::new(!(self.seed << 8 | self.objects)).count(0, 3) {
            0 => "",
            1 => "shadow_terminator = \"geometric\"\n",
            _ => "shadow_terminator = \"hanika\"\n",
        };
        let keys = format!(
            "file = \"{file}\"\nscale = {scale}\nrotate = {rotate:?}\ntranslate = {center:?}\n\
             smooth = {smooth}\n{terminator}"
        );
        self.object("mesh", material, &keys);
    }
}

#[test]
fn scenes_are_legal_and_cover_the_format() {
    let folder = tempfile::tempdir().unwrap();
    let texts: Vec<String> = scenes(folder.path())
        .iter()
        .map(|(name, scene)| {
            if let Err(error) = candela::world::World::new(scene) {
                panic!("{name}:\n{error}");
            }
            scene.source.text.clone()
        })
        .collect();
    for part in [
        ".sphere]",
        ".plane]",
        ".triangle]",
        ".mesh]",
        ".ply\"",
        ".obj\"",
        "smooth = true",
        "smooth = false",
        "shadow_terminator = \"geometric\"",
        "shadow_terminator = \"hanika\"",
        "[camera.perspective]",
        "[camera.orthographic]",
        ".phong]",
        ".normalized_phong]",
        "rgb = ",
        "\"#",
        "color_space = \"rec709\"",
        "color_space = \"p3-d65\"",
        "color_space = \"rec2020\"",
        "color_space = \"acescg\"",
        "space = \"p3-d65\" }",
        "space = \"rec2020\" }",
        "space = \"acescg\" }",
        "observer = \"1931\"",
        "observer = \"1964\"",
        "transport = \"rgb\"",
        "transport = \"spectral\"",
        "background = { lines",
        "background = { rgb",
        "background = { wavelengths",
        "background = { file",
        "diffuse = { wavelengths",
        "diffuse = { file",
        "specular = { wavelengths",
        "intensity = { rgb",
        "intensity = { wavelengths",
        "intensity = { file",
        "intensity = { lines",
        "{ candela = ",
        "{ lumens = ",
        "{ watts = ",
        "{ watts_per_steradian = ",
        "{ watts_per_steradian_nm = ",
        "{ illuminant = ",
        "{ daylight = ",
        "{ blackbody = ",
    ] {
        let count = texts.iter().filter(|text| text.contains(part)).count();
        assert!(count >= 5, "{part} is in {count} scenes");
    }
    let lights = |text: &String| text.matches("[lights.").count();
    assert!(texts.iter().any(|text| lights(text) == 0));
    assert!(texts.iter().any(|text| lights(text) == 8));
}

/// All scenes are legal, and each of these parts is in three of them or more.
fn are_legal_with(scenes: &[(String, Scene)], parts: &[&str]) {
    for (name, scene) in scenes {
        if let Err(error) = candela::world::World::new(scene) {
            panic!("{name}:\n{error}");
        }
    }
    for part in parts {
        let has = |(_, scene): &&(String, Scene)| scene.source.text.contains(part);
        let count = scenes.iter().filter(has).count();
        assert!(count >= 3, "{part} is in {count} scenes");
    }
}

#[test]
fn suns_and_luminaires_are_legal_and_cover_the_format() {
    let folder = tempfile::tempdir().unwrap();
    let parts = [
        ".sun]",
        ".ies]",
        ".point]",
        "lux = ",
        "\nup = ",
        "\nscale = ",
        "{ lumens = ",
        "direction = [0, -1, 0]",
        "transport = \"spectral\"",
    ];
    are_legal_with(&suns(40, folder.path()), &parts);
}

#[test]
fn spots_are_legal_and_cover_the_format() {
    let folder = tempfile::tempdir().unwrap();
    let parts = [
        ".spot]",
        ".point]",
        "\nlook_at = ",
        "\ndirection = ",
        "outer = 90.0",
        "inner = ",
        "falloff = \"smooth\"",
        "falloff = \"gltf\"",
        "falloff = \"linear_angle\"",
        "{ lumens = ",
        "transport = \"spectral\"",
    ];
    are_legal_with(&spots(40, folder.path()), &parts);
}
