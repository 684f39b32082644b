//! Whether a reflection can be drawn yet.
//!
//! Pipelines are compiled in the background. A mirror that comes into view is left as the plain mesh
//! until all that shows in it can be drawn; else one would see the clear color where things are.
//! From then on it is drawn with what is there: something new is missing for some frames, as it is
//! in the camera's own picture.

use std::sync::{Mutex, PoisonError};

use bevy::{
    ecs::{entity::EntityHashMap, prelude::*},
    log::warn,
    platform::collections::HashSet,
    render::render_resource::{CachedPipelineState, CachedRenderPipelineId, PipelineCache},
    shader::ShaderCacheError,
};

use super::{extract::ExtractedMirrors, mask::PassKey};

/// The views that have been drawn whole, by their entities in the main world, and the kind of
/// pass in which they were.
#[derive(Resource, Default)]
pub struct WholeViews(Mutex<Known>);

#[derive(Default)]
struct Known {
    whole: EntityHashMap<PassKey>,
    /// What cannot be compiled, so that each is named once.
    broken: HashSet<CachedRenderPipelineId>,
}

impl WholeViews {
    /// Whether a view may be drawn with such pipelines as are ready.
    pub fn may_draw(
        &self,
        view: Entity,
        pass: PassKey,
        cache: &PipelineCache,
        pipelines: impl Iterator<Item = CachedRenderPipelineId>,
    ) -> bool {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if known.whole.get(&view) == Some(&pass) {
            return true;
        }
        let mut is_whole = true;
        for pipeline in pipelines {
            match cache.get_render_pipeline_state(pipeline) {
                CachedPipelineState::Queued | CachedPipelineState::Creating(_) => return false,
                // What its shader waits for may never come, and the rest need not wait for it.
                CachedPipelineState::Err(
                    ShaderCacheError::ShaderNotLoaded(_)
                    | ShaderCacheError::ShaderImportNotYetAvailable,
                ) => is_whole = false,
                CachedPipelineState::Err(_) => {
                    if known.broken.insert(pipeline) {
                        warn_of_broken(cache, pipeline);
                    }
                }
                CachedPipelineState::Ok(_) => {}
            }
        }
        if is_whole {
            known.whole.insert(view, pass);
        }
        true
    }
}

fn warn_of_broken(cache: &PipelineCache, pipeline: CachedRenderPipelineId) {
    let descriptor = cache.get_render_pipeline_descriptor(pipeline);
    warn!(
        "{:?} is left out of mirrors: its shader does not compile there. A reflection has no depth, \
         normal or motion vector prepass: read one only under `#ifdef DEPTH_PREPASS` and the like.",
        descriptor.label.as_deref().unwrap_or("an unnamed item")
    );
}

/// Forgets views that are gone.
pub fn forget_whole_views(mirrors: Res<ExtractedMirrors>, mut whole: ResMut<WholeViews>) {
    let known = whole.0.get_mut().unwrap_or_else(PoisonError::into_inner);
    let whole = &mut known.whole;
    if whole.len() > mirrors.views.len() {
        whole.retain(|view, _| mirrors.views.iter().any(|it| it.main_view == *view));
    }
}
