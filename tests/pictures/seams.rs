//! The mirror and the picture around it meet: along the mirror's edge, and along the line where something enters it.
//!
//! No gap in between and no pixel drawn twice, by what one knows of the scenes: along the edge stock Bevy draws both sides
//! one by one, and what stands upright in a mirror makes a convex body together with its reflection.

use std::f32::consts::{FRAC_PI_2, PI};

use bevy::prelude::*;
use bevy_planar_mirror::{MirrorState, status::Projection::Oblique};

use super::cameras::states;
use crate::support::{
    count::count,
    picture::{Picture, Unlike},
    props::{BLUE, MAGENTA, RED, bytes, is},
    random::{self, Kind, Random},
    scene::{Look, Scene, Surface},
    studio::{Studio, TOLERANCE},
};

const SIZE: UVec2 = uvec2(128, 96);

/// Scenes of each kind, and where all are asked for.
const USUAL: u64 = 10;
const FULL: u64 = 50;

/// A random scene with a wall a hand's breadth behind its mirror: in whatever gap there was, the wall would be seen.
fn walled(seed: u64, kind: Kind) -> Scene {
    let mut scene = random::scene(seed, kind);
    scene.name = format!("edge-{seed}-{kind:?}");
    scene.size = SIZE;
    let mirror = scene.mirrors[0].transform;
    let place = mirror.translation - mirror.rotation * Vec3::Z * 0.02;
    let wall = Transform::from_translation(place).with_rotation(mirror.rotation);
    for object in &mut scene.objects {
        // Beside a cut the reference is not lit as the whole object is.
        if let Look::Standard(material) = &mut object.look {
            material.unlit = true;
        }
    }
    scene.object(Rectangle::new(40.0, 40.0), BLUE, wall)
}

/// The scene with paint where its mirror is.
fn painted(scene: &Scene) -> Scene {
    let mut painted = scene.clone();
    painted.mirrors[0] = painted.mirrors[0].clone().look(MAGENTA);
    painted
}

/// What stock Bevy makes of a scene: the picture where no mirror is seen, the reference where it is.
struct Composed {
    picture: Picture,
    /// The mirror painted, and everything before it.
    painted: Picture,
    reference: Picture,
}

impl Composed {
    fn new(studio: &mut Studio, scene: &Scene) -> Self {
        let painted = studio.without_mirrors(&painted(scene));
        // Not flipped: a pixel whose center lies on an edge must fall to the same side.
        let reference = studio.reference_in_place(scene, 0);
        let picture = Picture::from_fn(scene.size, |x, y| {
            let side = if is(MAGENTA)(painted.at(x, y)) {
                &reference
            } else {
                &painted
            };
            side.at(x, y)
        });
        Self {
            picture,
            painted,
            reference,
        }
    }

    fn is_mirror(&self, place: UVec2) -> bool {
        is(MAGENTA)(self.painted.at(place.x, place.y))
    }

    /// The pixels of one side that touch the other.
    fn along_the_edge(&self, place: UVec2) -> bool {
        let (low, high) = (place.saturating_sub(UVec2::ONE), place + 1);
        let high = high.min(SIZE - 1);
        (low.y..=high.y)
            .flat_map(|y| (low.x..=high.x).map(move |x| uvec2(x, y)))
            .any(|other| self.is_mirror(other) != self.is_mirror(place))
    }
}

/// Along the edge every pixel is that of one side or of the other, whichever is there: never the wall behind the
/// mirror, the clear color, or something of both. Of the pixels of all scenes `share` may be otherwise.
fn assert_edges_meet(kind: Kind, first: u64, share: f64) {
    let mut studio = Studio::default();
    let (mut pixels, mut odd, mut scenes) = (0, 0, 0);
    for seed in first..first + count(USUAL, FULL) {
        let scene = walled(seed, kind);
        let composed = Composed::new(&mut studio, &scene);
        let picture = studio.picture(&scene);
        let along = |place| composed.along_the_edge(place);
        let difference = picture.difference(&composed.picture, TOLERANCE, along);
        let difference = difference.unwrap_or_else(|unlike| panic!("{}: {unlike}", scene.name));
        if difference.beyond > 0 {
            let saved = [
                picture.save(&scene.name),
                composed.picture.save(&format!("{}-expected", scene.name)),
            ];
            println!("seams::walled({seed}, Kind::{kind:?}): {difference}: {saved:?}");
        }
        pixels += difference.compared;
        odd += difference.beyond;
        scenes += 1;
    }
    println!("{kind:?}: {odd} of {pixels} pixels along {scenes} edges are odd");
    assert!(pixels > 100 * scenes, "only {pixels} in {scenes} scenes");
    assert!(
        odd as f64 <= share * pixels as f64,
        "{odd} of {pixels} pixels along edges of {kind:?} scenes, see above"
    );
}

#[test]
fn edges_meet_in_scenes_of_any_kind() {
    assert_edges_meet(Kind::Any, 1000, 0.0);
}

#[test]
fn edges_meet_head_on() {
    assert_edges_meet(Kind::HeadOn, 1100, 0.0);
}

