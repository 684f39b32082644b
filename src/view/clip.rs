//! After visibility: what lies behind the mirror is dropped, and the projection chosen.

use core::any::TypeId;

use bevy::{
    camera::{
        Camera,
        primitives::Aabb,
        visibility::{NoCpuCulling, NoFrustumCulling, VisibleEntities},
    },
    ecs::prelude::*,
    mesh::Mesh3d,
    transform::components::GlobalTransform,
};
use glam::{DMat4, DVec3, DVec4};

use super::{PlannedView, ReflectedView, ReflectedViews};
use crate::{
    math::{Side, classify, signed_distance_range},
    mirror::MirrorClip,
    status::Projection,
};

type Bounds<'a> = (&'a GlobalTransform, Option<&'a Aabb>, Has<NoFrustumCulling>);

/// Takes out of each reflected view the mirror itself and whatever shows no part in front of the
/// plane, and cuts at the plane only if something crosses it.
pub fn clip_reflected_views(
    mut views: ResMut<ReflectedViews>,
    mut reflected: Query<(&mut ReflectedView, &mut VisibleEntities, &Camera)>,
    objects: Query<Bounds>,
    // What the GPU alone culls is in no list here, and may be anywhere.
    uncounted: Query<(), With<NoCpuCulling>>,
) {
    let ReflectedViews {
        decisions,
        entities,
        ..
    } = &mut *views;
    for decision in decisions {
        let Ok(planned) = &mut decision.view else {
            continue;
        };
        let Some(view) = entities.get(&(decision.camera, decision.mirror)) else {
            continue;
        };
        let Ok((mut reflected, mut visible, camera)) = reflected.get_mut(view.entity) else {
            continue;
        };
        let clip_from_view = camera.clip_from_view();
        let depth = depth_from_world(planned, &clip_from_view.as_dmat4());
        let mut crossed = !uncounted.is_empty();
        visible
            .get_mut(TypeId::of::<Mesh3d>())
            .retain(|&entity| match objects.get(entity) {
                _ if entity == decision.mirror => false,
                Ok(bounds) => {
                    let side = side_of(bounds, planned, depth);
                    crossed |= side == Side::Straddling;
                    side != Side::Behind
                }
                Err(_) => true,
            });
        planned.projection = match planned.clip {
            MirrorClip::Auto if !crossed => Projection::Plain,
            MirrorClip::Auto | MirrorClip::Oblique => Projection::Oblique,
            MirrorClip::Whole => Projection::Plain,
        };
        reflected.clip_from_view = match planned.projection {
            Projection::Plain => clip_from_view,
            Projection::Oblique => planned.plan.clip_from_view_oblique.as_mat4(),
        };
    }
}

/// The covector that gives the view depth (clip `w`) of a point in the world.
fn depth_from_world(planned: &PlannedView, clip_from_view: &DMat4) -> DVec4 {
    let view_from_world = DMat4::from(planned.plan.world_from_view.inverse());
    (*clip_from_view * view_from_world).row(3)
}

/// On which side of the mirror an object lies. An object without bounds may be on both.
fn side_of(
    (transform, aabb, unbounded): (&GlobalTransform, Option<&Aabb>, bool),
    planned: &PlannedView,
    depth: DVec4,
) -> Side {
    let (Some(aabb), false) = (aabb, unbounded) else {
        return Side::Straddling;
    };
    let world_from_local = transform.affine().as_daffine3();
    let center = world_from_local.transform_point3(DVec3::from(aabb.center.as_dvec3()));
    let half = DVec3::from(aabb.half_extents.as_dvec3());
    let axes = world_from_local.matrix3;
    let half_axes = [
        axes.x_axis * half.x,
        axes.y_axis * half.y,
        axes.z_axis * half.z,
    ];
    // The tolerance grows with depth, so the nearest point of the box is the strictest.
    let reach: f64 = half_axes
        .iter()
        .map(|axis| depth.truncate().dot(*axis).abs())
        .sum();
    let nearest = (depth.dot(center.extend(1.0)) - reach).max(0.0);
    classify(
        signed_distance_range(&planned.plane, center, half_axes),
        planned.plan.ghost_tolerance(nearest),
    )
}
