//! Circles between the files of a module: who of them uses whom, by whatever way it is written.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use super::source::{Path, anchored, module_path, paths, without_tests, words};

/// A path of modules from the root on.
type Module = Vec<String>;

/// What a name in a module stands for: a path, as an import has it.
type Imports = BTreeMap<String, Vec<String>>;

/// All modules of a crate, each a file.
#[derive(Debug, Default)]
pub(crate) struct Modules {
    /// What each imports or hands on, by the name that it has there.
    imports: BTreeMap<Module, Imports>,
    /// What each names, imports included, with where it was read.
    paths: Vec<(Module, Vec<String>)>,
    /// Imports of all there is, from which nobody can tell who uses whom.
    pub(crate) globs: Vec<String>,
}

/// What is used, where it was asked for.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Arrow {
    file: String,
    item: String,
}

/// The files of one module that lead to each other, and by what.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Circle {
    pub(crate) module: String,
    pub(crate) files: BTreeSet<String>,
    arrows: BTreeMap<(String, String), BTreeSet<Arrow>>,
}

impl Modules {
    /// Reads files: where each is, and what is in it.
    pub(crate) fn read<'text>(files: impl IntoIterator<Item = (&'text str, &'text str)>) -> Self {
        let mut modules = Self::default();
        for (path, text) in files {
            let module = module_path(path.as_ref());
            if !module.iter().any(|part| part == "tests") {
                modules.add(&module, &without_tests(&words(text)));
            }
        }
        modules
    }

    fn add(&mut self, module: &Module, words: &[&str]) {
        let owned = |path: &[&str]| path.iter().map(|&part| part.to_owned()).collect();
        let imports = self.imports.entry(module.clone()).or_default();
        for Path { mut parts, name } in paths(words) {
            if parts.last() == Some(&"*") {
                if ["self", "super", "crate"].contains(&parts[0]) {
                    let glob = format!("{}: {}", module.join("::"), parts.join("::"));
                    self.globs.push(glob);
                }
                continue;
            }
            // `a::{self, b}` is a, and a::b.
            parts.pop_if(|last| name.is_some() && *last == "self");
            if let Some(name) = name {
                imports.insert(name.to_owned(), owned(&parts));
            }
            self.paths.push((module.clone(), owned(&parts)));
        }
    }

    /// The module in which is what a path means, and whether the path means that module itself. What is not
    /// found is the module's own, or another crate's. `None`: a name that is imported from itself.
    fn resolve(&self, from: &[String], path: &[String], steps: usize) -> Option<(Module, bool)> {
        let steps = steps.checked_sub(1)?;
        let (mut module, mut rest) = anchored(from, path);
        while let [first, after @ ..] = rest {
            let child = [module.as_slice(), std::slice::from_ref(first)].concat();
            if self.imports.contains_key(&child) {
                (module, rest) = (child, after);
            } else if let Some(imported) = self.imports.get(&module)?.get(first) {
                let (target, is_module) = self.resolve(&module, imported, steps)?;
                if !is_module {
                    return Some((target, false));
                }
                (module, rest) = (target, after);
            } else {
                return Some((module, false));
            }
        }
        Some((module, true))
    }

    /// Who uses whom among the files of each module: a file stands for all that is below it, and what is
    /// handed on by the parent counts where it comes from. Parent and child may use each other.
    fn arrows(&self) -> BTreeMap<Module, BTreeMap<(String, String), BTreeSet<Arrow>>> {
        let mut found: BTreeMap<Module, BTreeMap<_, BTreeSet<Arrow>>> = BTreeMap::new();
        for (from, path) in &self.paths {
            let Some((to, _)) = self.resolve(from, path, 20) else {
                continue;
            };
            let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
            if let (Some(a), Some(b)) = (from.get(shared), to.get(shared)) {
                let arrows = found.entry(from[..shared].to_vec()).or_default();
                let arrow = Arrow {
                    file: from[shared..].join("::"),
                    item: path.last().cloned().unwrap_or_default(),
                };
                let ends = (a.clone(), b.clone());
                arrows.entry(ends).or_default().insert(arrow);
            }
        }
        found
    }

    /// The circles in each module: files of which each leads to each.
    pub(crate) fn circles(&self) -> Vec<Circle> {
        let mut circles = Vec::new();
        for (module, arrows) in self.arrows() {
            let files: BTreeSet<&String> = arrows.keys().flat_map(|(a, b)| [a, b]).collect();
            let reached = |from: &String| -> BTreeSet<String> {
                let mut reached = BTreeSet::new();
                let mut open = vec![from.clone()];
                while let Some(file) = open.pop() {
                    for (a, b) in arrows.keys() {
                        if *a == file && reached.insert(b.clone()) {
                            open.push(b.clone());
                        }
                    }
                }
                reached
            };
            let reached: BTreeMap<&String, BTreeSet<String>> =
                files.iter().map(|&file| (file, reached(file))).collect();
            let mut seen: BTreeSet<&String> = BTreeSet::new();
            for &file in &files {
                if !reached[file].contains(file) || seen.contains(file) {
                    continue;
                }
                let circle = files.iter().copied();
                let circle = circle.filter(|&other| {
                    reached[file].contains(other) && reached[other].contains(file)
                });
                let circle: BTreeSet<&String> = circle.collect();
                seen.extend(&circle);
                let mut inside = arrows.clone();
                inside.retain(|(a, b), _| circle.contains(a) && circle.contains(b));
                circles.push(Circle {
                    module: module.join("::"),
                    files: circle.iter().map(|&file| file.clone()).collect(),
                    arrows: inside,
                });
            }
        }
        circles
    }
}

