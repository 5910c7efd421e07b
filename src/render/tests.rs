//! Passes over tiles: in pieces or whole, over all pixels or some, with statistics or without.

use std::ops::Range;

use super::batch::{PIXELS, Selection};
use super::scheduler::windows;
use super::sink::{ErrorChannels, RenderedTile};
use super::tile::{Kept, Setup, Space, Tile};
use super::{Layers, Options, OptionsError, Relight, Renderer};
use crate::camera::Camera;
use crate::image::Window;
use crate::scene::{Material, Metal, Scene, Transport};
use crate::world::{Wavelengths, World};

/// Whole tiles, and such that are cut off.
const RESOLUTION: [u32; 2] = [37, 21];

/// Every layer that is made of samples.
fn all() -> Layers {
    Layers {
        lights: true,
        light_diffuse: true,
        light_specular: true,
        relight: Relight::Always,
        diffuse: true,
        specular: true,
        albedo: true,
        irradiance: true,
        depth: true,
        position: true,
        normal: true,
        shadow: true,
        object_mattes: true,
        material_mattes: true,
        ..Layers::default()
    }
}

/// The lecture's scene, small, with a background that has a share of its own.
fn world(transport: Transport) -> (World, Camera) {
    with_material(transport, None)
}

/// The same with another material in place of the first.
fn with_material(transport: Transport, material: Option<Material>) -> (World, Camera) {
    let mut scene = Scene::builtin();
    if let Some(material) = material {
        scene.materials[0].value = material;
    }
    scene.image.resolution.value = RESOLUTION;
    scene.image.transport.value = transport;
    scene.image.background.value = crate::scene::Value::Uniform(0.25);
    World::new(&scene).unwrap()
}

/// Works on every tile of an image with every kind of layer, RGB and spectral, with a mirror and a metal or without.
fn for_each_tile(samples: u32, kept: Kept, work: impl Fn(&Setup<'_>, Window)) {
    let copper = || Material::Metal(Metal::Preset("copper".to_owned().into()));
    for (transport, material) in [
        (Transport::Rgb, None),
        (Transport::Spectral, None),
        (Transport::Spectral, Some(Material::mirror(0.9))),
        (Transport::Spectral, Some(copper())),
    ] {
        let is_metal = matches!(material, Some(Material::Metal(_)));
        let (world, camera) = with_material(transport, material);
        let is_spectral = transport == Transport::Spectral;
        let relight = if is_metal {
            Relight::Never
        } else {
            Relight::Always
        };
        let options = Options {
            samples,
            layers: Layers {
                spectral: is_spectral.then(Wavelengths::default),
                relight,
                ..all()
            },
            ..Options::default()
        };
        let renderer = Renderer::new(&world).unwrap();
        let each = |setup: &Setup<'_>, window| windows(window).for_each(|tile| work(setup, tile));
        renderer.set_up(&camera, &options, kept, each).unwrap();
    }
}

/// Passes over all pixels.
fn passes<'w>(setup: &Setup<'w>, window: Window, ranges: &[Range<u32>]) -> Tile<'w> {
    let mut tile = Tile::default();
    tile.begin(setup, window);
    add(setup, &mut tile, ranges, &Selection::ALL);
    tile
}

fn add<'w>(setup: &Setup<'w>, tile: &mut Tile<'w>, ranges: &[Range<u32>], selection: &Selection) {
    let mut space = Box::<Space>::default();
    for range in ranges {
        tile.pass(setup, range.clone(), selection, &mut space);
    }
}

fn means<'w>(setup: &Setup<'w>, tile: &mut Tile<'w>) -> RenderedTile {
    let mut rendered = RenderedTile::new(setup.channels(), ErrorChannels::default());
    tile.means(setup, &mut rendered);
    rendered
}

