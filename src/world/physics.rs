//! What is legal but physically odd: materials that give more light than they get, lights inside
//! of objects, a scene without light.

use std::f64::consts::{PI, TAU};
use std::fmt;

use super::material::Model;
use super::{Material, Mesh, Shape, World};
use crate::math::{DVec3, Point};
use crate::scene::ColorSpace;
use crate::scene::ShadowTerminator;
use crate::spectrum::VISIBLE;
use crate::units::{Reflectance, Rgb};

/// Something that is legal and rendered as written, but may not be meant.
#[derive(Clone, Debug, PartialEq)]
pub enum Warning {
    /// A material reflects more light than it receives.
    ReflectsMore {
        /// The material's name.
        material: String,
        /// Its [directional albedo at normal incidence](albedo_at_normal_incidence), per primary.
        albedo: [f64; 3],
    },
    /// A light is inside of a closed object, so that it lights nothing but the inside.
    LightInside {
        /// The light's name.
        light: String,
        /// The object's name.
        object: String,
    },
    /// There is no light: every surface is black.
    NoLight,
    /// A mesh has triangles without area, which were dropped.
    Degenerate {
        /// The mesh's name.
        object: String,
        /// How many.
        triangles: usize,
    },
    /// A curve leaves out a part of the visible range, where its end values are used.
    Gap {
        /// Whose curve: "light `key`", "material `clay`".
        entry: String,
        /// The wavelengths in nm that it covers.
        range: [f64; 2],
    },
    /// A spectrum's color is outside of the working space.
    Outside {
        /// Whose: "light `key`", "material `clay` under white light".
        entry: String,
        /// The working space.
        space: ColorSpace,
        /// The color there, with a channel below 0.
        rgb: [f64; 3],
    },
    /// A mesh asks for shadow rays that start off its triangles and is shaded flat.
    NothingToLift {
        /// The mesh's name.
        object: String,
    },
    /// A mesh has triangles whose corners are the same point in f64, which were dropped.
    Vanished {
        /// The mesh's name.
        object: String,
        /// How many.
        triangles: usize,
    },
    /// A mesh file is not taken as written in places: one of its
    /// [remarks](crate::scene::mesh::MeshRemarks::list).
    Mended {
        /// The mesh's name.
        object: String,
        /// What the file has, how often, and what became of it.
        remark: String,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ReflectsMore { material, albedo } => {
                let largest = albedo.iter().copied().fold(0.0, f64::max);
                write!(
                    f,
                    "material `{material}` reflects {largest:.2} times the light that it receives \
                     at normal incidence (π k_d + 2π k_s/(n+2)), and more towards grazing; \
                     `normalized_phong` never reflects more than it receives",
                )
            }
            Self::LightInside { light, object } => {
                write!(f, "light `{light}` is inside of object `{object}`")
            }
            Self::NoLight => write!(f, "the scene has no light, so every surface is black"),
            Self::Degenerate {
                object,
                triangles: 1,
            } => write!(
                f,
                "1 triangle of object `{object}` has no area and was dropped"
            ),
            Self::Degenerate { object, triangles } => write!(
                f,
                "{triangles} triangles of object `{object}` have no area and were dropped"
            ),
            Self::Gap {
                entry,
                range: [first, last],
            } => write!(
                f,
                "the curve of {entry} covers {first} to {last} nm; from there to {} and {} nm it \
                 is taken to stay as at its ends",
                VISIBLE[0], VISIBLE[1],
            ),
            Self::Outside {
                entry,
                space,
                rgb: [r, g, b],
            } => write!(
                f,
                "{entry} is outside of {}, [{r:.4} {g:.4} {b:.4}]; the EXR keeps channels below 0, \
                 a PNG cannot",
                space.name(),
            ),
            Self::NothingToLift { object } => write!(
                f,
                "`shadow_terminator = \"hanika\"` of object `{object}` does nothing: it is shaded flat, \
                 for its file has no vertex normals or it says `smooth = false`",
            ),
            Self::Vanished {
                object,
                triangles: 1,
            } => write!(
                f,
                "1 triangle of object `{object}` is too small where it is placed for 64-bit floats \
                 to tell its corners apart, and was dropped"
            ),
            Self::Vanished { object, triangles } => write!(
                f,
                "{triangles} triangles of object `{object}` are too small where they are placed for \
                 64-bit floats to tell their corners apart, and were dropped"
            ),
            Self::Mended { object, remark } => {
                write!(f, "the file of object `{object}` has {remark}")
            }
        }
    }
}

