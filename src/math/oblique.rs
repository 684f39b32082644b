//! The oblique near plane: a projection whose near plane is the mirror.
//!
//! Lengyel ("Oblique View Frustum Depth Projection and Clipping", Journal of Game Development
//! 1(2), 2005) replaces the depth row of a projection so that its near plane becomes any plane C.
//! Here for reversed depth, for every kind of projection, and with the one free factor fitted to
//! the part of the screen that the mirror covers.
//!
//! With rows `r1`, `r2`, `r4` of the base matrix B untouched, the near face `z = w` is the
//! covector `r4 - r3`, which must be a positive multiple of C:
//!
//! ```text
//! r3 = r4 - k C,  k > 0        depth = z/w = 1 - k (C.p)/w
//! near:  C.p >= 0              far:  (C.p)/w <= 1/k
//! ```
//!
//! Only depth changes; position on the screen, interpolation and perspective do not. The far side
//! moves too, so `k` must be small enough that it cuts nothing visible and large enough that the
//! depth buffer resolves what is there: along a ray, depth differs by `k h / w^2` per unit, with
//! the eye at height `h` over the plane. The largest `k` is 1 over the greatest `(C.p)/w` at the
//! far end of the rays. In clip space C is `C^ = C B^-1`, the far end is depth 0, and so
//! `(C.p)/w = C^x x + C^y y + C^w`, greatest at a vertex of the visible polygon. Fitted to that
//! polygon, `k h` is the depth at which the mirror comes into view: the effective near distance.

use glam::{DAffine3, DMat4, DVec2, DVec4};

use super::{plane::Plane, projection::BaseProjection};

/// The rasterizer snaps positions to a grid at least this fine, in pixels.
const SNAP_PX: f64 = 1.0 / 128.0;

/// The mirror's plane in the view space of the reflected camera: `C = (-(W3^T n), -h)`.
///
/// `world_from_view` is the camera itself, not its reflection. `C.p` is the signed distance of
/// the real point, in world units, even if the camera is scaled or sheared; hence it is not of
/// unit length then. The reflection negates the signed distance: `(n, d) R W = -(n, d) W`.
pub fn plane_in_reflected_view(plane: &Plane, world_from_view: &DAffine3) -> DVec4 {
    let lateral = world_from_view.matrix3.transpose() * plane.normal;
    (-lateral).extend(-plane.signed_distance(world_from_view.translation))
}

/// The plane `plane_view` of view space in clip space, `C B^-1`.
///
/// `(C.p)/w` is its dot product with `(x, y, z, 1)` in base device coordinates.
/// `None` if the projection cannot be inverted or anything is not finite.
pub fn plane_in_clip(plane_view: DVec4, clip_from_view: &DMat4) -> Option<DVec4> {
    let plane_clip = BaseProjection::new(clip_from_view)?.clip_covector(plane_view);
    plane_clip.is_finite().then_some(plane_clip)
}

/// How far a region of the screen reaches in front of a plane: `(C.p)/w` at depth 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// The greatest value. Not positive: no ray of the region meets the plane from its front.
    pub f_max: f64,
    /// The greatest value without the share of C's `z`, where `w` is the view depth. Facing the
    /// plane it is tiny and known exactly, while its sum with `-C.z` has lost it.
    pub lateral: Option<f64>,
}

impl Reach {
    /// The reach of a slightly larger region, see [`raster_guard`].
    pub fn widened(self, guard: f64) -> Self {
        Self {
            f_max: self.f_max + guard,
            lateral: self.lateral.map(|lateral| lateral + guard),
        }
    }
}

/// The reach of the convex region with vertices `ndc` in front of `plane_view`.
///
/// Minus infinity if there are no vertices.
pub fn plane_reach(
    projection: &BaseProjection,
    plane_view: DVec4,
    ndc: impl Iterator<Item = DVec2> + Clone,
) -> Reach {
    let plane_clip = projection.clip_covector(plane_view);
    let greatest = |c: DVec4| {
        let at = |p: DVec2| c.x * p.x + c.y * p.y + c.w;
        ndc.clone().map(at).fold(f64::NEG_INFINITY, f64::max)
    };
    if projection.depth_is_w {
        let lateral = greatest(projection.clip_covector(DVec4 {
            z: 0.0,
            ..plane_view
        }));
        Reach {
            f_max: lateral - plane_view.z,
            lateral: Some(lateral),
        }
    } else {
        Reach {
            f_max: greatest(plane_clip),
            lateral: None,
        }
    }
}

/// By how much [`Reach`] grows when the region does by the rasterizer's snapping and, for a
/// jittered camera, by `jitter_px` pixels to each side.
pub fn raster_guard(plane_clip: DVec4, viewport_size: DVec2, jitter_px: f64) -> f64 {
    let per_pixel = plane_clip.truncate().truncate().abs() * 2.0 / viewport_size;
    (per_pixel.x + per_pixel.y) * (SNAP_PX + jitter_px)
}

/// The largest factor `k` that cuts nothing of the region at the far side, less `margin`.
///
/// `None` if the region sees nothing in front of the plane.
pub fn oblique_k(reach: &Reach, margin: f64) -> Option<f64> {
    let k = (1.0 - margin) / reach.f_max;
    (k.is_finite() && k > 0.0).then_some(k)
}

/// The depth row with the near plane at `plane_view`: `r4 - k C`.
pub fn oblique_row(clip_from_view: &DMat4, plane_view: DVec4, k: f64) -> DVec4 {
    clip_from_view.row(3) - plane_view * k
}

/// The depth row for `k` of [`oblique_k`] with the same `reach` and `margin`, without
/// cancellation.
///
/// For a perspective, facing the mirror, `-1 - k C.z` is the small difference of two numbers near
/// 1. It equals `-(k lateral) - margin`, which is exact.
pub fn fitted_depth_row(
    clip_from_view: &DMat4,
    plane_view: DVec4,
    k: f64,
    reach: &Reach,
    margin: f64,
) -> DVec4 {
    let mut row = oblique_row(clip_from_view, plane_view, k);
    if let Some(lateral) = reach.lateral {
        row.z = -(k * lateral) - margin;
    }
    row
}

/// The projection with another depth row.
pub fn with_depth_row(clip_from_view: &DMat4, row: DVec4) -> DMat4 {
    let mut changed = *clip_from_view;
    changed.x_axis.z = row.x;
    changed.y_axis.z = row.y;
    changed.z_axis.z = row.z;
    changed.w_axis.z = row.w;
    changed
}

/// The projection with its near plane at `plane_view`, of which the positive side is kept.
///
/// See the head of this file for `k`. Round the result to `f32` as the last step.
pub fn with_oblique_near_plane(clip_from_view: &DMat4, plane_view: DVec4, k: f64) -> DMat4 {
    with_depth_row(clip_from_view, oblique_row(clip_from_view, plane_view, k))
}
