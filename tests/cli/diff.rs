//! `candela diff`: its figures beside those of other programs, its limits, and what it refuses.

use std::fs;
use std::path::Path;
use std::process::Command;

use candela::exr::{DataWindow, write_planes};
use candela::output::Unfinished;
use serde_json::Value;
use tempfile::TempDir;

use super::{RESOLUTION, fails, files, folder, output, succeeds, text};
use crate::measured::Measured;
use crate::openimageio::{decode, idiff, idiff_agrees, oiiotool};

/// Six digits, of which the last is rounded.
const PRINTED: f64 = 5e-6;

/// The scene with one sample a pixel and with four, with layers.
fn rendered() -> TempDir {
    let folder = folder();
    for (name, samples) in [("a", 1), ("b", 4)] {
        let layers = "--layers lights,depth,normal";
        let arguments = format!("render ball.toml -o {name}.exr --samples {samples} {layers}");
        succeeds(folder.path(), &arguments);
    }
    folder
}

fn json(folder: &Path, arguments: &str) -> Value {
    serde_json::from_str(&succeeds(folder, &format!("diff {arguments} --json"))).unwrap()
}

/// A layer of a report.
#[track_caller]
fn layer<'r>(report: &'r Value, name: &str) -> &'r Value {
    let mut layers = report["layers"].as_array().unwrap().iter();
    layers.find(|layer| layer["name"] == name).unwrap()
}

/// Runs what finds more than its limits allow: what it prints, and its one message.
#[track_caller]
fn is_beyond(folder: &Path, arguments: &str) -> (String, String) {
    let output = output(folder, arguments);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{arguments}\n{message}");
    assert!(message.starts_with("error: "), "{message}");
    assert_eq!(message.lines().count(), 1, "{message}");
    (text(&output.stdout), message)
}

/// Writes channels of 4 × 2 pixels.
fn write(folder: &Path, name: &str, channels: &[(&str, [f32; 8])]) {
    let window = DataWindow {
        resolution: [4, 2],
        corner: [0, 0],
        size: [4, 2],
    };
    let planes: Vec<(&str, &[f32])> = channels
        .iter()
        .map(|(n, values)| (*n, &values[..]))
        .collect();
    write_planes(&folder.join(name), window, &planes, &Unfinished::new()).unwrap();
}

#[test]
fn figures_are_those_of_idiff() {
    let folder = rendered();
    let report = json(folder.path(), "a.exr b.exr");
    let names: Vec<&str> = report["layers"]
        .as_array()
        .unwrap()
        .iter()
        .map(|layer| layer["name"].as_str().unwrap())
        .collect();
    assert_eq!(
        names,
        [
            "RGB",
            "N",
            "Z",
            "light_background",
            "light_fill",
            "light_key"
        ]
    );
    for (name, channels) in [
        ("RGB", "R,G,B,A"),
        ("N", "N.X,N.Y,N.Z"),
        ("Z", "Z"),
        ("light_key", "light_key.R,light_key.G,light_key.B"),
    ] {
        for file in ["a", "b"] {
            let arguments = format!("{file}.exr --ch {channels} -o {file}-layer.exr");
            oiiotool(folder.path(), &arguments);
        }
        let theirs = idiff(folder.path(), "a-layer.exr", "b-layer.exr");
        let ours = layer(&report, name);
        for (key, theirs) in [
            ("max_error", theirs.max),
            ("mean_error", theirs.mean),
            ("rmse", theirs.rms),
            ("psnr", theirs.psnr),
        ] {
            let ours = ours[key].as_f64().unwrap();
            assert!(
                (ours - theirs).abs() <= PRINTED * theirs,
                "{name} {key}: {ours} {theirs}"
            );
        }
        // idiff subtracts in f32, where all depths are the same beside that of the background.
        if name == "Z" {
            continue;
        }
        let at = &ours["max_at"];
        let place = format!("{}, {}, ", at["x"], at["y"]);
        assert!(
            theirs.max_at.starts_with(&place),
            "{name}: {place}, {theirs:?}"
        );
    }
}

