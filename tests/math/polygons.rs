//! The visible part of a mirror on the screen.

use bevy_planar_mirror::math::*;
use glam::{DVec2, DVec4};
use proptest::prelude::*;

use crate::random::cases;

const VIEWPORT: DVec2 = DVec2::new(200.0, 100.0);

/// A rectangle on the screen at clip `w`, a little in front of the far plane.
fn on_screen(low: DVec2, high: DVec2, w: f64) -> [DVec4; 4] {
    [
        DVec2::new(low.x, low.y),
        DVec2::new(high.x, low.y),
        DVec2::new(high.x, high.y),
        DVec2::new(low.x, high.y),
    ]
    .map(|p| DVec4::new(p.x * w, p.y * w, 0.1, w))
}

fn area(polygon: &VisiblePolygon) -> f64 {
    let points: Vec<DVec2> = polygon.ndc().collect();
    let edges = points.iter().zip(points.iter().cycle().skip(1));
    edges.map(|(a, b)| a.perp_dot(*b)).sum::<f64>().abs() * 0.5
}

#[test]
fn a_rectangle_on_the_screen_stays() {
    let polygon = clip_polygon(&on_screen(DVec2::splat(-0.5), DVec2::splat(0.25), 3.0));
    assert_eq!(polygon.vertices().len(), 4);
    assert_eq!(polygon.w_min(), Some(3.0));
    let (low, high) = polygon.ndc_bounds();
    assert!(low.abs_diff_eq(DVec2::splat(-0.5), 1e-15), "{low}");
    assert!(high.abs_diff_eq(DVec2::splat(0.25), 1e-15), "{high}");
    let width = polygon.min_width_px(VIEWPORT);
    assert!((width - 37.5).abs() < 1e-12, "{width}");
}

#[test]
fn a_large_rectangle_is_cut_to_the_screen() {
    let polygon = clip_polygon(&on_screen(DVec2::splat(-1e6), DVec2::splat(1e6), 1.0));
    assert!((area(&polygon) - 4.0).abs() < 1e-9, "{polygon:?}");
    let width = polygon.min_width_px(VIEWPORT);
    assert!((width - 100.0).abs() < 1e-6, "{width}");
}

#[test]
fn beside_the_screen_and_behind_the_camera_nothing_is_left() {
    for (low, high) in [
        (DVec2::new(1.5, -1.0), DVec2::new(2.0, 1.0)),
        (DVec2::new(-1.0, -3.0), DVec2::new(1.0, -2.0)),
    ] {
        assert!(clip_polygon(&on_screen(low, high, 1.0)).is_empty());
    }
    assert!(clip_polygon(&on_screen(DVec2::NEG_ONE, DVec2::ONE, -1.0)).is_empty());
    // Nearer than the near plane: z is the near distance, and larger than w.
    assert!(clip_polygon(&on_screen(DVec2::NEG_ONE, DVec2::ONE, 0.05)).is_empty());
}

#[test]
fn a_floor_below_the_camera_begins_at_the_near_plane() {
    // From 1 behind the camera to 10 ahead, 0.05 below it, near plane at 0.1, square view.
    let corner = |x: f64, w: f64| DVec4::new(x, -0.05, 0.1, w);
    let polygon = clip_polygon(&[
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 10.0),
        corner(-1.0, 10.0),
    ]);
    let w_min = polygon.w_min().expect("visible");
    assert!((w_min - 0.1).abs() < 1e-15, "{w_min}");
    let (low, high) = polygon.ndc_bounds();
    assert!(
        (low.y + 0.5).abs() < 1e-12 && (high.y + 0.005).abs() < 1e-12,
        "{low} {high}"
    );
}

#[test]
fn the_full_view_is_the_screen_at_unknown_depth() {
    let polygon = VisiblePolygon::full_view();
    assert_eq!(polygon.ndc_bounds(), (DVec2::NEG_ONE, DVec2::ONE));
    assert_eq!(polygon.w_min(), None);
    assert!(!polygon.is_empty());
    assert!((polygon.min_width_px(VIEWPORT) - 100.0).abs() < 1e-12);
}

#[test]
fn not_a_number_is_not_visible() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut corners = on_screen(DVec2::NEG_ONE, DVec2::ONE, 1.0);
        corners[3].x = bad;
        let polygon = clip_polygon(&corners);
        assert!(polygon.is_empty());
        assert_eq!(
            (polygon.w_min(), polygon.min_width_px(VIEWPORT)),
            (None, 0.0)
        );
    }
}

