//! What the maths say of rounding, on the rasterizer: where the near plane cuts, which of two panels behind it is seen,
//! and that nothing far away is lost.

use std::f32::consts::PI;

use bevy::{
    math::{DAffine3, DMat4, DVec2, DVec3},
    prelude::*,
    render::renderer::RenderAdapterInfo,
};
use bevy_planar_mirror::{
    MirrorClip,
    math::{self, ReflectedViewPlan, ViewInput, depth_error, plan_reflected_view},
};

use crate::support::{
    count::count,
    mask::Mask,
    picture::Picture,
    props::{BLUE, GREEN, RED, at, is},
    random::Random,
    reference::reflected_eye,
    scene::{Scene, Surface, exact},
    studio::Studio,
};

/// The projection as the engine has it.
fn clip_from_view(scene: &Scene) -> DMat4 {
    let mut projection = scene.projection.clone();
    projection.update(scene.size.x as f32, scene.size.y as f32);
    projection.get_clip_from_view().as_dmat4()
}

/// The plan of a scene with one mirror, a wall of this size.
fn plan(scene: &Scene, size: Vec2) -> ReflectedViewPlan {
    let place = exact(&scene.mirrors[0].transform);
    let half = size.as_dvec2() / 2.0;
    let corner = |x: f64, y: f64| place.transform_point3(DVec3::new(x * half.x, y * half.y, 0.0));
    let plane = math::Plane::new(place.translation, place.z_axis).expect("a plane");
    let input = ViewInput {
        world_from_view: exact(&scene.eye),
        clip_from_view: clip_from_view(scene),
        viewport_size: scene.size.as_dvec2(),
        plane,
        corners: Some([
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ]),
        jitter_px: 0.0,
        was_drawn: false,
    };
    plan_reflected_view(&input).expect("the mirror is seen")
}

