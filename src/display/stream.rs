//! From an EXR file to a PNG or a TIFF, row by row: neither picture is ever in memory as a whole. Inputs of other formats
//! are.
//!
//! One part of the threads decodes the next rows while the last ones are developed and encoded.

use std::io::{self, Write};
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::content_light::{Light, LightMeter};
use super::develop::{Develop, Seen};
use super::exposure::{self, LogSum, Meter};
use super::picture::{Prepare, Repaired, has_uncovered_light};
use super::png::{self, Counted, into_io, pixel_dimensions};
use super::provenance::Provenance;
use super::source::Source;
use super::tags::{ContentLight, Shape, Tags};
use super::tiff;
use super::{Alpha, DisplayError, Frame, Input, OutputFormat, Report, Screen, Settings};
use crate::exr::{ExrError, ExrImage};
use crate::image::Window;
use crate::memory::{self, OutOfMemory};
use crate::output::{self, Sink, Unfinished};

/// Bytes of the picture that are developed at a time, before compression.
const ENCODED: usize = 1 << 22;

/// So many rows are in memory while a PNG is encoded, where they are wide: a blank one, the one that is
/// developed, and those of the encoder with its filters. A TIFF has fewer.
const ROWS: usize = 10;

/// Makes a PNG, or a TIFF where its name says so, of an EXR file or a picture of another format, whole or not at all.
///
/// # Errors
/// If the one cannot be read or the other cannot be written; the target is then as it was.
pub fn convert(
    input: &Path,
    output: &Path,
    settings: &Settings<'_>,
    unfinished: &Unfinished,
) -> Result<Report, DisplayError> {
    convert_input(&Input::open(input, None)?, output, settings, unfinished)
}

/// Makes a PNG or TIFF of what an EXR file of the scene with this hash shows, whole or not at all: the same pixels as
/// [`convert`] makes of the file.
///
/// # Errors
/// If it cannot be written; the target is then as it was.
pub fn convert_image(
    exr: &ExrImage,
    scene_hash: &str,
    output: &Path,
    settings: &Settings<'_>,
    unfinished: &Unfinished,
) -> Result<Report, DisplayError> {
    let provenance = Provenance::of_scene(scene_hash);
    convert_source(
        &Source::Image(exr),
        &provenance,
        output,
        settings,
        unfinished,
    )
}

/// Makes a PNG or TIFF of a picture that is open, whole or not at all.
///
/// # Errors
/// As [`convert`].
pub fn convert_input(
    input: &Input,
    output: &Path,
    settings: &Settings<'_>,
    unfinished: &Unfinished,
) -> Result<Report, DisplayError> {
    let provenance = Provenance::of_input(input)?;
    convert_source(&input.into(), &provenance, output, settings, unfinished)
}

