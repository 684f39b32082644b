//! Many things: all across the mirror, or none.

use bevy::prelude::*;

use super::{
    Case,
    rooms::scene,
    still_life::{daylight, furnish_before},
};
use crate::support::{
    props::{at, lit},
    random::Random,
    scene::{Look, Surface},
};

pub fn cases() -> Vec<Case> {
    vec![straddlers(), nothing_straddles()]
}

/// A floor mirror with 2500 posts through it.
fn straddlers() -> Case {
    const SIDE: u16 = 50;
    let random = &mut Random::new(7);
    let post = Mesh::from(Cuboid::new(0.1, 0.9, 0.1));
    let mut scene = daylight(scene("straddlers"))
        .eye(Vec3::new(0.0, 3.0, 9.0), Vec3::new(0.0, 0.0, -2.0))
        .fov(60.0)
        .mirror(Surface::floor(20.0, 20.0, at(0.0, 0.0, -6.0)));
    let looks: Vec<Look> = (0..6_u8)
        .map(|i| lit(Color::hsl(60.0 * f32::from(i), 0.7, 0.6)).into())
        .collect();
    for i in 0..SIDE * SIDE {
        let (x, z) = (f32::from(i % SIDE), f32::from(i / SIDE));
        let place = Vec3::new(
            (x / f32::from(SIDE) - 0.5) * 18.0,
            random.between(-0.2, 0.3),
            2.0 - z / f32::from(SIDE) * 17.0,
        );
        let lean = random.within(Vec3::splat(-0.5), Vec3::splat(0.5));
        let turned = Quat::from_euler(EulerRot::XYZ, lean.x, lean.y, lean.z);
        scene = scene.object(
            post.clone(),
            looks[usize::from(i) % looks.len()].clone(),
            Transform::from_translation(place).with_rotation(turned),
        );
    }
    Case::new("straddlers", "2500 posts through a floor mirror", scene)
}

fn nothing_straddles() -> Case {
    let scene = scene("nothing-straddles")
        .eye(Vec3::new(1.4, 0.8, 5.0), Vec3::ZERO)
        .mirror(Surface::wall(4.0, 3.0, Transform::default()));
    Case::new(
        "nothing-straddles",
        "things before the mirror and behind it, none across",
        furnish_before(scene, Transform::IDENTITY, 1.0),
    )
}
