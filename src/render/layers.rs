//! The layers that can be asked for beside R, G, B and A, and their channels.

use super::cryptomatte;
use super::shares::{BACKGROUND_LIGHT, Shares, has_background_share};
use crate::image::{Channel, ChannelKind, Channels};
use crate::world::{Delta, Reflectances, Wavelengths, World};

/// The layers that a render makes beside R, G, B and A. Default: none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Layers {
    /// Each light's share of L9 in cd/m², `light_NAME.R`, `.G`, `.B`, through the box filter as R, G
    /// and B are: what the film would be with this light alone and a black background. Lights of a group have one
    /// share, `light_GROUP`. A background that is not black has a share of its own, `light_background`. Together they
    /// are R, G and B.
    pub lights: bool,
    /// The part of each of these shares that diffuse lobes send (L5): `light_NAME_diffuse.R`, …
    pub light_diffuse: bool,
    /// The part that specular lobes send (L7): `light_NAME_specular.R`, …
    pub light_specular: bool,
    /// Of which lights, groups and background the three above and `shadow` are, by their names; `None` is all.
    pub only: Option<Vec<String>>,
    /// What a light of another color needs where light is carried spectrally and no mirror or glass colors it:
    /// `relight_NAME.flat`, `.1`, …, and `.emission` of one that is seen. Beside it, with `lights` and however light is
    /// carried, what each light that is seen sends itself: `emission_NAME.R`, …
    pub relight: Relight,
    /// What the diffuse lobes of all lights send, in cd/m²: `diffuse.R`, …; where the background is not black,
    /// `background.R`, … beside it. With `specular` they are R, G and B.
    pub diffuse: bool,
    /// What the specular lobes of all lights send, in cd/m²: `specular.R`, …
    pub specular: bool,
    /// What lights that are seen send themselves, in cd/m²: `emission.R`, … It comes with `lights`, `diffuse` and
    /// `specular` where any light is seen, so that these add up to R, G and B.
    pub emission: bool,
    /// What comes by mirrors, in cd/m²: `reflection.R`, … It and `refraction` come with `diffuse` and `specular` where
    /// anything is perfectly smooth, so that these add up to R, G and B.
    pub reflection: bool,
    /// What comes through glass, in cd/m²: `refraction.R`, …
    pub refraction: bool,
    /// k_d: `albedo.R`, …, through the box filter with 0 where nothing is hit.
    pub albedo: bool,
    /// `irradiance`: the illuminance E = Σ I (n·ω_i) V / d² of the surface in lux, through the box filter with 0 where
    /// nothing is hit.
    pub irradiance: bool,
    /// `Z`: the distance from the eye along the view axis in scene units, of the nearest sample of
    /// the pixel; [`BACKGROUND_DEPTH`](crate::image::BACKGROUND_DEPTH) where there is none. With an orthographic camera it is the
    /// distance from the plane through the eye.
    pub depth: bool,
    /// `P.X`, `P.Y`, `P.Z`: where that nearest sample is, in world space; 0 where there is none.
    pub position: bool,
    /// `N.X`, `N.Y`, `N.Z`: n of L5 to L7 in world space, turned towards the viewer, through the box
    /// filter with 0 where nothing is hit: of unit length where all samples have one normal.
    pub normal: bool,
    /// `shadow_NAME`: V of each light (L4), 0 to 1, through the box filter with 0 where nothing is hit, and where the
    /// surface is turned away.
    pub shadow: bool,
    /// The names of objects, as mattes: `CryptoObject00.R`, …
    pub object_mattes: bool,
    /// The names of materials, as mattes: `CryptoMaterial00.R`, …
    pub material_mattes: bool,
    /// How many names a pixel may have in a matte.
    pub matte_ranks: MatteRanks,
    /// Radiance band by band, at these wavelengths. Only where light is carried spectrally.
    pub spectral: Option<Wavelengths>,
    /// `error`, in cd/m²: how far the largest of R, G and B is off at most, and `error_kind`: 0 where that is a bound, 1
    /// where it is an estimate. Only where pixels are rendered to an error.
    pub error: bool,
    /// `samples`: how many samples were taken of the pixel, 0 where its edges were integrated.
    pub samples: bool,
}

/// A material that objects have and that colors what is seen by way of it, where light is carried spectrally; but for
/// mirrors of which all chains are known.
pub(super) fn coloring(world: &World) -> Option<&str> {
    let mut used = world.used_materials().into_iter();
    let chains = world
        .chains()
        .filter(|chains| chains.has_all(world.max_depth()));
    let is_known = |material| chains.is_some_and(|chains| chains.color(material).is_some());
    let colors = |material| world.delta(material).is_some_and(Delta::colors);
    let material = used.find(|&material| colors(material) && !is_known(material))?;
    Some(&world.materials()[material].name)
}

