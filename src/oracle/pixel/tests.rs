//! Means over pixels that have closed forms.

use std::f64::consts::PI;

use super::super::tests::{Builder, lobes, orthographic};
use super::gauss::SEVEN;
use super::*;
use crate::scene::{Material, Value};

const TOLERANCE: f64 = 1e-6;

/// One pixel that shows −½ to ½ of the plane z = 0, before a background of 1.
fn one_pixel() -> Builder {
    let mut scene = Builder::new([1, 1], orthographic([0.0, 0.0, 10.0], [0.0; 3], 1.0));
    scene.0.image.background = Value::Uniform(1.0).into();
    scene
}

/// The mean, which has to be this to as much as it says, and that to be little.
#[track_caller]
fn assert_mean(scene: &Builder, expected: [f64; 2], error: f64) -> PixelMean {
    let oracle = scene.oracle();
    let mean = PixelQuadrature::new(&oracle).pixel(0, 0, TOLERANCE);
    println!("{mean:?}, expected {expected:?}");
    assert!(mean.is_resolved);
    for (actual, expected, stated) in [
        (mean.radiance[0], expected[0], mean.error[0]),
        (mean.coverage, expected[1], mean.error[3]),
    ] {
        let off = (actual - expected).abs();
        assert!(off <= stated, "{off:e} off, {stated:e} stated");
        assert!(stated <= error, "{stated:e} stated");
    }
    mean
}

/// ∫∫ h/(h² + x² + y²)^(3/2) from (0, 0) to (x, y), the solid angle of a rectangle under a corner of it.
fn solid_angle(h: f64, x: f64, y: f64) -> f64 {
    (x * y / (h * (h * h + x * x + y * y).sqrt())).atan()
}

fn solid_angle_of(h: f64, x: [f64; 2], y: [f64; 2]) -> f64 {
    let to = |x, y| solid_angle(h, x, y);
    to(x[1], y[1]) - to(x[0], y[1]) - to(x[1], y[0]) + to(x[0], y[0])
}

#[test]
fn a_straight_edge() {
    for [slope, at] in [
        [0.3, 0.1],
        [0.0, 0.123],
        [-1.7, 0.05],
        [1e-3, -0.4],
        [1e-7, 0.2],
    ] {
        // Above y = at + slope x there is a black triangle.
        let end = |x: f64| [x, at + slope * x, 0.0];
        let scene = one_pixel().triangle([end(-50.0), end(50.0), [0.0, 300.0, 0.0]]);
        let steps = 200_000;
        let below = |i: i32| {
            let x = (f64::from(i) + 0.5) / f64::from(steps) - 0.5;
            (at + slope * x + 0.5).clamp(0.0, 1.0)
        };
        let below: f64 = (0..steps).map(below).sum::<f64>() / f64::from(steps);
        assert_mean(&scene, [below, 1.0 - below], 3e-6);
    }
}

#[test]
fn a_disk() {
    for radius in [0.45, 0.1, 0.04] {
        let scene = one_pixel().sphere([0.02, -0.03, 0.0], radius);
        let area = PI * radius * radius;
        assert_mean(&scene, [1.0 - area, area], 3e-6);
    }
}

/// A corner within the pixel, sharper and sharper.
#[test]
fn a_wedge() {
    for width in [0.5, 0.1, 2e-2] {
        let apex = [0.1, -0.3, 0.0];
        let scene = one_pixel().triangle([apex, [-width, 0.5, 0.0], [0.3, 0.5, 0.0]]);
        let area = 0.5 * 0.8 * (0.3 + width);
        assert_mean(&scene, [1.0 - area, area], 3e-6);
        let scene = one_pixel().triangle([apex, [0.2, 0.5, 0.0], [0.2 + width, 0.5, 0.0]]);
        // The widest is cut off.
        if width <= 0.3 {
            let area = 0.5 * 0.8 * width;
            assert_mean(&scene, [1.0 - area, area], 3e-6);
        }
    }
}

/// Thinner than the points at the beginning are apart, at all angles.
#[test]
fn a_sliver() {
    for (width, tangent) in [
        (1e-2, 0.0),
        (1e-2, 0.3),
        (1e-2, 1.0),
        (5e-3, 0.0),
        (5e-3, 0.3),
    ] {
        {
            // A band of that width across the pixel, from left to right; two triangles.
            let end = |x: f64, y: f64| [x, 0.05 + tangent * x + y, 0.0];
            let [a, b] = [end(-1.0, 0.0), end(1.0, 0.0)];
            let [c, d] = [end(-1.0, width), end(1.0, width)];
            let scene = one_pixel().triangle([a, b, c]).triangle([b, d, c]);
            let area = if tangent == 1.0 {
                // It leaves at the top, 0.05 before the corner.
                let to = |offset: f64| 0.5 * (1.0 - offset) * (1.0 - offset);
                to(0.05) - to(0.05 + width)
            } else {
                width
            };
            assert_mean(&scene, [1.0 - area, area], 3e-6);
        }
    }
}

#[test]
fn light_that_falls_off() {
    for h in [2.0, 0.5, 0.1] {
        let scene = one_pixel()
            .plane([0.0; 3], [0.0, 0.0, 1.0])
            .light([0.1, 0.2, h], 3.0);
        let all = 3.0 * solid_angle_of(h, [-0.6, 0.4], [-0.7, 0.3]);
        assert_mean(&scene, [all, 1.0], 1e-5 * all);
    }
}

