//! Runs many random scenes, keeps the largest errors, and says how to have a failing scene again.

use std::{
    collections::BTreeMap,
    panic::{AssertUnwindSafe, catch_unwind},
    time::Instant,
};

use crate::extremes::{Extreme, Kind, Shares, shares, shrink};

/// A law that does not hold, and by what figures.
pub struct Broken(pub &'static str, pub String);

/// How many scenes came out which way, and the largest share of each bound that was used.
#[derive(Default)]
pub struct Tally {
    seed: (u64, Option<Kind>),
    outcomes: BTreeMap<&'static str, u64>,
    worst: BTreeMap<&'static str, (f64, u64, Option<Kind>)>,
}

impl Tally {
    pub fn count(&mut self, outcome: &'static str) {
        *self.outcomes.entry(outcome).or_default() += 1;
    }

    pub fn counted(&self, outcome: &str) -> u64 {
        self.outcomes.get(outcome).copied().unwrap_or(0)
    }

    /// `error` must not exceed `allowed`; not a number does.
    pub fn bound(&mut self, what: &'static str, error: f64, allowed: f64) -> Result<(), Broken> {
        let share = if error > 0.0 { error / allowed } else { 0.0 };
        let worst = self.worst.entry(what).or_insert((-1.0, 0, None));
        if share > worst.0 {
            *worst = (share, self.seed.0, self.seed.1);
        }
        Self::law(what, error <= allowed && allowed.is_finite(), || {
            format!("{error:e} of {allowed:e}")
        })
    }

    pub fn law(
        what: &'static str,
        holds: bool,
        figures: impl FnOnce() -> String,
    ) -> Result<(), Broken> {
        if holds {
            Ok(())
        } else {
            Err(Broken(what, figures()))
        }
    }
}

/// Judges the scenes of `seeds` of every kind in turn. All laws that do not hold are shown, each
/// by its first scene, in one line that makes it again, and shrunk.
pub fn run(
    title: &str,
    kinds: &[Kind],
    seeds: u64,
    judge: impl Fn(&Extreme, &mut Tally) -> Result<(), Broken>,
) -> Tally {
    let start = Instant::now();
    let mut tally = Tally::default();
    let mut broken: BTreeMap<&'static str, (u64, u64, Kind)> = BTreeMap::new();
    let judged = |kind: Kind, shares: &Shares, tally: &mut Tally| {
        catch_unwind(AssertUnwindSafe(|| {
            judge(&Extreme::from_shares(kind, shares), tally)
        }))
        .unwrap_or(Err(Broken("no panic", "see above".into())))
    };
    for seed in 0..seeds {
        let kind = kinds[(seed % kinds.len() as u64) as usize];
        tally.seed = (seed, Some(kind));
        if let Err(Broken(what, _)) = judged(kind, &shares(seed), &mut tally) {
            broken.entry(what).or_insert((0, seed, kind)).0 += 1;
        }
    }

    println!("{title}: {seeds} scenes in {:.2?}", start.elapsed());
    for (outcome, number) in &tally.outcomes {
        println!("  {number:8} {outcome}");
    }
    for (what, (share, seed, kind)) in &tally.worst {
        let kind = kind.expect("a scene was judged");
        println!("  {share:8.3} of the bound: {what} (Extreme::of(Kind::{kind:?}, {seed}))");
    }
    for (what, (times, seed, kind)) in &broken {
        let verdict = |shares: &Shares| judged(*kind, shares, &mut Tally::default()).err();
        let figures = verdict(&shares(*seed)).map(|broken| broken.1);
        let tamest = shrink(shares(*seed), |tamer| {
            verdict(tamer).is_some_and(|broken| broken.0 == *what)
        });
        println!(
            "BROKEN {times} times: {what}: {}: Extreme::of(Kind::{kind:?}, {seed})\n  shrunk: {}: {:?}",
            figures.unwrap_or_default(),
            verdict(&tamest).map_or_else(String::new, |broken| broken.1),
            Extreme::from_shares(*kind, &tamest),
        );
    }
    assert!(broken.is_empty(), "{title}: {:?}", broken.keys());
    tally
}