/// R, G, B, A and all further channels of each pixel of a tile, by its number.
fn pixels(tile: &Tile<'_>, rendered: &RenderedTile) -> Vec<Vec<u32>> {
    let width = rendered.window().width;
    let count = rendered.pixels().len();
    let of_pixel = |[column, row]: [u32; 2]| {
        let place = (row * width + column) as usize;
        let values = rendered.values().iter().skip(place).step_by(count);
        let all = rendered.pixels()[place].iter().chain(values);
        all.map(|value| value.to_bits()).collect()
    };
    tile.places().map(of_pixel).collect()
}

#[test]
fn passes_in_pieces_are_one_pass_to_the_bit() {
    for (samples, pieces) in [
        (16, vec![0..4, 4..16]),
        (16, vec![0..1, 1..2, 2..9, 9..16]),
        (3, vec![0..2, 2..3]),
        (300, vec![0..256, 256..300]),
    ] {
        for_each_tile(samples, Kept::Sums, |setup, window| {
            // The samples of one pixel are more than a batch: that is slow, and no matter of the tile.
            if samples > 256 && window.count() > 25 {
                return;
            }
            let mut whole = passes(setup, window, std::slice::from_ref(&(0..samples)));
            let mut parts = passes(setup, window, &pieces);
            let expected = means(setup, &mut whole);
            assert!(means(setup, &mut parts) == expected, "{samples} {window:?}");
        });
    }
}

/// The first samples of many are the few, so that an image that is shown while more come is the image
/// with few.
#[test]
fn some_of_many_samples_are_as_many() {
    let rendered = |samples: u32, range: Range<u32>| {
        let tiles = std::cell::RefCell::new(Vec::new());
        for_each_tile(samples, Kept::Sums, |setup, window| {
            let mut tile = passes(setup, window, std::slice::from_ref(&range));
            tiles.borrow_mut().push(means(setup, &mut tile));
        });
        tiles.into_inner()
    };
    assert!(rendered(16, 0..4) == rendered(4, 0..4));
}

#[test]
fn more_samples_of_some_pixels_leave_the_others() {
    let differing = std::cell::Cell::new(0);
    for_each_tile(16, Kept::Sums, |setup, window| {
        let mut few = passes(setup, window, std::slice::from_ref(&(0..4)));
        let mut many = passes(setup, window, std::slice::from_ref(&(0..16)));
        let [few, many] = [&mut few, &mut many].map(|tile| {
            let rendered = means(setup, tile);
            pixels(tile, &rendered)
        });
        let some: Vec<usize> = (0..PIXELS).filter(|pixel| pixel * 7 % 5 < 2).collect();
        for pieces in [&[4..8, 8..16][..], &[4..5, 5..16]] {
            let mut tile = passes(setup, window, std::slice::from_ref(&(0..4)));
            let selection = some.iter().copied().collect();
            add(setup, &mut tile, pieces, &selection);
            let rendered = means(setup, &mut tile);
            for (number, pixel) in pixels(&tile, &rendered).iter().enumerate() {
                let expected = if some.contains(&number) { &many } else { &few };
                assert!(*pixel == expected[number], "{number} of {window:?}");
            }
        }
        differing.set(differing.get() + usize::from(few != many));
    });
    assert!(differing.get() > 4);
}

#[test]
fn no_samples_are_black_and_nothing() {
    for_each_tile(4, Kept::Sums, |setup, window| {
        let mut tile = passes(setup, window, &[]);
        let rendered = means(setup, &mut tile);
        assert!(rendered.pixels().iter().all(|pixel| *pixel == [0.0; 4]));
    });
}

#[test]
fn statistics_change_nothing() {
    let rendered = |kept| {
        let tiles = std::cell::RefCell::new(Vec::new());
        for_each_tile(6, kept, |setup, window| {
            let mut tile = passes(setup, window, &[0..5, 5..6]);
            tiles.borrow_mut().push(means(setup, &mut tile));
        });
        tiles.into_inner()
    };
    assert!(rendered(Kept::Sums) == rendered(Kept::SumsAndStatistics));
}

fn is_near(actual: f64, expected: f64, tolerance: f64) -> bool {
    (actual - expected).abs() <= tolerance * expected.abs()
}

