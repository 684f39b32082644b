//! Targets of other formats than a screen's, and of odd sizes.

use bevy::{prelude::*, render::render_resource::TextureFormat};

use crate::support::{
    hall::sunny_hall,
    picture::Picture,
    props::{RED, at},
    scene::{Scene, Surface},
    set::{build_plain, build_reference, build_with_mirrors, clear},
    stage::Stage,
    studio::{SHARE, Studio, TOLERANCE},
};

#[test]
fn targets_of_other_formats_show_the_reflection() {
    let scene = sunny_hall("format");
    let mut studio = Studio::default();
    let mask = studio.mask(&scene, 0);
    for format in [
        TextureFormat::Rgba8Unorm,
        TextureFormat::Bgra8Unorm,
        TextureFormat::Bgra8UnormSrgb,
        TextureFormat::Rgba16Float,
    ] {
        for hdr in [false, true] {
            let scene = if hdr {
                scene.clone().hdr()
            } else {
                scene.clone()
            };
            let what = format!("{format:?}-hdr-{hdr}");
            let mut mirrors = Stage::with_mirrors();
            let target = mirrors.target_of(scene.size, format);
            build_with_mirrors(&mut mirrors, &scene, target.clone());
            let picture = mirrors.picture(&target, scene.size);

            let mut stock = Stage::stock();
            let target = stock.target_of(scene.size, format);
            build_plain(&mut stock, &scene, target.clone());
            let plain = stock.picture(&target, scene.size);
            picture.assert_alike(
                &plain,
                0,
                1.0,
                |place| mask.outside(place),
                &format!("{what}-outside"),
            );
            let reference = reference_of(&mut stock, &scene, format);
            picture.assert_alike(
                &reference,
                TOLERANCE,
                SHARE,
                |place| mask.inside(place),
                &format!("{what}-inside"),
            );
        }
    }
}

#[track_caller]
fn reference_of(stock: &mut Stage, scene: &Scene, format: TextureFormat) -> Picture {
    clear(stock);
    let target = stock.target_of(scene.size, format);
    build_reference(stock, scene, 0, target.clone());
    stock.picture(&target, scene.size).flipped()
}

#[test]
fn a_target_of_one_pixel_shows_the_reflection() {
    // All that one can see is red in the mirror, and nothing beside it.
    let mut scene = Scene::new("one-pixel")
        .eye(vec3(0.0, 0.0, 2.0), Vec3::ZERO)
        .mirror(Surface::wall(8.0, 8.0, default()))
        .object(Cuboid::new(50.0, 50.0, 1.0), RED, at(0.0, 0.0, 8.0));
    scene.size = UVec2::ONE;
    let mut stage = Stage::with_mirrors();
    let target = stage.target(scene.size);
    build_with_mirrors(&mut stage, &scene, target.clone());
    let picture = stage
        .settle(&target, scene.size)
        .unwrap_or_else(|reason| panic!("{reason}"));
    assert_eq!(picture.at(0, 0), [255, 0, 0, 255]);
}

#[test]
fn targets_of_odd_sizes_show_the_reflection() {
    let mut studio = Studio::default();
    for size in [
        uvec2(3, 500),
        uvec2(500, 3),
        uvec2(1, 301),
        uvec2(301, 1),
        uvec2(127, 61),
    ] {
        let mut scene = sunny_hall(&format!("size-{}x{}", size.x, size.y));
        scene.size = size;
        // One line of the screen sees the hall from top to bottom, and something must stand in it.
        scene.mirrors[0] = Surface::wall(60.0, 9.0, at(0.0, 0.5, 0.0));
        for x in [-9.0, -4.0, 0.3, 4.0, 9.0] {
            let pillar = Cuboid::new(1.0, 8.0, 1.0);
            scene = scene.object(
                pillar,
                Color::srgb(0.5, 0.3, 0.5 + x / 20.0),
                at(x, 0.5, 5.5),
            );
        }
        studio.assert_small_reflects(&scene, 40);
    }
}
