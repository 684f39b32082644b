//! The Utah teapot jumps through a marble table that is a mirror.
//!
//! `cargo run --example teapot` opens a window whose keys are listed in it. Without a display, or
//! with `--headless`, the scene is drawn into a PNG file, and with `--frames` into many;
//! `--help` lists the rest.

mod args;
mod bezier;
mod controls;
mod headless;
mod marble;
mod overlay;
mod scene;
mod settings;
#[path = "../shared/mod.rs"]
#[allow(dead_code, reason = "other examples and the tests need more of it")]
mod shared;
mod sky;

use std::process::ExitCode;

use bevy::prelude::*;
use bevy_planar_mirror::PlanarMirrorPlugin;

use crate::shared::display;

fn main() -> ExitCode {
    let args = match args::Args::parse() {
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
fn common_plugin(app: &mut App) {
    app.add_plugins((
        PlanarMirrorPlugin::default(),
        settings::plugin,
        scene::plugin,
    ));
}
