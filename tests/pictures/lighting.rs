//! Lights, shadows, fog and environment in the reflection.

use bevy::{
    light::EnvironmentMapLight,
    pbr::{DistanceFog, FogFalloff},
    prelude::*,
};

use crate::support::{
    props::{add, at, lamp, lit, six_colors, spot, sun},
    scene::{Scene, Surface},
    studio::{Studio, assert_reflects},
};

/// A ball and a box on a table that is partly a mirror, and a wall that catches shadows.
fn still_life(name: &str) -> Scene {
    Scene::new(name)
        .eye(vec3(0.0, 1.6, 4.0), vec3(0.0, 0.3, 0.0))
        .mirror(Surface::floor(4.0, 4.0, Transform::default()))
        .object(
            Sphere::new(0.5).mesh().uv(32, 18),
            lit(Color::srgb(0.9, 0.5, 0.4)),
            at(-0.8, 0.7, 0.2),
        )
        .object(
            Cuboid::from_length(0.7),
            lit(Color::srgb(0.4, 0.6, 0.9)),
            at(0.8, 0.2, 0.0),
        )
        .object(
            Cuboid::new(4.0, 2.0, 0.2),
            lit(Color::srgb(0.8, 0.8, 0.7)),
            at(0.0, 1.2, -1.4),
        )
}

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
fn a_sun_without_shadows_lights_the_reflection() {
    assert_reflects(&still_life("sun").prop(sun(false)));
}

#[test]
fn a_suns_shadows_lie_right_in_the_reflection() {
    let scene = still_life("sun-shadows").prop(sun(true));
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
    let scene = still_life("spot-shadows").prop(spot(vec3(1.5, 3.0, 2.0), Vec3::ZERO, true));
    assert_shadows_matter(&scene);
    assert_reflects(&scene);
}

#[test]
fn shadows_of_sun_lamp_and_spot_together_lie_right() {
    let scene = still_life("all-shadows")
        .prop(sun(true))
        .prop(lamp(vec3(-1.5, 2.0, 2.0), true))
        .prop(spot(vec3(1.5, 3.0, 2.0), Vec3::ZERO, true));
    assert_reflects(&scene);
}

#[test]
fn an_object_behind_the_mirror_throws_its_shadow_before_it() {
    assert_reflects(&shadow_from_behind());
}

#[test]
fn ambient_light_lights_the_reflection() {
    let mut scene = still_life("ambient");
    scene.ambient.brightness = 600.0;
    assert_reflects(&scene);
}

#[test]
fn a_cameras_own_ambient_light_lights_the_reflection() {
    let ambient = AmbientLight {
        color: Color::srgb(0.5, 0.9, 0.3),
        brightness: 900.0,
        ..default()
    };
    assert_reflects(&still_life("camera-ambient").with_camera(ambient));
}

#[test]
fn fog_thickens_with_the_length_of_the_reflected_way() {
    let fog = DistanceFog {
        color: Color::srgb(0.6, 0.7, 0.8),
        falloff: FogFalloff::Linear {
            start: 2.0,
            end: 9.0,
        },
        ..default()
    };
    assert_reflects(&still_life("fog").prop(sun(false)).with_camera(fog));
}

#[test]
fn an_environment_map_lights_the_reflection() {
    let scene = still_life("environment").touch_camera(|camera| {
        let map = add(camera, six_colors());
        camera.insert(EnvironmentMapLight {
            diffuse_map: map.clone(),
            specular_map: map,
            intensity: 900.0,
            ..default()
        });
    });
    assert_reflects(&scene);
}

#[test]
fn shiny_things_have_their_highlights_at_the_reflected_place() {
    let shiny = StandardMaterial {
        base_color: Color::srgb(0.3, 0.3, 0.5),
        perceptual_roughness: 0.3,
        metallic: 0.5,
        ..default()
    };
    let mut scene = still_life("highlights").prop(lamp(vec3(0.5, 2.0, 2.0), false));
    scene.objects[0].look = shiny.into();
    assert_reflects(&scene);
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
