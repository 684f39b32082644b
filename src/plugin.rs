//! [`PlanarMirrorPlugin`]: every system of the crate in its order.

use bevy::{
    app::prelude::*,
    asset::Assets,
    camera::{CameraUpdateSystems, visibility::VisibilitySystems},
    ecs::prelude::*,
    light::SimulationLightSystems,
    mesh::Mesh,
    render::RenderApp,
    transform::TransformSystems,
};

use crate::{
    mirror::{NoMirrors, PlanarMirror},
    render,
    status::{MirrorFigures, MirrorStatus},
    view::{
        MirrorLimits, ReflectedViews, add_ranged_casters, any_clusters_on_cpu, any_own_cascades,
        any_reflected_views, apply_reflected_views, build_cascades, cluster_reflected_views,
        decide_reflected_views, disable_reflected_views, enable_reflected_views, narrow_cascades,
        place_mirrors, report_figures, report_status, see_reflected_views,
    },
};

/// Adds planar mirrors to an app.
///
/// Add it beside `DefaultPlugins`, in any order. Without a renderer nothing is drawn, but the
/// components work and [`MirrorStatus`] says so.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlanarMirrorPlugin {
    /// How often a ray may be reflected on its way to a camera. Default 1: a mirror that is seen in
    /// a mirror shows its material alone. With 2 it reflects, with 3 also what is seen in that; with
    /// 0 there are no reflections.
    pub max_bounces: u8,
    /// How many reflected views a camera may have, mirrors in mirrors included. Default 255.
    ///
    /// Mirrors in one plane share a view. Of more than that, those that cover most of the screen
    /// are drawn; the others' [`MirrorStatus`] says so.
    pub max_views: usize,
}

impl Default for PlanarMirrorPlugin {
    fn default() -> Self {
        Self {
            max_bounces: 1,
            max_views: 255,
        }
    }
}

/// The steps of the plugin in `PostUpdate`, to order systems against.
#[derive(SystemSet, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MirrorSystems {
    /// Decides which camera sees which mirror, from this frame's transforms and projections, and
    /// brings the reflected views in line with it. After `VisibilitySystems::UpdateFrusta`, before
    /// `VisibilitySystems::CheckVisibility`.
    UpdateViews,
    /// Finds what shows in each mirror, chooses the projections and writes [`MirrorStatus`]. Part of
    /// `VisibilitySystems::CheckVisibility`.
    SeeViews,
    /// Takes the camera's directional shadows for what is seen in a mirror, or leaves out those that
    /// fall on nothing seen, and writes [`MirrorFigures`]. Between
    /// `SimulationLightSystems::UpdateLightFrusta` and `CheckLightVisibility`.
    NarrowShadows,
}

impl Plugin for PlanarMirrorPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<PlanarMirror>()
            .register_type::<NoMirrors>()
            .register_type::<MirrorStatus>()
            .register_type::<MirrorFigures>()
            .init_resource::<MirrorFigures>()
            .init_resource::<ReflectedViews>()
            .insert_resource(MirrorLimits {
                max_bounces: self.max_bounces,
                max_views: if self.max_bounces == 0 {
                    0
                } else {
                    self.max_views
                },
            })
            .configure_sets(
                PostUpdate,
                (
                    MirrorSystems::UpdateViews
                        .after(TransformSystems::Propagate)
                        .after(CameraUpdateSystems)
                        .after(VisibilitySystems::UpdateFrusta)
                        .after(VisibilitySystems::VisibilityPropagate)
                        .after(VisibilitySystems::CalculateBounds)
                        .after(SimulationLightSystems::UpdateDirectionalLightCascades)
                        .before(VisibilitySystems::CheckVisibility),
                    // Lights that only a mirror shows are visible too, and have to be known as such.
                    MirrorSystems::SeeViews.in_set(VisibilitySystems::CheckVisibility),
                    MirrorSystems::NarrowShadows
                        .after(SimulationLightSystems::UpdateLightFrusta)
                        .before(SimulationLightSystems::CheckLightVisibility),
                )
                    .chain(),
            )
            .add_systems(
                PostUpdate,
                (
                    (
                        place_mirrors.run_if(resource_exists::<Assets<Mesh>>),
                        decide_reflected_views,
                        apply_reflected_views.run_if(any_reflected_views),
                        (cluster_reflected_views, build_cascades).run_if(any_reflected_views),
                    )
                        .chain()
                        .in_set(MirrorSystems::UpdateViews),
                    (
                        see_reflected_views.run_if(any_reflected_views),
                        report_status,
                    )
                        .chain()
                        .in_set(MirrorSystems::SeeViews),
                    (narrow_cascades.run_if(any_reflected_views), report_figures)
                        .chain()
                        .in_set(MirrorSystems::NarrowShadows),
                    add_ranged_casters
                        .run_if(any_own_cascades)
                        .after(SimulationLightSystems::CheckLightVisibility)
                        .before(VisibilitySystems::MarkNewlyHiddenEntitiesInvisible),
                    // No longer than needed: in between queries for cameras find the views too.
                    (
                        enable_reflected_views
                            .after(MirrorSystems::SeeViews)
                            .before(SimulationLightSystems::AssignLightsToClusters),
                        disable_reflected_views
                            .after(SimulationLightSystems::AssignLightsToClusters),
                    )
                        .run_if(any_clusters_on_cpu),
                ),
            );
    }

    fn finish(&self, app: &mut App) {
        // Not in `build`: gizmos may come with a plugin that is added later.
        #[cfg(feature = "debug")]
        if app.is_plugin_added::<bevy::gizmos::GizmoPlugin>() {
            crate::debug::add_mirror_gizmos(app);
        }
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render::build_render_app(render_app);
        // Not in `build`: the assets may come with a plugin that is added later.
        render::embed_shaders(app);
        app.world_mut().resource_mut::<ReflectedViews>().can_draw = true;
    }
}
