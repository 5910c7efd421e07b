//! Whole images whose pixels a formula gives.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;

use candela::image::Film;
use candela::scene::Scene;

use crate::images::{film_of, pixel, render, render_counted};
use crate::measured::{HALF_LAST_BIT, Measured};

/// Relative error where nothing but the rounding to f32 is between the formula and the pixel.
const ROUNDING: f64 = Measured::ROOM * HALF_LAST_BIT;

type Vector = [f64; 3];

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn assert_near(actual: f32, expected: f64, tolerance: f64, what: &str) {
    let actual = f64::from(actual);
    assert!(
        (actual - expected).abs() <= tolerance * expected.abs(),
        "{what}: {actual}, expected {expected}"
    );
}

/// An orthographic view of the x-z plane from above: +x right, +z down, `height` units high.
fn from_above(resolution: u32, height: f64) -> String {
    format!(
        "[image]\nresolution = [{resolution}, {resolution}]\n\
         [camera.orthographic]\neye = [0, 10, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, -1]\n\
         height = {height:?}\n"
    )
}

/// The middle of a pixel of such a view, in scene units from the middle of the image.
fn position(resolution: u32, height: f64, pixel: u32) -> f64 {
    (f64::from(pixel) + 0.5 - f64::from(resolution) / 2.0) * height / f64::from(resolution)
}

fn floor_of(material: &str) -> String {
    format!(
        "[materials.m.{material}\n\
         [objects.floor.plane]\nmaterial = \"m\"\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n"
    )
}

fn light(name: usize, position: Vector, intensity: f64) -> String {
    format!("[lights.l{name}.point]\nposition = {position:?}\nintensity = {intensity:?}\n")
}

fn each_pixel(film: &Film, height: f64, mut check: impl FnMut(f64, f64, [f32; 4])) {
    let [width, rows] = film.resolution();
    for y in 0..rows {
        for x in 0..width {
            let (across, down) = (position(width, height, x), position(rows, height, y));
            check(across, down, pixel(film, x, y));
        }
    }
}

/// L = I k_d h / (h² + r²)^{3/2}.
#[test]
fn a_plane_under_a_light() {
    let (intensity, h, height) = (30.0, 1.5, 6.0);
    let film = render(
        &[
            from_above(64, height),
            floor_of("phong]\ndiffuse = [0.2, 0.5, 0.75]"),
            light(0, [0.5, h, -0.25], intensity),
        ]
        .concat(),
        1,
    );
    each_pixel(&film, height, |x, z, rgba| {
        let (x, z) = (x - 0.5, z + 0.25);
        let expected = intensity * h / (h * h + x * x + z * z).powf(1.5);
        for (channel, diffuse) in rgba.into_iter().zip([0.2, 0.5, 0.75]) {
            assert_near(channel, diffuse * expected, ROUNDING, "plane");
        }
        assert_eq!(rgba[3], 1.0);
    });
}

/// A Lambertian sphere of radius 1: L = I k_d max(n·(p_L − p), 0) / d³ with p on the front.
#[test]
fn a_sphere_under_a_light_from_the_side() {
    const HEIGHT: f64 = 2.5;
    let at = [4.0, 1.0, 2.0];
    let film = render(
        &format!(
            "[image]\nresolution = [64, 64]\n\
             [camera.orthographic]\neye = [0, 0, 5]\nlook_at = [0, 0, 0]\nheight = {HEIGHT}\n\
             [materials.m.phong]\ndiffuse = 0.5\n\
             [objects.ball.sphere]\nmaterial = \"m\"\ncenter = [0, 0, 0]\nradius = 1\n{}",
            light(0, at, 20.0)
        ),
        1,
    );
    let (mut lit, mut dark) = (0, 0);
    each_pixel(&film, HEIGHT, |x, down, rgba| {
        let y = -down;
        let rest = 1.0 - x * x - y * y;
        if rest < 0.0 {
            assert_eq!(rgba, [0.0; 4]);
            return;
        }
        assert_eq!(rgba[3], 1.0);
        let p = [x, y, rest.sqrt()];
        let to_light = minus(at, p);
        let cosine = dot(p, to_light);
        let expected = 20.0 * 0.5 * cosine.max(0.0) / dot(to_light, to_light).powf(1.5);
        if cosine > 0.0 {
            lit += 1;
        } else {
            dark += 1;
        }
        // At the silhouette z = √(1 − x² − y²) loses digits, and at the terminator the cosine.
        let condition = 1.0 / rest.min(cosine.abs());
        let tolerance = ROUNDING + 1e-13 * condition;
        assert_near(rgba[0], expected, tolerance, "sphere");
    });
    assert!(lit > 1000 && dark > 200, "{lit} lit, {dark} dark");
}

