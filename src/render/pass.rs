//! The mirror pass: each reflected view where its mirror is marked in the stencil.
//!
//! The stencil counts reflections: 0 in the camera's own picture, 1 in its mirrors, 2 in mirrors
//! that are seen in these. A mirror is begun by counting up where it shows, and ended by counting
//! down again and leaving its surface's depth there. Between the two lies what is seen in it:
//!
//! ```text
//! mark, clear, opaque phases [ each mirror seen in it ] transmissive and transparent phases, unmark
//! ```
//!
//! So the picture in a mirror is made in the order in which the camera's own is, one mirror after
//! the other, and any number of them needs no more than one stencil value a reflection.

use core::ops::Range;

use bevy::{
    camera::{MainPassResolutionOverride, Viewport},
    core_pipeline::{
        core_3d::{AlphaMask3d, Opaque3d, Transparent3d},
        skybox::{SkyboxBindGroup, SkyboxPipelineId},
    },
    ecs::{prelude::*, system::SystemParam},
    image::ToExtents,
    log::error,
    pbr::{
        ExtractedDirectionalLight, LightEntity, ScreenSpaceTransmission, Shadow, Transmissive3d,
        ViewLightEntities, ViewTransmissionTexture,
    },
    render::{
        camera::ExtractedCamera,
        diagnostic::RecordDiagnostics,
        mesh::{RenderMesh, RenderMeshBufferInfo, allocator::MeshAllocator},
        render_asset::RenderAssets,
        render_phase::{
            BinnedRenderPhase, DrawError, SortedRenderPhase, TrackedRenderPass,
            ViewBinnedRenderPhases, ViewSortedRenderPhases,
        },
        render_resource::{
            BindGroup, CachedRenderPipelineId, LoadOp, Operations, PipelineCache,
            RenderPassDepthStencilAttachment, RenderPassDescriptor, RenderPipeline, StoreOp,
        },
        renderer::{RenderContext, ViewQuery},
        view::{ExtractedView, ViewDepthTexture, ViewTarget, ViewUniformOffset},
    },
};

use glam::{UVec2, Vec2};

use super::{
    prepare::{PreparedMirror, PreparedSurface, ViewMirrors},
    shadow::{MirrorShadowMaps, ShadowCopy, copy_spot_shadows, draw_cascades},
};

/// The phases of all views, and what else the pass looks up.
#[derive(SystemParam)]
pub struct PassResources<'w, 's> {
    opaque: Res<'w, ViewBinnedRenderPhases<Opaque3d>>,
    alpha_mask: Res<'w, ViewBinnedRenderPhases<AlphaMask3d>>,
    transmissive: Res<'w, ViewSortedRenderPhases<Transmissive3d>>,
    transparent: Res<'w, ViewSortedRenderPhases<Transparent3d>>,
    shadows: Res<'w, ViewBinnedRenderPhases<Shadow>>,
    shadow_maps: Res<'w, MirrorShadowMaps>,
    shadow_copy: Res<'w, ShadowCopy>,
    cache: Res<'w, PipelineCache>,
    meshes: Res<'w, RenderAssets<RenderMesh>>,
    allocator: Res<'w, MeshAllocator>,
    light_views: Query<'w, 's, (&'static ExtractedView, &'static LightEntity)>,
    lights: Query<'w, 's, &'static ExtractedDirectionalLight>,
    reflected: Query<
        'w,
        's,
        (
            &'static ExtractedView,
            &'static ViewUniformOffset,
            Option<&'static ViewLightEntities>,
            (
                Option<&'static SkyboxPipelineId>,
                Option<&'static SkyboxBindGroup>,
            ),
            (
                Option<&'static ScreenSpaceTransmission>,
                Option<&'static ViewTransmissionTexture>,
            ),
        ),
    >,
}

