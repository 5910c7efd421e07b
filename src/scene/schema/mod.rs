//! The scene format as a JSON schema, made of the tables that the reader uses.
//!
//! [JSON Schema draft 7](https://json-schema.org/draft-07), which is what editors of TOML know: Taplo,
//! and with it Even Better TOML, names unknown keys and wrong values while one writes, completes keys,
//! and shows what they mean.

mod json;

use std::ops::Bound;

use toml::de::DeValue;

use super::read::key::{AMOUNT, EXTENT, Form, Key, Kind, LARGEST, Presence, Purpose, Range};
use super::read::moving::{LAST_FRAME, MOVING};
use super::read::notation::Notation;
use super::read::outline::{self, Named};
use super::{MAX_RESOLUTION, Unit};
use crate::spectrum::{FIRST, LAST};
use json::{Json, Members, list, object};

/// The JSON schema of scene files, which editors check and complete them by; it ends in a newline.
///
/// What it cannot say: that a material is there, that `up` is not along the view, that wavelengths
/// ascend, that two albedos are at most 1 together, and what is in the files that a scene names.
/// `candela check` says all that.
///
/// ```
/// let schema = candela::scene::schema();
/// assert!(schema.contains("\"$schema\": \"http://json-schema.org/draft-07/schema#\""));
/// assert!(schema.contains("\"vertical_fov\""));
/// ```
pub fn schema() -> String {
    let mut properties = vec![
        (
            "image",
            form(
                "The picture: its size in pixels and its color space.",
                &outline::image(),
            ),
        ),
        (
            "camera",
            one_of_a_kind(
                "Where the picture is seen from: `[camera.perspective]` or `[camera.orthographic]`.",
                &outline::cameras(),
            ),
        ),
    ];
    properties.extend(outline::named().map(|section| (section.key, named(&section))));
    let include = object([
        (
            "description",
            Json::text("Files that are parts of this scene, relative to this one."),
        ),
        ("type", Json::text("array")),
        (
            "items",
            object([
                ("type", Json::text("string")),
                ("minLength", Json::from(1.0)),
            ]),
        ),
        ("examples", list([names(["lights.toml"])])),
    ]);
    properties.push(("include", include));
    let purposes = [
        (Purpose::Light, AMOUNT),
        (Purpose::Illuminance, AMOUNT),
        (Purpose::Luminance, AMOUNT),
        (Purpose::Color, AMOUNT),
        (Purpose::Background, AMOUNT),
        (Purpose::Surface, AMOUNT),
        (
            Purpose::Surface,
            (Bound::Included(0.0), Bound::Included(1.0)),
        ),
        (
            Purpose::Index,
            (Bound::Included(0.0), Bound::Included(100.0)),
        ),
        (
            Purpose::GlassIndex,
            (Bound::Included(1.0), Bound::Included(4.0)),
        ),
    ];
    let definitions =
        purposes.map(|(purpose, range)| (definition(purpose, range), value(purpose, range)));
    let schema = object([
        (
            "$schema",
            Json::text("http://json-schema.org/draft-07/schema#"),
        ),
        ("title", Json::text("A scene of candela")),
        (
            "description",
            Json::text(
                "A scene for candela, a renderer for direct light. Lengths are in scene units, one of \
                 which is a metre; angles in degrees; intensities in candela; radiance in cd/m².",
            ),
        ),
        ("type", Json::text("object")),
        // What a file includes may have the rest.
        (
            "anyOf",
            list(
                [names(["image", "camera", "objects"]), names(["include"])]
                    .map(|required| object([("required", required)])),
            ),
        ),
        ("additionalProperties", Json::Boolean(false)),
        ("properties", object(properties)),
        ("definitions", object(definitions)),
    ]);
    schema.pretty()
}

/// A section whose entries have names, each of one kind.
fn named(section: &Named) -> Json {
    let about = match section.key {
        "materials" => "How surfaces reflect: `[materials.NAME.phong]` with a name of your choice.",
        "lights" => "Where light comes from: `[lights.NAME.point]` with a name of your choice.",
        _ => "What light falls on: `[objects.NAME.sphere]` with a name of your choice.",
    };
    let entry = one_of_a_kind(
        &format!("The name of {}, of your choice.", section.an_entry),
        &section.kinds,
    );
    let mut members = vec![
        ("description", Json::text(about)),
        ("type", Json::text("object")),
        ("additionalProperties", Json::Boolean(false)),
        (
            "propertyNames",
            object([("maxLength", Json::from(outline::longest_name() as f64))]),
        ),
        (
            "patternProperties",
            Json::Object(vec![(name_pattern(&section.letters), entry)]),
        ),
    ];
    if section.key == "objects" {
        members.push(("minProperties", Json::from(1.0)));
    }
    object(members)
}

