//! What was written: a scene file, entry by entry, as f64 with the place of every value.
//!
//! Nothing here is resolved or legal yet: materials are names, colors keep their notation, meshes
//! are as their file has them, before scale, rotation and translation. [`crate::world`] makes the
//! legal scene from this one; [`crate::oracle`] computes from this one directly.

mod build;
mod curve;
mod delta;
#[doc(hidden)]
pub mod diagnostic;
mod inputs;
mod keys;
mod read;
mod schema;
mod value;

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use build::{NotAColor, Placement};
#[doc(hidden)]
pub use curve::CurveError;
pub use delta::{DEFAULT_DEPTH, Glass, GlassIndex, LARGEST_DEPTH, Metal, Mirror, Pane};
pub use diagnostic::{Diagnostic, Diagnostics, IncludeError, Problem, Span, Spanned};
#[doc(hidden)]
pub use inputs::Input;
pub(crate) use read::name_objection;
#[doc(hidden)]
pub use read::{Broken, Reading};
#[doc(hidden)]
pub use schema::schema;
pub use value::{Falloff, Mixture, ShadowTerminator, Transport, Unit, Value};

pub use keys::Interpolation;
pub use read::{Change, FIRST_FRAME, Motion, Moved};

pub use crate::color::ColorSpace;
use crate::ies::IesFile;
pub use crate::input::Hash;
#[doc(hidden)]
pub use crate::input::{Foreign, NotAFile};
pub use crate::mesh::MeshFile;
use crate::spectrum::Observer;

/// The text that a scene was read from, kept so that errors can show their line.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// The file's path as the user gave it; for the built-in scene a name in angle brackets.
    pub path: PathBuf,
    /// The file's whole text, and behind it those of [`Source::parts`].
    pub text: String,
    /// The files that it includes, and what was set on the command line.
    pub parts: Vec<Part>,
}

/// A text that belongs to a scene beside its file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// What messages call it: the path of an included file, or `--set`.
    pub name: PathBuf,
    /// Where it is in [`Source::text`].
    pub range: Range<usize>,
    /// Whether it was set on the command line, rather than read from a file.
    pub is_set: bool,
}

/// A scene as written.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Where it comes from.
    pub source: Arc<Source>,
    /// Where the camera is at first, if it moves: what stands still has the same numbers at all frames.
    pub anchor: Option<Anchor>,
    /// `[image]`
    pub image: Image,
    /// `[camera.VARIANT]`
    pub camera: Spanned<Camera>,
    /// `[materials.NAME.VARIANT]`, in the order of the file.
    pub materials: Vec<Entry<Material>>,
    /// `[lights.NAME.VARIANT]`, in the order of the file.
    pub lights: Vec<Entry<Light>>,
    /// `[objects.NAME.VARIANT]`, in the order of the file.
    pub objects: Vec<Entry<Object>>,
    /// The included, mesh and curve files that were read, each once, in the order in which the scene names
    /// them first. Empty in a scene made in code.
    pub inputs: Vec<Input>,
}

/// A named entry of a section.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry<T> {
    /// The user's name, unique in its section.
    pub name: String,
    /// The name in the file.
    pub span: Span,
    /// What it names.
    pub value: T,
}

/// `[image]`: what is rendered.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width and height in pixels. Range: 1 to [`MAX_RESOLUTION`] each.
    pub resolution: Spanned<[u32; 2]>,
    /// Working space and EXR space.
    pub color_space: Spanned<ColorSpace>,
    /// Radiance where a ray hits nothing, cd/m². Default 0.
    pub background: Spanned<Value>,
    /// How light is carried along its way. Default [`Transport::Auto`].
    pub transport: Spanned<Transport>,
    /// Whose color matching functions make colors of spectra. Default the 2° observer of 1931.
    pub observer: Spanned<Observer>,
    /// How often light may be reflected by mirrors and refracted by glass on its way to the viewer. Range: 0 to
    /// [`LARGEST_DEPTH`]. Default [`DEFAULT_DEPTH`].
    pub max_depth: Spanned<f64>,
}

