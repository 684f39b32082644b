//! Directional shadows of reflected views: what falls on nothing that is seen is left out.
//!
//! A reflected view has cascades like any camera's, over its whole frustum. Of these the reflection
//! samples only the ones that hold what shows in the mirror, and of each of these only the column
//! of light that leads to it. The cascades' own matrices stay as they are, so a shadow has the
//! same texels as in any picture of the same view.

use bevy::{
    camera::{
        Camera,
        primitives::{CascadesFrusta, Frustum},
    },
    ecs::prelude::*,
    light::{CascadeShadowConfig, Cascades, ShadowFilteringMethod, cascade::Cascade},
    math::primitives::HalfSpace,
};
use glam::{DMat4, DVec2, DVec3, DVec4};

use super::{DepthRange, PlannedView, ReflectedViews};
use crate::{math::BaseProjection, mirror::MirrorShadows};

/// How far beside a point its shadow may be looked up, in texels: the offset along the normal and
/// the widest fixed filter, twice over.
const FILTER_TEXELS: f64 = 8.0;

/// Whether anything at these view depths reads cascade `index`.
///
/// A point reads the first cascade whose far bound it lies before and, from where the next one
/// begins to overlap, that one as well.
pub fn cascade_is_sampled(config: &CascadeShadowConfig, index: usize, seen: DepthRange) -> bool {
    config.bounds.get(index).is_some_and(|&far| {
        seen.near <= far && seen.far >= cascade_near(config, index).unwrap_or(f32::NEG_INFINITY)
    })
}

/// Where a cascade begins; `None` for the first, which holds everything nearer than its end.
fn cascade_near(config: &CascadeShadowConfig, index: usize) -> Option<f32> {
    let before = config.bounds.get(index.checked_sub(1)?)?;
    Some((1.0 - config.overlap_proportion) * before)
}

/// Narrows the frusta by which casters are found for the cascades of reflected views.
pub fn narrow_cascades(
    views: Res<ReflectedViews>,
    cameras: Query<(&Camera, Option<&ShadowFilteringMethod>)>,
    mut lights: Query<(&CascadeShadowConfig, &Cascades, &mut CascadesFrusta)>,
) {
    for planned in &views.planned {
        let Some(view) = planned.entity else {
            continue;
        };
        let Ok((camera, filter)) = cameras.get(view) else {
            continue;
        };
        // How far the temporal filter reaches depends on the size of the light.
        let filter_is_narrow = !matches!(filter, Some(ShadowFilteringMethod::Temporal));
        for (config, cascades, mut frusta) in &mut lights {
            let (Some(cascades), Some(frusta)) =
                (cascades.cascades.get(&view), frusta.frusta.get_mut(&view))
            else {
                continue;
            };
            for (index, (cascade, frustum)) in cascades.iter().zip(frusta).enumerate() {
                if planned.shadows == MirrorShadows::Off
                    || !cascade_is_sampled(config, index, planned.depths)
                {
                    hold_nothing(frustum);
                } else if filter_is_narrow
                    && let Some(seen) = seen_corners(planned, camera, config, index)
                {
                    narrow(frustum, cascade, &seen);
                }
            }
        }
    }
}

/// The corners, in the world, of what one cascade is sampled for.
fn seen_corners(
    planned: &PlannedView,
    camera: &Camera,
    config: &CascadeShadowConfig,
    index: usize,
) -> Option<[DVec3; 8]> {
    let projection = BaseProjection::new(&camera.clip_from_view().as_dmat4())?;
    let (low, high) = planned.ndc_bounds;
    let mut near = planned.depths.near;
    if let Some(begin) = cascade_near(config, index) {
        near = near.max(begin);
    }
    if !projection.is_orthographic {
        near = near.max(0.0);
    }
    let far = planned.depths.far.min(*config.bounds.get(index)?);
    let world_from_view = planned.plan.world_from_view;
    let mut corners = [DVec3::ZERO; 8];
    let places = [
        DVec2::new(low.x, low.y),
        DVec2::new(high.x, low.y),
        DVec2::new(low.x, high.y),
        DVec2::new(high.x, high.y),
    ];
    for (corner, (place, depth)) in corners.iter_mut().zip(
        places
            .iter()
            .flat_map(|place| [(*place, near), (*place, far)]),
    ) {
        let view = at_depth(&projection.view_from_clip, place, f64::from(depth));
        *corner = world_from_view.transform_point3(view);
    }
    corners.iter().all(|c| c.is_finite()).then_some(corners)
}

/// The point at view depth `-z = depth` that shows at `ndc`.
fn at_depth(view_from_clip: &DMat4, ndc: DVec2, depth: f64) -> DVec3 {
    let point = |z: f64| view_from_clip.project_point3(ndc.extend(z));
    let (near, beyond) = (point(1.0), point(0.5));
    near + (beyond - near) * ((-depth - near.z) / (beyond.z - near.z))
}

/// Leaves the frustum what lies between the light and the corners.
fn narrow(frustum: &mut Frustum, cascade: &Cascade, corners: &[DVec3; 8]) {
    let world_from_cascade = cascade.world_from_cascade.as_dmat4();
    let guard = FILTER_TEXELS * f64::from(cascade.texel_size);
    let sides = [world_from_cascade.x_axis, world_from_cascade.y_axis]
        .map(DVec4::truncate)
        .into_iter()
        .flat_map(|axis| [axis, -axis]);
    for (half_space, inwards) in frustum.half_spaces.iter_mut().zip(sides) {
        let least = corners
            .iter()
            .map(|corner| inwards.dot(*corner))
            .fold(f64::INFINITY, f64::min);
        let d = (guard - least).min(f64::from(half_space.d()));
        *half_space = HalfSpace::new(inwards.extend(d).as_vec4());
    }
}

/// A half-space beyond every object.
fn hold_nothing(frustum: &mut Frustum) {
    const BEYOND: f32 = -1e30;
    let side = &mut frustum.half_spaces[0];
    *side = HalfSpace::new(side.normal().extend(BEYOND));
}
