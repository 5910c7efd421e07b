mod tolerance;

use std::fmt::Write as _;
use std::path::Path;

use super::super::{Place, Position};
use super::*;

const FORMATS: [Format; 3] = [
    Format::Ascii,
    Format::Binary(Endian::Little),
    Format::Binary(Endian::Big),
];

const INTEGERS: [(&str, &str, Scalar); 6] = [
    ("char", "int8", Scalar::I8),
    ("uchar", "uint8", Scalar::U8),
    ("short", "int16", Scalar::I16),
    ("ushort", "uint16", Scalar::U16),
    ("int", "int32", Scalar::I32),
    ("uint", "uint32", Scalar::U32),
];

const FLOATS: [(&str, &str, Scalar); 2] = [
    ("float", "float32", Scalar::F32),
    ("double", "float64", Scalar::F64),
];

/// A file in the making: the same calls make all three formats.
struct Writer {
    format: Format,
    bytes: Vec<u8>,
}

impl Writer {
    /// A file with these header lines between `format` and `end_header`.
    fn new(format: Format, header: &str) -> Self {
        let name = match format {
            Format::Ascii => "ascii",
            Format::Binary(Endian::Little) => "binary_little_endian",
            Format::Binary(Endian::Big) => "binary_big_endian",
        };
        let text = format!("ply\nformat {name} 1.0\n{header}\nend_header\n");
        Self {
            format,
            bytes: text.into_bytes(),
        }
    }

    fn value(&mut self, scalar: Scalar, value: f64) -> &mut Self {
        let mut little = match scalar {
            Scalar::I8 => (value as i8).to_le_bytes().to_vec(),
            Scalar::U8 => (value as u8).to_le_bytes().to_vec(),
            Scalar::I16 => (value as i16).to_le_bytes().to_vec(),
            Scalar::U16 => (value as u16).to_le_bytes().to_vec(),
            Scalar::I32 => (value as i32).to_le_bytes().to_vec(),
            Scalar::U32 => (value as u32).to_le_bytes().to_vec(),
            Scalar::F32 => (value as f32).to_le_bytes().to_vec(),
            Scalar::F64 => value.to_le_bytes().to_vec(),
        };
        match self.format {
            Format::Ascii => self.bytes.extend(format!("{value} ").bytes()),
            Format::Binary(Endian::Little) => self.bytes.append(&mut little),
            Format::Binary(Endian::Big) => self.bytes.extend(little.iter().rev()),
        }
        self
    }

    fn values(&mut self, scalar: Scalar, values: &[f64]) -> &mut Self {
        for &value in values {
            self.value(scalar, value);
        }
        self
    }

    fn list(&mut self, length: Scalar, item: Scalar, values: &[f64]) -> &mut Self {
        self.value(length, values.len() as f64).values(item, values)
    }

    fn end_element(&mut self) -> &mut Self {
        if self.format == Format::Ascii {
            self.bytes.push(b'\n');
        }
        self
    }

    fn parse(&self) -> Result<MeshFile, MeshError> {
        MeshFile::parse(&self.bytes, Path::new("mesh.ply"))
    }
}

/// A tetrahedron with its base as one face more: coordinates that every type holds.
const POSITIONS: [[f64; 3]; 4] = [[0., 0., 0.], [3., 0., 0.], [0., 2., 0.], [0., 0., 1.]];
const TRIANGLES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

fn tetrahedron() -> MeshFile {
    MeshFile {
        positions: POSITIONS.to_vec(),
        triangles: TRIANGLES.to_vec(),
        ..MeshFile::default()
    }
}

/// The tetrahedron with coordinates, lengths and indices of these types.
fn written(format: Format, [coordinate, length, index]: [(&str, Scalar); 3]) -> Writer {
    let (c, l, i) = (coordinate.0, length.0, index.0);
    let mut file = Writer::new(
        format,
        &format!(
            "element vertex 4\nproperty {c} x\nproperty {c} y\nproperty {c} z\n\
            element face 4\nproperty list {l} {i} vertex_indices"
        ),
    );
    for position in POSITIONS {
        file.values(coordinate.1, &position).end_element();
    }
    for triangle in TRIANGLES {
        file.list(length.1, index.1, &triangle.map(f64::from))
            .end_element();
    }
    file
}

