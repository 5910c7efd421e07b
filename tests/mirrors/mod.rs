//! Mirrors, metals, glass and panes: closed forms through the whole program, images in plane mirrors, the sums of
//! layers, and the same bits whatever renders them.

mod agreement;
mod bands;
mod color;
mod inside;

use candela::image::Window;
use candela::render::{Job, Layers, Options, Renderer};
use candela::scene::Scene;
use candela::world::World;

use crate::images::{assert_same_everywhere, film_of_text};
use crate::measured::{HALF_LAST_BIT, Measured};

/// Relative error where nothing but the rounding to f32 is between the closed form and the pixel.
const ROUNDING: f64 = Measured::ROOM * HALF_LAST_BIT;

/// R, G, B of the one pixel of a scene.
fn pixel(text: &str) -> [f64; 3] {
    let [r, g, b, _] = film_of_text(text, &Options::default()).pixels()[0];
    [r, g, b].map(f64::from)
}

fn assert_near(actual: f64, expected: f64, what: &str) {
    let error = (actual / expected - 1.0).abs();
    assert!(error <= ROUNDING, "{what}: {actual}, expected {expected}");
}

/// A ray that meets the plane y = 0, which is of the material `m`, at an angle to its normal, with a background of 1.
fn at_angle(degrees: f64, material: &str, more: &str) -> String {
    let (sin, cos) = degrees.to_radians().sin_cos();
    format!(
        "[image]\nresolution = [1, 1]\nbackground = 1\n{more}\n\
         [camera.orthographic]\neye = [{sin:?}, {cos:?}, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\nheight = 1e-9\n\
         [materials.m.{material}\n\
         [objects.o.plane]\nmaterial = \"m\"\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n"
    )
}

/// Fresnel's reflectances of metals, against published numbers: a background of 1 seen in them.
#[test]
fn metals_reflect_as_fresnel_says() {
    for (n, k, expected) in [
        (
            0.2,
            3.0,
            [
                (0.0, 0.923371647510),
                (60.0, 0.918411084659),
                (85.0, 0.963598561778),
            ],
        ),
        (
            2.9,
            3.1,
            [
                (0.0, 0.532634971797),
                (60.0, 0.515658688218),
                (85.0, 0.660118722346),
            ],
        ),
    ] {
        for (degrees, reflectance) in expected {
            for transport in ["rgb", "spectral"] {
                let metal = format!("metal]\nn = {n}\nk = {k}");
                let text = at_angle(degrees, &metal, &format!("transport = \"{transport}\""));
                for channel in pixel(&text) {
                    // In spectral light white is white up to what a sum of 471 numbers is rounded by.
                    assert_near(
                        channel,
                        reflectance,
                        &format!("{n} + {k}i at {degrees}°, {transport}"),
                    );
                }
            }
        }
    }
}

/// R and T of a thin pane add up to 1, and so does what is seen of a background of 1.
#[test]
fn panes_reflect_what_they_do_not_let_through() {
    for degrees in [0.0, 30.0, 60.0, 85.0] {
        let text = at_angle(degrees, "pane]\nn = 1.5", "");
        assert_near(pixel(&text)[0], 1.0, &format!("{degrees}°"));
    }
    // What comes along the ray is T, of a pane before a mirror that reflects nothing.
    let text = at_angle(60.0, "pane]\nn = 1.5", "")
        + "[materials.black.mirror]\nreflectance = 0\n\
           [objects.behind.plane]\nmaterial = \"black\"\npoint = [0, -1, 0]\nnormal = [0, 1, 0]\n";
    assert_near(pixel(&text)[0], 0.163767537290, "R at 60°");
}

