//! The geometry of a planar mirror, without an engine: where its plane is, the view that sees the
//! reflection, and the projection that cuts at the plane.
//!
//! | file | question it answers |
//! |---|---|
//! | `plane` | what a plane is, and how far a point is in front of it |
//! | `patch` | where a flat rectangle of a mesh lies in the world |
//! | `fit` | which rectangle a flat mesh covers |
//! | `join` | which mirrors lie in one plane, and share their reflection |
//! | `reflection` | where a point, a direction and a camera go by reflection |
//! | `projection` | how a projection is undone, and what kind it is |
//! | `polygon` | which part of the mirror a camera sees |
//! | `cover` | what is left of that past what stands before the mirror |
//! | `oblique` | how the near plane of a projection is moved to the mirror |
//! | `noise` | how much of that survives single precision |
//! | `side` | which objects lie in front of, behind and across the plane |
//! | `view` | all of it together: the plan for one mirror and one camera |
//!
//! # Conventions
//!
//! Matrices act on column vectors and are named `a_from_b`. World and view space are right
//! handed, the view looks down -Z. The clip volume is `-w <= x, y <= w` and `0 <= z <= w`, with
//! reversed depth: 1 near, 0 far. Lengths are world units unless a name or a sentence says pixels.
//! A plane is a covector `(n, d)`: `n.p + d` is positive on the side that the mirror shows.
//!
//! # Precision
//!
//! Everything takes and returns `f64`; the caller widens its `f32` input, which is exact, and
//! rounds the result once. Distances are taken in relative form, `n.(p - o)`, so that they do not
//! cancel far from the origin of the world.
//!
//! # What is measured
//!
//! On random scenes at the extremes (fields of view up to 179 degrees, up to ten million units from
//! the origin, stretched cameras and mirrors), of which so many are drawn. The last column is the
//! largest share of its bound that was used.
//!
//! | law | scenes | share |
//! |---|---|---|
//! | [`depth_error`] of what is visible, in `f32` and three orders of evaluation | 122,073 | 0.51 |
//! | [`clip_plane_error`], likewise | 122,073 | 0.50 |
//! | [`margin`] at the far end of every ray, of a depth row rounded to `f32` | 407,959 | 0.12 |
//! | [`clip_plane_error`], of such a row | 407,959 | 0.11 |
//! | [`ReflectedViewPlan::ghost_tolerance`], of a quarter of a pixel | 407,959 | 1.00 |
//!
//! `PLANAR_MIRROR_STABILITY=full cargo test --test math stability -- --nocapture` measures it anew.
//!
//! In pictures of 320 x 240 pixels by Mesa's software rasterizer, so with all that comes after:
//!
//! | | at the origin | 10 units away | 1000 units away |
//! |---|---|---|---|
//! | a pixel on the wrong side of the cut, from it, in pixels, 60 scenes each | 0.0021 | 0.0021 | 0.0102 |
//!
//! Of 500 scenes at the extremes, drawn there and compared with pictures that know no mirrors, 32 of
//! 2,309,468 pixels of mirrors differ by more than two levels of 255; on an NVIDIA H200 38. All but
//! 2, or 3, are where a step of single precision at the eye is more than 1/2048 of a pixel. The same
//! variable with `--test pictures random_scenes` measures that.
//!
//! Of two panels as far apart as [`depth_error`] asks for the nearer one was seen in all of 33
//! cases, at an eighth of that as well, and in 27 of them at a 64th: the bound is safe, and wide.
//! Nothing was lost at 1e3 and 1e7 units. The same variable with `--test pictures precision`
//! measures that.
//!
//! An NVIDIA H200 is less exact where the depth of a large triangle slopes, as it does in every
//! oblique projection: the nearer panel was seen at the promised distance in 31 of the 33 cases,
//! from four times as far apart on in the other two, and at a 64th in 19. The bound is that of the
//! vertices; no standard bounds what is interpolated between them.
//!
//! # Errors
//!
//! Nothing here panics. What cannot be answered is `None` or a named reason; not a number and
//! infinity are such cases wherever they would reach a matrix. Functions on single values (a
//! reflected point, a distance) pass them through.

mod cover;
mod fit;
mod join;
mod noise;
mod oblique;
mod patch;
mod plane;
mod polygon;
mod projection;
mod reflection;
mod side;
mod view;

pub use cover::{Cover, CoverView};
pub use fit::{FitError, fit_patch};
pub use join::{is_in_plane, joint_corners};
pub use noise::{MAX_MARGIN, clip_plane_error, depth_error, margin, noise};
pub use oblique::{
    Reach, fitted_depth_row, oblique_k, oblique_row, plane_in_clip, plane_in_reflected_view,
    plane_reach, raster_guard, with_depth_row, with_oblique_near_plane,
};
pub use patch::{PlanarPatch, transform_patch};
pub use plane::Plane;
pub(crate) use polygon::bounds_of;
pub use polygon::{Opening, VisiblePolygon, clip_polygon, clip_polygon_within};
pub use projection::BaseProjection;
pub use reflection::{reflect_point, reflect_vector, reflected_world_from_view, reflection_affine};
pub use side::{Side, classify, edge_sides, narrowed_sides, signed_distance_range};
pub use view::{
    ReflectedViewPlan, Skip, ViewInput, plan_reflected_view, plan_reflected_view_within,
};
