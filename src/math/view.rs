//! The plan for one mirror and one camera: whether to draw the reflection, and how.

use glam::{DAffine3, DMat3, DMat4, DVec2, DVec3, DVec4};

use super::{
    noise::{MAX_MARGIN, clip_plane_error, margin, noise},
    oblique::{
        fitted_depth_row, oblique_k, plane_in_reflected_view, plane_reach, raster_guard,
        with_depth_row,
    },
    plane::Plane,
    polygon::{Opening, VisiblePolygon, clip_polygon_within, is_beyond},
    projection::{BaseProjection, is_orthographic},
    reflection::reflected_world_from_view,
};

/// An object may reach this far behind the plane, in pixels, before it must be cut.
const GHOST_PX: f64 = 0.25;
/// An object that was cut in the last frame is cut until it reaches less than this share of that.
const STILL_CUT: f64 = 0.5;

/// What it takes to draw a mirror.
///
/// A pose rounded to `f32` trembles, and what is computed from it trembles with it. So a mirror
/// that was drawn stays until it is well beyond the limits at which it came. Of 25,023 slow sweeps
/// through such a limit 591 flicker without that, and 29 do with it, all of them where one step of
/// `f32` moves the picture by a sixteenth of a pixel or more.
struct Limits {
    /// It must be at least so wide, in pixels.
    width_px: f64,
    /// The eye must be higher over the plane than so many `f32` steps of the coordinates, and an
    /// orthographic camera look down at it at more than so many steps of 1.
    steps: f64,
    /// Noise may take so large a share of depth.
    margin: f64,
}

impl Limits {
    const NEW: Self = Self {
        width_px: 0.5,
        steps: 4.0,
        margin: MAX_MARGIN,
    };
    const KEPT: Self = Self {
        width_px: 0.25,
        steps: 2.0,
        margin: 1.5 * MAX_MARGIN,
    };
}

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
    /// Whether the mirror was drawn for this camera in the last frame. It then takes more to leave
    /// it out, so that it does not flicker on the way.
    pub was_drawn: bool,
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
    /// The visible part is thinner than half a pixel; of a mirror that was drawn, than a quarter.
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
    /// The smallest clip `w` of the visible part, of a mirror without bounds that of its plane in
    /// the view: the least view depth for a perspective.
    pub w_min: f64,
    /// How large may be what shows no larger than a quarter of a pixel where clip `w` is 1, in
    /// world units.
    pub ghost_size: f64,
}

