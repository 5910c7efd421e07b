//! What a render took and met.

use super::accuracy::ErrorCounts;
use crate::visibility::Work;

/// The radiance in cd/m² that a screen shows as its white, where no exposure is given.
pub const SCREEN_WHITE: f32 = 1.0;

/// Above this a pixel is brighter than the screen: it would have a code of 256 or more of 255.
pub(super) const BEYOND_WHITE: f32 = 1.009 * SCREEN_WHITE;

/// What a render took and met. The same for any number of threads, and all but [`work`](Self::work) for any
/// instructions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// Camera rays.
    pub primary_rays: u64,
    /// Rays that have left a mirror or glass.
    pub secondary_rays: u64,
    /// Of these, those that were not followed: beyond the largest depth, or as next to nothing of them arrives.
    pub cut_rays: u64,
    /// How much of their radiance would have arrived at most in any sample: what is left out is below that times the
    /// brightest radiance of the scene.
    pub cut: f64,
    /// A bound of what is left out of any pixel by that, in cd/m².
    pub depth_rest: f64,
    /// Of the camera rays, those that hit an object.
    pub hits: u64,
    /// Points asked for a light's visibility: those that the light is not below.
    pub shadow_rays: u64,
    /// Of these, those that the light reaches.
    pub lit: u64,
    /// Times that a light was exactly on the point it should light (d = 0) and added nothing.
    pub singular: u64,
    /// Channels of pixels, those of layers among them, whose value is beyond ± the largest f32, and
    /// became that.
    pub clamped: u64,
    /// The largest R, G or B of any pixel in cd/m², at least 0.
    pub brightest: f32,
    /// Pixels with R, G or B above [`SCREEN_WHITE`] by so much that a code of 8 bits
    /// cannot show it, 0.9 %.
    pub beyond_white: u64,
    /// How exact the pixels are, where they are rendered to an error.
    pub errors: ErrorCounts,
    /// What it took to find out what rays meet; nothing unless
    /// [`Options::counts_work`](super::Options::counts_work) asks.
    pub work: Work,
}

impl Counts {
    #[inline]
    pub(super) fn and(self, other: Self) -> Self {
        Self {
            primary_rays: self.primary_rays + other.primary_rays,
            secondary_rays: self.secondary_rays + other.secondary_rays,
            cut_rays: self.cut_rays + other.cut_rays,
            cut: self.cut.max(other.cut),
            depth_rest: self.depth_rest.max(other.depth_rest),
            hits: self.hits + other.hits,
            shadow_rays: self.shadow_rays + other.shadow_rays,
            lit: self.lit + other.lit,
            singular: self.singular + other.singular,
            clamped: self.clamped + other.clamped,
            brightest: self.brightest.max(other.brightest),
            beyond_white: self.beyond_white + other.beyond_white,
            errors: self.errors.and(other.errors),
            work: self.work.and(other.work),
        }
    }

    /// What the header of a file says of rays that were not followed, by name.
    pub(super) fn depth_provenance(&self) -> impl Iterator<Item = (String, String)> {
        [
            ("cut_rays", self.cut_rays.to_string()),
            ("depth_rest", self.depth_rest.to_string()),
        ]
        .into_iter()
        .map(|(name, value)| (name.to_owned(), value))
    }

    /// Adds a pixel that has no samples.
    pub(super) fn add_pixel(&mut self, [r, g, b, _]: [f32; 4], clamped: u64) {
        let largest = r.max(g).max(b);
        self.clamped += clamped;
        self.brightest = self.brightest.max(largest);
        self.beyond_white += u64::from(largest > BEYOND_WHITE);
    }
}
