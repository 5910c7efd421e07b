//! Which color space counts.

use super::file::{Part, rgb, row, write};
use super::{NEAREST, assert_pixels, shown};

/// Two colors, a middle gray and a light one, linear Rec.709, and their sRGB codes.
const REC709: [[f32; 3]; 4] = [
    [0.2, 0.3, 0.4],
    [0.8, 0.1, 0.05],
    [0.18, 0.18, 0.18],
    [0.9, 0.9, 0.9],
];
const CODES: [[u8; 3]; 4] = [
    [124, 149, 170],
    [231, 89, 63],
    [118, 118, 118],
    [243, 243, 243],
];

/// CIE X, Y, Z of these, by the matrix of ITU-R BT.709-6 with white D65 (computed with
/// colour-science).
const XYZ: [[f32; 3]; 4] = [
    [0.261_945, 0.285_953, 0.419_954],
    [0.374_695, 0.245_238, 0.074_910],
    [0.171_082, 0.18, 0.196_03],
    [0.855_41, 0.9, 0.980_152],
];

/// What the numbers of [`REC709`] are in ACEScg and in Adobe RGB, as sRGB codes (computed with
/// colour-science: Bradford, clipped).
const AS_ACESCG: [[u8; 3]; 4] = [
    [98, 152, 173],
    [255, 24, 44],
    [118, 118, 118],
    [243, 243, 243],
];
const AS_ADOBE: [[u8; 3]; 4] = [
    [111, 149, 170],
    [255, 89, 62],
    [118, 118, 118],
    [243, 243, 243],
];

const ACESCG_XY: [f32; 8] = [0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767];
const ADOBE_XY: [f32; 8] = [0.64, 0.33, 0.21, 0.71, 0.15, 0.06, 0.3127, 0.329];
const XYZ_XY: [f32; 8] = [1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0 / 3.0, 1.0 / 3.0];

fn part(colors: &'static [[f32; 3]]) -> Part {
    row(4, rgb("", colors))
}

#[track_caller]
fn assert_shows(part: Part, expected: &[[u8; 3]; 4], warning: Option<&str>) {
    let folder = tempfile::tempdir().unwrap();
    let shown = shown(&write(folder.path(), &[part]), None, &NEAREST).unwrap();
    assert_pixels(&shown, expected);
    let warnings = &shown.report.warnings;
    match warning {
        None => assert!(warnings.is_empty(), "{warnings:?}"),
        Some(warning) => assert!(warnings[0].contains(warning), "{warnings:?}"),
    }
}

#[test]
fn xyz_takes_the_plain_matrix() {
    assert_shows(part(&REC709), &CODES, None);
    assert_shows(part(&XYZ).chromaticities(XYZ_XY), &CODES, None);
    let id = part(&XYZ).with("colorInteropID", "string", "lin_ciexyzd65_scene");
    assert_shows(id, &CODES, None);
    let both =
        part(&XYZ)
            .chromaticities(XYZ_XY)
            .with("colorInteropID", "string", "lin_ciexyzd65_scene");
    assert_shows(both, &CODES, None);
}

#[test]
fn an_identifier_that_says_nothing_hides_no_chromaticities() {
    let plain = || part(&REC709).chromaticities(ACESCG_XY);
    assert_shows(plain(), &AS_ACESCG, None);
    let unknown = plain().with("colorInteropID", "string", "unknown");
    assert_shows(unknown, &AS_ACESCG, None);
    let studio = plain().with("colorInteropID", "string", "studio:plates");
    assert_shows(studio, &AS_ACESCG, Some("`studio:plates`, is not known"));
    let alone = part(&REC709).with("colorInteropID", "string", "unknown");
    assert_shows(alone, &CODES, None);
}

#[test]
fn adobe_rgb_is_known_by_its_name() {
    assert_shows(part(&REC709).chromaticities(ADOBE_XY), &AS_ADOBE, None);
    let named = part(&REC709).with("colorInteropID", "string", "lin_adobergb_scene");
    assert_shows(named, &AS_ADOBE, None);
}

/// As exr2aces leaves them: the pixels and chromaticities are those of ACES 2065-1, the identifier is the
/// source's.
#[test]
fn chromaticities_count_where_an_identifier_contradicts_them() {
    let stale = part(&REC709).chromaticities(ACESCG_XY).with(
        "colorInteropID",
        "string",
        "lin_rec709_scene",
    );
    assert_shows(stale, &AS_ACESCG, Some("contradict each other"));
}

#[test]
fn vectors_and_single_channels_have_no_color_space() {
    let folder = tempfile::tempdir().unwrap();
    let mut channels = rgb("", &REC709);
    for (name, place) in [("N.X", 0), ("N.Y", 1), ("N.Z", 2)] {
        channels.push(super::file::channel(name, move |x, _| {
            REC709[x as usize][place]
        }));
    }
    let path = write(folder.path(), &[row(4, channels).chromaticities(ACESCG_XY)]);
    assert_pixels(&shown(&path, Some("N"), &NEAREST).unwrap(), &CODES);
    let red = CODES.map(|[red, _, _]| [red; 3]);
    assert_pixels(&shown(&path, Some("N.X"), &NEAREST).unwrap(), &red);
    assert_pixels(&shown(&path, None, &NEAREST).unwrap(), &AS_ACESCG);
}

/// In XYZ, R = G = B is no gray, but luminance alone is one in every space.
#[test]
fn luminance_alone_is_gray_in_every_space() {
    let folder = tempfile::tempdir().unwrap();
    for chromaticities in [XYZ_XY, ACESCG_XY, ADOBE_XY] {
        let luminance = super::file::channel("Y", |x, _| [0.05, 0.18, 0.5, 1.0][x as usize]);
        let part = row(4, vec![luminance]).chromaticities(chromaticities);
        let shown = shown(&write(folder.path(), &[part]), None, &NEAREST).unwrap();
        assert_eq!(shown.pixels, [63, 118, 188, 255].map(|code| vec![code; 3]));
        assert!(shown.report.warnings.is_empty());
    }
}

/// Strings of attributes have a length, and a zero at the end is none of them; an empty one says nothing.
#[test]
fn identifiers_may_end_with_a_zero() {
    for (id, expected) in [
        ("lin_ap1_scene\0", &AS_ACESCG),
        ("lin_ap1_scene", &AS_ACESCG),
        ("", &CODES),
        ("\0", &CODES),
    ] {
        let part = part(&REC709).with("colorInteropID", "string", id);
        assert_shows(part, expected, None);
    }
}
