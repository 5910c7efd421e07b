//! Scenes made in code: constructors and conversions, so that nobody invents places in a file.
//!
//! Whatever is made here is as legal or not as what a file says: [`World::new`](crate::world::World::new)
//! decides.

use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;

use super::{
    Aim, AreaShape, Camera, ColorSpace, DEFAULT_DEPTH, Entry, Falloff, Glass, GlassIndex, Image,
    LIGHT_SAMPLES, Light, Lobes, Material, Mirror, Object, Pane, Scene, ShadowTerminator, Source,
    Span, Transport, Unit, Value, View,
};
use crate::mesh::MeshFile;
use crate::spectrum::{Curve, Illuminant, Lines, Observer};

impl Scene {
    /// A scene of nothing yet, with its image and camera.
    ///
    /// ```
    /// use candela::scene::{Camera, Image, Light, Material, Object, Scene};
    /// use candela::{Options, World, render};
    ///
    /// // One light of 10 cd, 2 m above a floor: L_o = k_d I/d² = 0.5 · 10 cd / (2 m)² = 1.25 cd/m².
    /// let scene = Scene::new(
    ///     Image::new(9, 9),
    ///     Camera::orthographic([0.0, 1.0, 0.0], [0.0; 3], 9.0).up([0.0, 0.0, -1.0]),
    /// )
    /// .material("chalk", Material::phong(0.5))
    /// .light("lamp", Light::point([0.0, 2.0, 0.0], 10.0))
    /// .object("floor", Object::plane("chalk", [0.0; 3], [0.0, 1.0, 0.0]));
    ///
    /// let (world, camera) = World::new(&scene)?;
    /// let film = render(&world, &camera, &Options::default())?;
    /// assert!((film.pixels()[9 * 4 + 4][0] - 1.25).abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(image: Image, camera: Camera) -> Self {
        let source = Source::new(PathBuf::from("<code>"), String::new());
        Self {
            source: Arc::new(source),
            anchor: None,
            image,
            camera: camera.into(),
            materials: Vec::new(),
            lights: Vec::new(),
            objects: Vec::new(),
            inputs: Vec::new(),
        }
    }

    /// Adds a material. Its name is what objects call it.
    #[must_use]
    pub fn material(mut self, name: impl Into<String>, material: Material) -> Self {
        self.materials.push(Entry::new(name, material));
        self
    }

    /// Adds a light. Its name is that of its layer.
    #[must_use]
    pub fn light(mut self, name: impl Into<String>, light: Light) -> Self {
        self.lights.push(Entry::new(name, light));
        self
    }

    /// Adds an object.
    #[must_use]
    pub fn object(mut self, name: impl Into<String>, object: Object) -> Self {
        self.objects.push(Entry::new(name, object));
        self
    }
}

impl<T> Entry<T> {
    /// `value` under a name, which is unique in its section.
    pub fn new(name: impl Into<String>, value: T) -> Self {
        Self {
            name: name.into(),
            span: Span::default(),
            value,
        }
    }
}

impl Image {
    /// An image of so many pixels, in Rec.709, black where nothing is.
    ///
    /// ```
    /// use candela::scene::{ColorSpace, Image};
    ///
    /// let image = Image::new(1280, 720).color_space(ColorSpace::AcesCg).background(0.5);
    /// assert_eq!(image.resolution.value, [1280, 720]);
    /// ```
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            resolution: [width, height].into(),
            color_space: ColorSpace::default().into(),
            background: Value::ZERO.into(),
            transport: Transport::default().into(),
            observer: Observer::default().into(),
            max_depth: f64::from(DEFAULT_DEPTH).into(),
        }
    }

    /// In another working space.
    #[must_use]
    pub fn color_space(mut self, space: ColorSpace) -> Self {
        self.color_space = space.into();
        self
    }

    /// With a radiance in cd/m² where a ray hits nothing.
    #[must_use]
    pub fn background(mut self, radiance: impl Into<Value>) -> Self {
        self.background = radiance.into().into();
        self
    }

    /// With light carried in this way.
    #[must_use]
    pub fn transport(mut self, transport: Transport) -> Self {
        self.transport = transport.into();
        self
    }

    /// As this observer sees spectra.
    #[must_use]
    pub fn observer(mut self, observer: Observer) -> Self {
        self.observer = observer.into();
        self
    }
}

