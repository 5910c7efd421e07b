//! What rays that are known to meet shapes have of them: where they do so, and what that says about the
//! points.

use fearless_simd::Simd;

use super::unit::unit;
use crate::math::{DVec3, all_three};
use crate::simd::{DVec3x16, F64x16, LANES, Mask64x16, U32x16, ones};
use crate::visibility::primitive::{DISKS, PLANES, Primitive, SPHERES};
use crate::visibility::question::NearestHit;
use crate::visibility::rays::Rays;
use crate::visibility::search::Search;
use crate::visibility::shape::{PlaneSetup, Triangle, plane, side_by_side, triangle};
use crate::visibility::shapes::Shapes;
use crate::world::geometry::{from_shorter_edges, triangle_normal};
use crate::world::{Shape, World};

/// What a primitive says about all its points.
#[derive(Clone, Copy)]
pub(in crate::visibility) struct SurfaceRecord {
    /// The center of a curved shape, or the normal of a flat one.
    pub(in crate::visibility) reference: DVec3,
    /// A point of a flat shape.
    pub(in crate::visibility) tangent: DVec3,
    pub(in crate::visibility) is_curved: bool,
    pub(in crate::visibility) material: u32,
}

/// A shape that rays are known to meet first.
#[derive(Clone, Copy)]
pub(in crate::visibility) struct KnownShape<S: Simd> {
    pub(in crate::visibility) slot: u32,
    pub(in crate::visibility) primitive: Primitive,
    pub(in crate::visibility) surface: SurfaceRecord,
    /// Of a triangle, as seen from where the rays start.
    pub(in crate::visibility) setup: Option<PlaneSetup<S>>,
}

impl<S: Simd> KnownShape<S> {
    #[inline(never)]
    pub(in crate::visibility) fn new(
        simd: S,
        shapes: &Shapes<'_>,
        slot: u32,
        rays: &Rays<S>,
    ) -> Self {
        simd.vectorize(
            #[inline(always)]
            || Self::at(simd, shapes, slot, rays),
        )
    }

    #[inline(always)]
    fn at(simd: S, shapes: &Shapes<'_>, slot: u32, rays: &Rays<S>) -> Self {
        let mut setup = None;
        let primitive = if slot >= DISKS {
            Primitive::whole(shapes.world.disks()[(slot - DISKS) as usize].object)
        } else if slot >= PLANES {
            let plane = &shapes.world.planes()[(slot - PLANES) as usize];
            Primitive::whole(plane.object)
        } else if slot >= SPHERES {
            shapes.spheres.get(slot - SPHERES).primitive()
        } else {
            let triangle = shapes.triangles.get(slot);
            let [a, b, c] = triangle.vertices();
            let corners = [
                DVec3x16::splat(simd, a),
                DVec3x16::splat(simd, b),
                DVec3x16::splat(simd, c),
            ];
            setup = Some(PlaneSetup::new(corners, rays.origin));
            triangle.primitive()
        };
        Self {
            slot,
            primitive,
            surface: surface_of(shapes.world, primitive),
            setup,
        }
    }

    /// L2 in f64: where rays that are known to meet it do so.
    #[inline(always)]
    pub(in crate::visibility) fn met(
        &self,
        simd: S,
        shapes: &Shapes<'_>,
        rays: &Rays<S>,
        bits: u32,
    ) -> F64x16<S> {
        let asked = Mask64x16::from_bits(simd, bits);
        if let Some(setup) = &self.setup {
            let (_, t) = triangle::met(setup, rays, asked);
            t
        } else if self.slot >= DISKS {
            let disk = &shapes.world.disks()[(self.slot - DISKS) as usize];
            plane::met(&disk.plane(), rays)
        } else if self.slot >= PLANES {
            let plane = &shapes.world.planes()[(self.slot - PLANES) as usize];
            plane::met(plane, rays)
        } else {
            let sphere = shapes.spheres.get(self.slot - SPHERES);
            let met = sphere.first_met(simd, rays, asked);
            let (_, t) = met.expect("a ray that surely meets a sphere meets it");
            t
        }
    }
}

/// One bit for each slot of a packet below another.
#[inline(always)]
pub(in crate::visibility) fn below<S: Simd>(simd: S, slots: &[u32], end: u32) -> u32 {
    U32x16::load(simd, slots)
        .lt(U32x16::splat(simd, end))
        .to_bits()
}

/// Where some rays meet triangles, each its own: t, the unit normal, and a corner.
#[inline(never)]
pub(in crate::visibility) fn meet_triangles<S: Simd>(
    simd: S,
    triangles: &Search<Triangle>,
    rays: &Rays<S>,
    slots: &[u32],
    bits: u32,
) -> (F64x16<S>, DVec3x16<S>, DVec3x16<S>) {
    simd.vectorize(
        #[inline(always)]
        || {
            let corners = side_by_side(
                simd,
                bits,
                #[inline(always)]
                |lane| triangles.get(slots[lane]).vertices(),
            );
            let setup = PlaneSetup::new(corners, rays.origin);
            let (_, t) = triangle::met(&setup, rays, Mask64x16::from_bits(simd, bits));
            let [a, ..] = corners;
            let square = setup.normal.dot(setup.normal);
            let inverse = square.inverse_root(simd);
            (t, unit(simd, setup.normal, square, inverse, bits), a)
        },
    )
}

