//! What is legal: a scene resolved and validated, ready to render.
//!
//! [`World::new`] is the only way in. Behind it nothing is missing, out of range or a name to look
//! up: materials are indices, values are linear RGB in the working space, meshes are transformed
//! triangles. Positions are kept in f64 relative to an [anchor](World::anchor), the point that the
//! scene's camera looks at, so that a scene far from the origin renders like one at the origin.
//!
//! A world has no camera: [`World::new`] gives the scene's beside it, and [`World::place`] places others.
//! The anchor is the scene's, whatever camera looks: a camera that is moved in a world shows
//! the bits that it shows in a world that was made anew.

#[doc(hidden)]
pub mod body;
mod brightness;
mod build;
mod chains;
#[doc(hidden)]
pub mod colorimetry;
mod contact;
mod containment;
#[doc(hidden)]
pub mod delta;
#[doc(hidden)]
pub mod difference;
pub(crate) mod geometry;
#[doc(hidden)]
pub mod light;
#[doc(hidden)]
pub mod material;
pub(crate) mod panes;
#[doc(hidden)]
pub mod physics;
#[doc(hidden)]
pub mod plan;
mod reflectances;
#[doc(hidden)]
pub mod spectra;

use std::path::Path;
use std::sync::Arc;

#[doc(hidden)]
pub use body::Body;
pub(crate) use body::Media;
#[doc(hidden)]
pub use delta::Delta;
#[doc(hidden)]
pub use geometry::{Disk, Mesh, MeshNormals, Plane, Sphere, Triangles};
#[doc(hidden)]
pub use light::{AreaLight, Light, PointLight, SpotLight};
#[doc(hidden)]
pub use material::Material;
#[doc(hidden)]
pub use plan::Plan;
#[doc(hidden)]
pub use reflectances::{ReflectanceTerm, Reflectances};
pub(crate) use spectra::RecentProducts;
pub use spectra::Wavelengths;
#[doc(hidden)]
pub use spectra::{Bands, Spectra};

use crate::camera::Camera;
use crate::math::DVec3;
use crate::scene::{self, ColorSpace, Diagnostics, Reading, Scene};
use crate::spectrum::{Observer, Spectrum};
use crate::units::{Radiance, ReflectedIntensity, Rgb};
pub(crate) use chains::{Chain, ChainColor, Chains};
use spectra::Products;

/// A legal scene.
#[derive(Clone, Debug)]
pub struct World {
    /// SHA-256 of the scene file's text, in hexadecimal digits.
    scene_hash: String,
    /// SHA-256 of all that the picture depends on, in hexadecimal digits.
    inputs_hash: String,
    /// What was set on the command line.
    set: Vec<String>,
    color_space: ColorSpace,
    background: Radiance,
    anchor: DVec3,
    materials: Vec<Named<Material>>,
    /// What each of them reflects like a mirror or lets through.
    deltas: Vec<Option<Delta>>,
    /// Whether one of these is a coat.
    has_coats: bool,
    /// Whether any object is perfectly smooth.
    has_deltas: bool,
    /// Whether any of these is a pane.
    has_panes: bool,
    /// Whether any of these disperses light, which is carried spectrally.
    has_dispersion: bool,
    bodies: Vec<Body>,
    /// The place among them of each object, `u32::MAX` of what is none.
    body_ranks: Vec<u32>,
    /// How often light is followed through mirrors and glass.
    max_depth: u32,
    lights: Vec<Named<Light>>,
    /// The group of each.
    light_groups: Vec<Option<String>>,
    objects: Vec<Object>,
    /// From here on objects are lights that are seen.
    first_light_object: usize,
    spheres: Vec<Sphere>,
    planes: Vec<Plane>,
    /// No object of a scene is one.
    disks: Vec<Disk>,
    /// Shared by the frames of a sequence in which none moves.
    triangles: Arc<Triangles>,
    /// I · k of every light on every material, where light is carried spectrally.
    products: Option<Products>,
    asked: scene::Transport,
    observer: Observer,
    /// What in the scene is spectral.
    spectral_values: Vec<String>,
    spectra: Option<Spectra>,
    /// What colored mirrors leave of light, where it is carried spectrally.
    chains: Option<Chains>,
    /// How the observer sees light, in the working space.
    colorimetry: Arc<colorimetry::Colorimetry>,
    /// The curves that leave out a part of the visible range, by the names of their entries, with
    /// their ranges in nm.
    gaps: Vec<Named<[f64; 2]>>,
}

