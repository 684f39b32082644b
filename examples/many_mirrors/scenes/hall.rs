//! Two long walls of mirrors that face each other, with things between.

use std::f32::consts::FRAC_PI_2;

use bevy::prelude::*;
use bevy_planar_mirror::prelude::*;

use super::{Builder, MainCamera};

/// From the middle of the hall to a wall.
const HALF: f32 = 2.2;
const LENGTH: f32 = 12.0;
const HEIGHT: f32 = 3.0;
/// Mirrors along a wall.
const MIRRORS: u8 = 6;

pub fn set_up(mut builder: Builder) {
    builder.commands.spawn((
        MainCamera,
        Transform::from_xyz(-0.9, 1.7, LENGTH / 2.0 - 0.4).looking_at(vec3(1.6, 1.1, 0.0), Vec3::Y),
    ));
    let long = |y: f32| Transform::from_xyz(0.0, y, 0.0);
    let slab = Cuboid::new(2.0 * HALF + 0.4, 0.1, LENGTH);
    builder.thing(slab, Color::srgb(0.35, 0.27, 0.2), long(-0.05));
    builder.thing(slab, Color::srgb(0.75, 0.75, 0.72), long(HEIGHT + 0.05));
    for end in [-1.0, 1.0] {
        let place = Transform::from_xyz(0.0, HEIGHT / 2.0, end * (LENGTH / 2.0 + 0.05));
        let wall = Cuboid::new(2.0 * HALF + 0.4, HEIGHT, 0.1);
        builder.thing(wall, Color::srgb(0.3, 0.36, 0.5), place);
    }
    let width = LENGTH / f32::from(MIRRORS);
    let mirror = builder
        .meshes
        .add(Rectangle::new(width - 0.2, HEIGHT - 0.5));
    for side in [-1.0, 1.0] {
        // The last reflection that is drawn shows this where a mirror would be.
        let place = Transform::from_xyz(side * (HALF + 0.1), HEIGHT / 2.0, 0.0);
        let wall = Cuboid::new(0.1, HEIGHT, LENGTH);
        builder.thing(wall, Color::srgb(0.45, 0.2, 0.18), place);
        for i in 0..MIRRORS {
            let along = (f32::from(i) + 0.5) * width - LENGTH / 2.0;
            builder.commands.spawn((
                super::InScene,
                Mesh3d(mirror.clone()),
                Transform::from_xyz(side * HALF, HEIGHT / 2.0, along)
                    .with_rotation(Quat::from_rotation_y(-side * FRAC_PI_2)),
                PlanarMirror::default(),
            ));
        }
    }
    for i in 0..5_u8 {
        let along = 2.1 * f32::from(i) - 4.6;
        let aside = if i % 2 == 0 { 0.7 } else { -0.5 };
        builder.exhibit(usize::from(i), vec3(aside, 0.0, along));
        if i % 2 == 0 {
            let color = [Color::srgb(1.0, 0.85, 0.6), Color::srgb(0.8, 0.9, 1.0)];
            builder.lamp(color[usize::from(i / 2 % 2)], vec3(0.0, 2.6, along + 0.8));
        }
    }
}
