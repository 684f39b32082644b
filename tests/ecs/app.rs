//! An app without a renderer, in which Bevy's own systems place cameras and find out what they see.

use std::{
    ops::{Deref, DerefMut},
    sync::{PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard},
};

use bevy::{
    asset::{AssetEventSystems, RenderAssetUsages},
    camera::{
        CameraPlugin, CameraUpdateSystems, Exposure, RenderTarget,
        visibility::{VisibilitySystems, VisibleEntities},
    },
    ecs::{entity_disabling::Disabled, query::Allow},
    gizmos::GizmoPlugin,
    light::LightPlugin,
    mesh::MeshPlugin,
    prelude::*,
    render::{
        RenderApp,
        camera::camera_system,
        render_resource::{Extent3d, TextureDimension, TextureFormat},
        sync_world::SyncToRenderWorld,
        texture::ManualTextureViews,
        view::{ColorGrading, Msaa},
    },
    window::ExitCondition,
};
use bevy_planar_mirror::{
    MirrorState, MirrorStatus, NotDrawn, PlanarMirror, PlanarMirrorPlugin,
    status::Projection as Drawn,
};

use crate::log::{self, Line};

pub const PLAIN: Option<MirrorState> = Some(MirrorState::Drawn(Drawn::Plain));
pub const OBLIQUE: Option<MirrorState> = Some(MirrorState::Drawn(Drawn::Oblique));

pub const fn not(reason: NotDrawn) -> Option<MirrorState> {
    Some(MirrorState::NotDrawn(reason))
}

/// The picture of every camera here.
pub const SIZE: UVec2 = UVec2::new(200, 100);

/// Where the camera of most tests stands: five units before the origin, looking at it.
pub const EYE: Transform = Transform::from_xyz(0.0, 0.0, 5.0);

/// A mirror that lies on the ground and is seen from above.
pub fn floor(y: f32) -> Transform {
    Transform::from_xyz(0.0, y, 0.0).with_rotation(upwards())
}

/// Turns what faces +Z, as a `Rectangle` does, to face +Y.
pub fn upwards() -> Quat {
    Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2)
}

/// Above a floor at y = 0 and looking down on it at a slant.
pub fn above() -> Transform {
    Transform::from_xyz(0.0, 2.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y)
}

/// Bevy without the mirrors: as much of it as brings a camera and a mesh to life.
pub fn stock_app() -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        TransformPlugin,
        AssetPlugin::default(),
        WindowPlugin {
            primary_window: None,
            exit_condition: ExitCondition::DontExit,
            ..default()
        },
        MeshPlugin,
        CameraPlugin,
        LightPlugin,
        // The light plugin draws lights with it.
        GizmoPlugin,
    ))
    .init_asset::<Image>()
    .init_resource::<ManualTextureViews>()
    // What the renderer's plugins add to a camera in the main world.
    .register_required_components::<Camera, Msaa>()
    .register_required_components::<Camera, SyncToRenderWorld>()
    .register_required_components::<Camera3d, ColorGrading>()
    .register_required_components::<Camera3d, Exposure>()
    .add_systems(
        PostUpdate,
        camera_system
            .in_set(CameraUpdateSystems)
            .before(AssetEventSystems)
            .before(VisibilitySystems::UpdateFrusta),
    );
    app
}

/// Stands in for the renderer: extraction takes place, and tells what it saw. Nothing is drawn.
pub fn stand_in_renderer() -> SubApp {
    let mut renderer = SubApp::new();
    renderer.init_resource::<Extracted>();
    renderer.set_extract(|main_world, render_world| {
        let cameras = main_world
            .query_filtered::<Entity, With<Camera>>()
            .iter(main_world)
            .collect();
        render_world.insert_resource(Extracted(cameras));
    });
    renderer
}

/// The cameras that a renderer would have drawn in the last frame.
#[derive(Resource, Default)]
pub struct Extracted(pub Vec<Entity>);

/// Bevy with the mirrors. What the plugin logs belongs to the process, so a test that reads it is alone.
pub struct MirrorApp {
    app: App,
    turn: Turn,
}

