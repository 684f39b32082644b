//! What is added to each of Bevy's examples: a fixed size, time by fixed steps, a picture after a
//! fixed number of frames, and the plugin.
//!
//! An example that ends with `use hosts::DefaultPlugins;` takes these in place of the prelude's.

use std::{cell::RefCell, collections::BTreeMap, env, fs, path::PathBuf, time::Duration};

use bevy::{
    app::PluginGroupBuilder,
    camera::{RenderTarget, primitives::Aabb, visibility::RenderLayers},
    prelude::*,
    render::{
        RenderPlugin,
        view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk},
    },
    time::TimeUpdateStrategy,
    transform::TransformSystems,
    window::{PresentMode, PrimaryWindow, WindowRef, WindowResized, WindowResolution},
    winit::WinitSettings,
};
use bevy_planar_mirror::prelude::*;
use chacha20::ChaCha8Rng;
use rand::{
    RngExt, SeedableRng,
    distr::{Distribution, StandardUniform},
};

const SIZE: UVec2 = UVec2::new(320, 240);
/// Frames until the mirrors come, so that they come into a scene that is there.
const MIRRORS_AT: u32 = 10;
/// Frames after which a picture that has not come never will.
const PATIENCE: u32 = 200;

/// Bevy's, and the [`Host`] after them.
pub struct DefaultPlugins;

impl PluginGroup for DefaultPlugins {
    fn build(self) -> PluginGroupBuilder {
        bevy::DefaultPlugins
            .build()
            // The same frame shows the same things in every run.
            .set(RenderPlugin {
                synchronous_pipeline_compilation: true,
                ..default()
            })
            .add(Host)
    }
}

/// Reads what to do from the environment: `HOSTS_MODE`, `HOSTS_FRAMES`, `HOSTS_PICTURE` and
/// `HOSTS_STATUS`.
struct Host;

impl Plugin for Host {
    fn build(&self, app: &mut App) {
        let mode = env::var("HOSTS_MODE").expect("HOSTS_MODE: stock, plugin or mirror");
        let picture_at = env::var("HOSTS_FRAMES").expect("HOSTS_FRAMES: a number");
        app.insert_resource(Frame {
            number: 0,
            picture_at: picture_at.parse().expect("HOSTS_FRAMES: a number"),
            saved: None,
        })
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(
            1.0 / 60.0,
        )))
        .add_systems(First, (count_frames, tell_size).chain())
        .add_systems(Last, (take_picture, leave));
        if mode != "stock" {
            app.add_plugins(PlanarMirrorPlugin::default());
        }
        if mode == "mirror" {
            app.init_resource::<Seen>()
                .add_systems(Update, spawn_mirrors)
                .add_systems(
                    PostUpdate,
                    follow_camera.before(TransformSystems::Propagate),
                )
                .add_systems(Last, (look_at_status, write_status).chain());
        }
        // It is there already, and is not opened yet.
        let mut windows = app
            .world_mut()
            .query_filtered::<&mut Window, With<PrimaryWindow>>();
        for mut window in windows.iter_mut(app.world_mut()) {
            window.resolution =
                WindowResolution::new(SIZE.x, SIZE.y).with_scale_factor_override(1.0);
            window.present_mode = PresentMode::AutoNoVsync;
        }
    }

    fn finish(&self, app: &mut App) {
        // Not in `build`: many examples set it, to sleep between events.
        app.insert_resource(WinitSettings::continuous());
    }
}

/// In place of `rand::rng`: the same in every run.
pub fn rng() -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(1)
}

/// In place of `rand::random`.
pub fn random<T>() -> T
where
    StandardUniform: Distribution<T>,
{
    thread_local!(static RNG: RefCell<ChaCha8Rng> = RefCell::new(rng()));
    RNG.with_borrow_mut(|rng| rng.random())
}

#[derive(Resource)]
struct Frame {
    number: u32,
    picture_at: u32,
    /// Frames since the picture was saved.
    saved: Option<u32>,
}

fn count_frames(mut frame: ResMut<Frame>) {
    frame.number += 1;
    frame.saved = frame.saved.map(|frames| frames + 1);
}

/// As a window manager does, which Xvfb has not.
fn tell_size(
    frame: Res<Frame>,
    windows: Query<Entity, With<PrimaryWindow>>,
    mut resized: MessageWriter<WindowResized>,
) {
    if frame.number == 3 {
        for window in &windows {
            resized.write(WindowResized {
                window,
                width: SIZE.x as f32,
                height: SIZE.y as f32,
            });
        }
    }
}

fn take_picture(mut commands: Commands, frame: Res<Frame>) {
    if frame.number == frame.picture_at {
        commands
            .spawn(Screenshot::primary_window())
            .observe(save_to_disk(path("HOSTS_PICTURE")))
            .observe(|_: On<ScreenshotCaptured>, mut frame: ResMut<Frame>| {
                frame.saved = Some(0);
            });
    }
}

fn leave(frame: Res<Frame>, mut exit: MessageWriter<AppExit>) {
    // Errors of the last frames are reported a frame or two later.
    if frame.saved.is_some_and(|frames| frames > 3) {
        exit.write(AppExit::Success);
    } else if frame.number > frame.picture_at + PATIENCE {
        exit.write(AppExit::from_code(3));
    }
}

fn path(variable: &str) -> PathBuf {
    PathBuf::from(env::var_os(variable).unwrap_or_else(|| panic!("{variable}: a path")))
}

/// On a mirror: where it stands before its camera.
#[derive(Component, Clone, Copy)]
struct Stand {
    camera: Entity,
    /// How far from the camera the middle of the scene is.
    distance: f32,
    /// 1.0 to the right of it, -1.0 to the left.
    side: f32,
}

