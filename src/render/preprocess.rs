//! The mesh uniforms of reflected views, and what is drawn of them indirectly.
//!
//! Of the engine's `Core3d` this is all that a reflected view needs; nearly everything else in it
//! looks for a picture to draw into, and finds none. And it has to be in the `Core3d` of the
//! camera that draws the view: there the indirect parameters of all views are cleared first, and
//! built from what was counted in between.

use bevy::{
    ecs::{
        prelude::*,
        schedule::{ScheduleLabel, SingleThreadedExecutor},
    },
    pbr::{PreprocessPipelines, early_gpu_preprocess, unpack_bins},
    render::renderer::CurrentView,
};

use super::prepare::ViewMirrors;

/// Runs the engine's own systems for one reflected view.
#[derive(ScheduleLabel, Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct PreprocessReflection;

impl PreprocessReflection {
    pub fn schedule() -> Schedule {
        let mut schedule = Schedule::new(Self);
        schedule
            .set_executor(SingleThreadedExecutor::new())
            .add_systems(
                (unpack_bins, early_gpu_preprocess)
                    .chain()
                    // Else the mesh uniforms come from the CPU.
                    .run_if(resource_exists::<PreprocessPipelines>),
            );
        schedule
    }
}

/// What the engine runs for a reflected view as for any camera: nothing.
#[derive(ScheduleLabel, Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct ReflectedCore3d;

/// Whether the camera that is being drawn shows mirrors.
pub fn shows_mirrors(
    view: Option<Res<CurrentView>>,
    mirrors: Query<(), With<ViewMirrors>>,
) -> bool {
    view.is_some_and(|view| mirrors.contains(view.0))
}

/// `Core3d` of a camera, between the engine's own preprocessing and what it builds of that. Commands
/// of what came before must have been applied: those of these views come next.
pub fn preprocess_reflections(world: &mut World) {
    let Some(&CurrentView(camera)) = world.get_resource() else {
        return;
    };
    let Some(mirrors) = world.get::<ViewMirrors>(camera) else {
        return;
    };
    let views: Vec<Entity> = mirrors.mirrors.iter().map(|mirror| mirror.view).collect();
    for view in views {
        world.insert_resource(CurrentView(view));
        world.run_schedule(PreprocessReflection);
    }
    world.insert_resource(CurrentView(camera));
}
