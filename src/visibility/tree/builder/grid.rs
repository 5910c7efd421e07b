//! The upper part of a tree over many shapes, by way of a grid.
//!
//! To part a set is to read all of it a few times, and many shapes do not fit in a processor's caches. So they
//! are put into the cells of a grid first, and it is the cells that are parted, each with the box around its
//! cell and the number of its shapes. Below [`SET`] shapes a set is parted shape by shape. Only then are there items, of one
//! set at a time for each thread: until then a shape is its number, four bytes.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use glam::Vec3;
use rayon::prelude::*;

use super::{BINS, BY_SURFACE, Item, Top, bounds_of, centers_of, part_at_bins};
use crate::math::all_three;

/// From so many shapes on there is a grid.
pub(super) const LEAST: usize = 1 << 16;

/// Sets of up to so many shapes stay in a cache of their own.
const SET: usize = 1 << 14;

/// Shapes for each cell, if they filled the grid; where they are a surface, far more.
const SHAPES_PER_CELL: usize = 32;

const MOST_CELLS: usize = 1 << 18;

/// Cells along an axis.
const MOST_ALONG: f32 = 1024.0;

/// The shapes are counted in so many runs, whatever the number of threads: a cell has them in their order.
const RUNS: usize = 16;

/// What is in no cell.
const NOWHERE: u32 = u32::MAX;

/// The cells of a box.
#[derive(Clone, Copy, Debug)]
struct Grid {
    /// The least corner, doubled as centers are.
    origin: Vec3,
    /// Cells per length.
    density: Vec3,
    size: [u32; 3],
}

/// Shapes in the order of cells.
struct Cells {
    /// The numbers of all shapes, cell by cell.
    order: Vec<u32>,
    /// The cells that have any.
    occupied: Vec<Cell>,
}

/// A cell that has shapes.
#[derive(Clone, Debug)]
struct Cell {
    /// Where it is in the grid.
    place: u32,
    /// Its shapes in the order of all.
    shapes: Range<u32>,
}

/// What parts cells.
struct Parting<'c, F> {
    cells: &'c Cells,
    item: &'c F,
    leaf_size: usize,
}

/// The tree over `count` shapes but the `listed` ones, whose boxes are in `bounds`; and their order.
pub(super) fn build(
    count: u32,
    listed: &[u32],
    bounds: [Vec3; 2],
    item: &(impl Fn(u32) -> Item + Sync),
    leaf_size: usize,
) -> (Top, Vec<u32>) {
    let grid = Grid::new(bounds, count as usize);
    let cells = Cells::new(count, listed, &grid, item);
    let occupied = cells.occupied.iter().zip(0..);
    let mut items: Vec<Item> = occupied
        .map(|(cell, number)| {
            let [min, max] = grid.bounds(cell.place);
            Item::new(min, max, number)
        })
        .collect();
    let mut order = vec![0; cells.order.len()];
    let parting = Parting {
        cells: &cells,
        item,
        leaf_size,
    };
    let top = parting.top(&mut items, &mut order, 0, 0);
    (top, order)
}

impl Grid {
    /// Of cubes over a box.
    fn new([min, max]: [Vec3; 2], count: usize) -> Self {
        /// Below this, cells per length would not be finite.
        const SMALLEST: f32 = 1e-30;
        let most = (count / SHAPES_PER_CELL).clamp(1, MOST_CELLS) as f32;
        let extent = (max - min) * 2.0;
        let largest = extent.max_element();
        let mut along = MOST_ALONG;
        let mut size = [1; 3];
        while largest > SMALLEST && along >= 1.0 {
            let cells = (extent * (along / largest)).ceil().max(Vec3::ONE);
            if cells.element_product() <= most {
                size = all_three(cells.to_array(), |cells| cells as u32);
                break;
            }
            along *= 0.95;
        }
        let along = if largest > SMALLEST {
            along / largest
        } else {
            0.0
        };
        Self {
            origin: min * 2.0,
            density: Vec3::splat(along),
            size,
        }
    }

    fn len(&self) -> usize {
        self.size.iter().map(|&cells| cells as usize).product()
    }

    #[inline]
    fn cell(&self, item: &Item) -> u32 {
        let place = (item.center().truncate() - self.origin) * self.density;
        let [x, y, z] = place.to_array();
        let [wide, high, deep] = self.size;
        // The conversion ends at 0.
        let [x, y, z] = [
            (x as u32).min(wide - 1),
            (y as u32).min(high - 1),
            (z as u32).min(deep - 1),
        ];
        x + wide * (y + high * z)
    }

