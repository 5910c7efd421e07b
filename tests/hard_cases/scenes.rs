//! The scenes of the table, as text.

use std::fmt::Write;
use std::path::Path;

use candela::scene::Scene;

use crate::images::parse;

pub(super) type Vector = [f64; 3];

/// Relative errors that are allowed.
const BAR: f64 = 1e-4;

/// Where the exponent n is so large that the last digits of a cosine show.
const BAR_OF_SHARP_LOBES: f64 = 1e-3;

/// What the errors say of spheres and triangles that are too large, and of lights that are too near to a plane.
const TOO_LARGE: &str = "1e10 times as much as `eye` is away from it and from `look_at`";
const TOO_NEAR: &str = "1e-11 of its distance from the point of that plane";

/// A row of the table.
pub(super) struct Case {
    pub(super) name: String,
    pub(super) scene: Scene,
    /// The relative error that is allowed.
    pub(super) bar: f64,
    /// Where the scene is refused: what the error has to say.
    pub(super) refusal: Option<&'static str>,
}

impl Case {
    fn new(name: impl Into<String>, text: &str) -> Self {
        Self::of(name, parse(text))
    }

    fn of(name: impl Into<String>, scene: Scene) -> Self {
        Self {
            name: name.into(),
            scene,
            bar: BAR,
            refusal: None,
        }
    }

    fn refused(self, refusal: &'static str) -> Self {
        Self {
            refusal: Some(refusal),
            ..self
        }
    }
}

/// A scene that is written piece by piece.
#[derive(Clone)]
struct Text {
    resolution: [u32; 2],
    eye: Vector,
    look_at: Vector,
    fov: f64,
    shininess: f64,
    lights: Vec<(Vector, f64)>,
    objects: String,
    count: usize,
}

/// A ball on a floor, with a light at (2, 3, 2).
fn still() -> Text {
    Text::looking([0.0, 1.0, 4.0], [0.0, 0.5, 0.0], 40.0)
        .light([2.0, 3.0, 2.0], 12.0)
        .sphere([0.0, 0.5, 0.0], 0.5)
        .floor()
}

impl Text {
    fn looking(eye: Vector, look_at: Vector, fov: f64) -> Self {
        Self {
            resolution: [24, 16],
            eye,
            look_at,
            fov,
            shininess: 50.0,
            lights: Vec::new(),
            objects: String::new(),
            count: 0,
        }
    }

    fn light(mut self, position: Vector, intensity: f64) -> Self {
        self.lights.push((position, intensity));
        self
    }

    fn object(mut self, kind: &str, keys: &str) -> Self {
        let number = self.count;
        self.count += 1;
        writeln!(
            self.objects,
            "[objects.o{number}.{kind}]\nmaterial = \"m\"\n{keys}"
        )
        .unwrap();
        self
    }

    fn sphere(self, center: Vector, radius: f64) -> Self {
        self.object(
            "sphere",
            &format!("center = {center:?}\nradius = {radius:?}"),
        )
    }

    fn plane(self, point: Vector, normal: Vector) -> Self {
        self.object("plane", &format!("point = {point:?}\nnormal = {normal:?}"))
    }

    fn floor(self) -> Self {
        self.plane([0.0; 3], [0.0, 1.0, 0.0])
    }

    fn triangle(self, vertices: [Vector; 3]) -> Self {
        self.object("triangle", &format!("vertices = {vertices:?}"))
    }

    fn mesh(self, keys: &str) -> Self {
        self.object("mesh", keys)
    }

    fn text(&self) -> String {
        let Self {
            resolution,
            eye,
            look_at,
            fov,
            shininess,
            objects,
            ..
        } = self;
        // Looking straight down, up is to the back.
        let up = if eye[0] == look_at[0] && eye[2] == look_at[2] {
            [0.0, 0.0, -1.0]
        } else {
            [0.0, 1.0, 0.0]
        };
        let mut text = format!(
            "[image]\nresolution = {resolution:?}\n[camera.perspective]\neye = {eye:?}\n\
             look_at = {look_at:?}\nup = {up:?}\nvertical_fov = {fov:?}\n[materials.m.phong]\n\
             diffuse = [0.7, 0.5, 0.3]\nspecular = 0.3\nshininess = {shininess:?}\n"
        );
        for (number, (position, intensity)) in self.lights.iter().enumerate() {
            writeln!(
                text,
                "[lights.l{number}.point]\nposition = {position:?}\nintensity = {intensity:?}"
            )
            .unwrap();
        }
        text + objects
    }

