//! What else an app does with its cameras goes on as if there were no mirrors: interface, picking, screenshots, wires.

use std::sync::{Arc, Mutex};

use bevy::{
    camera::{ClearColorConfig, NormalizedRenderTarget, RenderTarget},
    pbr::wireframe::{WireframeConfig, WireframePlugin},
    picking::{
        backend::PointerHits,
        mesh_picking::MeshPickingPlugin,
        pointer::{Location, PointerId, PointerLocation},
    },
    prelude::*,
    render::{
        camera::SortedCameras,
        view::screenshot::{Screenshot, ScreenshotCaptured},
    },
    ui::{ComputedUiTargetCamera, IsDefaultUiCamera, UiTargetCamera},
    window::PrimaryWindow,
};
use bevy_planar_mirror::PlanarMirrorPlugin;

use super::foreign::booth;
use crate::support::{
    live::Live,
    props::{BLUE, MAGENTA, YELLOW, at, is},
    scene::{Scene, Surface},
    stage::Stage,
    studio::Studio,
};

/// Does the same to the scene with mirrors and in an app without the plugin, one after the other.
///
/// With the plugin the app gives no warning that it would not give otherwise.
#[track_caller]
fn both<T>(scene: &Scene, act: impl Fn(&mut Live) -> T) -> [T; 2] {
    let run = |mut live: Live| {
        let result = act(&mut live);
        let warnings: Vec<_> = live.stage.warnings().cloned().collect();
        (result, warnings)
    };
    let add = |app: &mut App| scene.plugins.iter().for_each(|add| add(app));
    let (plain, known) = run(Live::plain(Stage::new(add), scene));
    let with_mirrors = Stage::new(|app| {
        app.add_plugins(PlanarMirrorPlugin::default());
        add(app);
    });
    let (picture, warnings) = run(Live::on(with_mirrors, scene));
    for line in warnings {
        assert!(
            known.iter().any(|known| known.text == line.text),
            "{}: with mirrors the app warns: {}",
            scene.name,
            line.text
        );
    }
    [picture, plain]
}

/// A frame with a word in it, over the left half of the picture.
fn spawn_panel(world: &mut World, camera: Entity) -> Entity {
    let panel = (
        Node {
            width: percent(50),
            height: percent(60),
            ..default()
        },
        BackgroundColor(BLUE),
        UiTargetCamera(camera),
        children![(Text::new("abc"), TextColor(YELLOW))],
    );
    world.spawn(panel).id()
}

/// Where the panel is.
fn in_panel(scene: &Scene) -> impl Fn(UVec2) -> bool + use<> {
    let size = scene.size;
    move |place| place.x < size.x / 2 && place.y < size.y * 3 / 5
}

#[track_caller]
fn assert_panel_over_mirror(scene: &Scene, spawn: impl Fn(&mut Live)) {
    let name = &scene.name;
    let [picture, plain] = both(scene, |live| {
        spawn(live);
        live.settled()
    });
    picture.assert_alike(&plain, 0, 1.0, in_panel(scene), &format!("{name}-panel"));
    let panel = in_panel(scene);
    let text = picture
        .places()
        .filter(|place| panel(*place) && is(YELLOW)(picture.at(place.x, place.y)));
    assert!(text.count() > 10, "no text: {}", picture.save(name));
    let bare = Studio::default().picture(scene);
    let beside = |place| !panel(place);
    picture.assert_alike(&bare, 0, 1.0, beside, &format!("{name}-scene"));
}

#[test]
fn an_interface_lies_over_the_scene_and_its_mirrors() {
    assert_panel_over_mirror(&booth("ui"), |live| {
        let camera = live.camera;
        spawn_panel(live.world(), camera);
    });
}

#[test]
fn a_2d_camera_draws_its_interface_over_a_scene_with_mirrors() {
    assert_panel_over_mirror(&booth("camera-2d"), |live| {
        let target = RenderTarget::from(live.target.clone());
        let camera = Camera {
            order: 1,
            clear_color: ClearColorConfig::None,
            ..default()
        };
        let camera = live
            .world()
            .spawn((Camera2d, camera, target, Msaa::Off))
            .id();
        spawn_panel(live.world(), camera);
    });
}

#[test]
fn an_interface_goes_to_the_camera_of_the_users() {
    for marked in [true, false] {
        both(&booth("default-ui-camera"), |live| {
            let camera = live.camera;
            let world = live.world();
            // A window that nothing draws into: what counts is who is asked for.
            world.spawn((Window::default(), PrimaryWindow));
            let eye = Transform::from_xyz(0.5, 0.5, 3.0);
            let other = world.spawn((Camera3d::default(), eye)).id();
            if marked {
                world.entity_mut(camera).insert(IsDefaultUiCamera);
            }
            let node = world.spawn(Node::default()).id();
            for _ in 0..3 {
                live.stage.frame();
            }
            let target = live.world().get::<ComputedUiTargetCamera>(node);
            let target = target.and_then(ComputedUiTargetCamera::get);
            assert_eq!(target, Some(if marked { camera } else { other }));
        });
    }
}

