//! Polygons, convex and concave, into triangles.
//!
//! Ear clipping (Meisters 1975; Eberly, "Triangulation by ear clipping", 2002) in the plane of
//! the polygon's Newell normal. Every corner becomes a corner of a triangle with area, those in
//! the middle of a straight edge too: a neighbor may have a vertex there, and a triangle edge
//! that passes it by would leave a crack. A polygon that crosses itself still becomes n − 2
//! triangles, and is reported. The tests are counted and bounded for the whole file, so that no
//! file takes more than linear time; a general triangulation library promises neither.

use std::collections::{TryReserveError, VecDeque};

use super::error::Fault;
use super::limits::MAX_CORNERS;

/// The work that any file may take, whatever its size: tests of one corner against the bounds of
/// one ear, of about a nanosecond each.
///
/// A spiral of 15 000 corners takes 1.1 · 10⁸ of them.
const BASE_TESTS: u64 = 150_000_000;

/// The tests that a file may take beside, for each of its bytes.
const TESTS_PER_BYTE: u64 = 100;

/// What the test of a corner within the bounds of an ear counts.
const WITHIN_BOUNDS: usize = 8;

/// The area below which a triangle is flat, relative to the square of the polygon's extent:
/// what the rounding of coordinates to f32 makes of no area at all.
const FLAT: f64 = 1e-7;

/// Cuts polygons into triangles; keeps its memory from one to the next.
#[derive(Debug)]
pub(super) struct Triangulator {
    /// Tests that may still be made.
    tests_left: u64,
    corners: Vec<Corner>,
    triangles: Vec<[u32; 3]>,
    /// Corners that may be ears.
    candidates: VecDeque<u32>,
    /// Corners that no ear may contain, all that are not convex: their places and numbers.
    blockers: Vec<([f64; 2], u32)>,
}

/// A polygon in triangles.
#[derive(Debug)]
pub(super) struct Triangulation<'a> {
    /// Three corner numbers each, wound as the polygon is.
    pub(super) triangles: &'a [[u32; 3]],
    /// Whether some triangles are turned over or overlap, as in a polygon that crosses itself.
    pub(super) folded: bool,
}

/// A corner of the polygon, in its plane.
#[derive(Clone, Copy, Debug)]
struct Corner {
    position: [f64; 2],
    previous: u32,
    next: u32,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Convex,
    /// Concave or straight.
    Blocking,
    Cut,
}

impl Triangulator {
    /// For the polygons of a file of `size` bytes.
    pub(super) fn for_file(size: usize) -> Self {
        Self {
            tests_left: (size as u64)
                .saturating_mul(TESTS_PER_BYTE)
                .saturating_add(BASE_TESTS),
            corners: Vec::new(),
            triangles: Vec::new(),
            candidates: VecDeque::new(),
            blockers: Vec::new(),
        }
    }

