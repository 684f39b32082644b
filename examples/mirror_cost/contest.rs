//! Several apps that take turns, frame by frame.

use bevy::prelude::*;
use bevy_planar_mirror::{PlanarMirrorPlugin, status::MirrorFigures};

use crate::{
    args::Plan,
    estimate::{Estimate, Part},
    frames::{self, FrameTimes},
    rival,
    stats::Summary,
    support::{
        picture::Picture,
        scene::Scene,
        set::{build_plain, build_with_mirrors},
        stage::Stage,
    },
};

/// How an app draws the mirrors of its scene.
#[derive(Clone, Copy, PartialEq)]
pub enum How {
    /// Bevy without the plugin: their meshes, as they are.
    Without,
    Mirrors {
        max_bounces: u8,
    },
    /// Its one mirror by a second camera into an image of the picture's size.
    SecondCamera,
}

pub const MIRRORS: How = How::Mirrors { max_bounces: 1 };

/// One app of a row.
pub struct Side {
    pub name: &'static str,
    pub how: How,
    pub scene: Scene,
}

pub fn side(name: &'static str, how: How, scene: &Scene) -> Side {
    let scene = scene.clone();
    Side { name, how, scene }
}

/// What a row says.
pub struct Measured {
    pub estimate: Estimate,
    /// What it is made of, for the CSV.
    pub details: String,
    /// What the apps drew, by name, if it was asked for.
    pub pictures: Vec<(&'static str, Picture)>,
}

/// Why a row says nothing.
pub enum Failure {
    /// The user has asked to stop.
    Interrupted,
    Reason(String),
}

pub type Outcome = Result<Measured, Failure>;

impl From<String> for Failure {
    fn from(reason: String) -> Self {
        Self::Reason(reason)
    }
}

/// Times frames of each side, as many as the plan says. `part` makes of the milliseconds of one
/// round, in the order of the sides, what is compared.
pub fn measure(
    plan: &Plan,
    sides: &[Side],
    clock: fn(&FrameTimes) -> f64,
    part: impl Fn(&[f64]) -> Part,
) -> Outcome {
    let mut times = vec![Vec::new(); sides.len()];
    let mut details = vec![String::new(); sides.len()];
    let mut pictures = Vec::new();
    // Whatever it is that makes apps faster or slower by when they were started, it shall not count:
    // in the second half they start the other way around.
    let mut order: Vec<usize> = (0..sides.len()).collect();
    for rounds in [plan.frames.div_ceil(2), plan.frames / 2] {
        let mut stages: Vec<(usize, Stage)> = Vec::new();
        for &index in &order {
            let side = &sides[index];
            let mut stage = start(side.how);
            let target = set_up(&mut stage, side);
            frames::settle(&mut stage)?;
            if plan.pictures && pictures.len() < sides.len() {
                let picture = stage.read(&target, side.scene.size);
                pictures.push((side.name, picture.map_err(|reason| reason.to_string())?));
            }
            stages.push((index, stage));
        }
        for _ in 0..rounds {
            stages.reverse();
            for (index, stage) in &mut stages {
                times[*index].push(clock(&frames::timed(stage)?));
                if stage.app().should_exit().is_some() {
                    return Err(Failure::Interrupted);
                }
            }
        }
        for (index, stage) in &mut stages {
            details[*index] = describe(&sides[*index], &times[*index], stage);
        }
        order.reverse();
    }
    let parts: Vec<Part> = (0..plan.frames as usize)
        .map(|round| part(&times.iter().map(|side| side[round]).collect::<Vec<_>>()))
        .collect();
    let nothing = || Failure::Reason("nothing was measured".into());
    Ok(Measured {
        estimate: Estimate::of(&parts).ok_or_else(nothing)?,
        details: details.join("; "),
        pictures,
    })
}

pub fn start(how: How) -> Stage {
    Stage::new(|app| match how {
        How::Without => {}
        How::Mirrors { max_bounces } => {
            app.add_plugins(PlanarMirrorPlugin {
                max_bounces,
                ..default()
            });
        }
        How::SecondCamera => rival::plugin(app),
    })
}

/// Returns what is drawn into.
fn set_up(stage: &mut Stage, side: &Side) -> Handle<Image> {
    let target = stage.target(side.scene.size);
    match side.how {
        How::Without => build_plain(stage, &side.scene, target.clone()),
        How::Mirrors { .. } => build_with_mirrors(stage, &side.scene, target.clone()),
        How::SecondCamera => rival::set_up(stage, &side.scene, 1.0, 1, true, &target),
    };
    target
}

/// Times, and of how many pixels each reflected view shows something.
fn describe(side: &Side, times: &[f64], stage: &mut Stage) -> String {
    let time = Summary::of(times).map_or(String::new(), |times| {
        format!(" {:.3} +- {:.3} ms", times.median, times.spread)
    });
    let figures = stage.world().get_resource::<MirrorFigures>();
    let pixels: String = figures
        .iter()
        .flat_map(|figures| &figures.views)
        .map(|view| format!(" {:.0}", view.pixels))
        .collect();
    let pixels = if pixels.is_empty() {
        pixels
    } else {
        format!(", pixels{pixels}")
    };
    format!("{}:{time}{pixels}", side.name)
}
