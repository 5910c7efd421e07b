use super::*;
use crate::color::transfer::srgb_encode;
use crate::display::lanes::{PIECE, Planes, of_one, transform};
use crate::simd::SimdLevel;
use glam::DVec3;

/// The peaks for which OpenColorIO has built-in transforms.
const PEAKS: [f64; 5] = [100.0, 500.0, 1000.0, 2000.0, 4000.0];

fn sdr() -> Aces2 {
    Aces2::new(100.0, &Primaries::REC709)
}

/// "ACES 2.0 - SDR 100 nits (Rec.709)" on "sRGB - Display" by OpenColorIO 2.6.0, config
/// studio-config-v4.0.0_aces-v2.0_ocio-v2.5, without optimization.
#[test]
fn sdr_is_opencolorio() {
    let view = sdr();
    for (rgb, expected) in [
        ([0.01; 3], [0.009205; 3]),
        ([0.18; 3], [0.349189; 3]),
        ([1.0; 3], [0.706684; 3]),
        ([4.0; 3], [0.899868; 3]),
        ([16.0; 3], [0.974730; 3]),
        ([1.0, 0.0, 0.0], [0.769867, 0.091997, 0.042600]),
        ([0.0, 1.0, 0.0], [0.240638, 0.744749, 0.202583]),
        ([0.0, 0.0, 1.0], [0.0, 0.0, 0.744115]),
        ([4.0, 4.0, 0.0], [0.926580, 0.937038, 0.541613]),
        ([0.8, 0.3, 0.05], [0.704168, 0.460493, 0.210420]),
        ([0.45, 0.27, 0.19], [0.543336, 0.436433, 0.375124]),
    ] {
        let codes = of_one(&view, rgb).map(srgb_encode);
        for (code, expected) in codes.into_iter().zip(expected) {
            // Its curve is another one near black, by 9.8e-6 at most.
            assert!((code - expected).abs() < 2e-5, "{rgb:?}: {codes:?}");
        }
    }
}

#[test]
fn all_screens_are_opencolorio() {
    let mut views = Vec::new();
    let table = include_str!("../../../../reference/display/aces2.csv");
    let rows = table.lines().filter(|line| !line.starts_with('#')).skip(1);
    for row in rows {
        let (screen, numbers) = row
            .match_indices(',')
            .nth(1)
            .map(|(at, _)| row.split_at(at))
            .unwrap();
        let (peak, primaries) = screen.split_once(',').unwrap();
        let peak: f64 = peak.parse().unwrap();
        if views.last().is_none_or(|(last, _)| last != screen) {
            let limiting = match primaries {
                "Rec.709" => Primaries::REC709,
                "P3" => Primaries::P3_D65,
                "Rec.2020" => Primaries::REC2020,
                other => panic!("{other}"),
            };
            views.push((screen.to_owned(), Aces2::new(peak, &limiting)));
        }
        let numbers: Vec<f64> = numbers[1..]
            .split(',')
            .map(|text| text.parse().unwrap())
            .collect();
        let rgb = of_one(
            &views.last().unwrap().1,
            [numbers[0], numbers[1], numbers[2]],
        );
        let found = Primaries::REC709.to_xyz() * DVec3::from_array(rgb);
        let expected = DVec3::from_slice(&numbers[3..]);
        let error = (found - expected).abs().max_element() / (peak / 100.0);
        assert!(error < 2e-5, "{row}: {found}, off by {error:e}");
    }
    assert_eq!(views.len(), 6);
}

#[test]
fn middle_gray_and_the_peak_are_where_they_belong() {
    // 10 cd/m² for a radiance of 0.18: what the 10.013 of the Academy's constants comes to.
    for light in of_one(&sdr(), [0.18; 3]) {
        assert!((light - 0.1).abs() < 1e-6, "{light}");
    }
    // The peak for a radiance of 128 with 100 cd/m² to 896 with 10 000, and for all above.
    for peak in PEAKS {
        let view = Aces2::new(peak, &Primaries::P3_D65);
        let roof = 128.0 + 768.0 * (peak / 100.0).log10() / 2.0;
        for radiance in [roof, 1e30] {
            for light in of_one(&view, [radiance; 3]) {
                let error = light / (peak / 100.0) - 1.0;
                assert!(error.abs() < 1e-10, "{peak}, {radiance}: {error:e}");
            }
        }
    }
}

