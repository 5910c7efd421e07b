//! `candela render --tile` and `candela merge` on the command line: the bytes of the whole render, or one message.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use super::{SCENE, candela, fails, files, folder, succeeds, text};

/// More rows than three blocks of any compression but dwab have, and no multiple of a block's.
const TALL: &str = "resolution = [40, 234]";

/// A folder with the scene `tall.toml` in it.
fn tall() -> TempDir {
    scene_of("resolution = [60, 40]", TALL)
}

fn scene_of(old: &str, new: &str) -> TempDir {
    let folder = folder();
    let scene = SCENE.replace(old, new);
    assert_ne!(scene, SCENE);
    fs::write(folder.path().join("tall.toml"), scene).unwrap();
    folder
}

/// Renders `tall.toml` in tiles, `t0.exr` and so on.
fn tiles(folder: &Path, options: &str, count: u32) {
    for index in 0..count {
        let arguments = format!("render tall.toml -q {options} --tile {index}/{count}");
        succeeds(folder, &format!("{arguments} -o t{index}.exr"));
    }
}

fn remove_tiles(folder: &Path) {
    for name in files(folder) {
        if name.starts_with('t') && name.ends_with(".exr") {
            fs::remove_file(folder.join(name)).unwrap();
        }
    }
}

/// Renders whole and in so many tiles; what is merged has the bytes of the whole.
fn assert_merges(folder: &Path, options: &str, counts: &[u32]) {
    let arguments = format!("render tall.toml -q {options} -o whole.exr");
    succeeds(folder, &arguments);
    let whole = fs::read(folder.join("whole.exr")).unwrap();
    for &count in counts {
        tiles(folder, options, count);
        succeeds(folder, "merge t*.exr -q -o merged.exr");
        let merged = fs::read(folder.join("merged.exr")).unwrap();
        assert!(merged == whole, "{options}: {count} tiles");
        remove_tiles(folder);
    }
}

#[test]
fn merged_is_whole_under_every_compression() {
    let folder = tall();
    for compression in ["none", "rle", "zips", "zip", "piz", "pxr24", "dwaa"] {
        let options = format!("--samples 2 --compression {compression}");
        assert_merges(folder.path(), &options, &[1, 2, 3, 7]);
        assert_merges(folder.path(), &format!("{options} --half"), &[2]);
    }
    let folder = scene_of("resolution = [60, 40]", "resolution = [16, 700]");
    assert_merges(
        folder.path(),
        "--samples 2 --compression dwab --half",
        &[2, 3],
    );
}

#[test]
fn merged_is_whole_with_all_that_a_file_may_have() {
    let folder = tall();
    let layers = "lights,light-diffuse,light-specular,relight,diffuse,specular,albedo,irradiance,depth,position,normal,\
                  shadow,cryptomatte";
    for options in [
        &format!("--samples 3 --layers {layers}"),
        &format!("--samples 3 --half --layers {layers}"),
        "--samples 3 --layers lights --transport spectral",
        "--samples 3 --layers spectral,lights --wavelengths 400:700:50 --transport spectral",
        "--max-error 2%",
        "--max-error 2% --max-samples 4 --layers error,samples,lights",
        "--samples 2 --crop 3,7,37,200 --layers lights",
        "--samples 2 --chromaticities",
    ] {
        assert_merges(folder.path(), options, &[2, 3, 7]);
    }
}

/// The header says of the whole what the tiles' headers say of them, added up.
#[test]
fn tiles_have_different_errors() {
    let folder = tall();
    let options = "--max-error 2% --max-samples 4 --layers lights";
    assert_merges(folder.path(), options, &[3]);
    tiles(folder.path(), options, 3);
    let heads = ["t0.exr", "t1.exr", "t2.exr"].map(|name| {
        let bytes = fs::read(folder.path().join(name)).unwrap();
        [
            "bound_pixels",
            "worst_bound",
            "worst_estimate",
            "unmet_pixels",
            "residual",
        ]
        .map(|name| {
            let name = format!("candela:{name}\0");
            let place = bytes
                .windows(name.len())
                .position(|here| here == name.as_bytes());
            bytes[place.unwrap()..][..60].to_vec()
        })
    });
    // What would be the same in all would not be tried.
    for attribute in 0..heads[0].len() {
        let differ = heads
            .iter()
            .any(|head| head[attribute] != heads[0][attribute]);
        assert!(differ, "{attribute}");
    }
}

