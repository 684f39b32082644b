//! The named extremes of where a mirror and an eye can be: head-on, grazing, in the plane, behind it, far away, tiny,
//! huge, partly out of view.

use std::f32::consts::FRAC_PI_4;

use bevy::prelude::*;
use bevy_planar_mirror::{MirrorState, NotDrawn};

use super::cameras::states;
use crate::support::{
    hall::{hall, sunny_hall},
    props::{BLUE, GREEN, MAGENTA, RED, YELLOW, at},
    scene::{Scene, Surface},
    studio::{SHARE_FAR_AWAY, Studio, TOLERANCE, assert_reflects},
};

/// An eye straight before the middle of the hall's mirror: the plane's normal in the view is (0, 0, -1), to the bit
/// or almost. The engine's own near clip plane is ignored there.
#[test]
fn head_on_and_a_hair_beside_reflect_alike() {
    let mut studio = Studio::default();
    for (name, turn) in [
        ("exact", 0.0),
        ("hair-right", 1e-7),
        ("hair-left", -1e-7),
        ("little", 1e-3),
    ] {
        for lit in [false, true] {
            let name = format!("head-on-{name}-{lit}");
            let mut scene = if lit { sunny_hall(&name) } else { hall(&name) };
            scene.eye = at(0.0, 0.5, 4.0).with_rotation(Quat::from_rotation_y(turn));
            studio.assert_reflects(&scene);
        }
    }
}

/// Straight up and down, where directions to look at have no up of their own.
#[test]
fn a_floor_seen_from_straight_above_reflects() {
    let mut scene = Scene::new("straight-down")
        .mirror(Surface::floor(3.0, 3.0, Transform::default()))
        .object(Cuboid::from_length(0.5), RED, at(-0.7, 0.5, 0.3))
        .object(Cuboid::new(0.4, 0.8, 0.4), GREEN, at(0.5, 0.1, -0.4))
        .object(Cuboid::from_length(0.8), BLUE, at(0.2, 6.0, 0.8));
    scene.eye = at(0.0, 4.0, 0.0).looking_at(Vec3::ZERO, Vec3::NEG_Z);
    assert_reflects(&scene);
}

/// Where the engine's own near clip plane divides by zero.
#[test]
fn forty_five_degrees_off_with_a_square_view_of_ninety_degrees_reflects() {
    let mut studio = Studio::default();
    for (name, yaw) in [("left", FRAC_PI_4), ("right", -FRAC_PI_4)] {
        let mut scene = hall(&format!("forty-five-{name}")).fov(90.0);
        scene.size = uvec2(120, 120);
        scene.objects[0].transform = at(-1.2, 0.4, 0.7);
        scene.objects[1].transform = at(1.2, 0.2, 0.7);
        scene.eye = at(1.3 * yaw.signum(), 0.6, 1.6).with_rotation(Quat::from_rotation_y(yaw));
        studio.assert_reflects(&scene);
    }
    for (name, pitch) in [("down", -FRAC_PI_4), ("up", FRAC_PI_4)] {
        let mut scene = hall(&format!("forty-five-{name}")).fov(90.0);
        scene.size = uvec2(120, 120);
        scene.objects[0].transform = at(-1.2, 0.4, 0.7);
        scene.objects[1].transform = at(1.2, 0.2, 0.7);
        scene.eye =
            at(0.0, 0.5 - 1.3 * pitch.signum(), 1.6).with_rotation(Quat::from_rotation_x(pitch));
        studio.assert_reflects(&scene);
    }
}

/// A few pixels high, though it is forty units long.
#[test]
fn a_mirror_seen_at_a_grazing_angle_reflects() {
    let mut studio = Studio::default();
    for height in [0.5, 0.1, 0.03] {
        let mut scene = Scene::new(&format!("grazing-{height}"))
            .eye(vec3(0.0, height, 0.0), vec3(0.0, 0.0, -6.0))
            .mirror(Surface::floor(30.0, 40.0, at(0.0, 0.0, -21.0)))
            .object(Cuboid::new(1.0, 2.0, 1.0), RED, at(-2.0, 1.3, -9.0))
            .object(Cuboid::new(1.0, 1.0, 1.0), GREEN, at(1.5, 0.2, -8.0))
            .object(Cuboid::new(60.0, 4.0, 1.0), BLUE, at(0.0, 3.0, -45.0))
            .object(Cuboid::new(4.0, 4.0, 4.0), MAGENTA, at(0.0, -3.0, -20.0));
        scene.size = uvec2(160, 90);
        studio.assert_small_reflects(&scene, 40);
    }
}

#[track_caller]
fn assert_not_drawn(studio: &mut Studio, scene: &Scene, reasons: &[NotDrawn]) {
    studio.assert_no_mirror(scene);
    let states = states(studio.stage());
    let expected = |state: &MirrorState| matches!(state, MirrorState::NotDrawn(reason) if reasons.contains(reason));
    assert!(
        states.len() == 1 && states.iter().all(expected),
        "{}: {states:?}",
        scene.name
    );
}

