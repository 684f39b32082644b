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
mod picture;
mod scene;
mod settings;
mod sky;

use std::process::ExitCode;

use bevy::prelude::*;
use bevy_planar_mirror::PlanarMirrorPlugin;

fn main() -> ExitCode {
    let args = match args::Args::parse() {
        Ok(args) => args,
        Err(code) => return code,
    };
    explain_missing_driver();
    if args.wants_pictures() {
        return headless::run(&args);
    }
    if !has_display() {
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

/// This example's build of Bevy opens X11 windows on Linux; Wayland desktops offer that as well.
fn has_display() -> bool {
    !cfg!(target_os = "linux") || std::env::var_os("DISPLAY").is_some_and(|name| !name.is_empty())
}

/// Bevy panics where it finds no graphics device or no window system. One line instead.
fn explain_missing_driver() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        let text = info.payload_as_str().unwrap_or_default();
        if text.contains("Unable to find a GPU") {
            eprintln!(
                "teapot: no graphics driver found. On Linux install a Vulkan driver: \
                 `sh examples/run` does it, or `apt-get install mesa-vulkan-drivers`."
            );
            std::process::exit(1);
        }
        if text.contains("event loop") {
            eprintln!("teapot: no window could be opened ({text}); try --headless.");
            std::process::exit(1);
        }
        usual(info);
    }));
}
