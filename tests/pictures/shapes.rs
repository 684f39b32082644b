//! Flat meshes of every kind as mirrors, under transforms of every kind.

use std::f32::consts::PI;

use bevy::{
    asset::RenderAssetUsages,
    math::DVec3,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};
use bevy_planar_mirror::{MirrorPlane, PlanarMirror};

use crate::support::{
    props::{BLUE, GREEN, RED, YELLOW, at},
    scene::{Look, Scene, Surface},
    studio::Studio,
};

/// Coloured things before whatever mirror stands about the origin and faces +z; one crosses its plane.
fn before(name: &str, surface: Surface) -> Scene {
    Scene::new(name)
        .eye(vec3(0.5, 0.4, 4.0), Vec3::ZERO)
        .mirror(surface)
        .object(
            Cuboid::from_length(0.5),
            RED,
            at(-0.8, 0.2, 1.0).with_rotation(Quat::from_euler(EulerRot::XYZ, 0.3, 0.6, 0.2)),
        )
        .object(
            Cuboid::new(0.3, 0.5, 0.8),
            GREEN,
            at(0.7, -0.5, 0.2).with_rotation(Quat::from_euler(EulerRot::XYZ, 0.2, 0.4, -0.3)),
        )
        .object(
            Sphere::new(0.3).mesh().uv(24, 14),
            YELLOW,
            at(0.3, 0.6, 1.2),
        )
        // Behind: it would show through a hole in the mask.
        .object(Cuboid::new(0.5, 2.0, 0.5), BLUE, at(0.0, 0.0, -1.0))
}

fn upright(mesh: impl Into<Mesh>) -> Surface {
    Surface {
        mesh: mesh.into(),
        ..Surface::wall(1.0, 1.0, Transform::default())
    }
}

/// Two triangles; their first is the upper left.
fn quad() -> Mesh {
    strip_or_list(PrimitiveTopology::TriangleList)
        .with_inserted_indices(Indices::U32(vec![0, 1, 2, 2, 1, 3]))
}

/// Four corners in the order of a strip that winds counter-clockwise seen from +z.
fn strip_or_list(topology: PrimitiveTopology) -> Mesh {
    let corners = [[-1.3, 1.0], [-1.3, -1.0], [1.3, 1.0], [1.3, -1.0]];
    Mesh::new(topology, RenderAssetUsages::default())
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_POSITION,
            corners.map(|[x, y]| [x, y, 0.0]).to_vec(),
        )
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 0.0, 1.0]; 4])
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_UV_0,
            corners
                .map(|[x, y]| [x / 2.6 + 0.5, 0.5 - y / 2.0])
                .to_vec(),
        )
}

#[test]
fn flat_meshes_of_every_shape_are_mirrors() {
    let shapes: [(&str, Mesh); 6] = [
        ("rectangle", Rectangle::new(2.6, 2.0).into()),
        ("circle", Circle::new(1.2).into()),
        ("ring", Annulus::new(0.5, 1.2).into()),
        ("hexagon", RegularPolygon::new(1.2, 6).into()),
        (
            "triangle",
            Triangle2d::new(vec2(-1.2, -0.9), vec2(1.3, -0.6), vec2(0.1, 1.1)).into(),
        ),
        (
            "plane",
            Plane3d::new(Vec3::Z, vec2(1.3, 1.0))
                .mesh()
                .subdivisions(5)
                .build(),
        ),
    ];
    let mut studio = Studio::default();
    for (name, mesh) in shapes {
        studio.assert_reflects(&before(&format!("shape-{name}"), upright(mesh)));
    }
}

#[test]
fn triangles_may_be_lists_or_strips_with_indices_of_any_width_or_none() {
    let strip = strip_or_list(PrimitiveTopology::TriangleStrip);
    let ways: [(&str, Mesh); 5] = [
        (
            "list-16",
            quad().with_inserted_indices(Indices::U16(vec![0, 1, 2, 2, 1, 3])),
        ),
        ("list", quad().with_duplicated_vertices()),
        (
            "strip-16",
            strip
                .clone()
                .with_inserted_indices(Indices::U16(vec![0, 1, 2, 3])),
        ),
        (
            "strip-32",
            strip
                .clone()
                .with_inserted_indices(Indices::U32(vec![0, 1, 2, 3])),
        ),
        ("strip", strip),
    ];
    let mut studio = Studio::default();
    let expected = studio.assert_reflects(&before("triangles", upright(quad())));
    for (name, mesh) in ways {
        let scene = before(&format!("triangles-{name}"), upright(mesh));
        studio.picture(&scene).assert_same(&expected, &scene.name);
    }
}

