//! Into which wavelengths a ray is split where glass disperses it.
//!
//! Each wavelength of the grid takes a way of its own. How much of the light arrives by these ways is smooth, but where
//! one begins to meet something else. So some are looked along first, and the spectrum is cut into intervals until in
//! each five ways meet the same, nothing else stands between them, and a polynomial through what they see tells the rest;
//! or until there is a way for each nm. Light then takes these ways, each with the share of the wavelengths around it that
//! the polynomial gives it; where all see the same, it takes one.

use std::collections::BTreeMap;

use crate::math::DVec3;
use crate::spectrum::{FIRST, SAMPLES, Spectrum};

/// Ends of the intervals to begin with, in nm: shorter where refractive indices change fast.
const BEGINNING: [u16; 4] = [360, 440, 560, 830];

/// By how much what a parabola tells of an interval may be off, as a part of the largest of the ray. The polynomial that is
/// taken has two nodes more.
const TOLERANCE: f64 = 1e-5;

/// The same for a polynomial of fewer nodes to be taken.
const TOLERANCE_OF_FEWER: f64 = 1e-8;

/// What is seen along the way of one wavelength.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Seen {
    /// What arrives if all light takes this way.
    pub(super) value: [f64; 3],
    /// All rays of the way, in order.
    pub(super) segments: Vec<Segment>,
    /// Whether some of it was not followed.
    pub(super) is_cut: bool,
}

/// A part of a way between two surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Segment {
    /// From where to where; beyond all shapes where nothing is met.
    pub(super) ends: [DVec3; 2],
    /// The objects there.
    pub(super) objects: [Option<u32>; 2],
}

/// The wavelengths of one ray.
#[derive(Clone, Debug)]
pub(super) struct Spread {
    seen: BTreeMap<u16, Seen>,
    undecided: Vec<Interval>,
    decided: Vec<(Interval, Fit)>,
}

/// Five wavelengths in nm, the first and the last of an interval among them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Interval([u16; 5]);

/// What tells all of an interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fit {
    /// There is nothing.
    Nothing,
    /// The middle.
    Constant,
    /// The ends and the middle.
    Parabola,
    /// All five.
    Quartic,
    /// Each nm has a way of its own.
    Each,
}

impl Fit {
    /// Which of the five it needs.
    fn places(self) -> &'static [usize] {
        match self {
            Self::Nothing | Self::Each => &[],
            Self::Constant => &[2],
            Self::Parabola => &[0, 2, 4],
            Self::Quartic => &[0, 1, 2, 3, 4],
        }
    }
}

impl Interval {
    /// So short that all of its wavelengths are among the five.
    const SHORTEST: u16 = 4;

    fn new(first: u16, last: u16) -> Self {
        let part = |quarters: u16| first + (last - first) * quarters / 4;
        Self([part(0), part(1), part(2), part(3), part(4)])
    }

    fn first(&self) -> u16 {
        self.0[0]
    }

    fn middle(&self) -> u16 {
        self.0[2]
    }

    fn last(&self) -> u16 {
        self.0[4]
    }

    fn is_shortest(&self) -> bool {
        self.last() - self.first() <= Self::SHORTEST
    }

    fn halves(&self) -> [Self; 2] {
        [
            Self::new(self.first(), self.middle()),
            Self::new(self.middle(), self.last()),
        ]
    }

    /// Its own wavelengths: the last one is the first of the next, but at the end of the grid.
    fn own(&self) -> impl Iterator<Item = u16> + use<> {
        let [.., end] = BEGINNING;
        let (first, last) = (self.first(), self.last());
        (first..=last).filter(move |&nm| nm < last || nm == end)
    }

    /// Those of the five that tell the rest.
    fn nodes(&self, fit: Fit) -> impl Iterator<Item = u16> + use<> {
        let five = self.0;
        fit.places().iter().map(move |&place| five[place])
    }
}