/// Draws the reflections of one camera's mirrors into its picture.
///
/// `Core3d`, after the opaque pass and before transmission and transparency. One render pass for
/// all mirrors, interrupted only where a view's shadow cascades have to be drawn first, or where
/// glass refracts. Then the surfaces of the mirrors that the camera itself sees go into its depth,
/// so that transparent objects behind a mirror are not drawn over its reflection.
pub fn mirror_pass(
    world: &World,
    view: ViewQuery<(
        &ExtractedCamera,
        &ViewTarget,
        &ViewDepthTexture,
        &ViewUniformOffset,
        &ViewMirrors,
        Option<&MainPassResolutionOverride>,
    )>,
    resources: PassResources,
    mut ctx: RenderContext,
) {
    let (camera, target, depth, view_offset, prepared, resolution) = view.into_inner();
    let Some(clear_pipeline) = resources.pipeline(prepared.clear_pipeline) else {
        return;
    };
    let mirrors = resources.ready_mirrors(prepared, view_offset);
    let Some(first) = mirrors.first() else {
        return;
    };
    let viewport = Viewport::from_viewport_and_override(camera.viewport.as_ref(), resolution);
    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let time_span = diagnostics.time_span(ctx.command_encoder(), "planar_mirror_pass");

    let attachments = Attachments {
        target,
        prepared,
        viewport: viewport.as_ref(),
    };

    if mirrors.iter().any(|mirror| mirror.cascades.is_some()) {
        copy_spot_shadows(
            &resources.shadow_maps,
            &resources.shadow_copy,
            &resources.cache,
            &mut ctx,
        );
    }
    resources.draw_cascades(first, world, &mut ctx);
    let mut lit = first.prepared.view;
    let mut pass = attachments.begin(&mut ctx, true);
    let mut begun: Vec<&Mirror> = Vec::new();
    for next in mirrors.iter().map(Some).chain([None]) {
        let outer = next.map_or(0, |next| next.prepared.bounce - 1);
        while let Some(mirror) = begun.pop_if(|mirror| mirror.prepared.bounce > outer) {
            let reflection = &mirror.reflection;
            if reflection.has_late_items() && mirror.cascades.is_some() && lit != reflection.entity
            {
                drop(pass);
                resources.draw_cascades(mirror, world, &mut ctx);
                lit = reflection.entity;
                pass = attachments.begin(&mut ctx, false);
            }
            attachments.limit(&mut pass, mirror);
            for items in reflection.transmissive_steps() {
                // Glass refracts what is in the picture by now: the reflection so far.
                drop(pass);
                reflection.copy_for_transmission(target, camera, &mut ctx);
                pass = attachments.begin(&mut ctx, false);
                attachments.limit(&mut pass, mirror);
                reflection.draw_transmissive(&mut pass, world, items);
            }
            reflection.draw_transparent(&mut pass, world);
            // After the last one nobody asks.
            if next.is_some() || !begun.is_empty() {
                resources.draw_surfaces(&mut pass, mirror, prepared, |surface| surface.restore);
            }
        }
        let Some(mirror) = next else {
            break;
        };
        if mirror.cascades.is_some() && lit != mirror.reflection.entity {
            drop(pass);
            resources.draw_cascades(mirror, world, &mut ctx);
            lit = mirror.reflection.entity;
            pass = attachments.begin(&mut ctx, false);
        }
        attachments.limit(&mut pass, mirror);
        pass.set_stencil_reference(u32::from(outer));
        if outer == 0 {
            pass.set_bind_group(1, &prepared.depth_group, &[]);
        }
        resources.draw_surfaces(&mut pass, mirror, prepared, |surface| surface.mask);
        pass.set_stencil_reference(u32::from(mirror.prepared.bounce));
        pass.set_render_pipeline(clear_pipeline);
        pass.set_blend_constant(prepared.background);
        pass.draw(0..3, 0..1);
        mirror.reflection.draw_opaque(&mut pass, world);
        begun.push(mirror);
    }
    drop(pass);

    let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
        label: Some("planar_mirror_depth_pass"),
        color_attachments: &[],
        depth_stencil_attachment: Some(depth.get_attachment(StoreOp::Store)),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    });
    if let Some(viewport) = &viewport {
        pass.set_camera_viewport(viewport);
    }
    for mirror in mirrors.iter().filter(|mirror| mirror.prepared.bounce == 1) {
        resources.draw_surfaces(&mut pass, mirror, prepared, |surface| surface.depth);
    }
    drop(pass);

    time_span.end(ctx.command_encoder());
}

