//! The harness itself: it must fail where it should, and its reference must be right where one knows the answer.

use bevy::{math::DVec3, prelude::*};

use crate::support::{
    cut::Plane,
    picture::{Picture, Unlike},
    props::{BLUE, GREEN, RED, at, is},
    reference::reflected_eye,
    scene::{Scene, Surface},
    set::build_plain,
    stage::{NoPicture, Stage},
    studio::Studio,
};

const SIZE: UVec2 = UVec2::new(64, 48);

/// A red box on the left, a green one on the right.
fn two_boxes() -> Scene {
    let mut scene = Scene::new("two-boxes")
        .eye(vec3(0.0, 0.0, 4.0), Vec3::ZERO)
        .object(Cuboid::default(), RED, at(-1.0, 0.0, 0.0))
        .object(Cuboid::default(), GREEN, at(1.0, 0.3, 0.0));
    scene.size = SIZE;
    scene
}

fn drawn(scene: &Scene) -> Picture {
    let mut stage = Stage::stock();
    let target = stage.target(SIZE);
    build_plain(&mut stage, scene, target.clone());
    stage.picture(&target, SIZE)
}

#[test]
fn a_scene_drawn_by_two_apps_is_the_same() {
    drawn(&two_boxes()).assert_same(&drawn(&two_boxes()), "drawn-twice");
}

#[test]
fn a_swapped_picture_fails() {
    let picture = drawn(&two_boxes());
    let unlike = picture.alike(&picture.flipped(), 2, 0.9999, |_| true);
    assert!(matches!(unlike, Err(Unlike::Pixels(_))), "{unlike:?}");
}

#[test]
#[should_panic(expected = "pixels differ")]
fn a_swapped_picture_fails_its_test() {
    let left = Picture::from_fn(SIZE, |x, _| [if x < 20 { 255 } else { 0 }, 0, 0, 255]);
    left.assert_same(&left.flipped(), "meant-to-fail");
}

#[test]
fn a_single_wrong_pixel_fails() {
    let black = Picture::from_fn(SIZE, |_, _| [0, 0, 0, 255]);
    let dot = Picture::from_fn(SIZE, |x, y| {
        [0, 0, if (x, y) == (7, 9) { 3 } else { 0 }, 255]
    });
    let unlike = dot.alike(&black, 2, 1.0, |_| true);
    assert!(matches!(unlike, Err(Unlike::Pixels(d)) if d.beyond == 1 && d.at == UVec2::new(7, 9)));
    assert!(dot.alike(&black, 3, 1.0, |_| true).is_ok());
    assert!(
        dot.alike(&black, 2, 0.999, |_| true).is_ok(),
        "one in 3072 is less than a thousandth"
    );
}

#[test]
fn an_empty_picture_fails() {
    assert!(
        Picture::from_fn(SIZE, |_, _| [1, 2, 3, 255])
            .shows_something()
            .is_err()
    );
    assert!(Picture::new(UVec2::ZERO, Vec::new()).is_none());
    assert!(Picture::new(SIZE, vec![[0; 4]; 5]).is_none());
}

#[test]
#[should_panic(expected = "is nothing but")]
fn a_scene_without_anything_fails() {
    let mut scene = Scene::new("nothing");
    scene.size = SIZE;
    drawn(&scene);
}

#[test]
fn a_missing_picture_fails() {
    let mut stage = Stage::stock();
    let target = stage.target(SIZE);
    stage
        .world()
        .resource_mut::<Assets<Image>>()
        .remove(&target);
    assert_eq!(stage.settle(&target, SIZE).unwrap_err(), NoPicture::Missing);
}

#[test]
fn a_picture_of_the_wrong_size_fails() {
    let mut stage = Stage::stock();
    let target = stage.target(SIZE * 2);
    build_plain(&mut stage, &two_boxes(), target.clone());
    let wrong = stage.settle(&target, SIZE);
    assert_eq!(
        wrong.unwrap_err(),
        NoPicture::WrongSize {
            actual: SIZE * 2,
            expected: SIZE
        }
    );
    let small = Picture::from_fn(SIZE, |x, _| [x as u8; 4]);
    let large = Picture::from_fn(SIZE * 2, |x, _| [x as u8; 4]);
    let unlike = small.alike(&large, 2, 0.5, |_| true);
    assert_eq!(
        unlike,
        Err(Unlike::WrongSize {
            actual: SIZE,
            expected: SIZE * 2
        })
    );
}

