//! What an image has beside R, G, B and A.

/// Z where no sample of a pixel hits anything: finite, so that arithmetic on it stays so, and behind
/// all that scenes in metres hold. It is what Blender writes.
pub const BACKGROUND_DEPTH: f32 = 1e10;

/// The channels of a film beside R, G, B and A, and what the EXR header says about them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Channels {
    /// In the order in which a pixel has them.
    pub list: Vec<Channel>,
    /// Text attributes, as name and value.
    pub attributes: Vec<(String, String)>,
    /// Sums that are R, G and B: of each, the places in `list` of the first of three channels R, G, B that follow each
    /// other, which together are the image.
    pub sums: Vec<Vec<usize>>,
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
#[non_exhaustive]
pub enum ChannelKind {
    /// Light, or a share of it: in the precision that is asked for, as R, G and B.
    Light,
    /// Numbers beside 1, such as reflectances and components of unit vectors: in the precision that is asked for.
    /// Nothing is lost where halves hold small ones with few digits.
    Relative,
    /// Anything whose digits all count, such as a distance: always FLOAT.
    Data,
    /// Numbers that stand for names: always FLOAT, and never under a compression that loses digits.
    Matte,
}
