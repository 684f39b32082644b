//! Stencil variants of the pipelines that draw in a reflected view.
//!
//! The engine's pipelines for 3D phases are made for a depth attachment without a stencil, and a
//! render pass wants the formats to be equal. A *variant* is a pipeline's own descriptor with the
//! depth-stencil format of the mirror pass, a test for the depth of the reflection, and after an odd
//! number of reflections the front face flipped: each turns the winding around. Flipping the front
//! face rather than the culled one is right for every material, for two-sided lighting, and when
//! nothing is culled.

use core::cell::Cell;

use bevy::{
    core_pipeline::{
        core_3d::{AlphaMask3d, Opaque3d, Transparent3d},
        skybox::SkyboxPipelineId,
    },
    ecs::{prelude::*, system::SystemParam},
    log::warn,
    pbr::{SpecializedMaterialPipelineCache, Transmissive3d, ViewKeyCache, wireframe::Wireframe3d},
    platform::collections::{HashMap, HashSet},
    render::{
        render_phase::{
            BinnedPhaseItem, BinnedRenderPhase, ViewBinnedRenderPhases, ViewSortedRenderPhases,
        },
        render_resource::{
            CachedRenderPipelineId, CompareFunction, FrontFace, PipelineCache,
            RenderPipelineDescriptor, StencilFaceState, StencilState, TextureFormat,
        },
        renderer::RenderDevice,
        settings::WgpuFeatures,
        view::{ExtractedView, Msaa, RetainedViewEntity},
    },
};

use super::extract::{ExtractedMirrorView, ExtractedMirrors};

/// The variants made so far, and the depth-stencil format they are made for.
#[derive(Resource)]
pub struct StencilVariants {
    /// `Depth32FloatStencil8` where the device has it: the depth of the main pass, exactly.
    pub format: TextureFormat,
    /// base, and whether it is flipped -> variant, and the pass that both fit.
    variants: HashMap<(CachedRenderPipelineId, bool), (CachedRenderPipelineId, PassFormat)>,
    /// variant -> base.
    bases: HashMap<CachedRenderPipelineId, CachedRenderPipelineId>,
    /// Pipelines that other plugins queued by themselves.
    foreign: HashSet<CachedRenderPipelineId>,
    /// What was left out, so that each is named once.
    left_out: HashSet<CachedRenderPipelineId>,
    /// How many pipelines there were when variants were asked for ahead.
    known_pipelines: usize,
}

impl FromWorld for StencilVariants {
    fn from_world(world: &mut World) -> Self {
        let features = world.resource::<RenderDevice>().features();
        Self {
            format: if features.contains(WgpuFeatures::DEPTH32FLOAT_STENCIL8) {
                TextureFormat::Depth32FloatStencil8
            } else {
                TextureFormat::Depth24PlusStencil8
            },
            variants: HashMap::default(),
            bases: HashMap::default(),
            foreign: HashSet::default(),
            left_out: HashSet::default(),
            known_pipelines: 0,
        }
    }
}

/// What a pipeline must agree with to be used in a camera's mirror pass.
#[derive(Clone, Copy, PartialEq)]
struct PassFormat {
    color: TextureFormat,
    samples: u32,
    /// Whether the front face is flipped.
    is_flipped: bool,
}

impl StencilVariants {
    /// The variant to draw with in place of `base`; `base` itself if it is a variant already.
    /// `None`, with one line in the log, if it cannot be drawn in the mirror pass.
    fn variant(
        &mut self,
        base: CachedRenderPipelineId,
        pass: PassFormat,
        cache: &mut PipelineCache,
    ) -> Option<CachedRenderPipelineId> {
        let variant = self.find_or_queue(base, pass, cache);
        if variant.is_none() && self.left_out.insert(base) {
            let descriptor = cache.get_render_pipeline_descriptor(base);
            warn!(
                "{:?} is left out of mirrors: its pipeline has no depth test, or other color \
                 targets or samples than its camera.",
                descriptor.label.as_deref().unwrap_or("an unnamed item")
            );
        }
        variant
    }

