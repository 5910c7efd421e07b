//! The camera of a scene, and those that are placed in its world.

use std::sync::Arc;

use glam::DVec3;

use super::{Builder, CAMERA_IS_MADE, Entry, Reported};
use crate::camera::{Camera, Projection};
use crate::math::Normal;
use crate::scene::{self, Broken, Diagnostics, MAX_RESOLUTION, Problem, Scene, Spanned};

/// Validates a camera that is placed in a world with this anchor.
pub(in crate::world) fn place(
    camera: &scene::Camera,
    [width, height]: [u32; 2],
    anchor: DVec3,
) -> Result<Camera, Diagnostics> {
    let scene = Scene::new(scene::Image::new(width, height), camera.clone());
    let broken = Broken::default();
    let mut builder = Builder::new(&scene, &broken, anchor);
    let camera = builder.camera();
    match Diagnostics::new(Arc::clone(&scene.source), builder.diagnostics) {
        Some(diagnostics) => Err(diagnostics),
        None => Ok(camera.ok().expect(CAMERA_IS_MADE)),
    }
}

impl Builder<'_> {
    /// The scene's camera, with the image that it makes.
    pub(super) fn camera(&mut self) -> Result<Camera, Reported> {
        self.entry = Some(Entry::Image);
        let resolution = self.resolution();
        self.entry = Some(Entry::Camera);
        let camera = self.camera_of(resolution);
        self.entry = None;
        camera
    }

    fn camera_of(&mut self, resolution: [u32; 2]) -> Result<Camera, Reported> {
        let view = self.scene.camera.value.view();
        let projection = match &self.scene.camera.value {
            scene::Camera::Perspective { vertical_fov, .. } => self
                .number(
                    "vertical_fov",
                    *vertical_fov,
                    |degrees| degrees > 0.0 && degrees < 180.0,
                    "an angle above 0 and below 180 degrees",
                )
                .map(|degrees| Projection::Perspective {
                    // libm's own tan is the same on every machine.
                    half_height: libm::tan((degrees / 2.0).to_radians()),
                }),
            scene::Camera::Orthographic { height, .. } => {
                self.length("height", *height)
                    .map(|height| Projection::Orthographic {
                        half_height: height / 2.0,
                    })
            }
        };
        let eye = self.position("eye", view.eye);
        let look_at = self.position("look_at", view.look_at);
        let up = self.direction("up", view.up);
        let (projection, eye, look_at, up) = (projection?, eye?, look_at?, up?);
        let forward = look_at.from(eye);
        if Normal::new(forward).is_none() {
            let conflict = "`look_at` is the same point as `eye`, expected a point to look at";
            self.report(view.look_at.span, Problem::Conflict(conflict.to_owned()));
            return Err(Reported);
        }
        let camera = Camera::new(self.anchor, eye, forward, up.get(), projection, resolution);
        camera.ok_or_else(|| {
            let conflict = "`up` is along the view from `eye` to `look_at`, expected a direction \
                            across it, such as [0, 0, 1] for a view along y";
            self.report(view.up.span, Problem::Conflict(conflict.to_owned()));
            Reported
        })
    }

    fn resolution(&mut self) -> [u32; 2] {
        let Spanned { value, span } = self.scene.image.resolution;
        if value
            .iter()
            .any(|side| !(1..=MAX_RESOLUTION).contains(side))
        {
            let expected = format!("a width and a height from 1 to {MAX_RESOLUTION} pixels");
            self.out_of_range("resolution", span, format!("{value:?}"), &expected);
            return [1, 1];
        }
        value
    }
}
