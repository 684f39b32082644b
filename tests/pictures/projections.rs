//! Lenses: narrow and wide, near and far planes, orthographic of every kind, off the center, on scaled and rolled
//! cameras.

use bevy::{
    camera::{CameraProjection, ScalingMode, SubCameraView},
    math::Vec3A,
    prelude::*,
};

use crate::support::{
    hall::{CROSSING, FLOOR, hall, sunny_hall},
    props::{BLUE, RED, at, is},
    scene::{Look, Scene, Surface},
    studio::{Studio, TOLERANCE},
};

/// The hall with a lens that shows so many degrees, from where the mirror fills a good part of the view.
fn through(name: &str, degrees: f32) -> Scene {
    let half = (degrees.to_radians() / 2.0).tan();
    // Wide lenses from near by, so near that the crossing box is out of the way.
    let distance = (1.3 / half).max(0.9);
    let eye = vec3(0.2, 0.5, 1.0) * distance.max(1.0);
    let mut scene = hall(name).eye(eye, vec3(0.0, 0.4, 0.0)).fov(degrees);
    if distance < 3.0 {
        // Out of the eye.
        scene.objects[0].transform = at(-1.4, 0.4, 0.8);
        scene.objects[1].transform = at(1.1, 0.1, 0.6);
    }
    scene
}

#[test]
fn every_field_of_view_reflects() {
    let mut studio = Studio::default();
    for degrees in [1.0, 10.0, 45.0, 90.0, 120.0, 170.0] {
        studio.assert_reflects(&through(&format!("fov-{degrees}"), degrees));
    }
}

#[test]
fn very_wide_and_very_high_pictures_reflect() {
    let mut studio = Studio::default();
    for size in [uvec2(400, 40), uvec2(40, 400)] {
        let mut scene = sunny_hall(&format!("aspect-{}x{}", size.x, size.y));
        scene.size = size;
        studio.assert_reflects(&scene);
    }
}

/// Everything of the hall grown by a factor, the eye's place too.
fn grown(mut scene: Scene, factor: f32) -> Scene {
    let grow = |transform: &mut Transform| {
        transform.translation *= factor;
        transform.scale *= factor;
    };
    scene.eye.translation *= factor;
    scene
        .mirrors
        .iter_mut()
        .for_each(|mirror| grow(&mut mirror.transform));
    scene
        .objects
        .iter_mut()
        .for_each(|object| grow(&mut object.transform));
    scene
}

#[test]
fn near_and_far_planes_of_any_distance_reflect() {
    let mut studio = Studio::default();
    for (near, far, factor) in [
        (1e-3, 1000.0, 1.0),
        (1e-3, 1000.0, 0.01),
        (1.5, 40.0, 1.0),
        (100.0, 1e5, 200.0),
    ] {
        let name = format!("near-{near}-grown-{factor}");
        let mut scene = grown(sunny_hall(&name), factor);
        scene.projection = PerspectiveProjection {
            near,
            far,
            ..default()
        }
        .into();
        studio.assert_reflects(&scene);
    }
}

/// The near plane of the camera is that of its reflection: what is nearer to the eye by way of the mirror is not
/// drawn either. And a mirror partly before the near plane is seen as far as it is drawn.
#[test]
fn a_near_plane_through_the_mirror_cuts_it_off() {
    let mut scene = hall("near-through-mirror").eye(vec3(1.4, 0.6, 0.9), vec3(-1.0, 0.4, 0.3));
    scene.projection = PerspectiveProjection {
        near: 1.1,
        fov: 1.2,
        ..default()
    }
    .into();
    Studio::default().assert_reflects(&scene);
}

/// A frustum as by four numbers and two planes, reversed depth, as a head-mounted display has it.
#[derive(Clone, Debug)]
struct Frustum {
    /// The left, right, bottom and top edge at a distance of 1.
    edges: [f32; 4],
    near: f32,
    far: f32,
}

impl CameraProjection for Frustum {
    fn get_clip_from_view(&self) -> Mat4 {
        let [left, right, bottom, top] = self.edges;
        let (near, far) = (self.near, self.far);
        let (width, height) = (right - left, top - bottom);
        let depth = far - near;
        Mat4::from_cols(
            vec4(2.0 / width, 0.0, 0.0, 0.0),
            vec4(0.0, 2.0 / height, 0.0, 0.0),
            vec4(
                (right + left) / width,
                (top + bottom) / height,
                near / depth,
                -1.0,
            ),
            vec4(0.0, 0.0, near * far / depth, 0.0),
        )
    }

