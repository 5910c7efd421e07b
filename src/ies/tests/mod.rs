//! Files that are as the standard has them, and what the tests share.

mod broken;
mod flux;
mod hostile;
mod repaired;
mod symmetry;
mod types;

use std::io;

use super::*;
use crate::math::DVec3;

/// A file of LM-63-2002 from its angles and a function of them.
struct Text {
    first: &'static str,
    tilt: &'static str,
    lamps: &'static str,
    kind: u8,
    factors: &'static str,
    vertical: Vec<f64>,
    horizontal: Vec<f64>,
}

impl Text {
    fn new(kind: u8, vertical: &[f64], horizontal: &[f64]) -> Self {
        Self {
            first: "IESNA:LM-63-2002\n[TEST] 1\n[MANUFAC] none\n",
            tilt: "TILT=NONE\n",
            lamps: "1 -1 1",
            kind,
            factors: "1 1 10",
            vertical: vertical.to_vec(),
            horizontal: horizontal.to_vec(),
        }
    }

    fn of(&self, candela: impl Fn(f64, f64) -> f64) -> String {
        let numbers = |list: &[f64]| {
            let words: Vec<String> = list.iter().map(f64::to_string).collect();
            words.join(" ") + "\n"
        };
        let mut text = format!(
            "{}{}{} {} {} {} 2 0.1 0.2 0\n{}\n",
            self.first,
            self.tilt,
            self.lamps,
            self.vertical.len(),
            self.horizontal.len(),
            self.kind,
            self.factors
        );
        text += &numbers(&self.vertical);
        text += &numbers(&self.horizontal);
        for &h in &self.horizontal {
            let plane: Vec<f64> = self.vertical.iter().map(|&v| candela(v, h)).collect();
            text += &numbers(&plane);
        }
        text
    }
}

/// `count` angles from `first` to `last`.
fn steps(first: f64, last: f64, count: usize) -> Vec<f64> {
    let step = (last - first) / (count - 1) as f64;
    (0..count).map(|i| first + step * i as f64).collect()
}