/// A scene file as it was read, and what was made of it.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// What was written.
    pub scene: Scene,
    /// What is legal.
    pub world: World,
    /// The scene's camera.
    pub camera: Camera,
    /// What of the scene moves.
    pub motion: scene::Motion,
}

/// Something with the name that the user gave it.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq)]
pub struct Named<T> {
    /// The user's name.
    pub name: String,
    /// What it names.
    pub value: T,
}

/// One quantity for each lobe of a material (L8).
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lobes<T> {
    /// Of the diffuse lobe (L5).
    pub diffuse: T,
    /// Of the specular lobe (L7).
    pub specular: T,
}

/// An object: its name, what it is made of and what it became.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// The user's name.
    pub name: String,
    /// Its material, an index into [`World::materials`].
    pub material: usize,
    /// Its shape, an index into the array of its kind.
    pub shape: Shape,
    /// The light that it is, an index into [`World::lights`]; `None` for what reflects.
    pub emits: Option<usize>,
}

/// Where the shape of an object is kept.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// An index into [`World::spheres`].
    Sphere(usize),
    /// An index into [`World::planes`].
    Plane(usize),
    /// An index into [`World::disks`].
    Disk(usize),
    /// An index into [`Triangles::meshes`]; a single triangle is a mesh of one.
    Mesh(usize),
}

impl World {
    /// Validates a scene: its world, and the camera that the scene has in it.
    ///
    /// # Errors
    /// Every value that is out of range, every name that is not there, and a scene without
    /// objects, each with its place.
    pub fn new(scene: &Scene) -> Result<(Self, Camera), Diagnostics> {
        build::world(scene)
    }

    /// The world of another frame of the same scene, in which this has changed: the same as [`World::new`] makes,
    /// sooner where no triangle moves.
    ///
    /// # Errors
    /// As [`World::new`].
    #[doc(hidden)]
    pub fn again(
        &self,
        scene: &Scene,
        change: scene::Change,
    ) -> Result<(Self, Camera), Diagnostics> {
        build::world_again(scene, change, self)
    }

    /// Another camera in this world, with the width and height of its image in pixels. Nothing is
    /// built for it.
    ///
    /// ```
    /// use candela::scene::Camera;
    /// use candela::{Options, Scene, World, render};
    ///
    /// let (world, camera) = World::new(&Scene::builtin())?;
    /// let above = Camera::perspective([0.0, 6.0, 0.1], [0.0; 3], 40.0);
    /// let above = world.place(&above, [64, 36])?;
    /// assert_eq!(above.anchor(), camera.anchor());
    /// let film = render(&world, &above, &Options::default())?;
    /// assert_eq!(film.pixels().len(), 64 * 36);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Every value that is out of range.
    pub fn place(
        &self,
        camera: &scene::Camera,
        resolution: [u32; 2],
    ) -> Result<Camera, Diagnostics> {
        build::place(camera, resolution, self.anchor)
    }

    /// Reads a scene file and validates it; what is wrong with its form and with its values is
    /// reported together.
    ///
    /// # Errors
    /// As [`Scene::load`] and [`World::new`].
    pub fn load(path: impl AsRef<Path>) -> Result<Loaded, Diagnostics> {
        Self::load_with(path, |_| {})
    }

    /// [`World::load`] of a scene in which something is changed between reading and validating,
    /// such as its [transport](scene::Image::transport).
    ///
    /// # Errors
    /// As [`World::load`].
    pub fn load_with(
        path: impl AsRef<Path>,
        change: impl FnOnce(&mut Scene),
    ) -> Result<Loaded, Diagnostics> {
        Self::of_reading(Reading::of_file(path.as_ref()), change)
    }

