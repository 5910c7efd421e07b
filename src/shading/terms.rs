//! The terms of L9 as data: what the layers of an image are made of.

use super::groups::Share;
use crate::simd::ones;
use crate::visibility::{Column, PACKETS};
use crate::world::Lobes;

/// What a light does at the points of a batch; 0 at points that it does not reach.
#[derive(Clone, Debug)]
pub(crate) struct LightTerms {
    /// An index into [`World::lights`](crate::world::World::lights).
    pub(crate) light: usize,
    /// For each packet one bit for each point that it reaches.
    pub(crate) points: [u32; PACKETS],
    /// Of a light with an area how much each of them sees of it: the part of its illuminance that arrives, 0 to 1.
    pub(crate) seen: Option<Box<Column>>,
    /// Σ geometry × weight × I · k over the reflectances, in cd/m² per primary: the radiance that this light
    /// alone sends to the viewer. Only with [`Detail::has_radiance`].
    pub(crate) radiance: [Column; 3],
    /// The parts of it that the lobes send. Only with [`Detail::has_lobes`].
    pub(crate) lobes: Lobes<[Column; 3]>,
    /// The cosine term of each lobe over d² at each point, in m⁻², at most [`f64::MAX`]: times the weight of a
    /// reflectance and I · k it is the radiance that the lobe sends to the viewer. Only with
    /// [`Detail::has_geometry`].
    pub(crate) geometry: Lobes<Column>,
}

impl Default for LightTerms {
    fn default() -> Self {
        Self {
            light: 0,
            points: [0; PACKETS],
            seen: None,
            radiance: [Column::ZERO; 3],
            lobes: Lobes {
                diffuse: [Column::ZERO; 3],
                specular: [Column::ZERO; 3],
            },
            geometry: Lobes {
                diffuse: Column::ZERO,
                specular: Column::ZERO,
            },
        }
    }
}

/// What is told of a light beside its radiance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Detail {
    /// The radiance of the light.
    pub(crate) has_radiance: bool,
    /// The radiance of each lobe.
    pub(crate) has_lobes: bool,
    /// The geometry of both lobes.
    pub(crate) has_geometry: bool,
}

impl Share {
    /// Of a point of the packet.
    #[inline]
    pub(crate) fn weight(&self, lane: usize) -> f64 {
        match &self.weights {
            Some(weights) => weights[lane],
            None => 1.0,
        }
    }

    /// One bit for each point with a weight: what is of weight 0 is left out.
    pub(crate) fn weighted(&self) -> u32 {
        match &self.weights {
            Some(weights) => ones(self.members)
                .filter(|&lane| weights[lane] != 0.0)
                .fold(0, |bits, lane| bits | 1 << lane),
            None => self.members,
        }
    }
}