    fn get_clip_from_view_for_sub(&self, _: &SubCameraView) -> Mat4 {
        self.get_clip_from_view()
    }

    fn update(&mut self, _width: f32, _height: f32) {}

    fn far(&self) -> f32 {
        self.far
    }

    fn get_frustum_corners(&self, z_near: f32, z_far: f32) -> [Vec3A; 8] {
        let [left, right, bottom, top] = self.edges;
        let corner = |x: f32, y: f32, z: f32| Vec3A::new(x * -z, y * -z, z);
        let face = |z: f32| {
            [(right, bottom), (right, top), (left, top), (left, bottom)]
                .map(|(x, y)| corner(x, y, z))
        };
        let ([a, b, c, d], [e, f, g, h]) = (face(z_near), face(z_far));
        [a, b, c, d, e, f, g, h]
    }
}

#[test]
fn a_projection_of_the_users_own_off_the_center_and_with_a_far_plane_reflects() {
    let mut studio = Studio::default();
    for (name, edges, far) in [
        ("finite", [-0.55, 0.55, -0.41, 0.41], 30.0),
        ("near-far", [-0.55, 0.55, -0.41, 0.41], 12.0),
        ("right", [-0.3, 0.8, -0.41, 0.41], 30.0),
        ("up-left", [-0.9, 0.2, -0.25, 0.6], 30.0),
    ] {
        let mut scene = sunny_hall(&format!("frustum-{name}"));
        scene.projection = Projection::custom(Frustum {
            edges,
            near: 0.1,
            far,
        });
        studio.assert_reflects_in_place(&scene);
    }
}

fn orthographic(scaling_mode: ScalingMode) -> Projection {
    OrthographicProjection {
        scaling_mode,
        ..OrthographicProjection::default_3d()
    }
    .into()
}

/// Straight on, at an angle, and along the plane with a mirror long enough to be seen.
#[test]
fn orthographic_cameras_of_every_angle_reflect() {
    let mut studio = Studio::default();
    for (degrees, height) in [(0.0, 3.2), (45.0, 3.2), (80.0, 3.2), (89.9, 0.4)] {
        let angle = f32::to_radians(degrees);
        let out = vec3(angle.sin(), 0.0, angle.cos());
        let mut scene =
            hall(&format!("orthographic-{degrees}")).eye(out * 60.0, vec3(0.0, 0.4, 0.0));
        scene.projection = orthographic(ScalingMode::FixedVertical {
            viewport_height: height,
        });
        if degrees > 89.0 {
            scene.objects.clear();
            scene = scene
                .mirror(Surface::wall(160.0, 2.2, at(0.0, 0.5, 0.0)))
                .object(Cuboid::new(160.0, 0.1, 0.2), RED, at(0.0, 0.45, 0.15))
                .object(Cuboid::new(2.0, 0.05, 0.2), BLUE, at(3.0, 0.35, 0.1));
            scene.mirrors.remove(0);
        }
        studio.assert_reflects(&scene);
    }
}

#[test]
fn orthographic_cameras_of_every_scaling_mode_reflect() {
    let mut studio = Studio::default();
    let modes = [
        ScalingMode::WindowSize,
        ScalingMode::Fixed {
            width: 5.0,
            height: 2.5,
        },
        ScalingMode::FixedHorizontal {
            viewport_width: 4.0,
        },
        ScalingMode::FixedVertical {
            viewport_height: 3.0,
        },
        ScalingMode::AutoMin {
            min_width: 2.0,
            min_height: 3.0,
        },
        ScalingMode::AutoMax {
            max_width: 4.0,
            max_height: 6.0,
        },
    ];
    for mode in modes {
        let mut scene = hall(&format!("{mode:?}"));
        // A unit is a pixel there.
        if matches!(mode, ScalingMode::WindowSize) {
            scene = grown(scene, 40.0);
        }
        scene.projection = orthographic(mode);
        studio.assert_reflects(&scene);
    }
}

