//! What all tiles of a render have in common.

use super::layer_sums::RequestedLayers;
use super::options::MAX_SAMPLES;
use super::options::Options;
use super::sampling::Sampler;
use super::tile::Work;
use crate::camera::Camera;
use crate::image::{ImageSpec, Metadata, Window};
use crate::visibility::Visibility;
use crate::world::{Bands, Plan, World};

/// A world that is built, and the camera that looks at it.
#[derive(Clone, Copy)]
pub(super) struct View<'w> {
    pub(super) world: &'w World,
    pub(super) plan: &'w Plan,
    pub(super) visibility: &'w Visibility<'w>,
    pub(super) camera: &'w Camera,
}

/// Makes what all tiles have in common, and renders with it.
///
/// # Panics
/// As [`render`](super::render()).
pub(super) fn set_up<T>(
    view: View<'_>,
    options: &Options,
    render: impl FnOnce(Work<'_>, ImageSpec) -> T,
) -> T {
    assert!(
        (1..=MAX_SAMPLES).contains(&options.samples),
        "samples are out of range"
    );
    let View { world, camera, .. } = view;
    assert!(
        camera.anchor() == world.anchor(),
        "the camera is placed in another world"
    );
    let resolution = camera.resolution();
    let bands = options.layers.spectral.map(|wavelengths| {
        let spectra = world.spectra();
        Bands::new(
            spectra.expect("bands are asked for where light is spectral"),
            wavelengths,
        )
    });
    let spec = ImageSpec {
        resolution,
        window: options.window.unwrap_or(Window::whole(resolution)),
        channels: options.layers.channels(world),
        metadata: metadata(view, options),
    };
    let sampler = Sampler::new(options.samples);
    let work = Work {
        view,
        samples: options.samples,
        simd: options.simd,
        sampler: &sampler,
        layers: RequestedLayers::new(world, camera, options.layers, bands.as_ref()),
    };
    render(work, spec)
}

fn metadata(view: View<'_>, options: &Options) -> Metadata {
    let View {
        world,
        plan,
        camera,
        ..
    } = view;
    let plan = serde_json::to_string(plan).expect("a plan is plain data");
    let layers = options.layers.names();
    let layers = (!layers.is_empty()).then(|| ("layers".to_owned(), layers.join(",")));
    let inputs = ("inputs_sha256".to_owned(), world.inputs_hash().to_owned());
    let others = [
        ("plan".to_owned(), plan),
        ("samples".to_owned(), options.samples.to_string()),
        ("scene_sha256".to_owned(), world.scene_hash().to_owned()),
    ];
    Metadata {
        color_space: world.color_space(),
        world_to_camera: camera.world_to_camera(),
        world_to_ndc: camera.world_to_ndc(),
        provenance: std::iter::once(inputs)
            .chain(layers)
            .chain(others)
            .collect(),
    }
}
