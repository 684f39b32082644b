//! The plan against what the engine and the device make of it in `f32`.

use bevy_planar_mirror::math::*;
use glam::{DAffine3, DVec3, DVec4, Mat4};
use proptest::prelude::*;

use crate::random::*;

/// The matrix of the vertex shader, as the engine computes it.
fn clip_from_world(plan: &ReflectedViewPlan) -> Mat4 {
    let world_from_view = Mat4::from(plan.world_from_view.as_affine3a());
    plan.clip_from_view_oblique.as_mat4() * world_from_view.inverse()
}

/// A visible point on the ray through a point of the polygon, `beyond` from 0 to 1 between the
/// mirror and far away, rounded to `f32`.
fn visible_point(
    input: &ViewInput,
    plan: &ReflectedViewPlan,
    weights: [f64; 3],
    beyond: f64,
) -> Option<(DVec3, f64)> {
    let projection = BaseProjection::new(&input.clip_from_view)?;
    let ndc = inside(&plan.polygon, weights);
    let plane_clip = projection.clip_covector(plan.plane_view);
    // On the mirror C^ . (x, y, z, 1) is 0, which gives the base depth there.
    let at_far = plane_clip.dot(ndc.extend(0.0).extend(1.0));
    let at_mirror = (-at_far / plane_clip.z).min(1.0);
    let depth = if projection.is_orthographic || input.clip_from_view.z_axis.z != 0.0 {
        at_mirror * (1.0 - beyond)
    } else {
        at_mirror * 10.0_f64.powf(-9.0 * beyond)
    };
    let view = projection.view_from_clip * DVec4::new(ndc.x, ndc.y, depth, 1.0);
    let view = view.truncate() / view.w;
    let world = plan
        .world_from_view
        .transform_point3(view)
        .as_vec3()
        .as_dvec3();
    let w = (input.clip_from_view * view.extend(1.0)).w;
    (world.is_finite() && w > 0.0).then_some((world, w))
}

proptest! {
    #![proptest_config(cases(16))]

    #[test]
    fn nothing_visible_is_lost_and_nothing_behind_is_drawn(
        input in any_scene(),
        weights in any_weights(),
        beyond in prop_oneof![Just(0.0), 0.0..1.0_f64, Just(1.0)],
        lift in -1.0..1.0_f64,
    ) {
        let Ok(plan) = plan_reflected_view(&input) else {
            return Ok(());
        };
        let Some((point, w)) = visible_point(&input, &plan, weights, beyond) else {
            return Ok(());
        };
        let drawn = (clip_from_world(&plan) * point.as_vec3().extend(1.0)).as_dvec4();
        prop_assert!(
            drawn.z >= 0.0,
            "lost to the far side: {point} at {drawn}, depth {}, margin {}",
            drawn.z / drawn.w,
            plan.margin
        );

        // And around the plane: cut where the bound says, on the right side.
        let near = point - input.plane.normal
            * (input.plane.signed_distance(point) - lift * 10.0 * clip_plane_error(plan.noise, plan.k, w));
        let near = near.as_vec3();
        let real = input.plane.signed_distance(near.as_dvec3());
        let reflected = plan.world_from_view.inverse().transform_point3(near.as_dvec3());
        let clip = plan.clip_from_view_oblique * reflected.extend(1.0);
        let on_screen = clip.w > 0.0
            && plan.polygon.w_min().is_none_or(|w_min| clip.w >= 0.5 * w_min)
            && clip.truncate().truncate().abs().max_element() <= clip.w;
        if on_screen {
            let allowed = clip_plane_error(plan.noise, plan.k, clip.w);
            let drawn = (clip_from_world(&plan) * near.extend(1.0)).as_dvec4();
            let cut = (drawn.w - drawn.z) / plan.k;
            prop_assert!(
                (cut - real).abs() <= allowed,
                "{near} is {real} from the plane and cut as if {cut}, allowed {allowed}"
            );
        }
    }

    #[test]
    fn depth_keeps_the_order_of_points_apart(
        input in any_scene(),
        weights in any_weights(),
        beyond in 0.0..0.6_f64,
    ) {
        let Ok(plan) = plan_reflected_view(&input) else {
            return Ok(());
        };
        let projection = BaseProjection::new(&input.clip_from_view).expect("invertible");
        prop_assume!(projection.depth_is_w);
        let Some((near, w)) = visible_point(&input, &plan, weights, beyond) else {
            return Ok(());
        };
        let apart = 2.0 * depth_error(plan.noise) * w * w / (plan.k * plan.eye_height);
        prop_assume!(apart < 0.5 * w);
        let eye = plan.world_from_view.translation;
        let far = eye + (near - eye) * (1.0 + 1.1 * apart / w);
        let depth = |p: DVec3| {
            let clip = clip_from_world(&plan) * p.as_vec3().extend(1.0);
            clip.z / clip.w
        };
        let (first, second) = (depth(near), depth(far));
        prop_assert!(
            first > second,
            "{near} at {first} is before {far} at {second}, {apart} apart at {w}"
        );
    }
}

