//! A million plans, each judged by what an independent look at the scene finds.

use bevy_planar_mirror::math::*;
use glam::{DMat3, DVec2};

use super::{
    tally::{Broken, Tally, run},
    witness::{HALF_STEP, Witness, lengths, max_margin, min_width_px},
};
use crate::{
    count::count,
    extremes::{Extreme, KINDS},
};

/// What both sides find in `f64` may differ by this much of it.
const CLOSE: f64 = 1e-6;

#[test]
fn plans_of_extreme_scenes_are_finite_and_skips_have_a_reason() {
    let scenes = count(60_000, 1_000_000);
    let tally = run("plans", &KINDS, scenes, |scene, tally| {
        let Some(input) = scene.input() else {
            tally.count("without a plane");
            return Tally::law("only what collapses has no plane", collapses(scene), || {
                format!("{:?}", scene.mirror)
            });
        };
        let witness = Witness::of(&input);
        match plan_reflected_view(&input) {
            Ok(plan) => {
                tally.count("drawn");
                is_sound(&input, &plan, tally)?;
                is_worth_drawing(&input, &plan, &witness, tally)?;
                loses_nothing(&input, &plan, &witness, tally)?;
                cuts_at_the_plane(&plan, &witness, &input, tally)
            }
            Err(skip) => {
                tally.count(name(skip));
                is_justified(&input, skip, &witness)
            }
        }
    });
    // The generator reaches every rule.
    for outcome in [
        "drawn",
        "EyeBehind",
        "OutOfView",
        "TooThin",
        "BelowPrecision",
    ] {
        let share = tally.counted(outcome) as f64 / scenes as f64;
        assert!(share > 0.005, "{share} of the scenes are {outcome}");
    }
    assert!(3 * tally.counted("drawn") > scenes);
}

fn name(skip: Skip) -> &'static str {
    match skip {
        Skip::DegenerateView => "DegenerateView",
        Skip::EyeBehind => "EyeBehind",
        Skip::OutOfView => "OutOfView",
        Skip::TooThin => "TooThin",
        Skip::BelowPrecision => "BelowPrecision",
    }
}

/// Two axes of the mirror are parallel to 1e-5, so that rounding decides where its plane is.
fn collapses(scene: &Extreme) -> bool {
    let (x, y) = (scene.mirror.x_axis, scene.mirror.y_axis);
    x.cross(y).length() < 1e-5 * x.length() * y.length()
}

fn is_justified(input: &ViewInput, skip: Skip, witness: &Witness) -> Result<(), Broken> {
    let width = witness.width_px(input.viewport_size);
    match skip {
        Skip::DegenerateView => Tally::law("no scene is degenerate", false, String::new),
        Skip::EyeBehind => {
            let front = witness.front(input);
            Tally::law("the eye is behind", front <= 1.0 + CLOSE, || {
                format!("{front}")
            })
        }
        Skip::OutOfView => {
            let is_seen = input.corners.is_some() && width > CLOSE;
            Tally::law("nothing is in view", !is_seen, || {
                format!("{width} px wide")
            })?;
            let found = witness.finds_a_visible_point(input);
            Tally::law("no point is in view", !found, String::new)
        }
        Skip::TooThin => {
            let is_thin = width < min_width_px(input) * (1.0 + CLOSE) + CLOSE;
            Tally::law("it is thin", is_thin, || format!("{width} px wide"))
        }
        Skip::BelowPrecision => {
            let margin = 2.0 * HALF_STEP * witness.noise(input);
            let is_lost = margin > max_margin(input) * (1.0 - 1e-3);
            Tally::law("the plane is lost in noise", is_lost, || {
                format!("margin {margin}")
            })
        }
    }
}

fn is_sound(input: &ViewInput, plan: &ReflectedViewPlan, tally: &mut Tally) -> Result<(), Broken> {
    let finite = plan.clip_from_view_oblique.as_mat4().is_finite()
        && plan.world_from_view.as_affine3a().is_finite()
        && plan.plane_view.as_vec4().is_finite()
        && plan
            .polygon
            .vertices()
            .iter()
            .all(|v| v.as_vec4().is_finite())
        && [plan.k, plan.w_min, plan.noise, plan.ghost_size, plan.margin]
            .iter()
            .all(|value| (*value as f32).is_finite() && *value as f32 > 0.0);
    Tally::law("all is finite in f32", finite, || format!("{plan:?}"))?;
    let sides = narrowed_sides(
        plan.polygon.ndc_bounds(),
        &input.clip_from_view,
        input.viewport_size,
    );
    let finite = sides.iter().all(|side| side.as_vec4().is_finite());
    Tally::law("culling planes are finite in f32", finite, || {
        format!("{sides:?}")
    })?;
    for row in [0, 1, 3] {
        let same = plan.clip_from_view_oblique.row(row) == input.clip_from_view.row(row);
        Tally::law("only the depth row changes", same, || format!("row {row}"))?;
    }
    tally.bound("margin", plan.margin, max_margin(input))
}

