//! Values as written → components: RGB of the working space, or spectra.

use std::f64::consts::PI;

use super::colorimetry::{Colorimetry, converted, luminance};
use super::components::Components;
use super::spectrum::{blackbody, curve, daylight, flat, illuminant, lines};
use super::upsampling;
use super::vector::{Vector, scale};
use crate::scene::{
    ColorSpace, Entry, Image, Light, Material, Mixture, Scene, Transport, Unit, Value,
};

/// What the brightest channel of a color is made before its smooth reflectance is looked for, one
/// after the other until there is one: light has no upper limit, reflectances have.
const DIMMED: [f64; 5] = [0.5, 0.125, 0.031_25, 0.007_812_5, 0.001_953_125];

/// What a light of size 1 sends out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    /// In cd: of an area along its normal.
    pub(super) intensity: f64,
    /// In lm.
    pub(super) flux: f64,
}

/// How colors become components, and components what is seen.
#[derive(Clone, Debug)]
pub(super) struct Palette {
    /// The working space.
    space: ColorSpace,
    colorimetry: Colorimetry,
    /// The weights by which spectra are found for colors; `None` where light is carried as RGB.
    weights: Option<[Components; 3]>,
}

impl Palette {
    pub(super) fn new(scene: &Scene) -> Self {
        let Image {
            color_space,
            observer,
            ..
        } = &scene.image;
        let colorimetry = Colorimetry::new(observer.value, color_space.value);
        Self {
            space: color_space.value,
            weights: is_spectral(scene).then(|| colorimetry.weights()),
            colorimetry,
        }
    }

    /// Whether light is carried wavelength by wavelength.
    pub(super) fn is_spectral(&self) -> bool {
        self.weights.is_some()
    }

    /// A reflectance of 0.
    pub(super) fn black(&self) -> Components {
        self.reflectance(&Value::ZERO)
    }

    /// The intensity of a light that is the same in all directions, of which there are 4π sr, or the radiance of
    /// a background.
    pub(super) fn light(&self, value: &Value) -> Components {
        self.light_into(value, 4.0 * PI)
    }

    /// The intensity of a light whose flux goes into so many sr.
    pub(super) fn light_into(&self, value: &Value, directions: f64) -> Components {
        let intensity = 1.0;
        let flux = directions;
        self.sized(value, Extent { intensity, flux })
    }

    /// The size of a light of this extent.
    pub(super) fn sized(&self, value: &Value, extent: Extent) -> Components {
        match value {
            Value::Sized {
                unit,
                amount,
                color,
            } => self.sized_light(*unit, *amount, color, extent),
            Value::Mixed(mixture) => sum(mixture, |part| self.sized(part, extent)),
            color => match self.working_rgb(color) {
                Some(rgb) => self.colored_light(rgb),
                None => self.light_of_spectrum(spectrum(color)),
            },
        }
    }

    /// k_d, k_s, ρ_d or ρ_s
    pub(super) fn reflectance(&self, value: &Value) -> Components {
        if let Value::Mixed(mixture) = value {
            return sum(mixture, |part| self.reflectance(part));
        }
        let Some(rgb) = self.working_rgb(value) else {
            return self.of_spectrum(spectrum(value));
        };
        let Some(weights) = &self.weights else {
            return Components(rgb.to_vec());
        };
        if is_gray(rgb) {
            return flat(rgb[0]);
        }
        upsampling::reflectance(weights, rgb).unwrap_or_else(|| share_of_white(weights, rgb))
    }

    /// A reflectance whose spectrum is known.
    pub(super) fn of_spectrum(&self, spectrum: Components) -> Components {
        match self.weights {
            Some(_) => spectrum,
            None => Components(self.colorimetry.reflectance(&spectrum).to_vec()),
        }
    }

    /// The RGB of light.
    pub(super) fn seen(&self, light: &Components) -> [f64; 3] {
        match self.weights {
            Some(_) => self.colorimetry.light(light),
            None => triple(light),
        }
    }

