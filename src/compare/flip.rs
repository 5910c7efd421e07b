//! ꟻLIP: how much two pictures seem to differ when one is flipped to the other on a screen.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström & Fairchild 2020, "ꟻLIP: A Difference Evaluator for
//! Alternating Images", with the separated filters and the constants of the authors' program, version 1.7
//! (<https://github.com/NVlabs/flip>), whose 67 pixels a degree are kept: 0.7 m from a screen 0.7 m wide with 3840
//! pixels.

use std::f32::consts::PI;

use rayon::prelude::*;

use super::filter::Planes;
use super::room;
use crate::memory::OutOfMemory;

/// Pixels in a degree of the field of view.
const PIXELS_PER_DEGREE: f32 = 0.7 * (3840.0 / 0.7) * (PI / 180.0);

/// q_c, p_c, p_t of the color pipeline.
const COLOR_POWER: f32 = 0.7;
const COLOR_PART: f32 = 0.4;
const COLOR_TARGET: f32 = 0.95;

/// w of the feature pipeline: the width of features in degrees. Its power q_f is a half: a square root.
const FEATURE_WIDTH: f32 = 0.082;

/// a and b of the contrast sensitivities: of luminance, red-green, and both terms of blue-yellow.
const SENSITIVITIES: [[f32; 2]; 4] = [[1.0, 0.0047], [1.0, 0.0053], [34.1, 0.04], [13.5, 0.025]];

/// XYZ of the screen's white, and its reciprocal.
const WHITE: [f32; 3] = [0.950_428_55, 1.0, 1.088_900_4];
const PER_WHITE: [f32; 3] = [1.052_156_9, 1.0, 0.918_357_7];

/// ꟻLIP of two pictures in linear Rec.709, 1 the screen's white; what is beyond 0 to 1 clips. Row by row, from 0,
/// no difference to be seen, to 1.
///
/// # Errors
/// If there is not so much memory.
///
/// # Panics
/// If both are not of one size, or of whole rows.
pub fn ldr_flip(
    width: usize,
    reference: &[[f32; 3]],
    image: &[[f32; 3]],
) -> Result<Vec<f32>, OutOfMemory> {
    flip_of(width, reference, image, |rgb| rgb)
}

/// ꟻLIP of what a function makes of both pictures.
pub(super) fn flip_of(
    width: usize,
    reference: &[[f32; 3]],
    image: &[[f32; 3]],
    shown: impl Fn([f32; 3]) -> [f32; 3] + Sync,
) -> Result<Vec<f32>, OutOfMemory> {
    assert!(width > 0 && reference.len() == image.len() && image.len().is_multiple_of(width));
    let opponent = |pixels: &[[f32; 3]]| -> Result<Planes<3>, OutOfMemory> {
        let mut opponent = Planes::new(width, pixels.len())?;
        let [ys, cxs, czs] = &mut opponent.planes;
        let channels = ys.par_iter_mut().zip(cxs).zip(czs).zip(pixels);
        channels.for_each(|(((y, cx), cz), &rgb)| {
            let light = shown(rgb).map(|channel| channel.clamp(0.0, 1.0));
            [*y, *cx, *cz] = opponent_color(xyz(light));
        });
        Ok(opponent)
    };
    let both = [opponent(reference)?, opponent(image)?];
    let mut errors = room(image.len(), 0.0_f32)?;
    color_differences(&both, &mut errors)?;
    feature_differences(both, &mut errors)?;
    Ok(errors)
}

/// The color pipeline: what is left of colors at the viewer's distance, and how far they are apart.
fn color_differences(both: &[Planes<3>; 2], errors: &mut [f32]) -> Result<(), OutOfMemory> {
    let [of_y, of_cx, of_cz1, of_cz2] = &spatial_filter();
    // Luminance, red-green, and blue-yellow twice.
    let rows =
        |image: &Planes<3>| image.along_rows([(0, of_y), (1, of_cx), (2, of_cz1), (2, of_cz2)]);
    let both = [rows(&both[0])?, rows(&both[1])?];
    let most = largest_distance();
    let knee = COLOR_PART * most;
    let width = both[0].width;
    let lines = errors.par_chunks_mut(width).enumerate();
    lines.for_each_init(
        || [(); 2].map(|()| [(); 4].map(|()| vec![0.0; width])),
        |sums, (line, errors)| {
            for (image, sums) in both.iter().zip(&mut *sums) {
                let filters = [(0, &**of_y), (1, &**of_cx), (2, &**of_cz1), (3, &**of_cz2)];
                image.along_columns(line, filters, sums);
            }
            for (x, error) in errors.iter_mut().enumerate() {
                let [r, i] = [0, 1].map(|image: usize| {
                    let [y, cx, cz1, cz2] = [0, 1, 2, 3].map(|plane: usize| sums[image][plane][x]);
                    let rgb = rgb(xyz_of_opponent([y, cx, cz1 + cz2]));
                    hunt(lab(xyz(rgb.map(|channel| channel.clamp(0.0, 1.0)))))
                });
                let distance = libm::powf(hyab(r, i), COLOR_POWER);
                *error = if distance < knee {
                    distance * (COLOR_TARGET / knee)
                } else {
                    COLOR_TARGET + (distance - knee) / (most - knee) * (1.0 - COLOR_TARGET)
                };
            }
        },
    );
    Ok(())
}

