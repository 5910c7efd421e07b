//! The outlines of shapes on a [`Canvas`].

use fearless_simd::Simd;

use super::canvas::{CLOSENESS, Canvas, Claim, Extent, GIVES_WAY, NEGLIGIBLE, Row, Verdict};
use crate::lanes::{LANES, Lanes, SingleMask, Singles, Vectors};
use crate::math::DVec3;

/// A function c₀ + c₁ x + c₂ y on the canvas.
#[derive(Clone, Copy, Debug)]
struct Affine([f32; 3]);

impl Affine {
    #[inline(always)]
    fn at<S: Simd>(self, simd: S, [x, y]: [Singles<S>; 2]) -> Singles<S> {
        let [c, cx, cy] = self.0.map(|c| Singles::splat(simd, c));
        x.times_plus(cx, y.times_plus(cy, c))
    }
}

/// A column of functions, those of triangle after triangle.
#[derive(Clone, Copy, Debug)]
struct Affines([Row; 3]);

impl Affines {
    const NONE: Self = Self([Row([0.0; LANES]); 3]);

    #[inline(always)]
    fn get(&self, index: usize) -> Affine {
        Affine(self.0.each_ref().map(|row| row.0[index]))
    }

    #[inline(always)]
    fn store<S: Simd>(&mut self, simd: S, c: Vectors<S>) {
        let [constant, x, y] = &mut self.0;
        c.z.narrowed(simd).store(&mut constant.0);
        c.x.narrowed(simd).store(&mut x.0);
        c.y.narrowed(simd).store(&mut y.0);
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
    /// One bit for each triangle that may be of interest to any ray.
    pub(super) of_interest: u32,
    /// One bit for each that cannot be told from f32.
    untold: u32,
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
            of_interest: 0,
            untold: 0,
        }
    }
}

/// A vector in the axes of a canvas.
#[inline(always)]
fn turned<S: Simd>(vector: Vectors<S>, [u, v, w]: [DVec3; 3]) -> Vectors<S> {
    Vectors {
        x: vector.dot_with(u),
        y: vector.dot_with(v),
        z: vector.dot_with(w),
    }
}

