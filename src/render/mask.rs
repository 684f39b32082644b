//! The pipelines that draw a mirror's own surface, and the one that clears what lies behind it.

use bevy::{
    asset::{AssetServer, Handle, load_embedded_asset},
    core_pipeline::core_3d::CORE_3D_DEPTH_FORMAT,
    ecs::prelude::*,
    mesh::{Mesh, MeshVertexBufferLayoutRef, PrimitiveTopology},
    render::{
        mesh::RenderMesh,
        render_resource::{
            BindGroupLayoutDescriptor, BindGroupLayoutEntries, BlendComponent, BlendFactor,
            BlendOperation, BlendState, CachedRenderPipelineId, ColorTargetState, ColorWrites,
            CompareFunction, DepthStencilState, FragmentState, IndexFormat, MultisampleState,
            PipelineCache, PrimitiveState, RenderPipelineDescriptor, ShaderStages,
            SpecializedMeshPipeline, SpecializedMeshPipelineError, SpecializedMeshPipelines,
            SpecializedRenderPipeline, SpecializedRenderPipelines, StencilFaceState,
            StencilOperation, StencilState, TextureFormat, VertexState,
            binding_types::{texture_depth_2d, texture_depth_2d_multisampled, uniform_buffer},
        },
        view::ViewUniform,
    },
    shader::Shader,
    utils::default,
};

use super::prepare::MirrorUniform;

/// Layouts and shader of the mirror pass's own pipelines.
#[derive(Resource)]
pub struct MirrorPipelines {
    /// The view that sees a surface, and the mirror's transform.
    pub surface_layout: BindGroupLayoutDescriptor,
    /// The camera's depth, without and with samples.
    pub depth_layouts: [BindGroupLayoutDescriptor; 2],
    shader: Handle<Shader>,
}

impl MirrorPipelines {
    pub fn depth_layout(&self, samples: u32) -> &BindGroupLayoutDescriptor {
        &self.depth_layouts[usize::from(samples > 1)]
    }
}

/// The pipelines made so far, by mesh layout and key.
#[derive(Resource, Default)]
pub struct SpecializedMasks {
    meshes: SpecializedMeshPipelines<MirrorPipelines>,
    clear: SpecializedRenderPipelines<MirrorPipelines>,
}

/// What a pass demands of its pipelines.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct PassKey {
    pub color: TextureFormat,
    pub depth_stencil: TextureFormat,
    pub samples: u32,
}

/// Which of the draws of a surface.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub enum SurfaceDraw {
    /// Counts the stencil up where the camera sees the surface.
    Mask,
    /// The same where a reflection shows it.
    InnerMask,
    /// Counts the stencil down again, and puts the surface's depth in place of its reflection's.
    Restore,
    /// Depth into the camera's own depth texture.
    Depth,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct SurfaceKey {
    draw: SurfaceDraw,
    pass: PassKey,
    topology: PrimitiveTopology,
    strip_index_format: Option<IndexFormat>,
}

impl SpecializedMasks {
    /// The pipeline for one draw of `mesh`; `None` for a mesh without positions.
    pub fn surface(
        &mut self,
        cache: &PipelineCache,
        pipelines: &MirrorPipelines,
        draw: SurfaceDraw,
        pass: PassKey,
        mesh: &RenderMesh,
    ) -> Option<CachedRenderPipelineId> {
        let topology = mesh.primitive_topology();
        let key = SurfaceKey {
            draw,
            pass,
            topology,
            strip_index_format: mesh.index_format().filter(|_| topology.is_strip()),
        };
        self.meshes
            .specialize(cache, pipelines, key, &mesh.layout)
            .ok()
    }

    /// The pipeline that clears color and depth of every masked pixel.
    pub fn clear(
        &mut self,
        cache: &PipelineCache,
        pipelines: &MirrorPipelines,
        pass: PassKey,
    ) -> CachedRenderPipelineId {
        self.clear.specialize(cache, pipelines, pass)
    }
}

pub fn init_mirror_pipelines(mut commands: Commands, assets: Res<AssetServer>) {
    let depth_layout = |binding| {
        BindGroupLayoutDescriptor::new(
            "planar_mirror_depth_layout",
            &BindGroupLayoutEntries::single(ShaderStages::FRAGMENT, binding),
        )
    };
    commands.insert_resource(MirrorPipelines {
        surface_layout: BindGroupLayoutDescriptor::new(
            "planar_mirror_surface_layout",
            &BindGroupLayoutEntries::sequential(
                ShaderStages::VERTEX,
                (
                    uniform_buffer::<ViewUniform>(true),
                    uniform_buffer::<MirrorUniform>(true),
                ),
            ),
        ),
        depth_layouts: [
            depth_layout(texture_depth_2d()),
            depth_layout(texture_depth_2d_multisampled()),
        ],
        shader: load_embedded_asset!(assets.as_ref(), "mask.wgsl"),
    });
}

impl SpecializedMeshPipeline for MirrorPipelines {
    type Key = SurfaceKey;

