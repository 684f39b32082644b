//! The mirror pass: masks into the stencil, then each reflected view where its id stands.

use bevy::{
    camera::{MainPassResolutionOverride, Viewport},
    core_pipeline::{
        core_3d::{AlphaMask3d, Opaque3d, Transparent3d},
        skybox::{SkyboxBindGroup, SkyboxPipelineId},
    },
    ecs::{prelude::*, system::SystemParam},
    log::error,
    pbr::{Shadow, Transmissive3d, ViewLightEntities},
    render::{
        camera::ExtractedCamera,
        diagnostic::RecordDiagnostics,
        mesh::{RenderMesh, RenderMeshBufferInfo, allocator::MeshAllocator},
        render_asset::RenderAssets,
        render_phase::{TrackedRenderPass, ViewBinnedRenderPhases, ViewSortedRenderPhases},
        render_resource::{
            CachedRenderPipelineId, LoadOp, Operations, PipelineCache,
            RenderPassDepthStencilAttachment, RenderPassDescriptor, RenderPipeline, StoreOp,
        },
        renderer::{RenderContext, ViewQuery},
        view::{ExtractedView, ViewDepthTexture, ViewTarget, ViewUniformOffset},
    },
};

use super::{
    prepare::{PreparedMirror, ViewMirrors},
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
    views: Query<'w, 's, &'static ExtractedView>,
    reflected: Query<
        'w,
        's,
        (
            &'static ExtractedView,
            &'static ViewUniformOffset,
            Option<&'static ViewLightEntities>,
            Option<&'static SkyboxPipelineId>,
            Option<&'static SkyboxBindGroup>,
        ),
    >,
}

/// Draws the reflections of one camera's mirrors into its picture.
///
/// `Core3d`, after the opaque pass and before transmission and transparency. One render pass for
/// all mirrors, interrupted only where a view's shadow cascades have to be drawn first; then the
/// mirrors' surfaces go into the camera's depth, so that transparent objects behind a mirror are
/// not drawn over its reflection.
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
    // A mirror whose surface cannot be drawn yet is left as it is.
    let mirrors: Vec<Mirror> = prepared
        .mirrors
        .iter()
        .filter_map(|mirror| resources.ready(mirror))
        .collect();
    if mirrors.is_empty() {
        return;
    }
    let viewport = Viewport::from_viewport_and_override(camera.viewport.as_ref(), resolution);
    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let time_span = diagnostics.time_span(ctx.command_encoder(), "planar_mirror_pass");

    if mirrors.iter().any(|mirror| mirror.cascades.is_some()) {
        copy_spot_shadows(
            &resources.shadow_maps,
            &resources.shadow_copy,
            &resources.cache,
            &mut ctx,
        );
    }

    let mut first = true;
    for group in mirrors.chunk_by(|_, next| next.cascades.is_none()) {
        if let Some(cascades) = group[0].cascades {
            draw_cascades(
                &resources.shadow_maps,
                cascades,
                &resources.views,
                &resources.shadows,
                world,
                &mut ctx,
            );
        }
        let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some("planar_mirror_pass"),
            color_attachments: &[Some(target.get_color_attachment())],
            depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                view: &prepared.depth_stencil.default_view,
                depth_ops: Some(load_or_clear(first, 0.0)),
                stencil_ops: Some(load_or_clear(first, 0)),
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        if let Some(viewport) = &viewport {
            pass.set_camera_viewport(viewport);
        }
        if first {
            for mirror in &mirrors {
                pass.set_stencil_reference(mirror.prepared.id);
                pass.set_bind_group(1, &prepared.depth_group, &[]);
                resources.draw_surface(&mut pass, mirror, mirror.mask, prepared, view_offset);
            }
            pass.set_render_pipeline(clear_pipeline);
            pass.set_bind_group(
                0,
                &prepared.surface_group,
                &[view_offset.offset, mirrors[0].prepared.uniform_offset],
            );
            pass.set_stencil_reference(0);
            pass.set_blend_constant(prepared.background);
            pass.draw(0..3, 0..1);
            first = false;
        }
        for mirror in group {
            pass.set_stencil_reference(mirror.prepared.id);
            resources.draw_reflection(&mut pass, world, mirror.prepared.view);
        }
    }

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
    for mirror in &mirrors {
        resources.draw_surface(&mut pass, mirror, mirror.depth, prepared, view_offset);
    }
    drop(pass);

    time_span.end(ctx.command_encoder());
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

