//! What lies in a slice of a view and in a box.

use glam::{DVec3, DVec4};

use super::polygon::VisiblePolygon;

/// A slice of a view between two depths, narrowed to a rectangle of the picture.
#[derive(Clone, Copy, Debug)]
pub struct ViewSlice {
    /// Bit 0 of an index says which depth, bits 1 and 2 which side of the rectangle.
    pub corners: [DVec3; 8],
}

/// The corners around each face.
const FACES: [[usize; 4]; 6] = [
    [0, 2, 6, 4],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 3, 7, 6],
    [0, 1, 3, 2],
    [4, 5, 7, 6],
];

impl ViewSlice {
    /// The least and the greatest value of each covector over what lies in the slice and in the box
    /// with those lowest and highest coordinates; infinity and its opposite if nothing does.
    ///
    /// What lies in both is convex, and a covector is greatest in one of its corners. These are the
    /// corners of the slice's faces, clipped by the box, and those of the box inside the slice.
    pub fn ranges_in_box<const N: usize>(
        &self,
        (low, high): (DVec3, DVec3),
        covectors: &[DVec4; N],
    ) -> [(f64, f64); N] {
        let mut ranges = [(f64::INFINITY, f64::NEG_INFINITY); N];
        let mut add = |corner: DVec4| {
            for ((least, greatest), covector) in ranges.iter_mut().zip(covectors) {
                let value = covector.dot(corner);
                *least = least.min(value);
                *greatest = greatest.max(value);
            }
        };
        let sides = [DVec3::X, DVec3::Y, DVec3::Z]
            .into_iter()
            .flat_map(|axis| [axis.extend(-axis.dot(low)), (-axis).extend(axis.dot(high))]);
        for face in FACES {
            let face = face.map(|corner| self.corners[corner].extend(1.0));
            let inside = sides.clone().fold(VisiblePolygon::of(&face), |face, side| {
                face.clipped(|corner| side.dot(corner))
            });
            inside.vertices().iter().copied().for_each(&mut add);
        }
        for index in 0..8 {
            let side = |axis: usize| if index >> axis & 1 == 0 { low } else { high }[axis];
            let corner = DVec3::new(side(0), side(1), side(2));
            if self.holds(corner) {
                add(corner.extend(1.0));
            }
        }
        ranges
    }

    /// Whether a point is inside of every face. One of no area, as at the eye, bounds nothing.
    fn holds(&self, point: DVec3) -> bool {
        let middle = self.corners.iter().sum::<DVec3>() / 8.0;
        FACES.iter().all(|face| {
            let [a, b, c, d] = face.map(|corner| self.corners[corner]);
            let normal = (c - a).cross(d - b);
            normal.dot(point - a) * normal.dot(middle - a) >= 0.0
        })
    }
}
