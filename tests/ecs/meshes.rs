//! The plane comes from the mesh: also from a new one, a changed one and a late one.

use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};
use bevy_planar_mirror::{MirrorPlane, NotDrawn, PlanarMirror};

use super::app::{EYE, MirrorApp, PLAIN, mirror_app, not};

/// A square in a plane of this height over z = 0, turned about Y.
fn square(height: f32, turn: f32) -> Mesh {
    Mesh::from(Rectangle::new(2.0, 2.0))
        .translated_by(vec3(0.0, 0.0, height))
        .rotated_by(Quat::from_rotation_y(turn))
}

/// The place of a view in a plane with this normal through this point, for a camera at [`EYE`].
#[track_caller]
fn assert_mirrored_about(app: &mut MirrorApp, camera: Entity, mirror: Entity, on: Vec3, turn: f32) {
    let view = app.view(camera, mirror);
    let place = app.of::<GlobalTransform>(view).translation();
    let normal = Quat::from_rotation_y(turn) * Vec3::Z;
    let eye = EYE.translation;
    let expected = eye - 2.0 * normal * normal.dot(eye - on);
    assert!(
        place.distance(expected) < 1e-5,
        "at {place}, expected {expected}"
    );
}

/// Whatever mesh is put on a mirror in this way, its plane is the mirror's in the same frame.
#[track_caller]
fn assert_plane_follows(put: impl Fn(&mut MirrorApp, Entity, Mesh)) {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.update();
    for (height, turn) in [(1.0, 0.0), (0.0, 0.3), (-0.5, -0.2)] {
        put(&mut app, mirror, square(height, turn));
        app.update();
        let on = Quat::from_rotation_y(turn) * vec3(0.0, 0.0, height);
        assert_mirrored_about(&mut app, camera, mirror, on, turn);
    }
}

/// Fills a place that is kept for a mesh.
fn fill(app: &mut MirrorApp, id: AssetId<Mesh>, mesh: Mesh) {
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    meshes.insert(id, mesh).expect("a handle keeps it");
}

fn empty(app: &mut MirrorApp, id: AssetId<Mesh>) {
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    meshes.remove(id).expect("it is there");
}

#[test]
fn a_new_mesh_has_a_new_plane_in_the_same_frame() {
    assert_plane_follows(|app, mirror, mesh| {
        let mesh = app.mesh(mesh);
        app.insert(mirror, Mesh3d(mesh));
    });
}

#[test]
fn a_mesh_changed_in_place_has_a_new_plane_in_the_same_frame() {
    assert_plane_follows(|app, mirror, mesh| {
        let id = app.of::<Mesh3d>(mirror).id();
        let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
        *meshes.get_mut(id).expect("it is there") = mesh;
    });
}

/// What was known of the old one does not count any more.
#[test]
fn a_mesh_in_place_of_one_that_was_removed_has_a_plane_of_its_own() {
    for frames_between in [0, 2] {
        assert_plane_follows(|app, mirror, mesh| {
            let id = app.of::<Mesh3d>(mirror).id();
            empty(app, id);
            app.updates(frames_between);
            fill(app, id, mesh);
        });
    }
}

#[test]
fn a_mesh_that_is_bent_and_flattened_again_says_so() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    let id = app.of::<Mesh3d>(mirror).id();
    for (mesh, expected) in [
        (Cuboid::default().into(), not(NotDrawn::MeshNotFlat)),
        (square(0.0, 0.0), PLAIN),
        (
            Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::all()),
            not(NotDrawn::MeshEmpty),
        ),
        (square(0.0, 0.1), PLAIN),
    ] {
        fill(&mut app, id, mesh);
        app.update();
        app.assert_state(mirror, camera, expected);
        assert_eq!(app.views().len(), usize::from(expected == PLAIN));
    }
}

#[test]
fn a_mirror_waits_for_its_mesh() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    let late = app.world().resource::<Assets<Mesh>>().reserve_handle();
    app.insert(mirror, Mesh3d(late.clone()));
    app.updates(3);
    app.assert_state(mirror, camera, not(NotDrawn::NoMesh));
    assert!(app.views().is_empty());
    fill(&mut app, late.id(), square(0.0, 0.0));
    app.update();
    app.assert_state(mirror, camera, PLAIN);
    // And it may go again.
    empty(&mut app, late.id());
    app.update();
    app.assert_state(mirror, camera, not(NotDrawn::NoMesh));
    assert!(app.views().is_empty());
}

#[test]
fn a_mirror_with_a_given_plane_waits_for_its_mesh_too() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    app.insert(mirror, facing(Vec3::Z));
    let late = app.world().resource::<Assets<Mesh>>().reserve_handle();
    app.insert(mirror, Mesh3d(late.clone()));
    app.update();
    app.assert_state(mirror, camera, not(NotDrawn::NoMesh));
    fill(&mut app, late.id(), square(0.0, 0.0));
    app.update();
    app.assert_state(mirror, camera, PLAIN);
}

