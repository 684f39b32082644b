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

/// Where scenes come from.
struct Source<'a> {
    /// How to call for one again, less its seed.
    again: String,
    scene: &'a dyn Fn(u64) -> Scene,
    /// The tamest of a seed for which something still holds.
    tamest: &'a dyn Fn(u64, &mut dyn FnMut(&Scene) -> bool) -> Scene,
}

/// What is asked of a scene.
#[derive(Clone, Copy)]
struct Limit {
    /// Pixels of each mirror that may be odd.
    odd: usize,
    /// The share of all pixels that must be right.
    share: f64,
    /// Pixels around the mirror that may be touched.
    around: usize,
}

enum Outcome {
    Compared(Difference),
    /// Neither the mirror nor stock Bevy shows anything.
    Blank,
    /// It has said so.
    Failed,
}

impl Limit {
    const USUAL: Self = Self {
        odd: ODD,
        share: SHARE,
        around: 0,
    };
    const FAR_AWAY: Self = Self {
        odd: ODD_FAR_AWAY,
        share: SHARE_FAR_AWAY,
        around: 0,
    };
    /// So far that a shallow line where something meets the mirror may move by more than a pixel.
    const EXTREMELY_FAR: Self = Self {
        around: ODD_FAR_AWAY - ODD,
        ..Self::FAR_AWAY
    };

    fn outcome(self, studio: &mut Studio, scene: &Scene) -> Outcome {
        let attempt = AssertUnwindSafe(|| studio.reflection_error(scene, self.around));
        match catch_unwind(attempt) {
            Ok(difference) => Outcome::Compared(difference),
            Err(panic) => {
                // What failed may have left its stage in any state.
                *studio = Studio::default();
                let says_so = panic.downcast_ref::<String>();
                if says_so.is_some_and(|text| text.contains("is nothing but"))
                    && is_blank(studio, scene)
                {
                    Outcome::Blank
                } else {
                    Outcome::Failed
                }
            }
        }
    }

    fn allows(self, difference: &Difference) -> bool {
        let share = (difference.compared as f64 * (1.0 - self.share)) as usize;
        difference.beyond <= self.odd.max(share)
    }

    fn is_kept_by(self, studio: &mut Studio, scene: &Scene) -> bool {
        match self.outcome(studio, scene) {
            Outcome::Compared(difference) => self.allows(&difference),
            Outcome::Blank => true,
            Outcome::Failed => false,
        }
    }
}

fn assert_all_reflect(kind: Kind, seeds: Range<u64>, limit: Limit) {
    let scene = |seed| random::scene(seed, kind);
    let source = Source {
        again: format!("random::scene(_, Kind::{kind:?})"),
        scene: &scene,
        tamest: &|seed, _| scene(seed),
    };
    assert_source_reflects(&source, seeds, limit);
}

/// The same of scenes at the extremes.
fn assert_extremes_reflect(kind: Kind, seeds: Range<u64>, limit: Limit) {
    let source = Source {
        again: format!("wild::scene(Kind::{kind:?}, _)"),
        scene: &|seed| wild::scene(kind, seed),
        tamest: &|seed, fails| wild::tamest(kind, seed, fails),
    };
    assert_source_reflects(&source, seeds, limit);
}

