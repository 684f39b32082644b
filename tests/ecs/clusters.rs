//! The light clusters of reflected views.

use bevy::{
    light::{
        ClusteredDecal, LightProbe,
        cluster::{ClusterConfig, GlobalClusterGpuSettings, GlobalClusterSettings},
    },
    prelude::*,
};
use bevy_planar_mirror::status::MirrorFigures;

use super::app::{EYE, MirrorApp, mirror_app, target};

fn clusters(x: u32, y: u32, z: u32) -> ClusterConfig {
    ClusterConfig::XYZ {
        dimensions: uvec3(x, y, z),
        z_config: default(),
        dynamic_resizing: false,
    }
}

fn dimensions(config: &ClusterConfig) -> UVec3 {
    match config {
        ClusterConfig::Single => UVec3::ONE,
        ClusterConfig::XYZ { dimensions, .. } => *dimensions,
        other => panic!("{other:?}"),
    }
}

/// A cluster costs the same whether it is seen or not.
#[test]
fn a_view_has_no_more_light_clusters_than_its_mirror_is_worth() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    let mut last = UVec3::ZERO;
    for scale in [0.02, 0.2, 1.0, 3.0] {
        app.of_mut::<Transform>(mirror).scale = Vec3::splat(scale);
        app.update();
        let pixels = app.world().resource::<MirrorFigures>().views[0].pixels as u32;
        let view = app.view(camera, mirror);
        let own = dimensions(app.of::<ClusterConfig>(view));
        assert_eq!(own.z, 24, "the engine's default");
        assert!(own.cmpge(last).all(), "{own} after {last}");
        let worth = pixels / 16;
        assert!(own.element_product() <= own.z.max(worth), "{own}");
        assert!(own.element_product() * 3 > worth, "{own}");
        last = own;
    }
    assert!(last.x > last.y, "as the picture is wider than high");
}

/// One of an even number would begin at the middle of the picture, where the horizon of a floor is.
#[test]
fn a_view_has_an_odd_number_of_light_clusters_across_and_down() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    for (config, expected) in [
        (ClusterConfig::Single, uvec3(1, 1, 1)),
        (clusters(9, 7, 4), uvec3(9, 7, 4)),
        (clusters(8, 6, 5), uvec3(7, 5, 5)),
        (clusters(2, 1, 1), uvec3(1, 1, 1)),
        (clusters(0, 0, 1), uvec3(1, 1, 1)),
    ] {
        app.insert(camera, config);
        app.update();
        let view = app.view(camera, mirror);
        assert_eq!(dimensions(app.of::<ClusterConfig>(view)), expected);
    }
}

/// As the renderer has it where lamps are sorted on the GPU.
fn sorted_on_gpu(is_so: bool) -> GlobalClusterSettings {
    GlobalClusterSettings {
        supports_storage_buffers: true,
        clustered_decals_are_usable: true,
        gpu_clustering: is_so.then_some(GlobalClusterGpuSettings {
            initial_z_slice_list_capacity: 1024,
            initial_index_list_capacity: 1024,
        }),
        max_uniform_buffer_clusterable_objects: 204,
        view_cluster_bindings_max_indices: 16384,
    }
}

/// Whether the only view has one cluster for all lamps.
fn has_one_cluster(app: &mut MirrorApp, view: Entity) -> bool {
    app.update();
    matches!(app.of::<ClusterConfig>(view), ClusterConfig::Single)
}

fn lamp(x: f32, range: f32) -> (PointLight, Transform) {
    let light = PointLight { range, ..default() };
    (light, Transform::from_xyz(x, 0.0, 1.0))
}

#[test]
fn few_lamps_share_one_cluster() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.update();
    let view = app.view(camera, mirror);
    app.insert_resource(sorted_on_gpu(true));
    assert!(has_one_cluster(&mut app, view), "there is none");
    for _ in 0..8 {
        app.spawn(lamp(0.0, 2.0));
        app.spawn(lamp(90.0, 2.0));
    }
    assert!(has_one_cluster(&mut app, view), "half of them are far away");
    let spots: Vec<_> = (0..30)
        .map(|_| {
            let (lamp, place) = lamp(0.0, 2.0);
            let spot = SpotLight {
                range: lamp.range,
                ..default()
            };
            app.spawn((spot, place))
        })
        .collect();
    assert!(!has_one_cluster(&mut app, view), "these are too many");
    for spot in &spots {
        app.insert(*spot, Visibility::Hidden);
    }
    assert!(has_one_cluster(&mut app, view), "which are not lit");
}

/// Of a mirror that fills a screen each lamp is looked at so often that it had better be sorted.
#[test]
fn the_larger_the_mirror_the_fewer_lamps_share_one_cluster() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    let large = target(&mut app, uvec2(2000, 1000));
    app.insert(camera, large);
    app.insert_resource(sorted_on_gpu(true));
    app.update();
    let view = app.view(camera, mirror);
    for _ in 0..15 {
        app.spawn(lamp(0.0, 2.0));
    }
    let pixels = |app: &MirrorApp| app.world().resource::<MirrorFigures>().views[0].pixels;
    assert!(has_one_cluster(&mut app, view), "{}", pixels(&app));
    app.of_mut::<Transform>(mirror).scale = Vec3::splat(9.0);
    assert!(!has_one_cluster(&mut app, view), "{}", pixels(&app));
}

#[test]
fn what_only_the_engine_can_sort_keeps_its_clusters() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.update();
    let view = app.view(camera, mirror);
    app.insert_resource(sorted_on_gpu(false));
    assert!(!has_one_cluster(&mut app, view), "sorted on the CPU");
    app.insert_resource(sorted_on_gpu(true));
    assert!(has_one_cluster(&mut app, view));
    let probe = app.spawn(LightProbe::default());
    assert!(!has_one_cluster(&mut app, view), "a probe");
    app.world_mut().despawn(probe);
    app.spawn(ClusteredDecal::default());
    assert!(!has_one_cluster(&mut app, view), "a decal");
}

#[test]
fn a_camera_without_clusters_has_none_in_its_mirrors() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.insert_resource(sorted_on_gpu(true));
    app.insert(camera, ClusterConfig::None);
    app.update();
    let view = app.view(camera, mirror);
    assert!(matches!(app.of::<ClusterConfig>(view), ClusterConfig::None));
}
