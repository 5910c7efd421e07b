//! `--layers`, `--wavelengths` and `--transport`: what is rendered beside R, G, B and A, and what it
//! asks of the way of light.

use candela::render::{BACKGROUND_LIGHT, Layers};
use candela::scene::diagnostic::nearest;
use candela::scene::{Scene, Transport};
use candela::spectrum::{FIRST, LAST};
use candela::world::{Wavelengths, World};
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::Failure;

/// A layer that is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Layer {
    Lights,
    Depth,
    Normal,
    Spectral,
    Error,
    Samples,
}

impl Layer {
    const ALL: [Self; 6] = [
        Self::Lights,
        Self::Depth,
        Self::Normal,
        Self::Spectral,
        Self::Error,
        Self::Samples,
    ];

    const fn name(self) -> &'static str {
        match self {
            Self::Lights => "lights",
            Self::Depth => "depth",
            Self::Normal => "normal",
            Self::Spectral => "spectral",
            Self::Error => "error",
            Self::Samples => "samples",
        }
    }
}

/// Layers that have a name but are not made yet.
const PLANNED: [&str; 7] = [
    "diffuse",
    "specular",
    "albedo",
    "irradiance",
    "position",
    "shadow",
    "cryptomatte",
];

/// The options about layers.
#[derive(Debug, clap::Args)]
pub(super) struct LayerArguments {
    /// What the EXR holds beside R, G, B and A, separated by commas: `lights`, each light's share as
    /// `light_NAME.R`, `.G`, `.B`; `depth`, the distance along the view axis as `Z`; `normal`, in
    /// world space, as `N.X`, `.Y`, `.Z`; `spectral`, L(λ) as `S0.550,000000nm`, …, at --wavelengths;
    /// `error`, how far a pixel is off, and `error_kind`, with --max-error; `samples`, those taken
    ///
    /// All are made in the same pass as R, G, B and A, and leave these as they are.
    ///
    /// lights: in cd/m², through the box filter like R, G and B. They add up to R, G and B, with
    /// `light_background` among them where the scene has a background.
    ///
    /// depth: in scene units, of the pixel's nearest sample; 1e10 where nothing is hit. Always FLOAT.
    ///
    /// normal: as the equation uses it, turned towards the viewer, through the box filter; 0 where
    /// nothing is hit.
    ///
    /// spectral: in W/(m² sr nm), in the layout of spectral EXR images (JCGT 2021). A scene with
    /// `transport = "auto"` carries light spectrally then. The cost is in proportion to bands and
    /// pixels, not to samples: 41 bands take about a fifth longer to render at 4 samples a pixel, 4
    /// bytes for each band and pixel, and several seconds to compress where the image is large.
    ///
    /// error: in cd/m², of the largest of R, G and B. `error_kind` is 0 where it is a bound, which is
    /// proven, and 1 where it is an estimate. Both are always FLOAT.
    ///
    /// samples: how many were taken of the pixel; 0 where its edges were integrated. Always FLOAT.
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = layer)]
    layers: Vec<Layer>,

    /// Where `--layers spectral` has its bands, in whole nm from 360 to 830, both ends included
    /// [default: 380:780:10]
    ///
    /// Each is the mean around its wavelength, weighted by a hat as wide as the distance to its
    /// neighbors, so that narrow lines between two bands are not lost.
    #[arg(long, value_name = "START:END:STEP", value_parser = wavelengths, allow_hyphen_values = true)]
    wavelengths: Option<Wavelengths>,

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
            .find(|&layer| self.layers.iter().filter(|&&other| other == layer).count() > 1);
        if let Some(layer) = twice {
            return Some(format!(
                "--layers has `{}` twice; say it once",
                layer.name()
            ));
        }
        if self.has(Layer::Error) && !has_target {
            return Some(
                "--layers error says how far pixels are off, which is known with --max-error alone; add it, \
                 or leave `error` out"
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

    fn has(&self, layer: Layer) -> bool {
        self.layers.contains(&layer)
    }

    fn is_spectral(&self) -> bool {
        self.has(Layer::Spectral)
    }

    /// The layers to render.
    pub(super) fn layers(&self) -> Layers {
        let wavelengths = self.wavelengths.unwrap_or_default();
        Layers {
            lights: self.has(Layer::Lights),
            depth: self.has(Layer::Depth),
            normal: self.has(Layer::Normal),
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
        // Of all names that a scene may hold, this alone can make a channel twice.
        let channels = self.layers().channels(world).list;
        let named = |name: &str| channels.iter().filter(|c| c.name == name).count();
        if named(&format!("light_{BACKGROUND_LIGHT}.R")) > 1 {
            return Err(format!(
                "--layers lights gives the background's share the name \
                 `light_{BACKGROUND_LIGHT}`, but there is a light `{BACKGROUND_LIGHT}`; rename the \
                 light, or leave `background` out of [image]"
            )
            .into());
        }
        Ok(())
    }
}

fn layer(name: &str) -> Result<Layer, String> {
    let name = name.trim();
    if let Some(layer) = Layer::ALL.into_iter().find(|layer| layer.name() == name) {
        return Ok(layer);
    }
    let made = Layer::ALL.map(Layer::name);
    if PLANNED.contains(&name) {
        return Err(format!(
            "layer `{name}` is not supported yet; there is {}",
            made.join(", ")
        ));
    }
    let names = made.into_iter().chain(PLANNED);
    Err(match nearest(name, names) {
        Some(nearest) => format!("there is no layer `{name}`; did you mean `{nearest}`?"),
        None => format!("there is no layer `{name}`; there is {}", made.join(", ")),
    })
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
