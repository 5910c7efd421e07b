//! Builds the tree: from the root down, by the surface area heuristic over bins.
//!
//! The chance that a ray meets a box goes with the box's surface, so a set of shapes is parted
//! where the sum of surface times count of both sides is least (MacDonald & Booth 1990). Only the
//! borders of equal bins of the shapes' centers are tried, along each axis (Wald 2007, "On fast
//! construction of SAH-based bounding volume hierarchies"). A node is made by parting its largest
//! part until there are eight.
//!
//! Takes O(n log n) time for any boxes. How the work is cut depends on the shapes alone, so the
//! tree is the same for any number of threads.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::node::{BuildNode, Child, Member, PackedNodes, WIDTH};
use crate::math::all_three;

/// Bins along each axis.
const BINS: usize = 16;

/// Bins along each axis where there are fewer shapes than [`MANY`]: less to sum up for each.
const FEW_BINS: usize = 8;

/// See [`FEW_BINS`].
const MANY: usize = 64;

/// Up to so many leaves of more than one shape, shapes are parted so that leaves are full, where that is
/// along the axis on which they are widest: what a leaf costs does not depend on how many it has.
const FULL_LEAVES: usize = 8;

/// Up to this many shapes make a subtree that one thread builds.
const SUBTREE: usize = 4096;

/// From this many shapes on, they are measured and put into bins by all threads.
const LARGE: usize = 1 << 17;

/// Binary partings below the root that go by surface; from there on a set is halved. So however
/// shapes lie, their tree is no deeper than this and the logarithm of their number, 64 together.
const BY_SURFACE: u32 = 32;

/// Numbers of this magnitude are 1 apart: adding it rounds a small number to an integer, which
/// stands in the low bits.
const ROUNDS_TO_INTEGER: f32 = (1 << 23) as f32;

/// A shape's box, and which shape it is.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct Item {
    /// Its last lanes have no part in the box: they hold the two halves of the shape's index, as
    /// integers, which f32 represents exactly.
    bounds: Box4,
}

/// A box in registers; the last lanes mean nothing.
#[derive(Clone, Copy, Debug)]
struct Box4 {
    min: Vec4,
    max: Vec4,
}

/// A set of shapes on its way into a tree.
#[derive(Clone, Copy, Debug)]
struct Part {
    start: usize,
    end: usize,
    bounds: Box4,
    /// Binary partings above it.
    depth: u32,
    /// Whether it is to stay as it is, since no plane parts its shapes.
    is_whole: bool,
}

/// Where a set of shapes is parted: below bin `border` along `axis`.
#[derive(Clone, Copy, Debug)]
struct Border {
    axis: usize,
    bin: u32,
    below: Box4,
    above: Box4,
}

/// Bins along three axes.
struct Bins<const N: usize> {
    boxes: [[Box4; N]; 3],
    counts: [[u32; N]; 3],
}

/// From centers to bins.
#[derive(Clone, Copy, Debug)]
struct Binning {
    /// The least of all centers, doubled.
    origin: Vec4,
    /// Bins per length, 0 along an axis that cannot part the centers.
    density: Vec4,
}

/// The upper part of a tree.
enum Top {
    /// Two parts.
    Parted { bounds: Box4, parts: Box<[Self; 2]> },
    /// A tree of its own, whose root comes first.
    Subtree { bounds: Box4, nodes: PackedNodes },
    /// Shapes that no plane parts.
    Leaf { bounds: Box4, child: Child },
}

