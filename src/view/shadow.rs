//! Directional shadows of reflected views: the camera's own, or else drawn again without what falls
//! on nothing that is seen.
//!
//! A reflected view has cascades like any camera's, over its whole frustum. Of these the reflection
//! samples only the ones that hold what shows in the mirror, and of each of these only the column
//! of light that leads to it. The cascades' own matrices stay as they are, so a shadow has the
//! same texels as in any picture of the same view.
//!
//! They are the texels of the camera's maps as well. Bevy's `build_directional_light_cascades` gives
//! each map the axes of its light, a width that follows from the projection alone, and a center on
//! whole texels. A camera and its reflection differ in nothing but where they stand, so their maps
//! are pieces of one grid. If the camera's piece reaches wherever a reflection looks, it is read
//! instead.

use core::any::TypeId;

use bevy::{
    camera::{
        Camera,
        primitives::{Aabb, CascadesFrusta, Frustum},
        visibility::{
            CascadesVisibleEntities, InheritedVisibility, NoCpuCulling, NoFrustumCulling,
            RenderLayers, SetViewVisibility, ViewVisibility, VisibilityRange, VisibleEntities,
        },
    },
    ecs::{entity_disabling::Disabled, prelude::*, query::QueryData, system::SystemParam},
    light::{
        CascadeShadowConfig, Cascades, DirectionalLight, NotShadowCaster, ShadowFilteringMethod,
        cluster::ClusterVisibilityClass,
    },
    math::primitives::HalfSpace,
    mesh::Mesh3d,
    transform::components::GlobalTransform,
};
use glam::Vec2;

use super::{
    DepthRange, PlannedView, ReflectedView, ReflectedViews,
    bounds::{Bounds, WorldBox},
    lookup::{Lookup, is_cascade_read},
    visible::range_center,
};
use crate::mirror::MirrorShadows;

/// A cascade of a reflected view's own that something seen in the view reads.
pub struct SeenCascade {
    pub light: Entity,
    /// Which of the light's cascades.
    pub index: usize,
    /// The lowest and the highest device coordinates of what is read of its map; `None` if that is
    /// not known.
    pub ndc_bounds: Option<(Vec2, Vec2)>,
}

/// A light that may throw shadows.
#[derive(QueryData)]
#[query_data(mutable)]
pub struct Sun {
    entity: Entity,
    light: &'static DirectionalLight,
    config: &'static CascadeShadowConfig,
    cascades: &'static mut Cascades,
    frusta: &'static mut CascadesFrusta,
    visibility: &'static InheritedVisibility,
    layers: Option<&'static RenderLayers>,
}

/// Whether a light that is visible or not, on these layers, throws shadows on anything that a view
/// shows.
fn casts(
    visibility: &InheritedVisibility,
    sun: Option<&RenderLayers>,
    view: &RenderLayers,
) -> bool {
    visibility.get() && sun.unwrap_or_default().intersects(view)
}

/// What reflected views show.
#[derive(SystemParam)]
pub struct Shown<'w, 's> {
    visible: Query<'w, 's, &'static VisibleEntities, (With<ReflectedView>, Allow<Disabled>)>,
    objects: Query<'w, 's, Bounds<'static>>,
}

impl Shown<'_, '_> {
    /// The objects in a view. `None` may be anywhere.
    fn boxes(&self, view: Entity, depths: DepthRange) -> impl Iterator<Item = Option<WorldBox>> {
        // Then some may be in no list.
        let unlisted = (depths == DepthRange::EVERYTHING).then_some(None);
        let listed = self.visible.get(view).into_iter();
        let listed = listed
            .flat_map(|visible| &visible.entities)
            .filter(|(class, _)| **class != TypeId::of::<ClusterVisibilityClass>())
            .flat_map(|(_, objects)| objects)
            .map(|&object| WorldBox::of(self.objects.get(object).ok()?));
        unlisted.into_iter().chain(listed)
    }
}

/// A reflected view, as far as what it reads depends on it.
struct Reader<'a> {
    view: Entity,
    planned: &'a PlannedView,
    camera: (&'a Camera, Option<&'a ShadowFilteringMethod>),
    layers: &'a RenderLayers,
}

