//! The tables of ACES 2.0 by hue: how colorful AP1 gets at the peak's lightness, and the limiting gamut.
//!
//! They are found as OpenColorIO finds them (`ACES2/Transform.cpp`, v2.5), by halving the same intervals as
//! often: where that ends is what its pictures show. Sixteen hues are sought at once.

use fearless_simd::Simd;
use glam::DVec3;

use super::Limits;
use super::appearance::{Appearance, LIGHTNESS};
use super::gamut::{CUSP_MARGIN, Compression, Gamut, Line};
use crate::display::lanes::Rgb;
use crate::simd::{F64x16, Kernel, LANES, Mask64x16, SimdLevel, angle, power};

/// Hues of each table (`gamutTableSize` of the CTL).
pub(super) const HUES: usize = 360;

/// Once around, in degrees.
pub(super) const CIRCLE: f64 = 360.0;

/// The corners of a cube of colors other than black and white, in the order of their hues: red, yellow, green,
/// cyan, blue, magenta.
const CORNERS: [DVec3; 6] = [
    DVec3::new(1.0, 0.0, 0.0),
    DVec3::new(1.0, 1.0, 0.0),
    DVec3::new(0.0, 1.0, 0.0),
    DVec3::new(0.0, 1.0, 1.0),
    DVec3::new(0.0, 0.0, 1.0),
    DVec3::new(1.0, 0.0, 1.0),
];

/// M that AP1 reaches is sought up to 1300, to 0.01 (`make_reachM_table`).
const REACH: Search = Search {
    step: 50.0,
    steps: 25,
    halves: 13,
};

/// γ of the upper hull is sought up to 5, to 1e-5 (`gammaSearchStep`, `gammaMaximum`, `gammaAccuracy`).
const GAMMA: Search = Search {
    step: 0.4,
    steps: 12,
    halves: 16,
};

/// A cusp is sought along an edge of the cube, to 1e-7 of it (OpenColorIO, `display_cusp_tolerance`).
const EDGE: Search = Search {
    step: 1.0,
    steps: 0,
    halves: 24,
};

/// R, G, B of AP1's corners at the peak's J are found to this (OpenColorIO, `reach_cusp_tolerance`).
const CORNER_TOLERANCE: f64 = 1e-3;

/// Where on the way from the cusp's J to the peak's the upper hull must not be inside of the gamut (OpenColorIO,
/// `testPositions`; the CTL has three others).
const HULL_TESTS: [f64; 5] = [0.01, 0.1, 0.5, 0.8, 0.99];

pub(super) struct Tables {
    /// M that AP1 reaches at the peak's J, at 0, 1, … 360°.
    pub(super) reach: Vec<f64>,
    /// From 0 to 360°, almost evenly, with one at each corner of the limiting gamut and of AP1.
    pub(super) cusps: Vec<Cusp>,
}

/// Where a hue of the limiting gamut is most colorful.
#[derive(Clone, Copy)]
pub(super) struct Cusp {
    /// In degrees.
    pub(super) hue: f64,
    /// J
    pub(super) lightness: f64,
    /// M, with the margin for a rounded hull.
    pub(super) colorfulness: f64,
    /// 1/γ of the upper hull.
    pub(super) upper_hull: f64,
}

/// What the tables are made from.
pub(super) struct Source<'a> {
    /// Of AP1.
    pub(super) reach: &'a Appearance,
    /// Of the limiting primaries.
    pub(super) limiting: &'a Appearance,
    pub(super) limits: &'a Limits,
    pub(super) compression: &'a Compression,
    /// R, G, B of the peak.
    pub(super) peak: f64,
    /// R, G, B of the brightest color in the scene.
    pub(super) brightest: f64,
}

