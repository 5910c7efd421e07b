//! Lights with an area against closed forms, all at p = 0 with n = z.

use super::*;
use crate::oracle::surface::Shape;
use crate::oracle::vector::{cross, dot, narrowed, unit};
use crate::oracle::wide::Real;
use crate::oracle::{AreaTerms, Outcome, Sample};
use crate::scene::{Aim, AreaShape};

/// The vectors have 13 digits.
const DIGITS: f64 = 2e-12;

/// A light of 1 cd/m² that is not seen itself.
fn light(shape: AreaShape) -> Light {
    Light::Area {
        shape,
        luminance: Value::Uniform(1.0).into(),
        visible: false,
        samples: 64.0.into(),
        group: None,
    }
}

fn rectangle(center: [f64; 3], direction: [f64; 3], up: [f64; 3], size: [f64; 2]) -> AreaShape {
    AreaShape::Rectangle {
        center: center.into(),
        aim: Aim::Direction(direction.into()),
        up: Some(up.into()),
        size: size.into(),
        two_sided: false,
    }
}

fn disk(center: [f64; 3], direction: [f64; 3], radius: f64) -> AreaShape {
    AreaShape::Disk {
        center: center.into(),
        aim: Aim::Direction(direction.into()),
        radius: radius.into(),
        two_sided: false,
    }
}

fn ball(center: [f64; 3], radius: f64) -> AreaShape {
    AreaShape::Sphere {
        center: center.into(),
        radius: radius.into(),
    }
}

/// ±0.5 at z = 1.
fn square() -> AreaShape {
    rectangle([0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0; 2])
}

impl Builder {
    fn area(mut self, shape: AreaShape) -> Self {
        let name = format!("light{}", self.0.lights.len());
        self.0.lights.push(entry(&name, light(shape)));
        self
    }

    fn seen_area(mut self, shape: AreaShape) -> Self {
        self = self.area(shape);
        if let Some(Light::Area { visible, .. }) =
            self.0.lights.last_mut().map(|entry| &mut entry.value)
        {
            *visible = true;
        }
        self
    }
}

/// The floor z = 0, seen from aside.
fn floor() -> Builder {
    Builder::looking([3.0, -2.0, 0.7], [0.0; 3]).plane([0.0; 3], [0.0, 0.0, 1.0])
}

/// The radiance and how far it may be off, which has to be enough.
#[track_caller]
fn assert_integral(scene: &Builder, expected: f64, tolerance: f64) {
    let Sample {
        radiance, error, ..
    } = scene.oracle().radiance(0.5, 0.5);
    let off = (radiance[0] - expected).abs() / expected;
    let estimate = error[0] / expected;
    assert!(
        off <= tolerance,
        "{} is off by {off:e}, by an estimate of {estimate:e}",
        radiance[0]
    );
    assert!(estimate <= 1e-7, "the estimate is {estimate:e}");
    assert!(
        off <= estimate + DIGITS,
        "{off:e} by an estimate of {estimate:e}"
    );
}

#[test]
fn rectangles() {
    let panel = |y: [f64; 2], z: [f64; 2]| {
        let center = [1.0, 0.5 * (y[0] + y[1]), 0.5 * (z[0] + z[1])];
        let size = [y[1] - y[0], z[1] - z[0]];
        rectangle(center, [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], size)
    };
    for (shape, expected) in [
        (square(), 0.752_274_688_454_1),
        (panel([0.0, 2.0], [0.5, 1.5]), 0.242_317_295_298_5),
        (panel([-1.0, 1.0], [-1.0, 1.0]), 0.350_188_287_713_9),
    ] {
        assert_integral(&floor().area(shape), expected, DIGITS);
    }
}

#[test]
fn spheres() {
    for (radius, distance, angle, expected) in [
        (1.0, 3.0, 30.0_f64, 0.302_299_894_039),
        (1.0, 2.0, 75.0, 0.221_200_880_053),
        (1.0, 2.0, 90.0, 0.090_586_073_706_08),
        (1.0, 2.0, 110.0, 0.006_753_065_521_712),
        (0.9, 1.0, 100.0, 0.518_440_885_579_3),
    ] {
        let (sin, cos) = angle.to_radians().sin_cos();
        // Turned so that the eye is not within it.
        let center = [-0.6 * distance * sin, 0.8 * distance * sin, distance * cos];
        assert_integral(&floor().area(ball(center, radius)), expected, DIGITS);
    }
}

