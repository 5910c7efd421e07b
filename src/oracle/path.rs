//! What is seen along a ray over perfectly smooth surfaces: all ways, reflected and refracted, to their ends.
//!
//! L(ray) is the background, or what is at the point that is hit. Lobes are lit by all lights (L9); of a smooth surface
//! L = R L(reflected) + T L(beyond). Both rays begin at the point, at a depth of one more; from a point at the largest
//! depth none does. What there is at the end of a way counts by the product of all R and T on it.

use super::Oracle;
use super::camera::Ray;
use super::components::Components;
use super::fresnel;
use super::hit::Hit;
use super::light::Light;
use super::lighting::ideal_reflection;
use super::media::Inside;
use super::occlusion::{Segment, Side};
use super::outcome::Event;
use super::smooth::{Glass, Smooth, of_metal};
use super::surface::Shape;
use super::vector::{WideVector, dot, length, negate, scale, subtract, widened};
use super::wide::{Real, Wide};

/// A ray, against the way of light.
struct Branch {
    ray: Ray,
    depth: u32,
    /// The surface that it leaves.
    leaves: Option<usize>,
    inside: Inside,
    /// By what counts what is seen along it.
    weight: Components,
    /// The place of its wavelength, where each goes its own way.
    wavelength: Option<usize>,
    came: Option<Came>,
}

/// Where a ray comes from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Came {
    /// The number of the vertex that it leaves.
    pub(super) vertex: usize,
    /// Which of the ways from there it is.
    pub(super) way: usize,
    pub(super) event: Event,
}

/// The end of a ray.
pub(super) struct Vertex<'v> {
    /// Which one it is, in the order in which they are found.
    pub(super) number: usize,
    /// `None` of the primary ray.
    pub(super) came: Option<Came>,
    /// `None` where nothing is hit.
    pub(super) hit: Option<&'v Hit>,
    /// By what counts what is here.
    pub(super) weight: &'v Components,
    /// What is seen here but for what other rays see: of lobes under a coat with the part that it lets through.
    pub(super) seen: &'v Light,
    /// All ways from here.
    pub(super) ways: &'v [Way],
    /// Whether they are followed.
    pub(super) goes_on: bool,
    pub(super) wavelength: Option<usize>,
}

/// A way from a smooth surface.
pub(super) struct Way {
    pub(super) event: Event,
    /// R or T
    pub(super) factor: Components,
    /// `None` where it would lead to the wrong side of the surface itself: a smooth mesh is not where its normals are.
    pub(super) direction: Option<WideVector>,
    pub(super) inside: Inside,
    /// The wavelength that goes here, where each goes its own way.
    pub(super) wavelength: Option<usize>,
}

/// What a primary ray sees.
pub(super) struct Seen {
    pub(super) light: Light,
    /// Whether the primary ray hits anything.
    pub(super) is_covered: bool,
}

impl Oracle {
    /// L at a point of the image.
    pub(super) fn seen(&self, px: f64, py: f64) -> Seen {
        let mut seen = Seen {
            light: Light::only(self.background.zero()),
            is_covered: false,
        };
        self.walk(&self.camera.primary_ray(px, py), |vertex| {
            seen.is_covered |= vertex.hit.is_some();
            seen.light = seen.light.plus(&vertex.seen.times(vertex.weight));
        });
        seen
    }

