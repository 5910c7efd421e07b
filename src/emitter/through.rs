//! What a point receives of an emitter past opaque shapes and through thin panes.
//!
//! Flat panes cut what is seen into convex pieces as opaque shapes do, so that each piece is seen through the same
//! panes. Over a piece T, the part that passes, is a smooth function of c = v·u, v the normal of the panes: a
//! polynomial Σ a_j cʲ, to an error that is known. So the irradiance is Σ a_j ∫ cʲ (n·u) dω, integrals that have closed
//! forms past all shapes as they are those of lobes around v. Of a lobe around another axis the linear part is such an
//! integral, ∫ (w·u)ᴺ c dω. For the rest, and for panes of several normals, the mean of T is taken by quadrature, and
//! times what would be received without panes it is what passes: a mean is right where it matters little for the
//! integral. Pieces are halved until halves say the same as the whole.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

use super::Emitter;
use super::average::{Means, Sums, for_each_point};
use super::conic::{Side, WholeCone};
use super::fit::{Fit, Line, MOST_DEGREE};
use super::occluder::{Blocker, Occluder};
use super::pieces::{Effect, Split, are_apart, effect_of, longest};
use super::received::{Gloss, Received, Receiver};
use super::seen::{Light, MOST_EFFECTS};
use super::shadow::{Accuracy, Bounded, ShadowSpace, Straight};
use crate::math::{DVec3, Direction, Normal, Point};

/// As many panes as have a bit.
const MOST_PANES: usize = u64::BITS as usize;

/// At most so many pieces are looked at.
const MOST_PIECES: usize = 1024;

/// What halves say instead of the whole is taken to be how far they are off, and this part of how far the whole was
/// taken to be: both may be off alike.
const OF_WHOLE: f64 = 1.0 / 64.0;

/// The part of the deviation of T that the quadrature may be off by where all of a piece is seen, and where a part is.
const OF_SMOOTH: f64 = 1.0 / 64.0;
const OF_CUT: f64 = 1.0;

/// A lobe of which less than this part of all of it is received is as exact as one of which that is.
const LEAST_LOBE: f64 = 1e-7;

/// A piece of which no more than this part of all that may be off is uncertain is not looked at more closely.
const OF_GOAL: f64 = 0.1;

/// The squared sine of the angle below which normals are the same.
const SAME_NORMAL: f64 = 1e-24;

/// Thin panes, which let a part of the light pass.
#[derive(Clone, Copy)]
pub(crate) struct Panes<'a> {
    pub(crate) shapes: &'a [Occluder],
    /// How many more there are, that all of the light is seen through; they have the numbers after those of the shapes.
    pub(crate) whole: usize,
    /// The normal of one of them, or for a ball the direction to its center.
    pub(crate) normal: &'a dyn Fn(usize) -> DVec3,
    /// T of one of them along a direction of any length: 0 to 1. It depends on the angle to the normal alone.
    pub(crate) transmittance: &'a dyn Fn(usize, DVec3) -> f64,
}

/// Of panes that are not told apart here: round ones, and very many.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Untold;

/// A part of the emitter, and the panes that it is seen through, a bit for each.
#[derive(Clone, Debug)]
struct Piece {
    corners: Range<usize>,
    panes: u64,
}

/// A piece and what is received of it.
#[derive(Clone, Debug)]
struct Taken {
    piece: Piece,
    value: Received,
    /// How far that may be off.
    error: Received,
    /// The largest part that this is of an integral.
    weight: f64,
}

/// Who looks at what through what.
struct Through<'a> {
    light: Light<'a>,
    panes: &'a Panes<'a>,
    opaque: &'a [Blocker],
}