/// What the mirror pass draws into.
struct Attachments<'a> {
    target: &'a ViewTarget,
    prepared: &'a ViewMirrors,
    viewport: Option<&'a Viewport>,
}

impl Attachments<'_> {
    /// Begins the pass, or goes on with it. It is left only to draw what a reflection reads.
    fn begin<'c>(&self, ctx: &'c mut RenderContext, first: bool) -> TrackedRenderPass<'c> {
        let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some("planar_mirror_pass"),
            color_attachments: &[Some(self.target.get_color_attachment())],
            depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                view: &self.prepared.depth_stencil.default_view,
                depth_ops: Some(load_or_clear(first, 0.0)),
                stencil_ops: Some(load_or_clear(first, 0)),
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        if let Some(viewport) = self.viewport {
            pass.set_camera_viewport(viewport);
        }
        pass
    }

    /// Lets the pass draw only where the mirror can be seen.
    fn limit(&self, pass: &mut TrackedRenderPass, mirror: &Mirror) {
        pass.set_stencil_reference(u32::from(mirror.prepared.bounce));
        let (min, size) = match self.viewport {
            Some(viewport) => (viewport.physical_position, viewport.physical_size),
            None => {
                let size = self.prepared.depth_stencil.texture.size();
                (UVec2::ZERO, UVec2::new(size.width, size.height))
            }
        };
        let (low, high) = pixel_bounds(mirror.prepared.ndc_bounds, size);
        pass.set_scissor_rect(min.x + low.x, min.y + low.y, high.x - low.x, high.y - low.y);
    }
}

/// The pixels within device coordinates, and two around them for jitter and rounding.
fn pixel_bounds((low, high): (Vec2, Vec2), size: UVec2) -> (UVec2, UVec2) {
    const AROUND: Vec2 = Vec2::splat(2.0);
    let pixel = |ndc: Vec2| (ndc * Vec2::new(0.5, -0.5) + 0.5) * size.as_vec2();
    let min = (pixel(Vec2::new(low.x, high.y)) - AROUND).floor();
    let max = (pixel(Vec2::new(high.x, low.y)) + AROUND).ceil();
    // Converting to unsigned numbers cuts off at 0.
    (min.as_uvec2().min(size), max.as_uvec2().min(size))
}

fn load_or_clear<V>(clear: bool, value: V) -> Operations<V> {
    Operations {
        load: if clear {
            LoadOp::Clear(value)
        } else {
            LoadOp::Load
        },
        store: StoreOp::Store,
    }
}

/// A reflected view that can be drawn.
struct Mirror<'a> {
    prepared: &'a PreparedMirror,
    /// Of what sees the surfaces.
    viewer_offset: u32,
    reflection: Reflection<'a>,
    /// Directional shadows to draw before the reflection.
    cascades: Option<&'a ViewLightEntities>,
}

/// The surface of a mirror, all of whose pipelines are there.
struct Surface<'a> {
    prepared: &'a PreparedSurface,
    mesh: &'a RenderMesh,
    mask: &'a RenderPipeline,
    restore: &'a RenderPipeline,
    depth: &'a RenderPipeline,
}

impl PassResources<'_, '_> {
    fn pipeline(&self, id: CachedRenderPipelineId) -> Option<&RenderPipeline> {
        self.cache.get_render_pipeline(id)
    }

