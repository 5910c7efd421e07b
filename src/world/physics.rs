//! What is legal but physically odd: materials that give more light than they get, lights inside
//! of objects, a scene without light.

use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};
use std::fmt;

use super::contact::touching_glass;
use super::containment::contained;
use super::material::Model;
use super::{Light, Material, Object, Shape, World};
use crate::ies::IesFile;
use crate::math::DVec3;
use crate::printable::counted;
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
    /// Lights are inside of a closed object, so that they light nothing but the inside.
    LightInside {
        /// The name of the first of them.
        light: String,
        /// How many more there are.
        more: usize,
        /// The object's name.
        object: String,
    },
    /// Whether lights are inside of some objects was not looked at: it would take too long.
    NotLookedInto {
        /// How many objects.
        objects: usize,
    },
    /// There is no light: every surface is black.
    NoLight,
    /// A sun is below a plane that everything else is above: it lights nothing of that.
    SunBelow {
        /// The light's name.
        light: String,
        /// The plane's name.
        object: String,
    },
    /// A face of glass lies exactly on one of another object: what is behind both is seen.
    GlassTouches {
        /// The name of the glass.
        glass: String,
        /// The name of the other object.
        object: String,
    },
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
    /// The layer of a light, or of a group, has a name that Blender 4.5 does not read.
    LongLayer {
        /// Its name.
        layer: String,
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
    /// An IES file is not taken as written in places: one of its [remarks](crate::ies::IesRemarks::list).
    MendedLuminaire {
        /// The light's name.
        light: String,
        /// What the file has, how often, and what became of it.
        remark: String,
    },
    /// What leaves a luminaire is not the flux that its file states of its lamps.
    OtherFlux {
        /// The light's name.
        light: String,
        /// The flux of its lamps, in lm.
        rated: f64,
        /// The zonal sum of its table, in lm.
        zonal: f64,
    },
    /// A mesh file is not taken as written in places: one of its
    /// [remarks](crate::mesh::MeshRemarks::list).
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
            Self::LightInside {
                light,
                more: 0,
                object,
            } => write!(f, "light `{light}` is inside of object `{object}`"),
            Self::LightInside {
                light,
                more,
                object,
            } => write!(
                f,
                "light `{light}` and {more} more are inside of object `{object}`"
            ),
            Self::NotLookedInto { objects } => write!(
                f,
                "{} not looked into for lights inside: lights times triangles are too many",
                counted(*objects, "object was", "objects were"),
            ),
            Self::NoLight => write!(f, "the scene has no light, so every surface is black"),
            Self::SunBelow { light, object } => write!(
                f,
                "light `{light}` comes from below plane `{object}`, which hides it from all that is above"
            ),
            Self::GlassTouches { glass, object } => write!(
                f,
                "glass `{glass}` lies exactly on object `{object}`, and what is behind both is seen where they touch; let it \
                 sink in a little, or leave a gap"
            ),
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
            Self::LongLayer { layer } => write!(
                f,
                "the layer `{layer}` of --layers lights has a name of {} bytes; Blender 4.5 drops those of more than \
                 {LONGEST_LAYER} without a word",
                layer.len()
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
            Self::MendedLuminaire { light, remark } => {
                write!(f, "the IES file of light `{light}` has {remark}")
            }
            Self::OtherFlux {
                light,
                rated,
                zonal,
            } => write!(
                f,
                "the IES file of light `{light}` states lamps of {rated:.6} lm, and {zonal:.6} lm leave the luminaire, \
                 {:.1} % of that: an efficiency, or another flux than that of its table",
                zonal / rated * 100.0,
            ),
            Self::Mended { object, remark } => {
                write!(f, "the file of object `{object}` has {remark}")
            }
        }
    }
}

/// By which part the flux that leaves a luminaire may differ from that of its lamps without a word.
const OTHER_FLUX: f64 = 0.05;

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
    warnings.extend(suns_below(world));
    let name = |object: usize| world.objects()[object].name.clone();
    let touching = touching_glass(world).into_iter();
    warnings.extend(touching.map(|[glass, object]| Warning::GlassTouches {
        glass: name(glass),
        object: name(object),
    }));
    warnings.extend(long_layers(world));
    for light in world.lights() {
        if let Light::Ies(luminaire) = &light.value {
            warnings.extend(of_luminaire(&light.name, &luminaire.luminaire));
        }
    }
    let contained = contained(world);
    let mut holders = contained.objects.iter().peekable();
    for (index, object) in world.objects().iter().enumerate() {
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
        if let Some(holder) = holders.next_if(|holder| holder.object == index) {
            warnings.push(Warning::LightInside {
                light: world.lights()[holder.light].name.clone(),
                more: holder.count - 1,
                object: object.name.clone(),
            });
        }
    }
    if contained.unknown > 0 {
        warnings.push(Warning::NotLookedInto {
            objects: contained.unknown,
        });
    }
    warnings
}

