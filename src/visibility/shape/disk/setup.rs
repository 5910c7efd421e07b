//! Disks on a [`BatchProjection`]: their reciprocal depth is that of their plane, their rim a conic.

use fearless_simd::Simd;

use crate::math::{DVec3, all_three, both};
use crate::simd::{F32x16, ones};
use crate::visibility::primitive::{DISKS, Primitive, ShapeId};
use crate::visibility::projection::{
    Affine, BatchProjection, DepthTest, Extent, Fragments, NEGLIGIBLE, NOISE, POLYNOMIAL_ERROR,
    RECIPROCAL_DEPTH_LIMIT, Shared, Start, State,
};
use crate::visibility::rays::ROUNDING;
use crate::world::Disk;

/// Distances and radii within this part of the unit and its reciprocal are told from f32: products of four of
/// them are far from the ends of f64, their reciprocals from those of f32.
const LENGTH_LIMIT: f64 = 1e30;

/// Where a ray meets the plane is off by some roundings of 2⁻⁵³ of the distance d, over the cosine: f64 decides
/// what is within the rim to 2⁻⁴⁷ (R + d)/cos, or better. That is less than half of the bound on the error in f32,
/// which is [`POLYNOMIAL_ERROR`] of R at least, as long as (R + d)/cos is below so many radii.
const SHARPEST: f64 = (1_u64 << 22) as f64;

/// The bound on the error of the discriminant, over the sum of the magnitudes of its terms: what f32 and f64 are off.
const RIM_ERROR: f32 = 2.0 * POLYNOMIAL_ERROR;

/// The center and the radius in the axes of a projection, over its unit.
#[derive(Clone, Copy)]
struct Place {
    center: [f64; 3],
    normal: [f64; 3],
    radius: f64,
    /// How far the center is from where rays start, at least, as far as rounding is concerned.
    distance: f64,
}

/// What f32 knows of a disk.
struct Told {
    reciprocal_depth: Affine,
    /// How far that may be off.
    error: f32,
    /// Between which the reciprocal depth is, all over the samples.
    range: [f32; 2],
    /// Of 1, x, y, x², x y and y²: above 0 within the rim, over the sum of the magnitudes of its terms.
    inside: [f32; 6],
}

/// The planes around all rays of a projection, in its axes and units; no ray is beyond one of them.
struct Borders {
    normals: [[f64; 3]; 6],
    offsets: [f64; 6],
}

impl Borders {
    #[inline(always)]
    fn new(projection: &BatchProjection) -> Self {
        let [left, right, bottom, top] = projection.rectangle();
        match projection.shared {
            Shared::Point => {
                let deepest = 1.0 / f64::from(projection.farthest);
                let [l, r, b, t] = [side(left), side(right), side(bottom), side(top)];
                Self {
                    normals: [
                        [-l, 0.0, left * l],
                        [r, 0.0, -right * r],
                        [0.0, -b, bottom * b],
                        [0.0, t, -top * t],
                        [0.0, 0.0, 1.0],
                        [0.0, 0.0, -1.0],
                    ],
                    offsets: [
                        0.0,
                        0.0,
                        0.0,
                        0.0,
                        -deepest * (1.0 + f64::from(POLYNOMIAL_ERROR)),
                        0.0,
                    ],
                }
            }
            Shared::Direction(start) => Self {
                normals: [
                    [-1.0, 0.0, 0.0],
                    [1.0, 0.0, 0.0],
                    [0.0, -1.0, 0.0],
                    [0.0, 1.0, 0.0],
                    [0.0, 0.0, 1.0],
                    [0.0, 0.0, -1.0],
                ],
                offsets: [
                    left,
                    -right,
                    bottom,
                    -top,
                    f64::from(projection.farthest),
                    start.nearest() / projection.unit,
                ],
            },
        }
    }

