//! Reasons that lie in the mirror's mesh.

use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, PrimitiveTopology, morph::MeshMorphWeights, skinning::SkinnedMesh},
    prelude::*,
};
use bevy_planar_mirror::{MirrorPlane, NotDrawn, PlanarMirror};

use super::{assert_only, pair};
use crate::ecs::app::{PLAIN, not};

#[test]
fn no_mesh() {
    let (mut app, mirror, camera) = pair();
    app.remove::<Mesh3d>(mirror);
    assert_only(&mut app, mirror, camera, NotDrawn::NoMesh);
}

#[test]
fn mesh_not_in_main_world() {
    // One that the renderer has taken already, and one that it will take.
    let mut taken = Mesh::from(Rectangle::new(2.0, 2.0));
    taken.take_gpu_data().expect("it is there to take");
    let mut to_take = Mesh::from(Rectangle::new(2.0, 2.0));
    to_take.asset_usage = RenderAssetUsages::RENDER_WORLD;
    for mesh in [taken, to_take] {
        let (mut app, mirror, camera) = pair();
        let mesh = app.mesh(mesh);
        app.insert(mirror, Mesh3d(mesh));
        assert_only(&mut app, mirror, camera, NotDrawn::MeshNotInMainWorld);
        // The remedy that its log line names.
        app.insert(
            mirror,
            PlanarMirror {
                plane: MirrorPlane::Local {
                    point: Vec3::ZERO,
                    normal: Vec3::Z,
                },
                ..default()
            },
        );
        app.update();
        app.assert_state(mirror, camera, PLAIN);
    }
}

#[test]
fn mesh_deforms() {
    let (mut app, mirror, camera) = pair();
    app.insert(mirror, SkinnedMesh::default());
    assert_only(&mut app, mirror, camera, NotDrawn::MeshDeforms);
    app.remove::<SkinnedMesh>(mirror);
    app.update();
    app.assert_state(mirror, camera, PLAIN);
    app.insert(mirror, MeshMorphWeights::Value { weights: vec![0.5] });
    assert_only(&mut app, mirror, camera, NotDrawn::MeshDeforms);
}

fn triangles(positions: Vec<[f32; 3]>) -> Mesh {
    let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::all());
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    mesh
}

#[test]
fn mesh_empty() {
    let line = [[0.0; 3], [1.0, 1.0, 0.0], [2.0, 2.0, 0.0]];
    for mesh in [
        Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::all()),
        triangles(Vec::new()),
        triangles(line[..2].to_vec()),
        triangles(line.to_vec()),
        triangles(vec![[1.0, 2.0, 3.0]; 6]),
    ] {
        let (mut app, mirror, camera) = pair();
        let mesh = app.mesh(mesh);
        app.insert(mirror, Mesh3d(mesh));
        assert_only(&mut app, mirror, camera, NotDrawn::MeshEmpty);
    }
}

#[test]
fn mesh_not_flat() {
    for mesh in [
        Mesh::from(Cuboid::default()),
        Mesh::from(Sphere::new(1.0)),
        // A roof with a ridge of a hundredth of its width.
        triangles(vec![
            [-1.0, 0.0, 0.0],
            [0.0, 0.0, 0.02],
            [0.0, 1.0, 0.02],
            [0.0, 0.0, 0.02],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.02],
        ]),
    ] {
        let (mut app, mirror, camera) = pair();
        let mesh = app.mesh(mesh);
        app.insert(mirror, Mesh3d(mesh));
        assert_only(&mut app, mirror, camera, NotDrawn::MeshNotFlat);
    }
}

#[test]
fn mesh_not_readable() {
    let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut lines = Mesh::new(PrimitiveTopology::LineList, RenderAssetUsages::all());
    lines.insert_attribute(Mesh::ATTRIBUTE_POSITION, corners.clone());
    let mut out_of_range = triangles(corners.clone());
    out_of_range.insert_indices(Indices::U32(vec![0, 1, 7]));
    for (what, mesh) in [
        ("lines", lines),
        ("an index that names no vertex", out_of_range),
        (
            "nan",
            triangles(vec![[f32::NAN, 0.0, 0.0], corners[1], corners[2]]),
        ),
        (
            "infinite",
            triangles(vec![[f32::INFINITY, 0.0, 0.0], corners[1], corners[2]]),
        ),
    ] {
        let (mut app, mirror, camera) = pair();
        let mesh = app.mesh(mesh);
        app.insert(mirror, Mesh3d(mesh));
        app.update();
        assert_eq!(
            app.state_of(mirror, camera),
            not(NotDrawn::MeshNotReadable),
            "{what}"
        );
        assert_only(&mut app, mirror, camera, NotDrawn::MeshNotReadable);
    }
}
