use std::sync::Arc;

use candela::scene::{
    Aim, AreaShape, Camera, Entry, Image, Light, Lobes, Material, Object, Source, Span, Spanned,
    Transport, Value, View,
};
use candela::spectrum::Observer;
use clap::Parser;
use serde_json::Value as Json;

use super::*;

fn entry<T>(name: &str, value: T) -> Entry<T> {
    Entry {
        name: name.to_owned(),
        span: Span::default(),
        value,
    }
}

/// A ball on a floor: `key` lights both, `under` is below the floor, `lamp` lies on it where the
/// middle of the image is, `back` is behind the ball.
fn scene() -> Scene {
    let rgb = |rgb| Value::Rgb {
        rgb,
        space: candela::scene::ColorSpace::Rec709,
    };
    let lobes = |diffuse, specular, shininess: Option<f64>| Lobes {
        diffuse: Spanned::from(diffuse),
        specular: Value::Uniform(specular).into(),
        shininess: shininess.map(Spanned::from),
        coat: None,
    };
    let light = |position: [f64; 3], intensity| Light::Point {
        position: position.into(),
        intensity: Spanned::from(intensity),
        group: None,
    };
    Scene {
        source: Arc::new(Source::new("ball.toml".into(), String::new())),
        anchor: None,
        image: Image {
            resolution: [65, 49].into(),
            color_space: Spanned::default(),
            background: rgb([0.01, 0.02, 0.03]).into(),
            transport: Transport::default().into(),
            observer: Observer::default().into(),
            max_depth: 8.0.into(),
        },
        camera: Camera::Perspective {
            view: View {
                eye: [0.0, 1.0, 4.0].into(),
                look_at: [0.0, 0.0, 1.0].into(),
                up: [0.0, 1.0, 0.0].into(),
            },
            vertical_fov: 60.0.into(),
        }
        .into(),
        materials: vec![
            entry(
                "clay",
                Material::Phong(lobes(rgb([0.7, 0.3, 0.2]), 0.3, Some(50.0))),
            ),
            entry(
                "stone",
                Material::NormalizedPhong(lobes(Value::Uniform(0.5), 0.25, Some(12.5))),
            ),
        ],
        lights: vec![
            entry("key", light([3.0, 4.0, 3.0], Value::Uniform(30.0))),
            entry("under", light([0.0, -2.0, 0.0], Value::Uniform(5.0))),
            entry("lamp", light([0.0, 0.0, 1.0], rgb([3.0, 2.0, 1.0]))),
            entry("back", light([0.0, 0.5, -3.0], Value::Uniform(1e-3))),
        ],
        objects: vec![
            entry(
                "ball",
                Object::Sphere {
                    material: "clay".to_owned().into(),
                    center: [0.0, 0.5, 0.0].into(),
                    radius: 0.5.into(),
                },
            ),
            entry(
                "floor",
                Object::Plane {
                    material: "stone".to_owned().into(),
                    point: [0.0; 3].into(),
                    normal: [0.0, 1.0, 0.0].into(),
                },
            ),
        ],
        inputs: Vec::new(),
    }
}

#[derive(Parser)]
struct Line {
    #[command(flatten)]
    arguments: Arguments,
}

fn arguments(pixel: &str, more: &[&str]) -> Arguments {
    let line = ["candela", "ball.toml", "--pixel", pixel];
    let arguments = Line::parse_from(line.iter().chain(more)).arguments;
    assert_eq!(arguments.scene.name(), std::path::Path::new("ball.toml"));
    arguments
}

fn output_of(scene: &Scene, arguments: &Arguments) -> Result<String, Failure> {
    let mut output = Vec::new();
    let renderer = |_| Ok([0.5, 0.25, 0.125]);
    run(arguments, scene, renderer, &mut output)?;
    Ok(String::from_utf8(output).unwrap())
}

fn output(pixel: &str, json: bool) -> Result<String, Failure> {
    let more: &[&str] = if json { &["--json"] } else { &[] };
    output_of(&scene(), &arguments(pixel, more))
}

fn json(pixel: &str) -> Json {
    serde_json::from_str(&output(pixel, true).unwrap()).unwrap()
}

