//! Where the pixels of a PNG come from.

use std::ops::Range;

use crate::exr::{ColorTag, Content, ExrError, ExrImage, ExrReader};
use crate::image::Window;
use crate::image_file::ImageFile;

/// Pixels of an image in memory that are developed together.
const TOGETHER: u32 = 1 << 20;

/// What is shown: what an EXR shows, of a file or in memory, or a picture of another format.
#[derive(Clone, Copy)]
pub(super) enum Source<'s> {
    File(&'s ExrReader),
    Image(&'s ExrImage),
    Decoded(&'s ImageFile),
}

impl Source<'_> {
    /// Width and height of the display window.
    pub(super) fn resolution(self) -> [u32; 2] {
        match self {
            Self::File(file) => file.resolution(),
            Self::Image(image) | Self::Decoded(ImageFile { image, .. }) => image.resolution,
        }
    }

    /// Whether the display window is about as large as the data makes plausible.
    pub(super) fn check_resolution(self) -> Result<(), ExrError> {
        match self {
            Self::File(file) => file.check_resolution(),
            Self::Image(_) | Self::Decoded(_) => Ok(()),
        }
    }

    /// The part of the display window that there are pixels for.
    pub(super) fn window(self) -> Option<Window> {
        match self {
            Self::File(file) => file.window(),
            Self::Image(image) | Self::Decoded(ImageFile { image, .. }) => image.window,
        }
    }

    /// Whether it is light of a file that says by an attribute which light it is.
    pub(super) fn may_name_its_space(self) -> bool {
        match self {
            Self::File(file) => file.content() == Content::Light,
            Self::Image(_) | Self::Decoded(_) => false,
        }
    }

    /// What it is a picture of.
    pub(super) fn content(self) -> Content {
        match self {
            Self::File(file) => file.content(),
            Self::Image(_) | Self::Decoded(_) => Content::Light,
        }
    }

    /// Whether there is a channel A.
    pub(super) fn has_alpha(self) -> bool {
        match self {
            Self::File(file) => file.has_alpha(),
            Self::Image(image) | Self::Decoded(ImageFile { image, .. }) => image.has_alpha,
        }
    }

    /// What is said about the color space.
    pub(super) fn color(&self) -> &ColorTag {
        match *self {
            Self::File(file) => file.color(),
            Self::Image(image) | Self::Decoded(ImageFile { image, .. }) => &image.color,
        }
    }

    /// How much wider than high a pixel is.
    pub(super) fn pixel_aspect(self) -> f32 {
        match self {
            Self::File(file) => file.pixel_aspect(),
            Self::Image(_) => 1.0,
            Self::Decoded(image) => image.pixel_aspect,
        }
    }

    /// What the user should know about the header, a sentence each.
    pub(super) fn warnings(self) -> Vec<String> {
        match self {
            Self::File(file) => file.warnings(),
            Self::Image(_) => Vec::new(),
            Self::Decoded(image) => image.warnings.clone(),
        }
    }

    /// The rows of the window, in groups that are well developed together, from the top.
    pub(super) fn bands(&self) -> Box<dyn Iterator<Item = Range<u32>> + '_> {
        match *self {
            Self::File(file) => Box::new(file.bands()),
            Self::Image(image) | Self::Decoded(ImageFile { image, .. }) => {
                let [width, height] = image.window.map_or([1, 0], |w| [w.width, w.height]);
                let rows = (TOGETHER / width.max(1)).max(1);
                let starts = (0..height).step_by(rows as usize);
                Box::new(starts.map(move |top| top..height.min(top + rows)))
            }
        }
    }

    /// Rows of the window, R, G, B, A as stored, in new memory.
    pub(super) fn rows(self, rows: Range<u32>) -> Result<Vec<[f32; 4]>, ExrError> {
        match self {
            Self::File(file) => file.new_rows(rows),
            Self::Image(image) | Self::Decoded(ImageFile { image, .. }) => {
                let width = image.window.map_or(0, |window| window.width as usize);
                let pixels = rows.start as usize * width..rows.end as usize * width;
                Ok(image.pixels[pixels].to_vec())
            }
        }
    }
}
