//! Strips, and files that are not quite as they should be.

use super::*;

const STRIPS: &str = "element vertex 6\nproperty float x\nproperty float y\nproperty float z\n";

/// A file of six vertices, of which elements follow as `more` of the header says.
fn with_six_vertices(format: Format, more: &str) -> Writer {
    let mut file = Writer::new(format, &format!("{STRIPS}{more}"));
    for i in 0..6 {
        file.values(Scalar::F32, &[f64::from(i / 2), f64::from(i % 2), 0.0])
            .end_element();
    }
    file
}

#[test]
fn strips_become_triangles() {
    for format in FORMATS {
        for (name, scalar) in [
            ("int", Scalar::I32),
            ("short", Scalar::I16),
            ("char", Scalar::I8),
            ("float", Scalar::F32),
            ("uint", Scalar::U32),
            ("ushort", Scalar::U16),
            ("uchar", Scalar::U8),
        ] {
            let header = format!("element tristrips 2\nproperty list int {name} vertex_indices");
            let mut file = with_six_vertices(format, &header);
            let mark = match scalar {
                Scalar::U8 => f64::from(u8::MAX),
                Scalar::U16 => f64::from(u16::MAX),
                Scalar::U32 => f64::from(u32::MAX),
                _ => -1.0,
            };
            // Every second triangle is turned; the repeated corners join two parts; a mark ends a
            // strip wherever it is.
            file.list(
                Scalar::I32,
                scalar,
                &[0., 1., 2., 3., mark, 0., 2., 1., mark, mark],
            )
            .end_element()
            .list(Scalar::I32, scalar, &[0., 1., 2., 2., 3., 3., 4., 5.])
            .end_element();
            let mesh = file.parse().unwrap();
            assert_eq!(
                mesh.triangles,
                [[0, 1, 2], [2, 1, 3], [0, 2, 1], [0, 1, 2], [4, 3, 5]],
                "{format:?} {name}"
            );
            assert!(mesh.remarks.is_empty());
        }
    }
}

/// Of 256 vertices the last is 255, which then ends no strip.
#[test]
fn a_vertex_is_no_mark() {
    let header = "element tristrips 1\nproperty list int uchar vertex_indices\n";
    let vertices: String = (0..256).map(|i| format!("{i} {} 0\n", i * i)).collect();
    let file = format!(
        "ply\nformat ascii 1.0\nelement vertex 256\nproperty float x\nproperty float y\n\
         property float z\n{header}end_header\n{vertices}4 0 1 255 2\n"
    );
    let mesh = MeshFile::parse(file.as_bytes(), Path::new("a.ply")).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 255], [255, 1, 2]]);
}

#[test]
fn strips_and_faces_in_any_order() {
    let [vertex, face, strip] = [
        STRIPS,
        "element face 1\nproperty list uchar int vertex_indices\n",
        "element tristrips 1\nproperty uchar tag\nproperty list int int vertex_indices\n\
        property float weight\n",
    ];
    for format in FORMATS {
        for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [2, 1, 0], [1, 2, 0]] {
            let header: String = order.map(|part| [vertex, face, strip][part]).concat();
            let mut file = Writer::new(format, header.trim_end());
            for part in order {
                match part {
                    0 => (0..6).for_each(|i| {
                        file.values(Scalar::F32, &[f64::from(i / 2), f64::from(i % 2), 0.0])
                            .end_element();
                    }),
                    1 => {
                        file.list(Scalar::U8, Scalar::I32, &[3., 2., 1.])
                            .end_element();
                    }
                    _ => {
                        file.value(Scalar::U8, 9.0)
                            .list(Scalar::I32, Scalar::I32, &[0., 1., 2., 3., -1., 5.])
                            .value(Scalar::F32, 0.5)
                            .end_element();
                    }
                }
            }
            let mesh = file.parse().unwrap();
            let mut expected = vec![[0, 1, 2], [2, 1, 3]];
            let face_first =
                order.iter().position(|&part| part == 1) < order.iter().position(|&part| part == 2);
            expected.insert(if face_first { 0 } else { 2 }, [3, 2, 1]);
            // Those before the vertices are read at the end.
            if order == [1, 0, 2] {
                expected.rotate_left(1);
            }
            assert_eq!(mesh.triangles, expected, "{format:?} {order:?}");
            assert_eq!(
                mesh.remarks.list(),
                ["1 face of fewer than 3 corners, which was skipped"]
            );
        }
    }
}

