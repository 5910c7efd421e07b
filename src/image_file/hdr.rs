//! Radiance HDR: three mantissas and an exponent that they share.
//!
//! Radiance means W/(sr m²) of white by these numbers, 1 of which is 179 cd/m² (Ward, "The RADIANCE picture file
//! format"); other programs mean nothing of the kind. So the numbers are taken as they are, divided by what the header
//! says that they were multiplied by.

use std::io::Cursor;
use std::io::Read;

use ::image::ImageDecoder;
use ::image::codecs::hdr::HdrDecoder;
use ::image::metadata::Orientation;

use super::coding::Coding;
use super::orientation::upright;
use super::problem::{ImageFileProblem, TOO_EARLY, damaged, of_decoder, unsupported};
use super::samples::{Channels, Depth, Layout};
use super::{Decoded, ImageFormat, check_size, room};
use crate::color::Primaries;

/// Bytes of the longest header that is read.
const LONGEST: usize = 1 << 16;

pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, ImageFileProblem> {
    let header = Header::of(bytes)?;
    let [length, lines] = header.scanlines;
    check_size(header.scanlines, bytes.len())?;
    let layout = Layout {
        depth: Depth::Float,
        channels: Channels::Rgb,
        is_premultiplied: false,
        coding: Coding::LINEAR,
    };
    let problem = |error| of_decoder(ImageFormat::Hdr, error);
    // The decoder has a scanline of its own.
    let mut samples = room(
        header.scanlines,
        layout.pixel_bytes(),
        u64::from(length) * 4,
    )?;
    // It knows but one signature and one order of scanlines.
    let plain = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {lines} +X {length}\n");
    let stream = Cursor::new(plain).chain(Cursor::new(&bytes[header.end..]));
    let decoder = HdrDecoder::new(stream).map_err(problem)?;
    decoder.read_image(&mut samples).map_err(problem)?;
    let mut pixels = layout.pixels(&samples)?;
    if header.gain != [1.0; 3] {
        for [r, g, b, _] in &mut pixels {
            for (channel, gain) in [r, g, b].into_iter().zip(header.gain) {
                *channel = (f64::from(*channel) / gain) as f32;
            }
        }
    }
    let resolution = upright(&mut pixels, header.scanlines, header.orientation)?;
    Ok(Decoded {
        resolution,
        pixels,
        has_alpha: false,
        primaries: header.primaries,
        pixel_aspect: header.pixel_aspect,
        warnings: header.warnings,
    })
}

/// What stands before the pixels.
#[derive(Debug)]
struct Header {
    /// The length of a scanline, and how many there are.
    scanlines: [u32; 2],
    orientation: Orientation,
    /// What R, G, B were multiplied by.
    gain: [f64; 3],
    primaries: Primaries,
    pixel_aspect: f32,
    warnings: Vec<String>,
    /// Where the pixels begin.
    end: usize,
}

impl Header {
    fn of(bytes: &[u8]) -> Result<Self, ImageFileProblem> {
        let head = &bytes[..bytes.len().min(LONGEST)];
        let mut lines = Lines {
            bytes: head,
            end: 0,
        };
        let mut header = Self {
            scanlines: [0; 2],
            orientation: Orientation::NoTransforms,
            gain: [1.0; 3],
            primaries: Primaries::REC709,
            pixel_aspect: 1.0,
            warnings: Vec::new(),
            end: 0,
        };
        loop {
            let line = lines.next(bytes)?;
            if line.is_empty() {
                break;
            }
            if let Some((name, value)) = line.split_once('=')
                && !line.starts_with('#')
            {
                header.heed(name.trim(), value.trim())?;
            }
        }
        let line = lines.next(bytes)?;
        (header.scanlines, header.orientation) =
            scanlines(&line).ok_or_else(|| damaged("its size cannot be read"))?;
        header.end = lines.end;
        Ok(header)
    }