    /// Whether a ball is beyond one of them.
    #[inline(always)]
    fn are_passed(&self, place: &Place) -> bool {
        let Place {
            center: [x, y, z],
            radius,
            distance,
            ..
        } = *place;
        let reach = radius + (distance + radius) * f64::from(POLYNOMIAL_ERROR);
        let mut are_passed = false;
        for (&[u, v, w], &offset) in self.normals.iter().zip(&self.offsets) {
            are_passed |= u * x + v * y + w * z + offset > reach;
        }
        are_passed
    }
}

/// Rasterizes disks, in the order of the world.
#[inline(never)]
pub(in crate::visibility) fn rasterize_disks<S: Simd>(
    simd: S,
    disks: &[Disk],
    projection: &mut BatchProjection,
    depth_test: impl DepthTest,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            if !is_open(projection) {
                return;
            }
            // Projections whose state changes later become narrower.
            projection.look(simd);
            let borders = Borders::new(projection);
            for (index, disk) in (0..).zip(disks) {
                let id = ShapeId {
                    slot: DISKS | index,
                    primitive: Primitive::whole(disk.object),
                };
                if depth_test.are_all_on(id) {
                    continue;
                }
                let place = Place::new(disk, projection);
                if !borders.are_passed(&place) && !is_beside(disk, projection) {
                    rasterize(simd, &place, id, projection, depth_test);
                }
                if !is_open(projection) {
                    return;
                }
            }
        },
    );
}

/// Whether a projection still has an interest in shapes.
#[inline(always)]
fn is_open(projection: &BatchProjection) -> bool {
    matches!(projection.state, State::Bounded | State::Projected)
}

/// Whether the plane of a disk is certainly not between where rays start and where they end.
#[inline(always)]
fn is_beside(disk: &Disk, projection: &BatchProjection) -> bool {
    let (center, normal) = (disk.center.0, disk.normal.get());
    if let Shared::Direction(_) = projection.shared {
        let [.., w] = projection.axes;
        // Exactly along the plane, f64 finds no way to it either.
        return w * normal == DVec3::ZERO;
    }
    if projection.is_beside(center, normal) {
        return true;
    }
    // A light that is on the plane as far as f64 can tell, such as a point of the disk itself. (Half as much, since
    // the sums here may be rounded in another way.)
    let to_light = projection.origin - center;
    let sizes = to_light.length() + projection.origin.length();
    projection.ends.is_some() && normal.dot(to_light).abs() <= 0.5 * ROUNDING * sizes
}

impl Place {
    #[inline(always)]
    fn new(disk: &Disk, projection: &BatchProjection) -> Self {
        let over_unit = 1.0 / projection.unit;
        let to_center = (disk.center.0 - projection.origin) * over_unit;
        let normal = disk.normal.get();
        let center = all_three(
            projection.axes,
            #[inline(always)]
            |axis| axis.dot(to_center),
        );
        let [x, y, z] = center;
        let from_start = match projection.shared {
            Shared::Point => 0.0,
            Shared::Direction(start) => start.distance * over_unit + 2.0,
        };
        Self {
            center,
            normal: all_three(
                projection.axes,
                #[inline(always)]
                |axis| axis.dot(normal),
            ),
            radius: disk.radius * over_unit,
            distance: x.abs() + y.abs() + z.abs() + from_start,
        }
    }

    /// Whether its size and distance are within what f32 can tell.
    #[inline(always)]
    fn fits(&self) -> bool {
        self.radius > 1.0 / LENGTH_LIMIT && self.distance + self.radius < LENGTH_LIMIT
    }

