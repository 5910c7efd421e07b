//! What a whole shaft of rays meets: nothing, one shape before all others, or some of a list of shapes.
//!
//! A shaft is all rays through a window of the image, or all segments from a box of points to a light's point
//! or box. It is the convex hull of its corners, cut out by half-spaces (for boxes the planes that bridge them,
//! Haines & Wallace 1994, "Shaft Culling for Efficient Ray-Cast Radiosity"). A shape that is on the outer side of
//! one of them is met by no ray; all others are listed, in the order of the scene. Nothing is sampled: the
//! answers hold for every ray of the shaft, and for those that f64 computes of them, which are within
//! [`MARGIN`](solid::MARGIN) of it.
//!
//! That all rays meet one shape is told from the corners alone, since the rays through a convex set are a
//! convex set (see [`Solid::enters`]). That they meet it first is told of every other shape by one of these:
//! - it is deeper, along the middle of the shaft, than the shape is ever met. From one point, or by parallel
//!   rays, that is at a corner: seen from there the reciprocal depth at which rays enter a convex set is a
//!   concave function of the window (projective maps keep sets convex), and for parallel rays the depth a convex
//!   one;
//! - it is all beyond the plane of the shape, or it is flat and the shape is all before its plane;
//! - it is flat, and its plane is met later at each corner: its reciprocal depth is affine in the window, and
//!   an affine function less a concave one is largest at a corner.

mod solid;

use fearless_simd::Simd;

use super::Visibility;
use super::primitive::Primitive;
use super::shapes::Shapes;
use super::tree::{Bounds, EMPTY_STACK, HalfSpace, MOST_SIDES, Stack};
use crate::math::DVec3;
use crate::world::{Shape, World};
use solid::{Common, Cone, CornerRay, Solid};

/// How far a depth along the middle of a shaft is off, over the largest coordinates: it is a scalar product, and each
/// of its three terms is off by [`MARGIN`](solid::MARGIN).
const DEPTH_MARGIN: f64 = solid::MARGIN * 3.0;

/// The corners of a box and a point.
const MOST_CORNERS: usize = 64;

/// All rays of a kind.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Shaft {
    /// Rays from `eye` between four directions whose depth along `forward`, a unit vector, is 1: in turn around
    /// the window. From the first to the second depth, which may be infinite.
    Perspective {
        eye: DVec3,
        directions: [DVec3; 4],
        forward: DVec3,
        depths: [f64; 2],
    },
    /// Rays along `forward`, a unit vector, from between four starts in a plane across it, in turn around the
    /// window. From the first to the second depth, which may be infinite.
    Orthographic {
        starts: [DVec3; 4],
        forward: DVec3,
        depths: [f64; 2],
    },
    /// Segments from all points of a box, by its least and its largest coordinates, to one point.
    ToPoint { from: [DVec3; 2], to: DVec3 },
    /// Segments from all points of a box to all points of another one.
    ToBox { from: [DVec3; 2], to: [DVec3; 2] },
}

/// What is asked of a shaft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ShaftQuestion {
    /// What is in it: the list is of all shapes.
    Contents,
    /// What is met first in it: shapes that are certainly behind one that all rays meet may be left out.
    FirstHit,
    /// What stands in it: one shape that all rays meet will do, whatever is before it.
    Blockage,
}

/// What a shaft meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ShaftAnswer {
    /// No ray meets anything.
    Nothing,
    /// All rays meet this shape: first, or if that was asked for, among others.
    All(u64),
    /// No shape but those of the list is met, and it is not known by which rays.
    These,
    /// There are more than were asked for.
    TooMany,
}

/// What a thread needs for shafts, to be used again and again.
#[derive(Debug)]
pub(crate) struct ShaftSpace {
    hull: Box<Hull>,
    stack: Box<Stack>,
    met: Vec<Met>,
    /// The shapes of the last answer, in the order of the scene.
    pub(crate) list: Vec<u64>,
}

/// A shape that may be in a shaft.
#[derive(Clone, Copy, Debug)]
struct Met {
    primitive: Primitive,
    solid: Solid,
    /// How deep it begins, at least.
    nearest: f64,
    /// How deep all rays have entered it, if they all do.
    cover: Option<f64>,
}

