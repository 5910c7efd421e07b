//! How bright anything in a world may be: what bounds the light of rays that are not followed.

use std::f64::consts::{PI, TAU};

use super::{Light, Lobes, Material, Shape, World};
use crate::math::{DVec3, Point};

/// So many pairs of a light and a triangle are looked at one by one; of more, boxes around meshes.
const MOST_PAIRS: usize = 100_000_000;

impl World {
    /// A bound of the radiance in cd/m² that anything sends to any viewer, in any channel: of the background, lights that
    /// are seen, and Σ I r̂/d̂² over the lights, with r̂ the largest reflectance and d̂ the distance from the light to the
    /// nearest surface. Infinite where a light is on a surface, or its mesh has a box around it.
    pub(crate) fn brightest(&self) -> f64 {
        let background = largest(self.background().0.0);
        let mut seen: f64 = background;
        for object in &self.objects {
            if let Some(light) = object
                .emits
                .and_then(|light| self.lights[light].value.area())
            {
                seen = seen.max(largest(light.luminance()));
            }
        }
        let lights = 0..self.lights.len();
        seen.max(lights.map(|light| self.brightest_by(light)).sum())
    }

    /// The most that one light has any surface send.
    fn brightest_by(&self, light: usize) -> f64 {
        let mut most: f64 = 0.0;
        for material in self.used_materials() {
            let Lobes { diffuse, specular } = self.reflected(light, material);
            let [diffuse, specular] = [diffuse.0.0, specular.0.0].map(largest);
            most = most.max(match &self.lights[light].value {
                // ∫ cos dω is at most π, and that of a lobe at most 2π.
                Light::Area(area) => (diffuse * PI + specular * TAU) * area.over_area(),
                _ => diffuse + specular,
            });
        }
        match &self.lights[light].value {
            _ if most == 0.0 => 0.0,
            Light::Area(_) | Light::Sun(_) => most,
            light => {
                let distance = self.distance_to_surfaces(light.position());
                most / (distance * distance)
            }
        }
    }

    /// From a point to the nearest surface that lights light.
    fn distance_to_surfaces(&self, point: Point) -> f64 {
        let pairs = self.triangles.len().saturating_mul(self.lights.len());
        let mut nearest = f64::INFINITY;
        for object in &self.objects {
            let material: &Material = &self.materials[object.material].value;
            let is_lit = material.reflectance() != Material::BLACK.reflectance();
            if !is_lit || object.emits.is_some() {
                continue;
            }
            let distance = match object.shape {
                Shape::Sphere(index) => {
                    let sphere = &self.spheres[index];
                    (point.from(sphere.center).length() - sphere.radius).abs()
                }
                Shape::Plane(index) => {
                    let plane = &self.planes[index];
                    plane.normal.get().dot(point.from(plane.point)).abs()
                }
                Shape::Disk(index) => {
                    let disk = &self.disks[index];
                    disk.normal.get().dot(point.from(disk.center)).abs()
                }
                Shape::Mesh(index) => {
                    let triangles = self.triangles.meshes()[index].triangles.clone();
                    let corners = triangles.map(|triangle| self.triangles.vertices(triangle));
                    if pairs <= MOST_PAIRS {
                        corners.fold(f64::INFINITY, |nearest, corners| {
                            nearest.min(distance_to_triangle(point.0, corners))
                        })
                    } else {
                        let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
                        for corner in corners.flatten() {
                            (least, most) = (least.min(corner), most.max(corner));
                        }
                        (point.0 - point.0.clamp(least, most)).length()
                    }
                }
            };
            nearest = nearest.min(distance);
        }
        nearest
    }
}

/// The largest channel, of a color outside of the working space by its size.
fn largest(rgb: [f64; 3]) -> f64 {
    rgb.iter()
        .fold(0.0, |most, channel| f64::max(most, channel.abs()))
}

/// From a point to a triangle: to its plane where the foot is inside, else to its nearest edge.
fn distance_to_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let mut is_inside = true;
    let mut to_edges = f64::INFINITY;
    for (from, to) in [(a, b), (b, c), (c, a)] {
        let edge = to - from;
        let way = point - from;
        is_inside &= normal.dot(edge.cross(way)) >= 0.0;
        let part = (way.dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
        to_edges = to_edges.min((way - edge * part).length());
    }
    if is_inside {
        normal.dot(point - a).abs() / normal.length()
    } else {
        to_edges
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_to_a_triangle() {
        let corners = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 3.0];
        for (point, expected) in [
            (DVec3::new(1.0, 1.0, 2.0), 2.0),
            (DVec3::new(1.0, 1.0, -2.0), 2.0),
            (DVec3::new(-3.0, 0.0, 4.0), 5.0),
            (DVec3::new(2.0, -3.0, 4.0), 5.0),
            // Beside the long edge, whose middle is 2.5 from the corner.
            (DVec3::new(2.0 + 0.6, 1.5 + 0.8, 0.0), 1.0),
        ] {
            let distance = distance_to_triangle(point, corners);
            assert!((distance - expected).abs() < 1e-15, "{point}: {distance}");
        }
    }
}
