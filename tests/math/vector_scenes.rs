//! The scenes of the reference vectors: camera, mirror, projection and points in the world.

use bevy_planar_mirror::math::*;
use glam::{DMat4, DVec2, DVec3};

use crate::{reference::*, support::*};

/// What evaluation in `f64` may lose.
const F64: f64 = 1e-14;

/// The scenes that the plan leaves out although their geometry can be drawn.
const SKIPPED: [(&str, Skip); 7] = [
    ("scene: floor 2..8 m ahead, level, h=1e-05", Skip::TooThin),
    (
        "scene: floor 2..8 m, pitch -7 roll 11, h=1e-06",
        Skip::EyeBehind,
    ),
    (
        "scene: floor 2..8 m, pitch -7 roll 11, h=1e-05",
        Skip::TooThin,
    ),
    (
        "scene: floor 2..8 m, pitch -7 roll 11, h=0.0001",
        Skip::TooThin,
    ),
    (
        "scene: floor 2..8 m, pitch -7 roll 11, h=0.001",
        Skip::TooThin,
    ),
    (
        "scene: oblique world plane off origin, h=1e-06",
        Skip::EyeBehind,
    ),
    ("scene: ortho grazing 89.9", Skip::TooThin),
];

#[test]
fn scene_verdicts() {
    for case in vectors().scene {
        let expected = match case.verdict.as_str() {
            "eye_not_in_front" => Err(Skip::EyeBehind),
            "not_in_view" => Err(Skip::OutOfView),
            _ => SKIPPED
                .iter()
                .find(|(name, _)| *name == case.name)
                .map_or(Ok(()), |(_, skip)| Err(*skip)),
        };
        let actual = plan_reflected_view(&case.input()).map(|_| ());
        assert_eq!(actual, expected, "{}", case.name);
    }
}

#[test]
fn scene_cameras() {
    let mut normal = Worst::of("scene: normal");
    let mut height = Worst::of("scene: eye height");
    let mut plane_view = Worst::of("scene: plane in the reflected view");
    let mut camera = Worst::of("scene: reflected camera");
    for case in vectors().scene {
        let name = &case.name;
        let ViewInput {
            plane,
            world_from_view,
            ..
        } = case.input();
        let away = world_from_view.translation.distance(plane.origin);
        normal.check_within(name, &plane.normal.to_array(), &case.unit_normal, F64);
        let h = plane.signed_distance(world_from_view.translation);
        height.check(name, h, case.eye_height, F64 * away);
        let c = plane_in_reflected_view(&plane, &world_from_view);
        let scale = world_from_view.matrix3.x_axis.length();
        plane_view.check_within(name, &c.to_array()[..3], &case.plane_view[..3], F64 * scale);
        plane_view.check(name, c.w, case.plane_view[3], F64 * away);
        let reflected = DMat4::from(reflected_world_from_view(&plane, &world_from_view));
        for (row, expected) in case.mirrored_camera_rows.iter().enumerate() {
            let actual = reflected.row(row).to_array();
            camera.check_within(name, &actual[..3], &expected[..3], F64 * scale);
            let size = world_from_view.translation.length().max(away);
            camera.check(name, actual[3], expected[3], F64 * size);
        }
    }
}

#[test]
fn scene_projections() {
    let mut bounds = Worst::of("scene: region");
    let mut factor = Worst::of("scene: k");
    let mut depth = Worst::of("scene: w_min");
    let mut rows = Worst::of("scene: depth rows");
    let mut bound = Worst::of("scene: noise and margin");
    for case in vectors().scene {
        let Some(expected) = &case.drawn else {
            continue;
        };
        let name = &case.name;
        let input = case.input();
        let projection = BaseProjection::new(&input.clip_from_view).expect(name);
        let c = plane_in_reflected_view(&input.plane, &input.world_from_view);
        let h = case.eye_height;
        let relative = relative_to_height(&input, h);

        let full = plane_reach(&projection, c, VisiblePolygon::full_view().ndc());
        let k_full = oblique_k(&full, 0.0).expect(name);
        factor.check(name, k_full, expected.k_full, F64 * 10.0 * expected.k_full);
        let row = fitted_depth_row(&input.clip_from_view, c, k_full, &full, 0.0);
        rows.check_all(name, &row.to_array(), &expected.row3_full, F64 * 10.0);
        check_rounded_row(name, row, expected.row3_full);

        let polygon = visible(&input);
        let (low, high) = polygon.ndc_bounds();
        bounds.check_within(name, &low.to_array(), &expected.region_ndc_min, 1e-11);
        bounds.check_within(name, &high.to_array(), &expected.region_ndc_max, 1e-11);
        for p in &expected.region_ndc {
            let nearest = polygon.ndc().map(|q| q.distance(DVec2::from(*p)));
            bounds.check(name, nearest.fold(f64::INFINITY, f64::min), 0.0, 1e-11);
        }
        let region = plane_reach(&projection, c, polygon.ndc());
        let k = oblique_k(&region, 0.0).expect(name);
        factor.check(name, k, expected.k_region, relative * expected.k_region);
        let row = fitted_depth_row(&input.clip_from_view, c, k, &region, 0.0);
        rows.check_all(name, &row.to_array(), &expected.row3_region, relative);
        check_rounded_row(name, row, expected.row3_region);

        if let (Some(w_min), Some(noise_n), Some(margin_m)) = (case.w_min, case.noise, case.margin)
        {
            let actual = polygon.w_min().expect(name);
            depth.check(name, actual, w_min, relative * w_min);
            depth.check(name, k * h, w_min, relative * w_min);
            let world = input.world_from_view.translation.length() + input.plane.origin.length();
            // The file takes half the way to the eye and half that to the mirror.
            let n = noise(&projection, polygon.ndc(), 0.5 * world, actual, k);
            bound.check(name, n, noise_n, relative * noise_n);
            bound.check(name, margin(n), margin_m, relative * margin_m);
        }
    }
}

