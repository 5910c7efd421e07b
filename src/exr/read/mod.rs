//! Reads OpenEXR files, ours or anyone's, row by row.
//!
//! ```text
//! source ─ header ─ layers ─ geometry ─ blocks ─ codec ─ rows of R, G, B, A
//!   │        │        │         │         │        │
//!   │        │        │         │         │        the `exr` crate, B44, chroma of fewer samples
//!   │        │        │         │         read and decoded by many threads
//!   │        │        │         windows, blocks of lines or tiles
//!   │        │        R, G, B; Y; Y, RY, BY; or the layer that is asked for
//!   │        what each part is
//!   a file, or a pipe in memory
//! ```
//!
//! Half, float or unsigned int (as the number that it is); scan lines, tiles, and of a multi-resolution image
//! the largest level; any compression but HTJ2K; many parts. Not deep pixels.
//!
//! **Memory.** The file is not trusted: what its header claims is held against the file's length before
//! memory is asked for, and every request may fail. [`ExrReader`] holds the offset table (8 bytes a
//! block), for every thread one block as the file has it and up to four times its size decoded (a row of
//! tiles at a time where there are tiles), and the rows that are asked for. Headers take at most 20 times
//! their size, and no more than some 30 MB. A pipe takes its length besides. [`read()`] takes 16 bytes for each pixel that
//! is shown.

mod b44;
mod blocks;
mod channels;
mod chroma;
mod codec;
mod color;
mod geometry;
mod header;
mod layers;
mod listing;
mod source;
mod stored;

use std::io::{self, Read};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use blocks::Blocks;
pub use channels::{ChannelName, DataWindow, ExrChannels};
pub use color::{ColorMeaning, ColorTag};
use header::Headers;
pub(crate) use header::SampleKind;
use layers::{Shape, Shown};
pub use listing::ExrLayers;
pub(super) use source::MAGIC;
use source::Source;
pub(in crate::exr) use stored::attributes_of;
pub(crate) use stored::{Attribute, StoredExr};

use crate::image::Window;
use crate::input::{Hash, is_transient};
use crate::printable::{printable, printable_path};

/// What an OpenEXR file shows: R, G, B, A inside the display window.
#[derive(Clone, Debug)]
pub struct ExrImage {
    /// Width and height of the display window.
    pub resolution: [u32; 2],
    /// The part of the display window, from its top left, that the file has pixels for; `None` if
    /// the data window lies outside.
    pub window: Option<Window>,
    /// R, G, B, A row by row from the top of `window`, as stored, RGB premultiplied by A; A is 1
    /// where the file has none. May hold infinities and NaN.
    pub pixels: Vec<[f32; 4]>,
    /// Whether the file has a channel A.
    pub has_alpha: bool,
    /// What the file says about the color space of R, G, B.
    pub color: ColorTag,
}

/// An OpenEXR file could not be read.
#[derive(Debug, thiserror::Error)]
#[error("cannot read {}: {problem}", named(path))]
pub struct ExrError {
    /// The file as the user named it.
    pub path: PathBuf,
    /// What failed.
    pub problem: ExrProblem,
}

fn named(path: &Path) -> String {
    if path == Path::new("-") {
        "standard input".to_owned()
    } else {
        printable_path(path)
    }
}

impl ExrError {
    /// Whether another machine or a later try may do better: no memory, a failing disk, a file that is
    /// gone amid the reading.
    pub fn is_transient(&self) -> bool {
        match &self.problem {
            ExrProblem::Io(error) => is_transient(error),
            ExrProblem::NoMemory { .. } => true,
            ExrProblem::NotExr
            | ExrProblem::NoRgb(_)
            | ExrProblem::NoLayer { .. }
            | ExrProblem::Unsupported(_)
            | ExrProblem::Damaged(_)
            | ExrProblem::TooLarge(..) => false,
        }
    }
}