/// Seen along the normal, ω_r·ω_o = n·ω_i: L = I k_s cosⁿθ / d², and for `normalized_phong`
/// L = I ρ_s (n+2)/(2π) cosⁿ⁺¹θ / d².
#[test]
fn the_profile_of_a_highlight() {
    const HEIGHT: f64 = 2.0;
    const ROWS: u32 = 48;
    for shininess in [0.5, 1.0, 20.0, 500.0, 5000.0] {
        for model in ["phong", "normalized_phong"] {
            let material = format!("{model}]\nspecular = 0.4\nshininess = {shininess:?}");
            let scene = [
                from_above(ROWS, HEIGHT),
                floor_of(&material),
                light(0, [0.0, 2.0, 0.0], 9.0),
            ];
            each_pixel(&render(&scene.concat(), 1), HEIGHT, |x, z, rgba| {
                let d2 = 4.0 + x * x + z * z;
                let cosine = 2.0 / d2.sqrt();
                let lobe = 9.0 * 0.4 * cosine.powf(shininess) / d2;
                let expected = match model {
                    "phong" => lobe,
                    _ => lobe * cosine * (shininess + 2.0) / TAU,
                };
                if expected > 1e-30 {
                    // 1e-16 in the cosine is n times that in its power.
                    let tolerance = ROUNDING + 1e-15 * shininess;
                    assert_near(rgba[0], expected, tolerance, model);
                }
            });
        }
    }
}

/// L3: twice as far is a quarter of the light, three times a ninth.
#[test]
fn the_inverse_square() {
    let radiance = |d: f64| {
        let scene = [
            from_above(1, 1.0),
            floor_of("phong]\ndiffuse = 0.5"),
            light(0, [0.0, d, 0.0], 6.0),
        ];
        pixel(&render(&scene.concat(), 1), 0, 0)[1]
    };
    for d in [0.01, 1.0, 1e4] {
        let one = 6.0 * 0.5 / (d * d);
        for times in [1.0, 2.0, 3.0] {
            let expected = one / (times * times);
            assert_near(radiance(d * times), expected, ROUNDING, "distance");
        }
    }
}

/// A perspective camera far away with a small angle sees what an orthographic one sees.
#[test]
fn the_orthographic_limit_of_perspective() {
    const DISTANCE: f64 = 1e7;
    /// The rays of both differ by an angle of 1e-7, and so do cosines; at the silhouette of the ball depth
    /// and cosines change faster.
    const LIMIT: f64 = 1.58e-5;
    let rest = format!(
        "[materials.m.phong]\ndiffuse = 0.5\nspecular = 0.4\nshininess = 10\n\
         [objects.ball.sphere]\nmaterial = \"m\"\ncenter = [0.1, 0.2, 0]\nradius = 0.8\n\
         [objects.wall.plane]\nmaterial = \"m\"\npoint = [0, 0, -1]\nnormal = [0.1, 0.2, 1]\n{}",
        light(0, [1.0, 2.0, 3.0], 10.0)
    );
    let view = format!(
        "[image]\nresolution = [64, 48]\n[camera.NAME]\neye = [0, 0, {DISTANCE:?}]\n\
         look_at = [0, 0, 0]\n"
    );
    let angle = 2.0 * (1.5 / DISTANCE).atan().to_degrees();
    let perspective = view.replace("NAME", "perspective") + &format!("vertical_fov = {angle:?}\n");
    let orthographic = view.replace("NAME", "orthographic") + "height = 3.0\n";
    let (a, b) = (
        render(&(perspective + &rest), 1),
        render(&(orthographic + &rest), 1),
    );
    let mut worst = Measured::new("orthographic limit", LIMIT);
    for (index, (a, b)) in a.pixels().iter().zip(b.pixels()).enumerate() {
        // No silhouette and no edge of a shadow falls on a pixel's center.
        assert_eq!(
            [a[0] > 0.0, a[3] > 0.0],
            [b[0] > 0.0, b[3] > 0.0],
            "{index}"
        );
        let scale = f64::from(b[0]);
        let error = (f64::from(a[0]) - scale).abs() / scale.max(f64::MIN_POSITIVE);
        worst.see(error, || index.to_string());
    }
    worst.judge();
}

