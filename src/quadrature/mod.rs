//! L over whole pixels, with proven bounds: where the rays through a square of the image meet one shape, which each
//! light reaches all of or none of, L is a smooth function of the place; where one edge passes through, it is one
//! smooth function on each side of it.
//!
//! Squares are told apart by shafts (`visibility/shaft.rs`): what may be met in a square, and what may stand
//! between there and a light. What is not told of a square is asked of its quarters, among the shapes that were
//! left, from 16 × 16 pixels down to one. So nothing is missed, however small, and what is told of a pixel depends on
//! its place in the image alone.
//!
//! What is known of smooth functions are models (`model`): their values and how much they bend.

mod area;
mod border;
mod clip;
mod division;
mod edge;
mod light;
mod model;
mod patch;
mod radiance;
mod shafts;
mod surface;
#[cfg(test)]
mod tests;
mod view;

use std::cell::RefCell;

use crate::camera::Camera;
use crate::emitter::{Occluder, ShadowSpace};
use crate::image::Window;
use crate::math::DVec3;
use crate::simd::SimdLevel;
use crate::visibility::{ShaftSpace, Visibility, object_and_triangle};
use crate::world::panes::PanesBefore;
use crate::world::{Light, World};
use patch::{Fit, Patch};
use radiance::{Content, Radiance, WIDE_BORDER};
use shafts::{Known, Region};
use surface::Surface;
use view::{Square, View};

/// Pixels along the side of the largest squares of which anything is told; they begin at multiples of it.
const BLOCK: u32 = 16;

/// Pixels along the side of the squares whose shapes are listed for the blocks in them.
const REGION: u32 = 64;

/// So many shapes in a square are told one by one; more are asked of its quarters.
const MOST_SHAPES: usize = 16;

/// Where there are more shapes than [`MOST_SHAPES`] in squares of so many pixels along their side, their pixels
/// are left open: to tell a dense mesh apart would take longer than to sample it. In a region with more than are listed
/// of it, so are all squares with more than that, and all of this size that are not told.
const LEAST_CROWDED: f64 = 4.0;

/// How exact a pixel is to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Target {
    /// E
    pub(crate) relative: f64,
    /// In cd/m²: errors of what is darker are relative to this.
    pub(crate) floor: f64,
    /// The most samples along the side of a smooth pixel.
    pub(crate) most_side: u32,
}

impl Target {
    /// Whether R, G, B and A are as exact as they are to be, as dark as their errors let them be.
    pub(crate) fn is_met(&self, mean: [f64; 4], error: [f64; 4]) -> bool {
        let near = |channel: usize| {
            let least = mean[channel] - error[channel];
            error[channel] <= self.relative * least.max(self.floor)
        };
        (0..3).all(near) && error[3] <= self.relative
    }

    /// The largest error of R, G and B over the larger of radiance and floor.
    pub(crate) fn largest(&self, radiance: &[f64], error: &[f64]) -> f64 {
        let channels = radiance.iter().zip(error).take(3);
        channels.fold(0.0, |largest, (radiance, &error)| {
            if error > 0.0 {
                f64::max(largest, error / radiance.max(self.floor))
            } else {
                largest
            }
        })
    }
}

/// What is known of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Verdict {
    /// The mean of `side` × `side` samples in the middles of as many equal parts is at most `error` off, in cd/m²
    /// per primary, and all samples hit something, or none.
    Smooth {
        side: u32,
        error: [f64; 3],
        /// Whether that is proven; else it is estimated from some points.
        is_bound: bool,
        /// The largest error over the larger of radiance and floor.
        relative: f64,
    },
    /// It is R, G, B, A, each at most `error` off, as a square around it says that is smooth or all in penumbrae.
    Interpolated {
        mean: [f64; 4],
        error: [f64; 4],
        /// Whether that is proven; else it is estimated from some points.
        is_bound: bool,
    },
    /// The same as its own edge says, or its own penumbra.
    Integrated {
        mean: [f64; 4],
        error: [f64; 4],
        /// Whether that is proven; else it is estimated from some points.
        is_bound: bool,
    },
    /// Too little; but the radiance and the alpha of everything in it are within these, where that is known.
    Open {
        range: Option<Range>,
        /// Whether there is certainly no edge in it.
        is_smooth: bool,
    },
}

impl Verdict {
    /// Nothing is known.
    const OPEN: Self = Self::Open {
        range: None,
        is_smooth: false,
    };
}

/// What is known of the pixels of a square.
enum Answer {
    /// The same of all.
    All(Verdict),
    Each(Patch),
}

