//! What `render` says: the files that it wrote, and why a picture may not be what was meant.

use std::fs;
use std::path::Path;

use candela::exr::read;

use tempfile::TempDir;

use super::{RESOLUTION, SCENE, candela, fails, files, json, succeeds, text, without_texts};

/// The ball on its floor, with nothing to be warned of.
fn scene() -> String {
    SCENE.replace("[0.7, 0.3, 0.2]", "[0.2, 0.09, 0.06]")
}

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("ball.toml"), scene()).unwrap();
    folder
}

/// What a render that works says, line by line.
fn said(folder: &Path, arguments: &str) -> Vec<String> {
    let output = candela(folder, arguments).output().unwrap();
    let stderr = text(&output.stderr);
    assert!(output.status.success(), "candela {arguments}\n{stderr}");
    assert_eq!(text(&output.stdout), "");
    stderr.lines().map(str::to_owned).collect()
}

/// Its warnings alone.
fn warnings(folder: &Path, arguments: &str) -> Vec<String> {
    let lines = said(folder, arguments).into_iter();
    lines
        .filter_map(|line| line.strip_prefix("warning: ").map(str::to_owned))
        .collect()
}

/// Writes the scene with some of its text replaced.
fn write(folder: &Path, name: &str, changes: &[(&str, &str)]) {
    let mut scene = scene();
    for (from, to) in changes {
        assert!(scene.contains(from), "{from}");
        scene = scene.replace(from, to);
    }
    fs::write(folder.join(name), scene).unwrap();
}

/// Both lights so strong.
fn lights(folder: &Path, name: &str, key: &str, fill: &str) {
    let key = format!("intensity = {key}");
    let fill = format!("intensity = {fill}");
    let changes = [
        ("intensity = [30, 30, 30]", &*key),
        ("intensity = 4", &fill),
    ];
    write(folder, name, &changes);
}

fn width_and_height(png: &Path) -> [u32; 2] {
    let bytes = fs::read(png).unwrap();
    [16, 20].map(|at| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()))
}

#[test]
fn every_file_is_named() {
    let folder = folder();
    let folder = folder.path();
    let lines = said(
        folder,
        "render ball.toml -o a.exr --preview b.png --stats c.json",
    );
    let [exr, png, json] = &lines[..] else {
        panic!("{lines:?}");
    };
    assert!(
        exr.starts_with("a.exr: 60 × 40, 16 samples a pixel, rendered in "),
        "{exr}"
    );
    assert_eq!(png, "b.png: its preview");
    assert_eq!(json, "c.json: counts and times");
    let lines = said(folder, "render ball.toml --samples 1");
    assert!(lines[0].starts_with("ball.exr: 60 × 40, 1 sample a pixel, "));
    // An exposure that is chosen is said, so that it can be repeated.
    let lines = said(folder, "render ball.toml --preview b.png --auto-exposure");
    let ev = lines[1]
        .strip_prefix("b.png: its preview, exposure ")
        .unwrap();
    let ev: f64 = ev.strip_suffix(" EV").unwrap().parse().unwrap();
    assert!(ev.abs() < 10.0);
}

#[test]
fn sixteen_samples_are_the_default() {
    let folder = folder();
    let folder = folder.path();
    succeeds(folder, "render ball.toml -o default.exr");
    succeeds(folder, "render ball.toml -o sixteen.exr --samples 16");
    let bytes = |name: &str| fs::read(folder.join(name)).unwrap();
    assert!(bytes("default.exr") == bytes("sixteen.exr"));
}