/// Whether what lights of other colors need is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Relight {
    /// With the lights' shares, where light is carried spectrally and it takes at most
    /// [`Relight::MOST`] channels.
    #[default]
    Auto,
    /// Where light is carried spectrally.
    Always,
    /// Not.
    Never,
}

impl Relight {
    /// The most channels that come without being asked for.
    pub const MOST: usize = 256;
}

/// How many names a pixel may have in a matte: those that cover most of it. Range: 2 to [`MatteRanks::MOST`], an even
/// number. Default: 6.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MatteRanks(usize);

impl MatteRanks {
    /// Two names in each of a hundred layers, `00` to `99`.
    pub const MOST: usize = 200;

    /// The even number that is not below; `None` out of range.
    pub fn new(count: usize) -> Option<Self> {
        (1..=Self::MOST)
            .contains(&count)
            .then(|| Self(count.next_multiple_of(2)))
    }

    /// How many.
    pub const fn count(self) -> usize {
        self.0
    }
}

impl Default for MatteRanks {
    fn default() -> Self {
        Self(6)
    }
}

/// What channels that follow each other hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Content {
    Lights,
    LightDiffuse,
    LightSpecular,
    Diffuse,
    Specular,
    Background,
    Emission,
    EmissionOfLights,
    Reflection,
    Refraction,
    Albedo,
    Irradiance,
    Normal,
    Shadow,
    Relight,
    Depth,
    Position,
    ObjectMattes,
    MaterialMattes,
    Spectral,
    /// `error` and `error_kind`.
    Error,
    Samples,
}

const RGB: [&str; 3] = ["R", "G", "B"];
const XYZ: [&str; 3] = ["X", "Y", "Z"];

