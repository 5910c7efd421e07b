//! Sixteen rays on their way down a tree together.
//!
//! A node's eight boxes are put to the [`Beam`] around all of them, and what it meets to the slabs of each ray. So a
//! box is opened for the rays that may meet it, and for no others.

use fearless_simd::Simd;

use super::beam::Beam;
use super::node::WIDTH;
use super::ray::{DESCENTS, Descent, TreeRay};
use super::stack::STACK;
use super::wide::{Tree, WideNode};
use crate::simd::{F32x16, LANES, ones};
use crate::visibility::batch::Row;
use crate::visibility::rays::Rays;

/// A box that waits to be opened.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    /// A node, or the first block of the shapes.
    child: u32,
    /// How many shapes; 0 for a node.
    count: u32,
    /// How deep it begins along the beam.
    at: f32,
    /// One bit for each ray that may meet it.
    rays: u32,
}

/// Slabs of rays as [`TreeRay`] has them, lane by lane.
#[derive(Debug)]
struct Slabs {
    inverse: [Row; 3],
    near: [Row; 3],
    far: [Row; 3],
    /// How far each ray goes.
    limit: Row,
}

/// Rays on their way down a tree.
#[derive(Debug)]
pub(in crate::visibility) struct PacketDescent {
    beam: Beam,
    slabs: Slabs,
    rays: [TreeRay; LANES],
    /// How far each ray goes, in t of the world.
    limits: [f64; LANES],
    /// How deep each ray starts along the beam, and what it gains with t, in the tree's frame.
    starts: [f64; LANES],
    speeds: [f64; LANES],
    /// How deep each ray goes, and the deepest of all.
    depth: Row,
    deepest: f32,
    stack: Box<[Waiting; STACK]>,
    height: usize,
}

/// Ways down a tree of rays that share nothing, and of those that go much the same way.
#[derive(Debug, Default)]
pub(in crate::visibility) struct Descents {
    pub(in crate::visibility) alone: [Descent; DESCENTS],
    pub(in crate::visibility) together: PacketDescent,
}

/// A leaf that some of the rays may meet.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct PacketLeaf {
    /// The first block, and how many shapes there are.
    pub(in crate::visibility) block: u32,
    pub(in crate::visibility) count: u32,
    /// One bit for each ray that may meet it.
    pub(in crate::visibility) rays: u32,
}

impl Slabs {
    const NONE: Self = Self {
        inverse: [Row([0.0; LANES]); 3],
        near: [Row([0.0; LANES]); 3],
        far: [Row([0.0; LANES]); 3],
        limit: Row([0.0; LANES]),
    };

    /// One bit for each ray that may meet the box of a child.
    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, node: &WideNode, child: usize) -> u32 {
        let mut begin = F32x16::splat(simd, 0.0);
        let mut end = F32x16::load(simd, &self.limit.0);
        for axis in 0..3 {
            let [lower, upper] = &node.planes[axis];
            let inverse = F32x16::load(simd, &self.inverse[axis].0);
            let at_lower = inverse * F32x16::splat(simd, lower[child]);
            let at_upper = inverse * F32x16::splat(simd, upper[child]);
            let near = F32x16::load(simd, &self.near[axis].0);
            let far = F32x16::load(simd, &self.far[axis].0);
            begin = begin.max(at_lower.min(at_upper) + near);
            end = end.min(at_lower.max(at_upper) + far);
        }
        begin.le(end).to_bits()
    }
}

impl Default for PacketDescent {
    fn default() -> Self {
        let nothing = Waiting {
            child: 0,
            count: 0,
            at: 0.0,
            rays: 0,
        };
        Self {
            beam: Beam::NONE,
            slabs: Slabs::NONE,
            rays: [TreeRay::NONE; LANES],
            limits: [f64::NAN; LANES],
            starts: [0.0; LANES],
            speeds: [0.0; LANES],
            depth: Row([f32::NEG_INFINITY; LANES]),
            deepest: f32::NEG_INFINITY,
            stack: Box::new([nothing; STACK]),
            height: 0,
        }
    }
}