impl ReflectedViewPlan {
    /// How far an object may reach behind the plane before it must be cut, in world units.
    ///
    /// `w` is the clip `w` of the object's nearest point: the view depth for a perspective, 1 for
    /// an orthographic camera. Nothing of that size shows larger than a quarter of a pixel there,
    /// anywhere in the visible part; but never less than what the cut itself could resolve. So
    /// what stands on a floor mirror does not need a cut.
    ///
    /// `was_cut` says whether the view was cut in the last frame: then half of that, so that
    /// what trembles about the limit is not cut in every other frame.
    pub fn ghost_tolerance(&self, w: f64, was_cut: bool) -> f64 {
        let at = |w: f64| (self.ghost_size * w).max(clip_plane_error(self.noise, self.k, w));
        // Behind the plane by d, an object shows only at depths from (1 - d/h) w_min on, so a
        // large object that begins beside the eye need not be held to the depth where it begins:
        // d = at((1 - d/h) w_min), solved for d.
        let (at_mirror, height) = (at(self.w_min), self.eye_height.max(0.0));
        let beyond_eye = at_mirror * height / (at_mirror + height);
        let tolerance = at(w.max(0.0)).max(beyond_eye);
        if was_cut {
            STILL_CUT * tolerance
        } else {
            tolerance
        }
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
    let limits = if input.was_drawn {
        Limits::KEPT
    } else {
        Limits::NEW
    };
    if !is_sound(input) {
        return Err(Skip::DegenerateView);
    }
    // First what is cheap to tell: of many mirrors most are not seen.
    if !is_seen_from_front(input, limits.steps) {
        return Err(Skip::EyeBehind);
    }
    let view_from_world = checked_inverse(&world_from_view)?;
    let eye = world_from_view.translation;
    let bounds = (opening.low, opening.high);
    // Relative to the eye, which may be far from the origin.
    let to_clip = |p: DVec3| input.clip_from_view * (view_from_world * (p - eye)).extend(1.0);
    let corners_clip = input
        .corners
        .map(|[a, b, c, d]| [to_clip(a), to_clip(b), to_clip(c), to_clip(d)]);
    if corners_clip.is_some_and(|corners| is_beyond(&corners, bounds)) {
        return Err(Skip::OutOfView);
    }
    let projection = BaseProjection::new(&input.clip_from_view).ok_or(Skip::DegenerateView)?;

    let eye_height = plane.signed_distance(eye);
    let plane_view = plane_in_reflected_view(&plane, &world_from_view);

    let polygon = match &corners_clip {
        None => VisiblePolygon::all_within(opening),
        Some(corners) => {
            let before = opening
                .plane_view
                .map(|plane| projection.clip_covector(plane));
            clip_polygon_within(corners, bounds, before)
        }
    };
    if polygon.is_empty() {
        return Err(Skip::OutOfView);
    }
    let reach = plane_reach(&projection, plane_view, polygon.ndc());
    let k_whole = oblique_k(&reach, 0.0).ok_or(Skip::OutOfView)?;
    let width = polygon.min_width_px(viewport_size);
    if width.is_nan() || width < limits.width_px {
        return Err(Skip::TooThin);
    }

    let plane_clip = projection.clip_covector(plane_view);
    let w_min = polygon
        .w_min()
        .unwrap_or_else(|| nearest_w(&projection, plane_clip, reach.f_max));
    let reflected = reflected_world_from_view(&plane, &world_from_view);
    let around_eye = projection.around_eye(&world_from_view.matrix3, &view_from_world);
    let eye_reach = reflected.translation.length();
    let noise = noise(&around_eye, polygon.ndc(), eye_reach, w_min, k_whole);
    let margin = margin(noise);
    if margin.is_nan() || margin > limits.margin {
        return Err(Skip::BelowPrecision);
    }

    let reach = reach.widened(raster_guard(plane_clip, viewport_size, input.jitter_px));
    let k = oblique_k(&reach, margin).ok_or(Skip::DegenerateView)?;
    let row = fitted_depth_row(&projection.clip_from_view, plane_view, k, &reach, margin);
    let plan = ReflectedViewPlan {
        world_from_view: reflected,
        plane_view,
        polygon,
        clip_from_view_oblique: with_depth_row(&projection.clip_from_view, row),
        k,
        margin,
        noise,
        eye_height,
        w_min,
        ghost_size: ghost_size(&around_eye, polygon.ndc(), viewport_size),
    };
    is_usable(&plan).then_some(plan).ok_or(Skip::DegenerateView)
}

/// Whether the numbers make sense, each by itself.
fn is_sound(input: &ViewInput) -> bool {
    input.plane.is_finite()
        && input.plane.normal.is_normalized()
        && input.world_from_view.is_finite()
        && input.clip_from_view.is_finite()
        && input.viewport_size.is_finite()
        && input.viewport_size.min_element() > 0.0
        && input.jitter_px.is_finite()
        && input.jitter_px >= 0.0
        && input
            .corners
            .is_none_or(|corners| corners.iter().all(|p| p.is_finite()))
}

/// The inverse of the camera's axes.
fn checked_inverse(world_from_view: &DAffine3) -> Result<DMat3, Skip> {
    world_from_view
        .matrix3
        .try_inverse()
        .filter(DMat3::is_finite)
        .ok_or(Skip::DegenerateView)
}

/// A perspective must have its eye in front, an orthographic camera must look at the front.
fn is_seen_from_front(input: &ViewInput, steps: f64) -> bool {
    let ViewInput {
        world_from_view,
        plane,
        ..
    } = input;
    let step = f64::from(f32::EPSILON);
    if is_orthographic(&input.clip_from_view) {
        let backward = world_from_view.matrix3.z_axis;
        plane.normal.dot(backward) > steps * step * backward.length()
    } else {
        let eye = world_from_view.translation;
        let largest = eye
            .abs()
            .max_element()
            .max(plane.origin.abs().max_element());
        plane.signed_distance(eye) > steps * step * largest
    }
}

/// The least clip `w` of a plane without bounds in the view, given its greatest `(C.p)/w` at
/// depth 0, `f_max`.
///
/// `(C.p)/w = C^x x + C^y y + C^z z + C^w` is 0 on the plane, which thus has its greatest depth
/// `z = f_max / -C^z` in a corner of the screen, unless the near plane, `z = 1`, cuts it before.
/// `1/w` is the last row of the inverse projection times `(x, y, z, 1)`: it grows with `z`, and in
/// every common projection with nothing else. In others this is a lower bound.
fn nearest_w(projection: &BaseProjection, plane_clip: DVec4, f_max: f64) -> f64 {
    let depth = (f_max / -plane_clip.z).min(1.0);
    let per_w = projection.view_from_clip.row(3);
    1.0 / (per_w.x.abs() + per_w.y.abs() + per_w.z * depth + per_w.w)
}

/// How large may be what shows no larger than [`GHOST_PX`] where clip `w` is 1, in any direction.
///
/// With the rows `x`, `y`, `w` of the projection around the eye, two points that are `d` apart,
/// the one at `ndc` and the other at clip `w`, are `d.(x - ndc w) / w` apart on the screen. The
/// second term is depth, which moves a point the more the farther it is from the center. The length
/// is convex in `ndc`, so it is greatest at a vertex; and `w` of the two points differs by at most
/// `d.w`, which the last term is for.
fn ghost_size(
    around_eye: &BaseProjection,
    ndc: impl Iterator<Item = DVec2>,
    viewport_size: DVec2,
) -> f64 {
    let [x, y, w] = [0, 1, 3].map(|row| around_eye.clip_from_view.row(row).truncate());
    let pixels = viewport_size * 0.5;
    let px_per_unit = ndc
        .map(|p| largest_image((x - w * p.x) * pixels.x, (y - w * p.y) * pixels.y))
        .fold(0.0, f64::max);
    GHOST_PX / (px_per_unit + GHOST_PX * w.length())
}

/// The greatest length of `(x.d, y.d)` over the unit vectors `d`.
fn largest_image(x: DVec3, y: DVec3) -> f64 {
    let (a, b) = (x.length_squared(), y.length_squared());
    (0.5 * (a + b) + (0.5 * (a - b)).hypot(x.dot(y))).sqrt()
}

/// Whether everything is finite, also after rounding to `f32`.
fn is_usable(plan: &ReflectedViewPlan) -> bool {
    plan.clip_from_view_oblique.as_mat4().is_finite()
        && plan.world_from_view.as_affine3a().is_finite()
        && plan.plane_view.is_finite()
        && [plan.k, plan.w_min, plan.ghost_size, plan.noise]
            .iter()
            .all(|value| value.is_finite() && *value > 0.0)
}
