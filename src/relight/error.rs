//! Why a file cannot be relit, and the way out.

use crate::exr::ExrError;
use crate::memory::OutOfMemory;
use crate::output::OutputError;
use crate::printable::{printable, shortened};
use crate::scene::Diagnostics;

/// A file could not be relit; nothing was written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RelightError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] ExrError),
    /// The new file cannot be written.
    #[error(transparent)]
    Write(#[from] OutputError),
    /// There is not enough memory.
    #[error(transparent)]
    Memory(OutOfMemory),
    /// A color that no scene could have.
    #[error("{0}")]
    Color(Diagnostics),
    /// There are no layers of lights.
    #[error(
        "it has no layer of a light, light_NAME.R, .G and .B; render it with `candela render --layers lights`, or \
         give other programs' layers such names"
    )]
    NoLayers,
    /// R, G and B are not there as HALF or FLOAT.
    #[error("it has no channels R, G and B in HALF or FLOAT, which its lights would add up to")]
    NoRgb,
    /// The file does not say what its lights are, and its layers do not add up to its picture.
    #[error(
        "it does not say what its lights are (it has no `candela:lights`), and its layers light_NAME do not add up to \
         R, G and B: {} of pixel {pixel} differs by {residual:e}; what is left over cannot be told apart from \
         them, so render it with all of its lights as layers",
        shortened(channel)
    )]
    NoSum {
        /// The channel, such as `R`.
        channel: String,
        /// Column and row of the data window, `x,y`.
        pixel: String,
        /// The largest difference that is more than rounding explains.
        residual: f64,
    },
    /// The file does not say what its lights are, which colors need.
    #[error(
        "it does not say what the color of `{}` is (it has no `candela:lights`), so that it cannot get another one; a factor \
         such as {}=2 can be given, or the scene rendered with `candela render --layers lights`",
        shortened(.0),
        shortened(.0)
    )]
    NoColors(String),
    /// No light, group or background has this name.
    #[error("there is no light `{}`; {}", shortened(name), found(nearest.as_deref(), names))]
    UnknownLight {
        /// As written.
        name: String,
        /// The one that was most likely meant.
        nearest: Option<String>,
        /// Those that there are.
        names: Vec<String>,
    },
    /// A light that has no layer of its own.
    #[error(
        "the light `{}` is in the file as a part of its group `{}` only; change the group, or render without it",
        shortened(light),
        shortened(group)
    )]
    InGroup {
        /// The light.
        light: String,
        /// Its group.
        group: String,
    },
    /// A light of the scene that the file has no layer of.
    #[error(
        "the file has no layer `light_{}`; render the scene with `--layers lights`, which gives each light one",
        shortened(.0)
    )]
    NoLayer(String),
    /// A name stands in two settings.
    #[error("`{}` is there twice; say it once, as NAME=2,#ff8040 where both a factor and a color are meant", shortened(.0))]
    Twice(String),
    /// A background can be dimmed only.
    #[error(
        "the background has no color of its own to change: what is seen is the picture of it; a factor such as \
         background=0.5 can be given"
    )]
    BackgroundColor,
    /// A light that is in the picture itself.
    #[error(
        "`{}` is seen in the picture, and the file has no layer of what it sends itself, emission_{}; render the scene with \
         `--layers lights`, which stores one, or with `visible = false` for this light",
        shortened(light),
        shortened(share)
    )]
    Seen {
        /// The light.
        light: String,
        /// The name of its layers: that of its group, or its own.
        share: String,
    },
    /// A channel in which there is no light to scale.
    #[error(
        "`{}` cannot get this color: its {channel} was 0 where the file was rendered, and nothing multiplied makes \
         light of 0; render the scene with the new color, or with light that has some {channel}",
        shortened(name)
    )]
    NoLight {
        /// The light or group.
        name: String,
        /// `red`, `green` or `blue`.
        channel: &'static str,
    },
    /// A group of lights of several colors, added up in R, G and B.
    #[error(
        "the lights of the group `{}` have different colors, which cannot be told apart in its layer; render the scene \
         without the group, or carry light spectrally, `candela render --transport spectral --layers lights`",
        shortened(.0)
    )]
    MixedGroup(String),
    /// Light was carried spectrally, and how it meets the reflectances is not in the file.
    #[error(
        "light was carried spectrally, and the file has no channels `relight_{}.flat`, .1, …, which a new color needs; \
         render the scene with `--layers lights`, which stores them unless mirrors or glass color light; a factor can be given \
         in any case",
        shortened(.0)
    )]
    NotStored(String),
    /// The file does not say in which space its colors are.
    #[error(
        "it does not say in which of the spaces of scenes its colors are (`colorInteropID`), so that a light cannot get \
         another color; factors can be given"
    )]
    NoColorSpace,
    /// What the header says cannot be understood.
    #[error(
        "what its header says in `{attribute}` is not as candela writes it ({}); render the scene anew",
        printable(reason)
    )]
    Header {
        /// The attribute.
        attribute: &'static str,
        /// Why.
        reason: String,
    },
}

/// At most this many names are listed.
const LISTED: usize = 20;

fn found(nearest: Option<&str>, names: &[String]) -> String {
    let mut list: Vec<String> = names
        .iter()
        .take(LISTED)
        .map(|name| shortened(name))
        .collect();
    if names.len() > LISTED {
        list.push(format!("{} more", names.len() - LISTED));
    }
    let list = format!("it has {}", list.join(", "));
    match nearest {
        Some(nearest) => format!("did you mean `{}`? {list}", shortened(nearest)),
        None => list,
    }
}
