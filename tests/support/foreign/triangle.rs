//! A triangle that a plugin draws by itself.

use bevy::{
    asset::AssetId,
    core_pipeline::core_3d::{
        Opaque3d, Opaque3dBatchSetKey, Opaque3dBinKey, Transparent3d, TransparentSortingInfo3d,
    },
    ecs::{
        query::ROQueryItem,
        schedule::ScheduleConfigs,
        system::{ScheduleSystem, SystemParam, SystemParamItem},
    },
    pbr::{
        MeshPipeline, MeshPipelineKey, MeshPipelineViewLayoutKey, SetMeshViewBindGroup,
        ViewKeyCache,
    },
    platform::collections::HashSet,
    prelude::*,
    render::{
        GpuResourceAppExt, Render, RenderApp, RenderSystems,
        render_phase::{
            AddRenderCommand, BinnedRenderPhaseType, DrawFunctions, InputUniformIndex, PhaseItem,
            PhaseItemExtraIndex, RenderCommand, RenderCommandResult, SetItemPipeline,
            TrackedRenderPass, ViewBinnedRenderPhases, ViewSortedRenderPhases,
        },
        render_resource::{
            BlendState, CachedRenderPipelineId, PipelineCache, RenderPipelineDescriptor,
            SpecializedRenderPipeline, SpecializedRenderPipelines, TextureFormat,
        },
        sync_world::MainEntity,
        view::{ExtractedView, RetainedViewEntity, ViewTarget},
    },
    shader::Shader,
};

use super::{descriptor, init_pipeline};

/// A triangle that a plugin draws by itself: no mesh, no material, no bounds.
#[derive(Resource, Clone, Debug)]
pub struct Triangle {
    pub label: &'static str,
    /// In the world; seen from the side where they go around counter-clockwise.
    pub corners: [Vec3; 3],
    pub phase: Phase,
    /// When its plugin queues it.
    pub when: When,
    pub misfit: Misfit,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phase {
    /// Queued anew for every frame.
    Transparent,
    /// Queued anew for every frame.
    Opaque,
    /// Queued once for each view, then left to the phase to keep.
    OpaqueRetained,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum When {
    /// Where the engine asks for it.
    Queue,
    /// Later, after the phases are sorted.
    Prepare,
}

/// What is wrong with the pipeline for views that are not drawn indirectly, as the user's is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Misfit {
    None,
    NoDepth,
    OtherSamples,
    OtherFormat,
}

/// Where the triangle's key in the phases comes from.
#[derive(Resource, Clone, Copy)]
struct Owner(MainEntity);

#[derive(Resource)]
struct TrianglePipeline {
    mesh_pipeline: MeshPipeline,
    shader: Handle<Shader>,
    triangle: Triangle,
}

impl Triangle {
    /// Adds the plugin that draws it in every view.
    pub fn add(self, app: &mut App) {
        let owner = app.world_mut().spawn(Name::new(self.label)).id();
        let queue: ScheduleConfigs<ScheduleSystem> = match self.phase {
            Phase::Transparent => queue_transparent.into_configs(),
            Phase::Opaque | Phase::OpaqueRetained => queue_opaque.into_configs(),
        };
        let queue = match self.when {
            When::Queue => queue.in_set(RenderSystems::Queue),
            When::Prepare => queue
                .after(RenderSystems::PrepareResourcesFlush)
                .in_set(RenderSystems::Prepare),
        };
        app.sub_app_mut(RenderApp)
            .insert_resource(Owner(owner.into()))
            .init_gpu_resource::<SpecializedRenderPipelines<TrianglePipeline>>()
            .add_render_command::<Transparent3d, DrawTriangleItem>()
            .add_render_command::<Opaque3d, DrawTriangleItem>()
            .add_systems(Render, queue);
        let shader = Shader::from_wgsl(self.wgsl(), self.label);
        init_pipeline(app, shader, move |mesh_pipeline, shader| TrianglePipeline {
            mesh_pipeline,
            shader,
            triangle: self.clone(),
        });
    }

    fn wgsl(&self) -> String {
        let corners = self
            .corners
            .map(|c| format!("vec3({:?}, {:?}, {:?})", c.x, c.y, c.z))
            .join(", ");
        format!(
            "#import bevy_render::view::View
            @group(0) @binding(0) var<uniform> view: View;
            struct Varying {{
                @builtin(position) position: vec4<f32>,
                @location(0) color: vec3<f32>,
            }}
            @vertex
            fn vertex(@builtin(vertex_index) index: u32) -> Varying {{
                var corners = array<vec3<f32>, 3>({corners});
                var colors = array<vec3<f32>, 3>(
                    vec3(0.9, 0.1, 0.1), vec3(0.1, 0.9, 0.1), vec3(0.1, 0.1, 0.9),
                );
                var out: Varying;
                out.position = view.clip_from_world * vec4(corners[index], 1.0);
                out.color = colors[index];
                return out;
            }}
            @fragment
            fn fragment(in: Varying) -> @location(0) vec4<f32> {{
                return vec4(in.color, 1.0);
            }}"
        )
    }
}

impl SpecializedRenderPipeline for TrianglePipeline {
    type Key = (MeshPipelineKey, Misfit);

