//! Scene files that are damaged, or made to be expensive.

use std::fs;
use std::path::Path;

use candela::oracle::Oracle;
use candela::scene::{Diagnostics, Reading, Scene};
use candela::world::World;

use crate::fuzzing;
use crate::images::scene_files;

/// Where a mesh and a curve are.
const FOLDER: &str = "tests/bad_scenes";

/// Cases by default: `CANDELA_FUZZ` is for more.
const CASES: u64 = 20_000;

/// A scene with everything that a file can have, its mesh a single triangle.
const ALL_SECTIONS: &str = r##"
[image]
resolution = [64, 48]
color_space = "rec709"
background = "#204060"
transport = "auto"

[camera.orthographic]
eye = [0, 1, 5]
look_at = [0, 0.5, 0]
up = [0, 1, 0]
height = 3.0

[materials.matte.normalized_phong]
diffuse = { rgb = [0.25, 0.5, 0.125], space = "rec709" }
specular = 0.25
shininess = 1e2

[lights.key.point]
position = [1, 2, 3]
intensity = [10.0, 20.0, 30.0]

[objects.wing.triangle]
material = "matte"
vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]

[objects.tile.mesh]
material = "matte"
file = "triangle.obj"
scale = [1, -2, 0.5]
rotate = [10, 20, 30]
translate = [0, 0.5, 0]
smooth = false
"##;

/// A scene with every notation for light and color that [`ALL_SECTIONS`] has not.
const ALL_NOTATIONS: &str = r##"
[image]
resolution = [64, 48]
color_space = "acescg"
observer = "1964"
background = { lines = [[589.0, 5e-4], [589.6, 2.5e-4]] }
transport = "spectral"

[camera.perspective]
eye = [0, 1, 5]
look_at = [0, 0.5, 0]
vertical_fov = 40

[materials]
cloth.phong = { diffuse = { wavelengths = [400, 550.5, 700], values = [0.1, 0.9, 0] } }
paint.normalized_phong = { diffuse = { file = "curve.csv" } }
glaze.phong = { diffuse = "#c86432", specular = [3, 2, 2.5], shininess = 9.5 }

[lights]
a.point = { position = [1, 2, 3], intensity = { candela = 120, color = { illuminant = "F11" } } }
b.point = { position = [1, 2, 3], intensity = { lumens = 8e2, color = { daylight = 5600 } } }
c.point = { position = [1, 2, 3], intensity = { watts_per_steradian = 0.5, color = { blackbody = 3200 } } }
d.point = { position = [1, 2, 3], intensity = { watts = 6, color = { rgb = [1, 0.5, 0.25], space = "p3-d65" } } }
e.point = { position = [1, 2, 3], intensity = { watts_per_steradian_nm = 0.002 } }
f.point = { position = [1, 2, 3], intensity = { watts_per_steradian_nm = { file = "curve.csv" } } }
g.point = { position = [1, 2, 3], intensity = { lines = [[436, 0.25], [546.1, 0.125]] } }

[objects]
ball.sphere = { material = "cloth", center = [0, 0, 0], radius = 1 }
floor.plane = { material = "paint", point = [0, 0, 0], normal = [0, 1, 0] }
wall.plane = { material = "glaze", point = [0, 0, -3], normal = [0, 0, 1] }
"##;

/// The files of `scenes/` that are whole without another file: to read those over and over is for
/// another test. And what they leave out.
pub(crate) fn legal() -> Vec<Vec<u8>> {
    let files = scene_files().into_iter();
    let whole = files.filter(|path| Scene::load(path).unwrap().files().len() == 1);
    let mut scenes: Vec<Vec<u8>> = whole.map(|path| fs::read(path).unwrap()).collect();
    assert!(scenes.len() >= 10, "{}", scenes.len());
    scenes.extend([ALL_SECTIONS, ALL_NOTATIONS].map(|text| text.as_bytes().to_vec()));
    scenes
}

/// Legal scenes, and those that are wrong in one way each.
fn corpus() -> Vec<Vec<u8>> {
    let bad = fs::read_dir(FOLDER).unwrap();
    let mut paths: Vec<_> = bad.map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|found| found == "toml"));
    paths.sort();
    assert!(paths.len() >= 40);
    let mut corpus: Vec<Vec<u8>> = paths.iter().map(|path| fs::read(path).unwrap()).collect();
    // Legal scenes as often as all the others, or few cases would come far.
    let wrong = corpus.len();
    corpus.extend(legal().into_iter().cycle().take(wrong));
    corpus
}

