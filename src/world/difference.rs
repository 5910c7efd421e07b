//! How differently a scene looks if light is carried in another way.

use super::{Lobes, World};
use crate::color::Primaries;
use crate::color::difference::{Lab, delta_e_2000};
use crate::math::DVec3;
use crate::units::{ReflectedIntensity, Rgb};

/// Color differences ΔE00 (CIEDE2000) between two worlds, of all materials under one light.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// The light, an index into [`World::lights`].
    pub light: usize,
    /// How many materials.
    pub materials: usize,
    /// The mean over the materials.
    pub mean: f64,
    /// The largest.
    pub worst: f64,
    /// Of this material, an index into [`World::materials`].
    pub worst_material: usize,
}

/// Color differences between two worlds of one scene, carried as RGB and spectrally, light by
/// light, over the materials that objects have.
///
/// The colors compared are the light as the diffuse lobe reflects it (of a material without one,
/// the specular lobe), scaled so that a white surface would have Y = 1, seen by an eye that is
/// adapted to the light.
pub fn differences(one: &World, other: &World) -> Vec<Difference> {
    let space = one.color_space().primaries();
    let used = one.used_materials();
    let lights = one.lights().iter().enumerate();
    lights
        .filter_map(|(light, entry)| {
            let white = xyz(entry.value.intensity().0, &space);
            if white.y <= 0.0 {
                return None;
            }
            // A light so saturated that it has no Z cannot be adapted to.
            let adapted = if white.min_element() > 0.0 {
                white
            } else {
                space.white_xyz() * white.y
            };
            let of_materials: Vec<(usize, f64)> = used
                .iter()
                .filter_map(|&material| {
                    let factors = one.materials()[material].value.factors();
                    let one = visible_lobe(one.reflected(light, material), factors)?;
                    let other = visible_lobe(other.reflected(light, material), factors)?;
                    let lab = |rgb| Lab::from_xyz(xyz(rgb, &space), adapted);
                    Some((material, delta_e_2000(lab(one), lab(other))))
                })
                .collect();
            let (worst_material, worst) = of_materials
                .iter()
                .copied()
                .max_by(|a, b| a.1.total_cmp(&b.1))?;
            let sum: f64 = of_materials.iter().map(|(_, difference)| difference).sum();
            Some(Difference {
                light,
                materials: of_materials.len(),
                mean: sum / of_materials.len() as f64,
                worst,
                worst_material,
            })
        })
        .collect()
}

/// I · k of the lobe that is seen, without the factor of its model.
fn visible_lobe(lobes: Lobes<ReflectedIntensity>, factors: Lobes<f64>) -> Option<Rgb> {
    [
        (lobes.diffuse, factors.diffuse),
        (lobes.specular, factors.specular),
    ]
    .into_iter()
    .find(|(lobe, _)| lobe.0 != Rgb::BLACK)
    .map(|(lobe, factor)| Rgb(lobe.0.0.map(|channel| channel / factor)))
}

fn xyz(rgb: Rgb, space: &Primaries) -> DVec3 {
    space.to_xyz() * DVec3::from_array(rgb.0)
}
