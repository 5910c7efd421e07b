//! Radiance to pixels: the tiles of an image, their samples, and the box filter.

use fearless_simd::Simd;
use rayon::prelude::*;

use super::batch::{Batch, PIXELS, Run, SampleRange, TILE};
use super::passes::Passes;
use super::sampling::Sampler;
use super::{Film, Frame, Layers, Metadata, Window};
use crate::camera::Camera;
use crate::shading::{self, Shaded, Terms};
use crate::simd::{
    F32x16, F64x16, Kernel, LANES, Mask32x16, SimdLevel, U32x16, every_nth, side_by_side,
};
use crate::visibility::{BATCH, Column, Points, Visibility, Workspace};
use crate::world::{Bands, Plan, World};

/// The most samples of a pixel.
pub const MAX_SAMPLES: u32 = 65_536;

/// The radiance in cd/m² that a screen shows as its white, where no exposure is given.
pub const SCREEN_WHITE: f32 = 1.0;

/// Above this a pixel is brighter than the screen: it would have a code of 256 or more of 255.
const BEYOND_WHITE: f32 = 1.009 * SCREEN_WHITE;

/// How to render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Samples of each pixel. 1 samples pixel centers and nothing else; more are a fixed pattern
    /// that differs from pixel to pixel. Range: 1 to [`MAX_SAMPLES`]. Default 1.
    pub samples: u32,
    /// The part of the image to render; `None` is all of it.
    pub window: Option<Window>,
    /// What is made beside R, G, B and A. Default: nothing.
    pub layers: Layers,
    /// The instructions to render with, which make no difference to the image. Default: the widest
    /// that the machine has.
    pub simd: SimdLevel,
}

/// What a render took and met. The same for any number of threads and any instructions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// Camera rays.
    pub primary_rays: u64,
    /// Of these, those that hit an object.
    pub hits: u64,
    /// Points asked for a light's visibility: those that the light is not below.
    pub shadow_rays: u64,
    /// Of these, those that the light reaches.
    pub lit: u64,
    /// Times that a light was exactly on the point it should light (d = 0) and added nothing.
    pub singular: u64,
    /// Channels of pixels, those of layers among them, whose value is beyond ± the largest f32, and
    /// became that.
    pub clamped: u64,
    /// The largest R, G or B of any pixel in cd/m², at least 0.
    pub brightest: f32,
    /// Pixels with R, G or B above [`SCREEN_WHITE`] by so much that a code of 8 bits
    /// cannot show it, 0.9 %.
    pub beyond_white: u64,
}

impl Counts {
    pub(super) fn and(self, other: Self) -> Self {
        Self {
            primary_rays: self.primary_rays + other.primary_rays,
            hits: self.hits + other.hits,
            shadow_rays: self.shadow_rays + other.shadow_rays,
            lit: self.lit + other.lit,
            singular: self.singular + other.singular,
            clamped: self.clamped + other.clamped,
            brightest: self.brightest.max(other.brightest),
            beyond_white: self.beyond_white + other.beyond_white,
        }
    }
}

impl Default for Options {
    fn default() -> Self {
        Self {
            samples: 1,
            window: None,
            layers: Layers::default(),
            simd: SimdLevel::default(),
        }
    }
}

/// Renders a world as a camera sees it: plans, builds what the plan needs, and renders with the threads
/// of the current rayon pool. The same world, camera and options give the same bits on any number of
/// threads. Where more than one picture is made of a world, a [`Renderer`](super::Renderer) builds once.
///
/// # Panics
/// If [`Options::samples`] is out of range, [`Options::window`] is not inside the image,
/// [`Options::layers`] has a spectral one where the world carries light as RGB, or the camera is placed in
/// a world with another anchor.
pub fn render(world: &World, camera: &Camera, options: &Options) -> Film {
    let plan = Plan::new(world);
    let visibility = Visibility::new(world, &plan);
    let stage = Stage {
        world,
        plan: &plan,
        visibility: &visibility,
        camera,
    };
    render_with(stage, options, &|_| {}).0
}

