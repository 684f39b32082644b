//! More mirrors than one: side by side, one before the other, back to back, in each other, many.

use bevy::prelude::*;
use bevy_planar_mirror::{MirrorState, NotDrawn};

use super::cameras::states;
use crate::support::{
    hall::hall,
    picture::Picture,
    props::{BLUE, GREEN, MAGENTA, RED, at, glass, is},
    scene::{Look, Scene, Surface},
    set::{add_camera, build_with_mirrors},
    stage::Stage,
    studio::{Studio, TOLERANCE},
};

/// Things of all colors before mirrors that stand about the origin and look to +Z.
fn before_mirrors(name: &str) -> Scene {
    let mut scene = hall(name);
    scene.mirrors.clear();
    scene
}

fn turned(x: f32, y: f32, z: f32, yaw: f32) -> Transform {
    at(x, y, z).with_rotation(Quat::from_rotation_y(yaw))
}

/// Every pixel is that of one mirror's reference or of the scene without mirrors: also where an edge
/// runs, where [`Studio::assert_reflects`] does not look.
#[track_caller]
fn assert_no_pixel_of_its_own(studio: &mut Studio, scene: &Scene, picture: &Picture) {
    let mut layers = vec![studio.without_mirrors(scene)];
    for mirror in 0..scene.mirrors.len() {
        layers.push(studio.reference_in_place(scene, mirror));
    }
    let foreign = picture.places().filter(|place| {
        let pixel = picture.at(place.x, place.y);
        layers
            .iter()
            .all(|layer| !close(layer.at(place.x, place.y), pixel))
    });
    let foreign: Vec<_> = foreign.collect();
    // Where an edge of an object meets that of a mirror, rounding may take the pixel beside.
    assert!(
        foreign.len() <= 2,
        "{}: nothing gives the pixels {foreign:?}\n{}",
        scene.name,
        picture.save(&format!("{}-foreign", scene.name))
    );
}

fn close(a: [u8; 4], b: [u8; 4]) -> bool {
    (0..4).all(|i| a[i].abs_diff(b[i]) <= TOLERANCE)
}

#[test]
fn mirrors_side_by_side_each_show_their_own_reflection() {
    let scene = before_mirrors("side-by-side")
        .mirror(Surface::wall(1.4, 2.0, turned(-1.0, 0.5, 0.0, 0.25)))
        .mirror(Surface::wall(1.4, 2.0, turned(1.0, 0.5, 0.0, -0.25)));
    let mut studio = Studio::games();
    let picture = studio.assert_reflects(&scene);
    assert_no_pixel_of_its_own(&mut studio, &scene, &picture);
}

/// Whatever the order in which they came.
#[test]
fn where_mirrors_overlap_on_the_screen_the_nearer_one_is_seen() {
    let mut studio = Studio::games();
    let mut near_first = before_mirrors("overlap-near-first")
        .mirror(Surface::wall(1.2, 1.4, turned(0.6, 0.4, 1.0, 0.3)))
        .mirror(Surface::wall(3.0, 2.0, turned(-0.1, 0.6, 0.0, -0.1)));
    near_first.objects[1].transform = at(1.2, -0.3, 2.0);
    let mut far_first = near_first.clone();
    far_first.name = "overlap-far-first".to_owned();
    far_first.mirrors.reverse();
    let pictures = [near_first, far_first].map(|scene| {
        let picture = studio.assert_reflects(&scene);
        assert_no_pixel_of_its_own(&mut studio, &scene, &picture);
        picture
    });
    pictures[0].assert_same(&pictures[1], "overlap-order");
}

/// Two mirrors that go through each other: each is nearer on its side.
#[test]
fn mirrors_that_cross_part_where_they_cross() {
    let scene = before_mirrors("crossing")
        .mirror(Surface::wall(2.4, 2.0, turned(0.0, 0.5, 0.0, 0.4)))
        .mirror(Surface::wall(2.4, 2.0, turned(0.0, 0.5, 0.0, -0.4)));
    let mut studio = Studio::games();
    let picture = studio.assert_reflects(&scene);
    assert_no_pixel_of_its_own(&mut studio, &scene, &picture);
}

