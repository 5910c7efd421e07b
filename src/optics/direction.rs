//! Where reflected and refracted light goes.

use super::fresnel::cos_transmitted;
use crate::math::DVec3;

/// r = d − 2 (n·d) n: the direction that `direction` is reflected into.
///
/// Both vectors have unit length. Either side of the surface may be that of the normal.
pub(crate) fn reflected(direction: DVec3, normal: DVec3) -> DVec3 {
    direction - normal * (2.0 * normal.dot(direction))
}

/// t = (d + c n)/η − c_t n: the direction that `direction` is refracted into, `None` at total reflection (Snell).
///
/// Both vectors have unit length, and the normal is on the side that light comes from: c = −n·d is in 0..=1. Light
/// along the normal stays so.
///
/// What a unit vector lacks of its length is multiplied by up to 1/η² on its way. t (3 − |t|²)/2, a step of Newton's,
/// restores it: t has unit length to 5e-16 for η in 0.25..=4, through any number of boundaries.
pub(crate) fn refracted(direction: DVec3, normal: DVec3, eta: f64) -> Option<DVec3> {
    // The dot product of unit vectors may be above 1 in its last digit.
    let cos_incident = (-normal.dot(direction)).clamp(0.0, 1.0);
    let cos_transmitted = cos_transmitted(cos_incident, eta)?;
    let along = direction + normal * cos_incident;
    let refracted = along / eta - normal * cos_transmitted;
    Some(refracted * (1.5 - 0.5 * refracted.dot(refracted)))
}
