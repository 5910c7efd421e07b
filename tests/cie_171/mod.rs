//! The cases of CIE 171:2006 that direct light is enough for, against closed forms. `docs/cie-171.md` has the table;
//! `BLESS=1 cargo test cie_171` writes it anew.

mod cases;

use std::f64::consts::PI;
use std::fmt::Write;
use std::path::Path;

use candela::illuminance;
use candela::render::{Options, render};
use candela::scene::{Camera, Scene};
use candela::world::World;

use crate::measured::{HALF_LAST_BIT, Measured};
use cases::{Point, Vector, cases, parallel, perpendicular};

const PAGE: &str = "docs/cie-171.md";
const FOLDER: &str = "reference/cie-171";

/// Around what the test writes.
const BEGIN: &str = "<!-- written by tests/cie_171/mod.rs -->\n";
const END: &str = "<!-- until here -->\n";

/// In percent: what is below is rounding.
const NEGLIGIBLE: f64 = 1e-9;

/// In percent: what the integral over the floor is off by below a luminaire.
const CONE: f64 = 1e-7;

fn scene(name: &str) -> Scene {
    let path = Path::new(FOLDER).join(format!("{name}.toml"));
    Scene::load(path).unwrap_or_else(|error| panic!("{error}"))
}

/// Lux at each point, as `candela lux` has it.
fn metered(world: &World, points: &[Point]) -> Vec<f64> {
    let of = |point: &Point| illuminance(world, &[point.at], point.normal).unwrap()[0];
    points.iter().map(of).collect()
}

/// The same from a picture of one pixel of the white surface there: E = π L.
fn seen(world: &World, point: &Point) -> f64 {
    let eye = [0, 1, 2].map(|axis| point.at[axis] + 1e-3 * point.normal[axis]);
    let camera = Camera::orthographic(eye, point.at, 1e-9).up([1.0, 0.0, 0.0]);
    let camera = world.place(&camera, [1, 1]).unwrap();
    let film = render(world, &camera, &Options::default()).unwrap();
    PI * f64::from(film.pixels()[0][1])
}

/// Of a reference that is 0 the error is in percent of the unit.
fn error_in_percent(found: f64, reference: f64) -> f64 {
    let scale = if reference == 0.0 { 1.0 } else { reference };
    100.0 * ((found - reference) / scale).abs()
}

/// An error in percent for the page: one digit, rounded up.
fn told(error: f64) -> String {
    if error < NEGLIGIBLE {
        return "< 1e-9".to_owned();
    }
    let power = 10.0_f64.powf(error.log10().floor());
    format!("{:.0e}", (error / power).ceil() * power)
}