/// A shaft's corners and borders.
#[derive(Clone, Debug)]
struct Hull {
    corners: [CornerRay; MOST_CORNERS],
    count: usize,
    half_spaces: [HalfSpace; MOST_SIDES],
    sides: usize,
    /// The middle, a unit vector.
    along: DVec3,
    kind: Kind,
    /// What all rays have in common.
    common: Common,
    /// Whether what is met is met from the starts of its rays on.
    is_from_start: bool,
    /// A cone around all rays from or to a point.
    cone: Option<Cone>,
    /// The largest coordinate of all corners.
    size: f64,
}

/// Whether depths at corners say all.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Rays from here: reciprocal depths do.
    Point(DVec3),
    /// Rays along `along`: depths do.
    Parallel,
    /// They do not.
    Boxes,
}

impl Default for ShaftSpace {
    fn default() -> Self {
        Self {
            hull: Box::new(Hull::EMPTY),
            stack: Box::new(EMPTY_STACK),
            met: Vec::new(),
            list: Vec::new(),
        }
    }
}

impl Hull {
    const EMPTY: Self = Self {
        corners: [CornerRay {
            start: DVec3::ZERO,
            way: DVec3::ZERO,
            is_endless: false,
        }; MOST_CORNERS],
        count: 0,
        half_spaces: [HalfSpace {
            normal: DVec3::ZERO,
            offset: 0.0,
        }; MOST_SIDES],
        sides: 0,
        along: DVec3::Z,
        kind: Kind::Boxes,
        common: Common::Nothing,
        is_from_start: false,
        cone: None,
        size: 0.0,
    };

    /// Becomes the hull of a shaft.
    fn set(&mut self, shaft: &Shaft) {
        let hull = self;
        (hull.count, hull.sides) = (0, 0);
        (hull.along, hull.kind) = (DVec3::Z, Kind::Boxes);
        (hull.common, hull.cone) = (Common::Nothing, None);
        hull.is_from_start = false;
        match *shaft {
            Shaft::Perspective {
                eye,
                directions,
                forward,
                depths: [near, far],
            } => {
                let starts = directions.map(|direction| eye + direction * near);
                (hull.along, hull.kind) = (forward, Kind::Point(eye));
                hull.common = Common::Point(eye);
                hull.is_from_start = near == 0.0;
                hull.add_window(starts, directions, far - near);
                hull.add_sides(eye, directions);
                hull.add_depths(eye.dot(forward), [near, far]);
            }
            Shaft::Orthographic {
                starts,
                forward,
                depths: [near, far],
            } => {
                let [a, b, _, d] = starts;
                (hull.along, hull.kind) = (forward, Kind::Parallel);
                hull.common = Common::Direction(forward);
                hull.is_from_start = near == 0.0;
                let at_near = starts.map(|start| start + forward * near);
                hull.add_window(at_near, [forward; 4], far - near);
                let (across, down) = (b - a, d - a);
                for (point, normal) in [(a, across), (b, -across), (a, down), (d, -down)] {
                    hull.add_side(point, normal);
                }
                hull.add_depths(a.dot(forward), [near, far]);
            }
            Shaft::ToPoint { from, to } => {
                hull.common = Common::Point(to);
                hull.add_boxes(from, [to, to]);
            }
            Shaft::ToBox { from, to } => hull.add_boxes(from, to),
        }
        let corners = &hull.corners[..hull.count];
        hull.size = corners.iter().fold(0.0, |size, corner| {
            let end = if corner.is_endless {
                corner.start
            } else {
                corner.start + corner.way
            };
            f64::max(size, corner.start.abs().max(end.abs()).max_element())
        });
        if let Common::Point(point) = hull.common {
            hull.size = hull.size.max(point.abs().max_element());
            hull.cone = Cone::around(point, hull.corners());
        }
    }

    fn add_window(&mut self, starts: [DVec3; 4], directions: [DVec3; 4], length: f64) {
        for (start, direction) in starts.into_iter().zip(directions) {
            let is_endless = length == f64::INFINITY;
            let way = if is_endless {
                direction
            } else {
                direction * length
            };
            self.add_corner(CornerRay {
                start,
                way,
                is_endless,
            });
        }
    }

