//! `[materials.NAME.VARIANT]`

use std::ops::Bound;

use super::super::super::value::Value;
use super::super::super::{Lobes, Material};
use super::super::entries::{Section, Variant, Variants};
use super::super::fields::Fields;
use super::super::key::{BRIGHTEST, Elsewhere, Form, Key, Kind, Purpose, key};
use super::delta::{COAT, GLASS, METAL, MIRROR, PANE, SCHLICK, coat};

pub(in crate::scene::read) const MATERIALS: Section<Material> = Section {
    key: "materials",
    entry: "material",
    an_entry: "a material",
    names_channels: false,
    kind: "kind of material",
    example: "`[materials.NAME.phong]` with a name of your choice",
    variants: Variants {
        list: &[
            Variant {
                name: "phong",
                about: "Phong's reflectance to the letter: r = k_d cos(n, ω_i) + k_s cosⁿ(ω_o, ω_r).",
                also: &[
                    "lambert",
                    "lambertian",
                    "diffuse",
                    "matte",
                    "blinn_phong",
                    "plastic",
                ],
                form: Form::new(&[&DIFFUSE, &SPECULAR, &SHININESS, &COAT, &SCHLICK])
                    .elsewhere(NOT_IN_MATERIALS),
                read: |fields| lobes(fields).map(Material::Phong),
            },
            Variant {
                name: "normalized_phong",
                about: "r = cos(n, ω_i) [ρ_d/π + ρ_s (n+2)/(2π) cosⁿ(ω_o, ω_r)]: it never reflects \
                        more than it receives, so that ρ_d + ρ_s is at most 1.",
                also: &["modified_phong", "phong_normalized", "physical_phong"],
                form: Form::new(&[
                    &DIFFUSE_ALBEDO,
                    &SPECULAR_ALBEDO,
                    &SHININESS,
                    &COAT,
                    &SCHLICK,
                ])
                .elsewhere(NOT_IN_MATERIALS),
                read: |fields| lobes(fields).map(Material::NormalizedPhong),
            },
            MIRROR,
            METAL,
            GLASS,
            PANE,
        ],
        elsewhere: &[Elsewhere {
            words: &[
                "emissive",
                "emission",
                "principled",
                "disney",
                "pbr",
                "standard_surface",
                "roughconductor",
                "oren_nayar",
            ],
            key: None,
            advice: "materials are `phong` or `normalized_phong`, a diffuse and a specular lobe, or perfectly \
                     smooth: `mirror`, `metal`, `glass` and `pane`; none gives light of its own",
        }],
    },
};

const DIFFUSE: Key = key!(
    "diffuse",
    "a reflectance (a number, `[r, g, b]` or `\"#rrggbb\"`)",
    "[0.7, 0.3, 0.2]"
)
.of(Kind::Value(Purpose::Surface, 1.0))
.or("0")
.about("k_d: from 0 to 1. From 1/π ≈ 0.318 on a surface reflects more than it receives.")
.also(&[
    "k_d",
    "kd",
    "rho_d",
    "ρ_d",
    "albedo",
    "color",
    "colour",
    "base_color",
    "basecolor",
    "diffuse_color",
    "rgb",
]);
const DIFFUSE_ALBEDO: Key =
    DIFFUSE.about("ρ_d, an albedo: from 0 to 1, and with `specular` no more than 1.");
const SPECULAR: Key = key!(
    "specular",
    "a reflectance (a number, `[r, g, b]` or `\"#rrggbb\"`)",
    "0.3"
)
.of(Kind::Value(Purpose::Surface, BRIGHTEST))
.or("0")
.about("k_s: from 0.")
.also(&[
    "k_s",
    "ks",
    "rho_s",
    "ρ_s",
    "spec",
    "specular_color",
    "glossy",
]);
const SPECULAR_ALBEDO: Key = SPECULAR
    .of(Kind::Value(Purpose::Surface, 1.0))
    .about("ρ_s, an albedo: from 0 to 1, and with `diffuse` no more than 1.");
const SHININESS: Key = key!("shininess", "an exponent", "50")
    .of(Kind::Number((Bound::Excluded(0.0), Bound::Included(1e9))))
    .with("specular")
    .about("n, the exponent of the specular lobe: above 0, up to 1e9; the larger, the smaller the highlight.")
    .also(&["n", "exponent", "power", "shine", "phong_exponent", "specular_exponent", "hardness", "ns"]);

const NOT_IN_MATERIALS: &[Elsewhere] = &[
    Elsewhere {
        words: &["roughness", "glossiness", "gloss", "smoothness", "alpha"],
        key: Some("shininess"),
        advice: "Phong's lobe has an exponent and no roughness: write `shininess`, such as 10 (dull), \
                 100 or 1000 (polished)",
    },
    Elsewhere {
        words: &["k_a", "ka", "ambient"],
        key: None,
        advice: "there is no ambient light: what no light reaches is black",
    },
    Elsewhere {
        words: &["emission", "emissive", "k_e", "ke", "radiance"],
        key: None,
        advice: "materials give no light of their own; write a light, `[lights.NAME.point]`",
    },
    Elsewhere {
        words: &[
            "metallic",
            "metalness",
            "ior",
            "eta",
            "transmission",
            "opacity",
            "transparency",
            "sheen",
        ],
        key: None,
        advice: "this material is a diffuse and a specular lobe, `diffuse`, `specular` and `shininess`, under a \
                 coat, `reflectance`; others are `mirror`, `metal`, `glass` and `pane`",
    },
    Elsewhere {
        words: &[
            "texture",
            "map_kd",
            "map",
            "bump",
            "normal_map",
            "image",
            "file",
        ],
        key: None,
        advice: "there are no textures: a material is the same all over its object",
    },
    Elsewhere {
        words: &["type", "model", "bsdf", "shader", "kind"],
        key: None,
        advice: "the kind stands in the header: `[materials.NAME.phong]`, `normalized_phong`, `mirror`, \
                 `metal`, `glass` or `pane`",
    },
];

fn lobes(fields: &mut Fields<'_, '_, '_>) -> Option<Lobes> {
    let diffuse = fields.value_or(&DIFFUSE, Purpose::Surface, Value::ZERO);
    let specular = fields.value_or(&SPECULAR, Purpose::Surface, Value::ZERO);
    let shininess = fields.optional_number(&SHININESS);
    let coat = coat(fields);
    Some(Lobes {
        diffuse: diffuse?,
        specular: specular?,
        shininess: shininess?,
        coat: coat?,
    })
}
