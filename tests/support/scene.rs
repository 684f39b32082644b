//! A scene as data: written once in a test, then drawn with mirrors, without them, as a mask and as a reference.

use std::sync::Arc;

use bevy::{
    camera::{ClearColorConfig, Hdr},
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    math::{DAffine3, DMat3, DQuat, DVec3},
    prelude::*,
};
use bevy_planar_mirror::PlanarMirror;

use super::cut::Plane;

/// Something done to an entity when the scene is built.
pub type Touch = Arc<dyn Fn(&mut EntityWorldMut) + Send + Sync>;

/// What a test sees: one camera, mirrors, objects, lights.
#[derive(Clone)]
pub struct Scene {
    /// For the files of a failure.
    pub name: String,
    pub size: UVec2,
    pub eye: Transform,
    pub projection: Projection,
    pub msaa: Msaa,
    pub mirrors: Vec<Surface>,
    pub objects: Vec<Object>,
    /// Everything that is the same in all drawings: lights above all.
    pub props: Vec<Touch>,
    /// What the camera carries besides.
    pub camera: Vec<Touch>,
    /// Done to the camera of masks too: viewports and whatever else decides where things are seen.
    pub lens: Vec<Touch>,
    pub clear_color: Color,
    pub ambient: GlobalAmbientLight,
    /// Plugins that the scene needs, for materials of its own.
    pub plugins: Vec<fn(&mut App)>,
}

/// A flat mesh that is a mirror.
#[derive(Clone)]
pub struct Surface {
    pub mesh: Mesh,
    /// A point of the plane and two directions in it, in the mesh's own space; their cross product
    /// points to the front.
    pub frame: [DVec3; 3],
    pub transform: Transform,
    pub look: Option<Look>,
    pub mirror: PlanarMirror,
}

#[derive(Clone)]
pub struct Object {
    pub mesh: Mesh,
    pub transform: Transform,
    pub look: Look,
}

/// A material.
#[derive(Clone)]
pub enum Look {
    Standard(Box<StandardMaterial>),
    Other(Touch),
}

impl Scene {
    /// A camera at (0, 1, 4) that looks slightly down to the origin; nothing else yet.
    ///
    /// Colors come out as they went in: no tone mapping, no dither, no ambient light.
    pub fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            size: UVec2::new(160, 120),
            eye: Transform::from_xyz(0.0, 1.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
            projection: Projection::Perspective(PerspectiveProjection::default()),
            msaa: Msaa::Off,
            mirrors: Vec::new(),
            objects: Vec::new(),
            props: Vec::new(),
            camera: Vec::new(),
            lens: Vec::new(),
            clear_color: Color::srgb_u8(10, 20, 30),
            ambient: GlobalAmbientLight {
                brightness: 0.0,
                ..default()
            },
            plugins: Vec::new(),
        }
    }

    pub fn eye(mut self, at: Vec3, look_at: Vec3) -> Self {
        self.eye = Transform::from_translation(at).looking_at(look_at, Vec3::Y);
        self
    }

    pub fn fov(mut self, degrees: f32) -> Self {
        let fov = degrees.to_radians();
        self.projection = PerspectiveProjection { fov, ..default() }.into();
        self
    }

    pub fn mirror(mut self, surface: Surface) -> Self {
        self.mirrors.push(surface);
        self
    }

    pub fn object(
        mut self,
        mesh: impl Into<Mesh>,
        look: impl Into<Look>,
        transform: Transform,
    ) -> Self {
        self.objects.push(Object {
            mesh: mesh.into(),
            transform,
            look: look.into(),
        });
        self
    }

    /// An entity that is the same in all drawings.
    pub fn prop(mut self, bundle: impl Bundle + Clone) -> Self {
        self.props.push(Arc::new(move |entity| {
            entity.insert(bundle.clone());
        }));
        self
    }

    /// A component for the camera.
    pub fn with_camera(mut self, bundle: impl Bundle + Clone) -> Self {
        self.camera.push(Arc::new(move |entity| {
            entity.insert(bundle.clone());
        }));
        self
    }

    /// Anything done to the camera.
    pub fn touch_camera(
        mut self,
        touch: impl Fn(&mut EntityWorldMut) + Send + Sync + 'static,
    ) -> Self {
        self.camera.push(Arc::new(touch));
        self
    }

    /// Anything done to the camera that moves what it sees on the screen.
    pub fn lens(mut self, touch: impl Fn(&mut EntityWorldMut) + Send + Sync + 'static) -> Self {
        self.lens.push(Arc::new(touch));
        self
    }

    pub fn plugin(mut self, add: fn(&mut App)) -> Self {
        self.plugins.push(add);
        self
    }

    pub fn hdr(self) -> Self {
        self.with_camera((Hdr, Tonemapping::TonyMcMapface))
    }

    /// The camera as every drawing has it, less where it stands.
    pub fn camera_bundle(&self) -> impl Bundle + use<> {
        (
            Camera3d::default(),
            Camera {
                clear_color: ClearColorConfig::Default,
                ..default()
            },
            Tonemapping::None,
            DebandDither::Disabled,
            self.msaa,
            self.projection.clone(),
        )
    }
}

