//! What the mirror pass reads of each camera: textures, pipelines, bind groups.

use core::ops::Range;

use bevy::{
    asset::AssetId,
    camera::{ClearColor, ClearColorConfig, CompositingSpace},
    color::{LinearRgba, Oklaba, Srgba},
    core_pipeline::prepass::ViewPrepassTextures,
    ecs::{prelude::*, system::SystemParam},
    image::ToExtents,
    material::AlphaMode,
    mesh::Mesh,
    pbr::{PreparedMaterial, RenderMaterialInstances},
    render::{
        camera::ExtractedCamera,
        erased_render_asset::ErasedRenderAssets,
        mesh::RenderMesh,
        render_asset::RenderAssets,
        render_resource::{
            BindGroup, BindGroupEntries, CachedRenderPipelineId, DynamicUniformBuffer,
            PipelineCache, ShaderType, TextureDescriptor, TextureDimension, TextureUsages,
        },
        renderer::{RenderDevice, RenderQueue},
        sync_world::MainEntity,
        texture::{CachedTexture, TextureCache},
        view::{ExtractedView, Msaa, ViewDepthTexture, ViewUniforms},
    },
};
use glam::{Mat4, Vec2, Vec3, Vec4};

use super::{
    extract::{ExtractedCascade, ExtractedMirrorView, ExtractedMirrors},
    mask::{MirrorPipelines, PassKey, PrepassColors, SpecializedMasks, SurfaceDraw, SurfaceShape},
    variant::StencilVariants,
};

/// Of one mirror's surface. The same struct stands in `mask.wgsl`.
#[derive(ShaderType)]
pub struct MirrorUniform {
    world_from_local: Mat4,
    previous_clip_from_local: Mat4,
    fade: Vec4,
    normal: Vec3,
    depth_noise: f32,
}

/// The uniforms of all surfaces of the frame.
#[derive(Resource, Default)]
pub struct MirrorUniforms(DynamicUniformBuffer<MirrorUniform>);

/// On a camera in the render world: the mirrors that it shows in this frame.
#[derive(Component)]
pub struct ViewMirrors {
    pub pass: PassKey,
    pub depth_stencil: CachedTexture,
    pub surface_group: BindGroup,
    pub depth_group: BindGroup,
    pub clear_pipeline: CachedRenderPipelineId,
    /// What a reflection shows where nothing is: the camera's own clear color.
    pub background: LinearRgba,
    /// In the order of [`ExtractedMirrors::views`].
    pub mirrors: Vec<PreparedMirror>,
    /// The surfaces of all of them.
    pub surfaces: Vec<PreparedSurface>,
    /// The shadow cascades of their own that they read.
    pub cascades: Vec<ExtractedCascade>,
}

/// A reflected view of a camera.
pub struct PreparedMirror {
    /// The camera or the reflected view that sees the surfaces.
    pub viewer: Entity,
    /// The reflected view, whose phases are drawn.
    pub view: Entity,
    /// How many reflections it is away from the camera, from 1: the stencil value of its pixels.
    pub bounce: u8,
    /// Which of the surfaces are its own.
    pub surfaces: Range<usize>,
    /// The lowest and the highest device coordinates of what is seen of the surfaces.
    pub ndc_bounds: (Vec2, Vec2),
    /// Which of the cascades are the reflection's.
    pub cascades: Range<usize>,
}

/// The surface of a mirror.
pub struct PreparedSurface {
    pub mesh: AssetId<Mesh>,
    pub uniform_offset: u32,
    pub mask_pipeline: CachedRenderPipelineId,
    /// For what a material with holes leaves out, of mirrors that are seen in mirrors.
    pub holes_pipeline: Option<CachedRenderPipelineId>,
    /// Also of the last one, after which nobody asks: it must not wait for this pipeline, and be
    /// gone for a frame, when another mirror comes into view.
    pub restore_pipeline: CachedRenderPipelineId,
    /// For the camera's own depth; only of mirrors that it sees itself, and whose material has not
    /// put it there.
    pub depth_pipeline: Option<CachedRenderPipelineId>,
    /// The same for the depth that a prepass leaves.
    pub prepass_depth_pipeline: Option<CachedRenderPipelineId>,
}

