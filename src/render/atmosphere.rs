//! Sunlight dimmed by an `Atmosphere`, in a reflection as in the room.
//!
//! The engine asks for its look-up textures view by view, and makes them for views that draw into a
//! picture. What lit materials read of them, how much light gets through the air above a place, is
//! the same for every view: a reflected view takes its camera's.

use bevy::{
    ecs::prelude::*,
    pbr::{ExtractedAtmosphere, resources::AtmosphereTextures, resources::GpuAtmosphere},
};

use super::extract::ExtractedMirrors;

/// Lets the materials in a reflection know that there is an atmosphere, as far as the camera's
/// textures are there.
pub fn share_atmosphere(
    mut commands: Commands,
    mirrors: Res<ExtractedMirrors>,
    cameras: Query<&ExtractedAtmosphere, With<AtmosphereTextures>>,
    all: Query<(), With<ExtractedAtmosphere>>,
) {
    for mirror in &mirrors.views {
        let mut view = commands.entity(mirror.view);
        match cameras.get(mirror.camera) {
            Ok(atmosphere) => {
                view.insert(atmosphere.clone());
            }
            Err(_) if all.contains(mirror.view) => {
                view.remove::<(ExtractedAtmosphere, AtmosphereTextures)>();
            }
            Err(_) => {}
        }
    }
}

/// The engine writes the one buffer that all materials read only if one camera has an atmosphere.
pub fn leave_atmosphere_to_cameras(
    mut commands: Commands,
    mirrors: Res<ExtractedMirrors>,
    all: Query<(), With<GpuAtmosphere>>,
) {
    for mirror in &mirrors.views {
        if all.contains(mirror.view) {
            commands.entity(mirror.view).remove::<GpuAtmosphere>();
        }
    }
}

/// Gives each reflected view the textures that its camera has by now.
pub fn share_atmosphere_textures(
    mut commands: Commands,
    mirrors: Res<ExtractedMirrors>,
    textures: Query<&AtmosphereTextures>,
    all: Query<(), With<ExtractedAtmosphere>>,
) {
    for mirror in &mirrors.views {
        if let (Ok(textures), true) = (textures.get(mirror.camera), all.contains(mirror.view)) {
            commands.entity(mirror.view).insert(AtmosphereTextures {
                transmittance_lut: textures.transmittance_lut.clone(),
                multiscattering_lut: textures.multiscattering_lut.clone(),
                sky_view_lut: textures.sky_view_lut.clone(),
                aerial_view_lut: textures.aerial_view_lut.clone(),
            });
        }
    }
}