impl Layers {
    /// The names of the layers, in the order of the documentation.
    pub fn names(&self) -> Vec<&'static str> {
        let asked = [
            (self.lights, "lights"),
            (self.light_diffuse, "light-diffuse"),
            (self.light_specular, "light-specular"),
            (self.relight == Relight::Always, "relight"),
            (self.diffuse, "diffuse"),
            (self.specular, "specular"),
            (self.emission, "emission"),
            (self.reflection, "reflection"),
            (self.refraction, "refraction"),
            (self.albedo, "albedo"),
            (self.irradiance, "irradiance"),
            (self.depth, "depth"),
            (self.position, "position"),
            (self.normal, "normal"),
            (self.shadow, "shadow"),
            (self.object_mattes && self.material_mattes, "cryptomatte"),
            (
                self.object_mattes && !self.material_mattes,
                "cryptomatte=object",
            ),
            (
                !self.object_mattes && self.material_mattes,
                "cryptomatte=material",
            ),
            (self.spectral.is_some(), "spectral"),
            (self.error, "error"),
            (self.samples, "samples"),
        ];
        let asked = asked
            .into_iter()
            .filter_map(|(is_asked, name)| is_asked.then_some(name));
        asked.collect()
    }

    /// The channels that these layers of a world are made of.
    ///
    /// Two may have one name, which no EXR can hold: see [`Layers::collision`].
    pub fn channels(&self, world: &World) -> Channels {
        let (mut list, mut places) = (Vec::new(), Vec::new());
        for (content, channels) in self.contents(world) {
            let first = list.len();
            list.extend(channels);
            places.push((content, first..list.len()));
        }
        let layers_of = |wanted: &[Content]| {
            let places = places
                .iter()
                .filter(|(content, _)| wanted.contains(content));
            let layers = places.flat_map(|(_, channels)| channels.clone().step_by(3));
            layers.collect::<Vec<usize>>()
        };
        let mut sums = Vec::new();
        if self.lights && self.only.is_none() {
            sums.push(layers_of(&[Content::Lights, Content::Emission]));
        }
        if self.diffuse && self.specular {
            sums.push(layers_of(&[
                Content::Diffuse,
                Content::Specular,
                Content::Background,
                Content::Emission,
                Content::Reflection,
                Content::Refraction,
            ]));
        }
        let mut attributes = self.spectral.map(spectral_attributes).unwrap_or_default();
        attributes.extend(self.relighting(world).map(|reflectances| {
            let text = reflectances.description(world);
            ("candela:reflectances".to_owned(), text)
        }));
        if self.object_mattes {
            let names = world.objects().iter().map(|object| object.name.as_str());
            attributes.extend(cryptomatte::attributes("CryptoObject", names));
        }
        if self.material_mattes {
            let names = world.materials().iter().map(|entry| entry.name.as_str());
            attributes.extend(cryptomatte::attributes("CryptoMaterial", names));
        }
        Channels {
            list,
            attributes,
            sums,
        }
    }

    /// The channels, content by content: first those that are sums over samples.
    pub(super) fn contents(&self, world: &World) -> Vec<(Content, Vec<Channel>)> {
        let shares = Shares::new(world, self.only.as_deref());
        let channel = |name: String, kind| Channel { name, kind };
        let rgb = |layer: &str| {
            let name = |c| channel(format!("{layer}.{c}"), ChannelKind::Light);
            RGB.map(name).to_vec()
        };
        let of_shares = |suffix: &str| {
            let names = shares.names().iter();
            let names = names.flat_map(|name| rgb(&format!("light_{name}{suffix}")));
            names.collect::<Vec<_>>()
        };
        let data = |names: &[&str]| {
            let names = names.iter();
            let channels = names.map(|&name| channel(name.to_owned(), ChannelKind::Data));
            channels.collect::<Vec<_>>()
        };
        let axes = |layer: &str, kind| {
            let name = |axis| channel(format!("{layer}.{axis}"), kind);
            XYZ.map(name).to_vec()
        };
        let has_background = (self.diffuse || self.specular) && has_background_share(world);
        let is_part = (self.lights && self.only.is_none()) || self.diffuse || self.specular;
        let has_emission = self.emission || (is_part && world.has_emission());
        let has_emission_of_lights =
            self.lights && self.relight != Relight::Never && !shares.seen().is_empty();
        let has_branches = (self.diffuse || self.specular) && world.has_deltas();
        let mut contents = Vec::new();
        let mut add = |is_asked: bool, content, channels: &dyn Fn() -> Vec<Channel>| {
            if is_asked {
                contents.push((content, channels()));
            }
        };
        add(self.lights, Content::Lights, &|| of_shares(""));
        add(self.light_diffuse, Content::LightDiffuse, &|| {
            of_shares("_diffuse")
        });
        add(self.light_specular, Content::LightSpecular, &|| {
            of_shares("_specular")
        });
        add(self.diffuse, Content::Diffuse, &|| rgb("diffuse"));
        add(self.specular, Content::Specular, &|| rgb("specular"));
        add(has_background, Content::Background, &|| {
            rgb(BACKGROUND_LIGHT)
        });
        add(has_emission, Content::Emission, &|| rgb("emission"));
        add(has_emission_of_lights, Content::EmissionOfLights, &|| {
            let seen = shares.seen().iter();
            let layers =
                seen.flat_map(|&share| rgb(&format!("emission_{}", shares.names()[share])));
            layers.collect()
        });
        add(
            has_branches || self.reflection,
            Content::Reflection,
            &|| rgb("reflection"),
        );
        add(
            has_branches || self.refraction,
            Content::Refraction,
            &|| rgb("refraction"),
        );
        add(self.albedo, Content::Albedo, &|| {
            let name = |c| channel(format!("albedo.{c}"), ChannelKind::Relative);
            RGB.map(name).to_vec()
        });
        add(self.irradiance, Content::Irradiance, &|| {
            data(&["irradiance"])
        });
        add(self.normal, Content::Normal, &|| {
            axes("N", ChannelKind::Relative)
        });
        add(self.shadow, Content::Shadow, &|| {
            let lights = world.lights().iter().enumerate();
            let lights = lights.filter(|&(light, _)| shares.of_light(light).is_some());
            lights
                .map(|(_, light)| channel(format!("shadow_{}", light.name), ChannelKind::Relative))
                .collect()
        });
        if let Some(reflectances) = self.relighting(world) {
            add(true, Content::Relight, &|| {
                let names = shares.of_lights().iter();
                let reflected = names.flat_map(|share| {
                    reflectances.names().map(move |reflectance| {
                        channel(format!("relight_{share}.{reflectance}"), ChannelKind::Data)
                    })
                });
                let seen = shares.seen().iter().map(|&share| {
                    let name = format!("relight_{}.emission", shares.names()[share]);
                    channel(name, ChannelKind::Data)
                });
                reflected.chain(seen).collect()
            });
        }
        add(self.depth, Content::Depth, &|| data(&["Z"]));
        add(self.position, Content::Position, &|| {
            axes("P", ChannelKind::Data)
        });
        let mattes = |name: &str| {
            let layers = 0..self.matte_ranks.count() / 2;
            let names = layers.flat_map(|layer| {
                ["R", "G", "B", "A"]
                    .map(|c| channel(format!("{name}{layer:02}.{c}"), ChannelKind::Matte))
            });
            names.collect::<Vec<_>>()
        };
        add(self.object_mattes, Content::ObjectMattes, &|| {
            mattes("CryptoObject")
        });
        add(self.material_mattes, Content::MaterialMattes, &|| {
            mattes("CryptoMaterial")
        });
        if let Some(wavelengths) = self.spectral {
            add(true, Content::Spectral, &|| bands(wavelengths));
        }
        add(self.error, Content::Error, &|| {
            data(&["error", "error_kind"])
        });
        add(self.samples, Content::Samples, &|| data(&["samples"]));
        contents
    }

    /// The reflectances that shares are kept apart by for lights of other colors, where they are.
    pub(super) fn relighting<'w>(&self, world: &'w World) -> Option<Reflectances<'w>> {
        // What metals and glass of a color show is not a sum over reflectances.
        let spectra = world.spectra().filter(|_| coloring(world).is_none())?;
        let is_wanted = match self.relight {
            Relight::Always => true,
            Relight::Auto => self.lights,
            Relight::Never => false,
        };
        if !is_wanted {
            return None;
        }
        let reflectances = Reflectances::new(spectra, world.chains());
        let shares = Shares::new(world, self.only.as_deref()).of_lights().len();
        let channels = shares.saturating_mul(reflectances.count());
        (self.relight == Relight::Always || channels <= Relight::MOST).then_some(reflectances)
    }

    /// A name that two channels of these layers have, of R, G, B, A and among each other.
    pub fn collision(&self, world: &World) -> Option<String> {
        let list = self.channels(world).list;
        let mut names: Vec<&str> = list.iter().map(|channel| channel.name.as_str()).collect();
        names.extend(["R", "G", "B", "A"]);
        names.sort_unstable();
        let twice = names.windows(2).find(|pair| pair[0] == pair[1]);
        twice.map(|pair| pair[0].to_owned())
    }
}

