//! What a reflected view takes from its camera.

use std::collections::HashSet;

use bevy::{
    camera::{Exposure, RenderTarget, SubCameraView, Viewport, visibility::RenderLayers},
    light::Cascades,
    prelude::*,
    render::view::Msaa,
};
use bevy_planar_mirror::NotDrawn;

use super::app::{EYE, PLAIN, SIZE, mirror_app, not};

fn fov(projection: &Projection) -> f32 {
    match projection {
        Projection::Perspective(perspective) => perspective.fov,
        other => panic!("{other:?}"),
    }
}

fn wide() -> Projection {
    PerspectiveProjection {
        fov: 1.3,
        ..default()
    }
    .into()
}

#[test]
fn a_new_view_has_what_its_camera_already_had() {
    let mut app = mirror_app();
    let camera = app.spawn_camera(EYE);
    app.insert(
        camera,
        (
            Msaa::Sample2,
            Exposure { ev100: 3.0 },
            wide(),
            RenderLayers::from_layers(&[0, 3]),
        ),
    );
    // The camera is old by the time when the mirror comes.
    app.updates(3);
    let mirror = app.spawn_mirror(default());
    app.update();
    let view = app.view(camera, mirror);
    assert_eq!(*app.of::<Msaa>(view), Msaa::Sample2);
    assert_eq!(app.of::<Exposure>(view).ev100, 3.0);
    assert_eq!(fov(app.of::<Projection>(view)), 1.3);
    assert_eq!(
        *app.of::<RenderLayers>(view),
        RenderLayers::from_layers(&[0, 3])
    );
}

#[test]
fn a_view_follows_what_its_camera_gains_changes_and_loses() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.updates(2);
    let view = app.view(camera, mirror);
    app.insert(
        camera,
        (RenderLayers::from_layers(&[0, 5]), DistanceFog::default()),
    );
    app.update();
    assert_eq!(
        *app.of::<RenderLayers>(view),
        RenderLayers::from_layers(&[0, 5])
    );
    assert!(app.world().entity(view).contains::<DistanceFog>());
    *app.of_mut::<Msaa>(camera) = Msaa::Off;
    app.of_mut::<DistanceFog>(camera).color = Color::srgb(1.0, 0.0, 0.0);
    *app.of_mut::<Projection>(camera) = wide();
    app.update();
    assert_eq!(*app.of::<Msaa>(view), Msaa::Off);
    assert_eq!(
        app.of::<DistanceFog>(view).color,
        Color::srgb(1.0, 0.0, 0.0)
    );
    assert_eq!(fov(app.of::<Projection>(view)), 1.3);
    app.remove::<(RenderLayers, DistanceFog)>(camera);
    app.update();
    assert!(!app.world().entity(view).contains::<RenderLayers>());
    assert!(!app.world().entity(view).contains::<DistanceFog>());
    // Also what every 3D camera begins with.
    app.remove::<Exposure>(camera);
    app.update();
    assert!(!app.world().entity(view).contains::<Exposure>());
    assert_eq!(
        app.view(camera, mirror),
        view,
        "it is the same view all along"
    );
}

#[test]
fn a_view_has_the_size_viewport_and_projection_of_its_camera_in_the_same_frame() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    let check = |app: &mut super::app::MirrorApp, size: UVec2| {
        app.update();
        let view = app.view(camera, mirror);
        let (main, reflected) = (app.of::<Camera>(camera), app.of::<Camera>(view));
        assert_eq!(main.physical_viewport_size(), Some(size));
        assert_eq!(
            reflected.physical_viewport_rect(),
            main.physical_viewport_rect()
        );
        assert_eq!(reflected.clip_from_view(), main.clip_from_view());
        let RenderTarget::None { size } = *app.of::<RenderTarget>(view) else {
            panic!("a view draws into no target of its own");
        };
        assert_eq!(Some(size), main.physical_target_size());
    };
    check(&mut app, SIZE);
    app.of_mut::<Camera>(camera).viewport = Some(Viewport {
        physical_position: uvec2(50, 20),
        physical_size: uvec2(80, 60),
        ..default()
    });
    check(&mut app, uvec2(80, 60));
    app.of_mut::<Camera>(camera).sub_camera_view = Some(SubCameraView {
        full_size: uvec2(160, 120),
        offset: vec2(20.0, 10.0),
        size: uvec2(80, 60),
    });
    check(&mut app, uvec2(80, 60));
    *app.of_mut::<Projection>(camera) = OrthographicProjection::default_3d().into();
    app.of_mut::<Transform>(camera).translation.z = 90.0;
    app.of_mut::<Transform>(mirror).scale = Vec3::splat(50.0);
    check(&mut app, uvec2(80, 60));
}

