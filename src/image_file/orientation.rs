//! Pictures that are stored turned or mirrored.

use ::image::metadata::Orientation;

use super::problem::ImageFileProblem;
use crate::memory;

/// Turns a picture as its file asks; its width and height after that.
pub(super) fn upright(
    pixels: &mut Vec<[f32; 4]>,
    [width, height]: [u32; 2],
    orientation: Orientation,
) -> Result<[u32; 2], ImageFileProblem> {
    let (columns, rows) = (width as usize, height as usize);
    // Where the pixel at x, y of the upright picture is in the file.
    type Place = fn([usize; 2], [usize; 2]) -> [usize; 2];
    let (is_turned, place): (bool, Place) = match orientation {
        Orientation::NoTransforms => return Ok([width, height]),
        Orientation::FlipHorizontal => (false, |[x, y], [w, _]| [w - 1 - x, y]),
        Orientation::Rotate180 => (false, |[x, y], [w, h]| [w - 1 - x, h - 1 - y]),
        Orientation::FlipVertical => (false, |[x, y], [_, h]| [x, h - 1 - y]),
        Orientation::Rotate90FlipH => (true, |[x, y], _| [y, x]),
        Orientation::Rotate90 => (true, |[x, y], [_, h]| [y, h - 1 - x]),
        Orientation::Rotate270FlipH => (true, |[x, y], [w, h]| [w - 1 - y, h - 1 - x]),
        Orientation::Rotate270 => (true, |[x, y], [w, _]| [w - 1 - y, x]),
    };
    let [new_columns, new_rows] = if is_turned {
        [rows, columns]
    } else {
        [columns, rows]
    };
    let mut upright = Vec::new();
    memory::reserve(&mut upright, pixels.len()).map_err(|error| error.for_what("the picture"))?;
    for y in 0..new_rows {
        upright.extend((0..new_columns).map(|x| {
            let [x, y] = place([x, y], [columns, rows]);
            pixels[y * columns + x]
        }));
    }
    *pixels = upright;
    Ok(if is_turned {
        [height, width]
    } else {
        [width, height]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::image::{DynamicImage, Rgba32FImage};

    /// The crate's own turning.
    #[test]
    fn every_orientation_is_that_of_exif() {
        let pixels: Vec<[f32; 4]> = (0..6).map(|i| [i as f32; 4]).collect();
        for code in 1..=8 {
            let orientation = Orientation::from_exif(code).unwrap();
            let image = Rgba32FImage::from_vec(3, 2, pixels.as_flattened().to_vec());
            let mut theirs = DynamicImage::ImageRgba32F(image.unwrap());
            theirs.apply_orientation(orientation);
            let mut ours = pixels.clone();
            let size = upright(&mut ours, [3, 2], orientation).unwrap();
            assert_eq!(size, [theirs.width(), theirs.height()], "{code}");
            assert_eq!(ours.as_flattened(), theirs.to_rgba32f().as_raw(), "{code}");
        }
    }
}
