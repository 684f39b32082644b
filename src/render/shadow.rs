//! Shadow maps for reflected views.
//!
//! Every camera draws its directional cascades into the same layers of one shared texture, just
//! before its own main pass. A reflected view is drawn within another camera's main pass, when
//! those layers hold that camera's cascades, and may read them. If it has cascades of its own, these
//! go into an array of the same shape: one for all reflected views, since the pass draws a view's
//! cascades just before its picture. Spot lights keep their maps in the later layers of the shared
//! texture; those layers are copied, not drawn again. Point lights have a texture to themselves.
//!
//! Of a cascade only what the reflection reads is drawn. The rest of a layer may hold what another
//! view left there.

use core::sync::atomic::{AtomicBool, Ordering};

use bevy::{
    asset::{AssetServer, Handle, load_embedded_asset},
    camera::{Camera3d, visibility::RenderLayers},
    core_pipeline::core_3d::CORE_3D_DEPTH_FORMAT,
    ecs::{prelude::*, system::SystemParam},
    log::error,
    pbr::{
        ExtractedDirectionalLight, LightEntity, MAX_CASCADES_PER_LIGHT, MAX_DIRECTIONAL_LIGHTS,
        Shadow, ShadowView, ViewLightEntities, ViewShadowBindings,
    },
    render::{
        camera::SortedCameras,
        occlusion_culling::{OcclusionCulling, OcclusionCullingSubview},
        render_phase::ViewBinnedRenderPhases,
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            CachedRenderPipelineId, CompareFunction, DepthStencilState, FragmentState, LoadOp,
            Operations, PipelineCache, RenderPassDepthStencilAttachment, RenderPassDescriptor,
            RenderPipeline, RenderPipelineDescriptor, ShaderStages, StoreOp, Texture,
            TextureDescriptor, TextureDimension, TextureUsages, TextureView, TextureViewDescriptor,
            TextureViewDimension, VertexState, binding_types::texture_depth_2d,
        },
        renderer::{RenderContext, RenderDevice},
        texture::TextureCache,
        view::ExtractedView,
    },
    shader::Shader,
    utils::default,
};
use glam::UVec2;

use super::{
    extract::{ExtractedCascade, ExtractedMirrors},
    pixels::pixel_bounds,
};

/// The pipelines that fill a layer, or a part of it, with something other than casters.
#[derive(Resource)]
pub struct ShadowPipelines {
    layout: BindGroupLayoutDescriptor,
    shader: Handle<Shader>,
    /// Copies a layer.
    copy: Option<CachedRenderPipelineId>,
    /// Clears what is in the scissor.
    clear: Option<CachedRenderPipelineId>,
}

/// The layers of the reflected views' own array; empty in a frame without directional shadows.
#[derive(Resource, Default)]
pub struct MirrorShadowMaps {
    /// Every directional light that may throw shadows, in the engine's order.
    suns: Vec<Sun>,
    layers: Vec<TextureView>,
    /// Of a layer, in texels.
    size: u32,
    /// Layers to copy from the shared texture, and where to.
    copies: Vec<(BindGroup, TextureView)>,
    copied: AtomicBool,
}

/// A directional light, as the engine counts its layers.
struct Sun {
    light: Entity,
    layers: RenderLayers,
    cascades: usize,
}

impl Sun {
    /// All of them, in the order in which `prepare_lights` numbers them.
    fn all(suns: &Query<(Entity, &ExtractedDirectionalLight, &RenderLayers)>) -> Vec<Self> {
        let mut sorted: Vec<_> = suns.iter().collect();
        sorted.sort_by_key(|(entity, sun, _)| (sun.volumetric, sun.shadow_maps_enabled, *entity));
        let sun = |(light, sun, layers): (Entity, &ExtractedDirectionalLight, &RenderLayers)| {
            let bounds = sun.cascade_shadow_config.bounds.len();
            Self {
                light,
                layers: layers.clone(),
                // So many as it is set up to have, also where a reflected view has fewer.
                cascades: if sun.shadow_maps_enabled {
                    bounds.min(MAX_CASCADES_PER_LIGHT)
                } else {
                    0
                },
            }
        };
        sorted.into_iter().map(sun).collect()
    }

    /// Those that a view with these layers has.
    fn of_view<'a>(suns: &'a [Self], view: &'a RenderLayers) -> impl Iterator<Item = &'a Self> {
        suns.iter()
            .filter(|sun| sun.layers.intersects(view))
            .take(MAX_DIRECTIONAL_LIGHTS)
    }

