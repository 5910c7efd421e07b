//! What is seen of light that no surface reflects: lights themselves, and the background.

use super::filters::Filters;
use crate::math::Point;
use crate::simd::{LANES, ones};
use crate::visibility::{Column, Points, vector};
use crate::world::World;
use crate::world::light::AreaLight;

/// Adds what lights that are seen send themselves: L from the side that shines.
#[inline(never)]
pub(super) fn add_emission(
    world: &World,
    points: &Points,
    packet: usize,
    filters: &Filters,
    radiance: &mut [Column; 3],
) {
    for lane in ones(points.hit[packet]) {
        let slot = packet * LANES + lane;
        if let Some((_, luminance)) = emission(world, points, filters, slot) {
            for (column, channel) in radiance.iter_mut().zip(luminance) {
                column[slot] += channel;
            }
        }
    }
}

/// The light that a point is on, if it is seen from the side that shines, and its luminance as it is seen.
pub(crate) fn emission(
    world: &World,
    points: &Points,
    filters: &Filters,
    slot: usize,
) -> Option<(usize, [f64; 3])> {
    let (index, light) = emitter_seen(world, points, slot)?;
    let luminance = filters.luminance(world, filters.number(slot), (index, light));
    Some((index, luminance))
}

/// The background as it is seen through filters, where nothing is hit.
#[inline(never)]
pub(super) fn filter_background(
    world: &World,
    filters: &Filters,
    hit: u32,
    first: usize,
    radiance: &mut [Column; 3],
) {
    // What is black has no color.
    if world.background().0.0 == [0.0; 3] {
        return;
    }
    let mut last: Option<(u16, Option<[f64; 3]>)> = None;
    for lane in ones(!hit & ((1 << LANES) - 1)) {
        let number = filters.number(first + lane);
        let background = match last {
            Some((known, background)) if known == number => background,
            _ => filters.background(world, number),
        };
        last = Some((number, background));
        if let Some(background) = background {
            for (column, channel) in radiance.iter_mut().zip(background) {
                column[first + lane] = channel;
            }
        }
    }
}

/// The light that a point is on, if it is seen from the side that shines, and which it is.
pub(crate) fn emitter_seen<'w>(
    world: &'w World,
    points: &Points,
    slot: usize,
) -> Option<(usize, &'w AreaLight)> {
    let position = Point(vector(&points.position, slot));
    let to_viewer = vector(&points.to_viewer, slot);
    world.emitter_seen(points.object(slot), position, to_viewer)
}
