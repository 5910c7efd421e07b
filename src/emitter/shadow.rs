//! What a point receives of an emitter past opaque shapes: the integrals over what it sees of it.
//!
//! What is seen is cut into pieces by planes through the point, each into what is on its two sides, so that pieces
//! neither overlap nor leave a gap: convex polygons, of which a disk or a sphere fills what its cone has of them.
//! Triangles and planes are subtracted exactly. What is left are cells that cones of disks and balls may cross. One
//! that a single cone crosses is a difference of two closed forms; one that several cross is halved, and of those
//! still undecided in the end half is counted, with the other half as the bound of the error.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::Range;

use super::conic::{Side, WholeCone};
use super::occluder::{Blocker, MOST_EDGES, Occluder, Plane, View};
use super::outline::Outline;
use super::pieces::{Bounds, Effect, Pieces, Split, are_apart, effect_of, longest};
use super::received::{Received, Receiver};
use super::seen::{Light, MOST_EFFECTS};
use super::{Emitter, Shape};
use crate::math::{DVec3, Point};

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Accuracy {
    /// Where the bounds of all errors are below this part of what is received with nothing in the way.
    pub(crate) relative: f64,
    /// At the latest after so many cells.
    pub(crate) most_cells: usize,
}

/// Integrals, and how far each may be off.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Bounded {
    pub(crate) value: Received,
    pub(crate) error: Received,
}

/// What [`Emitter::received_past`] works in: for one call at a time, to be kept for the next.
#[derive(Debug, Default)]
pub(crate) struct ShadowSpace {
    pub(super) pieces: Pieces,
    pub(super) straight: Vec<Straight>,
    pub(super) blockers: Vec<Blocker>,
    /// Of cells, who may still block a part.
    candidates: Vec<usize>,
    /// What is left once what is straight has been subtracted.
    pub(super) seen: Vec<Piece>,
    cells: Vec<Cell>,
    undecided: BinaryHeap<Undecided>,
}

/// A part of the emitter that nothing straight blocks.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub(super) corners: Range<usize>,
    bounds: Bounds,
}

/// A part of the emitter, and who may block a part of it.
#[derive(Clone, Debug)]
struct Cell {
    corners: Range<usize>,
    candidates: Range<usize>,
}

/// A cell of which it is not known how much is blocked.
#[derive(Clone, Debug)]
struct Undecided {
    cell: Cell,
    /// What is received of all of it, at most.
    all: Received,
    /// The largest part of an integral.
    weight: f64,
}

/// Directions within planes, all of which are blocked.
#[derive(Clone, Copy, Debug)]
pub(super) struct Straight {
    planes: [DVec3; MOST_EDGES],
    corners: [DVec3; MOST_EDGES],
    plane_count: usize,
    corner_count: usize,
    bounds: Bounds,
}

/// A sum over pieces.
#[derive(Clone, Copy, Debug)]
struct Total {
    value: Received,
    /// What is not known.
    error: Received,
    pieces: f64,
}

