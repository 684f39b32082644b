//! Main world: from mirrors and cameras to reflected views.
//!
//! A *reflected view* is a camera entity of the plugin's own, one for each camera and each mirror
//! that it sees: the camera's transform reflected about the mirror, its projection, no render
//! target. Bevy does visibility, light clusters, shadow cascades and phases for it as for any
//! camera; the pass in [`render`](crate::render) draws it into the picture of the camera it
//! belongs to.
//!
//! | step in `PostUpdate` | file |
//! |---|---|
//! | fit a plane to each mirror's mesh | `fit.rs` |
//! | decide which camera sees which mirror | `decide.rs` |
//! | bring the entities in line with that | `apply.rs`, `copy.rs` |
//! | after visibility: drop what is behind, choose the projection | `clip.rs` |
//! | leave out shadows that fall on nothing visible | `shadow.rs` |
//! | write [`MirrorStatus`](crate::MirrorStatus) | `report.rs` |
//!
//! Users never meet a reflected view: it carries `Disabled`, which keeps it out of every query
//! that does not name it, except from `apply.rs` to the end of Bevy's light systems in
//! `PostUpdate`, and during extraction.

mod apply;
mod clip;
mod copy;
mod decide;
mod fit;
mod report;
mod shadow;

use bevy::{ecs::prelude::*, platform::collections::HashMap};
use glam::{Mat4, Vec2};

pub use apply::{apply_reflected_views, disable_reflected_views, enable_reflected_views};
pub use clip::clip_reflected_views;
pub use decide::decide_reflected_views;
pub use fit::{MirrorPatches, fit_mirror_planes};
pub use report::report_status;
pub use shadow::{cascade_is_sampled, narrow_cascades};

use crate::{
    math::{Plane, ReflectedViewPlan},
    mirror::MirrorClip,
    status::{NotDrawn, Projection},
};

/// What this frame decided for every pair of a camera and a mirror, and the views that serve them.
#[derive(Resource, Default)]
pub struct ReflectedViews {
    /// Whether there is a renderer to draw them.
    pub can_draw: bool,
    /// How many others Bevy tells what is in `VisibilityRange`.
    pub users_views: usize,
    /// Whether some of ours are not seen by Bevy before it has looked at `VisibilityRange`.
    pub some_wait: bool,
    /// Grouped by mirror.
    pub decisions: Vec<Decision>,
    /// (camera, mirror) -> its reflected view.
    pub entities: HashMap<(Entity, Entity), ViewEntity>,
}

/// The entity of a reflected view.
pub struct ViewEntity {
    pub entity: Entity,
    /// Still wanted in this frame.
    pub wanted: bool,
}

/// What becomes of one mirror as seen by one camera.
pub struct Decision {
    pub camera: Entity,
    pub mirror: Entity,
    pub view: Result<PlannedView, NotDrawn>,
}

/// A reflection to draw.
pub struct PlannedView {
    pub plane: Plane,
    pub plan: ReflectedViewPlan,
    pub clip: MirrorClip,
    /// Filled in once visibility is known.
    pub projection: Projection,
    /// The least and the greatest view depth of anything visible. Filled in with `projection`.
    pub depths: DepthRange,
}

/// View depths (`-z`) from the nearest to the farthest point; `near > far` for nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthRange {
    pub near: f32,
    pub far: f32,
}

impl DepthRange {
    pub const NOTHING: Self = Self {
        near: f32::INFINITY,
        far: f32::NEG_INFINITY,
    };
    pub const EVERYTHING: Self = Self {
        near: f32::NEG_INFINITY,
        far: f32::INFINITY,
    };

    /// Widens to hold these depths too. What is not a number may be anywhere.
    pub fn include(&mut self, near: f32, far: f32) {
        if near.is_nan() || far.is_nan() {
            *self = Self::EVERYTHING;
        } else {
            self.near = self.near.min(near);
            self.far = self.far.max(far);
        }
    }
}

/// On a reflected view: whose it is, and the projection that the GPU shall use.
///
/// `Camera` and `Projection` of the entity stay those of the user's camera, so that clusters,
/// cascades and everything else that reads depth from them is right; only the vertices see the
/// oblique near plane.
#[derive(Component, Clone, Copy, Debug)]
pub struct ReflectedView {
    /// The user's camera into whose picture the view is drawn.
    pub camera: Entity,
    /// The mirror that it is seen in.
    pub mirror: Entity,
    pub clip_from_view: Mat4,
    /// The projection to take instead if other plugins put something into the view of which
    /// nobody knows where it is.
    pub clip_unbounded: Option<Mat4>,
    /// The lowest and the highest device coordinates of what is seen of the mirror.
    pub ndc_bounds: (Vec2, Vec2),
    /// Whether something crosses the mirror's plane, so that it must be cut there.
    pub crossed: bool,
    /// Of everything that is visible in it.
    pub depths: DepthRange,
}

/// Whether there are more views than Bevy tells what is in range.
pub fn some_views_wait(views: Res<ReflectedViews>) -> bool {
    views.some_wait
}

/// Whether there is anything to do, or to undo: a scene without mirrors runs none of the rest.
pub fn any_reflected_views(views: Res<ReflectedViews>) -> bool {
    !views.entities.is_empty() || views.decisions.iter().any(|decision| decision.view.is_ok())
}
