//! Mirrors, metals, glass, panes and coats: closed forms.

use super::*;
use crate::oracle::{Event, WayTerms};
use crate::scene::{Aim, AreaShape, Glass, GlassIndex, Metal, Mirror};
use crate::spectrum::Curve;

/// Published numbers have twelve digits.
pub(super) const DIGITS: f64 = 2e-12;

impl Builder {
    /// The last object is of another material.
    pub(super) fn of(mut self, name: &str, material: Material) -> Self {
        if let Some(last) = self.0.objects.last_mut() {
            let (Object::Sphere { material, .. }
            | Object::Plane { material, .. }
            | Object::Triangle { material, .. }
            | Object::Mesh { material, .. }) = &mut last.value;
            *material = name.to_owned().into();
        }
        self.material(name, material)
    }

    fn depth(mut self, depth: u32) -> Self {
        self.0.image.max_depth = f64::from(depth).into();
        self
    }

    pub(super) fn background(mut self, radiance: f64) -> Self {
        self.0.image.background = Value::Uniform(radiance).into();
        self
    }

    fn transport(mut self, transport: Transport) -> Self {
        self.0.image.transport = transport.into();
        self
    }

    fn ways(&self) -> Vec<WayTerms> {
        self.oracle().explain(0.5, 0.5).ways
    }
}

fn mirror(reflectance: f64) -> Material {
    Material::mirror(reflectance)
}

fn glass(n: f64, absorption: Value) -> Material {
    Material::Glass(Glass {
        index: GlassIndex::Value(Value::Uniform(n).into()),
        absorption: absorption.into(),
        dispersion: false,
    })
}

pub(super) fn clear(n: f64) -> Material {
    glass(n, Value::ZERO)
}

fn metal(n: f64, k: f64) -> Material {
    Material::Metal(Metal::Indices {
        n: Value::Uniform(n).into(),
        k: Value::Uniform(k).into(),
    })
}

fn coated(diffuse: f64, reflectance: f64, schlick: bool) -> Material {
    let mut lobes = lobes(diffuse, 0.0, None);
    lobes.coat = Some(Mirror {
        reflectance: Value::Uniform(reflectance).into(),
        schlick,
    });
    Material::Phong(lobes)
}

/// A ray along −z that meets the sphere of radius 1 around the origin at this angle, from outside.
fn at_angle(degrees: f64) -> Builder {
    let x = degrees.to_radians().sin();
    Builder::new([1, 1], orthographic([x, 0.0, 5.0], [x, 0.0, 0.0], 1.0)).sphere([0.0; 3], 1.0)
}

/// A box of glass or panes; in the other order its faces are turned inwards.
pub(super) fn cuboid(from: [f64; 3], to: [f64; 3], is_turned: bool) -> Arc<MeshFile> {
    let mut mesh = MeshFile::default();
    for corner in 0..8 {
        let coordinate = |axis: usize| [from, to][(corner >> axis) & 1][axis];
        mesh.positions.push([0, 1, 2].map(coordinate));
    }
    for [a, b, c, d] in [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ] {
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    if is_turned {
        for triangle in &mut mesh.triangles {
            triangle.swap(0, 1);
        }
    }
    Arc::new(mesh)
}

/// F by Fresnel's equations in the form with angles.
pub(super) fn fresnel(degrees: f64, n: f64) -> f64 {
    let incident = degrees.to_radians();
    let refracted = (incident.sin() / n).asin();
    let across = ((incident - refracted).sin() / (incident + refracted).sin()).powi(2);
    let parallel = ((incident - refracted).tan() / (incident + refracted).tan()).powi(2);
    (across + parallel) / 2.0
}

/// R of a conductor in its real form.
fn conductor(degrees: f64, n: f64, k: f64) -> f64 {
    let (s, c) = degrees.to_radians().sin_cos();
    let t = n * n - k * k - s * s;
    let big = (t * t + 4.0 * n * n * k * k).sqrt();
    let a = ((big + t) / 2.0).sqrt();
    let across = (big - 2.0 * a * c + c * c) / (big + 2.0 * a * c + c * c);
    let (even, odd) = (c * c * big + s.powi(4), 2.0 * a * c * s * s);
    (across + across * (even - odd) / (even + odd)) / 2.0
}

#[test]
fn a_mirror_shows_what_the_mirrored_eye_sees() {
    let at = |eye: [f64; 3]| {
        Builder::looking(eye, [0.2, 0.1, 0.0])
            .light([2.0, 3.0, 1.0], 10.0)
            .sphere([-1.0, 0.0, 3.0], 1.2)
            .plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0])
    };
    let unmirrored = at([1.5, 0.4, -3.5]).radiance();
    assert!(unmirrored > 0.1);
    let mirrored = at([1.5, 0.4, 3.5])
        .plane([0.0; 3], [0.0, 0.0, 1.0])
        .of("silver", mirror(0.75));
    assert_near(mirrored.radiance(), 0.75 * unmirrored, ROUNDING);
    assert_eq!(mirrored.depth(0).radiance(), 0.0);
}

