//! The kinds of scenes: each a camera, materials, objects and lights around the origin, within a
//! few units.

use std::f64::consts::{PI, TAU};

use super::mesh::Patch;
use super::{Draft, along};

impl Draft<'_> {
    pub(super) fn still_life(&mut self) {
        let eye = [self.random.between(-3.0, 3.0), 1.5, 4.0];
        self.camera(eye, [0.0, 0.5, 0.0]);
        let floor = self.material();
        self.plane(&floor, [0.0; 3], [0.0, 1.0, 0.0]);
        for _ in 0..self.random.count(3, 6) {
            let (material, radius) = (self.material(), self.random.between(0.2, 0.7));
            let [x, _, z] = self.random.point(1.5);
            self.sphere(&material, [x, radius, z], radius);
        }
        for _ in 0..self.random.count(0, 4) {
            let material = self.material();
            let corners = [(); 3].map(|()| along([0.0, 0.8, 0.0], self.random.point(1.5), 0.8));
            self.triangle(&material, corners);
        }
        self.lights_above(0, 4);
    }

    pub(super) fn crowd(&mut self) {
        let direction = self.random.direction();
        self.camera(along([0.0; 3], direction, 5.0), [0.0; 3]);
        let materials = [(); 4].map(|()| self.material());
        for index in 0..self.random.count(20, 80) {
            let (center, radius) = (self.random.point(2.0), self.random.log_between(0.02, 0.6));
            self.sphere(&materials[index as usize % 4], center, radius);
        }
        self.lights(0, 8);
    }

    pub(super) fn shards(&mut self) {
        let direction = self.random.direction();
        self.camera(along([0.0; 3], direction, 5.0), [0.0; 3]);
        let materials = [(); 3].map(|()| self.material());
        for index in 0..self.random.count(5, 80) {
            let center = self.random.point(1.5);
            let size = self.random.log_between(0.05, 2.0);
            let corners = [(); 3].map(|()| along(center, self.random.point(size), 1.0));
            self.triangle(&materials[index as usize % 3], corners);
        }
        if self.random.chance(0.5) {
            let normal = self.towards(direction);
            self.plane(&materials[0], along([0.0; 3], normal, -2.5), normal);
        }
        self.lights(1, 5);
    }

    pub(super) fn torus(&mut self) {
        let direction = self.random.direction();
        self.camera(along([0.0; 3], direction, 4.0), [0.0; 3]);
        let material = self.material();
        let waves = self.random.count(0, 5) as f64;
        let position = |u: f64, v: f64| {
            let (around, across) = ((TAU * u).sin_cos(), (TAU * v).sin_cos());
            let tube = 0.35 + 0.05 * (waves * TAU * u).sin() * (2.0 * TAU * v).cos();
            let radius = 1.0 + tube * across.1;
            [radius * around.1, tube * across.0, radius * around.0]
        };
        let patch = Patch {
            columns: 36,
            rows: 20,
            position: &position,
            lean: 0.0,
        };
        self.mesh(&material, [0.0; 3], &patch);
        let material = self.material();
        let center = self.random.point(0.5);
        self.sphere(&material, center, 0.3);
        let normal = self.towards(direction);
        let material = self.material();
        self.plane(&material, along([0.0; 3], normal, -1.8), normal);
        self.lights(1, 4);
    }

    pub(super) fn terrain(&mut self) {
        let eye = along([0.0; 3], self.random.direction(), 4.0);
        self.camera(eye, [0.0; 3]);
        let (bumps, material) = (self.random.between(1.0, 3.0), self.material());
        let height = |u: f64, v: f64| {
            let (x, z) = (4.0 * u - 2.0, 4.0 * v - 2.0);
            [x, 0.3 * (bumps * x).sin() * (bumps * z).cos(), z]
        };
        let terrain = Patch {
            columns: 24,
            rows: 24,
            position: &height,
            lean: 0.0,
        };
        self.mesh(&material, [0.0, -0.5, 0.0], &terrain);
        // Its poles are rows of equal points: half of their triangles have no area.
        let ball = |u: f64, v: f64| {
            let radius = 0.8 + 0.1 * (3.0 * TAU * u).sin() * (PI * v).sin();
            let ring = if v == 0.0 || v == 1.0 {
                0.0
            } else {
                radius * (PI * v).sin()
            };
            let (sin, cos) = (TAU * u).sin_cos();
            [ring * cos, radius * (PI * v).cos(), ring * sin]
        };
        let ball = Patch {
            columns: 24,
            rows: 12,
            position: &ball,
            lean: 0.0,
        };
        let material = self.material();
        self.mesh(&material, [0.0, 0.6, 0.0], &ball);
        self.lights(1, 4);
    }

    /// Touching spheres, spheres that touch the floor, and everything twice at the same place.
    pub(super) fn contacts(&mut self) {
        let eye = [self.random.between(-2.0, 2.0), 2.0, 4.0];
        self.camera(eye, [0.0, 0.4, 0.0]);
        let materials = [(); 3].map(|()| self.material());
        for floor in &materials[..2] {
            self.plane(floor, [0.0; 3], [0.0, 1.0, 0.0]);
        }
        for i in 0..3 {
            for j in 0..3 {
                let center = [f64::from(i) - 1.0, 0.5, f64::from(j) - 1.0];
                self.sphere(&materials[(i + j) as usize % 3], center, 0.5);
            }
        }
        // Twice, in another material.
        self.sphere(&materials[1], [0.0, 0.5, 0.0], 0.5);
        let corners = [[-1.5, 0.0, 1.2], [1.5, 0.0, 1.2], [0.0, 1.0, 1.2]];
        self.triangle(&materials[0], corners);
        self.triangle(&materials[2], corners);
        self.lights_above(1, 4);
    }

    pub(super) fn far_and_tiny(&mut self) {
        let distance = self.random.log_between(50.0, 1e4);
        let direction = self.random.direction();
        let center = along([0.0; 3], direction, distance);
        let (eye, look_at) = (self.place([0.0; 3]), self.place(center));
        let up = if direction[1].abs() > 0.9 {
            [1.0, 0.0, 0.0]
        } else {
            [0.0, 1.0, 0.0]
        };
        let view = format!("eye = {eye:?}\nlook_at = {look_at:?}\nup = {up:?}\n");
        if self.random.chance(0.5) {
            self.perspective(&view, (2.0 * (1.0 / distance).atan()).to_degrees());
        } else {
            self.orthographic(&view, 2.0);
        }
        for _ in 0..self.random.count(4, 12) {
            let material = self.material();
            let place = along(center, self.random.point(1.0), 0.8);
            let radius = self.random.log_between(1e-2, 0.5);
            self.sphere(&material, place, radius);
        }
        let material = self.material();
        self.plane(&material, along(center, direction, 1.5), direction);
        for _ in 0..self.random.count(1, 3) {
            let offset = self.random.point(3.0);
            let beside = along(center, offset, 1.0);
            self.light(along(beside, direction, -3.5));
        }
    }

    /// A small distance between a light and a surface, but one that the coordinates still tell:
    /// far from the origin their last bit is 1e-16 of that way.
    fn gap(&mut self) -> f64 {
        self.random.choice(&[1e-9, 1e-6, 1e-3, 0.1]) * self.far.max(1.0)
    }

    /// Lights just above surfaces, and within spheres, one of which the camera is in.
    pub(super) fn near_lights(&mut self) {
        self.camera([0.0, 1.0, 4.0], [0.0, 0.5, 0.0]);
        let material = self.material();
        self.plane(&material, [0.0; 3], [0.0, 1.0, 0.0]);
        let material = self.material();
        self.sphere(&material, [0.0, 1.0, 0.0], 7.0);
        for _ in 0..self.random.count(1, 4) {
            let material = self.material();
            let (center, radius) = ([0.0, 0.7, 0.0], self.random.between(0.2, 0.6));
            let center = along(center, self.random.point(1.0), 1.0);
            self.sphere(&material, center, radius);
            let way = self.random.direction();
            let gap = self.gap();
            self.light(along(center, way, radius + gap));
            if self.random.chance(0.3) {
                self.light(along(center, way, 0.5 * radius));
            }
        }
        let [x, _, z] = self.random.point(1.5);
        let gap = self.gap();
        self.light([x, gap, z]);
        self.lights_above(1, 2);
    }

    pub(super) fn grazing(&mut self) {
        let height = self.random.log_between(1e-4, 0.1);
        self.camera([0.1, height, 3.0], [0.0, 0.0, 0.0]);
        let material = self.material();
        self.plane(&material, [0.0; 3], [0.0, 1.0, 0.0]);
        for _ in 0..self.random.count(2, 12) {
            let material = self.material();
            let [x, y, z] = self.random.point(1.5);
            let radius = self.random.log_between(0.01, 0.5);
            self.sphere(&material, [x, y.abs() * 0.3, z], radius);
        }
        let corners = [(); 3].map(|()| self.random.point(1.5));
        self.triangle(&material, corners);
        for _ in 0..self.random.count(1, 3) {
            let [x, _, z] = self.random.point(3.0);
            let height = self.random.log_between(1e-3, 3.0);
            self.light([x, height, z]);
        }
    }

    /// Coarse meshes, some with normals that lean to all sides, within each other and within a sphere, and lights
    /// near their surfaces, within and at their middle: shadow rays start far off the triangles, also
    /// beyond a light.
    pub(super) fn terminators(&mut self) {
        let direction = self.random.direction();
        self.camera(along([0.0; 3], direction, 4.0), [0.0; 3]);
        for _ in 0..self.random.count(1, 3) {
            let material = self.material();
            let dented = self.random.choice(&[0.0, 0.0, 0.3]);
            let ball = |u: f64, v: f64| {
                let radius = 0.8 + dented * (2.0 * TAU * u).sin() * (PI * v).sin();
                let ring = if v == 0.0 || v == 1.0 {
                    0.0
                } else {
                    radius * (PI * v).sin()
                };
                let (sin, cos) = (TAU * u).sin_cos();
                [ring * cos, radius * (PI * v).cos(), ring * sin]
            };
            let patch = Patch {
                columns: self.random.count(4, 14) as usize,
                rows: self.random.count(3, 8) as usize,
                position: &ball,
                lean: self.random.choice(&[0.0, 0.0, 0.3, 1.0, 3.0]),
            };
            let center = self.random.point(0.6);
            self.mesh(&material, center, &patch);
            for _ in 0..self.random.count(0, 2) {
                let way = self.random.direction();
                let height = self.random.choice(&[0.0, 0.5, 0.7, 0.8, 0.9, 1.2]);
                self.light(along(center, way, height));
            }
        }
        let (material, center) = (self.material(), self.random.point(0.8));
        self.sphere(&material, center, 0.4);
        let normal = self.towards(direction);
        let material = self.material();
        self.plane(&material, along([0.0; 3], normal, -0.9), normal);
        self.lights(1, 3);
    }

    pub(super) fn room(&mut self) {
        let eye = self.random.point(1.8);
        self.camera(eye, along([0.0; 3], eye, -0.3));
        for axis in 0..3 {
            for side in [-2.0, 2.0] {
                let material = self.material();
                let mut wall = [0.0; 3];
                wall[axis] = side;
                self.plane(&material, wall, wall);
            }
        }
        for _ in 0..self.random.count(1, 10) {
            let (material, center) = (self.material(), self.random.point(1.5));
            let radius = self.random.between(0.1, 0.4);
            self.sphere(&material, center, radius);
        }
        let (a, b) = ([-1.0, -1.2, -1.0], [1.0, -1.2, 1.0]);
        let (c, d) = ([-1.0, -1.2, 1.0], [1.0, -1.2, -1.0]);
        let material = self.material();
        self.triangle(&material, [a, b, c]);
        self.triangle(&material, [b, a, d]);
        for _ in 0..self.random.count(1, 4) {
            let position = self.random.point(1.95);
            self.light(position);
        }
    }
}
