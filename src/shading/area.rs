//! L9 for lights with an area: L_o = L ∫ r V dω over what a point sees of them, point by point.
//!
//! What a point receives of all that it sees is a closed form; what is hidden is cut away, shape by shape. First the
//! whole batch is asked, by the shaft from the box around its points to the box around the light: where nothing may
//! be in the way, each point has the closed form, and where one shape hides all of it, nothing. What is left is asked
//! packet by packet and point by point. Where a point sees the light past very many shapes, some points of the light
//! are asked one by one, with shadow rays, as those of any other light.
//!
//! Each decision about a point is made from that point alone, so that it has the same bits beside any others.

use fearless_simd::Simd;

use super::groups::Gloss;
use super::panes::PaneSpace;
use crate::emitter::{Accuracy, Gloss as EmitterGloss, Occluder, Received, Receiver, ShadowSpace};
use crate::math::{DVec3, Direction, Normal};
use crate::simd::{LANES, ones};
use crate::visibility::{
    BATCH, Column, PACKETS, Points, Shaft, ShaftAnswer, ShaftQuestion, ShaftSpace, Start,
    Visibility, Workspace, object_and_triangle,
};
use crate::world::light::AreaLight;
use crate::world::panes::PanesBefore;
use crate::world::{Lobes, Shape, World};

/// So many shapes may be listed between a batch and a light; if there are more, each of its packets asks, and so
/// each of its points.
const MOST_LISTED: usize = 64;

/// The same for one point. It is above [`MOST_LISTED`], so that a point decides alike whatever is asked with it.
const MOST_BEFORE_POINT: usize = 96;

/// Past so many shapes a light is cut; past more, points of it are asked, if no error is asked for.
const MOST_CUT: usize = 24;

/// The same where an error is asked for.
const MOST_CUT_FOR_ERROR: usize = 4096;

/// How far what is cut may be off where no error is asked for, as a part of what arrives with nothing in the way.
/// Without round shapes before round lights it is exact.
pub(super) const ACCURACY: Accuracy = Accuracy {
    relative: 1e-5,
    most_cells: 4096,
};

/// The same where an error is asked for.
pub(super) const ACCURACY_FOR_ERROR: Accuracy = Accuracy {
    relative: 1e-6,
    most_cells: 65_536,
};

/// A part of the light that is below this is what rounding leaves of nothing.
const NOTHING: f64 = 1e-12;

/// What a light with an area does at the points of a batch.
#[derive(Clone, Debug)]
pub(super) struct AreaTerms {
    /// The cosine terms of both lobes, integrated over what each point sees of the light, per cd along its normal: in
    /// m⁻².
    pub(super) geometry: Lobes<Column>,
    /// V: how much of the illuminance with nothing in the way arrives, 0 to 1.
    pub(super) seen: Column,
}

/// What a thread needs to ask for lights with an area, to be used again and again.
#[derive(Debug, Default)]
pub(crate) struct AreaSpace {
    pub(super) shafts: ShaftSpace,
    pub(super) shadow: ShadowSpace,
    /// What may be between a batch, or a packet, and the light.
    batch_list: Vec<u64>,
    packet_list: Vec<u64>,
    pub(super) occluders: Vec<Occluder>,
    pub(super) panes_before: PanesBefore,
    /// Points that ask points of the light how much panes let pass.
    pub(super) undimmed: Vec<usize>,
    /// Of points of which points of the light are asked: with nothing in the way, and sums of weights.
    pub(super) free: Vec<(usize, Receiver, Received)>,
    pub(super) sums: Vec<[f64; 4]>,
    pub(super) panes: PaneSpace,
}

/// What stands between points and a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Between {
    Nothing,
    /// All of the light is hidden from all of them.
    All,
    /// Some of a list.
    Listed,
    Many,
}

/// What a point receives of a light past all that stands between, and V.
enum Cut {
    Seen(Received, f64),
    /// Beyond panes, of which nothing has been taken away yet.
    Undimmed(Received, f64),
    Hidden,
    /// There is too much between.
    TooMany,
}

/// What a light with an area does at a batch of points, and for each packet one bit for each point that it reaches.
pub(super) struct AreaLit {
    pub(super) terms: Box<AreaTerms>,
    pub(super) points: [u32; PACKETS],
    /// How many points are above the horizon of any point, and how many shadow rays were sent.
    pub(super) asked: u64,
}