impl Surface {
    /// Upright: its front is towards +Z.
    pub fn wall(width: f32, height: f32, transform: Transform) -> Self {
        Self {
            mesh: Rectangle::new(width, height).into(),
            frame: [DVec3::ZERO, DVec3::X, DVec3::Y],
            transform,
            look: None,
            mirror: PlanarMirror::default(),
        }
    }

    /// Lying: its front is up.
    pub fn floor(width: f32, depth: f32, transform: Transform) -> Self {
        Self {
            mesh: Plane3d::new(Vec3::Y, Vec2::new(width, depth) / 2.0).into(),
            frame: [DVec3::ZERO, DVec3::Z, DVec3::X],
            ..Self::wall(1.0, 1.0, transform)
        }
    }

    pub fn look(mut self, look: impl Into<Look>) -> Self {
        self.look = Some(look.into());
        self
    }

    /// Whether the transform turns the mesh inside out.
    pub fn is_mirrored(&self) -> bool {
        exact(&self.transform).matrix3.determinant() < 0.0
    }

    /// The plane in the world. Its front is where the transform takes the mesh's, also where that turns it inside out.
    pub fn plane(&self) -> Plane {
        let world_from_local = exact(&self.transform);
        let [point, a, b] = self.frame;
        let a = world_from_local.transform_vector3(a);
        let b = world_from_local.transform_vector3(b);
        let front = if self.is_mirrored() {
            b.cross(a)
        } else {
            a.cross(b)
        };
        Plane::through(world_from_local.transform_point3(point), front)
    }
}

/// A transform in f64, from the very numbers the app gets.
pub fn exact(transform: &Transform) -> DAffine3 {
    let scale = transform.scale.as_dvec3();
    let rotation = DMat3::from_quat(
        DQuat::from_array(transform.rotation.to_array().map(f64::from)).normalize(),
    );
    DAffine3 {
        matrix3: rotation * DMat3::from_diagonal(scale),
        translation: transform.translation.as_dvec3(),
    }
}

impl From<StandardMaterial> for Look {
    fn from(material: StandardMaterial) -> Self {
        Self::Standard(Box::new(material))
    }
}

impl From<Color> for Look {
    /// Unlit: the color on the screen is this one.
    fn from(color: Color) -> Self {
        StandardMaterial {
            base_color: color,
            unlit: true,
            ..default()
        }
        .into()
    }
}

impl Look {
    pub fn other(touch: impl Fn(&mut EntityWorldMut) + Send + Sync + 'static) -> Self {
        Self::Other(Arc::new(touch))
    }

    pub fn apply(&self, entity: &mut EntityWorldMut) {
        match self {
            Self::Standard(material) => {
                let material = (**material).clone();
                let handle = entity.world_scope(|world| {
                    world
                        .resource_mut::<Assets<StandardMaterial>>()
                        .add(material)
                });
                entity.insert(MeshMaterial3d(handle));
            }
            Self::Other(touch) => touch(entity),
        }
    }
}