    /// The layer of the first cascade of a light.
    fn first_layer(suns: &[Self], view: &RenderLayers, light: Entity) -> usize {
        Self::of_view(suns, view)
            .take_while(|sun| sun.light != light)
            .map(|sun| sun.cascades)
            .sum()
    }
}

pub fn init_shadow_pipelines(mut commands: Commands, assets: Res<AssetServer>) {
    let layout = BindGroupLayoutDescriptor::new(
        "planar_mirror_shadow_copy_layout",
        &BindGroupLayoutEntries::single(ShaderStages::FRAGMENT, texture_depth_2d()),
    );
    commands.insert_resource(ShadowPipelines {
        layout,
        shader: load_embedded_asset!(assets.as_ref(), "shadow.wgsl"),
        copy: None,
        clear: None,
    });
    // Also after a lost device, of which nothing may be left.
    commands.insert_resource(MirrorShadowMaps::default());
}

impl ShadowPipelines {
    /// Asks for the pipeline that clears when there are cascades.
    fn queue_clear(&mut self, cache: &PipelineCache) {
        let shader = &self.shader;
        self.clear
            .get_or_insert_with(|| cache.queue_render_pipeline(fill("clear", shader)));
    }

    /// Asks for the pipeline that copies when there is something to copy.
    fn queue_copy(&mut self, cache: &PipelineCache) {
        let (layout, shader) = (&self.layout, &self.shader);
        self.copy.get_or_insert_with(|| {
            cache.queue_render_pipeline(RenderPipelineDescriptor {
                layout: vec![layout.clone()],
                fragment: Some(FragmentState {
                    shader: shader.clone(),
                    ..default()
                }),
                ..fill("copy", shader)
            })
        });
    }
}

/// A triangle over the whole layer, at the far side.
fn fill(what: &str, shader: &Handle<Shader>) -> RenderPipelineDescriptor {
    RenderPipelineDescriptor {
        label: Some(format!("planar_mirror_shadow_{what}").into()),
        vertex: VertexState {
            shader: shader.clone(),
            ..default()
        },
        depth_stencil: Some(DepthStencilState {
            format: CORE_3D_DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(CompareFunction::Always),
            stencil: default(),
            bias: default(),
        }),
        ..default()
    }
}

