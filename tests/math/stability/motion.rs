//! Plans of cameras that move in the smallest steps, and in leaps.

use bevy_planar_mirror::math::*;
use glam::{DAffine3, DQuat, DVec2, DVec3};

use super::witness::HALF_STEP;
use crate::{
    extremes::{Extreme, KINDS},
    random::{perspective_rows, rounded},
    reference::matrix,
};

/// 90 degrees wide and high, near distance 0.1, 1000 x 1000 pixels; the mirror is 2 x 2 around
/// `origin` and faces along `turn`'s +Z. `eye` is in the mirror's frame, `look` turns the camera
/// from looking straight at the mirror.
#[derive(Clone, Copy)]
pub struct Wall {
    pub origin: DVec3,
    pub turn: DQuat,
}

impl Wall {
    pub const PLAIN: Self = Self {
        origin: DVec3::ZERO,
        turn: DQuat::IDENTITY,
    };

    pub fn seen_from(&self, eye: DVec3, look: DQuat) -> ViewInput {
        let patch = PlanarPatch {
            center: DVec3::ZERO,
            tangent_x: DVec3::X,
            tangent_y: DVec3::Y,
            half_size: DVec2::ONE,
        };
        let mirror = rounded(DAffine3::from_rotation_translation(self.turn, self.origin));
        let (plane, corners) = transform_patch(&patch, &mirror).expect("a plane");
        ViewInput {
            world_from_view: rounded(DAffine3::from_rotation_translation(
                self.turn * look,
                self.origin + self.turn * eye,
            )),
            clip_from_view: matrix(perspective_rows(1.0, 1.0, 0.0, 0.0, 0.0, 0.1)),
            viewport_size: DVec2::splat(1000.0),
            plane,
            corners,
            jitter_px: 0.0,
            was_drawn: false,
        }
    }
}

/// Somewhere off the origin, along no axis.
pub fn slanted(distance: f64) -> Wall {
    Wall {
        origin: DVec3::new(0.7, -0.2, 0.5) * distance,
        turn: DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -0.9, 1.3),
    }
}

type Outcome = Result<ReflectedViewPlan, Skip>;

fn reason(outcome: &Outcome) -> Option<Skip> {
    outcome.as_ref().err().copied()
}

/// The reasons in the order of the sweep, each once in a row.
fn story(sweep: &[Outcome]) -> Vec<Option<Skip>> {
    let mut story: Vec<_> = sweep.iter().map(reason).collect();
    story.dedup();
    story
}

/// The largest relative change of k from step to step, and of the depth row, as a share of its
/// largest entry.
fn largest_steps(sweep: &[Outcome]) -> (f64, f64) {
    sweep.windows(2).fold((0.0, 0.0), |(k, row), pair| {
        let (Ok(a), Ok(b)) = (&pair[0], &pair[1]) else {
            return (k, row);
        };
        let [from, to] = [a, b].map(|plan| plan.clip_from_view_oblique.row(2));
        let change = (to - from).abs().max_element() / from.abs().max_element();
        (k.max((b.k / a.k - 1.0).abs()), row.max(change))
    })
}

#[test]
fn turning_through_head_on_changes_the_plan_as_little_as_the_camera() {
    let step = 1e-7;
    for (wall, rounding) in [(Wall::PLAIN, 0.0), (slanted(10.0), 8.0 * HALF_STEP)] {
        for axis in [DVec3::X, DVec3::Y, DVec3::new(0.6, 0.8, 0.0)] {
            let sweep: Vec<_> = (-200..=200)
                .map(|i| {
                    let look = DQuat::from_axis_angle(axis, f64::from(i) * step);
                    plan_reflected_view(&wall.seen_from(DVec3::Z * 5.0, look))
                })
                .collect();
            assert_eq!(story(&sweep), [None], "{axis}");
            // The mirror's corner is a quarter of its distance to the side.
            let (k, row) = largest_steps(&sweep);
            println!("head-on about {axis}: k by {k:.1e}, row by {row:.1e} a step of 1e-7");
            assert!(k <= 0.5 * step + rounding, "{axis}: k by {k:e}");
            assert!(row <= 1.5 * step + rounding, "{axis}: the row by {row:e}");
        }
    }
}

