//! L3 and L5 to L9 against closed forms.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::*;
use crate::oracle::lighting::{Material as Lit, ideal_reflection};
use crate::oracle::value::Palette;
use crate::oracle::vector::{cross, dot, length, unit};

/// Directions over the sphere, none of them special.
fn directions() -> Vec<[f64; 3]> {
    (0..200)
        .map(|i| {
            let i = f64::from(i);
            unit([(i * 1.3).sin(), (i * 0.7 + 1.0).cos(), (i * 2.1).sin()]).unwrap()
        })
        .collect()
}

#[test]
fn a_plane_under_a_light() {
    let (intensity, diffuse, height) = (12.0, 0.6, 2.0_f64);
    for x in [0.0, 0.5, 1.0, 4.0, 30.0_f64] {
        let radiance = Builder::looking([x + 1.0, 3.0, 0.5], [x, 0.0, 0.0])
            .material(MATTE, Material::Phong(lobes(diffuse, 0.0, None)))
            .plane([0.0; 3], [0.0, 1.0, 0.0])
            .light([0.0, height, 0.0], intensity)
            .radiance();
        let distance_squared = height * height + x * x;
        let expected = intensity * diffuse * height / distance_squared.powf(1.5);
        assert_near(radiance, expected, ROUNDING);
    }
}

#[test]
fn a_sphere_follows_lambert() {
    let light = [2.0, 3.0, 4.0];
    let oracle = Builder::new([20, 20], orthographic([0.0, 0.0, 5.0], [0.0; 3], 2.0))
        .sphere([0.0; 3], 1.0)
        .light(light, 7.0)
        .oracle();
    let mut lit = 0;
    for (column, row) in (0..20).flat_map(|x| (0..20).map(move |y| (x, y))) {
        let (px, py) = (f64::from(column) + 0.5, f64::from(row) + 0.5);
        let (x, y) = (px / 10.0 - 1.0, 1.0 - py / 10.0);
        let sample = oracle.radiance(px, py);
        let depth_squared = 1.0 - x * x - y * y;
        assert_eq!(sample.coverage, f64::from(u8::from(depth_squared > 0.0)));
        if depth_squared > 0.0 {
            let n = [x, y, depth_squared.sqrt()];
            let way = [0, 1, 2].map(|i| light[i] - n[i]);
            let expected = 7.0 * dot(n, way).max(0.0) / length(way).powi(3);
            assert_near(sample.radiance[1], expected, ROUNDING);
            lit += i32::from(expected > 0.0);
        }
    }
    assert!(lit > 150, "{lit} pixels");
}

#[test]
fn light_falls_with_the_square_of_the_distance() {
    let at = |distance: f64| {
        Builder::looking([1.0, 1.0, 1.0], [0.0; 3])
            .plane([0.0; 3], [0.0, 1.0, 0.0])
            .light([0.0, distance, 0.0], 36.0)
            .radiance()
    };
    assert_near(at(1.0), 36.0, ROUNDING);
    assert_near(at(2.0), 9.0, ROUNDING);
    assert_near(at(3.0), 4.0, ROUNDING);
}

#[test]
fn the_ideal_reflection() {
    for n in directions() {
        for to_light in directions() {
            let reflected = ideal_reflection(n, to_light);
            assert_near(length(reflected), 1.0, ROUNDING);
            // The same angle, in the same plane, on the other side of the normal.
            assert!((dot(reflected, n) - dot(to_light, n)).abs() < ROUNDING);
            assert!(dot(cross(n, to_light), reflected).abs() < ROUNDING);
            let back = ideal_reflection(n, reflected);
            assert!((0..3).all(|i| (back[i] - to_light[i]).abs() < ROUNDING));
        }
    }
    assert_eq!(
        ideal_reflection([0.0, 1.0, 0.0], [0.6, 0.8, 0.0]),
        [-0.6, 0.8, 0.0]
    );
}