    /// The legal scene of what was read, in which something is changed before it is validated.
    ///
    /// # Errors
    /// As [`World::load`].
    pub fn of_reading(
        mut reading: Reading,
        change: impl FnOnce(&mut Scene),
    ) -> Result<Loaded, Diagnostics> {
        if let Some(scene) = &mut reading.scene {
            change(scene);
        }
        build::world_of_reading(reading)
    }

    /// SHA-256 of the scene file's text, in hexadecimal digits, as `sha256sum` prints it; of a scene
    /// made in code, of its content ([`Scene::hash`]).
    pub fn scene_hash(&self) -> &str {
        &self.scene_hash
    }

    /// SHA-256 of the scene file with the meshes and curves that it names, in hexadecimal digits
    /// ([`Scene::inputs_hash`]).
    pub fn inputs_hash(&self) -> &str {
        &self.inputs_hash
    }

    /// The values of the scene that were set on the command line, as they were written there.
    #[doc(hidden)]
    pub fn set(&self) -> &[String] {
        &self.set
    }

    /// The working space, in which all colors of the world are.
    pub fn color_space(&self) -> ColorSpace {
        self.color_space
    }

    /// Radiance where a ray hits nothing.
    #[doc(hidden)]
    pub fn background(&self) -> Radiance {
        self.background
    }

    /// What is subtracted from every position of the scene, in f64: the `look_at` of the scene's own camera.
    pub fn anchor(&self) -> DVec3 {
        self.anchor
    }

    /// The materials in the order of the file.
    #[doc(hidden)]
    pub fn materials(&self) -> &[Named<Material>] {
        &self.materials
    }

    /// What a material reflects like a mirror or lets through, if it does.
    #[inline]
    #[doc(hidden)]
    pub fn delta(&self, material: usize) -> Option<&Delta> {
        self.deltas[material].as_ref()
    }

    /// Whether any object is perfectly smooth.
    #[doc(hidden)]
    pub fn has_deltas(&self) -> bool {
        self.has_deltas
    }

    /// Whether light may be dispersed at the boundary of a body of this material: it is of glass, whatever glass is on the
    /// other side of it.
    pub(crate) fn may_disperse(&self, material: usize) -> bool {
        self.has_dispersion && matches!(self.deltas[material], Some(Delta::Glass(_)))
    }

    /// Whether any body of glass disperses light.
    #[inline]
    pub(crate) fn has_dispersion(&self) -> bool {
        self.has_dispersion
    }

    /// Whether any material is a thin pane, which light passes.
    #[inline]
    pub(crate) fn has_panes(&self) -> bool {
        self.has_panes
    }

    /// Whether a shape, as visibility names it, is a pane.
    pub(crate) fn is_pane(&self, object: u32) -> bool {
        self.has_panes && {
            let material = self.objects[object as usize].material;
            matches!(self.deltas[material], Some(Delta::Pane { .. }))
        }
    }

    /// Whether any material has a coat.
    #[inline]
    pub(crate) fn has_coats(&self) -> bool {
        self.has_coats
    }

    /// How often light is followed through mirrors and glass.
    #[doc(hidden)]
    pub fn max_depth(&self) -> u32 {
        self.max_depth
    }

    /// The lights in the order of the file, which is the order of the sum (L9).
    #[doc(hidden)]
    pub fn lights(&self) -> &[Named<Light>] {
        &self.lights
    }

    /// The luminous intensity of a light in cd, of a spot on its axis.
    #[doc(hidden)]
    pub fn candelas(&self, light: usize) -> f64 {
        match &self.spectra {
            Some(spectra) => spectra.colorimetry().luminous(spectra.light(light)),
            None => {
                let weights = self.color_space.primaries().luminance_weights();
                let intensity = self.lights[light].value.intensity().0.0;
                let channels = intensity.iter().zip(weights);
                channels.map(|(channel, weight)| channel * weight).sum()
            }
        }
    }

