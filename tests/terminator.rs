//! `shadow_terminator`: where the light of a smooth mesh ends.

use std::f64::consts::PI;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use candela::image::Film;
use candela::scene::Scene;

use crate::images::{bits, film_of, render};
use crate::oracle::assert_agrees;

type Vector = [f64; 3];

/// A PLY file of triangles with a normal for each vertex.
fn ply(vertices: &[[Vector; 2]], triangles: &[[usize; 3]]) -> String {
    let mut text = format!("ply\nformat ascii 1.0\nelement vertex {}\n", vertices.len());
    for property in ["x", "y", "z", "nx", "ny", "nz"] {
        let _ = writeln!(text, "property double {property}");
    }
    let _ = write!(
        text,
        "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        triangles.len()
    );
    for [[x, y, z], [nx, ny, nz]] in vertices {
        let _ = writeln!(text, "{x} {y} {z} {nx} {ny} {nz}");
    }
    for [a, b, c] in triangles {
        let _ = writeln!(text, "3 {a} {b} {c}");
    }
    text
}

/// A sphere of radius 1 from `rows` × 2 `rows` quads, with its own normals; every second row is turned by
/// half a quad.
fn globe(rows: usize) -> String {
    let columns = 2 * rows;
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for row in 0..=rows {
        for column in 0..columns {
            let (sin_polar, cos_polar) = (PI * row as f64 / rows as f64).sin_cos();
            // sin π is not 0 in f64: the pole would be a ring.
            let sin_polar = if row == rows { 0.0 } else { sin_polar };
            let turned = column as f64 + 0.5 * (row % 2) as f64;
            let (sin, cos) = (2.0 * PI * turned / columns as f64).sin_cos();
            vertices.push([[sin_polar * cos, cos_polar, sin_polar * sin]; 2]);
            let next = (column + 1) % columns;
            let [a, b] = [column, next].map(|column| row * columns + column);
            let [c, d] = [a + columns, b + columns];
            if row == rows {
                continue;
            }
            // The shorter diagonal keeps it convex.
            triangles.extend(if row % 2 == 0 {
                [[a, b, c], [b, d, c]]
            } else {
                [[a, b, d], [a, d, c]]
            });
        }
    }
    ply(&vertices, &triangles)
}

