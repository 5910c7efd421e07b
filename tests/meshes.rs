//! Meshes, curves and names as programs in the wild write them: what is read, what is said about
//! it, and what is refused for a reason that leads on.

use std::fs;
use std::path::Path;

use candela::mesh::MeshError;
use candela::scene::{Diagnostics, MeshFile, Problem, Reading};
use candela::world::World;
use candela::world::physics::warnings;
use tempfile::TempDir;

use crate::allocation;

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\n";

/// A view of the unit square, lit, whose object is a mesh of the file `name` with `more` keys.
fn scene(name: &str, more: &str) -> String {
    format!(
        "[image]\nresolution = [8, 6]\n[camera.perspective]\neye = [0.5, 0.5, 3]\n\
        look_at = [0.5, 0.5, 0]\nvertical_fov = 40\n[materials.clay.phong]\ndiffuse = 0.3\n\
        [lights.key.point]\nposition = [1, 2, 3]\nintensity = 10\n\
        [objects.shape.mesh]\nmaterial = \"clay\"\nfile = \"{name}\"\n{more}\n"
    )
}

/// A view of a ball whose reflectance is the value `diffuse`.
fn ball(diffuse: &str) -> String {
    format!(
        "[image]\nresolution = [8, 6]\n[camera.perspective]\neye = [0, 0, 3]\n\
        look_at = [0, 0, 0]\nvertical_fov = 40\n[materials.paint.normalized_phong]\n\
        diffuse = {diffuse}\n[lights.key.point]\nposition = [1, 2, 3]\nintensity = 30\n\
        [objects.ball.sphere]\nmaterial = \"paint\"\ncenter = [0, 0, 0]\nradius = 1\n"
    )
}

/// A folder of the scene and one file beside it.
fn folder(scene: &str, file: (&str, &[u8])) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    fs::write(folder.path().join(file.0), file.1).unwrap();
    folder
}

fn load(folder: &TempDir) -> Result<World, Diagnostics> {
    World::load(folder.path().join("scene.toml")).map(|loaded| loaded.world)
}

/// How many triangles the world has that is made of a mesh file, and what `check` and `render` say
/// about it.
#[track_caller]
fn world(name: &str, bytes: &[u8], more: &str) -> (usize, Vec<String>) {
    let world = load(&folder(&scene(name, more), (name, bytes))).unwrap();
    let said = warnings(&world).iter().map(ToString::to_string).collect();
    (world.triangles().len(), said)
}

/// The only message about a scene.
#[track_caller]
fn message(scene: &str, file: (&str, &[u8])) -> String {
    let error = load(&folder(scene, file)).unwrap_err();
    let [diagnostic] = error.list() else {
        panic!("{error}");
    };
    diagnostic.problem.to_string()
}

#[test]
fn meshes_without_flaws() {
    let [faces, cr_faces] = ["f 1 2 3 4", "f 1 2 3 4"].map(|face| format!("{SQUARE}{face}\n"));
    let body = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    let face = "element face 2\nproperty list uchar int vertex_indices\nend_header\n";
    let strips = "element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
    let ply_faces = format!("{PLY}{face}{body}3 0 1 2\n3 0 2 3\n");
    let ply_strips = format!("{PLY}{strips}{body}8 0 1 2 3 -1 0 1 2\n");
    for (name, text, triangles) in [
        ("a.obj", faces, 2),
        ("a.obj", cr_faces.replace('\n', "\r"), 2),
        ("a.obj", format!("{SQUARE}f 1// 2// 3// 4//\n"), 2),
        ("a.obj", format!("{SQUARE}vt 0 0\nf 1/1/ 2/1/ 3/1/ 4/1/"), 2),
        ("a.obj", format!("{SQUARE}f 1/ 2/ 3/ 4/"), 2),
        ("a.obj", format!("f 1 2 3 4\n{SQUARE}"), 2),
        ("a.obj", format!("{SQUARE}f 1 2 3 4\r\n\x1a"), 2),
        (
            "a.obj",
            format!("\u{feff}{SQUARE}usemtl a b\\\nf 1 2 3 4"),
            2,
        ),
        ("a.ply", ply_faces.replace('\n', "\r"), 2),
        ("a.ply", format!("\u{feff}{ply_faces}"), 2),
        ("a.ply", ply_faces, 2),
        ("a.ply", ply_strips.replace('\n', "\r\n"), 3),
        ("a.ply", ply_strips, 3),
    ] {
        assert_eq!(
            world(name, text.as_bytes(), ""),
            (triangles, vec![]),
            "{text}"
        );
    }
}

