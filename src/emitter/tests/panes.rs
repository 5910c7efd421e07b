//! What is received through panes, beside closed forms: where T is a power of v·u, what passes is a lobe of v.

use super::super::through::Panes;
use super::super::{Accuracy, Emitter, Gloss, Occluder, Received, Receiver, ShadowSpace};
use super::cubature::axes_across;
use super::fuzz::Random;
use super::shadows::{ORIGIN, receiver};
use super::{direction, normal, v};
use crate::math::{DVec3, Point};

const EXACT: Accuracy = Accuracy {
    relative: 1e-6,
    most_cells: 65_536,
};

/// A light above, a rectangle, a disk or a sphere.
fn light(random: &mut Random, kind: usize) -> Emitter {
    let center = v(random.within(-1.0, 1.0), random.within(-1.0, 1.0), 3.0);
    let size = random.scale(0.05, 1.2);
    let facing = -(center.normalize() + random.direction() * 0.6);
    let [a, b] = axes_across(facing.normalize());
    let emitter = match kind % 3 {
        0 => Emitter::rectangle(Point(center), [a * size, b * random.scale(0.05, 1.2)], true),
        1 => Emitter::disk(Point(center), normal(facing), size, true),
        _ => Emitter::sphere(Point(center), size),
    };
    emitter.unwrap()
}

/// Two triangles, a rectangle between the point and the light.
fn pane(random: &mut Random) -> [Occluder; 2] {
    let middle = v(
        random.within(-0.6, 0.6),
        random.within(-0.6, 0.6),
        random.within(0.5, 1.2),
    );
    let [a, b] = axes_across((DVec3::Z + random.direction() * 0.7).normalize());
    let [a, b] = [a * random.scale(0.1, 2.0), b * random.scale(0.1, 2.0)];
    let corners = [
        middle - a - b,
        middle + a - b,
        middle + a + b,
        middle - a + b,
    ];
    let [p, q, r, s] = corners;
    [[p, q, r], [p, r, s]].map(Occluder::Triangle)
}

/// Opaque shapes, mostly few.
fn shapes(random: &mut Random, number: usize) -> Vec<Occluder> {
    let center = |random: &mut Random| {
        v(
            random.within(-0.5, 0.5),
            random.within(-0.5, 0.5),
            random.within(0.8, 1.6),
        )
    };
    let triangle = |random: &mut Random| {
        let center = center(random);
        Occluder::Triangle([(); 3].map(|()| center + random.direction() * 0.4))
    };
    match number % 4 {
        0 => Vec::new(),
        1 => vec![triangle(random)],
        2 => vec![triangle(random), triangle(random)],
        _ => vec![Occluder::Ball {
            center: center(random),
            radius: random.scale(0.02, 0.3),
        }],
    }
}

fn past(emitter: &Emitter, receiver: &Receiver, occluders: &[&[Occluder]]) -> Received {
    let occluders = occluders.concat();
    let mut space = ShadowSpace::default();
    let bounded = emitter.received_past(ORIGIN, receiver, &occluders, 1e-12, &EXACT, &mut space);
    bounded.unwrap_or_default().value
}

fn through(
    emitter: &Emitter,
    receiver: &Receiver,
    opaque: &[Occluder],
    panes: &Panes<'_>,
) -> Received {
    let mut space = ShadowSpace::default();
    let bounded =
        emitter.received_through(ORIGIN, receiver, opaque, panes, 1e-12, &EXACT, &mut space);
    bounded.unwrap().unwrap_or_default().value
}

