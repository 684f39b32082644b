//! A picture read back from the GPU, and the comparison of two of them.

use std::{fmt, path::PathBuf};

use bevy::math::UVec2;

/// Rows of RGBA pixels, the first one on top; sRGB as on the screen.
#[derive(Clone, PartialEq, Eq)]
pub struct Picture {
    size: UVec2,
    pixels: Vec<[u8; 4]>,
}

/// Why two pictures could not be compared, or are not alike.
#[derive(Debug, PartialEq, Eq)]
pub enum Unlike {
    WrongSize {
        actual: UVec2,
        expected: UVec2,
    },
    /// The region to compare holds no pixel: nothing would be tested.
    NothingCompared,
    Pixels(Difference),
}

/// How far two pictures of one size are apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Pixels compared.
    pub compared: usize,
    /// Of these, the ones with a channel farther apart than the tolerance.
    pub beyond: usize,
    /// The largest difference of a channel, of 255 levels.
    pub worst: u8,
    /// Where that is.
    pub at: UVec2,
}

impl Picture {
    /// Takes pixels row by row. `None` where their number does not fit the size, or there are none.
    pub fn new(size: UVec2, pixels: Vec<[u8; 4]>) -> Option<Self> {
        let fits = pixels.len() == (size.x * size.y) as usize && !pixels.is_empty();
        fits.then_some(Self { size, pixels })
    }

    pub fn from_fn(size: UVec2, pixel: impl Fn(u32, u32) -> [u8; 4]) -> Self {
        let pixels = (0..size.y)
            .flat_map(|y| (0..size.x).map(move |x| (x, y)))
            .map(|(x, y)| pixel(x, y))
            .collect();
        Self { size, pixels }
    }

    pub fn size(&self) -> UVec2 {
        self.size
    }

    pub fn at(&self, x: u32, y: u32) -> [u8; 4] {
        assert!(
            x < self.size.x && y < self.size.y,
            "({x}, {y}) is outside {}",
            self.size
        );
        self.pixels[(y * self.size.x + x) as usize]
    }

    /// Left and right exchanged.
    pub fn flipped(&self) -> Self {
        Self::from_fn(self.size, |x, y| self.at(self.size.x - 1 - x, y))
    }

    /// Of each pixel, the one of two pictures of this size that is more like this one's.
    pub fn nearer(&self, a: &Self, b: &Self) -> Self {
        Self::from_fn(self.size, |x, y| {
            let [own, a, b] = [self, a, b].map(|picture| picture.at(x, y));
            if apart(own, a) <= apart(own, b) { a } else { b }
        })
    }

    pub fn crop(&self, min: UVec2, size: UVec2) -> Self {
        Self::from_fn(size, |x, y| self.at(min.x + x, min.y + y))
    }

    pub fn places(&self) -> impl Iterator<Item = UVec2> + use<> {
        let size = self.size;
        (0..size.y).flat_map(move |y| (0..size.x).map(move |x| UVec2::new(x, y)))
    }

    pub fn count(&self, wanted: impl Fn([u8; 4]) -> bool) -> usize {
        self.pixels.iter().filter(|pixel| wanted(**pixel)).count()
    }

    /// The mean place of the wanted pixels, in pixels from the top left corner; `None` if there are none.
    pub fn centroid(&self, wanted: impl Fn([u8; 4]) -> bool) -> Option<bevy::math::Vec2> {
        let found: Vec<_> = self
            .places()
            .filter(|place| wanted(self.at(place.x, place.y)))
            .collect();
        let sum: bevy::math::Vec2 = found.iter().map(|place| place.as_vec2() + 0.5).sum();
        (!found.is_empty()).then(|| sum / found.len() as f32)
    }

    /// Fails on a picture of one single color: whatever drew it drew nothing.
    pub fn shows_something(&self) -> Result<(), String> {
        let first = self.pixels[0];
        if self.pixels.iter().any(|pixel| *pixel != first) {
            return Ok(());
        }
        Err(format!(
            "the picture ({}) is nothing but {first:?}",
            self.size
        ))
    }

    #[track_caller]
    pub fn assert_shows_something(&self) {
        if let Err(nothing) = self.shows_something() {
            panic!("{nothing}");
        }
    }

