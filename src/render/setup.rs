//! What all tiles of a render have in common.

use super::layer_sums::RequestedLayers;
use super::options::MAX_SAMPLES;
use super::options::Options;
use super::sampling::Sampler;
use super::tile::Work;
use crate::image::{ImageSpec, Metadata, Window};
use crate::visibility::Visibility;
use crate::world::{Bands, Plan, World};

/// Makes what all tiles have in common, and renders with it.
///
/// # Panics
/// As [`render`](super::render()).
pub(super) fn set_up<T>(
    world: &World,
    plan: &Plan,
    visibility: &Visibility<'_>,
    options: &Options,
    render: impl FnOnce(Work<'_>, ImageSpec) -> T,
) -> T {
    assert!(
        (1..=MAX_SAMPLES).contains(&options.samples),
        "samples are out of range"
    );
    let resolution = world.resolution();
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
        metadata: metadata(world, options, plan),
    };
    let sampler = Sampler::new(options.samples);
    let work = Work {
        world,
        visibility,
        samples: options.samples,
        simd: options.simd,
        sampler: &sampler,
        layers: RequestedLayers::new(world, options.layers, bands.as_ref()),
    };
    render(work, spec)
}

fn metadata(world: &World, options: &Options, plan: &Plan) -> Metadata {
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
        world_to_camera: world.camera().world_to_camera(world.anchor()),
        world_to_ndc: world.camera().world_to_ndc(world.anchor()),
        provenance: std::iter::once(inputs)
            .chain(layers)
            .chain(others)
            .collect(),
    }
}
