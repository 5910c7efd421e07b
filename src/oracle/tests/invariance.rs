//! The image of a scene does not depend on the scene's size or place.

use super::*;

/// A scene with everything in it: touching balls, a mesh, shadows of each on the others.
/// All coordinates are multiples of 1/64, so that they can be moved and doubled exactly.
fn lecture(scale: f64, moved: [f64; 3]) -> Scene {
    let length = |x: f64| x * scale;
    let at = |point: [f64; 3]| [0, 1, 2].map(|i| point[i] * scale + moved[i]);
    let camera = perspective(at([1.0, 3.0, 6.0]), at([0.0, 0.5, 0.0]), 40.0);
    Builder::new([64, 48], camera)
        .material(MATTE, Material::Phong(lobes(0.5, 0.25, Some(20.0))))
        .plane(at([0.0; 3]), [0.0, 1.0, 0.0])
        .plane(at([0.0, 0.0, -2.5]), [0.125, 0.25, 1.0])
        .sphere(at([0.0, 0.5, 0.0]), length(0.5))
        .sphere(at([1.0, 0.5, 0.0]), length(0.5))
        .triangle([[-2.0, 0.0, 1.0], [-1.0, 0.0, 1.5], [-1.5, 1.5, 1.0]].map(at))
        .mesh(
            &globe(5),
            Placed {
                scale: [length(0.5), length(0.75), length(0.25)],
                rotate: [10.0, 20.0, 30.0],
                translate: at([-1.0, 1.0, -0.5]),
                smooth: true,
                shadow_terminator: ShadowTerminator::Hanika,
            },
        )
        .light(at([3.0, 4.0, 3.0]), 30.0)
        .light(at([-2.0, 2.0, 4.0]), 10.0)
        .light(at([0.5, 1.5, 0.0]), 2.0)
        .0
}

/// Compares the images pixel by pixel: radiance as `expected` × `factor`, within `tolerance`
/// where both decide alike. Returns how many pixels do not.
fn disagreements(actual: &Scene, expected: &Scene, factor: f64, tolerance: f64) -> usize {
    let (actual, expected) = (Oracle::new(actual), Oracle::new(expected));
    let mut disagreements = 0;
    let (mut covered, mut dark) = (0, 0);
    for (x, y) in (0..64).flat_map(|x| (0..48).map(move |y| (x, y))) {
        let (px, py) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
        if actual.decisions(px, py) != expected.decisions(px, py) {
            disagreements += 1;
            continue;
        }
        let (actual, expected) = (actual.radiance(px, py), expected.radiance(px, py));
        covered += i32::from(expected.coverage > 0.0);
        dark += i32::from(expected.radiance[0] == 0.0);
        let difference = (actual.radiance[0] - expected.radiance[0] * factor).abs();
        assert!(
            difference <= tolerance * expected.radiance[0] * factor,
            "pixel ({x}, {y}): {actual:?}, expected {expected:?} × {factor}"
        );
    }
    assert!(covered > 2000 && dark < 2000, "the scene shows something");
    disagreements
}

#[test]
fn a_scene_of_twice_the_size_to_the_bit() {
    let one = lecture(1.0, [0.0; 3]);
    for exponent in [-40, -20, -1, 1, 20, 40] {
        let scale = 2.0_f64.powi(exponent);
        let other = lecture(scale, [0.0; 3]);
        // Powers of two are exact in every operation; light falls with the square.
        let factor = 1.0 / (scale * scale);
        assert_eq!(disagreements(&other, &one, factor, 0.0), 0, "{scale}");
    }
}

/// Highlights amplify rounding by their exponent, rims of spheres by 1 / cos.
const AMPLIFIED_ROUNDING: f64 = 1e-9;

#[test]
fn a_scene_of_any_size() {
    let one = lecture(1.0, [0.0; 3]);
    for scale in [1e-6, 1e-3, 0.3, 1e3, 1e6] {
        let other = lecture(scale, [0.0; 3]);
        let factor = 1.0 / (scale * scale);
        assert_eq!(
            disagreements(&other, &one, factor, AMPLIFIED_ROUNDING),
            0,
            "{scale}"
        );
    }
}

#[test]
fn a_scene_far_away_to_the_bit() {
    let one = lecture(1.0, [0.0; 3]);
    for moved in [[1e6, -1e6, 1e6], [0.0, 3e9, 0.0]] {
        let other = lecture(1.0, moved);
        assert_eq!(disagreements(&other, &one, 1.0, 0.0), 0, "{moved:?}");
    }
}

#[test]
fn a_scene_far_away_with_rounded_coordinates() {
    let one = lecture(1.0, [0.0; 3]);
    let other = lecture(1.0, [1e6 + 0.1, 0.7 - 1e6, 1e6 / 3.0]);
    // Every coordinate is rounded to 1e-10.
    assert_eq!(disagreements(&other, &one, 1.0, 1e-6), 0);
}
