//! What to draw: [`ExtractedMirrors`], and the reflected views made to fit their cameras.

use core::ops::Range;

use bevy::{
    asset::AssetId,
    camera::{
        Camera3d, MainPassResolutionOverride, primitives::Frustum, visibility::VisibilityRange,
    },
    core_pipeline::prepass::PreviousViewData,
    ecs::{prelude::*, query::QueryData, schedule::ScheduleLabel},
    light::cluster::GlobalClusterSettings,
    math::{Affine3A, primitives::HalfSpace},
    mesh::{Mesh, Mesh3d},
    pbr::PreviousGlobalTransform,
    render::{
        Extract,
        camera::{CameraMainPassTextureFormats, ExtractedCamera, TemporalJitter},
        render_resource::TextureUsages,
        sync_world::RenderEntity,
        view::ExtractedView,
    },
    transform::components::GlobalTransform,
};
use glam::{Mat4, Vec2, Vec3, Vec4};

use super::preprocess::ReflectedCore3d;
use crate::{
    math::depth_error,
    status::Projection,
    view::{Lamp, ReflectedViews},
};

/// Every reflection of this frame.
#[derive(Resource, Default)]
pub struct ExtractedMirrors {
    /// Grouped by camera; in the order of drawing, which is that of a tree: after each view the
    /// views of mirrors that are seen in it.
    pub views: Vec<ExtractedMirrorView>,
    /// The surfaces of all views, each view's together.
    pub surfaces: Vec<ExtractedSurface>,
    /// The shadow cascades of their own that all views read, each view's together.
    pub cascades: Vec<ExtractedCascade>,
    /// The lamps of all views that list them, each view's together.
    pub lamps: Vec<Lamp>,
}

/// A reflected view. Entities are those of the render world.
pub struct ExtractedMirrorView {
    /// The user's camera.
    pub camera: Entity,
    /// The camera, or the reflected view, that sees the mirror.
    pub viewer: Entity,
    /// The reflected view.
    pub view: Entity,
    /// The same in the main world.
    pub main_view: Entity,
    /// From 1; see [`PlannedView`].
    pub bounce: u8,
    /// The surfaces that are masked.
    pub surfaces: Range<usize>,
    pub clip_from_view: Mat4,
    /// See [`PlannedView`].
    pub clip_unbounded: Option<Mat4>,
    /// See [`PlannedView`].
    pub ndc_bounds: (Vec2, Vec2),
    /// Which of [`ExtractedMirrors::cascades`] are its own.
    pub cascades: Range<usize>,
    /// Which of [`ExtractedMirrors::lamps`] are in its only cluster; see [`PlannedView`].
    pub lamps: Option<Range<usize>>,
    /// By how much the depths that two programs compute for a surface in `view` may differ while
    /// its near plane lies on the mirror.
    pub depth_noise: f32,
    /// Whether it does.
    pub is_oblique: bool,
    /// Whether other plugins put something into it.
    pub has_foreign_items: bool,
    /// Whether the GPU may cull by the view's frustum.
    pub culls_on_gpu: bool,
}

impl ExtractedMirrorView {
    /// Whether it is seen by an odd number of reflections, which turn the winding around.
    pub fn is_flipped(&self) -> bool {
        self.bounce % 2 == 1
    }

    /// A projection for the view as the GPU gets it: its space has the handedness of the camera's.
    ///
    /// A reflected view's own axes are left-handed. A shader that builds a billboard from them would
    /// make one that winds like no other mesh in the reflection. So the axis that points to the
    /// right is turned around, and the projection puts it right again: every point of the world
    /// stays where it is in the picture, to the bit.
    pub fn handed(&self, clip_from_view: Mat4) -> Mat4 {
        if self.is_flipped() {
            clip_from_view * Mat4::from_scale(TURN_RIGHT_AROUND)
        } else {
            clip_from_view
        }
    }
}

const TURN_RIGHT_AROUND: Vec3 = Vec3::new(-1.0, 1.0, 1.0);

/// The surface of a mirror.
pub struct ExtractedSurface {
    /// In the main world.
    pub mirror: Entity,
    pub mesh: AssetId<Mesh>,
    pub world_from_local: Mat4,
    /// Where the camera saw it in the last frame.
    pub previous_clip_from_local: Mat4,
    /// Of the plane, in the world.
    pub normal: Vec3,
    /// Where it begins to fade in, is there, begins to fade out and is gone, by distance from the
    /// eye; `None` if it does not fade.
    pub fade: Option<Vec4>,
}

