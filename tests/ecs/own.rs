//! What a reflected view carries: nothing that an app gives to cameras.

use bevy::{
    core_pipeline::prepass::DepthPrepass, ecs::entity_disabling::Disabled, prelude::*,
    transform::TransformSystems,
};

use super::app::{EYE, MirrorApp, mirror_app, mirror_app_with};

/// Components of the user's.
#[derive(Component, Default)]
struct Mine;
#[derive(Component, Default)]
#[require(MineToo)]
struct Theirs;
#[derive(Component, Default)]
struct MineToo;

fn components(app: &MirrorApp, view: Entity) -> Vec<String> {
    let world = app.world();
    let view = world.entity(view);
    let components = view.archetype().components();
    let names = components.iter().filter_map(|&id| {
        let info = world.components().get_info(id)?;
        Some(info.name().to_string())
    });
    let mut names: Vec<_> = names.collect();
    names.sort();
    names
}

/// The view of a mirror in such an app, and in one that does nothing, have the same.
#[track_caller]
fn assert_reaches_no_view(add: impl FnOnce(&mut App), frame: impl Fn(&mut MirrorApp, Entity)) {
    let view_of = |mut app: MirrorApp, frame: &dyn Fn(&mut MirrorApp, Entity)| {
        let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
        for _ in 0..3 {
            app.update();
            let view = app.view(camera, mirror);
            assert!(app.extracted().contains(&view));
            frame(&mut app, view);
        }
        app.update();
        let view = app.view(camera, mirror);
        components(&app, view)
    };
    let expected = view_of(mirror_app(), &|_, _| {});
    assert_eq!(view_of(mirror_app_with(add), &frame), expected);
}

#[test]
fn what_an_app_requires_of_cameras_reaches_no_view() {
    assert_reaches_no_view(
        |app| {
            app.register_required_components::<Camera3d, DepthPrepass>();
            app.register_required_components::<Camera3d, Mine>();
            app.register_required_components::<Camera, Theirs>();
        },
        |_, _| {},
    );
}

#[test]
fn what_an_observer_inserts_into_cameras_reaches_no_view() {
    assert_reaches_no_view(
        |app| {
            app.add_observer(|add: On<Add, Camera3d>, mut commands: Commands| {
                commands.entity(add.entity).insert((Mine, DepthPrepass));
            });
            // It insists.
            app.add_observer(|remove: On<Remove, Mine>, mut commands: Commands| {
                commands.entity(remove.entity).try_insert(Theirs);
            });
        },
        |_, _| {},
    );
}

#[test]
fn what_a_system_inserts_into_all_there_is_stays_on_no_view() {
    fn insert(cameras: Query<Entity, (With<Camera3d>, Allow<Disabled>)>, mut commands: Commands) {
        for camera in &cameras {
            commands.entity(camera).insert((Mine, DepthPrepass));
        }
    }
    use bevy::ecs::query::Allow;
    assert_reaches_no_view(
        |app| {
            app.add_systems(Update, insert)
                .add_systems(PostUpdate, insert.after(TransformSystems::Propagate));
        },
        |_, _| {},
    );
    assert_reaches_no_view(|_| {}, |app, view| app.insert(view, (Mine, DepthPrepass)));
}