/// Names: the characters of ASCII that the reader lets be, and all others, of which the reader lets
/// letters and digits be.
fn name_pattern(letters: &[bool; 0x80]) -> String {
    let is_out = |code: usize| letters.get(code).is_some_and(|is_in| !is_in);
    let mut none_of = String::new();
    let mut code = 0;
    while code < letters.len() {
        let first = code;
        while is_out(code) {
            code += 1;
        }
        if code > first {
            none_of.push_str(&format!("\\u{first:04x}-\\u{:04x}", code - 1));
        }
        code += 1;
    }
    // Spaces may be amid a name, and not at its ends.
    format!("^[^ {none_of}]([^{none_of}]*[^ {none_of}])?$")
}

/// A table that has exactly one of some kinds of entry.
fn one_of_a_kind(about: &str, kinds: &[outline::Kind]) -> Json {
    let kinds = kinds
        .iter()
        .map(|kind| (kind.name, form(kind.about, &kind.form)));
    object([
        ("description", Json::text(about)),
        ("type", Json::text("object")),
        ("additionalProperties", Json::Boolean(false)),
        ("minProperties", Json::from(1.0)),
        ("maxProperties", Json::from(1.0)),
        ("properties", object(kinds)),
    ])
}

/// A table of keys.
fn form(about: &str, form: &Form<'_>) -> Json {
    let mut members = keys(form, AMOUNT);
    members.insert(0, ("description".to_owned(), Json::text(about)));
    Json::Object(members)
}

/// A table of keys; `channels` is the range of RGB among them.
fn keys(form: &Form<'_>, channels: Range) -> Members {
    let required = form
        .keys
        .iter()
        .filter(|key| matches!(key.presence, Presence::Required));
    let required: Vec<&str> = required.map(|key| key.name).collect();
    let properties = form
        .keys
        .iter()
        .map(|key| (key.name, property(key, channels)));
    let mut members = vec![("type", Json::text("object"))];
    if !required.is_empty() {
        members.push(("required", names(required.iter().copied())));
        // What Taplo writes where a table is completed.
        members.push(("x-taplo", object([("initKeys", names(required))])));
    }
    members.push(("additionalProperties", Json::Boolean(false)));
    members.push(("properties", object(properties)));
    for key in form.keys {
        if let Presence::With(other) = key.presence {
            let condition = object([
                ("required", names([other])),
                ("properties", object([(other, not_black())])),
            ]);
            members.push(("if", condition));
            members.push(("then", object([("required", names([key.name]))])));
        }
    }
    // Of two that stand for each other, exactly one.
    let mut pairs = form.keys.iter().filter_map(|key| match key.presence {
        Presence::InsteadOf(other) => Some([key.name, other]),
        Presence::Required | Presence::Optional | Presence::Default(_) | Presence::With(_) => None,
    });
    if let Some(pair) = pairs.next() {
        let choices = pair.map(|name| object([("required", names([name]))]));
        members.push(("oneOf", list(choices)));
    }
    members
        .into_iter()
        .map(|(name, member)| (name.to_owned(), member))
        .collect()
}

fn property(key: &Key, channels: Range) -> Json {
    let mut members = vec![("description".to_owned(), Json::text(key.about))];
    members.extend(holds(key.kind, channels));
    if let Presence::Default(default) = key.presence {
        members.push(("default".to_owned(), written(default)));
    }
    members.push(("examples".to_owned(), list([written(key.example)])));
    Json::Object(members)
}

