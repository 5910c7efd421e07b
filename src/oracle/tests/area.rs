//! Lights with an area against closed forms, all at p = 0 with n = z.

use super::*;
use crate::oracle::surface::Shape;
use crate::oracle::vector::{cross, dot, narrowed, unit};
use crate::oracle::wide::Real;
use crate::oracle::{AreaTerms, Outcome, Sample};
use crate::scene::{Aim, AreaShape, Unit};

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

pub(super) fn rectangle(
    center: [f64; 3],
    direction: [f64; 3],
    up: [f64; 3],
    size: [f64; 2],
) -> AreaShape {
    AreaShape::Rectangle {
        center: center.into(),
        aim: Aim::Direction(direction.into()),
        up: Some(up.into()),
        size: size.into(),
        two_sided: false,
    }
}

pub(super) fn disk(center: [f64; 3], direction: [f64; 3], radius: f64) -> AreaShape {
    AreaShape::Disk {
        center: center.into(),
        aim: Aim::Direction(direction.into()),
        radius: radius.into(),
        two_sided: false,
    }
}

pub(super) fn ball(center: [f64; 3], radius: f64) -> AreaShape {
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
    pub(super) fn area(mut self, shape: AreaShape) -> Self {
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

pub(super) fn plus(a: [f64; 3], b: [f64; 3], factor: f64) -> [f64; 3] {
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
        let middle = plus([0.2 * of(4), 0.2 * of(5), 0.1 * of(6)], center, 0.5);
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
            off < 0.022,
            "{number}: {} by {points}, of {whole}",
            sample.radiance[0]
        );
        let seen = scene.first_light().area.unwrap().seen;
        assert!((-1e-9..=1.0 + 1e-9).contains(&seen), "{number}: {seen}");
        partial += u32::from(seen > 0.01 && seen < 0.99);
    }
    assert!(partial > 24, "{partial}");
}

/// Whether little effort or much: the estimate covers what is off.
#[test]
fn estimates_cover_what_little_effort_misses() {
    for number in 0..12 {
        let shape = match number % 2 {
            0 => ball([0.0, 1.0, 4.0], 1.0),
            _ => square(),
        };
        let [x, y] = [0, 1].map(|of| 0.3 * scattered(number, of));
        let placed = match shape {
            AreaShape::Sphere { .. } => Placed {
                scale: [0.5; 3],
                translate: [x, 0.5 + y, 2.0],
                ..AS_IS
            },
            _ => Placed {
                scale: [0.2; 3],
                translate: [x, y, 0.5],
                ..AS_IS
            },
        };
        let oracle = floor().area(shape).mesh(&globe(8), placed).oracle();
        let exact = oracle.clone().with_effort(1_000_000).radiance(0.5, 0.5);
        assert!(exact.error[0] < 1e-7, "{number}: {:e}", exact.error[0]);
        for effort in [1, 3_000, 10_000, 30_000] {
            let rough = oracle.clone().with_effort(effort).radiance(0.5, 0.5);
            let off = (rough.radiance[0] - exact.radiance[0]).abs();
            assert!(
                off <= rough.error[0] + exact.error[0],
                "{number}, {effort}: {off:e} by {:e}",
                rough.error[0]
            );
        }
    }
}

/// A light of 1 cd/m² as it is seen itself.
fn shining(shape: AreaShape, eye: [f64; 3]) -> (Sample, crate::oracle::Explanation) {
    let oracle = Builder::looking(eye, [0.0, 0.0, 1.0])
        .plane([0.0, 0.0, -5.0], [0.0, 0.0, 1.0])
        .seen_area(shape)
        .oracle();
    (oracle.radiance(0.5, 0.5), oracle.explain(0.5, 0.5))
}

#[test]
fn a_light_is_seen_from_where_it_shines_to() {
    let two_sided = |mut shape| {
        if let AreaShape::Rectangle { two_sided, .. } | AreaShape::Disk { two_sided, .. } =
            &mut shape
        {
            *two_sided = true;
        }
        shape
    };
    let down = disk([0.0, 0.0, 1.0], [0.0, 0.0, -1.0], 0.5);
    let (below, above, within) = ([0.3, 0.0, -1.0], [0.3, 0.0, 3.0], [0.1, 0.0, 1.2]);
    for (shape, eye, expected) in [
        (square(), below, 1.0),
        (square(), above, 0.0),
        (two_sided(square()), above, 1.0),
        (down.clone(), below, 1.0),
        (down.clone(), above, 0.0),
        (two_sided(down), above, 1.0),
        (ball([0.0, 0.0, 1.0], 0.5), above, 1.0),
        (ball([0.0, 0.0, 1.0], 0.5), within, 0.0),
    ] {
        let (sample, explanation) = shining(shape, eye);
        assert_eq!(sample.radiance, [expected; 3]);
        assert_eq!(sample.coverage, 1.0);
        let hit = explanation.hit.unwrap();
        assert_eq!((&hit.object[..], &hit.material[..]), ("light0", "light0"));
        let emission = hit.emission.unwrap();
        assert_eq!(emission.luminance, [expected; 3]);
        assert_eq!(emission.shines, expected > 0.0);
        assert!(explanation.lights.is_empty());
    }
}

