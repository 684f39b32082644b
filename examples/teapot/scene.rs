//! The scene and its motion: where everything is, is a function of the time and of nothing else.

use std::f32::consts::{FRAC_PI_2, TAU};

use bevy::{
    camera::ShadowLodOrigin,
    light::{DirectionalLightShadowMap, NotShadowCaster},
    math::{Affine2, ops, vec2, vec3},
    prelude::*,
};

use crate::{
    bezier::{self, TEAPOT_HEIGHT},
    marble::marble,
    settings::Settings,
    sky::sky,
};

/// The seconds that the jump and the light have run; each can be paused by itself.
#[derive(Resource, Clone, Copy, Default)]
pub struct SceneTime {
    pub jump: f32,
    pub light: f32,
}

/// The table: a flat mesh, a translucent material, a mirror.
#[derive(Component)]
pub struct Table;

#[derive(Component)]
pub struct Teapot;

/// The spot light that circles the scene, with a glowing bulb.
#[derive(Component)]
pub struct Lamp;

const TABLE_CENTER: Vec3 = vec3(0.0, -1.0, -3.0);
const TABLE_SIZE: f32 = 4.0;
const TABLE_THICKNESS: f32 = 0.2;

const TEAPOT_SCALE: f32 = 0.32;
const TEAPOT_Z: f32 = -3.5;
/// The lowest and highest height of the teapot's middle. It is 1.008 high, so it is wholly below the
/// table for a tenth of the time, and at its highest the table still shows the lid upside down.
const LOWEST: f32 = -1.8;
const HIGHEST: f32 = -0.26;

/// Everything repeats after 12 seconds.
const JUMP_SECONDS: f32 = 2.4;
const LIGHT_SECONDS: f32 = 12.0;

/// Where the camera stands, and returns to.
pub fn camera_pose() -> Transform {
    Transform::from_xyz(0.0, 0.0, 1.0).looking_at(TABLE_CENTER.with_y(0.0), Vec3::Y)
}

/// A jump as gravity would have it; the turn at the lowest point is out of sight below the table.
fn teapot_pose(seconds: f32) -> Transform {
    // -1..1 through a jump, 0 at its top; time 0 is a top.
    let phase = 2.0 * (seconds / JUMP_SECONDS + 0.5).rem_euclid(1.0) - 1.0;
    let height = HIGHEST - (HIGHEST - LOWEST) * phase * phase;
    let turn = -0.45 + 0.5 * ops::sin(TAU * seconds / LIGHT_SECONDS);
    // The mesh stands on its origin.
    let foot = height - 0.5 * TEAPOT_HEIGHT * TEAPOT_SCALE;
    Transform::from_xyz(0.0, foot, TEAPOT_Z)
        .with_rotation(Quat::from_rotation_y(turn))
        .with_scale(Vec3::splat(TEAPOT_SCALE))
}

fn lamp_pose(seconds: f32) -> Transform {
    let angle = TAU * seconds / LIGHT_SECONDS - 0.75;
    let around = vec3(3.2 * ops::sin(angle), 3.4, 3.2 * ops::cos(angle));
    Transform::from_translation(TABLE_CENTER + around)
        .looking_at(vec3(0.0, -0.9, TEAPOT_Z), Vec3::Y)
}

pub fn plugin(app: &mut App) {
    app.init_resource::<SceneTime>()
        .insert_resource(GlobalAmbientLight::NONE) // the sky lights the scene
        // Coarse enough that one sees what the filter does.
        .insert_resource(DirectionalLightShadowMap { size: 256 })
        .add_systems(Startup, setup)
        .add_systems(Update, move_along);
}

