//! Pictures into files.

use std::{fs, path::Path};

use crate::support::picture::Picture;

/// Writes a picture, and the folder for it.
pub fn write(picture: &Picture, path: &Path) -> Result<(), String> {
    let size = picture.size();
    let bytes: Vec<u8> = picture
        .places()
        .flat_map(|place| picture.at(place.x, place.y))
        .collect();
    write_bytes(&bytes, size.x, size.y, path)
}

/// Rows of RGBA.
pub fn write_bytes(bytes: &[u8], width: u32, height: u32, path: &Path) -> Result<(), String> {
    let told = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(|error| told(&error))?;
    }
    let format = image::ExtendedColorType::Rgba8;
    image::save_buffer(path, bytes, width, height, format).map_err(|error| told(&error))
}
