//! Scenes in numbers, what they look like as a scene file, and their radiance by brute force.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::path::Path;

use super::Vector;
use super::shape::{ENDS, Light, Material, Shape, across, cross, dot, minus, plus, times, unit};
use crate::generate::Random;

/// The floor's is rough, the spheres' is normalized, what is flat is dull.
const MATERIALS: [Material; 3] = [
    Material {
        diffuse: [0.3, 0.2, 0.1],
        specular: 0.0,
        shininess: 1.0,
        is_normalized: false,
    },
    Material {
        diffuse: [0.2, 0.2, 0.2],
        specular: 0.4,
        shininess: 60.0,
        is_normalized: false,
    },
    Material {
        diffuse: [0.4, 0.4, 0.4],
        specular: 0.3,
        shininess: 12.5,
        is_normalized: true,
    },
];

const EYE: Vector = [0.5, 2.0, 5.0];
const LOOK_AT: Vector = [0.0, 0.4, 0.0];
const DEGREES: f64 = 40.0;

/// Radiance, and what it would be if nothing were in the way.
#[derive(Clone, Copy, Default)]
struct Radiance {
    seen: Vector,
    unhidden: Vector,
}

/// A mean with its standard error.
#[derive(Clone, Copy)]
pub(super) struct Mean {
    pub(super) mean: Vector,
    pub(super) error: Vector,
    pub(super) unhidden: Vector,
}

impl Mean {
    /// Of so many lattices in some dimensions, each with a shift of its own.
    fn of_lattices<const N: usize>(
        lattices: usize,
        seed: u64,
        of_shift: impl Fn([f64; N]) -> Radiance,
    ) -> Self {
        let mut random = Random::new(seed);
        let mut shift = || [(); N].map(|()| random.unit());
        let parts: Vec<Radiance> = (0..lattices).map(|_| of_shift(shift())).collect();
        Self::of(&parts)
    }

    fn of(parts: &[Radiance]) -> Self {
        let count = parts.len() as f64;
        let mean_of = |of: fn(&Radiance) -> Vector| {
            let sum = parts.iter().map(of).fold([0.0; 3], plus);
            times(sum, 1.0 / count)
        };
        let mean = mean_of(|part| part.seen);
        let error = [0, 1, 2].map(|channel: usize| {
            let squares = parts
                .iter()
                .map(|part| (part.seen[channel] - mean[channel]).powi(2));
            (squares.sum::<f64>() / (count * (count - 1.0))).sqrt()
        });
        Self {
            mean,
            error,
            unhidden: mean_of(|part| part.unhidden),
        }
    }
}

/// A scene in numbers.
pub(super) struct Room {
    lights: Vec<Light>,
    /// With the material of each.
    objects: Vec<(Shape, usize)>,
    resolution: [usize; 2],
    pub(super) text: String,
}

impl Room {
    /// A floor, a wall now and then, spheres, triangles and a mesh under two lights, and a third that is in the way of
    /// those. Of twenty, each shape of a light meets each other.
    pub(super) fn new(seed: u64, resolution: [usize; 2], folder: &Path) -> Self {
        let mut random = Random::new(seed + (7 << 40));
        let mut room = Self {
            lights: Vec::new(),
            objects: Vec::new(),
            resolution,
            text: header(resolution),
        };
        let mut between = |low, high| random.between(low, high);
        room.plane("floor", [0.0; 3], [0.0, 1.0, 0.0]);
        if seed % 4 == 3 {
            room.plane("wall", [-1.2, 0.0, 0.0], [1.0, 0.2, between(-0.3, 0.3)]);
        }
        for number in 0..2 {
            let center = [between(-1.0, 1.0), between(0.2, 0.9), between(-1.0, 1.0)];
            room.sphere(number, center, between(0.1, 0.4));
        }
        for number in 0..2 {
            let center = [between(-1.0, 1.0), between(0.2, 1.1), between(-1.0, 1.0)];
            let mut corner = || [0, 1, 2].map(|axis: usize| center[axis] + between(-0.6, 0.6));
            let corners = [corner(), corner(), corner()];
            room.triangle(number, corners);
        }
        let center = [between(-0.8, 0.8), between(0.4, 1.0), between(-0.8, 0.8)];
        room.octahedron(seed, folder, center, between(0.15, 0.4));
        for number in 0..3 {
            let kind = [seed, seed / 3, 1][number] % 3;
            let is_low = number == 2;
            let height = if is_low {
                between(0.6, 1.2)
            } else {
                between(1.2, 2.5)
            };
            let center = [between(-1.5, 1.5), height, between(-1.5, 1.5)];
            let largest = if is_low { 0.3 } else { 0.7 };
            let aim = [between(-0.5, 0.5), 0.0, between(-0.5, 0.5)];
            let sizes = [between(0.05, largest), between(0.05, largest)];
            room.light(kind, center, aim, sizes, is_low || between(0.0, 1.0) < 0.7);
        }
        room
    }