/// The tree over `count` shapes but the `listed` ones, with `leaf_size` of them in a leaf at most, but for
/// those that no plane parts: its root first, and the order in which its leaves have the shapes. There is
/// one at least; their boxes, which `item` gives by their numbers, are within `bounds`.
pub(in crate::visibility) fn build(
    count: u32,
    listed: &[u32],
    bounds: [Vec3; 2],
    item: &(impl Fn(u32) -> Item + Sync),
    leaf_size: usize,
) -> (Vec<BuildNode>, Vec<u32>) {
    let (top, order) = if count as usize >= grid::LEAST {
        grid::build(count, listed, bounds, item, leaf_size)
    } else {
        let numbers = (0..count).into_par_iter();
        let mut items: Vec<Item> = numbers.map(item).collect();
        for &number in listed.iter().rev() {
            items.swap_remove(number as usize);
        }
        let bounds = bounds_of(&items);
        let top = Top::new(&mut items, 0, bounds, 0, leaf_size);
        let order = items.iter().map(Item::index);
        (top, order.collect())
    };
    (top.into_nodes(), order)
}

impl Top {
    /// A tree over items, of which `first` come before in the order of all.
    fn new(items: &mut [Item], first: usize, bounds: Box4, depth: u32, leaf_size: usize) -> Self {
        if items.len() <= SUBTREE {
            let mut nodes = Vec::with_capacity(items.len() / (2 * leaf_size) + 1);
            nodes.push(BuildNode::EMPTY);
            fill_node(&mut nodes, 0, items, first, bounds, depth, leaf_size);
            let nodes = PackedNodes::of(&nodes);
            return Self::Subtree { bounds, nodes };
        }
        let Some((count, below, above)) = part(items, depth, leaf_size) else {
            return Self::Leaf {
                bounds,
                child: leaf(first, items.len()),
            };
        };
        let (items_below, items_above) = items.split_at_mut(count);
        let (below, above) = rayon::join(
            || Self::new(items_below, first, below, depth + 1, leaf_size),
            || Self::new(items_above, first + count, above, depth + 1, leaf_size),
        );
        Self::Parted {
            bounds,
            parts: Box::new([below, above]),
        }
    }

    fn bounds(&self) -> &Box4 {
        match self {
            Self::Parted { bounds, .. }
            | Self::Subtree { bounds, .. }
            | Self::Leaf { bounds, .. } => bounds,
        }
    }

    /// Makes nodes of eight, and puts the subtrees behind them.
    fn into_nodes(self) -> Vec<BuildNode> {
        let mut upper = vec![BuildNode::EMPTY];
        let mut subtrees = Vec::new();
        match self {
            Self::Subtree { nodes, .. } => {
                let mut all = vec![BuildNode::EMPTY; nodes.len()];
                nodes.unpack(&mut all, 0);
                return all;
            }
            Self::Leaf { bounds, child } => upper[0].push(bounds.member(child)),
            Self::Parted { parts, .. } => {
                Self::fill_upper(&mut upper, 0, *parts, &mut subtrees);
            }
        }
        // Now it is known where each subtree goes.
        let mut end = upper.len() as u32;
        let mut starts = Vec::with_capacity(subtrees.len());
        for (subtree, holder, slot) in &subtrees {
            starts.push(end);
            upper[*holder].members_mut()[*slot].child = Child::Node(end);
            end += subtree.len() as u32;
        }
        let mut nodes = upper;
        let upper = nodes.len();
        nodes.resize(end as usize, BuildNode::EMPTY);
        let mut places = Vec::with_capacity(subtrees.len());
        let mut left = nodes.split_at_mut(upper).1;
        for ((subtree, ..), start) in subtrees.iter().zip(starts) {
            let place;
            (place, left) = left.split_at_mut(subtree.len());
            places.push((subtree, place, start));
        }
        let places = places.into_par_iter();
        places.for_each(|(subtree, place, start)| subtree.unpack(place, start));
        nodes
    }

