//! Lights, shadows and backgrounds that change.

use bevy::{core_pipeline::Skybox, prelude::*};

use super::{add, despawn, insert, place, remove, room, sunny_room};
use crate::support::{
    live::{assert_each_seen_at_once, of},
    props::{MAGENTA, YELLOW, six_colors},
};

#[test]
fn shadows_are_switched_on_and_off_in_the_reflection_too() {
    let shadows = |on| {
        move |world: &mut World| {
            of::<DirectionalLight>(world, "sun").shadow_maps_enabled = on;
        }
    };
    assert_each_seen_at_once(
        &sunny_room("shadows"),
        &[&shadows(false), &shadows(true), &shadows(false)],
    );
}

#[test]
fn a_light_that_moves_moves_its_shadows_in_the_reflection_too() {
    let shine = |from: Vec3| {
        let light = Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Y);
        move |world: &mut World| place(world, "sun", light)
    };
    assert_each_seen_at_once(
        &sunny_room("moving-light"),
        &[
            &shine(vec3(-1.0, 3.0, 1.0)),
            &shine(vec3(0.2, 2.0, 2.0)),
            &|world| despawn(world, "sun"),
        ],
    );
}

#[test]
fn a_skybox_comes_and_goes_in_the_reflection_too() {
    let sky = |world: &mut World| {
        let image = add(world, six_colors());
        let skybox = Skybox {
            image: Some(image),
            brightness: 600.0,
            ..default()
        };
        insert(world, "camera", skybox);
    };
    assert_each_seen_at_once(
        &room("skybox"),
        &[
            &sky,
            &|world| of::<Skybox>(world, "camera").rotation = Quat::from_rotation_y(1.0),
            &|world| remove::<Skybox>(world, "camera"),
        ],
    );
}

#[test]
fn the_clear_color_changes_in_the_reflection_too() {
    assert_each_seen_at_once(
        &room("clear-color"),
        &[
            &|world| world.resource_mut::<ClearColor>().0 = MAGENTA,
            &|world| of::<Camera>(world, "camera").clear_color = YELLOW.into(),
        ],
    );
}
