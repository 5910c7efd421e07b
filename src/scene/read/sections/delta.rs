//! `[materials.NAME.mirror]`, `metal`, `glass` and `pane`, and the coat of a Phong material.

use std::ops::Bound;

use super::super::super::diagnostic::{Problem, Spanned};
use super::super::super::value::Value;
use super::super::super::{Glass, GlassIndex, Material, Metal, Mirror, Pane};
use super::super::entries::Variant;
use super::super::fields::Fields;
use super::super::key::{BRIGHTEST, Elsewhere, Form, Key, Kind, Purpose, key};
use crate::optics::{Glass as Glasses, Metal as Metals};

pub(super) const MIRROR: Variant<Material> = Variant {
    name: "mirror",
    about: "A perfect mirror: L = R L_r, what is seen along the mirrored ray.",
    also: &["specular_mirror", "perfect_mirror", "reflective", "chrome"],
    form: Form::new(&[&REFLECTANCE, &SCHLICK]).elsewhere(NOT_IN_DELTAS),
    read: |fields| {
        let reflectance = fields.value(&REFLECTANCE, Purpose::Surface);
        let schlick = fields.boolean_or(&SCHLICK, false);
        Some(Material::Mirror(Mirror {
            reflectance: reflectance?,
            schlick: schlick?,
        }))
    },
};

pub(super) const METAL: Variant<Material> = Variant {
    name: "metal",
    about: "Polished metal: a mirror whose reflectance is that of Fresnel's equations for n + ik.",
    also: &["conductor", "smooth_conductor", "metallic"],
    form: Form::new(&[&METAL_N, &METAL_K, &PRESET]).elsewhere(NOT_IN_DELTAS),
    read: metal,
};

pub(super) const GLASS: Variant<Material> = Variant {
    name: "glass",
    about: "A smooth body that reflects and bends light, L = F L_r + (1 − F) L_t: a sphere or a closed mesh.",
    also: &[
        "dielectric",
        "smooth_dielectric",
        "refractive",
        "transparent",
        "water",
    ],
    form: Form::new(&[&GLASS_N, &SELLMEIER, &ABSORPTION, &DISPERSION]).elsewhere(NOT_IN_DELTAS),
    read: glass,
};

pub(super) const PANE: Variant<Material> = Variant {
    name: "pane",
    about: "A thin sheet of glass: both faces reflect, and nothing is bent.",
    also: &[
        "thin",
        "thin_dielectric",
        "thindielectric",
        "window",
        "thin_glass",
    ],
    form: Form::new(&[&PANE_N]).elsewhere(NOT_IN_DELTAS),
    read: |fields| {
        let n = fields.number(&PANE_N);
        Some(Material::Pane(Pane { n: n? }))
    },
};

const REFLECTANCE: Key = key!(
    "reflectance",
    "a reflectance (a number, `[r, g, b]` or `\"#rrggbb\"`)",
    "0.95"
)
.of(Kind::Value(Purpose::Surface, 1.0))
.about("R, how much of what is seen in the mirror is left: from 0 to 1.")
.also(&[
    "r",
    "specular",
    "k_s",
    "ks",
    "color",
    "colour",
    "albedo",
    "specular_reflectance",
    "tint",
]);
pub(super) const COAT: Key = key!("reflectance", "a number from 0 to 1", "0.04")
    .of(Kind::Number((Bound::Included(0.0), Bound::Included(1.0))))
    .optional()
    .about("R of a clear coat over the lobes, L = R L_r + (1 − R) L_lobes: from 0 to 1. Without it there is none.")
    .also(&["coat", "clearcoat", "clear_coat", "coating"]);
pub(super) const SCHLICK: Key = key!("schlick", "`true` or `false`", "true")
    .of(Kind::Boolean)
    .or("false")
    .about("Whether R rises to 1 at grazing angles: R + (1 − R)(1 − cos θ)⁵.")
    .also(&["fresnel", "schlick_fresnel"]);
const METAL_N: Key = key!("n", "a refractive index (a number or a curve), or a `preset`", "0.2")
    .of(Kind::Value(Purpose::Index, MOST))
    .instead_of("preset")
    .about("The real part of the refractive index n + ik: from 0 to 100. Either this, with `k`, or `preset`.")
    .also(&["eta", "ior", "refractive_index", "index"]);
const METAL_K: Key = key!(
    "k",
    "an extinction coefficient (a number or a curve)",
    "3.0"
)
.of(Kind::Value(Purpose::Index, MOST))
.with("n")
.about("The imaginary part of the refractive index n + ik: from 0 to 100.")
.also(&["extinction", "kappa"]);
const PRESET: Key = key!("preset", "the name of a metal", "\"gold\"")
    .of(Kind::Name(metals))
    .instead_of("n")
    .about("A metal whose n and k are known at each wavelength. Either this or `n` and `k`.")
    .also(&["material", "metal", "name", "conductor"]);
const GLASS_N: Key = key!(
    "n",
    "a refractive index (a number or a curve), or a glass, `sellmeier`",
    "1.5"
)
.of(Kind::Value(Purpose::GlassIndex, 4.0))
.instead_of("sellmeier")
.about("The refractive index: from 1 to 4. Either this or `sellmeier`.")
.also(&["ior", "eta", "refractive_index", "index", "int_ior"]);
const SELLMEIER: Key = key!("sellmeier", "the name of a glass", "\"N-BK7\"")
    .of(Kind::Name(glasses))
    .instead_of("n")
    .about("A glass whose refractive index is known at each wavelength. Either this or `n`.")
    .also(&["glass", "preset", "name", "catalog"]);
