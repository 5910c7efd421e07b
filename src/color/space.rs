//! The linear RGB spaces: what each is called, its primaries and white, in one table.

use super::Primaries;

/// The RGB color spaces that a scene can name. All are linear and scene-referred.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ColorSpace {
    /// The primaries and white of ITU-R BT.709.
    #[default]
    Rec709,
    /// Display P3 primaries, D65.
    P3D65,
    /// ITU-R BT.2020 primaries, D65.
    Rec2020,
    /// ACES AP1 primaries, the ACES white.
    AcesCg,
}

/// D65 as the RGB standards round it (ITU-R BT.709-6, table 1).
const D65: [f64; 2] = [0.3127, 0.3290];

impl Primaries {
    /// ITU-R BT.709-6, which sRGB shares.
    pub const REC709: Self = Self {
        red: [0.640, 0.330],
        green: [0.300, 0.600],
        blue: [0.150, 0.060],
        white: D65,
    };

    /// P3 with a D65 white (SMPTE EG 432-1).
    pub const P3_D65: Self = Self {
        red: [0.680, 0.320],
        green: [0.265, 0.690],
        blue: [0.150, 0.060],
        white: D65,
    };

    /// ITU-R BT.2020-2.
    pub const REC2020: Self = Self {
        red: [0.708, 0.292],
        green: [0.170, 0.797],
        blue: [0.131, 0.046],
        white: D65,
    };

    /// Adobe RGB (1998), section 4.3.1.1.
    pub const ADOBE_RGB: Self = Self {
        red: [0.640, 0.330],
        green: [0.210, 0.710],
        blue: [0.150, 0.060],
        white: D65,
    };

    /// CIE XYZ itself as a space of R, G, B. The white is that of equal numbers, which is no
    /// light's: colors are not adapted from it.
    pub const XYZ: Self = Self {
        red: [1.0, 0.0],
        green: [0.0, 1.0],
        blue: [0.0, 0.0],
        white: [1.0 / 3.0, 1.0 / 3.0],
    };

    /// AP1, the primaries of ACEScg (S-2014-004).
    pub const AP1: Self = Self {
        red: [0.713, 0.293],
        green: [0.165, 0.830],
        blue: [0.128, 0.044],
        white: [0.32168, 0.33767],
    };

    /// AP0, the primaries of ACES 2065-1 (SMPTE ST 2065-1).
    pub const AP0: Self = Self {
        red: [0.7347, 0.2653],
        green: [0.0, 1.0],
        blue: [0.0001, -0.0770],
        white: [0.32168, 0.33767],
    };
}

/// What there is to know of a linear space.
struct LinearSpace {
    primaries: Primaries,
    /// The identifier that the ASWF Color Interop Forum gives its scene-referred form.
    scene_id: &'static str,
    /// And that of its display-referred form, if it has one.
    display_id: Option<&'static str>,
}

/// A linear space with its name.
struct NamedSpace {
    /// In a scene file, or on the command line.
    name: &'static str,
    linear: LinearSpace,
}

const REC709: NamedSpace = NamedSpace {
    name: "rec709",
    linear: LinearSpace {
        primaries: Primaries::REC709,
        scene_id: "lin_rec709_scene",
        display_id: Some("lin_rec709_display"),
    },
};

const P3_D65: NamedSpace = NamedSpace {
    name: "p3-d65",
    linear: LinearSpace {
        primaries: Primaries::P3_D65,
        scene_id: "lin_p3d65_scene",
        display_id: Some("lin_p3d65_display"),
    },
};

const REC2020: NamedSpace = NamedSpace {
    name: "rec2020",
    linear: LinearSpace {
        primaries: Primaries::REC2020,
        scene_id: "lin_rec2020_scene",
        display_id: Some("lin_rec2020_display"),
    },
};

const ACES_CG: NamedSpace = NamedSpace {
    name: "acescg",
    linear: LinearSpace {
        primaries: Primaries::AP1,
        scene_id: "lin_ap1_scene",
        display_id: None,
    },
};

