//! What is decided anew in every frame does not flicker because poses are rounded to `f32`.

use bevy_planar_mirror::math::*;
use glam::{DMat3, DQuat, DVec2, DVec3};

use super::{
    motion::{Wall, slanted},
    witness::HALF_STEP,
};
use crate::{
    count::count,
    extremes::{Extreme, KINDS},
    random::rounded,
};

/// The side of a box in every frame of a sweep; a frame remembers whether the one before cut it.
fn sides(frames: impl Iterator<Item = ((f64, f64), ReflectedViewPlan)>, w: f64) -> Vec<Side> {
    let mut was_cut = false;
    let mut sides: Vec<_> = frames
        .map(|(range, plan)| {
            let side = classify(range, plan.ghost_tolerance(w, was_cut));
            was_cut = side == Side::Straddling;
            side
        })
        .collect();
    sides.dedup();
    sides
}

#[test]
fn a_box_that_goes_through_the_plane_is_cut_once() {
    for wall in [Wall::PLAIN, slanted(10.0), slanted(1e3)] {
        let input = wall.seen_from(DVec3::Z * 5.0, DQuat::from_rotation_y(0.1));
        let plan = plan_reflected_view(&input).expect("seen");
        let axes = DMat3::from_quat(DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 0.2, 0.1)) * 1e-3;
        let half_axes = [axes.x_axis, axes.y_axis, axes.z_axis];
        let frame = |i: i32| {
            let center = wall.origin + wall.turn * DVec3::new(0.3, 0.2, f64::from(i) * 1e-6);
            let center = center.as_vec3().as_dvec3();
            (signed_distance_range(&input.plane, center, half_axes), plan)
        };
        // Boxes thinner than what shows are never cut.
        let mut expected = if plan.ghost_tolerance(5.0, false) > 1.7e-3 {
            vec![Side::InFront, Side::Behind]
        } else {
            vec![Side::InFront, Side::Straddling, Side::Behind]
        };
        let sinking = sides((-8000..=8000).rev().map(frame), 5.0);
        assert_eq!(sinking, expected, "{}", wall.origin);
        expected.reverse();
        let rising = sides((-8000..=8000).map(frame), 5.0);
        assert_eq!(rising, expected, "{}", wall.origin);
    }
}

/// To and fro by micrometers, or by 1e-7 radian, about where a box comes to be cut.
#[test]
fn a_camera_that_trembles_cuts_once() {
    for wall in [Wall::PLAIN, slanted(10.0), slanted(1e3)] {
        let moved = |i: i32| (DVec3::Z * (5.0 + f64::from(i) * 1e-6), 0.1);
        let aside = |i: i32| (DVec3::new(f64::from(i) * 1e-6, 0.0, 5.0), 0.1);
        let turned = |i: i32| (DVec3::Z * 5.0, 0.1 + f64::from(i) * 1e-7);
        let ways: [&dyn Fn(i32) -> (DVec3, f64); 3] = [&moved, &aside, &turned];
        for (index, way) in ways.iter().enumerate() {
            let plan = |i: i32| {
                let (eye, look) = way(i);
                let input = wall.seen_from(eye, DQuat::from_rotation_y(look));
                plan_reflected_view(&input).expect("seen")
            };
            // The first frame just does without a cut.
            let reach = plan(0).ghost_tolerance(5.0, false);
            let trembling = (0..4000).map(|i| (i * 37) % 101 - 50);
            let frames = core::iter::once(0).chain(trembling);
            let sides = sides(frames.map(|i| ((-reach, 1.0), plan(i))), 5.0);
            let expected = [Side::InFront, Side::Straddling];
            assert_eq!(sides, expected, "{} way {index}", wall.origin);
        }
    }
}

