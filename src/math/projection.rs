//! The camera's own projection, and its inverse.

use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};

/// A projection that can be undone: perspective (infinite, finite, off-center) or orthographic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseProjection {
    /// View to clip space, reversed depth.
    pub clip_from_view: DMat4,
    /// Its inverse.
    pub view_from_clip: DMat4,
    /// Whether clip `w` is the view depth `-z`, as in every common perspective.
    pub depth_is_w: bool,
    /// Whether clip `w` is the same for all points.
    pub is_orthographic: bool,
}

impl BaseProjection {
    /// `None` if the matrix is not finite, cannot be inverted, or has no positive `w`.
    pub fn new(clip_from_view: &DMat4) -> Option<Self> {
        if !clip_from_view.is_finite() {
            return None;
        }
        let mut view_from_clip = clip_from_view.try_inverse()?;
        let w_row = clip_from_view.row(3);
        let depth_is_w = w_row == DVec4::NEG_Z;
        if depth_is_w {
            // w = -z exactly, and the closed form of the depth row relies on it.
            view_from_clip.x_axis.z = 0.0;
            view_from_clip.y_axis.z = 0.0;
            view_from_clip.z_axis.z = 0.0;
            view_from_clip.w_axis.z = -1.0;
        }
        let is_orthographic = is_orthographic(clip_from_view);
        let usable = view_from_clip.is_finite() && (!is_orthographic || w_row.w > 0.0);
        usable.then_some(Self {
            clip_from_view: *clip_from_view,
            view_from_clip,
            depth_is_w,
            is_orthographic,
        })
    }

    /// The clip-space covector of a view-space covector: `C B^-1`.
    pub fn clip_covector(&self, view_covector: DVec4) -> DVec4 {
        self.view_from_clip.transpose() * view_covector
    }

    /// The same projection of points given in the axes and the units of the world, from the eye.
    pub fn around_eye(&self, world_from_view: &DMat3, view_from_world: &DMat3) -> Self {
        Self {
            clip_from_view: self.clip_from_view * DMat4::from_mat3(*view_from_world),
            view_from_clip: DMat4::from_mat3(*world_from_view) * self.view_from_clip,
            depth_is_w: false,
            ..*self
        }
    }

    /// How far the visible points of a pixel may lie from the eye: the ray's length per unit of `w`
    /// for a perspective, the distance of its farther end for an orthographic projection. In the
    /// units of the space that the projection starts from.
    pub(super) fn ray_length(&self, ndc: DVec2) -> f64 {
        let end = |z| self.view_from_clip * ndc.extend(z).extend(1.0);
        if self.is_orthographic {
            let (far, near) = (end(0.0), end(1.0));
            (far.truncate() / far.w)
                .length()
                .max((near.truncate() / near.w).length())
        } else {
            end(0.0).truncate().length()
        }
    }
}

/// Whether clip `w` is the same for all points.
pub fn is_orthographic(clip_from_view: &DMat4) -> bool {
    clip_from_view.row(3).truncate() == DVec3::ZERO
}