/// A mirror that is told its plane: through the origin.
fn facing(normal: Vec3) -> PlanarMirror {
    PlanarMirror {
        plane: MirrorPlane::Local {
            point: Vec3::ZERO,
            normal,
        },
        ..default()
    }
}

#[test]
fn a_given_plane_serves_where_the_mesh_has_none() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    let ball = app.mesh(Sphere::new(0.5));
    app.insert(mirror, Mesh3d(ball));
    app.update();
    app.assert_state(mirror, camera, not(NotDrawn::MeshNotFlat));
    let turn = 0.25_f32;
    // Its length does not matter.
    app.insert(mirror, facing(Quat::from_rotation_y(turn) * Vec3::Z * 30.0));
    app.update();
    app.assert_state(mirror, camera, PLAIN);
    assert_mirrored_about(&mut app, camera, mirror, Vec3::ZERO, turn);
    app.insert(mirror, PlanarMirror::default());
    app.update();
    app.assert_state(mirror, camera, not(NotDrawn::MeshNotFlat));
}

#[test]
fn mirrors_that_share_a_mesh_each_have_a_plane() {
    let mut app = mirror_app();
    let mesh = app.mesh(square(0.0, 0.0));
    let camera = app.spawn_camera(EYE);
    for z in [-1.0, 0.5] {
        let at = Transform::from_xyz(0.0, 0.0, z);
        let mirror = app.spawn((Mesh3d(mesh.clone()), at, PlanarMirror::default()));
        app.update();
        assert_mirrored_about(&mut app, camera, mirror, at.translation, 0.0);
    }
    assert_eq!(app.views().len(), 2);
}

/// Four corners of a square that faces +Z, left to right and bottom to top.
const CORNERS: [[f32; 3]; 4] = [
    [-1.0, -1.0, 0.5],
    [1.0, -1.0, 0.5],
    [-1.0, 1.0, 0.5],
    [1.0, 1.0, 0.5],
];

fn corners(topology: PrimitiveTopology, order: &[usize], indices: Option<Indices>) -> Mesh {
    let positions: Vec<_> = order.iter().map(|&corner| CORNERS[corner]).collect();
    let mut mesh = Mesh::new(topology, RenderAssetUsages::all());
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    if let Some(indices) = indices {
        mesh.insert_indices(indices);
    }
    mesh
}

#[test]
fn lists_and_strips_with_and_without_indices_face_alike() {
    use PrimitiveTopology::{TriangleList, TriangleStrip};
    let list = [0, 1, 2, 2, 1, 3];
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    for mesh in [
        corners(TriangleList, &list, None),
        corners(
            TriangleList,
            &[0, 1, 2, 3],
            Some(Indices::U16(vec![0, 1, 2, 2, 1, 3])),
        ),
        corners(
            TriangleList,
            &[3, 2, 1, 0],
            Some(Indices::U32(vec![3, 2, 1, 1, 2, 0])),
        ),
        corners(TriangleStrip, &[0, 1, 2, 3], None),
        corners(
            TriangleStrip,
            &[3, 2, 1, 0],
            Some(Indices::U32(vec![3, 2, 1, 0])),
        ),
    ] {
        let mesh = app.mesh(mesh);
        app.insert(mirror, Mesh3d(mesh));
        app.of_mut::<Transform>(mirror).rotation = Quat::IDENTITY;
        app.update();
        app.assert_state(mirror, camera, PLAIN);
        assert_mirrored_about(&mut app, camera, mirror, vec3(0.0, 0.0, 0.5), 0.0);
        // From behind it is no mirror.
        app.of_mut::<Transform>(mirror).rotation = Quat::from_rotation_y(std::f32::consts::PI);
        app.update();
        app.assert_state(mirror, camera, not(NotDrawn::EyeBehind));
    }
}

/// If they had not, the larger half would decide: once the first triangle, once the second.
#[test]
fn all_triangles_of_a_strip_have_the_same_front() {
    let mut app = mirror_app();
    let (mirror, camera) = (app.spawn_mirror(default()), app.spawn_camera(EYE));
    for (below, above) in [(0.2, 1.0), (1.0, 0.2)] {
        let trapezoid = vec![
            [-below, -1.0, 0.5],
            [below, -1.0, 0.5],
            [-above, 1.0, 0.5],
            [above, 1.0, 0.5],
        ];
        let topology = PrimitiveTopology::TriangleStrip;
        let mesh = Mesh::new(topology, RenderAssetUsages::all())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, trapezoid);
        let mesh = app.mesh(mesh);
        app.insert(mirror, Mesh3d(mesh));
        app.update();
        app.assert_state(mirror, camera, PLAIN);
        assert_mirrored_about(&mut app, camera, mirror, vec3(0.0, 0.0, 0.5), 0.0);
    }
}
