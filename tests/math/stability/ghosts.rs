//! What is left uncut behind the plane moves over no more than a quarter of a pixel.

use bevy_planar_mirror::math::*;
use glam::{DAffine3, DMat4, DVec2, DVec3};

use super::{
    tally::{Broken, Tally, run},
    witness::Witness,
};
use crate::{count::count, extremes::KINDS};

/// As documented.
const GHOST_PX: f64 = 0.25;

#[test]
fn what_stays_uncut_is_within_a_quarter_of_a_pixel_of_its_place() {
    let scenes = count(20_000, 1_000_000);
    let tally = run("ghosts", &KINDS, scenes, |scene, tally| {
        let Some(input) = scene.input() else {
            return Ok(());
        };
        let Ok(plan) = plan_reflected_view(&input) else {
            return Ok(());
        };
        tally.count("drawn");
        ghosts(&input, &plan, tally)
    });
    assert!(5 * tally.counted("drawn") > scenes);
    // Where the cut is no better than that, a quarter of a pixel is not asked for.
    assert!(3 * tally.counted("points by pixels") > tally.counted("points"));
}

/// Points behind the plane, of objects that begin anywhere between the eye and the mirror, as they
/// appear on rays through the corners of what is seen, the middle, and between.
fn ghosts(input: &ViewInput, plan: &ReflectedViewPlan, tally: &mut Tally) -> Result<(), Broken> {
    let corners = Witness::of(input).screen();
    let middle = corners.iter().sum::<DVec2>() / corners.len() as f64;
    let inner = corners.iter().map(|corner| corner.lerp(middle, 0.4));
    for ndc in corners.iter().copied().chain(inner).chain([middle]) {
        for begin in [0.0, 0.3, 0.7, 0.9, 1.0] {
            ghost(input, plan, ndc, begin, tally)?;
        }
    }
    Ok(())
}

fn ghost(
    input: &ViewInput,
    plan: &ReflectedViewPlan,
    ndc: DVec2,
    begin: f64,
    tally: &mut Tally,
) -> Result<(), Broken> {
    let ViewInput {
        world_from_view,
        clip_from_view,
        plane,
        viewport_size,
        ..
    } = *input;
    // Around the eye, where nothing is lost far from the origin.
    let axes = DAffine3::from_mat3(world_from_view.matrix3);
    let clip_from_world = clip_from_view * DMat4::from(axes.inverse());
    let world = |depth: f64| {
        let view = clip_from_view.inverse() * ndc.extend(depth).extend(1.0);
        world_from_view.matrix3 * (view.truncate() / view.w)
    };
    let clip_w = |p: DVec3| clip_from_world.row(3).dot(p.extend(1.0));
    let (near, nearer) = (world(0.5), world(0.75));
    let along = near - nearer;
    let height = |p: DVec3| plan.eye_height + plane.normal.dot(p);
    let mirror = near - along * (height(near) / plane.normal.dot(along));
    let is_orthographic = clip_from_view.row(3).truncate() == DVec3::ZERO;
    let w = clip_w(mirror);
    let z = clip_from_world.row(2).dot(mirror.extend(1.0));
    let is_seen = w >= (1.0 - 1e-7) * plan.w_min && z >= 0.0;
    if !is_seen {
        return Ok(()); // Of a mirror without bounds: over the horizon, or beyond the far plane.
    }

    // The image of what is behind the plane is as far in front of it, and so nearer to the eye.
    let tolerance = plan.ghost_tolerance(begin * w, false);
    let behind = if is_orthographic {
        tolerance
    } else {
        tolerance.min((1.0 - begin) * plan.eye_height)
    };
    let along_normal = plane.normal.dot(along);
    let image = mirror + along * (behind / along_normal);
    let w = clip_w(image);
    tally.count("points");
    if behind <= clip_plane_error(plan.noise, plan.k, w) * (1.0 + 1e-6) {
        return Ok(());
    }
    tally.count("points by pixels");
    let pixel = |p: DVec3| {
        let clip = clip_from_world * p.extend(1.0);
        clip.truncate().truncate() / clip.w * viewport_size * 0.5
    };
    let away = plane.normal.any_orthonormal_vector();
    for (what, direction) in [
        ("to the plane", -plane.normal),
        ("along the plane", away),
        ("across", (away - plane.normal).normalize()),
    ] {
        let moved = pixel(image).distance(pixel(image + direction * behind));
        tally.bound(what, moved, GHOST_PX * (1.0 + 1e-6))?;
    }
    Ok(())
}
