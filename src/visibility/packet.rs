//! Sixteen rays at a time: what they are, what they ask, and their way down a tree.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};

use super::Primitive;
use super::canvas::Canvas;
use super::nodes::{Entry, Node, Tree, WIDTH};
use super::search::Shape;
use super::triangle::{Shears, shears};
use crate::lanes::{Ids, LANES, Lanes, Mask, Vectors};
use crate::math::{DVec3, Point};

/// Rays r(t) = o + t ω, side by side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rays<S: Simd> {
    pub(super) origin: Vectors<S>,
    pub(super) direction: Vectors<S>,
    /// Where all start, if they start at one point.
    pub(super) shared_origin: Option<DVec3>,
    /// |ω|²
    pub(super) square: Lanes<S>,
}

/// Rays that are asked together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Packet<S: Simd> {
    pub(super) rays: Rays<S>,
    pub(super) shears: Shears<S>,
}

impl<S: Simd> Packet<S> {
    #[inline(always)]
    pub(super) fn new(rays: Rays<S>) -> Self {
        Self {
            rays,
            shears: shears(rays.direction),
        }
    }
}

impl<S: Simd> Rays<S> {
    /// Rays from one point.
    #[inline(always)]
    pub(super) fn from_point(simd: S, origin: Point, direction: Vectors<S>) -> Self {
        let origins = Vectors::splat(simd, origin.0);
        Self::new(origins, direction, Some(origin.0))
    }

    #[inline(always)]
    pub(super) fn new(
        origin: Vectors<S>,
        direction: Vectors<S>,
        shared_origin: Option<DVec3>,
    ) -> Self {
        Self {
            origin,
            direction,
            shared_origin,
            square: direction.dot(direction),
        }
    }
}

/// The nearest hits so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest<S: Simd> {
    /// The rays that ask.
    pub(super) asked: Mask<S>,
    pub(super) asked_bits: u32,
    /// t; infinite where nothing is hit.
    pub(super) t: Lanes<S>,
    pub(super) primitive: Ids<S>,
}

impl<S: Simd> Nearest<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, asked_bits: u32) -> Self {
        Self {
            asked: Mask::from_bits(simd, asked_bits),
            asked_bits,
            t: Lanes::splat(simd, f64::INFINITY),
            primitive: Ids::splat(simd, u64::MAX),
        }
    }

    /// Takes the hits that are nearer; at the same distance what is written first in the scene.
    #[inline(always)]
    pub(super) fn offer(&mut self, simd: S, found: Mask<S>, t: Lanes<S>, primitive: Primitive) {
        let primitive = primitive.lanes(simd);
        let ties = t.eq(self.t) & primitive.lt(self.primitive);
        let is_nearer = found & self.asked & (t.lt(self.t) | ties);
        self.t = is_nearer.select(t, self.t);
        self.primitive = is_nearer.select_ids(primitive, self.primitive);
    }
}

/// Points of surfaces that ask for a light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ends<S: Simd> {
    pub(super) position: Vectors<S>,
    pub(super) error: Lanes<S>,
    pub(super) primitive: Ids<S>,
}

/// Which points a light reaches, so far.
#[derive(Debug)]
pub(super) struct Shadow<'p, S: Simd> {
    pub(super) light: Point,
    pub(super) points: &'p Ends<S>,
    /// Those that nothing is known to hide.
    pub(super) asked: Mask<S>,
    pub(super) asked_bits: u32,
}

impl<S: Simd> Shadow<'_, S> {
    #[inline(always)]
    pub(super) fn hide(&mut self, hidden: Mask<S>) {
        self.asked = self.asked & !hidden;
        self.asked_bits = self.asked.to_bits();
    }
}

/// What a packet asks of the shapes in a tree.
pub(super) trait Question<S: Simd> {
    /// One bit for each ray that still asks.
    fn asked(&self) -> u32;

    /// The largest t that is of interest to any of them.
    fn limit(&self, simd: S) -> f64;

    /// Asks one shape.
    fn ask<T: Shape>(&mut self, simd: S, packet: &Packet<S>, shape: &T);

    /// Asks only for some of the rays from now on.
    fn only(&mut self, simd: S, bits: u32);
}

impl<S: Simd> Question<S> for Nearest<S> {
    #[inline(always)]
    fn asked(&self) -> u32 {
        self.asked_bits
    }

