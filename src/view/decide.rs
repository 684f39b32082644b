//! Which camera sees which mirror, and otherwise why not.

use bevy::{
    asset::Assets,
    camera::{
        Camera, Camera3d, ShadowLodOrigin,
        primitives::Aabb,
        visibility::{InheritedVisibility, RenderLayers},
    },
    core_pipeline::prepass::DeferredPrepass,
    ecs::prelude::*,
    mesh::{Mesh, Mesh3d},
    render::camera::TemporalJitter,
    transform::components::GlobalTransform,
};
use glam::{DAffine3, DMat4, DVec2, DVec3};

use super::{Decision, DepthRange, PlannedView, ReflectedView, ReflectedViews, fit::MirrorPatches};
use crate::{
    math::{PlanarPatch, Plane, Skip, ViewInput, plan_reflected_view, transform_patch},
    mirror::{MirrorPlane, NoMirrors, PlanarMirror},
    status::{NotDrawn, Projection},
};

/// Stencil values are 8 bits wide, and 0 is "no mirror".
pub const MAX_MIRRORS: usize = 255;

/// A user's camera, widened to the precision of the maths.
pub struct CameraInput {
    entity: Entity,
    layers: RenderLayers,
    view: Result<(DAffine3, DMat4, DVec2), NotDrawn>,
    /// A jittered camera looks up to half a pixel beside its projection.
    jitter_px: f64,
}

/// Pairs every mirror with every camera that may see it.
pub fn decide_reflected_views(
    cameras: Query<
        (
            Entity,
            &Camera,
            &GlobalTransform,
            Option<&RenderLayers>,
            Has<DeferredPrepass>,
            Has<TemporalJitter>,
        ),
        (With<Camera3d>, Without<NoMirrors>, Without<ReflectedView>),
    >,
    mirrors: Query<(
        Entity,
        &PlanarMirror,
        &GlobalTransform,
        &InheritedVisibility,
        Option<&Mesh3d>,
        Option<&RenderLayers>,
        Option<&Aabb>,
    )>,
    ranged: Query<(), Or<(With<Camera>, With<ShadowLodOrigin>)>>,
    meshes: Option<Res<Assets<Mesh>>>,
    patches: Res<MirrorPatches>,
    mut inputs: Local<Vec<CameraInput>>,
    mut views: ResMut<ReflectedViews>,
) {
    views.decisions.clear();
    views.users_views = ranged.iter().count();
    inputs.clear();
    inputs.extend(
        cameras
            .iter()
            .filter(|(_, camera, ..)| camera.is_active)
            .map(
                |(entity, camera, transform, layers, deferred, jittered)| CameraInput {
                    entity,
                    layers: layers.cloned().unwrap_or_default(),
                    view: camera_view(camera, transform, deferred),
                    jitter_px: if jittered { 0.5 } else { 0.0 },
                },
            ),
    );

    // The order of archetypes changes with unrelated components; a status must not.
    inputs.sort_unstable_by_key(|camera| camera.entity);

    for (mirror, settings, transform, visible, mesh, layers, aabb) in &mirrors {
        let world_from_local = transform.affine().as_daffine3();
        let is_loaded = |mesh: &Mesh3d| meshes.as_ref().is_some_and(|m| m.contains(mesh));
        let mesh = mesh.filter(|mesh| is_loaded(mesh));
        let patch = mirror_patch(settings, mesh, aabb, &patches).and_then(|patch| {
            transform_patch(&patch, &world_from_local).ok_or(NotDrawn::DegenerateTransform)
        });
        let no_layers = RenderLayers::default();
        let layers = layers.unwrap_or(&no_layers);
        for camera in inputs.iter() {
            let view = if !views.can_draw {
                Err(NotDrawn::NoRenderer)
            } else if !visible.get() {
                Err(NotDrawn::Hidden)
            } else if !camera.layers.intersects(layers) {
                Err(NotDrawn::OtherLayers)
            } else {
                let was_drawn = views.entities.contains_key(&(camera.entity, mirror));
                plan(camera, &patch, was_drawn).map(|(plane, plan)| PlannedView {
                    plane,
                    plan,
                    clip: settings.clip,
                    projection: Projection::Plain,
                    depths: DepthRange::EVERYTHING,
                })
            };
            views.decisions.push(Decision {
                camera: camera.entity,
                mirror,
                view,
            });
        }
    }
    for camera in inputs.iter() {
        keep_nearest(&mut views.decisions, camera);
    }
}

