//! What light loses from colored mirror to colored mirror: products of reflectances, each made once.
//!
//! Factors commute. What is left of light depends on how often each color has reflected it, and not on the order: after
//! at most D reflections by S colors there are only C(S + D, D) products, 165 of three colors and eight reflections. So
//! a chain of reflections is a number, and R, G and B of a light on a material at its end are looked up.

use std::collections::HashMap;
use std::sync::OnceLock;

use super::colorimetry::SpectralReflectance;
use super::delta::{Delta, Tint};
use super::light::AreaLight;
use super::spectra::{Columns, Spectra};
use super::{Lobes, World};
use crate::memory::{self, OutOfMemory};
use crate::spectrum::Spectrum;
use crate::units::{Radiance, ReflectedIntensity, Rgb};

/// How often light was reflected by each color of a world: an index into all that are known, of which the first is
/// never.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Chain(u32);

impl Chain {
    /// Its place among all, of which that of no reflection is 0.
    #[inline]
    pub(crate) fn number(self) -> usize {
        self.0 as usize
    }
}

/// The color of a mirror: an index into those of a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ChainColor(u16);

/// The most products that are kept: 30 MB. Longer chains than these leave room for take a spectrum for each ray.
const MOST_PRODUCTS: u64 = 1 << 19;

/// The most chains, whose spectra take 15 MB.
const MOST_CHAINS: u64 = 1 << 12;

/// The chains of a world's colored mirrors.
#[derive(Clone, Debug)]
pub(crate) struct Chains {
    /// The color of each material that has one.
    of_materials: Vec<Option<ChainColor>>,
    colors: Vec<Spectrum>,
    /// The largest value of each.
    peaks: Vec<f64>,
    /// The most reflections of a chain that is known.
    depth: u32,
    /// Chain by chain how often each color has reflected.
    counts: Vec<u16>,
    /// Chain by chain the chain after one more reflection by each color, as far as they are known.
    next: Vec<Option<Chain>>,
    spectra: Vec<OnceLock<Spectrum>>,
    columns: Columns,
    lights: usize,
    /// Chain by chain, light by light, column by column within.
    products: Vec<OnceLock<Lobes<ReflectedIntensity>>>,
    /// Chain by chain: R, G and B of each light and of the background.
    seen: Vec<OnceLock<[f64; 3]>>,
}

impl Chains {
    /// Those of at most `max_depth` reflections, as far as there is room for their products; `None` where no mirror
    /// colors light.
    ///
    /// # Errors
    /// If there is not enough memory.
    pub(super) fn new(
        spectra: &Spectra,
        deltas: &[Option<Delta>],
        max_depth: u32,
    ) -> Result<Option<Self>, OutOfMemory> {
        let mut colors: Vec<Spectrum> = Vec::new();
        let mut color_of = |delta: &Option<Delta>| {
            let color = constant_color(delta.as_ref()?)?;
            let known = colors.iter().position(|known| known == color);
            let place = known.unwrap_or_else(|| {
                colors.push(color.clone());
                colors.len() - 1
            });
            // What does not fit is more than there are chains for.
            u16::try_from(place).ok().map(ChainColor)
        };
        let of_materials = deltas.iter().zip(&spectra.used);
        let of_materials: Vec<_> = of_materials
            .map(|(delta, is_used)| if *is_used { color_of(delta) } else { None })
            .collect();
        let columns = Columns::of(spectra);
        let lights = spectra.lights.len();
        let of_one = lights as u64 * (columns.used as u64 + 1) + 1;
        let most = (MOST_PRODUCTS / of_one).min(MOST_CHAINS);
        let depth = deepest(colors.len() as u64, max_depth, most);
        if depth == 0 {
            return Ok(None);
        }
        let (counts, next) = enumerate(colors.len(), depth);
        let chains = next.len() / colors.len();
        let (mut products, mut seen) = (Vec::new(), Vec::new());
        memory::reserve(&mut products, chains * lights * columns.used)?;
        products.resize_with(chains * lights * columns.used, OnceLock::new);
        memory::reserve(&mut seen, chains * (lights + 1))?;
        seen.resize_with(chains * (lights + 1), OnceLock::new);
        Ok(Some(Self {
            of_materials,
            depth,
            peaks: colors.iter().map(|color| color.peak().0).collect(),
            colors,
            counts,
            next,
            spectra: vec![OnceLock::new(); chains],
            columns,
            lights,
            products,
            seen,
        }))
    }

