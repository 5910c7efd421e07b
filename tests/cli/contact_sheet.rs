//! `candela contact-sheet`: what is on the sheet, and what it refuses.

use std::fs;

use candela::exr::{DataWindow, write_planes};
use candela::output::Unfinished;

use super::{fails, files, folder, output, succeeds, text};
use crate::openimageio::decode;

/// The ground of the sheet, in a PNG's codes over 255.
const GROUND: f32 = 30.0 / 255.0;

#[test]
fn views_and_layers() {
    let folder = folder();
    let folder = folder.path();
    succeeds(
        folder,
        "render ball.toml -o ball.exr --layers lights,depth,normal",
    );
    succeeds(folder, "contact-sheet ball.exr --width 120");
    succeeds(
        folder,
        "contact-sheet ball.exr --layers --width 120 -o layers.png",
    );
    assert_eq!(
        files(folder),
        ["ball.contact.png", "ball.exr", "ball.toml", "layers.png"]
    );
    // All views, four in a row, and five layers: R, G, B; N; two lights; Z.
    let views = decode(&folder.join("ball.contact.png"));
    let layers = decode(&folder.join("layers.png"));
    assert_eq!(views.channels, ["R", "G", "B"]);
    let [_, _, width, height] = views.data_window;
    assert!(layers.data_window[3] < height);
    for [x, y] in [[0, 0], [width as usize - 1, height as usize - 1]] {
        let pixel = views.pixel(x, y);
        assert!(
            pixel.iter().all(|code| (code - GROUND).abs() < 1e-3),
            "{pixel:?}"
        );
    }
    // The same to the byte, each time.
    let before = fs::read(folder.join("layers.png")).unwrap();
    succeeds(
        folder,
        "contact-sheet ball.exr --layers --width 120 -o layers.png",
    );
    assert!(fs::read(folder.join("layers.png")).unwrap() == before);
}

/// The picture of a flat gray is flat, whatever the size, and the exposure is that of `tonemap`.
#[test]
fn means_and_exposure() {
    let folder = folder();
    let folder = folder.path();
    let window = DataWindow {
        resolution: [7, 5],
        corner: [0, 0],
        size: [7, 5],
    };
    // A checkerboard of 0 and 1.44, whose mean is 0.72.
    let board: Vec<f32> = (0..35)
        .map(|place| if place % 2 == 0 { 1.44 } else { 0.0 })
        .collect();
    let planes: Vec<(&str, &[f32])> = ["B", "G", "R"].map(|name| (name, &board[..])).to_vec();
    write_planes(
        &folder.join("board.exr"),
        window,
        &planes,
        &Unfinished::new(),
    )
    .unwrap();
    succeeds(
        folder,
        "contact-sheet board.exr --width 1 -o small.png --exposure -2",
    );
    let small = decode(&folder.join("small.png"));
    // 18 of 35 pixels are lit: 0.7406 / 4, coded as 0.4674, and dithered by less than a code. It is one pixel, after a
    // margin of 36 units of 0.75 pixels, below a title of 44 more.
    let code = small.pixel(27, 27 + 33)[0];
    assert!((code - 0.4674).abs() < 0.004, "{code}");

    // The same of its code values, whose light is that at −2 EV.
    for name in ["board.png", "board.tif"] {
        succeeds(
            folder,
            &format!("tonemap board.exr -o {name} --bits 16 --exposure -2"),
        );
        succeeds(
            folder,
            &format!("contact-sheet {name} --width 1 -o small.png"),
        );
        let code = decode(&folder.join("small.png")).pixel(27, 27 + 33)[0];
        assert!((code - 0.4674).abs() < 0.004, "{name}: {code}");
    }

    let sheet = output(
        folder,
        "contact-sheet board.exr --auto-exposure -o auto.png",
    );
    let tonemap = output(folder, "tonemap board.exr --auto-exposure -o tonemap.png");
    assert!(text(&sheet.stderr).starts_with("exposure: -3.000 EV"));
    assert!(text(&tonemap.stderr).ends_with(&text(&sheet.stderr)));
}

#[test]
fn what_is_refused() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("text.exr"), "no picture").unwrap();
    for (arguments, code, part) in [
        ("contact-sheet", 2, "IN.exr"),
        ("contact-sheet none.exr", 1, "cannot read none.exr"),
        ("contact-sheet text.exr", 1, "it is not an OpenEXR file"),
        (
            "contact-sheet text.exr --layers",
            1,
            "it is not an OpenEXR file",
        ),
        (
            "contact-sheet text.exr -o a.jpg",
            2,
            "writes PNG; name the file a.png",
        ),
        ("contact-sheet text.exr --width 0", 2, "from 1 to 4096"),
        ("contact-sheet text.exr --view reinhard", 2, "--layers"),
        (
            "contact-sheet text.exr --layers --layer Z",
            2,
            "cannot be used with",
        ),
        ("contact-sheet -", 1, "give it one with -o OUT.png"),
    ] {
        let message = fails(folder, arguments, code);
        assert!(message.contains(part), "{arguments}\n{message}");
    }
    assert_eq!(files(folder), ["ball.toml", "text.exr"]);
    image::RgbImage::new(3, 2)
        .save(folder.join("black.png"))
        .unwrap();
    for (option, named) in [("--layers", "--layers"), ("--layer glow", "--layer")] {
        let message = fails(folder, &format!("contact-sheet black.png {option}"), 1);
        let expected = format!("it is a PNG, which has no layers; leave {named} away");
        assert!(message.contains(&expected), "{message}");
    }
    succeeds(folder, "render ball.toml -o ball.exr");
    let message = fails(folder, "contact-sheet ball.exr -o ball.exr", 2);
    assert!(message.contains("ball.png"), "{message}");
    let message = fails(folder, "contact-sheet ball.exr --layer glow", 1);
    assert!(message.contains("it has no layer `glow`"), "{message}");
}