#[test]
fn grays_rise_and_stay_gray() {
    for peak in PEAKS {
        let view = Aces2::new(peak, &Primaries::REC2020);
        let mut planes: Planes = [std::array::from_fn(|i| (i as f64 / 8.0 - 20.0).exp2()); 3];
        transform(SimdLevel::default(), &view, &mut planes, PIECE);
        let [red, green, blue] = &planes;
        assert!(
            red.is_sorted() && green.is_sorted() && blue.is_sorted(),
            "{peak}"
        );
        for ((r, g), b) in red.iter().zip(green).zip(blue) {
            assert!(
                (r - g).abs() < 1e-12 * r && (b - g).abs() < 1e-12 * b,
                "{r}, {g}, {b}"
            );
        }
        assert_eq!(of_one(&view, [0.0; 3]), [0.0; 3]);
    }
}

/// Colors of all kinds, from a linear congruential sequence.
fn colors() -> Planes {
    let mut state = 1_u64;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut planes = [[0.0; PIECE]; 3];
    for place in 0..PIECE {
        let size = (next() * 24.0 - 12.0).exp2();
        for plane in &mut planes {
            plane[place] = size * (next() * 1.4 - 0.4);
        }
    }
    planes
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    let view = Aces2::new(1000.0, &Primaries::P3_D65);
    let results = SimdLevel::available().into_iter().map(|(_, level)| {
        let mut planes = colors();
        transform(level, &view, &mut planes, PIECE);
        planes.map(|plane| plane.map(f64::to_bits))
    });
    let results: Vec<_> = results.collect();
    assert!(results.windows(2).all(|pair| pair[0] == pair[1]));
}

#[test]
fn any_color_is_inside_of_the_screen() {
    let view = Aces2::new(1000.0, &Primaries::P3_D65);
    let to_p3 = Primaries::P3_D65.from_xyz() * Primaries::REC709.to_xyz();
    let numbers = [-1e30, -1.0, -1e-30, 0.0, 1e-300, 1e-3, 1.0, 1e30];
    for r in numbers {
        for g in numbers {
            for b in numbers {
                let light = to_p3 * DVec3::from_array(of_one(&view, [r, g, b]));
                let is_inside = light
                    .to_array()
                    .iter()
                    .all(|x| (-1e-12..=10.0 + 1e-12).contains(x));
                assert!(is_inside, "{r}, {g}, {b}: {light}");
            }
        }
    }
}

/// The model of the CTL in one color, with the platform's own powers: J, M and h of linear R, G, B.
fn appearance_of(primaries: &Primaries, rgb: DVec3) -> [f64; 3] {
    let sharpened = Primaries {
        red: [0.8336, 0.1735],
        green: [2.3854, -1.4659],
        blue: [0.087, -0.125],
        white: [0.333, 0.333],
    };
    let cones = |rgb: DVec3| sharpened.from_xyz() * (primaries.to_xyz() * (rgb * 100.0));
    let level = 0.1 * 500_f64.cbrt();
    let white = cones(DVec3::ONE);
    let response = |x: f64| {
        let power = (level * x.abs()).powf(0.42);
        x.signum() * 400.0 * power / (power + 27.13)
    };
    let responses = |rgb: DVec3| (cones(rgb) / white).to_array().map(response);
    let achromatic = |[r, g, b]: [f64; 3]| 2.0 * r + g + 0.05 * b;
    let [r, g, b] = responses(rgb);
    let ratio = achromatic([r, g, b]) / achromatic(responses(DVec3::ONE));
    let (x, y) = (r - 12.0 * g / 11.0 + b / 11.0, (r + g - 2.0 * b) / 9.0);
    [
        100.0 * ratio.powf(0.59 * (1.48 + 0.2_f64.sqrt())),
        43.0 * 0.9 * x.hypot(y),
        y.atan2(x).to_degrees().rem_euclid(360.0),
    ]
}

