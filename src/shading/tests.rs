//! The sum over lights at hand-made points, with hand-made weights.

use fearless_simd::Simd;

use super::groups::Share;
use super::*;
use crate::math::DVec3;
use crate::scene::Scene;
use crate::simd::{Kernel, SimdLevel, ones};
use crate::visibility::BATCH;

/// Some materials, under a point light, a spot and a light that is a curve.
fn world(transport: &str) -> World {
    let text = format!(
        "[image]
        resolution = [4, 4]
        transport = '{transport}'
        [camera.orthographic]
        eye = [0, 0, 5]
        look_at = [0, 0, 0]
        height = 4
        [materials.clay.phong]
        diffuse = [0.7, 0.3, 0.2]
        [materials.jade.normalized_phong]
        diffuse = [0.2, 0.5, 0.3]
        specular = 0.4
        shininess = 12.5
        [materials.steel.phong]
        diffuse = 0.05
        specular = [0.3, 0.35, 0.4]
        shininess = 40
        [lights.key.point]
        position = [1, 2, 3]
        intensity = [30, 20, 10]
        [lights.lamp.spot]
        position = [0, 1, 2]
        look_at = [0, 0, 0]
        intensity = {{ lumens = 500, color = [0.9, 0.7, 0.5] }}
        inner = 5
        outer = 60
        [lights.blue.point]
        position = [-3, 0.5, 2]
        intensity = [2, 5, 30]
        [objects.a.sphere]
        material = 'clay'
        center = [0, 0, 0]
        radius = 1
        [objects.b.sphere]
        material = 'jade'
        center = [0, 0, 0]
        radius = 1
        [objects.c.sphere]
        material = 'steel'
        center = [0, 0, 0]
        radius = 1
        "
    );
    World::new(&Scene::parse(&text, "hand-made.toml").unwrap())
        .unwrap()
        .0
}

/// A packet of points about the origin, all of which face all lights, of the materials one after the other.
fn points() -> Points {
    let mut points = Points::default();
    points.hit[0] = 0xffff;
    points.is_uniform[0] = false;
    for lane in 0..LANES {
        let t = lane as f64;
        let position = DVec3::new((t * 0.7).sin() * 0.5, (t * 1.3).cos() * 0.5, 0.1 * t.cos());
        let normal = DVec3::new(0.2 * (t * 2.1).sin(), 0.2 * (t * 0.9).cos(), 1.0).normalize();
        let to_viewer = DVec3::new(0.3 * t.cos(), 0.1, 1.0).normalize();
        for axis in 0..3 {
            points.position[axis][lane] = position[axis];
            points.to_viewer[axis][lane] = to_viewer[axis];
            points.geometric_normals_mut()[axis][lane] = normal[axis];
        }
        points.cos_viewer[lane] = normal.dot(to_viewer);
        points.material[lane] = lane as u32 % 3;
    }
    points
}

/// L9 of a packet whose points have these shares, with a part of the light of each light let through.
struct Sum<'w> {
    world: &'w World,
    shares: Option<Vec<Share>>,
    transmitted: Option<f64>,
}

/// Of one packet: L9, the terms of each light, and the sum of what [`light_terms`] adds, light by light.
#[derive(Clone, Debug)]
struct Summed {
    all: [[f64; LANES]; 3],
    terms: Vec<LightTerms>,
    added: [[f64; LANES]; 3],
    shares: Vec<Share>,
}

/// The first packet of three columns.
fn packet(columns: &[Column; 3]) -> [[f64; LANES]; 3] {
    columns
        .each_ref()
        .map(|column| *column.first_chunk().unwrap())
}

