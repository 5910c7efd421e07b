//! One pixel after the other from radiance to the samples of a picture, and what is noticed on the way.

use super::dither::threshold;
use super::gamut::Compression;
use super::lanes::{Matrix, PIECE, Planes, transform};
use super::screen::Transfer;
use super::view::Rendering;
use super::{Bits, Dither, Gamut, LOOKS_BLACK, Overlay, Settings, code_of_8, code_of_16, exposure};
use crate::color::Primaries;
use crate::color::adaptation::cat16;
use crate::simd::SimdLevel;
use glam::DVec3;

/// A channel above this, times what becomes the largest code, clips: as it is, it would have a code of 256 or more
/// in sRGB.
const CLIPS: f64 = 1.009;

/// What is brighter, infinities among it, is taken for this: of a size that views can square and multiply.
const INFINITE: f64 = 1e30;

/// The settings, as far as pixels need them.
pub(super) struct Develop<'a> {
    level: SimdLevel,
    scale: f64,
    /// The exposed radiance that becomes white, and that which has the largest code.
    white: f64,
    peak: f64,
    /// A channel above this clips: of light, where more radiance is more light for as long as there are codes; else of
    /// exposed radiance.
    clips: f64,
    /// A code value of a channel that can be seen.
    visible: f64,
    /// What makes white of another color.
    balance: Option<Matrix>,
    /// Before the view where it works on the screen's primaries, else after it.
    to_screen: Option<Matrix>,
    is_per_channel: bool,
    compression: Option<Compression>,
    view: Rendering<'a>,
    transfer: Transfer,
    shows_invalid: bool,
    overlays: &'a [Overlay],
    bits: Bits,
    dither: Dither,
    has_alpha: bool,
    /// Where the picture's top left is in the display window.
    origin: [u32; 2],
    /// Of R, G, B in the luminance.
    weights: [f64; 3],
}

/// What was noticed about some pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Seen {
    /// The largest finite luminance, before the exposure.
    pub(super) brightest: f64,
    /// Whether there is a channel that can be seen on the screen.
    pub(super) is_visible: bool,
    /// Pixels of which a channel clips.
    pub(super) clipped: u64,
}

impl Seen {
    pub(super) fn and(self, other: Self) -> Self {
        Self {
            brightest: self.brightest.max(other.brightest),
            is_visible: self.is_visible || other.is_visible,
            clipped: self.clipped + other.clipped,
        }
    }
}

impl<'a> Develop<'a> {
    /// With an exposure of `ev`, whatever the settings say, for a picture whose top left is at `origin` in
    /// the display window.
    pub(super) fn new(settings: &Settings<'a>, ev: f64, has_alpha: bool, origin: [u32; 2]) -> Self {
        let screen = settings.screen;
        let of_view = settings.view.luminance().filter(|_| screen.is_hdr());
        let white = settings.white_luminance.or(of_view);
        let white = white.unwrap_or(screen.white());
        let headroom = screen.peak().map_or(1.0, |peak| peak / white);
        let view = Rendering::new(settings, white, ev);
        let is_coded = settings.view.is_coded();
        let level = SimdLevel::default();
        let shown_white = view.white();
        Self {
            level,
            scale: exposure::scale(ev),
            white: shown_white,
            peak: shown_white * if view.is_linear() { headroom } else { 1.0 },
            clips: if settings.bits == Bits::ThirtyTwo {
                // Floats hold what is brighter.
                f64::INFINITY
            } else {
                CLIPS
                    * if view.is_linear() {
                        headroom
                    } else {
                        shown_white
                    }
            },
            visible: {
                let mut gray = [[LOOKS_BLACK; PIECE]; 3];
                transform(level, &screen.transfer(white), &mut gray, 1);
                gray[0][0]
            },
            balance: settings.white.map(balance),
            to_screen: if is_coded {
                None
            } else {
                Matrix::between(&Primaries::REC709, &screen.primaries())
            },
            is_per_channel: settings.view.is_per_channel(),
            compression: match settings.gamut {
                Gamut::Compress if !is_coded => Compression::new(&screen.primaries()),
                Gamut::Clip | Gamut::Compress => None,
            },
            view,
            transfer: if is_coded {
                Transfer::Linear
            } else {
                screen.transfer(white)
            },
            shows_invalid: settings.shows_invalid,
            overlays: settings.drawn.overlays,
            bits: settings.bits,
            dither: settings.dither,
            has_alpha,
            origin,
            weights: Primaries::REC709.luminance_weights(),
        }
    }

