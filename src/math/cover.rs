//! What opaque faces that stand before a mirror leave of it to be seen.
//!
//! The visible polygon of the mirror is taken apart on the screen: of each of its pieces the part
//! that lies within a face is thrown away, and what is outside of each edge of the face stays, as a
//! piece of its own. The mirror is hidden when nothing is left. That is exact for any number of
//! faces that hide it together; where the pieces become too many, more is left than is seen.
//!
//! A face hides a point of the mirror if the ray to it from the eye meets the face first. The eye is
//! in front of the mirror's plane, and a ray meets a plane once: so what a face has in front of the
//! plane is before the mirror, wherever it is, and no depths need be compared.

use glam::{DAffine3, DMat4, DVec2, DVec3, DVec4, Vec4Swizzles};

use super::{
    polygon::{VisiblePolygon, bounds_of, clip_polygon_within},
    projection::BaseProjection,
    view::{ReflectedViewPlan, ViewInput},
};

/// So much of a mirror may be left, in pixels across all pieces: no less than it takes to draw one.
const NEGLIGIBLE_PX: f64 = 0.25;
/// In more pieces than this it is not worth to go on.
const MAX_PIECES: usize = 16;
/// A face must be nearer to the eye than the mirror by this share of the distance.
const MIN_GAP: f64 = 1e-3;
/// And by so large a share of the depth of an orthographic view, whose steps are all alike.
const MIN_GAP_OF_DEPTH: f64 = 32.0 * f32::EPSILON as f64;
/// A thinner face hides nothing.
const MIN_FACE_PX: f64 = 1.0 / 16.0;
/// A vertex may be off by so many `f32` steps of the coordinates that it is computed from.
const ROUNDING_STEPS: f64 = 8.0;

/// What is seen of one mirror by one camera, less the faces that hide it.
#[derive(Debug)]
pub struct Cover {
    /// Without any face.
    mirror: VisiblePolygon,
    left: Vec<VisiblePolygon>,
    /// Of pieces too thin to be kept, in pixels.
    thin_px: f64,
    /// What `left` was before the last face. Kept to use its memory again.
    before: Vec<VisiblePolygon>,
}

impl Default for Cover {
    /// Of nothing at all.
    fn default() -> Self {
        Self {
            mirror: VisiblePolygon::EMPTY,
            left: Vec::new(),
            thin_px: 0.0,
            before: Vec::new(),
        }
    }
}

impl Cover {
    /// Begins with a mirror of which all is seen.
    pub fn begin(&mut self, mirror: &VisiblePolygon) {
        self.mirror = *mirror;
        self.thin_px = 0.0;
        self.left.clear();
        self.left.push(*mirror);
    }

    /// Whether nothing is left that would be drawn.
    pub fn is_whole(&self) -> bool {
        self.left.is_empty() && self.is_open()
    }

    /// Whether it is worth to take away more.
    pub fn is_open(&self) -> bool {
        self.left.len() <= MAX_PIECES && self.thin_px < NEGLIGIBLE_PX
    }

    /// What is left, in pieces that do not overlap. Of a mirror that was taken apart too finely it
    /// is all of it.
    pub fn left(&self) -> &[VisiblePolygon] {
        if self.thin_px < NEGLIGIBLE_PX {
            &self.left
        } else {
            core::slice::from_ref(&self.mirror)
        }
    }

    /// The lowest and the highest coordinates on the screen of what is left.
    pub fn ndc_bounds(&self) -> (DVec2, DVec2) {
        bounds_of(self.left().iter().flat_map(VisiblePolygon::ndc))
    }

    /// Its area in pixels.
    pub fn area_px(&self, viewport_size: DVec2) -> f64 {
        let areas = self.left().iter().map(|piece| piece.area_px(viewport_size));
        areas.sum()
    }

