//! The part of a mirror's rectangle that a camera sees.

use glam::{DVec2, DVec3, DVec4, Vec4Swizzles};

/// A quad clipped by seven planes has at most eleven vertices; one to spare for rounding.
const CAPACITY: usize = 12;

/// A convex polygon in homogeneous clip space, inside the clip volume. Lives on the stack.
#[derive(Clone, Copy, Debug)]
pub struct VisiblePolygon {
    vertices: [DVec4; CAPACITY],
    len: usize,
    is_full_view: bool,
}

impl PartialEq for VisiblePolygon {
    fn eq(&self, other: &Self) -> bool {
        self.vertices() == other.vertices() && self.is_full_view == other.is_full_view
    }
}

impl VisiblePolygon {
    pub(super) const EMPTY: Self = Self {
        vertices: [DVec4::ZERO; CAPACITY],
        len: 0,
        is_full_view: false,
    };

    /// The whole screen: for a mirror without known bounds.
    pub fn full_view() -> Self {
        Self::all_within(&Opening::SCREEN)
    }

    /// All of an opening: for a mirror without known bounds.
    pub(super) fn all_within(opening: &Opening) -> Self {
        let Opening { low, high, .. } = *opening;
        let mut polygon = Self::EMPTY;
        for (x, y) in [
            (low.x, low.y),
            (high.x, low.y),
            (high.x, high.y),
            (low.x, high.y),
        ] {
            polygon.push(DVec4::new(x, y, 0.0, 1.0));
        }
        polygon.is_full_view = true;
        polygon
    }

    /// The vertices in clip space, in order around the polygon.
    pub fn vertices(&self) -> &[DVec4] {
        self.vertices.get(..self.len).unwrap_or(&[])
    }

    /// The vertices on the screen, each coordinate from -1 to 1.
    pub fn ndc(&self) -> impl Iterator<Item = DVec2> + Clone + '_ {
        self.vertices().iter().map(|v| {
            // Rounding in the clipping leaves a vertex outside by an ulp.
            (v.truncate().truncate() / v.w).clamp(DVec2::NEG_ONE, DVec2::ONE)
        })
    }

    /// Whether nothing is visible.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The smallest clip `w` of a visible point: for a perspective the view depth at which the
    /// mirror begins. `None` when empty, and for the [full view](Self::full_view).
    pub fn w_min(&self) -> Option<f64> {
        if self.is_full_view {
            return None;
        }
        self.vertices().iter().map(|v| v.w).reduce(f64::min)
    }

    /// The lowest and the highest coordinates on the screen; `low > high` when empty.
    pub fn ndc_bounds(&self) -> (DVec2, DVec2) {
        bounds_of(self.ndc())
    }

    /// The width of the narrowest strip of the screen that holds the polygon, in pixels of a
    /// `viewport` of that size. 0 when empty.
    ///
    /// The narrowest strip of a convex polygon lies along one of its edges.
    pub fn min_width_px(&self, viewport: DVec2) -> f64 {
        let pixels = |p: DVec2| p * viewport * 0.5;
        let next = self.ndc().cycle().skip(1);
        let width = self.ndc().zip(next).filter_map(|(a, b)| {
            let (a, b) = (pixels(a), pixels(b));
            let length = a.distance(b);
            (length > 0.0).then(|| {
                let normal = (b - a).perp() / length;
                self.ndc()
                    .map(|p| normal.dot(pixels(p) - a).abs())
                    .fold(0.0, f64::max)
            })
        });
        width.reduce(f64::min).unwrap_or(0.0)
    }

    /// The area in pixels of a `viewport` of that size. 0 when empty.
    pub fn area_px(&self, viewport: DVec2) -> f64 {
        // Device coordinates are two units wide.
        self.twice_area().abs() / 8.0 * viewport.x * viewport.y
    }

    /// Whether there is no room for another vertex.
    pub(super) fn is_full(&self) -> bool {
        self.len == CAPACITY
    }

    /// The lines on the screen along the edges: covectors of `(x, y, w)`, positive to the left.
    ///
    /// An edge so short that rounding decides where it leads has none.
    pub(super) fn edge_lines(&self) -> impl Iterator<Item = DVec3> + '_ {
        const MIN_SINE: f64 = 1e-12;
        let next = self.vertices().iter().cycle().skip(1);
        let edges = self.vertices().iter().zip(next);
        edges.filter_map(|(a, b)| {
            let (a, b) = (a.xyw(), b.xyw());
            let line = a.cross(b);
            (line.length() > MIN_SINE * a.length() * b.length()).then_some(line)
        })
    }

    /// Twice the area in device coordinates, positive if the vertices turn to the left.
    pub fn twice_area(&self) -> f64 {
        let next = self.ndc().cycle().skip(1);
        self.ndc().zip(next).map(|(a, b)| a.perp_dot(b)).sum()
    }

    fn push(&mut self, vertex: DVec4) {
        // Only a polygon that rounding has made concave could ask for more than there is.
        if let Some(slot) = self.vertices.get_mut(self.len) {
            *slot = vertex;
            self.len += 1;
        }
    }

    /// The part where `distance`, linear in the vertex, is not negative (Sutherland-Hodgman).
    pub(super) fn clipped(&self, distance: impl Fn(DVec4) -> f64) -> Self {
        let mut kept = Self::EMPTY;
        let vertices = self.vertices();
        for (index, &a) in vertices.iter().enumerate() {
            let b = vertices[(index + 1) % vertices.len()];
            let (from, to) = (distance(a), distance(b));
            if from >= 0.0 {
                kept.push(a);
            }
            // Vertices on the plane itself are kept above, so only true crossings cut.
            if (from > 0.0 && to < 0.0) || (from < 0.0 && to > 0.0) {
                kept.push(cut(a, from, b, to));
            }
        }
        kept
    }
}

