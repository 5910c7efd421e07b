//! The layers of a file that are shares of its picture: of lights, of groups of lights, of the background.

use std::collections::{HashMap, HashSet};

use super::error::RelightError;
use super::record::{self, LightRecord};
use crate::exr::{SampleKind, StoredExr};

/// What the background is called among the lights.
const BACKGROUND: &str = "background";

/// The lobes that a light may have layers of.
pub(super) const LOBES: [&str; 2] = ["diffuse", "specular"];

/// The channels of a file by their names.
pub(super) struct ChannelMap<'s> {
    stored: &'s StoredExr,
    places: HashMap<&'s str, usize>,
}

impl<'s> ChannelMap<'s> {
    pub(super) fn new(stored: &'s StoredExr) -> Self {
        let places = stored.names().iter().enumerate();
        Self {
            stored,
            places: places.map(|(place, name)| (name.as_str(), place)).collect(),
        }
    }

    /// A channel that holds HALF or FLOAT.
    pub(super) fn number(&self, name: &str) -> Option<usize> {
        let place = *self.places.get(name)?;
        match self.stored.kind(place) {
            SampleKind::Half | SampleKind::Float => Some(place),
            SampleKind::Uint => None,
        }
    }

    /// R, G and B of a layer; of what is outside of layers where its name is empty.
    pub(super) fn rgb(&self, layer: &str) -> Option<[usize; 3]> {
        let dot = if layer.is_empty() { "" } else { "." };
        let [r, g, b] = ["R", "G", "B"].map(|c| self.number(&format!("{layer}{dot}{c}")));
        Some([r?, g?, b?])
    }

    /// The channels of `relight_NAME`.
    fn relight(&self, name: &str) -> Option<Relight> {
        let emission = self.number(&format!("relight_{name}.emission"));
        let flat = self.number(&format!("relight_{name}.flat"));
        let curves = (1..).map_while(|curve| self.number(&format!("relight_{name}.{curve}")));
        let curves: Vec<usize> = curves.collect();
        let is_any = flat.is_some() || !curves.is_empty() || emission.is_some();
        is_any.then_some(Relight {
            flat,
            curves,
            emission,
        })
    }
}

/// A part of the picture that can be changed by itself.
#[derive(Clone, Debug)]
pub(super) struct Share {
    pub(super) name: String,
    pub(super) is_background: bool,
    /// The lights that it is of, by their places in the record.
    pub(super) lights: Vec<usize>,
    /// Its layer, if the file has it.
    pub(super) layer: Option<[usize; 3]>,
    /// The layers of its lobes, as [`LOBES`].
    pub(super) lobes: [Option<[usize; 3]>; 2],
    /// The layer of what its lights send themselves, where they are seen.
    pub(super) emission: Option<[usize; 3]>,
    pub(super) relight: Option<Relight>,
}

impl Share {
    fn of_light(name: &str, channels: &ChannelMap<'_>) -> Self {
        Self {
            name: name.to_owned(),
            is_background: false,
            lights: Vec::new(),
            layer: channels.rgb(&format!("light_{name}")),
            lobes: LOBES.map(|lobe| channels.rgb(&format!("light_{name}_{lobe}"))),
            emission: channels.rgb(&format!("emission_{name}")),
            relight: channels.relight(name),
        }
    }
}

/// What was reflected of light that has 1 cd of whatever spectrum, in cd/m²: by reflectances that are the same at
/// every wavelength, and by each of the curves.
#[derive(Clone, Debug)]
pub(super) struct Relight {
    pub(super) flat: Option<usize>,
    /// From the curve 1 on.
    pub(super) curves: Vec<usize>,
    /// What is seen of the lights themselves.
    pub(super) emission: Option<usize>,
}

/// All shares of a file.
#[derive(Debug)]
pub(super) struct Shares {
    pub(super) list: Vec<Share>,
    /// R, G and B.
    pub(super) rgb: [usize; 3],
    /// What the file says of its lights; `None` where it says nothing.
    pub(super) record: Option<Vec<LightRecord>>,
    /// Whether lights are seen in the picture, whose own light is apart from the shares.
    pub(super) has_emission: bool,
}

