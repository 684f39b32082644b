//! Which camera gets a reflected view of which mirror.

use bevy::{camera::visibility::RenderLayers, ecs::entity_disabling::Disabled, prelude::*};
use bevy_planar_mirror::{MirrorStatus, NoMirrors, NotDrawn};

use super::app::{EYE, PLAIN, floor, mirror_app, not};

#[test]
fn a_camera_that_sees_a_mirror_has_one_view_of_it() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.update();
    assert_eq!(app.views(), [app.view(camera, mirror)]);
    app.assert_state(mirror, camera, PLAIN);
    assert!(app.of::<MirrorStatus>(mirror).is_drawn());
}

#[test]
fn every_camera_has_a_view_of_every_mirror_that_it_sees() {
    let mut app = mirror_app();
    let mirrors = [-2.0, 0.0, 2.0].map(|x| app.spawn_mirror(Transform::from_xyz(x, 0.0, 0.1 * x)));
    let cameras = [4.0, 6.0].map(|z| app.spawn_camera(Transform::from_xyz(0.0, 0.0, z)));
    app.updates(3);
    let mut paired = Vec::new();
    for camera in cameras {
        for mirror in mirrors {
            app.assert_state(mirror, camera, PLAIN);
            paired.push(app.view(camera, mirror));
        }
    }
    let mut views = app.views();
    views.sort();
    paired.sort();
    assert_eq!(views, paired, "and no view besides");
    paired.dedup();
    assert_eq!(paired.len(), 6, "and none serves two");
}

#[test]
fn a_mirror_may_be_seen_by_one_camera_and_not_by_another() {
    let mut app = mirror_app();
    let mirror = app.spawn_mirror(default());
    let front = app.spawn_camera(EYE);
    let back = app.spawn_camera(EYE.looking_to(Vec3::Z, Vec3::Y));
    let behind =
        app.spawn_camera(Transform::from_xyz(0.0, 0.0, -5.0).looking_at(Vec3::ZERO, Vec3::Y));
    app.update();
    app.assert_state(mirror, front, PLAIN);
    app.assert_state(mirror, back, not(NotDrawn::OutOfView));
    app.assert_state(mirror, behind, not(NotDrawn::EyeBehind));
    assert_eq!(app.views(), app.views_of(front));
}

#[test]
fn a_camera_may_opt_out() {
    let mut app = mirror_app();
    let mirror = app.spawn_mirror(default());
    let (camera, other) = (app.spawn_camera(EYE), app.spawn_camera(EYE));
    app.insert(camera, NoMirrors);
    app.update();
    assert_eq!(app.views(), app.views_of(other));
    app.assert_state(mirror, camera, None);
    app.remove::<NoMirrors>(camera);
    app.update();
    assert_eq!(app.views_of(camera).len(), 1);
    app.insert(camera, NoMirrors);
    app.update();
    assert_eq!(app.views(), app.views_of(other));
    app.assert_state(mirror, camera, None);
}

#[test]
fn an_inactive_camera_sees_no_mirror_until_it_is_active() {
    let mut app = mirror_app();
    let mirror = app.spawn_mirror(default());
    let (camera, other) = (app.spawn_camera(EYE), app.spawn_camera(EYE));
    for active in [false, true, false] {
        app.of_mut::<Camera>(camera).is_active = active;
        app.update();
        assert_eq!(app.views_of(camera).len(), usize::from(active));
        app.assert_state(mirror, camera, PLAIN.filter(|_| active));
        app.assert_state(mirror, other, PLAIN);
    }
}

#[test]
fn a_2d_camera_sees_no_mirror() {
    let mut app = mirror_app();
    let mirror = app.spawn_mirror(default());
    let target = super::app::target(&mut app, super::app::SIZE);
    let camera = app.spawn((Camera2d, target, EYE));
    app.updates(2);
    assert_eq!(
        app.of::<Camera>(camera).physical_target_size(),
        Some(super::app::SIZE)
    );
    assert!(app.views().is_empty());
    app.assert_state(mirror, camera, None);
}

