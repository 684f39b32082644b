//! The reference vectors as they stand in their file.

use bevy_planar_mirror::math::{PlanarPatch, Plane, ViewInput, transform_patch};
use glam::{DAffine3, DMat4, DVec2, DVec3};
use serde::Deserialize;

#[derive(Deserialize)]
pub struct Vectors {
    pub reflection: Vec<Reflection>,
    pub plane: Vec<PlaneCase>,
    pub matrix: Vec<MatrixCase>,
    pub scene: Vec<Scene>,
    pub resolution: Vec<Resolution>,
}

#[derive(Deserialize)]
pub struct Reflection {
    pub name: String,
    pub normal: [f64; 3],
    pub point_on_plane: [f64; 3],
    pub p: [f64; 3],
    pub unit_normal: [f64; 3],
    pub plane_d: f64,
    pub signed_distance: f64,
    pub reflected: [f64; 3],
    pub matrix_rows: [[f64; 4]; 4],
}

#[derive(Deserialize)]
pub struct PlaneCase {
    pub name: String,
    pub mirror_rows: [[f64; 4]; 3],
    pub eye: [f64; 3],
    pub unit_normal: [f64; 3],
    pub plane_d: f64,
    pub eye_height: f64,
    pub verdict: String,
}

#[derive(Deserialize)]
pub struct MatrixCase {
    pub name: String,
    pub base_rows: [[f64; 4]; 4],
    pub plane_view: [f64; 4],
    pub region_ndc: Option<Vec<[f64; 2]>>,
    pub plane_clip: [f64; 4],
    pub fmax: f64,
    pub corner_ndc: [f64; 2],
    pub verdict: String,
    pub k: Option<f64>,
    pub row3: Option<[f64; 4]>,
    #[serde(default)]
    pub points: Vec<ViewPoint>,
}

#[derive(Deserialize)]
pub struct ViewPoint {
    pub p_view: [f64; 3],
    pub clip: [f64; 4],
    pub depth: f64,
    pub plane_distance: f64,
    pub kept: bool,
}

#[derive(Deserialize)]
pub struct Scene {
    pub name: String,
    pub camera_rows: [[f64; 4]; 3],
    pub mirror_rows: [[f64; 4]; 3],
    pub mirror_half_extent: [f64; 2],
    pub base_rows: [[f64; 4]; 4],
    pub unit_normal: [f64; 3],
    pub eye_height: f64,
    pub plane_view: [f64; 4],
    pub mirrored_camera_rows: [[f64; 4]; 3],
    pub verdict: String,
    #[serde(flatten)]
    pub drawn: Option<DrawnScene>,
    pub w_min: Option<f64>,
    #[serde(rename = "noise_N")]
    pub noise: Option<f64>,
    pub margin: Option<f64>,
}

#[derive(Deserialize)]
pub struct DrawnScene {
    pub k_full: f64,
    pub k_region: f64,
    pub row3_full: [f64; 4],
    pub row3_region: [f64; 4],
    pub region_ndc: Vec<[f64; 2]>,
    pub region_ndc_min: [f64; 2],
    pub region_ndc_max: [f64; 2],
    pub clip_from_world_region_rows: [[f64; 4]; 4],
    pub points: Vec<WorldPoint>,
}

#[derive(Deserialize)]
pub struct WorldPoint {
    pub p_world: [f64; 3],
    pub signed_distance: f64,
    pub clip: [f64; 4],
    pub depth: f64,
    pub kept: bool,
}

#[derive(Deserialize)]
pub struct Resolution {
    pub name: String,
    pub k: f64,
    pub h: f64,
    pub s: f64,
    pub w: f64,
    pub w_plane: f64,
    pub depth: f64,
    pub depth_at_infinity: f64,
    pub ddepth_dw: f64,
    pub dw_for_2pow_minus_24: f64,
}

pub fn vectors() -> Vectors {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/data/oblique_vectors.json"
    );
    let text = std::fs::read_to_string(path).expect("the reference vectors are part of the crate");
    serde_json::from_str(&text).expect("the reference vectors have the documented fields")
}

impl Scene {
    pub fn plane_and_corners(&self) -> (Plane, [DVec3; 4]) {
        let patch = PlanarPatch {
            center: DVec3::ZERO,
            tangent_x: DVec3::X,
            tangent_y: DVec3::Y,
            half_size: self.mirror_half_extent.into(),
        };
        match transform_patch(&patch, &affine(self.mirror_rows)) {
            Some((plane, Some(corners))) => (plane, corners),
            other => panic!("{}: {other:?}", self.name),
        }
    }

    /// 1080 pixels high, square pixels.
    pub fn input(&self) -> ViewInput {
        let (plane, corners) = self.plane_and_corners();
        let base = matrix(self.base_rows);
        let aspect = base.y_axis.y / base.x_axis.x;
        ViewInput {
            world_from_view: affine(self.camera_rows),
            clip_from_view: base,
            viewport_size: DVec2::new(1080.0 * aspect, 1080.0),
            plane,
            corners: Some(corners),
            jitter_px: 0.0,
            was_drawn: false,
        }
    }
}

pub fn matrix(rows: [[f64; 4]; 4]) -> DMat4 {
    DMat4::from_cols_array_2d(&rows).transpose()
}

pub fn affine([x, y, z]: [[f64; 4]; 3]) -> DAffine3 {
    DAffine3::from_mat4(matrix([x, y, z, [0.0, 0.0, 0.0, 1.0]]))
}
