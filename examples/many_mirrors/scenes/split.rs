//! A split screen: two cameras with viewports, and several mirrors that both see.

use std::f32::consts::FRAC_PI_2;

use bevy::{camera::Viewport, prelude::*};
use bevy_planar_mirror::prelude::*;

use super::{Builder, InScene, MainCamera};

/// Which half of the picture a camera has: 0 the left one, 1 the right one.
#[derive(Component)]
pub struct Half(u32);

pub fn set_up(mut builder: Builder) {
    builder.commands.spawn((
        MainCamera,
        Half(0),
        Transform::from_xyz(-0.8, 1.6, 4.2).looking_at(vec3(0.0, 1.0, 0.0), Vec3::Y),
    ));
    builder.commands.spawn((
        InScene,
        Camera3d::default(),
        Camera {
            order: 1,
            ..default()
        },
        Half(1),
        Transform::from_xyz(2.2, 2.6, 3.2).looking_at(vec3(-0.4, 0.8, -0.6), Vec3::Y),
    ));
    let gray = Color::srgb(0.55, 0.53, 0.5);
    let slab = Cuboid::new(7.0, 0.1, 9.0);
    builder.thing(slab, gray, Transform::from_xyz(0.0, -0.05, 1.0));
    let back = Cuboid::new(7.0, 3.2, 0.1);
    builder.thing(
        back,
        Color::srgb(0.3, 0.4, 0.5),
        Transform::from_xyz(0.0, 1.6, -2.6),
    );
    let front = Transform::from_xyz(0.0, 1.6, 5.5);
    builder.thing(back, Color::srgb(0.5, 0.35, 0.3), front);
    let side = Cuboid::new(0.1, 3.2, 9.0);
    for x in [-3.5, 3.5] {
        let place = Transform::from_xyz(x, 1.6, 1.0);
        builder.thing(side, Color::srgb(0.45, 0.5, 0.4), place);
    }

    // Three on the wall at the back, one on each side, one that stands in the room.
    let wall = |x: f32| Transform::from_xyz(x, 1.5, -2.5);
    let turned =
        |transform: Transform, angle: f32| transform.with_rotation(Quat::from_rotation_y(angle));
    let mirrors = [
        (1.2, 1.8, wall(-2.0)),
        (1.6, 2.2, wall(0.0)),
        (1.2, 1.8, wall(2.0)),
        (
            2.4,
            1.6,
            turned(Transform::from_xyz(-3.4, 1.4, 0.2), FRAC_PI_2),
        ),
        (
            2.4,
            1.6,
            turned(Transform::from_xyz(3.4, 1.4, 0.2), -FRAC_PI_2),
        ),
        (0.8, 1.5, turned(Transform::from_xyz(-1.7, 0.8, -0.9), 0.6)),
    ];
    for (width, height, transform) in mirrors {
        let mesh = builder.meshes.add(Rectangle::new(width, height));
        builder
            .commands
            .spawn((InScene, Mesh3d(mesh), transform, PlanarMirror::default()));
    }
    for i in 0..4_u8 {
        let place = vec3(1.1 * f32::from(i) - 1.4, 0.0, 0.7 * f32::from(i % 2) - 0.2);
        builder.exhibit(usize::from(i), place);
    }
    builder.lamp(Color::srgb(1.0, 0.9, 0.75), vec3(-1.2, 2.8, 1.0));
    builder.lamp(Color::srgb(0.8, 0.9, 1.0), vec3(1.6, 2.7, 2.4));
}

/// Each camera has its half, however large the picture is.
pub fn fit_viewports(mut cameras: Query<(&mut Camera, &Half)>) {
    for (mut camera, half) in &mut cameras {
        let Some(size) = camera.physical_target_size() else {
            continue;
        };
        let left = size.x / 2;
        let (from, width) = match half.0 {
            0 => (0, left),
            _ => (left, size.x - left),
        };
        // A window may be too small to be cut in two.
        let viewport = (left > 0 && size.y > 0).then(|| Viewport {
            physical_position: UVec2::new(from, 0),
            physical_size: UVec2::new(width, size.y),
            ..default()
        });
        let place = |viewport: &Option<Viewport>| {
            let viewport = viewport.as_ref()?;
            Some((viewport.physical_position, viewport.physical_size))
        };
        if place(&camera.viewport) != place(&viewport) {
            camera.viewport = viewport;
        }
    }
}