    /// How far the RGB of light may be off whose components may be off by this: of spectra, whose signs are not known,
    /// by the sum of all wavelengths.
    pub(super) fn seen_error(&self, error: &Components) -> [f64; 3] {
        match self.weights {
            Some(_) => self.colorimetry.light_error(error),
            None => triple(error),
        }
    }

    /// The RGB of a reflectance under white light.
    pub(super) fn under_white(&self, reflectance: &Components) -> [f64; 3] {
        match self.weights {
            Some(_) => self.colorimetry.reflectance(reflectance),
            None => triple(reflectance),
        }
    }

    /// A literal in the working space; `None` for spectra.
    fn working_rgb(&self, value: &Value) -> Option<Vector> {
        let (rgb, space) = literal(value)?;
        Some(converted(rgb, space, self.space))
    }

    /// Light of this RGB: white light through a filter.
    fn colored_light(&self, rgb: Vector) -> Components {
        match &self.weights {
            Some(weights) => self.filtered_white(weights, rgb),
            None => Components(rgb.to_vec()),
        }
    }

    fn filtered_white(&self, weights: &[Components; 3], rgb: Vector) -> Components {
        self.colorimetry.white.times(&share_of_white(weights, rgb))
    }

    fn light_of_spectrum(&self, spectrum: Components) -> Components {
        match self.weights {
            Some(_) => spectrum,
            None => Components(self.colorimetry.light(&spectrum).to_vec()),
        }
    }

    /// A light of this color, as strong as is said.
    fn sized_light(&self, unit: Unit, amount: f64, color: &Value, extent: Extent) -> Components {
        let intensity = match unit {
            Unit::Lux | Unit::Nits => amount,
            Unit::Candela | Unit::WattsPerSteradian => amount / extent.intensity,
            Unit::Lumens | Unit::Watts => amount / extent.flux,
        };
        // Nothing of a black color is nothing.
        let share = |whole: f64| {
            if intensity == 0.0 {
                0.0
            } else {
                intensity / whole
            }
        };
        if let (Some((rgb, space)), Unit::Candela | Unit::Lumens | Unit::Lux | Unit::Nits) =
            (literal(color), unit)
        {
            // A triple is in candela, and its luminance that of Rec.709.
            let candela = luminance(
                converted(rgb, space, ColorSpace::Rec709),
                ColorSpace::Rec709,
            );
            let working = converted(rgb, space, self.space);
            return self.colored_light(scale(working, share(candela)));
        }
        let spectrum = match self.working_rgb(color) {
            Some(rgb) => self.filtered_white(&self.colorimetry.weights(), rgb),
            None => spectrum(color),
        };
        let whole = match unit {
            Unit::Candela | Unit::Lumens | Unit::Lux | Unit::Nits => {
                self.colorimetry.luminous(&spectrum)
            }
            Unit::WattsPerSteradian | Unit::Watts => spectrum.sum(),
        };
        self.light_of_spectrum(spectrum.scaled(share(whole)))
    }
}

/// Whether light is carried wavelength by wavelength: as asked for, or because something is a
/// spectrum.
fn is_spectral(scene: &Scene) -> bool {
    let lights = scene.lights.iter().map(|light| match &light.value {
        Light::Point { intensity, .. }
        | Light::Spot { intensity, .. }
        | Light::Ies { intensity, .. } => &intensity.value,
        Light::Area { luminance, .. } => &luminance.value,
        Light::Sun { illuminance, .. } => &illuminance.value,
    });
    let needs_dispersion = |material: &Entry<Material>| match &material.value {
        Material::Metal(_) => true,
        Material::Glass(glass) => glass.dispersion,
        Material::Phong(_)
        | Material::NormalizedPhong(_)
        | Material::Mirror(_)
        | Material::Pane(_) => false,
    };
    let materials = scene
        .materials
        .iter()
        .flat_map(|material| match &material.value {
            Material::Phong(lobes) | Material::NormalizedPhong(lobes) => {
                vec![&lobes.diffuse.value, &lobes.specular.value]
            }
            Material::Mirror(mirror) => vec![&mirror.reflectance.value],
            Material::Glass(glass) => vec![&glass.absorption.value],
            Material::Metal(_) | Material::Pane(_) => Vec::new(),
        });
    match scene.image.transport.value {
        Transport::Rgb => false,
        Transport::Spectral => true,
        Transport::Auto => {
            scene.materials.iter().any(needs_dispersion)
                || lights
                    .chain(materials)
                    .chain([&scene.image.background.value])
                    .any(needs_spectra)
        }
    }
}

