//! Where a picture of the sheet is cut, to a fraction of a pixel.

use bevy::math::DVec2;

use crate::{color::linear, sheet::Cut, support::picture::Picture};

/// Columns at the ends of the sheet that are not looked at, besides those its sides run through.
const ENDS_PX: f64 = 1.5;

/// Where the cut lies, in pixels of the report.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Found {
    /// Beside its place: positive where too much shows, negative where too little.
    Beside {
        /// In the mean along the cut.
        shift: f64,
        /// How much more at one end than in the middle.
        tilt: f64,
    },
    /// The sheet shows beyond all that is looked at: it is not cut.
    NotCut,
    /// No sheet shows.
    NoSheet,
}

/// Measures the cut.
///
/// Across the cut, column by column (or row by row), the light of the sheet is summed up, which
/// is the place of the edge whatever its slope within the pixel; a straight line is fitted through
/// what the columns are off. `None` if the cut is too short to say.
pub fn locate(picture: &Picture, cut: &Cut) -> Option<Found> {
    let steep = (cut.to - cut.from).abs();
    let steep = steep.y > steep.x;
    // In a frame in which the cut runs along x.
    let turn = |p: DVec2| if steep { DVec2::new(p.y, p.x) } else { p };
    let mut ends = [
        (turn(cut.from), turn(cut.sides[0])),
        (turn(cut.to), turn(cut.sides[1])),
    ];
    ends.sort_by(|a, b| a.0.x.total_cmp(&b.0.x));
    let [(from, left), (to, right)] = ends;
    let slope = (to.y - from.y) / (to.x - from.x);
    let cosine = 1.0 / slope.hypot(1.0);
    let kept_below = turn(cut.kept).y > 0.0;
    let size = picture.size().as_dvec2();
    let size = turn(size);
    let window = cut.window * cut.magnification;
    // How far a side of the sheet runs along the cut while it leaves the window.
    let end = |side: DVec2| {
        let leaves = (side.y - side.x * slope).abs();
        ENDS_PX * cut.magnification + (side.x / leaves * window).abs()
    };
    let (first, last) = (from.x + end(left), to.x - end(right));

    let light = |x: f64, y: f64| {
        let (x, y) = if steep { (y, x) } else { (x, y) };
        linear(picture.at(x as u32, y as u32)[1])
    };
    let mut offs = Vec::new();
    let mut column = first.ceil();
    while column + 1.0 <= last {
        let edge = from.y + (column + 0.5 - from.x) * slope;
        let (top, bottom) = ((edge - window).floor(), (edge + window).floor());
        if top >= 0.0 && bottom <= size.y && column >= 0.0 && column < size.x {
            let mut sheet = 0.0;
            let mut row = top;
            while row < bottom {
                sheet += light(column, row);
                row += 1.0;
            }
            let expected = if kept_below {
                bottom - edge
            } else {
                edge - top
            };
            offs.push((column, (sheet - expected) * cosine / cut.magnification));
        }
        column += 1.0;
    }
    if offs.len() < 6 {
        return None;
    }
    let (shift, tilt) = line(&offs);
    let most = cut.window * cosine * 0.9;
    Some(if shift <= -most {
        Found::NoSheet
    } else if shift >= most {
        Found::NotCut
    } else {
        Found::Beside { shift, tilt }
    })
}

/// The straight line through the points: its height in the middle, its rise from there to an end.
fn line(points: &[(f64, f64)]) -> (f64, f64) {
    let count = points.len() as f64;
    let mean = |value: fn(&(f64, f64)) -> f64| points.iter().map(value).sum::<f64>() / count;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let across: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let along: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    let half = (points[points.len() - 1].0 - points[0].0) / 2.0;
    (y, across / along * half)
}

#[cfg(test)]
mod tests {
    use bevy::math::UVec2;

    use super::*;
    use crate::color::srgb;

    const SIZE: UVec2 = UVec2::new(160, 90);

    fn cut(from: DVec2, to: DVec2, kept: DVec2) -> Cut {
        Cut {
            from,
            to,
            kept,
            sides: [kept; 2],
            magnification: 1.0,
            window: 6.0,
        }
    }

    /// White beyond the line that lies `shift` from the cut, sampled `n` by `n` times a pixel.
    fn half_plane(cut: &Cut, shift: f64, tilt: f64, n: u32) -> Picture {
        let along = cut.to - cut.from;
        Picture::from_fn(SIZE, |x, y| {
            let mut inside = 0;
            for sample in 0..n * n {
                let within = DVec2::new(f64::from(sample % n), f64::from(sample / n)) + 0.5;
                let place = DVec2::new(f64::from(x), f64::from(y)) + within / f64::from(n);
                let t = (place - cut.from).dot(along) / along.length_squared() * 2.0 - 1.0;
                inside += u32::from((place - cut.from).dot(cut.kept) > -shift - tilt * t);
            }
            let level = srgb(f64::from(inside) / f64::from(n * n)).round() as u8;
            [level, level, level, 255]
        })
    }

