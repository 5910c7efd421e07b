//! The JSON schema of scenes: as it is checked in, and as Taplo, which editors use, judges by it.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use candela::scene::{Scene, schema};
use candela::world::World;
use serde_json::Value as Json;

/// What `candela schema` prints, for whoever wants it without candela.
const FILE: &str = "schema/candela.schema.json";

#[test]
fn the_file_is_what_the_reader_knows() {
    if std::env::var_os("BLESS").is_some() {
        fs::write(FILE, schema()).unwrap();
    }
    let is_same = fs::read_to_string(FILE).unwrap() == schema();
    assert!(is_same, "{FILE} is out of date (BLESS=1 writes it anew)");
}

/// The names of the files, without extension, in `folder` that Taplo finds fault with by the schema.
fn refused(folder: &Path) -> BTreeSet<String> {
    let taplo = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/taplo/bin/taplo");
    assert!(
        taplo.exists(),
        "{} is missing; run ./check, which installs it",
        taplo.display()
    );
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("schema.json");
    fs::write(&file, schema()).unwrap();
    let output = Command::new(taplo)
        .args(["lint", "--no-auto-config", "--colors", "never", "--schema"])
        .arg(format!("file://{}", file.display()))
        .arg("*.toml")
        .current_dir(folder)
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(text.contains("found files"), "{text}");
    assert!(!text.contains("failed to load schema"), "{text}");
    // Both where it shows a fault and where it sums up, of which it may lose the end.
    let names: BTreeSet<String> = text
        .lines()
        .filter_map(|line| {
            let shown = line.split_once("┌─ ").map(|(_, place)| place);
            let summed_up = line
                .contains("invalid file")
                .then(|| line.split_once("path=\""))
                .flatten();
            shown
                .or(summed_up.map(|(_, path)| path))?
                .split_once(".toml")
        })
        .map(|(path, _)| {
            Path::new(path)
                .file_name()
                .unwrap()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    assert_eq!(output.status.success(), names.is_empty(), "{text}");
    names
}

fn scenes(folder: &str) -> BTreeSet<String> {
    let files = fs::read_dir(folder).unwrap();
    let files = files.map(|entry| entry.unwrap().path());
    let files = files.filter(|path| path.extension().is_some_and(|found| found == "toml"));
    files
        .map(|path| path.file_stem().unwrap().to_string_lossy().into_owned())
        .collect()
}

#[test]
fn every_scene_is_valid() {
    assert!(scenes("scenes").len() > 20);
    assert_eq!(refused(Path::new("scenes")), BTreeSet::new());
}

/// What a schema cannot say, and the bad scenes that are wrong in that way alone. Each stands for all
/// whose names begin so.
const BEYOND: [(&str, &[&str]); 11] = [
    ("what is in a file", &["csv_", "mesh_"]),
    (
        "that wavelengths ascend",
        &["curve_duplicate", "curve_unsorted"],
    ),
    ("that lists are of one length", &["curve_lengths"]),
    (
        "what becomes of colors and curves in a space, or of sums of them",
        &[
            "outside_",
            "unit_black",
            "unit_overflow",
            "curve_albedo",
            "curve_overflow",
            "range_albedos",
        ],
    ),
    (
        "how points lie to each other",
        &[
            "range_eye",
            "range_up",
            "range_triangle",
            "range_sizes",
            "spot_at_itself",
            "area_named_as_object",
            "ies_at_itself",
        ],
    ),
    (
        "what is in an IES file",
        &["ies_missing", "ies_not_one", "ies_truncated"],
    ),
    (
        "which of two angles is larger",
        &["spot_inner_beyond_outer"],
    ),
    ("numbers that JSON's readers make infinite", &["curve_huge"]),
    ("wavelengths in another unit", &["curve_micrometers"]),
    (
        "what of an object is inside",
        &[
            "smooth_glass_plane",
            "smooth_glass_shells",
            "smooth_glass_crowded",
        ],
    ),
    (
        "whether an index is one for all wavelengths",
        &["smooth_glass_dispersion"],
    ),
];

#[test]
fn every_bad_scene_is_invalid_as_far_as_a_schema_can_say_it() {
    let all = scenes("tests/bad_scenes");
    assert!(all.len() > 100);
    let refused = refused(Path::new("tests/bad_scenes"));
    let is_beyond = |name: &&String| {
        let mut starts = BEYOND.iter().flat_map(|(_, starts)| *starts);
        starts.any(|start| name.starts_with(start))
    };
    let expected: BTreeSet<String> = all.iter().filter(is_beyond).cloned().collect();
    let valid: BTreeSet<String> = all.difference(&refused).cloned().collect();
    assert_eq!(valid, expected, "valid, and beyond what a schema can say");
}

/// Values of every type, near every limit.
const PROBES: [&str; 88] = [
    "0",
    "1",
    "0.5",
    "-1",
    "8",
    "179.9",
    "180",
    "1e9",
    "1.1e9",
    "1e30",
    "1.1e30",
    "-1e30",
    "3.4e38",
    "3.5e38",
    "0x10",
    "inf",
    "nan",
    "true",
    "2026-01-01",
    "\"\"",
    "\"auto\"",
    "\"rgb\"",
    "\"Spectral\"",
    "\"acescg\"",
    "\"srgb\"",
    "\"1964\"",
    "\"1930\"",
    "\"#c86432\"",
    "\"#C86432\"",
    "\"#c8643\"",
    "\"c86432\"",
    "\"#000000\"",
    "\"red\"",
    "\"nothing\"",
    "[]",
    "[1]",
    "[8, 8]",
    "[8, 0]",
    "[8, -8]",
    "[8, 65536]",
    "[65537, 8]",
    "[8, 8.5]",
    "[0, 0, 0]",
    "[0, 0, 5]",
    "[1, 1, 1]",
    "[0.1, 0.2, 0.3]",
    "[1.5, 0.2, 0.3]",
    "[-1, 2, 3]",
    "[1, 2, 3, 4]",
    "[1, 2, true]",
    "[1, 2, \"3\"]",
    "[1e31, 1, 1]",
    "[3.5e38, 1, 1]",
    "[[0, 0, 0], [1, 0, 0], [0, 1, 0]]",
    "[[0, 0, 0], [1, 0, 0]]",
    "[[0, 0], [1, 0], [0, 1]]",
    "{}",
    "{ x = 1 }",
    "{ rgb = [0.4, 0.4, 0.3] }",
    "{ rgb = [1.5, 1.5, 1.4] }",
    "{ rgb = 1 }",
    "{ rgb = [0.4, 0.4, 0.3], space = \"p3-d65\" }",
    "{ rgb = [0.4, 0.4, 0.3], space = \"p3\" }",
    "{ space = \"rec709\" }",
    "{ rgb = [0.4, 0.4, 0.3], candela = 1 }",
    "{ illuminant = \"F2\" }",
    "{ illuminant = \"f2\" }",
    "{ daylight = 4000 }",
    "{ daylight = 3999 }",
    "{ blackbody = 500 }",
    "{ blackbody = 1e7 }",
    "{ wavelengths = [400, 700], values = [0.1, 0.5] }",
    "{ wavelengths = [400], values = [0.1] }",
    "{ wavelengths = [400, 700], values = [0.1, -0.5] }",
    "{ wavelengths = [400, 700] }",
    "{ lines = [[589, 0.5], [589.6, 0.5]] }",
    "{ lines = [[300, 0.5]] }",
    "{ lines = [] }",
    "{ lines = [[589]] }",
    "{ candela = 120 }",
    "{ candela = -120 }",
    "{ lumens = 800, color = [1, 0.9, 0.8] }",
    "{ watts = 6, color = { illuminant = \"A\" } }",
    "{ candela = 1, color = { candela = 1 } }",
    "{ color = \"#ffffff\" }",
    "{ watts_per_steradian = 0.5, color = 2 }",
    "{ watts_per_steradian_nm = 0.002 }",
    "{ watts_per_steradian_nm = { wavelengths = [400, 700], values = [0.1, 0.5] } }",
];

/// Where the reader knows more than a schema can say.
fn is_beyond(key: &str, value: &str) -> bool {
    // JSON has no dates, which are text to Taplo.
    let is_text = value.starts_with('"') || value == "2026-01-01";
    match key {
        // Whether a material or a file of this name is there.
        "material" | "file" => is_text,
        "group" => value == "2026-01-01",
        // How points lie to each other.
        "eye" | "position" | "center" => value == "[0, 0, 0]",
        // Whether it is along the way that a light points.
        "up" => value == "[0,1,0]",
        // How large a mesh is beside what is seen of it.
        "scale" => value.trim_start_matches('-') == "1e30",
        // How large the values of a curve are, beside 1.
        "n" => value.starts_with("{ wavelengths = [400, 700], values"),
        // Whether an index is one for all wavelengths.
        "dispersion" => value == "true",
        // Which of two angles is larger.
        "inner" => value.parse().is_ok_and(|angle: f64| angle > 30.0),
        _ => false,
    }
}

/// A kind of entry: its header, and its keys with an example of each.
struct Kind {
    header: String,
    keys: Vec<(String, String)>,
    required: Vec<String>,
    /// Keys of which exactly one is required.
    one_of: Vec<String>,
}

impl Kind {
    /// Whether an entry in which `probed` is looked at has this key for the rest to be sound.
    fn needs(&self, name: &String, probed: &str) -> bool {
        let is_choice = self.one_of.first() == Some(name);
        let is_chosen = self.one_of.iter().any(|choice| choice == probed);
        self.required.contains(name) || is_choice && !is_chosen
    }
}

/// The kinds of entry that the schema knows.
fn kinds() -> Vec<Kind> {
    let schema: Json = serde_json::from_str(&schema()).unwrap();
    let kind = |header: String, form: &Json| {
        let keys = form["properties"].as_object().unwrap().iter();
        let keys = keys.map(|(name, key)| (name.clone(), key["examples"][0].to_string()));
        let required = form["required"].as_array().into_iter().flatten();
        let one_of = form["oneOf"].as_array().into_iter().flatten();
        let one_of = one_of.map(|choice| choice["required"][0].as_str().unwrap().to_owned());
        Kind {
            one_of: one_of.collect(),
            header,
            keys: keys.collect(),
            required: required
                .map(|key| key.as_str().unwrap().to_owned())
                .collect(),
        }
    };
    let sections = &schema["properties"];
    let mut kinds = vec![kind("image".to_owned(), &sections["image"])];
    let members = |json: &Json| json.as_object().unwrap().clone();
    for (name, form) in members(&sections["camera"]["properties"]) {
        kinds.push(kind(format!("camera.{name}"), &form));
    }
    for section in ["materials", "lights", "objects"] {
        let entries = members(&sections[section]["patternProperties"]);
        assert_eq!(entries.len(), 1);
        for (name, form) in members(&entries.values().next().unwrap()["properties"]) {
            kinds.push(kind(format!("{section}.probed.{name}"), &form));
        }
    }
    kinds
}

/// A sound scene but for one entry.
fn around(header: &str, entry: &str) -> String {
    let parts = [
        ("image", "[image]\nresolution = [8, 8]\n"),
        (
            "camera",
            "[camera.perspective]\neye = [0, 0, 5]\nlook_at = [0, 0, 0]\nvertical_fov = 40\n",
        ),
        ("materials", "[materials.clay.phong]\ndiffuse = 0.5\n"),
        (
            "lights",
            "[lights.key.point]\nposition = [3, 4, 3]\nintensity = 30\n",
        ),
        (
            "objects",
            "[objects.ball.sphere]\nmaterial = \"clay\"\ncenter = [0, 0, 0]\nradius = 1\n",
        ),
    ];
    let mut text = format!("[{header}]\n{entry}");
    for (section, part) in parts {
        let is_single = matches!(section, "image" | "camera");
        if !(is_single && header.starts_with(section)) {
            text += part;
        }
    }
    text
}

/// Schema and reader against each other: each key of each kind of entry with every value, without the
/// key, and with another.
#[test]
fn the_schema_agrees_with_the_reader() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("dragon.ply"), TRIANGLE).unwrap();
    fs::copy(
        "tests/bad_scenes/lamp.ies",
        folder.path().join("downlight.ies"),
    )
    .unwrap();
    let kinds = kinds();
    let keys: usize = kinds.iter().map(|kind| kind.keys.len()).sum();
    assert!(keys >= 34, "{keys}");
    let mut cases: Vec<(String, String)> = Vec::new();
    for kind in &kinds {
        let mut case = |what: String, key: &str, change: Option<&str>| {
            let mut entry = String::new();
            for (name, example) in &kind.keys {
                // What depends on others is as small as it can be.
                let is_probed = name == key;
                if is_probed && let Some(value) = change {
                    writeln!(entry, "{name} = {value}").unwrap();
                } else if !is_probed && kind.needs(name, key) {
                    writeln!(entry, "{name} = {example}").unwrap();
                }
            }
            cases.push((what, around(&kind.header, &entry)));
        };
        case(format!("{} as it is", kind.header), "", None);
        for (name, example) in &kind.keys {
            case(format!("{} without {name}", kind.header), name, None);
            let probes = PROBES.into_iter().chain([example.as_str()]);
            for value in probes.filter(|value| !is_beyond(name, value)) {
                case(
                    format!("{}: {name} = {value}", kind.header),
                    name,
                    Some(value),
                );
            }
        }
        let entry = |more: &str| {
            let required = kind.keys.iter().filter(|(name, _)| kind.needs(name, ""));
            let lines: String = required
                .map(|(name, example)| format!("{name} = {example}\n"))
                .collect();
            lines + more
        };
        cases.push((
            format!("{} with another key", kind.header),
            around(&kind.header, &entry("flavor = 1\n")),
        ));
    }
    let names = [
        "a", "9", "a b", "a-b", "a_b", "Füll", "光", " a", "a ", " ", "", "a.b", "a/b", "a:b",
        "a,b", "a\\tb", "a#b", "\u{7f}",
    ];
    for section in [
        "materials.NAME.phong",
        "lights.NAME.point",
        "objects.NAME.sphere",
    ] {
        let entry = match &section[..1] {
            "m" => "",
            "l" => "position = [0, 0, 9]\nintensity = 1\n",
            _ => "material = \"clay\"\ncenter = [0, 0, 0]\nradius = 1\n",
        };
        for name in names
            .map(str::to_owned)
            .into_iter()
            .chain([200, 201].map(|n| "n".repeat(n)))
        {
            let header = section.replace("NAME", &format!("\"{name}\""));
            cases.push((header.clone(), around(&header, entry)));
        }
    }
    let path = |index: usize| -> PathBuf { folder.path().join(format!("{index}.toml")) };
    for (index, (_, text)) in cases.iter().enumerate() {
        fs::write(path(index), text).unwrap();
    }
    let refused = refused(folder.path());
    let mut differences = Vec::new();
    let mut legal = 0;
    for (index, (what, _)) in cases.iter().enumerate() {
        let read = World::load(path(index));
        legal += usize::from(read.is_ok());
        if read.is_ok() == refused.contains(&index.to_string()) {
            let reader = read
                .err()
                .map_or("legal".to_owned(), |error| error.to_string());
            differences.push(format!("{what}: to the reader {reader}"));
        }
    }
    // Neither says yes, or no, to everything.
    assert!(
        legal > 250 && cases.len() - legal > 1000,
        "{legal} of {}",
        cases.len()
    );
    assert!(
        differences.is_empty(),
        "{} of {}:\n{}",
        differences.len(),
        cases.len(),
        differences.join("\n")
    );
}

