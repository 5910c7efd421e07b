//! What is measured of a layer.

use candela::compare::Metrics;
use serde::Serialize;

use super::layers::Layer;

/// What was found of a layer.
#[derive(Serialize)]
pub(super) struct LayerReport {
    pub(super) name: String,
    pub(super) channels: Vec<String>,
    /// The data window's left column, top row, width and height, from the display window's top left.
    window: [i64; 4],
    /// The channel of the largest error.
    pub(super) max_in: Option<String>,
    #[serde(flatten)]
    pub(super) metrics: Metrics,
    /// The mean of ꟻLIP, where the layer has colors.
    pub(super) flip: Option<f64>,
    /// The mean of HDR-ꟻLIP, where there is one.
    pub(super) hdr_flip: Option<f64>,
}

impl LayerReport {
    pub(super) fn new(
        layer: &Layer,
        mut metrics: Metrics,
        flips: Option<(f64, Option<f64>)>,
    ) -> Self {
        let [x, y] = layer.window.corner;
        let [width, height] = layer.window.size.map(i64::from);
        // As all coordinates that a user sees, from the display window's top left.
        for at in [&mut metrics.max_at, &mut metrics.relative_max_at]
            .into_iter()
            .flatten()
        {
            at.x += x;
            at.y += y;
        }
        Self {
            name: layer.name.clone(),
            channels: layer.names().map(str::to_owned).collect(),
            window: [x, y, width, height],
            max_in: metrics
                .max_at
                .map(|at| layer.short_name(at.channel).to_owned()),
            metrics,
            flip: flips.map(|(flip, _)| flip),
            hdr_flip: flips.and_then(|(_, hdr)| hdr),
        }
    }
}

/// The mean, summed up in f64.
pub(super) fn mean(values: &[f32]) -> f64 {
    values.iter().copied().map(f64::from).sum::<f64>() / values.len() as f64
}
