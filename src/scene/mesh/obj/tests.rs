use std::path::Path;

use super::*;

fn mesh(text: &str) -> MeshFile {
    MeshFile::parse(text.as_bytes(), Path::new("mesh.obj")).unwrap()
}

fn error(text: &str) -> String {
    MeshFile::parse(text.as_bytes(), Path::new("mesh.obj"))
        .unwrap_err()
        .to_string()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
const POSITIONS: [[f64; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];

#[test]
fn corners_of_every_form() {
    for face in [
        "f 1 2 3 4",
        "f 1/1 2/2 3/3 4/4",
        "f -4 -3 -2 -1",
        "f -4/-1 2/-1 -2/-9 4/0",
        "  f\t1   2 3 4  # a square",
        "f 1 2 \\\n 3 \\\r\n4",
        "fo 1 2 3 4",
    ] {
        let mesh = mesh(&format!("{SQUARE}{face}\n"));
        assert_eq!(mesh.positions, POSITIONS, "{face}");
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]], "{face}");
        assert_eq!(mesh.normals, None, "{face}");
        assert!(mesh.remarks.is_empty());
    }
}

#[test]
fn several_normals_of_one_position() {
    for face in [
        "f 1//1 2//2 3//1\nf 1//3 3//3 4//3",
        "f 1/7/1 2/7/2 3/7/1\nf 1/7/3 3/7/3 4/7/3",
        "f -4//-3 -3//-2 -2//-3\nf 1//-1 3//-1 4//-1",
    ] {
        let mesh = mesh(&format!("{SQUARE}vn 0 0 1\nvn 0 1 2\nvn 1 0 5\n{face}"));
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        let normals = mesh.normals.unwrap();
        assert_eq!(normals.vectors, [[0., 0., 1.], [0., 1., 2.], [1., 0., 5.]]);
        assert_eq!(normals.triangles.unwrap(), [[0, 1, 0], [2, 2, 2]]);
    }
}

#[test]
fn normals_of_polygons_follow_their_corners() {
    // Concave at corner 3, so that the cut does not start at the first corner.
    let mesh = mesh(
        "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nvn 1 0 1\nvn 2 0 1\nvn 3 0 1\nvn 4 0 1\n\
        vn 5 0 1\nvn 6 0 1\nf 1//6 2//5 3//4 4//3 5//2\n",
    );
    let normals = mesh.normals.unwrap().triangles.unwrap();
    assert_eq!(mesh.triangles.len(), 3);
    for (corners, normals) in mesh.triangles.iter().zip(&normals) {
        for (corner, normal) in corners.iter().zip(normals) {
            assert_eq!(normal + corner, 5);
        }
    }
}

#[test]
fn one_normal_a_position_needs_no_indices() {
    let mesh = mesh(&format!(
        "{SQUARE}vn 0 0 1\nvn 0 0 2\nvn 0 0 3\nvn 0 0 4\nf 1//1 2//2 3//3 4//4\n"
    ));
    let normals = mesh.normals.unwrap();
    assert_eq!(normals.triangles, None);
    assert_eq!(normals.vectors[3], [0., 0., 4.]);
}

#[test]
fn faces_without_normals_among_others() {
    // Before, between and after; a triangle without area too.
    let mesh = mesh(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 1 1 1\nf 1 2 3\nf 1 3 2\nf 1//1 2//1 3//1\n\
        f 1 2 4\nf 1 1 4\nf 2//1 3//1 4//1\nf 1 4 3\n",
    );
    let normals = mesh.normals.unwrap();
    let used: Vec<[f64; 3]> = normals
        .triangles
        .unwrap()
        .iter()
        .map(|&[a, b, c]| {
            assert!(a == b && b == c);
            normals.vectors[a as usize]
        })
        .collect();
    let written = [1., 1., 1.];
    let degenerate = UNSEEN;
    assert_eq!(
        used,
        [
            [0., 0., 1.],
            [0., 0., -1.],
            written,
            [0., -1., 0.],
            degenerate,
            written,
            [-1., 0., 0.]
        ]
    );
    assert!(mesh.remarks.is_empty());
}

#[test]
fn faces_of_normals_without_direction_are_flat_and_counted() {
    let text =
        format!("{SQUARE}vn 0 0 0\nvn 1 0 5\nvn nan 0 0\nf 1//2 2//2 3//1\nf 1//3 3//3 4//3\n");
    let all_flat = mesh(&text);
    assert_eq!(all_flat.normals, None);
    assert_eq!(all_flat.remarks.mended_normals, 2);
    let one_smooth = mesh(&format!("{text}f 1//2 2//2 4//2\n"));
    assert_eq!(one_smooth.remarks.mended_normals, 2);
    let normals = one_smooth.normals.unwrap();
    assert!(normals.vectors.iter().all(|&n| has_direction(n)));
    let indices = normals.triangles.unwrap();
    assert_eq!(normals.vectors[indices[0][2] as usize], [0., 0., 1.]);
    assert_eq!(indices[2], [1; 3]);
}