    fn add_corner(&mut self, corner: CornerRay) {
        self.corners[self.count] = corner;
        self.count += 1;
    }

    /// Planes through the eye and neighboring directions; the others are inside.
    fn add_sides(&mut self, eye: DVec3, directions: [DVec3; 4]) {
        let middle: DVec3 = directions.iter().sum();
        for side in 0..4 {
            let normal = directions[side].cross(directions[(side + 1) % 4]);
            let normal = if normal.dot(middle) < 0.0 {
                -normal
            } else {
                normal
            };
            self.add_side(eye, normal);
        }
    }

    /// What is beyond a plane through `point`. A normal without a length says nothing.
    fn add_side(&mut self, point: DVec3, normal: DVec3) {
        let Some(normal) = normal.try_normalize() else {
            return;
        };
        self.half_spaces[self.sides] = HalfSpace {
            normal,
            offset: normal.dot(point),
        };
        self.sides += 1;
    }

    /// What is between two depths from `start` along the middle.
    fn add_depths(&mut self, start: f64, [near, far]: [f64; 2]) {
        let mut add = |normal: DVec3, offset: f64| {
            self.half_spaces[self.sides] = HalfSpace { normal, offset };
            self.sides += 1;
        };
        add(self.along, start + near);
        if far < f64::INFINITY {
            add(-self.along, -(start + far));
        }
    }

    /// The hull of two boxes: the box around both, and in each coordinate plane the lines that bridge them.
    fn add_boxes(&mut self, from: [DVec3; 2], to: [DVec3; 2]) {
        let bounds = |[min, max]: [DVec3; 2]| Bounds { min, max };
        let (from_box, to_box) = (bounds(from), bounds(to));
        let ends = to_box.corners();
        let ends = if to[0] == to[1] {
            &ends[..1]
        } else {
            &ends[..]
        };
        for start in from_box.corners() {
            for &end in ends {
                self.add_corner(CornerRay {
                    start,
                    way: end - start,
                    is_endless: false,
                });
            }
        }
        let middle = (to[0] * 0.5 + to[1] * 0.5) - (from[0] * 0.5 + from[1] * 0.5);
        self.along = middle.normalize_or(DVec3::Z);
        let all = from_box.union(to_box);
        for axis in 0..3 {
            for (normal, offset) in [
                (DVec3::AXES[axis], all.min[axis]),
                (-DVec3::AXES[axis], -all.max[axis]),
            ] {
                self.half_spaces[self.sides] = HalfSpace { normal, offset };
                self.sides += 1;
            }
        }
        for axis in 0..3 {
            self.add_bridges(axis, from, to);
        }
    }

    /// Seen along an axis the boxes are rectangles. A line through the corners of both on the same sides, with
    /// all others on one side of it, bridges them. There are two at most.
    fn add_bridges(&mut self, axis: usize, from: [DVec3; 2], to: [DVec3; 2]) {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        for corner in 0..4 {
            let pick = |bounds: [DVec3; 2]| [bounds[corner & 1][u], bounds[corner >> 1][v]];
            let ([a_u, a_v], [b_u, b_v]) = (pick(from), pick(to));
            let mut normal = DVec3::ZERO;
            normal[u] = -(b_v - a_v);
            normal[v] = b_u - a_u;
            // Outwards is where this corner is of both boxes.
            let outwards_u = if corner & 1 == 1 { 1.0 } else { -1.0 };
            let outwards_v = if corner >> 1 == 1 { 1.0 } else { -1.0 };
            let inwards =
                |normal: DVec3| normal[u] * outwards_u <= 0.0 && normal[v] * outwards_v <= 0.0;
            if normal == DVec3::ZERO {
                continue;
            }
            if !inwards(normal) {
                normal = -normal;
            }
            if inwards(normal) {
                let mut point = DVec3::ZERO;
                (point[u], point[v]) = (a_u, a_v);
                // Both corners are on it; rounding of the normal moves one of them.
                let mut other = DVec3::ZERO;
                (other[u], other[v]) = (b_u, b_v);
                let further = if normal.dot(other) < normal.dot(point) {
                    other
                } else {
                    point
                };
                if self.sides < MOST_SIDES {
                    self.add_side(further, normal);
                }
            }
        }
    }

    fn corners(&self) -> &[CornerRay] {
        &self.corners[..self.count]
    }

