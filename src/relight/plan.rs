//! What becomes of each channel of a file.

use std::collections::BTreeSet;

use super::change::{Change, Terms};
use super::shares::{ChannelMap, LOBES, Share, Shares};
use crate::exr::StoredExr;
use crate::printable::shortened;

/// What a channel of the new file holds.
#[derive(Debug)]
pub(super) enum Output {
    /// What it held.
    Copy,
    /// A sum over channels of the old file.
    Linear(Terms),
    /// A sum over shares, some of which have changed.
    Sum(Sum),
}

/// A sum over shares: L' = L + Σ (L'_i − L_i). Where L is the sum of all L_i but for rounding, that is Σ L'_i, in which
/// no light that went off leaves its rounding behind.
#[derive(Debug)]
pub(super) struct Sum {
    pub(super) parts: Vec<Part>,
    /// Whether every share is among the parts.
    pub(super) is_complete: bool,
}

/// One share: L_i, and what L'_i is made of.
#[derive(Debug)]
pub(super) struct Part {
    pub(super) old: usize,
    pub(super) new: Terms,
}

/// What becomes of a file.
#[derive(Debug)]
pub(super) struct Plan {
    /// The channels that stay, by their places, ascending.
    pub(super) kept: Vec<usize>,
    /// What each of these holds.
    pub(super) outputs: Vec<Output>,
    /// Attributes that go with channels that go.
    pub(super) left_out: Vec<&'static str>,
    /// What a user should know, a sentence each.
    pub(super) notes: Vec<String>,
}

/// What is said about the bands of a spectral image.
const OF_BANDS: [&str; 3] = ["candela:bands", "emissiveUnits", "spectralLayoutVersion"];

/// Layers and channels that light does not change.
const UNLIT: [&str; 10] = [
    "R", "G", "B", "A", "Z", "N", "P", "albedo", "emission", "samples",
];

/// What the names of further ones begin with, and of those that are changed where that is to be.
const KNOWN: [&str; 5] = ["shadow_", "Crypto", "light_", "relight_", "emission_"];

/// What comes by mirrors and glass, of all lights together.
const PATHS: [&str; 2] = ["reflection", "refraction"];

impl Plan {
    pub(super) fn new(
        stored: &StoredExr,
        channels: &ChannelMap<'_>,
        shares: &Shares,
        changes: &[Option<Change>],
    ) -> Self {
        let outputs = stored.names().iter().map(|_| Some(Output::Copy));
        let mut planned = Planned {
            outputs: outputs.collect(),
            left_out: Vec::new(),
            notes: Vec::new(),
        };
        if changes.iter().any(Option::is_some) {
            let changed: Vec<(&Share, Option<&Change>)> = shares
                .list
                .iter()
                .zip(changes.iter().map(Option::as_ref))
                .collect();
            planned.of_shares(channels, &changed);
            planned.of_lobes(channels, &changed);
            planned.of_light(stored);
            let with_layers = changed.iter();
            let with_layers =
                with_layers.filter_map(|&(share, change)| Some((share, share.layer?, change)));
            let parts = |channel: usize| {
                let parts = with_layers.clone();
                parts.map(move |(share, layer, change)| Part {
                    old: layer[channel],
                    new: match change {
                        Some(change) => change.terms(share, layer, channel),
                        None => vec![(layer[channel], 1.0)],
                    },
                })
            };
            let is_complete = shares.are_complete();
            for (channel, &place) in shares.rgb.iter().enumerate() {
                let parts = parts(channel).chain(parts_of_emission(&changed, channel));
                planned.outputs[place] = Some(Output::Sum(Sum {
                    parts: parts.collect(),
                    is_complete,
                }));
            }
            planned.of_emission(channels, &changed, is_complete);
        }
        let (mut kept, mut outputs) = (Vec::new(), Vec::new());
        for (place, output) in planned.outputs.into_iter().enumerate() {
            if let Some(output) = output {
                kept.push(place);
                outputs.push(output);
            }
        }
        Self {
            kept,
            outputs,
            left_out: planned.left_out,
            notes: planned.notes,
        }
    }
}

/// What lights that are seen send themselves, where it is known light by light.
fn parts_of_emission<'c>(
    changed: &'c [(&Share, Option<&Change>)],
    channel: usize,
) -> impl Iterator<Item = Part> + 'c {
    changed.iter().filter_map(move |&(share, change)| {
        let emission = share.emission?;
        Some(Part {
            old: emission[channel],
            new: match change {
                Some(change) => change.terms_of_emission(share, emission, channel),
                None => vec![(emission[channel], 1.0)],
            },
        })
    })
}

/// A plan under way.
struct Planned {
    /// Of each channel; `None` where it goes.
    outputs: Vec<Option<Output>>,
    left_out: Vec<&'static str>,
    notes: Vec<String>,
}

impl Planned {
    fn set(&mut self, place: usize, terms: Terms) {
        self.outputs[place] = Some(Output::Linear(terms));
    }

    fn leave_out(&mut self, places: impl IntoIterator<Item = usize>) {
        for place in places {
            self.outputs[place] = None;
        }
    }

