//! What else a camera carries that changes its picture while it is drawn.

use bevy::{
    core_pipeline::{
        oit::OrderIndependentTransparencySettings,
        prepass::{DepthPrepass, NormalPrepass},
    },
    light::{FogVolume, VolumetricFog, VolumetricLight},
    pbr::{
        ContactShadows, MaterialPlugin,
        decal::{ForwardDecal, ForwardDecalMaterial, ForwardDecalMaterialExt},
    },
    prelude::*,
};

use crate::support::{
    props::{BLUE, GREEN, RED, YELLOW, add, at, glass, is, lit, still_noise, sun},
    scene::{Look, Scene, Surface},
    studio::{SHARE, Studio, TOLERANCE},
};

fn wall(name: &str) -> Scene {
    Scene::new(name)
        .eye(vec3(0.9, 0.5, 4.0), Vec3::ZERO)
        .mirror(Surface::wall(4.0, 2.6, Transform::default()))
}

/// The reflection has no such buffers: its see-through things are sorted, as for any other camera.
#[test]
fn a_camera_with_order_independent_transparency_reflects_see_through_things() {
    let turned = Quat::from_rotation_y(std::f32::consts::PI);
    let plain = wall("oit")
        .object(
            Rectangle::new(1.0, 1.0),
            glass(RED, 0.4),
            at(-0.6, 0.0, 1.0).with_rotation(turned),
        )
        .object(
            Rectangle::new(1.2, 1.2),
            glass(BLUE, 0.6),
            at(-0.2, 0.0, 1.6).with_rotation(turned),
        )
        .object(
            Rectangle::new(4.0, 0.4),
            YELLOW,
            at(0.0, 0.0, 3.0).with_rotation(turned),
        )
        // Before the mirror, seen by the camera alone.
        .object(
            Rectangle::new(0.5, 0.5),
            glass(GREEN, 0.5),
            at(0.9, 0.2, 1.0),
        );
    let mut tinted = plain.clone();
    tinted.mirrors[0].look = Some(glass(BLUE, 0.3).into());
    let mut studio = Studio::default();
    for (name, scene) in [("perfect", plain), ("tinted", tinted)] {
        let sorted = studio.picture(&scene);
        let scene = scene.with_camera(OrderIndependentTransparencySettings::default());
        let picture = studio.picture(&scene);
        // It adds the layers up in another order, and rounds otherwise.
        picture.assert_alike(&sorted, TOLERANCE, SHARE, |_| true, &format!("oit-{name}"));
        if name == "perfect" {
            // A camera of the engine's at the reflected eye, with transparency of the same kind.
            let reference = studio.reference(&scene, 0);
            let mask = studio.mask(&scene, 0);
            let inside = |place| mask.inside(place);
            picture.assert_alike(&reference, 3, 0.995, inside, "oit-reference");
        }
    }
}

/// They are found in the depths of the camera's picture, where a reflection has none: what is
/// reflected has no such shadows, and what is beside the mirror has them as ever.
#[test]
fn contact_shadows_fall_beside_the_mirror_alone() {
    let sun = |contact_shadows_enabled| {
        (
            DirectionalLight {
                illuminance: 6000.0,
                contact_shadows_enabled,
                ..default()
            },
            at(1.0, 3.0, 1.5).looking_at(Vec3::ZERO, Vec3::Y),
        )
    };
    let scene = |name: &str, with: bool| {
        Scene::new(name)
            .eye(vec3(0.4, 1.6, 4.2), vec3(0.0, 0.1, 0.0))
            .mirror(Surface::floor(2.0, 3.0, at(1.2, 0.0, 0.0)))
            .object(
                Cuboid::new(2.4, 0.2, 3.0),
                lit(Color::WHITE),
                at(-1.0, -0.1, 0.0),
            )
            .object(Cuboid::from_length(0.3), lit(RED), at(-0.6, 0.15, 0.5))
            .object(Cuboid::from_length(0.6), lit(YELLOW), at(1.0, 0.5, 0.0))
            .object(Cuboid::from_length(0.3), lit(BLUE), at(0.9, 0.5, 0.4))
            .prop(sun(with))
            .with_camera((DepthPrepass, ContactShadows::default()))
            .plugin(still_noise)
    };
    let mut studio = Studio::of(&scene("contact", true));
    let (with, without) = (scene("contact", true), scene("contact-none", false));
    let picture = studio.picture(&with);
    let expected = studio.reference(&without, 0);
    let mask = studio.mask(&with, 0);
    picture.assert_alike(
        &expected,
        TOLERANCE,
        SHARE,
        |place| mask.inside(place),
        "contact-inside",
    );
    studio.assert_untouched_outside(&with, &picture);
    let shadows =
        studio
            .without_mirrors(&with)
            .difference(&studio.without_mirrors(&without), 8, |place| {
                mask.outside(place)
            });
    assert!(
        shadows.as_ref().is_ok_and(|shadows| shadows.beyond > 5),
        "there are none: {shadows:?}"
    );
}