    /// Whether the picture has alpha.
    pub(super) const fn has_alpha(&self) -> bool {
        self.has_alpha
    }

    /// The exposed radiance that is shown as white, and that above which a picture clips; infinite where none is.
    pub(super) const fn ends(&self) -> [f64; 2] {
        [self.white, self.peak]
    }

    /// Bits of each sample.
    pub(super) const fn bits(&self) -> Bits {
        self.bits
    }

    /// Samples of a pixel.
    pub(super) const fn channels(&self) -> usize {
        if self.has_alpha { 4 } else { 3 }
    }

    /// Bytes of a pixel.
    pub(super) const fn pixel_bytes(&self) -> usize {
        self.channels() * self.bits.bytes()
    }

    /// Row `y` of the picture, of which there are pixels from column `left` on. Where there are
    /// none it is black, and transparent where there is alpha.
    pub(super) fn row(&self, y: u32, left: u32, pixels: &[[f32; 4]], row: &mut [u8]) -> Seen {
        let bytes = self.pixel_bytes();
        let (before, rest) = row.split_at_mut((left as usize * bytes).min(row.len()));
        let (samples, after) = rest.split_at_mut((pixels.len() * bytes).min(rest.len()));
        before.fill(0);
        after.fill(0);
        let mut seen = Seen::default();
        let mut planes = [[0.0; PIECE]; 3];
        let pieces = pixels.chunks(PIECE).zip(samples.chunks_mut(PIECE * bytes));
        for ((pixels, samples), x) in pieces.zip((left..).step_by(PIECE)) {
            self.expose(pixels, &mut planes, &mut seen);
            self.show(&mut planes, pixels.len(), &mut seen);
            if self.shows_invalid {
                mark_invalid(pixels, &mut planes);
            }
            self.quantize([x, y], pixels, &planes, samples);
        }
        for overlay in self.overlays {
            overlay.lay_on_row(y, row, self.bits, self.has_alpha);
        }
        seen
    }

    /// From exposed radiance in Rec.709 to the screen's code values, of the first `count` colors.
    fn show(&self, planes: &mut Planes, count: usize, seen: &mut Seen) {
        let level = self.level;
        if let Some(balance) = &self.balance {
            transform(level, balance, planes, count);
        }
        let is_linear = self.view.is_linear();
        if !is_linear {
            seen.clipped += beyond(planes, count, self.clips);
        }
        if !self.is_per_channel {
            self.view.apply(level, planes, count);
        }
        if let Some(to_screen) = &self.to_screen {
            transform(level, to_screen, planes, count);
        }
        if let Some(compression) = &self.compression {
            transform(level, compression, planes, count);
        }
        if self.is_per_channel {
            self.view.apply(level, planes, count);
        }
        if is_linear {
            seen.clipped += beyond(planes, count, self.clips);
        }
        transform(level, &self.transfer, planes, count);
        seen.is_visible = seen.is_visible || beyond(planes, count, self.visible) > 0;
    }