    /// Compares the pixels of a region; a channel may be `tolerance` levels off.
    pub fn difference(
        &self,
        expected: &Self,
        tolerance: u8,
        region: impl Fn(UVec2) -> bool,
    ) -> Result<Difference, Unlike> {
        if self.size != expected.size {
            return Err(Unlike::WrongSize {
                actual: self.size,
                expected: expected.size,
            });
        }
        let mut difference = Difference {
            compared: 0,
            beyond: 0,
            worst: 0,
            at: UVec2::ZERO,
        };
        for place in self.places().filter(|place| region(*place)) {
            let apart = apart(self.at(place.x, place.y), expected.at(place.x, place.y));
            difference.compared += 1;
            difference.beyond += usize::from(apart > tolerance);
            if apart > difference.worst {
                (difference.worst, difference.at) = (apart, place);
            }
        }
        if difference.compared == 0 {
            return Err(Unlike::NothingCompared);
        }
        Ok(difference)
    }

    /// [`Self::difference`], and at least `share` of the region within the tolerance.
    pub fn alike(
        &self,
        expected: &Self,
        tolerance: u8,
        share: f64,
        region: impl Fn(UVec2) -> bool,
    ) -> Result<Difference, Unlike> {
        let difference = self.difference(expected, tolerance, region)?;
        let allowed = difference.compared as f64 * (1.0 - share);
        if difference.beyond as f64 > allowed {
            return Err(Unlike::Pixels(difference));
        }
        Ok(difference)
    }

    /// Fails with the two pictures and their difference written beside the build.
    #[track_caller]
    pub fn assert_alike(
        &self,
        expected: &Self,
        tolerance: u8,
        share: f64,
        region: impl Fn(UVec2) -> bool,
        what: &str,
    ) -> Difference {
        match self.alike(expected, tolerance, share, region) {
            Ok(difference) => difference,
            Err(unlike) => {
                let files = [
                    self.save(&format!("{what}-actual")),
                    expected.save(&format!("{what}-expected")),
                    self.apart_from(expected)
                        .save(&format!("{what}-difference")),
                ];
                panic!("{what}: {unlike}\n{}", files.join("\n"));
            }
        }
    }

    /// Every pixel, every channel.
    #[track_caller]
    pub fn assert_same(&self, expected: &Self, what: &str) {
        self.assert_alike(expected, 0, 1.0, |_| true, what);
    }

    /// Where the two differ: brighter is farther apart, white is 16 levels or more.
    fn apart_from(&self, other: &Self) -> Self {
        Self::from_fn(self.size.min(other.size), |x, y| {
            let apart = apart(self.at(x, y), other.at(x, y)).saturating_mul(16);
            [apart, apart, apart, 255]
        })
    }

    /// Writes a PNG into the build's folder for tests and says where.
    pub fn save(&self, name: &str) -> String {
        let name: String = name
            .chars()
            .map(|c| {
                if c.is_alphanumeric() || c == '-' {
                    c
                } else {
                    '_'
                }
            })
            .collect();
        // Examples are not told of the folder for tests.
        let folder =
            option_env!("CARGO_TARGET_TMPDIR").map_or_else(std::env::temp_dir, PathBuf::from);
        let path = folder.join(format!("{name}.png"));
        let bytes = self.pixels.as_flattened();
        let format = image::ExtendedColorType::Rgba8;
        match image::save_buffer(&path, bytes, self.size.x, self.size.y, format) {
            Ok(()) => path.display().to_string(),
            Err(error) => format!("{} could not be written: {error}", path.display()),
        }
    }
}

fn apart(a: [u8; 4], b: [u8; 4]) -> u8 {
    std::array::from_fn::<u8, 4, _>(|i| a[i].abs_diff(b[i]))
        .into_iter()
        .max()
        .unwrap_or(0)
}

impl fmt::Debug for Picture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Picture({}x{})", self.size.x, self.size.y)
    }
}

impl fmt::Display for Unlike {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::WrongSize { actual, expected } => {
                write!(f, "the picture is {actual} and not {expected}")
            }
            Self::NothingCompared => f.write_str("the region to compare is empty"),
            Self::Pixels(difference) => difference.fmt(f),
        }
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            compared,
            beyond,
            worst,
            at,
        } = self;
        write!(
            f,
            "{beyond} of {compared} pixels differ, at {at} by {worst} levels"
        )
    }
}