/// A mirror with Schlick's approximation, and a coat over a surface that no light reaches.
#[test]
fn schlick_mirrors_and_coats() {
    for degrees in [0.0_f64, 45.0, 80.0] {
        let rise = (1.0 - degrees.to_radians().cos()).powi(5);
        let expected = 0.04 + 0.96 * rise;
        for material in [
            "mirror]\nreflectance = 0.04\nschlick = true",
            "phong]\ndiffuse = 0.5\nreflectance = 0.04\nschlick = true",
        ] {
            assert_near(
                pixel(&at_angle(degrees, material, ""))[0],
                expected,
                material,
            );
        }
    }
    // L = R L_r + (1 − R) L_lobes, L_lobes = k_d I/d² of a light above.
    let text = at_angle(0.0, "phong]\ndiffuse = 0.5\nreflectance = 0.25", "")
        + "[lights.l.point]\nposition = [0, 2, 0]\nintensity = 8\n";
    assert_near(pixel(&text)[0], 0.25 + 0.75 * 0.5 * 8.0 / 4.0, "coat");
}

/// Two planes under coats that face each other, a light between them: L = (1 − R) L_0 Σ Rᵏ = L_0 (1 − Rᴰ⁺¹), D the
/// depth.
#[test]
fn facing_coats_are_a_geometric_series() {
    for (reflectance, depth) in [(0.5_f64, 0), (0.5, 1), (0.5, 8), (0.9, 60), (0.999, 1000)] {
        let text = format!(
            "[image]\nresolution = [1, 1]\nmax_depth = {depth}\n\
             [camera.orthographic]\neye = [0, 1, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\nheight = 1e-9\n\
             [materials.m.phong]\ndiffuse = 0.2\nreflectance = {reflectance}\n\
             [lights.l.point]\nposition = [0, 1, 0]\nintensity = 10\n\
             [objects.low.plane]\nmaterial = \"m\"\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n\
             [objects.high.plane]\nmaterial = \"m\"\npoint = [0, 2, 0]\nnormal = [0, -1, 0]\n"
        );
        let expected = 0.2 * 10.0 * (1.0 - reflectance.powi(depth + 1));
        assert_near(
            pixel(&text)[0],
            expected,
            &format!("{reflectance}, {depth}"),
        );
    }
}

/// A body of clear glass before a background of 1 is not seen: what it reflects and what it lets through add up to 1,
/// but for what the depth leaves out.
#[test]
fn a_furnace_hides_glass() {
    let text = "[image]\nresolution = [24, 24]\nbackground = 1\nmax_depth = 60\n\
        [camera.perspective]\neye = [0, 0, 4]\nlook_at = [0, 0, 0]\nvertical_fov = 40\n\
        [materials.g.glass]\nn = 1.5\n\
        [objects.o.sphere]\nmaterial = \"g\"\ncenter = [0, 0, 0]\nradius = 1\n";
    let film = film_of_text(text, &Options::default());
    for (place, pixel) in film.pixels().iter().enumerate() {
        let error = (f64::from(pixel[0]) - 1.0).abs();
        assert!(error < 1e-6, "{place}: {pixel:?}");
    }
}

/// Light that goes straight through a slab of glass with two faces: (1 − F)² e^(−σx) Σ (F e^(−σx))²ᵏ.
#[test]
fn glass_absorbs_by_the_metre() {
    let folder = tempfile::tempdir().unwrap();
    let slab = "v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nv -9 -9 2\nv 9 -9 2\nv 9 9 2\nv -9 9 2\n\
        f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    std::fs::write(folder.path().join("slab.obj"), slab).unwrap();
    let text = "[image]\nresolution = [1, 1]\nbackground = 1\nmax_depth = 40\n\
        [camera.orthographic]\neye = [0.3, 0.2, 5]\nlook_at = [0.3, 0.2, 0]\nheight = 1e-9\n\
        [materials.g.glass]\nn = 1.5\nabsorption = [0.5, 0.25, 0]\n\
        [objects.o.mesh]\nmaterial = \"g\"\nfile = \"slab.obj\"\n";
    let path = folder.path().join("slab.toml");
    std::fs::write(&path, text).unwrap();
    let loaded = World::load(&path).unwrap_or_else(|error| panic!("{error}"));
    let renderer = Renderer::new(&loaded.world).unwrap();
    let film = renderer.film(&loaded.camera, &Options::default(), &Job::new());
    let [r, g, b, _] = film.unwrap().0.pixels()[0].map(f64::from);
    for (actual, sigma) in [(r, 0.5_f64), (g, 0.25), (b, 0.0)] {
        let left = (-sigma * 2.0).exp();
        let face = 0.04;
        let square = (face * left).powi(2);
        let through = (1.0 - face).powi(2) * left / (1.0 - square);
        let back = face + (1.0 - face).powi(2) * face * left.powi(2) / (1.0 - square);
        assert_near(actual, through + back, &format!("σ = {sigma}"));
    }
}