/// The largest width and height of an image in pixels: 65 536 square is 69 GB of film.
pub const MAX_RESOLUTION: u32 = 65_536;

/// `[camera.VARIANT]`: where the primary rays start (L1).
#[derive(Clone, Debug, PartialEq)]
pub enum Camera {
    /// `[camera.perspective]`
    Perspective {
        /// The place and direction of the view.
        view: View,
        /// The angle between the lower and the upper edge of the image, in degrees.
        /// Range: above 0, below 180.
        vertical_fov: Spanned<f64>,
    },
    /// `[camera.orthographic]`
    Orthographic {
        /// The place and direction of the view.
        view: View,
        /// The image's vertical extent in scene units. Range: above 0.
        height: Spanned<f64>,
    },
}

/// The view that the numbers of a world depend on, of all that a camera has in a sequence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// Where the camera is.
    pub eye: [f64; 3],
    /// Where it looks: positions are kept relative to this point while they are rendered.
    pub look_at: [f64; 3],
}

/// The place and direction of a camera.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// The viewer's position, or the center of the orthographic image plane.
    pub eye: Spanned<[f64; 3]>,
    /// The point in the middle of the image. Range: not `eye`.
    pub look_at: Spanned<[f64; 3]>,
    /// The direction that is up in the image. Range: not along the view. Default +y.
    pub up: Spanned<[f64; 3]>,
}

/// `[materials.NAME.VARIANT]`: how a surface reflects (L5–L8).
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// `[materials.NAME.phong]`: r = k_d cos(n, ω_i) + k_s cosⁿ(ω_o, ω_r), to the letter.
    Phong(Lobes),
    /// `[materials.NAME.normalized_phong]`:
    /// r = cos(n, ω_i) [ρ_d/π + ρ_s (n+2)/(2π) cosⁿ(ω_o, ω_r)], with ρ_d + ρ_s at most 1.
    NormalizedPhong(Lobes),
    /// `[materials.NAME.mirror]`: L = R L_r, what is seen along the mirrored ray.
    Mirror(Mirror),
    /// `[materials.NAME.metal]`: a mirror whose R is Fresnel's for n + ik.
    Metal(Metal),
    /// `[materials.NAME.glass]`: L = F L_r + (1 − F) L_t, with Fresnel's F.
    Glass(Glass),
    /// `[materials.NAME.pane]`: L = R L_r + T L_t, along the ray itself, by both faces of a thin sheet.
    Pane(Pane),
}

/// The two lobes of a Phong material.
#[derive(Clone, Debug, PartialEq)]
pub struct Lobes {
    /// k_d or ρ_d. Range: 0 or more. Default 0.
    pub diffuse: Spanned<Value>,
    /// k_s or ρ_s. Range: 0 or more. Default 0.
    pub specular: Spanned<Value>,
    /// n. Range: above 0. Needed where `specular` is not 0.
    pub shininess: Option<Spanned<f64>>,
    /// A clear coat over the lobes: L = R L_r + (1 − R) L_lobes. Its reflectance is one number. Default: none.
    pub coat: Option<Mirror>,
}

