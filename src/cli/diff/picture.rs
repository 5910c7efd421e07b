//! The relative error as a picture.

use std::path::Path;

use candela::compare::FalseColor;
use candela::display::Image;
use candela::exr::DataWindow;
use candela::output::{OutputError, Unfinished};

/// Writes relative errors in false colors, six decades of them.
pub(super) fn write(
    path: &Path,
    window: DataWindow,
    errors: &[f32],
    unfinished: &Unfinished,
) -> Result<(), OutputError> {
    let colors = errors
        .iter()
        .map(|&error| FalseColor::RELATIVE.color(error.into()));
    Image::opaque(window.size, colors.collect()).write_png(path, unfinished)
}