    fn case(&self, name: impl Into<String>) -> Case {
        Case::new(name, &self.text())
    }

    /// With mesh files from a folder.
    fn case_in(&self, name: impl Into<String>, folder: &Path) -> Case {
        let name = name.into();
        let path = folder.join("scene.toml");
        std::fs::write(&path, self.text()).unwrap();
        Case::of(
            name,
            Scene::load(&path).unwrap_or_else(|error| panic!("{error}")),
        )
    }
}

fn scaled(v: Vector, factor: f64) -> Vector {
    v.map(|x| x * factor)
}

/// All rows, in the order of the table.
pub(super) fn all(folder: &Path) -> Vec<Case> {
    let mut cases = sizes();
    cases.extend(places());
    cases.extend(worlds());
    cases.extend(views());
    cases.extend(lobes());
    cases.extend(lights());
    cases.extend(contacts());
    cases.extend(thin());
    cases.extend(smooth(folder));
    cases.extend(intensities());
    cases
}

fn sizes() -> Vec<Case> {
    let powers = [-12, -9, -6, -3, 0, 3, 6, 9, 12];
    let case = |power: i32| {
        let s = 10.0_f64.powi(power);
        Text::looking([0.0, s, 4.0 * s], [0.0, 0.5 * s, 0.0], 40.0)
            .light([2.0 * s, 3.0 * s, 2.0 * s], 12.0 * s * s)
            .sphere([0.0, 0.5 * s, 0.0], 0.5 * s)
            .floor()
            .triangle([[s, 0.0, 0.0], [1.5 * s, s, 0.0], [2.0 * s, 0.0, -0.5 * s]])
            .case(format!(
                "a ball, a floor and a triangle, 1e{power} times as large"
            ))
    };
    powers.map(case).into()
}

fn places() -> Vec<Case> {
    let away = |distance: f64| {
        let at = |v: Vector| [v[0] + distance, v[1] - distance, v[2] + distance];
        Text::looking(at([0.0, 1.0, 4.0]), at([0.0, 0.5, 0.0]), 40.0)
            .light(at([2.0, 3.0, 2.0]), 12.0)
            .sphere(at([0.0, 0.5, 0.0]), 0.5)
            .plane(at([0.0; 3]), [0.0, 1.0, 0.0])
            .triangle([[1.0, 0.0, 0.0], [1.5, 1.0, 0.0], [2.0, 0.0, -0.5]].map(at))
            .case(format!("{distance:e} m away from the origin"))
    };
    let tilted = |distance: f64| {
        let point = [distance, -0.1 * distance, 0.0];
        Text::looking([0.0, 1.0, 4.0], [0.0, 0.5, 0.0], 40.0)
            .light([2.0, 3.0, 2.0], 12.0)
            .sphere([0.0, 0.5, 0.0], 0.5)
            .plane(point, [0.1, 1.0, 0.05])
            .case(format!("a tilted plane whose point is {distance:e} m away"))
    };
    let tilted_far = |distance: f64| {
        Text::looking([distance, 1.0, 4.0], [distance, 0.5, 0.0], 40.0)
            .light([distance + 2.0, 3.0, 2.0], 12.0)
            .sphere([distance, 0.5, 0.0], 0.5)
            .plane([distance, 0.0, 0.0], [0.1, 1.0, 0.05])
            .case(format!("a tilted plane, all of it {distance:e} m away"))
    };
    let huge_triangle = |size: f64| {
        Text::looking([0.0, 1.0, 4.0], [0.0, 0.5, 0.0], 40.0)
            .light([2.0, 3.0, 2.0], 12.0)
            .sphere([0.0, 0.5, 0.0], 0.5)
            .triangle([
                [-size, -0.1 * size, size],
                [size, 0.1 * size, size],
                [0.0, 0.0, -size],
            ])
            .case(format!("a triangle of {size:e} m under a ball of 1 m"))
    };
    vec![
        away(1e6),
        away(1e9),
        away(1e12),
        away(1e15),
        tilted_far(1e15),
        tilted(1e6),
        tilted(1e12),
        tilted(1e15),
        huge_triangle(1e6),
        huge_triangle(1e9),
        huge_triangle(1e15).refused(TOO_LARGE),
    ]
}

