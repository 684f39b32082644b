//! A floor of fifty mirrors in one plane, under a few things.

use bevy::{light::CascadeShadowConfigBuilder, prelude::*};
use bevy_planar_mirror::prelude::*;

use super::{Builder, InScene, MainCamera};

const COLUMNS: u8 = 10;
const ROWS: u8 = 5;
const TILE: f32 = 1.0;

pub fn set_up(mut builder: Builder) {
    builder.commands.spawn((
        MainCamera,
        Transform::from_xyz(1.5, 2.4, 5.6).looking_at(vec3(0.0, 0.3, 0.0), Vec3::Y),
    ));
    builder.commands.spawn((
        InScene,
        DirectionalLight {
            illuminance: 7000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        CascadeShadowConfigBuilder {
            num_cascades: 2,
            first_cascade_far_bound: 6.0,
            maximum_distance: 25.0,
            ..default()
        }
        .build(),
        Transform::from_xyz(-2.0, 4.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let floor = Cuboid::new(14.0, 0.1, 9.0);
    let place = Transform::from_xyz(0.0, -0.06, 0.0);
    builder.thing(floor, Color::srgb(0.5, 0.46, 0.4), place);
    let wall = Cuboid::new(14.0, 3.0, 0.1);
    let place = Transform::from_xyz(0.0, 1.5, -4.5);
    builder.thing(wall, Color::srgb(0.35, 0.45, 0.55), place);

    let tile = builder
        .meshes
        .add(Plane3d::default().mesh().size(TILE - 0.05, TILE - 0.05));
    let tints = [Color::srgb(0.1, 0.15, 0.3), Color::srgb(0.9, 0.85, 0.7)].map(|color| {
        builder.materials.add(StandardMaterial {
            base_color: color.with_alpha(0.25),
            alpha_mode: AlphaMode::Blend,
            ..default()
        })
    });
    for i in 0..COLUMNS * ROWS {
        let (column, row) = (i % COLUMNS, i / COLUMNS);
        let place = |index: u8, count: u8| (f32::from(index) + 0.5 - f32::from(count) / 2.0) * TILE;
        builder.commands.spawn((
            InScene,
            Mesh3d(tile.clone()),
            MeshMaterial3d(tints[usize::from((column + row) % 2)].clone()),
            Transform::from_xyz(place(column, COLUMNS), 0.0, place(row, ROWS)),
            PlanarMirror::default(),
        ));
    }
    for i in 0..6_u8 {
        let place = vec3(1.5 * f32::from(i) - 3.7, 0.0, f32::from(i % 3) - 1.4);
        builder.exhibit(usize::from(i), place);
    }
}