/// Reading a decimal number may be off by one in the last place of f64.
const DIGITS: f64 = 1e-15;

#[test]
fn json_has_every_term() {
    let report = json("32,24");
    assert_eq!(report["pixel"], serde_json::json!([32, 24]));
    assert_eq!(report["hit"]["object"], "floor");
    assert_eq!(report["hit"]["material"], "stone");
    for key in ["position", "normal", "geometric_normal"] {
        assert_eq!(report["hit"][key].as_array().unwrap().len(), 3, "{key}");
    }
    assert_eq!(report["hit"]["group"], Json::Null);
    assert!(report["hit"]["distance"].as_f64().unwrap() > 3.0);
    let lights = report["lights"].as_array().unwrap();
    let names: Vec<_> = lights.iter().map(|light| &light["name"]).collect();
    assert_eq!(names, ["key", "under", "lamp", "back"]);
    let outcomes: Vec<_> = lights.iter().map(|light| &light["outcome"]).collect();
    assert_eq!(outcomes, ["lit", "below", "at_point", "occluded"]);
    assert_eq!(lights[0]["visible"], true);
    assert_eq!(lights[0]["occluder"], Json::Null);
    assert_eq!(lights[3]["visible"], false);
    assert_eq!(lights[3]["occluder"], "ball");
    for light in lights {
        for key in ["incident", "diffuse", "specular", "radiance"] {
            let triple = light[key].as_array().unwrap();
            assert!(triple.len() == 3 && triple.iter().all(Json::is_number));
        }
        for key in ["distance", "cos_incident", "cos_lobe"] {
            assert!(light[key].is_number(), "{key}");
        }
    }
    for (i, rendered) in [0.5, 0.25, 0.125].into_iter().enumerate() {
        let shares = lights
            .iter()
            .map(|light| light["radiance"][i].as_f64().unwrap());
        let radiance = report["radiance"][i].as_f64().unwrap();
        assert!((shares.sum::<f64>() - radiance).abs() < DIGITS);
        assert_eq!(report["renderer"]["radiance"][i], rendered);
        let difference = report["renderer"]["difference"][i].as_f64().unwrap();
        assert!((rendered - radiance - difference).abs() < DIGITS);
    }
}

#[test]
fn json_of_the_background() {
    let report = json("0,0");
    assert_eq!(report["hit"], Json::Null);
    assert_eq!(report["lights"], serde_json::json!([]));
    assert_eq!(report["radiance"], serde_json::json!([0.01, 0.02, 0.03]));
}

#[test]
fn the_table_of_the_background() {
    let expected = "\
Pixel (0, 0) of 65 × 49: nothing is there

                     R      G      B
background           0.01   0.02   0.03   cd/m²

renderer, in f32     0.5    0.25   0.125  cd/m²
renderer − equation  0.49   0.23   0.095  cd/m²
";
    assert_eq!(output("0,0", false).unwrap(), expected);
}

