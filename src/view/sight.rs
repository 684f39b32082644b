//! What one viewer, a camera or a reflected view, sees of all mirrors.

use bevy::{
    camera::{
        primitives::Aabb,
        visibility::{InheritedVisibility, RenderLayers, VisibilityRange},
    },
    ecs::{prelude::*, query::QueryData, system::SystemParam},
    mesh::{morph::MeshMorphWeights, skinning::SkinnedMesh},
    platform::collections::HashMap,
    transform::components::GlobalTransform,
};
use glam::{DVec2, DVec3};

use super::{
    DepthRange, PlannedView,
    cover::{Walls, WallsInView},
    decide::{CameraInput, CameraView},
    fit::MirrorPlace,
    visible::range_center,
};
use crate::{
    math::{
        Opening, Plane, ReflectedViewPlan, Skip, ViewInput, bounds_of, is_in_plane, joint_corners,
        plan_reflected_view_within,
    },
    mirror::{MirrorClip, MirrorShadows, PlanarMirror},
    status::{NotDrawn, Projection},
};

/// A mirror, wherever it is seen from.
#[derive(QueryData)]
pub struct MirrorInput {
    pub entity: Entity,
    settings: &'static PlanarMirror,
    place: &'static MirrorPlace,
    visibility: &'static InheritedVisibility,
    layers: Option<&'static RenderLayers>,
}

/// Mirrors that are not simply there. Most scenes have none, and need not look.
#[derive(SystemParam)]
pub struct UnusualMirrors<'w, 's> {
    ranged: Query<
        'w,
        's,
        (
            &'static VisibilityRange,
            &'static GlobalTransform,
            Option<&'static Aabb>,
        ),
        With<PlanarMirror>,
    >,
    deforming: Query<
        'w,
        's,
        (),
        (
            With<PlanarMirror>,
            Or<(With<SkinnedMesh>, With<MeshMorphWeights>)>,
        ),
    >,
}

impl UnusualMirrors<'_, '_> {
    /// Whether a mirror is a flat mesh that moves with its transform alone, and in range of an eye.
    fn check(&self, mirror: Entity, eye: Option<DVec3>) -> Result<(), NotDrawn> {
        if !self.deforming.is_empty() && self.deforming.contains(mirror) {
            return Err(NotDrawn::MeshDeforms);
        }
        if !self.ranged.is_empty()
            && let Some(eye) = eye
            && let Ok((range, transform, bounds)) = self.ranged.get(mirror)
        {
            let center = range_center(range, transform, bounds);
            if range.is_culled(eye.as_vec3a().distance(center)) {
                return Err(NotDrawn::OutOfRange);
            }
        }
        Ok(())
    }
}

/// Who looks, and through what.
pub struct Viewer<'a> {
    /// Whether there is a renderer.
    pub can_draw: bool,
    pub camera: &'a CameraInput,
    pub unusual: &'a UnusualMirrors<'a, 'a>,
    /// Those of mirrors without any.
    pub default_layers: &'a RenderLayers,
    /// Where it looks from, if that is known.
    pub view: Result<CameraView, NotDrawn>,
    /// What may hide mirrors from it, if it is a camera. What does so in a mirror is not looked for.
    pub walls: Option<&'a Walls<'a, 'a>>,
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
    walls: WallsInView,
    seen: Vec<SeenMirror>,
    groups: Vec<Group>,
}

