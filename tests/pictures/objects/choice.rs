//! Which objects are reflected at all: by their distance, their layers, their visibility.

use bevy::{
    camera::visibility::{RenderLayers, VisibilityRange},
    prelude::*,
};

use super::{turned, unlit, wall};
use crate::support::{
    props::{GREEN, RED, YELLOW, is},
    scene::Look,
    studio::{Studio, assert_reflects},
};

/// From the reflected eye it is farther than from the eye.
#[test]
fn a_things_distance_in_the_mirror_decides_on_its_level_of_detail() {
    let level = |color: Color, range: std::ops::Range<f32>| {
        Look::other(move |entity| {
            let material = unlit(entity, color);
            entity.insert((material, VisibilityRange::abrupt(range.start, range.end)));
        })
    };
    let place = turned(-0.5, 0.0, 1.0);
    let scene = wall("level-of-detail")
        .object(Cuboid::from_length(0.5), level(RED, 0.0..4.0), place)
        .object(Cuboid::from_length(0.5), level(GREEN, 4.0..20.0), place);
    let picture = assert_reflects(&scene);
    assert!(picture.count(is(RED)) > 200 && picture.count(is(GREEN)) > 100);
    let plain = Studio::default().without_mirrors(&scene);
    assert_eq!(plain.count(is(GREEN)), 0, "the eye itself is near");
}

#[test]
fn what_the_camera_is_not_to_see_is_not_reflected() {
    let scene = wall("layers").object(Cuboid::from_length(0.5), YELLOW, turned(-0.5, 0.0, 1.0));
    let mut studio = Studio::default();
    let alone = studio.picture(&scene);
    let other_layer = Look::other(|entity| {
        let material = unlit(entity, RED);
        entity.insert((material, RenderLayers::layer(3)));
    });
    let hidden = Look::other(|entity| {
        let material = unlit(entity, RED);
        entity.insert((material, Visibility::Hidden));
    });
    for (name, look) in [("layer", other_layer), ("hidden", hidden)] {
        let more = scene
            .clone()
            .object(Cuboid::from_length(0.8), look, turned(0.5, 0.0, 1.0));
        studio
            .picture(&more)
            .assert_same(&alone, &format!("unseen-{name}"));
    }
}
