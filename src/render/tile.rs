//! Tiles: running sums of their pixels, to which passes add samples.

use std::ops::Range;

use fearless_simd::Simd;

use super::bands::Further;
use super::batch::{Batch, PIXELS, Selection, TilePixels};
use super::counts::Counts;
use super::layer_sums::LayerSums;
use super::paths::Paths;
pub(super) use super::setup::{Kept, Setup};
use super::sink::RenderedTile;
use super::statistics::Statistics;
use super::sums::PixelSums;
use crate::image::Window;
use crate::shading::{self, LightTerms, Shaded};
use crate::simd::{Kernel, LANES};
use crate::visibility::{Points, Workspace};

/// The running sums of a tile's pixels, in the order of their samples.
///
/// Passes over ranges of samples that follow each other come to the bits of one pass over all of
/// them, whichever pixels each pass is over.
#[derive(Default)]
pub(super) struct Tile<'w> {
    pixels: TilePixels,
    /// Samples that each pixel has had.
    taken: Taken,
    sums: PixelSums,
    layers: Option<LayerSums<'w>>,
    statistics: Option<Box<Statistics>>,
    /// Whether passes add to these.
    kept: Kept,
}

/// A count for each pixel of a tile.
struct Taken([u32; PIXELS]);

impl Default for Taken {
    fn default() -> Self {
        Self([0; PIXELS])
    }
}

/// What a thread needs for a pass, to be used for the next as well.
#[derive(Default)]
pub(super) struct Space {
    batch: Batch,
    /// The sums of the pixels of a pass that is not over all.
    selected: PixelSums,
    tracing: Workspace,
    points: Points,
    shaded: Shaded,
    terms: LightTerms,
    paths: Paths,
}

impl Space {
    /// For tiles of a setup.
    pub(super) fn of(setup: &Setup<'_>) -> Box<Self> {
        let mut space = Box::<Self>::default();
        space.tracing.note_leaves(setup.met_leaves.cloned());
        space.shaded.cuts_areas = setup.cuts_areas;
        space
    }
}

impl<'w> Tile<'w> {
    /// Begins a tile, without samples.
    pub(super) fn begin(&mut self, setup: &Setup<'w>, window: Window) {
        self.pixels.begin(window);
        self.taken.0.fill(0);
        self.sums.clear();
        let pixels = self.pixels.iter().len();
        match setup.layers {
            None => self.layers = None,
            Some(requested) => {
                let layers = self.layers.get_or_insert_with(|| LayerSums::new(requested));
                layers.begin(pixels);
            }
        }
        self.keep(setup.sums);
    }

    /// What is kept of the samples from now on.
    pub(super) fn keep(&mut self, kept: Kept) {
        self.kept = kept;
        if kept == Kept::SumsAndStatistics {
            self.statistics.get_or_insert_default().clear();
        }
    }

    /// Adds these samples of some pixels, which have had all samples before these and no others.
    pub(super) fn pass(
        &mut self,
        setup: &Setup<'w>,
        samples: Range<u32>,
        selection: &Selection,
        space: &mut Space,
    ) -> Counts {
        setup.simd.run(Pass {
            setup: *setup,
            tile: self,
            samples,
            selection,
            space,
        })
    }

    /// The means of the samples so far.
    pub(super) fn means(&mut self, setup: &Setup<'w>, rendered: &mut RenderedTile) -> Counts {
        setup.simd.run(Means {
            tile: self,
            rendered,
        })
    }

    /// What is kept beside the sums, where it was asked for.
    pub(super) fn statistics(&self) -> Option<&Statistics> {
        self.statistics.as_deref()
    }

    /// Makes the samples that a pixel has had the first quarter of four times as many.
    pub(super) fn widen(&mut self, pixel: usize) {
        let (radiance, hits) = self.sums_of(pixel);
        if let Some(statistics) = &mut self.statistics {
            statistics.widen(pixel, radiance, hits);
        }
    }

    /// Column and row of each pixel, by its number.
    pub(super) fn places(&self) -> impl ExactSizeIterator<Item = [u32; 2]> {
        self.pixels.iter()
    }

    /// Σ L of a pixel, and its hits.
    pub(super) fn sums_of(&self, pixel: usize) -> ([f64; 3], u32) {
        (self.sums.radiance(pixel), self.sums.hits[pixel])
    }

    /// How many samples a pixel has had.
    pub(super) fn taken(&self, pixel: usize) -> u32 {
        self.taken.0[pixel]
    }
}

#[cfg(test)]
impl Setup<'_> {
    /// Channels beside R, G, B, A.
    pub(super) fn channels(&self) -> usize {
        self.layers
            .map_or(0, super::layer_sums::RequestedLayers::channels)
    }
}

/// A pass over a tile, on whatever instructions.
struct Pass<'t, 'w> {
    setup: Setup<'w>,
    tile: &'t mut Tile<'w>,
    samples: Range<u32>,
    selection: &'t Selection,
    space: &'t mut Space,
}

