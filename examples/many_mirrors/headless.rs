//! A scene into files, without a window.

use std::process::ExitCode;

use bevy::{camera::RenderTarget, prelude::*};

use crate::{
    args::Args,
    scenes::SceneTime,
    shared::{
        cli::say,
        headless::{Studio, Target},
    },
};

pub fn run(args: &Args) -> ExitCode {
    match draw(args) {
        Ok(line) => {
            println!("{line}");
            ExitCode::SUCCESS
        }
        Err(line) => {
            say(&line);
            ExitCode::FAILURE
        }
    }
}

/// The line that says where the pictures are; or what went wrong.
fn draw(args: &Args) -> Result<String, String> {
    let pictures = args.pictures()?;
    let mut studio = Studio::new(args.size, |app| {
        crate::add_common(app, args);
        app.add_systems(PreUpdate, aim_at_target);
    });
    pictures.draw(&mut studio, args.time, |app, seconds| {
        app.insert_resource(SceneTime(seconds));
    })
}

fn aim_at_target(
    mut commands: Commands,
    target: Res<Target>,
    cameras: Query<Entity, Added<Camera>>,
) {
    for camera in &cameras {
        commands
            .entity(camera)
            .insert(RenderTarget::Image(target.0.clone().into()));
    }
}