#[test]
fn a_resized_target_resizes_the_view_and_an_empty_one_ends_it() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.update();
    // Windows are minimized to zero; an image cannot be that small.
    let window = app.spawn(Window::default());
    app.insert(
        camera,
        RenderTarget::Window(bevy::window::WindowRef::Entity(window)),
    );
    for (size, expected) in [
        (uvec2(300, 200), PLAIN),
        (uvec2(0, 0), not(NotDrawn::NoTarget)),
        (uvec2(120, 0), not(NotDrawn::NoTarget)),
        (uvec2(120, 90), PLAIN),
    ] {
        app.of_mut::<Window>(window)
            .resolution
            .set_physical_resolution(size.x, size.y);
        app.world_mut().write_message(bevy::window::WindowResized {
            window,
            width: size.x as f32,
            height: size.y as f32,
        });
        app.update();
        app.assert_state(mirror, camera, expected);
        for view in app.views() {
            assert_eq!(app.of::<Camera>(view).physical_target_size(), Some(size));
        }
        assert_eq!(app.views().len(), usize::from(expected == PLAIN));
    }
}

/// Bevy warns of cameras with equal orders and targets, and draws lower orders first.
#[test]
fn views_come_before_every_camera_and_no_two_at_once() {
    let mut app = mirror_app();
    for x in [-1.0, 0.0, 1.0] {
        app.spawn_mirror(Transform::from_xyz(x, 0.0, 0.1 * x));
    }
    for order in [-7, 0, 3] {
        let camera = app.spawn_camera(EYE);
        app.of_mut::<Camera>(camera).order = order;
    }
    app.update();
    let orders: Vec<_> = app
        .views()
        .iter()
        .map(|&view| app.of::<Camera>(view).order)
        .collect();
    assert_eq!(orders.len(), 9);
    assert!(orders.iter().all(|&order| order < -7), "{orders:?}");
    let distinct: HashSet<_> = orders.iter().collect();
    assert_eq!(distinct.len(), 9, "{orders:?}");
}

/// A light has shadow cascades for each view, of this frame's views and no others.
#[test]
fn lights_know_the_views_of_the_same_frame() {
    let mut app = mirror_app();
    let light = app.spawn((
        DirectionalLight {
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::default().looking_to(vec3(1.0, -2.0, -1.0), Vec3::Y),
    ));
    app.spawn((PointLight::default(), Transform::from_xyz(0.0, 1.0, 1.0)));
    app.spawn((SpotLight::default(), Transform::from_xyz(0.0, 2.0, 1.0)));
    app.spawn_cube(0.3, vec3(0.3, 0.0, 1.0));
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    for shown in [true, false, true] {
        app.insert(
            mirror,
            if shown {
                Visibility::Visible
            } else {
                Visibility::Hidden
            },
        );
        app.update();
        let mut expected = app.views();
        assert_eq!(expected.len(), usize::from(shown));
        expected.push(camera);
        expected.sort();
        let cascades = &app.of::<Cascades>(light).cascades;
        let mut known: Vec<Entity> = cascades.keys().copied().collect();
        known.sort();
        assert_eq!(known, expected);
    }
}

#[test]
fn a_view_has_a_place_but_no_transform_of_its_own() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.update();
    let view = app.view(camera, mirror);
    let view = app.world().entity(view);
    assert!(view.contains::<GlobalTransform>());
    assert!(!view.contains::<Transform>());
    assert!(!view.contains::<ChildOf>());
}
