//! From device coordinates to pixels.

use glam::{UVec2, Vec2};

/// The lowest pixel within device coordinates and the one after the highest, and two around them
/// for jitter and rounding.
pub fn pixel_bounds((low, high): (Vec2, Vec2), size: UVec2) -> (UVec2, UVec2) {
    const AROUND: Vec2 = Vec2::splat(2.0);
    let pixel = |ndc: Vec2| (ndc * Vec2::new(0.5, -0.5) + 0.5) * size.as_vec2();
    let min = (pixel(Vec2::new(low.x, high.y)) - AROUND).floor();
    let max = (pixel(Vec2::new(high.x, low.y)) + AROUND).ceil();
    // Converting to unsigned numbers cuts off at 0.
    (min.as_uvec2().min(size), max.as_uvec2().min(size))
}
