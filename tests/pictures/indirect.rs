//! Reflections are drawn as their camera's own picture is: by indirect parameters that the GPU fills in, or directly.

use bevy::{
    core_pipeline::{core_3d::Opaque3d, prepass::DepthPrepass},
    prelude::*,
    render::{
        batching::gpu_preprocessing::{GpuPreprocessingMode, GpuPreprocessingSupport},
        occlusion_culling::OcclusionCulling,
        render_phase::ViewBinnedRenderPhases,
        view::NoIndirectDrawing,
    },
};

use super::lighting::{evening_sun, low_spot, still_life};
use crate::support::{
    props::{GREEN, MAGENTA, at, is},
    scene::Scene,
    studio::Studio,
};

/// Drawn by a camera that asks for it.
fn direct(scene: &Scene) -> Scene {
    let mut scene = scene.clone().lens(|camera| {
        camera.insert(NoIndirectDrawing);
    });
    scene.name += "-direct";
    scene
}

/// How many views have opaque bins that are drawn indirectly, and how many have others.
fn indirect_and_direct(studio: &mut Studio) -> (usize, usize) {
    let phases = studio
        .stage()
        .render_world()
        .resource::<ViewBinnedRenderPhases<Opaque3d>>();
    let indirect = phases
        .values()
        .filter(|phase| !phase.multidrawable_meshes.is_empty());
    let direct = phases
        .values()
        .filter(|phase| !phase.batchable_meshes.is_empty());
    (indirect.count(), direct.count())
}

#[test]
fn a_reflection_is_drawn_indirectly_where_its_camera_is() {
    let scene = still_life("indirect")
        .prop(evening_sun(vec3(1.0, 1.2, 3.0), 2))
        .prop(low_spot());
    let mut studio = Studio::default();
    let picture = studio.assert_reflects(&scene);
    let support = *studio
        .stage()
        .render_world()
        .resource::<GpuPreprocessingSupport>();
    let drawn = indirect_and_direct(&mut studio);
    // Also Mesa's software driver does that.
    assert!(support.max_supported_mode == GpuPreprocessingMode::Culling);
    assert_eq!(drawn, (2, 0), "the camera's picture and the reflection");
    let mut studio = Studio::default();
    let direct = studio.assert_reflects(&direct(&scene));
    assert_eq!(indirect_and_direct(&mut studio), (0, 2));
    picture.assert_same(&direct, "indirect-and-direct");
}

/// What hides things from the camera, or from its shadow maps, does not hide them from the reflection.
#[test]
fn occlusion_culling_leaves_nothing_out_of_the_reflection() {
    let sun = (evening_sun(vec3(1.0, 1.2, 3.0), 2), OcclusionCulling);
    // To the camera a thing stands behind a board. The mirror sees it from below.
    let behind_a_board = |name: &str| {
        still_life(name)
            .object(Cuboid::new(1.2, 1.2, 0.1), GREEN, at(0.0, 1.3, 0.6))
            .object(Cuboid::from_length(0.3), MAGENTA, at(0.0, 0.9, -0.6))
    };
    let scene = behind_a_board("occlusion-culling")
        .prop(sun)
        .with_camera((DepthPrepass, OcclusionCulling));
    let mut studio = Studio::default();
    let picture = studio.assert_reflects(&scene);
    assert!(picture.count(is(MAGENTA)) > 20, "it is in the mirror");
    let direct = studio.without_mirrors(&scene);
    assert_eq!(direct.count(is(MAGENTA)), 0, "the board hides it");
    let bare = behind_a_board("no-occlusion-culling").prop(evening_sun(vec3(1.0, 1.2, 3.0), 2));
    picture.assert_same(
        &studio.picture(&bare.with_camera(DepthPrepass)),
        "occlusion-culling-or-not",
    );
}
