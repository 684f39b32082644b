//! A user never meets a reflected view, but in extraction.

use bevy::{
    camera::{NormalizedRenderTarget, visibility::VisibilitySystems},
    light::SimulationLightSystems,
    picking::{
        PickingPlugin,
        backend::ray::RayMap,
        pointer::{Location, PointerId, PointerLocation},
    },
    prelude::*,
    ui::DefaultUiCamera,
    window::{PrimaryWindow, WindowRef},
};
use bevy_planar_mirror::MirrorSystems;

use super::app::{EYE, MirrorApp, mirror_app, mirror_app_with, target};

/// Which cameras the systems of a user met, by where the system stands.
#[derive(Resource, Default)]
struct Met(Vec<(&'static str, Vec<Entity>)>);

/// All the ways of asking for cameras. The last one skips the system if it is not the only one.
fn look(
    place: &'static str,
) -> impl FnMut(
    Query<Entity, With<Camera>>,
    Query<Entity, With<Camera3d>>,
    Query<(Entity, &Camera, &GlobalTransform), With<Projection>>,
    Single<(Entity, &Camera, &GlobalTransform)>,
    Single<Entity, With<Camera3d>>,
    ResMut<Met>,
) {
    move |cameras, cameras_3d, placed, single, single_3d, mut met| {
        let mut all: Vec<Entity> = cameras.iter().chain(&cameras_3d).collect();
        all.extend(placed.iter().map(|(entity, ..)| entity));
        all.extend([single.0, *single_3d]);
        met.0.push((place, all));
    }
}

const PLACES: usize = 19;

fn look_everywhere(app: &mut App) {
    app.init_resource::<Met>()
        .add_systems(First, look("First"))
        .add_systems(PreUpdate, look("PreUpdate"))
        .add_systems(Update, look("Update"))
        .add_systems(RunFixedMainLoop, look("RunFixedMainLoop"))
        .add_systems(
            PostUpdate,
            (
                look("before transforms").before(TransformSystems::Propagate),
                look("after transforms")
                    .after(TransformSystems::Propagate)
                    .before(MirrorSystems::UpdateViews),
                look("between")
                    .after(MirrorSystems::UpdateViews)
                    .before(MirrorSystems::SeeViews),
                look("while shadows are chosen")
                    .after(MirrorSystems::SeeViews)
                    .before(MirrorSystems::NarrowShadows),
                look("after all").after(MirrorSystems::NarrowShadows),
                look("after visibility").after(VisibilitySystems::CheckVisibility),
                look("after lights").after(SimulationLightSystems::CheckLightVisibility),
                // As users write them: in no order that is told, between any two others.
                (
                    look("somewhere 1"),
                    look("somewhere 2"),
                    look("somewhere 3"),
                    look("somewhere 4").after(TransformSystems::Propagate),
                    look("somewhere 5").after(TransformSystems::Propagate),
                    look("somewhere 6").after(TransformSystems::Propagate),
                ),
            ),
        )
        .add_systems(Last, (look("Last"), look("Last again")));
}

#[test]
fn a_users_systems_meet_the_users_camera_alone() {
    let mut app = mirror_app_with(look_everywhere);
    let camera = app.spawn_camera(EYE);
    let sun = DirectionalLight {
        shadow_maps_enabled: true,
        ..default()
    };
    app.spawn((sun, Transform::default().looking_to(Vec3::NEG_Y, Vec3::X)));
    for x in [-1.0, 0.0, 1.0] {
        app.spawn_mirror(Transform::from_xyz(x, 0.0, 0.1 * x));
    }
    for frame in 0..40 {
        app.insert_resource(Met::default());
        app.update();
        assert_eq!(app.views().len(), 3);
        let met = &app.world().resource::<Met>().0;
        assert_eq!(
            met.len(),
            PLACES,
            "no system was skipped in frame {frame}: {met:?}"
        );
        for (place, cameras) in met {
            assert!(
                cameras.iter().all(|&met| met == camera),
                "{place} meets {cameras:?}"
            );
            assert_eq!(cameras.len(), 5);
        }
    }
    let world = app.world_mut();
    assert_eq!(
        world.query::<&Camera>().iter(world).count(),
        1,
        "nor between frames"
    );
}

#[test]
fn extraction_meets_every_view() {
    let mut app = mirror_app();
    let camera = app.spawn_camera(EYE);
    app.spawn_mirror(default());
    for _ in 0..3 {
        app.update();
        let mut expected = app.views();
        expected.push(camera);
        expected.sort();
        let mut extracted = app.extracted().to_vec();
        extracted.sort();
        assert_eq!(extracted, expected);
    }
}

#[derive(Resource, Default)]
struct Filtered {
    added: Vec<Entity>,
    changed: Vec<Entity>,
    removed: Vec<Entity>,
}

fn filter(
    added: Query<Entity, Or<(Added<Camera>, Added<Camera3d>, Added<GlobalTransform>)>>,
    changed: Query<
        Entity,
        Or<(
            Changed<Camera>,
            Changed<Projection>,
            Changed<GlobalTransform>,
        )>,
    >,
    mut removed: RemovedComponents<Camera>,
    mut removed_transforms: RemovedComponents<Transform>,
    mut filtered: ResMut<Filtered>,
) {
    filtered.added.extend(&added);
    filtered.changed.extend(&changed);
    filtered.removed.extend(removed.read());
    filtered.removed.extend(removed_transforms.read());
}

#[test]
fn change_detection_of_a_user_sees_no_view() {
    let mut app = mirror_app_with(|app| {
        app.init_resource::<Filtered>().add_systems(Update, filter);
    });
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    let users = [mirror, camera];
    for frame in 0..6 {
        app.of_mut::<Transform>(camera).translation.x += 0.1;
        app.update();
        let filtered = std::mem::take(&mut *app.world_mut().resource_mut::<Filtered>());
        for entity in filtered.added.iter().chain(&filtered.changed) {
            assert!(users.contains(entity), "{entity} in frame {frame}");
        }
        // Bevy tells of what a view lost when it was made. After that nothing goes as long as it lives.
        assert!(
            frame < 2 || filtered.removed.is_empty(),
            "{:?}",
            filtered.removed
        );
    }
}

/// What observers heard, by kind of event.
#[derive(Resource, Default)]
struct Heard {
    added: Vec<Entity>,
    inserted: Vec<Entity>,
    discarded: Vec<Entity>,
    removed: Vec<Entity>,
}

fn listen(app: &mut App) {
    app.init_resource::<Heard>()
        .add_observer(|add: On<Add, Camera>, mut heard: ResMut<Heard>| {
            heard.added.push(add.entity);
        })
        .add_observer(
            |insert: On<Insert, (Camera, Camera3d)>, mut heard: ResMut<Heard>| {
                heard.inserted.push(insert.entity);
            },
        )
        .add_observer(
            |discard: On<Discard, (Camera, Camera3d)>, mut heard: ResMut<Heard>| {
                heard.discarded.push(discard.entity);
            },
        )
        .add_observer(|remove: On<Remove, Camera>, mut heard: ResMut<Heard>| {
            heard.removed.push(remove.entity);
        });
}

fn heard(app: &mut MirrorApp) -> Heard {
    std::mem::take(&mut *app.world_mut().resource_mut::<Heard>())
}

/// Bevy has no way to spawn or despawn an entity that observers do not hear of. Once each, then.
#[test]
fn observers_hear_of_a_view_when_it_comes_and_when_it_goes() {
    let mut app = mirror_app_with(listen);
    let camera = app.spawn_camera(EYE);
    app.update();
    heard(&mut app);
    let mirror = app.spawn_mirror(default());
    app.update();
    let view = app.view(camera, mirror);
    assert_eq!(heard(&mut app).added, [view]);
    for _ in 0..4 {
        app.of_mut::<Transform>(camera).translation.x += 0.1;
        app.update();
        let heard = heard(&mut app);
        let all = [
            &heard.added,
            &heard.inserted,
            &heard.discarded,
            &heard.removed,
        ];
        assert!(
            all.iter().all(|heard| heard.is_empty()),
            "{all:?} while {view} lives"
        );
    }
    app.despawn(mirror);
    app.update();
    assert_eq!(heard(&mut app).removed, [view]);
}

/// An observer that looks its camera up by a query, as most do, finds none.
#[test]
fn an_observer_that_looks_up_the_camera_meets_the_users_alone() {
    let mut app = mirror_app_with(|app| {
        app.init_resource::<Heard>()
            .add_observer(
                |add: On<Add, Camera>, cameras: Query<&Camera>, mut heard: ResMut<Heard>| {
                    heard
                        .added
                        .extend(cameras.contains(add.entity).then_some(add.entity));
                },
            )
            .add_observer(
                |insert: On<Insert, Camera3d>,
                 cameras: Query<&Camera3d>,
                 mut heard: ResMut<Heard>| {
                    heard
                        .inserted
                        .extend(cameras.contains(insert.entity).then_some(insert.entity));
                },
            )
            .add_observer(
                |remove: On<Remove, Camera>, cameras: Query<&Camera>, mut heard: ResMut<Heard>| {
                    heard
                        .removed
                        .extend(cameras.contains(remove.entity).then_some(remove.entity));
                },
            );
    });
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.updates(3);
    assert_eq!(app.views().len(), 1);
    app.despawn(mirror);
    app.updates(2);
    let found = heard(&mut app);
    assert_eq!(found.added, [camera]);
    assert_eq!(found.inserted, [camera]);
    assert!(found.removed.is_empty(), "{:?}", found.removed);
}

/// Pointers, rays and the default camera of a user interface, in an app with a window.
#[test]
fn picking_and_ui_know_the_users_camera_alone() {
    let mut app = mirror_app_with(|app| {
        app.add_plugins(PickingPlugin);
    });
    let window = app.spawn((Window::default(), PrimaryWindow));
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.insert(
        camera,
        bevy::camera::RenderTarget::Window(WindowRef::Primary),
    );
    app.spawn((
        PointerId::Mouse,
        PointerLocation::new(Location {
            target: NormalizedRenderTarget::Window(
                WindowRef::Primary
                    .normalize(Some(window))
                    .expect("it is named"),
            ),
            position: vec2(20.0, 20.0),
        }),
    ));
    app.updates(3);
    app.view(camera, mirror);
    let rays: Vec<Entity> = app
        .world()
        .resource::<RayMap>()
        .iter()
        .map(|(id, _)| id.camera)
        .collect();
    assert_eq!(rays, [camera]);
    let default_ui_camera = |app: &mut MirrorApp| {
        app.world_mut()
            .run_system_cached(|camera: DefaultUiCamera| camera.get())
            .expect("it runs")
    };
    assert_eq!(default_ui_camera(&mut app), Some(camera));
    // A camera that draws elsewhere leaves the interface without one.
    let image = target(&mut app, super::app::SIZE);
    app.insert(camera, image);
    app.updates(2);
    app.view(camera, mirror);
    assert_eq!(default_ui_camera(&mut app), None);
}

#[test]
fn a_user_may_ask_for_disabled_entities_and_find_the_views_by_name() {
    use bevy::ecs::entity_disabling::Disabled;
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.update();
    let world = app.world_mut();
    let names: Vec<String> = world
        .query_filtered::<&Name, (With<Camera>, With<Disabled>)>()
        .iter(world)
        .map(Name::to_string)
        .collect();
    assert_eq!(names, [format!("reflected view of {camera} in {mirror}")]);
}