/// The picture of the absolute error is that of oiiotool.
#[test]
fn the_difference_is_that_of_oiiotool() {
    let folder = rendered();
    let told = succeeds(folder.path(), "diff a.exr b.exr -o ours.exr -o ours.png");
    assert!(told.ends_with("wrote ours.exr, ours.png\n"), "{told}");
    oiiotool(folder.path(), "a.exr b.exr --absdiff -o theirs.exr");
    let path = |name: &str| folder.path().join(name);
    assert!(idiff_agrees(&path("ours.exr"), &path("theirs.exr")));
    let decoded = decode(&path("ours.exr"));
    assert_eq!(decoded.data_window, [0, 0, 60, 40]);
    assert_eq!(decoded.channels.len(), 17);
    // A crop's difference stands where the crop does.
    for (name, samples) in [("c", 1), ("d", 4)] {
        let arguments =
            format!("render ball.toml -o {name}.exr --samples {samples} --crop 7,5,41,30");
        succeeds(folder.path(), &arguments);
    }
    succeeds(folder.path(), "diff c.exr d.exr -o crop.exr");
    let decoded = decode(&path("crop.exr"));
    assert_eq!(decoded.data_window, [7, 5, 34, 25]);
    assert_eq!(decoded.display_window, [0, 0, 60, 40]);
    // And the places of the largest errors are those in the whole.
    let report = json(folder.path(), "c.exr d.exr");
    let rgb = layer(&report, "RGB");
    assert_eq!(rgb["window"], serde_json::json!([7, 5, 34, 25]));
    let theirs = idiff(folder.path(), "c.exr", "d.exr");
    let place = format!("{}, {}, ", rgb["max_at"]["x"], rgb["max_at"]["y"]);
    assert!(theirs.max_at.starts_with(&place), "{place} {theirs:?}");
}

/// The authors' own program, on the same numbers; its means are summed up here, since it adds in f32.
#[test]
fn flip_is_that_of_its_authors() {
    const SCRIPT: &str = "
import sys, numpy as np, flip_evaluator as flip
r, i = (np.fromfile(name, '<f4').reshape(int(sys.argv[3]), -1, 3) for name in sys.argv[1:3])
for kind, images in (('LDR', (r.clip(0, 1), i.clip(0, 1))), ('HDR', (r, i))):
    errors, _, _ = flip.evaluate(*images, kind, inputsRGB=False, applyMagma=False, computeMeanError=False)
    print(errors.astype(np.float64).mean())
";
    /// Of the mean, absolute: the last bits of powers and roots, in f32.
    const MEANS: f64 = 1e-7;
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/flip-evaluator/bin/python");
    if !python.exists() {
        println!(
            "skipped: {} is missing; ./check installs it",
            python.display()
        );
        return;
    }
    let mut of_means = Measured::new("mean FLIP beside its authors'", MEANS);
    let folder = rendered();
    let report = json(folder.path(), "a.exr b.exr");
    for name in ["RGB", "light_key"] {
        let prefix = if name == "RGB" {
            String::new()
        } else {
            format!("{name}.")
        };
        for file in ["a", "b"] {
            let arguments =
                format!("{file}.exr --ch {prefix}R,{prefix}G,{prefix}B -o {file}-rgb.exr");
            oiiotool(folder.path(), &arguments);
            let values = decode(&folder.path().join(format!("{file}-rgb.exr"))).values;
            let bytes: Vec<u8> = values.into_iter().flat_map(f32::to_le_bytes).collect();
            fs::write(folder.path().join(file), bytes).unwrap();
        }
        let mut command = Command::new(&python);
        command
            .current_dir(folder.path())
            .args(["-c", SCRIPT, "a", "b"]);
        let output = command.arg(RESOLUTION[1].to_string()).output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        let theirs: Vec<f64> = text(&output.stdout)
            .lines()
            .map(|line| line.parse().unwrap())
            .collect();
        for (key, theirs) in ["flip", "hdr_flip"].into_iter().zip(theirs) {
            let ours = layer(&report, name)[key].as_f64().unwrap();
            assert!(theirs > 1e-3, "{name} {key}: {theirs}");
            // As printed, to six decimals.
            assert_eq!(format!("{ours:.6}"), format!("{theirs:.6}"), "{name} {key}");
            of_means.see((ours - theirs).abs(), || format!("{name} {key}"));
        }
    }
    of_means.judge();
}

#[test]
fn the_same_image_is_the_same() {
    let folder = rendered();
    let none = "--max-error 0 --max-relative 0 --max-flips 0 --max-rmse 0 --max-flip 0 --max-hdr-flip 0 --min-psnr 1000";
    let told = succeeds(folder.path(), &format!("diff a.exr a.exr {none} -o a.png"));
    assert_eq!(told.matches("    the same\n").count(), 6, "{told}");
    let mut png = png::Decoder::new(std::io::BufReader::new(
        fs::File::open(folder.path().join("a.png")).unwrap(),
    ))
    .read_info()
    .unwrap();
    let mut samples = vec![0; png.output_buffer_size().unwrap()];
    png.next_frame(&mut samples).unwrap();
    assert!(samples.chunks(3).all(|pixel| pixel == [0, 0, 4]));
    // Compression that loses nothing, and another program between, change nothing.
    oiiotool(
        folder.path(),
        "a.exr --tile 16 16 --compression piz -o tiled.exr",
    );
    succeeds(folder.path(), &format!("diff a.exr tiled.exr {none}"));
}

