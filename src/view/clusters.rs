//! Light clusters of reflected views.
//!
//! Where few lamps reach what a view can see, one cluster holds them all, and the engine has nothing
//! to find out. Else the view has no more clusters than the seen part of the mirror is worth, and
//! none with a corner on the mirror's horizon. None of that changes a pixel: it decides how many
//! lamps are looked at in vain, and what it takes to know them.
//!
//! Where the GPU sorts lamps into clusters, the grid is laid out here, as the engine's
//! `assign_objects_to_clusters` would, which does not see the views. Where the CPU does, that
//! system sees them while it runs.

use bevy::{
    camera::{
        Camera,
        primitives::{Frustum, Sphere},
        visibility::InheritedVisibility,
    },
    ecs::{entity_disabling::Disabled, prelude::*},
    light::{
        ClusteredDecal, LightProbe, PointLight, SpotLight,
        cluster::{
            ClusterConfig, ClusterFarZMode, ClusterableObjects, Clusters, GlobalClusterSettings,
        },
    },
    transform::components::GlobalTransform,
};
use glam::{DVec2, UVec2, UVec3, Vec3A};

use super::{ReflectedView, ReflectedViews};

/// So many lamps share one cluster, whatever the mirror's size.
///
/// A lamp that does not reach a pixel is looked at there in vain. But to sort lamps into clusters
/// takes the engine five passes and half a dozen buffers a view.
const ALWAYS_LISTED: usize = 8;

/// And so many, if few pixels are seen of the mirror.
const MOST_LISTED: usize = 32;

/// How often lamps may be looked at, over all pixels of a mirror: as often as all pixels of a screen
/// of 2 million look at two of them.
const LOOKS: f64 = (1 << 22) as f64;

/// So many pixels of a mirror for each cluster, at least.
///
/// To find out whether a light reaches a cluster costs about as much as to shade a pixel by it, and
/// is done twice. So clusters add at most an eighth to the light of the pixels that are seen; the
/// default of 4096 is all of it from 65,536 pixels on.
const PIXELS_OF_CLUSTER: f64 = 16.0;

/// How far clusters reach before the engine has told how far the lamps do.
const FIRST_FAR: f32 = 1000.0;

/// A point or spot light that may reach what is seen in a mirror.
#[derive(Clone, Copy)]
pub struct Lamp {
    pub light: Entity,
    pub is_spot: bool,
}

/// All point and spot lights.
type Lamps<'w, 's, L> = Query<
    'w,
    's,
    (
        Entity,
        &'static L,
        &'static GlobalTransform,
        &'static InheritedVisibility,
    ),
>;

/// Chooses the clusters of every planned view.
pub fn cluster_reflected_views(
    mut views: ResMut<ReflectedViews>,
    cameras: Query<(&Camera, Option<&ClusterConfig>), Without<ReflectedView>>,
    mut reflected: Query<
        (
            &Frustum,
            &GlobalTransform,
            &mut ClusterConfig,
            &mut Clusters,
        ),
        (With<ReflectedView>, Allow<Disabled>),
    >,
    points: Lamps<PointLight>,
    spots: Lamps<SpotLight>,
    others: Query<(), Or<(With<LightProbe>, With<ClusteredDecal>)>>,
    settings: Option<Res<GlobalClusterSettings>>,
) {
    let ReflectedViews { planned, lamps, .. } = &mut *views;
    lamps.clear();
    // Sorting on the CPU looks at the clusters alone. And of what is no lamp only the engine knows
    // the number.
    let settings = settings.filter(|settings| settings.gpu_clustering.is_some());
    let can_list = settings.is_some() && others.is_empty();
    for planned in planned {
        planned.lamps = None;
        let (Ok((camera, config)), Some(Ok((frustum, transform, mut own, mut clusters)))) = (
            cameras.get(planned.camera),
            planned.entity.map(|view| reflected.get_mut(view)),
        ) else {
            continue;
        };
        let config = config.copied().unwrap_or_default();
        // How far the lamps of the last frame reached. The engine writes 0 before the answer is
        // there, and would then cut off what is farther, in the second frame of each view.
        if clusters.last_frame_farthest_z == Some(0.0) {
            clusters.last_frame_farthest_z = None;
        }
        let mut set = |chosen: ClusterConfig| {
            *own = chosen;
            if let Some(settings) = &settings {
                lay_out(&mut clusters, &chosen, (camera, transform), settings);
            }
        };
        // Then the camera sees no lamps, and neither do its mirrors.
        if matches!(config, ClusterConfig::None) {
            set(config);
            continue;
        }
        if can_list {
            let first = lamps.len();
            let most = most_listed(planned.pixels);
            let points = reaching(&points, frustum, |lamp| lamp.range, false);
            let spots = reaching(&spots, frustum, |lamp| lamp.range, true);
            lamps.extend(points.chain(spots).take(most + 1));
            if lamps.len() - first <= most {
                planned.lamps = Some(first..lamps.len());
                set(ClusterConfig::Single);
                continue;
            }
            lamps.truncate(first);
        }
        set(fitted(config, camera, planned.pixels));
    }
}

