//! The text: the keys, and what there is to draw for mirrors.

use std::{fmt::Write, time::Duration};

use bevy::{
    diagnostic::{DiagnosticsStore, FrameTimeDiagnosticsPlugin},
    prelude::*,
};
use bevy_planar_mirror::MirrorFigures;

use crate::{
    scenes::{Place, Shown},
    shared::panel::{add_panels, hide_panels},
    spans::Reader,
};

#[derive(Component)]
struct KeyList;

#[derive(Component)]
struct Figures;

pub fn plugin(app: &mut App) {
    app.add_plugins(FrameTimeDiagnosticsPlugin::default())
        .add_systems(Startup, add_text)
        .add_systems(Update, (hide_panels, show_keys))
        // What the plugin has decided for the very frame.
        .add_systems(Last, show_figures);
}

fn add_text(mut commands: Commands) {
    // Over the whole picture, whatever cameras share it.
    commands.spawn((
        Camera2d,
        Camera {
            order: 10,
            clear_color: ClearColorConfig::None,
            ..default()
        },
        IsDefaultUiCamera,
    ));
    add_panels(&mut commands, KeyList, Figures);
}

fn show_keys(shown: Res<Shown>, mut list: Single<&mut Text, With<KeyList>>) {
    let scenes = Place::ALL.iter().enumerate().map(|(index, place)| {
        let mark = if *place == shown.0 { "*" } else { "" };
        ((index + 1).to_string(), format!("{}{mark}", place.about()))
    });
    let others = [
        ("W A S D Q E", "fly; look around: right mouse button"),
        ("Space", "rest or run"),
        ("P", "save a picture"),
        ("Tab", "hide this text"),
    ];
    let others = others.map(|(key, what)| (key.to_owned(), what.to_owned()));
    let rows: Vec<String> = scenes
        .chain(others)
        .map(|(key, what)| format!("{key:<14}{what}"))
        .collect();
    list.set_if_neq(Text::new(rows.join("\n")));
}

fn show_figures(
    figures: Res<MirrorFigures>,
    store: Res<DiagnosticsStore>,
    mut reader: Local<Reader>,
    mut pass: Local<String>,
    mut text: Single<&mut Text, With<Figures>>,
) {
    let mut lines = format!("reflected views: {}\n", figures.views.len());
    let last = figures.views.iter().map(|view| view.bounces).max();
    for bounce in 1..=last.unwrap_or(0) {
        let (mut views, mut mirrors, mut objects, mut draws, mut shadows) = (0, 0, 0, 0, 0);
        let (mut pixels, mut time) = (0.0, Duration::ZERO);
        for view in figures.views.iter().filter(|view| view.bounces == bounce) {
            views += 1;
            mirrors += view.mirrors;
            objects += view.objects;
            shadows += view.cascades;
            pixels += view.pixels;
            if let Some(drawn) = view.drawn {
                draws += drawn.draws;
                time += drawn.time;
            }
        }
        // Writing to a String cannot fail.
        let _ = writeln!(
            lines,
            "bounce {bounce}: views {views}, mirrors {mirrors}, objects {objects} in {draws} draws, cascades {shadows}, pixels {pixels:.0}, CPU {:.2} ms",
            time.as_secs_f64() * 1e3,
        );
    }
    if let Some(spans) = reader.read(&store) {
        *pass = match spans.get("planar_mirror_pass") {
            None => "no mirror pass".into(),
            Some(span) => {
                let gpu = span.gpu.map_or("?".into(), |gpu| format!("{gpu:.2}"));
                format!("mirror pass: CPU {:.2} ms, GPU {gpu} ms", span.cpu)
            }
        };
    }
    let fps = store
        .get(&FrameTimeDiagnosticsPlugin::FPS)
        .and_then(|fps| fps.smoothed())
        .unwrap_or_default();
    lines += &format!("{}, {fps:.0} frames a second", *pass);
    text.set_if_neq(Text::new(lines));
}