impl Tables {
    pub(super) fn new(source: &Source<'_>) -> Self {
        let level = SimdLevel::default();
        let corners = level.run(Opponents {
            of: source.limiting,
            colors: CORNERS.map(|corner| corner * source.peak),
        });
        let corners = corners.map(|corner| corner.hue);
        let hues = even_hues(&both(corners, reach_corners(source, level)));
        let mut tables = Self {
            reach: Vec::with_capacity(HUES + 1),
            cusps: Vec::with_capacity(HUES + 1),
        };
        for start in (0..HUES).step_by(LANES) {
            // Beyond the last hue, the first ones are done again, and left out.
            let places = std::array::from_fn(|lane| (start + lane) % HUES);
            let found = level.run(Sixteen::new(source, places, &hues, corners));
            for lane in 0..LANES.min(HUES - start) {
                tables.reach.push(found.reach[lane]);
                tables.cusps.push(Cusp {
                    hue: hues[start + lane],
                    lightness: found.lightness[lane],
                    colorfulness: found.colorfulness[lane],
                    upper_hull: found.upper_hull[lane],
                });
            }
        }
        // 360° is 0° again.
        tables.reach.push(tables.reach[0]);
        tables.cusps.push(Cusp {
            hue: CIRCLE,
            ..tables.cusps[0]
        });
        tables
    }
}

/// The hues of AP1's corners, each as bright as the peak's J.
fn reach_corners(source: &Source<'_>, level: SimdLevel) -> [f64; CORNERS.len()] {
    let scaled = |scales: [f64; CORNERS.len()]| {
        level.run(Opponents {
            of: source.reach,
            colors: std::array::from_fn(|k| CORNERS[k] * scales[k]),
        })
    };
    let mut ends = [[0.0, source.brightest]; CORNERS.len()];
    // Those of all corners are equally far apart.
    while ends[0][1] - ends[0][0] > CORNER_TOLERANCE {
        let middles = ends.map(|[low, high]| (low + high) / 2.0);
        for (k, color) in scaled(middles).into_iter().enumerate() {
            let end = usize::from(color.achromatic >= source.limits.achromatic);
            ends[k][end] = middles[k];
        }
    }
    scaled(ends.map(|[_, high]| high)).map(|color| color.hue)
}

/// The hues of two sets of corners in order, each once.
fn both(some: [f64; CORNERS.len()], others: [f64; CORNERS.len()]) -> Vec<f64> {
    let mut all = [some, others].concat();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// [`HUES`] hues from 0° on, the corners among them, with as many even steps between two corners as there are
/// degrees, rounded (OpenColorIO, `build_hue_table`; the CTL has them at whole degrees).
fn even_hues(corners: &[f64]) -> Vec<f64> {
    let mut places: Vec<usize> = Vec::with_capacity(corners.len());
    // The first place is that of 0°.
    let mut least = usize::from(corners[0] != 0.0);
    let mut last = None;
    for (k, &hue) in corners.iter().enumerate() {
        let mut place = (hue.round() as usize).clamp(least, HUES - 1);
        if last == Some(place) {
            // Two corners at one place: the one before goes back where there is room, or else this one on.
            if k > 1 && places[k - 2] + 1 != places[k - 1] {
                places[k - 1] -= 1;
            } else {
                place += 1;
            }
        }
        places.push(place.min(HUES - 1));
        // Places up to the end may be taken twice; no hues are then between them.
        (least, last) = (place.min(HUES - 1), Some(place));
    }
    let mut hues = Vec::with_capacity(HUES);
    let (mut from, mut from_hue) = (0, 0.0);
    for (to, &to_hue) in places
        .iter()
        .chain([&HUES])
        .zip(corners.iter().chain([&CIRCLE]))
    {
        let steps = to.saturating_sub(from);
        let step = (to_hue - from_hue) / steps as f64;
        hues.extend((0..steps).map(|k| from_hue + k as f64 * step));
        (from, from_hue) = (*to, to_hue);
    }
    hues
}

#[derive(Clone, Copy)]
struct Opponent {
    achromatic: f64,
    hue: f64,
}

/// A and the hue of six colors.
struct Opponents<'a> {
    of: &'a Appearance,
    colors: [DVec3; CORNERS.len()],
}

impl Kernel for Opponents<'_> {
    type Output = [Opponent; CORNERS.len()];

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let colors = planes(|lane| self.colors[lane % CORNERS.len()]);
        let [achromatic, a, b] = self.of.opponent(simd, load(simd, &colors));
        let hue = angle(simd, [a, b], (a * a + b * b).sqrt()).to_array();
        let achromatic = achromatic.to_array();
        let mut opponents = [Opponent {
            achromatic: 0.0,
            hue: 0.0,
        }; CORNERS.len()];
        for (lane, opponent) in opponents.iter_mut().enumerate() {
            (opponent.achromatic, opponent.hue) = (achromatic[lane], hue[lane]);
        }
        opponents
    }
}