/// The feature pipeline: edges and points that only one picture has make the difference of colors larger.
fn feature_differences(mut both: [Planes<3>; 2], errors: &mut [f32]) -> Result<(), OutOfMemory> {
    let [blur, rise, bend] = &feature_filter();
    // First and second derivative along the row, and blurred.
    let rows = |image: &mut Planes<3>| {
        let gray = image.planes[0].par_iter_mut();
        gray.for_each(|y| *y = *y * (1.0 / 116.0) + 16.0 / 116.0);
        image.along_rows([(0, rise), (0, bend), (0, blur)])
    };
    let [reference, image] = &mut both;
    let both = [rows(reference)?, rows(image)?];
    let width = both[0].width;
    let lines = errors.par_chunks_mut(width).enumerate();
    lines.for_each_init(
        || [(); 2].map(|()| [(); 4].map(|()| vec![0.0; width])),
        |sums, (line, errors)| {
            for (image, sums) in both.iter().zip(&mut *sums) {
                let filters = [(0, &**blur), (1, &**blur), (2, &**rise), (2, &**bend)];
                image.along_columns(line, filters, sums);
            }
            for (x, error) in errors.iter_mut().enumerate() {
                let [[edge_r, point_r], [edge_i, point_i]] = [0, 1].map(|image: usize| {
                    let [dx, ddx, dy, ddy] = [0, 1, 2, 3].map(|plane: usize| sums[image][plane][x]);
                    [(dx * dx + dy * dy).sqrt(), (ddx * ddx + ddy * ddy).sqrt()]
                });
                let largest = (edge_r - edge_i).abs().max((point_r - point_i).abs());
                let feature = (largest * std::f32::consts::FRAC_1_SQRT_2).sqrt();
                *error = libm::powf(*error, 1.0 - feature);
            }
        },
    );
    Ok(())
}

/// The eye's contrast sensitivities as filters along a line, their sums 1; that of blue-yellow is the sum of two
/// products.
fn spatial_filter() -> [Vec<f32>; 4] {
    let widest = SENSITIVITIES
        .iter()
        .fold(0.0, |most: f32, [_, b]| most.max(*b));
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
    let taps = (-radius..=radius).map(|x| {
        let x = x as f32 * (1.0 / PIXELS_PER_DEGREE);
        let gaussian = |[_, b]: [f32; 2]| libm::expf(-(PI * PI) * (x * x) / b);
        let scale = |[a, b]: [f32; 2]| a * (PI / b).sqrt();
        let [y, cx, cz1, cz2] = SENSITIVITIES;
        [
            scale(y) * gaussian(y),
            scale(cx) * gaussian(cx),
            scale(cz1).sqrt() * gaussian(cz1),
            scale(cz2).sqrt() * gaussian(cz2),
        ]
    });
    let taps: Vec<[f32; 4]> = taps.collect();
    let sums = taps.iter().fold([0.0; 4], |sums: [f32; 4], tap| {
        std::array::from_fn(|i| sums[i] + tap[i])
    });
    let of_blue = (sums[2] * sums[2] + sums[3] * sums[3]).sqrt();
    let factors = [sums[0], sums[1], of_blue, of_blue].map(|sum| 1.0 / sum);
    std::array::from_fn(|i| taps.iter().map(|tap| tap[i] * factors[i]).collect())
}

/// A Gaussian, its first and its second derivative along a line; the sum of the first is 1, those of the positive and
/// of the negative weights of the others are 1 and −1.
fn feature_filter() -> [Vec<f32>; 3] {
    let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as i32;
    let taps = (-radius..=radius).map(|x| {
        let x = x as f32;
        let g = libm::expf(-(x * x) / (2.0 * deviation * deviation));
        [g, -x * g, (x * x / (deviation * deviation) - 1.0) * g]
    });
    let taps: Vec<[f32; 3]> = taps.collect();
    let sum = |part: &dyn Fn(&[f32; 3]) -> f32| taps.iter().map(part).sum::<f32>();
    let blur = sum(&|tap| tap[0]);
    let [rise, bend] = [1, 2].map(|i| {
        let positive = sum(&|tap| tap[i].max(0.0));
        let negative = sum(&|tap| (-tap[i]).max(0.0));
        [positive, negative]
    });
    let signed = |value: f32, [positive, negative]: [f32; 2]| {
        value / if value > 0.0 { positive } else { negative }
    };
    [
        taps.iter().map(|tap| tap[0] / blur).collect(),
        taps.iter().map(|tap| signed(tap[1], rise)).collect(),
        taps.iter().map(|tap| signed(tap[2], bend)).collect(),
    ]
}

