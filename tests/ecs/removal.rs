//! Mirrors, cameras and whole worlds that go away.

use bevy::{
    camera::RenderTarget,
    ecs::{entity_disabling::Disabled, query::Allow},
    prelude::*,
    render::view::NoIndirectDrawing,
};
use bevy_planar_mirror::{MirrorStatus, MirrorSystems, NotDrawn, PlanarMirror};

use super::app::{EYE, MirrorApp, PLAIN, mirror_app, mirror_app_with, not};

/// Two mirrors and two cameras, all of which see each other.
fn four() -> (MirrorApp, [Entity; 2], [Entity; 2]) {
    let mut app = mirror_app();
    let mirrors = [-0.5, 0.5].map(|x| app.spawn_mirror(Transform::from_xyz(x, 0.0, 0.1 * x)));
    let cameras = [EYE, EYE].map(|eye| app.spawn_camera(eye));
    app.updates(2);
    assert_eq!(app.views().len(), 4);
    (app, mirrors, cameras)
}

#[test]
fn a_despawned_mirror_takes_its_views_along() {
    let (mut app, mirrors, cameras) = four();
    app.despawn(mirrors[0]);
    app.update();
    assert_eq!(app.views().len(), 2);
    for camera in cameras {
        app.view(camera, mirrors[1]);
    }
}

#[test]
fn a_despawned_camera_takes_its_views_along() {
    let (mut app, mirrors, cameras) = four();
    app.despawn(cameras[0]);
    app.update();
    assert_eq!(app.views().len(), 2);
    for mirror in mirrors {
        app.view(cameras[1], mirror);
        app.assert_state(mirror, cameras[0], None);
        app.assert_state(mirror, cameras[1], PLAIN);
    }
}

#[test]
fn a_mirror_and_a_camera_may_go_in_one_frame() {
    let (mut app, mirrors, cameras) = four();
    app.despawn(mirrors[0]);
    app.despawn(cameras[1]);
    app.update();
    assert_eq!(app.views(), [app.view(cameras[0], mirrors[1])]);
    app.despawn(mirrors[1]);
    app.despawn(cameras[0]);
    app.update();
    assert!(app.views().is_empty());
}

#[test]
fn a_parent_that_is_despawned_takes_mirror_camera_and_views_along() {
    let (mut app, mirrors, cameras) = four();
    let parent = app.spawn((Transform::default(), Visibility::default()));
    app.insert(mirrors[0], ChildOf(parent));
    app.insert(cameras[0], ChildOf(parent));
    app.update();
    assert_eq!(app.views().len(), 4);
    app.despawn(parent);
    app.update();
    assert_eq!(app.views(), [app.view(cameras[1], mirrors[1])]);
}

#[test]
fn what_is_replaced_in_one_frame_gets_views_in_the_same_frame() {
    let (mut app, mirrors, cameras) = four();
    app.despawn(mirrors[0]);
    app.despawn(cameras[0]);
    let mirror = app.spawn_mirror(default());
    let camera = app.spawn_camera(EYE);
    app.update();
    assert_eq!(app.views().len(), 4);
    app.view(camera, mirror);
    app.view(camera, mirrors[1]);
    app.view(cameras[1], mirror);
}

#[test]
fn what_is_no_mirror_any_more_has_no_views_and_is_not_said_to_be_drawn() {
    let (mut app, mirrors, cameras) = four();
    app.remove::<PlanarMirror>(mirrors[0]);
    app.update();
    assert_eq!(app.views().len(), 2);
    let status = app.world().get::<MirrorStatus>(mirrors[0]);
    assert!(!status.is_some_and(MirrorStatus::is_drawn), "{status:?}");
    app.insert(mirrors[0], PlanarMirror::default());
    app.update();
    assert_eq!(app.views().len(), 4);
    app.assert_state(mirrors[0], cameras[0], PLAIN);
}

#[test]
fn a_mirror_without_a_mesh_says_so() {
    let (mut app, mirrors, cameras) = four();
    let mesh = app.of::<Mesh3d>(mirrors[0]).clone();
    app.remove::<Mesh3d>(mirrors[0]);
    app.update();
    assert_eq!(app.views().len(), 2);
    app.assert_state(mirrors[0], cameras[0], not(NotDrawn::NoMesh));
    app.insert(mirrors[0], mesh);
    app.update();
    assert_eq!(app.views().len(), 4);
    app.assert_state(mirrors[0], cameras[0], PLAIN);
}

#[test]
fn a_camera_that_is_no_3d_camera_any_more_has_no_views() {
    let (mut app, mirrors, cameras) = four();
    app.remove::<Camera3d>(cameras[0]);
    app.update();
    assert_eq!(app.views().len(), 2);
    app.assert_state(mirrors[0], cameras[0], None);
    app.insert(cameras[0], Camera3d::default());
    app.update();
    assert_eq!(app.views().len(), 4);
    app.remove::<Camera>(cameras[0]);
    app.update();
    assert_eq!(app.views().len(), 2);
    app.assert_state(mirrors[0], cameras[0], None);
}

/// Everything that has a place, as a game does that loads its next level; the plugin's views too.
fn clear(world: &mut World) {
    let placed: Vec<Entity> = world
        .query_filtered::<Entity, (With<GlobalTransform>, Allow<Disabled>)>()
        .iter(world)
        .collect();
    for entity in placed {
        world.try_despawn(entity).ok();
    }
}