/// What the primitives of a packet's rays say about the points, ray by ray.
pub(in crate::visibility) struct SurfaceRecords {
    pub(in crate::visibility) t: [f64; LANES],
    pub(in crate::visibility) primitive: [u64; LANES],
    pub(in crate::visibility) material: [u32; LANES],
    pub(in crate::visibility) reference: [[f64; LANES]; 3],
    pub(in crate::visibility) tangent: [[f64; LANES]; 3],
    pub(in crate::visibility) curved: u32,
}

impl SurfaceRecords {
    /// Those of the nearest hits, as far as they are known.
    #[inline(always)]
    pub(in crate::visibility) fn new<S: Simd>(nearest: &NearestHit<S>) -> Self {
        Self {
            t: nearest.t.to_array(),
            primitive: nearest.primitive.to_array(),
            material: [0; LANES],
            reference: [[0.0; LANES]; 3],
            tangent: [[0.0; LANES]; 3],
            curved: 0,
        }
    }

    /// Takes what the world says of the primitives of some rays.
    pub(in crate::visibility) fn take(&mut self, world: &World, bits: u32) {
        let mut known = None;
        for lane in ones(bits) {
            let primitive = Primitive(self.primitive[lane]);
            let surface = match known {
                Some((of, surface)) if of == primitive => surface,
                _ => surface_of(world, primitive),
            };
            known = Some((primitive, surface));
            self.put(lane, surface);
        }
    }

    fn put(&mut self, lane: usize, surface: SurfaceRecord) {
        for axis in 0..3 {
            self.reference[axis][lane] = surface.reference[axis];
            self.tangent[axis][lane] = surface.tangent[axis];
        }
        self.curved |= u32::from(surface.is_curved) << lane;
        self.material[lane] = surface.material;
    }

    /// Where the rays that surely meet shapes do so, each its own.
    #[inline(never)]
    pub(in crate::visibility) fn ask<S: Simd>(
        &mut self,
        simd: S,
        shapes: &Shapes<'_>,
        rays: &Rays<S>,
        slots: &[u32],
        met: u32,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                self.ask_triangles(simd, shapes, rays, slots, met);
                self.ask_others(simd, shapes, rays, slots, met);
            },
        );
    }

    /// Where the rays that meet triangles do so, each its own.
    #[inline(always)]
    fn ask_triangles<S: Simd>(
        &mut self,
        simd: S,
        shapes: &Shapes<'_>,
        rays: &Rays<S>,
        slots: &[u32],
        met: u32,
    ) {
        let bits = below(simd, slots, SPHERES) & met;
        if bits == 0 {
            return;
        }
        let (t, normal, _) = meet_triangles(simd, &shapes.triangles, rays, slots, bits);
        let t = t.to_array();
        let normal = [
            normal.x.to_array(),
            normal.y.to_array(),
            normal.z.to_array(),
        ];
        for lane in ones(bits) {
            let triangle = shapes.triangles.get(slots[lane]);
            let (object, _) = triangle.primitive().parts();
            self.t[lane] = t[lane];
            self.primitive[lane] = triangle.primitive().0;
            self.put(
                lane,
                SurfaceRecord {
                    reference: DVec3::from_array(all_three(normal, |column| column[lane])),
                    tangent: triangle.vertices()[0],
                    is_curved: false,
                    material: shapes.world.objects()[object as usize].material as u32,
                },
            );
        }
    }

    /// Where the rays that meet other shapes do so, shape by shape.
    #[inline(always)]
    fn ask_others<S: Simd>(
        &mut self,
        simd: S,
        shapes: &Shapes<'_>,
        rays: &Rays<S>,
        slots: &[u32],
        met: u32,
    ) {
        let mut left = met & !below(simd, slots, SPHERES);
        while left != 0 {
            let slot = slots[left.trailing_zeros() as usize];
            let mut bits = 0;
            for (lane, &other) in slots.iter().enumerate() {
                bits |= u32::from(other == slot) << lane;
            }
            bits &= left;
            left &= !bits;
            let known_shape = KnownShape::new(simd, shapes, slot, rays);
            let t = known_shape.met(simd, shapes, rays, bits).to_array();
            for lane in ones(bits) {
                self.t[lane] = t[lane];
                self.primitive[lane] = known_shape.primitive.0;
                self.put(lane, known_shape.surface);
            }
        }
    }
}

#[inline]
pub(in crate::visibility) fn surface_of(world: &World, primitive: Primitive) -> SurfaceRecord {
    let (object, triangle) = primitive.parts();
    let object = &world.objects()[object as usize];
    let material = object.material as u32;
    match object.shape {
        Shape::Sphere(index) => SurfaceRecord {
            reference: world.spheres()[index].center.0,
            tangent: DVec3::ZERO,
            is_curved: true,
            material,
        },
        Shape::Plane(index) => {
            let plane = &world.planes()[index];
            SurfaceRecord {
                reference: plane.normal.get(),
                tangent: plane.point.0,
                is_curved: false,
                material,
            }
        }
        Shape::Disk(index) => {
            let disk = &world.disks()[index];
            SurfaceRecord {
                reference: disk.normal.get(),
                tangent: disk.center.0,
                is_curved: false,
                material,
            }
        }
        Shape::Mesh(_) => {
            let vertices = world.triangles().vertices(triangle);
            let normal = triangle_normal(vertices).expect("no triangle is degenerate");
            SurfaceRecord {
                reference: normal.get(),
                tangent: from_shorter_edges(vertices)[0],
                is_curved: false,
                material,
            }
        }
    }
}