#[test]
fn a_part_and_its_preview_have_the_size_of_the_part() {
    let folder = folder();
    let folder = folder.path();
    let lines = said(
        folder,
        "render ball.toml -o part.exr --preview part.png --crop 10,5,40,25",
    );
    assert!(lines[0].starts_with("part.exr: 30 × 20 of 60 × 40, 16 samples"));
    assert_eq!(width_and_height(&folder.join("part.png")), [30, 20]);
    // The EXR knows its place, and shows the whole.
    assert_eq!(
        read(&folder.join("part.exr")).unwrap().resolution,
        RESOLUTION
    );
    succeeds(folder, "tonemap part.exr -o whole.png");
    assert_eq!(width_and_height(&folder.join("whole.png")), RESOLUTION);

    // The part looks as it does in the whole, to the code, dithered or not.
    let decoded = |name: &str| {
        let file = std::io::BufReader::new(fs::File::open(folder.join(name)).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        (bytes, info.width as usize, info.color_type.samples())
    };
    for dither in ["", "--dither none"] {
        let options = format!("--exposure 0.5 {dither}");
        succeeds(
            folder,
            &format!("render ball.toml --preview all.png {options}"),
        );
        let crop = format!("render ball.toml --preview part.png --crop 10,5,40,25 {options}");
        succeeds(folder, &crop);
        let (all, width, samples) = decoded("all.png");
        let (part, _, part_samples) = decoded("part.png");
        assert_eq!(samples, part_samples);
        for (y, row) in part.chunks(30 * samples).enumerate() {
            let start = ((y + 5) * width + 10) * samples;
            assert!(row == &all[start..][..30 * samples], "row {y}, {options}");
        }
    }
}

/// However large the whole is, of which nothing else is made.
#[test]
fn a_part_of_a_huge_image_has_a_preview() {
    let folder = folder();
    let folder = folder.path();
    write(folder, "huge.toml", &[("[60, 40]", "[65536, 65536]")]);
    succeeds(
        folder,
        "render huge.toml -o part.exr --preview part.png --crop 32000,40000,32004,40003",
    );
    assert_eq!(width_and_height(&folder.join("part.png")), [4, 3]);
    // As a whole it is more than the data in it makes plausible.
    let message = fails(folder, "tonemap part.exr -o whole.png", 1);
    assert!(
        message.contains("65536 × 65536 pixels are too many"),
        "{message}"
    );
}

#[test]
fn a_preview_is_developed_as_tonemap_does() {
    let folder = folder();
    let folder = folder.path();
    for options in [
        "--exposure -1.5",
        "--auto-exposure",
        "--view reinhard --exposure 2",
        "--dither none",
    ] {
        let render = format!("render ball.toml --preview preview.png {options}");
        succeeds(folder, &render);
        succeeds(
            folder,
            &format!("tonemap ball.exr -o tonemapped.png {options}"),
        );
        let chunks = |name: &str| without_texts(&folder.join(name));
        assert!(
            chunks("preview.png") == chunks("tonemapped.png"),
            "{options}"
        );
    }
    // It is not read back from the file, but is what the file shows: rounded to halves, with what a lossy
    // compression has made of it, amid layers.
    for storing in [
        "--half",
        "--compression dwaa",
        "--half --compression dwab --layers lights,depth,normal",
        "--compression pxr24 --chromaticities",
    ] {
        let render = format!("render ball.toml --preview preview.png --auto-exposure {storing}");
        succeeds(folder, &render);
        let tonemap = "tonemap ball.exr -o tonemapped.png --auto-exposure";
        succeeds(folder, tonemap);
        let chunks = |name: &str| without_texts(&folder.join(name));
        assert!(
            chunks("preview.png") == chunks("tonemapped.png"),
            "{storing}"
        );
    }
    // Without a preview there is nothing to develop.
    for options in [
        "--exposure 1",
        "--exposure 0",
        "--auto-exposure",
        "--view srgb",
        "--dither none",
    ] {
        let message = fails(
            folder,
            &format!("render ball.toml -o none.exr {options}"),
            2,
        );
        assert!(message.contains("--preview <OUT.png>"), "{message}");
    }
    assert!(!files(folder).contains(&"none.exr".to_owned()));
}

#[test]
fn nothing_in_view_is_said() {
    let folder = folder();
    let folder = folder.path();
    let away = ("look_at = [0.0, 0.6, 0.0]", "look_at = [0.0, 5.0, 5.0]");
    write(folder, "away.toml", &[away]);
    for options in ["", "--layers lights,depth", "--samples 1"] {
        let warnings = warnings(folder, &format!("render away.toml {options}"));
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert!(
            warnings[0].starts_with("nothing is in view: no camera ray hits an object; "),
            "{warnings:?}"
        );
    }
    // The background is all that this part has; elsewhere there is a ball.
    let warnings = warnings(folder, "render ball.toml --crop 0,0,10,5");
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("in this part of the image"));
    assert_eq!(self::warnings(folder, "render ball.toml"), [""; 0]);
}

