//! Light clusters of reflected views: no more than the seen part of the mirror is worth.

use bevy::{ecs::prelude::*, light::cluster::ClusterConfig};

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
/// In halves, so that their number stands still while the camera moves, and never fewer than
/// slices. What the user laid out in numbers along the axes stays.
pub fn fit_clusters(world: &mut World, camera: Entity, view: Entity, pixels: f64) {
    let mut config = world
        .get::<ClusterConfig>(camera)
        .copied()
        .unwrap_or_default();
    if let ClusterConfig::FixedZ {
        total, z_slices, ..
    } = &mut config
    {
        let floor = pixels / PIXELS_OF_CLUSTER;
        while f64::from(*total) > floor && *total / 2 >= (*z_slices).max(1) {
            *total /= 2;
        }
    }
    set(&mut world.entity_mut(view), config);
}
