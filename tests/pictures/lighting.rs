//! Lights, shadows, fog and environment in the reflection.

use bevy::{
    asset::RenderAssetUsages,
    light::{
        CascadeShadowConfig, CascadeShadowConfigBuilder, EnvironmentMapLight, IrradianceVolume,
        LightProbe, ShadowFilteringMethod, cluster::ClusterConfig,
    },
    pbr::{DistanceFog, FogFalloff},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};

use bevy_planar_mirror::MirrorShadows;

use crate::support::{
    live::{Live, assert_each_seen_at_once, of},
    props::{add, at, lamp, lit, six_colors, spot, still_noise, sun},
    scene::{Scene, Surface},
    studio::{SHARE, Studio, TOLERANCE, assert_reflects},
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

/// Low enough that the shadows fall on the wall behind the things.
fn evening_sun(from: Vec3, cascades: usize) -> (DirectionalLight, CascadeShadowConfig, Transform) {
    let light = DirectionalLight {
        illuminance: 3000.0,
        shadow_maps_enabled: cascades > 0,
        ..default()
    };
    let cascades = CascadeShadowConfigBuilder {
        num_cascades: cascades.max(1),
        maximum_distance: 20.0,
        first_cascade_far_bound: if cascades > 1 { 6.0 } else { 20.0 },
        ..default()
    };
    (
        light,
        cascades.build(),
        Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Y),
    )
}

/// Of a lamp that stands low, so that shadows fall on the wall.
fn low_spot() -> impl Bundle + Clone {
    spot(vec3(0.6, 1.0, 3.0), vec3(-0.3, 0.6, 0.0), true)
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

/// The middle of the picture is then the floor's horizon, where the near plane of a cut reflection is met by no ray.
#[test]
fn lamps_light_what_a_level_camera_sees_in_a_floor() {
    for (size, clusters) in [
        (uvec2(160, 100), None),
        (uvec2(100, 160), None),
        (uvec2(160, 120), Some(uvec3(4, 2, 24))),
        (uvec2(160, 120), Some(uvec3(1, 2, 1))),
    ] {
        let mut scene = still_life(&format!("level-{size}-{clusters:?}"))
            .eye(vec3(0.0, 1.6, 4.0), vec3(0.0, 1.6, 0.0))
            .prop(low_spot())
            .prop(lamp(vec3(1.0, 2.0, 2.0), false));
        scene.size = size;
        if let Some(dimensions) = clusters {
            scene = scene.with_camera(ClusterConfig::XYZ {
                dimensions,
                z_config: default(),
                dynamic_resizing: false,
            });
        }
        assert_reflects(&scene);
    }
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
    let falloffs = [
        FogFalloff::Linear {
            start: 2.0,
            end: 9.0,
        },
        FogFalloff::Exponential { density: 0.15 },
        FogFalloff::ExponentialSquared { density: 0.15 },
        FogFalloff::from_visibility_colors(
            9.0,
            Color::srgb(0.35, 0.5, 0.66),
            Color::srgb(0.8, 0.84, 1.0),
        ),
    ];
    let mut studio = Studio::default();
    for (i, falloff) in falloffs.into_iter().enumerate() {
        let fog = DistanceFog {
            color: Color::srgb(0.6, 0.7, 0.8),
            // Brighter towards the sun, also where one looks at it through the mirror.
            directional_light_color: Color::srgb(1.0, 0.8, 0.4),
            directional_light_exponent: 4.0,
            falloff,
        };
        let scene = still_life(&format!("fog-{i}"))
            .prop(evening_sun(vec3(1.0, 1.2, 3.0), 0))
            .with_camera(fog);
        studio.assert_reflects(&scene);
    }
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
fn a_turned_environment_map_is_turned_in_the_reflection() {
    let shiny = StandardMaterial {
        perceptual_roughness: 0.1,
        metallic: 1.0,
        ..lit(Color::WHITE)
    };
    let mut scene = still_life("environment-turned").touch_camera(|camera| {
        let map = add(camera, six_colors());
        camera.insert(EnvironmentMapLight {
            diffuse_map: map.clone(),
            specular_map: map,
            intensity: 900.0,
            rotation: Quat::from_euler(EulerRot::XYZ, 0.5, 1.2, 0.3),
            ..default()
        });
    });
    scene.objects[0].look = shiny.into();
    assert_reflects(&scene);
}

#[test]
fn an_irradiance_volume_lights_the_reflection() {
    let mut scene = still_life("irradiance");
    scene.props.push(std::sync::Arc::new(|entity| {
        let voxels = add(entity, voxels());
        entity.insert((
            LightProbe::default(),
            IrradianceVolume {
                voxels,
                intensity: 3000.0,
                ..default()
            },
            at(0.0, 1.0, 0.0).with_scale(vec3(6.0, 4.0, 6.0)),
        ));
    }));
    assert_light_matters(&scene);
    assert_reflects(&scene);
}

/// Two voxels along each axis, another color to each of the six sides.
fn voxels() -> Image {
    let size = Extent3d {
        width: 2,
        height: 4,
        depth_or_array_layers: 6,
    };
    let texel = |x: u32, y: u32, z: u32| {
        [
            60 + 150 * x as u8,
            40 + 60 * y as u8,
            250 - 40 * z as u8,
            255,
        ]
    };
    let data = (0..6)
        .flat_map(|z| (0..4).flat_map(move |y| (0..2).map(move |x| (x, y, z))))
        .flat_map(|(x, y, z)| texel(x, y, z))
        .collect();
    let format = TextureFormat::Rgba8Unorm;
    let usage = RenderAssetUsages::default();
    Image::new(size, TextureDimension::D3, data, format, usage)
}

/// Without its lights the reflection would be another one: else the test would test nothing.
fn assert_light_matters(scene: &Scene) {
    let mut studio = Studio::default();
    let lit = studio.reference(scene, 0);
    let mut dark = scene.clone();
    dark.props.clear();
    let mask = studio.mask(scene, 0);
    let difference = studio
        .reference(&dark, 0)
        .difference(&lit, 8, |place| mask.inside(place));
    assert!(
        difference.as_ref().is_ok_and(|d| d.beyond > 300),
        "it lights nothing: {difference:?}"
    );
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