/// A text without the places of values.
fn without_places(text: &str) -> String {
    let mut parts = text.split("Span { start: ");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| {
        let (_, rest) = part.split_once('}').unwrap();
        text + rest
    })
}

/// What stands where a key does not is what the schema says.
#[test]
fn defaults_are_what_the_schema_says() {
    let json: Json = serde_json::from_str(&schema()).unwrap();
    let json = &json["properties"];
    let entry = |section: &str| {
        json[section]["patternProperties"]
            .as_object()
            .unwrap()
            .clone()
    };
    let kinds = |section: &str| entry(section).values().next().unwrap()["properties"].clone();
    let forms = [
        ("image", "image", json.clone()),
        (
            "camera.perspective",
            "perspective",
            json["camera"]["properties"].clone(),
        ),
        (
            "camera.orthographic",
            "orthographic",
            json["camera"]["properties"].clone(),
        ),
        ("materials.probed.phong", "phong", kinds("materials")),
        (
            "materials.probed.normalized_phong",
            "normalized_phong",
            kinds("materials"),
        ),
        ("objects.probed.mesh", "mesh", kinds("objects")),
    ];
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("dragon.ply"), TRIANGLE).unwrap();
    fs::copy(
        "tests/bad_scenes/lamp.ies",
        folder.path().join("downlight.ies"),
    )
    .unwrap();
    let path = folder.path().join("scene.toml");
    let mut defaults = 0;
    for (header, kind, forms) in forms {
        let form = &forms[kind];
        let required: String = form["required"]
            .as_array()
            .into_iter()
            .flatten()
            .map(|key| {
                format!(
                    "{} = {}\n",
                    key.as_str().unwrap(),
                    form["properties"][key.as_str().unwrap()]["examples"][0]
                )
            })
            .collect();
        let read = |entry: &str| {
            let scene = Scene::parse(&around(header, entry), &path).unwrap();
            let Scene {
                image,
                camera,
                materials,
                objects,
                ..
            } = scene;
            without_places(&format!("{image:?} {camera:?} {materials:?} {objects:?}"))
        };
        for (name, key) in form["properties"].as_object().unwrap() {
            if let Some(default) = key.get("default") {
                defaults += 1;
                let said = read(&format!("{required}{name} = {default}\n"));
                assert_eq!(said, read(&required), "{header}: {name} = {default}");
            }
        }
    }
    assert_eq!(defaults, 5 + 2 + 2 * 3 + 5);
}

/// A mesh of one triangle.
const TRIANGLE: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                        property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
                        end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
