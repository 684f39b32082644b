//! What a reflected view needs of the engine's render schedule: its mesh uniforms.
//!
//! Of `Core3d` nearly everything looks for a picture to draw into, which a reflected view has not.
//! To find that out some seventy times a view takes longer than the little that is to do.

use bevy::{
    ecs::schedule::{
        IntoScheduleConfigs, Schedule, ScheduleLabel, SingleThreadedExecutor,
        common_conditions::resource_exists,
    },
    pbr::{PreprocessPipelines, early_gpu_preprocess, unpack_bins},
};

/// The schedule of a reflected view whose lamps are listed.
#[derive(ScheduleLabel, Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct ReflectedCore3d;

impl ReflectedCore3d {
    /// Runs the engine's own systems, one after the other.
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
