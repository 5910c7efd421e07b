//! Who may use whom, and how long a file may be, read from the sources themselves.

mod files;
mod source;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use files::{Circle, Modules};
use source::{anchored, module_path, paths, sources, without_tests, words};

/// The modules of the library in the order in which data flows, and whom each may use. The oracle
/// shares nothing with the renderer but the scene as written and the published tables, so that no mistake
/// can hide on both sides.
const MAY_USE: [(&str, &[&str]); 29] = [
    ("units", &[]),
    ("math", &[]),
    ("emitter", &["math"]),
    ("simd", &["math"]),
    ("camera", &["math", "simd"]),
    ("color", &[]),
    ("printable", &[]),
    ("memory", &[]),
    ("output", &["printable"]),
    ("optics", &["math"]),
    ("spectrum", &["printable"]),
    ("input", &[]),
    ("mesh", &["input", "printable"]),
    ("ies", &["input", "math", "printable"]),
    (
        "scene",
        &[
            "color",
            "spectrum",
            "optics",
            "mesh",
            "ies",
            "input",
            "printable",
            "memory",
        ],
    ),
    (
        "world",
        &[
            "scene",
            "mesh",
            "ies",
            "units",
            "math",
            "camera",
            "color",
            "spectrum",
            "optics",
            "printable",
            "memory",
            "emitter",
        ],
    ),
    ("visibility", &["world", "math", "simd", "memory"]),
    (
        "shading",
        &[
            "world",
            "visibility",
            "optics",
            "spectrum",
            "units",
            "math",
            "simd",
            "emitter",
        ],
    ),
    ("turns", &[]),
    ("image", &["color"]),
    (
        "quadrature",
        &[
            "world",
            "camera",
            "visibility",
            "image",
            "math",
            "simd",
            "emitter",
        ],
    ),
    (
        "exr",
        &[
            "image",
            "input",
            "color",
            "output",
            "printable",
            "turns",
            "memory",
        ],
    ),
    (
        "render",
        &[
            "world",
            "camera",
            "visibility",
            "shading",
            "quadrature",
            "image",
            "exr",
            "math",
            "simd",
            "spectrum",
            "memory",
            "turns",
        ],
    ),
    ("compare", &["color", "memory"]),
    (
        "image_file",
        &["image", "exr", "input", "color", "printable", "memory"],
    ),
    (
        "display",
        &[
            "image",
            "exr",
            "image_file",
            "input",
            "color",
            "simd",
            "memory",
            "output",
            "printable",
        ],
    ),
    (
        "relight",
        &[
            "world",
            "scene",
            "spectrum",
            "exr",
            "output",
            "printable",
            "turns",
            "memory",
        ],
    ),
    ("bench", &["world", "visibility", "math", "simd"]),
    ("oracle", &["scene", "mesh", "ies", "spectrum", "optics"]),
];

/// Arrows that are only to some items: who, to whom, to what there.
const ONLY_TO: [(&str, &str, &[&str]); 2] = [
    // What was published and what was written, not what the renderer makes of it.
    (
        "oracle",
        "spectrum",
        &["tables", "Curve", "Lines", "Observer"],
    ),
    // The published numbers of glasses and metals.
    ("oracle", "optics", &["Glass", "Metal"]),
];

/// Methods by which those items give away what the oracle computes itself.
const NOT_CALLED_IN_ORACLE: [&str; 10] = [
    ".primaries(",
    "::primaries(",
    ".spectrum(",
    "::spectrum(",
    ".color_matching(",
    "::color_matching(",
    ".luminous_efficacy(",
    "::luminous_efficacy(",
    "dispersion.index(",
    "known.index(",
];

/// Crates that the oracle must not share with the renderer.
const NOT_IN_ORACLE: [&str; 4] = ["glam", "libm", "rayon", "half"];

/// Lines of a file before its unit tests. The aim is 600; beyond this it is time to part it.
const LONGEST: usize = 650;

