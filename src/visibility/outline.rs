//! The outlines of shapes on a [`Canvas`].

mod parallel;

use fearless_simd::Simd;

use super::canvas::{
    CLOSENESS, Canvas, Claim, Extent, GIVES_WAY, NEGLIGIBLE, Row, Shared, Verdict, Who,
};
use crate::lanes::{LANES, SingleMask, Singles, Vectors, ones};
use crate::math::DVec3;

/// A function c₀ + c₁ x + c₂ y on the canvas.
#[derive(Clone, Copy, Debug)]
struct Affine([f32; 3]);

impl Affine {
    #[inline(always)]
    fn at<S: Simd>(self, simd: S, [x, y]: [Singles<S>; 2]) -> Singles<S> {
        let [c, cx, cy] = self.0;
        let cy = y.times_plus(Singles::splat(simd, cy), Singles::splat(simd, c));
        x.times_plus(Singles::splat(simd, cx), cy)
    }
}

/// A column of functions, those of triangle after triangle.
#[derive(Clone, Copy, Debug)]
struct Affines([Row; 3]);

impl Affines {
    const NONE: Self = Self([Row([0.0; LANES]); 3]);

    #[inline(always)]
    fn get(&self, index: usize) -> Affine {
        let [constant, x, y] = &self.0;
        Affine([constant.0[index], x.0[index], y.0[index]])
    }

    #[inline(always)]
    fn store<S: Simd>(&mut self, c: SingleVectors<S>) {
        let [constant, x, y] = &mut self.0;
        c.z.store(&mut constant.0);
        c.x.store(&mut x.0);
        c.y.store(&mut y.0);
    }
}

/// The bound on the error of an edge function, over the length of the edge times [`Frame::edge_error`]: see
/// [`Outlines::draw`]. Dots that are nearer to an edge are in doubt.
const EDGE_GIVES_WAY: f32 = 1.0 / (1 << 19) as f32;

/// One rounding to f32.
const ROUNDING: f32 = 1.0 / (1 << 24) as f32;

/// Six products of the sizes of a triangle's ways and its distance must be larger than this part of
/// them together, or its closeness may be off by more than a sixth.
const FLATTEST: f32 = 1.0 / (1 << 17) as f32;

/// Corners at a depth below this part of their distance are not clearly before a canvas's origin.
const NEAREST: f32 = 1.0 / (1 << 17) as f32;

/// A triangle smaller than this part of its distance has corners that rounding puts in one place: 2⁹ times
/// what an f64 may be off.
const SMALLEST: f32 = 1.0 / (1_u64 << 44) as f32;

/// How much a corner's place on the canvas is off by the rounding of its way in f64, times the size of the
/// way over its depth: eight roundings of 2⁻⁵³, and eight times that.
pub(super) const NOISE: f32 = 1.0 / (1_u64 << 47) as f32;

/// A vector in each lane.
#[derive(Clone, Copy)]
struct SingleVectors<S: Simd> {
    x: Singles<S>,
    y: Singles<S>,
    z: Singles<S>,
}

impl<S: Simd> SingleVectors<S> {
    #[inline(always)]
    fn load(simd: S, [x, y, z]: &[Row; 3]) -> Self {
        Self {
            x: Singles::load(simd, &x.0),
            y: Singles::load(simd, &y.0),
            z: Singles::load(simd, &z.0),
        }
    }

    /// In other axes.
    #[inline(always)]
    fn turned(self, simd: S, [u, v, w]: &[[f32; 3]; 3]) -> Self {
        Self {
            x: self.along(simd, u),
            y: self.along(simd, v),
            z: self.along(simd, w),
        }
    }

    #[inline(always)]
    fn along(self, simd: S, [x, y, z]: &[f32; 3]) -> Singles<S> {
        let zs = self.z * Singles::splat(simd, *z);
        let yzs = self.y.times_plus(Singles::splat(simd, *y), zs);
        self.x.times_plus(Singles::splat(simd, *x), yzs)
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self {
            x: self.x + other.x,
            y: self.y + other.y,
            z: self.z + other.z,
        }
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self {
            x: self.x - other.x,
            y: self.y - other.y,
            z: self.z - other.z,
        }
    }

