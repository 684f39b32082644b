//! Objects that are more than a mesh of one color: vertex colors, relief, lines, bones, many at once.

use std::{f32::consts::PI, sync::Arc};

use bevy::{
    asset::RenderAssetUsages,
    camera::visibility::{RenderLayers, VisibilityRange},
    image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor},
    mesh::{
        PrimitiveTopology, VertexAttributeValues,
        morph::{MeshMorphWeights, MorphAttributes, MorphWeights},
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    pbr::Lightmap,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};

use crate::support::{
    props::{BLUE, GREEN, RED, YELLOW, add, at, four_quarters, is, lamp, lit, sun},
    scene::{Look, Scene, Surface},
    studio::{Studio, assert_reflects},
};

fn wall(name: &str) -> Scene {
    Scene::new(name)
        .eye(vec3(0.9, 0.5, 4.0), Vec3::ZERO)
        .mirror(Surface::wall(4.0, 2.6, Transform::default()))
}

fn turned(x: f32, y: f32, z: f32) -> Transform {
    at(x, y, z).with_rotation(Quat::from_euler(EulerRot::XYZ, 0.3, 0.6, 0.2))
}

/// An object that is the same in all drawings: nothing of it is cut.
fn uncut(mut scene: Scene, spawn: impl Fn(&mut EntityWorldMut) + Send + Sync + 'static) -> Scene {
    scene.props.push(Arc::new(spawn));
    scene
}

fn unlit(entity: &mut EntityWorldMut, color: Color) -> MeshMaterial3d<StandardMaterial> {
    MeshMaterial3d(add(
        entity,
        StandardMaterial {
            base_color: color,
            unlit: true,
            ..default()
        },
    ))
}

#[test]
fn colors_of_vertices_are_reflected_also_where_they_are_cut() {
    let mut mesh = Mesh::from(Cuboid::from_length(0.9));
    let Some(VertexAttributeValues::Float32x3(corners)) = mesh.attribute(Mesh::ATTRIBUTE_POSITION)
    else {
        panic!("a box has positions");
    };
    let colors: Vec<[f32; 4]> = corners
        .iter()
        .map(|[x, y, z]| [x + 0.5, y + 0.5, z + 0.5, 1.0])
        .collect();
    mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, colors);
    let scene = wall("vertex-colors")
        .object(mesh.clone(), Color::WHITE, turned(-0.8, 0.0, 1.0))
        .object(mesh, lit(Color::WHITE), turned(0.5, 0.0, 0.1))
        .prop(sun(false));
    assert_reflects(&scene);
}

/// Bumps that are higher in one corner, so that turned or flipped ones would be seen.
fn relief(height: bool) -> Image {
    const EDGE: u32 = 16;
    let bump = |x: f32, y: f32| {
        let wave = (6.0 * PI * x).sin() * (4.0 * PI * y).sin();
        0.15 * wave * (0.3 + x) * (1.2 - y)
    };
    let texel = move |i: u32| {
        let [x, y] = [i % EDGE, i / EDGE].map(|k| k as f32 / EDGE as f32);
        let step = 0.01;
        let slope = vec3(
            bump(x - step, y) - bump(x + step, y),
            bump(x, y - step) - bump(x, y + step),
            4.0 * step,
        );
        let value = if height {
            Vec3::splat(0.5 - 3.0 * bump(x, y))
        } else {
            slope.normalize() * 0.5 + 0.5
        };
        [
            (value.x * 255.0) as u8,
            (value.y * 255.0) as u8,
            (value.z * 255.0) as u8,
            255,
        ]
    };
    let size = Extent3d {
        width: EDGE,
        height: EDGE,
        depth_or_array_layers: 1,
    };
    let mut image = Image::new(
        size,
        TextureDimension::D2,
        (0..EDGE * EDGE).flat_map(texel).collect(),
        TextureFormat::Rgba8Unorm,
        RenderAssetUsages::default(),
    );
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        ..ImageSamplerDescriptor::linear()
    });
    image
}

fn embossed(base: StandardMaterial, parallax: bool) -> Look {
    Look::other(move |entity| {
        let normals = add(entity, relief(false));
        let heights = parallax.then(|| add(entity, relief(true)));
        let material = add(
            entity,
            StandardMaterial {
                normal_map_texture: Some(normals),
                depth_map: heights,
                ..base.clone()
            },
        );
        entity.insert(MeshMaterial3d(material));
    })
}

