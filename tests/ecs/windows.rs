//! Cameras that draw into windows: each has its own reflections, of the window's size, and none while that has no pixels.
//!
//! There is no display here: the windows are what a display would have made of them, entities and messages.

use bevy::{
    camera::RenderTarget,
    prelude::*,
    window::{PrimaryWindow, WindowRef, WindowResized, WindowResolution, WindowScaleFactorChanged},
};
use bevy_planar_mirror::NotDrawn;

use super::app::{EYE, MirrorApp, PLAIN, SIZE, mirror_app, not};

fn spawn_window(app: &mut MirrorApp) -> Entity {
    app.spawn(Window {
        resolution: WindowResolution::new(SIZE.x, SIZE.y),
        ..default()
    })
}

fn spawn_window_camera(app: &mut MirrorApp, window: WindowRef) -> Entity {
    app.spawn((Camera3d::default(), RenderTarget::Window(window), EYE))
}

/// A window, a camera that draws into it, and a mirror before that.
fn windowed() -> (MirrorApp, Entity, Entity, Entity) {
    let mut app = mirror_app();
    let window = spawn_window(&mut app);
    let camera = spawn_window_camera(&mut app, WindowRef::Entity(window));
    let mirror = app.spawn_mirror(default());
    app.update();
    app.assert_state(mirror, camera, PLAIN);
    (app, window, camera, mirror)
}

fn resize(app: &mut MirrorApp, window: Entity, size: UVec2) {
    let resolution = &mut app.of_mut::<Window>(window).resolution;
    resolution.set_physical_resolution(size.x, size.y);
    let (width, height) = (resolution.width(), resolution.height());
    app.world_mut().write_message(WindowResized {
        window,
        width,
        height,
    });
}

/// The view has the target and the projection that its camera has in this frame.
#[track_caller]
fn assert_size(app: &mut MirrorApp, camera: Entity, mirror: Entity, size: UVec2) {
    app.assert_state(mirror, camera, PLAIN);
    let view = app.view(camera, mirror);
    let RenderTarget::None { size: target } = *app.of::<RenderTarget>(view) else {
        panic!("a view draws into no target of its own");
    };
    assert_eq!(target, size);
    let clip_from_view = app.of::<Camera>(camera).clip_from_view();
    assert_eq!(app.of::<Camera>(view).clip_from_view(), clip_from_view);
    let aspect = clip_from_view.y_axis.y / clip_from_view.x_axis.x;
    assert!((aspect - size.x as f32 / size.y as f32).abs() < 1e-5);
}

#[test]
fn a_window_that_is_resized_has_reflections_of_its_new_size_in_the_same_frame() {
    let (mut app, window, camera, mirror) = windowed();
    for size in [uvec2(640, 100), uvec2(33, 77), SIZE] {
        resize(&mut app, window, size);
        app.update();
        assert_size(&mut app, camera, mirror, size);
    }
}

#[test]
fn a_minimised_window_shows_no_mirror_until_it_is_restored() {
    let (mut app, window, camera, mirror) = windowed();
    for gone in [UVec2::ZERO, uvec2(200, 0), uvec2(0, 100)] {
        resize(&mut app, window, gone);
        for _ in 0..3 {
            app.update();
            app.assert_state(mirror, camera, not(NotDrawn::NoTarget));
            assert!(app.views().is_empty());
        }
        resize(&mut app, window, SIZE);
        app.update();
        assert_size(&mut app, camera, mirror, SIZE);
    }
}

/// A window that is taken to a finer screen keeps its size in the user's units and gets more pixels.
#[test]
fn a_window_on_a_finer_screen_has_finer_reflections() {
    let (mut app, window, camera, mirror) = windowed();
    for scale_factor in [2.0, 1.5, 1.0] {
        let size = (SIZE.as_vec2() * scale_factor).as_uvec2();
        let resolution = &mut app.of_mut::<Window>(window).resolution;
        resolution.set_scale_factor(scale_factor);
        app.world_mut().write_message(WindowScaleFactorChanged {
            window,
            scale_factor: scale_factor.into(),
        });
        resize(&mut app, window, size);
        app.update();
        assert_size(&mut app, camera, mirror, size);
        let logical = app.of::<Camera>(camera).logical_target_size();
        assert_eq!(logical, Some(SIZE.as_vec2()));
    }
}

#[test]
fn each_window_has_reflections_of_its_own() {
    let mut app = mirror_app();
    let mirror = app.spawn_mirror(default());
    let primary = spawn_window(&mut app);
    app.insert(primary, PrimaryWindow);
    let other = spawn_window(&mut app);
    let cameras = [WindowRef::Primary, WindowRef::Entity(other)]
        .map(|window| spawn_window_camera(&mut app, window));
    resize(&mut app, other, uvec2(50, 60));
    app.update();
    assert_size(&mut app, cameras[0], mirror, SIZE);
    assert_size(&mut app, cameras[1], mirror, uvec2(50, 60));
    assert_eq!(app.views().len(), 2);
    // What becomes of one is nothing to the other.
    resize(&mut app, primary, UVec2::ZERO);
    app.update();
    app.assert_state(mirror, cameras[0], not(NotDrawn::NoTarget));
    assert_size(&mut app, cameras[1], mirror, uvec2(50, 60));
    resize(&mut app, primary, SIZE);
    app.despawn(other);
    app.despawn(cameras[1]);
    app.update();
    assert_size(&mut app, cameras[0], mirror, SIZE);
    app.assert_state(mirror, cameras[1], None);
    assert_eq!(app.views().len(), 1);
}
