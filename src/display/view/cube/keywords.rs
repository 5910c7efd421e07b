//! The words of `.cube` files, and how large they may be.

pub(super) const TITLE: &str = "TITLE";
pub(super) const SIZE_1D: &str = "LUT_1D_SIZE";
pub(super) const SIZE_3D: &str = "LUT_3D_SIZE";
pub(super) const DOMAIN_LEAST: &str = "DOMAIN_MIN";
pub(super) const DOMAIN_MOST: &str = "DOMAIN_MAX";
pub(super) const RANGE_1D: &str = "LUT_1D_INPUT_RANGE";
pub(super) const RANGE_3D: &str = "LUT_3D_INPUT_RANGE";

/// The keywords that are read.
pub(super) const KEYWORDS: [&str; 7] = [
    TITLE,
    SIZE_1D,
    SIZE_3D,
    DOMAIN_LEAST,
    DOMAIN_MOST,
    RANGE_1D,
    RANGE_3D,
];

/// What Resolve says of tables whose codes are not those of the full range.
pub(super) const VIDEO: [&str; 2] = ["LUT_IN_VIDEO_RANGE", "LUT_OUT_VIDEO_RANGE"];

/// The most entries along an axis, by Adobe's specification: of one dimension, and of three.
pub(super) const MOST_1D: u64 = 65_536;
pub(super) const MOST_3D: u64 = 256;

/// The shortest line of three numbers, `0 0 0`, with its end.
pub(super) const SHORTEST_LINE: u64 = 6;

/// The largest table, with numbers of 40 characters, fits.
pub(super) const LONGEST_FILE: u64 = 1 << 31;

/// Adobe's specification has 250 bytes; comments of others are longer.
pub(super) const LONGEST_LINE: usize = 1 << 14;
