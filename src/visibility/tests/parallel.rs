//! Rays with a direction in common.

use super::*;

/// Parallel rays that start amid shapes: what is behind them is not seen, and spheres from within.
#[test]
fn parallel_rays_from_within() {
    let mut scene = Writer::orthographic(2.5, [0.1, 0.2, 0.1], [-0.4, 0.0, -0.9]);
    scene.clutter(300, 60, 0.2);
    scene.sphere([0.0; 3], 3.0);
    scene.sphere([0.1, 0.2, 0.1], 0.3);
    scene.plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
    let [a, b, c, d] =
        [[-20.0, -20.0], [20.0, -20.0], [20.0, 20.0], [-20.0, 20.0]].map(|[x, z]| [x, -0.9, z]);
    scene.triangle([a, b, c]);
    scene.triangle([a, c, d]);
    let fallback = scene.agrees();
    assert!(fallback < FALLS_BACK, "{fallback}");
    scene.sphere([0.5, 1001.0, 0.0], 1000.0);
    scene.plane([0.1, 0.2, 0.1], [1.0, 0.3, -0.2]);
    scene.lights();
    scene.agrees();
}

/// The start of the rays is on faces, edges and corners, in the plane of triangles, and touches spheres.
#[test]
fn parallel_rays_from_surfaces() {
    let mut scene = Writer::orthographic(2.0, [0.0, 0.0, 1.0], [0.0; 3]);
    for index in 0..40 {
        let at = |dimension| scattered(index, dimension) * 2.0 - 1.0;
        scene.triangle([
            [at(0), at(1), 1.0],
            [at(2), at(3), 1.0],
            [at(4), at(5), 1.0],
        ]);
        scene.triangle([
            [at(6), at(7), 1.0],
            [at(8), at(9), at(10)],
            [at(11), at(12), 2.0],
        ]);
        scene.triangle([
            [at(1), at(4), 1.0],
            [at(3), at(2), 1.0],
            [at(8), at(9), at(7)],
        ]);
        scene.sphere(
            [at(13), at(14), 1.0 + 0.1 * (f64::from(index % 3) - 1.0)],
            0.1,
        );
    }
    scene.plane([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]);
    scene.plane([0.0, 0.0, 1.0], [0.0, 1.0, 1.0]);
    scene.plane([0.0, 0.0, -1.0], [0.0, 0.0, 1.0]);
    scene.lights();
    scene.agrees();
}

/// Elevations: floors and walls along the rays, exactly and almost.
#[test]
fn parallel_rays_along_surfaces() {
    for tilt in [0.0, 1e-17, 1e-12, 1e-8, 1e-5, 1e-3] {
        let mut scene = Writer::orthographic(2.2, [0.0, 0.1, 3.0], [0.0, 0.1 - 3.0 * tilt, 0.0]);
        scene.plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
        scene.plane([0.0, -0.5, 0.0], [tilt, 1.0, tilt]);
        scene.plane([0.0, 0.0, -2.0], [0.0, tilt, 1.0]);
        for index in 0..60 {
            let at = |dimension| scattered(index, dimension) * 2.0 - 1.0;
            let (x, y) = (at(0), at(1));
            scene.triangle([[x, at(2), at(3)], [x, at(4), at(5)], [x, at(6), at(7)]]);
            scene.triangle([[at(8), y, at(3)], [at(9), y, at(5)], [at(10), y, at(7)]]);
        }
        scene.clutter(20, 10, 0.1);
        scene.lights();
        scene.agrees();
    }
}

/// Rays far closer together and far further apart than the shapes are large, and from far away.
#[test]
fn parallel_rays_at_every_scale() {
    for height in [1e-12, 1e-7, 1e-3, 30.0, 1e5, 1e9] {
        let mut scene = Writer::orthographic(height, EYE, [0.01, 0.02, 0.03]);
        scene.clutter(200, 40, 0.2);
        scene.plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
        scene.lights();
        scene.agrees();
    }
    for distance in [1e3, 1e6, 1e9, 1e13] {
        let eye = [0.3 * distance, 0.7 * distance, 0.4 * distance];
        let mut scene = Writer::orthographic(2.0, eye, [0.0; 3]);
        scene.clutter(200, 40, 0.2);
        scene.plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
        scene.lights();
        scene.agrees();
    }
}
