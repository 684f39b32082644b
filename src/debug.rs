//! What the plugin sees, drawn as gizmos.

use bevy::{
    app::prelude::*,
    color::palettes::css,
    ecs::prelude::*,
    gizmos::{AppGizmoBuilder, config::GizmoConfigGroup, gizmos::Gizmos},
    reflect::prelude::*,
};
use glam::{DVec3, Vec3};

use crate::{
    math::BaseProjection,
    plugin::MirrorSystems,
    view::{PlannedView, ReflectedViews},
};

/// Of each reflected view the visible polygon of the mirror, its normal, and the frustum behind the
/// polygon as far as anything is seen in it.
///
/// Needs the feature `debug` and Bevy's gizmos. To switch it off while the app runs, see
/// `GizmoConfigStore`.
#[derive(Default, Reflect, GizmoConfigGroup)]
#[reflect(Default)]
pub struct MirrorGizmos;

/// Draws [`MirrorGizmos`].
pub fn add_mirror_gizmos(app: &mut App) {
    app.init_gizmo_group::<MirrorGizmos>()
        .add_systems(PostUpdate, draw_gizmos.after(MirrorSystems::SeeViews));
}

fn draw_gizmos(views: Res<ReflectedViews>, mut gizmos: Gizmos<MirrorGizmos>) {
    for planned in &views.planned {
        let Some(rays) = seen_rays(planned) else {
            continue;
        };
        let surface = || rays.iter().map(|[near, _]| *near);
        gizmos.lineloop(surface(), css::AQUA);
        let center = surface().sum::<Vec3>() / rays.len() as f32;
        let normal = planned.plane.normal.as_vec3();
        let length = surface()
            .map(|corner| corner.distance(center))
            .fold(0.0, f32::max);
        gizmos.arrow(center, center + normal * (0.5 * length), css::AQUA);
        for [near, far] in &rays {
            gizmos.line(*near, *far, css::ORANGE);
        }
        gizmos.lineloop(rays.iter().map(|[_, far]| *far), css::ORANGE);
    }
}

/// For each corner of the visible polygon, where the mirror is and how far one sees behind it.
fn seen_rays(planned: &PlannedView) -> Option<Vec<[Vec3; 2]>> {
    let plan = &planned.plan;
    let projection = BaseProjection::new(&plan.clip_from_view_oblique)?;
    // The mirror's plane is the near plane of this projection, depth 1.
    let rays = plan.polygon.ndc().map(|ndc| {
        let near = projection.view_from_clip.project_point3(ndc.extend(1.0));
        let ray = if projection.is_orthographic {
            DVec3::NEG_Z
        } else {
            near / -near.z
        };
        let far = f64::from(planned.depths.far);
        let far = if far.is_finite() { far } else { -2.0 * near.z };
        let world = |view: DVec3| plan.world_from_view.transform_point3(view).as_vec3();
        [world(near), world(near + ray * (far + near.z).max(0.0))]
    });
    let rays: Vec<_> = rays.collect();
    (!rays.is_empty() && rays.iter().flatten().all(|point| point.is_finite())).then_some(rays)
}
