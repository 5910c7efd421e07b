//! What is refused: with its line and column, what was expected and the way out.

use super::*;

const GOOD: &str = "IESNA:LM-63-2002\n[TEST] 1\nTILT=NONE\n1 1000 1 3 2 1 2 0.1 0.2 0\n1 1 10\n0 45 90\n0 90\n\
    100 80 10\n100 70 5\n";

/// Each replaces a part of the good file, and what the message then says.
const BROKEN: [(&str, &str, &str); 63] = [
    (
        "TILT=NONE\n",
        "",
        "line 9, column 1: the file ends, expected a line `TILT=NONE`",
    ),
    ("TILT=NONE", "NONE", "expected a line `TILT=NONE`"),
    ("TILT=NONE", "TILT NONE", "expected a line `TILT=NONE`"),
    (
        "1 1000",
        "x 1000",
        "line 4, column 1: found `x`, expected the number of lamps",
    ),
    (
        "1 1000",
        "-1 1000",
        "line 4, column 1: the number of lamps is -1, expected 0",
    ),
    (
        "1 1000",
        "1 many",
        "line 4, column 3: found `many`, expected the lumens per lamp, or -1",
    ),
    (
        "1000 1 ",
        "1000 0 ",
        "line 4, column 8: the multiplier is 0, expected a factor above 0",
    ),
    (
        "1000 1 ",
        "1000 -1 ",
        "the multiplier is -1, expected a factor above 0",
    ),
    (
        "1000 1 ",
        "1000 1e99 ",
        "expected a factor above 0 and up to 1e12",
    ),
    (
        "1000 1 ",
        "1000 nan ",
        "found `nan`, expected a multiplier, usually 1",
    ),
    (
        "1000 1 ",
        "1000 inf ",
        "found `inf`, expected a multiplier, usually 1",
    ),
    (
        "1000 1 ",
        "1000 1e999 ",
        "found `1e999`, expected a multiplier, usually 1",
    ),
    (
        " 3 2 1 ",
        " 0 2 1 ",
        "line 4, column 10: the number of vertical angles is 0, expected a whole",
    ),
    (
        " 3 2 1 ",
        " -3 2 1 ",
        "the number of vertical angles is -3, expected a whole number",
    ),
    (
        " 3 2 1 ",
        " 3.5 2 1 ",
        "the number of vertical angles is 3.5, expected a whole number",
    ),
    (
        " 3 2 1 ",
        " 1e9 2 1 ",
        "1000000000 vertical angles, expected at most 65536",
    ),
    (
        " 3 2 1 ",
        " 65536 65536 1 ",
        "expected 4295098368 numbers of angles and intensities, but only 11 follow",
    ),
    (
        " 3 2 1 ",
        " 3 0 1 ",
        "the number of horizontal angles is 0, expected a whole number",
    ),
    (
        " 3 2 1 ",
        " 3 1e20 1 ",
        "horizontal angles, expected at most 65536",
    ),
    (
        " 3 2 1 ",
        " 3 3 1 ",
        "line 4, column 10: the file counts 3 vertical and 3 horizontal angles, expected 15",
    ),
    (
        " 3 2 1 ",
        " 4 2 1 ",
        "expected 14 numbers of angles and intensities, but only 11 follow",
    ),
    (
        " 3 2 1 ",
        " 3 2 0 ",
        "line 4, column 14: the type of photometry is 0, expected 1 (type C",
    ),
    (
        " 3 2 1 ",
        " 3 2 4 ",
        "the type of photometry is 4, expected 1 (type C",
    ),
    (
        " 3 2 1 ",
        " 3 2 C ",
        "found `C`, expected the type of photometry: 1, 2 or 3",
    ),
    (
        "1 2 0.1",
        "1 m 0.1",
        "found `m`, expected the type of units",
    ),
    (
        "0.1 0.2 0",
        "wide 0.2 0",
        "found `wide`, expected the width of the opening",
    ),
    (
        "0.1 0.2 0",
        "0.1 ? 0",
        "found `?`, expected the length of the opening",
    ),
    (
        "0.1 0.2 0",
        "0.1 0.2 low",
        "found `low`, expected the height of the opening",
    ),
    (
        "\n1 1 10",
        "\n0 1 10",
        "line 5, column 1: the ballast factor is 0, expected a factor above 0",
    ),
    (
        "1 1 10\n",
        "",
        "line 5, column 1: the ballast factor is 0, expected a factor above 0, usually 1; if this is the first angle, put a",
    ),
    (
        "\n1 1 10",
        "\n1 -2 10",
        "line 5, column 3: the ballast-lamp factor is -2, expected a factor",
    ),
    (
        "\n1 1 10",
        "\n1 1 ten",
        "line 5, column 5: found `ten`, expected the input watts",
    ),
    (
        "0 45 90\n",
        "0 45 190\n",
        "line 6, column 6: vertical angle 190 of type C photometry, expected 0 to 180",
    ),
    (
        "0 45 90\n",
        "-90 0 90\n",
        "vertical angle -90 of type C photometry, expected 0 to 180 degrees; see",
    ),
    (
        "0 45 90\n",
        "0 45 45\n",
        "line 6, column 6: vertical angle 45 is there twice with different values",
    ),
    (
        "0 45 90\n",
        "0 x 90\n",
        "line 6, column 3: found `x`, expected a vertical angle in degrees",
    ),
    (
        "\n0 90\n",
        "\n0 0\n",
        "line 7, column 3: horizontal angle 0 is there twice with different values",
    ),
    (
        "\n0 90\n",
        "\n0 60\n",
        "line 7, column 3: horizontal angles of type C photometry from 0 to 60, expected",
    ),
    (
        "\n0 90\n",
        "\n10 100\n",
        "horizontal angles of type C photometry from 10 to 100, expected 0 alone",
    ),
    (
        "\n0 90\n",
        "\n0 400\n",
        "horizontal angles of type C photometry from 0 to 400, expected 0 alone",
    ),
    (
        "\n0 90\n",
        "\n0 900\n",
        "line 7, column 3: horizontal angle 900 of type C photometry, expected -360",
    ),
    ("\n0 90\n", "\n0 240\n", "add the planes that are missing"),
    (
        "\n0 90\n",
        "\nzero 90\n",
        "found `zero`, expected a horizontal angle in degrees",
    ),
    (
        "100 80 10\n",
        "100 x 10\n",
        "line 8, column 5: found `x`, expected an intensity in cd",
    ),
    (
        "100 80 10\n",
        "100 8;0 10\n",
        "line 8, column 5: found `8;0`, expected an intensity in cd",
    ),
    (
        "100 80 10\n",
        "100 1.2.3 10\n",
        "found `1.2.3`, expected an intensity in cd",
    ),
    (
        "100 80 10\n",
        "100 80cd 10\n",
        "found `80cd`, expected an intensity in cd",
    ),
    (
        "100 80 10\n",
        "100 nan 10\n",
        "found `nan`, expected an intensity in cd",
    ),
    (
        "100 80 10\n",
        "100 -inf 10\n",
        "found `-inf`, expected an intensity in cd",
    ),
    (
        "100 80 10\n",
        "100 -80 10\n",
        "line 8, column 5: an intensity of -80 cd, expected none below 0",
    ),
    ("100 80 10\n", "100 1e31 10\n", "an intensity of 1"),
    (
        "100 80 10\n",
        "100 10\n",
        "but only 10 follow; it is cut off, or its counts are wrong",
    ),
    (
        "\n100 80 10\n100 70 5\n",
        "\n0 0 0\n0 0 0\n",
        "line 8, column 1: no intensity is above",
    ),
    (
        "0 45 90\n0 90\n100 80 10\n100 70 5\n",
        "",
        "but only 0 follow; it is cut off",
    ),
    (
        "1 1 10\n0 45 90\n0 90\n100 80 10\n100 70 5\n",
        "1",
        "line 5, column 2: the file ends, expected the ballast-lamp factor",
    ),
    (
        "TILT=NONE",
        "TILT=INCLUDE",
        "line 4, column 3: the file ends, expected as many tilt angles and then as many factors",
    ),
    (
        "TILT=NONE",
        "TILT=INCLUDE\n4\n2\n0 90\n1 1",
        "line 4, column 1: the lamp-to-luminaire geometry is 4, expected 1 (v",
    ),
    (
        "TILT=NONE",
        "TILT=INCLUDE\n1\n0\n1 1",
        "line 5, column 1: the number of tilt angles is 0, expected a whole",
    ),
    (
        "TILT=NONE",
        "TILT=INCLUDE\n1\n2\n0 900\n1 1",
        "line 6, column 3: a tilt angle is 900, expected -180 to 180",
    ),
    (
        "TILT=NONE",
        "TILT=INCLUDE\n1\n2\n0 90\n1 -1",
        "line 7, column 3: a tilt factor is -1, expected 0",
    ),
    (
        "TILT=NONE",
        "TILT=INCLUDE\n1\n2\n0 90\n0 1",
        "the tilt factor at 0 degrees is 0, expected one above 0",
    ),
    (
        "TILT=NONE",
        "TILT=INCLUDE\n1\n2\n0 0\n1 2",
        "tilt angle 0 is there twice with different values, expected",
    ),
    (
        "TILT=NONE",
        "TILT=INCLUDE\n1\n2\n0 90\n1 one",
        "line 7, column 3: found `one`, expected a tilt factor",
    ),
];

