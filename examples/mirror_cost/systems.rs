//! How long the plugin's systems in the main world take, alone and on one thread.

use std::{f32::consts::PI, time::Instant};

use bevy::{
    camera::{primitives::Aabb, visibility::InheritedVisibility},
    prelude::*,
};
use bevy_planar_mirror::{PlanarMirrorPlugin, status::MirrorStatus};

use crate::{
    alone::{app, mesh, spawn_camera, spawn_mirror},
    args::Plan,
    contest::{Failure, Measured, Outcome},
    estimate::{Estimate, Part},
};

const MIRRORS: u16 = 1000;
const THINGS: u16 = 10_000;

/// Microseconds of an update with a thousand mirrors that nobody sees, less those of the same app
/// without the plugin.
pub fn of_unseen_mirrors(plan: &Plan) -> Outcome {
    let mut apps = [mirror_app(), app(|_| {})];
    for app in &mut apps {
        spawn_camera(app);
        spawn_mirrors(app);
    }
    of_updates(plan, apps, false, format!("{MIRRORS} mirrors"))
}

/// Microseconds of an update with a mirror and ten thousand things, a hundred of them large, that
/// might hide it and do not, less those of an app with the mirror alone.
pub fn of_walls(plan: &Plan) -> Outcome {
    let mut apps = [mirror_app(), mirror_app()];
    for app in &mut apps {
        app.insert_resource(Assets::<StandardMaterial>::default());
        spawn_camera(app);
        let mesh = mesh(app);
        spawn_mirror(app, mesh, Transform::default());
    }
    spawn_things(&mut apps[0]);
    of_updates(plan, apps, true, format!("{THINGS} things"))
}

fn mirror_app() -> App {
    app(|app| {
        app.add_plugins(PlanarMirrorPlugin::default());
    })
}

/// What an update of the first app takes beyond one of the second.
fn of_updates(plan: &Plan, mut apps: [App; 2], is_drawn: bool, details: String) -> Outcome {
    for app in &mut apps {
        for _ in 0..5 {
            app.update();
        }
    }
    let world = apps[0].world_mut();
    let mut statuses = world.query::<&MirrorStatus>();
    if statuses
        .iter(world)
        .any(|status| status.is_drawn() != is_drawn)
    {
        return Err(Failure::Reason("a mirror is seen or is not".to_owned()));
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
        details,
        pictures: Vec::new(),
    })
}

/// Cubes all over the room between the camera and the mirror; every hundredth is large on the
/// screen.
fn spawn_things(app: &mut App) {
    let mesh = Mesh::from(Cuboid::from_length(1.0));
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
    let mut materials = app.world_mut().resource_mut::<Assets<StandardMaterial>>();
    let material = materials.add(StandardMaterial::default());
    for i in 0..THINGS {
        // A sequence of low discrepancy, which leaves no part of the room empty.
        let share = |ratio: f32| (f32::from(i) * ratio).fract() - 0.5;
        let place = Vec3::new(
            share(0.819_17) * 6.0,
            share(0.671_04) * 4.0,
            1.0 + share(0.549_7),
        );
        let size = if i % 100 == 0 { 0.3 } else { 0.02 };
        let transform = Transform::from_translation(place).with_scale(Vec3::splat(size));
        app.world_mut().spawn((
            Mesh3d(mesh.clone()),
            MeshMaterial3d(material.clone()),
            transform,
            GlobalTransform::from(transform),
            InheritedVisibility::VISIBLE,
            Aabb::from_min_max(Vec3::splat(-0.5), Vec3::splat(0.5)),
        ));
    }
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
