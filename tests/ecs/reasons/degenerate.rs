//! Numbers from which there is nothing to compute: in transforms, planes and projections.

use bevy::prelude::*;
use bevy_planar_mirror::{MirrorPlane, NotDrawn, PlanarMirror};

use super::{assert_blind, assert_only, pair};
use crate::ecs::app::{EYE, PLAIN, not};

#[test]
fn degenerate_transform() {
    let scale = |x, y, z| Transform::from_scale(vec3(x, y, z));
    for at in [
        Transform::from_xyz(f32::NAN, 0.0, 0.0),
        Transform::from_xyz(0.0, f32::INFINITY, 0.0),
        Transform::from_xyz(0.0, 0.0, f32::NEG_INFINITY),
        Transform::from_rotation(Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0)),
        scale(0.0, 0.0, 0.0),
        scale(1.0, 0.0, 1.0),
        scale(0.0, 1.0, 1.0),
        scale(f32::NAN, 1.0, 1.0),
        scale(1.0, f32::INFINITY, 1.0),
    ] {
        let (mut app, mirror, camera) = pair();
        *app.of_mut::<Transform>(mirror) = at;
        assert_only(&mut app, mirror, camera, NotDrawn::DegenerateTransform);
        *app.of_mut::<Transform>(mirror) = default();
        app.update();
        app.assert_state(mirror, camera, PLAIN);
    }
}

#[test]
fn degenerate_transform_by_a_parent() {
    let (mut app, mirror, camera) = pair();
    let parent = app.spawn((Transform::from_scale(Vec3::ZERO), Visibility::default()));
    app.insert(mirror, ChildOf(parent));
    assert_only(&mut app, mirror, camera, NotDrawn::DegenerateTransform);
}

#[test]
fn degenerate_given_plane() {
    for (point, normal) in [
        (Vec3::ZERO, Vec3::ZERO),
        (Vec3::ZERO, Vec3::NAN),
        (Vec3::ZERO, vec3(0.0, f32::INFINITY, 0.0)),
        (vec3(f32::NAN, 0.0, 0.0), Vec3::Z),
        (Vec3::INFINITY, Vec3::Z),
    ] {
        let (mut app, mirror, camera) = pair();
        let plane = MirrorPlane::Local { point, normal };
        app.of_mut::<PlanarMirror>(mirror).plane = plane;
        assert_only(&mut app, mirror, camera, NotDrawn::DegenerateTransform);
    }
}

#[test]
fn degenerate_camera_transform() {
    // Without a forward direction, as of scale 0, Bevy itself panics in update_frusta, if it has debug assertions.
    for eye in [
        EYE.with_translation(Vec3::NAN),
        EYE.with_translation(Vec3::INFINITY),
        EYE.with_scale(vec3(1.0, 0.0, 1.0)),
        EYE.with_scale(vec3(0.0, 0.0, 1.0)),
    ] {
        let (mut app, mirror, camera) = pair();
        *app.of_mut::<Transform>(camera) = eye;
        assert_blind(&mut app, mirror, camera, NotDrawn::DegenerateCamera);
    }
}

#[test]
fn degenerate_camera_projection() {
    let perspective = |fov: f32, near: f32| -> Projection {
        PerspectiveProjection {
            fov,
            near,
            ..default()
        }
        .into()
    };
    for projection in [
        perspective(f32::NAN, 0.1),
        perspective(1.0, f32::NAN),
        perspective(1.0, f32::INFINITY),
        perspective(1.0, 0.0),
        OrthographicProjection {
            scale: 0.0,
            ..OrthographicProjection::default_3d()
        }
        .into(),
        OrthographicProjection {
            near: 5.0,
            far: 5.0,
            ..OrthographicProjection::default_3d()
        }
        .into(),
    ] {
        let (mut app, mirror, camera) = pair();
        app.insert(camera, projection);
        assert_blind(&mut app, mirror, camera, NotDrawn::DegenerateCamera);
    }
}

#[test]
fn below_precision() {
    let (mut app, mirror, camera) = pair();
    let far = vec3(3e6, 0.0, 0.0);
    *app.of_mut::<Transform>(mirror) = Transform::from_translation(far);
    *app.of_mut::<Transform>(camera) = EYE.with_translation(EYE.translation + far);
    app.update();
    app.assert_state(mirror, camera, not(NotDrawn::BelowPrecision));
    assert!(app.views().is_empty());
}