/// Linear Rec.709 to XYZ, by fractions of whole numbers.
fn xyz([r, g, b]: [f32; 3]) -> [f32; 3] {
    [
        10_135_552.0 / 24_577_794.0 * r
            + 8_788_810.0 / 24_577_794.0 * g
            + 4_435_075.0 / 24_577_794.0 * b,
        2_613_072.0 / 12_288_897.0 * r
            + 8_788_810.0 / 12_288_897.0 * g
            + 887_015.0 / 12_288_897.0 * b,
        1_425_312.0 / 73_733_382.0 * r
            + 8_788_810.0 / 73_733_382.0 * g
            + 70_074_185.0 / 73_733_382.0 * b,
    ]
}

/// XYZ to linear Rec.709.
fn rgb([x, y, z]: [f32; 3]) -> [f32; 3] {
    [
        3.241_003_3 * x - 1.537_398_9 * y - 0.498_615_86 * z,
        -0.969_224_33 * x + 1.875_930_1 * y + 0.041_554_224 * z,
        0.055_639_423 * x - 0.204_011_2 * y + 1.057_148_9 * z,
    ]
}

/// XYZ to Y C_x C_z: L*a*b* without its cube roots.
fn opponent_color(xyz: [f32; 3]) -> [f32; 3] {
    let [x, y, z]: [f32; 3] = std::array::from_fn(|i| xyz[i] * PER_WHITE[i]);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// And back.
fn xyz_of_opponent([y, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (y + 16.0) / 116.0;
    let xyz = [y + cx / 500.0, y, y - cz / 200.0];
    std::array::from_fn(|i| xyz[i] * WHITE[i])
}

/// XYZ to L*a*b*.
fn lab(xyz: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let [x, y, z]: [f32; 3] = std::array::from_fn(|i| {
        let t = xyz[i] * PER_WHITE[i];
        if t > DELTA * DELTA * DELTA {
            libm::cbrtf(t)
        } else {
            t / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Hunt's effect: colors seem weaker where it is darker.
fn hunt([l, a, b]: [f32; 3]) -> [f32; 3] {
    [l, 0.01 * l * a, 0.01 * l * b]
}

/// HyAB: the distance of lightness, and that of the colors beside it.
fn hyab(r: [f32; 3], i: [f32; 3]) -> f32 {
    let [l, a, b]: [f32; 3] = std::array::from_fn(|channel| r[channel] - i[channel]);
    l.abs() + (a * a + b * b).sqrt()
}

/// The largest distance of colors on the screen, between green and blue.
fn largest_distance() -> f32 {
    let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|rgb| hunt(lab(xyz(rgb))));
    libm::powf(hyab(green, blue), COLOR_POWER)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flip(width: usize, reference: &[[f32; 3]], image: &[[f32; 3]]) -> Vec<f32> {
        ldr_flip(width, reference, image).unwrap_or_else(|error| panic!("{error}"))
    }

    #[test]
    fn the_same_picture_does_not_flip() {
        let picture: Vec<[f32; 3]> = (0..35).map(|i| [i as f32 / 35.0, 0.5, 0.1]).collect();
        assert_eq!(flip(7, &picture, &picture), [0.0; 35]);
    }

    /// Flat pictures have no edges: what is left is the distance of their colors.
    #[test]
    fn green_and_blue_are_as_far_apart_as_can_be() {
        let errors = flip(3, &[[0.0, 1.0, 0.0]; 9], &[[0.0, 0.0, 1.0]; 9]);
        for error in errors {
            assert!((error - 1.0).abs() < 1e-4, "{error}");
        }
    }

    #[test]
    fn filters_are_normalized() {
        let sum = |filter: &[f32]| filter.iter().sum::<f32>();
        let [y, cx, cz1, cz2] = &spatial_filter();
        assert!((sum(y) - 1.0).abs() < 1e-6 && (sum(cx) - 1.0).abs() < 1e-6);
        assert!((sum(cz1).powi(2) + sum(cz2).powi(2) - 1.0).abs() < 1e-6);
        assert_eq!(y.len(), 21);
        let [blur, rise, bend] = &feature_filter();
        assert!((sum(blur) - 1.0).abs() < 1e-6);
        assert!(sum(rise).abs() < 1e-6 && sum(bend).abs() < 1e-6);
    }
}