#[test]
fn limits_decide_the_exit_code() {
    let folder = rendered();
    let report = json(folder.path(), "a.exr b.exr --layers rgb");
    let rgb = layer(&report, "RGB");
    for (option, key) in [
        ("--max-error", "max_error"),
        ("--max-mean", "mean_error"),
        ("--max-rmse", "rmse"),
        ("--max-relative", "relative_max"),
        ("--max-relmse", "relmse"),
        ("--max-flips", "flips"),
        ("--max-flip", "flip"),
        ("--max-hdr-flip", "hdr_flip"),
    ] {
        let found = &rgb[key];
        let within = format!("diff a.exr b.exr --layers rgb {option} {found}");
        succeeds(folder.path(), &within);
        let less = match found.as_u64() {
            Some(count) => (count - 1).to_string(),
            None => (0.999 * found.as_f64().unwrap()).to_string(),
        };
        let beyond = format!("diff a.exr b.exr --layers rgb {option} {less}");
        let (report, message) = is_beyond(folder.path(), &beyond);
        assert!(report.contains("RMSE"), "{report}");
        assert!(
            message.contains("above the limit in layer RGB: "),
            "{message}"
        );
        assert!(message.contains(option), "{message}");
    }
    is_beyond(folder.path(), "diff a.exr b.exr --min-psnr 100");
    let (report, _) = is_beyond(
        folder.path(),
        "diff a.exr b.exr --json --max-error 1e-3 --max-flips 0",
    );
    let report: Value = serde_json::from_str(&report).unwrap();
    let beyond = report["beyond"].as_array().unwrap();
    assert!(beyond.len() > 4, "{report}");
    assert_eq!(beyond[0]["option"], "--max-error");
    assert_eq!(beyond[0]["layer"], "RGB");
    // A larger tolerance, fewer flips.
    let flips = |tolerance: &str| {
        let report = json(
            folder.path(),
            &format!("a.exr b.exr --layers rgb --tolerance {tolerance}"),
        );
        layer(&report, "RGB")["flips"].as_u64().unwrap()
    };
    assert!(flips("0") > flips("0.01") && flips("0.01") > flips("1") && flips("1e9") == 0);
}

#[test]
fn what_is_not_finite_is_counted_and_is_within_no_limit() {
    let folder = tempfile::tempdir().unwrap();
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let good = [1.0_f32; 8];
    let bad = [1.0, nan, 1.0, inf, 1.0, 1.0, 1.0, 1.0];
    let rgb = |r| [("R", r), ("G", good), ("B", good)];
    write(folder.path(), "good.exr", &rgb(good));
    write(folder.path(), "bad.exr", &rgb(bad));
    let report = json(folder.path(), "good.exr bad.exr");
    let found = layer(&report, "RGB");
    assert_eq!(found["not_finite_in_reference"], 0);
    assert_eq!(found["not_finite_in_image"], 2);
    assert!(found["max_error"].is_null(), "infinite: {found}");
    assert_eq!([&found["rmse"], &found["mean_error"]], [0.0, 0.0]);
    assert_eq!(found["flips"], 2);
    let told = succeeds(folder.path(), "diff good.exr bad.exr");
    assert!(told.contains("0 values of A, 2 of B"), "{told}");
    for limit in ["--max-rmse 1", "--max-flip 1", "--max-mean 5"] {
        let (_, message) = is_beyond(folder.path(), &format!("diff good.exr bad.exr {limit}"));
        assert!(message.contains("NaN or infinite"), "{message}");
    }
    // Where both are so, it is no difference.
    succeeds(folder.path(), "diff bad.exr bad.exr --max-error 0");
}

/// Closed forms: one value of eight is off.
#[test]
fn closed_forms() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "a.exr", &[("Z", [2.0; 8])]);
    write(
        folder.path(),
        "b.exr",
        &[("Z", [2.0, 2.0, 2.0, 2.0, 2.0, 2.5, 2.0, 2.0])],
    );
    let report = json(folder.path(), "a.exr b.exr");
    let found = layer(&report, "Z");
    let number = |key: &str| found[key].as_f64().unwrap();
    assert_eq!(number("max_error"), 0.5);
    assert_eq!(found["max_at"], serde_json::json!({"x": 1, "y": 1}));
    assert_eq!(number("mean_error"), 0.5 / 8.0);
    assert_eq!(number("rmse"), (0.25_f64 / 8.0).sqrt());
    assert_eq!(number("relative_max"), 0.25);
    assert_eq!(number("median"), 2.0);
    assert_eq!(number("relmse"), 0.25 / 4.04 / 8.0);
    assert!(found["flip"].is_null());
}

