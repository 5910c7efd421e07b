//! Facts about the equations, on scenes that are built here value by value.

mod area;
mod delta;
mod geometry;
mod invariance;
mod light;
mod panes;
mod slivers;
mod visibility;

use std::sync::Arc;

use super::{LightTerms, Oracle};
use crate::mesh::{MeshFile, MeshNormals, MeshRemarks};
use crate::scene::{
    Camera, Entry, Image, Light, Lobes, Material, Object, Scene, ShadowTerminator, Source, Span,
    Spanned, Transport, Value, View,
};
use crate::spectrum::Observer;

/// A closed form and its transcription differ by a few roundings of f64.
const ROUNDING: f64 = 1e-13;

/// A scene under construction: entries are numbered in the order in which they are added.
#[derive(Clone)]
pub(super) struct Builder(pub(super) Scene);

fn entry<T>(name: &str, value: T) -> Entry<T> {
    Entry {
        name: name.to_owned(),
        span: Span::default(),
        value,
    }
}

fn view(eye: [f64; 3], look_at: [f64; 3]) -> View {
    let along = [0, 1, 2].map(|i| look_at[i] - eye[i]);
    let is_vertical = along[0].abs() + along[2].abs() < 1e-3 * along[1].abs();
    let up = if is_vertical {
        [0.0, 0.0, -1.0]
    } else {
        [0.0, 1.0, 0.0]
    };
    View {
        eye: eye.into(),
        look_at: look_at.into(),
        up: up.into(),
    }
}

fn perspective(eye: [f64; 3], look_at: [f64; 3], vertical_fov: f64) -> Camera {
    Camera::Perspective {
        view: view(eye, look_at),
        vertical_fov: vertical_fov.into(),
    }
}

pub(super) fn orthographic(eye: [f64; 3], look_at: [f64; 3], height: f64) -> Camera {
    Camera::Orthographic {
        view: view(eye, look_at),
        height: height.into(),
    }
}

pub(super) fn lobes(diffuse: f64, specular: f64, shininess: Option<f64>) -> Lobes {
    Lobes {
        diffuse: Value::Uniform(diffuse).into(),
        specular: Value::Uniform(specular).into(),
        shininess: shininess.map(Spanned::from),
        coat: None,
    }
}

/// The material of every object that the builder adds, until it gets another.
const MATTE: &str = "matte";

impl Builder {
    /// A black world with `camera` and the material [`MATTE`], k_d = 1.
    pub(super) fn new(resolution: [u32; 2], camera: Camera) -> Self {
        Self(Scene {
            source: Arc::new(Source::new("test.toml".into(), String::new())),
            anchor: None,
            image: Image {
                resolution: resolution.into(),
                color_space: Spanned::default(),
                background: Value::ZERO.into(),
                transport: Transport::default().into(),
                observer: Observer::default().into(),
                max_depth: 8.0.into(),
            },
            camera: camera.into(),
            materials: Vec::new(),
            lights: Vec::new(),
            objects: Vec::new(),
            inputs: Vec::new(),
        })
        .material(MATTE, Material::Phong(lobes(1.0, 0.0, None)))
    }

    /// One pixel, in whose center the point `look_at` is seen.
    fn looking(eye: [f64; 3], look_at: [f64; 3]) -> Self {
        Self::new([1, 1], perspective(eye, look_at, 30.0))
    }

    /// Adds a material, or puts it in the place of the one of that name.
    pub(super) fn material(mut self, name: &str, material: Material) -> Self {
        self.0.materials.retain(|entry| entry.name != name);
        self.0.materials.push(entry(name, material));
        self
    }

    pub(super) fn light(mut self, position: [f64; 3], intensity: f64) -> Self {
        let name = format!("light{}", self.0.lights.len());
        let light = Light::Point {
            position: position.into(),
            intensity: Value::Uniform(intensity).into(),
            group: None,
        };
        self.0.lights.push(entry(&name, light));
        self
    }