/// `[lights.NAME.VARIANT]`: where light comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// `[lights.NAME.point]`: a diffuse point light (L3).
    Point {
        /// p_L
        position: Spanned<[f64; 3]>,
        /// I: a number and `[r, g, b]` in candela, a curve in W·sr⁻¹·nm⁻¹. Range: 0 or more.
        intensity: Spanned<Value>,
        /// Lights of one group have one layer, by its name. Default: none.
        group: Option<Spanned<String>>,
    },
    /// `[lights.NAME.spot]`: a point that shines into a cone.
    Spot {
        /// p_L
        position: Spanned<[f64; 3]>,
        /// Where its middle points.
        aim: Aim,
        /// I on the axis: as that of a point light; a flux is what leaves the lamp. Range: 0 or more.
        intensity: Spanned<Value>,
        /// The angle from the axis up to which it has its full intensity, in degrees. Range: 0 to `outer`.
        /// Default 0.
        inner: Spanned<f64>,
        /// The angle from the axis where it is dark, in degrees. Range: 1e-6 to 90.
        outer: Spanned<f64>,
        /// How it falls off between them. Default [`Falloff::Smooth`].
        falloff: Falloff,
        /// Lights of one group have one layer, by its name. Default: none.
        group: Option<Spanned<String>>,
    },
    /// `[lights.NAME.ies]`: a luminaire by its file, a point that sends into each direction what was measured.
    Ies {
        /// p_L
        position: Spanned<[f64; 3]>,
        /// Where vertical angle 0 of the file points.
        aim: Aim,
        /// What horizontal angle 0 is towards, of any length but 0; `None` is y, or where the light goes along
        /// that −z.
        up: Option<Spanned<[f64; 3]>>,
        /// The file as written.
        file: Spanned<String>,
        /// What it holds.
        luminaire: Arc<IesFile>,
        /// I into the brightest direction; a flux is what leaves the luminaire. Where it is not written that of the
        /// file, white. Range: 0 or more.
        intensity: Spanned<Value>,
        /// A factor of all of it. Range: 0 or more. Default 1.
        scale: Spanned<f64>,
        /// Lights of one group have one layer, by its name. Default: none.
        group: Option<Spanned<String>>,
    },
    /// `[lights.NAME.rectangle]`, `[lights.NAME.disk]`, `[lights.NAME.sphere]`: a surface that shines, with the same
    /// luminance everywhere and in all directions.
    Area {
        /// Where it is.
        shape: AreaShape,
        /// L: a number and `[r, g, b]` in cd/m², a curve in W·m⁻²·sr⁻¹·nm⁻¹; a flux is what leaves it, an intensity
        /// that along its normal. Range: 0 or more.
        luminance: Spanned<Value>,
        /// Whether it is seen, and in the way of light. Default true.
        visible: bool,
        /// How many of its points are asked where it is seen in part and no error is asked for. Range: 1 to
        /// [`MAX_LIGHT_SAMPLES`]. Default [`LIGHT_SAMPLES`].
        samples: Spanned<f64>,
        /// Lights of one group have one layer, by its name. Default: none.
        group: Option<Spanned<String>>,
    },
    /// `[lights.NAME.sun]`: parallel light from very far away.
    Sun {
        /// The way that the light goes, a vector of any length but 0.
        direction: Spanned<[f64; 3]>,
        /// E on a surface that faces it: a number and `[r, g, b]` in lux, a curve in W·m⁻²·nm⁻¹. Range: 0 or
        /// more.
        illuminance: Spanned<Value>,
        /// Lights of one group have one layer, by its name. Default: none.
        group: Option<Spanned<String>>,
    },
}

/// The surface of a light.
#[derive(Clone, Debug, PartialEq)]
pub enum AreaShape {
    /// It shines to the side that its axis points to.
    Rectangle {
        /// Its middle.
        center: Spanned<[f64; 3]>,
        /// Along its normal.
        aim: Aim,
        /// What one pair of its sides runs along, of any length but 0; `None` is y, or where the light goes along
        /// that −z.
        up: Option<Spanned<[f64; 3]>>,
        /// Across `up` and along it. Range: above 0.
        size: Spanned<[f64; 2]>,
        /// Whether it shines to the other side too. Default false.
        two_sided: bool,
    },
    /// It shines to the side that its axis points to.
    Disk {
        /// Its middle.
        center: Spanned<[f64; 3]>,
        /// Along its normal.
        aim: Aim,
        /// R. Range: above 0.
        radius: Spanned<f64>,
        /// Whether it shines to the other side too. Default false.
        two_sided: bool,
    },
    /// It shines outwards.
    Sphere {
        /// c
        center: Spanned<[f64; 3]>,
        /// R. Range: above 0.
        radius: Spanned<f64>,
    },
}

