//! One line in the log for what only the user can mend, and not one for each frame.

use bevy::{
    core_pipeline::prepass::DeferredPrepass, ecs::entity_disabling::Disabled, log::Level,
    prelude::*,
};
use bevy_planar_mirror::{NotDrawn, PlanarMirror};

use super::app::{EYE, MirrorApp, PLAIN, logged_mirror_app, not};

/// Since the last call each of these was warned of in one line that names it, and nothing else was.
#[track_caller]
fn assert_lines(app: &mut MirrorApp, expected: &[(Entity, NotDrawn)]) {
    let lines = app.log_lines();
    assert_eq!(lines.len(), expected.len(), "{lines:#?}");
    for (entity, reason) in expected {
        let (name, reason) = (format!("{entity}: "), reason.to_string());
        let found = lines.iter().any(|line| {
            line.level == Level::WARN && line.text.starts_with(&name) && line.text.contains(&reason)
        });
        assert!(found, "no line says {name}{reason}: {lines:#?}");
    }
}

#[test]
fn a_mirror_that_is_drawn_or_merely_out_of_sight_logs_nothing() {
    let mut app = logged_mirror_app();
    app.spawn_camera(EYE);
    app.spawn_mirror(default());
    app.spawn_mirror(Transform::from_xyz(50.0, 0.0, 0.0));
    app.spawn_mirror(Transform::from_xyz(0.0, 0.0, 9.0));
    let hidden = app.spawn_mirror(default());
    app.insert(hidden, Visibility::Hidden);
    let late = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let unloaded = app.spawn_mirror(default());
    app.insert(unloaded, Mesh3d(late));
    app.updates(5);
    assert_lines(&mut app, &[]);
}

#[test]
fn each_broken_mirror_logs_one_line_that_names_it() {
    let mut app = logged_mirror_app();
    let bent = app.spawn_mirror(default());
    let cube = app.mesh(Cuboid::default());
    app.insert(bent, Mesh3d(cube));
    let flat = app.spawn_mirror(Transform::from_scale(Vec3::ZERO));
    // Two cameras see it, and still it is one thing to mend.
    app.spawn_camera(EYE);
    app.spawn_camera(EYE);
    app.updates(10);
    let expected = [
        (bent, NotDrawn::MeshNotFlat),
        (flat, NotDrawn::DegenerateTransform),
    ];
    assert_lines(&mut app, &expected);
}

#[test]
fn a_mirror_that_breaks_again_and_again_logs_one_line() {
    let mut app = logged_mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    for frame in 0..10 {
        let broken = frame % 2 == 1;
        app.of_mut::<Transform>(mirror).scale = Vec3::splat(if broken { f32::NAN } else { 1.0 });
        app.update();
        let reason = not(NotDrawn::DegenerateTransform);
        app.assert_state(mirror, camera, if broken { reason } else { PLAIN });
    }
    assert_lines(&mut app, &[(mirror, NotDrawn::DegenerateTransform)]);
    // Another thing to mend is another line.
    let cube = app.mesh(Cuboid::default());
    app.of_mut::<Transform>(mirror).scale = Vec3::ONE;
    app.insert(mirror, Mesh3d(cube));
    app.updates(3);
    assert_lines(&mut app, &[(mirror, NotDrawn::MeshNotFlat)]);
}

/// What lies with a camera is one thing to mend, however many mirrors there are.
#[test]
fn each_camera_that_cannot_show_mirrors_logs_one_line_that_names_it() {
    let mut app = logged_mirror_app();
    for x in [-1.0, 0.0, 1.0] {
        app.spawn_mirror(Transform::from_xyz(x, 0.0, 0.1 * x));
    }
    app.spawn_camera(EYE);
    let deferred = app.spawn_camera(EYE);
    app.insert(deferred, DeferredPrepass);
    let squashed = app.spawn_camera(EYE.with_scale(vec3(1.0, 0.0, 1.0)));
    app.updates(5);
    let expected = [
        (deferred, NotDrawn::DeferredCamera),
        (squashed, NotDrawn::DegenerateCamera),
    ];
    assert_lines(&mut app, &expected);
}

/// What was said of a mirror or a camera is remembered while it is one, and no longer.
#[test]
fn what_is_made_a_mirror_or_a_camera_anew_is_warned_of_anew() {
    let mut app = logged_mirror_app();
    app.spawn_mirror(default());
    app.spawn_camera(EYE);
    let mirror = app.spawn_mirror(Transform::from_scale(Vec3::ZERO));
    let camera = app.spawn_camera(EYE);
    app.insert(camera, DeferredPrepass);
    let expected = [
        (mirror, NotDrawn::DegenerateTransform),
        (camera, NotDrawn::DeferredCamera),
    ];
    app.updates(3);
    assert_lines(&mut app, &expected);
    // Disabled they are what they were. The other camera is there to have the mirror looked at again.
    app.insert(mirror, Disabled);
    app.insert(camera, Disabled);
    app.updates(3);
    app.spawn_camera(EYE);
    app.remove::<Disabled>(mirror);
    app.remove::<Disabled>(camera);
    app.updates(3);
    assert_lines(&mut app, &[]);
    app.remove::<PlanarMirror>(mirror);
    app.remove::<Camera3d>(camera);
    app.updates(3);
    app.insert(mirror, PlanarMirror::default());
    app.insert(camera, Camera3d::default());
    app.updates(3);
    assert_lines(&mut app, &expected);
}
