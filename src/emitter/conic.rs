//! Disks and spheres as they are seen from a point: elliptic cones, and what planes through the point leave of
//! them.
//!
//! The outline of a disk or a sphere is g(t) = e₁ b cos t + e₂ d sin t + ê a, t from 0 to 2π, where ê is the axis
//! of the cone and e₁, e₂ are the axes of the ellipse: |g|² = a² + b² cos² t + d² sin² t. A plane through the point
//! cuts the ellipse along a chord.

use super::clip::{SLACK, across, l1};
use super::gauss;
use super::lambert::{half_arc, half_edge};
use super::lobe::{Integrand, is_small, power};
use crate::math::DVec3;

/// So many planes may cut a cone: two horizons, and the sides of a cell of its outline.
const MOST_PLANES: usize = 24;

/// Most cones are cut by so many at most, and then less is made room for.
const FEW_PLANES: usize = 5;

/// Two planes whose heights differ by less than so much of them are one: what is between them is below the last
/// digits of any integral.
const SAME_PLANE: f64 = 1e-14;

/// An elliptic cone from the origin, cut by planes through it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Conic {
    /// e₁, e₂, ê: right-handed, of unit length.
    frame: [DVec3; 3],
    /// b, d, a
    radii: [f64; 3],
    /// In the frame: inside is where n · x ≥ 0.
    planes: [DVec3; MOST_PLANES],
    count: usize,
}

/// A piece of the boundary, in the sense in which the outline runs.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Piece {
    /// From g(t₀) to g(t₁), t₀ < t₁.
    Arc([f64; 2]),
    /// Straight on, of vectors in the frame.
    Edge([DVec3; 2]),
}

/// Where a polygon is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Inside,
    Outside,
    /// Or too close to tell.
    Across,
}

/// A vector of unit length across another of unit length.
fn across_of(unit: DVec3) -> DVec3 {
    let [x, y, z] = unit.abs().to_array();
    let least = if x <= y && x <= z {
        DVec3::X
    } else if y <= z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    let cross = unit.cross(least);
    cross / cross.length()
}

impl Conic {
    fn new(frame: [DVec3; 3], radii: [f64; 3]) -> Self {
        Self {
            frame,
            radii,
            planes: [DVec3::ZERO; MOST_PLANES],
            count: 0,
        }
    }

    /// A sphere around a vector from the point. `None` from inside of it, and from its surface.
    pub(crate) fn of_sphere(center: DVec3, radius: f64) -> Option<Self> {
        let distance = center.length();
        if !(distance > radius && distance.is_finite()) {
            return None;
        }
        let axis = center / distance;
        let sine = radius / distance;
        let cosine = ((distance - radius) * (distance + radius)).sqrt() / distance;
        let e1 = across_of(axis);
        let frame = [e1, axis.cross(e1), axis];
        Some(Self::new(frame, [sine, sine, cosine]))
    }

