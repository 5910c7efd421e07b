//! What is read although it is not as it should be: the same table, and a remark.

use super::*;

/// The files of this test, without a flaw.
const GOOD: &str = "IESNA:LM-63-2002\n[TEST] 1\nTILT=NONE\n1 1000 1 3 5 1 2 0.1 0.2 0\n1 1 10\n0 45 90\n\
    0 90 180 270 360\n100 80 10.5\n100 70 5\n100 60 0\n100 50 4\n100 80 10.5\n";

/// Another form of the good file has the same intensities and these remarks alone.
#[expect(
    clippy::needless_pass_by_value,
    reason = "remarks are written where they are expected"
)]
fn same(text: &[u8], expected: IesRemarks) {
    let good = parse_clean(GOOD);
    let file = IesFile::parse(text);
    let shown = String::from_utf8_lossy(text);
    let file = file.unwrap_or_else(|error| panic!("{error}\n{shown}"));
    assert_eq!(file.remarks, expected, "{shown}");
    assert_eq!(file.remarks.list().is_empty(), file.remarks.is_empty());
    for direction in directions() {
        let (a, b) = (
            file.photometry.intensity(direction),
            good.photometry.intensity(direction),
        );
        assert!((a - b).abs() <= 1e-12 * b, "{direction} {a} {b}\n{shown}");
    }
}

fn replaced(part: &str, instead: &str) -> Vec<u8> {
    assert!(GOOD.contains(part), "{part}");
    GOOD.replacen(part, instead, 1).into_bytes()
}

/// What the standard allows, or what means nothing.
#[test]
fn forms_without_a_remark() {
    let none = IesRemarks::default;
    same(GOOD.as_bytes(), none());
    same(GOOD.replace('\n', "\r\n").as_bytes(), none());
    same(GOOD.replace("NONE\n", "NONE\n\n\n").as_bytes(), none());
    let (head, numbers) = GOOD.split_once("NONE\n").unwrap();
    let with = |numbers: String| format!("{head}NONE\n{numbers}").into_bytes();
    same(&with(numbers.replace([' ', '\n'], "\n")), none());
    same(&with(numbers.replace(' ', ", ")), none());
    same(
        &with(numbers.replace(' ', ",").replace('\n', ",\n")),
        none(),
    );
    same(&with(numbers.replace(' ', "\t")), none());
    same(&with(numbers.replace("\n0 90 ", " 0 90\n")), none());
    same(&with(numbers.replace("100 ", "1.0E+2 ")), none());
    same(&with(numbers.replace("100 ", "+100. ")), none());
    same(&with(numbers.replace("0.1 0.2", ".1 .2")), none());
    same(
        &with(numbers.replace("1 1000 1 3 5 1 2", "1.0 1000 1.0 3.0 5.0 1.0 2.0")),
        none(),
    );
    same(&with(format!("{numbers}\0\0\x1a\r\n")), none());
    same(GOOD.trim_end().as_bytes(), none());
    // −1 lumens are absolute photometry.
    same(&replaced("1 1000", "1 -1"), none());
    same(
        &replaced("[TEST] 1", "[TEST] 1\n[MORE] and on\n\n[_OWN] é"),
        none(),
    );
}