#[test]
fn the_highlight_has_the_profile_of_its_cosine() {
    for shininess in [0.5, 1.0, 10.0, 1000.0] {
        for degrees in [0.0, 5.0, 30.0, 60.0, 85.0_f64] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            // The light is above the point, so ω_r = n and the viewer's angle is the lobe's.
            let radiance = Builder::looking([3.0 * sin, 3.0 * cos, 0.0], [0.0; 3])
                .material(MATTE, Material::Phong(lobes(0.25, 0.5, Some(shininess))))
                .plane([0.0; 3], [0.0, 1.0, 0.0])
                .light([0.0, 2.0, 0.0], 8.0)
                .radiance();
            let expected = 8.0 / 4.0 * (0.25 + 0.5 * cos.powf(shininess));
            assert_near(radiance, expected, ROUNDING * shininess.max(1.0));
        }
    }
}

#[test]
fn phong_to_the_letter_has_no_cosine_on_its_highlight() {
    // Light and viewer as mirror images at 60° from the normal.
    let (sin, cos) = 60.0_f64.to_radians().sin_cos();
    let scene = |material| {
        Builder::looking([sin, cos, 0.0], [0.0; 3])
            .material(MATTE, material)
            .plane([0.0; 3], [0.0, 1.0, 0.0])
            .light([-sin, cos, 0.0], 1.0)
            .radiance()
    };
    let lobes = lobes(0.0, 0.5, Some(20.0));
    assert_near(scene(Material::Phong(lobes.clone())), 0.5, ROUNDING * 20.0);
    assert_near(
        scene(Material::NormalizedPhong(lobes)),
        0.5 * 22.0 / TAU * cos,
        ROUNDING * 20.0,
    );
}

/// ∫ f dω over the hemisphere around +z, by the midpoint rule in the polar angle and azimuth.
fn over_hemisphere(f: impl Fn([f64; 3]) -> f64) -> f64 {
    const RINGS: u32 = 800;
    const SECTORS: u32 = 400;
    let (ring, sector) = (FRAC_PI_2 / f64::from(RINGS), TAU / f64::from(SECTORS));
    let mut sum = 0.0;
    for i in 0..RINGS {
        let (sin, cos) = ((f64::from(i) + 0.5) * ring).sin_cos();
        for j in 0..SECTORS {
            let (y, x) = ((f64::from(j) + 0.5) * sector).sin_cos();
            sum += f([sin * x, sin * y, cos]) * sin;
        }
    }
    sum * ring * sector
}

/// The error of the midpoint rule with this many rings, for lobes up to n = 100.
const QUADRATURE: f64 = 1e-3;

fn lit(material: &Material) -> Lit {
    Lit::new(
        material,
        &Palette::new(&Builder::looking([1.0; 3], [0.0; 3]).0),
    )
}

/// ∫ r(ω_i, ω_o) dω_i: what a viewer at `to_viewer` sees under light of 1 lx from everywhere.
fn directional_albedo(material: &Lit, to_viewer: [f64; 3]) -> f64 {
    let n = [0.0, 0.0, 1.0];
    over_hemisphere(|to_light| {
        let cos_lobe = dot(to_viewer, ideal_reflection(n, to_light)).max(0.0);
        material
            .reflectance(to_light[2].into(), cos_lobe.into())
            .sum()
            .0[0]
    })
}

#[test]
fn normalized_phong_does_not_reflect_more_than_arrives() {
    for shininess in [1.0, 5.0, 100.0] {
        let material = lit(&Material::NormalizedPhong(lobes(0.3, 0.7, Some(shininess))));
        let at_normal = directional_albedo(&material, [0.0, 0.0, 1.0]);
        assert_near(at_normal, 1.0, QUADRATURE);
        let mut before = at_normal;
        for degrees in [20.0, 40.0, 60.0, 80.0_f64] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let albedo = directional_albedo(&material, [sin, 0.0, cos]);
            assert!(albedo <= before + QUADRATURE, "{shininess} {degrees}");
            assert!(albedo >= 0.3);
            before = albedo;
        }
    }
}

#[test]
fn phong_reflects_pi_times_its_diffuse_constant() {
    let material = lit(&Material::Phong(lobes(0.4, 0.0, None)));
    let albedo = directional_albedo(&material, [0.6, 0.0, 0.8]);
    assert_near(albedo, PI * 0.4, QUADRATURE);
    let normalized = lit(&Material::NormalizedPhong(lobes(0.4, 0.0, None)));
    let albedo = directional_albedo(&normalized, [0.6, 0.0, 0.8]);
    assert_near(albedo, 0.4, QUADRATURE);
}