#[test]
fn every_type_by_both_names_in_every_format() {
    for format in FORMATS {
        for (old, new, scalar) in FLOATS.into_iter().chain(INTEGERS) {
            for name in [old, new] {
                let types = [(name, scalar), ("uchar", Scalar::U8), ("int", Scalar::I32)];
                assert_eq!(written(format, types).parse().unwrap(), tetrahedron());
            }
        }
        for (old, new, scalar) in INTEGERS {
            for name in [old, new] {
                let float = ("float", Scalar::F32);
                for (other_old, _, other) in INTEGERS {
                    let types = [float, (name, scalar), (other_old, other)];
                    assert_eq!(written(format, types).parse().unwrap(), tetrahedron());
                }
            }
        }
    }
}

#[test]
fn the_rest_of_a_file_is_skipped() {
    for format in FORMATS {
        let mut file = Writer::new(
            format,
            "comment made by hand\nobj_info \u{ff} anything\n\nelement camera 2\n\
            property double angle\nproperty list ushort double path\nelement nothing 1000000000000\n\
            element vertex 4\nproperty uchar red\nproperty float z\nproperty list uchar float uv\n\
            property double x\nproperty float y\nelement edge 1\nproperty int a\nproperty int b\n\
            element face 4\nproperty short tag\nproperty list uint uint vertex_index\n\
            property list uchar float texcoord\nproperty float area\nelement tail 1\n\
            property char last",
        );
        for path in [&[][..], &[1.5, 2.5]] {
            file.value(Scalar::F64, 90.0)
                .list(Scalar::U16, Scalar::F64, path)
                .end_element();
        }
        for [x, y, z] in POSITIONS {
            file.value(Scalar::U8, 200.0)
                .value(Scalar::F32, z)
                .list(Scalar::U8, Scalar::F32, &[0.5; 2])
                .value(Scalar::F64, x)
                .value(Scalar::F32, y)
                .end_element();
        }
        file.values(Scalar::I32, &[0., 1.]).end_element();
        for triangle in TRIANGLES {
            file.value(Scalar::I16, -1.0)
                .list(Scalar::U32, Scalar::U32, &triangle.map(f64::from))
                .list(Scalar::U8, Scalar::F32, &[0.25; 6])
                .value(Scalar::F32, 1.0)
                .end_element();
        }
        file.value(Scalar::I8, -3.0).end_element();
        assert_eq!(file.parse().unwrap(), tetrahedron(), "{format:?}");
    }
}

#[test]
fn normals_of_every_layout() {
    // Extra fixed-size properties around them; single and double; one by one or through lists.
    for format in FORMATS {
        for (name, _, scalar) in FLOATS {
            for list in [false, true] {
                let extra = if list {
                    "property list uchar char l\n"
                } else {
                    ""
                };
                let mut file = Writer::new(
                    format,
                    &format!(
                        "element vertex 3\nproperty uchar a\nproperty {name} ny\n\
                        property {name} x\nproperty {name} y\nproperty {name} z\n{extra}\
                        property {name} nz\nproperty {name} nx\n\
                        element face 1\nproperty list uchar int vertex_indices"
                    ),
                );
                let normals = [[0., 0., 0.5], [0.25, 0., 8.], [0., -4., 1.]];
                for ([x, y, z], [nx, ny, nz]) in POSITIONS.into_iter().zip(normals) {
                    file.value(Scalar::U8, 1.0).values(scalar, &[ny, x, y, z]);
                    if list {
                        file.list(Scalar::U8, Scalar::I8, &[1., 2.]);
                    }
                    file.values(scalar, &[nz, nx]).end_element();
                }
                file.list(Scalar::U8, Scalar::I32, &[0., 1., 2.])
                    .end_element();
                let mesh = file.parse().unwrap();
                assert_eq!(mesh.positions, POSITIONS[..3]);
                let read = mesh.normals.unwrap();
                assert_eq!(read.vectors, normals);
                assert_eq!(read.triangles, None);
                assert!(mesh.remarks.is_empty());
            }
        }
    }
}

#[test]
fn faces_may_come_before_vertices() {
    for format in FORMATS {
        let mut file = Writer::new(
            format,
            "element face 4\nproperty list uchar int vertex_indices\nelement vertex 4\n\
            property float x\nproperty float y\nproperty float z",
        );
        for triangle in TRIANGLES {
            file.list(Scalar::U8, Scalar::I32, &triangle.map(f64::from))
                .end_element();
        }
        for position in POSITIONS {
            file.values(Scalar::F32, &position).end_element();
        }
        assert_eq!(file.parse().unwrap(), tetrahedron());
    }
}