    /// A disk around a vector from the point, across `normal` of unit length. `None` from a point in its plane.
    ///
    /// In the plane through the point, the center and the normal, the cone is between two rays g₁ and g₂ to the
    /// rim, and its axis halves the angle 2β between them: b = sin β, a = cos β. The chord through where the axis
    /// meets the disk gives d = R/√(|g₁| |g₂|).
    pub(crate) fn of_disk(center: DVec3, normal: DVec3, radius: f64) -> Option<Self> {
        let along = center.dot(normal);
        let height = along.abs();
        if !(height > 0.0 && height.is_finite()) {
            return None;
        }
        let down = if along < 0.0 { -normal } else { normal };
        let offset = center - down * height;
        let offset = offset - down * offset.dot(down);
        let x = offset.length();
        let in_plane = if x > 0.0 { offset / x } else { across_of(down) };
        let far = libm::hypot(x + radius, height);
        let near = libm::hypot(x - radius, height);
        let product = far * near;
        // Of 2β.
        let cosine = ((x - radius) * (x + radius) + height * height) / product;
        let sine = 2.0 * radius * height / product;
        let (sine, cosine) = if cosine > 0.0 {
            let half = (0.5 * (1.0 + cosine)).sqrt();
            (sine / (2.0 * half), half)
        } else {
            let half = (0.5 * (1.0 - cosine)).sqrt();
            (half, sine / (2.0 * half))
        };
        // g₁/|g₁| + g₂/|g₂| times |g₁| |g₂|, where what cancels in its first part is left out.
        let total = far + near;
        let [sideways, downwards] = [4.0 * x * product * cosine * cosine / total, height * total];
        let length = libm::hypot(sideways, downwards);
        let [sideways, downwards] = [sideways / length, downwards / length];
        let axis = in_plane * sideways + down * downwards;
        let e1 = in_plane * downwards - down * sideways;
        let frame = [e1, axis.cross(e1), axis];
        let radii = [sine, radius / product.sqrt(), cosine];
        Some(Self::new(frame, radii))
    }

    /// It without the planes that cut it.
    pub(super) fn whole(&self) -> WholeCone {
        WholeCone {
            frame: self.frame,
            radii: self.radii,
        }
    }

    /// What of it is where `inward · x ≥ 0`, of unit length. `None` where too many planes cut it.
    pub(crate) fn clipped(&self, inward: DVec3) -> Option<Self> {
        let mut clipped = *self;
        let plane = self.local(inward);
        if self.cuts(plane) {
            *clipped.planes.get_mut(self.count)? = plane;
            clipped.count += 1;
        }
        Some(clipped)
    }

    /// Whether a plane leaves less of the whole cone than all.
    fn cuts(&self, plane: DVec3) -> bool {
        let [b, d, a] = self.radii;
        plane.z * a < libm::hypot(plane.x * b, plane.y * d)
    }

    /// A vector in the frame.
    fn local(&self, vector: DVec3) -> DVec3 {
        let [x, y, z] = self.frame.map(|axis| axis.dot(vector));
        DVec3::new(x, y, z)
    }

    /// From the middle of the disk in which x = cos t, y = sin t to the frame.
    fn at(&self, x: f64, y: f64) -> DVec3 {
        let [b, d, a] = self.radii;
        DVec3::new(b * x, d * y, a)
    }

    /// How far it reaches to a side, over the distance.
    fn reach(&self) -> f64 {
        let [b, d, a] = self.radii;
        2.0 * b.max(d) / a
    }

    /// Φ(n) = ∫ max(0, n·u) dω in sr, from 0 to π, n of unit length: ½ ∮ n · (u × du), in closed form. Above the
    /// horizon it is π (n·ê) b d/√((a² + b²)(a² + d²)). Off by 3e-15 at most where a plane cuts it, else by 1e-15
    /// of the result.
    pub(crate) fn irradiance(&self, normal: DVec3) -> f64 {
        let normal = self.local(normal);
        let mut total = 0.0;
        self.for_each_piece(self.cuts(normal).then_some(normal), |piece| {
            total += match piece {
                Piece::Arc(turns) => half_arc(self.radii, normal, turns),
                Piece::Edge([from, to]) => half_edge(normal, from, to),
            };
        });
        total.max(0.0)
    }

    /// Its solid angle in sr, from 0 to 2π: that of [`lobe`](Self::lobe) where n is 0. Of a round cone it is in closed
    /// form: triangles between the axis and edges, and 1 − a of each arc.
    pub(crate) fn solid_angle(&self) -> f64 {
        let [b, d, a] = self.radii;
        if b != d {
            return self.lobe(self.frame[2], 0.0);
        }
        let length = libm::hypot(a, b);
        let mut total = 0.0;
        self.for_each_piece(None, |piece| {
            total += match piece {
                Piece::Arc([from, to]) => (to - from) * (b * b / (length * (length + a))),
                Piece::Edge([from, to]) => {
                    let [from_length, to_length] = [from.length(), to.length()];
                    let around = from_length * to_length
                        + from.z * to_length
                        + to.z * from_length
                        + from.dot(to);
                    2.0 * libm::atan2(across(from, to).z, around)
                }
            };
        });
        total.max(0.0)
    }