#[test]
fn objects_come_before_lights_and_lights_by_the_file() {
    let scene = Builder::looking([0.0, 0.0, -1.0], [0.0, 0.0, 1.0])
        .seen_area(square())
        .seen_area(square());
    let name = |scene: &Builder| {
        let oracle = scene.oracle();
        oracle.name_of(oracle.trace(0.5, 0.5).unwrap()).to_owned()
    };
    assert_eq!(name(&scene), "light0");
    let ceiling = scene.plane([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]);
    assert_eq!(name(&ceiling), "object0");
}

/// What is not seen is not hit, and hides nothing.
#[test]
fn lights_are_in_the_way_of_others_if_they_are_seen() {
    let panel = || disk([0.0, 0.0, 0.5], [0.0, 0.0, 1.0], 0.1);
    let lamp = |scene: Builder| scene.light([0.0, 0.0, 1.0], 1.0).oracle();
    let shaded = lamp(floor().seen_area(panel())).explain(0.5, 0.5);
    assert_eq!(shaded.lights[0].outcome, Outcome::Outside);
    assert_eq!(shaded.lights[1].outcome, Outcome::Occluded);
    assert_eq!(shaded.lights[1].occluder.as_deref(), Some("light0"));
    let free = lamp(floor().area(panel())).explain(0.5, 0.5);
    assert_eq!(free.lights[1].outcome, Outcome::Lit);
    // Nothing is in its own way.
    for shape in [square(), ball([0.0, 0.0, 2.0], 1.0)] {
        let terms = floor().seen_area(shape).first_light();
        assert_eq!(terms.outcome, Outcome::Lit);
        assert_eq!(terms.area.unwrap().seen, 1.0);
    }
}

/// A panel in a ceiling, one that stands on the floor, and a globe in a shell of its size.
#[test]
fn what_a_light_touches_does_not_hide_it() {
    let ceiling = |scene: Builder| scene.plane([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]);
    let standing = || rectangle([1.0, 0.0, 0.5], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0; 2]);
    for scene in [
        ceiling(floor().area(square())),
        ceiling(floor().area(ball([0.0, 0.0, 0.5], 0.5))),
        floor().area(standing()),
        floor()
            .area(standing())
            .plane([1.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
        floor()
            .area(ball([0.1, 0.2, 2.0], 0.5))
            .sphere([0.1, 0.2, 2.0], 0.5),
    ] {
        let terms = scene.first_light();
        if terms.outcome == Outcome::Outside {
            // The globe stands on p.
            continue;
        }
        assert_eq!(terms.outcome, Outcome::Lit, "{:?}", terms.area);
    }
    let hidden = floor()
        .area(square())
        .plane([0.0, 0.0, 0.999], [0.0, 0.0, 1.0]);
    assert_eq!(hidden.first_light().outcome, Outcome::Occluded);
    let below = floor().area(ball([0.0, 0.0, -2.0], 1.0)).first_light();
    assert_eq!(below.outcome, Outcome::Below);
}

/// Far away, a light is a point.
#[test]
fn a_small_light_is_a_point() {
    let radiance = |scene: Builder| {
        let material = Material::NormalizedPhong(lobes(0.3, 0.5, Some(40.0)));
        scene.material(MATTE, material).radiance()
    };
    let place = [-0.5, 0.4, 2.0];
    let (radius, intensity) = (1e-5, std::f64::consts::PI * 1e-10);
    let point = radiance(floor().light(place, intensity));
    assert_near(radiance(floor().area(ball(place, radius))), point, 1e-8);
    let facing = disk(place, place.map(|c| -c), radius);
    assert_near(radiance(floor().area(facing)), point, 1e-8);
}

/// What leaves a light, by its units.
#[test]
fn sizes_of_areas() {
    use std::f64::consts::PI;
    let two_sided = AreaShape::Disk {
        center: [0.0, 0.0, 1.0].into(),
        aim: Aim::LookAt([0.0; 3].into()),
        radius: 0.5.into(),
        two_sided: true,
    };
    for (shape, area, faces) in [
        (square(), 1.0, PI),
        (two_sided, PI / 4.0, 2.0 * PI),
        (ball([0.0, 0.0, 1.0], 0.5), PI / 4.0, 4.0 * PI),
    ] {
        for (unit, amount) in [
            (Unit::Nits, 3.0),
            (Unit::Candela, 3.0 * area),
            (Unit::Lumens, 3.0 * area * faces),
        ] {
            let mut scene = floor().area(shape.clone());
            let Light::Area { luminance, .. } = &mut scene.0.lights[0].value else {
                unreachable!()
            };
            luminance.value = Value::Sized {
                unit,
                amount,
                color: Box::new(Value::Uniform(1.0)),
            };
            let [red, ..] = scene.first_light().intensity;
            assert_near(red, 3.0, ROUNDING);
        }
    }
}