/// A light and who asks for it.
pub(super) struct Asked<'a, 'w> {
    pub(super) world: &'a World,
    pub(super) visibility: &'a Visibility<'w>,
    pub(super) points: &'a Points,
    /// Which it is among the lights.
    pub(super) index: usize,
    pub(super) light: &'a AreaLight,
    /// Which it is among the points of all lights.
    pub(super) number: usize,
    /// Whether it is cut by up to [`MOST_CUT_FOR_ERROR`] shapes.
    pub(super) cuts_all: bool,
    pub(super) accuracy: &'static Accuracy,
    /// For each packet one bit for each point with lobes.
    pub(super) lobed: &'a [u32; PACKETS],
}

impl Asked<'_, '_> {
    /// The light's terms; `None` where it reaches no point of the batch.
    #[inline(never)]
    pub(super) fn terms<S: Simd>(
        &self,
        simd: S,
        area: &mut AreaSpace,
        space: &mut Workspace,
    ) -> Option<AreaLit> {
        let points = self.points;
        if self.light.emitter.is_behind(points.bounds_of_starts()) {
            return None;
        }
        let of_batch = self.between_all(
            simd,
            points.bounds_of_starts(),
            points
                .only_shape()
                .filter(|&shape| !self.is_curved(shape))
                .unwrap_or(u64::MAX),
            area,
        );
        if of_batch == Between::All {
            return None;
        }
        if of_batch == Between::Listed {
            area.batch_list.clone_from(&area.shafts.list);
        }
        let mut lit = AreaLit {
            terms: Box::new(AreaTerms {
                geometry: Lobes {
                    diffuse: Column::ZERO,
                    specular: Column::ZERO,
                },
                seen: Column::ZERO,
            }),
            points: [0; PACKETS],
            asked: 0,
        };
        let mut sampled = [0; PACKETS];
        area.free.clear();
        area.undimmed.clear();
        for (packet, sampled) in sampled.iter_mut().enumerate() {
            let hit = self.lobed[packet];
            if hit == 0 {
                continue;
            }
            let mut between = of_batch;
            if between == Between::Many {
                between = self.of_packet(simd, packet, area);
            }
            if between == Between::All {
                continue;
            }
            for lane in ones(hit) {
                let slot = packet * LANES + lane;
                let start = points.start(slot);
                if self.is_own(start.primitive) {
                    // It is flat or bent away from itself.
                    continue;
                }
                let receiver = self.receiver(slot, &start);
                let Some(received) = self
                    .light
                    .emitter
                    .received_by_lobes(start.position, &receiver)
                else {
                    continue;
                };
                lit.asked += 1;
                let seen = match between {
                    Between::Nothing => Some((received, 1.0)),
                    Between::All => None,
                    Between::Listed | Between::Many => {
                        let cut =
                            self.cut(simd, between, &start, &receiver, &received, area, of_batch);
                        match cut {
                            Cut::Seen(received, share) => Some((received, share)),
                            Cut::Undimmed(received, share) => {
                                area.undimmed.push(slot);
                                Some((received, share))
                            }
                            Cut::Hidden => None,
                            Cut::TooMany => {
                                *sampled |= 1 << lane;
                                area.free.push((slot, receiver, received));
                                None
                            }
                        }
                    }
                };
                if let Some((received, share)) = seen {
                    self.put(&mut lit, slot, &received, share);
                }
            }
        }
        if !area.free.is_empty() {
            self.sample(simd, &sampled, &mut lit, area, space);
            if self.world.has_panes() {
                let AreaSpace { free, undimmed, .. } = area;
                undimmed.extend(free.iter().map(|(slot, ..)| slot));
            }
        }
        if !area.undimmed.is_empty() {
            self.through_panes(simd, &mut lit, area, space);
        }
        lit.points.iter().any(|&bits| bits != 0).then_some(lit)
    }

