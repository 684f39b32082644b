//! How wrong a picture of a mirror is.

use bevy::prelude::*;

use crate::{coded::Code, flip, support::picture::Picture, truth::Truth};

/// Differences up to this many levels of 255 do not count as wrong.
const TOLERANCE: f64 = 2.0;

/// Over the mirror's pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    pub pixels: usize,
    /// The share of them that is more than [`TOLERANCE`] levels off in a channel.
    pub beyond: f64,
    /// In levels.
    pub largest: f64,
    /// Root of the mean square, over pixels and channels, in levels.
    pub rmse: f64,
    /// Mean of FLIP.
    pub flip: f64,
}

/// Pixels of the mirror that show the wrong thing, where the right one is beyond doubt.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Things {
    /// They show what lies behind the mirror.
    pub ghosts: usize,
    /// They show what is behind it, or nothing, where something should be.
    pub losses: usize,
    /// They show the wrong one of two things that lie close together.
    pub inversions: usize,
}

/// `None` if no pixel is the mirror's.
pub fn errors(picture: &Picture, truth: &Truth) -> Option<Errors> {
    assert_eq!(picture.size(), truth.size);
    let pixels = truth.inside.iter().filter(|inside| **inside).count();
    if pixels == 0 {
        return None;
    }
    let (mut beyond, mut largest, mut squares) = (0, 0.0_f64, 0.0);
    // Outside the mirror the reference itself, so that nothing there is seen as different.
    let mut shown = truth.levels.clone();
    for (index, place) in picture
        .places()
        .enumerate()
        .filter(|(i, _)| truth.inside[*i])
    {
        let [r, g, b, _] = picture.at(place.x, place.y).map(f64::from);
        shown[index] = [r, g, b];
        let apart = [0, 1, 2].map(|i| (shown[index][i] - truth.levels[index][i]).abs());
        let most = apart[0].max(apart[1]).max(apart[2]);
        beyond += usize::from(most > TOLERANCE);
        largest = largest.max(most);
        squares += apart.iter().map(|v| v * v).sum::<f64>();
    }
    let seen = flip::Image::new(truth.size.x as usize, shown.into_iter()).seen();
    let differences = seen.difference(&truth.seen);
    let flip: f64 = differences
        .iter()
        .zip(&truth.inside)
        .filter_map(|(value, inside)| inside.then_some(*value))
        .sum();
    let count = pixels as f64;
    Some(Errors {
        pixels,
        beyond: f64::from(beyond as u32) / count,
        largest,
        rmse: (squares / (3.0 * count)).sqrt(),
        flip: flip / count,
    })
}

/// Counts wrong things in a coded picture.
pub fn things(picture: &Picture, truth: &Truth) -> Things {
    let mut things = Things::default();
    for (index, UVec2 { x, y }) in picture.places().enumerate() {
        if !truth.inside[index] {
            continue;
        }
        let shown = Code::of(picture.at(x, y), truth.background);
        if shown == Code::Ghost {
            things.ghosts += 1;
            continue;
        }
        let Some(right @ Code::Thing(_)) = truth.codes[index] else {
            continue;
        };
        if truth.layers.iter().any(|&[front, back]| {
            [front, back] == [right, shown] || [back, front] == [right, shown]
        }) {
            things.inversions += 1;
        } else if shown != right && shown != Code::Unclear {
            things.losses += 1;
        }
    }
    things
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: UVec2 = UVec2::new(40, 30);

    /// A reference of one level everywhere, all of it the mirror's but the left half.
    fn truth(level: f64) -> Truth {
        let count = (SIZE.x * SIZE.y) as usize;
        let levels = vec![[level; 3]; count];
        Truth {
            size: SIZE,
            seen: flip::Image::new(SIZE.x as usize, levels.iter().copied()).seen(),
            levels,
            inside: (0..count).map(|i| i % 40 >= 20).collect(),
            bounds: (UVec2::new(20, 0), SIZE),
            codes: vec![Some(Code::Thing(0)); count],
            background: [10, 20, 30, 255],
            layers: vec![[Code::Thing(0), Code::Thing(1)]],
        }
    }

    #[test]
    fn the_same_picture_has_no_error() {
        let picture = Picture::from_fn(SIZE, |_, _| [100, 100, 100, 255]);
        let errors = errors(&picture, &truth(100.0)).expect("it has pixels");
        assert_eq!(
            (errors.pixels, errors.beyond, errors.largest),
            (600, 0.0, 0.0)
        );
        assert_eq!((errors.rmse, errors.flip), (0.0, 0.0));
    }

    #[test]
    fn what_is_outside_the_mirror_does_not_count() {
        let picture = Picture::from_fn(SIZE, |x, _| if x < 20 { [255; 4] } else { [100; 4] });
        let errors = errors(&picture, &truth(100.0)).expect("it has pixels");
        assert_eq!((errors.beyond, errors.rmse, errors.flip), (0.0, 0.0, 0.0));
    }

    #[test]
    fn one_wrong_pixel_counts_once_in_every_measure() {
        let picture = Picture::from_fn(SIZE, |x, y| {
            if (x, y) == (30, 15) {
                [160, 100, 100, 255]
            } else {
                [100, 101, 102, 255]
            }
        });
        let errors = errors(&picture, &truth(100.0)).expect("it has pixels");
        assert!((errors.beyond - 1.0 / 600.0).abs() < 1e-12);
        assert_eq!(errors.largest, 60.0);
        let squares: f64 = 60.0_f64.powi(2) + 599.0 * (1.0 + 4.0);
        assert!((errors.rmse - (squares / 1800.0).sqrt()).abs() < 1e-12);
        assert!(errors.flip > 0.0);
    }

    #[test]
    fn ghosts_losses_and_inversions_are_told_apart() {
        let picture = Picture::from_fn(SIZE, |x, _| match x {
            0..20 => [255, 0, 255, 255],
            20 => [255, 0, 255, 255],
            21 => [10, 20, 30, 255],
            22 => [0, 0, 255, 255],
            23..26 => [0, 255, 0, 255],
            26 => [188, 188, 0, 255],
            _ => [255, 0, 0, 255],
        });
        let found = things(&picture, &truth(0.0));
        let expected = Things {
            ghosts: 30,
            losses: 60,
            inversions: 90,
        };
        assert_eq!(found, expected);
    }

    #[test]
    fn a_mirror_without_pixels_has_no_error_to_tell() {
        let mut truth = truth(1.0);
        truth.inside.fill(false);
        let picture = Picture::from_fn(SIZE, |_, _| [0; 4]);
        assert_eq!(errors(&picture, &truth), None);
    }
}
