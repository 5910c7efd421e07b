//! The light of a luminaire, from the table of its IES file.

use std::sync::Arc;

use super::vector::{Vector, cross, dot, length, scale, subtract, unit};
use crate::ies::{Coordinates, IesFile, Symmetry};
use crate::scene::Aim;

/// Nodes and weights of Gauss's rule of five points from −1 to 1 (Abramowitz & Stegun 25.4.30): exact for
/// polynomials of degree 9. Of a cell that is 5° wide the sine is one to the last digits.
const NODES: [[f64; 2]; 5] = [
    [-0.906_179_845_938_664, 0.236_926_885_056_189_08],
    [-0.538_469_310_105_683_1, 0.478_628_670_499_366_47],
    [0.0, 0.568_888_888_888_888_9],
    [0.538_469_310_105_683_1, 0.478_628_670_499_366_47],
    [0.906_179_845_938_664, 0.236_926_885_056_189_08],
];

/// Parts that a cell is integrated in, for tables with wide cells.
const PARTS: u32 = 64;

/// A luminaire as it hangs.
#[derive(Clone, Debug)]
pub(super) struct Luminaire {
    /// Towards vertical angle 0.
    axis: Vector,
    /// Towards horizontal angle 0, and 90: counter-clockwise seen against the light.
    up: Vector,
    side: Vector,
    file: Arc<IesFile>,
    /// The largest intensity of the table, in cd.
    peak: f64,
}

impl Luminaire {
    pub(super) fn new(
        position: [f64; 3],
        aim: &Aim,
        up: Option<[f64; 3]>,
        file: &Arc<IesFile>,
    ) -> Self {
        let axis = match aim {
            Aim::Direction(direction) => direction.value,
            Aim::LookAt(point) => subtract(point.value, position),
        };
        let axis = unit(axis).expect("a legal luminaire points somewhere");
        // An `up` of nobody, or along the axis, is y, or −z along that.
        let is_across = |up: &Vector| length(cross(axis, *up)) > 1e-6;
        let up = up.map(|up| unit(up).expect("a legal `up` is a direction"));
        let up = up.into_iter().chain([[0.0, 1.0, 0.0]]).find(is_across);
        let up = up.unwrap_or([0.0, 0.0, -1.0]);
        let across = subtract(up, scale(axis, dot(up, axis)));
        let up = unit(across).expect("a legal `up` is across");
        let side = cross(axis, up);
        let (vertical, horizontal) = file.photometry.angles();
        let mut peak = 0.0_f64;
        for h in 0..horizontal.len() {
            for v in 0..vertical.len() {
                peak = peak.max(file.photometry.value(v, h).unwrap_or(0.0));
            }
        }
        Self {
            axis,
            up,
            side,
            file: Arc::clone(file),
            peak,
        }
    }

    /// Vertical and horizontal angle of the way from the luminaire, in degrees.
    pub(super) fn angles(&self, way: Vector) -> [f64; 2] {
        let (x, y, z) = (dot(way, self.up), dot(way, self.side), dot(way, self.axis));
        let [vertical, horizontal] = match self.file.photometry.coordinates() {
            Coordinates::C => [x.hypot(y).atan2(z), y.atan2(x)],
            Coordinates::B => [x.atan2(z), (-y).atan2(x.hypot(z))],
            Coordinates::A => [x.atan2(y.hypot(z)), (-y).atan2(z)],
        };
        [vertical.to_degrees(), horizontal.to_degrees()]
    }

