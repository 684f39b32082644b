//! Every group of the reference vectors, within the tolerances that come with them.

use bevy_planar_mirror::math::*;
use glam::{DMat4, DVec2, DVec3, DVec4};

use crate::{random::perspective_rows, reference::*, support::*};

/// What evaluation in `f64` may lose.
const F64: f64 = 1e-14;

#[test]
fn reflection() {
    let mut normal = Worst::of("reflection: normal");
    let mut distance = Worst::of("reflection: distance");
    let mut image = Worst::of("reflection: image");
    let mut entries = Worst::of("reflection: matrix");
    for case in vectors().reflection {
        let name = &case.name;
        let (origin, p) = (DVec3::from(case.point_on_plane), DVec3::from(case.p));
        let plane = Plane::new(origin, case.normal.into()).expect(name);
        let size = origin.abs().max_element().max(p.abs().max_element());
        normal.check_within(name, &plane.normal.to_array(), &case.unit_normal, F64);
        distance.check(
            name,
            plane.signed_distance(p),
            case.signed_distance,
            F64 * 10.0,
        );
        distance.check(name, plane.covector().w, case.plane_d, F64 * size);
        image.check_within(
            name,
            &reflect_point(&plane, p).to_array(),
            &case.reflected,
            F64 * size,
        );
        let reflection = DMat4::from(reflection_affine(&plane));
        for (row, expected) in case.matrix_rows.iter().enumerate() {
            let actual = reflection.row(row).to_array();
            entries.check_within(name, &actual[..3], &expected[..3], F64);
            entries.check(name, actual[3], expected[3], F64 * size);
        }
    }
}

#[test]
fn plane() {
    let patch = PlanarPatch::from_point_and_normal(DVec3::ZERO, DVec3::Z, None).expect("a plane");
    let mut normal = Worst::of("plane: normal");
    let mut offset = Worst::of("plane: offset and height");
    for case in vectors().plane {
        let name = &case.name;
        let (plane, corners) = transform_patch(&patch, &affine(case.mirror_rows)).expect(name);
        assert_eq!(
            corners, None,
            "{name}: a patch without bounds has no corners"
        );
        normal.check_within(name, &plane.normal.to_array(), &case.unit_normal, F64);
        let size = plane.origin.length();
        offset.check(name, plane.covector().w, case.plane_d, F64 * size);
        let height = plane.signed_distance(case.eye.into());
        offset.check(name, height, case.eye_height, F64 * 10.0);
        assert_eq!(height > 0.0, case.verdict == "in_front", "{name}: {height}");
    }
}

#[test]
fn matrix_rows() {
    let mut clip = Worst::of("matrix: plane in clip space");
    let mut factor = Worst::of("matrix: k");
    let mut rows = Worst::of("matrix: depth row");
    let mut depth = Worst::of("matrix: clip position and depth");
    for case in vectors().matrix {
        let name = &case.name;
        let base = matrix(case.base_rows);
        let plane_view = DVec4::from(case.plane_view);
        let projection = BaseProjection::new(&base).expect(name);
        let plane_clip = plane_in_clip(plane_view, &base).expect(name);
        clip.check_all(name, &plane_clip.to_array(), &case.plane_clip, F64);

        let region: Vec<DVec2> = match &case.region_ndc {
            Some(region) => region.iter().map(|p| DVec2::from(*p)).collect(),
            None => VisiblePolygon::full_view().ndc().collect(),
        };
        let reach = plane_reach(&projection, plane_view, region.into_iter());
        let size = plane_clip.abs().max_element();
        factor.check(name, reach.f_max, case.fmax, F64 * size);
        let [x, y] = case.corner_ndc;
        factor.check(
            name,
            plane_clip.dot(DVec4::new(x, y, 0.0, 1.0)),
            case.fmax,
            F64 * size,
        );
        let k = oblique_k(&reach, 0.0);
        assert_eq!(k.is_some(), case.verdict == "ok", "{name}: k = {k:?}");
        let (Some(k), Some(expected_k), Some(expected_row)) = (k, case.k, case.row3) else {
            continue;
        };
        factor.check(name, k, expected_k, F64 * expected_k);
        let row = fitted_depth_row(&base, plane_view, k, &reach, 0.0);
        for (actual, expected) in row.to_array().iter().zip(expected_row) {
            // Relative to each entry, the ones that cancel in another formula included.
            let floor = if projection.depth_is_w { 0.0 } else { F64 };
            rows.check(name, *actual, expected, F64 * expected.abs().max(floor));
        }
        check_rounded_row(name, row, expected_row);
        let plain = with_oblique_near_plane(&base, plane_view, k);
        check_rounded_row(name, plain.row(2), expected_row);

        let oblique = with_depth_row(&base, row);
        for point in &case.points {
            let p = DVec3::from(point.p_view).extend(1.0);
            let actual = oblique * p;
            let terms = (row * p).abs().element_sum().max(actual.w.abs());
            depth.check_within(name, &actual.to_array(), &point.clip, 10.0 * F64 * terms);
            if actual.w > 0.0 {
                let allowed = 10.0 * F64 * terms / actual.w;
                depth.check(name, actual.z / actual.w, point.depth, allowed);
            }
            let distance = plane_view.dot(p);
            let allowed = 10.0 * F64 * (plane_view * p).abs().element_sum();
            depth.check(name, distance, point.plane_distance, allowed);
            if point.plane_distance.abs() > allowed {
                assert_eq!(
                    actual.z <= actual.w,
                    point.kept,
                    "{name}: {p} is at {actual}"
                );
            }
        }
    }
}

#[test]
fn resolution() {
    let mut worst = Worst::of("resolution");
    for case in vectors().resolution {
        let Resolution { k, h, s, w, .. } = case;
        let name = &case.name;
        // A ray of slope s to the plane, which the eye is h above: C.p = w s - h.
        let c = DVec4::new(0.0, 0.0, -s, -h);
        let depth_row = oblique_row(
            &matrix(perspective_rows(1.0, 1.0, 0.0, 0.0, 0.0, 0.1)),
            c,
            k,
        );
        let depth = |w: f64| depth_row.dot(DVec4::new(0.0, 0.0, -w, 1.0)) / w;
        worst.check(name, depth(w), case.depth, 1e-12);
        worst.check(name, depth(case.w_plane), 1.0, 1e-12);
        worst.check(name, depth(1e15), case.depth_at_infinity, 1e-10);
        let slope = -k * h / (w * w);
        worst.check(name, slope, case.ddepth_dw, 1e-12 * slope.abs());
        let step = 2.0_f64.powi(-24) / slope.abs();
        worst.check(name, step, case.dw_for_2pow_minus_24, 1e-12 * step);
    }
}
