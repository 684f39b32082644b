//! A camera that moves in the smallest steps: no picture pops, and what is decided anew in every frame changes once.

use std::f32::consts::FRAC_PI_2;

use bevy::{camera::ScalingMode, prelude::*};
use bevy_planar_mirror::{
    MirrorClip, MirrorState, NotDrawn,
    status::Projection::{Oblique, Plain},
};

use super::cameras::states;
use crate::support::{
    hall::sunny_hall,
    live::Live,
    picture::Picture,
    props::{BLUE, GREEN, RED, at, lit, sun},
    scene::{Scene, Surface},
    studio::TOLERANCE,
};

const SIZE: UVec2 = uvec2(96, 72);
/// In radians and in units.
const TURN: f64 = 1e-7;
const MOVE: f64 = 1e-6;
const STEPS: i32 = 10;

/// How far rounding may move what is drawn between two frames, in pixels: both may be wrong by what the cut may be.
const ROUNDING_PX: f64 = 2.0 * 0.01;
/// What is left uncut behind the plane shows no larger than that.
const GHOST_PX: f64 = 0.25;
/// What is thinner is not drawn, if the mirror was not drawn before; and if it was.
const THIN_PX: f64 = 0.5;
const STILL_THIN_PX: f64 = 0.25;

/// The camera along its way, by units or radians.
type Way<'a> = &'a dyn Fn(f64) -> Transform;

type Question = fn(MirrorState) -> bool;

#[derive(Debug)]
struct Swept {
    /// Each once in a row.
    states: Vec<MirrorState>,
    /// The most pixels that changed where the state did not.
    moved: usize,
    /// And where it did.
    popped: usize,
    /// Pixels along edges.
    edges: usize,
}

fn show(live: &mut Live, pose: Transform) -> (Picture, MirrorState) {
    let camera = live.camera;
    live.world().entity_mut(camera).insert(pose);
    let picture = live.next();
    let [state] = states(&mut live.stage)[..] else {
        panic!("one mirror, one camera");
    };
    (picture, state)
}

fn sweep(live: &mut Live, poses: impl Iterator<Item = Transform>) -> Swept {
    let frames: Vec<_> = poses.map(|pose| show(live, pose)).collect();
    let mut swept = Swept {
        states: frames.iter().map(|(_, state)| *state).collect(),
        moved: 0,
        popped: 0,
        edges: edges(&frames[0].0),
    };
    for pair in frames.windows(2) {
        let [(before, old), (after, new)] = pair else {
            continue;
        };
        let difference = after.difference(before, TOLERANCE, |_| true);
        let changed = difference.expect("one size").beyond;
        let most = if old == new {
            &mut swept.moved
        } else {
            &mut swept.popped
        };
        *most = changed.max(*most);
    }
    swept.states.dedup();
    swept
}

/// The pixels that are not like the next one in their row or column.
fn edges(picture: &Picture) -> usize {
    let unlike = |a: UVec2, b: UVec2| {
        let (a, b) = (picture.at(a.x, a.y), picture.at(b.x, b.y));
        a.iter().zip(b).any(|(a, b)| a.abs_diff(b) > TOLERANCE)
    };
    let last = picture.size() - 1;
    let places = picture.places();
    places
        .filter(|place| {
            unlike(*place, (*place + UVec2::X).min(last))
                || unlike(*place, (*place + UVec2::Y).min(last))
        })
        .count()
}

/// There and back again, from `middle - STEPS` steps on.
#[track_caller]
fn assert_continuous(
    what: &str,
    live: &mut Live,
    way: Way,
    (middle, step): (f64, f64),
    pop: f64,
) -> Vec<MirrorState> {
    let pose = |i: i32| way(middle + f64::from(i) * step);
    let there = sweep(live, (-STEPS..=STEPS).map(pose));
    let back = sweep(live, (-STEPS..=STEPS).rev().map(pose));
    println!("{what}: {there:?}, back {back:?}");
    for swept in [&there, &back] {
        assert!(swept.states.len() <= 2, "{what}: {:?}", swept.states);
        assert!(swept.edges > 50, "{what}: hardly anything is seen");
        let allowed = ROUNDING_PX * swept.edges as f64;
        assert!(swept.moved as f64 <= allowed, "{what}: {swept:?}");
        assert!(swept.popped as f64 <= pop + allowed, "{what}: {swept:?}");
    }
    there.states
}

