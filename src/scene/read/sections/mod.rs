//! What each section holds: image, cameras, materials, lights, objects.

mod aim;
mod areas;
mod camera;
mod delta;
mod image;
mod lights;
mod materials;
mod objects;

use super::super::diagnostic::Problem;
use super::key::unknown;
pub(super) use camera::{CAMERAS, camera};
pub(super) use image::{IMAGE, image};
pub(super) use lights::LIGHTS;
pub(super) use materials::MATERIALS;
pub(super) use objects::OBJECTS;

/// The sections of a scene file.
pub(super) const SECTIONS: [&str; 5] = ["image", "camera", "materials", "lights", "objects"];

/// What to say of a section that there is not.
pub(super) fn unknown_section(name: &str) -> Problem {
    let meant = match &*name.to_lowercase() {
        "scene" | "settings" | "render" | "film" | "options" => Some("image"),
        "view" | "sensor" => Some("camera"),
        "bsdfs" | "bsdf" | "shaders" | "mtl" => Some("materials"),
        "lamps" | "lamp" | "emitters" | "luminaires" => Some("lights"),
        "shapes" | "shape" | "geometry" | "meshes" | "spheres" | "primitives" | "models" => {
            Some("objects")
        }
        _ => None,
    };
    match meant {
        Some(meant) => Problem::OtherWord {
            what: "section",
            name: name.to_owned(),
            meant,
        },
        None => unknown("section", name, SECTIONS, &[]),
    }
}
