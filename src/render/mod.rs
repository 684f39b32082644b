//! Render world: from reflected views to the picture.
//!
//! | step | schedule | file |
//! |---|---|---|
//! | what to draw, for which camera | `ExtractSchedule`, then before views are prepared | `extract.rs` |
//! | what light the air lets through | before views are prepared, `PrepareResources` | `atmosphere.rs` |
//! | what is drawn without being culled on the CPU | before `Specialize` | `listed.rs` |
//! | pipelines with a stencil test and a flipped front face | after `Specialize`, after `Queue` | `variant.rs` |
//! | shadow maps that no other view draws over | `PrepareResources` | `shadow.rs` |
//! | what glass in a reflection refracts | `PrepareResources` | `transmission.rs` |
//! | mask pipelines, textures, bind groups | `PrepareResources`, `PrepareBindGroups` | `mask.rs`, `prepare.rs` |
//! | which lamps reach a reflected view | `PrepareViews` | `clusters.rs` |
//! | many lamps sorted | `Core3d` of a reflected view, before its camera's | the engine |
//! | mesh uniforms and indirect parameters | `Core3d`, before the passes | `preprocess.rs` |
//! | the mirror pass | `Core3d`, between opaque and transparent | `pass.rs`, `ready.rs`, `reflection.rs` |
//! | what it took, for the main world | the next `ExtractSchedule` | `drawn.rs` |
//!
//! Every step does nothing while [`ExtractedMirrors`] is empty.

mod atmosphere;
mod clusters;
mod drawn;
mod extract;
mod listed;
mod mask;
mod pass;
mod pixels;
mod prepare;
mod preprocess;
mod ready;
mod reflection;
mod shadow;
mod transmission;
mod variant;

use bevy::{
    app::{App, SubApp},
    asset::{embedded_asset, io::embedded::EmbeddedAssetRegistry},
    core_pipeline::{
        core_3d::{main_opaque_pass_3d, main_transparent_pass_3d},
        schedule::{Core3d, Core3dSystems},
    },
    ecs::prelude::*,
    pbr::{
        collect_gpu_culled_meshes, early_gpu_preprocess, early_prepass_build_indirect_parameters,
        main_transmissive_pass_3d, prepare_lights, resources::prepare_atmosphere_uniforms,
    },
    render::{ExtractSchedule, GpuResourceAppExt, Render, RenderStartup, RenderSystems},
};

use self::{
    extract::ExtractedMirrors,
    preprocess::{PreprocessReflection, ReflectedCore3d},
    variant::StencilVariants,
};
use crate::view::{disable_reflected_views, enable_reflected_views};

/// Embeds the shaders, if the app has assets.
pub fn embed_shaders(app: &mut App) {
    if !app.world().contains_resource::<EmbeddedAssetRegistry>() {
        return;
    }
    embedded_asset!(app, "mask.wgsl");
    embedded_asset!(app, "shadow.wgsl");
}

/// Adds every render-world system, in its order.
pub fn build_render_app(render_app: &mut SubApp) {
    render_app
        .init_resource::<ExtractedMirrors>()
        .init_resource::<drawn::DrawnViews>()
        .init_gpu_resource::<ready::WholeViews>()
        .add_schedule(Schedule::new(ReflectedCore3d))
        .add_schedule(PreprocessReflection::schedule())
        .init_gpu_resource::<StencilVariants>()
        .init_gpu_resource::<prepare::MirrorUniforms>()
        .init_gpu_resource::<mask::SpecializedMasks>()
        .add_systems(
            RenderStartup,
            (
                mask::init_mirror_pipelines,
                shadow::init_shadow_pipelines,
                clusters::forget_lamps,
            ),
        )
        .add_systems(
            ExtractSchedule,
            // Of the frame before, if it had mirrors.
            (
                drawn::hand_back.run_if(any_mirrors),
                extract::extract_mirrors,
                ready::forget_whole_views,
            )
                .chain(),
        )
        .add_systems(
            Render,
            (
                (
                    extract::configure_mirror_views,
                    atmosphere::share_atmosphere,
                )
                    .after(RenderSystems::ExtractCommands)
                    .before(RenderSystems::PrepareMeshes)
                    .before(RenderSystems::PrepareAssets),
                listed::list_on_cpu_alone
                    .after(collect_gpu_culled_meshes)
                    .after(RenderSystems::PrepareMeshes)
                    .before(RenderSystems::Specialize),
                atmosphere::leave_atmosphere_to_cameras
                    .after(prepare_atmosphere_uniforms)
                    .before(RenderSystems::PrepareResources),
                atmosphere::share_atmosphere_textures
                    .after(RenderSystems::PrepareResources)
                    .before(RenderSystems::PrepareBindGroups),
                extract::share_jitter
                    .after(RenderSystems::PrepareViews)
                    .before(RenderSystems::PrepareResources),
                clusters::list_lamps
                    .after(RenderSystems::CreateViews)
                    .before(RenderSystems::PrepareResources),
                variant::vary_material_pipelines
                    .after(RenderSystems::Specialize)
                    .before(RenderSystems::Queue),
                variant::vary_queued_items
                    .after(RenderSystems::Queue)
                    .before(RenderSystems::PhaseSort),
                shadow::prepare_mirror_shadows
                    .after(prepare_lights)
                    .in_set(RenderSystems::PrepareResources),
                transmission::prepare_mirror_transmission.in_set(RenderSystems::PrepareResources),
                prepare::prepare_mirrors.in_set(RenderSystems::PrepareBindGroups),
                (variant::vary_skyboxes, variant::vary_queued_items)
                    .after(RenderSystems::Prepare)
                    .before(RenderSystems::Render),
                variant::restore_queued_items.in_set(RenderSystems::Cleanup),
            )
                .run_if(any_mirrors),
        )
        .add_systems(
            Render,
            prepare::forget_mirrors
                .in_set(RenderSystems::PrepareResources)
                .run_if(any_with_component::<prepare::ViewMirrors>),
        )
        .add_systems(
            Core3d,
            (ApplyDeferred, preprocess::preprocess_reflections)
                .chain()
                .after(early_gpu_preprocess)
                .before(early_prepass_build_indirect_parameters)
                .run_if(preprocess::shows_mirrors),
        )
        .add_systems(
            Core3d,
            // Before transmission and transparency, so that glass shows the reflection and a
            // translucent floor blends over its own.
            pass::mirror_pass
                .after(main_opaque_pass_3d)
                .before(main_transmissive_pass_3d)
                .before(main_transparent_pass_3d)
                .in_set(Core3dSystems::MainPass),
        );

    // Extraction is the one time when the rest of the engine has to see the reflected views.
    if let Some(mut extract) = render_app.take_extract() {
        render_app.set_extract(move |main_world, render_world| {
            enable_reflected_views(main_world);
            extract(main_world, render_world);
            disable_reflected_views(main_world);
        });
    }
}

fn any_mirrors(mirrors: Res<ExtractedMirrors>) -> bool {
    !mirrors.views.is_empty()
}
