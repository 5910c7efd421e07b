//! Rays that go much the same way along the shapes of one kind: sixteen at a time.

use fearless_simd::Simd;

use super::{Along, Search};
use crate::simd::{LANES, Mask64x16, ones};
use crate::visibility::batch::{BATCH, PACKETS, first_lanes};
use crate::visibility::ray_batch::{IncoherentRays, RayStarts};
use crate::visibility::rays::ShearedRays;
use crate::visibility::shape::{Block, Shape};
use crate::visibility::tree::{Approach, Beam, Descents, PacketDescent, Tree, TreeRay};

/// Fewer rays than these go alone, and are put to a leaf's shapes alone.
const FEWEST: u32 = 4;

/// Rays of a packet that ask something.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct AskedPacket<'b, S: Simd> {
    /// All rays of its batch.
    batch: &'b IncoherentRays,
    pub(in crate::visibility) rays: ShearedRays<S>,
    /// Where they leave surfaces, if they do.
    pub(in crate::visibility) starts: Option<RayStarts<S>>,
    /// The first of them in its batch.
    pub(in crate::visibility) first: usize,
    /// Those that ask, by bits and by lanes.
    pub(in crate::visibility) bits: u32,
    pub(in crate::visibility) asked: Mask64x16<S>,
}

impl<S: Simd> AskedPacket<'_, S> {
    #[inline(always)]
    fn ask_only(&mut self, simd: S, bits: u32) {
        self.bits = bits;
        self.asked = Mask64x16::from_bits(simd, bits);
    }
}

/// What rays ask on their way along shapes, alone or in packets: one in lane i of its packet has begun at place i.
pub(in crate::visibility) trait AlongInPackets<S: Simd, T: Shape>:
    Along<S, T::Block>
{
    /// Asks one shape for all rays of a packet that ask.
    fn show_shape(&mut self, simd: S, packet: &AskedPacket<'_, S>, shape: &T);

    /// How far the ray at a place goes, in t.
    fn limit(&self, place: usize) -> f64;
}

impl<T: Shape> Search<T> {
    /// Takes rays along all blocks that they may meet, near ones first: those of a packet together if they go much the
    /// same way, the others one by one.
    #[inline(always)]
    pub(in crate::visibility) fn along_in_packets<S: Simd, A: AlongInPackets<S, T>>(
        &self,
        simd: S,
        rays: &IncoherentRays,
        asker: &mut A,
        descents: &mut Descents,
    ) {
        let count = rays.count();
        // Leaves of a surface across the tree; a list has none.
        let fineness = match &self.tree {
            Some(tree) => (self.blocks.len() as f64).sqrt() / (2.0 * tree.reach),
            None => 0.0,
        };
        let mut alone = [0_u16; BATCH];
        let mut alone_count = 0;
        for packet in 0..PACKETS {
            let asked = first_lanes(count, packet);
            if asked == 0 {
                break;
            }
            let lanes = rays.packet(simd, packet);
            let beam = if asked.count_ones() >= FEWEST {
                Beam::around(simd, &self.frame, &lanes, asked, fineness)
            } else {
                None
            };
            if let Some(beam) = beam {
                let packet = AskedPacket {
                    batch: rays,
                    rays: ShearedRays::new(lanes),
                    starts: rays.starts_of_packet(simd, packet),
                    first: packet * LANES,
                    bits: asked,
                    asked: Mask64x16::from_bits(simd, asked),
                };
                let together = &mut descents.together;
                self.along_together(simd, packet, beam, asker, together);
            } else {
                for lane in ones(asked) {
                    alone[alone_count] = (packet * LANES + lane) as u16;
                    alone_count += 1;
                }
            }
        }
        let alone = alone[..alone_count].iter().map(|&ray| usize::from(ray));
        self.along::<S, A, true>(simd, alone, asker, &mut descents.alone);
    }

    #[inline(always)]
    fn along_together<S: Simd, A: AlongInPackets<S, T>>(
        &self,
        simd: S,
        mut packet: AskedPacket<'_, S>,
        beam: Beam,
        asker: &mut A,
        descent: &mut PacketDescent,
    ) {
        let mut asked = 0;
        for lane in ones(packet.bits) {
            let is_asked = asker.begin(lane, packet.first + lane).is_some();
            asked |= u32::from(is_asked) << lane;
        }
        packet.ask_only(simd, asked);
        for (block, _, bits) in self.blocks(0, self.listed) {
            self.show_near(simd, &packet, &beam, block, bits, asker);
        }
        if let Some(tree) = &self.tree {
            descent.begin(beam, &packet.rays.rays);
            if descent.meets(simd, tree) {
                self.down_together(simd, &mut packet, &beam, tree, asker, descent);
            }
        }
        for lane in ones(asked) {
            asker.end(lane);
        }
    }

    /// Shows the shapes of a block that a beam might meet to all rays of a packet that ask.
    #[inline(always)]
    fn show_near<S: Simd, A: AlongInPackets<S, T>>(
        &self,
        simd: S,
        packet: &AskedPacket<'_, S>,
        beam: &Beam,
        block: &T::Block,
        bits: u32,
        asker: &mut A,
    ) {
        for place in ones(bits & block.near(simd, beam)) {
            asker.show_shape(simd, packet, &block.get(&self.exact, place));
        }
    }

    /// Takes the rays of a packet that ask down a tree.
    #[inline(always)]
    fn down_together<S: Simd, A: AlongInPackets<S, T>>(
        &self,
        simd: S,
        packet: &mut AskedPacket<'_, S>,
        beam: &Beam,
        tree: &Tree,
        asker: &mut A,
        descent: &mut PacketDescent,
    ) {
        let mut on_their_way = 0;
        for lane in ones(packet.bits) {
            let [origin, direction] = packet.batch.ray(packet.first + lane);
            match TreeRay::approach(tree, origin, direction, 0.0) {
                Approach::Beside => {}
                Approach::Towards(ray) => {
                    descent.take(lane, ray, asker.limit(lane));
                    on_their_way |= 1 << lane;
                }
                Approach::Untold => self.show_all(simd, lane, tree, asker),
            }
        }
        if on_their_way == 0 {
            return;
        }
        descent.open_root(simd, tree, on_their_way);
        while let Some(leaf) = descent.next_leaf(simd, tree) {
            if let Some(block) = descent.look_ahead(tree) {
                self.blocks[block as usize].touch();
            }
            let blocks = self.blocks(leaf.block as usize, leaf.count as usize);
            if leaf.rays.count_ones() < FEWEST {
                for (block, _, bits) in blocks {
                    for lane in ones(leaf.rays) {
                        asker.show(simd, lane, block, bits);
                    }
                }
            } else {
                packet.ask_only(simd, leaf.rays);
                for (block, _, bits) in blocks {
                    self.show_near(simd, packet, beam, block, bits, asker);
                }
            }
            for lane in ones(leaf.rays) {
                descent.go_up_to(lane, asker.limit(lane));
            }
            descent.look(simd);
        }
    }
}