/// 45° between two mirrors 1 m apart, ten times reflected, to a lamp.
#[test]
fn each_reflection_is_a_factor() {
    let between = |depth: u32| {
        let mut builder = Builder::looking([0.0, 0.0, 0.5], [0.5, 0.0, 0.0]).depth(depth);
        builder.0.lights.push(entry(
            "lamp",
            Light::Area {
                shape: AreaShape::Rectangle {
                    center: [10.0, 0.0, 0.5].into(),
                    aim: Aim::Direction([-1.0, 0.0, 0.0].into()),
                    up: None,
                    size: [3.0, 3.0].into(),
                    two_sided: false,
                },
                luminance: Value::Uniform(3.0).into(),
                samples: 16.0.into(),
                visible: true,
                group: None,
            },
        ));
        builder
            .plane([0.0; 3], [0.0, 0.0, 1.0])
            .of("silver", mirror(0.9))
            .plane([0.0, 0.0, 1.0], [0.0, 0.0, 1.0])
            .of("silver", mirror(0.9))
    };
    assert_near(between(10).radiance(), 3.0 * 0.9_f64.powi(10), ROUNDING);
    assert_eq!(between(9).radiance(), 0.0);
    let ways = between(10).ways();
    assert_eq!(ways.len(), 1);
    assert_eq!(ways[0].vertices.len(), 11);
    assert_eq!(ways[0].vertices[10].event, Event::Emitted);
    assert_near(ways[0].vertices[4].product[1], 0.9_f64.powi(5), ROUNDING);
}

/// To and fro between two coated walls: Σ Rʲ (1 − R) L of each in turn.
#[test]
fn coats_that_face_each_other_make_a_series() {
    let (reflectance, depth) = (0.3, 12);
    let builder = Builder::looking([0.0, 0.0, 0.5], [0.0; 3])
        .depth(depth)
        .light([1.0, 0.0, 0.25], 2.0)
        .plane([0.0; 3], [0.0, 0.0, 1.0])
        .of("lacquer", coated(0.6, reflectance, false))
        .plane([0.0, 0.0, 1.0], [0.0, 0.0, 1.0])
        .of("lacquer", coated(0.6, reflectance, false));
    let lit = |height: f64| 0.6 * 2.0 * height / (1.0 + height * height).powf(1.5);
    let walls = [lit(0.25), lit(0.75)];
    let series = (0..=depth as usize).map(|j| reflectance.powi(j as i32) * walls[j % 2]);
    let expected = (1.0 - reflectance) * series.sum::<f64>();
    assert_near(builder.radiance(), expected, ROUNDING);
    // The explanation adds up as well.
    let explanation = builder.oracle().explain(0.5, 0.5);
    let sum: f64 = explanation.ways.iter().map(|way| way.radiance[0]).sum();
    assert_near(sum, expected, ROUNDING);
    assert_near(explanation.lights[0].radiance[0], walls[0], ROUNDING);
}

