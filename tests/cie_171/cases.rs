//! The cases: their scenes, points and closed forms.

use std::f64::consts::PI;

/// Relative error of the cosine law as a table of each degree, interpolated: (π/180)² / 8.
const DATA: f64 = 3.81e-5;

/// Lux outside under the uniform sky, and what surfaces that are lights in 5.6 and 5.7 send in lm/m².
const OUTSIDE: f64 = 1e4;
const EXITANCE: f64 = 1e3;

const GROUND: f64 = 0.3;

pub(super) type Vector = [f64; 3];

const UP: Vector = [0.0, 0.0, 1.0];
const DOWN: Vector = [0.0, 0.0, -1.0];

/// From the wall with the points into the room.
const INWARD: Vector = [0.0, 1.0, 0.0];

/// A point with its letter, the reference, and what is printed in CIE 171 where that is known.
pub(super) struct Point {
    pub(super) letter: &'static str,
    pub(super) at: Vector,
    pub(super) normal: Vector,
    pub(super) reference: f64,
    pub(super) printed: Option<f64>,
}

/// A scene with its points.
pub(super) struct Case {
    pub(super) section: &'static str,
    pub(super) title: &'static str,
    pub(super) scene: &'static str,
    /// `lx`, or `%` of an illuminance.
    pub(super) unit: &'static str,
    /// The lux of one unit.
    pub(super) lux: f64,
    pub(super) points: Vec<Point>,
    /// Relative error that is allowed beside rounding.
    pub(super) allowed: f64,
}

/// The fraction of what a small surface receives that comes from a rectangle parallel to it, c away, whose corner is
/// straight above: from 0 to a and from 0 to b. (Howell's catalog, a differential element to a rectangle.)
fn parallel_corner(a: f64, b: f64, c: f64) -> f64 {
    let (p, q) = (a.hypot(c), b.hypot(c));
    (a / p * (b / p).atan() + b / q * (a / q).atan()) / (2.0 * PI)
}

/// The same of any such rectangle: it is odd in a and b.
pub(super) fn parallel(a: [f64; 2], b: [f64; 2], c: f64) -> f64 {
    let of = |i: usize, j: usize| parallel_corner(a[i], b[j], c);
    of(1, 1) - of(0, 1) - of(1, 0) + of(0, 0)
}

/// The same of a rectangle in a plane along the normal of the small surface, c away; `up` is how far its sides are along the
/// normal, from 0, and `across` along the other way: ∫∫ u c / (π (u² + v² + c²)²) du dv.
pub(super) fn perpendicular(up: [f64; 2], across: [f64; 2], c: f64) -> f64 {
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

pub(super) fn cases() -> Vec<Case> {
    let case = |section, title, scene, unit, lux, points| Case {
        section,
        title,
        scene,
        unit,
        lux,
        points,
        allowed: 0.0,
    };
    let of_sky =
        |section, title, scene, points| case(section, title, scene, "%", OUTSIDE / 100.0, points);
    let roof = |title, scene, points| of_sky("5.9", title, scene, points);
    let facade = |title, scene, points| of_sky("5.11", title, scene, points);
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
        roof(
            "uniform sky, opening of 1 m × 1 m in the roof",
            "roof-opening-1",
            below_a_square(
                1.0,
                100.0,
                [1.04, 2.39, 2.59, 2.20, 1.70, 1.27],
                [1.95, 2.52, 3.04, 3.37, 3.37, 3.04, 2.52, 1.95],
            ),
        ),
        roof(
            "uniform sky, opening of 4 m × 4 m in the roof",
            "roof-opening-4",
            below_a_square(
                4.0,
                100.0,
                [46.74, 36.05, 28.05, 21.67, 16.73, 12.98],
                [26.80, 30.95, 33.99, 35.58, 35.58, 33.99, 30.95, 26.80],
            ),
        ),
        facade(
            "uniform sky, opening of 2 m × 1 m in the facade, floor",
            "facade-2x1-sky",
            behind_the_facade(
                true,
                [1.0, 2.0],
                1.0,
                [1.27, 1.75, 2.49, 3.59, 5.19, 7.11, 7.99, 4.13],
            ),
        ),
        facade(
            "ground, opening of 2 m × 1 m in the facade, ceiling",
            "facade-2x1-ground",
            behind_the_facade(
                false,
                [1.0, 2.0],
                1.0,
                [0.38, 0.53, 0.75, 1.08, 1.56, 2.14, 2.40, 1.24],
            ),
        ),
        facade(
            "uniform sky, opening of 4 m × 3 m in the facade, floor",
            "facade-4x3-sky",
            behind_the_facade(
                true,
                [0.0, 3.0],
                2.0,
                [5.79, 7.63, 10.20, 13.78, 18.76, 25.50, 34.24, 45.29],
            ),
        ),
        facade(
            "ground, opening of 4 m × 3 m in the facade, ceiling",
            "facade-4x3-ground",
            behind_the_facade(
                false,
                [0.0, 3.0],
                2.0,
                [1.74, 2.29, 3.06, 4.14, 5.63, 7.65, 10.27, 13.59],
            ),
        ),
    ]
}
