//! The command line.

use std::{collections::HashSet, path::PathBuf, process::ExitCode};

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

    /// only this scene; may be given several times. random-0, random-1 and so on are random scenes
    #[argh(option)]
    scene: Vec<String>,

    /// only so many random scenes, at the extremes of what a scene can be
    #[argh(option, from_str_fn(random))]
    random: Option<u64>,

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
        let mut cases: Vec<Case> = Vec::new();
        for name in &self.scene {
            let none = || format!("--scene: there is no {name:?}; --list lists them");
            cases.push(scenes::named(name).ok_or_else(none)?);
        }
        cases.extend((0..self.random.unwrap_or(0)).map(scenes::random));
        // However often it is named, a scene is one.
        let mut names = HashSet::new();
        cases.retain(|case| names.insert(case.name.clone()));
        if cases.is_empty() {
            cases = scenes::all();
            cases.retain(|case| case.quick || !self.quick);
        }
        let or = |value: Option<u32>, quick, full| {
            value.unwrap_or(if self.quick { quick } else { full })
        };
        let height = or(self.size, 144, 360);
        Ok(Plan {
            cases: cases.into_iter().map(|case| case.sized(height)).collect(),
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

fn random(text: &str) -> Result<u64, String> {
    cli::within(text, 1..=1000, "1 to 1000 scenes, as in 20")
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
    fn a_random_scene_has_a_name_to_be_drawn_again() {
        let both = plan(&["--random", "2"]).unwrap_or_else(|e| panic!("{e}"));
        let one = plan(&["--scene", "random-1"]).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((both.cases.len(), one.cases.len()), (2, 1));
        assert_eq!(both.cases[1].name, one.cases[0].name);
        assert_eq!(both.cases[1].scene.eye, one.cases[0].scene.eye);
        let again = plan(&["--random", "2", "--scene", "random-1"]);
        assert_eq!(again.unwrap_or_else(|e| panic!("{e}")).cases.len(), 2);
    }

    #[test]
    fn what_makes_no_sense_is_told_what_does() {
        let wrong: [(&[&str], &str); 8] = [
            (&["--scene", "nowhere"], "--list"),
            (&["--scene", "random-x"], "--list"),
            (&["--random", "0"], "1 to 1000"),
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
            assert!(list().contains(&case.name));
        }
    }
}
