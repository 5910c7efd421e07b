//! The reflectances of a world by which the light of each light is kept apart, so that it can be given another spectrum.
//!
//! L9 is linear in ∫ I(λ) k(λ) m(λ) dλ, and a world has few different k(λ): a factor times 1 at all wavelengths, or
//! times one of its curves. So what a light of any spectrum s(λ) makes of a pixel is
//!
//! L = g_flat ∫ s m dλ + Σ_i g_i ∫ s ρ_i m dλ, g = Σ_samples geometry × factor × I_v / N
//!
//! with I_v the luminous intensity of the light in cd, and s(λ) that of 1 cd. What a chain of colored mirrors shows is of the
//! curves ρ_i · Π ρ_mirror, of which there are few, too: one for each chain and i.

use std::collections::HashMap;

use super::chains::{Chain, Chains};
use super::colorimetry::SpectralReflectance;
use super::spectra::{ScaledReflectance, Spectra};
use super::{Lobes, World};
use crate::spectrum::Spectrum;

/// The different reflectances of a world: flat ones, and its curves; and these as colored mirrors show them.
#[derive(Clone, Debug)]
pub struct Reflectances<'w> {
    curves: Vec<&'w Spectrum>,
    of_material: Vec<Lobes<ReflectanceTerm>>,
    chains: Option<&'w Chains>,
}

/// One lobe's k(λ).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReflectanceTerm {
    /// 0 is 1 at all wavelengths, i the curve i − 1.
    pub reflectance: usize,
    /// What it is multiplied by, in sr⁻¹.
    pub factor: f64,
}

impl<'w> Reflectances<'w> {
    /// Of the materials of a world, which are seen directly or along the chains of its colored mirrors.
    pub(crate) fn new(spectra: &'w Spectra, chains: Option<&'w Chains>) -> Self {
        let mut curves: Vec<&Spectrum> = Vec::new();
        let mut places: HashMap<Vec<u64>, usize> = HashMap::new();
        let mut term = |lobe: &'w ScaledReflectance| match &lobe.reflectance {
            SpectralReflectance::Flat(value) => ReflectanceTerm {
                reflectance: 0,
                factor: value * lobe.factor,
            },
            SpectralReflectance::Spectrum(curve) => {
                let bits = curve.values().map(f64::to_bits).to_vec();
                let reflectance = *places.entry(bits).or_insert_with(|| {
                    curves.push(curve);
                    curves.len()
                });
                ReflectanceTerm {
                    reflectance,
                    factor: lobe.factor,
                }
            }
        };
        let materials = spectra.materials.iter().zip(&spectra.used);
        let of_material = materials.map(|(material, is_used)| {
            if *is_used {
                Lobes {
                    diffuse: term(&material.diffuse),
                    specular: term(&material.specular),
                }
            } else {
                Lobes::default()
            }
        });
        Self {
            of_material: of_material.collect(),
            curves,
            chains,
        }
    }

    /// How many there are, the flat one included, along all chains.
    pub fn count(&self) -> usize {
        self.of_chain() * self.chains.map_or(1, Chains::count)
    }

    /// How many there are along one chain.
    fn of_chain(&self) -> usize {
        1 + self.curves.len()
    }

    /// The place of a reflectance that is seen along a chain.
    #[inline]
    pub(crate) fn along(&self, chain: Option<Chain>, reflectance: usize) -> usize {
        chain.map_or(0, Chain::number) * self.of_chain() + reflectance
    }

    /// Their names in channels.
    pub fn names(&self) -> impl Iterator<Item = String> + use<> {
        let curves = (1..self.count()).map(|curve| curve.to_string());
        std::iter::once("flat".to_owned()).chain(curves)
    }

    /// k(λ) of both lobes of a material.
    pub fn of_material(&self, material: usize) -> Lobes<ReflectanceTerm> {
        self.of_material[material]
    }

    /// The observer and the curves, as JSON.
    pub fn description(&self, world: &World) -> String {
        let observer = world
            .spectra()
            .map(|spectra| spectra.colorimetry().observer().name());
        let mut curves: Vec<Vec<f64>> = Vec::new();
        let mut add = |curve: &Spectrum| curves.push(curve.values().to_vec());
        self.curves.iter().copied().for_each(&mut add);
        for chain in self.chains.into_iter().flat_map(Chains::longer) {
            add(chain);
            for curve in &self.curves {
                add(&curve.times(chain));
            }
        }
        serde_json::json!({ "observer": observer, "curves": curves }).to_string()
    }
}
