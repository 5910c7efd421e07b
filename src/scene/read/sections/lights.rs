//! `[lights.NAME.VARIANT]`

use super::super::super::Light;
use super::super::entries::{Section, Variant, Variants};
use super::super::fields::Fields;
use super::super::key::{BRIGHTEST, Elsewhere, Form, Key, Kind, Purpose, key};

pub(in crate::scene::read) const LIGHTS: Section<Light> = Section {
    key: "lights",
    entry: "light",
    an_entry: "a light",
    kind: "kind of light",
    example: "`[lights.NAME.point]` with a name of your choice",
    variants: Variants {
        list: &[Variant {
            name: "point",
            about: "A point that sends the same light into all directions.",
            also: &["omni", "pointlight", "point_light", "bulb"],
            form: Form::new(&[&POSITION, &INTENSITY]).elsewhere(NOT_IN_LIGHTS),
            read: point_light,
        }],
        elsewhere: &[Elsewhere {
            words: &[
                "spot",
                "spotlight",
                "sun",
                "directional",
                "distant",
                "area",
                "rectangle",
                "disk",
                "sphere",
                "quad",
                "ies",
                "dome",
                "environment",
                "envmap",
                "infinite",
                "ambient",
                "constant",
                "sky",
            ],
            key: None,
            advice: "lights are `point`s; one far away has parallel rays, and `background` in `[image]` \
                     is what is seen where nothing is",
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

const NOT_IN_LIGHTS: &[Elsewhere] = &[
    Elsewhere {
        words: &["power", "energy", "flux", "watts", "lumens", "lm", "w"],
        key: Some("intensity"),
        advice: "write `intensity`, in candela or in a unit: `intensity = { lumens = 800 }`, \
                 `intensity = { watts = 6 }`",
    },
    Elsewhere {
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
    },
    Elsewhere {
        words: &["radius", "size", "width", "height"],
        key: None,
        advice: "a point light has no size; many of them around one another make soft shadows",
    },
    Elsewhere {
        words: &["direction", "look_at", "target", "angle", "cone", "falloff"],
        key: None,
        advice: "a point light sends the same light into all directions",
    },
    Elsewhere {
        words: &["type", "kind"],
        key: None,
        advice: "the kind stands in the header: `[lights.NAME.point]`",
    },
];

fn point_light(fields: &mut Fields<'_, '_, '_>) -> Option<Light> {
    let position = fields.vector(&POSITION);
    let intensity = fields.value(&INTENSITY, Purpose::Light);
    Some(Light::Point {
        position: position?,
        intensity: intensity?,
    })
}
