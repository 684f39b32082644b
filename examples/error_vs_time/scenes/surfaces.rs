//! Transforms at their limits: of the mirror, of the camera, of the whole world.

use bevy::prelude::*;

use super::{Case, rooms::scene, still_life::furnish};
use crate::support::scene::{Scene, Surface};

pub fn cases() -> Vec<Case> {
    vec![
        scaled(
            "scale-1e-3",
            "a mirror of 4000 units, scaled by 1/1000",
            1e-3,
        ),
        scaled("scale-1e3", "a mirror of 4 mm, scaled by 1000", 1e3),
        flattened(),
        negative(),
        scaled_camera(),
        moved("offset-1e3", "1000 units from the origin", 1e3, 1),
        moved("offset-1e4", "10 000 units from the origin", 1e4, 2).quick(),
        moved("offset-1e5", "100 000 units from the origin", 1e5, 8),
    ]
}

/// A tilted mirror of 4 by 3 units, whose mesh is smaller by the scale of its transform.
fn tilted(name: &str, scale: Vec3) -> Scene {
    let frame = Transform::from_xyz(0.5, 0.25, -0.5).with_rotation(Quat::from_euler(
        EulerRot::XYZ,
        -0.2,
        0.3,
        0.1,
    ));
    let size = Vec2::new(4.0, 3.0) / scale.truncate().abs();
    let scene = scene(name)
        .eye(Vec3::new(2.5, 1.5, 5.0), Vec3::new(0.5, 0.25, -0.5))
        .mirror(Surface::wall(size.x, size.y, frame.with_scale(scale)));
    furnish(scene, frame, 1.0)
}

fn scaled(name: &str, about: &str, scale: f32) -> Case {
    Case::new(name, about, tilted(name, Vec3::splat(scale)))
}

fn flattened() -> Case {
    Case::new(
        "flattened",
        "a mirror scaled by (1, 1, 0)",
        tilted("flattened", Vec3::new(1.0, 1.0, 0.0)),
    )
}

/// Its winding turns around, so the reference takes the rectangle that is the same one unscaled.
fn negative() -> Case {
    Case {
        exact: Some(tilted("negative", Vec3::ONE)),
        ..Case::new(
            "negative",
            "a mirror scaled by (-1, 1, 1)",
            tilted("negative", Vec3::new(-1.0, 1.0, 1.0)),
        )
    }
}

fn scaled_camera() -> Case {
    Case {
        camera_scale: 2.0,
        ..Case::new(
            "scaled-camera",
            "a camera parented to an entity scaled by 2",
            tilted("scaled-camera", Vec3::ONE),
        )
    }
}

/// All places are multiples of 1/64, which stay exact so far out; the reference is drawn at the
/// origin.
fn moved(name: &str, about: &str, offset: f32, slack: u32) -> Case {
    let mut near = tilted(name, Vec3::ONE);
    let grid = |place: Vec3| (place * 64.0).round() / 64.0;
    near.eye.translation = grid(near.eye.translation);
    near.mirrors[0].transform.translation = grid(near.mirrors[0].transform.translation);
    for object in &mut near.objects {
        object.transform.translation = grid(object.transform.translation);
    }
    let mut far = near.clone();
    let offset = Vec3::new(offset, offset * 0.25, -offset * 0.5);
    far.eye.translation += offset;
    far.mirrors[0].transform.translation += offset;
    for object in &mut far.objects {
        object.transform.translation += offset;
    }
    Case {
        exact: Some(near),
        slack,
        ..Case::new(name, about, far)
    }
}