impl Emitter {
    /// What a point receives past occluders: a value of each integral, and a bound of its error. An occluder counts
    /// where it is between the point and what is seen of the emitter. A triangle, disk or plane whose plane is
    /// closer to the point than `error_of_point`, or than coordinates are rounded, does not: the point is on it. In
    /// the same way, parts in the emitter's plane do not. `None` where nothing would be received of all of it.
    pub(crate) fn received_past(
        &self,
        point: Point,
        receiver: &Receiver,
        occluders: &[Occluder],
        error_of_point: f64,
        accuracy: &Accuracy,
        space: &mut ShadowSpace,
    ) -> Option<Bounded> {
        space.clear();
        let (cone, whole) = space.take_outline(&self.seen_from(point)?, receiver)?;
        let light = Light { cone, receiver };
        let view = self.view(point, error_of_point);
        for occluder in occluders {
            for blocker in view.blocked_by(occluder).iter().flatten() {
                if !space.take_blocker(blocker, &whole) {
                    let value = Received::NOTHING;
                    let error = receiver.rounding();
                    return Some(Bounded { value, error });
                }
            }
        }
        let free = || self.received(point, receiver);
        let mut total = Total::NOTHING;
        if space.blockers.is_empty() && space.straight.len() <= 1 {
            total.value = free()?;
            let hidden = space.straight.first().copied();
            if let Some(part) = hidden.and_then(|straight| space.part(whole, &straight)) {
                // So few planes have cut it that there is room for all.
                let hidden = light
                    .received(space.pieces.corners(&part))
                    .unwrap_or_default();
                total.value = (total.value - hidden).at_least_nothing();
                total.pieces = 2.0;
            }
            return Some(total.bounded(receiver));
        }
        space.subtract_straight(whole, accuracy);
        if space.seen.is_empty() {
            return Some(total.bounded(receiver));
        }
        if space.blockers.is_empty() {
            let mut is_sum = true;
            for piece in &space.seen {
                match light.received(space.pieces.corners(&piece.corners)) {
                    Some(part) => total.add(part),
                    None => is_sum = false,
                }
            }
            if is_sum {
                return Some(total.bounded(receiver));
            }
            total = Total::NOTHING;
        }
        let free = free()?;
        space.decide(&light, free, accuracy, &mut total);
        for undecided in &space.undecided {
            total.half_of(undecided.all);
        }
        Some(total.bounded(receiver))
    }

    /// The emitter has to be seen from there.
    pub(super) fn view(&self, point: Point, error: f64) -> View {
        let to_center = self.center.from(point);
        let (front, ball) = match self.shape {
            Shape::Rectangle { normal, .. } | Shape::Disk { normal, .. } => {
                let distance = normal.get().dot(to_center);
                let front = Plane {
                    normal: normal.get() * distance.signum(),
                    distance: distance.abs(),
                };
                (front, None)
            }
            Shape::Sphere { radius } => {
                let ball = (to_center, radius);
                (Plane::polar(ball), Some(ball))
            }
        };
        View {
            point,
            error,
            front,
            ball,
        }
    }
}

impl Total {
    const NOTHING: Self = Self {
        value: Received::NOTHING,
        error: Received::NOTHING,
        pieces: 1.0,
    };

    fn add(&mut self, part: Received) {
        self.value += part;
        self.pieces += 1.0;
    }

    /// Of a piece of which nobody knows how much is blocked.
    fn half_of(&mut self, all: Received) {
        self.add(all * 0.5);
        self.error += all * 0.5;
    }

    fn bounded(&self, receiver: &Receiver) -> Bounded {
        Bounded {
            value: self.value,
            error: self.error + receiver.rounding() * self.pieces,
        }
    }
}

impl Straight {
    pub(super) fn planes(&self) -> &[DVec3] {
        &self.planes[..self.plane_count]
    }

    pub(super) fn corners(&self) -> &[DVec3] {
        &self.corners[..self.corner_count]
    }

    fn blocker(&self) -> Blocker {
        Blocker {
            planes: self.planes,
            count: self.plane_count,
            corners: (self.corner_count > 0).then_some(self.corners),
            cone: None,
            hole: None,
        }
    }
}

impl ShadowSpace {
    pub(super) fn clear(&mut self) {
        self.pieces.clear();
        self.straight.clear();
        self.blockers.clear();
        self.candidates.clear();
        self.seen.clear();
        self.cells.clear();
        self.undecided.clear();
    }