/// A built world, and the camera that looks at it.
#[derive(Clone, Copy)]
pub(super) struct Stage<'w> {
    pub(super) world: &'w World,
    pub(super) plan: &'w Plan,
    pub(super) visibility: &'w Visibility<'w>,
    pub(super) camera: &'w Camera,
}

/// [`render`] of what is built. `progress` is told after each tile how many pixels it had.
pub(super) fn render_with(
    stage: Stage<'_>,
    options: &Options,
    progress: &(dyn Fn(u64) + Sync),
) -> (Film, Counts) {
    set_up(stage, options, |work, frame| {
        let mut film = Film::black(frame);
        let tiles = film.tiles(TILE).into_par_iter();
        let tiles = tiles.map_init(Box::<Space>::default, |space, mut tile| {
            let counts = work.tile(&mut tile, space);
            progress(tile.window.count());
            counts
        });
        let counts = tiles.reduce(Counts::default, Counts::and);
        (film, counts)
    })
}

/// Makes what all tiles have in common, and renders with it.
///
/// # Panics
/// As [`render`].
pub(super) fn set_up<T>(
    stage: Stage<'_>,
    options: &Options,
    render: impl FnOnce(Work<'_>, Frame) -> T,
) -> T {
    assert!(
        (1..=MAX_SAMPLES).contains(&options.samples),
        "samples are out of range"
    );
    let Stage { world, camera, .. } = stage;
    assert!(
        camera.anchor() == world.anchor(),
        "the camera is placed in another world"
    );
    let resolution = camera.resolution();
    let bands = options.layers.spectral.map(|wavelengths| {
        let spectra = world.spectra();
        Bands::new(
            spectra.expect("bands are asked for where light is spectral"),
            wavelengths,
        )
    });
    let frame = Frame {
        resolution,
        window: options.window.unwrap_or(Window::whole(resolution)),
        channels: options.layers.channels(world),
        metadata: metadata(stage, options),
    };
    let sampler = Sampler::new(options.samples);
    let work = Work {
        stage,
        samples: options.samples,
        simd: options.simd,
        sampler: &sampler,
        passes: Passes::new(world, camera, options.layers, bands.as_ref()),
    };
    render(work, frame)
}

fn metadata(stage: Stage<'_>, options: &Options) -> Metadata {
    let Stage {
        world,
        plan,
        camera,
        ..
    } = stage;
    let plan = serde_json::to_string(plan).expect("a plan is plain data");
    let layers = options.layers.names();
    let layers = (!layers.is_empty()).then(|| ("layers".to_owned(), layers.join(",")));
    let inputs = ("inputs_sha256".to_owned(), world.inputs_hash().to_owned());
    let others = [
        ("plan".to_owned(), plan),
        ("samples".to_owned(), options.samples.to_string()),
        ("scene_sha256".to_owned(), world.scene_hash().to_owned()),
    ];
    Metadata {
        color_space: world.color_space(),
        world_to_camera: camera.world_to_camera(),
        world_to_ndc: camera.world_to_ndc(),
        provenance: std::iter::once(inputs)
            .chain(layers)
            .chain(others)
            .collect(),
    }
}

/// A part of the film that one thread fills.
pub(super) struct Tile<'f> {
    /// Its place in the image.
    pub(super) window: Window,
    /// Its pixels, row by row.
    pub(super) rows: Vec<&'f mut [[f32; 4]]>,
    /// The values of its pixels' further channels, row by row, pixel by pixel within; empty where
    /// there are none.
    pub(super) values: Vec<&'f mut [f32]>,
}

/// What all tiles have in common.
#[derive(Clone, Copy)]
pub(super) struct Work<'w> {
    stage: Stage<'w>,
    samples: u32,
    simd: SimdLevel,
    sampler: &'w Sampler,
    passes: Option<Passes<'w>>,
}

/// What a thread needs for a tile, to be used for the next as well.
#[derive(Default)]
pub(super) struct Space {
    batch: Batch,
    sums: PixelSums,
    tracing: Workspace,
    points: Points,
    shaded: Shaded,
}

/// One tile, on whatever instructions.
struct TileKernel<'t, 'w, 'f> {
    work: Work<'w>,
    tile: &'t mut Tile<'f>,
    space: &'t mut Space,
}