/// A mirror as extraction reads it.
#[derive(QueryData)]
pub struct SurfaceInput {
    entity: Entity,
    mesh: &'static Mesh3d,
    transform: &'static GlobalTransform,
    previous: Option<&'static PreviousGlobalTransform>,
    range: Option<&'static VisibilityRange>,
}

/// See [`SeenCascade`](crate::view::SeenCascade).
#[derive(Clone, Copy)]
pub struct ExtractedCascade {
    pub light: Entity,
    pub index: usize,
    pub ndc_bounds: Option<(Vec2, Vec2)>,
}

pub fn extract_mirrors(
    mut extracted: ResMut<ExtractedMirrors>,
    views: Extract<Res<ReflectedViews>>,
    entities: Extract<Query<RenderEntity>>,
    mirrors: Extract<Query<SurfaceInput>>,
    previous: Extract<Query<&PreviousViewData>>,
) {
    let extracted = &mut *extracted;
    extracted.views.clear();
    extracted.surfaces.clear();
    extracted.cascades.clear();
    extracted.lamps.clear();
    for (index, planned) in views.planned.iter().enumerate() {
        if planned.viewer.is_none() {
            extract_tree(index, &views, &entities, (&mirrors, &previous), extracted);
        }
    }
}

/// Extracts a view, then all that is seen in it.
fn extract_tree(
    index: usize,
    views: &ReflectedViews,
    entities: &Query<RenderEntity>,
    (mirrors, previous): (&Query<SurfaceInput>, &Query<&PreviousViewData>),
    extracted: &mut ExtractedMirrors,
) {
    let planned = &views.planned[index];
    let outer = planned.viewer.map(|outer| &views.planned[outer]);
    let viewer = outer.map_or(Some(planned.camera), |outer| outer.entity);
    let render_entity = |entity: Option<Entity>| entities.get(entity?).ok();
    let (Some(camera), Some(viewer), Some(view), Some(main_view)) = (
        render_entity(Some(planned.camera)),
        render_entity(viewer),
        render_entity(planned.entity),
        planned.entity,
    ) else {
        return;
    };
    let first = extracted.surfaces.len();
    let before = previous.get(planned.camera).ok();
    extracted.surfaces.extend(
        mirrors
            .iter_many(&views.surfaces[planned.mirrors.clone()])
            .map(|mirror| surface(&mirror, planned.plane.normal.as_vec3(), before)),
    );
    let first_cascade = extracted.cascades.len();
    let read = &views.cascades[planned.cascades.clone()];
    extracted.cascades.extend(read.iter().filter_map(|seen| {
        Some(ExtractedCascade {
            light: render_entity(Some(seen.light))?,
            index: seen.index,
            ndc_bounds: seen.ndc_bounds,
        })
    }));
    let first_lamp = extracted.lamps.len();
    let lamps = planned.lamps.clone().map(|listed| {
        extracted
            .lamps
            .extend(views.lamps[listed].iter().filter_map(|lamp| {
                Some(Lamp {
                    light: render_entity(Some(lamp.light))?,
                    ..*lamp
                })
            }));
        first_lamp..extracted.lamps.len()
    });
    let (low, high) = planned.ndc_bounds;
    extracted.views.push(ExtractedMirrorView {
        camera,
        viewer,
        view,
        main_view,
        bounce: planned.bounce,
        surfaces: first..extracted.surfaces.len(),
        clip_from_view: planned.clip_from_view,
        clip_unbounded: planned.clip_unbounded(),
        ndc_bounds: (low.as_vec2(), high.as_vec2()),
        cascades: first_cascade..extracted.cascades.len(),
        lamps,
        depth_noise: depth_error(planned.plan.noise) as f32,
        is_oblique: planned.projection == Projection::Oblique,
        has_foreign_items: false,
        culls_on_gpu: planned.culls_on_gpu,
    });
    for inner in index + 1..views.planned.len() {
        if views.planned[inner].viewer == Some(index) {
            extract_tree(inner, views, entities, (mirrors, previous), extracted);
        }
    }
}