    #[inline(always)]
    fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    #[inline(always)]
    fn dot(self, other: Self) -> Singles<S> {
        let yzs = self.y.times_plus(other.y, self.z * other.z);
        self.x.times_plus(other.x, yzs)
    }

    /// At least the length, and 8 % more at most: (√2 − 1) times the smaller two components added to the
    /// largest.
    #[inline(always)]
    fn size(self, simd: S) -> Singles<S> {
        let (x, y, z) = (self.x.abs(), self.y.abs(), self.z.abs());
        let largest = x.max(y).max(z) * Singles::splat(simd, 0.5857);
        (x + y + z).times_plus(Singles::splat(simd, 0.4143), largest)
    }

    #[inline(always)]
    fn times(self, factor: Singles<S>) -> Self {
        Self {
            x: self.x * factor,
            y: self.y * factor,
            z: self.z * factor,
        }
    }

    /// The largest values of functions on a canvas, or more.
    #[inline(always)]
    fn largest(self, [x, y]: [Singles<S>; 2]) -> Singles<S> {
        let terms = self.y.abs().times_plus(y, self.z);
        self.x.abs().times_plus(x, terms)
    }

    /// The sum of the magnitudes of the terms of functions on a canvas, at most.
    #[inline(always)]
    fn magnitude(self, [x, y]: [Singles<S>; 2]) -> Singles<S> {
        let terms = self.y.abs().times_plus(y, self.z.abs());
        self.x.abs().times_plus(x, terms)
    }
}

/// Triangles side by side, by their first corners and the ways from there to the two others, in f32: so
/// small beside what an f64 has that the ways need a middle and a size.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Sketch {
    /// From the middle to the first corners, and from there to the second and to the third ones, over
    /// the size, axis by axis.
    first: [Row; 3],
    to_second: [Row; 3],
    to_third: [Row; 3],
    middle: DVec3,
    /// No corner is further from the middle.
    size: f64,
    over_size: f64,
}

impl Sketch {
    /// Of triangles whose first corners are between their shorter edges: at most sixteen.
    pub(super) fn of(triangles: impl ExactSizeIterator<Item = [DVec3; 3]> + Clone) -> Self {
        let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for [a, b, c] in triangles.clone() {
            least = least.min(a).min(b).min(c);
            most = most.max(a).max(b).max(c);
        }
        let middle = least * 0.5 + most * 0.5;
        // √3 times the largest component, and room for rounding.
        let reach = (most - middle).max(middle - least).max_element();
        let size = (reach * 1.75).max(f64::MIN_POSITIVE);
        let none = [Row([0.0; LANES]); 3];
        let mut sketch = Self {
            first: none,
            to_second: none,
            to_third: none,
            middle,
            size,
            over_size: 1.0 / size,
        };
        for (place, [a, b, c]) in triangles.enumerate() {
            let (first, to_second, to_third) =
                ((a - middle) / size, (b - a) / size, (c - a) / size);
            for axis in 0..3 {
                sketch.first[axis].0[place] = first[axis] as f32;
                sketch.to_second[axis].0[place] = to_second[axis] as f32;
                sketch.to_third[axis].0[place] = to_third[axis] as f32;
            }
        }
        sketch
    }

    /// The corners, which may be off by [`Self::error`] in each coordinate.
    #[inline(always)]
    pub(super) fn corners<S: Simd>(&self, simd: S) -> [Vectors<S>; 3] {
        let a = self.widened(simd, &self.first).minus(-self.middle);
        let ab = self.widened(simd, &self.to_second);
        let ac = self.widened(simd, &self.to_third);
        [a, a + ab, a + ac]
    }

    #[inline(always)]
    fn widened<S: Simd>(&self, simd: S, [x, y, z]: &[Row; 3]) -> Vectors<S> {
        Vectors {
            x: Singles::load(simd, &x.0).widened(simd) * self.size,
            y: Singles::load(simd, &y.0).widened(simd) * self.size,
            z: Singles::load(simd, &z.0).widened(simd) * self.size,
        }
    }

