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
        let mut values: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        Some(Self {
            median: quantile(&values, 0.5)?,
            spread: quantile(&values, 0.75)? - quantile(&values, 0.25)?,
            count: values.len(),
        })
    }
}

/// The value below which that share of the sorted values is; `None` of nothing. Between the
/// neighbors of a place that is not a whole number.
pub fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let place = share * sorted.len().checked_sub(1)? as f64;
    let (low, high) = (
        sorted[place.floor() as usize],
        sorted[place.ceil() as usize],
    );
    Some(low + (high - low) * place.fract())
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
