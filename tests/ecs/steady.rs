//! Frames in which nothing happens cost nothing that grows, and a thousand in which much does leave nothing behind.

use bevy::{ecs::world::World, prelude::*};

use super::app::{EYE, MirrorApp, mirror_app, spawn_camera, spawn_cube, stock_app};

/// What must not grow.
#[derive(Debug, PartialEq, Eq, Clone, Copy)]
struct Census {
    /// Entities alive. Resources are entities too.
    spawned: u32,
    /// Entity ids that were ever in use.
    ids: u32,
    archetypes: usize,
    tables: usize,
    components: usize,
    bundles: usize,
}

fn census(world: &World) -> Census {
    Census {
        spawned: world.entities().count_spawned(),
        ids: world.entities().len(),
        archetypes: world.archetypes().len(),
        tables: world.storages().tables.len(),
        components: world.components().len(),
        bundles: world.bundles().len(),
    }
}

#[test]
fn a_scene_without_mirrors_spawns_nothing() {
    /// What the first frames of the same scene spawn, and what later ones do.
    fn spawned(app: &mut App) -> (u32, u32) {
        spawn_camera(app, EYE);
        spawn_cube(app, 1.0, Vec3::ZERO);
        let start = census(app.world()).spawned;
        for _ in 0..3 {
            app.update();
        }
        let warm = census(app.world());
        for _ in 0..20 {
            app.update();
            let now = census(app.world());
            assert_eq!(now, warm);
        }
        (
            warm.spawned - start,
            census(app.world()).spawned - warm.spawned,
        )
    }
    let mut app = mirror_app();
    assert_eq!(spawned(&mut app), spawned(&mut stock_app()));
    assert!(app.views().is_empty());
}

/// A scene with mirrors that are drawn plain and oblique, and some that are not.
fn busy() -> (MirrorApp, Entity) {
    let mut app = mirror_app();
    for x in [-1.5, 0.0, 1.5, 40.0] {
        app.spawn_mirror(Transform::from_xyz(x, 0.0, 0.1 * x));
    }
    app.spawn_cube(0.3, Vec3::ZERO);
    let camera = app.spawn_camera(EYE);
    app.spawn_camera(Transform::from_xyz(1.0, 0.0, 6.0));
    (app, camera)
}

#[test]
fn after_the_first_frames_nothing_is_spawned() {
    let (mut app, camera) = busy();
    app.updates(3);
    let views = app.views();
    assert_eq!(views.len(), 6);
    let before = census(app.world());
    for step in 0..30 {
        // Neither when all stands still nor when the camera moves.
        if step > 10 {
            app.of_mut::<Transform>(camera).translation.x = 0.01 * step as f32;
        }
        app.update();
        assert_eq!(census(app.world()), before, "frame {step}");
    }
    assert_eq!(app.views(), views);
}

#[test]
fn a_thousand_frames_with_mirrors_that_come_and_go_leave_nothing_behind() {
    let (mut app, camera) = busy();
    let mut guest: Option<Entity> = None;
    let mesh = app.mesh(Rectangle::new(2.0, 2.0));
    let mut warm = None;
    for frame in 0..1000 {
        if frame % 100 == 99 {
            // The same phase of every hundred frames.
            let now = census(app.world());
            let warm = *warm.get_or_insert(now);
            assert_eq!(now, warm, "frame {frame}");
        }
        match frame % 5 {
            0 => {
                let at = Transform::from_xyz(0.5, 0.2, 0.0);
                let mirror = bevy_planar_mirror::PlanarMirror::default();
                guest = Some(app.spawn((Mesh3d(mesh.clone()), at, mirror)));
            }
            1 => app.of_mut::<Transform>(camera).rotate_y(3.0),
            2 => app.of_mut::<Transform>(camera).rotate_y(-3.0),
            3 => {
                if let Some(guest) = guest {
                    app.insert(guest, Visibility::Hidden);
                }
            }
            _ => {
                if let Some(guest) = guest.take() {
                    app.despawn(guest);
                }
            }
        }
        app.update();
    }
}

#[test]
fn meshes_that_come_and_go_leave_nothing_behind() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    let mut before = None;
    for frame in 0..100 {
        let mesh = app.mesh(Rectangle::new(2.0, 2.0 + 0.01 * frame as f32));
        app.insert(mirror, Mesh3d(mesh));
        app.update();
        app.view(camera, mirror);
        if frame > 2 {
            let now = census(app.world());
            assert_eq!(now, *before.get_or_insert(now), "frame {frame}");
        }
    }
}