    /// Reads a bit of it, so that it is on its way from memory while others are looked at.
    #[inline(always)]
    pub(super) fn touch(&self) {
        std::hint::black_box(self.first[0].0[0]);
        std::hint::black_box(self.first[1].0[0]);
        std::hint::black_box(self.first[2].0[0]);
        std::hint::black_box(self.to_second[0].0[0]);
        std::hint::black_box(self.to_second[1].0[0]);
        std::hint::black_box(self.to_second[2].0[0]);
        std::hint::black_box(self.to_third[0].0[0]);
        std::hint::black_box(self.to_third[1].0[0]);
        std::hint::black_box(self.to_third[2].0[0]);
        std::hint::black_box(self.middle.x);
    }

    /// The rounding of offsets to f32, 2⁻²⁴ of at most three sizes, and of sums in f64.
    pub(super) fn error(&self) -> f64 {
        self.size * NEGLIGIBLE * 8.0 + self.middle.abs().max_element() * (4.0 * f64::EPSILON)
    }
}

/// Where a sketch is as seen from a canvas's origin, in units of its size.
struct Frame {
    /// Its middle, in the axes of the canvas.
    middle: [f32; 3],
    /// How far the coordinates of corners may be off, and a quarter more, over [`ROUNDING`].
    drift: [f32; 3],
    /// At least the sum of the magnitudes of a corner's coordinates.
    distance: f32,
    /// How far edge functions may be off, over the length of the edge and [`EDGE_GIVES_WAY`]: those of
    /// edges at the first corner, and that of the edge opposite.
    edge_error: [f32; 2],
    /// From the reciprocal of a depth to its closeness.
    closeness: f64,
    /// How far the canvas's rays may be off, over [`NEGLIGIBLE`].
    error: f32,
}

impl Frame {
    #[inline(always)]
    fn new(canvas: &Canvas, sketch: &Sketch) -> Self {
        let to_middle = sketch.middle - canvas.origin;
        let over_size = sketch.over_size;
        let middle = canvas
            .axes
            .map(|axis| (axis.dot(to_middle) * over_size) as f32);
        let [x, y, z] = middle.map(f32::abs);
        let [extent_x, extent_y] = canvas.extent.map(|extent| extent as f32);
        // The terms of an edge function, where the coordinates of a point are of these sizes.
        let terms = |x: f32, y: f32, z: f32| (y + z) * extent_x + (z + x) * extent_y + (x + y);
        let (middle_terms, one_terms) = (terms(x, y, z), terms(1.0, 1.0, 1.0));
        let drift = |size: f32| (size * 3.0 + 18.0) * 1.25;
        Self {
            middle,
            drift: [drift(x), drift(y), drift(z)],
            distance: x + y + z + 4.0,
            // 16 (|m| + 1) + 2 |m| + 6 and 22 (|m| + 1) + 3 |m| + 18, over 28.
            edge_error: [
                (middle_terms * 18.0 + one_terms * 22.0) / 28.0,
                (middle_terms * 25.0 + one_terms * 40.0) / 28.0,
            ],
            closeness: canvas.unit * over_size,
            error: (canvas.error * over_size / NEGLIGIBLE) as f32,
        }
    }
}

/// The outlines of sixteen triangles.
#[derive(Clone, Debug)]
pub(super) struct Outlines {
    /// Positive inside, and over the sum of the magnitudes of its terms.
    edges: [Affines; 3],
    closeness: Affines,
    /// How far the closeness may be off.
    closeness_error: Row,
    /// The least and the largest x and y.
    boxes: [Row; 4],
    /// The largest closeness.
    most: Row,
    /// One bit for each packet that a triangle may be of interest to.
    packets: [u32; LANES],
    /// One bit for each triangle that may be of interest to any ray.
    pub(super) of_interest: u32,
    /// One bit for each that cannot be told from f32.
    untold: u32,
    /// One bit for each that may reach behind where parallel rays start.
    cut: u32,
}

