//! Rendering to an error: the same bits for parts, threads and instructions; what is promised where the truth is known.

use candela::image::{Film, Window};
use candela::render::{
    Counts, ErrorTarget, Job, Layers, Options, OptionsError, RenderError, Renderer, SimdLevel,
};
use candela::scene::{Scene, Transport};
use candela::world::World;

const RESOLUTION: [u32; 2] = [75, 45];

fn with_errors() -> Layers {
    Layers {
        error: true,
        samples: true,
        ..Layers::default()
    }
}

fn options(relative: f64) -> Options {
    Options {
        target: Some(ErrorTarget::new(relative)),
        layers: with_errors(),
        ..Options::default()
    }
}

fn film(scene: &Scene, options: &Options) -> Result<(Film, Counts), RenderError> {
    let (world, camera) = World::new(scene).unwrap();
    let renderer = Renderer::new(&world)?;
    renderer.film(&camera, options, &Job::new())
}

fn lecture(transport: Transport) -> Scene {
    let mut scene = Scene::builtin();
    scene.image.resolution.value = RESOLUTION;
    scene.image.transport.value = transport;
    scene
}

/// R, G, B, A and all layers of a pixel, as bits.
fn bits(film: &Film, pixel: usize) -> Vec<u32> {
    let values = film.pixels()[pixel].into_iter().chain(film.values(pixel));
    values.map(f32::to_bits).collect()
}

fn assert_same(one: &Film, other: &Film) {
    for pixel in 0..one.pixels().len() {
        assert_eq!(bits(one, pixel), bits(other, pixel), "{pixel}");
    }
}

#[test]
fn threads_instructions_and_parts_make_no_difference() {
    for transport in [Transport::Rgb, Transport::Spectral] {
        let scene = lecture(transport);
        let (whole, counts) = film(&scene, &options(0.01)).unwrap();
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let again = pool
                .build()
                .unwrap()
                .install(|| film(&scene, &options(0.01)));
            let (again, counted) = again.unwrap();
            assert_same(&whole, &again);
            assert_eq!(counts, counted);
        }
        for (name, simd) in SimdLevel::available() {
            let options = Options {
                simd,
                ..options(0.01)
            };
            let (again, mut counted) = film(&scene, &options).unwrap();
            assert_same(&whole, &again);
            // How often f32 can decide depends on its rounding.
            counted.work = counts.work;
            assert_eq!(counts, counted, "{name}");
        }
        let window = Window {
            x: 7,
            y: 5,
            width: 41,
            height: 30,
        };
        let part = Options {
            window: Some(window),
            ..options(0.01)
        };
        let (part, counted) = film(&scene, &part).unwrap();
        assert_eq!(counted.errors.floor, counts.errors.floor);
        for (place, [x, y]) in window.pixels().enumerate() {
            let pixel = (y * RESOLUTION[0] + x) as usize;
            assert_eq!(bits(&part, place), bits(&whole, pixel), "{x}, {y}");
        }
    }
}

/// Other layers are made of samples, and of these R, G and B, too.
#[test]
fn layers_that_are_made_of_samples_take_samples() {
    let layers = Layers {
        lights: true,
        depth: true,
        ..with_errors()
    };
    let options = Options {
        layers,
        ..options(0.02)
    };
    let (film, counts) = film(&lecture(Transport::Rgb), &options).unwrap();
    assert_eq!(counts.errors.edges, 0);
    let names: Vec<&str> = film
        .channels()
        .list
        .iter()
        .map(|c| c.name.as_str())
        .collect();
    let last = ["Z", "error", "error_kind", "samples"];
    assert_eq!(names[names.len() - 4..], last);
    for pixel in 0..film.pixels().len() {
        let values = film.values(pixel);
        let (shares, rest) = values.split_at(values.len() - 4);
        assert!(rest[3] >= 1.0);
        for channel in 0..3 {
            let sum: f64 = shares
                .chunks(3)
                .map(|share| f64::from(share[channel]))
                .sum();
            let whole = f64::from(film.pixels()[pixel][channel]);
            assert!(
                (sum - whole).abs() <= 4.0 * f64::from(f32::EPSILON) * whole,
                "{pixel}"
            );
        }
    }
}

/// What the counts, the header and the layers say is one.
#[test]
fn counts_header_and_layers_agree() {
    let (film, counts) = film(&lecture(Transport::Rgb), &options(0.01)).unwrap();
    let errors = counts.errors;
    let film = &film;
    let channel = |index: usize| {
        let pixels = 0..film.pixels().len();
        pixels.map(move |pixel| film.values(pixel)[index])
    };
    let estimated = channel(1).filter(|kind| *kind == 1.0).count() as u64;
    assert_eq!(errors.estimated, estimated);
    assert_eq!(errors.bound() + estimated, film.pixels().len() as u64);
    let integrated = channel(2).filter(|samples| *samples == 0.0).count() as u64;
    // What samples left open and parts of the pixel told has more of them than any smooth pixel.
    let is_told_by_parts = |pixel: &usize| {
        let values = film.values(*pixel);
        values[1] == 0.0 && values[2] > 64.0
    };
    let in_parts = (0..film.pixels().len()).filter(is_told_by_parts).count() as u64;
    assert!(in_parts > 0);
    assert_eq!(errors.edges, integrated + in_parts);
    let samples: f64 = channel(2).map(f64::from).sum();
    assert_eq!(counts.primary_rays as f64, samples);
    assert!(errors.worst_bound <= 0.01 + 1e-7);
    let provenance = &film.metadata().provenance;
    let said = |name: &str| {
        let entry = provenance.iter().find(|(known, _)| known == name);
        entry.map(|(_, value)| value.as_str())
    };
    assert_eq!(said("max_error"), Some("0.01"));
    assert_eq!(said("samples"), None);
    assert_eq!(said("bound_pixels"), Some(&*errors.bound().to_string()));
    assert_eq!(said("estimated_pixels"), Some(&*estimated.to_string()));
    assert_eq!(said("unmet_pixels"), Some(&*errors.unmet.to_string()));
    assert_eq!(said("error_floor"), Some(&*errors.floor.to_string()));
    assert_eq!(said("worst_bound"), Some(&*errors.worst_bound.to_string()));
    // Relative errors are those of the layer over radiance or floor.
    let mut worst = 0.0_f64;
    for (pixel, [r, g, b, _]) in film.pixels().iter().enumerate() {
        if film.values(pixel)[1] == 1.0 {
            let least = f64::from(r.min(*g).min(*b)).max(errors.floor);
            worst = worst.max(f64::from(film.values(pixel)[0]) / least);
        }
    }
    assert!(errors.worst_estimate <= worst * (1.0 + 1e-6));
}