    /// A variable; several of one name add up, as the format has it.
    fn heed(&mut self, name: &str, value: &str) -> Result<(), ImageFileProblem> {
        let numbers = || -> Option<Vec<f64>> {
            let words = value.split_ascii_whitespace();
            words.map(|word| word.parse().ok()).collect()
        };
        let is_gain = |number: &f64| *number > 0.0 && number.is_finite();
        match name {
            "FORMAT" => match value {
                "32-bit_rle_rgbe" => {}
                "32-bit_rle_xyze" => self.primaries = Primaries::XYZ,
                other => return Err(unsupported(ImageFormat::Hdr, other)),
            },
            "EXPOSURE" => match numbers().as_deref() {
                Some([exposure]) if is_gain(exposure) => {
                    self.gain = self.gain.map(|gain| gain * exposure);
                }
                Some(_) | None => self.warn(name),
            },
            "COLORCORR" => match numbers().as_deref() {
                Some(factors @ [_, _, _]) if factors.iter().all(is_gain) => {
                    for (gain, factor) in self.gain.iter_mut().zip(factors) {
                        *gain *= factor;
                    }
                }
                Some(_) | None => self.warn(name),
            },
            "PIXASPECT" => match numbers().as_deref() {
                // How much higher than wide.
                Some([aspect]) if is_gain(aspect) => self.pixel_aspect /= *aspect as f32,
                Some(_) | None => self.warn(name),
            },
            "PRIMARIES" => match numbers().as_deref() {
                Some(&[rx, ry, gx, gy, bx, by, wx, wy]) if self.primaries != Primaries::XYZ => {
                    self.primaries = Primaries {
                        red: [rx, ry],
                        green: [gx, gy],
                        blue: [bx, by],
                        white: [wx, wy],
                    };
                }
                Some(_) | None => self.warn(name),
            },
            // VIEW, GAMMA and the like say nothing about light.
            _ => {}
        }
        Ok(())
    }

    fn warn(&mut self, name: &str) {
        self.warnings.push(format!(
            "its header says something about {name} that cannot be read, which is passed over"
        ));
    }
}

/// Lines of a header.
struct Lines<'b> {
    bytes: &'b [u8],
    /// Where the last one ended.
    end: usize,
}

impl Lines<'_> {
    fn next(&mut self, file: &[u8]) -> Result<String, ImageFileProblem> {
        let rest = &self.bytes[self.end..];
        let Some(length) = rest.iter().position(|&byte| byte == b'\n') else {
            return Err(if self.bytes.len() < file.len() {
                damaged("its header has no end")
            } else {
                damaged(TOO_EARLY)
            });
        };
        self.end += length + 1;
        let line = String::from_utf8_lossy(&rest[..length]);
        Ok(line.trim_end_matches('\r').to_owned())
    }
}

