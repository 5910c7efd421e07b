//! What is read from scenes that are right, and how hostile ones end.

use std::time::{Duration, Instant};

use super::*;
use crate::scene::{Camera, ColorSpace, Light, Material, Object, Value};

/// The whole format in one file.
const EVERYTHING: &str = r#"
[image]
resolution = [1280, 720]
color_space = "rec709"
background = [0, 0, 0]
transport = "auto"

[camera.perspective]
eye = [0.0, 1.2, 4.0]
look_at = [0.0, 0.6, 0.0]
up = [0.0, 1.0, 0.0]
vertical_fov = 40.0

[materials.clay.phong]
diffuse = [0.7, 0.3, 0.2]
specular = 0.3
shininess = 50

[materials.chalk.normalized_phong]

[lights.key.point]
position = [3, 4, 3]
intensity = [30, 30, 30]

[objects.ball.sphere]
material = "clay"
center = [0, 0.5, 0]
radius = 0.5

[objects.floor.plane]
material = "clay"
point = [0, 0, 0]
normal = [0, 1, 0]

[objects.wing.triangle]
material = "clay"
vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]

[objects.dragon.mesh]
material = "clay"
file = "triangle.obj"
scale = 10.0
translate = [0.0, -0.5, 0.0]
smooth = true

[objects.dragon2.mesh]
material = "chalk"
file = "triangle.obj"
scale = [1, 2, 3]
rotate = [0, 90, 0]
smooth = false
"#;

/// A scene in a folder that has the mesh of [`EVERYTHING`].
const PATH: &str = "tests/bad_scenes/scene.toml";

/// What every scene needs.
const FRAME: &str = "[image]\nresolution = [8, 8]\n\
                     [camera.orthographic]\neye = [0, 0, 1]\nlook_at = [0, 0, 0]\nheight = 2\n";

fn scene(text: &str) -> Scene {
    Scene::parse(text, PATH).unwrap_or_else(|error| panic!("{error}"))
}

fn errors(text: &str) -> Vec<(String, (usize, usize))> {
    let reading = Reading::of_text(text.to_owned(), Path::new(PATH));
    let source = Arc::clone(&reading.source);
    let Some(diagnostics) = Diagnostics::new(reading.source, reading.diagnostics) else {
        return Vec::new();
    };
    let place = |span: Span| source.line_column(span.start);
    diagnostics
        .list()
        .iter()
        .map(|diagnostic| (diagnostic.problem.to_string(), place(diagnostic.span)))
        .collect()
}

/// The text that a span covers.
fn covered<T>(scene: &Scene, spanned: &Spanned<T>) -> String {
    scene.source.text[spanned.span.start..spanned.span.end].to_owned()
}

fn diffuse(value: &str) -> Value {
    let scene = scene(&format!(
        "{FRAME}[materials.clay.phong]\ndiffuse = {value}\n"
    ));
    match &scene.materials[0].value {
        Material::Phong(lobes) => {
            assert_eq!(covered(&scene, &lobes.diffuse), value);
            lobes.diffuse.value.clone()
        }
        Material::NormalizedPhong(_)
        | Material::Mirror(_)
        | Material::Metal(_)
        | Material::Glass(_)
        | Material::Pane(_) => panic!("another material"),
    }
}