/// The nodes and weights of a Gauss–Legendre rule on −1 to 1, by Newton's method.
fn gauss(count: usize) -> Vec<(f64, f64)> {
    let rule = |number: usize| {
        let n = count as f64;
        let mut x = (PI * (number as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..100 {
            let (mut before, mut value) = (1.0, x);
            for k in 2..=count {
                let k = k as f64;
                (before, value) = (
                    value,
                    ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k,
                );
            }
            slope = n * (x * value - before) / (x * x - 1.0);
            x -= value / slope;
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(rule).collect()
}

/// 5.4: lm that arrive on the six surfaces of the room, each parted where light from (1.2, 2.3, `height`) may have a kink.
fn flux(world: &World, height: f64) -> f64 {
    const ROOM: Vector = [4.0, 4.0, 3.0];
    let (rule, kinks) = (gauss(32), [1.2, 2.3, height]);
    let mut sum = 0.0;
    for (axis, end) in (0..3).flat_map(|axis| [(axis, 0.0), (axis, ROOM[axis])]) {
        let mut normal = [0.0; 3];
        normal[axis] = if end == 0.0 { 1.0 } else { -1.0 };
        let across = [(axis + 1) % 3, (axis + 2) % 3];
        let nodes = across.map(|axis| {
            let panel = |[from, to]: [f64; 2]| {
                let half = (to - from) / 2.0;
                let node =
                    move |&(x, weight): &(f64, f64)| (from + half * (1.0 + x), weight * half);
                rule.iter().map(node).collect::<Vec<_>>()
            };
            [[0.0, kinks[axis]], [kinks[axis], ROOM[axis]]]
                .map(panel)
                .concat()
        });
        let (mut points, mut areas) = (Vec::new(), Vec::new());
        for (u, du) in &nodes[0] {
            for (v, dv) in &nodes[1] {
                let mut point = [end; 3];
                (point[across[0]], point[across[1]]) = (*u, *v);
                points.push(point);
                areas.push(du * dv);
            }
        }
        let lux = illuminance(world, &points, normal).unwrap();
        sum += lux
            .iter()
            .zip(&areas)
            .map(|(lux, area)| lux * area)
            .sum::<f64>();
    }
    sum
}

/// What is written on the page, and a word on each thing that is wrong.
fn found() -> (String, Vec<String>) {
    let mut summary = "| section | case | scene | points | largest error in % | largest difference from the printed value in % |\n\
                       | --- | --- | --- | --- | --- | --- |\n"
        .to_owned();
    let (mut points, mut objections) = (String::new(), Vec::new());
    let mut pictures = Measured::rounding("pictures of the cases");
    for case in cases() {
        let (world, _) = World::new(&scene(case.scene)).unwrap_or_else(|error| panic!("{error}"));
        let lux = metered(&world, &case.points);
        let (mut worst, mut worst_printed) = (0.0_f64, None::<f64>);
        let unit = case.unit;
        write!(
            points,
            "\n**{}, {}**\n\n| point | x, y, z in m | reference in {unit} | candela in {unit} | error in % | printed |\n\
             | --- | --- | --- | --- | --- | --- |\n",
            case.section, case.title
        )
        .unwrap();
        for (point, lux) in case.points.iter().zip(lux) {
            let value = lux / case.lux;
            let error = error_in_percent(value, point.reference);
            worst = worst.max(error);
            let allowed = 100.0 * case.allowed + NEGLIGIBLE;
            if error > allowed {
                objections.push(format!(
                    "{} {}: {value}, expected {}",
                    case.scene, point.letter, point.reference
                ));
            }
            let picture = seen(&world, point) / case.lux;
            let of_picture = (picture - value).abs() / value.max(1e-3);
            pictures.see(of_picture, || format!("{} {}", case.scene, point.letter));
            let printed = point.printed.map_or_else(
                || "–".to_owned(),
                |printed| {
                    if printed > 0.0 {
                        let difference = 100.0 * (printed / point.reference - 1.0).abs();
                        worst_printed = Some(worst_printed.unwrap_or(0.0).max(difference));
                    }
                    printed.to_string()
                },
            );
            let [x, y, z] = point.at;
            writeln!(
                points,
                "| {} | {x}, {y}, {z} | {:.4} | {value:.4} | {} | {printed} |",
                point.letter,
                point.reference,
                told(error)
            )
            .unwrap();
        }
        writeln!(
            summary,
            "| {} | {} | `{}` | {} | {} | {} |",
            case.section,
            case.title,
            case.scene,
            case.points.len(),
            told(worst),
            worst_printed.map_or_else(|| "–".to_owned(), |worst| format!("{worst:.2}"))
        )
        .unwrap();
    }
    pictures.judge();

    write!(
        points,
        "\n**5.4, flux onto the six surfaces of a closed room**\n\n| light | scene | leaves in lm | arrives in lm | error in % |\n\
         | --- | --- | --- | --- | --- |\n"
    )
    .unwrap();
    let mut worst = 0.0_f64;
    for (light, name, height, leaves) in [
        ("a point", "room-point", 1.1, 1e4),
        // 4 ∫∫ I(V, H) sin V dV dH over one quadrant.
        (
            "a luminaire by its data",
            "room-luminaire",
            2.6,
            2000.0 * PI - 2600.0,
        ),
        ("a panel of 1 m × 1 m", "room-panel", 2.6, 1e4),
        ("a globe, R = 0.5 m", "room-globe", 1.6, 1e4),
    ] {
        let (world, _) = World::new(&scene(name)).unwrap_or_else(|error| panic!("{error}"));
        let arrives = flux(&world, height);
        let error = error_in_percent(arrives, leaves);
        worst = worst.max(error);
        // The luminaire's intensity has a cone's tip straight below it, where Gauss's rule is not exact.
        let allowed = if name == "room-luminaire" {
            CONE
        } else {
            NEGLIGIBLE
        };
        if error > allowed {
            objections.push(format!("{name}: {arrives} lm, expected {leaves}"));
        }
        writeln!(
            points,
            "| {light} | `{name}` | {leaves:.4} | {arrives:.4} | {} |",
            told(error)
        )
        .unwrap();
    }
    writeln!(
        summary,
        "| 5.4 | conservation of flux, four lights | `room-…` | six surfaces | {} | 0 |",
        told(worst)
    )
    .unwrap();
    (format!("{summary}{points}"), objections)
}

#[test]
fn cases_are_their_closed_forms() {
    let (table, objections) = found();
    println!("{table}");
    assert!(objections.is_empty(), "{}", objections.join("\n"));
    let page = std::fs::read_to_string(PAGE).unwrap();
    let begin = page.find(BEGIN).expect("the page has the table") + BEGIN.len();
    let end = page.find(END).expect("the table has an end");
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(PAGE, format!("{}{table}{}", &page[..begin], &page[end..])).unwrap();
    } else {
        assert_eq!(&page[begin..end], table, "BLESS=1 writes {PAGE} anew");
    }
}

/// The references are right, and the scenes and the page belong together.
#[test]
fn references_are_published_factors() {
    // A square of side 1 straight above, 1 away; one from 0 to 2 and from 0.5 to 1.5 before a wall: twelve digits of
    // quadrature, as E/L.
    let above = PI * parallel([-0.5, 0.5], [-0.5, 0.5], 1.0);
    assert!((above - 0.752_274_688_454_1).abs() < 1e-12, "{above}");
    let beside = PI * perpendicular([0.5, 1.5], [0.0, 2.0], 1.0);
    assert!((beside - 0.242_317_295_298_5).abs() < 1e-12, "{beside}");
    let page = std::fs::read_to_string(PAGE).unwrap();
    for entry in std::fs::read_dir(FOLDER).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        if path.extension().is_some_and(|end| end == "toml") && name != "camera" {
            assert!(page.contains(&format!("`{name}`")), "{name}");
        }
    }
    let rule: f64 = gauss(32)
        .iter()
        .map(|(x, weight)| weight * x.powi(10))
        .sum();
    assert!(
        (rule - 2.0 / 11.0).abs() < 10.0 * HALF_LAST_BIT.powi(2),
        "{rule}"
    );
}
