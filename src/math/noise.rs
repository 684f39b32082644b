//! What single precision costs: bounds for the error of depth, and the margin they ask for.
//!
//! The vertex shader evaluates `clip_from_world * p` in `f32`, from matrices that were inverted,
//! multiplied and rounded in `f32`. The bounds hold for that whole path, in every order of
//! evaluation. They are in units of half an `f32` step at 1, times a noise factor `N`.

use glam::DVec2;

use super::projection::BaseProjection;

/// Half the distance of neighboring `f32` numbers below 2.
const HALF_STEP: f64 = 1.0 / (1 << 24) as f64;
/// Depth that always stays free at the far side.
const MIN_MARGIN: f64 = 1.0 / (1 << 20) as f64;

/// With a larger [`margin`] than this the plane is lost in the rounding of the vertices.
pub const MAX_MARGIN: f64 = 0.25;

/// The noise factor `N` of a region of the screen with vertices `ndc`.
///
/// `reach_of_world` is the distance of the eye plus that of the mirror from the origin of the
/// world; `w_min` the smallest `w` of the mirror in that region; `k` the factor of the oblique
/// depth row.
///
/// Perspective: per unit of `w`, the coordinates that are rounded are as large as
/// `L = max |direction| + reach_of_world / w_min`; both `w` and `k C.p` carry that error, and
/// `N = (1 + k)(1 + 2 L)`. Orthographic: `w` is exact, and the coordinates reach to
/// `L = max |p| + reach_of_world` over both ends of the visible rays, so `N = 2 (1 + 2 k L)`.
pub fn noise(
    projection: &BaseProjection,
    ndc: impl Iterator<Item = DVec2>,
    reach_of_world: f64,
    w_min: f64,
    k: f64,
) -> f64 {
    let ray = ndc
        .map(|p| projection.ray_length(p))
        // Unlike `f64::max`, this keeps what is not a number.
        .fold(0.0, |a, b| if b <= a { a } else { b });
    if projection.is_orthographic {
        2.0 * (1.0 + 2.0 * k * (ray + reach_of_world))
    } else {
        (1.0 + k) * (1.0 + 2.0 * (ray + reach_of_world / w_min))
    }
}

/// The greatest error of the depth of a visible point.
pub fn depth_error(noise: f64) -> f64 {
    HALF_STEP * noise
}

/// How far from the mirror's plane the projection may cut, in world units, where clip `w` is `w`.
pub fn clip_plane_error(noise: f64, k: f64, w: f64) -> f64 {
    2.0 * depth_error(noise) * w / k
}

/// The share of depth to leave free at the far side, so that noise never cuts a distant point.
pub fn margin(noise: f64) -> f64 {
    // Not `f64::max`, which would hide what is not a number.
    let margin = 2.0 * depth_error(noise);
    if margin < MIN_MARGIN {
        MIN_MARGIN
    } else {
        margin
    }
}