impl Kernel for TileKernel<'_, '_, '_> {
    type Output = Counts;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Counts {
        self.work.render(simd, self.tile, self.space)
    }
}

impl Work<'_> {
    /// Fills a tile.
    pub(super) fn tile(self, tile: &mut Tile<'_>, space: &mut Space) -> Counts {
        self.simd.run(TileKernel {
            work: self,
            tile,
            space,
        })
    }

    /// Renders all samples of a tile's pixels, batch by batch.
    #[inline(always)]
    fn render<S: Simd>(self, simd: S, tile: &mut Tile<'_>, space: &mut Space) -> Counts {
        let Self {
            stage,
            samples,
            sampler,
            ..
        } = self;
        let Stage {
            world,
            visibility,
            camera,
            ..
        } = stage;
        let Space {
            batch,
            sums,
            tracing,
            points,
            shaded,
        } = space;
        batch.begin(simd, sampler, tile.window);
        sums.clear();
        let mut passes = self.passes.map(|passes| passes.sums(batch.pixels().len()));
        let mut counts = Counts::default();
        while batch.next(simd, sampler) {
            visibility.see(simd, batch.samples(camera), tracing, points);
            {
                let passes = passes.as_mut();
                let mut each = passes.and_then(|passes| passes.see(batch.range(), points));
                let each = each.as_mut().map(|each| each as &mut dyn FnMut(Terms<'_>));
                shading::radiance(simd, world, visibility, points, tracing, shaded, each);
            }
            sums.add(simd, batch.range(), points, &shaded.radiance);
            if let Some(passes) = &mut passes {
                // The last pixel may have samples in the next batch.
                passes.finish(batch.range().last_pixel());
            }
            counts = counts.and(Counts {
                primary_rays: batch.len() as u64,
                shadow_rays: shaded.shadow_rays,
                lit: shaded.lit_points,
                singular: shaded.singular,
                ..Counts::default()
            });
        }
        let mut pixels = batch.pixels();
        for first in (0..pixels.len()).step_by(LANES) {
            let count = pixels.len().min(LANES);
            let (means, met) = sums.means(simd, first, count, samples);
            for (mean, [column, row]) in means.into_iter().zip(pixels.by_ref()) {
                tile.rows[row as usize][column as usize] = mean;
            }
            counts = counts.and(met);
        }
        if let Some(mut passes) = passes {
            passes.finish(batch.pixels().len());
            for (pixel, [column, row]) in batch.pixels().enumerate() {
                let values = tile.values[row as usize]
                    .chunks_exact_mut(passes.channels())
                    .nth(column as usize)
                    .expect("the film has room for the layers of every pixel");
                let misses = samples - sums.hits[pixel];
                counts.clamped += passes.means(pixel, misses, samples, values);
            }
        }
        counts
    }
}

/// The box filter: the mean over the samples of each pixel of a tile, summed in f64.
#[derive(Clone)]
struct PixelSums {
    radiance: [Column; 3],
    hits: [u32; PIXELS],
}

impl Default for PixelSums {
    fn default() -> Self {
        Self {
            radiance: [Column::ZERO; 3],
            hits: [0; PIXELS],
        }
    }
}

impl PixelSums {
    fn clear(&mut self) {
        *self = Self::default();
    }

    /// Adds the radiance of some samples, those of each pixel in their order.
    #[inline(always)]
    fn add<S: Simd>(
        &mut self,
        simd: S,
        range: SampleRange,
        points: &Points,
        radiance: &[Column; 3],
    ) {
        let pixels = range.whole_pixels();
        for (sums, column) in self.radiance.iter_mut().zip(radiance) {
            match pixels.clone() {
                Some((1, pixels)) => add_each::<S, 1>(simd, &mut sums[pixels.start..], column),
                Some((2, pixels)) => add_each::<S, 2>(simd, &mut sums[pixels.start..], column),
                Some((4, pixels)) => add_each::<S, 4>(simd, &mut sums[pixels.start..], column),
                Some((8, pixels)) => add_each::<S, 8>(simd, &mut sums[pixels.start..], column),
                Some((16, pixels)) => add_each::<S, 16>(simd, &mut sums[pixels.start..], column),
                _ => {
                    for Run { pixel, slots } in range.runs() {
                        sums[pixel] = column[slots].iter().fold(sums[pixel], |sum, l| sum + l);
                    }
                }
            }
        }
        match pixels {
            Some((samples, pixels)) if points.all_hit() => {
                for hits in &mut self.hits[pixels] {
                    *hits += samples as u32;
                }
            }
            _ if points.none_hit() => {}
            _ => {
                for Run { pixel, slots } in range.runs() {
                    self.hits[pixel] += points.hits(slots);
                }
            }
        }
    }

    /// R, G, B, A of sixteen pixels, and what of [`Counts`] is known of the first `count` by then.
    #[inline(always)]
    fn means<S: Simd>(
        &self,
        simd: S,
        first: usize,
        count: usize,
        samples: u32,
    ) -> ([[f32; 4]; LANES], Counts) {
        let samples = f64::from(samples);
        let hits = U32x16::load(simd, &self.hits[first..]).widened(simd);
        let alpha = (hits / samples).narrowed(simd);
        let mut means = [alpha; 4];
        let mut clamped = 0;
        for (narrow, column) in means.iter_mut().zip(&self.radiance) {
            let mean = F64x16::load(simd, &column[first..]) / samples;
            let largest = F64x16::splat(simd, f64::from(f32::MAX));
            if (!mean.abs().le(largest)).any() {
                let mut values = [0.0; LANES];
                for (value, mean) in values.iter_mut().zip(mean.to_array()).take(count) {
                    let (narrow, is_clamped) = narrowed(mean);
                    *value = narrow;
                    clamped += u64::from(is_clamped);
                }
                *narrow = F32x16::load(simd, &values);
            } else {
                *narrow = mean.narrowed(simd);
            }
        }
        let [r, g, b, _] = means;
        let is_counted = Mask32x16::from_bits(simd, u32::MAX >> (u32::BITS - count as u32));
        let largest = is_counted.select(r.max(g).max(b), F32x16::splat(simd, 0.0));
        let is_beyond = largest.gt(F32x16::splat(simd, BEYOND_WHITE));
        let met = Counts {
            hits: self.hits[first..][..count]
                .iter()
                .copied()
                .map(u64::from)
                .sum(),
            clamped,
            brightest: largest.largest().max(0.0),
            beyond_white: u64::from(is_beyond.to_bits().count_ones()),
            ..Counts::default()
        };
        (side_by_side(means), met)
    }
}

/// Adds to each sum N numbers of its own, one after the other.
#[inline(always)]
fn add_each<S: Simd, const N: usize>(simd: S, sums: &mut [f64], column: &Column) {
    for (first, sums) in (0..BATCH).step_by(N * LANES).zip(sums.chunks_mut(LANES)) {
        let mut rows = [F64x16::splat(simd, 0.0); N];
        for (place, row) in rows.iter_mut().enumerate() {
            *row = F64x16::load(simd, &column[first + place * LANES..]);
        }
        let mut sum = F64x16::load(simd, sums);
        for row in every_nth(rows) {
            sum = sum + row;
        }
        sum.store(sums);
    }
}

/// Here, and nowhere before, light becomes f32; whether it was beyond the largest.
pub(super) fn narrowed(light: f64) -> (f32, bool) {
    let largest = f64::from(f32::MAX);
    if light.is_nan() {
        // Two lights at the very point, one of a color beyond the gamut: ∞ − ∞ is too large as well.
        return (f32::MAX, true);
    }
    let narrow = light.clamp(-largest, largest) as f32;
    (narrow, light.abs() > largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_narrowed_once_and_counted() {
        assert_eq!(narrowed(0.1), (0.1_f32, false));
        assert_eq!(narrowed(f64::from(f32::MAX)), (f32::MAX, false));
        // Colors beyond the gamut are negative.
        for (light, expected) in [
            (1e39, f32::MAX),
            (f64::INFINITY, f32::MAX),
            (-1e39, -f32::MAX),
            (f64::NAN, f32::MAX),
        ] {
            assert_eq!(narrowed(light), (expected, true));
        }
    }
}
