//! The integrals by brute force: over the area of a part of a plane, row by row, by adaptive Gauss–Kronrod
//! quadrature with its own estimate of its error. Nothing of this is shared with what it tests.

use crate::math::DVec3;

/// Points, weights, and weights of the rule of seven among them (QUADPACK, qk15).
const KRONROD: [[f64; 3]; 8] = [
    [0.991_455_371_120_812_6, 0.022_935_322_010_529_22, 0.0],
    [
        0.949_107_912_342_758_5,
        0.063_092_092_629_978_55,
        0.129_484_966_168_869_7,
    ],
    [0.864_864_423_359_769_1, 0.104_790_010_322_250_18, 0.0],
    [
        0.741_531_185_599_394_4,
        0.140_653_259_715_525_92,
        0.279_705_391_489_276_64,
    ],
    [0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0],
    [
        0.405_845_151_377_397_2,
        0.190_350_578_064_785_4,
        0.381_830_050_505_118_9,
    ],
    [0.207_784_955_007_898_47, 0.204_432_940_075_298_89, 0.0],
    [0.0, 0.209_482_141_084_727_82, 0.417_959_183_673_469_4],
];

/// Of a value, what rounding may be: halving does not help below it.
const ROUNDING: f64 = 3e-13;

/// A value, and how far it may be off.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    pub(super) value: f64,
    pub(super) error: f64,
}

fn adaptive(
    f: &mut impl FnMut(f64) -> f64,
    [from, to]: [f64; 2],
    tolerance: f64,
    depth: u32,
) -> Estimate {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let (mut value, mut coarse) = (0.0, 0.0);
    for [x, weight, other] in KRONROD {
        let both = if x == 0.0 {
            f(middle)
        } else {
            f(middle - half * x) + f(middle + half * x)
        };
        value += weight * both;
        coarse += other * both;
    }
    let error = half * (value - coarse).abs();
    if error <= tolerance.max(ROUNDING * half * value.abs()) || depth == 0 {
        let value = half * value;
        return Estimate { value, error };
    }
    let left = adaptive(f, [from, middle], tolerance * 0.6, depth - 1);
    let right = adaptive(f, [middle, to], tolerance * 0.6, depth - 1);
    Estimate {
        value: left.value + right.value,
        error: left.error + right.error,
    }
}

/// From one place to the next.
fn piecewise(mut f: impl FnMut(f64) -> f64, places: &mut [f64], tolerance: f64) -> Estimate {
    places.sort_unstable_by(f64::total_cmp);
    let mut sum = Estimate {
        value: 0.0,
        error: 0.0,
    };
    for pair in places.windows(2).filter(|pair| pair[1] > pair[0]) {
        let part = adaptive(&mut f, [pair[0], pair[1]], tolerance, 40);
        sum.value += part.value;
        sum.error += part.error;
    }
    sum
}

/// A part of a plane: corners, or a disk around the middle.
pub(super) enum Flat {
    Corners(Vec<[f64; 2]>),
    Disk(f64),
}

/// A convex part of a plane, seen from the origin, and what cuts it.
pub(super) struct Region {
    middle: DVec3,
    axes: [DVec3; 2],
    flat: Flat,
    /// It is where all h · x ≥ 0.
    half_spaces: Vec<DVec3>,
}

/// Two vectors across a third.
pub(super) fn axes_across(normal: DVec3) -> [DVec3; 2] {
    let other = if normal.x.abs() < 0.6 * normal.length() {
        DVec3::X
    } else {
        DVec3::Y
    };
    let first = normal.cross(other).normalize();
    [first, normal.cross(first).normalize()]
}

impl Region {
    pub(super) fn polygon(corners: &[DVec3]) -> Self {
        let middle = corners[0];
        let x = (corners[1] - middle).normalize();
        let normal = (corners[1] - middle).cross(corners[2] - middle);
        let axes = [x, normal.cross(x).normalize()];
        let flat = corners
            .iter()
            .map(|&corner| axes.map(|axis| axis.dot(corner - middle)));
        Self {
            middle,
            axes,
            flat: Flat::Corners(flat.collect()),
            half_spaces: Vec::new(),
        }
    }

