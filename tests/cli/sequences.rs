//! Many files in one call of `tonemap`, and screens.

use std::fs;

use super::{candela, files, folder, output, succeeds, text};

/// Frames become pictures, a damaged one keeps none of the others from it, and what was there stays.
#[test]
fn frames_of_which_one_is_damaged() {
    let folder = folder();
    let folder = folder.path();
    for frame in ["0001", "0003"] {
        succeeds(folder, &format!("render ball.toml -q -o f.{frame}.exr"));
    }
    fs::write(folder.join("f.0002.exr"), "no picture").unwrap();
    fs::write(folder.join("o2.png"), "before").unwrap();
    let done = output(folder, "tonemap f.####.exr -o o%d.png");
    assert_eq!(done.status.code(), Some(1));
    let told = text(&done.stderr);
    assert!(told.contains("error: cannot read f.0002.exr"), "{told}");
    assert!(
        told.ends_with("error: 1 of 3 files could not be converted\n"),
        "{told}"
    );
    let pictures: Vec<String> = files(folder)
        .into_iter()
        .filter(|name| name.ends_with(".png"))
        .collect();
    assert_eq!(pictures, ["o1.png", "o2.png", "o3.png"]);
    assert_eq!(fs::read(folder.join("o2.png")).unwrap(), b"before");
    // As one by one.
    succeeds(folder, "tonemap f.0003.exr -o alone.png");
    let read = |name: &str| fs::read(folder.join(name)).unwrap();
    assert!(read("alone.png") == read("o3.png"));
}

#[test]
fn many_files_need_many_names() {
    let folder = folder();
    let folder = folder.path();
    for name in ["a", "b"] {
        succeeds(folder, &format!("render ball.toml -q -o {name}.exr"));
    }
    for (arguments, part) in [
        (
            "tonemap a.exr b.exr -o one.png",
            "name the outputs with ####",
        ),
        (
            "tonemap a.exr b.exr --watch",
            "--watch takes one file, not 2",
        ),
        ("tonemap *.tif", "no file has a name like *.tif"),
        ("tonemap g.####.exr", "no frame has a name like g.####.exr"),
        (
            "tonemap a.exr o.png",
            "o.png is not there; a file to write is named by -o o.png",
        ),
    ] {
        let done = output(folder, arguments);
        // Wrong usage is what no file can cure.
        let is_misuse = part.contains("takes one file") || part.contains("name the outputs");
        let code = if is_misuse { 2 } else { 1 };
        assert_eq!(done.status.code(), Some(code), "{arguments}");
        let told = text(&done.stderr);
        assert!(told.contains(part), "{arguments}: {told}");
    }
    assert_eq!(files(folder), ["a.exr", "b.exr", "ball.toml"]);
    // A folder that is there, and the current one.
    fs::create_dir(folder.join("png")).unwrap();
    succeeds(folder, "tonemap *.exr -o png");
    succeeds(folder, "tonemap a.exr b.exr");
    for name in ["a.png", "b.png"] {
        let [here, there] = [name.to_owned(), format!("png/{name}")]
            .map(|path| fs::read(folder.join(path)).unwrap());
        assert!(here == there, "{name}");
    }
}

/// HDR has 16 bits, cICP's code points, and a viewer that is not there is said to be so.
#[test]
fn screens_and_viewers() {
    let folder = folder();
    let folder = folder.path();
    succeeds(folder, "render ball.toml -q -o a.exr");
    for (display, depth, points) in [
        ("srgb", 8, [1, 13]),
        ("p3", 8, [12, 13]),
        ("rec2020-pq", 16, [9, 16]),
        ("rec2020-hlg", 16, [9, 18]),
        ("rec1886", 8, [1, 1]),
        ("linear", 8, [1, 8]),
    ] {
        succeeds(
            folder,
            &format!("tonemap a.exr --display {display} -o a.png"),
        );
        let bytes = fs::read(folder.join("a.png")).unwrap();
        assert_eq!(bytes[24], depth, "{display}");
        let place = bytes.windows(4).position(|word| word == b"cICP").unwrap();
        assert_eq!(
            bytes[place + 4..][..4],
            [points[0], points[1], 0, 1],
            "{display}"
        );
    }
    let missed = candela(
        folder,
        "tonemap a.exr -o b.png --display-server 127.0.0.1:1",
    )
    .output()
    .unwrap();
    assert_eq!(missed.status.code(), Some(1));
    let told = text(&missed.stderr);
    assert!(
        told.starts_with("error: no viewer takes pictures at 127.0.0.1:1: "),
        "{told}"
    );
    assert!(!folder.join("b.png").exists());
}
