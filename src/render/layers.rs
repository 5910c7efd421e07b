//! The layers that can be asked for beside R, G, B and A, and their channels.

use crate::image::{Channel, ChannelKind, Channels};
use crate::world::{Wavelengths, World};

/// What the background is called among the lights.
pub const BACKGROUND_LIGHT: &str = "background";

/// The layers that a render makes beside R, G, B and A. Default: none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layers {
    /// Each light's share of L9 in cd/m², `light_NAME.R`, `.G`, `.B`, through the box filter as R, G
    /// and B are: what the film would be with this light alone and a black background. A background
    /// that is not black has a share of its own, `light_background`. Together they are R, G and B.
    pub lights: bool,
    /// `Z`: the distance from the eye along the view axis in scene units, of the nearest sample of
    /// the pixel; [`BACKGROUND_DEPTH`](crate::image::BACKGROUND_DEPTH) where there is none. With an orthographic camera it is the
    /// distance from the plane through the eye.
    pub depth: bool,
    /// `N.X`, `N.Y`, `N.Z`: n of L5 to L7 in world space, turned towards the viewer, through the box
    /// filter with 0 where nothing is hit: of unit length where all samples have one normal.
    pub normal: bool,
    /// Radiance band by band, at these wavelengths. Only where light is carried spectrally.
    pub spectral: Option<Wavelengths>,
    /// `error`, in cd/m²: how far the largest of R, G and B is off at most, and `error_kind`: 0 where that is a bound, 1
    /// where it is an estimate. Only where pixels are rendered to an error.
    pub error: bool,
    /// `samples`: how many samples were taken of the pixel, 0 where its edges were integrated.
    pub samples: bool,
}

impl Layers {
    /// The names of the layers, in the order of the documentation.
    pub fn names(self) -> Vec<&'static str> {
        let Self {
            lights,
            depth,
            normal,
            spectral,
            error,
            samples,
        } = self;
        let asked = [
            (lights, "lights"),
            (depth, "depth"),
            (normal, "normal"),
            (spectral.is_some(), "spectral"),
            (error, "error"),
            (samples, "samples"),
        ];
        let asked = asked
            .into_iter()
            .filter_map(|(is_asked, name)| is_asked.then_some(name));
        asked.collect()
    }

    /// The channels that these layers of a world are made of, in the order of [`Layers::names`].
    ///
    /// Where the background has a share and a light has its name, two channels have one name,
    /// which no EXR can hold.
    pub fn channels(self, world: &World) -> Channels {
        let Self {
            lights,
            depth,
            normal,
            spectral,
            error,
            samples,
        } = self;
        let channel = |name: String, kind| Channel { name, kind };
        let mut channels = spectral.map(self::spectral).unwrap_or_default();
        let shares = if lights {
            shares(world).collect()
        } else {
            Vec::new()
        };
        let shares = shares.into_iter().flat_map(|name| {
            ["R", "G", "B"].map(|c| channel(format!("light_{name}.{c}"), ChannelKind::Light))
        });
        let depth = depth.then(|| channel("Z".to_owned(), ChannelKind::Data));
        let normal = normal.then_some(["X", "Y", "Z"]).into_iter().flatten();
        let normal = normal.map(|axis| channel(format!("N.{axis}"), ChannelKind::Direction));
        let first = shares.chain(depth).chain(normal);
        channels.list.splice(0..0, first);
        let error = error.then_some(["error", "error_kind"]);
        let last = error
            .into_iter()
            .flatten()
            .chain(samples.then_some("samples"));
        let last = last.map(|name| channel(name.to_owned(), ChannelKind::Data));
        channels.list.extend(last);
        channels
    }
}

/// The names of what adds to the radiance: the lights in the order of the file, and the background
/// unless it is black.
fn shares(world: &World) -> impl Iterator<Item = &str> {
    let lights = world.lights().iter().map(|light| light.name.as_str());
    lights.chain(has_background_share(world).then_some(BACKGROUND_LIGHT))
}

/// Whether the background adds to the radiance.
pub(super) fn has_background_share(world: &World) -> bool {
    world.background().0.0 != [0.0; 3]
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
    use crate::scene::Scene;

    const SCENE: &str = "
        [image]
        resolution = [2, 2]
        [camera.orthographic]
        eye = [0, 0, 1]
        look_at = [0, 0, 0]
        height = 1
        [materials.m.phong]
        [lights.'key left'.point]
        position = [0, 0, 1]
        intensity = 1
        [lights.'lampe_grün'.point]
        position = [0, 0, 1]
        intensity = 1
        [objects.o.sphere]
        material = 'm'
        center = [0, 0, 0]
        radius = 1
    ";

    fn names(layers: Layers, scene: &str) -> Vec<String> {
        let world = World::new(&Scene::parse(scene, "scene.toml").unwrap())
            .unwrap()
            .0;
        let channels = layers.channels(&world);
        channels.list.into_iter().map(|c| c.name).collect()
    }

    const EVERY: Layers = Layers {
        lights: true,
        depth: true,
        normal: true,
        spectral: None,
        error: false,
        samples: false,
    };

    #[test]
    fn nothing_asked_for_is_nothing() {
        let world = World::new(&Scene::builtin()).unwrap().0;
        assert_eq!(Layers::default().channels(&world), Channels::default());
        assert!(Layers::default().names().is_empty());
    }

    #[test]
    fn channels_are_named_after_lights_and_axes() {
        assert_eq!(EVERY.names(), ["lights", "depth", "normal"]);
        let expected = [
            "light_key left.R",
            "light_key left.G",
            "light_key left.B",
            "light_lampe_grün.R",
            "light_lampe_grün.G",
            "light_lampe_grün.B",
            "Z",
            "N.X",
            "N.Y",
            "N.Z",
        ];
        assert_eq!(names(EVERY, SCENE), expected);
        // A background that is not black adds its own.
        let scene = SCENE.replace("[image]", "[image]\nbackground = [0, 0, 0.5]");
        let with_background = names(EVERY, &scene);
        assert_eq!(with_background.len(), expected.len() + 3);
        assert_eq!(with_background[6], "light_background.R");
        assert_eq!(with_background[9], "Z");
        let without_lights = Layers {
            lights: false,
            ..EVERY
        };
        assert_eq!(names(without_lights, &scene), expected[6..]);
    }

    #[test]
    fn bands_are_named_as_the_layout_has_it() {
        let layers = Layers {
            spectral: Wavelengths::new(550, 650, 50),
            depth: true,
            ..Layers::default()
        };
        assert_eq!(layers.names(), ["depth", "spectral"]);
        let expected = ["Z", "S0.550,000000nm", "S0.600,000000nm", "S0.650,000000nm"];
        assert_eq!(names(layers, SCENE), expected);
        let world = World::new(&Scene::builtin()).unwrap().0;
        assert_eq!(
            layers.channels(&world).attributes[0].1,
            r#"{"first":550,"last":650,"step":50,"unit":"W.m^-2.sr^-1.nm^-1","weights":"hat"}"#
        );
    }
}
