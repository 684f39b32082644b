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
    ecs::{component::Mutable, prelude::*},
    light::{AmbientLight, EnvironmentMapLight, ShadowFilteringMethod},
    pbr::{DistanceFog, ScreenSpaceTransmission},
    render::{
        camera::{MipBias, TemporalJitter},
        view::{ColorGrading, Msaa},
    },
};

use super::apply::set;

/// Brings the view's components in line with the camera's, of those that matter to its picture.
///
/// Not copied is what works on the finished picture (bloom, depth of field, sharpening, ...):
/// it sees the reflection as part of the camera's own picture. Nor are the light clusters, see
/// [`cluster_reflected_views`](super::cluster_reflected_views).
///
/// A `fresh` view has default components that nobody chose: everything is copied.
pub fn copy_camera_components(world: &mut World, camera: Entity, view: Entity, fresh: bool) {
    let pair = Pair {
        camera,
        view,
        fresh,
    };
    pair.copy::<AmbientLight>(world);
    pair.copy::<ColorGrading>(world);
    pair.copy::<CompositingSpace>(world);
    pair.copy::<DebandDither>(world);
    pair.copy::<DistanceFog>(world);
    pair.copy::<EnvironmentMapLight>(world);
    pair.copy::<Exposure>(world);
    pair.copy::<Hdr>(world);
    // Not `Clone` in the engine.
    pair.copy_by(world, |resolution: &MainPassResolutionOverride| {
        MainPassResolutionOverride(resolution.0)
    });
    pair.copy::<MipBias>(world);
    pair.copy::<Msaa>(world);
    pair.copy::<Projection>(world);
    pair.copy::<RenderLayers>(world);
    pair.copy::<ScreenSpaceTransmission>(world);
    pair.copy::<ShadowFilteringMethod>(world);
    pair.copy::<Skybox>(world);
    pair.copy::<TemporalJitter>(world);
    pair.copy::<Tonemapping>(world);
}

struct Pair {
    camera: Entity,
    view: Entity,
    fresh: bool,
}

impl Pair {
    fn copy<T: Component<Mutability = Mutable> + Clone>(&self, world: &mut World) {
        self.copy_by(world, T::clone);
    }

    /// Copies `T` if it is newer on the camera, removes it if the camera has none.
    fn copy_by<T: Component<Mutability = Mutable>>(
        &self,
        world: &mut World,
        clone: impl Fn(&T) -> T,
    ) {
        let source = world.entity(self.camera).get_ref::<T>();
        let copied = world.entity(self.view).get_ref::<T>();
        match (source, copied) {
            (Some(source), Some(copied))
                if !self.fresh
                    && !source
                        .last_changed()
                        .is_newer_than(copied.last_changed(), world.read_change_tick()) => {}
            (Some(source), _) => {
                let value = clone(&source);
                set(&mut world.entity_mut(self.view), value);
            }
            (None, Some(_)) => {
                world.entity_mut(self.view).remove::<T>();
            }
            (None, None) => {}
        }
    }
}