/// What mirrors are made of, whatever kind of `Material` it is.
#[derive(SystemParam)]
pub struct Materials<'w> {
    instances: Option<Res<'w, RenderMaterialInstances>>,
    materials: Option<Res<'w, ErasedRenderAssets<PreparedMaterial>>>,
}

impl Materials<'_> {
    /// Whether the material of a mirror has holes, and covers what is around them.
    fn is_cut_out(&self, mirror: Entity) -> bool {
        let (Some(instances), Some(materials)) = (&self.instances, &self.materials) else {
            return false;
        };
        let material = instances.instances.get(&MainEntity::from(mirror));
        material
            .and_then(|instance| materials.get(instance.asset_id))
            .is_some_and(|material| {
                matches!(
                    material.properties.alpha_mode,
                    AlphaMode::Mask(_) | AlphaMode::AlphaToCoverage
                )
            })
    }
}

/// What the camera's prepass has written besides depth.
fn prepass_colors(prepass: Option<&ViewPrepassTextures>) -> PrepassColors {
    prepass.map_or(PrepassColors::default(), |prepass| PrepassColors {
        normals: prepass.normal.is_some(),
        motion_vectors: prepass.motion_vectors.is_some(),
    })
}

/// Takes [`ViewMirrors`] off cameras that show none any more.
pub fn forget_mirrors(
    mut commands: Commands,
    mirrors: Res<ExtractedMirrors>,
    cameras: Query<Entity, With<ViewMirrors>>,
) {
    for camera in &cameras {
        if !mirrors.views.iter().any(|mirror| mirror.camera == camera) {
            commands.entity(camera).remove::<ViewMirrors>();
        }
    }
}