    /// The views to draw, in order. A mirror whose surface cannot be drawn yet is left as it is, and
    /// with it those that are seen in it.
    fn ready_mirrors<'a>(
        &'a self,
        prepared: &'a ViewMirrors,
        camera: &ViewUniformOffset,
    ) -> Vec<Mirror<'a>> {
        let mut mirrors = Vec::new();
        let mut left_out = u8::MAX;
        for mirror in &prepared.mirrors {
            if mirror.bounce > left_out {
                continue;
            }
            left_out = u8::MAX;
            match self.ready(mirror, prepared, camera) {
                Some(mirror) => mirrors.push(mirror),
                None => left_out = mirror.bounce,
            }
        }
        mirrors
    }

    fn ready<'a>(
        &'a self,
        prepared: &'a PreparedMirror,
        of_camera: &'a ViewMirrors,
        camera: &ViewUniformOffset,
    ) -> Option<Mirror<'a>> {
        self.surfaces(prepared, of_camera).next()?;
        let viewer_offset = if prepared.bounce == 1 {
            camera.offset
        } else {
            self.reflected.get(prepared.viewer).ok()?.1.offset
        };
        let (_, _, cascades, ..) = self.reflected.get(prepared.view).ok()?;
        Some(Mirror {
            prepared,
            viewer_offset,
            reflection: self.reflection(prepared.view)?,
            cascades: cascades.filter(|cascades| !cascades.lights.is_empty()),
        })
    }

    fn surfaces<'a>(
        &'a self,
        mirror: &PreparedMirror,
        prepared: &'a ViewMirrors,
    ) -> impl Iterator<Item = Surface<'a>> {
        prepared.surfaces[mirror.surfaces.clone()]
            .iter()
            .filter_map(|surface| {
                Some(Surface {
                    prepared: surface,
                    mesh: self.meshes.get(surface.mesh)?,
                    mask: self.pipeline(surface.mask_pipeline)?,
                    restore: self.pipeline(surface.restore_pipeline)?,
                    depth: self.pipeline(surface.depth_pipeline)?,
                })
            })
    }

    /// Draws all surfaces of a mirror, as what sees it does.
    fn draw_surfaces<'a>(
        &'a self,
        pass: &mut TrackedRenderPass<'a>,
        mirror: &Mirror,
        prepared: &'a ViewMirrors,
        pipeline: impl Fn(&Surface<'a>) -> &'a RenderPipeline,
    ) {
        for surface in self.surfaces(mirror.prepared, prepared) {
            let id = &surface.prepared.mesh;
            let Some(vertices) = self.allocator.mesh_vertex_slice(id) else {
                continue;
            };
            pass.set_render_pipeline(pipeline(&surface));
            pass.set_bind_group(
                0,
                &prepared.surface_group,
                &[mirror.viewer_offset, surface.prepared.uniform_offset],
            );
            pass.set_vertex_buffer(0, vertices.buffer.slice(..));
            match surface.mesh.buffer_info {
                RenderMeshBufferInfo::Indexed {
                    count,
                    index_format,
                } => {
                    let Some(indices) = self.allocator.mesh_index_slice(id) else {
                        continue;
                    };
                    pass.set_index_buffer(indices.buffer.slice(..), index_format);
                    pass.draw_indexed(
                        indices.range.start..indices.range.start + count,
                        vertices.range.start as i32,
                        0..1,
                    );
                }
                RenderMeshBufferInfo::NonIndexed => pass.draw(vertices.range, 0..1),
            }
        }
    }

    /// Draws what a reflection reads of its cascades into the array that all reflections share.
    fn draw_cascades(&self, mirror: &Mirror, world: &World, ctx: &mut RenderContext) {
        let Some(cascades) = mirror.cascades else {
            return;
        };
        draw_cascades(
            &self.shadow_maps,
            cascades,
            mirror.prepared.depths,
            &self.light_views,
            &self.lights,
            &self.shadows,
            world,
            ctx,
        );
    }

    /// The phases of a reflected view; `None` if it has gone.
    fn reflection(&self, entity: Entity) -> Option<Reflection<'_>> {
        let (view, offset, _, skybox, transmission) = self.reflected.get(entity).ok()?;
        let key = &view.retained_view_entity;
        let (settings, transmission) = transmission;
        let (pipeline, group) = skybox;
        let skybox = match (pipeline, group) {
            (Some(pipeline), Some(SkyboxBindGroup(group))) => {
                self.pipeline(pipeline.0).map(|pipeline| Skybox {
                    pipeline,
                    group: &group.0,
                    offsets: [offset.offset, group.1],
                })
            }
            _ => None,
        };
        Some(Reflection {
            entity,
            opaque: self.opaque.get(key),
            alpha_mask: self.alpha_mask.get(key),
            skybox,
            transmissive: self.transmissive.get(key),
            transmission_steps: settings.map_or(0, |settings| settings.steps),
            transmission,
            transparent: self.transparent.get(key),
        })
    }
}

