//! FLIP: how different two pictures look to an observer who flips between them.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: A Difference
//! Evaluator for Alternating Images", Proceedings of the ACM on Computer Graphics and Interactive
//! Techniques 3(2), 2020; for low dynamic range, and an observer 0.7 m before a display 0.7 m and
//! 3840 pixels wide. Pixels count from 0 (alike) to 1.
//!
//! Written anew rather than bound to its C++: the report must build with nothing but Rust. All of
//! its filters are sums of products of one filter along x and one along y, and run as such. The
//! tests hold it to values of the authors' program.

use std::f64::consts::PI;

use crate::color::from_srgb;

const PIXELS_PER_DEGREE: f64 = 3840.0 * PI / 180.0;

/// Of the contrast sensitivity: sums of `a sqrt(pi / b) exp(-pi^2 x^2 / b)`, for lightness,
/// red-green and blue-yellow.
const SENSITIVITY: [&[(f64, f64)]; 3] = [
    &[(1.0, 0.0047)],
    &[(1.0, 0.0053)],
    &[(34.1, 0.04), (13.5, 0.025)],
];
/// Standard deviations at which a filter ends, of its widest part.
const REACH: f64 = 3.0;
/// Width of the edge detector of the human eye, in degrees.
const FEATURE_WIDTH: f64 = 0.082;
const COLOR_EXPONENT: f64 = 0.7;
const FEATURE_EXPONENT: f64 = 0.5;
/// Color differences up to this share of the largest are spread over [`KNEE_TO`] of the scale.
const KNEE: f64 = 0.4;
const KNEE_TO: f64 = 0.95;

/// A picture with channels from 0 to 1.
#[derive(Clone)]
pub struct Image {
    width: usize,
    pixels: Vec<[f64; 3]>,
}

/// What FLIP sees of one picture: the first half of the work, to be shared among comparisons.
pub struct Seen {
    width: usize,
    /// After the eye's blur, in a space where distances are differences.
    colors: Vec<[f64; 3]>,
    edges: Vec<f64>,
    points: Vec<f64>,
}

impl Image {
    /// `levels` are sRGB from 0 to 255.
    pub fn new(width: usize, levels: impl Iterator<Item = [f64; 3]>) -> Self {
        Self {
            width,
            pixels: levels.map(|level| level.map(|v| v / 255.0)).collect(),
        }
    }

    fn plane(&self, value: impl Fn([f64; 3]) -> f64) -> Plane {
        Plane {
            width: self.width,
            values: self.pixels.iter().map(|pixel| value(*pixel)).collect(),
        }
    }

    pub fn seen(&self) -> Seen {
        let opponents = Self {
            width: self.width,
            pixels: self
                .pixels
                .iter()
                .map(|p| opponent(xyz(p.map(from_srgb))))
                .collect(),
        };
        let blurred: [Plane; 3] = std::array::from_fn(|channel| {
            let plane = opponents.plane(|pixel| pixel[channel]);
            blur(&plane, SENSITIVITY[channel])
        });
        let colors = (0..self.pixels.len())
            .map(|i| {
                let light = linear_rgb([0, 1, 2].map(|channel| blurred[channel].values[i]));
                hunt_lab(light.map(|v| v.clamp(0.0, 1.0)))
            })
            .collect();
        let lightness = opponents.plane(|[y, ..]| (y + 16.0) / 116.0);
        Seen {
            width: self.width,
            colors,
            edges: features(&lightness, |x, _| -x),
            points: features(&lightness, |x, deviation| (x / deviation).powi(2) - 1.0),
        }
    }
}

impl Seen {
    /// The difference of every pixel. The pictures must be of one size.
    pub fn difference(&self, other: &Self) -> Vec<f64> {
        assert_eq!(
            (self.width, self.colors.len()),
            (other.width, other.colors.len())
        );
        let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(hunt_lab);
        let largest = hyab(green, blue).powf(COLOR_EXPONENT);
        let knee = KNEE * largest;
        (0..self.colors.len())
            .map(|i| {
                let color = hyab(self.colors[i], other.colors[i]).powf(COLOR_EXPONENT);
                let color = if color < knee {
                    color * KNEE_TO / knee
                } else {
                    KNEE_TO + (color - knee) / (largest - knee) * (1.0 - KNEE_TO)
                };
                let edge = (self.edges[i] - other.edges[i]).abs();
                let point = (self.points[i] - other.points[i]).abs();
                let feature = (edge.max(point) / 2.0_f64.sqrt()).powf(FEATURE_EXPONENT);
                color.powf(1.0 - feature)
            })
            .collect()
    }
}

