//! How far the sizes in one scene may differ, so that 64-bit floats still tell where things are.

use glam::DVec3;

use super::{Builder, Reported, as_written};
use crate::math::Point;
use crate::printable::printable;
use crate::scene::{self, Object, Problem, Spanned};
use crate::world::World;

/// How many times larger a sphere or a triangle may be than what is seen of it is far away: its surface is rounded
/// by 1e-16 of its size, and the light that falls on it by some times as much.
const MOST_SIZES: f64 = 1e10;

/// How near a light may be to a plane or a triangle that it is not on, as a part of its distance from their point or
/// corner: the cosine there is rounded by 1e-16 of that over its height.
const LEAST_HEIGHT: f64 = 1e-11;

/// What the rounding of coordinates as written can make of a height 0, relative to them: such a light is on it.
const ON: f64 = 16.0 * f64::EPSILON;

/// A plane's own point is replaced by one near the scene where it is so many times further away.
const FAR_POINT: f64 = 1024.0;

/// a − b, and what rounding takes from it.
fn exact_difference(a: f64, b: f64) -> [f64; 2] {
    let difference = a - b;
    let of_b = a - difference;
    [difference, (a - (difference + of_b)) + (of_b - b)]
}

/// n·(a − b), to the last digits of f64 also where its terms cancel: exact differences and products, and their sum
/// with what rounding takes from it.
fn exact_height(n: DVec3, a: DVec3, b: DVec3) -> f64 {
    let (mut sum, mut rest) = (0.0, 0.0);
    let mut add = |term: f64| {
        let [total, lost] = exact_difference(sum, -term);
        sum = total;
        rest += lost;
    };
    for axis in 0..3 {
        let [difference, lost] = exact_difference(a[axis], b[axis]);
        let product = n[axis] * difference;
        add(product);
        add(n[axis].mul_add(difference, -product));
        add(n[axis] * lost);
    }
    sum + rest
}

/// What is rounding of n·v where components of a normal are so small beside its largest, 1, that they are roundings
/// of 0, as the cosine of 90° is.
fn of_zeros(n: DVec3, v: DVec3) -> f64 {
    let is_rounding = n.abs().cmplt(DVec3::splat(ON));
    (n * v)
        .abs()
        .dot(DVec3::select(is_rounding, DVec3::ONE, DVec3::ZERO))
}

