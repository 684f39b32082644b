//! What a reflection holds: opaque, masked and see-through objects, the sky, the clear color.

use std::f32::consts::PI;

use bevy::{camera::ClearColorConfig, light::Skybox, prelude::*};

use crate::support::{
    linear::{combined, over},
    props::{BLUE, GREEN, MAGENTA, RED, YELLOW, add, at, bytes, glass, is, quarters, six_colors},
    scene::{Scene, Surface},
    studio::{Studio, TOLERANCE, assert_reflects},
};

/// An eye four units before an upright mirror.
fn wall(name: &str) -> Scene {
    Scene::new(name)
        .eye(vec3(0.0, 0.0, 4.0), Vec3::ZERO)
        .mirror(Surface::wall(4.0, 2.6, Transform::default()))
}

/// Turned to the mirror: its face is seen in there alone.
fn turned(x: f32, y: f32, z: f32) -> Transform {
    at(x, y, z).with_rotation(Quat::from_rotation_y(PI))
}

/// Where a point shows in the picture of [`wall`], reflected if it is before the mirror.
fn seen(point: Vec3) -> Vec2 {
    let focal = 60.0 / (PI / 8.0).tan();
    vec2(80.0, 60.0) + focal * vec2(point.x, -point.y) / (4.0 + point.z)
}

#[test]
fn opaque_objects_show_where_geometry_says() {
    let scene = wall("opaque")
        .object(Rectangle::new(0.4, 0.4), RED, turned(-0.9, 0.5, 1.5))
        .object(Rectangle::new(0.4, 0.4), GREEN, turned(1.1, -0.4, 2.5));
    let picture = assert_reflects(&scene);
    for (color, place) in [(RED, vec3(-0.9, 0.5, 1.5)), (GREEN, vec3(1.1, -0.4, 2.5))] {
        let found = picture.centroid(is(color)).expect("it is reflected");
        assert!(
            found.distance(seen(place)) < 0.6,
            "at {found} and not at {}",
            seen(place)
        );
    }
}

#[test]
fn nearer_things_hide_farther_ones_in_the_reflection() {
    // To the camera the green pane is the nearer one.
    let scene = wall("depth-order")
        .object(Rectangle::new(1.0, 1.0), GREEN, turned(0.0, 0.0, 2.0))
        .object(Rectangle::new(0.4, 0.4), RED, turned(0.0, 0.0, 1.0));
    let picture = assert_reflects(&scene);
    assert!(is(RED)(picture.at(80, 60)));
    assert!(is(GREEN)(picture.at(91, 60)));
}

#[test]
fn through_the_holes_of_a_masked_object_one_sees_what_is_behind_it() {
    let pane = StandardMaterial {
        unlit: true,
        alpha_mode: AlphaMode::Mask(0.5),
        ..default()
    };
    // Green and yellow, its right half, are holes.
    let scene = wall("masked")
        .object(
            Rectangle::new(1.0, 1.0),
            quarters(pane, [255, 0, 255, 0]),
            turned(0.0, 0.0, 1.5),
        )
        .object(Rectangle::new(2.0, 2.0), MAGENTA, turned(0.0, 0.0, 2.2));
    let picture = assert_reflects(&scene);
    // Its left half, seen from where it faces to, is on the right of the mirror.
    let quarter = |x, y| {
        let place = seen(vec3(x, y, 1.5)).as_uvec2();
        picture.at(place.x, place.y)
    };
    assert!(is(RED)(quarter(0.25, 0.25)));
    assert!(is(BLUE)(quarter(0.25, -0.25)));
    assert!(is(MAGENTA)(quarter(-0.25, 0.25)));
    assert!(is(MAGENTA)(quarter(-0.25, -0.25)));
    assert_eq!(picture.count(is(GREEN)) + picture.count(is(YELLOW)), 0);
}