    /// Fills the node at `place` from two parts; lists each subtree with the node and member
    /// that is to hold it.
    fn fill_upper(
        nodes: &mut Vec<BuildNode>,
        place: usize,
        parts: [Self; 2],
        subtrees: &mut Vec<(PackedNodes, usize, usize)>,
    ) {
        let mut open = Vec::with_capacity(WIDTH);
        open.extend(parts);
        while open.len() < WIDTH {
            let parted = (0..open.len()).filter(|&part| matches!(open[part], Self::Parted { .. }));
            let area = |part: usize| open[part].bounds().half_area();
            let Some(largest) = parted.max_by(|&a, &b| area(a).total_cmp(&area(b))) else {
                break;
            };
            if let Self::Parted { parts, .. } = open.swap_remove(largest) {
                open.extend(*parts);
            }
        }
        for part in open {
            let bounds = *part.bounds();
            match part {
                Self::Parted { parts, .. } => {
                    let child = nodes.len();
                    nodes.push(BuildNode::EMPTY);
                    nodes[place].push(bounds.member(Child::Node(child as u32)));
                    Self::fill_upper(nodes, child, *parts, subtrees);
                }
                Self::Subtree { nodes: below, .. } => {
                    subtrees.push((below, place, nodes[place].members().len()));
                    nodes[place].push(bounds.member(Child::Node(0)));
                }
                Self::Leaf { child, .. } => nodes[place].push(bounds.member(child)),
            }
        }
    }
}

/// Fills the node at `place` with the items, of which `first` come before in the order of all,
/// and makes the nodes below it.
fn fill_node(
    nodes: &mut Vec<BuildNode>,
    place: usize,
    items: &mut [Item],
    first: usize,
    bounds: Box4,
    depth: u32,
    leaf_size: usize,
) {
    let mut parts = [Part {
        start: 0,
        end: items.len(),
        bounds,
        depth,
        is_whole: false,
    }; WIDTH];
    let mut areas = [f32::INFINITY; WIDTH];
    let mut count = 1;
    while count < WIDTH {
        let may_part = |part: &usize| parts[*part].may_part(leaf_size);
        let largest = (0..count)
            .filter(may_part)
            .max_by(|&a, &b| areas[a].total_cmp(&areas[b]));
        let Some(largest) = largest else {
            break;
        };
        let part = parts[largest];
        let shapes = &mut items[part.start..part.end];
        if shapes.len() <= WIDTH - count + 1 {
            // All have a place of their own.
            for (number, shape) in shapes.iter().enumerate() {
                let slot = if number == 0 { largest } else { count };
                count += usize::from(number > 0);
                parts[slot] = Part {
                    start: part.start + number,
                    end: part.start + number + 1,
                    bounds: shape.bounds,
                    depth: part.depth,
                    is_whole: true,
                };
            }
            continue;
        }
        let Some((count_below, below, above)) = self::part(shapes, part.depth, leaf_size) else {
            parts[largest].is_whole = true;
            continue;
        };
        let middle = part.start + count_below;
        let half = |start: usize, end: usize, bounds: Box4| Part {
            start,
            end,
            bounds,
            depth: part.depth + 1,
            is_whole: false,
        };
        parts[largest] = half(part.start, middle, below);
        areas[largest] = below.half_area();
        parts[count] = half(middle, part.end, above);
        areas[count] = above.half_area();
        count += 1;
    }
    let parts = &parts[..count];
    let mut child = nodes.len();
    for part in parts {
        let child = if part.may_part(leaf_size) {
            nodes.push(BuildNode::EMPTY);
            Child::Node(nodes.len() as u32 - 1)
        } else {
            leaf(first + part.start, part.end - part.start)
        };
        nodes[place].push(part.bounds.member(child));
    }
    for part in parts.iter().filter(|part| part.may_part(leaf_size)) {
        let items = &mut items[part.start..part.end];
        let first = first + part.start;
        fill_node(
            nodes,
            child,
            items,
            first,
            part.bounds,
            part.depth,
            leaf_size,
        );
        child += 1;
    }
}

fn leaf(first: usize, count: usize) -> Child {
    Child::Leaf {
        first: first as u32,
        count: count as u32,
    }
}

impl Part {
    fn may_part(&self, leaf_size: usize) -> bool {
        !self.is_whole && self.end - self.start > leaf_size
    }
}

