//! What the layers of a film keep of a tile's samples, in f64.
//!
//! ```text
//! points of a batch ─▶ LayerSums::see        normals, depths, mattes, …
//! its light, one light after the other ─▶ LayerSums::add_light
//! all samples of a tile ─▶ LayerSums::means  channel by channel
//! ```
//!
//! Most layers are sums over a pixel's samples: planes, one for each channel, to which columns of a batch are added
//! sixteen at a time ([`Planes`]). The others have a file each. Without layers there are no sums.

mod emission;
mod mattes;
mod nearest;
mod path_bands;
mod paths;
mod planes;
mod relight;
mod spectral;

use fearless_simd::Simd;

use mattes::Mattes;
use nearest::Nearest;
use planes::Planes;
use spectral::SpectralSums;

use super::arrivals::Arrivals;
use super::bands::Further;
use super::batch::{NumberedSamples, PIXELS, TilePixels};
use super::layers::{Content, Layers};
use super::shares::Shares;
use super::sink::RenderedTile;
use crate::camera::Camera;
use crate::shading::{Detail, LightTerms, Shaded};
use crate::simd::{F64x16, LANES, Mask64x16, ones};
use crate::visibility::{Column, PACKETS, Points};
use crate::world::{Bands, Reflectances, World};

/// The layers to make, and what they are made from.
pub(super) struct RequestedLayers<'w> {
    world: &'w World,
    camera: &'w Camera,
    bands: Option<&'w Bands<'w>>,
    shares: Shares,
    /// The light of each light goes to this plane of [`Content::Shadow`].
    shadows: Vec<Option<usize>>,
    /// I_v of each light in cd, where it is needed.
    candelas: Vec<f64>,
    /// k_d of each material, where it is needed.
    albedos: Vec<[f64; 3]>,
    reflectances: Option<Reflectances<'w>>,
    matte_ranks: usize,
    /// The first channel of each content, and how many there are.
    contents: Vec<(Content, usize, usize)>,
    detail: Detail,
    wants_light: bool,
}

impl<'w> RequestedLayers<'w> {
    /// `None` where no layer is asked for. `bands` are those of [`Layers::spectral`].
    pub(super) fn new(
        world: &'w World,
        camera: &'w Camera,
        layers: &Layers,
        bands: Option<&'w Bands<'w>>,
    ) -> Option<Self> {
        let mut channels = 0;
        let mut contents = Vec::new();
        for (content, list) in layers.contents(world) {
            match content {
                Content::Error | Content::Samples => {}
                _ => {
                    contents.push((content, channels, list.len()));
                    channels += list.len();
                }
            }
        }
        if contents.is_empty() {
            return None;
        }
        let has = |wanted: &[Content]| {
            contents
                .iter()
                .any(|(content, ..)| wanted.contains(content))
        };
        let lobes = [
            Content::LightDiffuse,
            Content::LightSpecular,
            Content::Diffuse,
            Content::Specular,
        ];
        let geometry = [Content::Irradiance, Content::Relight, Content::Spectral];
        let detail = Detail {
            has_radiance: has(&[Content::Lights]),
            has_lobes: has(&lobes),
            has_geometry: has(&geometry),
        };
        let shares = Shares::new(world, layers.only.as_deref());
        let lights = 0..world.lights().len();
        let mut shadows = 0;
        Some(Self {
            shadows: lights
                .clone()
                .map(|light| {
                    shares.of_light(light).map(|_| {
                        shadows += 1;
                        shadows - 1
                    })
                })
                .collect(),
            candelas: if has(&[Content::Irradiance, Content::Relight]) {
                lights.map(|light| world.candelas(light)).collect()
            } else {
                Vec::new()
            },
            albedos: if has(&[Content::Albedo]) {
                let materials = world.materials().iter();
                materials.map(|material| material.value.albedo()).collect()
            } else {
                Vec::new()
            },
            reflectances: layers.relighting(world),
            matte_ranks: layers.matte_ranks.count(),
            wants_light: detail != Detail::default() || has(&[Content::Shadow]),
            detail,
            world,
            camera,
            bands,
            shares,
            contents,
        })
    }

