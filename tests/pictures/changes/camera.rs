//! Cameras that change how they draw, where to, and how much of it.

use bevy::{
    camera::{Hdr, ScalingMode, Viewport},
    prelude::*,
    render::render_resource::Extent3d,
};

use super::{add, insert, remove, room};
use crate::support::live::{Live, assert_each_seen_at_once, of};

#[test]
fn samples_and_formats_are_switched_at_run_time() {
    // Bright enough that a format without room for it would show.
    let bright = |world: &mut World| {
        let material = StandardMaterial {
            base_color: LinearRgba::rgb(0.6, 2.5, 4.0).into(),
            unlit: true,
            ..default()
        };
        let material = add(world, material);
        insert(world, "ball", MeshMaterial3d(material));
    };
    assert_each_seen_at_once(
        &room("formats"),
        &[
            &|world| *of::<Msaa>(world, "camera") = Msaa::Sample4,
            &|world| {
                insert(world, "camera", Hdr);
                bright(world);
            },
            &|world| *of::<Msaa>(world, "camera") = Msaa::Off,
            &|world| *of::<Msaa>(world, "camera") = Msaa::Sample4,
            &|world| {
                remove::<Hdr>(world, "camera");
                *of::<Msaa>(world, "camera") = Msaa::Off;
            },
        ],
    );
}

#[test]
fn a_viewport_may_change_in_every_frame() {
    fn view(x: u32, y: u32, w: u32, h: u32) -> impl Fn(&mut World) {
        move |world| {
            of::<Camera>(world, "camera").viewport = Some(Viewport {
                physical_position: UVec2::new(x, y),
                physical_size: UVec2::new(w, h),
                ..default()
            });
        }
    }
    assert_each_seen_at_once(
        &room("viewport"),
        &[
            &view(10, 6, 70, 60),
            &view(0, 0, 40, 72),
            &view(48, 24, 48, 48),
            &|world| of::<Camera>(world, "camera").viewport = None,
        ],
    );
}

#[test]
fn a_target_that_changes_its_size_shows_the_reflection_in_it() {
    let scene = room("resized");
    let mut live = Live::new(&scene);
    live.settled();
    for (step, size) in [(48, 36), (133, 71), (7, 90), (96, 72)]
        .into_iter()
        .enumerate()
    {
        live.size = size.into();
        let extent = Extent3d {
            width: size.0,
            height: size.1,
            ..default()
        };
        let target = live.target.clone();
        let mut images = live.world().resource_mut::<Assets<Image>>();
        images.get_mut(&target).expect("it is there").resize(extent);
        // The engine itself tells its cameras of a new size a frame later.
        live.stage.frame();
        let picture = live.next();
        let mut expected = scene.clone();
        expected.size = live.size;
        let expected = Live::new(&expected).settled();
        picture.assert_same(&expected, &format!("resized-{step}"));
    }
}

#[test]
fn a_camera_that_changes_its_target_takes_the_reflection_along() {
    let scene = room("other-target");
    let mut live = Live::new(&scene);
    live.settled();
    live.size = UVec2::new(60, 60);
    live.target = live.stage.target(live.size);
    let target = bevy::camera::RenderTarget::from(live.target.clone());
    insert(live.world(), "camera", target);
    // Bevy itself looks at a camera's target only when something else of it changes too.
    of::<Projection>(live.world(), "camera").set_changed();
    let mut expected = scene.clone();
    expected.size = live.size;
    let picture = live.next();
    picture.assert_same(&Live::new(&expected).settled(), "other-target");
}

#[test]
fn a_projection_may_change_its_kind() {
    fn project(projection: impl Into<Projection> + Clone) -> impl Fn(&mut World) {
        move |world| *of::<Projection>(world, "camera") = projection.clone().into()
    }
    let flat = OrthographicProjection {
        scaling_mode: ScalingMode::FixedVertical {
            viewport_height: 2.5,
        },
        ..OrthographicProjection::default_3d()
    };
    let fov = |degrees: f32| PerspectiveProjection {
        fov: degrees.to_radians(),
        ..default()
    };
    assert_each_seen_at_once(
        &room("projections"),
        &[
            &project(flat.clone()),
            &project(fov(80.0)),
            &project(fov(20.0)),
            &project(flat),
        ],
    );
}
