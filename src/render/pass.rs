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

use core::{cell::Cell, time::Duration};

use bevy::{
    camera::{MainPassResolutionOverride, Viewport},
    core_pipeline::prepass::ViewPrepassTextures,
    ecs::{prelude::*, system::SystemParam},
    render::{
        camera::ExtractedCamera,
        diagnostic::RecordDiagnostics,
        mesh::{RenderMesh, RenderMeshBufferInfo, allocator::MeshAllocator},
        render_asset::RenderAssets,
        render_phase::TrackedRenderPass,
        render_resource::{
            CachedRenderPipelineId, LoadOp, Operations, PipelineCache, RenderPassColorAttachment,
            RenderPassDepthStencilAttachment, RenderPassDescriptor, RenderPipeline, StoreOp,
        },
        renderer::{RenderContext, ViewQuery},
        texture::ColorAttachment,
        view::{ViewDepthTexture, ViewTarget, ViewUniformOffset},
    },
    utils::default,
};
use glam::UVec2;

use super::{
    drawn::{DrawnViews, Laps},
    pixels::pixel_bounds,
    prepare::{PreparedMirror, PreparedSurface, ViewMirrors},
    ready::WholeViews,
    reflection::{Reflection, Reflections},
    shadow::MirrorShadowPasses,
};
use crate::status::DrawnFigures;

/// What the pass looks up.
#[derive(SystemParam)]
pub struct PassResources<'w, 's> {
    reflections: Reflections<'w, 's>,
    shadows: MirrorShadowPasses<'w, 's>,
    drawn: Res<'w, DrawnViews>,
    whole: Res<'w, WholeViews>,
    cache: Res<'w, PipelineCache>,
    meshes: Res<'w, RenderAssets<RenderMesh>>,
    allocator: Res<'w, MeshAllocator>,
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
        Option<&ViewPrepassTextures>,
    )>,
    resources: PassResources,
    mut ctx: RenderContext,
) {
    let (camera, target, depth, view_offset, prepared, resolution, prepass) = view.into_inner();
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

    let mut laps = Laps::begin();
    resources.shadows.copy_spots(&mut ctx);
    resources.draw_cascades(first, prepared, world, &mut ctx);
    let mut lit = first.prepared.view;
    let mut pass = attachments.begin(&mut ctx, true);
    let mut begun: Vec<&Mirror> = Vec::new();
    for next in mirrors.iter().map(Some).chain([None]) {
        let outer = next.map_or(0, |next| next.prepared.bounce - 1);
        while let Some(mirror) = begun.pop_if(|mirror| mirror.prepared.bounce > outer) {
            let reflection = &mirror.reflection;
            if reflection.has_late_items() && mirror.must_be_lit(lit) {
                drop(pass);
                resources.draw_cascades(mirror, prepared, world, &mut ctx);
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
                resources
                    .draw_surfaces(&mut pass, mirror, prepared, |surface| Some(surface.restore));
            }
            mirror.took(&mut laps);
        }
        let Some(mirror) = next else {
            break;
        };
        if mirror.must_be_lit(lit) {
            drop(pass);
            resources.draw_cascades(mirror, prepared, world, &mut ctx);
            lit = mirror.reflection.entity;
            pass = attachments.begin(&mut ctx, false);
        }
        attachments.limit(&mut pass, mirror);
        pass.set_stencil_reference(u32::from(outer));
        if outer == 0 {
            pass.set_bind_group(1, &prepared.depth_group, &[]);
        }
        resources.draw_surfaces(&mut pass, mirror, prepared, |surface| Some(surface.mask));
        pass.set_stencil_reference(u32::from(mirror.prepared.bounce));
        resources.draw_surfaces(&mut pass, mirror, prepared, |surface| surface.holes);
        pass.set_render_pipeline(clear_pipeline);
        pass.set_blend_constant(prepared.background);
        pass.draw(0..3, 0..1);
        mirror.reflection.draw_opaque(&mut pass, world);
        mirror.took(&mut laps);
        begun.push(mirror);
    }
    drop(pass);

    resources.draw_depth(
        &mirrors,
        &attachments,
        (depth, prepass),
        &mut ctx,
        &mut laps,
    );
    resources.drawn.add(mirrors.iter().map(Mirror::drawn));

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

/// What a prepass has written, to write more into it.
fn prepass_attachment(texture: &Option<ColorAttachment>) -> Option<RenderPassColorAttachment<'_>> {
    let texture = texture.as_ref()?;
    Some(RenderPassColorAttachment {
        view: &texture.texture.default_view,
        depth_slice: None,
        resolve_target: None,
        ops: load_or_clear(false, default()),
    })
}

/// A reflected view that can be drawn.
struct Mirror<'a> {
    prepared: &'a PreparedMirror,
    /// Of what sees the surfaces.
    viewer_offset: u32,
    reflection: Reflection<'a>,
    /// How long it took so far to record what it takes to draw.
    time: Cell<Duration>,
}

