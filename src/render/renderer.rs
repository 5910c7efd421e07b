//! A world made ready for as many pictures as one wants.

use std::io::{self, Seek, Write};

use super::counts::Counts;
use super::film::render_with;
use super::options::Options;
use super::setup::View;
use super::strips;
use crate::camera::Camera;
use crate::exr::{ExrOptions, ExrReport};
use crate::image::Film;
use crate::memory::OutOfMemory;
use crate::visibility::{Parts, Visibility};
use crate::world::{Plan, World};

/// A world with its plan and its trees, built once and seen through any number of cameras.
///
/// ```
/// use candela::render::{Options, Renderer};
/// use candela::scene::Camera;
/// use candela::{Scene, World};
///
/// let (world, camera) = World::new(&Scene::builtin())?;
/// let renderer = Renderer::new(world)?;
/// let film = renderer.render(&camera, &Options::default());
/// // A camera that moves builds nothing.
/// for step in 0..3 {
///     let eye = [0.1 * f64::from(step), 1.0, 4.0];
///     let moved = Camera::perspective(eye, [0.0, 0.5, 0.0], 40.0);
///     let moved = renderer.world().place(&moved, [64, 36])?;
///     renderer.render(&moved, &Options::default());
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Renderer {
    world: World,
    plan: Plan,
    parts: Parts,
}

impl Renderer {
    /// Plans a world and builds what its plan needs, with the threads of the current rayon pool.
    ///
    /// # Errors
    /// If there is not as much memory as building takes.
    pub fn new(world: World) -> Result<Self, OutOfMemory> {
        let plan = Plan::new(&world);
        let parts = Visibility::try_parts(&world, &plan)?;
        Ok(Self { world, plan, parts })
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// What is computed of it.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Bytes of the shapes and trees that were built.
    pub fn memory(&self) -> usize {
        self.parts.memory()
    }

    /// The picture that a camera sees. The same world, camera and options give the same bits on any
    /// number of threads, whatever was rendered before.
    ///
    /// # Panics
    /// As [`render`](super::render()).
    pub fn render(&self, camera: &Camera, options: &Options) -> Film {
        self.render_with(camera, options, &|_| {}).0
    }

    /// [`Renderer::render`], and what it took; `progress` is told after each tile how many pixels it
    /// had.
    ///
    /// # Panics
    /// As [`render`](super::render()).
    pub fn render_with(
        &self,
        camera: &Camera,
        options: &Options,
        progress: &(dyn Fn(u64) + Sync),
    ) -> (Film, Counts) {
        self.through(camera, |view| render_with(view, options, progress))
    }

    /// Renders and writes the picture as OpenEXR into `sink`, from the sink's start: blocks are
    /// compressed and written while others are still being rendered, and the film is never there as a
    /// whole. The bytes are those that [`Renderer::render`] and [`Film::write_exr_to`] make one after the
    /// other. `progress` is told after each tile how many pixels it had.
    ///
    /// # Errors
    /// As [`Film::write_exr_to`]; rendering ends with the first.
    ///
    /// # Panics
    /// As [`render`](super::render()).
    pub fn render_exr(
        &self,
        camera: &Camera,
        options: &Options,
        progress: &(dyn Fn(u64) + Sync),
        exr: &ExrOptions,
        sink: &mut (impl Write + Seek + Send),
    ) -> io::Result<(Counts, ExrReport)> {
        self.through(camera, |view| {
            strips::render_exr(view, options, progress, exr, sink)
        })
    }

    fn through<T>(&self, camera: &Camera, act: impl FnOnce(View<'_>) -> T) -> T {
        let visibility = Visibility::of(&self.world, self.parts.clone());
        act(View {
            world: &self.world,
            plan: &self.plan,
            visibility: &visibility,
            camera,
        })
    }
}
