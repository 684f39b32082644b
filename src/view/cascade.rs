//! Shadow cascades of reflected views.
//!
//! A cascade is a box that holds a slice of what a view sees, with the axes of its light. Bevy's
//! `build_directional_light_cascades` gives it a width that follows from the projection alone, and a
//! center on whole texels. A reflected view has its camera's projection, so its cascades differ from
//! the camera's in nothing but where they are.

use bevy::{
    camera::Projection,
    ecs::prelude::*,
    light::{CascadeShadowConfig, Cascades, DirectionalLight, cascade::Cascade},
};
use glam::{DAffine3, DMat3, DMat4, DVec3, DVec4};

use super::ReflectedViews;

/// Gives every planned view the cascades that the engine would give it.
pub fn build_cascades(
    views: Res<ReflectedViews>,
    cameras: Query<&Projection>,
    mut suns: Query<(&DirectionalLight, &CascadeShadowConfig, &mut Cascades)>,
) {
    for (sun, config, mut cascades) in &mut suns {
        if !sun.shadow_maps_enabled {
            continue;
        }
        for planned in &views.planned {
            let (Some(view), Ok(projection), Some(of_camera)) = (
                planned.entity,
                cameras.get(planned.camera),
                cascades.cascades.get(&planned.camera),
            ) else {
                continue;
            };
            // The light may have been set up anew since the engine built the camera's.
            let cascades_to = of_camera.iter().zip(&config.bounds).enumerate();
            let moved = cascades_to.map(|(index, (cascade, far))| {
                let near = cascade_near(config, index).unwrap_or(config.minimum_distance);
                let corners = projection.get_frustum_corners(-near, -far);
                let corners = corners.map(|corner| corner.as_dvec3());
                moved(cascade, corners, &planned.plan.world_from_view)
            });
            let moved = moved.collect();
            cascades.cascades.insert(view, moved);
        }
    }
}

/// Where a cascade begins; `None` for the first, which holds everything nearer than its end.
pub fn cascade_near(config: &CascadeShadowConfig, index: usize) -> Option<f32> {
    let before = config.bounds.get(index.checked_sub(1)?)?;
    Some((1.0 - config.overlap_proportion) * before)
}

/// The cascade around these corners, given in a view.
///
/// In the light's axes `L`, a rotation, the corners `L^T V c` have a least and a greatest place. The
/// cascade's origin is the middle of the two in x and y, down to whole texels, and the greatest z,
/// which is the nearest to the light. Depth goes from 1 there to 0 at the least z, reversed as all
/// depth in Bevy.
fn moved(cascade: &Cascade, corners: [DVec3; 8], world_from_view: &DAffine3) -> Cascade {
    let world_from_cascade = cascade.world_from_cascade.as_dmat4();
    let axes = DMat3::from_mat4(world_from_cascade);
    let corners = corners.map(|corner| axes.transpose() * world_from_view.transform_point3(corner));
    let least = corners.into_iter().fold(DVec3::INFINITY, DVec3::min);
    let greatest = corners.into_iter().fold(DVec3::NEG_INFINITY, DVec3::max);
    let texel = f64::from(cascade.texel_size);
    let middle = (0.5 * (least + greatest) / texel).floor() * texel;
    let origin = middle.truncate().extend(greatest.z);
    let mut clip_from_cascade = cascade.clip_from_cascade.as_dmat4();
    clip_from_cascade.z_axis.z = (greatest.z - least.z).recip();
    let place = |axes: DMat3, origin: DVec3| {
        DMat4::from_cols(
            axes.x_axis.extend(0.0),
            axes.y_axis.extend(0.0),
            axes.z_axis.extend(0.0),
            DVec4::from((origin, 1.0)),
        )
    };
    let cascade_from_world = place(axes.transpose(), -origin);
    Cascade {
        world_from_cascade: place(axes, axes * origin).as_mat4(),
        clip_from_cascade: clip_from_cascade.as_mat4(),
        clip_from_world: (clip_from_cascade * cascade_from_world).as_mat4(),
        texel_size: cascade.texel_size,
    }
}
