//! Mirrors, cameras and objects that move, jump, go through the plane or are handed on to a parent.

use bevy::{camera::visibility::NoFrustumCulling, prelude::*};

use super::{despawn, insert, place, remove, room};
use crate::support::{
    live::{Change, Live, assert_each_seen_at_once, assert_seen_at_once, find, of},
    props::at,
};

#[test]
fn a_mirror_and_a_camera_that_move_in_one_frame_are_both_seen_where_they_are() {
    let eye = Transform::from_xyz(-0.7, 0.5, 2.6).looking_at(vec3(0.1, 0.3, 0.0), Vec3::Y);
    let mirror = at(0.1, 0.1, -0.2).with_rotation(Quat::from_euler(EulerRot::YXZ, 0.2, -0.1, 0.05));
    assert_seen_at_once(&room("move-both"), |world| {
        place(world, "camera", eye);
        place(world, "mirror", mirror);
    });
}

#[test]
fn everything_moves_in_every_frame() {
    let moved: Vec<_> = (1..6)
        .map(|step| {
            move |world: &mut World| {
                let t = step as f32 * 0.15;
                let eye = vec3(0.5 - t, 0.8 - 0.3 * t, 3.0 - 0.4 * t);
                let eye = Transform::from_translation(eye).looking_at(Vec3::ZERO, Vec3::Y);
                place(world, "camera", eye);
                let turn = Quat::from_rotation_y(0.3 * t);
                place(world, "mirror", at(0.0, 0.2, -0.3 * t).with_rotation(turn));
                place(world, "box", at(-0.6 + 0.5 * t, 0.0, 0.7 - 0.9 * t));
                place(world, "ball", at(0.6, 0.5 - 0.4 * t, 0.5));
            }
        })
        .collect();
    let changes: Vec<Change> = moved.iter().map(|change| change as Change).collect();
    assert_each_seen_at_once(&room("move-all"), &changes);
}

#[test]
fn a_mirror_with_a_new_parent_goes_where_it_is_taken() {
    let lower = |world: &mut World| {
        let taken = Transform {
            translation: vec3(0.2, -0.2, -0.3),
            rotation: Quat::from_rotation_y(-0.3),
            scale: vec3(0.8, 1.2, 1.0),
        };
        let parent = world.spawn((taken, Visibility::default(), Name::new("parent")));
        let parent = parent.id();
        insert(world, "mirror", ChildOf(parent));
    };
    assert_each_seen_at_once(
        &room("reparent"),
        &[
            &lower,
            &|world| place(world, "parent", at(0.0, 0.3, -0.1)),
            &|world| remove::<ChildOf>(world, "mirror"),
            &|world| {
                let parent = find(world, "parent");
                insert(world, "camera", ChildOf(parent));
            },
            &|world| {
                let parent = find(world, "parent");
                remove::<ChildOf>(world, "camera");
                insert(world, "mirror", ChildOf(parent));
            },
            // The parent takes the mirror with it.
            &|world| despawn(world, "parent"),
        ],
    );
}

#[test]
fn an_object_that_passes_through_the_plane_is_cut_right_in_every_frame() {
    let steps: Vec<_> = (0..12)
        .map(|step| {
            // From well before to well behind, and through the touch on both sides.
            let z = 0.36 - 0.06 * step as f32;
            move |world: &mut World| place(world, "ball", at(0.3, 0.4, z))
        })
        .collect();
    let changes: Vec<Change> = steps.iter().map(|change| change as Change).collect();
    assert_each_seen_at_once(&room("through"), &changes);
}

/// What culling on the CPU leaves out of account may be on both sides of the plane.
#[test]
fn an_object_without_bounds_is_cut_at_the_plane_when_it_crosses() {
    assert_each_seen_at_once(
        &room("no-bounds"),
        &[
            &|world| {
                insert(world, "ball", NoFrustumCulling);
                place(world, "ball", at(0.2, 0.4, 0.1));
            },
            &|world| place(world, "ball", at(0.2, 0.4, -0.1)),
        ],
    );
}

#[test]
fn a_camera_that_jumps_a_million_units_and_back_sees_what_is_there() {
    let jump = |world: &mut World| of::<Transform>(world, "camera").translation += Vec3::splat(1e6);
    let back =
        |world: &mut World| of::<Transform>(world, "camera").translation = vec3(0.5, 0.8, 3.0);
    assert_each_seen_at_once(&room("jump"), &[&jump, &back]);
}

#[test]
fn a_mirror_that_jumps_a_million_units_and_back_shows_what_is_there() {
    let jump = |world: &mut World| place(world, "mirror", at(0.0, 1e6, -1e6));
    let back = |world: &mut World| place(world, "mirror", at(0.0, 0.2, 0.0));
    assert_each_seen_at_once(&room("mirror-jump"), &[&jump, &back]);
}

/// At a million units single precision leaves a sixteenth of a unit: coarse, but the same in every frame.
#[test]
fn a_world_that_jumps_a_million_units_and_back_is_whole_in_every_frame() {
    fn shift(by: f32) -> impl Fn(&mut World) {
        move |world| {
            let mut roots = world.query_filtered::<&mut Transform, Without<ChildOf>>();
            for mut transform in roots.iter_mut(world) {
                transform.translation.x += by;
            }
        }
    }
    let scene = room("world-jump");
    let mut live = Live::new(&scene);
    live.settled();
    shift(1e6)(live.world());
    // An app that never drew the mirror would not begin to here, at the limit of precision.
    let there = live.next();
    there.assert_same(&live.settled(), "world-jump-there");
    shift(-1e6)(live.world());
    let mut fresh = Live::new(&scene);
    shift(1e6)(fresh.world());
    shift(-1e6)(fresh.world());
    live.next().assert_same(&fresh.settled(), "world-jump-back");
}