    /// What is between the points in a box and the light; of a list, without the light itself, it is in the space.
    fn between_all<S: Simd>(
        &self,
        simd: S,
        from: [DVec3; 2],
        except: u64,
        area: &mut AreaSpace,
    ) -> Between {
        let to = self.light.emitter.bounds();
        let shaft = Shaft::ToBox { from, to };
        let question = ShaftQuestion::Blockage;
        let answer = self.visibility.shaft(
            simd,
            &shaft,
            question,
            except,
            MOST_LISTED,
            &mut area.shafts,
        );
        self.between(answer, area)
    }

    fn between(&self, answer: ShaftAnswer, area: &mut AreaSpace) -> Between {
        match answer {
            ShaftAnswer::Nothing => Between::Nothing,
            ShaftAnswer::All(shape) if !self.is_own(shape) && !self.is_pane(shape) => Between::All,
            // What it meets is the light itself, or a pane, behind which something else may have been left out.
            ShaftAnswer::All(_) | ShaftAnswer::TooMany => Between::Many,
            ShaftAnswer::These => {
                area.shafts.list.retain(|&shape| !self.is_own(shape));
                if area.shafts.list.is_empty() {
                    Between::Nothing
                } else {
                    Between::Listed
                }
            }
        }
    }

    /// Whether a shape may hide what is above of points of its own.
    fn is_curved(&self, shape: u64) -> bool {
        matches!(occluder(self.world, shape), Occluder::Ball { .. })
    }

    /// Whether a shape is a thin pane, which lets a part of the light pass.
    fn is_pane(&self, shape: u64) -> bool {
        let (object, _) = object_and_triangle(shape);
        self.world.is_pane(object)
    }

    /// Whether a shape is the light itself.
    fn is_own(&self, shape: u64) -> bool {
        is_light(self.world, shape, self.index)
    }

    fn of_packet<S: Simd>(&self, simd: S, packet: usize, area: &mut AreaSpace) -> Between {
        let bounds = self.points.bounds_of_packet(packet);
        let between = self.between_all(simd, bounds, u64::MAX, area);
        if between == Between::Listed {
            area.packet_list.clone_from(&area.shafts.list);
        }
        between
    }

    /// What receives light at a point.
    pub(super) fn receiver(&self, slot: usize, start: &Start) -> Receiver {
        let points = self.points;
        let [x, y, z] = points.shading_normals();
        let normal = DVec3::new(x[slot], y[slot], z[slot]);
        let material = &self.world.materials()[points.material[slot] as usize].value;
        let gloss = match Gloss::of(material) {
            Gloss::None => None,
            Gloss::Lobe { has_cosine, .. } => {
                let [x, y, z] = &points.to_viewer;
                let to_viewer = DVec3::new(x[slot], y[slot], z[slot]);
                let axis = normal * (2.0 * points.cos_viewer[slot]) - to_viewer;
                let gloss = Direction::new(axis).map(|axis| EmitterGloss {
                    axis,
                    shininess: material.shininess(),
                    has_cosine,
                });
                gloss.filter(|gloss| self.light.emitter.may_meet(start.position, gloss))
            }
        };
        let normal = Normal::new(normal).unwrap_or(start.horizon);
        Receiver {
            horizon: start.horizon,
            normal,
            gloss,
        }
    }

