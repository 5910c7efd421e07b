//! `--layers`, `--wavelengths` and `--transport`: what is rendered beside R, G, B and A, and what it
//! asks of the way of light.

use std::path::PathBuf;

use candela::internal::printable;
use candela::render::{BACKGROUND_LIGHT, Layers, MatteRanks, Relight};
use candela::scene::diagnostic::nearest;
use candela::scene::{Scene, Transport};
use candela::spectrum::{FIRST, LAST};
use candela::world::{Wavelengths, World};
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::Failure;
use super::values::named;

/// A layer that is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Layer {
    Lights,
    LightDiffuse,
    LightSpecular,
    Relight,
    NoRelight,
    Diffuse,
    Specular,
    Emission,
    Reflection,
    Refraction,
    Albedo,
    Irradiance,
    Depth,
    Position,
    Normal,
    Shadow,
    Cryptomatte,
    Spectral,
    Error,
    Samples,
}

impl Layer {
    const ALL: [Self; 20] = [
        Self::Lights,
        Self::LightDiffuse,
        Self::LightSpecular,
        Self::Relight,
        Self::NoRelight,
        Self::Diffuse,
        Self::Specular,
        Self::Emission,
        Self::Reflection,
        Self::Refraction,
        Self::Albedo,
        Self::Irradiance,
        Self::Depth,
        Self::Position,
        Self::Normal,
        Self::Shadow,
        Self::Cryptomatte,
        Self::Spectral,
        Self::Error,
        Self::Samples,
    ];

    const fn name(self) -> &'static str {
        match self {
            Self::Lights => "lights",
            Self::LightDiffuse => "light-diffuse",
            Self::LightSpecular => "light-specular",
            Self::Relight => "relight",
            Self::NoRelight => "no-relight",
            Self::Emission => "emission",
            Self::Reflection => "reflection",
            Self::Refraction => "refraction",
            Self::Diffuse => "diffuse",
            Self::Specular => "specular",
            Self::Albedo => "albedo",
            Self::Irradiance => "irradiance",
            Self::Depth => "depth",
            Self::Position => "position",
            Self::Normal => "normal",
            Self::Shadow => "shadow",
            Self::Cryptomatte => "cryptomatte",
            Self::Spectral => "spectral",
            Self::Error => "error",
            Self::Samples => "samples",
        }
    }

    /// Whether names of lights may follow.
    const fn is_by_light(self) -> bool {
        match self {
            Self::Lights | Self::LightDiffuse | Self::LightSpecular | Self::Shadow => true,
            Self::Relight
            | Self::NoRelight
            | Self::Diffuse
            | Self::Specular
            | Self::Emission
            | Self::Reflection
            | Self::Refraction
            | Self::Albedo
            | Self::Irradiance
            | Self::Depth
            | Self::Position
            | Self::Normal
            | Self::Cryptomatte
            | Self::Spectral
            | Self::Error
            | Self::Samples => false,
        }
    }

    fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|layer| layer.name() == name)
    }
}

/// What one `--layers` asks for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct LayerList {
    layers: Vec<Layer>,
    /// The lights after `lights=`.
    only: Vec<String>,
    /// `object` or `material`.
    mattes: Option<Mattes>,
}

/// Which mattes are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mattes {
    Object,
    Material,
}

