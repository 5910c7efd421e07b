//! The lights of L3, and how much they send into each direction.
//!
//! Every light is a spectrum times one number for each point and lobe: of a point light the cosine terms over
//! d², of a spot also its falloff. So light and reflectance meet wavelength by wavelength once
//! ([`World::reflected`](super::World::reflected)), whatever kind a light is of.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use crate::emitter::{Emitter, Surface};
use crate::ies::IesFile;
use crate::math::{DVec3, Direction, Normal, Point};
pub use crate::scene::Falloff;
use crate::units::{Intensity, Rgb};

/// What light comes from. Matches are exhaustive: what a new kind needs, the compiler lists.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// The same into all directions.
    Point(PointLight),
    /// Into a cone.
    Spot(SpotLight),
    /// Into each direction what was measured.
    Ies(IesLight),
    /// From a surface.
    Area(AreaLight),
    /// Parallel rays.
    Sun(SunLight),
}

/// A diffuse point light (L3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    /// p_L, relative to the anchor.
    pub position: Point,
    /// I
    pub intensity: Intensity,
}

/// A point that shines into a cone: L_i = I f(θ) / d², with θ the angle between the axis and the way from the
/// light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotLight {
    /// p_L, relative to the anchor.
    pub position: Point,
    /// Where its middle points.
    pub axis: Direction,
    /// I on the axis.
    pub intensity: Intensity,
    /// f(θ)
    pub cone: Cone,
}

/// A luminaire by its photometry: L_i = I f / d², with f what it sends into a direction over the largest of all.
#[derive(Clone, Debug, PartialEq)]
pub struct IesLight {
    /// p_L, relative to the anchor.
    pub position: Point,
    /// Where vertical angle 0 points.
    pub axis: Direction,
    /// Across the axis: where horizontal angle 0 is.
    pub up: Direction,
    /// I into the brightest direction.
    pub intensity: Intensity,
    /// What was measured.
    pub luminaire: Arc<IesFile>,
    /// 1 over its largest intensity in cd.
    over_peak: f64,
}

/// A surface with the same luminance everywhere and in all directions: L_o = L ∫ r V dω over what a point sees of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaLight {
    /// Its shape, relative to the anchor.
    pub(crate) emitter: Emitter,
    /// L times the area that is seen along the normal, of a sphere from anywhere.
    pub intensity: Intensity,
    /// Whether it is an object of the world too.
    pub is_visible: bool,
    /// How many of its points are asked where it is seen in part and no error is asked for.
    pub samples: u32,
}

/// Parallel light: L_i = E, whatever the distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunLight {
    /// Against the way of its light.
    pub to_light: Direction,
    /// E on a surface that faces it, as the intensity of a lamp that is 1 m away: 1 lx is 1 cd/m².
    pub illuminance: Intensity,
}

/// How far away a sun is taken to be for shadows, in m: 2¹⁸⁰. Next to that no coordinate of a scene, at most 10³⁰,
/// changes the direction by a digit of an f64.
const SUN_DISTANCE: f64 = (1_u128 << 90) as f64 * (1_u128 << 90) as f64;

/// How a spot's intensity falls off from its axis: 1 up to the inner angle, 0 from the outer angle on.
///
/// With x from 1 at the inner to 0 at the outer angle, linear in cos θ: `smooth` is x²(3 − 2x), as pbrt and
/// Cycles have it, and `gltf` x², the reference code of KHR_lights_punctual. `linear_angle` is linear in θ
/// itself, as Mitsuba has it. Where both angles are the same, the edge is sharp.
///
/// Cosines of small angles differ in their last digits only; so all is said in 1 − cos θ, which is
/// 2 sin²(θ/2), to the last digits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    pub(crate) falloff: Falloff,
    /// In radians.
    inner: f64,
    outer: f64,
    sin_outer: f64,
    cos_outer: f64,
    /// 1 − cos θ of the outer angle.
    pub(crate) versine_outer: f64,
    /// One over the difference of 1 − cos θ between the angles; where there is none, the largest number.
    pub(crate) inverse_span: f64,
    /// One over the difference of the angles; where there is none, the largest number.
    pub(crate) inverse_angle: f64,
}

