//! The Utah teapot from its 32 bicubic Bezier patches: points, analytic normals, a mesh.
//!
//! In f64, rounded once at the end, so that neighbouring patches meet without a gap.

use bevy::{
    asset::RenderAssetUsages,
    math::{DVec3, dvec3},
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};
use serde::Deserialize;

/// The finest tessellation on offer: 32 * 64 * 64 quads.
pub const MAX_TESSELLATION: u32 = 64;

/// 4 x 4 control points, row by row: `u` runs over the rows, `v` along a row.
pub struct Patch([[DVec3; 4]; 4]);

#[derive(Deserialize)]
struct ControlData {
    vertices: Vec<[f64; 3]>,
    patches: Vec<[usize; 16]>,
}

/// From the bottom to the tip of the knob.
pub const TEAPOT_HEIGHT: f32 = 3.15;

/// The patches, y up, standing on y = 0, [`TEAPOT_HEIGHT`] units high.
pub fn teapot_patches() -> Vec<Patch> {
    let json = include_str!("../../assets/teapot/utah_teapot_patches.json");
    let data: ControlData = serde_json::from_str(json).expect("the control data are well formed");
    // A quarter turn, z up to y up; it keeps the orientation of the patches.
    let point = |index: usize| {
        let [x, y, z] = data.vertices[index];
        dvec3(x, z, -y)
    };
    data.patches
        .iter()
        .map(|row| Patch([0, 4, 8, 12].map(|k| [0, 1, 2, 3].map(|j| point(row[k + j])))))
        .collect()
}

/// A mesh with `n` x `n` quads for each patch, front sides outwards.
pub fn tessellate(patches: &[Patch], n: u32) -> Mesh {
    let n = n.clamp(1, MAX_TESSELLATION);
    let mut positions = Vec::new();
    let mut normals = Vec::new();
    let mut indices = Vec::new();
    for patch in patches {
        let first = positions.len() as u32;
        for i in 0..=n {
            for j in 0..=n {
                let (u, v) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                positions.push(patch.point(u, v).as_vec3());
                normals.push(patch.normal(u, v).as_vec3());
            }
        }
        for i in 0..n {
            for j in 0..n {
                let a = first + i * (n + 1) + j;
                let (b, c, d) = (a + 1, a + n + 1, a + n + 2);
                for triangle in [[a, b, d], [a, d, c]] {
                    // Where an edge of the patch is a single point, one triangle in two is empty.
                    let [p, q, r] = triangle.map(|k| positions[k as usize]);
                    if p != q && q != r && r != p {
                        indices.extend(triangle);
                    }
                }
            }
        }
    }
    Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
    .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
    .with_inserted_indices(Indices::U32(indices))
}

impl Patch {
    /// The surface point at `u`, `v` in 0..=1.
    pub fn point(&self, u: f64, v: f64) -> DVec3 {
        self.sum(bernstein(u), bernstein(v))
    }

    /// The unit normal at `u`, `v` in 0..=1, outwards.
    ///
    /// At the tip of the lid's knob and in the middle of the bottom a whole edge `u = 0` is a
    /// single point: there `P_v` is zero, and the normal is the limit for `u -> 0`. With
    /// `P_v(u, v) = u P_uv(0, v) + O(u^2)` it has the direction of `P_uv x P_u`; on the edge
    /// `u = 1` the sign turns, as `u - 1` is negative. The same for `v` with the roles exchanged.
    pub fn normal(&self, u: f64, v: f64) -> DVec3 {
        let (du, dv) = (bernstein_slope(u), bernstein_slope(v));
        let mut p_u = self.sum(du, bernstein(v));
        let mut p_v = self.sum(bernstein(u), dv);
        let p_uv = self.sum(du, dv);
        let inwards = |t: f64| if t < 0.5 { 1.0 } else { -1.0 };
        // The control points are of order 1; a tangent this short is rounding.
        const VANISHED: f64 = 1e-9;
        if p_v.length() < VANISHED {
            p_v = p_uv * inwards(u);
        }
        if p_u.length() < VANISHED {
            p_u = p_uv * inwards(v);
        }
        p_v.cross(p_u).normalize()
    }

    fn sum(&self, by_row: [f64; 4], by_column: [f64; 4]) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for (row, a) in self.0.iter().zip(by_row) {
            for (point, b) in row.iter().zip(by_column) {
                sum += *point * (a * b);
            }
        }
        sum
    }
}

/// The four cubic Bernstein polynomials.
fn bernstein(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [s * s * s, 3.0 * t * s * s, 3.0 * t * t * s, t * t * t]
}

/// Their derivatives.
fn bernstein_slope(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [
        -3.0 * s * s,
        3.0 * s * (s - 2.0 * t),
        3.0 * t * (2.0 * s - t),
        3.0 * t * t,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEPS: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

    #[test]
    fn every_normal_is_a_unit_vector() {
        for (index, patch) in teapot_patches().iter().enumerate() {
            for u in STEPS {
                for v in STEPS {
                    let normal = patch.normal(u, v);
                    assert!(
                        (normal.length() - 1.0).abs() < 1e-12,
                        "patch {index} at ({u}, {v}): {normal}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_degenerate_corners_have_the_normal_of_their_surroundings() {
        let patches = teapot_patches();
        for v in STEPS {
            for tip in &patches[20..24] {
                assert!(tip.normal(0.0, v).abs_diff_eq(DVec3::Y, 1e-12), "lid");
            }
            for bottom in &patches[28..32] {
                assert!(
                    bottom.normal(0.0, v).abs_diff_eq(-DVec3::Y, 1e-12),
                    "bottom"
                );
            }
        }
        for patch in &patches {
            for v in STEPS {
                let (edge, beside) = (patch.normal(0.0, v), patch.normal(1e-6, v));
                assert!(edge.abs_diff_eq(beside, 1e-4), "{edge} beside {beside}");
            }
        }
    }

    #[test]
    fn normals_are_at_right_angles_to_the_surface() {
        const H: f64 = 1e-5;
        for patch in &teapot_patches() {
            for u in [0.2, 0.5, 0.8] {
                for v in [0.2, 0.5, 0.8] {
                    let normal = patch.normal(u, v);
                    let along_u = patch.point(u + H, v) - patch.point(u - H, v);
                    let along_v = patch.point(u, v + H) - patch.point(u, v - H);
                    assert!(normal.dot(along_u.normalize()).abs() < 1e-7);
                    assert!(normal.dot(along_v.normalize()).abs() < 1e-7);
                }
            }
        }
    }

    #[test]
    fn triangles_face_the_way_their_normals_point() {
        let mesh = tessellate(&teapot_patches(), 6);
        let positions = mesh
            .attribute(Mesh::ATTRIBUTE_POSITION)
            .and_then(|values| values.as_float3())
            .expect("positions");
        let normals = mesh
            .attribute(Mesh::ATTRIBUTE_NORMAL)
            .and_then(|values| values.as_float3())
            .expect("normals");
        let indices: Vec<usize> = mesh.indices().expect("indices").iter().collect();
        for triangle in indices.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|k| Vec3::from(positions[triangle[k]]));
            let mean: Vec3 = triangle.iter().map(|&k| Vec3::from(normals[k])).sum();
            assert!(
                (b - a).cross(c - a).dot(mean) > 0.0,
                "triangle {triangle:?}"
            );
        }
    }
}
