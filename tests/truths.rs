//! Numbers that nobody here made: published illuminances, the conservation of flux, a book's tests, and
//! what other programs compute.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::fs;
use std::path::Path;
use std::process::Command;

use candela::scene::Scene;

use crate::conformance::{FOLDER, printed, script};
use crate::images::{film_of, pixel, render};
use crate::measured::Measured;

/// Relative error of the flux of a closed room: of the sum instead of an integral, and roundings to f32.
pub(crate) const FLUX: f64 = 1.57e-9;

/// Relative difference of a pixel from that of Radiance, which carries colors in f32.
pub(crate) const RADIANCE: f64 = 3.14e-7;

/// Lux in a footcandle: one lumen to the square foot.
const FOOTCANDLE: f64 = 1.0 / (FOOT * FOOT);
const FOOT: f64 = 0.3048;

/// E in lux at the origin of a plane with this normal, from the radiance of a white Lambertian surface: E = π L.
fn illuminance(normal: [f64; 3], lights: &[([f64; 3], String)]) -> f64 {
    // From the side of the normal.
    let eye = normal.map(|x| 0.01 * x);
    let mut text = format!(
        "[image]\nresolution = [1, 1]\n\
         [camera.orthographic]\neye = {eye:?}\nlook_at = [0, 0, 0]\nup = [0.3, 0.1, 1]\nheight = 1e-6\n\
         [materials.white.normalized_phong]\ndiffuse = 1\n\
         [objects.plane.plane]\nmaterial = \"white\"\npoint = [0, 0, 0]\nnormal = {normal:?}\n"
    );
    for (number, (position, intensity)) in lights.iter().enumerate() {
        text += &format!(
            "[lights.l{number}.point]\nposition = {position:?}\nintensity = {intensity}\n"
        );
    }
    PI * f64::from(pixel(&render(&text, 1), 0, 0)[1])
}

/// A floor below one lamp so high and so far aside.
fn below(intensity: &str, up: f64, aside: f64) -> f64 {
    illuminance([0.0, 1.0, 0.0], &[([aside, up, 0.0], intensity.to_owned())])
}

/// A surface turned away by so many degrees from a lamp straight before it.
fn turned(candela: f64, distance: f64, degrees: f64) -> f64 {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let lamp = ([0.0, distance, 0.0], candela.to_string());
    illuminance([sine, cosine, 0.0], &[lamp])
}

/// A row of lamps of 100 cd, 9.15 m apart and 4.575 m up, from `first` spacings aside.
fn row(count: u32, first: f64) -> f64 {
    let lamps = (0..count).map(|number| {
        let aside = 9.15 * (first + f64::from(number));
        ([aside, 4.575, 0.0], "100".to_owned())
    });
    illuminance([0.0, 1.0, 0.0], &lamps.collect::<Vec<_>>())
}

/// Exercises of textbooks on lighting and physics with their printed results, each to its last digit. One of 200 cd at
/// 6 m, 5 m aside, is printed as 4.27 lx elsewhere, by the first power of the cosine.
#[test]
fn published_illuminances() {
    let ball = format!("{:?}", 2e4 * PI * 0.06 * 0.06);
    for (what, found, printed, digit) in [
        (
            "20 cd, 40 cm up, 30 cm aside",
            below("20", 0.4, 0.3),
            64.0,
            1e-5,
        ),
        ("5.4 cd, 60 cm up", below("5.4", 0.6, 0.0), 15.0, 1e-5),
        (
            "5.4 cd, 60 cm up, 80 cm aside",
            below("5.4", 0.6, 0.8),
            3.24,
            1e-6,
        ),
        (
            "1200 lm, 8 m up, 6 m aside",
            below("{ lumens = 1200 }", 8.0, 6.0),
            0.7639,
            1e-4,
        ),
        (
            "10 m up: a tenth of the light at 19.08 m",
            below("100", 10.0, 19.08) / below("100", 10.0, 0.0),
            0.1,
            1e-4,
        ),
        ("100 cd, 2 m", turned(100.0, 2.0, 0.0), 25.0, 1e-5),
        ("100 cd, 2 m, 45°", turned(100.0, 2.0, 45.0), 17.6777, 1e-4),
        ("100 cd, 2 m, 90°", turned(100.0, 2.0, 90.0), 0.0, 1e-12),
        ("200 cd, 6 m up", below("200", 6.0, 0.0), 5.5556, 1e-4),
        (
            "200 cd, 6 m up, 5 m aside",
            below("200", 6.0, 5.0),
            2.5188,
            1e-4,
        ),
        (
            "7 lamps in a row, below the middle",
            row(7, -3.0),
            5.81113,
            1e-5,
        ),
        ("6 lamps in a row, midway", row(6, -2.5), 3.75258, 1e-5),
        (
            "2000 cd at 8 ft, in footcandles",
            turned(2000.0, 8.0 * FOOT, 0.0) / FOOTCANDLE,
            31.25,
            1e-5,
        ),
        (
            "2000 cd at 8 ft",
            turned(2000.0, 8.0 * FOOT, 0.0),
            336.37,
            1e-2,
        ),
        (
            "2000 cd at 8 ft, 20°, in footcandles",
            turned(2000.0, 8.0 * FOOT, 20.0) / FOOTCANDLE,
            29.365,
            1e-3,
        ),
        (
            "a ball of 6 cm and 20 000 cd/m², 3 m",
            below(&ball, 3.0, 0.0),
            25.13,
            1e-2,
        ),
        ("450 cd, 3 m, 53.13°", turned(450.0, 3.0, 53.13), 30.0, 1e-3),
        (
            "0.8 lx on white, in cd/m²",
            below("0.8", 1.0, 0.0) / PI,
            0.254_647_909,
            2e-8,
        ),
    ] {
        // The printed digit is rounded, or cut.
        assert!(
            (found - printed).abs() <= digit,
            "{what}: {found}, printed {printed}"
        );
    }
}