/// Red, green and blue of sixteen colors, apart.
type Colors = [[f64; LANES]; 3];

#[inline(always)]
fn planes(color: impl Fn(usize) -> DVec3) -> Colors {
    let mut planes = [[0.0; LANES]; 3];
    let [red, green, blue] = &mut planes;
    for (lane, ((r, g), b)) in red.iter_mut().zip(green).zip(blue).enumerate() {
        let color = color(lane);
        (*r, *g, *b) = (color.x, color.y, color.z);
    }
    planes
}

#[inline(always)]
fn load<S: Simd>(simd: S, [red, green, blue]: &Colors) -> Rgb<S> {
    [
        F64x16::load(simd, red),
        F64x16::load(simd, green),
        F64x16::load(simd, blue),
    ]
}

/// Where from 0 on something begins: in which of some steps, and then in which half of that, and so on. What
/// does not begin in a step is taken to begin in the one after them.
struct Search {
    step: f64,
    steps: usize,
    halves: usize,
}

impl Search {
    /// The last number where it has not begun, and the first where it has.
    #[inline(always)]
    fn run<S: Simd>(
        &self,
        simd: S,
        has_begun: impl Fn(F64x16<S>) -> Mask64x16<S>,
    ) -> [F64x16<S>; 2] {
        let (mut low, mut high) = (F64x16::splat(simd, 0.0), F64x16::splat(simd, self.step));
        for _ in 0..self.steps {
            let found = has_begun(high);
            if !(!found).any() {
                break;
            }
            low = found.select(low, high);
            high = found.select(high, high + self.step);
        }
        for _ in 0..self.halves {
            let middle = (low + high) * 0.5;
            let found = has_begun(middle);
            low = found.select(low, middle);
            high = found.select(middle, high);
        }
        [low, high]
    }
}

/// Sixteen entries of both tables.
struct Sixteen<'a> {
    source: &'a Source<'a>,
    /// Cosines and sines of the reach's hues, and of the cusps'.
    degrees: [[f64; LANES]; 2],
    hues: [[f64; LANES]; 2],
    /// The corners between which each cusp is.
    edges: [Colors; 2],
}

/// What is found.
struct Found {
    reach: [f64; LANES],
    lightness: [f64; LANES],
    colorfulness: [f64; LANES],
    upper_hull: [f64; LANES],
}

impl<'a> Sixteen<'a> {
    /// Of some places in the tables, with the hues of all cusps and of the limiting gamut's corners.
    fn new(
        source: &'a Source<'_>,
        places: [usize; LANES],
        hues: &[f64],
        corners: [f64; CORNERS.len()],
    ) -> Self {
        let count = CORNERS.len();
        let first = (0..count).min_by(|&a, &b| corners[a].total_cmp(&corners[b]));
        let first = first.expect("there are corners");
        // The corner after a hue; after the last one is the first again.
        let after = places.map(|place| {
            let passed = corners.iter().filter(|&&corner| corner <= hues[place]);
            (first + passed.count()) % count
        });
        let corner = |k: usize| CORNERS[k % count] * source.peak;
        Self {
            source,
            degrees: directions(places.map(|place| place as f64)),
            hues: directions(places.map(|place| hues[place])),
            edges: [
                planes(|lane| corner(after[lane] + count - 1)),
                planes(|lane| corner(after[lane])),
            ],
        }
    }
}

/// The cosines and sines of angles in degrees.
fn directions(degrees: [f64; LANES]) -> [[f64; LANES]; 2] {
    [
        degrees.map(|angle| libm::cos(angle.to_radians())),
        degrees.map(|angle| libm::sin(angle.to_radians())),
    ]
}

impl Kernel for Sixteen<'_> {
    type Output = Found;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Found {
        let hue = [
            F64x16::load(simd, &self.hues[0]),
            F64x16::load(simd, &self.hues[1]),
        ];
        let cusp = self.cusps(simd, hue);
        Found {
            reach: self.reaches(simd).to_array(),
            lightness: cusp[0].to_array(),
            colorfulness: cusp[1].to_array(),
            upper_hull: self.upper_hulls(simd, hue, cusp).to_array(),
        }
    }
}

