//! The numbers that pages state are those that tests assert, benchmarks have measured and the program prints.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::{colorimetry, conformance, energy, generate, invariance, oracle, truths};

/// A page as one line of words, so that a sentence is found however its lines are broken.
fn page(path: &str) -> String {
    let text = fs::read_to_string(path).unwrap();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The number behind a phrase, which stands there once.
#[track_caller]
fn stated(page: &str, phrase: &str) -> f64 {
    let [_, rest] = page.split(phrase).collect::<Vec<_>>()[..] else {
        panic!("`{phrase}` does not stand there once");
    };
    let end = rest.find(|c: char| !c.is_ascii_digit() && !"e-. ".contains(c));
    let number = rest[..end.unwrap_or(rest.len())].trim();
    let number = number.trim_end_matches(['.', '-', ' ']).replace(' ', "");
    let number = number.parse();
    number.unwrap_or_else(|_| panic!("after `{phrase}` there is no number: {rest:.20}"))
}

/// Whether a page states a figure: rounded up, by less than a tenth.
fn states(stated: f64, figure: f64) -> bool {
    (figure..1.1 * figure).contains(&stated)
}

#[test]
fn errors_beside_the_oracle() {
    let readme = page("README.md");
    let promise = "shares no code with the renderer, to a relative error of ";
    assert_eq!(stated(&readme, promise), oracle::TOLERANCE);
    let worst = stated(&readme, "generated scenes the worst is ");
    assert!(states(worst, oracle::WORST_OF_MANY), "{worst:e}");

    let guarantees = page("docs/guarantees.md");
    let promise = stated(&guarantees, "Pixels agree to a relative error of ");
    assert_eq!(promise, oracle::TOLERANCE);
    let one_in = stated(&guarantees, "that may be one pixel in ");
    assert_eq!(one_in, 1.0 / oracle::FLIPS);
    let kinds = [
        "no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten",
        "eleven", "twelve", "thirteen", "fourteen",
    ];
    let kinds = format!("generated scenes of {} kinds", kinds[generate::KINDS]);
    assert!(guarantees.contains(&kinds), "{kinds}");
}

#[test]
fn sizes() {
    let guarantees = page("docs/guarantees.md");
    let powers = invariance::SCALES.map(|scale: f64| scale.log10().round());
    let [least, most] = [powers[0], powers[powers.len() - 1]];
    assert_eq!([least, most], [-6.0, 6.0]);
    assert!(guarantees.contains("scaled by 10⁻⁶ to 10⁶ or moved"));
    assert!(guarantees.contains("a million units from the origin"));
    assert_eq!(invariance::FAR, 1e6);
    // In metres, of a scene of 1 m.
    for text in [&guarantees, &page("README.md")] {
        assert!(text.contains("may be a micrometre or a thousand kilometres large"));
    }
}

#[test]
fn colors_beside_colour_science() {
    for path in ["README.md", "docs/guarantees.md"] {
        let text = page(path);
        assert!(states(stated(&text, "within ΔE00 "), colorimetry::WORST));
        assert!(text.contains("24 measured reflectances under six lamps"));
        assert_eq!(colorimetry::LIGHTS.len(), 6);
    }
    // Two digits, or one and a decimal.
    let digits = |difference: f64| match difference {
        0.0 => "0".to_owned(),
        _ if difference < 9.95 => format!("{difference:.1}"),
        _ => format!("{difference:.0}"),
    };
    let table = fs::read_to_string("docs/rgb-or-spectral.md").unwrap();
    for (light, spaces) in colorimetry::PUBLISHED {
        let cells = spaces.map(|spaces| spaces.map(digits).join(" / "));
        let row = format!("| {} |", cells.join(" | "));
        let stands = |line: &str| line.starts_with(&format!("| {light},")) && line.ends_with(&row);
        assert!(table.lines().any(stands), "{light}: {row}");
    }
}

/// Conformance, published values, other programs.
#[test]
fn what_others_find() {
    let count = conformance::suite().len();
    let guarantees = page("docs/guarantees.md");
    assert!(guarantees.contains(&format!("{count} scenes with pictures made from formulas")));
    let flux = stated(&guarantees, "the flux of a closed room to ");
    assert!(states(flux, truths::FLUX), "{flux:e}");
    let radiance = stated(&guarantees, "eight scenes of Radiance to ");
    assert!(states(radiance, truths::RADIANCE), "{radiance:e}");
    let conformance = page("docs/conformance.md");
    assert!(conformance.contains(&format!("has {count} small scenes")));
    assert!(page("CHANGELOG.md").contains(&format!("A conformance suite: {count} scenes")));
    let lobes = stated(&page("docs/energy.md"), "agree with the closed form to ");
    assert!(states(lobes, energy::LOBES), "{lobes:e}");
}

/// How many times as fast as Embree, with three lights: from the archive that the README names.
#[test]
fn speed_is_that_of_the_archive() {
    let readme = fs::read_to_string("README.md").unwrap();
    let archive = readme.split("(benches/archive/").nth(1).unwrap();
    let archive = archive.split(".md)").next().unwrap();
    let archive = Path::new("benches/archive").join(format!("{archive}.json"));
    let archive: Value = serde_json::from_str(&fs::read_to_string(archive).unwrap()).unwrap();
    let median = |scene: &str, samples: u64| -> f64 {
        let rows = archive["rows"].as_array().unwrap();
        let row = rows
            .iter()
            .find(|row| row["scene"] == scene && row["lights"] == 3 && row["samples"] == samples);
        row.unwrap()["ratio"]["median"].as_f64().unwrap()
    };
    let mut all = Vec::new();
    for (scene, words) in [
        ("spheres", "25 spheres on a floor"),
        ("dragon", "the Stanford dragon, 871 414 triangles"),
        ("smooth", "a smooth mesh of 1 M triangles"),
    ] {
        let ratios = [1, 4, 16].map(|samples| median(scene, samples));
        all.extend(ratios);
        let row = format!(
            "| {words} | {:.1}, {:.1}, {:.1} |",
            ratios[0], ratios[1], ratios[2]
        );
        assert!(readme.lines().any(|line| line == row), "{row}");
    }
    let machine = archive["setting"]["machine"].as_str().unwrap();
    let head = format!("| 1, 4, 16 samples | {machine} |");
    assert!(readme.lines().any(|line| line == head), "{head}");
    let [least, most] = [f64::min, f64::max].map(|of| all.iter().copied().reduce(of).unwrap());
    let range = format!("{least:.1} to {most:.0} times as fast as the same work on Embree");
    assert!(page("README.md").contains(&range), "{range}");
}

/// The table of one pixel is what the program prints, but for what is left out.
#[test]
fn a_probe_is_quoted() {
    let readme = fs::read_to_string("README.md").unwrap();
    let mut quoted = readme
        .split("```text\n$ candela probe ")
        .nth(1)
        .unwrap()
        .lines();
    let arguments = quoted.next().unwrap().split(' ');
    let mut command = Command::new(env!("CARGO_BIN_EXE_candela"));
    let output = command.arg("probe").args(arguments).output().unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    let mut printed = printed.lines();
    let mut compared = 0;
    for line in quoted.take_while(|line| *line != "```") {
        if line != "…" && !line.is_empty() {
            assert!(printed.any(|printed| printed.trim_end() == line), "{line}");
            compared += 1;
        }
    }
    assert!(compared > 10, "{compared}");
}

#[test]
fn numbers_are_read() {
    let page =
        "the worst is 6e-8, half of it; within ΔE00 0.004 of it. One pixel in 500 000 may be.";
    assert_eq!(stated(page, "the worst is "), 6e-8);
    assert_eq!(stated(page, "within ΔE00 "), 0.004);
    assert_eq!(stated(page, "One pixel in "), 5e5);
    assert!(states(0.004, 3.84e-3) && states(6e-8, 6e-8));
    assert!(!states(0.003, 3.84e-3) && !states(0.005, 3.84e-3));
}
