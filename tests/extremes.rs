//! Scenes at the limits of what is legal: many copies of one shape, shapes smaller than the
//! rounding of their place, very large and very small worlds, lights on surfaces, very sharp lobes.

use std::fmt::Write;
use std::thread;

use candela::image::Film;
use candela::scene::{Object, Scene};
use candela::world::plan::Acceleration;
use candela::world::{Plan, World};

use crate::generate::Random;
use crate::images::{bits, film_of, parse, render};
use crate::measured::{HALF_LAST_BIT, Measured};
use crate::oracle::assert_agrees;

type Vector = [f64; 3];

/// Far more copies than a thread with [`SMALL_STACK`] could recurse over one by one, or than quadratic
/// time would allow.
const COPIES: usize = 20_000;

/// Bytes. Threads of other programs may have no more: musl's have 128 kB, macOS's 512 kB.
const SMALL_STACK: usize = 512 << 10;

/// Relative error where every number of a scene is rounded anew: two roundings to f32, measured.
const SCALED: f64 = 9.02e-8;

/// How far a lobe's peak is below k_s I/d², relative: of a cosine that rounding puts below 1, to the power 1e9.
const PEAK: f64 = 1.75e-6;

/// Relative error of rounding to f32.
const NARROWING: f64 = Measured::ROOM * HALF_LAST_BIT;

/// A view whose vertical field of view is 40 degrees.
fn view(resolution: [u32; 2], eye: Vector, look_at: Vector) -> String {
    format!(
        "[image]\nresolution = {resolution:?}\n\
         [camera.perspective]\neye = {eye:?}\nlook_at = {look_at:?}\nvertical_fov = 40\n"
    )
}

fn light(name: usize, position: Vector, intensity: f64) -> String {
    format!("[lights.l{name}.point]\nposition = {position:?}\nintensity = {intensity:?}\n")
}

/// Material `m` with both lobes.
const GLOSSY: &str = "[materials.m.phong]\ndiffuse = [0.3, 0.2, 0.1]\nspecular = [0.1, 0.2, 0.3]\n\
                      shininess = 30\n";

fn sphere(name: usize, center: Vector, radius: f64) -> String {
    format!(
        "[objects.s{name}.sphere]\nmaterial = \"m\"\ncenter = {center:?}\nradius = {radius:?}\n"
    )
}

/// The scene with [`COPIES`] of its only object, each changed by `change`.
fn copied(scene: &Scene, change: impl Fn(usize, &mut Object)) -> Scene {
    let mut many = scene.clone();
    let [original] = &*scene.objects else {
        panic!("one object is copied");
    };
    many.objects = (0..COPIES)
        .map(|number| {
            let mut copy = original.clone();
            copy.name = format!("{}_{number}", original.name);
            change(number, &mut copy.value);
            copy
        })
        .collect();
    many
}

/// The image of a scene, built and rendered by threads with [`SMALL_STACK`].
fn film_on_small_stacks(scene: &Scene) -> Film {
    let on_pool = || {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(2)
            .stack_size(SMALL_STACK)
            .build();
        pool.unwrap().install(|| film_of(scene, 1))
    };
    thread::scope(|scope| {
        let builder = thread::Builder::new().stack_size(SMALL_STACK);
        let running = builder.spawn_scoped(scope, on_pool);
        running.unwrap().join().unwrap()
    })
}

fn coverage(film: &Film) -> usize {
    film.pixels().iter().filter(|rgba| rgba[3] > 0.0).count()
}

fn assert_finite(name: &str, film: &Film) {
    for rgba in film.pixels() {
        assert!(
            rgba.iter()
                .all(|&channel| (0.0..f32::MAX).contains(&channel)),
            "{name}: {rgba:?}"
        );
    }
}

fn view_of_one_object() -> String {
    [
        view([8, 6], [0.3, 0.2, 5.0], [0.0, 0.0, 0.0]),
        GLOSSY.to_owned(),
        light(0, [2.0, 3.0, 4.0], 50.0),
    ]
    .concat()
}

#[test]
fn copies_of_a_triangle_are_one() {
    let triangle = "[objects.t.triangle]\nmaterial = \"m\"\n\
                    vertices = [[-1, -1, 0.2], [1.2, -0.9, 0], [0.1, 1.1, -0.1]]\n";
    let one = parse(&(view_of_one_object() + triangle));
    let expected = film_of(&one, 1);
    assert!(coverage(&expected) >= 8, "{}", coverage(&expected));
    let many = copied(&one, |_, _| ());
    assert_eq!(bits(&film_on_small_stacks(&many)), bits(&expected));
}