#[test]
fn every_remark_is_a_warning_of_its_own() {
    let text = format!(
        "{SQUARE}v x\nvn -nan(ind) -nan(ind) -nan(ind)\nvn 0 0 1\nf 1//1 2//2 3//2\nf 1//2 3//0 4//2\n\
        f 1//2 3//2 4\nf 1 2\nf 1 1 1\nf 1 3 2 4\nl 1 2\nvw 1\n"
    );
    let expected = [
        "1 triangle of object `shape` has no area and was dropped",
        "the file of object `shape` has 1 normal without a direction, replaced by the geometric one",
        "the file of object `shape` has 1 corner that names a normal that is not there, replaced by \
        the geometric one",
        "the file of object `shape` has 1 face with normals at some corners only, which has its \
        geometric one",
        "the file of object `shape` has 1 polygon that crosses itself",
        "the file of object `shape` has 1 face of fewer than 3 corners, which was skipped",
        "the file of object `shape` has 1 vertex without a finite position, which no face uses",
        "the file of object `shape` has 1 line, point or curve, which is not rendered",
        "the file of object `shape` has 1 unknown statement, `vw`, which was skipped",
    ];
    let (triangles, said) = world("a.obj", text.as_bytes(), "");
    assert_eq!(triangles, 5);
    assert_eq!(said, expected);
    // Normals that are not used are nobody's concern.
    let (_, said) = world("a.obj", text.as_bytes(), "smooth = false");
    assert_eq!(said, [&expected[..1], &expected[4..]].concat());
    let twice = text.clone()
        + "f 1 2 2\nf 1//1 3//2 4//2\nf 9 3\n"
            .replace('9', "1")
            .as_str();
    let (_, said) = world("a.obj", twice.as_bytes(), "");
    assert_eq!(
        said[..2],
        [
            "2 triangles of object `shape` have no area and were dropped",
            "the file of object `shape` has 2 normals without a direction, replaced by geometric ones",
        ]
    );
    assert_eq!(
        said[5],
        "the file of object `shape` has 2 faces of fewer than 3 corners, which were skipped"
    );
    let trailing = format!(
        "{PLY}element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n\
        1 1 0\n0 1 0 7\n3 0 1 2\nmore\n"
    );
    assert_eq!(
        world("a.ply", trailing.as_bytes(), "").1,
        [
            "the file of object `shape` has 1 line with more or fewer values than belong there",
            "the file of object `shape` has 4 bytes behind all that its header counts, which were \
            skipped",
        ]
    );
}

#[test]
fn forms_that_are_not_read_are_named() {
    let utf16: Vec<u8> = format!("\u{feff}{SQUARE}f 1 2 3\n")
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    for (bytes, expected) in [
        (
            &utf16[..],
            "it is text in UTF-16 (little endian), expected a PLY or OBJ mesh in ASCII or UTF-8; save \
            it as UTF-8",
        ),
        (
            &utf16[2..],
            "it is text in UTF-16 (little endian), expected a PLY or OBJ mesh in ASCII or UTF-8; save \
            it as UTF-8",
        ),
        (
            b"\x1f\x8b\x08\0\0",
            "it is compressed by gzip, expected a PLY or OBJ mesh in ASCII or UTF-8; unpack it",
        ),
    ] {
        let found = message(&scene("a.obj", ""), ("a.obj", bytes));
        assert!(found.ends_with(expected), "{found}");
    }
}

#[test]
fn vertices_far_away_that_no_face_uses() {
    let text = format!("{SQUARE}v 1e200 0 0\nf 1 2 3\n");
    assert_eq!(world("a.obj", text.as_bytes(), "").0, 1);
    let used = format!("{text}f 1 2 5\n");
    assert_eq!(
        message(&scene("a.obj", ""), ("a.obj", used.as_bytes())),
        "the mesh has vertices beyond 1e30 scene units once it is placed"
    );
}

