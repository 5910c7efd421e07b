//! What light loses of its spectrum on its way through mirrors and glass: filters, one for each point that is seen so.

use crate::spectrum::Spectrum;
use crate::visibility::BATCH;

/// The filters of a batch of points, each a factor of the light at each wavelength.
#[derive(Clone, Debug, Default)]
pub(crate) struct Filters {
    spectra: Vec<Spectrum>,
    /// Which of them each point has, plus 1; 0 is none, which leaves all light.
    of_points: Option<Box<[u16; BATCH]>>,
}

impl Filters {
    /// Forgets all of them.
    pub(crate) fn clear(&mut self) {
        self.spectra.clear();
        self.of_points = None;
    }

    /// Gives a point the last filter that was made.
    pub(crate) fn push(&mut self, point: usize, filter: Spectrum) {
        self.spectra.push(filter);
        self.share(point, self.spectra.len() as u16);
    }

    /// Gives a point a filter that is there, by its number.
    pub(crate) fn share(&mut self, point: usize, number: u16) {
        let of_points = self.of_points.get_or_insert_with(|| Box::new([0; BATCH]));
        of_points[point] = number;
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
}
