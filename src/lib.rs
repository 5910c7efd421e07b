//! candela: a renderer for direct light.
//!
//! For every pixel it computes what a viewer receives from the lights of a scene by way of one surface,
//! seen directly or in mirrors and glass (L9, with its parts L1 to L8 in [`oracle`]):
//!
//! L_o(ω_o) = Σ_s I_s/d_s² · r(ω_i^s, ω_o) · V^s(p)
//!
//! in candela, lux and cd/m², with the metre as the scene unit; a sun has E_s in the place of I_s/d_s². The image is the
//! same to the bit for any number of threads.
//!
//! # The way of the data
//!
//! ```text
//!  scene.toml, *.ply, *.obj, *.ies, *.csv
//!            │ Scene::load
//!          scene ─────────────────── oracle      as written, every value with its place
//!            │ World::new              │
//!          world                       │         legal: resolved, in range
//!            │ Plan::new               │
//!          plan                        │         just what this scene needs
//!            │ render                  │         or Renderer::exr: straight into the file
//!  ┌─ render ┴────────────────┐        │
//!  │ visibility ⇄ shading     │        │         camera rays to points, points to radiance
//!  └─────────┬────────────────┘        │
//!            │ Film::write_exr    tests, probe   the same pixels by other code, in f64
//!        scene.exr                               linear, cd/m²
//!            │ display::convert
//!        scene.png                               exposed, viewed, sRGB-coded
//! ```
//!
//! The modules in the order in which data flows; each uses only some of those above it:
//!
//! | module | job |
//! | --- | --- |
//! | `units` | photometric quantities as types: candela, lux, cd/m² |
//! | `math` | points, directions, normals and rays in f64 |
//! | `emitter` | what a point receives of luminaires with an area, in closed form |
//! | `simd` | sixteen numbers side by side, on any instruction set |
//! | `color` | RGB spaces: primaries, luminance, conversion, differences, transfer functions |
//! | [`output`] | files that appear whole or not at all |
//! | `printable` | text from files and command lines as it may be shown on a terminal |
//! | [`spectrum`] | functions of wavelength: the CIE's tables, curves, illuminants, smooth spectra of colors |
//! | `camera` | pixels to rays (L1) |
//! | [`scene`] | what was written: the scene file and its meshes, with places for errors |
//! | [`world`] | what is legal: resolved, in range, in the working space, lights times reflectances integrated; and the plan |
//! | `visibility` | what a camera ray sees (L1, L2) and what a light reaches (L4) |
//! | `shading` | how much light goes from there to the viewer (L3, L5 to L9) |
//! | [`image`] | what an image is: its window, its pixels and channels |
//! | [`exr`] | images to OpenEXR and back |
//! | `image_file` | PNG, JPEG, TIFF and Radiance HDR to linear light |
//! | [`mod@render`] | tiles, their samples, the box filter, and where finished tiles go |
//! | [`mod@relight`] | pictures with layers of lights to pictures in other light |
//! | [`display`] | EXR to PNG: exposure, view, sRGB |
//! | `compare` | how far an image is from a reference: errors of numbers, relative ones, ꟻLIP |
//! | [`oracle`] | the equations by brute force, places in twice f64's length, from the scene as written: the truth for tests, `candela verify` and `candela probe`; it shares nothing else with the renderer but the CIE's tables |
//!
//! The command line is a program on top of these.
//!
//! # Scope
//!
//! In: points, spots, luminaires by IES files, and suns as lights; spheres, planes, triangles and meshes (PLY,
//! OBJ); Phong's reflectance, to the letter and normalized; perspective and orthographic cameras; light as RGB in
//! four working spaces, or as spectra; sequences of what moves.
//!
//! Out: indirect light, mirrors and refraction, lights with a size, textures, motion blur.
//!
//! # Example
//!
//! One light of 10 cd, 2 m above a floor, seen from above: the middle of the image is lit straight
//! from above, so that L_o = k_d I/d² = 0.5 · 10 cd / (2 m)² = 1.25 cd/m². Towards the side, at x
//! from there, d² = h² + x² and cos(n, ω_i) = h/d: L_o = k_d I h / (h² + x²)^{3/2}.
//!
//! ```
//! use candela::display::{self, Settings};
//! use candela::output::Unfinished;
//! use candela::{Options, Scene, World, render};
//!
//! let text = r#"
//!     [image]
//!     resolution = [9, 9]
//!
//!     [camera.orthographic]
//!     eye = [0, 1, 0]
//!     look_at = [0, 0, 0]
//!     up = [0, 0, -1]
//!     height = 9
//!
//!     [materials.chalk.phong]
//!     diffuse = 0.5
//!
//!     [lights.lamp.point]
//!     position = [0, 2, 0]
//!     intensity = 10
//!
//!     [objects.floor.plane]
//!     material = "chalk"
//!     point = [0, 0, 0]
//!     normal = [0, 1, 0]
//! "#;
//! let scene = Scene::parse(text, "floor.toml")?; // what was written
//! let (world, camera) = World::new(&scene)?; // what is legal, and who looks at it
//! let film = render(&world, &camera, &Options::default())?;
//!
//! // One pixel is one metre; column 4 is x = 0, column 7 is x = 3.
//! let pixel = |x: usize, y: usize| film.pixels()[9 * y + x];
//! let expected = |x: f64| (0.5 * 10.0 * 2.0 / (2.0_f64.powi(2) + x * x).powf(1.5)) as f32;
//! let agrees = |actual: f32, expected: f32| (actual - expected).abs() <= 1e-6 * expected;
//! assert!(agrees(pixel(4, 4)[0], 1.25));
//! assert!(agrees(pixel(7, 4)[0], expected(3.0)));
//! assert_eq!(pixel(4, 4)[3], 1.0); // A: covered
//!
//! let folder = tempfile::tempdir()?;
//! let (exr, png) = (folder.path().join("floor.exr"), folder.path().join("floor.png"));
//! film.save(&exr)?;
//! display::convert(&exr, &png, &Settings::default(), &Unfinished::new())?;
//! assert!(png.exists());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]

#[doc(hidden)]
mod bench;
mod camera;
mod color;
#[doc(hidden)]
pub mod compare;
pub mod display;
mod emitter;
pub mod exr;
#[doc(hidden)]
pub mod ies;
pub mod image;
#[doc(hidden)]
pub mod image_file;
mod input;
mod math;
mod memory;
pub mod mesh;
mod optics;
pub mod oracle;
pub mod output;
mod printable;
mod quadrature;
pub mod relight;
pub mod render;
pub mod scene;
mod shading;
mod simd;
pub mod spectrum;
mod turns;
mod units;
mod visibility;
pub mod world;

/// What the program, the tests and the benchmarks use beside the library's face. It may change in any
/// version.
#[doc(hidden)]
pub mod internal {
    pub use crate::bench::Tracer;
    pub use crate::color::adaptation::bradford;
    pub use crate::color::difference::{Lab, delta_e_2000};
    pub use crate::color::transfer::srgb_decode;
    pub use crate::memory::{Size, look_for_threads};
    pub use crate::printable::{counted, is_printable, printable, printable_path, shell_word};
}

/// The code of the page about the library compiles.
#[cfg(doctest)]
#[doc = include_str!("../docs/library.md")]
struct LibraryPage;

pub use self::image::Film;
pub use camera::{Camera, Projection};
#[doc(hidden)]
pub use color::Primaries;
pub use math::{DVec3, Direction, Point, Ray};
pub use memory::OutOfMemory;
pub use render::{Options, Renderer, illuminance, render};
pub use scene::Scene;
pub use world::World;
