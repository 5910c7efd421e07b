//! Radiance to pixels: the tiles of an image, their samples, and the box filter.

use fearless_simd::Simd;
use rayon::prelude::*;

use super::passes::Passes;
use super::sampling::Sampler;
use super::{Film, Layers, Metadata, Window};
use crate::lanes::{Door, Kernel, LANES};
use crate::shading::{self, Shaded, Term};
use crate::visibility::{BATCH, Column, Points, Visibility, Workspace};
use crate::world::{Bands, Plan, World};

/// Pixels along the side of a tile: its rays are alike enough to be traced as one batch.
const TILE: u32 = 16;

/// The most samples of a pixel.
pub const MAX_SAMPLES: u32 = 65_536;

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
    pub door: Door,
}

/// What a render took and met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Camera rays.
    pub primary_rays: u64,
    /// Points asked for a light's visibility.
    pub shadow_rays: u64,
    /// Times that a light was exactly on the point it should light (d = 0) and added nothing.
    pub singular: u64,
    /// Channels of pixels, those of layers among them, whose value is beyond ± the largest f32, and
    /// became that.
    pub clamped: u64,
}

impl Counts {
    fn and(self, other: Self) -> Self {
        Self {
            primary_rays: self.primary_rays + other.primary_rays,
            shadow_rays: self.shadow_rays + other.shadow_rays,
            singular: self.singular + other.singular,
            clamped: self.clamped + other.clamped,
        }
    }
}

impl Default for Options {
    fn default() -> Self {
        Self {
            samples: 1,
            window: None,
            layers: Layers::default(),
            door: Door::default(),
        }
    }
}

/// Renders a world: plans, builds what the plan needs, and renders with the threads of the
/// current rayon pool. The same world and options give the same bits on any number of threads.
///
/// # Panics
/// If [`Options::samples`] is out of range, [`Options::window`] is not inside the image, or
/// [`Options::layers`] has a spectral one where the world carries light as RGB.
pub fn render(world: &World, options: &Options) -> Film {
    let plan = Plan::new(world);
    let visibility = Visibility::new(world, &plan);
    render_with(world, &plan, &visibility, options, &|_| {}).0
}

/// [`render`] with the steps apart: what is built is passed in, `progress` is told after each
/// tile how many pixels it had, and what the render took comes back.
///
/// # Panics
/// As [`render`].
pub fn render_with(
    world: &World,
    plan: &Plan,
    visibility: &Visibility<'_>,
    options: &Options,
    progress: &(dyn Fn(u64) + Sync),
) -> (Film, Counts) {
    assert!(
        (1..=MAX_SAMPLES).contains(&options.samples),
        "samples are out of range"
    );
    let resolution = world.resolution();
    let window = options.window.unwrap_or(Window::whole(resolution));
    let bands = options.layers.spectral.map(|wavelengths| {
        let spectra = world.spectra();
        Bands::new(
            spectra.expect("bands are asked for where light is spectral"),
            wavelengths,
        )
    });
    let channels = options.layers.channels(world);
    let metadata = metadata(world, options, plan);
    let mut film = Film::black(resolution, window, channels, metadata);
    let sampler = Sampler::new(options.samples);
    let work = Work {
        world,
        visibility,
        samples: options.samples,
        sampler: &sampler,
        passes: Passes::new(world, options.layers, bands.as_ref()),
    };
    let tiles = film.tiles(TILE).into_par_iter();
    let tiles = tiles.map_init(Box::<Space>::default, |space, mut tile| {
        let counts = options.door.run(TileKernel {
            work,
            tile: &mut tile,
            space,
        });
        progress(u64::from(tile.window.width) * u64::from(tile.window.height));
        counts
    });
    let counts = tiles.reduce(Counts::default, Counts::and);
    (film, counts)
}