/// Chooses where the shadows of reflected views come from. Of their own cascades those beyond the
/// last that is read are taken away, and the frusta narrowed by which casters are found.
pub fn narrow_cascades(
    mut views: ResMut<ReflectedViews>,
    cameras: Query<
        (
            &Camera,
            Option<&ShadowFilteringMethod>,
            Option<&RenderLayers>,
        ),
        (With<ReflectedView>, Allow<Disabled>),
    >,
    // To each eye others of them are there.
    ranged_casters: Query<(), (With<VisibilityRange>, Without<NotShadowCaster>)>,
    shown: Shown,
    mut suns: Query<Sun>,
) {
    let ReflectedViews {
        planned, cascades, ..
    } = &mut *views;
    cascades.clear();
    for planned in planned {
        let first = cascades.len();
        planned.cascades = first..first;
        let Some(view) = planned.entity else {
            continue;
        };
        let Ok((camera, filter, layers)) = cameras.get(view) else {
            continue;
        };
        let reader = Reader {
            view,
            planned,
            camera: (camera, filter),
            layers: layers.unwrap_or_default(),
        };
        let shadows = match planned.shadows {
            MirrorShadows::Auto => {
                let is_shared = ranged_casters.is_empty()
                    && suns
                        .iter()
                        .all(|sun| reader.finds_all_at_the_cameras(&sun, &shown));
                if is_shared {
                    MirrorShadows::Shared
                } else {
                    MirrorShadows::Own
                }
            }
            chosen => chosen,
        };
        for mut sun in &mut suns {
            reader.narrow(&mut sun, shadows, cascades);
        }
        planned.shadows = shadows;
        planned.cascades.end = cascades.len();
    }
}

impl Reader<'_> {
    /// Whether the camera's maps of a light hold all that this view would read of its own.
    fn finds_all_at_the_cameras(&self, sun: &SunReadOnlyItem, shown: &Shown) -> bool {
        // Else its cascades may be those of the time when it still threw shadows.
        if !sun.light.shadow_maps_enabled || !casts(sun.visibility, sun.layers, self.layers) {
            return true;
        }
        let cascades = &sun.cascades.cascades;
        let (Some(own), Some(of_camera)) =
            (cascades.get(&self.view), cascades.get(&self.planned.camera))
        else {
            return false;
        };
        own.iter().enumerate().all(|(index, own)| {
            if !is_cascade_read(sun.config, index, self.planned.depths) {
                return true;
            }
            let lookup = self.lookup(sun.light, sun.config, index, own.texel_size);
            lookup
                .zip(of_camera.get(index))
                .is_some_and(|(lookup, of_camera)| {
                    let objects = shown.boxes(self.view, self.planned.depths);
                    own.texel_size == of_camera.texel_size && lookup.is_within(of_camera, objects)
                })
        })
    }

    /// Leaves of this view's cascades for a light those that are read, with the maps from where
    /// they shall come.
    fn narrow(&self, sun: &mut SunItem, shadows: MirrorShadows, cascades: &mut Vec<SeenCascade>) {
        if !sun.light.shadow_maps_enabled {
            return;
        }
        let casts = casts(sun.visibility, sun.layers, self.layers);
        let of_light = &mut sun.cascades.cascades;
        let Some(frusta) = sun.frusta.frusta.get_mut(&self.view) else {
            return;
        };
        let mut needed = 0;
        for (index, frustum) in frusta.iter_mut().enumerate() {
            if shadows == MirrorShadows::Off
                || !casts
                || !is_cascade_read(sun.config, index, self.planned.depths)
            {
                hold_nothing(frustum);
                continue;
            }
            let of_camera = (shadows == MirrorShadows::Shared).then(|| {
                let cascades = of_light.get(&self.planned.camera);
                let cascade = cascades.and_then(|cascades| cascades.get(index));
                cascade.cloned().unwrap_or_default()
            });
            let Some(cascade) = of_light
                .get_mut(&self.view)
                .and_then(|own| own.get_mut(index))
            else {
                break;
            };
            needed = index + 1;
            if let Some(of_camera) = of_camera {
                hold_nothing(frustum);
                *cascade = of_camera;
                continue;
            }
            let lookup = self.lookup(sun.light, sun.config, index, cascade.texel_size);
            if let Some(lookup) = &lookup {
                lookup.narrow(frustum, cascade);
            }
            cascades.push(SeenCascade {
                light: sun.entity,
                index,
                ndc_bounds: lookup.map(|lookup| lookup.map_bounds(cascade)),
            });
        }
        frusta.truncate(needed);
        if let Some(own) = of_light.get_mut(&self.view) {
            own.truncate(needed);
        }
    }

    fn lookup(
        &self,
        light: &DirectionalLight,
        config: &CascadeShadowConfig,
        index: usize,
        texel_size: f32,
    ) -> Option<Lookup> {
        Lookup::new(
            self.planned,
            self.camera,
            (light, config),
            index,
            texel_size,
        )
    }
}

