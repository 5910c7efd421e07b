//! L1 and L2 over a square of the image: where its rays meet a shape, as models.

use super::model::{Model, Vector};
use super::view::{Approach, View};
use crate::emitter::Occluder;
use crate::math::DVec3;
use crate::world::geometry::from_shorter_edges;
use crate::world::{Shape, World};

/// A shape with all that its surface is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Solid {
    Sphere {
        center: DVec3,
        radius: f64,
    },
    Plane {
        point: DVec3,
        normal: DVec3,
    },
    Disk {
        center: DVec3,
        normal: DVec3,
        radius: f64,
    },
    Triangle {
        corners: [DVec3; 3],
        normal: DVec3,
        /// Of a smooth mesh.
        normals: Option<[DVec3; 3]>,
        /// Whether shadow rays start elsewhere than on it.
        is_lifted: bool,
    },
}

impl Solid {
    /// How far a point is from it, at least.
    pub(super) fn distance(&self, point: DVec3) -> f64 {
        match *self {
            Self::Sphere { center, radius } => ((point - center).length() - radius).abs(),
            Self::Plane {
                point: on_it,
                normal,
            } => normal.dot(point - on_it).abs(),
            Self::Disk {
                center,
                normal,
                radius,
            } => {
                let way = point - center;
                (way.length() - radius).max(normal.dot(way).abs())
            }
            Self::Triangle {
                corners: [a, b, c],
                normal,
                ..
            } => {
                let (least, most) = (a.min(b).min(c), a.max(b).max(c));
                let beside = (point.clamp(least, most) - point).length();
                beside.max(normal.dot(point - a).abs())
            }
        }
    }

    /// As what hides light.
    pub(super) fn occluder(&self) -> Occluder {
        match *self {
            Self::Sphere { center, radius } => Occluder::Ball { center, radius },
            Self::Plane { point, normal } => Occluder::Plane { point, normal },
            Self::Disk {
                center,
                normal,
                radius,
            } => Occluder::Disk {
                center,
                normal,
                radius,
            },
            Self::Triangle { corners, .. } => Occluder::Triangle(corners),
        }
    }

    /// A point and the normal of the plane that it is in, unless it is round.
    pub(super) fn plane(&self) -> Option<[DVec3; 2]> {
        match *self {
            Self::Sphere { .. } => None,
            Self::Plane { point, normal } => Some([point, normal]),
            Self::Disk { center, normal, .. } => Some([center, normal]),
            Self::Triangle {
                corners, normal, ..
            } => Some([corners[0], normal]),
        }
    }

    /// How rays get to its plane.
    pub(super) fn approach(&self, view: &View) -> Option<Approach> {
        let [point, normal] = self.plane()?;
        Approach::new(view, point, normal)
    }

    /// Whether all rays through a square meet it, as far as they get.
    pub(super) fn is_all_over(&self, view: &View) -> bool {
        if !self
            .approach(view)
            .is_some_and(|approach| approach.is_met())
        {
            return false;
        }
        match *self {
            Self::Sphere { .. } | Self::Disk { .. } => false,
            Self::Plane { .. } => true,
            Self::Triangle { corners, .. } => {
                let edges = edges(view, corners);
                edges.iter().all(|edge| edge.least() > 0.0)
                    || edges.iter().all(|edge| edge.most() < 0.0)
            }
        }
    }

    /// Whether it is round, and no ray through a square meets it: shafts tell that of the boxes around shapes.
    pub(super) fn is_missed(&self, view: &View) -> bool {
        let inside = match *self {
            Self::Sphere { center, radius } => discriminant(view, center, radius).1,
            Self::Disk {
                center,
                normal,
                radius,
            } => within_disk(view, center, normal, radius),
            Self::Plane { .. } | Self::Triangle { .. } => return false,
        };
        inside.most() < 0.0
    }