/// Light along the normal, looked at from everywhere: ∫ L_o cos θ dω / (I/d²) is
/// π k_d + 2π k_s/(n+2) for `phong` and ρ_d + ρ_s for `normalized_phong`.
#[test]
fn the_albedo_at_normal_incidence() {
    const STEPS: u32 = 300;
    for (model, n, diffuse, specular) in [
        ("phong", 5.0, 0.3, 0.2),
        ("phong", 40.0, 0.1, 0.8),
        ("normalized_phong", 1.0, 0.4, 0.6),
        ("normalized_phong", 40.0, 0.25, 0.5),
    ] {
        let material =
            format!("{model}]\ndiffuse = {diffuse:?}\nspecular = {specular:?}\nshininess = {n:?}");
        let rest = floor_of(&material) + &light(0, [0.0, 2.0, 0.0], 4.0);
        let mut sum = 0.0;
        for step in 0..STEPS {
            // The midpoint rule in cos θ; around the normal everything is the same.
            let cosine = (f64::from(step) + 0.5) / f64::from(STEPS);
            let sine = (1.0 - cosine * cosine).sqrt();
            let view = format!(
                "[image]\nresolution = [1, 1]\n[camera.orthographic]\nheight = 1e-3\n\
                 eye = [{sine:?}, {cosine:?}, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n"
            );
            let radiance = pixel(&render(&(view + &rest), 1), 0, 0)[0];
            sum += f64::from(radiance) * cosine;
        }
        // I / d² is 1.
        let albedo = sum * TAU / f64::from(STEPS);
        let expected = match model {
            "phong" => PI * diffuse + TAU * specular / (n + 2.0),
            _ => diffuse + specular,
        };
        // The midpoint rule for cosⁿ⁺¹ is off by (n+1)/(24 N²), its integral is 1/(n+2).
        let tolerance = 2.0 * (n + 1.0) * (n + 2.0) / (24.0 * f64::from(STEPS * STEPS));
        let error = (albedo - expected).abs() / expected;
        assert!(error <= tolerance, "{model} {n}: {albedo}, not {expected}");
    }
}

/// A furnace: under light of radiance 1 from everywhere, a `normalized_phong` surface is ρ_d + ρ_s
/// bright along its normal, and never brighter in any other direction.
#[test]
fn a_furnace_gets_no_brighter() {
    const RINGS: u32 = 48;
    const SECTORS: u32 = 96;
    const DISTANCE: f64 = 3.0;
    let mut lights = String::new();
    let solid_angle = TAU / f64::from(RINGS * SECTORS);
    for index in 0..RINGS * SECTORS {
        let cosine = (f64::from(index / SECTORS) + 0.5) / f64::from(RINGS);
        let sine = (1.0 - cosine * cosine).sqrt();
        let (sin, cos) = (TAU * f64::from(index % SECTORS) / f64::from(SECTORS)).sin_cos();
        let at = [sine * cos, cosine, sine * sin].map(|axis| axis * DISTANCE);
        lights += &light(index as usize, at, solid_angle * DISTANCE * DISTANCE);
    }
    for n in [1.0, 10.0, 30.0] {
        let (diffuse, specular) = (0.3, 0.6);
        let material = format!(
            "normalized_phong]\ndiffuse = {diffuse:?}\nspecular = {specular:?}\nshininess = {n:?}"
        );
        let floor = floor_of(&material);
        for degrees in [0.0_f64, 20.0, 45.0, 70.0, 85.0, 89.5] {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let view = format!(
                "[image]\nresolution = [1, 1]\n[camera.orthographic]\nheight = 1e-3\n\
                 eye = [{sine:?}, {cosine:?}, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n"
            );
            let film = render(&[view.as_str(), &floor, &lights].concat(), 1);
            let brightness = f64::from(pixel(&film, 0, 0)[0]);
            let albedo = diffuse + specular;
            // The midpoint rule, as above.
            let tolerance = ROUNDING + (n + 1.0) * (n + 2.0) / (12.0 * f64::from(RINGS * RINGS));
            assert!(
                brightness <= albedo * (1.0 + tolerance),
                "{n}, {degrees}°: {brightness}"
            );
            if degrees == 0.0 {
                assert!(
                    (brightness - albedo).abs() <= albedo * tolerance,
                    "{n}: {brightness}"
                );
            }
        }
    }
}