impl Mirror<'_> {
    /// What was recorded since the last lap was for this one.
    fn took(&self, laps: &mut Laps) {
        self.time.set(self.time.get() + laps.next());
    }

    fn drawn(&self) -> (Entity, DrawnFigures) {
        let figures = DrawnFigures {
            draws: self.reflection.draws(),
            time: self.time.get(),
        };
        (self.reflection.main_entity, figures)
    }

    /// Whether its shadow cascades have to be drawn where now those of `lit` are.
    fn must_be_lit(&self, lit: Entity) -> bool {
        !self.prepared.cascades.is_empty() && lit != self.prepared.view
    }
}

/// The surface of a mirror, all of whose pipelines are there.
struct Surface<'a> {
    prepared: &'a PreparedSurface,
    mesh: &'a RenderMesh,
    mask: &'a RenderPipeline,
    holes: Option<&'a RenderPipeline>,
    restore: &'a RenderPipeline,
    depth: Option<&'a RenderPipeline>,
    prepass_depth: Option<&'a RenderPipeline>,
}

impl PassResources<'_, '_> {
    fn pipeline(&self, id: CachedRenderPipelineId) -> Option<&RenderPipeline> {
        self.cache.get_render_pipeline(id)
    }

    /// The views to draw, in order. A mirror that cannot be drawn yet is left as it is, and with it
    /// those that are seen in it.
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
            self.reflections.get(prepared.viewer)?.view_offset
        };
        let reflection = self.reflections.get(prepared.view)?;
        let may_draw = self.whole.may_draw(
            reflection.main_entity,
            of_camera.pass,
            &self.cache,
            reflection.pipelines(),
        );
        may_draw.then_some(Mirror {
            prepared,
            viewer_offset,
            reflection,
            time: Cell::default(),
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
                // All that it is to have.
                let optional = |id: Option<_>| match id {
                    Some(id) => self.pipeline(id).map(Some),
                    None => Some(None),
                };
                Some(Surface {
                    prepared: surface,
                    mesh: self.meshes.get(surface.mesh)?,
                    mask: self.pipeline(surface.mask_pipeline)?,
                    holes: optional(surface.holes_pipeline)?,
                    restore: self.pipeline(surface.restore_pipeline)?,
                    depth: optional(surface.depth_pipeline)?,
                    prepass_depth: optional(surface.prepass_depth_pipeline)?,
                })
            })
    }

    /// Draws those surfaces of a mirror that have the pipeline, as what sees it does.
    fn draw_surfaces<'a>(
        &'a self,
        pass: &mut TrackedRenderPass<'a>,
        mirror: &Mirror,
        prepared: &'a ViewMirrors,
        pipeline: impl Fn(&Surface<'a>) -> Option<&'a RenderPipeline>,
    ) {
        for surface in self.surfaces(mirror.prepared, prepared) {
            let id = &surface.prepared.mesh;
            let (Some(pipeline), Some(vertices)) =
                (pipeline(&surface), self.allocator.mesh_vertex_slice(id))
            else {
                continue;
            };
            pass.set_render_pipeline(pipeline);
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

    /// Draws the surfaces that the camera itself sees into its depth, and into what its prepass has
    /// written: effects would take what is hidden behind a mirror for what shows there.
    fn draw_depth(
        &self,
        mirrors: &[Mirror],
        attachments: &Attachments,
        (depth, prepass): (&ViewDepthTexture, Option<&ViewPrepassTextures>),
        ctx: &mut RenderContext,
        laps: &mut Laps,
    ) {
        let colors = prepass.map(|prepass| [&prepass.normal, &prepass.motion_vectors]);
        let colors = colors.map(|colors| colors.map(prepass_attachment));
        let colors = colors.filter(|colors| colors.iter().any(Option::is_some));
        let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some("planar_mirror_depth_pass"),
            color_attachments: colors.as_ref().map_or(&[], |colors| colors),
            depth_stencil_attachment: Some(depth.get_attachment(StoreOp::Store)),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        if let Some(viewport) = attachments.viewport {
            pass.set_camera_viewport(viewport);
        }
        for mirror in mirrors {
            self.draw_surfaces(&mut pass, mirror, attachments.prepared, |surface| {
                surface.depth
            });
            mirror.took(laps);
        }
        drop(pass);
        let Some(depth) = prepass.and_then(ViewPrepassTextures::depth_view) else {
            return;
        };
        let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some("planar_mirror_prepass_depth_pass"),
            color_attachments: &[],
            depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                view: depth,
                depth_ops: Some(load_or_clear(false, 0.0)),
                stencil_ops: None,
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        if let Some(viewport) = attachments.viewport {
            pass.set_camera_viewport(viewport);
        }
        pass.set_bind_group(1, &attachments.prepared.depth_group, &[]);
        for mirror in mirrors {
            self.draw_surfaces(&mut pass, mirror, attachments.prepared, |surface| {
                surface.prepass_depth
            });
            mirror.took(laps);
        }
    }

    /// Draws what a reflection reads of its cascades into the array that all reflections share.
    fn draw_cascades(
        &self,
        mirror: &Mirror,
        prepared: &ViewMirrors,
        world: &World,
        ctx: &mut RenderContext,
    ) {
        if let Some(cascades) = mirror.reflection.cascades {
            let read = &prepared.cascades[mirror.prepared.cascades.clone()];
            let view = mirror.reflection.entity;
            self.shadows.draw_cascades(view, cascades, read, world, ctx);
        }
    }
}
