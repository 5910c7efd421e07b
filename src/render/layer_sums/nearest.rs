//! Depth and position: of the nearest of each pixel's samples. A mean would be a place between things at which there
//! is nothing.

use fearless_simd::Simd;

use super::super::batch::{NumberedSamples, PIXELS, TilePixels};
use super::super::sink::RenderedTile;
use super::super::sums::{least_of_column, narrowed};
use crate::camera::Camera;
use crate::image::BACKGROUND_DEPTH;
use crate::math::DVec3;
use crate::simd::{DVec3x16, F64x16, LANES, Mask64x16};
use crate::visibility::{BATCH, Column, PACKETS, Points, columns};

/// The nearest samples of a tile's pixels.
pub(super) struct Nearest {
    eye: DVec3,
    forward: DVec3,
    anchor: DVec3,
    /// The depths of a batch.
    column: Box<Column>,
    /// Infinite where nothing is hit.
    depths: Box<Column>,
    /// Relative to the anchor, where they are asked for.
    positions: Option<Box<[DVec3; PIXELS]>>,
}

impl Nearest {
    pub(super) fn new(camera: &Camera, anchor: DVec3, has_positions: bool) -> Self {
        Self {
            eye: camera.eye().0,
            forward: camera.forward().get(),
            anchor,
            column: Box::new(Column::ZERO),
            depths: Box::new(Column([f64::INFINITY; BATCH])),
            positions: has_positions.then(|| Box::new([DVec3::ZERO; PIXELS])),
        }
    }

    pub(super) fn clear(&mut self) {
        self.depths.fill(f64::INFINITY);
    }

    #[inline(always)]
    pub(super) fn add<S: Simd>(&mut self, simd: S, samples: NumberedSamples<'_>, points: &Points) {
        let forward = DVec3x16::splat(simd, self.forward);
        let nothing = F64x16::splat(simd, f64::INFINITY);
        for packet in 0..PACKETS {
            let position = DVec3x16::load(simd, columns(&points.position, packet));
            let depth = position.minus(self.eye).dot(forward);
            let is_hit = Mask64x16::from_bits(simd, points.hit[packet]);
            let depth = is_hit.select(depth, nothing);
            depth.store(&mut self.column[packet * LANES..]);
        }
        let Some(positions) = &mut self.positions else {
            least_of_column(simd, samples, &mut self.depths, &self.column);
            return;
        };
        let [xs, ys, zs] = &points.position;
        for (slot, pixel) in samples.iter() {
            let depth = self.column[slot];
            if depth < self.depths[pixel] {
                self.depths[pixel] = depth;
                positions[pixel] = DVec3::new(xs[slot], ys[slot], zs[slot]);
            }
        }
    }

    /// Writes Z and P to these channels.
    pub(super) fn write(
        &self,
        pixels: &TilePixels,
        depth: Option<usize>,
        position: Option<usize>,
        rendered: &mut RenderedTile,
    ) {
        let places = pixels.row_major();
        if let Some(channel) = depth {
            let values = rendered.channels_mut(channel..channel + 1);
            for (&place, &depth) in places.iter().zip(self.depths.iter()) {
                values[place as usize] = if depth == f64::INFINITY {
                    BACKGROUND_DEPTH
                } else {
                    narrowed(depth).0
                };
            }
        }
        if let Some((channel, positions)) = position.zip(self.positions.as_ref()) {
            for axis in 0..3 {
                let values = rendered.channels_mut(channel + axis..channel + axis + 1);
                let nearest = self.depths.iter().zip(positions.iter());
                for (&place, (&depth, position)) in places.iter().zip(nearest) {
                    values[place as usize] = if depth == f64::INFINITY {
                        0.0
                    } else {
                        narrowed(position[axis] + self.anchor[axis]).0
                    };
                }
            }
        }
    }
}
