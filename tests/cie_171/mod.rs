//! The cases of CIE 171:2006 that direct light is enough for, against closed forms. `docs/cie-171.md` has the table;
//! `BLESS=1 cargo test cie_171` writes it anew.

use std::f64::consts::PI;
use std::fmt::Write;
use std::path::Path;

use candela::illuminance;
use candela::render::{Options, render};
use candela::scene::{Camera, Scene};
use candela::world::World;

use crate::measured::{HALF_LAST_BIT, Measured};

const PAGE: &str = "docs/cie-171.md";
const FOLDER: &str = "reference/cie-171";

/// Around what the test writes.
const BEGIN: &str = "<!-- written by tests/cie_171.rs -->\n";
const END: &str = "<!-- until here -->\n";

/// In percent: what is below is rounding.
const NEGLIGIBLE: f64 = 1e-9;

/// In percent: what the integral over the floor is off by below a luminaire.
const CONE: f64 = 1e-7;

/// Relative error of the cosine law as a table of each degree, interpolated: (π/180)² / 8.
const DATA: f64 = 3.81e-5;

/// Lux outside under the uniform sky, and what surfaces that are lights in 5.6 and 5.7 send in lm/m².
const OUTSIDE: f64 = 1e4;
const EXITANCE: f64 = 1e3;

const GROUND: f64 = 0.3;

type Vector = [f64; 3];

const UP: Vector = [0.0, 0.0, 1.0];
const DOWN: Vector = [0.0, 0.0, -1.0];

/// From the wall with the points into the room.
const INWARD: Vector = [0.0, 1.0, 0.0];

/// A point with its letter, the reference, and what is printed in CIE 171 where that is known.
struct Point {
    letter: &'static str,
    at: Vector,
    normal: Vector,
    reference: f64,
    printed: Option<f64>,
}

/// A scene with its points.
struct Case {
    section: &'static str,
    title: &'static str,
    scene: &'static str,
    /// `lx`, or `%` of an illuminance.
    unit: &'static str,
    /// The lux of one unit.
    lux: f64,
    points: Vec<Point>,
    /// Relative error that is allowed beside rounding.
    allowed: f64,
}

/// The fraction of what a small surface receives that comes from a rectangle parallel to it, c away, whose corner is
/// straight above: from 0 to a and from 0 to b. (Howell's catalog, a differential element to a rectangle.)
fn parallel_corner(a: f64, b: f64, c: f64) -> f64 {
    let (p, q) = (a.hypot(c), b.hypot(c));
    (a / p * (b / p).atan() + b / q * (a / q).atan()) / (2.0 * PI)
}

/// The same of any such rectangle: it is odd in a and b.
fn parallel(a: [f64; 2], b: [f64; 2], c: f64) -> f64 {
    let of = |i: usize, j: usize| parallel_corner(a[i], b[j], c);
    of(1, 1) - of(0, 1) - of(1, 0) + of(0, 0)
}

/// The same of a rectangle in a plane along the normal of the small surface, c away; `up` is how far its sides are along the
/// normal, from 0, and `across` along the other way: ∫∫ u c / (π (u² + v² + c²)²) du dv.
fn perpendicular(up: [f64; 2], across: [f64; 2], c: f64) -> f64 {
    let edge = |u: f64| {
        let k = u.hypot(c);
        ((across[1] / k).atan() - (across[0] / k).atan()) / k
    };
    c / (2.0 * PI) * (edge(up[0]) - edge(up[1]))
}

