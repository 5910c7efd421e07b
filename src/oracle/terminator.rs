//! L4: where the way to a light starts, by `shadow_terminator`.

use super::vector::{Vector, ZERO, add, dot, length, scale, subtract};

/// A point p of a triangle of a smooth mesh.
pub(super) struct OnTriangle {
    /// p
    pub(super) position: Vector,
    /// v₀, v₁, v₂
    pub(super) vertices: [Vector; 3],
    /// n₀, n₁, n₂ of unit length, on the viewer's side.
    pub(super) normals: [Vector; 3],
    /// b₀, b₁, b₂ of p.
    pub(super) barycentric: [f64; 3],
}

impl OnTriangle {
    /// p′ − p for `shadow_terminator = "hanika"`: from each vertex to p there is a way vᵢp. Where it leads
    /// below the tangent plane of the vertex, it is projected onto the plane. The mean of the projected
    /// ways' ends, weighted by the barycentric coordinates, is p′ (Hanika, "Hacking the Shadow
    /// Terminator", Ray Tracing Gems II, 2021).
    pub(super) fn lift(&self) -> Vector {
        let mut lift = ZERO;
        for corner in 0..3 {
            let (vertex, normal) = (self.vertices[corner], self.normals[corner]);
            let along_normal = dot(subtract(self.position, vertex), normal);
            let onto_plane = scale(normal, -along_normal.min(0.0));
            lift = add(lift, scale(onto_plane, self.barycentric[corner]));
        }
        lift
    }

    /// The size of the coordinates from which p′ is computed, beside those of p.
    pub(super) fn magnitude(&self) -> f64 {
        self.vertices.map(length).into_iter().fold(0.0, f64::max)
    }
}
