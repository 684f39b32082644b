//! Rooms of few triangles and many lamps: what a frame costs there is the shading of its pixels.

use std::f32::consts::{FRAC_PI_2, PI};

use bevy::{light::CascadeShadowConfigBuilder, prelude::*};

use crate::{
    scenes,
    support::{
        props::{at, lit},
        scene::{Scene, Surface},
    },
};

/// From the eye to the plane before it in which the mirrors hang.
const DISTANCE: f32 = 3.0;
/// Half the angle of view, from top to bottom: that of the default camera.
const HALF_FOV: f32 = PI / 8.0;
const RATIO: f32 = 16.0 / 9.0;

/// What the eye sees of a plane square to its view, in meters.
fn seen_at(distance: f32) -> Vec2 {
    let height = 2.0 * HALF_FOV.tan() * distance;
    Vec2::new(height * RATIO, height)
}

/// The eye looks at a wall half a meter behind the origin. What mirrors there show stands behind
/// the eye: the rest of the room, with spheres and cubes in it.
pub fn room(height: u32, lamps: u16) -> Scene {
    let mut scene = Scene::new("room").eye(Vec3::Z * DISTANCE, Vec3::ZERO);
    scene.size = UVec2::new(height * 16 / 9, height);
    scene.ambient.brightness = 100.0;
    // Width, height, depth; the wall before the eye is at its back.
    let size = Vec3::new(8.0, 4.0, 9.0);
    let center = Vec3::new(0.0, 0.0, size.z / 2.0 - 0.5);
    let walls = [
        (Quat::IDENTITY, size.xy(), size.z, [0.7, 0.6, 0.5]),
        (
            Quat::from_rotation_y(PI),
            size.xy(),
            size.z,
            [0.4, 0.5, 0.7],
        ),
        (
            Quat::from_rotation_y(FRAC_PI_2),
            size.zy(),
            size.x,
            [0.7, 0.4, 0.4],
        ),
        (
            Quat::from_rotation_y(-FRAC_PI_2),
            size.zy(),
            size.x,
            [0.4, 0.7, 0.4],
        ),
        (
            Quat::from_rotation_x(-FRAC_PI_2),
            size.xz(),
            size.y,
            [0.5, 0.5, 0.5],
        ),
        (
            Quat::from_rotation_x(FRAC_PI_2),
            size.xz(),
            size.y,
            [0.8, 0.8, 0.8],
        ),
    ];
    for (turn, face, depth, [r, g, b]) in walls {
        let place = center - turn * Vec3::Z * (depth / 2.0);
        scene = scene.object(
            Rectangle::from_size(face),
            lit(Color::srgb(r, g, b)),
            Transform::from_translation(place).with_rotation(turn),
        );
    }
    for i in 0..12_u8 {
        let (column, row) = (f32::from(i % 4), f32::from(i / 4));
        let place = Vec3::new(
            column * 1.6 - 2.4,
            row * 1.1 - 1.2,
            4.5 + 0.4 * column + row,
        );
        let paint = lit(Color::hsl(30.0 * f32::from(i), 0.6, 0.6));
        let place = Transform::from_translation(place);
        scene = if i % 2 == 0 {
            scene.object(Sphere::new(0.4).mesh().uv(24, 14), paint, place)
        } else {
            let turned = place.with_rotation(Quat::from_euler(EulerRot::XYZ, 0.5, 0.4, 0.3));
            scene.object(Cuboid::from_length(0.6), paint, turned)
        };
    }
    for i in 0..lamps {
        let across = (f32::from(i) + 0.5) / f32::from(lamps);
        let light = PointLight {
            intensity: 600_000.0 / f32::from(lamps),
            range: 30.0,
            ..default()
        };
        let place = at(
            (across * 2.0 - 1.0) * 3.0,
            1.7,
            0.5 + 7.0 * (across * 2.4).fract(),
        );
        scene = scene.prop((light, place));
    }
    scene
}

/// An upright mirror square to the view, in its middle, over that share of the picture.
pub fn facing(share: f32) -> Surface {
    // The whole picture to its very edge.
    let scale = if share < 1.0 { share.sqrt() } else { 1.01 };
    let size = seen_at(DISTANCE) * scale;
    Surface::wall(size.x, size.y, Transform::default())
}

/// The mirror of [`facing`] turned away, or put out of view behind the eye.
pub fn turned_away(surface: Surface) -> Surface {
    let transform = Transform::from_rotation(Quat::from_rotation_y(PI));
    Surface {
        transform,
        ..surface
    }
}

/// See [`turned_away`].
pub fn out_of_view(surface: Surface) -> Surface {
    // It faces the wall before the eye, and so its front is towards the eye as well.
    let transform = at(0.0, 0.0, 2.0 * DISTANCE).with_rotation(Quat::from_rotation_y(PI));
    Surface {
        transform,
        ..surface
    }
}