/// The image in a plane mirror is that of the mirrored eye, to the bit where the mirrored numbers are exact.
#[test]
fn a_plane_mirror_shows_what_the_mirrored_eye_sees() {
    let things = "[materials.w.phong]\ndiffuse = [0.3, 0.2, 0.1]\nspecular = 0.4\nshininess = 30\n\
        [lights.l.point]\nposition = [1, 2, 0.5]\nintensity = 50\n\
        [objects.ball.sphere]\nmaterial = \"w\"\ncenter = [0.3, -0.1, -1.5]\nradius = 0.5\n\
        [objects.ball2.sphere]\nmaterial = \"w\"\ncenter = [-0.7, 0.1, 2.5]\nradius = 0.6\n\
        [objects.t.triangle]\nmaterial = \"w\"\nvertices = [[-1, -1, -2], [1.5, -1, 3], [1.2, -0.8, -3]]\n";
    let image = "[image]\nresolution = [161, 100]\nbackground = [0.1, 0.2, 0.3]\n";
    let mirror = "[materials.m.mirror]\nreflectance = 1\n\
        [objects.m.plane]\nmaterial = \"m\"\npoint = [0, 0, -4]\nnormal = [0, 0, 1]\n";
    let camera = |z: f64| {
        format!(
            "[camera.perspective]\neye = [0.25, 0.5, {z:?}]\nlook_at = [0.25, 0.5, -4]\nvertical_fov = 50\n"
        )
    };
    // The eye sees nothing but the mirror; the mirrored eye sees the other way round.
    let seen = film_of_text(
        &format!("{image}{}{mirror}{things}", camera(-3.5)),
        &Options::default(),
    );
    let expected = film_of_text(
        &format!("{image}{}{things}", camera(-4.5)),
        &Options::default(),
    );
    let mut lit = 0;
    for (place, &[r, g, b, alpha]) in seen.pixels().iter().enumerate() {
        let (x, y) = (place % 161, place / 161);
        let mirrored = expected.pixels()[y * 161 + 160 - x];
        assert_eq!([r, g, b], mirrored[..3], "{x}, {y}");
        assert_eq!(alpha, 1.0);
        lit += usize::from(r > 0.2);
    }
    assert!(lit > 500, "{lit}");
}

/// A pane before a lamp lets T(θ) of its light through.
#[test]
fn light_comes_through_panes() {
    let floor = |lights: &str, more: &str| {
        format!(
            "[image]\nresolution = [1, 1]\n\
             [camera.orthographic]\neye = [0, 0.5, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\nheight = 1e-9\n\
             [materials.m.phong]\ndiffuse = 0.25\n[materials.p.pane]\nn = 1.5\n\
             [objects.floor.plane]\nmaterial = \"m\"\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n{lights}{more}"
        )
    };
    let pane = "[objects.pane.plane]\nmaterial = \"p\"\npoint = [0, 1, 0]\nnormal = [0, 1, 0]\n";
    let second = "[objects.second.triangle]\nmaterial = \"p\"\nvertices = [[-9, 1.5, -9], [9, 1.5, -9], [0, 1.5, 9]]\n";
    let (sin, cos) = (60.0_f64.to_radians().sin(), 0.5);
    let slanted = format!(
        "[lights.l.point]\nposition = [{:?}, {:?}, 0]\nintensity = 16\n",
        4.0 * sin,
        4.0 * cos
    );
    let sun = format!(
        "[lights.l.sun]\ndirection = [{:?}, {:?}, 0]\nilluminance = 1\n",
        -sin, -cos
    );
    let transmittance = 0.836232462710;
    for light in [&slanted, &sun] {
        for (panes, power) in [("", 0), (pane, 1), (&(pane.to_owned() + second), 2)] {
            let expected = 0.25 * cos * f64::powi(transmittance, power);
            assert_near(pixel(&floor(light, panes))[0], expected, panes);
        }
        // What is opaque stays so, behind a pane or before it.
        let wall = "[objects.wall.triangle]\nmaterial = \"m\"\nvertices = [[-9, 1.2, -9], [9, 1.2, -9], [0, 1.2, 9]]\n";
        assert_eq!(pixel(&floor(light, &(pane.to_owned() + wall)))[0], 0.0);
    }
    // Of a small light with an area above, T along the normal: E = L A/d².
    let panel = "[lights.l.rectangle]\ncenter = [0, 2, 0]\ndirection = [0, -1, 0]\nsize = [1e-3, 1e-3]\n\
        luminance = 4e6\nvisible = false\n";
    assert_near(pixel(&floor(panel, pane))[0], 0.25 * 0.96 / 1.04, "a panel");
}

