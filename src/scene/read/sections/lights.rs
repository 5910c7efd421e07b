//! `[lights.NAME.VARIANT]`

use std::ops::Bound;

use super::super::super::diagnostic::Spanned;
use super::super::super::{Falloff, Light, Value};
use super::super::entries::{Section, Variant, Variants};
use super::super::fields::Fields;
use super::super::key::{BRIGHTEST, Elsewhere, Form, Key, Kind, LARGEST, Purpose, key};
use super::aim::{DIRECTION, GROUP, LOOK_AT, aim};
use super::areas::{DISK, RECTANGLE, SPHERE};

pub(in crate::scene::read) const LIGHTS: Section<Light> = Section {
    key: "lights",
    entry: "light",
    an_entry: "a light",
    names_channels: true,
    kind: "kind of light",
    example: "`[lights.NAME.point]` with a name of your choice",
    variants: Variants {
        list: &[
            Variant {
                name: "point",
                about: "A point that sends the same light into all directions.",
                also: &["omni", "pointlight", "point_light", "bulb"],
                form: Form::new(&[&POSITION, &INTENSITY, &GROUP]).elsewhere(NOT_IN_POINTS),
                read: point_light,
            },
            Variant {
                name: "spot",
                about: "A point that shines into a cone.",
                also: &["spotlight", "spot_light", "cone"],
                form: Form::new(&[
                    &POSITION, &LOOK_AT, &DIRECTION, &ON_AXIS, &INNER, &OUTER, &FALLOFF, &GROUP,
                ])
                .elsewhere(NOT_IN_SPOTS),
                read: spot_light,
            },
            Variant {
                name: "ies",
                about: "A luminaire by its file, IES LM-63: a point that sends into each direction what was measured.",
                also: &["photometric", "photometry", "luminaire", "ies_light", "web"],
                form: Form::new(&[
                    &POSITION,
                    &LOOK_AT,
                    &DIRECTION,
                    &UP,
                    &LUMINAIRE,
                    &OF_LUMINAIRE,
                    &SCALE,
                    &GROUP,
                ])
                .elsewhere(NOT_IN_LUMINAIRES),
                read: ies_light,
            },
            Variant {
                name: "sun",
                about: "Parallel light from very far away, as strong everywhere.",
                also: &["directional", "distant", "infinite", "parallel", "sunlight"],
                form: Form::new(&[&WAY, &ILLUMINANCE, &GROUP]).elsewhere(NOT_IN_SUNS),
                read: sun_light,
            },
            RECTANGLE,
            DISK,
            SPHERE,
        ],
        elsewhere: &[Elsewhere {
            words: &[
                "dome",
                "environment",
                "envmap",
                "ambient",
                "constant",
                "sky",
            ],
            key: None,
            advice: "lights are `point`s, `spot`s, `ies` files, `sun`s, `rectangle`s, `disk`s and `sphere`s, and \
                     `background` in `[image]` is what is seen where nothing is",
        }],
    },
};

const POSITION: Key = key!("position", "the light's position", "[3, 4, 3]")
    .of(Kind::Vector)
    .about("p_L, the light's position.")
    .also(&[
        "p_l",
        "p",
        "pos",
        "location",
        "center",
        "origin",
        "from",
        "eye",
        "point",
        "translate",
    ]);
const INTENSITY: Key = key!(
    "intensity",
    "an intensity in candela (a number, `[r, g, b]` or `\"#rrggbb\"`), a curve, or in a unit",
    "[30, 30, 30]"
)
.of(Kind::Value(Purpose::Light, BRIGHTEST))
.about("I, the same in all directions: RGB in candela, a curve in W/(sr nm), or in a unit.")
.also(&[
    "i_l",
    "i",
    "strength",
    "brightness",
    "candela",
    "cd",
    "emission",
    "radiance",
    "luminance",
]);

const ON_AXIS: Key = INTENSITY.about(
    "I on the axis: RGB in candela, a curve in W/(sr nm), or in a unit; a flux, such as `lumens`, is what leaves \
     the lamp.",
);
const ANGLE: (Bound<f64>, Bound<f64>) = (Bound::Included(0.0), Bound::Included(90.0));
const INNER: Key = key!("inner", "an angle from the axis in degrees", "20")
    .of(Kind::Number(ANGLE))
    .or("0")
    .about(
        "Up to this angle from the axis it has its full intensity: from 0 to `outer`, in degrees.",
    )
    .also(&[
        "inner_angle",
        "inner_cone_angle",
        "innerconeangle",
        "beam_width",
        "hotspot",
    ]);
const OUTER: Key = key!("outer", "an angle from the axis in degrees", "30")
    .of(Kind::Number((Bound::Included(1e-6), Bound::Included(90.0))))
    .about(
        "From this angle from the axis on it is dark: up to 90 degrees. A cone is twice as wide.",
    )
    .also(&[
        "outer_angle",
        "outer_cone_angle",
        "outerconeangle",
        "cutoff_angle",
        "cutoff",
        "coneangle",
        "cone_angle",
        "cone",
        "half_angle",
    ]);