struct SeenMirror {
    /// Which of the mirrors.
    mirror: usize,
    entity: Entity,
    corners: Option<[DVec3; 4]>,
    plan: ReflectedViewPlan,
    /// Of what is seen of it.
    ndc_bounds: (DVec2, DVec2),
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
        mirrors: &Query<MirrorInput>,
        planned: &mut Vec<PlannedView>,
        surfaces: &mut Vec<Entity>,
        mut tell: impl FnMut(usize, Result<usize, NotDrawn>),
    ) {
        self.find(viewer, mirrors, &mut tell);
        self.sort(viewer.max_views);
        self.plan(viewer, planned, surfaces, tell);
    }

    /// Finds the mirrors that it sees, and which of them lie in one plane.
    fn find(
        &mut self,
        viewer: &Viewer,
        mirrors: &Query<MirrorInput>,
        tell: &mut impl FnMut(usize, Result<usize, NotDrawn>),
    ) {
        self.walls.forget();
        self.seen.clear();
        self.groups.clear();
        for (mirror, input) in mirrors.iter().enumerate() {
            let (look, plan) = match viewer.plan(&input) {
                Ok(planned) => planned,
                Err(reason) => {
                    tell(mirror, Err(reason));
                    continue;
                }
            };
            let in_view = self.walls.seen(viewer.walls, viewer.camera, &look, &plan);
            let Some(in_view) = in_view else {
                tell(mirror, Err(NotDrawn::Occluded));
                continue;
            };
            let seen = SeenMirror {
                mirror,
                entity: input.entity,
                corners: look.corners,
                plan,
                ndc_bounds: in_view.ndc_bounds(),
                pixels: in_view.area_px(look.viewport_size),
                group: 0,
            };
            self.add(seen, input.settings, look.plane);
        }
    }

    /// Those in one plane together. The largest come first if something must be left out; else the
    /// order does not depend on the place on the screen.
    fn sort(&mut self, max_views: usize) {
        let groups = &self.groups;
        let too_many = groups.len() > max_views;
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
    }

    /// Plans a view for those in one plane, as long as there may be more.
    fn plan(
        &self,
        viewer: &Viewer,
        planned: &mut Vec<PlannedView>,
        surfaces: &mut Vec<Entity>,
        mut tell: impl FnMut(usize, Result<usize, NotDrawn>),
    ) {
        let mut left = viewer.max_views;
        for group in self.seen.chunk_by(|a, b| a.group == b.group) {
            let Group {
                plane,
                clip,
                shadows,
                ..
            } = self.groups[group[0].group];
            let joint = viewer.plan_joint(&plane, group);
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
                surfaces.extend(members.iter().map(|seen| seen.entity));
                surfaces[first..].sort_unstable();
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
                    entity: members.iter().find_map(|seen| viewer.view_of(seen.entity)),
                    loose_frustum: None,
                    projection: Projection::Oblique,
                    depths: DepthRange::EVERYTHING,
                    cascades: 0..0,
                    lamps: None,
                    pixels: members.iter().map(|seen| seen.pixels).sum(),
                    objects: 0,
                    culls_on_gpu: false,
                });
            }
        }
    }

    fn add(&mut self, mut seen: SeenMirror, settings: &PlanarMirror, plane: Plane) {
        let PlanarMirror { clip, shadows, .. } = *settings;
        let known = seen.corners.and_then(|corners| {
            self.groups.iter().position(|group| {
                group.is_bounded
                    && (group.clip, group.shadows) == (clip, shadows)
                    && is_in_plane(&group.plane, &plane, &corners)
            })
        });
        seen.group = known.unwrap_or(self.groups.len());
        if known.is_none() {
            self.groups.push(Group {
                plane,
                clip,
                shadows,
                is_bounded: seen.corners.is_some(),
                pixels: 0.0,
            });
        }
        self.groups[seen.group].pixels += seen.pixels;
        self.seen.push(seen);
    }
}

impl Viewer<'_> {
    /// The reflected view in which it saw the mirror in the last frame.
    fn view_of(&self, mirror: Entity) -> Option<Entity> {
        self.last.get(&(self.entity?, mirror)).copied()
    }

    /// How it looks at the mirror, and what follows from that.
    fn plan(&self, mirror: &MirrorInputItem) -> Result<(ViewInput, ReflectedViewPlan), NotDrawn> {
        if !self.can_draw {
            return Err(NotDrawn::NoRenderer);
        }
        if !mirror.visibility.get() {
            return Err(NotDrawn::Hidden);
        }
        let layers = mirror.layers.unwrap_or(self.default_layers);
        if !self.camera.layers.intersects(layers) {
            return Err(NotDrawn::OtherLayers);
        }
        let eye = self.view.ok().map(|view| view.world_from_view.translation);
        self.unusual.check(mirror.entity, eye)?;
        let (plane, corners) = mirror.place.0?;
        let was_drawn = self.view_of(mirror.entity).is_some();
        self.plan_quad(plane, corners, was_drawn)
    }

    fn plan_quad(
        &self,
        plane: Plane,
        corners: Option<[DVec3; 4]>,
        was_drawn: bool,
    ) -> Result<(ViewInput, ReflectedViewPlan), NotDrawn> {
        let CameraView {
            world_from_view,
            clip_from_view,
            viewport_size,
        } = self.view?;
        let look = ViewInput {
            world_from_view,
            clip_from_view,
            viewport_size,
            plane,
            corners,
            jitter_px: self.camera.jitter_px,
            was_drawn,
        };
        match plan_reflected_view_within(&look, &self.opening) {
            Ok(plan) => Ok((look, plan)),
            Err(skip) => Err(match skip {
                Skip::DegenerateView => NotDrawn::DegenerateCamera,
                Skip::EyeBehind => NotDrawn::EyeBehind,
                Skip::OutOfView => NotDrawn::OutOfView,
                Skip::TooThin => NotDrawn::TooThin,
                Skip::BelowPrecision => NotDrawn::BelowPrecision,
            }),
        }
    }

    /// One plan for several mirrors of a plane; `None` for a single one, or if there is no such
    /// plan, as may be at the limit of precision.
    fn plan_joint(&self, plane: &Plane, group: &[SeenMirror]) -> Option<ReflectedViewPlan> {
        if group.len() < 2 {
            return None;
        }
        let quads = group.iter().filter_map(|seen| seen.corners);
        let corners = joint_corners(plane, quads)?;
        let was_drawn = group.iter().any(|seen| self.view_of(seen.entity).is_some());
        let (_, plan) = self.plan_quad(*plane, Some(corners), was_drawn).ok()?;
        Some(plan)
    }
}

/// The device coordinates of what is seen of all these.
fn joint_bounds(members: &[SeenMirror]) -> (DVec2, DVec2) {
    bounds_of(members.iter().flat_map(|seen| {
        let (low, high) = seen.ndc_bounds;
        [low, high]
    }))
}