fn parse(text: &str) -> IesFile {
    IesFile::parse(text.as_bytes()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// One without flaws.
fn parse_clean(text: &str) -> IesFile {
    let file = parse(text);
    assert_eq!(file.remarks.list(), [""; 0], "{text}");
    file
}

/// Directions all over the sphere.
fn directions() -> impl Iterator<Item = DVec3> {
    (0..400).map(|i| {
        let z = 1.0 - (f64::from(i) + 0.5) / 200.0;
        let (sin, cos) = libm::sincos(2.399_963_229_728_653 * f64::from(i));
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * cos, r * sin, z)
    })
}

fn assert_near(actual: f64, expected: f64, relative: f64) {
    let error = (actual - expected).abs();
    assert!(error <= relative * expected.abs(), "{actual} {expected}");
}

const DOWNLIGHT: &str = "IESNA:LM-63-2002\r\n[TEST] 17\r\n[MANUFAC] Lumen & Söhne\r\n[MORE] Berlin\r\n\
    [LAMP] LED\r\nTILT=NONE\r\n2 1000 0.5 3 1 1 1 -1 -1 0\r\n0.9 0.8 12.5\r\n0 45 90\r\n0\r\n100 80 10\r\n";

#[test]
fn a_file_is_read() {
    let file = parse_clean(DOWNLIGHT);
    assert_eq!(file.edition, Edition::Lm63_2002);
    assert_eq!(file.keyword("manufac"), Some("Lumen & Söhne\nBerlin"));
    assert_eq!(file.keyword("MORE"), None);
    let lamps = Lamps {
        count: 2.0,
        lumens: Some(1000.0),
    };
    assert_eq!((file.lamps, file.watts), (lamps, 12.5));
    assert_eq!(file.rated_lumens(), Some(2000.0));
    let opening = file.opening.unwrap();
    assert_eq!(opening.width, -0.3048);
    assert_eq!(file.tilt, Tilt::None);
    let photometry = &file.photometry;
    assert_eq!(photometry.coordinates(), Coordinates::C);
    assert_eq!(photometry.symmetry(), Symmetry::Axial);
    assert_eq!(photometry.angles(), (&[0.0, 45.0, 90.0][..], &[0.0][..]));
    let factor = 0.5 * 0.9 * 0.8;
    assert_near(photometry.value(1, 0).unwrap(), 80.0 * factor, 1e-15);
    assert_eq!(photometry.value(3, 0), None);
    assert_eq!(photometry.value(0, 1), None);
    let down = DVec3::new(0.0, 0.0, 2.0);
    assert_near(photometry.intensity(down), 100.0 * factor, 1e-15);
    assert_eq!(photometry.intensity(-down), 0.0);
    let halved = photometry.clone().scaled(0.5);
    assert_near(halved.intensity(down), 50.0 * factor, 1e-15);
}

#[test]
fn editions() {
    let with = |first: &str| {
        let text = DOWNLIGHT.replacen("IESNA:LM-63-2002\r\n", first, 1);
        parse(&text)
    };
    for (first, edition) in [
        ("IESNA91\n", Edition::Lm63_1991),
        ("IESNA:LM-63-1995\n", Edition::Lm63_1995),
        ("IESNA:LM-63-2002\n", Edition::Lm63_2002),
        ("iesna: lm-63-2002  \n", Edition::Lm63_2002),
        ("IES:LM-63-2019\n", Edition::Lm63_2019),
        ("IESNA86\n", Edition::Lm63_1986),
        ("IESNA:LM-63-1986\n", Edition::Lm63_1986),
    ] {
        let file = with(first);
        assert_eq!(file.edition, edition, "{first}");
        assert!(file.remarks.is_empty(), "{first}");
        // In LM-63-2019 the second factor is none.
        let is_2019 = edition == Edition::Lm63_2019;
        assert_eq!(file.generation, is_2019.then_some(0.8));
        let factor = 0.5 * 0.9 * if is_2019 { 1.0 } else { 0.8 };
        assert_near(file.photometry.peak().candela, 100.0 * factor, 1e-15);
    }
    assert!(with("").remarks.no_edition);
    assert!(with("IESNA:LM-63-2077\n").remarks.unknown_edition);
    // A file of 1986 has lines of any text, and nothing is amiss.
    let old = "A lamp\nof 1986\nTILT=NONE\n1 1000 1 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n5 5\n";
    assert_eq!(parse_clean(old).edition, Edition::Lm63_1986);
}

#[test]
fn tilt_is_read_and_applied_at_rest() {
    let text = DOWNLIGHT.replace(
        "TILT=NONE\r\n",
        "TILT=INCLUDE\r\n1\r\n4\r\n0 30 60 90\r\n1.25 1 0.9 0.8\r\n",
    );
    let file = parse_clean(&text);
    let Tilt::Factors(factors) = &file.tilt else {
        panic!("{:?}", file.tilt);
    };
    assert_eq!(factors.geometry, LampGeometry::Vertical);
    assert_eq!(factors.angles, [0.0, 30.0, 60.0, 90.0]);
    assert_near(factors.at(45.0), 0.95, 1e-15);
    assert_eq!((factors.at(-10.0), factors.at(100.0)), (1.25, 0.8));
    assert_eq!(file.factors.tilt, 1.25);
    let expected = 100.0 * 0.5 * 0.9 * 0.8 * 1.25;
    assert_near(file.photometry.peak().candela, expected, 1e-15);
}

#[test]
fn tilt_files() {
    let text = DOWNLIGHT.replace("NONE", "MH 400.TLT");
    let file = parse(&text);
    assert_eq!(file.tilt, Tilt::File("MH 400.TLT".to_owned()));
    assert!(file.remarks.unread_tilt);
    let given = |bytes: &'static str| {
        IesFile::parse_with(text.as_bytes(), move |name| {
            assert_eq!(name, "MH 400.TLT");
            Ok::<_, io::Error>(bytes.as_bytes().to_vec())
        })
    };
    let file = given("3\n2\n0 90\n1 0.5\n").unwrap();
    assert!(matches!(file.tilt, Tilt::Factors(_)));
    assert!(file.remarks.is_empty());
    assert_eq!(
        given("3\n2\n0 90\n1 x\n").unwrap_err().to_string(),
        "tilt file `MH 400.TLT`, line 4, column 3: found `x`, expected a tilt factor"
    );
    let empty = given("").unwrap_err().to_string();
    assert!(
        empty.contains("`MH 400.TLT` cannot be read: the file is empty"),
        "{empty}"
    );
    let error = IesFile::parse_with(text.as_bytes(), |_| Err("gone")).unwrap_err();
    assert_eq!(
        error.to_string(),
        "line 6: the file of tilt factors `MH 400.TLT` cannot be read: gone; expected it beside the IES \
            file; without it, write `TILT=NONE`"
    );
}

#[test]
fn files_on_disk() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lamp.ies");
    let text = DOWNLIGHT.replace("NONE", r"C:\lamps\a.tlt");
    std::fs::write(&path, text).unwrap();
    let error = IesFile::load(&path).unwrap_err();
    assert!(error.to_string().contains("line 6"), "{error}");
    std::fs::write(folder.path().join("a.tlt"), "1 1 0 1").unwrap();
    assert_eq!(IesFile::load(&path).unwrap().factors.tilt, 1.0);
    let error = IesFile::load(folder.path()).unwrap_err();
    assert_eq!(error.to_string(), "it is a directory, expected an IES file");
    let error = IesFile::load(&folder.path().join("absent.ies")).unwrap_err();
    assert!(matches!(error, IesError::Io(_)) && !error.is_transient());
    assert!(IesError::NoMemory.is_transient());
}

