//! Which techniques are not beaten: none is both faster and more right.

/// The indices of the points that no other is at least as good as in both and better in one, by
/// growing time.
pub fn frontier(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| {
        let ((ta, ea), (tb, eb)) = (points[a], points[b]);
        ta.total_cmp(&tb).then(ea.total_cmp(&eb))
    });
    let mut least = f64::INFINITY;
    order.retain(|&i| {
        let better = points[i].1 < least;
        if better {
            least = points[i].1;
        }
        better
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_not_beaten_remains_and_in_order_of_time() {
        let points = [
            (3.0, 1.0),
            (1.0, 9.0),
            (2.0, 9.5),
            (2.5, 4.0),
            (4.0, 1.0),
            (5.0, 0.5),
        ];
        assert_eq!(frontier(&points), [1, 3, 0, 5]);
    }

    #[test]
    fn of_equals_one_remains() {
        assert_eq!(frontier(&[(1.0, 1.0), (1.0, 1.0)]).len(), 1);
        assert_eq!(frontier(&[(1.0, 2.0), (1.0, 1.0)]), [1]);
        assert!(frontier(&[]).is_empty());
    }
}
