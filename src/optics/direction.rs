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
/// along the normal stays so. d + c n, the part along the surface, is made before it is divided by η, so that what
/// cancels in it is not enlarged; t has unit length to 1e-15 for η in 0.25..=4.
pub(crate) fn refracted(direction: DVec3, normal: DVec3, eta: f64) -> Option<DVec3> {
    // The dot product of unit vectors may be above 1 in its last digit.
    let cos_incident = (-normal.dot(direction)).clamp(0.0, 1.0);
    let cos_transmitted = cos_transmitted(cos_incident, eta)?;
    let along = direction + normal * cos_incident;
    Some(along / eta - normal * cos_transmitted)
}