#[test]
fn line_ends_and_blanks_of_any_kind() {
    let text = String::from_utf8(written(Format::Ascii, USUAL).bytes).unwrap();
    let variants = [
        text.replace('\n', "\r\n"),
        text.replace(' ', " \t "),
        text.trim_end().to_owned(),
        text.replace("end_header\n", "end_header\n\n\n") + "\n\n",
    ];
    for variant in variants {
        let mesh = MeshFile::parse(variant.as_bytes(), Path::new("")).unwrap();
        assert_eq!(mesh, tetrahedron());
    }
    for format in FORMATS {
        // A header with CRLF before binary data that begins with a line feed.
        let mut file = written(format, USUAL);
        let header = String::from_utf8_lossy(&file.bytes)
            .find("end_header")
            .unwrap();
        let header_text = String::from_utf8(file.bytes[..header + 11].to_vec()).unwrap();
        let body = file.bytes.split_off(header + 11);
        file.bytes = header_text.replace('\n', "\r\n").into_bytes();
        file.bytes.extend(body);
        assert_eq!(file.parse().unwrap(), tetrahedron());
    }
}

const USUAL: [(&str, Scalar); 3] = [
    ("float", Scalar::F32),
    ("uchar", Scalar::U8),
    ("int", Scalar::I32),
];

/// A cube of quads, a pentagon and triangles in turn.
#[test]
fn polygons_among_triangles() {
    for format in FORMATS {
        let mut file = Writer::new(
            format,
            "element vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
            element face 4\nproperty list uchar int vertex_indices",
        );
        for [x, y] in [[0., 0.], [4., 0.], [4., 4.], [2., 1.], [0., 4.], [9., 9.]] {
            file.values(Scalar::F32, &[x, y, 0.0]).end_element();
        }
        for face in [
            &[0., 1., 2.][..],
            &[0., 1., 2., 3., 4.],
            &[0., 1., 2., 4.],
            &[1., 5., 2.],
        ] {
            file.list(Scalar::U8, Scalar::I32, face).end_element();
        }
        let mesh = file.parse().unwrap();
        assert_eq!(mesh.triangles.len(), 1 + 3 + 2 + 1);
        assert_eq!(mesh.triangles[0], [0, 1, 2]);
        assert_eq!(mesh.triangles[4..], [[0, 1, 2], [0, 2, 4], [1, 5, 2]]);
        assert!(mesh.triangles[1..4].iter().flatten().any(|&i| i == 3));
        assert!(mesh.remarks.is_empty());
    }
}

#[test]
fn crossed_polygons_and_missing_normals_are_counted() {
    let mut text = String::from(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
        property float z\nproperty float nx\nproperty float ny\nproperty float nz\n\
        element face 2\nproperty list uchar int vertex_indices\nend_header\n",
    );
    for (position, normal) in [
        ("0 0 0", "0 0 1"),
        ("1 0 0", "nan nan nan"),
        ("0 1 0", "0 0 0"),
        ("2 2 0", "0 0 1"),
    ] {
        writeln!(text, "{position} {normal}").unwrap();
    }
    text += "3 0 1 2\n4 0 3 1 2\n";
    let mesh = MeshFile::parse(text.as_bytes(), Path::new("")).unwrap();
    assert_eq!(mesh.remarks.mended_normals, 2);
    assert_eq!(mesh.remarks.folded_polygons, 1);
    assert!(
        mesh.normals
            .unwrap()
            .vectors
            .iter()
            .all(|n| n[2].abs() == 1.0)
    );
}

/// The error of an ASCII file with this header and body.
fn error(header: &str, body: &str) -> MeshError {
    let text = format!("ply\nformat ascii 1.0\n{header}end_header\n{body}");
    MeshFile::parse(text.as_bytes(), Path::new("")).unwrap_err()
}

const HEADER: &str = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\n";

