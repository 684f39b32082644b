//! The pipelines that draw a mirror's own surface, and the one that clears what lies behind it.

use bevy::{
    asset::{AssetServer, Handle, load_embedded_asset},
    core_pipeline::{
        core_3d::CORE_3D_DEPTH_FORMAT,
        prepass::{MOTION_VECTOR_PREPASS_FORMAT, NORMAL_PREPASS_FORMAT},
    },
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
    shader::{Shader, ShaderDefVal},
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
    /// Counts the stencil down again where that reflection shows something behind the surface:
    /// where its material has holes.
    InnerHoles,
    /// Counts the stencil down again, and puts the surface's depth in place of its reflection's.
    Restore,
    /// Depth into the camera's own depth texture, and what a prepass has besides.
    Depth(PrepassColors),
    /// Depth into the texture that a prepass leaves for others to read.
    PrepassDepth,
}

/// What the camera's prepass has written besides depth.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct PrepassColors {
    pub normals: bool,
    pub motion_vectors: bool,
}

impl PrepassColors {
    pub fn any(self) -> bool {
        self.normals || self.motion_vectors
    }

    /// The targets of a pipeline that writes them, as the engine's prepass has them.
    fn targets(self) -> Vec<Option<ColorTargetState>> {
        let target = |format| ColorTargetState {
            format,
            blend: None,
            write_mask: ColorWrites::ALL,
        };
        vec![
            self.normals.then(|| target(NORMAL_PREPASS_FORMAT)),
            self.motion_vectors
                .then(|| target(MOTION_VECTOR_PREPASS_FORMAT)),
        ]
    }
}

/// What of a surface is there, of all that its mesh covers.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct SurfaceShape {
    /// Only where its material was drawn, which has holes.
    pub is_cut_out: bool,
    /// Less and less of it, by its distance from the eye.
    pub fades: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct SurfaceKey {
    draw: SurfaceDraw,
    shape: SurfaceShape,
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
        (draw, shape): (SurfaceDraw, SurfaceShape),
        pass: PassKey,
        mesh: &RenderMesh,
    ) -> Option<CachedRenderPipelineId> {
        let topology = mesh.primitive_topology();
        let key = SurfaceKey {
            draw,
            shape,
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
                ShaderStages::VERTEX_FRAGMENT,
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
        let is_multisampled = pass.samples > 1;
        let is_cut_out = key.shape.is_cut_out;
        let reads_depth = matches!(key.draw, SurfaceDraw::Mask | SurfaceDraw::PrepassDepth);
        let (label, vertex, fragment) = match key.draw {
            SurfaceDraw::Mask => ("mask", "near_vertex", "seen_fragment"),
            SurfaceDraw::InnerMask => ("inner_mask", "near_vertex", "empty_fragment"),
            SurfaceDraw::InnerHoles => ("inner_holes", "far_vertex", "empty_fragment"),
            SurfaceDraw::Restore => ("restore", "far_vertex", "empty_fragment"),
            SurfaceDraw::Depth(_) => ("depth", "far_vertex", "empty_fragment"),
            SurfaceDraw::PrepassDepth => ("prepass_depth", "far_vertex", "seen_fragment"),
        };
        descriptor.label = Some(format!("planar_mirror_{label}").into());
        descriptor.vertex.entry_point = Some(vertex.into());
        descriptor.depth_stencil = Some(match key.draw {
            // Where two mirrors overlap the nearer one is seen.
            SurfaceDraw::Mask => DepthStencilState {
                stencil: stencil(StencilOperation::IncrementClamp),
                ..depth(pass.depth_stencil, CompareFunction::GreaterEqual)
            },
            // Where there may be holes, the depth of what is behind them is needed once more.
            SurfaceDraw::InnerMask => DepthStencilState {
                stencil: stencil(StencilOperation::IncrementClamp),
                depth_write_enabled: Some(!is_cut_out),
                ..depth(pass.depth_stencil, CompareFunction::GreaterEqual)
            },
            SurfaceDraw::InnerHoles => DepthStencilState {
                stencil: stencil(StencilOperation::DecrementClamp),
                depth_write_enabled: Some(false),
                ..depth(pass.depth_stencil, CompareFunction::Greater)
            },
            SurfaceDraw::Restore => DepthStencilState {
                stencil: stencil(StencilOperation::DecrementClamp),
                ..depth(pass.depth_stencil, CompareFunction::Always)
            },
            SurfaceDraw::Depth(_) | SurfaceDraw::PrepassDepth => {
                depth(CORE_3D_DEPTH_FORMAT, CompareFunction::GreaterEqual)
            }
        });
        let mut defs: Vec<ShaderDefVal> = Vec::new();
        let mut define = |name: &str, is_defined: bool| {
            if is_defined {
                defs.push(name.into());
            }
        };
        let is_far_side = key.draw == SurfaceDraw::PrepassDepth;
        let cuts_out = key.draw == SurfaceDraw::Mask && is_cut_out;
        define("READS_DEPTH", reads_depth);
        define("MULTISAMPLED", reads_depth && is_multisampled);
        define("HAS_OTHER_SIDE", is_far_side || cuts_out);
        define("IS_FAR_SIDE", is_far_side);
        define("CUT_OUT", cuts_out);
        define("FADES", key.shape.fades);
        let no_color = ColorTargetState {
            format: pass.color,
            blend: None,
            write_mask: ColorWrites::empty(),
        };
        let mut fragment = FragmentState {
            shader: self.shader.clone(),
            entry_point: Some(fragment.into()),
            ..default()
        };
        match key.draw {
            SurfaceDraw::Depth(colors) if colors.any() => {
                define("PREPASS_COLORS", true);
                define("NORMALS", colors.normals);
                define("MOTION_VECTORS", colors.motion_vectors);
                fragment.entry_point = Some("prepass_fragment".into());
                fragment.targets = colors.targets();
            }
            SurfaceDraw::Depth(_) | SurfaceDraw::PrepassDepth => {}
            _ => fragment.targets = vec![Some(no_color)],
        }
        if reads_depth {
            descriptor
                .layout
                .push(self.depth_layout(pass.samples).clone());
        }
        descriptor.vertex.shader_defs = defs.clone();
        fragment.shader_defs = defs;
        let is_depth_alone =
            matches!(key.draw, SurfaceDraw::Depth(colors) if !colors.any()) && !key.shape.fades;
        descriptor.fragment = (!is_depth_alone).then_some(fragment);
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
