//! What of the user's camera changes how its picture looks, kept alike on the reflected view.

use bevy::{
    camera::{
        CompositingSpace, Exposure, Hdr, MainPassResolutionOverride, Projection,
        visibility::RenderLayers,
    },
    core_pipeline::{
        Skybox,
        tonemapping::{DebandDither, Tonemapping},
    },
    ecs::prelude::*,
    light::{AmbientLight, EnvironmentMapLight, ShadowFilteringMethod, cluster::ClusterConfig},
    pbr::{DistanceFog, ScreenSpaceTransmission},
    render::{
        camera::{MipBias, TemporalJitter},
        view::{ColorGrading, Msaa},
    },
};

/// Brings the view's components in line with the camera's, of those that matter to its picture.
///
/// Not copied is what works on the finished picture (bloom, depth of field, sharpening, ...):
/// it sees the reflection as part of the camera's own picture.
pub fn copy_camera_components(world: &mut World, camera: Entity, view: Entity) {
    copy::<AmbientLight>(world, camera, view);
    copy::<ClusterConfig>(world, camera, view);
    copy::<ColorGrading>(world, camera, view);
    copy::<CompositingSpace>(world, camera, view);
    copy::<DebandDither>(world, camera, view);
    copy::<DistanceFog>(world, camera, view);
    copy::<EnvironmentMapLight>(world, camera, view);
    copy::<Exposure>(world, camera, view);
    copy::<Hdr>(world, camera, view);
    // Not `Clone` in the engine.
    copy_by(
        world,
        camera,
        view,
        |resolution: &MainPassResolutionOverride| MainPassResolutionOverride(resolution.0),
    );
    copy::<MipBias>(world, camera, view);
    copy::<Msaa>(world, camera, view);
    copy::<Projection>(world, camera, view);
    copy::<RenderLayers>(world, camera, view);
    copy::<ScreenSpaceTransmission>(world, camera, view);
    copy::<ShadowFilteringMethod>(world, camera, view);
    copy::<Skybox>(world, camera, view);
    copy::<TemporalJitter>(world, camera, view);
    copy::<Tonemapping>(world, camera, view);
}

fn copy<T: Component + Clone>(world: &mut World, camera: Entity, view: Entity) {
    copy_by(world, camera, view, T::clone);
}

/// Copies `T` if it is newer on the camera, removes it if the camera has none.
fn copy_by<T: Component>(world: &mut World, camera: Entity, view: Entity, clone: impl Fn(&T) -> T) {
    let source = world.entity(camera).get_ref::<T>();
    let copied = world.entity(view).get_ref::<T>();
    match (source, copied) {
        (Some(source), Some(copied))
            if !source
                .last_changed()
                .is_newer_than(copied.last_changed(), world.read_change_tick()) => {}
        (Some(source), _) => {
            let value = clone(&source);
            world.entity_mut(view).insert(value);
        }
        (None, Some(_)) => {
            world.entity_mut(view).remove::<T>();
        }
        (None, None) => {}
    }
}
