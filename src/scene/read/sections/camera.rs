//! `[camera.VARIANT]`

use std::ops::Bound;

use toml::de::{DeTable, DeValue};

use super::super::super::diagnostic::{Problem, Span, Spanned};
use super::super::super::{Camera, View};
use super::super::entries::{Choice, Variant, Variants, one_variant};
use super::super::fields::{Fields, Reader};
use super::super::key::{Elsewhere, Form, Key, Kind, LENGTH, Range, key};
use super::super::syntax::header;

pub(in crate::scene::read) const CAMERAS: Variants<Camera> = Variants {
    list: &[
        Variant {
            name: "perspective",
            about: "All rays start at the eye.",
            also: &["pinhole", "thinlens", "persp"],
            form: Form::new(&[&EYE, &LOOK_AT, &UP, &VERTICAL_FOV]).elsewhere(NOT_IN_PERSPECTIVE),
            read: perspective,
        },
        Variant {
            name: "orthographic",
            about: "Parallel rays, which start on the image plane through the eye.",
            also: &["ortho", "orthogonal", "parallel"],
            form: Form::new(&[&EYE, &LOOK_AT, &UP, &HEIGHT]).elsewhere(NOT_IN_ORTHOGRAPHIC),
            read: orthographic,
        },
    ],
    elsewhere: &[],
};

const EYE: Key = key!("eye", "the viewer's position", "[0, 1.2, 4]")
    .of(Kind::Vector)
    .about("The viewer's position; of an orthographic camera, the center of the image plane.")
    .also(&[
        "from",
        "position",
        "pos",
        "origin",
        "location",
        "o",
        "look_from",
        "lookfrom",
    ]);
const LOOK_AT: Key = key!(
    "look_at",
    "the point in the middle of the image",
    "[0, 0.6, 0]"
)
.of(Kind::Vector)
.about("The point in the middle of the image: a point, not a direction.")
.also(&["to", "target", "lookat", "center", "interest", "aim"]);
const UP: Key = key!("up", "the direction that is up in the image", "[0, 1, 0]")
    .of(Kind::Direction)
    .or("[0, 1, 0]")
    .about("The direction that is up in the image: not along the view.")
    .also(&["up_vector", "vup", "world_up"]);
const VERTICAL_FOV: Key = key!("vertical_fov", "an angle in degrees", "40")
    .of(Kind::Number(FOVS))
    .about("The angle between the lower and the upper edge of the image in degrees: above 0, below 180.")
    .also(&["fov", "fovy", "fov_y", "vfov", "yfov", "field_of_view", "angle"]);
const HEIGHT: Key = key!("height", "the image's height in scene units", "3")
    .of(Kind::Number(LENGTH))
    .about("The vertical extent of the image in scene units: above 0.")
    .also(&["scale", "size", "ortho_scale", "orthographic_scale", "ymag"]);

/// Angles of view in degrees.
const FOVS: Range = (Bound::Excluded(0.0), Bound::Excluded(180.0));

const NOT_IN_PERSPECTIVE: &[Elsewhere] = &[
    Elsewhere {
        words: &[
            "focal_length",
            "focallength",
            "lens",
            "sensor_height",
            "film_height",
            "hfov",
            "horizontal_fov",
            "fov_x",
            "fovx",
            "xfov",
        ],
        key: Some("vertical_fov"),
        advice: "write `vertical_fov` in degrees: 2 atan(sensor height / (2 focal length)), or \
                 2 atan(tan(horizontal fov / 2) · height / width)",
    },
    Elsewhere {
        words: &["height", "scale", "ortho_scale"],
        key: Some("vertical_fov"),
        advice: "a perspective camera has an angle, `vertical_fov` in degrees; `height` is of \
                 `[camera.orthographic]`",
    },
    DIRECTION,
    ASPECT,
    CLIPPING,
    LENS,
];

const NOT_IN_ORTHOGRAPHIC: &[Elsewhere] = &[
    Elsewhere {
        words: &[
            "vertical_fov",
            "fov",
            "fovy",
            "fov_y",
            "vfov",
            "yfov",
            "field_of_view",
            "angle",
            "hfov",
            "horizontal_fov",
            "fov_x",
            "fovx",
            "xfov",
            "focal_length",
        ],
        key: Some("height"),
        advice: "an orthographic camera has no angle: write `height`, what it sees from bottom to top in \
                 scene units; `vertical_fov` is of `[camera.perspective]`",
    },
    DIRECTION,
    ASPECT,
    CLIPPING,
    LENS,
];

const DIRECTION: Elsewhere = Elsewhere {
    words: &["direction", "dir", "forward"],
    key: Some("look_at"),
    advice: "write `look_at`, a point: the eye's position plus the direction",
};

const ASPECT: Elsewhere = Elsewhere {
    words: &["aspect", "aspect_ratio", "resolution", "width"],
    key: None,
    advice: "pixels are square, and the picture's shape is that of `resolution` in `[image]`",
};

const CLIPPING: Elsewhere = Elsewhere {
    words: &[
        "near",
        "far",
        "near_clip",
        "far_clip",
        "znear",
        "zfar",
        "clip_start",
        "clip_end",
    ],
    key: None,
    advice: "nothing is clipped: all that is in front of the camera is seen, at any distance",
};

const LENS: Elsewhere = Elsewhere {
    words: &[
        "aperture",
        "fstop",
        "f_stop",
        "focus_distance",
        "focal_distance",
        "lens_radius",
    ],
    key: None,
    advice: "everything is in focus: the camera has no lens",
};

/// `[camera.VARIANT]`; `misspelt` are the sections that are there under another name.
pub(in crate::scene::read) fn camera(
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
        names_channels: false,
        header: header(reader.text, key.span().into(), node),
    };
    let camera = one_variant(reader, &choice, table, &CAMERAS)?;
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
