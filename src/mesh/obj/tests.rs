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
        "f 1 2 \\ \t\n 3 \\\r4\x1a",
        "f 1 2 3\\\n4",
        "fo 1 2 3 4",
        "f 1/ 2/ 3/ 4/",
        "f 1// 2// 3// 4//",
        "f 1/1// 2/2// 3/3/// 4/4//",
        "f 1/// 2/// 3//// \\\n 4///#a square",
        "f 1/1/ 2/1/ 3/1/ 4/1/",
        "f 1/ 2// 3/7/ 4",
        "f 1/x 2/1.5/ 3/99999999999999999999 4/nan/",
        "f 1 2 3 4#a square",
        "f 1 2 3 4\r",
        "f\x0b1\x0c2 3 4\0\0",
        "f 1 2 3 4\n\x1a\x1a\x1a",
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
        "f 1/7/1/ 2/7/2/ 3//1//\nf 1/7/3/ 3/7/3/ 4/7/3/",
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
            "f 1.5 2 3",
            "line 5: found `.5`, expected a corner: v, v/vt, v//vn or v/vt/vn",
        ),
        (
            "f 1/1/1/1 2 3",
            "line 5: found `/1`, expected a corner: v, v/vt, v//vn or v/vt/vn",
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
    ] {
        let found = line_5(statement);
        assert!(found.starts_with(message), "{statement}: {found}");
    }
    assert_eq!(
        error("f -1 1 2\nv 0 0 0\nv 1 0 0"),
        "line 1: vertex -1 does not exist, expected one of the file's, which has none there"
    );
}

#[test]
fn vertices_that_a_face_uses_must_be_finite() {
    for (vertex, message) in [
        ("v 1 2", "line 7: the line ends, expected a number for z"),
        ("v 1 two 3", "line 7: found `two`, expected a number for y"),
        (
            "v 1 2 inf",
            "line 7: coordinate z is inf, expected a finite number",
        ),
        (
            "v -nan(ind) 2 3",
            "line 7: coordinate x is NaN, expected a finite number",
        ),
    ] {
        // The first one that is used counts, whatever the order of the faces.
        let text = format!("{SQUARE}v a\n# six\n{vertex}\nv 1e999 0 0\nf 1 2 3");
        assert_eq!(error(&format!("{text}\nf 1 2 7\nf 1 2 6\n")), message);
        let mesh = mesh(&text);
        assert_eq!(mesh.positions.len(), 7);
        assert!(mesh.positions.iter().flatten().all(|x| x.is_finite()));
        assert_eq!(mesh.positions[..4], POSITIONS);
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
        assert_eq!(
            mesh.remarks.list(),
            ["3 vertices without a finite position, which no face uses"]
        );
    }
}

#[test]
fn faces_above_their_vertices() {
    let faces = "f 1//2 2//2 3//1\ng back\nl 1 2\nf 1 3 4\n# v 9 9 9 \\\n";
    let normals = "vn 0 0 1\nvn 0 1 1\n";
    let usual = mesh(&format!("{SQUARE}{normals}{faces}"));
    assert_eq!(usual.triangles, [[0, 1, 2], [0, 2, 3]]);
    for text in [
        format!("{faces}{SQUARE}{normals}"),
        format!("{normals}{faces}{SQUARE}"),
        format!("{SQUARE}{faces}{normals}"),
    ] {
        assert_eq!(mesh(&text), usual, "{text}");
    }
    // Counted back from where they stand.
    let mixed = "v 0 0 0\nv 1 0 0\nf -2 -1 3\nv 1 1 0\nv 0 1 0\nf -4 -2 -1\n";
    assert_eq!(mesh(mixed).triangles, usual.triangles);
    assert_eq!(
        error(&format!("f 1 2 3\n{SQUARE}f 1 2 5\n")),
        "line 6: vertex 5 does not exist, expected 1 to 4, or -4 to -1 counted backwards"
    );
}

#[test]
fn normals_that_are_not_there() {
    for (faces, absent, partial) in [
        ("f 1//0 2//0 3//0", 3, 0),
        ("f 1//1 2//9 3//1", 1, 0),
        ("f 1//-2 2//1 3//1", 1, 0),
        ("f 1//1 2 3//1", 0, 1),
        ("f 1 2//1 3//\nf 1 2 3//1", 0, 2),
        ("f 1//7 2 3//1", 1, 0),
        ("f 1//1 2//x 3/-/1", 1, 0),
        ("f 1//1 2//1.5 3//99999999999999999999", 2, 0),
    ] {
        let mesh = mesh(&format!("{SQUARE}vn 0 1 0\n{faces}\nf 1//1 3//1 4//1\n"));
        let expected = MeshRemarks {
            absent_normals: absent,
            partial_normals: partial,
            ..MeshRemarks::default()
        };
        assert_eq!(mesh.remarks, expected, "{faces}");
        let normals = mesh.normals.unwrap();
        let triangles = normals.triangles.unwrap();
        let of = |triangle: usize| triangles[triangle].map(|i| normals.vectors[i as usize]);
        assert_eq!(of(0), [[0., 0., 1.]; 3], "{faces}");
        assert_eq!(of(triangles.len() - 1), [[0., 1., 0.]; 3], "{faces}");
    }
    let without_any = mesh(&format!("{SQUARE}f 1//1 2//2 3//3"));
    assert_eq!(without_any.normals, None);
    assert_eq!(without_any.remarks.absent_normals, 3);
}

#[test]
fn what_the_picture_does_not_use() {
    let mesh = mesh(&format!(
        "{SQUARE}v 1 2 3 4 5 6 7 8\nv 1 2 3 red\nv 1 2 3 -nan 1.#IND 0\nvn 1 two 3\nvn 1 2 3 4\n\
        f 1 2\nf 3\nf\nf 1 2 3 4\nvw 0 0 1.0\nusemtl a\\b \\\nmtllib C:\\materials\\\n\
        f 2 3 4\nmtllib a.mtl \\\nb.mtl\nVW\n"
    ));
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [1, 2, 3]]);
    assert_eq!(
        mesh.remarks.list(),
        [
            "3 faces of fewer than 3 corners, which were skipped",
            "2 unknown statements such as `vw`, which were skipped",
            "3 lines with more or fewer values than belong there",
        ]
    );
}

#[test]
fn files_without_faces_say_what_they_have() {
    assert_eq!(
        error(SQUARE),
        "the mesh has no faces, expected at least one triangle or polygon"
    );
    assert_eq!(
        error(&format!("{SQUARE}l 1 2\nf 1 2\nw\u{1} 1\n")),
        "the mesh has no faces, expected at least one triangle or polygon; it has 1 face of fewer \
        than 3 corners, which was skipped; 1 line, point or curve, which is not rendered; 1 unknown \
        statement, `w\\x01`, which was skipped"
    );
}

#[test]
fn polygons_with_too_many_corners() {
    let face = |corners: usize| format!("{SQUARE}f{}\n", " 1".repeat(corners));
    assert_eq!(mesh(&face(MAX_CORNERS)).triangles.len(), MAX_CORNERS - 2);
    assert!(error(&face(MAX_CORNERS + 1)).starts_with("line 5: a face of 65537 corners"));
}