    /// What a point receives past what may be in the way, and how much of the light it sees.
    #[expect(clippy::too_many_arguments, reason = "all of it is of one point")]
    fn cut<S: Simd>(
        &self,
        simd: S,
        between: Between,
        start: &Start,
        receiver: &Receiver,
        received: &Received,
        area: &mut AreaSpace,
        of_batch: Between,
    ) -> Cut {
        let most = if self.cuts_all {
            MOST_CUT_FOR_ERROR
        } else {
            MOST_CUT
        };
        let emitter = &self.light.emitter;
        area.occluders.clear();
        if between == Between::Many {
            let shaft = Shaft::ToPoint {
                from: emitter.bounds(),
                to: start.position.0,
            };
            let question = ShaftQuestion::Contents;
            let limit = if self.cuts_all {
                MOST_CUT_FOR_ERROR
            } else {
                MOST_BEFORE_POINT
            };
            let visibility = self.visibility;
            let answer =
                visibility.shaft(simd, &shaft, question, u64::MAX, limit, &mut area.shafts);
            if answer == ShaftAnswer::TooMany {
                return Cut::TooMany;
            }
        }
        let list = match (between, of_batch) {
            (Between::Many, _) => &area.shafts.list,
            (_, Between::Many) => &area.packet_list,
            _ => &area.batch_list,
        };
        let sight = emitter.sight(start.position, start.horizon);
        area.panes_before.clear();
        for &shape in list {
            if self.is_own(shape) {
                continue;
            }
            let occluder = occluder(self.world, shape);
            if self.is_pane(shape) {
                if sight.may_be_hidden_by(&occluder) {
                    let (object, triangle) = object_and_triangle(shape);
                    let from = (emitter, start.position);
                    area.panes_before
                        .add(self.world, [object, triangle], occluder, from);
                }
                continue;
            }
            if shape == start.primitive {
                match self.hidden_by_surface(&occluder, start) {
                    true => return Cut::Hidden,
                    false => continue,
                }
            }
            if sight.may_be_hidden_by(&occluder) {
                area.occluders.push(occluder);
                if area.occluders.len() > most {
                    return Cut::TooMany;
                }
            }
        }
        if area.occluders.is_empty() && area.panes_before.is_empty() {
            return Cut::Seen(*received, 1.0);
        }
        let AreaSpace {
            occluders,
            panes_before,
            shadow,
            ..
        } = area;
        let from = (start.position, start.error);
        let past = panes_before.received(emitter, from, receiver, occluders, self.accuracy, shadow);
        let Some(seen) = past.received else {
            return Cut::Hidden;
        };
        let share = share(&seen, received);
        if share <= NOTHING {
            Cut::Hidden
        } else if past.is_undimmed {
            Cut::Undimmed(seen, share)
        } else {
            Cut::Seen(seen, share)
        }
    }

    /// Whether the shape that a point is on hides the light: a sphere from within, unless the light is within, too.
    fn hidden_by_surface(&self, surface: &Occluder, start: &Start) -> bool {
        let Occluder::Ball { center, radius } = *surface else {
            return false;
        };
        let is_within = start.horizon.get().dot(start.position.0 - center) < 0.0;
        is_within && (self.light.emitter.center().0 - center).length() > radius
    }

    /// Notes what a point receives.
    pub(super) fn put(&self, lit: &mut AreaLit, slot: usize, received: &Received, share: f64) {
        let over_area = self.light.over_area();
        let AreaTerms { geometry, seen } = &mut *lit.terms;
        geometry.diffuse[slot] = (received.irradiance * over_area).min(f64::MAX);
        geometry.specular[slot] = (received.lobe * over_area).min(f64::MAX);
        seen[slot] = share;
        lit.points[slot / LANES] |= 1 << (slot % LANES);
    }
}

/// A shape of the world, as what hides light.
pub(super) fn occluder(world: &World, shape: u64) -> Occluder {
    let (object, triangle) = object_and_triangle(shape);
    match world.objects()[object as usize].shape {
        Shape::Sphere(index) => {
            let sphere = &world.spheres()[index];
            Occluder::Ball {
                center: sphere.center.0,
                radius: sphere.radius,
            }
        }
        Shape::Plane(index) => {
            let plane = &world.planes()[index];
            Occluder::Plane {
                point: plane.point.0,
                normal: plane.normal.get(),
            }
        }
        Shape::Disk(index) => {
            let disk = &world.disks()[index];
            Occluder::Disk {
                center: disk.center.0,
                normal: disk.normal.get(),
                radius: disk.radius,
            }
        }
        Shape::Mesh(_) => Occluder::Triangle(world.triangles().vertices(triangle)),
    }
}

/// Whether a shape is a light itself.
pub(super) fn is_light(world: &World, shape: u64, light: usize) -> bool {
    let (object, _) = object_and_triangle(shape);
    world.objects()[object as usize].emits == Some(light)
}

/// How much of the light is seen: of its illuminance, or where there is none, of its solid angle.
fn share(seen: &Received, all: &Received) -> f64 {
    let part = if all.irradiance > 0.0 {
        seen.irradiance / all.irradiance
    } else {
        seen.solid_angle / all.solid_angle
    };
    part.clamp(0.0, 1.0)
}

/// A batch has a bit for each point.
const _: () = assert!(BATCH == PACKETS * LANES);
