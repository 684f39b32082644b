//! The scene in which cameras are tried: an upright mirror with something before, across and behind it.

use bevy::prelude::*;

use super::{
    props::{BLUE, GREEN, RED, YELLOW, at, lit, sun},
    scene::{Look, Scene, Surface},
};

/// The index of the object that goes through the mirror.
pub const CROSSING: usize = 2;
/// And that of the floor, which begins behind the mirror as well.
pub const FLOOR: usize = 4;

/// Seen a little from the right and above; every color is the one on the screen.
pub fn hall(name: &str) -> Scene {
    furnished(name, |color| color.into())
}

/// [`hall`] by daylight.
pub fn sunny_hall(name: &str) -> Scene {
    furnished(name, |color| lit(color).into()).prop(sun(false))
}

fn furnished(name: &str, look: impl Fn(Color) -> Look) -> Scene {
    let floor = Color::srgb(0.5, 0.5, 0.45);
    Scene::new(name)
        .eye(vec3(0.9, 1.2, 4.0), vec3(0.0, 0.4, 0.0))
        .mirror(Surface::wall(3.2, 2.2, at(0.0, 0.5, 0.0)))
        .object(Cuboid::from_length(0.6), look(RED), at(-0.8, 0.4, 1.2))
        .object(
            Sphere::new(0.35).mesh().uv(24, 16),
            look(BLUE),
            at(0.6, 0.2, 1.4),
        )
        // [`CROSSING`].
        .object(
            Cuboid::new(0.5, 0.5, 0.8),
            look(GREEN),
            Transform::from_xyz(0.2, 1.1, 0.0).with_rotation(Quat::from_rotation_y(0.4)),
        )
        .object(Cuboid::from_length(3.0), look(YELLOW), at(0.0, 0.5, -3.0))
        .object(Cuboid::new(8.0, 0.1, 6.0), look(floor), at(0.0, -0.9, 2.0))
}

/// Black bars before the edge of the hall's mirror, and as far around it as one sees.
pub fn framed(mut scene: Scene) -> Scene {
    let black: Look = Color::BLACK.into();
    let bars = [
        (vec3(20.0, 10.0, 0.05), vec3(0.0, 6.5, 0.1)),
        (vec3(20.0, 10.0, 0.05), vec3(0.0, -5.5, 0.1)),
        (vec3(10.0, 20.0, 0.05), vec3(6.5, 0.0, 0.1)),
        (vec3(10.0, 20.0, 0.05), vec3(-6.5, 0.0, 0.1)),
    ];
    for (size, place) in bars {
        let bar = Cuboid::from_size(size);
        scene = scene.object(bar, black.clone(), Transform::from_translation(place));
    }
    scene
}