/// Suns that planes hide from everything else. What is above of a plane is where other shapes are, or, if there are none,
/// where its normal points.
fn suns_below(world: &World) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let objects = &world.objects()[..world.first_light_object];
    for light in world.lights() {
        let Light::Sun(sun) = &light.value else {
            continue;
        };
        let to_sun = sun.to_light.get();
        for object in objects {
            let Shape::Plane(index) = object.shape else {
                continue;
            };
            let plane = &world.planes()[index];
            let normal = plane.normal.get();
            let towards = if normal.dot(to_sun) < 0.0 {
                -normal
            } else {
                normal
            };
            let height = |place: DVec3| towards.dot(place - plane.point.0);
            let mut others = objects
                .iter()
                .filter(|other| !matches!(other.shape, Shape::Plane(_)));
            let is_lit = |other: &Object| match other.shape {
                Shape::Sphere(index) => {
                    let sphere = &world.spheres()[index];
                    height(sphere.center.0) > -sphere.radius
                }
                Shape::Mesh(index) => {
                    let triangles = world.triangles();
                    let mut own = triangles.meshes()[index].triangles.clone();
                    own.any(|triangle| {
                        let corners = triangles.vertices(triangle);
                        corners.into_iter().any(|corner| height(corner) > 0.0)
                    })
                }
                Shape::Disk(_) | Shape::Plane(_) => false,
            };
            let is_above = if others.clone().next().is_none() {
                normal.dot(to_sun) >= 0.0
            } else {
                others.any(is_lit)
            };
            if !is_above {
                warnings.push(Warning::SunBelow {
                    light: light.name.clone(),
                    object: object.name.clone(),
                });
            }
        }
    }
    warnings
}

/// Bytes of the longest name of a layer that Blender 4.5 reads, by trial.
const LONGEST_LAYER: usize = 57;

/// Layers of lights and groups with longer names, each once.
fn long_layers(world: &World) -> impl Iterator<Item = Warning> {
    let lights = world.lights().iter().enumerate();
    let names = lights.map(|(light, entry)| world.light_group(light).unwrap_or(&entry.name));
    let layers = names.map(|name| format!("light_{name}"));
    let long: BTreeSet<String> = layers.filter(|layer| layer.len() > LONGEST_LAYER).collect();
    long.into_iter().map(|layer| Warning::LongLayer { layer })
}

/// What is to be said of the file of a luminaire.
fn of_luminaire(name: &str, file: &IesFile) -> Vec<Warning> {
    let remarks = file.remarks.list().into_iter();
    let mended = remarks.map(|remark| Warning::MendedLuminaire {
        light: name.to_owned(),
        remark,
    });
    let zonal = file.photometry.zonal_lumens();
    let other = file.rated_lumens().filter(|rated| {
        let is_told = *rated > 0.0;
        is_told && (zonal / rated - 1.0).abs() > OTHER_FLUX
    });
    let other = other.map(|rated| Warning::OtherFlux {
        light: name.to_owned(),
        rated,
        zonal,
    });
    mended.chain(other).collect()
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
        warning(
            format!("light `{}`", light.name),
            light.value.intensity().0.0,
        )
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
        let world = World::new(&Scene::parse(&text, "scene.toml").unwrap())
            .unwrap()
            .0;
        let found = warnings(&world).into_iter().map(|warning| match warning {
            Warning::LightInside {
                light,
                object,
                more,
            } => (object, light, more),
            other => panic!("{other}"),
        });
        let found: Vec<_> = found.collect();
        let mut expected = Vec::new();
        for (sphere, center) in [(0, -1.0), (1, 0.0), (2, 1.3)] {
            let is_inside = |&light: &i32| {
                let x = f64::from(light * 17 % 40) / 10.0 - 1.95;
                f64::hypot(x - center, 0.1) < 0.5
            };
            let inside: Vec<i32> = (0..40).filter(is_inside).collect();
            let first = format!("l{}", inside[0]);
            expected.push((format!("s{sphere}"), first, inside.len() - 1));
        }
        assert_eq!(found, expected);
    }

    /// A sun below a floor is told, with something on the floor or without, however its normal points; one above is not.
    #[test]
    fn suns_below_planes_are_told() {
        for (sun, normal, ball, is_below) in [
            ([0.2, -1.0, 0.1], [0.0, 1.0, 0.0], "", false),
            ([0.2, 1.0, 0.1], [0.0, 1.0, 0.0], "", true),
            ([0.2, 1.0, 0.1], [0.0, -2.0, 0.0], "", false),
            (
                [0.2, 1.0, 0.1],
                [0.0, -2.0, 0.0],
                "[objects.b.sphere]\nmaterial = 'm'\ncenter = [0, 1, 0]\nradius = 1",
                true,
            ),
            (
                [0.2, -1.0, 0.1],
                [0.0, -2.0, 0.0],
                "[objects.b.sphere]\nmaterial = 'm'\ncenter = [0, 1, 0]\nradius = 1",
                false,
            ),
            // A part of it is below the floor.
            (
                [0.2, 1.0, 0.1],
                [0.0, 1.0, 0.0],
                "[objects.b.sphere]\nmaterial = 'm'\ncenter = [0, 1, 0]\nradius = 1.1",
                false,
            ),
        ] {
            let text = format!(
                "[image]\nresolution = [1, 1]\n[camera.orthographic]\neye = [0, 9, 9]\nlook_at = [0, 0, 0]\n\
                 height = 1\n[materials.m.phong]\n[lights.l.sun]\ndirection = {sun:?}\nilluminance = 1\n\
                 [objects.f.plane]\nmaterial = 'm'\npoint = [0, 0, 0]\nnormal = {normal:?}\n{ball}\n"
            );
            let world = World::new(&Scene::parse(&text, "scene.toml").unwrap())
                .unwrap()
                .0;
            let expected = is_below.then(|| Warning::SunBelow {
                light: "l".to_owned(),
                object: "f".to_owned(),
            });
            assert_eq!(warnings(&world), Vec::from_iter(expected), "{text}");
        }
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