#[test]
fn bands_in_a_file_of_their_own_and_previews() {
    let folder = tall();
    let options =
        "--samples 2 --layers spectral,lights --wavelengths 400:700:50 --transport spectral";
    let render = |tile: &str, name: &str| {
        let outputs =
            format!("-o {name}.exr --spectral-output {name}-bands.exr --preview {name}.png");
        succeeds(
            folder.path(),
            &format!("render tall.toml -q {options} {tile} {outputs}"),
        );
    };
    render("", "whole");
    for index in 0..3 {
        render(&format!("--tile {index}/3"), &format!("t{index}"));
    }
    succeeds(folder.path(), "merge t?.exr -q -o merged.exr");
    succeeds(folder.path(), "merge t?-bands.exr -q -o merged-bands.exr");
    for name in ["", "-bands"] {
        let read =
            |start: &str| fs::read(folder.path().join(format!("{start}{name}.exr"))).unwrap();
        assert!(read("merged") == read("whole"), "{name}");
    }
    let message = fails(
        folder.path(),
        "merge t0.exr t1-bands.exr t2.exr -o x.exr",
        1,
    );
    assert!(message.contains("`channels` is"), "{message}");
    let preview = image::open(folder.path().join("t1.png")).unwrap();
    assert_eq!([preview.width(), preview.height()], [40, 80]);
}

/// As many tiles as an image of 2160 rows may have on a farm, with fewer files that may be open than tiles.
#[test]
fn many_tiles_of_a_high_image() {
    let folder = scene_of("resolution = [60, 40]", "resolution = [24, 2160]");
    succeeds(
        folder.path(),
        "render tall.toml -q --samples 1 -o whole.exr",
    );
    for index in 0..64 {
        let arguments = format!("render tall.toml -q --samples 1 --tile {index}/64");
        succeeds(folder.path(), &arguments);
    }
    let merge = "merge tall.tile####.exr -o merged.exr";
    if cfg!(unix) {
        let output = std::process::Command::new("sh")
            .current_dir(folder.path())
            .args(["-c", &format!("ulimit -n 40; exec \"$0\" {merge}")])
            .arg(env!("CARGO_BIN_EXE_candela"))
            .output()
            .unwrap();
        assert_eq!(
            text(&output.stderr),
            "merged.exr: 24 × 2160, merged from 64 tiles\n"
        );
    } else {
        succeeds(folder.path(), merge);
    }
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(read("merged.exr") == read("whole.exr"));
}

#[test]
fn wrong_tiles_are_2() {
    let folder = tall();
    for (arguments, part) in [
        ("--tile 3", "expected I/N"),
        ("--tile 3/3", "expected I/N"),
        ("--tile 0/0", "expected I/N"),
        ("--tile -1/3", "expected I/N"),
        ("--tile 1/2/3", "expected I/N"),
        ("--tile a/b", "expected I/N"),
        ("--tile 0/5000000000", "expected I/N"),
        ("--tile 0/2 --crop 0,0,40,99 --full-window", "--full-window"),
        ("--tile 0/16", "234 rows make 15 strips of 16 rows"),
        ("--tile 0/16", "choose N of I/N from 1 to 15"),
        (
            "--tile 8/9 --compression piz",
            "234 rows make 8 strips of 32 rows under compression piz",
        ),
        (
            "--tile 0/2 --compression dwab",
            "234 rows make 1 strip of 256 rows",
        ),
        ("--tile 0/2 --crop 0,3,9,19", "16 rows make 1 strip of 16"),
    ] {
        let message = fails(folder.path(), &format!("render tall.toml {arguments}"), 2);
        assert!(message.contains(part), "{arguments}: {message}");
    }
    for (arguments, part) in [
        ("merge", "IN.exr"),
        ("merge t0.exr", "--output"),
        ("merge t0.exr -o a.png", "a.exr"),
    ] {
        let message = fails(folder.path(), arguments, 2);
        assert!(message.contains(part), "{arguments}: {message}");
    }
    assert_eq!(files(folder.path()), ["ball.toml", "tall.toml"]);
}

