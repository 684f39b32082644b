//! The plan for one mirror and one camera: whether to draw the reflection, and how.

use glam::{DAffine3, DMat3, DMat4, DVec2, DVec3, DVec4};

use super::{
    noise::{MAX_MARGIN, clip_plane_error, margin, noise},
    oblique::{
        fitted_depth_row, oblique_k, plane_in_reflected_view, plane_reach, raster_guard,
        with_depth_row,
    },
    plane::Plane,
    polygon::{Opening, VisiblePolygon, clip_polygon_within},
    projection::BaseProjection,
    reflection::reflected_world_from_view,
};

/// A mirror seen thinner than this, in pixels, is not drawn.
const MIN_WIDTH_PX: f64 = 0.5;
/// An object may reach this far behind the plane, in pixels, before it must be cut.
const GHOST_PX: f64 = 0.25;
/// The eye must be higher over the plane than this many `f32` steps of the coordinates.
const MIN_EYE_STEPS: f64 = 4.0;

/// What the plan depends on. Widen `f32` values; all are in world space unless they say otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewInput {
    /// The camera, which may be scaled.
    pub world_from_view: DAffine3,
    /// Its projection with reversed depth.
    pub clip_from_view: DMat4,
    /// Its viewport in physical pixels.
    pub viewport_size: DVec2,
    /// The mirror's plane.
    pub plane: Plane,
    /// The corners of the mirror in order around it; `None` if its bounds are not known.
    pub corners: Option<[DVec3; 4]>,
    /// By how many pixels the projection may be shifted later: half a pixel for temporal
    /// anti-aliasing, else 0.
    pub jitter_px: f64,
}

/// Why a mirror is not drawn for a camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Skip {
    /// The camera, its projection or the mirror is not finite or cannot be inverted.
    DegenerateView,
    /// The eye is behind the plane, or in it as far as `f32` can tell. An orthographic camera, which
    /// has no eye, looks along the plane or at its back.
    EyeBehind,
    /// No part of the mirror is in the view.
    OutOfView,
    /// The visible part is thinner than half a pixel.
    TooThin,
    /// The plane is lost in the rounding of the vertices, for instance far from the origin.
    BelowPrecision,
}

/// How to draw the reflection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReflectedViewPlan {
    /// The reflected camera. It changes handedness.
    pub world_from_view: DAffine3,
    /// The plane in the reflected view's space; positive in front, in world units.
    pub plane_view: DVec4,
    /// What the camera sees of the mirror.
    pub polygon: VisiblePolygon,
    /// The projection with its near plane on the mirror, to be rounded to `f32`.
    pub clip_from_view_oblique: DMat4,
    /// The factor of the oblique depth row, margin included.
    pub k: f64,
    /// The share of depth left free at the far side.
    pub margin: f64,
    /// The noise factor, see [`noise`].
    pub noise: f64,
    /// How high the eye is over the plane, in world units.
    pub eye_height: f64,
    /// The smallest clip `w` of the visible part: its least view depth for a perspective.
    pub w_min: f64,
    /// The size of a pixel in world units where clip `w` is 1.
    pub pixel_size: f64,
}

impl ReflectedViewPlan {
    /// How far an object may reach behind the plane before it must be cut, in world units.
    ///
    /// `w` is the clip `w` of the object's nearest point: the view depth for a perspective, 1 for
    /// an orthographic camera. A quarter of a pixel there, and never less than what the cut
    /// itself could resolve. So what stands on a floor mirror does not need a cut.
    pub fn ghost_tolerance(&self, w: f64) -> f64 {
        let at =
            |w: f64| (GHOST_PX * self.pixel_size * w).max(clip_plane_error(self.noise, self.k, w));
        // Behind the plane by d, an object shows only at depths from (1 - d/h) w_min on, so a
        // large object that begins beside the eye need not be held to the depth where it begins.
        let beyond_eye = at(self.w_min).min(0.5 * self.eye_height.max(0.0));
        at(w.max(0.0)).max(beyond_eye)
    }
}

/// Decides whether a camera sees a mirror, and plans the reflected view.
///
/// The oblique projection is fitted to the visible part of the mirror, less a margin for rounding.
/// It is needed only if something straddles the plane; otherwise the camera's own projection has
/// the better depth.
pub fn plan_reflected_view(input: &ViewInput) -> Result<ReflectedViewPlan, Skip> {
    plan_reflected_view_within(input, &Opening::SCREEN)
}