    /// The color of a material that reflects the same share of each wavelength at all angles.
    #[inline]
    pub(crate) fn color(&self, material: usize) -> Option<ChainColor> {
        self.of_materials[material]
    }

    /// The reflectance of a color.
    pub(crate) fn reflectance(&self, ChainColor(color): ChainColor) -> &Spectrum {
        &self.colors[usize::from(color)]
    }

    /// The largest value of that.
    pub(crate) fn peak(&self, ChainColor(color): ChainColor) -> f64 {
        self.peaks[usize::from(color)]
    }

    /// The chain after one more reflection, if it is known.
    #[inline]
    pub(crate) fn after(
        &self,
        chain: Option<Chain>,
        ChainColor(color): ChainColor,
    ) -> Option<Chain> {
        let Chain(chain) = chain.unwrap_or(Chain(0));
        self.next[chain as usize * self.colors.len() + usize::from(color)]
    }

    /// How many there are, that of no reflection included.
    pub(crate) fn count(&self) -> usize {
        self.spectra.len()
    }

    /// Whether all chains of at most so many reflections are known.
    pub(crate) fn has_all(&self, max_depth: u32) -> bool {
        self.depth == max_depth
    }

    /// What all but that of no reflection leave of each wavelength, in order.
    pub(crate) fn longer(&self) -> impl Iterator<Item = &Spectrum> {
        (1..self.count()).map(|chain| self.spectrum(Chain(chain as u32)))
    }

    /// What is left of each wavelength: Π ρ_j^(n_j) over the colors, in the order of the file.
    pub(crate) fn spectrum(&self, Chain(chain): Chain) -> &Spectrum {
        self.spectra[chain as usize].get_or_init(|| {
            let counts = &self.counts[chain as usize * self.colors.len()..][..self.colors.len()];
            let mut product = Spectrum::constant(1.0);
            for (color, &count) in self.colors.iter().zip(counts) {
                for _ in 0..count {
                    product = product.times(color);
                }
            }
            product
        })
    }

    /// I · k of a light on a material, after the reflections of a chain.
    #[inline]
    pub(super) fn product(
        &self,
        spectra: &Spectra,
        chain: Chain,
        light: usize,
        material: usize,
    ) -> Lobes<ReflectedIntensity> {
        let Some(column) = self.columns.of_materials[material] else {
            return Lobes::default();
        };
        let Chain(row) = chain;
        let place = (row as usize * self.lights + light) * self.columns.used + column;
        *self.products[place]
            .get_or_init(|| spectra.filtered_product(light, material, self.spectrum(chain)))
    }

    /// R, G, B of a light's intensity after the reflections of a chain; of the background, `None`, its radiance.
    pub(super) fn seen(&self, spectra: &Spectra, chain: Chain, light: Option<usize>) -> [f64; 3] {
        let Chain(row) = chain;
        let place = row as usize * (self.lights + 1) + light.unwrap_or(self.lights);
        *self.seen[place].get_or_init(|| {
            let spectrum = light.map_or(&spectra.background, |light| spectra.light(light));
            spectra.filtered(spectrum, self.spectrum(chain))
        })
    }
}

impl World {
    /// What colored mirrors leave of light, where it is carried spectrally and one of them does not depend on the angle.
    #[inline]
    pub(crate) fn chains(&self) -> Option<&Chains> {
        self.chains.as_ref()
    }

    /// [`World::reflected`] of light that goes along a chain of colored mirrors on its way to the viewer.
    #[inline]
    pub(crate) fn reflected_along(
        &self,
        light: usize,
        material: usize,
        chain: Chain,
    ) -> Lobes<ReflectedIntensity> {
        let (spectra, chains) = self.spectra_and_chains();
        chains.product(spectra, chain, light, material)
    }

    /// The background as it is seen along a chain of colored mirrors.
    pub(crate) fn background_along(&self, chain: Chain) -> Radiance {
        let (spectra, chains) = self.spectra_and_chains();
        Radiance(Rgb(chains.seen(spectra, chain, None)))
    }

