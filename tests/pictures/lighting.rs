//! Lights, fog and environment in the reflection.

use bevy::{
    asset::RenderAssetUsages,
    light::{
        CascadeShadowConfig, CascadeShadowConfigBuilder, EnvironmentMapLight, IrradianceVolume,
        LightProbe, cluster::ClusterConfig,
    },
    pbr::{DistanceFog, FogFalloff},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};

use bevy_planar_mirror::PlanarMirror;

use crate::support::{
    live::{Live, assert_each_seen_at_once, find, of},
    props::{add, at, lamp, lit, six_colors, spot, sun},
    scene::{Scene, Surface},
    studio::{Studio, assert_reflects},
};

/// A ball and a box on a table that is partly a mirror, and a wall that catches shadows.
pub fn still_life(name: &str) -> Scene {
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

/// Low enough that the shadows fall on the wall behind the things.
pub fn evening_sun(
    from: Vec3,
    cascades: usize,
) -> (DirectionalLight, CascadeShadowConfig, Transform) {
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
pub fn low_spot() -> impl Bundle + Clone {
    spot(vec3(0.6, 1.0, 3.0), vec3(-0.3, 0.6, 0.0), true)
}

#[test]
fn a_sun_without_shadows_lights_the_reflection() {
    assert_reflects(&still_life("sun").prop(sun(false)));
}

/// A faint lamp that reaches no farther than two units.
fn candle(place: Vec3) -> impl Bundle + Clone {
    let light = PointLight {
        color: Color::srgb(1.0, 0.6, 0.2),
        intensity: 8_000.0,
        range: 2.0,
        ..default()
    };
    (light, Transform::from_translation(place))
}

/// As many lamps share one cluster, of a mirror as small as in these scenes. Any more are sorted by the engine.
const LISTED: usize = 32;

fn with_candles(scene: &Scene, count: usize) -> Scene {
    (0..count).fold(scene.clone(), |scene, index| {
        let across = 2.6 * index as f32 / count as f32;
        scene.prop(candle(vec3(across - 1.3, 0.6, 0.6)))
    })
}

#[test]
fn lamps_that_come_and_go_light_the_reflection_at_once() {
    let scene = with_candles(&still_life("one-lamp-more").prop(low_spot()), LISTED - 1);
    let come = |world: &mut World| {
        world.spawn((Name::new("last"), candle(vec3(0.2, 0.2, 0.9))));
    };
    let moved = |world: &mut World| {
        of::<Transform>(world, "last").translation = vec3(-0.7, 0.3, 0.7);
    };
    let go = |world: &mut World| {
        let last = find(world, "last");
        world.despawn(last);
    };
    assert_each_seen_at_once(&scene, &[&come, &moved, &go]);
    let mut more = scene;
    more.name += "-more";
    assert_reflects(&more.prop(candle(vec3(0.2, 0.2, 0.9))));
}

#[test]
fn a_mirror_that_comes_into_view_among_many_lamps_is_lit_at_once() {
    let scene = with_candles(&still_life("comes-lit").prop(low_spot()), LISTED);
    let expected = Studio::default().picture(&scene);
    let mut before = scene;
    before.mirrors[0].transform.translation.z += 50.0;
    let mut live = Live::new(&before);
    live.settled();
    let mut mirrors = live
        .world()
        .query_filtered::<&mut Transform, With<PlanarMirror>>();
    let mut mirror = mirrors.single_mut(live.world()).expect("there is one");
    mirror.translation.z -= 50.0;
    for frame in 0..4 {
        live.next()
            .assert_same(&expected, &format!("comes-lit-{frame}"));
    }
}

/// The middle of the picture is then the floor's horizon, where the near plane of a cut reflection is met by no ray.
#[test]
fn lamps_light_what_a_level_camera_sees_in_a_floor() {
    for (size, clusters) in [
        (uvec2(160, 100), None),
        (uvec2(100, 160), None),
        (uvec2(160, 120), Some(uvec3(4, 2, 24))),
        (uvec2(160, 120), Some(uvec3(1, 2, 5))),
    ] {
        let mut few = still_life(&format!("level-{size}-{clusters:?}"))
            .eye(vec3(0.0, 1.6, 4.0), vec3(0.0, 1.6, 0.0))
            .prop(low_spot())
            .prop(lamp(vec3(1.0, 2.0, 2.0), false));
        few.size = size;
        if let Some(dimensions) = clusters {
            few = few.with_camera(ClusterConfig::XYZ {
                dimensions,
                z_config: default(),
                dynamic_resizing: false,
            });
        }
        let mut many = with_candles(&few, LISTED);
        many.name += "-many";
        assert_reflects(&few);
        assert_reflects(&many);
    }
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