/// Where from 0 on the answer changes, in a frame after one at 0.
#[track_caller]
fn boundary(live: &mut Live, way: Way, (end, step): (f64, f64), ask: Question) -> f64 {
    let first = ask(show(live, way(0.0)).1);
    let mut is_as_at_first = |t: f64| {
        show(live, way(0.0));
        ask(show(live, way(t)).1) == first
    };
    assert!(!is_as_at_first(end), "it is {first} all the way");
    let (mut low, mut high) = (0.0, end);
    while high - low > 0.5 * step {
        let middle = 0.5 * (low + high);
        if is_as_at_first(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    show(live, way(0.0));
    high
}

fn is_drawn(state: MirrorState) -> bool {
    matches!(state, MirrorState::Drawn(_))
}

fn is_cut(state: MirrorState) -> bool {
    state == MirrorState::Drawn(Oblique)
}

fn small(mut scene: Scene) -> Scene {
    scene.size = SIZE;
    scene
}

#[test]
fn a_camera_passes_through_head_on() {
    let mut scene = small(sunny_hall("through-head-on"));
    let eye = at(0.0, 0.5, 4.0);
    scene.eye = eye;
    let mut flat = scene.clone();
    flat.projection = OrthographicProjection {
        scaling_mode: ScalingMode::FixedVertical {
            viewport_height: 3.0,
        },
        ..OrthographicProjection::default_3d()
    }
    .into();
    let mut live = Live::new(&scene);
    for (lens, scene) in [("perspective", &scene), ("orthographic", &flat)] {
        live = live.again(scene);
        live.settled();
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            let turned = |t: f64| eye.with_rotation(Quat::from_axis_angle(axis, t as f32));
            let moved = |t: f64| {
                let place = eye.translation.as_dvec3() + axis.as_dvec3() * t;
                eye.with_translation(place.as_vec3())
            };
            let ways: [(&str, Way, f64); 2] = [("turned", &turned, TURN), ("moved", &moved, MOVE)];
            for (how, way, step) in ways {
                let what = format!("head-on, {lens}, {how} about {axis}");
                let states = assert_continuous(&what, &mut live, way, (0.0, step), 0.0);
                assert_eq!(states, [MirrorState::Drawn(Oblique)], "{what}");
            }
        }
    }
}

/// What the sweeps are judged by must not pass a picture that pops.
#[test]
fn steps_that_can_be_seen_are_found() {
    let scene = small(sunny_hall("steps"));
    let mut live = Live::new(&scene);
    live.settled();
    let aside = |i: i32| {
        let place = scene.eye.translation + Vec3::X * (0.01 * i as f32);
        scene.eye.with_translation(place)
    };
    let swept = sweep(&mut live, (-2..=2).map(aside));
    let allowed = ROUNDING_PX * swept.edges as f64;
    assert!(swept.moved as f64 > allowed, "{swept:?}");
}

/// A mirror that lies in the plane z = 0 of `frame`, with something on it and something across.
fn lying(name: &str, frame: Transform, size: Vec2) -> Scene {
    let on = |place: Transform| frame * place;
    let mut scene = small(Scene::new(name))
        .mirror(Surface::wall(size.x, size.y, frame))
        .object(Cuboid::from_length(0.8), lit(RED), on(at(-0.8, 0.5, 0.6)))
        .object(Cuboid::from_length(0.7), lit(GREEN), on(at(0.7, 0.2, 0.1)))
        .object(Cuboid::new(9.0, 0.2, 5.0), lit(BLUE), on(at(0.0, 5.0, 2.5)))
        .prop(sun(false));
    scene.ambient.brightness = 200.0;
    scene
}

/// In the frame of such a mirror: along it, with the mirror's front up, a little rolled.
fn along(frame: Transform, place: Vec3, roll: f32) -> Transform {
    let look = Quat::from_rotation_x(FRAC_PI_2) * Quat::from_rotation_z(roll);
    frame * Transform::from_translation(place).with_rotation(look)
}

fn frames() -> [(&'static str, Transform); 2] {
    let tilted = Quat::from_euler(EulerRot::XYZ, 0.4, -0.9, 1.3);
    [
        ("at the origin", Transform::default()),
        ("ten units away", at(7.0, -2.0, 5.0).with_rotation(tilted)),
    ]
}

#[test]
fn a_camera_sinks_through_the_plane() {
    let mut live = Live::new(&lying("sinking", default(), vec2(4.0, 4.0)));
    for (place, frame) in frames() {
        live = live.again(&lying("sinking", frame, vec2(4.0, 4.0)));
        live.settled();
        let down = |t: f64| along(frame, vec3(0.1, -4.0, -t as f32), 0.3);
        let what = format!("through the plane {place}");
        let states = assert_continuous(&what, &mut live, &down, (0.0, MOVE), 0.0);
        assert_eq!(
            states.last(),
            Some(&MirrorState::NotDrawn(NotDrawn::EyeBehind)),
            "{what}"
        );
        let turning = |t: f64| {
            let pose = along(frame, vec3(0.1, -4.0, 0.0), 0.3);
            pose.with_rotation(pose.rotation * Quat::from_rotation_x(t as f32))
        };
        let what = format!("in the plane, turning, {place}");
        assert_continuous(&what, &mut live, &turning, (0.0, TURN), 0.0);
    }
}

#[test]
fn a_camera_sinks_until_the_mirror_is_too_thin() {
    let mut live = Live::new(&lying("thin", default(), vec2(4.0, 4.0)));
    for (place, frame) in frames() {
        live = live.again(&lying("thin", frame, vec2(4.0, 4.0)));
        live.settled();
        let height = |t: f64| along(frame, vec3(0.1, -4.0, t as f32), 0.3);
        let down = |t: f64| height(0.2 - t);
        let up = |t: f64| height(0.0001 + t);
        let ways: [(&str, Way, f64); 2] = [("down", &down, STILL_THIN_PX), ("up", &up, THIN_PX)];
        for (how, way, thin) in ways {
            let middle = boundary(&mut live, way, (0.199, MOVE), is_drawn);
            let what = format!("too thin, {how} by {middle} {place}");
            let pop = thin * f64::from(SIZE.x);
            let states = assert_continuous(&what, &mut live, way, (middle, MOVE), pop);
            assert_eq!(states.len(), 2, "{what}: {states:?}");
            assert!(
                states.contains(&MirrorState::NotDrawn(NotDrawn::TooThin)),
                "{what}: {states:?}"
            );
        }
    }
}

/// Cut whatever crosses it or not, and with posts all around the place from which it is seen.
fn surrounded(frame: Transform) -> Scene {
    let mut scene = lying("leaving", frame, vec2(4.0, 4.0));
    scene.mirrors[0].mirror.clip = MirrorClip::Oblique;
    for post in 0..8 {
        let (sin, cos) = (0.8 * post as f32).sin_cos();
        let place = frame * at(6.0 * sin, 6.0 * cos - 4.0, 1.5);
        scene = scene.object(Cuboid::new(0.4, 0.4, 8.0), lit(RED), place);
    }
    scene
}

#[test]
fn a_camera_turns_until_the_mirror_is_out_of_view() {
    let mut live = Live::new(&surrounded(default()));
    for (place, frame) in frames() {
        live = live.again(&surrounded(frame));
        live.settled();
        let eye = along(frame, vec3(0.1, -4.0, 1.5), 0.3);
        let yaw = |t: f64| eye.with_rotation(eye.rotation * Quat::from_rotation_y(t as f32));
        let out = |t: f64| yaw(0.55 + t);
        let into = |t: f64| yaw(2.05 - t);
        let ways: [(&str, Way, f64); 2] =
            [("out of", &out, STILL_THIN_PX), ("into", &into, THIN_PX)];
        for (how, way, thin) in ways {
            let middle = boundary(&mut live, way, (1.5, TURN), is_drawn);
            let what = format!("turned {how} view by {middle} {place}");
            let pop = thin * f64::from(SIZE.y);
            let states = assert_continuous(&what, &mut live, way, (middle, TURN), pop);
            assert_eq!(states.len(), 2, "{what}: {states:?}");
        }
    }
}

/// The red box reaches behind the plane by what shows as a quarter of a pixel from somewhere on the way.
#[test]
fn a_camera_comes_close_enough_to_see_that_something_is_cut() {
    let scene = |frame: Transform| {
        let mut scene = lying("touching", frame, vec2(4.0, 4.0));
        scene.objects[0].transform = frame * at(-0.8, 0.5, 0.4 - 0.01);
        scene.objects[1].transform = frame * at(0.7, 0.2, 1.0);
        scene
    };
    let mut live = Live::new(&scene(default()));
    for (place, frame) in frames() {
        live = live.again(&scene(frame));
        live.settled();
        let away = |back: f64| along(frame, vec3(0.1, -back as f32, 1.5), 0.3);
        let closer = |t: f64| away(9.0 - t);
        let farther = |t: f64| away(2.0 + t);
        for (how, way) in [("closer", &closer as Way), ("farther", &farther)] {
            let middle = boundary(&mut live, way, (7.0, MOVE), is_cut);
            let what = format!("{how} by {middle} {place}");
            let pop = GHOST_PX * edges(&show(&mut live, way(0.0)).0) as f64;
            let states = assert_continuous(&what, &mut live, way, (middle, MOVE), pop);
            let mut expected = [Plain, Oblique].map(MirrorState::Drawn);
            if how == "farther" {
                expected.reverse();
            }
            assert_eq!(states, expected, "{what}");
            // And turning there, from just before it.
            show(&mut live, way(0.0));
            let here = way(middle - MOVE);
            let turning =
                |t: f64| here.with_rotation(here.rotation * Quat::from_rotation_y(t as f32));
            let what = format!("{what}, turning");
            assert_continuous(&what, &mut live, &turning, (0.0, TURN), pop);
        }
    }
}
