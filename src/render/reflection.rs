//! What a reflected view sees, drawn in the order of the engine's own passes.

use core::ops::Range;

use bevy::{
    core_pipeline::{
        core_3d::{AlphaMask3d, Opaque3d, Transparent3d},
        skybox::{SkyboxBindGroup, SkyboxPipelineId},
    },
    ecs::{prelude::*, system::SystemParam},
    image::ToExtents,
    log::error,
    pbr::{
        ScreenSpaceTransmission, Transmissive3d, ViewLightEntities, ViewTransmissionTexture,
        wireframe::Wireframe3d,
    },
    render::{
        camera::ExtractedCamera,
        render_phase::{
            BinnedPhaseItem, BinnedRenderPhase, DrawError, SortedPhaseItem, SortedRenderPhase,
            TrackedRenderPass, ViewBinnedRenderPhases, ViewSortedRenderPhases,
        },
        render_resource::{BindGroup, CachedRenderPipelineId, PipelineCache, RenderPipeline},
        renderer::RenderContext,
        view::{ExtractedView, ViewTarget, ViewUniformOffset},
    },
};

/// The phases of all reflected views.
#[derive(SystemParam)]
pub struct Reflections<'w, 's> {
    opaque: Res<'w, ViewBinnedRenderPhases<Opaque3d>>,
    alpha_mask: Res<'w, ViewBinnedRenderPhases<AlphaMask3d>>,
    transmissive: Res<'w, ViewSortedRenderPhases<Transmissive3d>>,
    transparent: Res<'w, ViewSortedRenderPhases<Transparent3d>>,
    wireframe: Option<Res<'w, ViewBinnedRenderPhases<Wireframe3d>>>,
    cache: Res<'w, PipelineCache>,
    views: Query<
        'w,
        's,
        (
            &'static ExtractedView,
            &'static ViewUniformOffset,
            Option<&'static ViewLightEntities>,
            Option<&'static SkyboxPipelineId>,
            Option<&'static SkyboxBindGroup>,
            Option<&'static ScreenSpaceTransmission>,
            Option<&'static ViewTransmissionTexture>,
        ),
    >,
}

impl Reflections<'_, '_> {
    /// The phases of a reflected view; `None` if it has gone.
    pub fn get(&self, entity: Entity) -> Option<Reflection<'_>> {
        let (view, offset, cascades, pipeline, group, settings, transmission) =
            self.views.get(entity).ok()?;
        let key = &view.retained_view_entity;
        let skybox = match (pipeline, group) {
            (Some(pipeline), Some(SkyboxBindGroup(group))) => self
                .cache
                .get_render_pipeline(pipeline.0)
                .map(|pipeline| Skybox {
                    pipeline,
                    group: &group.0,
                    offsets: [offset.offset, group.1],
                }),
            _ => None,
        };
        Some(Reflection {
            entity,
            main_entity: key.main_entity.id(),
            view_offset: offset.offset,
            cascades: cascades.filter(|cascades| !cascades.lights.is_empty()),
            opaque: self.opaque.get(key),
            alpha_mask: self.alpha_mask.get(key),
            skybox_pipeline: pipeline.map(|pipeline| pipeline.0),
            skybox,
            transmissive: self.transmissive.get(key),
            transmission_steps: settings.map_or(0, |settings| settings.steps),
            transmission,
            transparent: self.transparent.get(key),
            wireframe: self.wireframe.as_ref().and_then(|phases| phases.get(key)),
        })
    }
}

/// Everything that a reflected view sees.
pub struct Reflection<'a> {
    pub entity: Entity,
    /// The same in the main world.
    pub main_entity: Entity,
    /// Of its view uniform.
    pub view_offset: u32,
    /// Directional shadows to draw before it.
    pub cascades: Option<&'a ViewLightEntities>,
    opaque: Option<&'a BinnedRenderPhase<Opaque3d>>,
    alpha_mask: Option<&'a BinnedRenderPhase<AlphaMask3d>>,
    skybox_pipeline: Option<CachedRenderPipelineId>,
    skybox: Option<Skybox<'a>>,
    transmissive: Option<&'a SortedRenderPhase<Transmissive3d>>,
    transmission_steps: usize,
    transmission: Option<&'a ViewTransmissionTexture>,
    transparent: Option<&'a SortedRenderPhase<Transparent3d>>,
    wireframe: Option<&'a BinnedRenderPhase<Wireframe3d>>,
}

struct Skybox<'a> {
    pipeline: &'a RenderPipeline,
    group: &'a BindGroup,
    offsets: [u32; 2],
}