impl Camera {
    /// A view from `eye` to the point `look_at`, `vertical_fov` degrees high; +y is up.
    ///
    /// ```
    /// use candela::scene::Camera;
    ///
    /// let camera = Camera::perspective([0.0, 1.2, 4.0], [0.0, 0.6, 0.0], 40.0);
    /// assert_eq!(camera.view().up.value, [0.0, 1.0, 0.0]);
    /// ```
    pub fn perspective(eye: [f64; 3], look_at: [f64; 3], vertical_fov: f64) -> Self {
        Self::Perspective {
            view: View::new(eye, look_at),
            vertical_fov: vertical_fov.into(),
        }
    }

    /// Parallel rays from a plane through `eye`, `height` scene units high; +y is up.
    pub fn orthographic(eye: [f64; 3], look_at: [f64; 3], height: f64) -> Self {
        Self::Orthographic {
            view: View::new(eye, look_at),
            height: height.into(),
        }
    }

    /// With another direction that is up in the image.
    #[must_use]
    pub fn up(mut self, up: [f64; 3]) -> Self {
        match &mut self {
            Self::Perspective { view, .. } | Self::Orthographic { view, .. } => view.up = up.into(),
        }
        self
    }
}

impl View {
    fn new(eye: [f64; 3], look_at: [f64; 3]) -> Self {
        Self {
            eye: eye.into(),
            look_at: look_at.into(),
            up: [0.0, 1.0, 0.0].into(),
        }
    }
}

impl Material {
    /// Phong's reflectance with a diffuse lobe alone, k_d.
    ///
    /// ```
    /// use candela::scene::Material;
    ///
    /// let clay = Material::phong([0.7, 0.3, 0.2]).specular(0.3, 50.0);
    /// let chalk = Material::normalized_phong(0.8);
    /// # assert_ne!(clay, chalk);
    /// ```
    pub fn phong(diffuse: impl Into<Value>) -> Self {
        Self::Phong(Lobes::diffuse(diffuse.into()))
    }

    /// Normalized Phong with a diffuse lobe alone, of the albedo ρ_d.
    pub fn normalized_phong(diffuse: impl Into<Value>) -> Self {
        Self::NormalizedPhong(Lobes::diffuse(diffuse.into()))
    }

    /// With a specular lobe, k_s or ρ_s, of the exponent n.
    #[must_use]
    pub fn specular(mut self, specular: impl Into<Value>, shininess: f64) -> Self {
        match &mut self {
            Self::Phong(lobes) | Self::NormalizedPhong(lobes) => {
                lobes.specular = specular.into().into();
                lobes.shininess = Some(shininess.into());
            }
            // These have no lobes.
            Self::Mirror(_) | Self::Metal(_) | Self::Glass(_) | Self::Pane(_) => {}
        }
        self
    }

    /// A perfect mirror of reflectance R.
    ///
    /// ```
    /// use candela::scene::Material;
    ///
    /// let silvered = Material::mirror(0.95);
    /// # assert_ne!(silvered, Material::glass(1.5));
    /// ```
    pub fn mirror(reflectance: impl Into<Value>) -> Self {
        Self::Mirror(Mirror {
            reflectance: reflectance.into().into(),
            schlick: false,
        })
    }

    /// Clear glass of the refractive index n.
    pub fn glass(n: f64) -> Self {
        Self::Glass(Glass {
            index: GlassIndex::Value(Value::Uniform(n).into()),
            absorption: Value::ZERO.into(),
            dispersion: false,
        })
    }

    /// A thin pane of glass of the refractive index n.
    pub fn pane(n: f64) -> Self {
        Self::Pane(Pane { n: n.into() })
    }
}

impl Lobes {
    fn diffuse(diffuse: Value) -> Self {
        Self {
            diffuse: diffuse.into(),
            specular: Value::ZERO.into(),
            shininess: None,
            coat: None,
        }
    }
}

impl Light {
    /// A point light: a number or `[r, g, b]` in candela, or any other [`Value`] of a light.
    ///
    /// ```
    /// use candela::scene::{Light, Value};
    ///
    /// let key = Light::point([3.0, 4.0, 3.0], 30.0);
    /// let bulb = Light::point([0.0, 2.0, 0.0], Value::lumens(800.0, Value::Blackbody(2700.0)));
    /// # assert_ne!(key, bulb);
    /// ```
    pub fn point(position: [f64; 3], intensity: impl Into<Value>) -> Self {
        Self::Point {
            position: position.into(),
            intensity: intensity.into().into(),
            group: None,
        }
    }

