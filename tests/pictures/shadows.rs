//! Shadows in the reflection.

use bevy::{
    camera::visibility::RenderLayers,
    light::{CascadeShadowConfigBuilder, ShadowFilteringMethod},
    prelude::*,
};
use bevy_planar_mirror::{MirrorFigures, MirrorShadows, PlanarMirrorPlugin};

use super::lighting::{evening_sun, low_spot, still_life};
use crate::support::{
    live::{Live, assert_each_seen_at_once, of},
    props::{at, lamp, lit, still_noise},
    scene::{Scene, Surface},
    stage::Stage,
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
    assert_shadows_lie_right(scene);
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
    assert_shadows_lie_right(scene);
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
    assert_shadows_lie_right(scene);
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
    let mut scene = small_mirror("left-over", evening_sun(vec3(-0.6, 0.3, 3.0), 2));
    scene.mirrors[0].mirror.shadows = MirrorShadows::Own;
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

/// Whose shadows are looked up meters away.
fn far_bias_sun() -> impl Bundle + Clone {
    let (mut light, cascades, place) = evening_sun(vec3(3.0, 2.0, 0.8), 1);
    light.shadow_normal_bias = 240.0;
    (light, cascades, place)
}

/// A bias moves the place where a shadow is looked up along the normal, by any distance: here the
/// wall's by some meters, to behind a box that throws no other shadow that is seen.
#[test]
fn shadows_that_are_looked_up_far_beside_lie_right() {
    let scene = small_mirror("bias", far_bias_sun()).object(
        Cuboid::from_length(1.6),
        lit(Color::WHITE),
        at(2.2, 2.1, 3.2),
    );
    assert_shadows_lie_right(scene);
}

#[test]
fn an_object_behind_the_mirror_throws_its_shadow_before_it() {
    assert_reflects(&shadow_from_behind());
}

/// With maps of the mirror's own, and with the camera's where they serve.
fn assert_shadows_lie_right(mut scene: Scene) {
    assert_shadows_matter(&scene);
    for shadows in [MirrorShadows::Own, MirrorShadows::Auto] {
        scene.mirrors[0].mirror.shadows = shadows;
        assert_reflects(&scene);
    }
}

/// Where the shadows in the one mirror of a picture came from.
fn source(studio: &mut Studio) -> MirrorShadows {
    studio.stage().world().resource::<MirrorFigures>().views[0].shadows
}

/// For each filter and number of lights, nearly texel for texel: the depths are rounded otherwise.
#[test]
fn the_cameras_maps_show_the_shadows_of_the_mirrors_own() {
    use ShadowFilteringMethod::{Gaussian, Hardware2x2, Temporal};
    let sun = || evening_sun(vec3(-0.6, 0.3, 3.0), 2);
    let mut scenes = vec![
        still_life("two-suns")
            .prop(evening_sun(vec3(-1.0, 1.2, 3.0), 1))
            .prop(evening_sun(vec3(1.0, 1.0, 3.0), 1))
            .prop(low_spot()),
        small_mirror("far-bias", far_bias_sun()),
    ];
    for method in [Hardware2x2, Gaussian, Temporal] {
        let scene = small_mirror(&format!("alike-{method:?}"), sun()).with_camera(method);
        scenes.push(scene.plugin(still_noise));
    }
    for scene in scenes {
        let mut studio = Studio::of(&scene);
        let mut drawn = |shadows| {
            let mut scene = scene.clone();
            scene.mirrors[0].mirror.shadows = shadows;
            (studio.picture(&scene), source(&mut studio))
        };
        let (shared, from) = drawn(MirrorShadows::Auto);
        assert_eq!(from, MirrorShadows::Shared, "{}", scene.name);
        let (own, from) = drawn(MirrorShadows::Own);
        assert_eq!(from, MirrorShadows::Own);
        let what = format!("{}-shared", scene.name);
        shared.assert_alike(&own, TOLERANCE, SHARE, |_| true, &what);
    }
}

/// A mirror on the wall, and what it shows behind the camera, where the camera's maps end.
fn behind_the_camera() -> Scene {
    let (light, _, _) = evening_sun(Vec3::Y, 1);
    let config = CascadeShadowConfigBuilder {
        num_cascades: 1,
        maximum_distance: 10.0,
        ..default()
    };
    Scene::new("behind-the-camera")
        .eye(vec3(0.0, 1.6, 4.0), vec3(0.0, 0.8, 0.0))
        .fov(20.0)
        .mirror(Surface::wall(4.0, 2.0, at(0.0, 1.0, 0.0)))
        .object(
            Cuboid::from_length(0.4),
            lit(Color::WHITE),
            at(0.2, 0.6, 5.2),
        )
        .object(
            Cuboid::new(8.0, 0.2, 12.0),
            lit(Color::WHITE),
            at(0.0, -0.1, 1.0),
        )
        .prop((
            light,
            config.build(),
            at(0.4, 2.0, 0.3).looking_at(Vec3::ZERO, Vec3::Y),
        ))
}

#[test]
fn a_mirror_has_maps_of_its_own_where_the_cameras_end() {
    let scene = behind_the_camera();
    assert_shadows_matter(&scene);
    let mut studio = Studio::default();
    studio.assert_reflects(&scene);
    assert_eq!(source(&mut studio), MirrorShadows::Own);
}

/// Every pixel is as with all shadows or as with none, and some of the first are of the second.
#[test]
fn what_the_cameras_maps_do_not_reach_is_lit_if_no_others_may_be_drawn() {
    let mut scene = behind_the_camera();
    scene.mirrors[0].mirror.shadows = MirrorShadows::Shared;
    let mut studio = Studio::default();
    let picture = studio.picture(&scene);
    assert_eq!(source(&mut studio), MirrorShadows::Shared);
    let mask = studio.mask(&scene, 0);
    let shadowed = studio.reference(&scene, 0);
    let lit = studio.reference(&without_shadows(&scene), 0);
    let inside = |place| mask.inside(place);
    let expected = picture.nearer(&shadowed, &lit);
    picture.assert_alike(&expected, TOLERANCE, SHARE, inside, "unreached");
    let unreached = picture.difference(&shadowed, TOLERANCE, inside);
    assert!(unreached.is_ok_and(|unreached| unreached.beyond > 50));
}

/// The scene, in which no light throws shadows.
fn without_shadows(scene: &Scene) -> Scene {
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
    bright
}

/// Without shadows the reflection would be another one: else the test would test nothing.
fn assert_shadows_matter(scene: &Scene) {
    let mut studio = Studio::default();
    let dark = studio.reference(scene, 0);
    let bright = without_shadows(scene);
    let mask = studio.mask(scene, 0);
    let difference = studio
        .reference(&bright, 0)
        .difference(&dark, 8, |place| mask.inside(place));
    assert!(
        difference.as_ref().is_ok_and(|d| d.beyond > 30),
        "no shadow in the reflection: {difference:?}"
    );
}

/// The engine moves the map of a spot to another layer only in a frame in which the light changes.
fn keep_spots_changing(app: &mut App) {
    app.add_systems(Update, |mut spots: Query<&mut SpotLight>| {
        spots.iter_mut().for_each(|mut spot| spot.set_changed());
    });
}

/// A floor before an upright mirror, and a box on it in the light of a spot.
fn spot_and_suns(name: &str, suns: &[(usize, f32, usize)]) -> Scene {
    let mut scene = Scene::new(name)
        .eye(vec3(-0.9, 0.3, 4.0), vec3(-0.2, 0.0, 0.0))
        .mirror(Surface::wall(4.0, 3.0, Transform::default()))
        .object(
            Cuboid::new(8.0, 0.1, 8.0),
            lit(Color::WHITE),
            at(0.0, -1.2, 2.0),
        )
        .object(
            Cuboid::from_length(0.6),
            lit(Color::WHITE),
            at(0.9, -0.5, 1.5),
        )
        .prop((
            SpotLight {
                shadow_maps_enabled: true,
                intensity: 2e6,
                ..default()
            },
            at(0.5, 3.0, 1.5).looking_at(vec3(0.9, -1.2, 1.5), Vec3::Z),
        ))
        .plugin(keep_spots_changing);
    for &(cascades, far, layer) in suns {
        scene = scene.prop((
            DirectionalLight {
                shadow_maps_enabled: true,
                illuminance: 800.0,
                ..default()
            },
            CascadeShadowConfigBuilder {
                num_cascades: cascades,
                first_cascade_far_bound: 0.3 * far,
                maximum_distance: far,
                ..default()
            }
            .build(),
            RenderLayers::layer(layer),
            Transform::default().looking_to(vec3(0.3, -1.0, -0.2), Vec3::Y),
        ));
    }
    scene.mirrors[0].mirror.shadows = MirrorShadows::Own;
    scene.size = UVec2::new(120, 90);
    scene
}

/// The spot's map lies behind the cascades of the camera that has most of them in this frame.
#[test]
fn a_spots_shadow_stays_when_a_camera_with_more_cascades_is_switched_off() {
    let scene = spot_and_suns("camera-switch", &[(1, 20.0, 0), (4, 20.0, 1)])
        .with_camera(RenderLayers::layer(0));
    let live = || {
        let stage = Stage::as_games_run(|app| {
            app.add_plugins(PlanarMirrorPlugin::default());
            keep_spots_changing(app);
        });
        Live::on(stage, &scene)
    };
    let expected = live().settled();
    let mut live = live();
    let size = live.size;
    let target = live.stage.target(size);
    let other = live.world().spawn((
        scene.camera_bundle(),
        bevy::camera::RenderTarget::from(target),
        scene.eye,
        RenderLayers::from_layers(&[0, 1]),
    ));
    let other = other.id();
    for _ in 0..4 {
        live.next();
    }
    let mut camera = live.world().get_mut::<Camera>(other).expect("it is one");
    camera.is_active = false;
    for _ in 0..3 {
        live.next();
    }
    live.next().assert_same(&expected, "camera-switch");
}

/// Of the first there is nothing to draw. The maps of the second lie behind the layers that it would
/// have.
#[test]
fn the_maps_of_one_sun_lie_right_where_anothers_end_before_what_is_seen() {
    for suns in [[(3, 2.0, 0), (2, 20.0, 0)], [(2, 20.0, 0), (3, 2.0, 0)]] {
        let scene = spot_and_suns(&format!("two-suns-{suns:?}"), &suns);
        assert_shadows_matter(&scene);
        Studio::of(&scene).assert_reflects(&scene);
    }
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
