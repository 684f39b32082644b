//! Every reason why a mirror is not drawn, reached once.

mod degenerate;
mod mesh;
mod sight;

use std::collections::HashSet;

use bevy::prelude::*;
use bevy_planar_mirror::{MirrorState, NotDrawn, status};

use super::app::{EYE, MirrorApp, PLAIN, mirror_app, not};

/// A mirror and a camera, and another mirror that must not care.
fn pair() -> (MirrorApp, Entity, Entity) {
    let mut app = mirror_app();
    let other = app.spawn_mirror(Transform::from_xyz(0.5, 0.5, 0.1));
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.update();
    app.assert_state(mirror, camera, PLAIN);
    app.assert_state(other, camera, PLAIN);
    (app, mirror, camera)
}

/// The mirror alone is not drawn, for this reason.
#[track_caller]
fn assert_only(app: &mut MirrorApp, mirror: Entity, camera: Entity, reason: NotDrawn) {
    app.update();
    app.assert_state(mirror, camera, not(reason));
    assert_eq!(app.views_of(camera).len(), 1, "the other mirror is drawn");
    app.updates(2);
    app.assert_state(mirror, camera, not(reason));
}

/// The camera alone sees no mirrors, for this reason.
#[track_caller]
fn assert_blind(app: &mut MirrorApp, mirror: Entity, camera: Entity, reason: NotDrawn) {
    let other = app.spawn_camera(EYE);
    app.updates(2);
    app.assert_state(mirror, camera, not(reason));
    assert!(app.views_of(camera).is_empty());
    app.assert_state(mirror, other, PLAIN);
    assert_eq!(app.views_of(other).len(), 2, "the other camera sees both");
}

const ALL: [NotDrawn; 18] = [
    NotDrawn::NoRenderer,
    NotDrawn::Hidden,
    NotDrawn::OtherLayers,
    NotDrawn::NoMesh,
    NotDrawn::MeshNotInMainWorld,
    NotDrawn::MeshEmpty,
    NotDrawn::MeshNotFlat,
    NotDrawn::MeshNotReadable,
    NotDrawn::DegenerateTransform,
    NotDrawn::DegenerateCamera,
    NotDrawn::NoTarget,
    NotDrawn::DeferredCamera,
    NotDrawn::EyeBehind,
    NotDrawn::OutOfView,
    NotDrawn::Occluded,
    NotDrawn::TooThin,
    NotDrawn::BelowPrecision,
    NotDrawn::TooManyMirrors,
];

#[test]
fn every_state_reads_differently() {
    let drawn = [status::Projection::Plain, status::Projection::Oblique].map(MirrorState::Drawn);
    let states = ALL.map(MirrorState::NotDrawn).into_iter().chain(drawn);
    let texts: Vec<String> = states.map(|state| state.to_string()).collect();
    assert!(texts.iter().all(|text| text.len() > 4), "{texts:?}");
    let distinct: HashSet<_> = texts.iter().collect();
    assert_eq!(distinct.len(), ALL.len() + 2, "{texts:?}");
    for reason in ALL {
        let text = MirrorState::NotDrawn(reason).to_string();
        assert_eq!(text, format!("not drawn: {reason}"));
    }
}