    fn slants() -> Vec<Cut> {
        let lines = [
            (DVec2::new(20.0, 30.3), DVec2::new(140.0, 51.7)),
            (DVec2::new(30.0, 70.0), DVec2::new(130.0, 20.0)),
            (DVec2::new(70.2, 10.0), DVec2::new(92.9, 80.0)),
        ];
        lines
            .into_iter()
            .flat_map(|(from, to)| {
                let square = (to - from).perp().normalize();
                [cut(from, to, square), cut(from, to, -square)]
            })
            .collect()
    }

    #[track_caller]
    fn assert_found(found: Option<Found>, shift: f64, tilt: f64, tolerance: f64) {
        let Some(Found::Beside { shift: s, tilt: t }) = found else {
            panic!("{found:?} instead of {shift} and {tilt}");
        };
        let near = (s - shift).abs() < tolerance && (t - tilt).abs() < tolerance * 2.0;
        assert!(near, "{s} and {t} instead of {shift} and {tilt}");
    }

    #[test]
    fn a_smooth_edge_is_found_to_a_hundredth_of_a_pixel() {
        for cut in slants() {
            for shift in [0.0, 0.02, -0.3, 1.7, -4.0] {
                let found = locate(&half_plane(&cut, shift, 0.0, 16), &cut);
                assert_found(found, shift, 0.0, 0.01);
            }
        }
    }

    #[test]
    fn an_edge_of_one_sample_a_pixel_is_found_to_a_twentieth() {
        for cut in slants() {
            let found = locate(&half_plane(&cut, 0.4, 0.0, 1), &cut);
            assert_found(found, 0.4, 0.0, 0.05);
        }
    }

    #[test]
    fn slanted_sides_of_the_sheet_do_not_move_the_edge() {
        for mut cut in slants() {
            let along = (cut.to - cut.from).normalize();
            cut.sides = [cut.kept + along, cut.kept - along * 0.5];
            let inside = |place: DVec2| {
                let height = (place - cut.from).dot(cut.kept);
                let from = (place - cut.from).dot(along) - height;
                let to = (cut.to - place).dot(along) - height * 0.5;
                height > 0.0 && from > 0.0 && to > 0.0
            };
            let sheet = Picture::from_fn(SIZE, |x, y| {
                let place = DVec2::new(f64::from(x), f64::from(y));
                let shown = (0..64_u32).filter(|i| {
                    let within = DVec2::new(f64::from(i % 8), f64::from(i / 8)) + 0.5;
                    inside(place + within / 8.0)
                });
                let level = srgb(shown.count() as f64 / 64.0).round() as u8;
                [level, level, level, 255]
            });
            assert_found(locate(&sheet, &cut), 0.0, 0.0, 0.01);
        }
    }

    #[test]
    fn a_turned_edge_shows_as_tilt() {
        for cut in slants() {
            let found = locate(&half_plane(&cut, 0.0, 0.5, 8), &cut);
            let Some(Found::Beside { shift, tilt }) = found else {
                panic!("{found:?}");
            };
            // From left to right, or from top to bottom: the sign is that of the screen.
            assert!(
                shift.abs() < 0.03 && (tilt.abs() - 0.48).abs() < 0.05,
                "{found:?}"
            );
        }
    }

    #[test]
    fn a_sheet_that_is_not_cut_or_not_there_is_told_apart() {
        let cut = &slants()[0];
        let white = Picture::from_fn(SIZE, |_, _| [255; 4]);
        assert_eq!(locate(&white, cut), Some(Found::NotCut));
        let black = Picture::from_fn(SIZE, |_, _| [0, 0, 0, 255]);
        assert_eq!(locate(&black, cut), Some(Found::NoSheet));
    }

    #[test]
    fn magnification_is_taken_out_again() {
        let mut cut = slants()[0];
        cut.magnification = 2.0;
        let picture = half_plane(&cut, 0.6, 0.0, 8);
        assert_found(locate(&picture, &cut), 0.3, 0.0, 0.01);
    }

    #[test]
    fn a_cut_too_short_to_measure_is_none() {
        let short = cut(DVec2::new(20.0, 30.0), DVec2::new(26.0, 31.0), DVec2::Y);
        assert_eq!(locate(&half_plane(&short, 0.0, 0.0, 4), &short), None);
    }
}