/// The length and number of scanlines by a line such as `-Y 600 +X 800`, and how they make the picture.
fn scanlines(line: &str) -> Option<([u32; 2], Orientation)> {
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let &[slow, lines, fast, length] = &words[..] else {
        return None;
    };
    let orientation = match (slow, fast) {
        ("-Y", "+X") => Orientation::NoTransforms,
        ("-Y", "-X") => Orientation::FlipHorizontal,
        ("+Y", "-X") => Orientation::Rotate180,
        ("+Y", "+X") => Orientation::FlipVertical,
        // Scanlines are columns.
        ("+X", "-Y") => Orientation::Rotate90FlipH,
        ("-X", "-Y") => Orientation::Rotate90,
        ("-X", "+Y") => Orientation::Rotate270FlipH,
        ("+X", "+Y") => Orientation::Rotate270,
        _ => return None,
    };
    Some(([length.parse().ok()?, lines.parse().ok()?], orientation))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of one pixel to a scanline, with these variables.
    fn file(variables: &str, size: &str, pixels: &[[u8; 4]]) -> Vec<u8> {
        let head = format!("#?RGBE\n# made by hand\n{variables}\n{size}\n");
        [head.as_bytes(), pixels.as_flattened()].concat()
    }

    /// r · 2^(e − 136), Ward 1991.
    const HALF: [u8; 4] = [128, 64, 0, 128];

    #[test]
    fn numbers_are_what_they_were_before_the_exposure() {
        let read = |variables: &str| decode(&file(variables, "-Y 1 +X 1", &[HALF])).unwrap();
        let decoded = read("FORMAT=32-bit_rle_rgbe\n");
        assert_eq!(decoded.pixels, [[0.5, 0.25, 0.0, 1.0]]);
        assert_eq!(decoded.primaries, Primaries::REC709);
        let exposed = read("EXPOSURE=2\nEXPOSURE= 0.5\r\nEXPOSURE=4\nCOLORCORR=0.5 1 1\n");
        assert_eq!(exposed.pixels, [[0.25, 0.0625, 0.0, 1.0]]);
        let primaries = read("PRIMARIES=.68 .32 .265 .69 .15 .06 .3127 .329\nPIXASPECT=2\n");
        assert_eq!(primaries.primaries, Primaries::P3_D65);
        assert_eq!(primaries.pixel_aspect, 0.5);
        assert_eq!(read("FORMAT=32-bit_rle_xyze\n").primaries, Primaries::XYZ);
        assert_eq!(read("EXPOSURE=dark\n").warnings.len(), 1);
        let other = decode(&file("FORMAT=8-bit\n", "-Y 1 +X 1", &[HALF]));
        assert!(matches!(other, Err(ImageFileProblem::Unsupported(_))));
    }

    /// Radiance's resolution lines: the first letter goes from scanline to scanline, the second along one.
    #[test]
    fn scanlines_are_laid_as_the_header_says() {
        let pixels = [[128, 0, 0, 129], [0, 128, 0, 129]];
        let (red, green) = ([1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]);
        for (size, resolution, expected) in [
            ("-Y 1 +X 2", [2, 1], [red, green]),
            ("-Y 1 -X 2", [2, 1], [green, red]),
            ("-Y 2 +X 1", [1, 2], [red, green]),
            ("+Y 2 +X 1", [1, 2], [green, red]),
            ("+Y 2 -X 1", [1, 2], [green, red]),
            ("+X 2 -Y 1", [2, 1], [red, green]),
            ("-X 2 -Y 1", [2, 1], [green, red]),
            ("+X 2 +Y 1", [2, 1], [red, green]),
            ("+X 1 +Y 2", [1, 2], [green, red]),
            ("-X 1 +Y 2", [1, 2], [green, red]),
        ] {
            let decoded = decode(&file("", size, &pixels)).unwrap();
            assert_eq!(decoded.resolution, resolution, "{size}");
            assert_eq!(decoded.pixels, expected, "{size}");
        }
    }

    #[test]
    fn a_header_may_be_anything() {
        for (file, is_early) in [
            (b"#?RADIANCE\nEXPOSURE=1".to_vec(), true),
            (b"#?RADIANCE\n\n".to_vec(), true),
            (b"#?RADIANCE\n\n-Y 1 +X 1\n\x01".to_vec(), true),
            (b"#?RADIANCE\n\n-Y 1 +Y 1\n".to_vec(), false),
            (b"#?RADIANCE\n\n-Y 99999999999 +X 1\n".to_vec(), false),
            (vec![b'#'; 1 << 17], false),
        ] {
            match decode(&file).map(|decoded| decoded.resolution) {
                Err(ImageFileProblem::Damaged(reason)) => {
                    assert_eq!(reason == TOO_EARLY, is_early, "{reason}");
                }
                other => panic!("{other:?}"),
            }
        }
        let huge = file("", "-Y 4000000000 +X 4000000000", &[]);
        assert!(matches!(decode(&huge), Err(ImageFileProblem::TooLarge(..))));
    }
}
