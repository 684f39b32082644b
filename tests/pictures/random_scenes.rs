//! Random scenes against the reference: tilted and scaled mirrors, objects across and behind the plane, fields of view
//! from narrow to wide, head-on, grazing, orthographic, far from the origin; lit or not. And the same at the extremes,
//! where every number is spread evenly in its logarithm: those on which the maths are tried.
//!
//! `PLANAR_MIRROR_STABILITY=full cargo test --test pictures random_scenes -- --nocapture` draws five hundred of each.

use std::{
    ops::Range,
    panic::{AssertUnwindSafe, catch_unwind},
};

use crate::support::{
    count::count,
    extremes,
    picture::Difference,
    random::{self, Kind},
    scene::Scene,
    studio::{SHARE, SHARE_FAR_AWAY, Studio},
    wild,
};

/// Scenes of each kind where all are asked for.
const FULL: u64 = 100;

/// Pixels that one mirror may show otherwise, however few it has. Where a mesh is cut, the reference is shaded a little
/// otherwise: a corner's normal is made unit anew.
const ODD: usize = 1;
/// So far away rounding moves edges by up to a twentieth of a pixel, and a mirror shows some three hundred pixels of them.
const ODD_FAR_AWAY: usize = 16;

/// One studio draws all scenes of a kind: what a scene leaves behind must not show in the next. Of the pixels of all
/// mirrors together at least `share` must be right.
fn assert_all_reflect(kind: Kind, seeds: Range<u64>, odd: usize, share: f64) {
    let scene = |seed| random::scene(seed, kind);
    assert_all(
        scene,
        &format!("random::scene({{}}, Kind::{kind:?})"),
        seeds,
        odd,
        share,
    );
}

/// The same of scenes at the extremes.
fn assert_extremes_reflect(kind: extremes::Kind, seeds: Range<u64>, odd: usize, share: f64) {
    let scene = |seed| wild::scene(kind, seed);
    assert_all(
        scene,
        &format!("wild::scene(Kind::{kind:?}, {{}})"),
        seeds,
        odd,
        share,
    );
}

/// `again` is how to call for a scene again.
fn assert_all(
    scene: impl Fn(u64) -> Scene,
    again: &str,
    seeds: Range<u64>,
    odd: usize,
    share: f64,
) {
    let seeds = seeds.start..seeds.start + count(seeds.end - seeds.start, FULL);
    let mut studio = Studio::default();
    let (mut compared, mut beyond, mut blank) = (0, 0, 0);
    let mut worst: Option<(u64, Difference)> = None;
    let mut failed = Vec::new();
    for seed in seeds.clone() {
        let scene = scene(seed);
        let again = again.replace("{}", &seed.to_string());
        // Far away a shallow line where something meets the mirror may move by more than a pixel.
        let attempt = AssertUnwindSafe(|| studio.reflection_error(&scene, odd - ODD));
        let difference = match catch_unwind(attempt) {
            Ok(difference) => difference,
            Err(panic) => {
                // What failed may have left its stage in any state.
                studio = Studio::default();
                let says_so = panic.downcast_ref::<String>();
                if says_so.is_some_and(|text| text.contains("is nothing but"))
                    && is_blank(&mut studio, &scene)
                {
                    blank += 1;
                } else {
                    failed.push(format!("{again}: see above"));
                }
                continue;
            }
        };
        let allowed = odd.max((difference.compared as f64 * (1.0 - share)) as usize);
        if difference.beyond > allowed {
            failed.push(format!("{again}: {difference}"));
        }
        compared += difference.compared;
        beyond += difference.beyond;
        let rank = |of: &Difference| (of.beyond, of.worst);
        if worst.is_none_or(|(_, worst)| rank(&difference) > rank(&worst)) {
            worst = Some((seed, difference));
        }
    }
    let scenes = seeds.end - seeds.start;
    println!("{again}: {scenes} scenes, {blank} blank; {beyond} of {compared} pixels differ");
    if let Some((seed, worst)) = worst {
        println!("  worst: {seed}: {worst}");
    }
    let failures = failed.join("\n");
    assert!(failed.is_empty(), "of {seeds:?} these fail:\n{failures}");
    assert!(
        beyond as f64 <= compared as f64 * (1.0 - share),
        "{beyond} of {compared} pixels differ"
    );
    assert!(
        20 * blank <= scenes,
        "{blank} of {scenes} scenes show nothing"
    );
}

/// Whether stock Bevy draws nothing of a scene either, neither beside the mirror nor in it.
fn is_blank(studio: &mut Studio, scene: &Scene) -> bool {
    let (plain, reference) = (studio.without_mirrors(scene), studio.reference(scene, 0));
    plain == reference && plain.shows_something().is_err()
}

#[test]
fn scenes_of_any_kind() {
    assert_all_reflect(Kind::Any, 0..20, ODD, SHARE);
}

#[test]
fn head_on_scenes() {
    assert_all_reflect(Kind::HeadOn, 100..107, ODD, SHARE);
}

#[test]
fn grazing_scenes() {
    assert_all_reflect(Kind::Grazing, 200..206, ODD, SHARE);
}

#[test]
fn orthographic_scenes() {
    assert_all_reflect(Kind::Orthographic, 300..306, ODD, SHARE);
}

/// So far away single precision moves an edge by some hundredths of a pixel, in the reference as in the mirror.
#[test]
fn scenes_far_from_the_origin() {
    assert_all_reflect(Kind::FarAway, 400..412, ODD_FAR_AWAY, SHARE_FAR_AWAY);
}

#[test]
fn extreme_scenes_of_any_kind() {
    assert_extremes_reflect(extremes::Kind::Any, 0..20, ODD, SHARE);
}

#[test]
fn extreme_head_on_scenes() {
    assert_extremes_reflect(extremes::Kind::HeadOn, 0..6, ODD, SHARE);
}

#[test]
fn extreme_grazing_scenes() {
    assert_extremes_reflect(extremes::Kind::Grazing, 0..6, ODD, SHARE);
}

#[test]
fn extreme_orthographic_scenes() {
    assert_extremes_reflect(extremes::Kind::Orthographic, 0..6, ODD, SHARE);
}

#[test]
fn extreme_scenes_far_off() {
    assert_extremes_reflect(extremes::Kind::FarOff, 0..6, ODD_FAR_AWAY, SHARE_FAR_AWAY);
}
