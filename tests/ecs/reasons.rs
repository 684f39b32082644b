//! Every reason why a mirror is not drawn, reached once.

use std::collections::HashSet;

use bevy::{
    asset::RenderAssetUsages,
    camera::{RenderTarget, visibility::RenderLayers},
    core_pipeline::prepass::DeferredPrepass,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};
use bevy_planar_mirror::{MirrorPlane, MirrorState, NotDrawn, PlanarMirror, status};

use super::app::{EYE, MirrorApp, PLAIN, floor, logged_mirror_app, mirror_app, not};

/// A mirror and a camera, and another mirror that must not care.
fn pair() -> (MirrorApp, Entity, Entity) {
    let mut app = mirror_app();
    let other = app.spawn_mirror(Transform::from_xyz(0.5, 0.5, 0.1));
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.update();
    app.assert_state(mirror, camera, PLAIN);
    app.assert_state(other, camera, PLAIN);
    (app, mirror, camera)
}

/// The mirror alone is not drawn, for this reason.
#[track_caller]
fn assert_only(app: &mut MirrorApp, mirror: Entity, camera: Entity, reason: NotDrawn) {
    app.update();
    app.assert_state(mirror, camera, not(reason));
    assert_eq!(app.views_of(camera).len(), 1, "the other mirror is drawn");
    app.updates(2);
    app.assert_state(mirror, camera, not(reason));
}

/// The camera alone sees no mirrors, for this reason.
#[track_caller]
fn assert_blind(app: &mut MirrorApp, mirror: Entity, camera: Entity, reason: NotDrawn) {
    let other = app.spawn_camera(EYE);
    app.updates(2);
    app.assert_state(mirror, camera, not(reason));
    assert!(app.views_of(camera).is_empty());
    app.assert_state(mirror, other, PLAIN);
    assert_eq!(app.views_of(other).len(), 2, "the other camera sees both");
}

#[test]
fn hidden() {
    let (mut app, mirror, camera) = pair();
    app.insert(mirror, Visibility::Hidden);
    assert_only(&mut app, mirror, camera, NotDrawn::Hidden);
}

#[test]
fn other_layers() {
    let (mut app, mirror, camera) = pair();
    app.insert(mirror, RenderLayers::layer(4));
    assert_only(&mut app, mirror, camera, NotDrawn::OtherLayers);
}

#[test]
fn no_mesh() {
    let (mut app, mirror, camera) = pair();
    app.remove::<Mesh3d>(mirror);
    assert_only(&mut app, mirror, camera, NotDrawn::NoMesh);
}

#[test]
fn mesh_not_in_main_world() {
    let (mut app, mirror, camera) = pair();
    // What the renderer does with a mesh of RENDER_WORLD alone, before the mirror comes.
    let mut gone = Mesh::from(Rectangle::new(2.0, 2.0));
    gone.take_gpu_data().expect("it is there to take");
    let gone = app.mesh(gone);
    app.insert(mirror, Mesh3d(gone));
    assert_only(&mut app, mirror, camera, NotDrawn::MeshNotInMainWorld);
    // The remedy that its log line names.
    app.insert(
        mirror,
        PlanarMirror {
            plane: MirrorPlane::Local {
                point: Vec3::ZERO,
                normal: Vec3::Z,
            },
            ..default()
        },
    );
    app.update();
    app.assert_state(mirror, camera, PLAIN);
}

fn triangles(positions: Vec<[f32; 3]>) -> Mesh {
    let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::all());
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    mesh
}

#[test]
fn mesh_empty() {
    let line = [[0.0; 3], [1.0, 1.0, 0.0], [2.0, 2.0, 0.0]];
    for mesh in [
        Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::all()),
        triangles(Vec::new()),
        triangles(line[..2].to_vec()),
        triangles(line.to_vec()),
        triangles(vec![[1.0, 2.0, 3.0]; 6]),
    ] {
        let (mut app, mirror, camera) = pair();
        let mesh = app.mesh(mesh);
        app.insert(mirror, Mesh3d(mesh));
        assert_only(&mut app, mirror, camera, NotDrawn::MeshEmpty);
    }
}