/// What a key may hold: where it may move, keys of that as well.
fn holds(kind: Kind, channels: Range) -> Members {
    let still = holds_still(kind, channels);
    match kind {
        Kind::Number(_)
        | Kind::Vector
        | Kind::Direction
        | Kind::Corners
        | Kind::Channels
        | Kind::Sides => or_moving(still),
        Kind::Factors => {
            let moving = moving(&Json::Object(still.clone()));
            still
                .into_iter()
                .map(|(name, member)| match member {
                    Json::List(mut choices) => {
                        choices.push(Json::Object(moving.clone()));
                        (name, Json::List(choices))
                    }
                    member => (name, member),
                })
                .collect()
        }
        // Of values, the definition says so.
        Kind::Value(..)
        | Kind::Pixels
        | Kind::Whole(_)
        | Kind::Count(_)
        | Kind::Boolean
        | Kind::Text
        | Kind::LightName
        | Kind::Name(_)
        | Kind::Wavelengths
        | Kind::Amounts
        | Kind::Lines
        | Kind::Density
        | Kind::Keys => still,
    }
}

/// The same, or keys of it. What is said of an object applies to that type alone, so that an editor still names the
/// number that is out of range.
fn or_moving(still: Members) -> Members {
    let moving = moving(&Json::Object(still.clone()));
    let mut members: Members = still
        .into_iter()
        .map(|(name, member)| match member {
            Json::Text(kind) if name == "type" => (name, names([kind.as_str(), "object"])),
            member => (name, member),
        })
        .collect();
    members.extend(moving.into_iter().filter(|(name, _)| name != "type"));
    members
}

/// Keys whose values are such.
fn moving(value: &Json) -> Members {
    let frame = (Bound::Included(-LAST_FRAME), Bound::Included(LAST_FRAME));
    let pair = object([
        ("type", Json::text("array")),
        ("items", list([Json::Object(number(frame)), value.clone()])),
        ("minItems", Json::from(2.0)),
        ("maxItems", Json::from(2.0)),
    ]);
    let mut members = keys(&MOVING, AMOUNT);
    for (name, member) in &mut members {
        if name == "properties"
            && let Json::Object(properties) = member
        {
            for (key, property) in properties {
                if key == "keys"
                    && let Json::Object(property) = property
                {
                    property.push(("items".to_owned(), pair.clone()));
                }
            }
        }
    }
    members
}

fn holds_still(kind: Kind, channels: Range) -> Members {
    let members = match kind {
        Kind::Number(range) => return number(range),
        Kind::Vector => return vector(vec![]),
        Kind::Direction => {
            let not_zero = [above(0.0), below(0.0)];
            return vector(vec![("contains", object([("anyOf", list(not_zero))]))]);
        }
        Kind::Corners => vec![
            ("type", Json::text("array")),
            ("items", Json::Object(vector(vec![]))),
            ("minItems", Json::from(3.0)),
            ("maxItems", Json::from(3.0)),
        ],
        Kind::Factors => {
            let smallest = LARGEST.recip();
            let factor = || {
                let part = |least, most| {
                    let range = (Bound::Included(least), Bound::Included(most));
                    Json::Object(number(range))
                };
                object([(
                    "anyOf",
                    list([part(-LARGEST, -smallest), part(smallest, LARGEST)]),
                )])
            };
            let factors = object([
                ("type", Json::text("array")),
                ("items", factor()),
                ("minItems", Json::from(3.0)),
                ("maxItems", Json::from(3.0)),
            ]);
            vec![("anyOf", list([factor(), factors]))]
        }
        Kind::Pixels => {
            let side = object([
                ("type", Json::text("integer")),
                ("minimum", Json::from(1.0)),
                ("maximum", Json::from(f64::from(MAX_RESOLUTION))),
            ]);
            vec![
                ("type", Json::text("array")),
                ("items", side),
                ("minItems", Json::from(2.0)),
                ("maxItems", Json::from(2.0)),
            ]
        }
        Kind::Sides => vec![
            ("type", Json::text("array")),
            ("items", Json::Object(number(EXTENT))),
            ("minItems", Json::from(2.0)),
            ("maxItems", Json::from(2.0)),
        ],
        Kind::Whole(most) => vec![
            ("type", Json::text("integer")),
            ("minimum", Json::from(1.0)),
            ("maximum", Json::from(f64::from(most))),
        ],
        Kind::Count(most) => vec![
            ("type", Json::text("integer")),
            ("minimum", Json::from(0.0)),
            ("maximum", Json::from(f64::from(most))),
        ],
        Kind::Boolean => vec![("type", Json::text("boolean"))],
        Kind::Text => vec![("type", Json::text("string"))],
        Kind::LightName => {
            let [_, lights, _] = outline::named();
            return vec![
                ("type".to_owned(), Json::text("string")),
                (
                    "maxLength".to_owned(),
                    Json::from(outline::longest_name() as f64),
                ),
                (
                    "pattern".to_owned(),
                    Json::text(&name_pattern(&lights.letters)),
                ),
            ];
        }
        Kind::Name(all) => vec![("enum", names(all()))],
        Kind::Value(purpose, most) => {
            let range = (Bound::Included(purpose.least()), Bound::Included(most));
            let place = format!("#/definitions/{}", definition(purpose, range));
            // Beside a `$ref` nothing else counts in this draft.
            vec![("allOf", list([object([("$ref", Json::text(&place))])]))]
        }
        Kind::Channels => vec![
            ("type", Json::text("array")),
            ("items", Json::Object(number(channels))),
            ("minItems", Json::from(3.0)),
            ("maxItems", Json::from(3.0)),
        ],
        Kind::Wavelengths => vec![
            ("type", Json::text("array")),
            ("items", above(0.0)),
            ("minItems", Json::from(2.0)),
        ],
        Kind::Amounts => vec![
            ("type", Json::text("array")),
            ("items", from_zero()),
            ("minItems", Json::from(2.0)),
        ],
        Kind::Lines => {
            let nm = (
                Bound::Included(f64::from(FIRST)),
                Bound::Included(f64::from(LAST)),
            );
            let line = object([
                ("type", Json::text("array")),
                ("items", list([Json::Object(number(nm)), from_zero()])),
                ("minItems", Json::from(2.0)),
                ("maxItems", Json::from(2.0)),
            ]);
            vec![
                ("type", Json::text("array")),
                ("items", line),
                ("minItems", Json::from(1.0)),
            ]
        }
        Kind::Density => {
            let curves = [Notation::Curve, Notation::File];
            let curves = curves.map(|notation| Json::Object(keys(&notation.form(), AMOUNT)));
            let choices = std::iter::once(from_zero()).chain(curves);
            vec![("anyOf", list(choices))]
        }
        Kind::Keys => vec![("type", Json::text("array")), ("minItems", Json::from(1.0))],
    };
    members
        .into_iter()
        .map(|(name, member)| (name.to_owned(), member))
        .collect()
}