    /// [`Self::variant`] without a word in the log.
    fn find_or_queue(
        &mut self,
        base: CachedRenderPipelineId,
        pass: PassFormat,
        cache: &mut PipelineCache,
    ) -> Option<CachedRenderPipelineId> {
        if self.bases.contains_key(&base) {
            return Some(base);
        }
        if let Some(&(variant, made_for)) = self.variants.get(&(base, pass.is_flipped))
            && made_for == pass
        {
            return Some(variant);
        }
        // A descriptor can be read only once its pipeline has left the queue of new ones.
        if base.id() >= cache.pipelines().count() {
            cache.process_queue();
        }
        let descriptor = cache.get_render_pipeline_descriptor(base);
        let variant = stencil_variant(descriptor, pass, self.format)?;
        let variant = cache.queue_render_pipeline(variant);
        self.variants
            .insert((base, pass.is_flipped), (variant, pass));
        self.bases.insert(variant, base);
        Some(variant)
    }

    /// [`Self::variant`] of what is not one yet: an item that another plugin has queued.
    fn foreign_variant(
        &mut self,
        base: CachedRenderPipelineId,
        pass: PassFormat,
        cache: &mut PipelineCache,
    ) -> Option<CachedRenderPipelineId> {
        self.foreign.insert(base);
        self.variant(base, pass, cache)
    }

    /// What to put back in place of a variant once the frame is drawn.
    fn restore_foreign(&self, variant: CachedRenderPipelineId) -> Option<CachedRenderPipelineId> {
        let base = self.bases.get(&variant)?;
        self.foreign.contains(base).then_some(*base)
    }
}

/// Draws where the stencil holds the reference value, and leaves it as it is.
fn equal_stencil() -> StencilState {
    let face = StencilFaceState {
        compare: CompareFunction::Equal,
        ..StencilFaceState::IGNORE
    };
    StencilState {
        front: face,
        back: face,
        read_mask: 0xff,
        write_mask: 0,
    }
}

/// `None` if the pipeline does not fit the pass in all but the depth-stencil format.
fn stencil_variant(
    base: &RenderPipelineDescriptor,
    pass: PassFormat,
    format: TextureFormat,
) -> Option<RenderPipelineDescriptor> {
    let mut variant = base.clone();
    let targets = &variant.fragment.as_ref()?.targets;
    if !matches!(&targets[..], [Some(target)] if target.format == pass.color)
        || variant.multisample.count != pass.samples
    {
        return None;
    }
    let depth_stencil = variant.depth_stencil.as_mut()?;
    depth_stencil.format = format;
    depth_stencil.stencil = equal_stencil();
    if pass.is_flipped {
        variant.primitive.front_face = match base.primitive.front_face {
            FrontFace::Ccw => FrontFace::Cw,
            FrontFace::Cw => FrontFace::Ccw,
        };
    }
    variant.label = base
        .label
        .as_ref()
        .map(|label| format!("planar_mirror_{label}").into());
    Some(variant)
}

type MirrorViews<'w, 's> = Query<'w, 's, (&'static ExtractedView, &'static Msaa)>;

fn pass_format(mirror: &ExtractedMirrorView, view: &ExtractedView, msaa: &Msaa) -> PassFormat {
    PassFormat {
        color: view.target_format,
        samples: msaa.samples(),
        is_flipped: mirror.is_flipped(),
    }
}

