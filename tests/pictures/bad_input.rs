//! Bad mirrors: the rest of the picture is drawn as if they were none, with one line in the log.

use bevy::{
    asset::RenderAssetUsages,
    camera::Viewport,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
    render::settings::{WgpuFeatures, WgpuSettings},
};
use bevy_planar_mirror::{PlanarMirror, PlanarMirrorPlugin};

use crate::support::{
    hall::hall,
    live::Live,
    props::at,
    scene::{Scene, Surface},
    set::add_camera,
    stage::Stage,
    studio::Studio,
};

/// The hall with another mirror in place of its own.
fn with(name: &str, surface: Surface) -> Scene {
    let mut scene = hall(name);
    scene.mirrors = vec![surface];
    scene
}

fn wall() -> Surface {
    Surface::wall(3.2, 2.2, at(0.0, 0.5, 0.0))
}

fn of_mesh(mesh: Mesh) -> Surface {
    Surface { mesh, ..wall() }
}

/// Two triangles that are not in one plane.
fn bent() -> Mesh {
    mesh(
        PrimitiveTopology::TriangleList,
        &[
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.5],
            [0.0, 1.0, 0.0],
        ],
    )
    .with_inserted_indices(Indices::U32(vec![0, 1, 2, 0, 2, 3]))
}

/// A triangle of which one corner does not exist.
fn out_of_range() -> Mesh {
    mesh(
        PrimitiveTopology::TriangleList,
        &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    )
    .with_inserted_indices(Indices::U32(vec![0, 1, 7]))
}

fn mesh(topology: PrimitiveTopology, positions: &[[f32; 3]]) -> Mesh {
    Mesh::new(topology, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions.to_vec())
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_NORMAL,
            vec![[0.0, 0.0, 1.0]; positions.len()],
        )
}

#[test]
fn a_bad_mirror_changes_no_pixel_and_says_so_once() {
    let scaled = |scale| Surface {
        transform: at(0.0, 0.5, 0.0).with_scale(scale),
        ..wall()
    };
    let moved = |x| Surface {
        transform: at(x, 0.5, 0.0),
        ..wall()
    };
    let cases = [
        ("nan", moved(f32::NAN), "degenerate"),
        ("infinite", moved(f32::INFINITY), "degenerate"),
        ("no-scale", scaled(Vec3::ZERO), "degenerate"),
        ("a-line", scaled(Vec3::new(1.0, 0.0, 1.0)), "degenerate"),
        (
            "lines",
            of_mesh(mesh(
                PrimitiveTopology::LineList,
                &[[0.0; 3], [1.0, 0.0, 0.0]],
            )),
            "not made of",
        ),
        ("bent", of_mesh(bent()), "not flat"),
        ("out-of-range", of_mesh(out_of_range()), "not made of"),
    ];
    let mut studio = Studio::default();
    for (name, surface, reason) in cases {
        let before = studio.stage().warnings().count();
        studio.assert_no_mirror(&with(&format!("bad-{name}"), surface));
        let warnings: Vec<_> = studio.stage().warnings().skip(before).collect();
        let ours: Vec<_> = warnings
            .iter()
            .filter(|line| line.target.starts_with("bevy_planar_mirror"))
            .collect();
        assert!(
            matches!(&ours[..], [one] if one.text.contains(reason)),
            "{name}: {ours:?}"
        );
    }
}

#[test]
fn a_bad_mirror_does_not_disturb_a_good_one() {
    let mut scene = hall("beside-a-bad-one");
    let mut studio = Studio::default();
    let good = studio.picture(&scene);
    scene.mirrors.push(of_mesh(bent()));
    scene.mirrors.push(Surface {
        transform: at(f32::NAN, 0.0, 0.0),
        ..wall()
    });
    let both = studio.picture(&scene);
    both.assert_same(&good, "beside-a-bad-one");
}