/// The least and the largest R, G, B, A anywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Range {
    pub(crate) least: [f64; 4],
    pub(crate) most: [f64; 4],
}

impl Range {
    fn new([r, g, b]: [f64; 3], alpha: f64) -> Self {
        let value = [r, g, b, alpha];
        Self {
            least: value,
            most: value,
        }
    }

    fn add(&mut self, channel: usize, [least, most]: [f64; 2]) {
        self.least[channel] += least;
        self.most[channel] += most;
    }

    fn union(mut self, other: &Self) -> Self {
        for channel in 0..4 {
            self.least[channel] = self.least[channel].min(other.least[channel]);
            self.most[channel] = self.most[channel].max(other.most[channel]);
        }
        self
    }
}

/// What rays through a square meet first.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Primary {
    Unasked,
    /// Nothing.
    Background,
    One(u64),
    /// Some of a list, or nothing.
    Several(List),
    /// Of more than are told one by one.
    Many,
}

/// Whether light reaches what is met.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Reach {
    Unasked,
    /// All of it.
    Lit,
    /// None of it.
    Dark,
    /// It is above a part of the surface.
    Terminator,
    /// Some of a list may be in the way of a light that is a point, or infinitely far away.
    Several(List),
    /// Some of a list may hide a part of a light with an area, or the horizon does.
    Partial {
        list: List,
        /// No border of a shadow moves across more than this part of the light from one end of the surface to the
        /// other.
        border: f64,
    },
    /// Through thin panes, past anything else.
    Dimmed,
    /// Of more than are told one by one.
    Many,
}

/// A part of the lists of a thread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct List {
    start: usize,
    end: usize,
    /// Whether it is of the region.
    of_region: bool,
}

impl List {
    fn of<'l>(self, lists: &'l [u64], of_region: &'l [u64]) -> &'l [u64] {
        let all = if self.of_region { of_region } else { lists };
        &all[self.start..self.end]
    }
}

/// What is known of a square.
#[derive(Clone, Copy, Debug)]
struct Told {
    primary: Primary,
    /// Where the reaches of its lights start.
    reaches: usize,
    /// Whether they are asked.
    is_asked: bool,
}

/// The mean over a square.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mean {
    /// R, G, B, A, and how far each is off at most.
    pub(crate) value: [f64; 4],
    pub(crate) error: [f64; 4],
    /// Whether that is proven; else it is estimated from some points.
    pub(crate) is_bound: bool,
}

impl Mean {
    /// Over a square that is smooth.
    fn of(radiance: &Radiance, told: &Told) -> Self {
        let [r, g, b] = &radiance.models;
        let alpha = f64::from(u8::from(told.primary != Primary::Background));
        Self {
            value: [r.center, g.center, b.center, alpha],
            error: [r.mean_error(), g.mean_error(), b.mean_error(), 0.0],
            is_bound: radiance.is_bound,
        }
    }
}

/// What is seen past shapes is computed in these.
#[derive(Debug, Default)]
struct Shadow {
    shadow: ShadowSpace,
    occluders: Vec<Occluder>,
    /// Of these, those that one point asks for.
    kept: Vec<Occluder>,
    panes: PanesBefore,
}

/// Tells what is known of pixels; what a thread needs for that, to be used again and again.
pub(crate) struct Quadrature<'w> {
    world: &'w World,
    camera: &'w Camera,
    visibility: &'w Visibility<'w>,
    simd: SimdLevel,
    target: Target,
    /// Whether pixels with edges are integrated.
    integrates: bool,
    /// Whether squares are interpolated. One sample takes less time than what is told of a square under points of light.
    interpolates: bool,
    /// The largest coordinate of spheres and triangles, if there is a sun.
    reach: f64,
    space: ShaftSpace,
    shadow: RefCell<Shadow>,
    /// Shapes, list after list, and what is known of lights, square after square.
    lists: Vec<u64>,
    reaches: Vec<Reach>,
    region: Region,
}

impl<'w> Quadrature<'w> {
    pub(crate) fn new(
        world: &'w World,
        camera: &'w Camera,
        visibility: &'w Visibility<'w>,
        simd: SimdLevel,
        target: Target,
        integrates: bool,
    ) -> Self {
        Self {
            world,
            camera,
            visibility,
            simd,
            target,
            integrates,
            interpolates: integrates
                && world
                    .lights()
                    .iter()
                    .any(|light| light.value.area().is_some()),
            reach: if world.lights().iter().any(|light| light.value.is_sun()) {
                visibility.reach()
            } else {
                0.0
            },
            space: ShaftSpace::default(),
            shadow: RefCell::default(),
            lists: Vec::new(),
            reaches: Vec::new(),
            region: Region::NONE,
        }
    }