#[test]
fn mesh_not_flat() {
    for mesh in [
        Mesh::from(Cuboid::default()),
        Mesh::from(Sphere::new(1.0)),
        // A roof with a ridge of a hundredth of its width.
        triangles(vec![
            [-1.0, 0.0, 0.0],
            [0.0, 0.0, 0.02],
            [0.0, 1.0, 0.02],
            [0.0, 0.0, 0.02],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.02],
        ]),
    ] {
        let (mut app, mirror, camera) = pair();
        let mesh = app.mesh(mesh);
        app.insert(mirror, Mesh3d(mesh));
        assert_only(&mut app, mirror, camera, NotDrawn::MeshNotFlat);
    }
}

#[test]
fn mesh_not_readable() {
    let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut lines = Mesh::new(PrimitiveTopology::LineList, RenderAssetUsages::all());
    lines.insert_attribute(Mesh::ATTRIBUTE_POSITION, corners.clone());
    let mut out_of_range = triangles(corners.clone());
    out_of_range.insert_indices(Indices::U32(vec![0, 1, 7]));
    for (what, mesh) in [
        ("lines", lines),
        ("an index that names no vertex", out_of_range),
        (
            "nan",
            triangles(vec![[f32::NAN, 0.0, 0.0], corners[1], corners[2]]),
        ),
        (
            "infinite",
            triangles(vec![[f32::INFINITY, 0.0, 0.0], corners[1], corners[2]]),
        ),
    ] {
        let (mut app, mirror, camera) = pair();
        let mesh = app.mesh(mesh);
        app.insert(mirror, Mesh3d(mesh));
        app.update();
        assert_eq!(
            app.state_of(mirror, camera),
            not(NotDrawn::MeshNotReadable),
            "{what}"
        );
        assert_only(&mut app, mirror, camera, NotDrawn::MeshNotReadable);
    }
}

#[test]
fn degenerate_transform() {
    let scale = |x, y, z| Transform::from_scale(vec3(x, y, z));
    for at in [
        Transform::from_xyz(f32::NAN, 0.0, 0.0),
        Transform::from_xyz(0.0, f32::INFINITY, 0.0),
        Transform::from_xyz(0.0, 0.0, f32::NEG_INFINITY),
        Transform::from_rotation(Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0)),
        scale(0.0, 0.0, 0.0),
        scale(1.0, 0.0, 1.0),
        scale(0.0, 1.0, 1.0),
        scale(f32::NAN, 1.0, 1.0),
        scale(1.0, f32::INFINITY, 1.0),
    ] {
        let (mut app, mirror, camera) = pair();
        *app.of_mut::<Transform>(mirror) = at;
        assert_only(&mut app, mirror, camera, NotDrawn::DegenerateTransform);
        *app.of_mut::<Transform>(mirror) = default();
        app.update();
        app.assert_state(mirror, camera, PLAIN);
    }
}

#[test]
fn degenerate_transform_by_a_parent() {
    let (mut app, mirror, camera) = pair();
    let parent = app.spawn((Transform::from_scale(Vec3::ZERO), Visibility::default()));
    app.insert(mirror, ChildOf(parent));
    assert_only(&mut app, mirror, camera, NotDrawn::DegenerateTransform);
}

#[test]
fn degenerate_given_plane() {
    for (point, normal) in [
        (Vec3::ZERO, Vec3::ZERO),
        (Vec3::ZERO, Vec3::NAN),
        (Vec3::ZERO, vec3(0.0, f32::INFINITY, 0.0)),
        (vec3(f32::NAN, 0.0, 0.0), Vec3::Z),
        (Vec3::INFINITY, Vec3::Z),
    ] {
        let (mut app, mirror, camera) = pair();
        let plane = MirrorPlane::Local { point, normal };
        app.of_mut::<PlanarMirror>(mirror).plane = plane;
        assert_only(&mut app, mirror, camera, NotDrawn::DegenerateTransform);
    }
}