    /// The box of a cell, in cells.
    fn bounds(&self, place: u32) -> [Vec3; 2] {
        let [wide, high, _] = self.size;
        let [x, y, z] = [place % wide, place / wide % high, place / wide / high];
        let min = Vec3::new(x as f32, y as f32, z as f32);
        [min, min + Vec3::ONE]
    }
}

impl Cells {
    fn new(count: u32, listed: &[u32], grid: &Grid, item: &(impl Fn(u32) -> Item + Sync)) -> Self {
        let numbers = (0..count).into_par_iter();
        let mut places: Vec<u32> = numbers.map(|number| grid.cell(&item(number))).collect();
        for &number in listed {
            places[number as usize] = NOWHERE;
        }
        let run = places.len().div_ceil(RUNS);
        let runs = places.par_chunks(run);
        // How many shapes of each run are in each cell, and then where its next one goes.
        let mut next = vec![0; grid.len() * RUNS];
        let counted = runs.clone().zip(next.par_chunks_mut(grid.len()));
        counted.for_each(|(run, counts)| {
            for &place in run.iter().filter(|&&place| place != NOWHERE) {
                counts[place as usize] += 1;
            }
        });
        let mut occupied = Vec::new();
        let mut end = 0;
        for place in 0..grid.len() {
            let start = end;
            for next in next.iter_mut().skip(place).step_by(grid.len()) {
                let count = std::mem::replace(next, end);
                end += count;
            }
            if end > start {
                occupied.push(Cell {
                    place: place as u32,
                    shapes: start..end,
                });
            }
        }
        let order = (0..end).into_par_iter().map(|_| AtomicU32::new(0));
        let order: Vec<AtomicU32> = order.collect();
        let runs = runs.zip(next.par_chunks_mut(grid.len())).enumerate();
        runs.for_each(|(number, (places, next))| {
            for (shape, &place) in (number * run..).zip(places) {
                if place != NOWHERE {
                    let next = &mut next[place as usize];
                    // Each place is written once; others wait until all are.
                    order[*next as usize].store(shape as u32, Relaxed);
                    *next += 1;
                }
            }
        });
        Self {
            order: order.into_iter().map(AtomicU32::into_inner).collect(),
            occupied,
        }
    }

    /// The shapes of the cell that an item stands for.
    fn shapes(&self, item: &Item) -> &[u32] {
        let Range { start, end } = self.occupied[item.index() as usize].shapes;
        &self.order[start as usize..end as usize]
    }
}

impl<F: Fn(u32) -> Item + Sync> Parting<'_, F> {
    /// A tree over the shapes of cells, of which `first` come before in the order of all; `order` is theirs.
    fn top(&self, cells: &mut [Item], order: &mut [u32], first: usize, depth: u32) -> Top {
        if order.len() <= SET || cells.len() == 1 || depth >= BY_SURFACE {
            return self.set(cells, order, first, depth);
        }
        let weight = |cell: &Item| self.cells.shapes(cell).len() as u32;
        let centers = centers_of(cells);
        let Some((count, ..)) = part_at_bins::<BINS>(cells, &centers, depth, weight) else {
            return self.set(cells, order, first, depth);
        };
        let (cells_below, cells_above) = cells.split_at_mut(count);
        let shapes = cells_below.iter().map(|cell| weight(cell) as usize).sum();
        let (order_below, order_above) = order.split_at_mut(shapes);
        let (below, above) = rayon::join(
            || self.top(cells_below, order_below, first, depth + 1),
            || self.top(cells_above, order_above, first + shapes, depth + 1),
        );
        Top::Parted {
            bounds: below.bounds().union(above.bounds()),
            parts: Box::new([below, above]),
        }
    }

    /// The same, parted shape by shape.
    fn set(&self, cells: &[Item], order: &mut [u32], first: usize, depth: u32) -> Top {
        let mut items = Vec::with_capacity(order.len());
        for cell in cells {
            let shapes = self.cells.shapes(cell);
            if shapes.len() > SET {
                items.par_extend(shapes.par_iter().map(|&number| (self.item)(number)));
            } else {
                items.extend(shapes.iter().map(|&number| (self.item)(number)));
            }
        }
        let bounds = bounds_of(&items);
        let top = Top::new(&mut items, first, bounds, depth, self.leaf_size);
        for (place, item) in order.iter_mut().zip(&items) {
            *place = item.index();
        }
        top
    }
}