fn worlds() -> Vec<Case> {
    let radius = 6.4e6;
    let planet = Text::looking([0.0, 1.7, 0.0], [0.0, 1.4, -4.0], 50.0)
        .light([2.0, 5.0, -3.0], 60.0)
        .sphere([0.0, -radius, 0.0], radius)
        .sphere([0.5, 0.3, -4.0], 0.3)
        .sphere([-0.6, 0.1, -3.0], 0.1)
        .case("a planet of 6.4e6 m under an eye at 1.7 m");
    let colossal = |radius: f64| {
        Text::looking([0.0, 1.0, 4.0], [0.0, 0.5, 0.0], 40.0)
            .light([2.0, 3.0, 2.0], 12.0)
            .sphere([0.0, -radius, 0.0], radius)
            .sphere([0.0, 0.5, 0.0], 0.5)
            .sphere([0.8, 0.001, 0.8], 0.001)
            .case(format!("a ball of 1 m on a sphere of {radius:e} m"))
    };
    let micro = |radius: f64| {
        Text::looking([0.0, 1e-6, 4e-6], [0.0, 5e-7, 0.0], 40.0)
            .light([2e-6, 3e-6, 2e-6], 1.2e-11)
            .sphere([0.0, -radius, 0.0], radius)
            .sphere([0.0, 1e-6, 0.0], 1e-6)
            .case(format!("a ball of 1e-6 m on a sphere of {radius:e} m"))
    };
    let mut grains = Text::looking([0.0, 0.02, 0.06], [0.0; 3], 30.0)
        .light([0.05, 0.08, 0.05], 0.01)
        .floor();
    for x in -3_i32..=3 {
        for z in -2_i32..=2 {
            grains = grains.sphere([f64::from(x) * 0.004, 0.001, f64::from(z) * 0.005], 0.001);
        }
    }
    vec![
        planet,
        colossal(1e9),
        colossal(1e12).refused(TOO_LARGE),
        colossal(1e15).refused(TOO_LARGE),
        micro(1.0),
        micro(1e4),
        micro(1e6).refused(TOO_LARGE),
        micro(1e9).refused(TOO_LARGE),
        micro(1e12).refused(TOO_LARGE),
        grains.case("1 mm spheres that touch a plane"),
    ]
}

fn views() -> Vec<Case> {
    let telephoto = Text::looking([0.0, 4000.0, 39_800.0], [0.0, 0.5, 0.0], 0.003)
        .light([2.0, 3.0, 2.0], 12.0)
        .sphere([0.0, 0.5, 0.0], 0.5)
        .floor()
        .case("telephoto at 40 km");
    let grazing = |height: f64| {
        Text::looking([0.0, height, 4.0], [0.0, height, 0.0], 40.0)
            .light([2.0, 3.0, 2.0], 12.0)
            .sphere([0.0, 0.5, 0.0], 0.5)
            .floor()
            .case(format!("an eye {height:e} m above the floor"))
    };
    let one = |side: u32| {
        Text {
            resolution: [side, side],
            ..still()
        }
        .case(format!("{side} × {side} pixels"))
    };
    vec![
        telephoto,
        grazing(1e-3),
        grazing(1e-6),
        grazing(1e-9),
        one(1),
    ]
}

fn lobes() -> Vec<Case> {
    let case = |shininess: f64| Case {
        bar: if shininess >= 1e6 {
            BAR_OF_SHARP_LOBES
        } else {
            BAR
        },
        // The mirror image of the light is in the middle of the view.
        ..Text {
            shininess,
            ..Text::looking([-1.5, 2.0, 0.0], [0.0; 3], 0.5)
                .light([1.5, 2.0, 0.0], 12.0)
                .floor()
        }
        .case(format!("n = {shininess:e}"))
    };
    [1e-3, 1.0, 1e4, 1e6, 1e9].map(case).into()
}

