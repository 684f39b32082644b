//! Where an object lies in the world.

use bevy::{camera::primitives::Aabb, transform::components::GlobalTransform};
use glam::{DVec3, DVec4};

/// A box with its axes in the world.
#[derive(Clone, Copy, Debug)]
pub struct WorldBox {
    pub center: DVec3,
    /// From the center to the middles of three faces.
    pub half_axes: [DVec3; 3],
}

impl WorldBox {
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

    /// The box that has two corners, and its edges along the axes of the world.
    pub fn between(low: DVec3, high: DVec3) -> Self {
        let half = (high - low) / 2.0;
        Self {
            center: (low + high) / 2.0,
            half_axes: [DVec3::X * half.x, DVec3::Y * half.y, DVec3::Z * half.z],
        }
    }

    /// The lowest and the highest coordinates in it.
    pub fn corners(&self) -> (DVec3, DVec3) {
        let [a, b, c] = self.half_axes.map(DVec3::abs);
        let half = a + b + c;
        (self.center - half, self.center + half)
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
