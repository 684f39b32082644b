//! The flat rectangle that a mirror covers, in its mesh's space and in the world.

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::plane::{Plane, direction};

/// Below this sine between two axes, rounding to `f32` alone decides which plane they span.
const MIN_SINE: f64 = 1e-6;

/// A rectangle in a mesh's own space, around the mesh's flat geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarPatch {
    /// The middle of the rectangle.
    pub center: DVec3,
    /// The direction of its width, of unit length.
    pub tangent_x: DVec3,
    /// The direction of its height, of unit length and orthogonal to the width.
    /// `tangent_x` × `tangent_y` points to the front.
    pub tangent_y: DVec3,
    /// Half its width and height. Infinite where the extent is not known.
    pub half_size: DVec2,
}

impl PlanarPatch {
    /// The patch of a plane given by a point and a normal of any length, in mesh space.
    ///
    /// `bounds` are the center and the half extents of a box in which the mirror lies; the patch
    /// is the shadow of that box on the plane. Without bounds it is infinite.
    /// `None` if `point` or `bounds` are not a number or `normal` has no direction.
    pub fn from_point_and_normal(
        point: DVec3,
        normal: DVec3,
        bounds: Option<(DVec3, DVec3)>,
    ) -> Option<Self> {
        let plane = Plane::new(point, normal)?;
        let (tangent_x, tangent_y) = tangents(plane.normal)?;
        let (center, half_size) = match bounds {
            Some((center, half)) if center.is_finite() && half.is_finite() => (
                center - plane.normal * plane.signed_distance(center),
                DVec2::new(
                    tangent_x.abs().dot(half.abs()),
                    tangent_y.abs().dot(half.abs()),
                ),
            ),
            Some((center, half)) if center.is_nan() || half.is_nan() => return None,
            _ => (point, DVec2::INFINITY),
        };
        (center.is_finite() && !half_size.is_nan()).then_some(Self {
            center,
            tangent_x,
            tangent_y,
            half_size,
        })
    }
}

/// The plane of a patch in the world, and its corners in order around it.
///
/// The corners are `None` for a patch without bounds. All is `None` if anything is not finite or
/// the transform collapses the plane to a line or a point.
///
/// The normal is `normalize(cross(M t1, M t2))`, whatever the scale, and it points to the side to
/// which `M` carries the front; where `M` flattens the front away, the sign of the cross product
/// stays. The inverse transpose of `M` gives the same plane but does not exist for the scale
/// (1, 1, 0), which a flat mesh may well have.
pub fn transform_patch(
    patch: &PlanarPatch,
    world_from_local: &DAffine3,
) -> Option<(Plane, Option<[DVec3; 4]>)> {
    let front = direction(patch.tangent_x.cross(patch.tangent_y))?;
    let normal = transform_normal(&world_from_local.matrix3, front)?;
    let origin = world_from_local.transform_point3(patch.center);
    if !origin.is_finite() || patch.half_size.is_nan() {
        return None;
    }
    let plane = Plane { origin, normal };
    if !patch.half_size.is_finite() {
        return Some((plane, None));
    }
    let x = world_from_local.transform_vector3(patch.tangent_x * patch.half_size.x);
    let y = world_from_local.transform_vector3(patch.tangent_y * patch.half_size.y);
    let corners = [
        origin - x - y,
        origin + x - y,
        origin + x + y,
        origin - x + y,
    ];
    corners
        .iter()
        .all(|corner| corner.is_finite())
        .then_some((plane, Some(corners)))
}

/// The unit normal of the plane onto which `m` maps the plane with normal `front`.
///
/// `cross(M t1, M t2) = cof(M) front`, where the columns of the cofactor matrix are the cross
/// products of M's columns. These are taken at unit scale and weighted afterwards, so that neither
/// tiny nor very unequal scales blur the direction; the tangents themselves may become almost
/// parallel under an unequal scale. The sign is that of `(cof(M) front).(M front) = det(M)`.
fn transform_normal(m: &DMat3, front: DVec3) -> Option<DVec3> {
    let columns = [m.x_axis, m.y_axis, m.z_axis];
    if !m.is_finite() {
        return None;
    }
    // Lengths, taken so that no square of a component overflows or vanishes.
    let scales = columns.map(|column| match column.abs().max_element() {
        0.0 => 0.0,
        largest => largest * (column / largest).length(),
    });
    let axes = columns.map(|column| direction(column).unwrap_or(DVec3::ZERO));
    let crosses = [
        axes[1].cross(axes[2]),
        axes[2].cross(axes[0]),
        axes[0].cross(axes[1]),
    ];
    // Relative to the largest scale: the products of two may overflow or vanish.
    let largest = scales[0].max(scales[1]).max(scales[2]);
    let [x, y, z] = scales.map(|scale| scale / largest);
    let weights = front * DVec3::new(y * z, z * x, x * y);
    let sum = crosses[0] * weights.x + crosses[1] * weights.y + crosses[2] * weights.z;
    let collapsed = sum.length() <= MIN_SINE * weights.abs().max_element();
    if collapsed || !sum.is_finite() {
        return None;
    }
    let normal = direction(sum)?;
    let handedness = axes[2].dot(crosses[2]);
    Some(if handedness < 0.0 { -normal } else { normal })
}

/// Two unit tangents with `x` × `y` = `normal`; `None` if `normal` has no direction.
///
/// The first is the coordinate axis least aligned with the normal, laid into the plane: of a
/// rectangle along two axes the tangents are these axes.
pub(super) fn tangents(normal: DVec3) -> Option<(DVec3, DVec3)> {
    let aligned = normal.abs();
    let axis = if aligned.x <= aligned.y && aligned.x <= aligned.z {
        DVec3::X
    } else if aligned.y <= aligned.z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    let x = direction(axis - normal * normal.dot(axis))?;
    Some((x, direction(normal.cross(x))?))
}