/// A wall through which nothing of a mirror of [`facing`] is seen, halfway to it.
pub fn with_screen(scene: Scene, share: f32) -> Scene {
    let size = seen_at(DISTANCE / 2.0) * share.sqrt() * 1.1;
    scene.object(
        Rectangle::from_size(size),
        lit(Color::srgb(0.6, 0.6, 0.3)),
        at(0.0, 0.0, DISTANCE / 2.0),
    )
}

/// Four upright mirrors in four planes, each over a twentieth of the picture.
pub fn four_mirrors() -> [Surface; 4] {
    let seen = seen_at(DISTANCE);
    let size = seen * 0.05_f32.sqrt();
    [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].map(|(x, y)| {
        let place = at(x * seen.x / 5.0, y * seen.y / 5.0, 0.0);
        let turn = Quat::from_euler(EulerRot::YXZ, -0.1 * x, 0.1 * y, 0.0);
        Surface::wall(size.x, size.y, place.with_rotation(turn))
    })
}

/// Sixty mirrors of which the eye sees none: out of view, or with their backs to it.
pub fn sixty_unseen() -> impl Iterator<Item = Surface> {
    (0..60_u8).map(|i| {
        let (column, row) = (f32::from(i % 10), f32::from(i / 10));
        let mirror = Surface::wall(0.25, 0.25, Transform::default());
        let place = Vec3::new(column * 0.4 - 1.8, row * 0.35 - 0.9, 0.0);
        let away = Quat::from_rotation_y(PI + 0.02 * f32::from(i));
        let transform = match i % 2 {
            0 => Transform::from_translation(place - Vec3::Z * 0.1).with_rotation(away),
            _ => Transform::from_translation(place + Vec3::Z * 7.0).with_rotation(away),
        };
        Surface {
            transform,
            ..mirror
        }
    })
}

/// Of a floor mirror before the eye.
const FLOOR: Vec2 = Vec2::new(4.0, 2.0);
const FLOOR_PLACE: Vec3 = Vec3::new(0.0, -0.8, 0.8);

/// The room with things over that place.
pub fn furnished_floor(height: u32, lamps: u16) -> Scene {
    let mut scene = room(height, lamps);
    for i in 0..5_u8 {
        let across = f32::from(i) - 2.0;
        let place = FLOOR_PLACE + Vec3::new(0.6 * across, 0.35, 0.25 * (across.abs() - 1.5));
        let paint = lit(Color::hsl(70.0 * f32::from(i), 0.6, 0.6));
        scene = scene.object(
            Sphere::new(0.2).mesh().uv(24, 14),
            paint,
            Transform::from_translation(place),
        );
    }
    scene
}

/// One mirror on the floor.
pub fn floor() -> Surface {
    Surface::floor(FLOOR.x, FLOOR.y, Transform::from_translation(FLOOR_PLACE))
}

/// Fifty that make up the same.
pub fn tiles() -> impl Iterator<Item = Surface> {
    let tile = FLOOR / Vec2::new(10.0, 5.0);
    (0..50_u8).map(move |i| {
        let step = Vec2::new(f32::from(i % 10) + 0.5, f32::from(i / 10) + 0.5);
        let place = step * tile - FLOOR / 2.0;
        let place = FLOOR_PLACE + Vec3::new(place.x, 0.0, place.y);
        Surface::floor(tile.x, tile.y, Transform::from_translation(place))
    })
}

/// Two mirrors that face each other, the eye close before the second. Each reflection of the one
/// in the other covers about half the pixels of the one before: it is farther away, and from the
/// third on the picture's sides no longer limit it.
pub fn facing_mirrors(height: u32, lamps: u16) -> Scene {
    const APART: f32 = 2.0;
    let eye = 0.9 * APART;
    let mut scene = room(height, lamps);
    scene.eye = at(0.0, 0.0, eye);
    let size = Vec2::new(seen_at(eye + APART).x, seen_at(eye).y * 0.9);
    let opposite = at(0.0, 0.0, APART).with_rotation(Quat::from_rotation_y(PI));
    scene
        .mirror(Surface::wall(size.x, size.y, Transform::default()))
        .mirror(Surface::wall(size.x, size.y, opposite))
}

/// The table of the teapot under a sun, whose shadows fall in Bevy's four cascades.
pub fn teapot(height: u32, shadows: bool) -> Result<Scene, String> {
    let all = scenes::all();
    let case = all.into_iter().find(|case| case.name == "teapot");
    let mut scene = case.ok_or("there is no teapot")?.sized(height).scene;
    scene.props.clear();
    let light = DirectionalLight {
        illuminance: 6000.0,
        shadow_maps_enabled: shadows,
        ..default()
    };
    let cascades = CascadeShadowConfigBuilder::default().build();
    let from = Transform::from_xyz(2.2, 3.4, 0.8).looking_at(Vec3::new(0.0, -1.0, -3.0), Vec3::Y);
    Ok(scene.prop((light, cascades, from)))
}