/// What a file uses of the crate: the first two parts of each path.
fn uses(path: &Path, words: &[&str]) -> BTreeSet<(String, String)> {
    let module = module_path(path);
    let mut found = BTreeSet::new();
    for path in paths(words) {
        let (above, rest) = anchored(&module, &path.parts);
        let parts = above.iter().map(String::as_str).chain(rest.iter().copied());
        let mut parts = parts.filter(|part| *part != "self");
        let (first, second) = (parts.next().unwrap_or(""), parts.next().unwrap_or(""));
        let is_told = match path.parts[0] {
            "crate" => !first.is_empty(),
            // As many `super` as there are modules lead to the root as well. (A module within the file has
            // one more.)
            "super" => MAY_USE.iter().any(|(module, _)| *module == first),
            _ => false,
        };
        if is_told {
            found.insert((first.to_owned(), second.to_owned()));
        }
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
    let mut words = words(text);
    if module != "oracle" {
        // What only tests may make its worlds from scenes; those of the oracle are to use no more than it does.
        words = without_tests(&words);
    }
    for (used, item) in uses(path, &words) {
        let is_allowed = used == *module || allowed.contains(&used.as_str());
        let is_open = ONLY_TO.iter().all(|(from, to, items)| {
            from != module || *to != used || items.contains(&item.as_str())
        });
        if !is_allowed || !is_open {
            arrows.push(format!("{}: {module} → {used}::{item}", path.display()));
        }
    }
    if module == "oracle" {
        let shared = words.iter().filter(|word| NOT_IN_ORACLE.contains(word));
        let shared: BTreeSet<&str> = shared.copied().collect();
        arrows.extend(
            shared
                .iter()
                .map(|name| format!("{}: oracle → {name}", path.display())),
        );
        let code = words.concat();
        let calls = NOT_CALLED_IN_ORACLE.iter();
        let calls = calls.filter(|call| code.contains(**call));
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

/// Whether a file is a module of tests, or below one.
fn is_of_tests(path: &Path) -> bool {
    module_path(path).iter().any(|part| part == "tests")
}

#[test]
fn only_allowed_arrows() {
    let arrows: Vec<String> = library()
        .iter()
        .filter(|path| path.starts_with("src/oracle") || !is_of_tests(path))
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
    let declared = lib.lines().filter_map(|line| {
        let line = line.strip_prefix("pub ").unwrap_or(line);
        line.strip_prefix("mod ")?.strip_suffix(';')
    });
    for module in declared {
        assert!(below.contains(&module), "{module}");
    }
}

/// What of the tables is not among the arrows: who, to whom, to what there.
fn unused(used: &BTreeSet<(String, String, String)>) -> Vec<String> {
    let mut unused = Vec::new();
    for (from, may_use) in MAY_USE {
        let is_used = |to: &&&str| used.iter().any(|(a, b, _)| a == from && b == **to);
        let spare = may_use.iter().filter(|to| !is_used(to));
        unused.extend(spare.map(|to| format!("{from} → {to}")));
    }
    for (from, to, items) in ONLY_TO {
        let arrow = |item: &str| (from.to_owned(), to.to_owned(), item.to_owned());
        let spare = items.iter().filter(|item| !used.contains(&arrow(item)));
        unused.extend(spare.map(|item| format!("{from} → {to}::{item}")));
    }
    unused
}

/// An arrow that nobody uses is not allowed any more: what is in the table is how the house is.
#[test]
fn every_allowed_arrow_is_used() {
    let mut used = BTreeSet::new();
    for path in library() {
        let module = module_path(&path);
        let Some(module) = module.first().filter(|_| !is_of_tests(&path)) else {
            continue;
        };
        let text = fs::read_to_string(&path).unwrap();
        let uses = uses(&path, &without_tests(&words(&text)));
        used.extend(
            uses.into_iter()
                .map(|(to, item)| (module.clone(), to, item)),
        );
    }
    let unused = unused(&used);
    assert!(unused.is_empty(), "nobody uses:\n{}", unused.join("\n"));
    // And it would find one.
    used.retain(|(from, to, _)| (from.as_str(), to.as_str()) != ("oracle", "spectrum"));
    assert!(self::unused(&used).contains(&"oracle → spectrum".to_owned()));
    assert!(self::unused(&used).contains(&"oracle → spectrum::Curve".to_owned()));
}

/// The table that a reader sees is this one, and the page is one that is read.
#[test]
fn the_architecture_has_this_table() {
    let page = fs::read_to_string("ARCHITECTURE.md").unwrap();
    assert!(page.lines().count() <= 250);
    let mut found = BTreeSet::new();
    for row in page.lines().filter(|line| line.starts_with("| `")) {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let [_, modules, _, may_use, _] = cells[..] else {
            continue;
        };
        // In parentheses is what of it, or why.
        let without_remarks = may_use.split(['(', ')']).step_by(2);
        let names: BTreeSet<String> = without_remarks
            .flat_map(|part| part.split(','))
            .map(|name| name.trim().to_owned())
            .filter(|name| !["", "–"].contains(&name.as_str()))
            .collect();
        found.insert((modules.replace('`', ""), names));
    }
    let cli = ("cli".to_owned(), BTreeSet::from(["all".to_owned()]));
    let table = MAY_USE.iter().map(|(module, may_use)| {
        let may_use = may_use.iter().map(|&used| used.to_owned());
        ((*module).to_owned(), may_use.collect())
    });
    let table: BTreeSet<_> = table.chain([cli]).collect();
    let told = |ours: &BTreeSet<(String, BTreeSet<String>)>, theirs| -> Vec<String> {
        let rows = ours.difference(theirs);
        rows.map(|row| format!("{row:?}")).collect()
    };
    assert_eq!(told(&table, &found), [""; 0], "not in ARCHITECTURE.md");
    assert_eq!(told(&found, &table), [""; 0], "only in ARCHITECTURE.md");
}

/// Files of one module are used in one direction.
#[test]
fn files_have_no_circles() {
    let files = sources("src").into_iter().map(|path| {
        let text = fs::read_to_string(&path).unwrap();
        (path.to_string_lossy().into_owned(), text)
    });
    let files: Vec<(String, String)> = files.collect();
    let modules = Modules::read(
        files
            .iter()
            .map(|(path, text)| (path.as_str(), text.as_str())),
    );
    assert_eq!(
        modules.globs, [""; 0],
        "from these nobody can tell who uses whom"
    );
    let told: String = modules.circles().iter().map(Circle::told).collect();
    assert!(told.is_empty(), "\n{told}");
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
            "src/oracle/smooth.rs",
            "let f = crate::optics::dielectric(c, eta);",
        ),
        ("src/oracle/smooth.rs", "let n = known.index(nm);"),
        (
            "src/oracle/tests/a.rs",
            "let p = crate::math::Point::new();",
        ),
        (
            "src/scene/mod.rs",
            "use crate::{\n    spectrum::Curve,\n    image::Film,\n};",
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
        ("src/scene/read/mod.rs", "use super::super::scene::Scene;"),
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
