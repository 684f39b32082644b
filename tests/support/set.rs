//! Sets scenes up on a stage: with mirrors, without them, as masks and as references.

use bevy::{
    camera::{RenderTarget, visibility::RenderLayers},
    light::NotShadowCaster,
    prelude::*,
    render::render_resource::Face,
};

use super::{
    cut::{Cut, cut},
    reference::{left_handed_eye, reflected_eye},
    scene::{Look, Object, Scene, Surface, exact},
    setting::Setting,
    stage::Stage,
};

/// What the camera sees, and what only lights see.
const SEEN: usize = 0;
const CASTING: usize = 1;

/// How a scene is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum How {
    /// With [`PlanarMirror`](bevy_planar_mirror::PlanarMirror) on the mirrors.
    Mirrors,
    /// The same without that component.
    Plain,
    /// The mirror of this index white, see-through things red, all else black.
    Mask(usize),
    /// What the mirror of this index must show, left and right exchanged.
    Reference(usize),
    /// What the mirror of this index must show, at its place: by a left-handed camera.
    InPlace(usize),
}

impl How {
    /// The mirror that is taken away for its reference.
    fn reference(self) -> Option<usize> {
        match self {
            Self::Reference(mirror) | Self::InPlace(mirror) => Some(mirror),
            _ => None,
        }
    }
}

/// Sets a scene with its mirrors up on a stage of the test's own; returns the camera.
pub fn build_with_mirrors(stage: &mut Stage, scene: &Scene, target: Handle<Image>) -> Entity {
    build(stage.world(), scene, How::Mirrors, target)
}

/// The same without the mirrors' component.
pub fn build_plain(stage: &mut Stage, scene: &Scene, target: Handle<Image>) -> Entity {
    build(stage.world(), scene, How::Plain, target)
}

/// Sets up what a mirror must show, left and right exchanged; returns the camera.
pub fn build_reference(
    stage: &mut Stage,
    scene: &Scene,
    mirror: usize,
    target: Handle<Image>,
) -> Entity {
    build(stage.world(), scene, How::Reference(mirror), target)
}

/// Adds the camera of a scene, and nothing else of it, to what is set up already.
pub fn add_camera(stage: &mut Stage, scene: &Scene, target: Handle<Image>) -> Entity {
    let bundle = (scene.camera_bundle(), RenderTarget::from(target), scene.eye);
    let mut camera = stage.world().spawn(bundle);
    equip(&mut camera, scene, true);
    camera.id()
}

/// Takes everything that a scene has spawned off the stage.
pub fn clear(stage: &mut Stage) {
    // All that a scene spawns has a transform; what the plugins spawn for themselves stays.
    let world = stage.world();
    let spawned: Vec<Entity> = world
        .query_filtered::<Entity, (With<Transform>, Without<ChildOf>)>()
        .iter(world)
        .collect();
    for entity in spawned {
        world.despawn(entity);
    }
}

