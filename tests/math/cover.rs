//! Faces that stand before a mirror, and what they leave of it to be seen.

use bevy_planar_mirror::math::*;
use glam::{DAffine3, DMat4, DVec2, DVec3};
use proptest::prelude::*;

use crate::{extremes::patch, random::*, reference::matrix};

type Triangle = [DVec3; 3];

/// A mirror as a camera sees it.
struct Look {
    input: ViewInput,
    plan: ReflectedViewPlan,
}

impl Look {
    fn new(input: ViewInput) -> Option<Self> {
        let plan = plan_reflected_view(&input).ok()?;
        Some(Self { input, plan })
    }

    /// Two units wide and high, five units before the eye, and square to its view.
    fn at_a_wall(clip_from_view: DMat4) -> Self {
        let (plane, corners) =
            transform_patch(&patch(DVec2::ONE), &DAffine3::IDENTITY).expect("it is a rectangle");
        Self::new(ViewInput {
            world_from_view: DAffine3::from_translation(DVec3::Z * 5.0),
            clip_from_view,
            viewport_size: DVec2::new(400.0, 400.0),
            plane,
            corners,
            jitter_px: 0.0,
            was_drawn: false,
        })
        .expect("it is in view")
    }

    fn view(&self) -> CoverView {
        CoverView::new(&self.input, &self.plan).expect("it has bounds")
    }

    /// The faces of triangles in the world.
    fn faces<'a>(&self, triangles: &'a [Triangle]) -> impl Iterator<Item = VisiblePolygon> + 'a {
        let view = self.view();
        triangles
            .iter()
            .filter_map(move |triangle| view.face(*triangle, &DAffine3::IDENTITY))
    }

    fn cover(&self, triangles: &[Triangle]) -> Cover {
        let mut cover = Cover::default();
        cover.begin(&self.plan.polygon);
        for face in self.faces(triangles) {
            if !cover.is_open() {
                break;
            }
            cover.take_away(&face, self.input.viewport_size);
        }
        cover
    }

    fn is_hidden_by(&self, triangles: &[Triangle]) -> bool {
        self.cover(triangles).is_whole()
    }

    /// Where the camera's ray through a place on the screen begins, and where it meets the mirror.
    fn ray(&self, ndc: DVec2) -> (DVec3, DVec3) {
        let view_from_clip = self.input.clip_from_view.inverse();
        let at = |z: f64| {
            let view = view_from_clip.project_point3(ndc.extend(z));
            self.input.world_from_view.transform_point3(view)
        };
        let (near, beyond) = (at(1.0), at(0.5));
        let height = |p| self.input.plane.signed_distance(p);
        let along = height(near) / (height(near) - height(beyond));
        (near, near + (beyond - near) * along)
    }

    /// Whether a ray meets a triangle before the mirror; `None` if that is hard to tell.
    fn meets(&self, ndc: DVec2, triangles: &[Triangle]) -> Option<bool> {
        let (from, to) = self.ray(ndc);
        let close = 2e-3 * self.input.plane.signed_distance(from).abs() + 0.02;
        let mut is_met = false;
        for hit in triangles.iter().filter_map(|t| intersection(from, to, *t)) {
            if self.input.plane.signed_distance(hit) < close {
                return None;
            }
            is_met = true;
        }
        Some(is_met)
    }

    /// The same for all rays less than half a pixel away, which must show the mirror as well.
    fn meets_around(&self, ndc: DVec2, triangles: &[Triangle]) -> Option<bool> {
        let mirror = &self.plan.polygon;
        let answer = self.meets(ndc, triangles)?;
        let steps = [-1.0, 0.0, 1.0];
        let around = steps.iter().flat_map(|x| steps.map(|y| DVec2::new(*x, y)));
        let half_pixel = DVec2::ONE / self.input.viewport_size;
        for step in around {
            let beside = ndc + step * half_pixel;
            if !holds(mirror, beside) || self.meets(beside, triangles)? != answer {
                return None;
            }
        }
        Some(answer)
    }
}

/// Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997, of a segment.
fn intersection(from: DVec3, to: DVec3, [a, b, c]: Triangle) -> Option<DVec3> {
    let (along, x, y) = (to - from, b - a, c - a);
    let normal = along.cross(y);
    let determinant = x.dot(normal);
    let offset = from - a;
    let u = offset.dot(normal) / determinant;
    let q = offset.cross(x);
    let v = along.dot(q) / determinant;
    let t = y.dot(q) / determinant;
    let is_inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && (0.0..=1.0).contains(&t);
    is_inside.then(|| from + along * t)
}

/// Whether a place of the screen is within a convex polygon, or on its edge.
fn holds(polygon: &VisiblePolygon, place: DVec2) -> bool {
    let next = polygon.ndc().cycle().skip(1);
    // An edge of no length leads nowhere.
    let turns: Vec<f64> = polygon
        .ndc()
        .zip(next)
        .filter(|(a, b)| a.distance(*b) > 1e-9)
        .map(|(a, b)| (b - a).normalize_or_zero().perp_dot(place - a))
        .collect();
    turns.iter().all(|turn| *turn >= -1e-9) || turns.iter().all(|turn| *turn <= 1e-9)
}

fn is_left(cover: &Cover, ndc: DVec2) -> bool {
    cover.left().iter().any(|piece| holds(piece, ndc))
}

/// A rectangle square to the z axis.
fn panel(low: DVec2, high: DVec2, z: f64) -> [Triangle; 2] {
    let at = |x: f64, y: f64| DVec3::new(x, y, z);
    let corners = [
        at(low.x, low.y),
        at(high.x, low.y),
        at(high.x, high.y),
        at(low.x, high.y),
    ];
    [
        [corners[0], corners[1], corners[2]],
        [corners[0], corners[2], corners[3]],
    ]
}

fn perspective() -> DMat4 {
    matrix(perspective_rows(2.0, 2.0, 0.0, 0.0, 0.0, 0.1))
}

fn orthographic() -> DMat4 {
    matrix([
        [0.5, 0.0, 0.0, 0.0],
        [0.0, 0.5, 0.0, 0.0],
        [0.0, 0.0, 0.001, 1.0],
        [0.0, 0.0, 0.0, 1.0],
    ])
}

const HALF: DVec2 = DVec2::splat(0.5);

#[test]
fn a_panel_hides_what_it_covers_on_the_screen() {
    // Halfway to the mirror half its width is enough, and a hundredth less is not: of 200 pixels
    // that is two.
    let look = Look::at_a_wall(perspective());
    assert!(look.is_hidden_by(&panel(-HALF, HALF, 2.5)));
    assert!(!look.is_hidden_by(&panel(-HALF, HALF * 0.98, 2.5)));
    let look = Look::at_a_wall(orthographic());
    assert!(look.is_hidden_by(&panel(-DVec2::ONE, DVec2::ONE, 2.5)));
    assert!(!look.is_hidden_by(&panel(-DVec2::ONE, DVec2::ONE * 0.98, 2.5)));
    assert!(!look.is_hidden_by(&[]));
}

#[test]
fn panels_hide_it_together() {
    let look = Look::at_a_wall(perspective());
    let left = panel(-HALF, DVec2::new(0.1, 0.5), 2.5);
    for (gap, is_hidden) in [(-0.3, true), (0.0, true), (0.02, false)] {
        let right = panel(DVec2::new(0.1 + gap, -0.5), HALF, 2.5);
        let both = [left, right].concat();
        assert_eq!(look.is_hidden_by(&both), is_hidden, "{gap}");
    }
    // One behind the other, and before it.
    let right = panel(DVec2::new(0.0, -0.9), DVec2::splat(0.9), 1.0);
    assert!(look.is_hidden_by(&[left, right].concat()));
}