/// Gives every reflected view that has cascades of its own the array of the reflected views, and
/// keeps the engine from drawing any into the shared one, where the others find their camera's.
pub fn prepare_mirror_shadows(
    mut commands: Commands,
    mirrors: Res<ExtractedMirrors>,
    mut bindings: Query<(&ViewLightEntities, &mut ViewShadowBindings)>,
    suns: Query<(Entity, &ExtractedDirectionalLight, &RenderLayers)>,
    (sorted_cameras, cameras): (
        Res<SortedCameras>,
        Query<Option<&RenderLayers>, (With<Camera3d>, With<ExtractedView>)>,
    ),
    mut maps: ResMut<MirrorShadowMaps>,
    mut textures: ResMut<TextureCache>,
    mut pipelines: ResMut<ShadowPipelines>,
    cache: Res<PipelineCache>,
    device: Res<RenderDevice>,
) {
    *maps = default();
    maps.suns = Sun::all(&suns);
    // The shared texture holds the cascades of the camera that has most of them in this frame, then
    // the spots.
    let default_layers = RenderLayers::default();
    let cascades = sorted_cameras
        .0
        .iter()
        .filter_map(|camera| cameras.get(camera.entity).ok())
        .map(|layers| {
            let suns = Sun::of_view(&maps.suns, layers.unwrap_or(&default_layers));
            suns.map(|sun| sun.cascades).sum()
        })
        .max()
        .unwrap_or(0);
    let mut own: Option<(Texture, TextureView)> = None;
    for mirror in &mirrors.views {
        let Ok((lights_of_view, mut binding)) = bindings.get_mut(mirror.view) else {
            continue;
        };
        for light_view in &lights_of_view.lights {
            // Nor is anything left out that was hidden in another picture.
            commands
                .entity(*light_view)
                .remove::<(ShadowView, OcclusionCulling, OcclusionCullingSubview)>();
        }
        if mirror.cascades.is_empty() {
            continue;
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
            let layer_count = shared.depth_or_array_layers() as usize;
            maps.size = shared.width();
            maps.layers = (0..cascades.min(layer_count))
                .map(|index| layer(&texture, index))
                .collect();
            maps.copies = (cascades..layer_count)
                .map(|index| {
                    let group = device.create_bind_group(
                        "planar_mirror_shadow_copy_group",
                        &cache.get_bind_group_layout(&pipelines.layout),
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
    if !maps.layers.is_empty() {
        pipelines.queue_clear(&cache);
    }
    if !maps.copies.is_empty() {
        pipelines.queue_copy(&cache);
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

/// What it takes to draw the shadows of reflected views.
#[derive(SystemParam)]
pub struct MirrorShadowPasses<'w, 's> {
    maps: Res<'w, MirrorShadowMaps>,
    pipelines: Res<'w, ShadowPipelines>,
    cache: Res<'w, PipelineCache>,
    phases: Res<'w, ViewBinnedRenderPhases<Shadow>>,
    views: Query<'w, 's, (&'static ExtractedView, &'static LightEntity)>,
    layers: Query<'w, 's, &'static RenderLayers>,
}

impl MirrorShadowPasses<'_, '_> {
    /// Copies the spot lights' maps, once a frame.
    pub fn copy_spots(&self, ctx: &mut RenderContext) {
        if self.maps.copies.is_empty() {
            return;
        }
        let Some(pipeline) = self.pipeline(self.pipelines.copy) else {
            return;
        };
        if self.maps.copied.swap(true, Ordering::Relaxed) {
            return;
        }
        for (source, target) in &self.maps.copies {
            let mut pass = ctx.begin_tracked_render_pass(depth_pass(target, LoadOp::Clear(0.0)));
            pass.set_render_pipeline(pipeline);
            pass.set_bind_group(0, source, &[]);
            pass.draw(0..3, 0..1);
        }
    }

    /// Draws the cascades of one reflected view, those of which it reads something.
    pub fn draw_cascades(
        &self,
        view: Entity,
        cascades: &ViewLightEntities,
        read: &[ExtractedCascade],
        world: &World,
        ctx: &mut RenderContext,
    ) {
        let clear = self.pipeline(self.pipelines.clear);
        let default_layers = RenderLayers::default();
        let layers = self.layers.get(view).unwrap_or(&default_layers);
        for &light_view in &cascades.lights {
            let Ok((view, light)) = self.views.get(light_view) else {
                continue;
            };
            let LightEntity::Directional {
                light_entity,
                cascade_index,
            } = *light
            else {
                continue;
            };
            let first_layer = Sun::first_layer(&self.maps.suns, layers, light_entity);
            let (Some(target), Some(read), Some(phase)) = (
                self.maps.layers.get(first_layer + cascade_index),
                read.iter()
                    .find(|read| (read.light, read.index) == (light_entity, cascade_index)),
                self.phases.get(&view.retained_view_entity),
            ) else {
                continue;
            };
            let layer = UVec2::splat(self.maps.size);
            let (low, high) = match read.ndc_bounds {
                Some(bounds) => pixel_bounds(bounds, layer),
                None => (UVec2::ZERO, layer),
            };
            let size = high.saturating_sub(low);
            if size.min_element() == 0 {
                continue;
            }
            // To clear a layer is cheap for a GPU, and to keep it may mean to read it. Worth it for
            // a small part.
            let is_small = size.element_product() <= layer.element_product() / 4;
            let clear = clear.filter(|_| is_small);
            let load = if clear.is_some() {
                LoadOp::Load
            } else {
                LoadOp::Clear(0.0)
            };
            let mut pass = ctx.begin_tracked_render_pass(depth_pass(target, load));
            pass.set_scissor_rect(low.x, low.y, size.x, size.y);
            if let Some(clear) = clear {
                pass.set_render_pipeline(clear);
                pass.draw(0..3, 0..1);
            }
            if let Err(err) = phase.render(&mut pass, world, light_view) {
                error!("shadows of a reflected view: {err:?}");
            }
        }
    }

    fn pipeline(&self, id: Option<CachedRenderPipelineId>) -> Option<&RenderPipeline> {
        self.cache.get_render_pipeline(id?)
    }
}

/// A pass that draws depth into one layer.
fn depth_pass(target: &TextureView, load: LoadOp<f32>) -> RenderPassDescriptor<'_> {
    RenderPassDescriptor {
        label: Some("planar_mirror_shadow_pass"),
        color_attachments: &[],
        depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
            view: target,
            depth_ops: Some(Operations {
                load,
                store: StoreOp::Store,
            }),
            stencil_ops: None,
        }),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    }
}