    fn object(mut self, object: Object) -> Self {
        let name = format!("object{}", self.0.objects.len());
        self.0.objects.push(entry(&name, object));
        self
    }

    pub(super) fn sphere(self, center: [f64; 3], radius: f64) -> Self {
        self.object(Object::Sphere {
            material: MATTE.to_owned().into(),
            center: center.into(),
            radius: radius.into(),
        })
    }

    pub(super) fn plane(self, point: [f64; 3], normal: [f64; 3]) -> Self {
        self.object(Object::Plane {
            material: MATTE.to_owned().into(),
            point: point.into(),
            normal: normal.into(),
        })
    }

    pub(super) fn triangle(self, vertices: [[f64; 3]; 3]) -> Self {
        self.object(Object::Triangle {
            material: MATTE.to_owned().into(),
            vertices: vertices.into(),
        })
    }

    fn mesh(self, geometry: &Arc<MeshFile>, placed: Placed) -> Self {
        self.object(Object::Mesh {
            material: MATTE.to_owned().into(),
            file: std::path::PathBuf::from("mesh.ply").into(),
            scale: placed.scale.into(),
            rotate: placed.rotate.into(),
            translate: placed.translate.into(),
            smooth: placed.smooth,
            shadow_terminator: placed.shadow_terminator,
            geometry: Arc::clone(geometry),
        })
    }

    pub(super) fn oracle(&self) -> Oracle {
        Oracle::new(&self.0)
    }

    /// The first channel of the radiance in the center of the first pixel.
    fn radiance(&self) -> f64 {
        self.oracle().radiance(0.5, 0.5).radiance[0]
    }

    /// The terms of the first light in the center of the first pixel.
    fn first_light(&self) -> LightTerms {
        self.oracle().explain(0.5, 0.5).lights[0].clone()
    }
}

/// How a mesh is placed.
#[derive(Clone, Copy)]
struct Placed {
    scale: [f64; 3],
    rotate: [f64; 3],
    translate: [f64; 3],
    smooth: bool,
    shadow_terminator: ShadowTerminator,
}

/// As in the file, with its normals.
const AS_IS: Placed = Placed {
    scale: [1.0; 3],
    rotate: [0.0; 3],
    translate: [0.0; 3],
    smooth: true,
    shadow_terminator: ShadowTerminator::Geometric,
};

/// A sphere of radius 1 around the origin from `rows` × 2 `rows` quads, with its normals; every
/// second row is turned by half a quad, so that no edges are in one line.
fn globe(rows: u32) -> Arc<MeshFile> {
    let columns = 2 * rows;
    let angle = |part: f64, of: u32| std::f64::consts::PI * part / f64::from(of);
    let mut mesh = MeshFile::default();
    for row in 0..=rows {
        for column in 0..columns {
            let (sin_polar, cos_polar) = angle(f64::from(row), rows).sin_cos();
            // sin π is not 0 in f64: the pole would be a ring.
            let sin_polar = if row == rows { 0.0 } else { sin_polar };
            let turned = f64::from(column) + 0.5 * f64::from(row % 2);
            let (sin, cos) = angle(2.0 * turned, columns).sin_cos();
            mesh.positions
                .push([sin_polar * cos, cos_polar, sin_polar * sin]);
            let next = (column + 1) % columns;
            let [a, b] = [column, next].map(|column| row * columns + column);
            let [c, d] = [a + columns, b + columns];
            // The shorter diagonal keeps the globe convex.
            if row == rows {
                continue;
            } else if row % 2 == 0 {
                mesh.triangles.extend([[a, b, c], [b, d, c]]);
            } else {
                mesh.triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
    }
    mesh.normals = Some(MeshNormals {
        vectors: mesh.positions.clone(),
        triangles: None,
    });
    Arc::new(mesh)
}

#[track_caller]
fn assert_near(actual: f64, expected: f64, tolerance: f64) {
    assert!(
        (actual - expected).abs() <= tolerance * expected.abs().max(tolerance),
        "{actual:e}, expected {expected:e} within {tolerance:e} of it"
    );
}