/// A mirror all of whose own pipelines are there.
struct Mirror<'a> {
    prepared: &'a PreparedMirror,
    mask: &'a RenderPipeline,
    depth: &'a RenderPipeline,
    mesh: &'a RenderMesh,
    /// Directional shadows to draw before the reflection.
    cascades: Option<&'a ViewLightEntities>,
}

impl PassResources<'_, '_> {
    fn pipeline(&self, id: CachedRenderPipelineId) -> Option<&RenderPipeline> {
        self.cache.get_render_pipeline(id)
    }

    fn ready<'a>(&'a self, prepared: &'a PreparedMirror) -> Option<Mirror<'a>> {
        let (_, _, cascades, ..) = self.reflected.get(prepared.view).ok()?;
        Some(Mirror {
            prepared,
            mask: self.pipeline(prepared.mask_pipeline)?,
            depth: self.pipeline(prepared.depth_pipeline)?,
            mesh: self.meshes.get(prepared.mesh)?,
            cascades: cascades.filter(|cascades| !cascades.lights.is_empty()),
        })
    }

    fn draw_surface<'w>(
        &'w self,
        pass: &mut TrackedRenderPass<'w>,
        mirror: &Mirror<'w>,
        pipeline: &'w RenderPipeline,
        prepared: &'w ViewMirrors,
        view_offset: &ViewUniformOffset,
    ) {
        let id = &mirror.prepared.mesh;
        let Some(vertices) = self.allocator.mesh_vertex_slice(id) else {
            return;
        };
        pass.set_render_pipeline(pipeline);
        pass.set_bind_group(
            0,
            &prepared.surface_group,
            &[view_offset.offset, mirror.prepared.uniform_offset],
        );
        pass.set_vertex_buffer(0, vertices.buffer.slice(..));
        match mirror.mesh.buffer_info {
            RenderMeshBufferInfo::Indexed {
                count,
                index_format,
            } => {
                let Some(indices) = self.allocator.mesh_index_slice(id) else {
                    return;
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

    /// Everything that the reflected view sees, in the order of the engine's own passes.
    fn draw_reflection<'w>(
        &'w self,
        pass: &mut TrackedRenderPass<'w>,
        world: &'w World,
        entity: Entity,
    ) {
        let Ok((view, offset, _, skybox_pipeline, skybox_group)) = self.reflected.get(entity)
        else {
            return;
        };
        let key = &view.retained_view_entity;
        let mut drawn = Ok(());
        if let Some(phase) = self.opaque.get(key) {
            drawn = drawn.and(phase.render(pass, world, entity));
        }
        if let Some(phase) = self.alpha_mask.get(key) {
            drawn = drawn.and(phase.render(pass, world, entity));
        }
        if let (Some(pipeline), Some(SkyboxBindGroup(group))) = (skybox_pipeline, skybox_group)
            && let Some(pipeline) = self.pipeline(pipeline.0)
        {
            pass.set_render_pipeline(pipeline);
            pass.set_bind_group(0, &group.0, &[offset.offset, group.1]);
            pass.draw(0..3, 0..1);
        }
        if let Some(phase) = self.transmissive.get(key) {
            drawn = drawn.and(phase.render(pass, world, entity));
        }
        if let Some(phase) = self.transparent.get(key) {
            drawn = drawn.and(phase.render(pass, world, entity));
        }
        if let Err(err) = drawn {
            error!("a reflected view's phases: {err:?}");
        }
    }
}
