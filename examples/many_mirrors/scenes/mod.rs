//! What is shown. Where everything is, is a function of the time and of nothing else.

mod hall;
mod split;
mod tiles;

use bevy::{camera::ShadowLodOrigin, light::NotShadowCaster, prelude::*};

/// Which scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    Hall,
    Tiles,
    Split,
}

impl Place {
    pub const ALL: [Self; 3] = [Self::Hall, Self::Tiles, Self::Split];

    pub fn name(self) -> &'static str {
        match self {
            Self::Hall => "hall",
            Self::Tiles => "tiles",
            Self::Split => "split",
        }
    }

    pub fn about(self) -> &'static str {
        match self {
            Self::Hall => "hall: two walls of mirrors that face each other",
            Self::Tiles => "tiles: a floor of fifty mirrors in one plane",
            Self::Split => "split: two cameras, several mirrors",
        }
    }

    pub fn key(self) -> KeyCode {
        match self {
            Self::Hall => KeyCode::Digit1,
            Self::Tiles => KeyCode::Digit2,
            Self::Split => KeyCode::Digit3,
        }
    }
}

/// The scene that is shown.
#[derive(Resource, PartialEq)]
pub struct Shown(pub Place);

/// The seconds that it has run.
#[derive(Resource)]
pub struct SceneTime(pub f32);

/// The camera that flies.
#[derive(Component, Default)]
#[require(Camera3d, ShadowLodOrigin, InScene)]
pub struct MainCamera;

/// Goes with its scene.
#[derive(Component, Default)]
struct InScene;

/// Turns around its own axis, in radians a second.
#[derive(Component)]
struct Turning(f32);

pub fn plugin(app: &mut App) {
    app.insert_resource(ClearColor(Color::srgb(0.55, 0.65, 0.75)))
        .insert_resource(GlobalAmbientLight {
            brightness: 60.0,
            ..default()
        })
        .add_systems(
            PreUpdate,
            (
                clear,
                (
                    hall::set_up.run_if(shows(Place::Hall)),
                    tiles::set_up.run_if(shows(Place::Tiles)),
                    split::set_up.run_if(shows(Place::Split)),
                ),
            )
                .chain()
                .run_if(resource_changed::<Shown>),
        )
        .add_systems(Update, (turn, split::fit_viewports));
}

fn shows(place: Place) -> impl Fn(Res<Shown>) -> bool + Clone {
    move |shown| shown.0 == place
}

fn clear(mut commands: Commands, scene: Query<Entity, With<InScene>>) {
    for entity in &scene {
        commands.entity(entity).despawn();
    }
}

fn turn(time: Res<SceneTime>, mut turning: Query<(&Turning, &mut Transform)>) {
    for (Turning(speed), mut transform) in &mut turning {
        transform.rotation = Quat::from_rotation_y(speed * time.0);
    }
}

/// Meshes, materials and entities of a scene in one hand.
#[derive(bevy::ecs::system::SystemParam)]
struct Builder<'w, 's> {
    commands: Commands<'w, 's>,
    meshes: ResMut<'w, Assets<Mesh>>,
    materials: ResMut<'w, Assets<StandardMaterial>>,
}

impl Builder<'_, '_> {
    /// Something of a rough material.
    fn thing(
        &mut self,
        mesh: impl Into<Mesh>,
        color: Color,
        transform: Transform,
    ) -> EntityCommands<'_> {
        let mesh = Mesh3d(self.meshes.add(mesh));
        let material = MeshMaterial3d(self.materials.add(StandardMaterial {
            base_color: color,
            perceptual_roughness: 0.6,
            ..default()
        }));
        self.commands.spawn((InScene, mesh, material, transform))
    }

    /// A lamp, and a bulb that one sees.
    fn lamp(&mut self, color: Color, place: Vec3) {
        let bulb = self.meshes.add(Sphere::new(0.07));
        let glow = self.materials.add(StandardMaterial {
            base_color: Color::BLACK,
            emissive: color.to_linear() * 40.0,
            ..default()
        });
        self.commands.spawn((
            InScene,
            PointLight {
                color,
                intensity: 250_000.0,
                ..default()
            },
            Transform::from_translation(place),
            // The light is inside it.
            children![(Mesh3d(bulb), MeshMaterial3d(glow), NotShadowCaster)],
        ));
    }

    /// Something that turns on a pedestal, of which there are several kinds.
    fn exhibit(&mut self, kind: usize, place: Vec3) {
        let white = Color::srgb(0.8, 0.78, 0.74);
        let pedestal = Cuboid::new(0.4, 0.7, 0.4);
        let foot = Transform::from_translation(place + Vec3::Y * 0.35);
        self.thing(pedestal, white, foot);
        let hue = 47.0 * kind as f32 % 360.0;
        let shape: Mesh = match kind % 4 {
            0 => Torus::new(0.08, 0.24)
                .mesh()
                .build()
                .rotated_by(Quat::from_rotation_x(1.2)),
            1 => Cuboid::from_length(0.34)
                .mesh()
                .build()
                .rotated_by(Quat::from_rotation_x(0.6)),
            2 => Cone::new(0.22, 0.5).into(),
            _ => Capsule3d::new(0.12, 0.3)
                .mesh()
                .build()
                .rotated_by(Quat::from_rotation_z(0.9)),
        };
        let above = Transform::from_translation(place + Vec3::Y * 1.1);
        self.thing(shape, Color::hsl(hue, 0.7, 0.5), above)
            .insert(Turning(0.5 + 0.1 * kind as f32));
    }
}
