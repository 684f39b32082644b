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
    light::{
        CascadeShadowConfig, Cascades, DirectionalLight, ShadowFilteringMethod, cascade::Cascade,
    },
    math::primitives::HalfSpace,
    reflect::structs::GetField,
};
use glam::{DMat4, DVec2, DVec3, DVec4, Vec2};

use super::{DepthRange, PlannedView, ReflectedViews};
use crate::{
    math::{BaseProjection, bounds_of},
    mirror::MirrorShadows,
};

/// How far beside a point the widest fixed filter looks its shadow up, in texels, and two more.
const FILTER_TEXELS: f64 = 5.0;

/// A cascade that something seen in a reflected view reads.
pub struct SeenCascade {
    pub light: Entity,
    /// Which of the light's cascades.
    pub index: usize,
    /// The lowest and the highest device coordinates of what is read of its map; `None` if that is
    /// not known.
    pub ndc_bounds: Option<(Vec2, Vec2)>,
}

/// Whether anything at these view depths reads cascade `index`.
///
/// A point reads the first cascade whose far bound it lies before and, from where the next one
/// begins to overlap, that one as well.
fn cascade_is_sampled(config: &CascadeShadowConfig, index: usize, seen: DepthRange) -> bool {
    config.bounds.get(index).is_some_and(|&far| {
        seen.near <= far && seen.far >= cascade_near(config, index).unwrap_or(f32::NEG_INFINITY)
    })
}

/// Where a cascade begins; `None` for the first, which holds everything nearer than its end.
fn cascade_near(config: &CascadeShadowConfig, index: usize) -> Option<f32> {
    let before = config.bounds.get(index.checked_sub(1)?)?;
    Some((1.0 - config.overlap_proportion) * before)
}

/// Finds out which cascades of reflected views are read, narrows the frusta by which their casters
/// are found, and takes away those beyond the last that is read.
pub fn narrow_cascades(
    mut views: ResMut<ReflectedViews>,
    cameras: Query<(&Camera, Option<&ShadowFilteringMethod>)>,
    mut lights: Query<(
        Entity,
        &DirectionalLight,
        &CascadeShadowConfig,
        &mut Cascades,
        &mut CascadesFrusta,
    )>,
) {
    let ReflectedViews {
        planned, cascades, ..
    } = &mut *views;
    cascades.clear();
    for planned in planned {
        let first = cascades.len();
        planned.cascades = first..first;
        let Some(view) = planned.entity else {
            continue;
        };
        let Ok((camera, filter)) = cameras.get(view) else {
            continue;
        };
        for (entity, light, config, mut of_light, mut frusta) in &mut lights {
            // Its cascades are those of the time when it still threw shadows.
            if !light.shadow_maps_enabled {
                continue;
            }
            let (Some(of_view), Some(frusta)) = (
                of_light.cascades.get_mut(&view),
                frusta.frusta.get_mut(&view),
            ) else {
                continue;
            };
            let reach = reach_texels(light, filter);
            // What is beyond the last that is read need not exist; but one cascade is expected.
            let mut needed = 1;
            for (index, (cascade, frustum)) in of_view.iter().zip(frusta.iter_mut()).enumerate() {
                if !cascade_is_sampled(config, index, planned.depths) {
                    hold_nothing(frustum);
                    continue;
                }
                needed = index + 1;
                let seen = reach
                    .and_then(|reach| Some((seen_corners(planned, camera, config, index)?, reach)));
                if planned.shadows == MirrorShadows::Off {
                    hold_nothing(frustum);
                } else if let Some((corners, reach)) = &seen {
                    narrow(frustum, cascade, corners, *reach);
                }
                cascades.push(SeenCascade {
                    light: entity,
                    index,
                    ndc_bounds: seen.map(|(corners, reach)| map_bounds(cascade, &corners, reach)),
                });
            }
            of_view.truncate(needed);
            frusta.truncate(needed);
        }
        planned.cascades.end = cascades.len();
    }
}

/// How far beside a point its shadow may be looked up, in texels; `None` if that depends on more
/// than the texels.
fn reach_texels(light: &DirectionalLight, filter: Option<&ShadowFilteringMethod>) -> Option<f64> {
    // How far these reach depends on the size of the light. The field is there only with a feature
    // of the engine, which is not for this crate to turn on.
    let is_soft = light
        .get_field::<Option<f32>>("soft_shadow_size")
        .is_some_and(Option::is_some);
    if is_soft || matches!(filter, Some(ShadowFilteringMethod::Temporal)) {
        return None;
    }
    // The engine moves the point along the normal by so many texels, times the square root of 2.
    let offset = core::f64::consts::SQRT_2 * f64::from(light.shadow_normal_bias.abs());
    Some(FILTER_TEXELS + offset).filter(|reach| reach.is_finite())
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

/// Leaves the frustum what lies between the light and the corners, and as far beside as shadows
/// reach.
fn narrow(frustum: &mut Frustum, cascade: &Cascade, corners: &[DVec3; 8], reach_texels: f64) {
    let world_from_cascade = cascade.world_from_cascade.as_dmat4();
    let guard = reach_texels * f64::from(cascade.texel_size);
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

/// The device coordinates of the corners in the cascade's map, and as far around as shadows reach.
fn map_bounds(cascade: &Cascade, corners: &[DVec3; 8], reach_texels: f64) -> (Vec2, Vec2) {
    let clip_from_world = cascade.clip_from_world.as_dmat4();
    let [x, y] = [0, 1].map(|row| clip_from_world.row(row).truncate().length());
    let guard = DVec2::new(x, y) * reach_texels * f64::from(cascade.texel_size);
    let places = corners.map(|corner| clip_from_world.transform_point3(corner).truncate());
    let (low, high) = bounds_of(places.into_iter());
    ((low - guard).as_vec2(), (high + guard).as_vec2())
}

/// A half-space beyond every object.
fn hold_nothing(frustum: &mut Frustum) {
    const BEYOND: f32 = -1e30;
    let side = &mut frustum.half_spaces[0];
    *side = HalfSpace::new(side.normal().extend(BEYOND));
}