    /// A spot that shines from a point to another, into a cone of half-angles in degrees: its full intensity up
    /// to `inner`, nothing from `outer` on.
    ///
    /// ```
    /// use candela::scene::{Light, Value};
    ///
    /// let lamp = Light::spot([0.0, 3.0, 0.0], [0.0, 0.0, 0.0], Value::lumens(800.0, 1.0), [20.0, 30.0]);
    /// # assert_ne!(lamp, Light::point([0.0, 3.0, 0.0], 800.0));
    /// ```
    pub fn spot(
        position: [f64; 3],
        look_at: [f64; 3],
        intensity: impl Into<Value>,
        [inner, outer]: [f64; 2],
    ) -> Self {
        Self::Spot {
            position: position.into(),
            aim: Aim::LookAt(look_at.into()),
            intensity: intensity.into().into(),
            inner: inner.into(),
            outer: outer.into(),
            falloff: Falloff::default(),
            group: None,
        }
    }

    /// A rectangle around a center that shines towards a point: a number or `[r, g, b]` in cd/m², or any other
    /// [`Value`] of such a light. Its size is across y and along it, or where it shines along y, z.
    ///
    /// ```
    /// use candela::scene::{Light, Value};
    ///
    /// let panel = Light::rectangle([0.0, 3.0, 0.0], [0.0; 3], [1.2, 0.6], Value::lumens(4000.0, 1.0));
    /// let globe = Light::sphere([0.0, 3.0, 0.0], 0.15, 5000.0);
    /// # assert_ne!(panel, globe);
    /// ```
    pub fn rectangle(
        center: [f64; 3],
        look_at: [f64; 3],
        size: [f64; 2],
        luminance: impl Into<Value>,
    ) -> Self {
        let shape = AreaShape::Rectangle {
            center: center.into(),
            aim: Aim::LookAt(look_at.into()),
            up: None,
            size: size.into(),
            two_sided: false,
        };
        Self::area(shape, luminance)
    }

    /// A disk around a center that shines towards a point.
    pub fn disk(
        center: [f64; 3],
        look_at: [f64; 3],
        radius: f64,
        luminance: impl Into<Value>,
    ) -> Self {
        let shape = AreaShape::Disk {
            center: center.into(),
            aim: Aim::LookAt(look_at.into()),
            radius: radius.into(),
            two_sided: false,
        };
        Self::area(shape, luminance)
    }

    /// A sphere that shines.
    pub fn sphere(center: [f64; 3], radius: f64, luminance: impl Into<Value>) -> Self {
        let shape = AreaShape::Sphere {
            center: center.into(),
            radius: radius.into(),
        };
        Self::area(shape, luminance)
    }

    /// A surface that shines, and is seen.
    pub fn area(shape: AreaShape, luminance: impl Into<Value>) -> Self {
        Self::Area {
            shape,
            luminance: luminance.into().into(),
            visible: true,
            samples: f64::from(LIGHT_SAMPLES).into(),
            group: None,
        }
    }
}

impl Object {
    /// A sphere of a material.
    pub fn sphere(material: impl Into<String>, center: [f64; 3], radius: f64) -> Self {
        Self::Sphere {
            material: material.into().into(),
            center: center.into(),
            radius: radius.into(),
        }
    }

    /// A plane through a point, without end.
    pub fn plane(material: impl Into<String>, point: [f64; 3], normal: [f64; 3]) -> Self {
        Self::Plane {
            material: material.into().into(),
            point: point.into(),
            normal: normal.into(),
        }
    }

    /// A triangle.
    pub fn triangle(material: impl Into<String>, vertices: [[f64; 3]; 3]) -> Self {
        Self::Triangle {
            material: material.into().into(),
            vertices: vertices.into(),
        }
    }

    /// A mesh, read from a file with [`MeshFile::load`] or made of numbers, where `placement` puts it.
    /// Meshes behind one `Arc` are kept in memory once, as far as the scene goes.
    ///
    /// ```
    /// use candela::scene::{MeshFile, Object, Placement};
    ///
    /// let quad = MeshFile {
    ///     positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
    ///     triangles: vec![[0, 1, 2], [0, 2, 3]],
    ///     ..MeshFile::default()
    /// };
    /// let wall = Object::mesh(
    ///     "chalk",
    ///     quad,
    ///     Placement {
    ///         scale: [4.0, 2.0, 1.0],
    ///         ..Placement::default()
    ///     },
    /// );
    /// assert_eq!(wall.material().value, "chalk");
    /// ```
    pub fn mesh(
        material: impl Into<String>,
        geometry: impl Into<Arc<MeshFile>>,
        placement: Placement,
    ) -> Self {
        let Placement {
            scale,
            rotate,
            translate,
            smooth,
            shadow_terminator,
        } = placement;
        Self::Mesh {
            material: material.into().into(),
            file: PathBuf::new().into(),
            scale: scale.into(),
            rotate: rotate.into(),
            translate: translate.into(),
            smooth,
            shadow_terminator,
            geometry: geometry.into(),
        }
    }
}

