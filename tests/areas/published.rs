//! Integrals over what one point sees of a light, from closed forms checked by quadrature to twelve digits.

use std::f64::consts::{PI, TAU};

use super::{AtOrigin, ROUNDING, triangles};

const UP: [f64; 3] = [0.0, 0.0, 1.0];
const WHITE: &str = "phong]\ndiffuse = 1";

const SQUARE: &str = "rectangle]\ncenter = [0, 0, 1]\ndirection = [0, 0, -1]\nsize = [1, 1]";
const WALL: &str =
    "rectangle]\ncenter = [1, 1, 1]\ndirection = [-1, 0, 0]\nup = [0, 0, 1]\nsize = [2, 1]";

/// Six triangles around a hole that is a triangle, so far that a light behind it is seen through the hole alone.
fn wall_around(hole: [[f64; 3]; 3]) -> String {
    let [a, b, c] = hole;
    let middle = [0, 1, 2].map(|axis: usize| (a[axis] + b[axis] + c[axis]) / 3.0);
    let far = |corner: [f64; 3]| {
        [0, 1, 2].map(|axis: usize| middle[axis] + 100.0 * (corner[axis] - middle[axis]))
    };
    let sides = [[a, b], [b, c], [c, a]]
        .map(|[from, to]| [[from, far(from), far(to)], [from, far(to), to]]);
    triangles(sides.as_flattened())
}

#[track_caller]
fn is_near(place: &AtOrigin<'_>, expected: f64) {
    let actual = place.radiance();
    let error = (actual / expected - 1.0).abs();
    assert!(
        error <= ROUNDING,
        "{actual}, expected {expected}\n{}",
        place.scene()
    );
}

#[track_caller]
fn irradiance_is(light: &str, objects: &str, expected: f64) {
    let place = AtOrigin {
        normal: UP,
        material: WHITE,
        to_viewer: UP,
        light,
        objects,
    };
    is_near(&place, expected);
}

#[test]
fn of_rectangles() {
    let sunk =
        "rectangle]\ncenter = [1, 0, 0]\ndirection = [-1, 0, 0]\nup = [0, 0, 1]\nsize = [2, 2]";
    irradiance_is(SQUARE, "", 0.752_274_688_454_1);
    irradiance_is(WALL, "", 0.242_317_295_298_5);
    irradiance_is(sunk, "", 0.350_188_287_713_9);
}

#[test]
fn of_spheres() {
    for (radius, distance, degrees, expected) in [
        (1.0, 3.0, 30.0_f64, 0.302_299_894_039),
        (1.0, 2.0, 75.0, 0.221_200_880_053),
        (1.0, 2.0, 90.0, 0.090_586_073_706_08),
        (1.0, 2.0, 110.0, 0.006_753_065_521_712),
        (0.9, 1.0, 100.0, 0.518_440_885_579_3),
    ] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let center = [distance * sin, 0.0, distance * cos];
        let light = format!("sphere]\ncenter = {center:?}\nradius = {radius:?}");
        irradiance_is(&light, "", expected);
    }
}

#[test]
fn of_disks() {
    for (center, direction, radius, expected) in [
        ([0.0, 0.0, 2.0], [0.0, 0.0, -1.0], 1.0, 0.2 * PI),
        ([1.5, 0.0, 2.0], [0.0, 0.0, -1.0], 1.0, 0.321_335_102_751_7),
        ([1.0, 0.0, 2.0], [-1.0, 0.0, -1.0], 0.5, 0.127_183_141_976_7),
    ] {
        let light =
            format!("disk]\ncenter = {center:?}\ndirection = {direction:?}\nradius = {radius:?}");
        irradiance_is(&light, "", expected);
    }
}