fn setup(
    mut commands: Commands,
    settings: Res<Settings>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) {
    commands.spawn((
        Camera3d::default(),
        camera_pose(),
        Projection::Perspective(PerspectiveProjection {
            fov: 65f32.to_radians(),
            ..default()
        }),
        sky(&mut images),
        ShadowLodOrigin,
    ));

    let stone = StandardMaterial {
        base_color_texture: Some(images.add(marble())),
        perceptual_roughness: 0.4,
        reflectance: 0.35,
        ..default()
    };
    // The settings add `PlanarMirror` to the table.
    commands.spawn((
        Table,
        Mesh3d(meshes.add(Plane3d::default().mesh().size(TABLE_SIZE, TABLE_SIZE))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::WHITE.with_alpha(settings.alpha),
            alpha_mode: AlphaMode::Blend,
            ..stone.clone()
        })),
        Transform::from_translation(TABLE_CENTER),
    ));
    // The edge of the slab, four upright strips; it lies below the mirror and is no part of it.
    let strip = meshes.add(Rectangle::new(TABLE_SIZE, TABLE_THICKNESS));
    let edge = materials.add(StandardMaterial {
        // The nearest strip goes on with the veins at the top's front.
        uv_transform: Affine2::from_scale_angle_translation(
            vec2(1.0, -TABLE_THICKNESS / TABLE_SIZE),
            0.0,
            vec2(0.0, 1.0),
        ),
        ..stone
    });
    for side in 0..4 {
        let turn = Quat::from_rotation_y(FRAC_PI_2 * side as f32);
        let outwards = vec3(0.0, -TABLE_THICKNESS / 2.0, TABLE_SIZE / 2.0);
        commands.spawn((
            Mesh3d(strip.clone()),
            MeshMaterial3d(edge.clone()),
            Transform::from_translation(TABLE_CENTER + turn * outwards).with_rotation(turn),
        ));
    }

    commands.spawn((
        Teapot,
        Mesh3d(meshes.add(bezier::tessellate(
            &bezier::teapot_patches(),
            settings.tessellation,
        ))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::srgb(0.52, 0.06, 0.03),
            perceptual_roughness: 0.35,
            clearcoat: 1.0,
            clearcoat_perceptual_roughness: 0.06,
            // One sees into the spout and through the gap under the lid.
            double_sided: true,
            cull_mode: None,
            ..default()
        })),
        teapot_pose(0.0),
    ));

    commands.spawn((
        Lamp,
        SpotLight {
            color: Color::srgb(1.0, 0.90, 0.76),
            intensity: 2_600_000.0, // lumens
            range: 12.0,
            inner_angle: 0.22,
            outer_angle: 0.46,
            shadow_maps_enabled: true,
            ..default()
        },
        lamp_pose(0.0),
        // An entity of its own: a light with a mesh would go out where the mesh leaves the view.
        children![(
            Mesh3d(meshes.add(Sphere::new(0.06))),
            MeshMaterial3d(materials.add(StandardMaterial {
                base_color: Color::BLACK,
                emissive: LinearRgba::rgb(30.0, 24.0, 16.0),
                ..default()
            })),
            NotShadowCaster, // the light is inside it
        )],
    ));
}

fn move_along(
    time: Res<SceneTime>,
    mut teapot: Single<&mut Transform, (With<Teapot>, Without<Lamp>)>,
    mut lamp: Single<&mut Transform, (With<Lamp>, Without<Teapot>)>,
) {
    **teapot = teapot_pose(time.jump);
    **lamp = lamp_pose(time.light);
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE_TOP: f32 = TABLE_CENTER.y;
    const LOWEST_AT: f32 = JUMP_SECONDS / 2.0;

    #[test]
    fn the_teapot_jumps_from_below_the_table_to_above_it() {
        let height = TEAPOT_HEIGHT * TEAPOT_SCALE;
        let foot = teapot_pose(LOWEST_AT).translation.y;
        assert!((foot + height / 2.0 - LOWEST).abs() < 1e-5);
        assert!(foot + height < TABLE_TOP);
        assert!(teapot_pose(0.0).translation.y > TABLE_TOP);
    }

    #[test]
    fn the_slab_hides_the_teapot_at_its_lowest() {
        let eye = camera_pose().translation;
        let pose = teapot_pose(LOWEST_AT);
        let front = TABLE_CENTER.z + TABLE_SIZE / 2.0;
        let mesh = bezier::tessellate(&bezier::teapot_patches(), 8);
        let points = mesh
            .attribute(Mesh::ATTRIBUTE_POSITION)
            .and_then(|values| values.as_float3())
            .expect("positions");
        for &point in points {
            let way = pose.transform_point(point.into()) - eye;
            let at_front = eye + way * ((front - eye.z) / way.z);
            assert!(at_front.y > TABLE_TOP - TABLE_THICKNESS, "{at_front}");
            assert!(at_front.x.abs() < TABLE_SIZE / 2.0, "{at_front}");
        }
    }

    #[test]
    fn everything_repeats_after_twelve_seconds() {
        for seconds in [0.0, 0.7, 3.1, 11.9] {
            for pose in [teapot_pose, lamp_pose] {
                let (now, then) = (pose(seconds), pose(seconds + 12.0));
                assert!(now.translation.abs_diff_eq(then.translation, 1e-3));
                assert!(now.rotation.abs_diff_eq(then.rotation, 1e-3));
            }
        }
    }
}