    fn specialize(
        &self,
        key: Self::Key,
        layout: &MeshVertexBufferLayoutRef,
    ) -> Result<RenderPipelineDescriptor, SpecializedMeshPipelineError> {
        let positions = layout
            .0
            .get_layout(&[Mesh::ATTRIBUTE_POSITION.at_shader_location(0)])?;
        let pass = key.pass;
        let mut descriptor = RenderPipelineDescriptor {
            layout: vec![self.surface_layout.clone()],
            vertex: VertexState {
                shader: self.shader.clone(),
                buffers: vec![positions],
                ..default()
            },
            // Which side is the front is the plane's business: see the math.
            primitive: PrimitiveState {
                topology: key.topology,
                strip_index_format: key.strip_index_format,
                cull_mode: None,
                ..default()
            },
            multisample: samples(pass.samples),
            ..default()
        };
        let (label, vertex) = match key.draw {
            SurfaceDraw::Mask | SurfaceDraw::InnerMask => ("planar_mirror_mask", "mask_vertex"),
            SurfaceDraw::Restore => ("planar_mirror_restore", "depth_vertex"),
            SurfaceDraw::Depth => ("planar_mirror_depth", "depth_vertex"),
        };
        descriptor.label = Some(label.into());
        descriptor.vertex.entry_point = Some(vertex.into());
        descriptor.depth_stencil = Some(match key.draw {
            // Where two mirrors overlap the nearer one is seen.
            SurfaceDraw::Mask | SurfaceDraw::InnerMask => DepthStencilState {
                stencil: stencil(StencilOperation::IncrementClamp),
                ..depth(pass.depth_stencil, CompareFunction::GreaterEqual)
            },
            SurfaceDraw::Restore => DepthStencilState {
                stencil: stencil(StencilOperation::DecrementClamp),
                ..depth(pass.depth_stencil, CompareFunction::Always)
            },
            SurfaceDraw::Depth => depth(CORE_3D_DEPTH_FORMAT, CompareFunction::GreaterEqual),
        });
        if key.draw == SurfaceDraw::Depth {
            return Ok(descriptor);
        }
        let mut fragment = FragmentState {
            shader: self.shader.clone(),
            entry_point: Some("empty_fragment".into()),
            targets: vec![Some(ColorTargetState {
                format: pass.color,
                blend: None,
                write_mask: ColorWrites::empty(),
            })],
            ..default()
        };
        if key.draw == SurfaceDraw::Mask {
            let mut defs = vec!["MASK".into()];
            if pass.samples > 1 {
                defs.push("MULTISAMPLED".into());
            }
            descriptor
                .layout
                .push(self.depth_layout(pass.samples).clone());
            descriptor.vertex.shader_defs = defs.clone();
            fragment.shader_defs = defs;
            fragment.entry_point = Some("mask_fragment".into());
        }
        descriptor.fragment = Some(fragment);
        Ok(descriptor)
    }
}

impl SpecializedRenderPipeline for MirrorPipelines {
    type Key = PassKey;

    fn specialize(&self, pass: Self::Key) -> RenderPipelineDescriptor {
        // The result is the blend constant: one pipeline for every color.
        let constant = BlendComponent {
            src_factor: BlendFactor::Constant,
            dst_factor: BlendFactor::Zero,
            operation: BlendOperation::Add,
        };
        RenderPipelineDescriptor {
            label: Some("planar_mirror_clear".into()),
            vertex: VertexState {
                shader: self.shader.clone(),
                entry_point: Some("clear_vertex".into()),
                ..default()
            },
            fragment: Some(FragmentState {
                shader: self.shader.clone(),
                entry_point: Some("clear_fragment".into()),
                targets: vec![Some(ColorTargetState {
                    format: pass.color,
                    blend: Some(BlendState {
                        color: constant,
                        alpha: constant,
                    }),
                    write_mask: ColorWrites::ALL,
                })],
                ..default()
            }),
            depth_stencil: Some(DepthStencilState {
                stencil: stencil(StencilOperation::Keep),
                ..depth(pass.depth_stencil, CompareFunction::Always)
            }),
            multisample: samples(pass.samples),
            ..default()
        }
    }
}

fn samples(count: u32) -> MultisampleState {
    MultisampleState { count, ..default() }
}

/// Writes depth, without a stencil test.
fn depth(format: TextureFormat, compare: CompareFunction) -> DepthStencilState {
    DepthStencilState {
        format,
        depth_write_enabled: Some(true),
        depth_compare: Some(compare),
        stencil: default(),
        bias: default(),
    }
}

/// Draws where the stencil holds the reference value.
fn stencil(pass_op: StencilOperation) -> StencilState {
    let face = StencilFaceState {
        compare: CompareFunction::Equal,
        pass_op,
        ..StencilFaceState::IGNORE
    };
    StencilState {
        front: face,
        back: face,
        read_mask: 0xff,
        write_mask: 0xff,
    }
}
