//! Arithmetic in linear light, in which the GPU blends, on colors and pictures of the screen.

use bevy::prelude::*;

use super::picture::Picture;

/// The light of a pixel.
pub fn light(pixel: [u8; 4]) -> Vec3 {
    let [r, g, b, _] = pixel;
    Color::srgb_u8(r, g, b).to_linear().to_vec3()
}

/// The pixel of this light.
pub fn pixel(light: Vec3) -> [u8; 4] {
    let light = light.clamp(Vec3::ZERO, Vec3::ONE);
    Color::linear_rgb(light.x, light.y, light.z)
        .to_srgba()
        .to_u8_array()
}

/// What the screen shows where `front` covers a share of `back`.
pub fn over(front: Color, alpha: f32, back: Color) -> Color {
    let [front, back] = [front, back].map(|color| color.to_linear().to_vec3());
    let mixed = back.lerp(front, alpha);
    Color::linear_rgb(mixed.x, mixed.y, mixed.z)
}

/// Made of the light of several pictures of one size, pixel by pixel.
pub fn combined<const N: usize>(
    pictures: [&Picture; N],
    light_of: impl Fn([Vec3; N]) -> Vec3,
) -> Picture {
    Picture::from_fn(pictures[0].size(), |x, y| {
        pixel(light_of(pictures.map(|picture| light(picture.at(x, y)))))
    })
}
