//! The blocks of a part, read and decoded by many threads, as rows of R, G, B, A.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::chroma::{self, LumaChroma};
use super::codec::Codec;
use super::geometry::{Geometry, Rectangle, check_sampling, chunks};
use super::header::{Channel, Headers, SampleKind};
use super::layers::{Shape, Shown};
use super::source::Source;
use super::{ExrProblem, damaged};
use half::f16;

/// Bytes of decoded rows that a thread works on at a time, where blocks are not larger.
const BAND: u64 = 1 << 21;

/// The rows of a part.
#[derive(Debug)]
pub(super) struct Blocks {
    pub(super) source: Arc<Source>,
    /// The number that chunks of this part begin with, where they have one.
    number: Option<i32>,
    pub(super) geometry: Geometry,
    codec: Codec,
    /// Where each block is in the file, row by row of blocks.
    offsets: Vec<u64>,
    shape: Shape,
    alpha: Option<usize>,
    /// Of R, G, B in the luminance.
    weights: [f32; 3],
}

/// Values of one channel in some lines.
struct Samples {
    /// In one line that has any.
    width: usize,
    values: Vec<f32>,
}

/// Where a block is in the file.
struct Found {
    block: Rectangle,
    /// Where its pixels start.
    start: u64,
    /// How long what is before them is.
    head: usize,
    length: usize,
}

impl Blocks {
    pub(super) fn new(
        source: Arc<Source>,
        headers: &Headers,
        shown: Shown,
        weights: [f64; 3],
    ) -> Result<Self, ExrProblem> {
        let part = &headers.parts[shown.part];
        let lines = |number: u8| super::codec::compression(number).map(Codec::lines);
        let own_lines = lines(part.compression)?;
        check_sampling(part)?;
        let geometry = Geometry::new(part, own_lines);
        let codec = Codec::new(part, geometry.size)?;
        codec.check_length(geometry.size, source.length())?;

        // The tables of all parts follow the headers, 8 bytes a chunk.
        let mut start = headers.end;
        for before in &headers.parts[..shown.part] {
            let count = match before.chunk_count {
                Some(count) => count,
                None => chunks(before, lines(before.compression)?),
            };
            start = start.saturating_add(count.saturating_mul(8));
        }
        let count = geometry.count();
        if start.saturating_add(count.saturating_mul(8)) > source.length() {
            return Err(damaged("it ends in the offset table"));
        }
        let mut offsets = Vec::new();
        super::resize(&mut offsets, count as usize, 0_u64)?;
        for (table, start) in offsets.chunks_mut(1 << 13).zip((start..).step_by(1 << 16)) {
            let bytes = source.bytes_at(start, 8 * table.len())?;
            let (places, _) = bytes.as_chunks::<8>();
            for (offset, &place) in table.iter_mut().zip(places) {
                *offset = u64::from_le_bytes(place);
            }
        }
        Ok(Self {
            number: headers.is_multi_part.then_some(shown.part as i32),
            source,
            geometry,
            codec,
            offsets,
            shape: shown.channels,
            alpha: shown.alpha,
            weights: weights.map(|weight| weight as f32),
        })
    }

    /// Rows of the window that are read together, from the top.
    pub(super) fn bands(&self) -> impl Iterator<Item = Range<u32>> {
        let height = self.geometry.window.map_or(0, |window| window.height);
        let width = u64::from(self.geometry.size[0]);
        let lines = self.geometry.block[1];
        let block = (16 * width * u64::from(lines)).max(1);
        let budget = BAND * rayon::current_num_threads() as u64;
        let mut together = (budget / block).clamp(1, 1 << 16);
        if matches!(self.shape, Shape::LumaChroma(_)) && self.codec.is_sampled() {
            // Lines around a band are read once more.
            together = together.max(u64::from((4 * chroma::REACH).div_ceil(lines)));
        }
        let rows = u64::from(lines) * together;
        let origin = u64::from(self.geometry.origin[1]);
        let end = origin + u64::from(height);
        let first = origin / rows;
        (first..end.div_ceil(rows).max(first)).map(move |band| {
            let top = (band * rows).max(origin);
            let bottom = ((band + 1) * rows).min(end);
            (top - origin) as u32..(bottom - origin) as u32
        })
    }