#[test]
fn small_scales_say_what_is_wrong() {
    let square = format!("{SQUARE}f 1 2 3 4\n");
    let scaled = |scale: &str| {
        let more = format!("scale = {scale}");
        message(&scene("a.obj", &more), ("a.obj", square.as_bytes()))
    };
    for (scale, written) in [
        ("5e-31", "[5e-31, 5e-31, 5e-31]"),
        ("[1, 0, 1]", "[1, 0, 1]"),
    ] {
        assert_eq!(
            scaled(scale),
            format!(
                "`scale` is {written}, expected factors that are not 0, each at least 1e-30 or at \
                most -1e-30"
            )
        );
    }
    // The eye is three units away.
    assert_eq!(
        scaled("1e-20"),
        "every triangle of the mesh is so small where it is placed that 64-bit floats cannot tell its \
        corners apart, expected a larger `scale`"
    );
    let flat = format!("{SQUARE}f 1 1 2\n");
    assert_eq!(
        message(&scene("a.obj", ""), ("a.obj", flat.as_bytes())),
        "every triangle of the mesh is degenerate: none has an area"
    );
    // A part that is small enough to vanish, beside one that is not.
    let parts = format!("{SQUARE}v 1e-20 0 0\nv 0 1e-20 0\nf 1 2 3\nf 1 5 6\nf 1 1 2\n");
    assert_eq!(
        world("a.obj", parts.as_bytes(), ""),
        (
            1,
            vec![
                "1 triangle of object `shape` has no area and was dropped".to_owned(),
                "1 triangle of object `shape` is too small where it is placed for 64-bit floats to \
                tell its corners apart, and was dropped"
                    .to_owned(),
            ]
        )
    );
}

/// Names as Blender gives them to copies.
#[test]
fn names_with_dots() {
    let text = scene("a.obj", "")
        .replace("[materials.clay.", "[materials.\"Material.001\".")
        .replace("\"clay\"", "\"Material.001\"")
        .replace("[objects.shape.", "[objects.\"Plane.001\".");
    let square = format!("{SQUARE}f 1 2 3 4\nf 1 2 2\n");
    let named = load(&folder(&text, ("a.obj", square.as_bytes()))).unwrap();
    assert_eq!(named.objects()[0].name, "Plane.001");
    assert_eq!(named.materials()[0].name, "Material.001");
    assert_eq!(
        warnings(&named)[0].to_string(),
        "1 triangle of object `Plane.001` has no area and was dropped"
    );
    let light = text.replace("[lights.key.", "[lights.\"Point.001\".");
    assert_eq!(
        message(&light, ("a.obj", square.as_bytes())),
        "`Point.001` cannot be the name of a light: a dot parts layer and channel in the EXR; write \
        `Point_001`"
    );
    let unknown = text.replace("\"Material.001\"\nfile", "\"Material.002\"\nfile");
    let error = load(&folder(&unknown, ("a.obj", square.as_bytes()))).unwrap_err();
    assert!(
        error.to_string().contains("did you mean `Material.001`?"),
        "{error}"
    );
    // Without quotes a dot begins a table.
    let bare = text.replace("\"Plane.001\"", "Plane.001");
    assert_eq!(
        message(&bare, ("a.obj", square.as_bytes())),
        "a name with a dot stands in quotes: `[objects.\"Plane.001\".mesh]`"
    );
    let without = text.replace("[objects.\"Plane.001\".mesh]", "[objects.\"Plane.001\"]");
    let error = load(&folder(&without, ("a.obj", square.as_bytes()))).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("`[objects.\"Plane.001\".sphere]`"),
        "{error}"
    );
}

#[test]
fn curves_of_any_separator_give_the_same_color() {
    let inline = ball("{ wavelengths = [380, 550, 780], values = [0.1, 0.5, 0.3] }");
    let expected = load(&folder(&inline, ("unused", b""))).unwrap();
    let expected = expected.materials()[0].value.reflectance();
    for text in [
        "# nm value\n380 0.1\n550 0.5\n780 0.3\n",
        "nm,R\n380,0.1\n550,0.5\n780,0.3\n",
        "380\t0.1\r550 \t 0.5 // green\r780 0.3",
    ] {
        let scene = ball("{ file = \"metal.spd\" }");
        let read = load(&folder(&scene, ("metal.spd", text.as_bytes()))).unwrap();
        assert_eq!(read.materials()[0].value.reflectance(), expected, "{text}");
    }
}