#[test]
fn edges_meet_at_grazing_angles() {
    assert_edges_meet(Kind::Grazing, 1200, 0.0);
}

#[test]
fn edges_meet_in_orthographic_views() {
    assert_edges_meet(Kind::Orthographic, 1300, 0.001);
}

#[test]
fn edges_meet_far_from_the_origin() {
    assert_edges_meet(Kind::FarAway, 1400, 0.001);
}

/// The engine draws an opaque mirror itself, and by other programs than ours: to be seen, what the mirror shows must be
/// before that at every pixel.
#[test]
fn no_pixel_of_an_opaque_mirror_shows() {
    let mut studio = Studio::default();
    for (kind, seed) in [(Kind::Orthographic, 1300), (Kind::FarAway, 1400)] {
        for seed in seed..seed + 5 {
            for away in [0.0, 3000.0] {
                let mut scene = painted(&walled(seed, kind));
                scene.name = format!("opaque-{seed}-{kind:?}-{away}");
                let by = vec3(0.6, -0.5, 0.7) * away;
                scene.eye.translation += by;
                scene.mirrors[0].transform.translation += by;
                for object in &mut scene.objects {
                    object.transform.translation += by;
                }
                let paint = studio.without_mirrors(&scene).count(is(MAGENTA));
                assert!(paint > 300, "{}: {paint} pixels", scene.name);
                let left = studio.picture(&scene).count(is(MAGENTA));
                assert_eq!(left, 0, "{}: of {paint} pixels", scene.name);
            }
        }
    }
}

fn with_pixel(picture: &Picture, at: UVec2, pixel: [u8; 4]) -> Picture {
    Picture::from_fn(picture.size(), |x, y| {
        if uvec2(x, y) == at {
            pixel
        } else {
            picture.at(x, y)
        }
    })
}

#[test]
fn one_wrong_pixel_along_an_edge_is_found() {
    let scene = walled(1000, Kind::Any);
    let composed = Composed::new(&mut Studio::default(), &scene);
    let along = |place| composed.along_the_edge(place);
    let wall = bytes(BLUE);
    let first = |is_mirror: bool, pixel: &dyn Fn(UVec2) -> [u8; 4]| {
        let mut places = composed.picture.places();
        places
            .find(|place| {
                let pixels = [pixel(*place), composed.picture.at(place.x, place.y)];
                along(*place)
                    && composed.is_mirror(*place) == is_mirror
                    && pixels[0]
                        .iter()
                        .zip(pixels[1])
                        .any(|(a, b)| a.abs_diff(b) > 2)
            })
            .map(|place| with_pixel(&composed.picture, place, pixel(place)))
            .expect("such a pixel")
    };
    let gap = first(true, &|_| wall);
    let hole = first(true, &|_| bytes(scene.clear_color));
    let doubled = first(false, &|place| composed.reference.at(place.x, place.y));
    for (what, wrong) in [("gap", gap), ("hole", hole), ("doubled", doubled)] {
        let unlike = wrong.alike(&composed.picture, TOLERANCE, 1.0, along);
        assert!(
            matches!(unlike, Err(Unlike::Pixels(difference)) if difference.beyond == 1),
            "{what}: {unlike:?}"
        );
    }
}

/// A red body in the plane of a mirror that is large enough to show all of its reflection: prisms and cones that stand
/// upright in it and balls whose centers are behind it.
///
/// What is before the plane leans nowhere outward, so it and its reflection are one convex body.
fn wading(seed: u64, kind: Kind) -> Scene {
    let mut scene = random::scene(seed, kind);
    scene.name = format!("waterline-{seed}-{kind:?}");
    scene.size = SIZE;
    scene.objects.clear();
    scene.props.clear();
    let place = scene.mirrors[0].transform;
    let size = vec2(18.0, 16.0) / place.scale.truncate();
    scene.mirrors[0] = Surface::wall(size.x, size.y, place);

    let random = &mut Random::new(seed + 5000);
    let (radius, half) = (random.between(0.3, 0.6), random.between(0.3, 0.8));
    let upright = Quat::from_rotation_x(FRAC_PI_2);
    let (mesh, depth, rotation): (Mesh, f32, Quat) = match random.below(4) {
        0 => {
            let other = random.between(0.3, 0.6);
            let mesh = Cuboid::new(2.0 * radius, 2.0 * other, 2.0 * half);
            (
                mesh.into(),
                random.between(-0.6, 0.6) * half,
                Quat::IDENTITY,
            )
        }
        1 => {
            let mesh = Cylinder::new(radius, 2.0 * half);
            (mesh.into(), random.between(-0.6, 0.6) * half, upright)
        }
        2 => {
            let mesh = Cone::new(radius, 2.0 * half);
            (mesh.into(), random.between(-0.6, 0.6) * half, upright)
        }
        _ => {
            let mesh = Sphere::new(1.5 * radius).mesh().uv(48, 24);
            let depth = -random.between(0.3, 0.9) * radius;
            (mesh, depth, Quat::from_rotation_x(random.between(-PI, PI)))
        }
    };
    if let Projection::Perspective(lens) = &mut scene.projection {
        lens.fov = lens.fov.min(0.9);
    }
    let across = vec3(random.between(-0.6, 0.6), random.between(-0.3, 0.6), depth);
    let turn = Quat::from_rotation_z(random.between(-PI, PI));
    let transform = Transform {
        translation: place.translation + place.rotation * across,
        rotation: place.rotation * turn * rotation,
        scale: Vec3::ONE,
    };
    scene.object(mesh, RED, transform)
}

