//! What one viewer, a camera or a reflected view, sees of all mirrors.

use bevy::{camera::visibility::RenderLayers, ecs::prelude::*, platform::collections::HashMap};
use glam::{DVec2, DVec3};

use super::{
    DepthRange, PlannedView,
    decide::{CameraInput, CameraView},
};
use crate::{
    math::{
        Opening, Plane, ReflectedViewPlan, Skip, ViewInput, is_in_plane, joint_corners,
        plan_reflected_view_within,
    },
    mirror::{MirrorClip, MirrorShadows},
    status::{NotDrawn, Projection},
};

/// A mirror, wherever it is seen from.
pub struct MirrorInput {
    pub entity: Entity,
    pub clip: MirrorClip,
    pub shadows: MirrorShadows,
    pub layers: RenderLayers,
    /// Its plane and its corners in the world, as far as they are known.
    pub place: Result<(Plane, Option<[DVec3; 4]>), NotDrawn>,
}

/// Who looks, and through what.
pub struct Viewer<'a> {
    pub camera: &'a CameraInput,
    /// Where it looks from, if that is known.
    pub view: Result<CameraView, NotDrawn>,
    pub opening: Opening,
    /// See [`PlannedView`].
    pub viewer: Option<usize>,
    pub bounce: u8,
    /// The camera, or the reflected view as far as it was there in the last frame.
    pub entity: Option<Entity>,
    /// The reflected views of the last frame, see [`ReflectedViews`](super::ReflectedViews).
    pub last: &'a HashMap<(Entity, Entity), Entity>,
    /// So many more may be planned.
    pub max_views: usize,
}

/// What is being decided for one viewer. Kept to use its memory again.
#[derive(Default)]
pub struct Sight {
    seen: Vec<SeenMirror>,
    groups: Vec<Group>,
}

struct SeenMirror {
    /// Which of the mirrors.
    mirror: usize,
    plan: ReflectedViewPlan,
    /// What is seen of it.
    pixels: f64,
    group: usize,
}

/// Mirrors in one plane that are drawn alike.
struct Group {
    plane: Plane,
    clip: MirrorClip,
    shadows: MirrorShadows,
    /// Mirrors without bounds are not joined with others.
    is_bounded: bool,
    /// What is seen of them.
    pixels: f64,
}

impl Sight {
    /// Plans the views of all mirrors that the viewer sees, and tells of each mirror which that is
    /// or why there is none.
    pub fn see(
        &mut self,
        viewer: &Viewer,
        mirrors: &[MirrorInput],
        planned: &mut Vec<PlannedView>,
        surfaces: &mut Vec<Entity>,
        mut tell: impl FnMut(usize, Result<usize, NotDrawn>),
    ) {
        self.seen.clear();
        self.groups.clear();
        for (mirror, input) in mirrors.iter().enumerate() {
            match viewer.plan(input) {
                Ok((plane, corners, plan)) => {
                    let pixels = plan.polygon.area_px(viewer.viewport_size());
                    self.add(mirror, input, plane, corners, plan, pixels);
                }
                Err(reason) => tell(mirror, Err(reason)),
            }
        }
        // The order does not depend on the place on the screen unless something must be left out.
        let groups = &self.groups;
        let too_many = groups.len() > viewer.max_views;
        let rank = |seen: &SeenMirror| {
            if too_many {
                groups[seen.group].pixels
            } else {
                0.0
            }
        };
        self.seen.sort_unstable_by(|a, b| {
            rank(b)
                .total_cmp(&rank(a))
                .then((a.group, a.mirror).cmp(&(b.group, b.mirror)))
        });
        let mut left = viewer.max_views;
        for group in self.seen.chunk_by(|a, b| a.group == b.group) {
            let joint = viewer.plan_joint(group, mirrors);
            let size = if joint.is_some() { group.len() } else { 1 };
            for members in group.chunks(size) {
                if left == 0 {
                    for seen in members {
                        tell(seen.mirror, Err(NotDrawn::TooManyMirrors));
                    }
                    continue;
                }
                left -= 1;
                for seen in members {
                    tell(seen.mirror, Ok(planned.len()));
                }
                let first = surfaces.len();
                surfaces.extend(members.iter().map(|seen| mirrors[seen.mirror].entity));
                surfaces[first..].sort_unstable();
                let Group {
                    plane,
                    clip,
                    shadows,
                    ..
                } = self.groups[group[0].group];
                let plan = joint.unwrap_or(members[0].plan);
                planned.push(PlannedView {
                    camera: viewer.camera.entity,
                    viewer: viewer.viewer,
                    bounce: viewer.bounce,
                    mirrors: first..surfaces.len(),
                    plane,
                    ndc_bounds: joint_bounds(members),
                    clip_from_view: plan.clip_from_view_oblique.as_mat4(),
                    plan,
                    clip,
                    shadows,
                    entity: members
                        .iter()
                        .find_map(|seen| viewer.view_of(mirrors[seen.mirror].entity)),
                    projection: Projection::Oblique,
                    depths: DepthRange::EVERYTHING,
                    pixels: members.iter().map(|seen| seen.pixels).sum(),
                    objects: 0,
                });
            }
        }
    }