    /// The box of the ball around it on the projection, and how close that comes; anywhere where it reaches behind
    /// the point that rays start from.
    #[inline(always)]
    fn extent(&self, projection: &BatchProjection) -> Extent {
        let Self {
            center: [x, y, z],
            radius,
            distance,
            ..
        } = *self;
        let (give, noise) = (f64::from(POLYNOMIAL_ERROR), f64::from(NOISE));
        let [extent_x, extent_y] = projection.extent;
        if !self.fits() {
            return Extent::EVERYTHING;
        }
        match projection.shared {
            Shared::Point => {
                let (nearest, size) = (z - radius, z.abs() + radius);
                let is_before = nearest > size * give;
                if !is_before {
                    return Extent::EVERYTHING;
                }
                let noise = (x.abs() + y.abs() + size) / nearest * noise;
                Extent {
                    x: self.sides(x, extent_x, noise),
                    y: self.sides(y, extent_y, noise),
                    most: ((1.0 + give) / nearest) as f32,
                }
            }
            Shared::Direction(_) => {
                let noise = distance * noise;
                let room = (z.abs() + radius) * give + noise;
                Extent {
                    x: self.flat_sides(x, extent_x, noise),
                    y: self.flat_sides(y, extent_y, noise),
                    most: (radius - z + room) as f32,
                }
            }
        }
    }

    /// Where the planes through the origin and an axis touch the ball around it, which is before the origin.
    #[inline(always)]
    fn sides(&self, across: f64, extent: f64, noise: f64) -> [f32; 2] {
        let Self {
            center: [.., z],
            radius,
            ..
        } = *self;
        let width = (z - radius) * (z + radius);
        let root = radius * (across * across + width).sqrt();
        let (least, most) = ((across * z - root) / width, (across * z + root) / width);
        let room = (least.abs().max(most.abs()) + extent) * f64::from(POLYNOMIAL_ERROR) + noise;
        [(least - room) as f32, (most + room) as f32]
    }

    /// The same before parallel rays.
    #[inline(always)]
    fn flat_sides(&self, across: f64, extent: f64, noise: f64) -> [f32; 2] {
        let radius = self.radius;
        let room = (across.abs() + radius + extent) * f64::from(POLYNOMIAL_ERROR) + noise;
        let (least, most) = (across - radius - room, across + radius + room);
        [least as f32, most as f32]
    }

    /// What f32 knows of it; `None` if it cannot be told.
    #[inline(always)]
    fn told(&self, projection: &BatchProjection) -> Option<Told> {
        if !self.fits() {
            return None;
        }
        match projection.shared {
            Shared::Point => self.told_from_point(projection),
            Shared::Direction(start) => self.told_along(projection, start),
        }
    }

    /// With e = c − o, d = x u + y v + w and h = n·e, a ray meets the plane h d/(n·d) − e beside the center.
    /// That is m/(n·d), m = h d − (n·d) e being affine in x and y, and R² (n·d)² − |m|² tells what is
    /// within the rim. The reciprocal depth is n·d/h.
    #[inline(always)]
    fn told_from_point(&self, projection: &BatchProjection) -> Option<Told> {
        let Self {
            center,
            normal,
            radius,
            distance,
        } = *self;
        let height = dot(normal, center);
        let size = radius + distance;
        let error = projection.error / projection.unit;
        let is_sharp = size * size < SHARPEST * radius * height.abs();
        if !(is_sharp && height.abs() > error / NEGLIGIBLE) {
            return None;
        }
        let [nx, ny, nz] = normal;
        let scale = 1.0 / height;
        let depth = [nz * scale, nx * scale, ny * scale];
        let (a, b) = DVec3::from_array(normal).any_orthonormal_pair();
        let facing = [nz, nx, ny];
        Told::new(
            projection,
            depth,
            0.0,
            facing,
            radius,
            [
                self.beside_from_point(a, height),
                self.beside_from_point(b, height),
            ],
        )
    }