#[test]
fn curves_in_other_units_are_errors() {
    const RANGE: &str = "no point of the curve is from 360 to 830 nm, all are from";
    for (points, unit) in [
        (
            ["0.38", "0.55", "0.78"],
            "these look like µm (1 µm is 1000 nm)",
        ),
        (
            ["3800", "5500", "7800"],
            "these look like Å (10 Å are 1 nm)",
        ),
        (
            ["13000", "18000", "26000"],
            "these look like cm⁻¹ (x cm⁻¹ are 1e7/x nm)",
        ),
    ] {
        let [a, b, c] = points;
        let expected = format!("{RANGE} {a} to {c}; wavelengths are in nm, {unit}");
        let inline = ball(&format!(
            "{{ wavelengths = [{a}, {b}, {c}], values = [0.1, 0.5, 0.3] }}"
        ));
        assert_eq!(message(&inline, ("unused", b"")), expected);
        let file = format!("x,R\n{a},0.1\n{b},0.5\n{c},0.3\n");
        let found = message(&ball("{ file = \"x.csv\" }"), ("x.csv", file.as_bytes()));
        assert!(found.ends_with(&expected), "{found}");
    }
    // Between two points beyond either end the curve is what it says.
    let around = ball("{ wavelengths = [300, 900], values = [0.5, 0.5] }");
    assert!(load(&folder(&around, ("unused", b""))).is_ok());
}

/// A pipe would be waited for until somebody writes to it.
#[cfg(unix)]
#[test]
fn pipes_and_folders_are_no_curves_and_no_meshes() {
    let folder = folder(
        &(scene("pipe", "")
            + "[materials.other.phong]\ndiffuse = { file = \"pipe\" }\n\
            [materials.third.phong]\ndiffuse = { file = \"folder\" }\n"),
        ("unused", b""),
    );
    let pipe = folder.path().join("pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.unwrap().success());
    fs::create_dir(folder.path().join("folder")).unwrap();
    let error = load(&folder).unwrap_err();
    let found: Vec<String> = (error.list().iter())
        .map(|diagnostic| match &diagnostic.problem {
            Problem::Mesh { error, .. } => error.to_string(),
            Problem::Curve { error, .. } => {
                assert!(!error.is_transient());
                error.to_string()
            }
            other => other.to_string(),
        })
        .collect();
    assert_eq!(
        found,
        [
            "it is a device or pipe, expected a PLY or OBJ file",
            "it is a device or pipe, expected a file of two columns",
            "it is a directory, expected a file of two columns",
        ]
    );
}

#[test]
fn what_another_try_may_cure() {
    let absent = MeshFile::load(Path::new("no_such_file.obj")).unwrap_err();
    assert!(!absent.is_transient());
    assert!(MeshError::NoMemory.is_transient());
    assert!(MeshError::Changed.is_transient());
    assert!(
        !MeshFile::parse(b"f 1", Path::new("a.obj"))
            .unwrap_err()
            .is_transient()
    );
}

/// A curve takes at most six times its file's size, and a little.
#[test]
fn curves_take_little_memory() {
    let shortest: String = (0..400_000).map(|i| format!("{} 1\n", 360 + i)).collect();
    let usual: String = (0..200_000)
        .map(|i| format!("{:.4},{:.6}\n", 360.0 + f64::from(i) / 1000.0, 0.5))
        .collect();
    for text in [
        shortest,
        usual,
        "\n".repeat(1_000_000),
        "#\r".repeat(500_000),
    ] {
        let folder = folder(&ball("{ file = \"x.csv\" }"), ("x.csv", text.as_bytes()));
        let path = folder.path().join("scene.toml");
        let (_, peak) = allocation::peak(|| Reading::of_file(&path));
        let limit = 6 * text.len() + (1 << 20);
        assert!(
            peak <= limit,
            "{peak} bytes for {}, expected {limit}",
            text.len()
        );
    }
}
