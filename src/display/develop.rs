//! One pixel after the other from radiance to the samples of a picture, and what is noticed on the way.

use super::dither::threshold;
use super::gamut::Compression;
use super::lanes::{Matrix, PIECE, Planes, transform};
use super::screen::Transfer;
use super::view::Rendering;
use super::{Bits, Dither, Gamut, Overlay, Settings, code_of_8, code_of_16, exposure};
use crate::color::Primaries;
use crate::color::adaptation::cat16;
use crate::simd::SimdLevel;
use glam::DVec3;

/// A channel above this, times the view's white, is brighter than the screen: as it is, it would have a code of
/// 256 or more.
const CLIPS: f64 = 1.009;

/// What is brighter, infinities among it, is taken for this: of a size that views can square and multiply.
const INFINITE: f64 = 1e30;

/// The settings, as far as pixels need them.
pub(super) struct Develop<'a> {
    level: SimdLevel,
    scale: f64,
    /// A channel above this clips.
    clips: f64,
    /// What makes white of another color.
    balance: Option<Matrix>,
    /// Before the view where it works on the screen's primaries, else after it.
    to_screen: Option<Matrix>,
    is_per_channel: bool,
    compression: Option<Compression>,
    view: Rendering<'a>,
    transfer: Transfer,
    shows_invalid: bool,
    overlay: Option<&'a Overlay>,
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
    /// Pixels of which a channel clips.
    pub(super) clipped: u64,
}

impl Seen {
    pub(super) fn and(self, other: Self) -> Self {
        Self {
            brightest: self.brightest.max(other.brightest),
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
        Self {
            level: SimdLevel::default(),
            scale: exposure::scale(ev),
            clips: if settings.bits == Bits::ThirtyTwo {
                // Floats hold what is brighter.
                f64::INFINITY
            } else {
                CLIPS * view.white() * if view.is_linear() { headroom } else { 1.0 }
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
            overlay: settings.overlay,
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
            self.show(&mut planes, pixels.len());
            if self.shows_invalid {
                mark_invalid(pixels, &mut planes);
            }
            self.quantize([x, y], pixels, &planes, samples);
        }
        if let Some(overlay) = self.overlay {
            overlay.lay_on_row(y, row, self.bits, self.has_alpha);
        }
        seen
    }

    /// From exposed radiance in Rec.709 to the screen's code values, of the first `count` colors.
    fn show(&self, planes: &mut Planes, count: usize) {
        let level = self.level;
        if let Some(balance) = &self.balance {
            transform(level, balance, planes, count);
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
        transform(level, &self.transfer, planes, count);
    }

    /// Exposed radiance by which no coverage is multiplied.
    fn expose(&self, pixels: &[[f32; 4]], [red, green, blue]: &mut Planes, seen: &mut Seen) {
        let [of_red, of_green, of_blue] = self.weights;
        let clips = self.clips;
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
            seen.clipped += u64::from(exposed.iter().any(|&channel| channel > clips));
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
