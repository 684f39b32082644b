//! Mirrors in mirrors: `PlanarMirrorPlugin::max_bounces`.
//!
//! What a mirror shows is what a camera at the reflected eye sees. So what a mirror in it shows is
//! the reference of the scene with its eye there, and so on: no code of the plugin is in any of it.
//! The scenes have nothing behind a mirror that would hide it from there.

use bevy::prelude::*;
use bevy_planar_mirror::{MirrorState, NotDrawn, PlanarMirrorPlugin};

use super::cameras::states;
use crate::support::{
    picture::Picture,
    props::{BLUE, GREEN, MAGENTA, RED, YELLOW, at, glass, lit, sun},
    reference::reflected_eye,
    scene::{Look, Scene, Surface},
    studio::{SHARE, Studio, TOLERANCE},
};

fn bouncing(max_bounces: u8) -> Studio {
    Studio::with(PlanarMirrorPlugin {
        max_bounces,
        ..default()
    })
}

/// What a viewer sees, and of each pixel by how many reflections; `None` along edges.
struct Seen {
    picture: Picture,
    bounces: Vec<Option<u8>>,
}

impl Seen {
    fn bounces(&self, place: UVec2) -> Option<u8> {
        self.bounces[(place.y * self.picture.size().x + place.x) as usize]
    }

    fn flipped(&self) -> Self {
        let size = self.picture.size();
        let picture = self.picture.flipped();
        let bounces = picture
            .places()
            .map(|place| self.bounces(uvec2(size.x - 1 - place.x, place.y)))
            .collect();
        Self { picture, bounces }
    }
}

/// `bare` is what the eye of the scene sees without mirrors. It looks out of the mirror `last`.
fn unfolded(
    studio: &mut Studio,
    scene: &Scene,
    last: Option<usize>,
    bare: Picture,
    max_bounces: u8,
) -> Seen {
    let count = (scene.size.x * scene.size.y) as usize;
    let mut seen = Seen {
        picture: bare,
        bounces: vec![Some(0); count],
    };
    if max_bounces == 0 {
        return seen;
    }
    let mut others = scene.clone();
    if let Some(last) = last {
        others.mirrors.remove(last);
    }
    for index in 0..others.mirrors.len() {
        let mask = studio.mask(&others, index);
        if mask.inside_count() == 0 {
            continue;
        }
        let bare = studio.reference(&others, index).flipped();
        let plane = others.mirrors[index].plane();
        let behind = Scene {
            eye: reflected_eye(&scene.eye, plane),
            ..scene.clone()
        };
        // The index among all mirrors.
        let this = index + usize::from(last.is_some_and(|last| last <= index));
        let inner = unfolded(studio, &behind, Some(this), bare, max_bounces - 1).flipped();
        let size = scene.size;
        for place in inner.picture.places() {
            let slot = &mut seen.bounces[(place.y * size.x + place.x) as usize];
            if mask.inside(place) {
                *slot = inner.bounces(place).map(|bounces| bounces + 1);
            } else if !mask.outside(place) {
                *slot = None;
            }
        }
        let outer = seen.picture.clone();
        seen.picture = Picture::from_fn(size, |x, y| {
            let from = if mask.inside(uvec2(x, y)) {
                &inner.picture
            } else {
                &outer
            };
            from.at(x, y)
        });
    }
    seen
}

/// Every pixel is right, and at least `least` of them are reflected `max_bounces` times.
#[track_caller]
fn assert_bounces(scene: &Scene, max_bounces: u8, least: usize) {
    assert_some_bounces(scene, max_bounces, least, |_| true);
}

/// The same of the pixels with these numbers of reflections.
#[track_caller]
fn assert_some_bounces(scene: &Scene, max_bounces: u8, least: usize, which: fn(u8) -> bool) {
    let mut studio = bouncing(max_bounces);
    let picture = studio.picture(scene);
    let bare = studio.without_mirrors(scene);
    let expected = unfolded(&mut studio, scene, None, bare, max_bounces);
    for bounces in (0..=max_bounces).filter(|bounces| which(*bounces)) {
        let region = |place: UVec2| expected.bounces(place) == Some(bounces);
        let pixels = picture.places().filter(|place| region(*place)).count();
        let what = format!("{}-{bounces}-bounces", scene.name);
        if bounces == max_bounces {
            assert!(pixels >= least, "{what}: only {pixels} pixels");
        }
        if pixels > 0 {
            picture.assert_alike(&expected.picture, TOLERANCE, SHARE, region, &what);
        }
    }
}

/// Two mirrors face each other, a little askew, with things of all colors between.
fn facing(name: &str, look: impl Fn(Color) -> Look) -> Scene {
    let turned = |x: f32, z: f32, yaw: f32| at(x, 0.5, z).with_rotation(Quat::from_rotation_y(yaw));
    Scene::new(name)
        .eye(vec3(1.0, 1.3, 2.4), vec3(0.1, 0.4, 0.0))
        .mirror(Surface::wall(3.2, 2.2, turned(0.0, 0.0, 0.05)))
        .mirror(Surface::wall(
            2.6,
            1.8,
            turned(0.2, 4.5, std::f32::consts::PI - 0.1),
        ))
        .object(Cuboid::from_length(0.5), look(RED), at(-0.7, 0.5, 1.1))
        .object(
            Sphere::new(0.25).mesh().uv(24, 16),
            look(BLUE),
            at(0.3, 0.1, 0.8),
        )
        .object(Cuboid::new(0.3, 0.8, 0.3), look(GREEN), at(0.9, 0.7, 3.4))
        .object(
            Cuboid::new(6.0, 0.1, 4.0),
            look(YELLOW),
            at(0.0, -0.8, 2.25),
        )
}