#[test]
fn a_world_that_is_cleared_can_be_filled_again() {
    let (mut app, ..) = four();
    let spawned = app.world().entities().count_spawned();
    clear(app.world_mut());
    app.updates(2);
    assert!(app.views().is_empty());
    let mirrors = [-0.5, 0.5].map(|x| app.spawn_mirror(Transform::from_xyz(x, 0.0, 0.1 * x)));
    let cameras = [EYE, EYE].map(|eye| app.spawn_camera(eye));
    app.update();
    assert_eq!(app.views().len(), 4);
    app.assert_state(mirrors[0], cameras[1], PLAIN);
    assert_eq!(app.world().entities().count_spawned(), spawned);
}

#[test]
fn a_world_that_is_cleared_and_filled_in_one_frame_has_new_views() {
    let (mut app, ..) = four();
    clear(app.world_mut());
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.update();
    assert_eq!(app.views(), [app.view(camera, mirror)]);
}

#[test]
fn a_view_that_somebody_despawned_comes_back() {
    let (mut app, mirrors, cameras) = four();
    for view in app.views() {
        app.despawn(view);
    }
    app.update();
    assert_eq!(app.views().len(), 4);
    app.view(cameras[0], mirrors[1]);
}

#[derive(Resource, Default)]
struct ClearNow(bool);

/// Clears the world once, in whatever schedule and place it stands in.
fn clear_when_told(world: &mut World) {
    if std::mem::take(&mut world.resource_mut::<ClearNow>().0) {
        clear(world);
    }
}

#[track_caller]
fn survives_clearing(add: impl FnOnce(&mut App)) {
    let mut app = mirror_app_with(|app| {
        app.init_resource::<ClearNow>();
        add(app);
    });
    app.spawn_mirror(default());
    app.spawn_camera(EYE);
    app.updates(2);
    assert_eq!(app.views().len(), 1);
    app.insert_resource(ClearNow(true));
    app.updates(2);
    assert!(app.views().is_empty());
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.update();
    assert_eq!(app.views(), [app.view(camera, mirror)]);
}

#[test]
fn a_world_may_be_cleared_at_any_time_of_the_frame() {
    survives_clearing(|app| {
        app.add_systems(First, clear_when_told);
    });
    survives_clearing(|app| {
        app.add_systems(Update, clear_when_told);
    });
    survives_clearing(|app| {
        app.add_systems(Last, clear_when_told);
    });
}

#[test]
fn a_world_may_be_cleared_before_the_views_are_updated() {
    survives_clearing(|app| {
        app.add_systems(
            PostUpdate,
            clear_when_told
                .after(TransformSystems::Propagate)
                .before(MirrorSystems::UpdateViews),
        );
    });
}

#[test]
fn a_world_may_be_cleared_between_any_two_steps() {
    survives_clearing(|app| {
        app.add_systems(
            PostUpdate,
            clear_when_told
                .after(MirrorSystems::UpdateViews)
                .before(MirrorSystems::SeeViews),
        );
    });
    survives_clearing(|app| {
        app.add_systems(
            PostUpdate,
            clear_when_told
                .after(MirrorSystems::SeeViews)
                .before(MirrorSystems::NarrowShadows),
        );
    });
}

#[test]
fn a_camera_whose_target_is_gone_sees_no_mirror() {
    let (mut app, mirrors, cameras) = four();
    // What a game does that closes a window: the camera stays.
    app.insert(cameras[0], RenderTarget::None { size: UVec2::ZERO });
    app.of_mut::<Projection>(cameras[0]).set_changed();
    app.update();
    app.assert_state(mirrors[0], cameras[0], not(NotDrawn::NoTarget));
    app.assert_state(mirrors[0], cameras[1], PLAIN);
    assert_eq!(app.views().len(), 2);
}

/// A game may allow one camera only, the newest, or none that it does not know. It will not be happy with mirrors,
/// but it must not crash.
#[test]
fn an_observer_may_despawn_cameras_while_views_are_made() {
    let newest_only =
        |add: On<Add, Camera>, cameras: Query<Entity, With<Camera>>, mut commands: Commands| {
            for camera in &cameras {
                if camera != add.entity {
                    commands.entity(camera).despawn();
                }
            }
        };
    let mut app = mirror_app_with(|app| {
        app.add_observer(newest_only);
    });
    app.spawn_mirror(default());
    let camera = app.spawn_camera(EYE);
    app.updates(3);
    assert!(app.world().get_entity(camera).is_err());
    assert!(app.views().is_empty());

    #[derive(Component)]
    struct Known;
    let known_only =
        |add: On<Add, Camera>, known: Query<(), With<Known>>, mut commands: Commands| {
            if !known.contains(add.entity) {
                commands.entity(add.entity).despawn();
            }
        };
    let mut app = mirror_app_with(|app| {
        app.add_observer(known_only);
    });
    let mirror = app.spawn_mirror(default());
    let target = super::app::target(&mut app, super::app::SIZE);
    // A view takes this over as it is spawned.
    let direct = NoIndirectDrawing;
    app.spawn((Camera3d::default(), target, EYE, Known, direct));
    app.updates(3);
    assert!(app.views().is_empty());
    assert!(app.world().get_entity(mirror).is_ok());
}
