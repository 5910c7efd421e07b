//! The intensities of a luminaire: a table over vertical and horizontal angles, bilinear between them.

use std::ops::RangeInclusive;

use super::coordinates::{Angles, Coordinates, sincos};
use crate::math::DVec3;

/// How a table that is not written whole goes on (LM-63-02, section 4, horizontal angles).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// One plane: the same all around the axis. Type C.
    Axial,
    /// Planes 0 to 90: the same in all quadrants. Type C.
    Quadrants,
    /// Planes 0 to 180 of type C, or 0 to 90 of types A and B: mirrored by the plane of axis and up.
    Mirrored,
    /// Planes 90 to 270: mirrored by the plane that stands across. Type C.
    MirroredAcross,
    /// All planes are there. Those of type C start anywhere from 0 to 360 and end 360 later, the last like the
    /// first.
    None,
}

/// Luminous intensities in cd, with all factors of their file, in the [lamp's frame](super::coordinates).
#[derive(Clone, Debug, PartialEq)]
pub struct Photometry {
    coordinates: Coordinates,
    symmetry: Symmetry,
    /// Degrees, ascending. At least two.
    vertical: Vec<f64>,
    /// Degrees, ascending. One where axial, otherwise at least two.
    horizontal: Vec<f64>,
    /// Of the first horizontal angle all vertical ones, then those of the next.
    candela: Vec<f64>,
}

/// A place between two neighbors in a list.
#[derive(Clone, Copy, Debug)]
struct Between {
    low: usize,
    high: usize,
    /// 0 at `low`, 1 at `high`.
    part: f64,
}

impl Between {
    /// `None` where it is outside of the list.
    fn find(list: &[f64], value: f64) -> Option<Self> {
        let (&first, &last) = (list.first()?, list.last()?);
        if !(first <= value && value <= last) {
            return None;
        }
        let high = list.partition_point(|&other| other <= value);
        let high = high.min(list.len() - 1);
        let low = high.saturating_sub(1);
        let part = if low < high {
            (value - list[low]) / (list[high] - list[low])
        } else {
            0.0
        };
        Some(Self { low, high, part })
    }
}

impl Photometry {
    /// Of what was checked: angles ascend, and there is a value ≥ 0 for each pair.
    pub(super) fn new(
        coordinates: Coordinates,
        symmetry: Symmetry,
        vertical: Vec<f64>,
        horizontal: Vec<f64>,
        candela: Vec<f64>,
    ) -> Self {
        debug_assert_eq!(candela.len(), vertical.len() * horizontal.len());
        Self {
            coordinates,
            symmetry,
            vertical,
            horizontal,
            candela,
        }
    }

    /// The type of photometry.
    pub fn coordinates(&self) -> Coordinates {
        self.coordinates
    }

    /// How the table goes on beyond its horizontal angles.
    pub fn symmetry(&self) -> Symmetry {
        self.symmetry
    }

    /// The vertical angles of the table and its horizontal ones: degrees, ascending.
    pub fn angles(&self) -> (&[f64], &[f64]) {
        (&self.vertical, &self.horizontal)
    }

    /// The intensity at angles of the table, by their places in [`Photometry::angles`]; `None` where there is no
    /// such angle.
    pub fn value(&self, vertical: usize, horizontal: usize) -> Option<f64> {
        let (height, width) = (self.vertical.len(), self.horizontal.len());
        let is_inside = vertical < height && horizontal < width;
        is_inside.then(|| self.candela[horizontal * height + vertical])
    }

    /// The intensities of a plane, by its place among the horizontal angles.
    pub(super) fn plane(&self, horizontal: usize) -> &[f64] {
        let height = self.vertical.len();
        &self.candela[horizontal * height..][..height]
    }

