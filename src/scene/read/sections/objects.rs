//! `[objects.NAME.VARIANT]`

use std::path::PathBuf;

use toml::de::DeValue;

use super::super::super::Object;
use super::super::super::diagnostic::Spanned;
use super::super::super::value::ShadowTerminator;
use super::super::entries::{Section, Variant, Variants};
use super::super::fields::{Fields, spanned};
use super::super::key::{Elsewhere, Form, Key, Kind, LENGTH, key};

pub(in crate::scene::read) const OBJECTS: Section<Object> = Section {
    key: "objects",
    entry: "object",
    an_entry: "an object",
    names_channels: false,
    kind: "kind of object",
    example: "`[objects.NAME.sphere]` with a name of your choice",
    variants: Variants {
        list: &[
            Variant {
                name: "sphere",
                about: "‖p − c‖ = R.",
                also: &["ball"],
                form: Form::new(&[&MATERIAL, &CENTER, &RADIUS]).elsewhere(NOT_IN_SPHERES),
                read: sphere,
            },
            Variant {
                name: "plane",
                about: "A plane without end in all directions.",
                also: &["floor", "ground", "infinite_plane"],
                form: Form::new(&[&MATERIAL, &POINT, &NORMAL]).elsewhere(NOT_IN_PLANES),
                read: plane,
            },
            Variant {
                name: "triangle",
                about: "A single triangle, seen from both sides.",
                also: &["tri", "face"],
                form: Form::new(&[&MATERIAL, &VERTICES]).elsewhere(NOT_IN_TRIANGLES),
                read: triangle,
            },
            Variant {
                name: "mesh",
                about: "The triangles of a PLY or OBJ file: scaled first, then rotated, then moved.",
                also: &[
                    "ply",
                    "obj",
                    "model",
                    "trianglemesh",
                    "triangle_mesh",
                    "plymesh",
                ],
                form: Form::new(&[
                    &MATERIAL,
                    &FILE,
                    &SCALE,
                    &ROTATE,
                    &TRANSLATE,
                    &SMOOTH,
                    &SHADOW_TERMINATOR,
                ])
                .elsewhere(NOT_IN_MESHES),
                read: mesh,
            },
        ],
        elsewhere: &[Elsewhere {
            words: &[
                "box",
                "cube",
                "quad",
                "rectangle",
                "disk",
                "disc",
                "cylinder",
                "cone",
                "torus",
                "capsule",
                "curve",
                "instance",
                "group",
            ],
            key: None,
            advice: "objects are `sphere`, `plane`, `triangle` or `mesh`; other shapes come as a mesh in \
                     a PLY or OBJ file, which Blender and others write",
        }],
    },
};

const MATERIAL: Key = key!("material", "the name of a material", "\"clay\"")
    .of(Kind::Text)
    .about("The name of what it is made of: of `[materials.NAME.VARIANT]`.")
    .also(&["mat", "bsdf", "shader", "brdf"]);
const CENTER: Key = key!("center", "the sphere's center", "[0, 0.5, 0]")
    .of(Kind::Vector)
    .about("c, the sphere's center.")
    .also(&[
        "centre",
        "c",
        "position",
        "pos",
        "origin",
        "location",
        "point",
        "translate",
        "p",
    ]);
const RADIUS: Key = key!("radius", "a number of scene units", "0.5")
    .of(Kind::Number(LENGTH))
    .about("R, in scene units: above 0.")
    .also(&["r", "size", "rad"]);
const POINT: Key = key!("point", "any point on the plane", "[0, 0, 0]")
    .of(Kind::Vector)
    .about("Any point on the plane.")
    .also(&[
        "p",
        "position",
        "pos",
        "origin",
        "center",
        "centre",
        "location",
        "translate",
    ]);
const NORMAL: Key = key!("normal", "the direction across the plane", "[0, 1, 0]")
    .of(Kind::Direction)
    .about("The direction across the plane, of any length but 0.")
    .also(&["n", "direction", "dir", "up", "axis"]);
const VERTICES: Key = key!(
    "vertices",
    "three corners",
    "[[0, 0, 0], [1, 0, 0], [0, 1, 0]]"
)
.of(Kind::Corners)
.about("The three corners: not on one line.")
.also(&["points", "corners", "positions", "p", "v", "verts"]);
const FILE: Key = key!(
    "file",
    "a PLY or OBJ file beside the scene",
    "\"dragon.ply\""
)
.of(Kind::Text)
.about("A PLY or OBJ file, relative to the folder of the scene file.")
.also(&[
    "filename", "path", "mesh", "src", "source", "url", "ply", "obj",
]);
const SCALE: Key = key!("scale", "a factor or three, for x, y and z", "10")
    .of(Kind::Factors)
    .or("1")
    .about("A factor, or three along x, y and z: not 0; negative ones mirror.")
    .also(&["size", "s"]);
const ROTATE: Key = key!("rotate", "degrees about x, then y, then z", "[0, 90, 0]")
    .of(Kind::Vector)
    .or("[0, 0, 0]")
    .about("Degrees about x, then y, then z: counter-clockwise seen from the axis' tip.")
    .also(&["rotation", "rot", "euler", "angles", "orientation"]);
const TRANSLATE: Key = key!("translate", "a way in scene units", "[0, -0.5, 0]")
    .of(Kind::Vector)
    .or("[0, 0, 0]")
    .about("The way moved, in scene units.")
    .also(&[
        "translation",
        "position",
        "pos",
        "offset",
        "location",
        "move",
        "center",
        "origin",
    ]);
