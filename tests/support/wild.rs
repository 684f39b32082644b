//! Random scenes at the extremes, to be drawn: the mirror and the camera of an [`Extreme`], and things along the rays
//! that the mirror reflects, so that they show however the numbers fall.

use bevy::{
    camera::ScalingMode,
    math::{DAffine3, DMat3, DQuat, DVec2, DVec3},
    prelude::*,
};
use bevy_planar_mirror::math::{
    ReflectedViewPlan, ViewInput, depth_error, plan_reflected_view, transform_patch,
};

use super::{
    extremes::{self, Extreme, Kind, Shares},
    props::sun,
    random::{Random, cone},
    scene::{Scene, Surface, exact},
};

/// Pixels of a picture, whatever its ratio.
const AREA: f64 = 128.0 * 96.0;
/// What must be seen of a mirror for a picture of it to say anything: so many pixels, none thinner than so many.
const LEAST: (f64, f64) = (400.0, 6.0);
/// A step of `f32` at the eye moves what is seen in the mirror by no more than so many pixels; it is that much at a
/// thousand units from the origin, seen at a distance of some meters.
const STEP_PX: f64 = 1.0 / 2048.0;
/// In scenes far off it is more than that, and less than this.
const STEP_PX_FAR_OFF: f64 = 1.0 / 16.0;

/// The scene of a seed: the same on every machine. In those of [`Kind::FarAway`] rounding shows.
///
/// What the plan leaves out is not among them: whether it does so rightly is asked by the tests of the maths.
pub fn scene(kind: Kind, seed: u64) -> Scene {
    let (scene, _) = drawn(kind, seed);
    scene
}

/// The tamest scene of a seed for which `fails` still holds.
pub fn tamest(kind: Kind, seed: u64, fails: &mut dyn FnMut(&Scene) -> bool) -> Scene {
    let (scene, shares) = drawn(kind, seed);
    let tamest = extremes::shrink(shares, |tamer| {
        furnished(kind, seed, tamer).is_some_and(|scene| fails(&scene))
    });
    furnished(kind, seed, &tamest).unwrap_or(scene)
}

fn drawn(kind: Kind, seed: u64) -> (Scene, Shares) {
    // Most mirrors of random cameras are not seen. Each seed has tries of its own.
    (0..)
        .map(|attempt| extremes::shares(seed + (attempt << 32)))
        .find_map(|shares| Some((furnished(kind, seed, &shares)?, shares)))
        .expect("some are seen")
}

fn furnished(kind: Kind, seed: u64, shares: &Shares) -> Option<Scene> {
    let extreme = Extreme::from_shares(kind, shares);
    let mut scene = Scene::new(&format!("wild-{seed}-{kind:?}"));
    scene.projection = projection(&extreme.projection);
    let ratio = match extreme.projection {
        extremes::Projection::Perspective { aspect, .. }
        | extremes::Projection::Orthographic { aspect, .. } => aspect,
    };
    let size = DVec2::new((AREA * ratio).sqrt(), (AREA / ratio).sqrt());
    scene.size = size.round().as_uvec2().max(UVec2::ONE);
    scene
        .projection
        .update(scene.size.x as f32, scene.size.y as f32);
    let camera = extreme.camera;
    scene.eye = Transform {
        rotation: rotation(camera.matrix3.z_axis, camera.matrix3.x_axis)?,
        translation: camera.translation.as_vec3(),
        scale: Vec3::ONE,
    };
    let half_size = extreme.half_size?.as_vec2();
    let surface = Surface::wall(
        2.0 * half_size.x,
        2.0 * half_size.y,
        place(&extreme.mirror)?,
    );
    let patch = extremes::patch(half_size.as_dvec2());
    let (plane, corners) = transform_patch(&patch, &exact(&surface.transform))?;
    let input = ViewInput {
        world_from_view: exact(&scene.eye),
        clip_from_view: scene.projection.get_clip_from_view().as_dmat4(),
        viewport_size: scene.size.as_dvec2(),
        plane,
        corners,
        jitter_px: 0.0,
        was_drawn: false,
    };
    let plan = plan_reflected_view(&input).ok()?;
    let (pixels, width) = LEAST;
    if plan.polygon.area_px(input.viewport_size) < pixels
        || plan.polygon.min_width_px(input.viewport_size) < width
    {
        return None;
    }
    let step_px = step_px(&input, &plan);
    let is_wanted = match kind {
        Kind::FarAway => (STEP_PX..STEP_PX_FAR_OFF).contains(&step_px),
        _ => step_px < STEP_PX,
    };
    if !is_wanted || !tells_depth(&input) {
        return None;
    }
    scene.mirrors.push(surface);

    // An orthographic view of what crosses the plane cannot be lit right: see the crate's docs.
    let random = &mut Random::new(seed ^ 0x5eed);
    let is_perspective = matches!(scene.projection, Projection::Perspective(_));
    let is_lit = random.below(2) == 0 && is_perspective;
    let things = things(random, &input, &plan);
    if things.is_empty() {
        return None;
    }
    for thing in things {
        let mesh: Mesh = match random.below(3) {
            0 => Cuboid::from_length(1.1).into(),
            1 => Sphere::new(0.9).mesh().uv(24, 16),
            _ => cone(0.7),
        };
        let look = random.look(is_lit);
        let transform = Transform {
            translation: thing.center.as_vec3(),
            rotation: random.rotation(),
            scale: Vec3::splat(thing.radius as f32),
        };
        scene = scene.object(mesh, look, transform);
    }
    if is_lit {
        scene.ambient.brightness = 100.0;
        scene = scene.prop(sun(false));
    }
    Some(scene)
}

