//! Layers as arrays for NumPy: each light by itself, depth and normals.
//!
//! ```console
//! $ cargo run --release --example layers_to_numpy -- SCENE.toml FOLDER
//! $ python3 -c 'import numpy; print(numpy.load("FOLDER/light_key.npy").shape)'
//! (720, 1280, 3)
//! ```
//!
//! Each layer becomes one array of 32-bit floats, [row, column, channel] from the top left: `rgba`, then
//! `light_NAME` in cd/m², `Z` in scene units and `N`. They add up: `sum(light_*) == rgba[:, :, :3]`.

use std::error::Error;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use candela::render::Layers;
use candela::world::Loaded;
use candela::{Film, Options, World, render};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let scene = arguments
        .next()
        .unwrap_or_else(|| "scenes/lecture.toml".into());
    let folder = arguments.next().unwrap_or_else(|| ".".into());
    for file in run(Path::new(&scene), Path::new(&folder))? {
        println!("{}", file.display());
    }
    Ok(())
}

/// Renders a scene file with its layers, and returns the files that they were written to.
pub(crate) fn run(scene: &Path, folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let Loaded { world, camera, .. } = World::load(scene)?;
    let options = Options {
        layers: Layers {
            lights: true,
            depth: true,
            normal: true,
            ..Layers::default()
        },
        ..Options::default()
    };
    let film = render(&world, &camera, &options)?;

    let rgba: Vec<f32> = film.pixels().iter().flatten().copied().collect();
    let mut files = vec![write(folder, "rgba", &film, 4, &rgba)?];
    // Channels of one layer are side by side: `light_key.R`, `light_key.G`, `light_key.B`.
    let names: Vec<&str> = film
        .channels()
        .list
        .iter()
        .map(|channel| channel.name.as_str())
        .collect();
    let layer = |name: &str| {
        name.rsplit_once('.')
            .map_or(name, |(layer, _)| layer)
            .to_owned()
    };
    let mut first = 0;
    for channels in names.chunk_by(|a, b| layer(a) == layer(b)) {
        let last = first + channels.len();
        // What a pixel has beside R, G, B, A, in the order of the channels.
        let values: Vec<f32> = (0..film.pixels().len())
            .flat_map(|pixel| film.values(pixel)[first..last].to_vec())
            .collect();
        files.push(write(
            folder,
            &layer(channels[0]),
            &film,
            channels.len(),
            &values,
        )?);
        first = last;
    }
    Ok(files)
}

/// Writes an array of [rows, columns, channels] as `NAME.npy`, or of [rows, columns] where there is one
/// channel.
fn write(
    folder: &Path,
    name: &str,
    film: &Film,
    channels: usize,
    values: &[f32],
) -> io::Result<PathBuf> {
    let [width, height] = film.resolution();
    let shape = match channels {
        1 => format!("({height}, {width})"),
        _ => format!("({height}, {width}, {channels})"),
    };
    // The format's version 1.0: a magic, a version, the length of a header that is a Python literal,
    // padded so that the data begin at a multiple of 64 bytes.
    let mut header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}");
    let start = 10;
    let padded = (start + header.len() + 1).next_multiple_of(64) - start;
    header = format!("{header:<width$}\n", width = padded - 1);
    let length = u16::try_from(header.len()).map_err(io::Error::other)?;

    let path = folder.join(format!("{name}.npy"));
    let mut file = BufWriter::new(File::create(&path)?);
    file.write_all(b"\x93NUMPY\x01\x00")?;
    file.write_all(&length.to_le_bytes())?;
    file.write_all(header.as_bytes())?;
    for value in values {
        file.write_all(&value.to_le_bytes())?;
    }
    file.flush()?;
    Ok(path)
}
