//! Mesh files that are damaged, or made to be expensive.

use std::path::Path;

use candela::mesh::MeshError;
use candela::scene::MeshFile;

use crate::fuzzing;

/// A pyramid with a square base, in the three formats of PLY with different properties, and OBJ.
fn corpus() -> Vec<Vec<u8>> {
    let positions = [
        [0., 0., 0.],
        [2., 0., 0.],
        [2., 2., 0.],
        [0., 2., 0.],
        [1., 1., 1.5_f32],
    ];
    let sides = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4_u32]];

    let mut ascii = String::from(
        "ply\nformat ascii 1.0\ncomment a pyramid\nelement vertex 5\nproperty float x\n\
        property float y\nproperty float z\nproperty float nx\nproperty float ny\n\
        property float nz\nelement face 5\nproperty list uchar int vertex_indices\nend_header\n",
    );
    let mut obj = String::from("# a pyramid\nmtllib p.mtl\no pyramid\n");
    for [x, y, z] in positions {
        ascii += &format!("{x} {y} {z} {} {} 0.25\n", x - 1.0, y - 1.0);
        obj += &format!(
            "v {x:.6} {y:.6} {z:e}\nvn {} {} 0.5\nvt 0 1\n",
            x - 1.0,
            y - 1.0
        );
    }
    ascii += "4 3 2 1 0\n";
    obj += "g base\nf 4 3 2 1\ng sides\nusemtl red\ns 1\n";
    for [a, b, c] in sides {
        ascii += &format!("3 {a} {b} {c}\n");
        obj += &format!("f {}/1/{} {}//{} -1//-1\n", a + 1, a + 1, b + 1, b + 1);
    }
    obj += "f 1 2 5 \\\n 3 4\nl 1 2\n";
    let concave_obj = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nv 0 3 0\nv 0 2 0\n\
        f 1 2 3 4 5 6 7\nf 7 6 5 4 3 2 1\n";

    let mut little = b"ply\nformat binary_little_endian 1.0\nelement vertex 5\nproperty float x\n\
        property float y\nproperty float z\nelement face 5\n\
        property list uchar int vertex_indices\nend_header\n"
        .to_vec();
    let mut big = b"ply\r\nformat binary_big_endian 1.0\r\nelement nothing 3\r\n\
        element vertex 5\r\nproperty double x\r\nproperty double y\r\nproperty uchar red\r\n\
        property list uchar short extra\r\nproperty double z\r\nelement face 5\r\n\
        property float area\r\nproperty list ushort uint vertex_index\r\nend_header\r\n"
        .to_vec();
    for [x, y, z] in positions {
        little.extend([x, y, z].into_iter().flat_map(f32::to_le_bytes));
        big.extend([x, y].into_iter().flat_map(|v| f64::from(v).to_be_bytes()));
        big.extend([200, 2, 0, 7, 0, 8]);
        big.extend(f64::from(z).to_be_bytes());
    }
    for face in std::iter::once(&[3, 2, 1, 0][..]).chain(sides.iter().map(|side| &side[..])) {
        little.push(face.len() as u8);
        little.extend(face.iter().flat_map(|index| index.to_le_bytes()));
        big.extend(1_f32.to_be_bytes());
        big.extend((face.len() as u16).to_be_bytes());
        big.extend(face.iter().flat_map(|index| index.to_be_bytes()));
    }
    // The sides as strips, beside the base as a face and before the vertices in one of the files.
    let mut strips = b"ply\nformat binary_big_endian 1.0\nelement tristrips 2\n\
        property list int int vertex_indices\nelement vertex 5\nproperty float x\nproperty float y\n\
        property float z\nelement face 1\nproperty list uchar float vertex_index\nend_header\n"
        .to_vec();
    for strip in [&[0, 1, 4, 2, 2, -1, 2, 3, 4_i32][..], &[3, 0, 4, -1]] {
        strips.extend((strip.len() as i32).to_be_bytes());
        strips.extend(strip.iter().flat_map(|index| index.to_be_bytes()));
    }
    strips.extend(positions.iter().flatten().flat_map(|x| x.to_be_bytes()));
    strips.push(4);
    strips.extend([3., 2., 1., 0_f32].into_iter().flat_map(f32::to_be_bytes));
    let ascii_strips = "ply\rformat ascii 1.0\rMade by hand\relement vertex 5\rproperty float x\r\
        property float y\rproperty float z\relement tristrips 1\r\
        property list int int vertex_indices\rend_header\r0 0 0\r2 0 0 7\r2 2 0\r0 2 0\r1 1 1.5\r\
        9 0 1 4 -1 1 2 4 3 0\rmore\r\x1a";
    let unlined = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n\
        property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0 2 0 0\n2 2 0\n0 2 0 1 1 1.5 4 0\n1 2 3\n\n3\n0 1 4";
    let ahead_obj = "f 1//1 2//2 3//9\nf 1/ 2// 5\nf 4//-1 3//1 2\nf 1 2\nv 0 0 0\nv 2 0 0 #x\n\
        v 2 2 0 1 2 3 4 5\nvn 0 0 1\nvn -nan(ind) 1.#QNAN 1e999\nv 0 2 0\rv 1 1 1.5\rv nan 0 0\n\
        vw 1 2\nmtllib a\\\nf 5 3 4\\ \n 1\n\x1a";

    vec![
        strips,
        ascii_strips.into(),
        unlined.into(),
        ahead_obj.into(),
        ascii.into_bytes(),
        little,
        big,
        obj.into_bytes(),
        concave_obj.into(),
    ]
}

