//! Tiles: the samples of their pixels, batch by batch, from rays to means.

use fearless_simd::Simd;

use super::batch::Batch;
use super::counts::Counts;
use super::layer_sums::RequestedLayers;
use super::sampling::Sampler;
use super::setup::View;
use super::sums::PixelSums;
use crate::image::Window;
use crate::shading::{self, Shaded, Terms};
use crate::simd::{Kernel, LANES, SimdLevel};
use crate::visibility::{Points, Workspace};

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
    pub(super) view: View<'w>,
    pub(super) samples: u32,
    pub(super) simd: SimdLevel,
    pub(super) sampler: &'w Sampler,
    pub(super) layers: Option<RequestedLayers<'w>>,
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
            view,
            samples,
            sampler,
            ..
        } = self;
        let View {
            world,
            visibility,
            camera,
            ..
        } = view;
        let Space {
            batch,
            sums,
            tracing,
            points,
            shaded,
        } = space;
        batch.begin(simd, sampler, tile.window);
        sums.clear();
        let mut layers = self.layers.map(|layers| layers.sums(batch.pixels().len()));
        let mut counts = Counts::default();
        while batch.next(simd, sampler) {
            visibility.see(simd, batch.samples(camera), tracing, points);
            {
                let layers = layers.as_mut();
                let mut each = layers.and_then(|layers| layers.see(batch.range(), points));
                let each = each.as_mut().map(|each| each as &mut dyn FnMut(Terms<'_>));
                shading::radiance(simd, world, visibility, points, tracing, shaded, each);
            }
            sums.add(simd, batch.range(), points, &shaded.radiance);
            if let Some(layers) = &mut layers {
                // The last pixel may have samples in the next batch.
                layers.finish(batch.range().last_pixel());
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
        if let Some(mut layers) = layers {
            layers.finish(batch.pixels().len());
            for (pixel, [column, row]) in batch.pixels().enumerate() {
                let values = tile.values[row as usize]
                    .chunks_exact_mut(layers.channels())
                    .nth(column as usize)
                    .expect("the film has room for the layers of every pixel");
                let misses = samples - sums.hits[pixel];
                counts.clamped += layers.means(pixel, misses, samples, values);
            }
        }
        counts
    }
}
