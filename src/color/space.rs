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

/// What there is to know of a linear space.
struct LinearSpace {
    primaries: Primaries,
    /// The identifier that the ASWF Color Interop Forum gives its scene-referred form.
    scene_id: &'static str,
    /// And that of its display-referred form, if it has one.
    display_id: Option<&'static str>,
}

const REC709: LinearSpace = LinearSpace {
    primaries: Primaries::REC709,
    scene_id: "lin_rec709_scene",
    display_id: Some("lin_rec709_display"),
};

const P3_D65: LinearSpace = LinearSpace {
    primaries: Primaries::P3_D65,
    scene_id: "lin_p3d65_scene",
    display_id: Some("lin_p3d65_display"),
};

const REC2020: LinearSpace = LinearSpace {
    primaries: Primaries::REC2020,
    scene_id: "lin_rec2020_scene",
    display_id: Some("lin_rec2020_display"),
};

const ACES_CG: LinearSpace = LinearSpace {
    primaries: Primaries::AP1,
    scene_id: "lin_ap1_scene",
    display_id: None,
};

/// Spaces that images come in, though no scene names them.
const OF_IMAGES: [LinearSpace; 3] = [
    LinearSpace {
        primaries: Primaries::ADOBE_RGB,
        scene_id: "lin_adobergb_scene",
        display_id: None,
    },
    LinearSpace {
        primaries: Primaries::AP0,
        scene_id: "lin_ap0_scene",
        display_id: None,
    },
    LinearSpace {
        primaries: Primaries::XYZ,
        scene_id: "lin_ciexyzd65_scene",
        display_id: Some("lin_ciexyzd65_display"),
    },
];

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

    const fn facts(self) -> LinearSpace {
        match self {
            Self::Rec709 => REC709,
            Self::P3D65 => P3_D65,
            Self::Rec2020 => REC2020,
            Self::AcesCg => ACES_CG,
        }
    }

    /// Its primaries and white.
    pub const fn primaries(self) -> Primaries {
        self.facts().primaries
    }

    /// The identifier that the ASWF Color Interop Forum gives it, as `colorInteropID` of an EXR holds it.
    pub const fn interop_id(self) -> &'static str {
        self.facts().scene_id
    }
}

impl Primaries {
    /// Those of a linear space by its identifier: all of those of the ASWF Color Interop Forum, of scenes and of
    /// displays.
    pub fn of_interop_id(id: &str) -> Option<Self> {
        let of_scenes = ColorSpace::ALL.map(ColorSpace::facts);
        let mut spaces = of_scenes.iter().chain(&OF_IMAGES);
        let found = spaces.find(|space| space.scene_id == id || space.display_id == Some(id));
        found.map(|space| space.primaries)
    }
}

#[cfg(test)]
mod tests {
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
        let spaces = ColorSpace::ALL.map(ColorSpace::facts);
        let all: Vec<&LinearSpace> = spaces.iter().chain(&OF_IMAGES).collect();
        for (place, one) in all.iter().enumerate() {
            for other in &all[..place] {
                assert_ne!(one.scene_id, other.scene_id);
                assert_ne!(one.primaries, other.primaries, "{}", one.scene_id);
            }
        }
    }
}
