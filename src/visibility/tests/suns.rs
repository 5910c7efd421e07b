//! The light of suns: projections along it against segments that share nothing.

use super::*;

impl Writer {
    /// Light along a direction.
    pub(super) fn sun(&mut self, direction: [f64; 3]) {
        self.objects += 1;
        let _ = write!(
            self.text,
            "[lights.l{}.sun]\ndirection = {direction:?}\nilluminance = 1\n",
            self.objects,
        );
    }

    /// From all sides: along the axes and diagonals, and without order.
    pub(super) fn suns(&mut self) {
        for direction in [
            [0.0, -1.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 0.0, -1.0],
            [-1.0, -1.0, 0.0],
            [1.0, -1.0, -1.0],
            [1e-17, -1.0, 1e-9],
            [-0.3, -0.8, -0.5],
            [0.9, -0.2, -0.3],
            [0.2, 0.4, -0.7],
        ] {
            self.sun(direction);
        }
    }
}

#[test]
fn the_light_of_a_sun_is_decided_by_the_projection() {
    let mut scene = Writer::new(1.0, [0.0; 3], 40.0, EYE);
    scene.clutter(300, 60, 0.2);
    scene.plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
    for direction in [[-0.3, -0.8, -0.5], [0.9, -0.2, -0.3], [0.1, -0.3, 0.7]] {
        scene.sun(direction);
    }
    let fallback = scene.agrees();
    assert!(fallback < FALLS_BACK, "{fallback}");
}

/// Many small triangles before a floor: points of a batch that are far apart are projected in groups.
#[test]
fn silhouettes_in_the_sun() {
    for largest in [0.03, 0.003] {
        let mut scene = Writer::new(1.0, [0.0; 3], 40.0, EYE);
        scene.clutter(4000, 0, largest);
        scene.triangle([[-9.0, -1.0, -9.0], [0.0, -1.0, 9.0], [9.0, -1.0, -9.0]]);
        scene.suns();
        scene.agrees();
    }
}

#[test]
fn suns_over_scenes_of_any_size_in_any_place() {
    for (size, place) in [
        (1e-9, [0.0; 3]),
        (1e-6, [0.0; 3]),
        (1e6, [0.0; 3]),
        (1e9, [0.0; 3]),
        (1e-3, [100.0, -50.0, 7.0]),
        (1.0, [1e6, -7e5, 3e5]),
        (1.0, [1e12, -7e11, 3e11]),
        (1e-30, [0.0; 3]),
        (1e29, [0.0; 3]),
    ] {
        let mut scene = Writer::new(size, place, 40.0, EYE);
        scene.clutter(100, 30, 0.3);
        scene.plane([0.0, -1.0, 0.0], [0.1, 1.0, 0.2]);
        scene.suns();
        scene.agrees();
    }
}

/// Light exactly and almost along faces, through edges and corners that neighbors share; and every triangle is
/// there twice.
#[test]
fn suns_along_faces_and_edges() {
    for tilt in [0.0, 1e-17, 1e-12, 1e-8, 1e-5, 1e-3] {
        let mut scene = Writer::new(1.0, [0.0; 3], 50.0, EYE);
        for twice in 0..2 {
            for cell in 0..16_u32 {
                let (x, z) = (
                    f64::from(cell % 4) / 2.0 - 1.0,
                    f64::from(cell / 4) / 2.0 - 1.0,
                );
                // Steps: treads across the light from above, and risers along it.
                let height = f64::from(cell % 3) * 0.25;
                let corner = |dx: f64, y: f64, dz: f64| [x + dx * 0.5, y, z + dz * 0.5];
                let tread = [
                    corner(0.0, height, 0.0),
                    corner(1.0, height, 0.0),
                    corner(1.0, height, 1.0),
                    corner(0.0, height, 1.0),
                ];
                let riser = [
                    corner(0.0, height, 0.0),
                    corner(0.0, height + 0.25, 0.0),
                    corner(0.0, height + 0.25, 1.0),
                    corner(0.0, height, 1.0),
                ];
                for [a, b, c, d] in [tread, riser] {
                    let halves = [[[a, b, c], [a, c, d]], [[b, c, a], [d, a, c]]];
                    for half in halves[twice] {
                        scene.triangle(half);
                    }
                }
            }
        }
        scene.plane([0.0, -0.5, 0.0], [tilt, 1.0, tilt]);
        scene.plane([0.0, 0.0, -2.0], [0.0, tilt, 1.0]);
        for direction in [
            [tilt, -1.0, 0.0],
            [1.0, -tilt, 0.0],
            [-1.0, -tilt, tilt],
            [0.0, tilt, -1.0],
            [-1.0, -1.0, tilt],
            [0.5, -0.25, tilt],
        ] {
            scene.sun(direction);
        }
        scene.agrees();
    }
}

