//! Mirrors, cameras and objects that come and go.

use bevy::prelude::*;
use bevy_planar_mirror::{NoMirrors, PlanarMirror};

use super::{add, despawn, insert, place, remove, room};
use crate::support::{
    live::{Live, assert_each_seen_at_once, assert_seen_at_once, find, of},
    props::at,
};

#[test]
fn what_is_hidden_is_gone_at_once_and_what_is_shown_is_back_at_once() {
    fn see(name: &'static str, visibility: Visibility) -> impl Fn(&mut World) {
        move |world| *of::<Visibility>(world, name) = visibility
    }
    let (hide, show) = (Visibility::Hidden, Visibility::Inherited);
    assert_each_seen_at_once(
        &room("hide-and-show"),
        &[
            &see("ball", hide),
            &see("mirror", hide),
            &see("ball", show),
            &see("mirror", show),
            &see("pane", hide),
            &see("pane", show),
        ],
    );
}

#[test]
fn what_is_despawned_is_gone_at_once() {
    assert_each_seen_at_once(
        &room("despawn"),
        &[
            &|world| despawn(world, "ball"),
            &|world| despawn(world, "pane"),
            &|world| despawn(world, "mirror"),
        ],
    );
}

#[test]
fn a_mirror_that_stops_being_one_is_a_mesh_again() {
    assert_each_seen_at_once(
        &room("no-mirror-any-more"),
        &[
            &|world| remove::<PlanarMirror>(world, "mirror"),
            &|world| insert(world, "mirror", PlanarMirror::default()),
            &|world| insert(world, "camera", NoMirrors),
            &|world| remove::<NoMirrors>(world, "camera"),
        ],
    );
}

#[test]
fn mirrors_come_and_go() {
    const NAMES: [&str; 4] = ["first", "second", "third", "fourth"];
    fn hang(index: usize) -> impl Fn(&mut World) {
        move |world| {
            let mesh = add(world, Rectangle::new(0.6, 0.8).into());
            let x = index as f32 * 0.7 - 1.0;
            let turn = Quat::from_rotation_y(0.3 - 0.2 * index as f32);
            world.spawn((
                Name::new(NAMES[index]),
                Mesh3d(mesh),
                at(x, 0.1, 0.3).with_rotation(turn),
                PlanarMirror::default(),
            ));
        }
    }
    let take = |index: usize| move |world: &mut World| despawn(world, NAMES[index]);
    assert_each_seen_at_once(
        &room("count"),
        &[
            &hang(0),
            &hang(1),
            &|world| (2..4).for_each(|index| hang(index)(world)),
            &take(1),
            &|world| despawn(world, "mirror"),
            &|world| {
                take(0)(world);
                hang(1)(world);
            },
            &|world| (1..4).for_each(|index| take(index)(world)),
            &hang(2),
        ],
    );
}

#[test]
fn a_camera_in_place_of_another_sees_its_own_reflection() {
    let other = Transform::from_xyz(-0.9, 0.4, 2.4).looking_at(vec3(0.0, 0.2, 0.0), Vec3::Y);
    let exchange = |world: &mut World| {
        let camera = find(world, "camera");
        let new = world.entity_mut(camera).clone_and_spawn();
        world.despawn(camera);
        *world.get_mut::<Transform>(new).expect("cloned") = other;
    };
    assert_seen_at_once(&room("another-camera"), exchange);
}

#[test]
fn a_camera_that_is_switched_off_and_on_shows_the_mirror_as_it_is_then() {
    let mut live = Live::new(&room("off-and-on"));
    live.settled();
    let switch = |world: &mut World, on: bool| of::<Camera>(world, "camera").is_active = on;
    switch(live.world(), false);
    for _ in 0..4 {
        live.next();
    }
    let mirror = at(0.0, 0.3, -0.3).with_rotation(Quat::from_rotation_y(0.2));
    place(live.world(), "mirror", mirror);
    live.next();
    switch(live.world(), true);
    let mut fresh = Live::new(&room("off-and-on"));
    place(fresh.world(), "mirror", mirror);
    live.next().assert_same(&fresh.settled(), "off-and-on");
}
