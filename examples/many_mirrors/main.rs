//! Many mirrors, to look at: facing each other, side by side in one plane, in two cameras.
//!
//! `cargo run --example many_mirrors` opens a window whose keys are listed in it. Without a
//! display, or with `--headless`, a scene is drawn into a PNG file; `--help` lists the rest. The
//! text says what the plugin draws, and what its pass takes.

mod args;
mod controls;
mod headless;
mod overlay;
mod scenes;
#[path = "../shared/mod.rs"]
#[expect(dead_code, reason = "other examples need more of it")]
mod shared;
#[path = "../error_vs_time/spans.rs"]
#[expect(dead_code, reason = "error_vs_time needs more of it")]
mod spans;

use std::process::ExitCode;

use bevy::{prelude::*, render::diagnostic::RenderDiagnosticsPlugin};
use bevy_planar_mirror::PlanarMirrorPlugin;

use crate::{
    args::Args,
    scenes::{SceneTime, Shown},
    shared::display,
};

fn main() -> ExitCode {
    let args = match Args::parse() {
        Ok(args) => args,
        Err(code) => return code,
    };
    display::explain_missing_driver();
    if args.wants_pictures() {
        return headless::run(&args);
    }
    if !display::has_display() {
        println!("No display (DISPLAY is not set): drawing into a file instead of a window.");
        return headless::run(&args);
    }
    controls::run(&args)
}

/// What the window and the pictures share.
fn add_common(app: &mut App, args: &Args) {
    app.add_plugins((
        PlanarMirrorPlugin {
            max_bounces: args.bounces,
            ..default()
        },
        RenderDiagnosticsPlugin,
        scenes::plugin,
        overlay::plugin,
    ))
    .insert_resource(Shown(args.scene))
    .insert_resource(SceneTime(args.time));
}