    #[inline(always)]
    fn limit(&self, simd: S) -> f64 {
        let zero = Lanes::splat(simd, 0.0);
        self.asked.select(self.t, zero).largest()
    }

    #[inline(always)]
    fn ask<T: Shape>(&mut self, simd: S, packet: &Packet<S>, shape: &T) {
        shape.intersect(simd, packet, self);
    }

    #[inline(always)]
    fn only(&mut self, simd: S, bits: u32) {
        self.asked_bits = bits;
        self.asked = Mask::from_bits(simd, bits);
    }
}

impl<S: Simd> Question<S> for Shadow<'_, S> {
    #[inline(always)]
    fn asked(&self) -> u32 {
        self.asked_bits
    }

    #[inline(always)]
    fn limit(&self, _: S) -> f64 {
        // A shadow ray ends at the point.
        1.0
    }

    #[inline(always)]
    fn ask<T: Shape>(&mut self, simd: S, packet: &Packet<S>, shape: &T) {
        shape.occlude(simd, packet, self);
    }

    #[inline(always)]
    fn only(&mut self, simd: S, bits: u32) {
        self.asked_bits = bits;
        self.asked = Mask::from_bits(simd, bits);
    }
}

/// How much farther the end of a ray in a box is taken to be: the slab test's roundings.
const SLAB_GIVES_WAY: f32 = 1.0 + 16.0 * f32::EPSILON;

/// A direction's component shorter than this, of about 1, counts as this: over the size of the
/// tree it moves no coordinate by more than a box gives way.
const SMALLEST_COMPONENT: f32 = 1e-18;

/// Farther from a tree than this, in its own size, no ray tells its boxes apart.
const FARTHEST: f64 = 1e30;

/// Rays whose directions differ by more than this part of their length do not share a shaft: at a
/// silhouette, points of the object and points far behind it would be enclosed in one.
const MOST_SPREAD: f64 = 1.0 / 64.0;

/// What some rays have in common in a tree's frame: for each axis a range of origins and of 1/ω.
#[derive(Clone, Copy, Debug)]
struct Shaft {
    /// For each axis: 0 if the rays enter a box by its lower plane, 1 if by its upper.
    enters_by: [usize; 3],
    /// What is subtracted from the lower planes and from the upper ones, with a margin.
    origins: [[f32; 2]; 3],
    inverse: [[f32; 2]; 3],
    /// Infinite for an axis along which the rays have no common direction, else 0.
    open: [f32; 3],
    /// A ray's t in the tree's frame over that in the world.
    stretch: f64,
}

/// The range of the numbers in some lanes.
#[inline(always)]
fn range<S: Simd>(simd: S, column: Lanes<S>, asked: Mask<S>) -> [f64; 2] {
    let infinite = Lanes::splat(simd, f64::INFINITY);
    [
        -asked.select(-column, -infinite).largest(),
        asked.select(column, -infinite).largest(),
    ]
}

/// How far apart some rays are.
struct Spread {
    origins: [[f64; 2]; 3],
    directions: [[f64; 2]; 3],
    /// One bit for each of those that should go without the others; 0 if all are alike.
    parted: u32,
}

impl Spread {
    /// Of the rays with a bit.
    #[inline(always)]
    fn of<S: Simd>(simd: S, rays: &Rays<S>, bits: u32) -> Self {
        let asked = Mask::from_bits(simd, bits);
        let d = rays.direction;
        let directions = [
            range(simd, d.x, asked),
            range(simd, d.y, asked),
            range(simd, d.z, asked),
        ];
        let origins = match rays.shared_origin {
            Some(origin) => origin.to_array().map(|o| [o, o]),
            None => [
                range(simd, rays.origin.x, asked),
                range(simd, rays.origin.y, asked),
                range(simd, rays.origin.z, asked),
            ],
        };
        let (mut widest, mut width, mut length) = (0, 0.0, 0.0);
        for (axis, [least, most]) in directions.into_iter().enumerate() {
            if most - least > width {
                (widest, width) = (axis, most - least);
            }
            length = f64::max(length, f64::max(most.abs(), least.abs()));
        }
        let mut parted = 0;
        if width > length * MOST_SPREAD {
            let [least, most] = directions[widest];
            let middle = Lanes::splat(simd, least * 0.5 + most * 0.5);
            let column = if widest == 0 {
                d.x
            } else if widest == 1 {
                d.y
            } else {
                d.z
            };
            parted = column.lt(middle).to_bits() & bits;
        }
        Self {
            origins,
            directions,
            // Neither part is empty, unless rounding makes it so.
            parted: if parted == bits { 0 } else { parted },
        }
    }
}