impl Spread {
    /// That of the middle of what is seen, in nm.
    pub(super) const MIDDLE: u16 = 555;

    /// A ray of which nothing is known yet.
    pub(super) fn new() -> Self {
        let ends = BEGINNING.windows(2);
        Self {
            seen: BTreeMap::new(),
            undecided: ends.map(|ends| Interval::new(ends[0], ends[1])).collect(),
            decided: Vec::new(),
        }
    }

    /// The wavelengths that are to be looked along next; none where all is known.
    pub(super) fn wanted(&self, mut put: impl FnMut(u16)) {
        let mut last = None;
        let mut wanted: Vec<u16> = self
            .undecided
            .iter()
            .flat_map(|interval| interval.0)
            .collect();
        wanted.sort_unstable();
        for nm in wanted {
            if last != Some(nm) && !self.seen.contains_key(&nm) {
                put(nm);
            }
            last = Some(nm);
        }
    }

    /// Notes what is seen along the way of a wavelength.
    pub(super) fn note(&mut self, nm: u16, seen: Seen) {
        self.seen.insert(nm, seen);
    }

    /// Decides what all wanted wavelengths have told; the rest is cut in halves. `is_free` tells whether nothing but the
    /// objects at their ends is between segments of ways that meet the same.
    pub(super) fn decide(&mut self, mut is_free: impl FnMut([&Segment; 5]) -> bool) {
        let largest = self.seen.values().map(Seen::largest);
        let largest = largest.fold(0.0, f64::max);
        let mut intervals = std::mem::take(&mut self.undecided);
        while let Some(interval) = intervals.pop() {
            let five = interval.0.map(|nm| self.seen.get(&nm));
            let [Some(a), Some(b), Some(c), Some(d), Some(e)] = five else {
                self.undecided.push(interval);
                continue;
            };
            match fit(&interval, [a, b, c, d, e], largest, &mut is_free) {
                Some(fit) => self.decided.push((interval, fit)),
                None => intervals.extend(interval.halves()),
            }
        }
    }

    /// The wavelengths in nm whose ways light takes.
    pub(super) fn ways(&self) -> Vec<u16> {
        let mut ways: Vec<u16> = Vec::new();
        for (interval, fit) in &self.decided {
            match fit {
                Fit::Each => {
                    let is_something = |nm: &u16| !self.seen.get(nm).is_none_or(Seen::is_nothing);
                    ways.extend(interval.own().filter(is_something));
                }
                _ => ways.extend(interval.nodes(*fit)),
            }
        }
        ways.sort_unstable();
        ways.dedup();
        ways
    }

    /// What of each wavelength takes the way of one.
    pub(super) fn share(&self, way: u16) -> Spectrum {
        let mut share = [0.0; SAMPLES];
        for (interval, fit) in &self.decided {
            if !(interval.first()..=interval.last()).contains(&way) {
                continue;
            }
            if *fit == Fit::Each {
                if interval.own().any(|nm| nm == way) {
                    share[place(way)] += 1.0;
                }
                continue;
            }
            let nodes: Vec<u16> = interval.nodes(*fit).collect();
            if let Some(which) = nodes.iter().position(|&node| node == way) {
                for nm in interval.own() {
                    share[place(nm)] += basis(&nodes, which, nm);
                }
            }
        }
        let mut share = share.iter();
        Spectrum::from_fn(|_| share.next().copied().unwrap_or_default())
    }
}