#[test]
fn what_is_left_has_bounds_and_an_area() {
    let look = Look::at_a_wall(perspective());
    let edge = 0.4;
    let cover = look.cover(&panel(DVec2::splat(-0.6), DVec2::new(0.1, 0.6), 2.5));
    let (low, high) = cover.ndc_bounds();
    assert!(low.abs_diff_eq(DVec2::new(0.08, -edge), 1e-12), "{low}");
    assert!(high.abs_diff_eq(DVec2::splat(edge), 1e-12), "{high}");
    let area = cover.area_px(look.input.viewport_size);
    assert!((area - 200.0 * 200.0 * 0.32 * 0.8).abs() < 1e-6, "{area}");
    // Blinds, whose slits are too fine to be kept, but so many that they show: it is all seen.
    let blinds: Vec<_> = (0..2000)
        .map(|i| -0.5 + 0.0005 * f64::from(i))
        .flat_map(|y| panel(DVec2::new(-0.6, y), DVec2::new(0.6, y + 0.00046), 2.5))
        .collect();
    let cover = look.cover(&blinds);
    assert!(!cover.is_open() && !cover.is_whole());
    let whole = (DVec2::splat(-edge), DVec2::splat(edge));
    assert_eq!(cover.ndc_bounds(), whole);
}

#[test]
fn what_is_behind_the_mirror_or_too_near_to_it_hides_nothing() {
    for projection in [perspective(), orthographic()] {
        let look = Look::at_a_wall(projection);
        let wide = |z| panel(DVec2::splat(-9.0), DVec2::splat(9.0), z);
        for (z, is_hidden) in [
            (0.1, true),
            (1e-3, false),
            (0.0, false),
            (-1.0, false),
            (4.5, true),
            // Nearer than the near plane, and behind the eye.
            (4.95, false),
            (5.5, false),
        ] {
            let is_seen_by_it = look.input.clip_from_view.row(3).w == 0.0 || z < 4.95;
            if is_seen_by_it {
                assert_eq!(look.is_hidden_by(&wide(z)), is_hidden, "{z}");
            }
        }
    }
}

#[test]
fn a_wall_that_reaches_behind_the_eye_hides_what_is_behind_it() {
    let look = Look::at_a_wall(perspective());
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    // It begins at the mirror's right and passes the eye at its left.
    let [a, b, c, d] = [
        at(1.5, -9.0, 0.5),
        at(-2.5, -9.0, 8.0),
        at(-2.5, 9.0, 8.0),
        at(1.5, 9.0, 0.5),
    ];
    assert!(look.is_hidden_by(&[[a, b, c], [a, c, d]]));
    assert!(!look.is_hidden_by(&[[a, b, c]]));
}

#[test]
fn a_wall_that_crosses_the_mirror_hides_none_of_what_is_before_it() {
    let look = Look::at_a_wall(perspective());
    let at = |x: f64, y: f64| DVec3::new(x, y, 0.5 - x);
    let slanted = [
        [at(-4.0, -4.0), at(4.0, -4.0), at(4.0, 4.0)],
        [at(-4.0, -4.0), at(4.0, 4.0), at(-4.0, 4.0)],
    ];
    let cover = look.cover(&slanted);
    assert!(!cover.is_whole());
    for (x, left) in [(-0.9, false), (0.0, false), (0.6, true), (0.9, true)] {
        let ndc = DVec2::new(x * 2.0 / 5.0, 0.1);
        assert_eq!(is_left(&cover, ndc), left, "{x}");
    }
}

/// Many slats leave many pieces; in the end it is seen, whatever else stands before it.
#[test]
fn what_is_cut_into_too_many_pieces_is_seen() {
    let look = Look::at_a_wall(perspective());
    let mut slats = Vec::new();
    for i in 0..40 {
        let y = -0.5 + 0.025 * f64::from(i);
        slats.extend(panel(DVec2::new(-0.6, y), DVec2::new(0.6, y + 0.012), 2.5));
    }
    assert!(!look.cover(&slats).is_open());
}