    /// Where a light is, as seen from points in a box. A sun is at a point so far away that its rays are parallel there
    /// to 2⁻³⁰, which is nothing beside the errors that can be asked for, and near enough for the digits of f64.
    fn origin(&self, light: usize, bounds: Option<[DVec3; 2]>) -> DVec3 {
        const PARALLEL: f64 = (1 << 30) as f64;
        match (&self.world.lights()[light].value, bounds) {
            (Light::Sun(sun), Some([least, most])) => {
                let reach = least.abs().max(most.abs()).max_element().max(self.reach);
                sun.to_light.get() * (reach * PARALLEL)
            }
            (light, _) => light.position().0,
        }
    }

    /// Tells what is known of the pixels of a window, row by row.
    pub(crate) fn tell(&mut self, window: Window, verdicts: &mut Vec<Verdict>) {
        verdicts.clear();
        verdicts.resize(window.count() as usize, Verdict::OPEN);
        let blocks = |start: u32, size: u32| start / BLOCK..=(start + size - 1) / BLOCK;
        for row in blocks(window.y, window.height) {
            for column in blocks(window.x, window.width) {
                self.lists.clear();
                self.reaches.clear();
                self.enter([column, row].map(|number| number * BLOCK / REGION));
                let known = Told {
                    primary: self.region.primary,
                    reaches: 0,
                    is_asked: false,
                };
                self.descend(aligned([column, row], BLOCK), known, window, verdicts);
            }
        }
    }

    /// Tells what is known of a square of pixels, of which more is known.
    fn descend(&mut self, square: Square, known: Told, window: Window, verdicts: &mut [Verdict]) {
        let Some(pixels) = inside(square, window) else {
            return;
        };
        let (lists, reaches) = (self.lists.len(), self.reaches.len());
        let view = View::new(self.camera, square);
        let (told, surface) = self.refine(square, &view, known);
        let answer = if self.shows_delta(told.primary) {
            // Of what is seen in mirrors and glass nothing is told.
            let is_told = square.half <= 0.5 || matches!(told.primary, Primary::One(_));
            is_told.then_some(Answer::All(Verdict::OPEN))
        } else if square.half > 0.5 {
            self.smooth(square, &told, surface.as_ref())
        } else {
            Some(Answer::All(self.pixel(
                square,
                &view,
                &told,
                surface.as_ref(),
            )))
        };
        let is_many = told.primary == Primary::Many;
        let is_small = 2.0 * square.half <= LEAST_CROWDED;
        let is_crowded = if self.region.is_crowded() {
            is_many || is_small
        } else {
            is_small && (is_many || self.is_shadow_crowded(&told))
        };
        let answer = answer.or(is_crowded.then_some(Answer::All(Verdict::OPEN)));
        match answer {
            Some(Answer::All(verdict)) => {
                for [x, y] in pixels.pixels() {
                    let place = (y - window.y) * window.width + (x - window.x);
                    verdicts[place as usize] = verdict;
                }
            }
            Some(Answer::Each(patch)) => patch.tell(pixels, window, verdicts),
            None => {
                for quarter in square.quarters() {
                    self.descend(quarter, told, window, verdicts);
                }
            }
        }
        self.lists.truncate(lists);
        self.reaches.truncate(reaches);
    }

    /// Whether any of what is met is perfectly smooth.
    fn shows_delta(&self, primary: Primary) -> bool {
        if !self.world.has_deltas() {
            return false;
        }
        let is_smooth = |shape: u64| {
            let (object, _) = object_and_triangle(shape);
            let material = self.world.objects()[object as usize].material;
            self.world.delta(material).is_some()
        };
        match primary {
            Primary::One(shape) => is_smooth(shape),
            Primary::Several(list) => {
                let shapes = self.list(list);
                shapes.iter().any(|&shape| is_smooth(shape))
            }
            Primary::Unasked | Primary::Background | Primary::Many => false,
        }
    }

    /// Whether there are more shapes between a square and a light than are told one by one.
    fn is_shadow_crowded(&self, told: &Told) -> bool {
        told.is_asked && {
            let reaches = &self.reaches[told.reaches..][..self.world.lights().len()];
            reaches.contains(&Reach::Many)
        }
    }

