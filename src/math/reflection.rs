//! Reflection about a plane: of points, directions and cameras.

use glam::{DAffine3, DMat3, DVec3};

use super::plane::Plane;

/// The mirror image of a point, in the plane's space: `p - 2 (n.(p - o)) n`.
///
/// In relative form, which does not lose what the distance of the plane from the origin would
/// cost in a matrix.
pub fn reflect_point(plane: &Plane, p: DVec3) -> DVec3 {
    p - plane.normal * (2.0 * plane.signed_distance(p))
}

/// The mirror image of a direction, about the plane through the origin with unit `normal`.
pub fn reflect_vector(normal: DVec3, v: DVec3) -> DVec3 {
    v - normal * (2.0 * normal.dot(v))
}

/// The reflection as a transform: Householder's `I - 2 n n^T`, and `2 (n.o) n` as translation.
///
/// Its own inverse, of determinant -1. Applied to coordinates far from the origin it loses more
/// than [`reflect_point`] does.
pub fn reflection_affine(plane: &Plane) -> DAffine3 {
    DAffine3 {
        matrix3: DMat3::from_cols(
            reflect_vector(plane.normal, DVec3::X),
            reflect_vector(plane.normal, DVec3::Y),
            reflect_vector(plane.normal, DVec3::Z),
        ),
        translation: reflect_point(plane, DVec3::ZERO),
    }
}

/// The camera as it stands behind the mirror: `R W = [W3 - 2 n (n^T W3) | e - 2 h n]`, where
/// `h` is the height of the eye over the plane.
///
/// It changes handedness, so what it draws winds the other way round. Point by point it sees
/// through the mirror's surface what the camera sees reflected in it, at the same pixel.
pub fn reflected_world_from_view(plane: &Plane, world_from_view: &DAffine3) -> DAffine3 {
    let axes = world_from_view.matrix3;
    DAffine3 {
        matrix3: DMat3::from_cols(
            reflect_vector(plane.normal, axes.x_axis),
            reflect_vector(plane.normal, axes.y_axis),
            reflect_vector(plane.normal, axes.z_axis),
        ),
        translation: reflect_point(plane, world_from_view.translation),
    }
}
