//! Random legal scenes, the same in every run: all shapes, both cameras, both materials, from
//! tiny to huge, with what is hard for a ray tracer put in on purpose.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::fs;
use std::path::Path;

use candela::scene::Scene;

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

/// All scenes with their names; mesh files go to `folder`.
pub(crate) fn scenes(folder: &Path) -> Vec<(String, Scene)> {
    let count = match std::env::var("CANDELA_SCENES") {
        Ok(count) => count.parse().expect("CANDELA_SCENES is a number of scenes"),
        Err(_) => COUNT,
    };
    (0..count).map(|seed| scene(seed, folder)).collect()
}

fn scene<'f>(seed: u64, folder: &'f Path) -> (String, Scene) {
    let kinds: [(&str, fn(&mut Draft<'f>)); 10] = [
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
    let (kind, compose) = kinds[(seed % kinds.len() as u64) as usize];
    let mut draft = Draft::new(seed, folder);
    compose(&mut draft);
    let name = format!("{seed} {kind}");
    let scene = Scene::parse(&draft.text, folder.join("generated.toml"))
        .unwrap_or_else(|error| panic!("{name}:\n{error}\n{}", draft.text));
    (name, scene)
}

/// A scene file as it is written.
struct Draft<'f> {
    seed: u64,
    random: Random,
    folder: &'f Path,
    /// Scene units for one unit of the compositions below.
    scale: f64,
    /// Where their origin is, at most this many units from that of the scene.
    origin: Vector,
    far: f64,
    text: String,
    materials: u64,
    lights: u64,
    objects: u64,
}

/// A surface over a grid of (u, v), each from 0 to 1.
struct Patch<'s> {
    columns: usize,
    rows: usize,
    position: &'s dyn Fn(f64, f64) -> Vector,
}

impl<'f> Draft<'f> {
    fn new(seed: u64, folder: &'f Path) -> Self {
        let mut random = Random::new(seed);
        let scale = random.choice(&[1.0, 1.0, 1.0, 1e-6, 1e-3, 1e3, 1e6]);
        let far = random.choice(&[0.0, 0.0, 0.0, 10.0, 1e3, 1e6]);
        let origin = random.point(far * scale);
        let [width, height] = RESOLUTION;
        let background = random.choice(&["0", "0.25", "[0.1, 0.2, 0.4]", "\"#204060\""]);
        Self {
            seed,
            random,
            folder,
            scale,
            origin,
            far,
            text: format!(
                "[image]\nresolution = [{width}, {height}]\nbackground = {background}\n\n"
            ),
            materials: 0,
            lights: 0,
            objects: 0,
        }
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

    /// A color in one of its notations, at most `most` in every channel.
    fn color(&mut self, most: f64) -> String {
        let random = &mut self.random;
        match random.count(0, 3) {
            0 => format!("{:?}", random.between(0.0, most)),
            1 => format!("{:?}", [(); 3].map(|()| random.between(0.0, most))),
            2 => {
                let rgb = [(); 3].map(|()| random.between(0.0, most));
                format!("{{ rgb = {rgb:?}, space = \"rec709\" }}")
            }
            // sRGB codes are never below the linear value.
            _ => {
                let [r, g, b] = [(); 3].map(|()| (random.between(0.0, most) * 255.0) as u8);
                format!("\"#{r:02x}{g:02x}{b:02x}\"")
            }
        }
    }

    /// A new material of either model, with or without a specular lobe.
    fn material(&mut self) -> String {
        let name = format!("m{}", self.materials);
        self.materials += 1;
        let model = self.random.choice(&["phong", "normalized_phong"]);
        let specular = self.random.chance(0.7);
        // Together at most 1.
        let diffuse = self.color(if specular { 0.5 } else { 1.0 });
        let _ = write!(
            self.text,
            "[materials.{name}.{model}]\ndiffuse = {diffuse}\n"
        );
        if specular {
            let specular = self.color(0.5);
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
        let intensity = match self.random.count(0, 2) {
            0 => format!("{strength:?}"),
            1 => format!(
                "{:?}",
                [(); 3].map(|()| strength * self.random.between(0.1, 1.0))
            ),
            _ => "\"#ffcc88\"".to_owned(),
        };
        let _ = write!(
            self.text,
            "[lights.l{}.point]\nposition = {position:?}\nintensity = {intensity}\n\n",
            self.lights
        );
        self.lights += 1;
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
        let keys = format!(
            "file = \"{file}\"\nscale = {scale}\nrotate = {rotate:?}\ntranslate = {center:?}\n\
             smooth = {smooth}\n"
        );
        self.object("mesh", material, &keys);
    }

    fn still_life(&mut self) {
        let eye = [self.random.between(-3.0, 3.0), 1.5, 4.0];
        self.camera(eye, [0.0, 0.5, 0.0]);
        let floor = self.material();
        self.plane(&floor, [0.0; 3], [0.0, 1.0, 0.0]);
        for _ in 0..self.random.count(3, 6) {
            let (material, radius) = (self.material(), self.random.between(0.2, 0.7));
            let [x, _, z] = self.random.point(1.5);
            self.sphere(&material, [x, radius, z], radius);
        }
        for _ in 0..self.random.count(0, 4) {
            let material = self.material();
            let corners = [(); 3].map(|()| along([0.0, 0.8, 0.0], self.random.point(1.5), 0.8));
            self.triangle(&material, corners);
        }
        self.lights_above(0, 4);
    }

    fn crowd(&mut self) {
        let direction = self.random.direction();
        self.camera(along([0.0; 3], direction, 5.0), [0.0; 3]);
        let materials = [(); 4].map(|()| self.material());
        for index in 0..self.random.count(20, 80) {
            let (center, radius) = (self.random.point(2.0), self.random.log_between(0.02, 0.6));
            self.sphere(&materials[index as usize % 4], center, radius);
        }
        self.lights(0, 8);
    }

    fn shards(&mut self) {
        let direction = self.random.direction();
        self.camera(along([0.0; 3], direction, 5.0), [0.0; 3]);
        let materials = [(); 3].map(|()| self.material());
        for index in 0..self.random.count(5, 80) {
            let center = self.random.point(1.5);
            let size = self.random.log_between(0.05, 2.0);
            let corners = [(); 3].map(|()| along(center, self.random.point(size), 1.0));
            self.triangle(&materials[index as usize % 3], corners);
        }
        if self.random.chance(0.5) {
            let normal = self.random.direction();
            self.plane(&materials[0], along([0.0; 3], normal, -2.5), normal);
        }
        self.lights(1, 5);
    }

    fn torus(&mut self) {
        let direction = self.random.direction();
        self.camera(along([0.0; 3], direction, 4.0), [0.0; 3]);
        let material = self.material();
        let waves = self.random.count(0, 5) as f64;
        let position = |u: f64, v: f64| {
            let (around, across) = ((TAU * u).sin_cos(), (TAU * v).sin_cos());
            let tube = 0.35 + 0.05 * (waves * TAU * u).sin() * (2.0 * TAU * v).cos();
            let radius = 1.0 + tube * across.1;
            [radius * around.1, tube * across.0, radius * around.0]
        };
        let patch = Patch {
            columns: 36,
            rows: 20,
            position: &position,
        };
        self.mesh(&material, [0.0; 3], &patch);
        let material = self.material();
        let center = self.random.point(0.5);
        self.sphere(&material, center, 0.3);
        let normal = self.random.direction();
        let material = self.material();
        self.plane(&material, along([0.0; 3], normal, -1.8), normal);
        self.lights(1, 4);
    }

    fn terrain(&mut self) {
        let eye = along([0.0; 3], self.random.direction(), 4.0);
        self.camera(eye, [0.0; 3]);
        let (bumps, material) = (self.random.between(1.0, 3.0), self.material());
        let height = |u: f64, v: f64| {
            let (x, z) = (4.0 * u - 2.0, 4.0 * v - 2.0);
            [x, 0.3 * (bumps * x).sin() * (bumps * z).cos(), z]
        };
        let terrain = Patch {
            columns: 24,
            rows: 24,
            position: &height,
        };
        self.mesh(&material, [0.0, -0.5, 0.0], &terrain);
        // Its poles are rows of equal points: half of their triangles have no area.
        let ball = |u: f64, v: f64| {
            let radius = 0.8 + 0.1 * (3.0 * TAU * u).sin() * (PI * v).sin();
            let ring = if v == 0.0 || v == 1.0 {
                0.0
            } else {
                radius * (PI * v).sin()
            };
            let (sin, cos) = (TAU * u).sin_cos();
            [ring * cos, radius * (PI * v).cos(), ring * sin]
        };
        let ball = Patch {
            columns: 24,
            rows: 12,
            position: &ball,
        };
        let material = self.material();
        self.mesh(&material, [0.0, 0.6, 0.0], &ball);
        self.lights(1, 4);
    }

    /// Touching spheres, spheres that touch the floor, and everything twice at the same place.
    fn contacts(&mut self) {
        let eye = [self.random.between(-2.0, 2.0), 2.0, 4.0];
        self.camera(eye, [0.0, 0.4, 0.0]);
        let materials = [(); 3].map(|()| self.material());
        for floor in &materials[..2] {
            self.plane(floor, [0.0; 3], [0.0, 1.0, 0.0]);
        }
        for i in 0..3 {
            for j in 0..3 {
                let center = [f64::from(i) - 1.0, 0.5, f64::from(j) - 1.0];
                self.sphere(&materials[(i + j) as usize % 3], center, 0.5);
            }
        }
        // Twice, in another material.
        self.sphere(&materials[1], [0.0, 0.5, 0.0], 0.5);
        let corners = [[-1.5, 0.0, 1.2], [1.5, 0.0, 1.2], [0.0, 1.0, 1.2]];
        self.triangle(&materials[0], corners);
        self.triangle(&materials[2], corners);
        self.lights_above(1, 4);
    }

    fn far_and_tiny(&mut self) {
        let distance = self.random.log_between(50.0, 1e4);
        let direction = self.random.direction();
        let center = along([0.0; 3], direction, distance);
        let (eye, look_at) = (self.place([0.0; 3]), self.place(center));
        let up = if direction[1].abs() > 0.9 {
            [1.0, 0.0, 0.0]
        } else {
            [0.0, 1.0, 0.0]
        };
        let view = format!("eye = {eye:?}\nlook_at = {look_at:?}\nup = {up:?}\n");
        if self.random.chance(0.5) {
            self.perspective(&view, (2.0 * (1.0 / distance).atan()).to_degrees());
        } else {
            self.orthographic(&view, 2.0);
        }
        for _ in 0..self.random.count(4, 12) {
            let material = self.material();
            let place = along(center, self.random.point(1.0), 0.8);
            let radius = self.random.log_between(1e-2, 0.5);
            self.sphere(&material, place, radius);
        }
        let material = self.material();
        self.plane(&material, along(center, direction, 1.5), direction);
        for _ in 0..self.random.count(1, 3) {
            let offset = self.random.point(3.0);
            let beside = along(center, offset, 1.0);
            self.light(along(beside, direction, -3.5));
        }
    }

    /// A small distance between a light and a surface, but one that the coordinates still tell:
    /// far from the origin their last bit is 1e-16 of that way.
    fn gap(&mut self) -> f64 {
        self.random.choice(&[1e-9, 1e-6, 1e-3, 0.1]) * self.far.max(1.0)
    }

    /// Lights just above surfaces, and within spheres, one of which the camera is in.
    fn near_lights(&mut self) {
        self.camera([0.0, 1.0, 4.0], [0.0, 0.5, 0.0]);
        let material = self.material();
        self.plane(&material, [0.0; 3], [0.0, 1.0, 0.0]);
        let material = self.material();
        self.sphere(&material, [0.0, 1.0, 0.0], 7.0);
        for _ in 0..self.random.count(1, 4) {
            let material = self.material();
            let (center, radius) = ([0.0, 0.7, 0.0], self.random.between(0.2, 0.6));
            let center = along(center, self.random.point(1.0), 1.0);
            self.sphere(&material, center, radius);
            let way = self.random.direction();
            let gap = self.gap();
            self.light(along(center, way, radius + gap));
            if self.random.chance(0.3) {
                self.light(along(center, way, 0.5 * radius));
            }
        }
        let [x, _, z] = self.random.point(1.5);
        let gap = self.gap();
        self.light([x, gap, z]);
        self.lights_above(1, 2);
    }

    fn grazing(&mut self) {
        let height = self.random.log_between(1e-4, 0.1);
        self.camera([0.1, height, 3.0], [0.0, 0.0, 0.0]);
        let material = self.material();
        self.plane(&material, [0.0; 3], [0.0, 1.0, 0.0]);
        for _ in 0..self.random.count(2, 12) {
            let material = self.material();
            let [x, y, z] = self.random.point(1.5);
            let radius = self.random.log_between(0.01, 0.5);
            self.sphere(&material, [x, y.abs() * 0.3, z], radius);
        }
        let corners = [(); 3].map(|()| self.random.point(1.5));
        self.triangle(&material, corners);
        for _ in 0..self.random.count(1, 3) {
            let [x, _, z] = self.random.point(3.0);
            let height = self.random.log_between(1e-3, 3.0);
            self.light([x, height, z]);
        }
    }

    fn room(&mut self) {
        let eye = self.random.point(1.8);
        self.camera(eye, along([0.0; 3], eye, -0.3));
        for axis in 0..3 {
            for side in [-2.0, 2.0] {
                let material = self.material();
                let mut wall = [0.0; 3];
                wall[axis] = side;
                self.plane(&material, wall, wall);
            }
        }
        for _ in 0..self.random.count(1, 10) {
            let (material, center) = (self.material(), self.random.point(1.5));
            let radius = self.random.between(0.1, 0.4);
            self.sphere(&material, center, radius);
        }
        let (a, b) = ([-1.0, -1.2, -1.0], [1.0, -1.2, 1.0]);
        let (c, d) = ([-1.0, -1.2, 1.0], [1.0, -1.2, -1.0]);
        let material = self.material();
        self.triangle(&material, [a, b, c]);
        self.triangle(&material, [b, a, d]);
        for _ in 0..self.random.count(1, 4) {
            let position = self.random.point(1.95);
            self.light(position);
        }
    }
}

/// How a mesh is written; the numbers are the same f32 in all.
#[derive(Clone, Copy)]
enum MeshFormat {
    Ply,
    BinaryPly,
    Obj,
}

impl MeshFormat {
    fn extension(self) -> &'static str {
        match self {
            Self::Ply | Self::BinaryPly => "ply",
            Self::Obj => "obj",
        }
    }

    fn write(self, patch: &Patch<'_>, with_normals: bool) -> Vec<u8> {
        let (vertices, quads) = patch.tessellated();
        match self {
            Self::Ply | Self::BinaryPly => self.ply(&vertices, &quads),
            Self::Obj => obj(&vertices, &quads, with_normals),
        }
    }

    fn ply(self, vertices: &[[f32; 6]], quads: &[[u32; 4]]) -> Vec<u8> {
        let binary = matches!(self, Self::BinaryPly);
        let format = if binary {
            "binary_little_endian"
        } else {
            "ascii"
        };
        let mut text = format!(
            "ply\nformat {format} 1.0\nelement vertex {}\n",
            vertices.len()
        );
        for property in ["x", "y", "z", "nx", "ny", "nz"] {
            let _ = writeln!(text, "property float {property}");
        }
        let _ = write!(
            text,
            "element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
            quads.len()
        );
        let mut bytes = text.into_bytes();
        for vertex in vertices {
            if binary {
                bytes.extend(vertex.iter().flat_map(|value| value.to_le_bytes()));
            } else {
                bytes.extend(vertex.map(|value| value.to_string()).join(" ").into_bytes());
                bytes.push(b'\n');
            }
        }
        for quad in quads {
            if binary {
                bytes.push(4);
                bytes.extend(quad.iter().flat_map(|index| index.to_le_bytes()));
            } else {
                let [a, b, c, d] = quad;
                bytes.extend(format!("4 {a} {b} {c} {d}\n").into_bytes());
            }
        }
        bytes
    }
}

fn obj(vertices: &[[f32; 6]], quads: &[[u32; 4]], with_normals: bool) -> Vec<u8> {
    let mut text = String::new();
    for [x, y, z, nx, ny, nz] in vertices {
        let _ = writeln!(text, "v {x} {y} {z}\nvn {nx} {ny} {nz}");
    }
    for quad in quads {
        let corners = quad.map(|index| {
            let index = index + 1;
            if with_normals {
                format!("{index}//{index}")
            } else {
                index.to_string()
            }
        });
        let _ = writeln!(text, "f {}", corners.join(" "));
    }
    text.into_bytes()
}

impl Patch<'_> {
    /// Positions with normals, and quads counter-clockwise around them.
    fn tessellated(&self) -> (Vec<[f32; 6]>, Vec<[u32; 4]>) {
        let mut vertices = Vec::new();
        for row in 0..=self.rows {
            for column in 0..=self.columns {
                let u = column as f64 / self.columns as f64;
                let v = row as f64 / self.rows as f64;
                vertices.push(self.vertex(u, v));
            }
        }
        let index = |row: usize, column: usize| (row * (self.columns + 1) + column) as u32;
        let quads = (0..self.rows).flat_map(|row| {
            (0..self.columns).map(move |column| {
                [
                    index(row, column),
                    index(row + 1, column),
                    index(row + 1, column + 1),
                    index(row, column + 1),
                ]
            })
        });
        (vertices, quads.collect())
    }

    fn vertex(&self, u: f64, v: f64) -> [f32; 6] {
        /// A step for differences; normals need not be exact, they are what the file says.
        const STEP: f64 = 1e-4;
        let p = (self.position)(u, v);
        // Away from the poles of a ball, where one of the tangents vanishes.
        let v = v.clamp(2.0 * STEP, 1.0 - 2.0 * STEP);
        let difference = |a: Vector, b: Vector| along(b, a, -1.0);
        let du = difference((self.position)(u - STEP, v), (self.position)(u + STEP, v));
        let dv = difference((self.position)(u, v - STEP), (self.position)(u, v + STEP));
        let normal = [
            dv[1] * du[2] - dv[2] * du[1],
            dv[2] * du[0] - dv[0] * du[2],
            dv[0] * du[1] - dv[1] * du[0],
        ];
        let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        let n = normal.map(|x| x / length);
        [p[0], p[1], p[2], n[0], n[1], n[2]].map(|value| value as f32)
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
        "[camera.perspective]",
        "[camera.orthographic]",
        ".phong]",
        ".normalized_phong]",
        "rgb = ",
        "\"#",
    ] {
        let count = texts.iter().filter(|text| text.contains(part)).count();
        assert!(count >= 5, "{part} is in {count} scenes");
    }
    let lights = |text: &String| text.matches("[lights.").count();
    assert!(texts.iter().any(|text| lights(text) == 0));
    assert!(texts.iter().any(|text| lights(text) == 8));
}
