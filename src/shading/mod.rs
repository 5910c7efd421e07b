//! L3 and L5 to L9: how much light each point sends to the viewer.

mod power;
mod reflectance;

pub use power::power;
use reflectance::Geometry;

use crate::units::Radiance;
use crate::visibility::{SurfacePoint, Visibility};
use crate::world::{Lobes, Plan, World};

/// The light of a batch of points, and what it took.
#[derive(Clone, Debug, Default)]
pub struct Shaded {
    /// L_o of each point, in the order of the points.
    pub radiance: Vec<Radiance>,
    /// How many points were asked for a light's visibility (L4).
    pub shadow_rays: u64,
    /// How often a light was at the very point it should light, d = 0, and added nothing.
    pub singular: u64,
}

/// One term of L9 without its color: what a light that is seen does at a point, by geometry alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// The point, by its place in the batch.
    pub point: usize,
    /// An index into [`World::lights`].
    pub light: usize,
    /// An index into [`World::materials`].
    pub material: usize,
    /// The cosine term of each lobe over d², in m⁻², at most [`f64::MAX`]: times I · k it is the
    /// radiance that the lobe sends to the viewer.
    pub geometry: Lobes<f64>,
}

/// L9: L_o(ω_o) = Σ_s L_i^s(p) r(ω_i^s, ω_o) V^s(p), light by light over a batch of points.
pub fn radiance(
    world: &World,
    plan: &Plan,
    visibility: &Visibility<'_>,
    points: &[SurfacePoint],
) -> Shaded {
    radiance_and_terms(world, plan, visibility, points, |_| {})
}

/// [`radiance`], where `each` is told of every term of the sum that is not hidden (L4): light by
/// light, point by point within. The sum itself is the same to the bit.
pub fn radiance_and_terms(
    world: &World,
    plan: &Plan,
    visibility: &Visibility<'_>,
    points: &[SurfacePoint],
    mut each: impl FnMut(Term),
) -> Shaded {
    let mut shaded = Shaded {
        radiance: vec![Radiance::BLACK; points.len()],
        ..Shaded::default()
    };
    let material_of = |point: &SurfacePoint| world.objects()[point.object as usize].material;
    for (index, light) in world.lights().iter().enumerate() {
        let transport = world.transport(index);
        let geometry: Vec<Geometry> = points
            .iter()
            .map(|point| {
                let material = &world.materials()[material_of(point)].value;
                Geometry::new(point, light.value.position, material, plan)
            })
            .collect();
        let facing: Vec<bool> = geometry.iter().map(Geometry::faces_light).collect();
        let lit = visibility.lit(light.value.position, points, &facing);
        for (place, point) in points.iter().enumerate() {
            if let (Geometry::Lit(factors), true) = (geometry[place], lit[place]) {
                let material = material_of(point);
                each(Term {
                    point: place,
                    light: index,
                    material,
                    geometry: factors,
                });
                let reflected = transport[material];
                shaded.radiance[place] += reflected.diffuse.radiance(factors.diffuse)
                    + reflected.specular.radiance(factors.specular);
            }
        }
        shaded.shadow_rays += facing.iter().filter(|&&facing| facing).count() as u64;
        let at_light = geometry
            .iter()
            .filter(|geometry| matches!(geometry, Geometry::Singular));
        shaded.singular += at_light.count() as u64;
    }
    shaded
}