/// The handedness of tangents is that of the mesh, and no mirror turns it.
#[test]
fn relief_is_lit_from_the_right_side_in_the_reflection() {
    let with_tangents = |mesh: Mesh| {
        mesh.with_generated_tangents()
            .expect("it has positions, normals and texture coordinates")
    };
    let cube = with_tangents(Cuboid::from_length(0.9).into());
    let ball = with_tangents(Sphere::new(0.5).mesh().uv(32, 18));
    let mut studio = Studio::default();
    for parallax in [false, true] {
        let base = StandardMaterial {
            perceptual_roughness: 0.4,
            ..lit(Color::srgb(0.8, 0.7, 0.6))
        };
        let scene = wall(&format!("relief-{parallax}"))
            .object(
                cube.clone(),
                embossed(base.clone(), parallax),
                turned(-0.9, -0.1, 1.0),
            )
            .object(
                ball.clone(),
                embossed(base.clone(), parallax),
                turned(0.6, 0.2, 0.9),
            )
            // Turned inside out: its tangents are left-handed.
            .object(
                ball.clone(),
                embossed(
                    StandardMaterial {
                        cull_mode: None,
                        ..base
                    },
                    parallax,
                ),
                turned(-0.1, -0.6, 0.8).with_scale(vec3(-0.6, 0.6, 0.6)),
            )
            .prop(lamp(vec3(1.5, 1.0, 1.5), false))
            .prop(lamp(vec3(-1.0, 1.5, -0.5), false));
        studio.assert_reflects(&scene);
    }
}

#[test]
fn coats_and_brushed_metal_shine_at_the_reflected_place() {
    let ball = Sphere::new(0.5)
        .mesh()
        .uv(32, 18)
        .with_generated_tangents()
        .expect("it has positions, normals and texture coordinates");
    let coated = StandardMaterial {
        clearcoat: 1.0,
        clearcoat_perceptual_roughness: 0.3,
        ..lit(Color::srgb(0.6, 0.1, 0.1))
    };
    let brushed = StandardMaterial {
        metallic: 1.0,
        perceptual_roughness: 0.4,
        anisotropy_strength: 0.9,
        anisotropy_rotation: 0.6,
        ..lit(Color::srgb(0.8, 0.8, 0.9))
    };
    let scene = wall("coats")
        .object(ball.clone(), coated, turned(-0.9, 0.0, 1.0))
        .object(ball, brushed, turned(0.5, 0.1, 0.9))
        .prop(lamp(vec3(0.0, 1.0, 0.6), false))
        .prop(sun(false));
    assert_reflects(&scene);
}

/// A line covers the same pixels only if it is drawn in the same place: no flip.
#[test]
fn lines_and_points_are_reflected() {
    let corners = |count: usize| -> Vec<[f32; 3]> {
        (0..count)
            .map(|i| {
                let angle = i as f32 * 2.4;
                [0.9 * angle.cos(), 0.7 * angle.sin(), 0.04 * i as f32]
            })
            .collect()
    };
    for (name, topology, color) in [
        ("lines", PrimitiveTopology::LineList, GREEN),
        ("strip", PrimitiveTopology::LineStrip, BLUE),
        ("points", PrimitiveTopology::PointList, GREEN),
    ] {
        let scene = uncut(wall(&format!("topology-{name}")), move |entity| {
            let mesh = Mesh::new(topology, RenderAssetUsages::default())
                .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners(40));
            let mesh = Mesh3d(add(entity, mesh));
            let material = unlit(entity, color);
            entity.insert((mesh, material, at(0.0, 0.0, 0.8)));
        });
        let mut studio = Studio::default();
        let picture = studio.assert_reflects_in_place(&scene);
        let plain = studio.without_mirrors(&scene);
        let (both, one) = (picture.count(is(color)), plain.count(is(color)));
        assert!(
            both > one + 10,
            "{name}: {both} pixels where {one} are seen directly"
        );
    }
}

