//! The reflection by construction, with no code of the plugin: a proper camera at the reflected eye, the geometry cut at
//! the plane beforehand, the mirror itself taken away, and the picture flipped.
//!
//! Let `R` be the reflection and `W` the camera's transform. What the mirror shows at a place of the screen is what the
//! frame `R W` sees there. That frame is left-handed, so no camera can stand in it; but `R W diag(-1, 1, 1)` is right-handed,
//! and it sees the same with left and right exchanged.

use bevy::{
    math::{DMat3, DQuat},
    prelude::*,
};

use super::{cut::Plane, scene::exact};

/// Where the camera of the reference stands.
pub fn reflected_eye(eye: &Transform, plane: Plane) -> Transform {
    assert_eq!(
        eye.scale,
        Vec3::ONE,
        "a scaled camera has no proper reflection here"
    );
    let eye = exact(eye);
    let axes = eye.matrix3;
    let rotation = DMat3::from_cols(
        -plane.reflect_direction(axes.x_axis),
        plane.reflect_direction(axes.y_axis),
        plane.reflect_direction(axes.z_axis),
    );
    let rotation = DQuat::from_mat3(&rotation).normalize().as_quat();
    Transform {
        translation: plane.reflect(eye.translation).as_vec3(),
        rotation: rotation.normalize(),
        scale: Vec3::ONE,
    }
}

/// The camera reflected as it is, and therefore left-handed: what it sees needs no flip, but its
/// triangles wind the other way. It may be scaled.
pub fn left_handed_eye(eye: &Transform, plane: Plane) -> Transform {
    let upright = reflected_eye(&eye.with_scale(Vec3::ONE), plane);
    upright.with_scale(eye.scale * Vec3::new(-1.0, 1.0, 1.0))
}
