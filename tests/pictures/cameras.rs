//! What a camera can be set to that changes every pixel: samples, dynamic range, tone mapping, exposure, grading, dither
//! and prepasses.

use bevy::{
    camera::{CompositingSpace, Exposure, Hdr},
    core_pipeline::{
        prepass::{DeferredPrepass, DepthPrepass, MotionVectorPrepass, NormalPrepass},
        tonemapping::{DebandDither, Tonemapping},
    },
    prelude::*,
    render::{
        render_resource::{
            Extent3d, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages,
        },
        renderer::{RenderAdapter, RenderDevice},
        view::{ColorGrading, ColorGradingGlobal, ColorGradingSection},
    },
};
use bevy_planar_mirror::{MirrorState, MirrorStatus, NotDrawn};

use crate::support::{
    hall::{hall, sunny_hall},
    picture::Picture,
    props::{MAGENTA, at, glass},
    scene::{Look, Scene},
    stage::Stage,
    studio::{Studio, assert_reflects},
};

const TONE_MAPPINGS: [Tonemapping; 5] = [
    Tonemapping::None,
    Tonemapping::Reinhard,
    Tonemapping::AcesFitted,
    Tonemapping::AgX,
    Tonemapping::TonyMcMapface,
];

/// Edges of objects are as smooth in the mirror as beside it: each sample is that of the reference.
#[test]
fn every_sample_count_that_the_adapter_has_reflects() {
    let mut studio = Studio::default();
    let mut drawn = Vec::new();
    for msaa in [Msaa::Off, Msaa::Sample2, Msaa::Sample4, Msaa::Sample8] {
        if !has_samples(studio.stage(), msaa) {
            assert_is_refused(msaa);
            continue;
        }
        for hdr in [false, true] {
            let mut scene = sunny_hall(&format!("{msaa:?}-hdr-{hdr}"));
            scene.msaa = msaa;
            if hdr {
                scene = scene.hdr();
            }
            studio.assert_reflects_in_place(&scene);
        }
        drawn.push(msaa.samples());
    }
    // Every adapter must have these two.
    assert!(drawn.contains(&1) && drawn.contains(&4), "only {drawn:?}");
}

/// Otherwise a mirror that drew one sample for all of a pixel would pass for one that draws four.
#[test]
fn four_samples_smooth_the_edges_in_the_mirror() {
    let mut scene = hall("smooth");
    let mut studio = Studio::default();
    let mask = studio.mask(&scene, 0);
    let mixed = |picture: &Picture| {
        let colors = main_colors(picture);
        picture
            .places()
            .filter(|place| mask.inside(*place))
            .filter(|place| !colors.contains(&picture.at(place.x, place.y)))
            .count()
    };
    let rough = studio.picture(&scene);
    scene.msaa = Msaa::Sample4;
    let smooth = studio.picture(&scene);
    assert_eq!(mixed(&rough), 0, "without samples every pixel is one thing");
    assert!(mixed(&smooth) > 30, "{} pixels are mixed", mixed(&smooth));
}

/// The colors that fill more than a line of the picture.
fn main_colors(picture: &Picture) -> Vec<[u8; 4]> {
    let mut counts = std::collections::HashMap::<[u8; 4], usize>::new();
    for place in picture.places() {
        *counts.entry(picture.at(place.x, place.y)).or_default() += 1;
    }
    counts.retain(|_, count| *count >= 40);
    counts.into_keys().collect()
}

/// Whether color and depth of the main pass can have so many samples.
fn has_samples(stage: &mut Stage, msaa: Msaa) -> bool {
    let adapter = stage.render_world().resource::<RenderAdapter>();
    [
        TextureFormat::Rgba8UnormSrgb,
        TextureFormat::Rgba16Float,
        TextureFormat::Depth32Float,
    ]
    .iter()
    .all(|format| {
        let features = adapter.get_texture_format_features(*format);
        features.flags.sample_count_supported(msaa.samples())
    })
}