/// Equal meshes with equal materials are drawn by one call for all of them.
#[test]
fn many_equal_objects_are_reflected_each_at_its_place() {
    let crowd = |scene: Scene, color: Color, offset: f32| {
        uncut(scene, move |entity| {
            let mesh = Mesh3d(add(entity, Cuboid::from_length(0.09).into()));
            let material = unlit(entity, color);
            entity.world_scope(|world| {
                for i in 0..150 {
                    let angle = i as f32 * 2.399 + offset;
                    let radius = 0.1 * (i as f32).sqrt();
                    let place = vec3(radius * angle.cos(), radius * angle.sin(), 0.01 * i as f32);
                    let place = Transform::from_translation(place + Vec3::Z * 0.3)
                        .with_rotation(Quat::from_rotation_x(angle));
                    world.spawn((mesh.clone(), material.clone(), place));
                }
            });
        })
    };
    let scene = crowd(crowd(wall("crowd"), GREEN, 0.0), BLUE, 1.2);
    assert_reflects(&scene);
}

/// A post of two joints, bent at the middle.
#[test]
fn a_skinned_mesh_is_reflected_as_it_is_bent() {
    let mut mesh = Cuboid::new(0.25, 1.2, 0.25).mesh().build();
    mesh = mesh.with_duplicated_vertices();
    let Some(VertexAttributeValues::Float32x3(corners)) = mesh.attribute(Mesh::ATTRIBUTE_POSITION)
    else {
        panic!("a box has positions");
    };
    let joints: Vec<[u16; 4]> = corners.iter().map(|_| [0, 1, 0, 0]).collect();
    let weights: Vec<[f32; 4]> = corners
        .iter()
        .map(|[_, y, _]| {
            if *y > 0.0 {
                [0.1, 0.9, 0.0, 0.0]
            } else {
                [1.0, 0.0, 0.0, 0.0]
            }
        })
        .collect();
    mesh.insert_attribute(
        Mesh::ATTRIBUTE_JOINT_INDEX,
        VertexAttributeValues::Uint16x4(joints),
    );
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights);
    let post = |bend: f32| {
        let mesh = mesh.clone();
        uncut(wall(&format!("skinned-{bend}")), move |entity| {
            let mesh = Mesh3d(add(entity, mesh.clone()));
            let material = unlit(entity, GREEN);
            let poses = SkinnedMeshInverseBindposes::from(vec![Mat4::IDENTITY; 2]);
            let inverse_bindposes = add(entity, poses);
            let root = at(-0.5, 0.0, 0.9);
            let joints = entity.world_scope(|world| {
                let upper = root * Transform::from_rotation(Quat::from_rotation_z(bend));
                [root, upper].map(|place| world.spawn(place).id()).to_vec()
            });
            entity.insert((
                mesh,
                material,
                root,
                SkinnedMesh {
                    inverse_bindposes,
                    joints,
                },
            ));
        })
    };
    let mut studio = Studio::default();
    let straight = studio.assert_reflects(&post(0.0));
    let bent = studio.assert_reflects(&post(-0.9));
    let moved = bent.difference(&straight, 8, |_| true);
    assert!(
        moved.is_ok_and(|moved| moved.beyond > 100),
        "it is not bent"
    );
}

#[test]
fn a_morphed_mesh_is_reflected_as_it_is_shaped() {
    let pyramid = |weight: f32| {
        uncut(wall(&format!("morphed-{weight}")), move |entity| {
            let mut mesh = Mesh::from(Cuboid::from_length(0.6));
            let count = mesh.count_vertices();
            let Some(VertexAttributeValues::Float32x3(corners)) =
                mesh.attribute(Mesh::ATTRIBUTE_POSITION)
            else {
                panic!("a box has positions");
            };
            let target: Vec<MorphAttributes> = corners
                .iter()
                .map(|[x, y, z]| MorphAttributes {
                    position: if *y > 0.0 {
                        vec3(-x, 0.3, -z)
                    } else {
                        Vec3::ZERO
                    },
                    ..default()
                })
                .collect();
            assert_eq!(target.len(), count);
            mesh.set_morph_targets(target);
            let mesh = add(entity, mesh);
            let material = unlit(entity, GREEN);
            entity.insert((
                Mesh3d(mesh.clone()),
                material,
                turned(-0.5, 0.0, 0.9),
                MorphWeights::new(vec![weight], Some(mesh)).expect("one weight"),
                MeshMorphWeights::Value {
                    weights: vec![weight],
                },
            ));
        })
    };
    let mut studio = Studio::default();
    let plain = studio.assert_reflects(&pyramid(0.0));
    let shaped = studio.assert_reflects(&pyramid(1.0));
    let moved = shaped.difference(&plain, 8, |_| true);
    assert!(
        moved.is_ok_and(|moved| moved.beyond > 100),
        "it has no other shape"
    );
}

