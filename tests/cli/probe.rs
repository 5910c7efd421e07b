//! `candela probe`: its numbers beside those of the image.

use std::fs;
use std::path::Path;

use candela::spectrum::tables;
use serde_json::Value;

use super::{RESOLUTION, SCENE, fails, folder, image, succeeds, with_bulge};
use crate::measured::{HALF_LAST_BIT, Measured};

fn triple(value: &Value) -> [f64; 3] {
    let numbers: Vec<f64> = value
        .as_array()
        .unwrap()
        .iter()
        .map(|number| number.as_f64().unwrap())
        .collect();
    numbers.try_into().unwrap()
}

fn probe(folder: &Path, x: u32, y: u32) -> Value {
    let text = succeeds(folder, &format!("probe ball.toml --pixel {x},{y} --json"));
    serde_json::from_str(&text).unwrap()
}

#[test]
fn a_probe_explains_the_pixel_of_the_image() {
    /// The terms of the report, relative: each is a few operations in f64 away from the others.
    const TERMS: f64 = 3.77e-16;
    /// The rounding to f32.
    const TOLERANCE: f64 = Measured::ROOM * HALF_LAST_BIT;
    let mut of_terms = Measured::new("terms of a probe", TERMS);
    let folder = folder();
    succeeds(folder.path(), "render ball.toml --samples 1");
    let rendered = image(folder.path(), "ball.exr").pixels;
    let (mut objects, mut occluded) = (Vec::new(), 0);
    for [x, y] in [
        [0, 0],
        [30, 20],
        [59, 39],
        [25, 33],
        [20, 25],
        [35, 15],
        [12, 30],
        [21, 28],
    ] {
        let report = probe(folder.path(), x, y);
        assert_eq!(report["pixel"], serde_json::json!([x, y]));
        let radiance = triple(&report["radiance"]);
        let pixel = rendered[(y * RESOLUTION[0] + x) as usize];
        for (&explained, &rendered) in radiance.iter().zip(&pixel) {
            let error = (explained - f64::from(rendered)).abs();
            assert!(error <= TOLERANCE * explained, "{x},{y}: {report}");
        }
        let hit = &report["hit"];
        if hit.is_null() {
            assert_eq!(pixel[3], 0.0);
            assert_eq!(radiance, [0.1, 0.2, 0.4]);
            assert_eq!(report["lights"], serde_json::json!([]));
            continue;
        }
        assert_eq!(pixel[3], 1.0);
        assert_eq!(hit["material"], "clay");
        objects.push(hit["object"].as_str().unwrap().to_owned());
        // The point is where the distance says: |p − eye|, and the normal is of unit length.
        let (p, n) = (triple(&hit["position"]), triple(&hit["normal"]));
        let way = [p[0], p[1] - 1.0, p[2] - 4.0];
        let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let mut same = |actual: f64, expected: f64, what: &str| {
            let error = (actual - expected).abs() / expected.max(f64::MIN_POSITIVE);
            of_terms.see(error, || format!("{what} at {x},{y}"));
        };
        same(length(way), hit["distance"].as_f64().unwrap(), "distance");
        same(length(n), 1.0, "normal");
        let lights = report["lights"].as_array().unwrap();
        let names: Vec<&Value> = lights.iter().map(|light| &light["name"]).collect();
        assert_eq!(names, ["key", "fill"]);
        let mut sum = [0.0; 3];
        for light in lights {
            let visible = light["visible"].as_bool().unwrap();
            assert_eq!(light["occluder"].is_null(), visible);
            occluded += usize::from(!visible);
            let [share, incident, diffuse, specular] =
                ["radiance", "incident", "diffuse", "specular"].map(|key| triple(&light[key]));
            let distance = light["distance"].as_f64().unwrap();
            let intensity = if light["name"] == "key" { 30.0 } else { 4.0 };
            let cosine = light["cos_incident"].as_f64().unwrap();
            for channel in 0..3 {
                let expected = intensity / (distance * distance);
                same(incident[channel], expected, "incident");
                let lambert = [0.7, 0.3, 0.2][channel] * cosine;
                same(diffuse[channel], lambert, "diffuse");
                let reflectance = diffuse[channel] + specular[channel];
                let expected = if visible {
                    incident[channel] * reflectance
                } else {
                    0.0
                };
                same(share[channel], expected, "share");
                sum[channel] += share[channel];
            }
        }
        for (sum, radiance) in sum.iter().zip(radiance) {
            same(*sum, radiance, "sum");
        }
        // The table for reading names the same.
        let table = succeeds(folder.path(), &format!("probe ball.toml --pixel {x},{y}"));
        for name in [objects.last().unwrap().as_str(), "clay", "key", "fill"] {
            assert!(table.contains(name), "{table}");
        }
    }
    of_terms.judge();
    assert!(objects.contains(&"ball".to_owned()) && objects.contains(&"floor".to_owned()));
    assert!(occluded > 0);
}