/// Whether a value is a spectrum, or of a size in watts, which RGB have none of.
fn needs_spectra(value: &Value) -> bool {
    match value {
        Value::Mixed(mixture) => mixture.0.iter().any(|(_, part)| needs_spectra(part)),
        Value::Sized { unit, color, .. } => {
            matches!(unit, Unit::WattsPerSteradian | Unit::Watts) || literal(color).is_none()
        }
        value => literal(value).is_none(),
    }
}

/// Linear RGB as written, and its space; `None` for what is not said so.
fn literal(value: &Value) -> Option<(Vector, ColorSpace)> {
    match *value {
        Value::Uniform(value) => Some(([value; 3], ColorSpace::Rec709)),
        Value::Rgb { rgb, space } => Some((rgb, space)),
        Value::Srgb(code) => Some((code.map(srgb_decoded), ColorSpace::Rec709)),
        Value::Illuminant(_)
        | Value::Daylight(_)
        | Value::Blackbody(_)
        | Value::Curve(_)
        | Value::Lines(_)
        | Value::Sized { .. }
        | Value::Mixed(_) => None,
    }
}

/// So many times each part of a mixture, together.
fn sum(mixture: &Mixture, components: impl Fn(&Value) -> Components) -> Components {
    let mut parts = mixture.0.iter();
    let scaled = |(weight, part): &(f64, Value)| components(part).scaled(*weight);
    let first = parts.next().map_or_else(|| flat(0.0), scaled);
    parts.fold(first, |sum, part| sum.plus(&scaled(part)))
}

/// Numbers over the wavelength that are no color: n, or k.
pub(super) fn numbers(value: &Value) -> Components {
    match value {
        Value::Uniform(number) => flat(*number),
        Value::Mixed(mixture) => sum(mixture, numbers),
        value => spectrum(value),
    }
}

/// Whether such are the same at all wavelengths.
pub(super) fn is_number(value: &Value) -> bool {
    match value {
        Value::Mixed(mixture) => mixture.0.iter().all(|(_, part)| is_number(part)),
        value => matches!(value, Value::Uniform(_)),
    }
}

/// The spectrum of what is not RGB, without the size of a light that has one beside it.
fn spectrum(value: &Value) -> Components {
    match value {
        Value::Illuminant(known) => illuminant(known.name()),
        Value::Daylight(temperature) => daylight(*temperature),
        Value::Blackbody(temperature) => blackbody(*temperature),
        Value::Curve(written) => curve(written),
        Value::Lines(written) => lines(written),
        // Not in a legal scene.
        Value::Uniform(_)
        | Value::Rgb { .. }
        | Value::Srgb(_)
        | Value::Sized { .. }
        | Value::Mixed(_) => flat(0.0),
    }
}

/// At each wavelength the share of white light, which may be more than 1, that makes this color:
/// a smooth reflectance of a dimmer one, scaled up again. Black for colors that are out of reach.
fn share_of_white(weights: &[Components; 3], rgb: Vector) -> Components {
    if is_gray(rgb) {
        return flat(rgb[0]);
    }
    let brightest = rgb[0].max(rgb[1]).max(rgb[2]);
    let dimmed = |maximum: &f64| {
        let factor = maximum / brightest;
        let reflectance = upsampling::reflectance(weights, scale(rgb, factor))?;
        Some(reflectance.scaled(1.0 / factor))
    };
    DIMMED.iter().find_map(dimmed).unwrap_or_else(|| flat(0.0))
}

