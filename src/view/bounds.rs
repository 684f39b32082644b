//! Where an object lies in the world.

use bevy::{
    camera::{primitives::Aabb, visibility::NoFrustumCulling},
    ecs::query::Has,
    transform::components::GlobalTransform,
};
use glam::{DVec3, DVec4};

/// What tells where an object is.
pub type Bounds<'a> = (&'a GlobalTransform, Option<&'a Aabb>, Has<NoFrustumCulling>);

/// A box with its axes in the world.
pub struct WorldBox {
    pub center: DVec3,
    /// From the center to the middles of three faces.
    pub half_axes: [DVec3; 3],
}

impl WorldBox {
    /// `None` if the object may be anywhere.
    pub fn of(
        (transform, aabb, is_anywhere): (&GlobalTransform, Option<&Aabb>, bool),
    ) -> Option<Self> {
        let aabb = aabb.filter(|_| !is_anywhere)?;
        Some(Self::new(transform, aabb))
    }

    pub fn new(transform: &GlobalTransform, aabb: &Aabb) -> Self {
        let world_from_local = transform.affine().as_daffine3();
        let half = aabb.half_extents.as_dvec3();
        let axes = world_from_local.matrix3;
        Self {
            center: world_from_local.transform_point3(aabb.center.as_dvec3()),
            half_axes: [
                axes.x_axis * half.x,
                axes.y_axis * half.y,
                axes.z_axis * half.z,
            ],
        }
    }

    /// The least and the greatest value of a covector over the box.
    pub fn range(&self, covector: DVec4) -> (f64, f64) {
        let middle = covector.dot(self.center.extend(1.0));
        let reach: f64 = self
            .half_axes
            .iter()
            .map(|axis| covector.truncate().dot(*axis).abs())
            .sum();
        (middle - reach, middle + reach)
    }
}