/// The mesh, or the error; what an accepted mesh promises is checked.
fn read(bytes: &[u8]) -> Result<MeshFile, MeshError> {
    let mesh = MeshFile::parse(bytes, Path::new("fuzzed.obj"))?;
    assert!(!mesh.triangles.is_empty());
    assert!(mesh.positions.iter().flatten().all(|x| x.is_finite()));
    let within = |triangles: &[[u32; 3]], count: usize| {
        triangles.iter().flatten().all(|&i| (i as usize) < count)
    };
    assert!(within(&mesh.triangles, mesh.positions.len()));
    if let Some(normals) = &mesh.normals {
        let valid = |n: &[f64; 3]| n.iter().all(|x| x.is_finite()) && *n != [0.0; 3];
        assert!(normals.vectors.iter().all(valid));
        match &normals.triangles {
            Some(triangles) => {
                assert_eq!(triangles.len(), mesh.triangles.len());
                assert!(within(triangles, normals.vectors.len()));
            }
            None => assert_eq!(normals.vectors.len(), mesh.positions.len()),
        }
    }
    let mut end = 0;
    for group in &mesh.groups {
        assert!(end <= group.triangles.start && group.triangles.start < group.triangles.end);
        end = group.triangles.end;
    }
    assert!(end as usize <= mesh.triangles.len());
    Ok(mesh)
}

#[test]
fn the_corpus_is_valid() {
    for bytes in corpus() {
        assert_eq!(fuzzing::check(&bytes, read), Ok(true));
    }
}

#[test]
fn damaged_files() {
    let corpus = corpus();
    let corpus: Vec<&[u8]> = corpus.iter().map(Vec::as_slice).collect();
    let outcomes = fuzzing::run("mesh", &corpus, 100_000, read);
    // Both ends must be reached, or the mutations are too timid or too wild.
    assert!(outcomes.accepted * 50 > outcomes.refused, "{outcomes:?}");
    assert!(outcomes.refused * 2 > outcomes.accepted, "{outcomes:?}");
}