impl Kernel for Pass<'_, '_> {
    type Output = Counts;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Counts {
        let Self {
            setup,
            tile,
            samples,
            selection,
            space,
        } = self;
        let sampler = setup.sampler;
        let further = if samples.end == sampler.samples() {
            Further::None
        } else {
            Further::MayCome
        };
        let count = samples.end - samples.start;
        // What the batch before met is taken for a hint. Of another tile's, what is counted would depend on the threads.
        if setup.counts_work {
            space.points.forget();
        }
        space
            .batch
            .begin(simd, sampler, &tile.pixels, selection, samples.clone());
        let is_over_all = space.batch.is_over_all();
        if !is_over_all {
            space.selected.gather(&tile.sums, space.batch.numbers());
        }
        let mut counts = Counts::default();
        while space.batch.next(simd, sampler) {
            counts = counts.and(shade(simd, &setup, tile, space));
            let Space {
                batch,
                selected,
                points,
                shaded,
                ..
            } = &mut *space;
            let sums = if is_over_all {
                &mut tile.sums
            } else {
                selected
            };
            sums.add(simd, batch.range(), points, &shaded.radiance);
            if tile.kept == Kept::SumsAndStatistics
                && let Some(statistics) = &mut tile.statistics
            {
                statistics.add(batch.numbered(), &samples, points, &shaded.radiance);
            }
            // The last pixel may have samples in the next batch.
            finish(tile, batch.numbered().last_pixel(), further);
        }
        finish(tile, PIXELS, further);
        let numbers = space.batch.numbers();
        for &pixel in numbers {
            let taken = tile.taken.0[pixel as usize];
            debug_assert_eq!(taken, samples.start, "samples follow each other");
        }
        if is_over_all {
            // Places without a pixel as well: sixteen at a time.
            for taken in &mut tile.taken.0 {
                *taken += count;
            }
        } else {
            space.selected.scatter(&mut tile.sums, numbers);
            for &pixel in numbers {
                tile.taken.0[pixel as usize] += count;
            }
        }
        if setup.counts_work {
            counts.work = space.tracing.take_work();
        }
        counts
    }
}

/// Traces and shades a batch, and adds what layers are made of.
#[inline(always)]
fn shade<S: Simd>(simd: S, setup: &Setup<'_>, tile: &mut Tile<'_>, space: &mut Space) -> Counts {
    let Setup {
        world,
        camera,
        visibility,
        ..
    } = *setup;
    let Space {
        batch,
        tracing,
        points,
        shaded,
        terms,
        paths,
        ..
    } = space;
    let rays = batch.rays(simd, camera);
    visibility.nearest(simd, &rays, tracing, points);
    let is_dimmed = world.has_deltas() && paths.begin(simd, setup, &rays, points, shaded);
    let dimmed = if is_dimmed { paths.dimmed() } else { None };
    if let Some(layers) = &mut tile.layers {
        layers.see(simd, batch.numbered(), points, shaded, dimmed);
    }
    match &mut tile.layers {
        Some(layers) if layers.requested().wants_light() => {
            let detail = layers.requested().detail();
            shading::begin_terms(simd, world, visibility, points, tracing, shaded);
            layers.begin_lights(batch.numbered(), shaded);
            for lit in 0..shaded.lit() {
                shading::light_terms(simd, world, points, lit, detail, shaded, terms);
                if is_dimmed {
                    paths.dim(&mut terms.radiance);
                    paths.dim(&mut terms.lobes.diffuse);
                    paths.dim(&mut terms.lobes.specular);
                }
                layers.add_light(simd, batch.numbered(), shaded, terms, dimmed);
            }
        }
        _ => shading::radiance(simd, world, visibility, points, tracing, shaded),
    }
    if is_dimmed {
        paths.dim(&mut shaded.radiance);
    }
    let counts = Counts {
        primary_rays: batch.len() as u64,
        shadow_rays: shaded.shadow_rays,
        lit: shaded.lit_points,
        singular: shaded.singular,
        ..Counts::default()
    };
    if !world.has_deltas() {
        return counts;
    }
    let samples = batch.numbered();
    let layers = tile.layers.as_mut();
    let followed = paths.follow(simd, setup, points, shaded, samples, tracing, layers);
    if let Some(layers) = &mut tile.layers {
        layers.end_batch(simd, samples);
    }
    counts.and(followed)
}

/// Ends a pass for the pixels before `end`.
#[inline(always)]
fn finish(tile: &mut Tile<'_>, end: usize, further: Further) {
    if let Some(layers) = &mut tile.layers {
        layers.finish(end, further);
    }
}

/// The means of a tile, on whatever instructions.
struct Means<'t, 'w> {
    tile: &'t mut Tile<'w>,
    rendered: &'t mut RenderedTile,
}

impl Kernel for Means<'_, '_> {
    type Output = Counts;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Counts {
        let Self { tile, rendered } = self;
        let Tile {
            pixels,
            taken: Taken(taken),
            sums,
            layers,
            ..
        } = tile;
        rendered.begin(pixels.window());
        let mut counts = Counts::default();
        let mut places = pixels.iter();
        for first in (0..places.len()).step_by(LANES) {
            let count = places.len().min(LANES);
            let (means, met) = sums.means(simd, first, count, taken);
            for (mean, place) in means.into_iter().zip(places.by_ref()) {
                rendered.set(place, mean);
            }
            counts = counts.and(met);
        }
        if let Some(layers) = layers {
            counts.clamped += layers.means(simd, pixels, taken, &sums.hits, rendered);
        }
        counts
    }
}