/// The area of the part of a pixel below the line y = `height_at(x)`, y down: a trapezoid, or what
/// the pixel leaves of it. Exact for lines but for 1e-6.
fn area_below(x: u32, y: u32, height_at: impl Fn(f64) -> f64) -> f64 {
    const STRIPS: u32 = 2000;
    let covered = |strip: u32| {
        let across = f64::from(x) + (f64::from(strip) + 0.5) / f64::from(STRIPS);
        (f64::from(y) + 1.0 - height_at(across)).clamp(0.0, 1.0)
    };
    (0..STRIPS).map(covered).sum::<f64>() / f64::from(STRIPS)
}

/// The box filter: the alpha of a pixel that an edge crosses becomes the area that is covered.
///
/// N stratified samples, a power of 4, lie one in each of √N × √N cells. A line crosses at most
/// 2√N of them and only these can be wrong, each by 1/N: the error is at most 2/√N. Independent
/// errors of the crossed cells have a variance of at most 1/4 of 1/N² each, so that the root mean
/// square over many pixels is below √(2√N)/(2N).
#[test]
fn the_coverage_of_an_edge() {
    const ROWS: u32 = 24;
    // A triangle whose upper edge crosses the image, far larger than it; 24 units are 24 pixels.
    let (left, right) = (9.3, 14.9);
    let vertices = [[-12.0, 12.0 - left, 0.0], [12.0, 12.0 - right, 0.0]];
    let [[x0, y0, _], [x1, y1, _]] = vertices;
    let (dx, dy) = (x1 - x0, y1 - y0);
    let far = [
        [x0 - 10.0 * dx, y0 - 10.0 * dy, 0.0],
        [x1 + 10.0 * dx, y1 + 10.0 * dy, 0.0],
        [0.0, -1e4, 0.0],
    ];
    let scene = format!(
        "[image]\nresolution = [{ROWS}, {ROWS}]\nbackground = [0, 8, 0]\n\
         [camera.orthographic]\neye = [0, 0, 5]\nlook_at = [0, 0, 0]\nheight = {ROWS}\n\
         [materials.m.phong]\ndiffuse = [1, 0, 0]\n\
         [objects.edge.triangle]\nmaterial = \"m\"\nvertices = {far:?}\n\
         [lights.far.point]\nposition = [0, 0, 1e6]\nintensity = 1e12\n"
    );
    let line = |x: f64| left + (right - left) * x / f64::from(ROWS);
    for samples in [4, 16, 64, 256] {
        let film = render(&scene, samples);
        let n = f64::from(samples);
        let (mut squares, mut edges) = (0.0, 0);
        for y in 0..ROWS {
            for x in 0..ROWS {
                let [r, g, b, alpha] = pixel(&film, x, y);
                let area = area_below(x, y, line);
                let error = f64::from(alpha) - area;
                assert!(error.abs() <= 2.0 / n.sqrt(), "{samples}: {alpha}, {area}");
                if area > 0.0 && area < 1.0 {
                    squares += error * error;
                    edges += 1;
                } else {
                    assert_eq!(f64::from(alpha), area);
                }
                // The light is 1 lx all over: what is covered is premultiplied, and what is not
                // shows the background.
                let alpha = f64::from(alpha);
                assert!((f64::from(r) - alpha).abs() <= ROUNDING, "{r}, {alpha}");
                assert!((f64::from(g) - 8.0 * (1.0 - alpha)).abs() <= 8.0 * ROUNDING);
                assert_eq!(b, 0.0);
            }
        }
        let mean = (squares / f64::from(edges)).sqrt();
        let bound = (2.0 * n.sqrt()).sqrt() / (2.0 * n);
        assert!(edges > 20 && mean <= bound, "{samples}: {mean}, {bound}");
    }
}

