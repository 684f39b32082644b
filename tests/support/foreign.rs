//! What other plugins may put into a view: phase items of their own, with pipelines of their own.

use bevy::{
    asset::AssetId,
    camera::visibility::{VisibilityClass, add_visibility_class},
    core_pipeline::core_3d::{
        CORE_3D_DEPTH_FORMAT, Opaque3d, Opaque3dBatchSetKey, Opaque3dBinKey, Transparent3d,
        TransparentSortingInfo3d,
    },
    ecs::{
        query::ROQueryItem,
        schedule::ScheduleConfigs,
        system::{ScheduleSystem, SystemParamItem},
    },
    mesh::MeshVertexBufferLayoutRef,
    pbr::{
        DrawMesh, MeshPipeline, MeshPipelineKey, MeshPipelineViewLayoutKey, RenderMeshInstances,
        SetMeshBindGroup, SetMeshViewBindGroup, SetMeshViewEmptyBindGroup, ViewKeyCache,
    },
    platform::collections::HashSet,
    prelude::*,
    render::{
        GpuResourceAppExt, Render, RenderApp, RenderStartup, RenderSystems,
        batching::gpu_preprocessing::GpuPreprocessingSupport,
        mesh::{RenderMesh, allocator::MeshAllocator},
        render_asset::RenderAssets,
        render_phase::{
            AddRenderCommand, BinnedRenderPhaseType, DrawFunctions, InputUniformIndex, PhaseItem,
            PhaseItemExtraIndex, RenderCommand, RenderCommandResult, SetItemPipeline,
            TrackedRenderPass, ViewBinnedRenderPhases, ViewSortedRenderPhases,
        },
        render_resource::{
            BlendState, ColorTargetState, ColorWrites, CompareFunction, DepthStencilState, Face,
            FragmentState, MultisampleState, PipelineCache, PrimitiveState,
            RenderPipelineDescriptor, SpecializedMeshPipeline, SpecializedMeshPipelineError,
            SpecializedMeshPipelines, SpecializedRenderPipeline, SpecializedRenderPipelines,
            VertexState,
        },
        sync_world::MainEntity,
        view::{ExtractedView, NoIndirectDrawing, RenderVisibleEntities, RetainedViewEntity},
    },
    shader::Shader,
};

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
        let shader = app
            .world_mut()
            .resource_mut::<Assets<Shader>>()
            .add(Shader::from_wgsl(self.wgsl(), self.label));
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
        let init = move |mut commands: Commands, mesh_pipeline: Res<MeshPipeline>| {
            commands.insert_resource(TrianglePipeline {
                mesh_pipeline: mesh_pipeline.clone(),
                shader: shader.clone(),
                triangle: self.clone(),
            });
        };
        app.sub_app_mut(RenderApp)
            .insert_resource(Owner(owner.into()))
            .init_gpu_resource::<SpecializedRenderPipelines<TrianglePipeline>>()
            .add_render_command::<Transparent3d, DrawTriangleItem>()
            .add_render_command::<Opaque3d, DrawTriangleItem>()
            .add_systems(RenderStartup, init.after(bevy::pbr::MeshPipelineSystems))
            .add_systems(Render, queue);
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
        let format = view_key.target_format();
        let samples = view_key.msaa_samples();
        RenderPipelineDescriptor {
            label: Some(self.triangle.label.into()),
            layout: vec![layout.main_layout.clone()],
            vertex: VertexState {
                shader: self.shader.clone(),
                ..default()
            },
            fragment: Some(FragmentState {
                shader: self.shader.clone(),
                targets: vec![Some(ColorTargetState {
                    format: match misfit {
                        Misfit::OtherFormat => {
                            bevy::render::render_resource::TextureFormat::R32Float
                        }
                        _ => format,
                    },
                    blend: match (misfit, self.triangle.phase) {
                        (Misfit::None, Phase::Transparent) => Some(BlendState::ALPHA_BLENDING),
                        _ => None,
                    },
                    write_mask: ColorWrites::ALL,
                })],
                ..default()
            }),
            // One-sided: the wrong winding would take it away.
            primitive: PrimitiveState {
                cull_mode: Some(Face::Back),
                ..default()
            },
            depth_stencil: match misfit {
                Misfit::NoDepth => None,
                _ => Some(depth()),
            },
            multisample: MultisampleState {
                count: match (misfit, samples) {
                    (Misfit::OtherSamples, 1) => 4,
                    (Misfit::OtherSamples, _) => 1,
                    _ => samples,
                },
                ..default()
            },
            ..default()
        }
    }
}

