//! Illuminance at points of a plane that is none of the scene's: what a lux meter says there (L3 and L4, with the
//! cosine of L5).

use fearless_simd::Simd;

use crate::math::{DVec3, Direction, Normal, Point};
use crate::memory::OutOfMemory;
use crate::shading::{AreaSpace, Crossing, Opaque, PaneSpace, area_illuminance};
use crate::simd::{Kernel, LANES, SimdLevel};
use crate::visibility::{
    BATCH, IncoherentSegments, RayStart, SegmentBatch, Visibility, Workspace, vector,
};
use crate::world::{Plan, World};

/// Direct illuminance in lux at points of a surface with the unit normal n:
///
/// E = Σ_lights I f / d² · max(0, n·ω_i) · V
///
/// of a sun E_s · max(0, n·ω_i) · V, of a light with an area L ∫ max(0, n·ω_i) V dω. Points are where the scene has them. A light at the very point adds nothing. What
/// reflects between surfaces is no part of it.
///
/// # Errors
/// If there is not as much memory as the trees over the shapes take.
pub fn illuminance(
    world: &World,
    points: &[[f64; 3]],
    normal: [f64; 3],
) -> Result<Vec<f64>, OutOfMemory> {
    let visibility = Visibility::try_new(world, &Plan::new(world))?;
    Ok(SimdLevel::default().run(Meter {
        world,
        visibility: &visibility,
        points,
        normal: DVec3::from_array(normal).normalize_or_zero(),
    }))
}

/// A lux meter, on whatever instructions.
struct Meter<'w> {
    world: &'w World,
    visibility: &'w Visibility<'w>,
    points: &'w [[f64; 3]],
    normal: DVec3,
}

impl Kernel for Meter<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Vec<f64> {
        let Self {
            world,
            visibility,
            points,
            normal,
        } = self;
        let mut space = Workspace::default();
        let mut area_space = AreaSpace::default();
        let mut panes = PaneSpace::default();
        let mut segments = Box::<IncoherentSegments>::default();
        let mut sums = vec![0.0; points.len()];
        for (light, entry) in world.lights().iter().enumerate() {
            let candela = world.candelas(light);
            if let Some(area) = entry.value.area() {
                let Some(normal) = Normal::new(normal) else {
                    continue;
                };
                for (sum, &point) in sums.iter_mut().zip(points) {
                    let (point, rounding) = place(world, point);
                    let per_candela = area_illuminance(
                        simd,
                        (world, visibility),
                        (light, area),
                        (Point(point), normal),
                        rounding,
                        &mut area_space,
                        &mut space,
                    );
                    *sum += per_candela * candela;
                }
                continue;
            }
            let end = entry.value.position();
            for (first, batch) in (0..).step_by(BATCH).zip(points.chunks(BATCH)) {
                let mut arriving = [0.0; BATCH];
                let mut asked = [0; BATCH];
                segments.count = 0;
                for (index, &point) in batch.iter().enumerate() {
                    let (point, rounding) = place(world, point);
                    let arrives = entry.value.illuminance(Point(point), normal) * candela;
                    if arrives == 0.0 {
                        continue;
                    }
                    let segment = segments.count;
                    arriving[segment] = arrives;
                    asked[segment] = first + index;
                    segments.start.set(segment, point, rounding, u64::MAX);
                    segments.end.set(segment, end.0, 0.0, u64::MAX);
                    segments.count += 1;
                }
                let free = visibility.free(simd, SegmentBatch::Any(&segments), &mut space);
                let is_free = |segment: usize| free[segment / LANES] >> (segment % LANES) & 1 == 1;
                let to_light = entry.value.direction();
                panes.crossings.clear();
                for segment in 0..segments.count {
                    if is_free(segment) {
                        sums[asked[segment]] += arriving[segment];
                    } else if world.has_panes() {
                        panes.crossings.push(crossing(&segments, segment, to_light));
                    }
                }
                panes.cross(simd, world, visibility, Opaque::Hides, &mut space);
                let hidden = (0..segments.count).filter(|&segment| !is_free(segment));
                for (segment, crossing) in hidden.zip(&panes.crossings) {
                    sums[asked[segment]] += arriving[segment] * crossing.passed;
                }
            }
        }
        sums
    }
}

/// A segment to a light, as panes ask it.
fn crossing(
    segments: &IncoherentSegments,
    segment: usize,
    to_light: Option<Direction>,
) -> Crossing {
    let position = vector(&segments.start.position, segment);
    let start = RayStart {
        t: 0.0,
        position,
        error: segments.start.error[segment],
        primitive: u64::MAX,
    };
    match to_light {
        Some(to_light) => Crossing::new(start, to_light.get(), f64::INFINITY),
        None => Crossing::new(
            start,
            vector(&segments.end.position, segment) - position,
            1.0,
        ),
    }
}

/// Where a point is in a world, and how far that may be off: a point of a table top is on it, as far as its
/// coordinates tell.
fn place(world: &World, point: [f64; 3]) -> (DVec3, f64) {
    let point = DVec3::from_array(point) - world.anchor();
    let rounding = ROUNDING * (point.abs() + world.anchor().abs()).max_element();
    (point, rounding)
}

/// What coordinates as written may be off, relative to them: some roundings of an f64.
const ROUNDING: f64 = 16.0 * f64::EPSILON;