impl Emitter {
    /// [What is received](Emitter::received_past) past opaque occluders and through panes. What panes let pass is an
    /// estimate, and so is then the error.
    #[expect(clippy::too_many_arguments, reason = "as without panes")]
    pub(crate) fn received_through(
        &self,
        point: Point,
        receiver: &Receiver,
        occluders: &[Occluder],
        panes: &Panes<'_>,
        error_of_point: f64,
        accuracy: &Accuracy,
        space: &mut ShadowSpace,
    ) -> Result<Option<Bounded>, Untold> {
        space.clear();
        let outline = self.seen_from(point);
        let Some((cone, whole)) = outline.and_then(|all| space.take_outline(&all, receiver)) else {
            return Ok(None);
        };
        let view = self.view(point, error_of_point);
        let mut before_all = 0;
        let mut numbers = Vec::new();
        for (number, shape) in panes.shapes.iter().enumerate() {
            for blocker in view.blocked_by(shape).iter().flatten() {
                if number >= MOST_PANES {
                    return Err(Untold);
                }
                if !space.take_blocker(blocker, &whole) {
                    before_all |= 1 << number;
                }
                numbers.resize(space.straight.len(), number);
            }
        }
        for number in panes.shapes.len()..panes.shapes.len() + panes.whole {
            if number >= MOST_PANES {
                return Err(Untold);
            }
            before_all |= 1 << number;
        }
        if !space.blockers.is_empty() {
            return Err(Untold);
        }
        if before_all == 0 && numbers.is_empty() {
            let seen =
                self.received_past(point, receiver, occluders, error_of_point, accuracy, space);
            return Ok(seen);
        }
        let edges = std::mem::take(&mut space.straight);
        for occluder in occluders {
            for blocker in view.blocked_by(occluder).iter().flatten() {
                if !space.take_blocker(blocker, &whole) {
                    return Ok(Some(Bounded {
                        value: Received::NOTHING,
                        error: receiver.rounding(),
                    }));
                }
            }
        }
        let Some(free) = self.received(point, receiver) else {
            return Ok(None);
        };
        space.subtract_straight(whole, accuracy);
        let seen = space.seen.drain(..).map(|piece| Piece {
            corners: piece.corners,
            panes: before_all,
        });
        let mut pieces: Vec<Piece> = seen.collect();
        for (straight, number) in edges.iter().zip(numbers) {
            space.part_by(&mut pieces, straight, number);
        }
        let opaque = std::mem::take(&mut space.blockers);
        let through = Through {
            light: Light { cone, receiver },
            panes,
            opaque: &opaque,
        };
        let total = through.sum(pieces, free, accuracy, space);
        space.blockers = opaque;
        space.straight = edges;
        Ok(Some(total))
    }
}

impl ShadowSpace {
    /// Parts what is seen through a pane from what is not.
    fn part_by(&mut self, pieces: &mut Vec<Piece>, straight: &Straight, pane: usize) {
        for place in 0..pieces.len() {
            let Piece { corners, panes } = pieces[place].clone();
            if are_apart(
                straight.planes(),
                straight.corners(),
                self.pieces.corners(&corners),
            ) {
                continue;
            }
            let mut rest = corners;
            let mut is_before = true;
            for &plane in straight.planes() {
                match self.pieces.split(&rest, plane) {
                    Split::Inside => {}
                    Split::Outside => {
                        is_before = false;
                        break;
                    }
                    Split::Both { inside, outside } => {
                        if !outside.is_empty() {
                            let corners = outside;
                            pieces.push(Piece { corners, panes });
                        }
                        rest = inside;
                        if rest.is_empty() {
                            break;
                        }
                    }
                }
            }
            let bit = if is_before { 1 << pane } else { 0 };
            pieces[place] = Piece {
                corners: rest,
                panes: panes | bit,
            };
        }
        pieces.retain(|piece| !piece.corners.is_empty());
    }
}