#[test]
fn schlick_s_coat_and_mirror() {
    for degrees in [0.0, 40.0, 75.0] {
        let c = f64::to_radians(degrees).cos();
        let expected = 0.2 + 0.8 * (1.0 - c).powi(5);
        let material = Material::Mirror(Mirror {
            reflectance: Value::Uniform(0.2).into(),
            schlick: true,
        });
        let mirrored = at_angle(degrees).of("mirror", material).background(1.0);
        assert_near(mirrored.radiance(), expected, ROUNDING);
        let coat = at_angle(degrees)
            .of("coat", coated(0.5, 0.2, true))
            .background(1.0);
        assert_near(coat.radiance(), expected, ROUNDING);
    }
}

/// Published vectors, of the first reflection alone.
#[test]
fn glass_reflects_as_fresnel_says() {
    for (n, degrees, expected) in [
        (1.5, 0.0, 0.04),
        (1.5, 30.0, 0.041_522_625_975_8),
        (1.5, 45.0, 0.050_239_911_012_2),
        (1.5, 60.0, 0.089_186_712_802_2),
        (1.5, 75.0, 0.253_060_562_990),
        (1.5, 85.0, 0.612_799_645_265),
        (1.5, 89.0, 0.904_184_949_780),
        (1.5, 56.309_932_474_0, 0.073_964_497_041_4),
        (1.33, 0.0, 0.020_059_312_199_5),
        (1.33, 30.0, 0.021_112_457_865_3),
        (1.33, 60.0, 0.059_125_599_247_4),
        (1.33, 89.0, 0.896_046_505_214),
    ] {
        let sphere = at_angle(degrees).of("glass", clear(n)).background(1.0);
        assert_near(sphere.depth(1).radiance(), expected, DIGITS);
    }
}

#[test]
fn from_inside_there_is_a_critical_angle() {
    let from_inside = |degrees: f64| {
        let x = f64::to_radians(degrees).sin();
        let builder = Builder::new([1, 1], orthographic([x, 0.0, 0.0], [x, 0.0, -1.0], 1.0));
        let sphere = builder.sphere([0.0; 3], 1.0).of("glass", clear(1.5));
        sphere.background(1.0).depth(1)
    };
    for (degrees, reflected) in [
        (20.0, 0.041_728_518_190_6),
        (40.0, 0.245_291_204_287),
        (41.8, 0.890_771_921_5),
    ] {
        let expected = 2.25 * (1.0 - reflected);
        assert_near(from_inside(degrees).radiance(), expected, 1e-10);
    }
    let beyond = from_inside(41.82);
    assert_eq!(beyond.radiance(), 0.0);
    let ways = beyond.depth(3).ways();
    assert_eq!(ways[0].vertices[0].event, Event::TotallyReflected);
    assert_eq!(ways[0].vertices[0].factor, [1.0; 3]);
}

#[test]
fn metals_reflect_as_fresnel_says() {
    for (n, k, degrees, expected) in [
        (0.2, 3.0, 0.0, 0.923_371_647_510),
        (0.2, 3.0, 60.0, 0.918_411_084_659),
        (0.2, 3.0, 85.0, 0.963_598_561_778),
        (2.9, 3.1, 0.0, 0.532_634_971_797),
        (2.9, 3.1, 60.0, 0.515_658_688_218),
        (2.9, 3.1, 85.0, 0.660_118_722_346),
    ] {
        let sphere = at_angle(degrees).of("metal", metal(n, k)).background(1.0);
        assert_near(sphere.radiance(), expected, DIGITS);
    }
}

