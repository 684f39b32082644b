//! The plugin's systems and no others, which run on one thread: the engine's own systems take time and allocate too,
//! and not the same in every frame.

use bevy::{
    asset::AssetEvent,
    camera::{CameraProjection, RenderTargetInfo, visibility::InheritedVisibility},
    ecs::schedule::{Schedules, SingleThreadedExecutor},
    prelude::*,
    render::RenderApp,
};
use bevy_planar_mirror::PlanarMirror;

/// An app that has nothing but what is added here, and a renderer that draws nothing.
pub fn app(add: impl FnOnce(&mut App)) -> App {
    let mut app = App::new();
    app.insert_resource(Assets::<Mesh>::default())
        .add_message::<AssetEvent<Mesh>>();
    let mut renderer = SubApp::new();
    renderer.set_extract(|_, _| {});
    app.insert_sub_app(RenderApp, renderer);
    add(&mut app);
    let mut schedules = app.world_mut().resource_mut::<Schedules>();
    for (_, schedule) in schedules.iter_mut() {
        schedule.set_executor(SingleThreadedExecutor::new());
    }
    app.finish();
    app.cleanup();
    app
}

pub fn mesh(app: &mut App) -> Handle<Mesh> {
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    meshes.add(Rectangle::new(1.0, 1.0))
}

/// With all that the engine would compute of it.
pub fn spawn_mirror(app: &mut App, mesh: Handle<Mesh>, place: Transform) -> Entity {
    let mirror = (
        Mesh3d(mesh),
        place,
        GlobalTransform::from(place),
        InheritedVisibility::VISIBLE,
        PlanarMirror::default(),
    );
    app.world_mut().spawn(mirror).id()
}

/// With all that the engine would compute of it.
pub fn spawn_camera(app: &mut App) {
    const SIZE: UVec2 = uvec2(200, 100);
    let mut projection = PerspectiveProjection::default();
    projection.update(SIZE.x as f32, SIZE.y as f32);
    let mut camera = Camera::default();
    camera.computed.clip_from_view = projection.get_clip_from_view();
    camera.computed.target_info = Some(RenderTargetInfo {
        physical_size: SIZE,
        scale_factor: 1.0,
    });
    let place = GlobalTransform::from_xyz(0.0, 0.0, 5.0);
    let projection = Projection::from(projection);
    let camera = (Camera3d::default(), camera, projection, place);
    app.world_mut().spawn(camera);
}