fn depth() -> DepthStencilState {
    DepthStencilState {
        format: CORE_3D_DEPTH_FORMAT,
        depth_write_enabled: Some(true),
        depth_compare: Some(CompareFunction::GreaterEqual),
        stencil: default(),
        bias: default(),
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

fn misfit_of(pipeline: &TrianglePipeline, direct: bool) -> Misfit {
    if direct {
        pipeline.triangle.misfit
    } else {
        Misfit::None
    }
}

fn queue_transparent(
    functions: Res<DrawFunctions<Transparent3d>>,
    pipeline: Res<TrianglePipeline>,
    mut pipelines: ResMut<SpecializedRenderPipelines<TrianglePipeline>>,
    cache: Res<PipelineCache>,
    keys: Res<ViewKeyCache>,
    owner: Res<Owner>,
    views: Query<(&ExtractedView, Has<NoIndirectDrawing>)>,
    mut phases: ResMut<ViewSortedRenderPhases<Transparent3d>>,
) {
    for (view, direct) in &views {
        let id = &view.retained_view_entity;
        let (Some(phase), Some(&key)) = (phases.get_mut(id), keys.get(id)) else {
            continue;
        };
        let key = (key, misfit_of(&pipeline, direct));
        phase.add_transient(Transparent3d {
            sorting_info: TransparentSortingInfo3d::Sorted {
                mesh_center: pipeline.triangle.corners.iter().sum::<Vec3>() / 3.0,
                depth_bias: 0.0,
            },
            distance: 0.0,
            pipeline: pipelines.specialize(&cache, &pipeline, key),
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
    pipeline: Res<TrianglePipeline>,
    mut pipelines: ResMut<SpecializedRenderPipelines<TrianglePipeline>>,
    cache: Res<PipelineCache>,
    keys: Res<ViewKeyCache>,
    owner: Res<Owner>,
    views: Query<(&ExtractedView, Has<NoIndirectDrawing>)>,
    mut phases: ResMut<ViewBinnedRenderPhases<Opaque3d>>,
    mut kept: Local<HashSet<(RetainedViewEntity, MeshPipelineKey)>>,
) {
    for (view, direct) in &views {
        let id = view.retained_view_entity;
        let (Some(phase), Some(&key)) = (phases.get_mut(&id), keys.get(&id)) else {
            continue;
        };
        if pipeline.triangle.phase == Phase::OpaqueRetained && !kept.insert((id, key)) {
            continue;
        }
        phase.remove(owner.0);
        let key = (key, misfit_of(&pipeline, direct));
        phase.add(
            Opaque3dBatchSetKey {
                pipeline: pipelines.specialize(&cache, &pipeline, key),
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

/// On a mesh without a material: drawn by a plugin's own pipeline and in a visibility class of its own.
#[derive(Component, Clone, Copy, Debug)]
#[require(VisibilityClass)]
#[component(on_add = add_visibility_class::<OwnPipeline>)]
pub struct OwnPipeline;

/// Draws what is [`OwnPipeline`]: the normal is the color.
pub fn add_own_pipeline(app: &mut App) {
    const WGSL: &str = "
        #import bevy_pbr::mesh_functions::{get_world_from_local, mesh_position_local_to_clip}
        struct Vertex {
            @builtin(instance_index) instance: u32,
            @location(0) position: vec3<f32>,
            @location(1) normal: vec3<f32>,
        }
        struct Varying {
            @builtin(position) position: vec4<f32>,
            @location(0) color: vec3<f32>,
        }
        @vertex
        fn vertex(vertex: Vertex) -> Varying {
            var out: Varying;
            let world_from_local = get_world_from_local(vertex.instance);
            out.position = mesh_position_local_to_clip(world_from_local, vec4(vertex.position, 1.0));
            out.color = vertex.normal * 0.4 + 0.5;
            return out;
        }
        @fragment
        fn fragment(in: Varying) -> @location(0) vec4<f32> {
            return vec4(in.color, 1.0);
        }";
    let shader = app
        .world_mut()
        .resource_mut::<Assets<Shader>>()
        .add(Shader::from_wgsl(WGSL, "own_pipeline"));
    let init = move |mut commands: Commands, mesh_pipeline: Res<MeshPipeline>| {
        commands.insert_resource(OwnMeshPipeline {
            mesh_pipeline: mesh_pipeline.clone(),
            shader: shader.clone(),
        });
    };
    app.sub_app_mut(RenderApp)
        .init_gpu_resource::<SpecializedMeshPipelines<OwnMeshPipeline>>()
        .add_render_command::<Opaque3d, DrawOwn>()
        .add_systems(RenderStartup, init.after(bevy::pbr::MeshPipelineSystems))
        .add_systems(Render, queue_own.in_set(RenderSystems::QueueMeshes));
}

#[derive(Resource)]
struct OwnMeshPipeline {
    mesh_pipeline: MeshPipeline,
    shader: Handle<Shader>,
}

type DrawOwn = (
    SetItemPipeline,
    SetMeshViewBindGroup<0>,
    SetMeshViewEmptyBindGroup<1>,
    SetMeshBindGroup<2>,
    DrawMesh,
);

impl SpecializedMeshPipeline for OwnMeshPipeline {
    type Key = MeshPipelineKey;

    fn specialize(
        &self,
        key: Self::Key,
        layout: &MeshVertexBufferLayoutRef,
    ) -> Result<RenderPipelineDescriptor, SpecializedMeshPipelineError> {
        let view = self
            .mesh_pipeline
            .get_view_layout(MeshPipelineViewLayoutKey::from(key));
        let vertices = layout.0.get_layout(&[
            Mesh::ATTRIBUTE_POSITION.at_shader_location(0),
            Mesh::ATTRIBUTE_NORMAL.at_shader_location(1),
        ])?;
        Ok(RenderPipelineDescriptor {
            label: Some("own_mesh_pipeline".into()),
            layout: vec![
                view.main_layout.clone(),
                view.empty_layout.clone(),
                self.mesh_pipeline.mesh_layouts.model_only.clone(),
            ],
            vertex: VertexState {
                shader: self.shader.clone(),
                buffers: vec![vertices],
                ..default()
            },
            fragment: Some(FragmentState {
                shader: self.shader.clone(),
                targets: vec![Some(ColorTargetState {
                    format: key.target_format(),
                    blend: None,
                    write_mask: ColorWrites::ALL,
                })],
                ..default()
            }),
            primitive: PrimitiveState {
                topology: key.primitive_topology(),
                cull_mode: Some(Face::Back),
                ..default()
            },
            depth_stencil: Some(depth()),
            multisample: MultisampleState {
                count: key.msaa_samples(),
                ..default()
            },
            ..default()
        })
    }
}

#[expect(
    clippy::too_many_arguments,
    reason = "each is one resource of the renderer"
)]
fn queue_own(
    functions: Res<DrawFunctions<Opaque3d>>,
    pipeline: Res<OwnMeshPipeline>,
    mut pipelines: ResMut<SpecializedMeshPipelines<OwnMeshPipeline>>,
    cache: Res<PipelineCache>,
    keys: Res<ViewKeyCache>,
    views: Query<(&ExtractedView, &RenderVisibleEntities)>,
    (meshes, instances, allocator): (
        Res<RenderAssets<RenderMesh>>,
        Res<RenderMeshInstances>,
        Res<MeshAllocator>,
    ),
    support: Res<GpuPreprocessingSupport>,
    mut phases: ResMut<ViewBinnedRenderPhases<Opaque3d>>,
) {
    for (view, visible) in &views {
        let id = &view.retained_view_entity;
        let (Some(phase), Some(&key), Some(visible)) = (
            phases.get_mut(id),
            keys.get(id),
            visible.get::<OwnPipeline>(),
        ) else {
            continue;
        };
        for (_, gone) in &visible.removed_entities {
            phase.remove(*gone);
        }
        for (_, entity) in visible.iter_visible() {
            phase.remove(*entity);
            let Some(instance) = instances.render_mesh_queue_data(*entity) else {
                continue;
            };
            let asset = instance.mesh_asset_id();
            let (Some(mesh), Some(slabs)) = (meshes.get(asset), allocator.mesh_slabs(&asset))
            else {
                continue;
            };
            let key = key
                | MeshPipelineKey::from_primitive_topology_and_strip_index(
                    mesh.primitive_topology(),
                    None,
                );
            let pipeline = pipelines
                .specialize(&cache, &pipeline, key, &mesh.layout)
                .expect("the test's meshes have positions and normals");
            phase.add(
                Opaque3dBatchSetKey {
                    pipeline,
                    draw_function: functions.read().id::<DrawOwn>(),
                    material_bind_group_index: None,
                    slabs,
                    lightmap_slab: None,
                },
                Opaque3dBinKey {
                    asset_id: asset.into(),
                },
                (Entity::PLACEHOLDER, *entity),
                instance.current_uniform_index,
                BinnedRenderPhaseType::mesh(instance.should_batch(), &support),
            );
        }
    }
}