/// The part of the light arriving along the normal that a material reflects into all directions,
/// per primary:
///
/// ∫ L_o cos θ dω / (I/d²) = π k_d + 2π k_s / (n + 2),
///
/// because ω_r is the normal there, and ∫ cosⁿθ cos θ dω = 2π/(n+2) over the hemisphere. For
/// `normalized_phong` this is ρ_d + ρ_s. Towards grazing incidence the specular part of `phong`
/// grows as 1/cos θ_i, because L7 has no cosine of the incident light.
pub fn albedo_at_normal_incidence(material: &Material) -> [f64; 3] {
    let reflectance = material.reflectance();
    let lobe = TAU / (material.shininess() + 2.0);
    std::array::from_fn(|i| PI * reflectance.diffuse.0.0[i] + lobe * reflectance.specular.0.0[i])
}

/// Everything about a world that may not be meant, in the order of the file.
pub fn warnings(world: &World) -> Vec<Warning> {
    let mut warnings = Vec::new();
    if world.lights().is_empty() {
        warnings.push(Warning::NoLight);
    }
    for material in world.materials() {
        let albedo = albedo_at_normal_incidence(&material.value);
        // A normalized material cannot exceed 1 but by a rounding.
        if material.value.model() == Model::Phong && albedo.iter().any(|&albedo| albedo > 1.0) {
            warnings.push(Warning::ReflectsMore {
                material: material.name.clone(),
                albedo,
            });
        }
    }
    for gap in world.gaps() {
        warnings.push(Warning::Gap {
            entry: gap.name.clone(),
            range: gap.value,
        });
    }
    warnings.extend(outside(world));
    let mut inside = Inside::new(world);
    for object in world.objects() {
        if let Shape::Mesh(mesh) = object.shape {
            let mesh = &world.triangles().meshes()[mesh];
            let object = &object.name;
            if mesh.degenerate > 0 {
                warnings.push(Warning::Degenerate {
                    object: object.clone(),
                    triangles: mesh.degenerate,
                });
            }
            if mesh.shadow_terminator == ShadowTerminator::Hanika && !mesh.lifts_shadow_rays() {
                warnings.push(Warning::NothingToLift {
                    object: object.clone(),
                });
            }
            if mesh.vanished > 0 {
                warnings.push(Warning::Vanished {
                    object: object.clone(),
                    triangles: mesh.vanished,
                });
            }
            let remarks = mesh.remarks.list().into_iter();
            warnings.extend(remarks.map(|remark| Warning::Mended {
                object: object.clone(),
                remark,
            }));
        }
        for light in inside.lights(object.shape) {
            warnings.push(Warning::LightInside {
                light: world.lights()[light].name.clone(),
                object: object.name.clone(),
            });
        }
    }
    warnings
}

/// Lights and reflectances with a channel below 0 in the working space, by more than rounding.
fn outside(world: &World) -> impl Iterator<Item = Warning> {
    let warning = |entry: String, rgb: [f64; 3]| {
        let largest = rgb.iter().copied().fold(0.0, f64::max);
        let is_outside = rgb.iter().any(|&channel| channel < -1e-6 * largest);
        is_outside.then(|| Warning::Outside {
            entry,
            space: world.color_space(),
            rgb,
        })
    };
    let lights = world.lights().iter().filter_map(move |light| {
        warning(format!("light `{}`", light.name), light.value.intensity.0.0)
    });
    let materials = world.materials().iter().filter_map(move |material| {
        let Reflectance(Rgb(diffuse)) = material.value.reflectance().diffuse;
        let factor = material.value.factors().diffuse;
        warning(
            format!("material `{}` under white light", material.name),
            diffuse.map(|channel| channel / factor),
        )
    });
    lights.chain(materials)
}