/// Why an OpenEXR file could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExrProblem {
    /// The system reports an error.
    #[error("{0}")]
    Io(io::Error),
    /// Something else than OpenEXR.
    #[error("it is not an OpenEXR file")]
    NotExr,
    /// No part has R, G and B, or Y, outside of layers; the layers that can be named.
    #[error(
        "it has no channels R, G, B; it has {}; show one of these with --layer NAME",
        listed(.0)
    )]
    NoRgb(Vec<String>),
    /// There is no such layer; the layers that can be named.
    #[error("it has no layer `{}`; it has {}", printable(wanted), listed(names))]
    NoLayer {
        /// What was asked for.
        wanted: String,
        /// What there is.
        names: Vec<String>,
    },
    /// Legal, but of a kind that is not read.
    #[error("{0}")]
    Unsupported(String),
    /// The file contradicts itself or ends too early.
    #[error("the file is damaged or incomplete ({0})")]
    Damaged(String),
    /// A display window of more pixels than the data makes plausible.
    #[error("{0} × {1} pixels are too many for the data in it")]
    TooLarge(u32, u32),
    /// The system does not give the memory.
    #[error("out of memory: {:.1} MB more are needed than there are", *.bytes as f64 / 1e6)]
    NoMemory {
        /// What was asked for.
        bytes: u64,
    },
}

/// At most this many names are listed: a file may have thousands of channels.
const LISTED: usize = 20;

fn listed(names: &[String]) -> String {
    if names.is_empty() {
        return "nothing else that can be shown".to_owned();
    }
    let mut list = names[..names.len().min(LISTED)].join(", ");
    if names.len() > LISTED {
        list += &format!(" and {} more", names.len() - LISTED);
    }
    list
}

/// Why deep pixels are not read.
fn deep() -> ExrProblem {
    ExrProblem::Unsupported(
        "it has deep pixels, many samples in each; flatten it first, as by \
         `oiiotool in.exr --flatten -o out.exr`"
            .to_owned(),
    )
}

fn damaged(reason: &str) -> ExrProblem {
    ExrProblem::Damaged(reason.to_owned())
}

/// Makes a list `count` long, or says that there is no memory for it.
fn resize<T: Clone>(list: &mut Vec<T>, count: usize, value: T) -> Result<(), ExrProblem> {
    let more = count.saturating_sub(list.len());
    let bytes = (more as u64).saturating_mul(size_of::<T>() as u64);
    list.try_reserve_exact(more)
        .map_err(|_| ExrProblem::NoMemory { bytes })?;
    list.resize(count, value);
    Ok(())
}

/// Whether the system would give so many bytes.
fn probe(count: usize) -> Result<(), ExrProblem> {
    let mut room: Vec<u8> = Vec::new();
    room.try_reserve_exact(count)
        .map_err(|_| ExrProblem::NoMemory {
            bytes: count as u64,
        })
}

/// An OpenEXR file that is open, and what of it is shown.
#[derive(Debug)]
pub struct ExrReader {
    path: PathBuf,
    layer: Option<String>,
    blocks: Blocks,
    data_window: [i32; 4],
    display_window: [i32; 4],
    pixel_aspect: f32,
    has_alpha: bool,
    content: Content,
    color: ColorTag,
}

/// What R, G and B are of what is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Light, a gray among it.
    Light,
    /// X, Y and Z of vectors.
    Vectors,
    /// A channel by itself, three times.
    Numbers,
}

impl ExrReader {
    /// Opens a file, or a pipe or device, which is read into memory. `-` is standard input.
    ///
    /// What is shown is the layer or channel of this name: `light_key`, `N`, `Z`,
    /// `ViewLayer.Combined`, or the name of a part. Without a name, it is the first part with R, G, B and A
    /// (or Y, or Y, RY, BY) outside of layers.
    ///
    /// # Errors
    /// See [`ExrProblem`].
    pub fn open(path: &Path, layer: Option<&str>) -> Result<Self, ExrError> {
        Self::of_source(path, Source::open(path), layer, false)
    }