    /// Takes away what is within a face, see [`CoverView::face`].
    pub fn take_away(&mut self, face: &VisiblePolygon, viewport_size: DVec2) {
        let turn = face.twice_area().signum();
        core::mem::swap(&mut self.left, &mut self.before);
        self.left.clear();
        for piece in &self.before {
            let first = self.left.len();
            let thin_px = self.thin_px;
            let mut inside = *piece;
            for line in face.edge_lines() {
                let from_edge = |v: DVec4| turn * line.dot(v.xyw());
                if inside.vertices().iter().all(|v| from_edge(*v) >= 0.0) {
                    continue;
                }
                // No room for another vertex: it stays as it is.
                if inside.is_full() {
                    inside = VisiblePolygon::EMPTY;
                    break;
                }
                let outside = inside.clipped(|v| -from_edge(v));
                let width = outside.min_width_px(viewport_size);
                if width > NEGLIGIBLE_PX / MAX_PIECES as f64 {
                    self.left.push(outside);
                } else {
                    self.thin_px += width;
                }
                inside = inside.clipped(from_edge);
                if inside.is_empty() {
                    break;
                }
            }
            // It is beside the face, and was cut for nothing.
            if inside.is_empty() {
                self.left.truncate(first);
                self.left.push(*piece);
                self.thin_px = thin_px;
            }
        }
    }
}

/// A camera that looks at a mirror, and at what may stand before it.
#[derive(Clone, Copy, Debug)]
pub struct CoverView {
    eye: DVec3,
    viewport_size: DVec2,
    /// From the axes of the world around the eye.
    clip_from_world: DMat4,
    /// What is seen of the mirror on the screen.
    bounds: (DVec2, DVec2),
    /// Positive where a face is surely before the mirror.
    plane_clip: DVec4,
    /// Of what size, in world units, shows no larger than a quarter of a pixel where clip `w` is 1.
    invisible: f64,
}

impl CoverView {
    /// `None` for a mirror without bounds, of which it is not known where it is seen.
    pub fn new(input: &ViewInput, plan: &ReflectedViewPlan) -> Option<Self> {
        let ViewInput {
            world_from_view,
            clip_from_view,
            viewport_size,
            ..
        } = input;
        plan.polygon.w_min()?;
        let projection = BaseProjection::new(clip_from_view)?;
        let axes = world_from_view.matrix3;
        let gap = if projection.is_orthographic {
            let depth = projection.view_from_clip.z_axis.truncate();
            MIN_GAP_OF_DEPTH * (axes * depth).length()
        } else {
            MIN_GAP * plan.eye_height
        };
        // The reflection has negated it.
        let before_mirror = -plan.plane_view - DVec4::W * gap;
        let view_from_world = DMat4::from_mat3(axes.try_inverse()?);
        Some(Self {
            eye: world_from_view.translation,
            viewport_size: *viewport_size,
            clip_from_world: projection.clip_from_view * view_from_world,
            bounds: plan.polygon.ndc_bounds(),
            plane_clip: projection.clip_covector(before_mirror),
            invisible: plan.ghost_size,
        })
    }

    /// What a triangle may hide of the mirror, given in its own space; `None` if that is nothing.
    ///
    /// Nor is anything hidden for sure by a triangle that single precision moves by more than a
    /// quarter of a pixel.
    pub fn face(
        &self,
        triangle: [DVec3; 3],
        world_from_local: &DAffine3,
    ) -> Option<VisiblePolygon> {
        let [a, b, c] = triangle.map(|corner| {
            let from_eye = world_from_local.transform_point3(corner) - self.eye;
            self.clip_from_world * from_eye.extend(1.0)
        });
        let face = clip_polygon_within(&[a, b, c, c], self.bounds, Some(self.plane_clip));
        let w_min = face.w_min()?;
        let size = triangle.map(|corner| rounded_from(world_from_local, corner));
        let largest = size
            .into_iter()
            .fold(self.eye.abs(), DVec3::max)
            .max_element();
        let off = ROUNDING_STEPS * f64::from(f32::EPSILON) * largest;
        let is_sure = off <= self.invisible * w_min;
        // What is thinner has edges that point anywhere.
        let is_wide = || face.min_width_px(self.viewport_size) > MIN_FACE_PX;
        (is_sure && is_wide()).then_some(face)
    }
}

/// The largest numbers that a vertex is computed from.
fn rounded_from(world_from_local: &DAffine3, corner: DVec3) -> DVec3 {
    world_from_local.matrix3.abs() * corner.abs() + world_from_local.translation.abs()
}
