//! The command line.

use std::{path::PathBuf, process::ExitCode};

use argh::FromArgs;

use crate::{
    rows::{self, Row},
    shared::cli,
};

/// What a planar mirror costs: a table of ratios, and a CSV.
#[derive(FromArgs)]
pub struct Args {
    /// smaller pictures and fewer of them
    #[argh(switch)]
    quick: bool,

    /// list the rows
    #[argh(switch)]
    list: bool,

    /// only this row; may be given several times
    #[argh(option)]
    row: Vec<String>,

    /// height of the pictures in pixels (240, or 144 with --quick); they are 16:9
    #[argh(option, from_str_fn(size))]
    size: Option<u32>,

    /// frames of each app that are timed (48, or 8 with --quick)
    #[argh(option, from_str_fn(frames))]
    frames: Option<u32>,

    /// folder for the CSV (target/mirror_cost)
    #[argh(option)]
    out: Option<PathBuf>,

    /// write what the apps draw there as well
    #[argh(switch)]
    pictures: bool,
}

/// What is to be measured.
#[derive(Clone)]
pub struct Plan {
    pub rows: Vec<Row>,
    pub height: u32,
    pub frames: u32,
    pub out: PathBuf,
    pub pictures: bool,
}

impl Plan {
    /// A line that says so.
    pub fn about(&self) -> String {
        format!(
            "pictures {} x {}, one sample a pixel, {} frames of each app, interleaved",
            self.height * 16 / 9,
            self.height,
            self.frames,
        )
    }
}

/// Reads the command line. `Err` has said on the terminal what there was to say.
pub fn parse() -> Result<Plan, ExitCode> {
    let args: Args = cli::parse()?;
    if args.list {
        for row in rows::all() {
            println!("{:15} {}", row.name, row.compared);
        }
        return Err(ExitCode::SUCCESS);
    }
    args.plan().map_err(|line| cli::complain(&line))
}

impl Args {
    fn plan(self) -> Result<Plan, String> {
        let all = rows::all();
        for name in &self.row {
            if !all.iter().any(|row| row.name == name) {
                return Err(format!("--row: there is no {name:?}; --list lists them"));
            }
        }
        let wanted =
            |row: &Row| self.row.is_empty() || self.row.iter().any(|name| name == row.name);
        let or = |value: Option<u32>, quick, full| {
            value.unwrap_or(if self.quick { quick } else { full })
        };
        Ok(Plan {
            rows: all.into_iter().filter(wanted).collect(),
            height: or(self.size, 144, 240),
            frames: or(self.frames, 8, 48),
            out: self.out.unwrap_or_else(|| "target/mirror_cost".into()),
            pictures: self.pictures,
        })
    }
}

fn size(text: &str) -> Result<u32, String> {
    cli::within(text, 48..=1080, "48 to 1080 pixels, as in 240")
}

fn frames(text: &str) -> Result<u32, String> {
    cli::within(text, 1..=10_000, "1 to 10000 frames, as in 48")
}