/// The options about layers.
#[derive(Debug, clap::Args)]
pub(super) struct LayerArguments {
    /// What the EXR holds beside R, G, B and A, separated by commas: `lights`, `diffuse`, `specular`, `emission`,
    /// `reflection`, `refraction`, `albedo`, `irradiance`, `depth`, `position`, `normal`, `shadow`, `cryptomatte`, `spectral`,
    /// `error`, `samples`, and for each light `light-diffuse`, `light-specular`
    ///
    /// All are made in the same pass as R, G, B and A, and leave these as they are. docs/layers.md says more of each.
    ///
    /// lights: each light's share, `light_NAME.R`, `.G`, `.B`, in cd/m², through the box filter like R, G and B. They
    /// add up to R, G and B, with `light_background` among them where the scene has a background. Lights with a
    /// `group` in the scene have one share together, `light_GROUP`. `lights=key,fill` makes those of these lights or
    /// groups alone. `candela relight` makes a picture with other lights of them.
    ///
    /// light-diffuse, light-specular: the two lobes of each share, `light_NAME_diffuse.R`, … ; `=key,fill` as well.
    ///
    /// diffuse, specular: the two terms of L8 of all lights, `diffuse.R`, …, `specular.R`, … With `background.R`, …
    /// where the scene has a background, they add up to R, G and B.
    ///
    /// emission: what lights that are seen send themselves, `emission.R`, … It comes with `lights`, `diffuse` and
    /// `specular` where any light is seen, so that these add up to R, G and B.
    ///
    /// reflection, refraction: what comes by mirrors and through glass, `reflection.R`, … They come with `diffuse` and
    /// `specular` where anything is perfectly smooth, so that these add up to R, G and B.
    ///
    /// albedo: k_d, `albedo.R`, …, 0 where nothing is hit. irradiance: the illuminance of the surface in lux,
    /// `irradiance`; always FLOAT. shadow: V of each light, `shadow_NAME`, 0 to 1; `=key,fill` as well. All through
    /// the box filter.
    ///
    /// depth: the distance along the view axis, `Z`, in scene units, of the pixel's nearest sample; 1e10 where
    /// nothing is hit. position: where that sample is, `P.X`, `.Y`, `.Z`. Always FLOAT.
    ///
    /// normal: in world space, `N.X`, `.Y`, `.Z`, as the equation uses it, turned towards the viewer, through the box
    /// filter; 0 where nothing is hit.
    ///
    /// cryptomatte: mattes of objects and materials, `CryptoObject00.R`, …, `CryptoMaterial00.R`, …, by Psyop's
    /// specification; `=object` or `=material` alone. Always FLOAT.
    ///
    /// spectral: L(λ) as `S0.550,000000nm`, …, at --wavelengths, in W/(m² sr nm), in the layout of spectral EXR
    /// images (JCGT 2021). A scene with `transport = "auto"` carries light spectrally then. Programs that show
    /// pictures may not like so many channels: --spectral-output writes them to a file of their own.
    ///
    /// error: in cd/m², of the largest of R, G and B. `error_kind` is 0 where it is a bound, which is
    /// proven, and 1 where it is an estimate; with --max-error. samples: how many were taken of the pixel; 0 where
    /// its edges were integrated, or a square around it interpolated. Always FLOAT.
    ///
    /// With `lights` comes what `candela relight` needs: `emission_NAME.R`, … of each light that is seen itself; and where
    /// light is carried spectrally `relight_NAME.flat`, `.1`, …, what a light of another color needs, if that takes at
    /// most 256 channels and no mirror or glass colors light; `relight` makes it in any case, `no-relight` neither.
    #[arg(long, value_name = "LIST", value_parser = layer_list)]
    layers: Vec<LayerList>,

    /// How many names a pixel may have in each matte of --layers cryptomatte: those that cover most of it, from 1 to
    /// 200, two for each layer of the file [default: 6]
    #[arg(long, value_name = "N", value_parser = matte_ranks)]
    cryptomatte_levels: Option<MatteRanks>,

    /// Where `--layers spectral` has its bands, in whole nm from 360 to 830, both ends included
    /// [default: 380:780:10]
    ///
    /// Each is the mean around its wavelength, weighted by a hat as wide as the distance to its
    /// neighbors, so that narrow lines between two bands are not lost.
    #[arg(long, value_name = "START:END:STEP", value_parser = wavelengths, allow_hyphen_values = true)]
    wavelengths: Option<Wavelengths>,

    /// Write the bands of --layers spectral to a file of their own, with R, G, B and A, beside the picture: many
    /// programs do not read a picture with dozens of channels
    #[arg(long, value_name = "BANDS.exr", value_parser = named("exr"))]
    pub(super) spectral_output: Option<PathBuf>,

    /// How light is carried, instead of what the scene says: `rgb`, `spectral`, or `auto`, which
    /// is spectral if anything in the scene is a spectrum
    #[arg(long, value_name = "NAME")]
    #[arg(value_parser = transports())]
    transport: Option<Transport>,
}

impl LayerArguments {
    /// What is wrong with the options as they stand together.
    pub(super) fn misuse(&self, has_target: bool) -> Option<String> {
        let twice = Layer::ALL
            .into_iter()
            .find(|&layer| self.asked().filter(|&other| other == layer).count() > 1);
        if let Some(layer) = twice {
            return Some(format!(
                "--layers has `{}` twice; say it once",
                layer.name()
            ));
        }
        if self.has(Layer::Relight) && self.has(Layer::NoRelight) {
            return Some("--layers has `relight` and `no-relight`; leave one out".to_owned());
        }
        if self.has(Layer::Error) && !has_target {
            return Some(
                "--layers error says how far pixels are off, which is known with --max-error alone; add it, \
                 or leave `error` out"
                    .to_owned(),
            );
        }
        if self.cryptomatte_levels.is_some() && !self.has(Layer::Cryptomatte) {
            return Some(
                "--cryptomatte-levels is about --layers cryptomatte, which is not asked for; add it, or leave \
                 --cryptomatte-levels out"
                    .to_owned(),
            );
        }
        if self.spectral_output.is_some() && !self.is_spectral() {
            return Some(
                "--spectral-output is where the bands of --layers spectral go, which are not asked for; add it, or \
                 leave --spectral-output out"
                    .to_owned(),
            );
        }
        if self.wavelengths.is_some() && !self.is_spectral() {
            return Some(
                "--wavelengths says where the bands of --layers spectral are, which is not asked \
                 for; add it, or leave --wavelengths out"
                    .to_owned(),
            );
        }
        (self.is_spectral() && self.transport == Some(Transport::Rgb)).then(|| {
            "--layers spectral needs light that is carried spectrally; leave --transport rgb out"
                .to_owned()
        })
    }

