//! Points, directions, normals and rays in f64 over glam.

pub use glam::DVec3;

/// A position in world space, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point(pub DVec3);

/// A direction of unit length, such as ω_i or ω_o.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction(DVec3);

/// A surface normal of unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normal(DVec3);

/// L1: r(t) = o + t ω. `t` is in units of the direction's length, which need not be 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// o: where the ray starts.
    pub origin: Point,
    /// ω: where it goes, of any length but zero.
    pub direction: DVec3,
}

impl Point {
    /// A point from its coordinates.
    pub const fn new(x: f64, y: f64, z: f64) -> Self {
        Self(DVec3::new(x, y, z))
    }

    /// The vector from `origin` to this point.
    pub fn from(self, origin: Self) -> DVec3 {
        self.0 - origin.0
    }
}

impl From<[f64; 3]> for Point {
    fn from(coordinates: [f64; 3]) -> Self {
        Self(DVec3::from_array(coordinates))
    }
}

/// Numbers in this range, and their roots, have all their digits as f32 too.
pub(crate) const SAFE_SQUARES: std::ops::Range<f64> = 1e-30..1e30;

/// 1/√x for x within [`SAFE_SQUARES`], to 4e-16 of it: an f32 root, and two of Newton's steps. Each
/// operation is exact to the last bit everywhere, and it takes a fraction of the time of a root and a
/// division in f64.
pub(crate) fn inverse_root(x: f64) -> f64 {
    let mut y = f64::from(1.0 / (x as f32).sqrt());
    for _ in 0..2 {
        y += y * ((1.0 - x * y * y) * 0.5);
    }
    y
}

/// `vector` at unit length, or `None` where it has no direction (zero, infinite or NaN).
///
/// Tiny and huge vectors are scaled by their largest component first, so that they neither
/// underflow nor overflow when they are squared.
#[inline]
fn unit(vector: DVec3) -> Option<DVec3> {
    let square = vector.length_squared();
    if SAFE_SQUARES.contains(&square) {
        return Some(vector * inverse_root(square));
    }
    let largest = vector.abs().max_element();
    if !(largest > 0.0 && vector.is_finite()) {
        return None;
    }
    let scaled = vector / largest;
    Some(scaled / scaled.length())
}

impl Direction {
    /// The direction of `vector`, or `None` where it has none (zero, infinite or NaN).
    #[inline]
    pub fn new(vector: DVec3) -> Option<Self> {
        unit(vector).map(Self)
    }

    /// The unit vector.
    pub const fn get(self) -> DVec3 {
        self.0
    }
}

impl Normal {
    /// The normal along `vector`, or `None` where it has no direction (zero, infinite or NaN).
    #[inline]
    pub fn new(vector: DVec3) -> Option<Self> {
        unit(vector).map(Self)
    }

    /// The unit vector.
    pub const fn get(self) -> DVec3 {
        self.0
    }

    /// The same normal on the other side of the surface.
    pub fn flipped(self) -> Self {
        Self(-self.0)
    }
}

impl From<Direction> for Normal {
    fn from(direction: Direction) -> Self {
        Self(direction.0)
    }
}

impl Ray {
    /// The point at parameter `t` (L1).
    pub fn at(&self, t: f64) -> Point {
        Point(self.origin.0 + self.direction * t)
    }
}

/// `f` of each of two. What the standard library does for arrays of any length is mostly compiled apart from
/// its caller, and so without the instructions of a kernel.
#[inline(always)]
pub(crate) fn both<T, U>([a, b]: [T; 2], f: impl Fn(T) -> U) -> [U; 2] {
    [f(a), f(b)]
}

/// `f` of each of three, as [`both`].
#[inline(always)]
pub(crate) fn all_three<T, U>([a, b, c]: [T; 3], f: impl Fn(T) -> U) -> [U; 3] {
    [f(a), f(b), f(c)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_root_is_as_exact_as_it_says() {
        for exponent in -299..300 {
            let x = 10_f64.powf(f64::from(exponent) / 10.0);
            // The exact quotient is 1, up to the rounding of the product.
            let error = (inverse_root(x) * x.sqrt() - 1.0).abs();
            assert!(error < 4e-16 + f64::EPSILON, "{x}: {error}");
        }
    }

    #[test]
    fn unit_vectors_at_every_magnitude() {
        for magnitude in [1e-300, 1e-160, 1e-6, 1.0, 1e6, 1e160, 1e300] {
            let unit = Direction::new(DVec3::new(3.0, 0.0, -4.0) * magnitude)
                .unwrap()
                .get();
            assert!(
                (unit - DVec3::new(0.6, 0.0, -0.8)).length() < 1e-15,
                "{magnitude}"
            );
        }
    }

    #[test]
    fn no_direction_without_a_length() {
        assert!(Direction::new(DVec3::ZERO).is_none());
        assert!(Normal::new(DVec3::new(f64::NAN, 0.0, 1.0)).is_none());
        assert!(Normal::new(DVec3::new(f64::INFINITY, 0.0, 1.0)).is_none());
    }
}
