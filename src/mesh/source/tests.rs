use std::fmt::Write;
use std::io::Cursor;
use std::path::Path;

use super::super::{MeshError, MeshFile, Place, Position};
use super::*;

/// Vertices of a strip of triangles whose files are several blocks long.
const COUNT: u32 = 60_000;

fn position(vertex: u32) -> [f32; 3] {
    [vertex as f32, (vertex % 2) as f32, 0.25]
}

/// A strip, each triangle of three vertices that follow each other.
fn strip() -> MeshFile {
    MeshFile {
        positions: (0..COUNT).map(|i| position(i).map(f64::from)).collect(),
        triangles: (0..COUNT - 2).map(|i| [i, i + 1, i + 2]).collect(),
        ..MeshFile::default()
    }
}

/// An ASCII PLY file of the strip.
fn ascii(faces_first: bool) -> String {
    let [vertex, face] = [COUNT, COUNT - 2];
    let vertex =
        format!("element vertex {vertex}\nproperty float x\nproperty float y\nproperty float z\n");
    let face = format!("element face {face}\nproperty list uchar int vertex_indices\n");
    let mut vertices = String::new();
    for [x, y, z] in (0..COUNT).map(position) {
        writeln!(vertices, "{x} {y} {z}").unwrap();
    }
    let mut faces = String::new();
    for i in 0..COUNT - 2 {
        writeln!(faces, "3 {i} {} {}", i + 1, i + 2).unwrap();
    }
    let parts = if faces_first {
        [face, vertex, "end_header\n".to_owned(), faces, vertices]
    } else {
        [vertex, face, "end_header\n".to_owned(), vertices, faces]
    };
    format!("ply\nformat ascii 1.0\n{}", parts.concat())
}

/// A binary PLY file of the strip, plain little endian or with lists and big endian.
fn binary(plain: bool) -> Vec<u8> {
    let [vertices, faces] = [COUNT, COUNT - 2];
    let [format, label, length] = if plain {
        ["little", "", "uchar"]
    } else {
        ["big", "property list uchar short label\n", "ushort"]
    };
    let mut bytes = format!(
        "ply\nformat binary_{format}_endian 1.0\nelement vertex {vertices}\nproperty float x\n\
        property float y\n{label}property float z\nelement face {faces}\n\
        property list {length} int vertex_indices\nend_header\n"
    )
    .into_bytes();
    for [x, y, z] in (0..COUNT).map(position) {
        if plain {
            bytes.extend([x, y, z].into_iter().flat_map(f32::to_le_bytes));
        } else {
            bytes.extend([x, y].into_iter().flat_map(f32::to_be_bytes));
            let label = (x as usize) % 5;
            bytes.push(label as u8);
            bytes.extend(std::iter::repeat_n([1, 2], label).flatten());
            bytes.extend(z.to_be_bytes());
        }
    }
    for corners in (0..faces).map(|i| [i, i + 1, i + 2]) {
        if plain {
            bytes.push(3);
            bytes.extend(corners.into_iter().flat_map(u32::to_le_bytes));
        } else {
            bytes.extend(3_u16.to_be_bytes());
            bytes.extend(corners.into_iter().flat_map(u32::to_be_bytes));
        }
    }
    bytes
}

/// An OBJ file of the strip, with faces on two lines each.
fn obj() -> String {
    let mut text = String::from("\u{feff}# a strip\n");
    for [x, y, z] in (0..COUNT).map(position) {
        writeln!(text, "v {x} {y} {z}").unwrap();
    }
    for i in 1..COUNT - 1 {
        writeln!(text, "usemtl m \\ \nx\nf {i} \\\n {} {}", i + 1, i + 2).unwrap();
    }
    text
}

fn place_of_error(bytes: &[u8], name: &str) -> Place {
    match MeshFile::parse(bytes, Path::new(name)).unwrap_err() {
        MeshError::Invalid { place, .. } => place,
        other => panic!("{other}"),
    }
}

#[test]
fn files_of_many_blocks() {
    let expected = strip();
    for file in [
        ascii(false).into_bytes(),
        ascii(true).into_bytes(),
        binary(true),
        binary(false),
        obj().into_bytes(),
    ] {
        assert!(file.len() > 3 * BLOCK, "{} bytes", file.len());
        let mesh = MeshFile::parse(&file, Path::new("strip.obj")).unwrap();
        assert!(mesh == expected);
    }
}

#[test]
fn faults_far_from_the_start() {
    let lines = |text: &str| text.lines().count();
    for text in [ascii(false), obj()] {
        let wrong = text.trim_end().to_owned() + "x\n";
        let place = place_of_error(wrong.as_bytes(), "strip.obj");
        assert_eq!(place.position, Position::Line(lines(&wrong)));
    }
    let text = ascii(false);
    let cut = &text[..text.trim_end().rfind('\n').unwrap() + 1];
    let place = place_of_error(cut.as_bytes(), "");
    assert_eq!(place.position, Position::Line(lines(cut) + 1));
    assert_eq!(place.element.unwrap().index, u64::from(COUNT - 3));
    for plain in [true, false] {
        let mut bytes = binary(plain);
        let last = bytes.len() - 4;
        bytes[last..].fill(0x7f);
        let place = place_of_error(&bytes, "");
        assert_eq!(place.position, Position::Byte(last));
        assert_eq!(place.element.unwrap().index, u64::from(COUNT - 3));
        bytes.pop();
        let place = place_of_error(&bytes, "");
        assert_eq!(place.element.unwrap().index, u64::from(COUNT - 3));
        bytes = binary(plain);
        bytes.extend(b" \nmore\0\x1a");
        let mesh = MeshFile::parse(&bytes, Path::new("")).unwrap();
        assert_eq!(mesh.remarks.trailing_bytes, 6);
    }
}

