//! Meshes with `NoCpuCulling` in reflected views.
//!
//! The engine keeps them in a list of each view's, to which it adds a mesh in the frame in which it
//! appears. A view that is made later never gets those that were there before, and one of a mirror
//! would get the mirror itself. So the plugin puts them into the list of what the CPU found visible
//! ([`see_reflected_views`](crate::view::see_reflected_views)), and empties the engine's.

use core::any::TypeId;

use bevy::{
    ecs::prelude::*,
    mesh::Mesh3d,
    render::{sync_world::MainEntity, view::RenderVisibleEntities},
};

use super::extract::ExtractedMirrors;

/// Leaves each reflected view what the CPU has listed for it.
pub fn list_on_cpu_alone(
    mirrors: Res<ExtractedMirrors>,
    mut visible: Query<&mut RenderVisibleEntities>,
) {
    for mirror in &mirrors.views {
        let Ok(mut visible) = visible.get_mut(mirror.view) else {
            continue;
        };
        let Some(meshes) = visible.classes.get_mut(&TypeId::of::<Mesh3d>()) else {
            continue;
        };
        if meshes.entities_gpu_culling.is_empty() {
            continue;
        }
        meshes.entities_gpu_culling.clear();
        let listed = &meshes.entities_cpu_culling;
        let is_listed = |main: MainEntity| {
            let found = listed.binary_search_by_key(&main, |(_, listed)| *listed);
            found.is_ok()
        };
        meshes.added_entities.retain(|(_, main)| is_listed(*main));
        meshes
            .added_entities
            .sort_unstable_by_key(|(_, main)| *main);
        meshes.added_entities.dedup_by_key(|(_, main)| *main);
    }
}
