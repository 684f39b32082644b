//! What a mirror must show, drawn with no code of the library: an ordinary camera at the
//! reflected eye, the geometry cut beforehand in f64, the picture flipped.

use bevy::prelude::*;

use crate::{
    coded::{self, Code, Coder},
    color::{linear, srgb},
    flip,
    scenes::Case,
    support::{mask::Mask, picture::Picture, scene::Scene, studio::Studio},
};

/// Samples along a side of a pixel of the reference.
pub const SAMPLES: u32 = 4;

/// The reference of one scene.
pub struct Truth {
    pub size: UVec2,
    /// sRGB levels, not rounded, of the mean light of each pixel's samples; row by row.
    pub levels: Vec<[f64; 3]>,
    /// Which pixels are the mirror's, less one pixel at its edge and at things before it.
    pub inside: Vec<bool>,
    /// The pixels that show any part of the mirror: from, to (exclusive).
    pub bounds: (UVec2, UVec2),
    /// What a pixel shows, where all pixels around it show the same.
    pub codes: Vec<Option<Code>>,
    pub background: [u8; 4],
    /// Codes of which the first lies just before the second.
    pub layers: Vec<[Code; 2]>,
    /// What FLIP sees of the levels.
    pub seen: flip::Seen,
}

/// Draws references, one scene after the other, in one app.
pub struct Painter {
    studio: Studio,
}

impl Painter {
    pub fn new() -> Self {
        let mut scene = Scene::new("none");
        scene.plugins = vec![coded::plugin];
        Self {
            studio: Studio::of(&scene),
        }
    }

    /// Panics if the app fails: without a reference there is nothing to report.
    pub fn truth(&mut self, case: &Case) -> Truth {
        let mut scene = case.exact().clone();
        scene.msaa = Msaa::Off;
        let size = scene.size;
        let mask = self.studio.mask(&scene, 0);
        let mut fine = scene.clone();
        fine.size *= SAMPLES;
        let levels = mean_levels(&self.studio.reference(&fine, 0), SAMPLES);
        let coded = Coder::new(&scene).scene(&fine);
        let coded = self.studio.reference(&coded, 0);
        let background = scene.clear_color.to_srgba().to_u8_array();
        let seen = flip::Image::new(size.x as usize, levels.iter().copied()).seen();
        Truth {
            size,
            inside: mask.picture().places().map(|p| mask.inside(p)).collect(),
            bounds: bounds(&mask),
            codes: even_codes(&coded, SAMPLES, case.slack, background),
            background,
            layers: case
                .layers
                .iter()
                .map(|front| [Code::of_object(*front), Code::of_object(front + 1)])
                .collect(),
            levels,
            seen,
        }
    }
}

impl Truth {
    /// The share of the picture that the mirror covers.
    pub fn share(&self) -> f64 {
        let inside = self.inside.iter().filter(|inside| **inside).count();
        inside as f64 / self.inside.len() as f64
    }
}

/// The box filter: the mean light of `n` by `n` samples.
fn mean_levels(fine: &Picture, n: u32) -> Vec<[f64; 3]> {
    let size = fine.size() / n;
    (0..size.y)
        .flat_map(|y| (0..size.x).map(move |x| (x, y)))
        .map(|(x, y)| {
            let mut light = [0.0; 3];
            for i in 0..n * n {
                let sample = fine.at(x * n + i % n, y * n + i / n);
                for (sum, level) in light.iter_mut().zip(sample) {
                    *sum += linear(level);
                }
            }
            light.map(|sum| srgb(sum / f64::from(n * n)))
        })
        .collect()
}

/// The code of each pixel whose samples, and those of all pixels up to `slack` away, agree.
fn even_codes(fine: &Picture, n: u32, slack: u32, background: [u8; 4]) -> Vec<Option<Code>> {
    let size = fine.size() / n;
    let own: Vec<Option<Code>> = (0..size.y)
        .flat_map(|y| (0..size.x).map(move |x| (x, y)))
        .map(|(x, y)| {
            let code = |i| Code::of(fine.at(x * n + i % n, y * n + i / n), background);
            (1..n * n)
                .all(|i| code(i) == code(0))
                .then(|| code(0))
                .filter(|code| *code != Code::Unclear)
        })
        .collect();
    let at = |x: u32, y: u32| own[(y * size.x + x) as usize];
    (0..size.y)
        .flat_map(|y| (0..size.x).map(move |x| (x, y)))
        .map(|(x, y)| {
            let mut around =
                (y.saturating_sub(slack)..=(y + slack).min(size.y - 1)).flat_map(|v| {
                    (x.saturating_sub(slack)..=(x + slack).min(size.x - 1)).map(move |u| (u, v))
                });
            at(x, y).filter(|code| around.all(|(u, v)| at(u, v) == Some(*code)))
        })
        .collect()
}

/// The rectangle around all that is not black.
fn bounds(mask: &Mask) -> (UVec2, UVec2) {
    let picture = mask.picture();
    let white = |place: &UVec2| {
        let [r, g, ..] = picture.at(place.x, place.y);
        r > 0 && g > 0
    };
    let found = picture.places().filter(white);
    found.fold((UVec2::MAX, UVec2::ZERO), |(low, high), place| {
        (low.min(place), high.max(place + 1))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const BACKGROUND: [u8; 4] = [10, 20, 30, 255];

    #[test]
    fn half_white_samples_are_half_the_light() {
        let fine = Picture::from_fn(UVec2::new(8, 4), |x, _| {
            if x % 4 < 2 && x < 4 {
                [255; 4]
            } else {
                [0, 0, 0, 255]
            }
        });
        let levels = mean_levels(&fine, 4);
        assert_eq!(levels.len(), 2);
        assert!((levels[0][0] - 187.5).abs() < 0.5, "{}", levels[0][0]);
        assert_eq!(levels[1], [0.0; 3]);
    }

    #[test]
    fn pixels_near_an_edge_have_no_code() {
        // Six pixels wide; the edge lies within the third.
        let fine = Picture::from_fn(UVec2::new(24, 12), |x, _| {
            if x < 10 { [255, 0, 0, 255] } else { BACKGROUND }
        });
        let row = |slack| even_codes(&fine, 4, slack, BACKGROUND)[6..12].to_vec();
        let (thing, ground) = (Some(Code::Thing(0)), Some(Code::Background));
        assert_eq!(row(0), [thing, thing, None, ground, ground, ground]);
        assert_eq!(row(1), [thing, None, None, None, ground, ground]);
        assert_eq!(row(2), [None, None, None, None, None, ground]);
    }
}