enum Turn {
    Shared(#[expect(dead_code, reason = "held, never read")] RwLockReadGuard<'static, ()>),
    Alone(#[expect(dead_code, reason = "held, never read")] RwLockWriteGuard<'static, ()>),
}

static TURN: RwLock<()> = RwLock::new(());

/// Bevy with the mirrors.
pub fn mirror_app() -> MirrorApp {
    mirror_app_with(|_| {})
}

/// Bevy with the mirrors, and what the test adds before the app is finished.
pub fn mirror_app_with(add: impl FnOnce(&mut App)) -> MirrorApp {
    MirrorApp::new(shared(), PlanarMirrorPlugin::default(), |app| {
        add(app);
        app.insert_sub_app(RenderApp, stand_in_renderer());
    })
}

/// Bevy with the mirrors, under other settings than the default.
pub fn mirror_app_of(plugin: PlanarMirrorPlugin) -> MirrorApp {
    MirrorApp::new(shared(), plugin, |app| {
        app.insert_sub_app(RenderApp, stand_in_renderer());
    })
}

/// Bevy with the mirrors, and nobody else who writes into the log.
pub fn logged_mirror_app() -> MirrorApp {
    MirrorApp::new(alone(), PlanarMirrorPlugin::default(), |app| {
        app.insert_sub_app(RenderApp, stand_in_renderer());
    })
}

/// The same on a machine that draws nothing.
pub fn logged_mirror_app_without_renderer() -> MirrorApp {
    MirrorApp::new(alone(), PlanarMirrorPlugin::default(), |_| {})
}

fn shared() -> Turn {
    Turn::Shared(TURN.read().unwrap_or_else(PoisonError::into_inner))
}

fn alone() -> Turn {
    let turn = TURN.write().unwrap_or_else(PoisonError::into_inner);
    log::install();
    log::take();
    Turn::Alone(turn)
}

impl Deref for MirrorApp {
    type Target = App;

    fn deref(&self) -> &App {
        &self.app
    }
}

impl DerefMut for MirrorApp {
    fn deref_mut(&mut self) -> &mut App {
        &mut self.app
    }
}

impl MirrorApp {
    fn new(turn: Turn, plugin: PlanarMirrorPlugin, add: impl FnOnce(&mut App)) -> Self {
        let mut app = stock_app();
        app.add_plugins(plugin);
        add(&mut app);
        app.finish();
        app.cleanup();
        Self { app, turn }
    }

    /// Some frames with nothing new in them.
    pub fn updates(&mut self, count: usize) {
        for _ in 0..count {
            self.update();
        }
    }

    /// What the plugin logged since the last call. Of a [`logged_mirror_app`] only.
    pub fn log_lines(&mut self) -> Vec<Line> {
        assert!(matches!(self.turn, Turn::Alone(_)), "others log too");
        let mut lines = log::take();
        lines.retain(|line| line.target.starts_with("bevy_planar_mirror"));
        lines
    }

    /// The state of `mirror` as seen by `camera`.
    pub fn state_of(&self, mirror: Entity, camera: Entity) -> Option<MirrorState> {
        self.world().get::<MirrorStatus>(mirror)?.of(camera)
    }

    #[track_caller]
    pub fn assert_state(&self, mirror: Entity, camera: Entity, expected: Option<MirrorState>) {
        assert_eq!(self.state_of(mirror, camera), expected);
    }

    /// The cameras that the last frame would have drawn, reflected views among them.
    pub fn extracted(&self) -> &[Entity] {
        &self.sub_app(RenderApp).world().resource::<Extracted>().0
    }

    /// Every reflected view there is.
    pub fn views(&mut self) -> Vec<Entity> {
        self.named_views("reflected view of ")
    }

    /// Those that belong to `camera`.
    pub fn views_of(&mut self, camera: Entity) -> Vec<Entity> {
        self.named_views(&format!("reflected view of {camera} in "))
    }

    /// The one that shows `mirror` to `camera`.
    #[track_caller]
    pub fn view(&mut self, camera: Entity, mirror: Entity) -> Entity {
        let name = format!("reflected view of {camera} in {mirror}");
        let found = self.named_views(&name);
        assert_eq!(found.len(), 1, "there is one {name}");
        found[0]
    }

    fn named_views(&mut self, prefix: &str) -> Vec<Entity> {
        let world = self.app.world_mut();
        world
            .query_filtered::<(Entity, &Name), (With<Camera3d>, Allow<Disabled>)>()
            .iter(world)
            .filter(|(_, name)| name.starts_with(prefix))
            .map(|(view, _)| view)
            .collect()
    }

    /// The meshes that a view or a camera shows.
    pub fn visible_to(&self, view: Entity) -> Vec<Entity> {
        let visible = self.world().get::<VisibleEntities>(view);
        visible
            .expect("it is a camera")
            .iter(std::any::TypeId::of::<Mesh3d>())
            .copied()
            .collect()
    }

    /// The component of an entity that has it.
    #[track_caller]
    pub fn of<T: Component>(&self, entity: Entity) -> &T {
        self.world().get::<T>(entity).expect("it has one")
    }

    /// The same, to write into.
    #[track_caller]
    pub fn of_mut<T: Component<Mutability = bevy::ecs::component::Mutable>>(
        &mut self,
        entity: Entity,
    ) -> Mut<'_, T> {
        self.app
            .world_mut()
            .get_mut::<T>(entity)
            .expect("it has one")
    }

    pub fn mesh(&mut self, mesh: impl Into<Mesh>) -> Handle<Mesh> {
        add_mesh(&mut self.app, mesh)
    }

    pub fn spawn(&mut self, bundle: impl Bundle) -> Entity {
        self.world_mut().spawn(bundle).id()
    }

    pub fn insert(&mut self, entity: Entity, bundle: impl Bundle) {
        self.world_mut().entity_mut(entity).insert(bundle);
    }

    pub fn remove<T: Bundle>(&mut self, entity: Entity) {
        self.world_mut().entity_mut(entity).remove::<T>();
    }

    pub fn despawn(&mut self, entity: Entity) {
        assert!(self.world_mut().despawn(entity));
    }

    /// A camera with a picture of its own.
    pub fn spawn_camera(&mut self, place: Transform) -> Entity {
        spawn_camera(&mut self.app, place)
    }

    /// A square mirror, two units wide, that faces its own +Z.
    pub fn spawn_mirror(&mut self, place: Transform) -> Entity {
        spawn_mirror(&mut self.app, place)
    }

    /// A cube of this width.
    pub fn spawn_cube(&mut self, width: f32, place: Vec3) -> Entity {
        spawn_cube(&mut self.app, width, place)
    }
}

/// An image that a camera can draw into.
pub fn target(app: &mut App, size: UVec2) -> RenderTarget {
    let image = Image::new_uninit(
        Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::default(),
    );
    let mut images = app.world_mut().resource_mut::<Assets<Image>>();
    RenderTarget::from(images.add(image))
}

pub fn add_mesh(app: &mut App, mesh: impl Into<Mesh>) -> Handle<Mesh> {
    app.world_mut()
        .resource_mut::<Assets<Mesh>>()
        .add(mesh.into())
}

pub fn spawn_camera(app: &mut App, place: Transform) -> Entity {
    let target = target(app, SIZE);
    app.world_mut()
        .spawn((Camera3d::default(), target, place))
        .id()
}

pub fn spawn_mirror(app: &mut App, place: Transform) -> Entity {
    let mesh = add_mesh(app, Rectangle::new(2.0, 2.0));
    app.world_mut()
        .spawn((Mesh3d(mesh), place, PlanarMirror::default()))
        .id()
}

pub fn spawn_cube(app: &mut App, width: f32, place: Vec3) -> Entity {
    let mesh = add_mesh(app, Cuboid::from_length(width));
    app.world_mut()
        .spawn((Mesh3d(mesh), Transform::from_translation(place)))
        .id()
}