fn surface(
    mirror: &SurfaceInputItem,
    normal: Vec3,
    camera: Option<&PreviousViewData>,
) -> ExtractedSurface {
    let now = mirror.transform.affine();
    let before = mirror.previous.map_or(now, |previous| previous.0);
    let clip_from_world = camera.map_or(Mat4::IDENTITY, |camera| camera.clip_from_world);
    ExtractedSurface {
        mirror: mirror.entity,
        mesh: mirror.mesh.id(),
        world_from_local: now.into(),
        previous_clip_from_local: (clip_from_world.as_dmat4() * Mat4::from(before).as_dmat4())
            .as_mat4(),
        normal,
        fade: mirror
            .range
            .filter(|range| !range.is_abrupt())
            .map(|range| {
                let (appear, vanish) = (&range.start_margin, &range.end_margin);
                Vec4::new(appear.start, appear.end, vanish.start, vanish.end)
            }),
    }
}

/// Gives each reflected view what only its camera's extracted form knows, and lets the mask read
/// the camera's depth.
pub fn configure_mirror_views(
    mirrors: Res<ExtractedMirrors>,
    mut views: Query<(
        &mut ExtractedView,
        &mut ExtractedCamera,
        &mut Camera3d,
        Option<&mut Frustum>,
    )>,
    mut formats: ResMut<CameraMainPassTextureFormats>,
    clusters: Option<Res<GlobalClusterSettings>>,
) {
    let are_sorted_on_gpu = clusters.is_some_and(|settings| settings.gpu_clustering.is_some());
    for mirror in &mirrors.views {
        let Ok([main, reflected]) = views.get_many_mut([mirror.camera, mirror.view]) else {
            continue;
        };
        let (main_view, _, mut main_camera, _) = main;
        let (mut view, mut camera, _, frustum) = reflected;
        view.target_format = main_view.target_format;
        view.clip_from_view = mirror.handed(mirror.clip_from_view);
        if mirror.is_flipped() {
            let turned = Affine3A::from_scale(TURN_RIGHT_AROUND);
            view.world_from_view = (view.world_from_view.affine() * turned).into();
        }
        formats.insert(mirror.view, main_view.target_format);
        // Without a size no depth or transmission texture is made for a view that draws into
        // its camera's.
        camera.physical_target_size = None;
        // Lamps are sorted on the GPU by a system of the engine's own, which only its own schedule
        // can run.
        if mirror.lamps.is_some() || !are_sorted_on_gpu {
            camera.schedule = ReflectedCore3d.intern();
        }
        // What is to be seen was found out on the CPU, but for meshes with `NoCpuCulling`. The GPU
        // would do it again, and take what has no bounds for a point, which so narrow a frustum
        // often does not hold.
        if let Some(mut frustum) = frustum
            && !mirror.culls_on_gpu
        {
            for half_space in &mut frustum.half_spaces {
                *half_space = HalfSpace::new(Vec3::Z.extend(f32::INFINITY));
            }
        }
        let usages = TextureUsages::from(main_camera.depth_texture_usages);
        main_camera.depth_texture_usages = (usages | TextureUsages::TEXTURE_BINDING).into();
    }
}

/// Temporal anti-aliasing moves the camera's picture by parts of a pixel, and with it what shows
/// in its mirrors. An upscaler does so with a picture that has fewer pixels than its viewport.
pub fn share_jitter(
    mut commands: Commands,
    mirrors: Res<ExtractedMirrors>,
    mut jitters: Query<&mut TemporalJitter>,
    resolutions: Query<&MainPassResolutionOverride>,
) {
    for mirror in &mirrors.views {
        if let Ok([camera, mut view]) = jitters.get_many_mut([mirror.camera, mirror.view]) {
            view.offset = camera.offset;
        }
        match (resolutions.get(mirror.camera), resolutions.get(mirror.view)) {
            (Ok(size), _) => {
                let size = MainPassResolutionOverride(size.0);
                commands.entity(mirror.view).insert(size);
            }
            (Err(_), Ok(_)) => {
                let mut view = commands.entity(mirror.view);
                view.remove::<MainPassResolutionOverride>();
            }
            (Err(_), Err(_)) => {}
        }
    }
}
