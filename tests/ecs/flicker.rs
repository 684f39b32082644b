//! What is decided anew in every frame remembers the frame before.

use bevy::prelude::*;
use bevy_planar_mirror::NotDrawn;

use super::app::{EYE, OBLIQUE, PLAIN, above, floor, mirror_app, not};

#[test]
fn a_thin_mirror_comes_at_half_a_pixel_and_goes_at_a_quarter() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    // A hundred pixels high: a unit at a distance of 5 is 24 pixels.
    let high = |px: f32| Transform::from_scale(vec3(1.0, px / 48.3, 1.0));
    let thin = not(NotDrawn::TooThin);
    for (px, expected) in [
        (0.4, thin),
        (0.6, PLAIN),
        (0.4, PLAIN),
        (0.6, PLAIN),
        (0.2, thin),
        (0.4, thin),
        (0.6, PLAIN),
    ] {
        *app.of_mut::<Transform>(mirror) = high(px);
        app.update();
        app.assert_state(mirror, camera, expected);
    }
    // Only in the very last frame.
    for visibility in [Visibility::Hidden, Visibility::Visible] {
        app.insert(mirror, visibility);
        *app.of_mut::<Transform>(mirror) = high(0.4);
        app.update();
    }
    app.assert_state(mirror, camera, thin);
}

#[test]
fn what_was_cut_is_cut_until_it_is_nearly_out() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(floor(0.0)), app.spawn_camera(above()));
    // A quarter of a pixel is 8 thousandths of a unit there.
    let cube = app.spawn_cube(0.4, vec3(0.0, 0.2, 0.0));
    for (sunk, expected) in [
        (0.0, PLAIN),
        (0.006, PLAIN),
        (0.02, OBLIQUE),
        (0.006, OBLIQUE),
        (0.002, PLAIN),
        (0.006, PLAIN),
    ] {
        app.of_mut::<Transform>(cube).translation.y = 0.2 - sunk;
        app.update();
        app.assert_state(mirror, camera, expected);
    }
}
