//! What may be met in a square, and what may stand between there and the lights, asked by shafts.

use fearless_simd::Simd;

use super::border::{border, is_hidden, nearest};
use super::surface::{Solid, Surface, rounding};
use super::view::{Square, View};
use super::{List, MOST_SHAPES, Primary, Quadrature, REGION, Reach, aligned};
use crate::camera::Projection;
use crate::emitter::Emitter;
use crate::math::DVec3;
use crate::simd::Kernel;
use crate::visibility::{
    Shaft, ShaftAnswer, ShaftQuestion, ShaftSpace, Visibility, object_and_triangle,
};
use crate::world::Light;
use crate::world::light::AreaLight;

/// So many shapes are listed of a region; where there are more, each block asks all.
const MOST_LISTED: usize = 64;

/// What is known of shapes in a region, for all of its blocks.
#[derive(Debug)]
pub(super) struct Region {
    /// Its column and row among the regions.
    pub(super) place: Option<[u32; 2]>,
    pub(super) square: Square,
    pub(super) primary: Primary,
    /// Shapes that are met in it, and where what may be between these and the lights starts.
    pub(super) shapes: Vec<(u64, usize)>,
    pub(super) reaches: Vec<Reach>,
    pub(super) lists: Vec<u64>,
}

impl Region {
    /// Whether it has more shapes than are listed.
    pub(super) fn is_crowded(&self) -> bool {
        self.primary == Primary::Unasked
    }

    pub(super) const NONE: Self = Self {
        place: None,
        square: Square {
            middle: [0.0; 2],
            half: 0.0,
        },
        primary: Primary::Unasked,
        shapes: Vec::new(),
        reaches: Vec::new(),
        lists: Vec::new(),
    };
}

/// A flat shape that is seen beside another: all that is seen of the other in a square is on one side of its plane, so
/// that it hides nothing of it from lights on that side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beside {
    pub(super) shape: u64,
    pub(super) point: DVec3,
    /// To that side.
    pub(super) normal: DVec3,
}

impl Beside {
    /// On the side of a shape that rays come from.
    pub(super) fn new(view: &View, shape: u64, solid: &Solid) -> Option<Self> {
        let (approach, [point, _]) = solid.approach(view).zip(solid.plane())?;
        Some(Self {
            shape,
            point,
            normal: approach.normal,
        })
    }

    /// Whether a point is on that side, by more than rounding.
    fn is_before(&self, place: DVec3) -> bool {
        self.normal.dot(place - self.point) > rounding(place, self.point)
    }
}

/// What is known of a surface before its lights are asked.
#[derive(Clone, Copy, Debug)]
pub(super) enum Known {
    Nothing,
    /// It is a part of another one, of which the reaches start there.
    PartOf(usize),
    Beside(Beside),
}

/// The same of one light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Before {
    reach: Reach,
    beside: Option<Beside>,
}

/// A shaft through all shapes, on whatever instructions.
struct Ask<'a, 'w> {
    visibility: &'a Visibility<'w>,
    shaft: &'a Shaft,
    question: ShaftQuestion,
    except: u64,
    most: usize,
    space: &'a mut ShaftSpace,
}

impl Kernel for Ask<'_, '_> {
    type Output = ShaftAnswer;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> ShaftAnswer {
        let Self {
            visibility,
            shaft,
            question,
            except,
            most,
            space,
        } = self;
        visibility.shaft(simd, shaft, question, except, most, space)
    }
}

