//! Curves on the plane of a light: where surfaces that hide it begin and end there, and where the light itself does.
//!
//! All are of degree 1 or 2 in the row and in the place on its line.

use super::super::vector::{Vector, dot, scale, subtract};
use super::polynomial::{quadratic, roots, sum_of_products};
use super::view::View;

/// Where a function is 0.
#[derive(Clone, Copy, Debug)]
pub(super) enum Curve {
    /// c₀ + c₁ row + c₂ s
    Straight([f64; 3]),
    /// a s² + 2 (b₀ + b₁ row) s + c₀ + c₁ row + c₂ row²
    Conic {
        square: f64,
        mixed: [f64; 2],
        rest: [f64; 3],
    },
}

/// A vector, and how much of the origin of the light it has: 1 is a point, 0 a way.
type Form = (Vector, f64);

impl Curve {
    /// Where n·d is `offset`.
    pub(super) fn straight(view: &View, normal: Vector, offset: f64) -> Self {
        Self::Straight([
            dot(normal, view.middle) - offset,
            dot(normal, view.across),
            dot(normal, view.along),
        ])
    }

    /// Where a quadratic form of the point is 0.
    fn conic(view: &View, form: impl Fn(Form, Form) -> f64) -> Self {
        let [middle, across, along] = [(view.middle, 1.0), (view.across, 0.0), (view.along, 0.0)];
        let square = form(along, along);
        let mixed = [form(along, middle), form(along, across)];
        let rest = [
            form(middle, middle),
            2.0 * form(middle, across),
            form(across, across),
        ];
        let all = mixed.into_iter().chain(rest);
        let size = all.fold(square.abs(), |size, c| size.max(c.abs()));
        Self::Conic {
            square: square / size,
            mixed: mixed.map(|c| c / size),
            rest: rest.map(|c| c / size),
        }
    }

    /// Where directions pass a circle: what a plane at `offset` has in common with a sphere.
    pub(super) fn circle(
        view: &View,
        (normal, offset): (Vector, f64),
        (center, radius): (Vector, f64),
    ) -> Self {
        // ‖offset d − (n·d) c‖² = R² (n·d)²
        let part = |d: Vector| {
            let along = dot(normal, d);
            (
                subtract(scale(d, offset), scale(center, along)),
                radius * along,
            )
        };
        Self::conic(view, |(a, _), (b, _)| {
            let ((a, of_a), (b, of_b)) = (part(a), part(b));
            dot(a, b) - of_a * of_b
        })
    }

    /// Where directions touch a sphere: (d·c)² = ‖d‖² power.
    pub(super) fn cone(view: &View, center: Vector, power: f64) -> Self {
        Self::conic(view, |(a, _), (b, _)| {
            dot(a, center) * dot(b, center) - power * dot(a, b)
        })
    }

    /// Where the plane of the light passes a sphere.
    pub(super) fn sphere(view: &View, center: Vector, radius: f64) -> Self {
        Self::conic(view, |(a, of_a), (b, of_b)| {
            let from = |way: Vector, of: f64| subtract(way, scale(center, of));
            dot(from(a, of_a), from(b, of_b)) - radius * radius * of_a * of_b
        })
    }

    /// Where the light ends.
    pub(super) fn outline(view: &View, horizon: Vector) -> Vec<Self> {
        let mut curves = if view.is_round {
            vec![Self::Conic {
                square: 1.0,
                mixed: [0.0; 2],
                rest: [-1.0, 0.0, 1.0],
            }]
        } else {
            vec![
                Self::Straight([-1.0, 0.0, 1.0]),
                Self::Straight([1.0, 0.0, 1.0]),
            ]
        };
        curves.push(Self::straight(view, horizon, 0.0));
        curves
    }

    /// Where it is on a line, at most twice; not a number where it is not.
    pub(super) fn on(&self, row: f64) -> [f64; 2] {
        match *self {
            Self::Straight([constant, by_row, by_s]) => {
                [-(constant + by_row * row) / by_s, f64::NAN]
            }
            Self::Conic {
                square,
                mixed: [b0, b1],
                rest: [c0, c1, c2],
            } => quadratic(square, b0 + b1 * row, c0 + (c1 + c2 * row) * row),
        }
    }

    /// The points of the first and the last row that it is in.
    pub(super) fn turns(&self) -> [[f64; 2]; 2] {
        let Self::Conic {
            square,
            mixed: [b0, b1],
            rest: [c0, c1, c2],
        } = *self
        else {
            return [[f64::NAN; 2]; 2];
        };
        let rows = quadratic(
            b1 * b1 - square * c2,
            b0 * b1 - 0.5 * square * c1,
            b0 * b0 - square * c0,
        );
        rows.map(|row| [row, -(b0 + b1 * row) / square])
    }

