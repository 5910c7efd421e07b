//! L4: where the way to a light starts, by `shadow_terminator`.

use super::vector::{WideVector, ZERO, add, dot, length, scale, subtract, widened};
use super::wide::{Real, Wide};

/// A point p of a triangle of a smooth mesh.
pub(super) struct OnTriangle {
    /// p
    pub(super) position: WideVector,
    /// v₀, v₁, v₂
    pub(super) vertices: [WideVector; 3],
    /// n₀, n₁, n₂ of unit length, on the viewer's side.
    pub(super) normals: [WideVector; 3],
    /// b₀, b₁, b₂ of p.
    pub(super) barycentric: [Wide; 3],
}

impl OnTriangle {
    /// p′ − p for `shadow_terminator = "hanika"`: from each vertex to p there is a way vᵢp. Where it leads
    /// below the tangent plane of the vertex, it is projected onto the plane. The mean of the projected
    /// ways' ends, weighted by the barycentric coordinates, is p′ (Hanika, "Hacking the Shadow
    /// Terminator", Ray Tracing Gems II, 2021).
    pub(super) fn lift(&self) -> WideVector {
        let mut lift = widened(ZERO);
        for corner in 0..3 {
            let (vertex, normal) = (self.vertices[corner], self.normals[corner]);
            let along_normal = dot(subtract(self.position, vertex), normal);
            let below = -along_normal;
            let below = if below > Wide::from(0.0) {
                below
            } else {
                Wide::from(0.0)
            };
            let onto_plane = scale(normal, below);
            lift = add(lift, scale(onto_plane, self.barycentric[corner]));
        }
        lift
    }

    /// The size of the coordinates from which p′ is computed, beside those of p.
    pub(super) fn magnitude(&self) -> f64 {
        self.vertices
            .map(|vertex| length(vertex).narrow())
            .into_iter()
            .fold(0.0, f64::max)
    }
}
