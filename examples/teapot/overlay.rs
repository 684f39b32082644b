//! The text in the window: the keys with what they switch, and the mirror's status.

use bevy::{
    camera_controller::free_camera::FreeCameraState,
    diagnostic::{DiagnosticsStore, FrameTimeDiagnosticsPlugin},
    prelude::*,
};
use bevy_planar_mirror::prelude::*;

use crate::{
    controls::Paused,
    scene::Table,
    settings::Settings,
    shared::panel::{add_panels, hide_panels},
};

#[derive(Component)]
struct KeyList;

#[derive(Component)]
struct StatusLine;

pub fn plugin(app: &mut App) {
    app.add_plugins(FrameTimeDiagnosticsPlugin::default())
        .add_systems(PostStartup, add_text)
        .add_systems(Update, (hide_panels, show_keys, show_status));
}

fn add_text(mut commands: Commands) {
    add_panels(&mut commands, KeyList, StatusLine);
}

fn show_keys(
    settings: Res<Settings>,
    paused: Res<Paused>,
    free_camera: Single<&FreeCameraState>,
    mut list: Single<&mut Text, With<KeyList>>,
) {
    let on = |yes: bool| if yes { "on" } else { "off" }.to_string();
    let runs = |rests: bool| if rests { "rests" } else { "runs" }.to_string();
    let samples = match settings.samples {
        1 => "off".into(),
        n => format!("{n} samples"),
    };
    let filter = if settings.soft_shadows {
        "soft"
    } else {
        "hard"
    };
    let flying = if free_camera.enabled {
        "on: W A S D Q E, right mouse button"
    } else {
        "off"
    };
    let rows = [
        ("J", "jump", runs(paused.jump)),
        ("L", "light", runs(paused.light)),
        ("R", "mirror", on(settings.mirror)),
        ("C", "cut at the table", on(settings.clip)),
        ("Up Down", "table's alpha", format!("{:.1}", settings.alpha)),
        (
            "Left Right",
            "tessellation",
            settings.tessellation.to_string(),
        ),
        ("B", "shadow filter", filter.into()),
        ("M", "multisampling", samples),
        ("H", "HDR and bloom", on(settings.hdr)),
        ("F", "free camera", flying.into()),
        ("P", "save a picture", String::new()),
        ("Tab", "hide this text", String::new()),
    ];
    let rows =
        rows.map(|(key, what, value)| format!("{key:<12}{what:<18}{value}").trim_end().to_string());
    list.set_if_neq(Text::new(rows.join("\n")));
}

fn show_status(
    settings: Res<Settings>,
    diagnostics: Res<DiagnosticsStore>,
    camera: Single<Entity, With<Camera3d>>,
    table: Single<Option<&MirrorStatus>, With<Table>>,
    mut line: Single<&mut Text, With<StatusLine>>,
) {
    let mirror = match table.and_then(|status| status.of(*camera)) {
        Some(state) if settings.mirror => state.to_string(),
        _ => "off".to_string(),
    };
    let fps = diagnostics
        .get(&FrameTimeDiagnosticsPlugin::FPS)
        .and_then(|fps| fps.smoothed())
        .unwrap_or_default();
    line.set_if_neq(Text::new(format!(
        "mirror {mirror}    {fps:.0} frames a second"
    )));
}