    /// Exposed radiance by which no coverage is multiplied.
    fn expose(&self, pixels: &[[f32; 4]], [red, green, blue]: &mut Planes, seen: &mut Seen) {
        let [of_red, of_green, of_blue] = self.weights;
        for (place, pixel) in pixels.iter().enumerate() {
            let [r, g, b, alpha] = pixel.map(f64::from);
            let per_coverage = if self.has_alpha && alpha > 0.0 && alpha.is_finite() {
                1.0 / alpha
            } else {
                1.0
            };
            let [r, g, b] = [r, g, b].map(|radiance| radiance * per_coverage);
            let luminance = of_red * r + of_green * g + of_blue * b;
            if luminance > seen.brightest && luminance.is_finite() {
                seen.brightest = luminance;
            }
            let exposed = [r, g, b].map(|radiance| radiance * self.scale);
            [red[place], green[place], blue[place]] =
                exposed.map(|channel| channel.clamp(-INFINITE, INFINITE));
        }
    }

    /// From code values from 0 to 1 to the samples of the image.
    fn quantize(
        &self,
        [left, y]: [u32; 2],
        pixels: &[[f32; 4]],
        [red, green, blue]: &Planes,
        samples: &mut [u8],
    ) {
        let [first_x, first_y] = self.origin;
        let codes = pixels.iter().zip(red.iter().zip(green).zip(blue));
        let codes = codes.map(|(pixel, ((&r, &g), &b))| ([r, g, b], f64::from(pixel[3])));
        let samples = samples.chunks_exact_mut(self.pixel_bytes());
        match self.bits {
            Bits::Eight => {
                for ((samples, (rgb, alpha)), x) in samples.zip(codes).zip(first_x + left..) {
                    let threshold = match self.dither {
                        Dither::Blue => threshold(x, first_y + y),
                        Dither::None => 0.5,
                    };
                    let [r, g, b] = rgb.map(|value| (value * f64::from(u8::MAX) + threshold) as u8);
                    let alpha = code_of_8(alpha);
                    for (sample, code) in samples.iter_mut().zip([r, g, b, alpha]) {
                        *sample = code;
                    }
                }
            }
            Bits::Sixteen => {
                for (samples, (rgb, alpha)) in samples.zip(codes) {
                    let [r, g, b] = rgb;
                    let codes = [r, g, b, alpha].map(code_of_16);
                    for (sample, code) in samples.chunks_exact_mut(2).zip(codes) {
                        sample.copy_from_slice(&code.to_be_bytes());
                    }
                }
            }
            Bits::ThirtyTwo => {
                for (samples, (rgb, alpha)) in samples.zip(codes) {
                    let [r, g, b] = rgb;
                    let values = [r, g, b, alpha].map(|value| value as f32);
                    for (sample, value) in samples.chunks_exact_mut(4).zip(values) {
                        sample.copy_from_slice(&value.to_ne_bytes());
                    }
                }
            }
        }
    }
}

/// How many of the first `count` colors have a channel above a limit.
fn beyond([red, green, blue]: &Planes, count: usize, limit: f64) -> u64 {
    let colors = red.iter().zip(green).zip(blue).take(count);
    // Without a branch, several at a time.
    let is_beyond = colors.map(|((&r, &g), &b)| u64::from((r > limit) | (g > limit) | (b > limit)));
    is_beyond.sum()
}

/// In Rec.709, what makes the screen's white of light of a chromaticity, by CAT16.
fn balance([x, y]: [f64; 2]) -> Matrix {
    let space = Primaries::REC709;
    let from = DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
    Matrix::new(space.from_xyz() * cat16(from, space.white_xyz()) * space.to_xyz())
}