    /// As [`ExrReader::open`]; a layer without an A of its own has that of its part's picture. Its numbers are taken
    /// for multiplied by it, as those of candela's layers are.
    ///
    /// # Errors
    /// See [`ExrProblem`].
    pub fn open_covered(path: &Path, layer: &str) -> Result<Self, ExrError> {
        Self::of_source(path, Source::open(path), Some(layer), true)
    }

    /// As [`ExrReader::open`], for a file that comes through a stream; `path` names it in messages.
    ///
    /// # Errors
    /// See [`ExrProblem`].
    pub fn from_stream(
        path: &Path,
        stream: &mut dyn Read,
        layer: Option<&str>,
    ) -> Result<Self, ExrError> {
        Self::of_source(path, Source::of_stream(stream), layer, false)
    }

    /// As [`ExrReader::open_covered`], for a file that comes through a stream; `path` names it in messages.
    ///
    /// # Errors
    /// See [`ExrProblem`].
    pub fn covered_from_stream(
        path: &Path,
        stream: &mut dyn Read,
        layer: &str,
    ) -> Result<Self, ExrError> {
        Self::of_source(path, Source::of_stream(stream), Some(layer), true)
    }

    fn of_source(
        path: &Path,
        source: Result<Source, ExrProblem>,
        layer: Option<&str>,
        has_coverage: bool,
    ) -> Result<Self, ExrError> {
        let opened = source.and_then(|source| {
            let headers = Headers::read(&source)?;
            let mut shown = match layer {
                None => layers::unnamed(&headers)?,
                Some(layer) => layers::named(&headers, layer)?,
            };
            if has_coverage && shown.alpha.is_none() {
                shown.alpha = layers::coverage(&headers.parts[shown.part]);
            }
            let reader = Self::new(path, Arc::new(source), &headers, shown)?;
            Ok(Self {
                layer: layer.map(str::to_owned),
                ..reader
            })
        });
        opened.map_err(|problem| ExrError {
            path: path.to_path_buf(),
            problem,
        })
    }

    /// Whether a file begins as every OpenEXR file does.
    pub(crate) fn begins(start: &[u8]) -> bool {
        start.starts_with(&MAGIC)
    }

    fn new(
        path: &Path,
        source: Arc<Source>,
        headers: &Headers,
        shown: Shown,
    ) -> Result<Self, ExrProblem> {
        let part = &headers.parts[shown.part];
        if part.is_deep {
            return Err(deep());
        }
        let color = if shown.channels.is_color() {
            part.color.clone()
        } else {
            ColorTag::default()
        };
        let weights = color.meaning().primaries.luminance_weights();
        Ok(Self {
            path: path.to_path_buf(),
            layer: None,
            data_window: part.data_window,
            display_window: part.display_window,
            pixel_aspect: part.pixel_aspect,
            has_alpha: shown.alpha.is_some(),
            content: match shown.channels {
                Shape::Rgb(_) | Shape::Gray(_) | Shape::LumaChroma(_) => Content::Light,
                Shape::Vector(_) => Content::Vectors,
                Shape::Single(_) => Content::Numbers,
            },
            color,
            blocks: Blocks::new(source, headers, shown, weights)?,
        })
    }

    /// Width and height of the display window.
    pub const fn resolution(&self) -> [u32; 2] {
        self.blocks.geometry.resolution
    }

    /// Whether the display window is about as large as the data makes plausible: to be asked before
    /// anything of its size is made.
    ///
    /// # Errors
    /// [`ExrProblem::TooLarge`].
    pub fn check_resolution(&self) -> Result<(), ExrError> {
        let checked = self.blocks.geometry.check_display();
        checked.map_err(|problem| self.error(problem))
    }

