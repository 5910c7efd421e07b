//! Every channel of a file by itself.

use std::fs;

use candela::exr::{DataWindow, ExrChannels};

use super::file::{Channel, Part, bytes, channel, row, write};

/// A name, and a value by column and row in the file's coordinates.
fn value(x: i32, y: i32) -> f32 {
    (100 * y + x) as f32
}

/// Lines of 6 × 4 pixels from (−2, 4) on, in a display window from (0, 0) on.
fn part() -> Part {
    let halved = Channel {
        sampling: 2,
        ..channel("BY", value)
    };
    Part {
        data: [-2, 4, 3, 7],
        display: [0, 0, 9, 9],
        ..row(
            6,
            vec![channel("Y", value), halved, channel("N.X", |x, _| x as f32)],
        )
    }
}

#[test]
fn channels_of_fewer_samples_are_repeated() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(folder.path(), &[part()]);
    let file = ExrChannels::open(&path).unwrap();
    let names: Vec<&str> = file
        .names()
        .iter()
        .map(|channel| channel.name.as_str())
        .collect();
    assert_eq!(names, ["BY", "N.X", "Y"]);
    let window = DataWindow {
        resolution: [10, 10],
        corner: [-2, 4],
        size: [6, 4],
    };
    assert_eq!(file.window(&file.names()[0]), window);
    // In the order that is asked for.
    let [by, x, y] = [0, 1, 2].map(|place| &file.names()[place]);
    let planes = file.read(&[y, by, x]).unwrap();
    for (place, (column, line)) in (4..8)
        .flat_map(|y| (-2..4).map(move |x| (x, y)))
        .enumerate()
    {
        assert_eq!(planes[0][place], value(column, line));
        assert_eq!(
            planes[1][place],
            value(column - column.rem_euclid(2), line / 2 * 2)
        );
        assert_eq!(planes[2][place], column as f32);
    }
}

#[test]
fn parts_have_names_where_channels_have_one() {
    let folder = tempfile::tempdir().unwrap();
    let named = |name: &'static str, factor: f32| {
        row(3, vec![channel("Z", move |x, _| factor * x as f32)]).with("name", "string", name)
    };
    let path = write(folder.path(), &[named("near", 1.0), named("far", 10.0)]);
    let file = ExrChannels::open(&path).unwrap();
    let names: Vec<&str> = file
        .names()
        .iter()
        .map(|channel| channel.name.as_str())
        .collect();
    assert_eq!(names, ["Z", "far.Z"]);
    let planes = file.read(&file.names().iter().collect::<Vec<_>>()).unwrap();
    assert_eq!(planes, [[0.0, 1.0, 2.0], [0.0, 10.0, 20.0]]);
}

/// Whatever byte is wrong: an error or other numbers, no panic.
#[test]
fn damaged_files_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let whole = bytes(&[part(), row(5, vec![channel("R", value)])]);
    let path = folder.path().join("damaged.exr");
    let mut errors = 0;
    for place in 0..whole.len() {
        for wrong in [0, 1, 0x7f, 0xff] {
            let mut damaged = whole.clone();
            damaged[place] = wrong;
            fs::write(&path, damaged).unwrap();
            let read = ExrChannels::open(&path);
            let read = read.and_then(|file| file.read(&file.names().iter().collect::<Vec<_>>()));
            errors += usize::from(read.is_err());
        }
    }
    assert!(errors > whole.len(), "{errors}");
}
