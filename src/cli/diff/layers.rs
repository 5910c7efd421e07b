//! Channels as layers, and which of them two files have in common.

use std::collections::BTreeMap;

use candela::Primaries;
use candela::exr::{ChannelName, DataWindow, ExrChannels};
use candela::internal::printable;

use crate::cli::Failure;

/// What the layer of the channels outside of layers is called.
const ROOT: &str = "RGB";

/// The channels that belong together without a layer's name.
const OF_ROOT: [&str; 6] = ["R", "G", "B", "Y", "RY", "BY"];

/// Channels that are no color and no component: what is relative leaves them out.
const ALPHA: &str = "A";

/// The order of channels in a layer; others follow by name.
const ORDER: [&str; 11] = ["R", "G", "B", "X", "Y", "Z", "RY", "BY", "U", "V", "A"];

/// At most so many names are listed in a message.
const LISTED: usize = 10;

/// What is compared.
pub(super) struct Common {
    pub(super) layers: Vec<Layer>,
    /// Layers and channels that only one file has, where the user has chosen others: a sentence each.
    pub(super) left_out: Vec<String>,
}

/// A layer of both files.
pub(super) struct Layer {
    pub(super) name: String,
    /// Of the reference and of the image: the same names, in one order.
    channels: [Vec<ChannelName>; 2],
    pub(super) window: DataWindow,
    /// The primaries of R, G, B, which are the first three channels, where it has them.
    pub(super) color: Option<Primaries>,
}

impl Layer {
    pub(super) fn channels(&self, side: usize) -> impl Iterator<Item = &ChannelName> {
        self.channels[side].iter()
    }

    /// The whole names of its channels in the reference.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.channels[0].iter().map(|channel| channel.name.as_str())
    }

    /// A channel's name without the layer.
    pub(super) fn short_name(&self, channel: usize) -> &str {
        split(&self.channels[0][channel].name).1
    }

    pub(super) fn count(&self) -> usize {
        self.channels[0].len()
    }

    pub(super) fn has_color(&self) -> bool {
        self.color.is_some()
    }

    /// How many of its channels, the first ones, count for what is relative.
    pub(super) fn relative(&self) -> usize {
        let is_alpha = |channel: &ChannelName| split(&channel.name).1.eq_ignore_ascii_case(ALPHA);
        match self.channels[0].last() {
            Some(last) if is_alpha(last) && self.count() > 1 => self.count() - 1,
            Some(_) | None => self.count(),
        }
    }
}

/// The layer and the channel of a name.
fn split(name: &str) -> (&str, &str) {
    name.rsplit_once('.').unwrap_or(("", name))
}

/// A file's layers by name.
type Layers = BTreeMap<String, Vec<ChannelName>>;

fn layers(file: &ExrChannels) -> Layers {
    let is_of_root = |name: &str| {
        OF_ROOT
            .iter()
            .chain(&[ALPHA])
            .any(|known| name.eq_ignore_ascii_case(known))
    };
    let mut layers = Layers::new();
    for channel in file.names() {
        let name = match split(&channel.name) {
            ("", name) if is_of_root(name) => ROOT,
            ("", name) => name,
            (layer, _) => layer,
        };
        layers
            .entry(name.to_owned())
            .or_default()
            .push(channel.clone());
    }
    let place = |channel: &ChannelName| {
        let name = split(&channel.name).1;
        let known = ORDER
            .iter()
            .position(|known| name.eq_ignore_ascii_case(known));
        (
            known.unwrap_or(ORDER.len() - 1) + usize::from(name.eq_ignore_ascii_case(ALPHA)),
            channel.name.clone(),
        )
    };
    for channels in layers.values_mut() {
        channels.sort_by_cached_key(place);
    }
    layers
}

/// The layers that are compared: those that the user names, or all, which both must have then.
pub(super) fn common(
    files: [&ExrChannels; 2],
    names: &[String; 2],
    wanted: &[String],
) -> Result<Common, Failure> {
    let mut sides = files.map(layers);
    let mut left_out = Vec::new();
    if wanted.is_empty() {
        refuse_lonely_layers(&sides, names)?;
    } else {
        for (side, name) in sides.iter().zip(names) {
            for wanted in wanted {
                if !side.keys().any(|layer| is_named(layer, wanted)) {
                    let there: Vec<&str> = side.keys().map(String::as_str).collect();
                    let message = format!(
                        "{name} has no layer `{}`; it has {}",
                        printable(wanted),
                        listed(&there)
                    );
                    return Err(message.into());
                }
            }
        }
        for side in &mut sides {
            side.retain(|layer, _| wanted.iter().any(|wanted| is_named(layer, wanted)));
        }
    }
    let [reference, mut image] = sides;
    let mut layers = Vec::new();
    for (name, channels) in reference {
        let Some(others) = image.remove(&name) else {
            continue;
        };
        let (channels, others) = paired(
            &name,
            [channels, others],
            names,
            !wanted.is_empty(),
            &mut left_out,
        )?;
        layers.push(layer(files, names, name, [channels, others])?);
    }
    if layers.is_empty() {
        return Err("there is no layer to compare".into());
    }
    // What is seen goes first.
    layers.sort_by_key(|layer| layer.name != ROOT);
    Ok(Common { layers, left_out })
}