#[test]
fn a_mirror_is_seen_by_cameras_of_its_layers_only() {
    let mut app = mirror_app();
    let mirror = app.spawn_mirror(default());
    let camera = app.spawn_camera(EYE);
    let cases = [
        (RenderLayers::layer(0), RenderLayers::layer(1), false),
        (RenderLayers::layer(1), RenderLayers::layer(1), true),
        (
            RenderLayers::layer(1),
            RenderLayers::from_layers(&[0, 1]),
            true,
        ),
        (RenderLayers::none(), RenderLayers::layer(1), false),
        (
            RenderLayers::none().with(70),
            RenderLayers::none().with(70),
            true,
        ),
    ];
    for (of_mirror, of_camera, seen) in cases {
        app.insert(mirror, of_mirror);
        app.insert(camera, of_camera);
        app.update();
        assert_eq!(app.views().len(), usize::from(seen));
        let expected = if seen {
            PLAIN
        } else {
            not(NotDrawn::OtherLayers)
        };
        app.assert_state(mirror, camera, expected);
    }
    // Without the component a thing is on layer 0.
    app.remove::<RenderLayers>(mirror);
    app.update();
    app.assert_state(mirror, camera, not(NotDrawn::OtherLayers));
    app.remove::<RenderLayers>(camera);
    app.update();
    app.assert_state(mirror, camera, PLAIN);
}

#[test]
fn a_hidden_mirror_has_no_view_until_it_is_shown() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    for (visibility, shown) in [
        (Visibility::Hidden, false),
        (Visibility::Visible, true),
        (Visibility::Hidden, false),
        (Visibility::Inherited, true),
    ] {
        app.insert(mirror, visibility);
        app.update();
        let expected = if shown { PLAIN } else { not(NotDrawn::Hidden) };
        app.assert_state(mirror, camera, expected);
        assert_eq!(app.views().len(), usize::from(shown), "{visibility:?}");
    }
}

#[test]
fn a_mirror_is_hidden_with_its_ancestors() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    let parent = app.spawn((Transform::default(), Visibility::default()));
    let grandparent = app.spawn((Transform::default(), Visibility::Hidden));
    app.insert(parent, ChildOf(grandparent));
    app.insert(mirror, ChildOf(parent));
    app.update();
    app.assert_state(mirror, camera, not(NotDrawn::Hidden));
    assert!(app.views().is_empty());
    app.insert(grandparent, Visibility::Visible);
    app.update();
    app.assert_state(mirror, camera, PLAIN);
    assert_eq!(app.views().len(), 1);
    app.insert(parent, Visibility::Hidden);
    app.update();
    app.assert_state(mirror, camera, not(NotDrawn::Hidden));
    app.remove::<ChildOf>(mirror);
    app.update();
    app.assert_state(mirror, camera, PLAIN);
}

#[test]
fn a_hidden_camera_still_draws_and_so_do_its_mirrors() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.insert(camera, Visibility::Hidden);
    app.update();
    app.assert_state(mirror, camera, PLAIN);
}

#[test]
fn a_disabled_mirror_or_camera_has_no_views() {
    let mut app = mirror_app();
    let mirrors = [default(), Transform::from_xyz(0.5, 0.0, 0.1)].map(|at| app.spawn_mirror(at));
    let cameras = [EYE, EYE].map(|eye| app.spawn_camera(eye));
    app.update();
    assert_eq!(app.views().len(), 4);
    app.insert(mirrors[0], Disabled);
    app.update();
    assert_eq!(app.views().len(), 2);
    app.insert(cameras[0], Disabled);
    app.update();
    assert_eq!(app.views(), [app.view(cameras[1], mirrors[1])]);
    app.remove::<Disabled>(mirrors[0]);
    app.remove::<Disabled>(cameras[0]);
    app.update();
    assert_eq!(app.views().len(), 4);
}

#[test]
fn a_mirror_comes_into_view_when_the_camera_turns() {
    let mut app = mirror_app();
    let mirror = app.spawn_mirror(floor(0.0));
    let camera = app.spawn_camera(Transform::from_xyz(0.0, 1.0, 3.0));
    for (pitch, seen) in [(1.2_f32, false), (-0.3, true), (1.2, false)] {
        app.of_mut::<Transform>(camera).rotation = Quat::from_rotation_x(pitch);
        app.update();
        assert_eq!(app.views().len(), usize::from(seen));
        let expected = if seen {
            PLAIN
        } else {
            not(NotDrawn::OutOfView)
        };
        app.assert_state(mirror, camera, expected);
    }
}
