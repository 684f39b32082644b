//! What happens seldom and all at once: revealed mirrors, lights set up anew, a lost device.

use bevy::{
    light::CascadeShadowConfigBuilder,
    prelude::*,
    render::{
        error_handler::{ErrorType, RenderErrorHandler, RenderErrorPolicy},
        render_resource::PollType,
        renderer::RenderDevice,
        settings::RenderCreation,
    },
};
use bevy_planar_mirror::PlanarMirrorPlugin;

use super::changes::{room, sunny_room};
use crate::support::{
    live::{Live, assert_each_seen_at_once, find, named, of},
    props::{BLUE, GREEN, RED, at},
    scene::{Scene, Surface},
    stage::Stage,
    studio::assert_reflects,
};

/// In front of the plane, nearly in it, behind it, and back.
#[test]
fn a_camera_that_passes_through_the_plane_sees_what_is_there() {
    let look = |z: f32| {
        move |world: &mut World| {
            let eye = vec3(0.5, 0.3, z);
            *of::<Transform>(world, "camera") =
                Transform::from_translation(eye).looking_at(vec3(-0.4, 0.0, 0.0), Vec3::Y);
        }
    };
    let places = [1.0, 0.3, 0.01, -0.5, 0.2, 2.0].map(look);
    let places: Vec<_> = places
        .iter()
        .map(|place| place as &dyn Fn(&mut World))
        .collect();
    assert_each_seen_at_once(&room("through-the-plane"), &places);
}

#[test]
fn a_mirror_hidden_for_a_hundred_frames_is_back_in_one() {
    let mut scene = room("revealed");
    scene = scene.object(
        Cuboid::new(6.0, 6.0, 0.1),
        named("screen", BLUE),
        at(0.0, 0.0, 1.6),
    );
    let mut live = Live::new(&scene);
    let hidden = live.settled();
    for _ in 0..100 {
        live.stage.frame();
    }
    hidden.assert_same(&live.next(), "still-hidden");
    let reveal = |world: &mut World| {
        let screen = find(world, "screen");
        world.despawn(screen);
    };
    reveal(live.world());
    let revealed = live.next();
    let mut fresh = Live::new(&scene);
    reveal(fresh.world());
    revealed.assert_same(&fresh.settled(), "revealed");
    assert!(
        revealed
            .difference(&hidden, 8, |_| true)
            .is_ok_and(|seen| seen.beyond > 500)
    );
}

#[test]
fn mirrors_of_wildly_different_sizes_reflect_together() {
    let scene = Scene::new("sizes")
        .eye(vec3(0.3, 0.5, 2.0), vec3(0.0, 0.2, 0.0))
        .mirror(Surface::wall(
            1.0,
            1.0,
            at(0.0, 0.0, -400.0).with_scale(Vec3::splat(600.0)),
        ))
        .mirror(Surface::wall(
            1.0,
            1.0,
            at(-0.3, 0.3, 0.0).with_scale(Vec3::splat(0.5)),
        ))
        .mirror(Surface::wall(
            1.0,
            1.0,
            at(0.29, 0.49, 1.9)
                .with_rotation(Quat::from_rotation_y(0.1))
                .with_scale(Vec3::splat(0.02)),
        ))
        .object(Cuboid::from_length(0.4), RED, at(-0.4, 0.1, 0.6))
        .object(Cuboid::from_length(90.0), GREEN, at(60.0, 80.0, -250.0))
        .object(Sphere::new(0.3).mesh().uv(24, 16), BLUE, at(0.4, 0.4, 3.0));
    assert_reflects(&scene);
}

#[test]
fn cascades_set_up_anew_at_run_time_are_those_of_the_reflection_too() {
    let cascades = |count: usize, first: f32, far: f32| {
        move |world: &mut World| {
            let config = CascadeShadowConfigBuilder {
                num_cascades: count,
                first_cascade_far_bound: first,
                maximum_distance: far,
                ..default()
            };
            let sun = find(world, "sun");
            world.entity_mut(sun).insert(config.build());
            // Seen for sure, whatever the cascades look like.
            let step = 0.1 * count as f32;
            *of::<Transform>(world, "box") = at(-0.6 + step, 0.1, 0.7);
        }
    };
    assert_each_seen_at_once(
        &sunny_room("cascades"),
        &[
            &cascades(4, 2.0, 30.0),
            &cascades(1, 5.0, 12.0),
            &cascades(3, 4.0, 9.0),
        ],
    );
}

/// The engine makes its renderer anew and runs `RenderStartup` again.
#[test]
fn after_a_lost_device_the_mirror_is_back() {
    let scene = sunny_room("lost-device");
    let stage = Stage::new(|app| {
        app.add_plugins(PlanarMirrorPlugin::default())
            .insert_resource(RenderErrorHandler(|error, _, _| match error.ty {
                ErrorType::DeviceLost => {
                    RenderErrorPolicy::Recover(RenderCreation::Automatic(Box::default()))
                }
                _ => RenderErrorPolicy::StopRendering,
            }));
    });
    let mut live = Live::on(stage, &scene);
    let before = live.settled();
    let errors = live.stage.errors_while(|app| {
        let device = app.world().resource::<RenderDevice>().wgpu_device();
        device.destroy();
        // The engine hears of it before it draws the next frame, as it does of a real loss.
        device.poll(PollType::Poll).ok();
        for _ in 0..20 {
            app.update();
        }
    });
    let other: Vec<_> = errors
        .iter()
        .filter(|line| !line.text.contains("DeviceLost"))
        .collect();
    assert!(other.is_empty(), "{other:?}");
    live.settled().assert_same(&before, "lost-device");
}
