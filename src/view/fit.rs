//! Where each mirror lies in the world: the plane fitted to its mesh, once per mesh asset, and carried
//! there when something about the mirror changes.

use bevy::{
    asset::{AssetEvent, AssetId, Assets, RenderAssetUsages},
    camera::primitives::Aabb,
    ecs::{entity_disabling::Disabled, prelude::*},
    mesh::{Indices, Mesh, Mesh3d, MeshAccessError, PrimitiveTopology, VertexAttributeValues},
    platform::collections::HashMap,
    transform::components::GlobalTransform,
};
use glam::DVec3;

use crate::{
    math::{FitError, PlanarPatch, Plane, fit_patch, transform_patch},
    mirror::{MirrorPlane, PlanarMirror},
    status::NotDrawn,
};

/// On every mirror: its plane in the world and, as far as they are known, the corners around it; or
/// why it has none.
#[derive(Component, Clone, Copy, Debug)]
pub struct MirrorPlace(pub Result<(Plane, Option<[DVec3; 4]>), NotDrawn>);

impl Default for MirrorPlace {
    fn default() -> Self {
        Self(Err(NotDrawn::NoMesh))
    }
}

/// Mesh -> its flat patch in mesh space, or why it has none.
pub type Patches = HashMap<AssetId<Mesh>, Result<PlanarPatch, NotDrawn>>;

/// Brings every [`MirrorPlace`] up to date. Most mirrors stand still: for these it is a glance.
pub fn place_mirrors(
    mut mirrors: Query<(
        Ref<PlanarMirror>,
        Ref<GlobalTransform>,
        Option<Ref<Mesh3d>>,
        Option<Ref<Aabb>>,
        &mut MirrorPlace,
    )>,
    meshes: Res<Assets<Mesh>>,
    mut events: MessageReader<AssetEvent<Mesh>>,
    mut without_mesh: RemovedComponents<Mesh3d>,
    mut without_bounds: RemovedComponents<Aabb>,
    // What changed while they were disabled is not seen as a change.
    mut enabled: RemovedComponents<Disabled>,
    mut patches: Local<Patches>,
) {
    let mut all_changed = [
        without_mesh.read().any(|entity| mirrors.contains(entity)),
        without_bounds.read().any(|entity| mirrors.contains(entity)),
        enabled.read().any(|entity| mirrors.contains(entity)),
    ]
    .contains(&true);
    for event in events.read() {
        if let AssetEvent::Modified { id } | AssetEvent::Removed { id } = event {
            patches.remove(id);
            all_changed = true;
        }
    }
    for (mirror, transform, mesh, bounds, mut place) in &mut mirrors {
        let is_changed = all_changed
            // The mesh may have been loaded since.
            || matches!(place.0, Err(NotDrawn::NoMesh))
            || mirror.is_changed()
            || transform.is_changed()
            || mesh.as_ref().is_some_and(|mesh| mesh.is_changed())
            || bounds.as_ref().is_some_and(|bounds| bounds.is_changed());
        if is_changed {
            let mesh = mesh.map(|mesh| mesh.id());
            place.0 = patch_of_mirror(&mirror, mesh, bounds.as_deref(), &meshes, &mut patches)
                .and_then(|patch| {
                    transform_patch(&patch, &transform.affine().as_daffine3())
                        .ok_or(NotDrawn::DegenerateTransform)
                });
        }
    }
}

/// In the mirror's own space.
fn patch_of_mirror(
    mirror: &PlanarMirror,
    mesh: Option<AssetId<Mesh>>,
    bounds: Option<&Aabb>,
    meshes: &Assets<Mesh>,
    patches: &mut Patches,
) -> Result<PlanarPatch, NotDrawn> {
    let id = mesh.ok_or(NotDrawn::NoMesh)?;
    let mesh = meshes.get(id).ok_or(NotDrawn::NoMesh)?;
    match mirror.plane {
        MirrorPlane::FromMesh => *patches.entry(id).or_insert_with(|| patch_of(mesh)),
        MirrorPlane::Local { point, normal } => {
            let bounds = bounds.map(|aabb| (aabb.center.as_dvec3(), aabb.half_extents.as_dvec3()));
            PlanarPatch::from_point_and_normal(point.as_dvec3(), normal.as_dvec3(), bounds)
                .ok_or(NotDrawn::DegenerateTransform)
        }
    }
}

fn patch_of(mesh: &Mesh) -> Result<PlanarPatch, NotDrawn> {
    // It may still be here, for the renderer to take at the next extraction.
    if !mesh.asset_usage.contains(RenderAssetUsages::MAIN_WORLD) {
        return Err(NotDrawn::MeshNotInMainWorld);
    }
    let positions = match mesh.try_attribute(Mesh::ATTRIBUTE_POSITION) {
        Ok(VertexAttributeValues::Float32x3(positions)) => positions,
        Err(MeshAccessError::ExtractedToRenderWorld) => return Err(NotDrawn::MeshNotInMainWorld),
        Err(MeshAccessError::NotFound) => return Err(NotDrawn::MeshEmpty),
        Ok(_) => return Err(NotDrawn::MeshNotReadable),
    };
    let count = positions.len() as u32;
    let corners: Vec<u32> = match mesh.try_indices_option() {
        Ok(Some(Indices::U16(indices))) => indices.iter().map(|&i| u32::from(i)).collect(),
        Ok(Some(Indices::U32(indices))) => indices.clone(),
        Ok(None) => (0..count).collect(),
        Err(_) => return Err(NotDrawn::MeshNotInMainWorld),
    };
    let triangles: Vec<[u32; 3]> = match mesh.primitive_topology() {
        PrimitiveTopology::TriangleList => corners
            .chunks_exact(3)
            .map(|c| [c[0], c[1], c[2]])
            .collect(),
        // Every other triangle of a strip winds the other way.
        PrimitiveTopology::TriangleStrip => corners
            .windows(3)
            .enumerate()
            .map(|(i, c)| {
                if i % 2 == 0 {
                    [c[0], c[1], c[2]]
                } else {
                    [c[1], c[0], c[2]]
                }
            })
            .collect(),
        _ => return Err(NotDrawn::MeshNotReadable),
    };
    fit_patch(positions, triangles.iter().copied()).map_err(|error| match error {
        FitError::Empty => NotDrawn::MeshEmpty,
        FitError::NotFlat { .. } => NotDrawn::MeshNotFlat,
        _ => NotDrawn::MeshNotReadable,
    })
}
