//! Meshes that are not where their bounds say, or whose bounds nobody asks: none is lost in a mirror,
//! and none shows behind it.

use bevy::{
    camera::visibility::NoCpuCulling,
    mesh::{
        VertexAttributeValues,
        morph::{MeshMorphWeights, MorphAttributes},
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
    render::render_resource::PrimitiveTopology,
};
use bevy_planar_mirror::PlanarMirror;

use crate::support::{
    live::{Live, find, named, of, unclad},
    props::{GREEN, RED, at},
    scene::{Look, Scene, Surface},
};

/// A wall mirror, a ball before it and a place for something else.
fn room(name: &str) -> Scene {
    let mut scene = Scene::new(name)
        .eye(vec3(-0.9, 0.0, 4.0), vec3(-0.9, 0.0, 0.0))
        .mirror(Surface::wall(4.0, 3.0, Transform::default()).look(unclad("mirror")))
        .object(
            Sphere::new(0.3).mesh().uv(16, 10),
            GREEN,
            at(-0.9, 0.4, 0.8),
        )
        .with_camera(Name::new("camera"));
    scene.size = UVec2::new(120, 90);
    scene
}

/// Turns the camera away and back.
fn look_away_and_back(live: &mut Live) {
    let eye = *of::<Transform>(live.world(), "camera");
    of::<Transform>(live.world(), "camera").rotate_y(3.1);
    for _ in 0..4 {
        live.next();
    }
    *of::<Transform>(live.world(), "camera") = eye;
}

/// `NoCpuCulling`: the engine lists such meshes in the frame in which they appear, once for all.
#[test]
fn what_only_the_gpu_culls_is_reflected_again_when_the_mirror_comes_back() {
    let with = |extra: fn(&mut EntityWorldMut)| {
        let red = Look::other(move |entity| {
            Look::from(RED).apply(entity);
            extra(entity);
        });
        room("gpu-culled").object(Cuboid::from_length(0.6), red, at(0.3, 0.0, 1.2))
    };
    let expected = Live::new(&with(|_| {})).settled();
    let mut live = Live::new(&with(|entity| {
        entity.insert(NoCpuCulling);
    }));
    live.settled().assert_same(&expected, "gpu-culled");
    look_away_and_back(&mut live);
    live.next().assert_same(&expected, "gpu-culled-again");
    // And it goes, and comes.
    let world = live.world();
    let thing = world
        .query_filtered::<Entity, With<NoCpuCulling>>()
        .single(world)
        .expect("there is one");
    world.entity_mut(thing).insert(Visibility::Hidden);
    let hidden = Live::new(&room("gpu-culled-hidden")).settled();
    live.next().assert_same(&hidden, "gpu-culled-hidden");
    live.world().entity_mut(thing).insert(Visibility::Inherited);
    live.next().assert_same(&expected, "gpu-culled-shown");
}

/// Behind the mirror it is cut away, as is what crosses it.
#[test]
fn what_only_the_gpu_culls_does_not_show_behind_the_mirror() {
    for z in [-1.0, 0.0] {
        let with = |is_gpu_culled: bool| {
            let red = Look::other(move |entity| {
                Look::from(RED).apply(entity);
                if is_gpu_culled {
                    entity.insert(NoCpuCulling);
                }
            });
            room("gpu-culled-behind").object(Cuboid::from_length(0.6), red, at(0.3, 0.0, z))
        };
        let expected = Live::new(&with(false)).settled();
        let picture = Live::new(&with(true)).settled();
        picture.assert_same(&expected, "gpu-culled-behind");
    }
}

#[test]
fn a_mirror_that_only_the_gpu_culls_is_not_in_itself() {
    let scene = room("gpu-culled-mirror");
    let expected = Live::new(&scene).settled();
    let mut live = Live::new(&scene);
    let mirror = find(live.world(), "mirror");
    live.world().entity_mut(mirror).insert(NoCpuCulling);
    live.settled().assert_same(&expected, "gpu-culled-mirror");
    look_away_and_back(&mut live);
    live.next()
        .assert_same(&expected, "gpu-culled-mirror-again");
}

/// The upper half of a box, pushed so far.
fn pushed(mesh: &Mesh, push: Vec3) -> Vec<Vec3> {
    let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION);
    let Some(VertexAttributeValues::Float32x3(positions)) = positions else {
        panic!("a box has positions");
    };
    let is_upper = |at: &[f32; 3]| if at[1] > 0.0 { push } else { Vec3::ZERO };
    positions.iter().map(is_upper).collect()
}