impl Light {
    /// What it is called in a scene: `point`, `spot`, `ies`, `rectangle`, `disk`, `sphere`, `sun`.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Point(_) => "point",
            Self::Spot(_) => "spot",
            Self::Ies(_) => "ies",
            Self::Area(light) => light.shape(),
            Self::Sun(_) => "sun",
        }
    }

    /// I: of a spot the one on its axis, of an area that along its normal, of a sun that of a lamp which is as strong at 1 m.
    #[inline]
    pub fn intensity(&self) -> Intensity {
        match self {
            Self::Point(light) => light.intensity,
            Self::Spot(light) => light.intensity,
            Self::Ies(light) => light.intensity,
            Self::Area(light) => light.intensity,
            Self::Sun(light) => light.illuminance,
        }
    }

    /// Where it is, of an area its middle, relative to the anchor; a sun is so far away that its rays are parallel to the last digit.
    #[inline]
    pub fn position(&self) -> Point {
        match self {
            Self::Point(light) => light.position,
            Self::Spot(light) => light.position,
            Self::Ies(light) => light.position,
            Self::Area(light) => light.emitter.center(),
            Self::Sun(light) => Point(light.to_light.get() * SUN_DISTANCE),
        }
    }

    /// Of parallel rays, against their way.
    #[inline]
    pub fn direction(&self) -> Option<Direction> {
        match self {
            Self::Point(_) | Self::Spot(_) | Self::Ies(_) | Self::Area(_) => None,
            Self::Sun(light) => Some(light.to_light),
        }
    }

    /// Whether its rays are parallel.
    #[inline]
    pub const fn is_sun(&self) -> bool {
        matches!(self, Self::Sun(_))
    }

    /// The flux in lm that leaves it for 1 cd of [`Light::intensity`]; of a sun there is none.
    pub fn flux(&self) -> Option<f64> {
        match self {
            Self::Point(_) => Some(2.0 * TAU),
            Self::Spot(light) => Some(light.cone.flux()),
            Self::Ies(light) => Some(light.luminaire.photometry.lumens() * light.over_peak),
            Self::Area(light) => Some(light.emitter.flux() / light.emitter.intensity()),
            Self::Sun(_) => None,
        }
    }

    /// Its surface, if it has one.
    #[inline]
    pub(crate) fn area(&self) -> Option<&AreaLight> {
        match self {
            Self::Area(light) => Some(light),
            Self::Point(_) | Self::Spot(_) | Self::Ies(_) | Self::Sun(_) => None,
        }
    }

    /// L3 with the cosine of L5: the illuminance in lux at a point of a surface with a unit normal, for 1 cd of
    /// [`Light::intensity`], where nothing is in its way. 0 where the light is below, or at the point itself.
    pub(crate) fn illuminance(&self, point: Point, normal: DVec3) -> f64 {
        let way = self.position().0 - point.0;
        let Some(to_light) = way.try_normalize() else {
            return 0.0;
        };
        let cosine = normal.dot(to_light).max(0.0);
        let factor = match self {
            Self::Sun(_) => return cosine,
            Self::Point(_) => 1.0,
            Self::Spot(light) => light.cone.falloff_along(light.axis.get(), -to_light),
            Self::Ies(light) => light.factor(-way),
            Self::Area(light) => return light.illuminance(point, normal),
        };
        let received = cosine * factor / way.length_squared();
        if received.is_finite() { received } else { 0.0 }
    }

    /// The points that its light comes from, relative to the anchor, each of which has a visibility (L4) of its
    /// own. Lights without a size have one.
    #[inline(always)]
    pub fn origins(&self) -> impl ExactSizeIterator<Item = Point> + use<> {
        std::iter::once(self.position())
    }

    /// Whether a box of points, from its least to its largest coordinates, gets nothing of it for certain.
    #[inline]
    pub fn misses(&self, bounds: [DVec3; 2]) -> bool {
        match self {
            Self::Point(_) | Self::Ies(_) | Self::Area(_) | Self::Sun(_) => false,
            Self::Spot(light) => light.misses(bounds),
        }
    }
}

