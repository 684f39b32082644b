//! Glass: materials that refract what is behind them, before a mirror and in it.

use bevy::{pbr::ScreenSpaceTransmission, prelude::*};

use crate::support::{
    props::{BLUE, GREEN, RED, YELLOW, at, is, lamp, lit},
    scene::{Scene, Surface},
    studio::{Studio, TOLERANCE},
};

/// Clear, without anything of its own: one sees what is behind it, where it is.
fn air() -> StandardMaterial {
    StandardMaterial {
        specular_transmission: 1.0,
        ior: 1.0,
        thickness: 0.0,
        perceptual_roughness: 0.0,
        reflectance: 0.0,
        ..default()
    }
}

fn glass() -> StandardMaterial {
    StandardMaterial {
        base_color: Color::srgb(0.9, 1.0, 0.9),
        specular_transmission: 0.9,
        ior: 1.5,
        thickness: 0.3,
        perceptual_roughness: 0.0,
        ..default()
    }
}

/// Stripes that a mirror shows to an eye before it, but which the eye does not see itself.
fn stripes(name: &str) -> Scene {
    let turned = Quat::from_rotation_y(std::f32::consts::PI);
    let mut scene = Scene::new(name)
        .eye(vec3(0.3, 0.2, 4.0), Vec3::ZERO)
        .mirror(Surface::wall(4.0, 2.6, Transform::default()));
    for (i, color) in [RED, YELLOW, BLUE, GREEN].into_iter().enumerate() {
        let place = at(i as f32 * 0.7 - 1.05, 0.0, 2.4).with_rotation(turned);
        scene = scene.object(Rectangle::new(0.5, 3.0), color, place);
    }
    scene
}

/// The camera's own glass sees the reflection behind it, as it sees all else.
#[test]
fn through_glass_before_the_mirror_one_sees_the_reflection() {
    let mut studio = Studio::default();
    let bare = stripes("glass-before");
    let without = studio.picture(&bare);
    // Flat and faced to the camera: its back, which the mirror would show, is culled.
    let pane = bare.object(Rectangle::new(1.2, 1.0), air(), at(0.2, 0.0, 1.5));
    let picture = studio.picture(&pane);
    picture.assert_alike(&without, TOLERANCE, 0.99, |_| true, "glass-before");
    assert!(without.count(is(YELLOW)) > 200);
}

#[test]
fn glass_is_reflected_with_what_is_seen_through_it() {
    let mut studio = Studio::default();
    let scene = stripes("air-reflected").object(
        Rectangle::new(1.2, 1.0),
        air(),
        at(0.2, 0.0, 1.2).with_rotation(Quat::from_rotation_y(std::f32::consts::PI)),
    );
    studio.assert_reflects(&scene);

    let ball = stripes("glass-reflected")
        .object(
            Sphere::new(0.5).mesh().uv(32, 18),
            glass(),
            at(-0.6, 0.1, 1.1),
        )
        .prop(lamp(vec3(0.5, 1.0, 2.0), false));
    studio.assert_reflects(&ball);
}

/// What one glass shows of another depends on the camera's steps.
#[test]
fn glass_behind_glass_is_reflected_as_in_so_many_steps() {
    let turned = Quat::from_rotation_y(std::f32::consts::PI);
    let mut studio = Studio::default();
    for steps in 0..3 {
        let scene = stripes(&format!("glass-steps-{steps}"))
            .object(
                Rectangle::new(1.2, 1.0),
                StandardMaterial {
                    base_color: Color::srgb(1.0, 0.5, 0.5),
                    ..glass()
                },
                at(0.2, 0.1, 1.6).with_rotation(turned),
            )
            .object(
                Rectangle::new(0.8, 0.7),
                glass(),
                at(0.0, 0.0, 0.9).with_rotation(turned),
            )
            .with_camera(ScreenSpaceTransmission { steps, ..default() });
        studio.assert_reflects(&scene);
    }
}

#[test]
fn glass_across_the_mirror_is_cut_at_it() {
    let scene = Scene::new("glass-cut")
        .eye(vec3(0.4, 1.6, 4.2), vec3(0.0, 0.1, 0.0))
        .mirror(Surface::floor(5.0, 5.0, Transform::default()))
        .object(
            Sphere::new(0.6).mesh().uv(32, 18),
            glass(),
            at(-0.5, 0.2, 0.3),
        )
        .object(Cuboid::new(3.0, 1.6, 0.1), YELLOW, at(0.0, 0.9, -1.4))
        .object(Cuboid::from_length(0.6), lit(RED), at(0.9, 0.4, -0.4))
        .prop(lamp(vec3(0.5, 2.0, 2.0), false));
    Studio::default().assert_reflects(&scene);
}

#[test]
fn glass_behind_the_mirror_does_not_show() {
    let mut studio = Studio::default();
    for (name, look) in [
        ("perfect", None),
        ("tinted", Some(crate::support::props::glass(BLUE, 0.3))),
    ] {
        let mut scene = stripes(&format!("glass-behind-{name}"));
        scene.mirrors[0].look = look.map(Into::into);
        let alone = studio.picture(&scene);
        let haunted = scene
            .object(
                Sphere::new(0.5).mesh().uv(32, 18),
                glass(),
                at(-0.4, 0.1, -0.6),
            )
            .object(Cuboid::from_length(0.8), glass(), at(0.6, 0.0, -0.41));
        let what = format!("glass-behind-{name}");
        studio.picture(&haunted).assert_same(&alone, &what);
    }
}
