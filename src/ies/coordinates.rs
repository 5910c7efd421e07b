//! Photometric coordinates: which direction a pair of angles is.
//!
//! # The lamp's frame
//!
//! Right-handed:
//!
//! - +Z is the *axis*: the way that the light goes, straight down from a ceiling. The scene's `look_at` lies there.
//! - +X is *up*: horizontal angle 0 of type C. The scene's `up` lies there.
//! - +Y is Z × X: horizontal angle 90 of type C. Angles go counter-clockwise for one who looks against the light.
//!
//! # The types
//!
//! The types differ in what their planes share (LM-63-02, section 3): in type C the axis, in type B a horizontal line
//! across it, in type A the line of up. Horizontal angles of types A and B go the other way around. A lamp of type A looks
//! at the horizon: its (0, 0) is turned to the axis here, so that all three types have V = 0 at H = 0 on the axis, and
//! V = 90° at H = 0 up.
//!
//! | type | direction of (V, H) | range |
//! | --- | --- | --- |
//! | C | sin V (cos H X + sin H Y) + cos V Z | V 0 to 180, H 0 to 360 |
//! | B | cos H (sin V X + cos V Z) − sin H Y | V −180 to 180, H −90 to 90 |
//! | A | sin V X + cos V (cos H Z − sin H Y) | V −90 to 90, H −180 to 180 |

use std::f64::consts::PI;
use std::fmt;

use crate::math::DVec3;

/// Degrees in a radian.
const DEGREES: f64 = 180.0 / PI;

/// The type of photometry: how vertical and horizontal angles make a direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinates {
    /// C: planes about the axis, as for all usual luminaires.
    C,
    /// B: planes about a line across the axis, as for floodlights.
    B,
    /// A: planes about the line of up, as for headlamps.
    A,
}

/// Vertical and horizontal angle, in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Angles {
    /// V
    pub vertical: f64,
    /// H
    pub horizontal: f64,
}

/// Sine and cosine of an angle in degrees; exact for multiples of 90.
pub(super) fn sincos(degrees: f64) -> (f64, f64) {
    let quarters = libm::rint(degrees / 90.0);
    let (sin, cos) = libm::sincos((degrees - quarters * 90.0) / DEGREES);
    match quarters.rem_euclid(4.0) as u8 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

impl Coordinates {
    /// The angles of a direction of any length but zero in the [lamp's frame](self); where one of them is
    /// any (at a pole), it is 0 or 180. Range: as the table of the page says.
    pub fn angles(self, direction: DVec3) -> Angles {
        let DVec3 { x, y, z } = direction;
        let angle = |y: f64, x: f64| libm::atan2(y, x) * DEGREES;
        let (vertical, horizontal) = match self {
            Self::C => {
                let around = angle(y, x);
                let around = if around < 0.0 { around + 360.0 } else { around };
                (angle(libm::hypot(x, y), z), around)
            }
            Self::B => (angle(x, z), angle(-y, libm::hypot(x, z))),
            Self::A => (angle(x, libm::hypot(y, z)), angle(-y, z)),
        };
        Angles {
            vertical,
            horizontal,
        }
    }

    /// The unit vector of a pair of angles, in the [lamp's frame](self).
    pub fn direction(self, angles: Angles) -> DVec3 {
        let (sin_v, cos_v) = sincos(angles.vertical);
        let (sin_h, cos_h) = sincos(angles.horizontal);
        match self {
            Self::C => DVec3::new(sin_v * cos_h, sin_v * sin_h, cos_v),
            Self::B => DVec3::new(cos_h * sin_v, -sin_h, cos_h * cos_v),
            Self::A => DVec3::new(sin_v, -(cos_v * sin_h), cos_v * cos_h),
        }
    }

    /// The least and the largest vertical angle there is, and the same of horizontal ones before those of
    /// type C are turned.
    pub(super) const fn limits(self) -> [(f64, f64); 2] {
        match self {
            Self::C => [(0.0, 180.0), (-360.0, 720.0)],
            Self::B => [(-180.0, 180.0), (-90.0, 90.0)],
            Self::A => [(-90.0, 90.0), (-180.0, 180.0)],
        }
    }

    /// Of a direction: the angle from the pole or the equator that circles of latitude have, and the one around
    /// the line of the poles.
    pub(super) const fn latitude_and_around(self, angles: Angles) -> (f64, f64) {
        match self {
            Self::C | Self::A => (angles.vertical, angles.horizontal),
            Self::B => (angles.horizontal, angles.vertical),
        }
    }

    /// Where the poles are, as latitudes.
    pub(super) const fn poles(self) -> (f64, f64) {
        match self {
            Self::C => (0.0, 180.0),
            Self::A | Self::B => (-90.0, 90.0),
        }
    }
}

impl fmt::Display for Coordinates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::C => "type C",
            Self::B => "type B",
            Self::A => "type A",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_the_axes_are() {
        let down = DVec3::Z;
        let up = DVec3::X;
        let side = DVec3::Y;
        let at = |coordinates: Coordinates, vertical, horizontal| {
            coordinates.direction(Angles {
                vertical,
                horizontal,
            })
        };
        use Coordinates::{A, B, C};
        for coordinates in [A, B, C] {
            assert_eq!(at(coordinates, 0.0, 0.0), down);
            assert_eq!(at(coordinates, 90.0, 0.0), up);
        }
        assert_eq!(at(C, 90.0, 90.0), side);
        assert_eq!(at(C, 180.0, 30.0), -down);
        assert_eq!(at(B, 33.0, 90.0), -side);
        assert_eq!(at(B, 180.0, 0.0), -down);
        assert_eq!(at(A, 0.0, 90.0), -side);
        assert_eq!(at(A, -90.0, 17.0), -up);
    }

    #[test]
    fn angles_lead_back() {
        for coordinates in [Coordinates::A, Coordinates::B, Coordinates::C] {
            let [(v0, v1), (h0, h1)] = match coordinates {
                Coordinates::C => [(0.0, 180.0), (0.0, 360.0)],
                Coordinates::A | Coordinates::B => coordinates.limits(),
            };
            for i in 1..20 {
                for j in 1..20 {
                    let angles = Angles {
                        vertical: v0 + (v1 - v0) * f64::from(i) / 20.0,
                        horizontal: h0 + (h1 - h0) * f64::from(j) / 20.0,
                    };
                    let direction = coordinates.direction(angles);
                    assert!((direction.length() - 1.0).abs() < 1e-15);
                    let back = coordinates.angles(direction * 3.7);
                    assert!((back.vertical - angles.vertical).abs() < 1e-12);
                    assert!((back.horizontal - angles.horizontal).abs() < 1e-12);
                }
            }
        }
    }
}
