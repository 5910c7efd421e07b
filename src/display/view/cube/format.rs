//! Words and limits of `.cube` files.

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

/// The largest table, with numbers of 40 characters, fits.
pub(super) const LONGEST_FILE: u64 = 1 << 31;

/// Adobe's specification has 250 bytes; comments of others are longer.
pub(super) const LONGEST_LINE: usize = 1 << 14;