#[test]
fn what_single_precision_moves_hides_nothing() {
    let hidden = |offset: f64| {
        let mut input = Look::at_a_wall(perspective()).input;
        let offset = DVec3::splat(offset);
        input.world_from_view.translation += offset;
        input.plane.origin += offset;
        input.corners = input.corners.map(|corners| corners.map(|c| c + offset));
        let look = Look::new(input).expect("it is in view");
        let wall = panel(-DVec2::ONE, DVec2::ONE, 2.5).map(|t| t.map(|corner| corner + offset));
        look.is_hidden_by(&wall)
    };
    assert!(hidden(100.0));
    assert!(!hidden(1e5));
    // A mesh far from its own pivot is as uncertain.
    let look = Look::at_a_wall(perspective());
    let pivot = DVec3::splat(1e6);
    let [triangle, _] = panel(-DVec2::ONE, DVec2::ONE, 2.5);
    let away = triangle.map(|corner| corner - pivot);
    let back = DAffine3::from_translation(pivot);
    assert!(look.view().face(triangle, &DAffine3::IDENTITY).is_some());
    assert!(look.view().face(away, &back).is_none());
}

#[test]
fn not_a_number_hides_nothing() {
    let look = Look::at_a_wall(perspective());
    for value in [f64::NAN, f64::INFINITY] {
        let mut wall = panel(-DVec2::ONE, DVec2::ONE, 2.5);
        wall[0][1].x = value;
        assert!(!look.is_hidden_by(&wall));
        let transform = DAffine3::from_translation(DVec3::X * value);
        assert!(look.view().face(wall[1], &transform).is_none());
    }
    // All three corners in a line.
    assert!(!look.is_hidden_by(&[[DVec3::Z, DVec3::X + DVec3::Z, DVec3::NEG_X + DVec3::Z]]));
}

#[test]
fn a_mirror_without_bounds_is_never_hidden() {
    let input = ViewInput {
        corners: None,
        ..Look::at_a_wall(perspective()).input
    };
    let look = Look::new(input).expect("it is in view");
    assert!(CoverView::new(&input, &look.plan).is_none());
}

/// A point on a line from the eye to the mirror's plane or beyond.
fn any_corner() -> impl Strategy<Value = [f64; 3]> {
    [-1.5..2.5_f64, -1.5..2.5_f64, 0.05..1.3_f64]
}

fn any_walls() -> impl Strategy<Value = Vec<[[f64; 3]; 3]>> {
    proptest::collection::vec([any_corner(), any_corner(), any_corner()], 1..10)
}

fn placed(input: &ViewInput, walls: &[[[f64; 3]; 3]]) -> Vec<Triangle> {
    let [a, b, _, d] = input.corners.expect("it has bounds");
    let eye = input.world_from_view.translation;
    let corner = |[u, v, t]: [f64; 3]| eye + (a + (b - a) * u + (d - a) * v - eye) * t;
    walls.iter().map(|wall| wall.map(corner)).collect()
}

proptest! {
    #![proptest_config(cases(4))]

    #[test]
    fn nothing_is_taken_away_that_is_seen(
        input in any_scene(),
        walls in any_walls(),
        samples in proptest::collection::vec(any_weights(), 20),
    ) {
        let Some(look) = Look::new(input) else {
            return Ok(());
        };
        let walls = placed(&input, &walls);
        let cover = look.cover(&walls);
        for ndc in samples.iter().map(|weights| inside(&look.plan.polygon, *weights)) {
            if let Some(false) = look.meets_around(ndc, &walls) {
                prop_assert!(is_left(&cover, ndc), "{ndc} of {input:?} is seen through {walls:?}");
            }
        }
    }

    #[test]
    fn all_is_taken_away_that_is_hidden(
        is_orthographic in any::<bool>(),
        walls in any_walls(),
        samples in proptest::collection::vec(any_weights(), 20),
    ) {
        let projection = if is_orthographic { orthographic() } else { perspective() };
        let look = Look::at_a_wall(projection);
        let walls = placed(&look.input, &walls);
        let cover = look.cover(&walls);
        for ndc in samples.iter().map(|weights| inside(&look.plan.polygon, *weights)) {
            if let Some(true) = look.meets_around(ndc, &walls) && cover.is_open() {
                prop_assert!(!is_left(&cover, ndc), "{ndc} is behind {walls:?}");
            }
        }
    }
}
