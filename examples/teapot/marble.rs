//! Dark green marble with white and golden veins, made on the CPU: the same at every run.

use std::{f32::consts::TAU, sync::LazyLock};

use bevy::{
    asset::RenderAssetUsages,
    image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor},
    math::{Vec2, Vec3, ops, vec2, vec3},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};

/// Width and height in texels; a power of two.
const SIZE: u32 = 1024;

/// A texture with all its mip levels.
pub fn marble() -> Image {
    let mut level: Vec<Vec3> = rows_in_parallel(SIZE, |x, y| {
        color(vec2(x as f32 + 0.5, y as f32 + 0.5) / SIZE as f32)
    });
    let (mut size, mut data, mut levels) = (SIZE, Vec::new(), 0);
    loop {
        for texel in &level {
            let srgb = Color::linear_rgb(texel.x, texel.y, texel.z).to_srgba();
            data.extend(srgb.to_u8_array());
        }
        levels += 1;
        if size == 1 {
            break;
        }
        size /= 2;
        let finer = |x: u32, y: u32| level[(y * size * 2 + x) as usize];
        level = (0..size * size)
            .map(|i| (2 * (i % size), 2 * (i / size)))
            .map(|(x, y)| {
                (finer(x, y) + finer(x + 1, y) + finer(x, y + 1) + finer(x + 1, y + 1)) / 4.0
            })
            .collect();
    }
    let mut image = Image::new_uninit(
        Extent3d {
            width: SIZE,
            height: SIZE,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.data = Some(data);
    image.texture_descriptor.mip_level_count = levels;
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::ClampToEdge,
        address_mode_v: ImageAddressMode::ClampToEdge,
        mipmap_filter: ImageFilterMode::Linear,
        anisotropy_clamp: 16,
        ..ImageSamplerDescriptor::linear()
    });
    image
}

/// Linear color at `uv` in 0..1.
fn color(uv: Vec2) -> Vec3 {
    const STONE: Vec3 = vec3(0.075, 0.125, 0.110);
    const CLOUD: Vec3 = vec3(0.022, 0.040, 0.036);
    const VEIN: Vec3 = vec3(0.75, 0.78, 0.74);
    const GOLD: Vec3 = vec3(0.62, 0.42, 0.18);
    let p = uv * 4.0;
    let bent = p + 1.1 * vec2(turbulence(p, 11), turbulence(p + vec2(5.2, 1.3), 12));
    let clouds = 0.5 + 0.5 * turbulence(bent * 0.8, 13);
    let mut stone = STONE.lerp(CLOUD, clouds * clouds);
    // A vein runs where a slow, bent wave passes through zero; it swells and fades on its way.
    for (direction, seed, width, strength, tint) in [
        (vec2(0.85, 0.52), 21, 0.050, 0.85, VEIN),
        (vec2(-0.35, 0.94), 22, 0.032, 0.60, VEIN),
        (vec2(0.30, 0.75), 23, 0.022, 0.70, GOLD),
        (vec2(1.7, -1.1), 24, 0.050, 0.35, VEIN),
    ] {
        let wave = ops::sin(1.5 * bent.dot(direction) + 2.6 * turbulence(bent * 0.6, seed));
        let presence = (0.55 + 0.9 * turbulence(p * 0.9, seed + 10)).clamp(0.0, 1.0);
        let core = ops::exp(-wave.abs() / (width * (0.4 + presence)));
        let halo = 0.22 * ops::exp(-wave.abs() / (width * 5.0));
        stone = stone.lerp(tint, strength * presence * (core + halo).min(1.0));
    }
    stone * (1.0 + 0.05 * turbulence(p * 12.0, 31))
}

/// A sum of octaves of noise, about -1..1.
fn turbulence(p: Vec2, seed: u32) -> f32 {
    let (mut sum, mut amplitude, mut q) = (0.0, 0.5, p);
    for octave in 0..6 {
        sum += amplitude * noise(q, seed * 8 + octave);
        amplitude *= 0.5;
        // A turn between octaves hides the grid.
        q = 2.0 * vec2(0.8 * q.x - 0.6 * q.y, 0.6 * q.x + 0.8 * q.y);
    }
    sum * 1.4
}

/// Gradient noise, about -0.7..0.7, doubled.
fn noise(p: Vec2, seed: u32) -> f32 {
    static GRADIENTS: LazyLock<[Vec2; 64]> = LazyLock::new(|| {
        std::array::from_fn(|direction| {
            let angle = TAU * direction as f32 / 64.0;
            vec2(ops::cos(angle), ops::sin(angle))
        })
    });
    let gradients = &*GRADIENTS;
    let cell = p.floor();
    let f = p - cell;
    let fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let corner = |x: f32, y: f32| {
        let at = cell + vec2(x, y);
        let direction = hash(at.x as i32 as u32, at.y as i32 as u32, seed) % 64;
        gradients[direction as usize].dot(f - vec2(x, y))
    };
    let near = corner(0.0, 0.0).lerp(corner(1.0, 0.0), fade.x);
    let far = corner(0.0, 1.0).lerp(corner(1.0, 1.0), fade.x);
    2.0 * near.lerp(far, fade.y)
}

/// Well mixed bits of three numbers (the finalizer of MurmurHash3).
fn hash(x: u32, y: u32, seed: u32) -> u32 {
    let mut h =
        x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77) ^ seed.wrapping_mul(0xc2b2_ae3d);
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// `size` x `size` values, the rows shared out among the processors.
fn rows_in_parallel(size: u32, value: impl Fn(u32, u32) -> Vec3 + Sync) -> Vec<Vec3> {
    let threads = std::thread::available_parallelism()
        .map_or(1, |n| n.get() as u32)
        .min(size);
    let rows_each = size.div_ceil(threads);
    let mut values = vec![Vec3::ZERO; (size * size) as usize];
    std::thread::scope(|scope| {
        for (band, rows) in values.chunks_mut((rows_each * size) as usize).enumerate() {
            let value = &value;
            let first = band as u32 * rows_each;
            scope.spawn(move || {
                for (i, texel) in rows.iter_mut().enumerate() {
                    *texel = value(i as u32 % size, first + i as u32 / size);
                }
            });
        }
    });
    values
}