    /// The same with g = x u + y v − e: the plane is met at a depth of −n·g/(n·w), and m = (n·w) g − (n·g) w.
    #[inline(always)]
    fn told_along(&self, projection: &BatchProjection, start: Start) -> Option<Told> {
        let Self {
            center,
            normal,
            radius,
            distance,
        } = *self;
        let [nx, ny, nz] = normal;
        let is_sharp = radius + distance < SHARPEST * radius * nz.abs();
        if !(is_sharp && nz.abs() > NEGLIGIBLE) {
            return None;
        }
        let over_unit = 1.0 / projection.unit;
        let scale = 1.0 / nz;
        let height = dot(normal, center);
        let depth = [-height * scale, nx * scale, ny * scale];
        // As of planes.
        let [x, y, z] = center;
        let to_center = (x * x + y * y + z * z).sqrt();
        let distance = to_center + start.distance * over_unit + 2.0;
        let of_ends = 2.0 * projection.error * over_unit;
        let noise = (distance * f64::from(NOISE) + of_ends) * scale.abs();
        let (a, b) = DVec3::from_array(normal).any_orthonormal_pair();
        let facing = [nz, 0.0, 0.0];
        Told::new(
            projection,
            depth,
            noise,
            facing,
            radius,
            [self.beside_along(a, height), self.beside_along(b, height)],
        )
    }
}

impl Place {
    /// m along an axis of the plane, from a point.
    #[inline(always)]
    fn beside_from_point(&self, axis: DVec3, height: f64) -> [f64; 3] {
        let [nx, ny, nz] = self.normal;
        let beside = dot(axis.to_array(), self.center);
        [
            height * axis.z - beside * nz,
            height * axis.x - beside * nx,
            height * axis.y - beside * ny,
        ]
    }

    /// m along an axis of the plane, of parallel rays.
    #[inline(always)]
    fn beside_along(&self, axis: DVec3, height: f64) -> [f64; 3] {
        let [nx, ny, nz] = self.normal;
        [
            axis.z * height - nz * dot(axis.to_array(), self.center),
            nz * axis.x - axis.z * nx,
            nz * axis.y - axis.z * ny,
        ]
    }
}

impl Told {
    /// From functions of 1, x and y: the reciprocal depth, which may be off by `noise` besides; n·d; and both
    /// coordinates of m in the plane.
    #[inline(always)]
    fn new(
        projection: &BatchProjection,
        depth: [f64; 3],
        noise: f64,
        facing: [f64; 3],
        radius: f64,
        beside: [[f64; 3]; 2],
    ) -> Option<Self> {
        let [ex, ey] = projection.extent;
        let give = f64::from(POLYNOMIAL_ERROR);
        let magnitude = largest(depth, projection.extent);
        let error = magnitude * give + noise;
        let least = match projection.shared {
            Shared::Point => 1.0 / RECIPROCAL_DEPTH_LIMIT,
            Shared::Direction(_) => 0.0,
        };
        if !(magnitude >= least && magnitude + error < RECIPROCAL_DEPTH_LIMIT) {
            return None;
        }
        let [z, x, y] = depth;
        let sides = x.abs() * ex + y.abs() * ey + 2.0 * error;
        let reach = facing_times(facing, radius);
        let [a, b] = beside;
        let [all, of_a, of_b] = [
            largest(reach, projection.extent),
            largest(a, projection.extent),
            largest(b, projection.extent),
        ];
        let over = 1.0 / (all * all + of_a * of_a + of_b * of_b);
        let [reach, a, b] = [square(reach), square(a), square(b)];
        let mut inside = [0.0; 6];
        for (term, inside) in inside.iter_mut().enumerate() {
            *inside = ((reach[term] - a[term] - b[term]) * over) as f32;
        }
        over.is_finite().then_some(Self {
            reciprocal_depth: Affine([z as f32, x as f32, y as f32]),
            error: error as f32,
            range: [(z - sides) as f32, (z + sides) as f32],
            inside,
        })
    }

    /// Between which the discriminant is, all over the samples.
    #[inline(always)]
    fn inside_range(&self, projection: &BatchProjection) -> [f32; 2] {
        let [ex, ey] = both(
            projection.extent,
            #[inline(always)]
            |extent| extent as f32,
        );
        let [c, cx, cy, cxx, cxy, cyy] = self.inside;
        let sides = cx.abs() * ex + cy.abs() * ey + cxy.abs() * (ex * ey);
        [
            c - sides + cxx.min(0.0) * (ex * ex) + cyy.min(0.0) * (ey * ey),
            c + sides + cxx.max(0.0) * (ex * ex) + cyy.max(0.0) * (ey * ey),
        ]
    }
}

