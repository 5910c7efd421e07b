//! L1: primary rays, from image space over NDC and camera space to world space.
//!
//! Here alone pixels become rays. A camera is apart from the world that it looks at: one world is built
//! once and seen through as many cameras as are [placed](crate::world::World::place) in it.

use fearless_simd::Simd;

use crate::math::{DVec3, Direction, Point, Ray, both};
use crate::simd::{DVec3x16, F64x16};

/// A camera that looks somewhere, with the image that it makes.
///
/// It is made by [`World::new`](crate::world::World::new), as the scene file has it, or by
/// [`World::place`](crate::world::World::place), anywhere else. The axes are orthonormal: `right` and `up` span the image plane, `forward` points along the
/// view. This is a left-handed frame, as OpenEXR has it for camera space.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// What is subtracted from every position of the scene.
    anchor: DVec3,
    eye: Point,
    right: Direction,
    up: Direction,
    forward: Direction,
    projection: Projection,
    resolution: [u32; 2],
}

/// How the image plane maps to rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// All rays start at the eye.
    Perspective {
        /// Half the image's height over its distance: tan(vertical_fov / 2).
        half_height: f64,
    },
    /// All rays have the direction of the view and start on the plane through the eye.
    Orthographic {
        /// Half the image's height in scene units.
        half_height: f64,
    },
}

impl Camera {
    /// A camera at `eye`, relative to `anchor`, that looks along `forward` with `up` upwards in the image;
    /// `None` where these do not make a frame.
    pub(crate) fn new(
        anchor: DVec3,
        eye: Point,
        forward: DVec3,
        up: DVec3,
        projection: Projection,
        resolution: [u32; 2],
    ) -> Option<Self> {
        let forward = Direction::new(forward)?;
        let right = Direction::new(forward.get().cross(Direction::new(up)?.get()))?;
        let up = Direction::new(right.get().cross(forward.get()))?;
        Some(Self {
            anchor,
            eye,
            right,
            up,
            forward,
            projection,
            resolution,
        })
    }

    /// What is subtracted from every position of the scene, in f64: the anchor of the world that the camera
    /// is placed in.
    pub fn anchor(&self) -> DVec3 {
        self.anchor
    }

    /// Width and height of the image in pixels.
    pub fn resolution(&self) -> [u32; 2] {
        self.resolution
    }

    /// The viewer's position, relative to the anchor.
    pub fn eye(&self) -> Point {
        self.eye
    }

    /// The direction of the view.
    pub fn forward(&self) -> Direction {
        self.forward
    }

    /// How the image plane maps to rays.
    pub fn projection(&self) -> Projection {
        self.projection
    }

    /// What it is, as JSON: its kind, and of a perspective one the vertical field of view in degrees, of an
    /// orthographic one the height of the image in scene units.
    pub(crate) fn description(&self) -> String {
        let description = match self.projection {
            Projection::Perspective { half_height } => serde_json::json!({
                "kind": "perspective",
                "vertical_fov": 2.0 * libm::atan(half_height).to_degrees(),
            }),
            Projection::Orthographic { half_height } => serde_json::json!({
                "kind": "orthographic",
                "height": 2.0 * half_height,
            }),
        };
        description.to_string()
    }

    /// The focal length that a perspective camera has with a sensor as wide as 35 mm film, and the size of that sensor,
    /// all in mm.
    pub(crate) fn lens(&self) -> Option<(f64, [f64; 2])> {
        /// The width of a frame of 35 mm film in mm (ISO 1007).
        const SENSOR: f64 = 36.0;
        let Projection::Perspective { half_height } = self.projection else {
            return None;
        };
        let [width, height] = self.resolution.map(f64::from);
        let sensor = [SENSOR, SENSOR * height / width];
        Some((sensor[1] / 2.0 / half_height, sensor))
    }

    /// Image space (pixels, (0, 0) the top left corner of the image) to the image plane, with the
    /// image's vertical extent from −1 to 1, y up.
    fn image_plane(&self, x: f64, y: f64) -> [f64; 2] {
        let [width, height] = both(self.resolution, f64::from);
        let pixel = 2.0 / height;
        [(x - width * 0.5) * pixel, (height * 0.5 - y) * pixel]
    }