impl Through<'_> {
    /// Adds what passes of all pieces, and halves those of which halves say something else.
    fn sum(
        &self,
        pieces: Vec<Piece>,
        free: Received,
        accuracy: &Accuracy,
        space: &mut ShadowSpace,
    ) -> Bounded {
        let mut goal = free * accuracy.relative;
        let least_lobe = LEAST_LOBE * self.light.receiver.full_lobe();
        goal.lobe = goal.lobe.max(least_lobe * accuracy.relative);
        let mut count = pieces.len();
        let mut open = BinaryHeap::new();
        let mut value = Received::NOTHING;
        let mut error = self.light.receiver.rounding() * (count + 1) as f64;
        for piece in pieces {
            let passed = self.received(&piece, goal, accuracy, space);
            open.push(passed.taken(piece, free));
        }
        let mut unknown = open
            .iter()
            .fold(Received::NOTHING, |sum, taken| sum + taken.error);
        while count < MOST_PIECES.min(accuracy.most_cells) && !unknown.is_below(goal) {
            let Some(taken) = open.pop() else {
                break;
            };
            let corners = space.pieces.corners(&taken.piece.corners);
            let plane = longest(corners);
            let Split::Both { inside, outside } = space.pieces.split(&taken.piece.corners, plane)
            else {
                value += taken.value;
                error += taken.error;
                unknown -= taken.error;
                continue;
            };
            let halves = [inside, outside].map(|corners| {
                let panes = taken.piece.panes;
                let piece = Piece { corners, panes };
                let passed = self.received(&piece, goal, accuracy, space);
                (piece, passed)
            });
            let [(_, one), (_, other)] = &halves;
            let difference = (one.value + other.value - taken.value).magnitude();
            let of_halves = (difference + taken.error * OF_WHOLE) * 0.5;
            unknown -= taken.error;
            for (piece, mut passed) in halves {
                passed.error = passed.error.least(of_halves);
                unknown += passed.error;
                open.push(passed.taken(piece, free));
            }
            count += 1;
        }
        for taken in open {
            value += taken.value;
            error += taken.error;
        }
        let value = value.at_least_nothing();
        Bounded { value, error }
    }

    /// What is received of a piece.
    fn received(
        &self,
        piece: &Piece,
        goal: Received,
        accuracy: &Accuracy,
        space: &mut ShadowSpace,
    ) -> Passed {
        let corners = space.pieces.corners(&piece.corners);
        if corners.is_empty() {
            return Passed::NOTHING;
        }
        let mut effects = [Effect::Nothing; MOST_EFFECTS];
        let mut before = Vec::new();
        let mut is_cut = false;
        for blocker in self.opaque {
            match effect_of(blocker, corners) {
                Effect::Nothing => continue,
                Effect::All => return Passed::NOTHING,
                Effect::Cut(_) => is_cut = true,
                effect @ (Effect::Within(_) | Effect::Without(_) | Effect::Ring { .. }) => {
                    if let Some(place) = effects.get_mut(before.len()) {
                        *place = effect;
                    }
                }
            }
            before.push(blocker);
        }
        let effects = effects.get(..before.len()).filter(|_| !is_cut);
        let seen = effects.and_then(|effects| {
            let seen = self
                .light
                .seen(effects, &piece.corners, &mut space.pieces)?;
            Some((effects, seen.at_least_nothing()))
        });
        let Some((effects, seen)) = seen else {
            let corners = space.pieces.corners(&piece.corners);
            let means = self.means(self.light.cone, corners, piece.panes, &Line::NONE, &before);
            let all = self.light.received(corners);
            let all = all.unwrap_or_else(|| self.light.receiver.of_polygon(corners));
            return Passed {
                value: all.times(means.rest).times(means.seen),
                error: all,
            };
        };
        if seen == Received::NOTHING || piece.panes == 0 {
            return Passed {
                value: seen,
                error: Received::NOTHING,
            };
        }
        let corners = space.pieces.corners(&piece.corners);
        let allowed = 0.5 * accuracy.relative;
        let fits = self.fits(corners, piece.panes, allowed);
        let mut value = Received::NOTHING;
        let mut error = Received::NOTHING;
        let mut line = Line::of(&fits);
        let is_polynomial = |fit: &Fit| fit.off <= allowed && fit.is_steady();
        let one = match &fits[..] {
            [fit] => Some(fit).filter(|fit| is_polynomial(fit)),
            _ => None,
        };
        if let Some(fit) = one {
            let Some(irradiance) = self.polynomial(fit, seen, effects, piece, space) else {
                return self.undecided(piece, seen, &before, space);
            };
            value.irradiance = irradiance;
            error.irradiance = fit.off * seen.irradiance;
            // It is asked for where there is no irradiance alone.
            value.solid_angle = seen.solid_angle * fit.at(fit.middle);
            let of_lobe = fit.spread() * seen.lobe;
            if of_lobe <= OF_GOAL * goal.lobe {
                (value.lobe, error.lobe) = (seen.lobe * fit.at(fit.middle), of_lobe);
                return Passed { value, error };
            }
        }
        let is_one = one.is_some();
        let Some(linear) = self.linear(&line, !is_one, seen, effects, piece, space) else {
            return self.undecided(piece, seen, &before, space);
        };
        line.has_lobe = self.has_plain_lobe();
        let corners = space.pieces.corners(&piece.corners);
        let (rest, of_rest) = self.rest(effects, corners, piece.panes, seen, &line, &before);
        let rest = linear + rest;
        value.lobe = rest.lobe;
        error.lobe = of_rest.lobe;
        if !is_one {
            (value.irradiance, error.irradiance) = (rest.irradiance, of_rest.irradiance);
            value.solid_angle = rest.solid_angle;
        }
        Passed { value, error }
    }

    /// What passes of what is seen of a piece where T is what is left of it without a line, and how far that may be off.
    fn rest(
        &self,
        effects: &[Effect],
        corners: &[DVec3],
        panes: u64,
        seen: Received,
        line: &Line,
        before: &[&Blocker],
    ) -> (Received, Received) {
        if let [Effect::Within(ball)] = effects
            && self.light.side_of(corners) == Side::Inside
            && let Some(hidden) = self.light.within(ball, corners)
        {
            // Both what there is and what a ball hides of it are convex, and T is smooth over them.
            let all = seen + hidden;
            let of_all = self.means(None, corners, panes, line, &[]);
            let of_hidden = self.means(Some(*ball), corners, panes, line, &[]);
            let rest = all.times(of_all.rest) - hidden.times(of_hidden.rest);
            return (rest, all.times(of_all.deviation) * OF_SMOOTH);
        }
        let means = self.means(self.light.cone, corners, panes, line, before);
        let part = if effects.is_empty() {
            OF_SMOOTH
        } else {
            OF_CUT
        };
        (seen.times(means.rest), seen.times(means.deviation) * part)
    }

    /// What is received of a piece of which that is known without panes, by the mean of T alone.
    fn undecided(
        &self,
        piece: &Piece,
        seen: Received,
        before: &[&Blocker],
        space: &ShadowSpace,
    ) -> Passed {
        let corners = space.pieces.corners(&piece.corners);
        let means = self.means(self.light.cone, corners, piece.panes, &Line::NONE, before);
        Passed {
            value: seen.times(means.rest),
            error: seen.times(means.deviation) * OF_CUT,
        }
    }

    /// Whether the lobe is without a cosine: with c it is then one that has a closed form.
    fn has_plain_lobe(&self) -> bool {
        let gloss = self.light.receiver.gloss;
        gloss.is_some_and(|gloss| !gloss.has_cosine)
    }

    /// ∫ max(0, w·u)ᴺ (v·u) dω of what is seen of a piece. `None` where that has no closed form here.
    fn cosine_lobe(
        &self,
        normal: Normal,
        gloss: Gloss,
        effects: &[Effect],
        piece: &Piece,
        space: &mut ShadowSpace,
    ) -> Option<f64> {
        let light = Light {
            cone: self.light.cone,
            receiver: &Receiver {
                horizon: self.light.receiver.horizon,
                normal,
                gloss: Some(Gloss {
                    has_cosine: true,
                    ..gloss
                }),
            },
        };
        let seen = light.seen(effects, &piece.corners, &mut space.pieces)?;
        Some(seen.lobe.max(0.0))
    }

    /// The irradiance Σ a_j ∫ cʲ (n·u) dω.
    fn polynomial(
        &self,
        fit: &Fit,
        seen: Received,
        effects: &[Effect],
        piece: &Piece,
        space: &mut ShadowSpace,
    ) -> Option<f64> {
        let axis = Direction::new(fit.axis)?;
        let mut sum = fit.coefficients[0] * seen.irradiance;
        for power in 1..=fit.degree {
            let gloss = Gloss {
                axis,
                shininess: power as f64,
                has_cosine: true,
            };
            let normal = self.light.receiver.normal;
            let moment = self.cosine_lobe(normal, gloss, effects, piece, space)?;
            sum += fit.coefficients[power] * moment;
        }
        Some(sum)
    }

    /// What passes where T is a linear function: of a lobe without a cosine, and of the irradiance if that is asked for.
    fn linear(
        &self,
        line: &Line,
        with_irradiance: bool,
        seen: Received,
        effects: &[Effect],
        piece: &Piece,
        space: &mut ShadowSpace,
    ) -> Option<Received> {
        let receiver = self.light.receiver;
        let mut linear = Received::NOTHING;
        if with_irradiance {
            linear.irradiance = line.constant * seen.irradiance;
        }
        let plain = receiver
            .gloss
            .filter(|_| self.has_plain_lobe() && seen.lobe > 0.0);
        if plain.is_some() {
            linear.lobe = line.constant * seen.lobe;
        }
        for &(axis, slope) in &line.slopes {
            if with_irradiance {
                let gloss = Gloss {
                    axis: Direction::new(axis)?,
                    shininess: 1.0,
                    has_cosine: true,
                };
                linear.irradiance +=
                    slope * self.cosine_lobe(receiver.normal, gloss, effects, piece, space)?;
            }
            if let Some(gloss) = plain {
                let normal = Normal::new(axis)?;
                linear.lobe += slope * self.cosine_lobe(normal, gloss, effects, piece, space)?;
            }
        }
        Some(linear)
    }

    /// T over a piece, of the panes of each normal as a function of the cosine to that: one to an error that is allowed,
    /// several as lines.
    fn fits(&self, corners: &[DVec3], panes: u64, allowed: f64) -> Vec<Fit> {
        let middle = corners.iter().map(|corner| corner / corner.length());
        let middle = middle.sum::<DVec3>().normalize_or(DVec3::Z);
        // The circle around the middle that holds all corners.
        let reach = corners
            .iter()
            .map(|corner| middle.cross(*corner).length() / corner.length());
        let reach = reach.fold(0.0, f64::max).min(1.0).asin();
        let mut fits = Vec::new();
        let mut rest = panes;
        let mut is_one = true;
        while rest != 0 {
            let normal = (self.panes.normal)(rest.trailing_zeros() as usize);
            let mut alike = 0;
            let mut others = rest;
            while others != 0 {
                let other = (self.panes.normal)(others.trailing_zeros() as usize);
                if other.cross(normal).length_squared() <= SAME_NORMAL {
                    alike |= others & others.wrapping_neg();
                }
                others &= others - 1;
            }
            rest &= !alike;
            is_one &= alike == panes;
            let axis = normal * normal.dot(middle).signum();
            let angle = axis.cross(middle).length().min(1.0).asin();
            let most = (angle - reach).max(0.0).cos();
            let least = (angle + reach).min(FRAC_PI_2).cos();
            let range = [0.5 * (most + least), 0.5 * (most - least)];
            let across = axis.any_orthonormal_vector();
            let transmittance = |cosine: f64| {
                let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
                self.transmittance(alike, axis * cosine + across * sine)
            };
            let mut fit = Fit::of_degree(1, axis, range, &transmittance);
            for degree in 2..=MOST_DEGREE {
                if fit.off <= allowed || !is_one {
                    break;
                }
                let next = Fit::of_degree(degree, axis, range, &transmittance);
                if !next.is_steady() {
                    break;
                }
                fit = next;
            }
            fits.push(fit);
        }
        fits
    }

    /// Means over a piece of the light, each with the weights of its integral; of T without a linear function.
    fn means(
        &self,
        cone: Option<WholeCone>,
        corners: &[DVec3],
        panes: u64,
        line: &Line,
        before: &[&Blocker],
    ) -> Means {
        let mut sums = Sums::default();
        for_each_point(cone, corners, |x, solid_angle| {
            let weights = self.light.receiver.weights(x) * solid_angle;
            let is_seen = !before.iter().any(|blocker| blocker.blocks(x));
            let rest = || {
                let passed = self.transmittance(panes, x);
                let rest = passed - line.at(x / x.length());
                Received {
                    irradiance: rest,
                    lobe: if line.has_lobe { rest } else { passed },
                    solid_angle: rest,
                }
            };
            sums.add(weights, is_seen.then(rest));
        });
        sums.means()
    }

    fn transmittance(&self, panes: u64, way: DVec3) -> f64 {
        let mut rest = panes;
        let mut product = 1.0;
        while rest != 0 {
            product *= (self.panes.transmittance)(rest.trailing_zeros() as usize, way);
            rest &= rest - 1;
        }
        product
    }
}

/// What is received of a piece, and how far that may be off.
struct Passed {
    value: Received,
    error: Received,
}

impl Passed {
    const NOTHING: Self = Self {
        value: Received::NOTHING,
        error: Received::NOTHING,
    };

    fn taken(self, piece: Piece, free: Received) -> Taken {
        Taken {
            piece,
            value: self.value,
            error: self.error,
            weight: self.error.part_of(free),
        }
    }
}

impl PartialEq for Taken {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Taken {}

impl PartialOrd for Taken {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Taken {
    fn cmp(&self, other: &Self) -> Ordering {
        let place = |taken: &Self| taken.piece.corners.start;
        let by_weight = self.weight.total_cmp(&other.weight);
        by_weight.then_with(|| place(self).cmp(&place(other)))
    }
}