#[expect(
    clippy::too_many_arguments,
    reason = "each is one resource of the renderer"
)]
pub fn prepare_mirrors(
    mut commands: Commands,
    mirrors: Res<ExtractedMirrors>,
    cameras: Query<(
        &ExtractedCamera,
        &ExtractedView,
        &Msaa,
        &ViewDepthTexture,
        Option<&ViewPrepassTextures>,
    )>,
    meshes: Res<RenderAssets<RenderMesh>>,
    materials: Materials,
    (pipelines, variants, cache): (
        Res<MirrorPipelines>,
        Res<StencilVariants>,
        Res<PipelineCache>,
    ),
    mut masks: ResMut<SpecializedMasks>,
    mut uniforms: ResMut<MirrorUniforms>,
    view_uniforms: Res<ViewUniforms>,
    mut textures: ResMut<TextureCache>,
    clear_color: Res<ClearColor>,
    (device, queue): (Res<RenderDevice>, Res<RenderQueue>),
) {
    uniforms.0.clear();
    let mut offsets = Vec::with_capacity(mirrors.surfaces.len());
    // Of the views that lead to the one that is next, by bounce; the camera's comes first.
    let mut noises = Vec::new();
    for mirror in &mirrors.views {
        noises.truncate(usize::from(mirror.bounce) - 1);
        let depth_noise = noises.last().copied().unwrap_or(0.0);
        noises.push(if mirror.is_oblique {
            mirror.depth_noise
        } else {
            0.0
        });
        for surface in &mirrors.surfaces[mirror.surfaces.clone()] {
            offsets.push(uniforms.0.push(&MirrorUniform {
                world_from_local: surface.world_from_local,
                previous_clip_from_local: surface.previous_clip_from_local,
                fade: surface.fade.unwrap_or_default(),
                normal: surface.normal,
                depth_noise,
            }));
        }
    }
    uniforms.0.write_buffer(&device, &queue);
    let (Some(view_binding), Some(mirror_binding)) =
        (view_uniforms.uniforms.binding(), uniforms.0.binding())
    else {
        return;
    };
    let surface_group = device.create_bind_group(
        "planar_mirror_surface_group",
        &cache.get_bind_group_layout(&pipelines.surface_layout),
        &BindGroupEntries::sequential((view_binding, mirror_binding)),
    );

    for of_camera in mirrors.views.chunk_by(|a, b| a.camera == b.camera) {
        let entity = of_camera[0].camera;
        let Ok((camera, view, msaa, depth, prepass)) = cameras.get(entity) else {
            continue;
        };
        let Some(size) = camera.physical_target_size else {
            continue;
        };
        let pass = PassKey {
            color: view.target_format,
            depth_stencil: variants.format,
            samples: msaa.samples(),
        };
        let depth_stencil = textures.get(
            &device,
            TextureDescriptor {
                label: Some("planar_mirror_depth_stencil"),
                size: size.to_extents(),
                mip_level_count: 1,
                sample_count: pass.samples,
                dimension: TextureDimension::D2,
                format: pass.depth_stencil,
                usage: TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            },
        );
        let mut surfaces = Vec::new();
        let mut prepare_surfaces = |mirror: &ExtractedMirrorView| {
            let first = surfaces.len();
            for index in mirror.surfaces.clone() {
                let surface = &mirrors.surfaces[index];
                let id = surface.mesh;
                let Some(mesh) = meshes.get(id) else {
                    continue;
                };
                let shape = SurfaceShape {
                    is_cut_out: materials.is_cut_out(surface.mirror),
                    fades: surface.fade.is_some(),
                };
                let mut pipeline =
                    |draw| masks.surface(&cache, &pipelines, (draw, shape), pass, mesh);
                let is_outer = mirror.bounce == 1;
                let mask = if is_outer {
                    SurfaceDraw::Mask
                } else {
                    SurfaceDraw::InnerMask
                };
                // A material with holes is opaque around them, and drawn by now.
                let writes_depth = is_outer && !shape.is_cut_out;
                // Of a mesh without positions there are none.
                let (Some(mask_pipeline), Some(restore_pipeline)) =
                    (pipeline(mask), pipeline(SurfaceDraw::Restore))
                else {
                    continue;
                };
                surfaces.push(PreparedSurface {
                    mesh: id,
                    uniform_offset: offsets[index],
                    mask_pipeline,
                    holes_pipeline: (!is_outer && shape.is_cut_out)
                        .then(|| pipeline(SurfaceDraw::InnerHoles))
                        .flatten(),
                    restore_pipeline,
                    depth_pipeline: writes_depth
                        .then(|| pipeline(SurfaceDraw::Depth(prepass_colors(prepass))))
                        .flatten(),
                    prepass_depth_pipeline: (writes_depth
                        && prepass.is_some_and(|prepass| prepass.depth.is_some()))
                    .then(|| pipeline(SurfaceDraw::PrepassDepth))
                    .flatten(),
                });
            }
            first..surfaces.len()
        };
        let mut cascades = Vec::new();
        let mut prepare_cascades = |read: Range<usize>| {
            let first = cascades.len();
            cascades.extend_from_slice(&mirrors.cascades[read]);
            first..cascades.len()
        };
        let mirrors = of_camera
            .iter()
            .map(|mirror| PreparedMirror {
                viewer: mirror.viewer,
                view: mirror.view,
                bounce: mirror.bounce,
                surfaces: prepare_surfaces(mirror),
                ndc_bounds: mirror.ndc_bounds,
                cascades: prepare_cascades(mirror.cascades.clone()),
            })
            .collect();
        commands.entity(entity).insert(ViewMirrors {
            pass,
            depth_stencil,
            surface_group: surface_group.clone(),
            depth_group: device.create_bind_group(
                "planar_mirror_depth_group",
                &cache.get_bind_group_layout(pipelines.depth_layout(pass.samples)),
                &BindGroupEntries::single(depth.view()),
            ),
            clear_pipeline: masks.clear(&cache, &pipelines, pass),
            background: background(camera, &clear_color),
            mirrors,
            surfaces,
            cascades,
        });
    }
}

/// The camera's clear color in the space of its target, as the engine clears with it.
///
/// A camera that does not clear draws over what others drew, which has no reflection: there the
/// global clear color is taken.
fn background(camera: &ExtractedCamera, global: &ClearColor) -> LinearRgba {
    let color = match camera.clear_color {
        ClearColorConfig::Custom(color) => color,
        ClearColorConfig::Default | ClearColorConfig::None => global.0,
    };
    match camera.compositing_space {
        Some(CompositingSpace::Srgb) => {
            let color = Srgba::from(color);
            LinearRgba::new(color.red, color.green, color.blue, color.alpha)
        }
        Some(CompositingSpace::Oklab) => {
            let color = Oklaba::from(color);
            LinearRgba::new(color.lightness, color.a, color.b, color.alpha)
        }
        Some(CompositingSpace::Linear) | None => color.into(),
    }
}