#[test]
fn the_edge_of_a_shadow() {
    // The light is twice as high as the triangle, whose edge at x = 0.2 has its shadow's at 0.3.
    let scene = one_pixel()
        .plane([0.0; 3], [0.0, 0.0, 1.0])
        .triangle([[0.2, -9.0, 0.5], [0.2, 9.0, 0.5], [0.9, 0.0, 0.5]])
        .light([0.1, 0.2, 1.0], 3.0);
    // What is behind the triangle is not seen from above: only what is beside it.
    let lit = 3.0 * solid_angle_of(1.0, [-0.6, 0.1], [-0.7, 0.3]);
    // The triangle is lit from above as well.
    let on_it = 3.0 * solid_angle_of(0.5, [0.1, 0.4], [-0.7, 0.3]);
    assert_mean(&scene, [lit + on_it, 1.0], 1e-5);
    // Beside the camera's view: its edge at x = 1 has its shadow's at −0.1.
    let scene = one_pixel()
        .plane([0.0; 3], [0.0, 0.0, 1.0])
        .triangle([[1.0, -99.0, 0.5], [1.0, 99.0, 0.5], [55.0, 0.0, 0.5]])
        .light([2.1, 0.2, 1.0], 3.0);
    let lit = 3.0 * solid_angle_of(1.0, [-2.6, -2.2], [-0.7, 0.3]);
    assert_mean(&scene, [lit, 1.0], 1e-5);
}

/// A highlight much smaller than the pixel, by brute force.
#[test]
fn a_peak() {
    for (shininess, radius) in [(1000.0, 2.0), (1000.0, 0.3)] {
        let scene = one_pixel()
            .material("matte", Material::Phong(lobes(0.1, 1.0, Some(shininess))))
            .sphere([0.0, 0.0, -radius], radius)
            .light([0.5, 0.3, 4.0], 3.0);
        let oracle = scene.oracle();
        let mut sum = 0.0;
        let mut covered = 0.0;
        let cells = 60;
        for cell in 0..cells * cells {
            let corner = [cell % cells, cell / cells].map(f64::from);
            for [x, wx] in SEVEN {
                for [y, wy] in SEVEN {
                    let [x, y] = [corner[0] + x, corner[1] + y].map(|at| at / f64::from(cells));
                    let sample = oracle.radiance(x, y);
                    sum += wx * wy * sample.radiance[0];
                    covered += wx * wy * sample.coverage;
                }
            }
        }
        let count = f64::from(cells * cells);
        let mean = PixelQuadrature::new(&oracle).pixel(0, 0, TOLERANCE);
        println!("{mean:?} {} {}", sum / count, covered / count);
        let off = (mean.radiance[0] - sum / count).abs();
        let room = if radius > 1.0 { 1e-9 } else { 1e-4 };
        assert!(off <= room * mean.radiance[0] + mean.error[0], "{off:e}");
        assert!(mean.is_resolved);
    }
}

/// The penumbra of an area, against many points of the image.
#[test]
fn pixels_of_a_penumbra() {
    use crate::scene::{Aim, AreaShape, Entry, Light, Span, Value};
    let mut scene = Builder::new([8, 8], orthographic([0.0, 5.0, 0.0], [0.0; 3], 2.0))
        .plane([0.0; 3], [0.0, 1.0, 0.0])
        .triangle([[-9.0, 0.4, 0.0], [0.3, 0.4, 0.1], [-0.2, 0.4, 9.0]]);
    scene.0.lights.push(Entry {
        name: "panel".to_owned(),
        span: Span::default(),
        value: Light::Area {
            shape: AreaShape::Rectangle {
                center: [0.5, 1.0, -0.5].into(),
                aim: Aim::LookAt([0.0; 3].into()),
                up: None,
                size: [0.5, 0.3].into(),
                two_sided: false,
            },
            luminance: Value::Uniform(5.0).into(),
            visible: true,
            samples: 64.0.into(),
            group: None,
        },
    });
    let oracle = scene.oracle();
    let pixels = PixelQuadrature::new(&oracle);
    const STEPS: u32 = 60;
    for ([x, y], few) in [
        ([2, 3], 5e-7),
        ([3, 4], 2e-4),
        ([5, 3], 1e-5),
        ([4, 6], 2e-6),
    ] {
        let pixel = pixels.pixel(x, y, 1e-4);
        assert!(pixel.is_resolved);
        assert!(pixel.error[0] <= 2e-6, "{:e}", pixel.error[0]);
        let mut sum = 0.0;
        for i in 0..STEPS {
            for j in 0..STEPS {
                let [u, v] = [i, j].map(|i| (f64::from(i) + 0.5) / f64::from(STEPS));
                sum += oracle.radiance(f64::from(x) + u, f64::from(y) + v).radiance[0];
            }
        }
        let mean = sum / f64::from(STEPS * STEPS);
        let off = (pixel.radiance[0] - mean).abs();
        assert!(off <= pixel.error[0] + few, "{x}, {y}: off by {off:e}");
    }
}