    /// The primary ray through the point (x, y) of the image, in pixels. Its direction is not of
    /// unit length: with a perspective camera, t is the distance along the view axis.
    #[inline]
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let [x, y] = self.image_plane(x, y);
        let across = |half: f64| self.right.get() * (x * half) + self.up.get() * (y * half);
        match self.projection {
            Projection::Perspective { half_height } => Ray {
                origin: self.eye,
                direction: self.forward.get() + across(half_height),
            },
            Projection::Orthographic { half_height } => Ray {
                origin: Point(self.eye.0 + across(half_height)),
                direction: self.forward.get(),
            },
        }
    }

    /// What differs from ray to ray through points of the image, as [`Camera::ray`] has it: the
    /// direction of a perspective camera, the origin of an orthographic one.
    #[inline(always)]
    pub(crate) fn varying<S: Simd>(&self, simd: S, x: F64x16<S>, y: F64x16<S>) -> DVec3x16<S> {
        let [width, height] = both(self.resolution, f64::from);
        let pixel = 2.0 / height;
        let x = (x - width * 0.5) * pixel;
        let y = (F64x16::splat(simd, height * 0.5) - y) * pixel;
        let (start, half) = match self.projection {
            Projection::Perspective { half_height } => (self.forward.get(), half_height),
            Projection::Orthographic { half_height } => (self.eye.0, half_height),
        };
        let right = DVec3x16::splat(simd, self.right.get()).times(x * half);
        let up = DVec3x16::splat(simd, self.up.get()).times(y * half);
        DVec3x16::splat(simd, start) + (right + up)
    }

    /// World to camera space for column vectors: +x right, +y up, +z along the view. It takes
    /// positions as the scene file has them.
    pub fn world_to_camera(&self) -> [[f64; 4]; 4] {
        let eye = self.eye.0 + self.anchor;
        let row = |axis: Direction| {
            let axis = axis.get();
            [axis.x, axis.y, axis.z, -axis.dot(eye)]
        };
        [
            row(self.right),
            row(self.up),
            row(self.forward),
            [0.0, 0.0, 0.0, 1.0],
        ]
    }

    /// World to NDC for column vectors, before the division by w: x and y from 0 to 1 over the
    /// image, (0, 0) its top left, y down; z is 1 − 1/depth with a perspective camera, so that the
    /// matrix can be inverted, and the depth with an orthographic one.
    pub fn world_to_ndc(&self) -> [[f64; 4]; 4] {
        let [right, up, forward, one] = self.world_to_camera();
        let aspect = f64::from(self.resolution[0]) / f64::from(self.resolution[1]);
        let combine =
            |a: [f64; 4], s: f64, b: [f64; 4], t: f64| std::array::from_fn(|i| a[i] * s + b[i] * t);
        match self.projection {
            Projection::Perspective { half_height } => [
                combine(right, 0.5 / (half_height * aspect), forward, 0.5),
                combine(up, -0.5 / half_height, forward, 0.5),
                combine(forward, 1.0, one, -1.0),
                forward,
            ],
            Projection::Orthographic { half_height } => [
                combine(right, 0.5 / (half_height * aspect), one, 0.5),
                combine(up, -0.5 / half_height, one, 0.5),
                forward,
                one,
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ANCHOR: DVec3 = DVec3::new(10.0, -20.0, 5.0);

    fn camera(projection: Projection) -> Camera {
        let look = DVec3::new(-3.0, -0.5, -7.0);
        Camera::new(
            ANCHOR,
            Point::new(4.0, 2.0, 6.0),
            look,
            DVec3::Y,
            projection,
            [640, 360],
        )
        .unwrap()
    }

    const PERSPECTIVE: Projection = Projection::Perspective { half_height: 0.4 };
    const ORTHOGRAPHIC: Projection = Projection::Orthographic { half_height: 1.7 };

    #[test]
    fn up_and_right_are_up_and_right_in_the_image() {
        for projection in [PERSPECTIVE, ORTHOGRAPHIC] {
            let camera = camera(projection);
            let center = camera.ray(320.0, 180.0).at(3.0).0;
            let above = camera.ray(320.0, 0.0).at(3.0).0;
            let beside = camera.ray(640.0, 180.0).at(3.0).0;
            assert!((above - center).y > 0.0);
            // Looking along −z, +x is on the right.
            assert!((beside - center).x > 0.0);
        }
    }

    #[test]
    fn ndc_takes_every_point_back_to_its_pixel() {
        for projection in [PERSPECTIVE, ORTHOGRAPHIC] {
            let camera = camera(projection);
            let matrix = camera.world_to_ndc();
            for (x, y, t) in [(0.0, 0.0, 1.0), (640.0, 360.0, 2.0), (123.0, 45.5, 40.0)] {
                let p = camera.ray(x, y).at(t).0 + ANCHOR;
                let ndc = matrix.map(|r| r[0] * p.x + r[1] * p.y + r[2] * p.z + r[3]);
                assert!((ndc[0] / ndc[3] * 640.0 - x).abs() < 1e-10);
                assert!((ndc[1] / ndc[3] * 360.0 - y).abs() < 1e-10);
                let z = match projection {
                    Projection::Perspective { .. } => 1.0 - 1.0 / t,
                    Projection::Orthographic { .. } => t,
                };
                assert!((ndc[2] / ndc[3] - z).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn no_camera_without_a_frame() {
        let eye = Point::new(0.0, 0.0, 0.0);
        let new = |forward, up| Camera::new(ANCHOR, eye, forward, up, PERSPECTIVE, [4, 4]);
        assert!(new(DVec3::ZERO, DVec3::Y).is_none());
        assert!(new(DVec3::Y, DVec3::Y * 3.0).is_none());
        assert!(new(DVec3::Z, DVec3::ZERO).is_none());
        assert!(new(DVec3::Z, DVec3::Y).is_some());
    }
}
