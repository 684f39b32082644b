//! The plane and the bounds of a flat mesh.

use core::fmt;

use glam::{DVec2, DVec3, Vec3};

use super::{
    patch::{PlanarPatch, tangents},
    plane::direction,
    polygon::bounds_of,
};

/// How far a vertex may leave the plane, as a share of the mesh's radius.
const FLATNESS: f64 = 1e-3;
/// And besides, in units of the rounding of its coordinates.
const ROUNDING_STEPS: f64 = 4.0;
/// Areas that differ by less than this share of their sum count as equal.
const SAME_AREA: f64 = 1e-6;

/// Why a mesh has no mirror plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FitError {
    /// A vertex position is infinite or not a number.
    NotFinite,
    /// A triangle names a vertex that does not exist.
    NotReadable,
    /// There is no triangle with an area.
    Empty,
    /// The vertices do not lie in one plane.
    NotFlat {
        /// The largest distance of a vertex from the plane of best fit, in mesh units.
        deviation: f64,
    },
}

impl fmt::Display for FitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => f.write_str("a vertex position is not finite"),
            Self::NotReadable => f.write_str("a triangle index is out of range"),
            Self::Empty => f.write_str("no triangle has an area"),
            Self::NotFlat { deviation } => {
                write!(f, "not flat: a vertex is {deviation} away from the plane")
            }
        }
    }
}

impl core::error::Error for FitError {}

/// Fits a plane and a rectangle to a flat mesh, given its positions in mesh space.
///
/// The front is the side that most of the area faces by the winding (counter-clockwise from the
/// front); for a mesh with equal areas both ways, the side of its largest triangle, and of
/// several such, of the first. Vertices that no triangle uses do not count.
pub fn fit_patch(
    positions: &[[f32; 3]],
    triangles: impl Iterator<Item = [u32; 3]> + Clone,
) -> Result<PlanarPatch, FitError> {
    let corners = |triangle: [u32; 3]| -> Result<[DVec3; 3], FitError> {
        let mut points = [DVec3::ZERO; 3];
        for (point, index) in points.iter_mut().zip(triangle) {
            let position = positions.get(index as usize).ok_or(FitError::NotReadable)?;
            *point = Vec3::from_array(*position).as_dvec3();
        }
        let finite = points.iter().all(|point| point.is_finite());
        finite.then_some(points).ok_or(FitError::NotFinite)
    };
    for triangle in triangles.clone() {
        corners(triangle)?;
    }
    // From here on every triangle is known to be readable.
    let faces = || triangles.clone().filter_map(|t| corners(t).ok());

    let (normal, centroid) = mean_plane(faces)?;
    check_flat(faces().flatten(), normal, centroid)?;
    let (tangent_x, tangent_y) = tangents(normal).ok_or(FitError::Empty)?;
    let (low, high) = bounds_of(faces().flatten().map(|p| {
        let from_center = p - centroid;
        DVec2::new(tangent_x.dot(from_center), tangent_y.dot(from_center))
    }));
    let middle = (low + high) * 0.5;
    Ok(PlanarPatch {
        center: centroid + tangent_x * middle.x + tangent_y * middle.y,
        tangent_x,
        tangent_y,
        half_size: (high - low) * 0.5,
    })
}

/// The unit normal and the centroid of the triangles, each weighted by its area.
fn mean_plane<F: Iterator<Item = [DVec3; 3]>>(
    faces: impl Fn() -> F,
) -> Result<(DVec3, DVec3), FitError> {
    let mut largest = DVec3::ZERO;
    for face in faces() {
        let area = face_area(face);
        // The two faces of a sheet may differ by rounding: the first one stays the largest.
        if area.length() > largest.length() * (1.0 + SAME_AREA) {
            largest = area;
        }
    }
    let reference = faces().next().map_or(DVec3::ZERO, |face| face[0]);
    let (mut sum, mut total, mut facing) = (DVec3::ZERO, 0.0, 0.0);
    let mut moment = DVec3::ZERO;
    for face in faces() {
        let area = face_area(face);
        let sign = if area.dot(largest) < 0.0 { -1.0 } else { 1.0 };
        sum += area * sign;
        facing += area.length() * sign;
        total += area.length();
        let center = face
            .iter()
            .map(|p| *p - reference)
            .fold(DVec3::ZERO, |a, b| a + b / 3.0);
        moment += center * area.length();
    }
    let normal = direction(sum).ok_or(FitError::Empty)?;
    let centroid = reference + moment / total;
    let flipped = facing < -SAME_AREA * total;
    Ok((if flipped { -normal } else { normal }, centroid))
}

/// Twice the area of a triangle, along its normal.
fn face_area([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

fn check_flat(
    points: impl Iterator<Item = DVec3>,
    normal: DVec3,
    center: DVec3,
) -> Result<(), FitError> {
    let (mut deviation, mut radius, mut largest) = (0.0_f64, 0.0_f64, 0.0_f64);
    for point in points {
        deviation = deviation.max(normal.dot(point - center).abs());
        radius = radius.max(point.distance(center));
        largest = largest.max(point.abs().max_element());
    }
    let rounding = ROUNDING_STEPS * f64::from(f32::EPSILON) * largest;
    if deviation <= FLATNESS * radius + rounding {
        Ok(())
    } else {
        Err(FitError::NotFlat { deviation })
    }
}
