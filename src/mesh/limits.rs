//! How much of a mesh file is read, whatever it says.

/// The memory that loading may take beside the file's bytes, as a multiple of their number.
///
/// Polygons of very short indices are the only legal content that outgrows it (a corner of two
/// bytes becomes a triangle of twelve or more), and they do so only past the first
/// bytes that any file may take; meshes from real programs stay below 3.
pub(super) const TIMES_FILE_SIZE: usize = 8;

/// The most corners of one polygon. Bounds the memory for cutting it to a few megabytes.
pub(super) const MAX_CORNERS: usize = 65_536;

/// The longest header that is read, in bytes. It keeps what it says in memory.
pub(super) const LONGEST_HEADER: usize = 1 << 20;
