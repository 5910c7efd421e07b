//! The scene of a render, and how it goes from frame to frame.

use candela::Camera;
use candela::render::{Built, Renderer};
use candela::scene::{Diagnostics, FIRST_FRAME, Motion, Scene};
use candela::world::{Loaded, World};

use super::Arguments;
use crate::cli::Failure;
use crate::cli::frames::Frame;
use crate::cli::legality::{Triangles, check_frames};

/// So many entries of all frames together are checked before the first is rendered.
const MOST_CHECKED: usize = 1_000_000;

/// A scene at a frame.
pub(super) struct Stage {
    pub(super) scene: Scene,
    pub(super) world: World,
    pub(super) camera: Camera,
    motion: Motion,
}

impl Stage {
    /// Reads the scene, at its first frame.
    pub(super) fn load(arguments: &Arguments, frame: Option<Frame>) -> Result<Self, Failure> {
        let change = |scene: &mut Scene| arguments.layers.apply(scene);
        let frame = frame.map(Frame::number);
        let Loaded {
            mut scene,
            world,
            camera,
            motion,
        } = arguments
            .base
            .load(arguments.scene.as_deref(), frame, change)?;
        if !motion.moved().world {
            // The world has what it takes of meshes, and is not made again.
            scene.release_meshes();
        }
        Ok(Self {
            scene,
            world,
            camera,
            motion,
        })
    }

    /// Whether the frames after the first, at which it is, are legal, as far as that is found out in no time: one in which
    /// triangles move is looked at when it is rendered.
    pub(super) fn check(&self, frames: &[Frame]) -> Result<(), Failure> {
        let Self {
            scene,
            world,
            motion,
            ..
        } = self;
        let entries = scene.materials.len() + scene.lights.len() + scene.objects.len();
        let numbers = frames.iter().skip(1).take(MOST_CHECKED / (1 + entries));
        let numbers: Vec<f64> = numbers.map(|frame| frame.number()).collect();
        check_frames(&numbers, motion, scene, world, Triangles::Left)
    }

    /// The frame that a header names: the one that is asked for, or that of a scene that moves.
    pub(super) fn frame(&self, asked: Option<Frame>) -> Option<f64> {
        let moves = self.motion.frames().is_some();
        asked.map(Frame::number).or(moves.then_some(FIRST_FRAME))
    }

    /// Goes to another frame. What was built for the frame before is kept as far as it stays as it was.
    pub(super) fn go_to(
        &mut self,
        frame: Frame,
        built: Option<Built>,
    ) -> Result<Option<Built>, Failure> {
        let number = frame.number();
        let at_frame = |errors: Diagnostics| errors.at_frame(number);
        let change = self.motion.set(&mut self.scene, number)?;
        if !self.motion.moved().world {
            if self.motion.moved().camera {
                let resolution = self.camera.resolution();
                let camera = self.world.place(&self.scene.camera.value, resolution);
                self.camera = camera.map_err(at_frame)?;
            }
            return Ok(built);
        }
        let (world, camera) = self.world.again(&self.scene, change).map_err(at_frame)?;
        let built = match built {
            Some(built) => {
                let before: Renderer<'_> = built.of(&self.world);
                Some(before.again(&world)?.into_built())
            }
            None => None,
        };
        self.world = world;
        self.camera = camera;
        Ok(built)
    }
}
