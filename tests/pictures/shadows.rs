//! Shadows in the reflection.

use bevy::{light::ShadowFilteringMethod, prelude::*};
use bevy_planar_mirror::MirrorShadows;

use super::lighting::{evening_sun, low_spot, still_life};
use crate::support::{
    live::{Live, assert_each_seen_at_once, of},
    props::{at, lamp, lit, still_noise},
    scene::{Scene, Surface},
    studio::{SHARE, Studio, TOLERANCE, assert_reflects},
};

/// A post behind an upright mirror, whose shadow falls over the floor before it.
pub fn shadow_from_behind() -> Scene {
    Scene::new("shadow-from-behind")
        .eye(vec3(0.0, 1.6, 4.0), vec3(0.0, 0.2, 0.0))
        .mirror(Surface::wall(4.0, 2.0, at(0.0, 1.0, 0.0)))
        .object(
            Cuboid::new(0.4, 4.0, 0.4),
            lit(Color::WHITE),
            at(0.0, 0.0, -0.6),
        )
        .object(
            Cuboid::new(8.0, 0.2, 8.0),
            lit(Color::WHITE),
            at(0.0, -0.3, 0.0),
        )
        .prop((
            DirectionalLight {
                illuminance: 6000.0,
                shadow_maps_enabled: true,
                ..default()
            },
            at(0.5, 2.0, -2.0).looking_at(Vec3::ZERO, Vec3::Y),
        ))
}

#[test]
fn a_suns_shadows_lie_right_in_the_reflection() {
    let scene = still_life("sun-shadows").prop(evening_sun(vec3(1.0, 1.2, 3.0), 2));
    assert_shadows_matter(&scene);
    assert_reflects(&scene);
}

#[test]
fn a_point_lights_shadows_lie_right_in_the_reflection() {
    let scene = still_life("lamp-shadows").prop(lamp(vec3(1.0, 2.0, 2.0), true));
    assert_shadows_matter(&scene);
    assert_reflects(&scene);
}

#[test]
fn a_spot_lights_shadows_lie_right_in_the_reflection() {
    let scene = still_life("spot-shadows").prop(low_spot());
    assert_shadows_matter(&scene);
    assert_reflects(&scene);
}

#[test]
fn shadows_of_sun_lamp_and_spot_together_lie_right() {
    let scene = still_life("all-shadows")
        .prop(evening_sun(vec3(1.0, 1.2, 3.0), 2))
        .prop(lamp(vec3(-1.5, 2.0, 2.0), true))
        .prop(low_spot());
    assert_shadows_matter(&scene);
    assert_reflects(&scene);
}

/// All cascades of all suns lie in one array, and the maps of spots behind them.
#[test]
fn shadows_of_suns_with_different_numbers_of_cascades_lie_right() {
    let scene = still_life("suns")
        .prop(evening_sun(vec3(1.0, 1.2, 3.0), 1))
        .prop(evening_sun(vec3(0.0, 2.0, 2.0), 0))
        .prop(evening_sun(vec3(-2.0, 1.0, 3.0), 4))
        .prop(evening_sun(vec3(0.4, 0.6, 3.0), 3))
        .prop(low_spot());
    assert_shadows_matter(&scene);
    assert_reflects(&scene);
}

/// Soft, softer, and noisy shadows. The noise is a pattern of the screen, so the reference must
/// not be flipped.
#[test]
fn shadows_are_filtered_in_the_reflection_as_the_camera_says() {
    use ShadowFilteringMethod::{Gaussian, Hardware2x2, Temporal};
    let mut studio = None;
    let mut last = None;
    for method in [Hardware2x2, Gaussian, Temporal] {
        let scene = still_life(&format!("filter-{method:?}"))
            .prop(evening_sun(vec3(1.0, 1.2, 3.0), 1))
            .prop(low_spot())
            .with_camera(method)
            .plugin(still_noise);
        let studio = studio.get_or_insert_with(|| Studio::of(&scene));
        let picture = studio.assert_reflects_in_place(&scene);
        let mask = studio.mask(&scene, 0);
        if let Some(last) = last {
            let other = picture.difference(&last, 8, |place| mask.inside(place));
            assert!(
                other.as_ref().is_ok_and(|other| other.beyond > 5),
                "{method:?} filters as the one before: {other:?}"
            );
        }
        last = Some(picture);
    }
}

/// The arrays of shadow maps grow when a light comes, and its maps move when another goes.
#[test]
fn lights_that_come_and_go_throw_their_shadows_at_once() {
    let bare = still_life("come-and-go").prop(lamp(vec3(-1.5, 2.0, 2.0), true));
    let with_spot = bare.clone().prop(low_spot());
    let with_both = with_spot.clone().prop(evening_sun(vec3(1.0, 1.2, 3.0), 2));
    let mut studio = Studio::default();
    let expected = [&bare, &with_spot, &with_both].map(|scene| studio.picture(scene));
    let mut live = Live::new(&bare);
    live.settled().assert_same(&expected[0], "lights-0");
    live.world().spawn(low_spot());
    live.settled().assert_same(&expected[1], "lights-1");
    let sun = live.world().spawn(evening_sun(vec3(1.0, 1.2, 3.0), 2)).id();
    live.settled().assert_same(&expected[2], "lights-2");
    live.world().despawn(sun);
    live.settled().assert_same(&expected[1], "lights-3");
}