/// A half-space beyond every object.
fn hold_nothing(frustum: &mut Frustum) {
    const BEYOND: f32 = -1e30;
    let side = &mut frustum.half_spaces[0];
    *side = HalfSpace::new(side.normal().extend(BEYOND));
}

/// What throws shadows while it is in its range.
#[derive(QueryData)]
#[query_data(mutable)]
pub struct RangedCaster {
    entity: Entity,
    inherited: &'static InheritedVisibility,
    seen: &'static mut ViewVisibility,
    layers: Option<&'static RenderLayers>,
    transform: &'static GlobalTransform,
    aabb: Option<&'static Aabb>,
    range: &'static VisibilityRange,
    no_frustum_culling: Has<NoFrustumCulling>,
}

type ThrowsShadows = (
    With<Mesh3d>,
    Without<NotShadowCaster>,
    Without<NoCpuCulling>,
    Without<DirectionalLight>,
);

/// Whether any shadow maps of reflected views' own are drawn.
pub fn any_own_cascades(views: Res<ReflectedViews>) -> bool {
    !views.cascades.is_empty()
}

/// Adds to the casters of each view's own cascades those with a `VisibilityRange`. The engine
/// leaves them out: it does not know what is in range of a view that it does not see.
pub fn add_ranged_casters(
    views: Res<ReflectedViews>,
    mut suns: Query<(
        &CascadesFrusta,
        &mut CascadesVisibleEntities,
        Option<&RenderLayers>,
    )>,
    mut casters: Query<RangedCaster, ThrowsShadows>,
) {
    if casters.is_empty() {
        return;
    }
    for planned in &views.planned {
        let Some(view) = planned.entity else {
            continue;
        };
        let eye = planned.plan.world_from_view.translation.as_vec3a();
        for cascade in &views.cascades[planned.cascades.clone()] {
            let Ok((frusta, mut visible, layers)) = suns.get_mut(cascade.light) else {
                continue;
            };
            let layers = layers.unwrap_or_default();
            let frustum = frusta
                .frusta
                .get(&view)
                .and_then(|frusta| frusta.get(cascade.index));
            let visible = visible
                .entities
                .get_mut(&view)
                .and_then(|visible| visible.get_mut(cascade.index));
            let (Some(frustum), Some(visible)) = (frustum, visible) else {
                continue;
            };
            for mut caster in &mut casters {
                let center = range_center(caster.range, caster.transform, caster.aabb);
                let is_in_frustum = || {
                    caster.aabb.is_none_or(|aabb| {
                        caster.no_frustum_culling
                            || frustum.intersects_obb(aabb, &caster.transform.affine(), false, true)
                    })
                };
                if caster.inherited.get()
                    && layers.intersects(caster.layers.unwrap_or_default())
                    && caster.range.is_visible_at_all(eye.distance(center))
                    && is_in_frustum()
                {
                    visible.entities.push(caster.entity);
                    caster.seen.set_visible();
                }
            }
            visible.entities.sort_unstable();
        }
    }
}