    /// All intensities times `factor`, which is finite and not negative.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        for value in &mut self.candela {
            *value *= factor;
        }
        self
    }

    /// The intensity towards a direction of any length but zero, given in the lamp's frame: +Z is the axis, +X
    /// up. 0 outside of the table.
    pub fn intensity(&self, direction: DVec3) -> f64 {
        self.at(self.coordinates.angles(direction))
    }

    /// The intensity at a pair of angles: bilinear in both. 0 outside of the table.
    pub fn at(&self, angles: Angles) -> f64 {
        let horizontal = self.folded(angles.horizontal);
        let v = Between::find(&self.vertical, angles.vertical);
        let h = Between::find(&self.horizontal, horizontal);
        let (Some(v), Some(h)) = (v, h) else {
            return 0.0;
        };
        let between = |a: f64, b: f64, part: f64| a + (b - a) * part;
        let in_plane = |h: usize| {
            let plane = self.plane(h);
            between(plane[v.low], plane[v.high], v.part)
        };
        between(in_plane(h.low), in_plane(h.high), h.part)
    }

    /// Whether the table says something of these angles.
    pub fn covers(&self, angles: Angles) -> bool {
        let covers = |list: &[f64], angle: f64| Between::find(list, angle).is_some();
        covers(&self.vertical, angles.vertical)
            && covers(&self.horizontal, self.folded(angles.horizontal))
    }

    /// The angle in the table that a horizontal angle stands for.
    fn folded(&self, horizontal: f64) -> f64 {
        let first = self.horizontal.first().copied().unwrap_or_default();
        if self.symmetry == Symmetry::Axial {
            return first;
        }
        if self.coordinates != Coordinates::C {
            return match self.symmetry {
                Symmetry::Mirrored => horizontal.abs(),
                _ => horizontal,
            };
        }
        let around = horizontal.rem_euclid(360.0);
        let half = |around: f64| around.min(360.0 - around);
        match self.symmetry {
            Symmetry::Axial => first,
            Symmetry::Quadrants => half(around).min(180.0 - half(around)),
            Symmetry::Mirrored => half(around),
            Symmetry::MirroredAcross => match around {
                around if around < 90.0 => 180.0 - around,
                around if around > 270.0 => 540.0 - around,
                around => around,
            },
            Symmetry::None if around < first => around + 360.0,
            Symmetry::None => around,
        }
    }

    /// All horizontal angles that a horizontal angle of the table stands for, within a turn or so.
    fn images(&self, horizontal: f64) -> [f64; 4] {
        let (g, is_c) = (horizontal, self.coordinates == Coordinates::C);
        match self.symmetry {
            Symmetry::Axial | Symmetry::None => [g; 4],
            Symmetry::Quadrants => [g, 180.0 - g, 180.0 + g, 360.0 - g],
            Symmetry::Mirrored if is_c => [g, 360.0 - g, g, 360.0 - g],
            Symmetry::Mirrored => [g, -g, g, -g],
            Symmetry::MirroredAcross => [g, 180.0 - g, g, 540.0 - g],
        }
    }

    /// The largest intensity over ranges of vertical and horizontal angles, up to rounding: it is at a corner
    /// of the ranges' part of a cell of the table. Horizontal angles are those of the whole table, with all
    /// symmetries; those of type C may go from −360 to 720.
    pub fn largest_in(
        &self,
        vertical: RangeInclusive<f64>,
        horizontal: RangeInclusive<f64>,
    ) -> f64 {
        let inside = self.vertical.iter().copied();
        let inside = inside.filter(|angle| vertical.contains(angle));
        let rows: Vec<f64> = inside.chain([*vertical.start(), *vertical.end()]).collect();
        let turns: &[f64] = match self.coordinates {
            Coordinates::C => &[-720.0, -360.0, 0.0, 360.0, 720.0],
            Coordinates::A | Coordinates::B => &[0.0],
        };
        let is_met = |angle: f64| {
            let images = self.images(angle);
            let mut images = images.iter().flat_map(|a| turns.iter().map(move |t| a + t));
            images.any(|image| horizontal.contains(&image))
        };
        let inside = self.horizontal.iter().copied().filter(|&a| is_met(a));
        let mut largest = 0.0_f64;
        for horizontal in inside.chain([*horizontal.start(), *horizontal.end()]) {
            for &vertical in &rows {
                largest = largest.max(self.at(Angles {
                    vertical,
                    horizontal,
                }));
            }
        }
        largest
    }

    /// A bound on the intensity over a cone of directions: none in it is above, but for rounding. `half_angle` is
    /// in degrees.
    pub fn largest_in_cone(&self, axis: DVec3, half_angle: f64) -> f64 {
        /// In degrees: more than rounding makes of an angle.
        const ROUNDING: f64 = 1e-9;
        let coordinates = self.coordinates;
        let (latitude, around) = coordinates.latitude_and_around(coordinates.angles(axis));
        let half = half_angle + ROUNDING;
        let (south, north) = coordinates.poles();
        let latitudes = (latitude - half).max(south)..=(latitude + half).min(north);
        let has_pole = latitude - half <= south || latitude + half >= north;
        let from_pole = latitude - south;
        let width = if has_pole {
            180.0
        } else {
            let sine = sincos(half).0 / sincos(from_pole).0;
            libm::asin(sine.min(1.0)).to_degrees() + ROUNDING
        };
        let around = if has_pole { 0.0 } else { around };
        let (from, to) = (around - width, around + width);
        match coordinates {
            Coordinates::C => self.largest_in(latitudes, from..=to),
            // What goes beyond ±180 is on the other side.
            Coordinates::A | Coordinates::B => {
                let parts = [
                    (from, to),
                    (from + 360.0, to + 360.0),
                    (from - 360.0, to - 360.0),
                ];
                let parts = parts.map(|(from, to)| (from.max(-180.0), to.min(180.0)));
                let parts = parts.into_iter().filter(|(from, to)| from <= to);
                let largest = parts.map(|(from, to)| match coordinates {
                    Coordinates::B => self.largest_in(from..=to, latitudes.clone()),
                    Coordinates::A | Coordinates::C => {
                        self.largest_in(latitudes.clone(), from..=to)
                    }
                });
                largest.fold(0.0, f64::max)
            }
        }
    }
}
