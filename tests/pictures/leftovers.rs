//! What stays in the renderer of a mirror that is gone: nothing.

use bevy::render::camera::ExtractedCamera;
use bevy_planar_mirror::PlanarMirror;

use super::changes::room;
use crate::support::live::{Live, find};

/// The views that the renderer has, the user's camera among them.
fn views(live: &mut Live) -> usize {
    let render = live.stage.render_world();
    render.query::<&ExtractedCamera>().iter(render).count()
}

#[test]
fn a_mirror_that_comes_and_goes_leaves_no_view_in_the_renderer() {
    let mut live = Live::in_reach(&room("leftovers"));
    let mirror = find(live.world(), "mirror");
    for round in 0..3 {
        live.next();
        assert_eq!(views(&mut live), 2, "with the mirror, round {round}");
        live.world().entity_mut(mirror).remove::<PlanarMirror>();
        // The renderer follows at the next extraction.
        live.next();
        live.next();
        assert_eq!(views(&mut live), 1, "without it, round {round}");
        live.world()
            .entity_mut(mirror)
            .insert(PlanarMirror::default());
    }
    let mut warnings = live.stage.warnings();
    assert!(warnings.all(|line| !line.text.contains("order ambiguities")));
}