/// A scene of one mesh; `rest` has the camera and the lights, `keys` go to the mesh.
fn scene(folder: &Path, mesh: &str, rest: &str, keys: &str) -> Scene {
    fs::write(folder.join("mesh.ply"), mesh).unwrap();
    let text = format!("{rest}\n[objects.o.mesh]\nmaterial = \"m\"\nfile = \"mesh.ply\"\n{keys}\n");
    Scene::parse(&text, folder.join("test.toml")).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

const GEOMETRIC: &str = "shadow_terminator = \"geometric\"";
const HANIKA: &str = "shadow_terminator = \"hanika\"";

/// The sphere seen from the front, lit from the side and a little from behind.
const BALL: &str = "[image]\nresolution = [256, 256]\n\
    [camera.orthographic]\neye = [0, 0, 5]\nlook_at = [0, 0, 0]\nheight = 2.2\n\
    [materials.m.phong]\ndiffuse = 0.5\n\
    [lights.l.point]\nposition = [4, 1, -0.5]\nintensity = 20\n";

fn is_lit(pixel: [f32; 4]) -> bool {
    pixel[0] > 0.0
}

/// How many pixels that both show are lit in the one and dark in the other.
fn lit_and_dark(lit: &Film, dark: &Film) -> usize {
    let pairs = lit.pixels().iter().zip(dark.pixels());
    pairs
        .filter(|&(&a, &b)| a[3] > 0.0 && b[3] > 0.0 && is_lit(a) && !is_lit(b))
        .count()
}

/// A tessellated sphere with exact normals, beside the sphere: what the triangles hide of themselves is a row of
/// steps as high as they are. Lifted, nothing that the sphere lights is dark, and what is lit
/// beyond its terminator (p is within the sphere) goes with the square of the tessellation.
#[test]
fn a_finer_globe_approaches_the_sphere() {
    let folder = tempfile::tempdir().unwrap();
    let sphere = render(
        &format!("{BALL}[objects.o.sphere]\nmaterial = \"m\"\ncenter = [0, 0, 0]\nradius = 1\n"),
        1,
    );
    for rows in [8, 16, 32, 64, 128] {
        let globe = globe(rows);
        let [geometric, hanika] =
            [GEOMETRIC, HANIKA].map(|keys| film_of(&scene(folder.path(), &globe, BALL, keys), 1));
        let before = [
            lit_and_dark(&sphere, &geometric),
            lit_and_dark(&geometric, &sphere),
        ];
        let after = [
            lit_and_dark(&sphere, &hanika),
            lit_and_dark(&hanika, &sphere),
        ];
        println!("{rows} rows: {before:?} pixels before, {after:?} after");
        // 617, 325, 131, 104 and 46 of 12 442 lit pixels.
        assert!(before[0] * rows > 4000, "{rows} rows: {before:?}");
        assert_eq!(after[0], 0, "{rows} rows");
        // 310, 80, 24, 8 and 2.
        assert!(after[1] * rows * rows < 40_000, "{rows} rows: {after:?}");
    }
}

/// Only V changes: what both rules light has the same bits.
#[test]
fn what_is_lit_keeps_its_radiance() {
    let folder = tempfile::tempdir().unwrap();
    let globe = globe(8);
    let [geometric, hanika] =
        [GEOMETRIC, HANIKA].map(|keys| film_of(&scene(folder.path(), &globe, BALL, keys), 1));
    let mut kept = 0;
    for (a, b) in bits(&geometric).into_iter().zip(bits(&hanika)) {
        if a[0] != 0 && b[0] != 0 {
            assert_eq!(a, b);
            kept += 1;
        }
    }
    assert!(kept > 10_000, "{kept}");
}

/// A mesh that says `"geometric"` has the bits of one that says nothing; so has one with
/// `"hanika"` that is shaded flat, and one whose normals are those of its triangles.
#[test]
fn nothing_changes_where_nothing_is_lifted() {
    let folder = tempfile::tempdir().unwrap();
    let smooth = globe(6);
    // The sides of a cube, apart.
    let corner = |bits: usize| [0, 1, 2].map(|axis| (bits >> axis & 1) as f64 - 0.5);
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for side in 0..2 {
            let mut normal = [0.0; 3];
            normal[axis] = 2.0 * side as f64 - 1.0;
            let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
            let first = vertices.len();
            vertices.extend([0, u, u | v, v].map(|bits| [corner(bits | side << axis), normal]));
            triangles.extend([[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(|i| i + first)));
        }
    }
    let cube = ply(&vertices, &triangles);
    // One light in the plane of a side.
    let view = "[image]\nresolution = [96, 96]\n\
        [camera.perspective]\neye = [2, 3, 4]\nlook_at = [0, 0, 0]\nvertical_fov = 30\n\
        [materials.m.phong]\ndiffuse = 0.5\nspecular = 0.5\nshininess = 3\n\
        [lights.a.point]\nposition = [1, 4, 2]\nintensity = 20\n\
        [lights.b.point]\nposition = [0.5, 2, 3]\nintensity = 20\n";
    for (mesh, others) in [(&smooth, vec![GEOMETRIC]), (&cube, vec![GEOMETRIC, HANIKA])] {
        let film = |keys: &str| bits(&film_of(&scene(folder.path(), mesh, view, keys), 4));
        for keys in others {
            assert!(film("") == film(keys), "{keys}");
        }
        let flat = |keys: &str| film(&format!("smooth = false\n{keys}"));
        assert!(flat("") == flat(HANIKA));
    }
}

/// One triangle whose vertex normals lean apart, seen from above; p is (0.5, 0.5, 0) in the middle.
fn leaning() -> String {
    let vertices = [
        [[0.0, 0.0, 0.0], [-1.0, 0.0, 0.0]],
        [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        [[0.5, 1.0, 0.0], [0.0, 0.0, 1.0]],
    ];
    ply(&vertices, &[[0, 1, 2]])
}

fn from_above(lights: &[Vector]) -> String {
    let mut text = "[image]\nresolution = [33, 33]\n\
        [camera.orthographic]\neye = [0.5, 0.5, 2]\nlook_at = [0.5, 0.5, 0]\nheight = 1\n\
        [materials.m.phong]\ndiffuse = 0.5\nspecular = 0.5\nshininess = 3\n"
        .to_owned();
    for (index, light) in lights.iter().enumerate() {
        let _ = write!(
            text,
            "[lights.l{index}.point]\nposition = {light:?}\nintensity = 20\n"
        );
    }
    text
}

/// b = (¼, ¼, ½) and (v₀ − p)·n₀ = ½: p′ = (0.375, 0.5, 0), to the bit. A light there, one between p and
/// p′, one beyond, one at p, and one at a corner.
#[test]
fn lights_around_the_start() {
    let folder = tempfile::tempdir().unwrap();
    for light in [
        [0.375, 0.5, 0.0],
        [0.4375, 0.5, 0.0],
        [0.25, 0.5, 0.0],
        [0.5, 0.5, 0.0],
        [0.0, 0.0, 0.0],
        [0.375, 0.5, 1e-300],
        [0.375, 0.5, -1e-9],
    ] {
        let view = from_above(&[light, [0.5, 0.5, 3.0]]);
        for keys in [
            HANIKA,
            "shadow_terminator = \"hanika\"\nscale = [-1, 1, 1]\ntranslate = [1, 0, 0]",
        ] {
            let scene = scene(folder.path(), &leaning(), &view, keys);
            let lit = assert_agrees(&format!("{light:?} {keys}"), &scene);
            assert!(lit > 100, "{light:?}");
        }
    }
}

/// A lid over the triangle, nearer to it than the lift: seen from the side, points below the lid start above it
/// and are lit by a lamp over it, and darkened by one below.
#[test]
fn starts_on_the_other_side_of_something() {
    let folder = tempfile::tempdir().unwrap();
    let vertices = [
        [[0.0, 0.0, 0.0], [-0.8, 0.0, 0.6]],
        [[1.0, 0.0, 0.0], [0.8, 0.0, 0.6]],
        [[0.5, 1.0, 0.0], [0.0, 0.0, 1.0]],
    ];
    let mesh = ply(&vertices, &[[0, 1, 2]]);
    let lid = "[objects.lid.triangle]\nmaterial = \"m\"\n\
        vertices = [[0.3, 0.1, 0.05], [0.7, 0.1, 0.05], [0.5, 0.6, 0.05]]";
    for (side, lamp) in [
        (1.0, [0.5, 0.5, 3.0]),
        (1.0, [0.5, -2.0, 0.02]),
        (-1.0, [0.5, 0.5, -3.0]),
    ] {
        let view = format!(
            "[image]\nresolution = [64, 64]\n\
             [camera.perspective]\neye = [0.5, -3, {:?}]\nlook_at = [0.5, 0.4, 0]\n\
             vertical_fov = 10\n[materials.m.phong]\ndiffuse = 0.5\n\
             [lights.l.point]\nposition = {lamp:?}\nintensity = 20\n",
            0.4 * side
        );
        for keys in [GEOMETRIC, HANIKA] {
            for lid in ["", lid] {
                let keys = format!("{keys}\n{lid}");
                let scene = scene(folder.path(), &mesh, &view, &keys);
                assert_agrees(&format!("{lamp:?} {keys}"), &scene);
            }
        }
        if side * lamp[2] == 3.0 && side == 1.0 {
            // Without the lid's own pixels: what of the mesh it keeps dark.
            let lit = |keys: &str| {
                let scene = scene(folder.path(), &mesh, &view, &format!("{keys}\n{lid}"));
                film_of(&scene, 1)
                    .pixels()
                    .iter()
                    .filter(|&&pixel| is_lit(pixel))
                    .count()
            };
            let [geometric, hanika] = [GEOMETRIC, HANIKA].map(lit);
            assert!(hanika > geometric + 10, "{geometric}, {hanika}");
        }
    }
}