#[test]
fn nothing_but_background() {
    let scene = format!(
        "[image]\nresolution = [5, 4]\nbackground = [0.25, 0.5, 1e-3]\n\
         [camera.perspective]\neye = [0, 0, 5]\nlook_at = [0, 0, 9]\nvertical_fov = 50\n\
         [materials.m.phong]\n\
         [objects.behind.sphere]\nmaterial = \"m\"\ncenter = [0, 0, 0]\nradius = 1\n{}",
        light(0, [0.0, 0.0, 8.0], 100.0)
    );
    for samples in [1, 4] {
        for &pixel in render(&scene, samples).pixels() {
            assert_eq!(pixel, [0.25, 0.5, 1e-3, 0.0]);
        }
    }
}

/// Four balls in the corners: (0, 0) is the top left, and +x is on the right of a camera that
/// looks along −z.
#[test]
fn the_image_is_the_right_way_up() {
    let mut objects = String::new();
    for (name, x, y, color) in [
        ("top_left", -1, 1, [1, 0, 0]),
        ("top_right", 1, 1, [0, 1, 0]),
        ("bottom_left", -1, -1, [0, 0, 1]),
        ("bottom_right", 1, -1, [1, 1, 1]),
    ] {
        let _ = write!(
            objects,
            "[materials.{name}.phong]\ndiffuse = {color:?}\n\
             [objects.{name}.sphere]\nmaterial = \"{name}\"\ncenter = [{x}, {y}, 0]\nradius = 0.6\n"
        );
    }
    let lights = light(0, [0.0, 0.0, 10.0], 100.0);
    for camera in [
        "[camera.perspective]\nvertical_fov = 25\n",
        "[camera.orthographic]\nheight = 4\n",
    ] {
        let scene = format!(
            "[image]\nresolution = [40, 40]\n{camera}eye = [0, 0, 10]\nlook_at = [0, 0, 0]\n\
             {objects}{lights}"
        );
        let film = render(&scene, 1);
        let lit = |x, y| {
            let [r, g, b, _] = pixel(&film, x, y);
            [r > 0.0, g > 0.0, b > 0.0]
        };
        assert_eq!(lit(10, 10), [true, false, false]);
        assert_eq!(lit(30, 10), [false, true, false]);
        assert_eq!(lit(10, 30), [false, false, true]);
        assert_eq!(lit(30, 30), [true, true, true]);
    }
}

/// f of the three curves, from the cosine and the angle to the axis, inner 20° and outer 30°.
fn falloff(name: &str, angle: f64) -> f64 {
    let [inner, outer] = [20.0_f64, 30.0].map(f64::to_radians);
    let x = ((angle.cos() - outer.cos()) / (inner.cos() - outer.cos())).clamp(0.0, 1.0);
    match name {
        "smooth" => x * x * (3.0 - 2.0 * x),
        "gltf" => x * x,
        _ => ((outer - angle) / (outer - inner)).clamp(0.0, 1.0),
    }
}