/// The name of the definition of values for a purpose, in a range of channels.
fn definition(purpose: Purpose, (_, most): Range) -> &'static str {
    match purpose {
        Purpose::Light => "light",
        Purpose::Illuminance => "illuminance",
        Purpose::Luminance => "luminance",
        Purpose::Color => "color_of_light",
        Purpose::Background => "background",
        Purpose::Surface if most == Bound::Included(1.0) => "reflectance_to_1",
        Purpose::Surface => "reflectance",
        Purpose::Index => "index",
        Purpose::GlassIndex => "index_of_glass",
    }
}

/// A value for light, color or a refractive index, in every notation that may stand there.
///
/// What is said of numbers, arrays and text stands side by side, as each applies to its type alone:
/// an editor then names the number that is out of range instead of a list of notations.
fn value(purpose: Purpose, range: Range) -> Json {
    let flat: &[&str] = if purpose.is_index() {
        &["number"]
    } else {
        &["number", "array", "string"]
    };
    let mut members = number(range);
    members.retain(|(name, _)| name != "type");
    if !purpose.is_index() {
        members.extend(holds_still(Kind::Channels, range));
        members.retain(|(name, _)| name != "type");
        let coded = Json::text("^#[0-9A-Fa-f]{6}$");
        members.push(("pattern".to_owned(), coded));
    }
    let all = names(flat.iter().copied().chain(["object"]));
    members.insert(0, ("type".to_owned(), all));
    let notations = Notation::ALL.into_iter();
    let tables = notations
        .filter(|notation| notation.is_for(purpose).is_ok())
        .map(|notation| {
            let mut table = keys(&notation.form(), range);
            let about = Json::text(about_notation(notation));
            table.insert(0, ("description".to_owned(), about));
            Json::Object(table)
        });
    let flat = object([("type", names(flat.iter().copied()))]);
    let place = format!("#/definitions/{}", definition(purpose, range));
    let moving = moving(&object([("$ref", Json::text(&place))]));
    let choices = std::iter::once(flat).chain(tables);
    let choices = list(choices.chain([Json::Object(moving)]));
    members.push(("anyOf".to_owned(), choices));
    Json::Object(members)
}

