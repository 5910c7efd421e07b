//! Look-up tables that are read, and what is said of those that are not.

use super::*;

fn read(text: &[u8]) -> Result<Cube, CubeProblem> {
    parsed(&mut { text }, text.len() as u64)
}

/// What is said of a file `look.cube`.
fn message(text: &[u8]) -> String {
    let error = CubeError {
        path: "look.cube".into(),
        problem: read(text).unwrap_err(),
    };
    error.to_string()
}

const EIGHT: &str = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n";

fn table(size: usize, least: [f64; 3], most: [f64; 3], entries: &[[f32; 3]]) -> Table {
    Table {
        domain: Domain { least, most },
        size,
        entries: entries.to_vec(),
    }
}

#[test]
fn plain_tables() {
    let cube = read(format!("LUT_3D_SIZE 2\n{EIGHT}").as_bytes()).unwrap();
    assert_eq!(cube.title(), None);
    let Tables::Grid(grid) = cube.tables else {
        panic!("a table of three dimensions");
    };
    assert_eq!((grid.size, grid.domain), (2, Domain::default()));
    assert_eq!(grid.entries[1], [1.0, 0.0, 0.0]);
    assert_eq!(grid.entries[4], [0.0, 0.0, 1.0]);
}

/// All that the specification, and those who do not keep to it, may write.
#[test]
fn every_form() {
    let text = "\u{feff}# a comment\r\n\r\nTITLE \"warm # 2\"\r\n  LUT_1D_SIZE\t2 \r\nDOMAIN_MIN -1 0 1e-3\r\n\
                DOMAIN_MAX\t+1.5E0 .5 2.\r\n# more\r\n\t0.25  5e-1\t-1 # first\r\n\r\n1 2e0 3";
    let cube = read(text.as_bytes()).unwrap();
    assert_eq!(cube.title(), Some("warm # 2"));
    let entries = [[0.25, 0.5, -1.0], [1.0, 2.0, 3.0]];
    let curves = table(2, [-1.0, 0.0, 1e-3], [1.5, 0.5, 2.0], &entries);
    assert_eq!(cube.tables, Tables::Curves(curves));
}

#[test]
fn a_shaper_and_a_table() {
    let text = format!(
        "LUT_3D_SIZE 2\nLUT_1D_SIZE 3\nLUT_3D_INPUT_RANGE 0.0 1.0\nLUT_1D_INPUT_RANGE -0.5 16\n\
         0 0 0\n0.75 0.75 0.75\n1 1 1\n{EIGHT}"
    );
    let Tables::Both(shaper, grid) = read(text.as_bytes()).unwrap().tables else {
        panic!("two tables");
    };
    let entries = [[0.0; 3], [0.75; 3], [1.0; 3]];
    assert_eq!(shaper, table(3, [-0.5; 3], [16.0; 3], &entries));
    assert_eq!((grid.size, grid.entries.len()), (2, 8));
    assert_eq!(grid.domain, Domain::default());
}

#[test]
fn one_end_of_a_domain_is_enough() {
    let text = format!("LUT_3D_SIZE 2\nDOMAIN_MAX 4 4 4\n{EIGHT}");
    let Tables::Grid(grid) = read(text.as_bytes()).unwrap().tables else {
        panic!("a table of three dimensions");
    };
    assert_eq!((grid.domain.least, grid.domain.most), ([0.0; 3], [4.0; 3]));
}

