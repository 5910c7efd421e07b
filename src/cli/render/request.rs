//! What is to be rendered, and how it is stored.

use std::path::Path;

use candela::Camera;
use candela::exr::{ExrOptions, Precision, Preserve, Tile};
use candela::image::{Channels, Window};
use candela::internal::{Size, printable_path};
use candela::render::{self, Layers, Options};
use candela::world::{Bands, World};

use super::Arguments;
use super::outputs::Outputs;
use super::stage::Stage;
use crate::cli::display_server::DisplayServer;
use crate::cli::frames::Frame;
use crate::cli::{Failure, failure};

/// Options of the library, made from those of the command line.
pub(super) struct Request {
    pub(super) options: Options,
    /// What of the image is rendered.
    pub(super) window: Window,
    pub(super) exr: ExrOptions,
    /// Whether a preview is made of the file.
    pub(super) preserve: Preserve,
    /// Of the whole image.
    resolution: [u32; 2],
    frame: Option<Frame>,
    /// Whether the bands of a spectral image have a file of their own.
    has_bands_apart: bool,
}

impl Request {
    pub(super) fn new(
        arguments: &Arguments,
        stage: &Stage,
        frame: Option<Frame>,
    ) -> Result<Self, Failure> {
        let (world, camera) = (&stage.world, &stage.camera);
        arguments.layers.check(world)?;
        let crop = arguments
            .crop
            .map(|crop| crop.within("--crop", camera.resolution()));
        let crop = crop.transpose()?;
        let tile = arguments.tile.map(|number| Tile {
            number,
            of: crop.unwrap_or(Window::whole(camera.resolution())),
        });
        let of_tile = tile.map(|tile| tile.window(arguments.compression));
        let of_tile = of_tile
            .transpose()
            .map_err(|error| failure::Misuse(format!("--tile: {error}")))?;
        let options = Options {
            samples: arguments.accuracy.samples,
            target: arguments.accuracy.target(),
            cuts_areas: false,
            window: of_tile.or(crop),
            layers: arguments.layers.layers(),
            simd: arguments.simd.unwrap_or_default(),
            frame: stage.frame(frame),
            counts_work: arguments.stats.is_some(),
        };
        Ok(Self {
            window: options.check(world, camera)?,
            options,
            exr: ExrOptions {
                precision: if arguments.half {
                    Precision::Half
                } else {
                    Precision::Float
                },
                compression: arguments.compression,
                chromaticities: arguments.chromaticities,
                full_window: arguments.full_window,
                tile,
            },
            resolution: camera.resolution(),
            frame,
            has_bands_apart: arguments.layers.spectral_output.is_some(),
            preserve: match arguments.preview {
                Some(_) => Preserve::Image,
                None => Preserve::Nothing,
            },
        })
    }

    /// The frame that is asked for.
    pub(super) const fn frame(&self) -> Option<Frame> {
        self.frame
    }

    /// Whether all of it is there already.
    pub(super) fn is_done(&self, stage: &Stage, outputs: &Outputs) -> Result<bool, Failure> {
        let (world, camera) = (&stage.world, &stage.camera);
        let bands = outputs.bands.as_deref();
        let done = render::is_done(world, camera, &self.options, &self.exr, &outputs.exr, bands);
        Ok(done?)
    }

    /// A viewer's image for what is rendered.
    pub(super) fn show(
        &self,
        world: &World,
        camera: &Camera,
        address: &str,
        output: &Path,
    ) -> Result<DisplayServer, Failure> {
        let own = ["R", "G", "B", "A"].map(str::to_owned);
        let further = self.options.layers.channels(world).list;
        let further = further.into_iter().map(|channel| channel.name);
        let name = if output == Path::new("-") {
            "candela".to_owned()
        } else {
            printable_path(output)
        };
        let channels = own.into_iter().chain(further).collect();
        DisplayServer::connect(address, &name, camera.resolution(), channels)
    }

