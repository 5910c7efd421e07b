//! Whether a file that is there already is the one that would be written.

use std::path::Path;

use rayon::prelude::*;

use super::ExrOptions;
use super::head::{RESIDUAL, head};
use super::merge::has_its_hash;
use super::read::{Attribute, StoredExr, attributes_of};
use super::tile::TILE_HASH;
use crate::image::ImageSpec;

/// Whether the file at `path` is whole, and its header is that of such an image, but for attributes that are not known
/// before it is rendered. What cannot be read is not.
pub(crate) fn is_whole(
    path: &Path,
    spec: &ImageSpec,
    options: &ExrOptions,
    is_known: &impl Fn(&str) -> bool,
) -> bool {
    // A pipe would be read, and what is read from it is gone.
    if !path.metadata().is_ok_and(|metadata| metadata.is_file()) {
        return false;
    }
    let Ok(stored) = StoredExr::open(path) else {
        return false;
    };
    let channels = spec.file_channels(options.precision);
    let Ok(head) = head(&spec.header(options, &channels)) else {
        return false;
    };
    let Ok(expected) = attributes_of(head) else {
        return false;
    };
    let is_told = |attribute: &&Attribute| {
        let name = String::from_utf8_lossy(&attribute.name);
        name != RESIDUAL && name != TILE_HASH && is_known(&name)
    };
    let is_same = stored
        .attributes()
        .iter()
        .filter(is_told)
        .eq(expected.iter().filter(is_told));
    // A copy that was cut off, or that lost bytes on its way.
    let is_whole = || match options.tile {
        Some(_) => has_its_hash(&stored),
        None => (0..stored.blocks())
            .into_par_iter()
            .all(|block| stored.lines(block).is_ok()),
    };
    is_same && is_whole()
}