/// How many points of a light are asked where it is seen in part, if the scene does not say.
pub const LIGHT_SAMPLES: u32 = 64;

/// The most points of a light that may be asked.
pub const MAX_LIGHT_SAMPLES: u32 = 65_536;

/// Where a light points.
#[derive(Clone, Debug, PartialEq)]
pub enum Aim {
    /// `look_at`: at this point, which is not where the light is.
    LookAt(Spanned<[f64; 3]>),
    /// `direction`: along this vector, of any length but 0.
    Direction(Spanned<[f64; 3]>),
}

impl Light {
    /// How strong it is, where that was written: its intensity, of a sun its illuminance, of an area its luminance.
    pub fn size(&self) -> &Spanned<Value> {
        match self {
            Self::Point { intensity, .. }
            | Self::Spot { intensity, .. }
            | Self::Ies { intensity, .. } => intensity,
            Self::Area { luminance, .. } => luminance,
            Self::Sun { illuminance, .. } => illuminance,
        }
    }

    /// The group that it is in, if any.
    pub fn group(&self) -> Option<&Spanned<String>> {
        match self {
            Self::Point { group, .. }
            | Self::Spot { group, .. }
            | Self::Ies { group, .. }
            | Self::Area { group, .. }
            | Self::Sun { group, .. } => group.as_ref(),
        }
    }

    /// Whether both are seen as the same rectangle, or neither as one.
    pub(crate) fn has_triangles_of(&self, other: &Self) -> bool {
        fn rectangle(light: &Light) -> Option<&AreaShape> {
            match light {
                Light::Area {
                    shape: shape @ AreaShape::Rectangle { .. },
                    visible: true,
                    ..
                } => Some(shape),
                Light::Area { .. }
                | Light::Point { .. }
                | Light::Spot { .. }
                | Light::Ies { .. }
                | Light::Sun { .. } => None,
            }
        }
        rectangle(self) == rectangle(other)
    }

    /// How strong it is, to be changed.
    pub fn size_mut(&mut self) -> &mut Spanned<Value> {
        match self {
            Self::Point { intensity, .. }
            | Self::Spot { intensity, .. }
            | Self::Ies { intensity, .. } => intensity,
            Self::Area { luminance, .. } => luminance,
            Self::Sun { illuminance, .. } => illuminance,
        }
    }
}

impl AreaShape {
    /// Its middle.
    pub fn center(&self) -> &Spanned<[f64; 3]> {
        match self {
            Self::Rectangle { center, .. }
            | Self::Disk { center, .. }
            | Self::Sphere { center, .. } => center,
        }
    }
}

/// `[objects.NAME.VARIANT]`: what light falls on (L2).
#[derive(Clone, Debug)]
pub enum Object {
    /// `[objects.NAME.sphere]`
    Sphere {
        /// The material's name.
        material: Spanned<String>,
        /// c
        center: Spanned<[f64; 3]>,
        /// R. Range: above 0.
        radius: Spanned<f64>,
    },
    /// `[objects.NAME.plane]`, without end.
    Plane {
        /// The material's name.
        material: Spanned<String>,
        /// Any point on the plane.
        point: Spanned<[f64; 3]>,
        /// A direction across it, of any length but 0.
        normal: Spanned<[f64; 3]>,
    },
    /// `[objects.NAME.triangle]`
    Triangle {
        /// The material's name.
        material: Spanned<String>,
        /// The three corners. Range: not on one line.
        vertices: Spanned<[[f64; 3]; 3]>,
    },
    /// `[objects.NAME.mesh]`: v ↦ T R S v, scaled first, then rotated, then moved.
    Mesh {
        /// The material's name.
        material: Spanned<String>,
        /// The file as written, relative to the scene file.
        file: Spanned<PathBuf>,
        /// S: factors along x, y, z. Range: not 0. Default 1.
        scale: Spanned<[f64; 3]>,
        /// R = R_z R_y R_x: degrees about x, then y, then z. Default 0.
        rotate: Spanned<[f64; 3]>,
        /// T: the way moved, in scene units. Default 0.
        translate: Spanned<[f64; 3]>,
        /// Whether vertex normals are used where the file has them. Default true.
        smooth: bool,
        /// Where the shadow rays of a smooth mesh start. Default [`ShadowTerminator::Geometric`].
        shadow_terminator: ShadowTerminator,
        /// What the file holds, shared by all objects that name it.
        geometry: Arc<MeshFile>,
    },
}