impl AreaLight {
    /// L in cd/m² per primary.
    #[inline]
    pub fn luminance(&self) -> [f64; 3] {
        let Intensity(Rgb(channels)) = self.intensity;
        let area = self.emitter.intensity();
        channels.map(|channel| channel / area)
    }

    /// 1 over the area that is seen of it along its normal, in m⁻².
    #[inline]
    pub(crate) fn over_area(&self) -> f64 {
        self.emitter.intensity().recip()
    }

    /// What it is called in a scene: `rectangle`, `disk`, `sphere`.
    pub fn shape(&self) -> &'static str {
        match self.emitter.surface() {
            Surface::Rectangle(_) => "rectangle",
            Surface::Disk { .. } => "disk",
            Surface::Sphere { .. } => "sphere",
        }
    }

    /// Whether it is part of a plane.
    pub fn is_flat(&self) -> bool {
        self.emitter.normal().is_some()
    }

    /// Whether it shines to both sides of its plane.
    pub fn is_two_sided(&self) -> bool {
        self.emitter.is_two_sided()
    }

    /// Of a rectangle its sides, else the radius, in m.
    pub fn lengths(&self) -> impl Iterator<Item = f64> {
        let lengths = match self.emitter.surface() {
            Surface::Rectangle([a, b, c, _]) => [Some((c - b).length()), Some((b - a).length())],
            Surface::Disk { radius, .. } | Surface::Sphere { radius } => [Some(radius), None],
        };
        lengths.into_iter().flatten()
    }

    /// Φ(n) per cd, in m⁻²: 0 from behind and below.
    fn illuminance(&self, point: Point, normal: DVec3) -> f64 {
        let Some(normal) = Normal::new(normal) else {
            return 0.0;
        };
        let outline = self.emitter.seen_from(point);
        outline.map_or(0.0, |outline| outline.irradiance(normal)) / self.emitter.intensity()
    }
}

impl IesLight {
    /// At `position`, with vertical angle 0 along `axis` and horizontal angle 0 towards `up`, as far as that is across
    /// the axis; `None` where it is along it.
    pub fn new(
        position: Point,
        axis: Direction,
        up: DVec3,
        intensity: Intensity,
        luminaire: Arc<IesFile>,
    ) -> Option<Self> {
        let w = axis.get();
        let up = up.try_normalize()?;
        let across = up - w * up.dot(w);
        // What is left of an `up` along the axis is rounding.
        let up = Direction::new(across).filter(|_| across.length() > 1e-9)?;
        let over_peak = luminaire.photometry.peak().candela.recip();
        Some(Self {
            position,
            axis,
            up,
            intensity,
            luminaire,
            over_peak,
        })
    }

    /// f towards a point at an offset from the luminaire, of any length but 0. Range: 0 to 1.
    pub fn factor(&self, offset: DVec3) -> f64 {
        let (axis, up) = (self.axis.get(), self.up.get());
        let side = axis.cross(up);
        let in_frame = DVec3::new(offset.dot(up), offset.dot(side), offset.dot(axis));
        (self.luminaire.photometry.intensity(in_frame) * self.over_peak).min(1.0)
    }
}

impl SpotLight {
    /// The ball around the box is outside of the cone where its center is by more than its radius, and by more
    /// than all rounding.
    fn misses(&self, [least, most]: [DVec3; 2]) -> bool {
        const ROOM: f64 = 1e-9;
        let (center, half) = ((least + most) * 0.5, (most - least) * 0.5);
        let way = center - self.position.0;
        let axis = self.axis.get();
        let along = way.dot(axis);
        let across = way.cross(axis).length();
        // How far the center is from the cone's side, on the outside; behind the apex it is further still.
        let outside = across * self.cone.cos_outer - along * self.cone.sin_outer;
        let magnitude = way.abs().max_element() + self.position.0.abs().max_element();
        outside > half.length() * (1.0 + ROOM) + magnitude * ROOM
    }
}

