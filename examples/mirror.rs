//! The smallest mirror: one plugin, one component on a flat mesh.

use bevy::prelude::*;
use bevy_planar_mirror::prelude::*;

fn main() {
    App::new()
        .add_plugins((DefaultPlugins, PlanarMirrorPlugin::default()))
        .add_systems(Startup, setup)
        .run();
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn((
        Mesh3d(meshes.add(Rectangle::new(4.0, 2.0))),
        Transform::from_xyz(0.0, 1.0, -2.0),
        PlanarMirror::default(),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Cuboid::from_length(1.0))),
        MeshMaterial3d(materials.add(Color::srgb(0.9, 0.5, 0.1))),
        Transform::from_xyz(0.0, 0.5, 0.0).with_rotation(Quat::from_rotation_y(0.5)),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(6.0, 6.0))),
        MeshMaterial3d(materials.add(Color::srgb(0.3, 0.5, 0.3))),
    ));
    commands.spawn((PointLight::default(), Transform::from_xyz(2.0, 4.0, 2.0)));
    commands.spawn((
        Camera3d::default(),
        Transform::from_xyz(1.5, 2.0, 4.0).looking_at(Vec3::Y * 0.5, Vec3::Y),
    ));
}
