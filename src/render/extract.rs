//! What to draw: [`ExtractedMirrors`], and the reflected views made to fit their cameras.

use bevy::{
    asset::AssetId,
    camera::Camera3d,
    ecs::prelude::*,
    mesh::{Mesh, Mesh3d},
    render::{
        Extract,
        camera::{CameraMainPassTextureFormats, ExtractedCamera, TemporalJitter},
        render_resource::TextureUsages,
        sync_world::RenderEntity,
        view::ExtractedView,
    },
    transform::components::GlobalTransform,
};
use glam::{Mat4, Vec2};

use crate::view::{DepthRange, ReflectedView};

/// Every reflection of this frame, grouped by camera.
#[derive(Resource, Default)]
pub struct ExtractedMirrors(pub Vec<ExtractedMirror>);

/// One mirror as seen by one camera. Entities are those of the render world.
pub struct ExtractedMirror {
    /// The user's camera.
    pub camera: Entity,
    /// The reflected view.
    pub view: Entity,
    /// The surface that is masked.
    pub mesh: AssetId<Mesh>,
    pub world_from_local: Mat4,
    pub clip_from_view: Mat4,
    /// See [`ReflectedView`].
    pub clip_unbounded: Option<Mat4>,
    /// See [`ReflectedView`].
    pub ndc_bounds: (Vec2, Vec2),
    pub depths: DepthRange,
}

pub fn extract_mirrors(
    mut extracted: ResMut<ExtractedMirrors>,
    views: Extract<Query<(RenderEntity, &ReflectedView)>>,
    cameras: Extract<Query<RenderEntity>>,
    mirrors: Extract<Query<(&Mesh3d, &GlobalTransform)>>,
) {
    extracted.0.clear();
    for (view, reflected) in &views {
        let (Ok(camera), Ok((mesh, transform))) =
            (cameras.get(reflected.camera), mirrors.get(reflected.mirror))
        else {
            continue;
        };
        extracted.0.push(ExtractedMirror {
            camera,
            view,
            mesh: mesh.id(),
            world_from_local: transform.to_matrix(),
            clip_from_view: reflected.clip_from_view,
            clip_unbounded: reflected.clip_unbounded,
            ndc_bounds: reflected.ndc_bounds,
            depths: reflected.depths,
        });
    }
    // Stable, so that ids and draw order do not jump between frames.
    extracted
        .0
        .sort_by_key(|mirror| (mirror.camera, mirror.view));
}

/// Gives each reflected view what only its camera's extracted form knows, and lets the mask read
/// the camera's depth.
pub fn configure_mirror_views(
    mirrors: Res<ExtractedMirrors>,
    mut views: Query<(&mut ExtractedView, &mut ExtractedCamera, &mut Camera3d)>,
    mut formats: ResMut<CameraMainPassTextureFormats>,
) {
    for mirror in &mirrors.0 {
        let Ok([main, reflected]) = views.get_many_mut([mirror.camera, mirror.view]) else {
            continue;
        };
        let (main_view, _, mut main_camera) = main;
        let (mut view, mut camera, _) = reflected;
        view.target_format = main_view.target_format;
        view.clip_from_view = mirror.clip_from_view;
        formats.insert(mirror.view, main_view.target_format);
        // Without a size no depth or transmission texture is made for a view that draws into
        // its camera's.
        camera.physical_target_size = None;
        let usages = TextureUsages::from(main_camera.depth_texture_usages);
        main_camera.depth_texture_usages = (usages | TextureUsages::TEXTURE_BINDING).into();
    }
}

/// Temporal anti-aliasing moves the camera's picture by parts of a pixel, and with it what shows
/// in its mirrors.
pub fn share_jitter(mirrors: Res<ExtractedMirrors>, mut jitters: Query<&mut TemporalJitter>) {
    for mirror in &mirrors.0 {
        if let Ok([camera, mut view]) = jitters.get_many_mut([mirror.camera, mirror.view]) {
            view.offset = camera.offset;
        }
    }
}