    pub(super) fn disk(middle: DVec3, normal: DVec3, radius: f64) -> Self {
        Self {
            middle,
            axes: axes_across(normal),
            flat: Flat::Disk(radius),
            half_spaces: Vec::new(),
        }
    }

    /// What is seen of a sphere is the disk within its outline.
    pub(super) fn sphere(center: DVec3, radius: f64) -> Self {
        let d = center.length();
        let middle = center * (1.0 - (radius / d).powi(2));
        let rim = radius * (1.0 - (radius / d).powi(2)).sqrt();
        Self::disk(middle, center / d, rim)
    }

    pub(super) fn cut(mut self, half_space: DVec3) -> Self {
        self.half_spaces.push(half_space);
        self
    }

    /// From where to where a row is inside.
    fn row(&self, y: f64) -> [f64; 2] {
        let [mut from, mut to] = [f64::INFINITY, f64::NEG_INFINITY];
        match &self.flat {
            Flat::Disk(radius) => {
                let half = ((radius - y) * (radius + y)).max(0.0).sqrt();
                [from, to] = [-half, half];
            }
            Flat::Corners(corners) => {
                for (place, &[x0, y0]) in corners.iter().enumerate() {
                    let [x1, y1] = corners[(place + 1) % corners.len()];
                    if (y0 - y) * (y1 - y) <= 0.0 && y0 != y1 {
                        let x = x0 + (x1 - x0) * ((y - y0) / (y1 - y0));
                        [from, to] = [from.min(x), to.max(x)];
                    }
                }
            }
        }
        let row = self.middle + self.axes[1] * y;
        for half_space in &self.half_spaces {
            let (height, slope) = (half_space.dot(row), half_space.dot(self.axes[0]));
            if slope > 0.0 {
                from = from.max(-height / slope);
            } else if slope < 0.0 {
                to = to.min(-height / slope);
            } else if height < 0.0 {
                return [0.0, 0.0];
            }
        }
        [from, to]
    }

    /// Rows at which it begins, ends, or has a corner.
    fn rows(&self) -> Vec<f64> {
        let mut lines: Vec<[f64; 3]> = Vec::new();
        let mut rows = match &self.flat {
            Flat::Disk(radius) => vec![-radius, *radius],
            Flat::Corners(corners) => {
                for (place, &[x0, y0]) in corners.iter().enumerate() {
                    let [x1, y1] = corners[(place + 1) % corners.len()];
                    let [nx, ny] = [y1 - y0, x0 - x1];
                    lines.push([nx, ny, -nx * x0 - ny * y0]);
                }
                corners.iter().map(|corner| corner[1]).collect()
            }
        };
        for h in &self.half_spaces {
            let line = [h.dot(self.axes[0]), h.dot(self.axes[1]), h.dot(self.middle)];
            if let Flat::Disk(radius) = self.flat {
                let square = line[0] * line[0] + line[1] * line[1];
                let rest = radius * radius - line[2] * line[2] / square;
                if rest > 0.0 {
                    let step = line[0] * (rest / square).sqrt();
                    let foot = -line[1] * line[2] / square;
                    rows.extend([foot - step, foot + step]);
                }
            }
            lines.push(line);
        }
        for (place, a) in lines.iter().enumerate() {
            for b in &lines[..place] {
                let determinant = a[0] * b[1] - a[1] * b[0];
                if determinant != 0.0 {
                    rows.push((a[2] * b[0] - a[0] * b[2]) / determinant);
                }
            }
        }
        let ends = match &self.flat {
            Flat::Disk(radius) => [-radius, *radius],
            Flat::Corners(corners) => corners.iter().fold(
                [f64::INFINITY, f64::NEG_INFINITY],
                |[least, most], corner| [least.min(corner[1]), most.max(corner[1])],
            ),
        };
        rows.retain(|row| (ends[0]..=ends[1]).contains(row));
        rows
    }