/// There are no lights that are triangles, but there are holes in walls before lights.
#[test]
fn of_triangles() {
    let hole = [[1.0, 0.0, 2.0], [0.0, 1.0, 2.0], [-1.0, -1.0, 3.0]];
    for (normal, expected) in [
        (UP, 0.258_953_915_278_9),
        ([1.0, 2.0, 3.0], 0.218_092_502_827_3),
    ] {
        let place = AtOrigin {
            normal,
            material: WHITE,
            to_viewer: normal,
            light: "rectangle]\ncenter = [0, 0, 5]\ndirection = [0, 0, -1]\nsize = [6, 6]",
            objects: &wall_around(hole),
        };
        is_near(&place, expected);
    }
    // One corner of it is below the horizon.
    let hole = [[2.0, 0.0, -1.0], [0.0, 2.0, 1.0], [-1.0, 0.0, 2.0]];
    let light = "rectangle]\ncenter = [1, 2, 1]\ndirection = [-1, 0, -1]\nsize = [10, 6]";
    irradiance_is(light, &wall_around(hole), 1.007_414_075_184);
}

#[test]
fn of_lobes() {
    let glossy = |shininess: f64| format!("phong]\nspecular = 1\nshininess = {shininess:?}");
    // The mirrored view is along (0.3, 0.1, 1).
    let square = |material: &str, expected: f64| {
        let place = AtOrigin {
            normal: UP,
            material,
            to_viewer: [-0.3, -0.1, 1.0],
            light: SQUARE,
            objects: "",
        };
        is_near(&place, expected);
    };
    for (shininess, expected) in [
        (1.0, 0.717_265_772_277_4),
        (2.0, 0.644_560_501_359_9),
        (5.0, 0.489_963_703_528_4),
        (12.5, 0.303_857_876_394_6),
        (20.0, 0.221_608_143_751_3),
        (50.0, 0.108_928_398_561_9),
    ] {
        square(&glossy(shininess), expected);
    }
    let normalized = "normalized_phong]\nspecular = 1\nshininess = 20";
    square(normalized, 22.0 / TAU * 0.209_539_557_180_2);
    let place = AtOrigin {
        normal: UP,
        material: &glossy(50.0),
        to_viewer: [-1.0, -1.0, 1.0],
        light: WALL,
        objects: "",
    };
    is_near(&place, 0.102_967_831_981_2);
}

/// What is left of the square where all is dark that is seen through x < 0.1 at z = 0.5: behind one triangle, behind
/// two, and behind a plane.
#[test]
fn of_a_shadow_with_one_straight_border() {
    let plane = "[objects.p.plane]\nmaterial = \"m\"\npoint = [0.2, 0, 1]\nnormal = [-1, 0, 1]\n";
    let [a, b, c, d] =
        [[-9.0, -9.0], [0.1, -9.0], [0.1, 9.0], [-9.0, 9.0]].map(|[x, y]| [x, y, 0.5]);
    for objects in [
        triangles(&[[[-9.0, 0.0, 0.5], b, c]]),
        triangles(&[[a, b, c], [a, c, d]]),
        plane.to_owned(),
    ] {
        irradiance_is(SQUARE, &objects, 0.207_575_167_619_8);
    }
}

#[test]
fn of_shadows() {
    for (triangle, expected) in [
        (
            [[-0.1, -0.1, 0.5], [0.15, -0.05, 0.5], [0.0, 0.15, 0.5]],
            0.642_357_466_148_9,
        ),
        (
            [[0.0, -0.1, 0.5], [0.4, 0.05, 0.5], [0.05, 0.3, 0.5]],
            0.554_641_868_674,
        ),
    ] {
        irradiance_is(SQUARE, &triangles(&[triangle]), expected);
    }
    let globe = "sphere]\ncenter = [0, 1, 4]\nradius = 1";
    let ball = "[objects.b.sphere]\nmaterial = \"m\"\ncenter = [0.2, 0.4, 2]\nradius = 0.5\n";
    irradiance_is(globe, "", 0.179_281_914_787_8);
    irradiance_is(globe, ball, 0.047_965_214_289_76);
}