#[test]
fn a_turned_strip_is_as_wide_as_it_is() {
    // 3 px wide, 60 px long, at 30 degrees in a square viewport of 100 px.
    let (sin, cos) = 30.0_f64.to_radians().sin_cos();
    let corners = [(-30.0, -1.5), (30.0, -1.5), (30.0, 1.5), (-30.0, 1.5)].map(|(x, y)| {
        let p = DVec2::new(x * cos - y * sin, x * sin + y * cos) / 50.0;
        DVec4::new(p.x, p.y, 0.1, 1.0)
    });
    let width = clip_polygon(&corners).min_width_px(DVec2::splat(100.0));
    assert!((width - 3.0).abs() < 1e-12, "{width}");
}

/// A rectangle in view space, through a projection with m00 = m11 = 1 and near distance 0.1.
fn any_quad() -> impl Strategy<Value = [DVec4; 4]> {
    let vector = || [-3.0..3.0_f64, -3.0..3.0, -3.0..3.0];
    (vector(), vector(), vector()).prop_map(|(center, x, y)| {
        let [center, x, y] = [center, x, y].map(glam::DVec3::from);
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(s, t)| {
            let p = center + x * s + y * t;
            DVec4::new(p.x, p.y, 0.1, -p.z)
        })
    })
}

proptest! {
    #![proptest_config(cases(1))]

    #[test]
    fn the_visible_part_is_in_the_view_and_in_the_quad(quad in any_quad()) {
        let polygon = clip_polygon(&quad);
        prop_assert!(polygon.vertices().len() <= 9, "{polygon:?}");
        let normal = {
            let [a, b, c, _] = quad.map(|v| DVec4::new(v.x, v.y, v.w, 0.0).truncate());
            ((b - a).cross(c - a), a)
        };
        for v in polygon.vertices() {
            let slack = 1e-12;
            prop_assert!(v.w >= 0.1 - slack, "{v}");
            prop_assert!(v.x.abs() <= v.w + slack && v.y.abs() <= v.w + slack, "{v}");
            let p = glam::DVec3::new(v.x, v.y, v.w);
            let off = normal.0.dot(p - normal.1).abs();
            prop_assert!(off <= 1e-11, "{v} is off the quad by {off}");
        }
    }

    #[test]
    fn a_smaller_quad_shows_less(quad in any_quad(), share in 0.1..1.0_f64) {
        let center = quad.iter().sum::<DVec4>() / 4.0;
        let smaller = quad.map(|v| center + (v - center) * share);
        let (part, whole) = (clip_polygon(&smaller), clip_polygon(&quad));
        prop_assert!(area(&part) <= area(&whole) + 1e-9, "{} of {}", area(&part), area(&whole));
        let (thin, wide) = (part.min_width_px(VIEWPORT), whole.min_width_px(VIEWPORT));
        prop_assert!(thin <= wide + 1e-6, "{thin} of {wide}");
        if let (Some(part), Some(whole)) = (part.w_min(), whole.w_min()) {
            prop_assert!(part >= whole - 1e-12, "{part} nearer than {whole}");
        }
    }

    #[test]
    fn order_and_starting_corner_do_not_matter(quad in any_quad(), turn in 0..4_usize) {
        let mut other = quad;
        other.rotate_left(turn);
        other.reverse();
        let (a, b) = (clip_polygon(&quad), clip_polygon(&other));
        prop_assert!((area(&a) - area(&b)).abs() <= 1e-9, "{a:?} and {b:?}");
        let (width_a, width_b) = (a.min_width_px(VIEWPORT), b.min_width_px(VIEWPORT));
        prop_assert!((width_a - width_b).abs() <= 1e-5, "{width_a} and {width_b}");
    }

    #[test]
    fn through_an_opening_shows_what_lies_in_it(
        quad in any_quad(),
        low in (-1.0..0.5_f64, -1.0..0.5_f64),
        size in (0.1..1.5_f64, 0.1..1.5_f64),
        plane in prop::array::uniform4(-1.0..1.0_f64),
    ) {
        let low = DVec2::from(low);
        let high = (low + DVec2::from(size)).min(DVec2::ONE);
        let plane = DVec4::from_array(plane);
        let whole = clip_polygon(&quad);
        let part = clip_polygon_within(&quad, (low, high), Some(plane));
        for v in part.vertices() {
            prop_assert!(plane.dot(*v) >= -1e-12, "{v} is behind");
        }
        for p in part.ndc() {
            prop_assert!(p.cmpge(low - 1e-12).all() && p.cmple(high + 1e-12).all(), "{p}");
        }
        prop_assert!(area(&part) <= area(&whole) + 1e-9);
        // And nothing of that is missing.
        let inside = |v: &DVec4| {
            let p = v.truncate().truncate() / v.w;
            p.cmpge(low).all() && p.cmple(high).all() && plane.dot(*v) >= 0.0
        };
        if whole.vertices().iter().all(inside) {
            prop_assert!((area(&part) - area(&whole)).abs() <= 1e-9);
        }
        let open = clip_polygon_within(&quad, (DVec2::NEG_ONE, DVec2::ONE), None);
        prop_assert_eq!(open, whole);
    }
}
