//! What the mirror itself is made of: the material on it, and the side it is seen from.

use bevy::prelude::*;

use crate::support::{
    linear::combined,
    picture::Picture,
    props::{BLUE, GREEN, RED, YELLOW, at, is, lamp, lit, quarters, sun},
    scene::{Look, Scene, Surface},
    studio::{Studio, TOLERANCE, assert_reflects},
};

/// Things on a floor, under two lights.
fn floor(name: &str, look: impl Into<Look>) -> Scene {
    let mut scene = Scene::new(name)
        .eye(vec3(0.4, 1.6, 4.2), vec3(0.0, 0.1, 0.0))
        .mirror(Surface::floor(4.0, 4.0, Transform::default()).look(look))
        .object(Cuboid::from_length(0.8), lit(RED), at(-0.7, 0.5, 0.0))
        .object(
            Sphere::new(0.5).mesh().uv(32, 18),
            lit(YELLOW),
            at(0.8, 0.4, 0.3),
        )
        .object(Cuboid::new(3.0, 1.6, 0.1), GREEN, at(0.0, 0.9, -1.4))
        .prop(sun(false))
        .prop(lamp(vec3(1.5, 2.0, 1.0), false));
    scene.ambient.brightness = 100.0;
    scene
}

/// What the picture must be where the mirror is: its material over the reflection, by the formula
/// of the material's own blending.
///
/// Every blending is linear in what is behind, `A + B x`: the same surface over black gives `A`, and
/// over some gray, dim enough that no channel is cut off at white, the rest.
fn blended(studio: &mut Studio, scene: &Scene) -> Picture {
    let mut alone = scene.clone();
    alone.objects.clear();
    alone.clear_color = Color::BLACK;
    let on_black = studio.without_mirrors(&alone);
    let gray = Color::srgb_u8(170, 170, 170);
    alone.clear_color = gray;
    let on_gray = studio.without_mirrors(&alone);
    let gray = gray.to_linear().red;
    let mut perfect = scene.clone();
    perfect.mirrors[0].look = None;
    let reflection = studio.assert_reflects(&perfect);
    combined(
        [&on_black, &on_gray, &reflection],
        |[on_black, on_gray, reflection]| on_black + (on_gray - on_black) / gray * reflection,
    )
}

#[test]
fn a_translucent_material_lies_over_the_reflection_by_its_own_formula() {
    let color = Color::srgba(0.2, 0.4, 0.6, 0.45);
    let modes = [
        AlphaMode::Blend,
        AlphaMode::Premultiplied,
        AlphaMode::Add,
        AlphaMode::Multiply,
    ];
    let mut studio = Studio::default();
    for alpha_mode in modes {
        for unlit in [true, false] {
            let material = StandardMaterial {
                alpha_mode,
                unlit,
                ..lit(color)
            };
            let name = format!("blend-{alpha_mode:?}-{unlit}");
            let scene = floor(&name, material);
            let expected = blended(&mut studio, &scene);
            let mask = studio.mask(&scene, 0);
            let inside = |place| mask.inside(place);
            let picture = studio.picture(&scene);
            // Three pictures, each rounded to 8 bits, make up what is expected.
            picture.assert_alike(&expected, TOLERANCE + 1, 1.0, inside, &name);
            studio.assert_untouched_outside(&scene, &picture);
        }
    }
}

/// Said once more with the numbers of the ordinary formula.
#[test]
fn half_a_floor_and_half_a_reflection() {
    let blue = StandardMaterial {
        base_color: BLUE.with_alpha(0.5),
        unlit: true,
        alpha_mode: AlphaMode::Blend,
        ..default()
    };
    let scene = Scene::new("half")
        .eye(vec3(0.0, 0.0, 4.0), Vec3::ZERO)
        .mirror(Surface::wall(4.0, 2.6, Transform::default()).look(blue))
        .object(Cuboid::from_length(0.8), RED, at(0.9, 0.0, 1.0));
    let picture = Studio::default().picture(&scene);
    let half = Color::linear_rgb(0.5, 0.0, 0.5);
    assert!(picture.count(is(half)) > 50, "{}", picture.save("half"));
}

#[test]
fn a_textured_translucent_material_lies_over_the_reflection() {
    let pane = StandardMaterial {
        unlit: true,
        alpha_mode: AlphaMode::Blend,
        ..default()
    };
    let scene = floor("blend-textured", quarters(pane, [255, 160, 90, 0]));
    let mut studio = Studio::default();
    let expected = blended(&mut studio, &scene);
    let mask = studio.mask(&scene, 0);
    let picture = studio.picture(&scene);
    picture.assert_alike(
        &expected,
        TOLERANCE,
        1.0,
        |place| mask.inside(place),
        "blend-textured",
    );
}

#[test]
fn without_a_material_it_is_a_perfect_mirror() {
    let mut scene = floor("perfect", GREEN);
    scene.mirrors[0].look = None;
    let picture = assert_reflects(&scene);
    assert!(picture.count(is(GREEN)) > 500);
}

/// A mirror out of a modelling tool has some opaque material. It shows where there is no reflection:
/// from behind, to cameras that see no mirrors, in an app without a renderer for them.
#[test]
fn the_reflection_covers_an_opaque_material() {
    let mut studio = Studio::default();
    for (name, look) in [("lit", lit(BLUE)), ("metal", metal())] {
        let scene = floor(&format!("opaque-{name}"), look);
        let mut perfect = scene.clone();
        perfect.mirrors[0].look = None;
        let expected = studio.picture(&perfect);
        let picture = studio.assert_reflects(&scene);
        let mask = studio.mask(&scene, 0);
        picture.assert_alike(&expected, 0, 1.0, |place| mask.inside(place), &scene.name);
    }
}

fn metal() -> StandardMaterial {
    StandardMaterial {
        metallic: 1.0,
        perceptual_roughness: 0.1,
        ..lit(Color::WHITE)
    }
}

#[test]
fn a_two_sided_mirror_shows_nothing_from_behind() {
    let two_sided = StandardMaterial {
        double_sided: true,
        cull_mode: None,
        ..lit(GREEN)
    };
    let mut studio = Studio::default();
    for (name, look) in [("bare", None), ("two-sided", Some(two_sided))] {
        let mut scene = Scene::new(&format!("back-{name}"))
            .eye(vec3(0.5, 0.4, -4.0), Vec3::ZERO)
            .mirror(Surface::wall(3.0, 2.0, Transform::default()))
            .object(Cuboid::from_length(0.5), RED, at(-0.6, 0.2, 1.0))
            .object(Cuboid::from_length(0.5), BLUE, at(0.7, 0.0, -1.0))
            .prop(sun(false));
        scene.mirrors[0].look = look.map(Into::into);
        studio.assert_no_mirror(&scene);
    }
}
