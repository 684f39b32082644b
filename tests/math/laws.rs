//! Laws of reflection and of the oblique near plane, on random planes, cameras and projections.

use bevy_planar_mirror::math::*;
use glam::{DAffine3, DMat4, DVec2, DVec3, DVec4};
use proptest::prelude::*;

use crate::random::*;

/// The largest coordinate, which scales every rounding.
fn size(points: &[DVec3]) -> f64 {
    points
        .iter()
        .fold(1.0, |size, p| size.max(p.abs().max_element()))
}

proptest! {
    #![proptest_config(cases(1))]

    #[test]
    fn reflecting_twice_is_identity(plane in any_plane(), p in any_point(1e3)) {
        let back = reflect_point(&plane, reflect_point(&plane, p));
        // The normal's own rounding moves a point by its distance from the plane.
        let allowed = 16.0 * f64::EPSILON * (p.length() + plane.origin.length());
        prop_assert!(back.abs_diff_eq(p, allowed), "{plane:?}: {p} came back as {back}");

        let direction = reflect_vector(plane.normal, reflect_vector(plane.normal, p));
        prop_assert!(direction.abs_diff_eq(p, allowed), "{plane:?}: {p} came back as {direction}");

        let twice = reflection_affine(&plane) * reflection_affine(&plane);
        let allowed = 48.0 * f64::EPSILON * size(&[plane.origin]);
        prop_assert!(twice.abs_diff_eq(DAffine3::IDENTITY, allowed), "{plane:?}: {twice:?}");
    }

    #[test]
    fn points_of_the_plane_stay(plane in any_plane(), p in any_point(1e3)) {
        let on_plane = p - plane.normal * plane.signed_distance(p);
        let moved = reflect_point(&plane, on_plane);
        let allowed = 1e-15 * 8.0 * size(&[p, plane.origin]);
        prop_assert!(moved.abs_diff_eq(on_plane, allowed), "{plane:?}: {on_plane} went to {moved}");
    }

    #[test]
    fn only_the_sign_of_the_distance_changes(plane in any_plane(), p in any_point(1e3)) {
        let before = plane.signed_distance(p);
        let after = plane.signed_distance(reflect_point(&plane, p));
        let allowed = 1e-15 * 16.0 * size(&[p, plane.origin]);
        prop_assert!((before + after).abs() <= allowed, "{plane:?}: {before} became {after}");
        let covector = plane.covector().dot(p.extend(1.0));
        prop_assert!((before - covector).abs() <= allowed, "{plane:?}: {before} or {covector}");
    }

    #[test]
    fn reflection_has_determinant_minus_one(plane in any_plane()) {
        let determinant = reflection_affine(&plane).matrix3.determinant();
        prop_assert!((determinant + 1.0).abs() <= 1e-15 * 8.0, "{plane:?}: {determinant}");
    }

    #[test]
    fn the_matrix_reflects_as_the_point_form(plane in any_plane(), p in any_point(1e3)) {
        let (point, matrix) = (
            reflect_point(&plane, p),
            reflection_affine(&plane).transform_point3(p),
        );
        let allowed = 1e-15 * 32.0 * size(&[p, plane.origin]);
        prop_assert!(point.abs_diff_eq(matrix, allowed), "{plane:?}: {point} or {matrix}");
    }

    #[test]
    fn the_reflected_camera_sees_the_mirror_where_the_camera_does(input in any_scene()) {
        let reflected = reflected_world_from_view(&input.plane, &input.world_from_view);
        prop_assert!(reflected.matrix3.determinant() < 0.0, "{reflected:?}");
        let corners = input.corners.expect("with bounds");
        for corner in corners {
            let at = |camera: &DAffine3| {
                camera.matrix3.inverse() * (corner - camera.translation)
            };
            let (direct, mirrored) = (at(&input.world_from_view), at(&reflected));
            let allowed = 1e-14 * size(&[direct, corner, input.plane.origin]);
            prop_assert!(
                direct.abs_diff_eq(mirrored, allowed),
                "{corner} is at {direct}, reflected at {mirrored}"
            );
        }
    }

    #[test]
    fn the_view_plane_measures_the_distance_of_the_real_point(
        input in any_scene(),
        p in any_point(10.0),
    ) {
        let c = plane_in_reflected_view(&input.plane, &input.world_from_view);
        let reflected = reflected_world_from_view(&input.plane, &input.world_from_view);
        let in_view = reflected.matrix3.inverse() * (p - reflected.translation);
        let (measured, real) = (c.dot(in_view.extend(1.0)), input.plane.signed_distance(p));
        let allowed = 1e-14 * size(&[in_view, p, input.plane.origin]) * 4.0;
        prop_assert!((measured - real).abs() <= allowed, "{measured} instead of {real}");
    }

    #[test]
    fn points_of_the_plane_land_on_depth_one(
        clip_from_view in any_projection(),
        plane in any_plane(),
        p in any_point(10.0),
        k in 1e-3..1e3_f64,
    ) {
        let c = plane.covector();
        let oblique = with_oblique_near_plane(&clip_from_view, c, k);
        for row in [0, 1, 3] {
            prop_assert_eq!(oblique.row(row), clip_from_view.row(row));
        }
        let near = plane.origin + p - plane.normal * plane.normal.dot(p);
        let clip = oblique * near.extend(1.0);
        let terms = (c * k * near.extend(1.0)).abs().element_sum() + clip.w.abs();
        let allowed = 1e-14 * terms;
        prop_assert!((clip.z - clip.w).abs() <= allowed, "{near} is at {clip}");

        let step = plane.normal * 0.5;
        let (front, back) = (
            oblique * (near + step).extend(1.0),
            oblique * (near - step).extend(1.0),
        );
        prop_assert!(front.z < front.w + allowed, "in front, but clipped: {front}");
        prop_assert!(back.z > back.w - allowed, "behind, but kept: {back}");
    }

    #[test]
    fn the_fitted_row_is_the_plain_one(input in any_scene()) {
        let Ok(plan) = plan_reflected_view(&input) else {
            return Ok(());
        };
        let plain = with_oblique_near_plane(&input.clip_from_view, plan.plane_view, plan.k);
        let difference = (plain.row(2) - plan.clip_from_view_oblique.row(2)).abs().max_element();
        let allowed = 1e-14 * (1.0 + plan.k) * (1.0 + plan.plane_view.abs().max_element());
        prop_assert!(difference <= allowed, "{:?} or {:?}", plain, plan.clip_from_view_oblique);
    }

    #[test]
    fn the_mirror_is_where_the_effective_near_distance_is(input in any_scene()) {
        let Ok(plan) = plan_reflected_view(&input) else {
            return Ok(());
        };
        let projection = BaseProjection::new(&input.clip_from_view).expect("invertible");
        // Only an infinite perspective has its far end at no depth.
        prop_assume!(projection.depth_is_w && input.clip_from_view.z_axis.z == 0.0);
        let reach = plane_reach(&projection, plan.plane_view, plan.polygon.ndc());
        let near = plan.eye_height / reach.f_max;
        let allowed = 1e-12 * plan.w_min * (1.0 + size(&[input.plane.origin]) / plan.eye_height);
        prop_assert!((near - plan.w_min).abs() <= allowed, "{near} instead of {}", plan.w_min);
    }

    #[test]
    fn a_box_reaches_as_far_as_its_corners(
        plane in any_plane(),
        center in any_point(10.0),
        axes in [any_point(2.0), any_point(2.0), any_point(2.0)],
    ) {
        let (low, high) = signed_distance_range(&plane, center, axes);
        let distances = (0..8).map(|corner| {
            let half = |axis: usize| axes[axis] * if corner >> axis & 1 == 1 { 1.0 } else { -1.0 };
            plane.signed_distance(center + half(0) + half(1) + half(2))
        });
        let least = distances.clone().fold(f64::INFINITY, f64::min);
        let greatest = distances.fold(f64::NEG_INFINITY, f64::max);
        let allowed = 1e-15 * 64.0 * size(&[center, plane.origin]);
        prop_assert!((low - least).abs() <= allowed, "{low} instead of {least}");
        prop_assert!((high - greatest).abs() <= allowed, "{high} instead of {greatest}");
        let side = classify((low, high), 0.0);
        let expected = match (least < -allowed, greatest > allowed) {
            (true, false) => Some(Side::Behind),
            (false, true) => (least > allowed).then_some(Side::InFront),
            (true, true) => Some(Side::Straddling),
            (false, false) => None,
        };
        if let Some(expected) = expected {
            prop_assert_eq!(side, expected);
        }
    }

    #[test]
    fn narrowed_sides_hold_what_the_polygon_shows(
        input in any_scene(),
        weights in any_weights(),
        w in 0.1..100.0_f64,
    ) {
        let Ok(plan) = plan_reflected_view(&input) else {
            return Ok(());
        };
        let sides = narrowed_sides(plan.polygon.ndc_bounds(), &input.clip_from_view, input.viewport_size);
        let p = inside(&plan.polygon, weights);
        let projection = BaseProjection::new(&input.clip_from_view).expect("invertible");
        let view = projection.view_from_clip * DVec4::new(p.x, p.y, 0.5 / w, 1.0);
        let view = view / view.w;
        for (name, side) in ["left", "right", "bottom", "top"].iter().zip(sides) {
            prop_assert!((side.truncate().length() - 1.0).abs() < 1e-12, "{name}: {side}");
            // The same view point counts as seen while it is in front of the eye.
            if (input.clip_from_view * view).w > 0.0 {
                let allowed = 1e-12 * (1.0 + view.truncate().length());
                prop_assert!(side.dot(view) >= -allowed, "{name}: {view} is outside of {side}");
            }
        }
    }

    #[test]
    fn edge_sides_hold_what_the_polygon_shows_and_little_more(
        input in any_scene(),
        weights in any_weights(),
        w in 0.1..100.0_f64,
        edge in 0..12_usize,
    ) {
        let Ok(plan) = plan_reflected_view(&input) else {
            return Ok(());
        };
        let sides: Vec<_> =
            edge_sides(&plan.polygon, &input.clip_from_view, input.viewport_size).collect();
        prop_assert!(sides.len() >= 3);
        let projection = BaseProjection::new(&input.clip_from_view).expect("invertible");
        let view = |p: DVec2| {
            let view = projection.view_from_clip * DVec4::new(p.x, p.y, 0.5 / w, 1.0);
            view / view.w
        };
        let seen = view(inside(&plan.polygon, weights));
        let is_in_front = |view: DVec4| (input.clip_from_view * view).w > 0.0;
        if is_in_front(seen) {
            for side in &sides {
                prop_assert!(side.dot(seen) >= 0.0, "{seen} is outside of {side}");
            }
        }
        // Five pixels beside the middle of an edge nothing is left.
        let corners: Vec<_> = plan.polygon.ndc().collect();
        let (a, b) = (corners[edge % corners.len()], corners[(edge + 1) % corners.len()]);
        let pixels = input.viewport_size * 0.5;
        let center = corners.iter().sum::<DVec2>() / corners.len() as f64;
        let outwards = ((b - a) * pixels).perp();
        let middle = a.midpoint(b);
        let outwards = outwards * outwards.dot((middle - center) * pixels).signum();
        let beside = view(middle + outwards.normalize_or_zero() * 5.0 / pixels);
        if outwards != DVec2::ZERO && is_in_front(beside) {
            prop_assert!(sides.iter().any(|side| side.dot(beside) < 0.0), "{beside} is inside");
        }
    }

    #[test]
    fn a_plane_in_clip_space_is_the_plane(
        clip_from_view in any_projection(),
        plane in any_plane(),
        p in any_point(100.0),
    ) {
        let c = plane.covector();
        let plane_clip = plane_in_clip(c, &clip_from_view).expect("invertible");
        let clip = clip_from_view * p.extend(1.0);
        let (in_view, in_clip) = (c.dot(p.extend(1.0)), plane_clip.dot(clip));
        let inverse = DMat4::from_cols_array(
            &clip_from_view.inverse().to_cols_array().map(f64::abs),
        );
        let terms = c.abs().dot(inverse * clip.abs());
        prop_assert!((in_view - in_clip).abs() <= 1e-14 * terms, "{in_clip} is not {in_view}");
    }
}
