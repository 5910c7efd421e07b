//! What rays took, counted: the same from run to run, however busy the machine is.

use std::fmt::Write as _;

use candela::render::{Counts, RayWork};
use serde::Serialize;

use super::compare::Row;

/// What primary and shadow rays took.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Work {
    primary: OfRays,
    shadow: OfRays,
}

/// What rays of one kind took.
#[derive(Clone, Copy, Debug, Serialize)]
struct OfRays {
    rays: u64,
    #[serde(flatten)]
    work: RayWork,
}

impl Work {
    pub(crate) fn of(counts: &Counts) -> Self {
        Self {
            primary: OfRays::new(counts.primary_rays, counts.work.primary),
            shadow: OfRays::new(counts.shadow_rays, counts.work.shadow),
        }
    }
}

impl OfRays {
    fn new(rays: u64, work: RayWork) -> Self {
        Self { rays, work }
    }

    /// How often each leaf was set up, the pairs that a resolved sample took, the parts in percent of rays that fell
    /// back and of batches that were resolved whole, and the MB that were read of leaf blocks.
    fn cells(&self) -> String {
        let Self { rays, work } = self;
        let resolved = rays - work.fallbacks;
        let distinct = work.distinct_leaves.unwrap_or(0);
        [
            quotient(work.leaves, distinct, 1.0, 2),
            quotient(work.pairs, resolved, 1.0, 3),
            quotient(work.fallbacks, *rays, 100.0, 3),
            quotient(work.resolved_whole, work.batches, 100.0, 1),
            format!("{:.1}", work.leaf_bytes as f64 / 1e6),
        ]
        .join(" | ")
    }
}

/// A quotient, if there is one.
fn quotient(part: u64, whole: u64, scale: f64, digits: usize) -> String {
    if whole == 0 {
        return "–".to_owned();
    }
    format!("{:.digits$}", scale * part as f64 / whole as f64)
}

/// The table of all rows.
pub(crate) fn markdown(rows: &[Row]) -> String {
    let mut text = "\nWhat rays took, counted by `--stats`: how often each leaf of triangles was set up, tests of a triangle \
                    against a packet for each sample that f32 resolved, rays that fell back to f64, batches resolved \
                    whole, leaf blocks read.\n\n\
                    | scene | lights | samples | rays | set-ups of a leaf | pairs a sample | fell back, % | \
                    whole, % | read, MB |\n\
                    | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n"
        .to_owned();
    for row in rows {
        for (kind, work) in [("primary", row.work.primary), ("shadow", row.work.shadow)] {
            // Writing to a string does not fail.
            let _ = writeln!(
                text,
                "| {} | {} | {} | {kind} | {} |",
                row.scene,
                row.lights,
                row.samples,
                work.cells(),
            );
        }
    }
    text
}
