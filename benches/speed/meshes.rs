//! Meshes of other kinds than smooth surfaces in even triangles: what scanners, thin parts and CAD programs give.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::fs::File;
use std::io::{self, BufWriter, Write as _};
use std::path::Path;

/// Triangles over a floor at y = 0, in meters.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mesh {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Writes a binary PLY file.
    pub(crate) fn write(&self, path: &Path) -> io::Result<()> {
        let mut file = BufWriter::new(File::create(path)?);
        write!(
            file,
            "ply\nformat binary_little_endian 1.0\nelement vertex {}\n\
             property float x\nproperty float y\nproperty float z\n\
             element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
            self.positions.len(),
            self.triangles.len(),
        )?;
        for coordinate in self.positions.as_flattened() {
            file.write_all(&coordinate.to_le_bytes())?;
        }
        for triangle in &self.triangles {
            file.write_all(&[3])?;
            for corner in triangle {
                file.write_all(&corner.to_le_bytes())?;
            }
        }
        file.flush()
    }

    fn vertex(&mut self, position: [f64; 3]) -> u32 {
        self.positions
            .push(position.map(|coordinate| coordinate as f32));
        self.positions.len() as u32 - 1
    }

    fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        self.triangles.extend([[a, b, c], [a, c, d]]);
    }

    /// A convex polygon, as a fan around its first corner.
    fn polygon(&mut self, corners: &[u32]) {
        for pair in corners[1..].windows(2) {
            self.triangles.push([corners[0], pair[0], pair[1]]);
        }
    }

    /// Quads between two rings of as many vertices.
    fn wall(&mut self, below: &[u32], above: &[u32]) {
        for i in 0..below.len() {
            let j = (i + 1) % below.len();
            self.quad([below[i], above[i], above[j], below[j]]);
        }
    }

    /// A prism with `sides` sides that stands on the point `base`.
    fn prism(&mut self, [x, y, z]: [f64; 3], radius: f64, height: f64, sides: u32) {
        let [bottom, top] = [y, y + height].map(|y| {
            (0..sides)
                .map(|side| {
                    let angle = TAU * f64::from(side) / f64::from(sides);
                    self.vertex([x + radius * angle.cos(), y, z + radius * angle.sin()])
                })
                .collect::<Vec<_>>()
        });
        self.polygon(&bottom);
        self.wall(&bottom, &top);
        self.polygon(&top);
    }

    fn cuboid(&mut self, low: [f64; 3], high: [f64; 3]) {
        let [bottom, top] = [low[1], high[1]].map(|y| {
            let corners = [(low, low), (high, low), (high, high), (low, high)];
            corners.map(|(x, z)| self.vertex([x[0], y, z[2]]))
        });
        self.quad(bottom);
        self.wall(&bottom, &top);
        self.quad(top);
    }

    /// A cuboid whose edges, but for those at the bottom, are rounded with `steps` steps.
    fn rounded(&mut self, low: [f64; 3], high: [f64; 3], radius: f64, steps: u32) {
        // The axes of the four upright edges, and the angle at which each begins.
        let (near, far) = (low.map(|l| l + radius), high.map(|h| h - radius));
        let axes = [
            [far[0], far[2]],
            [near[0], far[2]],
            [near[0], near[2]],
            [far[0], near[2]],
        ];
        let quarter = |step: u32| FRAC_PI_2 * f64::from(step) / f64::from(steps);
        let mut ring = |y: f64, radius: f64| {
            let mut vertices = Vec::new();
            for (start, [x, z]) in (0..).step_by(steps as usize).zip(axes) {
                for step in 0..=steps {
                    let (sin, cos) = quarter(start + step).sin_cos();
                    vertices.push(self.vertex([x + radius * cos, y, z + radius * sin]));
                }
            }
            vertices
        };
        let mut rings = vec![ring(low[1], radius)];
        for step in 0..steps {
            let (sin, cos) = quarter(step).sin_cos();
            rings.push(ring(far[1] + radius * sin, radius * cos));
        }
        self.polygon(&rings[0]);
        for pair in rings.windows(2) {
            self.wall(&pair[0], &pair[1]);
        }
        let top = axes.map(|[x, z]| self.vertex([x, high[1], z]));
        let last: Vec<&[u32]> = rings[rings.len() - 1].chunks(steps as usize + 1).collect();
        for corner in 0..4 {
            for pair in last[corner].windows(2) {
                self.triangles.push([pair[0], top[corner], pair[1]]);
            }
            let next = (corner + 1) % 4;
            let end = last[corner][steps as usize];
            self.quad([end, top[corner], top[next], last[next][0]]);
        }
        self.quad(top);
    }
}

