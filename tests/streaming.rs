//! Rendering straight into a file: the same bytes as of the finished film, without the film, and an end
//! with the first error.

use std::io::{self, Cursor, Seek, SeekFrom, Write};
use std::sync::atomic::{AtomicU64, Ordering};

use candela::Camera;
use candela::exr::{Compression, ExrOptions, ExrReport, Precision, Preserve};
use candela::image::Window;
use candela::render::{Counts, Job, Layers, Options, Renderer};
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
