//! How long the pure maths take: one mirror and one camera, and one object before a plane.

use std::{hint::black_box, time::Instant};

use bevy::math::{DAffine3, DMat4, DQuat, DVec2, DVec3, Mat4};
use bevy_planar_mirror::math::{
    Plane, Side, Skip, ViewInput, classify, plan_reflected_view, signed_distance_range,
};

use crate::{
    args::Plan,
    contest::{Failure, Measured, Outcome},
    estimate::{Estimate, Part},
    support::random::Random,
};

/// Different cameras or objects, so that no branch is learned by heart.
const DIFFERENT: usize = 64;
/// How often each is measured at once: the clock itself takes some twenty nanoseconds.
const REPEATS: usize = 32;

const SIZE: DVec2 = DVec2::new(1920.0, 1080.0);

/// Nanoseconds for a mirror that is drawn.
pub fn of_a_plan(plan: &Plan) -> Outcome {
    timed_views(plan, 5.0, 0.0, Ok(()))
}

/// Nanoseconds for one whose back is turned to the eye.
pub fn of_a_back(plan: &Plan) -> Outcome {
    timed_views(plan, -5.0, 0.0, Err(Skip::EyeBehind))
}

/// Nanoseconds for one that is before the eye, but beside its view.
pub fn of_one_out_of_view(plan: &Plan) -> Outcome {
    timed_views(plan, 5.0, 30.0, Err(Skip::OutOfView))
}

/// Of cameras that stand about `distance` before the mirror, and look past it by `aside`.
fn timed_views(plan: &Plan, distance: f64, aside: f64, expected: Result<(), Skip>) -> Outcome {
    let random = &mut Random::new(7);
    let mut noise = || f64::from(random.between(-1.0, 1.0));
    let projection = Mat4::perspective_infinite_reverse_rh(0.8, (SIZE.x / SIZE.y) as f32, 0.1);
    let views: Vec<ViewInput> = (0..DIFFERENT)
        .map(|_| {
            let eye = DVec3::new(noise(), noise(), distance + noise());
            let target = DVec3::new(aside + noise(), noise(), 0.0);
            ViewInput {
                world_from_view: DAffine3::look_at_rh(eye, target, DVec3::Y).inverse(),
                clip_from_view: DMat4::from_cols_array(&projection.to_cols_array().map(f64::from)),
                viewport_size: SIZE,
                plane: Plane {
                    normal: DVec3::Z,
                    origin: DVec3::ZERO,
                },
                corners: Some(
                    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                        .map(|(x, y)| DVec3::new(x, y, 0.0)),
                ),
                jitter_px: 0.0,
                was_drawn: false,
            }
        })
        .collect();
    if let Some(other) = views
        .iter()
        .map(|view| plan_reflected_view(view).map(|_| ()))
        .find(|told| *told != expected)
    {
        return Err(Failure::Reason(format!("one of the views is {other:?}")));
    }
    timed(plan, &views, |view| plan_reflected_view(view).is_ok())
}

/// Nanoseconds to tell on which side of a mirror an object's box lies.
pub fn of_an_object(plan: &Plan) -> Outcome {
    let random = &mut Random::new(8);
    let mut noise = || f64::from(random.between(-1.0, 1.0));
    let plane = Plane {
        normal: DVec3::new(0.6, 0.0, 0.8),
        origin: DVec3::ZERO,
    };
    let boxes: Vec<(DVec3, [DVec3; 3])> = (0..DIFFERENT)
        .map(|_| {
            let center = DVec3::new(noise(), noise(), noise());
            let turn = DQuat::from_rotation_y(noise());
            let half = 0.5 * noise().abs();
            (
                center,
                [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| turn * axis * half),
            )
        })
        .collect();
    timed(plan, &boxes, |(center, half_axes)| {
        classify(signed_distance_range(&plane, *center, *half_axes), 1e-3) == Side::Straddling
    })
}

/// Nanoseconds of one call, several thousand at once.
fn timed<T>(plan: &Plan, inputs: &[T], call: impl Fn(&T) -> bool) -> Outcome {
    let rounds: Vec<Part> = (0..plan.frames * 10)
        .map(|_| {
            let begin = Instant::now();
            for _ in 0..REPEATS {
                for input in inputs {
                    black_box(call(black_box(input)));
                }
            }
            Part {
                of: begin.elapsed().as_secs_f64() * 1e9 / (REPEATS * inputs.len()) as f64,
                by: 1.0,
            }
        })
        .collect();
    let nothing = || Failure::Reason("nothing was measured".into());
    Ok(Measured {
        estimate: Estimate::of(&rounds).ok_or_else(nothing)?,
        details: format!("{} calls", rounds.len() * REPEATS * inputs.len()),
        pictures: Vec::new(),
    })
}