    /// τⁿ(w) = ∫ max(0, w·u)ⁿ dω in sr, from 0 to 2π/(n+1), once the horizon has cut it; w of unit length, n from 0
    /// to 1e9. It is exact to 3e-12 of 2π/(n+1).
    pub(crate) fn lobe(&self, w: DVec3, exponent: f64) -> f64 {
        let w = self.local(w);
        let integrand = Integrand::lobe(w, exponent);
        if self.is_small(w, &integrand) {
            return self.over_small(|u| power(w, u, exponent));
        }
        self.boundary(w, &integrand) / (exponent + 1.0)
    }

    /// ∫ max(0, w·u)ⁿ v·u dω in sr, from 0 to 2π/(n+2), once v's horizon has cut it, as [`lobe`](Self::lobe). It is
    /// exact to 3e-12 of 2π/(n+2).
    pub(crate) fn cosine_lobe(&self, w: DVec3, v: DVec3, exponent: f64) -> f64 {
        let [w, v] = [w, v].map(|vector| self.local(vector));
        let integrand = Integrand::cosine_lobe(w, v, exponent);
        if self.is_small(w, &integrand) {
            return self
                .over_small(|u| power(w, u, exponent) * v.dot(u))
                .max(0.0);
        }
        self.boundary(w, &integrand) / (exponent + 2.0)
    }

    fn is_small(&self, w: DVec3, integrand: &Integrand) -> bool {
        self.count == 0 && is_small(self.reach(), integrand) && !self.cuts(w)
    }

    fn boundary(&self, w: DVec3, integrand: &Integrand) -> f64 {
        let mut total = 0.0;
        self.for_each_piece(self.cuts(w).then_some(w), |piece| {
            total += match piece {
                Piece::Arc(turns) => integrand.arc(self.radii, turns),
                Piece::Edge([from, to]) => integrand.edge(from, to),
            };
        });
        total.max(0.0)
    }

    /// ∫ f(x) dω over a whole cone that is so narrow that f and 1/|x|² hardly bend over it, x in the frame and of
    /// unit length: four points along the radius, twelve around.
    fn over_small(&self, f: impl Fn(DVec3) -> f64) -> f64 {
        const AROUND: u32 = 12;
        let [b, d, a] = self.radii;
        let step = std::f64::consts::TAU / f64::from(AROUND);
        let mut total = 0.0;
        for &[x, weight] in gauss::half_rule(4) {
            for radius in [0.5 - 0.5 * x, 0.5 + 0.5 * x] {
                for turn in 0..AROUND {
                    let (sin, cos) = libm::sincos(step * f64::from(turn));
                    let place = self.at(radius * cos, radius * sin);
                    let inverse = 1.0 / place.length();
                    total +=
                        0.5 * weight * radius * (inverse * inverse * inverse) * f(place * inverse);
                }
            }
        }
        total * step * a * b * d
    }

    /// The boundary of what is left of it, and where `further · x ≥ 0`, piece by piece.
    #[inline(always)]
    fn for_each_piece(&self, further: Option<DVec3>, mut take: impl FnMut(Piece)) {
        if self.count < FEW_PLANES {
            self.cut_by::<FEW_PLANES>(further, &mut take);
        } else {
            self.cut_by::<{ MOST_PLANES + 1 }>(further, &mut take);
        }
    }