/// The glass blends over its own reflection, and of the mirror behind it nothing is seen through it.
#[test]
fn a_mirror_behind_anothers_glass_does_not_show_through() {
    let tint = |scene: &mut Scene, mirror: usize| {
        let surface = scene.mirrors[mirror].clone();
        scene.mirrors[mirror] = surface.look(glass(MAGENTA, 0.5));
    };
    let mut scene = before_mirrors("behind-glass")
        .mirror(Surface::wall(1.2, 1.4, turned(0.6, 0.4, 1.0, 0.3)))
        .mirror(Surface::wall(3.0, 2.0, turned(-0.1, 0.6, 0.0, -0.1)));
    scene.objects[1].transform = at(1.2, -0.3, 2.0);
    let mut studio = Studio::games();
    let clear = studio.picture(&scene);
    let masks = [0, 1].map(|mirror| studio.mask(&scene, mirror));
    tint(&mut scene, 0);
    let tinted = studio.picture(&scene);
    let blended = Picture::from_fn(scene.size, |x, y| {
        half_blended(clear.at(x, y), MAGENTA.to_linear())
    });
    let before = |place| masks[0].inside(place);
    tinted.assert_alike(&blended, TOLERANCE, 1.0, before, "glass-before");
    let behind = |place| masks[1].inside(place);
    tinted.assert_alike(&clear, 0, 1.0, behind, "glass-beside");
}

/// Half the color over half of what is there, in linear light, as the pipeline blends.
fn half_blended(below: [u8; 4], over: LinearRgba) -> [u8; 4] {
    let below = Srgba::rgb_u8(below[0], below[1], below[2]);
    let mixed = LinearRgba::from(below) * 0.5 + over * 0.5;
    let mut bytes = Srgba::from(mixed).to_u8_array();
    bytes[3] = 255;
    bytes
}

/// A mirror is not in another mirror's reflection, unless it has a material: this alone shows then.
#[test]
fn in_a_mirror_another_one_shows_its_material_alone() {
    let facing = |look: Option<Look>| {
        let mut scene = before_mirrors("facing")
            .mirror(Surface::wall(3.2, 2.2, at(0.0, 0.5, 0.0)))
            // Before the other and behind the eye, and turned to it.
            .mirror(Surface::wall(2.0, 1.2, turned(-0.6, 0.4, 5.0, 3.0)));
        scene.mirrors[1].look = look;
        scene
    };
    let mut studio = Studio::games();
    let mut picture = |scene: &Scene| {
        let picture = studio.picture(scene);
        let mask = studio.mask(scene, 0);
        let reference = studio.reference(scene, 0);
        let inside = |place| mask.inside(place);
        picture.assert_alike(&reference, TOLERANCE, 0.9999, inside, "facing-inside");
        picture
    };
    let bare = picture(&facing(None));
    let covered = picture(&facing(Some(MAGENTA.into())));
    assert_eq!(bare.count(is(MAGENTA)), 0);
    assert!(covered.count(is(MAGENTA)) > 150, "the material is not seen");
    let mut alone = facing(None);
    alone.mirrors.pop();
    studio.picture(&alone).assert_same(&bare, "facing-alone");
}

/// Two halves of a wall, each a mirror, are one mirror: at the seam at most one pixel of a row is another.
#[test]
fn touching_mirrors_of_one_plane_leave_no_seam() {
    let mut studio = Studio::games();
    for (name, yaw, msaa) in [
        ("straight", 0.0, Msaa::Off),
        ("turned", 0.4, Msaa::Off),
        ("samples", 0.4, Msaa::Sample4),
    ] {
        let rotation = Quat::from_rotation_y(yaw);
        let place = |x: f32| {
            let offset = rotation * vec3(x, 0.0, 0.0);
            turned(0.0, 0.5, 0.0, yaw).with_translation(vec3(0.0, 0.5, 0.0) + offset)
        };
        let mut whole = before_mirrors(name).mirror(Surface::wall(3.0, 2.0, place(0.0)));
        whole.msaa = msaa;
        let mut halves = whole.clone();
        halves.mirrors = [-0.75, 0.75]
            .map(|x| Surface::wall(1.5, 2.0, place(x)))
            .to_vec();
        let (whole, halves) = (studio.picture(&whole), studio.picture(&halves));
        for y in 0..whole.size().y {
            let other = (0..whole.size().x)
                .filter(|x| !close(whole.at(*x, y), halves.at(*x, y)))
                .count();
            assert!(
                other <= 1,
                "{name}: {other} pixels of row {y} differ\n{}\n{}",
                whole.save("seam-whole"),
                halves.save("seam-halves")
            );
        }
        let seam = halves
            .difference(&whole, TOLERANCE, |_| true)
            .expect("one size");
        assert!(seam.beyond <= 4, "{name}: {seam}");
    }
}