/// Replaces the pipelines of all materials in reflected views, before they are queued.
///
/// And asks for variants of those that the camera itself uses, so that what it sees already is
/// ready when it comes into view of a mirror.
pub fn vary_material_pipelines(
    mirrors: Res<ExtractedMirrors>,
    views: MirrorViews,
    keys: Res<ViewKeyCache>,
    mut specialized: ResMut<SpecializedMaterialPipelineCache>,
    mut variants: ResMut<StencilVariants>,
    mut cache: ResMut<PipelineCache>,
) {
    for mirror in &mirrors.views {
        let Ok((view, msaa)) = views.get(mirror.view) else {
            continue;
        };
        let Some(pipelines) = specialized.get_mut(&view.retained_view_entity) else {
            continue;
        };
        let format = pass_format(mirror, view, msaa);
        pipelines.retain(
            |_, pipeline| match variants.variant(*pipeline, format, &mut cache) {
                Some(variant) => {
                    *pipeline = variant;
                    true
                }
                None => false,
            },
        );
    }
    // New pipelines are rare, and the camera's are many.
    if variants.known_pipelines == cache.pipelines().count() {
        return;
    }
    for mirror in &mirrors.views {
        let (Ok((view, msaa)), Ok((camera, _))) =
            (views.get(mirror.view), views.get(mirror.camera))
        else {
            continue;
        };
        let (view_key, camera_key) = (&view.retained_view_entity, &camera.retained_view_entity);
        // A camera that has more than the view, as a prepass, has other pipelines.
        if keys.get(view_key) != keys.get(camera_key) {
            continue;
        }
        let Some(pipelines) = specialized.get(camera_key) else {
            continue;
        };
        let format = pass_format(mirror, view, msaa);
        for &pipeline in pipelines.values() {
            variants.find_or_queue(pipeline, format, &mut cache);
        }
    }
    cache.process_queue();
    variants.known_pipelines = cache.pipelines().count();
}

/// The phases of all reflected views.
#[derive(SystemParam)]
pub struct Phases<'w> {
    opaque: ResMut<'w, ViewBinnedRenderPhases<Opaque3d>>,
    alpha_mask: ResMut<'w, ViewBinnedRenderPhases<AlphaMask3d>>,
    transmissive: ResMut<'w, ViewSortedRenderPhases<Transmissive3d>>,
    transparent: ResMut<'w, ViewSortedRenderPhases<Transparent3d>>,
    /// If there is a plugin for it.
    wireframe: Option<ResMut<'w, ViewBinnedRenderPhases<Wireframe3d>>>,
}

impl Phases<'_> {
    fn wireframe(
        &mut self,
        view: &RetainedViewEntity,
    ) -> Option<&mut BinnedRenderPhase<Wireframe3d>> {
        self.wireframe.as_mut()?.get_mut(view)
    }
}

/// Replaces the pipelines of what other plugins queued into reflected views by themselves.
///
/// Runs once before the items are batched and once before they are drawn, for what comes late.
pub fn vary_queued_items(
    mut mirrors: ResMut<ExtractedMirrors>,
    mut views: Query<(&mut ExtractedView, &Msaa)>,
    mut phases: Phases,
    mut variants: ResMut<StencilVariants>,
    mut cache: ResMut<PipelineCache>,
) {
    for mirror in &mut mirrors.views {
        let Ok((mut view, msaa)) = views.get_mut(mirror.view) else {
            continue;
        };
        let format = pass_format(mirror, &view, msaa);
        let key = &view.retained_view_entity;
        let met = Cell::new(false);
        let mut vary = |pipeline: &mut CachedRenderPipelineId| {
            if variants.bases.contains_key(pipeline) {
                return true;
            }
            met.set(true);
            let variant = variants.foreign_variant(*pipeline, format, &mut cache);
            *pipeline = variant.unwrap_or(*pipeline);
            variant.is_some()
        };
        if let Some(phase) = phases.opaque.get_mut(key) {
            rekey(phase, |key| &mut key.pipeline, &mut vary);
        }
        if let Some(phase) = phases.alpha_mask.get_mut(key) {
            rekey(phase, |key| &mut key.pipeline, &mut vary);
        }
        if let Some(phase) = phases.transmissive.get_mut(key) {
            phase.items.retain(|_, item| vary(&mut item.pipeline));
        }
        if let Some(phase) = phases.transparent.get_mut(key) {
            phase.items.retain(|_, item| vary(&mut item.pipeline));
        }
        let is_foreign = met.get();
        // Of these it is known where they are: on meshes that show.
        if let Some(phase) = phases.wireframe(key) {
            rekey(phase, |key| &mut key.pipeline, &mut vary);
        }
        mirror.has_foreign_items |= is_foreign;
        if is_foreign && let Some(oblique) = mirror.clip_unbounded {
            view.clip_from_view = mirror.handed(oblique);
            mirror.is_oblique = true;
        }
    }
}

