//! `candela report`: speed against error.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::{SCENE, fails, files, folder, image, output, succeeds, text};

const QUICK: &str = "--runs 1 --reference 256 --samples 1,4,16 --errors 5%";

const FILES: [&str; 5] = [
    "index.html",
    "plot.png",
    "plot.svg",
    "report.csv",
    "report.json",
];

/// Makes a report quickly; its JSON.
fn report(folder: &Path, arguments: &str) -> Value {
    succeeds(folder, &format!("report {QUICK} {arguments} -o out"));
    let text = fs::read_to_string(folder.join("out/report.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn read(folder: &Path, name: &str) -> String {
    fs::read_to_string(folder.join("out").join(name)).unwrap()
}

/// R, G, B of a picture, value by value.
fn values(folder: &Path, name: &str) -> Vec<f64> {
    let pixels = image(folder, name).pixels;
    let values = pixels.iter().flat_map(|pixel| &pixel[..3]);
    values.map(|&value| f64::from(value)).collect()
}

/// R, G, B of a picture of half the size: means of four pixels, in the f32 of a film.
fn halved(folder: &Path, name: &str) -> Vec<f64> {
    let image = image(folder, name);
    let [width, height] = image.resolution.map(|side| side as usize);
    let mut values = Vec::new();
    for y in (0..height).step_by(2) {
        for x in (0..width).step_by(2) {
            let places = [
                y * width + x,
                y * width + x + 1,
                (y + 1) * width + x,
                (y + 1) * width + x + 1,
            ];
            for channel in 0..3 {
                let sum: f64 = places
                    .map(|place| f64::from(image.pixels[place][channel]))
                    .iter()
                    .sum();
                values.push(f64::from((sum / 4.0) as f32));
            }
        }
    }
    values
}

/// √mean of the squares of differences.
fn rmse(reference: &[f64], measured: &[f64]) -> f64 {
    assert_eq!(reference.len(), measured.len());
    let squares = reference.iter().zip(measured).map(|(r, i)| (i - r).powi(2));
    f64::sqrt(squares.sum::<f64>() / reference.len() as f64)
}

/// The first row of these.
fn row<'r>(report: &'r Value, series: &str, transport: &str, setting: &str) -> &'r Value {
    let rows = report["rows"].as_array().unwrap();
    let is_it = |row: &&Value| {
        row["series"] == series && row["transport"] == transport && row["setting"] == setting
    };
    rows.iter().find(is_it).unwrap()
}

#[track_caller]
fn agree(actual: &Value, expected: f64) {
    let actual = actual.as_f64().unwrap();
    assert!(
        (actual - expected).abs() <= 1e-12 * expected.abs(),
        "{actual} {expected}"
    );
}

#[test]
fn errors_are_those_of_the_rendered_pictures() {
    let folder = folder();
    let found = report(folder.path(), "ball.toml");
    assert_eq!(files(&folder.path().join("out")), FILES);
    assert_eq!(found["resolution"], serde_json::json!([60, 40]));
    let fine = SCENE.replace("[60, 40]", "[120, 80]");
    fs::write(folder.path().join("fine.toml"), fine).unwrap();
    for transport in ["rgb", "spectral"] {
        let render = |scene: &str, how: &str, name: &str| {
            let options = format!("--transport {transport} {how} --quiet -o {name}.exr");
            succeeds(folder.path(), &format!("render {scene}.toml {options}"));
        };
        // 256 samples of a pixel are 64 of each of the four finer ones in it.
        render("fine", "--samples 64", "whole");
        render("fine", "--samples 32", "half");
        let whole = halved(folder.path(), "whole.exr");
        let mean = whole.iter().sum::<f64>() / whole.len() as f64;
        for (how, series, setting) in [
            ("--samples 1", "candela, N samples", "1 sample"),
            ("--samples 4", "candela, N samples", "4 samples"),
            ("--samples 16", "candela, N samples", "16 samples"),
            ("--max-error 5%", "candela, to an error", "to 5 %"),
        ] {
            render("ball", how, "picture");
            let rmse = rmse(&whole, &values(folder.path(), "picture.exr"));
            let row = row(&found, series, transport, setting);
            agree(&row["rmse_cd_m2"], rmse);
            agree(&row["rmse_percent"], 100.0 * rmse / mean);
            assert!(row["seconds"].as_f64().unwrap() > 0.0);
            let is_aimed = series == "candela, to an error";
            assert_eq!(row["target"].as_f64(), is_aimed.then_some(0.05));
            assert_eq!(row["unmet"].is_u64(), is_aimed);
            for column in ["within_target", "proven"] {
                let part = row[column].as_f64();
                assert_eq!(part.is_some(), is_aimed, "{column}");
                assert!(part.is_none_or(|part| part > 0.5), "{column}: {part:?}");
            }
        }
        let references = found["references"].as_array().unwrap();
        let reference = references.iter().find(|row| row["transport"] == transport);
        let reference = reference.unwrap();
        let half = rmse(&whole, &halved(folder.path(), "half.exr"));
        agree(&reference["rmse_cd_m2"], half);
        agree(&reference["mean_cd_m2"], mean);
        assert_eq!(reference["samples"], 256);
    }
}

