//! Who may use whom, and how long a file may be, read from the sources themselves.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The modules of the library in the order in which data flows, and whom each may use. The oracle
/// shares nothing with the renderer but the scene as written and the published tables, so that no mistake
/// can hide on both sides.
const MAY_USE: [(&str, &[&str]); 19] = [
    ("units", &[]),
    ("math", &[]),
    ("simd", &["math"]),
    ("camera", &["math", "simd"]),
    ("color", &[]),
    ("printable", &[]),
    ("memory", &[]),
    ("output", &["printable"]),
    ("spectrum", &["units", "printable"]),
    ("scene", &["units", "spectrum", "printable", "memory"]),
    (
        "world",
        &[
            "scene",
            "units",
            "math",
            "camera",
            "color",
            "spectrum",
            "printable",
            "memory",
        ],
    ),
    ("visibility", &["world", "camera", "math", "simd", "memory"]),
    ("shading", &["world", "visibility", "units", "math", "simd"]),
    ("turns", &[]),
    ("image", &["scene"]),
    (
        "exr",
        &[
            "image",
            "world",
            "scene",
            "color",
            "output",
            "printable",
            "turns",
        ],
    ),
    (
        "render",
        &[
            "world",
            "camera",
            "visibility",
            "shading",
            "scene",
            "image",
            "exr",
            "math",
            "simd",
            "memory",
            "output",
            "turns",
        ],
    ),
    (
        "display",
        &["image", "exr", "color", "memory", "output", "printable"],
    ),
    ("oracle", &["scene", "spectrum"]),
];

/// Arrows that are only to some items: who, to whom, to what there.
const ONLY_TO: [(&str, &str, &[&str]); 2] = [
    // The spaces' primaries, which the header of a file has.
    ("exr", "world", &["colorimetry"]),
    // What was published and what was written, not what the renderer makes of it.
    (
        "oracle",
        "spectrum",
        &["tables", "Curve", "Lines", "Illuminant", "Observer"],
    ),
];

/// Methods by which those items give away what the oracle computes itself.
const NOT_CALLED_IN_ORACLE: [&str; 6] = [
    ".spectrum(",
    "::spectrum(",
    ".color_matching(",
    "::color_matching(",
    ".luminous_efficacy(",
    "::luminous_efficacy(",
];

/// Crates that the oracle must not share with the renderer.
const NOT_IN_ORACLE: [&str; 4] = ["glam", "libm", "rayon", "half"];

/// Lines of a file before its unit tests. The aim is 600; beyond this it is time to part it.
const LONGEST: usize = 650;

/// Every Rust file below a folder, sorted.
fn sources(folder: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![PathBuf::from(folder)];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|found| found == "rs") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// A source without its comments.
fn code(text: &str) -> String {
    let line = |line: &str| -> String {
        let end = line.find("//").unwrap_or(line.len());
        line[..end].to_owned() + "\n"
    };
    text.lines().map(line).collect()
}

/// The path of modules that a file is: `src/exr/read/mod.rs` is exr, read.
fn module_path(path: &Path) -> Vec<String> {
    let mut parts: Vec<String> = path
        .with_extension("")
        .components()
        .skip(1)
        .map(|part| part.as_os_str().to_string_lossy().into_owned())
        .collect();
    parts.pop_if(|last| last == "mod" || last == "lib");
    parts
}

fn identifier(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_ascii_alphanumeric() && c != '_');
    &text[..end.unwrap_or(text.len())]
}

/// The first two parts of each path in what follows `crate::`, with groups in braces opened:
/// `{a::b, c}` is a::b and c.
fn heads(text: &str) -> Vec<(String, String)> {
    let Some(group) = text.strip_prefix('{') else {
        let first = identifier(text);
        let rest = text[first.len()..].strip_prefix("::").unwrap_or("");
        if first.is_empty() {
            return Vec::new();
        }
        return match rest.strip_prefix('{') {
            None => vec![(first.to_owned(), identifier(rest).to_owned())],
            Some(_) => heads(rest)
                .into_iter()
                .map(|(second, _)| (first.to_owned(), second))
                .collect(),
        };
    };
    let (mut depth, mut start, mut found) = (0, 0, Vec::new());
    for (place, character) in group.char_indices() {
        match character {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                found.extend(heads(group[start..place].trim()));
                start = place + 1;
                if character == '}' {
                    break;
                }
            }
            _ => {}
        }
    }
    found
}

/// What a file uses of the crate: the first two parts of each path.
fn uses(path: &Path, text: &str) -> BTreeSet<(String, String)> {
    let code = code(text);
    let mut found = BTreeSet::new();
    for (place, _) in code.match_indices("crate::") {
        let is_word = code[..place].ends_with(|c: char| c.is_alphanumeric() || c == '_');
        if !is_word {
            found.extend(heads(&code[place + "crate::".len()..]));
        }
    }
    // As many `super` as there are modules lead to the root as well.
    let climb = "super::".repeat(module_path(path).len().max(1));
    for (place, _) in code.match_indices(&climb) {
        let heads = heads(code[place + climb.len()..].trim_start_matches("super::"));
        let is_module = |name: &str| MAY_USE.iter().any(|(module, _)| *module == name);
        found.extend(heads.into_iter().filter(|(first, _)| is_module(first)));
    }
    found
}