impl PacketDescent {
    /// Sets out with the rays of a beam.
    #[inline(always)]
    pub(in crate::visibility) fn begin<S: Simd>(&mut self, beam: Beam, rays: &Rays<S>) {
        let [starts, speeds] = beam.depths(rays);
        starts.store(&mut self.starts);
        speeds.store(&mut self.speeds);
        self.beam = beam;
        self.depth = Row([f32::NEG_INFINITY; LANES]);
        self.deepest = f32::NEG_INFINITY;
        self.height = 0;
    }

    /// Whether any box of the root is met by the beam.
    #[inline(always)]
    pub(in crate::visibility) fn meets<S: Simd>(&self, simd: S, tree: &Tree) -> bool {
        self.beam.meet(simd, &tree.nodes[0], f32::INFINITY).0 != 0
    }

    /// Takes a ray along, up to t of `limit`.
    #[inline(always)]
    pub(in crate::visibility) fn take(&mut self, lane: usize, ray: TreeRay, limit: f64) {
        for axis in 0..3 {
            let slab = ray.slab_of(axis);
            self.slabs.inverse[axis].0[lane] = slab[0];
            self.slabs.near[axis].0[lane] = slab[1];
            self.slabs.far[axis].0[lane] = slab[2];
        }
        self.rays[lane] = ray;
        self.limits[lane] = f64::NAN;
        self.go_up_to(lane, limit);
    }

    /// A ray goes up to t of `limit` from now on.
    #[inline(always)]
    pub(in crate::visibility) fn go_up_to(&mut self, lane: usize, limit: f64) {
        if limit == self.limits[lane] {
            return;
        }
        self.limits[lane] = limit;
        self.slabs.limit.0[lane] = self.rays[lane].limit(limit);
        let depth = self.starts[lane] + limit * self.speeds[lane];
        self.depth.0[lane] = Beam::limit_in_frame(depth, self.starts[lane]);
    }

    /// Opens the root for the rays with a bit.
    #[inline(always)]
    pub(in crate::visibility) fn open_root<S: Simd>(&mut self, simd: S, tree: &Tree, rays: u32) {
        self.look(simd);
        self.open(simd, &tree.nodes[0], rays);
    }

    /// Looks how deep any ray still goes.
    #[inline(always)]
    pub(in crate::visibility) fn look<S: Simd>(&mut self, simd: S) {
        self.deepest = F32x16::load(simd, &self.depth.0).largest();
    }

    /// The next leaf that some rays may meet, near ones first.
    #[inline(always)]
    pub(in crate::visibility) fn next_leaf<S: Simd>(
        &mut self,
        simd: S,
        tree: &Tree,
    ) -> Option<PacketLeaf> {
        while self.height > 0 {
            self.height -= 1;
            let Waiting {
                child,
                count,
                at,
                rays,
            } = self.stack[self.height];
            if at > self.deepest {
                continue;
            }
            let depth = F32x16::load(simd, &self.depth.0);
            let rays = rays & depth.ge(F32x16::splat(simd, at)).to_bits();
            if rays == 0 {
                continue;
            }
            if count > 0 {
                return Some(PacketLeaf {
                    block: child,
                    count,
                    rays,
                });
            }
            self.open(simd, &tree.nodes[child as usize], rays);
        }
        None
    }

    /// The first block of the leaf that is likely to be next; a node is touched instead.
    #[inline(always)]
    pub(in crate::visibility) fn look_ahead(&self, tree: &Tree) -> Option<u32> {
        let next = self.stack.get(self.height.wrapping_sub(1))?;
        if next.count > 0 {
            return Some(next.child);
        }
        tree.nodes[next.child as usize].touch();
        None
    }

    /// Puts the children that rays with a bit may meet on the stack, the nearest on top.
    #[inline(always)]
    fn open<S: Simd>(&mut self, simd: S, node: &WideNode, asked: u32) {
        let (bits, at): (u32, [f32; WIDTH]) = self.beam.meet(simd, node, self.deepest);
        let bottom = self.height;
        for child in ones(bits) {
            let rays = self.slabs.meet(simd, node, child) & asked;
            if rays == 0 {
                continue;
            }
            let waiting = Waiting {
                child: node.children[child],
                count: node.counts[child],
                at: at[child],
                rays,
            };
            let mut place = self.height;
            while place > bottom && self.stack[place - 1].at < waiting.at {
                self.stack[place] = self.stack[place - 1];
                place -= 1;
            }
            self.stack[place] = waiting;
            self.height += 1;
        }
    }
}
