//! Values for light and color: from every notation to the working space, or to spectra.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::Arc;

use super::{Builder, Reported, as_written, listed};
use crate::color::Primaries;
use crate::scene::{ColorSpace, Problem, Spanned, Unit, Value};
use crate::spectrum::{Curve, Spectrum, blackbody, daylight};
use crate::world::colorimetry::{SpectralReflectance, converted};

/// The temperatures in K of black bodies: below, no more than one part in 10⁹ of the radiation is
/// visible; above, its color no longer changes.
const BLACKBODY: [f64; 2] = [500.0, 1e6];

/// The temperatures in K for which daylight is defined (CIE 15:2018).
const DAYLIGHT: [f64; 2] = [4000.0, 25_000.0];

/// Light as the world carries it.
#[derive(Clone, Debug)]
pub(super) struct Emission {
    /// In the working space.
    pub(super) rgb: [f64; 3],
    /// Per nm; only where light is carried spectrally.
    pub(super) spectrum: Option<Spectrum>,
}

/// A reflectance as the world carries it.
#[derive(Clone, Debug)]
pub(super) struct Reflection {
    /// Under white light, in the working space.
    pub(super) rgb: [f64; 3],
    /// Of every curve, and of RGB values where light is carried spectrally.
    pub(super) reflectance: Option<SpectralReflectance>,
}

/// How large a reflectance may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Bound {
    /// At most 1: k_d, or an albedo.
    Albedo,
    /// Without: a narrow lobe with a large k_s still reflects little in all.
    None,
}

impl Emission {
    const DARK: Self = Self {
        rgb: [0.0; 3],
        spectrum: None,
    };
}

impl Reflection {
    const BLACK: Self = Self {
        rgb: [0.0; 3],
        reflectance: None,
    };

    pub(super) fn is_black(&self) -> bool {
        self.rgb == [0.0; 3]
            && self
                .reflectance
                .as_ref()
                .is_none_or(SpectralReflectance::is_black)
    }

    pub(super) fn is_gray(&self) -> bool {
        self.rgb[0] == self.rgb[1] && self.rgb[1] == self.rgb[2]
    }
}

/// The spectra found for colors so far: scenes have few colors and many materials.
#[derive(Default)]
pub(super) struct KnownReflectances {
    known: HashMap<([u64; 3], Option<Bound>), Option<SpectralReflectance>>,
    out_of_reach: usize,
}

/// Errors of one kind that are enough to mend a scene by.
const MOST_OUT_OF_REACH: usize = 100;

impl KnownReflectances {
    /// What stands for a color, as a reflectance within a bound or as light. After many colors out of
    /// reach, each of which takes long to give up, no more are looked for.
    fn of(
        &mut self,
        rgb: [f64; 3],
        bound: Option<Bound>,
        find: impl FnOnce() -> Option<SpectralReflectance>,
    ) -> Result<Option<SpectralReflectance>, Reported> {
        let key = (rgb.map(f64::to_bits), bound);
        if let Some(known) = self.known.get(&key) {
            return Ok(known.clone());
        }
        if self.out_of_reach == MOST_OUT_OF_REACH {
            return Err(Reported);
        }
        let found = find();
        self.out_of_reach += usize::from(found.is_none());
        self.known.insert(key, found.clone());
        Ok(found)
    }
}

/// What was made of curves so far, by their places in memory: one file of a million points may be
/// what a million values name.
#[derive(Default)]
pub(super) struct Curves(HashMap<usize, OnGrid>);

/// A curve on the grid.
struct OnGrid {
    spectrum: Arc<Spectrum>,
    /// [`Curve::peak`]
    peak: Option<(f64, f64)>,
}

impl Curves {
    fn of(&mut self, curve: &Arc<Curve>) -> &OnGrid {
        let place = Arc::as_ptr(curve).addr();
        self.0.entry(place).or_insert_with(|| OnGrid {
            spectrum: Arc::new(curve.spectrum()),
            peak: curve.peak(),
        })
    }
}

/// A number or triple as written, in its own space.
struct Literal {
    rgb: [f64; 3],
    space: ColorSpace,
}

impl Literal {
    /// `None` for what is not said as RGB.
    fn of(value: &Value) -> Option<Self> {
        let (rgb, space) = value.linear()?;
        Some(Self { rgb, space })
    }

    fn is_legal(&self) -> bool {
        let legal = |channel: &f64| (0.0..=f64::from(f32::MAX)).contains(channel);
        self.rgb.iter().all(legal)
    }

    /// In another space. Gray stays gray to the bit, and what is within it but for a rounding
    /// stays within.
    fn within(&self, space: ColorSpace) -> [f64; 3] {
        let [r, g, b] = self.rgb;
        if r == g && g == b {
            return self.rgb;
        }
        let brightest = r.max(g).max(b);
        converted(self.rgb, self.space, space).map(|channel| {
            if channel.abs() <= ROUNDING * brightest {
                0.0
            } else {
                channel
            }
        })
    }

