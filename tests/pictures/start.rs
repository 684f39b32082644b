//! Frames in which pipelines are still being compiled. They are held back here, so that there are
//! such frames on any machine.

use std::sync::{Arc, Mutex};

use bevy::{camera::Hdr, prelude::*, tasks::AsyncComputeTaskPool};

use crate::support::{
    live::{Live, find, of},
    mask::Mask,
    picture::Picture,
    props::{BLUE, GREEN, MAGENTA, RED, YELLOW, at},
    scene::{Scene, Surface},
    stage::Stage,
    studio::Studio,
};

/// Keeps the threads that compile from doing anything, until `during` is over.
fn while_nothing_is_compiled<T>(during: impl FnOnce() -> T) -> T {
    let gate = Arc::new(Mutex::new(()));
    let closed = gate.lock().expect("nobody panics with it");
    let pool = AsyncComputeTaskPool::get();
    for _ in 0..pool.thread_num() {
        let gate = gate.clone();
        pool.spawn(async move { drop(gate.lock()) }).detach();
    }
    let result = during();
    drop(closed);
    result
}

/// Things of one pipeline all around, so that the room is drawn whole or not at all. The clear color
/// shows nowhere.
fn room(name: &str) -> Scene {
    let mut scene = Scene::new(name)
        .eye(vec3(0.5, 0.8, 3.0), vec3(0.0, 0.1, 0.0))
        .mirror(Surface::wall(2.0, 1.5, at(0.0, 0.2, 0.0)))
        .object(Cuboid::new(0.5, 0.7, 0.3), RED, at(-0.6, 0.0, 0.7))
        .object(Cuboid::new(12.0, 9.0, 0.1), BLUE, at(0.0, 0.0, -1.5))
        .object(Cuboid::new(40.0, 30.0, 0.1), GREEN, at(0.0, 0.0, 8.0))
        .with_camera(Name::new("camera"));
    scene.clear_color = MAGENTA;
    scene.size = UVec2::new(96, 72);
    scene
}

/// Hides all meshes, or shows them.
fn see(world: &mut World, visibility: Visibility) {
    let mut meshes = world.query_filtered::<&mut Visibility, With<Mesh3d>>();
    for mut mesh in meshes.iter_mut(world) {
        *mesh = visibility;
    }
}

/// The pictures of the frames until nothing waits any more.
fn frames(live: &mut Live) -> Vec<Picture> {
    let mut pictures = Vec::new();
    let mut take = |live: &mut Live| {
        live.stage.frame();
        pictures.extend(live.stage.read(&live.target, live.size).ok());
    };
    while_nothing_is_compiled(|| (0..6).for_each(|_| take(live)));
    for _ in 0..3 {
        take(live);
        while live.stage.waiting_pipelines() > 0 {
            take(live);
        }
    }
    pictures
}

/// Where the room is drawn, the mirror is there whole or not at all.
#[track_caller]
fn assert_whole_or_not_there(pictures: &[Picture], whole: &Picture, none: &Picture, mask: &Mask) {
    let is_like = |picture: &Picture, other: &Picture, region: &dyn Fn(UVec2) -> bool| {
        let difference = picture.difference(other, 0, region);
        difference.is_ok_and(|it| it.beyond == 0)
    };
    assert!(!is_like(whole, none, &|_| true), "the mirror is not seen");
    let mut plain_frames = 0;
    for (frame, picture) in pictures.iter().enumerate() {
        // A part of the room may be drawn when its pipeline is there and the last step's is not.
        if !is_like(picture, whole, &|place| mask.outside(place)) {
            continue;
        }
        let inside = |place| mask.inside(place);
        let is_plain = is_like(picture, none, &inside);
        plain_frames += usize::from(is_plain);
        assert!(
            is_plain || is_like(picture, whole, &inside),
            "frame {frame} shows a part of the reflection: {}",
            picture.save("first-frame")
        );
    }
    let last = pictures.last().expect("there were frames");
    assert!(is_like(last, whole, &|_| true), "it comes to an end");
    println!("{plain_frames} of {} frames were plain", pictures.len());
}

#[test]
fn a_mirror_is_a_plain_mesh_until_what_shows_in_it_is_ready() {
    let scene = room("first-frames");
    let whole = Live::new(&scene).settled();
    let none = Live::plain(Stage::stock(), &scene).settled();
    let mask = Studio::default().mask(&scene, 0);
    // What the engine blocks on is there by then, as what puts the picture on the screen.
    let mut live = Live::new(&scene);
    see(live.world(), Visibility::Hidden);
    live.settled();
    see(live.world(), Visibility::Inherited);
    let pictures = frames(&mut live);
    assert_whole_or_not_there(&pictures, &whole, &none, &mask);
}

#[test]
fn it_is_so_too_when_a_camera_changes_how_it_draws() {
    let changes: [fn(&mut World); 2] = [
        |world| *of::<Msaa>(world, "camera") = Msaa::Sample4,
        |world| {
            let camera = find(world, "camera");
            world.entity_mut(camera).insert(Hdr);
        },
    ];
    for change in changes {
        let scene = room("changed-frames");
        let mut live = Live::new(&scene);
        live.settled();
        change(live.world());
        let pictures = frames(&mut live);
        let end = |mut live: Live| {
            change(live.world());
            live.settled()
        };
        let whole = end(Live::new(&scene));
        let none = end(Live::plain(Stage::stock(), &scene));
        let mask = Studio::default().mask(&scene, 0);
        assert_whole_or_not_there(&pictures, &whole, &none, &mask);
    }
}

/// What is new is missing as long as it is in the room, or some frames longer. Around it the
/// reflection stays.
#[test]
fn something_new_takes_nothing_away_from_the_reflection() {
    let scene = room("something-new");
    let mut live = Live::new(&scene);
    let before = live.settled();
    let add = |world: &mut World| {
        let mesh = world
            .resource_mut::<Assets<Mesh>>()
            .add(Cuboid::from_length(0.5));
        let material = world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(StandardMaterial {
                base_color: YELLOW,
                unlit: true,
                cull_mode: None,
                ..default()
            });
        world.spawn((Mesh3d(mesh), MeshMaterial3d(material), at(0.5, 0.3, 0.8)));
    };
    add(live.world());
    let pictures = frames(&mut live);
    let mut after = Live::new(&scene);
    add(after.world());
    let after = after.settled();
    for (frame, picture) in pictures.iter().enumerate() {
        for at in picture.places() {
            let [got, before, after] = [picture, &before, &after].map(|it| it.at(at.x, at.y));
            assert!(
                got == before || got == after,
                "frame {frame} shows {got:?} at {at}: {}",
                picture.save("something-new")
            );
        }
    }
    pictures
        .last()
        .expect("there were frames")
        .assert_same(&after, "something-new");
}