/// The same projection by the engine's own numbers. It is on center, and a perspective has no far plane.
fn projection(projection: &extremes::Projection) -> Projection {
    match *projection {
        extremes::Projection::Perspective { fov, near, .. } => PerspectiveProjection {
            fov: fov as f32,
            near: near as f32,
            // Only culling reads it.
            far: 1e12,
            ..default()
        }
        .into(),
        extremes::Projection::Orthographic {
            height, near, far, ..
        } => OrthographicProjection {
            scaling_mode: ScalingMode::FixedVertical {
                viewport_height: height as f32,
            },
            near: near as f32,
            far: far as f32,
            ..OrthographicProjection::default_3d()
        }
        .into(),
    }
}

/// The rotation whose z is `z`, and whose x is as near to `x` as can be.
fn rotation(z: DVec3, x: DVec3) -> Option<Quat> {
    let z = z.try_normalize()?;
    let x = x.reject_from_normalized(z).try_normalize()?;
    let axes = DMat3::from_cols(x, z.cross(x), z);
    Some(DQuat::from_mat3(&axes).as_quat().normalize())
}

/// The transform of a mirror: scaled, flattened, turned inside out; but not sheared, which a [`Transform`] cannot say.
fn place(mirror: &DAffine3) -> Option<Transform> {
    let DMat3 {
        x_axis,
        y_axis,
        z_axis,
    } = mirror.matrix3;
    let front = x_axis.cross(y_axis).try_normalize()?;
    let upright = front.cross(x_axis.normalize());
    let scale = DVec3::new(x_axis.length(), y_axis.dot(upright), z_axis.dot(front));
    Some(Transform {
        translation: mirror.translation.as_vec3(),
        rotation: rotation(front, x_axis)?,
        scale: scale.as_vec3(),
    })
}

/// Whether a ball stands before most of what the camera sees of the mirror.
fn hides_mirror(input: &ViewInput, plan: &ReflectedViewPlan, center: DVec3, radius: f64) -> bool {
    let seen = input.world_from_view.inverse().transform_point3(center);
    let w = if is_orthographic(input) { 1.0 } else { -seen.z };
    let size_px = radius * px_per_unit(input) / w;
    let beside = (seen.truncate() * scale(input) / w - middle(plan)) * input.viewport_size * 0.5;
    let area = plan.polygon.area_px(input.viewport_size);
    w > 0.0 && size_px > 0.4 * area.sqrt() && beside.length() < size_px
}

/// Of what is seen of the mirror, on the screen.
fn middle(plan: &ReflectedViewPlan) -> DVec2 {
    plan.polygon.ndc().sum::<DVec2>() / plan.polygon.ndc().count() as f64
}

/// Whether the camera itself can tell which of two things is before the other, when they are a part of a pixel apart.
/// The depth of an orthographic camera has the same steps everywhere: long ones, if it reaches far.
fn tells_depth(input: &ViewInput) -> bool {
    let step = 0.5 * f64::from(f32::EPSILON) / input.clip_from_view.z_axis.z;
    !is_orthographic(input) || step * px_per_unit(input) < 1.0 / 16.0
}