impl<'a> Reflection<'a> {
    pub fn draw_opaque<'w>(&self, pass: &mut TrackedRenderPass<'w>, world: &'w World)
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

    /// All pipelines that it takes to draw it.
    pub fn pipelines(&self) -> impl Iterator<Item = CachedRenderPipelineId> {
        let opaque = self.opaque.into_iter();
        let alpha_mask = self.alpha_mask.into_iter();
        let transmissive = self.transmissive.into_iter();
        let transparent = self.transparent.into_iter();
        opaque
            .flat_map(|phase| batch_sets(phase).map(|set| set.pipeline))
            .chain(alpha_mask.flat_map(|phase| batch_sets(phase).map(|set| set.pipeline)))
            .chain(self.skybox_pipeline)
            .chain(transmissive.flat_map(|it| it.items.values().map(|item| item.pipeline)))
            .chain(transparent.flat_map(|it| it.items.values().map(|item| item.pipeline)))
    }

    /// How many draw calls that takes; many batches drawn by one call are one.
    pub fn draws(&self) -> usize {
        self.opaque.map_or(0, binned_draws)
            + self.alpha_mask.map_or(0, binned_draws)
            + usize::from(self.skybox.is_some())
            + self.transmissive.map_or(0, sorted_draws)
            + self.transparent.map_or(0, sorted_draws)
            + self.wireframe.map_or(0, binned_draws)
    }

    /// Whether anything is drawn after the mirrors that are seen in it.
    pub fn has_late_items(&self) -> bool {
        self.transmissive
            .is_some_and(|phase| !phase.items.is_empty())
            || self
                .transparent
                .is_some_and(|phase| !phase.items.is_empty())
    }

    /// The transmissive items, far ones first, in as many steps as the camera takes: each step
    /// refracts what the ones before have drawn. One step, without a texture, if it takes none.
    pub fn transmissive_steps(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let count = self.transmissive.map_or(0, |phase| phase.items.len());
        let steps = self.transmission_steps.clamp(1, count.max(1));
        (0..steps)
            .map(move |step| step * count / steps..(step + 1) * count / steps)
            .filter(|items| !items.is_empty())
    }

    /// Lets the next transmissive items see the picture as it is now.
    pub fn copy_for_transmission(
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

    pub fn draw_transmissive<'w>(
        &self,
        pass: &mut TrackedRenderPass<'w>,
        world: &'w World,
        items: Range<usize>,
    ) {
        if let Some(phase) = self.transmissive {
            report(phase.render_range(pass, world, self.entity, items));
        }
    }

    pub fn draw_transparent<'w>(&self, pass: &mut TrackedRenderPass<'w>, world: &'w World) {
        if let Some(phase) = self.transparent {
            report(phase.render(pass, world, self.entity));
        }
        // After all else, as the engine draws them.
        if let Some(phase) = self.wireframe {
            report(phase.render(pass, world, self.entity));
        }
    }
}

/// The keys of all bins.
fn batch_sets<I: BinnedPhaseItem>(
    phase: &BinnedRenderPhase<I>,
) -> impl Iterator<Item = &I::BatchSetKey> {
    phase
        .multidrawable_meshes
        .keys()
        .chain(phase.batchable_meshes.keys().map(|(set, _)| set))
        .chain(phase.unbatchable_meshes.keys().map(|(set, _)| set))
        .chain(phase.non_mesh_items.keys().map(|(set, _)| set))
}

/// As [`BinnedRenderPhase::render`] draws.
fn binned_draws<I: BinnedPhaseItem>(phase: &BinnedRenderPhase<I>) -> usize {
    let unbatched = phase.unbatchable_meshes.values();
    let others = phase.non_mesh_items.values();
    phase.multidrawable_meshes.len()
        + phase.batchable_meshes.len()
        + unbatched.map(|bin| bin.entities.len()).sum::<usize>()
        + others.map(|bin| bin.entities.len()).sum::<usize>()
}

/// As [`SortedRenderPhase::render`] draws: the first of a batch stands for those behind it.
fn sorted_draws<I: SortedPhaseItem>(phase: &SortedRenderPhase<I>) -> usize {
    let (mut draws, mut next) = (0, 0);
    for (index, item) in phase.items.values().enumerate() {
        let batch = item.batch_range().len();
        if index >= next && batch > 0 {
            draws += 1;
            next = index + batch;
        }
    }
    draws
}

fn report(drawn: Result<(), DrawError>) {
    if let Err(err) = drawn {
        error!("a reflected view's phase: {err:?}");
    }
}
