//! What of a scene is to be drawn into files, as the command line asks for it.

use std::path::{Path, PathBuf};

use bevy::app::App;
use indicatif::{ProgressBar, ProgressStyle};

use super::{cli::within, headless::Studio, picture::absolute};

pub enum Pictures {
    One(PathBuf),
    Film {
        frames: u32,
        fps: f32,
        folder: PathBuf,
    },
}

impl Pictures {
    /// By `--out`, `--frames` and `--fps`; or what makes no sense about them.
    pub fn asked(
        out: Option<&Path>,
        frames: Option<u32>,
        fps: Option<f32>,
    ) -> Result<Self, &'static str> {
        const NAME: &str = env!("CARGO_CRATE_NAME");
        let png = out.map(ends_in_png);
        match (frames, png) {
            (None, Some(false)) => Err("--out: a picture's name ends in .png, as in picture.png"),
            (Some(_), Some(true)) => Err("--out: with --frames it is a folder, as in frames"),
            (None, _) if fps.is_some() => Err("--fps goes with --frames, as in --frames 360"),
            (None, _) => Ok(Self::One(
                out.map_or_else(|| format!("{NAME}.png").into(), Into::into),
            )),
            (Some(frames), _) => Ok(Self::Film {
                frames,
                fps: fps.unwrap_or(30.0),
                folder: out.map_or_else(|| format!("{NAME}-frames").into(), Into::into),
            }),
        }
    }

    /// Draws them, from `start` seconds on; returns the line that says where they are.
    pub fn draw(
        &self,
        studio: &mut Studio,
        start: f32,
        set_time: impl Fn(&mut App, f32),
    ) -> Result<String, String> {
        match self {
            Self::One(path) => {
                studio.film(1, |app, _| set_time(app, start), |_| path.clone(), |_| ())?;
                Ok(format!("The picture is in {}", absolute(path)))
            }
            Self::Film {
                frames,
                fps,
                folder,
            } => {
                let bar = ProgressBar::new((*frames).into()).with_style(
                    ProgressStyle::with_template("{bar:40} {pos}/{len} pictures, {eta} to go")
                        .expect("the template is well formed"),
                );
                studio.film(
                    *frames,
                    |app, frame| set_time(app, start + frame as f32 / fps),
                    |frame| folder.join(format!("frame-{frame:05}.png")),
                    |done| bar.set_position(done.into()),
                )?;
                bar.finish_and_clear();
                Ok(format!(
                    "{frames} pictures, {fps} a second, are in {}",
                    absolute(&folder.join("frame-*.png"))
                ))
            }
        }
    }
}

fn ends_in_png(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("png"))
}

pub fn seconds(text: &str) -> Result<f32, String> {
    within(text, 0.0..=86_400.0, "seconds from 0 to 86400, as in 1.5")
}

pub fn size(text: &str) -> Result<(u32, u32), String> {
    const EXPECTED: &str = "WIDTHxHEIGHT from 1x1 to 8192x8192, as in 960x540";
    let (width, height) = text.split_once('x').ok_or(format!("expected {EXPECTED}"))?;
    Ok((
        within(width, 1..=8192, EXPECTED)?,
        within(height, 1..=8192, EXPECTED)?,
    ))
}

pub fn frames(text: &str) -> Result<u32, String> {
    within(text, 1..=100_000, "1 to 100000 pictures, as in 360")
}

pub fn fps(text: &str) -> Result<f32, String> {
    within(
        text,
        0.01..=1000.0,
        "0.01 to 1000 pictures a second, as in 30",
    )
}