#[test]
fn a_mirror_in_a_mirror_reflects() {
    assert_bounces(&facing("two-bounces", |color| color.into()), 2, 800);
}

#[test]
fn three_and_four_bounces_reflect() {
    let scene = facing("bounces", |color| color.into());
    assert_bounces(&scene, 3, 300);
    assert_bounces(&scene, 4, 100);
}

/// After an even number of reflections the triangles wind as they were made.
#[test]
fn lit_and_shadowed_surfaces_are_right_at_every_bounce() {
    let scene = facing("lit-bounces", |color| lit(color).into()).prop(sun(true));
    assert_bounces(&scene, 3, 300);
}

/// A picture that is flipped an odd number of times has its samples elsewhere in the pixel.
#[test]
fn samples_do_not_leak_between_bounces() {
    let mut scene = facing("sampled-bounces", |color| color.into());
    scene.msaa = Msaa::Sample4;
    assert_some_bounces(&scene, 4, 100, |bounces| bounces % 2 == 0);
}

/// What crosses the inner mirror is cut there, and what crosses the outer one is cut at that.
#[test]
fn each_bounce_is_cut_at_its_own_mirror() {
    let crossing = |color: Color, z: f32| (color, at(-0.1, 0.9, z));
    let mut scene = facing("cut-bounces", |color| color.into());
    for (color, place) in [crossing(MAGENTA, 0.0), crossing(RED, 4.5)] {
        scene = scene.object(Cuboid::new(0.4, 0.3, 0.5), color, place);
    }
    assert_bounces(&scene, 2, 800);
}

/// One after the other: the depth and the stencil that one leaves must not reach the next.
#[test]
fn several_mirrors_in_a_mirror_each_reflect() {
    let mut scene = facing("siblings", |color| color.into());
    scene.mirrors.pop();
    let turned = |x: f32, z: f32, yaw: f32| at(x, 0.5, z).with_rotation(Quat::from_rotation_y(yaw));
    // The second and the third overlap.
    for place in [
        turned(-1.0, 4.6, 2.9),
        turned(0.3, 4.8, 3.3),
        turned(0.8, 4.4, 3.0),
    ] {
        scene = scene.mirror(Surface::wall(1.1, 1.6, place));
    }
    assert_bounces(&scene, 2, 500);
    // The camera itself sees two mirrors, each with others in it.
    let mut scene = facing("cousins", |color| color.into());
    scene.mirrors[0] = Surface::wall(1.5, 2.0, turned(-0.8, 0.0, 0.1));
    scene = scene.mirror(Surface::wall(1.5, 2.0, turned(0.8, 0.1, -0.1)));
    assert_bounces(&scene, 3, 100);
}

/// Half a color over half the reflection, at every bounce anew.
#[test]
fn glass_over_a_mirror_tints_it_at_every_bounce() {
    let clear = facing("untinted", |color| color.into());
    let mut tinted = clear.clone();
    tinted.name = "tinted".to_owned();
    tinted.mirrors[1] = clear.mirrors[1].clone().look(glass(MAGENTA, 0.5));
    let mut studio = bouncing(2);
    let pictures = [&clear, &tinted].map(|scene| studio.picture(scene));
    let bare = studio.without_mirrors(&clear);
    let expected = unfolded(&mut studio, &clear, None, bare, 2);
    let half = |below: [u8; 4]| {
        let below = Srgba::rgb_u8(below[0], below[1], below[2]);
        let mixed = LinearRgba::from(below) * 0.5 + MAGENTA.to_linear() * 0.5;
        let mut bytes = Srgba::from(mixed).to_u8_array();
        bytes[3] = 255;
        bytes
    };
    let blended = Picture::from_fn(clear.size, |x, y| half(pictures[0].at(x, y)));
    for (bounces, wanted) in [(0, &pictures[0]), (1, &pictures[0]), (2, &blended)] {
        let region = |place: UVec2| expected.bounces(place) == Some(bounces);
        let what = format!("tinted-{bounces}");
        pictures[1].assert_alike(wanted, TOLERANCE, SHARE, region, &what);
    }
}

/// Beyond the last bounce a mirror shows its material; here it has none.
#[test]
fn no_bounce_more_than_asked_for() {
    let scene = facing("limited", |color| color.into());
    let three = bouncing(3).picture(&scene);
    let two = bouncing(2).picture(&scene);
    let mut studio = bouncing(2);
    let bare = studio.without_mirrors(&scene);
    let expected = unfolded(&mut studio, &scene, None, bare, 3);
    let shallow = |place: UVec2| expected.bounces(place).is_some_and(|bounces| bounces < 3);
    two.assert_alike(&three, TOLERANCE, SHARE, shallow, "limited-shallow");
    let deep = |place: UVec2| expected.bounces(place) == Some(3);
    assert!(
        two.difference(&three, TOLERANCE, deep)
            .is_ok_and(|d| d.beyond > 50)
    );

    let mut studio = bouncing(0);
    studio.assert_no_mirror(&scene);
    let states = states(studio.stage());
    assert_eq!(states[0], MirrorState::NotDrawn(NotDrawn::TooManyMirrors));
}