impl Outlines {
    /// The outlines of triangles whose first corner is between their shorter edges, for the lanes with
    /// a bit.
    #[inline(always)]
    pub(super) fn draw<S: Simd>(
        &mut self,
        simd: S,
        canvas: &Canvas,
        corners: [Vectors<S>; 3],
        bits: u32,
    ) {
        let splat = |value: f64| Lanes::splat(simd, value);
        let [first, second, third] = corners;
        let a = turned(first.minus(canvas.origin), canvas.axes);
        let ab = turned(second - first, canvas.axes);
        let ac = turned(third - first, canvas.axes);
        let (b, c) = (a + ab, a + ac);
        let [ab_size, ac_size] = [ab.taxicab(), ac.taxicab()];
        let size = a.taxicab() + ab_size + ac_size;

        // The box, where all corners are clearly before the canvas's origin.
        let nearest = a.z.min(b.z).min(c.z);
        let is_before = nearest.gt(size * NEGLIGIBLE);
        let one = splat(1.0);
        let inverse = [one / a.z, one / b.z, one / c.z];
        let xs = [a.x * inverse[0], b.x * inverse[1], c.x * inverse[2]];
        let ys = [a.y * inverse[0], b.y * inverse[1], c.y * inverse[2]];
        let [extent_x, extent_y] = canvas.extent;
        let sides = [
            (xs[0].min(xs[1]).min(xs[2]), -1.0, extent_x),
            (xs[0].max(xs[1]).max(xs[2]), 1.0, extent_x),
            (ys[0].min(ys[1]).min(ys[2]), -1.0, extent_y),
            (ys[0].max(ys[1]).max(ys[2]), 1.0, extent_y),
        ];
        let give = f64::from(GIVES_WAY);
        let [left, right, bottom, top] = sides.map(|(side, sign, extent)| {
            let side = side + (side.abs() + extent) * (sign * give);
            let side = is_before.select(side, splat(sign * f64::INFINITY));
            side.narrowed(simd)
        });
        let most = splat(canvas.unit * (1.0 + give)) / nearest;
        let most = is_before.select(most, splat(f64::INFINITY)).narrowed(simd);
        let [all_left, all_right, all_bottom, all_top] = canvas.bounds(simd);
        let single = |value: f32| Singles::splat(simd, value);
        let meets = left.le(single(all_right))
            & right.ge(single(all_left))
            & bottom.le(single(all_top))
            & top.ge(single(all_bottom))
            & most.ge(single(canvas.farthest(simd)));
        self.of_interest = meets.to_bits() & bits;
        if self.of_interest == 0 {
            return;
        }
        for (row, side) in self.boxes.iter_mut().zip([left, right, bottom, top]) {
            side.store(&mut row.0);
        }
        most.store(&mut self.most.0);

        // Twice the areas that the edges span with the origin, as vectors: the edge functions. Of a
        // corner and an edge, not of two corners: the products of these would cancel.
        let edges = [b.cross(ac - ab), ac.cross(a), a.cross(ab)];
        let lengths = [(ac - ab).taxicab(), ac_size, ab_size];
        let normal = ab.cross(ac);
        let normal_size = normal.taxicab();
        let volume = a.dot(normal);
        let least_volume = normal_size
            * (size * NEGLIGIBLE + canvas.error / NEGLIGIBLE);
        let mut is_told = volume.abs().gt(least_volume)
            & normal_size.gt(ab_size * ac_size * NEGLIGIBLE);
        let sign = volume.gt(splat(0.0)).select(one, splat(-1.0));
        let magnitude =
            |c: Vectors<S>| c.x.abs() * extent_x + c.y.abs() * extent_y + c.z.abs();
        for ((edge, length), stored) in edges.into_iter().zip(lengths).zip(&mut self.edges) {
            let magnitude = magnitude(edge);
            is_told = is_told & magnitude.gt(size * length * NEGLIGIBLE);
            stored.store(simd, edge.times(sign / magnitude));
        }
        let closeness = normal.times(splat(canvas.unit) / volume);
        let magnitude = magnitude(closeness);
        is_told = is_told
            & magnitude.gt(splat(1.0 / CLOSENESS))
            & magnitude.lt(splat(CLOSENESS));
        self.closeness.store(simd, closeness);
        (magnitude * give).narrowed(simd).store(&mut self.closeness_error.0);
        self.untold = !is_told.to_bits();
    }

    fn extent(&self, index: usize) -> Extent {
        let [left, right, bottom, top] = self.boxes.each_ref().map(|row| row.0[index]);
        Extent {
            x: [left, right],
            y: [bottom, top],
            most: self.most.0[index],
        }
    }

    /// Puts one triangle on the canvas.
    #[inline(always)]
    pub(super) fn cast<S: Simd>(
        &self,
        simd: S,
        index: usize,
        slot: u32,
        canvas: &mut Canvas,
        verdict: impl Verdict,
    ) {
        let mut packets = canvas.meets(simd, &self.extent(index));
        let is_untold = self.untold >> index & 1 == 1;
        let edges = [
            self.edges[0].get(index),
            self.edges[1].get(index),
            self.edges[2].get(index),
        ];
        let closeness = self.closeness.get(index);
        let error = Singles::splat(simd, self.closeness_error.0[index]);
        while packets != 0 {
            let packet = packets.trailing_zeros() as usize;
            packets &= packets - 1;
            if is_untold {
                verdict.abstain(simd, canvas, packet, slot);
                continue;
            }
            let dots = canvas.dots(simd, packet);
            let inside = edges[0]
                .at(simd, dots)
                .min(edges[1].at(simd, dots))
                .min(edges[2].at(simd, dots));
            let maybe = inside.ge(Singles::splat(simd, -GIVES_WAY));
            if maybe.to_bits() == 0 {
                continue;
            }
            let closeness = closeness.at(simd, dots);
            let claim = Claim {
                maybe,
                surely: inside.gt(Singles::splat(simd, GIVES_WAY)),
                least: closeness - error,
                most: closeness + error,
            };
            verdict.hear(simd, canvas, packet, slot, claim);
        }
    }
}