/// L = I f(θ) k_d h / (h² + r²)^{3/2} under a spot that points straight down: on the axis, in the penumbra, and
/// outside, where it is nothing and no shadow ray is asked.
#[test]
fn a_plane_under_a_spot() {
    let (intensity, h, height) = (30.0, 2.0, 4.0);
    for name in ["smooth", "gltf", "linear_angle"] {
        let text = [
            from_above(64, height),
            floor_of("phong]\ndiffuse = 0.5"),
            format!(
                "[lights.s.spot]\nposition = [0.1, {h:?}, 0]\ndirection = [0, -3, 0]\nintensity = \
                 {intensity:?}\ninner = 20\nouter = 30\nfalloff = \"{name}\"\n"
            ),
        ]
        .concat();
        let (film, counts) = render_counted(&text, 1);
        let (mut inside, mut shades) = (0, 0);
        each_pixel(&film, height, |x, z, [r, ..]| {
            let radius = (x - 0.1).hypot(z);
            let f = falloff(name, (radius / h).atan());
            if f == 0.0 {
                assert_eq!(r, 0.0, "{name} at {radius}");
                return;
            }
            inside += 1;
            shades += u64::from(f < 1.0);
            let d2 = h * h + radius * radius;
            let expected = 0.5 * intensity * f * h / d2.powf(1.5);
            // Close to the edge, where f is a small difference, as exact as at the axis.
            let tolerance = ROUNDING + 1e-12 / f;
            assert_near(r, expected, tolerance, name);
        });
        assert!(shades > 300, "{name}: {shades}");
        assert_eq!(counts.shadow_rays, inside, "{name}");
    }
}

/// What falls onto a plane under a spot is its flux, ∫ E dA = ∫ I f cos θ / d² dA = ∫ I f dω: from the image it is
/// what `lumens` says, whatever the cone.
#[test]
fn a_spot_in_lumens_sends_out_so_much() {
    for (inner, outer, name) in [
        (20.0, 30.0, "smooth"),
        (0.0, 60.0, "gltf"),
        (10.0, 80.0, "linear_angle"),
        (45.0, 45.0, "smooth"),
    ] {
        // The light is 1 m above the plane.
        let (resolution, height) = (128, 2.1 * f64::to_radians(outer).tan());
        let text = [
            from_above(resolution, height),
            floor_of("phong]\ndiffuse = 1"),
            format!(
                "[lights.s.spot]\nposition = [0, 1, 0]\nlook_at = [0, 0, 0]\nintensity = {{ lumens = 800 \
                 }}\ninner = {inner:?}\nouter = {outer:?}\nfalloff = \"{name}\"\n"
            ),
        ]
        .concat();
        let film = render(&text, 4);
        let mut sum = 0.0;
        each_pixel(&film, height, |_, _, [r, ..]| sum += f64::from(r));
        let area = (height / f64::from(resolution)).powi(2);
        // What is left is the sampling, of sharp edges above all.
        let flux = sum * area;
        assert!((flux / 800.0 - 1.0).abs() < 2e-3, "{name} {outer}: {flux}");
    }
}

/// L = E k_d n·ω, the same at all points.
#[test]
fn a_plane_under_a_sun() {
    for (direction, cos) in [
        ("[0, -1, 0]", 1.0),
        ("[3, -4, 0]", 0.8),
        ("[-2e6, -1e6, 2e6]", 1.0 / 3.0),
        ("[1e-6, 1e-9, 0]", 0.0),
    ] {
        let text = [
            from_above(16, 4.0),
            floor_of("phong]\ndiffuse = 0.5"),
            format!("[lights.s.sun]\ndirection = {direction}\nilluminance = [100000, 5, 0]\n"),
        ]
        .concat();
        let film = render(&text, 1);
        each_pixel(&film, 4.0, |_, _, [r, g, ..]| {
            assert_near(r, 0.5 * 100_000.0 * cos, ROUNDING, direction);
            assert_near(g, 0.5 * 5.0 * cos, ROUNDING, direction);
        });
    }
}