    /// Cuts the polygon with these corners, 3 to [`MAX_CORNERS`] of them.
    pub(super) fn triangulate(
        &mut self,
        positions: impl ExactSizeIterator<Item = [f64; 3]> + Clone,
    ) -> Result<Triangulation<'_>, Box<Fault>> {
        let count = positions.len();
        debug_assert!((3..=MAX_CORNERS).contains(&count), "{count} corners");
        self.make_room(count).map_err(|_| Fault::NoMemory)?;
        self.triangles.clear();
        let extent = self.project(positions);
        if count == 4 {
            self.split_quad();
        } else if self.fan_is_whole() {
            self.fan(0);
        } else {
            self.clip_ears()?;
        }
        let least = -FLAT * extent * extent;
        let folded = self
            .triangles
            .iter()
            .any(|&[a, b, c]| self.area(a, b, c) < least);
        Ok(Triangulation {
            triangles: &self.triangles,
            folded,
        })
    }

    /// Room for all that cutting `count` corners takes.
    fn make_room(&mut self, count: usize) -> Result<(), TryReserveError> {
        // What is there already is kept to be cleared.
        let more = |len: usize| count.saturating_sub(len);
        self.corners.try_reserve(more(self.corners.len()))?;
        self.triangles.try_reserve(more(self.triangles.len()))?;
        self.blockers.try_reserve(more(self.blockers.len()))?;
        // Each ear makes two corners candidates again.
        let candidates = (3 * count).saturating_sub(self.candidates.len());
        self.candidates.try_reserve(candidates)
    }

    /// Projects the corners along the axis that is nearest to the Newell normal, so that the
    /// polygon is counter-clockwise; the extent of the polygon.
    ///
    /// Leaving out a coordinate keeps the others exact.
    fn project(&mut self, positions: impl ExactSizeIterator<Item = [f64; 3]> + Clone) -> f64 {
        /// Extents whose cubes neither underflow nor overflow.
        const USUAL: std::ops::RangeInclusive<f64> = 1e-90..=1e90;
        let count = positions.len() as u32;
        let origin = positions.clone().next().unwrap_or_default();
        let extent_at = |scale: f64| {
            let offsets = positions
                .clone()
                .flat_map(|p| [0, 1, 2].map(|i| (p[i] * scale - origin[i] * scale).abs()));
            offsets.fold(0.0, f64::max)
        };
        let (scale, extent) = match extent_at(1.0) {
            extent if USUAL.contains(&extent) || extent == 0.0 => (1.0, extent),
            // Halved, the difference of any two numbers is finite.
            _ => (0.5 / extent_at(0.5).max(f64::MIN_POSITIVE), 1.0),
        };
        let offsets = positions.map(|p| [0, 1, 2].map(|i| p[i] * scale - origin[i] * scale));

        // Twice the polygon's area vector (Newell's method), from its first corner.
        let mut normal = [0.0; 3];
        let mut last = [0.0; 3];
        for offset in offsets.clone() {
            let cross = super::cross(last, offset);
            normal = [0, 1, 2].map(|i| normal[i] + cross[i]);
            last = offset;
        }
        let size = normal.map(f64::abs);
        let axis = if size[0] > size[1] && size[0] > size[2] {
            0
        } else if size[1] > size[2] {
            1
        } else {
            2
        };
        let (u, v) = match (axis, normal[axis] < 0.0) {
            (0, false) => (1, 2),
            (0, true) => (2, 1),
            (1, false) => (2, 0),
            (1, true) => (0, 2),
            (_, false) => (0, 1),
            (_, true) => (1, 0),
        };
        self.corners.clear();
        self.corners
            .extend((0..count).zip(offsets).map(|(i, offset)| Corner {
                position: [offset[u], offset[v]],
                previous: if i == 0 { count - 1 } else { i - 1 },
                next: if i + 1 == count { 0 } else { i + 1 },
                state: State::Convex,
            }));
        extent
    }

    fn corner(&self, corner: u32) -> &Corner {
        &self.corners[corner as usize]
    }

    /// Twice the area of a triangle of three corners, positive where counter-clockwise.
    fn area(&self, a: u32, b: u32, c: u32) -> f64 {
        let [a, b, c] = [a, b, c].map(|corner| self.corner(corner).position);
        area(a, b, c)
    }

    /// Four corners: the diagonal whose triangles both have area, from the first corner if that
    /// is one.
    fn split_quad(&mut self) {
        let least = |a: [u32; 3], b: [u32; 3]| {
            let [a, b] = [a, b].map(|[i, j, k]| self.area(i, j, k));
            a.min(b)
        };
        let first = [[0, 1, 2], [0, 2, 3]];
        let second = [[0, 1, 3], [1, 2, 3]];
        let from_first = least(first[0], first[1]);
        let chosen = if from_first > 0.0 || from_first >= least(second[0], second[1]) {
            first
        } else {
            second
        };
        self.triangles.extend(chosen);
    }

    /// Whether the fan around corner 0 covers the polygon with triangles that all have area.
    ///
    /// Seen from corner 0, every other corner is then further counter-clockwise than the one
    /// before it, and none further than half a turn.
    fn fan_is_whole(&self) -> bool {
        let last = self.corners.len() as u32 - 1;
        (1..last).all(|i| self.area(0, i, i + 1) > 0.0 && self.area(0, 1, i + 1) > 0.0)
    }

    /// The fan around `center` of all corners that are not cut yet.
    fn fan(&mut self, center: u32) {
        let mut b = self.corner(center).next;
        loop {
            let c = self.corner(b).next;
            if c == center {
                return;
            }
            self.triangles.push([center, b, c]);
            b = c;
        }
    }

    /// Cuts ears until three corners are left.
    ///
    /// Cutting an ear changes what can be said of its two neighbors only, so each corner is
    /// looked at once, and again when a neighbor is cut.
    fn clip_ears(&mut self) -> Result<(), Box<Fault>> {
        let count = self.corners.len() as u32;
        self.blockers.clear();
        for corner in 0..count {
            if !self.is_convex(corner) {
                self.corners[corner as usize].state = State::Blocking;
                self.blockers.push((self.corner(corner).position, corner));
            }
        }
        self.candidates.clear();
        // Every second corner first: better triangles than one after the other, which is a fan.
        self.candidates.extend((0..count).step_by(2));
        self.candidates.extend((1..count).step_by(2));
        let mut left = count;
        let mut start = 0;
        while left > 3
            && let Some(ear) = self.candidates.pop_front()
        {
            if self.corner(ear).state != State::Convex || !self.is_ear(ear)? {
                continue;
            }
            let Corner { previous, next, .. } = *self.corner(ear);
            self.triangles.push([previous, ear, next]);
            self.corners[ear as usize].state = State::Cut;
            self.corners[previous as usize].next = next;
            self.corners[next as usize].previous = previous;
            self.look_again(previous)?;
            self.look_again(next)?;
            left -= 1;
            start = next;
        }
        // The last triangle; or, where the polygon crosses itself or is flat, all that is left.
        self.fan(start);
        Ok(())
    }

    /// After a neighbor of `corner` was cut.
    fn look_again(&mut self, corner: u32) -> Result<(), Box<Fault>> {
        let convex = self.is_convex(corner);
        match (self.corner(corner).state, convex) {
            (State::Blocking, true) => {
                self.corners[corner as usize].state = State::Convex;
                self.count_tests(self.blockers.len())?;
                if let Some(place) = self.blockers.iter().position(|&(_, b)| b == corner) {
                    self.blockers.swap_remove(place);
                }
            }
            (State::Convex, false) => {
                self.corners[corner as usize].state = State::Blocking;
                self.blockers.push((self.corner(corner).position, corner));
            }
            (State::Convex, true) | (State::Blocking, false) | (State::Cut, _) => {}
        }
        if convex {
            self.candidates.push_back(corner);
        }
        Ok(())
    }

    fn is_convex(&self, corner: u32) -> bool {
        let Corner { previous, next, .. } = *self.corner(corner);
        self.area(previous, corner, next) > 0.0
    }

    /// Whether the triangle of a convex corner and its neighbors contains no other corner, on
    /// its edges neither. Corners at the place of one of the three do not count: the two sides
    /// of a slit that joins a hole to the outline meet there.
    fn is_ear(&mut self, ear: u32) -> Result<bool, Box<Fault>> {
        let Corner { previous, next, .. } = *self.corner(ear);
        let [a, b, c] = [previous, ear, next].map(|corner| self.corner(corner).position);
        let low = [0, 1].map(|i| a[i].min(b[i]).min(c[i]));
        let high = [0, 1].map(|i| a[i].max(b[i]).max(c[i]));
        let mut within_bounds = 0;
        // All conditions of a step at once: no branch among them is predictable.
        let blocked = self.blockers.iter().position(|&(p, _)| {
            let near = (p[0] >= low[0]) & (p[0] <= high[0]) & (p[1] >= low[1]) & (p[1] <= high[1]);
            within_bounds += usize::from(near);
            near && (area(a, b, p) >= 0.0)
                & (area(b, c, p) >= 0.0)
                & (area(c, a, p) >= 0.0)
                & !(same(p, a) | same(p, b) | same(p, c))
        });
        let tested = blocked.map_or(self.blockers.len(), |last| last + 1);
        self.count_tests(tested + WITHIN_BOUNDS * within_bounds)?;
        Ok(blocked.is_none())
    }

    fn count_tests(&mut self, tests: usize) -> Result<(), Box<Fault>> {
        self.tests_left = self
            .tests_left
            .checked_sub(tests as u64)
            .ok_or(Box::new(Fault::TooIntricate))?;
        Ok(())
    }
}