/// n and k are straight between the published points; RGB is that of the spectrum under D65.
#[test]
fn metals_by_name() {
    let gold = |transport| {
        let material = Material::Metal(Metal::Preset("gold".to_owned().into()));
        at_angle(60.0)
            .of("gold", material)
            .background(1.0)
            .transport(transport)
    };
    let spectral = gold(Transport::Spectral).oracle();
    let white = at_angle(60.0)
        .background(1.0)
        .transport(Transport::Spectral);
    let white = white.oracle().spectral_radiance(-5.0, 0.5).unwrap();
    let seen = spectral.spectral_radiance(0.5, 0.5).unwrap();
    let part = (500.0 - 495.9) / (520.9 - 495.9);
    let n = 1.04 + part * (0.62 - 1.04);
    let k = 1.833 + part * (2.081 - 1.833);
    let place = 500 - 360;
    assert_near(seen[place] / white[place], conductor(60.0, n, k), ROUNDING);
    let expected = spectral.radiance(0.5, 0.5).radiance;
    let rgb = gold(Transport::Rgb).oracle().radiance(0.5, 0.5).radiance;
    for (rgb, expected) in rgb.into_iter().zip(expected) {
        assert_near(rgb, expected, ROUNDING);
    }
    assert!(rgb[0] > 1.2 * rgb[2]);
}

/// In a furnace everything that takes nothing of light is not seen.
#[test]
fn clear_glass_in_a_furnace_is_not_seen() {
    for degrees in [0.0, 30.0, 70.0] {
        let sphere = at_angle(degrees).of("glass", clear(1.5)).background(1.0);
        assert_near(sphere.depth(40).radiance(), 1.0, 1e-14);
    }
    // From inside of it is n² as bright.
    let inside = Builder::looking([0.1, 0.2, 0.0], [0.3, 0.0, -0.5])
        .sphere([0.0; 3], 1.0)
        .of("glass", clear(1.5))
        .background(1.0);
    assert_near(inside.depth(40).radiance(), 2.25, 1e-14);
    // What is cut off is all that is missing of bodies in and beside each other.
    let many = |depth: u32| {
        at_angle(20.0)
            .of("glass", clear(1.5))
            .sphere([0.2, 0.1, 0.0], 0.5)
            .of("water", clear(1.33))
            .mesh(&cuboid([-0.4, -0.3, -3.1], [0.7, 0.5, -0.8], true), AS_IS)
            .of("flint", clear(1.8))
            .background(1.0)
            .depth(depth)
            .radiance()
    };
    let (short, long) = (many(6), many(14));
    assert!(short < long && long <= 1.0 + 1e-14, "{short}, {long}");
    assert!(1.0 - long < 5e-4 && 1.0 - short < 0.1, "{short}, {long}");
}

/// A slab with all that goes to and fro in it.
#[test]
fn glass_takes_light_on_the_way() {
    let slab = |n: f64, sigma: Value, is_turned: bool| {
        let mesh = cuboid([-3.0, -4.0, -2.0], [5.0, 6.0, 0.0], is_turned);
        Builder::looking([0.1, 0.2, 3.0], [0.1, 0.2, 0.0])
            .mesh(&mesh, AS_IS)
            .of("glass", glass(n, sigma))
            .background(1.0)
            .depth(30)
    };
    for is_turned in [false, true] {
        let sigma = Value::Uniform(0.7);
        let unbent = slab(1.0, sigma.clone(), is_turned);
        assert_near(unbent.radiance(), (-1.4_f64).exp(), ROUNDING);
        let (face, left) = (0.04, (-1.4_f64).exp());
        let to_and_fro = 1.0 - (face * left).powi(2);
        let through = (1.0 - face).powi(2) * left / to_and_fro;
        let back = face + (1.0 - face).powi(2) * face * left * left / to_and_fro;
        let expected = through + back;
        assert_near(slab(1.5, sigma, is_turned).radiance(), expected, ROUNDING);
    }
    // Channel by channel, and from within.
    let color = Value::Rgb {
        rgb: [0.1, 0.5, 2.0],
        space: crate::scene::ColorSpace::Rec709,
    };
    let seen = slab(1.0, color.clone(), false).oracle().radiance(0.5, 0.5);
    for (seen, sigma) in seen.radiance.into_iter().zip([0.1, 0.5, 2.0_f64]) {
        assert_near(seen, (-2.0 * sigma).exp(), ROUNDING);
    }
    let inside = Builder::looking([0.0; 3], [0.0, 0.0, -0.5])
        .sphere([0.0; 3], 1.0)
        .of("glass", glass(1.0, color))
        .background(1.0);
    let seen = inside.oracle().radiance(0.5, 0.5);
    for (seen, sigma) in seen.radiance.into_iter().zip([0.1, 0.5, 2.0_f64]) {
        assert_near(seen, (-sigma).exp(), ROUNDING);
    }
}