/// By how many pixels a step of `f32` at the eye moves the nearest that is seen in the mirror.
fn step_px(input: &ViewInput, plan: &ReflectedViewPlan) -> f64 {
    let places = eyes(input, plan).map(|eye| eye.abs().max_element());
    let step = f64::from(f32::EPSILON) * places[0].max(places[1]);
    let w = if is_orthographic(input) {
        1.0
    } else {
        plan.w_min
    };
    step * px_per_unit(input) / w
}

/// The camera's and its image in the mirror.
fn eyes(input: &ViewInput, plan: &ReflectedViewPlan) -> [DVec3; 2] {
    [
        input.world_from_view.translation,
        plan.world_from_view.translation,
    ]
}

fn is_orthographic(input: &ViewInput) -> bool {
    input.clip_from_view.w_axis.w == 1.0
}

/// Where clip `w` is 1.
fn px_per_unit(input: &ViewInput) -> f64 {
    (scale(input) * input.viewport_size * 0.5).max_element()
}

fn scale(input: &ViewInput) -> DVec2 {
    DVec2::new(input.clip_from_view.x_axis.x, input.clip_from_view.y_axis.y)
}

/// A ball that something fills.
struct Thing {
    center: DVec3,
    radius: f64,
    /// Two things must be so far apart for their order to show.
    apart: f64,
}

/// Four before the mirror, at any distance from it; two that go through it; one behind it. None where the picture has
/// no room.
fn things(random: &mut Random, input: &ViewInput, plan: &ReflectedViewPlan) -> Vec<Thing> {
    let is_orthographic = is_orthographic(input);
    let (scale, px_per_unit) = (scale(input), px_per_unit(input));
    // What crosses it is cut there only where nothing crosses the mirror.
    let far = if is_orthographic {
        input.clip_from_view.w_axis.z / input.clip_from_view.z_axis.z
    } else {
        f64::INFINITY
    };
    let eyes = eyes(input, plan);
    let corners: Vec<_> = plan.polygon.ndc().collect();
    let center = middle(plan);
    let mut things: Vec<Thing> = Vec::new();
    for index in 0..7 {
        let mut share = || f64::from(random.between(0.0, 1.0));
        let corner = corners[(share() * corners.len() as f64) as usize % corners.len()];
        let ndc = center.lerp(corner, share().sqrt());
        // From the eye to depth 1, or from depth 0 to 1.
        let across = (ndc / scale).extend(0.0);
        let (from, along) = if is_orthographic {
            (across, -DVec3::Z)
        } else {
            (DVec3::ZERO, across - DVec3::Z)
        };
        let plane = plan.plane_view;
        let slope = plane.truncate().dot(along);
        let mirror = -(plane.truncate().dot(from) + plane.w) / slope;
        let (beyond, lift) = (10.0_f64.powf(-1.5 + 4.0 * share()), 2.0 * share() - 1.0);
        let size_px = 3.0 * 15.0_f64.powf(share());
        let scale_of = |depth: f64| if is_orthographic { 1.0 } else { depth };
        let at = |depth: f64| plan.world_from_view.transform_point3(from + along * depth);
        let radius_at = |depth: f64| size_px * scale_of(depth) / px_per_unit;
        let depth = match index {
            0..=3 if is_orthographic => mirror + beyond * 10.0 / px_per_unit,
            0..=3 => mirror * (1.0 + beyond),
            _ => mirror,
        };
        let mut radius = radius_at(depth);
        let normal = input.plane.normal;
        let center = match index {
            0..=3 => {
                let center = at(depth);
                radius = radius.min(input.plane.signed_distance(center) / 1.2);
                center
            }
            4 | 5 => at(depth) + normal * (0.6 * lift * radius),
            _ => at(depth) - normal * ((3.0 + 2.0 * lift) * radius),
        };
        let rate = 2.0 * depth_error(plan.noise) / plan.k;
        let apart = if is_orthographic {
            rate / slope
        } else {
            rate * depth * depth / plan.eye_height
        };
        let thing = Thing {
            center,
            radius,
            apart,
        };
        let has_room = eyes
            .iter()
            .all(|eye| is_orthographic || eye.distance(center) > 2.0 * radius)
            && things.iter().all(|other| {
                let apart = other.radius + radius + 2.0 * thing.apart.max(other.apart);
                other.center.distance(center) > apart
            });
        let shows = radius * px_per_unit > 1.5 * scale_of(depth)
            && depth + 1.5 * radius < far
            && !hides_mirror(input, plan, center, radius);
        if has_room && shows && center.as_vec3().is_finite() && radius as f32 > 1e-12 {
            things.push(thing);
        }
    }
    things
}