impl Sixteen<'_> {
    /// The least M at the peak's J of which a channel of AP1 is negative.
    #[inline(always)]
    fn reaches<S: Simd>(&self, simd: S) -> F64x16<S> {
        let zero = F64x16::splat(simd, 0.0);
        let achromatic = F64x16::splat(simd, self.source.limits.achromatic);
        let cosine = F64x16::load(simd, &self.degrees[0]);
        let sine = F64x16::load(simd, &self.degrees[1]);
        let [_, reach] = REACH.run(
            simd,
            #[inline(always)]
            |m| {
                let opponent = [achromatic, m * cosine, m * sine];
                let [r, g, b] = self.source.reach.rgb(simd, opponent);
                r.lt(zero) | g.lt(zero) | b.lt(zero)
            },
        );
        reach
    }

    /// J and M of the cusps: along an edge of the cube, until the hue is met.
    #[inline(always)]
    fn cusps<S: Simd>(&self, simd: S, [cosine, sine]: [F64x16<S>; 2]) -> [F64x16<S>; 2] {
        let [before, after] = EDGE.run(
            simd,
            #[inline(always)]
            |t| {
                let [_, a, b] = self.on_edge(simd, t);
                // An edge is less than half a circle, so that the sine of the angle between says which is first.
                (b * cosine - a * sine).is_positive()
            },
        );
        let [achromatic, a, b] = self.on_edge(simd, (before + after) * 0.5);
        [
            power(simd, achromatic, self.source.limits.exponent) * LIGHTNESS,
            (a * a + b * b).sqrt() * CUSP_MARGIN,
        ]
    }

    /// A, a and b on the edges, whose ends are 0 and 1.
    #[inline(always)]
    fn on_edge<S: Simd>(&self, simd: S, t: F64x16<S>) -> Rgb<S> {
        let from = load(simd, &self.edges[0]);
        let to = load(simd, &self.edges[1]);
        let rgb = [
            from[0] + (to[0] - from[0]) * t,
            from[1] + (to[1] - from[1]) * t,
            from[2] + (to[2] - from[2]) * t,
        ];
        self.source.limiting.opponent(simd, rgb)
    }

    /// 1/γ of the upper hulls: the least γ with which no tested point of the hull is inside of the gamut.
    #[inline(always)]
    fn upper_hulls<S: Simd>(
        &self,
        simd: S,
        hue: [F64x16<S>; 2],
        cusp: [F64x16<S>; 2],
    ) -> F64x16<S> {
        let one = F64x16::splat(simd, 1.0);
        let lines = [
            self.tested_line(simd, cusp, HULL_TESTS[0]),
            self.tested_line(simd, cusp, HULL_TESTS[1]),
            self.tested_line(simd, cusp, HULL_TESTS[2]),
            self.tested_line(simd, cusp, HULL_TESTS[3]),
            self.tested_line(simd, cusp, HULL_TESTS[4]),
        ];
        let [_, gamma] = GAMMA.run(
            simd,
            #[inline(always)]
            |gamma| {
                let gamut = Gamut {
                    cusp,
                    upper_hull: one / gamma,
                };
                let mut all = self.is_outside(simd, hue, &gamut, &lines[0]);
                for line in &lines[1..] {
                    all = all & self.is_outside(simd, hue, &gamut, line);
                }
                all
            },
        );
        one / gamma
    }

    /// The line through the cusp's M at some part of the way from its J to the peak's.
    #[inline(always)]
    fn tested_line<S: Simd>(&self, simd: S, cusp: [F64x16<S>; 2], position: f64) -> Line<S> {
        let to_peak = -cusp[0] + self.source.limits.lightness;
        let tested = [cusp[0] + to_peak * position, cusp[1]];
        self.source.compression.line(simd, cusp, tested)
    }

    /// Whether a channel is brighter than the peak where a line meets the hull.
    #[inline(always)]
    fn is_outside<S: Simd>(
        &self,
        simd: S,
        [cosine, sine]: [F64x16<S>; 2],
        gamut: &Gamut<S>,
        line: &Line<S>,
    ) -> Mask64x16<S> {
        let m = self.source.compression.boundary(simd, gamut, line);
        let part = line.lightness(m) * (1.0 / LIGHTNESS);
        let achromatic = power(simd, part, self.source.limits.per_exponent);
        let opponent = [achromatic, m * cosine, m * sine];
        let [r, g, b] = self.source.limiting.rgb(simd, opponent);
        let peak = F64x16::splat(simd, self.source.peak);
        r.gt(peak) | g.gt(peak) | b.gt(peak)
    }
}