#[test]
fn the_table_of_a_floor() {
    let expected = "\
Pixel (32, 24) of 65 × 49: object `floor`, material `stone`, t = 3.16228 m
L_o = Σ L_i (r_d + r_s) V    L_i = I/d²
r_d = ρ_d/π cos(n, ω_i)    r_s = ρ_s (n+2)/(2π) cosⁿ(ω_o, ω_r) cos(n, ω_i)

                                                     x            y            z
L2  p                                                0            0            1           m
    n                                                0            1            0
    ω_o, to the viewer                               0            0.316228     0.948683

                                                     R            G            B
    ρ_d                                              0.5          0.5          0.5
    ρ_s                                              0.25         0.25         0.25        n = 12.5

Light `key`, d = 5.38516 m
    ω_i = (0.557086, 0.742781, 0.371391)      cos(n, ω_i)   = 0.742781
L6  ω_r = (-0.557086, 0.742781, -0.371391)    cos(ω_o, ω_r) = 0
    I                                               30           30           30           cd
L3  L_i = I / 5.38516²                               1.03448      1.03448      1.03448     lx
L5  r_d = ρ_d/π · 0.742781                           0.118217     0.118217     0.118217    1/sr
L7  r_s = ρ_s · 2.30775 · 0^12.5 · 0.742781          0            0            0           1/sr
L8  r   = r_d + r_s                                  0.118217     0.118217     0.118217    1/sr
L4  V                                                1            1            1           nothing stands between
    L_i · r · V                                      0.122294     0.122294     0.122294    cd/m²

Light `under`, d = 2.23607 m, is below the surface: it adds nothing
    ω_i = (0, -0.894427, -0.447214)    cos(n, ω_i)   = 0

Light `lamp` is at p itself, d = 0: it adds nothing

Light `back`, d = 4.03113 m
    ω_i = (0, 0.124035, -0.992278)    cos(n, ω_i)   = 0.124035
L6  ω_r = (0, 0.124035, 0.992278)     cos(ω_o, ω_r) = 0.980581
    I                                                0.001        0.001        0.001       cd
L3  L_i = I / 4.03113²                               6.15385e-5   6.15385e-5   6.15385e-5  lx
L5  r_d = ρ_d/π · 0.124035                           0.0197407    0.0197407    0.0197407   1/sr
L7  r_s = ρ_s · 2.30775 · 0.980581^12.5 · 0.124035   0.0560032    0.0560032    0.0560032   1/sr
L8  r   = r_d + r_s                                  0.075744     0.075744     0.075744    1/sr
L4  V                                                0            0            0           `ball` stands between
    L_i · r · V                                      0            0            0           cd/m²

Sum over the lights
    key                                              0.122294     0.122294     0.122294
    under                                            0            0            0           below the surface
    lamp                                             0            0            0           at p itself, d = 0
    back                                             0            0            0           `ball` stands between
L9  L_o = Σ L_i r V                                  0.122294     0.122294     0.122294    cd/m²

renderer, in f32                                     0.5          0.25         0.125       cd/m²
renderer − equation                                  0.377706     0.127706     0.00270622  cd/m²
";
    assert_eq!(output("32,24", false).unwrap(), expected);
}

/// Of a spot the table says where in its cone p is, and takes the falloff for a factor of L3.
#[test]
fn the_table_of_a_floor_under_spots() {
    let spot = |direction: [f64; 3]| Light::Spot {
        position: [0.0, 2.0, 1.0].into(),
        aim: Aim::Direction(direction.into()),
        intensity: Value::Uniform(40.0).into(),
        inner: 20.0.into(),
        outer: 30.0.into(),
        falloff: candela::scene::Falloff::Gltf,
        group: None,
    };
    let mut scene = scene();
    let (sin, cos) = 25.0_f64.to_radians().sin_cos();
    scene.lights = vec![
        entry("aslant", spot([sin, -cos, 0.0])),
        entry("away", spot([0.0, 1.0, 0.0])),
    ];
    let table = output_of(&scene, &arguments("32,24", &[])).unwrap();
    for expected in [
        "Light `aslant`, d = 2 m\n",
        "    θ = 25° from the axis    f(θ) = 0.299007\n",
        "    I, on the axis ",
        "L3  L_i = I · 0.299007 / 2² ",
        "  2.99007 ",
        "Light `away`, d = 2 m, has p outside of its cone: it adds nothing\n",
        "    θ = 180° from the axis    f(θ) = 0\n",
        "  outside of the cone\n",
    ] {
        assert!(table.contains(expected), "{expected:?} is not in\n{table}");
    }
    let json = output_of(&scene, &arguments("32,24", &["--json"])).unwrap();
    let json: Json = serde_json::from_str(&json).unwrap();
    let falloff = json["lights"][0]["spot"]["falloff"].as_f64().unwrap();
    assert!((falloff - 0.2990072972446).abs() < 1e-12, "{falloff}");
    assert_eq!(json["lights"][1]["outcome"], "outside");
    assert_eq!(
        json["lights"][1]["radiance"],
        serde_json::json!([0.0, 0.0, 0.0])
    );
}

#[test]
fn a_pixel_that_is_not_there() {
    for pixel in ["65,0", "0,49", "4294967295,4294967295"] {
        let error = output(pixel, false).unwrap_err().to_string();
        assert!(error.starts_with(&format!("pixel {pixel} is outside")));
        assert!(error.contains("65 × 49") && error.ends_with("X is 0 to 64, Y is 0 to 48"));
    }
}

