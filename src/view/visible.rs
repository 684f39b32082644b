//! What each reflected view shows: what Bevy's `check_visibility_cpu_culling` would find in its
//! frustum, less the mirror itself and whatever has no part in front of it.
//!
//! Bevy's own system never sees the views. And it drops what lies outside its bounds, such as a
//! morphed mesh, by the narrow frustum of a mirror; it finds at most 32 views in a
//! `VisibilityRange`; and it leaves meshes with `NoCpuCulling` to a list that views made later
//! never get.

use core::any::TypeId;

use bevy::{
    camera::{
        Camera,
        primitives::{Aabb, Frustum, Sphere},
        visibility::{
            DynamicSkinnedMeshBounds, InheritedVisibility, NoCpuCulling, NoFrustumCulling,
            RenderLayers, SetViewVisibility, ViewVisibility, VisibilityClass, VisibilityRange,
            VisibleEntities,
        },
    },
    ecs::{
        entity::EntityHashSet, entity_disabling::Disabled, prelude::*, query::QueryData,
        system::SystemParam,
    },
    light::cluster::ClusterVisibilityClass,
    mesh::{morph::MeshMorphWeights, skinning::SkinnedMesh},
    pbr::decal::ForwardDecal,
    tasks::ComputeTaskPool,
    transform::components::GlobalTransform,
    utils::{Parallel, TypeIdMap},
};
use glam::{DVec4, Vec3A};

use super::{
    ReflectedView, ReflectedViews,
    bounds::WorldBox,
    clip::{Cut, Seen},
};

/// So many objects are worth to be looked at by several threads.
const MANY: usize = 1024;

/// An object, as far as it matters to whether it shows.
#[derive(QueryData)]
#[query_data(mutable)]
pub struct Object {
    entity: Entity,
    inherited: &'static InheritedVisibility,
    seen: &'static mut ViewVisibility,
    class: Option<&'static VisibilityClass>,
    layers: Option<&'static RenderLayers>,
    transform: &'static GlobalTransform,
    aabb: Option<&'static Aabb>,
    sphere: Option<&'static Sphere>,
    range: Option<&'static VisibilityRange>,
    /// It may be anywhere.
    no_frustum_culling: Has<NoFrustumCulling>,
    no_cpu_culling: Has<NoCpuCulling>,
    is_skinned: Has<SkinnedMesh>,
    has_skin_bounds: Has<DynamicSkinnedMeshBounds>,
    is_morphed: Has<MeshMorphWeights>,
    is_decal: Has<ForwardDecal>,
}

/// What one thread found for one view.
#[derive(Default)]
pub struct Found {
    classes: TypeIdMap<Vec<Entity>>,
    count: usize,
    seen: Seen,
}

/// What tells which objects there are.
#[derive(SystemParam)]
pub struct Objects<'w, 's> {
    objects: Query<'w, 's, Object>,
    gpu_culled: Query<'w, 's, (), With<NoCpuCulling>>,
}

/// Fills in what each view shows, and chooses how it is drawn.
pub fn see_reflected_views(
    mut views: ResMut<ReflectedViews>,
    mut reflected: Query<
        (
            &mut VisibleEntities,
            &Camera,
            &Frustum,
            Option<&RenderLayers>,
        ),
        (With<ReflectedView>, Allow<Disabled>),
    >,
    mut all: Objects,
    mut threads: Local<Parallel<Found>>,
    mut own: Local<EntityHashSet>,
    mut sides: Local<Vec<DVec4>>,
) {
    let any_gpu_culled = !all.gpu_culled.is_empty();
    let by_many = all.objects.iter().len() >= MANY && ComputeTaskPool::try_get().is_some();
    let ReflectedViews {
        planned,
        surfaces,
        alive,
        ..
    } = &mut *views;
    for planned in planned {
        let Some(view) = planned.entity else {
            continue;
        };
        let (Some(live), Ok((mut visible, camera, frustum, layers))) =
            (alive.get_mut(&view), reflected.get_mut(view))
        else {
            continue;
        };
        own.clear();
        own.extend(&surfaces[planned.mirrors.clone()]);
        let eye = Eye {
            layers: layers.unwrap_or_default(),
            position: planned.plan.world_from_view.translation.as_vec3a(),
            frustum,
            loose: planned.loose_frustum.as_ref().unwrap_or(frustum),
            own: &own,
            cut: Cut::new(planned, own.len(), camera, live.was_cut, &mut sides),
        };
        if by_many {
            all.objects.par_iter_mut().for_each_init(
                || threads.borrow_local_mut(),
                |found, object| eye.look_at(object, found),
            );
        } else {
            let mut found = threads.borrow_local_mut();
            for object in &mut all.objects {
                eye.look_at(object, &mut found);
            }
        }
        visible.clear_all();
        let mut seen = Seen::default();
        let mut count = 0;
        for found in threads.iter_mut() {
            for (class, entities) in &mut found.classes {
                visible.get_mut(*class).append(entities);
            }
            seen.add(&core::mem::take(&mut found.seen));
            count += core::mem::take(&mut found.count);
        }
        // The engine finds what is new by comparing sorted lists.
        for entities in visible.entities.values_mut() {
            entities.sort_unstable();
        }
        seen.choose_projection(planned, live, camera);
        planned.objects = count;
        planned.culls_on_gpu = any_gpu_culled && !seen.any_unbounded;
    }
}