fn lights() -> Vec<Case> {
    let lit = |position: Vector, intensity: f64, name: String| {
        Text::looking([0.0, 1.0, 4.0], [0.0, 0.5, 0.0], 40.0)
            .light(position, intensity)
            .sphere([0.0, 0.5, 0.0], 0.5)
            .floor()
            .case(name)
    };
    let above = |height: f64| {
        lit(
            [0.9, height, 0.3],
            5.0,
            format!("a light {height:?} m above the floor"),
        )
    };
    let mut cases = Vec::from([1e-3, 1e-9, 1e-10, 0.0, -1e-9].map(above));
    cases.extend([1e-12, 1e-15, -1e-15].map(|height| above(height).refused(TOO_NEAR)));
    cases.push(lit(
        [0.1, 0.6, 0.1],
        5.0,
        "a light inside a sphere".to_owned(),
    ));
    cases.push(lit([0.0, 1.0, 0.0], 5.0, "a light on a sphere".to_owned()));
    cases.push(lit(
        [0.0, 1.0 + 1e-9, 0.0],
        5.0,
        "a light 1e-9 m above a sphere".to_owned(),
    ));
    cases.push(lit(
        [1e5, 1.6e5, 6e4],
        2e10,
        "a light of 2e10 cd, 2e5 m away".to_owned(),
    ));
    for distance in [1e9, 1.5e11, 1e13, 1e15, 1e18] {
        cases.push(lit(
            scaled([1.0, 2.0, 1.0], distance),
            distance * distance * 3.0,
            format!("a light {distance:e} m away"),
        ));
    }
    let mut many = Text {
        resolution: [4, 3],
        ..still()
    };
    many.lights = vec![([2.0, 3.0, 2.0], 12e-5); 100_000];
    cases.push(many.case("1e5 lights at one point"));
    cases
}

fn contacts() -> Vec<Case> {
    let base =
        || Text::looking([0.0, 1.0, 4.0], [0.0, 0.5, 0.0], 40.0).light([2.0, 3.0, 2.0], 12.0);
    let tangent = base()
        .floor()
        .sphere([0.0, 0.5, 0.0], 0.5)
        .sphere([1.0, 0.5, 0.0], 0.5)
        .sphere([-0.75, 0.25, 0.0], 0.25)
        .sphere([0.0, 1.25, 0.0], 0.25);
    let coincident = base()
        .floor()
        .floor()
        .sphere([0.0, 0.5, 0.0], 0.5)
        .sphere([0.0, 0.5, 0.0], 0.5)
        .triangle([[-2.0, 0.0, 1.0], [2.0, 0.0, 1.0], [0.0, 0.0, -3.0]])
        .triangle([[-2.0, 0.0, 1.0], [2.0, 0.0, 1.0], [0.0, 0.0, -3.0]]);
    // A cube around the light, a corner of which points at the eye, in a larger room: all outside is dark.
    let mut cube = Text::looking([3.0, 3.0, 3.0], [0.0; 3], 50.0)
        .light([0.1, 0.05, -0.1], 12.0)
        .plane([0.0, -2.0, 0.0], [0.0, 1.0, 0.0])
        .plane([-2.0, 0.0, 0.0], [1.0, 0.0, 0.0])
        .plane([0.0, 0.0, -2.0], [0.0, 0.0, 1.0]);
    for corners in cube_faces() {
        cube = cube.triangle(corners);
    }
    let edge_on = |mut cube: Text| {
        cube.eye = [0.5, 0.0, 4.0];
        cube.look_at = [0.5, 0.0, 0.0];
        cube.resolution = [25, 17];
        cube
    };
    vec![
        tangent.case("tangent spheres and a plane"),
        coincident.case("coincident spheres, planes and triangles"),
        cube.case("a closed cube around a light, a corner seen end-on"),
        edge_on(cube).case("the same, faces and edges seen edge-on"),
    ]
}

/// The twelve triangles of a cube of 1 m around the origin.
fn cube_faces() -> Vec<[Vector; 3]> {
    let mut faces = Vec::new();
    for axis in 0..3 {
        for side in [-0.5, 0.5] {
            let corner = |u: f64, v: f64| {
                let mut corner = [0.0; 3];
                corner[axis] = side;
                corner[(axis + 1) % 3] = u;
                corner[(axis + 2) % 3] = v;
                corner
            };
            let [a, b, c, d] = [
                corner(-0.5, -0.5),
                corner(0.5, -0.5),
                corner(0.5, 0.5),
                corner(-0.5, 0.5),
            ];
            faces.push([a, b, c]);
            faces.push([a, c, d]);
        }
    }
    faces
}