/// Without things that cross the mirror the projection stays the camera's own, and so does all of the light.
#[test]
fn an_orthographic_camera_reflects_by_daylight() {
    let mut scene = sunny_hall("orthographic-lit");
    // The floor, which begins behind it, is moved before it.
    scene.objects[FLOOR].transform.translation.z = 3.05;
    scene.objects.remove(CROSSING);
    scene.projection = orthographic(ScalingMode::FixedVertical {
        viewport_height: 3.2,
    });
    Studio::default().assert_reflects(&scene);
}

/// Where something crosses it, unlit objects are right to the pixel. Of lit ones the engine takes the
/// view direction from the depth row, which is the mirror's normal then: a limit, see the crate's docs.
#[test]
fn an_orthographic_camera_reflects_what_crosses_the_mirror() {
    let mut scene = hall("orthographic-cut");
    scene.projection = orthographic(ScalingMode::FixedVertical {
        viewport_height: 3.2,
    });
    Studio::default().assert_reflects(&scene);
}

#[test]
fn a_rolled_camera_reflects() {
    let mut studio = Studio::default();
    for degrees in [30.0, 90.0, 180.0, -117.0] {
        let mut scene = sunny_hall(&format!("rolled-{degrees}"));
        scene.eye.rotate_local_z(f32::to_radians(degrees));
        studio.assert_reflects(&scene);
    }
}

/// A scaled camera sees what one sees whose view is scaled the other way.
#[test]
fn a_scaled_camera_reflects() {
    let mut studio = Studio::default();
    for (name, scale) in [
        ("twice", Vec3::splat(2.0)),
        ("small", Vec3::splat(0.01)),
        ("higher", vec3(1.0, 1.5, 1.0)),
        ("uneven", vec3(0.8, 1.2, 3.0)),
    ] {
        let mut scene = hall(&format!("scaled-{name}"));
        scene.eye.scale = scale;
        studio.assert_reflects_in_place(&scene);
        if scale.min_element() == scale.max_element() {
            let unscaled = studio.picture(&hall("unscaled"));
            let scaled = studio.picture(&scene);
            scaled.assert_alike(&unscaled, TOLERANCE, 0.9995, |_| true, &scene.name);
        }
    }
}

/// The camera's own transform is whole; that of its parent scales it, and may shear it.
#[test]
fn a_camera_on_a_scaled_parent_reflects() {
    let mut studio = Studio::default();
    let straight = hall("unparented");
    let expected = studio.assert_reflects(&straight);
    for projection in [
        straight.projection.clone(),
        orthographic(ScalingMode::FixedVertical {
            viewport_height: 1.5,
        }),
    ] {
        let is_orthographic = matches!(projection, Projection::Orthographic(_));
        let mut scene = hall(&format!("parented-orthographic-{is_orthographic}"));
        scene.projection = projection;
        let eye = scene.eye;
        scene = scene.lens(move |camera| {
            let parent = camera
                .world_scope(|world| world.spawn(Transform::from_scale(Vec3::splat(2.0))).id());
            let local = eye.with_translation(eye.translation / 2.0);
            camera.insert((ChildOf(parent), local));
        });
        let expected = if is_orthographic {
            let mut straight = straight.clone();
            straight.name = "unparented-orthographic".to_owned();
            straight.projection = orthographic(ScalingMode::FixedVertical {
                viewport_height: 3.0,
            });
            studio.assert_reflects(&straight)
        } else {
            expected.clone()
        };
        let picture = studio.picture(&scene);
        picture.assert_alike(&expected, TOLERANCE, 0.9995, |_| true, &scene.name);
    }
}

/// Left and right are not exchanged: a thing on the right is reflected on the right.
#[test]
fn what_is_on_the_right_is_seen_on_the_right() {
    for projection in [
        Projection::from(PerspectiveProjection::default()),
        orthographic(ScalingMode::FixedVertical {
            viewport_height: 3.0,
        }),
    ] {
        let mut scene = Scene::new("right")
            .eye(vec3(0.0, 0.0, 4.0), Vec3::ZERO)
            .mirror(Surface::wall(4.0, 3.0, default()))
            .object(Cuboid::from_length(0.5), Look::from(RED), at(0.8, 0.3, 5.0));
        scene.projection = projection;
        let picture = Studio::default().picture(&scene);
        let seen = picture.centroid(is(RED)).expect("the box is reflected");
        assert!(seen.x > 90.0 && seen.y < 57.0, "at {seen}");
    }
}
