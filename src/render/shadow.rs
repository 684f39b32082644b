//! Shadow maps for reflected views.
//!
//! Every camera draws its directional cascades into the same layers of one shared texture, just
//! before its own main pass. A reflected view is drawn within another camera's main pass, when
//! those layers hold that camera's cascades. So the reflected views have an array of their own,
//! of the same shape: one for all of them, since the pass draws a view's cascades just before its
//! picture. Spot lights keep their maps in the later layers of the shared texture; those layers
//! are copied, not drawn again. Point lights have a texture to themselves.

use core::sync::atomic::{AtomicBool, Ordering};

use bevy::{
    asset::{AssetServer, Handle, load_embedded_asset},
    core_pipeline::core_3d::CORE_3D_DEPTH_FORMAT,
    ecs::prelude::*,
    log::error,
    pbr::{
        ExtractedDirectionalLight, LightEntity, Shadow, ShadowView, ViewLightEntities,
        ViewShadowBindings,
    },
    render::{
        render_phase::ViewBinnedRenderPhases,
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            CachedRenderPipelineId, CompareFunction, DepthStencilState, FragmentState, LoadOp,
            Operations, PipelineCache, RenderPassDepthStencilAttachment, RenderPassDescriptor,
            RenderPipelineDescriptor, ShaderStages, StoreOp, Texture, TextureDescriptor,
            TextureDimension, TextureUsages, TextureView, TextureViewDescriptor,
            TextureViewDimension, VertexState, binding_types::texture_depth_2d,
        },
        renderer::{RenderContext, RenderDevice},
        texture::TextureCache,
        view::ExtractedView,
    },
    shader::Shader,
    utils::default,
};

use super::extract::ExtractedMirrors;
use crate::view::{DepthRange, cascade_is_sampled};

/// The pipeline that copies one layer.
#[derive(Resource)]
pub struct ShadowCopy {
    layout: BindGroupLayoutDescriptor,
    shader: Handle<Shader>,
    pipeline: Option<CachedRenderPipelineId>,
}

/// The layers of the reflected views' own array; empty in a frame without directional shadows.
#[derive(Resource, Default)]
pub struct MirrorShadowMaps {
    layers: Vec<TextureView>,
    /// Layers to copy from the shared texture, and where to.
    copies: Vec<(BindGroup, TextureView)>,
    copied: AtomicBool,
}

pub fn init_shadow_copy(mut commands: Commands, assets: Res<AssetServer>) {
    let layout = BindGroupLayoutDescriptor::new(
        "planar_mirror_shadow_copy_layout",
        &BindGroupLayoutEntries::single(ShaderStages::FRAGMENT, texture_depth_2d()),
    );
    commands.insert_resource(ShadowCopy {
        layout,
        shader: load_embedded_asset!(assets.as_ref(), "shadow_copy.wgsl"),
        pipeline: None,
    });
    // Also after a lost device, of which nothing may be left.
    commands.insert_resource(MirrorShadowMaps::default());
}

impl ShadowCopy {
    /// Asks for the pipeline when there is something to copy.
    fn queue(&mut self, cache: &PipelineCache) {
        let (layout, shader) = (&self.layout, &self.shader);
        self.pipeline.get_or_insert_with(|| {
            cache.queue_render_pipeline(RenderPipelineDescriptor {
                label: Some("planar_mirror_shadow_copy".into()),
                layout: vec![layout.clone()],
                vertex: VertexState {
                    shader: shader.clone(),
                    ..default()
                },
                fragment: Some(FragmentState {
                    shader: shader.clone(),
                    ..default()
                }),
                depth_stencil: Some(DepthStencilState {
                    format: CORE_3D_DEPTH_FORMAT,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(CompareFunction::Always),
                    stencil: default(),
                    bias: default(),
                }),
                ..default()
            })
        });
    }
}

