//! Effects on the finished picture: they take the reflection for what it looks like, a view through an opening.

use bevy::{
    anti_alias::{
        contrast_adaptive_sharpening::ContrastAdaptiveSharpening, fxaa::Fxaa,
        taa::TemporalAntiAliasing,
    },
    camera::Hdr,
    core_pipeline::tonemapping::Tonemapping,
    pbr::ScreenSpaceAmbientOcclusion,
    post_process::{
        bloom::Bloom,
        dof::{DepthOfField, DepthOfFieldMode},
        effect_stack::ChromaticAberration,
        motion_blur::MotionBlur,
    },
    prelude::*,
};

use crate::support::{
    hall::{CROSSING, framed, hall, sunny_hall},
    opening::opened,
    picture::Picture,
    scene::Scene,
    set::{build_plain, build_with_mirrors},
    stage::Stage,
    studio::{SHARE, Studio, TOLERANCE},
};

/// Nothing crosses the mirror: at a cut the opening may have a pixel of its own, which an effect would spread.
fn uncut_hall(name: &str) -> Scene {
    let mut scene = framed(hall(name));
    scene.objects.remove(CROSSING);
    scene
}

/// The whole picture is that of the opening, and another one than without the effect.
#[track_caller]
fn assert_like_an_opening(studio: &mut Studio, scene: &Scene, bare: &Scene) -> Picture {
    let picture = studio.picture(scene);
    let through = studio.without_mirrors(&opened(scene));
    picture.assert_alike(&through, TOLERANCE, SHARE, |_| true, &scene.name);
    let without = studio.picture(bare);
    let changed = picture.difference(&without, TOLERANCE, |_| true);
    assert!(
        changed.as_ref().is_ok_and(|changed| changed.beyond > 50),
        "{}: the effect is not to be seen: {changed:?}",
        scene.name
    );
    picture
}

#[test]
fn an_opening_onto_the_reflected_world_looks_like_the_mirror() {
    let mut studio = Studio::default();
    for msaa in [Msaa::Off, Msaa::Sample4] {
        let mut scene = framed(hall(&format!("opening-{msaa:?}")));
        scene.msaa = msaa;
        let picture = studio.assert_reflects_in_place(&scene);
        let through = studio.without_mirrors(&opened(&scene));
        picture.assert_alike(&through, TOLERANCE, SHARE, |_| true, &scene.name);
    }
}

#[test]
fn a_bright_thing_in_the_mirror_blooms_over_its_frame() {
    let mut studio = Studio::default();
    for msaa in [Msaa::Off, Msaa::Sample4] {
        let glow = StandardMaterial {
            base_color: Color::linear_rgb(30.0, 10.0, 4.0),
            unlit: true,
            ..default()
        };
        let mut bare =
            uncut_hall(&format!("bloom-{msaa:?}")).with_camera((Hdr, Tonemapping::TonyMcMapface));
        bare.msaa = msaa;
        bare.objects[0].look = glow.into();
        // Where only its reflection is seen, and near the frame.
        bare.objects[0].transform.translation = vec3(-1.6, 1.0, 5.0);
        for bloom in [Bloom::NATURAL, Bloom::OLD_SCHOOL] {
            let scene = bare.clone().with_camera(bloom);
            assert_like_an_opening(&mut studio, &scene, &bare);
        }
    }
}

#[test]
fn edges_in_the_mirror_are_smoothed_as_all_others() {
    let mut studio = Studio::default();
    let bare = uncut_hall("smoothed");
    for hdr in [false, true] {
        let mut scene = bare.clone().with_camera(Fxaa::default());
        if hdr {
            scene = scene.with_camera(Hdr);
        }
        assert_like_an_opening(&mut studio, &scene, &bare);
    }
}

#[test]
fn sharpening_and_color_fringes_take_the_reflection_with_them() {
    let mut studio = Studio::default();
    let mut bare = uncut_hall("sharpened");
    // Sharpening works on what is not sharp.
    bare.msaa = Msaa::Sample4;
    let sharpening = ContrastAdaptiveSharpening {
        sharpening_strength: 0.9,
        ..default()
    };
    let fringes = ChromaticAberration {
        intensity: 0.05,
        ..default()
    };
    for scene in [
        bare.clone().with_camera(sharpening),
        bare.clone().with_camera(fringes),
    ] {
        assert_like_an_opening(&mut studio, &scene, &bare);
    }
}

