//! Places as games have them: a table, a corridor, floors, a wall.

use std::f32::consts::FRAC_PI_2;

use bevy::prelude::*;

use super::{
    Case,
    still_life::{daylight, furnish},
};
use crate::{
    bezier,
    support::{
        props::{at, lit, spot},
        scene::{Look, Scene, Surface},
    },
};

/// Wide as a screen, so that "aspect 1" and the like are said by the scenes that mean it.
pub const WIDE: UVec2 = UVec2::new(16, 9);

pub fn cases() -> Vec<Case> {
    vec![
        teapot().quick(),
        corridor(),
        floor("floor-1.6m", "a room's floor, the eye at 1.6 m", 1.6).quick(),
        floor("floor-1cm", "the same floor, the eye 1 cm above it", 0.01),
        head_on().quick(),
        off_45(),
    ]
}

pub fn scene(name: &str) -> Scene {
    let mut scene = Scene::new(name);
    scene.size = WIDE;
    scene
}

/// The table of the teapot example, with the teapot half through it and a spot light's shadows.
fn teapot() -> Case {
    const TABLE: Vec3 = Vec3::new(0.0, -1.0, -3.0);
    let pot = bezier::tessellate(&bezier::teapot_patches(), 12);
    let pose = Transform::from_xyz(0.0, -1.2, -3.3)
        .with_rotation(Quat::from_rotation_y(-0.45))
        .with_scale(Vec3::splat(0.25));
    let paint = StandardMaterial {
        perceptual_roughness: 0.35,
        double_sided: true,
        cull_mode: None,
        ..lit(Color::srgb(0.72, 0.16, 0.07))
    };
    let mut scene = scene("teapot")
        .eye(Vec3::new(0.0, 0.0, 1.0), TABLE.with_y(0.0))
        .fov(65.0)
        .mirror(Surface::floor(4.0, 4.0, Transform::from_translation(TABLE)))
        .object(pot, paint, pose)
        .object(
            Cuboid::new(5.0, 2.0, 0.2),
            lit(Color::srgb(0.6, 0.65, 0.75)),
            at(0.0, 0.2, -5.4),
        )
        // Under the table, where no reflection may find it.
        .object(
            Cuboid::new(1.5, 0.3, 1.5),
            lit(Color::srgb(0.2, 0.5, 0.2)),
            at(0.6, -1.6, -2.6),
        )
        .prop(spot(
            Vec3::new(2.2, 2.4, -0.8),
            Vec3::new(0.0, -0.9, -3.3),
            true,
        ));
    scene.ambient.brightness = 250.0;
    Case::new("teapot", "a teapot half through a mirror table", scene)
}

/// The mirror hangs on the right wall; in it one sees the left wall, its end, and what stands in
/// the open beyond.
fn corridor() -> Case {
    let mirror =
        Transform::from_xyz(1.0, 1.5, -20.0).with_rotation(Quat::from_rotation_y(-FRAC_PI_2));
    let mut scene = daylight(scene("corridor"))
        .eye(Vec3::new(-0.8, 1.6, 0.0), Vec3::new(0.9, 1.5, -20.0))
        .fov(8.0)
        .mirror(Surface::wall(3.0, 2.0, mirror))
        .object(
            Cuboid::new(2.4, 0.1, 80.0),
            lit(Color::srgb(0.6, 0.5, 0.4)),
            at(0.0, -0.05, -30.0),
        )
        .object(
            Cuboid::new(0.1, 3.0, 53.0),
            lit(Color::srgb(0.5, 0.6, 0.7)),
            at(-1.2, 1.5, -16.5),
        )
        // Half in the wall that the mirror hangs on.
        .object(
            Sphere::new(0.25).mesh().uv(24, 14),
            lit(Color::srgb(0.9, 0.4, 0.3)),
            at(1.0, 1.9, -20.6),
        )
        .object(
            Cuboid::from_length(1.5),
            lit(Color::srgb(0.3, 0.9, 0.3)),
            at(2.5, 1.5, -20.0),
        );
    for i in 0..3_u8 {
        let warm = 0.4 + 0.2 * f32::from(i);
        scene = scene.object(
            Cuboid::new(0.05, 0.5, 0.7),
            lit(Color::srgb(warm, 0.4, 1.0 - warm)),
            at(-1.1, 1.0 + 0.6 * f32::from(i), -42.4),
        );
    }
    let reflected_eye = Vec3::new(2.8, 1.6, 0.0);
    let case = Case::new("corridor", "a small mirror 20 m down a corridor", scene);
    layers(
        case,
        reflected_eye,
        &[45.0, 220.0],
        0.004,
        [-0.095, -0.086],
        0.01,
    )
}

