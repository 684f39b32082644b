//! Mirrors in one plane share a view; mirrors in mirrors have their own.

use bevy::prelude::*;
use bevy_planar_mirror::{MirrorClip, NotDrawn, PlanarMirror, PlanarMirrorPlugin};

use super::app::{EYE, MirrorApp, OBLIQUE, PLAIN, mirror_app, mirror_app_of, not};

/// Five by ten tiles of a wall before the camera.
fn tiles() -> impl Iterator<Item = Transform> {
    (0..50).map(|i| {
        Transform::from_xyz(
            0.4 * ((i % 10) as f32 - 4.5),
            0.2 * ((i / 10) as f32 - 2.0),
            0.0,
        )
        .with_scale(Vec3::splat(0.1))
    })
}

#[test]
fn tiles_of_one_plane_have_one_view() {
    let mut app = mirror_app();
    let camera = app.spawn_camera(EYE);
    let tiles: Vec<Entity> = tiles().map(|place| app.spawn_mirror(place)).collect();
    app.updates(2);
    assert_eq!(app.views().len(), 1);
    for tile in &tiles {
        app.assert_state(*tile, camera, PLAIN);
    }
    // What crosses the plane anywhere is cut in all of it.
    app.spawn_cube(0.5, Vec3::ZERO);
    app.updates(1);
    for tile in &tiles {
        app.assert_state(*tile, camera, OBLIQUE);
    }
}

#[test]
fn a_shared_view_outlives_each_of_its_mirrors() {
    let mut app = mirror_app();
    app.spawn_camera(EYE);
    let tiles: Vec<Entity> = tiles().map(|place| app.spawn_mirror(place)).collect();
    app.updates(1);
    let views = app.views();
    for tile in &tiles[..49] {
        app.despawn(*tile);
        app.updates(1);
        assert_eq!(app.views(), views);
    }
    app.despawn(tiles[49]);
    app.updates(1);
    assert!(app.views().is_empty());
}

#[test]
fn a_mirror_that_leaves_the_plane_has_a_view_of_its_own() {
    let mut app = mirror_app();
    app.spawn_camera(EYE);
    let tiles: Vec<Entity> = tiles().map(|place| app.spawn_mirror(place)).collect();
    app.updates(1);
    app.of_mut::<Transform>(tiles[7]).translation.z = 0.1;
    app.updates(1);
    assert_eq!(app.views().len(), 2);
    app.of_mut::<Transform>(tiles[7]).translation.z = 0.0;
    app.updates(1);
    assert_eq!(app.views().len(), 1);
}

#[test]
fn mirrors_that_are_cut_otherwise_do_not_share() {
    let mut app = mirror_app();
    app.spawn_camera(EYE);
    let tiles: Vec<Entity> = tiles().map(|place| app.spawn_mirror(place)).collect();
    app.of_mut::<PlanarMirror>(tiles[0]).clip = MirrorClip::Whole;
    app.updates(1);
    assert_eq!(app.views().len(), 2);
}

/// The camera stands between two mirrors and sees one of them.
fn facing(max_bounces: u8) -> (MirrorApp, [Entity; 3]) {
    let mut app = mirror_app_of(PlanarMirrorPlugin {
        max_bounces,
        ..default()
    });
    let camera = app.spawn_camera(EYE);
    let before = app.spawn_mirror(Transform::from_scale(Vec3::splat(4.0)));
    let behind = app.spawn_mirror(
        Transform::from_xyz(0.3, 0.2, 8.0)
            .with_rotation(Quat::from_rotation_y(3.1))
            .with_scale(Vec3::splat(4.0)),
    );
    app.updates(2);
    (app, [camera, before, behind])
}

#[test]
fn each_bounce_between_facing_mirrors_has_a_view() {
    for max_bounces in [0, 1, 2, 5] {
        let (mut app, [camera, before, behind]) = facing(max_bounces);
        assert_eq!(app.views().len(), usize::from(max_bounces));
        let seen = if max_bounces == 0 {
            not(NotDrawn::TooManyMirrors)
        } else {
            PLAIN
        };
        app.assert_state(before, camera, seen);
        app.assert_state(behind, camera, not(NotDrawn::OutOfView));
        app.despawn(behind);
        app.updates(1);
        assert_eq!(app.views().len(), usize::from(max_bounces.min(1)));
    }
}

#[test]
fn bounces_end_when_nothing_is_left_to_see() {
    let (mut app, _) = facing(255);
    let views = app.views().len();
    assert!((3..255).contains(&views), "{views} views");
}

#[test]
fn of_too_many_views_the_largest_are_drawn() {
    let mut app = mirror_app_of(PlanarMirrorPlugin {
        max_views: 2,
        ..default()
    });
    let camera = app.spawn_camera(EYE);
    let mirrors = [0.4, 1.0, 0.2, 0.8].map(|size| {
        let place = Transform::from_xyz(4.0 * (size - 0.6), 0.0, -0.1 * size);
        app.spawn_mirror(place.with_scale(Vec3::splat(size)))
    });
    app.updates(2);
    let expected = [
        not(NotDrawn::TooManyMirrors),
        PLAIN,
        not(NotDrawn::TooManyMirrors),
        PLAIN,
    ];
    for (mirror, expected) in mirrors.into_iter().zip(expected) {
        app.assert_state(mirror, camera, expected);
    }
    assert_eq!(app.views().len(), 2);
}