/// One channel, row by row.
struct Plane {
    width: usize,
    values: Vec<f64>,
}

impl Plane {
    /// Filters along x and along y; beyond its edge the picture goes on as it is there.
    fn filtered(&self, along_x: &[f64], along_y: &[f64]) -> Self {
        let (width, height) = (self.width, self.values.len() / self.width);
        let pass = |values: &[f64], weights: &[f64], count: usize, step: usize| -> Vec<f64> {
            let reach = (weights.len() / 2) as isize;
            (0..values.len())
                .map(|i| {
                    let at = (i / step % count) as isize;
                    let start = i as isize - at * step as isize;
                    (-reach..=reach)
                        .zip(weights)
                        .map(|(offset, weight)| {
                            let inside = (at + offset).clamp(0, count as isize - 1);
                            weight * values[(start + inside * step as isize) as usize]
                        })
                        .sum()
                })
                .collect()
        };
        let rows = pass(&self.values, along_x, width, 1);
        Self {
            width,
            values: pass(&rows, along_y, height, width),
        }
    }
}

fn blur(plane: &Plane, gaussians: &[(f64, f64)]) -> Plane {
    let widest = SENSITIVITY
        .iter()
        .copied()
        .flatten()
        .map(|(_, b)| *b)
        .fold(0.0, f64::max);
    let reach = (REACH * (widest / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil();
    let filters: Vec<(f64, Vec<f64>)> = gaussians
        .iter()
        .map(|(a, b)| {
            let weight = |x: f64| (-PI * PI * (x / PIXELS_PER_DEGREE).powi(2) / b).exp();
            (a * (PI / b).sqrt(), taps(reach, weight))
        })
        .collect();
    let sum: f64 = filters
        .iter()
        .map(|(height, taps)| height * taps.iter().sum::<f64>().powi(2))
        .sum();
    let mut blurred = vec![0.0; plane.values.len()];
    for (height, taps) in &filters {
        let part = plane.filtered(taps, taps);
        for (total, value) in blurred.iter_mut().zip(part.values) {
            *total += value * height / sum;
        }
    }
    Plane {
        width: plane.width,
        values: blurred,
    }
}

/// The strength of a feature at every pixel: the length of the detector's answers along x and y.
fn features(plane: &Plane, detector: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let reach = (REACH * deviation).ceil();
    let bell = |x: f64| (-x * x / (2.0 * deviation * deviation)).exp();
    let across = taps(reach, bell);
    let total: f64 = across.iter().sum();
    let across: Vec<f64> = across.iter().map(|weight| weight / total).collect();
    let mut along = taps(reach, |x| detector(x, deviation) * bell(x));
    // Its positive part sums up to 1, its negative part to -1.
    let positive: f64 = along.iter().filter(|weight| **weight > 0.0).sum();
    let negative: f64 = -along.iter().filter(|weight| **weight < 0.0).sum::<f64>();
    for weight in &mut along {
        *weight /= if *weight > 0.0 { positive } else { negative };
    }
    let x = plane.filtered(&along, &across).values;
    let y = plane.filtered(&across, &along).values;
    x.iter().zip(y).map(|(x, y)| x.hypot(y)).collect()
}

fn taps(reach: f64, weight: impl Fn(f64) -> f64) -> Vec<f64> {
    let count = 2 * reach as usize + 1;
    (0..count).map(|i| weight(i as f64 - reach)).collect()
}

/// CIE XYZ of linear sRGB, relative to its white.
fn xyz([r, g, b]: [f64; 3]) -> [f64; 3] {
    [
        (0.412_386_563_252_98 * r + 0.357_591_490_920_62 * g + 0.180_450_491_203_56 * b) / WHITE[0],
        0.212_636_821_677_32 * r + 0.715_182_981_841_25 * g + 0.072_180_196_481_42 * b,
        (0.019_330_620_152_48 * r + 0.119_197_163_640_21 * g + 0.950_372_587_005_43 * b) / WHITE[2],
    ]
}

const WHITE: [f64; 3] = [0.950_428_545, 1.0, 1.088_900_371];

/// Linear in light: lightness, red-green, blue-yellow.
fn opponent([x, y, z]: [f64; 3]) -> [f64; 3] {
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn linear_rgb([lightness, red_green, blue_yellow]: [f64; 3]) -> [f64; 3] {
    let y = (lightness + 16.0) / 116.0;
    let x = (y + red_green / 500.0) * WHITE[0];
    let z = (y - blue_yellow / 200.0) * WHITE[2];
    [
        3.241_003_275 * x - 1.537_398_934 * y - 0.498_615_861 * z,
        -0.969_224_334 * x + 1.875_930_071 * y + 0.041_554_224 * z,
        0.055_639_423 * x - 0.204_011_202 * y + 1.057_148_933 * z,
    ]
}

/// CIE L*a*b* of linear sRGB, with less color where it is dark (Hunt).
fn hunt_lab(rgb: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let [x, y, z] = xyz(rgb).map(|v| {
        if v > DELTA.powi(3) {
            v.cbrt()
        } else {
            v / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    });
    let lightness = 116.0 * y - 16.0;
    let gain = 0.01 * lightness;
    [lightness, gain * 500.0 * (x - y), gain * 200.0 * (y - z)]
}

/// City block in lightness, Euclid in color.
fn hyab(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    type Pixel = fn(usize, usize) -> [u8; 3];

    fn image(pixel: Pixel) -> Seen {
        let levels = (0..48).flat_map(|y| (0..64).map(move |x| pixel(x, y).map(f64::from)));
        Image::new(64, levels).seen()
    }

    /// Two pictures, and the mean and the largest value that version 1.2 of the authors' program
    /// gives them.
    const KNOWN: [(&str, Pixel, Pixel, f64, f64); 8] = [
        (
            "black and white",
            |_, _| [0; 3],
            |_, _| [255; 3],
            0.967_388,
            0.967_388,
        ),
        (
            "two levels",
            |_, _| [100; 3],
            |_, _| [102; 3],
            0.049_992,
            0.049_992,
        ),
        (
            "red and green",
            |_, _| [255, 0, 0],
            |_, _| [0, 255, 0],
            0.986_665,
            0.986_665,
        ),
        (
            "blue and yellow",
            |_, _| [0, 0, 255],
            |_, _| [255, 255, 0],
            0.998_972,
            0.998_972,
        ),
        (
            "a dot",
            |_, _| [30; 3],
            |x, y| {
                if (x, y) == (20, 17) {
                    [250, 240, 30]
                } else {
                    [30; 3]
                }
            },
            0.005_733,
            0.749_784,
        ),
        (
            "an edge by a pixel",
            |x, _| if x < 30 { [200, 60, 40] } else { [20, 40, 90] },
            |x, _| if x < 31 { [200, 60, 40] } else { [20, 40, 90] },
            0.040_155,
            0.471_708,
        ),
        (
            "a tint",
            |x, y| [(x * 4) as u8, (y * 5) as u8, 128],
            |x, y| [(x * 4) as u8, (y * 5) as u8, 120],
            0.115_837,
            0.134_424,
        ),
        (
            "stripes",
            |x, _| if x % 2 == 0 { [255; 3] } else { [0; 3] },
            |x, _| if x % 2 == 1 { [255; 3] } else { [0; 3] },
            0.067_244,
            0.660_783,
        ),
    ];

    #[test]
    fn known_pairs_have_their_known_values() {
        for (name, a, b, mean, largest) in KNOWN {
            let difference = image(a).difference(&image(b));
            let found = difference.iter().sum::<f64>() / difference.len() as f64;
            let peak = difference.iter().copied().fold(0.0, f64::max);
            assert!((found - mean).abs() < 2e-4, "{name}: {found}, not {mean}");
            assert!(
                (peak - largest).abs() < 2e-3,
                "{name}: {peak}, not {largest}"
            );
        }
    }

    #[test]
    fn like_pictures_do_not_differ_and_the_order_does_not_matter() {
        for (name, a, b, ..) in KNOWN {
            let (a, b) = (image(a), image(b));
            assert!(a.difference(&a).iter().all(|v| *v == 0.0), "{name}");
            assert_eq!(a.difference(&b), b.difference(&a), "{name}");
        }
    }
}
