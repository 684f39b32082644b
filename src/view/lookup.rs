//! Where in the shadow maps of a directional light a reflected view looks.

use bevy::{
    camera::{Camera, primitives::Frustum},
    light::{CascadeShadowConfig, DirectionalLight, ShadowFilteringMethod, cascade::Cascade},
    math::primitives::HalfSpace,
    reflect::structs::GetField,
};
use glam::{DMat4, DVec2, DVec3, DVec4, Vec2};

use super::{DepthRange, PlannedView, bounds::WorldBox, cascade::cascade_near};
use crate::math::BaseProjection;

/// How far beside a point the widest fixed filter looks its shadow up, in texels, and two more.
const FILTER_TEXELS: f64 = 5.0;

/// What a reflected view looks up in one cascade.
pub struct Lookup {
    /// The corners, in the world, of what the cascade is sampled for.
    corners: [DVec3; 8],
    /// The covector of the depth in the view.
    view_depth: DVec4,
    /// How far beside a point its shadow may be looked up.
    reach: f64,
    /// How far towards the light.
    lift: f64,
}

/// Whether anything at these view depths reads cascade `index`.
///
/// A point reads the first cascade whose far bound it lies before and, from where the next one
/// begins to overlap, that one as well.
pub fn is_cascade_read(config: &CascadeShadowConfig, index: usize, seen: DepthRange) -> bool {
    config.bounds.get(index).is_some_and(|&far| {
        seen.near <= far && seen.far >= cascade_near(config, index).unwrap_or(f32::NEG_INFINITY)
    })
}

impl Lookup {
    /// `None` if it is not known.
    pub fn new(
        planned: &PlannedView,
        (camera, filter): (&Camera, Option<&ShadowFilteringMethod>),
        (light, config): (&DirectionalLight, &CascadeShadowConfig),
        index: usize,
        texel_size: f32,
    ) -> Option<Self> {
        Some(Self {
            corners: seen_corners(planned, camera, config, index)?,
            view_depth: -DMat4::from(planned.plan.world_from_view.inverse()).row(2),
            reach: reach(light, filter, f64::from(texel_size))?,
            lift: f64::from(light.shadow_depth_bias.abs()),
        })
    }

    /// Leaves the frustum what lies between the light and the corners, and as far beside as shadows
    /// reach.
    pub fn narrow(&self, frustum: &mut Frustum, cascade: &Cascade) {
        let world_from_cascade = cascade.world_from_cascade.as_dmat4();
        let sides = [world_from_cascade.x_axis, world_from_cascade.y_axis]
            .map(DVec4::truncate)
            .into_iter()
            .flat_map(|axis| [axis, -axis]);
        for (half_space, inwards) in frustum.half_spaces.iter_mut().zip(sides) {
            let (least, _) = self.range(inwards.extend(0.0));
            let d = (self.reach - least).min(f64::from(half_space.d()));
            *half_space = HalfSpace::new(inwards.extend(d).as_vec4());
        }
    }

    /// The device coordinates of what is read of a cascade's map.
    pub fn map_bounds(&self, cascade: &Cascade) -> (Vec2, Vec2) {
        let clip_from_world = cascade.clip_from_world.as_dmat4();
        let [x, y] = [0, 1].map(|row| {
            let row = clip_from_world.row(row);
            widened(self.range(row), row, self.reach)
        });
        (
            DVec2::new(x.0, y.0).as_vec2(),
            DVec2::new(x.1, y.1).as_vec2(),
        )
    }

    /// Whether a cascade holds all that is read of these objects. `None` may be anywhere.
    pub fn is_within(
        &self,
        cascade: &Cascade,
        mut objects: impl Iterator<Item = Option<WorldBox>>,
    ) -> bool {
        let clip_from_world = cascade.clip_from_world.as_dmat4();
        let sides = [
            (clip_from_world.row(0), -1.0, self.reach),
            (clip_from_world.row(1), -1.0, self.reach),
            (clip_from_world.row(2), 0.0, self.reach + self.lift),
        ];
        let holds = |ranges: [(f64, f64); 3]| {
            ranges
                .into_iter()
                .zip(sides)
                .all(|(range, (row, least, reach))| {
                    let (low, high) = widened(range, row, reach);
                    low >= least && high <= 1.0
                })
        };
        let all = sides.map(|(row, ..)| self.range(row));
        let (near, far) = self.range(self.view_depth);
        holds(all)
            || objects.all(|object| {
                let Some(object) = object else {
                    return false;
                };
                let (nearest, farthest) = object.range(self.view_depth);
                let mut part = all;
                for (part, (row, ..)) in part.iter_mut().zip(sides) {
                    let (low, high) = object.range(row);
                    *part = (part.0.max(low), part.1.min(high));
                }
                let is_elsewhere = nearest > far || farthest < near;
                is_elsewhere || part.iter().any(|(low, high)| low > high) || holds(part)
            })
    }

    /// The least and the greatest value of a covector over the corners.
    fn range(&self, covector: DVec4) -> (f64, f64) {
        let values = self.corners.map(|corner| covector.dot(corner.extend(1.0)));
        (
            values.into_iter().fold(f64::INFINITY, f64::min),
            values.into_iter().fold(f64::NEG_INFINITY, f64::max),
        )
    }
}

/// A range of values of a covector, and of those so far around.
fn widened((low, high): (f64, f64), covector: DVec4, reach: f64) -> (f64, f64) {
    let guard = covector.truncate().length() * reach;
    (low - guard, high + guard)
}

/// How far beside a point its shadow may be looked up, in the world; `None` if that is not known.
fn reach(
    light: &DirectionalLight,
    filter: Option<&ShadowFilteringMethod>,
    texel_size: f64,
) -> Option<f64> {
    // How far these reach depends on the size of the light. The field is there only with a feature
    // of the engine, which is not for this crate to turn on.
    let is_soft = light
        .get_field::<Option<f32>>("soft_shadow_size")
        .is_some_and(Option::is_some);
    if is_soft {
        return None;
    }
    let spiral = match filter {
        Some(ShadowFilteringMethod::Temporal) => spiral_radius(texel_size),
        _ => 0.0,
    };
    // The engine moves the point along the normal by so many texels, times the square root of 2.
    let offset = core::f64::consts::SQRT_2 * f64::from(light.shadow_normal_bias.abs());
    Some((FILTER_TEXELS + offset) * texel_size + spiral).filter(|reach| reach.is_finite())
}

/// How far the noisy filter reaches, in the world, for texels of that size: a straight line through
/// two points, `calculate_uv_offset_scale_jimenez_fourteen` of Bevy's `shadow_sampling.wgsl`.
fn spiral_radius(texel_size: f64) -> f64 {
    const FINE: (f64, f64) = (0.00390625, 0.015);
    const COARSE: (f64, f64) = (0.022949219, 0.035);
    FINE.1 + (texel_size - FINE.0) * (COARSE.1 - FINE.1) / (COARSE.0 - FINE.0)
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