/// The pixels of another color between two red ones of their row or column.
fn gaps(picture: &Picture) -> Vec<UVec2> {
    let size = picture.size();
    let red = |x: u32, y: u32| is(RED)(picture.at(x, y));
    let between = |length: u32, red: &dyn Fn(u32) -> bool| {
        let first = (0..length).find(|i| red(*i)).unwrap_or(length);
        first..(first..length).rfind(|i| red(*i)).unwrap_or(first)
    };
    let rows: Vec<_> = (0..size.y)
        .map(|y| between(size.x, &|x| red(x, y)))
        .collect();
    let columns: Vec<_> = (0..size.x)
        .map(|x| between(size.y, &|y| red(x, y)))
        .collect();
    let inside =
        |at: &UVec2| rows[at.y as usize].contains(&at.x) || columns[at.x as usize].contains(&at.y);
    let places = picture.places();
    places.filter(|at| inside(at) && !red(at.x, at.y)).collect()
}

/// Where a pixel of the body itself touches one of its reflection.
fn waterline<'a>(picture: &'a Picture, itself: &'a Picture) -> impl Iterator<Item = UVec2> {
    let red = |picture: &Picture, at: UVec2| is(RED)(picture.at(at.x, at.y));
    let reflected = move |at: UVec2| red(picture, at) && !red(itself, at);
    let size = picture.size();
    picture.places().filter(move |place| {
        let beside = [
            place.with_x((place.x + 1).min(size.x - 1)),
            place.with_x(place.x.saturating_sub(1)),
            place.with_y((place.y + 1).min(size.y - 1)),
            place.with_y(place.y.saturating_sub(1)),
        ];
        red(itself, *place) && beside.into_iter().any(reflected)
    })
}

/// A cut `error` pixels beside the plane leaves a gap at that share of the waterline's pixels at the most.
fn assert_waterlines_close(kind: Kind, first: u64, error: f64) {
    let mut studio = Studio::default();
    let (mut pixels, mut open, mut scenes) = (0, 0, 0);
    for seed in first..first + count(USUAL, FULL) {
        let scene = wading(seed, kind);
        let picture = studio.picture(&scene);
        assert_eq!(
            states(studio.stage()),
            [MirrorState::Drawn(Oblique)],
            "{}",
            scene.name
        );
        let itself = studio.without_mirrors(&painted(&scene));
        pixels += waterline(&picture, &itself).count();
        scenes += 1;
        let found = gaps(&picture);
        if !found.is_empty() {
            let saved = picture.save(&scene.name);
            println!("seams::wading({seed}, Kind::{kind:?}): gaps at {found:?}: {saved}");
        }
        open += found.len();
    }
    println!("{kind:?}: {open} gaps in {scenes} waterlines of {pixels} pixels");
    assert!(pixels > 5 * scenes, "only {pixels} in {scenes} scenes");
    assert!(
        open as f64 <= error * pixels as f64,
        "{open} gaps in {pixels} pixels of waterlines"
    );
}

/// As the cut is allowed to be beside the plane within a thousand units from the origin, in pixels.
const NEAR_BY: f64 = 0.01;

#[test]
fn waterlines_close_in_scenes_of_any_kind() {
    assert_waterlines_close(Kind::Any, 2000, NEAR_BY);
}

#[test]
fn waterlines_close_head_on() {
    assert_waterlines_close(Kind::HeadOn, 2100, NEAR_BY);
}

#[test]
fn waterlines_close_at_grazing_angles() {
    assert_waterlines_close(Kind::Grazing, 2200, NEAR_BY);
}

#[test]
fn waterlines_close_in_orthographic_views() {
    assert_waterlines_close(Kind::Orthographic, 2300, NEAR_BY);
}

/// Two thousand units away, where single precision moves the mirror against the picture around it.
#[test]
fn waterlines_close_far_from_the_origin() {
    assert_waterlines_close(Kind::FarAway, 2400, 0.05);
}

#[test]
fn a_gap_of_one_pixel_along_a_waterline_is_found() {
    let scene = wading(2000, Kind::Any);
    let mut studio = Studio::default();
    let picture = studio.picture(&scene);
    let itself = studio.without_mirrors(&painted(&scene));
    let line: Vec<_> = waterline(&picture, &itself).collect();
    assert_eq!(gaps(&picture), []);
    // At its ends the line belongs to the outline.
    let middle = line[line.len() / 2];
    let open = with_pixel(&picture, middle, bytes(scene.clear_color));
    assert_eq!(gaps(&open), [middle]);
}
