//! The window and its keys.

use std::process::ExitCode;

use crate::{
    args::Args,
    bezier::MAX_TESSELLATION,
    overlay,
    scene::{SceneTime, camera_pose},
    settings::{Settings, supported_samples},
    shared::picture,
};
use bevy::{
    camera_controller::free_camera::{FreeCamera, FreeCameraPlugin, FreeCameraState},
    prelude::*,
    render::renderer::{RenderAdapter, RenderAdapterInfo},
    window::WindowResolution,
};

/// What runs, what rests.
#[derive(Resource, Default)]
pub struct Paused {
    pub jump: bool,
    pub light: bool,
}

pub fn run(args: &Args) -> ExitCode {
    let (width, height) = args.size;
    let mut app = App::new();
    app.add_plugins((
        DefaultPlugins.set(WindowPlugin {
            primary_window: Some(Window {
                title: "The teapot and the mirror".into(),
                resolution: WindowResolution::new(width, height),
                ..default()
            }),
            ..default()
        }),
        FreeCameraPlugin,
        overlay::plugin,
        crate::common_plugin,
    ))
    .insert_resource(args.settings())
    .insert_resource(SceneTime {
        jump: args.time,
        light: args.time,
    })
    .init_resource::<Paused>()
    .add_systems(PostStartup, add_free_camera)
    .add_systems(
        Update,
        (
            run_clocks,
            switch_settings,
            switch_free_camera,
            picture::save_window,
        ),
    );
    let wanted = args.msaa;
    app.add_systems(
        Startup,
        move |adapter: Res<RenderAdapter>,
              info: Res<RenderAdapterInfo>,
              mut settings: ResMut<Settings>| {
            settings.samples = choose_samples(wanted, &supported_samples(&adapter), &info);
        },
    );
    match app.run() {
        AppExit::Success => ExitCode::SUCCESS,
        AppExit::Error(code) => ExitCode::from(code.get()),
    }
}

/// As many samples as are wanted, or the next fewer that the device has.
///
/// Where the processor draws, samples cost most of the time: it starts without.
fn choose_samples(wanted: Option<u32>, offered: &[u32], info: &RenderAdapterInfo) -> u32 {
    // The engine passes the value on, but not the type to compare it with.
    let in_software = format!("{:?}", info.device_type) == "Cpu";
    let wanted = wanted.unwrap_or(if in_software { 1 } else { 4 });
    let chosen = offered.iter().copied().filter(|&samples| samples <= wanted);
    chosen.max().unwrap_or(1)
}

fn run_clocks(time: Res<Time>, paused: Res<Paused>, mut scene: ResMut<SceneTime>) {
    if !paused.jump {
        scene.jump += time.delta_secs();
    }
    if !paused.light {
        scene.light += time.delta_secs();
    }
}

fn switch_settings(
    keys: Res<ButtonInput<KeyCode>>,
    adapter: Res<RenderAdapter>,
    mut paused: ResMut<Paused>,
    mut settings: ResMut<Settings>,
) {
    let mut new = settings.clone();
    for key in keys.get_just_pressed() {
        match key {
            KeyCode::KeyJ => paused.jump ^= true,
            KeyCode::KeyL => paused.light ^= true,
            KeyCode::KeyR => new.mirror ^= true,
            KeyCode::KeyC => new.clip ^= true,
            KeyCode::ArrowUp => new.alpha = ((new.alpha * 10.0).round() / 10.0 + 0.1).min(1.0),
            KeyCode::ArrowDown => new.alpha = ((new.alpha * 10.0).round() / 10.0 - 0.1).max(0.0),
            KeyCode::ArrowRight => new.tessellation = (new.tessellation * 2).min(MAX_TESSELLATION),
            KeyCode::ArrowLeft => new.tessellation = (new.tessellation / 2).max(1),
            KeyCode::KeyB => new.soft_shadows ^= true,
            KeyCode::KeyH => new.hdr ^= true,
            KeyCode::KeyM => {
                let offered = supported_samples(&adapter);
                let next = offered.iter().find(|&&samples| samples > new.samples);
                new.samples = *next.unwrap_or(&1);
            }
            _ => {}
        }
    }
    settings.set_if_neq(new);
}

fn add_free_camera(mut commands: Commands, camera: Single<Entity, With<Camera3d>>) {
    let mut state = FreeCameraState::default();
    state.enabled = false;
    let controller = FreeCamera {
        keyboard_key_toggle_cursor_grab: KeyCode::KeyG,
        walk_speed: 2.0,
        run_speed: 6.0,
        ..default()
    };
    commands.entity(*camera).insert((controller, state));
}

fn switch_free_camera(
    keys: Res<ButtonInput<KeyCode>>,
    camera: Single<(&mut Transform, &mut FreeCameraState)>,
) {
    if keys.just_pressed(KeyCode::KeyF) {
        let (mut pose, mut state) = camera.into_inner();
        state.enabled ^= true;
        if !state.enabled {
            *pose = camera_pose();
            (state.yaw, state.pitch, state.velocity) = (0.0, 0.0, Vec3::ZERO);
        }
    }
}