    /// Decodes rows of the window into as many rows of pixels.
    pub(super) fn rows(&self, rows: Range<u32>, pixels: &mut [[f32; 4]]) -> Result<(), ExrProblem> {
        let Some(window) = self.geometry.window else {
            return Ok(());
        };
        pixels.fill([0.0, 0.0, 0.0, 1.0]);
        let top = self.geometry.origin[1] + rows.start;
        let bottom = self.geometry.origin[1] + rows.end;
        if self.codec.is_sampled() {
            return self.sampled_rows(top..bottom, pixels);
        }
        // Each row of blocks has its own rows of pixels.
        let lines = self.geometry.block[1];
        let mut jobs = Vec::new();
        let mut rest = pixels;
        for block in top / lines..=(bottom - 1) / lines {
            let from = top.max(block * lines);
            let to = u64::from(bottom).min(u64::from(block + 1) * u64::from(lines)) as u32;
            let length = (to - from) as usize * window.width as usize;
            let (here, below) = rest.split_at_mut(length);
            rest = below;
            jobs.push((block, from..to, here));
        }
        jobs.into_par_iter()
            .try_for_each(|(block, rows, pixels)| self.block_row(block, rows, pixels))
    }

    /// Decodes those rows of the data window that are in one row of blocks.
    fn block_row(
        &self,
        row: u32,
        rows: Range<u32>,
        pixels: &mut [[f32; 4]],
    ) -> Result<(), ExrProblem> {
        let Some(window) = self.geometry.window else {
            return Ok(());
        };
        let left = self.geometry.origin[0];
        let columns = left..left + window.width;
        let first = columns.start / self.geometry.block[0];
        let last = (columns.end - 1) / self.geometry.block[0];
        let blocks = (first..=last).into_par_iter();
        let blocks = blocks.map(|column| self.block(column, row));
        let blocks: Vec<_> = blocks.collect::<Result<_, _>>()?;
        for (block, decoded) in blocks {
            self.copy(block, &decoded, &rows, &columns, pixels);
        }
        if let Shape::LumaChroma(_) = self.shape {
            for pixel in pixels {
                let [y, ry, by, alpha] = *pixel;
                let [r, g, b] = chroma::rgb(self.weights, [y, ry, by]);
                *pixel = [r, g, b, alpha];
            }
        }
        Ok(())
    }

    /// Copies what counts of a block to its place.
    fn copy(
        &self,
        block: Rectangle,
        decoded: &[u8],
        rows: &Range<u32>,
        columns: &Range<u32>,
        pixels: &mut [[f32; 4]],
    ) {
        let width = block.width as usize;
        let bytes: usize = self.codec.channels().iter().map(|c| c.kind.bytes()).sum();
        let from = block.left.max(columns.start);
        let to = (block.left + block.width).min(columns.end);
        let is_gray = matches!(self.shape, Shape::Gray(_) | Shape::Single(_));
        let places = self.places();
        for (line, y) in decoded.chunks_exact(width * bytes).zip(block.top..) {
            if !rows.contains(&y) {
                continue;
            }
            let start = (y - rows.start) as usize * columns.len() + (from - columns.start) as usize;
            let target = &mut pixels[start..start + (to - from) as usize];
            let mut values = line;
            for (channel, place) in self.codec.channels().iter().zip(&places) {
                let (here, rest) = values.split_at(width * channel.kind.bytes());
                values = rest;
                if let &Some(place) = place {
                    copy_samples(channel, here, (from - block.left) as usize, target, place);
                }
            }
            if is_gray {
                for pixel in target {
                    [pixel[1], pixel[2]] = [pixel[0]; 2];
                }
            }
        }
    }