    /// The luminance where R = G = B = 1 has 1.
    fn luminance(&self) -> f64 {
        let weights = Primaries::REC709.luminance_weights();
        let rgb = self.within(ColorSpace::Rec709);
        weights.iter().zip(rgb).map(|(w, c)| w * c).sum()
    }
}

/// Channels that differ by no more than this, relatively, are one number after 471 additions each.
const WHITE: f64 = 1e-12;

/// What the matrices from space to space leave of a zero.
const ROUNDING: f64 = 1e-14;

impl Builder<'_> {
    /// The intensity of a light, or the background's radiance; dark after an error.
    pub(super) fn emission(
        &mut self,
        key: &'static str,
        written: &Spanned<Value>,
        spread: Spread,
    ) -> Emission {
        let emission = match &written.value {
            Value::Sized {
                unit,
                amount,
                color,
            } => self.sized(written, *unit, *amount, color, spread),
            Value::Mixed(mixture) => self.mixed_light(key, written, mixture, spread),
            value => match Literal::of(value) {
                Some(literal) => self
                    .literal(key, written, &literal)
                    .and_then(|rgb| self.literal_light(key, written, &literal, rgb)),
                None => self
                    .light_spectrum(key, written, value)
                    .map(|spectrum| self.spectral_light(spectrum)),
            },
        };
        let emission = emission.unwrap_or(Emission::DARK);
        // As a range, which holds no NaN: sums that overflow in both directions are one.
        let legal = |channel: &f64| (0.0..=f64::from(f32::MAX)).contains(&channel.abs());
        if !emission.rgb.iter().all(legal) {
            let expected = "light of at most 3.4e38 in every channel";
            self.out_of_range(key, written.span, listed(&emission.rgb), expected);
            return Emission::DARK;
        }
        emission
    }

    /// A reflectance; black after an error.
    pub(super) fn reflection(
        &mut self,
        key: &'static str,
        written: &Spanned<Value>,
        bound: Bound,
    ) -> Reflection {
        if let Value::Mixed(mixture) = &written.value {
            let mixed = self.mixed_reflection(key, written, mixture, bound);
            return mixed.unwrap_or(Reflection::BLACK);
        }
        let reflection = match Literal::of(&written.value) {
            Some(literal) => self
                .literal(key, written, &literal)
                .and_then(|rgb| self.literal_reflection(key, written, &literal, rgb, bound)),
            None => self
                .shared_spectrum(key, written)
                .and_then(|spectrum| self.curve_reflection(key, written, spectrum, bound)),
        };
        reflection.unwrap_or(Reflection::BLACK)
    }

    /// A literal in the working space, where that can hold it.
    fn literal(
        &mut self,
        key: &'static str,
        written: &Spanned<Value>,
        literal: &Literal,
    ) -> Result<[f64; 3], Reported> {
        if !literal.is_legal() {
            let (value, expected) = if let Value::Uniform(value) = written.value {
                (as_written(value), "a number from 0 to 3.4e38")
            } else {
                (listed(&literal.rgb), "three numbers from 0 to 3.4e38")
            };
            self.out_of_range(key, written.span, value, expected);
            return Err(Reported);
        }
        let working = self.scene.image.color_space.value;
        let rgb = literal.within(working);
        if self.colorimetry_of_spectra().is_none() && rgb.iter().any(|&channel| channel < 0.0) {
            let conflict = format!(
                "`{key}` is outside of {working}, where it would be {value}; expected a color \
                 that the working space holds, or `color_space = \"{space}\"` in `[image]`",
                working = working.name(),
                value = listed(&rounded(rgb)),
                space = literal.space.name(),
            );
            self.report(written.span, Problem::Conflict(conflict));
            return Err(Reported);
        }
        Ok(rgb)
    }

    fn literal_light(
        &mut self,
        key: &'static str,
        written: &Spanned<Value>,
        literal: &Literal,
        rgb: [f64; 3],
    ) -> Result<Emission, Reported> {
        let Some(colorimetry) = self.colorimetry_of_spectra() else {
            return Ok(Emission {
                rgb,
                spectrum: None,
            });
        };
        let reflectance = self
            .reflectances
            .of(rgb, None, || colorimetry.unbounded(rgb))?;
        let spectrum = reflectance.map(|reflectance| reflectance.of(colorimetry.white()));
        let Some(spectrum) = spectrum else {
            return Err(self.out_of_reach(key, written, literal, "light"));
        };
        Ok(Emission {
            rgb,
            spectrum: Some(spectrum),
        })
    }

    fn literal_reflection(
        &mut self,
        key: &'static str,
        written: &Spanned<Value>,
        literal: &Literal,
        rgb: [f64; 3],
        bound: Bound,
    ) -> Result<Reflection, Reported> {
        let above = |rgb: &[f64; 3]| rgb.iter().any(|&channel| channel > 1.0 + ROUNDING);
        let colorimetry = self.colorimetry_of_spectra();
        if bound == Bound::Albedo && (above(&literal.rgb) || colorimetry.is_none() && above(&rgb)) {
            let expected = "at most 1 in every channel";
            self.out_of_range(key, written.span, listed(&rgb), expected);
            return Err(Reported);
        }
        let Some(colorimetry) = colorimetry else {
            return Ok(Reflection {
                rgb,
                reflectance: None,
            });
        };
        let reflectance = self.reflectances.of(rgb, Some(bound), || match bound {
            Bound::Albedo => colorimetry.reflectance_of(rgb),
            Bound::None => colorimetry
                .reflectance_of(rgb)
                .or_else(|| colorimetry.unbounded(rgb)),
        })?;
        if reflectance.is_none() {
            return Err(self.out_of_reach(key, written, literal, "reflectance"));
        }
        Ok(Reflection { rgb, reflectance })
    }

    fn curve_reflection(
        &mut self,
        key: &'static str,
        written: &Spanned<Value>,
        spectrum: Arc<Spectrum>,
        bound: Bound,
    ) -> Result<Reflection, Reported> {
        let (mut peak, mut nm) = spectrum.peak();
        // Of a curve finer than the grid, the points say more than the means.
        if let Value::Curve(curve) = &written.value
            && let Some((value, place)) = self.curves.of(curve).peak
            && value > peak
        {
            (peak, nm) = (value, place);
        }
        let (most, expected) = match bound {
            Bound::Albedo => (1.0, "at most 1 at every wavelength"),
            Bound::None => (f64::from(f32::MAX), "at most 3.4e38 at every wavelength"),
        };
        if peak > most {
            let value = format!("{} at {nm} nm", as_written(peak));
            self.out_of_range(key, written.span, value, expected);
            return Err(Reported);
        }
        Ok(Reflection {
            rgb: self.colorimetry.reflectance(&spectrum),
            reflectance: Some(SpectralReflectance::Spectrum(spectrum)),
        })
    }

    /// What an albedo is at each wavelength; `None` if no smooth spectrum has its color.
    pub(super) fn by_wavelength(&mut self, albedo: &Reflection) -> Option<SpectralReflectance> {
        if albedo.reflectance.is_some() {
            return albedo.reflectance.clone();
        }
        let colorimetry = Arc::clone(&self.colorimetry);
        let find = || colorimetry.reflectance_of(albedo.rgb);
        let found = self.reflectances.of(albedo.rgb, Some(Bound::Albedo), find);
        found.ok().flatten()
    }

    fn out_of_reach(
        &mut self,
        key: &'static str,
        written: &Spanned<Value>,
        literal: &Literal,
        what: &str,
    ) -> Reported {
        let conflict = format!(
            "`{key}` is {value} in {space}, more saturated than any smooth {what}; expected a \
             color within reach, a curve of `wavelengths` and `values`, or `transport = \"rgb\"`",
            value = listed(&literal.rgb.map(six_digits)),
            space = literal.space.name(),
        );
        self.report(written.span, Problem::Conflict(conflict));
        Reported
    }

    fn spectral_light(&self, spectrum: Spectrum) -> Emission {
        let [r, g, b] = self.colorimetry.light(&spectrum);
        let (least, most) = (r.min(g).min(b), r.max(g).max(b));
        // Sums differ in their last digits; white is white to the bit.
        let is_white = most - least <= WHITE * most;
        Emission {
            rgb: if is_white { [g; 3] } else { [r, g, b] },
            spectrum: self.colorimetry_of_spectra().map(|_| spectrum),
        }
    }

    /// A light of a color and a size in a unit.
    fn sized(
        &mut self,
        written: &Spanned<Value>,
        unit: Unit,
        amount: f64,
        color: &Value,
        spread: Spread,
    ) -> Result<Emission, Reported> {
        if !(0.0..=f64::from(f32::MAX)).contains(&amount) {
            let expected = "a number from 0 to 3.4e38";
            self.out_of_range(unit.name(), written.span, as_written(amount), expected);
            return Err(Reported);
        }
        let key = "color";
        let per_steradian = spread.per_steradian(unit, amount);
        match (Literal::of(color), unit) {
            (Some(literal), Unit::Candela | Unit::Lumens | Unit::Lux) => {
                let of_color = self.literal(key, written, &literal)?;
                let size = self.share(written, per_steradian, literal.luminance())?;
                let [r, g, b] = of_color;
                let rgb = if r == g && g == b {
                    // To the bit what `intensity = [100, 100, 100]` is.
                    [per_steradian; 3]
                } else {
                    of_color.map(|channel| channel * size)
                };
                self.literal_light(key, written, &literal, rgb)
            }
            (literal, _) => {
                let spectrum = match literal {
                    Some(literal) => {
                        let rgb = self.literal(key, written, &literal)?;
                        let colorimetry = Arc::clone(&self.colorimetry);
                        let find = || colorimetry.unbounded(rgb);
                        let Some(reflectance) = self.reflectances.of(rgb, None, find)? else {
                            return Err(self.out_of_reach(key, written, &literal, "light"));
                        };
                        reflectance.of(self.colorimetry.white())
                    }
                    None => self.light_spectrum(key, written, color)?,
                };
                let whole = match unit {
                    Unit::Candela | Unit::Lumens | Unit::Lux => {
                        self.colorimetry.luminous(&spectrum)
                    }
                    Unit::WattsPerSteradian | Unit::Watts => spectrum.total(),
                    Unit::Nits => todo!(),
                };
                let size = self.share(written, per_steradian, whole)?;
                Ok(self.spectral_light(spectrum.scaled(size)))
            }
        }
    }

    /// By how much a color that is `whole` in a unit is scaled to be `wanted`.
    fn share(
        &mut self,
        written: &Spanned<Value>,
        wanted: f64,
        whole: f64,
    ) -> Result<f64, Reported> {
        if wanted == 0.0 && whole == 0.0 {
            // A lamp that is off, said twice.
            return Ok(0.0);
        }
        let share = wanted / whole;
        if whole.is_finite() && share.is_finite() {
            return Ok(share);
        }
        let conflict = if whole > 0.0 {
            "`color` is too bright or too dark to compute with, expected values near 1"
        } else {
            "`color` is black, expected a color that light can have"
        };
        self.report(written.span, Problem::Conflict(conflict.to_owned()));
        Err(Reported)
    }

    /// The spectrum of what is not a literal; those of one curve are one.
    fn shared_spectrum(
        &mut self,
        key: &'static str,
        written: &Spanned<Value>,
    ) -> Result<Arc<Spectrum>, Reported> {
        match &written.value {
            Value::Curve(curve) => Ok(Arc::clone(&self.curves.of(curve).spectrum)),
            value => self.light_spectrum(key, written, value).map(Arc::new),
        }
    }

    /// The spectrum of what is not a literal, on the grid.
    fn light_spectrum(
        &mut self,
        key: &'static str,
        written: &Spanned<Value>,
        value: &Value,
    ) -> Result<Spectrum, Reported> {
        let mut within = |[lowest, highest]: [f64; 2], name, temperature: f64| {
            if (lowest..=highest).contains(&temperature) {
                return Ok(temperature);
            }
            let expected = format!("a temperature from {lowest} to {highest} K");
            self.out_of_range(name, written.span, as_written(temperature), &expected);
            Err(Reported)
        };
        match value {
            Value::Illuminant(illuminant) => Ok(illuminant.spectrum()),
            Value::Daylight(t) => within(DAYLIGHT, "daylight", *t).map(daylight),
            Value::Blackbody(t) => within(BLACKBODY, "blackbody", *t).map(blackbody),
            Value::Curve(curve) => Ok(Spectrum::clone(&self.curves.of(curve).spectrum)),
            Value::Lines(lines) => Ok(lines.spectrum()),
            Value::Uniform(_)
            | Value::Rgb { .. }
            | Value::Srgb(_)
            | Value::Sized { .. }
            | Value::Mixed(_) => {
                // The reader lets sizes stand only where a light is, and literals are none.
                let conflict = format!("`{key}` cannot hold a size within a size");
                self.report(written.span, Problem::Conflict(conflict));
                Err(Reported)
            }
        }
    }
}

/// To six digits, for messages: hexadecimal codes become long numbers.
fn six_digits(number: f64) -> f64 {
    format!("{number:.5e}").parse().unwrap_or(number)
}

/// To six decimals, for messages.
fn rounded(rgb: [f64; 3]) -> [f64; 3] {
    rgb.map(|channel| (channel * 1e6).round() / 1e6)
}

/// Into how many sr the flux of a light goes: its flux in lm over its intensity in cd.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spread(pub(super) f64);

impl Spread {
    /// Of a point light: evenly into all directions, 4π sr.
    pub(super) const EVERYWHERE: Self = Self(4.0 * PI);

    /// An amount of light per steradian.
    fn per_steradian(self, unit: Unit, amount: f64) -> f64 {
        match unit {
            Unit::Candela | Unit::WattsPerSteradian | Unit::Lux => amount,
            Unit::Lumens | Unit::Watts => amount / self.0,
            Unit::Nits => todo!(),
        }
    }
}