#[test]
fn what_is_wrong_is_said_with_its_line() {
    let keywords = "TITLE, LUT_1D_SIZE, LUT_3D_SIZE, DOMAIN_MIN, DOMAIN_MAX, LUT_1D_INPUT_RANGE, LUT_3D_INPUT_RANGE";
    let keyword =
        format!(", line 1: expected three numbers or one of {keywords}, found `lut_3d_size`");
    let escape =
        format!(", line 1: expected three numbers or one of {keywords}, found `\\u{{1b}}[31m`");
    for (text, expected) in [
        (
            "",
            ": it has no LUT_1D_SIZE and no LUT_3D_SIZE; is it a .cube file?",
        ),
        (
            "# nothing\n",
            ": it has no LUT_1D_SIZE and no LUT_3D_SIZE; is it a .cube file?",
        ),
        (
            "0 0 0\n",
            ", line 1: numbers before LUT_1D_SIZE or LUT_3D_SIZE",
        ),
        ("lut_3d_size 2\n", &keyword),
        ("\u{1b}[31m\n", &escape),
        (
            "LUT_IN_VIDEO_RANGE\n",
            ", line 1: LUT_IN_VIDEO_RANGE asks for video levels, which are not read; export the table for full \
             range (data levels)",
        ),
        (
            "LUT_3D_SIZE 1\n",
            ", line 1: LUT_3D_SIZE is from 2 to 256, found 1",
        ),
        (
            "LUT_3D_SIZE 0\n",
            ", line 1: LUT_3D_SIZE is from 2 to 256, found 0",
        ),
        (
            "LUT_3D_SIZE 257\n",
            ", line 1: LUT_3D_SIZE is from 2 to 256, found 257",
        ),
        (
            "LUT_3D_SIZE -2\n",
            ", line 1: LUT_3D_SIZE is from 2 to 256, found -2",
        ),
        (
            "LUT_3D_SIZE\n",
            ", line 1: LUT_3D_SIZE is from 2 to 256, found ",
        ),
        (
            "\nLUT_1D_SIZE 99999999999999999999\n",
            ", line 2: LUT_1D_SIZE is from 2 to 65536, found 99999999999999999999",
        ),
        (
            "LUT_3D_SIZE 256\n",
            ", line 1: a table of 16777216 entries takes 100663295 bytes at least, and the file has 16",
        ),
        (
            "LUT_1D_SIZE 2\nLUT_1D_SIZE 2\n",
            ", line 2: LUT_1D_SIZE is there twice",
        ),
        (
            "LUT_1D_SIZE 2\n0 0 0\n",
            ": it ends after 1 of the 2 lines of numbers that its size asks for",
        ),
        (
            "LUT_1D_SIZE 2\n# no numbers\n",
            ": it ends after 0 of the 2 lines of numbers that its size asks for",
        ),
        (
            "LUT_1D_SIZE 2\n0 0 0\n1 1 1\n2 2 2\n",
            ", line 4: more lines of numbers than the 2 that its size asks for",
        ),
        (
            "LUT_1D_SIZE 2\n0 0\n1 1 1\n",
            ", line 2: expected three numbers, such as `0.25 0.5 1`, found `0 0`",
        ),
        (
            "LUT_1D_SIZE 2\n0 0 0 0\n1 1 1\n",
            ", line 2: expected three numbers, such as `0.25 0.5 1`, found `0 0 0 0`",
        ),
        (
            "LUT_1D_SIZE 2\n0 0,5 0\n1 1 1\n",
            ", line 2: expected three numbers, such as `0.25 0.5 1`, found `0 0,5 0`",
        ),
        (
            "LUT_1D_SIZE 2\n0 nan 0\n1 1 1\n",
            ", line 2: expected finite numbers, found `0 nan 0`",
        ),
        (
            "LUT_1D_SIZE 2\ninf 0 0\n1 1 1\n",
            ", line 2: expected finite numbers, found `inf 0 0`",
        ),
        (
            "LUT_1D_SIZE 2\n0 0 1e39\n1 1 1\n",
            ", line 2: expected finite numbers, found `0 0 1e39`",
        ),
        (
            "LUT_1D_SIZE 2\nDOMAIN_MIN 0 0 0\nDOMAIN_MAX 1 0 1\n0 0 0\n1 1 1\n",
            ", line 3: the domain's end must be above its start, found 0 to 0",
        ),
        (
            "LUT_1D_SIZE 2\nDOMAIN_MIN 0 2 0\n0 0 0\n1 1 1\n",
            ", line 2: the domain's end must be above its start, found 2 to 1",
        ),
        (
            "LUT_1D_SIZE 2\nLUT_1D_INPUT_RANGE 1 0\n0 0 0\n1 1 1\n",
            ", line 2: the domain's end must be above its start, found 1 to 0",
        ),
        (
            "LUT_1D_SIZE 2\nLUT_3D_INPUT_RANGE 0 1\n0 0 0\n1 1 1\n",
            ", line 2: LUT_3D_INPUT_RANGE is about a table that is not there",
        ),
        (
            "LUT_1D_SIZE 2\nDOMAIN_MIN 0 0 0\nLUT_1D_INPUT_RANGE 0 1\n0 0 0\n1 1 1\n",
            ", line 3: LUT_1D_INPUT_RANGE contradicts DOMAIN_MIN, which is there as well; remove one of them",
        ),
        (
            "LUT_1D_SIZE 2\n0 0 0\nDOMAIN_MIN 0 0 0\n1 1 1\n",
            ", line 3: DOMAIN_MIN after the first line of numbers; keywords come before",
        ),
    ] {
        assert_eq!(
            message(text.as_bytes()),
            format!("cannot read look.cube{expected}")
        );
    }
    let both = format!("LUT_1D_SIZE 2\nLUT_3D_SIZE 2\nDOMAIN_MIN 0 0 0\n0 0 0\n1 1 1\n{EIGHT}");
    assert_eq!(
        message(both.as_bytes()),
        "cannot read look.cube, line 3: DOMAIN_MIN does not say which of the two tables it is about; write \
         LUT_1D_INPUT_RANGE and LUT_3D_INPUT_RANGE instead"
    );
}