    /// Where in a pixel each channel of the part goes.
    fn places(&self) -> Vec<Option<usize>> {
        let place = |channel| {
            let color = self.shape.list().iter().position(|&shown| shown == channel);
            color.or_else(|| (self.alpha == Some(channel)).then_some(3))
        };
        (0..self.codec.channels().len()).map(place).collect()
    }

    /// Rows of the data window of a part where channels may have fewer samples than pixels.
    fn sampled_rows(&self, rows: Range<u32>, pixels: &mut [[f32; 4]]) -> Result<(), ExrProblem> {
        let Some(window) = self.geometry.window else {
            return Ok(());
        };
        let list = self.shape.list();
        let channels = self.codec.channels();
        let is_halved = |&channel: &usize| channels[channel].sampling == [2, 2];
        let is_filtered = matches!(self.shape, Shape::LumaChroma(_))
            && channels[list[0]].sampling == [1, 1]
            && list[1..].iter().all(is_halved);
        let reach = if is_filtered { chroma::REACH } else { 0 };
        // From a line on at which every channel has samples.
        let step = list
            .iter()
            .chain(&self.alpha)
            .map(|&c| channels[c].sampling[1]);
        let step = step.fold(1, least_common_multiple);
        let first = rows.start.saturating_sub(reach) / step * step;
        let end = (rows.end + reach).min(self.geometry.size[1]);
        let wanted: Vec<usize> = list.iter().copied().chain(self.alpha).collect();
        let samples = self.samples(first..end, &wanted)?;

        let (width, left) = (window.width as usize, self.geometry.origin[0] as usize);
        let luma_chroma = is_filtered.then(|| LumaChroma {
            weights: self.weights,
            width: self.geometry.size[0] as usize,
            height: i64::from(self.geometry.size[1]),
            first: i64::from(first),
            y: &samples[0].values,
            chroma: [&samples[1].values, &samples[2].values],
        });
        let pixels = pixels.par_chunks_exact_mut(width);
        pixels.zip(rows).for_each(|(row, line)| {
            let value = |place: usize, x: usize| {
                let [step_x, step_y] = channels[wanted[place]].sampling;
                let Samples { width, values } = &samples[place];
                let line = (line - first) / step_y;
                values[line as usize * width + (left + x) / step_x as usize]
            };
            let filtered = luma_chroma.as_ref().map(|source| source.line(line.into()));
            for (x, pixel) in row.iter_mut().enumerate() {
                let rgb = match (&filtered, self.shape) {
                    (Some(line), _) => line[left + x],
                    (None, Shape::Gray(_) | Shape::Single(_)) => [value(0, x); 3],
                    (None, Shape::Rgb(_) | Shape::Vector(_)) => [0, 1, 2].map(|c| value(c, x)),
                    (None, Shape::LumaChroma(_)) => {
                        chroma::rgb(self.weights, [0, 1, 2].map(|c| value(c, x)))
                    }
                };
                let alpha = self.alpha.map_or(1.0, |_| value(list.len(), x));
                *pixel = [rgb[0], rgb[1], rgb[2], alpha];
            }
        });
        Ok(())
    }

    /// The samples of these channels in some lines of the data window.
    fn samples(&self, rows: Range<u32>, wanted: &[usize]) -> Result<Vec<Samples>, ExrProblem> {
        let lines = self.geometry.block[1];
        let blocks = (rows.start / lines..=(rows.end - 1) / lines).into_par_iter();
        let blocks: Vec<_> = blocks
            .map(|row| self.block(0, row))
            .collect::<Result<_, _>>()?;
        let channels = self.codec.channels();
        let mut samples = Vec::new();
        for &channel in wanted {
            let mut values = Vec::new();
            let whole = self.geometry.size[0].div_ceil(channels[channel].sampling[0]) as usize;
            let most = whole * rows.len();
            values.try_reserve(most).map_err(|_| ExrProblem::NoMemory {
                bytes: 4 * most as u64,
            })?;
            samples.push(Samples {
                width: whole,
                values,
            });
        }
        for (block, decoded) in &blocks {
            let mut rest = decoded.as_slice();
            for line in block.top..block.top + block.height {
                for (number, channel) in channels.iter().enumerate() {
                    let count = self.codec.in_line(channel, *block, line);
                    let (here, below) = rest.split_at(count * channel.kind.bytes());
                    rest = below;
                    if !rows.contains(&line) {
                        continue;
                    }
                    let shown = wanted.iter().zip(&mut samples);
                    for (_, samples) in shown.filter(|(wanted, _)| **wanted == number) {
                        samples.values.extend(values(channel, here));
                    }
                }
            }
        }
        Ok(samples)
    }

