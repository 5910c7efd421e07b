//! Rendering straight into a file: the same bytes as of the finished film, without the film, and an end
//! with the first error.

use std::io::{self, Cursor, Seek, SeekFrom, Write};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};

use candela::Camera;
use candela::exr::{Compression, ExrOptions, ExrReport, Precision, Preserve, read};
use candela::image::Window;
use candela::render::{Counts, Job, Layers, Options, RenderError, RenderedTile, Renderer, Sink};
use candela::scene::{Scene, Transport};
use candela::world::{Wavelengths, World};

use crate::allocation::peak;

/// Neither side is a multiple of a tile's or a block's.
const RESOLUTION: [u32; 2] = [75, 301];

/// Not at a tile of the whole image, more than one block of every compression.
const CROP: Window = Window {
    x: 11,
    y: 3,
    width: 43,
    height: 290,
};

fn world(resolution: [u32; 2], transport: Transport) -> (World, Camera) {
    let mut scene = Scene::builtin();
    scene.image.resolution.value = resolution;
    scene.image.transport.value = transport;
    World::new(&scene).unwrap()
}

fn stream(
    (world, camera): &(World, Camera),
    options: &Options,
    progress: &(dyn Fn(u64) + Sync),
    exr: &ExrOptions,
    sink: &mut (impl Write + Seek + Send),
) -> io::Result<(Counts, ExrReport)> {
    let renderer = Renderer::new(world).unwrap();
    let job = Job::watched(progress);
    let rendered = renderer.exr(camera, options, exr, Preserve::Nothing, &job, sink)?;
    Ok((rendered.counts, rendered.report))
}

/// Renders and writes, together and one after the other, on any number of threads: one file, one
/// report.
fn assert_same(viewed: &(World, Camera), options: &Options, exr: &ExrOptions) {
    let (world, camera) = viewed;
    let renderer = Renderer::new(world).unwrap();
    let (film, counts) = renderer.film(camera, options, &Job::new()).unwrap();
    let mut file = Cursor::new(Vec::new());
    let report = film.write_exr_to(&mut file, exr).unwrap();
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        let mut streamed = Cursor::new(Vec::new());
        let progress = AtomicU64::new(0);
        let told = |pixels| {
            progress.fetch_add(pixels, Ordering::Relaxed);
        };
        let done = pool.install(|| stream(viewed, options, &told, exr, &mut streamed));
        let case = format!("{options:?} {exr:?} {threads}");
        assert_eq!(done.unwrap(), (counts, report), "{case}");
        assert!(streamed.get_ref() == file.get_ref(), "{case}");
        assert_eq!(progress.into_inner(), film.window().count(), "{case}");
    }
}

#[test]
fn the_bytes_are_those_of_the_finished_film() {
    let world = world(RESOLUTION, Transport::Auto);
    for window in [None, Some(CROP)] {
        let options = Options {
            window,
            ..Options::default()
        };
        for compression in Compression::ALL {
            for precision in [Precision::Float, Precision::Half] {
                let exr = ExrOptions {
                    precision,
                    compression,
                    ..ExrOptions::default()
                };
                assert_same(&world, &options, &exr);
            }
        }
    }
}

#[test]
fn windows_of_every_size_are_whole() {
    let world = world(RESOLUTION, Transport::Auto);
    for [width, height] in [
        [1, 1],
        [16, 16],
        [17, 15],
        [1, 33],
        [75, 1],
        [16, 32],
        [40, 257],
    ] {
        for compression in [Compression::Zips, Compression::Zip, Compression::Dwab] {
            let options = Options {
                window: Some(Window {
                    x: 0,
                    y: 44,
                    width,
                    height,
                }),
                samples: 2,
                ..Options::default()
            };
            let exr = ExrOptions {
                compression,
                ..ExrOptions::default()
            };
            assert_same(&world, &options, &exr);
        }
    }
}

#[test]
fn bands_are_streamed_as_well() {
    let world = world([75, 50], Transport::Spectral);
    for compression in [Compression::Zip, Compression::Piz] {
        for precision in [Precision::Float, Precision::Half] {
            let options = Options {
                layers: Layers {
                    spectral: Some(Wavelengths::default()),
                    ..Layers::default()
                },
                ..Options::default()
            };
            let exr = ExrOptions {
                precision,
                compression,
                ..ExrOptions::default()
            };
            assert_same(&world, &options, &exr);
        }
    }
}

/// A place that counts what is written, and keeps at most so many bytes.
struct Disk {
    free: usize,
    written: usize,
}

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.written + bytes.len() > self.free {
            return Err(io::ErrorKind::StorageFull.into());
        }
        self.written += bytes.len();
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Disk {
    fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
        Ok(0)
    }
}

