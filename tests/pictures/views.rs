//! Where a camera draws: viewports, parts of a larger view, several cameras in one target or in several, one over the
//! other, and which of them see a mirror at all.

use bevy::{
    camera::{
        ClearColorConfig, MainPassResolutionOverride, RenderTarget, SubCameraView, Viewport,
        visibility::RenderLayers,
    },
    prelude::*,
    render::{
        Render, RenderApp, RenderSystems,
        camera::{ExtractedCamera, TemporalJitter},
    },
};
use bevy_planar_mirror::{MirrorState, NoMirrors, NotDrawn, PlanarMirrorPlugin};

use super::cameras::states;
use crate::support::{
    hall::{hall, sunny_hall},
    live::Live,
    picture::Picture,
    props::{GREEN, MAGENTA, RED, YELLOW, at, is, lamp},
    scene::{Look, Scene, Surface},
    set::{add_camera, build_plain, build_with_mirrors},
    stage::Stage,
    studio::{SHARE, Studio, TOLERANCE},
};

/// Less than the target, away from its corner, and of another shape.
const OFFSET: UVec2 = uvec2(37, 21);
const PART: UVec2 = uvec2(101, 83);

fn viewport(scene: Scene, offset: UVec2, size: UVec2) -> Scene {
    scene.lens(move |camera| {
        edit(camera, |camera| {
            camera.viewport = Some(Viewport {
                physical_position: offset,
                physical_size: size,
                ..default()
            });
        });
    })
}

fn edit(entity: &mut EntityWorldMut, change: impl FnOnce(&mut Camera)) {
    let mut camera = entity
        .get_mut::<Camera>()
        .expect("a lens belongs to a camera");
    change(&mut camera);
}

#[test]
fn a_viewport_with_an_offset_reflects_and_keeps_to_itself() {
    let mut studio = Studio::default();
    for (msaa, hdr) in [
        (Msaa::Off, false),
        (Msaa::Sample4, false),
        (Msaa::Off, true),
        (Msaa::Sample4, true),
    ] {
        let scene = sunny_hall(&format!("viewport-{msaa:?}-hdr-{hdr}"));
        let mut scene = viewport(scene, OFFSET, PART);
        // The lamp lights a part of the hall alone, so the clusters of lights have to fit the viewport.
        scene = scene.prop(lamp(vec3(-0.9, 0.9, 1.9), false));
        scene.msaa = msaa;
        if hdr {
            scene = scene.hdr();
        }
        studio.assert_reflects_in_place(&scene);
    }
}

/// With a mirror all over the view, nothing but the viewport itself holds the reflection back.
#[test]
fn a_mirror_that_fills_the_viewport_does_not_leave_it() {
    let mut studio = Studio::default();
    for (name, offset, size) in [
        ("corner", UVec2::ZERO, uvec2(50, 40)),
        ("far-corner", uvec2(110, 80), uvec2(50, 40)),
        ("middle", uvec2(61, 47), uvec2(33, 27)),
    ] {
        let mut scene = viewport(hall(&format!("filled-{name}")), offset, size);
        scene.mirrors[0] = Surface::wall(80.0, 60.0, at(0.0, 0.5, 0.0));
        let picture = studio.assert_reflects_in_place(&scene);
        let beyond = |place: UVec2| place.cmplt(offset).any() || place.cmpge(offset + size).any();
        let plain = studio.without_mirrors(&scene);
        picture.assert_alike(&plain, 0, 1.0, beyond, &format!("{}-beyond", scene.name));
    }
}

#[test]
fn a_part_of_a_larger_view_reflects() {
    let mut studio = Studio::default();
    for (name, offset) in [("left", vec2(0.0, 0.0)), ("middle", vec2(0.7, 0.4))] {
        for projection in [
            Projection::from(PerspectiveProjection::default()),
            OrthographicProjection {
                scaling_mode: bevy::camera::ScalingMode::FixedVertical {
                    viewport_height: 3.2,
                },
                ..OrthographicProjection::default_3d()
            }
            .into(),
        ] {
            let mut scene = hall(&format!("sub-view-{name}"));
            let size = scene.size;
            scene.projection = projection;
            scene = scene.lens(move |camera| {
                edit(camera, |camera| {
                    camera.sub_camera_view = Some(SubCameraView {
                        full_size: size * 2,
                        offset: offset * size.as_vec2(),
                        size,
                    });
                });
            });
            studio.assert_reflects_in_place(&scene);
        }
    }
}

