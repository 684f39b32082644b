//! Shapes that are more than a list of triangles: strips, lines, points, bones, morphs, many at once.

use std::f32::consts::PI;

use bevy::{
    asset::RenderAssetUsages,
    mesh::{
        PrimitiveTopology, VertexAttributeValues,
        morph::{MeshMorphWeights, MorphAttributes, MorphWeights},
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
};

use super::{turned, uncut, unlit, wall};
use crate::support::{
    props::{BLUE, GREEN, add, at, is},
    scene::Scene,
    studio::{Studio, assert_reflects},
};

/// A line covers the same pixels only if it is drawn in the same place: no flip.
#[test]
fn lines_and_points_are_reflected() {
    let corners = |count: usize| -> Vec<[f32; 3]> {
        (0..count)
            .map(|i| {
                let angle = i as f32 * 2.4;
                [0.9 * angle.cos(), 0.7 * angle.sin(), 0.04 * i as f32]
            })
            .collect()
    };
    for (name, topology, color) in [
        ("lines", PrimitiveTopology::LineList, GREEN),
        ("strip", PrimitiveTopology::LineStrip, BLUE),
        ("points", PrimitiveTopology::PointList, GREEN),
    ] {
        let scene = uncut(wall(&format!("topology-{name}")), move |entity| {
            let mesh = Mesh::new(topology, RenderAssetUsages::default())
                .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners(40));
            let mesh = Mesh3d(add(entity, mesh));
            let material = unlit(entity, color);
            entity.insert((mesh, material, at(0.0, 0.0, 0.8)));
        });
        let mut studio = Studio::default();
        let picture = studio.assert_reflects_in_place(&scene);
        let plain = studio.without_mirrors(&scene);
        let (both, one) = (picture.count(is(color)), plain.count(is(color)));
        assert!(
            both > one + 10,
            "{name}: {both} pixels where {one} are seen directly"
        );
    }
}

/// Every other triangle of a strip winds the other way.
#[test]
fn strips_of_triangles_are_reflected() {
    let scene = uncut(wall("object-strip"), |entity| {
        let count = 14;
        let corners: Vec<[f32; 3]> = (0..count)
            .map(|i| {
                let along = (i / 2) as f32 * 0.2 - 0.6;
                let side = if i % 2 == 0 { 0.2 } else { -0.2 };
                [along, side, 0.2 * (5.0 * along).sin()]
            })
            .collect();
        let mesh = Mesh::new(
            PrimitiveTopology::TriangleStrip,
            RenderAssetUsages::default(),
        )
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners);
        let mesh = Mesh3d(add(entity, mesh));
        let material = unlit(entity, GREEN);
        entity.insert((
            mesh,
            material,
            // Its front is towards the mirror.
            at(-0.2, 0.0, 1.0).with_rotation(Quat::from_rotation_y(PI)),
        ));
    });
    let picture = assert_reflects(&scene);
    let plain = Studio::default().without_mirrors(&scene);
    assert_eq!(plain.count(is(GREEN)), 0, "its back is culled");
    assert!(picture.count(is(GREEN)) > 300);
}

/// Equal meshes with equal materials are drawn by one call for all of them.
#[test]
fn many_equal_objects_are_reflected_each_at_its_place() {
    let crowd = |scene: Scene, color: Color, offset: f32| {
        uncut(scene, move |entity| {
            let mesh = Mesh3d(add(entity, Cuboid::from_length(0.09).into()));
            let material = unlit(entity, color);
            entity.world_scope(|world| {
                for i in 0..150 {
                    let angle = i as f32 * 2.399 + offset;
                    let radius = 0.1 * (i as f32).sqrt();
                    let place = vec3(radius * angle.cos(), radius * angle.sin(), 0.01 * i as f32);
                    let place = Transform::from_translation(place + Vec3::Z * 0.3)
                        .with_rotation(Quat::from_rotation_x(angle));
                    world.spawn((mesh.clone(), material.clone(), place));
                }
            });
        })
    };
    let scene = crowd(crowd(wall("crowd"), GREEN, 0.0), BLUE, 1.2);
    assert_reflects(&scene);
}