fn forbidden(path: &Path, text: &str) -> Vec<String> {
    let module = module_path(path);
    let Some(module) = module.first() else {
        return Vec::new();
    };
    let allowed = MAY_USE.iter().find(|(name, _)| name == module);
    let Some((_, allowed)) = allowed else {
        return vec![format!(
            "{}: `{module}` is not in the table",
            path.display()
        )];
    };
    let mut arrows = Vec::new();
    for (used, item) in uses(path, text) {
        let is_allowed = used == *module || allowed.contains(&used.as_str());
        let is_open = ONLY_TO.iter().all(|(from, to, items)| {
            from != module || *to != used || items.contains(&item.as_str())
        });
        if !is_allowed || !is_open {
            arrows.push(format!("{}: {module} → {used}::{item}", path.display()));
        }
    }
    if module == "oracle" {
        let code = code(text);
        let words = code.split(|c: char| !c.is_alphanumeric() && c != '_');
        let shared: BTreeSet<&str> = words.filter(|word| NOT_IN_ORACLE.contains(word)).collect();
        arrows.extend(
            shared
                .iter()
                .map(|name| format!("{}: oracle → {name}", path.display())),
        );
        let calls = NOT_CALLED_IN_ORACLE
            .iter()
            .filter(|call| code.contains(**call));
        arrows.extend(calls.map(|call| format!("{}: oracle → {call}", path.display())));
    }
    arrows
}

/// The files of the library: all but the program's.
fn library() -> Vec<PathBuf> {
    let mut files = sources("src");
    files.retain(|path| !path.starts_with("src/cli") && !path.ends_with("main.rs"));
    assert!(files.len() > 30, "{}", files.len());
    files
}

#[test]
fn only_allowed_arrows() {
    let arrows: Vec<String> = library()
        .iter()
        // What only tests may make its worlds from scenes.
        .filter(|path| !path.ends_with("tests.rs"))
        .flat_map(|path| forbidden(path, &fs::read_to_string(path).unwrap()))
        .collect();
    assert!(
        arrows.is_empty(),
        "not in the table:\n{}",
        arrows.join("\n")
    );
}

#[test]
fn the_table_has_no_circles() {
    let mut below: Vec<&str> = Vec::new();
    for (module, may_use) in MAY_USE {
        for used in may_use {
            assert!(below.contains(used), "{module} → {used} leads upwards");
        }
        below.push(module);
    }
    let lib = fs::read_to_string("src/lib.rs").unwrap();
    for module in lib.lines().filter_map(|line| line.strip_prefix("pub mod ")) {
        assert!(below.contains(&module.trim_end_matches(';')), "{module}");
    }
}

#[test]
fn files_are_short() {
    for path in sources("src").iter().chain(&sources("tests")) {
        let text = fs::read_to_string(path).unwrap();
        let lines = text.lines().take_while(|line| *line != "#[cfg(test)]");
        let lines = lines.count();
        assert!(lines <= LONGEST, "{} has {lines} lines", path.display());
    }
}

/// The reader of paths sees what it should.
#[test]
fn arrows_are_found() {
    let found = |path: &str, text: &str| forbidden(Path::new(path), text);
    for (path, text) in [
        ("src/oracle/mod.rs", "use crate::world::World;"),
        ("src/oracle/mod.rs", "use glam::DVec3;"),
        ("src/oracle/hit.rs", "use super::super::math::Point;"),
        (
            "src/oracle/value.rs",
            "use crate::spectrum::{Curve, daylight};",
        ),
        ("src/oracle/value.rs", "use crate::spectrum;"),
        ("src/oracle/value.rs", "let on_grid = curve.spectrum();"),
        (
            "src/oracle/tests/a.rs",
            "let p = crate::math::Point::new();",
        ),
        (
            "src/scene/mod.rs",
            "use crate::{\n    units::Rgb,\n    image::Film,\n};",
        ),
        ("src/units.rs", "use super::math::DVec3;"),
        ("src/display/mod.rs", "use crate::render::Options;"),
        ("src/visibility/mod.rs", "pub(in crate::shading) fn f() {}"),
        ("src/spare.rs", ""),
    ] {
        assert_eq!(found(path, text).len(), 1, "{path}: {text}");
    }
    for (path, text) in [
        (
            "src/oracle/mod.rs",
            "//! Not [`crate::world`].\nuse crate::scene::Scene;",
        ),
        (
            "src/oracle/value.rs",
            "use super::spectrum::curve;\nuse crate::spectrum::{Curve, tables};",
        ),
        ("src/scene/mesh/mod.rs", "use super::super::scene::Scene;"),
        (
            "src/display/mod.rs",
            "use crate::{image::Film, exr::{self, read}};",
        ),
        (
            "src/render/tile.rs",
            "pub(crate) use crate::{shading, world::{Plan, World}};",
        ),
        ("src/lib.rs", "pub mod math;"),
    ] {
        assert_eq!(found(path, text), [""; 0], "{path}: {text}");
    }
}