/// Twice the area of the triangle a b c, positive where counter-clockwise.
#[inline]
fn area(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether two corners are at the same place.
#[inline]
fn same(a: [f64; 2], b: [f64; 2]) -> bool {
    (a[0] == b[0]) & (a[1] == b[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Areas are sums of a few products of numbers of order 1.
    const ROUNDING: f64 = 1e-12;

    /// A triangulation of a polygon in the plane z = 0, with everything checked that makes it
    /// one: n − 2 triangles that use every corner, none turned over, of the polygon's area.
    /// Triangles of positive area whose sum is the area of a simple polygon that they cover
    /// do not overlap.
    #[track_caller]
    fn checked(outline: &[[f64; 2]]) -> Vec<[u32; 3]> {
        let positions: Vec<[f64; 3]> = outline.iter().map(|&[x, y]| [x, y, 0.0]).collect();
        let mut triangulator = Triangulator::for_file(0);
        let result = triangulator.triangulate(positions.iter().copied()).unwrap();
        assert!(!result.folded, "{outline:?} {:?}", result.triangles);
        let triangles = result.triangles.to_vec();
        assert_eq!(triangles.len(), outline.len() - 2);
        for corner in 0..outline.len() as u32 {
            assert!(triangles.iter().flatten().any(|&used| used == corner));
        }
        let [mut sum, mut outline_area] = [0.0; 2];
        for (i, &p) in outline.iter().enumerate() {
            outline_area += area([0.0; 2], p, outline[(i + 1) % outline.len()]);
        }
        for &[a, b, c] in &triangles {
            let [a, b, c] = [a, b, c].map(|i| outline[i as usize]);
            assert!(area(a, b, c) * outline_area.signum() >= 0.0, "turned over");
            sum += area(a, b, c);
        }
        assert!(
            (sum - outline_area).abs() <= ROUNDING * outline_area.abs(),
            "{sum} instead of {outline_area}: {outline:?} {triangles:?}"
        );
        triangles
    }

    /// As `checked`, and every triangle has area: the polygon's straight corners are kept.
    #[track_caller]
    fn checked_with_area(outline: &[[f64; 2]]) {
        for [a, b, c] in checked(outline) {
            let [a, b, c] = [a, b, c].map(|i| outline[i as usize]);
            assert!(area(a, b, c).abs() > 0.0, "a triangle without area");
        }
    }

    /// The outline and its mirror image, from every corner.
    #[track_caller]
    fn checked_all_ways(outline: &[[f64; 2]]) {
        let mut turned = outline.to_vec();
        for _ in 0..outline.len() {
            turned.rotate_left(1);
            checked_with_area(&turned);
            let reversed: Vec<_> = turned.iter().rev().copied().collect();
            checked_with_area(&reversed);
        }
    }

    fn random(state: &mut u64) -> f64 {
        *state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (*state >> 11) as f64 / (1_u64 << 53) as f64
    }

    #[test]
    fn quads() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        assert_eq!(checked(&square), [[0, 1, 2], [0, 2, 3]]);
        // Concave at each corner in turn, and straight at one.
        checked_all_ways(&[[0.0, 0.0], [2.0, -1.0], [0.5, 0.5], [-1.0, 2.0]]);
        checked_all_ways(&[[0.0, 0.0], [2.0, 0.0], [1.0, 1.0], [0.0, 2.0]]);
    }

    #[test]
    fn letters() {
        let l = [[0., 0.], [3., 0.], [3., 1.], [1., 1.], [1., 3.], [0., 3.]];
        checked_all_ways(&l);
        let u = [
            [0., 0.],
            [3., 0.],
            [3., 3.],
            [2., 3.],
            [2., 1.],
            [1., 1.],
            [1., 3.],
            [0., 3.],
        ];
        checked_all_ways(&u);
        let e = [
            [0., 0.],
            [3., 0.],
            [3., 1.],
            [1., 1.],
            [1., 2.],
            [3., 2.],
            [3., 3.],
            [1., 3.],
            [1., 4.],
            [3., 4.],
            [3., 5.],
            [0., 5.],
        ];
        checked_all_ways(&e);
    }

    #[test]
    fn straight_corners_are_kept() {
        let mut outline = Vec::new();
        for i in 0..5 {
            outline.push([f64::from(i), 0.0]);
        }
        for i in 0..5 {
            outline.push([5.0, f64::from(i)]);
        }
        for i in 0..5 {
            outline.push([5.0 - f64::from(i), 5.0]);
        }
        outline.push([0.0, 5.0]);
        checked_all_ways(&outline);
    }

    #[test]
    fn star_shaped_polygons_of_all_sizes() {
        let mut state = 7;
        for count in (3..60).chain([257, 1000, 3000]) {
            let outline: Vec<[f64; 2]> = (0..count)
                .map(|i| {
                    let angle = f64::from(i) / f64::from(count) * std::f64::consts::TAU;
                    let radius = 0.2 + random(&mut state);
                    [radius * angle.cos(), radius * angle.sin()]
                })
                .collect();
            checked_with_area(&outline);
        }
    }

    /// Two arms, one inside the other: concave all along and not star-shaped.
    #[test]
    fn spiral() {
        let arm = |inner: f64| {
            (0..200).map(move |i| {
                let angle = f64::from(i) * 0.1;
                let radius = 1.0 + angle - inner;
                [radius * angle.cos(), radius * angle.sin()]
            })
        };
        let outline: Vec<_> = arm(0.0).chain(arm(0.5).rev()).collect();
        checked_with_area(&outline);
    }

    #[test]
    fn hole_joined_by_a_slit() {
        let outline = [
            [0., 0.],
            [4., 0.],
            [4., 4.],
            [0., 4.],
            [0., 0.],
            [1., 1.],
            [1., 3.],
            [3., 3.],
            [3., 1.],
            [1., 1.],
        ];
        checked(&outline);
        let reversed: Vec<_> = outline.iter().rev().copied().collect();
        checked(&reversed);
    }

    /// Random holes below the top edge, each joined to it by a slit of its own.
    #[test]
    fn many_holes_joined_by_slits() {
        let mut state = 11;
        for holes in 1..40 {
            let mut outline = vec![[0.0, 0.0], [f64::from(holes), 0.0], [f64::from(holes), 1.0]];
            for hole in (0..holes).rev() {
                let [x, y] = [f64::from(hole) + 0.5, 0.3 + 0.4 * random(&mut state)];
                let corners = 3 + (random(&mut state) * 6.0) as u32;
                let radius = 0.1 + 0.15 * random(&mut state);
                outline.push([x, 1.0]);
                // Clockwise from the top of the hole, around to it again.
                outline.extend((0..=corners).map(|corner| {
                    let turn = f64::from(corner % corners) / f64::from(corners);
                    let angle = turn * std::f64::consts::TAU;
                    [x + radius * angle.sin(), y + radius * angle.cos()]
                }));
                outline.push([x, 1.0]);
            }
            outline.push([0.0, 1.0]);
            checked(&outline);
            outline.reverse();
            checked(&outline);
        }
    }

    #[test]
    fn any_plane_and_any_size() {
        // The letter L, 5 units of area, in planes through (1, 2, 3).
        let l = [[0., 0.], [3., 0.], [3., 1.], [1., 1.], [1., 3.], [0., 3.]];
        for (u, v) in [
            ([1., 0., 0.], [0., 1., 0.]),
            ([0., 1., 0.], [0., 0., 1.]),
            ([0., 0., 1.], [1., 0., 0.]),
            ([0., 1., 0.], [1., 0., 0.]),
            ([0.6, 0.8, 0.], [0., 0., 1.]),
            ([0.6, 0., -0.8], [0.64, 0.6, 0.48]),
        ] {
            for size in [1e-300, 1e-120, 1e-3, 1.0, 1e3, 1e120, 1e300] {
                let positions = l
                    .map(|[x, y]| [0, 1, 2].map(|i| ((i + 1) as f64 + x * u[i] + y * v[i]) * size));
                let mut triangulator = Triangulator::for_file(0);
                let result = triangulator.triangulate(positions.into_iter()).unwrap();
                assert!(!result.folded);
                let mut sum = 0.0;
                for &[a, b, c] in result.triangles {
                    let [a, b, c] = [a, b, c].map(|i| positions[i as usize].map(|x| x / size));
                    let edge = |p: [f64; 3]| [0, 1, 2].map(|i| p[i] - a[i]);
                    let cross = super::super::cross(edge(b), edge(c));
                    let normal = super::super::cross(u, v);
                    let along: f64 = (0..3).map(|i| cross[i] * normal[i]).sum();
                    assert!(along > 0.0, "wound the other way");
                    sum += along / 2.0;
                }
                assert!((sum - 5.0).abs() < 1e-9, "{sum} at size {size}");
            }
        }
    }

    #[test]
    fn polygons_without_area_have_triangles_without_area() {
        for outline in [
            vec![[1.0; 3]; 7],
            (0..9).map(|i| [f64::from(i); 3]).collect(),
        ] {
            let mut triangulator = Triangulator::for_file(0);
            let result = triangulator.triangulate(outline.iter().copied()).unwrap();
            assert_eq!(result.triangles.len(), outline.len() - 2);
            assert!(!result.folded);
        }
    }

    #[test]
    fn crossed_polygons_are_reported() {
        for outline in [
            vec![[0., 0., 0.], [1., 1., 0.], [1., 0., 0.], [0., 2., 0.]],
            vec![
                [0., 0., 0.],
                [2., 2., 0.],
                [2., 0., 0.],
                [1., 0.1, 0.],
                [0., 3., 0.],
            ],
        ] {
            let mut triangulator = Triangulator::for_file(0);
            let result = triangulator.triangulate(outline.iter().copied()).unwrap();
            assert_eq!(result.triangles.len(), outline.len() - 2);
            assert!(result.folded, "{outline:?}");
        }
    }

    #[test]
    fn work_is_bounded() {
        let mut state = 3;
        let outline: Vec<[f64; 3]> = (0..MAX_CORNERS)
            .map(|_| [random(&mut state), random(&mut state), 0.0])
            .collect();
        let mut triangulator = Triangulator::for_file(0);
        triangulator.tests_left = 1_000_000;
        assert_eq!(
            *triangulator.triangulate(outline.into_iter()).unwrap_err(),
            Fault::TooIntricate
        );
    }
}