fn thin() -> Vec<Case> {
    let base = || still().light([-3.0, 4.0, 1.0], 9.0);
    let sliver = |width: f64| {
        let mut scene = base();
        for number in 0..12 {
            let x = -1.5 + 0.25 * f64::from(number);
            scene = scene.triangle([[x, 0.0, 1.0], [x + 0.2, 1.0, 1.0], [x + width, 0.0, 1.0]]);
        }
        scene.case(format!("slivers of 1 m by {width:e} m"))
    };
    let mut edge_on = base();
    for number in 0..6 {
        let y = 0.25 * f64::from(number);
        // In planes through the eye.
        let along = |x: f64, z: f64| [x, 1.0 + (y - 1.0) * (4.0 - z) / 4.0, z];
        edge_on = edge_on.triangle([along(-1.0, 1.0), along(1.0, 1.0), along(0.0, -1.0)]);
    }
    let lines = {
        // A pixel is 0.18 m wide there.
        let mut scene = base();
        for number in 0..30 {
            let x = -2.0 + 0.137 * f64::from(number);
            scene = scene
                .triangle([[x, 0.0, 0.9], [x + 1e-4, 0.0, 0.9], [x + 5e-5, 2.0, 0.9]])
                .sphere([x, 1.2, 0.5], 1e-4);
        }
        scene
    };
    vec![
        sliver(1e-6),
        sliver(1e-9),
        sliver(1e-12),
        edge_on.case("triangles seen edge-on"),
        lines.case("lines and points thinner than a pixel"),
    ]
}

/// A ball of triangles with vertex normals, of radius 1; `sign` turns the normals.
fn ball(sign: f64) -> String {
    let (columns, rows) = (12, 6);
    let mut text = String::new();
    let at = |row: u32, column: u32| {
        let polar = std::f64::consts::PI * f64::from(row) / f64::from(rows);
        let around = std::f64::consts::TAU * f64::from(column % columns) / f64::from(columns);
        [
            polar.sin() * around.cos(),
            polar.cos(),
            polar.sin() * around.sin(),
        ]
    };
    for row in 0..=rows {
        for column in 0..columns {
            let [x, y, z] = at(row, column);
            writeln!(text, "v {x:?} {y:?} {z:?}").unwrap();
            let [x, y, z] = [x, y, z].map(|x| x * sign);
            writeln!(text, "vn {x:?} {y:?} {z:?}").unwrap();
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let index = |row: u32, column: u32| row * columns + column % columns + 1;
            let [a, b, c, d] = [
                index(row, column),
                index(row, column + 1),
                index(row + 1, column + 1),
                index(row + 1, column),
            ];
            if row > 0 {
                writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}").unwrap();
            }
            if row + 1 < rows {
                writeln!(text, "f {a}//{a} {c}//{c} {d}//{d}").unwrap();
            }
        }
    }
    text
}

fn smooth(folder: &Path) -> Vec<Case> {
    std::fs::write(folder.join("ball.obj"), ball(1.0)).unwrap();
    std::fs::write(folder.join("inverted.obj"), ball(-1.0)).unwrap();
    let scene = |file: &str, more: &str| {
        Text::looking([0.0, 1.0, 4.0], [0.0, 0.5, 0.0], 40.0)
            .light([4.0, 1.5, -0.5], 30.0)
            .floor()
            .mesh(&format!(
                "file = \"{file}\"\nsmooth = true\ntranslate = [0, 1, 0]\n{more}"
            ))
    };
    vec![
        scene("ball.obj", "").case_in("smooth normals at the terminator", folder),
        scene("ball.obj", "shadow_terminator = \"hanika\"\n")
            .case_in("the same, with shadow rays off the triangles", folder),
        scene("inverted.obj", "").case_in("smooth normals that are inverted", folder),
    ]
}

fn intensities() -> Vec<Case> {
    let case = |intensity: f64| {
        let mut scene = still();
        scene.lights = vec![([2.0, 3.0, 2.0], intensity)];
        scene.case(format!("a light of {intensity:e} cd"))
    };
    [1e-300, 1e-45, 1e-37, 1e-30, 1e30, 3e38].map(case).into()
}

/// 16 million pixels, for the long sweep.
pub(super) fn large() -> Case {
    Text {
        resolution: [4096, 4096],
        ..still()
    }
    .case("4096 × 4096 pixels")
}
