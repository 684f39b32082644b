//! The engine's screen-space reflections: rays marched through the depth of the main picture. What
//! the main camera does not see, its reflection lacks.

use bevy::{
    asset::RenderAssetUsages,
    pbr::{DefaultOpaqueRendererMethod, ScreenSpaceReflections},
    prelude::*,
    render::render_resource::{Extent3d, Face, TextureDimension, TextureFormat},
};

use crate::support::{scene::Scene, set::build_plain, stage::Stage};

pub fn plugin(app: &mut App) {
    app.insert_resource(DefaultOpaqueRendererMethod::deferred());
}

/// Returns the camera.
pub fn set_up(stage: &mut Stage, scene: &Scene, target: &Handle<Image>) -> Entity {
    let flips = scene.mirrors[0].transform.scale.signum().element_product() < 0.0;
    // The mirror reflects nothing but the picture: no light from everywhere.
    let shut = stage
        .world()
        .resource_mut::<Assets<Image>>()
        .add(Image::new_fill(
            Extent3d::default(),
            TextureDimension::D2,
            &[0, 0, 0, 255],
            TextureFormat::Rgba8Unorm,
            RenderAssetUsages::default(),
        ));
    let mut scene = scene.clone().with_camera(ScreenSpaceReflections {
        // By default the smoothest surfaces, which a mirror is of, have none.
        min_perceptual_roughness: 0.0..0.0,
        ..default()
    });
    scene.mirrors[0].look = Some(
        StandardMaterial {
            base_color: Color::WHITE,
            metallic: 1.0,
            perceptual_roughness: 0.0,
            occlusion_texture: Some(shut),
            cull_mode: Some(if flips { Face::Front } else { Face::Back }),
            ..default()
        }
        .into(),
    );
    build_plain(stage, &scene, target.clone())
}