fn metadata(world: &World, options: &Options, plan: &Plan) -> Metadata {
    let plan = serde_json::to_string(plan).expect("a plan is plain data");
    let layers = options.layers.names();
    let layers = (!layers.is_empty()).then(|| ("layers".to_owned(), layers.join(",")));
    let others = [
        ("plan".to_owned(), plan),
        ("samples".to_owned(), options.samples.to_string()),
        ("scene_sha256".to_owned(), world.scene_hash().to_owned()),
    ];
    Metadata {
        color_space: world.color_space(),
        world_to_camera: world.camera().world_to_camera(world.anchor()),
        world_to_ndc: world.camera().world_to_ndc(world.anchor()),
        provenance: layers.into_iter().chain(others).collect(),
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
struct Work<'w> {
    world: &'w World,
    visibility: &'w Visibility<'w>,
    samples: u32,
    sampler: &'w Sampler,
    passes: Option<Passes<'w>>,
}

/// What a thread needs for a tile, to be used for the next as well.
struct Space {
    /// The samples' places in the image.
    positions: [Column; 2],
    tracing: Workspace,
    points: Points,
    shaded: Shaded,
    /// The pixel and the number of each sample of a batch.
    batch: Vec<(usize, u32)>,
}

impl Default for Space {
    fn default() -> Self {
        Self {
            positions: [[0.0; BATCH]; 2],
            tracing: Workspace::default(),
            points: Points::default(),
            shaded: Shaded::default(),
            batch: Vec::with_capacity(BATCH),
        }
    }
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
    /// Renders all samples of a tile's pixels, batch by batch. Samples of one pixel follow each
    /// other, and pixels come in an order that keeps neighbors together, so that the rays of a
    /// batch, and any few of them in a row, are as alike as they can be.
    #[inline(always)]
    fn render<S: Simd>(self, simd: S, tile: &mut Tile<'_>, space: &mut Space) -> Counts {
        let Self {
            world,
            samples,
            sampler,
            ..
        } = self;
        let Space {
            positions,
            tracing,
            points,
            shaded,
            batch,
        } = space;
        let Window {
            x,
            y,
            width,
            height,
        } = tile.window;
        let inside = |[column, row]: &[u32; 2]| *column < width && *row < height;
        let pixels: Vec<[u32; 2]> = (0..TILE * TILE).map(z_order).filter(inside).collect();
        let mut sums = vec![PixelSum::default(); pixels.len()];
        let mut passes = self.passes.map(|passes| passes.sums(pixels.len()));
        let mut counts = Counts::default();
        let mut samples_left =
            (0..pixels.len()).flat_map(|pixel| (0..samples).map(move |n| (pixel, n)));
        loop {
            batch.clear();
            batch.extend(samples_left.by_ref().take(BATCH));
            if batch.is_empty() {
                break;
            }
            for (slot, &(pixel, sample)) in batch.iter().enumerate() {
                let [column, row] = pixels[pixel];
                let [px, py] = sampler.position([x + column, y + row], sample);
                (positions[0][slot], positions[1][slot]) = (px, py);
            }
            let [xs, ys] = &*positions;
            self.visibility
                .see(simd, [xs, ys], batch.len(), tracing, points);
            let is_hit = |slot: usize| points.hit[slot / LANES] >> (slot % LANES) & 1 == 1;
            {
                let passes = passes.as_mut();
                let mut each = passes.and_then(|passes| passes.see(batch, points));
                let each = each.as_mut().map(|each| each as &mut dyn FnMut(Term));
                shading::radiance(simd, world, self.visibility, points, tracing, shaded, each);
            }
            for (slot, &(pixel, _)) in batch.iter().enumerate() {
                let hit = is_hit(slot);
                let seen = shaded.radiance.each_ref().map(|column| column[slot]);
                sums[pixel].hits += u32::from(hit);
                sums[pixel].add(if hit { seen } else { world.background().0.0 });
            }
            if let Some(passes) = &mut passes {
                // The last pixel may have samples in the next batch.
                passes.finish(batch[batch.len() - 1].0);
            }
            counts = counts.and(Counts {
                primary_rays: batch.len() as u64,
                shadow_rays: shaded.shadow_rays,
                singular: shaded.singular,
                clamped: 0,
            });
        }
        for (&[column, row], sum) in pixels.iter().zip(&sums) {
            let (rgba, clamped) = sum.mean(samples);
            tile.rows[row as usize][column as usize] = rgba;
            counts.clamped += clamped;
        }
        if let Some(mut passes) = passes {
            passes.finish(pixels.len());
            for (pixel, &[column, row]) in pixels.iter().enumerate() {
                let values = tile.values[row as usize]
                    .chunks_exact_mut(passes.channels())
                    .nth(column as usize)
                    .expect("the film has room for the layers of every pixel");
                let misses = samples - sums[pixel].hits;
                counts.clamped += passes.means(pixel, misses, samples, values);
            }
        }
        counts
    }
}

/// Column and row of the n-th pixel of a tile along a Z-order curve: the even and the odd bits of
/// n. Four in a row are a square, and so are four of these.
fn z_order(n: u32) -> [u32; 2] {
    let every_other_bit = |n: u32| (0..16).fold(0, |bits, bit| bits | (n >> (2 * bit) & 1) << bit);
    [every_other_bit(n), every_other_bit(n >> 1)]
}

/// The box filter of one pixel: the mean over its samples, summed in f64.
#[derive(Clone, Copy, Default)]
struct PixelSum {
    radiance: [f64; 3],
    hits: u32,
}

impl PixelSum {
    fn add(&mut self, radiance: [f64; 3]) {
        for (sum, channel) in self.radiance.iter_mut().zip(radiance) {
            *sum += channel;
        }
    }

    /// R, G, B, A, and how many channels are beyond the largest f32.
    fn mean(&self, samples: u32) -> ([f32; 4], u64) {
        let samples = f64::from(samples);
        let mean = self.radiance.map(|sum| narrowed(sum / samples));
        let clamped = mean.iter().filter(|(_, is_clamped)| *is_clamped).count();
        let [r, g, b] = mean.map(|(channel, _)| channel);
        let alpha = (f64::from(self.hits) / samples) as f32;
        ([r, g, b, alpha], clamped as u64)
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