#[test]
fn what_cannot_be_compared() {
    let folder = rendered();
    succeeds(folder.path(), "render ball.toml -o plain.exr --samples 1");
    succeeds(
        folder.path(),
        "render ball.toml -o crop.exr --samples 1 --crop 0,0,30,20",
    );
    let small = super::SCENE.replace("[60, 40]", "[30, 20]");
    fs::write(folder.path().join("small.toml"), small).unwrap();
    succeeds(folder.path(), "render small.toml -o small.exr --samples 1");
    let wide = super::SCENE.replace("[image]", "[image]\ncolor_space = \"acescg\"");
    fs::write(folder.path().join("wide.toml"), wide).unwrap();
    succeeds(folder.path(), "render wide.toml -o wide.exr --samples 1");
    fs::write(folder.path().join("text.exr"), "no EXR").unwrap();
    let before = files(folder.path());
    for (arguments, part) in [
        ("absent.exr a.exr", "cannot read absent.exr"),
        ("a.exr text.exr", "text.exr: it is not an OpenEXR file"),
        (
            "plain.exr crop.exr",
            "60 × 40 pixels and 30 × 20 pixels at 0,0 of 60 × 40",
        ),
        (
            "plain.exr small.exr",
            "different sizes: 60 × 40 pixels and 30 × 20 pixels",
        ),
        ("plain.exr wide.exr", "are of different spaces"),
        (
            "a.exr plain.exr",
            "only a.exr has the layers N, Z, light_background, light_fill, light_key; choose among what both have with --layers RGB",
        ),
        ("plain.exr a.exr", "only a.exr has the layers"),
        (
            "a.exr plain.exr --layers Z",
            "plain.exr has no layer `Z`; it has RGB",
        ),
        (
            "a.exr b.exr --layers Z --max-flip 1",
            "--max-flip is for colors",
        ),
        ("a.exr b.exr -o a.exr", "give another name"),
        ("a.exr b.exr -o absent/d.exr", "absent/d.exr"),
        ("- -", "both images would come from standard input"),
    ] {
        let message = fails(folder.path(), &format!("diff {arguments}"), 1);
        assert!(message.contains(part), "{arguments}: {message}");
    }
    assert_eq!(files(folder.path()), before);
    succeeds(
        folder.path(),
        "diff a.exr plain.exr --layers RGB --max-error 0",
    );
    // Without alpha, the colors can still be compared, if that is asked for.
    oiiotool(folder.path(), "plain.exr --ch R,G,B -o opaque.exr");
    let message = fails(folder.path(), "diff plain.exr opaque.exr", 1);
    assert!(
        message.contains("only plain.exr has the channel `A`"),
        "{message}"
    );
    let told = succeeds(
        folder.path(),
        "diff plain.exr opaque.exr --layers RGB --max-error 0",
    );
    assert!(
        told.contains("left out: only plain.exr has the channel `A`"),
        "{told}"
    );
}

/// Damaged files are one error each, wherever they end.
#[test]
fn files_that_end_early() {
    let folder = rendered();
    let whole = fs::read(folder.path().join("a.exr")).unwrap();
    for part in 1..20 {
        fs::write(
            folder.path().join("part.exr"),
            &whole[..whole.len() * part / 20],
        )
        .unwrap();
        let message = fails(folder.path(), "diff a.exr part.exr", 1);
        assert!(message.contains("cannot read part.exr"), "{message}");
    }
}

/// Files of other programs: parts, halves, luminance with chroma of fewer samples.
#[test]
fn files_of_other_programs() {
    let folder = rendered();
    oiiotool(folder.path(), "a.exr -d half -o half.exr");
    let report = json(folder.path(), "a.exr half.exr --layers RGB");
    let relative = layer(&report, "RGB")["relative_max"].as_f64().unwrap();
    // Half of the last of 11 bits.
    assert!(relative > 1e-4 && relative <= 1.0 / 2048.0, "{relative}");
    for file in ["a", "b"] {
        let parts = format!(
            "{file}.exr --ch R,G,B,A --attrib oiio:subimagename beauty {file}.exr --ch Z --attrib \
             oiio:subimagename depth --siappend -o {file}-parts.exr"
        );
        oiiotool(folder.path(), &parts);
    }
    let one = json(folder.path(), "a.exr b.exr --layers RGB,Z");
    let many = json(folder.path(), "a-parts.exr b-parts.exr");
    assert_eq!(one["layers"], many["layers"]);
}

#[test]
fn wrong_usage() {
    let folder = folder();
    for arguments in [
        "a.exr",
        "a.exr b.exr c.exr",
        "a.exr b.exr -o difference",
        "a.exr b.exr -o difference.jpg",
        "a.exr b.exr --max-error -1",
        "a.exr b.exr --max-error nan",
        "a.exr b.exr --max-flips 0.5",
        "a.exr b.exr --tolerance inf",
    ] {
        fails(folder.path(), &format!("diff {arguments}"), 2);
    }
}