    /// How many channels there are.
    #[cfg(test)]
    pub(super) fn channels(&self) -> usize {
        self.contents.iter().map(|&(_, _, count)| count).sum()
    }

    /// Whether any layer is made of the light of each light.
    pub(super) fn wants_light(&self) -> bool {
        self.wants_light
    }

    /// What they need of each light.
    pub(super) fn detail(&self) -> Detail {
        self.detail
    }

    /// The first channel of a content that is asked for.
    fn place(&self, wanted: Content) -> Option<usize> {
        let mut contents = self.contents.iter();
        contents.find_map(|&(content, first, _)| (content == wanted).then_some(first))
    }

    /// The channels that are sums over samples, which are the first.
    fn planes(&self) -> usize {
        let is_plane = |content| match content {
            Content::Lights
            | Content::LightDiffuse
            | Content::LightSpecular
            | Content::Diffuse
            | Content::Specular
            | Content::Background
            | Content::Emission
            | Content::EmissionOfLights
            | Content::Reflection
            | Content::Refraction
            | Content::Albedo
            | Content::Irradiance
            | Content::Normal
            | Content::Shadow
            | Content::Relight => true,
            Content::Depth
            | Content::Position
            | Content::ObjectMattes
            | Content::MaterialMattes
            | Content::Spectral
            | Content::Error
            | Content::Samples => false,
        };
        let planes = self
            .contents
            .iter()
            .filter(|&&(content, ..)| is_plane(content));
        planes.map(|&(_, _, count)| count).sum()
    }
}

/// The sums of a tile's pixels. In a pass, samples come in the order of the pixels.
pub(super) struct LayerSums<'w> {
    requested: &'w RequestedLayers<'w>,
    planes: Planes,
    /// Depth and position.
    nearest: Option<Nearest>,
    objects: Option<Mattes>,
    materials: Option<Mattes>,
    spectral: Option<SpectralSums<'w>>,
    /// What is added to planes next.
    column: Box<Column>,
    /// What of it arrives.
    arrived: Box<Column>,
}

impl<'w> LayerSums<'w> {
    pub(super) fn new(requested: &'w RequestedLayers<'w>) -> Self {
        let has = |content| requested.place(content).is_some();
        let ranks = requested.matte_ranks;
        let world = requested.world;
        Self {
            planes: Planes::new(requested.planes(), world.has_deltas()),
            nearest: (has(Content::Depth) || has(Content::Position))
                .then(|| Nearest::new(requested.camera, world.anchor(), has(Content::Position))),
            objects: has(Content::ObjectMattes).then(|| {
                let names = world.objects().iter().map(|object| object.name.as_str());
                Mattes::new(names, ranks)
            }),
            materials: has(Content::MaterialMattes).then(|| {
                let names = world
                    .materials()
                    .iter()
                    .map(|material| material.name.as_str());
                Mattes::new(names, ranks)
            }),
            spectral: requested.bands.map(|bands| SpectralSums::new(world, bands)),
            column: Box::new(Column::ZERO),
            arrived: Box::new(Column::ZERO),
            requested,
        }
    }

    /// Forgets all samples.
    pub(super) fn begin(&mut self, pixels: usize) {
        self.planes.clear();
        if let Some(nearest) = &mut self.nearest {
            nearest.clear();
        }
        for mattes in [&mut self.objects, &mut self.materials]
            .into_iter()
            .flatten()
        {
            mattes.clear();
        }
        if let Some(spectral) = &mut self.spectral {
            spectral.begin(pixels);
        }
    }

    /// What is asked for.
    pub(super) fn requested(&self) -> &'w RequestedLayers<'w> {
        self.requested
    }