impl Object {
    /// Whether both have the same triangles at the same places, or none.
    pub(crate) fn has_triangles_of(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Triangle { vertices: a, .. }, Self::Triangle { vertices: b, .. }) => {
                a.value == b.value
            }
            (
                Self::Mesh {
                    scale,
                    rotate,
                    translate,
                    smooth,
                    shadow_terminator,
                    geometry,
                    ..
                },
                Self::Mesh {
                    scale: other_scale,
                    rotate: other_rotate,
                    translate: other_translate,
                    smooth: other_smooth,
                    shadow_terminator: other_terminator,
                    geometry: other_geometry,
                    ..
                },
            ) => {
                scale.value == other_scale.value
                    && rotate.value == other_rotate.value
                    && translate.value == other_translate.value
                    && smooth == other_smooth
                    && shadow_terminator == other_terminator
                    && Arc::ptr_eq(geometry, other_geometry)
            }
            (
                Self::Sphere { .. } | Self::Plane { .. },
                Self::Sphere { .. } | Self::Plane { .. },
            ) => true,
            (
                Self::Triangle { .. }
                | Self::Mesh { .. }
                | Self::Sphere { .. }
                | Self::Plane { .. },
                _,
            ) => false,
        }
    }

    /// The name of the object's material, where it was written.
    pub fn material(&self) -> &Spanned<String> {
        match self {
            Self::Sphere { material, .. }
            | Self::Plane { material, .. }
            | Self::Triangle { material, .. }
            | Self::Mesh { material, .. } => material,
        }
    }
}

impl Camera {
    /// The camera's place and direction.
    pub fn view(&self) -> &View {
        match self {
            Self::Perspective { view, .. } | Self::Orthographic { view, .. } => view,
        }
    }
}

impl Scene {
    /// Reads a scene file and the meshes that it names.
    ///
    /// # Errors
    /// Everything that is wrong with the file's form, each with its place: syntax, unknown or
    /// missing keys, wrong types, mesh files that cannot be read. Values out of range are found
    /// by [`crate::world::World::new`]; [`crate::world::World::load`] reports both together.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, Diagnostics> {
        Reading::of_file(path.as_ref()).complete()
    }

    /// Reads a scene from text; mesh files are relative to the folder of `path`.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn parse(text: &str, path: impl AsRef<Path>) -> Result<Self, Diagnostics> {
        Reading::of_text(text.to_owned(), path.as_ref()).complete()
    }

    /// The files that the scene was read from: its own, those that it includes, and those of its meshes and curves.
    pub fn files(&self) -> Vec<PathBuf> {
        let inputs = self.inputs.iter().map(|input| input.path.clone());
        std::iter::once(self.source.path.clone())
            .chain(inputs)
            .collect()
    }

    /// Gives the memory of meshes back, once there is a world of it: what is left of each in the scene is empty.
    #[doc(hidden)]
    pub fn release_meshes(&mut self) {
        for entry in &mut self.objects {
            if let Object::Mesh { geometry, .. } = &mut entry.value {
                *geometry = Arc::default();
            }
        }
    }

    /// The scene that is rendered where no file is named: the lecture's.
    pub fn builtin() -> Self {
        let scene = Reading::of_builtin(&[]).complete();
        scene.expect("a test reads the built-in scene")
    }
}

/// The text of the built-in scene.
const BUILTIN: &str = include_str!("../../scenes/lecture.toml");