#[test]
fn the_whole_format() {
    let scene = scene(EVERYTHING);
    assert_eq!(scene.image.resolution.value, [1280, 720]);
    assert_eq!(scene.image.color_space.value, ColorSpace::Rec709);
    assert_eq!(covered(&scene, &scene.camera), "[camera.perspective]");
    let Camera::Perspective { view, vertical_fov } = &scene.camera.value else {
        panic!("another camera");
    };
    assert_eq!(view.eye.value, [0.0, 1.2, 4.0]);
    assert_eq!(view.look_at.value, [0.0, 0.6, 0.0]);
    assert_eq!(view.up.value, [0.0, 1.0, 0.0]);
    assert_eq!(vertical_fov.value, 40.0);

    let names: Vec<&str> = scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["clay", "chalk"]);
    let Material::Phong(clay) = &scene.materials[0].value else {
        panic!("another material");
    };
    let rgb = |rgb| Value::Rgb {
        rgb,
        space: ColorSpace::Rec709,
    };
    assert_eq!(clay.diffuse.value, rgb([0.7, 0.3, 0.2]));
    assert_eq!(clay.specular.value, Value::Uniform(0.3));
    assert_eq!(clay.shininess.map(|n| n.value), Some(50.0));
    let Material::NormalizedPhong(chalk) = &scene.materials[1].value else {
        panic!("another material");
    };
    assert_eq!(chalk.diffuse.value, Value::ZERO);
    assert_eq!(chalk.shininess, None);
    // A default points at the entry that leaves it out.
    assert_eq!(
        covered(&scene, &chalk.diffuse),
        "[materials.chalk.normalized_phong]"
    );

    let Light::Point {
        position,
        intensity,
        group: None,
    } = &scene.lights[0].value
    else {
        panic!("the light is a point");
    };
    assert_eq!(scene.lights[0].name, "key");
    assert_eq!(position.value, [3.0, 4.0, 3.0]);
    assert_eq!(intensity.value, rgb([30.0; 3]));

    let [ball, floor, wing, dragon, dragon2] = scene.objects.as_slice() else {
        panic!("five objects");
    };
    assert!(
        matches!(&ball.value, Object::Sphere { center, radius, material }
        if center.value == [0.0, 0.5, 0.0] && radius.value == 0.5 && material.value == "clay")
    );
    assert!(matches!(&floor.value, Object::Plane { point, normal, .. }
        if point.value == [0.0; 3] && normal.value == [0.0, 1.0, 0.0]));
    assert!(matches!(&wing.value, Object::Triangle { vertices, .. }
        if vertices.value == [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]));
    let Object::Mesh {
        file,
        scale,
        rotate,
        translate,
        smooth: true,
        geometry,
        ..
    } = &dragon.value
    else {
        panic!("another object");
    };
    assert_eq!(file.value, Path::new("triangle.obj"));
    assert_eq!(scale.value, [10.0; 3]);
    assert_eq!(rotate.value, [0.0; 3]);
    assert_eq!(translate.value, [0.0, -0.5, 0.0]);
    let Object::Mesh {
        scale,
        rotate,
        smooth: false,
        geometry: again,
        ..
    } = &dragon2.value
    else {
        panic!("another object");
    };
    assert_eq!(scale.value, [1.0, 2.0, 3.0]);
    assert_eq!(rotate.value, [0.0, 90.0, 0.0]);
    // One file is read once, however many objects name it.
    assert!(Arc::ptr_eq(geometry, again));
}

#[test]
fn the_builtin_scene_is_the_lecture_scene() {
    let scene = Scene::builtin();
    assert_eq!(scene.source.path, Path::new("<lecture.toml>"));
    assert_eq!(scene.image.resolution.value, [1280, 720]);
    assert_eq!((scene.lights.len(), scene.objects.len()), (3, 7));
    assert!(scene.source.text.starts_with("# The lecture's scene: "));
}

#[test]
fn every_notation_of_a_value() {
    let rgb = |rgb| Value::Rgb {
        rgb,
        space: ColorSpace::Rec709,
    };
    assert_eq!(diffuse("0.5"), Value::Uniform(0.5));
    assert_eq!(diffuse("1"), Value::Uniform(1.0));
    assert_eq!(diffuse("0x1F"), Value::Uniform(31.0));
    assert_eq!(diffuse("1_000"), Value::Uniform(1000.0));
    assert_eq!(diffuse("-2.5e-3"), Value::Uniform(-2.5e-3));
    assert_eq!(diffuse("[0.1, 2, 3e1]"), rgb([0.1, 2.0, 30.0]));
    assert_eq!(diffuse("\"#c86432\""), Value::Srgb([200, 100, 50]));
    assert_eq!(diffuse("\"#C86432\""), Value::Srgb([200, 100, 50]));
    assert_eq!(diffuse("{ rgb = [1, 2, 3] }"), rgb([1.0, 2.0, 3.0]));
    assert_eq!(
        diffuse("{ rgb = [1, 2, 3], space = \"rec709\" }"),
        rgb([1.0, 2.0, 3.0])
    );
    // Ranges are checked elsewhere, and with them these two.
    assert_eq!(diffuse("inf"), Value::Uniform(f64::INFINITY));
    assert!(matches!(diffuse("nan"), Value::Uniform(number) if number.is_nan()));
}

#[test]
fn colors_that_are_none() {
    for bad in [
        "#c8643", "#c864321", "c86432", "#c8643g", "#+86432", "#é6432", "",
    ] {
        let text = format!("{FRAME}[materials.clay.phong]\ndiffuse = \"{bad}\"\n");
        assert_eq!(errors(&text).len(), 1, "{bad}");
    }
}