/// Glass hides what is behind it from lamps.
#[test]
fn glass_is_opaque_to_shadow_rays() {
    let text = "[image]\nresolution = [1, 1]\n\
        [camera.orthographic]\neye = [0, 0.5, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\nheight = 1e-9\n\
        [materials.m.phong]\ndiffuse = 0.25\n[materials.g.glass]\nn = 1.0\n\
        [objects.floor.plane]\nmaterial = \"m\"\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n\
        [objects.ball.sphere]\nmaterial = \"g\"\ncenter = [0, 2, 0]\nradius = 0.5\n\
        [lights.l.point]\nposition = [0, 4, 0]\nintensity = 16\n";
    assert_eq!(pixel(text), [0.0; 3]);
}

/// A picture with everything smooth in it.
fn everything(transport: &str) -> String {
    format!(
        "[image]\nresolution = [96, 64]\nbackground = [0.1, 0.2, 0.4]\ntransport = \"{transport}\"\n\
         [camera.perspective]\neye = [0, 1.5, 5]\nlook_at = [0, 0.5, 0]\nvertical_fov = 40\n\
         [materials.floor.phong]\ndiffuse = [0.2, 0.15, 0.1]\nspecular = 0.1\nshininess = 20\nreflectance = 0.1\n\
         [materials.mirror.mirror]\nreflectance = [0.9, 0.8, 0.7]\n[materials.gold.metal]\npreset = \"gold\"\n\
         [materials.glass.glass]\nn = 1.5\nabsorption = [0.1, 0.5, 0.4]\n[materials.pane.pane]\nn = 1.5\n\
         [materials.red.phong]\ndiffuse = [0.25, 0.05, 0.03]\n\
         [lights.key.point]\nposition = [3, 4, 3]\nintensity = [90, 80, 70]\n\
         [lights.panel.rectangle]\ncenter = [-2, 3, 1]\nlook_at = [0, 0, 0]\nsize = [1, 1]\nluminance = 10\n\
         [objects.floor.plane]\nmaterial = \"floor\"\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n\
         [objects.mirror.sphere]\nmaterial = \"mirror\"\ncenter = [-1.2, 0.6, 0]\nradius = 0.6\n\
         [objects.gold.sphere]\nmaterial = \"gold\"\ncenter = [1.3, 0.5, 0]\nradius = 0.5\n\
         [objects.glass.sphere]\nmaterial = \"glass\"\ncenter = [0.1, 0.5, 0.8]\nradius = 0.5\n\
         [objects.red.sphere]\nmaterial = \"red\"\ncenter = [0, 0.4, -1]\nradius = 0.4\n\
         [objects.pane.triangle]\nmaterial = \"pane\"\nvertices = [[-2, 0, 1.2], [0.4, 0, 1.2], [-0.8, 2, 1.2]]\n"
    )
}

