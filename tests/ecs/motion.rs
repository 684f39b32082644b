//! A view stands where the reflection of its camera stands, in the same frame.

use bevy::{math::Affine3A, prelude::*};
use bevy_planar_mirror::math::{Plane, reflected_world_from_view};
use glam::{DAffine3, DVec3};

use super::app::{EYE, MirrorApp, above, floor, mirror_app, upwards};

fn exact(affine: Affine3A) -> DAffine3 {
    DAffine3::from_mat3_translation(affine.matrix3.as_dmat3(), affine.translation.as_dvec3())
}

/// The world transform that these local transforms make, outermost first.
fn chain(locals: &[Transform]) -> DAffine3 {
    locals.iter().fold(DAffine3::IDENTITY, |world, local| {
        world * exact(local.compute_affine())
    })
}

/// The plane of a `Rectangle`: its normal is +Z and its middle the origin.
fn plane(world_from_mirror: &DAffine3) -> Plane {
    let axes = world_from_mirror.matrix3;
    let normal = axes.x_axis.cross(axes.y_axis);
    let front = if normal.dot(axes.z_axis) < 0.0 {
        -normal
    } else {
        normal
    };
    Plane::new(world_from_mirror.translation, front).expect("not degenerate")
}

/// The view stands where it belongs, as far as single precision can tell.
#[track_caller]
fn assert_reflects(
    app: &mut MirrorApp,
    (camera, camera_locals): (Entity, &[Transform]),
    (mirror, mirror_locals): (Entity, &[Transform]),
) {
    let view = app.view(camera, mirror);
    let actual = exact(app.of::<GlobalTransform>(view).affine());

    // From what Bevy itself made of this frame's transforms: one rounding.
    let world_from = |entity: Entity| exact(app.of::<GlobalTransform>(entity).affine());
    let (of_camera, of_mirror) = (world_from(camera), world_from(mirror));
    let expected = reflected_world_from_view(&plane(&of_mirror), &of_camera);
    assert_alike(actual, expected, 1e-6);

    // From this frame's transforms, multiplied in double precision: Bevy's own roundings besides.
    let (of_camera, of_mirror) = (chain(camera_locals), chain(mirror_locals));
    let expected = reflected_world_from_view(&plane(&of_mirror), &of_camera);
    assert_alike(actual, expected, 1e-5);
}

#[track_caller]
fn assert_alike(actual: DAffine3, expected: DAffine3, tolerance: f64) {
    let columns = |a: DAffine3| -> [DVec3; 4] {
        let m = a.matrix3;
        [m.x_axis, m.y_axis, m.z_axis, a.translation]
    };
    for (a, b) in columns(actual).into_iter().zip(columns(expected)) {
        let error = (a - b).abs().max_element();
        assert!(
            error <= tolerance * (1.0 + b.length()),
            "{actual:?} is {error} off {expected:?}"
        );
    }
}

#[test]
fn a_view_is_the_reflection_of_its_camera() {
    let mut app = mirror_app();
    let (at, eye) = (Transform::from_xyz(0.0, 0.0, 1.0), EYE);
    let (mirror, camera) = (app.spawn_mirror(at), app.spawn_camera(eye));
    app.update();
    assert_reflects(&mut app, (camera, &[eye]), (mirror, &[at]));
    // By hand: five from the origin, one before it the mirror, so three behind it.
    let view = app.view(camera, mirror);
    let place = app.of::<GlobalTransform>(view);
    assert_eq!(place.translation(), vec3(0.0, 0.0, -3.0));
    assert_eq!(
        place.affine().matrix3,
        Mat3::from_diagonal(vec3(1.0, 1.0, -1.0)).into()
    );
}

#[test]
fn a_view_follows_mirror_and_camera_in_the_frame_in_which_they_move() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(floor(0.0)), app.spawn_camera(above()));
    app.update();
    for step in 1..20 {
        let angle = step as f32 * 0.02;
        let at = floor(0.3 * angle).with_rotation(upwards() * Quat::from_rotation_x(angle));
        let eye = Transform::from_xyz(angle, 2.0 + angle, 4.0).looking_at(at.translation, Vec3::Y);
        *app.of_mut::<Transform>(mirror) = at;
        *app.of_mut::<Transform>(camera) = eye;
        app.update();
        assert_reflects(&mut app, (camera, &[eye]), (mirror, &[at]));
    }
}

#[test]
fn a_view_jumps_with_its_camera() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.update();
    for x in [1e4_f32, -1e4, 0.0] {
        let at = Transform::from_xyz(x, 0.0, 0.0);
        let eye = Transform::from_xyz(x, 0.5, 5.0);
        *app.of_mut::<Transform>(mirror) = at;
        *app.of_mut::<Transform>(camera) = eye;
        app.update();
        assert_reflects(&mut app, (camera, &[eye]), (mirror, &[at]));
    }
}