/// Spaces that images come in, though no scene names them.
const OF_IMAGES: [NamedSpace; 3] = [
    NamedSpace {
        name: "adobe-rgb",
        linear: LinearSpace {
            primaries: Primaries::ADOBE_RGB,
            scene_id: "lin_adobergb_scene",
            display_id: None,
        },
    },
    NamedSpace {
        name: "aces2065-1",
        linear: LinearSpace {
            primaries: Primaries::AP0,
            scene_id: "lin_ap0_scene",
            display_id: None,
        },
    },
    NamedSpace {
        name: "xyz",
        linear: LinearSpace {
            primaries: Primaries::XYZ,
            scene_id: "lin_ciexyzd65_scene",
            display_id: Some("lin_ciexyzd65_display"),
        },
    },
];

impl ColorSpace {
    /// Every space, in the order of the documentation.
    pub const ALL: [Self; 4] = [Self::Rec709, Self::P3D65, Self::Rec2020, Self::AcesCg];

    /// The name in a scene file.
    pub const fn name(self) -> &'static str {
        self.facts().name
    }

    const fn facts(self) -> NamedSpace {
        match self {
            Self::Rec709 => REC709,
            Self::P3D65 => P3_D65,
            Self::Rec2020 => REC2020,
            Self::AcesCg => ACES_CG,
        }
    }

    /// Its primaries and white.
    pub const fn primaries(self) -> Primaries {
        self.facts().linear.primaries
    }

    /// The identifier that the ASWF Color Interop Forum gives it, as `colorInteropID` of an EXR holds it.
    pub const fn interop_id(self) -> &'static str {
        self.facts().linear.scene_id
    }
}

/// All linear spaces that are known.
fn spaces() -> impl Iterator<Item = NamedSpace> {
    let of_scenes = ColorSpace::ALL.map(ColorSpace::facts);
    of_scenes.into_iter().chain(OF_IMAGES)
}

impl Primaries {
    /// Those of a linear space by its identifier: all of those of the ASWF Color Interop Forum, of scenes and of
    /// displays.
    pub fn of_interop_id(id: &str) -> Option<Self> {
        let mut spaces = spaces().map(|space| space.linear);
        let found = spaces.find(|space| space.scene_id == id || space.display_id == Some(id));
        found.map(|space| space.primaries)
    }

    /// Those of a linear space by its name, one of [`Primaries::names`].
    pub fn named(name: &str) -> Option<Self> {
        let found = spaces().find(|space| space.name == name);
        found.map(|space| space.linear.primaries)
    }

    /// The name of the linear space that has them, if it is known.
    pub fn name(&self) -> Option<&'static str> {
        let found = spaces().find(|space| space.linear.primaries == *self);
        found.map(|space| space.name)
    }

    /// The names of all linear spaces that are known.
    pub fn names() -> impl Iterator<Item = &'static str> {
        spaces().map(|space| space.name)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn identifiers_lead_back_to_their_space() {
        for space in ColorSpace::ALL {
            let found = Primaries::of_interop_id(space.interop_id());
            assert_eq!(found, Some(space.primaries()), "{}", space.name());
        }
        assert_eq!(
            Primaries::of_interop_id("lin_ap0_scene"),
            Some(Primaries::AP0)
        );
        // Coded, not linear.
        assert_eq!(Primaries::of_interop_id("srgb_rec709_display"), None);
    }

    /// Names, identifiers and primaries are each of one space.
    #[test]
    fn no_two_spaces_share_a_fact() {
        let all: Vec<NamedSpace> = spaces().collect();
        for (place, one) in all.iter().enumerate() {
            for other in &all[..place] {
                assert_ne!(one.name, other.name);
                assert_ne!(one.linear.scene_id, other.linear.scene_id);
                assert_ne!(one.linear.primaries, other.linear.primaries, "{}", one.name);
            }
            assert_eq!(Primaries::named(one.name), Some(one.linear.primaries));
        }
    }

    /// The pages have every name, and every identifier of a scene-referred form, and no other.
    #[test]
    fn the_pages_have_this_table() {
        let format = include_str!("../../docs/scene-format.md");
        let names = ColorSpace::ALL.map(|space| format!("`\"{}\"`", space.name()));
        let row = format
            .lines()
            .find(|line| line.starts_with("| `color_space`"));
        assert!(row.unwrap().contains(&names.join(", ")));
        let tonemap = include_str!("../../docs/tonemap.md");
        let words = tonemap.split('`');
        let told: HashSet<&str> = words
            .filter(|word| word.starts_with("lin_") && word.len() > 4)
            .collect();
        assert_eq!(told, spaces().map(|space| space.linear.scene_id).collect());
    }
}