pub fn build(world: &mut World, scene: &Scene, how: How, target: Handle<Image>) -> Entity {
    let setting = Setting::of_this_run();
    world.insert_resource(ClearColor(match how {
        How::Mask(_) => Color::BLACK,
        _ => scene.clear_color,
    }));
    world.insert_resource(scene.ambient.clone());
    for prop in &scene.props {
        let mut entity = world.spawn(Transform::default());
        prop(&mut entity);
        if how.reference().is_some() {
            // Lights see the casters that the camera does not.
            entity.insert(RenderLayers::from_layers(&[SEEN, CASTING]));
        }
    }
    for (index, surface) in scene.mirrors.iter().enumerate() {
        let look = match how {
            How::Mask(mirror) if mirror == index => Some(white(surface)),
            How::Mask(_) => Some(Color::BLACK.into()),
            _ => surface.look.clone(),
        };
        let mut entity = spawn(
            world,
            surface.mesh.clone(),
            surface.transform,
            look.as_ref(),
        );
        match how {
            How::Mirrors => {
                entity.insert(setting.mirror(&surface.mirror));
            }
            _ if how.reference() == Some(index) => {
                // It does not see itself, but its shadow is still there.
                entity.insert(RenderLayers::layer(CASTING));
            }
            _ => {}
        }
    }
    for object in &scene.objects {
        match how {
            How::Reference(mirror) | How::InPlace(mirror) => {
                spawn_cut(world, scene, mirror, object);
            }
            How::Mask(_) => {
                let look = silhouette(&object.look);
                spawn(world, object.mesh.clone(), object.transform, Some(&look));
            }
            How::Mirrors | How::Plain => {
                spawn(
                    world,
                    object.mesh.clone(),
                    object.transform,
                    Some(&object.look),
                );
            }
        }
    }
    let eye = match how {
        How::Reference(mirror) => reflected_eye(&scene.eye, scene.mirrors[mirror].plane()),
        How::InPlace(mirror) => left_handed_eye(&scene.eye, scene.mirrors[mirror].plane()),
        _ => scene.eye,
    };
    let bundle = (
        scene.camera_bundle(),
        RenderTarget::from(target.clone()),
        eye,
    );
    let mut camera = world.spawn(bundle);
    equip(&mut camera, scene, !matches!(how, How::Mask(_)));
    if matches!(how, How::InPlace(_))
        && let Some(mut camera) = camera.get_mut::<Camera>()
    {
        camera.invert_culling = true;
    }
    let camera = camera.id();
    setting.camera(world, camera);
    if how == How::Mirrors {
        setting.scene(world, scene, &target);
    }
    camera
}

/// What the camera of a scene carries; to a mask only what moves things on the screen matters.
pub fn equip(camera: &mut EntityWorldMut, scene: &Scene, whole: bool) {
    for touch in &scene.lens {
        touch(camera);
    }
    if !whole {
        camera.insert(Msaa::Off);
        return;
    }
    for touch in &scene.camera {
        touch(camera);
    }
}

fn spawn<'w>(
    world: &'w mut World,
    mesh: Mesh,
    transform: Transform,
    look: Option<&Look>,
) -> EntityWorldMut<'w> {
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
    let mut entity = world.spawn((Mesh3d(mesh), transform));
    if let Some(look) = look {
        look.apply(&mut entity);
    }
    entity
}

fn spawn_cut(world: &mut World, scene: &Scene, mirror: usize, object: &Object) {
    let plane = scene.mirrors[mirror].plane();
    let part = match cut(&object.mesh, exact(&object.transform), plane) {
        Cut::Whole => {
            spawn(
                world,
                object.mesh.clone(),
                object.transform,
                Some(&object.look),
            );
            return;
        }
        Cut::Part(part) => Some(*part),
        Cut::Nothing => None,
    };
    if let Some(part) = part {
        spawn(world, part, object.transform, Some(&object.look)).insert(NotShadowCaster);
    }
    // A mirror cuts what is seen, not what stands in the light.
    spawn(
        world,
        object.mesh.clone(),
        object.transform,
        Some(&object.look),
    )
    .insert(RenderLayers::layer(CASTING));
}

/// White from the front. A mirrored transform turns the triangles over, but not the front.
fn white(surface: &Surface) -> Look {
    StandardMaterial {
        base_color: Color::WHITE,
        unlit: true,
        cull_mode: Some(if surface.is_mirrored() {
            Face::Front
        } else {
            Face::Back
        }),
        ..default()
    }
    .into()
}

/// The same shape in one color: black, or red where one sees through.
fn silhouette(look: &Look) -> Look {
    let Look::Standard(material) = look else {
        return Color::BLACK.into();
    };
    let color = match material.alpha_mode {
        AlphaMode::Opaque if material.specular_transmission == 0.0 => Color::BLACK,
        AlphaMode::Mask(_) => Color::BLACK.with_alpha(material.base_color.alpha()),
        _ => Color::srgb(1.0, 0.0, 0.0),
    };
    StandardMaterial {
        base_color: color,
        base_color_texture: material.base_color_texture.clone(),
        unlit: true,
        alpha_mode: match material.alpha_mode {
            AlphaMode::Mask(cutoff) => AlphaMode::Mask(cutoff),
            _ => AlphaMode::Opaque,
        },
        double_sided: material.double_sided,
        cull_mode: material.cull_mode,
        ..default()
    }
    .into()
}