#[test]
fn lights_that_reach_nothing_are_said() {
    let folder = folder();
    let folder = folder.path();
    let key = "position = [3, 4, 3]";
    let fill = "position = [-3, 2, 1]";
    let below = [
        (key, "position = [3, -4, 3]"),
        (fill, "position = [-3, -2, 1]"),
    ];
    write(folder, "below.toml", &below);
    // One is below the floor, one is behind a wall that it does not light on the side that is seen.
    let wall =
        "\n[objects.wall.plane]\nmaterial = \"clay\"\npoint = [0, 0, 6]\nnormal = [0, 0, 1]\n";
    let hidden = scene()
        .replace(key, "position = [3, 4, 7]")
        .replace(fill, "position = [-3, -2, 1]");
    fs::write(folder.join("hidden.toml"), hidden + wall).unwrap();
    for scene in ["below", "hidden"] {
        for options in ["", "--layers lights", "--crop 20,20,40,40"] {
            let arguments = format!("render {scene}.toml {options} --stats s.json");
            let warnings = warnings(folder, &arguments);
            assert_eq!(warnings.len(), 1, "{scene}: {warnings:?}");
            let start = "every light is hidden or below the surface";
            assert!(warnings[0].starts_with(start), "{warnings:?}");
            let middle = if options.starts_with("--crop") {
                "30,30"
            } else {
                "30,20"
            };
            let probe = format!("candela probe {scene}.toml --pixel {middle}");
            assert!(warnings[0].contains(&probe), "{warnings:?}");
            let stats = json(folder, "s.json");
            assert_eq!(stats["lit"], 0);
            assert!(stats["hits"].as_u64().unwrap() > 0);
        }
    }
    // No light at all is what `check` says, and said once.
    let scene = scene();
    let (before, lights) = scene.split_once("[lights").unwrap();
    let (_, objects) = lights.split_once("[objects").unwrap();
    let dark = format!("{before}[objects{objects}");
    fs::write(folder.join("dark.toml"), dark).unwrap();
    let warnings = warnings(folder, "render dark.toml");
    let expected = "the scene has no light, so every surface is black";
    assert_eq!(warnings, [expected]);
}

#[test]
fn a_picture_that_looks_black_is_said() {
    let folder = folder();
    let folder = folder.path();
    lights(folder, "dim.toml", "0.1", "0.01");
    let dim = fs::read_to_string(folder.join("dim.toml")).unwrap();
    fs::write(
        folder.join("dim.toml"),
        dim.replace("background = [0.1, 0.2, 0.4]", ""),
    )
    .unwrap();
    let warnings = |options: &str| warnings(folder, &format!("render dim.toml {options}"));
    let said = warnings("--samples 1");
    assert_eq!(said.len(), 1, "{said:?}");
    // The largest of R, G, B of all pixels, as the file has it.
    let image = read(&folder.join("dim.exr")).unwrap();
    let channels = image.pixels.iter().flat_map(|pixel| &pixel[..3]);
    let largest = channels.copied().fold(0.0, f32::max);
    assert!((1e-4..1e-2).contains(&largest));
    let start = "the brightest pixel has ";
    let number = said[0].strip_prefix(start).unwrap();
    let number: f32 = number.split(' ').next().unwrap().parse().unwrap();
    assert!((number / largest - 1.0).abs() < 0.06, "{number} {largest}");
    assert!(
        said[0].contains("try --auto-exposure of `candela tonemap dim.exr`"),
        "{said:?}"
    );

    let said = warnings("--preview dim.png");
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(said[0].ends_with("try --auto-exposure"), "{said:?}");
    for cured in ["--auto-exposure", "--exposure 8"] {
        let said = warnings(&format!("--preview dim.png {cured}"));
        assert_eq!(said, [""; 0], "{cured}");
    }
    // What the automatic exposure passes over has another way out.
    lights(folder, "faint.toml", "1e-7", "0");
    let faint = fs::read_to_string(folder.join("faint.toml")).unwrap();
    let faint = faint.replace("background = [0.1, 0.2, 0.4]", "");
    fs::write(folder.join("faint.toml"), faint).unwrap();
    let said = self::warnings(folder, "render faint.toml --preview f.png --auto-exposure");
    assert_eq!(said.len(), 1, "{said:?}");
    let (_, ev) = said[0].split_once(": try --exposure ").unwrap();
    let cured = format!("render faint.toml --preview f.png --exposure {ev}");
    assert_eq!(self::warnings(folder, &cured), [""; 0]);
    // What is bright may be made dark.
    let said = self::warnings(folder, "render ball.toml --preview ball.png --exposure -20");
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(said[0].starts_with(start), "{said:?}");

    // Light that is none, and surfaces that reflect none.
    lights(folder, "off.toml", "0", "0");
    let black = [
        ("diffuse = [0.2, 0.09, 0.06]", ""),
        ("specular = 0.3", ""),
        ("background = [0.1, 0.2, 0.4]", ""),
    ];
    write(folder, "black.toml", &black);
    for scene in ["black", "off"] {
        let path = folder.join(format!("{scene}.toml"));
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, text.replace("background = [0.1, 0.2, 0.4]", "")).unwrap();
        let said = self::warnings(folder, &format!("render {scene}.toml"));
        assert_eq!(said.len(), 1, "{said:?}");
        assert!(
            said[0].starts_with("the picture is black: light reaches"),
            "{said:?}"
        );
    }
}

