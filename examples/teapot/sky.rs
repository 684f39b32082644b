//! The backdrop and the light that comes from it: an evening sky with three soft boxes behind the
//! camera, as cube maps made on the CPU.

use std::f32::consts::TAU;

use bevy::{
    asset::RenderAssetUsages,
    light::{EnvironmentMapLight, Skybox},
    math::{ops, vec3},
    prelude::*,
    render::render_resource::{
        Extent3d, TextureDimension, TextureFormat, TextureViewDescriptor, TextureViewDimension,
    },
};

/// What a value of 1 in the maps means, in cd/m^2: white at Bevy's default exposure.
const BRIGHTNESS: f32 = 1000.0;

/// Sizes of the faces for perceptual roughness 0, 1/5, .. 1: Bevy reads level `roughness * 5`.
const SPECULAR_SIZES: [u32; 6] = [256, 128, 64, 32, 16, 8];
const DIFFUSE_SIZE: u32 = 8;

/// The sky for a camera: what it sees, and what lights the scene from all sides.
pub fn sky(images: &mut Assets<Image>) -> (Skybox, EnvironmentMapLight) {
    let roughest = (SPECULAR_SIZES.len() - 1) as f32;
    let specular = SPECULAR_SIZES.iter().enumerate().map(|(level, &size)| {
        let roughness = level as f32 / roughest;
        (size, move |direction| specular(direction, roughness))
    });
    let specular_map = images.add(cube_map(specular.collect()));
    let diffuse_map = images.add(cube_map(vec![(DIFFUSE_SIZE, diffuse)]));
    (
        Skybox {
            image: Some(specular_map.clone()),
            brightness: BRIGHTNESS,
            ..default()
        },
        EnvironmentMapLight {
            diffuse_map,
            specular_map,
            intensity: BRIGHTNESS,
            ..default()
        },
    )
}

/// Linear radiance from a direction (unit length).
fn radiance(direction: Vec3) -> Vec3 {
    const ZENITH: Vec3 = vec3(0.004, 0.010, 0.024);
    const DUSK: Vec3 = vec3(0.020, 0.052, 0.090);
    const GLOW: Vec3 = vec3(0.520, 0.200, 0.060);
    const GROUND: Vec3 = vec3(0.006, 0.007, 0.009);
    let height = direction.y;
    let sky = DUSK.lerp(ZENITH, smoothstep(-0.1, 0.75, height));
    // The last light of the day, low behind the table.
    let level = vec3(direction.x, 0.0, direction.z).normalize_or_zero();
    let sideways = smoothstep(0.35, 1.0, -level.z);
    let glow = GLOW * sideways * ops::exp(-height.max(0.0) / 0.11);
    let sky = (sky + glow).lerp(GROUND, smoothstep(0.0, 0.16, -height));
    // Soft boxes, center and half width: they give the glaze its highlights.
    let boxes = [
        (vec3(-0.75, 0.62, 0.45), 0.26, vec3(3.6, 3.3, 3.0)),
        (vec3(0.85, 0.45, 0.35), 0.18, vec3(1.5, 1.8, 2.3)),
        (vec3(0.1, 0.95, 0.1), 0.22, vec3(1.6, 1.6, 1.6)),
    ];
    boxes.iter().fold(sky, |sum, &(center, width, color)| {
        let center = center.normalize();
        let (right, up) = center.any_orthonormal_pair();
        let ahead = direction.dot(center);
        if ahead <= 0.0 {
            return sum;
        }
        let (x, y) = (direction.dot(right) / ahead, direction.dot(up) / ahead);
        let edge = |t: f32| 1.0 - smoothstep(width * 0.8, width, t.abs());
        sum + color * edge(x) * edge(y)
    })
}

/// Mean over the directions that a surface of this roughness reflects towards its normal (GGX).
fn specular(normal: Vec3, roughness: f32) -> Vec3 {
    if roughness == 0.0 {
        return radiance(normal);
    }
    let alpha_squared = ops::powf(roughness, 4.0);
    let (right, up) = normal.any_orthonormal_pair();
    let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
    for (x, y) in samples() {
        let cos = ((1.0 - y) / (1.0 + (alpha_squared - 1.0) * y)).sqrt();
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let half =
            right * (sin * ops::cos(TAU * x)) + up * (sin * ops::sin(TAU * x)) + normal * cos;
        let direction = half * (2.0 * half.dot(normal)) - normal;
        let weight = direction.dot(normal);
        if weight > 0.0 {
            sum += radiance(direction.normalize()) * weight;
            weights += weight;
        }
    }
    sum / weights
}

/// Cosine-weighted mean over the hemisphere.
fn diffuse(normal: Vec3) -> Vec3 {
    let (right, up) = normal.any_orthonormal_pair();
    let sum: Vec3 = samples()
        .map(|(x, y)| {
            let (sin, cos) = (y.sqrt(), (1.0 - y).sqrt());
            let around = right * ops::cos(TAU * x) + up * ops::sin(TAU * x);
            radiance((around * sin + normal * cos).normalize())
        })
        .sum();
    sum / SAMPLES as f32
}

const SAMPLES: u32 = 64;

/// Hammersley points: evenly spread, and the same at every run.
fn samples() -> impl Iterator<Item = (f32, f32)> {
    (0..SAMPLES).map(|i| {
        let y = i.reverse_bits() as f32 / (u32::MAX as f32 + 1.0);
        ((i as f32 + 0.5) / SAMPLES as f32, y)
    })
}

fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A cube map with one mip level for each size and function of the direction.
fn cube_map<F: Fn(Vec3) -> Vec3>(levels: Vec<(u32, F)>) -> Image {
    let mut data = Vec::new();
    for face in 0..6 {
        for (size, color) in &levels {
            for row in 0..*size {
                for column in 0..*size {
                    let at = |k: u32| 2.0 * (k as f32 + 0.5) / *size as f32 - 1.0;
                    let value = color(face_direction(face, at(column), at(row)));
                    for channel in [value.x, value.y, value.z, 1.0] {
                        data.extend(half_float(channel).to_le_bytes());
                    }
                }
            }
        }
    }
    let size = levels[0].0;
    let mut image = Image::new_uninit(
        Extent3d {
            width: size,
            height: size,
            depth_or_array_layers: 6,
        },
        TextureDimension::D2,
        TextureFormat::Rgba16Float,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.data = Some(data);
    image.texture_descriptor.mip_level_count = levels.len() as u32;
    image.texture_view_descriptor = Some(TextureViewDescriptor {
        dimension: Some(TextureViewDimension::Cube),
        ..default()
    });
    image
}

/// The direction in the world that texel `u` (right), `v` (down) of a face stands for.
fn face_direction(face: u32, u: f32, v: f32) -> Vec3 {
    let left_handed = match face {
        0 => vec3(1.0, -v, -u),
        1 => vec3(-1.0, -v, u),
        2 => vec3(u, 1.0, v),
        3 => vec3(u, -1.0, -v),
        4 => vec3(u, -v, 1.0),
        _ => vec3(-u, -v, -1.0),
    };
    // Cube maps are left-handed, Bevy's world is right-handed.
    (left_handed * vec3(1.0, 1.0, -1.0)).normalize()
}

/// An f32 as the bits of an f16; for numbers from 2^-14 to 65504, smaller ones become 0.
fn half_float(value: f32) -> u16 {
    if value < 6.2e-5 {
        return 0;
    }
    // Other bias of the exponent (127 - 15), 13 bits less of mantissa, rounded.
    ((value.to_bits() + 0x1000 - (112 << 23)) >> 13) as u16
}
