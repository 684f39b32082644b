//! Meshes that a plugin draws by a pipeline of its own, as the engine's example for it does.

use bevy::{
    camera::visibility::{VisibilityClass, add_visibility_class},
    core_pipeline::core_3d::{Opaque3d, Opaque3dBatchSetKey, Opaque3dBinKey},
    mesh::MeshVertexBufferLayoutRef,
    pbr::{
        DrawMesh, MeshPipeline, MeshPipelineKey, MeshPipelineViewLayoutKey, RenderMeshInstances,
        SetMeshBindGroup, SetMeshViewBindGroup, SetMeshViewEmptyBindGroup, ViewKeyCache,
    },
    prelude::*,
    render::{
        GpuResourceAppExt, Render, RenderApp, RenderSystems,
        batching::gpu_preprocessing::GpuPreprocessingSupport,
        mesh::{RenderMesh, allocator::MeshAllocator},
        render_asset::RenderAssets,
        render_phase::{
            AddRenderCommand, BinnedRenderPhaseType, DrawFunctions, SetItemPipeline,
            ViewBinnedRenderPhases,
        },
        render_resource::{
            PipelineCache, RenderPipelineDescriptor, SpecializedMeshPipeline,
            SpecializedMeshPipelineError, SpecializedMeshPipelines,
        },
        view::{ExtractedView, RenderVisibleEntities},
    },
    shader::Shader,
};

use super::{descriptor, init_pipeline};

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
    app.sub_app_mut(RenderApp)
        .init_gpu_resource::<SpecializedMeshPipelines<OwnMeshPipeline>>()
        .add_render_command::<Opaque3d, DrawOwn>()
        .add_systems(Render, queue_own.in_set(RenderSystems::QueueMeshes));
    let shader = Shader::from_wgsl(WGSL, "own_pipeline");
    init_pipeline(app, shader, |mesh_pipeline, shader| OwnMeshPipeline {
        mesh_pipeline,
        shader,
    });
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
        let layout = vec![
            view.main_layout.clone(),
            view.empty_layout.clone(),
            self.mesh_pipeline.mesh_layouts.model_only.clone(),
        ];
        let mut descriptor = descriptor("own_mesh_pipeline", layout, &self.shader, key);
        descriptor.vertex.buffers = vec![vertices];
        descriptor.primitive.topology = key.primitive_topology();
        Ok(descriptor)
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