    /// The edge function of a triangle's edge that passes through a square, if it is one alone: above 0 inside.
    pub(super) fn edge(&self, view: &View) -> Option<Model> {
        match *self {
            Self::Triangle { corners, .. } => one_edge(view, corners),
            Self::Sphere { .. } | Self::Plane { .. } | Self::Disk { .. } => None,
        }
    }

    /// Whether all of it is behind another one that all rays meet.
    pub(super) fn is_behind(&self, front: &Self, view: &View) -> bool {
        let Some((to_front, [point, _])) = front.approach(view).zip(front.plane()) else {
            return false;
        };
        let is_plane_behind = || {
            let to_plane = self.approach(view);
            to_plane.is_some_and(|to_plane| to_front.before(&to_plane).least() > 0.0)
        };
        // What is in its plane may be seen in its place.
        self.height_above(point, -to_front.normal) > 1.0 || is_plane_behind()
    }

    /// Whether all of it is on the side of a plane that the normal points to, or in it.
    pub(super) fn is_above(&self, point: DVec3, normal: DVec3) -> bool {
        self.height_above(point, normal) >= -1.0
    }

    /// How high it is above a plane at least, in units of what rounding may make of 0.
    fn height_above(&self, point: DVec3, normal: DVec3) -> f64 {
        let height =
            |place: DVec3, reach: f64| (normal.dot(place - point) - reach) / rounding(place, point);
        match *self {
            Self::Sphere { center, radius } => height(center, radius),
            Self::Plane { .. } => f64::NEG_INFINITY,
            Self::Disk {
                center,
                normal: across,
                radius,
            } => height(center, radius * normal.cross(across).length()),
            Self::Triangle { corners, .. } => {
                let heights = corners.map(|corner| height(corner, 0.0));
                heights.into_iter().fold(f64::INFINITY, f64::min)
            }
        }
    }

    /// Whether the one edge of it that passes through a square is in a plane.
    pub(super) fn stands_on(&self, view: &View, point: DVec3, normal: DVec3) -> bool {
        let Self::Triangle { corners, .. } = *self else {
            return false;
        };
        let edges = edges(view, corners);
        let mut mixed = (0..3).filter(|&i| !(edges[i].least() > 0.0 || edges[i].most() < 0.0));
        let is_in = |place: DVec3| normal.dot(place - point).abs() <= rounding(place, point);
        match (mixed.next(), mixed.next()) {
            (Some(i), None) => is_in(corners[i]) && is_in(corners[(i + 1) % 3]),
            _ => false,
        }
    }

    /// The shape of an object, and of a mesh the triangle.
    pub(super) fn of(world: &World, object: u32, triangle: u32) -> Self {
        match world.objects()[object as usize].shape {
            Shape::Sphere(index) => {
                let sphere = &world.spheres()[index];
                Self::Sphere {
                    center: sphere.center.0,
                    radius: sphere.radius,
                }
            }
            Shape::Plane(index) => {
                let plane = &world.planes()[index];
                Self::Plane {
                    point: plane.point.0,
                    normal: plane.normal.get(),
                }
            }
            Shape::Disk(index) => {
                let disk = &world.disks()[index];
                Self::Disk {
                    center: disk.center.0,
                    normal: disk.normal.get(),
                    radius: disk.radius,
                }
            }
            Shape::Mesh(index) => {
                let triangles = world.triangles();
                let mesh = &triangles.meshes()[index];
                let corners = triangles.vertices(triangle);
                let [a, b, c] = from_shorter_edges(corners);
                Self::Triangle {
                    corners,
                    normal: (b - a).cross(c - a).normalize(),
                    normals: mesh.normals.as_ref().map(|normals| {
                        let first = mesh.triangles.start;
                        let normals = triangles.normals_at(normals, first, triangle);
                        normals.map(crate::math::Normal::get)
                    }),
                    is_lifted: mesh.lifts_shadow_rays(),
                }
            }
        }
    }
}