#[test]
fn degenerate_camera_transform() {
    // Without a forward direction, as of scale 0, Bevy itself panics in update_frusta, if it has debug assertions.
    for eye in [
        EYE.with_translation(Vec3::NAN),
        EYE.with_translation(Vec3::INFINITY),
        EYE.with_scale(vec3(1.0, 0.0, 1.0)),
        EYE.with_scale(vec3(0.0, 0.0, 1.0)),
    ] {
        let (mut app, mirror, camera) = pair();
        *app.of_mut::<Transform>(camera) = eye;
        assert_blind(&mut app, mirror, camera, NotDrawn::DegenerateCamera);
    }
}

#[test]
fn degenerate_camera_projection() {
    let perspective = |fov: f32, near: f32| -> Projection {
        PerspectiveProjection {
            fov,
            near,
            ..default()
        }
        .into()
    };
    for projection in [
        perspective(f32::NAN, 0.1),
        perspective(1.0, f32::NAN),
        perspective(1.0, f32::INFINITY),
        perspective(1.0, 0.0),
        OrthographicProjection {
            scale: 0.0,
            ..OrthographicProjection::default_3d()
        }
        .into(),
        OrthographicProjection {
            near: 5.0,
            far: 5.0,
            ..OrthographicProjection::default_3d()
        }
        .into(),
    ] {
        let (mut app, mirror, camera) = pair();
        app.insert(camera, projection);
        assert_blind(&mut app, mirror, camera, NotDrawn::DegenerateCamera);
    }
}

#[test]
fn no_target() {
    let (mut app, mirror, camera) = pair();
    // The camera of an app whose window is not there yet, and one that draws nothing.
    let windowless = app.spawn((Camera3d::default(), EYE));
    let empty = app.spawn((
        Camera3d::default(),
        EYE,
        RenderTarget::None { size: UVec2::ZERO },
    ));
    app.updates(2);
    app.assert_state(mirror, windowless, not(NotDrawn::NoTarget));
    app.assert_state(mirror, empty, not(NotDrawn::NoTarget));
    assert_eq!(app.views(), app.views_of(camera));
}

#[test]
fn deferred_camera() {
    let (mut app, mirror, camera) = pair();
    app.insert(camera, DeferredPrepass);
    assert_blind(&mut app, mirror, camera, NotDrawn::DeferredCamera);
    app.remove::<DeferredPrepass>(camera);
    app.update();
    app.assert_state(mirror, camera, PLAIN);
}

#[test]
fn eye_behind() {
    let (mut app, mirror, camera) = pair();
    for at in [
        Transform::from_rotation(Quat::from_rotation_y(std::f32::consts::PI)),
        Transform::from_xyz(0.0, 0.0, 6.0),
        // The eye is in the plane.
        Transform::from_xyz(0.0, 0.0, 5.0),
        floor(0.0),
    ] {
        *app.of_mut::<Transform>(mirror) = at;
        assert_only(&mut app, mirror, camera, NotDrawn::EyeBehind);
    }
}

#[test]
fn eye_behind_of_an_orthographic_camera_is_where_it_looks() {
    let (mut app, mirror, camera) = pair();
    app.insert(
        camera,
        Projection::from(OrthographicProjection::default_3d()),
    );
    app.of_mut::<Transform>(mirror).scale = Vec3::splat(50.0);
    app.update();
    app.assert_state(mirror, camera, PLAIN);
    app.of_mut::<Transform>(mirror).rotation = Quat::from_rotation_y(std::f32::consts::PI);
    app.update();
    app.assert_state(mirror, camera, not(NotDrawn::EyeBehind));
}

#[test]
fn out_of_view() {
    let (mut app, mirror, camera) = pair();
    for at in [
        Transform::from_xyz(50.0, 0.0, 0.0),
        Transform::from_xyz(0.0, -20.0, 0.0),
        // At the back of the camera, and facing it.
        Transform::from_xyz(0.0, 0.0, 8.0).with_rotation(Quat::from_rotation_y(3.1)),
    ] {
        *app.of_mut::<Transform>(mirror) = at;
        assert_only(&mut app, mirror, camera, NotDrawn::OutOfView);
    }
}