    fn asked(&self) -> impl Iterator<Item = Layer> {
        self.layers
            .iter()
            .flat_map(|list| list.layers.iter().copied())
    }

    fn has(&self, layer: Layer) -> bool {
        self.asked().any(|asked| asked == layer)
    }

    fn is_spectral(&self) -> bool {
        self.has(Layer::Spectral)
    }

    /// The layers to render.
    pub(super) fn layers(&self) -> Layers {
        let wavelengths = self.wavelengths.unwrap_or_default();
        let only = self
            .layers
            .iter()
            .flat_map(|list| list.only.iter().cloned());
        let only: Vec<String> = only.collect();
        let mattes = self.layers.iter().find_map(|list| list.mattes);
        Layers {
            lights: self.has(Layer::Lights),
            light_diffuse: self.has(Layer::LightDiffuse),
            light_specular: self.has(Layer::LightSpecular),
            only: (!only.is_empty()).then_some(only),
            relight: if self.has(Layer::Relight) {
                Relight::Always
            } else if self.has(Layer::NoRelight) {
                Relight::Never
            } else {
                Relight::Auto
            },
            emission: self.has(Layer::Emission),
            reflection: self.has(Layer::Reflection),
            refraction: self.has(Layer::Refraction),
            diffuse: self.has(Layer::Diffuse),
            specular: self.has(Layer::Specular),
            albedo: self.has(Layer::Albedo),
            irradiance: self.has(Layer::Irradiance),
            depth: self.has(Layer::Depth),
            position: self.has(Layer::Position),
            normal: self.has(Layer::Normal),
            shadow: self.has(Layer::Shadow),
            object_mattes: self.has(Layer::Cryptomatte) && mattes != Some(Mattes::Material),
            material_mattes: self.has(Layer::Cryptomatte) && mattes != Some(Mattes::Object),
            matte_ranks: self.cryptomatte_levels.unwrap_or_default(),
            spectral: self.is_spectral().then_some(wavelengths),
            error: self.has(Layer::Error),
            samples: self.has(Layer::Samples),
        }
    }

    /// Makes the scene carry light as the options ask for.
    pub(super) fn apply(&self, scene: &mut Scene) {
        let transport = &mut scene.image.transport.value;
        if let Some(asked) = self.transport {
            *transport = asked;
        }
        if self.is_spectral() && *transport == Transport::Auto {
            *transport = Transport::Spectral;
        }
    }

    /// Whether the layers can be made of this world.
    pub(super) fn check(&self, world: &World) -> Result<(), Failure> {
        if self.is_spectral() && world.spectra().is_none() {
            return Err(
                "--layers spectral needs light that is carried spectrally, but the scene says \
                 `transport = \"rgb\"`; remove that, or add --transport spectral"
                    .into(),
            );
        }
        let layers = self.layers();
        if let Some(only) = &layers.only {
            check_names(only, world)?;
        }
        let Some(channel) = layers.collision(world) else {
            return Ok(());
        };
        if channel.starts_with(&format!("light_{BACKGROUND_LIGHT}.")) {
            return Err(format!(
                "--layers lights gives the background's share the name \
                 `light_{BACKGROUND_LIGHT}`, but there is a light `{BACKGROUND_LIGHT}`; rename the \
                 light, or leave `background` out of [image]"
            )
            .into());
        }
        Err(format!(
            "--layers makes two channels `{}`: a lobe of one light has the name of another light; rename one of \
             the lights, or leave `light-diffuse` and `light-specular` out",
            printable(&channel)
        )
        .into())
    }
}

