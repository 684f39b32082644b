//! The plugin in all sorts of apps.

use std::path::Path;

use bevy::{
    asset::io::AssetSourceId,
    diagnostic::FrameCountPlugin,
    log::LogPlugin,
    prelude::*,
    render::{
        RenderApp, RenderPlugin, pipelined_rendering::PipelinedRenderingPlugin,
        settings::WgpuSettings,
    },
    tasks::block_on,
    time::TimePlugin,
    window::ExitCondition,
    winit::WinitPlugin,
};
use bevy_planar_mirror::{MirrorStatus, NotDrawn, PlanarMirror, PlanarMirrorPlugin};

use super::app::{
    EYE, logged_mirror_app_without_renderer, mirror_app, not, spawn_camera, spawn_mirror,
    stand_in_renderer,
};

/// `DefaultPlugins` on a machine that draws nothing.
fn default_plugins() -> impl PluginGroup {
    DefaultPlugins
        .set(WindowPlugin {
            primary_window: None,
            exit_condition: ExitCondition::DontExit,
            ..default()
        })
        .set(RenderPlugin {
            render_creation: WgpuSettings {
                backends: None,
                ..default()
            }
            .into(),
            ..default()
        })
        .disable::<WinitPlugin>()
        .disable::<LogPlugin>()
        .disable::<PipelinedRenderingPlugin>()
        .disable::<bevy::app::TerminalCtrlCHandlerPlugin>()
}

/// Runs an app with a mirror in it.
fn run(mut app: App) -> Option<bevy_planar_mirror::MirrorState> {
    app.finish();
    app.cleanup();
    let (mirror, camera) = (
        spawn_mirror(&mut app, default()),
        spawn_camera(&mut app, EYE),
    );
    for _ in 0..3 {
        app.update();
    }
    app.world().get::<MirrorStatus>(mirror)?.of(camera)
}

#[test]
fn it_may_be_added_before_or_after_the_default_plugins() {
    let mut app = App::new();
    app.add_plugins((default_plugins(), PlanarMirrorPlugin::default()));
    assert_eq!(run(app), not(NotDrawn::NoRenderer));
    let mut app = App::new();
    app.add_plugins((PlanarMirrorPlugin::default(), default_plugins()));
    assert_eq!(run(app), not(NotDrawn::NoRenderer));
}

/// The names of the plugin's own shaders in the app's embedded assets.
fn shaders(app: &App) -> Vec<String> {
    let assets = app.world().resource::<AssetServer>();
    let source = assets
        .get_source(AssetSourceId::from("embedded"))
        .expect("assets are there");
    let mut names: Vec<String> = ["mask.wgsl", "shadow.wgsl"]
        .into_iter()
        .filter(|name| {
            let path = Path::new("bevy_planar_mirror/render").join(name);
            block_on(source.reader().read(&path)).is_ok()
        })
        .map(str::to_owned)
        .collect();
    names.sort();
    names
}

#[test]
fn its_shaders_are_there_in_whichever_order_it_is_added() {
    let base = || (TaskPoolPlugin::default(), AssetPlugin::default());
    let mut after = App::new();
    after.add_plugins((base(), PlanarMirrorPlugin::default()));
    let mut before = App::new();
    before.add_plugins((PlanarMirrorPlugin::default(), base()));
    for app in [&mut after, &mut before] {
        app.insert_sub_app(RenderApp, stand_in_renderer());
        app.finish();
        app.cleanup();
    }
    assert_eq!(shaders(&after), ["mask.wgsl", "shadow.wgsl"]);
    assert_eq!(shaders(&before), shaders(&after));
}

#[test]
fn without_a_renderer_it_says_so_and_makes_no_views() {
    let mut app = logged_mirror_app_without_renderer();
    let mirrors = [0.0, 0.5].map(|x| app.spawn_mirror(Transform::from_xyz(x, 0.0, 0.1 * x)));
    let camera = app.spawn_camera(EYE);
    app.updates(3);
    for mirror in mirrors {
        app.assert_state(mirror, camera, not(NotDrawn::NoRenderer));
    }
    assert!(app.views().is_empty());
    let lines = app.log_lines();
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert!(
        lines[0].text.contains("RenderPlugin"),
        "it names the remedy: {lines:?}"
    );
}

#[test]
fn an_app_without_meshes_cameras_or_anything_runs() {
    let mut app = App::new();
    app.add_plugins(PlanarMirrorPlugin::default());
    app.finish();
    app.cleanup();
    let mirror = app.world_mut().spawn(PlanarMirror::default()).id();
    app.update();
    app.update();
    assert_eq!(
        app.world().get::<MirrorStatus>(mirror),
        Some(&MirrorStatus::default())
    );
}

#[test]
fn an_app_with_cameras_but_without_meshes_runs() {
    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        FrameCountPlugin,
        TimePlugin,
        TransformPlugin,
        PlanarMirrorPlugin::default(),
    ));
    app.insert_sub_app(RenderApp, stand_in_renderer());
    app.finish();
    app.cleanup();
    let mirror = app
        .world_mut()
        .spawn((
            PlanarMirror::default(),
            Mesh3d::default(),
            InheritedVisibility::VISIBLE,
        ))
        .id();
    let camera = app.world_mut().spawn((Camera3d::default(), EYE)).id();
    app.update();
    app.update();
    let status = app.world().get::<MirrorStatus>(mirror);
    assert_eq!(
        status.and_then(|status| status.of(camera)),
        not(NotDrawn::NoMesh)
    );
}

#[test]
fn mirrors_may_be_there_before_the_first_frame_and_cameras_later() {
    let mut app = mirror_app();
    let mirror = app.spawn_mirror(default());
    app.updates(2);
    assert!(app.views().is_empty());
    let camera = app.spawn_camera(EYE);
    app.update();
    app.view(camera, mirror);
}