#[test]
fn moving_through_head_on_changes_the_plan_as_little_as_the_camera() {
    let step = 1e-6;
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        let sweep: Vec<_> = (-200..=200)
            .map(|i| {
                let eye = DVec3::Z * 5.0 + axis * (f64::from(i) * step);
                plan_reflected_view(&Wall::PLAIN.seen_from(eye, DQuat::IDENTITY))
            })
            .collect();
        assert_eq!(story(&sweep), [None], "{axis}");
        let (k, row) = largest_steps(&sweep);
        // Coordinates of 5 are 5e-7 apart.
        let allowed = (step + 5e-7) / 5.0 + 1e-12;
        assert!(k <= allowed, "{axis}: k by {k:e}");
        assert!(row <= allowed, "{axis}: the row by {row:e}");
    }
}

#[test]
fn sinking_through_the_plane_tells_each_reason_once() {
    // Along the mirror, from over one of its edges; in micrometers, or in steps of the coordinates.
    let along = DQuat::from_rotation_arc(DVec3::NEG_Z, DVec3::Y);
    for distance in [0.0, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5] {
        for beside in [-1.5, -0.5, 0.0] {
            let wall = slanted(distance);
            let step = (HALF_STEP * distance).max(1e-6);
            let coarse = (0..4000).map(|i| 10.0_f64.powf(-0.2 - f64::from(i) * 2e-3));
            let fine = (0..4000).map(|i| (2000.0 - f64::from(i)) * step);
            for heights in [coarse.collect::<Vec<_>>(), fine.collect()] {
                let sweep: Vec<_> = heights
                    .iter()
                    .map(|h| {
                        plan_reflected_view(&wall.seen_from(DVec3::new(0.1, beside, *h), along))
                    })
                    .collect();
                let story = story(&sweep);
                println!("sinking {distance} off, {beside} beside: {story:?}");
                for (index, told) in story.iter().enumerate() {
                    assert!(
                        !story[..index].contains(told),
                        "{distance} off, {beside} beside: {story:?}"
                    );
                }
                for (pair, h) in sweep.windows(2).zip(heights.windows(2)) {
                    if let (Ok(a), Ok(b)) = (&pair[0], &pair[1]) {
                        // k h is the depth of the nearest point seen, which hardly moves.
                        let change = (b.k * b.eye_height) / (a.k * a.eye_height) - 1.0;
                        let moved = (h[0] - h[1]).abs() + 4.0 * HALF_STEP * (distance + 10.0);
                        // The guard of 1/128 pixel weighs as w / h.
                        let guard = 2.0 / 1000.0 / 128.0 * a.w_min / a.eye_height;
                        let allowed = 4.0 * moved / a.w_min
                            + 4.0 * (b.margin - a.margin).abs()
                            + 2.0 * guard * moved / b.eye_height;
                        assert!(
                            change.abs() <= allowed,
                            "at {}: k h by {change:e} for {moved:e}, w {}",
                            h[0],
                            a.w_min
                        );
                    }
                }
            }
        }
    }
}

/// No state: a leap of a million units or another kind of projection in between changes nothing.
#[test]
fn plans_depend_on_nothing_but_their_input() {
    let input_of = |seed: u64| Extreme::of(KINDS[seed as usize % KINDS.len()], seed).input();
    let inputs: Vec<_> = (0..2000).filter_map(input_of).collect();
    let bits = |input: &ViewInput| format!("{:?}", plan_reflected_view(input));
    let calm: Vec<_> = inputs.iter().map(bits).collect();
    for (input, expected) in inputs.iter().zip(&calm) {
        let mut leapt = *input;
        leapt.world_from_view.translation += DVec3::splat(1e6);
        let mut other = *input;
        other.clip_from_view = matrix([
            [0.25, 0.0, 0.0, 0.0],
            [0.0, 0.25, 0.0, 0.0],
            [0.0, 0.0, 0.01, 1.0],
            [0.0, 0.0, 0.0, 1.0],
        ]);
        let between = [bits(&leapt), bits(&other)];
        assert_eq!(&bits(input), expected, "after {between:?}");
    }
    // And in another order of time.
    for (input, expected) in inputs.iter().zip(&calm).rev() {
        assert_eq!(&bits(input), expected);
    }
}
