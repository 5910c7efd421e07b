//! What a file says about the color space of its R, G, B, and which of two statements counts.

use crate::color::Primaries;
use crate::color::adaptation::conversion;
use crate::printable::printable;

/// What a file says about the color space of its R, G, B.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ColorTag {
    /// The attribute `colorInteropID`.
    pub interop_id: Option<String>,
    /// The attribute `chromaticities`.
    pub chromaticities: Option<Primaries>,
}

/// What a [`ColorTag`] means.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorMeaning {
    /// The primaries of R, G, B, which are linear light. Rec.709 where a file says nothing, which is
    /// OpenEXR's default.
    pub primaries: Primaries,
    /// What is odd about the tag, as a sentence.
    pub warning: Option<String>,
    /// Whether the file says nothing of it.
    pub is_assumed: bool,
}

impl ColorMeaning {
    /// Whether R, G, B of both mean the same colors, as far as files are exact.
    pub fn is_same(&self, other: &Self) -> bool {
        agree(&self.primaries, &other.primaries)
    }
}

/// How far chromaticities in old files are off, as the Color Interop Forum has it.
const CHROMATICITY_TOLERANCE: f64 = 0.001;

impl ColorTag {
    /// The primaries that count.
    ///
    /// An identifier that is known says all, as the ASWF Color Interop Forum asks; but programs that
    /// do not know the attribute copy it from file to file while they convert the pixels, so
    /// chromaticities that contradict it count, since they are kept up to date. An identifier that is
    /// `unknown`, or is not known here, does not hide chromaticities.
    pub fn meaning(&self) -> ColorMeaning {
        let usable = |primaries: &Primaries| conversion(primaries, &Primaries::REC709).is_finite();
        let id = self.interop_id.as_deref();
        let known = id.and_then(Primaries::of_interop_id);
        let named = printable(id.unwrap_or_default());
        let (primaries, warning) = match (known, self.chromaticities) {
            _ if id == Some("data") => (
                Primaries::REC709,
                Some("the file says that its channels are data, not colors; they are shown as linear Rec.709".to_owned()),
            ),
            (Some(known), Some(found)) if !usable(&found) || agree(&known, &found) => (known, None),
            (Some(_), Some(found)) => (
                found,
                Some(format!(
                    "the file's colorInteropID, `{named}`, and its chromaticities, {}, contradict \
                     each other; the chromaticities count, since programs that do not know the \
                     identifier keep it when they convert",
                    listed(&found)
                )),
            ),
            (Some(known), None) => (known, None),
            (None, Some(found)) if usable(&found) => {
                let warning = match id {
                    None | Some("unknown") => None,
                    Some(_) => Some(format!(
                        "the file's color space, `{named}`, is not known; it is shown as linear \
                         light of its chromaticities, {}",
                        listed(&found)
                    )),
                };
                (found, warning)
            }
            (None, Some(found)) => (
                Primaries::REC709,
                Some(format!(
                    "the file's color space is that of the chromaticities {}; it is shown as \
                     linear Rec.709, without conversion",
                    listed(&found)
                )),
            ),
            (None, None) => {
                let warning = match id {
                    None | Some("unknown") => None,
                    Some(_) => Some(format!(
                        "the file's color space is `{named}`; it is shown as linear Rec.709, \
                         without conversion"
                    )),
                };
                (Primaries::REC709, warning)
            }
        };
        let primaries = if agree(&primaries, &Primaries::REC709) {
            Primaries::REC709
        } else if primaries.is_xyz() {
            Primaries::XYZ
        } else {
            primaries
        };
        ColorMeaning {
            primaries,
            warning,
            is_assumed: id.is_none() && self.chromaticities.is_none(),
        }
    }
}

/// Whether two spaces are one, as far as files are exact.
fn agree(a: &Primaries, b: &Primaries) -> bool {
    if a.is_xyz() && b.is_xyz() {
        return true;
    }
    let list = |p: &Primaries| [p.red, p.green, p.blue, p.white].into_iter().flatten();
    // As a range, which holds no NaN.
    list(a)
        .zip(list(b))
        .all(|(a, b)| (0.0..=CHROMATICITY_TOLERANCE).contains(&(a - b).abs()))
}

