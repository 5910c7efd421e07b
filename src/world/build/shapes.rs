//! Objects: their shapes in world space, and their materials.

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::{Builder, LARGEST, Reported, listed};
use crate::math::{Normal, all_three};
use crate::mesh::{MeshError, MeshRemarks};
use crate::scene::{self, MeshFile, Problem, ShadowTerminator, Spanned};
use crate::world::geometry::{
    Mesh, MeshNormals, NormalCorners, Plane, Sphere, Triangles, triangle_normal,
};
use crate::world::{Shape, World};

/// What `scale` may be: the factors up to [`LARGEST`], and their inverses.
const SCALES: &str = "factors that are not 0, each at least 1e-30 or at most -1e-30";

impl Builder<'_> {
    /// An object's shape, put where its kind is kept, and its material.
    pub(super) fn object(
        &mut self,
        entry: &scene::Entry<scene::Object>,
        world: &mut World,
    ) -> Result<(usize, Shape), Reported> {
        let id = world.objects.len() as u32;
        let material = self.material_of(&entry.value);
        let shape = match &entry.value {
            scene::Object::Sphere { center, radius, .. } => {
                let center = self.position("center", *center);
                let length = self.length("radius", *radius);
                self.reserve(&mut world.spheres, 1)?;
                let (center, length) = (center?, length?);
                self.check_radius(center, length, *radius)?;
                world.spheres.push(Sphere {
                    center,
                    radius: length,
                    object: id,
                });
                Shape::Sphere(world.spheres.len() - 1)
            }
            scene::Object::Plane { point, normal, .. } => {
                let position = self.position("point", *point);
                let direction = self.direction("normal", *normal);
                self.reserve(&mut world.planes, 1)?;
                let (position, direction) = (position?, direction?);
                world.planes.push(Plane {
                    point: self.near_point(position, point.value, normal.value),
                    normal: direction,
                    object: id,
                });
                Shape::Plane(world.planes.len() - 1)
            }
            // Where no triangle has moved, they are in the world already.
            scene::Object::Triangle { .. } | scene::Object::Mesh { .. } if self.kept.is_some() => {
                self.kept_meshes += 1;
                Shape::Mesh(self.kept_meshes - 1)
            }
            scene::Object::Triangle { vertices, .. } => {
                let first = world.triangles.len();
                self.triangle(vertices, id, Arc::make_mut(&mut world.triangles))?;
                self.check_triangles(world, first, "vertices", vertices.span)?;
                Shape::Mesh(world.triangles.meshes.len() - 1)
            }
            scene::Object::Mesh {
                file,
                scale,
                rotate,
                translate,
                smooth,
                shadow_terminator,
                geometry,
                ..
            } => {
                let placement = self.placement(*scale, *rotate, *translate);
                if let Err(conflict) = self.meshes.check(geometry) {
                    self.report(file.span, Problem::Conflict(conflict));
                    return Err(Reported);
                }
                let first = world.triangles.len();
                self.mesh(
                    geometry,
                    *smooth,
                    &placement?,
                    id,
                    file,
                    Arc::make_mut(&mut world.triangles),
                )?;
                self.check_triangles(world, first, "file", file.span)?;
                if let Some(mesh) = Arc::make_mut(&mut world.triangles).meshes.last_mut() {
                    mesh.shadow_terminator = *shadow_terminator;
                }
                Shape::Mesh(world.triangles.meshes.len() - 1)
            }
        };
        Ok((material?, shape))
    }

    fn material_of(&mut self, object: &scene::Object) -> Result<usize, Reported> {
        let Spanned { value: name, span } = object.material();
        if let Some(&index) = self.materials.get(name.as_str()) {
            return Ok(index);
        }
        let is_hidden = self.broken.lost_entries || self.broken.materials.contains(name);
        if !is_hidden && !self.has_enough() {
            let materials = self.scene.materials.iter();
            let expected = materials.map(|entry| entry.name.as_str());
            let problem = Problem::unknown("material", name, expected);
            self.report(*span, problem);
        }
        Err(Reported)
    }

    fn triangle(
        &mut self,
        vertices: &Spanned<[[f64; 3]; 3]>,
        object: u32,
        triangles: &mut Triangles,
    ) -> Result<(), Reported> {
        let mut corners = [DVec3::ZERO; 3];
        for (corner, &value) in corners.iter_mut().zip(&vertices.value) {
            *corner = self
                .position("vertices", Spanned::new(value, vertices.span))?
                .0;
        }
        if triangle_normal(corners).is_none() {
            let value = format!("{:?}", vertices.value);
            let expected = "three corners that are not on one line";
            self.out_of_range("vertices", vertices.span, value, expected);
            return Err(Reported);
        }
        self.reserve_mesh(triangles, 3, 1)?;
        let first_vertex = triangles.positions.len() as u32;
        let start = triangles.len() as u32;
        triangles.positions.extend(corners);
        triangles
            .corners
            .push([first_vertex, first_vertex + 1, first_vertex + 2]);
        triangles.meshes.push(Mesh {
            object,
            triangles: start..start + 1,
            normals: None,
            shadow_terminator: ShadowTerminator::default(),
            degenerate: 0,
            vanished: 0,
            remarks: MeshRemarks::default(),
        });
        Ok(())
    }

    /// Two triangles between four corners in turn, as one mesh.
    pub(super) fn rectangle(
        &mut self,
        corners: [DVec3; 4],
        object: u32,
        span: scene::Span,
        triangles: &mut Triangles,
    ) -> Result<(), Reported> {
        let halves = [[0, 1, 2], [0, 2, 3]];
        let has_area = |half: [usize; 3]| triangle_normal(half.map(|it| corners[it])).is_some();
        if !halves.into_iter().all(has_area) {
            let conflict = "the light is so small beside its distance from the camera's `look_at` that 64-bit floats \
                            do not tell its corners apart, expected a larger one, or `visible = false`";
            self.report(span, Problem::Conflict(conflict.to_owned()));
            return Err(Reported);
        }
        self.reserve_mesh(triangles, 4, 2)?;
        let first = triangles.positions.len() as u32;
        let start = triangles.len() as u32;
        triangles.positions.extend(corners);
        for half in halves {
            triangles
                .corners
                .push(half.map(|corner| first + corner as u32));
        }
        triangles.meshes.push(Mesh {
            object,
            triangles: start..start + 2,
            normals: None,
            shadow_terminator: ShadowTerminator::default(),
            degenerate: 0,
            vanished: 0,
            remarks: MeshRemarks::default(),
        });
        Ok(())
    }

    /// Room for a mesh more, with so many positions and triangles.
    fn reserve_mesh(
        &mut self,
        into: &mut Triangles,
        positions: usize,
        triangles: usize,
    ) -> Result<(), Reported> {
        self.reserve(&mut into.positions, positions)?;
        self.reserve(&mut into.corners, triangles)?;
        self.reserve(&mut into.meshes, 1)
    }

    fn placement(
        &mut self,
        scale: Spanned<[f64; 3]>,
        rotate: Spanned<[f64; 3]>,
        translate: Spanned<[f64; 3]>,
    ) -> Result<Placement, Reported> {
        let factors = self.vector("scale", scale);
        let degrees = self.vector("rotate", rotate);
        let moved = self.position("translate", translate);
        let (factors, degrees, moved) = (factors?, degrees?, moved?);
        let smallest = factors.abs().min_element();
        if smallest < 1.0 / LARGEST {
            let value = listed(&scale.value);
            self.out_of_range("scale", scale.span, value, SCALES);
            return Err(Reported);
        }
        let [x, y, z] = degrees.to_array().map(f64::to_radians);
        let rotation = rotation_z(z) * rotation_y(y) * rotation_x(x);
        Ok(Placement {
            linear: rotation * DMat3::from_diagonal(factors),
            // The inverse transpose of R S is R S⁻¹.
            normals: rotation * DMat3::from_diagonal(factors.recip()),
            moved: moved.0,
        })
    }

    /// A mesh, put where its placement says.
    fn mesh(
        &mut self,
        file: &MeshFile,
        smooth: bool,
        placement: &Placement,
        object: u32,
        path: &Spanned<PathBuf>,
        triangles: &mut Triangles,
    ) -> Result<(), Reported> {
        self.make_room(file, path, triangles)?;
        let (first_vertex, start) = (triangles.positions.len(), triangles.len());
        self.place_vertices(file, placement, path, &mut triangles.positions)?;
        let faces = self.faces(file, path, &triangles.positions[first_vertex..])?;
        faces.keep(&mut triangles.corners, &file.triangles, first_vertex as u32);
        let normals = match &file.normals {
            Some(normals) if smooth => {
                let mut vectors = Vec::new();
                self.reserve(&mut vectors, normals.vectors.len())?;
                // A vector without a direction belongs to no triangle: the file's reader saw to that.
                vectors.par_extend(normals.vectors.par_iter().map(|&normal| {
                    Normal::new(placement.normals * DVec3::from_array(normal))
                        .unwrap_or_else(any_normal)
                }));
                let corners = match &normals.triangles {
                    Some(written) => {
                        let mut corners = Vec::new();
                        self.reserve(&mut corners, faces.count)?;
                        faces.keep(&mut corners, written, 0);
                        NormalCorners::Own(corners)
                    }
                    None => NormalCorners::OfVertices(first_vertex as u32),
                };
                Some(MeshNormals { vectors, corners })
            }
            Some(_) | None => None,
        };
        triangles.meshes.push(Mesh {
            object,
            triangles: start as u32..triangles.len() as u32,
            normals,
            shadow_terminator: ShadowTerminator::default(),
            degenerate: file.triangles.len() - faces.count - faces.vanished,
            vanished: faces.vanished,
            remarks: if smooth {
                file.remarks.clone()
            } else {
                file.remarks.without_normals()
            },
        });
        Ok(())
    }

    /// Room for a mesh, in numbers of 32 bits and in memory.
    fn make_room(
        &mut self,
        file: &MeshFile,
        path: &Spanned<PathBuf>,
        triangles: &mut Triangles,
    ) -> Result<(), Reported> {
        let fits = |count: usize| u32::try_from(count).is_ok();
        if !fits(triangles.positions.len() + file.positions.len())
            || !fits(triangles.len() + file.triangles.len())
        {
            let conflict = "the meshes together have more than 4294967295 vertices or triangles";
            self.report(path.span, Problem::Conflict(conflict.to_owned()));
            return Err(Reported);
        }
        let room = triangles.positions.try_reserve(file.positions.len());
        let room = room.and_then(|()| triangles.corners.try_reserve(file.triangles.len()));
        if let Err(error) = room {
            let problem = Problem::Mesh {
                path: path.value.clone(),
                error: Box::new(MeshError::from(error)),
            };
            self.report(path.span, problem);
            return Err(Reported);
        }
        self.reserve(&mut triangles.meshes, 1)
    }

    /// Appends the vertices of a mesh.
    fn place_vertices(
        &mut self,
        file: &MeshFile,
        placement: &Placement,
        path: &Spanned<PathBuf>,
        into: &mut Vec<DVec3>,
    ) -> Result<(), Reported> {
        let first = into.len();
        let positions = file
            .positions
            .par_iter()
            .map(|&position| placement.linear * DVec3::from_array(position) + placement.moved);
        into.par_extend(positions);
        let placed = &mut into[first..];
        let is_beyond =
            |position: &DVec3| position.is_nan() || position.abs().max_element() > 2.0 * LARGEST;
        if !placed.par_iter().any(is_beyond) {
            return Ok(());
        }
        let corners = || {
            let corners = file.triangles.iter().flatten();
            corners.map(|&corner| corner as usize)
        };
        if corners().any(|corner| is_beyond(&placed[corner])) {
            let conflict = "the mesh has vertices beyond 1e30 scene units once it is placed";
            self.report(path.span, Problem::Conflict(conflict.to_owned()));
            return Err(Reported);
        }
        // Those that no triangle uses may be anywhere; here they are where another one is.
        let used = corners()
            .next()
            .map_or(DVec3::ZERO, |corner| placed[corner]);
        for position in placed.iter_mut().filter(|position| is_beyond(position)) {
            *position = used;
        }
        Ok(())
    }

    /// Which triangles of a mesh have an area where its vertices are placed.
    fn faces(
        &mut self,
        file: &MeshFile,
        path: &Spanned<PathBuf>,
        placed: &[DVec3],
    ) -> Result<Faces, Reported> {
        let mut has_area = Vec::new();
        self.reserve(&mut has_area, file.triangles.len())?;
        has_area.par_extend(file.triangles.par_iter().map(|corners| {
            triangle_normal(all_three(*corners, |corner| placed[corner as usize])).is_some()
        }));
        let count = has_area.par_iter().filter(|&&has_area| has_area).count();
        if count == has_area.len() {
            return Ok(Faces {
                has_area,
                count,
                vanished: 0,
            });
        }
        let without_area = file.triangles.iter().zip(&has_area);
        let without_area = without_area.filter(|(_, has_area)| !**has_area);
        let had_area = |corners: &[u32; 3]| {
            let written = |corner| DVec3::from_array(file.positions[corner as usize]);
            triangle_normal(corners.map(written)).is_some()
        };
        let vanished = without_area
            .filter(|(corners, _)| had_area(corners))
            .count();
        if count == 0 {
            let conflict = if vanished == 0 {
                "every triangle of the mesh is degenerate: none has an area"
            } else {
                "every triangle of the mesh is so small where it is placed that 64-bit floats cannot \
                 tell its corners apart, expected a larger `scale`"
            };
            self.report(path.span, Problem::Conflict(conflict.to_owned()));
            return Err(Reported);
        }
        Ok(Faces {
            has_area,
            count,
            vanished,
        })
    }
}

