//! The only cluster of a reflected view that few lamps reach, in the engine's buffers.

use bevy::{
    ecs::prelude::*,
    pbr::{ExtractedClusterConfig, GlobalClusterableObjectMeta, ViewClusterBindings},
    render::{
        render_resource::{BindingResource, BufferBindingType},
        renderer::{RenderDevice, RenderQueue},
    },
};

use super::extract::ExtractedMirrors;

/// The lamps in the buffers of a view, by their indices among all lamps, points before spots.
#[derive(Component)]
pub struct ListedLamps {
    lamps: Vec<usize>,
    point_count: usize,
}

/// Fills the cluster of each view that lists its lamps, if they are others than before, and keeps
/// the engine from sorting them once more.
pub fn list_lamps(
    mut commands: Commands,
    mirrors: Res<ExtractedMirrors>,
    lamps: Res<GlobalClusterableObjectMeta>,
    listed: Query<&ListedLamps>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
) {
    for mirror in &mirrors.views {
        let last = listed.get(mirror.view).ok();
        let Some(range) = mirror.lamps.clone() else {
            if last.is_some() {
                commands.entity(mirror.view).remove::<ListedLamps>();
            }
            continue;
        };
        let mut view = commands.entity(mirror.view);
        view.remove::<ExtractedClusterConfig>();
        // Those that the engine leaves out light nothing.
        let lamps = mirrors.lamps[range]
            .iter()
            .filter_map(|lamp| Some((*lamps.entity_to_index.get(&lamp.light)?, lamp.is_spot)));
        let point_count = lamps.clone().filter(|(_, is_spot)| !is_spot).count();
        let lamps = lamps.map(|(index, _)| index);
        if last.is_some_and(|last| {
            last.point_count == point_count && lamps.clone().eq(last.lamps.iter().copied())
        }) {
            continue;
        }
        let list = ListedLamps {
            lamps: lamps.collect(),
            point_count,
        };
        view.insert((list.bindings(&device, &queue), list));
    }
}

impl ListedLamps {
    fn bindings(&self, device: &RenderDevice, queue: &RenderQueue) -> ViewClusterBindings {
        let mut bindings = ViewClusterBindings::new(BufferBindingType::Storage { read_only: true });
        bindings.reserve_clusters(1);
        for lamp in &self.lamps {
            bindings.push_index(*lamp);
        }
        if self.lamps.is_empty() {
            // A buffer cannot be empty.
            bindings.push_dummy_index();
        }
        bindings.write_buffers(device, queue);
        // How many there are can only be written past the engine: offset, points, spots, reflection
        // probes; irradiance volumes, decals, nothing, nothing.
        if let Some(BindingResource::Buffer(cluster)) = bindings.offsets_and_counts_binding() {
            let spot_count = self.lamps.len() - self.point_count;
            let counts = [0, self.point_count as u32, spot_count as u32, 0, 0, 0, 0, 0];
            let bytes: Vec<u8> = counts.into_iter().flat_map(u32::to_le_bytes).collect();
            queue.write_buffer(cluster.buffer, cluster.offset, &bytes);
        }
        bindings
    }
}

/// After a lost device its buffers are no buffers any more.
pub fn forget_lamps(mut commands: Commands, listed: Query<Entity, With<ListedLamps>>) {
    for view in &listed {
        commands
            .entity(view)
            .remove::<(ListedLamps, ViewClusterBindings)>();
    }
}
