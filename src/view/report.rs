//! Writes [`MirrorStatus`], and one line in the log for each thing that only the user can mend.

use bevy::{ecs::prelude::*, log::warn, platform::collections::HashSet};

use super::{Decision, ReflectedViews};
use crate::status::{CameraStatus, MirrorState, MirrorStatus, NotDrawn};

/// Brings every mirror's status in line with what this frame decided; change detection sees only
/// real changes.
pub fn report_status(
    views: Res<ReflectedViews>,
    mut statuses: Query<&mut MirrorStatus>,
    mut warned: Local<HashSet<(Option<Entity>, NotDrawn)>>,
) {
    for mirror in views.decisions.chunk_by(|a, b| a.mirror == b.mirror) {
        let entity = mirror[0].mirror;
        let Ok(mut status) = statuses.get_mut(entity) else {
            continue;
        };
        if status
            .cameras
            .iter()
            .copied()
            .eq(mirror.iter().map(status_of))
        {
            continue;
        }
        status.cameras.clear();
        status.cameras.extend(mirror.iter().map(status_of));
        for CameraStatus { state, .. } in &status.cameras {
            if let MirrorState::NotDrawn(reason) = *state
                && let Some(remedy) = remedy(reason)
                && warned.insert((concerns_one(reason).then_some(entity), reason))
            {
                warn!("mirror {entity} is not drawn: {reason}. {remedy}");
            }
        }
    }
}

fn status_of(decision: &Decision) -> CameraStatus {
    CameraStatus {
        camera: decision.camera,
        state: match &decision.view {
            Ok(view) => MirrorState::Drawn(view.projection),
            Err(reason) => MirrorState::NotDrawn(*reason),
        },
    }
}

/// Whether the reason lies with one mirror; otherwise one line serves for all.
fn concerns_one(reason: NotDrawn) -> bool {
    !matches!(reason, NotDrawn::NoRenderer | NotDrawn::TooManyMirrors)
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
        NotDrawn::DegenerateTransform => {
            "Its transform, or the normal of MirrorPlane::Local, must be finite and not zero."
        }
        NotDrawn::DegenerateCamera => {
            "The camera's transform and projection must be finite and invertible."
        }
        NotDrawn::DeferredCamera => {
            "Use forward rendering for this camera, or put NoMirrors on it."
        }
        NotDrawn::TooManyMirrors => "The nearest 255 are drawn.",
        _ => return None,
    })
}