    fn plane(&mut self, name: &str, point: Vector, normal: Vector) {
        writeln!(
            self.text,
            "[objects.{name}.plane]\nmaterial = \"m1\"\npoint = {point:?}\nnormal = {normal:?}"
        )
        .unwrap();
        self.objects.push((Shape::Plane { point, normal }, 1));
    }

    fn sphere(&mut self, number: usize, center: Vector, radius: f64) {
        writeln!(
            self.text,
            "[objects.s{number}.sphere]\nmaterial = \"m2\"\ncenter = {center:?}\nradius = {radius:?}"
        )
        .unwrap();
        self.objects.push((Shape::Sphere { center, radius }, 2));
    }

    fn triangle(&mut self, number: usize, corners: [Vector; 3]) {
        writeln!(
            self.text,
            "[objects.t{number}.triangle]\nmaterial = \"m0\"\nvertices = {corners:?}"
        )
        .unwrap();
        self.objects.push((Shape::Triangle(corners), 0));
    }

    fn octahedron(&mut self, seed: u64, folder: &Path, center: Vector, radius: f64) {
        let mut corners = Vec::new();
        for axis in 0..3 {
            for side in [radius, -radius] {
                let mut corner = center;
                corner[axis] += side;
                corners.push(corner);
            }
        }
        let mut file = String::new();
        for [x, y, z] in &corners {
            writeln!(file, "v {x:?} {y:?} {z:?}").unwrap();
        }
        for face in 0..8 {
            let [x, y, z] = [0, 1, 2].map(|axis: usize| 2 * axis + (face >> axis & 1));
            writeln!(file, "f {} {} {}", x + 1, y + 1, z + 1).unwrap();
            let face = [x, y, z].map(|corner| corners[corner]);
            self.objects.push((Shape::Triangle(face), 0));
        }
        let name = format!("octahedron-{seed}.obj");
        std::fs::write(folder.join(&name), file).unwrap();
        writeln!(
            self.text,
            "[objects.gem.mesh]\nmaterial = \"m0\"\nfile = \"{name}\""
        )
        .unwrap();
    }

    fn light(&mut self, kind: u64, center: Vector, aim: Vector, sizes: [f64; 2], is_visible: bool) {
        let number = self.lights.len();
        let normal = unit(minus(aim, center));
        let is_two_sided = kind == 1 && number != 1;
        let (shape, keys) = match kind {
            0 => {
                let [x, y] = across(normal, [0.0, 1.0, 0.0]);
                let shape = Shape::Rectangle {
                    center,
                    normal,
                    sides: [times(x, sizes[0]), times(y, sizes[1])],
                };
                let size = sizes.map(|half| 2.0 * half);
                (
                    shape,
                    format!("rectangle]\nlook_at = {aim:?}\nsize = {size:?}"),
                )
            }
            1 => {
                let radius = sizes[0];
                let shape = Shape::Disk {
                    center,
                    normal,
                    radius,
                };
                let keys = format!(
                    "disk]\nlook_at = {aim:?}\nradius = {radius:?}\ntwo_sided = {is_two_sided}"
                );
                (shape, keys)
            }
            _ => {
                let radius = 0.6 * sizes[0];
                (
                    Shape::Sphere { center, radius },
                    format!("sphere]\nradius = {radius:?}"),
                )
            }
        };
        let luminance = [20.0, 15.0, 10.0 + number as f64];
        writeln!(
            self.text,
            "[lights.l{number}.{keys}\ncenter = {center:?}\nluminance = {luminance:?}\nvisible = {is_visible}"
        )
        .unwrap();
        self.lights.push(Light {
            shape,
            luminance,
            is_two_sided,
            is_visible,
        });
    }