/// A quarter of the samples of each pass, and after four times as many the first quarter is all there was before.
#[test]
fn quarters_add_up() {
    const SAMPLES: u32 = 64;
    for_each_tile(SAMPLES, Kept::SumsAndStatistics, |setup, window| {
        let mut tile = passes(setup, window, std::slice::from_ref(&(0..16)));
        let pixels = window.count() as usize;
        let sums = |tile: &Tile<'_>| (0..pixels).map(|p| tile.sums_of(p)).collect::<Vec<_>>();
        let before = sums(&tile);
        for pixel in 0..pixels {
            tile.widen(pixel);
        }
        tile.pass(setup, 16..64, &Selection::ALL, &mut Box::default());
        for (pixel, (radiance, hits)) in sums(&tile).into_iter().enumerate() {
            let quarters = tile.statistics().unwrap().quarters(pixel);
            assert_eq!(quarters[0], before[pixel]);
            for channel in 0..3 {
                let sum: f64 = quarters.iter().map(|(part, _)| part[channel]).sum();
                assert!(is_near(sum, radiance[channel], 1e-14), "{pixel}");
            }
            assert_eq!(quarters.iter().map(|(_, hits)| hits).sum::<u32>(), hits);
        }
    });
}

/// A quarter of the sequence is a net over all of the pixel: in each of its quarters is a quarter of the samples.
#[test]
fn quarters_are_over_the_whole_pixel() {
    for_each_tile(64, Kept::SumsAndStatistics, |setup, _| {
        for quarter in 0..4 {
            let mut counts = [0; 4];
            for sample in 16 * quarter..16 * (quarter + 1) {
                // The first bits of a number are its last here.
                let [x, y] = setup.sampler.sequence(sample);
                counts[(x & 1 | (y & 1) << 1) as usize] += 1;
            }
            assert_eq!(counts, [4; 4]);
        }
    });
}

#[test]
fn means_lie_between_the_least_and_the_most() {
    for_each_tile(16, Kept::SumsAndStatistics, |setup, window| {
        let tile = passes(setup, window, std::slice::from_ref(&(0..16)));
        let mut is_spread = false;
        for pixel in 0..window.count() as usize {
            let (sums, _) = tile.sums_of(pixel);
            let statistics = tile.statistics().unwrap();
            let (least, most) = (statistics.least(pixel), statistics.most(pixel));
            for channel in 0..3 {
                // A sum of 16 may be rounded 15 times.
                let mean = sums[channel] / 16.0;
                let rounding = 16.0 * f64::EPSILON * most[channel].abs();
                assert!(least[channel] - rounding <= mean && mean <= most[channel] + rounding);
                is_spread |= least[channel] < most[channel];
            }
        }
        assert!(is_spread, "{window:?}");
    });
}

#[test]
fn options_that_do_not_fit_are_refused() {
    let (world, camera) = world(Transport::Rgb);
    let check = |options: Options| options.check(&world, &camera).unwrap_err();
    for samples in [0, super::MAX_SAMPLES + 1] {
        let options = Options {
            samples,
            ..Options::default()
        };
        assert_eq!(check(options), OptionsError::Samples(samples));
    }
    for [x, y, width, height] in [
        [0, 0, 38, 21],
        [37, 0, 1, 1],
        [0, 21, 1, 1],
        [0, 0, 0, 1],
        [0, 0, 1, 0],
        [1, 0, u32::MAX, 1],
    ] {
        let window = Window {
            x,
            y,
            width,
            height,
        };
        let options = Options {
            window: Some(window),
            ..Options::default()
        };
        let resolution = RESOLUTION;
        assert_eq!(check(options), OptionsError::Window { window, resolution });
    }
    let options = Options {
        layers: Layers {
            spectral: Some(Wavelengths::default()),
            ..all()
        },
        ..Options::default()
    };
    assert_eq!(check(options.clone()), OptionsError::Bands);
    assert!(super::render(&world, &camera, &options).is_err());
}