/// Puts items in two groups, one behind the other: the size of the first, and the boxes around
/// both. `None` where all have one center.
fn part(items: &mut [Item], depth: u32, leaf_size: usize) -> Option<(usize, Box4, Box4)> {
    let centers = centers_of(items);
    if leaf_size > 1 && items.len() <= leaf_size * FULL_LEAVES {
        Binning::new(&centers, FEW_BINS)?;
        let leaves = items.len().div_ceil(leaf_size);
        return Some(part_at(items, &centers, leaves / 2 * leaf_size));
    }
    if items.len() < MANY {
        part_at_bins::<FEW_BINS>(items, &centers, depth, |_| 1)
    } else {
        part_at_bins::<BINS>(items, &centers, depth, |_| 1)
    }
}

fn part_at_bins<const N: usize>(
    items: &mut [Item],
    centers: &Box4,
    depth: u32,
    weight: impl Fn(&Item) -> u32 + Sync,
) -> Option<(usize, Box4, Box4)> {
    let grid = Binning::new(centers, N)?;
    if depth >= BY_SURFACE {
        return Some(part_at(items, centers, items.len() / 2));
    }
    let bins = Bins::<N>::of(items, &grid, weight);
    // Some axis has a density above 0, and along it the least and the largest center are in the
    // first and the last bin.
    let border = bins.best_border(&grid)?;
    // Every item is swapped with the first that has to go above, in any case, and that place moves
    // on if the item is to be below: no branch to guess wrong.
    let mut place = 0;
    for next in 0..items.len() {
        let item = items[next];
        items.swap(next, place);
        place += usize::from(grid.bins(&item)[border.axis] < border.bin);
    }
    Some((place, border.below, border.above))
}

/// Parts items at some place of their order along the axis on which they are widest.
fn part_at(items: &mut [Item], centers: &Box4, middle: usize) -> (usize, Box4, Box4) {
    let size = (centers.max - centers.min).truncate();
    let axis = size.max_position();
    items.select_nth_unstable_by(middle, |a, b| a.center()[axis].total_cmp(&b.center()[axis]));
    let (below, above) = items.split_at(middle);
    (middle, bounds_of(below), bounds_of(above))
}

/// Folds items, by all threads where there are many. The order makes no difference to boxes and
/// counts.
fn fold<T: Send>(
    items: &[Item],
    some: impl Fn(&[Item]) -> T + Sync,
    both: impl Fn(T, T) -> T + Sync + Send,
) -> T {
    if items.len() < LARGE {
        return some(items);
    }
    let chunks = items.par_chunks(LARGE / 4).map(&some);
    chunks.reduce_with(both).unwrap_or_else(|| some(&[]))
}

fn bounds_of(items: &[Item]) -> Box4 {
    let some = |items: &[Item]| {
        let boxes = items.iter().map(|item| item.bounds);
        boxes.fold(Box4::EMPTY, |whole, one| whole.union(&one))
    };
    fold(items, some, |a, b| a.union(&b))
}

/// The box around the centers, doubled.
fn centers_of(items: &[Item]) -> Box4 {
    let some = |items: &[Item]| {
        let centers = items.iter().map(Item::center);
        centers.fold(Box4::EMPTY, |whole, center| {
            whole.union(&Box4 {
                min: center,
                max: center,
            })
        })
    };
    fold(items, some, |a, b| a.union(&b))
}

impl Binning {
    /// A grid of `bins` over these centers, `None` where they are one.
    fn new(centers: &Box4, bins: usize) -> Option<Self> {
        /// Below this, bins per length would not be finite.
        const SMALLEST: f32 = 1e-30;
        let size = centers.max - centers.min;
        let density = |size| {
            if size > SMALLEST {
                (bins - 1) as f32 / size
            } else {
                0.0
            }
        };
        let density = Vec4::new(density(size.x), density(size.y), density(size.z), 0.0);
        (density != Vec4::ZERO).then_some(Self {
            origin: centers.min,
            density,
        })
    }

