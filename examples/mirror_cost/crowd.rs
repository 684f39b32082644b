//! Ten thousand things around a mirror of two by two meters: how many are drawn in it, and how many
//! are truly seen there.

use bevy::prelude::*;
use bevy_planar_mirror::status::MirrorFigures;

use crate::{
    contest::{self, Failure, MIRRORS, Measured, Outcome},
    estimate::{Estimate, Part},
    frames, pyramid,
    support::{
        props::lit,
        random::Random,
        scene::{Look, Object, Scene, Surface},
        set::build_with_mirrors,
    },
};

const THINGS: usize = 10_000;

/// Where the eye stands, one after the other.
const EYES: [Vec3; 8] = [
    Vec3::new(0.0, 0.0, 4.0),
    Vec3::new(1.5, 0.4, 3.5),
    Vec3::new(-2.0, 1.0, 3.0),
    Vec3::new(0.5, -1.0, 5.0),
    Vec3::new(-3.0, 0.2, 2.5),
    Vec3::new(3.5, 1.5, 4.5),
    Vec3::new(0.2, 0.3, 8.0),
    Vec3::new(-0.8, 2.0, 2.5),
];

/// The objects drawn by [`MirrorFigures`], by those of which anything is left when their triangles
/// are cut at the mirror's plane and at the pyramid through its frame, in f64.
pub fn measure(height: u32) -> Outcome {
    let mesh = Mesh::from(Cuboid::from_length(0.3));
    let look = Look::from(lit(Color::srgb(0.8, 0.5, 0.3)));
    let random = &mut Random::new(5);
    let things: Vec<Object> = (0..THINGS)
        .map(|_| {
            let reach = Vec3::new(20.0, 10.0, 20.0);
            let turn = random.within(Vec3::splat(-3.0), Vec3::splat(3.0));
            let turn = Quat::from_euler(EulerRot::XYZ, turn.x, turn.y, turn.z);
            Object {
                mesh: mesh.clone(),
                transform: Transform::from_translation(random.within(-reach, reach))
                    .with_rotation(turn),
                look: look.clone(),
            }
        })
        .collect();
    let mut scene = Scene::new("crowd").mirror(Surface::wall(2.0, 2.0, Transform::default()));
    scene.size = UVec2::new(height * 16 / 9, height);
    scene.ambient.brightness = 500.0;

    let mut stage = contest::start(MIRRORS);
    let target = stage.target(scene.size);
    let camera = build_with_mirrors(&mut stage, &scene, target);
    // One mesh and one material for all, as a game would have them.
    let world = stage.world();
    let mesh = Mesh3d(world.resource_mut::<Assets<Mesh>>().add(mesh));
    let mut first = world.spawn(mesh.clone());
    look.apply(&mut first);
    let material = first
        .take::<MeshMaterial3d<StandardMaterial>>()
        .ok_or_else(|| "the look is no standard material".to_owned())?;
    first.despawn();
    let bundles: Vec<_> = things
        .iter()
        .map(|thing| (mesh.clone(), material.clone(), thing.transform))
        .collect();
    world.spawn_batch(bundles);

    let (mut parts, mut details) = (Vec::new(), Vec::new());
    for eye in EYES {
        scene = scene.eye(eye, Vec3::ZERO);
        stage.world().entity_mut(camera).insert(scene.eye);
        frames::settle(&mut stage)?;
        if stage.app().should_exit().is_some() {
            return Err(Failure::Interrupted);
        }
        let drawn: usize = stage
            .world()
            .resource::<MirrorFigures>()
            .views
            .iter()
            .map(|view| view.objects)
            .sum();
        let mut planes = pyramid::sides(&scene);
        planes.push(scene.mirrors[0].plane());
        let seen = things
            .iter()
            .filter(|thing| pyramid::within(thing, &planes).is_some())
            .count();
        details.push(format!("{drawn} drawn, {seen} seen"));
        parts.push(Part {
            of: drawn as f64,
            by: seen as f64,
        });
    }
    let estimate = Estimate::of(&parts).ok_or_else(|| "nothing was counted".to_owned())?;
    Ok(Measured {
        estimate,
        details: details.join("; "),
        pictures: Vec::new(),
    })
}