fn is_worth_drawing(
    input: &ViewInput,
    plan: &ReflectedViewPlan,
    witness: &Witness,
    tally: &mut Tally,
) -> Result<(), Broken> {
    let front = witness.front(input);
    Tally::law("the eye is in front", front >= 1.0 - CLOSE, || {
        format!("{front}")
    })?;
    let width = witness.width_px(input.viewport_size);
    let is_wide = width >= min_width_px(input) * (1.0 - CLOSE) - CLOSE;
    Tally::law("it is wide enough", is_wide, || format!("{width} px wide"))?;
    let w_min = witness.w_min();
    tally.bound("least w", (plan.w_min - w_min).abs(), 10.0 * CLOSE * w_min)?;
    let noise = witness.noise(input);
    tally.bound("noise factor", (plan.noise - noise).abs(), CLOSE * noise)?;

    // k h = w_min, but for the margin, the guard of the rasterizer and a far end that is not at infinity.
    if !witness.is_orthographic && input.corners.is_some() {
        let guard = guard(input, witness);
        let fitted = (1.0 - plan.margin) / plan.k - guard;
        let far = witness.far_end(DVec2::ZERO).w;
        let at_mirror = witness.height / w_min - witness.height * far;
        // What cancels is as long as the rays times the camera's axes.
        let rays = witness
            .screen()
            .into_iter()
            .map(|p| witness.far_end(p).truncate().length());
        let rays = rays.fold(0.0, f64::max) * lengths(input).1;
        let allowed = CLOSE * at_mirror + 1e-12 * (rays + guard + witness.height * far);
        tally.bound("k h = w_min", (fitted - at_mirror).abs(), allowed)?;
    }
    Ok(())
}

/// How much `(C.p)/w` changes over the pixels that the rasterizer's grid and jitter may add.
fn guard(input: &ViewInput, witness: &Witness) -> f64 {
    let pixel = 2.0 / input.viewport_size * (1.0 / 128.0 + input.jitter_px);
    let at = |ndc: DVec2| witness.reach(input, ndc);
    0.5 * ((at(DVec2::X) - at(DVec2::NEG_X)).abs() * pixel.x
        + (at(DVec2::Y) - at(DVec2::NEG_Y)).abs() * pixel.y)
}

/// The far end of every ray through the mirror, and a little beside it, stays in the clip volume.
fn loses_nothing(
    input: &ViewInput,
    plan: &ReflectedViewPlan,
    witness: &Witness,
    tally: &mut Tally,
) -> Result<(), Broken> {
    let row = plan.clip_from_view_oblique.row(2);
    let rounded = row.as_vec4().as_dvec4();
    let beside = 2.0 / input.viewport_size * (1.0 / 128.0 + input.jitter_px);
    for ndc in witness.screen() {
        for corner in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let end = witness.far_end(ndc + beside * DVec2::from(corner));
            let short = (plan.margin - row.dot(end)).max(0.0);
            tally.bound("far end keeps the margin", short, 0.1 * plan.margin)?;
            let short = plan.margin - rounded.dot(end);
            tally.bound("far end in a rounded row", short.max(0.0), plan.margin)?;
        }
    }
    Ok(())
}

/// What is seen of the mirror lies on the near side of the clip volume, so that all behind is cut.
fn cuts_at_the_plane(
    plan: &ReflectedViewPlan,
    witness: &Witness,
    input: &ViewInput,
    tally: &mut Tally,
) -> Result<(), Broken> {
    if input.corners.is_none() {
        return Ok(());
    }
    let row = plan.clip_from_view_oblique.row(2);
    let rounded = row.as_vec4().as_dvec4();
    let view_from_clip = input.clip_from_view.inverse();
    let view_from_world: DMat3 = input.world_from_view.matrix3.inverse();
    for clip in &witness.seen {
        let view = view_from_clip * *clip;
        let allowed = 2.0 * HALF_STEP * plan.noise * clip.w;
        let off = (clip.w - row.dot(view)).abs();
        tally.bound("cut at the plane", off, 0.01 * allowed)?;
        let off = (clip.w - rounded.dot(view)).abs();
        tally.bound("cut at the plane by a rounded row", off, allowed)?;

        // Behind the plane by twice the error of the cut: gone.
        let behind = -2.0 * clip_plane_error(plan.noise, plan.k, clip.w);
        let step = reflect_vector(input.plane.normal, input.plane.normal * behind);
        let reflected = view.truncate() / view.w + view_from_world * step;
        let at = reflected.extend(1.0);
        let w = plan.clip_from_view_oblique.row(3).dot(at);
        let is_cut = w <= 0.0 || rounded.dot(at) > w;
        Tally::law("what is behind is cut", is_cut, || {
            format!("{at} by {behind}: {} of {w}", rounded.dot(at))
        })?;
    }
    Ok(())
}
