//! Which layer the light of each light goes to.

use std::collections::HashMap;

use crate::world::World;

/// What the background is called among the lights.
pub const BACKGROUND_LIGHT: &str = "background";

/// Whether the background adds to the radiance.
pub(super) fn has_background_share(world: &World) -> bool {
    world.background().0.0 != [0.0; 3]
}

/// The shares of the radiance: one for each light that has no group, one for each group of lights, in the order of the
/// file, and one for the background unless it is black.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Shares {
    names: Vec<String>,
    of_light: Vec<Option<usize>>,
    /// Those of lights that are seen themselves, ascending.
    seen: Vec<usize>,
    background: Option<usize>,
}

impl Shares {
    /// Those with some names; `None` is all.
    pub(super) fn new(world: &World, only: Option<&[String]>) -> Self {
        let mut shares = Self {
            names: Vec::new(),
            of_light: Vec::new(),
            seen: Vec::new(),
            background: None,
        };
        let mut places = HashMap::new();
        let is_in = |name: &str| only.is_none_or(|only| only.iter().any(|one| one == name));
        for (light, entry) in world.lights().iter().enumerate() {
            let name = world.light_group(light).unwrap_or(&entry.name);
            let share = is_in(name).then(|| {
                *places.entry(name).or_insert_with(|| {
                    shares.names.push(name.to_owned());
                    shares.names.len() - 1
                })
            });
            shares.of_light.push(share);
        }
        let objects = world.objects().iter();
        let seen = objects.filter_map(|object| shares.of_light[object.emits?]);
        shares.seen = seen.collect();
        shares.seen.sort_unstable();
        shares.seen.dedup();
        if has_background_share(world) && is_in(BACKGROUND_LIGHT) {
            shares.background = Some(shares.names.len());
            shares.names.push(BACKGROUND_LIGHT.to_owned());
        }
        shares
    }

    /// The names of all.
    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    /// The names of those that lights have.
    pub(super) fn of_lights(&self) -> &[String] {
        &self.names[..self.names.len() - usize::from(self.background.is_some())]
    }

    /// Those of lights that are seen themselves, as indices into the names.
    pub(super) fn seen(&self) -> &[usize] {
        &self.seen
    }

    /// Of a light, an index into the names.
    pub(super) fn of_light(&self, light: usize) -> Option<usize> {
        self.of_light[light]
    }

    /// Of the background.
    pub(super) fn background(&self) -> Option<usize> {
        self.background
    }
}