/// What an app shows and reports with the plugin is what it shows and reports without.
///
/// For input of which the engine itself reports errors.
#[track_caller]
fn assert_no_mirror_and_no_other_errors(scene: &Scene, spoil: impl Fn(&mut Live)) {
    let [with, without] =
        [Live::in_reach(scene), Live::plain(Stage::stock(), scene)].map(|mut live| {
            spoil(&mut live);
            let errors: Vec<_> = (0..5)
                .filter_map(|_| live.stage.try_frame(App::update).err())
                .collect();
            (errors, live.stage.read(&live.target, live.size))
        });
    assert_eq!(with.0, without.0, "{}", scene.name);
    assert!(with.1 == without.1, "{}: another picture", scene.name);
}

#[test]
fn a_mirror_without_corners_changes_nothing() {
    let empty = of_mesh(mesh(PrimitiveTopology::TriangleList, &[]));
    assert_no_mirror_and_no_other_errors(&with("bad-empty", empty), |_| {});
}

#[test]
fn a_viewport_without_pixels_is_what_it_is_without_mirrors() {
    assert_no_mirror_and_no_other_errors(&hall("no-pixels"), |live| {
        let camera = live.camera;
        let mut camera = live.world().get_mut::<Camera>(camera).expect("it is one");
        camera.viewport = Some(Viewport {
            physical_size: UVec2::ZERO,
            ..default()
        });
    });
}

/// It sees no mirror, and the other camera sees what it would see without it.
#[test]
fn a_camera_that_is_nowhere_disturbs_no_other() {
    let scene = hall("nowhere");
    let alone = Live::in_reach(&scene).settled();
    for place in [at(f32::NAN, 0.0, 0.0), at(0.0, f32::INFINITY, 0.0)] {
        let nowhere = |mut live: Live| {
            let target = live.stage.target(scene.size);
            let camera = add_camera(&mut live.stage, &scene, target.clone());
            live.world().entity_mut(camera).insert(place);
            let beside = live.settled();
            (beside, live.stage.read(&target, scene.size))
        };
        let (beside, shown) = nowhere(Live::in_reach(&scene));
        beside.assert_same(&alone, "beside-nowhere");
        let (_, plain) = nowhere(Live::plain(Stage::stock(), &scene));
        assert_eq!(shown, plain, "at {}", place.translation);
    }
}

/// Without the format that keeps the main pass's depth there is another.
#[test]
fn without_a_depth_of_32_bits_beside_the_stencil_24_do() {
    let wgpu = WgpuSettings {
        disabled_features: Some(WgpuFeatures::DEPTH32FLOAT_STENCIL8),
        ..default()
    };
    let scene = hall("depth24");
    let stage = Stage::with_wgpu(wgpu, |app| {
        app.add_plugins(PlanarMirrorPlugin::default());
    });
    let coarse = Live::on(stage, &scene).settled();
    let fine = Live::in_reach(&scene).settled();
    coarse.assert_alike(&fine, 2, 0.999, |_| true, "depth24");
}

/// 300 mirrors in view: as many as the plugin may are drawn, the rest are as if they were none.
#[test]
fn more_mirrors_than_may_be_drawn() {
    let mut scene = Scene::new("crowd").eye(vec3(0.0, 0.0, 12.0), Vec3::ZERO);
    scene.size = UVec2::new(120, 90);
    for i in 0..300 {
        let (column, row) = (i % 20, i / 20);
        let place = vec3(
            column as f32 * 0.4 - 3.8,
            row as f32 * 0.4 - 2.8,
            i as f32 * -1e-3,
        );
        scene.mirrors.push(Surface::wall(
            0.36,
            0.36,
            Transform::from_translation(place),
        ));
    }
    let mut live = Live::in_reach(&scene);
    live.stage.frame();
    live.stage.frame();
    let world = live.world();
    let mut mirrors = world.query::<(&bevy_planar_mirror::MirrorStatus, &PlanarMirror)>();
    let drawn = mirrors
        .iter(world)
        .filter(|(status, _)| status.is_drawn())
        .count();
    let named = mirrors
        .iter(world)
        .filter(|(status, _)| {
            status
                .cameras
                .iter()
                .any(|seen| seen.state.to_string().contains("more mirrors in view"))
        })
        .count();
    assert_eq!((drawn, named), (255, 45));
}