    fn half_spaces(&self) -> &[HalfSpace] {
        &self.half_spaces[..self.sides]
    }

    /// How deep all rays have entered a shape at most, if it is certain that they all do.
    fn cover(&self, solid: &Solid) -> Option<f64> {
        if self.is_from_start && solid.is_around(self.corners()) {
            return Some(solid.farthest(self.along));
        }
        let mut deepest = f64::NEG_INFINITY;
        for corner in self.corners() {
            let at = solid.enters(corner)?;
            deepest = deepest.max(self.along.dot(corner.start + corner.way * at));
        }
        match self.kind {
            Kind::Point(_) | Kind::Parallel => {
                Some(deepest + (self.size + deepest.abs()) * DEPTH_MARGIN)
            }
            Kind::Boxes => Some(solid.farthest(self.along)),
        }
    }

    /// Whether a shape that all rays meet is met before another one by all of them.
    fn is_before(&self, front: &Met, back: &Met) -> bool {
        front.cover.is_some_and(|cover| back.nearest > cover)
            || front.solid.is_before(&back.solid, self.corners())
            || back.solid.is_beyond(&front.solid, self.corners())
            || self.is_before_at_corners(&front.solid, &back.solid)
    }

    fn is_before_at_corners(&self, front: &Solid, back: &Solid) -> bool {
        self.corners().iter().all(|corner| {
            let Some(at) = front.enters(corner) else {
                return false;
            };
            match self.kind {
                Kind::Boxes => false,
                Kind::Parallel => {
                    let crosses = back.crosses(corner.start, corner.way);
                    crosses.is_some_and(|crosses| crosses > at)
                }
                Kind::Point(eye) => {
                    // From the eye, to where the front is entered.
                    let way = corner.start + corner.way * at - eye;
                    let crosses = back.crosses(eye, way);
                    crosses.is_some_and(|crosses| !(0.0..=1.0).contains(&crosses))
                }
            }
        })
    }
}

impl Visibility<'_> {
    /// What a shaft meets; the shapes that it may meet are in the list of `space` then, if there are `most` or
    /// fewer. `except` is a shape that is left out, `u64::MAX` for none: what the ends of segments are on, if that
    /// is flat.
    #[inline(never)]
    pub(crate) fn shaft<S: Simd>(
        &self,
        simd: S,
        shaft: &Shaft,
        question: ShaftQuestion,
        except: u64,
        most: usize,
        space: &mut ShaftSpace,
    ) -> ShaftAnswer {
        simd.vectorize(
            #[inline(always)]
            || {
                space.hull.set(shaft);
                let mut search = ShaftSearch {
                    hull: &space.hull,
                    question,
                    except: Primitive(except),
                    most,
                    met: std::mem::take(&mut space.met),
                    limit: f64::INFINITY,
                    ended: None,
                };
                search.met.clear();
                search.run(simd, &self.shapes, &mut space.stack);
                let answer = search.answer(&mut space.list);
                space.met = search.met;
                answer
            },
        )
    }
}

impl Visibility<'_> {
    /// The same, of some shapes alone, such as those that a shaft around this one may meet.
    pub(crate) fn shaft_among(
        &self,
        shaft: &Shaft,
        question: ShaftQuestion,
        except: u64,
        shapes: &[u64],
        space: &mut ShaftSpace,
    ) -> ShaftAnswer {
        space.hull.set(shaft);
        let mut search = ShaftSearch {
            hull: &space.hull,
            question,
            except: Primitive(except),
            most: usize::MAX,
            met: std::mem::take(&mut space.met),
            limit: f64::INFINITY,
            ended: None,
        };
        search.met.clear();
        for &shape in shapes {
            search.offer(
                Primitive(shape),
                solid_of(self.shapes.world, Primitive(shape)),
            );
        }
        let answer = search.answer(&mut space.list);
        space.met = search.met;
        answer
    }
}

