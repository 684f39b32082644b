//! Ten thousand scenes through the vertex transform in `f32`, in three orders of evaluation.

use bevy_planar_mirror::math::*;
use glam::{DVec2, DVec3, DVec4, Mat4, Vec3};

use super::{
    tally::{Broken, Tally, run},
    witness::is_rigid,
};
use crate::{
    count::count,
    extremes::{Extreme, KINDS, Kind},
};

/// A clip coordinate of a point, given a row of the matrix.
type Order = fn([f32; 4], Vec3) -> f32;

const ORDERS: [Order; 3] = [
    |[x, y, z, w], p| ((x * p.x + y * p.y) + z * p.z) + w,
    |[x, y, z, w], p| x * p.x + (y * p.y + (z * p.z + w)),
    |[x, y, z, w], p| x.mul_add(p.x, y.mul_add(p.y, z.mul_add(p.z, w))),
];

struct Vertex {
    rows: [[f32; 4]; 4],
}

impl Vertex {
    fn new(plan: &ReflectedViewPlan) -> Self {
        let world_from_view = Mat4::from(plan.world_from_view.as_affine3a());
        let matrix = plan.clip_from_view_oblique.as_mat4() * world_from_view.inverse();
        Self {
            rows: [0, 1, 2, 3].map(|row| matrix.row(row).to_array()),
        }
    }

    fn z_and_w(&self, order: Order, p: Vec3) -> (f32, f32) {
        (order(self.rows[2], p), order(self.rows[3], p))
    }
}

#[test]
fn rounding_of_vertices_stays_within_its_bounds() {
    rounding("single precision", is_rigid);
}

#[test]
fn rounding_stays_within_its_bounds_for_stretched_cameras() {
    rounding("single precision, stretched", |input| !is_rigid(input));
}

/// What of each scene went beyond a bound is longer than the eye and the mirror are far away, or
/// measured in units of the camera.
#[test]
fn scenes_that_once_broke_a_bound_keep_it() {
    for (kind, seed) in [
        (Kind::Grazing, 14_422),
        (Kind::Grazing, 226_182),
        (Kind::Orthographic, 778),
        (Kind::Any, 82_525),
    ] {
        let input = Extreme::of(kind, seed).input().expect("a plane");
        let plan = plan_reflected_view(&input).expect("seen");
        if let Err(Broken(what, figures)) = rays(&input, &plan, &mut Tally::default()) {
            panic!("Extreme::of(Kind::{kind:?}, {seed}): {what}: {figures}");
        }
    }
}

fn rounding(title: &str, is_meant: fn(&ViewInput) -> bool) {
    let scenes = count(10_000, 300_000);
    let tally = run(title, &KINDS, scenes, |scene, tally| {
        let Some(input) = scene.input().filter(is_meant) else {
            return Ok(());
        };
        let Ok(plan) = plan_reflected_view(&input) else {
            tally.count("skipped");
            return Ok(());
        };
        tally.count("drawn");
        rays(&input, &plan, tally)
    });
    assert!(tally.counted("drawn") > 300);
    assert!(tally.counted("pairs of points") > 10_000);
}

/// Follows rays through the corners and the middle of what is seen from the mirror to far away.
fn rays(input: &ViewInput, plan: &ReflectedViewPlan, tally: &mut Tally) -> Result<(), Broken> {
    let corners: Vec<DVec2> = plan.polygon.ndc().collect();
    let middle = corners.iter().sum::<DVec2>() / corners.len() as f64;
    let projection = BaseProjection::new(&input.clip_from_view).expect("it was planned with");
    let plane_clip = projection.clip_covector(plan.plane_view);
    let vertex = Vertex::new(plan);
    let inner = corners.iter().map(|corner| corner.lerp(middle, 0.3));
    for ndc in corners.iter().copied().chain(inner).chain([middle]) {
        // On the mirror C^ . (x, y, z, 1) is 0, which gives the base depth there.
        let at_far = plane_clip.dot(ndc.extend(0.0).extend(1.0));
        let at_mirror = (-at_far / plane_clip.z).clamp(0.0, 1.0);
        for beyond in [0.0, 0.01, 0.3, 0.6, 1.0] {
            let depth = if projection.is_orthographic || input.clip_from_view.z_axis.z != 0.0 {
                at_mirror * (1.0 - beyond)
            } else {
                at_mirror * 10.0_f64.powf(-9.0 * beyond)
            };
            let view = projection.view_from_clip * ndc.extend(depth).extend(1.0);
            let view = view.truncate() / view.w;
            point(input, plan, &vertex, view, tally)?;
            order(input, plan, &vertex, view, tally)?;
        }
    }
    Ok(())
}