    /// The same, where there are at most so many planes.
    fn cut_by<const MOST: usize>(&self, further: Option<DVec3>, take: &mut impl FnMut(Piece)) {
        let mut cuts = [Cut::NONE; MOST];
        let mut count = 0;
        let planes = self.planes[..self.count].iter().copied();
        for plane in planes.chain(further) {
            let cut = Cut::new(self, plane);
            match cut.beside(&cuts[..count]) {
                Beside::Nothing => return,
                Beside::All => {}
                Beside::Less => {
                    cuts[count] = cut;
                    count += 1;
                }
            }
        }
        let cuts = &cuts[..count];
        for_each_arc::<MOST>(cuts, take);
        for place in 0..cuts.len() {
            if let Some([from, to]) = chord(cuts, place) {
                take(Piece::Edge([from, to].map(|[x, y]| self.at(x, y))));
            }
        }
    }
}

/// The arcs of the outline that are inside of so many cuts at most.
fn for_each_arc<const MOST: usize>(cuts: &[Cut], take: &mut impl FnMut(Piece)) {
    use std::f64::consts::TAU;
    let mut turns = [[0.0; 2]; MOST];
    let turns = turns.as_flattened_mut();
    let mut count = 0;
    for turn in cuts.iter().filter_map(|cut| cut.turns).flatten() {
        turns[count] = if turn < 0.0 { turn + TAU } else { turn };
        count += 1;
    }
    let is_inside = |turn: f64| {
        let (sin, cos) = libm::sincos(turn);
        cuts.iter().all(|cut| cut.height([cos, sin]) >= 0.0)
    };
    let turns = &mut turns[..count];
    turns.sort_unstable_by(f64::total_cmp);
    let Some(&first) = turns.first() else {
        if is_inside(0.0) {
            take(Piece::Arc([0.0, TAU]));
        }
        return;
    };
    for place in 0..count {
        let from = turns[place];
        let to = turns.get(place + 1).copied().unwrap_or(first + TAU);
        if to > from && is_inside(0.5 * (from + to)) {
            take(Piece::Arc([from, to]));
        }
    }
}

/// An elliptic cone that no plane has cut.
#[derive(Clone, Copy, Debug)]
pub(super) struct WholeCone {
    frame: [DVec3; 3],
    radii: [f64; 3],
}

impl WholeCone {
    fn cone(&self) -> Conic {
        Conic::new(self.frame, self.radii)
    }

    pub(super) fn axis(&self) -> DVec3 {
        self.frame[2]
    }

    /// e₁ b, e₂ d and ê a of the outline.
    pub(super) fn outline(&self) -> [DVec3; 3] {
        let [b, d, a] = self.radii;
        let [e1, e2, axis] = self.frame;
        [e1 * b, e2 * d, axis * a]
    }

    /// A vector as it is where the cone is x² + y² = z², z > 0.
    pub(super) fn round(&self, vector: DVec3) -> DVec3 {
        let [b, d, a] = self.radii;
        let [x, y, z] = self.frame.map(|axis| axis.dot(vector));
        DVec3::new(x / b, y / d, z / a)
    }

    /// Whether a direction is inside.
    pub(super) fn holds(&self, vector: DVec3) -> bool {
        let q = self.round(vector);
        q.z > 0.0 && q.x * q.x + q.y * q.y <= q.z * q.z
    }