#[test]
fn what_is_no_text_is_refused() {
    assert_eq!(
        message(b"TITLE \"\xff\"\n"),
        "cannot read look.cube, line 1: expected text in UTF-8; is it a .cube file?"
    );
    assert_eq!(
        message(&vec![b'#'; 1 << 20]),
        "cannot read look.cube, line 1: it is longer than 16384 bytes; is it a .cube file?"
    );
    let utf16: Vec<u8> = "LUT_3D_SIZE 2"
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    assert_eq!(
        message(&utf16),
        "cannot read look.cube: it is text in UTF-16 (little endian); save it as UTF-8"
    );
    let folder = tempfile::tempdir().unwrap();
    let error = Cube::read(folder.path()).unwrap_err();
    assert!(
        error.to_string().ends_with(": it is a directory"),
        "{error}"
    );
    assert!(!error.is_transient());
    let error = Cube::read(&folder.path().join("none.cube")).unwrap_err();
    assert!(matches!(error.problem, CubeProblem::Io(_)) && !error.is_transient());
}

/// Whatever is done to a file, reading it ends, and what it gives is whole.
#[test]
fn damaged_files_end() {
    let text = format!(
        "TITLE \"a\"\nLUT_1D_SIZE 3\nLUT_3D_SIZE 2\nLUT_1D_INPUT_RANGE 0 4\n0 0 0\n.5 .5 .5\n1 1 1\n{EIGHT}"
    );
    let bytes = text.as_bytes();
    // Without the last line's end it is whole.
    for end in 0..bytes.len() - 1 {
        assert!(read(&bytes[..end]).is_err(), "{end}");
    }
    for place in 0..bytes.len() {
        for byte in [0, b' ', b'\n', b'-', b'9', b'e', b'#', 0xff] {
            let mut damaged = bytes.to_vec();
            damaged[place] = byte;
            if let Ok(Cube { tables, .. }) = read(&damaged) {
                let count = match &tables {
                    Tables::Curves(table) => table.entries.len() - table.size,
                    Tables::Grid(table) | Tables::Both(_, table) => {
                        table.entries.len() - table.size.pow(3)
                    }
                };
                assert_eq!(count, 0);
            }
        }
    }
}