#[test]
fn an_eye_in_the_plane_sees_no_reflection() {
    let mut studio = Studio::default();
    for (name, height) in [
        ("exact", 0.0),
        ("above", 1e-7),
        ("below", -1e-7),
        ("little-below", -1e-4),
    ] {
        let scene = Scene::new(&format!("in-the-plane-{name}"))
            .eye(vec3(0.0, height, 4.0), vec3(0.0, height, 0.0))
            .mirror(Surface::floor(4.0, 4.0, Transform::default()).look(MAGENTA))
            .object(Cuboid::from_length(1.0), RED, at(-1.0, 0.6, 0.0))
            .object(Cuboid::from_length(1.0), BLUE, at(1.0, 0.0, 0.0));
        let reasons = [NotDrawn::EyeBehind, NotDrawn::TooThin, NotDrawn::OutOfView];
        assert_not_drawn(&mut studio, &scene, &reasons);
    }
}

#[test]
fn an_eye_behind_the_mirror_sees_no_reflection() {
    let mut studio = Studio::default();
    let scene = hall("behind").eye(vec3(0.4, 0.8, -1.3), vec3(0.0, 0.4, 0.5));
    assert_not_drawn(&mut studio, &scene, &[NotDrawn::EyeBehind]);
    let mut scene = hall("behind-orthographic").eye(vec3(0.4, 0.8, -1.3), vec3(0.0, 0.4, 0.5));
    scene.projection = OrthographicProjection {
        scaling_mode: bevy::camera::ScalingMode::FixedVertical {
            viewport_height: 3.0,
        },
        ..OrthographicProjection::default_3d()
    }
    .into();
    assert_not_drawn(&mut studio, &scene, &[NotDrawn::EyeBehind]);
}

#[test]
fn a_mirror_out_of_view_is_not_drawn() {
    let mut studio = Studio::default();
    for (name, at) in [
        ("behind-the-eye", vec3(0.9, 1.2, 9.0)),
        ("beside", vec3(9.0, 1.0, 3.0)),
    ] {
        // Something must be seen: a picture of nothing is none.
        let seen = Transform::from_translation(at);
        let scene = hall(&format!("out-of-view-{name}"))
            .eye(vec3(0.9, 1.2, 4.0), at)
            .object(Cuboid::from_length(0.3), MAGENTA, seen);
        assert_not_drawn(&mut studio, &scene, &[NotDrawn::OutOfView]);
    }
}

fn moved(mut scene: Scene, by: Vec3) -> Scene {
    scene.eye.translation += by;
    for mirror in &mut scene.mirrors {
        mirror.transform.translation += by;
    }
    for object in &mut scene.objects {
        object.transform.translation += by;
    }
    scene
}

/// The steps of single precision are a thousandth of a unit there at the most, so an edge may move by some
/// hundredths of a pixel: few enough of these have a pixel's center in them.
#[test]
fn mirrors_far_from_the_origin_reflect() {
    let mut studio = Studio::default();
    for (name, place) in [
        ("thousand", vec3(1000.0, 0.0, 0.0)),
        ("thousand-aslant", vec3(-600.0, 500.0, 700.0)),
        ("ten-thousand", vec3(0.0, 0.0, 10_000.0)),
        ("ten-thousand-aslant", vec3(6000.0, -5000.0, 7000.0)),
    ] {
        let scene = moved(hall(&format!("far-{name}")), place);
        let picture = studio.picture(&scene);
        let mask = studio.mask(&scene, 0);
        let reference = studio.reference(&scene, 0);
        let inside = |place| mask.inside(place);
        picture.assert_alike(&reference, TOLERANCE, SHARE_FAR_AWAY, inside, &scene.name);
        studio.assert_untouched_outside(&scene, &picture);
        let near = studio.picture(&hall("near-the-origin"));
        picture.assert_alike(
            &near,
            TOLERANCE,
            0.99,
            |_| true,
            &format!("{}-near", scene.name),
        );
    }
}

/// The same mirror in the world from meshes of very different sizes.
#[test]
fn mirrors_of_any_scale_reflect_alike() {
    let mut studio = Studio::default();
    let expected = studio.assert_reflects(&hall("unscaled-mirror"));
    for (name, scale) in [
        ("thousandth", Vec3::splat(1e-3)),
        ("thousandfold", Vec3::splat(1e3)),
        ("flattened", vec3(1.0, 1.0, 0.0)),
        ("uneven", vec3(1e-2, 1e2, 7.0)),
        ("upside-down", vec3(-1.0, -1.0, 1.0)),
    ] {
        let mut scene = hall(&format!("mirror-scaled-{name}"));
        let size = vec2(3.2, 2.2) / scale.truncate().abs();
        scene.mirrors[0] = Surface::wall(size.x, size.y, at(0.0, 0.5, 0.0).with_scale(scale));
        let picture = studio.assert_reflects(&scene);
        picture.assert_alike(&expected, TOLERANCE, 0.9995, |_| true, &scene.name);
    }
}

