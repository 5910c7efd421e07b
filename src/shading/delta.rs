//! What perfectly smooth surfaces make of a ray: where its reflection and its refraction go, and how much of the light
//! from there arrives.
//!
//! | material | L |
//! | --- | --- |
//! | mirror, metal | R L_r |
//! | coat | R L_r + (1 − R) L_lobes |
//! | glass | F L_r + (1 − F) (n_i/n_t)² L_t |
//! | pane | R L_r + T L along the ray |
//!
//! What leaves a flat surface by reflection is measured from the image of its eye in that mirror: so the image in a
//! plane mirror is that of the mirrored eye, to the bit where the mirrored numbers are exact.

use super::groups::coat_reflectance;
use crate::math::DVec3;
use crate::optics;
use crate::spectrum::{FIRST, Spectrum};
use crate::visibility::{Points, RayStart, object_and_triangle, vector};
use crate::world::colorimetry::SpectralReflectance;
use crate::world::delta::{Absorption, ComplexIndex, Glass, Tint};
use crate::world::geometry::area_vector;
use crate::world::{ChainColor, Delta, Media, Shape, World};

/// Which of the rays that leave a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Branch {
    Reflected,
    /// Refracted, or straight on.
    Transmitted,
    /// Refracted where the glass disperses light: this wavelength in nm.
    Dispersed(u16),
}

/// A ray before it meets a point, and what it has been through.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arriving {
    pub(crate) origin: DVec3,
    pub(crate) direction: DVec3,
    /// The bodies that it is inside of.
    pub(crate) media: Media,
    /// The wavelength in nm whose way it takes; 0 where it is that of all.
    pub(crate) nm: u16,
}

/// A ray that leaves a point.
#[derive(Clone, Debug)]
pub(crate) struct Leaving {
    pub(crate) origin: DVec3,
    pub(crate) direction: DVec3,
    pub(crate) start: RayStart,
    /// How much of its radiance arrives, per channel; where light is carried spectrally all three are the same.
    pub(crate) weight: [f64; 3],
    /// What of it arrives at each wavelength besides.
    pub(crate) filter: Option<Filter>,
    pub(crate) media: Media,
    pub(crate) nm: u16,
}

/// What arrives at each wavelength.
#[derive(Clone, Debug)]
pub(crate) enum Filter {
    /// The color of a mirror, one of [`World::chains`].
    Color(ChainColor),
    Spectrum(Spectrum),
}

impl Filter {
    /// The most that arrives of any wavelength.
    pub(crate) fn peak(&self, world: &World) -> f64 {
        match self {
            Self::Color(color) => world.chains().map_or(1.0, |chains| chains.peak(*color)),
            Self::Spectrum(spectrum) => spectrum.peak().0,
        }
    }
}