fn listed(primaries: &Primaries) -> String {
    let Primaries {
        red,
        green,
        blue,
        white,
    } = primaries;
    let [r, g, b, w] = [red, green, blue, white].map(|[x, y]| format!("({x:.4}, {y:.4})"));
    format!("R {r}, G {g}, B {b}, white {w}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tag(id: Option<&str>, chromaticities: Option<Primaries>) -> ColorTag {
        ColorTag {
            interop_id: id.map(str::to_owned),
            chromaticities,
        }
    }

    #[track_caller]
    fn assert_means(tag: &ColorTag, primaries: Primaries, warning: &str) {
        let meaning = tag.meaning();
        assert_eq!(meaning.primaries, primaries);
        let found = meaning.warning.unwrap_or_default();
        assert!(found.contains(warning), "{found}");
        assert_eq!(found.is_empty(), warning.is_empty(), "{found}");
    }

    #[test]
    fn identifiers() {
        assert_means(&ColorTag::default(), Primaries::REC709, "");
        assert_means(&tag(Some("lin_rec709_scene"), None), Primaries::REC709, "");
        assert_means(&tag(Some("unknown"), None), Primaries::REC709, "");
        assert_means(&tag(Some("lin_ap1_scene"), None), Primaries::AP1, "");
        assert_means(
            &tag(Some("lin_adobergb_scene"), None),
            Primaries::ADOBE_RGB,
            "",
        );
        assert_means(&tag(Some("lin_ciexyzd65_scene"), None), Primaries::XYZ, "");
        let other = tag(Some("g22_rec709_scene"), None);
        assert_means(
            &other,
            Primaries::REC709,
            "`g22_rec709_scene`; it is shown as linear Rec.709",
        );
        assert_means(
            &tag(Some("data"), None),
            Primaries::REC709,
            "data, not colors",
        );
        let hostile = tag(Some("\u{1b}[31m"), None);
        assert_means(&hostile, Primaries::REC709, r"`\u{1b}[31m`");
    }

    #[test]
    fn chromaticities() {
        let means = |chromaticities, primaries, warning| {
            assert_means(&tag(None, Some(chromaticities)), primaries, warning);
        };
        means(Primaries::P3_D65, Primaries::P3_D65, "");
        // Some writers round the white to four decimals of D65's own, others to f32.
        let rounded = Primaries {
            white: [0.31272, 0.32903],
            ..Primaries::REC709
        };
        means(rounded, Primaries::REC709, "");
        let xyz = Primaries {
            white: [f64::from(1.0_f32 / 3.0); 2],
            ..Primaries::XYZ
        };
        means(xyz, Primaries::XYZ, "");
        // Chromaticities of which no matrix can be made.
        for bad in [f64::NAN, 0.0] {
            let collapsed = Primaries {
                red: [bad, bad],
                blue: [bad, bad],
                ..Primaries::REC709
            };
            means(collapsed, Primaries::REC709, "without conversion");
        }
    }

    #[test]
    fn both() {
        let unknown = tag(Some("unknown"), Some(Primaries::AP1));
        assert_means(&unknown, Primaries::AP1, "");
        let other = tag(Some("studio_lin"), Some(Primaries::AP1));
        assert_means(&other, Primaries::AP1, "`studio_lin`, is not known");
        let same = tag(Some("lin_ap1_scene"), Some(Primaries::AP1));
        assert_means(&same, Primaries::AP1, "");
        let stale = tag(Some("lin_rec709_scene"), Some(Primaries::AP0));
        assert_means(&stale, Primaries::AP0, "contradict each other");
        let useless = Primaries {
            white: [0.0, 0.0],
            ..Primaries::REC709
        };
        assert_means(
            &tag(Some("lin_ap1_scene"), Some(useless)),
            Primaries::AP1,
            "",
        );
    }
}
