//! Writes [`MirrorStatus`], and one line in the log for each thing that only the user can mend.

use bevy::{
    camera::{Camera3d, visibility::InheritedVisibility},
    ecs::{entity_disabling::Disabled, prelude::*, query::Allow},
    log::warn,
    platform::collections::HashSet,
};

use super::{Decision, ReflectedViews};
use crate::{
    mirror::PlanarMirror,
    status::{CameraStatus, MirrorFigures, MirrorState, MirrorStatus, NotDrawn, ViewFigures},
};

/// What is no mirror any more.
type Undecided = Or<(Without<PlanarMirror>, Without<InheritedVisibility>)>;

/// Brings every mirror's status in line with what this frame decided; change detection sees only
/// real changes.
pub fn report_status(
    views: Res<ReflectedViews>,
    mut statuses: Query<&mut MirrorStatus, (With<PlanarMirror>, With<InheritedVisibility>)>,
    mut undecided: Query<&mut MirrorStatus, Undecided>,
    known: Query<(), (Or<(With<PlanarMirror>, With<Camera3d>)>, Allow<Disabled>)>,
    mut warned: Local<HashSet<(Option<Entity>, NotDrawn)>>,
) {
    // What is gone is never warned of again, so it need not be remembered.
    warned.retain(|(whom, _)| whom.is_none_or(|entity| known.contains(entity)));
    let clear = |mut status: Mut<MirrorStatus>| {
        if !status.cameras.is_empty() {
            status.cameras.clear();
        }
    };
    undecided.iter_mut().for_each(clear);
    if views.decisions.is_empty() {
        statuses.iter_mut().for_each(clear);
    }
    for mirror in views.decisions.chunk_by(|a, b| a.mirror == b.mirror) {
        let entity = mirror[0].mirror;
        let Ok(mut status) = statuses.get_mut(entity) else {
            continue;
        };
        if status
            .cameras
            .iter()
            .copied()
            .eq(mirror.iter().map(|decision| status_of(&views, decision)))
        {
            continue;
        }
        status.cameras.clear();
        status
            .cameras
            .extend(mirror.iter().map(|decision| status_of(&views, decision)));
        for CameraStatus { camera, state } in &status.cameras {
            if let MirrorState::NotDrawn(reason) = *state
                && let Some(remedy) = remedy(reason)
            {
                let (what, whom) = match concerns(reason) {
                    Concerns::Mirror => ("mirror is not drawn", Some(entity)),
                    Concerns::Camera => ("camera shows no mirrors", Some(*camera)),
                    Concerns::All => ("mirrors are not drawn", None),
                };
                if warned.insert((whom, reason)) {
                    let whom = whom.map(|entity| format!("{entity}: ")).unwrap_or_default();
                    warn!("{whom}{what}: {reason}. {remedy}");
                }
            }
        }
    }
}

/// Lists what is drawn.
pub fn report_figures(views: Res<ReflectedViews>, mut figures: ResMut<MirrorFigures>) {
    if views.planned.is_empty() && figures.views.is_empty() {
        return;
    }
    let drawn = |view: Option<Entity>| views.alive.get(&view?)?.drawn;
    figures.views.clear();
    figures.views.extend(
        views
            .planned
            .iter()
            .filter(|planned| planned.entity.is_some())
            .map(|planned| ViewFigures {
                camera: planned.camera,
                mirror: views.surfaces[planned.mirrors.start],
                mirrors: planned.mirrors.len(),
                bounces: planned.bounce,
                pixels: planned.pixels as f32,
                objects: planned.objects,
                projection: planned.projection,
                shadows: planned.shadows,
                cascades: planned.cascades.len(),
                drawn: drawn(planned.entity),
            }),
    );
}

fn status_of(views: &ReflectedViews, decision: &Decision) -> CameraStatus {
    CameraStatus {
        camera: decision.camera,
        state: match decision.view {
            Ok(view) => MirrorState::Drawn(views.planned[view].projection),
            Err(reason) => MirrorState::NotDrawn(reason),
        },
    }
}

/// Where a reason lies, and so what is named by its one line in the log.
enum Concerns {
    Mirror,
    Camera,
    All,
}

fn concerns(reason: NotDrawn) -> Concerns {
    match reason {
        NotDrawn::NoRenderer | NotDrawn::TooManyMirrors => Concerns::All,
        NotDrawn::DegenerateCamera | NotDrawn::DeferredCamera | NotDrawn::OtherRenderGraph => {
            Concerns::Camera
        }
        _ => Concerns::Mirror,
    }
}

/// What a user can do about it, where it is not simply where the camera stands.
fn remedy(reason: NotDrawn) -> Option<&'static str> {
    Some(match reason {
        NotDrawn::NoRenderer => "Add RenderPlugin, which is one of DefaultPlugins.",
        NotDrawn::MeshNotInMainWorld => {
            "Keep it with RenderAssetUsages::MAIN_WORLD, or give the plane with MirrorPlane::Local."
        }
        NotDrawn::MeshEmpty => "Give it triangles.",
        NotDrawn::MeshNotFlat => {
            "Split it into flat meshes, or give the plane with MirrorPlane::Local."
        }
        NotDrawn::MeshNotReadable => {
            "Use a triangle list or strip with finite Float32x3 positions and valid indices."
        }
        NotDrawn::MeshDeforms => "Use a mesh that moves with its Transform alone.",
        NotDrawn::DegenerateTransform => {
            "Its transform, or the normal of MirrorPlane::Local, must be finite and not zero."
        }
        NotDrawn::DegenerateCamera => {
            "The camera's transform and projection must be finite and invertible."
        }
        NotDrawn::DeferredCamera => {
            "Use forward rendering for this camera, or put NoMirrors on it."
        }
        NotDrawn::OtherRenderGraph => {
            "Use the Core3d render graph for this camera, or put NoMirrors on it."
        }
        NotDrawn::TooManyMirrors => {
            "The largest are drawn; PlanarMirrorPlugin::max_views says how many."
        }
        _ => return None,
    })
}
