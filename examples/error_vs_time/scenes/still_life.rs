//! What most scenes show, in the mirror's own frame: things before it, across it and behind it.

use bevy::prelude::*;

use crate::support::{
    props::{at, lit, sun},
    scene::{Look, Scene},
};

/// Puts the things of the still life into a scene whose mirror has this frame: x to the right,
/// y up, z to the front. `unit` is a quarter of the mirror's width.
pub fn furnish(mut scene: Scene, frame: Transform, unit: f32) -> Scene {
    for (mesh, look, local) in things() {
        let local = Transform {
            translation: local.translation * unit,
            scale: local.scale * unit,
            ..local
        };
        scene = scene.object(mesh, look, frame * local);
    }
    daylight(scene)
}

/// The same without what crosses the mirror.
pub fn furnish_before(scene: Scene, frame: Transform, unit: f32) -> Scene {
    let crossing = scene.objects.len() + BEFORE;
    let mut furnished = furnish(scene, frame, unit);
    furnished.objects.drain(crossing..crossing + ACROSS);
    furnished
}

/// One sun without shadows, and light from everywhere.
pub fn daylight(mut scene: Scene) -> Scene {
    scene.ambient.brightness = 150.0;
    scene.prop(sun(false))
}

const BEFORE: usize = 9;
const ACROSS: usize = 2;

/// Before the mirror, across it, behind it.
fn things() -> Vec<(Mesh, Look, Transform)> {
    let paint = |r, g, b| Look::from(lit(Color::srgb(r, g, b)));
    let tilted = |x: f32, y: f32, z: f32| {
        at(x, y, z).with_rotation(Quat::from_euler(EulerRot::XYZ, 0.5, 0.4, 0.3))
    };
    let post = |x: f32, y: f32, lean: f32| {
        // Leaning along the mirror, so that what is cut away would show beside the rest.
        at(x, y, 0.0).with_rotation(Quat::from_euler(EulerRot::XYZ, lean, 0.6, 0.0))
    };
    let mut things = vec![
        (
            Sphere::new(0.5).mesh().uv(32, 18),
            paint(0.9, 0.5, 0.3),
            at(-0.9, 0.3, 0.9),
        ),
        (
            Cuboid::from_length(0.7).into(),
            paint(0.4, 0.6, 0.9),
            tilted(0.9, -0.5, 0.8),
        ),
        (
            Torus::new(0.2, 0.5)
                .mesh()
                .minor_resolution(16)
                .major_resolution(32)
                .build(),
            paint(0.5, 0.9, 0.4),
            tilted(0.4, 0.8, 1.2),
        ),
        (
            Cone {
                radius: 0.35,
                height: 0.9,
            }
            .mesh()
            .resolution(32)
            .build(),
            paint(0.9, 0.9, 0.4),
            tilted(-1.2, -0.9, 1.0),
        ),
    ];
    // A wall of five stripes far before the mirror, which shows its back, and so nothing, to the
    // camera.
    for i in 0..5_u8 {
        let hue = f32::from(i) * 72.0;
        let around = Quat::from_rotation_y(std::f32::consts::PI);
        things.push((
            Rectangle::new(3.6, 14.0).into(),
            Look::from(lit(Color::hsl(hue, 0.35, 0.55))),
            at(3.6 * (f32::from(i) - 2.0), 0.0, 7.0).with_rotation(around),
        ));
    }
    things.extend([
        (
            Cuboid::new(0.25, 0.25, 1.6).into(),
            paint(0.8, 0.3, 0.5),
            post(-0.2, -0.3, 0.7),
        ),
        (
            Sphere::new(0.35).mesh().uv(32, 18),
            paint(0.3, 0.8, 0.8),
            at(1.3, 0.6, -0.05),
        ),
    ]);
    things.extend([
        (
            Cuboid::from_length(0.8).into(),
            paint(0.9, 0.2, 0.2),
            tilted(0.4, 0.2, -0.9),
        ),
        (
            Sphere::new(0.45).mesh().uv(32, 18),
            paint(0.7, 0.3, 0.9),
            at(-1.1, 0.1, -0.8),
        ),
    ]);
    things
}