const FALLOFF: Key = key!(
    "falloff",
    "`\"smooth\"`, `\"gltf\"` or `\"linear_angle\"`",
    "\"smooth\""
)
.of(Kind::Name(falloffs))
.or("\"smooth\"")
.about(
    "How it falls off from `inner` to `outer`: with x linear in the cosine, x²(3 − 2x) (pbrt, Cycles) or x² \
     (glTF); or linear in the angle (Mitsuba).",
)
.also(&["penumbra", "profile"]);

fn falloffs() -> Vec<&'static str> {
    Falloff::ALL.map(Falloff::name).to_vec()
}

const UP: Key = key!("up", "a vector towards horizontal angle 0", "[0, 1, 0]")
    .of(Kind::Direction)
    .or("[0, 1, 0]")
    .about(
        "What horizontal angle 0 of the file is towards; angles go counter-clockwise seen against the light. Where it is \
         along the light's way, `[0, 1, 0]` takes its place, and along that `[0, 0, -1]`.",
    )
    .also(&["u", "rotate", "roll", "orientation", "c0"]);
const LUMINAIRE: Key = key!("file", "an IES file beside the scene", "\"downlight.ies\"")
    .of(Kind::Text)
    .about("An IES file (LM-63), relative to the scene's folder.")
    .also(&["ies", "filename", "path", "profile", "photometry"]);
const OF_LUMINAIRE: Key = INTENSITY
    .optional()
    .about(
        "I into the brightest direction, instead of the file's: RGB in candela, a curve in W/(sr nm), or in a unit; a \
         flux, such as `lumens`, is what leaves the luminaire. Without it the light is white.",
    );
const SCALE: Key = key!("scale", "a factor", "0.5")
    .of(Kind::Number((
        Bound::Included(0.0),
        Bound::Included(LARGEST),
    )))
    .or("1")
    .about("A factor of all the light: dimming.")
    .also(&["factor", "multiplier", "dim", "dimming", "gain"]);

const NOT_IN_LUMINAIRES: &[Elsewhere] = &[
    FLUX,
    COLOR,
    Elsewhere {
        words: &[
            "inner", "outer", "angle", "cone", "falloff", "radius", "size",
        ],
        key: None,
        advice: "an `ies` light sends what its file says; a cone of light is `[lights.NAME.spot]`",
    },
    Elsewhere {
        words: &["type", "kind"],
        key: None,
        advice: "the kind stands in the header: `[lights.NAME.ies]`",
    },
];

const WAY: Key = key!("direction", "the way that the light goes", "[-1, -3, -1]")
    .of(Kind::Direction)
    .about("The way that the light goes, a vector of any length but 0: downwards at noon.")
    .also(&["dir", "d", "axis", "to", "way"]);
const ILLUMINANCE: Key = key!(
    "illuminance",
    "an illuminance in lux (a number, `[r, g, b]` or `\"#rrggbb\"`), a curve, or `{ lux = …, color = … }`",
    "100000"
)
.of(Kind::Value(Purpose::Illuminance, BRIGHTEST))
.about(
    "E on a surface that faces the light: RGB in lux, a curve in W/(m² nm), or `{ lux = …, color = … }`. The sun has \
     100000 lx.",
)
.also(&[
    "e",
    "lux",
    "lx",
    "irradiance",
    "intensity",
    "strength",
    "brightness",
]);

const NOT_IN_SUNS: &[Elsewhere] = &[
    Elsewhere {
        words: &[
            "position",
            "location",
            "center",
            "origin",
            "from",
            "look_at",
            "target",
            "elevation",
            "azimuth",
            "angles",
        ],
        key: Some("direction"),
        advice: "a sun has no place: write `direction`, the way that its light goes",
    },
    Elsewhere {
        words: &[
            "color",
            "colour",
            "rgb",
            "temperature",
            "blackbody",
            "daylight",
            "illuminant",
            "spectrum",
            "kelvin",
        ],
        key: Some("illuminance"),
        advice: "the color is a part of the illuminance: `illuminance = { lux = 100000, color = { daylight = 5600 } }`",
    },
    Elsewhere {
        words: &["angle", "radius", "size", "angular_diameter"],
        key: None,
        advice: "the rays of a sun are parallel, and its shadows sharp; a softer one is a `[lights.NAME.sphere]` far away",
    },
    Elsewhere {
        words: &["type", "kind"],
        key: None,
        advice: "the kind stands in the header: `[lights.NAME.sun]`",
    },
];

const FLUX: Elsewhere = Elsewhere {
    words: &["power", "energy", "flux", "watts", "lumens", "lm", "w"],
    key: Some("intensity"),
    advice: "write `intensity`, in candela or in a unit: `intensity = { lumens = 800 }`, \
             `intensity = { watts = 6 }`",
};

