//! What a reflected view carries: what makes it a camera, and what of the user's camera changes how
//! its picture looks. Nothing else stays on it, whatever the app requires of cameras or an observer
//! inserts.

use core::any::TypeId;

use bevy::{
    camera::{
        Camera, Camera3d, CameraMainTextureUsages, CompositingSpace, Exposure, Hdr, Projection,
        RenderTarget,
        primitives::Frustum,
        visibility::{
            InheritedVisibility, RenderLayers, ViewVisibility, Visibility, VisibleEntities,
        },
    },
    core_pipeline::{
        Skybox,
        tonemapping::{DebandDither, Tonemapping},
    },
    ecs::{
        archetype::ArchetypeId, component::ComponentId, component::Mutable,
        entity_disabling::Disabled, name::Name, prelude::*,
    },
    light::{
        AmbientLight, EnvironmentMapLight, ShadowFilteringMethod,
        cluster::{ClusterConfig, Clusters},
    },
    pbr::{DistanceFog, ScreenSpaceTransmission},
    platform::collections::HashSet,
    render::{
        camera::{CameraRenderGraph, MipBias, TemporalJitter},
        sync_world::{RenderEntity, SyncToRenderWorld},
        view::{ColorGrading, Msaa, NoIndirectDrawing},
    },
    transform::components::GlobalTransform,
};

use super::{ReflectedView, apply::set};

/// The components that are kept alike on camera and view.
///
/// What works on the finished picture (bloom, depth of field, sharpening, ...) is not among them:
/// it sees the reflection as part of the camera's own picture. Nor are the light clusters, see
/// [`cluster_reflected_views`](super::cluster_reflected_views).
const COPIED: [Copied; 17] = [
    Copied::of::<AmbientLight>(),
    Copied::of::<ColorGrading>(),
    Copied::of::<CompositingSpace>(),
    Copied::of::<DebandDither>(),
    Copied::of::<DistanceFog>(),
    Copied::of::<EnvironmentMapLight>(),
    Copied::of::<Exposure>(),
    Copied::of::<Hdr>(),
    Copied::of::<MipBias>(),
    Copied::of::<Msaa>(),
    Copied::of::<Projection>(),
    Copied::of::<RenderLayers>(),
    Copied::of::<ScreenSpaceTransmission>(),
    Copied::of::<ShadowFilteringMethod>(),
    Copied::of::<Skybox>(),
    Copied::of::<TemporalJitter>(),
    Copied::of::<Tonemapping>(),
];

/// What a view carries besides, as the plugin or the engine fills it in.
fn own_types() -> [TypeId; 19] {
    [
        TypeId::of::<Camera>(),
        TypeId::of::<Camera3d>(),
        TypeId::of::<CameraMainTextureUsages>(),
        TypeId::of::<CameraRenderGraph>(),
        TypeId::of::<ClusterConfig>(),
        TypeId::of::<Clusters>(),
        TypeId::of::<Disabled>(),
        TypeId::of::<Frustum>(),
        TypeId::of::<GlobalTransform>(),
        TypeId::of::<InheritedVisibility>(),
        TypeId::of::<Name>(),
        TypeId::of::<NoIndirectDrawing>(),
        TypeId::of::<ReflectedView>(),
        TypeId::of::<RenderEntity>(),
        TypeId::of::<RenderTarget>(),
        TypeId::of::<SyncToRenderWorld>(),
        TypeId::of::<ViewVisibility>(),
        TypeId::of::<Visibility>(),
        TypeId::of::<VisibleEntities>(),
    ]
}

/// A component that a view has exactly as its camera has it.
struct Copied {
    type_id: fn() -> TypeId,
    copy: fn(&Pair, &mut World),
}

impl Copied {
    const fn of<T: Component<Mutability = Mutable> + Clone>() -> Self {
        Self {
            type_id: TypeId::of::<T>,
            copy: Pair::copy::<T>,
        }
    }
}

/// Brings the view's components in line with the camera's, of those that matter to its picture.
///
/// A `fresh` view has default components that nobody chose: everything is copied.
pub fn copy_camera_components(world: &mut World, camera: Entity, view: Entity, fresh: bool) {
    let pair = Pair {
        camera,
        view,
        fresh,
    };
    for component in &COPIED {
        (component.copy)(&pair, world);
    }
}

/// Archetypes that hold nothing but what a view is to carry.
#[derive(Default)]
pub struct CleanArchetypes(HashSet<ArchetypeId>);

impl CleanArchetypes {
    /// Takes off the view what others put there: components that the app requires of cameras, or
    /// inserts into new ones. A prepass without textures, for one, would stop the renderer.
    pub fn clean(&mut self, world: &mut World, view: Entity) {
        let Ok(entity) = world.get_entity(view) else {
            return;
        };
        if self.0.contains(&entity.archetype().id()) {
            return;
        }
        let own = own_types();
        let is_foreign = |id: &ComponentId| {
            let info = world.components().get_info(*id);
            let type_id = info.and_then(|info| info.type_id());
            !type_id.is_some_and(|type_id| {
                own.contains(&type_id) || COPIED.iter().any(|it| (it.type_id)() == type_id)
            })
        };
        let components = entity.archetype().components().iter().copied();
        let foreign: Vec<ComponentId> = components.filter(is_foreign).collect();
        // Observers of the removal may put something back. It goes before the next use.
        world.entity_mut(view).remove_by_ids(&foreign);
        if foreign.is_empty()
            && let Ok(entity) = world.get_entity(view)
        {
            self.0.insert(entity.archetype().id());
        }
    }
}

struct Pair {
    camera: Entity,
    view: Entity,
    fresh: bool,
}

impl Pair {
    /// Copies `T` if it is newer on the camera, removes it if the camera has none.
    fn copy<T: Component<Mutability = Mutable> + Clone>(&self, world: &mut World) {
        let source = world.entity(self.camera).get_ref::<T>();
        let copied = world.entity(self.view).get_ref::<T>();
        match (source, copied) {
            (Some(source), Some(copied))
                if !self.fresh
                    && !source
                        .last_changed()
                        .is_newer_than(copied.last_changed(), world.read_change_tick()) => {}
            (Some(source), _) => {
                let value = T::clone(&source);
                set(&mut world.entity_mut(self.view), value);
            }
            (None, Some(_)) => {
                world.entity_mut(self.view).remove::<T>();
            }
            (None, None) => {}
        }
    }
}
