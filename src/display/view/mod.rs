//! Views: how radiance of any size becomes light on a screen, which ends at 1.
//!
//! A new view is a file with its `apply`, and an entry in [`View`].

mod reinhard;
mod srgb;

use std::fmt;
use std::str::FromStr;

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

    /// Exposed linear Rec.709 radiance, infinities included, to linear light from 0 to 1, of the
    /// screen's white.
    pub fn apply(self, rgb: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Srgb => srgb::apply(rgb),
            Self::Reinhard => reinhard::apply(rgb),
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
    fn views_end_at_0_and_1_and_never_fall() {
        for view in View::ALL {
            let mut last = 0.0;
            for i in -40..=40 {
                let x = f64::from(i).exp2();
                let [light, below, infinite] = view.apply([x, -x, f64::INFINITY]);
                assert!((last..=1.0).contains(&light), "{view} of {x} is {light}");
                assert_eq!((below, infinite), (0.0, 1.0), "{view}");
                last = light;
            }
        }
    }
}
