//! Cameras that move in the smallest steps, and in leaps.

use std::collections::BTreeMap;

use bevy_planar_mirror::math::*;
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};

use super::{
    tally::count,
    witness::{HALF_STEP, Witness},
};
use crate::{
    extremes::{Extreme, KINDS},
    random::{perspective_rows, rounded},
    reference::matrix,
};

/// 90 degrees wide and high, near distance 0.1, 1000 x 1000 pixels; the mirror is 2 x 2 around
/// `origin` and faces along `turn`'s +Z. `eye` is in the mirror's frame, `look` turns the camera
/// from looking straight at the mirror.
#[derive(Clone, Copy)]
struct Wall {
    origin: DVec3,
    turn: DQuat,
}

impl Wall {
    const PLAIN: Self = Self {
        origin: DVec3::ZERO,
        turn: DQuat::IDENTITY,
    };

    fn seen_from(&self, eye: DVec3, look: DQuat) -> ViewInput {
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
        }
    }
}

/// Somewhere off the origin, along no axis.
fn slanted(distance: f64) -> Wall {
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

#[test]
fn a_box_that_sinks_through_the_plane_is_cut_once() {
    for wall in [Wall::PLAIN, slanted(10.0), slanted(1e3)] {
        let input = wall.seen_from(DVec3::Z * 5.0, DQuat::from_rotation_y(0.1));
        let plan = plan_reflected_view(&input).expect("seen");
        let axes = DMat3::from_quat(DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 0.2, 0.1)) * 1e-3;
        let half_axes = [axes.x_axis, axes.y_axis, axes.z_axis];
        let mut sides: Vec<_> = (-8000..=8000)
            .map(|i| {
                let center = wall.origin + wall.turn * DVec3::new(0.3, 0.2, f64::from(-i) * 1e-6);
                let center = center.as_vec3().as_dvec3();
                let range = signed_distance_range(&input.plane, center, half_axes);
                classify(range, plan.ghost_tolerance(5.0))
            })
            .collect();
        sides.dedup();
        // Boxes thinner than what shows are never cut.
        let expected: &[Side] = if plan.ghost_tolerance(5.0) > 1.7e-3 {
            &[Side::InFront, Side::Behind]
        } else {
            &[Side::InFront, Side::Straddling, Side::Behind]
        };
        assert_eq!(sides, expected);
    }
}

#[test]
fn a_camera_that_backs_off_stops_cutting_once() {
    for wall in [Wall::PLAIN, slanted(10.0), slanted(1e3)] {
        let look = DQuat::from_rotation_y(0.1);
        let tolerance = |i: i32| {
            let eye = DVec3::Z * (5.0 + f64::from(i) * 1e-6);
            let input = wall.seen_from(eye, look);
            let plan = plan_reflected_view(&input).expect("seen");
            plan.ghost_tolerance(plan.w_min)
        };
        let tolerances: Vec<_> = (0..4000).map(tolerance).collect();
        // Whatever reaches behind by the middle of them is cut first and whole later.
        let reach = tolerances[2000];
        let mut sides: Vec<_> = tolerances
            .iter()
            .map(|tolerance| classify((-reach, 1.0), *tolerance))
            .collect();
        sides.dedup();
        println!("backing off {}: {} changes", wall.origin, sides.len() - 1);
        assert_eq!(sides, [Side::Straddling, Side::InFront], "{}", wall.origin);
    }
}

/// Where a camera starts or ceases to see a mirror, in steps of a micrometer or of 1e-7 radian,
/// and of a quarter of a step of `f32`.
///
/// The decision itself changes once. Rounding the camera's pose to `f32` makes some tremble about
/// the boundary; how far is printed, in steps of `f32` and in pixels.
#[test]
fn decisions_change_once_on_the_way() {
    let mut boundaries = 0;
    let mut trembling: BTreeMap<String, Tremble> = BTreeMap::new();
    for seed in 0..count(1500, 20_000) {
        let kind = KINDS[seed as usize % KINDS.len()];
        let Some(input) = Extreme::of(kind, seed).input() else {
            continue;
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
            let (smallest, grid) = match way {
                Way::Turn => (1e-7, 2.0 * HALF_STEP),
                _ => (1e-6, 2.0 * HALF_STEP * largest),
            };
            for step in [smallest, 0.25 * grid] {
                let ts = (-100..100).map(|i| boundary + f64::from(i) * step / span);
                let exact = ts.clone().map(|t| plan_reflected_view(&at(t)).is_ok());
                let changes = changes(&exact.collect::<Vec<_>>());
                // A step far from the origin may be larger than the mirror.
                let is_small = 100.0 * step < 0.01 * span;
                assert!(
                    changes.len() <= 1 || !is_small,
                    "Extreme::of(Kind::{kind:?}, {seed}) {way:?} in steps of {step:e}: {changes:?}"
                );

                let poses: Vec<_> = ts
                    .map(|t| {
                        let mut input = at(t);
                        input.world_from_view = rounded(input.world_from_view);
                        input
                    })
                    .collect();
                let drawn: Vec<_> = poses
                    .iter()
                    .map(|pose| plan_reflected_view(pose).is_ok())
                    .collect();
                let found = self::changes(&drawn);
                if let [first, .., last] = found[..] {
                    let skip = poses
                        .iter()
                        .find_map(|pose| plan_reflected_view(pose).err());
                    let near = if largest <= 1e3 {
                        "within 1e3"
                    } else {
                        "farther"
                    };
                    let entry = trembling
                        .entry(format!("{skip:?} {way:?} {near}"))
                        .or_default();
                    let band = (last - first) as f64 * step / grid;
                    entry.times += 1;
                    entry.steps = entry.steps.max(band);
                    for pose in &poses[first - 1..=last] {
                        let width = Witness::of(pose).width_px(pose.viewport_size);
                        if plan_reflected_view(pose).is_ok() {
                            entry.drawn_px = entry.drawn_px.max(width);
                        } else {
                            entry.skipped_px = entry.skipped_px.max(0.5 - width);
                        }
                    }
                }
            }
        }
    }
    println!("{boundaries} boundaries");
    for (what, tremble) in &trembling {
        println!("  {what}: {tremble:?}");
    }
    assert!(boundaries > 500, "{boundaries}");
}

/// What trembles: how often, in how many steps of `f32`; up to what width it was drawn, and by how
/// much less than half a pixel it was not.
#[derive(Debug, Default)]
struct Tremble {
    times: u32,
    steps: f64,
    drawn_px: f64,
    skipped_px: f64,
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

/// Where neighbors differ.
fn changes(drawn: &[bool]) -> Vec<usize> {
    (1..drawn.len())
        .filter(|i| drawn[*i] != drawn[i - 1])
        .collect()
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