#[test]
fn repairs_are_counted() {
    let none = IesRemarks::default;
    let mark = [b"\xef\xbb\xbf", GOOD.as_bytes()].concat();
    same(
        &mark,
        IesRemarks {
            byte_order_mark: true,
            ..none()
        },
    );
    let old = GOOD.replace('\n', "\r");
    same(
        old.as_bytes(),
        IesRemarks {
            carriage_returns: true,
            ..none()
        },
    );
    for (part, instead, expected) in [
        (
            "IESNA:LM-63-2002\n",
            "",
            IesRemarks {
                no_edition: true,
                ..none()
            },
        ),
        (
            "63-2002",
            "63-2012",
            IesRemarks {
                unknown_edition: true,
                ..none()
            },
        ),
        (
            "[TEST] 1\n",
            "[TEST] 1\na lamp\n(new)\n",
            IesRemarks {
                plain_lines: 2,
                ..none()
            },
        ),
        (
            "[TEST] 1",
            "[test] 1\n[Lamp] 2",
            IesRemarks {
                small_keywords: 2,
                ..none()
            },
        ),
        (
            "TILT=NONE",
            "TILT= NONE",
            IesRemarks {
                loose_tilt: true,
                ..none()
            },
        ),
        (
            "TILT=NONE",
            "TILT =NONE",
            IesRemarks {
                loose_tilt: true,
                ..none()
            },
        ),
        (
            "TILT=NONE",
            "tilt=none",
            IesRemarks {
                loose_tilt: true,
                ..none()
            },
        ),
        (
            "TILT=NONE",
            "TILT=",
            IesRemarks {
                loose_tilt: true,
                ..none()
            },
        ),
        (
            "TILT=NONE",
            "TILT=LAMP.TLT",
            IesRemarks {
                unread_tilt: true,
                ..none()
            },
        ),
        (
            "1 1000",
            "1 -1000",
            IesRemarks {
                odd_lumens: true,
                ..none()
            },
        ),
        (
            "\n1 1 10",
            "\n1 0 10",
            IesRemarks {
                no_ballast_lamp_factor: true,
                ..none()
            },
        ),
        (
            "1 2 0.1",
            "1 0 0.1",
            IesRemarks {
                unknown_unit: true,
                ..none()
            },
        ),
        (
            "50 4\n100 80 10.5\n",
            "50 4\n100 80 10.4\n",
            IesRemarks {
                open_seam: 1,
                ..none()
            },
        ),
        (
            "50 4\n100 80 10.5\n",
            "50 4\n99 81 10.4\n",
            IesRemarks {
                open_seam: 3,
                ..none()
            },
        ),
        (
            "60 0",
            "60 -0.5",
            IesRemarks {
                negative_values: 1,
                ..none()
            },
        ),
        (
            "50 4\n100 80 10.5\n",
            "50 4\n100 80 10.5\n1 2 3",
            IesRemarks {
                extra_numbers: 3,
                ..none()
            },
        ),
        (
            "50 4\n100 80 10.5\n",
            "50 4\n100 80 10.5\nend of file\n",
            IesRemarks {
                trailing_bytes: 11,
                ..none()
            },
        ),
        (
            "0 45 90\n",
            "0 45 89.9999\n",
            IesRemarks {
                rounded_angles: 1,
                ..none()
            },
        ),
        (
            "270 360",
            "270 359.9999",
            IesRemarks {
                rounded_angles: 1,
                ..none()
            },
        ),
        (" 5 1 2 ", " 4 1 2 ", IesRemarks { ..none() }),
    ] {
        if part == " 5 1 2 " {
            // No plane at 360.
            let text = GOOD.replace(part, instead).replace(" 360", "");
            let text = text.replace("50 4\n100 80 10.5\n", "50 4\n");
            same(
                text.as_bytes(),
                IesRemarks {
                    added_plane: true,
                    ..expected
                },
            );
        } else {
            same(&replaced(part, instead), expected);
        }
    }
    let mut latin1 = replaced("[TEST] 1", "[TEST] 1\n[MANUFAC] S?hne");
    let at = latin1.iter().position(|&byte| byte == b'?').unwrap();
    latin1[at] = 0xf6;
    same(
        &latin1,
        IesRemarks {
            latin1_lines: 1,
            ..none()
        },
    );
    assert_eq!(
        IesFile::parse(&latin1).unwrap().keyword("MANUFAC"),
        Some("Söhne")
    );
    let long = replaced("[TEST] 1", &format!("[TEST] {}", "x".repeat(300)));
    same(
        &long,
        IesRemarks {
            long_lines: 1,
            ..none()
        },
    );
    // Numbers on the line of TILT, and the tail of a spreadsheet.
    same(&replaced("NONE\n1 1000", "NONE,,, 1 1000"), none());
}

