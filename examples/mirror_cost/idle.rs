//! A thousand mirrors that nobody sees: how long the plugin's systems in the main world take.

use std::{f32::consts::PI, time::Instant};

use bevy::prelude::*;
use bevy_planar_mirror::{PlanarMirrorPlugin, status::MirrorStatus};

use crate::{
    alone::{app, mesh, spawn_camera, spawn_mirror},
    args::Plan,
    contest::{Failure, Measured, Outcome},
    estimate::{Estimate, Part},
};

const MIRRORS: u16 = 1000;

/// Microseconds of an update with the plugin's systems alone, on one thread, less those of the same
/// app without the plugin.
pub fn measure(plan: &Plan) -> Outcome {
    let mut apps = [
        app(|app| {
            app.add_plugins(PlanarMirrorPlugin::default());
        }),
        app(|_| {}),
    ];
    for app in &mut apps {
        spawn_camera(app);
        spawn_mirrors(app);
        for _ in 0..5 {
            app.update();
        }
    }
    let world = apps[0].world_mut();
    let mut statuses = world.query::<&MirrorStatus>();
    if statuses.iter(world).any(MirrorStatus::is_drawn) {
        return Err(Failure::Reason("a mirror is seen".to_owned()));
    }
    let mut timed = |index: usize| {
        let begin = Instant::now();
        apps[index].update();
        begin.elapsed().as_secs_f64() * 1e6
    };
    let rounds = (0..plan.frames * 10).map(|_| Part {
        of: timed(0) - timed(1),
        by: 1.0,
    });
    let nothing = || Failure::Reason("nothing was measured".into());
    Ok(Measured {
        estimate: Estimate::of(&rounds.collect::<Vec<_>>()).ok_or_else(nothing)?,
        details: format!("{MIRRORS} mirrors"),
        pictures: Vec::new(),
    })
}

/// Every other one shows the camera its back, the rest are behind it.
fn spawn_mirrors(app: &mut App) {
    let mesh = mesh(app);
    for i in 0..MIRRORS {
        let (column, row) = (f32::from(i % 40), f32::from(i / 40));
        let depth = if i % 2 == 0 { 0.0 } else { 10.0 };
        let place = Transform::from_xyz(column * 0.05 - 1.0, row * 0.05 - 0.6, depth)
            .with_rotation(Quat::from_rotation_y(PI));
        spawn_mirror(app, mesh.clone(), place);
    }
}