fn frames() -> [(&'static str, Transform); 3] {
    let tilted = Quat::from_euler(EulerRot::XYZ, 0.4, -0.9, 1.3);
    [
        ("at the origin", Transform::default()),
        ("10 units away", at_distance(10.0, tilted)),
        ("1000 units away", at_distance(1000.0, tilted)),
    ]
}

fn at_distance(distance: f32, rotation: Quat) -> Transform {
    Transform::from_translation(vec3(0.8, -0.36, 0.48) * distance).with_rotation(rotation)
}

/// Eyes before a mirror in the plane z = 0, what they look at, and the mirror's size.
const EYES: [(&str, Vec3, Vec3, Vec2); 4] = [
    ("head-on", vec3(0.0, 0.0, 3.0), Vec3::ZERO, vec2(3.0, 2.0)),
    ("aslant", vec3(2.0, 1.0, 2.5), Vec3::ZERO, vec2(3.0, 2.0)),
    (
        "a room's floor",
        vec3(0.0, -6.0, 1.6),
        vec3(0.0, 0.0, 0.2),
        vec2(8.0, 8.0),
    ),
    (
        "grazing",
        vec3(0.0, -6.0, 0.1),
        vec3(0.0, 6.0, 0.1),
        vec2(8.0, 8.0),
    ),
];

/// The mirror cuts whether something crosses it or not.
fn watched(name: &str, frame: Transform, (eye, target, size): (Vec3, Vec3, Vec2)) -> Scene {
    let mut scene = Scene::new(name).mirror(Surface::wall(size.x, size.y, frame));
    let up = frame.rotation
        * if eye.x == 0.0 && eye.y == 0.0 {
            Vec3::Y
        } else {
            Vec3::Z
        };
    scene.eye = Transform::from_translation(frame * eye).looking_at(frame * target, up);
    scene.mirrors[0].mirror.clip = MirrorClip::Oblique;
    // In a corner before the eye, so that no picture is of one color. The mirrors show its back, which is culled.
    let card = scene.eye * at(-0.5, 0.37, -1.0);
    scene.object(Rectangle::new(0.1, 0.1), GREEN, card)
}

/// Across the whole reflected view at view depth `w`; returns where it really is, after rounding.
fn panel(scene: &mut Scene, color: Color, w: f64) -> f64 {
    let eye = reflected_eye(&scene.eye, scene.mirrors[0].plane());
    let axes = exact(&eye);
    let forward = -axes.matrix3.z_axis;
    let place = (axes.translation + forward * w).as_vec3();
    let transform = eye.with_translation(place);
    let size = 3.0 * w as f32;
    *scene = scene
        .clone()
        .object(Rectangle::new(size, size), color, transform);
    forward.dot(place.as_dvec3() - axes.translation)
}

/// How many of a mirror's pixels show red, and how many do not.
fn red_and_other(studio: &mut Studio, scene: &Scene, mask: &Mask) -> (usize, usize) {
    let picture = studio.picture(scene);
    let inside = picture.places().filter(|place| mask.inside(*place));
    let red = inside.filter(|at| is(RED)(picture.at(at.x, at.y))).count();
    assert!(mask.inside_count() > 50, "{}: too few pixels", scene.name);
    (red, mask.inside_count() - red)
}

/// Two parallel panels that face the reflected eye, the farther one blue: as far apart as both may be wrong, the nearer
/// one is seen at every pixel. Much closer together they are confused somewhere.
#[test]
fn panels_as_far_apart_as_the_maths_ask_for_keep_their_order() {
    let mut studio = Studio::default();
    let (mut kept, mut confused, mut worst) = (0, 0, 0.0_f64);
    for (place, frame) in frames() {
        for (name, eye, target, size) in EYES {
            let bare = watched("panels", frame, (eye, target, size));
            let plan = plan(&bare, size);
            // All panels are beyond the mirror.
            let mask = studio.mask(&bare, 0);
            for times in [4.0, 40.0, 400.0] {
                let w = times * plan.w_min.max(eye.length().into());
                let apart = 2.0 * depth_error(plan.noise) * w * w / (plan.k * plan.eye_height);
                // As large as the distance itself: then nothing is promised.
                if apart > 0.5 * w {
                    println!("{name} {place}, at {w:.0}: nothing is resolved");
                    continue;
                }
                kept += 1;
                let mut least = f64::INFINITY;
                for share in [64.0, 16.0, 4.0, 1.0, 1.0 / 8.0, 1.0 / 64.0] {
                    if share * apart > w {
                        continue;
                    }
                    let mut scene = bare.clone();
                    scene.name = format!("panels-{name}-{place}-{times}-{share}");
                    let far = panel(&mut scene, BLUE, w + share * apart);
                    let near = panel(&mut scene, RED, w);
                    let (_, other) = red_and_other(&mut studio, &scene, &mask);
                    if other > 0 || far <= near {
                        confused += usize::from(far > near);
                        break;
                    }
                    least = (far - near) / apart;
                }
                println!(
                    "{name} {place}, at {w:.0}: {apart:.1e} promised, {least:.3} of that kept"
                );
                worst = worst.max(least);
            }
        }
    }
    // The bound is that of the vertices. How exactly a rasterizer follows the slope of a large triangle between them, no
    // standard says: an NVIDIA H200 misses it by up to four times, in 2 of these cases.
    let info = studio
        .stage()
        .render_world()
        .resource::<RenderAdapterInfo>();
    let is_exact = format!("{:?}", info.device_type) == "Cpu";
    let allowed = if is_exact { 1.01 } else { 4.01 };
    assert!(
        worst <= allowed,
        "order is kept only {worst} times as far apart"
    );
    assert!(kept > 15, "only {kept} promises");
    assert!(
        confused > 0,
        "nothing is ever confused: the panels test nothing"
    );
}

#[test]
fn nothing_far_away_is_lost() {
    let mut studio = Studio::default();
    for (place, frame) in frames() {
        for (name, eye, target, size) in EYES {
            let bare = watched("far", frame, (eye, target, size));
            let mask = studio.mask(&bare, 0);
            for w in [1e3, 1e7] {
                let mut scene = bare.clone();
                scene.name = format!("far-{name}-{place}-{w}");
                panel(&mut scene, RED, w);
                let (red, other) = red_and_other(&mut studio, &scene, &mask);
                assert_eq!(other, 0, "{}: {red} pixels are there", scene.name);
            }
        }
    }
}

const CUT_SIZE: UVec2 = uvec2(320, 240);
const CUT_MIRROR: Vec2 = vec2(12.0, 12.0);

/// A sheet through the mirror, seen in it and not beside it: its front looks down.
struct Leaning {
    scene: Scene,
    sheet: Transform,
    size: Vec2,
}

impl Leaning {
    /// `None` where the camera sees its front, or the reflection does not.
    fn of(seed: u64, frame: Transform) -> Option<Self> {
        let random = &mut Random::new(seed);
        let eye = vec3(
            random.between(-3.0, 3.0),
            random.between(-4.0, -2.0),
            random.between(1.5, 4.0),
        );
        let mut scene = watched("cut", frame, (eye, Vec3::ZERO, CUT_MIRROR));
        scene.name = format!("cut-{seed}");
        scene.size = CUT_SIZE;
        let size = vec2(random.between(1.5, 3.0), random.between(1.0, 2.0));
        let place = random.within(vec3(-0.5, -0.5, -0.2), vec3(0.5, 0.5, 0.2));
        // From lying with its front down to standing, and about any axis in the mirror's plane.
        let lean = Quat::from_rotation_x(random.between(0.55, 0.85) * PI);
        let turn = Quat::from_rotation_z(random.between(-PI, PI));
        let local = Transform::from_translation(place).with_rotation(turn * lean);
        let sheet = frame * local;
        let front = exact(&sheet).matrix3.z_axis;
        let plane = scene.mirrors[0].plane();
        let eye = scene.eye.translation.as_dvec3();
        let height = |eye: DVec3| front.dot(eye - sheet.translation.as_dvec3());
        let is_seen = height(eye) < -0.2 && height(plane.reflect(eye)) > 0.2;
        scene = scene.object(Rectangle::new(size.x, size.y), RED, sheet);
        is_seen.then_some(Self { scene, sheet, size })
    }

    /// How far a place of the picture is from where the sheet enters the mirror, and whether it is on the side of the
    /// sheet's image. `None` where that line is not near, or its ends or the image's other side are.
    fn beside_the_cut(&self, at: DVec2) -> Option<(f64, bool)> {
        let clip = clip_from_view(&self.scene);
        let world_from_view = exact(&self.scene.eye);
        let view_from_world = world_from_view.inverse();
        let pixel = |p: DVec3| {
            let clip = clip * view_from_world.transform_point3(p).extend(1.0);
            let ndc = DVec2::new(clip.x, -clip.y) / clip.w;
            (ndc + 1.0) * 0.5 * CUT_SIZE.as_dvec2()
        };
        let plane = self.scene.mirrors[0].plane();
        let [low, high] = cut_line(&exact(&self.sheet), self.size.as_dvec2(), |p| {
            plane.height(p)
        })?;
        let (a, b) = (pixel(low), pixel(high));
        let along = (b - a).normalize();
        let place_of = |p: DVec2| (along.dot(p - a), along.perp_dot(p - a));
        let (t, beside) = place_of(at);
        // The far side of the image of what is before the plane.
        let place = exact(&self.sheet);
        let upper = 0.5 * f64::from(self.size.y) * plane.normal.dot(place.matrix3.y_axis).signum();
        let [(t_a, beyond_a), (t_b, beyond_b)] = [-0.5, 0.5].map(|x| {
            let corner = DVec3::new(x * f64::from(self.size.x), upper, 0.0);
            place_of(pixel(plane.reflect(place.transform_point3(corner))))
        });
        let length = (b - a).length();
        // By so much its ends may lean inward in the one pixel beside the cut that is looked at.
        let lean = (t_a / beyond_a)
            .abs()
            .max(((t_b - length) / beyond_b).abs());
        let is_near = beside.abs() <= 1.0 && t > 4.0 + lean && t < length - 4.0 - lean;
        if !is_near || beyond_a * beyond_b < 0.0 || beyond_a.abs().min(beyond_b.abs()) < 3.0 {
            return None;
        }
        Some((beside.abs(), beyond_a.signum() == beside.signum()))
    }
}

/// Where a sheet in the plane z = 0 of `place` has height 0: from its one side to the other.
fn cut_line(place: &DAffine3, size: DVec2, height: impl Fn(DVec3) -> f64) -> Option<[DVec3; 2]> {
    let end = |x: f64| {
        let [low, high] =
            [-0.5, 0.5].map(|y| place.transform_point3(DVec3::new(x * size.x, y * size.y, 0.0)));
        let (from, to) = (height(low), height(high));
        (from * to < 0.0).then(|| low.lerp(high, from / (from - to)))
    };
    Some([end(-0.5)?, end(0.5)?])
}

/// The farthest pixel from the cut that is on its wrong side.
fn cut_error(picture: &Picture, leaning: &Leaning) -> (f64, usize) {
    let mut near = 0;
    let worst = picture
        .places()
        .filter_map(|at| {
            let (beside, is_image) = leaning.beside_the_cut(at.as_dvec2() + 0.5)?;
            near += 1;
            let is_wrong = is(RED)(picture.at(at.x, at.y)) != is_image;
            Some(if is_wrong { beside } else { 0.0 })
        })
        .fold(0.0, f64::max);
    (worst, near)
}

/// Sheets at all angles, of which the mirror shows the side that the camera does not see: a pixel whose center is farther
/// from the cut than what it may be off is on its right side.
#[test]
fn the_cut_is_where_it_should_be() {
    let mut studio = Studio::default();
    // The rasterizer moves both ends of an edge to a grid of 1/256 pixel.
    let grid = 0.5_f64.sqrt() / 256.0;
    for ((place, frame), allowed) in frames().into_iter().zip([0.01, 0.01, 0.02]) {
        let (mut worst, mut pixels, mut scenes) = (0.0_f64, 0, 0);
        let leaning = (3000..).filter_map(|seed| Leaning::of(seed, frame));
        for leaning in leaning.take(count(12, 60) as usize) {
            let picture = studio.picture(&leaning.scene);
            let (error, near) = cut_error(&picture, &leaning);
            if error > worst {
                println!("{} {place}: {error:.4} px", leaning.scene.name);
            }
            worst = worst.max(error);
            pixels += near;
            scenes += 1;
        }
        println!("{place}: {worst:.4} px in {scenes} scenes, of {pixels} pixels beside the cut");
        assert!(pixels > 100 * scenes, "{place}: {pixels} pixels");
        assert!(worst <= allowed + grid, "{place}: {worst} px");
    }
}

/// The measure finds a mirror that is three hundredths of a unit too high.
#[test]
fn a_cut_beside_its_place_is_found() {
    let frame = Transform::default();
    let leaning = (3000..)
        .find_map(|seed| Leaning::of(seed, frame))
        .expect("one");
    let mut raised = leaning.scene.clone();
    raised.mirrors[0].transform.translation.z += 0.03;
    let picture = Studio::default().picture(&raised);
    let (error, _) = cut_error(&picture, &leaning);
    assert!(error > 0.1, "{error} px");
}