#[test]
fn a_view_follows_parents_that_move_turn_and_scale() {
    let mut app = mirror_app();
    let parent = |app: &mut MirrorApp| app.spawn((Transform::default(), Visibility::default()));
    let (cart, stand) = (parent(&mut app), parent(&mut app));
    let (at, eye) = (
        Transform::from_xyz(0.2, 0.1, 0.0),
        Transform::from_xyz(0.0, 0.0, 5.0),
    );
    let (mirror, camera) = (app.spawn_mirror(at), app.spawn_camera(eye));
    app.insert(mirror, ChildOf(stand));
    app.insert(camera, ChildOf(cart));
    app.update();
    for step in 1..20 {
        let t = step as f32 * 0.03;
        let of_cart = Transform {
            translation: vec3(t, -t, 0.5 * t),
            rotation: Quat::from_rotation_y(0.4 * t),
            scale: vec3(1.0 + t, 1.0 - t, 1.0),
        };
        let of_stand = Transform {
            translation: vec3(-t, t, 0.0),
            rotation: Quat::from_rotation_z(t) * Quat::from_rotation_x(-0.3 * t),
            scale: vec3(1.0, 2.0 + t, 0.5 + t),
        };
        *app.of_mut::<Transform>(cart) = of_cart;
        *app.of_mut::<Transform>(stand) = of_stand;
        app.update();
        assert_reflects(
            &mut app,
            (camera, &[of_cart, eye]),
            (mirror, &[of_stand, at]),
        );
    }
}

#[test]
fn a_view_follows_reparenting() {
    let mut app = mirror_app();
    let lifted = Transform::from_xyz(0.0, 1.0, 0.5).with_scale(Vec3::splat(1.5));
    let parent = app.spawn((lifted, Visibility::default()));
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    let view = {
        app.update();
        app.view(camera, mirror)
    };
    let alone = Transform::default();
    app.insert(mirror, ChildOf(parent));
    app.update();
    assert_reflects(&mut app, (camera, &[EYE]), (mirror, &[lifted, alone]));
    app.insert(camera, ChildOf(parent));
    app.update();
    assert_reflects(
        &mut app,
        (camera, &[lifted, EYE]),
        (mirror, &[lifted, alone]),
    );
    app.remove::<ChildOf>(mirror);
    app.update();
    assert_reflects(&mut app, (camera, &[lifted, EYE]), (mirror, &[alone]));
    app.remove::<ChildOf>(camera);
    app.update();
    assert_reflects(&mut app, (camera, &[EYE]), (mirror, &[alone]));
    assert_eq!(
        app.view(camera, mirror),
        view,
        "it is the same view all along"
    );
}

#[test]
fn a_mirror_carried_by_its_camera_keeps_its_reflection() {
    let mut app = mirror_app();
    let hand = Transform::from_xyz(0.3, -0.2, -2.0).with_rotation(Quat::from_rotation_y(0.2));
    let (mirror, camera) = (app.spawn_mirror(hand), app.spawn_camera(EYE));
    app.insert(mirror, ChildOf(camera));
    for step in 0..8 {
        let eye = Transform::from_xyz(step as f32, 1.0, 5.0)
            .with_rotation(Quat::from_rotation_y(step as f32));
        *app.of_mut::<Transform>(camera) = eye;
        app.update();
        assert_reflects(&mut app, (camera, &[eye]), (mirror, &[eye, hand]));
    }
}

#[test]
fn a_mirror_may_be_scaled_unevenly_flattened_and_turned_inside_out() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    let tilt = Quat::from_rotation_y(0.4);
    for scale in [
        vec3(3.0, 0.5, 1.0),
        vec3(1.0, 1.0, 0.0),
        vec3(-1.0, 1.0, 1.0),
        vec3(0.1, 0.1, 1e3),
        vec3(40.0, 40.0, 1e-3),
    ] {
        let at = Transform::from_rotation(tilt).with_scale(scale);
        *app.of_mut::<Transform>(mirror) = at;
        app.update();
        assert_reflects(&mut app, (camera, &[EYE]), (mirror, &[at]));
    }
}

#[test]
fn a_mirror_and_a_camera_spawned_with_a_parent_are_paired_at_once() {
    let mut app = mirror_app();
    app.update();
    let lifted = Transform::from_xyz(0.0, 3.0, 0.0);
    let parent = app.spawn((lifted, Visibility::default()));
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.insert(mirror, ChildOf(parent));
    app.insert(camera, ChildOf(parent));
    app.update();
    assert_reflects(
        &mut app,
        (camera, &[lifted, EYE]),
        (mirror, &[lifted, default()]),
    );
}
