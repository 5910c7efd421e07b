//! Views: how radiance from 0 to ∞ becomes what a screen shows.
//!
//! A view is a file with its transform, an entry in [`View`], and an arm of [`Rendering`].

mod coded;
mod cube;
mod false_color;
mod reinhard;
mod srgb;
mod viridis;

use std::fmt;
use std::str::FromStr;

pub use cube::{Cube, CubeError, CubeFault, CubeProblem};
pub use false_color::{BadRange, FalseColor, Measure};

use super::lanes::{Planes, transform};
use crate::simd::SimdLevel;

/// The views by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum View {
    /// As it is; what exceeds the screen's range clips.
    #[default]
    Srgb,
    /// x / (1 + x) per channel; nothing clips.
    Reinhard,
}

impl View {
    /// Every view, in the order of the documentation.
    pub const ALL: [Self; 2] = [Self::Srgb, Self::Reinhard];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Srgb => "srgb",
            Self::Reinhard => "reinhard",
        }
    }

    /// Whether light that is brighter than the screen is cut off.
    pub const fn clips(self) -> bool {
        match self {
            Self::Srgb => true,
            Self::Reinhard => false,
        }
    }
}

/// A view with what it computes once: from exposed linear Rec.709, R, G, B without a coverage multiplied, to
/// linear Rec.709 light, of which 1 is the screen's white. What is outside of the screen's range clips later.
pub(super) enum Rendering {
    Srgb(srgb::Clip),
    Reinhard(reinhard::Reinhard),
    /// A look-up table of the user's.
    #[expect(dead_code, reason = "no view of the command line makes it yet")]
    Cube(Cube),
    /// Luminance as colors.
    #[expect(dead_code, reason = "no view of the command line makes it yet")]
    FalseColor(false_color::Map),
}

impl Rendering {
    pub(super) fn new(view: View) -> Self {
        match view {
            View::Srgb => Self::Srgb(srgb::Clip),
            View::Reinhard => Self::Reinhard(reinhard::Reinhard),
        }
    }

    /// Of the first `count` colors.
    pub(super) fn apply(&self, level: SimdLevel, planes: &mut Planes, count: usize) {
        match self {
            Self::Srgb(view) => transform(level, view, planes, count),
            Self::Reinhard(view) => transform(level, view, planes, count),
            Self::Cube(view) => transform(level, view, planes, count),
            Self::FalseColor(view) => transform(level, view, planes, count),
        }
    }
}

impl fmt::Display for View {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is not that of a [`View`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown view `{0}`, expected {expected}", expected = View::ALL.map(View::name).join(", "))]
pub struct UnknownView(pub String);

impl FromStr for View {
    type Err = UnknownView;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|view| view.name() == name)
            .ok_or_else(|| UnknownView(name.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::lanes::PIECE;

    #[test]
    fn views_have_names() {
        for view in View::ALL {
            assert_eq!(view.name().parse(), Ok(view));
        }
        assert_eq!(
            "film".parse::<View>().unwrap_err().to_string(),
            "unknown view `film`, expected srgb, reinhard"
        );
    }

    #[test]
    fn grays_never_fall() {
        for view in View::ALL {
            let grays = std::array::from_fn(|i| (i as f64 / 4.0 - 32.0).exp2());
            let mut planes: Planes = [grays; 3];
            Rendering::new(view).apply(SimdLevel::default(), &mut planes, PIECE);
            assert!(planes.iter().all(|plane| plane.is_sorted()), "{view}");
            assert!(planes[0][0] >= 0.0, "{view}");
        }
    }
}
