//! Luminance and chroma to R, G, B.
//!
//! Y = w · (R, G, B), RY = (R − Y)/Y, BY = (B − Y)/Y, with the weights w of the file's primaries. RY and BY
//! have a sample for 2 × 2 pixels; the others are found by the windowed sinc of OpenEXR's ImfRgbaYca, whose
//! six digits are the format's definition, as is what it does to pixels that are much more saturated than
//! their neighbors: "Technical Introduction to OpenEXR", Luminance/Chroma Images.

/// The weights of the samples 1, 3, … 13 pixels away, on both sides.
const FILTER: [f32; 7] = [
    0.627_123, -0.186_077, 0.087_929, -0.043_159, 0.019_597, -0.007_540, 0.002_128,
];

/// How many lines above and below a line decide about it.
pub(super) const REACH: u32 = 14;

/// Luminance and chroma of some lines.
pub(super) struct LumaChroma<'p> {
    /// The weights of R, G, B in Y.
    pub(super) weights: [f32; 3],
    /// Pixels in a line, an even number.
    pub(super) width: usize,
    /// Lines of the whole data window, an even number.
    pub(super) height: i64,
    /// The first line that is here, an even number.
    pub(super) first: i64,
    pub(super) y: &'p [f32],
    /// RY and BY at every other pixel of every other line.
    pub(super) chroma: [&'p [f32]; 2],
}

/// R, G, B of a pixel from Y, RY, BY.
pub(super) fn rgb(weights: [f32; 3], [y, ry, by]: [f32; 3]) -> [f32; 3] {
    // Grays come back as they were.
    if ry == 0.0 && by == 0.0 {
        return [y; 3];
    }
    let (r, b) = ((ry + 1.0) * y, (by + 1.0) * y);
    [r, (y - r * weights[0] - b * weights[2]) / weights[1], b]
}

impl LumaChroma<'_> {
    /// R, G, B of a line of the data window.
    pub(super) fn line(&self, line: i64) -> Vec<[f32; 3]> {
        let [above, mut here, below] = [line - 1, line, line + 1].map(|line| self.unlimited(line));
        let neighbors =
            [above, below].map(|line| -> Vec<f32> { line.into_iter().map(saturation).collect() });
        let last = self.width - 1;
        for (x, pixel) in here.iter_mut().enumerate() {
            let around = neighbors
                .iter()
                .map(|line| line[x.saturating_sub(1)] + line[last.min(x + 1)]);
            let mean = (around.sum::<f32>() / 4.0).min(1.0);
            let limit = (1.0 - (1.0 - mean) / 4.0).min(1.0);
            let found = saturation(*pixel);
            if found > mean && found > limit {
                *pixel = self.desaturated(*pixel, limit / found);
            }
        }
        here
    }

    /// A line without regard to its neighbors' saturation. Beyond the data window it is as the nearest
    /// even one.
    fn unlimited(&self, line: i64) -> Vec<[f32; 3]> {
        let inside = match line {
            line if line < 0 => 0,
            line if line >= self.height => self.height - 2,
            line => line,
        };
        let y = &self.y[(inside - self.first) as usize * self.width..][..self.width];
        let [ry, by] = self.chroma.map(|chroma| self.chroma_line(chroma, line));
        let chroma = ry.into_iter().zip(by);
        let pixels = y.iter().zip(chroma);
        pixels
            .map(|(&y, (ry, by))| rgb(self.weights, [y, ry, by]))
            .collect()
    }

    /// One of RY and BY at each pixel of a line.
    fn chroma_line(&self, chroma: &[f32], line: i64) -> Vec<f32> {
        let half = self.width / 2;
        let stored = |line: i64| {
            let line = line.clamp(0, self.height - 2);
            &chroma[((line - self.first) / 2) as usize * half..][..half]
        };
        let column: Vec<f32> = if line % 2 == 0 {
            stored(line).to_vec()
        } else {
            let mut sums = vec![0.0; half];
            for (distance, weight) in (1..).step_by(2).zip(FILTER) {
                let pairs = stored(line - distance).iter().zip(stored(line + distance));
                for (sum, (above, below)) in sums.iter_mut().zip(pairs) {
                    *sum += weight * (above + below);
                }
            }
            sums
        };
        let mut full = Vec::with_capacity(self.width);
        for (x, &here) in column.iter().enumerate() {
            full.push(here);
            let between = FILTER.iter().enumerate().map(|(step, weight)| {
                let left = column[x.saturating_sub(step)];
                weight * (left + column[(x + 1 + step).min(half - 1)])
            });
            full.push(between.sum());
        }
        full
    }

    /// A pixel with a part of its saturation and all of its luminance.
    fn desaturated(&self, pixel: [f32; 3], part: f32) -> [f32; 3] {
        let largest = pixel.into_iter().fold(f32::MIN, f32::max);
        let faded = pixel.map(|channel| (largest - (largest - channel) * part).max(0.0));
        let luminance = |rgb: [f32; 3]| -> f32 {
            rgb.iter()
                .zip(self.weights)
                .map(|(channel, weight)| channel * weight)
                .sum()
        };
        let (before, after) = (luminance(pixel), luminance(faded));
        if after > 0.0 {
            faded.map(|channel| channel * before / after)
        } else {
            faded
        }
    }
}

/// 1 − least / largest of R, G, B.
fn saturation(pixel: [f32; 3]) -> f32 {
    let largest = pixel.into_iter().fold(f32::MIN, f32::max);
    let least = pixel.into_iter().fold(f32::MAX, f32::min);
    if largest > 0.0 {
        1.0 - least / largest
    } else {
        0.0
    }
}