#[test]
fn all_files_say_the_same() {
    let folder = folder();
    let found = report(folder.path(), "ball.toml");
    let rows = found["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 8);
    let csv = read(folder.path(), "report.csv");
    let json = read(folder.path(), "report.json");
    let mut lines = csv.lines();
    let columns: Vec<&str> = lines.next().unwrap().split(',').collect();
    assert_eq!(columns.len(), rows[0].as_object().unwrap().len());
    for (line, row) in lines.clone().zip(rows) {
        // The name of the series alone has a comma.
        let line = line.replace("\"candela, N samples\"", "candela; N samples");
        let line = line.replace("\"candela, to an error\"", "candela; to an error");
        for (cell, column) in line.split(',').zip(&columns) {
            match &row[column] {
                Value::String(text) => assert_eq!(cell, text.replace(',', ";")),
                Value::Null => assert_eq!(cell, ""),
                // To the last digit.
                _ => assert!(json.contains(&format!("\"{column}\": {cell}")), "{column}"),
            }
        }
    }
    assert_eq!(lines.count(), rows.len());
    let svg = read(folder.path(), "plot.svg");
    // And those of the legend.
    assert_eq!(svg.matches("class=\"mark\"").count(), rows.len() + 4);
    let page = read(folder.path(), "index.html");
    assert!(page.contains(&svg));
    // The table's head, and its rows.
    assert_eq!(page.matches("<tr").count(), rows.len() + 1);
    let png = fs::read(folder.path().join("out/plot.png")).unwrap();
    assert_eq!(
        png[16..24],
        [0, 0, 7, 128, 0, 0, 4, 56],
        "1920 × 1080 pixels"
    );
}

#[test]
fn the_page_is_by_itself() {
    let folder = folder();
    let scene = folder.path().join("ball.toml");
    report(folder.path(), &scene.display().to_string());
    for name in ["index.html", "plot.svg", "report.json", "report.csv"] {
        let text = read(folder.path(), name);
        assert!(!text.contains(&*folder.path().to_string_lossy()), "{name}");
        let text = text.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
        for outside in [
            "http:", "https:", "file:", "<script", "<link", "@import", "url(",
        ] {
            assert!(!text.contains(outside), "{name}: {outside}");
        }
        for (start, attribute) in text.match_indices(" src=\"") {
            assert!(text[start + attribute.len()..].starts_with("data:image/png;base64,"));
        }
        for (start, attribute) in text.match_indices(" href=\"") {
            assert!(text[start + attribute.len()..].starts_with('#'));
        }
    }
}

#[test]
fn errors_do_not_depend_on_threads() {
    let folder = folder();
    let errors = |threads: u32| {
        let found = report(folder.path(), &format!("ball.toml --threads {threads}"));
        assert_eq!(found["threads"], threads);
        let mut rows = found["rows"].clone();
        for row in rows.as_array_mut().unwrap() {
            row.as_object_mut().unwrap().remove("seconds");
        }
        rows
    };
    assert_eq!(errors(1), errors(2));
}

#[test]
fn a_light_that_cannot_be_carried_both_ways() {
    let folder = folder();
    let saturated = SCENE.replace(
        "[0.7, 0.3, 0.2]",
        "{ rgb = [0.2, 0, 0], space = \"rec2020\" }",
    );
    let saturated = saturated.replace("[image]", "[image]\ncolor_space = \"rec2020\"");
    fs::write(folder.path().join("red.toml"), saturated).unwrap();
    let found = report(folder.path(), "red.toml");
    assert_eq!(found["references"].as_array().unwrap().len(), 1);
    assert_eq!(found["left_out"][0]["what"], "candela, spectral");
    let message = fails(
        folder.path(),
        "report red.toml -o other --transport spectral",
        1,
    );
    assert!(message.contains("red.toml"), "{message}");
}

#[test]
fn a_black_picture_and_a_single_pixel() {
    let folder = folder();
    let black = SCENE.replace("background = [0.1, 0.2, 0.4]", "");
    let black = black.replace("position = [3, 4, 3]", "position = [3, -4, 3]");
    let black = black.replace("position = [-3, 2, 1]", "position = [-3, -2, 1]");
    fs::write(folder.path().join("black.toml"), black).unwrap();
    let found = report(folder.path(), "black.toml");
    let first = &found["rows"][0];
    assert_eq!([&first["rmse_cd_m2"], &first["flip"]], [0.0, 0.0]);
    for column in [
        "rmse_percent",
        "relmse",
        "relative_p999",
        "relative_max",
        "hdr_flip",
    ] {
        assert_eq!(first[column], Value::Null, "{column}");
    }
    let said = found["remarks"][0].as_str().unwrap();
    assert!(said.starts_with("the picture is black"), "{said}");
    assert!(read(folder.path(), "plot.svg").contains("there is nothing to plot"));

    let pixel = SCENE.replace("[60, 40]", "[1, 1]");
    fs::write(folder.path().join("pixel.toml"), pixel).unwrap();
    let found = report(folder.path(), "pixel.toml");
    assert_eq!(found["resolution"], serde_json::json!([1, 1]));
    assert!(found["rows"][0]["rmse_percent"].as_f64().unwrap() > 0.0);
}

/// A list of one picture.
fn list(seconds: &str, picture: &str) -> String {
    format!(
        r#"{{"threads": 2, "rows": [{{"series": "other <1>", "setting": "all", "label": "a",
            "seconds": {seconds}, "runs": 3, "picture": "{picture}"}}],
            "left_out": [{{"what": "a third", "why": "it has no lobe"}}], "remarks": ["It is."]}}"#
    )
}

