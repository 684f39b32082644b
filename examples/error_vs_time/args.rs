//! The command line.

use std::{path::PathBuf, process::ExitCode};

use argh::FromArgs;

use crate::{
    scenes::{self, Case},
    shared::cli,
    truth,
};

/// Error against run time of ways to draw a planar mirror: a table, a CSV and a chart.
#[derive(FromArgs)]
pub struct Args {
    /// a few scenes in small pictures, in some minutes without a GPU
    #[argh(switch)]
    quick: bool,

    /// list the scenes
    #[argh(switch)]
    list: bool,

    /// only this scene; may be given several times
    #[argh(option)]
    scene: Vec<String>,

    /// height of the pictures in pixels (360, or 144 with --quick); each scene has its own ratio
    #[argh(option, from_str_fn(size))]
    size: Option<u32>,

    /// frames of each technique that are timed (40, or 6 with --quick)
    #[argh(option, from_str_fn(frames))]
    frames: Option<u32>,

    /// folder for the CSV and the chart (target/error_vs_time)
    #[argh(option)]
    out: Option<PathBuf>,

    /// write the pictures of all techniques there as well
    #[argh(switch)]
    pictures: bool,
}

/// What is to be measured.
pub struct Plan {
    pub cases: Vec<Case>,
    pub height: u32,
    pub frames: u32,
    pub out: PathBuf,
    pub pictures: bool,
}

impl Plan {
    /// A line that says so.
    pub fn about(&self) -> String {
        format!(
            "pictures {} pixels high, {} frames each, interleaved; reference {} samples a pixel",
            self.height,
            self.frames,
            truth::SAMPLES * truth::SAMPLES,
        )
    }
}

/// Reads the command line. `Err` has said on the terminal what there was to say.
pub fn parse() -> Result<Plan, ExitCode> {
    let args: Args = cli::parse()?;
    if args.list {
        print!("{}", list());
        return Err(ExitCode::SUCCESS);
    }
    args.plan().map_err(|line| cli::complain(&line))
}

impl Args {
    fn plan(self) -> Result<Plan, String> {
        let all = scenes::all();
        for name in &self.scene {
            if !all.iter().any(|case| case.name == name) {
                return Err(format!("--scene: there is no {name:?}; --list lists them"));
            }
        }
        let wanted = |case: &Case| {
            if self.scene.is_empty() {
                case.quick || !self.quick
            } else {
                self.scene.iter().any(|name| name == case.name)
            }
        };
        let or = |value: Option<u32>, quick, full| {
            value.unwrap_or(if self.quick { quick } else { full })
        };
        let height = or(self.size, 144, 360);
        Ok(Plan {
            cases: all
                .into_iter()
                .filter(wanted)
                .map(|case| case.sized(height))
                .collect(),
            height,
            frames: or(self.frames, 6, 40),
            out: self.out.unwrap_or_else(|| "target/error_vs_time".into()),
            pictures: self.pictures,
        })
    }
}

fn list() -> String {
    let line = |case: &Case| {
        let quick = if case.quick { " (also quick)" } else { "" };
        format!("{:18} {}{quick}\n", case.name, case.about)
    };
    scenes::all().iter().map(line).collect()
}

fn size(text: &str) -> Result<u32, String> {
    cli::within(text, 48..=1080, "48 to 1080 pixels, as in 360")
}

fn frames(text: &str) -> Result<u32, String> {
    cli::within(text, 1..=1000, "1 to 1000 frames, as in 40")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(args: &[&str]) -> Result<Plan, String> {
        Args::from_args(&["error_vs_time"], args)
            .map_err(|exit| exit.output)
            .and_then(Args::plan)
    }

    #[test]
    fn quick_is_fewer_scenes_and_smaller_pictures() {
        let (quick, full) = (
            plan(&["--quick"]).unwrap_or_else(|e| panic!("{e}")),
            plan(&[]),
        );
        let full = full.unwrap_or_else(|e| panic!("{e}"));
        assert!(quick.cases.len() < full.cases.len());
        assert!(quick.height < full.height && quick.frames < full.frames);
        assert_eq!(full.cases.len(), scenes::all().len());
    }

    #[test]
    fn a_scene_by_name_is_that_scene_alone() {
        let plan = plan(&["--quick", "--scene", "fov-1"]).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(plan.cases.len(), 1);
        assert_eq!(plan.cases[0].name, "fov-1");
    }

    #[test]
    fn what_makes_no_sense_is_told_what_does() {
        let wrong: [(&[&str], &str); 6] = [
            (&["--scene", "nowhere"], "--list"),
            (&["--size", "0"], "48 to 1080"),
            (&["--size", "wide"], "48 to 1080"),
            (&["--frames", "-3"], "1 to 1000"),
            (&["--frames"], "--frames"),
            (&["--fast"], "--fast"),
        ];
        for (args, says) in wrong {
            let error = plan(args)
                .err()
                .unwrap_or_else(|| panic!("{args:?} is taken"));
            assert!(error.contains(says), "{args:?}: {error}");
        }
    }

    #[test]
    fn the_list_names_every_scene() {
        for case in scenes::all() {
            assert!(list().contains(case.name));
        }
    }
}
