//! Plans for the cases that have gone wrong elsewhere, each by name.

use bevy_planar_mirror::math::*;
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec2, DVec3, DVec4};

use crate::{random::perspective_rows, reference::matrix};

/// 90 degrees wide and high, near distance 0.1, 1000 x 1000 pixels, at `eye`, looking along -Z.
/// The mirror is 2 x 2 in the plane z = 0 and faces +Z.
fn square_on(eye: DVec3) -> ViewInput {
    let patch = PlanarPatch {
        center: DVec3::ZERO,
        tangent_x: DVec3::X,
        tangent_y: DVec3::Y,
        half_size: DVec2::ONE,
    };
    let (plane, corners) = transform_patch(&patch, &DAffine3::IDENTITY).expect("a plane");
    ViewInput {
        world_from_view: DAffine3::from_translation(eye),
        clip_from_view: matrix(perspective_rows(1.0, 1.0, 0.0, 0.0, 0.0, 0.1)),
        viewport_size: DVec2::splat(1000.0),
        plane,
        corners,
        jitter_px: 0.0,
        was_drawn: false,
    }
}

fn turned(mut input: ViewInput, turn: DQuat) -> ViewInput {
    input.world_from_view.matrix3 = DMat3::from_quat(turn);
    input
}

fn orthographic(mut input: ViewInput) -> ViewInput {
    input.clip_from_view = matrix([
        [0.25, 0.0, 0.0, 0.0],
        [0.0, 0.25, 0.0, 0.0],
        [0.0, 0.0, 0.01, 1.0],
        [0.0, 0.0, 0.0, 1.0],
    ]);
    input
}

fn skip(input: &ViewInput) -> Option<Skip> {
    plan_reflected_view(input).err()
}

/// The depth at which the planned projection draws a real point.
fn depth(plan: &ReflectedViewPlan, p: DVec3) -> f64 {
    let view = plan.world_from_view.inverse().transform_point3(p);
    let clip = plan.clip_from_view_oblique * view.extend(1.0);
    clip.z / clip.w
}

#[test]
fn straight_at_the_mirror_still_clips() {
    let plan = plan_reflected_view(&square_on(DVec3::Z * 5.0)).expect("seen");
    assert_eq!(plan.plane_view, DVec4::new(0.0, 0.0, -1.0, -5.0));
    let on = depth(&plan, DVec3::ZERO);
    assert!((on - 1.0).abs() < 1e-12, "{on}");
    assert!(depth(&plan, DVec3::new(0.3, 0.0, -0.01)) > 1.0);
    let in_front = depth(&plan, DVec3::new(0.3, 0.0, 0.01));
    assert!(in_front < 1.0 && in_front > 0.9, "{in_front}");
}

#[test]
fn eye_in_or_behind_the_plane_sees_nothing() {
    for z in [0.0, -0.0, 1e-9, -1e-9, -5.0] {
        let input = square_on(DVec3::new(0.5, 0.0, z));
        assert_eq!(skip(&input), Some(Skip::EyeBehind), "{z}");
    }
}

#[test]
fn looking_away_sees_nothing() {
    let away = turned(
        square_on(DVec3::Z * 5.0),
        DQuat::from_rotation_y(core::f64::consts::PI),
    );
    assert_eq!(skip(&away), Some(Skip::OutOfView));
    let unbounded = ViewInput {
        corners: None,
        ..away
    };
    assert_eq!(skip(&unbounded), Some(Skip::OutOfView));
}

#[test]
fn parallel_to_the_edge_of_the_view_is_no_division_by_zero() {
    // 45 degrees away at 90 degrees of view: the outermost ray never meets the plane.
    let half = core::f64::consts::FRAC_1_SQRT_2;
    let mut input = square_on(DVec3::Z * 5.0);
    let forward = DVec3::new(half, 0.0, half);
    let z = -forward;
    input.world_from_view.matrix3 = DMat3::from_cols(DVec3::Y.cross(z), DVec3::Y, z);
    for corners in [input.corners, None] {
        let input = ViewInput { corners, ..input };
        let result = plan_reflected_view(&input);
        assert!(
            matches!(result, Err(Skip::OutOfView | Skip::BelowPrecision)),
            "{result:?}"
        );
    }
}

#[test]
fn thin_on_the_screen_is_left_out() {
    // On edge from 5 m away, 0.9 mm over the plane of a mirror of 2 m: 0.07 pixels.
    let eye = DVec3::new(-5.0, 0.0, 9e-4);
    let grazing = turned(
        square_on(eye),
        DQuat::from_rotation_y(-core::f64::consts::FRAC_PI_2),
    );
    assert_eq!(skip(&grazing), Some(Skip::TooThin));
}

