//! What each entry holds: image, cameras, materials, lights, objects.

use std::path::PathBuf;

use toml::de::{DeTable, DeValue};

use super::super::diagnostic::{Problem, Span, Spanned};
use super::super::value::{Transport, Value};
use super::super::{Camera, Image, Light, Lobes, MAX_RESOLUTION, Material, Object, View};
use super::Node;
use super::entries::{Choice, Section, Variants, header, one_variant};
use super::fields::{Fields, Key, Reader, key, spanned};
use super::value::Purpose;
use crate::spectrum::Observer;

pub(super) const MATERIALS: Section<Material> = Section {
    key: "materials",
    entry: "material",
    an_entry: "a material",
    names_channels: false,
    kind: "kind of material",
    example: "`[materials.NAME.phong]` with a name of your choice",
    variants: &[
        ("phong", |fields| lobes(fields).map(Material::Phong)),
        ("normalized_phong", |fields| {
            lobes(fields).map(Material::NormalizedPhong)
        }),
    ],
};

pub(super) const LIGHTS: Section<Light> = Section {
    key: "lights",
    entry: "light",
    an_entry: "a light",
    names_channels: true,
    kind: "kind of light",
    example: "`[lights.NAME.point]` with a name of your choice",
    variants: &[("point", point_light)],
};

pub(super) const OBJECTS: Section<Object> = Section {
    key: "objects",
    entry: "object",
    an_entry: "an object",
    names_channels: false,
    kind: "kind of object",
    example: "`[objects.NAME.sphere]` with a name of your choice",
    variants: &[
        ("sphere", sphere),
        ("plane", plane),
        ("triangle", triangle),
        ("mesh", mesh),
    ],
};

const CAMERAS: &Variants<Camera> = &[("perspective", perspective), ("orthographic", orthographic)];

/// The sections of a scene file.
pub(super) const SECTIONS: [&str; 5] = ["image", "camera", "materials", "lights", "objects"];

const RESOLUTION: Key = key!("resolution", "width and height in pixels", "[1280, 720]");
const COLOR_SPACE: Key = key!("color_space", "the name of a color space", "\"rec709\"");
const BACKGROUND: Key = key!(
    "background",
    "a radiance in cd/m² (a number, `[r, g, b]` or `\"#rrggbb\"`) or a curve",
    "[0, 0, 0]"
);
const TRANSPORT: Key = key!("transport", "how light is carried", "\"auto\"");
const OBSERVER: Key = key!("observer", "the year of a CIE observer", "\"1931\"");

/// `[image]`; `misspelt` are the sections that are there under another name.
pub(super) fn image(
    reader: &mut Reader<'_>,
    root: &DeTable<'_>,
    misspelt: &[String],
) -> Option<Image> {
    let Some((key, node)) = root.get_key_value("image") else {
        let problem = Problem::Missing {
            what: "section",
            name: "[image]".to_owned(),
            expected: "`[image]` with its `resolution`, such as `resolution = [1280, 720]`",
        };
        if !misspelt.iter().any(|section| section == "image") {
            reader.report(Span::default(), problem);
        }
        return None;
    };
    let DeValue::Table(table) = node.get_ref() else {
        reader.wrong_type("image", node, "a section with the header `[image]`");
        return None;
    };
    let header = header(reader.text, key.span().into(), node);
    let sound = !reader.damage.reaches(header.start);
    let mut fields = Fields::new(reader, table, header);
    let resolution = resolution(&mut fields);
    let color_space = fields.color_space(&COLOR_SPACE);
    let background = fields.value_or(&BACKGROUND, Purpose::Background, Value::ZERO);
    let transport = fields.choice(&TRANSPORT, "transport", &Transport::ALL, Transport::name);
    let observer = fields.choice(&OBSERVER, "observer", &Observer::ALL, Observer::name);
    fields.finish()?;
    sound.then_some(Image {
        resolution: resolution?,
        color_space: color_space?,
        background: background?,
        transport: transport?,
        observer: observer?,
    })
}

fn resolution(fields: &mut Fields<'_, '_, '_>) -> Option<Spanned<[u32; 2]>> {
    let node = fields.require(&RESOLUTION)?;
    let [width, height] = fields
        .reader
        .items::<2>(&RESOLUTION, RESOLUTION.name, node)?;
    let width = pixels(fields.reader, "resolution[0]", width);
    let height = pixels(fields.reader, "resolution[1]", height);
    spanned(
        width.zip(height).map(|(width, height)| [width, height]),
        node,
    )
}