#[test]
fn copies_of_a_sphere_are_one() {
    let one = parse(&(view_of_one_object() + &sphere(0, [0.1, 0.2, 0.3], 1.1)));
    let expected = film_of(&one, 1);
    assert!(coverage(&expected) >= 8, "{}", coverage(&expected));
    let many = copied(&one, |_, _| ());
    assert_eq!(bits(&film_on_small_stacks(&many)), bits(&expected));
}

/// All boxes have one center; only the outermost sphere is seen, and those inside shade nothing.
#[test]
fn of_concentric_spheres_the_outermost_is_seen() {
    let one = parse(&(view_of_one_object() + &sphere(0, [0.1, 0.2, 0.3], 1.1)));
    let many = copied(&one, |number, object| {
        let Object::Sphere { radius, .. } = object else {
            panic!("a sphere is copied");
        };
        radius.value *= (number + 1) as f64 / COPIES as f64;
    });
    let expected = bits(&film_of(&one, 1));
    assert_eq!(bits(&film_on_small_stacks(&many)), expected);
}

/// The center of the pixel in the middle looks straight at it; p is far off its surface by rounding.
#[test]
fn a_sphere_smaller_than_the_rounding_of_the_eye() {
    for copies in [1, 20] {
        let mut text = view([5, 5], [0.0, 0.0, 5.0], [0.0, 0.0, 0.0])
            + GLOSSY
            + &light(0, [0.0, 1.0, 5.0], 50.0);
        for number in 0..copies {
            text += &sphere(number, [0.0; 3], 1e-20);
        }
        assert_agrees("tiny", &parse(&text));
    }
}

/// Seen along a diagonal, from where positions are measured: no coordinate of their boxes is exact.
#[test]
fn spheres_smaller_than_the_rounding_of_their_place() {
    for look_at in [[0.0; 3], [1e8; 3]] {
        let mut text = view([5, 5], [1e8 + 5.0; 3], look_at)
            + GLOSSY
            + &light(0, [1e8, 1e8 + 1.0, 1e8 + 5.0], 50.0);
        for number in 0..20 {
            text += &sphere(number, [1e8; 3], 1e-12);
        }
        let scene = parse(&text);
        assert_finite("far and tiny", &film_of(&scene, 1));
        assert_agrees("far and tiny", &scene);
    }
}

/// Each is half as large as the one before and as far from a point that all approach: trees that
/// split off one at a time go as deep as there are shapes.
#[test]
fn a_series_of_ever_smaller_spheres() {
    for copies in [1, 3] {
        let mut text = view([32, 24], [0.2, 1.0, 3.0], [0.3, 0.1, 0.0])
            + GLOSSY
            + &light(0, [2.0, 3.0, 1.0], 20.0)
            + &light(1, [-2.0, 3.0, 2.0], 20.0);
        for number in 0..200 * copies {
            let size = 0.5_f64.powi((number / copies) as i32);
            let aside = 0.1 * (number % copies) as f64;
            text += &sphere(number, [size, aside * size, 0.0], size / 4.0);
        }
        let scene = parse(&text);
        let expected = film_of(&scene, 1);
        assert_eq!(bits(&film_on_small_stacks(&scene)), bits(&expected));
        let lit = assert_agrees("series", &scene);
        assert!(lit > 20, "{lit}");
    }
}

/// More spheres than a list takes on a floor of many triangles, `scale` times as large.
fn crowd(scale: f64, intensity: f64) -> String {
    let at = |position: Vector| position.map(|x| x * scale);
    let mut text = view([32, 24], at([1.0, 3.0, 7.0]), at([0.0, 0.4, 0.0])) + GLOSSY;
    for (number, position) in [[4.0, 6.0, 3.0], [-5.0, 4.0, 2.0]].into_iter().enumerate() {
        text += &light(number, at(position), intensity);
    }
    let mut random = Random::new(11);
    for number in 0..70 {
        let center = [
            random.between(-2.5, 2.5),
            random.between(0.2, 1.2),
            random.between(-2.5, 2.5),
        ];
        text += &sphere(number, at(center), random.between(0.1, 0.5) * scale);
    }
    for number in 0..24 {
        let (x, z) = (
            f64::from(number % 6) * 2.0 - 6.0,
            f64::from(number / 6) * 2.0 - 4.0,
        );
        let vertices = [[x, 0.0, z], [x, 0.0, z + 1.8], [x + 1.8, 0.0, z]].map(at);
        write!(
            text,
            "[objects.t{number}.triangle]\nmaterial = \"m\"\nvertices = {vertices:?}\n"
        )
        .unwrap();
    }
    text
}

