//! The programs in `examples/`, run as they are, and what they write.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::measured::Measured;

#[path = "../examples/layers_to_numpy.rs"]
#[expect(dead_code, reason = "its `main` is for the command line")]
mod layers_to_numpy;
#[path = "../examples/oracle_at_a_pixel.rs"]
#[expect(dead_code, reason = "its `main` is for the command line")]
mod oracle_at_a_pixel;
#[path = "../examples/render_to_memory.rs"]
#[expect(dead_code, reason = "its `main` is for the command line")]
mod render_to_memory;
#[path = "../examples/scene_in_code.rs"]
#[expect(dead_code, reason = "its `main` is for the command line")]
mod scene_in_code;

/// Two lights over a floor, which fills the picture but for its upper half.
const SCENE: &str = r#"
[image]
resolution = [12, 8]

[camera.perspective]
eye = [0, 1, 0]
look_at = [0, 1, -1]
vertical_fov = 60

[materials.chalk.phong]
diffuse = 0.5

[lights.key.point]
position = [1, 3, -4]
intensity = [30, 20, 10]

[lights.fill.point]
position = [-2, 1, -2]
intensity = 2

[objects.floor.plane]
material = "chalk"
point = [0, 0, 0]
normal = [0, 1, 0]
"#;

#[test]
fn a_scene_made_in_code_becomes_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let png = scene_in_code::run(folder.path(), 45).unwrap();
    assert_eq!(png, folder.path().join("steps.png"));
    let decoder = png::Decoder::new(std::io::BufReader::new(fs::File::open(&png).unwrap()));
    let info = decoder.read_info().unwrap();
    assert_eq!(info.info().size(), (80, 45));
    assert!(folder.path().join("steps.exr").exists());
}

#[test]
fn a_picture_in_memory_is_summed_up() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    fs::write(&scene, SCENE).unwrap();
    let summary = render_to_memory::summarize(&scene, 1).unwrap();
    assert_eq!(summary.resolution, [12, 8]);
    // The floor is what is below the horizon, which is between the fourth row and the fifth.
    assert!((summary.coverage - 0.5).abs() < f64::EPSILON);
    let ([_, y], [r, g, b]) = summary.brightest;
    assert!(y >= 4 && r > g && g > b, "{summary:?}");
    assert!(summary.mean[0] > summary.mean[2] && summary.mean[2] > 0.0);
}

/// NumPy's verdict on the arrays: shapes, types, and that the layers are what they should be.
#[test]
fn numpy_reads_the_layers() {
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/colour-science/bin/python");
    assert!(
        python.exists(),
        "{} is missing; run ./check, which installs it",
        python.display()
    );
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    fs::write(&scene, SCENE).unwrap();
    let files = layers_to_numpy::run(&scene, folder.path()).unwrap();
    let names: Vec<_> = files
        .iter()
        .map(|file| file.file_stem().unwrap().to_str().unwrap())
        .collect();
    assert_eq!(names, ["rgba", "light_key", "light_fill", "N", "Z"]);
    let script = "\
import numpy as np
rgba, key, fill, z, n = (np.load(f'{name}.npy') for name in ('rgba', 'light_key', 'light_fill', 'Z', 'N'))
assert rgba.shape == (8, 12, 4) and rgba.dtype == np.float32, (rgba.shape, rgba.dtype)
assert key.shape == fill.shape == n.shape == (8, 12, 3)
assert z.shape == (8, 12)
np.testing.assert_allclose(key + fill, rgba[..., :3], rtol=1.2e-7)
assert (rgba[:4] == 0).all() and (rgba[4:, :, 3] == 1).all()
np.testing.assert_allclose(n[4:], np.broadcast_to([0.0, 1.0, 0.0], (4, 12, 3)), atol=1.2e-7)
# The lowest row looks down by 60°/8 · 7/2 as the tangent has it: z = 1 / (tan 30° · 7/8).
np.testing.assert_allclose(z[7], 1 / (np.tan(np.radians(30)) * 7 / 8), rtol=1.2e-7)
np.testing.assert_allclose(key[..., 0], 3 * key[..., 2], rtol=1.2e-7)
";
    let output = Command::new(python)
        .args(["-c", script])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn the_oracle_agrees_at_a_pixel() {
    // The film keeps 32 bits.
    let mut worst = Measured::rounding("the oracle at a pixel");
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    fs::write(&scene, SCENE).unwrap();
    for pixel in [[0, 7], [6, 5], [11, 6], [3, 0]] {
        let (oracle, renderer) = oracle_at_a_pixel::both(&scene, pixel).unwrap();
        for (expected, found) in oracle.radiance.into_iter().zip(renderer) {
            let error = (f64::from(found) - expected).abs();
            worst.see(error / expected.max(f64::MIN_POSITIVE), || {
                format!("{pixel:?}")
            });
        }
    }
    worst.judge();
    assert!(oracle_at_a_pixel::both(&scene, [12, 0]).is_err());
}
