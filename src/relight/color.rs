//! Colors of lights, made as the renderer makes them: by a scene of one light.

use std::path::PathBuf;
use std::sync::Arc;

use super::error::RelightError;
use super::setting::Setting;
use crate::scene::{ColorSpace, Diagnostics, Scene, Source, Span, Transport};
use crate::spectrum::Observer;
use crate::world::World;

/// What the colors of a file depend on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Working {
    pub(super) space: ColorSpace,
    pub(super) observer: Observer,
    pub(super) transport: Transport,
}

/// What messages call the text of a setting.
const SHOWN: &str = "--light";

/// A world whose only light has `intensity = { candela = …, color = … }`, with the color of the setting.
///
/// # Errors
/// What a scene with this color would be told, with its place in the setting.
pub(super) fn world(
    setting: &Setting,
    candela: f64,
    working: Working,
) -> Result<World, RelightError> {
    let place = setting.color_place().unwrap_or_default();
    let color = setting.color().unwrap_or_default();
    let Working {
        space,
        observer,
        transport,
    } = working;
    let (space, observer, transport) = (space.name(), observer.name(), transport.name());
    // What has quotes in a scene goes without on the command line, where a shell would take them.
    let quote = if color.starts_with('#') { "\"" } else { "" };
    let before = format!(
        "[image]
resolution = [1, 1]
color_space = \"{space}\"
observer = \"{observer}\"
transport = \"{transport}\"
[camera.orthographic]
eye = [0, 0, 2]
look_at = [0, 0, 0]
height = 1
[materials.m.phong]
diffuse = 0.5
[objects.o.sphere]
material = \"m\"
center = [0, 0, 0]
radius = 1
[lights.l.point]
position = [0, 0, 2]
[lights.l.point.intensity]
candela = {candela:?}
color = {quote}"
    );
    let text = format!("{before}{color}{quote}\n");
    let made = Scene::parse(&text, SHOWN).and_then(|scene| World::new(&scene));
    let (world, _) = made.map_err(|errors| {
        let color = before.len()..before.len() + color.len();
        let written =
            |offset: usize| offset.clamp(color.start, color.end) - color.start + place.start;
        RelightError::Color(in_setting(errors, setting, |span| {
            let is_within = span.start < color.end && span.end > color.start;
            if is_within {
                Span::from(written(span.start)..written(span.end))
            } else {
                Span::from(place.clone())
            }
        }))
    })?;
    Ok(world)
}

/// Errors of the scene as errors of the setting's own text.
fn in_setting(errors: Diagnostics, setting: &Setting, place: impl Fn(Span) -> Span) -> Diagnostics {
    let source = Source::new(PathBuf::from(SHOWN), setting.to_string());
    errors.moved(Arc::new(source), place)
}
