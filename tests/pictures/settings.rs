//! What changes how much is done, and no pixel.

use bevy_planar_mirror::{MirrorClip, MirrorShadows, PlanarMirrorPlugin};

use crate::support::{
    random::{self, Kind},
    studio::Studio,
};

const SEEDS: std::ops::Range<u64> = 500..506;

/// One mirror has one view, and nothing is seen in it again.
#[test]
fn more_bounces_and_fewer_views_than_a_scene_needs_change_no_pixel() {
    let mut studio = Studio::with(PlanarMirrorPlugin {
        max_bounces: 4,
        max_views: 1,
    });
    for seed in SEEDS {
        studio.assert_reflects(&random::scene(seed, Kind::Any));
    }
}

#[test]
fn a_cut_where_nothing_crosses_and_no_shadows_where_there_are_none_change_no_pixel() {
    let mut studio = Studio::default();
    for seed in SEEDS {
        let mut scene = random::scene(seed, Kind::Any);
        for surface in &mut scene.mirrors {
            surface.mirror.clip = MirrorClip::Oblique;
            surface.mirror.shadows = MirrorShadows::Off;
        }
        studio.assert_reflects(&scene);
    }
}