/// The device itself must say no: nothing is left out because a question was asked wrongly.
#[track_caller]
fn assert_is_refused(msaa: Msaa) {
    let mut stage = Stage::stock();
    stage.frame();
    let device = stage.render_world().resource::<RenderDevice>().clone();
    device.create_texture(&TextureDescriptor {
        label: Some("samples"),
        size: Extent3d {
            width: 8,
            height: 8,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: msaa.samples(),
        dimension: TextureDimension::D2,
        format: TextureFormat::Rgba16Float,
        usage: TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let frame = std::panic::AssertUnwindSafe(|| stage.frame());
    let refused = std::panic::catch_unwind(frame).is_err();
    assert!(refused, "{msaa:?} can be had after all");
}

#[test]
fn every_tone_mapping_reflects() {
    let mut studio = Studio::default();
    for tone_mapping in TONE_MAPPINGS {
        for hdr in [false, true] {
            let mut scene =
                sunny_hall(&format!("{tone_mapping:?}-hdr-{hdr}")).with_camera(tone_mapping);
            if hdr {
                scene = scene.with_camera(Hdr);
            }
            studio.assert_reflects(&scene);
        }
    }
}

/// Without tone mapping all that is brighter than white is white, unless the target can hold it.
#[test]
fn what_is_brighter_than_white_keeps_its_brightness_in_the_mirror() {
    let glow = StandardMaterial {
        base_color: Color::linear_rgb(8.0, 4.0, 2.0),
        unlit: true,
        ..default()
    };
    let mut scene = hall("bright").with_camera((Hdr, Tonemapping::Reinhard));
    scene.objects[0].look = glow.into();
    let mut studio = Studio::default();
    let picture = studio.assert_reflects(&scene);
    let mask = studio.mask(&scene, 0);
    let dimmed = |pixel: [u8; 4]| pixel[0] > pixel[1] && pixel[1] > pixel[2] && pixel[2] > 100;
    let glowing = picture
        .places()
        .filter(|place| mask.inside(*place) && dimmed(picture.at(place.x, place.y)))
        .count();
    assert!(glowing > 50, "{glowing} pixels glow in the mirror");
}

#[test]
fn a_cameras_exposure_is_that_of_its_reflection() {
    let mut studio = Studio::default();
    let pictures = [Exposure::SUNLIGHT, Exposure::OVERCAST, Exposure::INDOOR].map(|exposure| {
        let mut scene = sunny_hall(&format!("exposure-{}", exposure.ev100)).with_camera(exposure);
        scene.ambient.brightness = 2000.0;
        studio.assert_reflects(&scene)
    });
    assert!(pictures[0] != pictures[1] && pictures[1] != pictures[2]);
}

#[test]
fn a_cameras_color_grading_is_that_of_its_reflection() {
    let section = |saturation, gain| ColorGradingSection {
        saturation,
        gain,
        ..default()
    };
    let grading = ColorGrading {
        global: ColorGradingGlobal {
            exposure: 0.4,
            temperature: 0.1,
            hue: 0.3,
            ..default()
        },
        shadows: section(0.6, 1.1),
        midtones: section(1.3, 0.9),
        highlights: section(0.8, 1.2),
    };
    let mut studio = Studio::default();
    for hdr in [false, true] {
        let mut scene = sunny_hall(&format!("grading-hdr-{hdr}"))
            .with_camera((grading.clone(), Tonemapping::TonyMcMapface));
        if hdr {
            scene = scene.with_camera(Hdr);
        }
        studio.assert_reflects(&scene);
    }
}

/// Glass, because the space is that in which colors are blended.
#[test]
fn a_cameras_compositing_space_is_that_of_its_reflection() {
    let mut studio = Studio::default();
    for space in [
        CompositingSpace::Linear,
        CompositingSpace::Srgb,
        CompositingSpace::Oklab,
    ] {
        for hdr in [false, true] {
            let mut scene = hall(&format!("{space:?}-hdr-{hdr}"))
                .with_camera(space)
                .object(
                    Cuboid::from_length(0.8),
                    glass(MAGENTA, 0.5),
                    at(-0.5, 0.6, 5.0),
                );
            if hdr {
                scene = scene.with_camera(Hdr);
            }
            studio.assert_reflects(&scene);
        }
    }
}

/// The dither is a pattern of the screen, so the reference must not be flipped.
#[test]
fn dither_falls_on_the_reflection_as_on_everything() {
    let mut studio = Studio::default();
    for hdr in [false, true] {
        let mut scene = sunny_hall(&format!("dither-hdr-{hdr}"))
            .with_camera((Tonemapping::TonyMcMapface, DebandDither::Enabled));
        if hdr {
            scene = scene.with_camera(Hdr);
        }
        let picture = studio.assert_reflects_in_place(&scene);
        let mask = studio.mask(&scene, 0);
        let reference = studio.reference_in_place(&scene, 0);
        // Not a level off: dithered otherwise, half of the pixels would be.
        picture.assert_alike(
            &reference,
            0,
            0.95,
            |place| mask.inside(place),
            "dither-to-the-level",
        );
    }
}

#[test]
fn a_camera_with_prepasses_reflects() {
    let mut studio = Studio::default();
    for (name, depth, normal, motion) in [
        ("depth", true, false, false),
        ("normal", false, true, false),
        ("motion", false, false, true),
        ("all", true, true, true),
    ] {
        let scene = sunny_hall(&format!("prepass-{name}"));
        let scene = with_prepasses(scene, depth, normal, motion);
        studio.assert_reflects(&scene);
    }
}

/// The reference draws back sides as well, since prepasses do not know of its left hand.
#[test]
fn a_camera_with_prepasses_and_samples_reflects() {
    let mut scene = with_prepasses(hall("prepass-samples"), true, true, true);
    scene.msaa = Msaa::Sample4;
    for object in &mut scene.objects {
        if let Look::Standard(material) = &mut object.look {
            material.cull_mode = None;
        }
    }
    Studio::default().assert_reflects_in_place(&scene);
}

fn with_prepasses(scene: Scene, depth: bool, normal: bool, motion: bool) -> Scene {
    scene.touch_camera(move |camera| {
        if depth {
            camera.insert(DepthPrepass);
        }
        if normal {
            camera.insert(NormalPrepass);
        }
        if motion {
            camera.insert(MotionVectorPrepass);
        }
    })
}

/// A mirror with a material of its own is in the prepass as well: the mask must not lose to it.
#[test]
fn a_mirror_with_a_material_reflects_for_a_camera_with_prepasses() {
    let mut scene = hall("prepass-material").touch_camera(|camera| {
        camera.insert((DepthPrepass, NormalPrepass));
    });
    let dark = StandardMaterial {
        base_color: Color::BLACK.with_alpha(0.0),
        unlit: true,
        alpha_mode: AlphaMode::Blend,
        ..default()
    };
    scene.mirrors[0] = scene.mirrors[0].clone().look(dark);
    assert_reflects(&scene);
}

#[test]
fn a_deferred_camera_sees_no_mirror_and_is_told_so() {
    let scene = sunny_hall("deferred").touch_camera(|camera| {
        camera.insert((DepthPrepass, DeferredPrepass));
    });
    let mut studio = Studio::default();
    studio.assert_no_mirror(&scene);
    assert_eq!(
        states(studio.stage()),
        [MirrorState::NotDrawn(NotDrawn::DeferredCamera)]
    );
}

/// What the mirrors on a stage say, one after the other.
pub fn states(stage: &mut Stage) -> Vec<MirrorState> {
    let world = stage.world();
    let mut statuses = world.query::<&MirrorStatus>();
    statuses
        .iter(world)
        .flat_map(|status| status.cameras.iter().map(|camera| camera.state))
        .collect()
}
