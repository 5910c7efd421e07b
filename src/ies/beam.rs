//! What data sheets say of a distribution: peak, beam and field angle, polar curves.

use super::coordinates::{Angles, Coordinates, sincos};
use super::photometry::Photometry;
use crate::math::DVec3;

/// The largest intensity, and where it goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// In cd.
    pub candela: f64,
    /// Those of the table.
    pub angles: Angles,
    /// Of unit length, in the lamp's frame. The first in the file where there are several.
    pub direction: DVec3,
}

/// How wide a distribution is in two planes through the axis, in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Widths {
    /// In the plane of axis and up (C0–C180). `None` where it is dark.
    pub plane_0: Option<f64>,
    /// In the plane across (C90–C270). `None` where it is dark.
    pub plane_90: Option<f64>,
}

/// The part of the largest intensity at which the beam ends (IES RP-16, beam angle).
const BEAM: f64 = 0.5;

/// The part of the largest intensity at which the field ends (IES RP-16, field angle).
const FIELD: f64 = 0.1;

impl Photometry {
    /// The largest intensity of the table, which is the largest of all directions.
    pub fn peak(&self) -> Peak {
        let (vertical, horizontal) = self.angles();
        let mut peak = (f64::NEG_INFINITY, 0, 0);
        for h in 0..horizontal.len() {
            for (v, &value) in self.plane(h).iter().enumerate() {
                if value > peak.0 {
                    peak = (value, v, h);
                }
            }
        }
        let (candela, v, h) = peak;
        let at = |list: &[f64], i: usize| list.get(i).copied().unwrap_or_default();
        let angles = Angles {
            vertical: at(vertical, v),
            horizontal: at(horizontal, h),
        };
        Peak {
            candela: candela.max(0.0),
            angles,
            direction: self.coordinates().direction(angles),
        }
    }

    /// The beam angle: of each plane the angle between the outermost two directions with 50 % of the largest
    /// intensity *in this plane* (not of that on the axis). A dip within does not end it.
    pub fn beam_angle(&self) -> Widths {
        self.widths(BEAM)
    }

    /// The field angle: as [`Photometry::beam_angle`], at 10 %.
    pub fn field_angle(&self) -> Widths {
        self.widths(FIELD)
    }

    /// The curve of a polar diagram: `count` pairs of an angle from the axis and the intensity there, in a plane
    /// through the axis. Angles are evenly spaced from −180 to 180 degrees, positive on the side of `plane`,
    /// which is counted in degrees from up as type C counts, and negative on the other side.
    pub fn polar_curve(&self, plane: f64, count: usize) -> Vec<(f64, f64)> {
        let steps = count.saturating_sub(1).max(1) as f64;
        let angle = |i: usize| -180.0 + 360.0 * (i as f64 / steps);
        let curve = (0..count).map(|i| (angle(i), self.in_plane(plane, angle(i))));
        curve.collect()
    }

    /// The angles of a direction in a plane through the axis.
    fn angles_in_plane(&self, plane: f64, from_axis: f64) -> Angles {
        let around = if from_axis < 0.0 {
            plane + 180.0
        } else {
            plane
        };
        let angles = Angles {
            vertical: from_axis.abs(),
            horizontal: around,
        };
        let lying = |vertical, horizontal| Angles {
            vertical,
            horizontal,
        };
        match self.coordinates() {
            Coordinates::C => angles,
            // The two planes in which the angles are those of the table, to the last digit.
            Coordinates::B if plane == 0.0 => lying(from_axis, 0.0),
            Coordinates::A if plane == 90.0 => lying(0.0, -from_axis),
            Coordinates::B if plane == 90.0 && from_axis.abs() <= 90.0 => lying(0.0, -from_axis),
            Coordinates::A if plane == 0.0 && from_axis.abs() <= 90.0 => lying(from_axis, 0.0),
            coordinates @ (Coordinates::A | Coordinates::B) => {
                let (sin, cos) = sincos(from_axis);
                let (sin_around, cos_around) = sincos(plane);
                coordinates.angles(DVec3::new(sin * cos_around, sin * sin_around, cos))
            }
        }
    }

