//! Small scenes with what is hard to bound.

/// Name, and what follows the image and a camera at (0.3, 1.2, 5) that looks at (0, 0.4, 0).
const SCENES: &[(&str, &str)] = &[
    (
        "inside a sphere, a light outside of it",
        r#"
[lights.out.point]
position = [0.5, 9, 0.3]
intensity = 400
[lights.in.point]
position = [1, 2, -1]
intensity = 20
[objects.shell.sphere]
material = "shiny"
center = [0, 0, 0]
radius = 7
[objects.ball.sphere]
material = "matte"
center = [0.2, 0.3, 0]
radius = 0.8
"#,
    ),
    (
        "a sharp cone",
        r#"
[lights.a.spot]
position = [0.4, 3, 1]
look_at = [0, 0, 0]
intensity = 50
outer = 18
inner = 18
[lights.b.spot]
position = [-2, 2, 1]
look_at = [-0.4, 0, 0]
intensity = 50
outer = 20
inner = 10
falloff = "linear_angle"
[lights.c.spot]
position = [2, 2, 1]
look_at = [0.8, 0, 0]
intensity = 50
outer = 20
inner = 10
falloff = "gltf"
[lights.d.spot]
position = [0, 2, 3]
look_at = [0, 0, 1]
intensity = 50
outer = 20
inner = 10
falloff = "smooth"
[objects.floor.plane]
material = "matte"
point = [0, 0, 0]
normal = [0, 1, 0]
[objects.ball.sphere]
material = "shiny"
center = [0.2, 0.4, 0]
radius = 0.4
"#,
    ),
    (
        "crossing shadows",
        r#"
[lights.a.point]
position = [1, 4, 2]
intensity = 60
[lights.b.point]
position = [-2, 3, 1]
intensity = 40
[objects.floor.plane]
material = "matte"
point = [0, 0, 0]
normal = [0, 1, 0]
[objects.t.triangle]
material = "shiny"
vertices = [[-1, 0.5, 0], [1, 0.7, 0.3], [0.2, 1.2, -0.5]]
[objects.u.triangle]
material = "matte"
vertices = [[-0.5, 1.5, 0.5], [0.6, 1.0, 0.7], [0.1, 1.7, -0.9]]
[objects.thin.triangle]
material = "matte"
vertices = [[-1.5, 0.0, 0.5], [-1.49, 0.0, 0.5], [-1.2, 1.7, 0.4]]
"#,
    ),
    (
        "intersecting spheres",
        r#"
[lights.a.point]
position = [1, 4, 2]
intensity = 60
[lights.b.point]
position = [0.1, 0.5, 1.05]
intensity = 0.5
[objects.floor.plane]
material = "matte"
point = [0, 0, 0]
normal = [0, 1, 0]
[objects.a.sphere]
material = "shiny"
center = [-0.3, 0.5, 0]
radius = 0.6
[objects.b.sphere]
material = "matte"
center = [0.4, 0.5, 0.1]
radius = 0.6
[objects.c.sphere]
material = "mirror"
center = [0.0, 1.1, 0.1]
radius = 0.3
"#,
    ),
    (
        "coincident planes and spheres",
        r#"
[lights.a.point]
position = [1, 4, 2]
intensity = 60
[objects.floor.plane]
material = "matte"
point = [0, 0, 0]
normal = [0, 1, 0]
[objects.floor2.plane]
material = "shiny"
point = [3, 0, 1]
normal = [0, -1, 0]
[objects.a.sphere]
material = "shiny"
center = [0, 0.5, 0]
radius = 0.5
[objects.b.sphere]
material = "matte"
center = [0, 0.5, 0]
radius = 0.5
[objects.t.triangle]
material = "mirror"
vertices = [[-2, 0, 1], [2, 0, 1], [0, 0, 2]]
"#,
    ),
    (
        "walls edge-on",
        r#"
[lights.a.point]
position = [1, 4, 2]
intensity = 60
[lights.b.point]
position = [-1, 0.4, 2]
intensity = 10
[objects.floor.plane]
material = "matte"
point = [0, 0, 0]
normal = [0, 1, 0]
[objects.t.triangle]
material = "shiny"
vertices = [[0.3, 0, 3], [0.3, 1.2, 0], [0.3, 0, -2]]
[objects.u.triangle]
material = "matte"
vertices = [[0.8, 0.1, 0.5], [-0.8, 0.1, 0.5], [0, 0.1001, -0.5]]
[objects.v.triangle]
material = "matte"
vertices = [[-1, 0, 0], [-1, 1, 0], [-0.999, 0.5, 1]]
"#,
    ),
    (
        "lights near surfaces",
        r#"
[lights.a.point]
position = [0.5, 0.01, 1]
intensity = 0.1
[lights.b.point]
position = [-0.5, 0.001, 1]
intensity = 0.1
[lights.c.point]
position = [0, 0.9005, 0]
intensity = 0.1
[lights.d.point]
position = [2, 4, 3]
intensity = 20
[objects.floor.plane]
material = "matte"
point = [0, 0, 0]
normal = [0, 1, 0]
[objects.ball.sphere]
material = "shiny"
center = [0, 0.4, 0]
radius = 0.5
"#,
    ),
    (
        "sharp highlights",
        r#"
[lights.a.point]
position = [0.5, 3, 4]
intensity = 30
[lights.b.point]
position = [-3, 1, 4]
intensity = 30
[objects.floor.plane]
material = "mirror"
point = [0, 0, 0]
normal = [0, 1, 0]
[objects.a.sphere]
material = "mirror"
center = [0, 0.5, 0]
radius = 0.5
[objects.b.sphere]
material = "mirror"
center = [0.8, 0.1, 1]
radius = 0.03
[objects.c.sphere]
material = "mirror"
center = [0.9, 0.1, 1.2]
radius = 0.004
[objects.t.triangle]
material = "mirror"
vertices = [[-2, 0.1, -0.5], [-0.7, 0.1, 0], [-1.2, 1.2, -0.6]]
"#,
    ),
    (
        "a horizon, and a light in a plane",
        r#"
[lights.a.point]
position = [0.5, 0, 2]
intensity = 30
[lights.b.point]
position = [-3, 1, -400]
intensity = 300000
[lights.c.point]
position = [0.2, -0.5, 2]
intensity = 30
[objects.floor.plane]
material = "shiny"
point = [0, 0, 0]
normal = [0, 1, 0]
[objects.a.sphere]
material = "matte"
center = [0, 0.1, 0]
radius = 0.5
"#,
    ),
];

/// All of them, seen through both cameras.
pub(super) fn all() -> Vec<(String, String)> {
    let mut all = Vec::new();
    for (name, objects) in SCENES {
        for (kind, last) in [
            ("perspective", "vertical_fov = 40"),
            ("orthographic", "height = 3.1"),
        ] {
            let text = format!(
                "[image]\nresolution = [96, 64]\nbackground = 0.7\n\
                 [camera.{kind}]\neye = [0.3, 1.2, 5]\nlook_at = [0, 0.4, 0]\nup = [0, 1, 0]\n{last}\n\
                 [materials.matte.phong]\ndiffuse = [0.7, 0.5, 0.3]\n\
                 [materials.shiny.normalized_phong]\ndiffuse = 0.4\nspecular = [0.3, 0.4, 0.5]\nshininess = 40\n\
                 [materials.mirror.phong]\ndiffuse = 0.1\nspecular = 0.9\nshininess = 3000\n{objects}"
            );
            all.push((format!("{name}, {kind}"), text));
        }
    }
    all
}