/// As it comes out of a modelling tool, where a whole house has one origin.
#[test]
fn a_mesh_may_be_modelled_away_from_its_pivot() {
    let pivot = vec3(3.0, -2.0, 5.0);
    let lean = Quat::from_euler(EulerRot::XYZ, 0.3, -0.4, 0.1);
    // The mesh itself leans, and the entity turns it back.
    let mesh = quad().rotated_by(lean).translated_by(pivot);
    let surface = Surface {
        mesh,
        frame: [
            pivot.as_dvec3(),
            (lean * Vec3::X).as_dvec3(),
            (lean * Vec3::Y).as_dvec3(),
        ],
        transform: Transform {
            rotation: lean.inverse(),
            translation: -(lean.inverse() * pivot),
            ..default()
        },
        ..upright(quad())
    };
    Studio::default().assert_reflects(&before("pivot", surface));
}

/// A mesh that only the GPU has, for which the plane is given.
#[test]
fn the_plane_may_be_given() {
    let mut mesh = quad();
    mesh.asset_usage = RenderAssetUsages::RENDER_WORLD;
    let surface = Surface {
        mirror: PlanarMirror {
            plane: MirrorPlane::Local {
                point: vec3(0.4, -0.3, 0.0),
                normal: vec3(0.0, 0.0, 7.0),
            },
            ..default()
        },
        ..upright(mesh)
    };
    Studio::default().assert_reflects(&before("given", surface));
}

#[test]
fn a_mirror_may_be_stretched_flattened_and_turned_over() {
    let turned = Quat::from_rotation_y(PI);
    let lean = Quat::from_euler(EulerRot::XYZ, -0.3, 0.3, 0.2);
    let scales = [
        ("flat", vec3(1.0, 1.0, 0.0), Quat::IDENTITY),
        ("stretched", vec3(0.7, 1.3, 40.0), lean),
        ("small", vec3(1e-3, 1e-3, 1e-3), lean),
        ("large", vec3(1e3, 1e3, 1e3), lean),
        // The front goes where the transform carries it, as normals do, not by how the triangles
        // wind in the world then.
        ("x", vec3(-1.0, 1.0, 1.0), lean),
        ("y", vec3(1.0, -1.0, 1.0), lean),
        ("xy", vec3(-1.0, -1.0, 1.0), lean),
        ("z", vec3(1.0, 1.0, -1.0), turned),
        ("xyz", vec3(-1.0, -1.0, -1.0), turned),
    ];
    let mut studio = Studio::default();
    for (name, scale, rotation) in scales {
        let mut surface = upright(quad());
        let size = scale.abs().truncate();
        // The mirror is as large as ever on the screen.
        surface.mesh = surface.mesh.scaled_by(size.recip().extend(1.0));
        surface.transform = Transform {
            scale,
            rotation,
            ..default()
        };
        studio.assert_reflects(&before(&format!("scale-{name}"), surface));
    }
}

/// Its own transform is a proper one, that of its parent is not.
#[test]
fn a_mirror_may_have_a_mirrored_parent() {
    let lean = Quat::from_rotation_x(-0.3);
    let mut surface = upright(quad());
    // Rotations about x commute with a parent that is mirrored in x.
    let own = Transform {
        translation: vec3(0.2, 0.1, 0.0),
        rotation: lean,
        scale: vec3(1.0, 0.8, 1.0),
    };
    let flip = vec3(-1.0, 1.0, 1.0);
    surface.transform = Transform {
        translation: own.translation * flip,
        scale: own.scale * flip,
        ..own
    };
    surface.look = Some(Look::other(move |entity| {
        let parent = entity.world_scope(|world| world.spawn(Transform::from_scale(flip)).id());
        entity.insert((own, ChildOf(parent)));
    }));
    Studio::default().assert_reflects(&before("mirrored-parent", surface));
}

/// Stretched by its parent across its own axes, which no transform of its own could do.
#[test]
fn a_mirror_may_be_sheared_by_its_parent() {
    let own = Quat::from_rotation_z(0.6);
    let stretch = vec3(1.4, 0.7, 1.0);
    let shear = Mat3::from_diagonal(stretch) * Mat3::from_quat(own);
    let surface = upright(quad().transformed_by(Transform::default()));
    let baked = |mut mesh: Mesh| {
        let Some(bevy::mesh::VertexAttributeValues::Float32x3(corners)) =
            mesh.attribute_mut(Mesh::ATTRIBUTE_POSITION)
        else {
            panic!("a quad has positions");
        };
        for corner in corners {
            *corner = (shear * Vec3::from_array(*corner)).to_array();
        }
        mesh
    };
    let expected = Surface {
        mesh: baked(quad()),
        frame: [DVec3::ZERO, DVec3::X, DVec3::Y],
        ..upright(quad())
    };
    let mut sheared = surface;
    sheared.look = Some(Look::other(move |entity| {
        let parent = Transform::from_scale(stretch);
        let parent = entity.world_scope(|world| world.spawn(parent).id());
        entity.insert((Transform::from_rotation(own), ChildOf(parent)));
    }));
    let mut studio = Studio::default();
    let expected = studio.assert_reflects(&before("sheared-expected", expected));
    let picture = studio.picture(&before("sheared", sheared));
    picture.assert_alike(&expected, 2, 0.9999, |_| true, "sheared");
}
