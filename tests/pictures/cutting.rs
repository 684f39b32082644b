//! What stands before a mirror hides it, what crosses its plane is cut there, what is behind never shows.

use std::f32::consts::PI;

use bevy::{
    camera::visibility::{NoAutoAabb, NoFrustumCulling},
    mesh::SphereKind,
    prelude::*,
};
use bevy_planar_mirror::{
    MirrorClip, MirrorState, MirrorStatus,
    status::Projection::{Oblique, Plain},
};

use crate::support::{
    props::{BLUE, GREEN, MAGENTA, RED, YELLOW, add, at, is, lamp, lit, quarters, sun},
    scene::{Look, Scene, Surface},
    studio::{Studio, TOLERANCE, assert_reflects},
};

/// A mirror to walk on, seen from above.
fn floor(name: &str) -> Scene {
    let mut scene = Scene::new(name)
        .eye(vec3(0.4, 1.6, 4.2), vec3(0.0, 0.1, 0.0))
        .mirror(Surface::floor(5.0, 5.0, Transform::default()))
        .prop(sun(false))
        .prop(lamp(vec3(-1.5, 2.0, 2.0), false));
    scene.ambient.brightness = 100.0;
    scene
}

fn tilted(x: f32, y: f32, z: f32, angles: [f32; 3]) -> Transform {
    let [a, b, c] = angles;
    at(x, y, z).with_rotation(Quat::from_euler(EulerRot::XYZ, a, b, c))
}

fn ball(radius: f32) -> Mesh {
    Sphere::new(radius)
        .mesh()
        .kind(SphereKind::Uv {
            sectors: 32,
            stacks: 18,
        })
        .build()
}

/// A look and a component for its entity.
fn with(color: Color, bundle: impl Bundle + Clone) -> Look {
    Look::other(move |entity| {
        let material = StandardMaterial {
            base_color: color,
            unlit: true,
            ..default()
        };
        let material = add(entity, material);
        entity.insert((MeshMaterial3d(material), bundle.clone()));
    })
}

/// The state of the one mirror on the stage.
fn state(studio: &mut Studio) -> MirrorState {
    let world = studio.stage().world();
    let statuses: Vec<_> = world.query::<&MirrorStatus>().iter(world).collect();
    assert_eq!(statuses.len(), 1);
    statuses[0].cameras[0].state
}

#[test]
fn what_stands_before_the_mirror_hides_it() {
    let scene = Scene::new("before")
        .eye(vec3(0.0, 0.0, 4.0), Vec3::ZERO)
        .mirror(Surface::wall(4.0, 2.6, Transform::default()))
        .object(Rectangle::new(0.5, 3.0), RED, at(-0.6, 0.0, 0.5))
        .object(Rectangle::new(0.5, 3.0), GREEN, at(0.6, 0.0, 0.001))
        .object(
            Cuboid::from_length(0.5),
            BLUE,
            tilted(0.0, 0.0, 1.0, [0.3, 0.4, 0.0]),
        );
    let picture = assert_reflects(&scene);
    for (x, color) in [(-0.6, RED), (0.6, GREEN)] {
        let place = 80.0 + 60.0 / (PI / 8.0).tan() * x / if x < 0.0 { 3.5 } else { 4.0 };
        assert!(
            is(color)(picture.at(place as u32, 100)),
            "{color:?} is hidden"
        );
    }
}

/// The faces look at the camera: their backs, which the mirror would show, are culled.
#[test]
fn through_the_holes_of_what_stands_before_it_one_sees_the_mirror() {
    let mesh = || Rectangle::new(1.6, 1.6);
    let place = at(0.1, 0.1, 0.8);
    let look = |alpha| {
        let pane = StandardMaterial {
            unlit: true,
            alpha_mode: AlphaMode::Mask(0.5),
            ..default()
        };
        quarters(pane, alpha)
    };
    let bare = Scene::new("lattice")
        .eye(vec3(0.0, 0.0, 4.0), Vec3::ZERO)
        .mirror(Surface::wall(4.0, 2.6, Transform::default()))
        .object(
            Rectangle::new(4.0, 2.0),
            MAGENTA,
            at(0.0, 0.3, 2.5).with_rotation(Quat::from_rotation_y(PI)),
        );
    let mut studio = Studio::default();
    let mirror = studio.picture(&bare);
    let closed = studio.picture(&bare.clone().object(mesh(), look([255; 4]), place));
    let picture = studio.picture(&bare.object(mesh(), look([255, 0, 0, 255]), place));
    for (color, stays) in [(RED, true), (GREEN, false), (BLUE, false), (YELLOW, true)] {
        assert!(closed.count(is(color)) > 300);
        let wanted = if stays { &closed } else { &mirror };
        picture.assert_alike(
            wanted,
            0,
            1.0,
            |place| is(color)(closed.at(place.x, place.y)),
            &format!("lattice-{color:?}"),
        );
    }
    let all = [RED, GREEN, BLUE, YELLOW];
    let beside = |place: UVec2| {
        let pixel = closed.at(place.x, place.y);
        !all.iter().any(|color| is(*color)(pixel))
    };
    picture.assert_alike(&mirror, 0, 1.0, beside, "lattice-beside");
}