/// The world, or the messages; with the mesh in reach.
fn read(bytes: &[u8]) -> Result<World, Diagnostics> {
    let text = String::from_utf8_lossy(bytes).into_owned();
    let scene = Reading::of_text(text, &Path::new(FOLDER).join("fuzzed.toml")).complete()?;
    World::new(&scene).map(|(world, _)| world)
}

#[test]
fn the_corpus_has_legal_scenes() {
    for text in legal() {
        let shown = String::from_utf8_lossy(&text);
        assert_eq!(fuzzing::check(&text, read), Ok(true), "{shown}");
    }
}

/// Numbers of consequence for temperatures, wavelengths and amounts.
const NUMBERS: [&str; 9] = [
    "0", "1", "-1", "0.5", "830", "4000", "1e308", "5e-324", "nan",
];

/// Tables that are, or nearly are, values; `#` is to be a number.
const NOTATIONS: [&str; 34] = [
    "#",
    "[#, 0.5, 0.25]",
    "[#, #, #]",
    "{ rgb = [0.5, #, 0.25], space = \"rec709\" }",
    "{ rgb = [0.5, #, 0.25], space = \"p3-d65\" }",
    "{ rgb = [#, 0.25, 0.25], space = \"rec2020\" }",
    "{ rgb = [#, 0, 0], space = \"acescg\" }",
    "{ rgb = [0, 0.1, #], space = \"acescg\" }",
    "{ illuminant = \"D65\" }",
    "{ illuminant = # }",
    "{ daylight = # }",
    "{ blackbody = # }",
    "{ wavelengths = [400, #], values = [0.5, 0.25] }",
    "{ wavelengths = [#, 700], values = [0.5, 0.25] }",
    "{ wavelengths = [400, 700], values = [#, 0.25] }",
    "{ wavelengths = [400, 700], values = [#, #] }",
    "{ wavelengths = [#], values = [0.5] }",
    "{ wavelengths = [], values = [] }",
    "{ wavelengths = [400, 700], values = # }",
    "{ file = \"curve.csv\" }",
    "{ file = \"triangle.obj\" }",
    "{ file = \".\" }",
    "{ lines = [[#, 0.5]] }",
    "{ lines = [[500, #]] }",
    "{ lines = [] }",
    "{ candela = # }",
    "{ candela = #, color = [0, 0, 0] }",
    "{ candela = 3, color = { blackbody = # } }",
    "{ candela = 1, color = { candela = # } }",
    "{ lumens = #, color = { rgb = [0, 0, 1], space = \"p3-d65\" } }",
    "{ watts = #, color = { daylight = 5000 } }",
    "{ watts_per_steradian = #, color = { lines = [[500, 0]] } }",
    "{ watts_per_steradian_nm = # }",
    "{ watts_per_steradian_nm = { wavelengths = [300, 900], values = [#, 1] } }",
];

/// A small scene with places for values.
const PLACES: &str = "
[image]
resolution = [2, 2]
transport = \"TRANSPORT\"
background = BACKGROUND

[camera.orthographic]
eye = [0, 0, 5]
look_at = [0, 0, 0]
height = 3

[materials.m.MODEL]
diffuse = DIFFUSE
specular = SPECULAR
shininess = 10

[lights.l.point]
position = [1, 2, 3]
intensity = INTENSITY

[objects.o.sphere]
material = \"m\"
center = [0, 0, 0]
radius = 1
";

/// Any value anywhere is taken or refused, with a message. The oracle gives some number for what is
/// refused.
#[test]
fn values_of_every_kind_in_every_place() {
    let read = |bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes).into_owned();
        let scene = Reading::of_text(text, &Path::new(FOLDER).join("fuzzed.toml")).complete()?;
        Oracle::new(&scene).radiance(1.0, 1.0);
        World::new(&scene)
    };
    let (mut accepted, mut refused) = (0, 0);
    for (i, notation) in NOTATIONS.iter().enumerate() {
        let numbers = if notation.contains('#') {
            NUMBERS.len()
        } else {
            1
        };
        for (j, number) in NUMBERS[..numbers].iter().enumerate() {
            let value = notation.replace('#', number);
            for (k, place) in ["BACKGROUND", "DIFFUSE", "SPECULAR", "INTENSITY"]
                .iter()
                .enumerate()
            {
                let transport = ["auto", "rgb", "spectral"][(i + j + k) % 3];
                let model = ["phong", "normalized_phong"][(i + j) % 2];
                let text = PLACES
                    .replace(place, &value)
                    .replace("TRANSPORT", transport)
                    .replace("MODEL", model)
                    .replace("INTENSITY", "10")
                    .replace("SPECULAR", "0.25")
                    .replace("DIFFUSE", "0.5")
                    .replace("BACKGROUND", "0");
                match fuzzing::check(text.as_bytes(), read) {
                    Ok(true) => accepted += 1,
                    Ok(false) => refused += 1,
                    Err(broken) => panic!("{broken}\n{text}"),
                }
            }
        }
    }
    println!("{accepted} accepted, {refused} refused");
    assert!(accepted > 150 && refused > 150, "{accepted} {refused}");
}

