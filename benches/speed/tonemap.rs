//! `candela tonemap` on a picture of 3840 × 2160 pixels, beside OpenColorIO's own programs on the same file.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use candela::display::{self, Alpha, Picture, Settings, View};
use candela::exr::{ExrOptions, ExrReader, read};
use candela::output::Unfinished;
use candela::scene::{Image, Scene};
use candela::world::World;
use candela::{Options, render};

use super::Result;
use super::compare::{Spread, timed};

const RESOLUTION: [u32; 2] = [3840, 2160];

/// What OpenColorIO calls candela's views, on a screen for sRGB.
const PEERS: [(View, &str); 2] = [
    (View::Srgb, "Un-tone-mapped"),
    (View::Aces2, "ACES 2.0 - SDR 100 nits (Rec.709)"),
];

const CONFIG: &str = "ocio://studio-config-v4.0.0_aces-v2.0_ocio-v2.5";

/// As pyociodisplay does it, with OpenImageIO's threads for files and its own for colors.
const PYTHON: &str = r#"
import sys
import numpy as np, OpenImageIO as oiio, PyOpenColorIO as ocio
source, target, view = sys.argv[1:]
image = oiio.ImageBuf(source)
pixels = np.ascontiguousarray(image.get_pixels(oiio.FLOAT)[..., :3])
config = ocio.Config.CreateFromBuiltinConfig("studio-config-v4.0.0_aces-v2.0_ocio-v2.5")
display = ocio.DisplayViewTransform(src="Linear Rec.709 (sRGB)", display="sRGB - Display", view=view)
config.getProcessor(display).getDefaultCPUProcessor().applyRGB(pixels)
height, width, _ = pixels.shape
out = oiio.ImageBuf(oiio.ImageSpec(width, height, 3, oiio.UINT8))
out.set_pixels(oiio.ROI(0, width, 0, height), pixels)
out.write(target)
"#;

/// A table for each view; each time is the median of `runs`.
pub(crate) fn measure(folder: &Path, runs: u32) -> Result<String> {
    let exr = folder.join("tonemap.exr");
    let mut scene = Scene::builtin();
    scene.image = Image {
        resolution: RESOLUTION.into(),
        ..scene.image
    };
    let (world, camera) = World::new(&scene)?;
    let options = Options {
        samples: 1,
        ..Options::default()
    };
    let unfinished = Unfinished::new();
    render(&world, &camera, &options)?.write_exr(&exr, &ExrOptions::default(), &unfinished)?;

    let mut text = String::from(
        "The lecture's scene, 3840 × 2160, FLOAT, ZIP, to a PNG of 8 bits; milliseconds. Read, transform and write are by \
         themselves, one after the other; whole is `candela tonemap`, in which they overlap.\n\n\
         | view | read | transform | write | whole | oiiotool | Python |\n| --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for view in View::ALL {
        let png = folder.join("tonemap.png");
        let settings = Settings {
            view,
            alpha: Alpha::Opaque,
            ..Settings::default()
        };
        let peer = PEERS.iter().find(|(known, _)| *known == view);
        let mut times: [Vec<f64>; 6] = Default::default();
        for _ in 0..runs {
            let (pixels, seconds) = timed(|| -> Result<_> {
                let reader = ExrReader::open(&exr, None)?;
                reader.bands().try_for_each(|band| {
                    let rows = reader.new_rows(band)?;
                    std::hint::black_box(rows);
                    Ok(())
                })
            });
            pixels?;
            times[0].push(seconds);
            let picture = Picture::new(read(&exr)?);
            let (image, seconds) = timed(|| display::tonemap(&picture, &settings));
            times[1].push(seconds);
            let (written, seconds) = timed(|| image.write_png(&png, &unfinished));
            written?;
            times[2].push(seconds);
            let mut own = Command::new(env!("CARGO_BIN_EXE_candela"));
            own.arg("tonemap").arg(&exr).arg("-o").arg(&png);
            own.args(["--view", view.name(), "--alpha", "opaque"]);
            times[3].extend(run(&mut own)?);
            if let Some((_, name)) = peer {
                let out = folder.join("peer.png");
                let mut tool = Command::new(installed("oiiotool"));
                tool.env("OCIO", CONFIG).arg(&exr);
                tool.args(["--iscolorspace", "Linear Rec.709 (sRGB)", "--ociodisplay"]);
                tool.args(["sRGB - Display", name, "--ch", "R,G,B", "-d", "uint8", "-o"]);
                times[4].extend(run(tool.arg(&out))?);
                let mut python = Command::new(installed("python"));
                python.args(["-c", PYTHON]).arg(&exr).arg(&out).arg(name);
                times[5].extend(run(&mut python)?);
            }
        }
        let own = Spread::of(times[3].clone()).median;
        write!(text, "| `{}` |", view.name())?;
        for (place, times) in times.into_iter().enumerate() {
            if times.is_empty() {
                text += " |";
                continue;
            }
            let median = Spread::of(times).median;
            let ratio = if place > 3 {
                format!(", {:.1} ×", median / own)
            } else {
                String::new()
            };
            write!(text, " {:.0}{ratio} |", median * 1e3)?;
        }
        text += "\n";
    }
    Ok(text)
}

/// A program as `tests/setup.sh` installs it, with OpenColorIO.
fn installed(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR"))
        .with_file_name("opencolorio/bin")
        .join(name)
}

/// The seconds that a process takes, unless there is no such program.
fn run(command: &mut Command) -> Result<Option<f64>> {
    let command = command.stdin(Stdio::null()).stderr(Stdio::null());
    let (status, seconds) = timed(|| command.status());
    match status {
        Ok(status) if status.success() => Ok(Some(seconds)),
        Ok(status) => Err(format!("{}: {status}", command.get_program().display()).into()),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error.into()),
    }
}