/// Puts the bins of other plugins back under the keys they chose, by which they will look for
/// them in the next frame.
pub fn restore_queued_items(
    mirrors: Res<ExtractedMirrors>,
    views: MirrorViews,
    mut phases: Phases,
    variants: Res<StencilVariants>,
) {
    let mut restore = |pipeline: &mut CachedRenderPipelineId| {
        *pipeline = variants.restore_foreign(*pipeline).unwrap_or(*pipeline);
        true
    };
    for mirror in &mirrors.views {
        let Ok((view, _)) = views.get(mirror.view) else {
            continue;
        };
        let key = &view.retained_view_entity;
        if let Some(phase) = phases.opaque.get_mut(key) {
            rekey(phase, |key| &mut key.pipeline, &mut restore);
        }
        if let Some(phase) = phases.alpha_mask.get_mut(key) {
            rekey(phase, |key| &mut key.pipeline, &mut restore);
        }
        if let Some(phase) = phases.wireframe(key) {
            rekey(phase, |key| &mut key.pipeline, &mut restore);
        }
    }
}

/// Changes the pipelines of bins; a bin whose pipeline cannot be changed is emptied.
fn rekey<I: BinnedPhaseItem>(
    phase: &mut BinnedRenderPhase<I>,
    pipeline: impl Fn(&mut I::BatchSetKey) -> &mut CachedRenderPipelineId,
    vary: &mut impl FnMut(&mut CachedRenderPipelineId) -> bool,
) {
    let mut changes = |set: &I::BatchSetKey| {
        let mut varied = set.clone();
        !vary(pipeline(&mut varied)) || varied != *set
    };
    let change_multidrawable = phase.multidrawable_meshes.keys().any(&mut changes);
    let change_batchable = phase.batchable_meshes.keys().any(|(set, _)| changes(set));
    let change_unbatchable = phase.unbatchable_meshes.keys().any(|(set, _)| changes(set));
    let change_others = phase.non_mesh_items.keys().any(|(set, _)| changes(set));
    if change_multidrawable {
        rekey_bins(&mut phase.multidrawable_meshes, &pipeline, vary);
    }
    if change_batchable {
        rekey_bins(
            &mut phase.batchable_meshes,
            |key| pipeline(&mut key.0),
            vary,
        );
    }
    if change_unbatchable {
        rekey_bins(
            &mut phase.unbatchable_meshes,
            |key| pipeline(&mut key.0),
            vary,
        );
    }
    if change_others {
        rekey_bins(&mut phase.non_mesh_items, |key| pipeline(&mut key.0), vary);
    }
}

/// Keeps the order, by which batches find their bins.
fn rekey_bins<M, K, V>(
    bins: &mut M,
    pipeline: impl Fn(&mut K) -> &mut CachedRenderPipelineId,
    vary: &mut impl FnMut(&mut CachedRenderPipelineId) -> bool,
) where
    M: Default + IntoIterator<Item = (K, V)> + Extend<(K, V)>,
{
    let old = core::mem::take(bins);
    bins.extend(
        old.into_iter()
            .filter_map(|(mut key, value)| vary(pipeline(&mut key)).then_some((key, value))),
    );
}

/// Replaces the skybox pipeline of reflected views.
pub fn vary_skyboxes(
    mirrors: Res<ExtractedMirrors>,
    views: MirrorViews,
    mut skyboxes: Query<&mut SkyboxPipelineId>,
    mut variants: ResMut<StencilVariants>,
    mut cache: ResMut<PipelineCache>,
) {
    for mirror in &mirrors.views {
        if let (Ok((view, msaa)), Ok(mut skybox)) =
            (views.get(mirror.view), skyboxes.get_mut(mirror.view))
            && let Some(variant) =
                variants.variant(skybox.0, pass_format(mirror, view, msaa), &mut cache)
        {
            skybox.0 = variant;
        }
    }
}