/// DWA leaves traces of light beside what is bright, where nothing covers a pixel. They are no background:
/// the preview keeps its alpha.
#[test]
fn traces_of_compression_are_no_background() {
    let folder = folder();
    let folder = folder.path();
    let changes = [
        ("background = [0.1, 0.2, 0.4]", ""),
        ("[30, 30, 30]", "3000"),
    ];
    write(folder, "void.toml", &changes);
    let arguments = "render void.toml --preview void.png --exposure -7 --compression dwaa";
    assert_eq!(warnings(folder, arguments), [""; 0]);
    let image = read(&folder.join("void.exr")).unwrap();
    let mut uncovered = image.pixels.iter().filter(|pixel| pixel[3] == 0.0);
    assert!(uncovered.any(|pixel| pixel[..3].iter().any(|&light| light > 0.0)));
    // The color type of a PNG with alpha.
    assert_eq!(fs::read(folder.join("void.png")).unwrap()[25], 6);
}

#[test]
fn a_picture_that_is_blown_out_is_said() {
    let folder = folder();
    let folder = folder.path();
    lights(folder, "bright.toml", "3000", "400");
    let warnings = |options: &str| warnings(folder, &format!("render bright.toml {options}"));
    let percent = |said: &[String]| -> f64 {
        let [said] = said else { panic!("{said:?}") };
        let (percent, rest) = said.split_once(" % of the picture is brighter").unwrap();
        for way_out in ["--exposure", "--auto-exposure", "--view reinhard"] {
            assert!(rest.contains(way_out), "{said}");
        }
        percent.parse().unwrap()
    };
    let said = warnings("--samples 1");
    let image = read(&folder.join("bright.exr")).unwrap();
    let is_beyond = |pixel: &&[f32; 4]| pixel[..3].iter().any(|&channel| channel > 1.009);
    let beyond = image.pixels.iter().filter(is_beyond).count();
    let expected = 100.0 * beyond as f64 / image.pixels.len() as f64;
    assert!(expected > 20.0);
    assert!((percent(&said) - expected).abs() <= 0.5);
    assert!(
        said[0].contains("of `candela tonemap bright.exr`"),
        "{said:?}"
    );
    // Layers are no part of the picture.
    assert_eq!(warnings("--samples 1 --layers lights,depth,normal"), said);
    // The preview counts with its own exposure.
    let same = warnings("--samples 1 --preview bright.png");
    assert_eq!(percent(&same), percent(&said));
    let darker = warnings("--samples 1 --preview bright.png --exposure -1");
    assert!(percent(&darker) < percent(&said));
    for cured in ["--exposure -9", "--view reinhard"] {
        let said = warnings(&format!("--samples 1 --preview bright.png {cured}"));
        assert_eq!(said, [""; 0], "{cured}");
    }
}

#[test]
fn warnings_of_check_are_those_of_render() {
    let folder = folder();
    let folder = folder.path();
    let inside = "position = [0, 0.5, 0]";
    let shiny = "specular = 8";
    let changes = [("position = [3, 4, 3]", inside), ("specular = 0.3", shiny)];
    write(folder, "odd.toml", &changes);
    let check = succeeds(folder, "check odd.toml");
    let (_, listed) = check.split_once("\nwarnings   2\n").unwrap();
    let listed: Vec<&str> = listed.lines().map(str::trim).collect();
    assert_eq!(listed.len(), 2);
    assert_eq!(warnings(folder, "render odd.toml"), listed);
    assert_eq!(said(folder, "render odd.toml -q"), [""; 0]);

    // Of many, some.
    let more: String = (0..15)
        .map(|i| format!("[materials.m{i}.phong]\nspecular = 8\nshininess = 5\n"))
        .collect();
    fs::write(folder.join("many.toml"), scene() + &more).unwrap();
    let check = succeeds(folder, "check many.toml");
    let (_, listed) = check.split_once("\nwarnings   15\n").unwrap();
    let count = listed.lines().count();
    assert_eq!(count, 15);
    let warnings = warnings(folder, "render many.toml");
    let expected = format!(
        "and {} more; `candela check many.toml` shows all",
        count - 5
    );
    assert_eq!(warnings[5], expected);
    assert_eq!(warnings.len(), 6);
}

/// What a stream has taken cannot be read back.
#[test]
fn a_preview_is_made_where_the_exr_goes_to_a_stream() {
    let folder = folder();
    let folder = folder.path();
    succeeds(folder, "render ball.toml -o file.exr --preview file.png");
    let bytes = |name: &str| fs::read(folder.join(name)).unwrap();
    let output = candela(folder, "render ball.toml -o - --preview piped.png")
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(output.stdout == bytes("file.exr"));
    assert!(bytes("piped.png") == bytes("file.png"));
    let said = text(&output.stderr);
    assert!(said.starts_with("standard output: 60 × 40"), "{said}");
    if cfg!(unix) {
        succeeds(folder, "render ball.toml -o /dev/null --preview null.png");
        assert!(bytes("null.png") == bytes("file.png"));
    }
}