#[test]
fn orthographic_is_cut_too_and_needs_no_eye_in_front() {
    let plan = plan_reflected_view(&orthographic(square_on(DVec3::Z * 5.0))).expect("seen");
    let on = depth(&plan, DVec3::ZERO);
    assert!((on - 1.0).abs() < 1e-12, "{on}");
    assert!(depth(&plan, DVec3::Z * -0.01) > 1.0);
    assert!(depth(&plan, DVec3::Z * 50.0) > 0.0);
    assert_eq!(plan.w_min, 1.0);

    // The near plane may lie behind the eye, so that the eye is behind a mirror in full view.
    let mut behind = orthographic(square_on(DVec3::Z * -5.0));
    behind.clip_from_view.w_axis.z = 0.9;
    let plan = plan_reflected_view(&behind).expect("seen");
    assert!(
        plan.eye_height < 0.0 && plan.ghost_tolerance(1.0, false) > 0.0,
        "{plan:?}"
    );

    let along = turned(
        orthographic(square_on(DVec3::Z * 5.0)),
        DQuat::from_rotation_y(core::f64::consts::FRAC_PI_2 * 1.01),
    );
    assert_eq!(skip(&along), Some(Skip::EyeBehind));
}

#[test]
fn without_bounds_the_whole_view_is_the_region() {
    let bounded = square_on(DVec3::Z * 5.0);
    let input = ViewInput {
        corners: None,
        ..turned(bounded, DQuat::from_rotation_y(0.3))
    };
    let plan = plan_reflected_view(&input).expect("seen");
    assert_eq!(plan.polygon, VisiblePolygon::full_view());
    // The nearest point of the plane in view, on the ray at the left or right edge.
    let expected = 5.0 / (0.3_f64.cos() + 0.3_f64.sin());
    assert!(
        (plan.w_min - expected).abs() < 1e-12,
        "{} {expected}",
        plan.w_min
    );
    let on = depth(&plan, DVec3::new(0.5, 0.5, 0.0));
    assert!((on - 1.0).abs() < 1e-12, "{on}");
}

#[test]
fn without_bounds_the_plane_begins_where_it_enters_the_view() {
    let unbounded = |input| ViewInput {
        corners: None,
        ..input
    };
    // Straight at the plane, which is 3 away, and the far plane 15.
    let mut input = unbounded(square_on(DVec3::Z * 3.0));
    let (near, far) = (0.1, 15.0);
    input.clip_from_view.z_axis.z = near / (far - near);
    input.clip_from_view.w_axis.z = near * far / (far - near);
    let w_min = plan_reflected_view(&input).expect("seen").w_min;
    assert!((w_min - 3.0).abs() < 1e-12, "{w_min}");

    // Along a floor that is 5 below: it enters the view through its lower edge, at 45 degrees; a
    // near plane that is farther away than that cuts it first.
    let level = DQuat::from_rotation_arc(DVec3::NEG_Z, DVec3::Y);
    for (near, expected) in [(0.1, 5.0), (7.0, 7.0)] {
        let mut input = unbounded(turned(square_on(DVec3::Z * 5.0), level));
        input.clip_from_view.w_axis.z = near;
        let w_min = plan_reflected_view(&input).expect("seen").w_min;
        assert!((w_min - expected).abs() < 1e-12, "{w_min} {expected}");
    }
}

#[test]
fn scaled_cameras_measure_in_world_units() {
    let mut input = square_on(DVec3::Z * 5.0);
    input.world_from_view.matrix3 = DMat3::from_diagonal(DVec3::splat(2.0));
    let plan = plan_reflected_view(&input).expect("seen");
    let on = depth(&plan, DVec3::ZERO);
    assert!((on - 1.0).abs() < 1e-12, "{on}");
    assert_eq!((plan.eye_height, plan.w_min), (5.0, 2.5));
    let unscaled = plan_reflected_view(&square_on(DVec3::Z * 5.0)).expect("seen");
    // The same size at the same distance, of which w is half.
    let [scaled, unscaled] =
        [(plan, 2.5), (unscaled, 5.0)].map(|(plan, w)| plan.ghost_tolerance(w, false));
    assert!((scaled - unscaled).abs() < 1e-15, "{scaled} {unscaled}");
}

#[test]
fn far_from_the_origin_the_plane_is_lost() {
    let at = |offset: f64| {
        let mut input = square_on(DVec3::new(offset, 0.0, 5.0));
        input.plane.origin.x += offset;
        input.corners = input.corners.map(|c| c.map(|p| p + DVec3::X * offset));
        input
    };
    for (offset, expected) in [
        (0.0, None),
        (1e4, None),
        (1e6, None),
        (5e6, Some(Skip::BelowPrecision)),
        (1e8, Some(Skip::EyeBehind)),
    ] {
        assert_eq!(skip(&at(offset)), expected, "{offset}");
    }
}

