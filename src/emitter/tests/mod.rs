//! The closed forms beside published numbers, brute force, and what symmetry demands.

mod brute;
mod cubature;
mod fuzz;
mod lobes;
mod panes;
mod shadow_fuzz;
mod shadows;
mod symmetry;

use std::f64::consts::PI;

use super::clip::MOST_CORNERS;
use super::conic::Conic;
use super::lambert::{half_arc, half_edge};
use super::{Emitter, Outline, Polygon, polygon};
use crate::math::{DVec3, Direction, Normal, Point};

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

fn normal(vector: DVec3) -> Normal {
    Normal::new(vector).unwrap()
}

fn direction(vector: DVec3) -> Direction {
    Direction::new(vector).unwrap()
}

/// The square from −½ to ½, one above.
fn square() -> [DVec3; 4] {
    [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(x, y)| v(x, y, 1.0))
}

fn tilted() -> [DVec3; 4] {
    [(0.0, 0.5), (2.0, 0.5), (2.0, 1.5), (0.0, 1.5)].map(|(y, z)| v(1.0, y, z))
}

/// To the digits there are.
#[track_caller]
fn is_near(actual: f64, expected: f64) {
    let error = (actual / expected - 1.0).abs();
    assert!(error < 1e-12, "{actual} instead of {expected}: {error:e}");
}

#[test]
fn polygons_have_the_irradiance_computed_apart() {
    let up = DVec3::Z;
    is_near(polygon::irradiance(&square(), up), 0.752_274_688_454_1);
    is_near(polygon::solid_angle(&square()), 0.805_431_683_161_3);
    is_near(polygon::irradiance(&tilted(), up), 0.242_317_295_298_5);
    let half_below = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let half_below = half_below.map(|(y, z)| v(1.0, y, z));
    is_near(polygon::irradiance(&half_below, up), 0.350_188_287_713_9);
    let triangle = [v(1.0, 0.0, 2.0), v(0.0, 1.0, 2.0), v(-1.0, -1.0, 3.0)];
    is_near(polygon::irradiance(&triangle, up), 0.258_953_915_278_9);
    let slanted = v(1.0, 2.0, 3.0).normalize();
    is_near(polygon::irradiance(&triangle, slanted), 0.218_092_502_827_3);
    let triangle = [v(2.0, 0.0, -1.0), v(0.0, 2.0, 1.0), v(-1.0, 0.0, 2.0)];
    is_near(polygon::irradiance(&triangle, up), 1.007_414_075_184);
}

#[test]
fn spheres_and_disks_have_the_irradiance_computed_apart() {
    for (radius, distance, degrees, expected) in [
        (1.0, 3.0, 30.0, 0.302_299_894_039),
        (1.0, 2.0, 75.0, 0.221_200_880_053),
        (1.0, 2.0, 90.0, 0.090_586_073_706_08),
        (1.0, 2.0, 110.0, 0.006_753_065_521_712),
        (0.9, 1.0, 100.0, 0.518_440_885_579_3),
    ] {
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        let sphere = Conic::of_sphere(v(sin, 0.0, cos) * distance, radius).unwrap();
        is_near(sphere.irradiance(DVec3::Z), expected);
    }
    let disk = |center: DVec3, normal: DVec3, radius: f64| {
        let disk = Conic::of_disk(center, normal.normalize(), radius);
        disk.unwrap().irradiance(DVec3::Z)
    };
    is_near(disk(v(0.0, 0.0, 2.0), -DVec3::Z, 1.0), 0.628_318_530_718_0);
    is_near(disk(v(1.5, 0.0, 2.0), -DVec3::Z, 1.0), 0.321_335_102_751_7);
    let facing = v(-1.0, 0.0, -1.0);
    is_near(disk(v(1.0, 0.0, 2.0), facing, 0.5), 0.127_183_141_976_7);
}