fn is_named(layer: &str, wanted: &str) -> bool {
    layer == wanted
        || layer == ROOT
            && ["rgb", "rgba"]
                .iter()
                .any(|root| wanted.eq_ignore_ascii_case(root))
}

/// An error where only one file has a layer.
fn refuse_lonely_layers(sides: &[Layers; 2], names: &[String; 2]) -> Result<(), Failure> {
    for (side, other) in [(0, 1), (1, 0)] {
        let lonely: Vec<&str> = sides[side]
            .keys()
            .filter(|layer| !sides[other].contains_key(*layer))
            .map(String::as_str)
            .collect();
        if !lonely.is_empty() {
            let both: Vec<&str> = sides[0]
                .keys()
                .filter(|layer| sides[1].contains_key(*layer))
                .map(String::as_str)
                .collect();
            let way_out = if both.is_empty() {
                "they have no layer in common".to_owned()
            } else {
                format!(
                    "choose among what both have with --layers {}",
                    listed(&both).replace(", ", ",")
                )
            };
            return Err(format!(
                "only {} has the layers {}; {way_out}",
                names[side],
                listed(&lonely),
            )
            .into());
        }
    }
    Ok(())
}

/// The channels that both have of a layer, in one order.
fn paired(
    layer: &str,
    [reference, image]: [Vec<ChannelName>; 2],
    names: &[String; 2],
    is_chosen: bool,
    left_out: &mut Vec<String>,
) -> Result<(Vec<ChannelName>, Vec<ChannelName>), Failure> {
    let has = |list: &[ChannelName], wanted: &ChannelName| {
        list.iter().any(|channel| channel.name == wanted.name)
    };
    for (list, other, name) in [
        (&reference, &image, &names[0]),
        (&image, &reference, &names[1]),
    ] {
        if let Some(lonely) = list.iter().find(|channel| !has(other, channel)) {
            let message = format!("only {name} has the channel `{}`", printable(&lonely.name));
            if !is_chosen {
                return Err(format!(
                    "{message}; compare what both have with --layers {}",
                    printable(layer)
                )
                .into());
            }
            left_out.push(message);
        }
    }
    let keep = |list: &[ChannelName], other: &[ChannelName]| -> Vec<ChannelName> {
        list.iter()
            .filter(|channel| has(other, channel))
            .cloned()
            .collect()
    };
    let both = (keep(&reference, &image), keep(&image, &reference));
    if both.0.is_empty() {
        return Err(format!(
            "layer {} has other channels in both files",
            printable(layer)
        )
        .into());
    }
    Ok(both)
}

/// A layer of both, if they are of one size and in one color space.
fn layer(
    files: [&ExrChannels; 2],
    names: &[String; 2],
    name: String,
    channels: [Vec<ChannelName>; 2],
) -> Result<Layer, Failure> {
    let [window, other] = [0, 1].map(|side| files[side].window(&channels[side][0]));
    if window != other {
        return Err(format!(
            "{} and {} are of different sizes: {} and {}",
            names[0],
            names[1],
            size(window),
            size(other)
        )
        .into());
    }
    let is = |place: usize, wanted: &str| {
        let channel = channels[0].get(place);
        channel.is_some_and(|channel| split(&channel.name).1.eq_ignore_ascii_case(wanted))
    };
    let has_color = is(0, "R") && is(1, "G") && is(2, "B");
    let mut color = None;
    if has_color {
        let [meaning, other] = [0, 1].map(|side| files[side].color(&channels[side][0]).meaning());
        if !meaning.is_same(&other) {
            return Err(format!(
                "the colors of {} and {} are of different spaces; convert one of them first, as by \
                 `oiiotool in.exr --colorconvert FROM TO -o out.exr`",
                names[0], names[1]
            )
            .into());
        }
        color = Some(meaning.primaries);
    }
    Ok(Layer {
        name,
        channels,
        window,
        color,
    })
}

/// What a message says of a window.
fn size(window: DataWindow) -> String {
    let [width, height] = window.size;
    let [x, y] = window.corner;
    if window.size == window.resolution && window.corner == [0, 0] {
        return format!("{width} × {height} pixels");
    }
    let [whole_width, whole_height] = window.resolution;
    format!("{width} × {height} pixels at {x},{y} of {whole_width} × {whole_height}")
}

fn listed(names: &[&str]) -> String {
    let shown = names.iter().take(LISTED).map(|name| printable(name));
    let mut list = shown.collect::<Vec<_>>().join(", ");
    if names.len() > LISTED {
        list += &format!(" and {} more", names.len() - LISTED);
    }
    list
}