#[test]
fn comparing_nothing_fails() {
    let picture = Picture::from_fn(SIZE, |x, _| [x as u8; 4]);
    assert_eq!(
        picture.alike(&picture, 2, 0.5, |_| false),
        Err(Unlike::NothingCompared)
    );
}

#[test]
#[should_panic(expected = "reports errors")]
fn an_error_of_the_renderer_fails() {
    use bevy::render::{render_resource::*, renderer::RenderDevice};
    let mut stage = Stage::stock();
    stage.frame();
    let device = stage.world().resource::<RenderDevice>().clone();
    device.create_buffer(&BufferDescriptor {
        label: Some("too large for any device"),
        size: u64::MAX / 2,
        usage: BufferUsages::UNIFORM,
        mapped_at_creation: false,
    });
    stage.frame();
}

#[test]
fn the_reflected_eye_is_where_one_expects_it() {
    let floor = Plane::through(default(), Vec3::Y.as_dvec3());
    let eye = Transform::from_xyz(3.0, 2.0, 1.0).looking_at(vec3(0.0, 1.0, -4.0), Vec3::Y);
    let reflected = reflected_eye(&eye, floor);
    let flip = vec3(1.0, -1.0, 1.0);
    assert!(
        reflected
            .translation
            .abs_diff_eq(eye.translation * flip, 1e-6)
    );
    assert!(reflected.forward().abs_diff_eq(*eye.forward() * flip, 1e-6));
    assert!(reflected.up().abs_diff_eq(*eye.up() * flip, 1e-6));
    // Left and right are exchanged, else the frame would be left-handed.
    assert!(reflected.right().abs_diff_eq(-*eye.right() * flip, 1e-6));
}

/// Straight before a wall, a box at the eye's height: by symmetry the reflection is as far right as
/// the box, and smaller by the ratio of the distances.
#[test]
fn the_reference_puts_a_reflection_where_geometry_says() {
    let scene = Scene::new("by-hand")
        .eye(vec3(0.0, 0.0, 4.0), Vec3::ZERO)
        .mirror(Surface::wall(4.0, 3.0, Transform::default()))
        .object(Cuboid::from_length(0.5), RED, at(1.0, 0.5, 2.0))
        .object(Cuboid::from_length(3.0), BLUE, at(0.0, 0.0, -2.0));
    let mut studio = Studio::default();
    let reference = studio.reference(&scene, 0);
    let seen = reference.centroid(is(RED)).expect("the box is reflected");
    // The front of the reflected box is 4 + 1.75 from the eye.
    let focal = 60.0 / 22.5_f32.to_radians().tan();
    let expected = vec2(80.0, 60.0) + focal * vec2(1.0, -0.5) / 5.75;
    assert!(
        seen.distance(expected) < 2.0,
        "at {seen}, expected near {expected}"
    );
    assert_eq!(
        reference.count(is(BLUE)),
        0,
        "what is behind the mirror is cut away"
    );
    let mask = studio.mask(&scene, 0);
    assert!(mask.inside_count() > 1000);
    assert!(mask.picture().count(is(Color::BLACK)) > 1000);
}

/// In a reference the lights still see what the camera no longer does.
#[test]
fn a_cut_object_throws_its_whole_shadow_in_the_reference() {
    let scene = super::shadows::shadow_from_behind();
    let mut studio = Studio::default();
    let shadow = studio.reference(&scene, 0);
    let mut open = scene.clone();
    open.objects.remove(0);
    let light = studio.reference(&open, 0);
    let darker = shadow.difference(&light, 8, |_| true).expect("one size");
    assert!(darker.beyond > 50, "{darker}");
}

/// However it is scaled: a wall that is flattened, or turned inside out along any of its axes.
#[test]
fn the_front_of_a_surface_is_where_its_transform_takes_it() {
    for scale in [
        Vec3::ONE,
        vec3(1.0, 1.0, 0.0),
        vec3(-1.0, 1.0, 1.0),
        vec3(1.0, -2.0, 1.0),
        vec3(-1.0, -1.0, 1.0),
    ] {
        let turned = Surface::wall(1.0, 1.0, Transform::from_scale(scale));
        assert_eq!(turned.plane().normal, DVec3::Z, "{scale}");
    }
    let turned = Surface::wall(1.0, 1.0, Transform::from_scale(vec3(1.0, 1.0, -1.0)));
    assert_eq!(turned.plane().normal, DVec3::NEG_Z);
}