/// In a mirror that shows a small part of what the sun's cascades hold.
fn small_mirror(name: &str, sun: impl Bundle + Clone) -> Scene {
    let mut scene = still_life(name).prop((Name::new("sun"), sun));
    scene.mirrors = vec![Surface::floor(1.2, 0.8, at(0.0, 0.0, 0.6))];
    scene
}

/// Of a shadow map only the part is drawn that the mirror reads, and the rest is what an earlier
/// frame left there.
#[test]
fn no_shadow_is_left_over_from_where_the_sun_and_the_eye_have_been() {
    let scene = small_mirror("left-over", evening_sun(vec3(-0.6, 0.3, 3.0), 2));
    assert_shadows_matter(&scene);
    let sun_from = |from: Vec3| {
        move |world: &mut World| {
            *of::<Transform>(world, "sun") =
                Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Y);
        }
    };
    let eye_at = |eye: Vec3| {
        move |world: &mut World| {
            let mut cameras = world.query_filtered::<&mut Transform, With<Camera3d>>();
            let mut camera = cameras.single_mut(world).expect("there is one");
            *camera = Transform::from_translation(eye).looking_at(vec3(0.0, 0.3, 0.0), Vec3::Y);
        }
    };
    assert_each_seen_at_once(
        &scene,
        &[
            &sun_from(vec3(-1.2, 0.1, 3.0)),
            &eye_at(vec3(1.0, 1.2, 3.5)),
            &sun_from(vec3(-0.3, 0.5, 3.0)),
            &eye_at(vec3(-0.6, 1.9, 4.2)),
        ],
    );
}

/// A bias moves the place where a shadow is looked up along the normal, by any distance: here the
/// wall's by some meters, to behind a box that throws no other shadow that is seen.
#[test]
fn shadows_that_are_looked_up_far_beside_lie_right() {
    let (mut light, cascades, place) = evening_sun(vec3(3.0, 2.0, 0.8), 1);
    light.shadow_normal_bias = 240.0;
    let scene = small_mirror("bias", (light, cascades, place)).object(
        Cuboid::from_length(1.6),
        lit(Color::WHITE),
        at(2.2, 2.1, 3.2),
    );
    assert_shadows_matter(&scene);
    assert_reflects(&scene);
}

#[test]
fn an_object_behind_the_mirror_throws_its_shadow_before_it() {
    assert_reflects(&shadow_from_behind());
}

/// Without shadows the reflection would be another one: else the test would test nothing.
fn assert_shadows_matter(scene: &Scene) {
    let mut studio = Studio::default();
    let dark = studio.reference(scene, 0);
    let mut bright = scene.clone();
    for prop in &mut bright.props {
        let lit = prop.clone();
        *prop = std::sync::Arc::new(move |entity| {
            lit(entity);
            if let Some(mut light) = entity.get_mut::<DirectionalLight>() {
                light.shadow_maps_enabled = false;
            }
            if let Some(mut light) = entity.get_mut::<PointLight>() {
                light.shadow_maps_enabled = false;
            }
            if let Some(mut light) = entity.get_mut::<SpotLight>() {
                light.shadow_maps_enabled = false;
            }
        });
    }
    let mask = studio.mask(scene, 0);
    let difference = studio
        .reference(&bright, 0)
        .difference(&dark, 8, |place| mask.inside(place));
    assert!(
        difference.as_ref().is_ok_and(|d| d.beyond > 30),
        "no shadow in the reflection: {difference:?}"
    );
}

/// What is seen in it is lit as if the sun threw no shadows; the scene keeps them.
#[test]
fn a_mirror_may_do_without_shadows() {
    let mut scene = still_life("without-shadows").prop(evening_sun(vec3(1.0, 1.2, 3.0), 2));
    scene.mirrors[0].mirror.shadows = MirrorShadows::Off;
    let shadowless = still_life("shadowless").prop(evening_sun(vec3(1.0, 1.2, 3.0), 0));
    let mut studio = Studio::default();
    let picture = studio.picture(&scene);
    let mask = studio.mask(&scene, 0);
    let expected = studio.reference(&shadowless, 0);
    let inside = |place| mask.inside(place);
    picture.assert_alike(
        &expected,
        TOLERANCE,
        SHARE,
        inside,
        "without-shadows-inside",
    );
    studio.assert_untouched_outside(&scene, &picture);
    let shadowed = studio.reference(&scene, 0);
    let difference = shadowed.difference(&expected, TOLERANCE, inside);
    assert!(difference.is_ok_and(|difference| difference.beyond > 50));
}