/// Any `f32`: common numbers, extreme ones, and every bit pattern.
fn nasty() -> impl Strategy<Value = f64> {
    let special = prop::sample::select(vec![
        0.0,
        -0.0,
        1.0,
        -1.0,
        f32::MIN_POSITIVE,
        1e-45,
        f32::MAX,
        f32::MIN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
    ]);
    prop_oneof![
        2 => special,
        1 => any::<u32>().prop_map(f32::from_bits),
        2 => -10.0_f32..10.0,
    ]
    .prop_map(f64::from)
}

/// Puts `value` in the place of one of the numbers of `input`.
fn spoil(input: &mut ViewInput, place: usize, value: f64) {
    let mut camera = input.world_from_view.to_cols_array();
    let mut projection = input.clip_from_view.to_cols_array();
    match place {
        0..12 => camera[place] = value,
        12..28 => projection[place - 12] = value,
        28 => input.viewport_size.x = value,
        29 => input.viewport_size.y = value,
        30..33 => input.plane.origin[place - 30] = value,
        33..36 => input.plane.normal[place - 33] = value,
        36 => input.jitter_px = value,
        37 => input.corners = None,
        _ => {
            if let Some(corner) = input.corners.as_mut().and_then(|c| c.get_mut(place % 4)) {
                corner[place % 3] = value;
            }
        }
    }
    input.world_from_view = DAffine3::from_cols_array(&camera);
    input.clip_from_view = glam::DMat4::from_cols_array(&projection);
}

fn assert_usable(input: &ViewInput) {
    let Ok(plan) = plan_reflected_view(input) else {
        return;
    };
    assert!(
        plan.clip_from_view_oblique.as_mat4().is_finite(),
        "{plan:?}"
    );
    assert!(plan.world_from_view.as_affine3a().is_finite(), "{plan:?}");
    assert!(plan.margin >= 0.0 && plan.margin <= MAX_MARGIN, "{plan:?}");
    assert!(plan.polygon.ndc().all(|p| p.is_finite()), "{plan:?}");
    assert!(plan.ghost_tolerance(1.0, false) >= 0.0, "{plan:?}");
    let sides = narrowed_sides(
        plan.polygon.ndc_bounds(),
        &input.clip_from_view,
        input.viewport_size,
    );
    assert!(
        sides.iter().all(|side| side.is_finite()),
        "{sides:?}, {plan:?}"
    );
}

proptest! {
    #![proptest_config(cases(16))]

    #[test]
    fn no_number_breaks_a_plan(
        scene in any_scene(),
        spoilt in prop::collection::vec((0..60_usize, nasty()), 1..4),
    ) {
        let mut input = scene;
        for (place, value) in spoilt {
            spoil(&mut input, place, value);
        }
        assert_usable(&input);
    }

    #[test]
    fn no_numbers_at_all_break_a_plan(
        scene in any_scene(),
        numbers in prop::collection::vec(nasty(), 60),
    ) {
        let mut input = scene;
        for (place, value) in numbers.into_iter().enumerate() {
            if place != 37 {
                spoil(&mut input, place, value);
            }
        }
        assert_usable(&input);
    }

    #[test]
    fn no_number_breaks_a_patch(n in prop::collection::vec(nasty(), 24)) {
        let v = |i: usize| DVec3::new(n[i], n[i + 1], n[i + 2]);
        let patch = PlanarPatch {
            center: v(0),
            tangent_x: v(3),
            tangent_y: v(6),
            half_size: v(9).truncate(),
        };
        let local = PlanarPatch::from_point_and_normal(v(0), v(3), Some((v(6), v(9))));
        let transform = DAffine3::from_cols(v(12), v(15), v(18), v(21));
        for patch in [Some(patch), local].into_iter().flatten() {
            if let Some((plane, corners)) = transform_patch(&patch, &transform) {
                prop_assert!(plane.origin.is_finite(), "{plane:?}");
                prop_assert!((plane.normal.length() - 1.0).abs() < 1e-12, "{plane:?}");
                prop_assert!(corners.iter().flatten().all(|c| c.is_finite()), "{corners:?}");
            }
        }
    }
}