/// The shadow of a sphere under a sun is as wide as the sphere, wherever that is: an ellipse of half-axes R and
/// R / cos θ around where the way through its center meets the floor.
#[test]
fn a_sphere_under_a_sun() {
    for height in [0.5, 10.0, 1e4] {
        let text = [
            from_above(64, 4.0),
            floor_of("phong]\ndiffuse = 0.5"),
            format!(
                "[lights.s.sun]\ndirection = [3, -4, 0]\nilluminance = 10\n[objects.ball.sphere]\nmaterial = \
                 \"m\"\ncenter = [{:?}, {height:?}, 0.2]\nradius = 0.4\n",
                // As seen from above it is not before its shadow.
                -0.75 * height + if height < 1.0 { -0.5 } else { 0.0 }
            ),
        ]
        .concat();
        let film = render(&text, 1);
        let center = if height < 1.0 { -0.5 } else { 0.0 };
        let mut dark = 0;
        each_pixel(&film, 4.0, |x, z, [r, ..]| {
            let from_ball = (x - (-0.75 * height + center)).hypot(z - 0.2);
            if from_ball < 0.5 {
                return;
            }
            let inside = ((x - center) * 0.8).hypot(z - 0.2);
            // The rays of the camera go nearly straight down.
            if inside < 0.39 {
                dark += 1;
                assert_eq!(r, 0.0, "{height} at {x} {z}");
            } else if inside > 0.41 {
                assert_near(r, 0.5 * 10.0 * 0.8, ROUNDING, "lit");
            }
        });
        assert!(dark > 40, "{height}: {dark}");
    }
}

/// L = I(V, H) k_d h / (h² + r²)^{3/2} under a luminaire that points straight down, its table bilinear in both
/// angles: horizontal angle 0 is towards `up`, and they go counter-clockwise for one who looks against the light.
#[test]
fn a_plane_under_a_luminaire() {
    let folder = tempfile::tempdir().unwrap();
    let table = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 2 3 5 1 2 0 0 0\n1 1 10\n0 30 90\n0 90 180 270 360\n\
                 50 10 0\n50 20 0\n50 30 0\n50 40 0\n50 10 0\n";
    std::fs::write(folder.path().join("lamp.ies"), table).unwrap();
    let (h, height) = (1.5, 4.0);
    let text = [
        from_above(64, height),
        floor_of("phong]\ndiffuse = 0.5"),
        format!(
            "[lights.s.ies]\nposition = [0.1, {h:?}, 0]\ndirection = [0, -3, 0]\nup = [1, 0, 0]\nfile = \
             \"lamp.ies\"\nscale = 0.25\n"
        ),
    ]
    .concat();
    let scene = Scene::parse(&text, folder.path().join("scene.toml")).unwrap();
    let film = film_of(&scene, 1);
    each_pixel(&film, height, |x, z, [r, ..]| {
        let radius = (x - 0.1).hypot(z);
        let vertical = (radius / h).atan().to_degrees();
        // Seen from below with x to the right, z is upwards.
        let horizontal = z.atan2(x - 0.1).to_degrees().rem_euclid(360.0);
        let at_30 = match horizontal {
            h if h < 90.0 => 10.0 + 10.0 * h / 90.0,
            h if h < 180.0 => 20.0 + 10.0 * (h - 90.0) / 90.0,
            h if h < 270.0 => 30.0 + 10.0 * (h - 180.0) / 90.0,
            h => 40.0 - 30.0 * (h - 270.0) / 90.0,
        };
        let candela = if vertical < 30.0 {
            50.0 + (at_30 - 50.0) * vertical / 30.0
        } else {
            at_30 * (90.0 - vertical) / 60.0
        };
        let d2 = h * h + radius * radius;
        // The file's multiplier is 2.
        let expected = 0.25 * 2.0 * candela * 0.5 * h / d2.powf(1.5);
        assert_near(r, expected, 1e-6, "luminaire");
    });
}

/// Half of the light of a spot of 90° to 90° is a hemisphere of a point light.
#[test]
fn a_spot_of_all_directions_below_is_a_point_light() {
    let scene = |light: &str| {
        [
            from_above(32, 6.0),
            floor_of("phong]\ndiffuse = 0.3\nspecular = 0.2\nshininess = 20"),
            format!("[lights.l.{light}\nposition = [0.3, 1.5, -0.2]\nintensity = [3, 4, 5]\n"),
        ]
        .concat()
    };
    let point = render(&scene("point]"), 1);
    let spot = render(
        &scene("spot]\ndirection = [0, -1, 0]\ninner = 90\nouter = 90"),
        1,
    );
    assert_eq!(point.pixels(), spot.pixels());
}