/// Pairs of a light and a triangle that are looked at, to find the lights inside of meshes: about a
/// tenth of a second. Lights beyond are not looked for, so that no scene takes longer to judge than to
/// load.
const PAIRS: usize = 1 << 21;

/// Finds the lights inside of shapes.
struct Inside<'w> {
    world: &'w World,
    /// x of each light's position, and its number; by x, so that each shape meets only the lights that
    /// are within its reach.
    by_x: Vec<(f64, usize)>,
    /// Of [`PAIRS`], those that are left.
    pairs: usize,
}

impl<'w> Inside<'w> {
    fn new(world: &'w World) -> Self {
        let lights = world.lights().iter().enumerate();
        let mut by_x: Vec<_> = lights
            .map(|(light, of)| (of.value.position.0.x, light))
            .collect();
        by_x.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self {
            world,
            by_x,
            pairs: PAIRS,
        }
    }

    /// The lights inside of a shape, in their order.
    fn lights(&mut self, shape: Shape) -> Vec<usize> {
        let world = self.world;
        let position = |light: usize| world.lights()[light].value.position;
        let mut inside: Vec<usize> = match shape {
            Shape::Sphere(index) => {
                let sphere = &world.spheres()[index];
                let (center, radius) = (sphere.center.0.x, sphere.radius);
                self.between(center - radius, center + radius)
                    .filter(|&light| position(light).from(sphere.center).length() < radius)
                    .collect()
            }
            Shape::Plane(_) => Vec::new(),
            // Without lights there is no need to look at every corner.
            Shape::Mesh(_) if self.by_x.is_empty() => Vec::new(),
            Shape::Mesh(index) => {
                let mesh = &world.triangles().meshes()[index];
                let [min, max] = extent(world, mesh);
                let is_in_box = |&light: &usize| {
                    let DVec3 { y, z, .. } = position(light).0;
                    min.y < y && y < max.y && min.z < z && z < max.z
                };
                let near: Vec<usize> = self.between(min.x, max.x).filter(is_in_box).collect();
                let most = self.pairs / mesh.triangles.len().max(1);
                let asked = near.len().min(most);
                self.pairs -= asked * mesh.triangles.len();
                let is_inside =
                    |&light: &usize| winding_number(world, mesh, position(light)).abs() > 0.5;
                near.into_iter().take(asked).filter(is_inside).collect()
            }
        };
        inside.sort_unstable();
        inside
    }

    /// The lights whose x is above `low` and below `high`.
    fn between(&self, low: f64, high: f64) -> impl Iterator<Item = usize> {
        let start = self.by_x.partition_point(|&(x, _)| x <= low);
        let end = self.by_x.partition_point(|&(x, _)| x < high);
        self.by_x[start..end.max(start)]
            .iter()
            .map(|&(_, light)| light)
    }
}

/// The least and the largest corner of a mesh's box.
fn extent(world: &World, mesh: &Mesh) -> [DVec3; 2] {
    let corners = mesh
        .triangles
        .clone()
        .flat_map(|index| world.triangles().vertices(index));
    let nowhere = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    corners.fold(nowhere, |[min, max], corner| {
        [min.min(corner), max.max(corner)]
    })
}