/// The effect jitters the camera from frame to frame; a reflection without the jitter would stay rough.
#[test]
fn temporal_anti_aliasing_smooths_the_reflection() {
    let bare = uncut_hall("temporal");
    let scene = bare.clone().with_camera(TemporalAntiAliasing::default());
    let after = |mut stage: Stage,
                 build: fn(&mut Stage, &Scene, Handle<Image>) -> Entity,
                 scene: &Scene| {
        let target = stage.target(bare.size);
        build(&mut stage, scene, target.clone());
        // The same count in both apps: the jitter goes by the frame.
        for _ in 0..40 {
            stage.frame();
        }
        stage
            .read(&target, bare.size)
            .unwrap_or_else(|reason| panic!("{reason}"))
    };
    let picture = after(Stage::with_mirrors(), build_with_mirrors, &scene);
    let through = after(Stage::stock(), build_plain, &opened(&scene));
    picture.assert_alike(&through, 16, 0.999, |_| true, "temporal");
    let rough = after(Stage::with_mirrors(), build_with_mirrors, &bare);
    let changed = picture.difference(&rough, 8, |_| true).expect("one size");
    assert!(changed.beyond > 50, "nothing is smoothed: {changed}");
}

/// At rest nothing is blurred; in motion nothing breaks.
#[test]
fn motion_blur_leaves_a_mirror_at_rest_alone_and_stands_one_in_motion() {
    let scene = uncut_hall("motion-blur").with_camera(MotionBlur {
        shutter_angle: 1.0,
        samples: 4,
    });
    let mut studio = Studio::default();
    let picture = studio.picture(&scene);
    let through = studio.without_mirrors(&opened(&scene));
    picture.assert_alike(&through, TOLERANCE, SHARE, |_| true, &scene.name);

    let mut stage = Stage::with_mirrors();
    let target = stage.target(scene.size);
    let camera = build_with_mirrors(&mut stage, &scene, target.clone());
    let at_rest = stage.picture(&target, scene.size);
    for _ in 0..4 {
        let mut eye = stage
            .world()
            .get_mut::<Transform>(camera)
            .expect("a camera stands somewhere");
        eye.rotate_y(0.05);
        stage.frame();
    }
    let moving = stage
        .read(&target, scene.size)
        .unwrap_or_else(|reason| panic!("{reason}"));
    let changed = moving.difference(&at_rest, 8, |_| true).expect("one size");
    assert!(changed.beyond > 500, "nothing moves: {changed}");
}

/// The depth of the picture is that of the mirror's surface, so this is what has to be in focus.
#[test]
fn depth_of_field_sees_the_mirrors_surface() {
    let mut studio = Studio::default();
    let bare = framed(hall("focus"));
    let mask = studio.mask(&bare, 0);
    let focus = |distance: f32| DepthOfField {
        mode: DepthOfFieldMode::Gaussian,
        focal_distance: distance,
        aperture_f_stops: 1.0 / 50.0,
        max_circle_of_confusion_diameter: 12.0,
        max_depth: 40.0,
        ..default()
    };
    let sharp = studio.picture(&bare);
    let mut blurred = |distance| {
        let picture = studio.picture(&bare.clone().with_camera(focus(distance)));
        let blurred = picture.difference(&sharp, 24, |place| mask.inside(place));
        blurred.expect("one size").beyond
    };
    let (on_the_surface, in_the_depth) = (blurred(4.2), blurred(12.0));
    assert!(
        on_the_surface * 4 < in_the_depth,
        "{on_the_surface} pixels are blurred where the mirror is in focus, else {in_the_depth}"
    );
}

/// Occlusion is found in the depth of the camera's own picture, of which the reflection is no part: it is
/// drawn without. Around the mirror it is as ever.
#[test]
fn ambient_occlusion_darkens_what_is_around_the_mirror_alone() {
    let mut bare = sunny_hall("occlusion");
    bare.ambient.brightness = 3000.0;
    let scene = bare
        .clone()
        .with_camera(ScreenSpaceAmbientOcclusion::default());
    let mut studio = Studio::default();
    let picture = studio.picture(&scene);
    studio.assert_untouched_outside(&scene, &picture);
    let mask = studio.mask(&scene, 0);
    let reference = studio.reference(&bare, 0);
    let inside = |place| mask.inside(place);
    picture.assert_alike(&reference, TOLERANCE, SHARE, inside, "occlusion-inside");
    let dark = picture
        .difference(&studio.without_mirrors(&bare), 4, |place| {
            mask.outside(place)
        })
        .expect("one size");
    assert!(dark.beyond > 50, "nothing is occluded: {dark}");
}