/// Which triangles of a mesh have an area.
struct Faces {
    has_area: Vec<bool>,
    /// How many have.
    count: usize,
    /// How many of the others have one in the file.
    vanished: usize,
}

impl Faces {
    /// Appends the corners of the triangles with area, each by `offset` larger.
    fn keep(&self, kept: &mut Vec<[u32; 3]>, corners: &[[u32; 3]], offset: u32) {
        if self.count == corners.len() {
            let moved = corners.par_iter();
            kept.par_extend(moved.map(|&corners| all_three(corners, |corner| corner + offset)));
            return;
        }
        let with_area = corners.iter().zip(&self.has_area);
        let with_area = with_area.filter(|&(_, &has_area)| has_area);
        kept.extend(with_area.map(|(corners, _)| all_three(*corners, |corner| corner + offset)));
    }
}

/// v ↦ R S v + T.
struct Placement {
    linear: DMat3,
    normals: DMat3,
    moved: DVec3,
}

/// What a mesh normal without a direction becomes, which no triangle uses.
fn any_normal() -> Normal {
    Normal::new(DVec3::Y).expect("the y axis has a direction")
}

fn rotation_x(angle: f64) -> DMat3 {
    let (sin, cos) = libm::sincos(angle);
    DMat3::from_cols(
        DVec3::X,
        DVec3::new(0.0, cos, sin),
        DVec3::new(0.0, -sin, cos),
    )
}

fn rotation_y(angle: f64) -> DMat3 {
    let (sin, cos) = libm::sincos(angle);
    DMat3::from_cols(
        DVec3::new(cos, 0.0, -sin),
        DVec3::Y,
        DVec3::new(sin, 0.0, cos),
    )
}

fn rotation_z(angle: f64) -> DMat3 {
    let (sin, cos) = libm::sincos(angle);
    DMat3::from_cols(
        DVec3::new(cos, sin, 0.0),
        DVec3::new(-sin, cos, 0.0),
        DVec3::Z,
    )
}
