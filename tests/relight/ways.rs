//! Other light on pictures with mirrors and glass, and with lights that are seen: what is relit is what a new render is.

use candela::exr::ExrOptions;
use candela::image::Film;
use candela::relight::RelightError;
use candela::render::{self, Layers, Options, OptionsError, Relight, RenderError};
use candela::world::World;

use super::{change, planes, see, without, write};
use crate::images::{assert_same_everywhere, parse};
use crate::measured::Measured;

/// The largest relative error of a pixel, by sums of up to seven shares.
const RELIT: f64 = 1.2e-7;

/// A lamp, a panel that is seen and one that is not, and a group, of which one light is in the glass, over a coated floor, beside a mirror, a ball of
/// gray glass and a pane; the eye is before the glass, or in it.
fn scene(transport: &str, eye: &str, lights: [&str; 3], more: &str) -> String {
    let [key, panel, pair] = lights;
    format!(
        "[image]\nresolution = [36, 24]\nbackground = 0.25\nmax_depth = 6\ntransport = \"{transport}\"\n\
         [camera.perspective]\neye = {eye}\nlook_at = [0, 0.6, 0]\nvertical_fov = 50\n\
         [materials.floor.phong]\ndiffuse = [0.2, 0.15, 0.1]\nspecular = 0.1\nshininess = 20\nreflectance = 0.1\n\
         [materials.mirror.mirror]\nreflectance = 0.8\nschlick = true\n\
         [materials.glass.glass]\nn = 1.5\nabsorption = 0.3\n[materials.pane.pane]\nn = 1.5\n\
         [materials.leaf.phong]\n\
         diffuse = {{ wavelengths = [400, 500, 550, 600, 680, 740], values = [0.03, 0.04, 0.11, 0.05, 0.03, 0.3] }}\n\
         [lights.key.point]\nposition = [3, 4, 3]\nintensity = {key}\n\
         [lights.panel.rectangle]\ncenter = [-1, 2, -1.5]\nlook_at = [0, 0.5, 2]\nsize = [0.8, 0.6]\n\
         luminance = {{ candela = {panel} }}\n\
         [lights.one.disk]\ncenter = [1.4, 1.6, -1]\nlook_at = [0, 0.5, 2]\nradius = 0.3\ngroup = \"pair\"\n\
         luminance = {{ candela = {pair} }}\n\
         [lights.two.sphere]\ncenter = [2.2, 1.6, -1]\nradius = 0.2\ngroup = \"pair\"\n\
         luminance = {{ candela = {pair} }}\n\
         [lights.within.sphere]\ncenter = [0.05, 0.62, 0.7]\nradius = 0.05\ngroup = \"pair\"\n\
         luminance = {{ candela = {pair} }}\n\
         [lights.hidden.disk]\ncenter = [0, 3, 0]\nlook_at = [0, 0, 0]\nradius = 0.3\nvisible = false\nluminance = 4\n\
         [objects.floor.plane]\nmaterial = \"floor\"\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n\
         [objects.mirror.sphere]\nmaterial = \"mirror\"\ncenter = [-1.2, 0.6, 0]\nradius = 0.6\n\
         [objects.glass.sphere]\nmaterial = \"glass\"\ncenter = [0.1, 0.6, 0.8]\nradius = 0.6\n\
         [objects.leaf.sphere]\nmaterial = \"leaf\"\ncenter = [0.6, 0.4, -0.6]\nradius = 0.4\n\
         [objects.pane.triangle]\nmaterial = \"pane\"\nvertices = [[-0.2, 0, 1.6], [2, 0, 1.6], [1.2, 1.4, 1.6]]\n{more}"
    )
}

const OUTSIDE: &str = "[0, 1.2, 4]";
const INSIDE: &str = "[0.1, 0.7, 1.1]";

const LIT: [&str; 3] = [
    "{ candela = 40, color = \"#ffe0c0\" }",
    "3, color = [0.2, 0.5, 1]",
    "1, color = { blackbody = 4000 }",
];