/// The `f32` point nearest to one of the view, its exact clip coordinates and signed distance.
fn real(input: &ViewInput, plan: &ReflectedViewPlan, view: DVec3) -> Option<(Vec3, DVec4, f64)> {
    let point = plan.world_from_view.transform_point3(view).as_vec3();
    let real = point.as_dvec3();
    let from_eye = real - plan.world_from_view.translation;
    let view = plan.world_from_view.matrix3.inverse() * from_eye;
    let clip = plan.clip_from_view_oblique * view.extend(1.0);
    let is_seen = point.is_finite()
        && clip.w >= 0.999 * plan.w_min
        && clip.x.abs() <= 1.001 * clip.w
        && clip.y.abs() <= 1.001 * clip.w;
    is_seen.then(|| (point, clip, input.plane.signed_distance(real)))
}

fn point(
    input: &ViewInput,
    plan: &ReflectedViewPlan,
    vertex: &Vertex,
    view: DVec3,
    tally: &mut Tally,
) -> Result<(), Broken> {
    let Some((point, clip, distance)) = real(input, plan, view) else {
        return Ok(());
    };
    let expected = 1.0 - plan.k * distance / clip.w;
    for evaluate in ORDERS {
        let (z, w) = vertex.z_and_w(evaluate, point);
        let depth = f64::from(z) / f64::from(w);
        let off = (depth - expected).abs();
        // What is behind the plane is cut, however wrong its depth.
        if distance >= 0.0 {
            let what = "depth of a vertex";
            tally
                .bound(what, off, depth_error(plan.noise))
                .map_err(|Broken(what, figures)| {
                    Broken(what, format!("{figures}: {point} at w {}", clip.w))
                })?;
            Tally::law("far points stay", z >= 0.0, || {
                format!("{point}: {z} of {w}")
            })?;
        }
        let cut = (f64::from(w) - f64::from(z)) / plan.k;
        let allowed = clip_plane_error(plan.noise, plan.k, clip.w);
        // Where the plane is, not far beyond, a cut happens.
        if distance.abs() <= 10.0 * allowed {
            tally.bound("distance of the cut", (cut - distance).abs(), allowed)?;
        }
    }
    Ok(())
}

/// Two points of a ray, apart by what the bound says: the nearer has the greater depth.
fn order(
    input: &ViewInput,
    plan: &ReflectedViewPlan,
    vertex: &Vertex,
    view: DVec3,
    tally: &mut Tally,
) -> Result<(), Broken> {
    let w = (input.clip_from_view * view.extend(1.0)).w;
    let is_orthographic = input.clip_from_view.row(3).truncate() == DVec3::ZERO;
    // Both may be wrong by that.
    let error = 2.0 * depth_error(plan.noise);
    if error > 0.25 {
        return Ok(());
    }
    let farther = if is_orthographic {
        let apart = error / (plan.k * -plan.plane_view.z);
        view - DVec3::Z * apart
    } else {
        let apart = error * w * w / (plan.k * plan.eye_height);
        if apart > 0.5 * w {
            return Ok(());
        }
        view * (1.0 + 1.1 * apart / w)
    };
    if (input.clip_from_view * farther.extend(1.0)).z < 0.0 {
        return Ok(()); // Beyond the camera's far plane.
    }
    let (Some((near, ..)), Some((far, ..))) = (real(input, plan, view), real(input, plan, farther))
    else {
        return Ok(());
    };
    tally.count("pairs of points");
    for evaluate in ORDERS {
        let depth = |p| {
            let (z, w) = vertex.z_and_w(evaluate, p);
            z / w
        };
        let (first, second) = (depth(near), depth(far));
        Tally::law("depth keeps the order", first > second, || {
            format!("{near} at {first} before {far} at {second}")
        })?;
    }
    Ok(())
}
