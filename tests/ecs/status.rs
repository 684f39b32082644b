//! `MirrorStatus` says what is, and changes only when that does.

use bevy::prelude::*;
use bevy_planar_mirror::{MirrorClip, MirrorStatus, NoMirrors, NotDrawn, PlanarMirror};

use super::app::{EYE, MirrorApp, OBLIQUE, PLAIN, floor, mirror_app_with, not};

/// How often a status was seen as changed.
#[derive(Resource, Default)]
struct Changes(usize);

fn count_changes(changed: Query<(), Changed<MirrorStatus>>, mut changes: ResMut<Changes>) {
    changes.0 += changed.iter().count();
}

fn watched_app() -> MirrorApp {
    mirror_app_with(|app| {
        app.init_resource::<Changes>()
            .add_systems(Last, count_changes);
    })
}

/// The changes within these frames.
fn changes_in(app: &mut MirrorApp, frames: usize) -> usize {
    app.insert_resource(Changes(0));
    app.updates(frames);
    app.world().resource::<Changes>().0
}

#[test]
fn a_status_that_stays_is_not_changed() {
    let mut app = watched_app();
    app.spawn_mirror(default());
    app.spawn_mirror(Transform::from_xyz(50.0, 0.0, 0.0));
    let cameras = [EYE, EYE].map(|eye| app.spawn_camera(eye));
    assert_eq!(changes_in(&mut app, 1), 2, "it is written at once");
    assert_eq!(changes_in(&mut app, 5), 0);
    for step in 0..5 {
        app.of_mut::<Transform>(cameras[0]).translation.x = 0.1 * step as f32;
        assert_eq!(
            changes_in(&mut app, 1),
            0,
            "the view moves, the status does not"
        );
    }
}

#[test]
fn a_status_changes_once_when_something_happens() {
    let mut app = watched_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.spawn_mirror(default());
    app.updates(2);
    app.insert(mirror, Visibility::Hidden);
    assert_eq!(changes_in(&mut app, 3), 1);
    app.insert(mirror, Visibility::Visible);
    assert_eq!(changes_in(&mut app, 3), 1);
    app.of_mut::<PlanarMirror>(mirror).clip = MirrorClip::Oblique;
    assert_eq!(changes_in(&mut app, 3), 1);
    app.assert_state(mirror, camera, OBLIQUE);
    let other = app.spawn_camera(EYE);
    assert_eq!(
        changes_in(&mut app, 3),
        2,
        "both mirrors have a camera more"
    );
    app.despawn(other);
    assert_eq!(changes_in(&mut app, 3), 2);
}

/// Bevy visits cameras in the order of their archetypes, which is nobody's business.
#[test]
fn a_component_more_on_a_camera_changes_no_status() {
    #[derive(Component)]
    struct Unrelated;

    let mut app = watched_app();
    let mirror = app.spawn_mirror(default());
    let near = app.spawn_camera(EYE);
    let behind = app.spawn_camera(Transform::from_xyz(0.0, 0.0, -5.0));
    app.updates(2);
    for camera in [near, behind, near] {
        app.insert(camera, Unrelated);
        assert_eq!(changes_in(&mut app, 2), 0);
        app.remove::<Unrelated>(camera);
        assert_eq!(changes_in(&mut app, 2), 0);
    }
    app.assert_state(mirror, near, PLAIN);
    app.assert_state(mirror, behind, not(NotDrawn::EyeBehind));
}

#[test]
fn a_status_has_one_entry_for_each_active_3d_camera() {
    let mut app = watched_app();
    let mirror = app.spawn_mirror(floor(0.0));
    let cameras = [1.0, 2.0, -3.0].map(|y| app.spawn_camera(Transform::from_xyz(0.0, y, 4.0)));
    let deaf = app.spawn_camera(EYE);
    app.insert(deaf, NoMirrors);
    let inactive = app.spawn_camera(EYE);
    app.of_mut::<Camera>(inactive).is_active = false;
    app.spawn((Camera2d, EYE));
    app.updates(3);
    let status = app.of::<MirrorStatus>(mirror);
    let mut named: Vec<Entity> = status.cameras.iter().map(|status| status.camera).collect();
    named.sort();
    let mut expected = cameras;
    expected.sort();
    assert_eq!(named, expected);
    app.assert_state(mirror, cameras[0], PLAIN);
    app.assert_state(mirror, cameras[2], not(NotDrawn::EyeBehind));
}

#[test]
fn the_last_camera_leaves_an_empty_status() {
    let leave: [fn(&mut MirrorApp, Entity); 5] = [
        |app, camera| app.despawn(camera),
        |app, camera| app.insert(camera, NoMirrors),
        |app, camera| app.of_mut::<Camera>(camera).is_active = false,
        |app, camera| app.remove::<Camera3d>(camera),
        |app, camera| app.remove::<Camera>(camera),
    ];
    for leave in leave {
        let mut app = watched_app();
        let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
        app.updates(2);
        app.assert_state(mirror, camera, PLAIN);
        leave(&mut app, camera);
        assert_eq!(changes_in(&mut app, 3), 1);
        assert_eq!(*app.of::<MirrorStatus>(mirror), MirrorStatus::default());
    }
}

#[test]
fn a_status_written_by_somebody_else_is_put_right() {
    let mut app = watched_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.updates(2);
    app.insert(mirror, MirrorStatus::default());
    app.update();
    app.assert_state(mirror, camera, PLAIN);
}

#[test]
fn a_mirror_without_any_camera_has_an_empty_status() {
    let mut app = watched_app();
    let mirror = app.spawn_mirror(default());
    app.updates(2);
    assert_eq!(*app.of::<MirrorStatus>(mirror), MirrorStatus::default());
    assert!(app.views().is_empty());
}
