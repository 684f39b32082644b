//! What lies in front of a mirror, behind it and across, and what its frame hides.

use glam::{DMat4, DVec2, DVec3, DVec4};

use super::{plane::Plane, polygon::VisiblePolygon};

/// By how much the culling planes keep clear of the polygon, in pixels.
const CULLING_GUARD_PX: f64 = 2.0;

/// On which side of a mirror an object lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// Shows nothing in the mirror.
    Behind,
    /// Shows whole, without a cut at the plane.
    InFront,
    /// Must be cut at the plane.
    Straddling,
}

/// The least and the greatest signed distance of the points of a box from a plane.
///
/// `half_axes` run from the center of the box to the middles of three faces. Exact for every
/// parallelepiped.
#[inline]
pub fn signed_distance_range(plane: &Plane, center: DVec3, half_axes: [DVec3; 3]) -> (f64, f64) {
    let middle = plane.signed_distance(center);
    let [x, y, z] = half_axes.map(|axis| plane.normal.dot(axis).abs());
    let reach = x + y + z;
    (middle - reach, middle + reach)
}

/// The side of an object whose points have signed distances in `range`.
///
/// What reaches no more than `tolerance` behind the plane counts as in front of it, and what
/// reaches no more than that in front of it as behind: an object in the plane shows nothing new.
/// An unknown range (not a number) straddles: it is drawn, and cut.
#[inline]
pub fn classify((least, greatest): (f64, f64), tolerance: f64) -> Side {
    // Both comparisons at once: which of them holds is not to be predicted.
    match (greatest <= tolerance, least >= -tolerance) {
        (true, _) => Side::Behind,
        (false, true) => Side::InFront,
        (false, false) => Side::Straddling,
    }
}

/// The planes left, right, bottom and top of what is seen between `low` and `high` on the screen,
/// in view space, with unit normals to the inside: `n.p + d >= 0`.
///
/// Through these bounds and two pixels around them, but not beyond the screen. They are the same
/// for the camera and for its reflection. Where there is no such plane, because the bounds are
/// those of nothing or the projection degenerate, `(0, 0, 0, 1)`, which everything is inside of.
pub fn narrowed_sides(
    (low, high): (DVec2, DVec2),
    clip_from_view: &DMat4,
    viewport_size: DVec2,
) -> [DVec4; 4] {
    let guard = DVec2::splat(CULLING_GUARD_PX * 2.0) / viewport_size;
    let low = (low - guard).max(DVec2::NEG_ONE);
    let high = (high + guard).min(DVec2::ONE);
    let (x, y, w) = (
        clip_from_view.row(0),
        clip_from_view.row(1),
        clip_from_view.row(3),
    );
    [x - w * low.x, w * high.x - x, y - w * low.y, w * high.y - y].map(with_unit_normal)
}

/// The planes along the edges of a polygon of the screen, in view space, to the inside: an object
/// that is behind one of them does not show in the polygon.
///
/// Each is two pixels away from its edge. An edge without a length gives none.
pub fn edge_sides<'a>(
    polygon: &'a VisiblePolygon,
    clip_from_view: &'a DMat4,
    viewport_size: DVec2,
) -> impl Iterator<Item = DVec4> + 'a {
    let pixels = viewport_size * 0.5;
    let next = polygon.ndc().cycle().skip(1);
    let turn = polygon.twice_area().signum();
    polygon.ndc().zip(next).filter_map(move |(a, b)| {
        let along = (b - a) * pixels;
        let normal = along.perp() * turn / along.length();
        // n.(p - a) + guard in pixels, with p = (x, y) / w times pixels.
        let (n, a) = (normal * pixels, a * pixels);
        let side = clip_from_view.row(0) * n.x
            + clip_from_view.row(1) * n.y
            + clip_from_view.row(3) * (CULLING_GUARD_PX - normal.dot(a));
        side.is_finite().then_some(side)
    })
}

fn with_unit_normal(plane: DVec4) -> DVec4 {
    let unit = plane / plane.truncate().length();
    if unit.is_finite() { unit } else { DVec4::W }
}
