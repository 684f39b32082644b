//! Reasons that lie in where the mirror is seen from, or by whom.

use bevy::{
    camera::{
        RenderTarget,
        visibility::{RenderLayers, VisibilityRange},
    },
    core_pipeline::{prepass::DeferredPrepass, schedule::Core3d},
    ecs::schedule::ScheduleLabel,
    prelude::*,
    render::camera::CameraRenderGraph,
};
use bevy_planar_mirror::{NotDrawn, PlanarMirror};

use super::{assert_blind, assert_only, pair};
use crate::ecs::app::{EYE, PLAIN, floor, logged_mirror_app, not};

#[test]
fn hidden() {
    let (mut app, mirror, camera) = pair();
    app.insert(mirror, Visibility::Hidden);
    assert_only(&mut app, mirror, camera, NotDrawn::Hidden);
}

#[test]
fn other_layers() {
    let (mut app, mirror, camera) = pair();
    app.insert(mirror, RenderLayers::layer(4));
    assert_only(&mut app, mirror, camera, NotDrawn::OtherLayers);
}

#[test]
fn no_target() {
    let (mut app, mirror, camera) = pair();
    // The camera of an app whose window is not there yet, and one that draws nothing.
    let windowless = app.spawn((Camera3d::default(), EYE));
    let empty = app.spawn((
        Camera3d::default(),
        EYE,
        RenderTarget::None { size: UVec2::ZERO },
    ));
    // One for the sake of what it finds visible.
    let blind = app.spawn((
        Camera3d::default(),
        EYE,
        RenderTarget::None {
            size: UVec2::splat(64),
        },
    ));
    app.updates(2);
    app.assert_state(mirror, windowless, not(NotDrawn::NoTarget));
    app.assert_state(mirror, blind, not(NotDrawn::NoTarget));
    app.assert_state(mirror, empty, not(NotDrawn::NoTarget));
    assert_eq!(app.views(), app.views_of(camera));
}

#[test]
fn deferred_camera() {
    let (mut app, mirror, camera) = pair();
    app.insert(camera, DeferredPrepass);
    assert_blind(&mut app, mirror, camera, NotDrawn::DeferredCamera);
    app.remove::<DeferredPrepass>(camera);
    app.update();
    app.assert_state(mirror, camera, PLAIN);
}

#[test]
fn other_render_graph() {
    #[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
    struct Mine;

    let (mut app, mirror, camera) = pair();
    app.insert(camera, CameraRenderGraph::new(Mine));
    assert_blind(&mut app, mirror, camera, NotDrawn::OtherRenderGraph);
    app.insert(camera, CameraRenderGraph::new(Core3d));
    app.update();
    app.assert_state(mirror, camera, PLAIN);
}

#[test]
fn out_of_range() {
    let (mut app, mirror, camera) = pair();
    // The eye is five units away.
    for (range, is_there) in [(0.0..4.9, false), (5.1..9.0, false), (4.9..5.1, true)] {
        app.insert(mirror, VisibilityRange::abrupt(range.start, range.end));
        if is_there {
            app.update();
            app.assert_state(mirror, camera, PLAIN);
        } else {
            assert_only(&mut app, mirror, camera, NotDrawn::OutOfRange);
        }
    }
}

#[test]
fn eye_behind() {
    let (mut app, mirror, camera) = pair();
    for at in [
        Transform::from_rotation(Quat::from_rotation_y(std::f32::consts::PI)),
        Transform::from_xyz(0.0, 0.0, 6.0),
        // The eye is in the plane.
        Transform::from_xyz(0.0, 0.0, 5.0),
        floor(0.0),
    ] {
        *app.of_mut::<Transform>(mirror) = at;
        assert_only(&mut app, mirror, camera, NotDrawn::EyeBehind);
    }
}

#[test]
fn eye_behind_of_an_orthographic_camera_is_where_it_looks() {
    let (mut app, mirror, camera) = pair();
    app.insert(
        camera,
        Projection::from(OrthographicProjection::default_3d()),
    );
    app.of_mut::<Transform>(mirror).scale = Vec3::splat(50.0);
    app.update();
    app.assert_state(mirror, camera, PLAIN);
    app.of_mut::<Transform>(mirror).rotation = Quat::from_rotation_y(std::f32::consts::PI);
    app.update();
    app.assert_state(mirror, camera, not(NotDrawn::EyeBehind));
}

#[test]
fn out_of_view() {
    let (mut app, mirror, camera) = pair();
    for at in [
        Transform::from_xyz(50.0, 0.0, 0.0),
        Transform::from_xyz(0.0, -20.0, 0.0),
        // At the back of the camera, and facing it.
        Transform::from_xyz(0.0, 0.0, 8.0).with_rotation(Quat::from_rotation_y(3.1)),
    ] {
        *app.of_mut::<Transform>(mirror) = at;
        assert_only(&mut app, mirror, camera, NotDrawn::OutOfView);
    }
}

#[test]
fn too_thin() {
    let (mut app, mirror, camera) = pair();
    // A hundred pixels high: a unit at a distance of 5 is 24 pixels.
    for at in [
        floor(-0.02),
        Transform::from_scale(vec3(1.0, 0.01, 1.0)),
        Transform::from_xyz(0.0, 0.0, -1000.0),
    ] {
        *app.of_mut::<Transform>(mirror) = at;
        assert_only(&mut app, mirror, camera, NotDrawn::TooThin);
    }
}

/// As many as a stencil has ids for: the nearest.
#[test]
fn too_many_mirrors() {
    const COUNT: usize = 300;
    let mut app = logged_mirror_app();
    let camera = app.spawn_camera(EYE);
    let mesh = app.mesh(Rectangle::new(2.0, 2.0));
    // Not in the order of their distance.
    let depth = |index: usize| ((index * 77) % COUNT) as f32 * 0.02;
    let mirrors: Vec<Entity> = (0..COUNT)
        .map(|index| {
            let at = Transform::from_xyz(0.0, 0.0, -depth(index));
            app.spawn((Mesh3d(mesh.clone()), at, PlanarMirror::default()))
        })
        .collect();
    app.updates(2);
    for (index, &mirror) in mirrors.iter().enumerate() {
        let drawn = depth(index) < 254.5 * 0.02;
        let expected = if drawn {
            PLAIN
        } else {
            not(NotDrawn::TooManyMirrors)
        };
        assert_eq!(app.state_of(mirror, camera), expected, "mirror {index}");
    }
    assert_eq!(app.views().len(), 255);
    let lines = app.log_lines();
    assert_eq!(lines.len(), 1, "one cause, one line: {lines:?}");

    // Another camera has ids of its own.
    let other = app.spawn_camera(EYE);
    app.update();
    assert_eq!(app.views_of(other).len(), 255);
    app.despawn(other);
    // The next nearest move up.
    for (index, &mirror) in mirrors.iter().enumerate() {
        if depth(index) < 44.5 * 0.02 {
            app.despawn(mirror);
        }
    }
    app.update();
    assert_eq!(app.views().len(), 255);
    for (index, &mirror) in mirrors.iter().enumerate() {
        if depth(index) > 44.5 * 0.02 {
            assert_eq!(app.state_of(mirror, camera), PLAIN, "mirror {index}");
        }
    }
}
