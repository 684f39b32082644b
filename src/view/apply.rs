//! Brings the reflected views' entities in line with what was decided.

use bevy::{
    camera::{Camera, Camera3d, RenderTarget, primitives::Frustum},
    ecs::{component::Mutable, entity_disabling::Disabled, name::Name, prelude::*},
    light::cluster::ClusterConfig,
    math::{
        Affine3A,
        primitives::{HalfSpace, ViewFrustum},
    },
    render::view::NoIndirectDrawing,
    transform::components::{GlobalTransform, Transform},
};
use glam::DAffine3;

use super::{PlannedView, ReflectedView, ReflectedViews, copy::copy_camera_components};
use crate::math::{Plane, narrowed_sides, reflect_vector};

/// Spawns, updates and despawns reflected views.
///
/// Runs after the user's frusta are up to date and before visibility, so that the transforms and
/// projections of this very frame are used.
pub fn apply_reflected_views(world: &mut World) {
    world.resource_scope(|world, mut views: Mut<ReflectedViews>| {
        let views = &mut *views;
        for live in views.alive.values_mut() {
            live.is_wanted = false;
        }
        // What was planned knows of the last frame's by now.
        views.entities.clear();
        for index in 0..views.planned.len() {
            let made = entity_of(world, views, index);
            views.planned[index].entity = made.map(|(_, view)| view);
            let Some((viewer, view)) = made else {
                continue;
            };
            views.clean.clean(world, view);
            views.planned[index].loose_frustum =
                update_view(world, viewer, view, &views.planned, index);
        }
        views.alive.retain(|&view, live| {
            if !live.is_wanted
                && let Ok(mut view) = world.get_entity_mut(view)
            {
                // No camera any more, before observers of its removal can look it up.
                view.remove::<(Camera, Camera3d)>();
                // What is disabled when it goes is not missed by the render world.
                view.remove::<Disabled>();
                view.despawn();
            }
            live.is_wanted
        });
    });
}

/// What sees a planned view's mirrors, and the entity of the view: the one that showed any of these
/// mirrors before, else a new one. It looks as its camera does.
fn entity_of(
    world: &mut World,
    views: &mut ReflectedViews,
    index: usize,
) -> Option<(Entity, Entity)> {
    let planned = &views.planned[index];
    let camera = planned.camera;
    let viewer = match planned.viewer {
        None => camera,
        Some(outer) => views.planned[outer].entity?,
    };
    let mirrors = &views.surfaces[planned.mirrors.clone()];
    // Mirrors that were in one plane and are not any more have one view between them; and somebody
    // may have cleared the world.
    let is_free = |view: &Entity| views.alive.get(view).is_some_and(|live| !live.is_wanted);
    let known = planned
        .entity
        .filter(|view| is_free(view) && world.get_entity(*view).is_ok());
    let view = known.unwrap_or_else(|| spawn_view(world, camera, viewer, mirrors[0]));
    // Observers of new cameras have run by now, and may have despawned either.
    let alive = |entity| world.get_entity(entity).is_ok();
    let is_wanted = alive(camera) && alive(viewer) && alive(view);
    views.alive.entry(view).or_default().is_wanted = is_wanted;
    if !is_wanted {
        return None;
    }
    for mirror in mirrors {
        views.entities.insert((viewer, *mirror), view);
    }
    copy_camera_components(world, camera, view, known.is_none());
    Some((viewer, view))
}

/// Takes the reflected views out of every query again.
pub fn disable_reflected_views(world: &mut World) {
    for_each_view(world, |view| {
        view.insert(Disabled);
    });
}

/// Lets the engine see the reflected views; [`disable_reflected_views`] ends that.
pub fn enable_reflected_views(world: &mut World) {
    for_each_view(world, |view| {
        view.remove::<Disabled>();
    });
}

fn for_each_view(world: &mut World, change: impl Fn(&mut EntityWorldMut)) {
    // Out of the world for the time being, which observers may change.
    let mut views = core::mem::take(&mut *world.resource_mut::<ReflectedViews>());
    for &view in views.alive.keys() {
        // Somebody may have cleared the world.
        if let Ok(mut entity) = world.get_entity_mut(view) {
            change(&mut entity);
            views.clean.clean(world, view);
        }
    }
    *world.resource_mut::<ReflectedViews>() = views;
}

fn spawn_view(world: &mut World, camera: Entity, viewer: Entity, mirror: Entity) -> Entity {
    let is_direct = world.get::<NoIndirectDrawing>(camera).is_some();
    let view = world.spawn((
        // From the start, so that an observer that looks up what was added by a query finds nothing.
        Disabled,
        Name::new(format!("reflected view of {viewer} in {mirror}")),
        ReflectedView,
        Camera3d::default(),
        ClusterConfig::default(),
    ));
    let view = view.id();
    if let Ok(mut view) = world.get_entity_mut(view) {
        // Its place is computed, not propagated.
        view.remove::<Transform>();
        // Drawn as its camera is; the engine allows of no change later.
        if is_direct {
            view.insert(NoIndirectDrawing);
        } else {
            view.remove::<NoIndirectDrawing>();
        }
    }
    view
}