#[test]
fn what_is_no_luminaire_file() {
    let message = |bytes: &[u8]| IesFile::parse(bytes).unwrap_err().to_string();
    assert!(message(b"").contains("empty"));
    assert!(message(b"\xef\xbb\xbf").contains("empty"));
    let wide: Vec<u8> = DOWNLIGHT
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    assert!(message(&wide).contains("save it as UTF-8"));
    assert!(message(b"\x1f\x8b\x08\0").contains("unpack it"));
    let large = vec![b' '; (16 << 20) + 1];
    assert!(message(&large).contains("more than 16 MB"));
}

#[test]
fn peak_beam_and_field() {
    // Linear from 100 at 0° to 0 at 50°: half at 25°, a tenth at 45°.
    let text = Text::new(1, &[0.0, 50.0, 90.0], &[0.0]).of(|v, _| (100.0 - 2.0 * v).max(0.0));
    let cone = parse_clean(&text).photometry;
    let both = |width: Widths| [width.plane_0.unwrap(), width.plane_90.unwrap()];
    for width in both(cone.beam_angle()) {
        assert_near(width, 50.0, 1e-14);
    }
    for width in both(cone.field_angle()) {
        assert_near(width, 90.0, 1e-14);
    }
    assert_eq!(cone.peak().direction, DVec3::Z);
    // To the ceiling: as wide about straight up. It ends at once where the table ends.
    let text = Text::new(1, &[90.0, 130.0, 180.0], &[0.0, 90.0]).of(|v, h| {
        if h == 0.0 {
            (2.0 * v - 260.0).max(0.0)
        } else {
            7.0
        }
    });
    let ceiling = parse_clean(&text).photometry;
    let [plane_0, plane_90] = both(ceiling.beam_angle());
    assert_near(plane_0, 50.0, 1e-13);
    assert_near(plane_90, 180.0, 1e-15);
    // A dip on the axis is within; a plane without light has no width.
    let batwing = Text::new(1, &[0.0, 40.0, 60.0, 80.0], &[0.0, 90.0]).of(|v, h| match v {
        _ if h == 90.0 => 0.0,
        0.0 => 1.0,
        80.0 => 0.0,
        _ => 10.0,
    });
    let batwing = parse(&batwing).photometry;
    let width = batwing.beam_angle();
    assert_near(width.plane_0.unwrap(), 140.0, 1e-14);
    assert_eq!(width.plane_90, None);
}

#[test]
fn polar_curves() {
    let text = Text::new(1, &steps(0.0, 180.0, 7), &steps(0.0, 360.0, 5)).of(|v, h| v + h % 360.0);
    let photometry = parse_clean(&text).photometry;
    let curve = photometry.polar_curve(90.0, 7);
    assert_eq!(
        curve,
        [
            (-180.0, 450.0),
            (-120.0, 390.0),
            (-60.0, 330.0),
            (0.0, 90.0),
            (60.0, 150.0),
            (120.0, 210.0),
            (180.0, 270.0),
        ]
    );
    assert_eq!(photometry.polar_curve(0.0, 0), []);
    assert_eq!(photometry.polar_curve(0.0, 1).len(), 1);
}

/// No direction is brighter than the bound, and the bound is met.
#[test]
fn bounds_hold() {
    for kind in 1..=3 {
        let (vertical, horizontal) = match kind {
            1 => (steps(0.0, 180.0, 13), steps(0.0, 360.0, 13)),
            _ => (steps(-90.0, 90.0, 13), steps(-90.0, 90.0, 7)),
        };
        let text = Text::new(kind, &vertical, &horizontal);
        let text = text.of(|v, h| ((v * 0.37 + (h % 360.0) * 0.11).sin() * 50.0).abs().floor());
        let photometry = parse(&text).photometry;
        for axis in directions().step_by(7) {
            for half in [0.5, 10.0, 60.0, 100.0] {
                let bound = photometry.largest_in_cone(axis, half);
                let inside = directions().filter(|d| d.dot(axis) >= libm::cos(half.to_radians()));
                for direction in inside.chain([axis]) {
                    assert!(photometry.intensity(direction) <= bound * (1.0 + 1e-12));
                }
            }
        }
        assert_eq!(
            photometry.largest_in_cone(DVec3::X, 180.0),
            photometry.peak().candela
        );
    }
    let text = Text::new(1, &[0.0, 90.0], &[0.0, 90.0]).of(|v, h| v + h);
    let quarter = parse_clean(&text).photometry;
    let near = |actual: f64, expected: f64| assert_near(actual, expected, 1e-12);
    near(quarter.largest_in(10.0..=20.0, 30.0..=40.0), 60.0);
    near(quarter.largest_in(10.0..=20.0, 80.0..=110.0), 110.0);
    near(quarter.largest_in(10.0..=20.0, 350.0..=375.0), 35.0);
    near(quarter.largest_in(10.0..=20.0, -20.0..=-15.0), 40.0);
    assert_eq!(quarter.largest_in(100.0..=120.0, 0.0..=360.0), 0.0);
}
