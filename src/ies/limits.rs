//! How much a luminaire file may ask for.

/// The size of the largest file that is read, in bytes. The largest that were seen have 1.3 MB.
pub(super) const LARGEST_FILE: usize = 16 << 20;

/// The most angles of one kind: 1801 are a tenth of a degree apart over 180°.
pub(super) const MOST_ANGLES: usize = 1 << 16;

/// The largest intensity, in cd. The sun has 3e27.
pub(super) const MOST_CANDELA: f64 = 1e30;

/// The least peak that is light at all, in cd: fluxes and ratios are exact above it.
pub(super) const LEAST_CANDELA: f64 = 1e-30;

/// Negative intensities down to this part of the largest are noise of the measurement.
pub(super) const NOISE_PER_MILLE: u32 = 10;

/// How far an angle may be from the end of its range to be meant to be there, in degrees.
pub(super) const ANGLE_TOLERANCE: f64 = 1e-3;

/// The longest line that LM-63-2002 allows, in bytes.
pub(super) const LONGEST_LINE: usize = 256;