/// Puts an endless plane through `point` on the canvas.
#[inline(always)]
pub(super) fn cast_plane<S: Simd>(
    simd: S,
    point: DVec3,
    normal: DVec3,
    slot: u32,
    canvas: &mut Canvas,
    verdict: impl Verdict,
) {
    let to_point = point - canvas.origin;
    let height = normal.dot(to_point);
    let [x, y, z] = canvas.axes.map(|axis| axis.dot(normal) * (canvas.unit / height));
    let [extent_x, extent_y] = canvas.extent;
    let magnitude = x.abs() * extent_x + y.abs() * extent_y + z.abs();
    let is_told = height.abs() > to_point.length() * NEGLIGIBLE + canvas.error / NEGLIGIBLE
        && (1.0 / CLOSENESS..CLOSENESS).contains(&magnitude);
    let closeness = Affine([z as f32, x as f32, y as f32]);
    let error = Singles::splat(simd, magnitude as f32 * GIVES_WAY);
    let all = SingleMask::from_bits(simd, u32::from(u16::MAX));
    let mut packets = canvas.meets(simd, &Extent::EVERYTHING);
    while packets != 0 {
        let packet = packets.trailing_zeros() as usize;
        packets &= packets - 1;
        if !is_told {
            verdict.abstain(simd, canvas, packet, slot);
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
        verdict.hear(simd, canvas, packet, slot, claim);
    }
}

/// Where R²|d|² − |oc × d|², over the sum of the magnitudes of its terms, is above this, a ray surely
/// meets a sphere, and the root of it is off by [`GIVES_WAY`] over twice the root of this at most.
const SURELY: f32 = 1.0 / (1 << 13) as f32;

/// By how much that root is off at most, √ of [`SURELY`] being 2⁻⁶·⁵: 2⁻²⁰ · 2⁶·⁵ / 2, and room.
const ROOT_ERROR: f64 = 1.0 / (1 << 14) as f64;

/// Puts a sphere on the canvas. `shows_outside` says that no viewer sees it from within.
#[inline(always)]
pub(super) fn cast_sphere<S: Simd>(
    simd: S,
    center: DVec3,
    radius: f64,
    shows_outside: bool,
    slot: u32,
    canvas: &mut Canvas,
    verdict: impl Verdict,
) {
    let from_origin = center - canvas.origin;
    let [x, y, z] = canvas.axes.map(|axis| axis.dot(from_origin));
    let extent = disc_extent(canvas, [x, y, z], radius);
    let mut packets = canvas.meets(simd, &extent);
    if packets == 0 {
        return;
    }
    let distance = from_origin.length();
    let clearance = distance - radius;
    // oc × d = g₀ + g₁ x + g₂ y in the axes of the canvas
    let g = [
        DVec3::new(y, -x, 0.0),
        DVec3::new(0.0, z, -y),
        DVec3::new(-z, 0.0, x),
    ];
    let square = radius * radius;
    let terms = [
        square - g[0].length_squared(),
        -2.0 * g[0].dot(g[1]),
        -2.0 * g[0].dot(g[2]),
        square - g[1].length_squared(),
        -2.0 * g[1].dot(g[2]),
        square - g[2].length_squared(),
    ];
    let [ex, ey] = canvas.extent;
    let powers = [1.0, ex, ey, ex * ex, ex * ey, ey * ey];
    let mut magnitude = square + g[0].length_squared();
    for (term, power) in terms.iter().zip(powers).skip(1) {
        magnitude += term.abs() * power;
    }
    let [c, cx, cy, cxx, cxy, cyy] =
        terms.map(|term| Singles::splat(simd, (term / magnitude) as f32));
    // With b = oc · d and c = |oc|² − R², t = c / (b ± √…), the nearer root of which is before a point
    // outside and behind one inside.
    let scale = canvas.unit / (clearance * (distance + radius));
    let along = [z * scale, x * scale, y * scale];
    let along_size = along[0].abs() + along[1].abs() * ex + along[2].abs() * ey;
    let root_scale = magnitude.sqrt() * scale.abs();
    let error = along_size * f64::from(GIVES_WAY) + root_scale * ROOT_ERROR;
    let size = along_size + root_scale;
    let is_told = clearance.abs() > distance * NEGLIGIBLE + canvas.error / NEGLIGIBLE
        && radius > distance * NEGLIGIBLE + canvas.error / NEGLIGIBLE
        && (1.0 / CLOSENESS..CLOSENESS).contains(&size);
    // Seen from outside, a sphere does not hide points of its own that face the light.
    let own_is_safe = shows_outside || clearance < 0.0;
    let along = Affine(along.map(|c| c as f32));
    let error = Singles::splat(simd, error as f32);
    // Where it is not sure that the sphere is met, the root is below that of 2 · SURELY.
    let edge_error = Singles::splat(simd, root_scale as f32 * (2.0 * SURELY).sqrt());
    let root_scale = Singles::splat(simd, root_scale as f32);
    let zero = Singles::splat(simd, 0.0);
    while packets != 0 {
        let packet = packets.trailing_zeros() as usize;
        packets &= packets - 1;
        if !is_told {
            verdict.abstain(simd, canvas, packet, slot);
            verdict.doubt_own(simd, canvas, packet, slot);
            continue;
        }
        if !own_is_safe {
            verdict.doubt_own(simd, canvas, packet, slot);
        }
        let [x, y] = canvas.dots(simd, packet);
        let discriminant = x.times_plus(
            x.times_plus(cxx, y.times_plus(cxy, cx)),
            y.times_plus(y.times_plus(cyy, cy), c),
        );
        let maybe = discriminant.ge(Singles::splat(simd, -GIVES_WAY));
        if maybe.to_bits() == 0 {
            continue;
        }
        let surely = discriminant.gt(Singles::splat(simd, SURELY));
        let root = discriminant.max(zero).sqrt();
        let closeness = root.times_plus(root_scale, along.at(simd, [x, y]));
        let most = closeness + error;
        let claim = Claim {
            maybe,
            surely,
            least: closeness - error,
            most: surely.select(most, most + edge_error),
        };
        verdict.hear(simd, canvas, packet, slot, claim);
    }
}

/// The box of a sphere on the canvas: the planes through the origin and an axis that touch it (Mara &
/// McGuire 2013, "2D Polyhedral Bounds of a Clipped, Perspective-Projected 3D Sphere").
fn disc_extent(canvas: &Canvas, [x, y, z]: [f64; 3], radius: f64) -> Extent {
    let nearest = z - radius;
    if nearest <= (z.abs() + radius) * f64::from(GIVES_WAY) {
        return Extent::EVERYTHING;
    }
    let give = f64::from(GIVES_WAY);
    let width = nearest * (z + radius);
    let sides = |across: f64, extent: f64| {
        let root = radius * (across * across + width).sqrt();
        let [least, most] = [(across * z - root) / width, (across * z + root) / width];
        [
            (least - (least.abs() + extent) * give) as f32,
            (most + (most.abs() + extent) * give) as f32,
        ]
    };
    Extent {
        x: sides(x, canvas.extent[0]),
        y: sides(y, canvas.extent[1]),
        most: (canvas.unit / nearest * (1.0 + give)) as f32,
    }
}

/// Which lanes the first `count` are.
pub(super) fn first(count: usize) -> u32 {
    (1_u32 << count) - 1
}

/// Sixteen triangles' corners side by side.
#[inline(always)]
pub(super) fn side_by_side<S: Simd>(
    simd: S,
    bits: u32,
    corners: impl Fn(usize) -> [DVec3; 3],
) -> [Vectors<S>; 3] {
    let mut columns = [[[0.0; LANES]; 3]; 3];
    let mut bits = bits;
    while bits != 0 {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits - 1;
        for (columns, corner) in columns.iter_mut().zip(corners(lane)) {
            for (column, number) in columns.iter_mut().zip(corner.to_array()) {
                column[lane] = number;
            }
        }
    }
    columns.each_ref().map(|[x, y, z]| Vectors::load(simd, [x, y, z]))
}
