//! What was done with a picture, what was noticed, and what the user may want to change.

use super::{Screen, View, exposure};

/// What was done with a picture, and what was noticed.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// The exposure in EV.
    pub ev: f64,
    /// Whether it was chosen from the picture.
    pub is_auto: bool,
    /// How radiance became light.
    pub view: View,
    /// What the picture is shown on.
    pub screen: Screen,
    /// Width and height of what was written.
    pub resolution: [u32; 2],
    /// The largest luminance Y of a pixel as the file has it, before the exposure, in Rec.709, RGB divided
    /// by A where alpha is kept: cd/m² in candela's files. Infinite values do not count. 0
    /// where there is no light.
    pub brightest: f64,
    /// Whether nothing can be seen in the picture: no channel of a pixel is shown at 2 % of the screen's white.
    pub is_black: bool,
    /// The luminance, as [`Report::brightest`] is one, that is shown as the screen's white. Infinite under a view that
    /// does not clip.
    pub white: f64,
    /// The luminance above which a picture clips: that of white, unless the screen has codes for brighter light and
    /// the view uses them.
    pub peak: f64,
    /// The share of the picture's pixels, 0 to 1, of which a channel is brighter than the peak and clips. 0 under a view
    /// that does not clip.
    pub clipped: f64,
    /// What the user should know about the file, a sentence each.
    pub warnings: Vec<String>,
    /// What was taken for granted, a sentence each.
    pub notes: Vec<String>,
}

/// Light below this, of which 1 is white, is coded below 39 of 255 in sRGB: where nothing is brighter, there is nothing
/// to see.
#[doc(hidden)]
pub const LOOKS_BLACK: f64 = 0.02;

/// A larger share of clipped pixels is more than highlights.
#[doc(hidden)]
pub const MANY_CLIPPED: f64 = 0.05;

impl Report {
    /// The exposure as it is shown, such as `-1.250 EV`; what rounds to 0 has no sign.
    pub fn exposure(&self) -> String {
        shown_exposure(self.ev)
    }

    /// What to try where the picture is black.
    pub fn way_out_of_black(&self) -> String {
        // What becomes white, exposed.
        let white = self.white * exposure::scale(self.ev);
        let white = if white.is_finite() { white } else { 1.0 };
        let exposure = format!("try --exposure {:.0}", (white / self.brightest).log2());
        match self.view {
            // The automatic one is for views of which 1 is white, and for light.
            View::Absolute | View::Raw => exposure,
            // Of a range in cd/m² no exposure changes what is below.
            View::FalseColor => {
                "try a range that begins lower, by --view false-color=FROM:TO".to_owned()
            }
            View::Srgb
            | View::Reinhard
            | View::ReinhardExtended
            | View::Hable
            | View::AcesFit
            | View::AcesFitHill
            | View::PbrNeutral
            | View::Agx
            | View::Aces1
            | View::Aces2
            | View::Cube => {
                // What is so faint, or has no coverage, does not count for the automatic one.
                if self.is_auto || self.brightest <= exposure::DELTA {
                    exposure
                } else {
                    "try --auto-exposure".to_owned()
                }
            }
        }
    }

    /// What to try where much of the picture clips.
    pub fn way_out_of_clipping(&self) -> String {
        match self.view {
            View::Raw => "try a lower --exposure".to_owned(),
            View::Absolute if self.screen.is_hdr() => {
                "try a lower --exposure, or another --view".to_owned()
            }
            View::Absolute => {
                "try a larger --white-nits, a lower --exposure, or another --view".to_owned()
            }
            View::Srgb
            | View::Reinhard
            | View::ReinhardExtended
            | View::Hable
            | View::AcesFit
            | View::AcesFitHill
            | View::PbrNeutral
            | View::Agx
            | View::Aces1
            | View::Aces2
            | View::FalseColor
            | View::Cube => {
                if self.is_auto {
                    format!("try --view reinhard, or an --exposure below {:.1}", self.ev)
                } else {
                    "try --auto-exposure, a lower --exposure, or --view reinhard".to_owned()
                }
            }
        }
    }

    /// What there is to say of a picture that is black or blown out, with the way out; a sentence
    /// each.
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        remarks.extend(self.of_darkness());
        if self.clipped >= MANY_CLIPPED {
            remarks.push(format!(
                "{:.0} % of the picture {} and clips; {}",
                100.0 * self.clipped,
                self.too_bright(),
                self.way_out_of_clipping(),
            ));
        }
        remarks
    }

    fn of_darkness(&self) -> Option<String> {
        if !self.is_black {
            return None;
        }
        if self.brightest == 0.0 {
            let nothing = if self.view == View::Raw {
                "no pixel has numbers above 0"
            } else {
                "no pixel has any light"
            };
            return Some(format!("the picture is black: {nothing}"));
        }
        let what = if self.view == View::Raw {
            "its numbers, as code values, are all close to 0".to_owned()
        } else if self.white.is_finite() {
            format!(
                "its brightest pixel has a luminance of {}, where the screen's white is {}",
                digits(self.brightest),
                digits(self.white)
            )
        } else {
            format!(
                "its brightest pixel has a luminance of {}, which the view `{}` shows as black",
                digits(self.brightest),
                self.view
            )
        };
        Some(format!(
            "the picture is black: {what}; {}",
            self.way_out_of_black()
        ))
    }

    fn too_bright(&self) -> &'static str {
        match self.view {
            View::Raw => "has numbers above 1, the largest code value,",
            View::Srgb | View::Absolute => "is brighter than the screen",
            View::Reinhard
            | View::ReinhardExtended
            | View::Hable
            | View::AcesFit
            | View::AcesFitHill
            | View::PbrNeutral
            | View::Agx
            | View::Aces1
            | View::Aces2
            | View::FalseColor
            | View::Cube => "is brighter than what the view shows as white",
        }
    }
}

