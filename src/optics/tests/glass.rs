//! Indices against what is published of them.

use super::*;
use crate::optics::sellmeier::Sellmeier;

/// Fraunhofer's lines d, F and C in nm.
const D: f64 = 587.5618;
const F: f64 = 486.1327;
const C: f64 = 656.2725;

/// V_d = (n_d − 1)/(n_F − n_C).
fn abbe(glass: &Sellmeier) -> f64 {
    (glass.index(D) - 1.0) / (glass.index(F) - glass.index(C))
}

#[track_caller]
fn assert_index_and_abbe(
    name: &str,
    nm: f64,
    (n, n_decimals): (f64, i32),
    (v, v_decimals): (f64, i32),
) {
    let glass = Glass::named(name).unwrap().dispersion;
    assert_published(glass.index(nm), n, n_decimals);
    assert_published(abbe(&glass), v, v_decimals);
}

/// n_d and V_d with their decimals.
#[test]
fn indices_and_abbe_numbers() {
    let published = [
        // Schott's catalog of 20 January 2017.
        ("N-FK51A", (1.48656, 5), (84.47, 2)),
        ("N-BK7", (1.5168, 5), (64.17, 2)),
        ("N-K5", (1.52249, 5), (59.48, 2)),
        ("N-BAK4", (1.56883, 5), (55.98, 2)),
        ("N-SK16", (1.62041, 5), (60.32, 2)),
        ("N-LAK10", (1.72003, 5), (50.62, 2)),
        ("F2", (1.62004, 5), (36.37, 2)),
        ("N-F2", (1.62005, 5), (36.43, 2)),
        ("N-SF11", (1.78472, 5), (25.68, 2)),
        ("N-SF6", (1.80518, 5), (25.36, 2)),
        ("N-SF66", (1.92286, 5), (20.88, 2)),
    ];
    for (name, n, v) in published {
        assert_index_and_abbe(name, D, n, v);
    }
    // refractiveindex.info, which has 587.6 nm for d; V_d of silica is Nikon's of NIFS-S, 67.826.
    let published = [
        ("fused-silica", (1.45846, 5), (67.8, 1)),
        ("diamond", (2.41748, 5), (55.30, 2)),
        ("water", (1.3334, 4), (55.76, 2)),
    ];
    for (name, n, v) in published {
        assert_index_and_abbe(name, 587.6, n, v);
    }
}

/// Those whose Abbe number is not published with its index, against tables.
#[test]
fn tabulated_indices() {
    let published: [(&str, &[[f64; 2]], f64); 2] = [
        // Crystran's handbook, 2023.
        (
            "calcium-fluoride",
            &[
                [400.0, 1.4419],
                [486.0, 1.4370],
                [588.0, 1.4339],
                [656.0, 1.4325],
                [687.0, 1.4320],
                [728.0, 1.4314],
            ],
            1e-4,
        ),
        // Valley Design, "Index of Refraction for Sapphire", n_o.
        (
            "sapphire",
            &[
                [365.0, 1.793],
                [442.0, 1.78038],
                [458.0, 1.77843],
                [488.0, 1.7753],
                [515.0, 1.77304],
                [532.0, 1.7717],
                [590.0, 1.76804],
                [633.0, 1.7659],
                [670.0, 1.76433],
                [694.0, 1.76341],
                [780.0, 1.76068],
                [820.0, 1.75961],
            ],
            5e-4,
        ),
    ];
    for (name, table, tolerance) in published {
        let glass = Glass::named(name).unwrap().dispersion;
        for [nm, n] in table {
            let error = (glass.index(*nm) - n).abs();
            assert!(error <= tolerance, "{name}, {nm}: {error}");
        }
    }
}

#[test]
fn indices_to_all_digits() {
    let of = |name| Glass::named(name).unwrap().dispersion;
    let glass = of("N-BK7");
    assert_published(glass.index(400.0), 1.530_848_538_25, 11);
    assert_published(glass.index(550.0), 1.518_522_387_62, 11);
    assert_published(glass.index(700.0), 1.513_063_997_20, 11);
    for (name, n, v) in [
        ("N-BK7", 1.516_800, 64.167),
        ("N-SF11", 1.784_720, 25.680),
        ("fused-silica", 1.458_464, 67.821),
    ] {
        assert_published(of(name).index(D), n, 6);
        assert_published(abbe(&of(name)), v, 3);
    }
}

#[test]
fn every_glass_holds_where_light_is_seen() {
    for glass in Glass::ALL {
        let Glass {
            name,
            dispersion,
            fitted: [from, to],
            ..
        } = glass;
        assert!(dispersion.holds(360.0, 830.0), "{name}");
        assert!(from <= 390.0 && to >= 760.0 && from < to, "{name}");
        let indices = (360..=830).map(|nm| dispersion.index(f64::from(nm)));
        assert!(indices.is_sorted_by(|a, b| a > b), "{name}");
    }
}

#[test]
fn names_are_found() {
    for name in Glass::names() {
        assert_eq!(Glass::named(name).unwrap().name, name);
        assert_eq!(Glass::names().filter(|other| *other == name).count(), 1);
    }
    assert!(Glass::named("n-bk7").is_none());
}

#[test]
fn coefficients_without_an_index() {
    let glass = Sellmeier::three([1.0, 0.2, 1.0], [0.006, 0.02, 100.0]);
    assert!(glass.holds(360.0, 830.0));
    let with = |place: usize, b, c| {
        let mut changed = glass;
        (changed.b[place], changed.c[place]) = (b, c);
        changed
    };
    // A resonance within, at either end, and just beside.
    assert!(!with(1, 0.2, 0.25).holds(360.0, 830.0));
    assert!(!with(1, 0.2, 0.36 * 0.36).holds(360.0, 830.0));
    assert!(!with(1, 0.2, 0.83 * 0.83).holds(360.0, 830.0));
    assert!(with(1, 0.2, 0.1295).holds(360.0, 830.0));
    // An index below 1, or none.
    assert!(!with(0, -1.0, 0.006).holds(360.0, 830.0));
    assert!(!with(2, 3.0, 0.7).holds(360.0, 830.0));
    for (b, c) in [
        (f64::NAN, 0.01),
        (1.0, f64::NAN),
        (f64::INFINITY, 0.01),
        (1.0, f64::INFINITY),
    ] {
        assert!(!with(0, b, c).holds(360.0, 830.0), "{b}, {c}");
    }
    // Not a range.
    assert!(!glass.holds(830.0, 360.0));
    assert!(!glass.holds(0.0, 830.0) && !glass.holds(f64::NAN, 830.0));
    assert!(!glass.holds(360.0, f64::INFINITY));
    // Vacuum.
    let nothing = Sellmeier::three([0.0; 3], [0.0; 3]);
    assert!(nothing.holds(360.0, 830.0));
    assert_eq!(nothing.index(500.0), 1.0);
}