/// The camera as the maths wants it: `world_from_view`, `clip_from_view`, viewport in pixels.
fn camera_view(
    camera: &Camera,
    transform: &GlobalTransform,
    deferred: bool,
) -> Result<(DAffine3, DMat4, DVec2), NotDrawn> {
    if deferred {
        return Err(NotDrawn::DeferredCamera);
    }
    match (
        camera.physical_viewport_size(),
        camera.physical_target_size(),
    ) {
        (Some(viewport), Some(target))
            if viewport.min_element() > 0 && target.min_element() > 0 =>
        {
            Ok((
                transform.affine().as_daffine3(),
                camera.clip_from_view().as_dmat4(),
                viewport.as_dvec2(),
            ))
        }
        _ => Err(NotDrawn::NoTarget),
    }
}

fn mirror_patch(
    settings: &PlanarMirror,
    mesh: Option<&Mesh3d>,
    aabb: Option<&Aabb>,
    patches: &MirrorPatches,
) -> Result<PlanarPatch, NotDrawn> {
    let mesh = mesh.ok_or(NotDrawn::NoMesh)?;
    match settings.plane {
        MirrorPlane::FromMesh => *patches.0.get(&mesh.id()).ok_or(NotDrawn::NoMesh)?,
        MirrorPlane::Local { point, normal } => {
            let bounds = aabb.map(|aabb| (aabb.center.as_dvec3(), aabb.half_extents.as_dvec3()));
            PlanarPatch::from_point_and_normal(point.as_dvec3(), normal.as_dvec3(), bounds)
                .ok_or(NotDrawn::DegenerateTransform)
        }
    }
}

fn plan(
    camera: &CameraInput,
    patch: &Result<(Plane, Option<[DVec3; 4]>), NotDrawn>,
    was_drawn: bool,
) -> Result<(Plane, crate::math::ReflectedViewPlan), NotDrawn> {
    let (plane, corners) = (*patch)?;
    let (world_from_view, clip_from_view, viewport_size) = camera.view?;
    plan_reflected_view(&ViewInput {
        world_from_view,
        clip_from_view,
        viewport_size,
        plane,
        corners,
        jitter_px: camera.jitter_px,
        was_drawn,
    })
    .map(|plan| (plane, plan))
    .map_err(|skip| match skip {
        Skip::DegenerateView => NotDrawn::DegenerateCamera,
        Skip::EyeBehind => NotDrawn::EyeBehind,
        Skip::OutOfView => NotDrawn::OutOfView,
        Skip::TooThin => NotDrawn::TooThin,
        Skip::BelowPrecision => NotDrawn::BelowPrecision,
    })
}

/// Leaves the nearest [`MAX_MIRRORS`] views of a camera, by distance from the eye.
fn keep_nearest(decisions: &mut [Decision], camera: &CameraInput) {
    let Ok((world_from_view, ..)) = camera.view else {
        return;
    };
    let seen = |decision: &Decision| decision.camera == camera.entity && decision.view.is_ok();
    if decisions.iter().filter(|decision| seen(decision)).count() <= MAX_MIRRORS {
        return;
    }
    let distance = |view: &PlannedView| view.plane.origin.distance(world_from_view.translation);
    let mut nearest: Vec<(f64, usize)> = decisions
        .iter()
        .enumerate()
        .filter(|(_, decision)| seen(decision))
        .filter_map(|(index, decision)| Some((distance(decision.view.as_ref().ok()?), index)))
        .collect();
    nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
    for &(_, index) in &nearest[MAX_MIRRORS..] {
        decisions[index].view = Err(NotDrawn::TooManyMirrors);
    }
}