#[test]
fn groups_are_ranges_of_triangles() {
    let mesh = mesh(&format!(
        "{SQUARE}f 1 2 3\no empty\ng  left wing \nf 1 2 3 4\nf 1 2 3\no body\ns 1\nf 2 3 4\n\
        g\nf 1 2 3\ng left wing\r\nf 1 2 3\n"
    ));
    let group = |name: &str, triangles| MeshGroup {
        name: name.to_owned(),
        triangles,
    };
    assert_eq!(
        mesh.groups,
        [
            group("left wing", 1..4),
            group("body", 4..5),
            group("left wing", 6..7)
        ]
    );
    assert_eq!(mesh.triangles.len(), 7);
}

#[test]
fn statements_that_are_not_rendered() {
    let mesh = mesh(
        "\u{feff}# made by hand \\\nmtllib a.mtl\nv 0 0 0 1\nv 1 0 0 0.5 0.5 0.5\n\
        v 0 1 0 1.0 1 1 1\nvt 0 0\nvt junk\nvp 1\nusemtl red\ns off\nl 1 2 \\\n 3\np 1\n\
        curv 0 1 \\\r\n1 2\ncstype bezier\nparm u 0 1\nend\nf 1 2 3",
    );
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    assert_eq!(mesh.positions.len(), 3);
    assert_eq!(mesh.remarks.skipped_statements, 3);
}

#[test]
fn errors_say_the_line() {
    let line_5 = |statement: &str| error(&format!("{SQUARE}{statement}\nf 1 2 3\n"));
    for (statement, message) in [
        ("v 1 2", "line 5: the line ends, expected a number for z"),
        ("v 1 two 3", "line 5: found `two`, expected a number for y"),
        (
            "v 1 2 3 # 4\nv 1 2 inf",
            "line 6: coordinate z is inf, expected a finite number",
        ),
        (
            "v 1 2 3 4 5 6 7 8",
            "line 5: found `8`, expected the end of the line",
        ),
        (
            "vn 1 2 3 4",
            "line 5: found `4`, expected the end of the line",
        ),
        ("f 1 2", "line 5: a face of 2 corners, expected at least 3"),
        ("f", "line 5: a face of 0 corners, expected at least 3"),
        (
            "f 1 2 5",
            "line 5: vertex 5 does not exist, expected 1 to 4, or -4 to -1 counted backwards",
        ),
        (
            "f 1 2 \\\n-5",
            "line 6: vertex -5 does not exist, expected 1 to 4, or -4 to -1 counted backwards",
        ),
        (
            "f 0 1 2",
            "line 5: vertex 0 does not exist, expected 1 to 4, or -4 to -1 counted backwards",
        ),
        (
            "f 1//1 2//1 3//1",
            "line 5: normal 1 does not exist, expected one that is defined before it, of which \
            there are none",
        ),
        (
            "vn 0 0 1\nf 1//1 2 3//1",
            "line 6: a face of corners with and without a normal, expected all alike",
        ),
        (
            "vn 0 0 1\nf 1 2//1 3//1",
            "line 6: a face of corners with and without a normal, expected all alike",
        ),
        ("f 1/ 2 3", "line 5: the line ends, expected"),
        ("f 1// 2 3", "line 5: "),
        ("f 1/2/ 2 3", "line 5: "),
        (
            "f 1.5 2 3",
            "line 5: found `.5`, expected a corner: v, v/vt, v//vn or v/vt/vn",
        ),
        (
            "f 1 2 99999999999999999999",
            "line 5: found `99999999999999999999`, expected a corner",
        ),
        (
            "f a b c",
            "line 5: found `a`, expected a corner: v, v/vt, v//vn or v/vt/vn",
        ),
        (
            "call other.obj",
            "line 5: `call` and `csh` statements are not supported; put everything in one file",
        ),
        (
            "w\u{1} 1",
            "line 5: found `w\\x01`, expected an OBJ statement such as `v`, `vn`, `f`, `g`, `o`, \
            `usemtl` or `#`",
        ),
    ] {
        let found = line_5(statement);
        assert!(found.starts_with(message), "{statement}: {found}");
    }
    assert!(error(SQUARE).contains("no faces"));
}

#[test]
fn polygons_with_too_many_corners() {
    let face = |corners: usize| format!("{SQUARE}f{}\n", " 1".repeat(corners));
    assert_eq!(mesh(&face(MAX_CORNERS)).triangles.len(), MAX_CORNERS - 2);
    assert!(error(&face(MAX_CORNERS + 1)).starts_with("line 5: a face of 65537 corners"));
}