#[test]
fn disks() {
    let down = [0.0, 0.0, -1.0];
    for (shape, expected) in [
        (disk([0.0, 0.0, 2.0], down, 1.0), 0.628_318_530_718),
        (disk([1.5, 0.0, 2.0], down, 1.0), 0.321_335_102_751_7),
        (
            disk([1.0, 0.0, 2.0], [-1.0, 0.0, -1.0], 0.5),
            0.127_183_141_976_7,
        ),
    ] {
        assert_integral(&floor().area(shape), expected, DIGITS);
    }
}

/// The floor with this material, seen from where the mirror image of (0.3, 0.1, 1) is.
fn mirrored(material: Material) -> Builder {
    Builder::looking([-0.9, -0.3, 3.0], [0.0; 3])
        .material(MATTE, material)
        .plane([0.0; 3], [0.0, 0.0, 1.0])
}

#[test]
fn lobes_of_the_square() {
    for (n, expected) in [
        (1.0, 0.717_265_772_277_4),
        (2.0, 0.644_560_501_359_9),
        (5.0, 0.489_963_703_528_4),
        (12.5, 0.303_857_876_394_6),
        (20.0, 0.221_608_143_751_3),
        (50.0, 0.108_928_398_561_9),
    ] {
        let scene = mirrored(Material::Phong(lobes(0.0, 1.0, Some(n)))).area(square());
        assert_integral(&scene, expected, DIGITS);
    }
    let material = Material::NormalizedPhong(lobes(0.0, 1.0, Some(20.0)));
    let expected = 0.209_539_557_180_2 * 22.0 / std::f64::consts::TAU;
    assert_integral(&mirrored(material).area(square()), expected, DIGITS);
}

/// A lobe that the square is far wider than: 2π/(n + 1).
#[test]
fn narrow_lobes_are_resolved() {
    for n in [3e3, 1e4, 1e5] {
        let scene = mirrored(Material::Phong(lobes(0.0, 1.0, Some(n)))).area(square());
        let expected = std::f64::consts::TAU / (n + 1.0);
        assert_integral(&scene, expected, 2e-9);
    }
}

#[test]
fn shadows_on_the_square() {
    let at = |[x, y]: [f64; 2]| [x, y, 0.5];
    for (corners, expected) in [
        (
            [[-0.1, -0.1], [0.15, -0.05], [0.0, 0.15]],
            0.642_357_466_148_9,
        ),
        ([[0.0, -0.1], [0.4, 0.05], [0.05, 0.3]], 0.554_641_868_674_5),
    ] {
        let scene = floor().area(square()).triangle(corners.map(at));
        assert_integral(&scene, expected, 2e-8);
        let terms = scene.first_light();
        assert_eq!(terms.outcome, Outcome::Partial);
        let AreaTerms {
            seen, occluders, ..
        } = terms.area.unwrap();
        assert_near(seen, expected / 0.752_274_688_454_1, 2e-8);
        assert_eq!(occluders, ["object1"]);
    }
}

#[test]
fn a_sphere_behind_a_sphere() {
    let scene = floor().area(ball([0.0, 1.0, 4.0], 1.0));
    assert_integral(&scene, 0.179_281_914_787_8, DIGITS);
    let scene = scene.sphere([0.2, 0.4, 2.0], 0.5);
    assert_integral(&scene, 0.047_965_214_289_76, 2e-8);
}

/// A number from −1 to 1 for each.
fn scattered(number: u32, of: u32) -> f64 {
    (f64::from(number) * 1.618_033_988_749_895 + f64::from(of) * 0.7).sin()
}

