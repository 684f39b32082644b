//! What a scene does not need does not exist: counted in running apps, feature by feature.
//!
//! A full scene and the same scene with one thing less, each in an app of its own, beside the same
//! scene in an app without the plugin. What is counted is what the plugin adds.

use std::{any::TypeId, collections::HashSet, path::Path};

use bevy::{
    camera::{RenderTarget, Viewport, visibility::VisibleEntities},
    core_pipeline::Skybox,
    ecs::entity_disabling::Disabled,
    pbr::{Shadow, ViewLightEntities},
    prelude::*,
    render::{
        diagnostic::RenderDiagnosticsPlugin, render_phase::ViewBinnedRenderPhases,
        view::ExtractedView,
    },
};
use bevy_planar_mirror::PlanarMirrorPlugin;

use crate::{
    attempt::attempt,
    frames,
    memory::Memory,
    shared::table::aligned,
    spans::Spans,
    support::{
        props::{add, at, glass, lit, six_colors, spot, sun},
        scene::{Scene, Surface},
        set::{build_plain, build_with_mirrors},
        stage::Stage,
    },
};

const SIZE: UVec2 = UVec2::new(320, 180);

/// What the full scene has and a row can lack.
#[derive(Clone, Copy)]
struct Parts {
    lights: bool,
    shadows: bool,
    skybox: bool,
    transparent: bool,
    straddler: bool,
    samples: Msaa,
    mirrors: usize,
    cameras: usize,
    in_view: bool,
}

const FULL: Parts = Parts {
    lights: true,
    shadows: true,
    skybox: true,
    transparent: true,
    straddler: true,
    samples: Msaa::Sample4,
    mirrors: 2,
    cameras: 2,
    in_view: true,
};

fn rows() -> Vec<(&'static str, Parts)> {
    let less = |less: fn(&mut Parts)| {
        let mut parts = FULL;
        less(&mut parts);
        parts
    };
    vec![
        ("everything", FULL),
        (
            "no lights",
            less(|parts| (parts.lights, parts.shadows) = (false, false)),
        ),
        ("no shadows", less(|parts| parts.shadows = false)),
        ("no skybox", less(|parts| parts.skybox = false)),
        (
            "nothing transparent",
            less(|parts| parts.transparent = false),
        ),
        ("nothing straddles", less(|parts| parts.straddler = false)),
        ("no MSAA", less(|parts| parts.samples = Msaa::Off)),
        ("one mirror", less(|parts| parts.mirrors = 1)),
        ("one camera", less(|parts| parts.cameras = 1)),
        ("no mirror in view", less(|parts| parts.in_view = false)),
        ("no mirror", less(|parts| parts.mirrors = 0)),
    ]
}

/// What the plugin adds to a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Added {
    /// The plugin's systems that ran in the frame.
    systems: i64,
    /// Reflected views.
    views: i64,
    /// Meshes drawn in them.
    meshes: i64,
    /// Shadow cascades into which something is drawn.
    cascades: i64,
    /// Passes that the engine's diagnostics know.
    passes: i64,
    /// Pipelines of the plugin.
    pipelines: i64,
    /// Its own textures and buffers.
    allocations: i64,
    own_bytes: i64,
    /// All that the device holds.
    bytes: i64,
}

impl Added {
    fn fields(&self) -> Vec<String> {
        let kib = |bytes: i64| (bytes as f64 / 1024.0).round().to_string();
        let mut fields: Vec<String> = [
            self.systems,
            self.views,
            self.meshes,
            self.cascades,
            self.passes,
            self.pipelines,
            self.allocations,
        ]
        .map(|count| count.to_string())
        .to_vec();
        fields.extend([kib(self.own_bytes), kib(self.bytes)]);
        fields
    }
}

const HEAD: [&str; 10] = [
    "without",
    "systems",
    "views",
    "meshes",
    "cascades",
    "passes",
    "pipelines",
    "allocations",
    "own KiB",
    "all KiB",
];