impl Circle {
    /// The circle as one reads it: its files, then each arrow with what is used where.
    pub(crate) fn told(&self) -> String {
        let files: Vec<&str> = self.files.iter().map(String::as_str).collect();
        let mut told = format!("`{}` has a circle: {}\n", self.module, files.join(", "));
        for ((from, to), arrows) in &self.arrows {
            let mut by_file: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
            for Arrow { file, item } in arrows {
                by_file.entry(file).or_default().push(item);
            }
            for (file, items) in by_file {
                let inside = if file == from {
                    String::new()
                } else {
                    format!(" (in {file})")
                };
                let _ = writeln!(told, "    {from} → {to}{inside}: {}", items.join(", "));
            }
        }
        told
    }
}

/// The reader of paths sees what it should, and no more.
#[test]
fn circles_are_found() {
    let found = |files: &[(&str, &str)]| -> Vec<String> {
        let circles = Modules::read(files.iter().copied()).circles();
        let files = |circle: Circle| circle.files.into_iter().collect::<Vec<_>>().join(" ");
        circles.into_iter().map(files).collect()
    };
    let parent = (
        "src/m/mod.rs",
        "mod a; mod b; pub(super) use b::B; struct M;",
    );
    let b_leads_to_a = ("src/m/b.rs", "use super::a::A; pub struct B;");
    for a in [
        "use super::b::C;",
        "use super::{M, b::{self}};",
        "use super::{M, b::{C as D}};",
        "use crate::m::b;",
        "pub use self::super::b::C;",
        "fn f() -> super::b::C { todo!() }",
        "impl Iterator for crate::m::b::C {}",
        "const ALL: [super::b::C; 1] = [];",
        "let c = 2 * super::b::C;",
        "fn f<'l>(c: &'l super::b::C) {}",
        "let x = 'x'; let y = super::b::C;",
        "fn f() { use super::b::C; }",
        // Handed on by the parent.
        "use super::B;",
        "use crate::m::B;",
        "use super::{M, B};",
        "use super::B as D;",
        "let b = super::B::new();",
        // By a name for the module.
        "use crate::m as parent; let c = parent::B;",
    ] {
        let files = [parent, b_leads_to_a, ("src/m/a.rs", a)];
        assert_eq!(found(&files), ["a b"], "{a}");
    }
    for a in [
        "use super::M;",
        "use glam::b::C;",
        "// use super::b::C;",
        "let text = \"super::b::C\";",
        "let text = r#\"\" super::b::C\"#;",
        "#[cfg(test)] mod tests { use super::super::b::C; }",
        "#[cfg(test)] use super::b::C;",
        "pub(in crate::m) fn f() {}",
        "let c = b::C; let d = self.b.c;",
        "mod deep; use deep::C;",
        "fn f(x: super::M) -> impl Fn() + use<'_> {}",
    ] {
        let files = [parent, b_leads_to_a, ("src/m/a.rs", a)];
        assert_eq!(found(&files), [""; 0], "{a}");
    }
    // Deeper files count for the one that they are under.
    let deep = ("src/m/a/deep/mod.rs", "use super::super::b::C;");
    let up = ("src/m/b/up.rs", "use crate::m::a::deep;");
    let a = ("src/m/a/mod.rs", "mod deep;");
    assert_eq!(found(&[parent, a, deep, ("src/m/b.rs", ""), up]), ["a b"]);
    assert_eq!(found(&[parent, a, deep, ("src/m/b.rs", "")]), [""; 0]);
    // Tests may use what they like; a parent and its child each other.
    let tests = ("src/m/a/tests.rs", "use super::super::b::C;");
    assert_eq!(found(&[parent, a, tests, b_leads_to_a]), [""; 0]);
    let child = ("src/m/a/deep.rs", "use super::A; use super::super::M;");
    assert_eq!(found(&[parent, a, child]), [""; 0]);
    // Around three corners, and two circles side by side.
    let around = [
        ("src/a.rs", "use crate::b::B;"),
        ("src/b.rs", "use super::c::C;"),
        ("src/c.rs", "use crate::{a::A, d};"),
        ("src/d.rs", "use crate::e::E;"),
        ("src/e.rs", "use crate::d::D;"),
    ];
    assert_eq!(found(&around), ["a b c", "d e"]);
}

#[test]
fn a_circle_is_told() {
    let circles = Modules::read([
        ("src/m/mod.rs", ""),
        ("src/m/a/mod.rs", ""),
        ("src/m/a/deep.rs", "use crate::m::b::{B, C};"),
        ("src/m/b.rs", "use super::a::A;"),
    ])
    .circles();
    let told: Vec<String> = circles.iter().map(Circle::told).collect();
    let expected = "`m` has a circle: a, b\n    a → b (in a::deep): B, C\n    b → a: A\n";
    assert_eq!(told, [expected]);
}

#[test]
fn imports_of_everything_are_told() {
    let files = [("src/m/a.rs", "use super::b::*; use rayon::prelude::*;")];
    assert_eq!(Modules::read(files).globs, ["m::a: super::b::*"]);
}
