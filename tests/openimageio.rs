//! OpenImageIO's tools as judges, and images as they see them.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A tool of the environment that `tests/setup.sh` makes.
fn tool(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("target/openimageio/bin")
        .join(name);
    assert!(
        path.exists(),
        "{} is missing; run ./check, which installs it",
        path.display()
    );
    path
}

fn run(command: &mut Command) -> Output {
    let output = command.output().unwrap();
    assert!(
        output.status.success(),
        "{command:?}\n{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    output
}

/// Runs oiiotool in `folder` with arguments split at spaces; what it prints.
pub(crate) fn oiiotool(folder: &Path, arguments: &str) -> String {
    let mut command = Command::new(tool("oiiotool"));
    command
        .current_dir(folder)
        .args(arguments.split_whitespace());
    String::from_utf8(run(&mut command).stdout).unwrap()
}

/// What idiff measures.
#[derive(Debug)]
pub(crate) struct Differences {
    /// Mean, root mean square and largest error, and the peak signal-to-noise ratio in dB.
    pub(crate) mean: f64,
    pub(crate) rms: f64,
    pub(crate) psnr: f64,
    pub(crate) max: f64,
    /// Column, row and channel of the largest.
    pub(crate) max_at: String,
}

/// The figures of `idiff -a` for two images.
pub(crate) fn idiff(folder: &Path, a: &str, b: &str) -> Differences {
    let mut command = Command::new(tool("idiff"));
    // It fails where images differ, which is none here.
    let output = command
        .current_dir(folder)
        .args(["-a", a, b])
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let value = |name: &str| {
        let line = text
            .lines()
            .find(|line| line.trim_start().starts_with(name));
        let line = line.unwrap_or_else(|| panic!("no {name} in {text}"));
        line.split_once(" = ").unwrap().1
    };
    let number = |name: &str| value(name).split(' ').next().unwrap().parse().unwrap();
    let max = value("Max error");
    Differences {
        mean: number("Mean error"),
        rms: number("RMS error"),
        psnr: number("Peak SNR"),
        max: number("Max error"),
        max_at: max.split(['(', ')']).nth(1).unwrap_or_default().to_owned(),
    }
}

/// Whether idiff finds no difference above its defaults between two images.
pub(crate) fn idiff_agrees(a: &Path, b: &Path) -> bool {
    let mut command = Command::new(tool("idiff"));
    command.arg(a).arg(b).output().unwrap().status.success()
}

/// Whether idiff finds at most `count` pixels of two images further apart than
/// `relative` of their mean.
pub(crate) fn idiff_agrees_within(a: &Path, b: &Path, relative: f64, count: usize) -> bool {
    let (relative, count) = (relative.to_string(), count.to_string());
    let mut command = Command::new(tool("idiff"));
    command
        // Relative alone, without absolute tolerance.
        .args(["-fail", "0", "-failrelative", &relative])
        .args(["-allowfailures", &count, "-warn", "inf"])
        .arg(a)
        .arg(b);
    command.output().unwrap().status.success()
}

/// The first part of an image as OpenImageIO decodes it.
#[derive(Debug)]
pub(crate) struct Decoded {
    /// The names of the channels, in OpenImageIO's order.
    pub(crate) channels: Vec<String>,
    /// x, y, width and height of the data window.
    pub(crate) data_window: [i32; 4],
    /// x, y, width and height of the display window.
    pub(crate) display_window: [i32; 4],
    /// Every channel of every pixel of the data window.
    pub(crate) values: Vec<f32>,
}

impl Decoded {
    /// Channels of a pixel by column and row of the data window.
    pub(crate) fn pixel(&self, x: usize, y: usize) -> &[f32] {
        let width = self.data_window[2] as usize;
        &self.values[(y * width + x) * self.channels.len()..][..self.channels.len()]
    }
}

/// Decodes an image by OpenImageIO, bit for bit.
pub(crate) fn decode(path: &Path) -> Decoded {
    const SCRIPT: &str = "
import sys, OpenImageIO as oiio
image = oiio.ImageBuf(sys.argv[1])
spec = image.spec()
print(' '.join(spec.channelnames))
print(spec.x, spec.y, spec.width, spec.height)
print(spec.full_x, spec.full_y, spec.full_width, spec.full_height, flush=True)
sys.stdout.buffer.write(image.get_pixels(oiio.FLOAT).astype('<f4').tobytes())
";
    let mut command = Command::new(tool("python"));
    let output = run(command.arg("-c").arg(SCRIPT).arg(path)).stdout;
    let mut parts = output.splitn(4, |&byte| byte == b'\n');
    let mut line = || std::str::from_utf8(parts.next().unwrap()).unwrap();
    let window = |line: &str| -> [i32; 4] {
        let numbers: Vec<i32> = line.split(' ').map(|n| n.parse().unwrap()).collect();
        numbers.try_into().unwrap()
    };
    let channels = line().split(' ').map(str::to_string).collect();
    let data_window = window(line());
    let display_window = window(line());
    let (values, rest) = parts.next().unwrap().as_chunks::<4>();
    assert!(rest.is_empty());
    Decoded {
        channels,
        data_window,
        display_window,
        values: values.iter().map(|&b| f32::from_le_bytes(b)).collect(),
    }
}
