//! What lies in a slice of a view and in a box.

use bevy_planar_mirror::math::ViewSlice;
use glam::{DMat3, DVec3, DVec4};

use crate::split_mix::SplitMix;

struct Case {
    slice: ViewSlice,
    low: DVec3,
    high: DVec3,
    covectors: [DVec4; 3],
}

fn vector(random: &mut SplitMix) -> DVec3 {
    DVec3::from_array([0; 3].map(|_| 2.0 * random.share() - 1.0))
}

impl Case {
    /// Of any kind of view, turned, stretched and reflected; in every eighth it begins at the eye.
    fn random(seed: u64) -> Self {
        let mut random = SplitMix::new(seed);
        let world_from_view = DMat3::from_cols_array(&[0.0; 9].map(|_| 2.0 * random.share() - 1.0));
        let eye = vector(&mut random) * 3.0;
        let near = if seed.is_multiple_of(8) {
            0.0
        } else {
            random.share()
        };
        let far = near + 4.0 * random.share();
        let [left, bottom] = [0; 2].map(|_| random.share() - 1.0);
        let [right, top] = [0; 2].map(|_| random.share());
        let is_orthographic = seed % 4 == 1;
        let corners = [0, 1, 2, 3, 4, 5, 6, 7].map(|index| {
            let depth = if index & 1 == 0 { near } else { far };
            let x = if index & 2 == 0 { left } else { right };
            let y = if index & 4 == 0 { bottom } else { top };
            let width = if is_orthographic { 1.0 } else { depth };
            eye + world_from_view * DVec3::new(x * width, y * width, -depth)
        });
        let middle = corners.iter().sum::<DVec3>() / 8.0;
        let [a, b] = [0; 2].map(|_| middle + vector(&mut random) * 2.0);
        Self {
            slice: ViewSlice { corners },
            low: a.min(b),
            high: a.max(b),
            covectors: [0; 3].map(|_| vector(&mut random).extend(random.share())),
        }
    }

    fn ranges(&self) -> [(f64, f64); 3] {
        self.slice
            .ranges_in_box((self.low, self.high), &self.covectors)
    }

    /// The half-spaces of both, positive inside; those of faces that have an area.
    fn half_spaces(&self) -> Vec<DVec4> {
        let corners = &self.slice.corners;
        let middle = corners.iter().sum::<DVec3>() / 8.0;
        let mut sides = Vec::new();
        for bit in [1, 2, 4] {
            for end in [0, bit] {
                // The two longest ways across the face.
                let face: Vec<DVec3> = (0..8)
                    .filter(|index| index & bit == end)
                    .map(|index| corners[index])
                    .collect();
                let normal = (face[3] - face[0]).cross(face[2] - face[1]);
                if let Some(normal) = normal.try_normalize() {
                    let side = normal.extend(-normal.dot(face[0]));
                    let turn = side.dot(middle.extend(1.0)).signum();
                    sides.push(side * turn);
                }
            }
        }
        for axis in DVec3::AXES {
            sides.push(axis.extend(-axis.dot(self.low)));
            sides.push((-axis).extend(axis.dot(self.high)));
        }
        sides
    }

    /// Every corner of what lies in both, by brute force: where three of the planes meet.
    fn meeting_points(&self) -> Vec<DVec3> {
        let sides = self.half_spaces();
        let mut points = Vec::new();
        for (i, a) in sides.iter().enumerate() {
            for (j, b) in sides[..i].iter().enumerate() {
                for c in &sides[..j] {
                    let rows = [a, b, c].map(|side| side.truncate());
                    let planes = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
                    if planes.determinant().abs() < 1e-9 {
                        continue;
                    }
                    let point = planes.inverse() * -DVec3::new(a.w, b.w, c.w);
                    if sides.iter().all(|side| side.dot(point.extend(1.0)) > -1e-7) {
                        points.push(point);
                    }
                }
            }
        }
        points
    }
}

#[test]
fn ranges_are_those_of_the_corners_where_three_planes_meet() {
    let mut compared = 0;
    for seed in 0..2000 {
        let case = Case::random(seed);
        let points = case.meeting_points();
        // Of next to nothing rounding decides whether it is there.
        let size = points
            .iter()
            .flat_map(|a| points.iter().map(|b| a.distance(*b)))
            .fold(0.0, f64::max);
        if size < 1e-3 {
            continue;
        }
        compared += 1;
        for (covector, (least, greatest)) in case.covectors.iter().zip(case.ranges()) {
            let values = points.iter().map(|point| covector.dot(point.extend(1.0)));
            let expected = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            });
            let off = (least - expected.0)
                .abs()
                .max((greatest - expected.1).abs());
            assert!(
                off < 1e-4,
                "seed {seed}: {least} to {greatest}, not {expected:?}"
            );
        }
    }
    assert!(compared > 1000, "{compared}");
}

#[test]
fn what_lies_in_both_is_in_range() {
    let mut inside = 0;
    for seed in 0..2000 {
        let case = Case::random(seed);
        let ranges = case.ranges();
        let mut random = SplitMix::new(!seed);
        for _ in 0..20 {
            let shares = [0; 8].map(|_| random.share().powi(4));
            let sum: f64 = shares.iter().sum();
            let corners = case.slice.corners.iter().zip(shares);
            let point: DVec3 = corners.map(|(corner, share)| *corner * (share / sum)).sum();
            if point.cmplt(case.low).any() || point.cmpgt(case.high).any() {
                continue;
            }
            inside += 1;
            for (covector, (least, greatest)) in case.covectors.iter().zip(ranges) {
                let value = covector.dot(point.extend(1.0));
                let is_in = value > least - 1e-9 && value < greatest + 1e-9;
                assert!(is_in, "seed {seed}: {value} of {least} to {greatest}");
            }
        }
    }
    assert!(inside > 2000, "{inside}");
}

#[test]
fn of_what_lies_apart_there_is_no_range() {
    let mut case = Case::random(3);
    let top = case
        .slice
        .corners
        .iter()
        .fold(DVec3::NEG_INFINITY, |top, corner| top.max(*corner));
    (case.low, case.high) = (top + 1.0, top + 2.0);
    let nothing = (f64::INFINITY, f64::NEG_INFINITY);
    assert_eq!(case.ranges(), [nothing; 3]);
}