/// Points within a sphere, on spheres that touch each other and a plane, on a planet and on its pebbles; and spheres
/// as small as what rounding leaves of their points.
#[test]
fn suns_over_spheres() {
    for around in [false, true] {
        let mut scene = Writer::new(1.0, [0.0; 3], 60.0, EYE);
        if around {
            scene.sphere([0.0; 3], 5.0);
        }
        scene.sphere([0.0, -1001.0, 0.0], 1000.0);
        scene.plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
        for index in 0..40_u32 {
            let x = f64::from(index % 8) * 0.25 - 1.0;
            let z = f64::from(index / 8) * 0.25 - 0.5;
            scene.sphere([x, -0.875, z], 0.125);
            scene.sphere([x, -0.7495, z], 5e-4);
            scene.sphere([x, -0.75 + 1e-9, z], 1e-9);
            scene.sphere([x, -0.75, z], 1e-14);
        }
        scene.clutter(30, 0, 0.3);
        scene.suns();
        scene.agrees();
    }
    // The viewer is in the one that is seen.
    let mut scene = Writer::new(1.0, [0.0; 3], 60.0, EYE);
    scene.sphere(EYE, 0.2);
    scene.sphere(EYE, 0.1);
    scene.suns();
    scene.agrees();
}

#[test]
fn suns_over_slivers_and_contacts() {
    let mut scene = Writer::new(1.0, [0.1, -0.7, 0.3], 90.0, EYE);
    for index in 0..40 {
        let at = |dimension| scattered(index, dimension) * 2.0 - 1.0;
        let [a, b, c] =
            [0, 3, 6].map(|dimension| [at(dimension), at(dimension + 1), at(dimension + 2)]);
        let between = |s: f64, t: f64| {
            [0, 1, 2].map(|axis: usize| a[axis] + (b[axis] - a[axis]) * s + (c[axis] - a[axis]) * t)
        };
        scene.triangle([a, b, c]);
        let far = [0, 1, 2].map(|axis: usize| a[axis] * 0.3 + b[axis] * 0.7 + 1e-9);
        scene.triangle([a, b, far]);
        scene.triangle([
            between(0.3, 0.3),
            [at(9), at(10), at(11)],
            [at(12), at(13), at(14)],
        ]);
        scene.triangle([
            between(0.1, 0.2),
            between(0.6, 0.2),
            [at(15), at(16), at(17)],
        ]);
        scene.triangle([between(0.1, 0.1), between(0.2, 0.5), between(0.5, 0.1)]);
        scene.triangle([
            [at(9) * 9.0, at(10) * 9.0, -4.0],
            [at(11) * 9.0, at(12) * 9.0, 8.0],
            [at(6) * 9.0, at(7) * 9.0, 8.0],
        ]);
        // In the plane of a triangle, along an edge.
        if index % 10 == 0 {
            scene.sun([0, 1, 2].map(|axis: usize| b[axis] - a[axis]));
            scene.sun([0, 1, 2].map(|axis: usize| between(0.4, 0.3)[axis] - c[axis]));
        }
    }
    scene.suns();
    scene.agrees();
}

/// Coarse and fine balls, whose shadow rays start off the triangles.
#[test]
fn suns_over_lifted_points() {
    for (size, place) in [(1.0, [0.0; 3]), (1e-3, [100.0, -50.0, 7.0])] {
        for lean in [0.0, 0.5, 3.0] {
            for grid in [[4, 2], [9, 5], [40, 20]] {
                let mut scene = Writer::new(size, place, 40.0, EYE);
                scene.ball([0.0; 3], 0.7, grid, lean);
                scene.ball([0.6, 0.4, 0.3], 0.4, [7, 4], lean);
                scene.clutter(10, 4, 0.2);
                scene.plane([0.0, -0.6, 0.0], [0.1, 1.0, 0.2]);
                scene.suns();
                scene.agrees();
            }
        }
    }
}

/// Points far closer together than the shapes are large, and far further apart.
#[test]
fn suns_before_parallel_rays_at_every_scale() {
    for height in [1e-12, 1e-7, 1e-3, 30.0, 1e5, 1e9] {
        let mut scene = Writer::orthographic(height, EYE, [0.01, 0.02, 0.03]);
        scene.clutter(200, 40, 0.2);
        scene.plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
        scene.suns();
        // Along the view: what is seen is lit.
        scene.sun([0, 1, 2].map(|axis: usize| [0.01, 0.02, 0.03][axis] - EYE[axis]));
        scene.agrees();
    }
}