const COLOR: Elsewhere = Elsewhere {
    words: &[
        "color",
        "colour",
        "rgb",
        "temperature",
        "blackbody",
        "illuminant",
        "spectrum",
        "kelvin",
    ],
    key: Some("intensity"),
    advice: "the color is a part of the intensity: `intensity = [30, 25, 20]`, or \
             `intensity = { candela = 30, color = { blackbody = 3200 } }`",
};

const NOT_IN_POINTS: &[Elsewhere] = &[
    FLUX,
    COLOR,
    Elsewhere {
        words: &["radius", "size", "width", "height"],
        key: None,
        advice: "a point light has no size; soft shadows are those of `[lights.NAME.sphere]`, `disk` or `rectangle`",
    },
    Elsewhere {
        words: &[
            "direction",
            "look_at",
            "target",
            "angle",
            "cone",
            "falloff",
            "inner",
            "outer",
        ],
        key: None,
        advice: "a point light sends the same light into all directions; a cone of light is \
                 `[lights.NAME.spot]`",
    },
    Elsewhere {
        words: &["type", "kind"],
        key: None,
        advice: "the kind stands in the header: `[lights.NAME.point]`",
    },
];

const NOT_IN_SPOTS: &[Elsewhere] = &[
    FLUX,
    COLOR,
    Elsewhere {
        words: &["radius", "size", "width", "height"],
        key: None,
        advice: "a spot has no size; soft shadows are those of `[lights.NAME.disk]`, `rectangle` or `sphere`",
    },
    Elsewhere {
        words: &["angle", "spot_size", "fov", "aperture"],
        key: Some("outer"),
        advice: "write `outer`, the angle from the axis to the edge: a half of the whole cone's",
    },
    Elsewhere {
        words: &[
            "blend",
            "spot_blend",
            "conedeltaangle",
            "cone_delta_angle",
            "softness",
        ],
        key: Some("inner"),
        advice: "write `inner`, the angle from the axis up to which the light has its full intensity",
    },
    Elsewhere {
        words: &["up", "rotate", "rotation"],
        key: Some("look_at"),
        advice: "a cone is round: `look_at` or `direction` says all of where it points",
    },
    Elsewhere {
        words: &["type", "kind"],
        key: None,
        advice: "the kind stands in the header: `[lights.NAME.spot]`",
    },
];

fn point_light(fields: &mut Fields<'_, '_, '_>) -> Option<Light> {
    let position = fields.vector(&POSITION);
    let intensity = fields.value(&INTENSITY, Purpose::Light);
    let group = fields.optional_string(&GROUP);
    Some(Light::Point {
        position: position?,
        intensity: intensity?,
        group: group?,
    })
}

fn spot_light(fields: &mut Fields<'_, '_, '_>) -> Option<Light> {
    let position = fields.vector(&POSITION);
    let aim = aim(fields);
    let intensity = fields.value(&ON_AXIS, Purpose::Light);
    let inner = fields.number_or(&INNER, 0.0);
    let outer = fields.number(&OUTER);
    let falloff = fields.choice(&FALLOFF, "falloff", &Falloff::ALL, Falloff::name);
    let group = fields.optional_string(&GROUP);
    Some(Light::Spot {
        position: position?,
        aim: aim?,
        intensity: intensity?,
        inner: inner?,
        outer: outer?,
        falloff: falloff?.value,
        group: group?,
    })
}

fn ies_light(fields: &mut Fields<'_, '_, '_>) -> Option<Light> {
    let position = fields.vector(&POSITION);
    let aim = aim(fields);
    let up = match fields.get(&UP) {
        Some(_) => fields.vector(&UP).map(Some),
        None => Some(None),
    };
    let file = fields.string(&LUMINAIRE);
    let luminaire = file.as_ref().and_then(|file| fields.reader.luminaire(file));
    let intensity = match fields.get(&OF_LUMINAIRE) {
        Some(_) => fields.value(&OF_LUMINAIRE, Purpose::Light).map(Some),
        None => Some(None),
    };
    let scale = fields.number_or(&SCALE, 1.0);
    let group = fields.optional_string(&GROUP);
    let (file, luminaire) = (file?, luminaire?);
    let of_file = || Spanned {
        value: Value::Uniform(luminaire.photometry.peak().candela),
        span: file.span,
    };
    Some(Light::Ies {
        position: position?,
        aim: aim?,
        up: up?,
        intensity: intensity?.unwrap_or_else(of_file),
        file,
        luminaire,
        scale: scale?,
        group: group?,
    })
}

fn sun_light(fields: &mut Fields<'_, '_, '_>) -> Option<Light> {
    let direction = fields.vector(&WAY);
    let illuminance = fields.value(&ILLUMINANCE, Purpose::Illuminance);
    let group = fields.optional_string(&GROUP);
    Some(Light::Sun {
        direction: direction?,
        illuminance: illuminance?,
        group: group?,
    })
}
