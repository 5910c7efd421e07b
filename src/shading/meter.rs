//! What a lux meter reads of a light with an area.

use fearless_simd::Simd;

use super::area::{ACCURACY_FOR_ERROR, AreaSpace, is_light, occluder};
use super::area_points::through_panes;
use crate::emitter::Receiver;
use crate::math::{Normal, Point};
use crate::visibility::{
    RayStart, Shaft, ShaftQuestion, Visibility, Workspace, object_and_triangle,
};
use crate::world::World;
use crate::world::light::AreaLight;

/// The illuminance in lux per cd of a light with an area, at a point that is on no shape, across a normal.
#[inline(always)]
pub(crate) fn area_illuminance<S: Simd>(
    simd: S,
    (world, visibility): (&World, &Visibility<'_>),
    (index, light): (usize, &AreaLight),
    (point, normal): (Point, Normal),
    rounding: f64,
    space: &mut AreaSpace,
    tracing: &mut Workspace,
) -> f64 {
    let emitter = &light.emitter;
    let receiver = Receiver {
        horizon: normal,
        normal,
        gloss: None,
    };
    let Some(received) = emitter.received(point, &receiver) else {
        return 0.0;
    };
    let shaft = Shaft::ToPoint {
        from: emitter.bounds(),
        to: point.0,
    };
    let question = ShaftQuestion::Contents;
    let all = usize::MAX;
    visibility.shaft(simd, &shaft, question, u64::MAX, all, &mut space.shafts);
    let sight = emitter.sight(point, normal);
    space.occluders.clear();
    space.panes_before.clear();
    for &shape in &space.shafts.list {
        let (object, triangle) = object_and_triangle(shape);
        if is_light(world, shape, index) {
            continue;
        }
        let occluder = occluder(world, shape);
        if !sight.may_be_hidden_by(&occluder) {
            continue;
        }
        if world.is_pane(object) {
            let from = (emitter, point);
            space
                .panes_before
                .add(world, [object, triangle], occluder, from);
        } else {
            space.occluders.push(occluder);
        }
    }
    if space.occluders.is_empty() && space.panes_before.is_empty() {
        return received.irradiance * light.over_area();
    }
    let AreaSpace {
        occluders,
        panes_before,
        shadow,
        ..
    } = &mut *space;
    let (from, accuracy) = ((point, rounding), &ACCURACY_FOR_ERROR);
    let past = panes_before.received(emitter, from, &receiver, occluders, accuracy, shadow);
    let irradiance = past.received.map_or(0.0, |seen| seen.irradiance);
    let [passed, _] = if irradiance > 0.0 && past.is_undimmed {
        let start = RayStart {
            t: 0.0,
            position: point.0,
            error: rounding,
            primitive: u64::MAX,
        };
        let (scene, panes) = ((world, visibility), &mut space.panes);
        through_panes(simd, scene, light, &start, &receiver, panes, tracing)
    } else {
        [1.0; 2]
    };
    irradiance * passed * light.over_area()
}
