//! Mirrors in one plane: they have one reflection, which needs to be drawn once.

use glam::DVec3;

use super::{
    patch::tangents,
    plane::{Plane, direction},
};

/// Normals may differ by this angle, in radians: some roundings of an `f32` rotation. What is
/// reflected moves by twice that, which is thousandths of a pixel.
const MAX_ANGLE: f64 = 1e-6;
/// Corners may lie off the plane by so many `f32` steps of the coordinates.
const MAX_STEPS: f64 = 4.0;

/// Whether the mirror with these `corners` and the plane `other` lies in `plane` and faces its
/// front, as far as single precision can tell.
pub fn is_in_plane(plane: &Plane, other: &Plane, corners: &[DVec3; 4]) -> bool {
    let largest = corners
        .iter()
        .fold(plane.origin.abs(), |largest, corner| {
            largest.max(corner.abs())
        })
        .max_element();
    let off = MAX_STEPS * f64::from(f32::EPSILON) * largest;
    plane.normal.dot(other.normal) > 0.0
        && plane.normal.cross(other.normal).length() <= MAX_ANGLE
        && corners
            .iter()
            .all(|corner| plane.signed_distance(*corner).abs() <= off)
}

/// The corners of a rectangle of `plane` that holds all `quads`, along an edge of the first.
///
/// `None` if there are no quads, or they are not finite.
pub fn joint_corners(
    plane: &Plane,
    quads: impl Iterator<Item = [DVec3; 4]> + Clone,
) -> Option<[DVec3; 4]> {
    let first = quads.clone().next()?;
    let edge = first[1] - first[0];
    let x = match direction(edge - plane.normal * plane.normal.dot(edge)) {
        Some(x) => x,
        None => tangents(plane.normal)?.0,
    };
    let y = plane.normal.cross(x);
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for corner in quads.flatten() {
        let offset = corner - plane.origin;
        let place = DVec3::new(x.dot(offset), y.dot(offset), 0.0);
        low = low.min(place);
        high = high.max(place);
    }
    let corner = |along_x: f64, along_y: f64| plane.origin + x * along_x + y * along_y;
    let corners = [
        corner(low.x, low.y),
        corner(high.x, low.y),
        corner(high.x, high.y),
        corner(low.x, high.y),
    ];
    corners.iter().all(|c| c.is_finite()).then_some(corners)
}
