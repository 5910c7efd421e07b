//! Which channels of a file are shown: those without a layer's name, or those of a layer that the user
//! names.
//!
//! A channel's name is `layer.channel`, parted at the last dot, and layers may be within layers
//! (`ViewLayer.Combined.R`). A part of a file is a layer, too, by its name.

use std::collections::{BTreeMap, BTreeSet};

use super::ExrProblem;
use super::header::{Channel, Headers, Part};
use crate::printable::printable;

/// What is shown of a part: places in its list of channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Shown {
    pub(super) part: usize,
    pub(super) channels: Shape,
    pub(super) alpha: Option<usize>,
}

/// A layer that can be shown.
#[derive(Clone, Debug)]
pub(super) struct Layer {
    /// Empty for what a file of one part has outside of layers.
    pub(super) name: String,
    pub(super) shown: Shown,
}

/// What channels show together, and their alpha.
type Together = (Shape, Option<usize>);

/// How channels make a color.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    /// R, G and B.
    Rgb([usize; 3]),
    /// X, Y and Z of a vector, shown as R, G and B: no color.
    Vector([usize; 3]),
    /// Luminance alone: a gray.
    Gray(usize),
    /// Another channel by itself, shown as a gray: no color.
    Single(usize),
    /// Luminance, and chroma that may have fewer samples: Y, RY, BY.
    LumaChroma([usize; 3]),
}

impl Shape {
    /// Whether it is light.
    pub(super) const fn is_light(self) -> bool {
        match self {
            Self::Rgb(_) | Self::Gray(_) | Self::LumaChroma(_) => true,
            Self::Vector(_) | Self::Single(_) => false,
        }
    }

    /// Whether its color space counts. Luminance alone is the same gray in all.
    pub(super) const fn is_color(self) -> bool {
        match self {
            Self::Rgb(_) | Self::LumaChroma(_) => true,
            Self::Gray(_) | Self::Vector(_) | Self::Single(_) => false,
        }
    }

    /// The channels in the order of R, G, B, or Y, RY, BY.
    pub(super) fn list(&self) -> &[usize] {
        match self {
            Self::Rgb(list) | Self::Vector(list) | Self::LumaChroma(list) => list,
            Self::Gray(channel) | Self::Single(channel) => std::slice::from_ref(channel),
        }
    }
}

/// A channel's name without its layer, and the layer.
fn split(name: &[u8]) -> (&[u8], &[u8]) {
    match name.iter().rposition(|&byte| byte == b'.') {
        Some(dot) => (&name[..dot], &name[dot + 1..]),
        None => (&[], name),
    }
}

/// The channels of each layer of a part, by their places; the empty layer is the part's own.
fn layers(part: &Part) -> BTreeMap<&[u8], Vec<usize>> {
    let mut layers: BTreeMap<&[u8], Vec<usize>> = BTreeMap::new();
    for (place, channel) in part.channels.iter().enumerate() {
        layers
            .entry(split(&channel.name).0)
            .or_default()
            .push(place);
    }
    layers
}

/// What the channels of a layer show together; `None` where there is no such layer, or its channels are no
/// color and no vector.
fn shape(part: &Part, layer: &[u8]) -> Option<Together> {
    let is_in = |channel: &Channel| split(&channel.name).0 == layer;
    let channels = part.channels.iter().enumerate();
    let places: Vec<usize> = channels
        .filter_map(|(place, channel)| is_in(channel).then_some(place))
        .collect();
    shape_of(part, layer, &places)
}

/// What these channels, all that a layer has, show together.
fn shape_of(part: &Part, layer: &[u8], places: &[usize]) -> Option<Together> {
    let find = |wanted: &str| {
        let mut places = places.iter().copied();
        places.find(|&place| {
            let channel = split(&part.channels[place].name).1;
            channel.eq_ignore_ascii_case(wanted.as_bytes())
        })
    };
    let all = |names: [&str; 3]| {
        let [a, b, c] = names.map(find);
        Some([a?, b?, c?])
    };
    let alpha = find("A").or_else(|| find("alpha"));
    // Some programs write the words.
    if let Some(rgb) = all(["R", "G", "B"]).or_else(|| all(["red", "green", "blue"])) {
        return Some((Shape::Rgb(rgb), alpha));
    }
    if let Some(yca) = all(["Y", "RY", "BY"]) {
        return Some((Shape::LumaChroma(yca), alpha));
    }
    // A depth beside luminance, both without a layer, is no vector.
    if let Some(xyz) = all(["X", "Y", "Z"]).filter(|_| !layer.is_empty()) {
        return Some((Shape::Vector(xyz), None));
    }
    find("Y").map(|y| (Shape::Gray(y), alpha))
}

