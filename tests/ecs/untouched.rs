//! The plugin writes into nothing of the user's but `MirrorStatus`.

use std::{
    any::TypeId,
    collections::{BTreeMap, BTreeSet},
};

use bevy::{
    camera::visibility::{CascadesVisibleEntities, VisibilityRange, VisibleEntities},
    ecs::change_detection::Tick,
    light::Cascades,
    prelude::*,
};
use bevy_planar_mirror::{MirrorShadows, MirrorStatus, PlanarMirror};

use super::app::{
    EYE, MirrorApp, add_mesh, floor, mirror_app, spawn_camera, spawn_cube, spawn_mirror, stock_app,
};

/// What a user spawns: camera, mirror, a cube before it, one that crosses it, and a sun.
fn spawn(app: &mut App) -> [Entity; 5] {
    let camera = spawn_camera(app, EYE);
    let mirror = spawn_mirror(app, default());
    let [front, across, sun] = spawn_rest(app);
    [camera, mirror, front, across, sun]
}

/// The same without the plugin's component.
fn spawn_stock(app: &mut App) -> [Entity; 5] {
    let camera = spawn_camera(app, EYE);
    let mesh = add_mesh(app, Rectangle::new(2.0, 2.0));
    let mirror = app
        .world_mut()
        .spawn((Mesh3d(mesh), Transform::default()))
        .id();
    let [front, across, sun] = spawn_rest(app);
    [camera, mirror, front, across, sun]
}

fn spawn_rest(app: &mut App) -> [Entity; 3] {
    let light = DirectionalLight {
        shadow_maps_enabled: true,
        ..default()
    };
    let place = Transform::default().looking_to(vec3(1.0, -2.0, -1.0), Vec3::Y);
    [
        spawn_cube(app, 0.3, vec3(0.4, 0.0, 1.0)),
        spawn_cube(app, 0.3, vec3(-0.4, 0.0, 0.0)),
        app.world_mut().spawn((light, place)).id(),
    ]
}

/// Both scenes after some frames.
fn both() -> ((App, [Entity; 5]), (MirrorApp, [Entity; 5])) {
    let mut stock = stock_app();
    let mut app = mirror_app();
    let (plain, mirrored) = (spawn_stock(&mut stock), spawn(&mut app));
    for _ in 0..3 {
        stock.update();
        app.update();
    }
    assert_eq!(app.views().len(), 1);
    ((stock, plain), (app, mirrored))
}

/// These entities as places in what was spawned, which is the same in both scenes.
fn places(spawned: &[Entity], found: impl IntoIterator<Item = Entity>) -> BTreeSet<Option<usize>> {
    found
        .into_iter()
        .map(|found| spawned.iter().position(|&entity| entity == found))
        .collect()
}

/// When each component of an entity was changed last.
fn ticks(world: &World, entity: Entity) -> BTreeMap<TypeId, Tick> {
    let entity = world.entity(entity);
    entity
        .archetype()
        .components()
        .iter()
        .map(|&id| {
            let info = world.components().get_info(id).expect("it is in use");
            let ticks = entity.get_change_ticks_by_id(id).expect("it is there");
            (info.type_id().expect("it is a Rust type"), ticks.changed)
        })
        .collect()
}

/// The components that a frame of this still scene changes.
fn changed(app: &mut App, entity: Entity) -> BTreeSet<TypeId> {
    let before = ticks(app.world(), entity);
    app.update();
    let after = ticks(app.world(), entity);
    assert_eq!(before.len(), after.len());
    after
        .into_iter()
        .filter(|(id, tick)| before[id] != *tick)
        .map(|(id, _)| id)
        .collect()
}

#[test]
fn a_frame_changes_no_component_that_it_would_not_change_without_the_plugin() {
    let ((mut stock, plain), (mut app, mirrored)) = both();
    for (plain, mirrored) in plain.into_iter().zip(mirrored) {
        assert_eq!(changed(&mut app, mirrored), changed(&mut stock, plain));
    }
}