    /// Adds what the points of a batch are by themselves; `dimmed` is what glass around the eye leaves of their light,
    /// where there is any.
    #[inline(always)]
    pub(super) fn see<S: Simd>(
        &mut self,
        simd: S,
        samples: NumberedSamples<'_>,
        points: &Points,
        shaded: &Shaded,
        dimmed: Option<Arrivals<'_>>,
    ) {
        let requested = self.requested;
        if let Some(nearest) = &mut self.nearest {
            nearest.add(simd, samples, points);
        }
        if let Some(first) = requested.place(Content::Normal) {
            self.add_normals(simd, samples, points, first);
        }
        if let Some(first) = requested.place(Content::Albedo) {
            self.add_albedos(simd, samples, points, first);
        }
        if let Some(first) = requested.place(Content::Emission) {
            self.add_emission(simd, samples, points, shaded, dimmed, first);
        }
        self.add_emission_of_lights(simd, samples, points, shaded, dimmed);
        if let Some(spectral) = &mut self.spectral {
            match spectral.paths().zip(dimmed) {
                None => spectral.add_emission(requested.world, samples, points),
                Some((paths, dimmed)) => {
                    paths.add_dimmed(requested.world, samples, points, shaded, dimmed);
                }
            }
        }
        for content in [Content::Lights, Content::Background] {
            if let Some(first) = requested.place(content) {
                let first = (content, first);
                self.add_background(simd, samples, points, shaded, dimmed, first);
            }
        }
        if let Some(objects) = &mut self.objects {
            objects.add(samples, points, |slot| points.object(slot));
        }
        if let Some(materials) = &mut self.materials {
            materials.add(samples, points, |slot| points.material[slot]);
        }
    }

    /// What the points of a batch reflect with, before its lights are added.
    pub(super) fn begin_lights(&mut self, samples: NumberedSamples<'_>, shaded: &Shaded) {
        if let Some(spectral) = &mut self.spectral {
            spectral.begin_lights(samples, shaded);
        }
    }

    /// Ends a batch, all of whose paths have been followed.
    #[inline(always)]
    pub(super) fn end_batch<S: Simd>(&mut self, simd: S, samples: NumberedSamples<'_>) {
        self.planes.end_batch(simd, samples);
        if let Some(paths) = self.spectral.as_mut().and_then(SpectralSums::paths) {
            paths.end_batch(samples);
        }
    }

    /// Adds what a light does at the points of a batch.
    #[inline(always)]
    pub(super) fn add_light<S: Simd>(
        &mut self,
        simd: S,
        samples: NumberedSamples<'_>,
        shaded: &Shaded,
        terms: &LightTerms,
        dimmed: Option<Arrivals<'_>>,
    ) {
        let requested = self.requested;
        let light = terms.light;
        if let Some(share) = requested.shares.of_light(light) {
            for (content, part) in [
                (Content::Lights, &terms.radiance),
                (Content::LightDiffuse, &terms.lobes.diffuse),
                (Content::LightSpecular, &terms.lobes.specular),
            ] {
                if let Some(first) = requested.place(content) {
                    self.planes
                        .add_three(simd, samples, first + 3 * share, part);
                }
            }
            if let Some(first) = requested.place(Content::Relight) {
                self.add_relight(simd, samples, shaded, terms, (first, share), dimmed);
            }
        }
        for (content, part) in [
            (Content::Diffuse, &terms.lobes.diffuse),
            (Content::Specular, &terms.lobes.specular),
        ] {
            if let Some(first) = requested.place(content) {
                self.planes.add_three(simd, samples, first, part);
            }
        }
        if let Some(first) = requested.place(Content::Irradiance) {
            self.add_irradiance(simd, samples, terms, first);
        }
        if let Some((first, place)) = requested
            .place(Content::Shadow)
            .zip(requested.shadows[light])
        {
            self.add_shadow(simd, samples, terms, first + place);
        }
        if let Some(spectral) = &mut self.spectral {
            match spectral.paths().zip(dimmed) {
                None => spectral.add_light(shaded, terms),
                Some((paths, dimmed)) => paths.add_light(shaded, terms, dimmed),
            }
        }
    }

    #[inline(always)]
    fn add_normals<S: Simd>(
        &mut self,
        simd: S,
        samples: NumberedSamples<'_>,
        points: &Points,
        first: usize,
    ) {
        let normals = points.shading_normals();
        for (axis, normals) in normals.iter().enumerate() {
            for packet in 0..PACKETS {
                let lanes = packet * LANES..;
                let is_hit = Mask64x16::from_bits(simd, points.hit[packet]);
                let normals = F64x16::load(simd, &normals[lanes.clone()]);
                let normals = is_hit.select(normals, F64x16::splat(simd, 0.0));
                normals.store(&mut self.column[lanes]);
            }
            self.planes.add(simd, samples, first + axis, &self.column);
        }
    }

