//! Main world: from mirrors and cameras to reflected views.
//!
//! A *reflected view* is a camera entity of the plugin's own, one for each camera and each plane of
//! mirrors that it sees: the camera's transform reflected about the plane, its projection, no
//! render target. Bevy does visibility, light clusters, shadow cascades and phases for it as for
//! any camera; the pass in [`render`](crate::render) draws it into the picture of the camera it
//! belongs to. What sees a mirror may itself be a reflected view: a mirror in a mirror.
//!
//! | step in `PostUpdate` | file |
//! |---|---|
//! | fit a plane to each mirror's mesh, and carry it into the world | `fit.rs` |
//! | decide which camera sees which mirror | `decide.rs`, `sight.rs` |
//! | what walls leave of them to be seen | `cover.rs` |
//! | bring the entities in line with that | `apply.rs`, `copy.rs` |
//! | which lamps reach what is seen | `clusters.rs` |
//! | shadow cascades, as Bevy would build them | `cascade.rs` |
//! | find what is visible, drop what is behind, choose the projection | `visible.rs`, `clip.rs` |
//! | take the camera's shadow maps, or leave out what falls on nothing visible | `shadow.rs`, `lookup.rs` |
//! | write [`MirrorStatus`](crate::MirrorStatus) | `report.rs` |
//!
//! Users never meet a reflected view: it carries `Disabled`, which keeps it out of every query
//! that does not name it. It is taken off only during extraction. What Bevy's systems do for cameras
//! in `PostUpdate` the plugin does for its views; only where light clusters are filled on the CPU
//! must Bevy see them for that.

mod apply;
mod bounds;
mod cascade;
mod clip;
mod clusters;
mod copy;
mod cover;
mod decide;
mod fit;
mod lookup;
mod report;
mod shadow;
mod sight;
mod visible;

use core::ops::Range;

use bevy::{
    camera::primitives::Frustum,
    ecs::{entity::EntityHashMap, prelude::*},
    light::cluster::GlobalClusterSettings,
    platform::collections::HashMap,
};
use glam::{DVec2, Mat4};

pub use apply::{apply_reflected_views, disable_reflected_views, enable_reflected_views};
pub use cascade::build_cascades;
pub use clusters::{Lamp, cluster_reflected_views};
pub use decide::decide_reflected_views;
pub use fit::{MirrorPlace, place_mirrors};
pub use report::{report_figures, report_status};
pub use shadow::{SeenCascade, add_ranged_casters, any_own_cascades, narrow_cascades};
pub use visible::see_reflected_views;

use self::copy::CleanArchetypes;
use crate::{
    math::{Plane, ReflectedViewPlan},
    mirror::{MirrorClip, MirrorShadows},
    status::{DrawnFigures, NotDrawn, Projection},
};

/// How much the plugin may do.
#[derive(Resource, Clone, Copy, Debug)]
pub struct MirrorLimits {
    /// See [`PlanarMirrorPlugin`](crate::PlanarMirrorPlugin).
    pub max_bounces: u8,
    /// See [`PlanarMirrorPlugin`](crate::PlanarMirrorPlugin).
    pub max_views: usize,
}

/// What this frame decided for every pair of a camera and a mirror, and the views that serve them.
#[derive(Resource, Default)]
pub struct ReflectedViews {
    /// Whether there is a renderer to draw them.
    pub can_draw: bool,
    /// Grouped by mirror.
    pub decisions: Vec<Decision>,
    /// Grouped by camera; a mirror comes before what is seen in it.
    pub planned: Vec<PlannedView>,
    /// The mirrors of all planned views.
    pub surfaces: Vec<Entity>,
    /// The shadow cascades of their own that all planned views read.
    pub cascades: Vec<SeenCascade>,
    /// The lamps that may reach what is seen in the views that list them.
    pub lamps: Vec<Lamp>,
    /// (what sees it, mirror) -> its reflected view, which it may share with others.
    pub entities: HashMap<(Entity, Entity), Entity>,
    /// All entities of reflected views.
    pub alive: EntityHashMap<LiveView>,
    pub clean: CleanArchetypes,
}

