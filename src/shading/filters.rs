//! What light loses of its spectrum on its way through mirrors and glass: filters, one for each point that is seen so.

use crate::spectrum::Spectrum;
use crate::units::ReflectedIntensity;
use crate::visibility::BATCH;
use crate::world::light::AreaLight;
use crate::world::{Chain, Lobes, World};

/// The filters of a batch of points, each a factor of the light at each wavelength.
#[derive(Clone, Debug, Default)]
pub(crate) struct Filters {
    spectra: Vec<Spectrum>,
    /// Of each that is made by colored mirrors alone, which of those that are known it is.
    chains: Vec<Option<Chain>>,
    /// Which of them each point has, plus 1; 0 is none, which leaves all light.
    of_points: Option<Box<[u16; BATCH]>>,
}

impl Filters {
    /// Forgets all of them.
    pub(crate) fn clear(&mut self) {
        self.spectra.clear();
        self.chains.clear();
        self.of_points = None;
    }

    /// Gives a point the last filter that was made.
    pub(crate) fn push(&mut self, point: usize, filter: Spectrum) {
        self.spectra.push(filter);
        self.chains.push(None);
        self.share(point, self.spectra.len() as u16);
    }

    /// Gives a point the filter that a chain of colored mirrors is.
    pub(crate) fn push_chain(&mut self, point: usize, chain: Chain, filter: &Spectrum) {
        self.push(point, filter.clone());
        self.chains[self.spectra.len() - 1] = Some(chain);
    }

    /// Gives a point a filter that is there, by its number.
    pub(crate) fn share(&mut self, point: usize, number: u16) {
        let of_points = self.of_points.get_or_insert_with(|| Box::new([0; BATCH]));
        of_points[point] = number;
    }

    /// Whether any point has one.
    #[inline]
    pub(crate) fn has_any(&self) -> bool {
        self.of_points.is_some()
    }

    /// The number of a point's filter; 0 is none.
    #[inline]
    pub(crate) fn number(&self, point: usize) -> u16 {
        self.of_points
            .as_ref()
            .map_or(0, |of_points| of_points[point])
    }

    /// Those of the points from `first` on, where any point has one.
    #[inline(always)]
    pub(super) fn numbers(&self, first: usize) -> Option<&[u16]> {
        self.of_points.as_ref().map(|of_points| &of_points[first..])
    }

    /// A filter by its number.
    #[inline]
    pub(crate) fn get(&self, number: u16) -> Option<&Spectrum> {
        self.spectra.get(usize::from(number).checked_sub(1)?)
    }

    /// The chain of colored mirrors that a filter is, if it is one that is known.
    #[inline]
    pub(crate) fn chain(&self, number: u16) -> Option<Chain> {
        *self.chains.get(usize::from(number).checked_sub(1)?)?
    }

    /// I · k of a light on a material, as it is seen through a filter; `None` without one.
    #[inline]
    pub(super) fn reflected(
        &self,
        world: &World,
        number: u16,
        light: usize,
        material: usize,
    ) -> Option<Lobes<ReflectedIntensity>> {
        let filter = self.get(number)?;
        Some(match self.chain(number) {
            Some(chain) => world.reflected_along(light, material, chain),
            None => world.reflected_through(light, material, filter),
        })
    }

    /// The background's R, G and B as they are seen through a filter; `None` without one.
    pub(super) fn background(&self, world: &World, number: u16) -> Option<[f64; 3]> {
        let filter = self.get(number)?;
        let background = match self.chain(number) {
            Some(chain) => world.background_along(chain),
            None => world.background_through(filter),
        };
        Some(background.0.0)
    }

    /// The luminance of a light with an area as it is seen through a filter.
    pub(super) fn luminance(
        &self,
        world: &World,
        number: u16,
        (index, light): (usize, &AreaLight),
    ) -> [f64; 3] {
        match (self.get(number), self.chain(number)) {
            (None, _) => light.luminance(),
            (Some(_), Some(chain)) => world.luminance_along(index, light, chain),
            (Some(filter), None) => world.luminance_through(index, light, filter),
        }
    }
}