/// Where a mesh goes: v ↦ T R S v, scaled first, then rotated, then moved. By default it stays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// S: factors along x, y, z. Range: not 0.
    pub scale: [f64; 3],
    /// R = R_z R_y R_x: degrees about x, then y, then z.
    pub rotate: [f64; 3],
    /// T: the way moved, in scene units.
    pub translate: [f64; 3],
    /// Whether vertex normals are used where the mesh has them.
    pub smooth: bool,
    /// Where shadow rays start and light ends where normals are interpolated.
    pub shadow_terminator: ShadowTerminator,
}

impl Default for Placement {
    fn default() -> Self {
        Self {
            scale: [1.0; 3],
            rotate: [0.0; 3],
            translate: [0.0; 3],
            smooth: true,
            shadow_terminator: ShadowTerminator::default(),
        }
    }
}

impl Value {
    /// Linear red, green and blue of a color space; of Rec.709 `[r, g, b].into()` is enough.
    pub const fn rgb(rgb: [f64; 3], space: ColorSpace) -> Self {
        Self::Rgb { rgb, space }
    }

    /// Light of so many cd, of a color.
    ///
    /// ```
    /// use candela::scene::Value;
    /// use candela::spectrum::Illuminant;
    ///
    /// let value = Value::candela(120.0, Illuminant::D65);
    /// assert!(value.is_spectral());
    /// ```
    pub fn candela(amount: f64, color: impl Into<Self>) -> Self {
        Self::sized(Unit::Candela, amount, color)
    }

    /// Light of so many lm, of a color.
    pub fn lumens(amount: f64, color: impl Into<Self>) -> Self {
        Self::sized(Unit::Lumens, amount, color)
    }

    /// Light of a sun of so many lx, of a color.
    pub fn lux(amount: f64, color: impl Into<Self>) -> Self {
        Self::sized(Unit::Lux, amount, color)
    }

    /// Light of a surface of so many cd/m², of a color.
    pub fn nits(amount: f64, color: impl Into<Self>) -> Self {
        Self::sized(Unit::Nits, amount, color)
    }

    /// Light of so much of a unit, of a color.
    pub fn sized(unit: Unit, amount: f64, color: impl Into<Self>) -> Self {
        Self::Sized {
            unit,
            amount,
            color: Box::new(color.into()),
        }
    }
}

/// The same in every channel.
impl From<f64> for Value {
    fn from(value: f64) -> Self {
        Self::Uniform(value)
    }
}

/// Linear red, green and blue in Rec.709.
impl From<[f64; 3]> for Value {
    fn from(rgb: [f64; 3]) -> Self {
        Self::rgb(rgb, ColorSpace::Rec709)
    }
}

/// The color of an illuminant.
impl From<Illuminant> for Value {
    fn from(illuminant: Illuminant) -> Self {
        Self::Illuminant(illuminant)
    }
}

/// A curve.
impl From<Curve> for Value {
    fn from(curve: Curve) -> Self {
        Self::Curve(Arc::new(curve))
    }
}

/// Light of single wavelengths.
impl From<Lines> for Value {
    fn from(lines: Lines) -> Self {
        Self::Lines(Arc::new(lines))
    }
}

/// A text that is not `#rrggbb`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected `#` and six hexadecimal digits, such as `#c86432`")]
pub struct NotAColor;

/// `#rrggbb`, sRGB-coded, in either case.
///
/// ```
/// use candela::scene::Value;
///
/// let orange: Value = "#c86432".parse()?;
/// assert_eq!(orange, Value::Srgb([200, 100, 50]));
/// assert!("orange".parse::<Value>().is_err());
/// # Ok::<(), candela::scene::NotAColor>(())
/// ```
impl FromStr for Value {
    type Err = NotAColor;

    fn from_str(text: &str) -> Result<Self, NotAColor> {
        super::read::srgb(text).map(Self::Srgb).ok_or(NotAColor)
    }
}