/// How often a mesh surrounds a point: its solid angle as seen from there over 4π. 0 outside of a
/// closed mesh and ±1 inside; in between for a mesh with holes.
///
/// The solid angle of a triangle with corners a, b, c around the point is
/// 2 atan2(a · (b × c), |a||b||c| + (a·b)|c| + (a·c)|b| + (b·c)|a|)
/// (Van Oosterom & Strackee 1983).
fn winding_number(world: &World, mesh: &Mesh, point: Point) -> f64 {
    let solid_angle = |index: u32| {
        let [a, b, c] = world
            .triangles()
            .vertices(index)
            .map(|vertex| vertex - point.0);
        let [la, lb, lc] = [a, b, c].map(DVec3::length);
        let volume = a.dot(b.cross(c));
        let around = la * lb * lc + a.dot(b) * lc + a.dot(c) * lb + b.dot(c) * la;
        2.0 * libm::atan2(volume, around)
    };
    mesh.triangles.clone().map(solid_angle).sum::<f64>() / (2.0 * TAU)
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;

    use super::*;
    use crate::scene::Scene;

    /// Lights in and out of spheres, against a look at each pair.
    #[test]
    fn lights_inside_of_shapes_are_found_in_order() {
        let mut text = "[image]\nresolution = [1, 1]\n[camera.orthographic]\neye = [0, 0, 9]\n\
             look_at = [0, 0, 0]\nheight = 1\n[materials.m.phong]\n"
            .to_owned();
        for light in 0..40 {
            // A shuffled row along x from -2 to 2.
            let x = f64::from(light * 17 % 40) / 10.0 - 1.95;
            let entry = format!("[lights.l{light}.point]\nposition = [{x}, 0.1, 0]\nintensity = 1");
            writeln!(text, "{entry}").unwrap();
        }
        for (sphere, x) in [(0, -1.0), (1, 0.0), (2, 1.3)] {
            let entry = format!("[objects.s{sphere}.sphere]\nmaterial = 'm'\ncenter = [{x}, 0, 0]");
            writeln!(text, "{entry}\nradius = 0.5").unwrap();
        }
        let world = World::new(&Scene::parse(&text, "scene.toml").unwrap()).unwrap();
        let found = warnings(&world).into_iter().map(|warning| match warning {
            Warning::LightInside { light, object } => (object, light),
            other => panic!("{other}"),
        });
        let found: Vec<_> = found.collect();
        let mut expected = Vec::new();
        for (sphere, center) in [(0, -1.0), (1, 0.0), (2, 1.3)] {
            for light in 0..40 {
                let x = f64::from(light * 17 % 40) / 10.0 - 1.95;
                if f64::hypot(x - center, 0.1) < 0.5 {
                    expected.push((format!("s{sphere}"), format!("l{light}")));
                }
            }
        }
        assert!(expected.len() > 20);
        assert_eq!(found, expected);
    }

    /// The closed form against a quadrature over the hemisphere, at normal incidence.
    #[test]
    fn albedo_is_the_integral_over_the_hemisphere() {
        for shininess in [0.5, 1.0, 20.0, 80.0] {
            let material = Material::phong([0.2, 0.3, 0.4], [0.3, 0.1, 0.0], shininess);
            let steps = 100_000;
            let reflectance = material.reflectance();
            let integral: [f64; 3] = std::array::from_fn(|i| {
                let ring = |step: u32| {
                    let theta = (f64::from(step) + 0.5) / f64::from(steps) * PI / 2.0;
                    let (sin, cos) = theta.sin_cos();
                    let reflected = reflectance.diffuse.0.0[i]
                        + reflectance.specular.0.0[i] * cos.powf(shininess);
                    TAU * sin * cos * reflected
                };
                (0..steps).map(ring).sum::<f64>() * PI / 2.0 / f64::from(steps)
            });
            let closed_form = albedo_at_normal_incidence(&material);
            for (closed_form, integral) in closed_form.iter().zip(integral) {
                assert!(
                    (closed_form - integral).abs() < 1e-8,
                    "{closed_form} {integral}"
                );
            }
        }
    }

    #[test]
    fn a_normalized_material_reflects_its_albedos() {
        let material = Material::normalized_phong([0.5, 0.2, 0.0], [0.5, 0.3, 0.1], 37.0);
        let albedo = albedo_at_normal_incidence(&material);
        for (albedo, expected) in albedo.iter().zip([1.0, 0.5, 0.1]) {
            assert!((albedo - expected).abs() < 1e-15);
        }
    }
}