#[test]
fn toml_in_every_layout_is_one_scene() {
    let expected = "Point { position: [1.0, 2.0, 3.0], intensity: Uniform(4.0) }";
    for layout in [
        "[lights.key.point]\nposition = [1, 2, 3]\nintensity = 4\n",
        "[lights.key]\npoint.position = [1, 2, 3]\npoint.intensity = 4\n",
        "[lights.key]\npoint = { position = [1, 2, 3], intensity = 4 }\n",
        "[lights]\nkey.point.position = [1, 2, 3]\nkey.point.intensity = 4\n",
        "[lights]\nkey = { point = { position = [1, 2, 3], intensity = 4 } }\n",
        "[lights.\"key\".'point']\n\"position\" = [\n  1, # x\n  2,\n  3,\n]\nintensity = 4\n",
        "[ lights . key . point ]\nintensity = 4\nposition = [1, 2, 3,]\n",
    ] {
        let scene = scene(&format!("{FRAME}{layout}"));
        let Light::Point {
            position,
            intensity,
            group: None,
        } = &scene.lights[0].value
        else {
            panic!("the light is a point");
        };
        let read = format!(
            "Point {{ position: {:?}, intensity: {:?} }}",
            position.value, intensity.value
        );
        assert_eq!(read, expected, "{layout}");
        assert_eq!(scene.lights[0].name, "key");
    }
    let dotted = "lights.key.point.position = [1, 2, 3]\nlights.key.point.intensity = 4\n";
    assert_eq!(scene(&format!("{dotted}{FRAME}")).lights.len(), 1);
    let bom = format!("\u{feff}{FRAME}");
    assert_eq!(scene(&bom).image.resolution.value, [8, 8]);
}

#[test]
fn entries_in_the_order_of_the_file_whatever_lies_between() {
    let text = format!(
        "[lights.b.point]\nposition = [0, 0, 0]\nintensity = 1\n{FRAME}\
         [lights.a.point]\nposition = [0, 0, 0]\nintensity = 1\n"
    );
    let scene = scene(&text);
    let names: Vec<&str> = scene
        .lights
        .iter()
        .map(|light| light.name.as_str())
        .collect();
    assert_eq!(names, ["b", "a"]);
}

#[test]
fn names_in_any_script() {
    for name in [
        "key",
        "key-1",
        "key_1",
        "1",
        "left key",
        "Schlüssel",
        "鍵",
        "Material.001",
        // Letters with marks: decomposed as macOS writes them, Devanagari, Thai, Hebrew.
        "e\u{301}t\u{e9}",
        "हिन्दी",
        "ไม้",
        "שָׁלוֹם",
    ] {
        let text = format!("{FRAME}[materials.\"{name}\".phong]\n");
        assert_eq!(scene(&text).materials[0].name, name);
    }
    for name in [
        "",
        " key",
        "key ",
        "a/b",
        "a\\tb",
        "\\\"",
        "a:b",
        // A mark without a letter, a character without width, a picture.
        "\u{301}a",
        "a\u{200b}b",
        "a\u{ad}b",
        "☀",
        &"x".repeat(201),
    ] {
        let text = format!("{FRAME}[materials.\"{name}\".phong]\n");
        let errors = errors(&text);
        assert!(errors[0].0.contains("cannot be the name of a material"));
        assert_eq!(errors.len(), 1, "{name}");
    }
}

#[test]
fn places_with_windows_line_ends_tabs_and_wide_characters() {
    for (text, place) in [
        ("\r\n\tradus = 1", (8, 2)),
        ("\n# 漢字\n  'ü' = 1", (9, 3)),
        ("\n\n\nup = [\n0,\n1", (10, 6)),
    ] {
        let text = format!("{FRAME}{text}");
        let places: Vec<_> = errors(&text).into_iter().map(|(_, place)| place).collect();
        assert_eq!(places, [place], "{text}");
    }
}

/// One error for each, none for the objects that have the material.
#[test]
fn a_dotted_name_without_quotes_stays_known() {
    let text = format!(
        "{FRAME}[materials.Material.phong]\n[materials.Material.001.phong]\n\
         [materials.Material.002.normalized_phong]\n\
         [objects.a.sphere]\nmaterial = \"Material.001\"\ncenter = [0, 0, 0]\nradius = 1\n\
         [objects.b.sphere]\nmaterial = \"Material.002\"\ncenter = [0, 0, 0]\nradius = 1\n"
    );
    let reading = Reading::of_text(text, Path::new(PATH));
    assert!(reading.is_known_material("Material.001"));
    let errors = reading.complete().unwrap_err().to_string();
    let errors: Vec<_> = (errors.lines())
        .filter(|line| line.starts_with("error"))
        .collect();
    assert_eq!(
        errors,
        [
            "error: a name with a dot stands in quotes: `[materials.\"Material.001\".phong]`",
            "error: a name with a dot stands in quotes: \
             `[materials.\"Material.002\".normalized_phong]`",
        ]
    );
}