#[test]
fn too_thin() {
    let (mut app, mirror, camera) = pair();
    // A hundred pixels high: a unit at a distance of 5 is 24 pixels.
    for at in [
        floor(-0.02),
        Transform::from_scale(vec3(1.0, 0.01, 1.0)),
        Transform::from_xyz(0.0, 0.0, -1000.0),
    ] {
        *app.of_mut::<Transform>(mirror) = at;
        assert_only(&mut app, mirror, camera, NotDrawn::TooThin);
    }
}

#[test]
fn below_precision() {
    let (mut app, mirror, camera) = pair();
    let far = vec3(3e6, 0.0, 0.0);
    *app.of_mut::<Transform>(mirror) = Transform::from_translation(far);
    *app.of_mut::<Transform>(camera) = EYE.with_translation(EYE.translation + far);
    app.update();
    app.assert_state(mirror, camera, not(NotDrawn::BelowPrecision));
    assert!(app.views().is_empty());
}

/// As many as a stencil has ids for: the nearest.
#[test]
fn too_many_mirrors() {
    const COUNT: usize = 300;
    let mut app = logged_mirror_app();
    let camera = app.spawn_camera(EYE);
    let mesh = app.mesh(Rectangle::new(2.0, 2.0));
    // Not in the order of their distance.
    let depth = |index: usize| ((index * 77) % COUNT) as f32 * 0.02;
    let mirrors: Vec<Entity> = (0..COUNT)
        .map(|index| {
            let at = Transform::from_xyz(0.0, 0.0, -depth(index));
            app.spawn((Mesh3d(mesh.clone()), at, PlanarMirror::default()))
        })
        .collect();
    app.updates(2);
    for (index, &mirror) in mirrors.iter().enumerate() {
        let drawn = depth(index) < 254.5 * 0.02;
        let expected = if drawn {
            PLAIN
        } else {
            not(NotDrawn::TooManyMirrors)
        };
        assert_eq!(app.state_of(mirror, camera), expected, "mirror {index}");
    }
    assert_eq!(app.views().len(), 255);
    let lines = app.log_lines();
    assert_eq!(lines.len(), 1, "one cause, one line: {lines:?}");

    // Another camera has ids of its own.
    let other = app.spawn_camera(EYE);
    app.update();
    assert_eq!(app.views_of(other).len(), 255);
    app.despawn(other);
    // The next nearest move up.
    for (index, &mirror) in mirrors.iter().enumerate() {
        if depth(index) < 44.5 * 0.02 {
            app.despawn(mirror);
        }
    }
    app.update();
    assert_eq!(app.views().len(), 255);
    for (index, &mirror) in mirrors.iter().enumerate() {
        if depth(index) > 44.5 * 0.02 {
            assert_eq!(app.state_of(mirror, camera), PLAIN, "mirror {index}");
        }
    }
}

const ALL: [NotDrawn; 17] = [
    NotDrawn::NoRenderer,
    NotDrawn::Hidden,
    NotDrawn::OtherLayers,
    NotDrawn::NoMesh,
    NotDrawn::MeshNotInMainWorld,
    NotDrawn::MeshEmpty,
    NotDrawn::MeshNotFlat,
    NotDrawn::MeshNotReadable,
    NotDrawn::DegenerateTransform,
    NotDrawn::DegenerateCamera,
    NotDrawn::NoTarget,
    NotDrawn::DeferredCamera,
    NotDrawn::EyeBehind,
    NotDrawn::OutOfView,
    NotDrawn::TooThin,
    NotDrawn::BelowPrecision,
    NotDrawn::TooManyMirrors,
];

#[test]
fn every_state_reads_differently() {
    let drawn = [status::Projection::Plain, status::Projection::Oblique].map(MirrorState::Drawn);
    let states = ALL.map(MirrorState::NotDrawn).into_iter().chain(drawn);
    let texts: Vec<String> = states.map(|state| state.to_string()).collect();
    assert!(texts.iter().all(|text| text.len() > 4), "{texts:?}");
    let distinct: HashSet<_> = texts.iter().collect();
    assert_eq!(distinct.len(), ALL.len() + 2, "{texts:?}");
    for reason in ALL {
        let text = MirrorState::NotDrawn(reason).to_string();
        assert_eq!(text, format!("not drawn: {reason}"));
    }
}
