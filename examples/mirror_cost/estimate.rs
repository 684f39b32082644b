//! A ratio from noisy measurements, and how sure it is.

use crate::{stats::quantile, support::random::Random};

/// What one round, a frame of each app, says: one thing, and what it is measured by.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    pub of: f64,
    pub by: f64,
}

/// The median of the one over the median of the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    pub value: f64,
    /// The 16th and the 84th percentile of the same over rounds drawn from the measured ones again
    /// and again: what one more run would say, two times out of three.
    pub range: [f64; 2],
    pub count: usize,
}

/// How often the rounds are drawn again.
const DRAWS: usize = 1000;

impl Estimate {
    /// `None` of nothing.
    pub fn of(rounds: &[Part]) -> Option<Self> {
        let value = ratio(rounds.iter().copied())?;
        let random = &mut Random::new(1);
        let mut drawn: Vec<f64> = (0..DRAWS)
            .filter_map(|_| {
                let round = |_| rounds[random.below(rounds.len() as u64) as usize];
                ratio((0..rounds.len()).map(round))
            })
            .collect();
        drawn.sort_by(f64::total_cmp);
        Some(Self {
            value,
            range: [quantile(&drawn, 0.16)?, quantile(&drawn, 0.84)?],
            count: rounds.len(),
        })
    }
}

fn ratio(rounds: impl Iterator<Item = Part>) -> Option<f64> {
    let (mut of, mut by): (Vec<f64>, Vec<f64>) = rounds.map(|part| (part.of, part.by)).unzip();
    of.sort_by(f64::total_cmp);
    by.sort_by(f64::total_cmp);
    Some(quantile(&of, 0.5)? / quantile(&by, 0.5)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rounds(pairs: &[(f64, f64)]) -> Vec<Part> {
        pairs.iter().map(|&(of, by)| Part { of, by }).collect()
    }

    #[test]
    fn equal_rounds_leave_no_doubt() {
        let estimate = Estimate::of(&rounds(&[(3.0, 2.0); 5])).expect("there are rounds");
        assert_eq!((estimate.value, estimate.range), (1.5, [1.5, 1.5]));
        assert_eq!(estimate.count, 5);
        assert_eq!(Estimate::of(&[]), None);
    }

    #[test]
    fn one_slow_frame_moves_the_ratio_little() {
        let mut pairs = vec![(3.0, 2.0); 20];
        pairs.push((500.0, 2.0));
        let estimate = Estimate::of(&rounds(&pairs)).expect("there are rounds");
        assert_eq!((estimate.value, estimate.range), (1.5, [1.5, 1.5]));
    }

    #[test]
    fn more_rounds_of_the_same_noise_are_surer() {
        let random = &mut Random::new(3);
        let mut noisy = |count: usize| {
            let pairs: Vec<_> = (0..count)
                .map(|_| [0; 2].map(|_| f64::from(random.between(0.8, 1.2))).into())
                .collect();
            Estimate::of(&rounds(&pairs)).expect("there are rounds")
        };
        let width = |estimate: Estimate| estimate.range[1] - estimate.range[0];
        let (few, many) = (noisy(20), noisy(2000));
        assert!(width(many) < width(few) / 3.0, "{few:?}, {many:?}");
        assert!((many.value - 1.0).abs() < 0.05, "{many:?}");
        assert!(many.range[0] <= many.value && many.value <= many.range[1]);
    }
}