/// The table, also written as `leave_out.csv`.
pub fn table(folder: &Path) -> Result<String, String> {
    let mut lines = vec![HEAD.map(str::to_owned).to_vec()];
    for (name, parts) in rows() {
        let mut line = vec![name.to_owned()];
        match attempt(|| added(parts)) {
            Ok(added) => line.extend(added.fields()),
            Err(reason) => line.push(reason.split_whitespace().collect::<Vec<_>>().join(" ")),
        }
        lines.push(line);
    }
    let csv: String = lines
        .iter()
        .map(|line| line.join(",").replace('\n', " ") + "\n")
        .collect();
    let path = folder.join("leave_out.csv");
    std::fs::write(&path, csv).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(aligned(&lines))
}

fn added(parts: Parts) -> Result<Added, String> {
    let mut plain = Stage::new(|app| {
        app.add_plugins(RenderDiagnosticsPlugin);
    });
    build(&mut plain, parts, false);
    let without = count(&mut plain, &HashSet::new())?;
    let known = systems(&mut plain);
    drop(plain);
    let mut stage = Stage::new(|app| {
        app.add_plugins((RenderDiagnosticsPlugin, PlanarMirrorPlugin::default()));
    });
    build(&mut stage, parts, true);
    let with = count(&mut stage, &known)?;
    Ok(Added {
        cascades: with.cascades - without.cascades,
        passes: with.passes - without.passes,
        bytes: with.bytes - without.bytes,
        ..with
    })
}

