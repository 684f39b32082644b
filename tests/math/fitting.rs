//! The plane of a mesh.

use bevy_planar_mirror::math::*;
use glam::{DVec2, DVec3};
use proptest::prelude::*;

use crate::random::*;

const QUAD: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

/// The corners of a rectangle in the plane z = 0, counter-clockwise.
fn rectangle(half: DVec2) -> [DVec3; 4] {
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| DVec3::new(x * half.x, y * half.y, 0.0))
}

fn positions(points: &[DVec3]) -> Vec<[f32; 3]> {
    points.iter().map(|p| p.as_vec3().to_array()).collect()
}

fn fit(points: &[DVec3], triangles: &[[u32; 3]]) -> Result<PlanarPatch, FitError> {
    fit_patch(&positions(points), triangles.iter().copied())
}

fn front(patch: &PlanarPatch) -> DVec3 {
    patch.tangent_x.cross(patch.tangent_y)
}

#[test]
fn axis_aligned_rectangle_is_found_exactly() {
    let patch = fit(&rectangle(DVec2::new(2.0, 0.5)), &QUAD).expect("flat");
    assert_eq!(patch.center, DVec3::ZERO);
    assert_eq!(patch.half_size, DVec2::new(2.0, 0.5));
    assert_eq!((patch.tangent_x, patch.tangent_y), (DVec3::X, DVec3::Y));
}

#[test]
fn floor_of_y_up_faces_up() {
    let floor = rectangle(DVec2::new(3.0, 1.0)).map(|p| DVec3::new(p.x, 0.0, -p.y));
    let patch = fit(&floor, &QUAD).expect("flat");
    assert_eq!(front(&patch), DVec3::Y);
    let extent =
        patch.tangent_x.abs() * patch.half_size.x + patch.tangent_y.abs() * patch.half_size.y;
    assert_eq!(extent, DVec3::new(3.0, 0.0, 1.0));
}

#[test]
fn winding_decides_the_front() {
    let corners = rectangle(DVec2::ONE);
    let reversed = QUAD.map(|[a, b, c]| [a, c, b]);
    assert_eq!(front(&fit(&corners, &QUAD).expect("flat")), DVec3::Z);
    assert_eq!(
        front(&fit(&corners, &reversed).expect("flat")),
        DVec3::NEG_Z
    );
}

#[test]
fn two_faced_sheet_shows_its_first_side() {
    let corners = rectangle(DVec2::new(0.3, 0.7));
    let [a, b] = QUAD;
    let reversed = QUAD.map(|[a, b, c]| [c, b, a]);
    let both = [a, b, reversed[0], reversed[1]];
    assert_eq!(front(&fit(&corners, &both).expect("flat")), DVec3::Z);
    let back_first = [reversed[1], reversed[0], a, b];
    assert_eq!(
        front(&fit(&corners, &back_first).expect("flat")),
        DVec3::NEG_Z
    );
}

#[test]
fn the_larger_area_is_the_front() {
    // One large triangle faces back, several smaller ones of more area together face the front.
    let mut points = vec![
        DVec3::new(0.0, 0.0, 0.0),
        DVec3::new(0.0, 1.2, 0.0),
        DVec3::new(1.2, 0.0, 0.0),
    ];
    points.extend(rectangle(DVec2::ONE));
    let triangles = [[0, 1, 2], [3, 4, 5], [3, 5, 6]];
    assert_eq!(front(&fit(&points, &triangles).expect("flat")), DVec3::Z);
}

#[test]
fn unused_vertices_do_not_count() {
    let mut points = rectangle(DVec2::ONE).to_vec();
    points.push(DVec3::splat(100.0));
    points.push(DVec3::NAN);
    let patch = fit(&points, &QUAD).expect("flat");
    assert_eq!(patch.half_size, DVec2::ONE);
}