/// An edge at x = 0.3 pixels: a plane's half, lit from far away.
#[test]
fn an_edge_is_exact() {
    let scene = "
        [image]
        resolution = [8, 8]
        [camera.orthographic]
        eye = [0, 0, 10]
        look_at = [0, 0, 0]
        height = 8
        [materials.m.phong]
        diffuse = 0.5
        [lights.l.point]
        position = [0, 0, 10000]
        intensity = 100000000
        [objects.half.triangle]
        material = 'm'
        vertices = [[0.3, -500, 0], [1000, 0, 0], [0.3, 500, 0]]
    ";
    let scene = Scene::parse(scene, "edge.toml").unwrap();
    let (film, counts) = film(&scene, &options(1e-4)).unwrap();
    assert_eq!(counts.errors.edges, 8);
    assert_eq!(counts.errors.estimated, 0);
    // I/d² = 1 lx and L = k_d · 1 lx below the lamp; 4 m aside 2.4e-7 less.
    for (place, [r, _, _, alpha]) in film.pixels().iter().enumerate() {
        let covered = match place % 8 {
            0..4 => 0.0,
            4 => 0.7,
            _ => 1.0,
        };
        assert!(
            (f64::from(*alpha) - covered).abs() <= 6e-8,
            "{place}: {alpha}"
        );
        let off = (f64::from(*r) - 0.5 * covered).abs();
        assert!(
            off <= f64::from(film.values(place)[0]) + 2.5e-7,
            "{place}: {off}"
        );
        assert!(off <= 1e-4 * 0.5, "{place}: {off}");
    }
}

/// A camera in a closed ball with its light outside sees black, exactly.
#[test]
fn black_is_exact() {
    let scene = |ball: &str| {
        let text = format!(
            "
            [image]
            resolution = [20, 12]
            [camera.perspective]
            eye = [0, 0, 0]
            look_at = [0, 0, -1]
            vertical_fov = 50
            [materials.m.phong]
            diffuse = 0.5
            [lights.l.point]
            position = [0, 5, 0]
            intensity = 100
            [objects.shell.sphere]
            material = 'm'
            center = [0, 0, 0]
            radius = 2
            {ball}"
        );
        Scene::parse(&text, "black.toml").unwrap()
    };
    let inner = "
            [objects.ball.sphere]
            material = 'm'
            center = [0.1, 0, -1]
            radius = 0.3";
    for ball in ["", inner] {
        let (film, counts) = film(&scene(ball), &options(0.01)).unwrap();
        assert_eq!(counts.errors.unmet, 0);
        for (pixel, value) in film.pixels().iter().enumerate() {
            assert_eq!(value[..3], [0.0; 3]);
            assert_eq!(film.values(pixel)[0], 0.0);
        }
    }
}

#[test]
fn targets_out_of_range_are_refused() {
    let scene = lecture(Transport::Rgb);
    let target = ErrorTarget::new(0.01);
    for target in [
        ErrorTarget::new(0.0),
        ErrorTarget::new(-0.1),
        ErrorTarget::new(f64::NAN),
        ErrorTarget::new(1.1),
        ErrorTarget::new(1e-7),
        ErrorTarget {
            floor: Some(0.0),
            ..target
        },
        ErrorTarget {
            floor: Some(f64::INFINITY),
            ..target
        },
        ErrorTarget {
            max_samples: 0,
            ..target
        },
    ] {
        let options = Options {
            target: Some(target),
            ..Options::default()
        };
        let error = film(&scene, &options).unwrap_err();
        assert!(
            matches!(error, RenderError::Options(OptionsError::Target(_))),
            "{target:?}: {error}"
        );
    }
    let options = Options {
        layers: with_errors(),
        ..Options::default()
    };
    let error = film(&scene, &options).unwrap_err();
    assert!(matches!(
        error,
        RenderError::Options(OptionsError::NoTarget)
    ));
}

/// With few samples allowed pixels stay above the target, and are counted; a target that is easily met takes few.
#[test]
fn samples_are_bounded() {
    let scene = lecture(Transport::Rgb);
    let rays = |relative, max_samples| {
        let options = Options {
            target: Some(ErrorTarget {
                max_samples,
                ..ErrorTarget::new(relative)
            }),
            ..options(relative)
        };
        let (film, counts) = film(&scene, &options).unwrap();
        for pixel in 0..film.pixels().len() {
            assert!(film.values(pixel)[2] <= max_samples as f32);
        }
        counts
    };
    for max_samples in [1, 3, 40, 1024] {
        assert!(rays(0.001, max_samples).errors.unmet > 0, "{max_samples}");
    }
    assert!(rays(0.001, 4096).errors.unmet < rays(0.001, 40).errors.unmet);
    assert!(rays(0.2, 4096).primary_rays < rays(0.001, 4096).primary_rays);
}