/// Through a prism of 60° at the least deviation: sin((A + D)/2) = n sin(A/2).
#[test]
fn a_prism_deviates_light() {
    let tall = 3.0_f64.sqrt();
    for is_turned in [false, true] {
        let mut mesh = MeshFile::default();
        for z in [-1.0, 1.0] {
            mesh.positions
                .extend([[-1.0, 0.0, z], [1.0, 0.0, z], [0.0, tall, z]]);
        }
        mesh.triangles = vec![
            [0, 2, 1],
            [3, 4, 5],
            [0, 1, 4],
            [0, 4, 3],
            [1, 2, 5],
            [1, 5, 4],
            [2, 0, 3],
            [2, 3, 5],
        ];
        if is_turned {
            for triangle in &mut mesh.triangles {
                triangle.swap(1, 2);
            }
        }
        // The middle of the left face, whose normal is (−√3, 1)/2.
        let met = [-0.5, tall / 2.0, 0.1];
        let incident = f64::asin(0.75).to_degrees();
        let (sin, cos) = (150.0 + incident).to_radians().sin_cos();
        let eye = [met[0] + 2.0 * cos, met[1] + 2.0 * sin, 0.1];
        let builder = Builder::looking(eye, met)
            .mesh(&Arc::new(mesh), AS_IS)
            .of("glass", clear(1.5))
            .plane([9.0, 0.0, 0.0], [-1.0, 0.0, 0.0])
            .light([5.0, 0.0, 0.1], 1.0);
        let ways = builder.ways();
        let events: Vec<Event> = ways[0].vertices.iter().map(|vertex| vertex.event).collect();
        assert_eq!(events, [Event::Refracted, Event::Refracted, Event::Lit]);
        let [a, b, c] = [0, 1, 2].map(|i: usize| ways[0].vertices[i].position.unwrap());
        assert_near(a[1], b[1], ROUNDING);
        let (incoming, outgoing) = (
            (met[1] - eye[1]).atan2(met[0] - eye[0]),
            (c[1] - b[1]).atan2(c[0] - b[0]),
        );
        let deviation = (incoming - outgoing).to_degrees();
        assert_near(deviation, 2.0 * incident - 60.0, ROUNDING);
        let passed = 1.0 - fresnel(incident, 1.5);
        assert_near(ways[0].vertices[2].product[0], passed * passed, ROUNDING);
        assert!(ways[0].radiance[0] > 0.0);
    }
}