    /// Whether the file can hold what is asked for, and the memory what it takes on the way.
    pub(super) fn check(&self, world: &World) -> Result<(), Failure> {
        let layers = &self.options.layers;
        let channels = layers.channels(world);
        self.exr.check(self.window, &channels)?;
        let spectral = world.spectra().zip(layers.spectral);
        let table = spectral.map_or(0, |(spectra, wavelengths)| {
            Bands::size(spectra, wavelengths)
        });
        let threads = rayon::current_num_threads();
        let values = 4 + channels.list.len() as u64;
        // The whole film is there where its header says what came of it, and where it is written in another shape.
        let films = u64::from(self.options.target.is_some())
            + u64::from(self.exr.full_window)
            + 2 * u64::from(self.has_bands_apart);
        let pixels = if self.exr.full_window {
            self.resolution.map(u64::from).into_iter().product()
        } else {
            self.window.count()
        };
        let film = pixels.saturating_mul(4 * values).saturating_mul(films);
        let [pixels, all] = [Preserve::Nothing, self.preserve].map(|preserve| {
            let parts = render::memory(self.window, &channels, &self.exr, preserve, threads);
            parts.saturating_add(film)
        });
        fits_in_memory(pixels, all - pixels, table, layers, &channels).map_err(failure::transient)
    }
}

/// Whether the system would give the memory for so many bytes of pixels under way, for so many of a
/// preview, and for a table of so many numbers for the bands of lights on materials.
fn fits_in_memory(
    pixels: u64,
    preview: u64,
    table: u64,
    layers: &Layers,
    channels: &Channels,
) -> Result<(), Failure> {
    let mut rows: Vec<u8> = Vec::new();
    let mut bands: Vec<f64> = Vec::new();
    let pixels = pixels.saturating_add(preview);
    let fits = usize::try_from(pixels).is_ok_and(|count| rows.try_reserve_exact(count).is_ok())
        && usize::try_from(table).is_ok_and(|count| bands.try_reserve_exact(count).is_ok());
    if fits {
        return Ok(());
    }
    let table = table.saturating_mul(size_of::<f64>() as u64);
    let size = Size(pixels.saturating_add(table));
    if table > pixels {
        return Err(format!(
            "the bands of all lights on all materials take {size} of memory, more than \
             there is; choose fewer --wavelengths, or fewer lights or materials",
        )
        .into());
    }
    if preview > pixels - preview {
        return Err(format!(
            "the pixels of the preview take {size} of memory, more than there is; leave --preview \
             out and make the PNG with `candela tonemap`, or render the image in parts with --crop",
        )
        .into());
    }
    let fewer = if layers.spectral.is_some() {
        "fewer --wavelengths or "
    } else if !channels.list.is_empty() {
        "fewer --layers or "
    } else {
        ""
    };
    Err(format!(
        "the rows of the image that are rendered at once take {size} of memory, more than \
         there is; choose {fewer}a smaller `resolution`, or render it in parts with --crop",
    )
    .into())
}

#[cfg(test)]
mod tests {
    use candela::scene::Scene;
    use candela::world::Wavelengths;

    use super::*;

    #[test]
    fn what_does_not_fit_in_memory_is_said() {
        let layers = Layers {
            spectral: Some(Wavelengths::default()),
            ..Layers::default()
        };
        let channels = layers.channels(&World::new(&Scene::builtin()).unwrap().0);
        assert!(fits_in_memory(1000, 0, 1000, &layers, &channels).is_ok());
        // 2⁵⁸ numbers are 2⁶¹ bytes, more than any machine addresses.
        let message = |table| {
            let error = fits_in_memory(1000, 0, table, &layers, &channels).unwrap_err();
            error.to_string()
        };
        for table in [1 << 58, u64::MAX] {
            let message = message(table);
            assert!(
                message.contains("bands of all lights on all materials"),
                "{message}"
            );
            assert!(
                message.contains("fewer --wavelengths, or fewer lights"),
                "{message}"
            );
        }
        assert!(
            message(1 << 58).contains("2305843009.2 GB"),
            "{}",
            message(1 << 58)
        );

        let rows = |layers: &Layers, channels| {
            let error = fits_in_memory(1 << 61, 0, 0, layers, channels).unwrap_err();
            error.to_string()
        };
        let message = rows(&layers, &channels);
        assert!(message.contains("2305843009.2 GB"), "{message}");
        assert!(
            message.contains("fewer --wavelengths or a smaller"),
            "{message}"
        );
        let message = rows(&Layers::default(), &Channels::default());
        assert!(
            message.contains("choose a smaller `resolution`"),
            "{message}"
        );
        let error = fits_in_memory(1000, 1 << 61, 0, &layers, &channels).unwrap_err();
        let message = error.to_string();
        assert!(message.contains("leave --preview out"), "{message}");
    }
}