    /// Everything that can be seen: objects, then lights, with the place of each in its list.
    fn seen(&self) -> impl Iterator<Item = (&Shape, Result<usize, usize>)> {
        let objects = self
            .objects
            .iter()
            .map(|(shape, material)| (shape, Ok(*material)));
        let lights = self.lights.iter().enumerate();
        let lights = lights.filter(|(_, light)| light.is_visible);
        objects.chain(lights.map(|(number, light)| (&light.shape, Err(number))))
    }

    fn is_hidden(&self, from: Vector, way: Vector, light: usize) -> bool {
        self.seen().any(|(shape, what)| {
            what != Err(light) && shape.hit(from, way, [ENDS, 1.0 - ENDS]).is_some()
        })
    }

    /// What arrives at the eye through a point of the image, in pixels from its upper left corner. Each light is asked at
    /// the points of the square that are given.
    fn radiance(&self, [x, y]: [f64; 2], points: &[[f64; 2]]) -> Radiance {
        let forward = unit(minus(LOOK_AT, EYE));
        let [right, up] = {
            let right = unit(cross(forward, [0.0, 1.0, 0.0]));
            [right, cross(right, forward)]
        };
        let [width, height] = self.resolution.map(|side| side as f64);
        let half = (DEGREES / 2.0).to_radians().tan();
        let way = unit(plus(
            forward,
            plus(
                times(right, (2.0 * x / width - 1.0) * half * width / height),
                times(up, (1.0 - 2.0 * y / height) * half),
            ),
        ));
        let hits = self.seen().filter_map(|(shape, what)| {
            let t = shape.hit(EYE, way, [0.0, f64::INFINITY])?;
            Some((t, shape, what))
        });
        let Some((t, shape, what)) = hits.min_by(|a, b| a.0.total_cmp(&b.0)) else {
            return Radiance::default();
        };
        let at = plus(EYE, times(way, t));
        let back = times(way, -1.0);
        match what {
            Ok(material) => {
                let normal = shape.normal(at);
                let side = dot(normal, back).signum();
                self.reflected(at, times(normal, side), back, MATERIALS[material], points)
            }
            Err(number) => {
                let light = &self.lights[number];
                let is_front = light.cosine(at, back) > 0.0;
                let seen = if is_front { light.luminance } else { [0.0; 3] };
                Radiance {
                    seen,
                    unhidden: seen,
                }
            }
        }
    }

    fn reflected(
        &self,
        at: Vector,
        normal: Vector,
        eye: Vector,
        material: Material,
        points: &[[f64; 2]],
    ) -> Radiance {
        let mirrored = minus(times(normal, 2.0 * dot(normal, eye)), eye);
        let n = material.shininess;
        let mut sum = Radiance::default();
        for (number, light) in self.lights.iter().enumerate() {
            // Of the diffuse and of the specular lobe: with shadow and without.
            let mut lobes = [[0.0; 2]; 2];
            for &[u, v] in points {
                let (end, area) = light.shape.point(at, u, v);
                let way = minus(end, at);
                let square = dot(way, way);
                let omega = times(way, 1.0 / square.sqrt());
                let cosine = dot(normal, omega);
                let solid = light.cosine(end, times(omega, -1.0)) * area / square;
                if cosine <= 0.0 || solid == 0.0 {
                    continue;
                }
                let lobe = if material.specular == 0.0 {
                    0.0
                } else {
                    dot(mirrored, omega).max(0.0).powf(n)
                };
                let is_hidden = self.is_hidden(at, way, number);
                let of_lobe = if material.is_normalized {
                    [cosine / PI, (n + 2.0) / TAU * lobe * cosine]
                } else {
                    [cosine, lobe]
                };
                for (lobe, of_lobe) in lobes.iter_mut().zip(of_lobe) {
                    lobe[1] += of_lobe * solid;
                    lobe[0] += if is_hidden { 0.0 } else { of_lobe * solid };
                }
            }
            let count = points.len() as f64;
            let of = |which: usize| {
                [0, 1, 2].map(|channel: usize| {
                    let [diffuse, specular] = lobes.map(|lobe| lobe[which] / count);
                    let reflected =
                        material.diffuse[channel] * diffuse + material.specular * specular;
                    light.luminance[channel] * reflected
                })
            };
            sum.seen = plus(sum.seen, of(0));
            sum.unhidden = plus(sum.unhidden, of(1));
        }
        sum
    }