#[test]
fn a_jittered_camera_keeps_more_clear() {
    let input = turned(square_on(DVec3::Z * 5.0), DQuat::from_rotation_y(0.3));
    let jittered = ViewInput {
        jitter_px: 0.5,
        ..input
    };
    let (still, moving) = (plan_reflected_view(&input), plan_reflected_view(&jittered));
    let (still, moving) = (still.expect("seen"), moving.expect("seen"));
    assert!(
        moving.k < still.k && moving.k > 0.99 * still.k,
        "{} {}",
        moving.k,
        still.k
    );
}

#[test]
fn what_stands_on_a_floor_does_not_straddle() {
    let plan = plan_reflected_view(&square_on(DVec3::Z * 5.0)).expect("seen");
    // A quarter of a pixel of 2/1000 of the depth; the mirror's corner is a fifth of it to the
    // side and up, where depth counts as well.
    let at_mirror = plan.ghost_tolerance(5.0, false);
    let expected = 0.0025 / 1.08_f64.sqrt();
    assert!((at_mirror / expected - 1.0).abs() < 1e-3, "{at_mirror}");
    let around_the_eye = plan.ghost_tolerance(0.0, false);
    assert!(around_the_eye < at_mirror && around_the_eye > 0.999 * at_mirror);
    assert!(plan.ghost_tolerance(10.0, false) > at_mirror);
    assert_eq!(classify((-0.002, 1.0), at_mirror), Side::InFront);
    assert_eq!(classify((-0.003, 1.0), at_mirror), Side::Straddling);
    assert_eq!(classify((-1.0, 0.001), at_mirror), Side::Behind);
    assert_eq!(classify((-1.0, -0.5), at_mirror), Side::Behind);
    assert_eq!(classify((f64::NAN, f64::NAN), at_mirror), Side::Straddling);
}

#[test]
fn degenerate_input_is_named() {
    let good = square_on(DVec3::Z * 5.0);
    let mut flat_camera = good;
    flat_camera.world_from_view.matrix3 = DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0));
    let mut blind = good;
    blind.clip_from_view = DMat4::ZERO;
    let mut empty = good;
    empty.viewport_size = DVec2::new(0.0, 100.0);
    let mut unknown = good;
    unknown.world_from_view.translation.x = f64::NAN;
    let mut long_normal = good;
    long_normal.plane.normal *= 2.0;
    for input in [flat_camera, blind, empty, unknown, long_normal] {
        assert_eq!(skip(&input), Some(Skip::DegenerateView), "{input:?}");
    }
}

#[test]
fn collapsed_and_unlimited_patches() {
    let patch = PlanarPatch::from_point_and_normal(DVec3::ZERO, DVec3::Z * 3.0, None);
    let patch = patch.expect("a plane");
    assert_eq!(patch.half_size, DVec2::INFINITY);
    for scale in [
        DVec3::new(0.0, 1.0, 1.0),
        DVec3::ZERO,
        DVec3::new(1.0, f64::NAN, 1.0),
        DVec3::new(1.0, f64::INFINITY, 1.0),
    ] {
        assert_eq!(
            transform_patch(&patch, &DAffine3::from_scale(scale)),
            None,
            "{scale}"
        );
    }
    for scale in [
        DVec3::new(1.0, 1.0, 0.0),
        DVec3::new(1e-20, 1e-20, 1.0),
        DVec3::new(-1.0, 2.0, 3.0),
    ] {
        let (plane, corners) =
            transform_patch(&patch, &DAffine3::from_scale(scale)).expect("a plane");
        let sign = if scale.x < 0.0 && scale.z == 0.0 {
            -1.0
        } else {
            1.0
        };
        assert_eq!((plane.normal, corners), (DVec3::Z * sign, None), "{scale}");
    }
    let mirrored = DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0));
    let (plane, _) = transform_patch(&patch, &mirrored).expect("a plane");
    assert_eq!(plane.normal, DVec3::NEG_Z);

    assert_eq!(
        PlanarPatch::from_point_and_normal(DVec3::ZERO, DVec3::ZERO, None),
        None
    );
    assert_eq!(
        PlanarPatch::from_point_and_normal(DVec3::NAN, DVec3::Z, None),
        None
    );
    let bounds = Some((DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0)));
    let boxed = PlanarPatch::from_point_and_normal(DVec3::ZERO, DVec3::Z, bounds);
    let boxed = boxed.expect("a plane");
    assert_eq!(boxed.center, DVec3::new(1.0, 2.0, 0.0));
    assert_eq!(boxed.half_size, DVec2::new(4.0, 5.0));
}
