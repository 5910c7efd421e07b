//! L1: the ray through a point of the image, r(t) = o + t ω.

use super::vector::{Vector, WideVector, ZERO, add, cross, dot, scale, subtract, unit, widened};
use super::wide::{Real, Wide};
use crate::scene;

/// L1: r(t) = o + t ω. ω has unit length, so that t is a distance in meters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    /// o
    pub(super) origin: WideVector,
    /// ω
    pub(super) direction: WideVector,
}

impl Ray {
    /// L1: the point at distance `t`.
    pub(super) fn at(&self, t: Wide) -> WideVector {
        add(self.origin, scale(self.direction, t))
    }
}

/// A camera at the origin of the oracle's coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Camera {
    /// Width and height of the image in pixels.
    resolution: [f64; 2],
    frame: Frame,
    projection: Projection,
}

/// The camera's axes in the world, each of unit length and square to the others.
#[derive(Clone, Copy, Debug)]
struct Frame {
    forward: WideVector,
    right: WideVector,
    up: WideVector,
}

#[derive(Clone, Copy, Debug)]
enum Projection {
    Perspective {
        /// tan(fov / 2): half the image's height at distance 1.
        tangent: f64,
    },
    Orthographic {
        /// Half the image's height in scene units.
        half_height: f64,
    },
}

impl Camera {
    /// The camera as written. A legal camera has a direction, and an `up` that is not along it.
    pub(super) fn new(camera: &scene::Camera, resolution: [u32; 2]) -> Self {
        let view = camera.view();
        Self {
            resolution: resolution.map(f64::from),
            frame: Frame::new(view.eye.value, view.look_at.value, view.up.value),
            projection: match camera {
                scene::Camera::Perspective { vertical_fov, .. } => Projection::Perspective {
                    tangent: (vertical_fov.value.to_radians() / 2.0).tan(),
                },
                scene::Camera::Orthographic { height, .. } => Projection::Orthographic {
                    half_height: height.value / 2.0,
                },
            },
        }
    }

    /// L1: the primary ray through the image at (`px`, `py`), in pixels from the top left corner;
    /// the center of pixel (x, y) is (x + 0.5, y + 0.5).
    pub(super) fn primary_ray(&self, px: f64, py: f64) -> Ray {
        let image = self.image_plane(px, py);
        match self.projection {
            Projection::Perspective { tangent } => perspective_ray(&self.frame, tangent, image),
            Projection::Orthographic { half_height } => {
                orthographic_ray(&self.frame, half_height, image)
            }
        }
    }

    /// How far a point is along the view axis: z of camera space.
    pub(super) fn depth(&self, point: WideVector) -> f64 {
        dot(point, self.frame.forward).narrow()
    }

    /// Image space → the image plane: x to the right, y up, (0, 0) in the middle, y = ±1 at the
    /// upper and lower edge, x = ±W/H at the sides.
    fn image_plane(&self, px: f64, py: f64) -> [Wide; 2] {
        let [width, height] = self.resolution.map(Wide::from);
        let [one, two] = [1.0, 2.0].map(Wide::from);
        [
            (two * Wide::from(px) / width - one) * width / height,
            one - two * Wide::from(py) / height,
        ]
    }
}

impl Frame {
    /// f = unit(look_at − eye), r = unit(f × up), u = r × f.
    fn new(eye: Vector, look_at: Vector, up: Vector) -> Self {
        let zero = widened(ZERO);
        let forward = unit(subtract(widened(look_at), widened(eye))).unwrap_or(zero);
        // Only the direction of `up` counts; at unit length the product cannot overflow.
        let right = unit(cross(forward, unit(widened(up)).unwrap_or(zero))).unwrap_or(zero);
        Self {
            forward,
            right,
            up: cross(right, forward),
        }
    }

    /// The vector x r + y u across the image.
    fn across(&self, [x, y]: [Wide; 2]) -> WideVector {
        add(scale(self.right, x), scale(self.up, y))
    }
}

/// L1, perspective: o = eye, ω = unit(f + tan(fov/2) (x r + y u)).
fn perspective_ray(frame: &Frame, tangent: f64, [x, y]: [Wide; 2]) -> Ray {
    let tangent = Wide::from(tangent);
    let direction = add(frame.forward, frame.across([x * tangent, y * tangent]));
    Ray {
        origin: widened(ZERO),
        direction: unit(direction).unwrap_or(frame.forward),
    }
}

/// L1, orthographic: o = eye + height/2 (x r + y u), ω = f.
fn orthographic_ray(frame: &Frame, half_height: f64, [x, y]: [Wide; 2]) -> Ray {
    let half_height = Wide::from(half_height);
    Ray {
        origin: frame.across([x * half_height, y * half_height]),
        direction: frame.forward,
    }
}
