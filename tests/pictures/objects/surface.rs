//! Surfaces of more than one color: vertex colors, relief, coats, baked light.

use std::f32::consts::PI;

use bevy::{
    asset::RenderAssetUsages,
    image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor},
    mesh::VertexAttributeValues,
    pbr::Lightmap,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};

use super::{turned, wall};
use crate::support::{
    props::{add, four_quarters, lamp, lit, sun},
    scene::Look,
    studio::{Studio, assert_reflects},
};

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