/// Where the rays through a square meet a shape.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    /// t
    pub(super) distance: Model,
    /// p
    pub(super) position: Vector,
    /// ω_o
    pub(super) to_viewer: Vector,
    /// n · ω_o
    pub(super) cos_viewer: Model,
    normal: Normal,
    /// Whether shadow rays start elsewhere than at p.
    pub(super) is_lifted: bool,
}

/// n, on the viewer's side.
#[derive(Clone, Copy, Debug)]
enum Normal {
    Flat {
        point: DVec3,
        normal: DVec3,
    },
    /// n = ±(p − c)/R
    Round {
        offset: Vector,
        center: DVec3,
        radius: f64,
        sign: f64,
    },
    /// Interpolated, over a flat triangle.
    Smooth {
        point: DVec3,
        flat: DVec3,
        normal: Vector,
    },
}

/// Where the silhouette of a shape passes through a square: the shape is where this is above 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Silhouette {
    pub(super) inside: Model,
    /// Of a sphere, √inside is a coordinate of its surface.
    pub(super) is_round: bool,
}

impl Surface {
    /// Of a shape that all rays meet.
    pub(super) fn new(view: &View, solid: &Solid) -> Option<Self> {
        match *solid {
            Solid::Sphere { center, radius } => {
                let (to_center, inside) = discriminant(view, center, radius);
                Self::round(view, center, radius, to_center, inside.root())
            }
            Solid::Plane { point, normal } => Self::flat(view, point, normal),
            Solid::Disk { center, normal, .. } => Self::flat(view, center, normal),
            Solid::Triangle {
                corners,
                normal,
                normals,
                is_lifted,
            } => {
                let surface = Self::flat(view, corners[0], normal)?;
                let surface = match normals {
                    Some(normals) => surface.smooth(corners, normals)?,
                    None => surface,
                };
                Some(Self {
                    is_lifted,
                    ..surface
                })
            }
        }
    }

    /// Of a shape whose silhouette passes through the square.
    pub(super) fn at_silhouette(
        view: &View,
        solid: &Solid,
        silhouette: &Silhouette,
    ) -> Option<Self> {
        match *solid {
            Solid::Sphere { center, radius } if silhouette.is_round => {
                // √D from 0 to its largest is the third coordinate.
                let root = Model::third(silhouette.inside.most().max(0.0).sqrt() * 0.5);
                let to_center = -view.origin.minus(center);
                Self::round(view, center, radius, to_center, root)
            }
            _ => Self::new(view, solid),
        }
    }

    fn flat(view: &View, point: DVec3, normal: DVec3) -> Option<Self> {
        let Approach {
            height,
            facing,
            normal,
        } = Approach::new(view, point, normal).filter(Approach::is_met)?;
        let distance = height * facing.reciprocal();
        distance.is_known().then(|| Self {
            distance,
            position: view.origin + view.direction.scaled(distance),
            to_viewer: -view.direction.scaled(view.inverse),
            cos_viewer: facing * view.inverse,
            normal: Normal::Flat { point, normal },
            is_lifted: false,
        })
    }

    /// Of a sphere, from √D.
    fn round(
        view: &View,
        center: DVec3,
        radius: f64,
        to_center: Vector,
        root: Model,
    ) -> Option<Self> {
        let outside = to_center.dot(to_center).plus(-radius * radius);
        let sign = if outside.least() > 0.0 {
            1.0
        } else if outside.most() < 0.0 {
            -1.0
        } else {
            return None;
        };
        let middle = to_center.dot(view.direction);
        let distance = (middle - root.times(sign)) * view.square.reciprocal();
        let is_before = distance.is_known() && distance.least() > 0.0;
        let offset = view.direction.scaled(distance) - to_center;
        is_before.then(|| Self {
            distance,
            position: offset.minus(-center),
            to_viewer: -view.direction.scaled(view.inverse),
            // (p − c)·ω = −√D
            cos_viewer: (root * view.inverse).times(1.0 / radius),
            normal: Normal::Round {
                offset,
                center,
                radius,
                sign,
            },
            is_lifted: false,
        })
    }