/// What tells all of an interval, five of whose wavelengths see this; `None` where they do not tell.
fn fit(
    interval: &Interval,
    seen: [&Seen; 5],
    largest: f64,
    is_free: &mut impl FnMut([&Segment; 5]) -> bool,
) -> Option<Fit> {
    let is_nothing = seen.iter().all(|seen| seen.is_nothing());
    if interval.is_shortest() {
        return Some(if is_nothing { Fit::Nothing } else { Fit::Each });
    }
    if !seen.iter().all(|other| other.meets_the_same(seen[0])) {
        return None;
    }
    let misses = |fit: Fit| {
        let nodes: Vec<u16> = interval.nodes(fit).collect();
        let mut most: f64 = 0.0;
        for (&nm, of_nm) in interval.0.iter().zip(&seen) {
            let mut off = of_nm.value;
            for (which, &node) in fit.places().iter().enumerate() {
                let weight = basis(&nodes, which, nm);
                for (off, value) in off.iter_mut().zip(seen[node].value) {
                    *off -= weight * value;
                }
            }
            most = off.iter().fold(most, |most, off| most.max(off.abs()));
        }
        most
    };
    let fit = if is_nothing {
        Fit::Nothing
    } else if misses(Fit::Constant) <= TOLERANCE_OF_FEWER * largest {
        Fit::Constant
    } else {
        match misses(Fit::Parabola) / largest {
            off if off <= TOLERANCE_OF_FEWER => Fit::Parabola,
            off if off <= TOLERANCE => Fit::Quartic,
            _ => return None,
        }
    };
    let mut segments = 0..seen[0].segments.len();
    let are_free = segments.all(|place| is_free(seen.map(|seen| &seen.segments[place])));
    are_free.then_some(fit)
}

impl Seen {
    fn is_nothing(&self) -> bool {
        self.largest() == 0.0 && !self.is_cut
    }

    /// Whether two ways meet the same objects, in the same order.
    fn meets_the_same(&self, other: &Self) -> bool {
        fn objects(seen: &Seen) -> impl Iterator<Item = [Option<u32>; 2]> {
            seen.segments.iter().map(|segment| segment.objects)
        }
        self.is_cut == other.is_cut && objects(self).eq(objects(other))
    }

    fn largest(&self) -> f64 {
        let values = self.value.iter();
        values.fold(0.0, |largest, value| f64::max(largest, value.abs()))
    }
}

/// The place of a wavelength on the grid.
fn place(nm: u16) -> usize {
    usize::from(nm) - FIRST as usize
}

