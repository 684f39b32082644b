//! After visibility: what lies behind the mirror is dropped, and the projection chosen.

use core::any::TypeId;

use bevy::{
    camera::{
        Camera,
        visibility::{NoCpuCulling, VisibleEntities},
    },
    ecs::prelude::*,
    light::cluster::ClusterVisibilityClass,
    pbr::decal::ForwardDecal,
};
use glam::{DMat4, DVec4};

use super::{
    DepthRange, PlannedView, ReflectedView, ReflectedViews,
    bounds::{Bounds, WorldBox},
};
use crate::{
    math::{Side, classify, edge_sides, signed_distance_range},
    mirror::MirrorClip,
    status::Projection,
};

/// Takes out of each reflected view the mirror itself and whatever shows no part in front of the
/// plane, and cuts at the plane only if something crosses it.
pub fn clip_reflected_views(
    mut views: ResMut<ReflectedViews>,
    mut reflected: Query<(&mut VisibleEntities, &Camera), With<ReflectedView>>,
    objects: Query<Bounds>,
    // What the GPU alone culls is in no list here, and may be anywhere.
    uncounted: Query<(), With<NoCpuCulling>>,
    // They are laid on what a depth prepass has drawn, and a reflected view has none.
    decals: Query<(), With<ForwardDecal>>,
    mut sides: Local<Vec<DVec4>>,
) {
    let ReflectedViews {
        planned,
        surfaces,
        alive,
        ..
    } = &mut *views;
    for planned in planned {
        let Some(view) = planned.entity else {
            continue;
        };
        let (Some(live), Ok((mut visible, camera))) =
            (alive.get_mut(&view), reflected.get_mut(view))
        else {
            continue;
        };
        let mirrors = &surfaces[planned.mirrors.clone()];
        let clip_from_view = camera.clip_from_view();
        let clip_matrix = clip_from_view.as_dmat4();
        let view_from_world = DMat4::from(planned.plan.world_from_view.inverse());
        let rows = DepthRows {
            clip_w: (clip_matrix * view_from_world).row(3),
            view_depth: -view_from_world.row(2),
        };
        sides.clear();
        // Several mirrors have no common polygon but their bounds, which have culled already.
        if mirrors.len() == 1 {
            let viewport = camera.physical_viewport_size().unwrap_or_default();
            let edges = edge_sides(&planned.plan.polygon, &clip_matrix, viewport.as_dvec2());
            // Planes are covectors: from view to world space by the matrix from world to view.
            sides.extend(edges.map(|side| view_from_world.transpose() * side));
        }
        let mut seen = Seen {
            was_cut: live.was_cut,
            crossed: !uncounted.is_empty(),
            depths: if uncounted.is_empty() {
                DepthRange::NOTHING
            } else {
                DepthRange::EVERYTHING
            },
        };
        let mut objects_in_view = 0;
        for (class, visible) in &mut visible.entities {
            // Lights and decals reach farther than their bounds.
            if *class == TypeId::of::<ClusterVisibilityClass>() {
                continue;
            }
            visible.retain(|&entity| match objects.get(entity) {
                _ if mirrors.binary_search(&entity).is_ok() || decals.contains(entity) => false,
                Ok(bounds) => seen.shows(WorldBox::of(bounds), planned, &rows, &sides),
                Err(_) => true,
            });
            objects_in_view += visible.len();
        }
        planned.projection = match planned.clip {
            MirrorClip::Auto if !seen.crossed => Projection::Plain,
            MirrorClip::Auto | MirrorClip::Oblique => Projection::Oblique,
            MirrorClip::Whole => Projection::Plain,
        };
        planned.clip_from_view = match planned.projection {
            Projection::Plain => clip_from_view,
            Projection::Oblique => planned.plan.clip_from_view_oblique.as_mat4(),
        };
        live.was_cut = seen.crossed;
        planned.depths = seen.depths;
        planned.objects = objects_in_view;
    }
}

/// Covectors that give the depth of a point in the world, in two measures.
struct DepthRows {
    /// Clip `w`.
    clip_w: DVec4,
    /// `-z` in view space.
    view_depth: DVec4,
}

/// What is known of all that a reflected view shows.
struct Seen {
    /// In the last frame, when something crossed the plane.
    was_cut: bool,
    crossed: bool,
    depths: DepthRange,
}

impl Seen {
    /// Whether an object shows in the mirror, and what follows for the view.
    ///
    /// An object without bounds may be anywhere.
    fn shows(
        &mut self,
        bounds: Option<WorldBox>,
        planned: &PlannedView,
        rows: &DepthRows,
        sides: &[DVec4],
    ) -> bool {
        let Some(bounds) = bounds else {
            self.crossed = true;
            self.depths = DepthRange::EVERYTHING;
            return true;
        };
        if sides.iter().any(|side| bounds.range(*side).1 < 0.0) {
            return false;
        }
        // The tolerance grows with depth, so the nearest point of the box is the strictest.
        let (nearest, _) = bounds.range(rows.clip_w);
        let side = classify(
            signed_distance_range(&planned.plane, bounds.center, bounds.half_axes),
            planned.plan.ghost_tolerance(nearest, self.was_cut),
        );
        if side == Side::Behind {
            return false;
        }
        self.crossed |= side == Side::Straddling;
        let (near, far) = bounds.range(rows.view_depth);
        self.depths.include(near as f32, far as f32);
        true
    }
}