#[test]
fn angles_in_any_order() {
    let none = IesRemarks::default;
    let body = |angles: &str, planes: &str| {
        let (head, _) = GOOD.split_once("0 45 90\n").unwrap();
        format!("{head}{angles}\n{planes}\n").into_bytes()
    };
    let sorted = IesRemarks {
        unsorted_lists: 1,
        ..none()
    };
    let text = body(
        "90 0 45\n0 90 180 270 360",
        "10.5 100 80 5 100 70 0 100 60 4 100 50 10.5 100 80",
    );
    same(&text, sorted.clone());
    let text = body(
        "0 45 90\n360 270 180 90 0",
        "100 80 10.5 100 50 4 100 60 0 100 70 5 100 80 10.5",
    );
    same(&text, sorted);
    let twice = GOOD
        .replace(" 3 5 1 ", " 4 5 1 ")
        .replace("0 45 90", "0 45 45 90");
    let twice = twice.replace(" 80 ", " 80 80 ").replace(" 70 ", " 70 70 ");
    let twice = twice.replace(" 60 ", " 60 60 ").replace(" 50 ", " 50 50 ");
    same(
        twice.as_bytes(),
        IesRemarks {
            repeated_angles: 1,
            ..none()
        },
    );
    let turned = IesRemarks {
        turned_planes: true,
        ..none()
    };
    let text = body(
        "0 45 90\n-180 -90 0 90 180",
        "100 60 0 100 50 4 100 80 10.5 100 70 5 100 60 0",
    );
    same(&text, turned.clone());
    let text = body(
        "0 45 90\n90 180 270 360 450",
        "100 70 5 100 60 0 100 50 4 100 80 10.5 100 70 5",
    );
    same(&text, turned.clone());
    let text = body(
        "0 45 90\n180 270 0 90 180",
        "100 60 0 100 50 4 100 80 10.5 100 70 5 100 60 0",
    );
    same(&text, turned);
    let partial = Text::new(1, &[0.0, 80.0], &[0.0]).of(|_, _| 1.0);
    assert_eq!(
        parse(&partial).remarks,
        IesRemarks {
            partial_range: true,
            ..none()
        }
    );
    let partial = Text::new(2, &[-60.0, 60.0], &[-60.0, 60.0]).of(|_, _| 1.0);
    assert!(parse(&partial).remarks.partial_range);
}

#[test]
fn fortran_exponents() {
    let text = GOOD.replace("100 80", "1.0D2 8.d+1");
    let file = parse(&text);
    assert_eq!(file.remarks.fortran_exponents, 4);
    assert_eq!(file.photometry, parse(GOOD).photometry);
    for word in ["D2", "1D", "1D2D3", "1e2d3"] {
        let error = IesFile::parse(GOOD.replace("100", word).as_bytes());
        assert!(error.unwrap_err().to_string().contains(word));
    }
}

#[test]
fn decimal_commas() {
    let text = GOOD.replace('.', ",");
    let file = parse(&text);
    assert_eq!(file.remarks.decimal_commas, 4);
    assert_eq!(file.photometry, parse(GOOD).photometry);
    // With all numbers so, and a list parted by commas and blanks.
    let text = GOOD.replace(".5", ",5").replace("100 80", "100,0, 80,0");
    let file = parse(&text.replace("0.1 0.2", "0,1 0,2"));
    assert_eq!(file.photometry, parse(GOOD).photometry);
    // Both ways of reading them leave numbers over.
    let text = "TILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 1\n0 90\n0\n1,5 2,5 3,5\n";
    let error = IesFile::parse(text.as_bytes()).unwrap_err().to_string();
    assert_eq!(
        error,
        "line 6, column 2: commas that may be decimal points or part numbers, expected decimal points; \
            replace the commas by points, or put blanks between the numbers"
    );
}