/// Gives every reflected view that has cascades the array of the reflected views, and keeps the
/// engine from drawing them into the shared one.
pub fn prepare_mirror_shadows(
    mut commands: Commands,
    mirrors: Res<ExtractedMirrors>,
    mut bindings: Query<(&ViewLightEntities, &mut ViewShadowBindings)>,
    lights: Query<&LightEntity>,
    mut maps: ResMut<MirrorShadowMaps>,
    mut textures: ResMut<TextureCache>,
    mut copy: ResMut<ShadowCopy>,
    cache: Res<PipelineCache>,
    device: Res<RenderDevice>,
) {
    *maps = default();
    // The shared texture holds the cascades of the camera that has most of them, then the spots.
    let cascades = bindings
        .iter()
        .map(|(lights, _)| lights.lights.len())
        .max()
        .unwrap_or(0);
    let mut own: Option<(Texture, TextureView)> = None;
    for mirror in &mirrors.views {
        let Ok((lights_of_view, mut binding)) = bindings.get_mut(mirror.view) else {
            continue;
        };
        if lights_of_view.lights.is_empty() {
            continue;
        }
        for light_view in &lights_of_view.lights {
            commands.entity(*light_view).remove::<ShadowView>();
        }
        let (texture, view) = own.get_or_insert_with(|| {
            let shared = &binding.directional_light_depth_texture;
            let texture = textures
                .get(
                    &device,
                    TextureDescriptor {
                        label: Some("planar_mirror_shadow_maps"),
                        size: shared.size(),
                        mip_level_count: 1,
                        sample_count: 1,
                        dimension: TextureDimension::D2,
                        format: shared.format(),
                        usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING,
                        view_formats: &[],
                    },
                )
                .texture;
            let spots = lights
                .iter()
                .filter(|light| matches!(light, LightEntity::Spot { .. }))
                .count();
            let layer_count = shared.depth_or_array_layers() as usize;
            maps.layers = (0..cascades.min(layer_count))
                .map(|index| layer(&texture, index))
                .collect();
            maps.copies = (cascades..(cascades + spots).min(layer_count))
                .map(|index| {
                    let group = device.create_bind_group(
                        "planar_mirror_shadow_copy_group",
                        &cache.get_bind_group_layout(&copy.layout),
                        &BindGroupEntries::single(&layer(shared, index)),
                    );
                    (group, layer(&texture, index))
                })
                .collect();
            let view = texture.create_view(&TextureViewDescriptor {
                label: Some("planar_mirror_shadow_maps"),
                dimension: Some(TextureViewDimension::D2Array),
                ..default()
            });
            (texture, view)
        });
        binding.directional_light_depth_texture = texture.clone();
        binding.directional_light_depth_texture_view = view.clone();
    }
    if !maps.copies.is_empty() {
        copy.queue(&cache);
    }
}

fn layer(texture: &Texture, index: usize) -> TextureView {
    texture.create_view(&TextureViewDescriptor {
        label: Some("planar_mirror_shadow_map"),
        dimension: Some(TextureViewDimension::D2),
        base_array_layer: index as u32,
        array_layer_count: Some(1),
        ..default()
    })
}

/// Copies the spot lights' maps, once a frame.
pub fn copy_spot_shadows(
    maps: &MirrorShadowMaps,
    copy: &ShadowCopy,
    cache: &PipelineCache,
    ctx: &mut RenderContext,
) {
    if maps.copies.is_empty() {
        return;
    }
    let Some(pipeline) = copy.pipeline.and_then(|id| cache.get_render_pipeline(id)) else {
        return;
    };
    if maps.copied.swap(true, Ordering::Relaxed) {
        return;
    }
    for (source, target) in &maps.copies {
        let mut pass = ctx.begin_tracked_render_pass(depth_pass(target));
        pass.set_render_pipeline(pipeline);
        pass.set_bind_group(0, source, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// Draws the cascades of one reflected view that something at the `seen` depths reads.
pub fn draw_cascades(
    maps: &MirrorShadowMaps,
    cascades: &ViewLightEntities,
    seen: DepthRange,
    views: &Query<(&ExtractedView, &LightEntity)>,
    lights: &Query<&ExtractedDirectionalLight>,
    phases: &ViewBinnedRenderPhases<Shadow>,
    world: &World,
    ctx: &mut RenderContext,
) {
    for (&light_view, target) in cascades.lights.iter().zip(&maps.layers) {
        let Ok((view, light)) = views.get(light_view) else {
            continue;
        };
        if let LightEntity::Directional {
            light_entity,
            cascade_index,
        } = light
            && let Ok(light) = lights.get(*light_entity)
            && !cascade_is_sampled(&light.cascade_shadow_config, *cascade_index, seen)
        {
            continue;
        }
        let Some(phase) = phases.get(&view.retained_view_entity) else {
            continue;
        };
        let mut pass = ctx.begin_tracked_render_pass(depth_pass(target));
        if let Err(err) = phase.render(&mut pass, world, light_view) {
            error!("shadows of a reflected view: {err:?}");
        }
    }
}

/// A pass that clears one layer and draws depth into it.
fn depth_pass(target: &TextureView) -> RenderPassDescriptor<'_> {
    RenderPassDescriptor {
        label: Some("planar_mirror_shadow_pass"),
        color_attachments: &[],
        depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
            view: target,
            depth_ops: Some(Operations {
                load: LoadOp::Clear(0.0),
                store: StoreOp::Store,
            }),
            stencil_ops: None,
        }),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    }
}
