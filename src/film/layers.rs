//! What an image has beside R, G, B and A: the layers that can be asked for, and their channels.

use crate::world::Wavelengths;

/// The layers that a render makes beside R, G, B and A. Default: none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layers {
    /// Radiance band by band, at these wavelengths. Only where light is carried spectrally.
    pub spectral: Option<Wavelengths>,
}

/// The channels of a film beside R, G, B and A, and what the EXR header says about them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Channels {
    /// In the order in which a pixel has them.
    pub list: Vec<Channel>,
    /// Text attributes, as name and value.
    pub attributes: Vec<(String, String)>,
}

/// A channel beside R, G, B and A.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Its name in the EXR: `layer.C`, where the last dot parts the layer from the channel.
    pub name: String,
    /// How it may be stored.
    pub kind: ChannelKind,
}

/// What a channel holds, which decides how it may be stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ChannelKind {
    /// Light, or a share of it: in the precision that is asked for, as R, G and B.
    Light,
    /// Anything whose digits all count, such as a distance: always FLOAT.
    Data,
}

impl Layers {
    /// The names of the layers, in the order of the documentation.
    pub fn names(self) -> Vec<&'static str> {
        self.spectral.iter().map(|_| "spectral").collect()
    }

    /// The channels that these layers are made of.
    pub fn channels(self) -> Channels {
        self.spectral.map(spectral).unwrap_or_default()
    }
}

/// Bands in the layout of Fichet, Pacanowski & Wilkie 2021, "An OpenEXR Layout for Spectral
/// Images" (JCGT 10/3): emissive, unpolarized (`S0`), the wavelength with a decimal comma, because a
/// dot would part layer from channel.
///
/// The layout knows only "W.m^-2.sr^-1" as the unit of emission. Here it is so per nm, which
/// `candela:bands` says.
fn spectral(wavelengths: Wavelengths) -> Channels {
    let list = wavelengths.iter().map(|nm| Channel {
        name: format!("S0.{nm},000000nm"),
        kind: ChannelKind::Light,
    });
    let bands = serde_json::json!({
        "first": wavelengths.first(),
        "last": wavelengths.last(),
        "step": wavelengths.step(),
        "unit": "W.m^-2.sr^-1.nm^-1",
        "weights": "hat",
    });
    let attributes = [
        ("candela:bands", bands.to_string()),
        ("emissiveUnits", "W.m^-2.sr^-1".to_owned()),
        ("spectralLayoutVersion", "1.0".to_owned()),
    ];
    Channels {
        list: list.collect(),
        attributes: attributes
            .map(|(name, value)| (name.to_owned(), value))
            .to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_asked_for_is_nothing() {
        assert_eq!(Layers::default().channels(), Channels::default());
        assert!(Layers::default().names().is_empty());
    }

    #[test]
    fn bands_are_named_as_the_layout_has_it() {
        let layers = Layers {
            spectral: Wavelengths::new(550, 650, 50),
        };
        let channels = layers.channels();
        let names: Vec<&str> = channels.list.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(
            names,
            ["S0.550,000000nm", "S0.600,000000nm", "S0.650,000000nm"]
        );
        assert_eq!(
            channels.attributes[0].1,
            r#"{"first":550,"last":650,"step":50,"unit":"W.m^-2.sr^-1.nm^-1","weights":"hat"}"#
        );
    }
}