/// Whether there are lights, or groups of lights, of all these names.
fn check_names(only: &[String], world: &World) -> Result<(), Failure> {
    let of_light = |light: usize| {
        let name = world.lights()[light].name.as_str();
        world.light_group(light).unwrap_or(name)
    };
    let lights = 0..world.lights().len();
    let mut names: Vec<&str> = lights.clone().map(of_light).collect();
    names.push(BACKGROUND_LIGHT);
    for name in only {
        if names.contains(&name.as_str()) {
            continue;
        }
        let grouped = lights
            .clone()
            .find(|&light| world.lights()[light].name == *name);
        if let Some(group) = grouped.and_then(|light| world.light_group(light)) {
            return Err(format!(
                "--layers: the light `{}` is in the group `{}`, which has one layer for all its lights; write `{}`",
                printable(name),
                printable(group),
                printable(group)
            )
            .into());
        }
        let meant = nearest(name, names.iter().copied());
        let meant = meant.map_or(String::new(), |meant| {
            format!("; did you mean `{}`?", printable(meant))
        });
        return Err(format!(
            "--layers: there is no layer and no light `{}`{meant}",
            printable(name)
        )
        .into());
    }
    Ok(())
}

/// Layers, and after `lights=` lights up to the next layer.
fn layer_list(text: &str) -> Result<LayerList, String> {
    let mut list = LayerList::default();
    let mut takes_names = false;
    for item in text.split(',') {
        let item = item.trim();
        let (name, value) = match item.split_once('=') {
            Some((name, value)) => (name.trim(), Some(value.trim())),
            None => (item, None),
        };
        let quoted = item
            .strip_prefix('"')
            .and_then(|rest| rest.strip_suffix('"'));
        if let Some(name) = quoted.filter(|_| takes_names) {
            list.only.push(name.to_owned());
            continue;
        }
        let layer = match Layer::named(name) {
            Some(layer) => layer,
            None if takes_names && value.is_none() => {
                list.only.push(name.to_owned());
                continue;
            }
            None => return Err(no_layer(name)),
        };
        list.layers.push(layer);
        takes_names = false;
        match (layer, value) {
            (_, None) => {}
            (layer, Some(light)) if layer.is_by_light() => {
                let quoted = light
                    .strip_prefix('"')
                    .and_then(|rest| rest.strip_suffix('"'));
                list.only.push(quoted.unwrap_or(light).to_owned());
                takes_names = true;
            }
            (Layer::Cryptomatte, Some("object")) => list.mattes = Some(Mattes::Object),
            (Layer::Cryptomatte, Some("material")) => list.mattes = Some(Mattes::Material),
            (Layer::Cryptomatte, Some(_)) => {
                return Err("expected cryptomatte=object or cryptomatte=material".to_owned());
            }
            (layer, Some(_)) => {
                return Err(format!("`{}` takes no names of lights", layer.name()));
            }
        }
    }
    Ok(list)
}

fn no_layer(name: &str) -> String {
    let names = Layer::ALL.map(Layer::name);
    match nearest(name, names) {
        Some(nearest) => format!("there is no layer `{name}`; did you mean `{nearest}`?"),
        None => format!("there is no layer `{name}`; there is {}", names.join(", ")),
    }
}

fn matte_ranks(text: &str) -> Result<MatteRanks, String> {
    let count: Option<usize> = text.parse().ok();
    count
        .and_then(MatteRanks::new)
        .ok_or_else(|| format!("expected a number from 1 to {}", MatteRanks::MOST))
}

fn wavelengths(text: &str) -> Result<Wavelengths, String> {
    let numbers: Result<Vec<u32>, _> = text.split(':').map(|part| part.trim().parse()).collect();
    let Ok([first, last, step]) = numbers.as_deref() else {
        return Err("expected START:END:STEP in whole nm, such as 400:700:10".to_owned());
    };
    let (first, last, step) = (*first, *last, *step);
    if first < FIRST || last > LAST {
        return Err(format!("expected wavelengths from {FIRST} to {LAST} nm"));
    }
    if first >= last {
        return Err("expected START < END".to_owned());
    }
    if step == 0 {
        return Err("expected a STEP of at least 1 nm".to_owned());
    }
    Wavelengths::new(first, last, step).ok_or_else(|| {
        let below = (last - first) / step * step;
        let ends = match below {
            0 => format!("{}", first + step),
            _ => format!("{} or {}", first + below, first + below + step),
        };
        format!("expected END to be whole steps from START, such as {ends}")
    })
}

/// The name of a transport.
pub(crate) fn transports() -> impl TypedValueParser<Value = Transport> {
    PossibleValuesParser::new(Transport::ALL.map(Transport::name)).map(|name| transport(&name))
}

fn transport(name: &str) -> Transport {
    let named = Transport::ALL.into_iter().find(|it| it.name() == name);
    named.expect("clap lets only these names pass")
}