    /// Column and row of a pixel of a film.
    pub(super) fn pixel(&self, index: usize) -> [usize; 2] {
        let [width, _] = self.resolution;
        [index % width, index / width]
    }

    /// At the middle of a pixel, by so many points of each light in so many lattices.
    pub(super) fn at_middle(
        &self,
        pixel: [usize; 2],
        count: usize,
        lattices: usize,
        seed: u64,
    ) -> Mean {
        let per_lattice = count / lattices;
        // Nearly the golden section, so that the lattice is about square.
        let generator = (per_lattice as f64 * 0.618_034) as usize | 1;
        let middle = pixel.map(|at| at as f64 + 0.5);
        Mean::of_lattices(lattices, seed, |shift: [f64; 2]| {
            let points: Vec<[f64; 2]> = (0..per_lattice)
                .map(|i| {
                    let lattice = [i, i * generator % per_lattice];
                    [0, 1].map(|axis: usize| {
                        let x = (lattice[axis] as f64 / per_lattice as f64 + shift[axis]).fract();
                        // The baker's transformation: as if the integrand were periodic (Hickernell 2002).
                        1.0 - (2.0 * x - 1.0).abs()
                    })
                })
                .collect();
            self.radiance(middle, &points)
        })
    }

    /// The mean over the square of a pixel: each point of it asks one point of each light, of a sequence in four dimensions.
    pub(super) fn over_pixel(
        &self,
        pixel: [usize; 2],
        count: usize,
        lattices: usize,
        seed: u64,
    ) -> Mean {
        /// The positive root of x⁵ = x + 1.
        const RATIO: f64 = 1.167_303_978_261_418_7;
        let per_lattice = count / lattices;
        Mean::of_lattices(lattices, seed, |shift: [f64; 4]| {
            let mut sum = Radiance::default();
            for i in 0..per_lattice {
                let [x, y, u, v] = [0, 1, 2, 3].map(|axis: usize| {
                    (shift[axis] + (i + 1) as f64 / RATIO.powi(axis as i32 + 1)).fract()
                });
                let place = [pixel[0] as f64 + x, pixel[1] as f64 + y];
                let radiance = self.radiance(place, &[[u, v]]);
                sum.seen = plus(sum.seen, radiance.seen);
                sum.unhidden = plus(sum.unhidden, radiance.unhidden);
            }
            let count = per_lattice as f64;
            Radiance {
                seen: times(sum.seen, 1.0 / count),
                unhidden: times(sum.unhidden, 1.0 / count),
            }
        })
    }
}

fn header([width, height]: [usize; 2]) -> String {
    let mut text = format!(
        "[image]\nresolution = [{width}, {height}]\n\
         [camera.perspective]\neye = {EYE:?}\nlook_at = {LOOK_AT:?}\nvertical_fov = {DEGREES:?}\n"
    );
    for (number, material) in MATERIALS.iter().enumerate() {
        let Material {
            diffuse,
            specular,
            shininess,
            is_normalized,
        } = material;
        let kind = if *is_normalized {
            "normalized_phong"
        } else {
            "phong"
        };
        writeln!(
            text,
            "[materials.m{number}.{kind}]\ndiffuse = {diffuse:?}\nspecular = {specular:?}\nshininess = {shininess:?}"
        )
        .unwrap();
    }
    text
}
