//! `[lights.NAME.rectangle]`, `[lights.NAME.disk]`, `[lights.NAME.sphere]`

use super::super::super::diagnostic::Spanned;
use super::super::super::{AreaShape, LIGHT_SAMPLES, Light, MAX_LIGHT_SAMPLES, Value};
use super::super::entries::Variant;
use super::super::fields::{Fields, spanned};
use super::super::key::{BRIGHTEST, EXTENT, Elsewhere, Form, Key, Kind, Purpose, key};
use super::aim::{DIRECTION, GROUP, LOOK_AT, aim};

pub(super) const RECTANGLE: Variant<Light> = Variant {
    name: "rectangle",
    about: "A rectangle that shines, with the same luminance everywhere and in all directions: a panel, a window.",
    also: &[
        "area",
        "rect",
        "quad",
        "rectangular",
        "panel",
        "rect_light",
        "area_light",
        "square",
        "softbox",
        "portal",
    ],
    form: Form::new(&[
        &CENTER, &LOOK_AT, &DIRECTION, &UP, &SIZE, &LUMINANCE, &TWO_SIDED, &VISIBLE, &SAMPLES,
        &GROUP,
    ])
    .elsewhere(NOT_IN_RECTANGLES),
    read: rectangle,
};

pub(super) const DISK: Variant<Light> = Variant {
    name: "disk",
    about: "A disk that shines, with the same luminance everywhere and in all directions.",
    also: &["disc", "disk_light", "circle", "round"],
    form: Form::new(&[
        &CENTER, &LOOK_AT, &DIRECTION, &RADIUS, &LUMINANCE, &TWO_SIDED, &VISIBLE, &SAMPLES, &GROUP,
    ])
    .elsewhere(NOT_IN_DISKS),
    read: disk,
};

pub(super) const SPHERE: Variant<Light> = Variant {
    name: "sphere",
    about: "A sphere that shines, with the same luminance everywhere and in all directions: a globe.",
    also: &["ball", "globe", "sphere_light", "spherical"],
    form: Form::new(&[&CENTER, &RADIUS, &LUMINANCE, &VISIBLE, &SAMPLES, &GROUP])
        .elsewhere(NOT_IN_SPHERES),
    read: sphere,
};

const CENTER: Key = key!("center", "the middle of the light", "[0, 3, 0]")
    .of(Kind::Vector)
    .about("The middle of the light.")
    .also(&[
        "centre",
        "position",
        "pos",
        "p",
        "location",
        "origin",
        "from",
        "translate",
        "c",
    ]);
const UP: Key = key!("up", "a vector along one pair of sides", "[0, 1, 0]")
    .of(Kind::Direction)
    .or("[0, 1, 0]")
    .about(
        "What one pair of its sides runs along, as far as that is across the light. Where it is along the light's way, \
         `[0, 1, 0]` takes its place, and along that `[0, 0, -1]`.",
    )
    .also(&["u", "rotate", "roll", "orientation"]);
const SIZE: Key = key!(
    "size",
    "two lengths, across `up` and along it",
    "[1.2, 0.6]"
)
.of(Kind::Sides)
.about("Its lengths across `up` and along it, in scene units.")
.also(&["sizes", "dimensions", "extent", "scale", "sides"]);
const RADIUS: Key = key!("radius", "a length in scene units", "0.25")
    .of(Kind::Number(EXTENT))
    .about("R, in scene units.")
    .also(&["r", "size"]);
const LUMINANCE: Key = key!(
    "luminance",
    "a luminance in cd/m² (a number, `[r, g, b]` or `\"#rrggbb\"`), a curve, or in a unit",
    "3000"
)
.of(Kind::Value(Purpose::Luminance, BRIGHTEST))
.about(
    "L, the same everywhere and in all directions: RGB in cd/m², a curve in W/(m² sr nm), or in a unit: \
     `{ lumens = 800 }` is what leaves it in all, `{ candela = 250 }` its intensity along the normal.",
)
.also(&[
    "l",
    "radiance",
    "emission",
    "nits",
    "intensity",
    "strength",
    "brightness",
    "exitance",
]);
const TWO_SIDED: Key = Key {
    value: "`true` or `false`",
    line: "`two_sided = true`",
    ..key!("two_sided", "whether both sides shine", "true")
}
.of(Kind::Boolean)
.or("false")
.about("Whether it shines to both sides; else the back is black.")
.also(&["twosided", "double_sided", "both_sides"]);
const VISIBLE: Key = Key {
    value: "`true` or `false`",
    line: "`visible = true`",
    ..key!("visible", "whether the light itself is seen", "false")
}
.of(Kind::Boolean)
.or("true")
.about("Whether the light is seen by the camera, and in the way of other light.")
.also(&[
    "camera_visible",
    "shown",
    "is_visible",
    "primary_visibility",
]);
const SAMPLES: Key = key!("samples", "a whole number of points", "64")
    .of(Kind::Whole(MAX_LIGHT_SAMPLES))
    .or("64")
    .about(
        "How many of its points are asked where something complex hides a part of it, and no error is asked for: \
         1 to 65536. Everywhere else what is seen of it is computed, not sampled.",
    )
    .also(&["light_samples", "num_samples", "shadow_samples", "spp"]);