impl Quadrature<'_> {
    /// Lists the shapes in a region, if it is another one than before.
    pub(super) fn enter(&mut self, place: [u32; 2]) {
        let region = &mut self.region;
        if region.place == Some(place) {
            return;
        }
        region.place = Some(place);
        region.square = aligned(place, REGION);
        region.shapes.clear();
        region.reaches.clear();
        region.lists.clear();
        let shaft = self.window(self.region.square);
        let answer = self.ask(&shaft, ShaftQuestion::FirstHit, u64::MAX, MOST_LISTED);
        self.region.primary = match answer {
            ShaftAnswer::Nothing => Primary::Background,
            ShaftAnswer::All(shape) => Primary::One(shape),
            ShaftAnswer::These => Primary::Several(self.keep_for_region()),
            ShaftAnswer::TooMany => Primary::Unasked,
        };
        if self.region.is_crowded() {
            // Of no shape is anything listed.
            let lights = self.world.lights().len();
            self.region.reaches.resize(lights, Reach::Unasked);
        }
    }

    /// Keeps the list of the last answer for all blocks of the region.
    pub(super) fn keep_for_region(&mut self) -> List {
        let lists = &mut self.region.lists;
        let start = lists.len();
        lists.extend_from_slice(&self.space.list);
        List {
            start,
            end: lists.len(),
            of_region: true,
        }
    }

    pub(super) fn primary(&mut self, square: Square, view: &View, known: Primary) -> Primary {
        let shaft = match known {
            Primary::Background | Primary::One(_) => return known,
            Primary::Unasked | Primary::Several(_) | Primary::Many => self.window(square),
        };
        let answer = match known {
            Primary::Several(list) => self.visibility.shaft_among(
                &shaft,
                ShaftQuestion::FirstHit,
                u64::MAX,
                list.of(&self.lists, &self.region.lists),
                &mut self.space,
            ),
            _ => self.ask(&shaft, ShaftQuestion::FirstHit, u64::MAX, MOST_SHAPES),
        };
        match answer {
            ShaftAnswer::Nothing => Primary::Background,
            ShaftAnswer::All(shape) => Primary::One(shape),
            ShaftAnswer::These => {
                self.drop_from_list(|quadrature, shape| quadrature.solid(shape).is_missed(view));
                self.drop_hidden(view);
                match self.space.list[..] {
                    [] => Primary::Background,
                    [shape] if self.solid(shape).is_all_over(view) => Primary::One(shape),
                    _ => Primary::Several(self.keep()),
                }
            }
            ShaftAnswer::TooMany => Primary::Many,
        }
    }

    /// Drops, of the list of the last answer, what is behind a shape that all rays meet: shafts tell that of boxes
    /// around shapes, this of planes too, which all go on to where others end.
    fn drop_hidden(&mut self, view: &View) {
        let shapes = self.space.list.clone();
        for &front in &shapes {
            let solid = self.solid(front);
            if self.space.list.contains(&front) && solid.is_all_over(view) {
                self.drop_from_list(|quadrature, other| {
                    other != front && quadrature.solid(other).is_behind(&solid, view)
                });
            }
        }
    }

    /// The rays through a square.
    pub(super) fn window(&self, square: Square) -> Shaft {
        let Square {
            middle: [x, y],
            half,
        } = square;
        let rays = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[u, v]| self.camera.ray(x + u * half, y + v * half));
        let forward = self.camera.forward().get();
        let depths = [0.0, f64::INFINITY];
        match self.camera.projection() {
            Projection::Perspective { .. } => Shaft::Perspective {
                eye: self.camera.eye().0,
                directions: rays.map(|ray| ray.direction),
                forward,
                depths,
            },
            Projection::Orthographic { .. } => Shaft::Orthographic {
                starts: rays.map(|ray| ray.origin.0),
                forward,
                depths,
            },
        }
    }

    /// Asks all shapes; the list is in `space`.
    pub(super) fn ask(
        &mut self,
        shaft: &Shaft,
        question: ShaftQuestion,
        except: u64,
        most: usize,
    ) -> ShaftAnswer {
        self.simd.run(Ask {
            most,
            visibility: self.visibility,
            shaft,
            question,
            except,
            space: &mut self.space,
        })
    }

    /// Keeps the list of the last answer.
    pub(super) fn keep(&mut self) -> List {
        let start = self.lists.len();
        self.lists.extend_from_slice(&self.space.list);
        List {
            start,
            end: self.lists.len(),
            of_region: false,
        }
    }

    pub(super) fn list(&self, list: List) -> &[u64] {
        list.of(&self.lists, &self.region.lists)
    }

    /// What may be between a shape and the lights anywhere in the region; where the answers start among those of
    /// the region.
    pub(super) fn between(&mut self, shape: u64) -> usize {
        if self.region.is_crowded() {
            return 0;
        }
        let known = self.region.shapes.iter().find(|(known, _)| *known == shape);
        if let Some((_, start)) = known {
            return *start;
        }
        let start = self.region.reaches.len();
        let solid = self.solid(shape);
        let bounds = match solid {
            Solid::Sphere { center, radius } | Solid::Disk { center, radius, .. } => {
                Some([center - DVec3::splat(radius), center + DVec3::splat(radius)])
            }
            Solid::Plane { .. } | Solid::Triangle { .. } => {
                let view = View::new(self.camera, self.region.square);
                let surface = Surface::new(&view, &solid).filter(|surface| !surface.is_lifted);
                surface.and_then(|surface| surface.position.bounds())
            }
        };
        for light in 0..self.world.lights().len() {
            let reach = match bounds {
                None => Reach::Unasked,
                Some(bounds) => self.all_between(bounds, shape, light),
            };
            self.region.reaches.push(reach);
        }
        self.region.shapes.push((shape, start));
        start
    }

    pub(super) fn all_between(&mut self, from: [DVec3; 2], shape: u64, light: usize) -> Reach {
        let question = ShaftQuestion::Contents;
        if let Some(area) = self.world.lights()[light].value.area() {
            let to = area.emitter.bounds();
            let answer = self.ask(&Shaft::ToBox { from, to }, question, shape, MOST_LISTED);
            if answer == ShaftAnswer::TooMany {
                return Reach::Unasked;
            }
            self.drop_from_list(|quadrature, other| quadrature.is_of(light, other));
            return Reach::Partial {
                list: self.keep_for_region(),
                border: f64::INFINITY,
            };
        }
        let to = self.origin(light, Some(from));
        match self.ask(&Shaft::ToPoint { from, to }, question, shape, MOST_LISTED) {
            ShaftAnswer::TooMany => Reach::Unasked,
            ShaftAnswer::Nothing | ShaftAnswer::All(_) | ShaftAnswer::These => {
                Reach::Several(self.keep_for_region())
            }
        }
    }

    pub(super) fn solid(&self, shape: u64) -> Solid {
        let (object, triangle) = object_and_triangle(shape);
        Solid::of(self.world, object, triangle)
    }

    /// Asks of all lights whether they reach a surface, where that is not known; where the answers start.
    pub(super) fn reach_all(&mut self, shape: u64, surface: &Surface, known: Known) -> usize {
        let start = self.reaches.len();
        let (object, _) = object_and_triangle(shape);
        if self.world.objects()[object as usize].emits.is_some() {
            // A light reflects nothing.
            let lights = self.world.lights().len();
            self.reaches.resize(start + lights, Reach::Dark);
            return start;
        }
        let beside = match known {
            Known::Beside(beside) => Some(beside),
            Known::Nothing | Known::PartOf(_) => None,
        };
        let bounds = surface.position.bounds();
        let of_region = self.between(shape);
        for light in 0..self.world.lights().len() {
            let reach = match known {
                Known::PartOf(whole) => self.reaches[whole + light],
                Known::Nothing | Known::Beside(_) => Reach::Unasked,
            };
            let reach = match reach {
                Reach::Unasked | Reach::Terminator | Reach::Dimmed | Reach::Many => {
                    self.region.reaches[of_region + light]
                }
                Reach::Lit | Reach::Dark | Reach::Several(_) | Reach::Partial { .. } => reach,
            };
            let reach = match reach {
                Reach::Lit | Reach::Dark => reach,
                _ => self.reach(shape, surface, bounds, light, Before { reach, beside }),
            };
            self.reaches.push(reach);
        }
        start
    }

    pub(super) fn reach(
        &mut self,
        shape: u64,
        surface: &Surface,
        bounds: Option<[DVec3; 2]>,
        light: usize,
        before: Before,
    ) -> Reach {
        let Some(bounds) = bounds.filter(|_| !surface.is_lifted) else {
            return Reach::Many;
        };
        if self.world.lights()[light].value.area().is_some() {
            return self.reach_of_area(shape, surface, bounds, light, before);
        }
        let origin = self.origin(light, Some(bounds));
        if self.world.lights()[light].value.misses(bounds) {
            return Reach::Dark;
        }
        let height = surface.height(origin);
        let room = rounding(origin, bounds[0].abs().max(bounds[1].abs()));
        if height.most() < -room {
            return Reach::Dark;
        }
        // From inside of a sphere no light outside of it is seen.
        if let Some(beyond) = surface.beyond(origin)
            && beyond > -room
        {
            return if beyond > room {
                Reach::Dark
            } else {
                Reach::Many
            };
        }
        let is_above = height.least() > room;
        if !is_above {
            return Reach::Terminator;
        }
        // A flat shape does not hide its own points, and a sphere none that are above of it.
        match self.between_points(bounds, origin, shape, before.reach, ShaftQuestion::Blockage) {
            ShaftAnswer::Nothing => Reach::Lit,
            ShaftAnswer::All(blocks) if self.is_pane(blocks) => Reach::Dimmed,
            ShaftAnswer::All(_) => Reach::Dark,
            ShaftAnswer::These if self.are_panes_listed() => Reach::Dimmed,
            ShaftAnswer::These => {
                let beside = before.beside.filter(|beside| beside.is_before(origin));
                self.drop_from_list(|_, other| beside.is_some_and(|beside| beside.shape == other));
                if self.space.list.is_empty() {
                    Reach::Lit
                } else {
                    Reach::Several(self.keep())
                }
            }
            ShaftAnswer::TooMany => Reach::Many,
        }
    }

    /// Whether a shape is a thin pane: it lets light pass, of which shafts do not know how much.
    pub(super) fn is_pane(&self, shape: u64) -> bool {
        let (object, _) = object_and_triangle(shape);
        self.world.is_pane(object)
    }

    /// Whether there are any in the list of the last answer.
    fn are_panes_listed(&self) -> bool {
        self.world.has_panes() && self.space.list.iter().any(|&shape| self.is_pane(shape))
    }

    /// Whether there are any that are spheres.
    fn are_round_panes_listed(&self) -> bool {
        let is_round = |shape: u64| matches!(self.solid(shape), Solid::Sphere { .. });
        let mut list = self.space.list.iter();
        self.world.has_panes() && list.any(|&shape| self.is_pane(shape) && is_round(shape))
    }

    /// Drops shapes from the list of the last answer.
    fn drop_from_list(&mut self, is_dropped: impl Fn(&Self, u64) -> bool) {
        let mut list = std::mem::take(&mut self.space.list);
        list.retain(|&shape| !is_dropped(self, shape));
        self.space.list = list;
    }

    /// Whether all of a light with an area arrives, or nothing of it, or what may hide a part.
    fn reach_of_area(
        &mut self,
        shape: u64,
        surface: &Surface,
        bounds: [DVec3; 2],
        light: usize,
        Before {
            reach: before,
            beside,
        }: Before,
    ) -> Reach {
        let Light::Area(AreaLight { emitter, .. }) = &self.world.lights()[light].value else {
            return Reach::Many;
        };
        let [least, most] = emitter.bounds();
        let room = rounding(
            least.abs().max(most.abs()),
            bounds[0].abs().max(bounds[1].abs()),
        );
        let corners = (0..8).map(|corner: u32| {
            let pick =
                |axis: u32, from: f64, to: f64| if corner >> axis & 1 == 0 { from } else { to };
            DVec3::new(
                pick(0, least.x, most.x),
                pick(1, least.y, most.y),
                pick(2, least.z, most.z),
            )
        });
        let is_below = |corner: DVec3| surface.height(corner).most() < -room;
        if corners.clone().all(is_below) || emitter.is_behind(bounds) {
            return Reach::Dark;
        }
        // From inside of a sphere no light outside of it is seen.
        let size = 0.5 * (most - least).length();
        if let Some(beyond) = surface.beyond(emitter.center().0)
            && beyond + size > -room
        {
            return if beyond - size > room {
                Reach::Dark
            } else {
                Reach::Many
            };
        }
        // The horizon of what is flat cuts the light alike everywhere.
        let plane = surface.plane();
        let is_above = |corner: DVec3| {
            (plane.is_some() || surface.height(corner).least() > room)
                && (!surface.is_smooth() || surface.shading_height(corner).least() > room)
        };
        let may_be_lit = nearest(emitter, bounds) > room && corners.clone().all(is_above);
        let shaft = Shaft::ToBox {
            from: bounds,
            to: [least, most],
        };
        let ask = |quadrature: &mut Self, question| match before {
            Reach::Partial { list, .. } => quadrature.visibility.shaft_among(
                &shaft,
                question,
                shape,
                list.of(&quadrature.lists, &quadrature.region.lists),
                &mut quadrature.space,
            ),
            _ => quadrature.ask(&shaft, question, shape, MOST_SHAPES),
        };
        let mut answer = ask(self, ShaftQuestion::Blockage);
        if let ShaftAnswer::All(blocks) = answer {
            if !self.is_of(light, blocks) && !self.is_pane(blocks) {
                return Reach::Dark;
            }
            // What is behind the light itself, or a pane, may have been left out.
            answer = ask(self, ShaftQuestion::Contents);
        }
        match answer {
            ShaftAnswer::TooMany | ShaftAnswer::All(_) => Reach::Many,
            ShaftAnswer::These if self.are_round_panes_listed() => Reach::Dimmed,
            ShaftAnswer::Nothing if may_be_lit => Reach::Lit,
            ShaftAnswer::Nothing => {
                self.space.list.clear();
                self.partial(surface, emitter)
            }
            ShaftAnswer::These => {
                let beside =
                    beside.filter(|beside| corners.clone().all(|corner| beside.is_before(corner)));
                self.drop_from_list(|quadrature, other| {
                    quadrature.is_of(light, other)
                        || beside.is_some_and(|beside| beside.shape == other)
                        // Below the horizon nothing is hidden.
                        || plane.is_some_and(|[point, normal]| {
                            quadrature.solid(other).is_above(point, -normal)
                        })
                });
                if self.space.list.is_empty() && may_be_lit {
                    Reach::Lit
                } else if nearest(emitter, bounds) > room && self.is_hidden(surface, emitter) {
                    Reach::Dark
                } else {
                    self.partial(surface, emitter)
                }
            }
        }
    }

    /// Whether the balls of the last answer's list hide all of a light.
    fn is_hidden(&self, surface: &Surface, emitter: &Emitter) -> bool {
        let balls = self.space.list.iter();
        let balls = balls.filter_map(|&shape| match self.solid(shape) {
            Solid::Sphere { center, radius } => Some((center, radius)),
            Solid::Plane { .. } | Solid::Triangle { .. } | Solid::Disk { .. } => None,
        });
        is_hidden(surface, emitter, balls, &mut self.shadow.borrow_mut())
    }

    /// The list of the last answer may hide a part of a light with an area.
    fn partial(&mut self, surface: &Surface, emitter: &Emitter) -> Reach {
        // The edge of a pane is a border, whatever opaque shape goes on from there.
        let border = [false, true].map(|are_panes| {
            let shapes = self.space.list.iter();
            let shapes = shapes.filter(|&&shape| self.is_pane(shape) == are_panes);
            border(surface, emitter, &shapes.map(|&shape| self.solid(shape)))
        });
        let border = border[0].max(border[1]);
        let list = self.keep();
        Reach::Partial { list, border }
    }

    /// Whether a shape is a light itself.
    fn is_of(&self, light: usize, shape: u64) -> bool {
        let (object, _) = object_and_triangle(shape);
        self.world.objects()[object as usize].emits == Some(light)
    }

    /// What is between a box and a point that is a light, of a list if that is known `before`; but for the shape that the box is on.
    pub(super) fn between_points(
        &mut self,
        from: [DVec3; 2],
        to: DVec3,
        shape: u64,
        before: Reach,
        question: ShaftQuestion,
    ) -> ShaftAnswer {
        let shaft = Shaft::ToPoint { from, to };
        let Reach::Several(list) = before else {
            return self.ask(&shaft, question, shape, MOST_SHAPES);
        };
        let list = list.of(&self.lists, &self.region.lists);
        if list.is_empty() {
            return ShaftAnswer::Nothing;
        }
        self.visibility
            .shaft_among(&shaft, question, shape, list, &mut self.space)
    }
}