/// Magenta where a value is not a number, cyan where one is infinite.
fn mark_invalid(pixels: &[[f32; 4]], [red, green, blue]: &mut Planes) {
    for (place, pixel) in pixels.iter().enumerate() {
        let color = if pixel.iter().any(|value| value.is_nan()) {
            [1.0, 0.0, 1.0]
        } else if pixel.iter().any(|value| value.is_infinite()) {
            [0.0, 1.0, 1.0]
        } else {
            continue;
        };
        [red[place], green[place], blue[place]] = color;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::{FalseColor, Screen, View};

    fn seen(settings: &Settings<'_>, pixels: &[[f32; 4]]) -> Seen {
        let develop = Develop::new(settings, 0.0, false, [0, 0]);
        let mut row = vec![0; pixels.len() * develop.pixel_bytes()];
        develop.row(0, 0, pixels, &mut row)
    }

    fn of(view: View, screen: Screen) -> Settings<'static> {
        Settings {
            view,
            screen,
            ..Settings::new()
        }
    }

    fn gray(value: f32) -> [f32; 4] {
        [value, value, value, 1.0]
    }

    /// 2 % of the white of each view: of 203 cd/m², of 80, and by reinhard's curve.
    #[test]
    fn what_is_shown_is_seen() {
        for (view, screen, border) in [
            (View::Srgb, Screen::Srgb, 0.02),
            (View::Srgb, Screen::P3, 0.02),
            (View::Srgb, Screen::Rec2020Pq, 0.02),
            (View::Srgb, Screen::Rec2020Hlg, 0.02),
            (View::Srgb, Screen::Rec1886, 0.02),
            (View::Srgb, Screen::Linear, 0.02),
            (View::Absolute, Screen::Srgb, 1.6),
            (View::Absolute, Screen::Rec2020Pq, 4.06),
            (View::Reinhard, Screen::Srgb, 0.02 / 0.98),
            // The code of 2 %, by the formula of sRGB.
            (View::Raw, Screen::Srgb, 0.151_699),
        ] {
            let settings = of(view, screen);
            let is_visible = |light| seen(&settings, &[gray(0.0), gray(light)]).is_visible;
            assert!(is_visible(border * 1.001), "{view} on {}", screen.name());
            assert!(!is_visible(border * 0.999), "{view} on {}", screen.name());
        }
        // A color for everything, no light and infinite light among it.
        for false_color in [FalseColor::STOPS, FalseColor::luminance(1.0, 10.0).unwrap()] {
            let settings = Settings {
                false_color,
                ..of(View::FalseColor, Screen::Srgb)
            };
            let seen = seen(&settings, &[gray(0.0), gray(f32::INFINITY)]);
            assert!(seen.is_visible);
            assert_eq!(seen.clipped, 0);
        }
        // Blue has little luminance, and is seen.
        let blue = seen(&of(View::Srgb, Screen::Srgb), &[[0.0, 0.0, 0.1, 1.0]]);
        assert!(blue.is_visible && blue.brightest < 0.02);
    }

    #[test]
    fn what_has_no_code_clips() {
        for (view, screen, border) in [
            (View::Srgb, Screen::Srgb, 1.0),
            (View::Srgb, Screen::Rec2020Pq, 10_000.0 / 203.0),
            (View::Srgb, Screen::Rec2020Hlg, 1000.0 / 203.0),
            (View::Absolute, Screen::Srgb, 80.0),
            (View::Absolute, Screen::Rec1886, 100.0),
            (View::Absolute, Screen::Rec2020Pq, 10_000.0),
            (View::Raw, Screen::Rec2020Pq, 1.0),
            (View::ReinhardExtended, Screen::Srgb, 4.0),
        ] {
            let clipped = |light| seen(&of(view, screen), &[gray(light), gray(0.1)]).clipped;
            assert_eq!(clipped(border * 1.02), 1, "{view} on {}", screen.name());
            assert_eq!(clipped(border * 1.001), 0, "{view} on {}", screen.name());
        }
        for view in [View::Reinhard, View::PbrNeutral] {
            assert_eq!(seen(&of(view, Screen::Srgb), &[gray(1e30)]).clipped, 0);
        }
        // The red of P3 is outside of Rec.709, and on its own screen.
        let red = [1.2249, -0.0420, -0.0196, 1.0];
        assert_eq!(seen(&of(View::Srgb, Screen::Srgb), &[red]).clipped, 1);
        assert_eq!(seen(&of(View::Srgb, Screen::P3), &[red]).clipped, 0);
        let floats = Settings {
            bits: Bits::ThirtyTwo,
            ..of(View::Srgb, Screen::Srgb)
        };
        assert_eq!(seen(&floats, &[gray(9.0)]).clipped, 0);
    }
}