#[test]
fn lobes_are_those_computed_apart() {
    let w = v(0.3, 0.1, 1.0).normalize();
    for (exponent, expected) in [
        (1.0, 0.717_265_772_277_4),
        (2.0, 0.644_560_501_359_9),
        (5.0, 0.489_963_703_528_4),
        (12.5, 0.303_857_876_394_6),
        (20.0, 0.221_608_143_751_3),
        (50.0, 0.108_928_398_561_9),
    ] {
        is_near(polygon::lobe(&square(), w, exponent), expected);
    }
    let with_cosine = polygon::cosine_lobe(&square(), w, DVec3::Z, 20.0);
    is_near(with_cosine, 0.209_539_557_180_2);
    let w = DVec3::ONE.normalize();
    is_near(polygon::lobe(&tilted(), w, 50.0), 0.102_967_831_981_2);
}

/// What is left of the square behind a half-plane and behind triangles.
#[test]
fn shadows_are_cut_out_exactly() {
    let square = Polygon::new(&square()).unwrap();
    // Dark where x < 0.1 at z = 0.5.
    let visible = square.clipped(v(1.0, 0.0, -0.2)).unwrap();
    let irradiance = polygon::irradiance(visible.corners(), DVec3::Z);
    is_near(irradiance, 0.207_575_167_619_8);
    for (triangle, expected) in [
        (
            [(-0.1, -0.1), (0.15, -0.05), (0.0, 0.15)],
            0.642_357_466_148_9,
        ),
        ([(0.0, -0.1), (0.4, 0.05), (0.05, 0.3)], 0.554_641_868_674),
    ] {
        let [a, b, c] = triangle.map(|(x, y)| v(x, y, 0.5));
        let edges = [a.cross(b), b.cross(c), c.cross(a)];
        let hidden = edges
            .iter()
            .fold(square, |part, &edge| part.clipped(edge).unwrap());
        let all = polygon::irradiance(square.corners(), DVec3::Z);
        let hidden = polygon::irradiance(hidden.corners(), DVec3::Z);
        is_near(all - hidden, expected);
        // The same, as what is outside of each edge and inside of those before.
        let (mut rest, mut sum) = (square, 0.0);
        for edge in edges {
            let outside = rest.clipped(-edge).unwrap();
            sum += polygon::irradiance(outside.corners(), DVec3::Z);
            rest = rest.clipped(edge).unwrap();
        }
        is_near(sum, expected);
    }
}

/// Two caps: the boundary of what both cover is an arc of each.
#[test]
fn a_sphere_hides_a_part_of_another() {
    let [light, occluder] = [(v(0.0, 1.0, 4.0), 1.0), (v(0.2, 0.4, 2.0), 0.5)];
    let light_cone = Conic::of_sphere(light.0, light.1).unwrap();
    let free = light_cone.irradiance(DVec3::Z);
    is_near(free, 0.179_281_914_787_8);
    let part = |(center, radius): (DVec3, f64), (other, other_radius): (DVec3, f64)| {
        let axis = center.normalize();
        let [x, y] = cubature::axes_across(axis);
        let (x, y) = if x.cross(y).dot(axis) > 0.0 {
            (x, y)
        } else {
            (y, x)
        };
        let sin = radius / center.length();
        let cos = (1.0 - sin * sin).sqrt();
        // Where axis₂ · g(t) = cos α₂.
        let other_axis = other.normalize();
        let bound = (1.0 - (other_radius / other.length()).powi(2)).sqrt();
        let [along_x, along_y] = [x, y].map(|side| sin * side.dot(other_axis));
        let middle = along_y.atan2(along_x);
        let offset = (bound - cos * axis.dot(other_axis)) / along_x.hypot(along_y);
        let half = offset.acos();
        let local = v(x.dot(DVec3::Z), y.dot(DVec3::Z), axis.dot(DVec3::Z));
        half_arc([sin, sin, cos], local, [middle - half, middle + half])
    };
    let hidden = part(light, occluder) + part(occluder, light);
    is_near(free - hidden, 0.047_965_214_289_76);
}

#[test]
fn an_edge_through_the_point_has_no_side() {
    assert_eq!(half_edge(DVec3::Z, DVec3::X, -DVec3::X), 0.0);
    assert_eq!(half_edge(DVec3::Z, DVec3::X, DVec3::X), 0.0);
    assert_eq!(half_edge(DVec3::Z, DVec3::ZERO, DVec3::X), 0.0);
}