/// The scene with as many point lights in the place of its first light, an area of 1 cd/m² seen from the origin.
fn as_points(scene: &Builder, shape: &AreaShape, across: u32) -> Builder {
    let mut points = scene.clone();
    points.0.lights.remove(0);
    let area = crate::oracle::area::Area::new(shape, false, [0.0; 3]).unwrap();
    let mut add = |point: [f64; 3], normal: [f64; 3], size: f64| {
        let distance = dot(point, point).sqrt();
        let cos = -dot(point, normal) / distance;
        if cos > 0.0 {
            points = points.clone().light(point, cos * size);
        }
    };
    for i in 0..across {
        for j in 0..across {
            let [s, t] = [i, j].map(|i| (f64::from(i) + 0.5) / f64::from(across));
            let cell = f64::from(across * across).recip();
            match &area.shape {
                Shape::Rectangle {
                    center,
                    normal,
                    halves,
                } => {
                    let [center, normal, a, b] =
                        [*center, *normal, halves[0], halves[1]].map(narrowed);
                    let point = plus(plus(center, a, 2.0 * s - 1.0), b, 2.0 * t - 1.0);
                    let size = 4.0 * (dot(a, a) * dot(b, b)).sqrt();
                    add(point, normal, size * cell);
                }
                Shape::Disk {
                    center,
                    normal,
                    radius,
                } => {
                    let [center, normal] = [*center, *normal].map(narrowed);
                    let a = unit(cross(normal, [0.3, 0.5, 0.9])).unwrap();
                    let b = cross(normal, a);
                    let r = radius.narrow() * s.sqrt();
                    let (sin, cos) = (std::f64::consts::TAU * t).sin_cos();
                    let point = plus(plus(center, a, r * cos), b, r * sin);
                    let size = std::f64::consts::PI * radius.narrow().powi(2);
                    add(point, normal, size * cell);
                }
                Shape::Sphere { center, radius } => {
                    let (center, radius) = (narrowed(*center), radius.narrow());
                    let z = 2.0 * s - 1.0;
                    let (sin, cos) = (std::f64::consts::TAU * t).sin_cos();
                    let across = (1.0 - z * z).sqrt();
                    let normal = [across * cos, across * sin, z];
                    let size = 4.0 * std::f64::consts::PI * radius * radius;
                    add(plus(center, normal, radius), normal, size * cell);
                }
                Shape::Plane { .. } | Shape::Triangle { .. } => unreachable!(),
            }
        }
    }
    points
}

fn plus(a: [f64; 3], b: [f64; 3], factor: f64) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] + factor * b[i])
}

/// L9 over points, by the code for points: whatever is in the way, they agree as far as so few points can.
#[test]
fn an_area_is_many_points() {
    let down = [0.1, -0.2, -1.0];
    let mut partial = 0;
    for number in 0..36 {
        let of = |which: u32| scattered(number, which);
        let center = [0.5 * of(0), 0.5 * of(1), 2.0 + 0.3 * of(2)];
        let shape = match number % 3 {
            0 => rectangle(center, down, [1.0, of(3), 0.2], [1.0, 0.7]),
            1 => disk(center, down, 0.6),
            _ => ball(center, 0.6),
        };
        let material = match number % 2 {
            0 => Material::Phong(lobes(0.5, 0.4, Some(6.0))),
            _ => Material::NormalizedPhong(lobes(0.5, 0.4, Some(3.0))),
        };
        let scene = floor().area(shape.clone()).material(MATTE, material);
        let middle = [0.6 * of(4), 0.6 * of(5), 1.1 + 0.5 * of(6)];
        let corner = |which: u32| plus(middle, [of(which), of(which + 1), of(which + 2)], 0.5);
        let scene = match (number / 3) % 6 {
            0 => scene.sphere(middle, 0.25),
            1 => scene.triangle([corner(7), corner(10), corner(13)]),
            2 => scene.plane(middle, [1.0, of(7), of(8)]),
            3 => scene.seen_area(disk(middle, [of(7), of(8), 1.0], 0.3)),
            4 => scene.seen_area(rectangle(
                middle,
                [of(7), of(8), 1.0],
                [1.0, 0.3, of(9)],
                [0.5; 2],
            )),
            // Through the light.
            _ => scene
                .sphere(plus(center, [of(7), of(8), of(9)], 0.4), 0.4)
                .triangle([corner(7), plus(center, [0.2, 0.1, 0.5], 1.0), corner(13)]),
        };
        // Of two lights only the first.
        let mut scene = scene;
        if let Some(Entry {
            value: Light::Area { luminance, .. },
            ..
        }) = scene.0.lights.get_mut(1)
        {
            luminance.value = Value::ZERO;
        }
        let sample = scene.oracle().radiance(0.5, 0.5);
        if scene.oracle().trace(0.5, 0.5).map(|hit| hit.object) != Some(0) {
            continue;
        }
        let points = as_points(&scene, &shape, 48).radiance();
        let whole = scene.first_light().unoccluded[0];
        let off = (sample.radiance[0] - points).abs() / whole;
        assert!(
            off < 0.012,
            "{number}: {} by {points}, of {whole}",
            sample.radiance[0]
        );
        let seen = scene.first_light().area.unwrap().seen;
        assert!((-1e-9..=1.0 + 1e-9).contains(&seen), "{number}: {seen}");
        partial += u32::from(seen > 0.01 && seen < 0.99);
    }
    assert!(partial > 8, "{partial}");
}