/// Everything that a reflected view sees, in the order of the engine's own passes.
struct Reflection<'a> {
    entity: Entity,
    opaque: Option<&'a BinnedRenderPhase<Opaque3d>>,
    alpha_mask: Option<&'a BinnedRenderPhase<AlphaMask3d>>,
    skybox: Option<Skybox<'a>>,
    transmissive: Option<&'a SortedRenderPhase<Transmissive3d>>,
    transmission_steps: usize,
    transmission: Option<&'a ViewTransmissionTexture>,
    transparent: Option<&'a SortedRenderPhase<Transparent3d>>,
}

struct Skybox<'a> {
    pipeline: &'a RenderPipeline,
    group: &'a BindGroup,
    offsets: [u32; 2],
}

impl<'a> Reflection<'a> {
    fn draw_opaque<'w>(&self, pass: &mut TrackedRenderPass<'w>, world: &'w World)
    where
        'a: 'w,
    {
        if let Some(phase) = self.opaque {
            report(phase.render(pass, world, self.entity));
        }
        if let Some(phase) = self.alpha_mask {
            report(phase.render(pass, world, self.entity));
        }
        if let Some(skybox) = &self.skybox {
            pass.set_render_pipeline(skybox.pipeline);
            pass.set_bind_group(0, skybox.group, &skybox.offsets);
            pass.draw(0..3, 0..1);
        }
    }

    /// Whether anything is drawn after the mirrors that are seen in it.
    fn has_late_items(&self) -> bool {
        self.transmissive
            .is_some_and(|phase| !phase.items.is_empty())
            || self
                .transparent
                .is_some_and(|phase| !phase.items.is_empty())
    }

    /// The transmissive items, far ones first, in as many steps as the camera takes: each step
    /// refracts what the ones before have drawn. One step, without a texture, if it takes none.
    fn transmissive_steps(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let count = self.transmissive.map_or(0, |phase| phase.items.len());
        let steps = self.transmission_steps.clamp(1, count.max(1));
        (0..steps)
            .map(move |step| step * count / steps..(step + 1) * count / steps)
            .filter(|items| !items.is_empty())
    }

    /// Lets the next transmissive items see the picture as it is now.
    fn copy_for_transmission(
        &self,
        target: &ViewTarget,
        camera: &ExtractedCamera,
        ctx: &mut RenderContext,
    ) {
        if let (Some(transmission), Some(size)) = (self.transmission, camera.physical_target_size) {
            ctx.command_encoder().copy_texture_to_texture(
                target.main_texture().as_image_copy(),
                transmission.texture.as_image_copy(),
                size.to_extents(),
            );
        }
    }

    fn draw_transmissive<'w>(
        &self,
        pass: &mut TrackedRenderPass<'w>,
        world: &'w World,
        items: Range<usize>,
    ) {
        if let Some(phase) = self.transmissive {
            report(phase.render_range(pass, world, self.entity, items));
        }
    }

    fn draw_transparent<'w>(&self, pass: &mut TrackedRenderPass<'w>, world: &'w World) {
        if let Some(phase) = self.transparent {
            report(phase.render(pass, world, self.entity));
        }
    }
}

fn report(drawn: Result<(), DrawError>) {
    if let Err(err) = drawn {
        error!("a reflected view's phase: {err:?}");
    }
}