/// The terms of the height are as large as the coordinates, and so is their rounding.
fn relative_to_height(input: &ViewInput, h: f64) -> f64 {
    let world = input.world_from_view.translation.length() + input.plane.origin.length();
    if h < 1e-5 {
        1e-9
    } else {
        F64 + f64::EPSILON * 4.0 * world / h
    }
}

/// The visible polygon alone, of scenes that the plan skips, too.
fn visible(input: &ViewInput) -> VisiblePolygon {
    let view_from_world = input.world_from_view.matrix3.inverse();
    let corners = input.corners.expect("the scenes have bounds");
    clip_polygon(&corners.map(|corner| {
        let p = view_from_world * (corner - input.world_from_view.translation);
        input.clip_from_view * p.extend(1.0)
    }))
}

#[test]
fn scene_points() {
    let mut matrices = Worst::of("scene: clip_from_world");
    let mut clips = Worst::of("scene: clip positions");
    let mut depths = Worst::of("scene: depth in f32, of the bound");
    let mut cuts = Worst::of("scene: cut in f32, of the bound");
    for case in vectors().scene {
        let Some(expected) = &case.drawn else {
            continue;
        };
        let name = &case.name;
        let input = case.input();
        let projection = BaseProjection::new(&input.clip_from_view).expect(name);
        let c = plane_in_reflected_view(&input.plane, &input.world_from_view);
        let reach = plane_reach(&projection, c, visible(&input).ndc());
        let k = oblique_k(&reach, 0.0).expect(name);
        let row = fitted_depth_row(&input.clip_from_view, c, k, &reach, 0.0);
        let clip_from_view = with_depth_row(&input.clip_from_view, row);
        let world_from_view = reflected_world_from_view(&input.plane, &input.world_from_view);
        let clip_from_world = clip_from_view * DMat4::from(world_from_view.inverse());
        let relative = 10.0 * relative_to_height(&input, case.eye_height);
        for (row, expected) in expected.clip_from_world_region_rows.iter().enumerate() {
            let actual = clip_from_world.row(row).to_array();
            let largest = expected.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            // The last column cancels by as much as the eye is away.
            let eye = world_from_view.translation.length();
            let allowed = relative * largest + F64 * eye;
            matrices.check_within(name, &actual, expected, allowed);
        }
        // As the engine does it: inverted and multiplied in f32.
        let clip_from_world_f32 =
            clip_from_view.as_mat4() * glam::Mat4::from(world_from_view.as_affine3a()).inverse();
        for point in &expected.points {
            let p = DVec3::from(point.p_world);
            let distance = input.plane.signed_distance(p);
            let size = p.distance(input.plane.origin).max(1.0);
            clips.check(name, distance, point.signed_distance, F64 * 10.0 * size);
            let view = world_from_view
                .matrix3
                .inverse()
                .mul_vec3(p - world_from_view.translation);
            let clip = clip_from_view * view.extend(1.0);
            let terms = (row * view.extend(1.0)).abs().element_sum().max(size);
            clips.check_within(name, &clip.to_array(), &point.clip, relative * terms);
            let off_plane = point.signed_distance.abs() > 1e-9 * size;
            if off_plane && clip.w > 0.0 {
                assert_eq!(clip.z <= clip.w, point.kept, "{name}: {p} is at {clip}");
            }
            let (Some(n), true) = (case.noise, clip.w > 0.0) else {
                continue;
            };
            let drawn = (clip_from_world_f32 * p.as_vec3().extend(1.0)).as_dvec4();
            let cut = (drawn.w - drawn.z) / k;
            let allowed = clip_plane_error(n, k, clip.w);
            cuts.check(name, cut, point.signed_distance, allowed);
            if point.kept {
                // The file allows half of ours.
                let allowed = 0.5 * depth_error(n);
                depths.check(name, drawn.z / drawn.w, point.depth, allowed);
            }
        }
    }
}
