//! A spot: how its intensity falls off from its axis, and what it sends out in all.

use std::f64::consts::PI;

use super::vector::{Vector, cross, dot, length, subtract, unit};
use crate::scene::{Aim, Falloff};

/// Into how many steps the penumbra is cut for the flux: Simpson's rule is then exact to 1e-12.
const STEPS: u32 = 2000;

/// The cone that a light shines into.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    /// Where its middle points, of unit length.
    axis: Vector,
    /// In radians.
    inner: f64,
    outer: f64,
    falloff: Falloff,
}

impl Cone {
    /// From half-angles in degrees.
    pub(super) fn new(
        position: Vector,
        aim: &Aim,
        [inner, outer]: [f64; 2],
        falloff: Falloff,
    ) -> Self {
        let along = match aim {
            Aim::LookAt(point) => subtract(point.value, position),
            Aim::Direction(direction) => direction.value,
        };
        Self {
            axis: unit(along).expect("a legal spot points somewhere"),
            inner: inner * PI / 180.0,
            outer: outer * PI / 180.0,
            falloff,
        }
    }

    /// In radians: nothing falls off within it.
    pub(super) fn inner_angle(&self) -> f64 {
        self.inner
    }

    /// θ in radians: between the axis and a way from the light.
    pub(super) fn angle(&self, way: Vector) -> f64 {
        length(cross(self.axis, way)).atan2(dot(self.axis, way))
    }

    /// f(θ): 1 on the axis, 0 from the outer angle on.
    pub(super) fn falloff(&self, angle: f64) -> f64 {
        if angle >= self.outer {
            return 0.0;
        }
        if angle <= self.inner {
            return 1.0;
        }
        // cos θ − cos o by the half angles, so that no digit cancels.
        let to_outer =
            |angle: f64| ((self.outer - angle) / 2.0).sin() * ((self.outer + angle) / 2.0).sin();
        let x = to_outer(angle) / to_outer(self.inner);
        match self.falloff {
            Falloff::Smooth => x * x * (3.0 - 2.0 * x),
            Falloff::Gltf => x * x,
            Falloff::LinearAngle => (self.outer - angle) / (self.outer - self.inner),
        }
    }

    /// ∫ f dω in sr: how much flux a spot of 1 cd on its axis has, in lm.
    pub(super) fn flux(&self) -> f64 {
        let core = 4.0 * PI * (self.inner / 2.0).sin().powi(2);
        let step = (self.outer - self.inner) / f64::from(STEPS);
        let ring = |place: u32| {
            let angle = self.inner + step * f64::from(place);
            2.0 * PI * self.falloff(angle) * angle.sin()
        };
        let weighted = (0..=STEPS).map(|place| match place {
            0 | STEPS => ring(place),
            _ if place % 2 == 1 => 4.0 * ring(place),
            _ => 2.0 * ring(place),
        });
        core + weighted.sum::<f64>() * step / 3.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cone(angles: [f64; 2], falloff: Falloff) -> Cone {
        let aim = Aim::LookAt([1.0, 2.0, 0.0].into());
        Cone::new([1.0, 2.0, 3.0], &aim, angles, falloff)
    }

    /// pbrt's, glTF's and Mitsuba's curves and fluxes, computed apart.
    #[test]
    fn curves_and_fluxes_are_the_published_ones() {
        for (falloff, at_25_degrees, flux) in [
            (Falloff::Smooth, 0.5700181841666, 0.6103548267347),
            (Falloff::Gltf, 0.2990072972446, 0.5332106974873),
            (Falloff::LinearAngle, 0.5, 0.5959104669037),
        ] {
            let cone = cone([20.0, 30.0], falloff);
            let (sin, cos) = 25.0_f64.to_radians().sin_cos();
            let angle = cone.angle([0.0, 3.0 * sin, -3.0 * cos]);
            let actual = cone.falloff(angle);
            assert!(
                (actual - at_25_degrees).abs() < 1e-12,
                "{falloff:?}: {actual}"
            );
            let actual = cone.flux();
            assert!((actual - flux).abs() < 1e-12, "{falloff:?}: {actual}");
        }
    }

    #[test]
    fn a_sharp_cone_sends_into_its_solid_angle() {
        for falloff in Falloff::ALL {
            let cone = cone([60.0, 60.0], falloff);
            assert!((cone.flux() - PI).abs() < 1e-12);
            assert_eq!(cone.falloff(60.0_f64.to_radians() - 1e-9), 1.0);
            assert_eq!(cone.falloff(60.0_f64.to_radians()), 0.0);
        }
    }
}