/// A reflected view that looks for what it shows.
struct Eye<'a> {
    layers: &'a RenderLayers,
    position: Vec3A,
    frustum: &'a Frustum,
    /// For what may leave its bounds.
    loose: &'a Frustum,
    /// The mirrors, which would lie in the near plane.
    own: &'a EntityHashSet,
    cut: Cut<'a>,
}

/// Where an object is.
enum Place {
    /// In its bounds.
    Bounds,
    /// Near its bounds, but it may leave them.
    AroundBounds,
    /// Nobody knows.
    Anywhere,
}

impl Eye<'_> {
    /// Adds the object to what is seen.
    fn look_at(&self, mut object: ObjectItem, found: &mut Found) {
        if !object.inherited.get()
            || !self.layers.intersects(object.layers.unwrap_or_default())
            // They are laid on what a depth prepass has drawn, and a reflected view has none.
            || object.is_decal
            || self.own.contains(&object.entity)
            || !self.is_in_range(&object)
            || !self.is_in_frustum(&object)
        {
            return;
        }
        let place = object.place();
        let mut shows = None;
        let mut is_listed = object.class.is_none();
        for &class in object.class.iter().flat_map(|class| class.iter()) {
            // Lights and decals reach farther than their bounds.
            if class != TypeId::of::<ClusterVisibilityClass>() {
                let shows = *shows.get_or_insert_with(|| {
                    let bounds = object.aabb.filter(|_| matches!(place, Place::Bounds));
                    let bounds = bounds.map(|aabb| WorldBox::new(object.transform, aabb));
                    self.cut.shows(bounds, &mut found.seen)
                });
                if !shows {
                    continue;
                }
                found.count += 1;
            }
            is_listed = true;
            found.classes.entry(class).or_default().push(object.entity);
        }
        // Bevy sees to those that it does not cull.
        if is_listed && !object.no_cpu_culling {
            object.seen.set_visible();
        }
    }

    /// By the way from the object over the mirror to the eye.
    fn is_in_range(&self, object: &ObjectItem) -> bool {
        object.range.is_none_or(|range| {
            range.is_visible_at_all(self.position.distance(range_center(
                range,
                object.transform,
                object.aabb,
            )))
        })
    }

    /// As Bevy culls.
    fn is_in_frustum(&self, object: &ObjectItem) -> bool {
        let frustum = match object.place() {
            Place::Bounds => self.frustum,
            Place::AroundBounds => self.loose,
            Place::Anywhere => return true,
        };
        if let Some(aabb) = object.aabb {
            let world_from_local = object.transform.affine();
            let sphere = Sphere {
                center: world_from_local.transform_point3a(aabb.center),
                radius: object.transform.radius_vec3a(aabb.half_extents),
            };
            return frustum.intersects_sphere(&sphere, false)
                && frustum.intersects_obb(aabb, &world_from_local, true, false);
        }
        object
            .sphere
            .is_none_or(|sphere| frustum.intersects_sphere(sphere, false))
    }
}

impl ObjectItem<'_, '_> {
    fn place(&self) -> Place {
        if self.no_frustum_culling || self.no_cpu_culling {
            Place::Anywhere
        } else if self.is_morphed || (self.is_skinned && !self.has_skin_bounds) {
            Place::AroundBounds
        } else {
            Place::Bounds
        }
    }
}

/// The point whose distance counts for a `VisibilityRange`.
pub fn range_center(
    range: &VisibilityRange,
    transform: &GlobalTransform,
    aabb: Option<&Aabb>,
) -> Vec3A {
    match aabb {
        Some(aabb) if range.use_aabb => transform.affine().transform_point3a(aabb.center),
        _ => transform.translation_vec3a(),
    }
}