    fn in_plane(&self, plane: f64, from_axis: f64) -> f64 {
        self.at(self.angles_in_plane(plane, from_axis))
    }

    fn widths(&self, part: f64) -> Widths {
        Widths {
            plane_0: self.width(0.0, part),
            plane_90: self.width(90.0, part),
        }
    }

    /// Angles from the axis, −180 to 180 and ascending, between which the curve of plane 0 or 90 is straight.
    fn kinks(&self, plane: f64) -> Vec<f64> {
        let (vertical, horizontal) = self.angles();
        let list = match self.coordinates() {
            Coordinates::C => vertical,
            Coordinates::A | Coordinates::B if plane == 0.0 => vertical,
            Coordinates::A | Coordinates::B => horizontal,
        };
        // On the far side types A and B count from ±180 back.
        let images = |&angle: &f64| [angle, -angle, 180.0 - angle, angle - 180.0];
        let images = list.iter().flat_map(images);
        let mut kinks: Vec<f64> = images.chain([-180.0, 0.0, 180.0]).collect();
        kinks.retain(|angle| angle.abs() <= 180.0);
        kinks.sort_by(f64::total_cmp);
        kinks.dedup_by(|a, b| *a == *b);
        kinks
    }

    /// The angle between the outermost two directions of a plane with `part` of its largest intensity.
    fn width(&self, plane: f64, part: f64) -> Option<f64> {
        let kinks = self.kinks(plane);
        let value = |angle: f64| self.in_plane(plane, angle);
        let brightest = kinks
            .iter()
            .copied()
            .max_by(|&a, &b| value(a).total_cmp(&value(b)))?;
        let threshold = part * value(brightest);
        if threshold <= 0.0 {
            return None;
        }
        if brightest.abs() <= 90.0 {
            return width_about(&kinks, value, threshold);
        }
        // A luminaire that lights the ceiling is as wide as it is about straight up.
        width_about(&from_above(&kinks), |angle| value(above(angle)), threshold)
    }
}

/// The angle between the outermost two places of a curve with at least `threshold`, straight between its kinks.
fn width_about(kinks: &[f64], value: impl Fn(f64) -> f64, threshold: f64) -> Option<f64> {
    let is_inside = |&angle: &f64| value(angle) >= threshold;
    let first = kinks.iter().position(is_inside)?;
    let last = kinks.iter().rposition(is_inside)?;
    let end = |inner: f64, outer: Option<&f64>| {
        let Some(&outer) = outer else {
            return inner;
        };
        let (inside, outside) = (value(inner), value(outer));
        // Where the table ends, light ends at once.
        if value(inner.midpoint(outer)) < inside.midpoint(outside) / 2.0 {
            return inner;
        }
        inner + (outer - inner) * ((inside - threshold) / (inside - outside))
    };
    let before = first.checked_sub(1).and_then(|i| kinks.get(i));
    let width = end(kinks[last], kinks.get(last + 1)) - end(kinks[first], before);
    Some(width.clamp(0.0, 360.0))
}

/// An angle from straight up as an angle from the axis.
fn above(angle: f64) -> f64 {
    if angle > 0.0 {
        angle - 180.0
    } else {
        angle + 180.0
    }
}

/// Kinks counted from straight up.
fn from_above(kinks: &[f64]) -> Vec<f64> {
    let both = kinks
        .iter()
        .flat_map(|&angle| [angle - 180.0, angle + 180.0]);
    let mut kinks: Vec<f64> = both.filter(|angle| angle.abs() <= 180.0).collect();
    kinks.sort_by(f64::total_cmp);
    kinks.dedup_by(|a, b| *a == *b);
    kinks
}
