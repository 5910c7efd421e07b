//! Tiles that change between the look at their headers and the copying of their blocks.

use std::fs;
use std::path::PathBuf;

use super::*;
use crate::color::ColorSpace;
use crate::exr::ExrOptions;
use crate::image::{Film, Metadata};

const RESOLUTION: [u32; 2] = [8, 40];

/// The tiles of an image of this gray.
fn tiles(folder: &Path, gray: f32) -> Vec<PathBuf> {
    (0..3)
        .map(|index| {
            let tile = Tile {
                number: TileNumber::new(index, 3).unwrap(),
                of: Window::whole(RESOLUTION),
            };
            let options = ExrOptions {
                compression: Compression::None,
                tile: Some(tile),
                ..ExrOptions::default()
            };
            let window = tile.window(options.compression).unwrap();
            let pixels = vec![[gray; 4]; window.count() as usize];
            let identity = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(i == j)));
            let metadata = Metadata {
                color_space: ColorSpace::Rec709,
                world_to_camera: identity,
                world_to_ndc: identity,
                provenance: Vec::new(),
                numbers: Vec::new(),
            };
            let film = Film::new(RESOLUTION, window, pixels, metadata);
            let path = folder.join(format!("{index}.exr"));
            film.write_exr(&path, &options, &Unfinished::new()).unwrap();
            path
        })
        .collect()
}

#[test]
fn a_tile_that_vanishes_may_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let tiles = tiles(folder.path(), 0.5);
    let output = folder.path().join("merged.exr");
    let merger = Merger::new(&tiles).unwrap();
    let bytes = fs::read(&tiles[1]).unwrap();
    fs::remove_file(&tiles[1]).unwrap();
    let error = merger.write(&output, &Unfinished::new()).unwrap_err();
    assert!(matches!(error, MergeError::Vanished(_)), "{error}");
    assert!(error.is_transient());
    assert!(error.to_string().contains("1.exr was there"), "{error}");
    assert!(!output.exists());
    fs::write(&tiles[1], bytes).unwrap();
    merger.write(&output, &Unfinished::new()).unwrap();
}

#[test]
fn a_tile_that_is_another_is_not_merged() {
    let folder = tempfile::tempdir().unwrap();
    let paths = tiles(folder.path(), 0.5);
    let output = folder.path().join("merged.exr");
    let merger = Merger::new(&paths).unwrap();
    // Longer, and of the same length with other pixels.
    let bytes = fs::read(&paths[1]).unwrap();
    fs::write(&paths[1], [&bytes[..], b"more"].concat()).unwrap();
    let error = merger.write(&output, &Unfinished::new()).unwrap_err();
    assert!(matches!(error, MergeError::Changed(_)), "{error}");
    assert!(error.is_transient());
    tiles(folder.path(), 0.25);
    let error = merger.write(&output, &Unfinished::new()).unwrap_err();
    assert!(matches!(error, MergeError::Changed(_)), "{error}");
    assert!(!output.exists());
}

#[test]
fn ranges_of_missing_tiles() {
    let missing = |missing: Vec<_>, count| MergeError::Missing { missing, count }.to_string();
    let text = missing(vec![3..=3, 5..=7], 16);
    assert!(
        text.starts_with("tiles 3, 5-7 of 16 are missing; "),
        "{text}"
    );
    assert!(text.contains("`candela render --tile 3/16`"), "{text}");
    let text = missing(vec![15..=15], 16);
    assert!(text.starts_with("tile 15 of 16 is missing; "), "{text}");
    let text = missing((0..100).map(|index| 2 * index..=2 * index).collect(), 300);
    assert!(text.contains("36, 38, … of 300 are missing"), "{text}");
}

/// What tells most is named, wherever it stands.
#[test]
fn the_most_telling_difference_is_named() {
    let tile = |entries: &[(&str, &str)]| -> Vec<Attribute> {
        let entries = entries.iter();
        entries
            .map(|(name, value)| Attribute {
                name: name.as_bytes().to_vec(),
                kind: b"string".to_vec(),
                value: value.as_bytes().to_vec(),
            })
            .collect()
    };
    let one = tile(&[
        ("candela:camera", "left"),
        ("candela:frame", "1"),
        (TILE, "0/2"),
    ]);
    let other = tile(&[
        ("candela:camera", "right"),
        ("candela:frame", "2"),
        (TILE, "1/2"),
    ]);
    let found = difference([2, 2], [&one, &other]).unwrap();
    assert_eq!(found.name(), "`candela:frame`");
    assert_eq!(found.values, ["`1`", "`2`"]);
    assert!(found.way_out().contains("one frame"));
    let found = difference([2, 2], [&one[..1], &other[..1]]).unwrap();
    assert_eq!(found.name(), "`candela:camera`");
    // Which tile it is may differ, and nothing else.
    assert_eq!(difference([2, 2], [&one[2..], &other[2..]]), None);
    let found = difference([2, 1026], [&one[2..], &other[2..]]).unwrap();
    assert_eq!(found.values, ["0x2", "0x402"]);
}