#[test]
fn other_programs_are_measured_alike() {
    let folder = folder();
    fs::create_dir(folder.path().join("peers")).unwrap();
    let path = |name: &str| folder.path().join("peers").join(name);
    succeeds(
        folder.path(),
        "render ball.toml --samples 4 --quiet -o peers/four.exr",
    );
    fs::write(path("peers.json"), list("0.5", "four.exr")).unwrap();
    let found = report(folder.path(), "ball.toml --peers peers/peers.json");
    let (own, other) = (
        row(&found, "candela, N samples", "rgb", "4 samples"),
        row(&found, "other <1>", "rgb", "all"),
    );
    for column in [
        "rmse_cd_m2",
        "relmse",
        "relative_p999",
        "relative_max",
        "flip",
        "hdr_flip",
    ] {
        assert_eq!(own[column], other[column], "{column}");
    }
    assert_eq!(
        [&other["seconds"], &other["samples_per_pixel"]],
        [&Value::from(0.5), &Value::Null]
    );
    assert_eq!(found["left_out"][0]["why"], "it has no lobe");
    assert_eq!(found["remarks"][0], "It is.");
    let page = read(folder.path(), "index.html");
    assert!(page.contains("other &lt;1&gt;") && !page.contains("other <1>"));
    // Light of a spectrum is another picture.
    let found = report(
        folder.path(),
        "ball.toml --peers peers/peers.json --transport spectral",
    );
    assert_eq!(found["left_out"][0]["what"], "the programs of --peers");
}

#[test]
fn what_is_wrong_leaves_everything_as_it_was() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    fs::create_dir(path("out")).unwrap();
    for name in FILES {
        fs::write(path("out").join(name), "before").unwrap();
    }
    fs::write(
        path("bad.toml"),
        SCENE.replace("radius = 0.5", "radius = -1"),
    )
    .unwrap();
    fs::write(path("small.toml"), SCENE.replace("[60, 40]", "[30, 20]")).unwrap();
    succeeds(folder.path(), "render small.toml --quiet -o small.exr");
    for (name, text) in [
        ("text.json", "no JSON".to_owned()),
        ("key.json", list("1", "small.exr").replace("label", "lable")),
        ("size.json", list("1", "small.exr")),
        ("time.json", list("0", "small.exr")),
        ("absent.json", list("1", "absent.exr")),
        ("scene.json", list("1", "ball.toml")),
    ] {
        fs::write(path(name), text).unwrap();
    }
    for (arguments, part) in [
        ("ball.toml -o ball.toml", "cannot make the folder ball.toml"),
        (
            "ball.toml -o ball.toml/out",
            "cannot make the folder ball.toml/out",
        ),
        ("bad.toml -o out", "bad.toml"),
        ("absent.toml -o out", "absent.toml"),
        (
            "ball.toml -o out --peers nowhere.json",
            "cannot read nowhere.json",
        ),
        ("ball.toml -o out --peers out", "cannot read out"),
        (
            "ball.toml -o out --peers text.json",
            "text.json is not a list",
        ),
        ("ball.toml -o out --peers key.json", "unknown field `lable`"),
        (
            "ball.toml -o out --peers size.json",
            "small.exr has 30 × 20 pixels",
        ),
        (
            "ball.toml -o out --peers time.json",
            "expected a time above 0",
        ),
        ("ball.toml -o out --peers absent.json", "absent.exr"),
        (
            "ball.toml -o out --peers scene.json",
            "it is not an OpenEXR file",
        ),
    ] {
        let message = fails(folder.path(), &format!("report {QUICK} {arguments}"), 1);
        assert!(message.contains(part), "{arguments}: {message}");
    }
    for name in FILES {
        assert_eq!(read(folder.path(), name), "before");
    }
    assert_eq!(files(&path("out")), FILES);
    for arguments in [
        "--samples 0",
        "--samples 1,x",
        "--runs 0",
        "--reference-seconds -1",
    ] {
        fails(
            folder.path(),
            &format!("report ball.toml -o out {arguments}"),
            2,
        );
    }
    let message = text(&output(folder.path(), "report ball.toml").stderr);
    assert!(message.contains("--output"), "{message}");
}