/// The scene as `--spectrum` has it computed.
fn spectral_output(pixel: &str, more: &[&str]) -> String {
    let (arguments, mut scene) = (arguments(pixel, more), scene());
    prepare(&arguments, &mut scene);
    assert_eq!(scene.image.transport.value, Transport::Spectral);
    output_of(&scene, &arguments).unwrap()
}

#[test]
fn json_has_the_spectrum_that_is_asked_for() {
    let report =
        |more: &[&str]| -> Json { serde_json::from_str(&spectral_output("0,0", more)).unwrap() };
    let spectrum = &report(&["--json", "--spectrum"])["spectrum"];
    assert_eq!(spectrum["unit"], "W.m^-2.sr^-1.nm^-1");
    let numbers = |key: &str| -> Vec<f64> {
        let numbers = spectrum[key].as_array().unwrap().iter();
        numbers.map(|number| number.as_f64().unwrap()).collect()
    };
    let (wavelengths, radiance) = (numbers("wavelengths"), numbers("radiance"));
    assert_eq!((wavelengths.len(), radiance.len()), (41, 41));
    assert_eq!((wavelengths[0], wavelengths[40]), (380.0, 780.0));
    assert!(radiance.iter().all(|&radiance| radiance > 0.0));
    // The background is of a blue.
    assert!(radiance[7] > radiance[27], "{radiance:?}");
    let few = report(&["--json", "--spectrum=450:470:20"]);
    assert_eq!(
        few["spectrum"]["wavelengths"],
        serde_json::json!([450, 470])
    );
    assert_eq!(few["spectrum"]["radiance"][0], radiance[7]);
    assert_eq!(few["transport"], "spectral");
    // Not asked for, not there; and the scene stays as it is.
    let plain = json("0,0");
    assert_eq!(
        (&plain["spectrum"], &plain["transport"]),
        (&Json::Null, &"rgb".into())
    );
}

#[test]
fn the_table_ends_with_the_spectrum() {
    let table = spectral_output("0,0", &["--spectrum=450:550:50"]);
    let (before, spectrum) = table.split_once("L_o(λ) in W/(m² sr nm)\n").unwrap();
    assert!(before.contains("background") && before.contains("renderer − equation"));
    let lines: Vec<&str> = spectrum.lines().collect();
    assert_eq!(lines.len(), 3);
    for (line, nm) in lines.iter().zip(["450", "500", "550"]) {
        assert!(line.starts_with(&format!("    {nm} nm  ")), "{line}");
    }
    let bar = |line: &str| line.matches('▇').count();
    assert_eq!(bar(lines[0]), 40);
    assert!(bar(lines[0]) > bar(lines[1]) && bar(lines[1]) > bar(lines[2]));
    let table = spectral_output("32,24", &["--spectrum"]);
    assert!(table.contains("Products are taken wavelength by wavelength"));
    assert!(!output("32,24", false).unwrap().contains("wavelength"));
}

#[test]
fn a_scene_in_rgb_has_no_spectrum() {
    let (arguments, mut scene) = (arguments("0,0", &["--spectrum"]), scene());
    scene.image.transport.value = Transport::Rgb;
    prepare(&arguments, &mut scene);
    let error = output_of(&scene, &arguments).unwrap_err().to_string();
    assert!(error.contains("`transport = \"rgb\"`"), "{error}");
}

/// The same with a panel over the ball, that shines down.
fn with_a_panel() -> Scene {
    let mut scene = scene();
    let panel = Light::Area {
        shape: AreaShape::Rectangle {
            center: [0.0, 2.0, -0.3].into(),
            aim: Aim::Direction([0.0, -1.0, 0.0].into()),
            up: None,
            size: [1.0, 0.5].into(),
            two_sided: false,
        },
        luminance: Value::Uniform(10.0).into(),
        visible: true,
        samples: 64.0.into(),
        group: None,
    };
    scene.lights = vec![entry("panel", panel)];
    scene
}