/// The lowest and the highest coordinates of some points; `low > high` for none.
pub fn bounds_of(points: impl Iterator<Item = DVec2>) -> (DVec2, DVec2) {
    points.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
        (low.min(p), high.max(p))
    })
}

/// The point between `a` and `b` where the distance is 0.
///
/// Measured from the nearer end, and the same for both directions of an edge.
fn cut(a: DVec4, from: f64, b: DVec4, to: f64) -> DVec4 {
    if from.abs() <= to.abs() {
        a + (b - a) * (from / (from - to))
    } else {
        b + (a - b) * (to / (to - from))
    }
}

/// Through what a mirror is looked at: the screen, or another mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening {
    /// The lowest coordinates on the screen, from -1 on.
    pub low: DVec2,
    /// The highest coordinates on the screen, to 1.
    pub high: DVec2,
    /// What is behind this plane of view space, the other mirror's, does not show.
    pub plane_view: Option<DVec4>,
}

impl Opening {
    /// The whole screen.
    pub const SCREEN: Self = Self {
        low: DVec2::NEG_ONE,
        high: DVec2::ONE,
        plane_view: None,
    };
}

/// The visible part of a quad, given its corners in clip space in order around it.
///
/// The quad is clipped to the whole clip volume, `|x| <= w`, `|y| <= w` and `0 <= z <= w`; for an
/// infinite perspective, where `z` is the near distance everywhere, the last is `w >= near`.
/// Empty if nothing is visible or a corner is not finite.
pub fn clip_polygon(corners_clip: &[DVec4; 4]) -> VisiblePolygon {
    clip_polygon_within(corners_clip, (DVec2::NEG_ONE, DVec2::ONE), None)
}

/// [`clip_polygon`], of which only what shows between `low` and `high` on the screen is kept, and
/// what is in front of `plane_clip`, a plane of clip space.
pub fn clip_polygon_within(
    corners_clip: &[DVec4; 4],
    (low, high): (DVec2, DVec2),
    plane_clip: Option<DVec4>,
) -> VisiblePolygon {
    if !corners_clip.iter().all(|corner| corner.is_finite()) {
        return VisiblePolygon::EMPTY;
    }
    let mut visible = VisiblePolygon::EMPTY;
    for &corner in corners_clip {
        visible.push(corner);
    }
    for plane in volume(low, high).into_iter().chain(plane_clip) {
        if visible.vertices().iter().any(|v| plane.dot(*v) < 0.0) {
            visible = visible.clipped(|v| plane.dot(v));
        }
    }
    // A projection without a near plane leaves the eye itself, which has no place on the screen.
    let on_screen = visible
        .vertices()
        .iter()
        .all(|v| v.is_finite() && v.w > 0.0);
    if on_screen {
        visible
    } else {
        VisiblePolygon::EMPTY
    }
}

/// Whether a quad lies wholly beyond one plane of the clip volume between `low` and `high`: what
/// there is to know of most mirrors, at a small part of the price of their polygon.
pub(super) fn is_beyond(corners_clip: &[DVec4; 4], (low, high): (DVec2, DVec2)) -> bool {
    // The dot products with `volume`, without what is zero.
    let is_outside = |v: &DVec4| {
        [
            v.w < v.z,
            v.z < 0.0,
            high.x * v.w < v.x,
            v.x < low.x * v.w,
            high.y * v.w < v.y,
            v.y < low.y * v.w,
        ]
    };
    let mut are_all_outside = [true; 6];
    for corner in corners_clip {
        for (all, one) in are_all_outside.iter_mut().zip(is_outside(corner)) {
            *all &= one;
        }
    }
    are_all_outside.contains(&true)
}

/// The planes of the clip volume between `low` and `high` on the screen, to the inside.
fn volume(low: DVec2, high: DVec2) -> [DVec4; 6] {
    [
        // First, so that w is positive from there on.
        DVec4::new(0.0, 0.0, -1.0, 1.0),
        DVec4::new(0.0, 0.0, 1.0, 0.0),
        DVec4::new(-1.0, 0.0, 0.0, high.x),
        DVec4::new(1.0, 0.0, 0.0, -low.x),
        DVec4::new(0.0, -1.0, 0.0, high.y),
        DVec4::new(0.0, 1.0, 0.0, -low.y),
    ]
}
