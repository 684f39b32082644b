//! What can be switched while the scene runs, and its way into the scene.

use bevy::{
    camera::Hdr,
    light::ShadowFilteringMethod,
    post_process::bloom::Bloom,
    prelude::*,
    render::{render_resource::TextureFormat, renderer::RenderAdapter},
};
use bevy_planar_mirror::prelude::*;

use crate::{
    bezier,
    scene::{Table, Teapot},
};

#[derive(Resource, Clone, PartialEq)]
pub struct Settings {
    pub mirror: bool,
    /// Whether the reflection is cut at the table; off shows what the oblique near plane is for.
    pub clip: bool,
    /// How much of the table's own color shows over its reflection.
    pub alpha: f32,
    /// Quads along the side of each of the teapot's patches.
    pub tessellation: u32,
    pub soft_shadows: bool,
    pub samples: u32,
    pub hdr: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            mirror: true,
            clip: true,
            alpha: 0.5,
            tessellation: 16,
            soft_shadows: true,
            samples: 4,
            hdr: true,
        }
    }
}

pub fn plugin(app: &mut App) {
    app.init_resource::<Settings>()
        .add_systems(PostStartup, (set_table, set_teapot, set_camera));
    app.add_systems(
        Update,
        (set_table, set_teapot, set_camera).run_if(resource_changed::<Settings>),
    );
}

fn set_table(
    mut commands: Commands,
    settings: Res<Settings>,
    table: Single<(Entity, &MeshMaterial3d<StandardMaterial>), With<Table>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let (table, material) = *table;
    if let Some(mut material) = materials.get_mut(material) {
        material.base_color.set_alpha(settings.alpha);
    }
    if settings.mirror {
        commands.entity(table).insert(PlanarMirror {
            clip: if settings.clip {
                MirrorClip::Auto
            } else {
                MirrorClip::Whole
            },
            ..default()
        });
    } else {
        commands.entity(table).remove::<PlanarMirror>();
    }
}

fn set_teapot(
    settings: Res<Settings>,
    teapot: Single<&Mesh3d, With<Teapot>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut shown: Local<u32>,
) {
    if *shown == settings.tessellation {
        return;
    }
    if let Some(mut mesh) = meshes.get_mut(&teapot.0) {
        *mesh = bezier::tessellate(&bezier::teapot_patches(), settings.tessellation);
        *shown = settings.tessellation;
    }
}

fn set_camera(
    mut commands: Commands,
    settings: Res<Settings>,
    camera: Single<Entity, With<Camera3d>>,
) {
    let mut camera = commands.entity(*camera);
    camera.insert((
        Msaa::from_samples(settings.samples),
        if settings.soft_shadows {
            ShadowFilteringMethod::Gaussian
        } else {
            ShadowFilteringMethod::Hardware2x2
        },
    ));
    if settings.hdr {
        camera.insert((Hdr, Bloom::NATURAL));
    } else {
        camera.remove::<(Hdr, Bloom)>();
    }
}

/// The numbers of samples that the adapter can draw with, of 1, 2, 4 and 8.
pub fn supported_samples(adapter: &RenderAdapter) -> Vec<u32> {
    let formats = [
        TextureFormat::Rgba8UnormSrgb,
        TextureFormat::Rgba16Float,
        TextureFormat::Depth32Float,
        TextureFormat::Depth32FloatStencil8,
    ];
    let supported = |samples: &u32| {
        formats.iter().all(|&format| {
            let features = adapter.get_texture_format_features(format);
            features.flags.sample_count_supported(*samples)
        })
    };
    [1, 2, 4, 8].into_iter().filter(supported).collect()
}