    /// The intensity at these angles over the largest: bilinear between the angles of the table, 0 outside of it.
    pub(super) fn factor(&self, [vertical, horizontal]: [f64; 2]) -> f64 {
        let (rows, columns) = self.file.photometry.angles();
        let first = columns[0];
        let is_c = self.file.photometry.coordinates() == Coordinates::C;
        let turn = horizontal.rem_euclid(360.0);
        let from_first = turn.min(360.0 - turn);
        let horizontal = match (self.file.photometry.symmetry(), is_c) {
            (Symmetry::Axial, _) => first,
            (Symmetry::Quadrants, _) => from_first.min(180.0 - from_first),
            (Symmetry::Mirrored, true) => from_first,
            (Symmetry::Mirrored, false) => horizontal.abs(),
            (Symmetry::MirroredAcross, _) if turn < 90.0 => 180.0 - turn,
            (Symmetry::MirroredAcross, _) if turn > 270.0 => 540.0 - turn,
            (Symmetry::MirroredAcross, _) => turn,
            (Symmetry::None, true) if turn < first => turn + 360.0,
            (Symmetry::None, true) => turn,
            (Symmetry::None, false) => horizontal,
        };
        let hats = |angles: &[f64], at: f64| -> Vec<(usize, f64)> {
            if angles.len() == 1 {
                return vec![(0, 1.0)];
            }
            let pair = (1..angles.len()).find(|&i| angles[i - 1] <= at && at <= angles[i]);
            pair.map_or_else(Vec::new, |i| {
                let part = (at - angles[i - 1]) / (angles[i] - angles[i - 1]);
                vec![(i - 1, 1.0 - part), (i, part)]
            })
        };
        let mut candela = 0.0;
        for (h, in_column) in hats(columns, horizontal) {
            for (v, in_row) in hats(rows, vertical) {
                candela += in_column * in_row * self.file.photometry.value(v, h).unwrap_or(0.0);
            }
        }
        candela / self.peak
    }

    /// ∫ f dω in sr: how much flux it has for 1 cd into the brightest direction, in lm.
    pub(super) fn flux(&self) -> f64 {
        let photometry = &self.file.photometry;
        let (rows, columns) = photometry.angles();
        let value = |v: usize, h: usize| photometry.value(v, h).unwrap_or(0.0);
        let images = match photometry.symmetry() {
            Symmetry::Axial | Symmetry::None => 1.0,
            Symmetry::Quadrants => 4.0,
            Symmetry::Mirrored | Symmetry::MirroredAcross => 2.0,
        };
        // Solid angle per angle times angle: by the angle from the poles.
        let density = |vertical: f64, horizontal: f64| match photometry.coordinates() {
            Coordinates::C => vertical.to_radians().sin(),
            Coordinates::B => horizontal.to_radians().cos(),
            Coordinates::A => vertical.to_radians().cos(),
        };
        let mut sum = 0.0;
        let mut cell =
            |[v0, v1]: [f64; 2], [h0, h1]: [f64; 2], corner: &dyn Fn(f64, f64) -> f64| {
                for part in 0..PARTS {
                    let at = |node: f64| (f64::from(part) + 0.5 * (node + 1.0)) / f64::from(PARTS);
                    for [node, weight] in NODES {
                        for [other, of_other] in NODES {
                            // The parts are along the angle from the poles; the other one is linear.
                            let (s, t) = if photometry.coordinates() == Coordinates::B {
                                (0.5 * (other + 1.0), at(node))
                            } else {
                                (at(node), 0.5 * (other + 1.0))
                            };
                            let (v, h) = (v0 + (v1 - v0) * s, h0 + (h1 - h0) * t);
                            let area = (v1 - v0).to_radians() * (h1 - h0).to_radians();
                            let share = weight * of_other / 4.0 / f64::from(PARTS);
                            sum += corner(s, t) * density(v, h) * area * share;
                        }
                    }
                }
            };
        for v in 1..rows.len() {
            let row = [rows[v - 1], rows[v]];
            if columns.len() == 1 {
                cell(row, [0.0, 360.0], &|s, _| {
                    value(v - 1, 0) * (1.0 - s) + value(v, 0) * s
                });
            }
            for h in 1..columns.len() {
                cell(row, [columns[h - 1], columns[h]], &|s, t| {
                    let column = |h| value(v - 1, h) * (1.0 - s) + value(v, h) * s;
                    column(h - 1) * (1.0 - t) + column(h) * t
                });
            }
        }
        sum * images / self.peak
    }
}