#[test]
fn a_full_disk_ends_rendering() {
    let world = world([256, 256], Transport::Auto);
    let exr = ExrOptions {
        compression: Compression::None,
        ..ExrOptions::default()
    };
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        let run = |free| {
            let mut disk = Disk { free, written: 0 };
            let rendered = AtomicU64::new(0);
            let told = |pixels| {
                rendered.fetch_add(pixels, Ordering::Relaxed);
            };
            let result =
                pool.install(|| stream(&world, &Options::default(), &told, &exr, &mut disk));
            (result, rendered.into_inner(), disk.written)
        };
        // No place for the head, for the third block of 16 lines, for the offset table.
        let (result, rendered, size) = run(usize::MAX);
        result.unwrap();
        assert_eq!(rendered, 256 * 256);
        for (free, most) in [(0, 0), (150_000, 256 * 128), (size - 1, 256 * 256)] {
            let (result, rendered, _) = run(free);
            let error = result.unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::StorageFull);
            assert!(rendered <= most, "{rendered} pixels with {free} bytes");
        }
    }
}

/// What is kept of a file that is written is what is read from it, to the bit.
#[test]
fn the_image_that_is_preserved_is_what_the_file_shows() {
    let (world, camera) = world(RESOLUTION, Transport::Auto);
    let renderer = Renderer::new(&world).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("written.exr");
    let layers = Layers {
        lights: true,
        depth: true,
        normal: true,
        ..Layers::default()
    };
    for compression in Compression::ALL {
        for precision in [Precision::Float, Precision::Half] {
            for (window, layers) in [(None, Layers::default()), (Some(CROP), layers.clone())] {
                let options = Options {
                    window,
                    layers,
                    ..Options::default()
                };
                let exr = ExrOptions {
                    compression,
                    precision,
                    chromaticities: false,
                    full_window: false,
                    tile: None,
                };
                let mut file = Cursor::new(Vec::new());
                let rendered = renderer.exr(
                    &camera,
                    &options,
                    &exr,
                    Preserve::Image,
                    &Job::new(),
                    &mut file,
                );
                let preserved = rendered.unwrap().image.unwrap();
                std::fs::write(&path, file.into_inner()).unwrap();
                let shown = read(&path).unwrap();
                let case = format!("{options:?} {exr:?}");
                assert_eq!(preserved.resolution, shown.resolution, "{case}");
                assert_eq!(preserved.window, shown.window, "{case}");
                assert_eq!(preserved.has_alpha, shown.has_alpha, "{case}");
                assert_eq!(preserved.color, shown.color, "{case}");
                assert!(preserved.pixels == shown.pixels, "{case}");
            }
        }
    }
}

/// Counts tiles, and ends the render at one of them.
struct Ending<'j> {
    tiles: AtomicU64,
    at: u64,
    /// To be canceled; without, the sink breaks.
    job: Option<&'j Job<'j>>,
}

impl Sink for Ending<'_> {
    fn take(&self, tile: &RenderedTile) -> ControlFlow<()> {
        assert_eq!(tile.pixels().len() as u64, tile.window().count());
        let is_last = self.tiles.fetch_add(1, Ordering::Relaxed) + 1 == self.at;
        match self.job {
            Some(job) if is_last => job.cancel(),
            None if is_last => return ControlFlow::Break(()),
            Some(_) | None => {}
        }
        ControlFlow::Continue(())
    }
}

#[test]
fn a_job_ends_where_it_is_canceled_or_its_sink_breaks() {
    let (world, camera) = world([320, 160], Transport::Auto);
    let renderer = Renderer::new(&world).unwrap();
    let options = Options::default();
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        let job = Job::new();
        for is_canceled in [false, true] {
            let sink = Ending {
                tiles: AtomicU64::new(0),
                at: 7,
                job: is_canceled.then_some(&job),
            };
            let done = pool.install(|| renderer.tiles(&camera, &options, &job, &sink));
            assert_eq!(matches!(done, Err(RenderError::Canceled)), is_canceled);
            // Those that were begun beside the last one are there as well.
            let tiles = sink.tiles.into_inner();
            assert!((7..7 + threads as u64).contains(&tiles), "{tiles}");
        }
        assert!(renderer.film(&camera, &options, &job).is_err());
        let mut file = Cursor::new(Vec::new());
        let exr = renderer.exr(
            &camera,
            &options,
            &ExrOptions::default(),
            Preserve::Nothing,
            &job,
            &mut file,
        );
        assert!(matches!(exr, Err(RenderError::Canceled)));
    }
}

/// A film of 1024 × 1024 pixels is 16.8 MB; a strip of it is 262 kB, and what compresses it takes some
/// 2 MB whatever the image.
#[test]
fn the_film_is_never_there_as_a_whole() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1);
    let pool = pool.build().unwrap();
    let (world, camera) = world([1024, 1024], Transport::Auto);
    let mut disk = Disk {
        free: usize::MAX,
        written: 0,
    };
    let renderer = Renderer::new(&world).unwrap();
    let (result, most) = pool.install(|| {
        peak(|| {
            let (options, exr) = (Options::default(), ExrOptions::default());
            renderer.exr(
                &camera,
                &options,
                &exr,
                Preserve::Nothing,
                &Job::new(),
                &mut disk,
            )
        })
    });
    result.unwrap();
    assert!(disk.written > 1_000_000);
    assert!(most < 5_000_000, "{most}");
}