fn convert_source(
    exr: &Source<'_>,
    provenance: &Provenance,
    output: &Path,
    settings: &Settings<'_>,
    unfinished: &Unfinished,
) -> Result<Report, DisplayError> {
    let format = OutputFormat::of(output);
    if !format.holds(settings.bits) {
        return Err(DisplayError::NoFloats);
    }
    // Of the data alone, the display window is no matter.
    if settings.frame == Frame::Display || exr.window().is_none() {
        exr.check_resolution()?;
    }
    let color = exr.color().meaning();
    let primaries = settings.input.unwrap_or(color.primaries);
    let prepare = Prepare::from(&primaries, settings.shows_invalid);
    let may_have_alpha = exr.has_alpha() && settings.alpha != Alpha::Opaque;
    let (ev, mut is_uncovered) = match Meter::new(settings.exposure) {
        Err(ev) => (ev, false),
        Ok(meter) => measured(exr, Prepare::from(&primaries, false), &meter)?,
    };
    let shown = Shown::new(exr, settings.frame).and_beside(settings.drawn.columns);
    let tags = Tags {
        screen: settings.screen,
        text: provenance.texts(settings, ev),
        mastering: settings.view.mastering(settings.screen),
        // Unknown, until the pixels are written.
        content_light: has_content_light(format, settings.screen).then_some(ContentLight {
            brightest: 0.0,
            average: 0.0,
        }),
    };
    let conversion = |has_alpha| {
        let develop = Develop::new(settings, ev, has_alpha, shown.origin);
        let meter = || LightMeter::new(develop.bits(), develop.channels());
        Conversion {
            exr,
            format,
            tags: &tags,
            shown,
            prepare,
            light: tags.content_light.and_then(|_| meter()),
            develop,
            stops_at_uncovered: settings.alpha == Alpha::Auto && has_alpha,
        }
    };
    let is_auto = settings.alpha == Alpha::Auto && exr.has_alpha();
    let has_alpha = may_have_alpha && !(is_auto && is_uncovered);
    let first = conversion(has_alpha);
    let [white, peak] = first.develop.ends().map(|end| end / exposure::scale(ev));
    let done = match first.write(output, unfinished) {
        // It is begun again, without alpha.
        Err(Stop::Uncovered) => {
            is_uncovered = true;
            conversion(false).write(output, unfinished)
        }
        done => done,
    };
    let noticed = match done {
        Ok(noticed) => noticed,
        Err(Stop::Failed(error)) => return Err(error),
        Err(Stop::Uncovered) => unreachable!("only a picture with alpha stops there"),
    };

    let mut warnings = exr.warnings();
    let mut notes = Vec::new();
    if settings.input.is_none() {
        warnings.extend(color.warning);
        if color.is_assumed && exr.may_name_its_space() {
            notes.push(
                "the file names no color space and is taken for linear Rec.709; --input-space says another"
                    .to_owned(),
            );
        }
    }
    warnings.extend(noticed.repaired.warnings(settings.shows_invalid));
    if is_auto && is_uncovered {
        warnings.push(format!(
            "there is light where coverage is 0, such as a background, a glow, or traces of a \
             lossy compression: the {} has no alpha, unless --alpha keep asks for it",
            format.name()
        ));
    }
    if pixel_dimensions(exr.pixel_aspect()).is_some() {
        let told = match format {
            OutputFormat::Png => "the PNG says so, in a chunk that many programs pass over",
            OutputFormat::Tiff => {
                "the TIFF says so, in its resolutions, which many programs pass over"
            }
        };
        warnings.push(format!(
            "its pixels are not square, but {} times as wide as high; {told}",
            exr.pixel_aspect()
        ));
    }
    let [width, height] = shown.resolution.map(f64::from);
    Ok(Report {
        ev,
        is_auto: settings.exposure.is_auto(),
        view: settings.view,
        screen: settings.screen,
        resolution: shown.resolution,
        brightest: noticed.seen.brightest,
        is_black: !noticed.seen.is_visible,
        white,
        peak,
        clipped: noticed.seen.clipped as f64 / (width * height),
        warnings,
        notes,
    })
}

/// Whether a file says how bright it is in cd/m²: that of HLG depends on who looks at it.
const fn has_content_light(format: OutputFormat, screen: Screen) -> bool {
    match (format, screen) {
        (OutputFormat::Png, Screen::Rec2020Pq) => true,
        (
            OutputFormat::Png,
            Screen::Srgb | Screen::P3 | Screen::Rec2020Hlg | Screen::Rec1886 | Screen::Linear,
        )
        | (OutputFormat::Tiff, _) => false,
    }
}

/// The exposure of a file by a meter, and whether there is light without coverage.
fn measured(exr: &Source<'_>, prepare: Prepare, meter: &Meter) -> Result<(f64, bool), ExrError> {
    let mut sum = LogSum::default();
    let mut is_uncovered = false;
    let width = exr.window().map_or(1, |window| window.width as usize);
    for band in exr.bands() {
        let mut pixels = exr.rows(band)?;
        let rows = pixels.par_chunks_mut(width).map(|row| {
            prepare.apply(row);
            (meter.of_row(row), has_uncovered_light(row))
        });
        for (row, uncovered) in rows.collect::<Vec<_>>() {
            sum = sum.and(row);
            is_uncovered |= uncovered;
        }
    }
    Ok((meter.ev(sum), is_uncovered && exr.has_alpha()))
}

/// Why a conversion came to no end.
enum Stop {
    /// A PNG with alpha cannot hold what there is.
    Uncovered,
    Failed(DisplayError),
}

/// What was noticed on the way.
#[derive(Clone, Copy, Default)]
struct Noticed {
    seen: Seen,
    repaired: Repaired,
    is_uncovered: bool,
    light: Light,
}

