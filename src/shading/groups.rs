//! What the points of a packet are made of: lobes, and weights over reflectances.

use super::power::whole_exponent;
use crate::optics;
use crate::simd::{LANES, ones};
use crate::world::material::Model;
use crate::world::{Delta, Material, World};

/// The specular lobe of a material.
#[derive(Clone, Copy, Debug)]
pub(super) enum Gloss {
    /// There is none.
    None,
    /// cosⁿ of L7, with the cosine of the incident light as a factor or without.
    Lobe {
        shininess: Shininess,
        has_cosine: bool,
    },
}

/// n of L7.
#[derive(Clone, Copy, Debug)]
pub(super) enum Shininess {
    /// So that its powers come by multiplication.
    Whole(u32),
    Any(f64),
}

/// R of a coat at a cosine between the normal and the viewer.
#[inline]
pub(crate) fn coat_reflectance(reflectance: f64, schlick: bool, cos_viewer: f64) -> f64 {
    if schlick {
        // An interpolated normal may face away from the viewer.
        optics::schlick(reflectance, cos_viewer.abs().min(1.0))
    } else {
        reflectance
    }
}

impl Gloss {
    #[inline]
    pub(super) fn of(material: &Material) -> Self {
        if !material.is_specular() {
            return Self::None;
        }
        let shininess = material.shininess();
        Self::Lobe {
            shininess: match whole_exponent(shininess) {
                Some(exponent) => Shininess::Whole(exponent),
                None => Shininess::Any(shininess),
            },
            has_cosine: match material.model() {
                Model::Phong => false,
                Model::NormalizedPhong => true,
            },
        }
    }
}

/// The points of a packet with one specular lobe.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    /// One bit for each.
    pub(super) members: u32,
    pub(super) gloss: Gloss,
}

/// The points of a packet that reflect with one reflectance.
///
/// A point has a share in each of its reflectances, and what it reflects is linear in their weights:
/// Σ weight · k. Most have one reflectance, their material's, of weight 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Share {
    /// One bit for each point.
    pub(crate) members: u32,
    /// An index into [`World::materials`].
    pub(crate) reflectance: u32,
    /// The weight at each point of the packet; `None` is 1 at all of them, which multiplies nothing. Where it
    /// is 0, the reflectance is left out.
    pub(crate) weights: Option<[f64; LANES]>,
    /// The number of the filter that its light is seen through; 0 is none.
    pub(crate) filter: u16,
}

/// The points of a packet, material by material.
#[derive(Clone, Debug, Default)]
pub(super) struct Groups {
    groups: Vec<Group>,
    shares: Vec<Share>,
    /// The material and the filter of each group while they are taken.
    kinds: Vec<(u32, u16)>,
}

impl Groups {
    /// Forgets all points.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.groups.clear();
        self.shares.clear();
    }

    /// Takes the points with a bit, and forgets all others.
    #[inline(always)]
    pub(super) fn take(
        &mut self,
        world: &World,
        materials: &[u32],
        filters: Option<&[u16]>,
        bits: u32,
        are_uniform: bool,
    ) {
        if are_uniform && filters.is_none() {
            self.take_one(world, materials[bits.trailing_zeros() as usize], bits);
            return;
        }
        self.clear();
        self.kinds.clear();
        for lane in ones(bits) {
            let filter = filters.map_or(0, |filters| filters[lane]);
            let kind = (materials[lane], filter);
            let known = self.kinds.iter().position(|&known| known == kind);
            match known {
                Some(place) => {
                    self.groups[place].members |= 1 << lane;
                    self.shares[place].members |= 1 << lane;
                }
                None => {
                    self.kinds.push(kind);
                    self.push(world, kind, 1 << lane);
                }
            }
        }
    }

    /// Has the lobes of points under a coat count 1 − R times, R of each.
    #[inline(never)]
    pub(super) fn coat(&mut self, world: &World, cos_viewer: &[f64]) {
        for share in &mut self.shares {
            if let Some(Delta::Coat {
                reflectance,
                schlick,
            }) = world.delta(share.reflectance as usize)
            {
                let mut weights = [0.0; LANES];
                for lane in ones(share.members) {
                    weights[lane] =
                        1.0 - coat_reflectance(*reflectance, *schlick, cos_viewer[lane]);
                }
                share.weights = Some(weights);
            }
        }
    }

    /// Takes points of one material. What one packet is made of, the next one mostly is.
    #[inline(always)]
    fn take_one(&mut self, world: &World, material: u32, members: u32) {
        if let ([group], [share]) = (&mut self.groups[..], &mut self.shares[..])
            && share.reflectance == material
            && share.weights.is_none()
            && share.filter == 0
        {
            (group.members, share.members) = (members, members);
        } else {
            self.clear();
            self.push(world, (material, 0), members);
        }
    }

    /// A material: one reflectance of weight 1.
    #[inline(always)]
    fn push(&mut self, world: &World, (material, filter): (u32, u16), members: u32) {
        self.groups.push(Group {
            members,
            gloss: Gloss::of(&world.materials()[material as usize].value),
        });
        self.shares.push(Share {
            members,
            reflectance: material,
            weights: None,
            filter,
        });
    }

    #[inline(always)]
    pub(super) fn get(&self) -> &[Group] {
        &self.groups
    }

    #[inline(always)]
    pub(super) fn shares(&self) -> &[Share] {
        &self.shares
    }

    /// Lets the points have shares in these reflectances instead.
    #[cfg(test)]
    pub(super) fn replace(&mut self, shares: Vec<Share>) {
        self.shares = shares;
    }
}
