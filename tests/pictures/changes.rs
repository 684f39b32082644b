//! A scene in motion: each frame is right by itself, whatever was shown before it.
//!
//! The law in all of these: one frame after a change the picture is, to the bit, that of an app that
//! never knew the scene otherwise.

mod camera;
mod light;
mod motion;
mod presence;
mod surface;

use bevy::prelude::*;

use crate::support::{
    live::{Live, find, named, of, unclad},
    props::{BLUE, GREEN, RED, YELLOW, at, glass, lit, sun},
    scene::{Look, Scene, Surface},
};

/// A wall mirror; a box, a ball and a pane before it, a block behind it.
pub fn room(name: &str) -> Scene {
    let mut scene = Scene::new(name)
        .eye(vec3(0.5, 0.8, 3.0), vec3(0.0, 0.1, 0.0))
        .mirror(Surface::wall(3.0, 2.0, at(0.0, 0.2, 0.0)).look(unclad("mirror")))
        .object(
            Cuboid::new(0.5, 0.7, 0.3),
            named("box", RED),
            at(-0.6, 0.0, 0.7),
        )
        .object(
            Sphere::new(0.3).mesh().uv(16, 10),
            named("ball", GREEN),
            at(0.6, 0.5, 0.5),
        )
        .object(
            Cuboid::new(0.6, 0.4, 0.02),
            named("pane", glass(YELLOW, 0.5)),
            at(-0.1, 0.5, 0.9),
        )
        .object(
            Cuboid::from_length(0.8),
            named("block", BLUE),
            at(0.3, 0.3, -0.9),
        )
        .with_camera(Name::new("camera"));
    scene.size = UVec2::new(96, 72);
    scene
}

/// The room with a floor under a shadowed sun.
pub fn sunny_room(name: &str) -> Scene {
    let mut scene = room(name)
        .object(
            Cuboid::new(4.0, 0.1, 4.0),
            lit(Color::srgb(0.8, 0.8, 0.7)),
            at(0.0, -0.8, 0.0),
        )
        .prop((sun(true), Name::new("sun")));
    scene.objects[0].look = named("box", lit(RED));
    scene
}

fn place(world: &mut World, name: &str, transform: Transform) {
    *of::<Transform>(world, name) = transform;
}

fn insert(world: &mut World, name: &str, bundle: impl Bundle) {
    let entity = find(world, name);
    world.entity_mut(entity).insert(bundle);
}

fn remove<B: Bundle>(world: &mut World, name: &str) {
    let entity = find(world, name);
    world.entity_mut(entity).remove::<B>();
}

fn despawn(world: &mut World, name: &str) {
    let entity = find(world, name);
    world.despawn(entity);
}

fn add<A: Asset>(world: &mut World, asset: A) -> Handle<A> {
    world.resource_mut::<Assets<A>>().add(asset)
}

/// A look that is none, so that the mirror can be found by its name alone.
#[test]
fn a_named_mirror_reflects_as_any_other() {
    let mut bare = room("named");
    let named = Live::new(&bare).settled();
    bare.mirrors[0].look = None::<Look>;
    named.assert_same(&Live::new(&bare).settled(), "named");
}
