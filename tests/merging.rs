//! Tiles that were damaged on their way: whatever byte is another, merging finds it.

use std::fs;
use std::path::{Path, PathBuf};

use candela::exr::{
    Compression, ExrOptions, ExrOptionsError, MergeError, MergeReport, Preserve, Tile, TileNumber,
    merge,
};
use candela::image::{Channels, Window};
use candela::output::Unfinished;
use candela::render::{Job, Layers, Options, Renderer};
use candela::scene::Scene;
use candela::world::World;

use crate::fuzzing;
use sha2::{Digest, Sha256};

const RESOLUTION: [u32; 2] = [20, 90];

/// Renders the built-in scene with its lights as layers; the whole file and the files of three tiles.
fn files(folder: &Path, compression: Compression) -> (Vec<u8>, Vec<PathBuf>) {
    let mut scene = Scene::builtin();
    scene.image.resolution.value = RESOLUTION;
    let (world, camera) = World::new(&scene).unwrap();
    let renderer = Renderer::new(&world).unwrap();
    let file = |tile: Option<Tile>| {
        let exr = ExrOptions {
            compression,
            tile,
            ..ExrOptions::default()
        };
        let options = Options {
            window: tile.map(|tile| tile.window(compression).unwrap()),
            layers: Layers {
                lights: true,
                ..Layers::default()
            },
            ..Options::default()
        };
        let mut file = std::io::Cursor::new(Vec::new());
        let job = Job::new();
        renderer
            .exr(&camera, &options, &exr, Preserve::Nothing, &job, &mut file)
            .unwrap();
        file.into_inner()
    };
    let tiles = (0..3).map(|index| {
        let tile = Tile {
            number: TileNumber::new(index, 3).unwrap(),
            of: Window::whole(RESOLUTION),
        };
        let path = folder.join(format!("{index}.exr"));
        fs::write(&path, file(Some(tile))).unwrap();
        path
    });
    let tiles = tiles.collect();
    (file(None), tiles)
}

fn merged(tiles: &[PathBuf], output: &Path) -> Result<MergeReport, MergeError> {
    merge(tiles, output, &Unfinished::new())
}

/// The hash in a tile is that of docs/tiles.md.
#[test]
fn the_hash_of_a_tile_is_as_documented() {
    for compression in [Compression::Zips, Compression::Piz] {
        let folder = tempfile::tempdir().unwrap();
        let (_, tiles) = files(folder.path(), compression);
        let bytes = fs::read(&tiles[0]).unwrap();
        // Attributes are name, type, length, value; the header ends with an empty name.
        let number = |place: usize| i32::from_le_bytes(bytes[place..place + 4].try_into().unwrap());
        let end_of = |place: usize| place + bytes[place..].iter().position(|&b| b == 0).unwrap();
        let (mut place, mut hash) = (8, 0..0);
        while bytes[place] != 0 {
            let end = end_of(place);
            let value = end_of(end + 1) + 5;
            let length = number(value - 4) as usize;
            if &bytes[place..end] == b"candela:tile_sha256" {
                hash = value..value + length;
            }
            place = value + length;
        }
        let mut head = bytes[..=place].to_vec();
        head[hash.clone()].fill(b'0');
        let mut all = Sha256::digest(&head).to_vec();
        // Blocks follow the table, which says where the first one is.
        let mut block = number(place + 1) as usize;
        while block < bytes.len() {
            let end = block + 8 + number(block + 4) as usize;
            all.extend(Sha256::digest(&bytes[block..end]));
            block = end;
        }
        let digits = Sha256::digest(&all);
        let digits: String = digits.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(digits.as_bytes(), &bytes[hash], "{compression}");
    }
}

/// Every byte of a tile, and every length.
#[test]
fn any_byte_that_changes_is_found() {
    for compression in [Compression::None, Compression::Zip, Compression::Dwaa] {
        let folder = tempfile::tempdir().unwrap();
        let (whole, tiles) = files(folder.path(), compression);
        let output = folder.path().join("merged.exr");
        let report = merged(&tiles, &output).unwrap();
        assert_eq!((report.tiles, report.resolution), (3, RESOLUTION));
        assert_eq!(report.bytes, whole.len() as u64);
        assert!(fs::read(&output).unwrap() == whole);
        fs::remove_file(&output).unwrap();

        let bytes = fs::read(&tiles[1]).unwrap();
        let refused = |bytes: &[u8], what: &str, place: usize| {
            fs::write(&tiles[1], bytes).unwrap();
            let message = merged(&tiles, &output).unwrap_err().to_string();
            assert!(
                message.contains("1.exr"),
                "{compression}: {what} {place}: {message}"
            );
            assert!(!output.exists());
        };
        // All of the head, and some of the blocks: steps that no length of a line has.
        let head = 2500.min(bytes.len());
        let places = (0..head).step_by(3).chain((head..bytes.len()).step_by(61));
        for place in places {
            let mut changed = bytes.clone();
            changed[place] ^= 1 << (place % 8);
            refused(&changed, "byte", place);
        }
        for length in (0..bytes.len()).step_by(97) {
            refused(&bytes[..length], "length", length);
        }
        fs::write(&tiles[1], &bytes).unwrap();
        merged(&tiles, &output).unwrap();
        assert!(fs::read(&output).unwrap() == whole);
    }
}

/// What fuzzing makes of a tile ends in an error, or was no change of what counts.
#[test]
fn mutated_tiles_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, tiles) = files(folder.path(), Compression::Zip);
    let output = folder.path().join("merged.exr");
    let bytes = fs::read(&tiles[1]).unwrap();
    let outcomes = fuzzing::run("merge", &[&bytes], 300, |mutated| {
        fs::write(&tiles[1], mutated).unwrap();
        let merged = merged(&tiles, &output);
        if merged.is_ok() {
            assert!(fs::read(&output).unwrap() == whole);
        }
        merged
    });
    assert!(outcomes.refused > outcomes.accepted, "{outcomes:?}");
}

/// A file does not say that it is a tile where it is not.
#[test]
fn a_tile_is_where_it_says() {
    let tile = Tile {
        number: TileNumber::new(1, 3).unwrap(),
        of: Window::whole(RESOLUTION),
    };
    let exr = ExrOptions {
        tile: Some(tile),
        ..ExrOptions::default()
    };
    let window = tile.window(exr.compression).unwrap();
    assert_eq!((window.y, window.height), (32, 32));
    assert_eq!(exr.check(window, &Channels::default()), Ok(()));
    let whole = Window::whole(RESOLUTION);
    let error = exr.check(whole, &Channels::default()).unwrap_err();
    assert_eq!(error, ExrOptionsError::NotTheTile(tile.number));
    assert!(error.to_string().contains("tile 1/3"));
}
