//! Colors along chains of mirrors, and branches that an error leaves out.

use candela::image::Window;
use candela::render::{ErrorTarget, Job, Layers, Options, Renderer};
use candela::scene::Scene;
use candela::world::World;

use crate::images::assert_same_everywhere;
use crate::oracle::disagreement;

/// A room of three colored mirrors with a colored ball, a lamp that is seen and a sky.
const HALL: &str = "
    [image]
    resolution = [64, 36]
    transport = \"spectral\"
    max_depth = 7
    background = [0.1, 0.2, 0.4]
    [camera.perspective]
    eye = [0.3, 0.1, 2.5]
    look_at = [0, 0, -1]
    vertical_fov = 60
    [materials.red.mirror]
    reflectance = [0.8, 0.4, 0.3]
    [materials.blue.mirror]
    reflectance = [0.3, 0.5, 0.85]
    [materials.green.mirror]
    reflectance = [0.4, 0.8, 0.4]
    [materials.floor.phong]
    diffuse = [0.2, 0.15, 0.1]
    [materials.ball.phong]
    diffuse = [0.1, 0.1, 0.2]
    specular = 0.2
    shininess = 40
    [lights.a.point]
    position = [0.5, 1.8, 1]
    intensity = 10
    [lights.b.point]
    position = [-1.5, 1.5, -1]
    intensity = { candela = 6, color = { blackbody = 3000 } }
    [lights.c.sphere]
    center = [-0.8, 0.9, -2]
    radius = 0.2
    luminance = { nits = 3, color = { illuminant = \"F11\" } }
    visible = true
    [objects.floor.plane]
    material = \"floor\"
    point = [0, -1, 0]
    normal = [0, 1, 0]
    [objects.left.plane]
    material = \"red\"
    point = [-2, 0, 0]
    normal = [1, 0, 0]
    [objects.right.plane]
    material = \"blue\"
    point = [2, 0, 0]
    normal = [-1, 0, 0]
    [objects.back.plane]
    material = \"green\"
    point = [0, 0, -3]
    normal = [0, 0, 1]
    [objects.ball.sphere]
    material = \"ball\"
    center = [0, -0.4, 0]
    radius = 0.6
    [objects.mirror.sphere]
    material = \"blue\"
    center = [0.9, -0.6, -1]
    radius = 0.4
";

fn assert_agrees(what: &str, text: &str) {
    let scene = Scene::parse(text, "test.toml").unwrap();
    let [count, wrong] = disagreement(what, &scene);
    assert_eq!(wrong, 0, "{what}: {wrong} of {count}");
}

/// R, G, B of each light, the sky and a lamp are those of the product of all reflectances, whichever mirrors it was.
#[test]
fn colors_along_chains_are_those_of_the_oracle() {
    assert_agrees("chains of colored mirrors", HALL);
}

/// Colors that depend on the angle, metals and glass are before and behind colored mirrors on the same way.
#[test]
fn chains_go_on_through_other_filters() {
    let glass = "[materials.absorbs.glass]\nn = 1.4\nabsorption = [0.3, 0.9, 2]\n\
        [objects.glass.sphere]\nmaterial = \"absorbs\"\ncenter = [-0.8, -0.5, 1]\nradius = 0.4\n";
    let text = HALL
        .replace(
            "[materials.green.mirror]",
            "[materials.green.mirror]\nschlick = true",
        )
        .replace("[materials.ball.phong]", "[materials.ball.metal]")
        .replace(
            "diffuse = [0.1, 0.1, 0.2]\n    specular = 0.2\n    shininess = 40",
            "preset = \"gold\"",
        );
    assert_agrees("chains and filters", &(text + glass));
}

/// Of more colors than there is room for the products of all chains, longer chains are as exact.
#[test]
fn chains_may_be_longer_than_are_kept() {
    let mut text = HALL
        .replace("[64, 36]", "[32, 18]")
        .replace("max_depth = 7", "max_depth = 4");
    for color in 0..40 {
        let angle = f64::from(color) * 0.7;
        let [x, y, z] = [
            angle.cos() * 1.4,
            f64::from(color % 5) * 0.35 - 0.6,
            angle.sin() * 1.4 - 0.6,
        ];
        let red = 0.2 + f64::from(color) * 0.015;
        text += &format!(
            "[materials.m{color}.mirror]\nreflectance = [{red}, 0.5, {}]\n\
             [objects.m{color}.sphere]\nmaterial = \"m{color}\"\ncenter = [{x}, {y}, {z}]\nradius = 0.16\n",
            0.9 - red
        );
    }
    let scene = Scene::parse(&text, "test.toml").unwrap();
    let [count, wrong] = disagreement("many colors", &scene);
    // One ray of 576 meets an edge by way of two balls, where the last digit decides.
    assert!(wrong * 250 <= count, "{wrong} of {count}");
}

/// Where an error is asked for, branches are not followed that cannot matter; what they would have brought is told, and
/// the picture is as near as was asked for.
#[test]
fn an_error_leaves_out_what_cannot_matter() {
    let text = "[image]\nresolution = [48, 32]\nbackground = 0.3\nmax_depth = 12\ntransport = \"rgb\"\n\
        [camera.perspective]\neye = [0, 1, 6]\nlook_at = [0, 0, 0]\nvertical_fov = 40\n\
        [materials.g.glass]\nn = 1.5\n[materials.m.mirror]\nreflectance = 0.3\n\
        [lights.l.point]\nposition = [4, 6, 4]\nintensity = 40\n\
        [objects.a.sphere]\nmaterial = \"g\"\ncenter = [-1, 0, 0]\nradius = 1\n\
        [objects.b.sphere]\nmaterial = \"m\"\ncenter = [1.2, 0, 0]\nradius = 1\n";
    let scene = Scene::parse(text, "test.toml").unwrap();
    let (world, camera) = World::new(&scene).unwrap();
    let renderer = Renderer::new(&world).unwrap();
    let options = |relative: f64| Options {
        target: Some(ErrorTarget {
            floor: Some(0.1),
            max_samples: 1,
            ..ErrorTarget::new(relative)
        }),
        ..Options::default()
    };
    let film = |relative: f64| {
        let options = options(relative);
        renderer.film(&camera, &options, &Job::new()).unwrap()
    };
    let ((fine, of_fine), (coarse, of_coarse)) = (film(1e-6), film(0.1));
    // 1632 and 3218.
    assert!(of_coarse.secondary_rays * 3 < of_fine.secondary_rays * 2);
    // A 64th of 0.1 of the floor may be left out.
    let allowed = 0.1 * 0.1 / 64.0;
    assert!(
        of_coarse.depth_rest <= allowed * (1.0 + 1e-12),
        "{}",
        of_coarse.depth_rest
    );
    // Pixels of the balls have one sample in both, all others the background.
    let mut differ = 0;
    for (one, other) in fine.pixels().iter().zip(coarse.pixels()) {
        for (one, other) in one.iter().zip(other).take(3) {
            let [one, other] = [one, other].map(|channel| f64::from(*channel));
            differ += usize::from(one != other);
            assert!((one - other).abs() <= allowed + one * 1e-7, "{one} {other}");
        }
    }
    assert!(differ > 0);
}

/// A pane or a prism that no object is made of changes neither a pixel nor what is proven of it.
#[test]
fn materials_that_no_object_has_change_nothing() {
    let text = "[image]\nresolution = [48, 32]\ntransport = \"spectral\"\n\
        [camera.perspective]\neye = [0, 1, 6]\nlook_at = [0, 0, 0]\nvertical_fov = 40\n\
        [materials.g.phong]\ndiffuse = 0.25\n\
        [lights.l.point]\nposition = [4, 6, 4]\nintensity = 40\n\
        [objects.a.sphere]\nmaterial = \"g\"\ncenter = [-1, 0, 0]\nradius = 1\n\
        [objects.b.plane]\nmaterial = \"g\"\npoint = [0, -1, 0]\nnormal = [0, 1, 0]\n";
    let unused = "[materials.p.pane]\nn = 1.5\n\
        [materials.d.glass]\nsellmeier = \"N-BK7\"\ndispersion = true\n";
    let options = Options {
        target: Some(ErrorTarget::new(0.01)),
        layers: Layers {
            error: true,
            samples: true,
            ..Layers::default()
        },
        ..Options::default()
    };
    let [without, with] = [text.to_owned(), format!("{text}{unused}")].map(|text| {
        let scene = Scene::parse(&text, "test.toml").unwrap();
        let (world, camera) = World::new(&scene).unwrap();
        let renderer = Renderer::new(&world).unwrap();
        let (film, report) = renderer.film(&camera, &options, &Job::new()).unwrap();
        let values: Vec<Vec<f32>> = (0..film.pixels().len())
            .map(|place| film.values(place).to_vec())
            .collect();
        (film.pixels().to_vec(), values, report.errors.bound())
    });
    assert!(with.2 > 1000, "{}", with.2);
    assert!(without == with);
}

/// What is left out of a sample does not depend on what is beside it.
#[test]
fn what_is_left_out_is_the_same_everywhere() {
    let options = Options {
        target: Some(ErrorTarget {
            floor: Some(0.05),
            max_samples: 16,
            ..ErrorTarget::new(0.2)
        }),
        layers: Layers {
            lights: true,
            ..Layers::default()
        },
        ..Options::default()
    };
    let part = Window {
        x: 13,
        y: 9,
        width: 30,
        height: 19,
    };
    assert_same_everywhere(HALL, &options, part);
}