fn decals(app: &mut App) {
    if !app.is_plugin_added::<MaterialPlugin<ForwardDecalMaterial<StandardMaterial>>>() {
        app.add_plugins(MaterialPlugin::<ForwardDecalMaterial<StandardMaterial>>::default());
    }
}

/// A decal is laid on what the prepass has drawn. A reflection has no prepass: the decal is left
/// out of it, and everything else is there.
#[test]
fn a_decal_is_left_out_of_the_reflection_and_breaks_nothing() {
    let decal = Look::other(|entity| {
        let material = add(
            entity,
            ForwardDecalMaterial {
                base: StandardMaterial {
                    base_color: RED,
                    unlit: true,
                    ..default()
                },
                extension: ForwardDecalMaterialExt {
                    depth_fade_factor: 1.0,
                },
            },
        );
        entity.remove::<Mesh3d>();
        entity.insert((ForwardDecal, MeshMaterial3d(material)));
    });
    let bare = Scene::new("decal")
        .eye(vec3(0.4, 1.2, 4.2), vec3(0.0, 0.4, 0.0))
        .mirror(Surface::wall(3.0, 1.6, at(0.0, 0.8, -0.5)))
        .object(
            Cuboid::new(4.0, 0.2, 3.0),
            lit(Color::WHITE),
            at(0.0, -0.1, 1.0),
        )
        .object(Cuboid::from_length(0.3), BLUE, at(-0.6, 0.15, 0.5))
        .prop(sun(false))
        .with_camera((DepthPrepass, NormalPrepass))
        .plugin(decals);
    let scene = bare
        .clone()
        .object(Rectangle::new(1.0, 1.0), decal, at(0.6, 0.0, 1.0));
    let mut studio = Studio::of(&scene);
    let without = studio.picture(&bare);
    let picture = studio.picture(&scene);
    assert!(picture.count(is(RED)) > 100, "the camera sees no decal");
    let mask = studio.mask(&bare, 0);
    picture.assert_alike(
        &without,
        0,
        1.0,
        |place| mask.inside(place),
        "decal-reflection",
    );
}

/// The fog lies before the mirror as before a wall; what is reflected has none of its own.
#[test]
fn volumetric_fog_lies_before_the_mirror() {
    let mut scene = wall("volumetric").object(Cuboid::from_length(0.7), YELLOW, at(-0.5, 0.0, 1.2));
    let mut studio = Studio::default();
    let clear = studio.picture(&scene);
    scene = scene
        .prop((
            DirectionalLight {
                illuminance: 6000.0,
                shadow_maps_enabled: true,
                ..default()
            },
            VolumetricLight,
            at(1.0, 3.0, 1.5).looking_at(Vec3::ZERO, Vec3::Y),
        ))
        .prop((
            FogVolume::default(),
            Transform::from_scale(Vec3::splat(3.0)),
        ))
        .with_camera(VolumetricFog::default());
    let picture = studio.picture(&scene);
    let mask = studio.mask(&scene, 0);
    let foggy = picture.difference(&clear, 4, |place| mask.inside(place));
    assert!(
        foggy.as_ref().is_ok_and(|foggy| foggy.beyond > 1000),
        "no fog before the mirror: {foggy:?}"
    );
}