impl Default for Outlines {
    fn default() -> Self {
        let row = Row([0.0; LANES]);
        Self {
            edges: [Affines::NONE; 3],
            closeness: Affines::NONE,
            closeness_error: row,
            boxes: [row; 4],
            most: row,
            packets: [0; LANES],
            of_interest: 0,
            untold: 0,
            cut: 0,
        }
    }
}

impl Outlines {
    /// The outlines of the triangles of a sketch with a bit.
    ///
    /// All is in units of the sketch's size. With u = 2⁻²⁴, m the middle and ℓ the length of a way:
    /// a way is stored with an error of u in each component, and turned by three products and sums with
    /// axes rounded to f32, so that it is off by 5 u ℓ; so is the way from the middle to the first corner a,
    /// with ℓ ≤ 1. Adding m, rounded to f32 by itself, makes u (2 |m| + 6) for each component of a, and
    /// u (3 |m| + 18) for b and c. The way from b to c is the longest one, and off by 11 u of its length.
    ///
    /// In an edge function p × e no term is larger than ℓ (|m| + 1) for e. Of that it is off by 5 u or
    /// 11 u for e, by 2 u for the products, 1 u for the factor, 3 u for its sum, and 5 u for x and y of a
    /// dot; and by ℓ times the error of p. That is 28 u of [`Frame::edge_error`]; the ways in f64, which
    /// move a whole edge, are worth another 4 u of it: [`EDGE_GIVES_WAY`].
    #[inline(always)]
    pub(super) fn draw<S: Simd>(
        &mut self,
        simd: S,
        canvas: &mut Canvas,
        sketch: &Sketch,
        bits: u32,
    ) {
        if let Shared::Direction(start) = canvas.shared {
            self.draw_parallel(simd, canvas, start, sketch, bits);
            return;
        }
        self.cut = 0;
        let frame = Frame::new(canvas, sketch);
        let middle = SingleVectors {
            x: Singles::splat(simd, frame.middle[0]),
            y: Singles::splat(simd, frame.middle[1]),
            z: Singles::splat(simd, frame.middle[2]),
        };
        let a = SingleVectors::load(simd, &sketch.first).turned(simd, &canvas.turn);
        let ab = SingleVectors::load(simd, &sketch.to_second).turned(simd, &canvas.turn);
        let ac = SingleVectors::load(simd, &sketch.to_third).turned(simd, &canvas.turn);
        let a = middle.plus(a);
        let (b, c) = (a.plus(ab), a.plus(ac));

        // The box, where all corners are clearly before the canvas's origin.
        let one = Singles::splat(simd, 1.0);
        let zero = Singles::splat(simd, 0.0);
        let infinite = Singles::splat(simd, f32::INFINITY);
        let [extent_x, extent_y] = canvas.extent.map(|extent| extent as f32);
        let ab_size = ab.size(simd);
        let ac_size = ac.size(simd);
        let nearest = a.z.min(b.z).min(c.z);
        // Corners that are one and the same as far as the rounding of their way can tell are anywhere.
        let has_size = ab_size
            .min(ac_size)
            .gt(Singles::splat(simd, frame.distance * SMALLEST));
        let has_closeness = (1.0 / CLOSENESS..CLOSENESS).contains(&frame.closeness);
        let nearest_told = if has_closeness {
            frame.distance * NEAREST
        } else {
            f32::INFINITY
        };
        let is_before = has_size & nearest.gt(Singles::splat(simd, nearest_told));
        let (in_a, in_b, in_c) = (one / a.z, one / b.z, one / c.z);
        let inverse = in_a.max(in_b).max(in_c);
        // Corners drift, across and along; dots are off by 5 u, and divisions by 2 u.
        let [drift_x, drift_y, drift_z] = frame.drift;
        let give = Singles::splat(simd, GIVES_WAY);
        let slope = inverse.times_plus(Singles::splat(simd, drift_z * ROUNDING), give);
        let noise = frame.distance * NOISE;
        let room_x = inverse.times_plus(
            Singles::splat(simd, drift_x * ROUNDING + noise),
            Singles::splat(simd, extent_x * GIVES_WAY),
        );
        let room_y = inverse.times_plus(
            Singles::splat(simd, drift_y * ROUNDING + noise),
            Singles::splat(simd, extent_y * GIVES_WAY),
        );
        let (ax, bx, cx) = (a.x * in_a, b.x * in_b, c.x * in_c);
        let (ay, by, cy) = (a.y * in_a, b.y * in_b, c.y * in_c);
        let (left, right) = (ax.min(bx).min(cx), ax.max(bx).max(cx));
        let (bottom, top) = (ay.min(by).min(cy), ay.max(by).max(cy));
        let left = left - left.abs().times_plus(slope, room_x);
        let left = is_before.select(left, zero - infinite);
        let right = right + right.abs().times_plus(slope, room_x);
        let right = is_before.select(right, infinite);
        let bottom = bottom - bottom.abs().times_plus(slope, room_y);
        let bottom = is_before.select(bottom, zero - infinite);
        let top = top + top.abs().times_plus(slope, room_y);
        let top = is_before.select(top, infinite);
        let to_closeness = Singles::splat(simd, frame.closeness as f32);
        let most = inverse * to_closeness * (one + slope);
        let most = is_before.select(most, infinite);
        let meets = canvas.is_of_interest(simd, [left, right, bottom, top], most);
        let of_interest = meets.to_bits() & bits;
        if !self.place(simd, canvas, [left, right, bottom, top], most, of_interest) {
            return;
        }

        // Twice the areas that the edges span with the origin, as vectors: the edge functions. Of a
        // corner and an edge, not of two corners: the products of these would cancel.
        let bc = ac.minus(ab);
        let bc_size = bc.size(simd);
        let normal = ab.cross(ac);
        let volume = a.dot(normal);
        // The normal is off by 16 u of the product of its edges in each component, and the volume by
        // 21 u of that and the distance. Errors of a sliver's normal and of a grazing view multiply.
        let edges = ab_size * ac_size;
        let is_clear = has_size
            & volume
                .abs()
                .gt(edges * Singles::splat(simd, frame.distance * FLATTEST + frame.error));
        let sign = volume.gt(zero).select(one, zero - one);
        let extent = [
            Singles::splat(simd, extent_x),
            Singles::splat(simd, extent_y),
        ];
        let sizes = [ab_size, ac_size, bc_size];
        let (are_told, is_met) =
            self.draw_edges(simd, &frame, [a, b], [ab, ac, bc], sizes, sign, extent);
        // k (n · d) / V: an error of a sixth in V makes 20 u of 16 u, and 26 u of 21 u.
        let over_volume = one / volume;
        let closeness = normal.times(to_closeness * over_volume);
        let magnitude = closeness.magnitude(extent);
        let is_told = is_clear
            & are_told
            & magnitude.gt(Singles::splat(simd, (1.0 / CLOSENESS) as f32))
            & magnitude.le(Singles::splat(simd, CLOSENESS as f32));
        self.closeness.store(closeness);
        let flatness = edges * Singles::splat(simd, ROUNDING) * over_volume.abs();
        let of_volume = flatness.times_plus(
            Singles::splat(simd, frame.distance * 26.0),
            Singles::splat(simd, ROUNDING * 16.0),
        );
        let of_normal =
            flatness * to_closeness * Singles::splat(simd, (1.0 + extent_x + extent_y) * 20.0);
        let error = magnitude.times_plus(of_volume, of_normal);
        error.store(&mut self.closeness_error.0);
        let told = is_told.to_bits();
        self.untold = !told;
        self.of_interest &= is_met.to_bits() | self.untold;
    }