impl Builder<'_> {
    /// Where a camera that moves is first: the numbers of a world do not depend on the frame that it is made for.
    fn eye(&self) -> DVec3 {
        let eye = || self.scene.camera.value.view().eye.value;
        DVec3::from_array(self.scene.anchor.map_or_else(eye, |anchor| anchor.eye))
    }

    /// From `eye` to `look_at`.
    fn view_length(&self) -> f64 {
        (self.eye() - self.anchor).length()
    }

    /// The point of a plane that is nearest to the anchor, where its own is so far away that the plane would be
    /// rounded with it.
    pub(super) fn near_point(&self, point: Point, written: [f64; 3], normal: [f64; 3]) -> Point {
        let n = DVec3::from_array(normal);
        // Of any length; at about 1 its square neither underflows nor overflows.
        let n = n / n.abs().max_element();
        let height = exact_height(n, DVec3::from_array(written), self.anchor);
        let nearest = n * (height / n.length_squared());
        let near = nearest.length() + self.view_length();
        if point.0.length() > FAR_POINT * near && nearest.is_finite() {
            Point(nearest)
        } else {
            point
        }
    }

    /// A sphere is not so large that 64-bit floats do not tell where its surface is.
    pub(super) fn check_radius(
        &mut self,
        center: Point,
        radius: f64,
        written: Spanned<f64>,
    ) -> Result<(), Reported> {
        let eye = self.eye() - self.anchor;
        let height = ((eye - center.0).length() - radius).abs();
        let most = MOST_SIZES * (height + self.view_length());
        // What is wrong with the camera is said elsewhere.
        if radius <= most || most.is_nan() {
            return Ok(());
        }
        let expected = format!(
            "at most {most:.1e}, 1e10 times as much as `eye` is away from it and from `look_at`: of a larger one \
             64-bit floats do not tell where its surface is; use a plane instead"
        );
        self.out_of_range("radius", written.span, as_written(radius), &expected);
        Err(Reported)
    }

    /// The same for the triangles that were added last, from the one with the number `first` on.
    pub(super) fn check_triangles(
        &mut self,
        world: &World,
        first: usize,
        key: &'static str,
        span: scene::Span,
    ) -> Result<(), Reported> {
        let triangles = &world.triangles;
        let (eye, view) = (self.eye() - self.anchor, self.view_length());
        let size = |v: &DVec3| v.abs().max_element();
        let limit = MOST_SIZES * view;
        let is_too_large = |&number: &usize| {
            let corners = triangles.vertices(number as u32);
            let largest = corners.iter().map(size).fold(0.0, f64::max);
            if largest <= limit {
                return false;
            }
            let [a, b, c] = corners;
            let beside = (a.min(b).min(c) - eye).max(eye - a.max(b).max(c));
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let height = normal.dot(eye - a).abs();
            largest > MOST_SIZES * (beside.max_element().max(height) + view)
        };
        if let Some(number) = (first..triangles.len()).find(is_too_large) {
            let corners = triangles.vertices(number as u32);
            let largest = corners.iter().map(size).fold(0.0, f64::max);
            let conflict = format!(
                "`{key}` has a corner {} away from `look_at`, expected at most 1e10 times as much as `eye` is away \
                 from it and from `look_at`: of a larger triangle 64-bit floats do not tell where it is; use a \
                 plane, or smaller triangles",
                as_written(largest)
            );
            self.report(span, Problem::Conflict(conflict));
            return Err(Reported);
        }
        Ok(())
    }

    /// No light is so near to a plane or a triangle, without being on it, that rounding decides how much arrives.
    pub(super) fn check_heights(&mut self) {
        let scene = self.scene;
        let (anchor, view) = (self.anchor, self.view_length());
        let lights = scene.lights.len();
        let flat = scene.objects.iter().filter_map(|entry| {
            let plane = match &entry.value {
                Object::Plane { point, normal, .. } => (point.value, normal.value, 0.0),
                Object::Triangle { vertices, .. } => {
                    let [a, b, c] = vertices.value.map(DVec3::from_array);
                    let normal = (b - a).cross(c - a);
                    let size = (b - a).length().max((c - a).length());
                    (a.to_array(), normal.to_array(), size)
                }
                Object::Sphere { .. } | Object::Mesh { .. } => return None,
            };
            Some((&entry.name, plane))
        });
        for (name, (point, normal, size)) in flat {
            let (point, normal) = (DVec3::from_array(point), DVec3::from_array(normal));
            let normal = normal / normal.abs().max_element();
            let normal_length = normal.length();
            for index in 0..lights {
                if self.has_enough() {
                    return;
                }
                let position = match &scene.lights[index].value {
                    scene::Light::Point { position, .. }
                    | scene::Light::Spot { position, .. }
                    | scene::Light::Ies { position, .. } => position,
                    // It has no place.
                    scene::Light::Sun { .. } => continue,
                    scene::Light::Area { .. } => todo!(),
                };
                let light = DVec3::from_array(position.value);
                let reach = (light - point).length();
                if size > 0.0 && reach > 2.0 * size {
                    continue;
                }
                let height = exact_height(normal, light, point) / normal_length;
                let least = LEAST_HEIGHT * reach.min((light - anchor).length() + view);
                // The normal of a triangle is itself rounded.
                let sizes = light.abs() + point.abs();
                let across = normal.abs().dot(sizes) / normal_length;
                let of_normal = if size > 0.0 { reach } else { 0.0 };
                let rounding = ON * (across + of_normal) + of_zeros(normal, light - point);
                if height.abs() >= least || height.abs() <= rounding {
                    continue;
                }
                // What is not finite is said elsewhere.
                if !height.is_finite() || !least.is_finite() {
                    continue;
                }
                let conflict = format!(
                    "`position` is {} from the plane of object `{}`, expected 0, where it gives no light to it, \
                     or at least {:.1e}, 1e-11 of its distance from the point of that plane: nearer by, \
                     64-bit floats do not tell how much light arrives",
                    as_written(height.abs()),
                    printable(name),
                    least
                );
                self.entry = Some(super::Entry::Named("light", &scene.lights[index].name));
                self.report(position.span, Problem::Conflict(conflict));
                self.entry = None;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cosine_of_a_right_angle_is_rounding() {
        let (sine, cosine) = std::f64::consts::FRAC_PI_2.sin_cos();
        let light = DVec3::new(0.0, 2.0, 0.0);
        let n = DVec3::new(sine, cosine, 0.0);
        assert_eq!(of_zeros(n, light), 2.0 * cosine);
        assert_eq!(of_zeros(DVec3::new(1.0, 1e-3, 0.0), light), 0.0);
        assert_eq!(of_zeros(DVec3::Y, DVec3::new(2.0, 1e-15, 0.0)), 0.0);
    }

    #[test]
    fn heights_are_exact_where_terms_cancel() {
        let n = DVec3::new(0.1, 1.0, 0.05);
        // 0.1 as an f64 is 5.551115123125783e-18 more than a tenth.
        let a = DVec3::new(1e15, -1e14, 0.0);
        let height = exact_height(n, a, DVec3::ZERO);
        assert!(
            (height - 0.005_551_115_123_125_783).abs() < 1e-17,
            "{height}"
        );
        let light = DVec3::new(0.9, 1e-15, 0.3);
        let up = exact_height(DVec3::Y, light, DVec3::new(0.0, 0.5, 0.0));
        assert_eq!(up, -0.499_999_999_999_999);
        assert_eq!(exact_height(DVec3::Y, light, DVec3::ZERO), 1e-15);
    }
}