#[test]
fn lights_with_an_area_are_explained() {
    let scene = with_a_panel();
    let told = |pixel, more: &[&str]| output_of(&scene, &arguments(pixel, more)).unwrap();
    let report: Json = serde_json::from_str(&told("32,24", &["--json"])).unwrap();
    let light = &report["lights"][0];
    assert_eq!(light["outcome"], "partial");
    assert_eq!(light["area"]["occluders"], serde_json::json!(["ball"]));
    let number = |key: &str| light["area"][key].as_f64().unwrap();
    assert!(number("seen") > 0.0 && number("seen") < 1.0);
    assert!(number("solid_angle") > std::f64::consts::PI * number("form_factor"));
    let text = told("32,24", &[]);
    for line in [
        "sr above the surface",
        "∫ L r V dω",
        "`ball` stands between",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    let line = told("32,24", &[]).lines().count();
    assert!(line > 25, "{text}");
    // The panel from below, and nothing but that.
    let mut scene = scene.clone();
    let Camera::Perspective { view, .. } = &mut scene.camera.value else {
        unreachable!()
    };
    view.look_at = [0.0, 2.0, -0.3].into();
    let text = output_of(&scene, &arguments("32,24", &[])).unwrap();
    assert!(text.contains("light `panel`, t = "), "{text}");
    assert!(text.contains("it emits"), "{text}");
    let report = output_of(&scene, &arguments("32,24", &["--json"])).unwrap();
    let report: Json = serde_json::from_str(&report).unwrap();
    let luminance = &report["hit"]["emission"]["luminance"];
    assert_eq!(*luminance, serde_json::json!([10.0, 10.0, 10.0]));
}

/// Of a glass ball there are the ways of light through it, vertex by vertex; what they add is L_o.
#[test]
fn ways_over_smooth_surfaces_are_explained() {
    let mut scene = scene();
    scene.materials[0] = entry("clay", Material::glass(1.5));
    let table = output_of(&scene, &arguments("32,16", &[])).unwrap();
    for expected in [
        "Pixel (32, 16) of 65 × 49: object `ball`, material `clay`, t = ",
        "\nL_o = F L(reflected) + (1 − F)(n_i/n_t)² L(refracted)    F = (r∥² + r⊥²)/2\n",
        "\nWays over smooth surfaces, the strongest first, and the products of their factors\n",
        "\nWay 1 ",
        "°: refracted ",
        "°: reflected ",
        "\n    L_o ",
    ] {
        assert!(table.contains(expected), "{expected}\n{table}");
    }
    let json = output_of(&scene, &arguments("32,16", &["--json"])).unwrap();
    let report: Json = serde_json::from_str(&json).unwrap();
    assert_eq!(report["hit"]["reflectance"]["model"], "glass");
    assert_eq!(report["lights"], serde_json::json!([]));
    assert_eq!(report["more_ways"], Json::Null);
    let ways = report["ways"].as_array().unwrap();
    let of = |way: &Json| way["radiance"][2].as_f64().unwrap();
    let sum: f64 = ways.iter().map(of).sum();
    let radiance = report["radiance"][2].as_f64().unwrap();
    assert!((sum - radiance).abs() < 10.0 * DIGITS * radiance, "{json}");
    for way in ways {
        let vertices = way["vertices"].as_array().unwrap();
        assert_eq!(vertices[0]["object"], "ball");
        let mut product = 1.0;
        for vertex in vertices {
            product *= vertex["factor"][0].as_f64().unwrap();
            let told = vertex["product"][0].as_f64().unwrap();
            assert!((told - product).abs() < 10.0 * DIGITS, "{json}");
        }
    }
}

/// Under a coat there are lobes as well.
#[test]
fn coats_are_explained() {
    let mut scene = scene();
    let coat = candela::scene::Mirror {
        reflectance: Value::Uniform(0.125).into(),
        schlick: false,
    };
    if let Material::NormalizedPhong(lobes) = &mut scene.materials[1].value {
        lobes.coat = Some(coat);
    }
    let table = output_of(&scene, &arguments("32,24", &[])).unwrap();
    for expected in [
        "\nL_o = R L(reflected) + (1 − R) Σ L_i (r_d + r_s) V    L_i = I/d²\n",
        "\nL9  Σ L_i r V ",
        "cd/m², without the coat\n",
        "°: lit ",
        "× 0.875\n",
        "× 0.125\n",
    ] {
        assert!(table.contains(expected), "{expected}\n{table}");
    }
}