/// A perfect mirror at the right of the picture, and one under tinted glass at the left. Each is
/// turned so that the middle of the scene is seen in its middle.
fn spawn_mirrors(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    frame: Res<Frame>,
    cameras: Query<
        (
            Entity,
            &Camera,
            &RenderTarget,
            &GlobalTransform,
            Option<&RenderLayers>,
        ),
        With<Camera3d>,
    >,
    things: Query<(&GlobalTransform, Option<&Aabb>), With<Mesh3d>>,
    windows: Query<Entity, With<PrimaryWindow>>,
    mut done: Local<bool>,
) {
    if *done || frame.number < MIRRORS_AT {
        return;
    }
    let into_window = |target: &RenderTarget| match target {
        RenderTarget::Window(WindowRef::Primary) => true,
        RenderTarget::Window(WindowRef::Entity(window)) => windows.contains(*window),
        _ => false,
    };
    let Some((entity, camera, _, transform, layers)) = cameras
        .iter()
        .filter(|(_, camera, target, ..)| camera.is_active && into_window(target))
        .min_by_key(|(entity, camera, ..)| (camera.order, *entity))
    else {
        return;
    };
    *done = true;
    let distance = distance_to_middle(transform, &things);
    let half = half_extents(camera, 0.8 * distance);
    let mesh = meshes.add(Rectangle::new(0.9 * half.x, 1.1 * half.y));
    for (name, side) in [("bare", 1.0), ("glass", -1.0)] {
        let mut mirror = commands.spawn((
            Name::new(name),
            Mesh3d(mesh.clone()),
            PlanarMirror::default(),
            Stand {
                camera: entity,
                distance,
                side,
            },
        ));
        if let Some(layers) = layers {
            mirror.insert(layers.clone());
        }
        if name == "glass" {
            mirror.insert(MeshMaterial3d(materials.add(StandardMaterial {
                base_color: Color::srgba(0.2, 0.5, 0.9, 0.3),
                alpha_mode: AlphaMode::Blend,
                ..default()
            })));
        }
    }
}

/// The median depth of the meshes before the camera.
fn distance_to_middle(
    camera: &GlobalTransform,
    things: &Query<(&GlobalTransform, Option<&Aabb>), With<Mesh3d>>,
) -> f32 {
    let mut depths: Vec<f32> = things
        .iter()
        .map(|(transform, aabb)| {
            let center = aabb.map_or(Vec3A::ZERO, |aabb| aabb.center);
            let center = transform.affine().transform_point3a(center);
            (Vec3::from(center) - camera.translation()).dot(*camera.forward())
        })
        .filter(|depth| *depth > 0.2 && depth.is_finite())
        .collect();
    depths.sort_by(f32::total_cmp);
    depths.get(depths.len() / 2).copied().unwrap_or(3.0)
}

/// Half of what the camera shows at this distance.
fn half_extents(camera: &Camera, distance: f32) -> Vec2 {
    let projection = camera.clip_from_view();
    let half = Vec2::new(projection.x_axis.x, projection.y_axis.y).recip();
    if is_perspective(camera) {
        half * distance
    } else {
        half
    }
}

fn is_perspective(camera: &Camera) -> bool {
    camera.clip_from_view().w_axis.w == 0.0
}

fn follow_camera(
    cameras: Query<(&Camera, &GlobalTransform), With<Camera3d>>,
    mut mirrors: Query<(&Stand, &mut Transform)>,
) {
    for (stand, mut transform) in &mut mirrors {
        let Ok((camera, from)) = cameras.get(stand.camera) else {
            continue;
        };
        let (_, rotation, eye) = from.to_scale_rotation_translation();
        let forward = rotation * Vec3::NEG_Z;
        let distance = 0.8 * stand.distance;
        let aside = 0.45 * stand.side * half_extents(camera, distance).x;
        let place = eye + distance * forward + aside * (rotation * Vec3::X);
        let arriving = if is_perspective(camera) {
            (place - eye).normalize_or(forward)
        } else {
            forward
        };
        let leaving = (eye + stand.distance * forward - place).normalize_or(forward);
        let normal = (leaving - arriving).normalize_or(-forward);
        let placed = Transform::from_translation(place).looking_to(-normal, rotation * Vec3::Y);
        transform.set_if_neq(placed);
    }
}

/// How many frames each mirror was in each state, summed over the cameras.
#[derive(Resource, Default)]
struct Seen(BTreeMap<String, BTreeMap<String, u32>>);

fn look_at_status(
    mirrors: Query<(&Name, &MirrorStatus), With<Stand>>,
    frame: Res<Frame>,
    mut seen: ResMut<Seen>,
) {
    if frame.saved.is_some() {
        return;
    }
    for (name, status) in &mirrors {
        let states = seen.0.entry(name.to_string()).or_default();
        for camera in &status.cameras {
            *states.entry(camera.state.to_string()).or_default() += 1;
        }
    }
}

/// One line for each mirror, its most frequent state first.
fn write_status(seen: Res<Seen>) {
    if !seen.is_changed() {
        return;
    }
    let mut text = String::new();
    for (name, states) in &seen.0 {
        let mut states: Vec<_> = states.iter().collect();
        states.sort_by_key(|(_, frames)| u32::MAX - **frames);
        let states: Vec<_> = states
            .iter()
            .map(|(state, frames)| format!("{state} ({frames})"))
            .collect();
        text += &format!("{name}: {}\n", states.join("; "));
    }
    if text.is_empty() {
        text += "no 3D camera that draws into the window\n";
    }
    if let Err(error) = fs::write(path("HOSTS_STATUS"), text) {
        error!("the status cannot be written: {error}");
    }
}
