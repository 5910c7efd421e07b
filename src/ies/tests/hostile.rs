//! Bytes of any kind: an error or a table, and no panic.

use proptest::prelude::*;

use super::*;

fn corpus() -> Vec<String> {
    let tilt = "TILT=INCLUDE\r\n1\r\n2\r\n0 90\r\n1 0.9\r\n";
    let table = |kind, vertical: &[f64], horizontal: &[f64]| {
        Text::new(kind, vertical, horizontal).of(|v, h| 300.0 - v - h / 3.0)
    };
    vec![
        DOWNLIGHT.to_owned(),
        DOWNLIGHT.replace("TILT=NONE\r\n", tilt),
        DOWNLIGHT.replace("NONE", "other.tlt"),
        table(1, &steps(0.0, 90.0, 4), &steps(0.0, 360.0, 5)),
        table(1, &steps(0.0, 180.0, 4), &steps(90.0, 270.0, 5)),
        table(2, &steps(-90.0, 90.0, 4), &steps(-90.0, 90.0, 5)),
        table(3, &steps(-90.0, 90.0, 4), &steps(0.0, 90.0, 3)),
        "TILT=NONE\n1 -1 1,5 2 1 1 2 0,1 0,1 0,0\n1,0 1,0 10,0\n0,0 90,0\n0,0\n1,5 0,5\n"
            .to_owned(),
    ]
}

/// What is read keeps what it promises.
fn look(bytes: &[u8]) {
    let tilt = |_: &str| Ok::<_, io::Error>(bytes.to_vec());
    for file in [IesFile::parse(bytes), IesFile::parse_with(bytes, tilt)] {
        let file = match file {
            Ok(file) => file,
            Err(error) => {
                let text = error.to_string();
                assert!(text.contains("expected"), "{text}");
                continue;
            }
        };
        let _ = file.remarks.list();
        let photometry = &file.photometry;
        let (vertical, horizontal) = photometry.angles();
        assert!(vertical.is_sorted_by(|a, b| a < b) && vertical.len() > 1);
        assert!(horizontal.is_sorted_by(|a, b| a < b) && !horizontal.is_empty());
        let peak = photometry.peak();
        assert!(peak.candela > 0.0 && peak.candela.is_finite());
        assert!(photometry.lumens().is_finite() && photometry.zonal_lumens() >= 0.0);
        for direction in directions()
            .step_by(41)
            .chain([peak.direction, DVec3::ZERO])
        {
            let value = photometry.intensity(direction);
            assert!((0.0..=peak.candela * (1.0 + 1e-12)).contains(&value));
        }
        for width in [photometry.beam_angle(), photometry.field_angle()] {
            for width in [width.plane_0, width.plane_90].into_iter().flatten() {
                assert!((0.0..=360.0).contains(&width));
            }
        }
        let _ = (
            photometry.polar_curve(30.0, 5),
            photometry.largest_in_cone(DVec3::X, 20.0),
        );
    }
}

/// One change: what to do, where, and with what.
type Mutation = (u8, usize, Vec<u8>);

fn mutate(bytes: &mut Vec<u8>, (what, at, with): &Mutation) {
    if bytes.is_empty() {
        return;
    }
    let at = at % bytes.len();
    match what % 5 {
        0 => bytes.truncate(at),
        1 => drop(bytes.splice(at..at, with.iter().copied())),
        2 => {
            let end = (at + with.len()).min(bytes.len());
            bytes.splice(at..end, with.iter().copied());
        }
        3 => drop(bytes.drain(at..(at + with.len()).min(bytes.len()))),
        _ => {
            let end = (at + 20).min(bytes.len());
            let part = bytes[at..end].to_vec();
            bytes.extend(part);
        }
    }
}

fn pieces() -> impl Strategy<Value = Vec<u8>> {
    let words = [
        " ",
        "\n",
        "\r",
        ",",
        "0",
        "-1",
        "90",
        "180",
        "360",
        "1e30",
        "1e-300",
        "nan",
        "inf",
        "4294967296",
        "18446744073709551616",
        "TILT=NONE\n",
        "TILT=INCLUDE\n",
        "[MORE] ",
        "\0",
        "\u{feff}",
        "0,5",
        "1.",
        "-",
        "65536",
        "1 2 3 4 5 6 7 8 9 ",
    ];
    let words = words.map(|word| word.as_bytes().to_vec()).to_vec();
    prop_oneof![
        prop::sample::select(words),
        prop::collection::vec(any::<u8>(), 1..4),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        look(&bytes);
        look(&[b"TILT=NONE\n", &bytes[..]].concat());
    }

    #[test]
    fn any_numbers(numbers in prop::collection::vec(prop_oneof![0_i32..5, -200_i32..400], 0..80)) {
        let words: Vec<String> = numbers.iter().map(i32::to_string).collect();
        look(format!("TILT=NONE\n1 -1 1 {}", words.join(" ")).as_bytes());
    }

    #[test]
    fn damaged_files(
        which in 0_usize..8,
        mutations in prop::collection::vec((any::<u8>(), any::<usize>(), pieces()), 1..6),
    ) {
        let mut bytes = corpus().swap_remove(which).into_bytes();
        for mutation in &mutations {
            mutate(&mut bytes, mutation);
        }
        look(&bytes);
    }
}

/// A file cut off anywhere is an error or, where only blanks are gone, whole.
#[test]
fn every_cut() {
    for text in corpus() {
        for end in 0..text.len() {
            look(&text.as_bytes()[..end]);
        }
    }
}