#[test]
fn ascii_errors_say_line_and_element() {
    for (body, message) in [
        (
            "0 0 0\n1 zero 0\n",
            "vertex 1 of 3 at line 11: found `zero`, expected a number",
        ),
        (
            "0 0 0\n1 0\n0 1 0\n3 0 1 2\n",
            "vertex 1 of 3 at line 11: the line ends, expected a number",
        ),
        (
            "0 0 0\n1 0 0\n",
            "vertex 2 of 3 at line 12: the file ends, expected a number; it is cut off, or its \
            header counts too many",
        ),
        (
            "0 0 0\n1 0 0\n0 -nan(ind) 0\n3 0 1 2\n",
            "vertex 2 of 3 at line 12: coordinate y is NaN, expected a finite number",
        ),
        (
            "0 0 -1e999\n1 nan 0\n0 1 0\n3 2 1 0\n",
            "vertex 0 of 3 at line 10: coordinate z is -inf, expected a finite number",
        ),
        (
            "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
            "face 0 of 1 at line 13: vertex 3 does not exist, expected 0 to 2",
        ),
        (
            "0 0 0\n1 0 0\n0 1 0\n3 0 -1 2\n",
            "face 0 of 1 at line 13: vertex -1 does not exist, expected 0 to 2",
        ),
        (
            "0 0 0\n1 0 0\n0 1 0\n2 0 1\n",
            "the mesh has no faces, expected at least one triangle or polygon; it has 1 face of \
            fewer than 3 corners, which was skipped",
        ),
        (
            "0 0 0\n1 0 0\n0 1 0\n-7 0 1\n",
            "face 0 of 1 at line 13: found `-7`, expected the number of a face's corners",
        ),
        (
            "0 0 0\n1 0 0\n0 1 0\n9999999999 0 1\n",
            "face 0 of 1 at line 13: a face of 9999999999 corners, expected at most 65536; cut it \
            into triangles in the program it comes from",
        ),
        (
            "0 0 0\n1 0 0\n0 1 0\n3 0 1 2.5\n",
            "face 0 of 1 at line 13: found `2.5`, expected the index of a vertex",
        ),
        (
            "0 0 0\n1 0 0\n0 1 0\n3 0 1\n",
            "face 0 of 1 at line 13: the line ends, expected the index of a vertex",
        ),
    ] {
        assert_eq!(error(HEADER, body).to_string(), message);
    }
}

#[test]
fn header_errors_say_the_line() {
    for (header, message) in [
        (
            "elment vertex 3\nproperty float x\n",
            "line 4: found `property`, expected an `element` before it",
        ),
        (
            "element vertex 3\nproprety float x\n",
            "line 4: found `proprety`, expected `format`, `element`, `property`, `comment`, \
            `obj_info` or `end_header`",
        ),
        (
            "element vertex many\n",
            "line 3: found `many`, expected the number of elements",
        ),
        (
            "element vertex -3\n",
            "line 3: found `-3`, expected the number of elements",
        ),
        (
            "element vertex\n",
            "line 3: the line ends, expected the number of elements",
        ),
        (
            "element vertex 5000000000\n",
            "line 3: more than 4294967295 vertices, expected fewer",
        ),
        (
            "element vertex 3 4\n",
            "line 3: found `4`, expected nothing more on the line",
        ),
        (
            "property float x\n",
            "line 3: found `property`, expected an `element` before it",
        ),
        (
            "element vertex 3\nproperty real x\n",
            "line 4: found `real`, expected a type: char, uchar, short, ushort, int, uint, float, \
            double, int8, uint8, int16, uint16, int32, uint32, float32 or float64",
        ),
        (
            "element vertex 3\nproperty float\n",
            "line 4: the line ends, expected the property's name",
        ),
        (
            "comment nothing\n",
            "line 4: the header has no `element vertex`, expected `element vertex COUNT`",
        ),
        (
            "element vertex 3\nproperty float x\nproperty float y\n",
            "line 3: the header has no position in `element vertex`, expected `property float x`, \
            `property float y` and `property float z` after it",
        ),
        (
            "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
            property float y\n",
            "line 3: property `y` is there twice",
        ),
        (
            "element vertex 3\nelement vertex 4\n",
            "line 4: element `vertex` is there twice",
        ),
        (
            "element vertex 0\nproperty float x\nproperty float y\nproperty float z\n",
            "the mesh has no faces, expected at least one triangle or polygon",
        ),
        (
            "element vertex 0\nproperty float x\nproperty float y\nproperty float z\n\
            element range_grid 1\nproperty list uchar int vertex_indices\n",
            "line 7: range grids are not supported; save the mesh with `element face`",
        ),
        (
            "element vertex 0\nproperty float x\nproperty float y\nproperty float z\n\
            element face 1\nproperty list uchar float texcoord\n",
            "line 7: the header has no corners in its `element face` or `element tristrips`, \
            expected `property list uchar int vertex_indices` after it",
        ),
        (
            "format ascii 2.0\n",
            "line 3: found `2.0`, expected version `1.0`",
        ),
        (
            "format binary 1.0\n",
            "line 3: found `binary`, expected `ascii`, `binary_little_endian` or \
            `binary_big_endian`",
        ),
    ] {
        assert_eq!(error(header, "").to_string(), message);
    }
    for (text, message) in [
        (
            "ply\nelement vertex 3\n",
            "line 3: the file ends, expected `end_header`; it is cut off, or its header counts \
            too many",
        ),
        (
            "ply\nend_header\n",
            "line 2: the header has no format, expected `format ascii 1.0`, \
            `format binary_little_endian 1.0` or `format binary_big_endian 1.0`",
        ),
        (
            "ply format\n",
            "line 1: found `format`, expected nothing but `ply` on the first line",
        ),
    ] {
        let error = MeshFile::parse(text.as_bytes(), Path::new("")).unwrap_err();
        assert_eq!(error.to_string(), message);
    }
}

