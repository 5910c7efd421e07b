//! Emitters and occluders at random: beside brute force, beside themselves in more cells and at other scales, and
//! with numbers of any size.

use super::super::shadow::Bounded;
use super::super::{Accuracy, Gloss, Occluder, Received, Receiver, ShadowSpace};
use super::brute::{Brute, TestEmitter};
use super::cubature::axes_across;
use super::fuzz::Random;
use super::shadows::{FINE, ORIGIN, icosphere, receiver};
use super::{direction, normal, v};
use crate::math::{DVec3, Point};

fn emitter(random: &mut Random) -> TestEmitter {
    let center = v(
        random.within(-0.5, 0.5),
        random.within(-0.5, 0.5),
        random.within(2.0, 4.0),
    );
    let facing = (random.direction() - DVec3::Z).normalize();
    match (random.within(0.0, 3.0)) as u32 {
        0 => {
            let [x, y] = axes_across(facing);
            TestEmitter::Rectangle(
                center,
                [x * random.within(0.2, 1.0), y * random.within(0.2, 1.0)],
            )
        }
        1 => TestEmitter::Disk(center, facing, random.within(0.2, 1.0)),
        _ => TestEmitter::Sphere(center, random.within(0.2, 1.0)),
    }
}

fn occluders(random: &mut Random, emitter: &TestEmitter) -> Vec<Occluder> {
    let count = 1 + random.within(0.0, 4.0) as u32;
    let middle = match *emitter {
        TestEmitter::Rectangle(center, _)
        | TestEmitter::Disk(center, ..)
        | TestEmitter::Sphere(center, _) => center,
    };
    let mut all = Vec::new();
    for _ in 0..count {
        let place =
            middle * random.within(-0.1, 1.2) + random.direction() * random.within(0.0, 0.5);
        let size = random.scale(0.05, 1.2);
        match random.within(0.0, 6.0) as u32 {
            0 => {
                let corners = [(); 3].map(|()| place + random.direction() * size);
                all.push(Occluder::Triangle(corners));
            }
            1 => all.push(Occluder::Ball {
                center: place,
                radius: size,
            }),
            2 => all.push(Occluder::Disk {
                center: place,
                normal: random.direction(),
                radius: size,
            }),
            3 => all.push(Occluder::Plane {
                point: place + random.direction() * 0.5,
                normal: random.direction(),
            }),
            4 => {
                let [a, b, c, d] = [(); 4].map(|()| place + random.direction() * size);
                let faces = [[a, b, c], [a, b, d], [a, c, d], [b, c, d]];
                all.extend(faces.map(Occluder::Triangle));
            }
            _ => {
                let levels = random.within(1.0, 2.3) as u32;
                let triangles = icosphere(place, size, levels);
                all.extend(triangles.into_iter().map(Occluder::Triangle));
            }
        }
    }
    all
}

#[test]
fn shadows_are_what_brute_force_says() {
    let mut random = Random(17);
    let accuracy = Accuracy {
        relative: 1e-4,
        most_cells: 20_000,
    };
    let mut space = ShadowSpace::default();
    let mut worst = 0.0_f64;
    for case in 0..300 {
        let shape = emitter(&mut random);
        let occluders = occluders(&mut random, &shape);
        let point = random.direction() * 0.1;
        let horizon = (DVec3::Z * 1.2 + random.direction()).normalize();
        let shading = (horizon * 3.0 + random.direction()).normalize();
        let gloss = Gloss {
            axis: direction(DVec3::Z * 3.0 + random.direction()),
            shininess: random.scale(1.0, 60.0).floor(),
            has_cosine: case % 2 == 0,
        };
        let receiver = Receiver {
            horizon: normal(horizon),
            normal: normal(shading),
            gloss: Some(gloss),
        };
        let light = shape.emitter();
        let Some(free) = light.received(Point(point), &receiver) else {
            continue;
        };
        let bounded = light.received_past(
            Point(point),
            &receiver,
            &occluders,
            1e-12,
            &accuracy,
            &mut space,
        );
        let Bounded { value, error } = bounded.unwrap();
        let brute = Brute {
            emitter: &shape,
            point,
            receiver: &receiver,
            occluders: &occluders,
        };
        let count = 90;
        let expected = brute.received(count);
        for (name, value, error, expected, free) in [
            (
                "irradiance",
                value.irradiance,
                error.irradiance,
                expected.irradiance,
                free.irradiance,
            ),
            ("lobe", value.lobe, error.lobe, expected.lobe, free.lobe),
            (
                "solid angle",
                value.solid_angle,
                error.solid_angle,
                expected.solid_angle,
                free.solid_angle,
            ),
        ] {
            let off = (value - expected).abs() / free;
            worst = worst.max(off);
            let told = || {
                let few = &occluders[..occluders.len().min(4)];
                format!(
                    "{case} {name}: {value} ± {error:e}, {expected} of {free}\n{shape:?}\n{point}\n{few:?}"
                )
            };
            assert!(off <= 0.01 + error / free, "{}", told());
            assert!(error <= 1e-4 * free + 1e-7, "{}", told());
        }
    }
    assert!(worst < 0.01, "{worst}");
}