    /// Every sample of these channels, each by itself, row by row of the whole data window. A channel of fewer
    /// samples than pixels is repeated.
    pub(super) fn planes(&self, wanted: &[usize]) -> Result<Vec<Vec<f32>>, ExrProblem> {
        let [width, height] = self.geometry.size;
        let width = width as usize;
        let mut planes = Vec::new();
        for _ in wanted {
            let mut plane = Vec::new();
            super::resize(&mut plane, width * height as usize, 0.0_f32)?;
            planes.push(plane);
        }
        // Each row of blocks has its own lines of every plane.
        let lines = self.geometry.block[1];
        let mut rests: Vec<&mut [f32]> = planes.iter_mut().map(Vec::as_mut_slice).collect();
        let mut jobs = Vec::new();
        for row in 0..self.geometry.blocks[1] {
            let height = self.geometry.rectangle(0, row).height as usize;
            let here = rests.iter_mut().map(|rest| {
                let (here, below) = std::mem::take(rest).split_at_mut(height * width);
                *rest = below;
                here
            });
            jobs.push((row, here.collect::<Vec<_>>()));
        }
        jobs.into_par_iter().try_for_each(|(row, mut planes)| {
            (0..self.geometry.blocks[0]).try_for_each(|column| {
                let (block, decoded) = self.block(column, row)?;
                self.part(block, &decoded, row * lines, wanted, &mut planes);
                Ok::<(), ExrProblem>(())
            })
        })?;
        if self.codec.is_sampled() {
            for (plane, &channel) in planes.iter_mut().zip(wanted) {
                let step = self.codec.channels()[channel].sampling[1] as usize;
                for line in (0..height as usize).filter(|line| line % step != 0) {
                    let from = (line - line % step) * width;
                    plane.copy_within(from..from + width, line * width);
                }
            }
        }
        Ok(planes)
    }

    /// Parts a block into the planes of these channels, of the lines from `top` on.
    fn part(
        &self,
        block: Rectangle,
        decoded: &[u8],
        top: u32,
        wanted: &[usize],
        planes: &mut [&mut [f32]],
    ) {
        let width = self.geometry.size[0] as usize;
        let mut rest = decoded;
        for line in block.top..block.top + block.height {
            for (number, channel) in self.codec.channels().iter().enumerate() {
                let count = self.codec.in_line(channel, block, line);
                let (here, below) = rest.split_at(count * channel.kind.bytes());
                rest = below;
                let step = channel.sampling[0] as usize;
                let start = (line - top) as usize * width + block.left as usize;
                for (_, plane) in wanted
                    .iter()
                    .zip(&mut *planes)
                    .filter(|(w, _)| **w == number)
                {
                    let target = &mut plane[start..start + block.width as usize];
                    for (pixels, value) in target.chunks_mut(step).zip(values(channel, here)) {
                        pixels.fill(value);
                    }
                }
            }
        }
    }

    /// A block of scan lines as the file has it before compression: line by line, in each line channel by channel.
    pub(super) fn lines(&self, row: u32) -> Result<Vec<u8>, ExrProblem> {
        Ok(self.block(0, row)?.1)
    }

    /// Bytes of a block that is not cut off, before compression.
    pub(super) fn block_bytes(&self) -> u64 {
        self.codec.bytes(self.geometry.rectangle(0, 0))
    }