    /// Follows a primary ray to all ends.
    pub(super) fn walk(&self, primary: &Ray, mut visit: impl FnMut(&Vertex<'_>)) {
        let mut open = vec![Branch {
            ray: *primary,
            depth: 0,
            leaves: None,
            inside: self.media.around(&self.surfaces, primary.origin),
            weight: Components::uniform(1.0, self.background.0.len()),
            wavelength: None,
            came: None,
        }];
        let mut number = 0;
        while let Some(branch) = open.pop() {
            let hit = match branch.leaves {
                None => self.nearest(&branch.ray),
                Some(surface) => self.nearest_from(&branch.ray, surface),
            };
            let distance = hit
                .as_ref()
                .map_or(f64::INFINITY, |hit| hit.distance.narrow());
            let weight = match self.glass_of(&branch.inside) {
                None => branch.weight.clone(),
                Some(glass) => branch.weight.times(&glass.left_after(distance)),
            };
            let ways = hit
                .as_ref()
                .map_or_else(Vec::new, |hit| self.ways(hit, &branch));
            let seen = self.seen_at(hit.as_ref());
            let goes_on = branch.depth < self.max_depth;
            visit(&Vertex {
                number,
                came: branch.came,
                hit: hit.as_ref(),
                weight: &weight,
                seen: &seen,
                ways: &ways,
                goes_on,
                wavelength: branch.wavelength,
            });
            if let Some(hit) = hit.filter(|_| goes_on) {
                // The first of them is followed first.
                for (place, way) in ways.into_iter().enumerate().rev() {
                    let mut weight = weight.times(&way.factor);
                    if let Some(wavelength) = way.wavelength {
                        weight = weight.only(wavelength);
                    }
                    let Some(direction) = way.direction.filter(|_| !weight.is_zero()) else {
                        continue;
                    };
                    open.push(Branch {
                        ray: Ray {
                            origin: hit.position,
                            direction,
                        },
                        depth: branch.depth + 1,
                        leaves: Some(hit.surface),
                        inside: way.inside,
                        weight,
                        wavelength: way.wavelength,
                        came: Some(Came {
                            vertex: number,
                            way: place,
                            event: way.event,
                        }),
                    });
                }
            }
            number += 1;
        }
    }

    /// What is seen where a ray ends but for what other rays see.
    fn seen_at(&self, hit: Option<&Hit>) -> Light {
        let Some(hit) = hit else {
            return Light::only(self.background.clone());
        };
        match self.smooth(hit) {
            None => self.sum_over_lights(hit),
            Some(Smooth::Coat(coat)) => {
                let through = coat.at(facing(hit).1).rest();
                self.sum_over_lights(hit).times(&through)
            }
            Some(
                Smooth::Mirror(_) | Smooth::Metal { .. } | Smooth::Glass(_) | Smooth::Pane { .. },
            ) => Light::only(self.background.zero()),
        }
    }

    /// The smooth material where a ray has hit.
    pub(super) fn smooth(&self, hit: &Hit) -> Option<&Smooth> {
        self.object(hit.surface).smooth.as_deref()
    }

    /// The glass where all these are; `None` in air.
    fn glass_of(&self, inside: &Inside) -> Option<&Glass> {
        self.glass(self.media.innermost(inside))
    }

    fn glass(&self, object: Option<usize>) -> Option<&Glass> {
        match self.objects[object?].smooth.as_deref()? {
            Smooth::Glass(glass) => Some(glass),
            Smooth::Mirror(_) | Smooth::Coat(_) | Smooth::Metal { .. } | Smooth::Pane { .. } => {
                None
            }
        }
    }

    /// The ways from where a ray has hit; none but from a smooth surface.
    fn ways(&self, hit: &Hit, branch: &Branch) -> Vec<Way> {
        let Some(smooth) = self.smooth(hit) else {
            return Vec::new();
        };
        let (normal, cos) = facing(hit);
        let inside = || branch.inside.clone();
        let wavelength = branch.wavelength;
        let reflection = |factor| Way {
            event: Event::Reflected,
            factor,
            direction: reflected(hit, normal),
            inside: inside(),
            wavelength,
        };
        match smooth {
            Smooth::Mirror(mirror) | Smooth::Coat(mirror) => vec![reflection(mirror.at(cos))],
            Smooth::Metal { n, k } => vec![reflection(of_metal(n, k, cos, &self.palette))],
            Smooth::Pane { n } => {
                let [reflectance, transmittance] =
                    fresnel::pane(cos, *n).map(|part| self.everywhere(part));
                let passing = Way {
                    event: Event::Passed,
                    factor: transmittance,
                    direction: Some(branch.ray.direction),
                    inside: inside(),
                    wavelength,
                };
                vec![reflection(reflectance), passing]
            }
            Smooth::Glass(_) => self.ways_of_glass(hit, branch),
        }
    }

    /// L = F L(reflected) + (1 − F)(n_i/n_t)² L(refracted), where the medium changes.
    fn ways_of_glass(&self, hit: &Hit, branch: &Branch) -> Vec<Way> {
        let object = self.surfaces[hit.surface].object;
        let with = branch.inside.with(object);
        let without = branch.inside.without(object);
        let enters = hit.is_in_front != self.media.is_turned(object);
        let [before, after] = if enters {
            [branch.inside.clone(), with]
        } else {
            [with, without]
        };
        let media = [&before, &after].map(|inside| self.media.innermost(inside));
        if media[0] == media[1] {
            return vec![Way {
                event: Event::Unchanged,
                factor: self.everywhere(1.0),
                direction: Some(branch.ray.direction),
                inside: after,
                wavelength: branch.wavelength,
            }];
        }
        let glasses = media.map(|medium| self.glass(medium));
        let parts = glasses.iter().flatten().any(|glass| glass.is_dispersive());
        let wavelengths: Vec<Option<usize>> = match branch.wavelength {
            None if parts => (0..self.background.0.len()).map(Some).collect(),
            wavelength => vec![wavelength],
        };
        let (normal, cos) = facing(hit);
        let mut ways = Vec::new();
        for wavelength in wavelengths {
            let [n_i, n_t] = glasses.map(|glass| {
                let n = glass.map_or(1.0, |glass| glass.index(wavelength));
                Wide::from(n)
            });
            let eta = n_t / n_i;
            let reflectance = fresnel::dielectric(cos, eta);
            let cos_refracted = fresnel::cos_refracted(cos, eta);
            ways.push(Way {
                event: match cos_refracted {
                    Some(_) => Event::Reflected,
                    None => Event::TotallyReflected,
                },
                factor: self.everywhere(reflectance.narrow()),
                direction: reflected(hit, normal),
                inside: before.clone(),
                wavelength,
            });
            if let Some(cos_refracted) = cos_refracted {
                let rest = (Wide::from(1.0) - reflectance) / (eta * eta);
                let incident = branch.ray.direction;
                let direction = fresnel::refracted(incident, normal, eta, [cos, cos_refracted]);
                let is_beyond = dot(direction, hit.geometric_normal) < Wide::from(0.0);
                ways.push(Way {
                    event: Event::Refracted,
                    factor: self.everywhere(rest.narrow()),
                    direction: is_beyond.then_some(direction),
                    inside: after.clone(),
                    wavelength,
                });
            }
        }
        ways
    }

    /// The same for all components.
    fn everywhere(&self, factor: f64) -> Components {
        Components::uniform(factor, self.background.0.len())
    }

    /// L2 for a ray that leaves a surface: of those that its start is on it meets the other side of spheres alone.
    fn nearest_from(&self, ray: &Ray, leaves: usize) -> Option<Hit> {
        let start = Segment {
            from: ray.origin,
            to: ray.at(Wide::from(1.0)),
            magnitude: length(ray.origin).narrow() + self.surfaces[leaves].shape.magnitude(),
            reference: widened(self.reference),
        };
        self.nearest_by(ray, 0..self.surfaces.len(), |index| {
            let surface = &self.surfaces[index];
            if !surface.may_meet(ray) {
                return None;
            }
            let magnitude = surface.shape.magnitude();
            let is_left = index == leaves;
            match &surface.shape {
                Shape::Sphere { center, radius } => {
                    let on_it = || start.sides_of_sphere(*center, *radius, magnitude).0 == Side::On;
                    if !is_left && !on_it() {
                        return surface.intersect(ray);
                    }
                    // ‖o + t ω − c‖ = ‖o − c‖
                    let from_center = subtract(ray.origin, *center);
                    let t = dot(scale(from_center, Wide::from(-2.0)), ray.direction);
                    (t > Wide::from(0.0)).then_some(t)
                }
                Shape::Plane { point, normal }
                | Shape::Rectangle {
                    center: point,
                    normal,
                    ..
                }
                | Shape::Disk {
                    center: point,
                    normal,
                    ..
                }
                | Shape::Triangle {
                    vertices: [point, ..],
                    normal,
                    ..
                } => surface.intersect(ray).filter(|_| {
                    let (side, _) = start.sides_of_plane(*point, *normal, magnitude);
                    !is_left && side != Side::On
                }),
            }
        })
    }
}

/// n on the viewer's side, and c = |n·ω_o|.
pub(super) fn facing(hit: &Hit) -> (WideVector, Wide) {
    let (zero, one) = (Wide::from(0.0), Wide::from(1.0));
    let cos = dot(hit.normal, hit.to_viewer);
    let (normal, cos) = if cos < zero {
        (negate(hit.normal), -cos)
    } else {
        (hit.normal, cos)
    };
    (normal, if cos > one { one } else { cos })
}

/// The reflected direction (L6), if it leads away from the surface itself.
fn reflected(hit: &Hit, normal: WideVector) -> Option<WideVector> {
    let direction = ideal_reflection(normal, hit.to_viewer);
    let is_away = dot(direction, hit.geometric_normal) > Wide::from(0.0);
    is_away.then_some(direction)
}
