//! A scene into files, without a window.

use std::process::ExitCode;

use bevy::{camera::RenderTarget, prelude::*};

use crate::{
    args::Args,
    scenes::SceneTime,
    shared::{
        cli,
        headless::{Studio, Target},
    },
};

pub fn run(args: &Args) -> ExitCode {
    cli::tell(draw(args))
}

/// The line that says where the pictures are; or what went wrong, and the exit code.
fn draw(args: &Args) -> Result<String, (String, u8)> {
    let pictures = args.pictures().map_err(|line| (line.to_owned(), 2))?;
    let mut studio = Studio::new(args.size, |app| {
        crate::add_common(app, args);
        app.add_systems(PreUpdate, aim_at_target);
    });
    let drawn = pictures.draw(&mut studio, args.time, |app, seconds| {
        app.insert_resource(SceneTime(seconds));
    });
    drawn.map_err(|line| (line, 1))
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
