//! What the plugin allocates in the main world in a frame in which nothing happens.

#[path = "support/alone.rs"]
mod alone;

use allocation_counter::{AllocationInfo, measure};
use bevy::prelude::*;
use bevy_planar_mirror::{MirrorState, MirrorStatus, NotDrawn, PlanarMirrorPlugin};

use alone::{mesh, spawn_camera, spawn_mirror};

fn app() -> App {
    alone::app(|app| {
        app.add_plugins(PlanarMirrorPlugin::default())
            .init_resource::<Moves>()
            .add_systems(Update, move_camera);
    })
}

/// Mirrors that are drawn and a camera that sees them, some frames after they came.
fn app_with_mirrors(count: usize) -> App {
    let mut app = app();
    let mesh = mesh(&mut app);
    for index in 0..count {
        let place = Transform::from_xyz(index as f32 * 0.1, 0.0, 0.0);
        spawn_mirror(&mut app, mesh.clone(), place);
    }
    spawn_camera(&mut app);
    for _ in 0..5 {
        app.update();
    }
    let world = app.world_mut();
    let mut statuses = world.query::<&MirrorStatus>();
    assert!(statuses.iter(world).all(MirrorStatus::is_drawn));
    app
}

/// Whether the camera moves.
#[derive(Resource, Default)]
struct Moves(bool);

fn move_camera(
    moves: Res<Moves>,
    mut places: Query<&mut GlobalTransform, With<Camera3d>>,
    mut step: Local<f32>,
) {
    if moves.0 {
        *step += 0.001;
        for mut place in &mut places {
            *place = GlobalTransform::from_xyz(*step, 0.0, 5.0);
        }
    }
}

fn allocations_in(app: &mut App, frames: u64) -> AllocationInfo {
    measure(|| (0..frames).for_each(|_| app.update()))
}

#[test]
fn without_mirrors_nothing_is_allocated() {
    let info = allocations_in(&mut app_with_mirrors(0), 100);
    assert_eq!(info.count_total, 0, "{info:?}");
}

/// Whether the camera moves or not.
#[test]
fn mirrors_that_are_drawn_allocate_nothing_from_frame_to_frame() {
    for count in [1, 2, 20] {
        for moves in [false, true] {
            let mut app = app_with_mirrors(count);
            app.world_mut().resource_mut::<Moves>().0 = moves;
            let info = allocations_in(&mut app, 100);
            assert_eq!(info.count_total, 0, "{count} mirrors: {info:?}");
        }
    }
}

/// Each is warned of once, and none is remembered when it is gone.
#[test]
fn bad_mirrors_that_come_and_go_hold_no_memory() {
    let mut app = app_with_mirrors(1);
    let mesh = mesh(&mut app);
    let mut come_and_go = |frames: usize| {
        measure(|| {
            for _ in 0..frames {
                let flat = Transform::from_scale(Vec3::ZERO);
                let bad = spawn_mirror(&mut app, mesh.clone(), flat);
                app.update();
                let status = app.world().get::<MirrorStatus>(bad).expect("it is there");
                let state = status.cameras[0].state;
                let reason = NotDrawn::DegenerateTransform;
                assert_eq!(state, MirrorState::NotDrawn(reason));
                app.world_mut().despawn(bad);
            }
        })
    };
    come_and_go(1000);
    assert_eq!(come_and_go(3000).bytes_current, 0);
}