#[test]
fn strips_with_errors() {
    let header = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element tristrips 1\nproperty list int int vertex_indices\n";
    for (strip, message) in [
        (
            "4 0 1 2 3",
            "tristrips 0 of 1 at line 13: vertex 3 does not exist, expected 0 to 2",
        ),
        (
            "4 0 1 2 -2",
            "tristrips 0 of 1 at line 13: vertex -2 does not exist, expected 0 to 2",
        ),
        (
            "4 0 1 2",
            "tristrips 0 of 1 at line 13: the line ends, expected the index of a vertex",
        ),
        (
            "-4 0 1 2",
            "tristrips 0 of 1 at line 13: found `-4`, expected the length of a list, 0 or more",
        ),
        (
            "4 0 1 -1 2",
            "the mesh has no faces, expected at least one triangle or polygon; it has 2 faces of fewer than 3 corners, which were skipped",
        ),
    ] {
        let found = error(header, &format!("0 0 0\n1 0 0\n0 1 0\n{strip}\n"));
        assert_eq!(found.to_string(), message);
    }
}

#[test]
fn faces_that_become_no_triangle() {
    for format in FORMATS {
        let header = "element face 5\nproperty list uchar int vertex_indices";
        let mut file = with_six_vertices(format, header);
        for face in [&[0., 1., 2.][..], &[0., 1.], &[], &[5.], &[1., 3., 2.]] {
            file.list(Scalar::U8, Scalar::I32, face).end_element();
        }
        let mesh = file.parse().unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(
            mesh.remarks.list(),
            ["3 faces of fewer than 3 corners, which were skipped"]
        );
    }
}

#[test]
fn vertices_that_no_face_uses() {
    for format in FORMATS {
        let header = "element vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
            element face 1\nproperty list uchar int vertex_indices";
        let mut file = Writer::new(format, header);
        for [x, y] in [
            [0., 0.],
            [f64::NAN, 0.],
            [1., 0.],
            [0., f64::INFINITY],
            [0., 1.],
        ] {
            file.values(Scalar::F32, &[x, y, 0.0]).end_element();
        }
        let used = file.bytes.clone();
        file.list(Scalar::U8, Scalar::I32, &[0., 2., 4.])
            .end_element();
        let mesh = file.parse().unwrap();
        assert_eq!(mesh.triangles, [[0, 2, 4]]);
        assert_eq!(mesh.positions[2], [1., 0., 0.]);
        assert!(mesh.positions.iter().flatten().all(|x| x.is_finite()));
        assert_eq!(mesh.remarks.unused_positions, 2);
        file.bytes = used;
        file.list(Scalar::U8, Scalar::I32, &[0., 3., 4.])
            .end_element();
        let message = file.parse().unwrap_err().to_string();
        assert!(message.starts_with("vertex 3 of 5 at "), "{message}");
        assert!(
            message.ends_with("coordinate y is inf, expected a finite number"),
            "{message}"
        );
    }
}

#[test]
fn lists_of_other_types_and_names() {
    for format in FORMATS {
        for (header, length, item) in [
            (
                "property list float int vertex_indices",
                Scalar::F32,
                Scalar::I32,
            ),
            (
                "property list uchar double vertex_index",
                Scalar::U8,
                Scalar::F64,
            ),
            (
                "property list uint float vertex_indices",
                Scalar::U32,
                Scalar::F32,
            ),
            ("property list uchar uint corners", Scalar::U8, Scalar::U32),
        ] {
            let mut file = with_six_vertices(format, &format!("element face 1\n{header}"));
            file.list(length, item, &[0., 1., 2.]).end_element();
            assert_eq!(file.parse().unwrap().triangles, [[0, 1, 2]], "{header}");
        }
        let header = "element face 1\nproperty list uchar float vertex_indices";
        let mut file = with_six_vertices(format, header);
        file.list(Scalar::U8, Scalar::F32, &[0., 1.5, 2.])
            .end_element();
        let message = file.parse().unwrap_err().to_string();
        assert!(
            message.ends_with("found `1.5`, expected the index of a vertex"),
            "{message}"
        );
    }
}