#[test]
fn a_probe_outside_of_the_image() {
    let folder = folder();
    for pixel in ["60,0", "0,40", "4000000000,1"] {
        let message = fails(
            folder.path(),
            &format!("probe ball.toml --pixel {pixel}"),
            1,
        );
        assert!(message.contains("60 × 40"), "{message}");
    }
}

/// 683 lm/W ∫ L(λ) ȳ(λ) dλ is the luminance of the radiance, and that of the image.
#[test]
fn a_probed_spectrum_has_the_luminance_of_the_pixel() {
    /// The luminances of Rec.709's red, green and blue (ITU-R BT.709-6, more digits).
    const WEIGHTS: [f64; 3] = [0.212_639_005_9, 0.715_168_678_8, 0.072_192_315_4];
    /// The weights have ten digits.
    const WHITE: f64 = 1.29e-10;
    let mut of_white = Measured::new("luminance of a spectrum", WHITE);
    let mut of_pixel = Measured::rounding("luminance of a pixel");
    let folder = folder();
    let tungsten = SCENE.replace(
        "intensity = 4",
        "intensity = { lumens = 50, color = { illuminant = \"A\" } }",
    );
    fs::write(folder.path().join("tungsten.toml"), tungsten).unwrap();
    for scene in ["ball", "tungsten"] {
        succeeds(
            folder.path(),
            &format!("render {scene}.toml -o {scene}.exr --samples 1"),
        );
        let rendered = image(folder.path(), &format!("{scene}.exr")).pixels;
        for [x, y] in [[0, 0], [30, 20], [25, 33]] {
            let report: Value = serde_json::from_str(&succeeds(
                folder.path(),
                &format!("probe {scene}.toml --pixel {x},{y} --json --spectrum=360:830:1"),
            ))
            .unwrap();
            let spectrum = report["spectrum"]["radiance"].as_array().unwrap();
            assert_eq!(
                report["spectrum"]["wavelengths"].as_array().unwrap().len(),
                471
            );
            let sum: f64 = tables::cie_1931()
                .column("y")
                .iter()
                .zip(spectrum)
                .map(|(y, radiance)| y * radiance.as_f64().unwrap())
                .sum();
            let luminance = |rgb: [f64; 3]| -> f64 {
                rgb.iter()
                    .zip(WEIGHTS)
                    .map(|(channel, weight)| channel * weight)
                    .sum()
            };
            let explained = luminance(triple(&report["radiance"]));
            of_white.see((683.0 * sum / explained - 1.0).abs(), || {
                format!("{scene} {x},{y}")
            });
            // The spectral scene was rendered so as well.
            let [r, g, b, _] = rendered[(y * RESOLUTION[0] + x) as usize].map(f64::from);
            let error = (luminance([r, g, b]) / explained - 1.0).abs();
            if scene == "tungsten" {
                of_pixel.see(error, || format!("{x},{y}"));
            }
        }
    }
    of_white.judge();
    of_pixel.judge();
}

#[test]
fn a_spectrum_that_cannot_be() {
    let folder = folder();
    let rgb = SCENE.replace("[image]", "[image]\ntransport = \"rgb\"");
    fs::write(folder.path().join("rgb.toml"), rgb).unwrap();
    let message = fails(folder.path(), "probe rgb.toml --pixel 0,0 --spectrum", 1);
    assert!(message.contains("`transport = \"rgb\"`"), "{message}");
    for range in [
        "",
        "380:780",
        "780:380:10",
        "300:780:10",
        "380:780:0",
        "a:b:c",
    ] {
        let arguments = format!("probe ball.toml --pixel 0,0 --spectrum={range}");
        let message = fails(folder.path(), &arguments, 2);
        assert!(message.contains("--spectrum"), "{message}");
    }
}