/// The same mesh with the push in its vertices.
fn baked(push: Vec3) -> Mesh {
    let mut mesh = Mesh::from(Cuboid::from_length(0.6));
    let moves = pushed(&mesh, push);
    let positions = mesh.attribute_mut(Mesh::ATTRIBUTE_POSITION);
    if let Some(VertexAttributeValues::Float32x3(positions)) = positions {
        for (at, by) in positions.iter_mut().zip(moves) {
            *at = (Vec3::from(*at) + by).to_array();
        }
    }
    mesh
}

const PUSHES: [Vec3; 3] = [
    // Through the plane, wholly behind it and away from it, out of the bounds in each case.
    Vec3::new(0.0, 0.0, -1.6),
    Vec3::new(0.0, 0.0, -3.0),
    Vec3::new(-1.4, 0.0, 0.6),
];

#[test]
fn a_morphed_mesh_is_reflected_as_it_is_drawn() {
    for push in PUSHES {
        let place = at(0.5, 0.0, 0.9);
        let expected = room("morphed").object(baked(push), RED, place);
        let expected = Live::new(&expected).settled();
        let mut mesh = Mesh::from(Cuboid::from_length(0.6));
        let moves = pushed(&mesh, push).into_iter();
        let moves = moves.map(|position| MorphAttributes {
            position,
            ..default()
        });
        mesh.set_morph_targets(moves.collect());
        let red = Look::other(|entity| {
            Look::from(RED).apply(entity);
            entity.insert(MeshMorphWeights::Value { weights: vec![1.0] });
        });
        let picture = Live::new(&room("morphed").object(mesh, red, place)).settled();
        picture.assert_same(&expected, &format!("morphed-{push}"));
    }
}

/// Also when its bounds at rest lie behind the mirror.
#[test]
fn a_skinned_mesh_without_bounds_of_its_own_is_reflected_as_it_is_drawn() {
    for (rest, moved) in [
        (vec3(0.5, 0.0, 0.9), Vec3::new(-0.6, 0.0, 0.4)),
        (vec3(0.5, 0.0, -1.5), Vec3::new(0.0, 0.0, 2.4)),
        (vec3(0.5, 0.0, 0.9), Vec3::new(0.0, 0.0, -0.9)),
    ] {
        let expected = room("skinned").object(
            Cuboid::from_length(0.6),
            RED,
            Transform::from_translation(rest + moved),
        );
        let expected = Live::new(&expected).settled();
        let mut mesh = Mesh::from(Cuboid::from_length(0.6));
        assert_eq!(mesh.primitive_topology(), PrimitiveTopology::TriangleList);
        let count = mesh.count_vertices();
        mesh.insert_attribute(
            Mesh::ATTRIBUTE_JOINT_INDEX,
            VertexAttributeValues::Uint16x4(vec![[0; 4]; count]),
        );
        mesh.insert_attribute(
            Mesh::ATTRIBUTE_JOINT_WEIGHT,
            vec![[1.0_f32, 0.0, 0.0, 0.0]; count],
        );
        let scene = room("skinned").object(
            mesh,
            named("skinned", RED),
            Transform::from_translation(rest),
        );
        let mut live = Live::new(&scene);
        let skinned = find(live.world(), "skinned");
        let world = live.world();
        let poses = SkinnedMeshInverseBindposes::from(vec![Mat4::IDENTITY]);
        let inverse_bindposes = world
            .resource_mut::<Assets<SkinnedMeshInverseBindposes>>()
            .add(poses);
        let joint = world.spawn(Transform::from_translation(rest + moved)).id();
        world.entity_mut(skinned).insert(SkinnedMesh {
            inverse_bindposes,
            joints: vec![joint],
        });
        live.settled()
            .assert_same(&expected, &format!("skinned-{moved}"));
    }
}

/// Bevy tells no more than 32 views what is in their range.
#[test]
fn levels_of_detail_show_in_any_number_of_mirrors() {
    use bevy::camera::visibility::VisibilityRange;
    let tiles = |ranged: bool| {
        let red = Look::other(move |entity| {
            Look::from(RED).apply(entity);
            if ranged {
                entity.insert(VisibilityRange::abrupt(0.0, 30.0));
            }
        });
        let mut scene = room("ranged-tiles").object(Sphere::new(0.5), red, at(0.0, 0.0, 1.5));
        scene.mirrors.clear();
        for index in 0..40 {
            let (x, y) = ((index % 8) as f32, (index / 8) as f32);
            // Each in a plane of its own.
            let turn = Quat::from_rotation_y(0.01 * index as f32 - 0.2);
            let place = at(0.5 * x - 1.75, 0.5 * y - 1.0, 0.0).with_rotation(turn);
            scene = scene.mirror(Surface {
                mirror: PlanarMirror::default(),
                ..Surface::wall(0.46, 0.46, place)
            });
        }
        scene
    };
    let expected = Live::new(&tiles(false)).settled();
    let picture = Live::new(&tiles(true)).settled();
    picture.assert_same(&expected, "ranged-tiles");
}