    /// The corners around what is seen above the horizon, and the cone of a disk or a sphere. `None` where there is
    /// nothing.
    pub(super) fn take_outline(
        &mut self,
        outline: &Outline,
        receiver: &Receiver,
    ) -> Option<(Option<WholeCone>, Range<usize>)> {
        let (cone, all) = match outline {
            Outline::Polygon(polygon) => (None, self.pieces.take(polygon.corners())),
            Outline::Conic(conic) => {
                let cone = conic.whole();
                (Some(cone), self.pieces.take(&cone.around()))
            }
        };
        let whole = match self.pieces.split(&all, receiver.horizon.get()) {
            Split::Inside => all,
            Split::Outside => return None,
            Split::Both { inside, .. } => inside,
        };
        let corners = self.pieces.corners(&whole);
        let is_nothing = cone.is_some_and(|cone| cone.side_of(corners) == Side::Outside);
        (!is_nothing && whole.len() > 2).then_some((cone, whole))
    }

    /// Keeps what blocks a part of the emitter. Whether that is not all of it.
    pub(super) fn take_blocker(&mut self, blocker: &Blocker, whole: &Range<usize>) -> bool {
        match effect_of(blocker, self.pieces.corners(whole)) {
            Effect::Nothing => {}
            Effect::All => return false,
            Effect::Cut(_) | Effect::Within(_) | Effect::Without(_) | Effect::Ring { .. } => {
                if blocker.is_straight() {
                    let corners = blocker.corners.unwrap_or_default();
                    let corner_count = blocker.corners.map_or(0, |_| blocker.count);
                    self.straight.push(Straight {
                        planes: blocker.planes,
                        corners,
                        plane_count: blocker.count,
                        corner_count,
                        bounds: self.pieces.bounds_of(&corners[..corner_count]),
                    });
                } else {
                    self.blockers.push(*blocker);
                }
            }
        }
        true
    }

    /// Takes from all of the outline what straight blockers block; those that there is no room for are decided cell
    /// by cell, as far as that goes.
    pub(super) fn subtract_straight(&mut self, whole: Range<usize>, accuracy: &Accuracy) {
        self.keep(whole);
        let mut place = 0;
        while place < self.straight.len() && (1..=accuracy.most_cells).contains(&self.seen.len()) {
            self.subtract(place);
            place += 1;
        }
        for straight in &self.straight[place..] {
            self.blockers.push(straight.blocker());
        }
    }

    /// What is left so far.
    fn keep(&mut self, corners: Range<usize>) {
        let bounds = self.pieces.bounds_of(self.pieces.corners(&corners));
        self.seen.push(Piece { corners, bounds });
    }

    /// What of a piece is within all planes.
    fn part(&mut self, piece: Range<usize>, straight: &Straight) -> Option<Range<usize>> {
        let mut part = piece;
        for &plane in straight.planes() {
            match self.pieces.split(&part, plane) {
                Split::Inside => {}
                Split::Outside => return None,
                Split::Both { inside, .. } => part = inside,
            }
        }
        Some(part)
    }

    /// Takes from all pieces what is within a blocker's planes: of each, what is outside of one plane and inside of
    /// those before is a piece.
    fn subtract(&mut self, place: usize) {
        let straight = self.straight[place];
        let planes = straight.planes();
        let mut piece = 0;
        let mut end = self.seen.len();
        while piece < end {
            if self.seen[piece].bounds.are_apart(&straight.bounds) {
                piece += 1;
                continue;
            }
            let mut rest = self.seen[piece].corners.clone();
            let corners = self.pieces.corners(&rest);
            if are_apart(planes, straight.corners(), corners) {
                piece += 1;
                continue;
            }
            // New pieces come last, the next one in the place of this.
            end -= 1;
            self.seen.swap(piece, end);
            self.seen.swap_remove(end);
            for &plane in planes {
                match self.pieces.split(&rest, plane) {
                    Split::Inside => {}
                    Split::Outside => {
                        self.keep(rest);
                        break;
                    }
                    Split::Both { inside, outside } => {
                        if !outside.is_empty() {
                            self.keep(outside);
                        }
                        if inside.is_empty() {
                            break;
                        }
                        rest = inside;
                    }
                }
            }
        }
    }