const ABSORPTION: Key = key!(
    "absorption",
    "absorption per metre (a number or `[r, g, b]`)",
    "[1, 0.2, 0.1]"
)
.of(Kind::Value(Purpose::Surface, BRIGHTEST))
.or("0")
.about("σ in 1/m: of light that goes x metres through the glass e^(−σx) is left.")
.also(&[
    "sigma",
    "sigma_a",
    "attenuation",
    "absorption_coefficient",
    "density",
]);
const DISPERSION: Key = key!("dispersion", "`true` or `false`", "true")
    .of(Kind::Boolean)
    .or("false")
    .about(
        "Whether each wavelength is bent by an angle of its own. Else all go the way of 587.6 nm.",
    )
    .also(&["dispersive", "prism", "abbe"]);
const PANE_N: Key = key!("n", "a refractive index", "1.5")
    .of(Kind::Number((Bound::Included(1.0), Bound::Included(4.0))))
    .about("The refractive index: from 1 to 4.")
    .also(&["ior", "eta", "refractive_index", "index"]);

/// The largest n and k of a metal.
const MOST: f64 = 100.0;

const NOT_IN_DELTAS: &[Elsewhere] = &[
    Elsewhere {
        words: &[
            "roughness",
            "glossiness",
            "gloss",
            "smoothness",
            "alpha",
            "shininess",
        ],
        key: None,
        advice: "mirrors, metals and glass are perfectly smooth; a dull highlight is a `phong` material's lobe",
    },
    Elsewhere {
        words: &["diffuse", "k_d", "kd", "base_color"],
        key: None,
        advice: "what also scatters light is a `phong` material with a coat: `reflectance = 0.04`",
    },
    Elsewhere {
        words: &[
            "transmission",
            "transmittance",
            "opacity",
            "transparency",
            "filter",
        ],
        key: None,
        advice: "what is let through follows from `n`; color comes from the `absorption` of a `glass`",
    },
    Elsewhere {
        words: &["type", "model", "bsdf", "shader", "kind"],
        key: None,
        advice: "the kind stands in the header, such as `[materials.NAME.mirror]` or `[materials.NAME.glass]`",
    },
];

fn metals() -> Vec<&'static str> {
    Metals::names().collect()
}

fn glasses() -> Vec<&'static str> {
    Glasses::names().collect()
}

fn metal(fields: &mut Fields<'_, '_, '_>) -> Option<Material> {
    let preset = fields.get(&PRESET).map(toml::Spanned::span);
    let (has_n, has_k) = (
        fields.get(&METAL_N).is_some(),
        fields.get(&METAL_K).is_some(),
    );
    if let Some(span) = preset {
        if has_n || has_k {
            let other = if has_n { "n" } else { "k" };
            let conflict =
                format!("both `preset` and `{other}` say what metal it is, expected one of them");
            fields
                .reader
                .report(span.into(), Problem::Conflict(conflict));
            return None;
        }
        let name = named(fields, &PRESET, "metal", &metals())?;
        return Some(Material::Metal(Metal::Preset(name)));
    }
    let n = fields.value(&METAL_N, Purpose::Index);
    let k = if has_k || n.as_ref().is_some_and(|n| n.value != Value::ZERO) {
        fields.value(&METAL_K, Purpose::Index)
    } else {
        fields.value_or(&METAL_K, Purpose::Index, Value::ZERO)
    };
    Some(Material::Metal(Metal::Indices { n: n?, k: k? }))
}

fn glass(fields: &mut Fields<'_, '_, '_>) -> Option<Material> {
    let index = match (fields.get(&GLASS_N), fields.get(&SELLMEIER)) {
        (Some(_), Some(node)) => {
            let conflict =
                "both `n` and `sellmeier` say how much it bends light, expected one of them";
            let problem = Problem::Conflict(conflict.to_owned());
            fields.reader.report(node.span().into(), problem);
            None
        }
        (None, Some(_)) => {
            let name = named(fields, &SELLMEIER, "glass", &glasses());
            name.map(GlassIndex::Sellmeier)
        }
        // Without either, `n` is said to be missing.
        (Some(_) | None, None) => {
            let n = fields.value(&GLASS_N, Purpose::GlassIndex);
            n.map(GlassIndex::Value)
        }
    };
    let absorption = fields.value_or(&ABSORPTION, Purpose::Surface, Value::ZERO);
    let dispersion = fields.boolean_or(&DISPERSION, false);
    Some(Material::Glass(Glass {
        index: index?,
        absorption: absorption?,
        dispersion: dispersion?,
    }))
}

/// The coat of a Phong material, if it has one.
pub(super) fn coat(fields: &mut Fields<'_, '_, '_>) -> Option<Option<Mirror>> {
    let reflectance = fields.optional_number(&COAT);
    let schlick = fields.boolean_or(&SCHLICK, false);
    let reflectance = reflectance?;
    let schlick = schlick?;
    Some(reflectance.map(|Spanned { value, span }| Mirror {
        reflectance: Spanned::new(Value::Uniform(value), span),
        schlick,
    }))
}

/// One of a few names.
fn named(
    fields: &mut Fields<'_, '_, '_>,
    key: &'static Key,
    what: &'static str,
    names: &[&'static str],
) -> Option<Spanned<String>> {
    let written = fields.string(key)?;
    if names.contains(&&*written.value) {
        return Some(written);
    }
    let problem = Problem::unknown(what, &written.value, names.iter().copied());
    fields.reader.report(written.span, problem);
    None
}