#[test]
fn a_floor_larger_than_the_view_reflects_from_just_above_it() {
    let mut studio = Studio::default();
    for (height, pitch) in [(0.01, -0.02), (0.01, -0.4), (1.0, -0.1), (0.01, 0.1)] {
        let name = format!("floor-{height}-{pitch}");
        let mut scene = Scene::new(&name)
            .fov(60.0)
            .mirror(Surface::floor(4000.0, 4000.0, Transform::default()))
            .object(Cuboid::new(0.3, 0.3, 0.3), RED, at(-0.4, 0.16, -1.5))
            .object(Cuboid::new(2.0, 2.0, 2.0), GREEN, at(2.0, 0.4, -8.0))
            .object(
                Cuboid::new(100.0, 160.0, 40.0),
                BLUE,
                at(-150.0, 81.0, -700.0),
            )
            .object(
                Cuboid::new(80.0, 60.0, 40.0),
                YELLOW,
                at(200.0, 0.0, -500.0),
            )
            .object(
                Cuboid::new(30.0, 30.0, 30.0),
                MAGENTA,
                at(0.0, -40.0, -100.0),
            );
        scene.eye = at(0.0, height, 0.0).with_rotation(Quat::from_rotation_x(pitch));
        studio.assert_reflects(&scene);
    }
}

/// The plane goes on behind the eye, where a point of it has no place on the screen.
#[test]
fn a_mirror_partly_behind_the_eye_reflects() {
    let mut studio = Studio::default();
    // A long wall to the right of the eye, from far behind it to far before it.
    for (name, yaw) in [("along", 0.0), ("towards", -0.5), ("away", 0.3)] {
        let mut scene = Scene::new(&format!("behind-the-eye-{name}"))
            .fov(75.0)
            .mirror(Surface::wall(
                40.0,
                3.0,
                at(1.0, 0.0, 0.0)
                    .with_rotation(Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2)),
            ))
            .object(Cuboid::from_length(0.8), RED, at(0.0, -0.4, -4.0))
            .object(Cuboid::from_length(0.8), GREEN, at(1.1, 0.6, -5.0))
            .object(Cuboid::from_length(1.5), BLUE, at(-2.5, 0.6, -9.0))
            .object(Cuboid::from_length(2.0), YELLOW, at(2.8, 0.0, -4.0));
        scene.eye = at(0.0, 0.1, 0.0).with_rotation(Quat::from_rotation_y(yaw));
        studio.assert_reflects(&scene);
    }
}

#[test]
fn a_mirror_of_a_few_pixels_reflects() {
    let mut studio = Studio::default();
    for (pixels, least) in [(12.0, 60), (5.0, 6), (3.2, 1)] {
        let mut scene = hall(&format!("tiny-{pixels}"));
        // At the eye's distance, about 36 pixels of the picture are one unit.
        let size = pixels / 36.0;
        scene.mirrors[0] = Surface::wall(size, size, at(-0.1, 0.05, 0.5));
        let picture = studio.assert_small_reflects(&scene, least);
        let plain = studio.without_mirrors(&scene);
        let changed = picture.difference(&plain, 0, |_| true).expect("one size");
        let area = (pixels * pixels) as usize;
        assert!(
            (area / 2..area * 2).contains(&changed.beyond),
            "{pixels} pixels: {changed}"
        );
    }
}

/// By and by into the view, over each of the four edges.
#[test]
fn a_mirror_entering_at_an_edge_of_the_screen_reflects_as_far_as_it_is_seen() {
    let mut studio = Studio::default();
    let mut seen = Vec::new();
    for (name, axis, turns) in [
        ("left", Vec3::Y, [-0.62, -0.5, -0.38]),
        ("right", Vec3::Y, [0.66, 0.5, 0.38]),
        ("bottom", Vec3::X, [0.55, 0.45, 0.35]),
        ("top", Vec3::X, [-0.55, -0.45, -0.35]),
    ] {
        for (step, turn) in turns.into_iter().enumerate() {
            let mut scene = hall(&format!("entering-{name}-{step}"));
            scene.mirrors[0] = Surface::wall(1.6, 1.6, at(0.0, 0.4, 0.0));
            scene.eye = at(0.0, 0.4, 4.0).with_rotation(Quat::from_axis_angle(axis, turn));
            let count = studio.mask(&scene, 0).inside_count();
            studio.assert_small_reflects(&scene, 1);
            seen.push(count);
        }
    }
    assert!(
        seen.chunks(3)
            .all(|step| step[0] < step[1] && step[1] < step[2]),
        "not by and by: {seen:?}"
    );
}
