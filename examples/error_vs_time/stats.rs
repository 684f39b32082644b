//! What many measurements say: median, spread, count.

/// Of a list of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    pub median: f64,
    /// From the first to the third quartile.
    pub spread: f64,
    pub count: usize,
}

impl Summary {
    /// `None` of nothing.
    pub fn of(values: &[f64]) -> Option<Self> {
        let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().checked_sub(1)?;
        // Between the neighbors of a place that is not a whole number.
        let at = |share: f64| {
            let place = share * last as f64;
            let (low, high) = (
                sorted[place.floor() as usize],
                sorted[place.ceil() as usize],
            );
            low + (high - low) * place.fract()
        };
        Some(Self {
            median: at(0.5),
            spread: at(0.75) - at(0.25),
            count: sorted.len(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_slow_frame_moves_neither_median_nor_spread_far() {
        let even = Summary::of(&[4.0, 1.0, 3.0, 2.0, 5.0]).expect("there are values");
        assert_eq!((even.median, even.spread, even.count), (3.0, 2.0, 5));
        let slow = Summary::of(&[4.0, 1.0, 3.0, 2.0, 500.0]).expect("there are values");
        assert_eq!((slow.median, slow.spread), (3.0, 2.0));
    }

    #[test]
    fn an_even_count_has_its_median_between() {
        let summary = Summary::of(&[1.0, 2.0]).expect("there are values");
        assert_eq!((summary.median, summary.spread), (1.5, 0.5));
        assert_eq!(
            Summary::of(&[7.0]).map(|s| (s.median, s.spread)),
            Some((7.0, 0.0))
        );
        assert_eq!(Summary::of(&[]), None);
        assert_eq!(Summary::of(&[f64::NAN]), None);
    }
}
