//! Rays that leave flat surfaces, mirrored or straight on, against the same rays one by one.

use super::*;
use crate::world::Shape;

/// The rays that leave a batch's points on flat shapes: by a mirror those of the shape that is hit first, or all
/// straight on.
fn leaving(
    world: &World,
    points: &Points,
    before: &IncoherentRays,
    is_mirrored: bool,
) -> IncoherentRays {
    let mut rays = IncoherentRays::default();
    let mut only = None;
    for slot in (0..BATCH).filter(|&slot| points.is_hit(slot)) {
        let shape = world.objects()[points.object(slot) as usize].shape;
        let normal = vector(points.geometric_normals(), slot);
        let is_curved =
            matches!(shape, Shape::Sphere(_)) || vector(points.shading_normals(), slot) != normal;
        let primitive = points.primitive[slot];
        if is_curved || is_mirrored && *only.get_or_insert(primitive) != primitive {
            continue;
        }
        let [origin, direction] = before.ray(slot);
        let position = vector(&points.position, slot);
        let start = RayStart {
            t: (position - origin).dot(direction) / direction.length_squared(),
            position,
            error: points.error[slot],
            primitive,
        };
        if is_mirrored {
            let image = origin - normal * (2.0 * (normal.dot(origin) - points.plane(slot)));
            let mirrored = direction - normal * (2.0 * normal.dot(direction));
            rays.push_from(image, mirrored, &start);
        } else {
            rays.push_from(origin, direction, &start);
        }
    }
    rays
}

/// Asserts that rays which leave the points of a batch meet the same with a projection and without; how many the
/// projection told of how many.
#[inline(always)]
pub(super) fn compare<S: Simd>(
    simd: S,
    world: &World,
    ways: [&Visibility<'_>; 2],
    points: &Points,
    before: &IncoherentRays,
    space: &mut Workspace,
) -> [u32; 2] {
    let mut told = [0; 2];
    for is_mirrored in [false, true] {
        let rays = leaving(world, points, before, is_mirrored);
        if rays.count() == 0 {
            continue;
        }
        let batch: RayBatch<'_, fn(usize) -> DVec3x16<S>> = RayBatch::Any(&rays);
        let mut met: [Points; 2] = Default::default();
        for (way, met) in ways.into_iter().zip(&mut met) {
            way.nearest(simd, &batch, space, met);
            if way.uses_projection && rays.eye().is_some() && rays.count() >= 8 {
                told[1] += rays.count() as u32;
                if space.projection.state == State::Projected {
                    let open = (0..PACKETS).map(|packet| {
                        let asked = batch::first_lanes(rays.count(), packet);
                        (space.projection.falls_back(packet) & asked).count_ones()
                    });
                    told[0] += rays.count() as u32 - open.sum::<u32>();
                }
            }
        }
        let [seen, expected] = &met;
        assert_eq!(seen.hit, expected.hit, "{is_mirrored}");
        for slot in (0..rays.count()).filter(|&slot| expected.is_hit(slot)) {
            assert_eq!(seen.primitive[slot], expected.primitive[slot]);
            let bits = |points: &Points| {
                let columns = [&points.position, points.shading_normals()];
                columns.map(|vector| vector.each_ref().map(|column| column[slot].to_bits()))
            };
            assert_eq!(bits(seen), bits(expected), "{:?}", seen.primitive[slot]);
        }
    }
    told
}

/// Mirrors amid spheres before them, behind them and through them: the projection tells most of it.
#[test]
fn what_mirrors_show_is_told_by_the_projection() {
    let mut scene = Writer::new(1.0, [0.0; 3], 40.0, EYE);
    scene.clutter(0, 60, 0.2);
    scene.triangle([[-1.5, -1.5, -0.2], [1.5, -1.5, -0.2], [0.0, 2.0, -0.4]]);
    scene.plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
    scene.lights();
    let told = |compare: Compare<'_>| SimdLevel::default().run(Told(compare));
    let [told, asked] = scene.with_ways(&scene.cameras[0], told);
    assert!(asked > 1000, "{asked}");
    assert!(told * 10 > asked * 9, "{told} of {asked}");
}

/// How many rays that leave surfaces the projection tells of how many.
struct Told<'w>(Compare<'w>);

impl Kernel for Told<'_> {
    type Output = [u32; 2];

    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let Compare {
            world,
            camera,
            ways,
        } = self.0;
        let mut all = [0; 2];
        let mut space = Workspace::default();
        let mut points = Points::default();
        for tile in 0..12_u32 {
            let mut rays = IncoherentRays::default();
            for slot in 0..BATCH as u32 {
                let (x, y) = (slot % 16 + tile % 4 * 16, slot / 16 + tile / 4 * 16);
                let ray = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
                rays.push(ray.origin.0, ray.direction);
            }
            let batch: RayBatch<'_, fn(usize) -> DVec3x16<S>> = RayBatch::Any(&rays);
            ways[1].nearest(simd, &batch, &mut space, &mut points);
            let [told, asked] = compare(simd, world, ways, &points, &rays, &mut space);
            all = [all[0] + told, all[1] + asked];
        }
        all
    }
}