/// Nothing is written over, and one message names the file and the way out.
#[test]
fn what_cannot_be_merged_is_said() {
    let folder = tall();
    let path = |name: &str| folder.path().join(name);
    tiles(folder.path(), "--samples 1", 3);
    let other = |options: &str, name: &str| {
        succeeds(
            folder.path(),
            &format!("render tall.toml -q --tile 1/3 {options} -o {name}.exr"),
        );
    };
    other("--samples 2", "samples");
    other("--samples 1 --layers depth", "layers");
    other("--samples 1 --half", "half");
    other("--samples 1 --compression zips", "compression");
    other("--samples 1 --crop 0,0,40,200", "crop");
    other("--samples 1 --transport spectral", "transport");
    succeeds(
        folder.path(),
        "render tall.toml -q --samples 1 --tile 1/4 -o count.exr",
    );
    let scene = fs::read_to_string(path("tall.toml")).unwrap();
    fs::write(
        path("tall.toml"),
        scene.replace("intensity = 4", "intensity = 5"),
    )
    .unwrap();
    other("--samples 1", "scene");
    fs::write(path("tall.toml"), scene).unwrap();
    succeeds(
        folder.path(),
        "render tall.toml -q --samples 1 -o plain.exr",
    );
    succeeds(
        folder.path(),
        "render tall.toml -q --samples 1 --crop 0,80,40,160 -o part.exr",
    );
    fs::copy(path("t1.exr"), path("copy.exr")).unwrap();
    let bytes = fs::read(path("t1.exr")).unwrap();
    let changed = |name: &str, old: &str, new: &str| {
        let mut bytes = bytes.clone();
        let place = bytes
            .windows(old.len())
            .position(|here| here == old.as_bytes());
        let place = place.unwrap();
        bytes[place..place + old.len()].copy_from_slice(new.as_bytes());
        fs::write(path(name), bytes).unwrap();
    };
    let version = concat!("candela ", env!("CARGO_PKG_VERSION"));
    changed("software.exr", version, &version.replace('0', "9"));
    changed("place.exr", "1/3candela", "2/3candela");
    changed("number.exr", "1/3candela", "1-3candela");
    let mut flipped = bytes.clone();
    let last = flipped.len() - 9;
    flipped[last] ^= 1;
    fs::write(path("flipped.exr"), flipped).unwrap();
    fs::write(path("cut.exr"), &bytes[..bytes.len() - 1]).unwrap();
    fs::write(path("short.exr"), &bytes[..300]).unwrap();
    fs::write(path("text.exr"), "no EXR").unwrap();
    fs::write(path("old.exr"), "old").unwrap();
    other("--samples 1 --layers lights", "lights");
    succeeds(
        folder.path(),
        "relight lights.exr -q -o relit.exr --light key=2",
    );
    let before = files(folder.path());
    for (inputs, parts) in [
        ("t0.exr", &["tiles 1-2 of 3 are missing", "--tile 1/3"][..]),
        ("t0.exr t2.exr", &["tile 1 of 3 is missing", "--tile 1/3"]),
        ("t1.exr", &["tiles 0, 2 of 3 are missing"]),
        (
            "t2.exr copy.exr t0.exr t1.exr",
            &["copy.exr and t1.exr are both tile 1/3"],
        ),
        ("t0.exr t0.exr t1.exr t2.exr", &["are both tile 0/3"]),
        (
            "t0.exr scene.exr t2.exr",
            &[
                "t0.exr and scene.exr",
                "`candela:inputs_sha256` is `",
                "the scene",
            ],
        ),
        (
            "t0.exr samples.exr t2.exr",
            &[
                "`candela:samples` is 1 in the first and 2 in the second",
                "same options",
            ],
        ),
        (
            "t0.exr software.exr t2.exr",
            &[
                "`software` is `candela",
                "render all tiles with one version",
            ],
        ),
        (
            "t0.exr layers.exr t2.exr",
            &["`candela:layers` is not there in the first and `depth` in"],
        ),
        (
            "t0.exr half.exr t2.exr",
            &["`channels` is `A FLOAT, ", "`A HALF, "],
        ),
        (
            "t0.exr compression.exr t2.exr",
            &["`compression` is zip in the first and zips in the second"],
        ),
        (
            "t0.exr crop.exr t2.exr",
            &["`candela:tile_window` is 0 0 39 233 in the first and 0 0 39 199"],
        ),
        (
            "t0.exr transport.exr t2.exr",
            &["`candela:transport` is `rgb` in the first and `spectral`"],
        ),
        (
            "t0.exr count.exr t2.exr",
            &["t0.exr is tile 0/3, and count.exr is tile 1/4"],
        ),
        (
            "plain.exr",
            &["plain.exr is no tile", "candela render --tile I/N"],
        ),
        ("t0.exr relit.exr t2.exr", &["relit.exr is no tile"]),
        ("t0.exr part.exr t2.exr", &["part.exr is no tile", "--crop"]),
        (
            "t0.exr t1.exr place.exr",
            &[
                "place.exr says that it is tile 2/3",
                "rows are not 160 to 233",
            ],
        ),
        (
            "t0.exr number.exr t2.exr",
            &["number.exr does not say which tile"],
        ),
        (
            "t0.exr flipped.exr t2.exr",
            &["flipped.exr is damaged", "--tile 1/3"],
        ),
        (
            "t0.exr cut.exr t2.exr",
            &["cut.exr is damaged", "--tile 1/3"],
        ),
        (
            "t0.exr short.exr t2.exr",
            &["cannot read short.exr", "render it anew"],
        ),
        (
            "t0.exr text.exr t2.exr",
            &["text.exr", "it is not an OpenEXR file"],
        ),
        ("t0.exr absent.exr t2.exr", &["cannot read absent.exr"]),
        ("t0.exr . t2.exr", &["cannot read ."]),
        (
            "t0.exr - t2.exr",
            &["cannot merge standard input", "to a file"],
        ),
        ("x*.exr", &["no file has a name like x*.exr"]),
    ] {
        let message = fails(folder.path(), &format!("merge {inputs} -o old.exr"), 1);
        for part in parts {
            assert!(message.contains(part), "{inputs}: {message}");
        }
    }
    for (arguments, part) in [
        (
            "merge t0.exr t1.exr t2.exr -o t1.exr",
            "t1.exr would be written over t1.exr, which is read",
        ),
        (
            "merge t0.exr t1.exr t2.exr -o absent/a.exr",
            "the folder absent does not exist",
        ),
    ] {
        let message = fails(folder.path(), arguments, 1);
        assert!(message.contains(part), "{arguments}: {message}");
    }
    assert_eq!(files(folder.path()), before);
    assert_eq!(fs::read(path("old.exr")).unwrap(), b"old");
}

