//! On which side of the mirror what a reflected view shows lies, and by which projection it is
//! drawn therefore.

use bevy::camera::Camera;
use glam::{DMat4, DVec4};

use super::{DepthRange, LiveView, PlannedView, bounds::WorldBox};
use crate::{
    math::{Plane, ReflectedViewPlan, Side, classify, edge_sides, signed_distance_range},
    mirror::MirrorClip,
    status::Projection,
};

/// What is cut off of all that a view would see.
pub struct Cut<'a> {
    plane: Plane,
    plan: ReflectedViewPlan,
    /// Whether something crossed the plane in the last frame.
    was_cut: bool,
    /// Covectors that give the depth of a point in the world: clip `w`, and `-z` in view space.
    clip_w: DVec4,
    view_depth: DVec4,
    /// Half-spaces of the world through the edges of what is seen of the mirror.
    sides: &'a [DVec4],
}

impl<'a> Cut<'a> {
    /// For a view of so many mirrors. The memory of `sides` is used again.
    pub fn new(
        planned: &PlannedView,
        mirrors: usize,
        camera: &Camera,
        was_cut: bool,
        sides: &'a mut Vec<DVec4>,
    ) -> Self {
        let clip_from_view = camera.clip_from_view().as_dmat4();
        let view_from_world = DMat4::from(planned.plan.world_from_view.inverse());
        sides.clear();
        // Several mirrors have no common polygon but their bounds, which the frustum has.
        if mirrors == 1 {
            let viewport = camera.physical_viewport_size().unwrap_or_default();
            let edges = edge_sides(&planned.plan.polygon, &clip_from_view, viewport.as_dvec2());
            // Planes are covectors: from view to world space by the matrix from world to view.
            sides.extend(edges.map(|side| view_from_world.transpose() * side));
        }
        Self {
            plane: planned.plane,
            plan: planned.plan,
            was_cut,
            clip_w: (clip_from_view * view_from_world).row(3),
            view_depth: -view_from_world.row(2),
            sides,
        }
    }

    /// Whether an object shows in the mirror, and what follows for the view.
    ///
    /// An object without bounds may be anywhere: it counts as crossing.
    pub fn shows(&self, bounds: Option<WorldBox>, seen: &mut Seen) -> bool {
        let Some(bounds) = bounds else {
            seen.any_unbounded = true;
            seen.crossed = true;
            seen.depths = DepthRange::EVERYTHING;
            return true;
        };
        if self.sides.iter().any(|side| bounds.range(*side).1 < 0.0) {
            return false;
        }
        // The tolerance grows with depth, so the nearest point of the box is the strictest.
        let (nearest, _) = bounds.range(self.clip_w);
        let side = classify(
            signed_distance_range(&self.plane, bounds.center, bounds.half_axes),
            self.plan.ghost_tolerance(nearest, self.was_cut),
        );
        if side == Side::Behind {
            return false;
        }
        seen.crossed |= side == Side::Straddling;
        let (near, far) = bounds.range(self.view_depth);
        seen.depths.include(near as f32, far as f32);
        true
    }
}

/// What is known of all that a reflected view shows.
pub struct Seen {
    pub crossed: bool,
    pub any_unbounded: bool,
    pub depths: DepthRange,
}

impl Default for Seen {
    fn default() -> Self {
        Self {
            crossed: false,
            any_unbounded: false,
            depths: DepthRange::NOTHING,
        }
    }
}

impl Seen {
    /// Takes in what another thread has seen.
    pub fn add(&mut self, other: &Self) {
        self.crossed |= other.crossed;
        self.any_unbounded |= other.any_unbounded;
        self.depths.include(other.depths.near, other.depths.far);
    }

    /// The view is cut at the plane only if something crosses it, or might.
    pub fn choose_projection(
        &self,
        planned: &mut PlannedView,
        live: &mut LiveView,
        camera: &Camera,
    ) {
        planned.projection = match planned.clip {
            MirrorClip::Auto if !self.crossed && !live.has_foreign_items => Projection::Plain,
            MirrorClip::Auto | MirrorClip::Oblique => Projection::Oblique,
            MirrorClip::Whole => Projection::Plain,
        };
        planned.clip_from_view = match planned.projection {
            Projection::Plain => camera.clip_from_view(),
            Projection::Oblique => planned.plan.clip_from_view_oblique.as_mat4(),
        };
        live.was_cut = self.crossed;
        planned.depths = self.depths;
    }
}
