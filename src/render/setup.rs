//! What all tiles of a render have in common.

use std::sync::Arc;

use super::accuracy::Goal;
use super::layer_sums::RequestedLayers;
use super::sampling::Sampler;
use crate::camera::Camera;
use crate::simd::SimdLevel;
use crate::visibility::{MetLeaves, Visibility};
use crate::world::World;

/// What all tiles have in common.
#[derive(Clone, Copy)]
pub(super) struct Setup<'w> {
    pub(super) world: &'w World,
    pub(super) camera: &'w Camera,
    pub(super) visibility: &'w Visibility<'w>,
    /// Whether it is counted what visibility takes, and where it is noted which leaves are met.
    pub(super) counts_work: bool,
    pub(super) met_leaves: Option<&'w Arc<MetLeaves>>,
    pub(super) simd: SimdLevel,
    /// [`Options::cuts_areas`](super::Options::cuts_areas)
    pub(super) cuts_areas: bool,
    /// Where all samples of a pixel are, of which a pass takes a range.
    pub(super) sampler: &'w Sampler,
    pub(super) layers: Option<&'w RequestedLayers<'w>>,
    pub(super) sums: Kept,
    /// How much radiance in cd/m² branches of light that are not followed may bring to a sample together, where an error is
    /// asked for; else 0.
    pub(super) left_out: f64,
    /// Which part that is of the brightest radiance of the world.
    pub(super) negligible: f64,
    /// Where pixels are rendered to an error, which.
    pub(super) goal: Option<&'w Goal>,
}

/// What is kept of samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Kept {
    /// Their sums.
    #[default]
    Sums,
    /// [`Statistics`](super::statistics::Statistics) beside these.
    SumsAndStatistics,
}