    /// With interpolated normals: Σ bᵢ nᵢ at unit length, b linear in p.
    fn smooth(self, corners: [DVec3; 3], normals: [DVec3; 3]) -> Option<Self> {
        let Normal::Flat { normal: flat, .. } = self.normal else {
            return None;
        };
        let area = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let over = 1.0 / area.length_squared();
        let weight = |i: usize| {
            let (a, b) = (corners[(i + 1) % 3], corners[(i + 2) % 3]);
            // The area of the triangle of p and the opposite edge, over all of it.
            let along = area.cross(b - a) * over;
            self.position.minus(a).along(along)
        };
        let mut sum = Vector::constant(DVec3::ZERO);
        for (i, &normal) in normals.iter().enumerate() {
            sum = sum + Vector::constant(normal).scaled(weight(i));
        }
        let normal = sum.scaled(sum.dot(sum).root().reciprocal());
        let side = normal.along(flat);
        let normal = if side.least() > 0.0 {
            normal
        } else if side.most() < 0.0 {
            -normal
        } else {
            return None;
        };
        let cos_viewer = normal.dot(self.to_viewer);
        cos_viewer.is_known().then_some(Self {
            cos_viewer,
            normal: Normal::Smooth {
                point: corners[0],
                flat,
                normal,
            },
            ..self
        })
    }

    /// n, of L5.
    pub(super) fn normal(&self) -> Vector {
        match self.normal {
            Normal::Flat { normal, .. } => Vector::constant(normal),
            Normal::Smooth { normal, .. } => normal,
            Normal::Round {
                offset,
                radius,
                sign,
                ..
            } => offset.scaled(Model::constant(sign / radius)),
        }
    }

    /// A point and the geometric normal of the plane that it is in, unless it is round.
    pub(super) fn plane(&self) -> Option<[DVec3; 2]> {
        match self.normal {
            Normal::Flat { point, normal } => Some([point, normal]),
            Normal::Smooth { point, flat, .. } => Some([point, flat]),
            Normal::Round { .. } => None,
        }
    }

    /// n · (l − p), of the geometric normal: a light at l is above where it is above 0.
    pub(super) fn height(&self, light: DVec3) -> Model {
        match self.normal {
            Normal::Flat { point, normal } => Model::constant(normal.dot(light - point)),
            Normal::Smooth { point, flat, .. } => Model::constant(flat.dot(light - point)),
            Normal::Round { .. } => self.shading_height(light),
        }
    }

    /// n · (l − p) of L5.
    pub(super) fn shading_height(&self, light: DVec3) -> Model {
        match self.normal {
            Normal::Flat { .. } => self.height(light),
            Normal::Smooth { normal, .. } => -self.position.minus(light).dot(normal),
            Normal::Round {
                offset,
                center,
                radius,
                sign,
            } => offset
                .along(light - center)
                .plus(-radius * radius)
                .times(sign / radius),
        }
    }

    /// How far outside of the sphere a light is that is met from its inside: below 0 where it is inside, too.
    pub(super) fn beyond(&self, light: DVec3) -> Option<f64> {
        match self.normal {
            Normal::Round {
                center,
                radius,
                sign,
                ..
            } if sign < 0.0 => Some((light - center).length() - radius),
            Normal::Round { .. } | Normal::Flat { .. } | Normal::Smooth { .. } => None,
        }
    }

    /// Whether the normal is an interpolated one.
    pub(super) fn is_smooth(&self) -> bool {
        matches!(self.normal, Normal::Smooth { .. })
    }
}

/// From the origins of rays to a sphere's center, and the discriminant D = R²|ω|² − |(c − o) × ω|² of where they
/// meet it. Near the silhouette b² − ac would be the difference of numbers that are larger by far.
fn discriminant(view: &View, center: DVec3, radius: f64) -> (Vector, Model) {
    let to_center = -view.origin.minus(center);
    let beside = to_center.cross(view.direction);
    let inside = view.square.times(radius * radius) - beside.dot(beside);
    (to_center, inside)
}