fn update_view(
    world: &mut World,
    viewer: Entity,
    view: Entity,
    all_planned: &[PlannedView],
    index: usize,
) -> Option<Frustum> {
    let planned = &all_planned[index];
    let main = world.entity(planned.camera);
    let (Some(main_camera), Some(main_3d), Some(frustum)) = (
        main.get::<Camera>(),
        main.get::<Camera3d>(),
        world.entity(viewer).get::<Frustum>(),
    ) else {
        return None;
    };
    let main_camera = main_camera.clone();
    let main_3d = main_3d.clone();
    let loose_viewer = match planned.viewer {
        None => Some(*frustum),
        Some(outer) => all_planned[outer].loose_frustum,
    };
    let frustum = narrowed_frustum(planned, &main_camera, frustum);
    let size = main_camera.physical_target_size().unwrap_or_default();
    let camera = Camera {
        // Before every camera of the user's, and no two alike: Bevy warns of equal orders.
        order: isize::MIN + index as isize,
        ..main_camera
    };
    let world_from_view = planned.plan.world_from_view;
    let mut view = world.entity_mut(view);
    set(&mut view, camera);
    set(&mut view, main_3d);
    set(&mut view, RenderTarget::None { size });
    set(&mut view, GlobalTransform::from(single(&world_from_view)));
    set(&mut view, frustum);
    loose_viewer.map(|viewer| loose_frustum(planned, &viewer))
}

/// Writes a component in place: an insertion would wake observers in every frame, and bring back
/// required components that the view is not to have.
pub fn set<T: Component<Mutability = Mutable>>(view: &mut EntityWorldMut, value: T) {
    if let Some(mut component) = view.get_mut::<T>() {
        *component = value;
    } else {
        view.insert(value);
    }
}

/// Rounds once to the precision of the renderer.
fn single(affine: &DAffine3) -> Affine3A {
    Affine3A {
        matrix3: affine.matrix3.as_mat3().into(),
        translation: affine.translation.as_vec3a(),
    }
}

/// The half-spaces that hold all that can show in the mirror: its plane for the near plane (the
/// camera's own test of it is never true for an oblique projection), and sides through the
/// bounds of what is seen of the mirror. The far half-space is that of what sees the mirror,
/// reflected.
fn narrowed_frustum(planned: &PlannedView, camera: &Camera, viewer: &Frustum) -> Frustum {
    let plan = &planned.plan;
    let viewport = camera
        .physical_viewport_size()
        .unwrap_or_default()
        .as_dvec2();
    let clip_from_view = camera.clip_from_view().as_dmat4();
    let sides = narrowed_sides(planned.ndc_bounds, &clip_from_view, viewport);
    // Planes are covectors: they go to world space by the inverse transpose.
    let world_from_view = glam::DMat4::from(plan.world_from_view);
    let to_world = world_from_view.inverse().transpose();
    let mut half_spaces = viewer.half_spaces;
    for (half_space, side) in half_spaces.iter_mut().zip(sides) {
        *half_space = HalfSpace::new((to_world * side).as_vec4());
    }
    half_spaces[ViewFrustum::NEAR_PLANE_IDX] = HalfSpace::new(planned.plane.covector().as_vec4());
    let far = &mut half_spaces[ViewFrustum::FAR_PLANE_IDX];
    *far = reflected_half_space(&planned.plane, far);
    Frustum(ViewFrustum { half_spaces })
}

/// The frustum of what sees the mirror, reflected, without a near plane. For what may leave its
/// bounds: the engine culls it by these sides in the camera's own picture too.
fn loose_frustum(planned: &PlannedView, viewer: &Frustum) -> Frustum {
    let mut half_spaces = viewer
        .half_spaces
        .map(|half_space| reflected_half_space(&planned.plane, &half_space));
    let near = &mut half_spaces[ViewFrustum::NEAR_PLANE_IDX];
    *near = HalfSpace::new(near.normal().extend(f32::INFINITY));
    Frustum(ViewFrustum { half_spaces })
}

/// A half-space as seen in the mirror. One without a bound stays as it is.
fn reflected_half_space(plane: &Plane, half_space: &HalfSpace) -> HalfSpace {
    let normal_d = half_space.normal_d().as_dvec4();
    if !normal_d.is_finite() {
        return *half_space;
    }
    let normal = normal_d.truncate();
    // (n, d) R with R p = p - 2 m (m.(p - o)).
    let d = normal_d.w + 2.0 * plane.normal.dot(normal) * plane.normal.dot(plane.origin);
    HalfSpace::new(reflect_vector(plane.normal, normal).extend(d).as_vec4())
}
