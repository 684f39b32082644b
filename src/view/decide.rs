//! Which camera sees which mirror, and otherwise why not.

use bevy::{
    camera::{Camera, Camera3d, RenderTarget, visibility::RenderLayers},
    core_pipeline::{prepass::DeferredPrepass, schedule::Core3d},
    ecs::{prelude::*, query::QueryData, schedule::ScheduleLabel},
    render::camera::{CameraRenderGraph, TemporalJitter},
    transform::components::GlobalTransform,
};
use glam::{DAffine3, DMat4, DVec2};

use super::{
    Decision, MirrorLimits, ReflectedView, ReflectedViews,
    cover::Walls,
    sight::{MirrorInput, Sight, UnusualMirrors, Viewer},
};
use crate::{math::Opening, mirror::NoMirrors, status::NotDrawn};

/// A user's camera, widened to the precision of the maths.
pub struct CameraInput {
    pub entity: Entity,
    pub layers: RenderLayers,
    pub view: Result<CameraView, NotDrawn>,
    /// Whether it shows the faces that other cameras cull.
    pub inverts_culling: bool,
    /// A jittered camera looks up to half a pixel beside its projection.
    pub jitter_px: f64,
}

#[derive(Clone, Copy)]
pub struct CameraView {
    pub world_from_view: DAffine3,
    pub clip_from_view: DMat4,
    /// In physical pixels.
    pub viewport_size: DVec2,
}

/// A user's camera, as the engine knows it.
#[derive(QueryData)]
pub struct UserCamera {
    entity: Entity,
    camera: &'static Camera,
    transform: &'static GlobalTransform,
    target: Option<&'static RenderTarget>,
    graph: Option<&'static CameraRenderGraph>,
    layers: Option<&'static RenderLayers>,
    is_deferred: Has<DeferredPrepass>,
    is_jittered: Has<TemporalJitter>,
}

/// Pairs every mirror with every camera that may see it, and what sees mirrors in mirrors.
pub fn decide_reflected_views(
    cameras: Query<UserCamera, (With<Camera3d>, Without<NoMirrors>, Without<ReflectedView>)>,
    mirrors: Query<MirrorInput>,
    unusual: UnusualMirrors,
    walls: Walls,
    limits: Res<MirrorLimits>,
    mut camera_inputs: Local<Vec<CameraInput>>,
    mut sight: Local<Sight>,
    mut views: ResMut<ReflectedViews>,
) {
    let views = &mut *views;
    views.decisions.clear();
    views.planned.clear();
    views.surfaces.clear();
    camera_inputs.clear();
    if mirrors.is_empty() {
        return;
    }
    camera_inputs.extend(
        cameras
            .iter()
            .filter(|it| it.camera.is_active)
            .map(|it| CameraInput {
                entity: it.entity,
                layers: it.layers.cloned().unwrap_or_default(),
                view: camera_view(&it),
                inverts_culling: it.camera.invert_culling,
                jitter_px: if it.is_jittered { 0.5 } else { 0.0 },
            }),
    );
    // The order of archetypes changes with unrelated components; a status must not.
    camera_inputs.sort_unstable_by_key(|camera| camera.entity);

    for mirror in &mirrors {
        views
            .decisions
            .extend(camera_inputs.iter().map(|camera| Decision {
                camera: camera.entity,
                mirror: mirror.entity,
                view: Err(NotDrawn::OtherLayers),
            }));
    }

    let default_layers = RenderLayers::default();
    for (index, camera) in camera_inputs.iter().enumerate() {
        let first = views.planned.len();
        let decisions = &mut views.decisions;
        let viewer = Viewer {
            can_draw: views.can_draw,
            camera,
            unusual: &unusual,
            default_layers: &default_layers,
            view: camera.view,
            walls: Some(&walls),
            opening: Opening::SCREEN,
            viewer: None,
            entity: Some(camera.entity),
            last: &views.entities,
            bounce: 1,
            max_views: limits.max_views,
        };
        sight.see(
            &viewer,
            &mirrors,
            &mut views.planned,
            &mut views.surfaces,
            |mirror, view| decisions[mirror * camera_inputs.len() + index].view = view,
        );
        // What is planned on the way is looked at in its turn.
        let mut next = first;
        while next < views.planned.len() {
            let outer = &views.planned[next];
            if outer.bounce < limits.max_bounces {
                let (low, high) = outer.ndc_bounds;
                let viewer = Viewer {
                    can_draw: views.can_draw,
                    camera,
                    unusual: &unusual,
                    default_layers: &default_layers,
                    view: camera.view.map(|view| CameraView {
                        world_from_view: outer.plan.world_from_view,
                        ..view
                    }),
                    walls: None,
                    opening: Opening {
                        low,
                        high,
                        plane_view: Some(outer.plan.plane_view),
                    },
                    viewer: Some(next),
                    entity: outer.entity,
                    last: &views.entities,
                    bounce: outer.bounce + 1,
                    max_views: limits.max_views.saturating_sub(views.planned.len() - first),
                };
                sight.see(
                    &viewer,
                    &mirrors,
                    &mut views.planned,
                    &mut views.surfaces,
                    |_, _| {},
                );
            }
            next += 1;
        }
    }
}

/// The camera as the maths wants it.
fn camera_view(
    UserCameraItem {
        camera,
        transform,
        target,
        graph,
        is_deferred,
        ..
    }: &UserCameraItem,
) -> Result<CameraView, NotDrawn> {
    if *is_deferred {
        return Err(NotDrawn::DeferredCamera);
    }
    if graph.is_some_and(|graph| graph.0 != Core3d.intern()) {
        return Err(NotDrawn::OtherRenderGraph);
    }
    if target.is_some_and(|target| matches!(target, RenderTarget::None { .. })) {
        return Err(NotDrawn::NoTarget);
    }
    match (
        camera.physical_viewport_size(),
        camera.physical_target_size(),
    ) {
        (Some(viewport), Some(target))
            if viewport.min_element() > 0 && target.min_element() > 0 =>
        {
            Ok(CameraView {
                world_from_view: transform.affine().as_daffine3(),
                clip_from_view: camera.clip_from_view().as_dmat4(),
                viewport_size: viewport.as_dvec2(),
            })
        }
        _ => Err(NotDrawn::NoTarget),
    }
}
