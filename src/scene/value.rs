//! Values for light and color, as written.

/// A value for light or color: `0.5`, `[r, g, b]`, `"#c86432"` or
/// `{ rgb = [r, g, b], space = "rec709" }`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// The same in every channel.
    Uniform(f64),
    /// Linear, one number per primary of `space`; a bare `[r, g, b]` is Rec.709.
    Rgb {
        /// Red, green, blue.
        rgb: [f64; 3],
        /// Whose primaries these are.
        space: ColorSpace,
    },
    /// `"#rrggbb"`: sRGB-coded, 8 bits a channel.
    Srgb([u8; 3]),
}

/// The RGB color spaces that a scene can name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ColorSpace {
    /// Linear, with the primaries and white of ITU-R BT.709.
    #[default]
    Rec709,
    /// Linear, Display P3 primaries, D65. Not rendered in yet.
    P3D65,
    /// Linear, ITU-R BT.2020 primaries, D65. Not rendered in yet.
    Rec2020,
    /// Linear, ACES AP1 primaries. Not rendered in yet.
    AcesCg,
}

impl ColorSpace {
    /// Every space, in the order of the documentation.
    pub const ALL: [Self; 4] = [Self::Rec709, Self::P3D65, Self::Rec2020, Self::AcesCg];

    /// The name in a scene file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rec709 => "rec709",
            Self::P3D65 => "p3-d65",
            Self::Rec2020 => "rec2020",
            Self::AcesCg => "acescg",
        }
    }
}

impl Value {
    /// Zero in every channel.
    pub const ZERO: Self = Self::Uniform(0.0);
}
