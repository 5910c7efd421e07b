//! Lights with an area: their surfaces, and the objects that those which are seen are.

use std::sync::Arc;

use glam::DVec3;

use super::color::{Emission, Spread};
use super::{Builder, Reported, listed};
use crate::emitter::{Emitter, Surface};
use crate::math::{Normal, Point};
use crate::printable::printable;
use crate::scene::{self, AreaShape, LIGHT_SAMPLES, MAX_LIGHT_SAMPLES, Problem, Spanned};
use crate::spectrum::Spectrum;
use crate::units::{Intensity, Rgb};
use crate::world::geometry::{Disk, Sphere};
use crate::world::light::{AreaLight, Light};
use crate::world::{Object, Shape, World};

impl Builder<'_> {
    /// A light with an area, and its spectrum. After an error the world is dropped.
    pub(super) fn area_light(
        &mut self,
        shape: &AreaShape,
        luminance: &Spanned<scene::Value>,
        is_visible: bool,
        samples: Spanned<f64>,
    ) -> (Light, Option<Spectrum>) {
        let emitter = self.emitter(shape);
        let samples = self.samples(samples);
        let emitter = emitter.unwrap_or_else(|Reported| {
            Emitter::sphere(Point(DVec3::ZERO), 1.0).expect("1 is a radius")
        });
        let spread = Spread {
            flux: emitter.flux(),
            intensity: emitter.intensity(),
        };
        let Emission { rgb, spectrum } = self.emission("luminance", luminance, spread);
        let area = emitter.intensity();
        let light = AreaLight {
            emitter,
            intensity: Intensity(Rgb(rgb.map(|channel| channel * area))),
            is_visible,
            samples,
        };
        let spectrum = spectrum.map(|spectrum| spectrum.scaled(area));
        (Light::Area(light), spectrum)
    }

    fn samples(&mut self, written: Spanned<f64>) -> u32 {
        let legal = |count: f64| {
            (1.0..=f64::from(MAX_LIGHT_SAMPLES)).contains(&count) && count.fract() == 0.0
        };
        let count = self.number(
            "samples",
            written,
            legal,
            "a whole number of points from 1 to 65536",
        );
        count.map_or(LIGHT_SAMPLES, |count| count as u32)
    }

    fn emitter(&mut self, shape: &AreaShape) -> Result<Emitter, Reported> {
        match *shape {
            AreaShape::Rectangle {
                center,
                ref aim,
                up,
                size,
                two_sided,
            } => {
                let place = self.position("center", center);
                let axis = self.axis("center", center, aim);
                let sizes = self.sides(size);
                let axis = axis?;
                let up = self.up(axis, up);
                let (place, [across, along], up) = (place?, sizes?, up?);
                let normal = axis.get();
                let up = (up - normal * up.dot(normal)).normalize();
                let side = normal.cross(up);
                // Their cross product is the axis.
                let halves = [up * (0.5 * along), side * (0.5 * across)];
                Ok(Emitter::rectangle(place, halves, two_sided).expect("it has an area"))
            }
            AreaShape::Disk {
                center,
                ref aim,
                radius,
                two_sided,
            } => {
                let place = self.position("center", center);
                let axis = self.axis("center", center, aim);
                let length = self.extent("radius", radius);
                let normal = Normal::new(axis?.get()).expect("an axis has a length");
                Ok(Emitter::disk(place?, normal, length?, two_sided).expect("it has an area"))
            }
            AreaShape::Sphere { center, radius } => {
                let place = self.position("center", center);
                let length = self.extent("radius", radius);
                let (place, length) = (place?, length?);
                self.check_radius(place, length, radius)?;
                Ok(Emitter::sphere(place, length).expect("it has an area"))
            }
        }
    }

    /// The two lengths of a rectangle.
    fn sides(&mut self, written: Spanned<[f64; 2]>) -> Result<[f64; 2], Reported> {
        let legal = |length: &f64| LENGTHS.contains(length);
        if written.value.iter().all(legal) {
            return Ok(written.value);
        }
        self.out_of_range(
            "size",
            written.span,
            listed(&written.value),
            "two lengths from 1e-15 to 1e15, in scene units",
        );
        Err(Reported)
    }

    fn extent(&mut self, key: &'static str, written: Spanned<f64>) -> Result<f64, Reported> {
        let expected = "a length from 1e-15 to 1e15, in scene units";
        self.number(key, written, |length| LENGTHS.contains(&length), expected)
    }

    /// The lights that are seen are objects of their own, behind those of the scene: black, but for what they send.
    pub(super) fn light_objects(
        &mut self,
        world: &mut World,
        mut material: impl FnMut(
            &mut Self,
            &mut World,
            &scene::Entry<scene::Material>,
        ) -> Result<(), Reported>,
    ) {
        world.first_light_object = world.objects.len();
        for (index, entry) in self.scene.lights.iter().enumerate() {
            let Some(Light::Area(light)) = world.lights.get(index).map(|light| &light.value) else {
                continue;
            };
            if !light.is_visible || self.is_out_of_memory {
                continue;
            }
            let emitter = light.emitter;
            self.entry = Some(super::Entry::Named("light", &entry.name));
            if let Some(object) = self.scene.objects.iter().find(|it| it.name == entry.name) {
                let conflict = format!(
                    "there is an object `{}` as well as a light that is seen, whose mattes would have one name, \
                     expected another name for one of them",
                    printable(&object.name)
                );
                self.report(entry.span, Problem::Conflict(conflict));
                continue;
            }
            // Only the shape is needed of it: it reflects nothing.
            let black = scene::Entry {
                name: entry.name.clone(),
                span: entry.span,
                value: scene::Material::phong(0.0),
            };
            if material(self, world, &black).is_err()
                || self.reserve(&mut world.objects, 1).is_err()
            {
                return;
            }
            let Ok(shape) = self.shape_of(&emitter, world, entry.span) else {
                continue;
            };
            world.objects.push(Object {
                name: entry.name.clone(),
                material: world.materials.len() - 1,
                shape,
                emits: Some(index),
            });
        }
        self.entry = None;
    }

    fn shape_of(
        &mut self,
        emitter: &Emitter,
        world: &mut World,
        span: scene::Span,
    ) -> Result<Shape, Reported> {
        let object = world.objects.len() as u32;
        match emitter.surface() {
            // Where no triangle has moved, they are in the world already.
            Surface::Rectangle(_) if self.kept.is_some() => {
                self.kept_meshes += 1;
                Ok(Shape::Mesh(self.kept_meshes - 1))
            }
            Surface::Rectangle([a, b, c, d]) => {
                let first = world.triangles.len();
                let triangles = Arc::make_mut(&mut world.triangles);
                self.rectangle([a, b, c, d], object, span, triangles)?;
                self.check_triangles(world, first, "size", span)?;
                Ok(Shape::Mesh(world.triangles.meshes.len() - 1))
            }
            Surface::Disk { normal, radius } => {
                let disk = Disk {
                    center: emitter.center(),
                    normal,
                    radius,
                    object,
                };
                self.check_disk(&disk, Spanned::new(radius, span))?;
                self.reserve(&mut world.disks, 1)?;
                world.disks.push(disk);
                Ok(Shape::Disk(world.disks.len() - 1))
            }
            Surface::Sphere { radius } => {
                self.reserve(&mut world.spheres, 1)?;
                world.spheres.push(Sphere {
                    center: emitter.center(),
                    radius,
                    object,
                });
                Ok(Shape::Sphere(world.spheres.len() - 1))
            }
        }
    }
}

/// The lengths of a light, in scene units: squares and reciprocals of areas are far within f64.
const LENGTHS: std::ops::RangeInclusive<f64> = 1e-15..=1e15;
