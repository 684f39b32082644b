//! The window and its keys.

use std::process::ExitCode;

use bevy::{
    camera_controller::free_camera::{FreeCamera, FreeCameraPlugin},
    prelude::*,
    window::WindowResolution,
};

use crate::{
    args::Args,
    scenes::{MainCamera, Place, SceneTime, Shown},
    shared::picture,
};

pub fn run(args: &Args) -> ExitCode {
    let (width, height) = args.size;
    let mut app = App::new();
    app.add_plugins((
        DefaultPlugins.set(WindowPlugin {
            primary_window: Some(Window {
                title: "Many mirrors".into(),
                resolution: WindowResolution::new(width, height),
                ..default()
            }),
            ..default()
        }),
        FreeCameraPlugin,
    ))
    .add_systems(
        Update,
        (
            run_clock,
            switch_scene,
            let_camera_fly,
            picture::save_window,
        ),
    );
    crate::add_common(&mut app, args);
    match app.run() {
        AppExit::Success => ExitCode::SUCCESS,
        AppExit::Error(code) => ExitCode::from(code.get()),
    }
}

fn run_clock(
    time: Res<Time>,
    keys: Res<ButtonInput<KeyCode>>,
    mut scene: ResMut<SceneTime>,
    mut rests: Local<bool>,
) {
    *rests ^= keys.just_pressed(KeyCode::Space);
    if !*rests {
        scene.0 += time.delta_secs();
    }
}

fn switch_scene(keys: Res<ButtonInput<KeyCode>>, mut shown: ResMut<Shown>) {
    let keys = Place::ALL.map(|place| (place, keys.just_pressed(place.key())));
    if let Some((place, _)) = keys.into_iter().find(|(_, pressed)| *pressed) {
        shown.0 = place;
    }
}

fn let_camera_fly(mut commands: Commands, cameras: Query<Entity, Added<MainCamera>>) {
    for camera in &cameras {
        commands.entity(camera).insert(FreeCamera {
            walk_speed: 2.0,
            run_speed: 6.0,
            ..default()
        });
    }
}