impl Kernel for Sum<'_> {
    type Output = Summed;

    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let points = points();
        let mut shaded = Shaded::default();
        for (light, entry) in self.world.lights().iter().enumerate() {
            let mut lit = [0; PACKETS];
            // Not all lights reach all points.
            lit[0] = 0xffff ^ (1 << light);
            shaded.lit.push(Lit {
                light,
                origin: entry.value.position(),
                points: lit,
                factors: self.transmitted.map(|part| Box::new(Column([part; BATCH]))),
                passed: None,
                area: None,
            });
        }
        let hit = points.hit[0];
        shaded
            .groups
            .take(self.world, &points.material[..LANES], None, hit, false);
        if let Some(shares) = self.shares {
            shaded.groups.replace(shares);
        }
        let all = shaded.sum_lights(simd, self.world, &points, 0);
        let shares = shaded.groups.shares().to_vec();
        shaded.begin(simd, self.world, &points);
        shaded.packets[0].replace(shares.clone());
        let detail = Detail {
            has_radiance: true,
            has_lobes: true,
            has_geometry: true,
        };
        let terms = (0..shaded.lit()).map(|lit| {
            let mut terms = LightTerms::default();
            shaded.add_light(simd, self.world, &points, lit, detail, &mut terms);
            terms
        });
        let terms = terms.collect();
        Summed {
            all: all.map(F64x16::to_array),
            terms,
            added: packet(&shaded.radiance),
            shares,
        }
    }
}

fn sum(world: &World, shares: Option<Vec<Share>>) -> [[f64; LANES]; 3] {
    terms(world, shares, None).all
}

fn terms(world: &World, shares: Option<Vec<Share>>, transmitted: Option<f64>) -> Summed {
    SimdLevel::default().run(Sum {
        world,
        shares,
        transmitted,
    })
}

/// All points have a reflectance, each by its own weight.
fn share(reflectance: u32, weight: impl Fn(usize) -> f64) -> Share {
    Share {
        members: 0xffff,
        reflectance,
        weights: Some(std::array::from_fn(weight)),
        filter: 0,
    }
}

fn whole(reflectance: u32) -> Share {
    Share {
        members: 0xffff,
        reflectance,
        weights: None,
        filter: 0,
    }
}

const TRANSPORTS: [&str; 2] = ["rgb", "spectral"];

#[test]
fn a_weight_of_one_changes_no_bit() {
    for transport in TRANSPORTS {
        let world = world(transport);
        for reflectance in 0..3 {
            let one = sum(&world, Some(vec![share(reflectance, |_| 1.0)]));
            assert_eq!(one, sum(&world, Some(vec![whole(reflectance)])));
        }
    }
}

/// What weighs nothing is left out, and not multiplied: the sum has no trace of it, not even of one that is
/// beyond all numbers.
#[test]
fn a_weight_of_zero_leaves_nothing() {
    for transport in TRANSPORTS {
        let world = world(transport);
        let alone = sum(&world, Some(vec![whole(1)]));
        assert_eq!(sum(&world, Some(vec![whole(1), share(2, |_| 0.0)])), alone);
        let huge = |lane| if lane % 2 == 0 { 0.0 } else { f64::MAX };
        let some = sum(&world, Some(vec![whole(1), share(2, huge), share(0, huge)]));
        for (channel, alone) in some.iter().zip(alone) {
            for lane in (0..LANES).step_by(2) {
                assert_eq!(channel[lane], alone[lane]);
            }
            assert!(channel.iter().all(|sum| !sum.is_nan()));
        }
    }
}

#[test]
fn the_sum_is_linear_in_the_weights() {
    let weight = |lane: usize| 0.1 + lane as f64 / 17.0;
    for transport in TRANSPORTS {
        let world = world(transport);
        let once = sum(&world, Some(vec![share(0, weight), share(2, |_| 0.25)]));
        let twice = sum(
            &world,
            Some(vec![share(0, |lane| 2.0 * weight(lane)), share(2, |_| 0.5)]),
        );
        assert_eq!(twice, once.map(|channel| channel.map(|sum| 2.0 * sum)));
    }
}