    /// The part of the display window, from its top left, that there are pixels for.
    pub const fn window(&self) -> Option<Window> {
        self.blocks.geometry.window
    }

    /// Whether there is a channel A.
    pub const fn has_alpha(&self) -> bool {
        self.has_alpha
    }

    /// What it is that is shown.
    pub const fn content(&self) -> Content {
        self.content
    }

    /// What the file says about the color space; nothing for a layer that holds no colors.
    pub const fn color(&self) -> &ColorTag {
        &self.color
    }

    /// How much wider than high a pixel is.
    pub const fn pixel_aspect(&self) -> f32 {
        self.pixel_aspect
    }

    /// What the user should know about the file's header, a sentence each.
    pub fn warnings(&self) -> Vec<String> {
        if self.window().is_some() {
            return Vec::new();
        }
        let corners = |[left, top, right, bottom]: [i32; 4]| {
            format!("({left}, {top}) to ({right}, {bottom})")
        };
        vec![format!(
            "the data window, {}, is outside of the display window, {}: nothing is shown",
            corners(self.data_window),
            corners(self.display_window)
        )]
    }

    /// The hash of the whole file.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(crate) fn hash(&self) -> Result<Hash, ExrError> {
        let hashed = self.blocks.source.hash();
        hashed.map_err(|problem| self.error(problem))
    }

    /// The layer that was asked for.
    pub(crate) fn layer(&self) -> Option<&str> {
        self.layer.as_deref()
    }

    /// The rows of [`ExrReader::window`], in groups that are well read together, from the top. Together they
    /// hold some megabytes for each thread, or what one row of blocks holds.
    pub fn bands(&self) -> impl Iterator<Item = Range<u32>> {
        self.blocks.bands()
    }

    /// Reads rows of the window, as many as `pixels` has room for: R, G, B, A as stored; A is 1 where
    /// the file has none.
    ///
    /// # Errors
    /// See [`ExrProblem`].
    ///
    /// # Panics
    /// If there is not room for just these rows.
    pub fn rows(&self, rows: Range<u32>, pixels: &mut [[f32; 4]]) -> Result<(), ExrError> {
        let width = self.window().map_or(0, |window| window.width as usize);
        assert_eq!(pixels.len(), rows.len() * width, "room for the rows");
        let read = self.blocks.rows(rows, pixels);
        read.map_err(|problem| self.error(problem))
    }

    /// Rows of the window in new memory.
    ///
    /// # Errors
    /// See [`ExrProblem`].
    pub fn new_rows(&self, rows: Range<u32>) -> Result<Vec<[f32; 4]>, ExrError> {
        let width = self.window().map_or(0, |window| window.width as usize);
        let mut pixels = Vec::new();
        resize(&mut pixels, rows.len() * width, [0.0; 4]).map_err(|problem| self.error(problem))?;
        self.rows(rows, &mut pixels)?;
        Ok(pixels)
    }

    fn error(&self, problem: ExrProblem) -> ExrError {
        ExrError {
            path: self.path.clone(),
            problem,
        }
    }
}

/// Reads all of what an OpenEXR file shows.
///
/// # Errors
/// See [`ExrProblem`].
pub fn read(path: &Path) -> Result<ExrImage, ExrError> {
    let reader = ExrReader::open(path, None)?;
    reader.check_resolution()?;
    let mut pixels = Vec::new();
    if let Some(window) = reader.window() {
        let width = window.width as usize;
        let count = width * window.height as usize;
        resize(&mut pixels, count, [0.0; 4]).map_err(|problem| reader.error(problem))?;
        for band in reader.bands() {
            let range = band.start as usize * width..band.end as usize * width;
            reader.rows(band, &mut pixels[range])?;
        }
    }
    Ok(ExrImage {
        resolution: reader.resolution(),
        window: reader.window(),
        pixels,
        has_alpha: reader.has_alpha,
        color: reader.color,
    })
}