/// An exposure as it is shown, such as `-1.250 EV`; what rounds to 0 has no sign.
#[doc(hidden)]
pub fn shown_exposure(ev: f64) -> String {
    let thousandths = (ev * 1000.0).round();
    // −0 + 0 is 0.
    format!("{:.3} EV", thousandths / 1000.0 + 0.0)
}

/// About two significant digits of a number above 0, without an exponent where that is short.
#[doc(hidden)]
pub fn digits(number: f64) -> String {
    let magnitude = number.log10().floor();
    match magnitude {
        -5.0..1.0 => {
            let decimals = (1.0 - magnitude) as usize;
            let text = format!("{number:.decimals$}");
            let text = text.trim_end_matches('0');
            text.trim_end_matches('.').to_owned()
        }
        1.0..=6.0 => format!("{number:.0}"),
        _ => format!("{number:.1e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (number, expected) in [
            (0.000_31, "0.00031"),
            (0.000_3, "0.0003"),
            (0.019, "0.019"),
            (1.0, "1"),
            (2.54, "2.5"),
            (10.0, "10"),
            (9.96, "10"),
            (16.0, "16"),
            (1024.0, "1024"),
            (3.2e-9, "3.2e-9"),
            (1e20, "1.0e20"),
            (0.0, "0.0e0"),
        ] {
            assert_eq!(digits(number), expected);
        }
    }

    const FAINT: Report = Report {
        ev: 0.0,
        is_auto: false,
        view: View::Srgb,
        screen: Screen::Srgb,
        resolution: [1, 1],
        brightest: 0.01,
        is_black: true,
        white: 1.0,
        peak: 1.0,
        clipped: 0.0,
        warnings: Vec::new(),
        notes: Vec::new(),
    };

    #[track_caller]
    fn assert_remark(report: &Report, expected: &str) {
        assert_eq!(report.remarks(), [expected]);
    }

    #[test]
    fn what_is_said_of_the_dark_goes_by_the_view() {
        let of = |view, white| Report {
            view,
            white,
            ..FAINT
        };
        assert_remark(
            &of(View::Agx, 16.0),
            "the picture is black: its brightest pixel has a luminance of 0.01, where the screen's white is 16; \
             try --auto-exposure",
        );
        assert_remark(
            &of(View::Reinhard, f64::INFINITY),
            "the picture is black: its brightest pixel has a luminance of 0.01, which the view `reinhard` shows as \
             black; try --auto-exposure",
        );
        // log2(80 / 0.01) is 12.97. The automatic one would make a gray of 0.18 cd/m².
        assert_remark(
            &of(View::Absolute, 80.0),
            "the picture is black: its brightest pixel has a luminance of 0.01, where the screen's white is 80; \
             try --exposure 13",
        );
        assert_remark(
            &of(View::Raw, 1.0),
            "the picture is black: its numbers, as code values, are all close to 0; try --exposure 7",
        );
        let colored = Report {
            is_black: false,
            ..of(View::FalseColor, f64::INFINITY)
        };
        assert_eq!(colored.remarks(), [""; 0]);
        assert_remark(
            &of(View::FalseColor, f64::INFINITY),
            "the picture is black: its brightest pixel has a luminance of 0.01, which the view `false-color` shows as \
             black; try a range that begins lower, by --view false-color=FROM:TO",
        );
        let nothing = Report {
            brightest: 0.0,
            ..of(View::Raw, 1.0)
        };
        assert_remark(
            &nothing,
            "the picture is black: no pixel has numbers above 0",
        );
    }

    #[test]
    fn what_is_said_of_the_bright_goes_by_the_view() {
        let of = |view, screen| Report {
            is_black: false,
            clipped: 0.5,
            view,
            screen,
            ..FAINT
        };
        for (view, screen, expected) in [
            (
                View::Srgb,
                Screen::Srgb,
                "50 % of the picture is brighter than the screen and clips; try --auto-exposure, a lower --exposure, or \
                 --view reinhard",
            ),
            (
                View::Agx,
                Screen::Srgb,
                "50 % of the picture is brighter than what the view shows as white and clips; try --auto-exposure, a lower \
                 --exposure, or --view reinhard",
            ),
            (
                View::Raw,
                Screen::Srgb,
                "50 % of the picture has numbers above 1, the largest code value, and clips; try a lower --exposure",
            ),
            (
                View::Absolute,
                Screen::Srgb,
                "50 % of the picture is brighter than the screen and clips; try a larger --white-nits, a lower --exposure, \
                 or another --view",
            ),
            (
                View::Absolute,
                Screen::Rec2020Pq,
                "50 % of the picture is brighter than the screen and clips; try a lower --exposure, or another --view",
            ),
        ] {
            assert_remark(&of(view, screen), expected);
        }
    }
}
