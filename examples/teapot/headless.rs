//! The scene into files, without a window.

use std::process::ExitCode;

use bevy::{camera::RenderTarget, prelude::*, render::renderer::RenderAdapter};

use crate::{
    args::Args,
    scene::SceneTime,
    settings,
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
        app.insert_resource(args.settings())
            .add_plugins(crate::common_plugin)
            .add_systems(PostStartup, aim_at_target);
    });
    let offered = settings::supported_samples(studio.app.world().resource::<RenderAdapter>());
    let samples = args.settings().samples;
    if !offered.contains(&samples) {
        return Err((
            format!("--msaa: this device has {offered:?}, not {samples}"),
            2,
        ));
    }
    let drawn = pictures.draw(&mut studio, args.time, |app, seconds| {
        app.insert_resource(SceneTime {
            jump: seconds,
            light: seconds,
        });
    });
    drawn.map_err(|line| (line, 1))
}

fn aim_at_target(
    mut commands: Commands,
    target: Res<Target>,
    camera: Single<Entity, With<Camera3d>>,
) {
    commands
        .entity(*camera)
        .insert(RenderTarget::Image(target.0.clone().into()));
}