/// What upscalers do: the main pass draws a smaller picture into the corner of its target.
#[test]
fn a_main_pass_of_lower_resolution_reflects() {
    fn lower_resolution(app: &mut App) {
        let lower = |mut commands: Commands, cameras: Query<(Entity, &ExtractedCamera)>| {
            for (entity, camera) in &cameras {
                // The override belongs to the user's cameras, as an upscaler would give it.
                if camera.target.is_some() {
                    let resolution = MainPassResolutionOverride(uvec2(96, 72));
                    commands.entity(entity).insert(resolution);
                }
            }
        };
        app.sub_app_mut(RenderApp)
            .add_systems(Render, lower.in_set(RenderSystems::PrepareViews));
    }
    for msaa in [Msaa::Off, Msaa::Sample4] {
        let mut scene = sunny_hall(&format!("override-{msaa:?}")).plugin(lower_resolution);
        scene.msaa = msaa;
        Studio::of(&scene).assert_reflects_in_place(&scene);
    }
}

/// The other camera: from the left, over less of the scene.
fn from_the_left(scene: &Scene) -> Scene {
    let mut other = scene.clone().eye(vec3(-1.6, 0.9, 3.4), vec3(0.2, 0.5, 0.0));
    other.name = format!("{}-left", scene.name);
    other
}

fn order(scene: Scene, order: isize, clear: ClearColorConfig) -> Scene {
    scene.touch_camera(move |camera| {
        edit(camera, |camera| {
            camera.order = order;
            camera.clear_color = clear;
        });
    })
}

/// The scene of the first camera, seen by all, in one target.
#[track_caller]
fn together(
    stage: &mut Stage,
    build: fn(&mut Stage, &Scene, Handle<Image>) -> Entity,
    cameras: &[Scene],
) -> Picture {
    let size = cameras[0].size;
    let target = stage.target(size);
    build(stage, &cameras[0], target.clone());
    for camera in &cameras[1..] {
        add_camera(stage, camera, target.clone());
    }
    stage.picture(&target, size)
}

#[test]
fn two_cameras_share_a_target_and_each_shows_its_own_reflection() {
    let half = uvec2(80, 120);
    for (msaa, hdr) in [(Msaa::Off, false), (Msaa::Sample4, true)] {
        let mut scene = sunny_hall(&format!("split-{msaa:?}-hdr-{hdr}"));
        scene.msaa = msaa;
        if hdr {
            scene = scene.hdr();
        }
        let right = viewport(scene.clone(), uvec2(80, 0), half);
        let left = viewport(from_the_left(&scene), UVec2::ZERO, half);
        let mut studio = Studio::default();
        let alone = [&right, &left].map(|camera| studio.assert_reflects_in_place(camera));

        let right = order(right, 0, ClearColorConfig::Default);
        let left = order(left, 1, ClearColorConfig::None);
        let mut stage = Stage::with_mirrors();
        let picture = together(&mut stage, build_with_mirrors, &[right, left]);
        let of = |index: usize| move |place: UVec2| (place.x < 80) == (index == 1);
        for (index, alone) in alone.iter().enumerate() {
            let what = format!("{}-{index}", scene.name);
            // The second camera must not clear the first one's half, and what is left of the clear color is
            // then mapped to the screen twice.
            let tolerance = if hdr { TOLERANCE } else { 0 };
            picture.assert_alike(alone, tolerance, 1.0, of(index), &what);
        }
    }
}