fn build(stage: &mut Stage, parts: Parts, mirrors: bool) {
    let mut scene = scene(parts);
    let target = stage.target(SIZE);
    let half = UVec2::new(SIZE.x / parts.cameras as u32, SIZE.y);
    let viewport = move |x: u32| Viewport {
        physical_position: UVec2::new(x, 0),
        physical_size: half,
        ..default()
    };
    scene = scene.touch_camera(move |camera| {
        if let Some(mut camera) = camera.get_mut::<Camera>() {
            camera.viewport = Some(viewport(0));
        }
    });
    if mirrors {
        build_with_mirrors(stage, &scene, target.clone());
    } else {
        build_plain(stage, &scene, target.clone());
    }
    if parts.cameras > 1 {
        let mut second = stage.world().spawn((
            scene.camera_bundle(),
            RenderTarget::from(target),
            Transform::from_xyz(1.5, 1.8, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
        ));
        for touch in &scene.camera {
            touch(&mut second);
        }
        if let Some(mut camera) = second.get_mut::<Camera>() {
            camera.order = 1;
            camera.viewport = Some(viewport(half.x));
        }
    }
}

fn scene(parts: Parts) -> Scene {
    let mut scene = Scene::new("leave-out")
        .eye(Vec3::new(0.0, 1.6, 4.0), Vec3::new(0.0, 0.2, 0.0))
        .object(
            Sphere::new(0.5).mesh().uv(32, 18),
            lit(Color::srgb(0.9, 0.5, 0.4)),
            at(-0.9, 0.8, 0.2),
        )
        .object(
            Cuboid::from_length(0.6),
            lit(Color::srgb(0.4, 0.6, 0.9)),
            at(0.9, 0.6, 0.3),
        );
    scene.size = SIZE;
    scene.msaa = parts.samples;
    let place = if parts.in_view { 0.0 } else { 20.0 };
    let mirrors = [
        Surface::floor(3.0, 3.0, at(0.0, 0.0, place)),
        Surface::wall(3.0, 2.0, at(0.0, 1.2, place - 1.8)),
    ];
    scene
        .mirrors
        .extend(mirrors.into_iter().take(parts.mirrors));
    if parts.straddler {
        scene = scene.object(
            Cuboid::new(0.3, 1.2, 0.3),
            lit(Color::srgb(0.5, 0.8, 0.4)),
            at(0.0, 0.2, 0.6),
        );
    }
    if parts.transparent {
        scene = scene.object(
            Cuboid::new(0.5, 0.5, 0.05),
            glass(Color::srgb(0.3, 0.5, 1.0), 0.5),
            at(0.2, 0.9, 1.0),
        );
    }
    if parts.lights {
        scene = scene.prop(sun(parts.shadows)).prop(spot(
            Vec3::new(1.5, 3.0, 2.0),
            Vec3::ZERO,
            parts.shadows,
        ));
    } else {
        scene.ambient.brightness = 400.0;
    }
    if parts.skybox {
        scene = scene.touch_camera(|camera| {
            let image = add(camera, six_colors());
            camera.insert(Skybox {
                image: Some(image),
                brightness: 600.0,
                ..default()
            });
        });
    }
    scene
}

fn count(stage: &mut Stage, known: &HashSet<Name>) -> Result<Added, String> {
    frames::settle(stage)?;
    let Spans(spans) = frames::spans(stage)?;
    let ran = systems_that_ran(stage, known)?;
    let (mut views, mut meshes) = (0, 0);
    let world = stage.world();
    let mut reflected =
        world.query_filtered::<&VisibleEntities, (With<Camera3d>, With<Disabled>)>();
    for visible in reflected.iter(world) {
        views += 1;
        meshes += visible.get(TypeId::of::<Mesh3d>()).len() as i64;
    }
    let render = stage.render_world();
    let mut lights = render.query::<&ViewLightEntities>();
    let phases = render.resource::<ViewBinnedRenderPhases<Shadow>>();
    let cascades = lights
        .iter(render)
        .flat_map(|view| &view.lights)
        .filter_map(|light| render.get::<ExtractedView>(*light))
        .filter_map(|view| phases.get(&view.retained_view_entity))
        .filter(|phase| !phase.is_empty())
        .count() as i64;
    let own = |label: &&String| label.starts_with("planar_mirror");
    let labels = stage.pipeline_labels();
    let memory = Memory::of(stage).unwrap_or_default();
    let (allocations, own_bytes) = memory.labeled("planar_mirror");
    Ok(Added {
        systems: ran,
        views,
        meshes,
        cascades,
        passes: spans.values().map(|span| span.count as i64).sum(),
        pipelines: labels.iter().filter(own).count() as i64,
        allocations: allocations as i64,
        own_bytes: own_bytes as i64,
        bytes: memory.bytes as i64,
    })
}

/// A system by its schedule and its type.
type Name = (String, TypeId);

fn systems(stage: &mut Stage) -> HashSet<Name> {
    let mut names = of_schedules(stage.world(), |_| true);
    names.extend(of_schedules(stage.render_world(), |_| true));
    names.into_iter().collect()
}

/// How many systems that are not `known` ran in one more frame.
fn systems_that_ran(stage: &mut Stage, known: &HashSet<Name>) -> Result<i64, String> {
    let before = [
        stage.world().change_tick(),
        stage.render_world().change_tick(),
    ];
    stage.try_frame(App::update)?;
    let mut count = 0;
    for (before, is_main) in before.into_iter().zip([true, false]) {
        let world = if is_main {
            stage.world()
        } else {
            stage.render_world()
        };
        let now = world.change_tick();
        let ran = of_schedules(world, |system| {
            system.get_last_run().is_newer_than(before, now)
        });
        count += ran.iter().filter(|name| !known.contains(*name)).count() as i64;
    }
    Ok(count)
}

fn of_schedules(
    world: &World,
    wanted: impl Fn(&bevy::ecs::system::ScheduleSystem) -> bool,
) -> Vec<Name> {
    let schedules = world.resource::<Schedules>();
    let mut names = Vec::new();
    for (label, schedule) in schedules.iter() {
        // One that has never run has no systems yet.
        let Ok(systems) = schedule.systems() else {
            continue;
        };
        for (_, system) in systems.filter(|(_, system)| wanted(system)) {
            names.push((format!("{label:?}"), system.system_type()));
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_lacks_something_that_the_full_scene_has() {
        let parts = |parts: Parts| {
            let scene = scene(parts);
            (
                scene.props.len(),
                parts.shadows,
                scene.camera.len(),
                scene.objects.len(),
                scene.msaa,
                scene.mirrors.len(),
                parts.cameras,
                parts.in_view,
            )
        };
        for (index, (name, row)) in rows().into_iter().enumerate() {
            assert_eq!(parts(row) == parts(FULL), index == 0, "{name}");
        }
        assert_eq!(Added::default().fields().len() + 1, HEAD.len());
    }
}