/// N-BK7 of three wavelengths: angles, and F of each where they are dispersed.
#[test]
fn glass_by_name() {
    for (n, refracted) in [
        (1.530_848_538_25, 34.452_021_513_9),
        (1.518_522_387_62, 34.771_703_472_5),
        (1.513_063_997_20, 34.915_334_030_5),
    ] {
        let sphere = at_angle(60.0).of("glass", clear(n)).background(1.0);
        let ways = sphere.ways();
        let way = ways.iter().find(|way| way.vertices.len() == 3).unwrap();
        assert_near(way.vertices[0].angle.unwrap(), 60.0, DIGITS);
        // n has as many digits.
        assert_near(way.vertices[1].angle.unwrap(), refracted, 1e-11);
    }
    let by_name = |dispersion: bool| {
        let material = Material::Glass(Glass {
            index: GlassIndex::Sellmeier("N-BK7".to_owned().into()),
            absorption: Value::ZERO.into(),
            dispersion,
        });
        let sphere = at_angle(60.0).of("glass", material).background(1.0);
        sphere.transport(Transport::Spectral).depth(1).oracle()
    };
    let white = by_name(true).spectral_radiance(-5.0, 0.5).unwrap();
    let reflected = |dispersion: bool, nm: usize| {
        let seen = by_name(dispersion).spectral_radiance(0.5, 0.5).unwrap();
        seen[nm - 360] / white[nm - 360]
    };
    for (nm, n) in [
        (400, 1.530_848_538_25),
        (550, 1.518_522_387_62),
        (700, 1.513_063_997_20),
    ] {
        assert_near(reflected(true, nm), fresnel(60.0, n), 1e-11);
        // n_d of Schott's catalog.
        assert_near(reflected(false, nm), fresnel(60.0, 1.516_80), 2e-5);
        assert_eq!(
            (1e12 * reflected(false, nm)).round(),
            (1e12 * reflected(false, 500)).round()
        );
    }
    // One way for all wavelengths that go over the same surfaces.
    let explanation = by_name(true).explain(0.5, 0.5);
    assert_eq!(explanation.ways[0].wavelengths, Some(471));
    assert_eq!(explanation.ways.len() + explanation.more_ways, 2);
}

/// A curve is taken where the d line is.
#[test]
fn glass_of_a_curve() {
    let curve = Curve::new(vec![580.0, 600.0], vec![1.5, 1.7]).unwrap();
    let material = Material::Glass(Glass {
        index: GlassIndex::Value(Value::Curve(Arc::new(curve)).into()),
        absorption: Value::ZERO.into(),
        dispersion: false,
    });
    let sphere = at_angle(60.0).of("glass", material).background(1.0);
    let expected = fresnel(60.0, 1.575_618);
    assert_near(sphere.depth(1).radiance(), expected, ROUNDING);
}

/// Of two equally large bodies the first counts, and a smaller one within counts more.
#[test]
fn bodies_that_overlap() {
    let ahead = |builder: Builder| {
        let ways = builder.background(1.0).ways();
        let vertices = &ways[0].vertices;
        let events: Vec<Event> = vertices.iter().map(|vertex| vertex.event).collect();
        (events, vertices[vertices.len() - 1].product[0])
    };
    let through = |before: f64, after: f64| 1.0 - ((after - before) / (after + before)).powi(2);
    let overlapping = at_angle(0.0)
        .of("first", clear(1.5))
        .sphere([0.0, 0.0, -1.5], 1.0)
        .of("second", clear(1.7));
    let (events, product) = ahead(overlapping);
    let expected = [
        Event::Refracted,
        Event::Unchanged,
        Event::Refracted,
        Event::Refracted,
        Event::Background,
    ];
    assert_eq!(events, expected);
    let weight = through(1.0, 1.5) * through(1.5, 1.7) * through(1.7, 1.0);
    assert_near(product, weight, ROUNDING);
    let bubble = at_angle(0.0)
        .of("glass", clear(1.5))
        .sphere([0.0; 3], 0.5)
        .of("air", clear(1.0));
    let (events, product) = ahead(bubble);
    assert_eq!(events.len(), 5);
    assert_near(product, through(1.0, 1.5).powi(4), ROUNDING);
    // From the middle of both.
    let inside = Builder::looking([0.0; 3], [0.0, 0.0, -0.5])
        .sphere([0.0; 3], 1.0)
        .of("glass", clear(1.5))
        .sphere([0.0; 3], 0.5)
        .of("air", clear(1.0));
    let (events, product) = ahead(inside);
    assert_eq!(events.len(), 3);
    assert_near(product, through(1.0, 1.5).powi(2), ROUNDING);
}
