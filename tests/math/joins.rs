//! Mirrors that lie in one plane share a reflection; which do is told despite rounding, and not more.

use bevy_planar_mirror::math::*;
use glam::{Affine3A, DQuat, DVec2, DVec3, Quat, Vec3};
use proptest::prelude::*;

use crate::random::cases;

/// A 2x2 tile that faces +Z, placed by a transform in `f32`.
fn tile(rotation: Quat, place: Vec3) -> (Plane, [DVec3; 4]) {
    let patch = PlanarPatch {
        center: DVec3::ZERO,
        tangent_x: DVec3::X,
        tangent_y: DVec3::Y,
        half_size: DVec2::ONE,
    };
    let world_from_local = Affine3A::from_rotation_translation(rotation, place).as_daffine3();
    let (plane, corners) = transform_patch(&patch, &world_from_local).expect("it is a tile");
    (plane, corners.expect("with bounds"))
}

proptest! {
    #![proptest_config(cases(4))]

    #[test]
    fn tiles_of_a_wall_are_one_mirror(
        angles in prop::array::uniform3(-3.0..3.0_f32),
        center in prop::array::uniform3(-100.0..100.0_f32),
        steps in (-20..20_i32, -20..20_i32),
    ) {
        let rotation = Quat::from_euler(glam::EulerRot::XYZ, angles[0], angles[1], angles[2]);
        let center = Vec3::from_array(center);
        let step = rotation * Vec3::new(2.0 * steps.0 as f32, 2.0 * steps.1 as f32, 0.0);
        let (plane, first) = tile(rotation, center);
        let (other, corners) = tile(rotation, center + step);
        prop_assert!(is_in_plane(&plane, &other, &corners));
        let joint = joint_corners(&plane, [first, corners].into_iter()).expect("two tiles");
        let [origin, x, _, y] = joint;
        for corner in first.iter().chain(&corners) {
            for axis in [x - origin, y - origin] {
                let along = (*corner - origin).dot(axis) / axis.length_squared();
                prop_assert!((-1e-5..=1.0 + 1e-5).contains(&along), "{corner} at {along}");
            }
        }
        for corner in joint {
            prop_assert!(plane.signed_distance(corner).abs() < 1e-9);
        }
        // Their own edges: it is no larger than it must be.
        let area = (x - origin).length() * (y - origin).length();
        let spanned = f64::from((2 + 2 * steps.0.abs()) * (2 + 2 * steps.1.abs()));
        prop_assert!((area - spanned).abs() < 1e-3 * spanned, "{area} instead of {spanned}");
    }

    #[test]
    fn a_tile_that_stands_out_or_leans_is_a_mirror_of_its_own(
        angles in prop::array::uniform3(-3.0..3.0_f32),
        center in prop::array::uniform3(-10.0..10.0_f32),
        out in 1e-3..1.0_f32,
        lean in 1e-4..1.0_f64,
    ) {
        let rotation = Quat::from_euler(glam::EulerRot::XYZ, angles[0], angles[1], angles[2]);
        let center = Vec3::from_array(center);
        let (plane, _) = tile(rotation, center);
        let (other, corners) = tile(rotation, center + rotation * Vec3::new(2.0, 0.0, out));
        prop_assert!(!is_in_plane(&plane, &other, &corners));
        let leaning = (rotation.as_dquat() * DQuat::from_rotation_x(lean)).as_quat();
        let (other, corners) = tile(leaning, center);
        prop_assert!(!is_in_plane(&plane, &other, &corners));
    }
}

#[test]
fn the_back_of_a_wall_is_not_its_front() {
    let (plane, corners) = tile(Quat::IDENTITY, Vec3::ZERO);
    let back = Plane {
        normal: -plane.normal,
        ..plane
    };
    assert!(!is_in_plane(&plane, &back, &corners));
}

/// A tiny tile may lean much before a corner leaves the plane; its normal tells.
#[test]
fn a_tiny_tile_is_told_by_its_normal() {
    let (plane, _) = tile(Quat::IDENTITY, Vec3::new(100.0, 0.0, 0.0));
    let normal = DVec3::new(1e-4, 0.0, 1.0).normalize();
    let other = Plane { normal, ..plane };
    let corners = [DVec3::new(100.0, 0.0, 0.0); 4];
    assert!(!is_in_plane(&plane, &other, &corners));
}

#[test]
fn nothing_has_no_joint_corners() {
    let (plane, _) = tile(Quat::IDENTITY, Vec3::ZERO);
    assert!(joint_corners(&plane, [].into_iter()).is_none());
    let corners = [DVec3::NAN; 4];
    assert!(!is_in_plane(&plane, &plane, &corners));
    assert!(joint_corners(&plane, [corners].into_iter()).is_none());
}