/// light_… and emission add up to R, G and B, as do diffuse, specular, background, emission, reflection and refraction.
#[test]
fn layers_add_up() {
    for transport in ["rgb", "spectral"] {
        let layers = Layers {
            lights: true,
            diffuse: true,
            specular: true,
            ..Layers::default()
        };
        let options = Options {
            samples: 4,
            layers,
            ..Options::default()
        };
        let film = film_of_text(&everything(transport), &options);
        let plain = Options {
            samples: 4,
            ..Options::default()
        };
        assert_eq!(
            film.pixels(),
            film_of_text(&everything(transport), &plain).pixels()
        );
        let names: Vec<&str> = film
            .channels()
            .list
            .iter()
            .map(|it| it.name.as_str())
            .collect();
        let values: Vec<Vec<f32>> = (0..film.pixels().len()).map(|it| film.values(it)).collect();
        let of = |name: &str| {
            let place = names.iter().position(|known| *known == name);
            let place = place.unwrap_or_else(|| panic!("{name} of {names:?}"));
            values
                .iter()
                .map(|values| values[place])
                .collect::<Vec<f32>>()
        };
        for (channel, letter) in ["R", "G", "B"].into_iter().enumerate() {
            let lights: Vec<_> = names
                .iter()
                .filter(|name| name.starts_with("light_") && name.ends_with(&format!(".{letter}")))
                .map(|name| of(name))
                .chain([of(&format!("emission.{letter}"))])
                .collect();
            assert_eq!(lights.len(), 4, "{names:?}");
            let parts = [
                "diffuse",
                "specular",
                "background",
                "emission",
                "reflection",
                "refraction",
            ];
            let parts: Vec<_> = parts
                .iter()
                .map(|part| of(&format!("{part}.{letter}")))
                .collect();
            for sum in [&lights, &parts] {
                for (place, pixel) in film.pixels().iter().enumerate() {
                    let total: f64 = sum.iter().map(|part| f64::from(part[place])).sum();
                    let size: f64 = sum.iter().map(|part| f64::from(part[place]).abs()).sum();
                    let error = (total - f64::from(pixel[channel])).abs();
                    assert!(
                        error <= 4.0 * HALF_LAST_BIT * size.max(1e-30),
                        "{place}: {total}, {pixel:?}"
                    );
                }
            }
        }
    }
}

/// Renders what takes no light before a background of 1: no channel is further from 1 than what is left out by the depth,
/// whose bound the counts say. The darkest channel, and that bound.
fn furnace(text: &str) -> [f64; 2] {
    let scene = Scene::parse(text, "test.toml").unwrap_or_else(|error| panic!("{error}"));
    let (world, camera) = World::new(&scene).unwrap_or_else(|error| panic!("{error}"));
    let renderer = Renderer::new(&world).unwrap();
    let film = renderer.film(&camera, &Options::default(), &Job::new());
    let (film, counts) = film.unwrap();
    let mut darkest = 1.0_f64;
    for (place, pixel) in film.pixels().iter().enumerate() {
        for channel in &pixel[..3] {
            let radiance = f64::from(*channel);
            darkest = darkest.min(radiance);
            let error = (radiance - 1.0).abs();
            assert!(
                error <= counts.depth_rest + 1e-6,
                "{place}: {pixel:?}, {counts:?}"
            );
        }
    }
    [darkest, counts.depth_rest]
}