#[test]
fn baked_light_lies_right_on_reflected_things() {
    let mut mesh = Mesh::from(Cuboid::from_length(0.9));
    let Some(VertexAttributeValues::Float32x2(uv)) = mesh.attribute(Mesh::ATTRIBUTE_UV_0).cloned()
    else {
        panic!("a box has texture coordinates");
    };
    mesh.insert_attribute(Mesh::ATTRIBUTE_UV_1, uv);
    let baked = Look::other(|entity| {
        let image = add(entity, four_quarters([255; 4]));
        let material = add(
            entity,
            StandardMaterial {
                lightmap_exposure: 1000.0,
                ..lit(Color::WHITE)
            },
        );
        entity.insert((MeshMaterial3d(material), Lightmap { image, ..default() }));
    });
    let scene = wall("lightmap").object(mesh, baked, turned(-0.7, 0.0, 1.0));
    let picture = assert_reflects(&scene);
    let colored = picture.count(|[r, g, b, _]| r.max(g).max(b) > 60);
    assert!(colored > 1000, "nothing is lit: {colored}");
}

/// From the reflected eye it is farther than from the eye.
#[test]
fn a_things_distance_in_the_mirror_decides_on_its_level_of_detail() {
    let level = |color: Color, range: std::ops::Range<f32>| {
        Look::other(move |entity| {
            let material = unlit(entity, color);
            entity.insert((material, VisibilityRange::abrupt(range.start, range.end)));
        })
    };
    let place = turned(-0.5, 0.0, 1.0);
    let scene = wall("level-of-detail")
        .object(Cuboid::from_length(0.5), level(RED, 0.0..4.0), place)
        .object(Cuboid::from_length(0.5), level(GREEN, 4.0..20.0), place);
    let picture = assert_reflects(&scene);
    assert!(picture.count(is(RED)) > 200 && picture.count(is(GREEN)) > 100);
    let plain = Studio::default().without_mirrors(&scene);
    assert_eq!(plain.count(is(GREEN)), 0, "the eye itself is near");
}

#[test]
fn what_the_camera_is_not_to_see_is_not_reflected() {
    let scene = wall("layers").object(Cuboid::from_length(0.5), YELLOW, turned(-0.5, 0.0, 1.0));
    let mut studio = Studio::default();
    let alone = studio.picture(&scene);
    let other_layer = Look::other(|entity| {
        let material = unlit(entity, RED);
        entity.insert((material, RenderLayers::layer(3)));
    });
    let hidden = Look::other(|entity| {
        let material = unlit(entity, RED);
        entity.insert((material, Visibility::Hidden));
    });
    for (name, look) in [("layer", other_layer), ("hidden", hidden)] {
        let more = scene
            .clone()
            .object(Cuboid::from_length(0.8), look, turned(0.5, 0.0, 1.0));
        studio
            .picture(&more)
            .assert_same(&alone, &format!("unseen-{name}"));
    }
}

/// Every other triangle of a strip winds the other way.
#[test]
fn strips_of_triangles_are_reflected() {
    let scene = uncut(wall("object-strip"), |entity| {
        let count = 14;
        let corners: Vec<[f32; 3]> = (0..count)
            .map(|i| {
                let along = (i / 2) as f32 * 0.2 - 0.6;
                let side = if i % 2 == 0 { 0.2 } else { -0.2 };
                [along, side, 0.2 * (5.0 * along).sin()]
            })
            .collect();
        let mesh = Mesh::new(
            PrimitiveTopology::TriangleStrip,
            RenderAssetUsages::default(),
        )
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners);
        let mesh = Mesh3d(add(entity, mesh));
        let material = unlit(entity, GREEN);
        entity.insert((
            mesh,
            material,
            // Its front is towards the mirror.
            at(-0.2, 0.0, 1.0).with_rotation(Quat::from_rotation_y(PI)),
        ));
    });
    let picture = assert_reflects(&scene);
    let plain = Studio::default().without_mirrors(&scene);
    assert_eq!(plain.count(is(GREEN)), 0, "its back is culled");
    assert!(picture.count(is(GREEN)) > 300);
}