fn with_lights(samples: u32) -> Options {
    Options {
        samples,
        layers: Layers {
            lights: true,
            ..Layers::default()
        },
        ..Options::default()
    }
}

fn render(text: &str, options: &Options) -> Result<Film, RenderError> {
    let (world, camera) = World::new(&parse(text)).unwrap_or_else(|error| panic!("{error}"));
    render::render(&world, &camera, options)
}

fn names(film: &Film) -> Vec<&str> {
    let list = film.channels().list.iter();
    list.map(|channel| channel.name.as_str()).collect()
}

/// What is asked for, and the lights of a scene that is lit so.
const CASES: [(&[&str], [&str; 3]); 6] = [
    (
        &["key=#40ff80"],
        ["{ candela = 40, color = \"#40ff80\" }", LIT[1], LIT[2]],
    ),
    (&["panel=2"], [LIT[0], "6, color = [0.2, 0.5, 1]", LIT[2]]),
    (&["panel=off"], [LIT[0], "0", LIT[2]]),
    (
        &["panel=0.5,{blackbody=3000}", "key=2"],
        [
            "{ candela = 80, color = \"#ffe0c0\" }",
            "1.5, color = { blackbody = 3000 }",
            LIT[2],
        ],
    ),
    (
        &["pair=3,{illuminant=\"F11\"}"],
        [LIT[0], LIT[1], "3, color = { illuminant = \"F11\" }"],
    ),
    (
        &["key=off", "panel=off", "pair=2"],
        ["0", "0", "2, color = { blackbody = 4000 }"],
    ),
];

#[test]
fn what_mirrors_and_glass_show_is_relit_as_it_is_rendered() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let mut measured = Measured::new("relit by mirrors and glass", RELIT);
    for transport in ["rgb", "spectral"] {
        for eye in [OUTSIDE, INSIDE] {
            let film = render(&scene(transport, eye, LIT, ""), &with_lights(2)).unwrap();
            for (texts, lights) in CASES {
                write(&film, &path, &ExrOptions::default());
                let report = change(&path, texts).unwrap();
                assert!(report.notes.is_empty(), "{:?}", report.notes);
                let expected = render(&scene(transport, eye, lights, ""), &with_lights(2)).unwrap();
                let what = format!("{transport} from {eye}, {}", texts[0]);
                see(&mut measured, &path, &expected, &what);
            }
        }
    }
    measured.judge();
}

/// Two mirrors of other colors that show each other, the lamps and the leaf.
const COLORED: &str = "\
    [materials.red.mirror]\nreflectance = [0.8, 0.4, 0.3]\n[materials.blue.mirror]\nreflectance = [0.3, 0.5, 0.85]\n\
    [objects.back.plane]\nmaterial = \"red\"\npoint = [0, 0, -3]\nnormal = [0.1, 0, 1]\n\
    [objects.front.plane]\nmaterial = \"blue\"\npoint = [0, 0, 4.5]\nnormal = [0, 0, -1]\n";

/// What chains of colored mirrors show has curves of its own.
#[test]
fn what_colored_mirrors_show_is_relit_as_it_is_rendered() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let mut measured = Measured::new("relit by colored mirrors", RELIT);
    let mut options = with_lights(2);
    options.layers.relight = Relight::Always;
    let film = render(&scene("spectral", OUTSIDE, LIT, COLORED), &options).unwrap();
    // The leaf and the floor have a curve each, and C(2 + 6, 6) chains show them and what is gray.
    let of_key = names(&film).into_iter();
    assert_eq!(
        of_key
            .filter(|name| name.starts_with("relight_key"))
            .count(),
        3 * 28
    );
    for (texts, lights) in CASES {
        write(&film, &path, &ExrOptions::default());
        let report = change(&path, texts).unwrap();
        assert!(report.notes.is_empty(), "{:?}", report.notes);
        let expected = render(&scene("spectral", OUTSIDE, lights, COLORED), &options).unwrap();
        see(&mut measured, &path, &expected, texts[0]);
    }
    measured.judge();
    // By itself only as many channels are made as are few.
    let film = render(&scene("spectral", OUTSIDE, LIT, COLORED), &with_lights(1)).unwrap();
    assert!(!names(&film).iter().any(|name| name.starts_with("relight_")));
    let shallow =
        scene("spectral", OUTSIDE, LIT, COLORED).replace("max_depth = 6", "max_depth = 2");
    let film = render(&shallow, &with_lights(1)).unwrap();
    assert!(names(&film).contains(&"relight_key.17"));
}

