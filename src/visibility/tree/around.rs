//! A beam around rays that start anywhere and go much the same way.
//!
//! With w along the middle of their directions, no ray loses height along n = u − l w, where l is the least slope of any along
//! u: n · (o + t d) = n · o + t (d · u − l d · w). So all of it is beyond the least n · o.

use fearless_simd::Simd;

use super::beam::{Beam, REACH, Side};
use super::frame::TreeFrame;
use crate::math::DVec3;
use crate::simd::{DVec3x16, F64x16, Mask64x16};
use crate::visibility::batch::range;
use crate::visibility::rays::{ROUNDING, Rays};

/// Rays whose beam would meet more leaves than this share none.
const MOST_LEAVES: f64 = 1024.0;

/// Rays that start further away than this, in sizes of the frame, share none: f64 places them worse than f32 does the
/// planes of a beam, and what they meet is a matter of rounding.
const FARTHEST_START: f64 = (1_u64 << 28) as f64;

/// Rays as seen from the middle of a frame, those that are asked.
struct FramedRays<S: Simd> {
    simd: S,
    origin: DVec3x16<S>,
    direction: DVec3x16<S>,
    /// w, and what each gains along it.
    along: DVec3,
    pace: F64x16<S>,
    asked: Mask64x16<S>,
    /// How far from the middle they start at most, in lengths of the frame.
    distance: f64,
    scale: f64,
}

impl<S: Simd> FramedRays<S> {
    /// `None` if they do not all go one way, or start too far away.
    #[inline(always)]
    fn new(simd: S, frame: &TreeFrame, rays: &Rays<S>, asked: u32) -> Option<Self> {
        let asked = Mask64x16::from_bits(simd, asked);
        let d = rays.direction;
        let x = range(simd, d.x, asked);
        let y = range(simd, d.y, asked);
        let z = range(simd, d.z, asked);
        let along = DVec3::new(x[0] + x[1], y[0] + y[1], z[0] + z[1]).try_normalize()?;
        let pace = d.dot_with(along);
        let [slowest, _] = range(simd, pace, asked);
        if slowest.is_nan() || slowest <= 0.0 {
            return None;
        }
        let origin = rays.origin.minus(frame.center);
        let [_, distance] = range(simd, origin.taxicab(), asked);
        let distance = distance * frame.scale;
        if distance.is_nan() || distance > FARTHEST_START {
            return None;
        }
        Some(Self {
            simd,
            origin,
            direction: d,
            along,
            pace,
            asked,
            distance,
            scale: frame.scale,
        })
    }

    /// The least and the most slope along an axis across w, and how wide the beam is where it leaves the frame.
    #[inline(always)]
    fn across(&self, axis: DVec3) -> ([f64; 2], f64) {
        let slopes = self.direction.dot_with(axis) / self.pace;
        let [least, most] = range(self.simd, slopes, self.asked);
        let [first, last] = range(self.simd, self.origin.dot_with(axis), self.asked);
        let width = (most - least) * (self.distance + REACH) + (last - first) * self.scale;
        let rounding = (least.abs() + most.abs() + 1.0) * ROUNDING;
        ([least - rounding, most + rounding], width)
    }

    /// What is as far along a normal as the starts are, and somewhat more.
    #[inline(always)]
    fn side(&self, normal: DVec3) -> Side {
        let [least, _] = range(self.simd, self.origin.dot_with(normal), self.asked);
        Side::new(normal, least * self.scale, self.distance, 0.0)
    }
}

impl Beam {
    /// Rays with a bit in `asked`; `None` if they are so far apart that their beam meets more than [`MOST_LEAVES`] among
    /// leaves of which there are `fineness` across one unit of the frame.
    #[inline(always)]
    pub(in crate::visibility) fn around<S: Simd>(
        simd: S,
        frame: &TreeFrame,
        rays: &Rays<S>,
        asked: u32,
        fineness: f64,
    ) -> Option<Self> {
        let rays = FramedRays::new(simd, frame, rays, asked)?;
        let w = rays.along;
        let (u, v) = w.any_orthonormal_pair();
        let ([left, right], wide) = rays.across(u);
        let ([bottom, top], high) = rays.across(v);
        let leaves = (wide * fineness + 1.0) * (high * fineness + 1.0);
        if leaves.is_nan() || leaves > MOST_LEAVES {
            return None;
        }
        let start = rays.side(w);
        Some(Self {
            sides: [
                rays.side(u - w * left),
                rays.side(w * right - u),
                rays.side(v - w * bottom),
                rays.side(w * top - v),
            ],
            start,
            behind: start.offset,
            center: frame.center,
            scale: frame.scale,
        })
    }
}