#[test]
fn closed_bodies_are_cut_at_the_plane() {
    let scene = floor("cut-closed")
        .object(
            ball(0.6),
            lit(Color::srgb(0.9, 0.4, 0.3)),
            at(-0.9, 0.15, 0.0),
        )
        .object(
            Cuboid::from_length(0.8),
            lit(Color::srgb(0.3, 0.6, 0.9)),
            at(0.9, -0.1, 0.3),
        );
    let mut studio = Studio::default();
    studio.assert_reflects(&scene);
    assert_eq!(state(&mut studio), MirrorState::Drawn(Oblique));
}

/// One sees into them: nothing hides a wrong cut.
#[test]
fn open_sheets_are_cut_at_the_plane() {
    let sheet = |color| StandardMaterial {
        double_sided: true,
        cull_mode: None,
        ..lit(color)
    };
    let pipe = Extrusion::new(Annulus::new(0.45, 0.5), 0.9);
    let pipe = pipe
        .mesh()
        .with_inner(|circle| circle.resolution(24))
        .build();
    let scene = floor("cut-open")
        .object(
            Rectangle::new(1.0, 1.2),
            sheet(RED),
            tilted(-1.2, 0.2, 0.2, [0.0, 0.3, 0.0]),
        )
        .object(
            Rectangle::new(1.2, 1.0),
            sheet(GREEN),
            tilted(1.2, 0.1, 0.0, [-0.9, -0.5, 0.2]),
        )
        .object(
            pipe,
            sheet(YELLOW),
            tilted(0.0, 0.1, 0.4, [PI / 2.0, 0.0, 0.0]),
        );
    assert_reflects(&scene);
}

#[test]
fn tilted_bodies_are_cut_at_a_tilted_plane() {
    let mirror = Transform::from_rotation(Quat::from_euler(EulerRot::XYZ, -0.5, 0.4, 0.2));
    let mut scene = Scene::new("cut-tilted")
        .eye(vec3(0.3, 1.0, 4.0), Vec3::ZERO)
        .mirror(Surface::wall(3.2, 2.4, mirror))
        .prop(sun(false));
    scene.ambient.brightness = 200.0;
    for (i, color) in [RED, GREEN, BLUE, YELLOW, MAGENTA].into_iter().enumerate() {
        let angle = i as f32;
        let place = mirror * vec3(0.6 * angle - 1.2, 0.5 * (angle * 2.3).sin(), 0.1);
        let turned = tilted(0.0, 0.0, 0.0, [angle, 1.7 * angle, 0.4]);
        scene = scene.object(
            Cuboid::new(0.3, 0.5, 0.7),
            lit(color),
            turned.with_translation(place),
        );
    }
    assert_reflects(&scene);
}

#[test]
fn textures_lie_right_on_what_is_left_of_a_cut_object() {
    let paper = StandardMaterial {
        unlit: true,
        ..default()
    };
    let scene = floor("cut-textured")
        .object(
            Cuboid::from_length(1.0),
            quarters(paper.clone(), [255; 4]),
            tilted(-0.8, 0.1, 0.3, [0.2, 0.5, 0.3]),
        )
        .object(
            ball(0.6),
            quarters(paper, [255; 4]),
            tilted(1.0, 0.2, 0.2, [0.0, 1.0, 0.4]),
        );
    assert_reflects(&scene);
}

/// Its corners are far beyond the mirror's edges, in front and behind.
#[test]
fn a_huge_floor_is_cut_at_a_leaning_mirror() {
    for lean in [-0.6, 0.0, 0.4] {
        let mirror = at(0.0, 0.6, 0.0).with_rotation(Quat::from_rotation_x(lean));
        let scene = Scene::new(&format!("cut-huge-{lean}"))
            .eye(vec3(0.5, 1.2, 4.0), vec3(0.0, 0.4, 0.0))
            .mirror(Surface::wall(3.0, 2.0, mirror))
            .object(
                Plane3d::new(Vec3::Y, Vec2::splat(200.0)),
                lit(Color::srgb(0.6, 0.7, 0.3)),
                Transform::default(),
            )
            .object(Cuboid::from_length(0.5), lit(RED), at(0.7, 0.25, 1.2))
            .prop(sun(false));
        assert_reflects(&scene);
    }
}

#[test]
fn what_stands_exactly_on_the_plane_is_whole_in_the_reflection() {
    let scene = floor("standing")
        .object(Cuboid::from_length(0.5), lit(RED), at(-0.7, 0.25, 0.3))
        .object(
            Cuboid::new(0.3, 1.0, 0.3),
            lit(GREEN),
            tilted(0.6, 0.5, 0.0, [0.0, 0.7, 0.0]),
        );
    let mut studio = Studio::default();
    studio.assert_reflects(&scene);
    assert_eq!(
        state(&mut studio),
        MirrorState::Drawn(Plain),
        "nothing crosses the plane"
    );
}

