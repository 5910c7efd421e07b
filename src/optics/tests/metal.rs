//! Tables of metals.

use super::*;

fn along_the_normal(metal: &Metal, nm: f64) -> f64 {
    let [n, k] = metal.index(nm);
    conductor(1.0, n, k)
}

#[test]
fn tables_reach_over_the_grid() {
    for metal in Metal::ALL {
        let (name, points) = (metal.name, metal.points);
        assert!(points.is_sorted_by(|a, b| a[0] < b[0]), "{name}");
        assert!(points[0][0] < 360.0 && points[points.len() - 1][0] > 830.0);
        assert!(points.iter().flatten().all(|number| *number > 0.0));
    }
}

#[test]
fn indices_are_linear_between_points() {
    let gold = Metal::named("gold").unwrap();
    assert_eq!(gold.index(548.6), [0.43, 2.455]);
    let [n, k] = gold.index((548.6 + 582.1) / 2.0);
    assert!((n - 0.36).abs() < 1e-14 && (k - 2.659).abs() < 1e-14);
    let [first, last] = [gold.points[0], gold.points[gold.points.len() - 1]];
    for nm in [0.0, 100.0, first[0]] {
        assert_eq!(gold.index(nm), [first[1], first[2]]);
    }
    for nm in [last[0], 1e4] {
        assert_eq!(gold.index(nm), [last[1], last[2]]);
    }
}

/// At 550 nm, against n and k of others who measured the same metal.
#[test]
fn reflectances_are_those_of_other_measurements() {
    let others = [
        // McPeak et al. 2015, ACS Photonics 2, 326.
        ("aluminum", 0.789_405_353, 5.851_936_501, 0.01),
        ("copper", 0.797_459_94, 2.564_204_04, 0.06),
        ("silver", 0.043_817_181, 3.610_113_564, 0.01),
        // Olmon et al. 2012, Phys. Rev. B 86, 235147: evaporated gold.
        ("gold", 0.325_6, 2.507, 0.05),
        // Querry 1985, Contractor Report CRDC-CR-85034.
        ("iron", 2.189, 3.171, 0.06),
        // Rakić et al. 1998, Appl. Opt. 37, 5271, at 547.79 nm.
        ("nickel", 1.812_7, 3.262_5, 0.05),
        // Mash and Motulevich 1973, Sov. Phys. JETP 36, 516, between 540 and 560 nm.
        ("titanium", 2.245, 2.925, 0.06),
    ];
    for (name, n, k, tolerance) in others {
        let own = along_the_normal(Metal::named(name).unwrap(), 550.0);
        let other = conductor(1.0, n, k);
        assert!((own - other).abs() < tolerance, "{name}: {own}, {other}");
    }
}

/// Copper and gold are dark in the blue and bright in the red; the others are nearly gray.
#[test]
fn colors_of_metals() {
    for metal in &Metal::ALL {
        let [blue, red] = [450.0, 650.0].map(|nm| along_the_normal(metal, nm));
        if ["copper", "gold"].contains(&metal.name) {
            assert!(blue < 0.6 && red > 0.9, "{}: {blue}, {red}", metal.name);
        } else {
            assert!((red - blue).abs() < 0.15, "{}: {blue}, {red}", metal.name);
        }
    }
}

#[test]
fn names_are_found() {
    for name in Metal::names() {
        assert_eq!(Metal::named(name).unwrap().name, name);
        assert_eq!(Metal::names().filter(|other| *other == name).count(), 1);
    }
    assert!(Metal::named("Gold").is_none());
}