impl Noticed {
    fn and(self, other: Self) -> Self {
        Self {
            seen: self.seen.and(other.seen),
            repaired: self.repaired.and(other.repaired),
            is_uncovered: self.is_uncovered || other.is_uncovered,
            light: self.light.and(other.light),
        }
    }
}

/// What of a file's windows is shown.
#[derive(Clone, Copy)]
struct Shown {
    /// Width and height of the PNG.
    resolution: [u32; 2],
    /// Where there is data.
    window: Option<Window>,
    /// Where its top left is in the display window.
    origin: [u32; 2],
}

impl Shown {
    fn new(exr: &Source<'_>, frame: Frame) -> Self {
        match (frame, exr.window()) {
            (Frame::Display, window) | (Frame::Data, window @ None) => Self {
                resolution: exr.resolution(),
                window,
                origin: [0, 0],
            },
            (Frame::Data, Some(window)) => Self {
                resolution: [window.width, window.height],
                window: Some(Window::whole([window.width, window.height])),
                origin: [window.x, window.y],
            },
        }
    }

    /// With so many more columns at the right, in which there is no data.
    fn and_beside(self, columns: u32) -> Self {
        let [width, height] = self.resolution;
        Self {
            resolution: [width.saturating_add(columns), height],
            ..self
        }
    }
}

/// A PNG or TIFF that is being made.
struct Conversion<'a> {
    exr: &'a Source<'a>,
    format: OutputFormat,
    tags: &'a Tags,
    shown: Shown,
    prepare: Prepare,
    develop: Develop<'a>,
    /// Where the file says how bright it is.
    light: Option<LightMeter>,
    /// Whether light without coverage is not to be written.
    stops_at_uncovered: bool,
}