/// Files of a few hundred kB to some MB whose form is legal and whose cost would be anything but
/// linear in a careless reader.
#[test]
fn expensive_files() {
    const SIZE: usize = 300_000;
    let mut state = 1_u64;
    let mut random = |end: u64| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 33) % end
    };
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    let repeated = |line: &str| format!("{square}{}", line.repeat(SIZE / line.len()));
    let polygon_of = |corners: usize, vertex: &mut dyn FnMut() -> String| {
        let mut text: String = (0..corners).map(|_| vertex()).collect();
        text += "f";
        for corner in 1..=corners {
            text += &format!(" {corner}");
        }
        text
    };
    let scribble = polygon_of(15_000, &mut || {
        format!("v {} {} 0\n", random(1000), random(1000))
    });
    let mut tooth = 0;
    let comb = polygon_of(15_000, &mut || {
        tooth += 1;
        format!(
            "v {} {} 0\n",
            tooth,
            if tooth % 2 == 0 { 9 } else { tooth % 7 }
        )
    });
    let many_scribbles: String = (0..SIZE / 200)
        .map(|_| {
            let corners: String = (0..64).map(|_| format!(" {}", 1 + random(9))).collect();
            format!("f{corners}\n")
        })
        .collect();
    let nine: String = (0..9)
        .map(|i| format!("v {} {} 0\n", i * i, i * 7 % 9))
        .collect();
    let few_places: String = (0..60_000).map(|_| format!(" {}", 1 + random(9))).collect();
    let mut half_turns = 0.0_f64;
    let spiral = polygon_of(8_000, &mut || {
        half_turns += 0.02;
        let inward = half_turns > 80.0;
        let angle = if inward {
            160.0 - half_turns
        } else {
            half_turns
        };
        let radius = 1.0 + angle - if inward { 0.5 } else { 0.0 };
        format!(
            "v {:.3} {:.3} 0\n",
            radius * angle.cos(),
            radius * angle.sin()
        )
    });
    let one_char_corners = format!("{square}f{}\n", " 1".repeat(60_000)).repeat(2);
    let header = "ply\nformat ascii 1.0\n";
    for (name, text) in [
        ("scribble", scribble),
        ("comb", comb),
        ("few places", format!("{nine}f{few_places}\n")),
        ("spiral", spiral),
        ("many scribbles", nine + &many_scribbles),
        ("short corners", one_char_corners),
        ("groups", repeated("g a\nf 1 2 3\n")),
        ("empty groups", repeated("g a\n")),
        ("junk in groups", repeated("g \u{1}\u{2}\n")),
        (
            "normals now and then",
            format!("vn 0 0 1\n{}", repeated("f 1 2 3\nf 1//1 2//1 3//1\n")),
        ),
        ("one line", "f 1 2 3 \\\n".repeat(SIZE / 10)),
        (
            "faces above their vertices",
            format!("{}{square}", "f 1 2 3\n".repeat(SIZE / 8)),
        ),
        ("normals that are not there", repeated("f 1//9 2//9 3//9\n")),
        (
            "vertices that are not finite",
            repeated("v\n") + "f 1 2 3\n",
        ),
        ("a used one at the end", repeated("v\n") + "f 1 2 -1\n"),
        ("unknown statements", repeated("\u{1}\n") + "f 1 2 3\n"),
        ("lone returns", repeated("\r\r\\\r\r") + "f 1 2 3\n"),
        ("joined blanks", repeated("\\ \t \n") + "f 1 2 3\n"),
        ("names", repeated("mtllib a\\\n") + "f 1 2 3\n"),
        (
            "one number a line",
            format!(
                "{header}element vertex 20000\nproperty float x\nproperty float y\nproperty float z\n\
                element face 20000\nproperty list uchar int vertex_indices\nend_header\n{}{}",
                "1\n".repeat(60_000),
                "3\n0\n1\n2\n".repeat(20_000)
            ),
        ),
        (
            "strips",
            format!(
                "{header}element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n\
                0 1 0\n{} {}\n",
                SIZE / 2,
                "0 1 2 ".repeat(SIZE / 6)
            ),
        ),
        ("no line end", "v".repeat(SIZE)),
        ("long number", format!("v 1{} 0 0\n", "0".repeat(SIZE))),
        (
            "long fraction",
            format!("v 0.{} 0 0\n", "123456789".repeat(SIZE / 9)),
        ),
        (
            "elements",
            format!("{header}{}", "element a 9\n".repeat(SIZE / 12)),
        ),
        (
            "properties",
            format!(
                "{header}element vertex 1\n{}",
                "property char a\n".repeat(SIZE / 16)
            ),
        ),
        (
            "comments",
            format!("{header}{}", "comment\n".repeat(SIZE / 8)),
        ),
        ("blank lines", format!("{header}{}", "\n".repeat(SIZE))),
    ] {
        if let Err(broken) = fuzzing::check(text.as_bytes(), read) {
            panic!("`{name}` {broken}");
        }
    }
}

/// The densest legal files: a byte or two a corner, large enough that the multiple counts.
#[test]
fn dense_files() {
    let mut list = vec![255];
    list.extend((0..255).map(|i| i % 3));
    let mut ply = b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n\
        property float y\nproperty float z\nelement face 100000\n\
        property list uchar uchar vertex_indices\nend_header\n"
        .to_vec();
    ply.extend((0..9_u8).flat_map(|i| f32::from(i * i % 5).to_le_bytes()));
    ply.extend(list.repeat(100_000));
    let mut obj = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n");
    obj += &format!("f{}\n", " 1 2 3".repeat(20)).repeat(200_000);
    let mut strips = b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n\
        property float y\nproperty float z\nelement tristrips 1\n\
        property list uint uchar vertex_indices\nend_header\n"
        .to_vec();
    strips.extend((0..9_u8).flat_map(|i| f32::from(i * i % 5).to_le_bytes()));
    strips.extend(30_000_000_u32.to_le_bytes());
    strips.extend([0, 1, 2].repeat(10_000_000));
    for bytes in [&ply, obj.as_bytes(), &strips] {
        // Refused, since no legal answer fits in the allowance.
        assert_eq!(fuzzing::check(bytes, read), Ok(false));
    }
    // Read, with room to spare.
    let mut wide = b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n\
        property float y\nproperty float z\nelement tristrips 1\n\
        property list uint int vertex_indices\nend_header\n"
        .to_vec();
    wide.extend((0..9_u8).flat_map(|i| f32::from(i * i % 5).to_le_bytes()));
    wide.extend(6_000_000_u32.to_le_bytes());
    wide.extend((0..6_000_000_u32).flat_map(|i| (i % 3).to_le_bytes()));
    let ahead =
        "f 1//1 2//2 3//9\n".repeat(600_000) + "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 1 0\n";
    for bytes in [&wide, ahead.as_bytes()] {
        assert_eq!(fuzzing::check(bytes, read), Ok(true));
    }
}