#[test]
fn see_through_panes_lie_over_each_other_in_the_order_of_the_reflected_way() {
    // To the camera the blue pane is the nearer one.
    let scene = wall("panes")
        .object(
            Rectangle::new(1.0, 1.0),
            glass(RED, 0.4),
            turned(-0.2, 0.0, 1.0),
        )
        .object(
            Rectangle::new(1.2, 1.2),
            glass(BLUE, 0.6),
            turned(0.2, 0.0, 2.0),
        )
        .object(Rectangle::new(4.0, 0.4), YELLOW, turned(0.0, 0.0, 3.0));
    let picture = assert_reflects(&scene);
    let both = over(RED, 0.4, over(BLUE, 0.6, YELLOW));
    let place = seen(vec3(0.0, 0.0, 1.0)).as_uvec2();
    let found = picture.at(place.x, place.y);
    assert!(is(both)(found), "{found:?} is not {:?}", bytes(both));
    let wrong = over(BLUE, 0.6, over(RED, 0.4, YELLOW));
    assert!(!is(wrong)(bytes(both)), "the two orders look alike");
    let clear = over(RED, 0.4, over(BLUE, 0.6, scene.clear_color));
    assert!(
        picture.count(is(clear)) > 100,
        "no pane lies over the clear color"
    );
}

#[test]
fn a_pane_before_the_mirror_lies_over_the_reflection() {
    let behind = wall("before")
        .object(Cuboid::from_length(0.6), RED, turned(0.2, 0.1, 1.0))
        .object(Rectangle::new(3.0, 1.0), YELLOW, turned(0.0, 0.5, 3.0));
    // Seen from behind a pane is culled, so it is not reflected as well.
    let place = at(0.3, 0.0, 2.0);
    let pane = Rectangle::new(0.7, 0.5);
    let mut studio = Studio::default();
    let bare = studio.picture(&behind);
    let covered = studio.picture(&behind.clone().object(pane, GREEN, place));
    let picture = studio.picture(&behind.object(pane, glass(GREEN, 0.4), place));
    let expected = combined([&bare, &covered], |[bare, covered]| {
        let green = GREEN.to_linear().to_vec3();
        if covered == green {
            bare.lerp(green, 0.4)
        } else {
            bare
        }
    });
    assert!(covered.count(is(GREEN)) > 400);
    picture.assert_alike(&expected, TOLERANCE, 1.0, |_| true, "pane-before");
}

/// Neither drawn into the reflection, nor through the mirror, whatever the mirror is made of.
#[test]
fn nothing_see_through_shows_from_behind_the_mirror() {
    let mut studio = Studio::default();
    for (mirror, look) in [("perfect", None), ("tinted", Some(glass(BLUE, 0.3)))] {
        let mut scene = wall(&format!("behind-{mirror}")).object(
            Cuboid::from_length(0.4),
            YELLOW,
            at(0.6, 0.2, 1.0),
        );
        scene.mirrors[0].look = look.map(Into::into);
        let alone = studio.picture(&scene);
        for mode in [
            AlphaMode::Blend,
            AlphaMode::Premultiplied,
            AlphaMode::Add,
            AlphaMode::Multiply,
            AlphaMode::Mask(0.1),
            AlphaMode::Opaque,
        ] {
            let ghost = StandardMaterial {
                base_color: RED.with_alpha(0.5),
                unlit: true,
                alpha_mode: mode,
                cull_mode: None,
                ..default()
            };
            let mut haunted = scene.clone();
            // Near the mirror, far from it, and large: as much as the mirror hides.
            for (size, z) in [(1.0, -0.01), (0.8, -0.5), (1.5, -2.0)] {
                let pane = Rectangle::new(size, size);
                haunted = haunted.object(pane, ghost.clone(), at(0.0, 0.0, z));
            }
            let what = format!("behind-{mirror}-{mode:?}");
            studio.picture(&haunted).assert_same(&alone, &what);
        }
    }
}