/// In front of it, behind it, and in its plane.
#[test]
fn emitters_shine_to_their_sides() {
    let center = Point::new(0.0, 0.0, 2.0);
    let above = Point::new(0.1, 0.2, 3.0);
    let below = Point::new(0.1, 0.2, 1.0);
    let within_plane = Point::new(0.1, 0.2, 2.0);
    let halves = [v(0.5, 0.0, 0.0), v(0.0, 0.25, 0.0)];
    for is_two_sided in [false, true] {
        let rectangle = Emitter::rectangle(center, halves, is_two_sided).unwrap();
        let disk = Emitter::disk(center, normal(DVec3::Z), 0.5, is_two_sided).unwrap();
        for emitter in [rectangle, disk] {
            let irradiance = |point: Point, n: DVec3| {
                let outline = emitter.seen_from(point);
                outline.map(|outline| outline.irradiance(normal(n)))
            };
            let lit = irradiance(above, -DVec3::Z).unwrap();
            assert!(lit > 0.1);
            assert_eq!(irradiance(below, DVec3::Z), is_two_sided.then_some(lit));
            assert_eq!(irradiance(within_plane, DVec3::X), None);
        }
    }
    let sphere = Emitter::sphere(center, 0.5).unwrap();
    assert!(sphere.seen_from(above).is_some() && sphere.seen_from(below).is_some());
    assert!(sphere.seen_from(center).is_none());
    assert!(sphere.seen_from(Point::new(0.0, 0.0, 2.5)).is_none());
}

#[test]
fn an_outline_is_what_it_holds() {
    let center = Point::new(0.0, 0.0, 1.0);
    let halves = [v(0.0, 0.5, 0.0), v(0.5, 0.0, 0.0)];
    let [n, w] = [v(0.1, 0.2, 1.0), v(0.3, 0.1, 1.0)].map(DVec3::normalize);
    let disk = Conic::of_disk(DVec3::Z, -DVec3::Z, 0.5).unwrap();
    for (emitter, [solid_angle, irradiance, lobe, cosine_lobe]) in [
        (
            Emitter::rectangle(center, halves, false),
            [
                polygon::solid_angle(&square()),
                polygon::irradiance(&square(), n),
                polygon::lobe(&square(), w, 20.0),
                polygon::cosine_lobe(&square(), w, n, 20.0),
            ],
        ),
        (
            Emitter::disk(center, normal(-DVec3::Z), 0.5, false),
            [
                disk.solid_angle(),
                disk.irradiance(n),
                disk.lobe(w, 20.0),
                disk.cosine_lobe(w, n, 20.0),
            ],
        ),
    ] {
        let origin = Point::new(0.0, 0.0, 0.0);
        let outline = emitter.unwrap().seen_from(origin).unwrap();
        is_near(outline.solid_angle(), solid_angle);
        is_near(outline.irradiance(normal(n)), irradiance);
        is_near(outline.lobe(direction(w), 20.0), lobe);
        is_near(
            outline.cosine_lobe(direction(w), normal(n), 20.0),
            cosine_lobe,
        );
    }
}

#[test]
fn what_has_no_area_is_no_emitter() {
    let center = Point::new(0.0, 0.0, 2.0);
    assert!(Emitter::rectangle(center, [DVec3::X, DVec3::X], false).is_none());
    assert!(Emitter::rectangle(center, [DVec3::X, DVec3::NAN], false).is_none());
    assert!(Emitter::disk(center, normal(DVec3::Z), 0.0, false).is_none());
    assert!(Emitter::sphere(center, f64::NAN).is_none());
    assert!(Emitter::sphere(Point::new(f64::INFINITY, 0.0, 0.0), 1.0).is_none());
}

