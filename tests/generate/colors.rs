//! Values for light and color in every notation, within the reach of the scene that they are for.

use std::f64::consts::PI;
use std::fmt::Write;
use std::fs;

use candela::scene::ColorSpace;
use candela::spectrum::Illuminant;

use super::Draft;

/// Luminous intensity of a radiant one in the middle of the visible, about, in lm/W.
const EFFICACY: f64 = 200.0;

/// What the values of a scene are, and how its light is carried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Palette {
    /// Triples of Rec.709.
    Rec709,
    /// Triples of any space, in any space.
    Rgb,
    /// The same, carried spectrally.
    Upsampled,
    /// Values of every kind.
    Spectral,
    /// Values of every kind, carried as RGB.
    Flattened,
}

impl Palette {
    pub(super) const ALL: [Self; 8] = [
        Self::Rec709,
        Self::Rec709,
        Self::Rgb,
        Self::Upsampled,
        Self::Spectral,
        Self::Spectral,
        Self::Spectral,
        Self::Flattened,
    ];

    pub(super) fn has_spectra(self) -> bool {
        matches!(self, Self::Spectral | Self::Flattened)
    }

    /// Whether albedos are bounded wavelength by wavelength.
    fn is_carried_spectrally(self) -> bool {
        matches!(self, Self::Upsampled | Self::Spectral)
    }
}