#[test]
fn the_sky_is_the_right_way_round_in_every_mirror() {
    let sky = |scene: Scene, rotation: Quat| {
        scene.touch_camera(move |camera| {
            let image = add(camera, six_colors());
            camera.insert(Skybox {
                image: Some(image),
                brightness: 1000.0,
                rotation,
            });
        })
    };
    let mut studio = Studio::default();

    let facing = sky(wall("sky-facing"), Quat::IDENTITY);
    let picture = studio.assert_reflects(&facing);
    // One looks towards -z into the mirror, and sees what is towards +z.
    let [r, g, b, _] = picture.at(80, 60);
    assert!(r < 80 && g > 120 && b > 120, "{:?}", picture.at(80, 60));
    let [r, g, b, _] = picture.at(2, 60);
    assert!(r > 120 && g < 80 && b > 120, "{:?}", picture.at(2, 60));

    let floor = |name: &str| {
        Scene::new(name)
            .fov(80.0)
            .mirror(Surface::floor(6.0, 6.0, Transform::default()))
    };
    studio.assert_reflects(&sky(floor("sky-floor"), Quat::IDENTITY));
    studio.assert_reflects(&sky(
        floor("sky-turned"),
        Quat::from_euler(EulerRot::XYZ, 0.4, 1.0, 0.2),
    ));
    // The oblique near plane must not bend the sky.
    let crossed = floor("sky-crossed").object(Cuboid::default(), RED, at(1.0, 0.1, 0.0));
    studio.assert_reflects(&sky(crossed, Quat::IDENTITY));
    let leaning = Transform::from_rotation(Quat::from_euler(EulerRot::XYZ, -0.5, 0.6, 0.3));
    let leaning = Scene::new("sky-leaning").mirror(Surface::wall(4.0, 2.5, leaning));
    studio.assert_reflects(&sky(leaning, Quat::IDENTITY));
}

#[test]
fn where_nothing_is_the_reflection_shows_the_clear_color() {
    let mut studio = Studio::default();
    let mut scene = wall("clear-global").object(Cuboid::default(), RED, turned(0.9, 0.0, 1.5));
    scene.clear_color = Color::srgb(0.3, 0.7, 0.1);
    let picture = studio.assert_reflects(&scene);
    assert!(is(scene.clear_color)(picture.at(60, 60)));
}

#[test]
fn a_cameras_own_clear_color_is_that_of_its_reflection() {
    let own = Color::srgb(0.8, 0.3, 0.1);
    let mut scene = wall("clear-own").object(Cuboid::default(), BLUE, turned(0.9, 0.0, 1.5));
    // What shines through from behind is not the clear color.
    scene = scene.object(Rectangle::new(2.0, 2.0), GREEN, at(-0.5, 0.0, -1.0));
    let scene = scene.touch_camera(move |camera| {
        camera.get_mut::<Camera>().expect("a camera").clear_color = ClearColorConfig::Custom(own);
    });
    let picture = assert_reflects(&scene);
    assert!(is(own)(picture.at(60, 60)));
}

/// Such a camera draws over what others drew, which has no reflection.
#[test]
fn a_camera_that_does_not_clear_reflects_the_global_clear_color() {
    let mut scene = wall("clear-none").object(Cuboid::default(), BLUE, turned(0.9, 0.0, 1.5));
    scene.clear_color = Color::srgb(0.3, 0.7, 0.1);
    scene = scene.object(Rectangle::new(2.0, 2.0), GREEN, at(-0.5, 0.0, -1.0));
    let scene = scene.touch_camera(|camera| {
        camera.get_mut::<Camera>().expect("a camera").clear_color = ClearColorConfig::None;
    });
    let picture = Studio::default().picture(&scene);
    assert!(is(scene.clear_color)(picture.at(60, 60)));
    assert_eq!(picture.count(is(GREEN)), 0, "it shines through");
    assert!(!is(scene.clear_color)(picture.at(1, 60)), "it was cleared");
}
