//! ꟻLIP: how much two pictures seem to differ when one is flipped to the other on a screen.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström & Fairchild 2020, "ꟻLIP: A Difference Evaluator for
//! Alternating Images", with the separated filters and the constants of the authors' program, version 1.7
//! (<https://github.com/NVlabs/flip>), whose 67 pixels a degree are kept: 0.7 m from a screen 0.7 m wide with 3840
//! pixels.

use std::f32::consts::PI;

use rayon::prelude::*;

use super::filter::Grid;
use super::room;
use crate::memory::OutOfMemory;

/// Pixels in a degree of the field of view.
const PIXELS_PER_DEGREE: f32 = 0.7 * (3840.0 / 0.7) * (PI / 180.0);

/// q_c, p_c, p_t of the color pipeline.
const COLOR_POWER: f32 = 0.7;
const COLOR_PART: f32 = 0.4;
const COLOR_TARGET: f32 = 0.95;

/// w and q_f of the feature pipeline: the width of features in degrees, and a power.
const FEATURE_WIDTH: f32 = 0.082;
const FEATURE_POWER: f32 = 0.5;

/// a and b of the contrast sensitivities: of luminance, red-green, and both terms of blue-yellow.
const SENSITIVITIES: [[f32; 2]; 4] = [[1.0, 0.0047], [1.0, 0.0053], [34.1, 0.04], [13.5, 0.025]];

/// XYZ of the screen's white, and its reciprocal.
const WHITE: [f32; 3] = [0.950_428_55, 1.0, 1.088_900_4];
const PER_WHITE: [f32; 3] = [1.052_156_9, 1.0, 0.918_357_67];

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
    let opponent = |pixels: &[[f32; 3]]| -> Result<Grid<3>, OutOfMemory> {
        let mut opponent = room(pixels.len(), [0.0; 3])?;
        let both = opponent.par_iter_mut().zip(pixels);
        both.for_each(|(opponent, &rgb)| {
            let light = shown(rgb).map(|channel| channel.clamp(0.0, 1.0));
            *opponent = opponent_color(xyz(light));
        });
        Ok(Grid {
            width,
            pixels: opponent,
        })
    };
    let both = [opponent(reference)?, opponent(image)?];
    let mut errors = room(image.len(), 0.0_f32)?;
    color_differences(&both, &mut errors)?;
    feature_differences(&both, &mut errors)?;
    Ok(errors)
}