const SMOOTH: Key = Key {
    value: "`true` or `false`",
    line: "`smooth = true`",
    ..key!("smooth", "whether vertex normals are used", "true")
}
.of(Kind::Boolean)
.or("true")
.about("Whether vertex normals are used, if the file has them.")
.also(&["smooth_normals", "smooth_shading", "shade_smooth"]);

const SHADOW_TERMINATOR: Key = key!(
    "shadow_terminator",
    "where shadow rays start, `\"geometric\"` or `\"hanika\"`",
    "\"hanika\""
)
.of(Kind::Name(shadow_terminators))
.or("\"geometric\"")
.about(
    "Where shadow rays start and light ends on a smooth mesh: at its facets, or lifted to where the \
     vertex normals say (Hanika 2021), without steps.",
)
.also(&["terminator", "shadow_terminator_offset"]);

fn shadow_terminators() -> Vec<&'static str> {
    ShadowTerminator::ALL.map(ShadowTerminator::name).to_vec()
}

const NOT_IN_SPHERES: &[Elsewhere] = &[COLORS, TRANSFORMATIONS, SHAPES, DIAMETER];

const NOT_IN_PLANES: &[Elsewhere] = &[
    COLORS,
    TRANSFORMATIONS,
    SHAPES,
    Elsewhere {
        words: &["d", "distance", "height"],
        key: Some("point"),
        advice: "a plane is said by any `point` on it and its `normal`",
    },
];

const NOT_IN_TRIANGLES: &[Elsewhere] = &[
    COLORS,
    TRANSFORMATIONS,
    SHAPES,
    Elsewhere {
        words: &[
            "a", "b", "c", "v0", "v1", "v2", "v3", "p0", "p1", "p2", "p3",
        ],
        key: Some("vertices"),
        advice: "write the three corners as `vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]`",
    },
    Elsewhere {
        words: &["normal", "normals"],
        key: None,
        advice: "a triangle's normal follows from its corners, and both of its sides are seen",
    },
];

const NOT_IN_MESHES: &[Elsewhere] = &[
    COLORS,
    SHAPES,
    Elsewhere {
        words: &["transform", "matrix", "to_world"],
        key: None,
        advice: "write `scale`, `rotate` and `translate`, which are done in this order",
    },
    Elsewhere {
        words: &[
            "vertices",
            "faces",
            "indices",
            "normals",
            "triangles",
            "points",
        ],
        key: Some("file"),
        advice: "the triangles come from a PLY or OBJ file, named by `file`; a single one is \
                 `[objects.NAME.triangle]`",
    },
];

const COLORS: Elsewhere = Elsewhere {
    words: &[
        "color", "colour", "diffuse", "albedo", "specular", "k_d", "k_s", "kd", "ks",
    ],
    key: None,
    advice: "colors belong to materials: `[materials.NAME.phong]` with `diffuse`, and here \
             `material = \"NAME\"`",
};

const TRANSFORMATIONS: Elsewhere = Elsewhere {
    words: &[
        "transform",
        "matrix",
        "scale",
        "rotate",
        "rotation",
        "to_world",
    ],
    key: None,
    advice: "only meshes are scaled and rotated; the other objects stand where their points are",
};

const SHAPES: Elsewhere = Elsewhere {
    words: &["type", "kind", "shape"],
    key: None,
    advice: "the kind stands in the header, such as `[objects.NAME.sphere]`",
};

const DIAMETER: Elsewhere = Elsewhere {
    words: &["diameter", "d"],
    key: Some("radius"),
    advice: "write `radius`, half of the diameter",
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
    let vertices = fields.reader.moving(node, |reader, node| {
        let [a, b, c] = reader.items::<3>(&VERTICES, VERTICES.name, node)?;
        let mut corner = |name, node| reader.numbers::<3>(&VERTEX, name, node);
        let (a, b, c) = (
            corner("vertices[0]", a),
            corner("vertices[1]", b),
            corner("vertices[2]", c),
        );
        Some([a?, b?, c?])
    });
    spanned(vertices, node)
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
    let shadow_terminator = fields.choice(
        &SHADOW_TERMINATOR,
        "shadow terminator",
        &ShadowTerminator::ALL,
        ShadowTerminator::name,
    );
    let file = file?;
    let geometry = fields.reader.mesh(&file);
    Some(Object::Mesh {
        material: material?,
        file: Spanned::new(PathBuf::from(file.value), file.span),
        scale: scale?,
        rotate: rotate?,
        translate: translate?,
        smooth: smooth?,
        shadow_terminator: shadow_terminator?.value,
        geometry: geometry?,
    })
}

/// One factor for all axes or one for each.
fn scale(fields: &mut Fields<'_, '_, '_>) -> Option<Spanned<[f64; 3]>> {
    let Some(node) = fields.get(&SCALE) else {
        return Some(Spanned::new([1.0; 3], fields.header));
    };
    let scale = fields
        .reader
        .moving(node, |reader, node| match node.get_ref() {
            DeValue::Array(_) => reader.numbers(&SCALE, SCALE.name, node),
            _ => {
                let factor = reader.number(&SCALE, SCALE.name, node);
                factor.map(|factor| [factor; 3])
            }
        });
    spanned(scale, node)
}