impl Shaft {
    #[inline(always)]
    fn new(tree: &Tree, origins: [[f64; 2]; 3], directions: [[f64; 2]; 3]) -> Self {
        let center = tree.center.to_array();
        let mut reach = 0.0_f64;
        let mut longest = 0.0_f64;
        for axis in 0..3 {
            for end in 0..2 {
                reach = reach.max(((origins[axis][end] - center[axis]) * tree.scale).abs());
                longest = longest.max((directions[axis][end] * tree.scale).abs());
            }
        }
        // Directions about 1 long, whatever their length in the world.
        let stretch = power_of_two_below(longest);
        let margin = if reach < FARTHEST {
            (reach as f32 + 1.0) * super::nodes::BOX_GIVES_WAY
        } else {
            // Too far away to tell anything apart: every box may be met.
            f32::MAX / 4.0
        };
        let mut shaft = Self {
            enters_by: [0; 3],
            origins: [[0.0; 2]; 3],
            inverse: [[0.0; 2]; 3],
            open: [0.0; 3],
            stretch,
        };
        for axis in 0..3 {
            let in_frame = |origin: f64| {
                ((origin - center[axis]) * tree.scale).clamp(-FARTHEST, FARTHEST) as f32
            };
            // A box's lower plane is farthest behind the origin that is farthest on, and the upper
            // one farthest ahead of the one farthest back.
            shaft.origins[axis] = [
                in_frame(origins[axis][1]) + margin,
                in_frame(origins[axis][0]) - margin,
            ];
            let [least, most] = directions[axis].map(|d| (d * tree.scale / stretch) as f32);
            let (least, most) = (least.next_down(), most.next_up());
            if least >= SMALLEST_COMPONENT || most <= -SMALLEST_COMPONENT {
                shaft.enters_by[axis] = usize::from(most < 0.0);
                shaft.inverse[axis] = [(1.0 / most).next_down(), (1.0 / least).next_up()];
            } else {
                shaft.open[axis] = f32::INFINITY;
            }
        }
        shaft
    }

    /// t of the world in the tree's frame, at least.
    #[inline(always)]
    fn limit(&self, t: f64) -> f32 {
        (t * self.stretch) as f32 * SLAB_GIVES_WAY
    }

    /// One bit for each child of a node whose box a ray might meet up to `limit`, and where it
    /// enters at the earliest.
    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, node: &Node, limit: f32) -> (u32, [f32; WIDTH]) {
        let mut enters = f32x8::splat(simd, 0.0);
        let mut leaves = f32x8::splat(simd, f32::INFINITY);
        for axis in 0..3 {
            let near = self.enters_by[axis];
            let far = 1 - near;
            let to_near =
                f32x8::from_slice(simd, &node.planes[axis][near]) - self.origins[axis][near];
            let to_far = f32x8::from_slice(simd, &node.planes[axis][far]) - self.origins[axis][far];
            let [slow, fast] = self.inverse[axis];
            let (a, b) = (to_near * slow, to_near * fast);
            let (c, d) = (to_far * slow, to_far * fast);
            let near = a.simd_lt(b).select(a, b);
            let far = c.simd_gt(d).select(c, d) + self.open[axis];
            enters = near.simd_gt(enters).select(near, enters);
            leaves = far.simd_lt(leaves).select(far, leaves);
        }
        let leaves = leaves * SLAB_GIVES_WAY;
        let meets = enters.simd_le(leaves) & enters.simd_le(limit);
        let bits = meets.to_bitmask() as u32 & node.present;
        let mut at = [0.0; WIDTH];
        enters.store_slice(&mut at);
        (bits, at)
    }
}

/// Boxes that wait to be opened at most: a tree is at most 64 nodes deep, and each leaves 7 behind.
const STACK: usize = 64 * (WIDTH - 1) + 2 * WIDTH;

/// Boxes that wait to be opened.
pub(super) type Stack = [Entry; STACK];

/// No boxes.
pub(super) const EMPTY_STACK: Stack = [Entry {
    child: 0,
    count: 0,
    at: 0.0,
}; STACK];