/// Lines of sodium, twice: what R, G and B say nothing of.
#[test]
fn spectra_are_relit_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let film = render(&scene("spectral", OUTSIDE, LIT, ""), &with_lights(2)).unwrap();
    write(&film, &path, &ExrOptions::default());
    change(&path, &["panel={lines=[[589.0, 1], [589.6, 0.5]]}"]).unwrap();
    change(&path, &["panel=2,{illuminant=\"F11\"}"]).unwrap();
    let lights = [LIT[0], "6, color = { illuminant = \"F11\" }", LIT[2]];
    let expected = render(&scene("spectral", OUTSIDE, lights, ""), &with_lights(2)).unwrap();
    let mut measured = Measured::new("relit twice by mirrors and glass", RELIT);
    see(&mut measured, &path, &expected, "twice");
    measured.judge();
}

/// What each light that is seen sends itself has a layer, and these add up to `emission`; R, G and B are as without.
#[test]
fn lights_that_are_seen_have_layers_of_their_own() {
    for transport in ["rgb", "spectral"] {
        let text = scene(transport, OUTSIDE, LIT, "");
        let film = render(&text, &with_lights(4)).unwrap();
        let all = names(&film);
        for (name, is_there) in [
            ("emission.R", true),
            ("emission_panel.G", true),
            ("emission_pair.B", true),
            ("emission_key.R", false),
            ("emission_hidden.R", false),
            ("relight_panel.emission", transport == "spectral"),
            ("relight_pair.flat", transport == "spectral"),
            ("relight_hidden.emission", false),
        ] {
            assert_eq!(all.contains(&name), is_there, "{name} of {all:?}");
        }
        let of = |name: String| super::channel(&film, &name);
        for letter in ["R", "G", "B"] {
            let sum = of(format!("emission.{letter}"));
            let parts = ["panel", "pair"].map(|name| of(format!("emission_{name}.{letter}")));
            let mut seen = 0;
            for (place, sum) in sum.into_iter().enumerate() {
                let total: f64 = parts.iter().map(|part| f64::from(part[place])).sum();
                let error = (total - f64::from(sum)).abs();
                assert!(error <= 1.2e-7 * total.abs(), "{place}: {total}, {sum}");
                seen += usize::from(sum > 0.0);
            }
            assert!(seen > 5, "{seen} pixels show a light");
        }
        let never = Options {
            layers: Layers {
                lights: true,
                relight: Relight::Never,
                ..Layers::default()
            },
            ..with_lights(4)
        };
        let plain = render(&text, &never).unwrap();
        assert_eq!(film.pixels(), plain.pixels());
        assert!(
            !names(&plain)
                .iter()
                .any(|name| name.starts_with("emission_"))
        );
    }
}

/// Files without these layers say so, be it that they are older or that nobody asked for them.
#[test]
fn lights_that_are_seen_without_layers_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let film = render(&scene("rgb", OUTSIDE, LIT, ""), &with_lights(1)).unwrap();
    let without_it = without(&without(&film, "emission_panel"), "emission_pair");
    write(&without_it, &path, &ExrOptions::default());
    let error = change(&path, &["panel=2"]).unwrap_err();
    assert!(matches!(error, RelightError::Seen { .. }), "{error}");
    assert!(error.to_string().contains("emission_panel"), "{error}");
    // One that is not seen needs none.
    change(&path, &["hidden=2", "key=2"]).unwrap();
    // Of a choice of lights the layers are there without `emission`.
    let options = Options {
        layers: Layers {
            lights: true,
            only: Some(vec!["panel".to_owned()]),
            ..Layers::default()
        },
        ..with_lights(1)
    };
    let lit = |lights| render(&scene("rgb", OUTSIDE, lights, ""), &options).unwrap();
    write(&lit(LIT), &path, &ExrOptions::default());
    assert!(!planes(&path).contains_key("emission.R"));
    change(&path, &["panel=2"]).unwrap();
    let mut measured = Measured::new("one light that is seen", RELIT);
    see(&mut measured, &path, &lit(CASES[1].1), "panel=2");
    measured.judge();
}