    /// Where a convex polygon is, which runs against the clock as it is seen from the origin.
    pub(super) fn side_of(&self, corners: &[DVec3]) -> Side {
        let [b, d, a] = self.radii;
        let scale = DVec3::new(1.0 / b, 1.0 / d, 1.0 / a);
        let round = |corner: DVec3| {
            let [x, y, z] = self.frame.map(|axis| axis.dot(corner));
            DVec3::new(x, y, z) * scale
        };
        let is_inside = |q: DVec3| q.z > 0.0 && q.x * q.x + q.y * q.y <= q.z * q.z;
        let (mut are_inside, mut nearest, mut ratio) = (true, DVec3::ZERO, f64::INFINITY);
        let mut is_in_front = false;
        for &corner in corners {
            let q = round(corner);
            are_inside &= is_inside(q);
            is_in_front |= q.z > 0.0;
            let square = q.x * q.x + q.y * q.y;
            if q.z > 0.0 && square < ratio * (q.z * q.z) {
                (nearest, ratio) = (q, square / (q.z * q.z));
            }
        }
        if are_inside {
            return Side::Inside;
        }
        if !is_in_front {
            return Side::Outside;
        }
        let is_beyond = |plane: DVec3| {
            let is_cone_outside = plane.z + libm::hypot(plane.x, plane.y) <= 0.0;
            // Planes through ends that are close to each other may be anywhere.
            is_cone_outside
                && corners
                    .iter()
                    .all(|&corner| plane.dot(round(corner)) >= 0.0)
        };
        let length = libm::hypot(nearest.x, nearest.y);
        if ratio > 1.0 && length > 0.0 {
            let tangent = DVec3::new(nearest.x / length, nearest.y / length, -1.0);
            if corners
                .iter()
                .all(|&corner| tangent.dot(round(corner)) >= 0.0)
            {
                return Side::Outside;
            }
        }
        let mut before = corners.last().map_or(DVec3::ZERO, |&corner| round(corner));
        for &corner in corners {
            let q = round(corner);
            let plane = before.cross(q - before);
            // The edge itself is on both sides of its plane, as it is rounded.
            if is_beyond(plane + DVec3::Z * (1e-15 * plane.abs().element_sum())) {
                return Side::Outside;
            }
            before = q;
        }
        Side::Across
    }

    /// What of it is inside of a convex polygon, which runs against the clock as it is seen from the origin. `None`
    /// where too many edges cut it.
    pub(super) fn within(&self, corners: &[DVec3]) -> Option<Conic> {
        let mut part = self.cone();
        let mut before = *corners.last()?;
        for &corner in corners {
            let plane = across(before, corner);
            // A plane through a long and a short vector is rounded as what it is made of.
            let rounding = SLACK * l1(plane).max(l1(before) * l1(corner - before));
            let is_edge = |other: DVec3| plane.dot(other) >= -rounding * l1(other);
            let local = part.local(plane);
            // Planes through ends that are close to each other may be anywhere; what they cut off is as small.
            if part.cuts(local) && corners.iter().all(|&other| is_edge(other)) {
                *part.planes.get_mut(part.count)? = local;
                part.count += 1;
            }
            before = corner;
        }
        Some(part)
    }

    /// The corners of a polygon around all of it, against the clock as they are seen from the origin.
    pub(super) fn around(&self) -> [DVec3; 4] {
        // No edge may cut it as numbers are rounded.
        const MORE: f64 = 1.0 + 1e-9;
        [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].map(|[x, y]| {
            let [b, d, a] = self.radii;
            self.frame[0] * (b * x * MORE) + self.frame[1] * (d * y * MORE) + self.frame[2] * a
        })
    }
}

/// A plane through the point, as it cuts the disk in which x = cos t, y = sin t.
#[derive(Clone, Copy, Debug)]
struct Cut {
    /// Of unit length; inside is where x n + offset ≥ 0.
    normal: [f64; 2],
    offset: f64,
    /// Where the outline comes in and goes out, the second after the first, if it does; from −π to 3π.
    turns: Option<[f64; 2]>,
    /// Half the length of its chord, and the ends of it, in the sense of the outline.
    half: f64,
    ends: [[f64; 2]; 2],
}

/// What a cut leaves of what others before it have left.
enum Beside {
    Nothing,
    All,
    Less,
}

impl Cut {
    const NONE: Self = Self {
        normal: [0.0; 2],
        offset: 1.0,
        turns: None,
        half: 0.0,
        ends: [[0.0; 2]; 2],
    };

