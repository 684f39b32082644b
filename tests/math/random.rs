//! Random planes, cameras and scenes.

use bevy_planar_mirror::math::{Plane, ViewInput, VisiblePolygon, transform_patch};
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec2, DVec3};
use proptest::prelude::*;

use crate::{extremes::patch, reference::matrix};

/// As many cases as usual, times `factor`. What fails is printed, and belongs in a named test.
pub fn cases(factor: u32) -> ProptestConfig {
    let usual = ProptestConfig::default();
    ProptestConfig {
        cases: usual.cases.saturating_mul(factor),
        failure_persistence: None,
        max_global_rejects: u32::MAX,
        ..usual
    }
}

/// Exactly an `f32`, as every input of the engine is.
pub fn single(x: f64) -> f64 {
    f64::from(x as f32)
}

pub fn any_direction() -> impl Strategy<Value = DVec3> {
    (-1.0..1.0_f64, 0.0..core::f64::consts::TAU).prop_map(|(z, turn)| {
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * turn.cos(), r * turn.sin(), z)
    })
}

pub fn any_point(reach: f64) -> impl Strategy<Value = DVec3> {
    [-reach..reach, -reach..reach, -reach..reach]
        .prop_map(|[x, y, z]| DVec3::new(single(x), single(y), single(z)))
}

pub fn any_plane() -> impl Strategy<Value = Plane> {
    (any_point(1e3), any_direction()).prop_filter_map("no direction", |(origin, normal)| {
        Plane::new(origin, normal)
    })
}

pub fn any_rotation() -> impl Strategy<Value = DQuat> {
    (any_direction(), 0.0..core::f64::consts::TAU)
        .prop_map(|(axis, angle)| DQuat::from_axis_angle(axis.normalize(), angle))
}

/// A projection of any kind, rounded to `f32`.
pub fn any_projection() -> impl Strategy<Value = DMat4> {
    let half_height = (0.05_f64..1.4).prop_map(f64::tan);
    (
        half_height,
        0.3..3.0_f64,
        0.01..1.0_f64,
        50.0..2000.0_f64,
        0..4_usize,
    )
        .prop_map(|(half_height, aspect, near, far, kind)| {
            let (sx, sy) = (1.0 / (half_height * aspect), 1.0 / half_height);
            let span = far - near;
            let rows = match kind {
                0 => perspective_rows(sx, sy, 0.0, 0.0, 0.0, near),
                1 => perspective_rows(sx, sy, 0.0, 0.0, near / span, near * far / span),
                2 => perspective_rows(sx, sy, 0.7, -0.3, 0.0, near),
                _ => [
                    [0.1 * sx, 0.0, 0.0, 0.2],
                    [0.0, 0.1 * sy, 0.0, -0.1],
                    [0.0, 0.0, 1.0 / span, far / span],
                    [0.0, 0.0, 0.0, 1.0],
                ],
            };
            matrix(rows.map(|row| row.map(single)))
        })
}

pub fn perspective_rows(sx: f64, sy: f64, a: f64, b: f64, p: f64, q: f64) -> [[f64; 4]; 4] {
    [
        [sx, 0.0, a, 0.0],
        [0.0, sy, b, 0.0],
        [0.0, 0.0, p, q],
        [0.0, 0.0, -1.0, 0.0],
    ]
}

/// A camera near a mirror and mostly looking at it, everything rounded to `f32`.
pub fn any_scene() -> impl Strategy<Value = ViewInput> {
    (
        any_projection(),
        (any_rotation(), any_point(1.0), 0.0..3.0_f64),
        (0.1..5.0_f64, 0.1..5.0_f64, 0.1..2.0_f64),
        (any_direction(), -3.0..1.5_f64, any_direction()),
    )
        .prop_map(|(clip_from_view, place, (x, y, scale), eye)| {
            let (turn, at, far_off) = place;
            let (eye_direction, log_distance, wobble) = eye;
            let origin = at * 10.0_f64.powf(far_off);
            let axes = DMat3::from_quat(turn);
            let mirror = DAffine3::from_mat3_translation(axes * scale, origin);
            let mirror = rounded(mirror);
            let patch = patch(DVec2::new(x, y));
            let (plane, corners) = transform_patch(&patch, &mirror).expect("a proper transform");
            let eye = origin + eye_direction * 10.0_f64.powf(log_distance) * 3.0;
            let toward = (origin - eye).normalize() + wobble * 0.5;
            let z = -toward.normalize();
            let x = z.any_orthonormal_vector();
            let camera = DAffine3 {
                matrix3: DMat3::from_cols(x, z.cross(x), z),
                translation: eye,
            };
            ViewInput {
                world_from_view: rounded(camera),
                clip_from_view,
                viewport_size: DVec2::new(1920.0, 1080.0),
                plane,
                corners,
                jitter_px: 0.0,
                was_drawn: false,
            }
        })
}

pub fn rounded(affine: DAffine3) -> DAffine3 {
    affine.as_affine3a().as_daffine3()
}

/// A vertex of the polygon, and how far to go from there to another one.
pub fn any_weights() -> impl Strategy<Value = [f64; 3]> {
    let share = prop_oneof![Just(0.0), 0.0..1.0_f64];
    (0.0..1.0_f64, 0.0..1.0_f64, share).prop_map(|(a, b, t)| [a, b, t])
}

/// A point of the polygon on the screen; its vertices, which see the farthest, often.
pub fn inside(polygon: &VisiblePolygon, [a, b, t]: [f64; 3]) -> DVec2 {
    let points: Vec<_> = polygon.ndc().collect();
    let pick = |share: f64| points[(share * points.len() as f64) as usize % points.len()];
    pick(a).lerp(pick(b), t)
}