    /// Asks what is not known yet of a part of a square.
    fn refine(&mut self, square: Square, view: &View, known: Told) -> (Told, Option<Surface>) {
        let primary = self.primary(square, view, known.primary);
        let Primary::One(shape) = primary else {
            let told = Told {
                primary,
                reaches: self.reaches.len(),
                is_asked: false,
            };
            return (told, None);
        };
        let solid = self.solid(shape);
        let Some(surface) = Surface::new(view, &solid) else {
            let told = Told {
                primary,
                reaches: self.reaches.len(),
                is_asked: false,
            };
            return (told, None);
        };
        let before = if known.is_asked {
            Known::PartOf(known.reaches)
        } else {
            Known::Nothing
        };
        let reaches = self.reach_all(shape, &surface, before);
        let told = Told {
            primary,
            reaches,
            is_asked: true,
        };
        (told, Some(surface))
    }

    /// Of smooth radiance over a square, how far the mean over a part of it, half of whose side is `part` of the
    /// square's, is from the value in the middle of the part, if that is near enough.
    fn flatness(&self, radiance: &Radiance, side: u32, part: f64) -> Option<Verdict> {
        let error = [0, 1, 2].map(|channel: usize| radiance.models[channel].bend(part));
        let least = [0, 1, 2].map(|channel: usize| radiance.models[channel].least());
        let relative = self.target.largest(&least, &error);
        (relative <= self.target.relative).then_some(Verdict::Smooth {
            side,
            error,
            is_bound: radiance.is_bound,
            relative,
        })
    }

    /// A square of whole pixels that is smooth, and bends so little that nine values will do, or one sample a pixel.
    fn smooth(&self, square: Square, told: &Told, surface: Option<&Surface>) -> Option<Answer> {
        let Some(radiance) = self.smooth_radiance(told, surface, None) else {
            let surface = surface.filter(|_| self.interpolates)?;
            return self.penumbra_patch(square, told, surface).map(Answer::Each);
        };
        if self.interpolates {
            match self.smooth_patch(square, told, &radiance) {
                Fit::Told(patch) => return Some(Answer::Each(patch)),
                Fit::OfQuarters => return None,
                Fit::TooCoarse => {}
            }
        }
        let verdict = self.flatness(&radiance, 1, 0.5 / square.half);
        verdict.map(Answer::All)
    }

    /// What is known of one pixel.
    fn pixel(
        &mut self,
        square: Square,
        view: &View,
        told: &Told,
        surface: Option<&Surface>,
    ) -> Verdict {
        let smooth = self.smooth_radiance(told, surface, Some(WIDE_BORDER));
        let integrated = |quadrature: &Self, mean: Mean| {
            let is_met = quadrature.target.is_met(mean.value, mean.error);
            (quadrature.integrates && is_met).then_some(Verdict::Integrated {
                mean: mean.value,
                error: mean.error,
                is_bound: mean.is_bound,
            })
        };
        if let Some(smooth) = &smooth {
            // What is estimated has been computed in the middle already.
            if !smooth.is_bound
                && let Some(verdict) = integrated(self, Mean::of(smooth, told))
            {
                return verdict;
            }
            let mut side = 1;
            while side <= self.target.most_side {
                let verdict = self.flatness(smooth, side, 1.0 / f64::from(side));
                if let Some(verdict) = verdict {
                    return verdict;
                }
                side *= 2;
            }
        }
        let mean = match &smooth {
            Some(smooth) => Some(Mean::of(smooth, told)),
            None if self.integrates => self.across_edge(square, view, told, surface),
            None => None,
        };
        if let Some(verdict) = mean.and_then(|mean| integrated(self, mean)) {
            return verdict;
        }
        // Borders of shadows as wide as the pixel are no edges.
        let is_smooth = smooth.is_some()
            || match (told.primary, surface) {
                (Primary::One(shape), Some(surface)) => self.has_no_edge(shape, told, surface),
                _ => false,
            };
        Verdict::Open {
            range: self.range(square, view, told, surface, Content::Unsampled),
            is_smooth,
        }
    }
}

/// The square at a place among those of so many pixels.
fn aligned(place: [u32; 2], side: u32) -> Square {
    let half = f64::from(side) * 0.5;
    Square {
        middle: place.map(|number| f64::from(number) * f64::from(side) + half),
        half,
    }
}

/// The pixels of a square that are in a window, unless there are none.
fn inside(square: Square, window: Window) -> Option<Window> {
    let [left, top] = square.middle.map(|middle| (middle - square.half) as u32);
    let side = (2.0 * square.half) as u32;
    let x = left.max(window.x);
    let y = top.max(window.y);
    let right = (left + side).min(window.x + window.width);
    let bottom = (top + side).min(window.y + window.height);
    (x < right && y < bottom).then(|| Window {
        x,
        y,
        width: right - x,
        height: bottom - y,
    })
}