fn is_gray([r, g, b]: Vector) -> bool {
    r == g && g == b
}

/// The three components of RGB.
fn triple(components: &Components) -> [f64; 3] {
    [0, 1, 2].map(|i: usize| components.0[i])
}

/// The sRGB transfer function of IEC 61966-2-1, from an 8-bit code to linear light:
/// c / 12.92 up to 0.04045, ((c + 0.055) / 1.055)^2.4 above.
fn srgb_decoded(code: u8) -> f64 {
    let c = f64::from(code) / 255.0;
    if c <= 0.04045 {
        c / 12.92
    } else {
        ((c + 0.055) / 1.055).powf(2.4)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::spectrum::{Curve, Lines, Observer};

    /// `powf` is good to a few units in the last place.
    const ROUNDING: f64 = 1e-15;

    /// Sums of 471 terms.
    const SUMS: f64 = 1e-13;

    /// A color and the one found for it.
    const SOLVED: f64 = 1e-11;

    fn palette(transport: Transport, space: ColorSpace) -> Palette {
        let mut scene = Scene::builtin();
        scene.image.transport.value = transport;
        scene.image.color_space.value = space;
        Palette::new(&scene)
    }

    fn rec709(rgb: Vector) -> Value {
        let space = ColorSpace::Rec709;
        Value::Rgb { rgb, space }
    }

    fn reddish() -> Value {
        let points = (vec![400.0, 700.0], vec![0.1, 0.8]);
        Value::Curve(Arc::new(Curve::new(points.0, points.1).unwrap()))
    }

    fn sodium() -> Value {
        Value::Lines(Arc::new(
            Lines::new(vec![[589.0, 0.5], [589.6, 0.5]]).unwrap(),
        ))
    }

    fn sized(unit: Unit, amount: f64, color: Value) -> Value {
        let color = Box::new(color);
        Value::Sized {
            unit,
            amount,
            color,
        }
    }

    fn assert_near(actual: Vector, expected: Vector, tolerance: f64) {
        let near = |i: usize| (actual[i] - expected[i]).abs() <= tolerance * expected[i].abs();
        assert!((0..3).all(near), "{actual:?}, expected {expected:?}");
    }

    #[test]
    fn srgb_codes() {
        // From decimal arithmetic with 40 digits.
        for (code, linear) in [
            (0, 0.0),
            (1, 1.0 / 255.0 / 12.92),
            (10, 10.0 / 255.0 / 12.92),
            (11, 0.003_346_535_763_899_158_5),
            (119, 0.184_474_994_500_440_9),
            (128, 0.215_860_500_113_899_2),
            (255, 1.0),
        ] {
            assert!((srgb_decoded(code) - linear).abs() < ROUNDING, "{code}");
        }
    }

    #[test]
    fn rgb_is_taken_as_it_stands() {
        let palette = palette(Transport::Auto, ColorSpace::Rec709);
        for (value, rgb) in [
            (Value::Uniform(0.5), [0.5; 3]),
            (rec709([0.1, 0.2, 0.3]), [0.1, 0.2, 0.3]),
            (Value::Srgb([255, 0, 255]), [1.0, 0.0, 1.0]),
        ] {
            assert_eq!(palette.light(&value), Components(rgb.to_vec()));
            assert_eq!(palette.reflectance(&value), Components(rgb.to_vec()));
        }
    }

    #[test]
    fn spectra_of_colors_look_like_them() {
        for space in ColorSpace::ALL {
            let palette = palette(Transport::Spectral, space);
            for rgb in [[0.7, 0.3, 0.2], [30.0, 20.0, 1.0], [0.25; 3], [8.0; 3]] {
                let expected = converted(rgb, ColorSpace::Rec709, space);
                assert_near(palette.seen(&palette.light(&rec709(rgb))), expected, SOLVED);
                let reflectance = palette.reflectance(&rec709(rgb));
                assert_near(palette.under_white(&reflectance), expected, SOLVED);
            }
        }
    }

    #[test]
    fn sizes_are_kept() {
        let palette = palette(Transport::Spectral, ColorSpace::Rec2020);
        for color in [
            reddish(),
            sodium(),
            Value::Blackbody(3200.0),
            Value::Daylight(5600.0),
        ] {
            let light = |unit, amount| palette.light(&sized(unit, amount, color.clone()));
            for (found, expected) in [
                (
                    palette.colorimetry.luminous(&light(Unit::Candela, 120.0)),
                    120.0,
                ),
                (
                    palette.colorimetry.luminous(&light(Unit::Lumens, 800.0)) * 4.0 * PI,
                    800.0,
                ),
                (light(Unit::WattsPerSteradian, 0.5).sum(), 0.5),
                (light(Unit::Watts, 6.0).sum() * 4.0 * PI, 6.0),
            ] {
                assert!(
                    (found / expected - 1.0).abs() < SUMS,
                    "{found}, expected {expected}"
                );
            }
        }
        // White is illuminant D65, and candela are those of each channel.
        let white = palette.light(&sized(Unit::Candela, 120.0, Value::Uniform(1.0)));
        assert_near(palette.seen(&white), [120.0; 3], SUMS);
    }

    /// What a scene holds, carried as RGB, looks the same where no two spectra meet.
    #[test]
    fn spectra_carried_as_rgb_are_their_colors() {
        for space in ColorSpace::ALL {
            let [rgb, spectral] =
                [Transport::Rgb, Transport::Spectral].map(|transport| palette(transport, space));
            for light in [
                reddish(),
                sodium(),
                sized(Unit::Watts, 2.0, rec709([0.2, 0.4, 0.9])),
                sized(Unit::Lumens, 2.0, rec709([0.2, 0.4, 0.9])),
            ] {
                let expected = spectral.seen(&spectral.light(&light));
                assert_near(rgb.seen(&rgb.light(&light)), expected, SOLVED);
            }
            let expected = spectral.under_white(&spectral.reflectance(&reddish()));
            assert_near(
                rgb.under_white(&rgb.reflectance(&reddish())),
                expected,
                SUMS,
            );
        }
        // The yellow of sodium is outside of Rec.709.
        let palette = palette(Transport::Rgb, ColorSpace::Rec709);
        let [red, green, blue] = palette.seen(&palette.light(&sodium()));
        assert!(red > green && green > 0.0 && blue < 0.0);
    }

    #[test]
    fn spectra_or_watts_make_a_scene_spectral() {
        let with_light = |value: Value| {
            let mut scene = Scene::builtin();
            scene.lights[0].value.size_mut().value = value;
            Palette::new(&scene).is_spectral()
        };
        assert!(!with_light(rec709([1.0, 2.0, 3.0])));
        assert!(!with_light(sized(
            Unit::Lumens,
            1.0,
            Value::Srgb([1, 2, 3])
        )));
        assert!(with_light(sized(Unit::Watts, 1.0, Value::Srgb([1, 2, 3]))));
        assert!(with_light(sized(Unit::Lumens, 1.0, sodium())));
        assert!(with_light(reddish()));
        let mut scene = Scene::builtin();
        scene.image.background.value = reddish();
        assert!(Palette::new(&scene).is_spectral());
        scene.image.transport.value = Transport::Rgb;
        assert!(!Palette::new(&scene).is_spectral());
        scene.image.observer.value = Observer::Cie1964;
        scene.image.transport.value = Transport::Spectral;
        assert!(Palette::new(&scene).is_spectral());
    }
}