/// Quotes would not help a light.
#[test]
fn a_dotted_name_of_a_light_is_answered_without_dot() {
    let text = format!(
        "{FRAME}[lights.Point.001.point]\nposition = [0, 0, 0]\nintensity = 1\n\
         [lights.\"Spot é\".002.point]\nposition = [0, 0, 0]\nintensity = 1\n"
    );
    let messages: Vec<_> = errors(&text).into_iter().map(|(error, _)| error).collect();
    let why = "the name of a light has no dot, which parts layer and channel in the EXR; write";
    assert_eq!(
        messages,
        [
            format!("{why} `[lights.Point_001.point]`"),
            format!("{why} `[lights.\"Spot é_002\".point]`"),
        ]
    );
}

#[test]
fn a_broken_material_stays_known() {
    let text = format!("{FRAME}[materials.clay.phong]\ndiffuse = true\n[materials.chalk.phong]\n");
    let reading = Reading::of_text(text, Path::new(PATH));
    assert!(reading.is_known_material("clay"));
    assert!(reading.is_known_material("chalk"));
    assert!(!reading.is_known_material("glaze"));
    // The rest can be checked in the same run.
    let scene = reading.scene.as_ref().unwrap();
    assert_eq!(scene.materials.len(), 1);
    assert!(reading.broken.materials.contains("clay"));
    assert_eq!(reading.complete().unwrap_err().list().len(), 1);
}

#[test]
fn what_another_error_hides_is_not_unknown() {
    for text in [
        "[material.clay.phong]\ndiffuse = 0.5\n",
        "[materials.clay.phong\ndiffuse = 0.5\n",
        "[objects.ball.sphere]\ncenter = [0, 0, 0\n[materials.clay.phong]\n",
    ] {
        let reading = Reading::of_text(format!("{FRAME}{text}"), Path::new(PATH));
        assert!(reading.is_known_material("clay"), "{text}");
        assert_eq!(reading.diagnostics.len(), 1, "{text}");
    }
}

#[test]
fn a_syntax_error_in_one_entry_leaves_the_others_checked() {
    let text = format!(
        "{FRAME}[materials.clay.phong]\ndiffuse = 0,5\nspeculer = 1\n\
         [materials.chalk.phong]\nspeculer = 1\n"
    );
    let messages: Vec<_> = errors(&text)
        .into_iter()
        .map(|(message, _)| message)
        .collect();
    assert_eq!(
        messages,
        [
            "unexpected comma; numbers are written with a decimal point, such as `0.5`",
            "unknown key `speculer`"
        ]
    );
}

#[test]
fn many_errors_are_collected_only_so_far() {
    let keys: String = (0..5_000).map(|i| format!("k{i} = 1\n")).collect();
    let text = format!("{FRAME}[materials.clay.phong]\n{keys}");
    assert_eq!(errors(&text).len(), 1_000);
}

#[test]
fn a_file_that_is_not_text_shows_the_byte() {
    let reading = Reading::of_stream(
        &b"# ok\r\nab\xff = 1\n"[..],
        Path::new("x.toml"),
        Path::new(""),
        &[],
    );
    let span = reading.diagnostics[0].span;
    assert_eq!(reading.source.line_column(span.start), (2, 3));
    assert!(reading.complete().unwrap_err().to_string().contains("0xFF"));
}

#[test]
fn in_a_large_file_the_first_syntax_error_is_told_alone() {
    let spheres: String = (0..5_000)
        .map(|i| {
            format!("[objects.s{i}.sphere]\nmaterial = \"m\"\ncenter = [0, 0, 0]\nradius = 1\n")
        })
        .collect();
    let entry = "[materials.m.phong]\n";
    let text = format!("{FRAME}{entry}{spheres}{entry}speculer = 1\n");
    assert_eq!(
        errors(&text),
        [("material `m` is there twice".to_owned(), (20_008, 1))]
    );
}

#[test]
fn a_file_too_large_is_not_read() {
    let file = tempfile::NamedTempFile::new().unwrap();
    file.as_file().set_len(LARGEST_FILE + 1).unwrap();
    let error = Scene::load(file.path()).unwrap_err();
    let path = file.path().display();
    assert_eq!(
        error.to_string(),
        format!(
            "error: the scene file is larger than 256 MB\n--> {path}\n \
             = help: put triangles into a mesh file and name it in `[objects.NAME.mesh]`"
        )
    );
}