#[test]
fn nothing_behind_the_mirror_shows() {
    let scene = Scene::new("ghosts")
        .eye(vec3(0.3, 0.2, 4.0), Vec3::ZERO)
        .mirror(Surface::wall(4.0, 2.6, Transform::default()))
        .object(Cuboid::from_length(0.5), BLUE, at(0.8, 0.2, 1.0));
    let mut studio = Studio::default();
    let alone = studio.picture(&scene);
    let ghosts: [(&str, Look); 3] = [
        ("bounded", RED.into()),
        ("always", with(RED, NoFrustumCulling)),
        ("unbounded", with(RED, NoAutoAabb)),
    ];
    for (name, look) in ghosts {
        let haunted = scene
            .clone()
            .object(Cuboid::from_length(0.8), look.clone(), at(0.0, 0.0, -1.0))
            .object(ball(0.3), look, at(-0.9, 0.3, -0.31));
        let picture = studio.picture(&haunted);
        picture.assert_same(&alone, &format!("ghosts-{name}"));
    }
}

#[test]
fn objects_that_are_never_culled_or_have_no_bounds_are_cut() {
    let scene = floor("unbounded")
        .object(
            Cuboid::from_length(0.9),
            with(RED, NoFrustumCulling),
            tilted(-0.8, 0.1, 0.0, [0.3, 0.4, 0.0]),
        )
        .object(
            Cuboid::from_length(0.9),
            with(GREEN, NoAutoAabb),
            tilted(0.8, 0.0, 0.3, [0.0, 0.4, 0.6]),
        );
    assert_reflects(&scene);
}

#[test]
fn a_picture_on_the_mirror_is_all_there_or_not_at_all() {
    let bare = Scene::new("sticker")
        .eye(vec3(0.7, 0.4, 4.0), Vec3::ZERO)
        .mirror(Surface::wall(4.0, 2.6, Transform::default()))
        .object(
            Rectangle::new(4.0, 3.0),
            BLUE,
            at(0.0, 0.0, 2.5).with_rotation(Quat::from_rotation_y(PI)),
        );
    let mut studio = Studio::default();
    let mirror = studio.picture(&bare);
    let sticker = bare.object(Rectangle::new(0.8, 0.6), RED, at(0.4, 0.2, 0.0));
    let plain = studio.without_mirrors(&sticker);
    let picture = studio.picture(&sticker);
    let covered = plain.count(is(RED));
    assert!(covered > 300);
    let shown = picture.count(is(RED));
    assert!(
        shown == covered || shown == 0,
        "{shown} of {covered} pixels: {}",
        picture.save("sticker")
    );
    let beside = |place: UVec2| !is(RED)(plain.at(place.x, place.y));
    picture.assert_alike(&mirror, 0, 1.0, beside, "sticker-beside");
}

/// The oblique near plane moves depth alone: no pixel tells which projection was used.
#[test]
fn an_oblique_near_plane_changes_no_picture() {
    let mut scene = floor("projections")
        .object(ball(0.5), lit(RED), at(-0.7, 0.6, 0.3))
        .object(Cuboid::from_length(0.6), lit(GREEN), at(0.7, 0.4, -0.2))
        .object(Cuboid::new(0.2, 0.2, 3.0), lit(YELLOW), at(0.1, 0.9, -1.5));
    let mut studio = Studio::default();
    let auto = studio.assert_reflects(&scene);
    assert_eq!(state(&mut studio), MirrorState::Drawn(Plain));
    scene.mirrors[0].mirror.clip = MirrorClip::Oblique;
    let oblique = studio.picture(&scene);
    assert_eq!(state(&mut studio), MirrorState::Drawn(Oblique));
    oblique.assert_alike(&auto, TOLERANCE, 0.9999, |_| true, "oblique-and-auto");
}

#[test]
fn whole_objects_show_what_is_behind_the_mirror_too() {
    let mut scene = floor("whole").object(Cuboid::new(0.4, 2.0, 0.4), RED, at(0.0, -0.6, 1.0));
    let mut studio = Studio::default();
    let cut = studio.assert_reflects(&scene);
    scene.mirrors[0].mirror.clip = MirrorClip::Whole;
    let whole = studio.picture(&scene);
    assert_eq!(state(&mut studio), MirrorState::Drawn(Plain));
    // 0.4 units of the post are before the mirror, and 1.6 behind.
    let (cut_count, whole_count) = (cut.count(is(RED)), whole.count(is(RED)));
    assert!(
        whole_count > cut_count + 200,
        "{whole_count} pixels where {cut_count} are cut"
    );
    // Nothing is lost by it.
    let in_front = |place: UVec2| is(RED)(cut.at(place.x, place.y));
    whole.assert_alike(&cut, 0, 1.0, in_front, "whole-in-front");
    studio.assert_untouched_outside(&scene, &whole);

    let behind = scene.object(Cuboid::from_length(0.5), GREEN, at(1.0, -0.6, 0.5));
    let picture = studio.picture(&behind);
    assert_eq!(picture.count(is(GREEN)), 0, "it is wholly behind");
}
