//! From an image of Bevy's to a PNG file.

use std::{
    fs,
    path::{self, Path, PathBuf},
};

use bevy::{
    prelude::*,
    render::view::screenshot::{Screenshot, ScreenshotCaptured},
};
use image::ImageFormat;

use super::cli::say;

/// Writes a PNG, making its folder where there is none. The error is one line for the user.
pub fn save(image: &Image, path: &Path) -> Result<(), String> {
    let failed = |what: String| format!("{} could not be written: {what}", path.display());
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(|error| failed(error.to_string()))?;
    }
    image
        .clone()
        .try_into_dynamic()
        .map_err(|error| failed(error.to_string()))?
        // Alpha holds no coverage here but leftovers of the blending.
        .to_rgb8()
        .save_with_format(path, ImageFormat::Png)
        .map_err(|error| failed(error.to_string()))
}

/// The path in full, for a line that says where a file is.
pub fn absolute(path: &Path) -> String {
    let full = path::absolute(path);
    full.as_deref().unwrap_or(path).display().to_string()
}

/// Saves what the window shows when P is pressed; hide the text first with Tab.
pub fn save_window(mut commands: Commands, keys: Res<ButtonInput<KeyCode>>) {
    if !keys.just_pressed(KeyCode::KeyP) {
        return;
    }
    let free = (1..)
        .map(|n| PathBuf::from(format!("{}-{n}.png", env!("CARGO_CRATE_NAME"))))
        .find(|path| !path.exists());
    let Some(path) = free else { return };
    commands
        .spawn(Screenshot::primary_window())
        .observe(
            move |event: On<ScreenshotCaptured>| match save(&event.image, &path) {
                Ok(()) => println!("The picture is in {}", absolute(&path)),
                Err(line) => say(&line),
            },
        );
}