    /// The points that it has in common with another: the row and the place on its line. That is not a number where
    /// only rows are known.
    pub(super) fn crossings(&self, other: &Self, mut found: impl FnMut([f64; 2])) {
        match (self, other) {
            (Self::Straight(a), Self::Straight(b)) => {
                let determinant = a[1] * b[2] - a[2] * b[1];
                found([
                    (a[2] * b[0] - a[0] * b[2]) / determinant,
                    (a[0] * b[1] - a[1] * b[0]) / determinant,
                ]);
            }
            (Self::Straight(line), conic) | (conic, Self::Straight(line)) => {
                let Self::Conic {
                    square,
                    mixed: [b0, b1],
                    rest: [c0, c1, c2],
                } = *conic
                else {
                    return;
                };
                let [constant, by_row, by_s] = *line;
                if by_s.abs() >= by_row.abs() {
                    // s = m + k row
                    let (m, k) = (-constant / by_s, -by_row / by_s);
                    for row in quadratic(
                        square * k * k + 2.0 * b1 * k + c2,
                        square * m * k + b0 * k + b1 * m + 0.5 * c1,
                        square * m * m + 2.0 * b0 * m + c0,
                    ) {
                        found([row, m + k * row]);
                    }
                } else {
                    // row = m + k s
                    let (m, k) = (-constant / by_row, -by_s / by_row);
                    for s in quadratic(
                        square + 2.0 * b1 * k + c2 * k * k,
                        b0 + b1 * m + 0.5 * c1 * k + c2 * m * k,
                        c0 + (c1 + c2 * m) * m,
                    ) {
                        found([m + k * s, s]);
                    }
                }
            }
            (
                Self::Conic {
                    square: a,
                    mixed: b,
                    rest: c,
                },
                Self::Conic {
                    square: a2,
                    mixed: b2,
                    rest: c2,
                },
            ) => {
                // The resultant of both for s.
                let squares: [f64; 3] = std::array::from_fn(|i| a * c2[i] - a2 * c[i]);
                let mixed: [f64; 2] = std::array::from_fn(|i| a * b2[i] - a2 * b[i]);
                let mut rest = [0.0; 4];
                sum_of_products(b, c2, 1.0, &mut rest);
                sum_of_products(b2, c, -1.0, &mut rest);
                let mut resultant = [0.0; 5];
                sum_of_products(&squares, &squares, 1.0, &mut resultant);
                sum_of_products(&mixed, &rest, -4.0, &mut resultant);
                for row in roots(&resultant, [-1.0, 1.0]) {
                    found([row, f64::NAN]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (s − x)² / w² + (row − y)² / h² + t (s − x) (row − y) = 1
    fn ellipse([x, y]: [f64; 2], [w, h]: [f64; 2], t: f64) -> Curve {
        let (p, q) = (1.0 / (w * w), 1.0 / (h * h));
        Curve::Conic {
            square: p,
            mixed: [0.5 * -t * y - p * x, 0.5 * t],
            rest: [
                p * x * x + q * y * y + t * x * y - 1.0,
                -2.0 * q * y - t * x,
                q,
            ],
        }
    }

    fn value(curve: &Curve, [row, s]: [f64; 2]) -> f64 {
        match *curve {
            Curve::Straight([constant, by_row, by_s]) => constant + by_row * row + by_s * s,
            Curve::Conic {
                square,
                mixed: [b0, b1],
                rest: [c0, c1, c2],
            } => square * s * s + 2.0 * (b0 + b1 * row) * s + c0 + (c1 + c2 * row) * row,
        }
    }

    #[test]
    fn points_are_on_both_curves() {
        let curves = [
            Curve::Straight([0.1, 0.7, -1.0]),
            Curve::Straight([0.05, -0.9, 0.2]),
            ellipse([0.0; 2], [1.0; 2], 0.0),
            ellipse([0.1, -0.2], [0.5, 0.7], 0.0),
            ellipse([-0.2, 0.1], [0.7, 0.4], 0.9),
        ];
        let mut count = 0;
        for (i, a) in curves.iter().enumerate() {
            for [row, s] in a.turns().into_iter().filter(|turn| turn[0].is_finite()) {
                assert!(value(a, [row, s]).abs() < 1e-14);
                assert!((a.on(row - 1e-6 * row.signum())[0] - s).abs() < 1e-2);
            }
            for b in &curves[i + 1..] {
                a.crossings(b, |[row, s]| {
                    let places = if s.is_nan() {
                        a.on(row).to_vec()
                    } else {
                        vec![s]
                    };
                    let off = |s: f64| value(a, [row, s]).abs().max(value(b, [row, s]).abs());
                    let least = places.into_iter().map(off).fold(f64::INFINITY, f64::min);
                    if row.is_finite() {
                        assert!(least < 1e-12, "{a:?} {b:?}: {row}, {least:e}");
                        count += 1;
                    }
                });
            }
        }
        // Each line crosses each of the ellipses twice; the circle holds the two others, which cross each other.
        assert!(count >= 15, "{count}");
    }
}