/// What is shown where the user names nothing: the first part with R, G, B, or else with luminance.
pub(super) fn unnamed(headers: &Headers) -> Result<Shown, ExrProblem> {
    let found = |is_wanted: fn(Shape) -> bool| {
        let parts = headers.parts.iter().enumerate();
        let mut shown = parts.filter_map(|(part, header)| {
            let (channels, alpha) = shape(header, b"")?;
            is_wanted(channels).then_some(Shown {
                part,
                channels,
                alpha,
            })
        });
        shown.next()
    };
    found(|shape| matches!(shape, Shape::Rgb(_)))
        .or_else(|| found(Shape::is_light))
        .ok_or_else(|| ExrProblem::NoRgb(names(headers)))
}

/// What is shown of the layer or channel with this name.
pub(super) fn named(headers: &Headers, wanted: &str) -> Result<Shown, ExrProblem> {
    // Colors go before single channels, and names without a part's before those with one.
    let searches: [fn(&Part, &str) -> Option<Together>; 4] = [
        |part, wanted| (!wanted.is_empty()).then(|| shape(part, wanted.as_bytes()))?,
        |part, wanted| channel(part, wanted.as_bytes()),
        |part, wanted| {
            let rest = wanted.as_bytes().strip_prefix(part.name.as_slice())?;
            match rest {
                b"" => shape(part, b"").or_else(|| only(part)),
                rest => shape(part, rest.strip_prefix(b".")?),
            }
        },
        |part, wanted| {
            let rest = wanted.as_bytes().strip_prefix(part.name.as_slice())?;
            channel(part, rest.strip_prefix(b".")?)
        },
    ];
    for search in searches {
        let mut parts = headers.parts.iter().enumerate();
        let found = parts.find_map(|(part, header)| Some((part, search(header, wanted)?)));
        if let Some((part, (channels, alpha))) = found {
            return Ok(Shown {
                part,
                channels,
                alpha,
            });
        }
    }
    Err(ExrProblem::NoLayer {
        wanted: wanted.to_owned(),
        names: names(headers),
    })
}

/// The coverage of a part's own color, outside of layers: that of its layers as well, where they have none.
pub(super) fn coverage(part: &Part) -> Option<usize> {
    let mut channels = part.channels.iter();
    channels.position(|channel| {
        let name = channel.name.as_slice();
        name.eq_ignore_ascii_case(b"A") || name.eq_ignore_ascii_case(b"alpha")
    })
}

/// A channel by its whole name.
fn channel(part: &Part, wanted: &[u8]) -> Option<Together> {
    let mut names = part.channels.iter().map(|channel| channel.name.as_slice());
    let place = names.position(|name| name == wanted)?;
    Some((Shape::Single(place), None))
}

/// What a part shows that has one layer, or one channel, alone.
fn only(part: &Part) -> Option<Together> {
    let layers = layers(part);
    let (layer, places) = layers.first_key_value().filter(|_| layers.len() == 1)?;
    shape_of(part, layer, places)
        .or_else(|| (places.len() == 1).then_some((Shape::Single(0), None)))
}

/// What can be named, for messages.
fn names(headers: &Headers) -> Vec<String> {
    let names = list(headers).into_iter().map(|layer| layer.name);
    names
        .filter(|name| !name.is_empty())
        .map(|name| printable(&name))
        .collect()
}

/// What can be shown: layers that show together, then channels that belong to none.
pub(super) fn list(headers: &Headers) -> Vec<Layer> {
    let (mut together, mut single) = (Vec::new(), Vec::new());
    let mut seen = BTreeSet::new();
    for (number, part) in headers.parts.iter().enumerate() {
        let mut shown = layers(part);
        shown.retain(|layer, places| shape_of(part, layer, places).is_some());
        let mut add = |list: &mut Vec<Layer>, name: &[u8], (channels, alpha): Together| {
            let mut name = String::from_utf8_lossy(name).into_owned();
            if !seen.insert(name.clone()) && !part.name.is_empty() {
                name = format!("{}.{name}", String::from_utf8_lossy(&part.name));
                seen.insert(name.clone());
            }
            let shown = Shown {
                part: number,
                channels,
                alpha,
            };
            list.push(Layer { name, shown });
        };
        for (layer, places) in &shown {
            let Some(shape) = shape_of(part, layer, places) else {
                continue;
            };
            match layer {
                [] => add(&mut together, &part.name, shape),
                layer => add(&mut together, layer, shape),
            }
        }
        for (place, channel) in part.channels.iter().enumerate() {
            let layer = split(&channel.name).0;
            if !shown.contains_key(layer) || layer.is_empty() && !is_of_color(&channel.name) {
                let shape = (Shape::Single(place), None);
                add(&mut single, &channel.name, shape);
            }
        }
    }
    together.append(&mut single);
    together
}

/// Whether a channel without a layer belongs to the part's color.
fn is_of_color(name: &[u8]) -> bool {
    let names = [
        "R", "G", "B", "A", "red", "green", "blue", "alpha", "Y", "RY", "BY",
    ];
    names
        .iter()
        .any(|color| name.eq_ignore_ascii_case(color.as_bytes()))
}
