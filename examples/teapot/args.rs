//! The command line.

use std::{path::PathBuf, process::ExitCode};

use argh::FromArgs;

use crate::{
    bezier::MAX_TESSELLATION,
    settings::Settings,
    shared::{
        cli::{self, within},
        pictures::{Pictures, fps, frames, seconds, size},
    },
};

/// A teapot jumps through a marble table that is a mirror: in a window, or with --headless,
/// --out or --frames into pictures (same arguments, same pixels).
#[derive(FromArgs)]
pub struct Args {
    /// draw into a file, without a window
    #[argh(switch)]
    pub headless: bool,

    /// seconds into the scene (0); all of it repeats after 12
    #[argh(option, default = "0.0", from_str_fn(seconds))]
    pub time: f32,

    /// width and height in pixels, as in 960x540 (the default)
    #[argh(option, default = "(960, 540)", from_str_fn(size))]
    pub size: (u32, u32),

    /// the picture (teapot.png), or with --frames the folder (teapot-frames)
    #[argh(option)]
    out: Option<PathBuf>,

    /// draw that many pictures for a film
    #[argh(option, from_str_fn(frames))]
    frames: Option<u32>,

    /// pictures for a second of the film (30)
    #[argh(option, from_str_fn(fps))]
    fps: Option<f32>,

    /// how much of the table's own color covers its reflection, 0 to 1 (0.5)
    #[argh(option, default = "0.5", from_str_fn(alpha))]
    alpha: f32,

    /// quads along a side of each of the teapot's 32 patches, 1 to 64 (16)
    #[argh(option, default = "16", from_str_fn(tessellation))]
    tessellation: u32,

    /// samples for each pixel: 1, 2, 4 or 8, as far as the device has them (4)
    #[argh(option, from_str_fn(msaa))]
    pub msaa: Option<u32>,

    /// draw in low dynamic range, without bloom
    #[argh(switch)]
    no_hdr: bool,

    /// do not cut the reflection at the table
    #[argh(switch)]
    no_clip: bool,

    /// leave the table a plain table
    #[argh(switch)]
    no_mirror: bool,

    /// filter shadows hard, over 2 x 2 texels
    #[argh(switch)]
    hard_shadows: bool,
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

    pub fn settings(&self) -> Settings {
        Settings {
            mirror: !self.no_mirror,
            clip: !self.no_clip,
            alpha: self.alpha,
            tessellation: self.tessellation,
            soft_shadows: !self.hard_shadows,
            samples: self.msaa.unwrap_or(4),
            hdr: !self.no_hdr,
        }
    }
}

fn alpha(text: &str) -> Result<f32, String> {
    within(text, 0.0..=1.0, "a number from 0 to 1, as in 0.5")
}

fn tessellation(text: &str) -> Result<u32, String> {
    within(
        text,
        1..=MAX_TESSELLATION,
        "a whole number from 1 to 64, as in 16",
    )
}

fn msaa(text: &str) -> Result<u32, String> {
    within(text, 1..=8, "1, 2, 4 or 8").and_then(|n: u32| {
        n.is_power_of_two()
            .then_some(n)
            .ok_or("expected 1, 2, 4 or 8".into())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(line: &str) -> Option<Args> {
        let given: Vec<&str> = line.split_whitespace().collect();
        let args = Args::from_args(&["teapot"], &given).ok()?;
        args.pictures().is_ok().then_some(args)
    }

    #[test]
    fn arguments_that_make_no_sense_are_refused() {
        for line in [
            "--time -1",
            "--time NaN",
            "--time soon",
            "--size 0x540",
            "--size 960",
            "--size 960x9000",
            "--frames 0",
            "--frames 3 --fps 0",
            "--fps 30",
            "--frames 3 --out film.png",
            "--out picture.jpg",
            "--alpha 1.5",
            "--tessellation 65",
            "--msaa 3",
            "--msaa 16",
            "--unheard-of",
            "teapot.png",
        ] {
            assert!(read(line).is_none(), "{line}");
        }
    }

    #[test]
    fn files_are_drawn_when_they_are_asked_for() {
        let wants_pictures = |line: &str| read(line).map(|args| args.wants_pictures());
        assert_eq!(wants_pictures(""), Some(false));
        assert_eq!(wants_pictures("--time 2 --msaa 8"), Some(false));
        for line in ["--headless", "--out a.PNG", "--frames 2 --fps 1 --out film"] {
            assert_eq!(wants_pictures(line), Some(true), "{line}");
        }
    }
}