/// One studio draws all scenes of a kind: what a scene leaves behind must not show in the next.
fn assert_source_reflects(source: &Source, seeds: Range<u64>, limit: Limit) {
    let seeds = seeds.start..seeds.start + count(seeds.end - seeds.start, FULL);
    let mut studio = Studio::default();
    let (mut compared, mut beyond, mut blank) = (0, 0, 0);
    let mut worst: Option<(u64, Difference)> = None;
    let mut failed = Vec::new();
    for seed in seeds.clone() {
        match limit.outcome(&mut studio, &(source.scene)(seed)) {
            Outcome::Blank => blank += 1,
            Outcome::Failed => failed.push((seed, "see above".to_owned())),
            Outcome::Compared(difference) => {
                if !limit.allows(&difference) {
                    failed.push((seed, difference.to_string()));
                }
                compared += difference.compared;
                beyond += difference.beyond;
                let rank = |of: &Difference| (of.beyond, of.worst);
                if worst.is_none_or(|(_, worst)| rank(&difference) > rank(&worst)) {
                    worst = Some((seed, difference));
                }
            }
        }
    }
    let scenes = seeds.end - seeds.start;
    let again = &source.again;
    println!("{again}: {scenes} scenes, {blank} blank; {beyond} of {compared} pixels differ");
    if let Some((seed, worst)) = worst {
        println!("  worst: {seed}: {worst}");
    }
    if let Some((seed, _)) = failed.first() {
        println!("the tamest like {seed}: {}", tamest(source, *seed, limit));
    }
    let failures: Vec<_> = failed
        .iter()
        .map(|(seed, how)| format!("{}: {how}", again.replace('_', &seed.to_string())))
        .collect();
    let failures = failures.join("\n");
    assert!(failed.is_empty(), "of {seeds:?} these fail:\n{failures}");
    assert!(
        beyond as f64 <= compared as f64 * (1.0 - limit.share),
        "{beyond} of {compared} pixels differ"
    );
    assert!(
        20 * blank <= scenes,
        "{blank} of {scenes} scenes show nothing"
    );
}

/// A scene that fails, made as tame as it may be and of as few objects, in words.
fn tamest(source: &Source, seed: u64, limit: Limit) -> String {
    let mut studio = Studio::default();
    let mut fails = |scene: &Scene| !limit.is_kept_by(&mut studio, scene);
    let mut scene = (source.tamest)(seed, &mut fails);
    for index in (0..scene.objects.len()).rev() {
        let mut fewer = scene.clone();
        fewer.objects.remove(index);
        if fails(&fewer) {
            scene = fewer;
        }
    }
    let mirrors: Vec<_> = scene.mirrors.iter().map(|it| it.transform).collect();
    let objects: Vec<_> = scene.objects.iter().map(|it| it.transform).collect();
    format!(
        "{}, eye {:?}, {:?}, mirrors {mirrors:?}, objects {objects:?}",
        scene.size, scene.eye, scene.projection
    )
}

/// Whether stock Bevy draws nothing of a scene either, neither beside the mirror nor in it.
fn is_blank(studio: &mut Studio, scene: &Scene) -> bool {
    let (plain, reference) = (studio.without_mirrors(scene), studio.reference(scene, 0));
    plain == reference && plain.shows_something().is_err()
}

#[test]
fn scenes_of_any_kind() {
    assert_all_reflect(Kind::Any, 0..20, Limit::USUAL);
}

#[test]
fn head_on_scenes() {
    assert_all_reflect(Kind::HeadOn, 100..107, Limit::USUAL);
}

#[test]
fn grazing_scenes() {
    assert_all_reflect(Kind::Grazing, 200..206, Limit::USUAL);
}

#[test]
fn orthographic_scenes() {
    assert_all_reflect(Kind::Orthographic, 300..306, Limit::USUAL);
}

/// So far away single precision moves an edge by some hundredths of a pixel, in the reference as in the mirror.
#[test]
fn scenes_far_from_the_origin() {
    assert_all_reflect(Kind::FarAway, 400..412, Limit::FAR_AWAY);
}

#[test]
fn extreme_scenes_of_any_kind() {
    assert_extremes_reflect(Kind::Any, 0..20, Limit::USUAL);
}

#[test]
fn extreme_head_on_scenes() {
    assert_extremes_reflect(Kind::HeadOn, 0..6, Limit::USUAL);
}

#[test]
fn extreme_grazing_scenes() {
    assert_extremes_reflect(Kind::Grazing, 0..6, Limit::USUAL);
}

#[test]
fn extreme_orthographic_scenes() {
    assert_extremes_reflect(Kind::Orthographic, 0..6, Limit::USUAL);
}

#[test]
fn extreme_scenes_far_off() {
    assert_extremes_reflect(Kind::FarAway, 0..6, Limit::EXTREMELY_FAR);
}
