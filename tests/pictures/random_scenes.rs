//! Random scenes against the reference: tilted and scaled mirrors, objects across and behind the plane, fields of view
//! from narrow to wide, head-on, grazing, orthographic, far from the origin; lit or not.

use crate::support::{
    random::{self, Kind},
    studio::Studio,
};

/// One studio draws them all: what a scene leaves behind must not show in the next.
fn assert_all_reflect(kind: Kind, seeds: std::ops::Range<u64>) {
    let mut studio = Studio::default();
    let mut failed = Vec::new();
    for seed in seeds {
        let scene = random::scene(seed, kind);
        let attempt = std::panic::AssertUnwindSafe(|| studio.assert_reflects(&scene));
        if std::panic::catch_unwind(attempt).is_err() {
            failed.push(seed);
            // What failed may have left its stage in any state.
            studio = Studio::default();
        }
    }
    assert!(
        failed.is_empty(),
        "{kind:?} scenes fail with the seeds {failed:?}"
    );
}

#[test]
fn scenes_of_any_kind() {
    assert_all_reflect(Kind::Any, 0..20);
}

#[test]
fn head_on_scenes() {
    assert_all_reflect(Kind::HeadOn, 100..107);
}

#[test]
fn grazing_scenes() {
    assert_all_reflect(Kind::Grazing, 200..206);
}

#[test]
fn orthographic_scenes() {
    assert_all_reflect(Kind::Orthographic, 300..306);
}

#[test]
fn scenes_far_from_the_origin() {
    assert_all_reflect(Kind::FarAway, 400..407);
}