/// A post of two joints, bent at the middle.
#[test]
fn a_skinned_mesh_is_reflected_as_it_is_bent() {
    let mut mesh = Cuboid::new(0.25, 1.2, 0.25).mesh().build();
    mesh = mesh.with_duplicated_vertices();
    let Some(VertexAttributeValues::Float32x3(corners)) = mesh.attribute(Mesh::ATTRIBUTE_POSITION)
    else {
        panic!("a box has positions");
    };
    let joints: Vec<[u16; 4]> = corners.iter().map(|_| [0, 1, 0, 0]).collect();
    let weights: Vec<[f32; 4]> = corners
        .iter()
        .map(|[_, y, _]| {
            if *y > 0.0 {
                [0.1, 0.9, 0.0, 0.0]
            } else {
                [1.0, 0.0, 0.0, 0.0]
            }
        })
        .collect();
    mesh.insert_attribute(
        Mesh::ATTRIBUTE_JOINT_INDEX,
        VertexAttributeValues::Uint16x4(joints),
    );
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights);
    let post = |bend: f32| {
        let mesh = mesh.clone();
        uncut(wall(&format!("skinned-{bend}")), move |entity| {
            let mesh = Mesh3d(add(entity, mesh.clone()));
            let material = unlit(entity, GREEN);
            let poses = SkinnedMeshInverseBindposes::from(vec![Mat4::IDENTITY; 2]);
            let inverse_bindposes = add(entity, poses);
            let root = at(-0.5, 0.0, 0.9);
            let joints = entity.world_scope(|world| {
                let upper = root * Transform::from_rotation(Quat::from_rotation_z(bend));
                [root, upper].map(|place| world.spawn(place).id()).to_vec()
            });
            entity.insert((
                mesh,
                material,
                root,
                SkinnedMesh {
                    inverse_bindposes,
                    joints,
                },
            ));
        })
    };
    let mut studio = Studio::default();
    let straight = studio.assert_reflects(&post(0.0));
    let bent = studio.assert_reflects(&post(-0.9));
    let moved = bent.difference(&straight, 8, |_| true);
    assert!(
        moved.is_ok_and(|moved| moved.beyond > 100),
        "it is not bent"
    );
}

#[test]
fn a_morphed_mesh_is_reflected_as_it_is_shaped() {
    let pyramid = |weight: f32| {
        uncut(wall(&format!("morphed-{weight}")), move |entity| {
            let mut mesh = Mesh::from(Cuboid::from_length(0.6));
            let count = mesh.count_vertices();
            let Some(VertexAttributeValues::Float32x3(corners)) =
                mesh.attribute(Mesh::ATTRIBUTE_POSITION)
            else {
                panic!("a box has positions");
            };
            let target: Vec<MorphAttributes> = corners
                .iter()
                .map(|[x, y, z]| MorphAttributes {
                    position: if *y > 0.0 {
                        vec3(-x, 0.3, -z)
                    } else {
                        Vec3::ZERO
                    },
                    ..default()
                })
                .collect();
            assert_eq!(target.len(), count);
            mesh.set_morph_targets(target);
            let mesh = add(entity, mesh);
            let material = unlit(entity, GREEN);
            entity.insert((
                Mesh3d(mesh.clone()),
                material,
                turned(-0.5, 0.0, 0.9),
                MorphWeights::new(vec![weight], Some(mesh)).expect("one weight"),
                MeshMorphWeights::Value {
                    weights: vec![weight],
                },
            ));
        })
    };
    let mut studio = Studio::default();
    let plain = studio.assert_reflects(&pyramid(0.0));
    let shaped = studio.assert_reflects(&pyramid(1.0));
    let moved = shaped.difference(&plain, 8, |_| true);
    assert!(
        moved.is_ok_and(|moved| moved.beyond > 100),
        "it has no other shape"
    );
}
