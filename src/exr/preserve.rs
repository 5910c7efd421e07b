//! What a file that is being written shows, without reading it back.

use std::io;
use std::sync::{Mutex, PoisonError};

use half::f16;

use super::read::{ColorTag, ExrImage};
use super::store::FileChannel;
use super::{ExrOptions, Precision};
use crate::image::{ImageSpec, Window};
use crate::memory;

/// R, G, B, A of a file that is being written, as whoever reads it will find them.
pub(super) struct Preserved {
    resolution: [u32; 2],
    window: Window,
    interop_id: &'static str,
    is_lossless: bool,
    precision: Precision,
    /// Bytes of a line before compression.
    line: usize,
    /// Where in a line R, G, B and A begin.
    starts: [usize; 4],
    pixels: Mutex<Vec<[f32; 4]>>,
}

impl Preserved {
    /// # Errors
    /// If there is not enough memory.
    pub(super) fn new(
        spec: &ImageSpec,
        options: &ExrOptions,
        channels: &[FileChannel<'_>],
    ) -> io::Result<Self> {
        let window = spec.window;
        let width = window.width as usize;
        let mut starts = [0; 4];
        let mut line = 0;
        for channel in channels {
            if let Some(place) = channel.place_in_rgba() {
                starts[place] = line;
            }
            line += width * channel.precision.bytes();
        }
        let count = width * window.height as usize;
        let mut pixels = Vec::new();
        memory::reserve(&mut pixels, count).map_err(|error| {
            let error = error.for_what("the pixels of the preview");
            io::Error::new(io::ErrorKind::OutOfMemory, error)
        })?;
        pixels.resize(count, [0.0; 4]);
        Ok(Self {
            resolution: spec.resolution,
            window,
            interop_id: spec.metadata.color_space.interop_id(),
            is_lossless: options.compression.is_lossless(options.precision),
            precision: options.precision,
            line,
            starts,
            pixels: Mutex::new(pixels),
        })
    }

    /// Whether blocks come back from compression as they were.
    pub(super) fn is_lossless(&self) -> bool {
        self.is_lossless
    }

    /// Takes a block of lines, as a file has it before compression, from this line of the window on.
    pub(super) fn add(&self, top: usize, block: &[u8]) {
        let width = self.window.width as usize;
        let mut all = self.pixels.lock().unwrap_or_else(PoisonError::into_inner);
        let rows = all[top * width..].chunks_exact_mut(width);
        for (row, line) in rows.zip(block.chunks_exact(self.line)) {
            for (place, &start) in self.starts.iter().enumerate() {
                match self.precision {
                    Precision::Float => {
                        let (values, _) = line[start..].as_chunks();
                        for (pixel, &value) in row.iter_mut().zip(values) {
                            pixel[place] = f32::from_ne_bytes(value);
                        }
                    }
                    Precision::Half => {
                        let (values, _) = line[start..].as_chunks();
                        for (pixel, &value) in row.iter_mut().zip(values) {
                            pixel[place] = f16::from_ne_bytes(value).to_f32();
                        }
                    }
                }
            }
        }
    }

    /// What the file shows, once it has all blocks.
    pub(super) fn into_image(self) -> ExrImage {
        let pixels = self.pixels.into_inner();
        ExrImage {
            resolution: self.resolution,
            window: Some(self.window),
            pixels: pixels.unwrap_or_else(PoisonError::into_inner),
            has_alpha: true,
            color: ColorTag {
                interop_id: Some(self.interop_id.to_owned()),
                chromaticities: None,
            },
        }
    }
}