/// What CIE 171:2006 asks in 5.4: the flux onto the walls of a closed room is that of the lamp, wherever it is.
#[test]
fn flux_of_a_closed_room() {
    const SIDE: f64 = 4.0;
    const LUMENS: f64 = 1e4;
    /// The sum over the centers of pixels instead of an integral is off by the square of their size: of two sizes,
    /// one twice the other, that is taken off (Richardson 1911).
    const ROWS: [u32; 2] = [96, 192];
    let mut worst = Measured::new("flux of a closed room", FLUX);
    for lamp in [[0.0; 3], [0.7, 0.9, -0.5], [-0.3, 0.2, 1.1]] {
        let mut room = format!(
            "[materials.white.normalized_phong]\ndiffuse = 1\n\
             [lights.lamp.point]\nposition = {lamp:?}\nintensity = {{ lumens = {LUMENS} }}\n"
        );
        let walls: Vec<[f64; 3]> = (0..6)
            .map(|wall| {
                let mut normal = [0.0; 3];
                normal[wall / 2] = if wall % 2 == 0 { 1.0 } else { -1.0 };
                normal
            })
            .collect();
        for (number, normal) in walls.iter().enumerate() {
            let point = normal.map(|x| x * SIDE / 2.0);
            room += &format!(
                "[objects.wall{number}.plane]\nmaterial = \"white\"\npoint = {point:?}\nnormal = {normal:?}\n"
            );
        }
        let onto_walls = |rows: u32| -> f64 {
            let area = (SIDE / f64::from(rows)).powi(2);
            let lux = walls.iter().map(|way| {
                let up = [way[1], way[2], way[0]];
                let view = format!(
                    "[image]\nresolution = [{rows}, {rows}]\n\
                     [camera.orthographic]\neye = [0, 0, 0]\nlook_at = {way:?}\nup = {up:?}\nheight = {SIDE}\n"
                );
                let film = render(&(view + &room), 1);
                let lux = film.pixels().iter().map(|pixel| PI * f64::from(pixel[1]));
                lux.sum::<f64>()
            });
            area * lux.sum::<f64>()
        };
        let [coarse, fine] = ROWS.map(onto_walls);
        let flux = (4.0 * fine - coarse) / 3.0;
        worst.see((flux / LUMENS - 1.0).abs(), || {
            format!("{lamp:?}: {flux} lm")
        });
        // Six walls of 16 m².
        let mean = flux / (6.0 * SIDE * SIDE);
        assert!((mean - 104.1667).abs() < 1e-3, "{mean} lx");
    }
    worst.judge();
}