/// A floor of twenty by twenty meters; far away pairs of layers, each a thousandth behind the
/// other, up to a kilometer.
///
/// Near the floor only its part just before the near plane is more than a line, so there the
/// boards are lower.
fn floor(name: &str, about: &str, height: f32) -> Case {
    let near = height.min(1.0);
    let (size, rise) = if height < 0.1 {
        (0.05, 0.05)
    } else {
        (0.1, 0.2)
    };
    let scene = daylight(scene(name))
        .eye(
            Vec3::new(0.0, height, 2.0),
            Vec3::new(0.0, height * 0.6, -4.0),
        )
        .fov(60.0)
        .mirror(Surface::floor(20.0, 20.0, at(0.0, 0.0, -7.5)))
        .object(
            Sphere::new(0.5).mesh().uv(32, 18),
            lit(Color::srgb(0.9, 0.5, 0.3)),
            at(-1.2, 0.8, -3.0),
        )
        // It stands in the floor, leaning.
        .object(
            Cuboid::new(0.3, 2.4, 0.3),
            lit(Color::srgb(0.8, 0.3, 0.5)),
            at(0.5, 0.2, -3.5).with_rotation(Quat::from_euler(EulerRot::XYZ, 0.2, 0.4, 0.6)),
        )
        .object(
            Cuboid::new(1.2, 0.3 * near, 1.2),
            lit(Color::srgb(0.4, 0.6, 0.9)),
            at(1.8, 0.6 * near, -5.0),
        )
        .object(
            Cuboid::new(6.0, 0.5, 3.0),
            lit(Color::srgb(0.2, 0.9, 0.2)),
            at(0.0, -0.8, if height < 0.1 { -60.0 } else { -6.0 }),
        );
    layers(
        Case::new(name, about, scene),
        Vec3::ZERO,
        &[30.0, 100.0, 300.0, 1000.0],
        size,
        [-0.45, 0.45],
        rise,
    )
}

/// Pairs of boards across -Z from `from`, at these distances; the farther board of a pair is a
/// thousandth of the distance behind the nearer one and a little larger. `size`, the range `side` and
/// `rise` are theirs for each unit of distance.
fn layers(
    mut case: Case,
    from: Vec3,
    distances: &[f32],
    size: f32,
    side: [f32; 2],
    rise: f32,
) -> Case {
    let count = distances.len() as f32;
    for (i, &distance) in distances.iter().enumerate() {
        let side = side[0] + (side[1] - side[0]) * (i as f32 + 0.5) / count;
        let [front, back] = [[0.9, 0.9, 0.8], [0.3, 0.3, 0.9]]
            .map(|[r, g, b]| Look::from(lit(Color::srgb(r, g, b))));
        case.layers.push(case.scene.objects.len());
        for (look, distance, size) in [
            (front, distance, size),
            (back, distance * 1.001, size * 1.4),
        ] {
            let place = Vec3::new(side, rise, -1.0) * distance;
            let size = size * distance;
            case.scene = case.scene.object(
                Rectangle::new(size, size),
                look,
                Transform::from_translation(from + place),
            );
        }
    }
    case
}

/// Exactly square to a wall.
fn head_on() -> Case {
    let scene = scene("head-on")
        .eye(Vec3::new(0.8, 0.5, 4.0), Vec3::new(0.8, 0.5, 0.0))
        .mirror(Surface::wall(4.0, 3.0, Transform::default()));
    Case::new(
        "head-on",
        "the camera exactly square to a wall mirror",
        furnish(scene, Transform::IDENTITY, 1.0),
    )
}

/// One edge of the view is parallel to the mirror.
fn off_45() -> Case {
    let mut scene = scene("off-45")
        .eye(Vec3::new(2.5, 0.4, 2.5), Vec3::new(0.0, 0.4, 0.0))
        .fov(90.0)
        .mirror(Surface::wall(5.0, 4.0, Transform::default()));
    scene.size = UVec2::new(1, 1);
    Case::new(
        "off-45",
        "45 degrees off, fov 90, a square picture: one edge of the view parallel to the mirror",
        furnish(scene, Transform::IDENTITY, 1.0),
    )
}
