//! The terms of L9 as data: what the layers of an image are made of.

use super::groups::Share;
use crate::simd::{LANES, ones};
use crate::world::Lobes;

/// The terms of L9 of the points of one packet: geometry × weight × I · k for each light that reaches a
/// point and each reflectance that the point has.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Terms<'s> {
    /// The first point of the packet, by its place in the batch.
    pub(crate) first: usize,
    /// One bit for each point that is hit, whether any light reaches it or none.
    pub(crate) hit: u32,
    /// What the points reflect with.
    pub(crate) shares: &'s [Share],
    /// What each light does that reaches any of them, in the order of the sum.
    pub(crate) lights: &'s [LightTerms],
}

/// What a light does at the points of a packet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LightTerms {
    /// An index into [`World::lights`](crate::world::World::lights).
    pub(crate) light: usize,
    /// One bit for each point that it reaches; the numbers of others mean nothing.
    pub(crate) points: u32,
    /// The cosine term of each lobe over d² at each point, in m⁻², at most [`f64::MAX`]: times the weight of a
    /// reflectance and I · k it is the radiance that the lobe sends to the viewer.
    pub(crate) geometry: Lobes<[f64; LANES]>,
    /// Σ geometry × weight × I · k over the reflectances, in cd/m² per primary: the radiance that this light
    /// alone sends to the viewer.
    pub(crate) radiance: [[f64; LANES]; 3],
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