impl Cone {
    /// The widest half-angle in degrees: a half of all directions.
    pub const WIDEST: f64 = 90.0;

    /// The narrowest outer half-angle in degrees: what it lights at 1 km is 17 µm wide.
    pub const NARROWEST: f64 = 1e-6;

    /// A cone of half-angles in degrees; `None` unless 0 ≤ inner ≤ outer, and outer from [`Cone::NARROWEST`] to
    /// [`Cone::WIDEST`].
    pub fn new(inner: f64, outer: f64, falloff: Falloff) -> Option<Self> {
        let is_legal = 0.0 <= inner && inner <= outer;
        let is_legal = is_legal && (Self::NARROWEST..=Self::WIDEST).contains(&outer);
        let (inner, outer) = (inner.to_radians(), outer.to_radians());
        is_legal.then(|| Self {
            falloff,
            inner,
            outer,
            sin_outer: libm::sin(outer),
            cos_outer: libm::cos(outer),
            versine_outer: versine(outer),
            inverse_span: versine_span(inner, outer).recip().min(f64::MAX),
            inverse_angle: (outer - inner).recip().min(f64::MAX),
        })
    }

    /// Which curve.
    #[inline]
    pub fn falloff(&self) -> Falloff {
        self.falloff
    }

    /// Up to where it is 1, in radians.
    #[inline]
    pub fn inner(&self) -> f64 {
        self.inner
    }

    /// From where on it is 0, in radians.
    #[inline]
    pub fn outer(&self) -> f64 {
        self.outer
    }

    /// f into a unit direction, of a cone around a unit axis.
    fn falloff_along(&self, axis: DVec3, direction: DVec3) -> f64 {
        let (sin, cos) = (axis.cross(direction).length(), axis.dot(direction));
        if cos <= 0.0 {
            return 0.0;
        }
        let inside = |x: f64| x.clamp(0.0, 1.0);
        // 1 − cos θ = sin²θ / (1 + cos θ)
        let versine = sin * sin / (1.0 + cos);
        let x = inside((self.versine_outer - versine) * self.inverse_span);
        match self.falloff {
            Falloff::Smooth => x * x * (3.0 - 2.0 * x),
            Falloff::Gltf => x * x,
            Falloff::LinearAngle => {
                inside((self.outer - libm::atan2(sin, cos)) * self.inverse_angle)
            }
        }
    }

    /// The angle in radians from the axis at which f is a part of 1, from 0 to 1.
    pub fn angle_at(&self, part: f64) -> f64 {
        let x = match self.falloff {
            // x²(3 − 2x) = part, by halving: it grows with x.
            Falloff::Smooth => {
                let mut range = [0.0, 1.0];
                for _ in 0..f64::MANTISSA_DIGITS {
                    let middle = 0.5 * (range[0] + range[1]);
                    let is_above = middle * middle * (3.0 - 2.0 * middle) > part;
                    range[usize::from(is_above)] = middle;
                }
                0.5 * (range[0] + range[1])
            }
            Falloff::Gltf => libm::sqrt(part),
            Falloff::LinearAngle => return self.outer - part * (self.outer - self.inner),
        };
        let versine = self.versine_outer - x * versine_span(self.inner, self.outer);
        2.0 * libm::asin(libm::sqrt(versine / 2.0).min(1.0))
    }