/// Layers that hold the light of all ways together cannot follow it.
#[test]
fn sums_over_ways_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let options = Options {
        layers: Layers {
            lights: true,
            light_diffuse: true,
            light_specular: true,
            diffuse: true,
            specular: true,
            ..Layers::default()
        },
        ..with_lights(1)
    };
    let film = render(&scene("rgb", OUTSIDE, LIT, ""), &options).unwrap();
    write(&film, &path, &ExrOptions::default());
    let notes = change(&path, &["key=2"]).unwrap().notes;
    let planes = planes(&path);
    for layer in ["diffuse", "specular", "reflection", "refraction"] {
        assert!(!planes.contains_key(&format!("{layer}.R")), "{layer}");
        let is_told = |note: &String| note.contains(&format!("`{layer}` is left out"));
        assert!(notes.iter().any(is_told), "{layer}: {notes:?}");
    }
    assert!(planes.contains_key("light_key_diffuse.R"));
}

/// Where mirrors or glass color light, what spectra need is not made: by itself it is left out, and asked for refused.
#[test]
fn ways_that_color_light_have_no_layers_of_reflectances() {
    for (material, shape) in [
        (
            "mirror]\nreflectance = [0.9, 0.8, 0.7]\nschlick = true",
            "plane",
        ),
        ("metal]\npreset = \"gold\"", "plane"),
        ("glass]\nn = 1.5\nabsorption = [0.1, 0.2, 0.3]", "sphere"),
        ("glass]\nsellmeier = \"N-BK7\"\ndispersion = true", "sphere"),
    ] {
        let object = match shape {
            "plane" => "point = [0, 0, -9]\nnormal = [0, 0, 1]",
            _ => "center = [0, 9, 0]\nradius = 1",
        };
        let more = format!(
            "[materials.tinted.{material}\n[objects.tinted.{shape}]\nmaterial = \"tinted\"\n{object}\n"
        );
        let text = scene("spectral", OUTSIDE, LIT, &more);
        let film = render(&text, &with_lights(1)).unwrap();
        assert!(!names(&film).iter().any(|name| name.starts_with("relight_")));
        let asked = |transport: &str| {
            let mut options = with_lights(1);
            options.layers.relight = Relight::Always;
            render(&scene(transport, OUTSIDE, LIT, &more), &options)
        };
        let error = asked("spectral").err().unwrap();
        assert!(
            matches!(&error, RenderError::Options(OptionsError::ColoredWays { material }) if material == "tinted"),
            "{error}"
        );
        assert!(error.to_string().contains("leave `relight` out"), "{error}");
        // As RGB colors are factors of each channel; a sphere that disperses is spectral.
        if !material.contains("dispersion") {
            assert!(asked("rgb").is_ok());
        }
        // No object has the material: nothing is colored by it.
        let unused = format!("[materials.tinted.{material}\n");
        let film = render(&scene("spectral", OUTSIDE, LIT, &unused), &with_lights(1)).unwrap();
        assert!(names(&film).contains(&"relight_key.1"), "{material}");
    }
}

#[test]
fn threads_instructions_and_parts_make_no_difference() {
    let part = candela::image::Window {
        x: 9,
        y: 5,
        width: 17,
        height: 11,
    };
    for (transport, eye) in [("rgb", INSIDE), ("spectral", OUTSIDE), ("spectral", INSIDE)] {
        let text = scene(transport, eye, LIT, "");
        assert_same_everywhere(&text, &with_lights(3), part);
    }
}
