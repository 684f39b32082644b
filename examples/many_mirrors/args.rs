//! The command line.

use std::{path::PathBuf, process::ExitCode};

use argh::FromArgs;

use crate::{
    scenes::Place,
    shared::{
        cli::{self, within},
        pictures::{Pictures, fps, frames, seconds, size},
    },
};

/// Many mirrors: in a window, or with --headless, --out or --frames into pictures.
#[derive(FromArgs)]
pub struct Args {
    /// draw into a file, without a window
    #[argh(switch)]
    headless: bool,

    /// hall (the default), tiles or split
    #[argh(option, default = "Place::Hall", from_str_fn(place))]
    pub scene: Place,

    /// how often a ray is reflected at most, 0 to 8 (4)
    #[argh(option, default = "4", from_str_fn(bounces))]
    pub bounces: u8,

    /// seconds into the scene (0)
    #[argh(option, default = "0.0", from_str_fn(seconds))]
    pub time: f32,

    /// width and height in pixels, as in 960x540 (the default)
    #[argh(option, default = "(960, 540)", from_str_fn(size))]
    pub size: (u32, u32),

    /// the picture (many_mirrors.png), or with --frames the folder (many_mirrors-frames)
    #[argh(option)]
    out: Option<PathBuf>,

    /// draw that many pictures for a film
    #[argh(option, from_str_fn(frames))]
    frames: Option<u32>,

    /// pictures for a second of the film (30)
    #[argh(option, from_str_fn(fps))]
    fps: Option<f32>,
}

impl Args {
    /// Reads the command line. `Err` has said on the terminal what there was to say.
    pub fn parse() -> Result<Self, ExitCode> {
        let parsed: Self = cli::parse()?;
        match parsed.pictures() {
            Ok(_) => Ok(parsed),
            Err(text) => Err(cli::complain(text)),
        }
    }

    /// Whether the arguments ask for files instead of a window.
    pub fn wants_pictures(&self) -> bool {
        self.headless || self.out.is_some() || self.frames.is_some()
    }

    /// What to draw into files; or what makes no sense about it.
    pub fn pictures(&self) -> Result<Pictures, &'static str> {
        Pictures::asked(self.out.as_deref(), self.frames, self.fps)
    }
}

fn place(text: &str) -> Result<Place, String> {
    Place::ALL
        .into_iter()
        .find(|place| place.name() == text)
        .ok_or_else(|| "expected hall, tiles or split".into())
}

fn bounces(text: &str) -> Result<u8, String> {
    within(text, 0..=8, "0 to 8 bounces, as in 4")
}