impl Shares {
    /// A light of a share that is seen in the picture without a layer of what it sends itself. Where the file does not say
    /// whether it is, one with an area may be, if there is a layer `emission`.
    pub(super) fn seen_of(&self, share: &Share) -> Option<String> {
        let record = self.record.as_ref().filter(|_| share.emission.is_none())?;
        let mut lights = share.lights.iter().filter_map(|&light| record.get(light));
        let is_area = |kind: &str| matches!(kind, "rectangle" | "disk" | "sphere");
        let seen = lights.find(|light| {
            let may_be = self.has_emission && is_area(&light.kind);
            light.visible.unwrap_or(may_be)
        });
        seen.map(|light| light.name.clone())
    }

    /// Finds them.
    pub(super) fn find(
        stored: &StoredExr,
        channels: &ChannelMap<'_>,
    ) -> Result<Self, RelightError> {
        let record = record::lights(stored)?;
        let mut list: Vec<Share> = Vec::new();
        match &record {
            Some(lights) => {
                let mut places: HashMap<&str, usize> = HashMap::new();
                for (number, light) in lights.iter().enumerate() {
                    let place = *places.entry(light.share()).or_insert_with(|| {
                        list.push(Share::of_light(light.share(), channels));
                        list.len() - 1
                    });
                    list[place].lights.push(number);
                }
            }
            None => list.extend(named_so(stored).map(|name| Share {
                is_background: name == BACKGROUND,
                ..Share::of_light(name, channels)
            })),
        }
        if !list.iter().any(|share| share.name == BACKGROUND) {
            let of_lights = channels.rgb(&format!("light_{BACKGROUND}"));
            let layer = of_lights.or_else(|| channels.rgb(BACKGROUND));
            list.extend(layer.map(|layer| Share {
                is_background: true,
                layer: Some(layer),
                ..Share::of_light(BACKGROUND, channels)
            }));
        }
        // A light may have the name of another's lobe.
        let names: HashSet<String> = list.iter().map(|share| share.name.clone()).collect();
        for share in &mut list {
            for (lobe, layer) in LOBES.iter().zip(&mut share.lobes) {
                *layer = layer.filter(|_| !names.contains(&format!("{}_{lobe}", share.name)));
            }
        }
        if list.iter().all(|share| share.layer.is_none()) {
            return Err(RelightError::NoLayers);
        }
        Ok(Self {
            list,
            rgb: channels.rgb("").ok_or(RelightError::NoRgb)?,
            record,
            has_emission: channels.rgb("emission").is_some(),
        })
    }

    /// Whether every light has its layer.
    pub(super) fn are_complete(&self) -> bool {
        self.list.iter().all(|share| share.layer.is_some())
    }

    /// The place of the share of this name.
    pub(super) fn place(&self, name: &str) -> Result<usize, RelightError> {
        let is_named = |share: &Share| share.name == name;
        if let Some(place) = self.list.iter().position(is_named) {
            return match self.list[place].layer {
                Some(_) => Ok(place),
                None => Err(RelightError::NoLayer(name.to_owned())),
            };
        }
        let mut lights = self.record.iter().flatten();
        if let Some(light) = lights.find(|light| light.name == name) {
            return Err(RelightError::InGroup {
                light: name.to_owned(),
                group: light.share().to_owned(),
            });
        }
        let there = self.list.iter().filter(|share| share.layer.is_some());
        let names: Vec<String> = there.map(|share| share.name.clone()).collect();
        let nearest = crate::scene::diagnostic::nearest(name, names.iter().map(String::as_str));
        Err(RelightError::UnknownLight {
            name: name.to_owned(),
            nearest: nearest.map(str::to_owned),
            names,
        })
    }
}

/// The names of all layers light_NAME, in the order of the file.
fn named_so(stored: &StoredExr) -> impl Iterator<Item = &str> {
    let names = stored.names().iter();
    names.filter_map(|name| {
        let (layer, channel) = name.rsplit_once('.')?;
        let layer = layer.strip_prefix("light_")?;
        (channel == "R").then_some(layer)
    })
}