/// The one that draws later covers the other, whichever was spawned first.
#[test]
fn a_picture_in_the_picture_shows_its_own_reflection() {
    let scene = hall("inset");
    let inset = viewport(from_the_left(&scene), uvec2(100, 10), uvec2(50, 40));
    let mut studio = Studio::default();
    let (around, within) = (studio.picture(&scene), studio.picture(&inset));
    let later = order(inset, 5, ClearColorConfig::None);
    let sooner = order(scene, -5, ClearColorConfig::Default);
    for cameras in [
        [sooner.clone(), later.clone()],
        [later.clone(), sooner.clone()],
    ] {
        let mut stage = Stage::with_mirrors();
        let picture = together(&mut stage, build_with_mirrors, &cameras);
        let inside =
            |place: UVec2| place.cmpge(uvec2(100, 10)).all() && place.cmplt(uvec2(150, 50)).all();
        // The inset does not clear, so what it leaves open shows the picture below.
        let covered = |place: UVec2| {
            let pixel = within.at(place.x, place.y);
            inside(place) && !is(Color::srgb_u8(10, 20, 30))(pixel)
        };
        picture.assert_alike(&around, 0, 1.0, |place| !inside(place), "inset-around");
        picture.assert_alike(&within, 0, 1.0, covered, "inset-within");
    }
}

#[test]
fn two_cameras_with_two_images_show_two_reflections() {
    let right = hall("image-right");
    let mut left = from_the_left(&right);
    left.size = uvec2(90, 130);
    left = left.hdr();
    left.msaa = Msaa::Sample4;
    let mut studio = Studio::default();
    let alone = [&right, &left].map(|camera| studio.assert_reflects_in_place(camera));
    let mut stage = Stage::with_mirrors();
    let targets = [&right, &left].map(|camera| stage.target(camera.size));
    build_with_mirrors(&mut stage, &right, targets[0].clone());
    add_camera(&mut stage, &left, targets[1].clone());
    for (index, camera) in [&right, &left].into_iter().enumerate() {
        let picture = stage.picture(&targets[index], camera.size);
        picture.assert_same(&alone[index], &camera.name);
    }
}

/// The mirror of a camera that draws over another's picture shows its own scene on the clear color: what is
/// below has no reflection.
#[test]
fn a_camera_that_does_not_clear_reflects_on_the_clear_color() {
    let scene = hall("overlay");
    let over = order(scene.clone(), 1, ClearColorConfig::None);
    let backdrop = |stage: &mut Stage, target: &Handle<Image>| {
        let world = stage.world();
        let mesh = world
            .resource_mut::<Assets<Mesh>>()
            .add(Cuboid::new(40.0, 2.0, 0.1));
        let mut entity = world.spawn((Mesh3d(mesh), at(0.0, 0.0, -6.0), RenderLayers::layer(3)));
        Look::from(MAGENTA).apply(&mut entity);
        let below = (
            scene.camera_bundle(),
            scene.eye,
            RenderTarget::from(target.clone()),
            RenderLayers::layer(3),
        );
        world.spawn(below);
    };
    let draw = |mut stage: Stage, build: fn(&mut Stage, &Scene, Handle<Image>) -> Entity| {
        let target = stage.target(scene.size);
        build(&mut stage, &over, target.clone());
        backdrop(&mut stage, &target);
        stage.picture(&target, scene.size)
    };
    let picture = draw(Stage::with_mirrors(), build_with_mirrors);
    let plain = draw(Stage::stock(), build_plain);
    let mut studio = Studio::default();
    let mask = studio.mask(&scene, 0);
    picture.assert_alike(
        &plain,
        0,
        1.0,
        |place| mask.outside(place),
        "overlay-outside",
    );
    picture.assert_alike(
        &studio.reference(&scene, 0),
        TOLERANCE,
        SHARE,
        |place| mask.inside(place),
        "overlay-inside",
    );
    let below = picture
        .places()
        .filter(|place| mask.outside(*place) && is(MAGENTA)(picture.at(place.x, place.y)));
    assert!(below.count() > 100, "the picture below is covered");
}

#[test]
fn of_two_cameras_the_one_with_no_mirrors_sees_none() {
    let half = uvec2(80, 120);
    let scene = hall("opted-out");
    let right = viewport(scene.clone(), uvec2(80, 0), half);
    let left = viewport(from_the_left(&scene), UVec2::ZERO, half).with_camera(NoMirrors);
    let mut studio = Studio::default();
    let with = studio.assert_reflects_in_place(&right);
    studio.assert_no_mirror(&left);
    let without = studio.without_mirrors(&left);

    let right = order(right, 0, ClearColorConfig::Default);
    let left = order(left, 1, ClearColorConfig::None);
    let mut stage = Stage::with_mirrors();
    let picture = together(&mut stage, build_with_mirrors, &[right, left]);
    picture.assert_alike(&with, 0, 1.0, |place| place.x >= 80, "opted-in");
    picture.assert_alike(&without, 0, 1.0, |place| place.x < 80, "opted-out");
    assert_eq!(
        states(&mut stage).len(),
        1,
        "the other camera is not concerned"
    );
}

