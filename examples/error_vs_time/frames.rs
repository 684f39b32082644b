//! Single frames, and where their time goes.

use std::time::Instant;

use bevy::{camera::visibility::VisibilitySystems, prelude::*, transform::TransformSystems};
use bevy_planar_mirror::MirrorSystems;

use crate::{
    spans::{Reader, Spans},
    support::stage::Stage,
};

/// Updates until meshes, textures and pipelines are made and retained phases are filled.
const SETTLING: usize = 4;

/// Of one frame, in milliseconds.
#[derive(Clone, Copy, Debug, Default)]
pub struct FrameTimes {
    /// From the start of the update to the last pixel.
    pub whole: f64,
    /// CPU: the main world's schedules, extraction, the render world's schedules up to the
    /// submission of all work.
    pub main: f64,
    pub extract: f64,
    pub render: f64,
    /// The plugin's steps in the main world; `None` without it.
    pub plugin: Option<f64>,
}

/// One update in the phases of `App::update`, timed.
pub fn timed(stage: &mut Stage) -> Result<FrameTimes, String> {
    let mut times = FrameTimes::default();
    let start = Instant::now();
    stage.try_frame(|app| {
        let apps = app.sub_apps_mut();
        let phase = Instant::now();
        apps.main.run_default_schedule();
        times.main = milliseconds(phase);
        for sub_app in apps.sub_apps.values_mut() {
            let phase = Instant::now();
            sub_app.extract(apps.main.world_mut());
            times.extract += milliseconds(phase);
            let phase = Instant::now();
            sub_app.update();
            times.render += milliseconds(phase);
        }
        apps.main.world_mut().clear_trackers();
    })?;
    times.whole = milliseconds(start);
    times.plugin = stage
        .world()
        .get_resource::<PluginClock>()
        .map(|clock| clock.milliseconds);
    Ok(times)
}

/// Updates until nothing is waited for any more.
pub fn settle(stage: &mut Stage) -> Result<(), String> {
    const PATIENCE: usize = 100;
    for _ in 0..PATIENCE {
        for _ in 0..SETTLING {
            stage.try_frame(App::update)?;
        }
        if stage.waiting_pipelines() == 0 {
            return Ok(());
        }
    }
    Err(format!(
        "{} pipelines never got ready",
        stage.waiting_pipelines()
    ))
}

/// Updates until diagnostics of a frame after this call have come back.
pub fn spans(stage: &mut Stage) -> Result<Spans, String> {
    let mut reader = Reader::default();
    reader.read(stage.world().resource());
    let mut newest = None;
    for _ in 0..6 {
        stage.try_frame(App::update)?;
        newest = reader.read(stage.world().resource()).or(newest);
    }
    newest.ok_or_else(|| "the engine's diagnostics never came".to_owned())
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

/// How long the plugin's steps in `PostUpdate` took in the last update.
///
/// Its systems are its own, but their sets are public: a clock starts when all that a set waits
/// for is done and stops when the set is. Whatever the engine runs beside them in that time is
/// counted too, so this is what they take at most.
#[derive(Resource, Default)]
pub struct PluginClock {
    milliseconds: f64,
    running: Option<Instant>,
}

/// Times the steps of the plugin; for apps that have it.
pub fn clock_plugin(app: &mut App) {
    let start = |mut clock: ResMut<PluginClock>| clock.running = Some(Instant::now());
    let stop = |mut clock: ResMut<PluginClock>| {
        if let Some(start) = clock.running.take() {
            clock.milliseconds += milliseconds(start);
        }
    };
    app.init_resource::<PluginClock>()
        .add_systems(First, |mut clock: ResMut<PluginClock>| {
            clock.milliseconds = 0.0;
        })
        .add_systems(
            PostUpdate,
            (
                start
                    .after(TransformSystems::Propagate)
                    .after(bevy::camera::CameraUpdateSystems)
                    .after(VisibilitySystems::UpdateFrusta)
                    .after(VisibilitySystems::VisibilityPropagate)
                    .after(VisibilitySystems::CalculateBounds)
                    .before(MirrorSystems::UpdateViews),
                stop.after(MirrorSystems::UpdateViews)
                    .before(VisibilitySystems::CheckVisibility),
                start
                    .after(bevy::camera::visibility::check_visibility_cpu_culling)
                    .before(MirrorSystems::SeeViews),
                stop.after(MirrorSystems::SeeViews)
                    .before(MirrorSystems::NarrowShadows),
            ),
        );
}
