//! Objects that are more than a mesh of one color.

mod choice;
mod shape;
mod surface;

use std::sync::Arc;

use bevy::prelude::*;

use crate::support::{
    props::{add, at},
    scene::{Scene, Surface},
};

fn wall(name: &str) -> Scene {
    Scene::new(name)
        .eye(vec3(0.9, 0.5, 4.0), Vec3::ZERO)
        .mirror(Surface::wall(4.0, 2.6, Transform::default()))
}

fn turned(x: f32, y: f32, z: f32) -> Transform {
    at(x, y, z).with_rotation(Quat::from_euler(EulerRot::XYZ, 0.3, 0.6, 0.2))
}

/// An object that is the same in all drawings: nothing of it is cut.
fn uncut(mut scene: Scene, spawn: impl Fn(&mut EntityWorldMut) + Send + Sync + 'static) -> Scene {
    scene.props.push(Arc::new(spawn));
    scene
}

fn unlit(entity: &mut EntityWorldMut, color: Color) -> MeshMaterial3d<StandardMaterial> {
    MeshMaterial3d(add(
        entity,
        StandardMaterial {
            base_color: color,
            unlit: true,
            ..default()
        },
    ))
}
