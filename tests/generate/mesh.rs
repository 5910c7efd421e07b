//! Curved surfaces as mesh files.

use std::fmt::Write;

use super::{Random, Vector, along};

/// A surface over a grid of (u, v), each from 0 to 1.
pub(super) struct Patch<'s> {
    pub(super) columns: usize,
    pub(super) rows: usize,
    pub(super) position: &'s dyn Fn(f64, f64) -> Vector,
    /// How far the normals lean from those of the surface, at random; from 1 on in any direction.
    pub(super) lean: f64,
}

/// How a mesh is written; the numbers are the same f32 in all.
#[derive(Clone, Copy)]
pub(super) enum MeshFormat {
    Ply,
    BinaryPly,
    Obj,
}

impl MeshFormat {
    pub(super) fn extension(self) -> &'static str {
        match self {
            Self::Ply | Self::BinaryPly => "ply",
            Self::Obj => "obj",
        }
    }

    pub(super) fn write(self, patch: &Patch<'_>, with_normals: bool) -> Vec<u8> {
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
        let unit = |v: Vector| {
            let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
            v.map(|x| x / length)
        };
        let n = unit(normal);
        let n = if self.lean == 0.0 {
            n
        } else {
            let seed = (u * 1e6) as u64 ^ ((v * 1e6) as u64) << 32;
            unit(along(n, Random::new(seed).direction(), self.lean))
        };
        [p[0], p[1], p[2], n[0], n[1], n[2]].map(|value| value as f32)
    }
}