/// A look that only cameras of some layers see.
fn on_layers(color: Color, layers: &[usize]) -> Look {
    let look = Look::from(color);
    let layers = RenderLayers::from_layers(layers);
    Look::other(move |entity| {
        look.apply(entity);
        entity.insert(layers.clone());
    })
}

#[test]
fn a_mirror_shows_what_its_cameras_layers_hold() {
    let mut scene = hall("layers").with_camera(RenderLayers::from_layers(&[2, 4]));
    scene.mirrors[0] = scene.mirrors[0].clone().look(Look::other(|entity| {
        entity.insert(RenderLayers::layer(2));
    }));
    let layers: [&[usize]; 5] = [&[2], &[3], &[2, 3], &[4], &[4]];
    let colors = [RED, MAGENTA, GREEN, YELLOW, Color::srgb(0.5, 0.5, 0.45)];
    for ((object, layers), color) in scene.objects.iter_mut().zip(layers).zip(colors) {
        object.look = on_layers(color, layers);
    }
    // Behind the eye: seen in the mirror alone, or not.
    scene.objects[1].transform = at(-0.3, 0.9, 5.5);
    let picture = Studio::default().assert_reflects(&scene);
    assert_eq!(picture.count(is(MAGENTA)), 0, "layer 3 is not the camera's");
    assert!(picture.count(is(RED)) > 100);
}

#[test]
fn a_mirror_on_other_layers_than_the_camera_is_none() {
    let mut scene = hall("other-layers");
    scene.mirrors[0] = scene.mirrors[0].clone().look(Look::other(|entity| {
        entity.insert(RenderLayers::layer(2));
    }));
    let mut studio = Studio::default();
    studio.assert_no_mirror(&scene);
    assert_eq!(
        states(studio.stage()),
        [MirrorState::NotDrawn(NotDrawn::OtherLayers)]
    );
}

/// An upscaler tells the renderer to draw fewer pixels than the viewport has, and moves the picture by
/// parts of these: the reflection has to move along.
#[test]
fn the_resolution_of_an_upscaler_goes_for_the_reflection_too() {
    #[derive(Resource)]
    struct Upscaled(Option<UVec2>);

    fn upscale(
        mut commands: Commands,
        mut cameras: Query<(Entity, &ExtractedCamera, &mut TemporalJitter)>,
        upscaled: Res<Upscaled>,
    ) {
        for (entity, camera, mut jitter) in &mut cameras {
            if camera.target.is_none() {
                continue;
            }
            jitter.offset = vec2(0.25, -0.125);
            let mut camera = commands.entity(entity);
            match upscaled.0 {
                Some(size) => camera.insert(MainPassResolutionOverride(size)),
                None => camera.remove::<MainPassResolutionOverride>(),
            };
        }
    }

    let stage = Stage::new(|app| {
        app.add_plugins(PlanarMirrorPlugin::default());
        app.sub_app_mut(RenderApp)
            .insert_resource(Upscaled(None))
            .add_systems(Render, upscale.in_set(RenderSystems::PrepareViews));
    });
    let scene = super::foreign::booth("upscaled").with_camera(TemporalJitter::default());
    let mut live = Live::on(stage, &scene);
    for size in [
        None,
        Some(UVec2::new(60, 45)),
        Some(UVec2::new(80, 60)),
        None,
    ] {
        live.stage.render_world().insert_resource(Upscaled(size));
        for _ in 0..3 {
            live.stage.frame();
        }
        let world = live.stage.render_world();
        let mut views = world.query::<(
            &ExtractedCamera,
            &TemporalJitter,
            Option<&MainPassResolutionOverride>,
        )>();
        let seen: Vec<_> = views
            .iter(world)
            .map(|(_, jitter, size)| (jitter.offset, size.map(|size| size.0)))
            .collect();
        assert_eq!(seen, [(vec2(0.25, -0.125), size); 2]);
    }
}