    /// The layers of the shares that change.
    fn of_shares(&mut self, channels: &ChannelMap<'_>, changed: &[(&Share, Option<&Change>)]) {
        for &(share, change) in changed {
            let (Some(change), Some(layer)) = (change, share.layer) else {
                continue;
            };
            for (channel, &place) in layer.iter().enumerate() {
                self.set(place, change.terms(share, layer, channel));
            }
            if let Some(emission) = share.emission {
                for (channel, place) in emission.into_iter().enumerate() {
                    self.set(place, change.terms_of_emission(share, emission, channel));
                }
            }
            if let Some(relight) = &share.relight {
                let flat = relight.flat.iter().chain(&relight.emission);
                for &place in flat.chain(&relight.curves) {
                    self.set(place, vec![(place, change.factor)]);
                }
            }
            let sum = channels.rgb("background").filter(|_| share.is_background);
            for place in sum.into_iter().flatten() {
                self.set(place, vec![(place, change.factor)]);
            }
            let lobes: Vec<[usize; 3]> = share.lobes.into_iter().flatten().collect();
            if change.is_spectral() && !lobes.is_empty() {
                self.leave_out(lobes.concat());
                self.notes.push(format!(
                    "the lobes of `light_{}` are left out: what the file holds of its reflected light is of both \
                     together",
                    shortened(&share.name)
                ));
                continue;
            }
            for lobe in lobes {
                for (channel, place) in lobe.into_iter().enumerate() {
                    self.set(place, vec![(place, change.ratio(channel))]);
                }
            }
        }
    }

    /// The layer `emission`, which is a sum over all lights that are seen.
    fn of_emission(
        &mut self,
        channels: &ChannelMap<'_>,
        changed: &[(&Share, Option<&Change>)],
        is_complete: bool,
    ) {
        let is_seen = |(share, change): &(&Share, Option<&Change>)| {
            share.emission.is_some() && change.is_some()
        };
        let sum = channels
            .rgb("emission")
            .filter(|_| changed.iter().any(is_seen));
        for (channel, place) in sum.into_iter().flatten().enumerate() {
            self.outputs[place] = Some(Output::Sum(Sum {
                parts: parts_of_emission(changed, channel).collect(),
                is_complete,
            }));
        }
    }

    /// The layers `diffuse` and `specular`, which are sums over all lights.
    fn of_lobes(&mut self, channels: &ChannelMap<'_>, changed: &[(&Share, Option<&Change>)]) {
        // Beside these the lobes of a light have what comes by mirrors and glass, which the sums have not.
        let has_paths = PATHS.iter().any(|layer| channels.rgb(layer).is_some());
        for (number, lobe) in LOBES.into_iter().enumerate() {
            let Some(sum) = channels.rgb(lobe) else {
                continue;
            };
            if has_paths {
                self.leave_out(sum);
                self.notes.push(format!(
                    "`{lobe}` is left out: it is of the lights as they were rendered"
                ));
                continue;
            }
            let lights = || changed.iter().filter(|(share, _)| !share.is_background);
            let is_kept = |change: &Change| !change.is_spectral();
            let has = |share: &Share| share.lobes[number].is_some();
            let is_known = lights()
                .all(|(share, change)| change.is_none_or(|change| has(share) && is_kept(change)));
            if !is_known {
                self.leave_out(sum);
                self.notes.push(format!(
                    "`{lobe}` is left out: the new file does not have this lobe of each light that changes"
                ));
                continue;
            }
            for (channel, place) in sum.into_iter().enumerate() {
                let parts = lights().filter_map(|(share, change)| {
                    let old = share.lobes[number]?[channel];
                    let ratio = change.map_or(1.0, |change| change.ratio(channel));
                    Some(Part {
                        old,
                        new: vec![(old, ratio)],
                    })
                });
                self.outputs[place] = Some(Output::Sum(Sum {
                    parts: parts.collect(),
                    is_complete: lights().all(|(share, _)| has(share)),
                }));
            }
        }
    }

    /// What else is of the light, and cannot follow it.
    fn of_light(&mut self, stored: &StoredExr) {
        let mut unknown: BTreeSet<&str> = BTreeSet::new();
        for (place, name) in stored.names().iter().enumerate() {
            let layer = name
                .rsplit_once('.')
                .map_or(name.as_str(), |(layer, _)| layer);
            let is_of_light =
                layer == "irradiance" || layer.starts_with("irradiance_") || PATHS.contains(&layer);
            let note = if is_of_light {
                format!(
                    "`{}` is left out: it is of the lights as they were rendered",
                    shortened(layer)
                )
            } else if matches!(layer, "error" | "error_kind") {
                "`error` is left out: it is of the picture as it was rendered".to_owned()
            } else if layer == "S0" {
                self.left_out = OF_BANDS.to_vec();
                "the bands `S0` are left out: they are of the lights as they were rendered"
                    .to_owned()
            } else {
                let is_known = UNLIT.contains(&layer)
                    || KNOWN.iter().any(|start| layer.starts_with(start))
                    || layer == "background"
                    || LOBES.contains(&layer);
                if !is_known {
                    unknown.insert(layer);
                }
                continue;
            };
            self.outputs[place] = None;
            if !self.notes.contains(&note) {
                self.notes.push(note);
            }
        }
        if let Some(first) = unknown.first() {
            let more = match unknown.len() - 1 {
                0 => String::new(),
                1 => " and 1 more layer".to_owned(),
                more => format!(" and {more} more layers"),
            };
            self.notes.push(format!(
                "`{}`{more}, of which candela does not know whether light is in it, stays as it was",
                shortened(first)
            ));
        }
    }
}