impl Conversion<'_> {
    fn write(&self, output: &Path, unfinished: &Unfinished) -> Result<Noticed, Stop> {
        let mut stop = None;
        let written = output::write(output, unfinished, |sink| {
            self.write_to(sink).map_err(|error| match error {
                Halt::Stop(why) => {
                    stop = Some(why);
                    io::Error::other("stopped")
                }
                Halt::Write(error) => error,
            })
        });
        match (written, stop) {
            (_, Some(stop)) => Err(stop),
            (Ok(noticed), None) => Ok(noticed),
            (Err(error), None) => Err(Stop::Failed(error.into())),
        }
    }

    fn write_to(&self, sink: &mut dyn Sink) -> Result<Noticed, Halt> {
        match self.format {
            OutputFormat::Png => self.write_png(sink),
            OutputFormat::Tiff => self.write_tiff(sink),
        }
    }

    fn write_png(&self, sink: &mut dyn Sink) -> Result<Noticed, Halt> {
        look_for((ROWS * self.row_bytes()) as u64, "rows of the PNG")?;
        let (start, count) = (sink.stream_position()?, AtomicU64::new(0));
        let counted = Counted {
            sink: &mut *sink,
            count: &count,
        };
        let mut writer = png::begin(counted, self.shape(), self.tags)?;
        let pixels = start + count.load(Ordering::Relaxed);
        let mut rows = writer.stream_writer().map_err(into_io)?;
        let noticed = self.rows(&mut rows)?;
        rows.finish().map_err(into_io)?;
        writer.finish().map_err(into_io)?;
        if self.light.is_some() {
            let [width, height] = self.shown.resolution.map(u64::from);
            let content = noticed.light.content(width * height);
            png::tell_content_light(sink, pixels, content)?;
        }
        Ok(noticed)
    }

    fn write_tiff(&self, sink: &mut dyn Sink) -> Result<Noticed, Halt> {
        look_for((ROWS * self.row_bytes()) as u64, "rows of the TIFF")?;
        tiff::write(sink, self.shape(), self.tags, |rows| self.rows(rows))
    }

    fn shape(&self) -> Shape {
        Shape {
            resolution: self.shown.resolution,
            has_alpha: self.develop.has_alpha(),
            bits: self.develop.bits(),
            pixel_aspect: self.exr.pixel_aspect(),
        }
    }

    /// All rows, one after the other, from the top.
    fn rows(&self, rows: &mut (dyn Write + Send)) -> Result<Noticed, Halt> {
        let height = self.shown.resolution[1];
        Ok(match self.shown.window {
            None => self.blank(rows, 0..height)?,
            Some(window) => {
                let above = self.blank(rows, 0..window.y)?;
                let noticed = self.window(rows, window)?;
                let below = self.blank(rows, window.y + window.height..height)?;
                above.and(noticed).and(below)
            }
        })
    }

    fn row_bytes(&self) -> usize {
        self.shown.resolution[0] as usize * self.develop.pixel_bytes()
    }

    /// Rows that no data covers.
    fn blank(&self, rows: &mut (dyn Write + Send), blank: Range<u32>) -> Result<Noticed, Halt> {
        let mut row = vec![0; self.row_bytes()];
        let mut noticed = Noticed::default();
        for y in blank {
            self.develop.row(y, 0, &[], &mut row);
            // There may be a legend.
            noticed.light = noticed.light.and(self.light_of(&row));
            rows.write_all(&row)?;
        }
        Ok(noticed)
    }

    fn light_of(&self, row: &[u8]) -> Light {
        let light = self.light.as_ref().map(|meter| meter.of_row(row));
        light.unwrap_or_default()
    }

    /// Rows with data.
    fn window(&self, rows: &mut (dyn Write + Send), window: Window) -> Result<Noticed, Halt> {
        let mut noticed = Noticed::default();
        let mut bands = self.exr.bands();
        let mut samples = Vec::new();
        let read = |band: Option<Range<u32>>| {
            let band = band?;
            Some(self.exr.rows(band.clone()).map(|pixels| (band, pixels)))
        };
        let mut current = read(bands.next());
        while let Some(band) = current {
            let (band, pixels) = band?;
            let following = bands.next();
            let (written, next) = rayon::join(
                || self.band(rows, window, band, pixels, &mut samples),
                || read(following),
            );
            noticed = noticed.and(written?);
            current = next;
        }
        Ok(noticed)
    }

    /// Develops and encodes some rows of the window.
    fn band(
        &self,
        rows: &mut (dyn Write + Send),
        window: Window,
        band: Range<u32>,
        mut pixels: Vec<[f32; 4]>,
        samples: &mut Vec<u8>,
    ) -> Result<Noticed, Halt> {
        let (width, row_bytes) = (window.width as usize, self.row_bytes());
        let together = (ENCODED / row_bytes).clamp(1, band.len());
        samples.resize(together * row_bytes, 0);
        let mut noticed = Noticed::default();
        for (pixels, top) in pixels
            .chunks_mut(together * width)
            .zip((window.y + band.start..).step_by(together))
        {
            let pixels = pixels.par_chunks_exact_mut(width);
            let samples = &mut samples[..pixels.len() * row_bytes];
            let lines = samples.par_chunks_exact_mut(row_bytes).zip(pixels);
            let here = lines.enumerate().map(|(line, (samples, pixels))| {
                let repaired = self.prepare.apply(pixels);
                let y = top + line as u32;
                let seen = self.develop.row(y, window.x, pixels, samples);
                Noticed {
                    seen,
                    repaired,
                    is_uncovered: self.stops_at_uncovered && has_uncovered_light(pixels),
                    light: self.light_of(samples),
                }
            });
            noticed = noticed.and(here.reduce(Noticed::default, Noticed::and));
            if noticed.is_uncovered {
                return Err(Halt::Stop(Stop::Uncovered));
            }
            rows.write_all(samples)?;
        }
        Ok(noticed)
    }
}

fn look_for(bytes: u64, what: &'static str) -> io::Result<()> {
    memory::look_for(bytes).map_err(|error| out_of_memory(error, what))
}

fn out_of_memory(error: OutOfMemory, what: &'static str) -> io::Error {
    io::Error::new(io::ErrorKind::OutOfMemory, error.for_what(what))
}

/// What ends the writing of a file.
enum Halt {
    Stop(Stop),
    Write(io::Error),
}

impl From<io::Error> for Halt {
    fn from(error: io::Error) -> Self {
        Self::Write(error)
    }
}

impl From<ExrError> for Halt {
    fn from(error: ExrError) -> Self {
        Self::Stop(Stop::Failed(error.into()))
    }
}
