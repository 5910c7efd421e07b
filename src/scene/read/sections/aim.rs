//! What lights of several kinds have: where they point, and their group.

use super::super::super::Aim;
use super::super::super::diagnostic::Problem;
use super::super::fields::Fields;
use super::super::key::{Key, Kind, key};

pub(super) const GROUP: Key = key!("group", "the name of a group of lights", "\"window\"")
    .of(Kind::LightName)
    .optional()
    .about(
        "Lights with the same `group` have one layer together, `light_GROUP`, with `--layers lights`. No light has the \
         name of a group.",
    )
    .also(&["light_group", "lightgroup", "groups", "set", "layer"]);

pub(super) const LOOK_AT: Key = key!(
    "look_at",
    "a point that the light points at, or a vector along its way, `direction`",
    "[0, 0, 0]"
)
.of(Kind::Vector)
.instead_of("direction")
.about("A point on the axis. Either this or `direction`.")
.also(&["target", "to", "aim", "at", "lookat"]);

pub(super) const DIRECTION: Key = key!("direction", "where the light points", "[0, -1, 0]")
    .of(Kind::Direction)
    .instead_of("look_at")
    .about("A vector along the axis, of any length but 0. Either this or `look_at`.")
    .also(&["dir", "axis", "normal", "d"]);

/// Either `look_at` or `direction`.
pub(super) fn aim(fields: &mut Fields<'_, '_, '_>) -> Option<Aim> {
    match (fields.get(&LOOK_AT), fields.get(&DIRECTION)) {
        (Some(_), Some(direction)) => {
            let conflict =
                "both `look_at` and `direction` say where the light points, expected one of them";
            let problem = Problem::Conflict(conflict.to_owned());
            fields.reader.report(direction.span().into(), problem);
            None
        }
        (None, Some(_)) => fields.vector(&DIRECTION).map(Aim::Direction),
        // Without either, `look_at` is said to be missing.
        (Some(_) | None, None) => fields.vector(&LOOK_AT).map(Aim::LookAt),
    }
}