#[test]
fn lights_add_up_channel_by_channel() {
    let mut scene = Builder::looking([1.0, 2.0, 1.0], [0.0; 3])
        .plane([0.0; 3], [0.0, 1.0, 0.0])
        .light([0.0, 1.0, 0.0], 0.0)
        .light([0.0, 2.0, 0.0], 4.0);
    scene.0.lights[0].value.size_mut().value = Value::Rgb {
        rgb: [1.0, 2.0, 3.0],
        space: crate::scene::ColorSpace::Rec709,
    };
    let Material::Phong(lobes) = &mut scene.0.materials[0].value else {
        unreachable!("the builder's material is phong");
    };
    lobes.diffuse.value = Value::Srgb([255, 255, 0]);
    let explanation = scene.oracle().explain(0.5, 0.5);
    for (channel, expected) in [2.0, 3.0, 0.0].into_iter().enumerate() {
        assert_near(explanation.radiance[channel], expected, ROUNDING);
        let shares = explanation
            .lights
            .iter()
            .map(|light| light.radiance[channel]);
        assert_near(shares.sum(), expected, ROUNDING);
    }
    for light in &explanation.lights {
        assert!(light.visible && light.occluder.is_none());
        for channel in 0..3 {
            let product =
                light.incident[channel] * (light.diffuse[channel] + light.specular[channel]);
            assert_near(light.radiance[channel], product, ROUNDING);
        }
    }
}

#[test]
fn nothing_but_background() {
    let mut scene = Builder::looking([0.0, 1.0, 0.0], [0.0, 2.0, 0.0])
        .plane([0.0; 3], [0.0, 1.0, 0.0])
        .light([0.0, 5.0, 0.0], 1.0);
    scene.0.image.background.value = Value::Uniform(0.25);
    let oracle = scene.oracle();
    let sample = oracle.radiance(0.5, 0.5);
    assert_eq!((sample.radiance, sample.coverage), ([0.25; 3], 0.0));
    assert_eq!(oracle.trace(0.5, 0.5), None);
    let explanation = oracle.explain(0.5, 0.5);
    assert!(explanation.hit.is_none() && explanation.lights.is_empty());
    assert_eq!(explanation.radiance, [0.25; 3]);
}

/// L_o(λ) = I(λ) k_d(λ) / d² straight under the lamp, and its luminance by 683 lm/W ∫ L_o ȳ dλ.
#[test]
fn spectra_are_multiplied_wavelength_by_wavelength() {
    let curve = |values: [f64; 2]| {
        let curve = crate::spectrum::Curve::new(vec![360.0, 830.0], values.to_vec());
        Value::Curve(Arc::new(curve.unwrap()))
    };
    let mut scene = Builder::looking([1.0, 2.0, 1.0], [0.0; 3])
        .plane([0.0; 3], [0.0, 1.0, 0.0])
        .light([0.0, 2.0, 0.0], 1.0);
    scene.0.lights[0].value.size_mut().value = curve([0.02, 0.01]);
    let Material::Phong(lobes) = &mut scene.0.materials[0].value else {
        unreachable!("the builder's material is phong");
    };
    lobes.diffuse.value = curve([0.0, 1.0]);
    let oracle = scene.oracle();
    let spectrum = oracle.spectral_radiance(0.5, 0.5).unwrap();
    let mut luminance = 0.0;
    let matching = crate::spectrum::tables::cie_1931().column("y");
    for (i, (&radiance, y)) in spectrum.iter().zip(matching).enumerate() {
        let part = i as f64 / 470.0;
        assert_near(radiance, (0.02 - 0.01 * part) * part / 4.0, ROUNDING);
        luminance += 683.0 * radiance * y;
    }
    let explanation = oracle.explain(0.5, 0.5);
    assert_eq!(explanation.radiance, oracle.radiance(0.5, 0.5).radiance);
    assert_eq!(explanation.radiance, explanation.lights[0].unoccluded);
    let [r, g, b] = explanation.radiance;
    // The white of Rec.709 is that of illuminant D65 to 3e-4.
    assert_near(0.2126 * r + 0.7152 * g + 0.0722 * b, luminance, 5e-4);
    // The product of the RGB is another.
    let light = &explanation.lights[0];
    assert!((light.incident[0] * light.diffuse[0] / r - 1.0).abs() > 1e-3);
}
