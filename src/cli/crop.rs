//! Parts of an image on the command line.

use candela::image::Window;

use super::Failure;

/// A part of an image, whatever its size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crop {
    from: [u32; 2],
    to: [u32; 2],
}

impl Crop {
    /// The part of an image of this size; an error, which names the option, where there is no such part.
    pub(super) fn within(self, option: &str, resolution: [u32; 2]) -> Result<Window, Failure> {
        let Self { from, to } = self;
        let [width, height] = resolution;
        if to[0] > width || to[1] > height {
            return Err(format!(
                "{option} {},{},{},{} is not inside of the image, whose pixels are 0,0,{width},{height}",
                from[0], from[1], to[0], to[1],
            )
            .into());
        }
        Ok(Window {
            x: from[0],
            y: from[1],
            width: to[0] - from[0],
            height: to[1] - from[1],
        })
    }
}

/// `X0,Y0,X1,Y1`
pub(super) fn crop(text: &str) -> Result<Crop, String> {
    let expected = || "expected X0,Y0,X1,Y1 in pixels, such as 0,0,640,360".to_owned();
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let [x0, y0, x1, y1] = numbers.map_err(|_| expected())?[..] else {
        return Err(expected());
    };
    if x0 >= x1 || y0 >= y1 {
        return Err("there are no pixels in it: expected X0 < X1 and Y0 < Y1".to_owned());
    }
    Ok(Crop {
        from: [x0, y0],
        to: [x1, y1],
    })
}