/// What is remembered of a reflected view from one frame to the next.
#[derive(Default)]
pub struct LiveView {
    /// Whether this frame wants it.
    pub is_wanted: bool,
    /// Whether something crossed the mirror's plane, so that it had to be cut there.
    pub was_cut: bool,
    /// Whether it showed items of other plugins, of which nobody knows where they are.
    pub has_foreign_items: bool,
    /// What the renderer said last.
    pub drawn: Option<DrawnFigures>,
}

/// What becomes of one mirror as seen by one camera.
pub struct Decision {
    pub camera: Entity,
    pub mirror: Entity,
    /// Which of [`ReflectedViews::planned`] shows it.
    pub view: Result<usize, NotDrawn>,
}

/// A reflection to draw.
pub struct PlannedView {
    /// The user's camera into whose picture it goes.
    pub camera: Entity,
    /// The planned view that sees the mirror, if not the camera itself does.
    pub viewer: Option<usize>,
    /// How many reflections it is away from the camera: 1 if the camera sees the mirror.
    pub bounce: u8,
    /// Which of [`ReflectedViews::surfaces`] are the mirror: several if they lie in one plane. Sorted.
    pub mirrors: Range<usize>,
    pub plane: Plane,
    pub plan: ReflectedViewPlan,
    /// The lowest and the highest device coordinates of what is seen of the mirrors.
    pub ndc_bounds: (DVec2, DVec2),
    pub clip: MirrorClip,
    /// Not `Auto` once `cascades` is filled in.
    pub shadows: MirrorShadows,
    /// Its entity. Until the entities are brought in line that of the last frame, if there was one;
    /// then `None` if it could not be made.
    pub entity: Option<Entity>,
    /// That of what sees the mirrors, reflected, without a near plane. Filled in with the entity.
    pub loose_frustum: Option<Frustum>,
    /// Filled in once visibility is known.
    pub projection: Projection,
    /// The projection that the GPU shall use. Filled in with `projection`.
    ///
    /// `Camera` and `Projection` of the entity stay those of the user's camera, so that clusters,
    /// cascades and everything else that reads depth from them is right; only the vertices see the
    /// oblique near plane.
    pub clip_from_view: Mat4,
    /// The least and the greatest view depth of anything visible. Filled in with `projection`.
    pub depths: DepthRange,
    /// Which of [`ReflectedViews::cascades`] are its own. Filled in after `depths`.
    pub cascades: Range<usize>,
    /// Which of [`ReflectedViews::lamps`] are in its only cluster; `None` if it has clusters that
    /// the engine fills. Filled in once its entity is there.
    pub lamps: Option<Range<usize>>,
    /// What is seen of the mirrors, in pixels.
    pub pixels: f64,
    /// How many objects are visible. Filled in with `projection`.
    pub objects: usize,
    /// Whether the GPU may cull by the view's frustum. Filled in with `projection`.
    pub culls_on_gpu: bool,
}

impl PlannedView {
    /// The projection to take instead if other plugins put something into the view of which
    /// nobody knows where it is.
    pub fn clip_unbounded(&self) -> Option<Mat4> {
        (self.clip == MirrorClip::Auto).then(|| self.plan.clip_from_view_oblique.as_mat4())
    }
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

/// Marks the entity of a reflected view.
#[derive(Component, Clone, Copy, Debug)]
pub struct ReflectedView;

/// Whether Bevy fills the light clusters of some view, which it does on the CPU alone.
pub fn any_clusters_on_cpu(
    views: Res<ReflectedViews>,
    settings: Option<Res<GlobalClusterSettings>>,
) -> bool {
    !views.planned.is_empty() && settings.is_some_and(|settings| settings.gpu_clustering.is_none())
}

/// Whether there is anything to do, or to undo: a scene without mirrors runs none of the rest.
pub fn any_reflected_views(views: Res<ReflectedViews>) -> bool {
    !views.alive.is_empty() || !views.planned.is_empty()
}
