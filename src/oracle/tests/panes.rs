//! Panes: what they reflect, and what of a light comes through.

use super::delta::{DIGITS, clear, cuboid, fresnel};
use super::*;
use crate::scene::{Aim, AreaShape, Pane};

fn pane(n: f64) -> Material {
    Material::Pane(Pane { n: n.into() })
}

#[test]
fn panes_reflect_from_both_faces() {
    for (degrees, transmitted, reflected) in [
        (60.0, 0.836_232_462_710, 0.163_767_537_290),
        (0.0, 0.96 / 1.04, 0.08 / 1.04),
    ] {
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        let window = || {
            Builder::looking([2.0 * sin, 0.0, 2.0 * cos], [0.0; 3])
                .plane([0.0; 3], [0.0, 0.0, 1.0])
                .of("pane", pane(1.5))
                .background(1.0)
        };
        assert_near(window().radiance(), 1.0, ROUNDING);
        let before_black = window().plane([0.0, 0.0, -1.0], [0.0, 0.0, 1.0]);
        assert_near(before_black.radiance(), reflected, DIGITS);
        let above_black = window().plane([0.0, 0.0, 9.0], [0.0, 0.0, 1.0]);
        assert_near(above_black.radiance(), transmitted, DIGITS);
    }
}

/// Adds a pane to a scene.
type Adds = fn(Builder) -> Builder;

#[test]
fn lamps_shine_through_panes() {
    let lit = |pane_at: Option<Adds>| {
        let floor = Builder::looking([0.0, -0.4, 0.3], [0.0; 3])
            .light([3.0_f64.sqrt(), 0.0, 1.0], 5.0)
            .plane([0.0; 3], [0.0, 0.0, 1.0]);
        pane_at.map_or(floor.clone(), |add| add(floor).of("pane", pane(1.5)))
    };
    let unhidden = lit(None).radiance();
    let aslant = 0.836_232_462_710;
    let across = 0.96 / 1.04;
    let at_the_side = (1.0 - fresnel(30.0, 1.5)) / (1.0 + fresnel(30.0, 1.5));
    let cases: [(Adds, f64, usize); 5] = [
        (|b| b.plane([0.0, 0.0, 0.5], [0.0, 0.0, 1.0]), aslant, 1),
        // From within, and through all of it.
        (|b| b.sphere([3.0_f64.sqrt(), 0.0, 1.0], 0.5), across, 1),
        (
            |b| b.sphere([0.75_f64.sqrt(), 0.0, 0.5], 0.25),
            across * across,
            1,
        ),
        // Through the edge that two triangles share.
        (
            |b| {
                let mut mesh = MeshFile::default();
                let x = 0.75_f64.sqrt();
                mesh.positions = vec![
                    [x - 0.1, -0.1, 0.5],
                    [x + 0.1, -0.1, 0.5],
                    [x + 0.1, 0.1, 0.5],
                    [x - 0.1, 0.1, 0.5],
                ];
                mesh.triangles = vec![[0, 1, 2], [0, 2, 3]];
                b.mesh(&Arc::new(mesh), AS_IS)
            },
            aslant,
            1,
        ),
        (
            |b| b.mesh(&cuboid([0.2, -0.3, 0.2], [1.5, 0.4, 0.9], false), AS_IS),
            // In through the lower face, out through the one at the side, at 30° to its normal.
            aslant * at_the_side,
            2,
        ),
    ];
    for (add, transmitted, count) in cases {
        let scene = lit(Some(add));
        let light = scene.first_light();
        assert_eq!(light.outcome, crate::oracle::Outcome::Through);
        let panes = light.panes.unwrap();
        assert_eq!(panes.names.len(), count);
        assert_near(panes.transmittance, transmitted, DIGITS);
        assert_near(scene.radiance(), unhidden * transmitted, DIGITS);
    }
    let wall = lit(Some(|b| b.plane([0.0, 0.0, 0.5], [0.0, 0.0, 1.0])));
    // Glass is opaque to it.
    let opaque = wall.of("glass", clear(1.5));
    assert_eq!(opaque.radiance(), 0.0);
}

/// A lamp with an area behind a window: T within the integral, and 1 beside the window.
#[test]
fn lamps_with_an_area_shine_through_panes() {
    let lit = |pane_of: Option<[f64; 2]>| {
        let mut builder = Builder::looking([0.0, -0.4, 0.1], [0.0; 3]);
        builder.0.lights.push(entry(
            "lamp",
            Light::Area {
                shape: AreaShape::Disk {
                    center: [0.0, 0.0, 2.0].into(),
                    aim: Aim::Direction([0.0, 0.0, -1.0].into()),
                    radius: 2.0.into(),
                    two_sided: false,
                },
                luminance: Value::Uniform(3.0).into(),
                samples: 16.0.into(),
                visible: true,
                group: None,
            },
        ));
        let floor = builder.plane([0.0; 3], [0.0, 0.0, 1.0]);
        let Some([from, to]) = pane_of else {
            return floor;
        };
        let mesh = MeshFile {
            positions: vec![
                [from, -9.0, 0.5],
                [to, -9.0, 0.5],
                [to, 9.0, 0.5],
                [from, 9.0, 0.5],
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..MeshFile::default()
        };
        floor.mesh(&Arc::new(mesh), AS_IS).of("pane", pane(1.5))
    };
    // L π ∫ T(θ) sin 2θ dθ up to 45°, by Simpson's rule.
    let steps = 2000;
    let step = std::f64::consts::FRAC_PI_4 / f64::from(steps);
    let integrand = |i: i32| {
        let angle = (f64::from(i) * step).max(1e-9);
        let face = fresnel(angle.to_degrees(), 1.5);
        (1.0 - face) / (1.0 + face) * (2.0 * angle).sin()
    };
    let weights = |i: i32| match i {
        _ if i == 0 || i == steps => 1.0,
        _ if i % 2 == 1 => 4.0,
        _ => 2.0,
    };
    let integral: f64 = (0..=steps).map(|i| weights(i) * integrand(i)).sum();
    let seen = 3.0 * std::f64::consts::PI * integral * step / 3.0;
    let unhidden = lit(None).radiance();
    assert_near(unhidden, 3.0 * std::f64::consts::PI / 2.0, 1e-8);
    let whole = lit(Some([-9.0, 9.0]));
    assert_near(whole.radiance(), seen, 1e-8);
    let light = whole.first_light();
    assert_eq!(light.outcome, crate::oracle::Outcome::Through);
    assert_near(light.panes.unwrap().transmittance, seen / unhidden, 1e-8);
    let on_one_side = lit(Some([0.0, 9.0]));
    assert_near(on_one_side.radiance(), (seen + unhidden) / 2.0, 1e-8);
    let sample = on_one_side.oracle().radiance(0.5, 0.5);
    assert!(sample.error[0] < 1e-6 * unhidden);
    // A sphere around p: its normals are along the ways from its middle.
    let around = lit(None).sphere([0.0; 3], 1.0).of("pane", pane(1.5));
    let around = Builder(Scene {
        camera: perspective([0.0, -0.4, 0.1], [0.0; 3], 30.0).into(),
        ..around.0
    });
    assert_near(around.radiance(), unhidden * 0.96 / 1.04, 1e-8);
}