/// The place of the error of the tetrahedron's file after `change`, in both byte orders.
#[track_caller]
fn binary_error(change: impl Fn(&mut Vec<u8>, usize)) -> String {
    let [little, big] = [Endian::Little, Endian::Big].map(|endian| {
        let mut file = written(Format::Binary(endian), USUAL);
        let body = file.bytes.len() - 4 * 12 - 4 * 13;
        change(&mut file.bytes, body);
        match file.parse().unwrap_err() {
            MeshError::Invalid {
                place:
                    Place {
                        position: Position::Byte(byte),
                        element,
                    },
                fault,
            } => {
                let element = element.map(|e| format!("{} {} of {}", e.name, e.index, e.count));
                format!("{element:?} at {}: {fault}", byte - body)
            }
            other => panic!("no place: {other}"),
        }
    });
    assert_eq!(little, big);
    little
}

#[test]
fn binary_errors_say_byte_and_element() {
    let cut = |length: usize| binary_error(|bytes, body| bytes.truncate(body + length));
    assert!(cut(0).starts_with("Some(\"vertex 0 of 4\") at 0: the file ends"));
    assert!(cut(35).starts_with("Some(\"vertex 2 of 4\") at 24: the file ends"));
    assert!(cut(48).starts_with("Some(\"face 0 of 4\") at 48: the file ends"));
    assert!(cut(48 + 13 + 12).starts_with("Some(\"face 1 of 4\") at 62: the file ends"));
    assert_eq!(
        binary_error(|bytes, body| bytes[body + 12..body + 16].fill(0xff)),
        "Some(\"vertex 1 of 4\") at 12: coordinate x is NaN, expected a finite number"
    );
    assert_eq!(
        binary_error(|bytes, body| bytes[body + 48 + 13 + 5..][..4].fill(0xff)),
        "Some(\"face 1 of 4\") at 66: vertex -1 does not exist, expected 0 to 3"
    );
}

#[test]
fn huge_counts_end_where_the_file_ends() {
    for format in FORMATS {
        for count in [1_000_000_000_u64, 10_000_000_000, 999_999_999_999_999_999] {
            for (name, header) in [
                (
                    "vertex",
                    "element vertex COUNT\nproperty float x\nproperty float y\n\
                    property float z\nelement face 1\nproperty list uchar int vertex_indices",
                ),
                (
                    "face",
                    "element vertex 1\nproperty float x\nproperty float y\n\
                    property float z\nelement face COUNT\nproperty list uint int vertex_indices",
                ),
                (
                    "extra",
                    "element extra COUNT\nproperty char a\nproperty double b\n\
                    element vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
                    element face 1\nproperty list uint int vertex_indices",
                ),
            ] {
                let mut file = Writer::new(format, &header.replace("COUNT", &count.to_string()));
                file.values(Scalar::F32, &[0.0; 3]).end_element();
                let message = file.parse().unwrap_err().to_string();
                assert!(
                    message.contains("the file ends")
                        || message.contains("more than 4294967295")
                        || message.contains("found `0`"),
                    "{format:?} {name} {count}: {message}"
                );
            }
        }
    }
}

#[test]
fn huge_lists_end_where_the_file_ends() {
    for format in [Format::Binary(Endian::Little), Format::Binary(Endian::Big)] {
        let header = "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
            property list uint double weights\nelement face 1\n\
            property list uchar int vertex_indices";
        let mut file = Writer::new(format, header);
        file.values(Scalar::F32, &[0.0; 3])
            .value(Scalar::U32, f64::from(u32::MAX));
        let message = file.parse().unwrap_err().to_string();
        assert!(message.contains("vertex 0 of 1 at byte"), "{message}");
        assert!(message.contains("the items of a list"), "{message}");
    }
}
