//! Tolerances that show what they measured.

use glam::DVec4;

/// The largest error of a group of checks, as a share of its tolerance.
pub struct Worst {
    what: &'static str,
    share: f64,
    case: String,
}

impl Worst {
    pub fn of(what: &'static str) -> Self {
        Self {
            what,
            share: 0.0,
            case: String::new(),
        }
    }

    pub fn check(&mut self, case: &str, actual: f64, expected: f64, tolerance: f64) {
        let error = (actual - expected).abs();
        assert!(
            error <= tolerance,
            "{}, {case}: {actual:e} instead of {expected:e}, off by {error:e}, allowed {tolerance:e}",
            self.what
        );
        if error > self.share * tolerance {
            self.share = error / tolerance;
            self.case = case.to_string();
        }
    }

    /// Every entry within `tolerance` of the largest.
    pub fn check_all(&mut self, case: &str, actual: &[f64], expected: &[f64], tolerance: f64) {
        let largest = expected.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        self.check_within(case, actual, expected, tolerance * largest);
    }

    pub fn check_within(&mut self, case: &str, actual: &[f64], expected: &[f64], tolerance: f64) {
        assert_eq!(actual.len(), expected.len(), "{}, {case}", self.what);
        for (a, e) in actual.iter().zip(expected) {
            self.check(case, *a, *e, tolerance);
        }
    }
}

impl Drop for Worst {
    fn drop(&mut self) {
        println!(
            "{}: {:.3} of the tolerance ({})",
            self.what, self.share, self.case
        );
    }
}

/// The bound for a row after rounding: an ulp, or 1e-7 of the largest entry where it cancels.
pub fn check_rounded_row(case: &str, actual: DVec4, expected: [f64; 4]) {
    let largest = expected.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    for (a, e) in actual.as_vec4().to_array().iter().zip(expected) {
        let error = (f64::from(*a) - e).abs();
        let allowed = (1.2e-7 * e.abs()).max(1e-7 * largest);
        assert!(
            error <= allowed,
            "{case}: {a:e} instead of {e:e}, off by {error:e}, allowed {allowed:e}"
        );
    }
}
