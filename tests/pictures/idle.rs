//! What a mirror that nobody sees costs the renderer: nothing.

use bevy::{prelude::*, render::camera::ExtractedCamera};

use crate::support::{
    hall::hall,
    live::{Live, find, named},
    props::at,
    scene::Scene,
};

/// A way for the mirror not to be in view.
type Hide = fn(&mut World, Entity);

const WAYS: [(&str, Hide); 4] = [
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

/// Every component of the crate in the renderer, and how many pipelines it has asked for.
fn traces(live: &mut Live) -> (Vec<String>, usize, usize) {
    let pipelines = live.stage.pipeline_labels();
    let ours = pipelines
        .iter()
        .filter(|label| label.contains("planar_mirror"))
        .count();
    let render = live.stage.render_world();
    let views = render.query::<&ExtractedCamera>().iter(render).count();
    let components = render
        .iter_entities()
        .flat_map(|entity| entity.archetype().components().to_vec())
        .filter_map(|id| render.components().get_name(id))
        .map(|name| name.to_string())
        .filter(|name| name.starts_with("bevy_planar_mirror"))
        .collect();
    (components, views, ours)
}

#[test]
fn a_mirror_never_in_view_leaves_no_trace_in_the_renderer() {
    for (way, hide) in WAYS {
        let mut live = Live::new(&scene());
        let mirror = find(live.world(), "mirror");
        hide(live.world(), mirror);
        live.settled();
        let (components, views, pipelines) = traces(&mut live);
        assert_eq!(components, Vec::<String>::new(), "{way}");
        assert_eq!((views, pipelines), (1, 0), "{way}: views and pipelines");
    }
}

#[test]
fn a_mirror_that_leaves_the_view_takes_all_with_it_but_its_pipelines() {
    for (way, hide) in WAYS {
        let mut live = Live::new(&scene());
        live.settled();
        let (components, views, pipelines) = traces(&mut live);
        assert!(
            !components.is_empty() && pipelines > 0,
            "{way}: the mirror was seen"
        );
        assert_eq!(views, 2, "{way}");
        let mirror = find(live.world(), "mirror");
        hide(live.world(), mirror);
        live.settled();
        let (components, views, still) = traces(&mut live);
        assert_eq!(components, Vec::<String>::new(), "{way}");
        assert_eq!((views, still), (1, pipelines), "{way}: views and pipelines");
    }
}