const fn about_notation(notation: Notation) -> &'static str {
    match notation {
        Notation::Rgb => "Red, green and blue, linear, in any color space.",
        Notation::Illuminant => "The color of an illuminant of the CIE.",
        Notation::Daylight => "The color of daylight by its temperature.",
        Notation::Blackbody => "The color of a glowing body by its temperature.",
        Notation::Curve => "A curve: a value at each wavelength.",
        Notation::File => "A curve from a file.",
        Notation::Lines => "Light of single wavelengths.",
        Notation::Sized(Unit::Candela) => "A luminous intensity, and a color.",
        Notation::Sized(Unit::Lumens) => "A luminous flux, and a color.",
        Notation::Sized(Unit::WattsPerSteradian) => "A radiant intensity, and a color.",
        Notation::Sized(Unit::Watts) => "A radiant flux, and a color.",
        Notation::Sized(Unit::Lux) => "An illuminance, and a color.",
        Notation::Sized(Unit::Nits) => "A luminance, and a color.",
        Notation::Density => "A spectral intensity.",
    }
}

/// A value that is not 0 in every channel, as far as the scene alone tells.
fn not_black() -> Json {
    let some = || object([("type", Json::text("array")), ("contains", above(0.0))]);
    let table = |key| {
        object([
            ("type", Json::text("object")),
            ("required", names([key])),
            ("properties", object([(key, some())])),
        ])
    };
    let coded = object([
        ("type", Json::text("string")),
        ("pattern", Json::text("[1-9A-Fa-f]")),
    ]);
    object([(
        "anyOf",
        list([above(0.0), some(), coded, table("rgb"), table("values")]),
    )])
}

/// Three coordinates.
fn vector(more: Vec<(&'static str, Json)>) -> Members {
    let range = (Bound::Included(-LARGEST), Bound::Included(LARGEST));
    let mut members = vec![
        ("type", Json::text("array")),
        ("items", Json::Object(number(range))),
        ("minItems", Json::from(3.0)),
        ("maxItems", Json::from(3.0)),
    ];
    members.extend(more);
    members
        .into_iter()
        .map(|(name, member)| (name.to_owned(), member))
        .collect()
}

fn number((least, most): Range) -> Members {
    let mut members = vec![("type".to_owned(), Json::text("number"))];
    let mut bound = |bound: Bound<f64>, including: &str, excluding: &str| match bound {
        Bound::Included(limit) => members.push((including.to_owned(), Json::from(limit))),
        Bound::Excluded(limit) => members.push((excluding.to_owned(), Json::from(limit))),
        Bound::Unbounded => {}
    };
    bound(least, "minimum", "exclusiveMinimum");
    bound(most, "maximum", "exclusiveMaximum");
    members
}

fn above(limit: f64) -> Json {
    Json::Object(number((Bound::Excluded(limit), Bound::Unbounded)))
}

fn below(limit: f64) -> Json {
    Json::Object(number((Bound::Unbounded, Bound::Excluded(limit))))
}

fn from_zero() -> Json {
    Json::Object(number((Bound::Included(0.0), Bound::Unbounded)))
}

fn names<'a>(names: impl IntoIterator<Item = &'a str>) -> Json {
    list(names.into_iter().map(Json::text))
}

/// A value of the tables, which is TOML, as JSON.
fn written(text: &str) -> Json {
    fn json(value: &DeValue<'_>) -> Json {
        match value {
            DeValue::String(text) => Json::text(text),
            DeValue::Integer(number) => Json::from(as_number(number.as_str())),
            DeValue::Float(number) => Json::from(as_number(number.as_str())),
            DeValue::Boolean(value) => Json::Boolean(*value),
            DeValue::Datetime(date) => Json::text(&date.to_string()),
            DeValue::Array(items) => list(items.iter().map(|item| json(item.get_ref()))),
            DeValue::Table(table) => {
                let members = table.iter();
                let members =
                    members.map(|(key, item)| (key.get_ref().to_string(), json(item.get_ref())));
                Json::Object(members.collect())
            }
        }
    }
    fn as_number(text: &str) -> f64 {
        text.parse().expect("the numbers of the tables are decimal")
    }
    let value = DeValue::parse(text).expect("the values of the tables are TOML");
    json(value.get_ref())
}