/// The engine's grid of clusters for a view, to be filled by the GPU.
fn lay_out(
    clusters: &mut Clusters,
    config: &ClusterConfig,
    (camera, transform): (&Camera, &GlobalTransform),
    settings: &GlobalClusterSettings,
) {
    clusters.clusterable_objects = ClusterableObjects::Gpu;
    let size = camera.physical_viewport_size().unwrap_or_default();
    let (mut dimensions, z_config, is_resized) = match *config {
        ClusterConfig::Single => (UVec3::ONE, None, false),
        ClusterConfig::XYZ {
            dimensions,
            z_config,
            dynamic_resizing,
        } => (dimensions, Some(z_config), dynamic_resizing),
        ClusterConfig::None | ClusterConfig::FixedZ { .. } => (UVec3::ZERO, None, false),
    };
    if size.min_element() == 0 || dimensions.min_element() == 0 {
        clusters.tile_size = UVec2::ONE;
        clusters.dimensions = UVec3::ZERO;
        (clusters.near, clusters.far) = (0.0, 0.0);
        return;
    }
    let far = match z_config.map(|config| config.far_z_mode) {
        Some(ClusterFarZMode::Constant(far)) => far,
        _ => clusters.last_frame_farthest_z.unwrap_or(FIRST_FAR),
    };
    let projection = camera.clip_from_view();
    let first_slice = z_config.map_or(0.0, |config| config.first_slice_depth);
    let near = match (projection.w_axis.w == 1.0, dimensions.z) {
        (true, _) => (projection.w_axis.z - 1.0) / projection.z_axis.z,
        (false, 1) => first_slice.max(far),
        (false, _) => first_slice,
    };
    let near = near * transform.compute_transform().scale.z.recip();
    if is_resized
        && let Some(count) = clusters.last_frame_total_cluster_index_count
        && count > settings.view_cluster_bindings_max_indices
    {
        let ratio = settings.view_cluster_bindings_max_indices as f32 / count as f32;
        let fewer = (dimensions.truncate().as_vec2() * ratio.sqrt()).as_uvec2();
        dimensions = fewer.max(UVec2::ONE).extend(dimensions.z);
    }
    let size = size.as_vec2();
    let tile_size = (size / dimensions.truncate().as_vec2()).ceil();
    clusters.tile_size = tile_size.as_uvec2().max(UVec2::ONE);
    clusters.dimensions = (size / clusters.tile_size.as_vec2())
        .ceil()
        .as_uvec2()
        .extend(dimensions.z)
        .max(UVec3::ONE);
    clusters.near = near;
    clusters.far = far.max(near);
}

/// The lamps that may reach something in the frustum: no part of a spot's light is farther than its
/// range either.
fn reaching<L: Component>(
    lamps: &Lamps<L>,
    frustum: &Frustum,
    range: fn(&L) -> f32,
    is_spot: bool,
) -> impl Iterator<Item = Lamp> {
    lamps.iter().filter_map(move |(light, lamp, at, visible)| {
        let sphere = Sphere {
            center: Vec3A::from(at.translation()),
            radius: range(lamp),
        };
        let reaches = visible.get() && frustum.intersects_sphere(&sphere, true);
        reaches.then_some(Lamp { light, is_spot })
    })
}

/// How many lamps one cluster may hold.
fn most_listed(pixels: f64) -> usize {
    // Saturates: of no pixels it is any number.
    ((LOOKS / pixels) as usize).clamp(ALWAYS_LISTED, MOST_LISTED)
}

/// The camera's clusters, fewer if few `pixels` are seen of the mirrors: all of them are filled,
/// whether they are seen or not.
///
/// An odd number of them across and down. The engine finds their corners where the view's rays meet
/// the near plane, which is the mirror's, and those along its horizon never do. The horizon of a
/// level camera over a floor is the middle of the picture.
fn fitted(config: ClusterConfig, camera: &Camera, pixels: f64) -> ClusterConfig {
    match config {
        ClusterConfig::FixedZ {
            total,
            z_slices,
            z_config,
            dynamic_resizing,
        } => {
            let worth = (pixels / PIXELS_OF_CLUSTER).min(total.into());
            let of_slice = worth / f64::from(z_slices.clamp(1, total.max(1)));
            let size = camera.physical_viewport_size().unwrap_or(UVec2::ONE);
            ClusterConfig::XYZ {
                dimensions: square_tiles(of_slice, size).extend(z_slices),
                z_config,
                dynamic_resizing,
            }
        }
        ClusterConfig::XYZ {
            dimensions,
            z_config,
            dynamic_resizing,
        } => ClusterConfig::XYZ {
            dimensions: odd(dimensions.truncate()).extend(dimensions.z),
            z_config,
            dynamic_resizing,
        },
        ClusterConfig::None | ClusterConfig::Single => config,
    }
}

/// At most `count` tiles across and down a picture, about as wide as high.
fn square_tiles(count: f64, size: UVec2) -> UVec2 {
    let size = size.as_dvec2();
    let ratio = size.x / size.y;
    let across = DVec2::new(count * ratio, count / ratio).map(f64::sqrt);
    // A picture much longer than high has one row of tiles, and not more of them for that.
    odd(across.min(DVec2::splat(count)).as_uvec2())
}

/// These numbers or the next odd ones below, but at least 1.
fn odd(count: UVec2) -> UVec2 {
    count.saturating_sub(UVec2::ONE) | UVec2::ONE
}
