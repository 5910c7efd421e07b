//! What two elliptic cones have in common.
//!
//! The outline g(t) of the one, seen so that the other is x² + y² = z², crosses it where
//! F(t) = x² + y² − z² = c₀ + c₁ cos t + s₁ sin t + c₂ cos 2t + s₂ sin 2t is 0: at four places at most. Between two
//! of them that follow each other, what both have in common is a segment of that one of which the outline is
//! inside; within all chords it is a polygon.

use std::f64::consts::{PI, TAU};

use super::conic::WholeCone;
use crate::math::DVec3;

/// How two cones are to each other.
#[derive(Clone, Copy, Debug)]
pub(super) enum Meeting {
    Apart,
    /// The first is inside of the second.
    FirstInside,
    SecondInside,
    Crossing(Crossing),
    /// They touch, or nearly.
    Unknown,
}

/// Where the outlines of two cones cross.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    /// Against the clock, as they are seen from the point.
    places: [DVec3; 4],
    /// Whether the outline of the first is inside of the second, from each place to the next.
    is_first_inside: [bool; 4],
    count: usize,
}

/// c₀, [c₁, s₁], [c₂, s₂], and how far all of the first and second derivatives are from 0 at most.
struct Wave {
    constant: f64,
    once: [f64; 2],
    twice: [f64; 2],
    bend: f64,
}

/// Zeros of a wave, in order.
struct Zeros {
    turns: [f64; 4],
    count: usize,
}

/// Where a wave has no zero, or just one, over spans so narrow in radians, or nothing is said of it.
const NARROWEST: f64 = 1e-7;

impl Wave {
    /// Value and slope.
    fn at(&self, turn: f64) -> [f64; 2] {
        let (sin, cos) = libm::sincos(turn);
        let [sin_twice, cos_twice] = [2.0 * sin * cos, (cos - sin) * (cos + sin)];
        let [[c1, s1], [c2, s2]] = [self.once, self.twice];
        [
            self.constant + c1 * cos + s1 * sin + c2 * cos_twice + s2 * sin_twice,
            s1 * cos - c1 * sin + 2.0 * (s2 * cos_twice - c2 * sin_twice),
        ]
    }

    /// `None` where two may be one.
    fn zeros(&self) -> Option<Zeros> {
        const SPANS: u32 = 6;
        let mut zeros = Zeros {
            turns: [0.0; 4],
            count: 0,
        };
        let half = PI / f64::from(SPANS);
        for span in 0..SPANS {
            self.zeros_within(half * f64::from(2 * span + 1), half, &mut zeros)?;
        }
        Some(zeros)
    }

    fn zeros_within(&self, middle: f64, half: f64, zeros: &mut Zeros) -> Option<()> {
        let [value, slope] = self.at(middle);
        let curve = self.bend * half;
        if value.abs() > (slope.abs() + 0.5 * curve) * half {
            return Some(());
        }
        if slope.abs() > curve {
            let [from, to] = [middle - half, middle + half];
            let [start, end] = [from, to].map(|turn| self.at(turn)[0] >= 0.0);
            if start != end {
                *zeros.turns.get_mut(zeros.count)? = self.zero_between(from, to);
                zeros.count += 1;
            }
            return Some(());
        }
        if half < NARROWEST {
            return None;
        }
        let half = 0.5 * half;
        self.zeros_within(middle - half, half, zeros)?;
        self.zeros_within(middle + half, half, zeros)
    }

    /// Newton's steps, within the ends, between which the wave rises or falls all the way.
    fn zero_between(&self, mut from: f64, mut to: f64) -> f64 {
        let is_rising = self.at(from)[0] < 0.0;
        let mut turn = 0.5 * (from + to);
        for _ in 0..60 {
            let [value, slope] = self.at(turn);
            if (value < 0.0) == is_rising {
                from = turn;
            } else {
                to = turn;
            }
            let next = turn - value / slope;
            let next = if next > from && next < to {
                next
            } else {
                0.5 * (from + to)
            };
            if (next - turn).abs() <= 1e-16 * TAU {
                return next;
            }
            turn = next;
        }
        turn
    }
}

/// How two cones are to each other.
pub(super) fn meeting(first: &WholeCone, second: &WholeCone) -> Meeting {
    let outline = first.outline();
    let [p, q, s] = outline.map(|vector| second.round(vector));
    let form = |a: DVec3, b: DVec3| a.x * b.x + a.y * b.y - a.z * b.z;
    let (pp, qq) = (form(p, p), form(q, q));
    let once = [2.0 * form(p, s), 2.0 * form(q, s)];
    let twice = [0.5 * (pp - qq), form(p, q)];
    let wave = Wave {
        constant: 0.5 * (pp + qq) + form(s, s),
        once,
        twice,
        bend: libm::hypot(once[0], once[1]) + 4.0 * libm::hypot(twice[0], twice[1]),
    };
    let Some(zeros) = wave.zeros() else {
        return Meeting::Unknown;
    };
    let at = |turn: f64| {
        let (sin, cos) = libm::sincos(turn);
        outline[0] * cos + outline[1] * sin + outline[2]
    };
    // The form is that of the opposite cone as well.
    let is_in_front = |turn: f64| {
        let (sin, cos) = libm::sincos(turn);
        p.z * cos + q.z * sin + s.z > 0.0
    };
    let mut turns = [0.0; 4];
    let mut count = 0;
    for &turn in &zeros.turns[..zeros.count] {
        if is_in_front(turn) {
            turns[count] = turn;
            count += 1;
        }
    }
    let is_inside = |turn: f64| wave.at(turn)[0] < 0.0 && is_in_front(turn);
    if count == 0 {
        return if is_inside(0.0) {
            Meeting::FirstInside
        } else if first.holds(second.axis()) {
            Meeting::SecondInside
        } else {
            Meeting::Apart
        };
    }
    let mut crossing = Crossing {
        places: [DVec3::ZERO; 4],
        is_first_inside: [false; 4],
        count,
    };
    for (place, &turn) in turns[..count].iter().enumerate() {
        let next = if place + 1 < count {
            turns[place + 1]
        } else {
            turns[0] + TAU
        };
        crossing.places[place] = at(turn);
        crossing.is_first_inside[place] = is_inside(0.5 * (turn + next));
    }
    // What touches is no crossing.
    if count % 2 == 1 {
        return Meeting::Unknown;
    }
    Meeting::Crossing(crossing)
}

impl Crossing {
    /// Two or four.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// From each place to the next, and whether the outline of the first is inside of the second there.
    pub(super) fn chords(&self) -> impl Iterator<Item = ([DVec3; 2], bool)> {
        (0..self.count).map(|place| {
            let next = (place + 1) % self.count;
            (
                [self.places[place], self.places[next]],
                self.is_first_inside[place],
            )
        })
    }
}