/// With whatever number of cells, what is found is no further off than it says: balls and disks that overlap, one
/// behind the other and behind triangles.
#[test]
fn bounds_hold_after_any_number_of_cells() {
    let mut random = Random(29);
    let mut space = ShadowSpace::default();
    let mut widest = [0.0_f64; 3];
    for _ in 0..200 {
        let shape = emitter(&mut random);
        let light = shape.emitter();
        let mut all = Vec::new();
        for _ in 0..4 {
            let center = random.direction() * 0.15 + DVec3::Z;
            let radius = random.within(0.05, 0.2);
            let normal = random.direction();
            all.extend([
                Occluder::Ball { center, radius },
                Occluder::Disk {
                    center,
                    normal,
                    radius: 1.3 * radius,
                },
            ]);
        }
        let triangle = [(); 3].map(|()| DVec3::Z * 0.7 + random.direction() * 0.2);
        all.push(Occluder::Triangle(triangle));
        let up = normal(DVec3::Z);
        let receiver = Receiver {
            horizon: up,
            normal: up,
            gloss: Some(Gloss {
                axis: direction(DVec3::Z * 3.0 + random.direction()),
                shininess: 20.0,
                has_cosine: true,
            }),
        };
        let mut found = |relative: f64, most_cells: usize| {
            let accuracy = Accuracy {
                relative,
                most_cells,
            };
            let bounded =
                light.received_past(ORIGIN, &receiver, &all, 1e-12, &accuracy, &mut space);
            bounded.unwrap_or_default()
        };
        let Some(free) = light.received(ORIGIN, &receiver) else {
            continue;
        };
        let best = found(1e-6, 100_000);
        let parts = |all: Received| [all.irradiance, all.lobe, all.solid_angle];
        for error in parts(best.error).iter().zip(parts(free)) {
            assert!(*error.0 <= 1e-6 * error.1 + 1e-8, "{error:?}");
        }
        for most_cells in [0, 1, 7, 50, 1000] {
            let coarse = found(1e-6, most_cells);
            let offs = parts(coarse.value - best.value).map(f64::abs);
            let bounds = parts(coarse.error + best.error);
            let frees = parts(free);
            for (place, widest) in widest.iter_mut().enumerate() {
                let (off, bound) = (offs[place], bounds[place]);
                assert!(off <= bound, "{most_cells}: {off:e} {bound:e}");
                assert!(bound <= 0.5 * frees[place] + 1e-5);
                if most_cells == 50 && bound > 0.0 {
                    *widest = widest.max(off / bound);
                }
            }
        }
    }
    // They would not be bounds of anything if nothing came close.
    assert!(widest.iter().all(|&part| part > 0.3), "{widest:?}");
}

/// The same from far away, and of any size.
#[test]
fn shadows_have_no_scale() {
    let mut random = Random(31);
    let mut space = ShadowSpace::default();
    let mut worst = 0.0_f64;
    for _ in 0..200 {
        let shape = emitter(&mut random);
        let size = random.scale(1e-3, 1e3);
        let (scaled, offset) = (random.direction() * size, random.direction() * size);
        let moved = |place: DVec3| place * size + offset;
        let triangle = [(); 3].map(|()| DVec3::Z + random.direction() * 0.3);
        let (center, radius) = (DVec3::Z * 0.8 + random.direction() * 0.2, 0.15);
        let all = [
            Occluder::Triangle(triangle),
            Occluder::Ball { center, radius },
        ];
        let moved_all = [
            Occluder::Triangle(triangle.map(moved)),
            Occluder::Ball {
                center: moved(center),
                radius: radius * size,
            },
        ];
        let moved_shape = match shape {
            TestEmitter::Rectangle(center, halves) => {
                TestEmitter::Rectangle(moved(center), halves.map(|half| half * size))
            }
            TestEmitter::Disk(center, facing, radius) => {
                TestEmitter::Disk(moved(center), facing, radius * size)
            }
            TestEmitter::Sphere(center, radius) => {
                TestEmitter::Sphere(moved(center), radius * size)
            }
        };
        let receiver = receiver(scaled);
        let mut found = |shape: &TestEmitter, point: DVec3, all: &[Occluder]| {
            let light = shape.emitter();
            let point = Point(point);
            light.received_past(point, &receiver, all, 0.0, &FINE, &mut space)
        };
        let one = found(&shape, DVec3::ZERO, &all);
        let other = found(&moved_shape, offset, &moved_all);
        let (Some(one), Some(other)) = (one, other) else {
            assert_eq!(one.is_some(), other.is_some());
            continue;
        };
        let bound = one.error.irradiance + other.error.irradiance;
        let off = (one.value.irradiance - other.value.irradiance).abs();
        worst = worst.max(off);
        assert!(off <= bound + 1e-14, "{off:e} {bound:e}");
    }
    assert!(worst < 1e-6, "{worst:e}");
}