    fn add(
        &mut self,
        mirror: usize,
        input: &MirrorInput,
        plane: Plane,
        corners: Option<[DVec3; 4]>,
        plan: ReflectedViewPlan,
        pixels: f64,
    ) {
        let known = corners.and_then(|corners| {
            self.groups.iter().position(|group| {
                group.is_bounded
                    && (group.clip, group.shadows) == (input.clip, input.shadows)
                    && is_in_plane(&group.plane, &plane, &corners)
            })
        });
        let group = known.unwrap_or(self.groups.len());
        if known.is_none() {
            self.groups.push(Group {
                plane,
                clip: input.clip,
                shadows: input.shadows,
                is_bounded: corners.is_some(),
                pixels: 0.0,
            });
        }
        self.groups[group].pixels += pixels;
        self.seen.push(SeenMirror {
            mirror,
            plan,
            pixels,
            group,
        });
    }
}

impl Viewer<'_> {
    /// The reflected view in which it saw the mirror in the last frame.
    fn view_of(&self, mirror: Entity) -> Option<Entity> {
        self.last.get(&(self.entity?, mirror)).copied()
    }

    fn viewport_size(&self) -> DVec2 {
        self.view.map_or(DVec2::ZERO, |view| view.viewport_size)
    }

    fn plan(
        &self,
        mirror: &MirrorInput,
    ) -> Result<(Plane, Option<[DVec3; 4]>, ReflectedViewPlan), NotDrawn> {
        // What concerns the mirror alone is named first.
        if let Err(reason @ (NotDrawn::NoRenderer | NotDrawn::Hidden)) = mirror.place {
            return Err(reason);
        }
        if !self.camera.layers.intersects(&mirror.layers) {
            return Err(NotDrawn::OtherLayers);
        }
        let (plane, corners) = mirror.place?;
        let was_drawn = self.view_of(mirror.entity).is_some();
        let plan = self.plan_quad(plane, corners, was_drawn)?;
        Ok((plane, corners, plan))
    }

    fn plan_quad(
        &self,
        plane: Plane,
        corners: Option<[DVec3; 4]>,
        was_drawn: bool,
    ) -> Result<ReflectedViewPlan, NotDrawn> {
        let CameraView {
            world_from_view,
            clip_from_view,
            viewport_size,
        } = self.view?;
        let input = ViewInput {
            world_from_view,
            clip_from_view,
            viewport_size,
            plane,
            corners,
            jitter_px: self.camera.jitter_px,
            was_drawn,
        };
        plan_reflected_view_within(&input, &self.opening).map_err(|skip| match skip {
            Skip::DegenerateView => NotDrawn::DegenerateCamera,
            Skip::EyeBehind => NotDrawn::EyeBehind,
            Skip::OutOfView => NotDrawn::OutOfView,
            Skip::TooThin => NotDrawn::TooThin,
            Skip::BelowPrecision => NotDrawn::BelowPrecision,
        })
    }

    /// One plan for several mirrors of a plane; `None` for a single one, or if there is no such
    /// plan, as may be at the limit of precision.
    fn plan_joint(
        &self,
        group: &[SeenMirror],
        mirrors: &[MirrorInput],
    ) -> Option<ReflectedViewPlan> {
        let (first, others) = group.split_first()?;
        if others.is_empty() {
            return None;
        }
        let quads = group
            .iter()
            .filter_map(|seen| mirrors[seen.mirror].place.ok()?.1);
        let (plane, _) = mirrors[first.mirror].place.ok()?;
        let was_drawn = group
            .iter()
            .any(|seen| self.view_of(mirrors[seen.mirror].entity).is_some());
        self.plan_quad(plane, Some(joint_corners(&plane, quads)?), was_drawn)
            .ok()
    }
}

/// The device coordinates of what is seen of all these.
fn joint_bounds(members: &[SeenMirror]) -> (DVec2, DVec2) {
    members
        .iter()
        .map(|seen| seen.plan.polygon.ndc_bounds())
        .fold(
            (DVec2::INFINITY, DVec2::NEG_INFINITY),
            |(low, high), bounds| (low.min(bounds.0), high.max(bounds.1)),
        )
}