#[test]
fn damaged_scenes() {
    let corpus = corpus();
    let corpus: Vec<&[u8]> = corpus.iter().map(Vec::as_slice).collect();
    let outcomes = fuzzing::run("scene", &corpus, CASES, read);
    // Both ends must be reached, or the mutations are too timid or too wild.
    assert!(outcomes.accepted * 100 > outcomes.refused, "{outcomes:?}");
    assert!(outcomes.refused * 2 > outcomes.accepted, "{outcomes:?}");
}

/// Whatever the bytes, a file is read as its text is: also where they are not UTF-8, as most
/// mutations of binary numbers are not.
#[test]
fn damaged_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fuzzed.toml");
    let corpus = corpus();
    let corpus: Vec<&[u8]> = corpus.iter().map(Vec::as_slice).collect();
    let outcomes = fuzzing::run("scene-file", &corpus, CASES / 20, |bytes| {
        fs::write(&path, bytes).unwrap();
        World::load(&path).map(|loaded| loaded.world)
    });
    assert!(
        outcomes.accepted > 0 && outcomes.refused > 0,
        "{outcomes:?}"
    );
}

/// Files of 300 kB whose form is simple and whose cost would be anything but linear in a careless
/// reader.
#[test]
fn expensive_scenes() {
    const SIZE: usize = 300_000;
    let lecture = &Scene::builtin().source.text;
    let repeated = |part: &str| part.repeat(SIZE / part.len());
    let numbered = |part: &str| -> String {
        (0..SIZE / part.len())
            .map(|number| part.replace('#', &number.to_string()))
            .collect()
    };
    for (name, text) in [
        ("open arrays", format!("[image]\na = {}", repeated("["))),
        ("open tables", format!("[image]\na = {}", repeated("{a="))),
        ("headers", repeated("[image]\n")),
        ("a deep header", format!("[{}a]", repeated("a."))),
        (
            "unknown keys",
            format!("[image]\n{}", numbered("key_# = 1\n")),
        ),
        ("unknown sections", numbered("[section_#]\n")),
        (
            "unknown materials",
            format!(
                "{lecture}{}",
                numbered(
                    "[objects.o#.sphere]\nmaterial = \"m#\"\ncenter = [0, 0, 0]\nradius = 1\n"
                )
            ),
        ),
        (
            "bad values",
            format!("{lecture}{}", numbered("[lights.l#.point]\nposition = 1\n")),
        ),
        (
            "a long name",
            format!("[materials.{}.phong]\n", "x".repeat(SIZE)),
        ),
        (
            "a long string",
            format!("[image]\ncolor_space = \"{}\"\n", "y".repeat(SIZE)),
        ),
        (
            "a long number",
            format!("[image]\nresolution = [{}, 1]\n", "9".repeat(SIZE)),
        ),
        ("comments", repeated("# comment\n")),
        ("quotes", repeated("\"")),
        (
            "commas",
            format!("[image]\nresolution = [{}]", repeated("1,")),
        ),
        (
            "inline",
            format!("[image]\nbackground = {{ {} }}", numbered("rgb# = 1, ")),
        ),
        ("no line end", "x".repeat(SIZE)),
        ("returns", repeated("\r")),
        (
            "legal",
            format!(
                "{lecture}{}",
                numbered(
                    "[objects.o#.sphere]\nmaterial = \"clay\"\ncenter = [#, 0, 0]\nradius = 1\n",
                )
            ),
        ),
    ] {
        match fuzzing::check(text.as_bytes(), read) {
            Ok(is_accepted) => assert_eq!(is_accepted, name == "legal", "`{name}`"),
            Err(broken) => panic!("`{name}` {broken}"),
        }
    }
}

/// As many lights as materials: their products are one for each pair.
#[test]
fn many_lights_on_many_materials() {
    let mut text = Scene::builtin().source.text.clone();
    for number in 0..1000 {
        text += &format!("[materials.m{number}.phong]\ndiffuse = 0.5\n");
        text += &format!("[lights.l{number}.point]\nposition = [0, 9, 0]\nintensity = 1\n");
    }
    assert_eq!(fuzzing::check(text.as_bytes(), read), Ok(true));
}