#[test]
fn rays_of_a_pointer_hit_what_they_hit_without_mirrors() {
    let mut scene = booth("picking").plugin(|app| {
        app.add_plugins(MeshPickingPlugin);
        app.init_resource::<Hits>();
        app.add_systems(Update, collect);
    });
    // Something that one sees in the mirror alone.
    scene = scene.object(Cuboid::from_length(0.3), MAGENTA, at(0.2, 0.4, 0.9));
    let [with, without] = both(&scene, |live| {
        live.world().spawn((Window::default(), PrimaryWindow));
        let target = RenderTarget::from(live.target.clone());
        let target = target.normalize(None).expect("an image");
        let pointer = live.world().spawn(PointerId::Custom(uuid())).id();
        for _ in 0..3 {
            live.stage.frame();
        }
        let places = (4..scene.size.y).step_by(8).flat_map(|y| {
            (4..scene.size.x)
                .step_by(8)
                .map(move |x| vec2(x as f32, y as f32))
        });
        let mut found = Vec::new();
        for place in places {
            point(live.world(), pointer, target.clone(), place);
            live.stage.frame();
            let hits = std::mem::take(&mut live.world().resource_mut::<Hits>().0);
            found.push((place, hits));
        }
        found
    });
    assert_eq!(with, without);
    let hits = with.iter().filter(|(_, hits)| !hits.is_empty()).count();
    assert!(hits > 20, "{hits} rays hit something");
}

/// Where each hit is, from which camera, in which order.
#[derive(Resource, Default)]
struct Hits(Vec<(Option<Vec3>, f32, f32)>);

fn collect(mut messages: MessageReader<PointerHits>, mut hits: ResMut<Hits>) {
    for message in messages.read() {
        for (_, hit) in &message.picks {
            hits.0.push((hit.position, hit.depth, message.order));
        }
    }
}

fn uuid() -> bevy::asset::uuid::Uuid {
    bevy::asset::uuid::Uuid::from_u128(1)
}

fn point(world: &mut World, pointer: Entity, target: NormalizedRenderTarget, position: Vec2) {
    let location = PointerLocation::new(Location { target, position });
    world.entity_mut(pointer).insert(location);
}

#[test]
fn a_screenshot_shows_the_mirrors() {
    let scene = booth("screenshot");
    let mut live = Live::in_reach(&scene);
    let picture = live.settled();
    let shot = Arc::new(Mutex::new(None));
    let taken = shot.clone();
    let screenshot = Screenshot::image(live.target.clone());
    live.world()
        .spawn(screenshot)
        .observe(move |captured: On<ScreenshotCaptured>| {
            *taken.lock().expect("nothing panics while it is held") = Some(captured.image.clone());
        });
    for _ in 0..20 {
        live.stage.frame();
    }
    let image = shot.lock().expect("nothing panics while it is held").take();
    let data = image
        .expect("a screenshot was taken")
        .data
        .expect("in the main world");
    let pixels = data.as_chunks().0.to_vec();
    let shot = crate::support::picture::Picture::new(scene.size, pixels);
    shot.expect("of the target's size")
        .assert_same(&picture, "screenshot");
}

/// Wires are a pass of the camera's own; in the mirror there are none yet.
#[test]
fn wires_are_drawn_over_the_scene_as_without_mirrors() {
    let scene = booth("wires").plugin(|app| {
        app.add_plugins(WireframePlugin::default());
        app.insert_resource(WireframeConfig {
            global: true,
            default_color: MAGENTA,
            ..default()
        });
    });
    let mask = Studio::default().mask(&booth("wires"), 0);
    let [picture, plain] = both(&scene, Live::settled);
    let outside = |place| mask.outside(place);
    picture.assert_alike(&plain, 0, 1.0, outside, "wires-outside");
    assert!(plain.count(is(MAGENTA)) > 50, "{}", plain.save("wires"));
    // Those of the mirror's own mesh stay on top of it.
    let on_mirror = |place: UVec2| mask.inside(place) && is(MAGENTA)(plain.at(place.x, place.y));
    assert!(plain.places().any(on_mirror));
    picture.assert_alike(&plain, 0, 1.0, on_mirror, "wires-on-mirror");
}

/// The engine warns of cameras that it cannot put in order, once in the life of a process; so this looks itself.
#[test]
fn every_camera_has_a_place_of_its_own_in_the_order() {
    let mut scene = booth("many");
    let floor = Surface::floor(3.0, 2.0, at(0.0, -0.8, 1.0));
    scene.mirrors.push(floor);
    let [with, without] = both(&scene, |live| {
        for order in 1..4 {
            let target = RenderTarget::from(live.stage.target(scene.size));
            let mut eye = scene.eye;
            eye.translation.x -= 0.1 * order as f32;
            live.world().spawn((scene.camera_bundle(), target, eye));
        }
        live.settled();
        let cameras = &live.stage.render_world().resource::<SortedCameras>().0;
        let places = cameras
            .iter()
            .map(|camera| (camera.order, camera.target.clone()));
        places.collect::<Vec<_>>()
    });
    assert_eq!(without.len(), 4);
    assert_eq!(with.len(), 4 + 4 * 2, "each camera sees each mirror");
    for (index, place) in with.iter().enumerate() {
        assert!(!with[..index].contains(place), "{place:?} is taken twice");
    }
}