#[test]
fn meshes_without_a_plane_are_named() {
    let corners = rectangle(DVec2::ONE);
    assert_eq!(fit(&corners, &[]), Err(FitError::Empty));
    assert_eq!(fit(&[], &[]), Err(FitError::Empty));
    assert_eq!(fit(&corners, &[[0, 0, 1]]), Err(FitError::Empty));
    assert_eq!(fit(&corners, &[[0, 1, 4]]), Err(FitError::NotReadable));
    let line: Vec<DVec3> = (0..3).map(|i| DVec3::X * f64::from(i)).collect();
    assert_eq!(fit(&line, &[[0, 1, 2]]), Err(FitError::Empty));
    for bad in [f64::NAN, f64::INFINITY] {
        let mut points = corners;
        points[2].y = bad;
        assert_eq!(fit(&points, &QUAD), Err(FitError::NotFinite));
    }
    let mut bent = corners;
    bent[2].z = 0.02;
    match fit(&bent, &QUAD) {
        Err(FitError::NotFlat { deviation }) => {
            assert!(deviation > 1e-3 && deviation < 0.02, "{deviation}");
        }
        other => panic!("{other:?}"),
    }
    bent[2].z = 1e-4;
    assert!(fit(&bent, &QUAD).is_ok());
}

#[test]
fn errors_say_what_is_wrong() {
    for (error, word) in [
        (FitError::NotFinite, "finite"),
        (FitError::NotReadable, "range"),
        (FitError::Empty, "area"),
        (FitError::NotFlat { deviation: 0.25 }, "0.25"),
    ] {
        assert!(error.to_string().contains(word), "{error}");
    }
}

proptest! {
    #![proptest_config(cases(1))]

    #[test]
    fn a_moved_rectangle_is_found(
        turn in any_rotation(),
        at in any_point(1e4),
        half in [0.01..100.0_f64, 0.01..100.0_f64],
        two_faced in any::<bool>(),
    ) {
        let half = DVec2::from(half);
        let corners = rectangle(half).map(|p| turn * p + at);
        let triangles = match two_faced {
            false => QUAD.to_vec(),
            true => vec![QUAD[0], QUAD[1], [2, 1, 0], [3, 2, 0]],
        };
        let patch = fit(&corners, &triangles);
        // The grid of the coordinates may be coarser than the mesh is thin.
        let grid = f64::from(f32::EPSILON) * at.abs().max_element();
        prop_assume!(grid < 0.01 * half.min_element());
        let patch = patch.map_err(|error| TestCaseError::fail(error.to_string()))?;
        let allowed = 4.0 * (grid + 1e-6 * half.max_element());
        prop_assert!(patch.tangent_x.dot(patch.tangent_y).abs() < 1e-12, "{patch:?}");
        prop_assert!((patch.tangent_x.length() - 1.0).abs() < 1e-12, "{patch:?}");
        prop_assert!(patch.center.abs_diff_eq(at, 8.0 * allowed), "{at}: {patch:?}");
        let facing = front(&patch).dot(turn * DVec3::Z);
        prop_assert!(facing > 0.99, "{facing}: {patch:?}");
        let plane = Plane { origin: patch.center, normal: front(&patch) };
        for corner in corners {
            let off = plane.signed_distance(corner).abs();
            prop_assert!(off <= 4.0 * allowed, "{corner} is {off} off, allowed {allowed}");
            let from_center = corner - patch.center;
            let reach = DVec2::new(
                patch.tangent_x.dot(from_center),
                patch.tangent_y.dot(from_center),
            );
            let inside = reach.abs().cmple(patch.half_size + 2.0 * allowed).all();
            prop_assert!(inside, "{corner} is outside of {patch:?}");
        }
    }

    #[test]
    fn any_positions_are_fitted_or_refused(
        bits in prop::collection::vec([any::<u32>(), any::<u32>(), any::<u32>()], 0..6),
        triangles in prop::collection::vec([0..7_u32, 0..7, 0..7], 0..6),
    ) {
        let positions: Vec<[f32; 3]> = bits.iter().map(|p| p.map(f32::from_bits)).collect();
        if let Ok(patch) = fit_patch(&positions, triangles.iter().copied()) {
            prop_assert!(patch.center.is_finite() && patch.half_size.is_finite(), "{patch:?}");
            prop_assert!((front(&patch).length() - 1.0).abs() < 1e-9, "{patch:?}");
        }
    }
}