/// How much of the radiance arrives, before it is known whether light is carried spectrally.
#[derive(Clone, Copy)]
pub(super) enum Factor<'w> {
    Gray(f64),
    /// The color of a mirror.
    Color(ChainColor),
    Tinted(&'w Tint, f64),
    Metal(&'w ComplexIndex, f64),
    /// F of a boundary that disperses light, from one medium to another.
    Boundary {
        from: Option<&'w Glass>,
        to: Option<&'w Glass>,
        cos_incident: f64,
    },
}

/// Where the bodies are before and beyond a boundary.
struct Boundary {
    before: Media,
    beyond: Media,
}

/// t of a point of a ray.
#[inline]
pub(super) fn t_of(point: DVec3, origin: DVec3, direction: DVec3) -> f64 {
    (point - origin).dot(direction) / direction.length_squared()
}

/// A ray that leaves a point of a smooth surface; `None` where there is none.
pub(crate) fn leave(
    world: &World,
    points: &Points,
    slot: usize,
    arriving: &Arriving,
    branch: Branch,
) -> Option<Leaving> {
    let delta = world.delta(points.material[slot] as usize)?;
    let surface = Surface::new(world, points, slot);
    let cosine = surface.cos_viewer();
    let reflected = |factor| surface.reflected(world, arriving, arriving.media, factor);
    let straight = |factor, media| surface.straight(world, arriving, media, factor);
    match (delta, branch) {
        (Delta::Mirror(tint), Branch::Reflected) => {
            let material = points.material[slot] as usize;
            reflected(Factor::of_mirror(world, material, tint, cosine))
        }
        (Delta::Metal(index), Branch::Reflected) => reflected(Factor::Metal(index, cosine)),
        (
            Delta::Coat {
                reflectance,
                schlick,
            },
            Branch::Reflected,
        ) => reflected(Factor::Gray(coat_reflectance(
            *reflectance,
            *schlick,
            cosine,
        ))),
        (Delta::Pane { n }, Branch::Reflected) => {
            reflected(Factor::Gray(optics::pane(cosine, *n)[0]))
        }
        (Delta::Pane { n }, Branch::Transmitted) => {
            straight(Factor::Gray(optics::pane(cosine, *n)[1]), arriving.media)
        }
        (Delta::Glass(_), _) => {
            let object = points.object(slot);
            let Boundary { before, beyond } = surface.boundary(world, object, arriving)?;
            let [from, to] = [before, beyond].map(|media| body_of(world, media));
            if before.top() == beyond.top() {
                return match branch {
                    Branch::Transmitted => straight(Factor::Gray(1.0), beyond),
                    Branch::Reflected | Branch::Dispersed(_) => None,
                };
            }
            let disperses =
                |glass: Option<&Glass>| glass.is_some_and(|glass| glass.dispersion.is_some());
            let is_split = world.spectra().is_some() && (disperses(from) || disperses(to));
            let nm = match (is_split && arriving.nm == 0, branch) {
                (true, Branch::Reflected) => {
                    return surface.reflected(
                        world,
                        arriving,
                        before,
                        Factor::Boundary {
                            from,
                            to,
                            cos_incident: cosine,
                        },
                    );
                }
                (true, Branch::Transmitted) | (false, Branch::Dispersed(_)) => return None,
                (true, Branch::Dispersed(nm)) => nm,
                (false, Branch::Reflected | Branch::Transmitted) => arriving.nm,
            };
            let eta = index(to, nm) / index(from, nm);
            let reflectance = optics::dielectric(cosine, eta);
            if branch == Branch::Reflected {
                return surface.reflected(world, arriving, before, Factor::Gray(reflectance));
            }
            let mut leaving = surface.refracted(beyond, eta, 1.0 - reflectance)?;
            leaving.nm = nm;
            Some(leaving)
        }
        _ => None,
    }
}

/// What of the light that has gone so far through a medium is left: factors per channel, and where light is carried
/// spectrally a filter besides.
pub(crate) fn absorbed(
    world: &World,
    media: Media,
    distance: f64,
) -> Option<([f64; 3], Option<Spectrum>)> {
    let Absorption { rgb, spectrum } = body_of(world, media)?.absorption.as_ref()?;
    let left = |sigma: f64| {
        if sigma == 0.0 {
            1.0
        } else {
            optics::absorbed(sigma, distance)
        }
    };
    Some(match spectrum {
        None => (rgb.map(left), None),
        Some(SpectralReflectance::Flat(sigma)) => ([left(*sigma); 3], None),
        Some(SpectralReflectance::Spectrum(sigma)) => {
            let mut sigma = sigma.values().iter();
            let filter = Spectrum::from_fn(|_| left(sigma.next().copied().unwrap_or_default()));
            ([1.0; 3], Some(filter))
        }
    })
}

/// The glass that fills a place; `None` is air.
fn body_of(world: &World, media: Media) -> Option<&Glass> {
    let body = world.bodies()[media.top()? as usize];
    match world.delta(world.objects()[body.object as usize].material) {
        Some(Delta::Glass(glass)) => Some(glass),
        _ => None,
    }
}

/// The refractive index of a medium for a wavelength in nm; of all, 0, that at 587.6 nm.
fn index(glass: Option<&Glass>, nm: u16) -> f64 {
    match glass {
        None => 1.0,
        Some(glass) => match &glass.dispersion {
            Some(dispersion) if nm > 0 => dispersion.at(f64::from(nm)),
            Some(_) | None => glass.n,
        },
    }
}

/// How many times as much radiance as in air there may be inside of bodies: n², n the largest of all wavelengths.
pub(crate) fn most_in(world: &World, media: Media) -> f64 {
    let largest = |glass: &Glass| match &glass.dispersion {
        Some(dispersion) => dispersion.peak().0.max(glass.n),
        None => glass.n,
    };
    let n = body_of(world, media).map_or(1.0, largest);
    n * n
}

/// A point of a smooth surface.
pub(super) struct Surface {
    position: DVec3,
    error: f64,
    primitive: u64,
    to_viewer: DVec3,
    geometric_normal: DVec3,
    /// n of the cosines, towards the viewer.
    pub(super) normal: DVec3,
    /// n·q of the plane through the point.
    plane: f64,
    pub(super) is_flat: bool,
}

impl Surface {
    pub(super) fn new(world: &World, points: &Points, slot: usize) -> Self {
        let geometric_normal = vector(points.geometric_normals(), slot);
        let to_viewer = vector(&points.to_viewer, slot);
        let shading_normal = vector(points.shading_normals(), slot);
        // An interpolated normal may face away from the viewer.
        let normal = if shading_normal.dot(to_viewer) < 0.0 {
            -shading_normal
        } else {
            shading_normal
        };
        let shape = world.objects()[points.object(slot) as usize].shape;
        Self {
            position: vector(&points.position, slot),
            error: points.error[slot],
            primitive: points.primitive[slot],
            to_viewer,
            geometric_normal,
            normal,
            plane: points.plane(slot),
            is_flat: !matches!(shape, Shape::Sphere(_)) && normal == geometric_normal,
        }
    }

    fn cos_viewer(&self) -> f64 {
        self.normal.dot(self.to_viewer).min(1.0)
    }

    /// The start of a ray with that origin.
    fn start(&self, t: f64) -> RayStart {
        RayStart {
            t,
            position: self.position,
            error: self.error,
            primitive: self.primitive,
        }
    }

    fn t_of(&self, arriving: &Arriving) -> f64 {
        t_of(self.position, arriving.origin, arriving.direction)
    }

    /// The image of an eye in the plane of the surface.
    pub(super) fn image_of(&self, eye: DVec3) -> DVec3 {
        let height = self.normal.dot(eye) - self.plane;
        eye - self.normal * (2.0 * height)
    }

    /// L_r: of a flat surface from the image of the eye.
    fn reflected(
        &self,
        world: &World,
        arriving: &Arriving,
        media: Media,
        factor: Factor<'_>,
    ) -> Option<Leaving> {
        let direction = optics::reflected(-self.to_viewer, self.normal);
        // An interpolated normal may send it below the surface.
        if direction.dot(self.geometric_normal) <= 0.0 {
            return None;
        }
        let (ray, t) = if self.is_flat {
            let image = self.image_of(arriving.origin);
            let direction = optics::reflected(arriving.direction, self.normal);
            ([image, direction], self.t_of(arriving))
        } else {
            ([self.position, direction], 0.0)
        };
        self.leaving(world, ray, t, factor, (media, arriving.nm))
    }

    /// What is along the ray itself.
    fn straight(
        &self,
        world: &World,
        arriving: &Arriving,
        media: Media,
        factor: Factor<'_>,
    ) -> Option<Leaving> {
        let ray = [arriving.origin, arriving.direction];
        let t = self.t_of(arriving);
        self.leaving(world, ray, t, factor, (media, arriving.nm))
    }

    fn leaving(
        &self,
        world: &World,
        [origin, direction]: [DVec3; 2],
        t: f64,
        factor: Factor<'_>,
        (media, nm): (Media, u16),
    ) -> Option<Leaving> {
        let (weight, filter) = factor.apart(world)?;
        Some(Leaving {
            origin,
            direction,
            start: self.start(t),
            weight,
            filter,
            media,
            nm,
        })
    }

    fn refracted(&self, media: Media, eta: f64, transmittance: f64) -> Option<Leaving> {
        let direction = optics::refracted(-self.to_viewer, self.normal, eta)?;
        if transmittance == 0.0 || direction.dot(self.geometric_normal) >= 0.0 {
            return None;
        }
        Some(Leaving {
            origin: self.position,
            direction,
            start: self.start(0.0),
            // Radiance over n² is what stays.
            weight: [transmittance / (eta * eta); 3],
            filter: None,
            media,
            nm: 0,
        })
    }

    /// What is before a boundary of glass and what is beyond it.
    fn boundary(&self, world: &World, object: u32, arriving: &Arriving) -> Option<Boundary> {
        let rank = world.body_rank(object)?;
        let outwards = match world.objects()[object as usize].shape {
            Shape::Sphere(index) => self.position - world.spheres()[index].center.0,
            Shape::Mesh(_) => {
                let (_, triangle) = object_and_triangle(self.primitive);
                let normal = area_vector(world.triangles().vertices(triangle));
                if world.bodies()[rank as usize].is_inside_out {
                    -normal
                } else {
                    normal
                }
            }
            Shape::Plane(_) | Shape::Disk(_) => return None,
        };
        let with = arriving.media.with(rank);
        Some(if outwards.dot(self.geometric_normal) > 0.0 {
            Boundary {
                before: arriving.media.without(rank),
                beyond: with,
            }
        } else {
            Boundary {
                before: with,
                beyond: arriving.media.without(rank),
            }
        })
    }
}

impl<'w> Factor<'w> {
    pub(super) fn of_mirror(world: &World, material: usize, tint: &'w Tint, cosine: f64) -> Self {
        match world.chains().and_then(|chains| chains.color(material)) {
            Some(color) => Self::Color(color),
            None => Self::Tinted(tint, cosine),
        }
    }

    /// Its weight per channel, and its filter where light is carried spectrally; `None` where nothing arrives.
    pub(super) fn apart(&self, world: &World) -> Option<([f64; 3], Option<Filter>)> {
        let (weight, filter) = match *self {
            Self::Gray(weight) => ([weight; 3], None),
            Self::Color(color) => return Some(([1.0; 3], Some(Filter::Color(color)))),
            Self::Tinted(tint, cosine) => {
                let at = |r0: f64| {
                    if tint.schlick {
                        optics::schlick(r0, cosine)
                    } else {
                        r0
                    }
                };
                match &tint.reflectance {
                    None => (tint.rgb.map(at), None),
                    Some(SpectralReflectance::Flat(r0)) => ([at(*r0); 3], None),
                    Some(SpectralReflectance::Spectrum(r0)) => {
                        let mut r0 = r0.values().iter();
                        let value = |_| at(r0.next().copied().unwrap_or_default());
                        ([1.0; 3], Some(Spectrum::from_fn(value)))
                    }
                }
            }
            Self::Metal(index, cosine) => {
                let mut nk = index.n.values().iter().zip(index.k.values());
                let reflectance = Spectrum::from_fn(|_| {
                    let (&n, &k) = nk.next().unwrap_or((&1.0, &0.0));
                    optics::conductor(cosine, n, k)
                });
                match world.spectra() {
                    Some(_) => ([1.0; 3], Some(reflectance)),
                    None => (world.color_of_reflectance(&reflectance), None),
                }
            }
            Self::Boundary {
                from,
                to,
                cos_incident,
            } => {
                let at = |glass: Option<&Glass>, place: usize| match glass {
                    None => 1.0,
                    Some(glass) => glass
                        .dispersion
                        .as_ref()
                        .map_or(glass.n, |dispersion| dispersion.values()[place]),
                };
                let filter = Spectrum::from_fn(|nm| {
                    let place = (nm - f64::from(FIRST)) as usize;
                    optics::dielectric(cos_incident, at(to, place) / at(from, place))
                });
                ([1.0; 3], Some(filter))
            }
        };
        (weight != [0.0; 3]).then(|| (weight, filter.map(Filter::Spectrum)))
    }
}