    /// Keeps the boxes of triangles, and which of those with a bit hold any ray; whether there are such.
    #[inline(always)]
    fn place<S: Simd>(
        &mut self,
        simd: S,
        canvas: &mut Canvas,
        boxes: [Singles<S>; 4],
        most: Singles<S>,
        bits: u32,
    ) -> bool {
        self.of_interest = bits;
        if bits == 0 {
            return false;
        }
        if let Some(bins) = canvas.bins(simd, self.of_interest.count_ones()) {
            let places = bins.places(simd, boxes);
            for place in ones(self.of_interest) {
                let packets = bins.packets(&places, place);
                self.packets[place] = packets;
                self.of_interest &= !(u32::from(packets == 0) << place);
            }
            if self.of_interest == 0 {
                return false;
            }
        } else {
            self.packets = [u32::MAX; LANES];
        }
        let [left, right, bottom, top] = boxes;
        left.store(&mut self.boxes[0].0);
        right.store(&mut self.boxes[1].0);
        bottom.store(&mut self.boxes[2].0);
        top.store(&mut self.boxes[3].0);
        most.store(&mut self.most.0);
        true
    }

    /// The edge functions, of which `sign` makes those positive whose triangles turn the other way: by the
    /// first two corners, the ways ab, ac and bc, and their sizes. Which can be told, and which
    /// may hold a ray of this extent.
    #[inline(always)]
    #[expect(
        clippy::too_many_arguments,
        reason = "what both kinds of canvas know of triangles"
    )]
    fn draw_edges<S: Simd>(
        &mut self,
        simd: S,
        frame: &Frame,
        [a, b]: [SingleVectors<S>; 2],
        [ab, ac, bc]: [SingleVectors<S>; 3],
        [ab_size, ac_size, bc_size]: [Singles<S>; 3],
        sign: Singles<S>,
        extent: [Singles<S>; 2],
    ) -> (SingleMask<S>, SingleMask<S>) {
        let edges = ab_size * ac_size;
        // Of the longest edge, opposite of the first corner: rounding on the way to a corner moves all.
        let rounding = bc_size * Singles::splat(simd, frame.distance * NEGLIGIBLE as f32);
        let [beside_first, opposite_first] = frame.edge_error;
        let shortest = ab_size.min(ac_size).min(bc_size);
        let are_told = (shortest * Singles::splat(simd, beside_first)).gt(rounding);
        // The reciprocals of the three lengths from one division: none is below 2⁻⁴².
        let scale = sign / (edges * bc_size);
        let beside = scale * bc_size * Singles::splat(simd, 1.0 / beside_first);
        let opposite = scale * edges * Singles::splat(simd, 1.0 / opposite_first);
        let [opposite_a, opposite_b, opposite_c] = &mut self.edges;
        let edge_a = b.cross(bc).times(opposite);
        let edge_b = ac.cross(a).times(beside * ab_size);
        let edge_c = a.cross(ab).times(beside * ac_size);
        opposite_a.store(edge_a);
        opposite_b.store(edge_b);
        opposite_c.store(edge_c);
        // One edge may have all rays on its outer side. Twice the room: for the three sums of this.
        let outside = Singles::splat(simd, -2.0 * EDGE_GIVES_WAY);
        let is_met = edge_a.largest(extent).gt(outside)
            & edge_b.largest(extent).gt(outside)
            & edge_c.largest(extent).gt(outside);
        (are_told, is_met)
    }

    fn extent(&self, index: usize) -> Extent {
        let [left, right, bottom, top] = &self.boxes;
        Extent {
            x: [left.0[index], right.0[index]],
            y: [bottom.0[index], top.0[index]],
            most: self.most.0[index],
        }
    }

    /// Puts one triangle on the canvas.
    #[inline(always)]
    pub(super) fn cast<S: Simd>(
        &self,
        simd: S,
        index: usize,
        who: Who,
        canvas: &mut Canvas,
        verdict: impl Verdict,
    ) {
        let packets = canvas.meets(simd, &self.extent(index)) & self.packets[index];
        let is_untold = self.untold >> index & 1 == 1;
        let edges = [
            self.edges[0].get(index),
            self.edges[1].get(index),
            self.edges[2].get(index),
        ];
        let closeness = self.closeness.get(index);
        let error = Singles::splat(simd, self.closeness_error.0[index]);
        let is_cut = self.cut >> index & 1 == 1;
        for packet in ones(packets) {
            if is_untold {
                verdict.abstain(simd, canvas, packet, who);
                continue;
            }
            let dots = canvas.dots(simd, packet);
            let inside = edges[0]
                .at(simd, dots)
                .min(edges[1].at(simd, dots))
                .min(edges[2].at(simd, dots));
            let maybe = inside.ge(Singles::splat(simd, -EDGE_GIVES_WAY));
            if maybe.to_bits() == 0 {
                continue;
            }
            let closeness = closeness.at(simd, dots);
            let claim = Claim {
                maybe,
                surely: inside.gt(Singles::splat(simd, EDGE_GIVES_WAY)),
                least: closeness - error,
                most: closeness + error,
            };
            let claim = if is_cut {
                canvas.ahead(simd, claim)
            } else {
                claim
            };
            verdict.hear(simd, canvas, packet, who, claim);
        }
    }
}

