//! The plane of each mirror's mesh, fitted once per mesh asset.

use bevy::{
    asset::{AssetEvent, AssetId, Assets, RenderAssetUsages},
    ecs::prelude::*,
    mesh::{Indices, Mesh, Mesh3d, MeshAccessError, PrimitiveTopology, VertexAttributeValues},
    platform::collections::HashMap,
};

use crate::{
    math::{FitError, PlanarPatch, fit_patch},
    mirror::{MirrorPlane, PlanarMirror},
    status::NotDrawn,
};

/// Mesh -> its flat patch in mesh space, or why it has none. Meshes not loaded yet are absent.
#[derive(Resource, Default)]
pub struct MirrorPatches(pub HashMap<AssetId<Mesh>, Result<PlanarPatch, NotDrawn>>);

/// Fits a plane to the mesh of every mirror that asks for one, when it is first seen or changed.
pub fn fit_mirror_planes(
    mirrors: Query<(&PlanarMirror, &Mesh3d)>,
    meshes: Res<Assets<Mesh>>,
    mut events: MessageReader<AssetEvent<Mesh>>,
    mut patches: ResMut<MirrorPatches>,
) {
    for event in events.read() {
        match event {
            AssetEvent::Modified { id } | AssetEvent::Removed { id } => {
                patches.0.remove(id);
            }
            _ => {}
        }
    }
    for (mirror, mesh) in &mirrors {
        let id = mesh.id();
        if mirror.plane == MirrorPlane::FromMesh
            && !patches.0.contains_key(&id)
            && let Some(mesh) = meshes.get(id)
        {
            patches.0.insert(id, patch_of(mesh));
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