/// The default of `samples` as text.
const _: () = assert!(LIGHT_SAMPLES == 64);

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
    key: Some("luminance"),
    advice: "the color is a part of the luminance: `luminance = [3000, 2500, 2000]`, or \
             `luminance = { nits = 3000, color = { blackbody = 3200 } }`",
};
const FLUX: Elsewhere = Elsewhere {
    words: &[
        "power", "energy", "flux", "watts", "lumens", "lm", "w", "candela", "cd",
    ],
    key: Some("luminance"),
    advice: "write `luminance`, in cd/m² or in a unit: `luminance = { lumens = 800 }`, \
             `luminance = { candela = 250 }`",
};
const MATERIAL: Elsewhere = Elsewhere {
    words: &["material", "reflectance"],
    key: None,
    advice: "a light reflects nothing: what it sends is its `luminance`",
};
const KIND: Elsewhere = Elsewhere {
    words: &["type", "kind", "shape"],
    key: None,
    advice: "the shape stands in the header: `[lights.NAME.rectangle]`, `disk` or `sphere`",
};

const NOT_IN_RECTANGLES: &[Elsewhere] = &[
    COLOR,
    FLUX,
    MATERIAL,
    KIND,
    Elsewhere {
        words: &["width", "height", "length", "size_x", "size_y"],
        key: Some("size"),
        advice: "write `size = [width, height]`, such as `size = [1.2, 0.6]`: across `up` and along it",
    },
];
const NOT_IN_DISKS: &[Elsewhere] = &[
    COLOR,
    FLUX,
    MATERIAL,
    KIND,
    Elsewhere {
        words: &["up", "rotate", "rotation"],
        key: Some("look_at"),
        advice: "a disk is round: `look_at` or `direction` says all of where it points",
    },
    Elsewhere {
        words: &["diameter", "width"],
        key: Some("radius"),
        advice: "write `radius`, a half of the diameter",
    },
];
const NOT_IN_SPHERES: &[Elsewhere] = &[
    COLOR,
    FLUX,
    MATERIAL,
    KIND,
    Elsewhere {
        words: &[
            "look_at",
            "direction",
            "up",
            "rotate",
            "rotation",
            "two_sided",
        ],
        key: None,
        advice: "a sphere shines the same to all sides",
    },
    Elsewhere {
        words: &["diameter", "width"],
        key: Some("radius"),
        advice: "write `radius`, a half of the diameter",
    },
];

fn rectangle(fields: &mut Fields<'_, '_, '_>) -> Option<Light> {
    let center = fields.vector(&CENTER);
    let aim = aim(fields);
    let up = match fields.get(&UP) {
        Some(_) => fields.vector(&UP).map(Some),
        None => Some(None),
    };
    let size = sides(fields);
    let two_sided = fields.boolean_or(&TWO_SIDED, false);
    let rest = rest(fields);
    let shape = AreaShape::Rectangle {
        center: center?,
        aim: aim?,
        up: up?,
        size: size?,
        two_sided: two_sided?,
    };
    Some(rest?.of(shape))
}

fn disk(fields: &mut Fields<'_, '_, '_>) -> Option<Light> {
    let center = fields.vector(&CENTER);
    let aim = aim(fields);
    let radius = fields.number(&RADIUS);
    let two_sided = fields.boolean_or(&TWO_SIDED, false);
    let rest = rest(fields);
    let shape = AreaShape::Disk {
        center: center?,
        aim: aim?,
        radius: radius?,
        two_sided: two_sided?,
    };
    Some(rest?.of(shape))
}

fn sphere(fields: &mut Fields<'_, '_, '_>) -> Option<Light> {
    let center = fields.vector(&CENTER);
    let radius = fields.number(&RADIUS);
    let rest = rest(fields);
    let shape = AreaShape::Sphere {
        center: center?,
        radius: radius?,
    };
    Some(rest?.of(shape))
}

/// What lights of all shapes have.
struct Rest {
    luminance: Spanned<Value>,
    visible: bool,
    samples: Spanned<f64>,
    group: Option<Spanned<String>>,
}

impl Rest {
    fn of(self, shape: AreaShape) -> Light {
        let Self {
            luminance,
            visible,
            samples,
            group,
        } = self;
        Light::Area {
            shape,
            luminance,
            visible,
            samples,
            group,
        }
    }
}

fn rest(fields: &mut Fields<'_, '_, '_>) -> Option<Rest> {
    let luminance = fields.value(&LUMINANCE, Purpose::Luminance);
    let visible = fields.boolean_or(&VISIBLE, true);
    let samples = match fields.get(&SAMPLES) {
        Some(node) => spanned(fields.reader.number(&SAMPLES, SAMPLES.name, node), node),
        None => Some(Spanned::new(f64::from(LIGHT_SAMPLES), fields.header)),
    };
    let group = fields.optional_string(&GROUP);
    Some(Rest {
        luminance: luminance?,
        visible: visible?,
        samples: samples?,
        group: group?,
    })
}

fn sides(fields: &mut Fields<'_, '_, '_>) -> Option<Spanned<[f64; 2]>> {
    let node = fields.require(&SIZE)?;
    let sides = fields.reader.moving(node, |reader, node| {
        reader.numbers::<2>(&SIZE, SIZE.name, node)
    });
    spanned(sides, node)
}
