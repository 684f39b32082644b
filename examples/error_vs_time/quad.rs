//! The rectangle that a mirror covers in the world, in f64.

use bevy::{
    math::{DVec2, DVec3},
    mesh::{Mesh, VertexAttributeValues},
};

use crate::support::{
    cut::Plane,
    scene::{Surface, exact},
};

/// A rectangle; `x` and `y` run from its center to the middles of two sides, and their cross
/// product points to the front.
#[derive(Clone, Copy, Debug)]
pub struct Quad {
    pub center: DVec3,
    pub x: DVec3,
    pub y: DVec3,
}

impl Quad {
    pub fn of(surface: &Surface) -> Self {
        let [point, a, b] = surface.frame;
        let Some(VertexAttributeValues::Float32x3(positions)) =
            surface.mesh.attribute(Mesh::ATTRIBUTE_POSITION)
        else {
            panic!("the mirrors of the report have positions");
        };
        let flat = positions.iter().map(|position| {
            let from_point = DVec3::from_array(position.map(f64::from)) - point;
            DVec2::new(from_point.dot(a), from_point.dot(b))
        });
        let (low, high) = flat.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), at| {
            (low.min(at), high.max(at))
        });
        let world_from_local = exact(&surface.transform);
        let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0);
        // A transform that turns the mesh inside out takes its front along.
        let b_side = if surface.is_mirrored() { -b } else { b };
        Self {
            center: world_from_local.transform_point3(point + a * middle.x + b * middle.y),
            x: world_from_local.transform_vector3(a * half.x),
            y: world_from_local.transform_vector3(b_side * half.y),
        }
    }

    pub fn plane(&self) -> Plane {
        Plane::through(self.center, self.x.cross(self.y))
    }

    /// Whether a point of the plane is in the rectangle.
    pub fn contains(&self, point: DVec3) -> bool {
        let from_center = point - self.center;
        [self.x, self.y]
            .iter()
            .all(|axis| from_center.dot(*axis).abs() <= axis.length_squared())
    }

    /// In order around the rectangle.
    pub fn corners(&self) -> [DVec3; 4] {
        let Self { center, x, y } = *self;
        [
            center - x - y,
            center + x - y,
            center + x + y,
            center - x + y,
        ]
    }
}

#[cfg(test)]
mod tests {
    use bevy::prelude::*;

    use super::*;

    #[test]
    fn the_front_is_that_of_the_surface() {
        for scale in [Vec3::new(-1.0, 1.0, 1.0), Vec3::new(1.0, 1.0, -1.0)] {
            let surface = Surface::wall(4.0, 3.0, Transform::from_scale(scale));
            let front = Quad::of(&surface).plane().normal;
            assert_eq!(front, surface.plane().normal, "{scale}");
        }
    }

    #[test]
    fn a_flattened_and_turned_surface_keeps_its_plane_and_its_size() {
        let transform = Transform::from_xyz(1.0, 2.0, 3.0)
            .with_rotation(Quat::from_rotation_y(0.7))
            .with_scale(Vec3::new(2.0, 1.0, 0.0));
        let quad = Quad::of(&Surface::wall(4.0, 3.0, transform));
        assert!((quad.x.length() - 4.0).abs() < 1e-6);
        assert!((quad.y.length() - 1.5).abs() < 1e-6);
        assert!(quad.contains(quad.center + quad.x * 0.99 - quad.y * 0.99));
        assert!(!quad.contains(quad.center + quad.x * 1.01));
        let front = Quat::from_rotation_y(0.7) * Vec3::Z;
        assert!(quad.plane().normal.distance(front.as_dvec3()) < 1e-6);
    }
}