    /// The luminance of a light with an area as it is seen along a chain of colored mirrors.
    pub(crate) fn luminance_along(&self, light: usize, area: &AreaLight, chain: Chain) -> [f64; 3] {
        let (spectra, chains) = self.spectra_and_chains();
        let intensity = chains.seen(spectra, chain, Some(light));
        intensity.map(|channel| channel * area.over_area())
    }

    fn spectra_and_chains(&self) -> (&Spectra, &Chains) {
        let both = self.spectra.as_ref().zip(self.chains.as_ref());
        both.expect("chains are of spectra")
    }
}

/// The reflectance of a mirror that colors light, the same at all angles.
fn constant_color(delta: &Delta) -> Option<&Spectrum> {
    match delta {
        Delta::Mirror(Tint {
            reflectance: Some(SpectralReflectance::Spectrum(reflectance)),
            schlick: false,
            ..
        }) => Some(reflectance),
        _ => None,
    }
}

/// The largest number of reflections, at most `max_depth`, whose chains by so many colors are at most `most`.
fn deepest(colors: u64, max_depth: u32, most: u64) -> u32 {
    if colors == 0 {
        return 0;
    }
    let mut count: u64 = 1;
    for depth in 0..max_depth {
        // C(S + D + 1, D + 1) = C(S + D, D) · (S + D + 1) / (D + 1)
        let deeper = u64::from(depth) + 1;
        count = count.saturating_mul(colors + deeper) / deeper;
        if count > most {
            return depth;
        }
    }
    max_depth
}

/// All multisets of at most so many colors: how often each color is in them, and which each becomes by one color more.
fn enumerate(colors: usize, depth: u32) -> (Vec<u16>, Vec<Option<Chain>>) {
    let mut known: HashMap<Vec<u16>, Chain> = HashMap::new();
    let mut chains = vec![vec![0_u16; colors]];
    let mut next = Vec::new();
    known.insert(chains[0].clone(), Chain(0));
    let mut place = 0;
    while place < chains.len() {
        let length: u32 = chains[place].iter().map(|&count| u32::from(count)).sum();
        for color in 0..colors {
            if length == depth {
                next.push(None);
                continue;
            }
            let mut longer = chains[place].clone();
            longer[color] += 1;
            let chain = *known.entry(longer).or_insert_with_key(|longer| {
                chains.push(longer.clone());
                Chain(chains.len() as u32 - 1)
            });
            next.push(Some(chain));
        }
        place += 1;
    }
    (chains.concat(), next)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// C(S + D, D), as many as are made.
    #[test]
    fn chains_are_multisets() {
        for (colors, depth, expected) in [(1, 8, 9), (3, 4, 35), (3, 8, 165), (4, 8, 495)] {
            let (counts, next) = enumerate(colors, depth);
            assert_eq!(next.len(), expected * colors);
            assert_eq!(counts.len(), expected * colors);
            assert_eq!(deepest(colors as u64, depth, expected as u64), depth);
            assert_eq!(
                deepest(colors as u64, depth, expected as u64 - 1),
                depth - 1
            );
        }
        assert_eq!(deepest(1, 1000, MOST_CHAINS), 1000);
        assert_eq!(deepest(0, 8, MOST_CHAINS), 0);
        assert_eq!(deepest(u64::MAX / 2, 8, MOST_CHAINS), 0);
    }

    /// The order of reflections does not matter.
    #[test]
    fn factors_commute() {
        let colors = 3;
        let (counts, next) = enumerate(colors, 4);
        let after = |order: [usize; 4]| {
            order.iter().fold(Chain(0), |Chain(chain), color| {
                next[chain as usize * colors + color].unwrap()
            })
        };
        assert_eq!(after([0, 1, 2, 1]), after([1, 1, 0, 2]));
        assert_ne!(after([0, 1, 2, 1]), after([0, 0, 2, 1]));
        let Chain(chain) = after([0, 1, 2, 1]);
        assert_eq!(counts[chain as usize * colors..][..colors], [1, 2, 1]);
        assert!(
            next[chain as usize * colors..][..colors]
                .iter()
                .all(Option::is_none)
        );
    }
}
