//! From an image of Bevy's to a PNG file.

use std::{
    fs,
    path::{self, Path},
};

use bevy::prelude::*;
use image::ImageFormat;

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
