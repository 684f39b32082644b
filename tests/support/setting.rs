//! What must change no picture of any scene. `PLANAR_MIRROR_SETTING=unseen cargo test --test pictures` draws all of
//! them so. Of the tests, those then fail that count views or look for the one camera or status; with `unseen` those of
//! facing mirrors, with `oblique` an orthographic camera by daylight, with `direct` that of a lamp's shadows, with `own`
//! that of shared shadow maps.

use bevy::{camera::RenderTarget, prelude::*, render::view::NoIndirectDrawing};
use bevy_planar_mirror::{MirrorClip, MirrorShadows, PlanarMirror};

use super::scene::Scene;

#[derive(Clone, Copy, PartialEq)]
pub enum Setting {
    /// As it is.
    Usual,
    /// Drawn one by one, in every app: the engine loses a lamp's shadows where no camera draws indirectly.
    Direct,
    /// Cut where nothing crosses the mirror.
    Oblique,
    /// With shadow maps of each mirror's own.
    Own,
    /// Sixty mirrors behind the eye, or with their backs to it.
    Unseen,
    /// A second camera sees the same.
    Watched,
}

impl Setting {
    pub fn of_this_run() -> Self {
        match std::env::var("PLANAR_MIRROR_SETTING").as_deref() {
            Err(_) | Ok("") => Self::Usual,
            Ok("direct") => Self::Direct,
            Ok("oblique") => Self::Oblique,
            Ok("own") => Self::Own,
            Ok("unseen") => Self::Unseen,
            Ok("watched") => Self::Watched,
            Ok(other) => panic!(
                "PLANAR_MIRROR_SETTING is direct, oblique, own, unseen, watched or not set, not {other:?}"
            ),
        }
    }

    /// For a mirror of a scene.
    pub fn mirror(self, mirror: &PlanarMirror) -> PlanarMirror {
        let mut mirror = mirror.clone();
        if self == Self::Oblique && mirror.clip == MirrorClip::Auto {
            mirror.clip = MirrorClip::Oblique;
        }
        if self == Self::Own && mirror.shadows == MirrorShadows::Auto {
            mirror.shadows = MirrorShadows::Own;
        }
        mirror
    }

    /// For the camera of any drawing.
    pub fn camera(self, world: &mut World, camera: Entity) {
        if self == Self::Direct {
            world.entity_mut(camera).insert(NoIndirectDrawing);
        }
    }

    /// For a scene with its mirrors, whose camera has that target.
    pub fn scene(self, world: &mut World, scene: &Scene, target: &Handle<Image>) {
        match self {
            Self::Usual | Self::Direct | Self::Oblique | Self::Own => {}
            Self::Unseen => {
                let mesh = world
                    .resource_mut::<Assets<Mesh>>()
                    .add(Rectangle::from_length(0.5));
                for index in 0..60 {
                    let turn = Quat::from_rotation_y(std::f32::consts::PI + 0.01 * index as f32);
                    let distance = if index % 2 == 0 { -1.0 } else { 1.0 };
                    let place = Transform::from_xyz(0.0, 0.0, distance).with_rotation(turn);
                    let upright = scene.eye.with_scale(Vec3::ONE);
                    // Without a material: what is seen of them is nothing.
                    world.spawn((
                        Mesh3d(mesh.clone()),
                        upright * place,
                        PlanarMirror::default(),
                    ));
                }
            }
            Self::Watched => {
                let mut images = world.resource_mut::<Assets<Image>>();
                let Some(image) = images.get(target).cloned() else {
                    return;
                };
                let target = RenderTarget::from(images.add(image));
                let mut second = world.spawn((scene.camera_bundle(), target, scene.eye));
                super::set::equip(&mut second, scene, true);
            }
        }
    }
}