/// What the picture does not use may be anything, and lines may have more or less of it.
#[test]
fn lines_of_other_lengths() {
    let mesh = MeshFile::parse(
        b"ply\nformat ascii 1.0\nCreated by a program\nelement vertex 3\nproperty float x\n\
        property float y\nproperty float z\nproperty uchar red\nelement edge 1\nproperty int a\n\
        element face 2\nproperty list uchar int vertex_indices\nproperty uchar red\nend_header\n\
        0 0 0 1.#QNAN\n1 0 0\n0 1 0 red green\nanything at all\n3 0 1 2 9 1 1 1\n3 2 1 0 255\n\
        3 0 1 2\n\x1a",
        Path::new(""),
    )
    .unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [2, 1, 0]]);
    assert_eq!(
        mesh.remarks.list(),
        [
            "1 unknown statement, `Created`, which was skipped",
            "3 lines with more or fewer values than belong there",
            "7 bytes behind all that its header counts, which were skipped",
        ]
    );
}

/// The byte after the CR that ends a header may be a line feed that belongs to the data.
#[test]
fn headers_that_end_in_cr_alone() {
    for (format, first) in [
        (
            Format::Binary(Endian::Little),
            f32::from_le_bytes([10, 0, 128, 63]),
        ),
        (
            Format::Binary(Endian::Big),
            f32::from_be_bytes([10, 0, 0, 0]),
        ),
        (Format::Ascii, 3.0),
    ] {
        let mut file = Writer::new(format, STRIPS.trim_end().replace("6", "3").as_str());
        let text = String::from_utf8(file.bytes).unwrap();
        let faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
        file.bytes = text
            .replace("end_header\n", faces)
            .replace('\n', "\r")
            .into_bytes();
        for [x, y] in [[f64::from(first), 0.], [1., 0.], [0., 1.]] {
            file.values(Scalar::F32, &[x, y, 0.0]);
            file.bytes
                .extend(matches!(format, Format::Ascii).then_some(b'\r'));
        }
        file.list(Scalar::U8, Scalar::I32, &[0., 1., 2.]);
        let mesh = file.parse().unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
        assert_eq!(mesh.positions[0][0], f64::from(first));
        assert!(mesh.remarks.is_empty());
    }
}

#[test]
fn long_headers_are_not_kept() {
    let comments = "comment nothing\n".repeat(LONGEST_HEADER / 16 + 1);
    let text = format!("ply\nformat ascii 1.0\n{comments}end_header\n");
    let error = MeshFile::parse(text.as_bytes(), Path::new("")).unwrap_err();
    assert_eq!(
        error.to_string(),
        "line 1: a header of more than 1 MB, expected `end_header` before"
    );
}

#[test]
fn normals_that_are_no_numbers() {
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float nx\nproperty float x\n\
        property float y\nproperty float z\nproperty float ny\nproperty float nz\nelement face 1\n\
        property list uchar int vertex_indices\nend_header\n\
        -nan(ind) 0 0 0 1.#IND 0\njunk 1 0 0 0 1\n0 0 1 0\n3 0 1 2\n";
    let mesh = MeshFile::parse(text.as_bytes(), Path::new("")).unwrap();
    assert_eq!(mesh.positions, [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]]);
    assert_eq!(mesh.normals.unwrap().vectors, [[0., 0., 1.]; 3]);
    assert_eq!(mesh.remarks.mended_normals, 3);
}

/// Numbers that are not an element a line, but all there.
#[test]
fn elements_that_are_not_on_lines_of_their_own() {
    let header = "ply\nformat ascii 1.0\nelement tag 1\nproperty list uchar int a\n\
        element face 1\nproperty list uchar int vertex_indices\nproperty uchar red\n\
        element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n\
        element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
    let numbers = "2 7 7 3 0 1 2 9 0 0 0 9 1 0 0 9 1 1 0 9 0 1 0 9 5 0 1 2 -1 3";
    let in_lines = "2 7 7\n3 0 1 2 9\n0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0 9\n5 0 1 2 -1 3\n";
    let parse = |body: &str| MeshFile::parse(format!("{header}{body}").as_bytes(), Path::new(""));
    let mut expected = parse(in_lines).unwrap();
    assert_eq!(expected.triangles, [[0, 1, 2], [0, 1, 2]]);
    assert!(!expected.remarks.unlined);
    expected.remarks.unlined = true;
    for body in [
        numbers.to_owned(),
        numbers.replace(' ', "\n"),
        numbers.replace(' ', "\r\n\r\n"),
        numbers.replace(" 1 ", " 1\n"),
    ] {
        assert_eq!(parse(&body).unwrap(), expected, "{body}");
    }
    // One number too few or too many: the lines are right, and one of them is wrong.
    for body in [
        in_lines.replace("1 1 0 9", "1 1"),
        in_lines.replace("1 1 0 9\n", ""),
    ] {
        let message = parse(&body).unwrap_err().to_string();
        assert!(message.contains(" at line "), "{message}");
    }
}