impl Draft<'_> {
    /// The lines of `[image]` about color.
    pub(super) fn image_colors(&mut self) {
        let transport = match self.palette {
            Palette::Rec709 | Palette::Spectral => None,
            Palette::Rgb if self.random.chance(0.5) => None,
            Palette::Rgb | Palette::Flattened => Some("rgb"),
            Palette::Upsampled => Some("spectral"),
        };
        if let Some(transport) = transport {
            let _ = writeln!(self.text, "transport = \"{transport}\"");
        }
        if self.palette != Palette::Rec709 {
            let space = self.random.choice(&ColorSpace::ALL).name();
            let _ = writeln!(self.text, "color_space = \"{space}\"");
            let observer = self.random.choice(&["1931", "1931", "1964"]);
            let _ = writeln!(self.text, "observer = \"{observer}\"");
        }
        let background = self.background();
        let _ = writeln!(self.text, "background = {background}\n");
    }

    fn background(&mut self) -> String {
        let in_triples = ["0", "0.25", "[0.1, 0.2, 0.4]", "\"#204060\""];
        if self.palette == Palette::Rec709 {
            return self.random.choice(&in_triples).to_owned();
        }
        match self.random.count(0, 6) {
            0 if self.palette.has_spectra() => {
                let power = 0.3 / EFFICACY;
                self.lines(power)
            }
            1 | 2 if self.palette.has_spectra() => self.curve(1e-4),
            3 => self.triple_of_any_space(0.3),
            _ => self.random.choice(&in_triples).to_owned(),
        }
    }

    /// A reflectance of at most `most` in every channel or at every wavelength.
    pub(super) fn reflectance(&mut self, most: f64) -> String {
        // The spectrum of a triple, however dark, may come near 1 at the ends of the visible.
        let kinds = if self.palette.is_carried_spectrally() && most < 1.0 {
            [0, 0, 4]
        } else {
            [1, 2, 3]
        };
        let kind = match self.random.count(0, 3) {
            0 if self.palette.has_spectra() => 4,
            0 => 0,
            _ => self.random.choice(&kinds),
        };
        match kind {
            1 => self.triple(most),
            2 if self.palette == Palette::Rec709 => {
                let rgb = [(); 3].map(|()| self.random.between(0.0, most));
                format!("{{ rgb = {rgb:?}, space = \"rec709\" }}")
            }
            2 => self.triple_of_any_space(most),
            // sRGB codes are never below the linear value.
            3 => {
                let [r, g, b] = [(); 3].map(|()| (self.random.between(0.0, most) * 255.0) as u8);
                format!("\"#{r:02x}{g:02x}{b:02x}\"")
            }
            4 if self.palette.has_spectra() => {
                // In RGB a saturated curve has a channel that is larger than the curve.
                self.curve(0.6 * most)
            }
            _ => format!("{:?}", self.random.between(0.0, most)),
        }
    }

    /// k_s, of any size.
    pub(super) fn highlight(&mut self) -> String {
        if self.random.chance(0.3) {
            // Clearly beyond what a reflectance can be.
            let rgb = [(); 3].map(|()| self.random.between(1.5, 3.0));
            return format!("{rgb:?}");
        }
        self.reflectance(1.0)
    }

    /// A light's intensity of about so many candela.
    pub(super) fn intensity(&mut self, candela: f64) -> String {
        let kind = match self.palette {
            Palette::Rec709 => self.random.count(0, 2),
            Palette::Rgb | Palette::Upsampled => self.random.count(0, 5),
            Palette::Spectral | Palette::Flattened => self.random.count(1, 14),
        };
        let (watts, sphere) = (candela / EFFICACY, 4.0 * PI);
        match kind {
            0 => format!("{candela:?}"),
            1 => {
                let rgb = [(); 3].map(|()| candela * self.random.between(0.1, 1.0));
                format!("{rgb:?}")
            }
            2 => "\"#ffcc88\"".to_owned(),
            3 => self.triple_of_any_space(candela),
            4 => self.sized("candela", candela, Self::triple_color),
            5 => self.sized("lumens", sphere * candela, Self::triple_color),
            6 => self.sized("watts_per_steradian", watts, Self::triple_color),
            7 => self.curve(watts / 100.0),
            8 => self.lines(watts),
            9 => format!("{{ watts_per_steradian_nm = {:?} }}", watts / 200.0),
            10 => {
                let curve = self.curve(watts / 100.0);
                format!("{{ watts_per_steradian_nm = {curve} }}")
            }
            11 => self.sized("watts", sphere * watts, Self::spectral_color),
            12 => self.sized("watts_per_steradian", watts, Self::spectral_color),
            13 => self.sized("lumens", sphere * candela, Self::spectral_color),
            _ => self.sized("candela", candela, Self::spectral_color),
        }
    }

    fn sized(&mut self, unit: &str, amount: f64, color: fn(&mut Self) -> String) -> String {
        let color = color(self);
        format!("{{ {unit} = {amount:?}, color = {color} }}")
    }

    fn triple_color(&mut self) -> String {
        let triple = self.triple_of_any_space(1.0);
        self.random
            .choice(&[
                "1",
                "[1, 0.5, 0.25]",
                "[0, 0.2, 0.1]",
                "\"#ffe0a0\"",
                &triple,
            ])
            .to_owned()
    }

    fn spectral_color(&mut self) -> String {
        match self.random.count(0, 7) {
            0..=2 => {
                let name = self.random.choice(&Illuminant::ALL).name();
                format!("{{ illuminant = \"{name}\" }}")
            }
            3 => format!(
                "{{ daylight = {:?} }}",
                self.random.between(4000.0, 25_000.0)
            ),
            4 | 5 => format!(
                "{{ blackbody = {:?} }}",
                self.random.log_between(500.0, 1e5)
            ),
            6 => self.curve(1.0),
            _ => self.lines(1.0),
        }
    }

    /// `[r, g, b]` of any hue, each from 0 to `most`.
    fn triple(&mut self, most: f64) -> String {
        format!("{:?}", [(); 3].map(|()| self.random.between(0.0, most)))
    }

    /// A color so pale that every space holds it, at most `most` in each of them.
    fn triple_of_any_space(&mut self, most: f64) -> String {
        let rgb = [(); 3].map(|()| most * self.random.between(0.5, 0.75));
        let space = self.random.choice(&ColorSpace::ALL).name();
        format!("{{ rgb = {rgb:?}, space = \"{space}\" }}")
    }

    /// Points anywhere from the ultraviolet to the infrared, with values up to `most`, in the scene
    /// or in a file.
    fn curve(&mut self, most: f64) -> String {
        let points = self.random.count(2, 12);
        let mut nm = self.random.between(300.0, 450.0);
        let (mut wavelengths, mut values) = (Vec::new(), Vec::new());
        for point in 0..points {
            // A curve beside the range on which light is computed is an error.
            if point + 1 == points && nm < 360.0 {
                nm = self.random.between(360.0, 830.0);
            }
            wavelengths.push(nm);
            // At times just beside, at times far away.
            nm += self.random.log_between(0.1, 150.0);
            // Nowhere black: a light of a color must have one.
            values.push(most * self.random.between(0.01, 1.0));
        }
        if self.random.chance(0.5) {
            return format!("{{ wavelengths = {wavelengths:?}, values = {values:?} }}");
        }
        let mut text = "nm,value\n".to_owned();
        for (nm, value) in wavelengths.iter().zip(&values) {
            let _ = writeln!(text, "{nm:?},{value:?}");
        }
        let file = format!("curve-{}-{}.csv", self.seed, self.curve_files);
        self.curve_files += 1;
        fs::write(self.folder.join(&file), text).unwrap();
        format!("{{ file = \"{file}\" }}")
    }

    /// One to five lines with `power` in all, about.
    fn lines(&mut self, power: f64) -> String {
        let count = self.random.count(1, 5);
        let lines: Vec<[f64; 2]> = (0..count)
            .map(|_| {
                let nm = self.random.between(420.0, 680.0);
                // Also in the middle of the grid's wavelengths.
                let nm = if self.random.chance(0.3) {
                    nm.round()
                } else {
                    nm
                };
                [nm, power * self.random.between(0.2, 1.0)]
            })
            .collect();
        format!("{{ lines = {lines:?} }}")
    }
}