#[test]
fn errors_say_where_and_what() {
    parse_clean(GOOD);
    for (part, instead, expected) in BROKEN {
        assert!(GOOD.contains(part), "{part}");
        let text = GOOD.replacen(part, instead, 1);
        let error = match IesFile::parse(text.as_bytes()) {
            Ok(file) => panic!("{text}\n{:?}", file.remarks.list()),
            Err(error) => error.to_string(),
        };
        assert!(error.starts_with("line "), "{error}");
        assert!(error.contains(", column "), "{error}");
        assert!(error.contains("expected"), "{error}");
        assert!(error.contains(expected), "{error}\nnot {expected}");
    }
}

#[test]
fn errors_of_types_a_and_b() {
    let message = |kind, vertical: &[f64], horizontal: &[f64]| {
        let text = Text::new(kind, vertical, horizontal).of(|v, h| 500.0 + v + h);
        let error = IesFile::parse(text.as_bytes()).unwrap_err().to_string();
        assert!(
            error.starts_with("line ") && error.contains("expected"),
            "{error}"
        );
        error
    };
    let (good, one) = ([-90.0, 0.0, 90.0], [0.0]);
    assert!(
        message(2, &good, &one)
            .contains("line 8, column 1: horizontal angles of type B photometry from 0 to 0")
    );
    assert!(message(3, &good, &one).contains("expected at least two"));
    assert!(message(2, &good, &[5.0, 90.0]).contains("from 0 (both sides alike)"));
    assert!(message(2, &good, &[-90.0, -5.0]).contains("or from a negative angle"));
    assert!(
        message(2, &good, &[0.0, 120.0])
            .contains("horizontal angle 120 of type B photometry, expected -90 to 90")
    );
    assert!(
        message(3, &[0.0, 120.0], &good)
            .contains("vertical angle 120 of type A photometry, expected -90 to 90")
    );
    assert!(
        message(1, &[0.0], &one)
            .contains("the number of different vertical angles is 1, expected at least 2")
    );
}