/// [`plan_reflected_view`] of a mirror that is looked at through an opening.
///
/// For a mirror in a mirror `input.world_from_view` is the reflected view of the outer one, and the
/// opening what is seen of that.
pub fn plan_reflected_view_within(
    input: &ViewInput,
    opening: &Opening,
) -> Result<ReflectedViewPlan, Skip> {
    let ViewInput {
        world_from_view,
        plane,
        viewport_size,
        ..
    } = *input;
    let projection = checked_projection(input)?;
    let view_from_world = checked_inverse(&world_from_view)?;

    let eye = world_from_view.translation;
    let eye_height = plane.signed_distance(eye);
    let plane_view = plane_in_reflected_view(&plane, &world_from_view);
    if !is_seen_from_front(&projection, eye, &plane, plane_view) {
        return Err(Skip::EyeBehind);
    }

    let polygon = match &input.corners {
        None => VisiblePolygon::all_within(opening),
        Some(corners) => clip_polygon_within(
            &corners.map(|corner| {
                // Relative to the eye, which may be far from the origin.
                projection.clip_from_view * (view_from_world * (corner - eye)).extend(1.0)
            }),
            (opening.low, opening.high),
            opening
                .plane_view
                .map(|plane_view| projection.clip_covector(plane_view)),
        ),
    };
    if polygon.is_empty() {
        return Err(Skip::OutOfView);
    }
    let reach = plane_reach(&projection, plane_view, polygon.ndc());
    let k_whole = oblique_k(&reach, 0.0).ok_or(Skip::OutOfView)?;
    let width = polygon.min_width_px(viewport_size);
    if width.is_nan() || width < MIN_WIDTH_PX {
        return Err(Skip::TooThin);
    }

    // k h = w_min: of a mirror without bounds, the nearest point of the plane in view.
    let w_min = polygon.w_min().unwrap_or(if projection.is_orthographic {
        projection.clip_from_view.w_axis.w
    } else {
        k_whole * eye_height
    });
    let reach_of_world = eye.length() + plane.origin.length();
    let noise = noise(&projection, polygon.ndc(), reach_of_world, w_min, k_whole);
    let margin = margin(noise);
    if margin.is_nan() || margin > MAX_MARGIN {
        return Err(Skip::BelowPrecision);
    }

    let plane_clip = projection.clip_covector(plane_view);
    let reach = reach.widened(raster_guard(plane_clip, viewport_size, input.jitter_px));
    let k = oblique_k(&reach, margin).ok_or(Skip::DegenerateView)?;
    let row = fitted_depth_row(&projection.clip_from_view, plane_view, k, &reach, margin);
    let plan = ReflectedViewPlan {
        world_from_view: reflected_world_from_view(&plane, &world_from_view),
        plane_view,
        polygon,
        clip_from_view_oblique: with_depth_row(&projection.clip_from_view, row),
        k,
        margin,
        noise,
        eye_height,
        w_min,
        pixel_size: pixel_size(&projection, &view_from_world, viewport_size),
    };
    is_usable(&plan).then_some(plan).ok_or(Skip::DegenerateView)
}

fn checked_projection(input: &ViewInput) -> Result<BaseProjection, Skip> {
    let finite = input.plane.is_finite()
        && input.plane.normal.is_normalized()
        && input.viewport_size.is_finite()
        && input.viewport_size.min_element() > 0.0
        && input.jitter_px.is_finite()
        && input.jitter_px >= 0.0
        && input.corners.iter().flatten().all(|p| p.is_finite());
    if !finite {
        return Err(Skip::DegenerateView);
    }
    BaseProjection::new(&input.clip_from_view).ok_or(Skip::DegenerateView)
}

/// The inverse of the camera's axes.
fn checked_inverse(world_from_view: &DAffine3) -> Result<DMat3, Skip> {
    if !world_from_view.is_finite() {
        return Err(Skip::DegenerateView);
    }
    world_from_view
        .matrix3
        .try_inverse()
        .filter(DMat3::is_finite)
        .ok_or(Skip::DegenerateView)
}

/// A perspective must have its eye in front, an orthographic camera must look at the front.
fn is_seen_from_front(
    projection: &BaseProjection,
    eye: DVec3,
    plane: &Plane,
    plane_view: DVec4,
) -> bool {
    if projection.is_orthographic {
        -plane_view.z > 0.0
    } else {
        let largest = eye
            .abs()
            .max_element()
            .max(plane.origin.abs().max_element());
        plane.signed_distance(eye) > MIN_EYE_STEPS * f64::from(f32::EPSILON) * largest
    }
}

/// The size of a pixel in world units where clip `w` is 1, along the finer of the two axes.
fn pixel_size(projection: &BaseProjection, view_from_world: &DMat3, viewport_size: DVec2) -> f64 {
    let w = projection.clip_from_view.row(3).truncate();
    // Across the line of sight: an off-center projection leans.
    let across = |row: DVec3| row - w * (row.dot(w) / w.length_squared().max(f64::MIN_POSITIVE));
    let per_unit = |row: usize| {
        let view = across(projection.clip_from_view.row(row).truncate());
        (view_from_world.transpose() * view).length()
    };
    let px_per_unit = DVec2::new(per_unit(0), per_unit(1)) * viewport_size * 0.5;
    1.0 / px_per_unit.max_element()
}

/// Whether everything is finite, also after rounding to `f32`.
fn is_usable(plan: &ReflectedViewPlan) -> bool {
    plan.clip_from_view_oblique.as_mat4().is_finite()
        && plan.world_from_view.as_affine3a().is_finite()
        && plan.plane_view.is_finite()
        && [plan.k, plan.w_min, plan.pixel_size, plan.noise]
            .iter()
            .all(|value| value.is_finite() && *value > 0.0)
}