#[test]
fn the_hue_stays() {
    // What is muted enough does not meet the screen's limits.
    for rgb in [[0.3, 0.2, 0.15], [0.1, 0.2, 0.12], [2.0, 2.2, 3.0]] {
        let scene = conversion(&Primaries::REC709, &Primaries::AP1) * DVec3::from_array(rgb);
        let [_, _, hue] = appearance_of(&Primaries::AP1, scene);
        let light = DVec3::from_array(of_one(&sdr(), rgb));
        let [_, _, shown] = appearance_of(&Primaries::REC709, light);
        assert!((hue - shown).abs() < 1e-6, "{rgb:?}: {hue}, {shown}");
    }
}

/// The tables of a screen.
fn tables(peak: f64, limiting: &Primaries) -> Tables {
    let view = Aces2::new(peak, limiting);
    Tables::new(&Source {
        reach: &view.scene,
        limiting: &view.screen,
        limits: &view.limits,
        compression: &view.compression,
        peak: view.peak,
        brightest: view.tone.brightest,
    })
}

#[test]
fn the_cusps_have_the_corners_of_the_gamut() {
    for (peak, limiting) in [
        (100.0, Primaries::REC709),
        (1000.0, Primaries::P3_D65),
        (4000.0, Primaries::REC2020),
    ] {
        let tables = tables(peak, &limiting);
        assert_eq!((tables.cusps.len(), tables.reach.len()), (361, 361));
        assert!(tables.cusps.is_sorted_by(|a, b| a.hue < b.hue));
        assert_eq!((tables.cusps[0].hue, tables.cusps[360].hue), (0.0, 360.0));
        for corner in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 1.0, 0.0)] {
            let [j, m, h] = appearance_of(&limiting, corner * (peak / 100.0));
            let off = |cusp: &&tables::Cusp| (cusp.hue - h).abs();
            let cusp = tables
                .cusps
                .iter()
                .min_by(|a, b| off(a).total_cmp(&off(b)))
                .unwrap();
            assert!((cusp.hue - h).abs() < 1e-6, "{h}: {}", cusp.hue);
            assert!((cusp.lightness - j).abs() < 1e-4, "{j}: {}", cusp.lightness);
            // The margin of the CTL: smoothM times smoothCusps.
            let m = m * (1.0 + 0.27 * 0.12);
            assert!(
                (cusp.colorfulness - m).abs() < 1e-4,
                "{m}: {}",
                cusp.colorfulness
            );
        }
    }
}

#[test]
fn the_reach_is_where_ap1_ends() {
    // On the faces of AP1's cube a channel is 0. At the peak's J, M at such a color's hue is what is reached.
    let tables = tables(100.0, &Primaries::REC709);
    for face in [
        [1.0, 0.4, 0.0],
        [0.0, 1.0, 0.3],
        [0.2, 0.0, 1.0],
        [1.0, 0.0, 0.6],
    ] {
        let mut ends = [0.0, 1e4];
        for _ in 0..100 {
            let middle = (ends[0] + ends[1]) / 2.0;
            let [j, _, _] = appearance_of(&Primaries::AP1, DVec3::from_array(face) * middle);
            ends[usize::from(j >= 100.0)] = middle;
        }
        let [_, m, h] = appearance_of(&Primaries::AP1, DVec3::from_array(face) * ends[1]);
        let (degree, t) = (h as usize, h.fract());
        let reach = tables.reach[degree] * (1.0 - t) + tables.reach[degree + 1] * t;
        // The search ends up to 0.0061 above, and a straight line stands for a degree of a curve.
        assert!((reach - m).abs() < 0.016, "{h}: {reach}, {m}");
    }
}