    #[inline(always)]
    fn add_albedos<S: Simd>(
        &mut self,
        simd: S,
        samples: NumberedSamples<'_>,
        points: &Points,
        first: usize,
    ) {
        for channel in 0..3 {
            for packet in 0..PACKETS {
                let lanes = packet * LANES..(packet + 1) * LANES;
                let bits = points.hit[packet];
                let is_hit = Mask64x16::from_bits(simd, bits);
                let albedos = &self.requested.albedos;
                let mut values = [0.0; LANES];
                for lane in ones(bits) {
                    values[lane] = albedos[points.material[lanes.start + lane] as usize][channel];
                }
                let values = is_hit.select(F64x16::load(simd, &values), F64x16::splat(simd, 0.0));
                values.store(&mut self.column[lanes]);
            }
            self.planes
                .add(simd, samples, first + channel, &self.column);
        }
    }

    /// E = I_v (n·ω_i) V / d², in lux.
    #[inline(always)]
    fn add_irradiance<S: Simd>(
        &mut self,
        simd: S,
        samples: NumberedSamples<'_>,
        terms: &LightTerms,
        plane: usize,
    ) {
        let candelas = F64x16::splat(simd, self.requested.candelas[terms.light]);
        for packet in 0..PACKETS {
            let lanes = packet * LANES..;
            let geometry = F64x16::load(simd, &terms.geometry.diffuse[lanes.clone()]);
            (geometry * candelas).store(&mut self.column[lanes]);
        }
        self.planes.add(simd, samples, plane, &self.column);
    }

    /// V
    #[inline(always)]
    fn add_shadow<S: Simd>(
        &mut self,
        simd: S,
        samples: NumberedSamples<'_>,
        terms: &LightTerms,
        plane: usize,
    ) {
        let (zero, one) = (F64x16::splat(simd, 0.0), F64x16::splat(simd, 1.0));
        for (packet, &bits) in terms.points.iter().enumerate() {
            let seen = match &terms.seen {
                Some(seen) => F64x16::load(simd, &seen[packet * LANES..]),
                None => one,
            };
            let values = Mask64x16::from_bits(simd, bits).select(seen, zero);
            values.store(&mut self.column[packet * LANES..]);
        }
        self.planes.add(simd, samples, plane, &self.column);
    }

    /// Ends the pass for the pixels before `end`.
    pub(super) fn finish(&mut self, end: usize, further: Further) {
        if let Some(spectral) = &mut self.spectral {
            spectral.finish(end, further);
        }
    }

    /// The values of all pixels, of which each has had so many samples and hits, channel by channel; how many are
    /// beyond the largest f32.
    #[inline(always)]
    pub(super) fn means<S: Simd>(
        &mut self,
        simd: S,
        pixels: &TilePixels,
        taken: &[u32; PIXELS],
        hits: &[u32; PIXELS],
        rendered: &mut RenderedTile,
    ) -> u64 {
        let requested = self.requested;
        let count = pixels.iter().len();
        let mut clamped = self.planes.means(simd, pixels, taken, rendered);
        if let Some(nearest) = &self.nearest {
            let [depth, position] =
                [Content::Depth, Content::Position].map(|content| requested.place(content));
            nearest.write(pixels, depth, position, rendered);
        }
        for (mattes, content) in [
            (&mut self.objects, Content::ObjectMattes),
            (&mut self.materials, Content::MaterialMattes),
        ] {
            if let Some((mattes, first)) = mattes.as_mut().zip(requested.place(content)) {
                mattes.write(pixels, taken, first, rendered);
            }
        }
        if let Some((spectral, first)) = self
            .spectral
            .as_mut()
            .zip(requested.place(Content::Spectral))
        {
            for (pixel, place) in pixels.iter().enumerate().take(count) {
                let misses = taken[pixel] - hits[pixel];
                let sums = spectral.of(pixel, misses);
                clamped += rendered.set_values(place, first, sums, f64::from(taken[pixel].max(1)));
            }
        }
        clamped
    }
}