#[test]
fn two_reflectances_are_the_mix_of_two_renders() {
    let weight = |lane: usize| lane as f64 / 15.0;
    for transport in TRANSPORTS {
        let world = world(transport);
        let [one, other] = [0, 2].map(|place| sum(&world, Some(vec![whole(place)])));
        let mixed = vec![share(0, weight), share(2, |lane| 1.0 - weight(lane))];
        let mixed = sum(&world, Some(mixed));
        for channel in 0..3 {
            for lane in 0..LANES {
                let (w, actual) = (weight(lane), mixed[channel][lane]);
                let expected = w * one[channel][lane] + (1.0 - w) * other[channel][lane];
                assert!(
                    (actual - expected).abs() <= 1e-14 * expected,
                    "{channel} {lane}"
                );
            }
        }
    }
}

/// Layers are made of the terms: these must add up to the radiance, to the bit.
#[test]
fn terms_are_what_the_sum_is_made_of() {
    let weight = |lane: usize| if lane == 3 { 0.0 } else { lane as f64 / 7.0 };
    for transport in TRANSPORTS {
        let world = world(transport);
        for shares in [None, Some(vec![whole(1), share(2, weight)])] {
            let is_mixed = shares.is_some();
            let summed = terms(&world, shares, None);
            assert_eq!(summed.added, summed.all);
            let mut added = [[0.0; LANES]; 3];
            let mut count = 0;
            for of_light in &summed.terms {
                let mut alone = [[0.0; LANES]; 3];
                let mut lobes = Lobes::<[[f64; LANES]; 3]>::default();
                for share in &summed.shares {
                    let reflected = world.reflected(of_light.light, share.reflectance as usize);
                    let (kd, ks) = (reflected.diffuse.0.0, reflected.specular.0.0);
                    for lane in ones(of_light.points[0] & share.weighted()) {
                        let [diffuse, specular] =
                            [of_light.geometry.diffuse, of_light.geometry.specular]
                                .map(|geometry| geometry[lane] * share.weight(lane));
                        for channel in 0..3 {
                            let more = diffuse * kd[channel] + specular * ks[channel];
                            lobes.diffuse[channel][lane] += diffuse * kd[channel];
                            lobes.specular[channel][lane] += specular * ks[channel];
                            added[channel][lane] += more;
                            alone[channel][lane] += more;
                        }
                        count += 1;
                    }
                }
                assert_eq!(packet(&of_light.radiance), alone);
                assert_eq!(packet(&of_light.lobes.diffuse), lobes.diffuse);
                assert_eq!(packet(&of_light.lobes.specular), lobes.specular);
            }
            assert_eq!(added, summed.all);
            let points = if is_mixed { 2 * LANES - 1 } else { LANES };
            assert!(count > 2 * points && count < 3 * points);
        }
    }
}

#[test]
fn a_part_of_the_light_is_that_part_of_the_sum() {
    let world = world("rgb");
    let all = terms(&world, None, None).all;
    assert_eq!(terms(&world, None, Some(1.0)).all, all);
    let half = terms(&world, None, Some(0.5)).all;
    assert_eq!(half, all.map(|channel| channel.map(|sum| 0.5 * sum)));
}

/// Whether products are kept in a table or made by each thread is no matter of a bit.
#[test]
fn products_without_a_table_have_the_same_bits() {
    let mut world = world("spectral");
    let expected = terms(&world, None, None);
    let products = |world: &World| -> Vec<_> {
        let pairs = (0..9).map(|pair| world.reflected(pair / 3, pair % 3));
        pairs.collect()
    };
    let table = products(&world);
    assert!(world.products_memory().unwrap() > 0);
    world.drop_table();
    assert_eq!(world.products_memory(), Some(0));
    let summed = terms(&world, None, None);
    assert_eq!(summed.all, expected.all);
    let radiances = |summed: &Summed| -> Vec<_> {
        let terms = summed.terms.iter();
        terms.map(|terms| packet(&terms.radiance)).collect()
    };
    assert_eq!(radiances(&summed), radiances(&expected));
    assert_eq!(products(&world), table);
}