#[test]
fn panes_let_pass_what_lobes_receive() {
    let mut random = Random(1);
    let mut worst = 0.0_f64;
    for number in 0..600 {
        let emitter = light(&mut random, number);
        let [first, second] = [pane(&mut random), pane(&mut random)];
        let opaque = shapes(&mut random, number / 3);
        let axis = (DVec3::Z + random.direction() * 0.3).normalize();
        let up = receiver(DVec3::Z);
        let lobe = |shininess: f64| Receiver {
            gloss: Some(Gloss {
                axis: direction(axis),
                shininess,
                has_cosine: true,
            }),
            ..up
        };
        // T = (v·u)ᴺ of the first, which no polynomial is, v·u of the second.
        let power = random.within(1.0, 24.0);
        let transmittance = |pane: usize, way: DVec3| {
            let cosine = axis.dot(way) / way.length();
            if pane < 2 { cosine.powf(power) } else { cosine }
        };
        let both = [first, second].concat();
        let panes = Panes {
            shapes: &both,
            whole: 0,
            normal: &|_| axis,
            transmittance: &transmittance,
        };
        let actual = through(&emitter, &up, &opaque, &panes).irradiance;
        let of =
            |power: f64, occluders: &[&[Occluder]]| past(&emitter, &lobe(power), occluders).lobe;
        let neither = past(&emitter, &up, &[&opaque, &first, &second]).irradiance;
        let only_first = of(power, &[&opaque, &second]) - of(power, &[&opaque, &first, &second]);
        let only_second = of(1.0, &[&opaque, &first]) - of(1.0, &[&opaque, &first, &second]);
        let of_both = of(power + 1.0, &[&opaque])
            - of(power + 1.0, &[&opaque, &first])
            - of(power + 1.0, &[&opaque, &second])
            + of(power + 1.0, &[&opaque, &first, &second]);
        let expected = neither + only_first + only_second + of_both;
        let free = past(&emitter, &up, &[]).irradiance;
        let error = (actual - expected).abs() / free;
        worst = worst.max(error);
    }
    assert!(worst < 6e-6, "{worst:e}");
}

/// The Phong lobe w times n·u is the one with a cosine.
#[test]
fn panes_let_pass_a_part_of_a_lobe() {
    let mut random = Random(2);
    let mut worst = 0.0_f64;
    for number in 0..600 {
        let emitter = light(&mut random, number);
        let pane = pane(&mut random);
        let opaque = shapes(&mut random, number / 3);
        let axis = (DVec3::Z + random.direction() * 0.5).normalize();
        let with = |has_cosine: bool| Receiver {
            gloss: Some(Gloss {
                axis: direction(axis),
                shininess: [2.0, 20.0, 500.0, 1e5][number % 4],
                has_cosine,
            }),
            ..receiver(DVec3::Z)
        };
        let transmittance = |_: usize, way: DVec3| way.z / way.length();
        let panes = Panes {
            shapes: &pane,
            whole: 0,
            normal: &|_| DVec3::Z,
            transmittance: &transmittance,
        };
        let actual = through(&emitter, &with(false), &opaque, &panes).lobe;
        let expected = past(&emitter, &with(false), &[&opaque, &pane]).lobe
            + past(&emitter, &with(true), &[&opaque]).lobe
            - past(&emitter, &with(true), &[&opaque, &pane]).lobe;
        let free = past(&emitter, &with(false), &[]).lobe;
        if free > 1e-9 {
            let error = (actual - expected).abs() / free;
            worst = worst.max(error);
        }
    }
    assert!(worst < 5e-8, "{worst:e}");
}

/// Panes of two normals: n·u of one and v·u of the other make a lobe of the irradiance.
#[test]
fn panes_of_two_normals_let_pass_what_a_lobe_receives() {
    let mut random = Random(3);
    let mut worst = 0.0_f64;
    for number in 0..300 {
        let emitter = light(&mut random, number);
        let opaque = shapes(&mut random, number / 3);
        let axis = (DVec3::Z + random.direction() * 0.4).normalize();
        let sheet = |normal: DVec3| Occluder::Plane {
            point: v(0.0, 0.0, 0.3),
            normal,
        };
        let axes = [DVec3::Z, axis];
        let panes = Panes {
            shapes: &axes.map(sheet),
            whole: 0,
            normal: &|pane| axes[pane],
            transmittance: &|pane, way| axes[pane].dot(way) / way.length(),
        };
        let up = receiver(DVec3::Z);
        let actual = through(&emitter, &up, &opaque, &panes).irradiance;
        let with_cosine = Receiver {
            normal: normal(axis),
            gloss: Some(Gloss {
                axis: direction(DVec3::Z),
                shininess: 2.0,
                has_cosine: true,
            }),
            ..up
        };
        let expected = past(&emitter, &with_cosine, &[&opaque]).lobe;
        let free = past(&emitter, &up, &[]).irradiance;
        worst = worst.max((actual - expected).abs() / free);
    }
    assert!(worst < 2.4e-5, "{worst:e}");
}