/// The color pipeline: what is left of colors at the viewer's distance, and how far they are apart.
fn color_differences(both: &[Grid<3>; 2], errors: &mut [f32]) -> Result<(), OutOfMemory> {
    let filter = spatial_filter();
    // Luminance, red-green, and blue-yellow twice.
    let rows = |grid: &Grid<3>| {
        grid.along_rows(&filter, |sums: &mut [f32; 4], weights, [y, cx, cz]| {
            let values = [y, cx, cz, cz];
            for ((sum, weight), value) in sums.iter_mut().zip(weights).zip(values) {
                *sum += weight * value;
            }
        })
    };
    let both = [rows(&both[0])?, rows(&both[1])?];
    let most = largest_distance();
    let knee = COLOR_PART * most;
    let width = both[0].width;
    let lines = errors.par_chunks_mut(width).enumerate();
    lines.for_each_init(
        || [vec![[0.0; 4]; width], vec![[0.0; 4]; width]],
        |columns, (line, errors)| {
            for (grid, columns) in both.iter().zip(&mut *columns) {
                grid.along_columns(line, &filter, columns, |sums, weights, values| {
                    for ((sum, weight), value) in sums.iter_mut().zip(weights).zip(values) {
                        *sum += weight * value;
                    }
                });
            }
            let [reference, image] = columns;
            for ((error, &r), &i) in errors.iter_mut().zip(&*reference).zip(&*image) {
                let [r, i] = [r, i].map(|[y, cx, cz1, cz2]| {
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
fn feature_differences(both: &[Grid<3>; 2], errors: &mut [f32]) -> Result<(), OutOfMemory> {
    let filter = feature_filter();
    // First and second derivative along the row, and blurred.
    let rows = |grid: &Grid<3>| {
        grid.along_rows(&filter, |sums: &mut [f32; 3], [g, d, dd], [y, _, _]| {
            let gray = y * (1.0 / 116.0) + 16.0 / 116.0;
            sums[0] += d * gray;
            sums[1] += dd * gray;
            sums[2] += g * gray;
        })
    };
    let both = [rows(&both[0])?, rows(&both[1])?];
    let width = both[0].width;
    let lines = errors.par_chunks_mut(width).enumerate();
    lines.for_each_init(
        || [vec![[0.0; 4]; width], vec![[0.0; 4]; width]],
        |columns, (line, errors)| {
            for (grid, columns) in both.iter().zip(&mut *columns) {
                grid.along_columns(
                    line,
                    &filter,
                    columns,
                    |sums, [g, d, dd], [dx, ddx, gray]| {
                        sums[0] += g * dx;
                        sums[1] += g * ddx;
                        sums[2] += d * gray;
                        sums[3] += dd * gray;
                    },
                );
            }
            let [reference, image] = columns;
            for ((error, &r), &i) in errors.iter_mut().zip(&*reference).zip(&*image) {
                let [[edge_r, point_r], [edge_i, point_i]] = [r, i].map(|[dx, ddx, dy, ddy]| {
                    [(dx * dx + dy * dy).sqrt(), (ddx * ddx + ddy * ddy).sqrt()]
                });
                let largest = (edge_r - edge_i).abs().max((point_r - point_i).abs());
                let feature = libm::powf((1.0 / 2.0_f32.sqrt()) * largest, FEATURE_POWER);
                *error = libm::powf(*error, 1.0 - feature);
            }
        },
    );
    Ok(())
}

/// The eye's contrast sensitivities as filters along a line, their sums 1; that of blue-yellow is the sum of two
/// products.
fn spatial_filter() -> Vec<[f32; 4]> {
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
    let mut taps: Vec<[f32; 4]> = taps.collect();
    let sums = taps.iter().fold([0.0; 4], |sums: [f32; 4], tap| {
        std::array::from_fn(|i| sums[i] + tap[i])
    });
    let of_blue = (sums[2] * sums[2] + sums[3] * sums[3]).sqrt();
    for tap in &mut taps {
        for (weight, sum) in tap.iter_mut().zip([sums[0], sums[1], of_blue, of_blue]) {
            *weight *= 1.0 / sum;
        }
    }
    taps
}

/// A Gaussian, its first and its second derivative along a line; the sum of the first is 1, those of the positive and
/// of the negative weights of the others are 1 and −1.
fn feature_filter() -> Vec<[f32; 3]> {
    let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as i32;
    let taps = (-radius..=radius).map(|x| {
        let x = x as f32;
        let g = libm::expf(-(x * x) / (2.0 * deviation * deviation));
        [g, -x * g, (x * x / (deviation * deviation) - 1.0) * g]
    });
    let mut taps: Vec<[f32; 3]> = taps.collect();
    let sum = |part: &dyn Fn(&[f32; 3]) -> f32| taps.iter().map(part).sum::<f32>();
    let blur = sum(&|tap| tap[0]);
    let [rise, bend] = [1, 2].map(|i| {
        let positive = sum(&|tap| tap[i].max(0.0));
        let negative = sum(&|tap| (-tap[i]).max(0.0));
        [positive, negative]
    });
    for [g, d, dd] in &mut taps {
        *g /= blur;
        *d /= if *d > 0.0 { rise[0] } else { rise[1] };
        *dd /= if *dd > 0.0 { bend[0] } else { bend[1] };
    }
    taps
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
        let sum = |i: usize| spatial_filter().iter().map(|tap| tap[i]).sum::<f32>();
        assert!((sum(0) - 1.0).abs() < 1e-6 && (sum(1) - 1.0).abs() < 1e-6);
        assert!((sum(2).powi(2) + sum(3).powi(2) - 1.0).abs() < 1e-6);
        assert_eq!(spatial_filter().len(), 21);
        let features = feature_filter();
        assert!((features.iter().map(|tap| tap[0]).sum::<f32>() - 1.0).abs() < 1e-6);
        for i in [1, 2] {
            assert!(features.iter().map(|tap| tap[i]).sum::<f32>().abs() < 1e-6);
        }
    }
}