fn solid_of(world: &World, primitive: Primitive) -> Solid {
    let (object, triangle) = primitive.parts();
    match world.objects()[object as usize].shape {
        Shape::Sphere(index) => {
            let sphere = &world.spheres()[index];
            Solid::Sphere {
                center: sphere.center.0,
                radius: sphere.radius,
            }
        }
        Shape::Plane(index) => {
            let plane = &world.planes()[index];
            Solid::Plane {
                point: plane.point.0,
                normal: plane.normal.get(),
            }
        }
        Shape::Disk(index) => Solid::of_disk(&world.disks()[index]),
        Shape::Mesh(_) => Solid::Triangle(world.triangles().vertices(triangle)),
    }
}

/// A shaft on its way through the shapes.
struct ShaftSearch<'h> {
    hull: &'h Hull,
    question: ShaftQuestion,
    except: Primitive,
    most: usize,
    met: Vec<Met>,
    /// What begins deeper than this is of no interest.
    limit: f64,
    /// An answer that nothing more can change.
    ended: Option<ShaftAnswer>,
}

impl ShaftSearch<'_> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S, shapes: &Shapes<'_>, stack: &mut Stack) {
        for plane in shapes.world.planes() {
            let (point, normal) = (plane.point.0, plane.normal.get());
            self.offer(
                Primitive::whole(plane.object),
                Solid::Plane { point, normal },
            );
        }
        for disk in shapes.world.disks() {
            self.offer(Primitive::whole(disk.object), Solid::of_disk(disk));
        }
        let hull = self.hull;
        let (half_spaces, along) = (hull.half_spaces(), hull.along);
        let error = hull.size * DEPTH_MARGIN;
        shapes.spheres.within(
            simd,
            half_spaces,
            along,
            error,
            self.limit,
            stack,
            #[inline(always)]
            |sphere| {
                let (center, radius) = sphere.center_and_radius();
                self.offer(sphere.primitive(), Solid::Sphere { center, radius });
                self.next()
            },
        );
        if self.ended.is_some() {
            return;
        }
        shapes.triangles.within(
            simd,
            half_spaces,
            along,
            error,
            self.limit,
            stack,
            #[inline(always)]
            |triangle| {
                self.offer(triangle.primitive(), Solid::Triangle(triangle.vertices()));
                self.next()
            },
        );
    }

    /// How deep to go from now on, if at all.
    fn next(&self) -> Option<f64> {
        self.ended.is_none().then_some(self.limit)
    }

    /// Takes note of a shape if it may be in the shaft.
    #[inline(never)]
    fn offer(&mut self, primitive: Primitive, solid: Solid) {
        let hull = self.hull;
        if primitive == self.except
            || self.ended.is_some()
            || hull
                .cone
                .is_some_and(|cone| solid.is_outside(&cone, hull.size))
            || solid.is_beside(hull.half_spaces(), hull.corners(), hull.size)
            || solid.is_passed(hull.common, hull.corners(), hull.size)
        {
            return;
        }
        let nearest = solid.nearest(hull.along);
        if nearest > self.limit {
            return;
        }
        let cover = hull.cover(&solid);
        self.met.push(Met {
            primitive,
            solid,
            nearest,
            cover,
        });
        if let Some(cover) = cover {
            match self.question {
                ShaftQuestion::Contents => {}
                ShaftQuestion::FirstHit => self.limit = self.limit.min(cover),
                ShaftQuestion::Blockage => self.ended = Some(ShaftAnswer::All(primitive.0)),
            }
        }
        if self.met.len() > self.most {
            let limit = self.limit;
            self.met.retain(|met| met.nearest <= limit);
            if self.met.len() > self.most {
                self.ended.get_or_insert(ShaftAnswer::TooMany);
            }
        }
    }

    fn answer(&mut self, list: &mut Vec<u64>) -> ShaftAnswer {
        list.clear();
        if let Some(answer) = self.ended {
            return answer;
        }
        let limit = self.limit;
        self.met.retain(|met| met.nearest <= limit);
        self.met.sort_unstable_by_key(|met| met.primitive);
        list.extend(self.met.iter().map(|met| met.primitive.0));
        let first = self.met.iter().find(|front| {
            let mut others = self.met.iter();
            front.cover.is_some()
                && others.all(|back| {
                    back.primitive == front.primitive || self.hull.is_before(front, back)
                })
        });
        match first {
            Some(first) => ShaftAnswer::All(first.primitive.0),
            None if self.met.is_empty() => ShaftAnswer::Nothing,
            None => ShaftAnswer::These,
        }
    }
}