/// A number of pixels, as far as u32 holds it; the range is checked with all other ranges.
fn pixels(reader: &mut Reader<'_>, name: &str, node: &Node<'_>) -> Option<u32> {
    let DeValue::Integer(integer) = node.get_ref() else {
        reader.wrong_type(name, node, "a whole number of pixels, such as `1280`");
        return None;
    };
    let pixels = i128::from_str_radix(integer.as_str(), integer.radix())
        .ok()
        .and_then(|pixels| u32::try_from(pixels).ok());
    if pixels.is_none() {
        let problem = Problem::OutOfRange {
            key: RESOLUTION.name,
            value: integer.to_string(),
            expected: format!("1 to {MAX_RESOLUTION} pixels"),
        };
        reader.report(node.span().into(), problem);
    }
    pixels
}

/// Light is computed in RGB, which is what both `"auto"` and `"rgb"` come to.
const EYE: Key = key!("eye", "the viewer's position", "[0, 1.2, 4]");
const LOOK_AT: Key = key!(
    "look_at",
    "the point in the middle of the image",
    "[0, 0.6, 0]"
);
const UP: Key = key!("up", "the direction that is up in the image", "[0, 1, 0]");
const VERTICAL_FOV: Key = key!("vertical_fov", "an angle in degrees", "40");
const HEIGHT: Key = key!("height", "the image's height in scene units", "3");

/// `[camera.VARIANT]`; `misspelt` are the sections that are there under another name.
pub(super) fn camera(
    reader: &mut Reader<'_>,
    root: &DeTable<'_>,
    misspelt: &[String],
) -> Option<Spanned<Camera>> {
    let Some((key, node)) = root.get_key_value("camera") else {
        let problem = Problem::Missing {
            what: "section",
            name: "[camera.perspective]".to_owned(),
            expected: "`[camera.perspective]` with `eye`, `look_at` and `vertical_fov`,\n\
                       or `[camera.orthographic]` with `eye`, `look_at` and `height`",
        };
        if !misspelt.iter().any(|section| section == "camera") {
            reader.report(Span::default(), problem);
        }
        return None;
    };
    let DeValue::Table(table) = node.get_ref() else {
        reader.wrong_type(
            "camera",
            node,
            "a section with the header `[camera.perspective]`",
        );
        return None;
    };
    let choice = Choice {
        what: "section",
        name: "camera",
        kind: "kind of camera",
        path: "camera",
        header: header(reader.text, key.span().into(), node),
    };
    let camera = one_variant(reader, &choice, table, CAMERAS)?;
    let span = table.iter().next().map_or(choice.header, |(key, node)| {
        header(reader.text, key.span().into(), node)
    });
    Some(Spanned::new(camera, span))
}

fn perspective(fields: &mut Fields<'_, '_, '_>) -> Option<Camera> {
    let view = view(fields);
    let vertical_fov = fields.number(&VERTICAL_FOV);
    Some(Camera::Perspective {
        view: view?,
        vertical_fov: vertical_fov?,
    })
}

fn orthographic(fields: &mut Fields<'_, '_, '_>) -> Option<Camera> {
    let view = view(fields);
    let height = fields.number(&HEIGHT);
    Some(Camera::Orthographic {
        view: view?,
        height: height?,
    })
}

fn view(fields: &mut Fields<'_, '_, '_>) -> Option<View> {
    let eye = fields.vector(&EYE);
    let look_at = fields.vector(&LOOK_AT);
    let up = fields.vector_or(&UP, [0.0, 1.0, 0.0]);
    Some(View {
        eye: eye?,
        look_at: look_at?,
        up: up?,
    })
}

const DIFFUSE: Key = key!(
    "diffuse",
    "a reflectance (a number, `[r, g, b]` or `\"#rrggbb\"`)",
    "[0.7, 0.3, 0.2]"
);
const SPECULAR: Key = key!(
    "specular",
    "a reflectance (a number, `[r, g, b]` or `\"#rrggbb\"`)",
    "0.3"
);
const SHININESS: Key = key!("shininess", "an exponent", "50");

fn lobes(fields: &mut Fields<'_, '_, '_>) -> Option<Lobes> {
    let diffuse = fields.value_or(&DIFFUSE, Purpose::Surface, Value::ZERO);
    let specular = fields.value_or(&SPECULAR, Purpose::Surface, Value::ZERO);
    let shininess = fields.optional_number(&SHININESS);
    Some(Lobes {
        diffuse: diffuse?,
        specular: specular?,
        shininess: shininess?,
    })
}

