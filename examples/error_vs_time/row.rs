//! One row of the report: a technique with its samples in a scene.

use crate::{
    edge::Found,
    errors::{Errors, Things},
    stats::Summary,
    techniques::Technique,
};

/// What became of a technique in a scene.
#[derive(Clone, Debug)]
pub struct Row {
    pub scene: String,
    pub technique: Technique,
    /// The share of the picture that the mirror covers.
    pub share: f64,
    /// Or why there is nothing to measure.
    pub outcome: Result<Measured, String>,
}

/// Times are in milliseconds.
#[derive(Clone, Debug, Default)]
pub struct Measured {
    pub frame: Option<Summary>,
    /// All passes of the frame, by timestamps.
    pub gpu: Option<Summary>,
    /// The mirror's passes, by timestamps: its own pass where it has one, else all passes less
    /// those of the frame without a mirror.
    pub gpu_mirror: Option<f64>,
    pub cpu_main: Option<Summary>,
    pub cpu_extract: Option<Summary>,
    pub cpu_render: Option<Summary>,
    /// The plugin's steps in the main world, at most.
    pub cpu_plugin: Option<Summary>,
    /// Encoding the mirror's pass.
    pub cpu_pass: Option<Summary>,
    /// The frame to that without a mirror.
    pub to_none: Option<f64>,
    /// The frame to the least that a frame with the mirror can take.
    pub to_bound: Option<f64>,
    /// Bytes beyond those of the app without a mirror.
    pub memory: Option<i64>,
    pub errors: Option<Errors>,
    pub things: Option<Things>,
    pub cut: Option<Found>,
}

impl Row {
    pub fn measured(&self) -> Option<&Measured> {
        self.outcome.as_ref().ok()
    }

    /// Its place in a chart: milliseconds a frame, and root mean square error in levels.
    pub fn place(&self) -> Option<(f64, f64)> {
        let measured = self.measured()?;
        Some((measured.frame?.median, measured.errors?.rmse))
    }
}