#[inline(always)]
fn dot([ax, ay, az]: [f64; 3], [bx, by, bz]: [f64; 3]) -> f64 {
    ax * bx + ay * by + az * bz
}

#[inline(always)]
fn facing_times([c, x, y]: [f64; 3], radius: f64) -> [f64; 3] {
    [c * radius, x * radius, y * radius]
}

/// At least the largest magnitude of a function of 1, x and y.
#[inline(always)]
fn largest([c, x, y]: [f64; 3], [ex, ey]: [f64; 2]) -> f64 {
    c.abs() + x.abs() * ex + y.abs() * ey
}

/// One over the length of (1, s).
#[inline(always)]
fn side(slope: f64) -> f64 {
    1.0 / (1.0 + slope * slope).sqrt()
}

/// The square of a function of 1, x and y, as one of 1, x, y, x², x y and y².
#[inline(always)]
fn square([c, x, y]: [f64; 3]) -> [f64; 6] {
    [c * c, 2.0 * c * x, 2.0 * c * y, x * x, 2.0 * x * y, y * y]
}

/// Rasterizes one disk.
#[inline(always)]
fn rasterize<S: Simd>(
    simd: S,
    place: &Place,
    id: ShapeId,
    projection: &mut BatchProjection,
    depth_test: impl DepthTest,
) {
    let extent = place.extent(projection);
    let told = place.told(projection);
    let (mut cover, mut most) = (None, extent.most);
    if let Some(told) = &told {
        let [least_inside, most_inside] = told.inside_range(projection);
        if most_inside < -2.0 * RIM_ERROR {
            return;
        }
        let [least, largest] = told.range;
        most = most.min(largest);
        let is_ahead = match projection.shared {
            Shared::Point => least > 0.0,
            Shared::Direction(_) => false,
        };
        cover = (least_inside > 2.0 * RIM_ERROR && is_ahead).then_some(told.range);
    }
    let is_behind = projection.state == State::Bounded && most < 0.0;
    let is_resolved = is_behind || depth_test.resolves_whole(projection, id, cover, most);
    if is_resolved || !depth_test.ensure_projected(simd, projection) {
        return;
    }
    let packets = projection.meets(simd, &extent);
    let Some(told) = told else {
        for packet in ones(packets) {
            depth_test.leave_unresolved(simd, projection, packet, id);
        }
        return;
    };
    let zero = F32x16::splat(simd, 0.0);
    let error = F32x16::splat(simd, told.error);
    let rim_error = F32x16::splat(simd, RIM_ERROR);
    let [c, cx, cy, cxx, cxy, cyy] = [
        F32x16::splat(simd, told.inside[0]),
        F32x16::splat(simd, told.inside[1]),
        F32x16::splat(simd, told.inside[2]),
        F32x16::splat(simd, told.inside[3]),
        F32x16::splat(simd, told.inside[4]),
        F32x16::splat(simd, told.inside[5]),
    ];
    for packet in ones(packets) {
        let [x, y] = projection.samples(simd, packet);
        let inside = x.times_plus(
            x.times_plus(cxx, y.times_plus(cxy, cx)),
            y.times_plus(y.times_plus(cyy, cy), c),
        );
        let may_cover = inside.ge(zero - rim_error);
        if may_cover.to_bits() == 0 {
            continue;
        }
        let reciprocal_depth = told.reciprocal_depth.at(simd, [x, y]);
        let may_cover = match projection.shared {
            // Behind the point a disk is of negative reciprocal depth.
            Shared::Point => may_cover & reciprocal_depth.ge(zero - error),
            Shared::Direction(_) => may_cover,
        };
        let fragments = Fragments {
            may_cover,
            covered: inside.gt(rim_error),
            least: reciprocal_depth - error,
            most: reciprocal_depth + error,
        };
        let fragments = projection.ahead(simd, fragments);
        depth_test.resolve(simd, projection, packet, id, fragments);
    }
}