    /// A block of scan lines as the file has it, with its place and its length before it.
    pub(super) fn packed(&self, row: u32) -> Result<Vec<u8>, ExrProblem> {
        let Found {
            start,
            head,
            length,
            ..
        } = self.find(0, row)?;
        self.source.bytes_at(start - head as u64, head + length)
    }

    /// Reads and decodes a block.
    fn block(&self, column: u32, row: u32) -> Result<(Rectangle, Vec<u8>), ExrProblem> {
        let Found {
            block,
            start,
            length,
            ..
        } = self.find(column, row)?;
        let bytes = self.source.bytes_at(start, length)?;
        Ok((block, self.codec.decode(block, bytes)?))
    }

    /// Finds a block in the file.
    fn find(&self, column: u32, row: u32) -> Result<Found, ExrProblem> {
        let block = self.geometry.rectangle(column, row);
        let number = row as usize * self.geometry.blocks[0] as usize + column as usize;
        let offset = self.offsets[number];
        if offset == 0 {
            return Err(damaged("a block was never written"));
        }
        // The part, the place, the length.
        let mut expected: Vec<i32> = self.number.into_iter().collect();
        if self.geometry.is_tiled {
            expected.extend([column as i32, row as i32, 0, 0]);
        } else {
            expected.push(self.geometry.start[1] + block.top as i32);
        }
        let head = self.source.bytes_at(offset, 4 * (expected.len() + 1))?;
        let (numbers, _) = head.as_chunks::<4>();
        let mut numbers = numbers.iter().map(|&bytes| i32::from_le_bytes(bytes));
        if !expected.iter().all(|&place| numbers.next() == Some(place)) {
            return Err(damaged("a block is not where the header says"));
        }
        let length = numbers.next().map(usize::try_from);
        let Some(Ok(length)) = length else {
            return Err(damaged("a block has no legal length"));
        };
        // What would be longer is stored as it is.
        if length as u64 > self.codec.bytes(block) {
            return Err(damaged("a block is longer than its pixels"));
        }
        Ok(Found {
            block,
            start: offset + head.len() as u64,
            head: head.len(),
            length,
        })
    }
}

fn least_common_multiple(a: u32, b: u32) -> u32 {
    let (mut x, mut y) = (a, b);
    while y != 0 {
        (x, y) = (y, x % y);
    }
    (a / x).saturating_mul(b)
}

/// Puts the samples of a line, from the one at `from` on, into a place of each pixel.
fn copy_samples(
    channel: &Channel,
    line: &[u8],
    from: usize,
    target: &mut [[f32; 4]],
    place: usize,
) {
    fn put<const N: usize>(
        line: &[u8],
        from: usize,
        target: &mut [[f32; 4]],
        place: usize,
        value: impl Fn([u8; N]) -> f32,
    ) {
        let (values, _) = line.as_chunks::<N>();
        for (pixel, &bytes) in target.iter_mut().zip(&values[from..]) {
            pixel[place] = value(bytes);
        }
    }
    match channel.kind {
        SampleKind::Half => put(line, from, target, place, |b| {
            f16::from_ne_bytes(b).to_f32()
        }),
        SampleKind::Float => put(line, from, target, place, f32::from_ne_bytes),
        SampleKind::Uint => put(line, from, target, place, |b| u32::from_ne_bytes(b) as f32),
    }
}

/// The samples of a line.
fn values<'l>(channel: &Channel, line: &'l [u8]) -> Box<dyn Iterator<Item = f32> + 'l> {
    let (twos, fours) = (line.as_chunks::<2>().0, line.as_chunks::<4>().0);
    match channel.kind {
        SampleKind::Half => Box::new(twos.iter().map(|&b| f16::from_ne_bytes(b).to_f32())),
        SampleKind::Float => Box::new(fours.iter().map(|&b| f32::from_ne_bytes(b))),
        SampleKind::Uint => Box::new(fours.iter().map(|&b| u32::from_ne_bytes(b) as f32)),
    }
}