    /// How light is carried: `rgb` or `spectral`.
    #[doc(hidden)]
    pub fn transport(&self) -> &'static str {
        match self.spectra {
            Some(_) => scene::Transport::Spectral.name(),
            None => scene::Transport::Rgb.name(),
        }
    }

    /// Whose eye sees spectra.
    #[doc(hidden)]
    pub fn observer(&self) -> Observer {
        self.observer
    }

    /// The lights as JSON, for who renders them with other intensities: names, groups, kinds, luminous intensities in
    /// cd, intensities in cd per primary of the working space, and of those with an area whether they are seen.
    #[doc(hidden)]
    pub fn describe_lights(&self) -> String {
        let lights = self.lights.iter().enumerate().map(|(light, entry)| {
            let mut description = serde_json::json!({
                "name": entry.name,
                "kind": entry.value.kind(),
                "group": self.light_group(light),
                "candela": self.candelas(light),
                "rgb": entry.value.intensity().0.0,
            });
            if entry.value.area().is_some() {
                let mut objects = self.objects.iter();
                description["visible"] = objects.any(|object| object.emits == Some(light)).into();
            }
            description
        });
        serde_json::Value::from_iter(lights).to_string()
    }

    /// The group of a light, if it has one.
    #[doc(hidden)]
    pub fn light_group(&self, light: usize) -> Option<&str> {
        self.light_groups[light].as_deref()
    }

    /// Whether any light is seen itself.
    #[inline]
    pub(crate) fn has_emission(&self) -> bool {
        self.first_light_object < self.objects.len()
    }

    /// The light that a point of an object is on, where it is seen from the side that shines.
    #[inline]
    pub(crate) fn emitter_seen(
        &self,
        object: u32,
        point: crate::math::Point,
        to_viewer: DVec3,
    ) -> Option<(usize, &AreaLight)> {
        if (object as usize) < self.first_light_object {
            return None;
        }
        let index = self.objects[object as usize].emits?;
        let light = self.lights[index].value.area()?;
        light
            .emitter
            .shines_along(point, to_viewer)
            .then_some((index, light))
    }

    /// The objects in the order of the file, behind them the lights that are seen, which settles ties between surfaces.
    #[doc(hidden)]
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// All spheres, in the order of the objects.
    #[doc(hidden)]
    pub fn spheres(&self) -> &[Sphere] {
        &self.spheres
    }

    /// All planes, in the order of the objects.
    #[doc(hidden)]
    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// All disks, in the order of the objects.
    #[doc(hidden)]
    pub fn disks(&self) -> &[Disk] {
        &self.disks
    }

    /// Adds a disk as the last object, of the first material.
    #[cfg(test)]
    pub(crate) fn add_disk(&mut self, center: DVec3, normal: DVec3, radius: f64) {
        self.disks.push(Disk {
            center: crate::math::Point(center),
            normal: crate::math::Normal::new(normal).expect("a direction"),
            radius,
            object: self.objects.len() as u32,
        });
        self.objects.push(Object {
            name: format!("disk{}", self.disks.len()),
            material: 0,
            shape: Shape::Disk(self.disks.len() - 1),
            emits: None,
        });
    }

    /// All triangles, in the order of the objects.
    #[doc(hidden)]
    pub fn triangles(&self) -> &Triangles {
        &self.triangles
    }

    /// The same, to be kept beside the world.
    pub(crate) fn shared_triangles(&self) -> &Arc<Triangles> {
        &self.triangles
    }

    /// What the scene asks for about the way of light.
    #[doc(hidden)]
    pub fn transport_asked(&self) -> scene::Transport {
        self.asked
    }

    /// What in the scene is spectral, as people name it: "light `key`", …
    #[doc(hidden)]
    pub fn spectral_values(&self) -> &[String] {
        &self.spectral_values
    }

    /// The spectra of lights and materials; `None` where light is carried as RGB.
    #[doc(hidden)]
    pub fn spectra(&self) -> Option<&Spectra> {
        self.spectra.as_ref()
    }

    /// The curves that leave out a part of the visible range, by the names of their entries, with
    /// their ranges in nm.
    #[doc(hidden)]
    pub fn gaps(&self) -> &[Named<[f64; 2]>] {
        &self.gaps
    }

    /// T: I · k of both lobes of a reflectance, that of a material, lit by a light. Zero for a material that no
    /// object has, where light is carried spectrally.
    ///
    /// Where light is carried as RGB, it is the product of three numbers, made when it is asked for; where it
    /// is spectral, an integral, made when it is first asked for. Whenever and wherever it is made, it has the
    /// same bits.
    #[inline]
    #[doc(hidden)]
    pub fn reflected(&self, light: usize, material: usize) -> Lobes<ReflectedIntensity> {
        self.reflected_from(light, None)(material)
    }

    /// [`World::reflected`] of one light, for each material that is asked for. Products that no table has room
    /// for are kept in `recent`, if that is there.
    #[inline(always)]
    pub(crate) fn reflected_from<'w>(
        &'w self,
        light: usize,
        mut recent: Option<&'w mut RecentProducts>,
    ) -> impl FnMut(usize) -> Lobes<ReflectedIntensity> + 'w {
        let products = self.products.as_ref();
        let intensity = self.lights[light].value.intensity();
        #[inline(always)]
        move |material| match products {
            Some(products) => match products.known(light, material) {
                Some(product) => *product,
                None => self.integrated(products, light, material, recent.as_deref_mut()),
            },
            None => {
                let reflectance = self.materials[material].value.reflectance();
                Lobes {
                    diffuse: intensity.reflected(reflectance.diffuse),
                    specular: intensity.reflected(reflectance.specular),
                }
            }
        }
    }

    /// [`World::reflected`] of light that goes through a filter on its way to the viewer. Only where light is carried
    /// spectrally.
    pub(crate) fn reflected_through(
        &self,
        light: usize,
        material: usize,
        filter: &Spectrum,
    ) -> Lobes<ReflectedIntensity> {
        let spectra = self.spectra.as_ref().expect("filters are of spectra");
        spectra.filtered_product(light, material, filter)
    }

    /// R, G, B of a reflectance under white light.
    pub(crate) fn color_of_reflectance(&self, reflectance: &Spectrum) -> [f64; 3] {
        self.colorimetry.reflectance(reflectance)
    }

    /// The background as it is seen through a filter.
    pub(crate) fn background_through(&self, filter: &Spectrum) -> Radiance {
        let spectra = self.spectra.as_ref().expect("filters are of spectra");
        Radiance(Rgb(spectra.filtered(&spectra.background, filter)))
    }

    /// The luminance of a light with an area as it is seen through a filter.
    pub(crate) fn luminance_through(
        &self,
        light: usize,
        area: &AreaLight,
        filter: &Spectrum,
    ) -> [f64; 3] {
        let spectra = self.spectra.as_ref().expect("filters are of spectra");
        let intensity = spectra.filtered(spectra.light(light), filter);
        intensity.map(|channel| channel * area.over_area())
    }

    /// A product that is not known yet.
    #[cold]
    #[inline(never)]
    fn integrated(
        &self,
        products: &Products,
        light: usize,
        material: usize,
        recent: Option<&mut RecentProducts>,
    ) -> Lobes<ReflectedIntensity> {
        let spectra = self.spectra.as_ref();
        let spectra = spectra.expect("products are of spectra");
        let intensity = self.lights[light].value.intensity();
        let integrate = || spectra.product(light, intensity, material);
        products.make(light, material, recent, integrate)
    }

    /// Bytes of the table of I · k of lights and materials; `None` where light is carried as RGB,
    /// which takes none, 0 where a table would be too large, and products are made where they are needed.
    #[doc(hidden)]
    pub fn products_memory(&self) -> Option<u64> {
        self.products.as_ref().map(Products::memory)
    }

    /// Has products made where they are needed, as if there were too many for a table.
    #[cfg(test)]
    pub(crate) fn drop_table(&mut self) {
        if let Some(products) = &mut self.products {
            products.drop_table();
        }
    }

    /// The materials that objects have, as indices into [`World::materials`], ascending.
    #[doc(hidden)]
    pub fn used_materials(&self) -> Vec<usize> {
        let mut used = vec![false; self.materials.len()];
        for object in &self.objects {
            used[object.material] = true;
        }
        let used = used.into_iter().enumerate();
        used.filter_map(|(material, is_used)| is_used.then_some(material))
            .collect()
    }
}
