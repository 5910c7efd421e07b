//! What becomes of a light at a point, and of a ray.

use serde::Serialize;

/// What becomes of one light at one point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// It adds its term to L9.
    Lit,
    /// It has an area, of which something stands before a part.
    Partial,
    /// It is seen through panes: V is what they let through.
    Through,
    /// It is above the surface, but something stands between: V = 0.
    Occluded,
    /// It is below the surface, n·ω_i ≤ 0 for the geometric normal, or for n where shadow rays are lifted: it
    /// adds nothing.
    Below,
    /// It is a spot and the point is outside of its cone, or a luminaire that sends nothing there, or an area that does not
    /// shine to its side: it adds nothing.
    Outside,
    /// It is at the point itself, d = 0: it adds nothing.
    AtPoint,
}

/// What becomes of a ray, which goes against the way of light, where it ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Event {
    /// It goes on as in a mirror, with the part R or F of its light.
    Reflected,
    /// The same with all of its light: it comes from where n is larger, and too aslant to leave.
    TotallyReflected,
    /// It goes on in the other medium, with the part (1 − F)(n_i/n_t)² of its light.
    Refracted,
    /// It goes on straight through a pane, with the part T of its light.
    Passed,
    /// It goes on straight, with all of its light: the surface is within a glass that counts for more.
    Unchanged,
    /// What it sees is a surface with lobes, that lights light.
    Lit,
    /// What it sees is a light.
    Emitted,
    /// It hits nothing.
    Background,
    /// It would go on, but has done so `max_depth` times: what is farther on adds nothing.
    TooDeep,
    /// It would go on to the wrong side of a mesh, whose normals are interpolated: that adds nothing.
    Lost,
}
