//! What a camera sees of a mirror, found without the code under test: in the mirror's own two
//! coordinates, by trying every pair of the lines that bound what is seen.

use bevy_planar_mirror::math::ViewInput;
use glam::{DMat3, DMat4, DVec2, DVec3, DVec4, Vec3Swizzles};

/// The rules for leaving a mirror out, as documented: of one that was not drawn, and of one that was.
pub fn min_width_px(input: &ViewInput) -> f64 {
    if input.was_drawn { 0.25 } else { 0.5 }
}

fn min_steps(input: &ViewInput) -> f64 {
    if input.was_drawn { 2.0 } else { 4.0 }
}

pub fn max_margin(input: &ViewInput) -> f64 {
    if input.was_drawn { 0.375 } else { 0.25 }
}

pub const HALF_STEP: f64 = 1.0 / (1 << 24) as f64;

/// A linear function of the mirror's coordinates `(1, u, v)`, positive inside.
type Bound = DVec3;

pub struct Witness {
    pub is_orthographic: bool,
    view_from_clip: DMat4,
    /// The center of the mirror and the steps to two of its sides, in clip space.
    frame: Option<[DVec4; 3]>,
    /// The corners of what is seen, in clip space; of a mirror without bounds, the screen's.
    pub seen: Vec<DVec4>,
    /// How high the eye is.
    pub height: f64,
    /// `max (C.p)/w` over the corners, at the far end of their rays.
    pub f_max: f64,
}