#[test]
fn twenty_mirrors_show_twenty_reflections() {
    let mut scene = Scene::new("twenty").eye(vec3(0.9, 1.2, 4.0), vec3(0.0, 0.4, 0.0));
    // A colorful wall behind the eye, for each mirror to show some other part of.
    for i in 0..99 {
        let (column, row) = ((i % 11) as f32 - 5.0, (i / 11) as f32 - 4.0);
        let color = Color::srgb(0.5 + column / 10.0, 0.5 + row / 8.0, (i % 3) as f32 / 2.0);
        let place = at(3.0 * column, 2.4 * row, 9.0);
        scene = scene.object(Cuboid::new(2.7, 2.1, 0.1), color, place);
    }
    scene = scene.object(Cuboid::from_length(0.2), RED, at(0.1, 0.5, 0.8));
    for i in 0..20 {
        let (column, row) = ((i % 5) as f32, (i / 5) as f32);
        let rotation = Quat::from_euler(
            EulerRot::YXZ,
            0.1 * (2.0 - column),
            0.1 * (row - 1.5),
            0.1 * column,
        );
        let place = at(0.85 * (column - 2.0), 0.7 * row - 0.6, 0.0).with_rotation(rotation);
        scene = scene.mirror(Surface::wall(0.7, 0.55, place));
    }
    let mut studio = Studio::games();
    let picture = studio.assert_reflects(&scene);
    assert_no_pixel_of_its_own(&mut studio, &scene, &picture);
    for mirror in 0..20 {
        let mask = studio.mask(&scene, mirror);
        let inside = |place: &UVec2| mask.inside(*place);
        let mut seen: Vec<_> = picture
            .places()
            .filter(inside)
            .map(|place| picture.at(place.x, place.y))
            .collect();
        seen.sort_unstable();
        seen.dedup();
        assert!(seen.len() > 1, "mirror {mirror} shows nothing but {seen:?}");
    }
}

/// A wall with a mirror on either side: each camera sees the one that faces it.
#[test]
fn mirrors_back_to_back_serve_both_sides_of_a_wall() {
    let scene = |name: &str, eye: Vec3| {
        let mut scene = Scene::new(name)
            .eye(eye, vec3(0.0, 0.3, 0.0))
            .object(Cuboid::from_length(0.7), RED, at(-0.6, 0.4, 1.4))
            .object(Cuboid::from_length(0.7), BLUE, at(0.8, 0.2, -1.2))
            .object(Cuboid::new(0.4, 0.4, 1.4), GREEN, at(0.2, 1.0, 0.0))
            .mirror(Surface::wall(3.0, 2.0, turned(0.0, 0.5, 0.0, 0.0)))
            .mirror(Surface::wall(
                3.0,
                2.0,
                turned(0.0, 0.5, 0.0, std::f32::consts::PI),
            ));
        scene.size = uvec2(120, 90);
        scene
    };
    let before = scene("back-to-back-before", vec3(0.7, 1.0, 4.0));
    let behind = scene("back-to-back-behind", vec3(0.4, 1.2, -4.0));
    let mut studio = Studio::games();
    let mut alone = |scene: &Scene, facing: usize| {
        // The other mirror has no part in it, so the acceptance is that of the facing one alone.
        let mut only = scene.clone();
        only.mirrors = vec![scene.mirrors[facing].clone()];
        let picture = studio.assert_reflects(&only);
        studio.picture(scene).assert_same(&picture, &scene.name);
        let states = states(studio.stage());
        assert!(matches!(states[facing], MirrorState::Drawn(_)));
        assert_eq!(
            states[1 - facing],
            MirrorState::NotDrawn(NotDrawn::EyeBehind)
        );
        picture
    };
    let alone = [alone(&before, 0), alone(&behind, 1)];

    let mut stage = Stage::with_mirrors();
    let targets = [&before, &behind].map(|scene| stage.target(scene.size));
    build_with_mirrors(&mut stage, &before, targets[0].clone());
    add_camera(&mut stage, &behind, targets[1].clone());
    for (index, scene) in [&before, &behind].into_iter().enumerate() {
        let picture = stage.picture(&targets[index], scene.size);
        picture.assert_same(&alone[index], &format!("{}-together", scene.name));
    }
}