/// Where shadow rays start off the triangle, by how much; else nothing is said of it.
#[test]
fn a_probe_tells_the_lift() {
    let folder = folder();
    for (rule, is_lifted) in [("geometric", false), ("hanika", true)] {
        with_bulge(
            folder.path(),
            "bulge.toml",
            &format!("shadow_terminator = \"{rule}\""),
        );
        for (pixel, object) in [
            ("20,22", "bulge"),
            ("40,22", "bulge"),
            ("41,21", "bulge"),
            ("30,35", "floor"),
        ] {
            let at = format!("probe bulge.toml --pixel {pixel}");
            let report = succeeds(folder.path(), &format!("{at} --json"));
            let report: Value = serde_json::from_str(&report).unwrap();
            let hit = &report["hit"];
            assert_eq!(hit["object"], object, "{pixel}");
            let table = succeeds(folder.path(), &at);
            if is_lifted && object == "bulge" {
                let [_, rise, _] = triple(&hit["lift"]);
                assert!(rise > 0.1, "{report}");
                assert!(table.contains("L4  p′ − p, lift"), "{table}");
                assert!(table.contains("shadow rays start at p′, 0."), "{table}");
            } else {
                assert!(hit["lift"].is_null(), "{report}");
                assert!(!table.contains("lift"), "{table}");
            }
        }
    }
}

/// Several points in one call are what they are one by one; the renderer is asked at centers alone.
#[test]
fn probes_of_several_points() {
    let folder = folder();
    let several = "probe ball.toml --pixel 30,20 --pixel 30.5,20 --pixel 10.25,33.5 --json";
    let reports: Value = serde_json::from_str(&succeeds(folder.path(), several)).unwrap();
    let reports = reports.as_array().unwrap();
    assert_eq!(reports.len(), 3);
    assert_eq!(reports[0], probe(folder.path(), 30, 20));
    assert_eq!(reports[0], reports[1]);
    assert_eq!(reports[2]["pixel"], serde_json::json!([10, 33]));
    assert_eq!(reports[2]["point"], serde_json::json!([10.25, 33.5]));
    assert!(reports[2]["renderer"].is_null());
    assert_eq!(reports[2]["hit"]["object"], "floor");
    // A quarter of a pixel to the left of its center, it is a little different.
    let center = probe(folder.path(), 10, 33);
    assert_ne!(reports[2]["radiance"], center["radiance"]);
    let table = succeeds(
        folder.path(),
        "probe ball.toml --pixel 30,20 --pixel 10.25,33.5",
    );
    assert!(
        table.contains("Pixel (30, 20) of 60 × 40: object `ball`"),
        "{table}"
    );
    assert!(
        table.contains("Point (10.25, 33.5) of 60 × 40 pixels: object `floor`"),
        "{table}"
    );
    assert_eq!(table.matches("renderer − equation").count(), 1, "{table}");
    for point in ["60.0,1", "1,40.0", "59.5,1e9"] {
        let message = fails(
            folder.path(),
            &format!("probe ball.toml --pixel {point}"),
            1,
        );
        assert!(message.contains("is outside of the image"), "{message}");
    }
}

#[test]
fn a_region_is_probed_pixel_by_pixel() {
    let folder = folder();
    let json = succeeds(folder.path(), "probe ball.toml --region 28,18,31,20 --json");
    let reports: Vec<Value> = serde_json::from_str(&json).unwrap();
    let expected: Vec<Value> = (18..20)
        .flat_map(|y| (28..31).map(move |x| [x, y]))
        .map(|[x, y]| probe(folder.path(), x, y))
        .collect();
    assert_eq!(reports, expected);
    let lines = succeeds(folder.path(), "probe ball.toml --region 0,0,60,40");
    assert_eq!(lines.lines().count(), 60 * 40);
    assert!(lines.starts_with("0,0  0.1 0.2 0.4 cd/m², "), "{lines}");
    assert!(lines.contains(": `ball`, lit by `key`, "), "{lines}");
    assert!(
        lines.contains(": `floor`, in the shadow of `key`"),
        "{lines}"
    );
    let message = fails(folder.path(), "probe ball.toml --region 0,0,61,40", 1);
    assert!(
        message.contains("--region 0,0,61,40 is not inside of the image"),
        "{message}"
    );
}
