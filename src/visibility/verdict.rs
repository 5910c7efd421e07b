//! What is made of what shapes say of the rays on a [`Canvas`].

use fearless_simd::Simd;

use super::canvas::{Canvas, State};
use super::surface::{Only, PACKETS, Points};
use super::{Primitive, way};
use crate::math::Point;
use crate::simd::{F32x16, LANES, Mask32x16, U32x16, U64x16};

/// Which shape it is.
#[derive(Clone, Copy)]
pub(super) struct Who {
    pub(super) slot: u32,
    pub(super) primitive: Primitive,
}

/// What a shape says of the rays of a packet.
#[derive(Clone, Copy)]
pub(super) struct Claim<S: Simd> {
    /// Those that may meet it.
    pub(super) maybe: Mask32x16<S>,
    /// Those that do, certainly.
    pub(super) surely: Mask32x16<S>,
    /// Between which closenesses they do.
    pub(super) least: F32x16<S>,
    pub(super) most: F32x16<S>,
}

/// What is made of the claims.
pub(super) trait Verdict: Copy {
    /// Whether all rays end on the shape.
    fn are_all_on(self, who: Who) -> bool;

    /// Takes note on a canvas that is only aimed of a shape that may be of interest: `cover` is between which
    /// closenesses all rays surely meet it, if they do, and `most` the largest at which any does. Whether
    /// no ray need be asked.
    fn settles(self, canvas: &mut Canvas, who: Who, cover: Option<[f32; 2]>, most: f32) -> bool;

    /// Stretches a canvas that is only aimed; whether it is fit for its rays.
    fn is_ready<S: Simd>(self, simd: S, canvas: &mut Canvas) -> bool;

    /// Takes note of a claim of the shape.
    fn hear<S: Simd>(self, simd: S, canvas: &mut Canvas, packet: usize, who: Who, claim: Claim<S>);

    /// The shape cannot be told from f32: all rays of a packet that may meet it are asked again.
    fn abstain<S: Simd>(self, simd: S, canvas: &mut Canvas, packet: usize, who: Who);

    /// A sphere that the end of a ray is on may hide it all the same: those are asked again that are seen from
    /// within, and of one that cannot be told all.
    fn doubt_own<S: Simd>(
        self,
        simd: S,
        canvas: &mut Canvas,
        packet: usize,
        who: Who,
        is_untold: bool,
    );
}

/// What is the first that a primary ray meets?
#[derive(Clone, Copy)]
pub(super) struct First;

/// Which points does the light reach, of those with a bit?
#[derive(Clone, Copy)]
pub(super) struct Reached<'p> {
    /// Where the light is.
    pub(super) light: Point,
    pub(super) points: &'p Points,
    pub(super) asked: &'p [u32; PACKETS],
}

impl Reached<'_> {
    /// The points of a packet that are on a shape.
    #[inline(always)]
    fn are_on<S: Simd>(self, simd: S, packet: usize, who: Who) -> Mask32x16<S> {
        let on = U64x16::load(simd, &self.points.primitive[packet * LANES..]);
        Mask32x16::from_bits(simd, on.eq(who.primitive.lanes(simd)).to_bits())
    }

    /// Stretches a canvas before the light.
    #[inline(never)]
    pub(super) fn stretch<S: Simd>(self, simd: S, canvas: &mut Canvas) {
        simd.vectorize(
            #[inline(always)]
            || {
                canvas.stretch(
                    simd,
                    self.asked,
                    #[inline(always)]
                    |packet| way(simd, self.points, packet, self.light),
                );
            },
        );
    }
}

impl Verdict for First {
    #[inline(always)]
    fn are_all_on(self, _: Who) -> bool {
        false
    }

    #[inline(always)]
    fn settles(self, canvas: &mut Canvas, who: Who, cover: Option<[f32; 2]>, most: f32) -> bool {
        if canvas.state != State::Aimed {
            return false;
        }
        let before = canvas.cover.map(|cover| cover.range);
        match (cover, before) {
            (_, Some([least, _])) if most < least => {}
            (Some(range), None) => canvas.cover_with(who, range),
            (Some(range), Some([_, most])) if range[0] > most => canvas.cover_with(who, range),
            _ => canvas.close(State::Unclear),
        }
        true
    }

    #[inline(always)]
    fn is_ready<S: Simd>(self, _: S, canvas: &mut Canvas) -> bool {
        canvas.state == State::Stretched
    }