/// The time that hostile input may take, with reserve for a busy machine; typical are 50 ms.
const HOSTILE_TIME: Duration = Duration::from_secs(5);

/// The longest report for it in bytes: 20 messages.
const HOSTILE_REPORT: usize = 20_000;

#[test]
fn hostile_text_ends_soon_in_a_short_message() {
    const SIZE: usize = 100_000;
    let cases = [
        ("brackets", "[".repeat(SIZE)),
        ("arrays", format!("a = {}", "[".repeat(SIZE))),
        ("tables", format!("a = {}", "{a=".repeat(SIZE / 3))),
        ("mixed", format!("a = {}", "[{a=".repeat(SIZE / 4))),
        ("dots", format!("{}a = 1", "a.".repeat(SIZE / 2))),
        (
            "header dots",
            format!("[{}a]\nx = 1", "a.".repeat(SIZE / 2)),
        ),
        ("equals", "=\n".repeat(SIZE / 2)),
        ("headers", "[a]\n".repeat(SIZE / 4)),
        ("sphere", "[objects.a.sphere]\nradius=1\n".repeat(SIZE / 28)),
        ("keys", format!("[image]\n{}", "a=1\n".repeat(SIZE / 4))),
        ("array headers", "[[a]]\n".repeat(SIZE / 6)),
        ("quotes", "'''".repeat(SIZE / 3)),
        (
            "open string",
            format!("a = \"\"\"{}", "x\n".repeat(SIZE / 2)),
        ),
        ("long key", format!("{} = 1", "a".repeat(SIZE))),
        (
            "long name",
            format!("[materials.{}.phong]", "a".repeat(SIZE)),
        ),
        (
            "long string",
            format!("image = \"{}\"", "é".repeat(SIZE / 2)),
        ),
        (
            "long number",
            format!("{FRAME}[camera]\nx = {}", "9".repeat(SIZE)),
        ),
        ("long array", format!("image = [{}]", "1,".repeat(SIZE / 2))),
        ("nul", "\0".repeat(SIZE)),
        ("returns", "\r".repeat(SIZE)),
        ("controls", format!("a = \"{}\"", "\u{1b}".repeat(SIZE))),
        ("commas", format!("a = [{}", ",\n".repeat(SIZE / 2))),
        ("names", {
            let names = 0..SIZE / 18;
            names.map(|i| format!("[objects.x{i}.spher]\n")).collect()
        }),
    ];
    for (name, text) in cases {
        let started = Instant::now();
        let error = Scene::parse(&text, "hostile.toml").unwrap_err();
        let report = error.to_string();
        let took = started.elapsed();
        assert!(took < HOSTILE_TIME, "{name}: {took:?}");
        assert!(report.len() < HOSTILE_REPORT, "{name}: {}", report.len());
        assert!(report.contains("--> hostile.toml"), "{name}");
        assert!(
            !report.contains(|character: char| character.is_control() && character != '\n'),
            "{name}"
        );
        println!(
            "{name}: {} bytes in {took:?}: {}",
            text.len(),
            error.list().len()
        );
    }
}

/// Brackets of one kind alone, mixed, and with closing ones that do not fit: the parser has a frame
/// on the stack for each, so that an answer at all is the test.
#[test]
fn brackets_within_brackets() {
    for pattern in [
        "[",
        "{a=",
        "{a=[",
        "[{",
        "[}{]",
        "{a=[}",
        "[\n",
        "{a=[#]\n",
        "[\"]\"{'}'",
    ] {
        let text = format!("image = {}", pattern.repeat(50_000));
        let error = Scene::parse(&text, "deep.toml").unwrap_err().to_string();
        assert!(
            error.contains("brackets within brackets"),
            "{pattern}: {error}"
        );
    }
}

/// Sequences of brackets without rule, of a seeded generator (splitmix64).
#[test]
fn any_brackets_have_an_answer() {
    let mut state: u64 = 7;
    let mut next = move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed ^ (mixed >> 31)) as usize
    };
    const PIECES: [&str; 12] = [
        "[", "{", "[", "{a=", "]", "}", "a=", ",", "\n", "'", "\"", "1",
    ];
    for _ in 0..200 {
        // Half of the pieces open something, so that the depth goes up all the time.
        let text: String = (0..5_000).map(|_| PIECES[next() % PIECES.len()]).collect();
        assert!(Scene::parse(&format!("a = {text}"), "any.toml").is_err());
    }
}
