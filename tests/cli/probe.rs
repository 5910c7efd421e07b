//! `candela probe`: its numbers beside those of the image.

use std::path::Path;

use serde_json::Value;

use super::{RESOLUTION, fails, folder, image, succeeds};

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
    /// As between renderer and oracle in every test of theirs.
    const TOLERANCE: f64 = 1e-5;
    let folder = folder();
    succeeds(folder.path(), "render ball.toml");
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
        assert!((length(way) - hit["distance"].as_f64().unwrap()).abs() < 1e-12);
        assert!((length(n) - 1.0).abs() < 1e-12);
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
                assert!((incident[channel] - expected).abs() < 1e-12 * expected);
                let lambert = [0.7, 0.3, 0.2][channel] * cosine;
                assert!((diffuse[channel] - lambert).abs() <= 1e-12);
                let reflectance = diffuse[channel] + specular[channel];
                let expected = if visible {
                    incident[channel] * reflectance
                } else {
                    0.0
                };
                assert!((share[channel] - expected).abs() <= 1e-12 * expected);
                sum[channel] += share[channel];
            }
        }
        for (sum, radiance) in sum.iter().zip(radiance) {
            assert!((sum - radiance).abs() <= 1e-12 * radiance, "{report}");
        }
        // The table for reading names the same.
        let table = succeeds(folder.path(), &format!("probe ball.toml --pixel {x},{y}"));
        for name in [objects.last().unwrap().as_str(), "clay", "key", "fill"] {
            assert!(table.contains(name), "{table}");
        }
    }
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