/// Bands in the layout of Fichet, Pacanowski & Wilkie 2021, "An OpenEXR Layout for Spectral
/// Images" (JCGT 10/3): emissive, unpolarized (`S0`), the wavelength with a decimal comma, because a
/// dot would part layer from channel.
fn bands(wavelengths: Wavelengths) -> Vec<Channel> {
    let bands = wavelengths.iter().map(|nm| Channel {
        name: format!("S0.{nm},000000nm"),
        kind: ChannelKind::Light,
    });
    bands.collect()
}

/// Whether a channel is one of these.
pub(super) fn is_band(name: &str) -> bool {
    name.starts_with("S0.")
}

/// Whether an attribute is about them.
pub(super) fn is_about_bands(name: &str) -> bool {
    ["candela:bands", "emissiveUnits", "spectralLayoutVersion"].contains(&name)
}

/// The layout knows only "W.m^-2.sr^-1" as the unit of emission. Here it is so per nm, which
/// `candela:bands` says.
fn spectral_attributes(wavelengths: Wavelengths) -> Vec<(String, String)> {
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
    attributes
        .map(|(name, value)| (name.to_owned(), value))
        .to_vec()
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

    fn names(layers: &Layers, scene: &str) -> Vec<String> {
        let world = World::new(&Scene::parse(scene, "scene.toml").unwrap())
            .unwrap()
            .0;
        let channels = layers.channels(&world);
        channels.list.into_iter().map(|c| c.name).collect()
    }

    fn three() -> Layers {
        Layers {
            lights: true,
            depth: true,
            normal: true,
            ..Layers::default()
        }
    }

    #[test]
    fn nothing_asked_for_is_nothing() {
        let world = World::new(&Scene::builtin()).unwrap().0;
        assert_eq!(Layers::default().channels(&world), Channels::default());
        assert!(Layers::default().names().is_empty());
    }

    #[test]
    fn channels_are_named_after_lights_and_axes() {
        assert_eq!(three().names(), ["lights", "depth", "normal"]);
        let expected = [
            "light_key left.R",
            "light_key left.G",
            "light_key left.B",
            "light_lampe_grün.R",
            "light_lampe_grün.G",
            "light_lampe_grün.B",
            "N.X",
            "N.Y",
            "N.Z",
            "Z",
        ];
        assert_eq!(names(&three(), SCENE), expected);
        // A background that is not black adds its own.
        let scene = SCENE.replace("[image]", "[image]\nbackground = [0, 0, 0.5]");
        let with_background = names(&three(), &scene);
        assert_eq!(with_background.len(), expected.len() + 3);
        assert_eq!(with_background[6], "light_background.R");
        assert_eq!(with_background[9], "N.X");
        let without_lights = Layers {
            lights: false,
            ..three()
        };
        assert_eq!(names(&without_lights, &scene), expected[6..]);
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
        assert_eq!(names(&layers, SCENE), expected);
        let world = World::new(&Scene::builtin()).unwrap().0;
        assert_eq!(
            layers.channels(&world).attributes[0].1,
            r#"{"first":550,"last":650,"step":50,"unit":"W.m^-2.sr^-1.nm^-1","weights":"hat"}"#
        );
    }
}