/// The flux through a large sphere around it, and the intensity along the normal, by the irradiance that arrives.
#[test]
fn sizes_are_what_arrives() {
    let halves = [v(0.3, 0.0, 0.0), v(0.0, 0.2, 0.0)];
    let center = Point::new(0.0, 0.0, 0.0);
    let far = 1e4;
    for (emitter, intensity, flux) in [
        (Emitter::rectangle(center, halves, false), 0.24, 0.24 * PI),
        (Emitter::rectangle(center, halves, true), 0.24, 0.48 * PI),
        (
            Emitter::disk(center, normal(DVec3::Z), 0.5, false),
            0.25 * PI,
            0.25 * PI * PI,
        ),
        (Emitter::sphere(center, 0.5), 0.25 * PI, PI * PI),
    ] {
        let emitter = emitter.unwrap();
        is_near(emitter.intensity(), intensity);
        is_near(emitter.flux(), flux);
        let arriving = |way: DVec3| {
            let outline = emitter.seen_from(Point(way * far));
            outline.map_or(0.0, |outline| outline.irradiance(normal(-way))) * far * far
        };
        assert!((arriving(DVec3::Z) / intensity - 1.0).abs() < 1e-8);
        // Over rings of one area each.
        let rings = 1000;
        let ring = |place: u32| {
            let cosine = (2.0 * f64::from(place) + 1.0) / f64::from(rings) - 1.0;
            arriving(v((1.0 - cosine * cosine).sqrt(), 0.0, cosine))
        };
        let total: f64 = (0..rings).map(ring).sum();
        let total = total * 4.0 * PI / f64::from(rings);
        assert!((total / flux - 1.0).abs() < 1e-6, "{total} {flux}");
    }
}

#[test]
fn there_is_an_end_to_corners_and_planes() {
    let corners = [DVec3::Z; MOST_CORNERS + 1];
    assert!(Polygon::new(&corners).is_none());
    let full = Polygon::new(&corners[1..]).unwrap();
    assert!(full.clipped(DVec3::Z).is_some());
    assert!(Polygon::new(&[DVec3::Z, DVec3::NAN, DVec3::X]).is_none());
    let planes = (0..24).map(|turn| {
        let (sin, cos) = f64::from(turn).sin_cos();
        normal(v(cos, sin, 0.0))
    });
    let mut outline = Conic::of_disk(DVec3::Z, DVec3::Z, 0.5).map(Outline::Conic);
    for plane in planes {
        outline = outline.unwrap().clipped(plane);
    }
    let outline = outline.unwrap();
    assert!(outline.irradiance(normal(DVec3::Z)) < 1e-15);
    assert!(outline.clipped(normal(v(1.0, 1.0, 0.0))).is_none());
    assert!(outline.lobe(direction(v(0.1, 0.0, 1.0)), 20.0) < 1e-15);
}

/// Two planes that face each other leave nothing of a cone, however rounding turns them: neither chord is left without the
/// other.
#[test]
fn between_planes_that_face_each_other_is_nothing() {
    let disk = Conic::of_disk(v(0.1, 0.2, 1.0), DVec3::Z, 0.5).unwrap();
    for turn in 0..100 {
        let (sin, cos) = f64::from(turn).sin_cos();
        let plane = v(cos, sin, -0.2 * sin);
        for off in [0.0, 1e-16, 4e-16, 2e-15, 1e-14, 1e-12] {
            for [x, z] in [[off, 0.0], [0.0, off], [0.0, -off], [off, -off]] {
                let facing = -plane + v(x, 0.0, z);
                let cut = |outline: Conic, plane: DVec3| outline.clipped(normal(plane).get());
                let left = cut(cut(disk, plane).unwrap(), facing).unwrap();
                let up = normal(v(0.3, 0.1, 1.0)).get();
                let all = [
                    left.irradiance(up),
                    left.irradiance(normal(plane).get()),
                    left.irradiance(normal(facing).get()),
                    left.lobe(up, 20.0),
                    left.cosine_lobe(up, DVec3::Z, 3.0),
                    left.solid_angle(),
                ];
                let most = 1e-14 + 4.0 * off;
                assert!(
                    all.iter().all(|&part| part < most),
                    "{turn} {off:e} {all:?}"
                );
            }
        }
    }
}
