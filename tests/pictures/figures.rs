//! What [`MirrorFigures`] says of the drawing.

use core::time::Duration;

use bevy::{prelude::*, render::view::NoIndirectDrawing};
use bevy_planar_mirror::{
    MirrorFigures,
    status::{DrawnFigures, ViewFigures},
};

use super::lighting::{evening_sun, still_life};
use crate::support::{
    live::{Live, find, named},
    props::{at, glass, lit},
    scene::Scene,
};

/// Three opaque things and two panes of glass, each with a mesh of its own.
fn things() -> Scene {
    let pane = glass(Color::WHITE, 0.5);
    still_life("figures")
        .prop(evening_sun(vec3(1.0, 1.2, 3.0), 1))
        .object(
            Rectangle::from_length(0.4),
            named("pane", pane.clone()),
            at(0.1, 0.6, 1.0),
        )
        .object(Rectangle::from_length(0.3), pane, at(-0.2, 0.8, 1.1))
}

/// What there was to draw, and what it took, when nothing changes any more.
fn figures(live: &mut Live) -> (ViewFigures, DrawnFigures) {
    live.settled();
    live.stage.frame();
    let view = live.world().resource::<MirrorFigures>().views[0];
    (view, view.drawn.expect("it was drawn"))
}

#[test]
fn figures_count_the_draw_calls() {
    let scene = things().lens(|camera| {
        camera.insert(NoIndirectDrawing);
    });
    let mut live = Live::in_reach(&scene);
    let (view, drawn) = figures(&mut live);
    assert_eq!((view.objects, drawn.draws), (5, 5));
    assert!(drawn.time > Duration::ZERO);
    // Of what is alike, one for all.
    let world = live.world();
    let pane = find(world, "pane");
    let mesh = world.get::<Mesh3d>(pane).expect("it is a mesh").clone();
    let material = lit(Color::srgb(0.2, 0.6, 0.2));
    let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
    let material = MeshMaterial3d(materials.add(material));
    for x in [-0.4, 0.0, 0.4] {
        world.spawn((mesh.clone(), material.clone(), at(x, 0.9, 0.7)));
    }
    let (view, drawn) = figures(&mut live);
    assert_eq!((view.objects, drawn.draws), (8, 6));
}

/// Several batches may be one call, but what blends is drawn one after the other.
#[test]
fn figures_count_many_batches_of_one_call_once() {
    let mut live = Live::in_reach(&things());
    let (view, drawn) = figures(&mut live);
    assert_eq!(view.objects, 5);
    assert!((3..=5).contains(&drawn.draws), "{drawn:?}");
}

/// Nothing is known of a view that was never drawn, and nothing is forgotten of one that was.
#[test]
fn figures_know_what_it_took_since_the_first_time() {
    let mut live = Live::in_reach(&things());
    let drawn = |live: &mut Live| {
        live.stage.frame();
        let figures = live.world().resource::<MirrorFigures>();
        figures.views.first().map(|view| view.drawn.is_some())
    };
    assert_eq!(drawn(&mut live), Some(false));
    live.settled();
    assert_eq!(drawn(&mut live), Some(true));
    assert_eq!(drawn(&mut live), Some(true));
}