#[test]
fn nothing_of_the_users_gains_or_loses_a_component() {
    let ((stock, plain), (app, mirrored)) = both();
    let of = |app: &App, entity: Entity| -> BTreeSet<TypeId> {
        ticks(app.world(), entity).into_keys().collect()
    };
    for (index, (plain, mirrored)) in plain.into_iter().zip(mirrored).enumerate() {
        let (before, after) = (of(&stock, plain), of(&app, mirrored));
        assert!(after.is_superset(&before));
        let gained: BTreeSet<_> = after.difference(&before).copied().collect();
        if index == 1 {
            assert!(gained.contains(&TypeId::of::<PlanarMirror>()));
            assert!(gained.contains(&TypeId::of::<MirrorStatus>()));
            // And what the plugin remembers of a mirror.
            assert_eq!(gained.len(), 3);
        } else {
            assert!(gained.is_empty());
        }
    }
}

#[test]
fn a_moving_mirror_changes_nothing_of_its_camera() {
    let mut app = mirror_app();
    let camera = spawn_camera(&mut app, super::app::above());
    let mirror = spawn_mirror(&mut app, floor(0.0));
    app.updates(3);
    let still = changed(&mut app, camera);
    for step in 0..5 {
        app.of_mut::<Transform>(mirror).translation.y = -0.1 * step as f32;
        assert_eq!(changed(&mut app, camera), still);
    }
    app.despawn(mirror);
    assert_eq!(changed(&mut app, camera), still);
}

#[test]
fn a_camera_sees_what_it_would_see_without_the_plugin() {
    let ((mut stock, plain), (mut app, mirrored)) = both();
    // And one that only a mirror shows: behind the camera's back.
    spawn_cube(&mut stock, 0.3, vec3(0.0, 0.0, 7.0));
    let back = app.spawn_cube(0.3, vec3(0.0, 0.0, 7.0));
    stock.update();
    app.update();
    let seen = |app: &App, spawned: &[Entity]| {
        let visible = app.world().get::<VisibleEntities>(spawned[0]);
        let meshes = visible.expect("it is a camera").get(TypeId::of::<Mesh3d>());
        places(spawned, meshes.iter().copied())
    };
    let expected = seen(&stock, &plain);
    assert_eq!(expected, [Some(1), Some(2), Some(3)].into());
    assert_eq!(seen(&app, &mirrored), expected);
    let view = app.view(mirrored[0], mirrored[1]);
    assert!(app.visible_to(view).contains(&back));
}

#[test]
fn a_light_casts_for_the_camera_what_it_would_cast_without_the_plugin() {
    let ((stock, plain), (mut app, mirrored)) = both();
    let cast = |app: &App, spawned: &[Entity]| {
        let [camera, light] = [spawned[0], spawned[4]];
        let world = app.world();
        let cascades = world.get::<Cascades>(light).expect("it is a light");
        let casters = world.get::<CascadesVisibleEntities>(light);
        let casters: Vec<_> = casters.expect("it is a light").entities[&camera]
            .iter()
            .map(|cascade| places(spawned, cascade.entities.iter().copied()))
            .collect();
        let matrices: Vec<Mat4> = cascades.cascades[&camera]
            .iter()
            .map(|cascade| cascade.clip_from_world)
            .collect();
        (matrices, casters)
    };
    let expected = cast(&stock, &plain);
    assert!(expected.1[0].contains(&Some(2)), "the cube throws a shadow");
    assert_eq!(cast(&app, &mirrored), expected);
    // Nor if it casts for the view as well.
    app.of_mut::<PlanarMirror>(mirrored[1]).shadows = MirrorShadows::Own;
    app.update();
    assert_eq!(cast(&app, &mirrored), expected);
    let view = app.view(mirrored[0], mirrored[1]);
    let casters = &app.of::<CascadesVisibleEntities>(mirrored[4]).entities[&view];
    assert!(
        casters
            .iter()
            .any(|cascade| cascade.entities.contains(&mirrored[2]))
    );
}

/// Bevy tells at most 32 views what is in their range.
#[test]
fn many_mirrors_take_no_level_of_detail_from_the_camera() {
    #[derive(Component)]
    struct Late;

    let mut app = mirror_app();
    let camera = spawn_camera(&mut app, EYE);
    let cube = spawn_cube(&mut app, 0.3, vec3(0.3, 0.0, 2.0));
    app.insert(cube, VisibilityRange::abrupt(0.0, 20.0));
    for index in 0..40 {
        spawn_mirror(
            &mut app,
            Transform::from_xyz(0.0, 0.0, -0.01 * index as f32),
        );
    }
    app.updates(2);
    assert_eq!(app.views().len(), 40);
    // From here on Bevy comes to the camera after the views.
    app.insert(camera, Late);
    app.update();
    assert!(app.visible_to(camera).contains(&cube));
}