#[test]
fn any_order_any_names_and_through_a_pipe() {
    let folder = tall();
    tiles(folder.path(), "--samples 1", 3);
    succeeds(
        folder.path(),
        "render tall.toml -q --samples 1 -o whole.exr",
    );
    let whole = fs::read(folder.path().join("whole.exr")).unwrap();
    let piped = candela(folder.path(), "merge t2.exr t0.exr t1.exr -o -");
    let piped = { piped }.output().unwrap();
    assert!(piped.stdout == whole);
    assert_eq!(
        text(&piped.stderr),
        "standard output: 40 × 234, merged from 3 tiles\n"
    );
    for inputs in ["t%d.exr", "t[0-2].exr"] {
        succeeds(folder.path(), &format!("merge {inputs} -q -o m.exr"));
        assert!(
            fs::read(folder.path().join("m.exr")).unwrap() == whole,
            "{inputs}"
        );
    }
}

/// Two machines that were given one tile, at the same time.
#[test]
fn two_processes_write_one_tile() {
    let folder = tall();
    let render = "render tall.toml -q --samples 64 --tile 1/3 -o t1.exr";
    let started = [(); 2].map(|()| candela(folder.path(), render).spawn().unwrap());
    for process in started {
        assert!(process.wait_with_output().unwrap().status.success());
    }
    let both = fs::read(folder.path().join("t1.exr")).unwrap();
    succeeds(folder.path(), render);
    assert!(fs::read(folder.path().join("t1.exr")).unwrap() == both);
    assert_eq!(files(folder.path()), ["ball.toml", "t1.exr", "tall.toml"]);
}