/// The tests of lighting in *The Ray Tracer Challenge* (Buck 2019), to its four or five digits. Its lights have no
/// falloff, which I = d² undoes; its ambient term, 0.1 of the color, is taken off.
#[test]
fn the_ray_tracer_challenge() {
    const MATERIAL: &str = "[materials.m.phong]\ndiffuse = 0.9\nspecular = 0.9\nshininess = 200\n\
        [objects.o.plane]\nmaterial = \"m\"\npoint = [0, 0, 0]\nnormal = [0, 0, -1]\n";
    let view = |eye: [f64; 3], look_at: [f64; 3]| {
        format!(
            "[image]\nresolution = [1, 1]\n[camera.perspective]\neye = {eye:?}\nlook_at = {look_at:?}\n\
             vertical_fov = 1e-6\n"
        )
    };
    let lamp = |position: [f64; 3], to: [f64; 3]| {
        let square: f64 = (0..3).map(|i| (position[i] - to[i]).powi(2)).sum();
        format!("[lights.l.point]\nposition = {position:?}\nintensity = {square:?}\n")
    };
    let half = 0.5_f64.sqrt();
    for (eye, position, printed) in [
        ([0.0, 0.0, -1.0], [0.0, 0.0, -10.0], 1.9),
        ([0.0, half, -half], [0.0, 0.0, -10.0], 1.0),
        ([0.0, 0.0, -1.0], [0.0, 10.0, -10.0], 0.7364),
        ([0.0, -half, -half], [0.0, 10.0, -10.0], 1.6364),
        ([0.0, 0.0, -1.0], [0.0, 0.0, 10.0], 0.1),
    ] {
        let scene = view(eye, [0.0; 3]) + MATERIAL + &lamp(position, [0.0; 3]);
        let found = f64::from(pixel(&render(&scene, 1), 0, 0)[0]) + 0.1;
        assert!((found - printed).abs() < 1e-4, "{found}, printed {printed}");
    }
    // The default world, seen along z.
    let scene = view([0.0, 0.0, -5.0], [0.0; 3])
        + "[materials.m.phong]\ndiffuse = [0.56, 0.7, 0.42]\nspecular = 0.2\nshininess = 200\n\
           [objects.outer.sphere]\nmaterial = \"m\"\ncenter = [0, 0, 0]\nradius = 1\n\
           [objects.inner.sphere]\nmaterial = \"m\"\ncenter = [0, 0, 0]\nradius = 0.5\n"
        + &lamp([-10.0, 10.0, -10.0], [0.0, 0.0, -1.0]);
    let found = pixel(&render(&scene, 1), 0, 0);
    for ((found, color), printed) in found
        .into_iter()
        .zip([0.8, 1.0, 0.6])
        .zip([0.38066, 0.47583, 0.2855])
    {
        let found = f64::from(found) + 0.1 * color;
        assert!((found - printed).abs() < 1e-5, "{found}, printed {printed}");
    }
}

/// The values of Radiance's `rtrace`, which `reference/README.md` tells how to make again.
#[test]
fn radiance_agrees() {
    /// As the suite scores.
    const FLOOR: f64 = 1e-3;
    let table = fs::read_to_string("reference/radiance.csv").unwrap();
    let mut cases: HashMap<&str, Vec<[f64; 5]>> = HashMap::new();
    for line in table.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let (name, numbers) = line.split_once(',').unwrap();
        let numbers: Vec<f64> = numbers.split(',').map(|n| n.parse().unwrap()).collect();
        cases
            .entry(name)
            .or_default()
            .push(numbers.try_into().unwrap());
    }
    assert_eq!(cases.len(), 8);
    let mut worst = Measured::new("beside Radiance", RADIANCE);
    for (name, rows) in cases {
        let scene = Scene::load(Path::new(FOLDER).join(format!("{name}.toml"))).unwrap();
        let film = film_of(&scene, 1);
        assert_eq!(film.pixels().len(), rows.len(), "{name}");
        let brightest = |[_, _, r, g, b]: &[f64; 5]| r.max(*g).max(*b);
        let peak = rows.iter().map(brightest).fold(0.0, f64::max);
        for row in &rows {
            let scale = brightest(row).max(FLOOR * peak);
            let [x, y, rgb @ ..] = *row;
            for (found, expected) in pixel(&film, x as u32, y as u32).into_iter().zip(rgb) {
                let error = (f64::from(found) - expected).abs() / scale;
                worst.see(error, || format!("{name} {x}, {y}"));
            }
        }
    }
    worst.judge();
}

/// POV-Ray's `phong` is L7 to the letter: the scenes of the suite that it can express, where it is installed. What it
/// loses is what its fixed epsilons lose.
#[test]
fn povray_agrees() {
    if Command::new("povray").arg("--version").output().is_err() {
        println!("not run: there is no povray");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let scores = folder.path().join("scores.json");
    let output = script("run.py")
        .args(["--renderer", "povray", "--jobs", "8", "--json"])
        .arg(&scores)
        .output()
        .unwrap();
    let scores = fs::read_to_string(scores).unwrap_or_else(|_| panic!("{}", printed(&output)));
    let scores: serde_json::Value = serde_json::from_str(&scores).unwrap();
    let of = |verdict: &str| -> Vec<&str> {
        let rows = scores.as_array().unwrap().iter();
        rows.filter(|row| row["verdict"] == verdict)
            .map(|row| row["case"].as_str().unwrap())
            .collect()
    };
    let failed = of("FAIL");
    assert_eq!(
        failed,
        [
            "close-occluder",
            "closer-occluder",
            "a-micrometre",
            "a-thousand-kilometres"
        ]
    );
    let passed = of("pass");
    for lobes in [
        "phong-0.5",
        "phong-1",
        "phong-50",
        "phong-1000",
        "phong-sum",
        "thirty-lights",
    ] {
        assert!(passed.contains(&lobes), "{lobes}: {}", printed(&output));
    }
}