/// What takes no light is not seen before a background of 1, but for what lies beyond the depth: that is in the bound, which
/// is less than all of it.
#[test]
fn a_furnace_hides_what_takes_no_light() {
    for depth in [1, 3, 12] {
        let text = format!(
            "[image]\nresolution = [60, 40]\nbackground = 1\nmax_depth = {depth}\n\
             [camera.perspective]\neye = [0, 0.5, 5]\nlook_at = [0, 0, 0]\nvertical_fov = 40\n\
             [materials.mirror.mirror]\nreflectance = 1\n[materials.glass.glass]\nn = 1.5\n\
             [materials.water.glass]\nn = 1.33\n[materials.pane.pane]\nn = 1.5\n\
             [objects.mirror.sphere]\nmaterial = \"mirror\"\ncenter = [-1.3, 0, -0.5]\nradius = 0.7\n\
             [objects.glass.sphere]\nmaterial = \"glass\"\ncenter = [0.4, 0, 0]\nradius = 0.7\n\
             [objects.drop.sphere]\nmaterial = \"water\"\ncenter = [0.5, 0.1, 0.2]\nradius = 0.3\n\
             [objects.across.sphere]\nmaterial = \"water\"\ncenter = [1.1, 0.2, 0.1]\nradius = 0.4\n\
             [objects.pane.triangle]\nmaterial = \"pane\"\nvertices = [[-2, -1, 1], [0.5, -1, 1], [-1, 2, 1]]\n"
        );
        let [darkest, left_out] = furnace(&text);
        // The bound is not far off: one sample a pixel, and nothing is brighter than the background.
        assert!(
            left_out > 1e-12 && 1.0 - darkest > 0.1 * left_out,
            "{darkest}, {left_out}"
        );
    }
}

/// Light that leaves one glass for another that disperses it is split there: nothing of a background of 1 is lost.
#[test]
fn overlapping_glass_loses_no_light_where_one_disperses_it() {
    let text = "[image]\nresolution = [12, 12]\nbackground = 1\nmax_depth = 8\ntransport = \"spectral\"\n\
        [camera.orthographic]\neye = [0, 0, 5]\nlook_at = [0, 0, 0]\nheight = 0.2\n\
        [materials.flint.glass]\nsellmeier = \"N-SF11\"\ndispersion = true\n[materials.clear.glass]\nn = 1.3\n\
        [objects.large.sphere]\nmaterial = \"flint\"\ncenter = [0, 0, 0]\nradius = 1\n\
        [objects.small.sphere]\nmaterial = \"clear\"\ncenter = [0, 0, 0.8]\nradius = 0.5\n";
    let [darkest, _] = furnace(text);
    assert!(darkest > 0.99, "{darkest}");
}

#[test]
fn threads_instructions_and_parts_make_no_difference() {
    let part = Window {
        x: 37,
        y: 21,
        width: 30,
        height: 25,
    };
    for transport in ["rgb", "spectral"] {
        let options = Options {
            samples: 3,
            layers: Layers {
                lights: true,
                diffuse: true,
                specular: true,
                ..Layers::default()
            },
            ..Options::default()
        };
        assert_same_everywhere(&everything(transport), &options, part);
    }
}

/// F of glass against published numbers: before a background of 1, where nothing is followed beyond the first surface.
#[test]
fn glass_reflects_as_fresnel_says() {
    let published = [
        (
            1.5,
            [
                (0.0, 0.04),
                (30.0, 0.0415226259758),
                (45.0, 0.0502399110122),
                (60.0, 0.0891867128022),
                (75.0, 0.253060562990),
                (85.0, 0.612799645265),
                (89.0, 0.904184949780),
            ],
        ),
        (
            1.33,
            [
                (0.0, 0.0200593121995),
                (30.0, 0.0211124578653),
                (45.0, 0.0275213835608),
                (60.0, 0.0591255992474),
                (75.0, 0.211426604134),
                (85.0, 0.582728244892),
                (89.0, 0.896046505214),
            ],
        ),
    ];
    for (n, expected) in published {
        for (degrees, reflectance) in expected {
            let beside = f64::to_radians(degrees).sin();
            // The ray inside meets the ball again, where the depth ends.
            let text = format!(
                "[image]\nresolution = [1, 1]\nbackground = 1\nmax_depth = 1\n\
                 [camera.orthographic]\neye = [{beside:?}, 0, 5]\nlook_at = [{beside:?}, 0, 0]\nheight = 1e-12\n\
                 [materials.m.glass]\nn = {n}\n\
                 [objects.o.sphere]\nmaterial = \"m\"\ncenter = [0, 0, 0]\nradius = 1\n"
            );
            assert_near(pixel(&text)[0], reflectance, &format!("{n} at {degrees}°"));
        }
    }
}