    /// Adds what is received of all pieces, and halves those that are undecided until they matter no more.
    fn decide(&mut self, light: &Light, free: Received, accuracy: &Accuracy, total: &mut Total) {
        self.candidates.extend(0..self.blockers.len());
        for Piece { corners, .. } in self.seen.drain(..) {
            let candidates = 0..self.blockers.len();
            self.cells.push(Cell {
                corners,
                candidates,
            });
        }
        let mut count = 0;
        let mut bound = Received::NOTHING;
        loop {
            while let Some(cell) = self.cells.pop() {
                count += 1;
                let is_last = count + self.cells.len() >= accuracy.most_cells;
                if let Some((cell, all)) = self.look_at(cell, light, is_last, total) {
                    bound += all * 0.5;
                    let weight = all.part_of(free);
                    self.undecided.push(Undecided { cell, all, weight });
                }
            }
            if count >= accuracy.most_cells || bound.is_below(free * accuracy.relative) {
                return;
            }
            let Some(Undecided { cell, all, .. }) = self.undecided.pop() else {
                return;
            };
            let plane = longest(self.pieces.corners(&cell.corners));
            if self.halve(&cell, plane) {
                bound -= all * 0.5;
            } else {
                total.half_of(all);
            }
        }
    }

    /// Both sides of a plane through the point are cells to look at. Whether there are two.
    fn halve(&mut self, cell: &Cell, plane: DVec3) -> bool {
        let Split::Both { inside, outside } = self.pieces.split(&cell.corners, plane) else {
            return false;
        };
        for corners in [inside, outside] {
            if !corners.is_empty() {
                let candidates = cell.candidates.clone();
                self.cells.push(Cell {
                    corners,
                    candidates,
                });
            }
        }
        true
    }

    /// Adds what is received of a cell if that is known, and cuts it where planes do. Else what is received of it at
    /// most.
    fn look_at(
        &mut self,
        cell: Cell,
        light: &Light,
        is_last: bool,
        total: &mut Total,
    ) -> Option<(Cell, Received)> {
        let corners = self.pieces.corners(&cell.corners);
        if light.side_of(corners) == Side::Outside {
            return None;
        }
        let start = self.candidates.len();
        let mut effects = [Effect::Nothing; MOST_EFFECTS];
        let mut cut = None;
        for place in cell.candidates {
            let candidate = self.candidates[place];
            match effect_of(&self.blockers[candidate], corners) {
                Effect::Nothing => continue,
                Effect::All => {
                    self.candidates.truncate(start);
                    return None;
                }
                Effect::Cut(plane) => cut = Some(plane),
                effect @ (Effect::Within(_) | Effect::Without(_) | Effect::Ring { .. }) => {
                    if let Some(place) = effects.get_mut(self.candidates.len() - start) {
                        *place = effect;
                    }
                }
            }
            self.candidates.push(candidate);
        }
        let candidates = start..self.candidates.len();
        if cut.is_none()
            && let Some(effects) = effects.get(..candidates.len())
            && let Some(seen) = light.seen(effects, &cell.corners, &mut self.pieces)
        {
            total.add(seen.at_least_nothing());
            return None;
        }
        let cell = Cell {
            corners: cell.corners,
            candidates,
        };
        if let Some(plane) = cut
            && !is_last
            && self.halve(&cell, plane)
        {
            return None;
        }
        let corners = self.pieces.corners(&cell.corners);
        let all = light.received(corners);
        let all = all.unwrap_or_else(|| light.receiver.of_polygon(corners));
        Some((cell, all))
    }
}

impl PartialEq for Undecided {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Undecided {}

impl PartialOrd for Undecided {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Undecided {
    fn cmp(&self, other: &Self) -> Ordering {
        let place = |undecided: &Self| undecided.cell.corners.start;
        let by_weight = self.weight.total_cmp(&other.weight);
        by_weight.then_with(|| place(self).cmp(&place(other)))
    }
}
