//! A plane in space.

use glam::{DVec3, DVec4};

/// A plane through `origin`, in any one space; the front is where `normal` points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// A point on the plane. Best one near the geometry: distances are measured from it.
    pub origin: DVec3,
    /// The unit normal, to the front.
    pub normal: DVec3,
}

impl Plane {
    /// The plane through `origin` with a normal of any length.
    ///
    /// `None` if `origin` is not finite or `normal` has no direction.
    pub fn new(origin: DVec3, normal: DVec3) -> Option<Self> {
        let normal = direction(normal)?;
        origin.is_finite().then_some(Self { origin, normal })
    }

    /// How far `p` is in front of the plane; negative behind it.
    ///
    /// In relative form, `n.(p - o)`: far from the origin of the world, `n.p - n.o` would be the
    /// small difference of two large numbers.
    #[inline]
    pub fn signed_distance(&self, p: DVec3) -> f64 {
        self.normal.dot(p - self.origin)
    }

    /// The plane as `(n, d)` with `n.p + d` the signed distance of `p`, and so `d = -n.o`.
    pub fn covector(&self) -> DVec4 {
        self.normal.extend(-self.normal.dot(self.origin))
    }

    pub(super) fn is_finite(&self) -> bool {
        self.origin.is_finite() && self.normal.is_finite()
    }
}

/// `v` at unit length; `None` if it is zero or not finite.
///
/// Scaled by its largest component first, whose square may overflow or vanish.
pub(super) fn direction(v: DVec3) -> Option<DVec3> {
    let largest = v.abs().max_element();
    if !v.is_finite() || largest == 0.0 {
        return None;
    }
    let scaled = v / largest;
    let unit = scaled / scaled.length();
    unit.is_finite().then_some(unit)
}