/// L3: radiance is I/d², so the same image where intensities grow with the square of lengths, and
/// in proportion where they do not.
#[test]
fn any_scale_gives_the_same_image() {
    let intensity = 40.0;
    let expected = render(&crowd(1.0, intensity), 1);
    assert!(
        coverage(&expected) >= 300,
        "{} are seen",
        coverage(&expected)
    );
    let mut worst = Measured::new("any scale", SCALED);
    // At 1e25, I · 1e50 is more than a light may have.
    for (scale, scaled_intensity) in [
        (1e13, intensity * 1e26),
        (1e-13, intensity * 1e-26),
        (1e25, 3e38),
        (1e-25, intensity * 1e-50),
    ] {
        let scene = parse(&crowd(scale, scaled_intensity));
        let plan = Plan::new(&World::new(&scene).unwrap().0);
        assert_eq!(
            [plan.spheres(), plan.triangles()],
            [Acceleration::Tree; 2],
            "the tree is what is tested"
        );
        let actual = film_of(&scene, 1);
        let factor = scaled_intensity / intensity / (scale * scale);
        let pixels = actual.pixels().iter().zip(expected.pixels());
        for (index, (actual, expected)) in pixels.enumerate() {
            // None is at an edge.
            assert_eq!(actual[3], expected[3], "pixel {index} at {scale:e}");
            let expected_rgb = [0, 1, 2].map(|i| f64::from(expected[i]) * factor);
            let largest = expected_rgb.into_iter().fold(f64::MIN_POSITIVE, f64::max);
            for (&actual, expected) in actual.iter().zip(expected_rgb) {
                let error = (f64::from(actual) - expected).abs() / largest;
                worst.see(error, || format!("pixel {index} at {scale:e}"));
            }
        }
    }
    worst.judge();
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(v: Vector) -> Vector {
    let length = dot(v, v).sqrt();
    v.map(|x| x / length)
}

/// A light exactly in the mirror direction of the viewer: L7 is k_s there, whatever n, and a cosine
/// that rounding puts above 1 must not make it more.
#[test]
fn the_sharpest_lobe_is_no_higher_than_its_reflectance() {
    let (specular, intensity) = (0.7, 20.0);
    let mut random = Random::new(5);
    let mut below = Measured::new("the peak of a lobe", PEAK);
    for number in 0..60 {
        let normal = unit(random.point(1.0));
        let other = random.point(1.0);
        let along = dot(other, normal);
        let tangent = unit([0, 1, 2].map(|i| other[i] - along * normal[i]));
        let (sin, cos) = random.between(0.0, 1.3).sin_cos();
        let eye = [0, 1, 2].map(|i| 5.0 * (cos * normal[i] + sin * tangent[i]));
        let position = [0, 1, 2].map(|i| 3.0 * (cos * normal[i] - sin * tangent[i]));
        let shininess = [1e3, 1e6, 1e8, 1e9][number % 4];
        let text = format!(
            "{}[materials.m.phong]\nspecular = {specular:?}\nshininess = {shininess:?}\n\
             [objects.p.plane]\nmaterial = \"m\"\npoint = [0, 0, 0]\nnormal = {normal:?}\n{}",
            view([1, 1], eye, [0.0; 3]),
            light(0, position, intensity),
        );
        let scene = parse(&text);
        assert_eq!(assert_agrees(&text, &scene), 1, "{text}");
        let highest = specular * intensity / dot(position, position);
        let actual = f64::from(film_of(&scene, 1).pixels()[0][0]);
        assert!(
            actual <= highest * (1.0 + NARROWING),
            "{actual} is above {highest}\n{text}"
        );
        below.see(1.0 - actual / highest, || text.clone());
    }
    below.judge();
}

/// Lights that rounding puts on either side of the wall they are on: from inside, nothing stands
/// between.
#[test]
fn lights_on_the_wall_of_a_sphere_seen_from_inside() {
    let mut random = Random::new(6);
    let (center, radius) = ([0.3, -0.2, 0.7], 2.3);
    let mut all = String::new();
    let room =
        view([12, 9], [0.5, 0.1, 0.9], [0.1, -0.4, -1.0]) + GLOSSY + &sphere(0, center, radius);
    for number in 0..60 {
        let direction = unit(random.point(1.0));
        let on_wall = [0, 1, 2].map(|i| center[i] + radius * direction[i]);
        let one = light(number, on_wall, 10.0);
        let lit = assert_agrees(&one, &parse(&(room.clone() + &one)));
        assert_eq!(lit, 12 * 9, "{one}");
        all += &one;
    }
    assert_agrees("all lights", &parse(&(room + &all)));
}

/// Spheres on a floor that hides what is below it.
fn still_life(spheres: usize) -> String {
    let mut text = view([32, 24], [1.0, 3.0, 7.0], [0.0, 0.4, 0.0]) + GLOSSY;
    text += &light(0, [4.0, 6.0, 3.0], 60.0);
    text += &light(1, [-5.0, 4.0, 2.0], 40.0);
    text += "[objects.floor.plane]\nmaterial = \"m\"\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n";
    let mut random = Random::new(7);
    for number in 0..spheres {
        let center = [
            random.between(-2.5, 2.5),
            random.between(0.2, 1.2),
            random.between(-2.5, 2.5),
        ];
        text += &sphere(number, center, random.between(0.2, 0.6));
    }
    text
}

/// However large hidden shapes make the tree: what is seen is found in it as in a list.
#[test]
fn a_tree_finds_what_a_list_finds() {
    let listed = still_life(12);
    let expected = render(&listed, 4);
    let plan = |scene: &Scene| Plan::new(&World::new(scene).unwrap().0).spheres();
    assert_eq!(plan(&parse(&listed)), Acceleration::List);
    for far in [20.0, 1e4, 1e7, 1e12] {
        let mut random = Random::new(8);
        let mut text = listed.clone();
        for number in 100..170 {
            let [x, _, z] = random.point(far);
            text += &sphere(number, [x, -far, z], random.between(0.2, 0.6));
        }
        let scene = parse(&text);
        assert_eq!(plan(&scene), Acceleration::Tree);
        assert_eq!(bits(&film_of(&scene, 4)), bits(&expected), "{far:e}");
    }
}

/// The Earth and 200 pebbles on it.
#[test]
fn a_planet_under_pebbles() {
    let mut text = view([32, 24], [0.5, 3.0, 7.0], [0.0, 0.0, 0.0]) + GLOSSY;
    text += &light(0, [4.0, 6.0, 3.0], 60.0);
    text += &light(1, [-5.0, 4.0, 2.0], 40.0);
    text += &sphere(1000, [0.0, -6.4e6, 0.0], 6.4e6);
    let mut random = Random::new(9);
    for number in 0..200 {
        let center = [
            random.between(-3.0, 3.0),
            random.between(0.0, 0.2),
            random.between(-3.0, 3.0),
        ];
        text += &sphere(number, center, random.between(0.05, 0.2));
    }
    let lit = assert_agrees("pebbles", &parse(&text));
    assert!(lit > 32 * 24 / 2, "{lit}");
}

/// 1/d² is far beyond an f32 where the light gives nothing in a channel.
#[test]
fn no_light_from_a_black_channel_however_near() {
    for height in [1e-10, 1e-20, 1e-29, 1e-100, 1e-150, 1e-155, 1e-160] {
        let text = format!(
            "[image]\nresolution = [3, 3]\n\
             [camera.orthographic]\neye = [0, {height:?}, 0]\nlook_at = [0, 0, 0]\n\
             up = [0, 0, -1]\nheight = {height:?}\n{GLOSSY}\
             [objects.floor.plane]\nmaterial = \"m\"\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n\
             [lights.l.point]\nposition = [0, {height:?}, 0]\nintensity = [3, 0, 1e-30]\n"
        );
        let film = render(&text, 1);
        for rgba in film.pixels() {
            assert_eq!(rgba[1], 0.0, "{height:e}: {rgba:?}");
            assert!(rgba.iter().all(|channel| channel.is_finite()), "{rgba:?}");
        }
    }
}