/// Shows a packet's question the leaves of a tree that its rays might meet, near ones first: `show` is
/// given a leaf's first block and how many shapes it has.
#[inline(always)]
pub(super) fn descend<S: Simd, Q: Question<S>>(
    simd: S,
    tree: &Tree,
    packet: &Packet<S>,
    question: &mut Q,
    stack: &mut Stack,
    mut show: impl FnMut(u32, u32, &mut Q),
) {
    if question.asked() == 0 {
        return;
    }
    // Rays too unlike for one shaft part into groups.
    let mut groups = [0; LANES];
    groups[0] = question.asked();
    let mut waiting = 1;
    let mut left = 0;
    while waiting > 0 {
        waiting -= 1;
        let group = groups[waiting];
        let Spread {
            origins,
            directions,
            parted,
        } = Spread::of(simd, &packet.rays, group);
        if parted == 0 {
            let shaft = Shaft::new(tree, origins, directions);
            question.only(simd, group);
            descend_shaft(simd, tree, &shaft, question, stack, &mut show);
            left |= question.asked();
        } else {
            groups[waiting] = group & parted;
            groups[waiting + 1] = group & !parted;
            waiting += 2;
        }
    }
    question.only(simd, left);
}

#[inline(always)]
fn descend_shaft<S: Simd, Q: Question<S>>(
    simd: S,
    tree: &Tree,
    shaft: &Shaft,
    question: &mut Q,
    stack: &mut Stack,
    show: &mut impl FnMut(u32, u32, &mut Q),
) {
    let mut limit = shaft.limit(question.limit(simd));
    let mut height = open(simd, &tree.nodes[0], shaft, limit, stack, 0);
    while height > 0 {
        height -= 1;
        let Entry { child, count, at } = stack[height];
        if at > limit {
            continue;
        }
        if count == 0 {
            let node = &tree.nodes[child as usize];
            height = open(simd, node, shaft, limit, stack, height);
            continue;
        }
        show(child, count, question);
        if question.asked() == 0 {
            return;
        }
        limit = shaft.limit(question.limit(simd));
    }
}

/// Shows the leaves of a tree that the rays on a canvas might meet, near ones first: `show` is given a
/// leaf's first block and how many shapes it has.
#[inline(always)]
pub(super) fn sweep<S: Simd>(
    simd: S,
    tree: &Tree,
    canvas: &mut Canvas,
    stack: &mut Stack,
    mut show: impl FnMut(u32, u32, &mut Canvas),
) {
    let origins = canvas.origin.to_array().map(|o| [o, o]);
    let shaft = Shaft::new(tree, origins, canvas.directions(simd));
    let mut limit = shaft.limit(canvas.depth(simd));
    let mut height = open(simd, &tree.nodes[0], &shaft, limit, stack, 0);
    while height > 0 {
        height -= 1;
        let Entry { child, count, at } = stack[height];
        if at > limit {
            continue;
        }
        if count == 0 {
            let node = &tree.nodes[child as usize];
            height = open(simd, node, &shaft, limit, stack, height);
        } else {
            show(child, count, canvas);
            limit = shaft.limit(canvas.depth(simd));
        }
    }
}

/// Puts the children of a node that the shaft meets on the stack, the nearest on top; its new height.
#[inline(always)]
fn open<S: Simd>(
    simd: S,
    node: &Node,
    shaft: &Shaft,
    limit: f32,
    stack: &mut Stack,
    bottom: usize,
) -> usize {
    let (mut bits, at) = shaft.meet(simd, node, limit);
    let mut height = bottom;
    while bits != 0 {
        let child = bits.trailing_zeros() as usize;
        bits &= bits - 1;
        let entry = Entry {
            child: node.children[child],
            count: node.counts[child],
            at: at[child],
        };
        let mut place = height;
        while place > bottom && stack[place - 1].at < entry.at {
            stack[place] = stack[place - 1];
            place -= 1;
        }
        stack[place] = entry;
        height += 1;
    }
    height
}

/// The largest power of two that is not above a length, to be divided by; 1 for a length of 0.
fn power_of_two_below(length: f64) -> f64 {
    const EXPONENT: u64 = 0x7ff << 52;
    let power = f64::from_bits(length.to_bits() & EXPONENT);
    if power > 0.0 { power } else { 1.0 }
}