/// Lagrange's polynomial that is 1 at one of the nodes and 0 at the others.
fn basis(nodes: &[u16], which: usize, nm: u16) -> f64 {
    let mut value = 1.0;
    for (other, &node) in nodes.iter().enumerate() {
        if other != which {
            value *=
                (f64::from(nm) - f64::from(node)) / (f64::from(nodes[which]) - f64::from(node));
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A spread that has looked along all ways that it wants to, and how many.
    fn looked(
        seen: impl Fn(u16) -> Seen,
        is_free: impl Fn([&Segment; 5]) -> bool,
    ) -> (Spread, usize) {
        let mut spread = Spread::new();
        let mut asked = 0;
        loop {
            let mut wanted = Vec::new();
            spread.wanted(|nm| wanted.push(nm));
            if wanted.is_empty() {
                return (spread, asked);
            }
            asked += wanted.len();
            for nm in wanted {
                spread.note(nm, seen(nm));
            }
            spread.decide(&is_free);
        }
    }

    /// What a spread makes of light that arrives as `seen` tells, wavelength by wavelength, how many were asked and how
    /// many ways it takes.
    fn told(seen: impl Fn(u16) -> Seen) -> ([f64; SAMPLES], usize, usize) {
        let (spread, asked) = looked(&seen, |_| true);
        let ways = spread.ways();
        let mut sums = [0.0; SAMPLES];
        for &way in &ways {
            for (sum, share) in sums.iter_mut().zip(spread.share(way).values()) {
                *sum += share * seen(way).value[1];
            }
        }
        (sums, asked, ways.len())
    }

    fn gray(value: f64) -> Seen {
        Seen {
            value: [value; 3],
            ..Seen::default()
        }
    }

    #[test]
    fn what_is_the_same_everywhere_takes_three_ways() {
        let (sums, asked, ways) = told(|_| gray(0.7));
        assert!(sums.iter().all(|sum| *sum == 0.7));
        assert_eq!((asked, ways), (13, 3));
        // And nothing takes none.
        let (sums, asked, ways) = told(|_| gray(0.0));
        assert!(sums.iter().all(|sum| *sum == 0.0));
        assert_eq!((asked, ways), (13, 0));
    }

    #[test]
    fn what_changes_smoothly_is_told_by_few() {
        // Fresnel's reflectance of a glass that disperses by Cauchy's formula, at 80°.
        let value = |nm: u16| {
            let n = 1.7 + 15_000.0 / f64::from(nm).powi(2);
            1.0 - crate::optics::dielectric(80.0_f64.to_radians().cos(), n)
        };
        let (sums, asked, ways) = told(|nm| gray(value(nm)));
        for (sum, nm) in sums.iter().zip(360..) {
            assert!((sum - value(nm)).abs() < 2e-6, "{nm}: {sum}");
        }
        assert!(asked < 40 && ways < 30, "{asked}, {ways}");
    }

    #[test]
    fn an_edge_is_found_to_the_nm() {
        for edge in [361, 363, 440, 441, 500, 559, 560, 561, 700, 829, 830] {
            let value = |nm: u16| if nm < edge { 0.0 } else { 2.0 };
            let (sums, asked, _) = told(|nm| gray(value(nm)));
            for (sum, nm) in sums.iter().zip(360..) {
                assert!((sum - value(nm)).abs() < 1e-14, "{edge}: {nm}: {sum}");
            }
            assert!(asked < 50, "{asked}");
        }
    }

    /// A way of one ray to a point at x = nm/100.
    fn way(nm: u16, object: u32, value: f64) -> Seen {
        let end = DVec3::new(f64::from(nm) / 100.0, 0.0, 5.0);
        Seen {
            segments: vec![Segment {
                ends: [DVec3::ZERO, end],
                objects: [Some(0), Some(object)],
            }],
            ..gray(value)
        }
    }

    #[test]
    fn where_other_objects_are_met_an_interval_ends() {
        // Both are as bright as each other.
        let (_, asked, ways) = told(|nm| way(nm, u32::from(nm > 600), 1.0));
        assert!((20..40).contains(&asked), "{asked}");
        assert!(ways < 20, "{ways}");
    }

    #[test]
    fn what_is_between_ways_is_looked_for() {
        // A slit that 2 nm see, and that nobody meets who looks at every hundredth.
        let slit = 613..615_u16;
        let seen = |nm: u16| {
            way(
                nm,
                u32::from(slit.contains(&nm)),
                f64::from(u8::from(slit.contains(&nm))),
            )
        };
        let (spread, asked) = looked(seen, |segments| {
            let [first, .., last] = segments.map(|segment| segment.ends[1].x * 100.0);
            let is_beside = last < f64::from(slit.start) || first >= f64::from(slit.end);
            is_beside || segments[0].objects[1] == Some(1)
        });
        assert_eq!(spread.ways(), [613, 614]);
        assert!(asked < 50, "{asked}");
    }

    #[test]
    fn light_that_is_not_followed_is_counted_where_nothing_arrives() {
        let (_, _, ways) = told(|_| Seen {
            is_cut: true,
            ..gray(0.0)
        });
        assert!(ways > 0);
    }

    /// Whatever is split is all there: at each wavelength the shares are 1.
    #[test]
    fn shares_keep_the_light() {
        let seen = |nm: u16| {
            let step = if nm > 611 { 0.3 } else { 0.0 };
            gray(2.0 + (f64::from(nm) / 100.0).sin() + step)
        };
        let (spread, _) = looked(seen, |_| true);
        let mut sums = [0.0; SAMPLES];
        for way in spread.ways() {
            for (sum, share) in sums.iter_mut().zip(spread.share(way).values()) {
                *sum += share;
            }
        }
        for sum in sums {
            assert!((sum - 1.0).abs() < 1e-13, "{sum}");
        }
    }
}