/// Numbers of any size and shapes without any: there is a number, not below 0 and not above what is received with
/// nothing in the way.
#[test]
fn there_is_a_number_past_anything() {
    let mut random = Random(23);
    let accuracy = Accuracy {
        relative: 1e-3,
        most_cells: 300,
    };
    let mut space = ShadowSpace::default();
    for case in 0..4000 {
        let shape = emitter(&mut random);
        let mut occluders = occluders(&mut random, &shape);
        occluders.truncate(6);
        let point = random.direction() * random.scale(1e-9, 1.0);
        let size = random.scale(1e-12, 1e12);
        let number = match case % 7 {
            0 => 0.0,
            1 => f64::NAN,
            2 => f64::INFINITY,
            3 => 1e-300,
            4 => 1e200,
            _ => size,
        };
        let place = random.direction() * number;
        let near = DVec3::Z * random.within(0.0, 3.0);
        occluders.push(match case % 6 {
            0 => Occluder::Triangle([place, near, near + random.direction()]),
            1 => Occluder::Triangle([near, near, place]),
            2 => Occluder::Ball {
                center: near,
                radius: number,
            },
            3 => Occluder::Disk {
                center: near + place,
                normal: random.direction(),
                radius: size,
            },
            4 => Occluder::Plane {
                point: near,
                normal: place,
            },
            _ => Occluder::Ball {
                center: place,
                radius: number,
            },
        });
        let horizon = normal(random.direction());
        let receiver = Receiver {
            horizon,
            normal: horizon,
            gloss: None,
        };
        let light = shape.emitter();
        let bounded = light.received_past(
            Point(point),
            &receiver,
            &occluders,
            1e-12,
            &accuracy,
            &mut space,
        );
        let free = light.received(Point(point), &receiver).unwrap_or_default();
        let Bounded { value, error } = bounded.unwrap_or_default();
        for (value, error, free) in [
            (value.irradiance, error.irradiance, free.irradiance),
            (value.solid_angle, error.solid_angle, free.solid_angle),
        ] {
            assert!(
                value >= 0.0 && value <= free + error + 1e-12,
                "{case}: {value} of {free}"
            );
            assert!((0.0..=free + 1e-9).contains(&error), "{case}: {error}");
        }
    }
}

/// Near a disk's plane and a sphere's surface, from where they fill up to a half of all directions: triangles hide together no less
/// than each alone, and no more than all of them one by one.
#[test]
fn near_an_emitter_shadows_add_up() {
    let mut random = Random(41);
    let mut space = ShadowSpace::default();
    let mut judged = 0;
    for round in 0..20_000 {
        let height = random.scale(1e-6, 1.0);
        let emitter = if round % 4 == 0 {
            TestEmitter::Sphere(random.direction() * (1.0 + height), 1.0)
        } else {
            let [x, y] = [(); 2].map(|()| random.within(-1.2, 1.2));
            TestEmitter::Disk(v(x, y, height), -DVec3::Z, 1.0)
        };
        let emitter = emitter.emitter();
        let up = receiver(random.direction());
        let Some(free) = emitter.received(ORIGIN, &up) else {
            continue;
        };
        // Every other one is about as flat as what is between the point and the disk.
        let flat = if round % 2 == 0 { 1.0 } else { 3.0 * height };
        let triangles = [(); 3].map(|()| {
            let middle = random.direction() * random.within(0.1, 1.5);
            Occluder::Triangle([(); 3].map(|()| {
                let corner = middle + random.direction() * random.within(0.1, 0.7);
                v(corner.x, corner.y, corner.z * flat)
            }))
        });
        let mut hidden_by = |occluders: &[Occluder]| {
            let past = emitter.received_past(ORIGIN, &up, occluders, 1e-12, &FINE, &mut space);
            past.map(|past| free.irradiance - past.value.irradiance)
        };
        let Some(hidden) = hidden_by(&triangles) else {
            continue;
        };
        let [a, b, c] = triangles.map(|triangle| hidden_by(&[triangle]).unwrap());
        let room = 4.0 * FINE.relative * free.irradiance;
        assert!(
            hidden >= a.max(b).max(c) - room && hidden <= a + b + c + room,
            "{round}: {height:e}, {triangles:?} hide {hidden}, alone {a}, {b} and {c} of {}",
            free.irradiance
        );
        judged += 1;
    }
    assert!(judged > 15_000, "{judged}");
}