    fn specialize(&self, (view_key, misfit): Self::Key) -> RenderPipelineDescriptor {
        let layout = self
            .mesh_pipeline
            .get_view_layout(MeshPipelineViewLayoutKey::from(view_key));
        let layout = vec![layout.main_layout.clone()];
        let mut descriptor = descriptor(self.triangle.label, layout, &self.shader, view_key);
        let target = descriptor.fragment.as_mut().map(|it| &mut it.targets[0]);
        if let Some(Some(target)) = target {
            match (misfit, self.triangle.phase) {
                (Misfit::OtherFormat, _) => target.format = TextureFormat::R32Float,
                (Misfit::None, Phase::Transparent) => {
                    target.blend = Some(BlendState::ALPHA_BLENDING);
                }
                _ => {}
            }
        }
        let samples = &mut descriptor.multisample.count;
        match misfit {
            Misfit::OtherSamples => *samples = if *samples == 1 { 4 } else { 1 },
            Misfit::NoDepth => descriptor.depth_stencil = None,
            Misfit::None | Misfit::OtherFormat => {}
        }
        descriptor
    }
}

type DrawTriangleItem = (SetItemPipeline, SetMeshViewBindGroup<0>, DrawTriangle);

struct DrawTriangle;

impl<P: PhaseItem> RenderCommand<P> for DrawTriangle {
    type Param = ();
    type ViewQuery = ();
    type ItemQuery = ();

    fn render<'w>(
        _: &P,
        (): ROQueryItem<'w, '_, Self::ViewQuery>,
        _: Option<()>,
        (): SystemParamItem<'w, '_, Self::Param>,
        pass: &mut TrackedRenderPass<'w>,
    ) -> RenderCommandResult {
        pass.draw(0..3, 0..1);
        RenderCommandResult::Success
    }
}

/// What the triangle is queued from, in either phase.
#[derive(SystemParam)]
struct Views<'w, 's> {
    pipeline: Res<'w, TrianglePipeline>,
    pipelines: ResMut<'w, SpecializedRenderPipelines<TrianglePipeline>>,
    cache: Res<'w, PipelineCache>,
    keys: Res<'w, ViewKeyCache>,
    views: Query<'w, 's, (&'static ExtractedView, Has<ViewTarget>)>,
}

impl Views<'_, '_> {
    /// Every view that draws meshes, its key, and the triangle's pipeline in it.
    fn each(&mut self) -> Vec<(RetainedViewEntity, MeshPipelineKey, CachedRenderPipelineId)> {
        let views = self.views.iter().filter_map(|(view, is_seen)| {
            let id = view.retained_view_entity;
            let key = *self.keys.get(&id)?;
            // A view without a picture of its own is a reflected one.
            let misfit = if is_seen {
                Misfit::None
            } else {
                self.pipeline.triangle.misfit
            };
            let pipelines = &mut self.pipelines;
            let pipeline = pipelines.specialize(&self.cache, &self.pipeline, (key, misfit));
            Some((id, key, pipeline))
        });
        views.collect()
    }
}

fn queue_transparent(
    functions: Res<DrawFunctions<Transparent3d>>,
    mut views: Views,
    owner: Res<Owner>,
    mut phases: ResMut<ViewSortedRenderPhases<Transparent3d>>,
) {
    for (id, _, pipeline) in views.each() {
        let Some(phase) = phases.get_mut(&id) else {
            continue;
        };
        phase.add_transient(Transparent3d {
            sorting_info: TransparentSortingInfo3d::Sorted {
                mesh_center: views.pipeline.triangle.corners.iter().sum::<Vec3>() / 3.0,
                depth_bias: 0.0,
            },
            distance: 0.0,
            pipeline,
            entity: (Entity::PLACEHOLDER, owner.0),
            draw_function: functions.read().id::<DrawTriangleItem>(),
            batch_range: 0..1,
            extra_index: PhaseItemExtraIndex::None,
            indexed: false,
        });
    }
}

fn queue_opaque(
    functions: Res<DrawFunctions<Opaque3d>>,
    mut views: Views,
    owner: Res<Owner>,
    mut phases: ResMut<ViewBinnedRenderPhases<Opaque3d>>,
    mut kept: Local<HashSet<(RetainedViewEntity, MeshPipelineKey)>>,
) {
    for (id, key, pipeline) in views.each() {
        let Some(phase) = phases.get_mut(&id) else {
            continue;
        };
        let retained = views.pipeline.triangle.phase == Phase::OpaqueRetained;
        if retained && !kept.insert((id, key)) {
            continue;
        }
        phase.remove(owner.0);
        phase.add(
            Opaque3dBatchSetKey {
                pipeline,
                draw_function: functions.read().id::<DrawTriangleItem>(),
                material_bind_group_index: None,
                slabs: default(),
                lightmap_slab: None,
            },
            Opaque3dBinKey {
                asset_id: AssetId::<Mesh>::default().untyped(),
            },
            (Entity::PLACEHOLDER, owner.0),
            InputUniformIndex::default(),
            BinnedRenderPhaseType::NonMesh,
        );
    }
}
