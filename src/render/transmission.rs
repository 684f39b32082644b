//! What transmissive objects in a reflection refract: the camera's picture as it is by then.

use bevy::{
    ecs::prelude::*,
    image::ToExtents,
    pbr::{ScreenSpaceTransmission, Transmissive3d, ViewTransmissionTexture},
    platform::collections::HashMap,
    render::{
        camera::ExtractedCamera,
        render_phase::ViewSortedRenderPhases,
        render_resource::{
            FilterMode, SamplerDescriptor, TextureDescriptor, TextureDimension, TextureUsages,
        },
        renderer::RenderDevice,
        texture::TextureCache,
        view::ExtractedView,
    },
};

use super::extract::ExtractedMirrors;

/// Gives each reflected view that has transmissive items the texture that they refract. One for
/// each camera: the pass fills it anew for every use.
///
/// The engine makes none, as a reflected view has no target whose size it could take.
pub fn prepare_mirror_transmission(
    mut commands: Commands,
    mirrors: Res<ExtractedMirrors>,
    cameras: Query<(&ExtractedCamera, &ExtractedView)>,
    views: Query<(
        &ExtractedView,
        &ScreenSpaceTransmission,
        Has<ViewTransmissionTexture>,
    )>,
    phases: Res<ViewSortedRenderPhases<Transmissive3d>>,
    mut textures: ResMut<TextureCache>,
    device: Res<RenderDevice>,
) {
    let mut of_cameras = HashMap::<Entity, _>::default();
    for mirror in &mirrors.views {
        let (Ok((view, settings, has_texture)), Ok((camera, main_view))) =
            (views.get(mirror.view), cameras.get(mirror.camera))
        else {
            continue;
        };
        let refracts = settings.steps > 0
            && phases
                .get(&view.retained_view_entity)
                .is_some_and(|phase| !phase.items.is_empty());
        let (true, Some(size)) = (refracts, camera.physical_target_size) else {
            if has_texture {
                commands
                    .entity(mirror.view)
                    .remove::<ViewTransmissionTexture>();
            }
            continue;
        };
        let (texture, sampler) = of_cameras.entry(mirror.camera).or_insert_with(|| {
            let texture = textures.get(
                &device,
                TextureDescriptor {
                    label: Some("planar_mirror_transmission"),
                    size: size.to_extents(),
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: TextureDimension::D2,
                    format: main_view.target_format,
                    usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
                    view_formats: &[],
                },
            );
            let sampler = device.create_sampler(&SamplerDescriptor {
                label: Some("planar_mirror_transmission"),
                mag_filter: FilterMode::Linear,
                min_filter: FilterMode::Linear,
                ..Default::default()
            });
            (texture, sampler)
        });
        commands
            .entity(mirror.view)
            .insert(ViewTransmissionTexture {
                texture: texture.texture.clone(),
                view: texture.default_view.clone(),
                sampler: sampler.clone(),
            });
    }
}
