//! One line in the log for what only the user can mend, and not one for each frame.

use bevy::{core_pipeline::prepass::DeferredPrepass, log::Level, prelude::*};
use bevy_planar_mirror::NotDrawn;

use super::app::{EYE, MirrorApp, PLAIN, logged_mirror_app, not};

#[track_caller]
fn assert_lines(app: &mut MirrorApp, expected: &[&[&str]]) {
    let lines = app.log_lines();
    assert_eq!(lines.len(), expected.len(), "{lines:#?}");
    assert!(
        lines.iter().all(|line| line.level == Level::WARN),
        "{lines:#?}"
    );
    for words in expected {
        let found = lines
            .iter()
            .any(|line| words.iter().all(|word| line.text.contains(word)));
        assert!(found, "no line says {words:?}: {lines:#?}");
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
        [bent.to_string(), NotDrawn::MeshNotFlat.to_string()],
        [flat.to_string(), NotDrawn::DegenerateTransform.to_string()],
    ];
    let expected = expected
        .each_ref()
        .map(|words| words.each_ref().map(|word| &**word));
    assert_lines(&mut app, &[&expected[0], &expected[1]]);
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
    let name = mirror.to_string();
    assert_lines(&mut app, &[&[&name]]);
    // Another thing to mend is another line.
    let cube = app.mesh(Cuboid::default());
    app.of_mut::<Transform>(mirror).scale = Vec3::ONE;
    app.insert(mirror, Mesh3d(cube));
    app.updates(3);
    assert_lines(&mut app, &[&[&name, &NotDrawn::MeshNotFlat.to_string()]]);
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
        [deferred.to_string(), NotDrawn::DeferredCamera.to_string()],
        [squashed.to_string(), NotDrawn::DegenerateCamera.to_string()],
    ];
    let expected = expected
        .each_ref()
        .map(|words| words.each_ref().map(|word| &**word));
    assert_lines(&mut app, &[&expected[0], &expected[1]]);
}