/// Where lines along `way` come through a disk, `to_center` being the way from where they start to its center:
/// above 0 there. They meet its plane at m/(n·d) beside the center, m = h d − (n·d) e = n × (d × e): R² (n·d)² − |m|².
pub(super) fn within_rim(way: Vector, to_center: Vector, normal: DVec3, radius: f64) -> Model {
    let facing = way.along(normal);
    let beside = Vector::constant(normal).cross(way.cross(to_center));
    (facing * facing).times(radius * radius) - beside.dot(beside)
}

/// Where rays come through a disk: above 0 there.
fn within_disk(view: &View, center: DVec3, normal: DVec3, radius: f64) -> Model {
    let to_center = -view.origin.minus(center);
    within_rim(view.direction, to_center, normal, radius)
}

impl Solid {
    /// Its silhouette in a square, if that is one curve there; and how far the rays get before it, at most.
    pub(super) fn silhouette(&self, view: &View) -> Option<(Silhouette, f64)> {
        match *self {
            Self::Sphere { center, radius } => {
                let (to_center, inside) = discriminant(view, center, radius);
                let middle = to_center.dot(view.direction) * view.square.reciprocal();
                let is_before = middle.least() > 0.0 && inside.is_known();
                let silhouette = Silhouette {
                    inside,
                    is_round: true,
                };
                is_before.then_some((silhouette, middle.most()))
            }
            Self::Plane { point, normal } => {
                let height = view.origin.minus(point).along(normal);
                let sign = height.center.signum();
                let silhouette = Silhouette {
                    inside: view.direction.along(normal * -sign),
                    is_round: false,
                };
                (height.times(sign).least() > 0.0).then_some((silhouette, f64::INFINITY))
            }
            Self::Disk {
                center,
                normal,
                radius,
            } => {
                let inside = within_disk(view, center, normal, radius);
                let surface = Surface::new(view, self)?;
                let silhouette = Silhouette {
                    inside,
                    is_round: false,
                };
                let is_told = inside.is_known();
                is_told.then_some((silhouette, surface.distance.most()))
            }
            Self::Triangle { corners, .. } => {
                let inside = one_edge(view, corners)?;
                let surface = Surface::new(view, self)?;
                let silhouette = Silhouette {
                    inside,
                    is_round: false,
                };
                Some((silhouette, surface.distance.most()))
            }
        }
    }
}

/// How far from its plane rounding may put a point, by their coordinates: what is nearer is on neither side.
pub(super) fn rounding(place: DVec3, point: DVec3) -> f64 {
    1e-12 * (place.abs() + point.abs()).max_element()
}

/// The edge function of a triangle's edge that passes through a square, if it is one alone: above 0 inside.
fn one_edge(view: &View, corners: [DVec3; 3]) -> Option<Model> {
    one_of(edges(view, corners))
}

/// The one of three edge functions that changes its sign, turned so that the others are above 0.
pub(super) fn one_of(edges: [Model; 3]) -> Option<Model> {
    let mut mixed = None;
    let mut sign = 0.0;
    for edge in edges {
        let side = if edge.least() > 0.0 {
            1.0
        } else if edge.most() < 0.0 {
            -1.0
        } else {
            if mixed.replace(edge).is_some() {
                return None;
            }
            continue;
        };
        if sign * side < 0.0 {
            return None;
        }
        sign = side;
    }
    let edge = mixed?;
    Some(if sign < 0.0 { -edge } else { edge })
}

/// det(ω, a − o, b − o) of the edges, as det(ω, a − o, b − a): linear in the place of the image, and as a model so too,
/// because only ω or only o differs from ray to ray.
fn edges(view: &View, corners: [DVec3; 3]) -> [Model; 3] {
    [0, 1, 2].map(|i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        let way = -view.origin.minus(a);
        way.cross(Vector::constant(b - a)).dot(view.direction)
    })
}
