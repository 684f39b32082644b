//! Projections at their limits.

use bevy::{camera::ScalingMode, prelude::*};

use super::{Case, rooms::scene, still_life::furnish};
use crate::support::scene::{Scene, Surface};

pub fn cases() -> Vec<Case> {
    vec![
        fov_1(),
        fov_179(),
        aspect(
            "aspect-0.01",
            "a picture 100 times as high as wide",
            UVec2::new(1, 100),
        ),
        aspect(
            "aspect-100",
            "a picture 100 times as wide as high",
            UVec2::new(100, 1),
        ),
        near(),
        orthographic_facing(),
        orthographic_grazing(),
    ]
}

fn still_life(scene: Scene) -> Scene {
    furnish(
        scene.mirror(Surface::wall(4.0, 3.0, Transform::default())),
        Transform::IDENTITY,
        1.0,
    )
}

fn fov_1() -> Case {
    let scene = scene("fov-1")
        .eye(Vec3::new(70.0, 30.0, 200.0), Vec3::ZERO)
        .fov(1.0);
    Case::new("fov-1", "through a telescope", still_life(scene))
}

/// Almost a half-space of view: the things are large and near, or they would be dots.
fn fov_179() -> Case {
    let scene = scene("fov-179")
        .eye(Vec3::new(0.6, 0.4, 3.0), Vec3::new(0.2, 0.1, 0.0))
        .fov(179.0)
        .mirror(Surface::wall(400.0, 300.0, Transform::default()));
    Case::new(
        "fov-179",
        "almost a half-space of view",
        furnish(
            scene,
            Transform::from_scale(Vec3::new(40.0, 40.0, 1.0)),
            1.0,
        ),
    )
}

fn aspect(name: &str, about: &str, size: UVec2) -> Case {
    let (fov, distance) = if size.x > size.y {
        (2.0, 3.0)
    } else {
        (60.0, 5.0)
    };
    let mut scene = scene(name)
        .eye(
            Vec3::new(0.2 * distance, 0.1 * distance, distance),
            Vec3::new(0.0, 0.0, 0.0),
        )
        .fov(fov);
    scene.size = size;
    Case::new(name, about, still_life(scene))
}

fn near() -> Case {
    let mut scene = scene("near-1e-6").eye(Vec3::new(1.4, 0.8, 5.0), Vec3::ZERO);
    scene.projection = PerspectiveProjection {
        near: 1e-6,
        ..default()
    }
    .into();
    Case::new(
        "near-1e-6",
        "a near plane a micrometer away",
        still_life(scene),
    )
}

fn orthographic(height: f32) -> Projection {
    OrthographicProjection {
        scaling_mode: ScalingMode::FixedVertical {
            viewport_height: height,
        },
        ..OrthographicProjection::default_3d()
    }
    .into()
}

fn orthographic_facing() -> Case {
    let mut scene = scene("ortho-facing").eye(Vec3::new(0.0, 0.0, 20.0), Vec3::ZERO);
    scene.projection = orthographic(3.6);
    Case::new(
        "ortho-facing",
        "an orthographic camera exactly square to the mirror",
        still_life(scene),
    )
}

/// The mirror, 20 long, is a strip a tenth of the picture high.
fn orthographic_grazing() -> Case {
    let angle = 0.1_f32.to_radians();
    let (sin, cos) = angle.sin_cos();
    let mut scene = scene("ortho-89.9")
        .eye(Vec3::new(20.0 * cos, 0.0, 20.0 * sin), Vec3::ZERO)
        .mirror(Surface::wall(20.0, 0.6, Transform::default()));
    scene.eye = Transform::from_translation(scene.eye.translation).looking_at(Vec3::ZERO, Vec3::Z);
    scene.projection = orthographic(0.12);
    Case::new(
        "ortho-89.9",
        "an orthographic camera 89.9 degrees off",
        furnish(scene, Transform::from_scale(Vec3::splat(0.03)), 1.0),
    )
}
