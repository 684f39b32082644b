//! What other plugins may put into a view: phase items of their own, with pipelines of their own.

mod own_mesh;
mod triangle;

use bevy::{
    core_pipeline::core_3d::CORE_3D_DEPTH_FORMAT,
    pbr::{MeshPipeline, MeshPipelineKey, MeshPipelineSystems},
    prelude::*,
    render::{
        RenderApp, RenderStartup,
        render_resource::{
            BindGroupLayoutDescriptor, ColorTargetState, ColorWrites, CompareFunction,
            DepthStencilState, Face, FragmentState, MultisampleState, PrimitiveState,
            RenderPipelineDescriptor, VertexState,
        },
    },
    shader::Shader,
};

pub use own_mesh::{OwnPipeline, add_own_pipeline};
pub use triangle::{Misfit, Phase, Triangle, When};

/// Makes a plugin's own pipeline, when the renderer starts, of a shader and the engine's pipeline for meshes.
fn init_pipeline<P: Resource>(
    app: &mut App,
    shader: Shader,
    pipeline: impl Fn(MeshPipeline, Handle<Shader>) -> P + Send + Sync + 'static,
) {
    let shader = app.world_mut().resource_mut::<Assets<Shader>>().add(shader);
    let init = move |mut commands: Commands, mesh_pipeline: Res<MeshPipeline>| {
        commands.insert_resource(pipeline(mesh_pipeline.clone(), shader.clone()));
    };
    app.sub_app_mut(RenderApp)
        .add_systems(RenderStartup, init.after(MeshPipelineSystems));
}

/// Opaque, as the view of this key wants it, and one-sided: the wrong winding would take it away.
fn descriptor(
    label: &'static str,
    layout: Vec<BindGroupLayoutDescriptor>,
    shader: &Handle<Shader>,
    key: MeshPipelineKey,
) -> RenderPipelineDescriptor {
    RenderPipelineDescriptor {
        label: Some(label.into()),
        layout,
        vertex: VertexState {
            shader: shader.clone(),
            ..default()
        },
        fragment: Some(FragmentState {
            shader: shader.clone(),
            targets: vec![Some(ColorTargetState {
                format: key.target_format(),
                blend: None,
                write_mask: ColorWrites::ALL,
            })],
            ..default()
        }),
        primitive: PrimitiveState {
            cull_mode: Some(Face::Back),
            ..default()
        },
        depth_stencil: Some(DepthStencilState {
            format: CORE_3D_DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(CompareFunction::GreaterEqual),
            stencil: default(),
            bias: default(),
        }),
        multisample: MultisampleState {
            count: key.msaa_samples(),
            ..default()
        },
        ..default()
    }
}
