//! A mirror as an opening: the reflected world built as real things behind a hole, for whole pictures without one line of
//! the plugin in them. What works on the finished picture must do the same to both.

use bevy::{
    math::{DAffine3, DVec3},
    mesh::{Indices, VertexAttributeValues},
    prelude::*,
};

use super::{
    cut::{Cut, Plane, cut},
    scene::{Object, Scene, exact},
};

/// The scene in which the one mirror is a hole, and what shows in it stands behind.
///
/// Equal to the picture of the scene pixel by pixel if its materials are unlit, nothing but the mirror
/// shows where the reflected things would, and the mirror's edge is hidden by something before it.
pub fn opened(scene: &Scene) -> Scene {
    let [mirror] = &scene.mirrors[..] else {
        panic!("{}: one mirror, one hole", scene.name);
    };
    let plane = mirror.plane();
    let mut opened = scene.clone();
    opened.name = format!("{}-opened", scene.name);
    opened.mirrors.clear();
    opened.objects.clear();
    for object in &scene.objects {
        let world_from_local = exact(&object.transform);
        let mesh = match cut(&object.mesh, world_from_local, plane) {
            Cut::Nothing => continue,
            Cut::Whole => object.mesh.clone(),
            Cut::Part(part) => *part,
        };
        opened.objects.push(Object {
            mesh: reflected(&mesh, world_from_local, plane),
            transform: Transform::default(),
            look: object.look.clone(),
        });
        opened.objects.push(Object {
            mesh,
            ..object.clone()
        });
    }
    opened
}

/// The mirror image of a mesh, in the world, with its front where its front is.
fn reflected(mesh: &Mesh, world_from_local: DAffine3, plane: Plane) -> Mesh {
    let mut mesh = mesh.clone();
    let normals = world_from_local.matrix3.inverse().transpose();
    transform(&mut mesh, Mesh::ATTRIBUTE_POSITION.id, |p| {
        plane.reflect(world_from_local.transform_point3(p))
    });
    transform(&mut mesh, Mesh::ATTRIBUTE_NORMAL.id, |n| {
        plane.reflect_direction((normals * n).normalize())
    });
    let mut corners: Vec<u32> = match mesh.indices() {
        Some(indices) => indices.iter().map(|index| index as u32).collect(),
        None => (0..mesh.count_vertices() as u32).collect(),
    };
    for triangle in corners.as_chunks_mut::<3>().0 {
        triangle.swap(1, 2);
    }
    mesh.insert_indices(Indices::U32(corners));
    mesh
}

fn transform(
    mesh: &mut Mesh,
    attribute: bevy::mesh::MeshVertexAttributeId,
    map: impl Fn(DVec3) -> DVec3,
) {
    if let Some(VertexAttributeValues::Float32x3(values)) = mesh.attribute_mut(attribute) {
        for value in values {
            *value = map(Vec3::from(*value).as_dvec3()).as_vec3().to_array();
        }
    }
}