    /// The bin of an item along each axis. The outer two are half as wide as the others: numbers are
    /// rounded to the nearest.
    #[inline(always)]
    fn bins(&self, item: &Item) -> [u32; 3] {
        let place = (item.center() - self.origin) * self.density + ROUNDS_TO_INTEGER;
        let [x, y, z, _] = place.to_array();
        all_three([x, y, z], |place| place.to_bits() & 0xff)
    }
}

impl<const N: usize> Bins<N> {
    const EMPTY: Self = Self {
        boxes: [[Box4::EMPTY; N]; 3],
        counts: [[0; N]; 3],
    };

    /// With as many shapes in each as the items are worth together.
    fn of(items: &[Item], grid: &Binning, weight: impl Fn(&Item) -> u32 + Sync) -> Self {
        let some = |items: &[Item]| {
            let mut bins = Self::EMPTY;
            for item in items {
                let places = grid.bins(item);
                let weight = weight(item);
                for (axis, place) in places.into_iter().enumerate() {
                    let place = place as usize % N;
                    let bin = &mut bins.boxes[axis][place];
                    *bin = bin.union(&item.bounds);
                    bins.counts[axis][place] += weight;
                }
            }
            bins
        };
        fold(items, some, |a, b| a.and(&b))
    }

    fn and(mut self, other: &Self) -> Self {
        for axis in 0..3 {
            for bin in 0..N {
                self.boxes[axis][bin] = self.boxes[axis][bin].union(&other.boxes[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
        self
    }

    /// The border between bins, with something on both sides, at which the sum of surface times
    /// count is least.
    fn best_border(&self, grid: &Binning) -> Option<Border> {
        let mut best: Option<Border> = None;
        let mut least = f32::INFINITY;
        for axis in 0..3 {
            if grid.density[axis] == 0.0 {
                continue;
            }
            let (boxes, counts) = (&self.boxes[axis], &self.counts[axis]);
            let mut above = [(Box4::EMPTY, 0.0); N];
            let mut whole = Box4::EMPTY;
            let mut count = 0;
            for bin in (1..N).rev() {
                whole = whole.union(&boxes[bin]);
                count += counts[bin];
                above[bin] = (whole, whole.half_area() * count as f32);
            }
            let all = count + counts[0];
            let mut below = Box4::EMPTY;
            let mut count = 0;
            for bin in 1..N {
                below = below.union(&boxes[bin - 1]);
                count += counts[bin - 1];
                let cost = below.half_area() * count as f32 + above[bin].1;
                if cost < least && count < all {
                    least = cost;
                    best = Some(Border {
                        axis,
                        bin: bin as u32,
                        below,
                        above: above[bin].0,
                    });
                }
            }
        }
        best
    }
}

impl Item {
    /// The box of shape number `index`.
    #[inline]
    pub(in crate::visibility) fn new(min: Vec3, max: Vec3, index: u32) -> Self {
        const HALF: u32 = u32::BITS / 2;
        let (low, high) = (index & ((1 << HALF) - 1), index >> HALF);
        Self {
            bounds: Box4 {
                min: min.extend(low as f32),
                max: max.extend(high as f32),
            },
        }
    }

    fn index(&self) -> u32 {
        const HALF: u32 = u32::BITS / 2;
        self.bounds.min.w as u32 | (self.bounds.max.w as u32) << HALF
    }

    /// The middle of the box, doubled.
    #[inline(always)]
    fn center(&self) -> Vec4 {
        self.bounds.min + self.bounds.max
    }
}

impl Box4 {
    const EMPTY: Self = Self {
        min: Vec4::INFINITY,
        max: Vec4::NEG_INFINITY,
    };

    #[inline(always)]
    fn union(&self, other: &Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// Half the surface.
    #[inline(always)]
    fn half_area(&self) -> f32 {
        let size = self.max - self.min;
        size.x * (size.y + size.z) + size.y * size.z
    }

    fn member(&self, child: Child) -> Member {
        Member {
            min: self.min.truncate(),
            max: self.max.truncate(),
            child,
        }
    }
}

mod grid;
#[cfg(test)]
mod tests;
