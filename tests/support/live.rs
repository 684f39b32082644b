//! Scenes that change while they run, measured by apps that never knew them otherwise.

use bevy::prelude::*;

use super::{
    picture::Picture,
    scene::{Look, Scene},
    set::{build_plain, build_with_mirrors, clear},
    stage::Stage,
};

/// Something that happens to the world between two frames.
pub type Change<'a> = &'a dyn Fn(&mut World);

/// A look with a name, by which [`find`] finds what wears it.
pub fn named(name: &'static str, look: impl Into<Look>) -> Look {
    let look = look.into();
    Look::other(move |entity| {
        look.apply(entity);
        entity.insert(Name::new(name));
    })
}

/// A name and no material.
pub fn unclad(name: &'static str) -> Look {
    Look::other(move |entity| {
        entity.insert(Name::new(name));
    })
}

/// The one entity of this name.
#[track_caller]
pub fn find(world: &mut World, name: &str) -> Entity {
    let mut names = world.query::<(Entity, &Name)>();
    let found: Vec<_> = names
        .iter(world)
        .filter(|(_, it)| it.as_str() == name)
        .map(|(entity, _)| entity)
        .collect();
    let [entity] = found[..] else {
        panic!("{} entities are named {name}", found.len());
    };
    entity
}

/// A component of the one entity of this name.
#[track_caller]
pub fn of<'w, C>(world: &'w mut World, name: &str) -> Mut<'w, C>
where
    C: Component<Mutability = bevy::ecs::component::Mutable>,
{
    let entity = find(world, name);
    world
        .get_mut(entity)
        .unwrap_or_else(|| panic!("{name} has no such component"))
}

/// One scene on a stage.
pub struct Live {
    pub stage: Stage,
    pub target: Handle<Image>,
    pub camera: Entity,
    pub size: UVec2,
}

impl Live {
    /// The scene with its mirrors in an app as games run it, as no frame has shown it yet.
    pub fn new(scene: &Scene) -> Self {
        Self::on(Stage::game_with_mirrors(), scene)
    }

    /// [`Self::new`] in an app whose render world is in reach.
    pub fn in_reach(scene: &Scene) -> Self {
        Self::on(Stage::with_mirrors(), scene)
    }

    /// The same on a stage of the test's own.
    pub fn on(mut stage: Stage, scene: &Scene) -> Self {
        let target = stage.target(scene.size);
        let camera = build_with_mirrors(&mut stage, scene, target.clone());
        Self {
            stage,
            target,
            camera,
            size: scene.size,
        }
    }

    /// The same, where the mirrors' component is left away.
    pub fn plain(mut stage: Stage, scene: &Scene) -> Self {
        let target = stage.target(scene.size);
        let camera = build_plain(&mut stage, scene, target.clone());
        Self {
            stage,
            target,
            camera,
            size: scene.size,
        }
    }

    /// Takes the scene down and sets it up again.
    pub fn again(self, scene: &Scene) -> Self {
        let mut stage = self.stage;
        clear(&mut stage);
        Self::on(stage, scene)
    }

    pub fn world(&mut self) -> &mut World {
        self.stage.world()
    }

    /// The picture when nothing changes any more.
    #[track_caller]
    pub fn settled(&mut self) -> Picture {
        let settled = self.stage.settle(&self.target, self.size);
        settled.unwrap_or_else(|reason| panic!("{reason}"))
    }

    /// The picture after one frame more, and as many as it takes to compile what is new in it.
    #[track_caller]
    pub fn next(&mut self) -> Picture {
        self.stage.frame();
        while self.stage.waiting_pipelines() > 0 {
            self.stage.frame();
        }
        let picture = self.stage.read(&self.target, self.size);
        picture.unwrap_or_else(|reason| panic!("{reason}"))
    }
}

/// The first frame after a change shows what an app shows that never knew the scene otherwise.
#[track_caller]
pub fn assert_seen_at_once(scene: &Scene, change: impl Fn(&mut World)) -> Picture {
    assert_each_seen_at_once(scene, &[&change])
}

/// [`assert_seen_at_once`] for changes one after the other, a frame for each.
///
/// Each has to be seen: one that leaves the picture as it was tests nothing.
#[track_caller]
pub fn assert_each_seen_at_once(scene: &Scene, changes: &[Change]) -> Picture {
    let mut live = Live::new(scene);
    let mut last = live.settled();
    let mut fresh = Live::new(scene);
    for step in 0..changes.len() {
        if step > 0 {
            fresh = fresh.again(scene);
        }
        changes[step](live.world());
        let picture = live.next();
        for change in &changes[..=step] {
            change(fresh.world());
        }
        let what = format!("{}-change-{step}", scene.name);
        picture.assert_same(&fresh.settled(), &what);
        let seen = picture.difference(&last, 8, |_| true);
        assert!(
            seen.as_ref().is_ok_and(|seen| seen.beyond > 5),
            "{what} is not to be seen: {seen:?}"
        );
        last = picture;
    }
    last
}