/// 5.2: A to J, half a metre apart on a quarter of the surface below the lamp, which is over (2, 2).
fn below_the_lamp(reference: impl Fn(f64, f64) -> f64, printed: Option<[f64; 10]>) -> Vec<Point> {
    const PLACES: [(&str, f64, f64); 10] = [
        ("A", 0.0, 0.0),
        ("B", 0.5, 0.0),
        ("C", 1.0, 0.0),
        ("D", 1.5, 0.0),
        ("E", 0.5, 0.5),
        ("F", 1.0, 0.5),
        ("G", 1.5, 0.5),
        ("H", 1.0, 1.0),
        ("I", 1.5, 1.0),
        ("J", 1.5, 1.5),
    ];
    let places = PLACES.iter().enumerate();
    let point = |(number, &(letter, x, y)): (usize, &(&'static str, f64, f64))| Point {
        letter,
        at: [2.0 + x, 2.0 + y, 0.0],
        normal: UP,
        reference: reference(x, y),
        printed: printed.map(|printed| printed[number]),
    };
    places.map(point).collect()
}

/// Points half a metre apart, from 0.25 m on, in the middle of a wall, floor or ceiling.
fn row(
    letters: &[&'static str],
    at: impl Fn(f64) -> Vector,
    normal: Vector,
    reference: impl Fn(f64) -> f64,
    printed: &[f64],
) -> Vec<Point> {
    let point = |(number, letter): (usize, &&'static str)| {
        let way = 0.25 + 0.5 * number as f64;
        Point {
            letter,
            at: at(way),
            normal,
            reference: reference(way),
            printed: printed.get(number).copied(),
        }
    };
    letters.iter().enumerate().map(point).collect()
}

const ON_WALL: [&str; 6] = ["A", "B", "C", "D", "E", "F"];
const ON_FLOOR: [&str; 8] = ["G", "H", "I", "J", "K", "L", "M", "N"];
const ON_CEILING: [&str; 8] = ["G′", "H′", "I′", "J′", "K′", "L′", "M′", "N′"];

/// Wall and floor of 5.3 and 5.9 below a square in the middle of a ceiling 3 m high, whose side is `side`, in parts of π L.
fn below_a_square(side: f64, lux: f64, wall: [f64; 6], floor: [f64; 8]) -> Vec<Point> {
    let half = side / 2.0;
    let mut points = row(
        &ON_WALL,
        |down| [2.0, 0.0, 3.0 - down],
        INWARD,
        |down| lux * perpendicular([2.0 - half, 2.0 + half], [-half, half], down),
        &wall,
    );
    points.extend(row(
        &ON_FLOOR,
        |y| [2.0, y, 0.0],
        UP,
        |y| lux * parallel([2.0 - half - y, 2.0 + half - y], [-half, half], 3.0),
        &floor,
    ));
    points
}

/// 5.6: above the ground that is a light. A of the wall is below its lower edge and has no printed value.
fn above_the_ground() -> Vec<Point> {
    let mut points = row(
        &ON_WALL,
        |z| [2.0, 0.0, z],
        INWARD,
        |z| 100.0 * perpendicular([0.0, 4.0], [-2.0, 2.0], z),
        &[f64::NAN, 35.901, 27.992, 21.639, 16.716, 12.967],
    );
    points.remove(0);
    points.extend(row(
        &ON_FLOOR,
        |y| [2.0, y, 3.0],
        DOWN,
        |y| 100.0 * parallel([-y, 4.0 - y], [-2.0, 2.0], 3.0),
        &[26.80, 30.94, 33.98, 35.57, 35.57, 33.98, 30.94, 26.80],
    ));
    points
}

/// 5.7: what is seen of the wall at y = 4 past a box from y = 2.5 to 2.7, 1 m high. It is as wide as the wall, so that the
/// height from which on the wall is seen is the same everywhere. The values are the corrected ones.
fn past_the_box() -> Vec<Point> {
    let lowest = |y: f64, z: f64| {
        let over = |edge: f64| z + (1.0 - z) * (4.0 - y) / (edge - y);
        over(2.5).max(over(2.7)).clamp(0.0, 3.0)
    };
    let mut points = row(
        &ON_WALL,
        |down| [2.0, 0.0, 3.0 - down],
        INWARD,
        |down| {
            let z = 3.0 - down;
            100.0 * parallel([lowest(0.0, z) - z, 3.0 - z], [-2.0, 2.0], 4.0)
        },
        &[16.07, 16.33, 15.40, 13.32, 10.32, 7.08],
    );
    points.extend(row(
        &ON_FLOOR[..5],
        |y| [2.0, y, 0.0],
        UP,
        |y| 100.0 * perpendicular([lowest(y, 0.0), 3.0], [-2.0, 2.0], 4.0 - y),
        &[3.38, 3.63, 3.01, 0.0, 0.0],
    ));
    points
}

/// 5.11: floor or ceiling behind an opening from `up[0]` to `up[1]` from there, in the wall at y = 0.
fn behind_the_facade(is_floor: bool, up: [f64; 2], half: f64, printed: [f64; 8]) -> Vec<Point> {
    let (letters, z, normal, lux) = if is_floor {
        (&ON_FLOOR, 0.0, UP, 100.0)
    } else {
        (&ON_CEILING, 3.0, DOWN, 100.0 * GROUND)
    };
    row(
        letters,
        // From the wall opposite.
        |way| [2.0, 4.0 - way, z],
        normal,
        |way| lux * perpendicular(up, [-half, half], 4.0 - way),
        &printed,
    )
}

fn cases() -> Vec<Case> {
    let case = |section, title, scene, unit, lux, points| Case {
        section,
        title,
        scene,
        unit,
        lux,
        points,
        allowed: 0.0,
    };
    let distance = |x: f64, y: f64| (x * x + y * y + 9.0).sqrt();
    let uniform = |x: f64, y: f64| 1000.0 * 3.0 / distance(x, y).powi(3);
    let diffuse = |x: f64, y: f64| 1000.0 * 9.0 / distance(x, y).powi(4);
    let luminaire = |x: f64, y: f64| {
        let vertical = x.hypot(y).atan2(3.0) / (PI / 2.0);
        let horizontal = y.atan2(x) / (PI / 2.0);
        (1.0 - vertical * (0.4 + 0.5 * horizontal)) * uniform(x, y)
    };
    vec![
        case(
            "5.2",
            "a point, the same intensity to all sides",
            "point-uniform",
            "lx",
            1.0,
            below_the_lamp(uniform, None),
        ),
        Case {
            allowed: DATA,
            ..case(
                "5.2",
                "a luminaire by its data, diffuse",
                "point-diffuse",
                "lx",
                1.0,
                below_the_lamp(
                    diffuse,
                    Some([
                        111.11, 105.21, 90.02, 71.11, 99.73, 85.64, 68.06, 74.36, 59.98, 49.39,
                    ]),
                ),
            )
        },
        case(
            "5.2",
            "a luminaire by its data, another in each plane",
            "point-luminaire",
            "lx",
            1.0,
            below_the_lamp(luminaire, None),
        ),
        case(
            "5.3",
            "an area, diffuse",
            "area-source",
            "lx",
            1.0,
            below_a_square(
                1.0,
                1000.0 * PI,
                [32.68, 75.09, 81.38, 69.12, 53.41, 39.90],
                [61.27, 79.18, 95.52, 105.89, 105.89, 95.52, 79.18, 61.27],
            ),
        ),
        case(
            "5.6",
            "diffuse reflection, 4 m × 4 m",
            "diffuse-reflection",
            "%",
            EXITANCE / 100.0,
            above_the_ground(),
        ),
        case(
            "5.7",
            "diffuse reflection past an obstruction",
            "obstruction",
            "%",
            EXITANCE / 100.0,
            past_the_box(),
        ),
        case(
            "5.9",
            "uniform sky, opening of 1 m × 1 m in the roof",
            "roof-opening-1",
            "%",
            OUTSIDE / 100.0,
            below_a_square(
                1.0,
                100.0,
                [1.04, 2.39, 2.59, 2.20, 1.70, 1.27],
                [1.95, 2.52, 3.04, 3.37, 3.37, 3.04, 2.52, 1.95],
            ),
        ),
        case(
            "5.9",
            "uniform sky, opening of 4 m × 4 m in the roof",
            "roof-opening-4",
            "%",
            OUTSIDE / 100.0,
            below_a_square(
                4.0,
                100.0,
                [46.74, 36.05, 28.05, 21.67, 16.73, 12.98],
                [26.80, 30.95, 33.99, 35.58, 35.58, 33.99, 30.95, 26.80],
            ),
        ),
        case(
            "5.11",
            "uniform sky, opening of 2 m × 1 m in the facade, floor",
            "facade-2x1-sky",
            "%",
            OUTSIDE / 100.0,
            behind_the_facade(
                true,
                [1.0, 2.0],
                1.0,
                [1.27, 1.75, 2.49, 3.59, 5.19, 7.11, 7.99, 4.13],
            ),
        ),
        case(
            "5.11",
            "ground, opening of 2 m × 1 m in the facade, ceiling",
            "facade-2x1-ground",
            "%",
            OUTSIDE / 100.0,
            behind_the_facade(
                false,
                [1.0, 2.0],
                1.0,
                [0.38, 0.53, 0.75, 1.08, 1.56, 2.14, 2.40, 1.24],
            ),
        ),
        case(
            "5.11",
            "uniform sky, opening of 4 m × 3 m in the facade, floor",
            "facade-4x3-sky",
            "%",
            OUTSIDE / 100.0,
            behind_the_facade(
                true,
                [0.0, 3.0],
                2.0,
                [5.79, 7.63, 10.20, 13.78, 18.76, 25.50, 34.24, 45.29],
            ),
        ),
        case(
            "5.11",
            "ground, opening of 4 m × 3 m in the facade, ceiling",
            "facade-4x3-ground",
            "%",
            OUTSIDE / 100.0,
            behind_the_facade(
                false,
                [0.0, 3.0],
                2.0,
                [1.74, 2.29, 3.06, 4.14, 5.63, 7.65, 10.27, 13.59],
            ),
        ),
    ]
}

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