/// Numbers from -1 to 1 without order (SplitMix64), the same in every run.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        (bits >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// A torus of a million triangles, each coordinate of whose vertices is off by up to half an edge's length.
pub(crate) fn noisy() -> Mesh {
    const AROUND: u32 = 408;
    const ALONG: u32 = 3 * AROUND;
    const TUBE: f64 = 0.35;
    let edge = TAU * TUBE / f64::from(AROUND);
    let (mut mesh, mut noise) = (Mesh::default(), Noise(1));
    for i in 0..ALONG {
        for j in 0..AROUND {
            let u = TAU * f64::from(i) / f64::from(ALONG);
            let v = TAU * f64::from(j) / f64::from(AROUND);
            let distance = 0.9 + TUBE * v.cos();
            let position = [distance * u.cos(), 0.4 + TUBE * v.sin(), distance * u.sin()];
            mesh.vertex(position.map(|coordinate| coordinate + edge / 2.0 * noise.next()));
        }
    }
    for i in 0..ALONG {
        for j in 0..AROUND {
            let vertex = |i: u32, j: u32| (i % ALONG) * AROUND + j % AROUND;
            mesh.quad([
                vertex(i, j),
                vertex(i, j + 1),
                vertex(i + 1, j + 1),
                vertex(i + 1, j),
            ]);
        }
    }
    mesh
}

/// A hundred open tubes in all directions, of 2000 triangles each that are a thousand times as long as wide.
pub(crate) fn slivers() -> Mesh {
    const SIDES: u32 = 1000;
    const RADIUS: f64 = 0.0875;
    let (mut mesh, mut noise) = (Mesh::default(), Noise(2));
    for place in 0..100 {
        let [x, z] = [place % 10, place / 10].map(|p| (f64::from(p) - 4.5) * 0.3);
        // Along the tube, and two vectors across it.
        let axis = unit([noise.next(), 1.0, noise.next()]);
        let across = unit(cross(axis, [1.0, 0.0, 0.0]));
        let other = cross(axis, across);
        let [bottom, top] = [-0.5, 0.5].map(|end| {
            (0..SIDES)
                .map(|side| {
                    let (sin, cos) = (TAU * f64::from(side) / f64::from(SIDES)).sin_cos();
                    let center = [x, 0.35, z];
                    mesh.vertex([0, 1, 2].map(|c| {
                        let round = cos * across[c] + sin * other[c];
                        center[c] + RADIUS * (TAU * end * axis[c] + round)
                    }))
                })
                .collect::<Vec<_>>()
        });
        mesh.wall(&bottom, &top);
    }
    mesh
}

/// What a CAD program may give: 440 blocks with tiny fillets on a plate of two large triangles a side, each block
/// exactly on the plate and exactly beside the next one, a prism on every other block, and blocks let into the plate
/// whose top is the plate's. 314 k triangles, many of them on each other, with edges from 5 m to 0.15 mm.
pub(crate) fn cad() -> Mesh {
    // Lengths are binary fractions, so that faces are on each other to the bit.
    const UNIT: f64 = 1.0 / 64.0;
    let mut mesh = Mesh::default();
    let plate = 6.0 * UNIT;
    mesh.cuboid([-1.75, 0.0, -168.0 * UNIT], [1.75, plate, 56.0 * UNIT]);
    for i in 0..22 {
        for j in 0..20 {
            let x = (f64::from(i) - 11.0) * 9.0 * UNIT;
            let z = (10.0 * f64::from(j) - 156.0) * UNIT;
            let top = plate + f64::from(4 + (7 * i + 5 * j + i * j) % 11) * UNIT;
            let side = 9.0 * UNIT;
            mesh.rounded([x, plate, z], [x + side, top, z + side], UNIT / 4.0, 8);
            if (i + j) % 2 == 0 {
                let center = [x + side / 2.0, top, z + side / 2.0];
                mesh.prism(center, 2.5 * UNIT, 3.0 * UNIT, 32);
            }
        }
    }
    for i in 0..10 {
        let x = (f64::from(i) - 5.0) * 20.0 * UNIT;
        mesh.cuboid(
            [x, plate / 2.0, 47.0 * UNIT],
            [x + 15.0 * UNIT, plate, 53.0 * UNIT],
        );
    }
    mesh
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn unit(vector: [f64; 3]) -> [f64; 3] {
    let length = vector.iter().map(|c| c * c).sum::<f64>().sqrt();
    vector.map(|c| c / length)
}
