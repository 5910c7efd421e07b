//! What becomes of a light at a point.

use serde::Serialize;

/// What becomes of one light at one point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// It adds its term to L9.
    Lit,
    /// It has an area, of which something stands before a part.
    Partial,
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