    #[inline(always)]
    fn hear<S: Simd>(self, simd: S, canvas: &mut Canvas, packet: usize, who: Who, claim: Claim<S>) {
        let first = packet * LANES;
        let least = F32x16::load(simd, &canvas.least.0[first..]);
        let maybe = claim.maybe & claim.most.ge(least);
        let bits = maybe.to_bits();
        if bits == 0 {
            return;
        }
        let most = F32x16::load(simd, &canvas.most.0[first..]);
        let is_nearer = maybe & claim.surely & claim.least.gt(most);
        let nearer = is_nearer.to_bits();
        let least = is_nearer.select(claim.least, least);
        least.store(&mut canvas.least.0[first..]);
        let doubt = bits & !nearer;
        let most_of_both = most.max(claim.most);
        let most = Mask32x16::from_bits(simd, doubt).select(most_of_both, most);
        is_nearer
            .select(claim.most, most)
            .store(&mut canvas.most.0[first..]);
        let slots = U32x16::load(simd, &canvas.slots[first..]);
        let slots = is_nearer.select_words(U32x16::splat(simd, who.slot), slots);
        slots.store(&mut canvas.slots[first..]);
        canvas.doubtful[packet] = canvas.doubtful[packet] & !nearer | doubt;
        canvas.far.0[packet] = least.smallest();
    }

    #[inline(always)]
    fn abstain<S: Simd>(self, simd: S, canvas: &mut Canvas, packet: usize, _: Who) {
        canvas.undecided[packet] |= canvas.asking(simd, packet).to_bits();
    }

    #[inline(always)]
    fn doubt_own<S: Simd>(self, _: S, _: &mut Canvas, _: usize, _: Who, _: bool) {}
}

impl Verdict for Reached<'_> {
    #[inline(always)]
    fn are_all_on(self, who: Who) -> bool {
        self.points.only == Only::One(who.primitive)
    }

    #[inline(always)]
    fn settles(self, canvas: &mut Canvas, who: Who, cover: Option<[f32; 2]>, _: f32) -> bool {
        let is_before = cover.is_some_and(|[least, _]| least > canvas.nearest_end);
        let are_others = matches!(self.points.only, Only::One(own) if own != who.primitive);
        let is_dark = canvas.state == State::Aimed && is_before && are_others;
        if is_dark {
            canvas.close(State::Dark);
        }
        is_dark
    }

    #[inline(always)]
    fn is_ready<S: Simd>(self, simd: S, canvas: &mut Canvas) -> bool {
        if canvas.state == State::Aimed {
            self.stretch(simd, canvas);
        }
        canvas.state == State::Stretched
    }

    #[inline(always)]
    fn hear<S: Simd>(self, simd: S, canvas: &mut Canvas, packet: usize, who: Who, claim: Claim<S>) {
        let first = packet * LANES;
        let least = F32x16::load(simd, &canvas.least.0[first..]);
        let maybe = claim.maybe & claim.most.ge(least);
        if maybe.to_bits() == 0 {
            return;
        }
        let maybe = maybe & !self.are_on(simd, packet, who);
        let bits = maybe.to_bits();
        if bits == 0 {
            return;
        }
        let most = F32x16::load(simd, &canvas.most.0[first..]);
        let is_dark = maybe & claim.surely & claim.least.gt(most);
        let dark = is_dark.to_bits();
        canvas.doubtful[packet] = (canvas.doubtful[packet] | bits) & !dark;
        canvas.undecided[packet] &= !dark;
        if dark != 0 {
            let infinite = F32x16::splat(simd, f32::INFINITY);
            let least = is_dark.select(infinite, least);
            least.store(&mut canvas.least.0[first..]);
            canvas.far.0[packet] = least.smallest();
        }
    }

    #[inline(always)]
    fn abstain<S: Simd>(self, simd: S, canvas: &mut Canvas, packet: usize, who: Who) {
        let own = self.are_on(simd, packet, who);
        canvas.undecided[packet] |= (canvas.asking(simd, packet) & !own).to_bits();
    }

    #[inline(always)]
    fn doubt_own<S: Simd>(
        self,
        simd: S,
        canvas: &mut Canvas,
        packet: usize,
        who: Who,
        is_untold: bool,
    ) {
        let own = self.are_on(simd, packet, who);
        let own = (canvas.asking(simd, packet) & own).to_bits();
        let of_those = if is_untold {
            own
        } else {
            self.points.within[packet]
        };
        canvas.undecided[packet] |= own & of_those;
    }
}
