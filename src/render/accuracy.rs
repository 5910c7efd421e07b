//! Rendering to an error: what is asked for, and what came of it.

use super::sampling::Sampler;
use crate::quadrature::Target;

/// The most samples of a pixel.
pub const MAX_SAMPLES: u32 = 65_536;

/// The least [`ErrorTarget::relative`]: what is exact to less than 24 bits is exact to this.
pub const MIN_RELATIVE_ERROR: f64 = 1e-6;

/// How exact each pixel is to be, instead of how many samples it takes.
///
/// With L the radiance that is rendered, in each of R, G and B, and L̄ the mean radiance over the square of the pixel, a
/// pixel meets the target where
///
/// |L − L̄| ≤ E max(L̄, floor),
///
/// and its alpha is within E of the part of the square that is covered. Where that is proven, the error is a bound;
/// elsewhere it is an estimate, from samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorTarget {
    /// E, from [`MIN_RELATIVE_ERROR`] to 1: 0.01 is one percent.
    pub relative: f64,
    /// The floor in cd/m²: what is darker may be off by as much as this may. `None` is a hundredth of the mean
    /// luminance of 64 × 64 points over the whole image, whatever part of it is rendered.
    pub floor: Option<f64>,
    /// The most samples of a pixel, 1 to [`MAX_SAMPLES`]. Default 4096.
    pub max_samples: u32,
}

impl ErrorTarget {
    /// Of a relative error, with everything else at its default.
    pub fn new(relative: f64) -> Self {
        Self {
            relative,
            floor: None,
            max_samples: 4096,
        }
    }

    /// Whether all is in range.
    pub(super) fn is_valid(&self) -> bool {
        (MIN_RELATIVE_ERROR..=1.0).contains(&self.relative)
            && (1..=MAX_SAMPLES).contains(&self.max_samples)
            && self
                .floor
                .is_none_or(|floor| floor > 0.0 && floor.is_finite())
    }
}

/// How exact the pixels of a render are. Errors are relative: the largest of R, G and B over the larger of the pixel's
/// radiance and the floor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorCounts {
    /// The floor in cd/m².
    pub floor: f64,
    /// Pixels without an edge, whose error has a bound.
    pub smooth: u64,
    /// Pixels that were integrated across their edges, whose error has a bound.
    pub edges: u64,
    /// Pixels whose error is estimated.
    pub estimated: u64,
    /// Of these, those that the most samples have not brought to the target.
    pub unmet: u64,
    /// The largest bound.
    pub worst_bound: f64,
    /// The largest estimate.
    pub worst_estimate: f64,
}

impl ErrorCounts {
    /// Pixels whose error has a bound.
    pub fn bound(&self) -> u64 {
        self.smooth + self.edges
    }

    #[inline]
    pub(super) fn and(self, other: Self) -> Self {
        Self {
            floor: self.floor.max(other.floor),
            smooth: self.smooth + other.smooth,
            edges: self.edges + other.edges,
            estimated: self.estimated + other.estimated,
            unmet: self.unmet + other.unmet,
            worst_bound: self.worst_bound.max(other.worst_bound),
            worst_estimate: self.worst_estimate.max(other.worst_estimate),
        }
    }

    /// What the header of a file says of it, by name.
    pub(super) fn provenance(&self) -> impl Iterator<Item = (String, String)> {
        [
            ("bound_pixels", self.bound().to_string()),
            ("error_floor", self.floor.to_string()),
            ("estimated_pixels", self.estimated.to_string()),
            ("unmet_pixels", self.unmet.to_string()),
            ("worst_bound", self.worst_bound.to_string()),
            ("worst_estimate", self.worst_estimate.to_string()),
        ]
        .into_iter()
        .map(|(name, value)| (name.to_owned(), value))
    }
}

/// What all tiles that are rendered to an error have in common.
#[derive(Debug)]
pub(super) struct Goal {
    /// Its floor is 0 where the image is black at all points that were asked.
    pub(super) target: Target,
    pub(super) max_samples: u32,
    /// Whether nothing is made of samples but R, G, B and A.
    pub(super) is_plain: bool,
    /// Of 1, 2, 4 and 8 samples along each side.
    pub(super) grids: [Sampler; 4],
}

impl Goal {
    pub(super) fn new(target: &ErrorTarget, floor: f64, is_plain: bool) -> Self {
        Self {
            target: Target {
                relative: target.relative,
                floor,
                most_side: most_side(target.max_samples),
            },
            max_samples: target.max_samples,
            is_plain,
            grids: [1, 2, 4, 8].map(Sampler::grid),
        }
    }
}

/// The most samples along the side of a smooth pixel that may have so many.
fn most_side(max_samples: u32) -> u32 {
    let sides = [8, 4, 2, 1];
    let fits = |side: &u32| side * side <= max_samples;
    sides.into_iter().find(fits).unwrap_or(1)
}
