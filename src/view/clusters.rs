//! Light clusters of reflected views: no more than the seen part of the mirror is worth, and none
//! with a corner on the mirror's horizon.

use bevy::{camera::Camera, ecs::prelude::*, light::cluster::ClusterConfig};
use glam::{DVec2, UVec2};

use super::apply::set;

/// So many pixels of a mirror for each cluster, at least.
///
/// To find out whether a light reaches a cluster costs about as much as to shade a pixel by it, and
/// is done twice. So clusters add at most an eighth to the light of the pixels that are seen; the
/// default of 4096 is all of it from 65,536 pixels on.
const PIXELS_OF_CLUSTER: f64 = 16.0;

/// Gives the view the camera's clusters, fewer if few `pixels` are seen of its mirrors: all of them
/// are filled, whether they are seen or not. How they are cut changes no pixel, only how many lights
/// are looked at in vain.
///
/// An odd number of them across and down. The engine finds their corners where the view's rays meet
/// the near plane, which is the mirror's, and those along its horizon never do. The horizon of a
/// level camera over a floor is the middle of the picture.
pub fn fit_clusters(world: &mut World, camera: Entity, view: Entity, pixels: f64) {
    let config = world.get::<ClusterConfig>(camera).copied();
    let size = world
        .get::<Camera>(camera)
        .and_then(Camera::physical_viewport_size);
    let fitted = match config.unwrap_or_default() {
        ClusterConfig::FixedZ {
            total,
            z_slices,
            z_config,
            dynamic_resizing,
        } => {
            let worth = (pixels / PIXELS_OF_CLUSTER).min(total.into());
            let of_slice = worth / f64::from(z_slices.clamp(1, total.max(1)));
            ClusterConfig::XYZ {
                dimensions: square_tiles(of_slice, size.unwrap_or(UVec2::ONE)).extend(z_slices),
                z_config,
                dynamic_resizing,
            }
        }
        ClusterConfig::XYZ {
            dimensions,
            z_config,
            dynamic_resizing,
        } => ClusterConfig::XYZ {
            dimensions: odd(dimensions.truncate()).extend(dimensions.z),
            z_config,
            dynamic_resizing,
        },
        other => other,
    };
    set(&mut world.entity_mut(view), fitted);
}

/// At most `count` tiles across and down a picture, about as wide as high.
fn square_tiles(count: f64, size: UVec2) -> UVec2 {
    let size = size.as_dvec2();
    let ratio = size.x / size.y;
    let across = DVec2::new(count * ratio, count / ratio).map(f64::sqrt);
    // A picture much longer than high has one row of tiles, and not more of them for that.
    odd(across.min(DVec2::splat(count)).as_uvec2())
}

/// These numbers or the next odd ones below, but at least 1.
fn odd(count: UVec2) -> UVec2 {
    count.saturating_sub(UVec2::ONE) | UVec2::ONE
}