    /// ∫ f dω, where f is largest at `peak`, over some `width` in radians.
    pub(super) fn integral(
        &self,
        f: impl Fn(DVec3) -> f64,
        peak: DVec3,
        width: f64,
        tolerance: f64,
    ) -> Estimate {
        let normal = self.axes[0].cross(self.axes[1]);
        let height = normal.dot(self.middle);
        let at = peak * (height / normal.dot(peak));
        let is_met = at.is_finite() && at.dot(peak) > 0.0;
        let [px, py] = self.axes.map(|axis| axis.dot(at - self.middle));
        let steps: Vec<f64> = (0..12)
            .map(|power| width * at.length() * 4.0_f64.powi(power))
            .chain([0.0])
            .collect();
        let around = |place: f64, within: [f64; 2], places: &mut Vec<f64>| {
            if is_met {
                let near = steps.iter().flat_map(|step| [place - step, place + step]);
                places.extend(near.filter(|near| within[0] < *near && *near < within[1]));
            }
        };
        let mut rows = self.rows();
        let least = rows.iter().copied().fold(f64::INFINITY, f64::min);
        let most = rows.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        around(py, [least, most], &mut rows);
        // Rows of a disk end as a root does; by its angle they do not.
        let radius = match self.flat {
            Flat::Disk(radius) => Some(radius),
            Flat::Corners(_) => None,
        };
        if let Some(radius) = radius {
            for row in &mut rows {
                *row = (*row / radius).clamp(-1.0, 1.0).asin();
            }
        }
        let mut inner_error = 0.0_f64;
        let row_integral = |place: f64| {
            let (y, slope) = match radius {
                Some(radius) => (radius * place.sin(), radius * place.cos()),
                None => (place, 1.0),
            };
            let [from, to] = self.row(y);
            if from >= to {
                return 0.0;
            }
            let mut places = vec![from, to];
            around(px, [from, to], &mut places);
            let along = |x: f64| {
                let place = self.middle + self.axes[0] * x + self.axes[1] * y;
                let length = place.length();
                f(place / length) * height.abs() / length.powi(3)
            };
            let part = piecewise(along, &mut places, tolerance / (most - least) * 0.05);
            inner_error = inner_error.max(part.error);
            slope * part.value
        };
        let mut sum = piecewise(row_integral, &mut rows, tolerance * 0.05);
        sum.error += inner_error * (most - least);
        sum
    }

    /// Φ(n)
    pub(super) fn irradiance(self, n: DVec3, tolerance: f64) -> Estimate {
        let region = self.cut(n);
        region.integral(|u| n.dot(u).max(0.0), n, 1.0, tolerance)
    }

    /// ∫ max(0, w·u)ⁿ (v·u) dω, or without v·u.
    pub(super) fn lobe(self, w: DVec3, v: Option<DVec3>, n: f64, tolerance: f64) -> Estimate {
        let region = self.cut(w);
        let f = |u: DVec3| {
            let lobe = if n == 0.0 {
                1.0
            } else {
                let cosine = w.dot(u);
                let power = if cosine > 0.9 {
                    0.5 * n * (-w.cross(u).length_squared()).ln_1p()
                } else {
                    n * cosine.max(0.0).ln()
                };
                power.exp()
            };
            v.map_or(lobe, |v| lobe * v.dot(u))
        };
        region.integral(f, w, 1.0 / (n + 1.0).sqrt(), tolerance)
    }
}

#[test]
fn it_knows_polynomials_and_known_integrals() {
    let power = adaptive(&mut |x| x.powi(22), [-1.0, 1.0], f64::INFINITY, 0);
    assert!((power.value - 2.0 / 23.0).abs() < 1e-15);
    let coarse = adaptive(
        &mut |x| x.powi(13) + x.powi(12),
        [0.0, 1.0],
        f64::INFINITY,
        0,
    );
    assert!(coarse.error < 1e-15);
    // π sin²α, and 2π (1 − cosᵏ⁺¹ α)/(k + 1), over a cap.
    let cap = || Region::disk(DVec3::Z, DVec3::Z, 0.75);
    let irradiance = cap().irradiance(DVec3::Z, 1e-12);
    assert!((irradiance.value - std::f64::consts::PI * 0.36).abs() < 1e-12);
    assert!(irradiance.error < 1e-12);
    let lobe = cap().lobe(DVec3::Z, None, 99.0, 1e-12).value;
    let expected = std::f64::consts::TAU * (1.0 - 0.8_f64.powi(100)) / 100.0;
    assert!((lobe - expected).abs() < 1e-12);
}