    fn new(conic: &Conic, plane: DVec3) -> Self {
        let [b, d, a] = conic.radii;
        let normal = [plane.x * b, plane.y * d];
        let offset = plane.z * a;
        let length = libm::hypot(normal[0], normal[1]);
        let side = offset;
        let offset = offset / length;
        let half = ((1.0 - offset) * (1.0 + offset)).max(0.0).sqrt();
        // One that touches it cuts nothing off.
        let is_across = length > side.abs() && half > 0.0;
        if !is_across {
            return Self {
                offset: if side > 0.0 { 1.0 } else { -1.0 },
                ..Self::NONE
            };
        }
        let middle = libm::atan2(normal[1], normal[0]);
        let turn = libm::atan2(((length - side) * (length + side)).sqrt(), -side);
        let cut = Self {
            normal: normal.map(|part| part / length),
            offset,
            turns: Some([middle - turn, middle + turn]),
            half,
            ends: Self::NONE.ends,
        };
        Self {
            ends: [-half, half].map(|s| cut.at(s)),
            ..cut
        }
    }

    fn height(&self, [x, y]: [f64; 2]) -> f64 {
        self.normal[0] * x + self.normal[1] * y + self.offset
    }

    /// A place on its chord, so far from the middle of it. The outline goes against the clock; inside is to the left of
    /// the chord.
    fn at(&self, s: f64) -> [f64; 2] {
        let [x, y] = self.normal;
        [-self.offset * x + s * y, -self.offset * y - s * x]
    }

    /// How far along the chord a place is.
    fn along(&self, [x, y]: [f64; 2]) -> f64 {
        x * self.normal[1] - y * self.normal[0]
    }

    /// How far the ends of another chord are inside.
    fn heights_of(&self, other: &Self) -> [f64; 2] {
        other.ends.map(|end| self.height(end))
    }

    /// What it leaves, as far as any integral tells, where it does not cut the disk or goes along another.
    fn beside(&self, others: &[Self]) -> Beside {
        if self.turns.is_none() {
            return if self.offset > 0.0 {
                Beside::All
            } else {
                Beside::Nothing
            };
        }
        let is_along = |other: &&Self| {
            let heights = other.heights_of(self);
            heights.iter().all(|height| height.abs() <= SAME_PLANE)
        };
        match others.iter().find(is_along) {
            None => Beside::Less,
            // What two leave that face each other is too narrow.
            Some(other) if self.faces(other) => Beside::Nothing,
            Some(_) => Beside::All,
        }
    }

    fn faces(&self, other: &Self) -> bool {
        let ([x, y], [other_x, other_y]) = (self.normal, other.normal);
        x * other_x + y * other_y < 0.0
    }
}

/// Of the chord along one cut, what is inside of the others, in the sense of the outline.
///
/// Two chords end in the same place where they cross: how rounding moves it along both, where there is a small angle between
/// them, is then nothing beside what they enclose.
fn chord(cuts: &[Cut], place: usize) -> Option<[[f64; 2]; 2]> {
    let cut = &cuts[place];
    let [mut from, mut to] = [-cut.half, cut.half];
    for (other_place, other) in cuts.iter().enumerate() {
        if other_place == place {
            continue;
        }
        let is_first = place < other_place;
        let (first, second) = if is_first { (cut, other) } else { (other, cut) };
        let [start, end] = second.heights_of(first);
        if (start < 0.0) == (end < 0.0) {
            let [start, end] = other.heights_of(cut);
            if start + end < 0.0 {
                return None;
            }
            continue;
        }
        let crossing = -first.half + 2.0 * first.half * (start / (start - end));
        let crossing = if is_first {
            crossing
        } else {
            cut.along(first.at(crossing))
        };
        // What is inside of the other begins on the one there and ends on the other.
        if (start < 0.0) == is_first {
            from = from.max(crossing);
        } else {
            to = to.min(crossing);
        }
    }
    (from < to).then(|| [cut.at(from), cut.at(to)])
}
