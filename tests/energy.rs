//! How much of the light a surface sends back: directional albedos of both lobes of both materials, from what the
//! renderer computes and by the closed form of `docs/energy.md`.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fs;

use candela::scene::{Camera, Image, Light, Material, Object, Scene};

use crate::images::{film_of, pixel};
use crate::measured::Measured;

/// Relative error of the albedo of a lobe: of the midpoint rule, where the horizon cuts the lobe.
pub(crate) const LOBES: f64 = 4.65e-4;

/// Steps of the lobe's cosine and around its axis.
const STEPS: [u32; 2] = [96, 192];

const EXPONENTS: [f64; 6] = [0.5, 1.0, 5.0, 20.0, 100.0, 1000.0];
const DEGREES: [f64; 6] = [0.0, 20.0, 45.0, 60.0, 75.0, 88.0];

/// ∫ sinᵐ from 0 to π/2.
fn wallis(m: f64) -> f64 {
    let ratio = libm::lgamma((m + 1.0) / 2.0) - libm::lgamma(m / 2.0 + 1.0);
    PI.sqrt() / 2.0 * ratio.exp()
}

/// F(θ, n) = ∫ cosⁿα cos θ_o dω over the directions above the surface, α from an axis at the angle θ to its normal:
/// 2π c/(n+2) + 2A/(n+1) − 2c² B/(n+2), with c = cos θ, A = sᵐ Wₘ and B = Σ sᵐ⁺²ᵏ Wₘ₊₂ₖ, m = n + 2, s = sin θ.
fn lobe_with_cosine(theta: f64, n: f64) -> f64 {
    let (s, c) = theta.sin_cos();
    let m = n + 2.0;
    let a = s.powf(m) * wallis(m);
    let (mut term, mut b, mut exponent) = (a, 0.0, m);
    while term > 1e-17 * (1.0 + b) {
        b += term;
        term *= s * s * (exponent + 1.0) / (exponent + 2.0);
        exponent += 2.0;
    }
    TAU * c / m + 2.0 * a / (n + 1.0) - 2.0 * c * c * b / m
}

/// Radiance of a floor that is seen at the angle θ from its normal, under a light of each direction around an axis at
/// `axis` to the normal, on the other side: as strong as the weight that `strength` makes of a solid angle and
/// the cosine to the normal. The directions are as dense as cosⁿ around the axis asks for.
fn radiance(
    material: &Material,
    theta: f64,
    axis: f64,
    n: f64,
    strength: impl Fn(f64, f64) -> f64,
) -> f64 {
    let (s, c) = theta.sin_cos();
    let camera = Camera::orthographic([s, c, 0.0], [0.0; 3], 1e-6).up([0.0, 0.0, 1.0]);
    let mut scene = Scene::new(Image::new(1, 1), camera)
        .material("m", material.clone())
        .object("floor", Object::plane("m", [0.0; 3], [0.0, 1.0, 0.0]));
    let (s, c) = axis.sin_cos();
    let [rows, columns] = STEPS;
    for row in 0..rows {
        // The midpoint rule in y = xⁿ⁺¹, x the cosine to the axis: dy = (n + 1) xⁿ dx.
        let y = (f64::from(row) + 0.5) / f64::from(rows);
        let x = y.powf(1.0 / (n + 1.0));
        let aside = (1.0 - x * x).sqrt();
        let solid_angle = TAU / f64::from(columns) / f64::from(rows) / ((n + 1.0) * x.powf(n));
        for column in 0..columns {
            let (sin, cos) = (TAU * (f64::from(column) + 0.5) / f64::from(columns)).sin_cos();
            let way = [
                c * aside * cos - s * x,
                s * aside * cos + c * x,
                aside * sin,
            ];
            if way[1] > 0.0 {
                let name = format!("l{row}-{column}");
                scene = scene.light(name, Light::point(way, strength(solid_angle, way[1])));
            }
        }
    }
    f64::from(pixel(&film_of(&scene, 1), 0, 0)[1])
}

/// L7 is the same for both directions, as is a Lambertian surface: what comes back of one direction, into all, is what
/// all send into this one, each weighted by its cosine.
#[test]
fn directional_albedos() {
    let mut lobes = Measured::new("albedo of lobes", LOBES);
    let mut diffuse = Measured::rounding("albedo of diffuse reflectance");
    for degrees in DEGREES {
        let theta = degrees.to_radians();
        let see = |worst: &mut Measured, found: f64, expected: f64, what: &str| {
            worst.see((found / expected - 1.0).abs(), || {
                format!("{what}, {degrees}°: {found}, expected {expected}")
            });
        };
        for (material, expected) in [
            (Material::phong(0.3), 0.3 * PI),
            (Material::normalized_phong(0.8), 0.8),
        ] {
            // L5 has the cosine of the light.
            let found = radiance(&material, theta, 0.0, 1.0, |solid_angle, _| solid_angle);
            see(&mut diffuse, found, expected, "diffuse");
        }
        for n in EXPONENTS {
            let share = lobe_with_cosine(theta, n);
            let phong = Material::phong(0.0).specular(0.4, n);
            // L7 has not.
            let found = radiance(&phong, theta, theta, n, |solid_angle, cosine| {
                solid_angle * cosine
            });
            let what = format!("phong {n}");
            see(
                &mut lobes,
                found / theta.cos(),
                0.4 * share / theta.cos(),
                &what,
            );

            let normalized = Material::normalized_phong(0.0).specular(0.9, n);
            let found = radiance(&normalized, theta, theta, n, |solid_angle, _| solid_angle);
            let expected = 0.9 * share * (n + 2.0) / TAU;
            let what = format!("normalized_phong {n}");
            see(&mut lobes, found, expected, &what);
            assert!(expected <= 0.9 * (1.0 + 1e-14), "{what}: {expected}");
        }
    }
    diffuse.judge();
    lobes.judge();
}

/// What the docs state of F.
#[test]
fn the_closed_form() {
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a}, {b}");
    for n in EXPONENTS {
        near(lobe_with_cosine(0.0, n), TAU / (n + 2.0));
    }
    for degrees in DEGREES {
        let theta: f64 = degrees.to_radians();
        let (s, c) = theta.sin_cos();
        near(lobe_with_cosine(theta, 0.0), FRAC_PI_2 * (1.0 + c));
        near(
            lobe_with_cosine(theta, 1.0),
            2.0 / 3.0 * (s + (PI - theta) * c),
        );
    }
    let page = fs::read_to_string("docs/energy.md").unwrap();
    for stated in ["2π/(n+2)", "⅔ (sin θ + (π − θ) cos θ)", "π/2 (1 + cos θ)"] {
        assert!(page.contains(stated), "{stated}");
    }
}

/// What the page's table states of a white lobe: the albedo of `phong` and of `normalized_phong`.
#[test]
fn the_table_of_the_page() {
    let page = fs::read_to_string("docs/energy.md").unwrap();
    for degrees in [0.0, 30.0, 60.0, 80.0, 89.0] {
        let theta = f64::to_radians(degrees);
        let cells = [1.0, 5.0, 20.0, 100.0, 1000.0].map(|n| {
            let share = lobe_with_cosine(theta, n);
            format!(
                "{:.3} / {:.3}",
                share / theta.cos(),
                share * (n + 2.0) / TAU
            )
        });
        let row = format!("| {degrees}° | {} |", cells.join(" | "));
        assert!(page.lines().any(|line| line == row), "{row}");
    }
}