/// Where a camera starts or ceases to see a mirror, in steps of a micrometer or of 1e-7 radian,
/// and of a quarter of a step of `f32`.
///
/// With exact poses what is decided changes once. With poses rounded to `f32` it does, too, because
/// a mirror that was drawn is left out later; unless the camera is so far away from the origin
/// that such a step shows.
#[test]
fn decisions_change_once_on_the_way() {
    let (mut boundaries, mut rounded_ones) = (0, 0);
    let (mut without_memory, mut where_steps_show) = (0, 0);
    for seed in 0..count(1500, 20_000) {
        let kind = KINDS[seed as usize % KINDS.len()];
        let Some(input) = Extreme::of(kind, seed).input() else {
            continue;
        };
        let input = ViewInput {
            was_drawn: false,
            ..input
        };
        let Ok(plan) = plan_reflected_view(&input) else {
            continue;
        };
        for (way, span) in [
            (Way::Down, 1.05 * plan.eye_height.abs()),
            (Way::Aside, plan.w_min),
            (Way::Turn, 1.5),
        ] {
            let at = |t: f64| moved(&input, way, t * span);
            let Some(boundary) = boundary(|t| plan_reflected_view(&at(t)).is_ok()) else {
                continue;
            };
            boundaries += 1;
            let largest = input.world_from_view.translation.abs().max_element();
            let corners = input.corners.iter().flatten();
            let extent = corners.fold(largest, |extent, c| extent.max(c.abs().max_element()));
            let (smallest, grid) = match way {
                Way::Turn => (1e-7, 2.0 * HALF_STEP),
                _ => (1e-6, 2.0 * HALF_STEP * largest),
            };
            for step in [smallest, 0.25 * grid] {
                // A step far from the origin may be larger than the mirror, and one near it
                // smaller than what `f64` resolves.
                if 100.0 * step >= 0.01 * span || step < 1e-12 * extent {
                    continue;
                }
                let ts = (-100..100).map(|i| boundary + f64::from(i) * step / span);
                let exact: Vec<_> = ts.clone().map(at).collect();
                let label = format!("Extreme::of(Kind::{kind:?}, {seed}) {way:?} by {step:e}");
                let found = changes(&exact, false);
                assert!(found <= 1, "{label}: {found} changes");

                let mut poses: Vec<_> = exact
                    .into_iter()
                    .map(|pose| ViewInput {
                        world_from_view: rounded(pose.world_from_view),
                        ..pose
                    })
                    .collect();
                rounded_ones += 1;
                without_memory += u32::from(changes(&poses, false) > 1);
                let there = changes(&poses, true);
                poses.reverse();
                let back = changes(&poses, true);
                if steps_show(&input, &plan) {
                    where_steps_show += u32::from(there > 1 || back > 1);
                } else {
                    assert!(there <= 1, "{label}: {there} changes");
                    assert!(back <= 1, "{label}: {back} changes on the way back");
                }
            }
        }
    }
    println!(
        "{boundaries} boundaries, {rounded_ones} sweeps; flicker: {without_memory} without memory, \
         {where_steps_show} where steps show"
    );
    assert!(boundaries > 500, "{boundaries}");
    assert!(without_memory > 10, "nothing to prove");
}

/// Whether one step of `f32` of a pose moves the picture by more than a sixteenth of a pixel.
fn steps_show(input: &ViewInput, plan: &ReflectedViewPlan) -> bool {
    let step = 2.0 * HALF_STEP;
    let eye = input.world_from_view.translation.abs().max_element();
    let largest = eye.max(input.plane.origin.abs().max_element());
    let px_per_unit = 0.25 / plan.ghost_size / plan.w_min;
    let projection = input.clip_from_view;
    let focal = input.viewport_size * 0.5 * DVec2::new(projection.x_axis.x, projection.y_axis.y);
    step * (largest * px_per_unit + focal.max_element()) > 1.0 / 16.0
}

#[derive(Clone, Copy, Debug)]
enum Way {
    Down,
    Aside,
    Turn,
}

fn moved(input: &ViewInput, way: Way, by: f64) -> ViewInput {
    let mut moved = *input;
    let pose = &mut moved.world_from_view;
    let normal = input.plane.normal;
    match way {
        Way::Down => pose.translation -= normal * by,
        Way::Aside => pose.translation += normal.any_orthonormal_vector() * by,
        Way::Turn => {
            let axis = pose.x_axis.normalize();
            pose.matrix3 = DMat3::from_axis_angle(axis, by) * pose.matrix3;
        }
    }
    moved
}

/// The first boundary from 0 to 1, as exact as `f64` has it.
fn boundary(drawn: impl Fn(f64) -> bool) -> Option<f64> {
    let first = (1..=32).map(f64::from).find(|i| !drawn(i / 32.0))?;
    let (mut low, mut high) = ((first - 1.0) / 32.0, first / 32.0);
    for _ in 0..48 {
        let middle = 0.5 * (low + high);
        if drawn(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(high)
}

/// How often a mirror comes or goes in successive frames, which may remember the one before.
fn changes(frames: &[ViewInput], remember: bool) -> usize {
    let mut was_drawn = false;
    let drawn: Vec<_> = frames
        .iter()
        .map(|frame| {
            let was_drawn_before = was_drawn && remember;
            was_drawn = plan_reflected_view(&ViewInput {
                was_drawn: was_drawn_before,
                ..*frame
            })
            .is_ok();
            was_drawn
        })
        .collect();
    drawn.windows(2).filter(|pair| pair[0] != pair[1]).count()
}