impl Witness {
    pub fn of(input: &ViewInput) -> Self {
        let w_row = input.clip_from_view.row(3);
        let eye = input.world_from_view.translation;
        let frame = input.corners.map(|corners| {
            let [a, b, _, d] = corners.map(|corner| corner - eye);
            let center = (a + corners[2] - eye) * 0.5;
            let clip = |v: DVec3, w: f64| {
                let view = input.world_from_view.matrix3.inverse() * v;
                input.clip_from_view * view.extend(w)
            };
            [
                clip(center, 1.0),
                clip((b - a) * 0.5, 0.0),
                clip((d - a) * 0.5, 0.0),
            ]
        });
        let mut witness = Self {
            is_orthographic: w_row.truncate() == DVec3::ZERO,
            view_from_clip: input.clip_from_view.inverse(),
            frame,
            seen: match &frame {
                None => [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                    .map(|(x, y)| DVec4::new(x, y, 0.0, 1.0))
                    .to_vec(),
                Some(frame) => corners_seen(frame),
            },
            height: input.plane.normal.dot(eye - input.plane.origin),
            f_max: 0.0,
        };
        let reaches = witness
            .screen()
            .into_iter()
            .map(|p| witness.reach(input, p));
        witness.f_max = reaches.fold(f64::NEG_INFINITY, f64::max);
        witness
    }

    /// The corners of what is seen, from -1 to 1.
    pub fn screen(&self) -> Vec<DVec2> {
        self.seen
            .iter()
            .map(|v| v.truncate().truncate() / v.w)
            .collect()
    }

    /// The far end of a ray in view space, per unit of clip `w`.
    pub fn far_end(&self, ndc: DVec2) -> DVec4 {
        self.view_from_clip * ndc.extend(0.0).extend(1.0)
    }

    /// `(C.p)/w` at the far end of a ray of the reflected camera: the distance of the real point,
    /// whose component along the normal the reflection turned round.
    pub fn reach(&self, input: &ViewInput, ndc: DVec2) -> f64 {
        let end = self.far_end(ndc);
        let along = input.world_from_view.matrix3 * end.truncate();
        -input.plane.normal.dot(along) - self.height * end.w
    }

    /// How far the camera is on the front side, as a multiple of what it must be: its eye's height
    /// in steps of `f32`, or how steeply an orthographic camera looks down.
    pub fn front(&self, input: &ViewInput) -> f64 {
        let steps = min_steps(input) * 2.0 * HALF_STEP;
        if self.is_orthographic {
            let forward = input.world_from_view.matrix3 * DVec3::NEG_Z;
            return -input.plane.normal.dot(forward.normalize()) / steps;
        }
        let (eye, origin) = (input.world_from_view.translation, input.plane.origin);
        let largest = eye.abs().max(origin.abs()).max_element();
        self.height / (steps * largest).max(f64::MIN_POSITIVE)
    }

    /// Looks for a point of the mirror that is well inside of the view: a grid over the mirror,
    /// and the mirror under a grid of pixels.
    pub fn finds_a_visible_point(&self, input: &ViewInput) -> bool {
        const GRID: i32 = 8;
        let steps = (-GRID..=GRID).map(|i| f64::from(i) / f64::from(GRID));
        let mut grid = steps
            .clone()
            .flat_map(|a| steps.clone().map(move |b| DVec2::new(a, b)));
        let Some([center, u, v]) = self.frame else {
            return grid.any(|ndc| {
                let largest = self.far_end(ndc).truncate().length();
                self.reach(input, ndc) > 1e-12 * largest * lengths(input).1
            });
        };
        let is_inside = |p: DVec4| {
            let slack = 1e-9 * (center.abs() + u.abs() + v.abs()).max_element();
            let inside = [p.w - p.z, p.z, p.w - p.x, p.w + p.x, p.w - p.y, p.w + p.y];
            // Depth may be a constant below the slack, the near distance.
            inside[1] >= 0.0 && inside.iter().enumerate().all(|(i, d)| i == 1 || *d > slack)
        };
        if grid
            .clone()
            .any(|at| is_inside(center + u * at.x + v * at.y))
        {
            return true;
        }
        // x - ndc w = 0 for x and y, solved for the mirror's coordinates.
        grid.any(|ndc| {
            let row = |p: DVec4| DVec2::new(p.x - ndc.x * p.w, p.y - ndc.y * p.w);
            let (c, u2, v2) = (row(center), row(u), row(v));
            let det = u2.perp_dot(v2);
            let at = DVec2::new(-c.perp_dot(v2), c.perp_dot(u2)) / det;
            at.abs().max_element() < 1.0 - 1e-9 && is_inside(center + u * at.x + v * at.y)
        })
    }

    /// The width of the narrowest strip that holds what is seen, in pixels.
    pub fn width_px(&self, viewport: DVec2) -> f64 {
        let pixels: Vec<_> = self.screen().iter().map(|p| *p * viewport * 0.5).collect();
        let mut least = f64::INFINITY;
        for (index, a) in pixels.iter().enumerate() {
            for b in &pixels[index + 1..] {
                let Some(along) = (*b - *a).try_normalize() else {
                    continue;
                };
                let across = pixels.iter().map(|p| along.perp_dot(*p - *a));
                let (low, high) = across.fold((0.0_f64, 0.0_f64), |(low, high), d| {
                    (low.min(d), high.max(d))
                });
                least = least.min(high - low);
            }
        }
        if least.is_finite() { least } else { 0.0 }
    }

    /// The nearest point of the mirror in view; of one without bounds, of its plane: where a ray
    /// through a corner of the screen meets it, or at the near plane.
    pub fn w_min(&self) -> f64 {
        if self.frame.is_some() {
            self.seen.iter().map(|v| v.w).fold(f64::INFINITY, f64::min)
        } else if self.is_orthographic {
            1.0
        } else {
            let near = self.view_from_clip * DVec4::new(0.0, 0.0, 1.0, 1.0);
            let at_corner = self.height / (self.f_max + self.height * self.far_end(DVec2::ZERO).w);
            at_corner.max(1.0 / near.w)
        }
    }

    /// The noise factor of `f32`: for each ray the sum of all that is rounded on the way.
    pub fn noise(&self, input: &ViewInput) -> f64 {
        let axes = input.world_from_view.matrix3;
        let eye = input.world_from_view.translation;
        let eye = (eye - input.plane.normal * (2.0 * self.height)).length();
        let w_min = self.w_min();
        let rays = self.screen().into_iter().map(|ndc| {
            let far = self.far_end(ndc);
            if self.is_orthographic {
                let near = self.view_from_clip * ndc.extend(1.0).extend(1.0);
                [far, near]
                    .map(|end| (axes * (end.truncate() / end.w)).length())
                    .into_iter()
                    .fold(0.0, f64::max)
            } else {
                (axes * far.truncate()).length()
            }
        });
        let ray = rays.fold(0.0, f64::max);
        let k = 1.0 / self.f_max;
        if self.is_orthographic {
            return 2.0 + 4.0 * k * (ray + 2.0 * eye);
        }
        // By how much w grows along each axis of the world.
        let w_row = input.clip_from_view.row(3).truncate();
        let w = (axes.transpose().inverse() * w_row).length();
        let coordinates = 2.0 * ray + 4.0 * eye / w_min;
        (w + k) / w + (w + k) * coordinates
    }
}

/// Whether a camera is neither scaled nor sheared.
pub fn is_rigid(input: &ViewInput) -> bool {
    let axes = input.world_from_view.matrix3;
    (axes.transpose() * axes).abs_diff_eq(DMat3::IDENTITY, 1e-5)
}

/// How long a camera's axes are, at least and at most.
pub fn lengths(input: &ViewInput) -> (f64, f64) {
    let inverse = input.world_from_view.matrix3.inverse().transpose();
    let longest = |axes: DMat3| {
        let lengths = [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::length);
        lengths.into_iter().fold(0.0, f64::max)
    };
    (
        1.0 / longest(inverse),
        longest(input.world_from_view.matrix3),
    )
}

fn corners_seen([center, u, v]: &[DVec4; 3]) -> Vec<DVec4> {
    let of = |f: fn(DVec4) -> f64| Bound::new(f(*center), f(*u), f(*v));
    let bounds: [Bound; 10] = [
        Bound::new(1.0, 1.0, 0.0),
        Bound::new(1.0, -1.0, 0.0),
        Bound::new(1.0, 0.0, 1.0),
        Bound::new(1.0, 0.0, -1.0),
        of(|p| p.w - p.z),
        of(|p| p.z),
        of(|p| p.w - p.x),
        of(|p| p.w + p.x),
        of(|p| p.w - p.y),
        of(|p| p.w + p.y),
    ];
    let mut seen = Vec::with_capacity(12);
    for (i, a) in bounds.iter().enumerate() {
        for b in &bounds[i + 1..] {
            // Where both are 0, in homogeneous coordinates.
            let cross = a.cross(*b);
            let at = cross / cross.x;
            if !at.is_finite() {
                continue;
            }
            // Almost parallel bounds leave less of it.
            let (a, b) = (a.abs(), b.abs());
            let terms = a.yzx() * b.zxy() + a.zxy() * b.yzx();
            let doubt = 1e-12 * at.abs() + 1e-14 * terms / cross.x.abs();
            let is_inside = |bound: &Bound| bound.dot(at) >= -bound.abs().dot(doubt);
            if bounds.iter().all(is_inside) {
                seen.push(*center + *u * at.y + *v * at.z);
            }
        }
    }
    seen.retain(|p| p.w > 0.0);
    seen
}