/// Puts an endless plane through `point` on the canvas.
#[inline(always)]
pub(super) fn cast_plane<S: Simd>(
    simd: S,
    point: DVec3,
    normal: DVec3,
    who: Who,
    canvas: &mut Canvas,
    verdict: impl Verdict,
) {
    let is_beside = canvas.is_beside(point, normal) || verdict.are_all_on(who);
    if is_beside || !verdict.is_ready(simd, canvas) {
        return;
    }
    if let Shared::Direction(start) = canvas.shared {
        parallel::cast_plane(simd, point, normal, start, who, canvas, verdict);
        return;
    }
    let to_point = point - canvas.origin;
    let height = normal.dot(to_point);
    let [u, v, w] = canvas.axes;
    let scale = canvas.unit / height;
    let (x, y, z) = (
        u.dot(normal) * scale,
        v.dot(normal) * scale,
        w.dot(normal) * scale,
    );
    let [extent_x, extent_y] = canvas.extent;
    let magnitude = x.abs() * extent_x + y.abs() * extent_y + z.abs();
    let is_told = height.abs() > to_point.length() * NEGLIGIBLE + canvas.error / NEGLIGIBLE
        && (1.0 / CLOSENESS..CLOSENESS).contains(&magnitude);
    let closeness = Affine([z as f32, x as f32, y as f32]);
    let error = Singles::splat(simd, magnitude as f32 * GIVES_WAY);
    let all = SingleMask::from_bits(simd, u32::from(u16::MAX));
    let packets = canvas.meets(simd, &Extent::EVERYTHING);
    for packet in ones(packets) {
        if !is_told {
            verdict.abstain(simd, canvas, packet, who);
            continue;
        }
        let closeness = closeness.at(simd, canvas.dots(simd, packet));
        let maybe = closeness.ge(Singles::splat(simd, 0.0) - error);
        let claim = Claim {
            maybe,
            surely: all,
            least: closeness - error,
            most: closeness + error,
        };
        verdict.hear(simd, canvas, packet, who, claim);
    }
}

/// Sixteen triangles' corners side by side.
#[inline(always)]
pub(super) fn side_by_side<S: Simd>(
    simd: S,
    bits: u32,
    corners: impl Fn(usize) -> [DVec3; 3],
) -> [Vectors<S>; 3] {
    let mut columns = [[0.0; LANES]; 9];
    for lane in ones(bits) {
        let [a, b, c] = corners(lane);
        columns[0][lane] = a.x;
        columns[1][lane] = a.y;
        columns[2][lane] = a.z;
        columns[3][lane] = b.x;
        columns[4][lane] = b.y;
        columns[5][lane] = b.z;
        columns[6][lane] = c.x;
        columns[7][lane] = c.y;
        columns[8][lane] = c.z;
    }
    let [ax, ay, az, bx, by, bz, cx, cy, cz] = &columns;
    [
        Vectors::load(simd, [ax, ay, az]),
        Vectors::load(simd, [bx, by, bz]),
        Vectors::load(simd, [cx, cy, cz]),
    ]
}
