//! What a mirror that nobody sees costs the renderer: nothing. And what one costs that stays as it is: nothing that grows.

use std::collections::BTreeSet;

use bevy::{
    prelude::*,
    render::{camera::ExtractedCamera, renderer::RenderInstance},
};

use crate::support::{
    hall::hall,
    live::{Live, find, named},
    props::{at, lit},
    scene::Scene,
};

/// A way for the mirror not to be in view.
type Hide = fn(&mut World, Entity);

const WAYS: [(&str, Hide); 5] = [
    ("behind the camera", |world, mirror| {
        place(world, mirror, at(0.0, 0.5, 30.0))
    }),
    ("turned away", |world, mirror| {
        let back = Quat::from_rotation_y(std::f32::consts::PI);
        place(world, mirror, at(0.0, 0.5, 0.0).with_rotation(back));
    }),
    ("hidden", |world, mirror| {
        world.entity_mut(mirror).insert(Visibility::Hidden);
    }),
    ("behind a wall", |world, _| {
        let mesh = Mesh::from(Cuboid::new(9.0, 9.0, 0.1));
        let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
        let material = lit(Color::srgb(0.6, 0.6, 0.3));
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        let material = MeshMaterial3d(materials.add(material));
        world.spawn((Mesh3d(mesh), material, at(0.5, 1.0, 2.5)));
    }),
    ("gone", |world, mirror| {
        world.despawn(mirror);
    }),
];

fn place(world: &mut World, mirror: Entity, transform: Transform) {
    world.entity_mut(mirror).insert(transform);
}

fn scene() -> Scene {
    let mut scene = hall("idle");
    // A look of its own, by which the mirror is found; it is drawn with and without the plugin.
    scene.mirrors[0].look = Some(named("mirror", Color::srgb(0.2, 0.2, 0.3)));
    scene
}

/// What the renderer keeps: views, components of the user's camera, pipelines made for mirrors.
#[derive(Debug, PartialEq)]
struct Traces {
    views: usize,
    camera_components: usize,
    pipelines: usize,
}

fn traces(live: &mut Live) -> Traces {
    let labels = live.stage.pipeline_labels();
    let pipelines = labels
        .iter()
        .filter(|label| label.contains("planar_mirror"))
        .count();
    let render = live.stage.render_world();
    let mut query = render.query::<(EntityRef, &ExtractedCamera)>();
    let counts: Vec<_> = query
        .iter(render)
        .map(|(entity, camera)| (camera.order, entity.archetype().component_count()))
        .collect();
    Traces {
        views: counts.len(),
        // The reflected views come before every camera of the user's.
        camera_components: counts.iter().max().map_or(0, |(_, count)| *count),
        pipelines,
    }
}

#[test]
fn a_mirror_never_in_view_leaves_no_trace_in_the_renderer() {
    let mut bare = scene();
    bare.mirrors.clear();
    let mut bare = Live::in_reach(&bare);
    bare.settled();
    let nothing = traces(&mut bare);
    assert_eq!((nothing.views, nothing.pipelines), (1, 0));
    drop(bare);
    for (way, hide) in WAYS {
        let mut live = Live::in_reach(&scene());
        let mirror = find(live.world(), "mirror");
        hide(live.world(), mirror);
        live.settled();
        assert_eq!(traces(&mut live), nothing, "{way}");
    }
}

#[test]
fn a_mirror_that_leaves_the_view_takes_all_with_it_but_its_pipelines() {
    for (way, hide) in WAYS {
        let mut live = Live::in_reach(&scene());
        live.settled();
        let seen = traces(&mut live);
        assert!(seen.views == 2 && seen.pipelines > 0, "{way}: {seen:?}");
        let mirror = find(live.world(), "mirror");
        hide(live.world(), mirror);
        live.settled();
        let left = traces(&mut live);
        assert_eq!((left.views, left.pipelines), (1, seen.pipelines), "{way}");
        assert!(
            left.camera_components < seen.camera_components,
            "{way}: {left:?}, {seen:?}"
        );
    }
}

/// What a frame in which nothing happens leaves as it was.
#[derive(Debug, PartialEq)]
struct Steady {
    main: Kept,
    render: Kept,
    pipelines: usize,
    textures: usize,
    buffers: usize,
}

/// The entities of a world, by id and generation, and its archetypes.
#[derive(Debug, PartialEq)]
struct Kept {
    entities: BTreeSet<Entity>,
    archetypes: usize,
}

fn kept(world: &World) -> Kept {
    let archetypes = world.archetypes();
    let entities = archetypes.iter().flat_map(|archetype| archetype.entities());
    Kept {
        entities: entities.map(|entity| entity.id()).collect(),
        archetypes: archetypes.len(),
    }
}

fn steady(live: &mut Live) -> Steady {
    let main = kept(live.world());
    let pipelines = live.stage.pipeline_labels().len();
    let render = live.stage.render_world();
    let report = render.resource::<RenderInstance>().generate_report();
    let report = report.expect("it runs on this machine").hub;
    Steady {
        main,
        render: kept(render),
        pipelines,
        textures: report.textures.num_allocated,
        buffers: report.buffers.num_allocated,
    }
}

#[test]
fn a_frame_in_which_nothing_happens_adds_nothing_in_either_world() {
    let seen: (&str, Hide) = ("seen", |_, _| {});
    for (way, hide) in WAYS.into_iter().chain([seen]) {
        let mut live = Live::in_reach(&scene());
        let mirror = find(live.world(), "mirror");
        hide(live.world(), mirror);
        live.settled();
        let before = steady(&mut live);
        for frame in 0..8 {
            live.stage.frame();
            assert_eq!(steady(&mut live), before, "{way}, frame {frame}");
        }
    }
}
