//! The points of `--pixel`.

use std::fmt;

/// A point of the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point([Coordinate; 2]);

/// Where a point is along a side of the image.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Coordinate {
    /// In the middle of this column or row.
    Middle(u32),
    /// So many pixels from the left or upper edge. Range: finite, from 0 on.
    At(f64),
}

impl Coordinate {
    fn position(self) -> f64 {
        match self {
            Self::Middle(pixel) => f64::from(pixel) + 0.5,
            Self::At(position) => position,
        }
    }
}

impl Point {
    /// The center of a pixel.
    pub(super) fn center(pixel: [u32; 2]) -> Self {
        Self(pixel.map(Coordinate::Middle))
    }

    /// In pixels from the top left corner of the image.
    pub(super) fn position(self) -> [f64; 2] {
        self.0.map(Coordinate::position)
    }

    /// Column and row of the pixel that it is in.
    pub(super) fn pixel(self) -> [u32; 2] {
        // Inside of an image there are no more than a `u32` holds.
        self.position().map(|position| position as u32)
    }

    /// Whether it is the center of a pixel.
    pub(super) fn is_center(self) -> bool {
        self.position()
            .iter()
            .all(|position| position.fract() == 0.5)
    }

    /// Whether an image has it.
    pub(super) fn is_in(self, resolution: [u32; 2]) -> bool {
        let mut sides = self.0.iter().zip(resolution);
        sides.all(|(coordinate, side)| coordinate.position() < f64::from(side))
    }
}

impl fmt::Display for Point {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y] = self.0.map(|coordinate| match coordinate {
            Coordinate::Middle(pixel) => pixel.to_string(),
            Coordinate::At(position) => position.to_string(),
        });
        write!(f, "{x},{y}")
    }
}

/// Reads `X,Y`.
pub(super) fn point(text: &str) -> Result<Point, String> {
    let coordinate = |part: &str| {
        let part = part.trim();
        if part.bytes().all(|byte| byte.is_ascii_digit()) {
            return part.parse().ok().map(Coordinate::Middle);
        }
        let position = part.parse().ok();
        let position = position.filter(|at: &f64| at.is_finite() && at.is_sign_positive());
        position.map(Coordinate::At)
    };
    text.split_once(',')
        .and_then(|(x, y)| Some(Point([coordinate(x)?, coordinate(y)?])))
        .ok_or_else(|| {
            "expected column and row, two whole numbers such as 640,360, or a place with decimals \
             such as 640.25,360.5"
                .to_owned()
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_are_middles() {
        let position = |text: &str| point(text).map(Point::position);
        assert_eq!(position("3, 4"), Ok([3.5, 4.5]));
        assert_eq!(position("3.0,4"), Ok([3.0, 4.5]));
        assert_eq!(position("10.25,7.5"), Ok([10.25, 7.5]));
        assert_eq!(position("0.0,1e1"), Ok([0.0, 10.0]));
        let is_center = |text: &str| point(text).map(Point::is_center);
        assert_eq!(is_center("3,4.5"), Ok(true));
        assert_eq!(is_center("3.0,4"), Ok(false));
        assert_eq!(point("3.99,4").map(Point::pixel), Ok([3, 4]));
        assert_eq!(
            point("64.999,48").map(|point| point.is_in([65, 49])),
            Ok(true)
        );
        assert_eq!(
            point("65.0,48").map(|point| point.is_in([65, 49])),
            Ok(false)
        );
        for text in [
            "",
            "1",
            ",",
            "1,",
            "1,2,3",
            "-1,2",
            "-0.5,2",
            "-0.0,1",
            "4294967296,0",
            "a,b",
            "nan,0",
            "inf,0",
            "1e999,0",
        ] {
            assert!(point(text).unwrap_err().contains("640,360"), "{text}");
        }
    }
}