const POSITION: Key = key!("position", "the light's position", "[3, 4, 3]");
const INTENSITY: Key = key!(
    "intensity",
    "an intensity in candela (a number, `[r, g, b]` or `\"#rrggbb\"`), a curve, or in a unit",
    "[30, 30, 30]"
);

fn point_light(fields: &mut Fields<'_, '_, '_>) -> Option<Light> {
    let position = fields.vector(&POSITION);
    let intensity = fields.value(&INTENSITY, Purpose::Light);
    Some(Light::Point {
        position: position?,
        intensity: intensity?,
    })
}

const MATERIAL: Key = key!("material", "the name of a material", "\"clay\"");
const CENTER: Key = key!("center", "the sphere's center", "[0, 0.5, 0]");
const RADIUS: Key = key!("radius", "a number of scene units", "0.5");
const POINT: Key = key!("point", "any point on the plane", "[0, 0, 0]");
const NORMAL: Key = key!("normal", "the direction across the plane", "[0, 1, 0]");
const VERTICES: Key = key!(
    "vertices",
    "three corners",
    "[[0, 0, 0], [1, 0, 0], [0, 1, 0]]"
);
const FILE: Key = key!(
    "file",
    "a PLY or OBJ file beside the scene",
    "\"dragon.ply\""
);
const SCALE: Key = key!("scale", "a factor or three, for x, y and z", "10");
const ROTATE: Key = key!("rotate", "degrees about x, then y, then z", "[0, 90, 0]");
const TRANSLATE: Key = key!("translate", "a way in scene units", "[0, -0.5, 0]");
const SMOOTH: Key = Key {
    name: "smooth",
    value: "`true` or `false`",
    line: "`smooth = true`",
};

fn sphere(fields: &mut Fields<'_, '_, '_>) -> Option<Object> {
    let material = fields.string(&MATERIAL);
    let center = fields.vector(&CENTER);
    let radius = fields.number(&RADIUS);
    Some(Object::Sphere {
        material: material?,
        center: center?,
        radius: radius?,
    })
}

fn plane(fields: &mut Fields<'_, '_, '_>) -> Option<Object> {
    let material = fields.string(&MATERIAL);
    let point = fields.vector(&POINT);
    let normal = fields.vector(&NORMAL);
    Some(Object::Plane {
        material: material?,
        point: point?,
        normal: normal?,
    })
}

fn triangle(fields: &mut Fields<'_, '_, '_>) -> Option<Object> {
    let material = fields.string(&MATERIAL);
    let vertices = vertices(fields);
    Some(Object::Triangle {
        material: material?,
        vertices: vertices?,
    })
}

fn vertices(fields: &mut Fields<'_, '_, '_>) -> Option<Spanned<[[f64; 3]; 3]>> {
    let node = fields.require(&VERTICES)?;
    let [a, b, c] = fields.reader.items::<3>(&VERTICES, VERTICES.name, node)?;
    let mut corner = |name, node| fields.reader.numbers::<3>(&VERTEX, name, node);
    let (a, b, c) = (
        corner("vertices[0]", a),
        corner("vertices[1]", b),
        corner("vertices[2]", c),
    );
    Some(Spanned::new([a?, b?, c?], node.span().into()))
}

/// One of the `vertices`; the key is the one that out-of-range numbers name.
const VERTEX: Key = key!("vertices", "a corner", "[1, 0, 0]");

fn mesh(fields: &mut Fields<'_, '_, '_>) -> Option<Object> {
    let material = fields.string(&MATERIAL);
    let file = fields.string(&FILE);
    let scale = scale(fields);
    let rotate = fields.vector_or(&ROTATE, [0.0; 3]);
    let translate = fields.vector_or(&TRANSLATE, [0.0; 3]);
    let smooth = fields.boolean_or(&SMOOTH, true);
    let file = file?;
    let geometry = fields.reader.mesh(&file);
    Some(Object::Mesh {
        material: material?,
        file: Spanned::new(PathBuf::from(file.value), file.span),
        scale: scale?,
        rotate: rotate?,
        translate: translate?,
        smooth: smooth?,
        geometry: geometry?,
    })
}

/// One factor for all axes or one for each.
fn scale(fields: &mut Fields<'_, '_, '_>) -> Option<Spanned<[f64; 3]>> {
    let Some(node) = fields.get(&SCALE) else {
        return Some(Spanned::new([1.0; 3], fields.header));
    };
    let scale = match node.get_ref() {
        DeValue::Array(_) => fields.reader.numbers(&SCALE, SCALE.name, node),
        _ => {
            let factor = fields.reader.number(&SCALE, SCALE.name, node);
            factor.map(|factor| [factor; 3])
        }
    };
    spanned(scale, node)
}