#[test]
fn lines_are_whole() {
    let whole = |text: &str, dialect| whole_lines(text.as_bytes(), dialect);
    assert_eq!(whole("a b", Dialect::Ply), None);
    assert_eq!(whole("a\nb\nc", Dialect::Ply), Some(4));
    assert_eq!(whole("a \\\nb", Dialect::Ply), Some(4));
    assert_eq!(whole("a \\\nb", Dialect::Obj), None);
    assert_eq!(whole("a\nb \\ \t\r\nc", Dialect::Obj), Some(2));
    assert_eq!(whole("a\\\n\\\nb\n\nc", Dialect::Obj), Some(8));
    assert_eq!(whole("a\\\n  \nc", Dialect::Obj), Some(6));
    for dialect in [Dialect::Obj, Dialect::Ply] {
        assert_eq!(whole("a\rb\rc", dialect), Some(4));
        // The LF may follow.
        assert_eq!(whole("a\rb\r", dialect), Some(2));
        assert_eq!(whole("a\r", dialect), None);
    }
    assert_eq!(whole("a\rb \\\rc", Dialect::Obj), Some(2));
    assert_eq!(whole("a \\\r\n\rc", Dialect::Obj), Some(6));
}

#[test]
fn a_long_file_is_seen_once_and_in_order() {
    let bytes: Vec<u8> = (0..5 * BLOCK).map(|i| (i % 251) as u8).collect();
    let mut cursor = Cursor::new(&bytes);
    let mut source = Source::new(&mut cursor, bytes.len()).unwrap();
    let mut seen = Vec::new();
    while !source.window().is_empty() {
        assert_eq!(source.position(), seen.len());
        assert_eq!(source.remaining(), bytes.len() - seen.len());
        // Neither all nor a divisor of it.
        let taken = source.window().len().min(BLOCK / 3 + 1);
        seen.extend_from_slice(&source.window()[..taken]);
        source.skip(taken);
        source.read_on().unwrap();
    }
    assert!(source.has_ended());
    assert_eq!(seen, bytes);
    source.go_to(BLOCK + 7).unwrap();
    assert_eq!(source.window()[..100], bytes[BLOCK + 7..BLOCK + 107]);
}

/// A file of CR alone, so long that a block ends at any place of a line, and one whose line ends
/// are of all kinds.
#[test]
fn line_ends_of_any_kind() {
    let expected = strip();
    for (text, name) in [(ascii(false), "strip.ply"), (obj(), "strip.obj")] {
        let lone = text.replace('\n', "\r");
        let mut kinds = ["\n", "\r\n", "\r"].into_iter().cycle();
        let mixed: String = (text.lines())
            .flat_map(|line| {
                [
                    line,
                    if line.ends_with('\\') {
                        "\r"
                    } else {
                        kinds.next().unwrap()
                    },
                ]
            })
            .collect();
        for text in [lone, mixed] {
            let mesh = MeshFile::parse(text.as_bytes(), Path::new(name)).unwrap();
            assert!(mesh == expected, "{name}");
            let wrong = text.trim_end().to_owned() + "x\r";
            let lines = wrong
                .replace("\r\n", "\n")
                .replace('\r', "\n")
                .lines()
                .count();
            let place = place_of_error(wrong.as_bytes(), name);
            assert_eq!(place.position, Position::Line(lines));
        }
    }
}

#[test]
fn a_file_that_becomes_shorter() {
    let bytes = binary(true);
    let mut cursor = Cursor::new(&bytes[..bytes.len() - 1]);
    let source = Source::new(&mut cursor, bytes.len()).unwrap();
    let error = MeshFile::read(source, Path::new("")).unwrap_err();
    assert!(error.is_transient(), "{error}");
    assert_eq!(
        error.to_string(),
        "the file became shorter while it was read"
    );
    // One that grows has more than its header counts.
    let longer = [&bytes[..], b"more"].concat();
    let mut cursor = Cursor::new(&longer);
    let source = Source::new(&mut cursor, bytes.len()).unwrap();
    let mesh = MeshFile::read(source, Path::new("")).unwrap();
    assert_eq!(mesh.triangles, strip().triangles);
    assert_eq!(mesh.remarks.trailing_bytes, 4);
}

#[test]
fn a_line_longer_than_a_block() {
    let mut text = vec![b'x'; 3 * BLOCK];
    text.extend(b"\nnext\nlast");
    let mut cursor = Cursor::new(&text);
    let mut source = Source::new(&mut cursor, text.len()).unwrap();
    let lines = source.lines(Dialect::Ply).unwrap();
    assert!(lines.starts_with(&text[..=3 * BLOCK]));
    source.skip(3 * BLOCK + 1);
    source.read_on().unwrap();
    let rest = source.lines(Dialect::Ply).unwrap().to_vec();
    assert_eq!(rest, b"next\nlast");
    assert_eq!(source.line(rest.len()).unwrap(), 3);
}
