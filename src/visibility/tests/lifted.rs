//! Shadow rays that start off the triangles.

use std::path::PathBuf;
use std::sync::Arc;

use super::*;

/// Adds objects that are no text to a scene.
pub(super) fn add_meshes(scene: &mut Scene, meshes: &[Object]) {
    for (index, mesh) in meshes.iter().enumerate() {
        scene.objects.push(Entry {
            name: format!("mesh{index}"),
            span: Span::default(),
            value: mesh.clone(),
        });
    }
}

impl Writer {
    /// A ball of radius 1 from quads, with its normals; these `lean` to all sides.
    pub(super) fn ball(
        &mut self,
        center: [f64; 3],
        radius: f64,
        [columns, rows]: [u32; 2],
        lean: f64,
    ) {
        let mut mesh = MeshFile::default();
        let mut normals = Vec::new();
        for row in 0..=rows {
            for column in 0..columns {
                let around = f64::from(column) / f64::from(columns) * std::f64::consts::TAU;
                let polar =
                    (f64::from(row) + 0.01) / (f64::from(rows) + 0.02) * std::f64::consts::PI;
                let (ring, height) = polar.sin_cos();
                let out = [ring * around.cos(), height, ring * around.sin()];
                mesh.positions.push(out);
                let index = row * columns + column;
                let lean = |axis: u32| (scattered(index, axis) * 2.0 - 1.0) * lean;
                normals.push([out[0] + lean(0), out[1] + lean(1), out[2] + lean(2)]);
                if row < rows {
                    let beside = row * columns + (column + 1) % columns;
                    mesh.triangles.extend([
                        [index, beside, beside + columns],
                        [index, beside + columns, index + columns],
                    ]);
                }
            }
        }
        mesh.normals = Some(MeshNormals {
            vectors: normals,
            triangles: None,
        });
        let place = [0, 1, 2].map(|axis: usize| self.place[axis] + self.size * center[axis]);
        self.meshes.push(Object::Mesh {
            material: "m".to_owned().into(),
            file: PathBuf::from("ball.ply").into(),
            scale: [radius * self.size; 3].into(),
            rotate: [10.0, 20.0, 30.0].into(),
            translate: place.into(),
            smooth: true,
            shadow_terminator: ShadowTerminator::Hanika,
            geometry: Arc::new(mesh),
        });
    }
}

/// Coarse and fine balls, as lists and as trees, amid other shapes; beside flat ones in one batch.
#[test]
fn the_projection_decides_by_where_shadow_rays_start() {
    for (size, place) in [
        (1.0, [0.0; 3]),
        (1e-6, [0.0; 3]),
        (1e-3, [100.0, -50.0, 7.0]),
    ] {
        for lean in [0.0, 0.5, 3.0] {
            for grid in [[4, 2], [9, 5], [40, 20]] {
                let mut scene = Writer::new(size, place, 40.0, EYE);
                scene.ball([0.0; 3], 0.7, grid, lean);
                scene.ball([0.6, 0.4, 0.3], 0.4, [7, 4], lean);
                scene.clutter(10, 4, 0.2);
                scene.plane([0.0, -0.6, 0.0], [0.1, 1.0, 0.2]);
                scene.lights();
                // In a ball, at its surface, and just off it.
                scene.light([0.6, 0.4, 0.3]);
                scene.light([0.0, 0.7, 0.0]);
                scene.light([0.02, 0.75, 0.01]);
                scene.agrees();
            }
        }
    }
}
