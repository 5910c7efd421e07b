//! Closed forms of what is received of a convex piece that cones cross.

use std::ops::Range;

use super::clip::across;
use super::conic::{Side, WholeCone};
use super::crossing::{Crossing, Meeting, meeting};
use super::pieces::{Effect, Pieces, Split};
use super::received::{Received, Receiver};
use crate::math::DVec3;

/// Of so many blockers of one piece closed forms are tried.
pub(super) const MOST_EFFECTS: usize = 4;

/// A disk or a sphere, or else all of every piece; and who receives it.
#[derive(Clone, Copy)]
pub(super) struct Light<'a> {
    pub(super) cone: Option<WholeCone>,
    pub(super) receiver: &'a Receiver,
}

impl Light<'_> {
    pub(super) fn side_of(&self, corners: &[DVec3]) -> Side {
        self.cone.map_or(Side::Inside, |cone| cone.side_of(corners))
    }

    /// What is received of a piece. `None` where a cone is cut by more edges than there is room for.
    pub(super) fn received(&self, corners: &[DVec3]) -> Option<Received> {
        let Some(cone) = self.cone else {
            return Some(self.receiver.of_polygon(corners));
        };
        self.within(&cone, corners)
    }

    /// What is received of a piece within a cone, if that is lit.
    pub(super) fn within(&self, cone: &WholeCone, corners: &[DVec3]) -> Option<Received> {
        Some(match cone.side_of(corners) {
            Side::Inside => self.receiver.of_polygon(corners),
            Side::Outside => Received::NOTHING,
            Side::Across => self.receiver.of_conic(&cone.within(corners)?),
        })
    }

    /// What is received of a piece past blockers, each of which a cone makes. `None` where that has no closed form
    /// here.
    pub(super) fn seen(
        &self,
        effects: &[Effect],
        piece: &Range<usize>,
        pieces: &mut Pieces,
    ) -> Option<Received> {
        let corners = pieces.corners(piece);
        let light = match self.side_of(corners) {
            Side::Inside => None,
            Side::Outside => return Some(Received::NOTHING),
            Side::Across => self.cone,
        };
        match *effects {
            [] => self.received(corners),
            [Effect::Without(hole)] => self.lit(light, &hole, piece, pieces),
            [Effect::Ring { cone, hole }] if light.is_none() => {
                let within = self.within(&cone, corners)?;
                let all = self.received(corners)?;
                Some(all - within + self.common(&cone, &hole, piece, pieces)?)
            }
            _ => self.past_cones(light, effects, piece, pieces),
        }
    }

    /// Where all block what is within their cones.
    fn past_cones(
        &self,
        light: Option<WholeCone>,
        effects: &[Effect],
        piece: &Range<usize>,
        pieces: &mut Pieces,
    ) -> Option<Received> {
        let cone_of = |effect: &Effect| match *effect {
            Effect::Within(cone) => Some(cone),
            Effect::Nothing
            | Effect::All
            | Effect::Cut(_)
            | Effect::Without(_)
            | Effect::Ring { .. } => None,
        };
        // Not counted are cones inside of others.
        let mut counts = [true; MOST_EFFECTS];
        let mut both = Received::NOTHING;
        for (place, effect) in effects.iter().enumerate() {
            let cone = cone_of(effect)?;
            for (other_place, other) in effects[..place].iter().enumerate() {
                if !(counts[place] && counts[other_place]) {
                    continue;
                }
                let other = cone_of(other)?;
                match meeting(&cone, &other) {
                    Meeting::Apart => {}
                    Meeting::FirstInside => counts[place] = false,
                    Meeting::SecondInside => counts[other_place] = false,
                    Meeting::Crossing(crossing)
                        if effects.len() == 2 && is_one_inside(light, [&cone, &other]) =>
                    {
                        both = self.crossing(&crossing, [&cone, &other], piece, pieces)?;
                    }
                    Meeting::Crossing(_) | Meeting::Unknown => return None,
                }
            }
        }
        let mut seen = self.received(pieces.corners(piece))? + both;
        for (effect, _) in effects.iter().zip(counts).filter(|(_, counts)| *counts) {
            seen -= self.lit(light, &cone_of(effect)?, piece, pieces)?;
        }
        Some(seen)
    }

    /// What is received of the light within a cone, where the light fills the piece or is a cone.
    fn lit(
        &self,
        light: Option<WholeCone>,
        cone: &WholeCone,
        piece: &Range<usize>,
        pieces: &mut Pieces,
    ) -> Option<Received> {
        match light {
            None => self.within(cone, pieces.corners(piece)),
            Some(light) => self.common(&light, cone, piece, pieces),
        }
    }

    /// What is received of a piece within two cones.
    fn common(
        &self,
        first: &WholeCone,
        second: &WholeCone,
        piece: &Range<usize>,
        pieces: &mut Pieces,
    ) -> Option<Received> {
        match meeting(first, second) {
            Meeting::Apart => Some(Received::NOTHING),
            Meeting::FirstInside => self.within(first, pieces.corners(piece)),
            Meeting::SecondInside => self.within(second, pieces.corners(piece)),
            Meeting::Crossing(crossing) => self.crossing(&crossing, [first, second], piece, pieces),
            Meeting::Unknown => None,
        }
    }

    fn crossing(
        &self,
        crossing: &Crossing,
        [first, second]: [&WholeCone; 2],
        piece: &Range<usize>,
        pieces: &mut Pieces,
    ) -> Option<Received> {
        let mut sum = Received::NOTHING;
        let mut rest = piece.clone();
        let last = crossing.count() - 1;
        for (place, ([from, to], is_first_inside)) in crossing.chords().enumerate() {
            let inner = if is_first_inside { first } else { second };
            // Two places have one chord, of which the last segment is the other side.
            let is_rest = place == last && last == 1;
            let split = if is_rest {
                Split::Outside
            } else {
                pieces.split(&rest, across(from, to))
            };
            match split {
                Split::Inside => {}
                Split::Outside => {
                    return Some(sum + self.within(inner, pieces.corners(&rest))?);
                }
                Split::Both { inside, outside } => {
                    if !outside.is_empty() {
                        sum += self.within(inner, pieces.corners(&outside))?;
                    }
                    if inside.is_empty() {
                        return Some(sum);
                    }
                    rest = inside;
                }
            }
        }
        Some(sum + self.receiver.of_polygon(pieces.corners(&rest)))
    }
}

/// Whether what two cones have in common is lit.
fn is_one_inside(light: Option<WholeCone>, cones: [&WholeCone; 2]) -> bool {
    light.is_none_or(|light| {
        cones
            .iter()
            .any(|cone| matches!(meeting(cone, &light), Meeting::FirstInside))
    })
}