    /// The flux in lm of a spot of 1 cd on its axis: ∫ f dω = 2π ∫ f(θ) sin θ dθ, in closed form. Range: above 0,
    /// up to 2π.
    pub fn flux(&self) -> f64 {
        let inner = versine(self.inner);
        let span = versine_span(self.inner, self.outer);
        TAU * match self.falloff {
            Falloff::Smooth => inner + span / 2.0,
            Falloff::Gltf => inner + span / 3.0,
            // 1 − (sin o − sin i)/(o − i) = 1 − cos m · sin h/h, with m the mean angle and h half of their
            // difference.
            Falloff::LinearAngle => {
                let (m, h) = (
                    (self.outer + self.inner) / 2.0,
                    (self.outer - self.inner) / 2.0,
                );
                versine(m) + libm::cos(m) * one_less_sinc(h)
            }
        }
    }
}

/// cos a − cos b, to the last digits.
fn versine_span(a: f64, b: f64) -> f64 {
    2.0 * libm::sin((b - a) / 2.0) * libm::sin((b + a) / 2.0)
}

/// 1 − cos θ, to the last digits.
fn versine(angle: f64) -> f64 {
    let sin = libm::sin(angle / 2.0);
    2.0 * sin * sin
}

/// 1 − sin(h)/h for h up to π/4, by its series: Σ −(−h²)ᵏ/(2k + 1)! from k = 1. The first term left out is below
/// (π/4)²⁰/21! ≈ 2e-22.
fn one_less_sinc(h: f64) -> f64 {
    debug_assert!(h <= PI / 4.0 * (1.0 + f64::EPSILON));
    let square = h * h;
    // h²/6 (1 − h²/20 (1 − h²/42 (…)))
    (1..10).rev().fold(0.0, |rest, k| {
        let k = f64::from(k);
        square / (2.0 * k * (2.0 * k + 1.0)) * (1.0 - rest)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Rgb;

    fn cone(inner: f64, outer: f64, falloff: Falloff) -> Cone {
        Cone::new(inner, outer, falloff).unwrap()
    }

    #[test]
    fn angles_are_checked() {
        for (inner, outer) in [
            (-1.0, 10.0),
            (20.0, 10.0),
            (0.0, 0.0),
            (0.0, 0.9e-6),
            (10.0, 90.1),
            (f64::NAN, 10.0),
            (10.0, f64::NAN),
        ] {
            assert_eq!(Cone::new(inner, outer, Falloff::Smooth), None);
        }
        for (inner, outer) in [(0.0, 1e-6), (30.0, 30.0), (90.0, 90.0)] {
            assert!(Cone::new(inner, outer, Falloff::Smooth).is_some());
        }
    }

    /// From the integral by quadrature to twelve digits, computed apart.
    #[test]
    fn flux_is_the_published_one() {
        for (falloff, flux) in [
            (Falloff::Smooth, 0.6103548267347),
            (Falloff::Gltf, 0.5332106974873),
            (Falloff::LinearAngle, 0.5959104669037),
        ] {
            let actual = cone(20.0, 30.0, falloff).flux();
            assert!((actual - flux).abs() < 1e-13, "{falloff:?}: {actual}");
        }
    }

    /// Of a sharp cone it is the solid angle; of a tiny one π θ².
    #[test]
    fn flux_of_sharp_and_of_tiny_cones() {
        for falloff in Falloff::ALL {
            let sharp = cone(60.0, 60.0, falloff).flux();
            assert!((sharp - PI).abs() < 1e-14, "{falloff:?}");
            let half = cone(90.0, 90.0, falloff).flux();
            assert!((half - TAU).abs() < 1e-14, "{falloff:?}");
            let tiny = cone(1e-6, 1e-6, falloff).flux();
            let expected = PI * 1e-6_f64.to_radians().powi(2);
            assert!((tiny / expected - 1.0).abs() < 1e-12, "{falloff:?}: {tiny}");
        }
        // Linear from the axis on: π θ² / 3.
        let tiny = cone(0.0, 1e-6, Falloff::LinearAngle).flux();
        let expected = PI * 1e-6_f64.to_radians().powi(2) / 3.0;
        assert!((tiny / expected - 1.0).abs() < 1e-12, "{tiny}");
    }

    /// The integral of the very curve, by Simpson's rule from the inner to the outer angle.
    #[test]
    fn flux_is_the_integral_of_the_falloff() {
        for falloff in Falloff::ALL {
            for (inner, outer) in [(0.0, 90.0), (10.0, 80.0), (0.0, 1.0), (44.0, 45.0)] {
                let cone = cone(inner, outer, falloff);
                let f = |angle: f64| {
                    let x = (angle.cos() - cone.outer().cos())
                        / (cone.inner().cos() - cone.outer().cos());
                    match falloff {
                        Falloff::Smooth => x * x * (3.0 - 2.0 * x),
                        Falloff::Gltf => x * x,
                        Falloff::LinearAngle => {
                            (cone.outer() - angle) / (cone.outer() - cone.inner())
                        }
                    }
                };
                let steps = 2000;
                let step = (cone.outer() - cone.inner()) / f64::from(steps);
                let sum: f64 = (0..=steps)
                    .map(|i| {
                        let weight = match i {
                            0 => 1.0,
                            i if i == steps => 1.0,
                            i if i % 2 == 1 => 4.0,
                            _ => 2.0,
                        };
                        let angle = cone.inner() + step * f64::from(i);
                        weight * f(angle) * angle.sin()
                    })
                    .sum();
                let expected = TAU * (1.0 - cone.inner().cos() + sum * step / 3.0);
                let error = (cone.flux() / expected - 1.0).abs();
                assert!(error < 1e-10, "{falloff:?} {inner} {outer}: {error}");
            }
        }
    }

    /// The angle at which a part of the light is left is where the falloff says so.
    #[test]
    fn angles_of_parts_lead_back() {
        for falloff in Falloff::ALL {
            for (inner, outer) in [(0.0, 90.0), (20.0, 30.0), (0.0, 1e-3)] {
                let cone = cone(inner, outer, falloff);
                for part in [0.01, 0.1, 0.5, 0.9] {
                    let (sin, cos) = libm::sincos(cone.angle_at(part));
                    let f = cone.falloff_along(DVec3::X, DVec3::new(cos, sin, 0.0));
                    let error = (f - part).abs();
                    assert!(error < 1e-11, "{falloff:?} {outer} {part}: {error}");
                }
            }
        }
        // Where both angles are the same, that is the angle.
        let sharp = cone(30.0, 30.0, Falloff::Smooth);
        assert!((sharp.angle_at(0.5).to_degrees() - 30.0).abs() < 1e-12);
    }

    /// No box that has a point inside of the cone is missed, and boxes that are far off are.
    #[test]
    fn boxes_beside_the_cone_are_missed() {
        let light = |outer| {
            Light::Spot(SpotLight {
                position: Point::new(1.0, 2.0, 3.0),
                axis: Direction::new(DVec3::new(1.0, 2.0, -2.0)).unwrap(),
                intensity: Intensity(Rgb([1.0; 3])),
                cone: cone(0.0, outer, Falloff::Smooth),
            })
        };
        let mut state = 1_u64;
        let mut unit = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0
        };
        let mut missed = 0;
        for outer in [1.0, 20.0, 60.0, 90.0] {
            let light = light(outer);
            for _ in 0..2000 {
                let center = DVec3::new(unit(), unit(), unit()) * 6.0;
                let half = DVec3::new(unit(), unit(), unit()).abs();
                let bounds = [center - half, center + half];
                if !light.misses(bounds) {
                    continue;
                }
                missed += 1;
                for _ in 0..50 {
                    let point = center + half * DVec3::new(unit(), unit(), unit());
                    let way = point - light.position().0;
                    let axis = DVec3::new(1.0, 2.0, -2.0) / 3.0;
                    let angle = way.angle_between(axis).to_degrees();
                    assert!(angle > outer, "{angle} of {outer}");
                }
            }
        }
        assert!(missed > 2000, "{missed}");
    }
}
